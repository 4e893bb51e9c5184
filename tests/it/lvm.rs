//! LabVIEW measurement files: the dialects that its versions write, and what is refused.

use crate::support::{
    Folder, check_at, check_codes, check_refused, data, one, read_path, with_channel,
};
use latchgate_kernel::units::AccelerationUnit;
use latchgate_recording::error::ErrorKind;
use latchgate_recording::{ReadOptions, Selection, Severity};

#[derive(Clone, Copy)]
struct Dialect {
    time: &'static str,
    decimal: char,
    declared: &'static str,
    samples: &'static str,
    delta: &'static str,
    newline: &'static str,
}

const PLAIN: Dialect = Dialect {
    time: "One",
    decimal: '.',
    declared: "Decimal_Separator\t.\n",
    samples: "300",
    delta: "1.0E-4",
    newline: "\n",
};

fn sample(index: usize) -> f64 {
    ((index * 37) % 101) as f64 - 50.25
}

impl Dialect {
    /// Two channels, `Kraft` [N] and `a quer` [g], 300 samples at 10 kHz from −5 ms on.
    fn write(self) -> Vec<u8> {
        let multi = self.time == "Multi";
        let pair = |value: &str| {
            if multi {
                format!("\t{value}\t\t{value}\t")
            } else {
                format!("\t{value}\t{value}\t")
            }
        };
        let mut text = format!(
            "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\n{}X_Columns\t{}\nTime\t09:51:39,19705\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples{}\nY_Unit_Label{}\nX_Dimension{}\nX0{}\nDelta_X{}\n***End_of_Header***\t\t\t\n",
            self.declared,
            self.time,
            pair(self.samples),
            if multi { "\tN\t\tg\t" } else { "\tN\tg\t" },
            pair("Time"),
            pair("-5.0E-3"),
            pair(self.delta),
        );
        text.push_str(if multi {
            "X_Value\tKraft\tX_Value\ta quer\tComment\n"
        } else {
            "X_Value\tKraft\ta quer\tComment\n"
        });
        for index in 0..300 {
            let stamp = format!("{:.6}", (index as f64 - 50.0) * 1e-4);
            let value = format!("{:.6}", sample(index));
            text.push_str(&match self.time {
                "No" => format!("\t1.5\t{value}\n"),
                "One" => format!("{stamp}\t1.5\t{value}\n"),
                _ => format!("{stamp}\t1.5\t{stamp}\t{value}\n"),
            });
        }
        let (head, table) = text.split_at(text.find("X_Value").unwrap());
        let table = table.replace('.', &self.decimal.to_string());
        format!("{head}{table}")
            .replace('\n', self.newline)
            .into_bytes()
    }
}

#[track_caller]
fn check_dialect(dialect: Dialect, warnings: &[&str]) {
    let folder = Folder::new("lvm-dialect");
    let path = folder.file("a.lvm", dialect.write());
    let (channel, findings) = one(&path, &ReadOptions::default());
    assert_eq!(channel.name, "a quer");
    assert_eq!(channel.unit, Some(AccelerationUnit::StandardGravity));
    assert_eq!((channel.rate.hertz(), channel.start_s), (10_000.0, -0.005));
    let expected: Vec<f64> = (0..300).map(sample).collect();
    assert_eq!(channel.values, expected);
    check_codes(&findings, Severity::Warning, warnings);
    check_codes(&findings, Severity::Blocking, &[]);
}

#[test]
fn val_every_dialect_gives_the_same_samples() {
    check_dialect(PLAIN, &[]);
    let comma = Dialect {
        decimal: ',',
        declared: "Decimal_Separator\t,\n",
        ..PLAIN
    };
    check_dialect(comma, &[]);
    for time in ["No", "One", "Multi"] {
        for newline in ["\n", "\r\n"] {
            check_dialect(
                Dialect {
                    time,
                    newline,
                    ..PLAIN
                },
                &[],
            );
            check_dialect(
                Dialect {
                    time,
                    newline,
                    ..comma
                },
                &[],
            );
        }
    }
    // The header says nothing of the mark, or something else than the numbers.
    check_dialect(
        Dialect {
            declared: "",
            ..comma
        },
        &[],
    );
    check_dialect(
        Dialect {
            declared: "Decimal_Separator\t,\n",
            ..PLAIN
        },
        &["decimal-contradicted"],
    );
    check_dialect(
        Dialect {
            samples: "100",
            ..PLAIN
        },
        &["count-contradicted"],
    );
    // Fewer than stated, and any other number without stamps, are not all that was measured.
    for (time, samples, code) in [
        ("One", "999", "samples-missing"),
        ("Multi", "301", "samples-missing"),
        ("No", "301", "samples-missing"),
        ("No", "299", "count-contradicted"),
        ("No", "many", "statement-unread"),
    ] {
        let text = Dialect {
            time,
            samples,
            ..PLAIN
        };
        let folder = Folder::new("lvm-count");
        let (_, findings) = one(&folder.file("a.lvm", text.write()), &ReadOptions::default());
        check_codes(&findings, Severity::Blocking, &[code]);
    }
    check_dialect(
        Dialect {
            samples: "many",
            ..PLAIN
        },
        &["statement-unread"],
    );
    check_dialect(
        Dialect {
            delta: "1.0",
            ..PLAIN
        },
        &["time-differs"],
    );
}

fn plain() -> String {
    String::from_utf8(PLAIN.write()).unwrap()
}

#[test]
fn val_what_cannot_be_read_is_refused_with_its_place() {
    let folder = Folder::new("lvm-refused");
    let malformed: fn(&ErrorKind) -> bool = |kind| matches!(kind, ErrorKind::Malformed { .. });
    let text = plain();
    let second = format!("{text}Channels\t2\t\n");
    let hole = text.replace("0.010000\t1.5\t", "0.010000\t\t");
    for (content, kind, words) in [
        (second, malformed, vec!["second header", ":317"]),
        (hole, malformed, vec!["without a break", "column 2"]),
        (
            text.replace("Channels\t2", "Channels\t3"),
            malformed,
            vec!["3 channel names"],
        ),
        (
            text.replace("X_Dimension\tTime", "X_Dimension\tFrequency"),
            malformed,
            vec!["Frequency"],
        ),
        (
            text.replace("0.010000\t1.5", "0.010000\tx"),
            malformed,
            vec!["`x`"],
        ),
        (
            text.replace("0.010000\t", "0.009900\t"),
            |kind| matches!(kind, ErrorKind::TimeNotIncreasing { .. }),
            vec![":167"],
        ),
        (
            text.split("X_Value").next().unwrap().to_string(),
            malformed,
            vec!["X_Value"],
        ),
        (
            text.split_inclusive('\n').take(16).collect::<String>(),
            |kind| matches!(kind, ErrorKind::Empty { .. }),
            vec!["no sample"],
        ),
    ] {
        let path = folder.file("a.lvm", content);
        check_refused(&path, &ReadOptions::default(), kind, &words);
    }
    let path = folder.file("a.lvm", plain());
    let words = ["`N`", "`sensitivity`"];
    check_refused(&path, &with_channel("Kraft"), malformed, &words);
    check_refused(
        &path,
        &with_channel("b"),
        |kind| matches!(kind, ErrorKind::NoSuchChannel { .. }),
        &["holds: a quer"],
    );
    assert_eq!(one(&path, &with_channel("2")).0.name, "a quer");
}

/// Words in the last column count from their row on.
#[test]
fn val_words_in_the_comment_column_block_from_their_row_on() {
    let folder = Folder::new("lvm-words");
    let text: String = plain()
        .lines()
        .map(|line| {
            let words = if line.starts_with("0.010000\t") {
                "\tsensor lost"
            } else {
                ""
            };
            format!("{line}{words}\n")
        })
        .collect();
    let path = folder.file("a.lvm", text);
    let (_, findings) = one(&path, &ReadOptions::default());
    if findings
        .iter()
        .any(|finding| finding.severity == Severity::Blocking)
    {
        check_at(&findings, "laboratory-remark", Some(0.01));
    } else {
        panic!("the remark was overlooked: {findings:#?}");
    }
}

/// A file that is cut anywhere, or from which rows were taken, is no whole record: its own number
/// of samples says so, and a last row that is cut where nothing is counted.
#[test]
fn regress_rows_that_are_lost_are_missed() {
    let folder = Folder::new("lvm-lost");
    let blocks = |bytes: &[u8]| {
        let path = folder.file("a.lvm", bytes);
        let Ok(recording) = read_path(&path, &ReadOptions::default(), Selection::Lateral) else {
            return true;
        };
        let findings = recording
            .channels
            .iter()
            .flat_map(|channel| &channel.findings);
        findings
            .into_iter()
            .any(|finding| finding.severity == Severity::Blocking)
    };
    for time in ["One", "No", "Multi"] {
        let whole = Dialect { time, ..PLAIN }.write();
        assert!(!blocks(&whole));
        let rows: Vec<usize> = (0..whole.len()).filter(|at| whole[*at] == b'\n').collect();
        let first = rows[rows.len() - 290];
        for at in (first..whole.len() - 2).step_by(97) {
            assert!(blocks(&whole[..at]), "{time}: cut at byte {at}");
        }
        let (from, to) = (rows[rows.len() - 200], rows[rows.len() - 150]);
        let lost = [&whole[..from], &whole[to..]].concat();
        assert!(blocks(&lost), "{time}: rows taken out");
        // Nothing is counted, and the last number has lost its last digits.
        let text = String::from_utf8(whole).unwrap();
        let uncounted: String = text
            .split_inclusive('\n')
            .filter(|line| !line.starts_with("Samples"))
            .collect();
        let cut = uncounted.trim_end().len() - 2;
        assert!(!blocks(uncounted.trim_end().as_bytes()));
        assert!(
            blocks(&uncounted.as_bytes()[..cut]),
            "{time}: a last row that is cut"
        );
    }
}

/// Files of other people's instruments.
#[test]
fn val_real_files() {
    let options = ReadOptions::default();
    let path = data("recordings/lvm_short.lvm");
    let chosen = ReadOptions {
        channel: Some("Response (Trigger)".into()),
        ..ReadOptions::default()
    };
    let (channel, findings) = one(&path, &chosen);
    assert_eq!(
        (channel.rate.hertz(), channel.values[0]),
        (25_600.0, 1.204792)
    );
    assert_eq!(channel.unit, Some(AccelerationUnit::MetrePerSecondSquared));
    check_at(&findings, "decimal-comma", None);

    let (channel, _) = one(&data("recordings/lvm_no_decimal_separator.lvm"), &options);
    assert_eq!(
        (channel.name.as_str(), channel.rate.hertz()),
        ("ay", 4000.0)
    );
    assert_eq!(channel.values, [-0.028189, -0.031060, -0.013517, -0.021172]);

    let empty = read_path(
        &data("recordings/lvm_with_empty_fields.lvm"),
        &options,
        Selection::Every,
    )
    .unwrap();
    assert_eq!(empty.channels.len(), 3);
    assert!(
        empty
            .findings
            .iter()
            .any(|finding| finding.code == "channels-empty"
                && finding.text.starts_with("4 channels"))
    );

    let path = data("recordings/lvm_with_comments.lvm");
    let irregular = read_path(&path, &options, Selection::Every).unwrap();
    check_codes(
        &irregular.channels[0].findings,
        Severity::Warning,
        &["count-contradicted", "time-differs", "time-irregular"],
    );
    check_codes(
        &irregular.findings,
        Severity::Blocking,
        // One text, first beside the first sample.
        &["laboratory-remark"],
    );
    check_refused(
        &path,
        &options,
        |kind| matches!(kind, ErrorKind::NoChannel { .. }),
        &["Temperatura (°C)"],
    );
}
