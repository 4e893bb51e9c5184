//! Guards against damaged, cut and contradictory MCAP files: each ends in its message, none
//! in a panic, an abort or a recording with other samples than were written.

use crate::mcap::*;
use crate::support::Random;
use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::error::{Candidates, ErrorKind};
use latchgate_recording::{Limits, ReadOptions, Selection, read};
use std::mem::{Discriminant, discriminant};

fn kinds() -> [Discriminant<ErrorKind>; 4] {
    let text = String::new;
    [
        discriminant(&ErrorKind::Truncated {
            expected: text(),
            found: text(),
        }),
        discriminant(&ErrorKind::Malformed {
            expected: text(),
            found: text(),
            hint: text(),
        }),
        discriminant(&ErrorKind::LimitExceeded {
            limit: "",
            value: 0,
            found: text(),
        }),
        discriminant(&ErrorKind::Kernel(KernelError::NonFinite { found: text() })),
    ]
}

const TRUNCATED: usize = 0;
const MALFORMED: usize = 1;
const LIMIT: usize = 2;
const NON_FINITE: usize = 3;

/// The file is refused with an error of this kind whose message holds `fragment`, both when
/// one channel is read and, but for faults of one topic alone, when all are.
#[track_caller]
fn check_refused(what: &str, bytes: &[u8], kind: usize, fragment: &str) {
    check_refused_with(what, bytes, &options(None), kind, fragment);
}

#[track_caller]
fn check_refused_with(
    what: &str,
    bytes: &[u8],
    options: &ReadOptions,
    kind: usize,
    fragment: &str,
) {
    let error = match lateral(bytes, options) {
        Ok(found) => panic!("{what}: read, with {} channels", found.channels.len()),
        Err(error) => error,
    };
    let text = error.to_string();
    assert!(
        text.contains(fragment),
        "{what}: `{fragment}` not in `{text}`"
    );
    assert!(text.starts_with("log.mcap"), "{what}: no file in `{text}`");
    assert_eq!(discriminant(error.kind()), kinds()[kind], "{what}: {text}");
}

fn good() -> Vec<u8> {
    file(&imu_data(6), &[statistics(&[(1, 6)])])
}

fn with(extra: &[Vec<u8>]) -> Vec<u8> {
    let data = [imu_data(6), extra.to_vec()].concat();
    file(&data, &[statistics(&[(1, 6)])])
}

#[test]
fn val_files_that_are_cut_or_contradict_themselves_are_refused() {
    let good = good();
    let end = good.len();
    let mut cases: Vec<(&str, Vec<u8>, usize, &str)> = Vec::new();
    let mut add = |what, bytes, kind, fragment| cases.push((what, bytes, kind, fragment));

    add(
        "cut in a message",
        good[..3000].to_vec(),
        TRUNCATED,
        "the end of the file after",
    );
    add(
        "cut before the footer",
        good[..end - 37].to_vec(),
        TRUNCATED,
        "footer",
    );
    add(
        "cut in the end magic",
        good[..end - 3].to_vec(),
        TRUNCATED,
        "end magic",
    );
    add(
        "without end magic",
        good[..end - 8].to_vec(),
        TRUNCATED,
        "end magic",
    );
    let zeroed = [&good[..end - 8], &[0; 8][..]].concat();
    add("end magic zeroed", zeroed, TRUNCATED, "end magic");
    let twice = [&good[..], &good[end / 2..]].concat();
    add("tail of an older log", twice, TRUNCATED, "older, longer");
    add(
        "one byte more",
        [&good[..], b"\n"].concat(),
        TRUNCATED,
        "more bytes",
    );
    add("only magic", MAGIC.to_vec(), TRUNCATED, "0 messages");
    let short = file(&imu_data(5), &[statistics(&[(1, 6)])]);
    add(
        "a message lost",
        short,
        TRUNCATED,
        "6 messages, as the statistics say",
    );
    let longer = file(&imu_data(7), &[statistics(&[(1, 6)])]);
    add("a message too many", longer, TRUNCATED, "found 7");
    let moved = file(&two_channels(), &[statistics(&[(1, 3), (2, 3)])]);
    add("a message moved", moved, TRUNCATED, "messages of channel 1");
    let no_end = [MAGIC, &header(), &imu_data(6).concat(), &footer(0), MAGIC];
    add(
        "no end of data",
        no_end.concat(),
        TRUNCATED,
        "end of the data",
    );
    let body = [MAGIC, &header(), &imu_data(6).concat(), &data_end(0)].concat();
    let astray = [&body[..], &footer(77), MAGIC].concat();
    add("a footer that points astray", astray, TRUNCATED, "byte 77");
    let mut unclosed = [MAGIC, &header()].concat();
    unclosed.push(6);
    unclosed.extend([0xFF; 60]);
    add("a chunk never closed", unclosed, TRUNCATED, "all ones");
    let chunk_index = |start: u64| {
        let mut body = vec![0; 16];
        body.extend(start.to_le_bytes());
        body.extend([0; 48]);
        record(0x08, &body)
    };
    let summary = [statistics(&[(1, 6)]), chunk_index(100)];
    let lost = file(&imu_data(6), &summary);
    add(
        "a chunk lost",
        lost,
        TRUNCATED,
        "1 chunks of the chunk index",
    );

    let records = imu_data(6).concat();
    let in_chunk = |chunk: Vec<u8>| file(&[chunk], &[statistics(&[(1, 6)])]);
    let size = records.len() as u64;
    let crc = crc32(&records);
    let wrong = in_chunk(chunk("", size, crc ^ 1, &records));
    add("a wrong chunk checksum", wrong, MALFORMED, "checksum");
    let less = in_chunk(chunk("", size + 4, 0, &records));
    add(
        "a chunk shorter than it says",
        less,
        TRUNCATED,
        "as its header says",
    );
    let more = in_chunk(chunk("", size - 4, 0, &records));
    add(
        "a chunk longer than it says",
        more,
        MALFORMED,
        "as its header says",
    );
    let cut = in_chunk(chunk("", size - 4, 0, &records[..records.len() - 4]));
    add(
        "a chunk cut in a record",
        cut,
        MALFORMED,
        "more bytes in the chunk record",
    );
    let packed_short = &lz4(&records)[..200];
    let cut = in_chunk(chunk("lz4", size, crc, packed_short));
    add("an lz4 chunk cut", cut, MALFORMED, "lz4");
    let garbage = in_chunk(chunk("zstd", size, crc, &[7; 100]));
    add("a zstd chunk of garbage", garbage, MALFORMED, "zstd");
    let unknown = in_chunk(chunk("brotli", size, crc, &records));
    add("an unknown compression", unknown, MALFORMED, "`brotli`");
    let nested = in_chunk(packed("", &packed("", &records)));
    add("a chunk in a chunk", nested, MALFORMED, "in a chunk");
    let mut all_ones = chunk("", size, crc, &records);
    for byte in &mut all_ones[25..33] {
        *byte = 0xFF;
    }
    add(
        "a chunk of endless size",
        in_chunk(all_ones),
        LIMIT,
        "mcap_chunk_bytes",
    );

    let mut magic = good.clone();
    magic[6] = b'\n';
    add("no magic", magic, MALFORMED, "magic at the start");
    let headless = [
        MAGIC,
        &imu_data(6).concat(),
        &data_end(0),
        &footer(0),
        MAGIC,
    ];
    add(
        "no header",
        headless.concat(),
        MALFORMED,
        "header as the first",
    );
    add("two headers", with(&[header()]), MALFORMED, "one header");
    add(
        "two ends of data",
        with(&[data_end(0)]),
        MALFORMED,
        "one end of the data",
    );
    let body = [MAGIC, &header(), &imu_data(6).concat()].concat();
    let crc = data_end(crc32(&body) ^ 0x10);
    let wrong = [&body[..], &crc, &footer(0), MAGIC].concat();
    add("a wrong data checksum", wrong, MALFORMED, "checksum");
    let late = file(&imu_data(6), &[imu_messages(1).concat()]);
    add(
        "a message after the data",
        late,
        MALFORMED,
        "only a summary",
    );
    let early = with(&[statistics(&[(1, 6)])]);
    add(
        "statistics before the end",
        early,
        MALFORMED,
        "statistics after",
    );
    let stranger = with(&[message(4, 1, b"")]);
    add("a message of no channel", stranger, MALFORMED, "channel 4");
    let orphan = with(&[channel(5, 8, "/orphan", "cdr")]);
    add("a channel of no schema", orphan, MALFORMED, "schema 8");
    let zero = with(&[schema(0, "a", "b", "c")]);
    add("a schema of id 0", zero, MALFORMED, "schema id");
    let other = with(&[schema(1, "sensor_msgs/msg/Imu", "ros2msg", "float64 x")]);
    add("a schema redefined", other, MALFORMED, "schema 1");
    let other = with(&[channel(1, 1, "/other", "cdr")]);
    add("a channel redefined", other, MALFORMED, "channel 1");
    let mut huge = imu_schema(2);
    huge[11..15].copy_from_slice(&[0xFF; 4]);
    add("a name of 4 GiB", with(&[huge]), MALFORMED, "schema record");
    let mut map = channel(3, 1, "/imu3", "cdr");
    let length = map.len();
    map[length - 4] = 200;
    add(
        "a map beyond its record",
        with(&[map]),
        MALFORMED,
        "channel record",
    );
    let mut latin = channel(3, 1, "/imu3", "cdr");
    latin[18] = 0xE9;
    add("a topic not in UTF-8", with(&[latin]), MALFORMED, "utf-8");
    add(
        "a short message record",
        with(&[record(5, &[1, 0])]),
        MALFORMED,
        "message record",
    );
    let mut long = good.clone();
    let at = MAGIC.len() + header().len() + 1;
    long[at..at + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    add("a record of a tebibyte", long, LIMIT, "mcap_record_bytes");

    assert!(cases.len() >= 40);
    for (what, bytes, kind, fragment) in &cases {
        check_refused(what, bytes, *kind, fragment);
        let every = read(
            &source(bytes),
            &options(None),
            Selection::Every,
            &Limits::default(),
        );
        assert!(every.is_err(), "{what}: inspected as if it were whole");
    }
}

fn two_channels() -> Vec<Vec<u8>> {
    let mut data = imu_data(4);
    data.push(channel(2, 1, "/imu2", "cdr"));
    data.extend(imu_messages(2).into_iter().map(|mut record| {
        record[9] = 2;
        record
    }));
    data
}

/// Files whose framing is whole, but whose one topic cannot carry an answer.
#[test]
fn val_messages_that_cannot_be_read_are_refused() {
    let topic = |encoding: &str, schema_encoding: &str, schema_text: &str, messages: &[Vec<u8>]| {
        let mut data = vec![
            schema(1, imu::IMU_SCHEMA_NAME, schema_encoding, schema_text),
            channel(1, 1, "/imu", encoding),
        ];
        for (index, bytes) in messages.iter().enumerate() {
            data.push(message(1, stamp(index), bytes));
        }
        file(&data, &[statistics(&[(1, messages.len() as u64)])])
    };
    let imu_of =
        |index: usize, value: f64| imu::imu_message_cdr(stamp(index), "imu", [0.0, value, 0.0]);
    let cdr = |messages: &[Vec<u8>]| topic("cdr", "ros2msg", imu::IMU_SCHEMA, messages);
    let one = [imu_of(0, 1.0)];
    let schema_of = |text: &str| topic("cdr", "ros2msg", text, &one);
    let mut cases: Vec<(&str, Vec<u8>, usize, &str)> = Vec::new();
    let mut add = |what, bytes, kind, fragment| cases.push((what, bytes, kind, fragment));

    add(
        "cdr called ros1",
        topic("ros1", "ros1msg", imu::IMU_SCHEMA, &one),
        LIMIT,
        "message 1",
    );
    add(
        "ros1 with a schema of ROS 2",
        topic("ros1", "ros2msg", imu::IMU_SCHEMA, &one),
        MALFORMED,
        "ros1msg",
    );
    add(
        "protobuf without a descriptor",
        topic("protobuf", "protobuf", "", &one),
        MALFORMED,
        "a definition of",
    );
    add(
        "a protobuf descriptor of other bytes",
        topic("protobuf", "protobuf", "float64 x", &one),
        MALFORMED,
        "protobuf fields",
    );
    add("cbor", topic("cbor", "", "", &one), MALFORMED, "`cbor`");
    add(
        "an IDL schema",
        topic("cdr", "ros2idl", "", &one),
        MALFORMED,
        "`ros2idl`",
    );
    let nan = cdr(&[imu_of(0, 1.0), imu_of(1, f64::NAN)]);
    add(
        "NaN",
        nan,
        NON_FINITE,
        "/imu:linear_acceleration.y, message 2",
    );
    let infinite = cdr(&[imu_of(0, f64::NEG_INFINITY)]);
    add("infinity", infinite, NON_FINITE, "-inf");
    let mut short = imu_of(1, 1.0);
    short.truncate(250);
    add(
        "a short message",
        cdr(&[imu_of(0, 1.0), short]),
        MALFORMED,
        "message 2",
    );
    let mut long = imu_of(0, 1.0);
    long.extend([0; 8]);
    add("a long message", cdr(&[long]), MALFORMED, "8 bytes more");
    add(
        "an empty message",
        cdr(&[Vec::new()]),
        MALFORMED,
        "CDR header",
    );
    let mut parameters = imu_of(0, 1.0);
    parameters[1] = 3;
    add("a parameter list", cdr(&[parameters]), MALFORMED, "00 03");
    let mut frame = imu_of(0, 1.0);
    frame[12..16].copy_from_slice(&[0xFF; 4]);
    add(
        "a frame name of 4 GiB",
        cdr(&[frame]),
        LIMIT,
        "a string of 4294967295 bytes in a message",
    );
    let mut nanoseconds = imu_of(0, 1.0);
    nanoseconds[8..12].copy_from_slice(&1_000_000_000_u32.to_le_bytes());
    add(
        "10^9 ns",
        cdr(&[nanoseconds]),
        MALFORMED,
        "channel /imu, message 1: expected a stamp of whole seconds",
    );

    let recursive = "Imu again\nfloat64 x";
    add(
        "a type in itself",
        schema_of(recursive),
        MALFORMED,
        "nested",
    );
    let missing = imu::IMU_SCHEMA.replace("MSG: geometry_msgs/Q", "MSG: geometry_msgs/q");
    add(
        "a type left out",
        schema_of(&missing),
        MALFORMED,
        "geometry_msgs/Quaternion",
    );
    let twice = imu::IMU_SCHEMA.replace("float64 x\nfloat64 y", "float64 y\nfloat64 y");
    add("a field twice", schema_of(&twice), MALFORMED, "`y` twice");
    let wide = imu::IMU_SCHEMA.replace("string frame_id", "wstring frame_id");
    add("a wide string", schema_of(&wide), MALFORMED, "wide string");
    let bad = imu::IMU_SCHEMA.replace("float64[9] or", "float64[nine] or");
    add(
        "an array of no size",
        schema_of(&bad),
        MALFORMED,
        "type name",
    );
    let heading = imu::IMU_SCHEMA.replace("MSG: std", "IDL: std");
    add("another divider", schema_of(&heading), MALFORMED, "MSG:");
    let mut swollen = String::from("std_msgs/Header header\n");
    let mut parts = String::new();
    for depth in 0..25 {
        swollen.push_str(if depth == 0 { "a/T0 l\n" } else { "" });
        let next = depth + 1;
        parts.push_str(&format!("{}\nMSG: a/T{depth}\n", "=".repeat(80)));
        parts.push_str(&format!("T{next} a\nT{next} b\n"));
    }
    parts.push_str(&format!("{}\nMSG: a/T25\nfloat64 x\n", "=".repeat(80)));
    swollen.push_str("geometry_msgs/Vector3 linear_acceleration\n");
    swollen.push_str(&parts);
    let tail = imu::IMU_SCHEMA.split_once(&"=".repeat(80)).unwrap().1;
    swollen.push_str(&format!("{}{tail}", "=".repeat(80)));
    add(
        "types that multiply",
        schema_of(&swollen),
        MALFORMED,
        "at most 4096 numbers",
    );

    for (what, bytes, kind, fragment) in &cases {
        check_refused(what, bytes, *kind, fragment);
    }
}

#[test]
fn val_json_that_cannot_be_read_is_refused() {
    let json = |messages: &[&str]| {
        let mut data = vec![channel(1, 0, "/sensor", "json")];
        for (index, text) in messages.iter().enumerate() {
            data.push(message(1, stamp(index), text.as_bytes()));
        }
        file(&data, &[statistics(&[(1, messages.len() as u64)])])
    };
    let good = r#"{"accel": {"linear": {"y": 1.5}}}"#;
    let deep = format!("{}1{}", "[".repeat(5000), "]".repeat(5000));
    for (what, second, kind, fragment) in [
        ("cut", r#"{"accel": {"linear""#, MALFORMED, "EOF"),
        (
            "null",
            r#"{"accel": {"linear": {"y": null}}}"#,
            NON_FINITE,
            "null",
        ),
        (
            "text",
            r#"{"accel": {"linear": {"y": "broken"}}}"#,
            NON_FINITE,
            "a text in accel",
        ),
        (
            "number in quotes",
            r#"{"accel": {"linear": {"y": "1.5"}}}"#,
            NON_FINITE,
            "a number written as a text",
        ),
        (
            "absent",
            r#"{"accel": {"linear": {"x": 1.5}}}"#,
            MALFORMED,
            "accel.linear.y",
        ),
        (
            "twice",
            r#"{"accel": {"linear": {"y": 1, "y": 2}}}"#,
            MALFORMED,
            "twice",
        ),
        (
            "more",
            r#"{"accel": {"linear": {"y": 1}}} {}"#,
            MALFORMED,
            "trailing",
        ),
        (
            "large",
            r#"{"accel": {"linear": {"y": 1e999}}}"#,
            MALFORMED,
            "range",
        ),
        ("deep", deep.as_str(), MALFORMED, "recursion"),
    ] {
        check_refused(what, &json(&[good, second]), kind, fragment);
    }
    let stamped = |sec: &str| {
        let stamp = format!(r#""header": {{"stamp": {{"sec": {sec}, "nanosec": 0}}}}"#);
        format!(r#"{{{stamp}, "accel": {{"linear": {{"y": 1.5}}}}}}"#)
    };
    let fraction = json(&[&stamped("1.5"), &stamped("2")]);
    check_refused("half a second", &fraction, MALFORMED, "whole seconds");
    let broken = json(&["no JSON at all"]);
    check_refused("no JSON", &broken, MALFORMED, "/sensor");
    let both = r#"{"accel": {"linear": {"y": 1}}, "linear_acceleration": {"y": 2}}"#;
    let error = lateral(&json(&[both]), &options(None)).unwrap_err();
    let names = ["/sensor:accel.linear.y", "/sensor:linear_acceleration.y"];
    let candidates = Candidates::named(names);
    assert_eq!(error.kind(), &ErrorKind::AmbiguousChannel { candidates });
    // Beside a topic that can be meant, one that is no JSON does not matter.
    let data = [
        imu_data(3),
        vec![channel(2, 0, "/sensor", "json"), message(2, 1, b"nothing")],
    ];
    let bytes = file(&data.concat(), &[statistics(&[(1, 3), (2, 1)])]);
    let found = lateral(&bytes, &options(None)).unwrap();
    assert_eq!(found.channels[0].name, "/imu:linear_acceleration.y");
    // Where it might be meant, it says itself what is wrong with it.
    let named = options(Some("/sensor"));
    let error = lateral(&bytes, &named).unwrap_err();
    assert!(error.to_string().contains("JSON"), "{error}");
}

#[test]
fn val_stamps_that_repeat_or_go_back_are_refused() {
    for stamps in [[0, 1, 1, 2], [0, 2, 1, 3], [0, 0, 1, 2]] {
        let mut data = vec![imu_schema(1), channel(1, 1, "/imu", "cdr")];
        for (index, step) in stamps.iter().enumerate() {
            let cdr = imu::imu_message_cdr(step * 1_000_000, "", [0.0, 1.0, 0.0]);
            data.push(message(1, stamp(index), &cdr));
        }
        let bytes = file(&data, &[statistics(&[(1, 4)])]);
        let error = lateral(&bytes, &options(None)).unwrap_err();
        let number = if stamps[1] == 0 { 2 } else { 3 };
        let text = error.to_string();
        assert!(
            text.contains(&format!("/imu, message {number}: ")),
            "{text}"
        );
        // What stands still or goes back in the messages does not in the log.
        let way_out = "the time of logging is sound: state the setting `time_source` = log";
        assert!(text.contains(way_out), "{text}");
        assert!(!text.contains("row") && !text.contains("rate_hz"), "{text}");
    }
}

#[test]
fn val_chunks_that_swell_are_stopped() {
    let limits = Limits {
        mcap_chunk_bytes: 1 << 20,
        ..Limits::default()
    };
    let zeros = vec![0; 4 << 20];
    let level = ruzstd::encoding::CompressionLevel::Fastest;
    let zstd = ruzstd::encoding::compress_to_vec(&zeros[..], level);
    // Blocks of one repeated byte: 4 bytes become 128 KiB, 4000 of them half a gibibyte.
    let mut swelling = vec![0x28, 0xB5, 0x2F, 0xFD, 0x00, 0x58];
    for _ in 0..4000 {
        swelling.extend([0x02, 0x00, 0x10, 0x00]);
    }
    for (compression, data) in [("zstd", zstd), ("zstd", swelling), ("lz4", lz4(&zeros))] {
        for (size, kind, fragment) in [
            (4 << 20, LIMIT, "mcap_chunk_bytes"),
            (1 << 20, MALFORMED, "chunk"),
            (1000, MALFORMED, "chunk"),
        ] {
            let bytes = file(&[chunk(compression, size, 0, &data)], &[]);
            let selection = Selection::Lateral;
            let error = read(&source(&bytes), &options(None), selection, &limits).unwrap_err();
            assert_eq!(discriminant(error.kind()), kinds()[kind], "{error}");
            assert!(error.to_string().contains(fragment), "{error}");
        }
    }
}

#[test]
fn val_limits_on_samples_topics_and_records_hold() {
    let refused = |limits: Limits, fragment: &str| {
        let bytes = file(&two_channels(), &[]);
        let error = read(&source(&bytes), &options(None), Selection::Every, &limits).unwrap_err();
        assert_eq!(discriminant(error.kind()), kinds()[LIMIT], "{error}");
        assert!(error.to_string().contains(fragment), "{error}");
    };
    let usual = Limits::default;
    refused(
        Limits {
            samples: 3,
            ..usual()
        },
        "samples",
    );
    refused(
        Limits {
            mcap_channels: 1,
            ..usual()
        },
        "mcap_channels",
    );
    refused(
        Limits {
            mcap_record_bytes: 100,
            ..usual()
        },
        "mcap_record_bytes",
    );
}

// ---------------------------------------------------------------- random damage

/// Small logs of every kind, each of 12 samples.
fn samples_of_every_kind() -> Vec<Vec<u8>> {
    let count = 12;
    let summary = || {
        vec![
            statistics(&[(1, count as u64)]),
            channel(1, 1, "/imu", "cdr"),
        ]
    };
    let records = imu_data(count).concat();
    let json = || {
        let mut data = vec![channel(1, 0, "/sensor", "json")];
        for index in 0..count {
            let text = format!(r#"{{"accel": {{"linear": {{"x": 0, "y": {index}}}}}}}"#);
            data.push(message(1, stamp(index), text.as_bytes()));
        }
        file(&data, &[statistics(&[(1, count as u64)])])
    };
    vec![
        imu::imu_recording("/imu", START, INTERVAL, &values(count)),
        file(&imu_data(count), &summary()),
        file(&[packed("", &records)], &summary()),
        file(&[packed("zstd", &records)], &summary()),
        file(&[packed("lz4", &records)], &summary()),
        json(),
    ]
}

fn any_unit() -> ReadOptions {
    ReadOptions {
        unit: Some(latchgate_kernel::units::AccelerationUnit::StandardGravity),
        ..options(None)
    }
}

/// Every way of cutting a log short ends in an error: each byte of the end, where the file
/// says what it holds, and every eleventh before.
#[test]
fn prop_a_log_cut_anywhere_is_refused() {
    for (kind, whole) in samples_of_every_kind().iter().enumerate() {
        assert_eq!(
            lateral(whole, &any_unit()).unwrap().channels[0]
                .values
                .len(),
            12
        );
        let tail = whole.len() - 150;
        for end in (kind..tail).step_by(11).chain(tail..whole.len()) {
            let found = lateral(&whole[..end], &any_unit());
            assert!(found.is_err(), "kind {kind} cut at byte {end} is read");
        }
    }
}

fn damage(random: &mut Random, bytes: &mut Vec<u8>) {
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len());
        match random.below(8) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.below(256) as u8,
            2 => bytes[at] = [0x00, 0xFF, 0x7F, 0x80][random.below(4)],
            3 => {
                let end = (at + random.below(9)).min(bytes.len());
                bytes[at..end].fill([0x00, 0xFF][random.below(2)]);
            }
            4 => bytes.truncate(at.max(1)),
            5 => {
                let end = (at + random.below(40)).min(bytes.len());
                bytes.drain(at..end);
                bytes.push(0);
            }
            6 => {
                let end = (at + random.below(400)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, copy);
            }
            _ => bytes.insert(at, random.below(256) as u8),
        }
    }
}

/// Damage is refused, or leaves the number of samples as it was; only damaged stamps may
/// change it, and then a finding says that time is not what it was.
#[test]
fn prop_random_damage_never_panics_and_never_changes_the_number_of_samples_in_silence() {
    let seed = 20_260_101;
    println!("seed {seed}");
    let mut random = Random(seed);
    let whole = samples_of_every_kind();
    let limits = Limits {
        samples: 10_000,
        mcap_chunk_bytes: 1 << 20,
        mcap_record_bytes: 1 << 20,
        ..Limits::default()
    };
    let (mut read_all, mut refused) = (0, 0);
    for round in 0..24_000 {
        let mut bytes = whole[round % whole.len()].clone();
        damage(&mut random, &mut bytes);
        match read(&source(&bytes), &any_unit(), Selection::Lateral, &limits) {
            Err(_) => refused += 1,
            Ok(found) => {
                read_all += 1;
                let channel = &found.channels[0];
                let told = channel
                    .findings
                    .iter()
                    .any(|finding| ["gap", "time-irregular"].contains(&&*finding.code));
                let same = channel.values.len() == 12;
                assert!(
                    same || told,
                    "round {round}: {} samples",
                    channel.values.len()
                );
            }
        }
    }
    println!("{read_all} read, {refused} refused");
    // Damage to what no checksum covers and nobody reads must not be refused either.
    assert!(read_all > 500 && refused > 10_000);
}
