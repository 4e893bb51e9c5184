//! Guards what a pass claims of levers: a lever stated whole, a scatter stated, a share only where something varies,
//! and the share that the design allows.

use crate::support::{Done, Folder, advised, latchgate, signal_file};
use serde_json::Value;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// The paper's lever with tolerances to be stated.
const EXAMPLE: &str = "name = \"own\"\nbase = \"paper\"\n";

/// All six numbers of a lever that a sled pulse of 33 g lifts a little and does not open.
const WHOLE: &str = "\
name = \"whole\"
[lever]
moment_of_inertia_kg_m2 = 8.888e-4
pivot_damping_nm_s_per_rad = 9.3e-5
spring_stiffness_nm_per_rad = 0.370
preload_torque_nm = 3.08
mass_kg = 0.1475
center_of_mass_m = 0.065
";

const STATED: &str = "[tolerance]\npreload_torque_nm = 0\nmass_kg = 0\nrestitution = 0\n";
const NO_INPUT: &str = "[input]\nscale = 0\nbias_g = 0\n";
const SLED: &str = "pulse:sled206-33g,opens-when=positive";

fn judged(recording: &str, design: &str, more: &[&str]) -> Done {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    // Tests that run at once have a folder each.
    let folder = Folder::new(&format!("scatter-{}", COUNT.fetch_add(1, Relaxed)));
    let file = folder.write("d.toml", design);
    let own = ["replay", recording, "--design", &file, "--no-report"];
    latchgate(&[&own[..], more].concat())
}

fn document(recording: &str, design: &str, more: &[&str]) -> Value {
    judged(recording, design, &[&["--format", "json"], more].concat()).document()
}

fn codes(list: &Value) -> Vec<&str> {
    let listed = list.as_array().unwrap().iter();
    listed.map(|one| one["code"].as_str().unwrap()).collect()
}

/// Every door refuses a lever of which a part is missing, and names all that is, in one message.
#[test]
fn cli_a_lever_is_stated_whole() {
    let folder = Folder::new("scatter-whole");
    let only = folder.write("only.toml", "[lever]\npreload_torque_nm = 3.2\n");
    let none = folder.write("none.toml", "name = \"none\"\n");
    folder.write(
        "gate.toml",
        format!("[[recordings]]\nfiles = \"{SLED}\"\n[[designs]]\nfile = \"only.toml\"\n"),
    );
    let gate = folder.path().join("gate.toml");
    let four = [
        "moment_of_inertia_kg_m2",
        "pivot_damping_nm_s_per_rad",
        "spring_stiffness_nm_per_rad",
        "mass_kg, center_of_mass_m",
    ];
    for words in [
        &["replay", SLED, "--design", &only, "--no-report"][..],
        &["margin", SLED, "--design", &only, "--no-report"],
        &["static", &only, "--no-report"],
        &["gate", gate.to_str().unwrap(), "--no-store"],
    ] {
        let done = latchgate(words);
        assert_eq!(done.code, 4, "{words:?} {}", done.out);
        assert!(
            four.iter().all(|key| done.err.contains(key)),
            "{}",
            done.err
        );
        assert!(done.err.contains("base = \"paper\""), "{}", done.err);
        assert!(!done.err.contains("preload_torque_nm"), "{}", done.err);
    }
    let done = latchgate(&["replay", SLED, "--design", &none, "--no-report"]);
    assert_eq!(done.code, 4);
    assert!(done.err.contains("preload_torque_nm"), "{}", done.err);
    // An override changes a value; it states no lever.
    let set = ["--set", "lever.mass_kg=0.1475"];
    let own = ["replay", SLED, "--design", &only, "--no-report"];
    assert_eq!(latchgate(&[&own[..], &set].concat()).code, 4);
    for (text, expected) in [
        (
            "base = \"papers\"\n",
            "odd.toml:1: expected \"paper\" for `base`",
        ),
        ("base = \"\"\n", "odd.toml:1: expected \"paper\" for `base`"),
        (
            "[lever]\nbase = \"paper\"\n",
            "odd.toml:2: expected `base` above the tables",
        ),
    ] {
        let file = folder.write("odd.toml", text);
        let done = latchgate(&["replay", SLED, "--design", &file, "--no-report"]);
        assert_eq!(done.code, 4);
        assert!(done.err.contains(expected), "{}", done.err);
    }
}

/// What a file leaves to the example stands in the document, and is marked in the report's table.
#[test]
fn cli_what_was_not_stated_is_marked() {
    let folder = Folder::new("scatter-marked");
    let file = folder.write(
        "d.toml",
        format!("{EXAMPLE}[lever]\npreload_torque_nm = 2.0\n{STATED}"),
    );
    let out = folder.path().join("out");
    let own = ["replay", SLED, "--design", &file, "--members", "0"];
    let set = [
        "--set",
        "lever.mass_kg=0.15",
        "--out",
        out.to_str().unwrap(),
    ];
    latchgate(&[&own[..], &set].concat());
    let text = std::fs::read_to_string(out.join("verdict.json")).unwrap();
    let stored: Value = serde_json::from_str(&text).unwrap();
    let not_stated = stored["design"]["not_stated"].to_string();
    for key in [
        "lever.moment_of_inertia_kg_m2",
        "stop.restitution",
        "input.scale",
    ] {
        assert!(not_stated.contains(key), "{not_stated}");
    }
    // One is stated by the file, the other by an override.
    for key in ["lever.preload_torque_nm", "lever.mass_kg"] {
        assert!(!not_stated.contains(key), "{not_stated}");
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Moment of inertia about the pivot, not stated: the example's"));
    assert!(page.contains("<th>Preload torque</th>"));
    let verified = latchgate(&["verify", out.join("verdict.json").to_str().unwrap()]);
    assert_eq!(verified.code, 0, "{}{}", verified.out, verified.err);
}

/// A table of tolerances that names two of them leaves the restitution's as it is, marked as not stated.
#[test]
fn cli_tolerances_that_are_stated_take_no_others_away() {
    let tolerances = "[tolerance]\npreload_torque_nm = 0\nmass_kg = 0\n";
    let design = format!("{EXAMPLE}{tolerances}");
    let judged = document(SLED, &design, &["--members", "128"]);
    assert_eq!(judged["design"]["tolerance"]["restitution"], 0.02);
    let not_stated = judged["design"]["not_stated"].to_string();
    assert!(not_stated.contains("tolerance.restitution"), "{not_stated}");
    let own = format!("{design}restitution = 0.05\n");
    let judged = document(SLED, &own, &["--members", "128"]);
    assert_eq!(judged["design"]["tolerance"]["restitution"], 0.05);
    let not_stated = judged["design"]["not_stated"].to_string();
    assert!(
        !not_stated.contains("tolerance.restitution"),
        "{not_stated}"
    );
}

/// A pass waits for the scatter of preload and unbalance, with an ensemble or without; 0 is a statement, a fail waits
/// for nothing, and the paper's lever gives no tolerances away.
#[test]
fn cli_a_pass_waits_for_the_scatter() {
    for (design, missing) in [
        (WHOLE.to_string(), &["preload_torque_nm", "mass_kg"][..]),
        (
            format!("{WHOLE}[tolerance]\nrestitution = 0\npreload_torque_nm = 0\n"),
            &["mass_kg"],
        ),
        (
            format!("{WHOLE}[tolerance]\ncenter_of_mass_m = 0\n"),
            &["preload_torque_nm"],
        ),
    ] {
        for members in ["0", "128"] {
            let asked = [
                "--members",
                members,
                "--set",
                "input.scale=0",
                "--set",
                "input.bias_g=0",
            ];
            let done = judged(SLED, &design, &[&asked[..], &["--format", "json"]].concat());
            let document = done.document();
            assert_eq!(done.code, 3, "{missing:?} {}", document["why"]);
            assert!(codes(&document["findings"]).contains(&"scatter-unstated"));
            assert_eq!(document["why"][0]["code"], "needs-word");
            let text = document["why"][0]["text"].as_str().unwrap();
            for key in ["preload_torque_nm", "mass_kg"] {
                let named = format!("tolerance.{key}=VALUE");
                assert_eq!(text.contains(&named), missing.contains(&key), "{text}");
            }
            // What it asks for is what it takes.
            let stated: Vec<String> = missing
                .iter()
                .map(|key| format!("tolerance.{key}=0"))
                .collect();
            let stated = stated.iter().flat_map(|word| ["--set", word.as_str()]);
            let stated: Vec<&str> = asked.into_iter().chain(stated).collect();
            assert_eq!(judged(SLED, &design, &stated).code, 0, "{stated:?}");
        }
    }
    let weak = WHOLE.replace("3.08", "0.1");
    let document = document(SLED, &weak, &["--members", "128"]);
    assert_eq!(document["verdict"], "fail");
    assert!(codes(&document["findings"]).contains(&"scatter-unstated"));
    let paper = judged(&signal_file("surviving.csv"), EXAMPLE, &[]);
    assert_eq!(paper.code, 3, "{}", paper.out);
    assert!(paper.out.contains("tolerance.mass_kg"), "{}", paper.out);
}

/// Without a quiet stretch nothing shows the noise: who loses it, by cut rows or another instant of contact, gains no
/// pass; a short one is drawn.
#[test]
fn cli_a_lost_quiet_stretch_gains_no_pass() {
    let folder = Folder::new("scatter-noise");
    let whole = crate::support::root().join("tests/data/noisy_near_the_limit.csv");
    let text = std::fs::read_to_string(&whole).unwrap();
    let from = |start: f64| {
        let kept = text.lines().filter(|line| {
            let time = line.split(',').next().and_then(|time| time.parse().ok());
            time.is_none_or(|time: f64| time > start - 1e-9)
        });
        kept.collect::<Vec<_>>().join("\n") + "\n"
    };
    let design = folder.write("d.toml", format!("{EXAMPLE}{STATED}"));
    let asked = [
        "--design",
        &design,
        "--opens-when",
        "negative",
        "--model",
        "rigid",
    ];
    let alone = ["--members", "0", "--transfer", "1", "--no-report"];
    let asked = [&asked[..], &alone].concat();
    let (cut, short) = (
        folder.write("cut.csv", from(0.0)),
        folder.write("short.csv", from(-0.003)),
    );
    // Quiet samples that somebody filled with zeros, all of them or nine of ten.
    let filled = |kept: i32| {
        let fill = |(number, line): (usize, &str)| {
            let (time, _) = line.split_once(',').unwrap_or((line, ""));
            let is_quiet = time.parse().is_ok_and(|time: f64| time < -1e-3 + 1e-9);
            let is_kept = (number as i32) < kept;
            match is_quiet && !is_kept {
                true => format!("{time},0\n"),
                false => format!("{line}\n"),
            }
        };
        text.lines().enumerate().map(fill).collect::<String>()
    };
    // As many at the end, so that the record is silent on both sides of a noisy event.
    let ends: Vec<String> = filled(0).lines().map(String::from).collect();
    let (kept, end) = ends.split_at(ends.len() - 260);
    let end = end
        .iter()
        .map(|line| format!("{},0", line.split_once(',').unwrap().0));
    let ends: Vec<String> = kept.iter().cloned().chain(end).collect();
    let (zero, mostly, ends) = (
        folder.write("zero.csv", filled(0)),
        folder.write("mostly.csv", filled(25)),
        folder.write("ends.csv", ends.join("\n")),
    );
    let accept = ["--accept", "noise"];
    for (file, more, code, said) in [
        (whole.to_str().unwrap(), &[][..], 3, "noise"),
        (
            whole.to_str().unwrap(),
            &["--time-zero", "-0.022"],
            3,
            "noise",
        ),
        (&short, &[], 3, "noise"),
        (&short, &accept, 3, "noise"),
        (&zero, &[], 3, "--accept noise"),
        (&ends, &[], 3, "--accept noise"),
        // Nine of ten zeros still show how far what is left decides.
        (&mostly, &[], 3, "noise-unknown"),
        (&mostly, &accept, 3, "noise"),
        (&cut, &[], 3, "--accept noise"),
        (&cut, &accept, 0, "PASS"),
    ] {
        // Without what its ends held a record has another change of velocity.
        let change = if file == ends { "0.00225" } else { "0.0055" };
        let change = ["--velocity-change", change];
        let done = latchgate(&[&["replay", file], &asked[..], &change, more].concat());
        assert_eq!(done.code, code, "{file} {more:?}: {}", done.out);
        assert!(done.out.contains(said), "{file} {more:?}: {}", done.out);
    }
}

/// Copies of one lever are no statistics: where nothing varies there is no ensemble and no share, and where the
/// readings alone do, no word of levers.
#[test]
fn cli_without_scatter_there_is_no_share_of_levers() {
    let alone = format!("{WHOLE}{STATED}{NO_INPUT}");
    let nothing = document(SLED, &alone, &[]);
    assert_eq!(nothing["verdict"], "pass", "{}", nothing["why"]);
    assert!(nothing["ensemble"].is_null());
    assert!(codes(&nothing["why"]).contains(&"nothing-varied"));
    let rule = nothing["decision_rule"].as_str().unwrap();
    assert!(rule.starts_with("Nominal runs alone"), "{rule}");
    let text = judged(SLED, &alone, &[]).out;
    assert!(text.contains("This one lever stays"), "{text}");
    assert!(
        !text.contains("varied levers open") && !text.contains("confidence"),
        "{text}"
    );

    let surviving = signal_file("surviving.csv");
    let readings = format!("{EXAMPLE}{STATED}");
    let document = document(&surviving, &readings, &[]);
    assert_eq!(
        document["ensemble"]["varied"], "readings",
        "{}",
        document["why"]
    );
    let text = judged(&surviving, &readings, &[]).out;
    assert!(text.contains("This one lever stays"), "{text}");
    let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flat.contains("0 of 128 readings of this recording open (soft stop, fewer than 3.4 % of readings, at 98.75 % confidence); rigid stop: 0 of 128"), "{flat}");
    assert!(!flat.contains("varied levers"), "{flat}");
    assert!(
        flat.contains("nothing of the lever; reading: scale ±1 %, bias ±0.1 g"),
        "{flat}"
    );

    // The rigid stop has its restitution alone: a scatter of the soft one's numbers varies no lever there.
    let radius = format!("{EXAMPLE}{STATED}radius_m = 0.01\n");
    for (stop, varied) in [("rigid", "readings"), ("soft", "levers-and-readings")] {
        let found = self::document(&surviving, &radius, &["--model", stop]);
        assert_eq!(
            found["ensemble"]["varied"], varied,
            "{stop}: {}",
            found["why"]
        );
    }
    let unmoved = format!("{alone}[stop]\nradius_m = 0.1\n")
        .replace("mass_kg = 0\n", "mass_kg = 0\nradius_m = 0.01\n");
    let found = self::document(SLED, &unmoved, &["--model", "rigid"]);
    assert!(found["ensemble"].is_null(), "{}", found["ensemble"]);

    let both = judged(
        &surviving,
        &format!("{EXAMPLE}[tolerance]\npreload_torque_nm = \"5 %\"\nmass_kg = 0\n"),
        &[],
    )
    .out;
    let flat = both.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        flat.contains("% of levers and readings, at 98.75 % confidence"),
        "{flat}"
    );
    assert!(
        flat.contains(
            "preload torque ±5 %, restitution of the stop ±0.02; reading: scale ±1 %, bias ±0.1 g"
        ),
        "{flat}"
    );
}

/// A share follows the value that an override tries; what is no share is refused.
#[test]
fn cli_a_share_follows_its_value() {
    let surviving = signal_file("surviving.csv");
    let design = format!("{EXAMPLE}[tolerance]\npreload_torque_nm = \"5 %\"\nmass_kg = \"2 %\"\n");
    let deviation = |more: &[&str]| {
        let document = document(&surviving, &design, more);
        let drivers = document["ensemble"]["drivers"].as_array().unwrap().clone();
        let mut drivers = drivers.into_iter();
        let driver = drivers.find(|one| one["parameter"] == "lever.preload_torque_nm");
        driver.unwrap()["standard_deviation"].as_f64().unwrap()
    };
    assert_eq!(deviation(&[]), 0.05 * 0.1);
    assert_eq!(
        deviation(&["--set", "lever.preload_torque_nm=0.2"]),
        0.05 * 0.2
    );
    assert_eq!(
        deviation(&["--set", "tolerance.preload_torque_nm=0.004"]),
        0.004
    );
    assert_eq!(
        deviation(&["--set", "tolerance.preload_torque_nm=10 %"]),
        0.1 * 0.1
    );
    // In quotes, as in a file.
    assert_eq!(
        deviation(&["--set", "tolerance.preload_torque_nm=\"10 %\""]),
        0.1 * 0.1
    );
    for (share, said) in [
        ("-5 %", "not from 0 % to less than 33 %"),
        ("33 %", "not from 0 % to less than 33 %"),
        ("nan %", "not from 0 % to less than 33 %"),
        ("five %", "no number with %"),
        ("5", "no number with %"),
    ] {
        let wrong = format!("{EXAMPLE}[tolerance]\npreload_torque_nm = \"{share}\"\n");
        let done = judged(&surviving, &wrong, &[]);
        assert_eq!(done.code, 4, "{share}");
        assert!(
            done.err.contains("d.toml:4:") && done.err.contains(said),
            "{}",
            done.err
        );
        assert_eq!(done.err.lines().count(), 1, "{}", done.err);
    }
    // A share of nothing would scatter nothing in silence.
    let done = judged(&surviving, &design, &["--set", "lever.preload_torque_nm=0"]);
    assert!(matches!(done.code, 2 | 4), "{}", done.code);
    assert!(
        done.err.contains("tolerance.preload_torque_nm"),
        "{}",
        done.err
    );
}

/// The share that may open is the design's: looks, sentences and the number of members follow it.
#[test]
fn cli_the_open_share_is_the_designs() {
    let surviving = signal_file("surviving.csv");
    let design = |criterion: &str| {
        format!(
            "{EXAMPLE}[tolerance]\npreload_torque_nm = \"2 %\"\nmass_kg = \"1 %\"\n[criterion]\n{criterion}"
        )
    };
    let tight = design("open_share = 0.001\n");
    let few = document(&surviving, &tight, &["--members", "2048"]);
    assert_eq!(few["verdict"], "undecided", "{}", few["why"]);
    let reasons = few["why"].as_array().unwrap();
    let reason = reasons
        .iter()
        .find(|reason| reason["code"] == "members-too-few");
    let text = reason.unwrap()["text"].as_str().unwrap();
    assert!(text.contains("4380") && text.contains("0.1 %"), "{text}");
    let many = document(&surviving, &tight, &[]);
    let ensemble = &many["ensemble"];
    assert_eq!(many["verdict"], "pass", "{}", many["why"]);
    assert!(ensemble["members"].as_u64().unwrap() >= 4380);
    assert!(ensemble["p_upper"].as_f64().unwrap() <= 0.001);
    assert!(
        ensemble["generator"]
            .as_str()
            .unwrap()
            .contains("not truncated")
    );
    // More confidence takes more members.
    let sure = document(&surviving, &design("confidence = 0.999\n"), &[]);
    assert_eq!(sure["ensemble"]["confidence"], 1.0 - 0.001 / 4.0);
    assert!(sure["ensemble"]["members"].as_u64().unwrap() > 128);
    for wrong in [
        "open_share = 0\n",
        "open_share = 1e-9\n",
        "open_share = 1\n",
        "confidence = 1\n",
        "confidence = nan\n",
    ] {
        let done = judged(&surviving, &design(wrong), &[]);
        assert_eq!(done.code, 4, "{wrong}");
        assert!(done.err.contains("from 0.00001 to 0.9999"), "{}", done.err);
    }
    // A looser one than the rule's own is warned of.
    let loose = document(
        &surviving,
        &design("open_share = 0.3\n"),
        &["--members", "128"],
    );
    assert!(codes(&loose["findings"]).contains(&"design-implausible"));
}

/// A share so small that the first look cannot show it is searched for with as many levers as show it.
#[test]
fn cli_the_advice_is_held_to_the_share_of_the_design() {
    let tolerances = "[tolerance]\npreload_torque_nm = \"1 %\"\nmass_kg = \"1 %\"\n";
    let design = format!("{EXAMPLE}{tolerances}[criterion]\nopen_share = 0.01\n");
    let burst = signal_file("burst.csv");
    let folder = Folder::new("scatter-advice");
    let file = folder.write("d.toml", &design);
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    advised(&["replay", &burst, "--design", &file, "--out", out]);
    let stored = std::fs::read_to_string(folder.path().join("out/verdict.json")).unwrap();
    let judged: Value = serde_json::from_str(&stored).unwrap();
    let least = judged["preload_answer"]["safe_from"].as_f64();
    let least = least.unwrap_or_else(|| panic!("{}", judged["preload_answer"]));
    let set = format!("lever.preload_torque_nm={least}");
    let judged = document(&burst, &design, &["--set", &set]);
    assert_eq!(judged["verdict"], "pass", "{}", judged["why"]);
    let members = &judged["ensemble"]["members"];
    assert!(
        members.as_u64().is_none_or(|members| members >= 437),
        "{members}"
    );
}

/// What no production keeps is no scatter.
#[test]
fn cli_a_scatter_too_small_for_any_production_is_said() {
    for (share, is_said) in [
        ("1e-12", true),
        ("\"0.001 %\"", true),
        ("0", false),
        ("\"0.1 %\"", false),
    ] {
        let design = format!("{EXAMPLE}[tolerance]\npreload_torque_nm = 0\nmass_kg = {share}\n");
        let judged = document(SLED, &design, &["--members", "0"]);
        let findings = judged["findings"].to_string();
        let said = findings.contains("tolerance.mass_kg is");
        assert_eq!(said, is_said, "{share}: {findings}");
    }
}

/// A design as a document holds it states its lever whole too.
#[test]
fn regress_a_lever_in_a_document_is_whole() {
    let whole = serde_json::to_value(latchgate::pipeline::Design::reference()).unwrap();
    latchgate::pipeline::design_from_json(&whole).unwrap();
    let mut half = whole.clone();
    half["lever"].as_object_mut().unwrap().remove("mass_kg");
    let error = latchgate::pipeline::design_from_json(&half).unwrap_err();
    assert!(error.contains("mass_kg"), "{error}");
    let mut none = whole;
    none.as_object_mut().unwrap().remove("lever");
    let error = latchgate::pipeline::design_from_json(&none).unwrap_err();
    assert!(error.contains("preload_torque_nm"), "{error}");
}
