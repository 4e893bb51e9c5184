//! Text tables whose rows, counts, clocks and words contradict the samples.

use super::super::{Case, FROM, TO, g, good, refused, s};
use super::{plain, table, with_row};

/// Lines between rows that are none: harmless with stamps, a missing sample without.
pub(super) fn breaks() -> Vec<Case> {
    let broken = |head: &str, row: &dyn Fn(i64) -> String, line: &str| {
        let (before, after) = (format!("{}\n", row(99)), format!("{}\n", row(100)));
        let text = table(head, row);
        let joined = format!("{before}{after}");
        assert_eq!(text.matches(&joined).count(), 1);
        text.replace(&joined, &format!("{before}{line}\n{after}"))
    };
    let stamped = |k: i64| format!("{},{}", s(k), g(k));
    let two = |k: i64| format!("{}\t{}", g(k), g(k + 5));
    let rate = ["--rate-hz", "10000", "--time-zero", "0.02"];
    let mut cases = Vec::new();
    for (name, line) in [
        ("empty", ""),
        ("blanks", "  "),
        ("tabs", "\t"),
        ("comment", "# pause"),
    ] {
        cases.push(good(
            &format!("{name}-with-stamps.csv"),
            broken("time_s,acc_y_g", &stamped, line),
        ));
        cases.push(
            refused(
                &format!("{name}-without-stamps.csv"),
                broken("acc_y_g", &|k| g(k), line),
                &[":302", "no column tells their time"],
            )
            .options(&rate),
        );
        cases.push(
            refused(
                &format!("{name}-in-two-columns.txt"),
                broken("acc_y_g\tacc_x_g", &two, line),
                &[":302", "no column tells their time"],
            )
            .options(&rate),
        );
    }
    cases.push(
        good(
            "breaks-around.csv",
            format!(
                "# sled\n\nacc_y\n\ng\n\n# begin\n{}\n \n# end\n\n",
                table("", g).trim()
            ),
        )
        .channel("acc_y")
        .options(&rate),
    );
    cases.push(
        refused(
            "break-after-first.csv",
            table("", g).trim_start().replacen('\n', "\n\n", 1),
            &[":2", "no column tells their time"],
        )
        .options(&rate)
        .options(&["--unit", "g", "--skip-lines", "0"]),
    );
    cases
}

/// Rows that look like comments: cells that a spreadsheet damaged, and rows put behind a `#`.
pub(super) fn lost_rows() -> Vec<Case> {
    let rate = ["--rate-hz", "10000", "--time-zero", "0.02"];
    let mut cases = Vec::new();
    for (index, cell) in [
        "########", "##", "#NUM!", "#DIV/0!", "#N/A", "#VALUE!", "#REF!", "#NAME?", "#NULL!",
        "#WERT!", "#NV", "#NÚM!",
    ]
    .iter()
    .enumerate()
    {
        let says = [
            ":302, column 1",
            cell,
            "widen the column or correct the cell",
        ];
        cases.push(refused(
            &format!("damaged-stamp-{index}.csv"),
            with_row(&format!("{cell},{}", g(100))),
            &says,
        ));
        // The samples first, and no more after them.
        let swapped = table("acc_y_g\ttime_s", |k| {
            let sample = if k < 100 { g(k) } else { (*cell).to_string() };
            format!("{sample}\t{}", s(k))
        });
        cases.push(refused(
            &format!("damaged-to-the-end-{index}.txt"),
            swapped,
            &says,
        ));
        let blanks = table("acc_y_g time_s", |k| {
            let sample = if k == 100 { (*cell).to_string() } else { g(k) };
            format!(" {sample} {}", s(k))
        });
        cases.push(refused(
            &format!("damaged-between-blanks-{index}.txt"),
            blanks,
            &says,
        ));
        for (place, row) in [("start", FROM), ("end", TO - 1), ("open-end", TO - 1)] {
            let line = format!(":{}, column 1", row - FROM + 2);
            let sample = |k| if k == row { (*cell).to_string() } else { g(k) };
            let mut alone = table("acc_y_g", sample);
            if place == "open-end" {
                assert_eq!(alone.pop(), Some('\n'));
            }
            cases.push(
                refused(
                    &format!("damaged-{place}-{index}.csv"),
                    alone,
                    &[&line, "widen the column or correct the cell"],
                )
                .options(&rate),
            );
        }
    }
    cases.extend([
        good(
            "rules-drawn.csv",
            plain("########\n## Sled 12 ##\n######## ab\n### 3 tests, one good\ntime_s,acc_y_g")
                + "########\n## end\n",
        ),
        good(
            "rows-made-comments.csv",
            with_row("# made a comment").replace("\n# made", &format!("\n#{},0.1\n# made", s(99))),
        )
        .samples(800)
        .unusable(&["blocking gap", "warning rows-made-comments"], &["gap"]),
        good(
            "row-made-a-comment-at-the-end.csv",
            plain("time_s,acc_y_g") + "# 0.0600,0.1\n",
        )
        .finds(&["warning rows-made-comments"]),
        refused(
            "sample-made-a-comment.csv",
            table("acc_y_g\n#0.01", g),
            &[":2", "as many numbers as a row"],
        )
        .options(&rate),
    ]);
    cases
}

/// Columns that count the rows, alone or beside stamps.
pub(super) fn counts() -> Vec<Case> {
    let rate = ["--rate-hz", "10000", "--time-zero", "0.02"];
    let with = |name: &str, head: &str, count: &dyn Fn(i64) -> i64| {
        let text = table(head, |k| format!("{},{}", count(k - FROM), g(k)));
        good(name, text).options(&rate)
    };
    let gap = |k: i64| if k < 300 { k } else { k + 40 };
    let faulty = |case: Case, says: &str| case.unusable(&["blocking index-gap"], &[says]);
    let stamped = |count: &dyn Fn(i64) -> i64| {
        table("n,time_s,acc_y_g", |k| {
            format!("{},{},{}", count(k - FROM), s(k), g(k))
        })
    };
    vec![
        faulty(
            with("index-gap.csv", "sample,acc_y_g", &gap),
            "from 299 to 340 (line 302)",
        ),
        faulty(
            with("index-back.csv", "index,acc_y_g", &|k| 2000 - k),
            "from 2000 to 1999",
        ),
        faulty(
            with("index-anew.csv", "n,acc_y_g", &|k| k % 400),
            "from 399 to 0",
        ),
        faulty(
            with("index-twice.csv", "scan,acc_y_g", &|k| {
                k - i64::from(k > 50)
            }),
            "from 50 to 50",
        ),
        faulty(
            with("ticks-gap.csv", "ticks,acc_y_g", &|k| 100 * gap(k)),
            "from 29900 to 34000",
        )
        .finds(&["info channel-chosen"]),
        faulty(
            with("stamps-unknown.csv", "Taktgeber,acc_y_g", &|k| 100 * gap(k)),
            "from 29900",
        )
        .finds(&["info channel-chosen"]),
        with("ticks.csv", "ticks,acc_y_g", &|k| 100 * k).finds(&["info channel-chosen"]),
        with("index-of-16-bits.csv", "count,acc_y_g", &|k| {
            (k + 65_200) % 65_536
        }),
        with("test-number.csv", "nr,acc_y_g", &|_| 12),
        with("index-by-two.csv", "scan,acc_y_g", &|k| 2 * k).finds(&["warning index-step"]),
        good("index-gap-with-stamps.csv", stamped(&gap)).finds(&["warning index-gap"]),
        good("index-by-two-with-stamps.csv", stamped(&|k| 2 * k)),
    ]
}

/// Tables of pairs, each channel with a clock of its own.
pub(super) fn two_clocks() -> Vec<Case> {
    let pairs = |head: &str| {
        table(head, |k| {
            format!("{},{},{:.4},{}", s(k), g(k + 3), k as f64 / 5e3, g(k))
        })
    };
    let mut cases = Vec::new();
    for (index, head) in [
        "t [s],ax [g],t2 [s],ay [g]",
        "Time [s],ax [g],X2 [s],ay [g]",
        "t,ax (g),t.1,ay (g)",
        "time_s,ax (g),time_y_s,ay (g)",
        "t (s),ax (g),t_y,ay (g)",
    ]
    .iter()
    .enumerate()
    {
        cases.push(refused(
            &format!("two-clocks-{index}.csv"),
            pairs(head),
            &[
                "one time column",
                head.split(',').nth(2).unwrap(),
                "--time-column",
            ],
        ));
    }
    cases.push(
        good("two-clocks-told.csv", pairs("t [s],ax [g],t2 [s],ay [g]"))
            .options(&["--time-column", "t2 [s]"])
            .channel("ay [g]")
            .clock(5_000.0, -0.04)
            .finds(&["info channel-chosen", "warning rate-below-default-filter"]),
    );
    cases
}

/// Comments and columns of words that say what the samples are worth.
pub(super) fn words_on_samples() -> Vec<Case> {
    let said =
        |name: &str, comment: &str| good(name, plain(&format!("# {comment}\ntime_s,acc_y_g")));
    let column = |name: &str, title: &str, word: &dyn Fn(i64) -> &'static str| {
        let text = table(&format!("time_s,acc_y_g,{title}"), |k| {
            format!("{},{},{}", s(k), g(k), word(k))
        });
        good(name, text)
    };
    let flagged = ["blocking invalid-by-laboratory"];
    let remarked = ["blocking laboratory-remark"];
    let shown = ["info laboratory-remark"];
    let asks =
        |name: &str, comment: &str| said(name, comment).unusable(&remarked, &["accepted_remarks"]);
    vec![
        said(
            "comment-limit.csv",
            "acc_y_g: NO VALID DATA AFTER 30 MS (cable cut)",
        )
        .unusable(&remarked, &["AFTER 30 MS"]),
        asks("comment-no-data.csv", "NO VALID DATA"),
        good(
            "comment-behind.csv",
            plain("time_s,acc_y_g") + "# sensor failed at 30 ms\n",
        )
        .unusable(&remarked, &["sensor failed at 30 ms"]),
        asks("comment-polarity.csv", "polarity reversed"),
        // The vehicle or a setting may be meant: a person says so.
        asks("comment-door.csv", "Door lock failed"),
        asks("comment-rating.csv", "Sensor 7264C, overload 5000 g"),
        asks(
            "comment-setting.csv",
            "Clipping level of the channel: 200 g",
        ),
        said("comment-denied.csv", "Overload: no").finds(&shown),
        asks("comment-name.csv", "spike_1k fs=10000"),
        said("comment-accepted.csv", "Overload: 2")
            .options(&["--accept-remark", "Overload:  2 "])
            .finds(&["warning remark-accepted"]),
        said("comment-in-the-card.csv", "Overload: 2")
            .beside(
                "comment-in-the-card.csv.toml",
                "accepted_remarks = [\"Overload: 2\"]\n",
            )
            .finds(&["warning remark-accepted"]),
        said("comment-accepted-otherwise.csv", "Overload: 2")
            .options(&["--accept-remark", "Overload: none"])
            .finds(&["warning accepted-remark-not-found"])
            .unusable(&remarked, &["Overload: 2"]),
        said("comment-airbag.csv", "Airbag fired at 12 ms").finds(&shown),
        said("comment-of-another.csv", "time_s: clipped"),
        said("comment-trigger.csv", "trigger at 20 ms").finds(&shown),
        said("comment-plain.csv", "Test 12, 7.5 m/s, filtered at 1650 Hz"),
        column("status-ok.csv", "status", &|_| "OK"),
        column("status-overload.csv", "status", &|k| {
            if k < 100 { "OK" } else { "OVERLOAD" }
        })
        .unusable(&remarked, &["OVERLOAD", "in row 301"]),
        column("status-unknown.csv", "status", &|k| {
            if k < 100 { "OK" } else { "HOLD" }
        })
        .unusable(&remarked, &["status: HOLD", "in row 301"]),
        column("status-accepted.csv", "status", &|k| {
            if k < 100 { "OK" } else { "HOLD" }
        })
        .options(&["--accept-remark", "status: HOLD"])
        .finds(&["warning remark-accepted"]),
        column("flag-set.csv", "overload", &|k| {
            if k < 100 { "0" } else { "1" }
        })
        .unusable(&flagged, &["`overload` says"])
        .finds(&["info channel-chosen"]),
        column("valid-no-more.csv", "valid", &|k| {
            if k < 100 { "1" } else { "0" }
        })
        .unusable(&flagged, &["`valid` says"])
        .finds(&["info channel-chosen"]),
        column("noted.csv", "comment", &|k| {
            if k == 0 { "contact" } else { "" }
        })
        .finds(&shown),
        column("noted-fault.csv", "comment", &|k| {
            if k == 0 { "cable out" } else { "" }
        })
        .unusable(&remarked, &["cable out", "in row 201"]),
    ]
}

/// Numbers in other dress, lines above the header, and rows that are one cell.
pub(super) fn odd_cells() -> Vec<Case> {
    let in_each = |dress: &dyn Fn(String) -> String| {
        table("time_s,acc_y_g", |k| format!("{},{}", s(k), dress(g(k))))
    };
    let clock = |stamp: &dyn Fn(i64) -> String| {
        table("time,acc_y_g", |k| format!("{},{}", stamp(k - FROM), g(k)))
    };
    vec![
        refused(
            "fortran.csv",
            in_each(&|text| text + "D+00"),
            &["D+00`", "exponent with E"],
        ),
        good(
            "no-break-space.csv",
            in_each(&|text| format!("\u{a0}{text}\u{202f}")),
        ),
        good(
            "minus-sign.csv",
            in_each(&|text| text.replace('-', "\u{2212}")),
        ),
        refused(
            "dash.csv",
            with_row("0.0100,\u{2013}0.1"),
            &[":302, column 2", "U+2013"],
        ),
        good(
            "preamble-of-numbers.csv",
            plain("Test,1234\nRate,10000\ntime_s,acc_y_g"),
        )
        .finds(&["info preamble"]),
        refused(
            "times-of-day.csv",
            clock(&|k| format!("10:61:04.{k:04}")),
            &["`10:61:04.0000`", "2024-05-01T10:00:00.0001"],
        ),
        refused(
            "dates-with-slashes.csv",
            clock(&|k| format!("05/32/2024 10:00:04.{k:04}")),
            &["05/32/2024", "2024-05-01T10:00:00.0001"],
        ),
        refused(
            "rows-quoted.csv",
            table("\"time_s,acc_y_g\"", |k| format!("\"{},{}\"", s(k), g(k))),
            &["no quotes around rows"],
        ),
        refused(
            "bars.csv",
            plain("time_s,acc_y_g").replace(',', "|"),
            &["a comma, semicolon or tab between cells"],
        ),
    ]
}
