//! MCAP messages of other encodings than CDR, types of our users' own, and the official
//! conformance files.

use crate::mcap::{
    MAGIC, block, channel, described, double, file, lateral, message, message_type, options,
    schema, schema_of_bytes, whole,
};
use crate::support::{check_codes, data};
use latchgate_kernel::units::AccelerationUnit;
use latchgate_recording::error::ErrorKind;
use latchgate_recording::{Channel, Limits, ReadOptions, Selection, Severity, Source};
use std::io::Read as _;

const IMU1: &str = "\
Header header
float64[9] covariance
Vector3 linear_acceleration
Mark[] marks
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: sensor_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: sensor_msgs/Mark
";

fn sample(index: usize) -> f64 {
    (index as f64 * 0.37).sin() * 120.0
}

/// Instants of 10 kHz, first contact at message 20.
fn stamp_ns(index: usize) -> u64 {
    1_700_000_000_000_000_000 + index as u64 * 100_000
}

fn ros1_message(index: usize) -> Vec<u8> {
    let stamp = stamp_ns(index);
    let mut data = Vec::new();
    data.extend((index as u32).to_le_bytes());
    data.extend(((stamp / 1_000_000_000) as u32).to_le_bytes());
    data.extend(((stamp % 1_000_000_000) as u32).to_le_bytes());
    // A name of three letters would move all that follows if it were aligned.
    data.extend(3_u32.to_le_bytes());
    data.extend(b"imu");
    data.extend([0; 72]);
    for value in [1.0, sample(index), 2.0] {
        data.extend(value.to_le_bytes());
    }
    // Four marks, each of which takes no byte.
    data.extend(4_u32.to_le_bytes());
    data
}

#[track_caller]
fn check_samples(bytes: &[u8], name: Option<&str>, expected_name: &str, count: usize) -> Channel {
    let recording = lateral(bytes, &options(name)).unwrap_or_else(|error| panic!("{error}"));
    let channel = recording.channels.into_iter().next().unwrap();
    assert_eq!(channel.name, expected_name);
    let expected: Vec<f64> = (0..count).map(sample).collect();
    assert_eq!(channel.values, expected);
    assert_eq!(channel.rate.hertz(), 10_000.0);
    channel
}

#[track_caller]
fn check_error(bytes: &[u8], options: &ReadOptions, fragment: &str) -> ErrorKind {
    let error = lateral(bytes, options).unwrap_err();
    assert!(
        error.to_string().contains(fragment),
        "`{fragment}` in: {error}"
    );
    error.kind().clone()
}

#[test]
fn val_ros1_imu() {
    let log = |cut: usize| {
        let mut data = vec![
            schema(1, "sensor_msgs/Imu", "ros1msg", IMU1),
            channel(1, 1, "/imu", "ros1"),
        ];
        data.extend((0..60).map(|index| {
            let mut body = ros1_message(index);
            body.truncate(body.len() - cut);
            message(1, 5, &body)
        }));
        file(&data, &[])
    };
    let found = check_samples(&log(0), None, "/imu:linear_acceleration.y", 60);
    assert_eq!(found.unit, Some(AccelerationUnit::MetrePerSecondSquared));
    check_codes(&found.findings, Severity::Warning, &[]);
    check_error(&log(1), &options(None), "message 1");
}

// ---------------------------------------------------------------- protobuf

fn descriptor_set(syntax: &str) -> Vec<u8> {
    let timestamp = [
        block(1, b"google/protobuf/timestamp.proto"),
        block(2, b"google.protobuf"),
        message_type(
            "Timestamp",
            &[
                described("seconds", 1, 1, 3, ""),
                described("nanos", 2, 1, 5, ""),
            ],
        ),
        block(12, b"proto3"),
    ]
    .concat();
    let own = [
        block(1, b"crash.proto"),
        block(2, b"lab"),
        message_type(
            "Vector",
            &[
                described("x", 1, 1, 1, ""),
                described("y", 2, 1, 1, ""),
                described("count", 3, 1, 18, ""),
            ],
        ),
        message_type(
            "Crash",
            &[
                described("stamp", 1, 1, 11, ".google.protobuf.Timestamp"),
                described("note", 2, 1, 9, ""),
                described("accel", 3, 1, 11, ".lab.Vector"),
                described("raw", 5, 3, 1, ""),
            ],
        ),
        block(12, syntax.as_bytes()),
    ]
    .concat();
    [block(1, &timestamp), block(1, &own)].concat()
}

fn crash(index: usize, vector: &[u8]) -> Vec<u8> {
    let stamp = stamp_ns(index);
    let raw: Vec<u8> = [9.0, sample(index)]
        .iter()
        .flat_map(|v: &f64| v.to_le_bytes())
        .collect();
    [
        block(
            1,
            &[
                whole(1, stamp / 1_000_000_000),
                whole(2, stamp % 1_000_000_000),
            ]
            .concat(),
        ),
        block(2, b"a note"),
        block(3, vector),
        block(5, &raw),
        // A field that the descriptor does not know.
        block(77, b"later"),
    ]
    .concat()
}

fn protobuf_log(syntax: &str, vector: impl Fn(usize) -> Vec<u8>) -> Vec<u8> {
    let mut data = vec![
        schema_of_bytes(1, "lab.Crash", "protobuf", &descriptor_set(syntax)),
        channel(1, 1, "/crash", "protobuf"),
    ];
    data.extend((0..60).map(|index| message(1, 5, &crash(index, &vector(index)))));
    file(&data, &[])
}

#[test]
fn val_protobuf_by_its_own_descriptor() {
    // A zero is not written in proto3.
    let vector = |index: usize| {
        if index == 0 {
            Vec::new()
        } else {
            [double(1, 7.0), double(2, sample(index)), whole(3, 3)].concat()
        }
    };
    let log = protobuf_log("proto3", vector);
    let unit = AccelerationUnit::StandardGravity;
    // The name says lateral acceleration, nothing says the unit.
    let kind = check_error(&log, &options(None), "/crash:accel.y");
    assert!(matches!(kind, ErrorKind::MissingUnit));
    for (name, expected) in [
        (None, "/crash:accel.y"),
        (Some("/crash:raw[1]"), "/crash:raw[1]"),
    ] {
        let with = ReadOptions {
            unit: Some(unit),
            ..options(name)
        };
        let recording = lateral(&log, &with).unwrap();
        let found = &recording.channels[0];
        assert_eq!(
            (found.name.as_str(), found.rate.hertz()),
            (expected, 10_000.0)
        );
        assert_eq!(found.values, (0..60).map(sample).collect::<Vec<_>>());
    }
    let with = ReadOptions {
        unit: Some(unit),
        ..options(Some("/crash:accel.count"))
    };
    assert_eq!(lateral(&log, &with).unwrap().channels[0].values[1], -2.0);
    // In proto2 a value that is not there is none.
    let with = ReadOptions {
        unit: Some(unit),
        ..options(None)
    };
    check_error(&protobuf_log("proto2", vector), &with, "a value of accel.y");
    for (path, fragment) in [
        ("/crash:accel.q", "/crash:accel.y"),
        ("/crash:raw", "raw[0..]"),
    ] {
        check_error(&log, &options(Some(path)), fragment);
    }
    check_error(
        &protobuf_log("proto3", |_| double(2, f64::NAN)),
        &with,
        "finite",
    );
    check_error(&protobuf_log("proto3", |_| whole(2, 1)), &with, "wire type");
    check_error(
        &protobuf_log("proto3", |_| vec![0x11, 0]),
        &with,
        "protobuf",
    );
}

#[test]
fn val_types_of_ones_own_are_found_by_the_names_of_their_fields() {
    let log = |definition: &str| {
        let mut data = vec![
            schema(1, "lab_msgs/msg/Crash", "ros2msg", definition),
            channel(1, 1, "/crash", "cdr"),
        ];
        data.extend((0..60).map(|index| {
            let mut body = vec![0, 1, 0, 0];
            body.extend(1.0_f64.to_le_bytes());
            body.extend(sample(index).to_le_bytes());
            message(1, stamp_ns(index), &body)
        }));
        file(&data, &[])
    };
    let found = check_samples(
        &log("float64 speed\nfloat64 ay_g\n"),
        None,
        "/crash:ay_g",
        60,
    );
    assert_eq!(found.unit, Some(AccelerationUnit::StandardGravity));
    check_codes(&found.findings, Severity::Warning, &["log-time"]);
    check_error(
        &log("float64 accel_y\nfloat64 ay\n"),
        &options(None),
        "/crash:accel_y, /crash:ay",
    );
    let kind = check_error(
        &log("float64 speed\nfloat64 angular_accel_y\n"),
        &options(None),
        "/crash",
    );
    assert!(matches!(kind, ErrorKind::AmbiguousChannel { candidates } if candidates.0.len() == 1));
}

// ---------------------------------------------------------------- conformance

/// Files of a tar archive: names and contents.
fn tar_files(tar: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    let mut left = tar;
    while left.len() >= 512 && left[0] != 0 {
        let text = |range: std::ops::Range<usize>| {
            String::from_utf8_lossy(&left[range])
                .trim_matches(['\0', ' '])
                .to_string()
        };
        let size = usize::from_str_radix(&text(124..136), 8).unwrap();
        let content = left[512..512 + size].to_vec();
        if left[156] == b'0' {
            files.push((text(0..100), content));
        }
        left = &left[512 + size.next_multiple_of(512)..];
    }
    files
}

/// Each file of the part of the official conformance suite that is at hand reads, with the
/// topics, types and numbers of messages that the description beside it states.
#[test]
fn val_the_conformance_suite_reads_as_described() {
    let name = "mcap_conformance_NoData_OneMessage_OneSchemalessMessage_OneMetadata.tar.gz";
    let path = data(&format!("recordings/{name}"));
    let mut tar = Vec::new();
    flate2::read::GzDecoder::new(std::fs::File::open(path).unwrap())
        .read_to_end(&mut tar)
        .unwrap();
    let files = tar_files(&tar);
    let mut checked = 0;
    for (name, bytes) in files.iter().filter(|(name, _)| name.ends_with(".mcap")) {
        let beside = name.replace(".mcap", ".json");
        let (_, json) = files.iter().find(|(other, _)| *other == beside).unwrap();
        let json: serde_json::Value = serde_json::from_slice(json).unwrap();
        let records = json["records"].as_array().unwrap();
        let of = |kind: &str| -> Vec<&serde_json::Value> {
            records
                .iter()
                .filter(|record| record["type"] == kind)
                .collect()
        };
        let field = |record: &serde_json::Value, key: &str| -> String {
            let fields = record["fields"].as_array().unwrap();
            let pair = fields.iter().find(|pair| pair[0] == key).unwrap();
            pair[1].as_str().unwrap_or_default().to_string()
        };
        assert!(bytes.starts_with(MAGIC), "{name}");
        let source = Source::bytes(name.clone(), bytes.clone());
        let read = latchgate_recording::read(
            &source,
            &ReadOptions::default(),
            Selection::Every,
            &Limits::default(),
        )
        .unwrap_or_else(|error| panic!("{name}: {error}"));
        let told = read
            .findings
            .iter()
            .find(|finding| finding.code == "topics-left-out");
        let channels = of("Channel");
        assert_eq!(told.is_some(), !channels.is_empty(), "{name}");
        if let (Some(told), Some(first)) = (told, channels.first()) {
            let schema = of("Schema")
                .first()
                .map_or("no schema".into(), |schema| field(schema, "name"));
            let messages = of("Message").len();
            let expected = format!(
                "{} ({schema}, {}): {messages} message",
                field(first, "topic"),
                field(first, "message_encoding")
            );
            assert!(
                told.text.contains(&expected),
                "{name}: {expected}: {}",
                told.text
            );
        }
        checked += 1;
    }
    assert_eq!(checked, 248);
}
