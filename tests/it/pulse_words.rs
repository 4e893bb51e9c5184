//! Pulses by formula where a recording may stand: values at 200 bits, their words, and every command.

use crate::support::{Folder, data, latchgate};
use latchgate_recording::pulse::canonical;
use serde_json::Value;

/// The reference lever's numbers.
const INERTIA_KG_M2: f64 = 8.888e-4;
const MASS_KG: f64 = 0.1475;
const ARM_M: f64 = 0.065;

/// Radius of the weight of the reference values [m].
const WEIGHT_ARM_M: f64 = 0.03;

fn judged(word: &str, arguments: &[&str]) -> Value {
    let fixed = ["replay", word, "--no-report", "--format", "json"];
    latchgate(&[&fixed, arguments].concat()).document()
}

/// The lever with a weight fixed to it beyond the pivot moves as at 200 bits, overbalanced or not.
#[test]
fn val_sled_pulses_agree_with_200_bits() {
    let text = std::fs::read_to_string(data("reference/sled_pulses.csv")).unwrap();
    let mut seen = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let [scene, weight_kg, release, crossing, peak] =
            line.split(',').collect::<Vec<_>>().try_into().unwrap();
        let word = match scene {
            "lower" => "pulse:sled206-lower,opens-when=positive",
            "upper" => "pulse:sled206-upper,opens-when=positive",
            "overbalanced" => "pulse:sled206-33g,opens-when=negative",
            _ => "pulse:sled206-33g,opens-when=positive",
        };
        let weight_kg: f64 = weight_kg.parse().unwrap();
        let arm_m = (MASS_KG * ARM_M - weight_kg * WEIGHT_ARM_M) / MASS_KG;
        let inertia = INERTIA_KG_M2 + weight_kg * WEIGHT_ARM_M * WEIGHT_ARM_M;
        let [arm, inertia] = [
            format!("lever.center_of_mass_m={arm_m:?}"),
            format!("lever.moment_of_inertia_kg_m2={inertia:?}"),
        ];
        let settings = [
            "--model",
            "rigid",
            "--members",
            "0",
            "--set",
            &arm,
            "--set",
            &inertia,
        ];
        let run = &judged(word, &settings)["nominal"];
        let check = |key: &str, wanted: &str, tolerance: f64| {
            let (got, wanted) = (run[key].as_f64(), wanted.parse::<f64>().ok());
            let off = got
                .zip(wanted)
                .map_or(0.0, |(got, wanted)| (got - wanted).abs());
            assert!(
                got.is_some() == wanted.is_some() && off <= tolerance,
                "{scene} {key}: {got:?}, {wanted:?}"
            );
        };
        check("first_release_s", release, 1e-15);
        check("first_crossing_s", crossing, 1e-15);
        check("peak_angle_rad", peak, 1e-13);
        seen += 1;
    }
    assert_eq!(seen, 6);
    // The other sign presses an overbalanced lever onto its stop.
    let arm = format!("lever.center_of_mass_m={:?}", -ARM_M / 10.0);
    let pressed = judged("pulse:sled206-33g,opens-when=positive", &["--set", &arm]);
    assert_eq!(pressed["verdict"], "pass", "{pressed}");
    let opened = judged("pulse:sled206-33g,opens-when=negative", &["--set", &arm]);
    assert_eq!(opened["verdict"], "fail", "{opened}");
}

/// A negative arm is the mirrored recording, for the nominal levers and every varied one.
#[test]
fn verif_an_overbalanced_lever_is_one_on_the_mirrored_recording() {
    for word in [
        "pulse:haversine,peak=14g,duration=12ms",
        "pulse:sawtooth,peak=2g,duration=40ms",
    ] {
        let mirrored = |arm: &str, opens: &str| {
            let word = format!("{word},opens-when={opens}");
            let set = format!("lever.center_of_mass_m={arm}");
            judged(&word, &["--set", &set, "--set", "input.bias_g=0.02"])
        };
        let (plain, over) = (
            mirrored("0.065", "positive"),
            mirrored("-0.065", "negative"),
        );
        for key in ["verdict", "error_budget_rad"] {
            assert_eq!(plain[key], over[key], "{word} {key}");
        }
        for key in ["peak_angle_rad", "first_crossing_s", "impacts", "work"] {
            assert_eq!(plain["nominal"][key], over["nominal"][key], "{word} {key}");
        }
        assert!(plain["ensemble"]["exceeded"].as_u64().is_some());
    }
}

/// Nothing is removed, filtered or left open between the samples, and no sensor is doubted.
#[test]
fn cli_a_pulse_is_exact() {
    let document = judged(
        "pulse:half-sine,peak=14g,duration=11ms",
        &["--members", "0"],
    );
    let conditioning = &document["conditioning"];
    for (key, wanted) in [("filter", "none"), ("between", "exact")] {
        assert_eq!(conditioning[key], wanted, "{conditioning}");
    }
    assert_eq!(conditioning["bias_m_s2"], 0.0);
    assert_eq!(document["error_budget_rad"]["interpolation"], 0.0);
    assert_eq!(
        document["findings"].as_array().unwrap().len(),
        0,
        "{document}"
    );
    assert_eq!(document["recording"]["opens_when_source"], "pulse");
    // Twice as many samples are the same pulse.
    let finer = "pulse:half-sine,peak=14g,duration=11ms,rate=80kHz";
    let (a, b) = (
        &document["nominal"],
        &judged(finer, &["--members", "0"])["nominal"],
    );
    let peak = |run: &Value| run["peak_angle_rad"].as_f64().unwrap();
    assert!((peak(a) - peak(b)).abs() < 1e-12, "{a} {b}");
    // What is asked for is done.
    let filtered = judged(
        "pulse:half-sine,peak=14g,duration=11ms",
        &["--filter", "cfc60"],
    );
    assert_eq!(filtered["conditioning"]["filter"], "cfc60");
    assert_eq!(filtered["conditioning"]["between"], "band-limited");
    assert!(
        filtered["error_budget_rad"]["interpolation"]
            .as_f64()
            .unwrap()
            > 0.0
    );
}

/// A sawtooth ends with a jump: the lever feels nothing of it one instant later.
#[test]
fn verif_a_sawtooth_ends_with_a_jump() {
    let run = |word: &str| judged(word, &["--members", "0", "--model", "rigid"])["nominal"].clone();
    let jump = run("pulse:sawtooth,peak=4g,duration=20ms,opens-when=positive");
    // The same with a fall of ever shorter duration comes near it, in proportion.
    let fall = |micros: u32| {
        let rest = 20_000 + micros;
        let points = format!("0:0/20:4/{}.{:03}:0", rest / 1000, rest % 1000);
        run(&format!(
            "pulse:polyline,points={points},unit=g,opens-when=positive,rate=500kHz"
        ))
    };
    let peak = |run: &Value| run["peak_angle_rad"].as_f64().unwrap();
    let [far, near] = [40, 20].map(|micros| peak(&fall(micros)) - peak(&jump));
    assert!(far > 0.0 && near > 0.0, "{far} {near}");
    assert!((far / near - 2.0).abs() < 0.02, "{far} {near}");
}

#[test]
fn cli_words_of_pulses_have_one_form() {
    for (word, wanted) in [
        (
            "pulse:sled206-33g",
            "pulse:sled206-33g,rate=20000Hz,tail=200ms,opens-when=both",
        ),
        (
            "pulse:trapezoid,hold=0.035s,peak=33g,rise=22000us,fall=28ms,rate=20kHz,opens-when=negative,tail=0",
            "pulse:trapezoid,peak=33g,rise=22ms,hold=35ms,fall=28ms,rate=20000Hz,tail=0ms,opens-when=negative",
        ),
        (
            "pulse:polyline,unit=m/s2,points=0:0/0.5:-1e2/1:0",
            "pulse:polyline,points=0:0/0.5:-100/1:0,unit=m/s2,rate=20000Hz,tail=200ms,opens-when=both",
        ),
        (
            "pulse:triangle,peak=-20 G,duration=1 MS",
            "pulse:triangle,peak=-20g,duration=1ms,rate=20000Hz,tail=200ms,opens-when=both",
        ),
        (
            "pulse:triangle,peak=-20g,duration=1ms",
            "pulse:triangle,peak=-20g,duration=1ms,rate=20000Hz,tail=200ms,opens-when=both",
        ),
    ] {
        assert_eq!(canonical(word, None).unwrap(), wanted);
        assert_eq!(canonical(wanted, None).unwrap(), wanted);
    }
    let first = judged(
        "pulse:half-sine,peak=30g,duration=11ms",
        &["--members", "0"],
    );
    let other = judged(
        "pulse:half-sine,duration=0.011s,peak=3e1g",
        &["--members", "0"],
    );
    assert_eq!(first["report_id"], other["report_id"]);
}

#[test]
fn cli_a_wrong_word_is_refused_with_what_to_say() {
    for (word, told) in [
        ("pulse:half-sine,peak=30g", "add for example duration=11ms"),
        (
            "pulse:half-sine,peak=30g,length=11ms",
            "unknown key of this pulse `length`",
        ),
        (
            "pulse:half-sine,peak=30,duration=11ms",
            "found `30`; try peak=30g or peak=30m/s2",
        ),
        (
            "pulse:half-sine,peak=30ft,duration=11ms",
            "an acceleration in g or m/s2",
        ),
        (
            "pulse:half-sine,peak=30g,duration=11",
            "found `11`; try duration=11ms",
        ),
        (
            "pulse:half-sine,peak=0g,duration=11ms",
            "a peak that is not 0",
        ),
        (
            "pulse:half-sine,peak=infg,duration=11ms",
            "peak as a number",
        ),
        (
            "pulse:half-sin,peak=30g,duration=11ms",
            "did you mean `half-sine`?",
        ),
        (
            "pulse:half-sine,peak=30g,duration=11ms,raet=1kHz",
            "did you mean `rate`?",
        ),
        (
            "pulse:half-sine,peak=30g,duration=11ms,rate=1kHz",
            "200 samples",
        ),
        (
            "pulse:half-sine,peak=30g,duration=11ms,duration=12ms",
            "each key once",
        ),
        (
            "pulse:half-sine,peak=30g,duration=1e-10s",
            "whole nanoseconds",
        ),
        (
            "pulse:trapezoid,peak=33g,rise=22.3ms,hold=35ms,fall=28ms,rate=1kHz",
            "rate=20000Hz",
        ),
        (
            "pulse:trapezoid,peak=33g,rise=0,hold=0,fall=0",
            "takes time",
        ),
        (
            "pulse:polyline,points=0:0/1.000001:30/99:0,unit=g",
            "round the times",
        ),
        ("pulse:polyline,points=5:1/20:30,unit=g", "begin at 0"),
        (
            "pulse:polyline,points=0:0/20:30/20:0,unit=g",
            "order of time",
        ),
        ("pulse:polyline,file=nowhere.csv", "nowhere.csv"),
        (
            "pulse:half-sine,peak=30g,duration=11ms,opens-when=down",
            "negative|positive|both",
        ),
    ] {
        let done = latchgate(&["replay", word, "--no-report"]);
        assert_eq!(
            (done.code, done.out.as_str()),
            (4, ""),
            "{word}: {}",
            done.err
        );
        assert!(done.err.contains(told), "{word}: {}", done.err);
    }
    let unit = latchgate(&["replay", "pulse:sled206-33g", "--unit", "g", "--no-report"]);
    assert_eq!(unit.code, 4);
    assert!(unit.err.contains("leave out --unit"), "{}", unit.err);
}

/// A polyline's points may come from a file; its content is the points, wherever the file lies.
#[test]
fn cli_points_of_a_file_are_the_content() {
    let folder = Folder::new("pulse-points");
    let file = folder.file("corridor.csv", "ms,g\n0,0\n22,33\n57,33\n85,0\n");
    let of_file = judged(
        &format!("pulse:polyline,file={}", file.display()),
        &["--members", "0"],
    );
    let written = judged(
        "pulse:polyline,points=0:0/22:33/57:33/85:0,unit=g",
        &["--members", "0"],
    );
    assert_eq!(of_file["report_id"], written["report_id"]);
    let seconds = folder.file("seconds.csv", "s,m/s2\n0,0\n0.022,33\n");
    let word = canonical(
        &format!("pulse:polyline,file={}", seconds.display()),
        Some("".as_ref()),
    );
    assert!(
        word.unwrap()
            .starts_with("pulse:polyline,points=0:0/22:33,unit=m/s2")
    );
    folder.file("bad.csv", "ms,g\n0,0\n22,x\n");
    let bad = folder.path().join("bad.csv");
    let done = latchgate(&[
        "replay",
        &format!("pulse:polyline,file={}", bad.display()),
        "--no-report",
    ]);
    assert_eq!(done.code, 4);
    assert!(done.err.contains("bad.csv:3"), "{}", done.err);
}

/// Replay with report, verify from the report, margin, inspect and a gate take a pulse.
#[test]
fn cli_every_command_takes_a_pulse() {
    let folder = Folder::new("pulse-commands");
    let out = folder.path().join("report");
    let done = latchgate(&[
        "replay",
        "pulse:sled206-33g",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(done.code, 1, "{}", done.err);
    assert!(done.out.contains("pulse-unverified"), "{}", done.out);
    let verdict = out.join("verdict.json");
    let verified = latchgate(&["verify", verdict.to_str().unwrap()]);
    assert_eq!(verified.code, 0, "{} {}", verified.out, verified.err);
    let margin = latchgate(&[
        "margin",
        "pulse:sled206-33g",
        "--members",
        "0",
        "--format",
        "json",
    ]);
    let least = margin.document()["least_preload_torque_nm"]
        .as_f64()
        .unwrap();
    assert!((least - 2.98989015985953).abs() < 0.2, "{least}");
    let inspected = latchgate(&["inspect", "pulse:doorslam-500-11"]);
    assert_eq!(inspected.code, 0, "{}", inspected.err);
    assert!(inspected.out.contains("pulse"), "{}", inspected.out);
    let gate = folder.file(
        "gate.toml",
        "[[recordings]]\nfiles = [\"pulse:sled206-33g\", \"pulse:doorslam-300-6\"]\n\n[[designs]]\n\
         name = \"stiff\"\nset = [\"lever.preload_torque_nm=6\"]\n",
    );
    let gate = gate.to_str().unwrap();
    for cached in ["0 of 2", "2 of 2"] {
        let done = latchgate(&["gate", gate, "--reports", "none"]);
        assert_eq!(done.code, 0, "{cached}: {} {}", done.out, done.err);
    }
}

/// A direction that contradicts the word is refused; a pulse that only presses the lever shut says so.
#[test]
fn cli_the_direction_of_a_pulse_is_its_words() {
    let word = "pulse:half-sine,peak=30g,duration=11ms,opens-when=positive";
    let done = latchgate(&["replay", word, "--opens-when", "negative", "--no-report"]);
    assert_eq!(done.code, 4, "{}", done.out);
    assert!(
        done.err.contains("the direction of the pulse's word"),
        "{}",
        done.err
    );
    let shut = "pulse:trapezoid,peak=33g,rise=22ms,hold=35ms,fall=28ms,opens-when=negative";
    let codes = |document: &Value| {
        let findings = document["findings"].as_array().unwrap().iter();
        findings
            .map(|one| one["code"].as_str().unwrap().to_string())
            .collect::<Vec<_>>()
    };
    assert_eq!(codes(&judged(shut, &[])), ["pulse-presses-shut"]);
    let arm = format!("lever.center_of_mass_m={:?}", -ARM_M / 10.0);
    assert!(codes(&judged(shut, &["--set", &arm])).is_empty());
    assert_eq!(
        canonical("pulse:polyline,points=0:-0/22:33,unit=g", None).unwrap(),
        canonical("pulse:polyline,points=0:0/22:33,unit=g", None).unwrap()
    );
}
