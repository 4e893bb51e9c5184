//! LabVIEW measurement files.

use super::{Case, FROM, TO, g, good, numbers, refused, s, to_and_fro};

/// What a file says of itself and how its rows look.
struct Lvm {
    columns: &'static str,
    decimal: &'static str,
    samples: &'static str,
    delta: &'static str,
    unit: &'static str,
    names: [&'static str; 2],
    comma: bool,
    stamp: fn(i64) -> String,
    remark: fn(i64) -> &'static str,
}

/// A force and the lateral acceleration, with a time column before both.
const PLAIN: Lvm = Lvm {
    columns: "One",
    decimal: "Decimal_Separator\t.\n",
    samples: "800",
    delta: "1.0E-4",
    unit: "g",
    names: ["Force", "acc y"],
    comma: false,
    stamp: s,
    remark: |_| "",
};

impl Lvm {
    fn text(&self) -> String {
        let pair = |key: &str, one: &str, two: &str| match self.columns {
            "Multi" => format!("{key}\t{one}\t\t{two}\t\n"),
            _ => format!("{key}\t{one}\t{two}\t\n"),
        };
        let mut text = format!(
            "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\n{}Multi_Headings\tYes\nX_Columns\t{}\nTime_Pref\tRelative\nDate\t2020/01/01\nTime\t09:51:39,19705\n***End_of_Header***\t\n\t\n",
            self.decimal, self.columns
        );
        text += &pair("Channels", "2", "");
        text += &pair("Samples", self.samples, self.samples);
        text += &pair("Y_Unit_Label", "N", self.unit);
        text += &pair("X_Dimension", "Time", "Time");
        text += &pair("X0", "-2.0E-2", "-2.0E-2");
        text += &pair("Delta_X", self.delta, self.delta);
        text += "***End_of_Header***\t\t\t\n";
        text += &match self.columns {
            "Multi" => format!(
                "X_Value\t{}\tX_Value\t{}\tComment\n",
                self.names[0], self.names[1]
            ),
            _ => format!("X_Value\t{}\t{}\tComment\n", self.names[0], self.names[1]),
        };
        for k in FROM..TO {
            let stamp = (self.stamp)(k);
            let row = match self.columns {
                "No" => format!("\t{}\t{}", g(k + 9), g(k)),
                "Multi" => format!("{stamp}\t{}\t{stamp}\t{}", g(k + 9), g(k)),
                _ => format!("{stamp}\t{}\t{}", g(k + 9), g(k)),
            };
            text += &row;
            let remark = (self.remark)(k);
            if !remark.is_empty() {
                text += &format!("\t{remark}");
            }
            text.push('\n');
        }
        if self.comma {
            let data = text.find("X_Value").unwrap();
            let (head, rows) = text.split_at(data);
            text = head.to_string() + &rows.replace('.', ",");
        }
        text
    }
}

fn read(name: &str, file: &Lvm) -> Case {
    good(name, file.text()).channel("acc y")
}

/// The unit of times that the header states, and files without times.
fn clocks() -> Vec<Case> {
    let labelled = |columns: &'static str, label: &str, per_second: f64, delta: &'static str| {
        let file = Lvm {
            columns,
            delta,
            ..PLAIN
        };
        let text = file.text().replace(
            "X0\t-2.0E-2\t-2.0E-2",
            &format!(
                "X_Unit_Label\t{label}\t{label}\nX0\t{0}\t{0}",
                -0.02 * per_second
            ),
        );
        (FROM..TO).fold(text, |text, k| {
            let stamp = format!("{:.4}", k as f64 / 1e4 * per_second);
            text.replacen(&format!("\n{}\t", s(k)), &format!("\n{stamp}\t"), 1)
        })
    };
    let read = |name: &str, text: String| good(name, text).channel("acc y");
    let mut cases = vec![
        read("ms.lvm", labelled("One", "ms", 1e3, "0.1")),
        read(
            "ms-no-column.lvm",
            labelled("No", "Milliseconds", 1e3, "0.1"),
        ),
        read("us.lvm", labelled("One", "usec", 1e6, "100")),
        read("s.lvm", labelled("One", "s", 1.0, "1.0E-4")),
        refused(
            "fortnights.lvm",
            labelled("One", "fortnights", 1e3, "0.1"),
            &["X_Unit_Label `fortnights`", "--time-unit"],
        ),
        read(
            "fortnights-told.lvm",
            labelled("One", "fortnights", 1e3, "0.1"),
        )
        .options(&["--time-unit", "ms"])
        .finds(&["warning time-unit-overridden"]),
        read("unit-told.lvm", labelled("One", "s", 1e3, "0.1"))
            .options(&["--time-unit", "ms"])
            .finds(&["warning time-unit-overridden"]),
    ];
    // Delta_X is 1 where no timing was attached, and the first column counts.
    let counted = |columns: &'static str| {
        let file = Lvm {
            columns,
            delta: "1.000000",
            ..PLAIN
        };
        let text = file.text().replace("X0\t-2.0E-2\t-2.0E-2", "X0\t0.0\t0.0");
        (FROM..TO).fold(text, |text, k| {
            let count = format!("{}.000000", k - FROM);
            text.replacen(&format!("\n{}\t", s(k)), &format!("\n{count}\t"), 1)
        })
    };
    for columns in ["One", "No", "Multi"] {
        let text = match columns {
            "Multi" => (FROM..TO).fold(counted(columns), |text, k| {
                let count = format!("\t{}.000000\t", k - FROM);
                text.replacen(
                    &format!("\t{}\t{}\n", s(k), g(k)),
                    &format!("{count}{}\n", g(k)),
                    1,
                )
            }),
            _ => counted(columns),
        };
        let untimed = read(&format!("untimed-{columns}.lvm"), text.clone());
        cases.push(
            untimed
                .options(&["--rate-hz", "10000", "--time-zero", "0.02"])
                .finds(&["warning timing-absent"]),
        );
        cases.push(
            read(&format!("untimed-slow-{columns}.lvm"), text)
                .clock(1.0, 0.0)
                .unusable(
                    &[
                        "blocking low-rate",
                        "warning timing-absent",
                        "warning rate-below-default-filter",
                        "warning implausible-velocity",
                        "warning no-pre-event-data",
                    ],
                    &["250 Hz"],
                ),
        );
    }
    cases
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = tables();
    cases.extend(clocks());
    cases
}

fn tables() -> Vec<Case> {
    let plain = PLAIN.text();
    let no_time = Lvm {
        columns: "No",
        ..PLAIN
    }
    .text();
    let row = |k: i64| format!("\t{}\t{}\n", g(k + 9), g(k));
    // What else stands in the X_Value column, or in the first header.
    let with_cells = |text: &str, cell: fn(i64) -> String| {
        (FROM..TO).fold(text.to_string(), |text, k| {
            text.replacen(
                &format!("\n{}", row(k)),
                &format!("\n{}{}", cell(k), row(k)),
                1,
            )
        })
    };
    let spoken = |words: &str| plain.replace("Date\t", &format!("{words}Date\t"));
    let grouped = |decimal| {
        let cell = |k: i64| {
            let whole = format!("{:.0}", super::push(k) * 9_806.65);
            match whole.trim_start_matches('-').len() {
                0..=3 => whole,
                _ => format!(
                    "{},{}",
                    &whole[..whole.len() - 3],
                    &whole[whole.len() - 3..]
                ),
            }
        };
        let file = Lvm {
            columns: "No",
            unit: "mm/s2",
            decimal,
            ..PLAIN
        };
        let text = file.text();
        let head = &text[..text.find(&row(FROM)).unwrap()];
        (FROM..TO).fold(head.to_string(), |text, k| {
            text + &format!("\t1.5\t{}\n", cell(k))
        })
    };
    vec![
        read("one.lvm", &PLAIN),
        read(
            "no-time.lvm",
            &Lvm {
                columns: "No",
                ..PLAIN
            },
        ),
        read(
            "multi.lvm",
            &Lvm {
                columns: "Multi",
                ..PLAIN
            },
        ),
        read(
            "comma.lvm",
            &Lvm {
                decimal: "Decimal_Separator\t,\n",
                comma: true,
                ..PLAIN
            },
        )
        .finds(&["info decimal-comma"]),
        // The Time line has a comma, the data have points, and nothing is declared.
        read(
            "mark-undeclared.lvm",
            &Lvm {
                decimal: "",
                ..PLAIN
            },
        ),
        read(
            "mark-contradicted.lvm",
            &Lvm {
                decimal: "Decimal_Separator\t,\n",
                ..PLAIN
            },
        )
        .finds(&["warning decimal-contradicted"]),
        good("crlf.lvm", plain.replace('\n', "\r\n")).channel("acc y"),
        good(
            "latin-1.lvm",
            plain
                .replace("Date\t", "Notes\tat 20 °C\nDate\t")
                .chars()
                .map(|c| u8::try_from(u32::from(c)).unwrap())
                .collect::<Vec<u8>>(),
        )
        .channel("acc y")
        .finds(&["info encoding-assumed", "info laboratory-remark"]),
        // Rows beyond those announced are samples all the same; that something is amiss is said.
        read(
            "more-rows.lvm",
            &Lvm {
                samples: "700",
                ..PLAIN
            },
        )
        .finds(&["warning count-contradicted"]),
        read(
            "one-announced.lvm",
            &Lvm {
                samples: "1",
                ..PLAIN
            },
        )
        .finds(&["warning count-contradicted"]),
        // Rows that were announced and are not there may hold the crash.
        read(
            "fewer-rows.lvm",
            &Lvm {
                samples: "25600",
                ..PLAIN
            },
        )
        .unusable(&["blocking samples-missing"], &["25600"]),
        refused(
            "names-missing.lvm",
            plain.replace("X_Value\tForce\tacc y\tComment\n", ""),
            &["channels' names", "a row of numbers", "--input-format"],
        ),
        good("first-name.lvm", plain.replace("X_Value", "Time")).channel("acc y"),
        // The time column counts where Delta_X says otherwise.
        read(
            "delta.lvm",
            &Lvm {
                delta: "1.0",
                ..PLAIN
            },
        )
        .finds(&["warning rate-contradicted"]),
        read(
            "irregular.lvm",
            &Lvm {
                stamp: |k| format!("{:.7}", k as f64 / 1e4 + to_and_fro(k) * 1e-6),
                ..PLAIN
            },
        )
        .samples(799)
        .finds(&["warning time-irregular"]),
        read(
            "ms2.lvm",
            &Lvm {
                unit: "m/s^2",
                ..PLAIN
            },
        )
        .unit("m/s2", g)
        .exit(3)
        .finds(&["warning implausible-peak", "warning implausible-velocity"]),
        // Only its unit tells, so that a person chooses it.
        refused(
            "by-unit.lvm",
            Lvm {
                names: ["Force", "Response"],
                ..PLAIN
            }
            .text(),
            &["Response (`response`)", "--channel Response"],
        ),
        refused(
            "no-unit.lvm",
            Lvm { unit: "", ..PLAIN }.text(),
            &["no unit of acceleration", "--unit"],
        ),
        refused(
            "two.lvm",
            Lvm {
                names: ["acc y", "acc y"],
                ..PLAIN
            }
            .text()
            .replace("Y_Unit_Label\tN\t", "Y_Unit_Label\tg\t"),
            &["several channels", "choose: latchgate replay", "▁"],
        ),
        read(
            "remark.lvm",
            &Lvm {
                remark: |k| if k == 150 { "signal lost" } else { "" },
                ..PLAIN
            },
        )
        .unusable(&["blocking laboratory-remark"], &["signal lost"]),
        // An instant that the record does not reach is no leave to use all of it.
        good(
            "notes-beyond-the-end.lvm",
            plain.replace("Date\t", "Notes\tNO VALID DATA AFTER 64.6 SECONDS\nDate\t"),
        )
        .channel("acc y")
        .unusable(
            &["blocking laboratory-remark"],
            &["lies outside the record"],
        ),
        // What is not understood is passed on.
        read(
            "note.lvm",
            &Lvm {
                remark: |k| if k == 150 { "door opens" } else { "" },
                ..PLAIN
            },
        )
        .finds(&["info laboratory-remark"]),
        // However many remarks come before the one that counts.
        read(
            "many-remarks.lvm",
            &Lvm {
                remark: |k| match k {
                    -100..0 => "noise",
                    150 => "signal lost",
                    _ => "",
                },
                ..PLAIN
            },
        )
        .unusable(&["blocking laboratory-remark"], &["noise"]),
        // Empty cells of a channel that holds nothing are none of the other channel's.
        good(
            "empty-channel.lvm",
            (FROM..TO).fold(
                plain[..plain.find(&s(FROM)).unwrap()]
                    .replace("Samples\t800\t800", "Samples\t0\t800"),
                |text, k| text + &format!("{}\t\t{}\n", s(k), g(k)),
            ),
        )
        .channel("acc y")
        .finds(&["info channels-empty"]),
        refused(
            "word.lvm",
            plain.replace(
                &format!("{}\t{}\t{}\n", s(100), g(109), g(100)),
                &format!("{}\t1.0\tERR\n", s(100)),
            ),
            &["ERR"],
        ),
        refused(
            "empty-cell.lvm",
            plain.replace(
                &format!("{}\t{}\t{}\n", s(100), g(109), g(100)),
                &format!("{}\t1.0\t\n", s(100)),
            ),
            &["empty-cell.lvm:"],
        ),
        refused(
            "one-header.lvm",
            plain[..plain.find("Channels").unwrap()].to_string(),
            &["one-header.lvm"],
        ),
        refused(
            "no-rows.lvm",
            plain[..plain.find(&s(FROM)).unwrap()].to_string(),
            &["no-rows.lvm"],
        ),
        // Two bytes a character, as newer versions write it.
        good(
            "utf-16.lvm",
            format!("\u{feff}{plain}")
                .encode_utf16()
                .flat_map(u16::to_le_bytes)
                .collect::<Vec<u8>>(),
        )
        .channel("acc y"),
        // Whole mm/s² with commas between thousands, where the header declares the point.
        refused(
            "thousands.lvm",
            grouped("Decimal_Separator\t.\n"),
            &["column 3", "thousands"],
        ),
        refused(
            "thousands-undeclared.lvm",
            grouped(""),
            &["column 3", "thousands"],
        ),
        // Without stamps a row without its cell is a sample that is missing.
        refused(
            "empty-row.lvm",
            no_time.replace(&row(100), &format!("\t\t\n{}", row(100))),
            &["without a break"],
        ),
        refused(
            "empty-line.lvm",
            no_time.replace(&row(100), &format!("\n{}", row(100))),
            &["without a break"],
        ),
        refused(
            "first-row-empty.lvm",
            no_time.replace(&row(FROM), &format!("\t\t\n{}", row(FROM))),
            &["without a break"],
        ),
        refused(
            "one-cell-empty.lvm",
            no_time.replace(&row(100), &format!("\t{}\t\n", g(109))),
            &["without a break", "acc y"],
        ),
        // X_Columns No, and a column that may be of stamps all the same: which of the two holds is
        // not known.
        refused(
            "unannounced-rows.lvm",
            with_cells(&no_time, |k| (k - FROM).to_string()),
            &["X_Columns No", "`0`", "--input-format"],
        ),
        refused(
            "unannounced-clock.lvm",
            with_cells(&no_time, s),
            &["X_Columns No", "`-0.0200`"],
        ),
        refused(
            "unannounced-in-part.lvm",
            with_cells(&no_time, |k| if k < 100 { s(k) } else { String::new() }),
            &["X_Columns No", "`-0.0200`"],
        ),
        refused(
            "unannounced-word.lvm",
            no_time.replace(&row(100), &format!("lost{}", row(100))),
            &["column 1", "lost"],
        ),
        refused(
            "rate-incredible.lvm",
            no_time.replace("1.0E-4", "1.0E-6"),
            &["1000000 Hz", "Delta_X"],
        ),
        refused(
            "stamps-incredible.lvm",
            Lvm {
                stamp: |k| format!("{:.7}", k as f64 / 1e6),
                ..PLAIN
            }
            .text(),
            &["1000000 Hz", "time column"],
        ),
        // Words at several places: none silences another.
        good(
            "description-then-notes.lvm",
            spoken("Description\tSensor failed at 10 ms\nNotes\tfine test\n"),
        )
        .channel("acc y")
        .finds(&["info laboratory-remark"])
        .unusable(&["blocking laboratory-remark"], &["Sensor failed"]),
        good(
            "two-notes.lvm",
            spoken("Notes\tsignal lost\nNotes\tfine test\n"),
        )
        .channel("acc y")
        .finds(&["info laboratory-remark"])
        .unusable(&["blocking laboratory-remark"], &["signal lost"]),
        good(
            "note-goes-on.lvm",
            spoken("Notes\tfine test\nbut signal lost\n"),
        )
        .channel("acc y")
        .finds(&["info laboratory-remark"])
        .unusable(&["blocking laboratory-remark"], &["signal lost"]),
        good("operator-says.lvm", spoken("Operator\tmt, cable broken\n"))
            .channel("acc y")
            .unusable(&["blocking laboratory-remark"], &["cable broken"]),
        good(
            "channel-notes.lvm",
            plain.replace("Samples", "Comment\tfine\tsignal lost\t\nSamples"),
        )
        .channel("acc y")
        .unusable(&["blocking laboratory-remark"], &["signal lost"]),
        good(
            "semicolon.lvm",
            plain
                .replace("Separator\tTab", "Separator\tSemicolon")
                .replace('\t', ";"),
        )
        .channel("acc y"),
        good(
            "time-lower-case.lvm",
            plain.replace("X_Dimension\tTime\tTime", "X_Dimension\ttime\ttime"),
        )
        .channel("acc y"),
        good("empty-lines-at-end.lvm", no_time.clone() + "\t\t\n\n").channel("acc y"),
        refused(
            "rate-against-delta.lvm",
            no_time.clone(),
            &["1000000 Hz", "10000 Hz by Delta_X"],
        )
        .options(&["--rate-hz", "1e6"]),
        refused(
            "rate-against-stamps.lvm",
            plain.clone(),
            &["5000 Hz", "10000 Hz by the file's time column"],
        )
        .options(&["--rate-hz", "5000"]),
        good("rate-agrees.lvm", no_time.clone())
            .options(&["--rate-hz", "10000"])
            .channel("acc y"),
        refused(
            "time-column.lvm",
            plain.clone(),
            &["leave out --time-column"],
        )
        .options(&["--time-column", "1"]),
        good("by-number.lvm", plain.clone())
            .options(&["--channel", "1", "--sensitivity", "1 g/N"])
            .channel("Force")
            .values(numbers(|k| g(k + 9)))
            .finds(&["info sensitivity-used", "warning channel-not-lateral"]),
        // A force is none, whatever a person calls it.
        refused(
            "force-as-g.lvm",
            plain.clone(),
            &["`N` in the header", "--sensitivity '20 g/N'"],
        )
        .options(&["--channel", "1", "--unit", "g"]),
    ]
}
