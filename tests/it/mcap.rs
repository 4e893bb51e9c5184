//! Guards the MCAP reader: numbers come out to the last bit, the right topic is taken, and
//! what the format allows is read. Files are built here, byte by byte, so that the reader is
//! not held against its own idea of the format.

use crate::support::data;
use latchgate::pipeline::Control;
use latchgate_kernel::units::AccelerationUnit;
use latchgate_recording::error::{Candidates, Error, ErrorKind};
use latchgate_recording::{
    Channel, Limits, ReadOptions, Recording, Selection, Source, read, read_both,
};

pub(crate) use latchgate_test_support::mcap::*;

// ---------------------------------------------------------------- reading them

pub(crate) fn source(bytes: &[u8]) -> Source {
    Source::bytes("log.mcap", bytes.to_vec())
}

pub(crate) fn options(channel: Option<&str>) -> ReadOptions {
    ReadOptions {
        channel: channel.map(String::from),
        input_format: Some("mcap".into()),
        ..ReadOptions::default()
    }
}

pub(crate) fn lateral(bytes: &[u8], options: &ReadOptions) -> Result<Recording, Error> {
    read(
        &source(bytes),
        options,
        Selection::Lateral,
        &Limits::default(),
    )
}

#[track_caller]
fn one(bytes: &[u8], options: &ReadOptions) -> Channel {
    let recording = lateral(bytes, options).unwrap();
    assert_eq!(recording.format, "mcap");
    assert_eq!(recording.channels.len(), 1);
    recording.channels.into_iter().next().unwrap()
}

/// The channel `name` holds `expected` to the last bit at 10 kHz from time 0.
#[track_caller]
fn check_read(bytes: &[u8], options: &ReadOptions, name: &str, expected: &[f64]) -> Channel {
    let channel = one(bytes, options);
    assert_eq!(channel.name, name);
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&channel.values), bits(expected));
    assert_eq!(channel.rate.hertz(), 10_000.0);
    assert_eq!(channel.start_s, 0.0);
    channel
}

#[track_caller]
fn check_finding(channel: &Channel, code: &str) {
    let codes: Vec<&str> = channel.findings.iter().map(|found| &*found.code).collect();
    assert!(codes.contains(&code), "{code} not among {codes:?}");
}

#[track_caller]
fn check_error(bytes: &[u8], options: &ReadOptions, fragment: &str) -> ErrorKind {
    let error = lateral(bytes, options).unwrap_err();
    let text = error.to_string();
    assert!(text.contains(fragment), "`{fragment}` not in `{text}`");
    error.kind().clone()
}

// ---------------------------------------------------------------- values

#[test]
fn val_imu_in_little_endian_cdr_comes_out_to_the_last_bit() {
    let expected = values(50);
    let bytes = imu::imu_recording("/imu", START, INTERVAL, &expected);
    let channel = check_read(
        &bytes,
        &options(None),
        "/imu:linear_acceleration.y",
        &expected,
    );
    assert_eq!(channel.unit, Some(AccelerationUnit::MetrePerSecondSquared));
    assert_eq!(channel.unit_source, "format");
    let codes: Vec<&str> = channel.findings.iter().map(|found| &*found.code).collect();
    assert_eq!(codes, ["channel-chosen", "time-zero-first"]);
}

/// Every frame length shifts the alignment of what follows.
#[test]
fn val_accel_stamped_in_both_byte_orders_with_every_frame_length() {
    for little in [true, false] {
        for length in 0..9 {
            let expected = values(12);
            let mut data = vec![
                schema(3, "geometry_msgs/msg/AccelStamped", "ros2msg", ACCEL_SCHEMA),
                channel(9, 3, "/accel", "cdr"),
            ];
            for (index, value) in expected.iter().enumerate() {
                let cdr = Cdr::new(little)
                    .header(stamp(index), &"f".repeat(length))
                    .f64s(&[1.0, *value, 3.0, 4.0, 5.0, 6.0])
                    .finish();
                data.push(message(9, 5, &cdr));
            }
            let bytes = file(&data, &[statistics(&[(9, 12)])]);
            check_read(&bytes, &options(None), "/accel:accel.linear.y", &expected);
        }
    }
}

#[test]
fn val_imu_in_big_endian_cdr() {
    let expected = values(12);
    let mut data = vec![imu_schema(1), channel(1, 1, "/imu", "cdr")];
    for (index, value) in expected.iter().enumerate() {
        let cdr = Cdr::new(false)
            .header(stamp(index), "")
            .f64s(&[0.0; 4 + 9 + 3 + 9])
            .f64s(&[1.0, *value, 3.0])
            .f64s(&[0.0; 9])
            .finish();
        data.push(message(1, 5, &cdr));
    }
    check_read(
        &file(&data, &[]),
        &options(Some("/imu")),
        "/imu:linear_acceleration.y",
        &expected,
    );
}

#[test]
fn val_json_numbers_are_read_to_the_last_bit() {
    // Each of these lies between two doubles such that a sloppy parser takes the wrong one.
    let texts = [
        "1.1754943508222875e-308",
        "0.1",
        "-123456.78901234567",
        "9007199254740993.0",
        "2.2250738585072011e-308",
        "17",
        "-3",
        "6.02214076e23",
    ];
    let expected: Vec<f64> = texts.iter().map(|text| text.parse().unwrap()).collect();
    let mut data = vec![channel(1, 0, "/sensor", "json")];
    for (index, text) in texts.iter().enumerate() {
        let (sec, nanosec) = (stamp(index) / 1_000_000_000, stamp(index) % 1_000_000_000);
        let json = format!(
            r#"{{"header": {{"stamp": {{"sec": {sec}, "nanosec": {nanosec}}}, "frame_id": "a"}},
                "list": [1, {{"deep": [true, null]}}], "linear_acceleration": {{"x": 1, "y": {text}}}}}"#
        );
        data.push(message(1, 5, json.as_bytes()));
    }
    let bytes = file(&data, &[statistics(&[(1, 8)])]);
    let mut options = options(None);
    assert_eq!(
        check_error(&bytes, &options, "/sensor:linear_acceleration.y"),
        ErrorKind::MissingUnit
    );
    options.unit = Some(AccelerationUnit::StandardGravity);
    let channel = check_read(&bytes, &options, "/sensor:linear_acceleration.y", &expected);
    assert_eq!(channel.unit, Some(AccelerationUnit::StandardGravity));
    assert_eq!(channel.unit_source, "option");

    options.channel = Some("/sensor:list[0]".into());
    check_read(&bytes, &options, "/sensor:list[0]", &[1.0; 8]);
    options.channel = Some("/sensor:list[1].depp".into());
    let wrong = check_error(&bytes, &options, "/sensor:linear_acceleration.x");
    assert!(matches!(wrong, ErrorKind::NoSuchChannel { .. }));
}

/// Types of this message sit at odd places: strings, bounded and open sequences, arrays of
/// messages, constants, defaults, an empty type.
#[test]
fn val_fields_are_found_behind_strings_sequences_and_nested_types() {
    let definition = "\
# a comment
uint8 KIND=3
string NAME = \"x # y\"
string<=5 label
bool flag
Empty nothing
int16[] levels
my_msgs/msg/Part[<=4] parts
Part[2] pair
float32[3] triple 1.0 2.0 3.0 # with defaults
char last
================================================================================
MSG: my_msgs/Part
string[] names
float64 value
================================================================================
MSG: my_msgs/Empty
";
    let message_of = |little: bool, offset: f64| {
        let part = |cdr: Cdr, names: &[&str], value: f64| {
            let cdr = cdr.u32(names.len() as u32);
            names
                .iter()
                .fold(cdr, |cdr, name| cdr.text(name))
                .f64(value)
        };
        let mut cdr = Cdr::new(little).text("abc").u8(1).u8(0).u32(3);
        cdr = cdr.i16(1).i16(-2).i16(3).u32(2);
        cdr = part(cdr, &["a", "bcdef"], offset + 10.0);
        cdr = part(cdr, &[], offset + 11.0);
        cdr = part(cdr, &["x"], offset + 12.0);
        cdr = part(cdr, &[], offset + 13.0);
        cdr.f32(0.5).f32(1.5).f32(2.5).u8(200).finish()
    };
    let expectations = [
        ("levels[1]", vec![-2.0; 3]),
        ("parts[0].value", vec![10.0, 11.0, 12.0]),
        ("parts[1].value", vec![11.0, 12.0, 13.0]),
        ("pair[0].value", vec![12.0, 13.0, 14.0]),
        ("pair[1].value", vec![13.0, 14.0, 15.0]),
        ("triple[2]", vec![2.5; 3]),
        ("last", vec![200.0; 3]),
    ];
    for little in [true, false] {
        let mut data = vec![
            schema(1, "my_msgs/msg/Odd", "ros2msg", definition),
            channel(1, 1, "/odd", "cdr"),
        ];
        for index in 0..3 {
            let cdr = message_of(little, index as f64);
            data.push(message(1, stamp(index), &cdr));
        }
        let bytes = file(&data, &[statistics(&[(1, 3)])]);
        for (path, expected) in &expectations {
            let name = format!("/odd:{path}");
            let mut options = options(Some(&name));
            options.unit = Some(AccelerationUnit::StandardGravity);
            let channel = check_read(&bytes, &options, &name, expected);
            check_finding(&channel, "log-time");
        }
        for path in [
            "label",
            "flag",
            "pair.value",
            "pair[2].value",
            "KIND",
            "counts",
        ] {
            let name = format!("/odd:{path}");
            let kind = check_error(&bytes, &options(Some(&name)), "/odd:pair[0..1].value");
            assert!(matches!(kind, ErrorKind::NoSuchChannel { .. }));
        }
        let kind = check_error(
            &bytes,
            &options(Some("/odd:parts[2].value")),
            "a value of parts[2].value",
        );
        assert!(matches!(kind, ErrorKind::Malformed { .. }));
    }
}

#[test]
fn val_chunks_uncompressed_zstd_and_lz4_give_the_same_samples() {
    let expected = values(300);
    for compression in ["", "zstd", "lz4"] {
        let messages = imu_messages(300);
        let mut data = Vec::new();
        for part in messages.chunks(100) {
            // Definitions are repeated in each chunk, as some writers do.
            let definitions = [imu_schema(1), channel(1, 1, "/imu", "cdr")].concat();
            data.push(packed(compression, &[definitions, part.concat()].concat()));
        }
        let bytes = file(&data, &[statistics(&[(1, 300)])]);
        check_read(
            &bytes,
            &options(None),
            "/imu:linear_acceleration.y",
            &expected,
        );
    }
}

#[test]
fn val_stamps_that_are_all_zero_give_way_to_the_time_of_logging() {
    let expected = values(20);
    let mut data = vec![imu_schema(1), channel(1, 1, "/imu", "cdr")];
    for (index, value) in expected.iter().enumerate() {
        let cdr = imu::imu_message_cdr(0, "", [0.0, *value, 0.0]);
        data.push(message(1, stamp(index), &cdr));
    }
    let bytes = file(&data, &[statistics(&[(1, 20)])]);
    let channel = check_read(
        &bytes,
        &options(None),
        "/imu:linear_acceleration.y",
        &expected,
    );
    check_finding(&channel, "stamp-zero");
}

/// A clock that starts at 0, as in a simulation, is a clock.
#[test]
fn val_a_clock_that_starts_at_zero_is_kept() {
    let expected = values(20);
    let bytes = imu::imu_recording("/imu", 0, INTERVAL, &expected);
    let channel = check_read(
        &bytes,
        &options(None),
        "/imu:linear_acceleration.y",
        &expected,
    );
    assert!(
        !channel
            .findings
            .iter()
            .any(|found| found.code == "stamp-zero")
    );
}

#[test]
fn val_time_zero_is_an_instant_on_the_clock_of_the_file() {
    let mut options = options(None);
    let bytes = imu::imu_recording("/imu", 5_000_000_000, INTERVAL, &values(200));
    options.time_zero_s = Some(5.01);
    let channel = one(&bytes, &options);
    assert!(
        (channel.start_s + 0.01).abs() < 1e-12,
        "{}",
        channel.start_s
    );
    // As times are shown, from the first message on.
    options.time_zero_s = Some(0.01);
    let shown = one(&bytes, &options);
    assert!((shown.start_s + 0.01).abs() < 1e-12, "{}", shown.start_s);
    check_finding(&shown, "time-zero-outside");
    // A little before the log began, and on the clock of another day.
    options.time_zero_s = Some(4.995);
    check_finding(&one(&bytes, &options), "time-zero-outside");
    options.time_zero_s = Some(1.7e9);
    check_error(&bytes, &options, "must lie between 5 and 5.0199 s");
}

// ---------------------------------------------------------------- which channel

#[test]
fn val_another_axis_and_another_unit_can_be_asked_for() {
    let bytes = imu::imu_recording("/imu", START, INTERVAL, &values(9));
    let mut options = options(Some("/imu:linear_acceleration.z"));
    check_read(
        &bytes,
        &options,
        "/imu:linear_acceleration.z",
        &[9.806_65; 9],
    );
    options.unit = Some(AccelerationUnit::StandardGravity);
    let channel = one(&bytes, &options);
    assert_eq!(channel.unit, options.unit);
    check_finding(&channel, "unit-overridden");
    options.unit = None;
    options.channel = Some("/imu:angular_velocity.y".into());
    assert_eq!(
        check_error(&bytes, &options, "unit"),
        ErrorKind::MissingUnit
    );
}

fn two_topics(messages_on_second: usize) -> Vec<u8> {
    let mut data = imu_data(4);
    data.push(channel(2, 1, "/imu2", "cdr"));
    let second = imu_messages(messages_on_second);
    data.extend(second.into_iter().map(|mut record| {
        record[9] = 2;
        record
    }));
    let counts = [(1, 4), (2, messages_on_second as u64)];
    file(&data, &[statistics(&counts)])
}

#[test]
fn val_two_candidates_are_listed_and_none_is_taken() {
    let bytes = two_topics(3);
    let kind = check_error(&bytes, &options(None), "`channel`");
    assert_eq!(
        kind,
        ErrorKind::AmbiguousChannel {
            candidates: Candidates::named([
                "/imu:linear_acceleration.y",
                "/imu2:linear_acceleration.y"
            ])
        }
    );
    assert_eq!(one(&bytes, &options(Some("/imu2"))).values, values(3));
    // A topic without messages is no candidate, but cannot be read either.
    let bytes = two_topics(0);
    assert_eq!(one(&bytes, &options(None)).values, values(4));
    let kind = check_error(&bytes, &options(Some("/imu2")), "no message");
    assert!(matches!(kind, ErrorKind::Empty { .. }));
}

#[test]
fn val_wrong_names_list_what_there_is() {
    let bytes = imu::imu_recording("/imu", START, INTERVAL, &values(9));
    for name in [
        "/imu:linear_acceleration.q",
        "/imu:",
        "/imu:linear_acceleration",
    ] {
        let kind = check_error(&bytes, &options(Some(name)), "/imu:linear_acceleration.y");
        assert!(matches!(kind, ErrorKind::NoSuchChannel { .. }), "{name}");
    }
    let known = "/imu (sensor_msgs/msg/Imu, cdr)";
    let kind = check_error(&bytes, &options(Some("/imus:linear_acceleration.y")), known);
    assert!(matches!(kind, ErrorKind::NoSuchChannel { .. }));
}

#[test]
fn val_inspection_delivers_every_number_of_an_imu() {
    let mut data = imu_data(6);
    data.push(channel(2, 0, "/notes", "text"));
    data.push(message(2, 1, b"hello"));
    let bytes = file(&data, &[statistics(&[(1, 6), (2, 1)])]);
    let limits = Limits::default();
    let found = read(&source(&bytes), &options(None), Selection::Every, &limits).unwrap();
    let names: Vec<(&str, bool)> = found
        .channels
        .iter()
        .map(|channel| (channel.name.as_str(), channel.unit.is_some()))
        .collect();
    let expected = [
        ("/imu:orientation.x", false),
        ("/imu:orientation.y", false),
        ("/imu:orientation.z", false),
        ("/imu:orientation.w", false),
        ("/imu:angular_velocity.x", false),
        ("/imu:angular_velocity.y", false),
        ("/imu:angular_velocity.z", false),
        ("/imu:linear_acceleration.x", true),
        ("/imu:linear_acceleration.y", true),
        ("/imu:linear_acceleration.z", true),
    ];
    assert_eq!(names, expected);
    assert_eq!(found.channels[8].values, values(6));
    let left_out = found.findings.iter().find(|f| f.code == "topics-left-out");
    assert!(left_out.unwrap().text.contains("/notes (no schema, text)"));
}

// ---------------------------------------------------------------- what the format allows

#[test]
fn val_what_the_format_allows_is_read() {
    let longer = |mut record: Vec<u8>| {
        // Bytes after the known fields: a later version of the format may put some there.
        record.extend(b"later");
        let length = record.len() as u64 - 9;
        record[1..9].copy_from_slice(&length.to_le_bytes());
        record
    };
    let mut data = vec![
        record(0x42, b"unknown"),
        longer(imu_schema(1)),
        imu_schema(1),
        longer(channel(1, 1, "/imu", "cdr")),
        channel(1, 1, "/imu", "cdr"),
        channel(2, 0, "/silent", "text"),
        record(0x09, b"an attachment is not looked into"),
        packed("", &[]),
    ];
    let messages = imu_messages(10);
    let split = record(0x99, b"private");
    data.push(longer(packed(
        "zstd",
        &[split, messages[..5].concat()].concat(),
    )));
    data.extend_from_slice(&messages[5..]);
    let summary = [
        longer(statistics(&[(1, 10), (2, 0)])),
        imu_schema(1),
        channel(1, 1, "/imu", "cdr"),
        record(0x43, b"unknown"),
    ];
    let expected = values(10);
    let name = "/imu:linear_acceleration.y";
    check_read(&file(&data, &summary), &options(None), name, &expected);
}

/// What a person wrote of a topic or of the whole log; settings of programs stand there as well.
#[test]
fn val_comments_in_metadata_are_remarks() {
    let map = |entries: &[(&str, &str)]| {
        let pairs = entries
            .iter()
            .flat_map(|(key, value)| [text(key), text(value)]);
        let pairs: Vec<u8> = pairs.flatten().collect();
        [(pairs.len() as u32).to_le_bytes().to_vec(), pairs].concat()
    };
    let of_channel = |entries: &[(&str, &str)]| {
        let ids = [1_u16.to_le_bytes(), 1_u16.to_le_bytes()].concat();
        record(
            0x04,
            &[ids, text("/imu"), text("cdr"), map(entries)].concat(),
        )
    };
    let of_file =
        |entries: &[(&str, &str)]| record(0x0C, &[text("rosbag2"), map(entries)].concat());
    let mut data = imu_data(10);
    data[1] = of_channel(&[("qos", "depth: lost"), ("comment", "cable was loose")]);
    data.push(of_file(&[
        ("ROS_DISTRO", "failed"),
        ("description", "left door"),
    ]));
    data.push(record(0x0C, b"damaged"));
    let found = lateral(&file(&data, &[statistics(&[(1, 10)])]), &options(None)).unwrap();
    let own = &found.channels[0];
    assert_eq!(own.stated.remarks, ["cable was loose"]);
    let told = |findings: &[latchgate_recording::Finding]| -> Vec<String> {
        let remarks = findings
            .iter()
            .filter(|one| one.code == "laboratory-remark");
        remarks
            .map(|one| format!("{} {}", one.severity.name(), one.text))
            .collect()
    };
    assert!(told(&own.findings)[0].starts_with("blocking"), "{own:?}");
    let of_file = told(&found.findings);
    assert_eq!(of_file.len(), 2, "{of_file:?}");
    assert!(of_file[0].starts_with("info") && of_file[0].contains("left door"));
    // What stands in metadata that cannot be read may be of the sensor; a person is asked.
    assert!(of_file[1].starts_with("blocking"), "{of_file:?}");
    assert!(
        of_file[1].contains("a record that cannot be read"),
        "{of_file:?}"
    );
}

#[test]
fn val_a_file_that_says_nothing_of_itself_is_read_with_a_warning() {
    let found = lateral(&file(&imu_data(5), &[]), &options(None)).unwrap();
    let codes: Vec<&str> = found.findings.iter().map(|found| &*found.code).collect();
    assert_eq!(codes, ["mcap-unverified"]);
    let vouched = file(&imu_data(5), &[statistics(&[(1, 5)])]);
    assert_eq!(lateral(&vouched, &options(None)).unwrap().findings, []);
}

/// Neighbours that take more than `samples` lets in are left out, and the channel that is meant is
/// read all the same; beyond what it takes alone nothing is.
#[test]
fn verif_neighbours_over_the_limit_do_not_take_the_channel_along() {
    let bytes = file(&imu_data(100), &[statistics(&[(1, 100)])]);
    let within = |samples: u64| {
        let limits = Limits {
            samples,
            ..Limits::default()
        };
        let control = Control::default();
        read_both(&source(&bytes), &options(None), &limits, &control)
    };
    let is_over = |result: Result<Recording, Error>| {
        let kind = result.unwrap_err().kind().clone();
        assert!(
            matches!(kind, ErrorKind::LimitExceeded { limit, .. } if limit == "samples"),
            "{kind}"
        );
    };
    let whole = within(1000);
    assert!(whole.every.unwrap().channels.len() > 3);
    let reduced = within(200);
    assert_eq!(reduced.chosen.unwrap(), whole.chosen.unwrap());
    is_over(reduced.every);
    let none = within(50);
    is_over(none.chosen);
    is_over(none.every);
}

// ---------------------------------------------------------------- real logs

#[test]
fn val_real_logs_without_acceleration_or_cut_are_refused() {
    for (name, fragment) in [
        (
            "mcapcrate_compressed.ros1.mcap",
            "/diagnostics (diagnostic_msgs/DiagnosticArray, ros1)",
        ),
        ("mcapcrate_chunk_not_closed.mcap", "byte 39"),
    ] {
        let source = Source::File(data(&format!("recordings/{name}")));
        let limits = Limits::default();
        let error = read(&source, &options(None), Selection::Lateral, &limits).unwrap_err();
        assert!(error.to_string().contains(fragment), "{error}");
    }
}
