//! Guards what the program says of a verdict: reasons, draws, ensembles, and that each code of a reason
//! is documented.

use crate::support::{Folder, data, half_sine, latchgate, signal_file, table, weak, without_run};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[test]
fn cli_tolerances_that_leave_what_is_physical() {
    let folder = Folder::new("wide-tolerances");
    let file = folder.write("a.csv", table(weak));
    let set = [
        "replay",
        &file,
        "--no-report",
        "--opens-when",
        "negative",
        "--transfer",
        "1",
        "--set",
    ];
    let wide = "tolerance.mass_kg=0.06";
    let refused = latchgate(&[&set[..], &[wide]].concat());
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("tolerance.mass_kg"), "{}", refused.err);
    assert_eq!(
        latchgate(&[&set[..], &[wide, "--members", "0"]].concat()).code,
        0
    );
    let design = folder.write(
        "wide.toml",
        "base = \"paper\"\n[tolerance]\nmass_kg = 0.06\n",
    );
    let refused = latchgate(&["replay", &file, "--no-report", "--design", &design]);
    assert_eq!(refused.code, 4);
    assert!(refused.err.contains("tolerance.mass_kg"), "{}", refused.err);
    for members in ["1000001", "-1", "1.5"] {
        let refused = latchgate(&["replay", &file, "--no-report", "--members", members]);
        assert_eq!(refused.code, 2, "{members}");
    }
}

#[test]
fn verif_the_burst_fails_and_the_surviving_pulse_passes_at_any_seed() {
    let seeds = if cfg!(debug_assertions) { 4 } else { 20 };
    for seed in 1..=seeds {
        let seed = seed.to_string();
        for (file, code) in [("burst.csv", 1), ("surviving.csv", 0)] {
            let own = ["replay", &signal_file(file), "--no-report", "--seed", &seed];
            assert_eq!(latchgate(&own).code, code, "{file} {seed}");
        }
    }
}

/// A limit on work that leaves the ensembles out, or breaks them off, leaves the answer open: a lever that the
/// nominal runs alone would pass is no pass, one that they would fail no fail.
#[test]
fn cli_a_limit_on_work_that_cuts_the_ensemble_decides_nothing() {
    let folder = Folder::new("work-limit");
    // Without noise: the draws that a pass takes would reach the limit before the ensembles.
    let silent = folder.write("weak.csv", table(weak));
    let card = "synthetic = true\nopens_when = \"negative\"\n";
    folder.write("weak.csv.toml", card);
    for (file, nominal_code, limits) in [
        (silent, 0, ["work=20000", "work=60000", "work=120000"]),
        (
            signal_file("burst.csv"),
            1,
            ["work=60000", "work=80000", "work=160000"],
        ),
    ] {
        let replay = |further: &[&str]| {
            let first = ["replay", &file, "--no-report", "--format", "json"];
            latchgate(&[&first[..], further].concat())
        };
        assert_eq!(replay(&["--members=0"]).code, nominal_code, "{file}");
        for limit in limits {
            let nominal = replay(&["--members=0", "--limit", limit]);
            assert_eq!(nominal.code, nominal_code, "{file}, {limit}");
            let done = replay(&["--limit", limit]);
            let document = done.document();
            assert_eq!(done.code, 3, "{file}, {limit}: {}", document["why"]);
            assert_eq!(document["verdict"], "undecided", "{file}, {limit}");
            let has_code = |list: &str| {
                let mut entries = document[list].as_array().unwrap().iter();
                entries.any(|entry| entry["code"] == "work-limit")
            };
            assert!(has_code("why") && has_code("findings"), "{file}, {limit}");
        }
    }
}

/// Threads change no byte, neither of the document nor of the report.
#[test]
fn cli_the_same_bytes_for_any_number_of_threads() {
    let folder = Folder::new("threads");
    let file = folder.write("a.csv", table(|t| half_sine(t, 0.0, 0.006, -9.0)));
    let of = |threads: &str| {
        let out = folder.path().join(threads);
        let done = latchgate(&[
            "replay",
            &file,
            "--members",
            "700",
            "--threads",
            threads,
            "--format",
            "json",
            "--set",
            "tolerance.preload_torque_nm=0.01",
            "--out",
            out.to_str().unwrap(),
        ]);
        let pictures: Vec<Vec<u8>> = ["spread.svg", "drivers.svg", "report.html"]
            .iter()
            .map(|name| std::fs::read(out.join(name)).unwrap())
            .collect();
        (without_run(&done.out).to_string(), pictures)
    };
    let one = of("1");
    assert!(one.0.contains("\"members\": 700") || one.0.contains("\"ended\": \"decided\""));
    for threads in ["2", "3"] {
        assert!(of(threads) == one, "{threads} threads give other bytes");
    }
}

/// NHTSA test 7292, curve 148, on the paper's lever. Nominal peaks as an
/// independent program gave them; the verdict names what it hangs on.
#[test]
fn val_a_real_channel_is_undecided_by_bias_and_polarity() {
    let path = data("recordings/nhtsa_v07292.148");
    let file = path.to_str().unwrap();
    let run = |own: &[&str]| {
        let first = [
            "replay",
            file,
            "--unit",
            "g",
            "--no-report",
            "--format",
            "json",
        ];
        latchgate(&[&first[..], own].concat()).document()
    };
    for (bias, peak) in [
        ("none", 0.0531),
        ("-0.02..-0.001", 0.303),
        ("-0.02..-0.00008", 0.0787),
    ] {
        let raw = run(&[
            "--filter",
            "none",
            "--model",
            "rigid",
            "--opens-when",
            "negative",
            "--members",
            "0",
            "--between",
            "linear",
            "--bias",
            bias,
        ]);
        let found = raw["nominal"]["peak_angle_rad"].as_f64().unwrap();
        assert!((found / peak - 1.0).abs() < 3e-3, "{bias}: {found}");
    }
    // As it is in release mode; where runs are slow, with fewer members.
    let short: &[&str] = if cfg!(debug_assertions) {
        &["--members", "600"]
    } else {
        &[]
    };
    let document = run(short);
    assert_eq!(document["verdict"], "undecided");
    let codes: Vec<&str> = document["why"]
        .as_array()
        .unwrap()
        .iter()
        .map(|reason| reason["code"].as_str().unwrap())
        .collect();
    assert!(codes.contains(&"polarity-decides"), "{codes:?}");
    assert!(codes.contains(&"bias-decides"), "{codes:?}");
}

#[test]
fn cli_a_lever_that_cannot_be_followed_ends_with_three() {
    let folder = Folder::new("endless");
    let file = folder.write("quiet.csv", table(weak));
    let done = latchgate(&[
        "replay",
        &file,
        "--model",
        "rigid",
        "--opens-when",
        "negative",
        "--members",
        "0",
        "--omega0",
        "1e-10",
        "--set",
        "stop.restitution=1",
        "--set",
        "lever.pivot_damping_nm_s_per_rad=0",
        "--no-report",
        "--format",
        "json",
    ]);
    assert_eq!(done.code, 3, "{}", done.err);
    let document = done.document();
    assert_eq!(document["why"][0]["code"], "method-broke-down");
    assert!(document["answers"][0]["uncertainty_rad"].is_null());
}

/// NHTSA test 7292, curve 148, nominal runs alone: what an ensemble's reasons
/// name is named without one.
#[test]
fn val_nominal_runs_of_a_real_channel_name_the_bias() {
    let file = data("recordings/nhtsa_v07292.148");
    let document = latchgate(&[
        "replay",
        file.to_str().unwrap(),
        "--unit",
        "g",
        "--members",
        "0",
        "--no-report",
        "--format",
        "json",
    ])
    .document();
    assert_eq!(document["verdict"], "undecided");
    let codes: Vec<&str> = document["why"]
        .as_array()
        .unwrap()
        .iter()
        .map(|reason| reason["code"].as_str().unwrap())
        .collect();
    assert!(codes.contains(&"bias-decides"), "{codes:?}");
}

#[test]
fn tidy_every_reason_is_documented_and_a_test_names_it() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let codes = documented_codes(&root);
    assert_eq!(codes, codes_in_sources(&root), "docs/decision.md, Reasons");
    let tests_of_verdict = root.join("crates/verdict/tests/it");
    let mut tests = text_of(&tests_of_verdict.join("verdict.rs"));
    for file in std::fs::read_dir(tests_of_verdict.join("verdict")).unwrap() {
        tests.push_str(&text_of(&file.unwrap().path()));
    }
    tests.push_str(&text_of(&root.join("tests/it/scatter.rs")));
    for code in &codes {
        assert!(
            tests.contains(&format!("\"{code}\"")),
            "no test names {code}"
        );
    }
}
fn text_of(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// Every string of lower-case words after `code: "`, or first in a pair of code and text, in the file
/// of the reasons, and the codes of reasons in that of a mechanism.
fn codes_in_sources(root: &Path) -> BTreeSet<String> {
    let sources = root.join("crates/verdict/src");
    let source = text_of(&sources.join("reasons.rs"));
    let is_code =
        |word: &str| word.contains('-') && word.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    let mut found: BTreeSet<String> = source
        .split('"')
        .skip(1)
        .step_by(2)
        .filter(|word| is_code(word))
        .map(String::from)
        .collect();
    // A reason without a hyphen is named here, so that the scan above stays simple.
    assert!(source.contains("\"uncertainty\""));
    found.insert("uncertainty".into());
    // That of a mechanism gives findings too, which are documented elsewhere: a reason names its field.
    let mechanism = text_of(&sources.join("mechanism.rs"));
    let after_field = mechanism.split("code: \"").skip(1);
    let codes = after_field.filter_map(|rest| Some(rest.split_once('"')?.0.to_string()));
    found.extend(codes);
    assert!(found.contains("catch-tie"), "no reason of a mechanism");
    found
}

/// Returns the codes in the table of reasons.
fn documented_codes(root: &Path) -> BTreeSet<String> {
    let text = text_of(&root.join("docs/decision.md"));
    let (_, rest) = text.split_once("## Reasons").expect("a table of reasons");
    let table = rest.split("\n## ").next().unwrap();
    table
        .lines()
        .filter_map(|line| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_string()))
        .collect()
}

/// An ensemble that a bound spares is told: as none of its levers crosses, not as one that nobody asked for.
#[test]
fn verif_an_ensemble_that_is_spared_is_told() {
    let program = latchgate(&[
        "replay",
        &signal_file("surviving.csv"),
        "--set",
        "lever.preload_torque_nm=20",
        "--no-report",
    ]);
    assert!(program.out.contains("The lever stays"), "{}", program.out);
    let told = "none of the varied levers can open: the worst never lifts";
    assert!(program.out.contains(told), "{}", program.out);
}

/// Nominal levers are given no table of filters for a program, which wants an answer; an ensemble and a report are.
#[test]
fn verif_the_filter_table_stands_beside_an_ensemble() {
    let folder = Folder::new("filter-table");
    let file = folder.write("a.csv", table(weak));
    let rows = |own: &[&str]| {
        let first = ["replay", &file, "--format", "json"];
        let document = latchgate(&[&first[..], own].concat()).document();
        document["filters"].as_array().unwrap().len()
    };
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    for (kept, of_nominal) in [(&["--no-report"][..], 0), (&["--out", out], 5)] {
        assert_eq!(rows(&[&["--members", "0"], kept].concat()), of_nominal);
        assert_eq!(rows(&[&["--members", "16"], kept].concat()), 5);
    }
}

/// Under a range of factors each is left a part of the work; the message tells the limit that was stated.
#[test]
fn cli_the_limit_of_work_is_told_as_it_was_stated() {
    let arguments = [
        "replay",
        &signal_file("sled_30g_30ms.csv"),
        "--set",
        "lever.preload_torque_nm=4",
        "--transfer",
        "0.5..1",
        "--limit",
        "work=600000",
        "--no-report",
        "--format",
        "json",
    ];
    let done = latchgate(&arguments);
    assert_eq!(done.code, 3, "{}", done.out);
    let document = done.document();
    for list in ["why", "findings"] {
        let entries = document[list].as_array().unwrap();
        let told = entries.iter().find(|entry| entry["code"] == "work-limit");
        let text = told.unwrap()["text"].as_str().unwrap();
        assert!(text.contains("more than 600000 steps"), "{text}");
        assert!(text.contains("work=6000000."), "{text}");
    }
}
