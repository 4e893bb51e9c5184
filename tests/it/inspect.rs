//! Guards `inspect`: what it tells of a recording that `replay` would judge, or refuse.

use crate::support::{Folder, fed, half_sine, latchgate, table, weak};
use serde_json::Value;

/// The document of a file of this text.
#[track_caller]
fn inspected(name: &str, text: &str, options: &[&str]) -> Value {
    let folder = Folder::new(&format!("inspect-{name}"));
    let path = folder.write("a.csv", text);
    let arguments = [&["inspect", &path, "--format", "json"], options].concat();
    let done = latchgate(&arguments);
    assert_eq!(done.code, 0, "{}", done.err);
    done.document()
}

fn codes(channel: &Value) -> Vec<&str> {
    let findings = channel["findings"].as_array().unwrap();
    findings
        .iter()
        .map(|f| f["code"].as_str().unwrap())
        .collect()
}

/// Two lateral columns at one place and a third that goes elsewhere.
fn three(third: f64) -> String {
    let push = |t: f64| half_sine(t, 0.0, 0.02, 30.0) + 0.05 * (t * 9_100.0).sin();
    let mut text = String::from("time_s,acc_y_g,door_y (g),sill_y (g)\n");
    for row in table(push).lines().skip(1) {
        let time: f64 = row.split(',').next().unwrap().parse().unwrap();
        let value = push(time);
        text += &format!(
            "{time:.4},{value:.4},{:.4},{:.4}\n",
            value * 1.01,
            value * third
        );
    }
    text
}

#[test]
fn cli_inspect_says_what_replay_takes_and_why() {
    let plain = inspected("plain", &table(weak), &[]);
    assert_eq!(plain["replay"]["channel"], "acc_y_g");
    assert_eq!(plain["replay"]["reason"], "it is the only channel");
    let named = inspected("named", &three(1.0), &["--channel", "sill_y (g)"]);
    assert_eq!(named["replay"]["channel"], "sill_y (g)");
    assert_eq!(named["replay"]["reason"], "the setting `channel` names it");
    let several = inspected("several", &three(1.0), &[]);
    assert_eq!(several["replay"]["channel"], Value::Null);
    let candidates = several["replay"]["candidates"].as_array().unwrap();
    assert_eq!(candidates.len(), 3, "{several}");
}

/// Names with commas in them are told apart, and each can be chosen.
#[test]
fn cli_inspect_offers_names_with_commas() {
    let text = three(1.0).replacen(
        "door_y (g),sill_y (g)",
        "\"y, left (g)\",\"y, right (g)\"",
        1,
    );
    let several = inspected("commas", &text, &[]);
    let candidates = serde_json::json!(["acc_y_g", "y, left (g)", "y, right (g)"]);
    assert_eq!(several["replay"]["candidates"], candidates, "{several}");
    let chosen = inspected("comma", &text, &["--channel", "y, right (g)"]);
    assert_eq!(chosen["replay"]["channel"], "y, right (g)");
}

/// A lone channel of another axis is not taken unless it is asked for, and then doubted.
#[test]
fn cli_inspect_doubts_another_axis() {
    let text = table(weak).replacen("acc_y_g", "acc_x_g", 1);
    let document = inspected("axis", &text, &[]);
    assert!(document["replay"]["channel"].is_null(), "{document}");
    let reason = document["replay"]["reason"].as_str().unwrap();
    assert!(
        reason.contains("acc_x_g (`x` names the X axis)"),
        "{reason}"
    );
    let asked = inspected("axis-asked", &text, &["--channel", "acc_x_g"]);
    assert_eq!(asked["replay"]["channel"], "acc_x_g");
    let reason = asked["replay"]["reason"].as_str().unwrap();
    assert!(
        reason.starts_with("the setting `channel` names it, but: "),
        "{reason}"
    );
    assert!(
        reason.ends_with("structure: `x` names the X axis. Check the channel"),
        "{reason}"
    );
}

/// Where no channel can be read, the place of the fault is said as replay says it.
#[test]
fn cli_inspect_names_the_cell_at_fault() {
    let folder = Folder::new("inspect-cell");
    let path = folder.write("a.csv", "time_s,acc_y_g\n0,1\n0.001,\n0.002,3\n");
    let told = |command: &str| {
        let done = latchgate(&[command, &path]);
        assert_eq!(done.code, 4, "{}", done.err);
        done.err.lines().last().unwrap_or_default().to_string()
    };
    let message = told("inspect");
    assert!(message.contains("a.csv:3, column 2"), "{message}");
    assert_eq!(message, told("replay"));
}

#[test]
fn cli_inspect_lists_what_replay_would_refuse() {
    let text = table(|t| if t > 0.1 { 1e12 } else { weak(t) });
    let document = inspected("refused", &text, &[]);
    assert!(codes(&document["channels"][0]).contains(&"samples-unusable"));
}

#[test]
fn cli_inspect_compares_neighbours() {
    let agree = inspected("agree", &three(1.0), &[]);
    for channel in agree["channels"].as_array().unwrap() {
        assert!(!codes(channel).contains(&"sign-suspected"), "{channel}");
        assert!(codes(channel).contains(&"pre-event"), "{channel}");
    }
    let disagree = inspected("disagree", &three(-0.4), &[]);
    assert!(
        codes(&disagree["channels"][2]).contains(&"sign-suspected"),
        "{disagree}"
    );
}

/// What could not be compared is said; standard input, read once, is compared like a file.
#[test]
fn cli_replay_tells_of_neighbours_that_were_not_read() {
    let options = ["--channel", "sill_y (g)", "--opens-when", "both"];
    let rest = ["--members", "0", "--no-report", "--format", "json"];
    let done = fed(
        &[&["replay", "-"], &options[..], &rest].concat(),
        three(-0.4).as_bytes(),
    );
    let fed = done.document();
    let folder = Folder::new("neighbours-unread");
    let path = folder.write("a.csv", three(-0.4));
    let read = latchgate(&[&["replay", &path], &options[..], &rest].concat()).document();
    assert_eq!(codes(&fed), codes(&read));
    assert!(!codes(&fed).contains(&"neighbours-unread"), "{fed}");
    // Enough for one column, not for three.
    let cells = format!("table_cells={}", 2 * three(-0.4).lines().count());
    let limit = ["--limit", &cells];
    let done = latchgate(&[&["replay", &path], &options[..], &limit, &rest].concat());
    let document = done.document();
    assert!(
        codes(&document).contains(&"neighbours-unread"),
        "{document}"
    );
}

/// A verdict on one of several channels says what the others have against it.
#[test]
fn cli_replay_compares_neighbours() {
    let folder = Folder::new("replay-neighbours");
    for (third, expected) in [(1.0, false), (-0.4, true)] {
        let path = folder.write("a.csv", three(third));
        let done = latchgate(&[
            "replay",
            &path,
            "--channel",
            "sill_y (g)",
            "--opens-when",
            "both",
            "--members",
            "0",
            "--no-report",
            "--format",
            "json",
        ]);
        let document = done.document();
        let found = codes(&document).contains(&"sign-suspected");
        assert_eq!(found, expected, "{document}");
    }
}

/// What is taken, offered and passed over stands in a column; findings of the rest are asked for.
#[test]
fn cli_inspect_tells_the_status_of_each_channel() {
    let folder = Folder::new("inspect-status");
    let text = three(1.0).replacen("door_y (g),sill_y (g)", "door_x (g),temperature", 1);
    let path = folder.write("a.csv", text);
    let done = latchgate(&["inspect", &path]);
    assert_eq!(done.code, 0, "{}", done.err);
    let statuses: Vec<&str> = done
        .out
        .lines()
        .skip_while(|line| !line.starts_with("channel "))
        .skip(1)
        .take(3)
        .map(|line| {
            line.split("  ")
                .filter(|cell| !cell.is_empty())
                .nth(1)
                .unwrap()
                .trim()
        })
        .collect();
    assert_eq!(
        statuses,
        ["taken", "passed over", "no unit"],
        "{}",
        done.out
    );
    assert!(!done.out.contains("door_x (g): "), "{}", done.out);
    assert!(done.out.contains("-v shows them"), "{}", done.out);
    let all = latchgate(&["inspect", &path, "-v"]);
    assert!(
        all.out.contains("door_x (g): ") && !all.out.contains("-v shows"),
        "{}",
        all.out
    );
    let several = inspected("offered", &three(1.0), &[]);
    let statuses = several["channels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| &one["status"]);
    assert!(
        statuses.into_iter().all(|status| status == "offered"),
        "{several}"
    );
    assert_eq!(several["series"], Value::Null);
}

/// The samples that `inspect` gives are those of the series of a report, digit by digit.
#[test]
fn cli_inspect_and_the_series_of_a_report_hold_the_same_numbers() {
    let folder = Folder::new("report-series");
    let path = folder.write("a.csv", table(weak));
    let listed = inspected("series", &table(weak), &[]);
    let report = folder.path().join("out");
    let report = report.to_str().unwrap();
    let options = [
        "--members",
        "0",
        "--opens-when",
        "negative",
        "--out",
        report,
    ];
    latchgate(&[&["replay", &path], &options[..]].concat());
    let table = std::fs::read_to_string(format!("{report}/series.csv")).unwrap();
    let numbers = |key: &str| listed["series"][key].as_array().unwrap().iter();
    let mut listed = numbers("time_s").zip(numbers("acceleration_recorded_m_s2"));
    for line in table.lines().skip(1) {
        let mut cells = line.split(',').map(|cell| cell.parse::<f64>().unwrap());
        let (time, value) = listed.next().unwrap();
        assert_eq!(cells.next(), time.as_f64(), "{line}");
        assert_eq!(cells.next(), value.as_f64(), "{line}");
    }
    assert_eq!(listed.next(), None);
}

/// What was read of a head is shown: of a table its lines, of a sheet its name, of a channel what is said of it.
#[test]
fn cli_inspect_shows_what_was_read_of_the_head() {
    let shown = |path: &str| {
        let done = latchgate(&["inspect", path]);
        assert_eq!(done.code, 0, "{}", done.err);
        // As one line, since lines are wrapped.
        done.out.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let recordings = crate::support::data("recordings");
    let tests = crate::support::data("");
    let folder = Folder::new("inspect-head");
    let table = "Test no,7292\nSample rate [Hz],10000\nTime,Acc Y\ns,g\n0,1\n0.0001,2\n0.0002,3\n";
    let table = folder.write("a.csv", table);
    let of_tests = |path: &str| tests.join(path).to_string_lossy().into_owned();
    let header = recordings
        .join("nhtsa_v07292.EV5")
        .to_string_lossy()
        .into_owned();
    for (path, lines) in [
        (
            table,
            &[
                "table: names on line 3, units on line 4, samples from line 5, time in `Time` in s",
                "above it: Test no 7292; Sample rate [Hz] 10000",
                "Acc Y: unit g by units row",
                "test: 7292",
            ][..],
        ),
        (
            of_tests("workbook/openpyxl.xlsx"),
            &[
                "table: sheet `Data`, names on line 5, units on line 6, samples from line 7, time in `Time` in s",
                "above it: Test no 7292; Laboratory A laboratory; Test date 2026-01-15",
                "door y: unit g by units row",
                "date: 2026-01-15",
            ],
        ),
        (
            of_tests("tdms/plain.tdms"),
            &["test: side impact", "door y: unit g by header"],
        ),
        (
            header,
            &[
                "vehicle: vehicle 1: 2007",
                "full scale 2000.0 g",
                "analogue filter to",
            ],
        ),
    ] {
        let text = shown(&path);
        for line in lines {
            assert!(text.contains(line), "{path}: {line}\n{text}");
        }
    }
    let folder = Folder::new("inspect-head-json");
    let path = folder.write("a.csv", "t_s,acc_y_g\n0,1\n0.001,2\n0.002,3\n");
    let document = latchgate(&["inspect", &path, "--format", "json"]).document();
    assert_eq!(document["table"]["header_line"], 1);
    assert_eq!(document["table"]["separator"], "comma");
}
