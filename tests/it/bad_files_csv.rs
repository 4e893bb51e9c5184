//! Bad text tables: each is refused with its message and place, none panics, none costs memory.

use crate::csv::read_table;
use crate::support::Random;
use latchgate_kernel::units::{AccelerationUnit, TimeUnit};
use latchgate_recording::error::ErrorKind;
use latchgate_recording::{Limits, ReadOptions, Selection, Source};

fn none() -> ReadOptions {
    ReadOptions::default()
}

fn in_g() -> ReadOptions {
    ReadOptions {
        unit: Some(AccelerationUnit::StandardGravity),
        ..ReadOptions::default()
    }
}

fn channel(name: &str) -> ReadOptions {
    ReadOptions {
        channel: Some(name.into()),
        ..ReadOptions::default()
    }
}

fn time_column(name: &str) -> ReadOptions {
    ReadOptions {
        time_column: Some(name.into()),
        ..ReadOptions::default()
    }
}

fn rate(hertz: f64) -> ReadOptions {
    ReadOptions {
        rate_hz: Some(hertz),
        ..in_g()
    }
}

/// Of a table without names: where it begins, and which column holds the times.
fn unnamed(time_column: Option<&str>) -> ReadOptions {
    ReadOptions {
        skip_lines: Some(0),
        time_column: time_column.map(String::from),
        ..in_g()
    }
}

/// Checks the whole message up to `fragment`'s end: `place` is what stands between the file
/// name and the message.
#[track_caller]
fn check_refused(bytes: impl Into<Vec<u8>>, options: &ReadOptions, place: &str, fragment: &str) {
    let bytes = bytes.into();
    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).into_owned();
    match read_table(bytes, options, Selection::Lateral) {
        Ok(recording) => panic!("{shown:?} was read: {:?}", recording.channels),
        Err(error) => {
            let message = error.to_string();
            let start = format!("table.csv{place}: ");
            assert!(
                message.starts_with(&start) && message[start.len()..].contains(fragment),
                "{shown:?}\n expected {start}…{fragment}\n found    {message}"
            );
        }
    }
}

const GOOD: &str = "time_s,acc_y_g\n0.0000,0.1\n0.0001,0.2\n0.0002,0.3\n0.0003,0.4\n";

#[track_caller]
fn check_refused_after(find: &str, replace: &str, place: &str, fragment: &str) {
    assert!(GOOD.contains(find));
    check_refused(GOOD.replacen(find, replace, 1), &none(), place, fragment);
}

/// Cells that are no numbers, at their line and column.
#[test]
fn val_bad_cells() {
    check_refused_after(
        "0.2\n",
        "nan\n",
        ":3, column 2",
        "expected a finite number, found `nan`",
    );
    check_refused_after(
        "0.2\n",
        "-NaN\n",
        ":3, column 2",
        "expected a finite number, found `-NaN`",
    );
    check_refused_after(
        "0.2\n",
        "inf\n",
        ":3, column 2",
        "expected a finite number, found `inf`",
    );
    check_refused_after(
        "0.4\n",
        "1e999\n",
        ":5, column 2",
        "expected a finite number, found `1e999`",
    );
    check_refused_after(
        "0.1\n",
        "broken\n",
        ":2, column 2",
        "expected a number, found `broken`",
    );
    check_refused_after(
        "0.2\n",
        "\n",
        ":3, column 2",
        "expected a number, found an empty cell",
    );
    check_refused_after(
        "0.2\n",
        "1_000\n",
        ":3, column 2",
        "expected a number, found `1_000`",
    );
    check_refused_after(
        "0.2\n",
        "0x1F\n",
        ":3, column 2",
        "expected a number, found `0x1F`",
    );
    check_refused_after(
        "0.2\n",
        "1.0D+00\n",
        ":3, column 2",
        "expected a number, found `1.0D+00`",
    );
    check_refused_after("0.2\n", "‒0.2\n", ":3, column 2", "U+2012");
    check_refused_after(
        "0.2\n",
        "\"1,234\"\n",
        ":3, column 2",
        "expected the same decimal mark",
    );
    check_refused_after(
        "0.2\n",
        "0.2 g\n",
        ":3, column 2",
        "expected a number, found `0.2 g`",
    );
    check_refused_after(
        "0.3
",
        "#N/A
",
        ":4, column 2",
        "expected a number, found `#N/A`",
    );
}

/// Time that is none.
#[test]
fn val_bad_time() {
    check_refused_after(
        "0.0002",
        "0.0001",
        ":4, column 1",
        "expected a time after 0.0001 s, found 0.0001 s",
    );
    check_refused_after(
        "0.0003",
        "0.00005",
        ":5, column 1",
        "expected a time after 0.0002 s, found 0.00005 s",
    );
    check_refused_after(
        "0.0002",
        "nan",
        ":4, column 1",
        "expected a finite number, found `nan`",
    );
    check_refused_after(
        "0.0002",
        "",
        ":4, column 1",
        "expected a number, found an empty cell",
    );
    check_refused_after(
        "time_s",
        "x_s",
        "",
        "no time column by name; `x_s` rises by 0.0001 a row, 10000 Hz if in seconds",
    );
    check_refused_after(
        "time_s",
        "Time (ticks)",
        "",
        "expected a known unit of time, such as s, ms, 10 us or day, found `Time (ticks)`; state its unit with the setting `time_unit` = s|ms|us|ns|min|h|day, or with a number before it, such as 10us, or the rate with the setting `rate_hz` = HZ",
    );
    check_refused(
        "date_time,a_g\n2020-01-01 10:00:00,1\n2020-01-01 10:00:01,2\n2020-01-32 10:00:02,2\n",
        &none(),
        ":4, column 1",
        "expected a time that latchgate reads, found `2020-01-32 10:00:02`; export times as seconds, 10:00:00.0001",
    );
    check_refused(
        "date_time,a_g\n1 o'clock,1\n2 o'clock,2\n",
        &none(),
        ":2, column 1",
        "expected a time that latchgate reads, found `1 o'clock`",
    );
    check_refused(
        "time_1,a_g,time_2\n0,1,0\n1,2,1\n",
        &none(),
        "",
        "expected one time column, found time_1, time_2; choose one with the setting `time_column` = NAME",
    );
    check_refused(
        GOOD,
        &time_column("tiem_s"),
        "",
        "unknown time column `tiem_s`; did you mean `time_s`?",
    );
    check_refused(GOOD, &time_column("9"), "", "unknown time column `9`");
    check_refused(
        GOOD,
        &rate(5000.0),
        "",
        "expected the stated rate of 5000 Hz, found 10000 Hz by the time column `time_s`",
    );
    check_refused(
        "a\n1\n2\n",
        &rate(-1.0),
        "",
        "sample rate [Hz] must be finite and positive, found -1",
    );
    check_refused(
        "0,1.5\n1,1.5\n2,2.5\n",
        &unnamed(None),
        "",
        "no time column and no sample rate",
    );
    check_refused(
        "1.5\n2.5\n3.5\n",
        &unnamed(None),
        "",
        "no time column and no sample rate",
    );
    check_refused(
        "time_s,a_g\n0.0,1\n",
        &none(),
        "",
        "a time base needs at least 2 samples, found 1",
    );
    check_refused(
        "a\n1\n",
        &rate(1e4),
        "",
        "a recording needs at least 2 samples, found 1",
    );
    check_refused(
        "time_s,a_g\n0,1\n1e-4,1\n2e-4,1\n1e9,1\n",
        &none(),
        "",
        "limit samples of 8000000 crossed: found 10000000000001 samples on a uniform time base (a gap in time: after 0.0002 s on the file's clock the next sample comes 1000000000 s later",
    );
    // A step back in a headerless file is told where it is, not as a missing time column.
    let mut rows: Vec<String> = (0..40)
        .map(|i| format!("{:.4}\t{}.5", f64::from(i) * 1e-4, i))
        .collect();
    rows[20] = "0.0001\t1.5".into();
    check_refused(
        rows.join("\n"),
        &unnamed(Some("1")),
        ":21, column 1",
        "expected a time after 0.0019 s, found 0.0001 s",
    );
}

/// Rows and headers that do not fit.
#[test]
fn val_bad_shape() {
    check_refused_after(
        "0.0002,0.3",
        "0.0002",
        ":4",
        "expected 2 cells as in the rows before, found 1; correct the row",
    );
    check_refused_after(
        "0.0002,0.3",
        "0.0002,0.3,7",
        ":4",
        "expected 2 cells as in the rows before, found 3",
    );
    check_refused(
        "# one\n\n  # two\ntime_s,a_g\n0.0,1\n\n# three\n0.1\n",
        &none(),
        ":8",
        "found 1; correct the export; if the table ends on line 5, state the setting `last_line` = 5",
    );
    check_refused(
        "time_s,a_g,b_g\n0.0,1\n0.1,2\n",
        &none(),
        ":1",
        "expected as many header cells as the rows have, found 3 header cells over rows of 2",
    );
    check_refused(
        "a\n0,5\n0,6\n",
        &rate(1e4),
        ":1",
        "expected as many header cells as the rows have, found 1 header cells over rows of 2",
    );
    check_refused(
        "time_s,a_g\n0.0,1,2\n0.1,2,3\n",
        &none(),
        ":1",
        "expected as many header cells as the rows have, found 2",
    );
    check_refused(
        "time_s,a_g\n0.0,1,\n0.1,2,3\n",
        &none(),
        ":3, column 3",
        "expected nothing after the last column, found `3`",
    );
    check_refused(
        "Test 7\n\nwhen,a_g\n0.0,1\n",
        &none(),
        ":3",
        "expected numbers or a row of units after the header, found `when`; the column names seem to be on line 3",
    );
    check_refused(
        "time,a\ns,g\nleft,right\n0.0,1\n",
        &none(),
        ":3",
        "expected numbers after names and units, found `left`",
    );
    check_refused(
        "time_s,a_g\ns,m/s2\n0.0,1\n0.1,1\n",
        &none(),
        ", channel a_g",
        "no unit of acceleration is clear from header, units row or card",
    );
    check_refused(
        "0,5\n1,7\n2,6\n",
        &rate(1e4),
        ":1",
        "two columns of numbers without names; state the setting `skip_lines` = 0 and the setting `channel` = 1|2",
    );
    check_refused(
        "0,5\n1,7\n2,6\n",
        &in_g(),
        ":1",
        "state the setting `skip_lines` = 0, the setting `rate_hz` = HZ and the setting `channel` = 1|2",
    );
    check_refused(
        "t;a_g\n0,000;1.5\n0,001;2.5\n",
        &none(),
        ":2, column 2",
        "expected the same decimal mark in all numbers, found `1.5`",
    );
    check_refused(
        "t;a_g\n0;1.234,5\n1;2.345,6\n",
        &none(),
        ":2, column 2",
        "expected a number, found `1.234,5`",
    );
    check_refused(
        "time_s,\"a\ng\"\n0.0,1\n0.1,2\n",
        &none(),
        ":1",
        "expected a quoted cell to end on its line",
    );
    check_refused_after(
        "0.3\n",
        "\"0.3\n",
        ":4",
        "expected a quoted cell to end on its line",
    );
    check_refused(
        "time_s,acc_y_g\n0.0,\"1\"\n0.1,\"2.5\"\n0.2,\"12",
        &none(),
        ":4",
        "expected a quoted cell to end on its line",
    );
}

/// Files without content, and files of something else.
#[test]
fn val_bad_content() {
    check_refused("", &none(), "", "the file is empty; expected a recording");
    check_refused(
        "\n\n\n",
        &none(),
        "",
        "the file holds no rows; expected rows of numbers",
    );
    check_refused(
        "# only\n% words\n// here\n",
        &none(),
        "",
        "the file holds no rows",
    );
    check_refused(
        "time_s,acc_y_g\n",
        &none(),
        "",
        "the file holds a header and no rows",
    );
    check_refused(
        "time,acc_y\ns,g\n",
        &none(),
        "",
        "the file holds a header and no rows",
    );
    check_refused(
        ",,,\n,,,\n",
        &none(),
        ":2",
        "expected numbers or a row of units",
    );
    check_refused(
        "Call me Ishmael.\nSome years ago\n",
        &none(),
        ":2",
        "expected numbers or a row of units",
    );
    check_refused("{\"a\": [1, 2]}\n", &none(), "", "this is JSON");
    check_refused(
        "<html><body>404</body></html>\n",
        &none(),
        "",
        "the file holds a header and no rows",
    );
    check_refused(
        b"\x7FELF\x02\x01\x01\x00".to_vec(),
        &none(),
        "",
        "unknown format (",
    );
    check_refused(
        b"t\x00i\x00m\x00e\x00".to_vec(),
        &none(),
        "",
        "UTF-16 text without its byte order mark, which latchgate does not read; save it as UTF-8",
    );
    check_refused(
        b"MDF     4.11".to_vec(),
        &none(),
        "",
        "this is ASAM MDF4, which latchgate does not read",
    );
    check_refused(b"PK\x03\x04....".to_vec(), &none(), "", "save the sheet");
    let named = ReadOptions {
        input_format: Some("csv".into()),
        ..none()
    };
    check_refused(
        b"time_s,a_g\n0,1\n1,\x002\n".to_vec(),
        &named,
        ":3",
        "expected text, found a NUL character",
    );
    check_refused(
        b"\xFF\xFEt\x00;\x00a".to_vec(),
        &none(),
        ":1",
        "expected UTF-16, as the file is marked",
    );
    check_refused(
        b"\xFF\xFEt\x00\n\x00\x00\xD8a\x00".to_vec(),
        &none(),
        ":2",
        "expected UTF-16",
    );
    check_refused(
        b"\xEF\xBB\xBFtime_s,a_g\n0,\xFF\n".to_vec(),
        &none(),
        ":2",
        "expected UTF-8, as the file is marked",
    );
}

/// Channels that are not there or not clear, and units that nothing states.
#[test]
fn val_bad_choice() {
    let wide = "time_s,ay_left (g),ay_right (g),t_oil (°C)\n0.0,1,2,3\n0.1,4,5,6\n";
    check_refused(
        wide,
        &none(),
        "",
        "several channels could be the lateral acceleration: ay_left (g), ay_right (g); choose one",
    );
    check_refused(
        wide,
        &channel("ay"),
        "",
        "no channel `ay`; the recording holds: time_s, ay_left (g), ay_right (g), t_oil (°C)",
    );
    check_refused(wide, &channel("0"), "", "no channel `0`");
    check_refused(wide, &channel("5"), "", "no channel `5`");
    check_refused(wide, &channel(""), "", "no channel ``");
    check_refused(
        wide,
        &channel("1"),
        "",
        "expected a channel of acceleration, found the time column `time_s`",
    );
    check_refused(
        wide,
        &channel("t_oil"),
        ", channel t_oil (°C)",
        "expected a unit of acceleration, found `°C` in the header of `t_oil (°C)`",
    );
    check_refused(
        "time_s,a,a\n0.0,1,2\n0.1,4,5\n",
        &channel("a"),
        "",
        "expected one column `a`, found a (column 2), a (column 3); choose it by number",
    );
    check_refused(
        "time_s,p,q\n0.0,1,2\n0.1,4,5\n",
        &in_g(),
        "",
        "each with its doubt: p (`p` is no known word), q (`q` is no known word)",
    );
    check_refused(
        "time_s\n0.0\n0.1\n",
        &in_g(),
        "",
        "no channel carries a lateral acceleration",
    );
    check_refused(
        "# unit: g\nt,a\n0.0,1\n0.1,4\n",
        &none(),
        ", channel a",
        "no unit of acceleration is clear from header, units row or card; state the setting `unit` = g|mg|m/s2|cm/s2|mm/s2|mm/ms2|ft/s2|in/s2|kilo-g",
    );
    check_refused(
        "0.0 1.5\n0.1 2.5\n",
        &ReadOptions {
            unit: None,
            ..unnamed(Some("1"))
        },
        ", channel column 2",
        "no unit of acceleration",
    );
    let format = ReadOptions {
        input_format: Some("cvs".into()),
        ..none()
    };
    check_refused(
        GOOD,
        &format,
        "",
        "unknown input format `cvs`; did you mean `csv`?",
    );
}

#[track_caller]
fn check_limit(bytes: Vec<u8>, limits: &Limits, selection: Selection, name: &str) {
    let source = Source::bytes("table.csv", bytes);
    let options = unnamed(Some("1"));
    let error = latchgate_recording::read(&source, &options, selection, limits).unwrap_err();
    match error.kind() {
        ErrorKind::LimitExceeded { limit, .. } => assert_eq!(*limit, name),
        other => panic!("expected limit {name}, found {other}"),
    }
}

/// Files made to cost memory end at a limit, before the table reader counts their cells.
#[test]
fn val_limits_hold() {
    let limits = Limits::default();
    let lateral = Selection::Lateral;
    check_limit(vec![b','; 8 << 20], &limits, lateral, "line_bytes");
    check_limit(vec![b','; 1 << 16], &limits, lateral, "columns");
    check_limit("1 ".repeat(5000).into_bytes(), &limits, lateral, "columns");
    check_limit(
        "1;2\n".repeat(2 << 20).into_bytes(),
        &Limits {
            text_bytes: 4 << 20,
            ..Limits::default()
        },
        lateral,
        "text_bytes",
    );
    let mut rows = String::new();
    for i in 0..2000 {
        rows.push_str(&format!("{};1\n", i * 2));
    }
    let few = Limits {
        samples: 1000,
        ..Limits::default()
    };
    check_limit(rows.clone().into_bytes(), &few, lateral, "samples");
    let cells = Limits {
        table_cells: 1000,
        ..Limits::default()
    };
    check_limit(rows.into_bytes(), &cells, Selection::Every, "table_cells");
    // Quotes that would join many lines to one record of millions of cells.
    let joined = format!(
        "t;a\n\"{}",
        format!("\n\";{};\"", ";".repeat(4000)).repeat(200)
    );
    check_refused(
        joined,
        &in_g(),
        ":2",
        "expected a quoted cell to end on its line",
    );
}

/// Valid files with random bytes changed, dropped or doubled never panic; where they are still
/// read, every sample is finite and time runs on.
#[test]
fn prop_mutated_files_never_panic() {
    let seeds: [(&str, ReadOptions); 5] = [
        (GOOD, none()),
        (
            "# x\nZeit;ay\ns;g\n0,0000;1,5\n0,0001;-2,5\n0,0002;3,5E0\n0,0003;0\n",
            none(),
        ),
        (
            "\"Time (ms)\"\t\"acc y (g)\"\t\"b\"\n0.0\t1\t2\n0.1\t2\t3\n0.2\t3\t4\n",
            none(),
        ),
        (
            "-0.020000\t-1.659300\n-0.019920\t2.324930\n-0.019840\t3.357030\n",
            unnamed(Some("1")),
        ),
        (
            "1 2 3\n4 5 6\n7 8 9\n",
            ReadOptions {
                channel: Some("2".into()),
                time_unit: Some(TimeUnit::MICROSECOND),
                ..unnamed(Some("1"))
            },
        ),
    ];
    const BYTES: &[u8] = b"0123456789.,;\t \n\r\"'#%-+eE/\x00\x1a\x7f\x80\xc3\xffagmsN()[]";
    let seed = 2_024;
    let mut random = Random(seed);
    let mut read = 0;
    let rounds = 4000;
    for round in 0..rounds {
        let (text, options) = &seeds[round % seeds.len()];
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..=random.below(4) {
            if bytes.is_empty() {
                break;
            }
            let place = random.below(bytes.len());
            match random.below(6) {
                0 => {
                    bytes.remove(place);
                }
                1 => bytes.insert(place, BYTES[random.below(BYTES.len())]),
                2 => {
                    let end = (place + 1 + random.below(12)).min(bytes.len());
                    let part = bytes[place..end].to_vec();
                    bytes.splice(place..place, part);
                }
                3 => bytes.truncate(place),
                4 => bytes[place] = (random.next() & 0xFF) as u8,
                _ => bytes[place] = BYTES[random.below(BYTES.len())],
            }
        }
        let selection = if random.below(3) == 0 {
            Selection::Every
        } else {
            Selection::Lateral
        };
        if let Ok(recording) = read_table(bytes.clone(), options, selection) {
            read += 1;
            for channel in &recording.channels {
                let shown = String::from_utf8_lossy(&bytes);
                assert!(
                    channel.values.len() >= 2,
                    "seed {seed} round {round}: {shown}"
                );
                assert!(
                    channel.values.iter().all(|v| v.is_finite()),
                    "seed {seed} round {round}: {shown}"
                );
                assert!(
                    channel.start_s.is_finite(),
                    "seed {seed} round {round}: {shown}"
                );
            }
        }
    }
    assert!(
        read > rounds / 20,
        "only {read} of {rounds} were read, so little was tried"
    );
    assert!(read < rounds * 19 / 20, "{read} of {rounds} were read");
}

/// Looking up the line of each repeated row took minutes.
#[test]
fn regress_a_row_repeated_very_often_is_read_in_one_pass() {
    let text = format!(
        "t_s,acc_y_g\n0.000,1\n{}0.002,1\n",
        "0.001,1\n".repeat(300_000)
    );
    let table = read_table(text, &none(), Selection::Lateral).unwrap();
    assert_eq!(table.channels[0].values.len(), 3);
}
