//! Text tables: separators, headers, units, encodings, clocks, and what is no table.

mod doubts;
mod preambles;
mod quantities;
mod units;

use super::{Case, FROM, TO, g, good, numbers, push, refused, s, si, to_and_fro};

/// A header and a row per sample.
fn table(head: &str, row: impl Fn(i64) -> String) -> String {
    let rows: String = (FROM..TO).map(|k| row(k) + "\n").collect();
    format!("{head}\n{rows}")
}

/// Stamp and sample, with a comma between them.
fn plain(head: &str) -> String {
    table(head, |k| format!("{},{}", s(k), g(k)))
}

/// The plain table with the row of sample 100, line 302, changed.
fn with_row(row: &str) -> String {
    let old = format!("\n{},{}\n", s(100), g(100));
    let text = plain("time_s,acc_y_g");
    assert!(text.contains(&old));
    text.replace(&old, &format!("\n{row}\n"))
}

fn comma(text: &str) -> String {
    text.replace('.', ",")
}

fn utf_16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    ("\u{feff}".to_string() + text)
        .encode_utf16()
        .flat_map(bytes)
        .collect()
}

/// Stamps of a clock other than that of the samples' grid.
fn clocked(rate_hz: f64, decimals: usize) -> String {
    table("time_s,acc_y_g", |k| {
        format!("{:.decimals$},{}", k as f64 / rate_hz, g(k))
    })
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = separators();
    cases.extend(headers());
    cases.extend(units());
    cases.extend(encodings());
    cases.extend(clocks());
    cases.extend(channels());
    cases.extend(bad_rows());
    cases.extend(marks());
    cases.extend(doubts::breaks());
    cases.extend(doubts::lost_rows());
    cases.extend(doubts::counts());
    cases.extend(doubts::two_clocks());
    cases.extend(doubts::words_on_samples());
    cases.extend(doubts::odd_cells());
    cases.extend(units::doubtful_units());
    cases.extend(units::doubtful_times());
    cases.extend(other_formats());
    cases.extend(quantities::cases());
    cases.extend(preambles::cases());
    cases
}

fn separators() -> Vec<Case> {
    let padded = |k: i64| format!("  {:>9}   {:>9}", s(k), g(k));
    vec![
        good("comma.csv", plain("time_s,acc_y_g")),
        good("crlf.csv", plain("time_s,acc_y_g").replace('\n', "\r\n")),
        good("cr.csv", plain("time_s,acc_y_g").replace('\n', "\r")),
        good("no-last-newline.csv", plain("time_s,acc_y_g").trim_end()),
        good("cut-in-a-number.csv", {
            let whole = plain("time_s,acc_y_g");
            whole[..whole.len() - 3].to_string()
        })
        .samples(799)
        .unusable(&["blocking samples-missing"], &["is cut"]),
        good(
            "semicolon.csv",
            table("time_s;acc_y_g", |k| format!("{};{}", s(k), g(k))),
        ),
        good(
            "tab.txt",
            table("time_s\tacc_y_g", |k| format!("{}\t{}", s(k), g(k))),
        ),
        good("blanks.asc", table("  time_s   acc_y_g", padded)),
        good(
            "decimal-comma.csv",
            comma(&table("time_s;acc_y_g", |k| format!("{};{}", s(k), g(k)))),
        )
        .finds(&["info decimal-comma"]),
        good(
            "decimal-comma-tab.txt",
            comma(&table("time_s\tacc_y_g", |k| format!("{}\t{}", s(k), g(k)))),
        )
        .finds(&["info decimal-comma"]),
        good(
            "sep-line.csv",
            table("sep=;\ntime_s;acc_y_g", |k| format!("{};{}", s(k), g(k))),
        ),
        good(
            "quoted.csv",
            table("\"time_s\",\"acc_y_g\"", |k| {
                format!("\"{}\",\"{}\"", s(k), g(k))
            }),
        ),
        good(
            "quoted-decimal-comma.csv",
            table("\"time_s\";\"acc_y_g\"", |k| {
                comma(&format!("\"{}\";\"{}\"", s(k), g(k)))
            }),
        )
        .finds(&["info decimal-comma"]),
        good(
            "blank-before-cells.csv",
            table("time_s, acc_y_g", |k| format!("{}, {}", s(k), g(k))),
        ),
        good(
            "empty-last-cells.csv",
            table("time_s;acc_y_g;", |k| format!("{};{};", s(k), g(k))),
        ),
        good(
            "empty-last-cells-of-rows.csv",
            table("time_s;acc_y_g", |k| format!("{};{};", s(k), g(k))),
        ),
        good(
            "exponents.csv",
            table("time_s,acc_y_g", |k| {
                format!("{:.4E},{:.4E}", k as f64 / 1e4, push(k))
            }),
        )
        .unit("g", |k| format!("{:.4E}", push(k))),
        good(
            "plus-signs.csv",
            table("time_s,acc_y_g", |k| {
                format!("{:+.4},{:+.3}", k as f64 / 1e4, push(k))
            }),
        ),
    ]
}

fn headers() -> Vec<Case> {
    vec![
        good(
            "comments.csv",
            plain("# Sled test 12\n# unit: mm/s2\n\ntime_s,acc_y_g"),
        ),
        good(
            "comment-at-end.csv",
            plain("time_s,acc_y_g") + "# end of record\n\n",
        ),
        good("units-row.csv", plain("time,acc_y\ns,g")).channel("acc_y"),
        good("units-row-brackets.csv", plain("time,acc_y\n[s],[g]")).channel("acc_y"),
        good(
            "quoted-name.csv",
            plain("Time (s),\"Acceleration, lateral (g)\""),
        )
        .channel("Acceleration, lateral (g)"),
        good("brackets.csv", plain("t [s],a quer [g]")).channel("a quer [g]"),
        // Whether the first row is a sample, and what its cells are, a person says.
        refused(
            "no-header.csv",
            plain("").trim_start(),
            &["no-header.csv:1", "without names", "--skip-lines 0"],
        )
        .options(&["--unit", "g"]),
        refused(
            "no-header-no-time.csv",
            plain("").trim_start(),
            &["no time column", "--time-column"],
        )
        .options(&["--unit", "g", "--skip-lines", "0"]),
        good("no-header-told.csv", plain("").trim_start())
            .options(&["--unit", "g", "--skip-lines", "0", "--time-column", "1"])
            .channel("column 2")
            .finds(&["info time-unit-assumed"]),
        refused(
            "no-header-no-unit.csv",
            plain("").trim_start(),
            &["no unit of acceleration", "--unit"],
        )
        .options(&["--skip-lines", "0", "--time-column", "1"]),
        // A header of three names over rows of two cells would mislabel each of them.
        refused(
            "header-too-long.csv",
            plain("time_s,acc_x_g,acc_y_g"),
            &["header cells", "found 3", "--skip-lines 1"],
        ),
        good("header-by-number.csv", plain("time_s,acc_x_g,acc_y_g"))
            .options(&["--skip-lines", "1", "--channel", "2", "--time-column", "1"])
            .options(&["--unit", "g"])
            .channel("column 2")
            .finds(&["info time-unit-assumed"]),
        refused(
            "header-too-short.csv",
            table("time_s,acc_y_g", |k| format!("{},{},{}", s(k), g(k), g(k))),
            &["header cells", "found 2"],
        ),
        refused(
            "unit-in-comment-only.csv",
            plain("# unit: g\ntime_s,acc_y"),
            &["no unit of acceleration"],
        ),
        refused(
            "units-contradict.csv",
            plain("time_s,acc_y_g\ns,m/s2"),
            &["no unit of acceleration is clear from", "--unit"],
        ),
        good(
            "index-column.csv",
            table("n,time_s,acc_y_g", |k| {
                format!("{},{},{}", k - FROM, s(k), g(k))
            }),
        ),
        good(
            "index-and-rate.csv",
            table("sample,acc_y_g", |k| format!("{},{}", k - FROM, g(k))),
        )
        .options(&["--rate-hz", "10000", "--time-zero", "0.02"]),
        // Below a preamble the line of the names is found, or an option or card tells it.
        good(
            "preamble.csv",
            plain("Sled 07\nRate,10000\n\ntime_s,acc_y_g"),
        )
        .finds(&["info preamble"]),
        good(
            "preamble-told.csv",
            plain("Sled 07\nRate,10000\n\ntime_s,acc_y_g"),
        )
        .options(&["--header-line", "4"])
        .finds(&["info preamble"]),
        good(
            "preamble-card.csv",
            plain("Sled 07\nRate,10000\n\ntime_s,acc_y_g"),
        )
        .beside("preamble-card.csv.toml", "skip_lines = 3\n")
        .finds(&["info preamble"]),
        refused(
            "preamble-other-line.csv",
            plain("Sled 07\nRate,10000\n\ntime_s,acc_y_g"),
            &["on line 3", "--header-line"],
        )
        .options(&["--header-line", "3"]),
        refused(
            "described.csv",
            plain("time,acc_y\ns,g\nfrom trigger,inner panel"),
            &["described.csv:3", "--header-line 1"],
        ),
        good(
            "described-told.csv",
            plain("time,acc_y\ns,g\nfrom trigger,inner panel"),
        )
        .options(&["--header-line", "1"])
        .channel("acc_y"),
        refused(
            "commented-names.csv",
            plain("#time_s,acc_y_g"),
            &["names seem to be on line 1", "--header-line 1"],
        ),
        good("commented-names-told.csv", plain("#time_s,acc_y_g")).options(&["--header-line", "1"]),
        good("lvm-names.csv", plain("X_Value,acc_y_g")).finds(&["info time-unit-assumed"]),
        good("card.csv", plain("time_s,acc_y"))
            .beside("card.csv.toml", "unit = \"g\"\n")
            .channel("acc_y"),
    ]
}

fn units() -> Vec<Case> {
    let spelled = |name: &str, unit: &str, canonical: &'static str, factor: f64| {
        let text = move |k: i64| format!("{:.7}", push(k) * factor);
        let head = format!("Time (s),acc y ({unit})");
        good(name, table(&head, |k| format!("{},{}", s(k), text(k))))
            .channel(&format!("acc y ({unit})"))
            .unit(canonical, text)
    };
    vec![
        spelled("ms2.csv", "m/s2", "m/s2", 9.806_65),
        spelled("ms-caret.csv", "m/s^2", "m/s2", 9.806_65),
        spelled("ms-superscript.csv", "m/s²", "m/s2", 9.806_65),
        spelled("ms-times.csv", "m/(s*s)", "m/s2", 9.806_65),
        spelled("mms2.csv", "mm/s2", "mm/s2", 9_806.65),
        spelled("mmms2.csv", "mm/ms2", "mm/ms2", 9.806_65e-3),
        spelled("kilo-g.csv", "kilo-g", "kilo-g", 1e-3),
        spelled("fts2.csv", "ft/s2", "ft/s2", 9.806_65 / 0.3048),
        spelled("gs.csv", "G'S", "g", 1.0),
        spelled("capital-g.csv", "G", "g", 1.0),
        refused(
            "gram.csv",
            plain("time_s,acc y (gram)"),
            &["acc y (gram) (by unit or code none is", "--channel"],
        ),
        spelled("millig.csv", "mg", "mg", 1e3),
        // The option counts, and a pass on 294 "g" needs a person's word.
        good(
            "unit-overridden.csv",
            table("time_s,acc_y (m/s2)", |k| format!("{},{}", s(k), si(k))),
        )
        .options(&["--unit", "g"])
        .channel("acc_y (m/s2)")
        .unit("g", si)
        .exit(3)
        .finds(&["warning unit-overridden", "warning implausible-velocity"]),
    ]
}

fn encodings() -> Vec<Case> {
    let text = plain("time_s,acc_y_g");
    let latin = |head: &[u8]| [head, b"\n", text.as_bytes()].concat();
    vec![
        good("bom.csv", format!("\u{feff}{text}")),
        good("utf-16le.csv", utf_16(&text, u16::to_le_bytes)),
        good("utf-16be.csv", utf_16(&text, u16::to_be_bytes)),
        // A Windows ellipsis, which Latin-1 takes for a line end.
        good("windows-1252.csv", latin(b"# door \x85 lateral")).finds(&["info encoding-assumed"]),
        good("latin-1.csv", latin(b"# at 20 \xB0C, T\xFCr")).finds(&["info encoding-assumed"]),
        good(
            "latin-1-name.csv",
            [
                b"time_s,Querbeschl. T\xFCr y [g]\n".as_slice(),
                text.split_once('\n').unwrap().1.as_bytes(),
            ]
            .concat(),
        )
        .channel("Querbeschl. Tür y [g]")
        .finds(&["info encoding-assumed"]),
        // In UTF-8 the same character is two bytes, and no line end either.
        good("next-line.csv", format!("# door \u{85} lateral\n{text}")),
        refused(
            "utf-16-unmarked.csv",
            utf_16(&text, u16::to_le_bytes)[2..].to_vec(),
            &["UTF-16 text without its byte order mark", "UTF-8"],
        ),
        refused(
            "utf-16-cut.csv",
            utf_16(&text, u16::to_le_bytes)[..2001].to_vec(),
            &["UTF-16"],
        ),
    ]
}

fn clocks() -> Vec<Case> {
    let start = |rate: f64| FROM as f64 / rate;
    let irregular = table("time_s,acc_y_g", |k| {
        format!("{:.7},{}", k as f64 / 1e4 + to_and_fro(k) * 1e-6, g(k))
    });
    let mut gap = plain("time_s,acc_y_g");
    let (from, to) = (format!("\n{},", s(120)), format!("\n{},", s(170)));
    gap.replace_range(gap.find(&from).unwrap()..gap.find(&to).unwrap(), "");
    let row = format!("{},{}\n", s(50), g(50));
    let iso = |k: i64| {
        // From 09:59:59.98 on, so that the stamps pass a full hour.
        let ticks = 36_000 * 10_000 + k;
        let (seconds, part) = (ticks.div_euclid(10_000), ticks.rem_euclid(10_000));
        format!(
            "2024-05-01T{:02}:{:02}:{:02}.{part:04}",
            seconds / 3600,
            seconds / 60 % 60,
            seconds % 60
        )
    };
    vec![
        good(
            "ms.csv",
            table("t (ms),acc_y_g", |k| {
                format!("{:.1},{}", k as f64 / 10.0, g(k))
            }),
        ),
        good(
            "us.csv",
            table("time_us,acc_y_g", |k| format!("{},{}", k * 100, g(k))),
        ),
        good(
            "ns.csv",
            table("t [ns],acc_y_g", |k| format!("{},{}", k * 100_000, g(k))),
        ),
        good(
            "time_ns.csv",
            table("time_ns,acc_y_g", |k| format!("{},{}", k * 100_000, g(k))),
        ),
        good(
            "ns-by-option.csv",
            table("t,acc_y_g", |k| format!("{},{}", k * 100_000, g(k))),
        )
        .options(&["--time-unit", "NS"]),
        refused(
            "ns-untold.csv",
            table("t,acc_y_g", |k| format!("{},{}", k * 100_000, g(k))),
            &["Hz by the time column `t`, seconds assumed", "--time-unit"],
        ),
        good(
            "ms-by-option.csv",
            table("t,acc_y_g", |k| format!("{:.1},{}", k as f64 / 10.0, g(k))),
        )
        .options(&["--time-unit", "ms"]),
        good("seconds-assumed.csv", plain("time,acc_y_g")).finds(&["info time-unit-assumed"]),
        // Milliseconds that nothing calls so make a log of 10 Hz.
        good(
            "ms-untold.csv",
            table("t,acc_y_g", |k| format!("{:.1},{}", k as f64 / 10.0, g(k))),
        )
        .clock(10.0, -20.0)
        .unusable(
            &[
                "blocking low-rate",
                "info time-unit-assumed",
                "warning time-unit-implausible",
                "warning rate-below-default-filter",
                "warning implausible-velocity",
            ],
            &["250 Hz"],
        ),
        good(
            "time-unit-overridden.csv",
            table("t (s),acc_y_g", |k| {
                format!("{:.1},{}", k as f64 / 10.0, g(k))
            }),
        )
        .options(&["--time-unit", "ms"])
        .finds(&["warning time-unit-overridden"]),
        good("12khz.csv", clocked(12_000.0, 6)).clock(12_000.0, start(12_000.0)),
        good("9600hz.csv", clocked(9_600.0, 6))
            .clock(9_600.0, start(9_600.0))
            .finds(&["warning rate-below-default-filter"]),
        good("25600hz.csv", clocked(25_600.0, 7))
            .clock(25_600.0, start(25_600.0))
            .exit(3)
            .finds(&["warning implausible-velocity"]),
        good("1024hz.csv", clocked(1024.0, 6))
            .clock(1024.0, start(1024.0))
            .exit(3)
            .finds(&[
                "warning rate-below-default-filter",
                "warning implausible-velocity",
            ]),
        // The step itself was rounded, so the file's clock is not 1024 Hz and is not made so.
        good(
            "rounded-step.csv",
            table("time_s,acc_y_g", |k| {
                format!("{:.6},{}", k as f64 * 0.000_977, g(k))
            }),
        )
        .clock(1.0 / 0.000_977, -0.1954)
        .samples(800)
        .exit(3)
        .finds(&[
            "warning rate-below-default-filter",
            "warning implausible-velocity",
        ]),
        good(
            "iso-stamps.csv",
            table("time,acc_y_g", |k| format!("{},{}", iso(k), g(k))),
        )
        .clock(10_000.0, 0.0)
        .finds(&["info time-absolute", "warning no-pre-event-data"]),
        good(
            "iso-stamps-zero.csv",
            table("Timestamp;acc_y_g", |k| {
                format!("{}Z;{}", iso(k).replace('T', " "), g(k))
            }),
        )
        .options(&["--time-zero", "0.02"])
        .finds(&["info time-absolute"]),
        refused(
            "iso-back.csv",
            table("time,acc_y_g", |k| {
                format!("{},{}", iso(if k == 100 { 90 } else { k }), g(k))
            }),
            &[":302", "time must increase"],
        ),
        good("rate.csv", table("acc_y_g", g)).options(&[
            "--rate-hz",
            "10000",
            "--time-zero",
            "0.02",
        ]),
        refused(
            "no-time.csv",
            table("acc_y_g", g),
            &["no time column", "--rate-hz"],
        ),
        refused(
            "rate-contradicts.csv",
            plain("time_s,acc_y_g"),
            &["5000 Hz", "10000 Hz"],
        )
        .options(&["--rate-hz", "5000"]),
        good("time-zero.csv", plain("time_s,acc_y_g"))
            .options(&["--time-zero", "0.001"])
            .clock(10_000.0, -0.021),
        good(
            "rows-repeated.csv",
            plain("time_s,acc_y_g").replace(&row, &row.repeat(3)),
        )
        .finds(&["warning rows-repeated"]),
        refused(
            "stamp-back.csv",
            with_row(&format!("{},1.0", s(0))),
            &[":302", "time must increase"],
        ),
        // Its last stamp lies 5 µs before the 800th instant of a uniform clock.
        good("irregular.csv", irregular)
            .samples(799)
            .finds(&["warning time-irregular"]),
        // 38, 24, 17, 14 ms before a steady 10 ms; the mean of the steps that are no gaps counts.
        good(
            "start-up.csv",
            "time_s,acc_y_g\n0.000,0.1\n0.038,0.2\n0.062,0.1\n0.079,-0.1\n0.093,0.3\n".to_string()
                + &(0..200)
                    .map(|k| {
                        format!(
                            "{:.3},{}\n",
                            0.103 + f64::from(k) * 0.01,
                            g(i64::from(k) - 50)
                        )
                    })
                    .collect::<String>(),
        )
        .clock(99.8, 0.0)
        .samples(209)
        .unusable(
            &[
                "blocking gap",
                "blocking low-rate",
                "warning no-pre-event-data",
                "warning rate-below-default-filter",
                "warning time-irregular",
                "warning implausible-velocity",
                "warning ends-early",
                "blocking ends-inside-event",
            ],
            &["gap"],
        ),
        good("gap.csv", gap)
            .samples(800)
            .unusable(&["blocking gap"], &["gap in time"]),
    ]
}

fn channels() -> Vec<Case> {
    let three = |head: &str| {
        table(head, |k| {
            format!("{},{},{},{}", s(k), g(k + 3), g(k), g(k - 5))
        })
    };
    vec![
        good("xyz.csv", three("time_s,acc_x_g,acc_y_g,acc_z_g")).finds(&["info channel-chosen"]),
        good("by-name.csv", three("time_s,acc_x_g,acc_y_g,acc_z_g"))
            .options(&["--channel", "acc_x_g"])
            .channel("acc_x_g")
            .unit("g", |k| g(k + 3))
            .finds(&["warning channel-not-lateral"]),
        good("by-number.csv", three("time_s,acc_x_g,acc_y_g,acc_z_g"))
            .options(&["--channel", "4"])
            .channel("acc_z_g")
            .unit("g", |k| g(k - 5))
            .finds(&["warning channel-not-lateral"]),
        good(
            "primary.csv",
            three("time_s,acc_y_red (g),acc_y (g),acc_z (g)"),
        )
        .channel("acc_y (g)")
        .finds(&["info channel-chosen"]),
        good(
            "foreign-units.csv",
            three("time_s,angular y (deg/s),acc_y_g,force y (N)"),
        ),
        refused(
            "only-other-axis.csv",
            plain("time_s,acc_x_g"),
            &["no channel is clearly", "acc_x_g (`x`)", "--channel"],
        ),
        refused(
            "only-head.csv",
            plain("time_s,head_acc_y (g)"),
            &[
                "no channel is clearly",
                "head_acc_y (g) (`head`)",
                "--channel",
            ],
        ),
        good("other-axis-named.csv", plain("time_s,acc_x_g"))
            .options(&["--channel", "acc_x_g"])
            .channel("acc_x_g")
            .finds(&["warning channel-not-lateral"]),
        refused(
            "head-and-pillar.csv",
            three("time_s,head_acc_y (g),bpillar_acc_x (g),bpillar_acc_z (g)"),
            &["head_acc_y (g) (`head`)", "--channel"],
        ),
        refused(
            "lateral-unreadable.csv",
            plain("time_s,acc_x_g")
                .replace('\n', ",n/a\n")
                .replacen("n/a", "acc_y_g", 1),
            &["`n/a`", "csv:2, column 3"],
        ),
        refused(
            "two-lateral.csv",
            three("time_s,acc_y_upper (g),acc_y_lower (g),acc_z (g)"),
            &[
                "several channels",
                "acc_y_upper (g)",
                "two-lateral.csv --channel 'acc_y_lower (g)'",
                "▁",
            ],
        ),
        // With gravity and without: only the header tells, and both are named.
        refused(
            "gravity-in-and-out.csv",
            three("Time (s),Acceleration y (m/s^2),Linear Acceleration y (m/s^2),Absolute (m/s^2)"),
            &["several channels", "Linear Acceleration y"],
        ),
        refused(
            "same-names.csv",
            three("time_s,acc_y_g,acc_y_g,acc_z_g"),
            &["--channel"],
        ),
        refused(
            "no-lateral.csv",
            three("time_s,acc_x_g,acc_z_g,temp"),
            &["acc_x_g", "acc_z_g"],
        ),
        refused(
            "no-such-channel.csv",
            plain("time_s,acc_y_g"),
            &["no channel `acc_q_g`", "acc_y_g"],
        )
        .options(&["--channel", "acc_q_g"]),
    ]
}

fn bad_rows() -> Vec<Case> {
    let at = |name: &str, row: &str, says: &[&str]| refused(name, with_row(row), says);
    vec![
        at("nan.csv", "0.0100,nan", &[":302, column 2", "found `nan`"]),
        at(
            "inf.csv",
            "0.0100,-inf",
            &[":302, column 2", "found `-inf`"],
        ),
        at(
            "too-large.csv",
            "0.0100,1e999",
            &[":302, column 2", "`1e999`"],
        ),
        at("word.csv", "0.0100,ERR", &[":302, column 2", "found `ERR`"]),
        at(
            "empty-cell.csv",
            "0.0100,",
            &[":302, column 2", "empty cell"],
        ),
        at(
            "hexadecimal.csv",
            "0.0100,0x1F",
            &[":302, column 2", "`0x1F`"],
        ),
        at("short-row.csv", "0.0100", &[":302", "expected 2 cells"]),
        at(
            "long-row.csv",
            "0.0100,1.0,2.0",
            &[":302", "expected 2 cells"],
        ),
        at("nul.csv", "0.0100,1.0\0", &[":302", "NUL"]),
        at(
            "thousands.csv",
            "0.0100,\"1,234.5\"",
            &[":302, column 2", "1,234.5"],
        ),
        refused(
            "two-marks.csv",
            table("time_s;acc_y_g", |k| format!("{};{}", s(k), g(k)))
                .replace(&format!("\n{};", s(100)), &format!("\n{};", comma(&s(100)))),
            &[":302, column 1", "decimal mark"],
        ),
        // Decimal commas between commas: twice the cells, and no way to tell them apart.
        refused(
            "comma-twice.csv",
            comma(&plain("time_s,acc_y_g")),
            &["header cells", "found 2"],
        ),
        refused("open-quote.csv", with_row("0.0100,\"1.0"), &["302"]),
        refused("empty.csv", "", &["the file is empty"]),
        refused("comments-only.csv", "# a\n# b\n", &["expected"]),
        refused("header-only.csv", "time_s,acc_y_g\n", &["expected"]),
        refused("one-row.csv", "time_s,acc_y_g\n0.0,1.0\n", &["at least"]),
        good("cut.csv", &plain("time_s,acc_y_g")[..9_000])
            .samples(plain("time_s,acc_y_g")[..9_000].matches('\n').count() - 1)
            .unusable(&["blocking samples-missing"], &["is cut"]),
    ]
}

fn other_formats() -> Vec<Case> {
    let head = |name: &str, bytes: &[u8], says: &str| {
        refused(
            name,
            [bytes, &[0; 64]].concat(),
            &[says, "which latchgate does not read"],
        )
    };
    vec![
        head("log.mf4", b"MDF     4.10    ", "ASAM MDF4"),
        head("open.mf4", b"UnFinMF 4.10    ", "ASAM MDF4"),
        head("old.mdf", b"MDF     3.30    ", "ASAM MDF3"),
        head("data.tdms_index", b"TDSh\x0e\0\0\0", "NI TDMS, its index"),
        head(
            "data.xls",
            b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1",
            "legacy Excel",
        ),
        head("data.h5", b"\x89HDF\r\n\x1A\n", "HDF5"),
        head("data.mat", b"MATLAB 5.0 MAT-file, Platform", "MATLAB"),
        // The name lies, the bytes do not.
        head("data.csv", b"MDF     4.10    ", "ASAM MDF4"),
        refused(
            "page.csv",
            "<!DOCTYPE html>\n<html><body>404</body></html>\n",
            &["expected"],
        ),
        refused(
            "object.csv",
            "{\"time\": [0, 1], \"acc\": [0, 1]}\n",
            &["this is JSON"],
        ),
        head("log.ide", b"\x1A\x45\xDF\xA3\x01", "EBML"),
        head("door.chn", b"\x1F\x35\x36\x2C", "DTS SLICEWare"),
        head("sled.bin", b"\x94\x13\0\0", "HBM catman"),
        head("sled.npy", b"\x93NUMPY\x01\0", "NumPy"),
        // Names of columns that begin as other formats do.
        good("logger.csv", plain("LOGG time_s,acc_y_g")).options(&["--time-unit", "s"]),
        good("mdf.csv", plain("MDF   time_s,acc_y_g")).options(&["--time-unit", "s"]),
        good("format.csv", plain("FORMAT  time_s,acc_y_g")).options(&["--time-unit", "s"]),
        good("riff.csv", plain("RIFF time_s,acc_y_g")).options(&["--time-unit", "s"]),
        refused(
            "pointer.csv",
            "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n",
            &["Git LFS", "git lfs pull"],
        ),
        good(
            "date-in-brackets.csv",
            plain("[2024-05-01 10:00:00] log\ntime_s,acc_y_g"),
        ),
        refused(
            "picture.csv",
            b"\x89PNG\r\n\x1A\n\0\0\0\rIHDR\0\0\0\x01".to_vec(),
            &["picture.csv"],
        ),
    ]
}

/// Whole mm/s².
fn whole(k: i64) -> String {
    format!("{:.0}", push(k) * 9_806.65)
}

/// The same with a mark between thousands.
fn grouped(k: i64, mark: char) -> String {
    let text = whole(k);
    let digits = text.trim_start_matches('-');
    match digits.len() {
        0..=3 => text,
        length => {
            let (thousands, rest) = digits.split_at(length - 3);
            format!(
                "{}{thousands}{mark}{rest}",
                &text[..text.len() - digits.len()]
            )
        }
    }
}

/// Marks that are decimal ones, or stand between thousands and make a thousandth of the pulse.
fn marks() -> Vec<Case> {
    let micro = |head: &str, separator: &str, value: &dyn Fn(i64) -> String| {
        table(head, |k| format!("{}{separator}{}", k * 100, value(k)))
    };
    let quoted = |value: &dyn Fn(i64) -> String| {
        table("time_s,acc_y_g", |k| {
            format!("\"{}\",\"{}\"", comma(&s(k)), value(k))
        })
    };
    vec![
        good("whole.csv", micro("time_us;acc_y (mm/s2)", ";", &whole))
            .channel("acc_y (mm/s2)")
            .unit("mm/s2", whole),
        refused(
            "thousands-comma.csv",
            micro("time_us;acc_y (mm/s2)", ";", &|k| grouped(k, ',')),
            &["column 2", "--decimal"],
        ),
        good(
            "thousands-told.csv",
            micro("time_us;acc_y (mm/s2)", ";", &|k| grouped(k, ',')),
        )
        .options(&["--decimal", "."])
        .channel("acc_y (mm/s2)")
        .unit("mm/s2", whole),
        good(
            "thousands-told.txt",
            micro("time_us\tacc_y (mm/s2)", "\t", &|k| grouped(k, '.')),
        )
        .options(&["--decimal", ","])
        .channel("acc_y (mm/s2)")
        .unit("mm/s2", whole)
        .finds(&["info decimal-comma"]),
        refused(
            "thousands-point.txt",
            micro("time_us\tacc_y (mm/s2)", "\t", &|k| grouped(k, '.')),
            &["column 2", "thousands"],
        ),
        // A point between commas may be one between thousands just as well.
        refused(
            "thousands-point.csv",
            micro("time_us,acc_y (mm/s2)", ",", &|k| grouped(k, '.')),
            &["column 2", "thousands"],
        ),
        refused(
            "thousands-in-time.csv",
            table("time_us;acc_y (mm/s2)", |k| {
                let stamp = (k * 100).to_string();
                let (sign, digits) = stamp.split_at(usize::from(k < 0));
                let split = digits.len().saturating_sub(3);
                let stamp = match split {
                    0 => stamp.clone(),
                    _ => format!("{sign}{}.{}", &digits[..split], &digits[split..]),
                };
                format!("{stamp};{}", whole(k))
            }),
            &["column 1", "thousands"],
        ),
        // Quotes hold number and comma together; `-0,0200` has no thousands.
        good("quoted-comma.csv", quoted(&|k| comma(&g(k)))).finds(&["info decimal-comma"]),
        refused(
            "quoted-thousands.csv",
            table("time_us,acc_y (mm/s2)", |k| {
                format!("{},\"{}\"", k * 100, grouped(k, ','))
            }),
            &["column 2", "thousands"],
        ),
        good("sep-capital.csv", plain("SEP=,\ntime_s,acc_y_g")),
        good("sep-quoted.csv", plain("\"sep=,\"\ntime_s,acc_y_g")),
        refused(
            "sep-bar.csv",
            plain("sep=|\ntime_s,acc_y_g").replace(',', "|"),
            &["a comma, semicolon or tab between cells"],
        ),
        refused(
            "numbered-columns.csv",
            plain("0,1"),
            &[":1", "`0` and `1`", "--header-line 1"],
        )
        .options(&["--unit", "g"]),
    ]
}

/// The samples of every table above that is written in g.
#[test]
fn verif_the_samples_of_the_set_rise_and_fall_as_meant() {
    let values = numbers(g);
    let peak = values.iter().copied().fold(f64::MIN, f64::max);
    assert!((peak - 30.05).abs() < 0.05, "{peak}");
    let sum: f64 = values.iter().sum();
    assert!((sum * 9.806_65 / 1e4 - 3.745).abs() < 0.01, "{sum}");
}
