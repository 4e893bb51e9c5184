//! One signal, written in every format, is one signal: bit-equal samples and one hash. And what
//! is no format of ours is refused by its name, with a way out.

use crate::mcap::{channel, file, imu, message, schema};
use crate::support::{Folder, check_codes, check_refused, data, one};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::error::ErrorKind;
use latchgate_recording::{Channel, ReadOptions, Severity};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A clock that formats write: rate [Hz], samples before first contact, interval in
/// microseconds as a header prints it, decimals of a stamp in seconds.
#[derive(Clone, Copy)]
struct Clock {
    rate_hz: f64,
    before: i64,
    interval_us: &'static str,
    decimals: usize,
}

const COUNT: i64 = 700;

/// Values of a converter [g], with six decimals as NHTSA prints them.
fn value_g(index: i64) -> String {
    let phase = index as f64 * 0.0731;
    format!("{:.6}", 87.3 * phase.sin() - 21.7 * (2.3 * phase).cos())
}

fn stamp(clock: Clock, index: i64) -> String {
    format!(
        "{:.*}",
        clock.decimals,
        (index - clock.before) as f64 / clock.rate_hz
    )
}

/// The interval as a header prints it [s].
fn interval_s(clock: Clock) -> String {
    format!("{}E-6", clock.interval_us)
}

fn csv(clock: Clock, comma: bool) -> String {
    let mut text = String::from(if comma {
        "Zeit [s];a quer [g]\n"
    } else {
        "time_s,ay_g\n"
    });
    for index in 0..COUNT {
        let (stamp, value) = (stamp(clock, index), value_g(index));
        if comma {
            writeln!(
                text,
                "{};{}",
                stamp.replace('.', ","),
                value.replace('.', ",")
            )
            .unwrap();
        } else {
            writeln!(text, "{stamp},{value}").unwrap();
        }
    }
    text
}

fn utf_16(text: &str) -> Vec<u8> {
    let mut bytes = vec![0xFF, 0xFE];
    bytes.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
    bytes
}

fn lvm(clock: Clock, columns: &str) -> String {
    let mut text = format!(
        "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\t{columns}\n***End_of_Header***\t\n\nChannels\t1\t\nSamples\t{COUNT}\t\nY_Unit_Label\tg\t\nX_Dimension\tTime\t\nX0\t{}\t\nDelta_X\t{}\t\n***End_of_Header***\t\t\nX_Value\tay\tComment\n",
        stamp(clock, 0),
        interval_s(clock)
    );
    for index in 0..COUNT {
        let stamp = if columns == "No" {
            String::new()
        } else {
            stamp(clock, index)
        };
        writeln!(text, "{stamp}\t{}", value_g(index)).unwrap();
    }
    text
}

fn ev5(clock: Clock) -> (String, String) {
    let header = format!(
        "----- INSTRUMENTATION -----\n1|3|AC|NA|DSLF|YG|SEC|G'S|1650|M|01/JAN/2020|2000|5|0.0|{}|{}|{}|AM|P|NO COMMENTS\n----- END -----",
        -clock.before,
        COUNT - 1 - clock.before,
        clock.interval_us
    );
    let mut curve = String::new();
    for index in 0..COUNT {
        let stamp = (index - clock.before) as f64 / clock.rate_hz;
        writeln!(curve, "{stamp:.6}\t{}", value_g(index)).unwrap();
    }
    (header, curve)
}

fn mme(clock: Clock) -> String {
    let mut text = format!(
        "Channel code                :11DOORLE0000ACYA\nUnit                        :g\nReference channel           :implicit\nSampling interval           :{}\nTime of first sample        :{}\nNumber of samples           :{COUNT}\n",
        interval_s(clock),
        stamp(clock, 0)
    );
    for index in 0..COUNT {
        writeln!(text, "{}", value_g(index)).unwrap();
    }
    text
}

/// Messages carry m/s², so the product is made before it is written.
fn mcap(clock: Clock, contact_ns: u64) -> Vec<u8> {
    let mut data = vec![
        schema(1, imu::IMU_SCHEMA_NAME, "ros2msg", imu::IMU_SCHEMA),
        channel(1, 1, "/imu", "cdr"),
    ];
    for index in 0..COUNT {
        let offset = ((index - clock.before) as f64 / clock.rate_hz * 1e9).round() as i64;
        let stamp = contact_ns.wrapping_add_signed(offset);
        let value: f64 = value_g(index).parse().unwrap();
        let body = imu::imu_message_cdr(stamp, "imu", [0.0, value * STANDARD_GRAVITY, 9.8]);
        data.push(message(1, stamp, &body));
    }
    file(&data, &[])
}

fn written(folder: &Folder, clock: Clock) -> Vec<(PathBuf, ReadOptions)> {
    let plain = ReadOptions::default;
    let (header, curve) = ev5(clock);
    folder.file("a.EV5", header);
    let contact_s = 1_000;
    vec![
        (folder.file("a.csv", csv(clock, false)), plain()),
        (folder.file("comma.csv", csv(clock, true)), plain()),
        (folder.file("utf16.txt", utf_16(&csv(clock, true))), plain()),
        (folder.file("one.lvm", lvm(clock, "One")), plain()),
        (folder.file("no.lvm", lvm(clock, "No")), plain()),
        (folder.file("a.003", curve), plain()),
        (folder.file("mme/t.001", mme(clock)), plain()),
        (
            folder.file("a.mcap", mcap(clock, contact_s * 1_000_000_000)),
            ReadOptions {
                time_zero_s: Some(contact_s as f64),
                ..plain()
            },
        ),
    ]
}

fn in_si(channel: &Channel) -> Vec<u64> {
    let factor = channel.unit.unwrap().metres_per_second_squared();
    channel
        .values
        .iter()
        .map(|value| (value * factor).to_bits())
        .collect()
}

#[track_caller]
fn check_agreement(clock: Clock) {
    let folder = Folder::new("agreement");
    let mut first: Option<(Vec<u64>, String)> = None;
    for (path, options) in written(&folder, clock) {
        let (channel, findings) = one(&path, &options);
        let name = path.display();
        check_codes(&findings, Severity::Blocking, &[]);
        assert_eq!(channel.rate.hertz(), clock.rate_hz, "{name}");
        let found = (in_si(&channel), channel.content_sha256().unwrap());
        let expected = first.get_or_insert_with(|| found.clone());
        assert_eq!(found.0, expected.0, "{name}");
        assert_eq!(
            found.1,
            expected.1,
            "{name}: start {:e}, rate {:e}",
            channel.start_s,
            channel.rate.hertz()
        );
    }
}

#[test]
fn val_all_readers_give_one_signal() {
    for clock in [
        Clock {
            rate_hz: 10_000.0,
            before: 100,
            interval_us: "100",
            decimals: 6,
        },
        Clock {
            rate_hz: 12_500.0,
            before: 250,
            interval_us: "80",
            decimals: 6,
        },
        Clock {
            rate_hz: 20_000.0,
            before: 0,
            interval_us: "50",
            decimals: 6,
        },
        Clock {
            rate_hz: 25_600.0,
            before: 256,
            interval_us: "39.0625",
            decimals: 10,
        },
        Clock {
            rate_hz: 8_000.0,
            before: 33,
            interval_us: "125",
            decimals: 6,
        },
    ] {
        check_agreement(clock);
    }
}

/// An interval a hundred times too short makes a pulse a hundredth as long, which no lever feels:
/// whatever the format, a rate that no crash recording has needs a person's word.
#[test]
fn val_a_rate_beyond_belief_is_asked_for_in_every_format() {
    let folder = Folder::new("incredible");
    let clock = Clock {
        rate_hz: 1e6,
        before: 100,
        interval_us: "1",
        decimals: 6,
    };
    for (path, options) in written(&folder, clock) {
        check_refused(
            &path,
            &options,
            |kind| matches!(kind, ErrorKind::Malformed { .. }),
            &[
                "a rate that crash recordings have",
                "1000000 Hz",
                "`rate_hz`",
            ],
        );
        let confirmed = ReadOptions {
            rate_hz: Some(clock.rate_hz),
            ..options
        };
        // The unit alone confirms no rate.
        let in_seconds = ReadOptions {
            time_unit: Some(latchgate_kernel::units::TimeUnit::SECOND),
            rate_hz: None,
            ..confirmed.clone()
        };
        let malformed = |kind: &ErrorKind| matches!(kind, ErrorKind::Malformed { .. });
        check_refused(&path, &in_seconds, malformed, &["1000000 Hz"]);
        let (channel, findings) = one(&path, &confirmed);
        assert_eq!(channel.rate.hertz(), clock.rate_hz);
        let told = |finding: &latchgate_recording::Finding| {
            finding.code == "time-unit-implausible" && finding.severity == Severity::Warning
        };
        assert!(
            findings.iter().any(told),
            "{}: {findings:?}",
            path.display()
        );
    }
}

/// The hash tells signals apart: by a bit of a sample, by the rate, by the start.
#[test]
fn val_the_hash_tells_signals_apart() {
    let folder = Folder::new("hash");
    let clock = Clock {
        rate_hz: 10_000.0,
        before: 100,
        interval_us: "100",
        decimals: 6,
    };
    let (whole, _) = one(
        &folder.file("a.csv", csv(clock, false)),
        &ReadOptions::default(),
    );
    let hash = whole.content_sha256().unwrap();
    assert_eq!(hash.len(), 64);
    let mut other = whole.clone();
    other.values[7] = f64::from_bits(other.values[7].to_bits() ^ 1);
    let later = ReadOptions {
        time_zero_s: Some(1e-4),
        ..ReadOptions::default()
    };
    let (moved, _) = one(&folder.path().join("a.csv"), &later);
    for channel in [other, moved] {
        assert_ne!(channel.content_sha256().unwrap(), hash);
    }
    let mut without = whole;
    without.unit = None;
    assert_eq!(without.content_sha256(), None);
}

fn refused(path: &Path, words: &[&str]) {
    check_refused(
        path,
        &ReadOptions::default(),
        |kind| matches!(kind, ErrorKind::RefusedFormat { .. }),
        words,
    );
}

#[test]
fn val_other_formats_are_refused_by_name_with_a_way_out() {
    let folder = Folder::new("refused");
    for (head, words) in [
        (&b"MDF     4.11"[..], ["MDF4", "CSV"]),
        (b"UnFinMF 4.11", ["MDF4", "CSV"]),
        (b"MDF     3.30", ["MDF", "CSV"]),
        (b"TDSh\x0e\0\0\0", ["TDMS", ".tdms file"]),
        (b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", [".xls", "CSV"]),
        (b"\x89HDF\r\n\x1A\n", ["HDF5", "CSV"]),
        (
            b"MATLAB 5.0 MAT-file, Platform: PCWIN",
            ["MATLAB", "writematrix"],
        ),
        (
            b"MATLAB 7.3 MAT-file, Platform: PCWIN",
            ["MATLAB", "writematrix"],
        ),
        (b"\x28\xB5\x2F\xFD\0", ["zstd", "unpack"]),
        (b"BZh91AY&SY", ["bzip2", "unpack"]),
        (b"\xFD7zXZ\0\0", ["xz", "unpack"]),
        (b"#ROSBAG V2.0\n", ["ROS 1 bag", "mcap convert"]),
        (b"SQLite format 3\0", ["SQLite", "ros2 bag convert"]),
        (b"ULog\x01\x12\x35\x01\0\0", ["ULog", "ulog2csv"]),
        (b"LOGG\x90\0\0\0\x05\x02", ["Vector (.blf)", "CSV"]),
        (
            b"date Sam Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\ninternal events logged\n",
            ["Vector (.asc)", "CSV"],
        ),
        (
            b"date Tue May 3 10:00:00 am 2024\r\nbase dec  timestamps relative\r\n   0.01 1  64  Rx d 2 01 02\r\n",
            ["Vector (.asc)", "CSV"],
        ),
        (b"FORMAT\0\0\0\0\0\0", ["RPC III", "CSV"]),
        (b"\0\0\x01\x20\0\0\0\0\x51\xED\xA7\xA0<?xml", ["SoMat", "CSV"]),
        (
            b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<sie version=\"1.0\">\n",
            ["SoMat", "CSV"],
        ),
        (b"#9001120146WAVEDESC\0\0\0", ["LeCroy", "CSV"]),
        (b"WAVEDESC\0\0\0\0LECROY_2_3", ["LeCroy", "CSV"]),
        (b"\x0F\x0F:WFM#003\x04\x0C", ["Tektronix", "CSV"]),
        (b"\xF0\xF0:WFM#002\x04\x0C", ["Tektronix", "CSV"]),
        (b"000001D ANMO 00BHZIU\x07\xDA\0", ["miniSEED", "CSV"]),
        (b"123456R STATION\0\0", ["miniSEED", "CSV"]),
        (b"MS\x03\x04\0\0", ["miniSEED", "CSV"]),
        (b"\x02\x50\x0C\0", ["C3D", "CSV"]),
        (b"\xFFBIOSEMI", ["BDF", "CSV"]),
        (b"ARROW1\0\0", ["Feather", "CSV"]),
        (b"FEA1\0\0", ["Feather", "CSV"]),
        (b"\x08\x08\x08\x01\x01\x01\0\0", ["binout", "CSV"]),
    ] {
        // The content counts, whatever the name says.
        refused(&folder.file("a.csv", head), &words);
    }
    // These say nothing of themselves; their names do.
    for (name, word) in [("a.tdx", "DIAdem"), ("A.TDX", "DIAdem"), ("a.edf", "EDF")] {
        refused(&folder.file(name, b"\0\x01\x02\x03"), &[word, "CSV"]);
    }
    for (name, word) in [
        ("canedge_vehicle_imu_finalized.MF4", "MDF4"),
        ("canedge_vehicle_imu_unfinalized.MF4", "MDF4"),
    ] {
        refused(&data(&format!("recordings/{name}")), &[word, "CSV"]);
    }
}

/// A row that a recorder wrote twice is taken once; a stamp that comes again with another
/// value is refused as before.
#[test]
fn val_rows_written_twice_are_taken_once() {
    let folder = Folder::new("repeated");
    let rows: Vec<String> = (0..300)
        .map(|i| format!("{:.4},{}\n", f64::from(i) * 1e-4, i % 7))
        .collect();
    let mut text = String::from("time_s,ay_g\n");
    for (index, row) in rows.iter().enumerate() {
        text.push_str(row);
        if index % 100 == 50 {
            text.push_str(row);
        }
    }
    let (channel, findings) = one(&folder.file("a.csv", &text), &ReadOptions::default());
    assert_eq!(
        (channel.values.len(), channel.rate.hertz()),
        (300, 10_000.0)
    );
    check_codes(&findings, Severity::Warning, &["rows-repeated"]);
    assert!(
        findings
            .iter()
            .any(|finding| finding.text.contains("3 rows") && finding.text.contains("line 53"))
    );
    let other = text.replacen("0.0050,1\n0.0050,1\n", "0.0050,1\n0.0050,2\n", 1);
    check_refused(
        &folder.file("a.csv", other),
        &ReadOptions::default(),
        |kind| matches!(kind, ErrorKind::TimeNotIncreasing { .. }),
        &["a.csv:53"],
    );
}

/// Files of every format with bytes changed, cut and doubled end in samples or in an error,
/// never in a panic; the seed of a case that does is in the message.
#[test]
fn prop_damaged_files_never_panic() {
    use crate::support::Random;
    use latchgate_recording::{Limits, Selection, Source};

    let clock = Clock {
        rate_hz: 10_000.0,
        before: 100,
        interval_us: "100",
        decimals: 6,
    };
    let folder = Folder::new("damaged");
    for (path, options) in written(&folder, clock) {
        let whole = std::fs::read(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // The start, where headers are, and all of it.
        for seed in 0..120 {
            let mut random = Random(seed);
            let mut bytes = whole.clone();
            if seed % 3 == 0 {
                bytes.truncate(600);
            }
            for _ in 0..=random.below(4) {
                let reach = if seed % 2 == 0 {
                    bytes.len().min(700)
                } else {
                    bytes.len()
                };
                let at = random.below(reach.max(1));
                match random.below(4) {
                    0 => bytes.truncate(at),
                    1 => bytes.insert(at, b"\t\n:|,.-0"[random.below(8)]),
                    2 => {
                        let piece = bytes[at..].iter().copied().take(40).collect::<Vec<_>>();
                        bytes.splice(at..at, piece);
                    }
                    _ if at < bytes.len() => bytes[at] = (random.next() & 0xFF) as u8,
                    _ => {}
                }
            }
            let source = Source::bytes(name.clone(), bytes);
            for selection in [Selection::Lateral, Selection::Every] {
                let read = std::panic::catch_unwind(|| {
                    latchgate_recording::read(&source, &options, selection, &Limits::default())
                });
                let read = read.unwrap_or_else(|_| panic!("{name}, seed {seed}"));
                for channel in read.iter().flat_map(|recording| &recording.channels) {
                    assert!(
                        channel.values.iter().all(|value| value.is_finite()),
                        "{name}, seed {seed}"
                    );
                }
            }
        }
    }
}
