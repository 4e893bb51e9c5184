//! Cells of tables and channel files: marks in numbers, dates, and columns that count the rows.

use crate::csv::read_table;
use crate::support::Random;
use latchgate_kernel::units::TimeUnit;
use latchgate_recording::csv::stamp::{StampClock, nanoseconds};
use latchgate_recording::error::Error;
use latchgate_recording::{Limits, ReadOptions, Recording, Selection, Source};

/// Reads numbers as the channel file of a test, one a line.
fn read_numbers(cells: &[&str]) -> Result<Recording, Error> {
    let text = format!(
        "Channel code :14BPILLO0000ACYA\nUnit :g\nSampling interval :0.001\n{}\n",
        cells.join("\n")
    );
    let source = Source::bytes("a.001", text.into_bytes());
    latchgate_recording::read(
        &source,
        &ReadOptions::default(),
        Selection::Lateral,
        &Limits::default(),
    )
}

/// Checks whether the marks may separate thousands. With a whole number and a doubtful one beside
/// them they may unless one is `decimal`.
#[track_caller]
fn check_marks(cells: &[&str], decimal: bool, may_be_thousands: bool) {
    let is_refused = |cells: &[&str]| match read_numbers(cells) {
        Ok(_) => false,
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains("mark is clear"), "{cells:?}: {text}");
            true
        }
    };
    assert_eq!(is_refused(cells), may_be_thousands, "{cells:?}");
    let comma = cells.iter().any(|cell| cell.contains(','));
    let doubtful = if comma { "7,158" } else { "7.158" };
    let beside = [cells, &["1", doubtful]].concat();
    assert_eq!(is_refused(&beside), !decimal, "{beside:?}");
}

#[test]
fn verif_marks_that_may_separate_thousands_are_told_from_decimal_ones() {
    check_marks(&["-1", "2", "6,158", "12,322"], false, true);
    check_marks(&["-1", " -6.158 "], false, true);
    check_marks(&["+588,273", "0"], false, true);
    // Three decimals throughout, and nothing beside them.
    check_marks(&["6.158", "12.322"], false, false);
    check_marks(&["1", "2"], false, false);
    for proof in [
        "0,158", "-0.158", ".158", "1234.158", "6.1580", "6,1", "6.158e0", "6.",
    ] {
        let doubtful = if proof.contains(',') {
            "6,158"
        } else {
            "6.158"
        };
        check_marks(&["1", doubtful, proof], true, false);
        check_marks(&[proof, "1", doubtful], true, false);
    }
}
#[track_caller]
fn check_date(text: &str, seconds: i64, rest_ns: i64) {
    let expected = i128::from(seconds) * 1_000_000_000 + i128::from(rest_ns);
    assert_eq!(nanoseconds(text.as_bytes()), Some(expected), "{text}");
}

/// Seconds since 1970 as `date -u -d TEXT +%s` gives them.
#[test]
fn val_dates() {
    check_date("1970-01-01T00:00:00", 0, 0);
    check_date("2024-05-01T10:00:00.0001", 1_714_557_600, 100_000);
    check_date("2024-05-01 10:00:00,5Z", 1_714_557_600, 500_000_000);
    check_date("2024-05-01T10:00:00+02:00", 1_714_550_400, 0);
    check_date(
        "2024-05-01T10:00:00.123456789-0530",
        1_714_577_400,
        123_456_789,
    );
    check_date("2000-02-29T23:59:59", 951_868_799, 0);
    check_date("1969-12-31T23:59:59.999999999", -1, 999_999_999);
    for text in [
        "2023-02-29T00:00:00",
        "2024-13-01T00:00:00",
        "2024-05-01",
        "2024-05-01T24:00:00",
        "2024-05-01T10:00:00.",
        "2024-05-01T10:00:00 CET",
        "2024-05-01T10:00:00+1",
        "2024-05-01T10:00:00+01:",
        "24-05-01T10:00:00",
        "0.5",
        "",
    ] {
        assert_eq!(nanoseconds(text.as_bytes()), None, "{text}");
    }
}

/// Reads stamps one after the other; checks the times that they tell [s].
#[track_caller]
fn check_stamps(cells: &[&str], expected: &[Option<f64>]) {
    let mut clock = StampClock::default();
    let times: Vec<Option<f64>> = cells
        .iter()
        .map(|cell| clock.seconds(cell.as_bytes()))
        .collect();
    assert_eq!(times, expected, "{cells:?}");
}

/// What a reader of each stamp would say: seconds from the first, or from the zero of its own.
#[test]
fn val_stamps_as_words() {
    let two = |first: &str, second: &str, seconds: f64| {
        check_stamps(&[first, second], &[Some(0.0), Some(seconds)]);
    };
    two(
        "2024-12-31T23:59:59.9999",
        "2025-01-01T00:00:00.0001",
        0.0002,
    );
    two("23:59:59.9999", "00:00:00.0001", 0.0002);
    two("59:59.9999", "00:00.0001", 0.0002);
    two("11:59:59 AM", "12:00:01 p.m.", 2.0);
    two("12:59:59 am", "1:00:00 am", 1.0);
    two("28/02/2024 23:59:59", "29/02/2024 00:00:00", 1.0);
    two("02/28/2023 23:59:59", "03/01/2023 00:00:00", 1.0);
    two("01/05/2024 23:59:59", "02/05/2024 00:00:00", 1.0);
    two("05/01/2024 23:59:59", "05/02/2024 00:00:00", 1.0);
    two("12-Feb-2024 23:59:59", "13-FEB-2024 00:00:00", 1.0);
    two("29. Feb. 2024 10:00:00", "1. März 2024 10:00:00", 86_400.0);
    two("05/01/2024 10:00", "05/01/2024 10:01", 60.0);
    two(
        "2024-05-01T10:00:00+02:00",
        "2024-05-01T09:00:00+01:00",
        0.0,
    );
    check_stamps(
        &[
            "-1 days +23:59:59.95",
            "0 days",
            "0 days 00:00:00.1",
            "1 days 00:00:00",
        ],
        &[Some(-0.05), Some(0.0), Some(0.1), Some(86_400.0)],
    );
    check_stamps(
        &["900 us", "1 ms", "0.0011 s", "1e-3min"],
        &[Some(9e-4), Some(1e-3), Some(0.0011), Some(0.06)],
    );
    check_stamps(&["-00:00:01.5", "00:00:00"], &[Some(-1.5), Some(0.0)]);
    // A date among times, a month that is none, and what is no time at all.
    check_stamps(&["10:00:00", "2024-05-01 10:00:01"], &[Some(0.0), None]);
    for text in [
        "10:00",
        "10:60:00",
        "10:00:60",
        "10:00:00:12",
        "13:00:00 PM",
        "0:30 AM",
        "1.13.2024 10:00:00",
        "13/13/2024 10:00:00",
        "1-Foo-2024 10:00:00",
        "10h00m01s",
        "0.1 g",
        "5 m",
        "12",
        "ms",
        "1:2:3:4:5",
        "",
    ] {
        let expected = (text == "10:00").then_some(0.0);
        check_stamps(&[text], &[expected]);
    }
}

/// Cells of any such characters neither panic nor give a time that is none, and units are read back as they are
/// written.
#[test]
fn prop_stamps_and_units_never_panic() {
    const PARTS: [&str; 28] = [
        "0",
        "1",
        "12",
        "59",
        "2024",
        "000100",
        ":",
        ":",
        ":",
        ".",
        ",",
        "-",
        "+",
        "/",
        " ",
        "T",
        "Z",
        "am",
        "PM",
        "day",
        "days",
        "ms",
        "us",
        "May",
        "µ",
        "e",
        "99999999999999999999",
        "min",
    ];
    let seed = 36;
    let mut random = Random(seed);
    let mut read = 0;
    for round in 0..40_000 {
        let cells: Vec<String> = (0..3)
            .map(|_| {
                (0..1 + random.below(9))
                    .map(|_| PARTS[random.below(PARTS.len())])
                    .collect()
            })
            .collect();
        let mut clock = StampClock::default();
        for cell in &cells {
            if let Some(seconds) = clock.seconds(cell.as_bytes()) {
                assert!(seconds.is_finite(), "seed {seed} round {round}: {cells:?}");
                read += 1;
            }
            if let Some(unit) = TimeUnit::from_spelling(cell) {
                let again = TimeUnit::from_spelling(&unit.to_string());
                assert_eq!(again, Some(unit), "seed {seed} round {round}: {cell}");
            }
        }
    }
    assert!(read > 400, "{read} stamps were read");
}

/// Seconds of units of time, by their definitions.
#[test]
fn val_units_of_time() {
    for (text, seconds, name) in [
        ("s", 1.0, "s"),
        ("Sek.", 1.0, "s"),
        ("msec", 1e-3, "ms"),
        ("µs", 1e-6, "us"),
        ("10us", 1e-5, "10us"),
        ("0.01ms", 1e-5, "10us"),
        ("0,1 ms", 1e-4, "100us"),
        ("1e-4 s", 1e-4, "100us"),
        ("1E-7s", 1e-7, "100ns"),
        ("100 ns ticks", 1e-7, "100ns"),
        ("100-ns", 1e-7, "100ns"),
        ("12.5ns", 1.25e-8, "1/80000000s"),
        ("1/32768 s", 1.0 / 32_768.0, "1/32768s"),
        ("1000 ms", 1.0, "s"),
        ("min", 60.0, "min"),
        ("15 Minuten", 900.0, "15min"),
        ("h", 3600.0, "h"),
        ("Tage", 86_400.0, "day"),
    ] {
        let unit = TimeUnit::from_spelling(text).unwrap_or_else(|| panic!("{text}"));
        assert_eq!(unit.seconds(), seconds, "{text}");
        assert_eq!(unit.to_string(), name, "{text}");
        assert_eq!(TimeUnit::from_spelling(name), Some(unit), "{name}");
    }
    for text in [
        "",
        "10",
        "m",
        "0 us",
        "-1 ms",
        "1//2 s",
        "1e s",
        "100 g",
        "us ticks",
        "1e40 s",
        "1e-30 s",
        "ticks",
        "99999999999999999999 s",
        ". s",
        "s2",
        "m/s",
    ] {
        assert_eq!(TimeUnit::from_spelling(text), None, "{text}");
    }
}

/// Reads counts beside a channel at a stated rate; checks which finding they give, and in which row.
#[track_caller]
fn check_counts(counts: &[f64], named: bool, expected: Option<(&str, Option<u64>)>) {
    let name = if named { "n" } else { "w" };
    let row = |count: &f64| format!("{count},{}\n", count % 3.0 + 0.5);
    let rows: String = counts.iter().map(row).collect();
    let options = ReadOptions {
        rate_hz: Some(1e3),
        ..ReadOptions::default()
    };
    let table = format!("{name},acc_y_g\n{rows}");
    let recording = read_table(table, &options, Selection::Lateral).expect("a table");
    let mut found = recording.channels[0].findings.iter();
    let found = found.find(|one| one.code.starts_with("index-"));
    let line = |text: &str| text.split_once("line ")?.1.split(')').next()?.parse().ok();
    // The header stands on line 1, and the fault is told where the row before it ends.
    let row = |text: &str| line(text).map(|line: u64| line - 3);
    let found = found.map(|one| (&*one.code, row(&one.text)));
    assert_eq!(found, expected, "{counts:?}");
}

#[test]
fn verif_counts_that_skip_repeat_or_run_back_are_told() {
    check_counts(&[0.0, 1.0, 2.0, 3.0], true, None);
    check_counts(&[0.0, 2.0, 4.0, 6.0], true, Some(("index-step", None)));
    check_counts(
        &[0.0, 1.0, 2.0, 4.0, 5.0],
        true,
        Some(("index-gap", Some(2))),
    );
    check_counts(
        &[0.0, 1.0, 1.0, 2.0, 3.0],
        true,
        Some(("index-gap", Some(1))),
    );
    check_counts(
        &[0.0, 1.0, 2.0, 0.0, 1.0],
        true,
        Some(("index-gap", Some(2))),
    );
    check_counts(&[3.0, 2.0, 1.0, 0.0], true, Some(("index-gap", Some(0))));
    check_counts(&[0.0, 0.0, 0.0, 1.0], true, Some(("index-gap", Some(0))));
    check_counts(&[254.0, 255.0, 0.0, 1.0], true, None);
    // The number of a test, a current, and a channel without a name that says what it is.
    check_counts(&[7.0, 7.0, 7.0, 7.0], true, None);
    check_counts(&[0.5, 0.25, 0.75, 0.25, 0.5], true, None);
    check_counts(&[0.0, 1.0, 5.0, 3.0, 9.0], false, None);
    // A clock that nothing calls one.
    let mut ticks: Vec<f64> = (0..40).map(|k| 100.0 * f64::from(k)).collect();
    check_counts(&ticks, false, None);
    ticks.remove(20);
    check_counts(&ticks, false, Some(("index-gap", Some(19))));
}
/// A line too long after many that are not is told at its own line and byte, be it long only once it
/// is decoded.
#[test]
fn verif_a_long_line_after_many_rows_is_told_at_its_place() {
    let limits = Limits {
        line_bytes: 60,
        ..Limits::default()
    };
    for long in [&[b'3'; 99][..], &[0xE9; 50]] {
        let table = [&b"1,2\n".repeat(5000), long, b"\n1,2\n"].concat();
        let source = Source::bytes("a.csv", table);
        let options = ReadOptions::default();
        let error = latchgate_recording::read(&source, &options, Selection::Lateral, &limits)
            .expect_err("a long line");
        let place = error.place();
        assert_eq!((place.line, place.byte), (Some(5001), Some(20_060)));
    }
}

#[test]
fn val_patterns_of_codes() {
    let code = "14BPILLO0000ACYA";
    let fits = |pattern: &str| {
        let text = format!("Channel code :{code}\nUnit :g\nSampling interval :0.001\n1\n2\n");
        let options = ReadOptions {
            channel: Some(pattern.into()),
            ..ReadOptions::default()
        };
        let source = Source::bytes("a.001", text.into_bytes());
        latchgate_recording::read(&source, &options, Selection::Lateral, &Limits::default()).is_ok()
    };
    for pattern in [
        code,
        "1?BPIL??????AC[Y2]?",
        "*BPIL*AC[2Y]*",
        "14bpil*",
        "*",
        "????????????????",
    ] {
        assert!(fits(pattern), "{pattern}");
    }
    for pattern in [
        "",
        "1?BPIL??????AC[X2]?",
        "*SILB*",
        "???",
        "14BPIL*Z",
        "[",
        "*B",
    ] {
        assert!(!fits(pattern), "{pattern}");
    }
}
