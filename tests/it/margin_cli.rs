//! Guards `latchgate margin` at the process boundary.

use crate::support::{Folder, advised, at_door, latchgate, signal_file, table, weak};
use serde_json::Value;

const FAST: [&str; 2] = ["--members", "0"];

fn margin(arguments: &[&str]) -> crate::support::Done {
    let mut all = vec!["margin"];
    all.extend(arguments);
    all.extend(FAST);
    latchgate(&all)
}

#[track_caller]
fn check_bracketed(document: &Value, key: &str) {
    let at = document[key].as_f64().unwrap();
    let bracket = &document[format!("{key}_bracket")];
    let (low, high) = (bracket[0].as_f64().unwrap(), bracket[1].as_f64().unwrap());
    assert!(low <= at && at <= high, "{key}: {at} in {low}..{high}");
    assert!(high - low <= 1e-9 * high.abs(), "{key}: {low}..{high}");
}

#[test]
fn cli_margin_answers_in_json() {
    let done = margin(&[
        &signal_file("surviving.csv"),
        "--model",
        "rigid",
        "--no-report",
        "--format",
        "json",
    ]);
    assert_eq!(done.code, 0, "{}", done.err);
    let document = done.document();
    assert_eq!(document["schema"], "latchgate.margin/1");
    assert_eq!(document["verdict"], "pass");
    assert_eq!(document["basis"], "nominal run");
    for key in [
        "scale_to_flip",
        "least_preload_torque_nm",
        "least_threshold_rad",
    ] {
        check_bracketed(&document, key);
        let advised = document[format!("{key}_safe_from")].as_f64().unwrap();
        let at = document[key].as_f64().unwrap();
        let above = key != "scale_to_flip";
        assert!((advised > at) == above, "{key}: {advised} beside {at}");
    }
    assert!(document["scale_to_flip"].as_f64().unwrap() > 1.0);
    assert!(document["least_preload_torque_nm"].as_f64().unwrap() < 0.1);
    // An unbalance that opens it would have more inertia than the lever.
    assert!(document["greatest_unbalance_kg_m"].is_null());
    assert!(document["greatest_unbalance_kg_m_reason"].is_string());
    // It passes, and no counterweight makes that worse.
    assert!(document["counterweight"]["mass_kg"].is_null());
    assert!(document["counterweight"]["reason"].is_string());
    assert!(document["restitution"].is_null());
    assert!(document["restitution_reason"].is_string());
    for boundary in document["boundaries"].as_array().unwrap() {
        for key in ["quantity", "at", "bracket", "below", "above"] {
            assert!(!boundary[key].is_null(), "{boundary}");
        }
    }
    assert!(document["recording"]["sha256"].is_string());
    assert!(document["design"]["lever"].is_object());
    assert_eq!(document["request"]["members"], 0);
    assert_eq!(document["request"]["counterweight_radius"], 0.03);
    let last = document.as_object().unwrap().keys().next_back().unwrap();
    assert!(done.out.trim_end().ends_with("}\n}"), "{last}");
}

#[test]
fn cli_margin_writes_its_report() {
    let folder = Folder::new("margin-report");
    let out = folder.path().join("out");
    let done = margin(&[
        &signal_file("surviving.csv"),
        "--model",
        "rigid",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(done.code, 0, "{}", done.err);
    assert!(
        done.out.starts_with("✓ PASS  Passes down to a preload of "),
        "{}",
        done.out
    );
    for word in ["passes from", "scale of the recording", "half-sine"] {
        assert!(done.out.contains(word), "{word}: {}", done.out);
    }
    let limit = std::fs::read_to_string(out.join("margin-limit.csv")).unwrap();
    assert_eq!(limit.lines().count(), 1 + 41);
    let page = std::fs::read_to_string(out.join("margin.html")).unwrap();
    for figure in ["margin-limit", "margin-scan"] {
        assert!(
            page.contains(&format!("<figure id=\"{figure}\">")),
            "{figure}"
        );
        assert!(out.join(format!("{figure}.svg")).is_file(), "{figure}");
    }
    let document: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("margin.json")).unwrap()).unwrap();
    // Its number stands in the page and in the folder's name unless one is given.
    let id = document["report_id"].as_str().unwrap();
    assert!(id.len() == 64 && page.contains(id), "{id}");
}

#[track_caller]
fn check_refused(arguments: &[&str], code: i32, word: &str) {
    let mut all = arguments.to_vec();
    all.push("--no-report");
    let done = margin(&all);
    assert_eq!(done.code, code, "{arguments:?}: {}", done.err);
    assert!(done.err.contains(word), "{arguments:?}: {}", done.err);
    assert!(done.out.is_empty(), "{}", done.out);
}

#[test]
fn cli_margin_refuses_wrong_usage() {
    let file = signal_file("surviving.csv");
    check_refused(&[&file, "--counterweight-radius", "0"], 2, "positive");
    check_refused(&[&file, "--set", "lever.mass_kg=-1"], 2, "positive");
    check_refused(&["no-such-file.csv"], 4, "no-such-file.csv");
}

/// A record that ends inside the event carries no verdict: the numbers are printed with a word
/// of caution, and the exit code says that they are no answer.
#[test]
fn cli_margin_of_a_spoiled_recording_ends_with_four() {
    let folder = Folder::new("margin-spoiled");
    let file = folder.write("cut.csv", table(|t| if t > 0.1 { -20.0 } else { 0.0 }));
    let done = margin(&[
        &file,
        "--opens-when",
        "negative",
        "--model",
        "rigid",
        "--no-report",
        "--format",
        "json",
    ]);
    assert_eq!(done.code, 4, "{}", done.err);
    assert!(done.err.contains("prove nothing"), "{}", done.err);
    let document = done.document();
    assert_eq!(document["basis"], "nominal run");
    assert!(
        document["notes"][0]
            .as_str()
            .unwrap()
            .contains("no evidence")
    );
}

/// However often the answer changes, what is printed fits a screen; all changes stand in the document.
#[test]
fn cli_margin_prints_a_screen_at_most() {
    let done = margin(&[&signal_file("burst.csv"), "--no-report"]);
    assert_eq!(done.code, 0, "{}", done.err);
    let lines = done.out.lines().count();
    assert!(lines <= 24, "{lines} lines:\n{}", done.out);
    let json = margin(&[&signal_file("burst.csv"), "--no-report", "--format", "json"]);
    let boundaries = json.document()["boundaries"].as_array().unwrap().len();
    assert!(boundaries > 8, "{boundaries}");
}

/// The report of a replay advises the preload that margins advise.
#[test]
fn cli_replay_and_margin_advise_one_preload() {
    let folder = Folder::new("margin-advice");
    let out = folder.path().join("out");
    let file = signal_file("surviving.csv");
    let members = ["--members", "0"];
    let mut replay = vec![
        "replay",
        &file,
        "--out",
        out.to_str().unwrap(),
        "--format",
        "json",
    ];
    replay.extend(members);
    advised(&replay);
    let stored = std::fs::read_to_string(out.join("verdict.json")).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&stored).unwrap();
    let json = [
        "margin",
        &file,
        "--no-report",
        "--format",
        "json",
        members[0],
        members[1],
    ];
    let margin = latchgate(&json).document();
    let (own, other) = (&answer["preload_answer"], &margin["answers"][1]["advice"]);
    assert!(own["safe_from"].is_number(), "{own}");
    assert_eq!(
        own["safe_from"],
        margin["least_preload_torque_nm_safe_from"]
    );
    assert_eq!(own, other);
}

/// A replay searches for the preload where that may take no longer than an answer, be the lever at rest at
/// present, and with a catch for a tenth of the samples.
#[test]
fn cli_a_replay_leaves_a_long_search_to_margin() {
    let folder = Folder::new("margin-left-out");
    let recording = folder.write("weak.csv", at_door(&table(weak)));
    let catch = folder.path().join("catch.toml");
    let catch = catch.to_str().unwrap();
    let init = ["init", "design", "--mechanism", "catch", catch];
    assert_eq!(latchgate(&init).code, 0);
    let held = ["--set", "lever.preload_torque_nm=9"];
    let stated = ["tolerance.preload_torque_nm=0", "tolerance.mass_kg=0"];
    let with_catch = ["--design", catch, "--set", stated[0], "--set", stated[1]];
    // 3001 samples, two stops: 12 million steps and ten times as many.
    let cases = [
        (&held[..], "work=12000000", false),
        (&held, "work=13000000", true),
        (&with_catch, "work=100000000", false),
    ];
    for (further, limit, expected) in cases {
        let mut arguments = vec!["replay", &recording, "--opens-when", "negative"];
        arguments.extend(["--no-report", "--limit", limit]);
        arguments.extend(further);
        let done = advised(&arguments);
        assert_eq!(done.code, 0, "{limit}: {}", done.err);
        let left = done
            .out
            .contains("latchgate margin searches for the preloads");
        assert_eq!(left, !expected, "{limit}: {}", done.out);
        assert_eq!(
            done.out.contains("values tried"),
            expected,
            "{limit}: {}",
            done.out
        );
    }
}

/// On the sill of a real crash 3.6 N·m pass, 3.61 to 3.76 do not throughout: the pass is warned of at once, and what is
/// advised passes with what lies beyond.
#[test]
fn cli_an_isolated_pass_is_warned_of() {
    let folder = Folder::new("margin-isolated");
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/recordings/nhtsa_v07292.146"
    );
    let out = folder.path().join("report");
    let set = |preload: &str| format!("lever.preload_torque_nm={preload}");
    let shown = out.to_str().unwrap();
    let mut own = vec!["replay", file, "--transfer", "1"];
    // Of this one lever: its scatter would hide what lies so near.
    own.extend(["--set", "tolerance.preload_torque_nm=0"]);
    own.extend(["--set", "tolerance.mass_kg=0", "--set"]);
    let done = advised(&[&own[..], &[&set("3.6"), "--out", shown]].concat());
    assert_eq!(done.code, 0, "{}", done.err);
    let text = done.out.split_whitespace().collect::<Vec<_>>().join(" ");
    let said =
        "advice warning Isolated pass, do not design to it: a preload of 3.6\u{a0}N·m passes";
    let plain = |text: &str| text.replace('\u{a0}', " ");
    assert!(plain(&text).contains(&plain(said)), "{}", done.out);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    let first = page
        .split("<ul class=\"why\"><li class=\"caution\">")
        .nth(1);
    let first = first.unwrap();
    assert!(
        first.starts_with("Isolated pass, do not design to it"),
        "{}",
        &first[..200]
    );
    for (preload, code) in [("3.65", 3), ("3.76", 3), ("3.77", 0), ("3.9", 0)] {
        let done = latchgate(&[&own[..], &[&set(preload), "--no-report"]].concat());
        assert_eq!(done.code, code, "{preload}");
    }
}

/// Threads change no byte but those of the time it took.
#[test]
fn cli_margin_gives_the_same_bytes_for_any_threads() {
    let run = |threads: &str| {
        let done = margin(&[
            &signal_file("surviving.csv"),
            "--threads",
            threads,
            "--no-report",
            "--format",
            "json",
        ]);
        let end = done.out.rfind("\"elapsed_s\"").unwrap();
        done.out[..end].to_string()
    };
    assert_eq!(run("1"), run("3"));
}

/// Limits hold for `margin` as for `replay`, and what was asked says so.
#[test]
fn cli_margin_keeps_the_limits_that_are_set() {
    let recording = signal_file("surviving.csv");
    let json = ["--no-report", "--format", "json"];
    let refused = margin(&[&[&*recording, "--limit", "samples=100"][..], &json].concat());
    assert_eq!(refused.code, 4, "{}", refused.err);
    assert!(refused.err.contains("samples"), "{}", refused.err);
    let held = margin(&[&[&*recording, "--limit", "samples=100000"][..], &json].concat());
    assert_eq!(held.code, 0, "{}", held.err);
}
