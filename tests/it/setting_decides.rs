//! Guards settings that decide: a pass that the defaults do not share is said to be one of the
//! setting, a doubtful bias and a method without a bound decide no pass, and a design out of any
//! latch's world is warned of.

use crate::support::{Done, Folder, half_sine, latchgate, table};
use serde_json::Value;

/// A pulse that opens the paper's lever to 0.32 rad.
fn opening(time: f64) -> f64 {
    half_sine(time, 0.0, 0.012, -14.0) + 0.01 * (time * 9_100.0).sin()
}

/// A vibration at 200 Hz that shakes the lever open and adds up to no velocity.
fn shaking(time: f64) -> f64 {
    let hump = half_sine(time, 0.0, 0.1, 1.0);
    160.0 * hump * hump * (std::f64::consts::TAU * 200.0 * time).sin()
        + 0.01 * (time * 9_100.0).sin()
}

fn replayed(folder: &Folder, of: fn(f64) -> f64, arguments: &[&str]) -> Done {
    let path = folder.file("pulse.csv", table(of).as_bytes());
    folder.file("pulse.csv.toml", "synthetic = true\n");
    let path = path.to_str().unwrap().to_string();
    let fixed = [
        "replay",
        &path,
        "--opens-when",
        "negative",
        "--no-report",
        "--format",
        "json",
    ];
    latchgate(&[&fixed, arguments].concat())
}

fn codes(document: &Value, list: &str) -> Vec<String> {
    let all = document[list].as_array().unwrap();
    all.iter()
        .map(|one| one["code"].as_str().unwrap().to_string())
        .collect()
}

/// The pass is warned of first, in `why` and among the warnings, naming setting and both answers.
#[track_caller]
fn check_decides(done: &Done, setting: &str) {
    let document = done.document();
    assert_eq!(done.code, 0, "{}", done.out);
    let first = &document["why"][0];
    assert_eq!(first["code"], "setting-decides", "{first}");
    let text = first["text"].as_str().unwrap();
    assert!(text.contains(setting) && text.contains("pass"), "{text}");
    assert!(
        text.contains("fail") || text.contains("undecided"),
        "{text}"
    );
    let findings = document["findings"].as_array().unwrap();
    let at = findings
        .iter()
        .position(|one| one["code"] == "setting-decides")
        .unwrap();
    assert_eq!(findings[at]["severity"], "warning");
    assert!(
        findings[..at]
            .iter()
            .all(|one| one["severity"] == "blocking" || one["code"] == "design-implausible")
    );
}

#[test]
fn cli_a_setting_that_turns_a_fail_into_a_pass_is_named() {
    let folder = Folder::new("settings-decide");
    assert_eq!(replayed(&folder, opening, &[]).code, 1);
    assert_eq!(replayed(&folder, shaking, &[]).code, 1);
    let decides = |of, arguments: &[&str], setting: &str| {
        check_decides(&replayed(&folder, of, arguments), setting);
    };
    decides(shaking, &["--resample", "300"], "`resample`");
    decides(shaking, &["--filter", "cfc60"], "`filter`");
    decides(opening, &["--window=-0.04..0.001"], "`window`");
    let raised = ["--set", "criterion.threshold_rad=0.9"];
    decides(opening, &raised, "`criterion.threshold_rad`");
    // A share that a pass allows beyond the default is a setting like the limit angle.
    let most = |time: f64| 0.5 * opening(time);
    let strict = replayed(&folder, most, &[]);
    assert_ne!(strict.code, 0, "{}", strict.out);
    let loose = ["--set", "criterion.open_share=0.9"];
    decides(most, &loose, "`criterion.open_share`");
    // What both say alike is no news.
    let agreed = replayed(&folder, |time| 0.3 * opening(time), &["--filter", "cfc180"]);
    assert_eq!(agreed.code, 0);
    assert!(!codes(&agreed.document(), "why").contains(&"setting-decides".into()));
}

#[test]
fn cli_a_bias_from_the_event_does_not_let_a_recording_pass() {
    let folder = Folder::new("settings-bias");
    for window in ["0..0.012", "0.002..0.010"] {
        let done = replayed(&folder, opening, &["--bias", window]);
        let document = done.document();
        assert_ne!(document["verdict"], "pass", "{}", done.out);
        assert!(codes(&document, "findings").contains(&"bias-window-doubtful".into()));
    }
    // A window before contact that holds a vibration is no better, however small its mean: left in, some
    // levers open.
    let shaken = |time: f64| {
        let is_shaken = (-0.045..0.0).contains(&time);
        let vibration = 2.5 * (time * std::f64::consts::TAU * 500.0).sin();
        let offset = if time < 0.0 { -0.6 } else { 0.0 };
        let push = half_sine(time, 0.0, 0.012, -7.0);
        offset + push + if is_shaken { vibration } else { 0.0 }
    };
    let document = replayed(&folder, shaken, &["--bias=-0.04..-0.002"]).document();
    let why = &document["why"][0];
    assert_eq!(document["verdict"], "undecided", "{why}");
    let text = why["text"].as_str().unwrap();
    assert!(text.starts_with("Without the doubtful bias"), "{text}");
    let quiet = replayed(&folder, opening, &["--bias=-0.04..-0.01"]).document();
    assert!(!codes(&quiet, "findings").contains(&"bias-window-doubtful".into()));
}

#[test]
fn cli_a_method_that_states_no_bound_decides_no_pass() {
    let folder = Folder::new("settings-method");
    let weak = |time: f64| 0.3 * opening(time);
    for method in [
        "moreau-jean",
        "rk4",
        "rk4-located",
        "dopri5",
        "dopri5-samples",
    ] {
        let own = ["--model", "rigid", "--method", method, "--members", "0"];
        let done = replayed(&folder, weak, &own);
        assert_eq!(done.code, 3, "{method}: {}", done.out);
        let first = done.document()["why"][0]["code"].clone();
        assert_eq!(first, "method-without-bound", "{method}");
    }
    let coarse = [
        "--model",
        "rigid",
        "--method",
        "moreau-jean",
        "--members",
        "0",
    ];
    for steps in ["1", "5", "10"] {
        let own = [coarse.as_slice(), &["--steps-per-period", steps]].concat();
        assert_ne!(replayed(&folder, opening, &own).code, 0, "{steps}");
    }
}

#[test]
fn cli_a_design_of_another_world_is_warned_of_first() {
    let folder = Folder::new("settings-design");
    for (assignment, key) in [
        ("criterion.threshold_rad=10", "criterion.threshold_rad"),
        ("lever.mass_kg=1e-9", "lever.mass_kg"),
        (
            "lever.moment_of_inertia_kg_m2=1000",
            "lever.moment_of_inertia_kg_m2",
        ),
        (
            "lever.pivot_damping_nm_s_per_rad=10",
            "lever.pivot_damping_nm_s_per_rad",
        ),
        ("stop.damping_n_s_per_m=5e4", "stop.damping_n_s_per_m"),
    ] {
        let own = ["--set", assignment, "--members", "0"];
        let document = replayed(&folder, opening, &own).document();
        let findings = document["findings"].as_array().unwrap();
        let first = findings
            .iter()
            .find(|one| one["severity"] == "warning")
            .unwrap();
        assert_eq!(first["code"], "design-implausible", "{assignment}");
        let text = first["text"].as_str().unwrap();
        assert!(text.contains(key), "{text}");
    }
    let plain = replayed(&folder, opening, &["--members", "0"]).document();
    assert!(!codes(&plain, "findings").contains(&"design-implausible".into()));
}
