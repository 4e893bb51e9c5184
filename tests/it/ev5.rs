//! NHTSA EV5: what a curve file and its header say together, and where they disagree.

use crate::support::{
    Folder, check_at, check_codes, check_refused, data, one, read_path, with_channel,
};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::units::AccelerationUnit;
use latchgate_recording::error::ErrorKind;
use latchgate_recording::{ReadOptions, Selection, Severity};
use std::fmt::Write as _;
use std::path::PathBuf;

/// One line of instrumentation; what a case changes stands in it.
#[derive(Clone)]
pub(crate) struct Line {
    number: u32,
    sensor: &'static str,
    seat: &'static str,
    attachment: &'static str,
    axis: &'static str,
    unit: &'static str,
    prefilter: &'static str,
    rating: &'static str,
    percent: &'static str,
    first: i64,
    last: i64,
    interval: &'static str,
    status: &'static str,
    rank: &'static str,
    comment: &'static str,
}

/// 20 kHz from −2 ms on, a pulse of at most 20 g on a range of 200 g.
pub(crate) const PLAIN: Line = Line {
    number: 7,
    sensor: "AC",
    seat: "NA",
    attachment: "BPLL",
    axis: "YG",
    unit: "G'S",
    prefilter: "1650",
    rating: "200",
    percent: "10",
    first: -40,
    last: 359,
    interval: "50",
    status: "AM",
    rank: "P",
    comment: "NO COMMENTS",
};

impl Line {
    fn text(&self) -> String {
        format!(
            "1|{}|{}|{}|{}|{}|SEC|{}|{}|MAKER|01/JAN/2020|{}|{}|0.0|{}|{}|{}|{}|{}|{}",
            self.number,
            self.sensor,
            self.seat,
            self.attachment,
            self.axis,
            self.unit,
            self.prefilter,
            self.rating,
            self.percent,
            self.first,
            self.last,
            self.interval,
            self.status,
            self.rank,
            self.comment
        )
    }
}

fn header(lines: &[Line]) -> String {
    let mut text = String::from(
        "# Source: a test\n----- EV5 -----\n----- TEST -----\nV5|T|O|01/JAN/2020|L|\n----- INSTRUMENTATION -----\n",
    );
    for line in lines {
        text.push_str(&line.text());
        text.push('\n');
    }
    text.push_str("----- END -----");
    text
}

fn sample(index: i64) -> f64 {
    if (0..200).contains(&index) {
        20.0 * (std::f64::consts::PI * index as f64 / 200.0).sin()
    } else {
        0.0
    }
}

fn curve(first: i64, count: i64, interval_s: f64) -> String {
    let mut text = String::new();
    for index in first..first + count {
        let stamp = index as f64 * interval_s;
        writeln!(text, "{stamp:.6}\t{:.6}", sample(index)).unwrap();
    }
    text
}

/// Writes a test of the given lines, each with its curve, and returns folder and header.
pub(crate) fn test_of(name: &str, lines: &[Line]) -> (Folder, PathBuf) {
    let folder = Folder::new(name);
    for line in lines {
        folder.file(&format!("v00001.{:03}", line.number), curve(-40, 400, 5e-5));
    }
    let path = folder.file("v00001.EV5", header(lines));
    (folder, path)
}

#[test]
fn val_a_curve_has_what_its_line_says() {
    let (folder, header) = test_of("ev5-plain", &[PLAIN]);
    for path in [
        folder.path().join("v00001.007"),
        header,
        folder.path().to_path_buf(),
    ] {
        let (channel, findings) = one(&path, &ReadOptions::default());
        assert_eq!(channel.name, "7 V1 AC BPLL YG");
        assert_eq!(channel.unit, Some(AccelerationUnit::StandardGravity));
        assert_eq!((channel.rate.hertz(), channel.start_s), (20_000.0, -0.002));
        assert_eq!(channel.full_scale_g(), Some(200.0));
        assert_eq!(channel.stated.prefilter_hz, Some(1650.0));
        assert_eq!(channel.stated.status.as_deref(), Some("AM"));
        assert_eq!(channel.values.len(), 400);
        assert_eq!(channel.values[140], 20.0);
        check_codes(&findings, Severity::Warning, &[]);
        check_codes(&findings, Severity::Blocking, &[]);
    }
}

/// Stamps of a microsecond jitter at 9.6 kHz; the header's clock does not.
#[test]
fn val_curves_that_are_announced_and_missing_are_told() {
    let (folder, path) = test_of("missing", &[PLAIN, Line { number: 8, ..PLAIN }]);
    std::fs::remove_file(folder.path().join("v00001.008")).unwrap();
    let recording = read_path(&path, &ReadOptions::default(), Selection::Every).unwrap();
    assert_eq!(recording.channels.len(), 1);
    check_codes(
        &recording.findings,
        Severity::Info,
        &["curves-without-file"],
    );
}

#[test]
fn val_the_stated_clock_is_preferred_to_rounded_stamps() {
    let folder = Folder::new("ev5-clock");
    let line = Line {
        interval: "104.16667",
        percent: "10",
        ..PLAIN
    };
    folder.file("v1.EV5", header(&[line]));
    let path = folder.file("v1.007", curve(-40, 400, 1.0 / 9600.0));
    let (channel, findings) = one(&path, &ReadOptions::default());
    assert_eq!(channel.rate.hertz(), 9600.0);
    check_codes(&findings, Severity::Blocking, &[]);
    // Shifted by --time-zero, samples and findings alike.
    let shifted = ReadOptions {
        time_zero_s: Some(0.001),
        ..ReadOptions::default()
    };
    let (moved, _) = one(&path, &shifted);
    assert_eq!(moved.start_s, channel.start_s - 0.001);
}

/// Every stamp counts against the header's clock, the first and the last as well: one that is off by more than
/// its last digit and a hundredth of the interval, to either side, takes the header's clock away, and is told.
#[test]
fn verif_each_stamp_is_compared_with_the_stated_clock() {
    let folder = Folder::new("ev5-each-stamp");
    folder.file("v1.EV5", header(&[PLAIN]));
    for index in [0, 1, 200, 398, 399] {
        for (off_us, is_told) in [(0, false), (1, false), (20, true), (-20, true)] {
            let whole = curve(-40, 400, 5e-5);
            let mut lines: Vec<String> = whole.lines().map(String::from).collect();
            let (stamp, value) = lines[index].split_once('\t').unwrap();
            let stamp_s = stamp.parse::<f64>().unwrap() + f64::from(off_us) * 1e-6;
            lines[index] = format!("{stamp_s:.6}\t{value}");
            let path = folder.file("v1.007", lines.join("\n") + "\n");
            let (channel, findings) = one(&path, &ReadOptions::default());
            let of_time = |code: &str| code.starts_with("time-");
            let told = findings.iter().any(|one| of_time(&one.code));
            assert_eq!(
                told, is_told,
                "stamp {index} off by {off_us} µs: {findings:?}"
            );
            if !is_told {
                assert_eq!(channel.rate.hertz(), 20_000.0);
            }
        }
    }
    // A start that is five samples off is another clock, though the rates are the same.
    let path = folder.file("v1.007", curve(-35, 400, 5e-5));
    let (_, findings) = one(&path, &ReadOptions::default());
    check_at(&findings, "time-contradicted", None);
}

#[track_caller]
fn check_blocking(line: Line, expected: &[(&str, Option<f64>)]) {
    let (folder, _) = test_of("ev5-word", &[line]);
    let (_, findings) = one(&folder.path().join("v00001.007"), &ReadOptions::default());
    let codes: Vec<&str> = expected.iter().map(|(code, _)| *code).collect();
    check_codes(&findings, Severity::Blocking, &codes);
    for (code, at_s) in expected {
        check_at(&findings, code, *at_s);
    }
}

#[test]
fn val_the_laboratory_says_from_when_on_a_curve_is_no_evidence() {
    let with = |status, comment| Line {
        status,
        comment,
        ..PLAIN
    };
    let (word, remark) = ("invalid-by-laboratory", "laboratory-remark");
    check_blocking(
        with("QD", "NO VALID DATA AFTER 6.4 MILLISECONDS"),
        &[(word, Some(0.0064)), (remark, Some(0.0064))],
    );
    check_blocking(
        with("AM", "EXCEEDED FULL SCALE AT 3 MS"),
        &[(remark, Some(0.003))],
    );
    check_blocking(
        with("AM", "NO VALID DATA AFTER .010 SECONDS"),
        &[(remark, Some(0.01))],
    );
    // With an exponent, outside of the record, and in two ways: no sample is good.
    check_blocking(
        with("AM", "NO VALID DATA AFTER 1.0E-2 S"),
        &[(remark, None)],
    );
    check_blocking(with("AM", "NO VALID DATA AFTER 10 S"), &[(remark, None)]);
    check_blocking(
        with("AM", "NO VALID DATA AFTER 1,000 MS"),
        &[(remark, None)],
    );
    // A status that is not known, and one whose instant lies outside.
    check_blocking(with("XX", "NO COMMENTS"), &[(word, None)]);
    check_blocking(
        with("CF", "NO VALID DATA AFTER 10 S"),
        &[(word, None), (remark, None)],
    );
    check_blocking(with("QD", "NO COMMENTS"), &[(word, None)]);
    check_blocking(with("CF", ""), &[(word, None)]);
    check_blocking(with("MN", "NO COMMENTS"), &[(word, None)]);
    check_blocking(with("XX", ""), &[(word, None)]);
    check_blocking(with("CM", "CALCULATED"), &[]);
    check_blocking(with("AM", "DRIVER SIDE | SECOND PART"), &[]);
}

#[test]
fn val_a_header_that_the_samples_contradict_is_not_believed() {
    // The stamps say 20 kHz.
    check_blocking(
        Line {
            interval: "100",
            ..PLAIN
        },
        &[("time-contradicted", None)],
    );
    // Fewer samples than announced; part of them were never sent.
    check_blocking(
        Line { last: 400, ..PLAIN },
        &[("samples-missing", Some(359.0 / 20_000.0))],
    );
    let cut = Line {
        last: 400,
        status: "CF",
        comment: "INVALID AFTER 17.9 MS",
        ..PLAIN
    };
    check_blocking(
        cut,
        &[
            ("invalid-by-laboratory", Some(0.0179)),
            ("laboratory-remark", Some(0.0179)),
            ("samples-missing", Some(359.0 / 20_000.0)),
        ],
    );

    let (folder, _) = test_of(
        "ev5-peak",
        &[Line {
            percent: "55",
            last: 300,
            ..PLAIN
        }],
    );
    let (_, findings) = one(&folder.path().join("v00001.007"), &ReadOptions::default());
    check_codes(&findings, Severity::Warning, &["count-contradicted"]);
    check_codes(&findings, Severity::Blocking, &["peak-contradicted"]);
}

#[test]
fn val_the_lateral_acceleration_of_the_structure_is_found() {
    let at = |number, attachment, axis| Line {
        number,
        attachment,
        axis,
        ..PLAIN
    };
    let others = [
        at(1, "VECG", "XG"),
        Line {
            sensor: "LC",
            unit: "NWT",
            ..at(2, "BPLL", "YG")
        },
        Line {
            seat: "01",
            ..at(3, "HDCG", "YL")
        },
        Line {
            rank: "R",
            ..at(4, "DSLF", "YG")
        },
        at(5, "VECG", "YG"),
    ];
    // A primary sensor comes before its redundant one.
    let mut lines = others[..4].to_vec();
    lines.push(at(5, "WHLF", "YG"));
    lines.push(at(6, "DSLF", "YG"));
    let (_folder, path) = test_of("ev5-choice", &lines);
    let (channel, findings) = one(&path, &ReadOptions::default());
    assert_eq!(channel.name, "6 V1 AC DSLF YG");
    check_at(&findings, "channel-chosen", None);
    let everything = read_path(&path, &ReadOptions::default(), Selection::Every).unwrap();
    assert_eq!(everything.channels.len(), 6);
    assert_eq!(everything.channels[1].unit, None);
    assert_eq!(everything.parts.len(), 6);

    lines.push(at(8, "DSRF", "YG"));
    let (_folder, path) = test_of("ev5-choice", &lines);
    check_refused(
        &path,
        &ReadOptions::default(),
        |kind| matches!(kind, ErrorKind::AmbiguousChannel { .. }),
        &["6 V1 AC DSLF YG, 8 V1 AC DSRF YG", "`channel`"],
    );
    for name in ["8", "008", "DSRF YG", "8 v1 ac dsrf yg"] {
        assert_eq!(one(&path, &with_channel(name)).0.name, "8 V1 AC DSRF YG");
    }
    let (_, findings) = one(&path, &with_channel("1"));
    check_codes(&findings, Severity::Warning, &["channel-not-lateral"]);
    check_refused(
        &path,
        &with_channel("2"),
        |kind| matches!(kind, ErrorKind::Malformed { .. }),
        &["NWT", "`sensitivity`"],
    );
    check_refused(
        &path,
        &with_channel("99"),
        |kind| matches!(kind, ErrorKind::NoSuchChannel { .. }),
        &["99"],
    );
    let (_folder, path) = test_of("ev5-choice", &others[..3]);
    check_refused(
        &path,
        &ReadOptions::default(),
        |kind| matches!(kind, ErrorKind::AmbiguousChannel { .. }),
        &["1 V1 AC VECG XG (its axis is XG", "3 V1 AC seat 01 HDCG YL"],
    );
}

#[test]
fn val_a_bare_curve_needs_its_unit_and_says_what_is_missing() {
    let folder = Folder::new("ev5-bare");
    let path = folder.file("v1.007", curve(-40, 400, 5e-5));
    check_refused(
        &path,
        &ReadOptions::default(),
        |kind| matches!(kind, ErrorKind::MissingUnit),
        &["the setting `unit`"],
    );
    let options = ReadOptions {
        unit: Some(AccelerationUnit::StandardGravity),
        ..ReadOptions::default()
    };
    let (channel, findings) = one(&path, &options);
    assert_eq!((channel.rate.hertz(), channel.start_s), (20_000.0, -0.002));
    check_codes(&findings, Severity::Warning, &["header-missing"]);
}

#[test]
fn val_damage_is_refused_at_its_line() {
    let folder = Folder::new("ev5-damage");
    let malformed: fn(&ErrorKind) -> bool = |kind| matches!(kind, ErrorKind::Malformed { .. });
    folder.file("v1.EV5", header(&[PLAIN]));
    for (text, kind, words) in [
        ("0.0\t1.0\n1e-4\t1.0\n2e-4\n", malformed, ":3"),
        ("0.0\t1.0\n1e-4\t1.0\n2e-4\tx\n", malformed, "`x`"),
        ("0.0\t1.0\n1e-4\t1,5\n2e-4\t1\n", malformed, "1,5"),
        (
            "0.0\t1.0\n1e-4\t1.0\n1e-4\t1.0\n",
            |kind| matches!(kind, ErrorKind::TimeNotIncreasing { .. }),
            ":3",
        ),
        (
            "0.0\t1.0\n1e-4\t1.0\n2e-4\tinf\n",
            |kind| matches!(kind, ErrorKind::Kernel(KernelError::NonFinite { .. })),
            "inf",
        ),
    ] {
        let path = folder.file("v1.007", text);
        check_refused(&path, &ReadOptions::default(), kind, &[words]);
    }
    folder.file("v1.007", curve(-40, 400, 5e-5));
    for (lines, words) in [
        (vec![PLAIN, PLAIN], "curve 7 twice"),
        (
            vec![Line {
                unit: "G'S|1|2\n1|8|AC",
                ..PLAIN
            }],
            "fields",
        ),
    ] {
        let path = folder.file("v1.EV5", header(&lines));
        check_refused(
            &path,
            &ReadOptions::default(),
            malformed,
            &[words, "v1.EV5"],
        );
    }
}

/// Curves of NHTSA test 7292, where they are at hand: figures read by another program.
#[test]
fn val_curves_of_a_real_test() {
    for (end, name, peak, blocking) in [
        ("146", "146 V1 AC DSLF YG", 191.0, None),
        ("148", "148 V1 AC DSRF YG", 86.0, None),
        ("150", "150 V1 AC VECG YG", 372.0, None),
        ("038", "38 V1 AC seat 01 FOTL YL", 2010.38, Some(0.0646)),
        ("056", "56 V1 AC seat 01 FOTR YL", 2106.54, Some(0.0614)),
    ] {
        let path = data(&format!("recordings/nhtsa_v07292.{end}"));
        let (channel, findings) = one(&path, &ReadOptions::default());
        assert_eq!(channel.name, name);
        assert_eq!(channel.unit, Some(AccelerationUnit::StandardGravity));
        assert_eq!((channel.rate.hertz(), channel.start_s), (12_500.0, -0.02));
        assert_eq!(
            (channel.values.len(), channel.full_scale_g()),
            (4126, Some(2000.0))
        );
        assert_eq!(channel.stated.prefilter_hz, Some(1650.0));
        let found = channel
            .values
            .iter()
            .fold(0.0_f64, |peak, a| peak.max(a.abs()));
        assert!((found - peak).abs() < 1.0, "{found}");
        let expected: &[&str] = if blocking.is_some() {
            &["invalid-by-laboratory", "laboratory-remark"]
        } else {
            &[]
        };
        check_codes(&findings, Severity::Blocking, expected);
        if blocking.is_some() {
            check_at(&findings, "invalid-by-laboratory", blocking);
        }
    }
}
