//! Guards what must give no verdict, and cards, design files, filters and windows.

use super::reports::listing;
use super::*;
use crate::support::at_door;

#[track_caller]
pub(super) fn check_unusable(arguments: &[&str], fragment: &str) -> Value {
    let arguments = [arguments, &["--no-report", "--format", "json"]].concat();
    let done = latchgate(&arguments);
    assert_eq!(done.code, 4, "{arguments:?}: {}", done.err);
    let document = done.document();
    assert_eq!(document["verdict"], "unusable");
    assert_eq!(done.err.lines().count(), 1, "{arguments:?}: {}", done.err);
    assert!(
        done.err.starts_with("latchgate: ") && done.err.contains(fragment),
        "{arguments:?}: `{fragment}` not in {}",
        done.err
    );
    document
}

#[test]
fn cli_unusable_recordings_print_the_document_and_one_message() {
    let folder = Folder::new("unusable");
    let missing = folder.path().join("missing.csv");
    let refused = [
        (
            missing.to_str().unwrap(),
            "missing.csv: cannot open the file",
        ),
        (
            folder.path().to_str().unwrap(),
            "it is a folder; name a file in it",
        ),
    ];
    for (path, fragment) in refused {
        let document = check_unusable(&["replay", path], fragment);
        assert_eq!(document["nominal"], Value::Null);
        assert_eq!(document["conditioning"], Value::Null);
        assert_eq!(document["why"][0]["code"], "input-refused");
        assert_eq!(document["findings"][0]["severity"], "blocking");
        assert_eq!(document["recording"]["samples"], 0);
    }
    // A recording whose findings block is replayed all the same, but no reason comes of faulty samples.
    let clipped = folder.write("clipped.csv", table(|t| weak(t).max(-3.0)));
    let document = check_unusable(
        &["replay", &clipped, "--opens-when", "negative"],
        "saturated",
    );
    assert!(document["nominal"]["peak_angle_rad"].as_f64().unwrap() > 0.0);
    assert_eq!(document["why"][0]["code"], "clipping");
    let findings = document["findings"].as_array().unwrap();
    let blocking = findings.iter();
    let blocking = blocking.filter(|finding| finding["severity"] == "blocking");
    let codes: Vec<&Value> = blocking.map(|finding| &finding["code"]).collect();
    let why = document["why"].as_array().unwrap();
    let reasons: Vec<&Value> = why.iter().map(|reason| &reason["code"]).collect();
    assert_eq!(reasons, codes);
    // Refused in the middle: what was known by then is printed.
    let plain = folder.write("plain.csv", table(weak));
    let document = check_unusable(
        &["replay", &plain, "--window", "5..6"],
        "which runs from -0.05 to 0.25",
    );
    assert_eq!(document["nominal"], Value::Null);
    assert_eq!(document["recording"]["samples"], 3001);
    assert_eq!(document["conditioning"]["filter"], "cfc1000");
}

#[cfg(unix)]
#[test]
fn cli_a_file_that_may_not_be_read_is_unusable() {
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::process::CommandExt;
    let folder = Folder::new("secret");
    let secret = folder.write("secret.csv", table(weak));
    fs::set_permissions(&secret, fs::Permissions::from_mode(0o000)).unwrap();
    if fs::File::open(&secret).is_err() {
        check_unusable(&["replay", &secret], "cannot open the file");
        return;
    }
    // Root may read it all the same, so the program runs as nobody, from a place that all may enter.
    let own = folder.path().join("latchgate");
    fs::copy(env!("CARGO_BIN_EXE_latchgate"), &own).unwrap();
    for (path, mode) in [(own.as_path(), 0o755), (folder.path(), 0o755)] {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }
    let done = finish(
        Command::new(&own)
            .args(["replay", &secret, "--no-report"])
            .current_dir(folder.path())
            .uid(65_534)
            .gid(65_534),
    );
    assert_eq!(done.code, 4, "{}", done.err);
    assert!(done.err.contains("cannot open the file"), "{}", done.err);
}

#[cfg(unix)]
#[test]
fn cli_file_names_need_not_be_utf_8() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new("names");
    let name = std::ffi::OsStr::from_bytes(b"pole\xff\x1b[31m.csv");
    fs::write(folder.path().join(name), at_door(&table(weak))).unwrap();
    let done = finish(
        program()
            .arg("replay")
            .arg(name)
            .args(["--opens-when", "negative"])
            .current_dir(folder.path()),
    );
    assert_eq!((done.code, done.err.as_str()), (0, ""));
    assert!(!done.out.contains('\x1b'), "{}", done.out);
    let made = listing(&folder.path().join("reports/out"));
    assert!(made.len() == 1 && made[0].starts_with("pole___31m.csv-paper-"));
    // A card is found beside a name that is no text.
    let mut card = name.to_os_string();
    card.push(".toml");
    fs::write(folder.path().join(card), "opens_wen = \"negative\"\n").unwrap();
    let done = finish(
        program()
            .arg("replay")
            .arg(name)
            .arg("--no-report")
            .current_dir(folder.path()),
    );
    assert_eq!(done.code, 4);
    assert!(
        done.err.contains("did you mean `opens_when`?"),
        "{}",
        done.err
    );
}

#[test]
fn cli_options_go_before_cards_and_cards_before_files() {
    let folder = Folder::new("cards");
    let file = folder.write("pulse.csv", at_door(&table(weak)));
    let card = |text: &str| folder.write("pulse.csv.toml", text);
    let run = |options: &[&str]| {
        let arguments = [
            &["replay", &file, "--no-report", "--format", "json"],
            options,
        ]
        .concat();
        latchgate(&arguments).document()
    };
    let unit = |document: &Value| {
        let block = &document["recording"];
        [&block["unit"], &block["unit_source"]].map(|value| value.as_str().unwrap().to_string())
    };
    assert_eq!(unit(&run(&[])), ["g", "header"]);
    card("unit = \"m/s2\"\nopens_when = \"positive\"\n");
    let document = run(&[]);
    assert_eq!(unit(&document), ["m/s2", "card"]);
    assert_eq!(document["recording"]["opens_when_source"], "card");
    assert_eq!(document["nominal"]["opens_when"], "positive");
    assert_eq!(document["error_budget_rad"]["polarity"], Value::Null);
    assert!(document["findings"].to_string().contains("unit-overridden"));
    let document = run(&["--unit", "ft/s2", "--opens-when", "negative"]);
    assert_eq!(unit(&document), ["ft/s2", "option"]);
    assert_eq!(document["recording"]["opens_when_source"], "option");
    assert_eq!(document["nominal"]["opens_when"], "negative");

    for (text, fragment) in [
        (
            "unit = \"g\"\nopens_wen = \"both\"\n",
            "pulse.csv.toml:2: unknown card key `opens_wen`; did you mean `opens_when`?",
        ),
        (
            "range_g = \"big\"\n",
            "pulse.csv.toml:1: expected `range_g` to be a number",
        ),
        ("unit = \"gram\"\n", "pulse.csv.toml:1: unknown unit `gram`"),
        (
            "opens_when = \"up\"\n",
            "pulse.csv.toml:1: unknown polarity `up`",
        ),
        ("notes = \"\n", "pulse.csv.toml:1: expected TOML"),
        ("rate = 5000.0\n", "expected the stated rate of 5000 Hz"),
    ] {
        card(text);
        let document = check_unusable(&["replay", &file], fragment);
        assert_eq!(document["nominal"], Value::Null, "{text}");
    }
}

#[test]
fn cli_design_files_are_refused_with_the_line() {
    let folder = Folder::new("designs");
    let file = signal_file("surviving.csv");
    for (text, fragment) in [
        (
            &b"name = 3\n"[..],
            "d.toml:1: expected a text for `name`, found an integer",
        ),
        (
            b"\n[lever]\nmass_kg = 0.1\nmas_kg = 3\n",
            "d.toml:4: unknown design key `lever.mas_kg`; did you mean `lever.mass_kg`?",
        ),
        (
            b"[stop]\n# mass\n[lever]\nmass_kg = \"a\"\n",
            "d.toml:4: expected a number for `mass_kg`, found a string",
        ),
        (
            b"[stop]\n\nrestitution = 1.5\n",
            "d.toml:3: stop.restitution must be 0 to 1, found 1.5",
        ),
        (
            b"[lever]\npreload_torque_nm = -1.0\n",
            "d.toml:2: lever.preload_torque_nm must be zero or positive",
        ),
        (
            b"[lever]\nmass_kg = nan\n",
            "d.toml:2: lever.mass_kg must be positive and finite, found NaN",
        ),
        (
            b"name = \"x\"\n[lever\n",
            "d.toml:2: expected a design file in TOML",
        ),
        (
            b"lever = 3\n",
            "d.toml:1: expected a table [lever], found an integer",
        ),
        (
            b"[levers]\nmass_kg = 1\n",
            "d.toml:1: unknown design key `levers`; did you mean `lever`?",
        ),
        (
            b"\nlever.mass_kg = true\n",
            "d.toml:2: expected a number for `mass_kg`, found a boolean",
        ),
        (
            b"[tolerance]\nrestitutio = 1\n",
            "d.toml:2: unknown design key `tolerance.restitutio`; did you mean `tolerance.restitution`?",
        ),
        (
            b"[tolerance]\nrestitution = -1\n",
            "d.toml:2: tolerance.restitution must be zero or positive",
        ),
        (
            b"base = \"paper\"\n[lever]\nmass_kg = 100.0\n",
            "d.toml: lever.moment_of_inertia_kg_m2",
        ),
        (
            b"base = \"paper\"\n[lever]\npreload_torque_nm = 0\nspring_stiffness_nm_per_rad = 0\n",
            "nothing closes the lever",
        ),
        (b"name = \"x\"\xff\n", "d.toml: expected UTF-8"),
    ] {
        let design = folder.write("d.toml", text);
        let done = latchgate(&["replay", &file, "--no-report", "--design", &design]);
        assert_eq!(done.code, 4, "{fragment}: {}", done.err);
        assert_eq!(done.out, "", "no verdict without a design");
        assert!(
            done.err.contains(fragment),
            "`{fragment}` not in {}",
            done.err
        );
        assert_eq!(done.err.lines().count(), 1, "{}", done.err);
    }
    for path in [folder.path().join("no.toml"), folder.path().to_path_buf()] {
        let done = latchgate(&[
            "replay",
            &file,
            "--no-report",
            "--design",
            path.to_str().unwrap(),
        ]);
        assert_eq!(done.code, 4);
        assert!(
            done.err.contains("cannot read the design file"),
            "{}",
            done.err
        );
    }
    // That the two do not go together shows only when the file is read: no wrong usage.
    let light = folder.write(
        "d.toml",
        "base = \"paper\"\n[lever]\nmoment_of_inertia_kg_m2 = 7e-4\n",
    );
    let done = latchgate(&[
        "replay",
        &file,
        "--no-report",
        "--design",
        &light,
        "--set",
        "lever.mass_kg=0.2",
    ]);
    assert_eq!(done.code, 4, "{}", done.err);
    // A byte order mark is no fault; an empty file states no lever.
    let stated = "base = \"paper\"\n[tolerance]\npreload_torque_nm = 0\nmass_kg = 0\n";
    for (text, code) in [(format!("\u{feff}{stated}"), 0), (String::new(), 4)] {
        let design = folder.write("d.toml", text);
        let done = latchgate(&["replay", &file, "--no-report", "--design", &design]);
        assert_eq!(done.code, code, "{}", done.err);
    }
}

#[test]
fn cli_a_filter_that_the_rate_does_not_carry_is_refused() {
    let folder = Folder::new("slow");
    let slow: String = table(weak)
        .lines()
        .enumerate()
        .filter(|(index, _)| *index == 0 || index % 2 == 1)
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    let file = folder.write("slow.csv", slow);
    check_unusable(
        &["replay", &file, "--filter", "cfc1000"],
        "CFC 1000 needs a sample rate of at least 10000 Hz (ten times the class), found 5000 Hz",
    );
    let document = check_verdict(
        &[
            "replay",
            &file,
            "--opens-when",
            "negative",
            "--transfer",
            "1",
        ],
        0,
        "pass",
    );
    assert_eq!(document["conditioning"]["filter"], "none");
    assert!(
        document["findings"]
            .to_string()
            .contains("rate-below-default-filter")
    );
}

/// Outside the window a crossing does not count, but it is not passed over in silence.
#[test]
fn cli_a_window_that_misses_the_crossing_warns() {
    let file = signal_file("surviving.csv");
    let low = ["--set", "criterion.threshold_rad=0.02"];
    let whole = [&["replay", &file][..], &low].concat();
    check_verdict(&whole, 1, "fail");
    let document = check_verdict(&[&whole[..], &["--window", "0.1..0.2"]].concat(), 0, "pass");
    let findings = document["findings"].as_array().unwrap();
    let warning = findings
        .iter()
        .find(|finding| finding["code"] == "crossing-outside-window")
        .unwrap();
    assert_eq!(warning["severity"], "warning");
    assert!((warning["at_s"].as_f64().unwrap() - 0.0142).abs() < 1e-4);
    assert_eq!(document["why"][0]["code"], "setting-decides");
    assert_eq!(document["why"][2]["code"], "crossing-outside-window");
    let document = check_verdict(&[&whole[..], &["--window", "0..0.1"]].concat(), 1, "fail");
    assert!(
        !document["findings"]
            .to_string()
            .contains("crossing-outside-window")
    );
}

/// Values of options are read alike: whatever their case, and counts as `1e2`; what is near a value
/// is named.
#[test]
fn cli_values_of_options_are_read_whatever_their_case() {
    let folder = Folder::new("case");
    let path = folder.write("a.csv", at_door(&table(weak)));
    let with = |options: &[&str]| {
        let own = ["replay", &path, "--no-report", "--format", "JSON"];
        latchgate(&[&own, options].concat())
    };
    let plain = with(&[
        "--opens-when",
        "negative",
        "--unit",
        "g",
        "--filter",
        "cfc180",
    ]);
    let shouted = with(&[
        "--opens-when",
        "NEGATIVE",
        "--unit",
        "G",
        "--filter",
        "CFC180",
    ]);
    assert_eq!(
        (plain.code, shouted.code),
        (0, 0),
        "{}{}",
        plain.err,
        shouted.err
    );
    let id = |done: &crate::support::Done| done.document()["report_id"].clone();
    assert_eq!(id(&plain), id(&shouted));
    let counted = with(&[
        "--opens-when",
        "negative",
        "--members",
        "1e2",
        "--model",
        "Rigid",
    ]);
    assert_eq!(
        counted.document()["request"]["members"],
        100,
        "{}",
        counted.err
    );
    for (option, value, near) in [
        ("--filter", "cfc18O", "cfc180"),
        ("--opens-when", "negativ", "negative"),
        ("--filter-standard", "sae-j211", "saej211"),
    ] {
        let done = with(&[option, value]);
        assert_eq!(done.code, 2, "{value}");
        assert!(
            done.err.contains(&format!("did you mean {near}?")),
            "{}",
            done.err
        );
    }
}

/// An answer that nobody can get is no answer; where stdout is open, to nowhere or not, it is one.
#[cfg(target_os = "linux")]
#[test]
fn cli_a_closed_stdout_is_an_error() {
    let folder = Folder::new("closed");
    let path = folder.write("a.csv", at_door(&table(weak)));
    let run = |redirect: &str| {
        let program = env!("CARGO_BIN_EXE_latchgate");
        let line = format!(
            "'{program}' replay '{path}' --opens-when negative --no-report --members 0 {redirect}"
        );
        finish(std::process::Command::new("sh").args(["-c", &line]))
    };
    let closed = run(">&-");
    assert_eq!(closed.code, 4, "{}", closed.err);
    assert!(closed.err.contains("stdout is closed"), "{}", closed.err);
    assert_eq!(run(">/dev/null").code, 0);
    assert_eq!(run("<>/dev/null >&0").code, 0);
}

/// A name of 250 bytes leaves no room for the card's or the report's.
#[test]
fn cli_a_long_name_needs_no_card_and_no_long_folder() {
    let folder = Folder::new("long");
    let name = format!("{}.csv", "a".repeat(248));
    folder.write(&name, at_door(&table(weak)));
    let done = finish(
        program()
            .args([
                "replay",
                &name,
                "--opens-when",
                "negative",
                "--members",
                "0",
            ])
            .current_dir(folder.path()),
    );
    assert_eq!(done.code, 0, "{}", done.err);
}
