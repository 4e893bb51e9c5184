//! Guards `latchgate verify`: the run inside a verdict made again, at the process boundary.

use crate::support::{Folder, finish, latchgate, program, signal_file};
use serde_json::Value;

/// Writes the verdict of a replay into `folder` and returns its path.
fn verdict(folder: &Folder, arguments: &[&str]) -> String {
    let mut all = vec!["replay"];
    all.extend(arguments);
    all.extend(["--no-report", "--format", "json"]);
    let done = latchgate(&all);
    assert!([0, 1, 3, 4].contains(&done.code), "{}", done.err);
    folder.write("verdict.json", done.out)
}

fn text_of(path: &str) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[track_caller]
fn check_same(verdict: &str, recording: &str, word: &str) {
    let done = latchgate(&[
        "verify",
        verdict,
        "--recording",
        recording,
        "--format",
        "json",
    ]);
    let document = done.document();
    assert_eq!(done.code, 0, "{document:#}");
    assert_eq!(document["schema"], "latchgate.verify/1");
    assert_eq!(document["same"], true);
    assert_eq!(document["differences"], 0);
    assert_eq!(document["first_difference"], Value::Null);
    assert_eq!(document["verdict"]["stored"], word);
    assert_eq!(document["verdict"]["now"], word);
}

/// Whatever was asked, the run inside the verdict comes to the same numbers.
#[test]
fn cli_verify_repeats_what_was_asked() {
    let folder = Folder::new("verify-same");
    let design = folder.write(
        "own design.toml",
        "name = \"stiff one\"\nbase = \"paper\"\n[lever]\npreload_torque_nm = 0.3\n[tolerance]\npreload_torque_nm = 0.01\nmass_kg = 0\n",
    );
    let burst = signal_file("burst.csv");
    let surviving = signal_file("surviving.csv");
    let nominal = ["--members", "0"];
    for (recording, options, word) in [
        (&burst, &["--limit", "samples=100"][..], "unusable"),
        (&burst, &[][..], "fail"),
        (&surviving, &[][..], "pass"),
        (&surviving, &nominal[..], "pass"),
        (
            &surviving,
            &[
                "--design",
                design.as_str(),
                "--set",
                "stop.restitution=0.55",
                "--members",
                "300",
                "--seed",
                "7",
            ],
            "pass",
        ),
        (
            &burst,
            &[
                "--model",
                "soft",
                "--filter",
                "cfc180",
                "--filter-standard",
                "saej211",
                "--window",
                "-0.01..0.05",
                "--bias",
                "-0.04..-0.002",
                "--members",
                "0",
                "--opens-when",
                "both",
            ],
            "fail",
        ),
        (
            &burst,
            &[
                "--model",
                "rigid",
                "--method",
                "rk4",
                "--steps-per-period",
                "4000",
                "--phi0",
                "0.01",
                "--omega0",
                "-0.1",
                "--resample",
                "12000",
            ],
            "fail",
        ),
    ] {
        let mut all = vec![recording.as_str()];
        all.extend(options);
        let verdict = verdict(&folder, &all);
        check_same(&verdict, recording, word);
    }
}

/// The verdict in a report folder holds the filter table also where only nominal runs are judged.
#[test]
fn cli_verify_takes_the_verdict_of_a_report() {
    let folder = Folder::new("verify-report");
    let out = folder.path().join("out");
    let recording = signal_file("surviving.csv");
    for members in ["0", "200"] {
        latchgate(&[
            "replay",
            &recording,
            "--members",
            members,
            "--out",
            out.to_str().unwrap(),
        ]);
        check_same(
            out.join("verdict.json").to_str().unwrap(),
            &recording,
            "pass",
        );
    }
}

/// Without a name the recording is looked for beside the verdict; a refused one is the same again.
#[test]
fn cli_verify_finds_the_recording_beside_the_verdict() {
    let folder = Folder::new("verify-beside");
    let file = folder.write("it's odd.csv", "time [s],acc_y [g]\n0,1\n0.001,x\n");
    let verdict = verdict(&folder, &[&file]);
    let done = latchgate(&["verify", &verdict]);
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    assert!(done.out.starts_with("SAME\n"), "{}", done.out);
    assert!(done.out.contains("unusable"), "{}", done.out);
}

#[track_caller]
fn check_different(verdict: &str, recording: &str, kind: &str, at: &str, word: &str) {
    let done = latchgate(&[
        "verify",
        verdict,
        "--recording",
        recording,
        "--format",
        "json",
    ]);
    assert_eq!(done.code, 1, "{}", done.err);
    let document = done.document();
    let first = &document["first_difference"];
    assert_eq!(document["same"], false);
    assert_eq!(
        (&first["kind"], &first["at"]),
        (&kind.into(), &at.into()),
        "{first:#}"
    );
    assert!(first["text"].as_str().unwrap().contains(word), "{first:#}");
    let done = latchgate(&["verify", verdict, "--recording", recording]);
    assert_eq!(done.code, 1);
    assert!(done.out.starts_with("DIFFERENT\n"), "{}", done.out);
    assert!(done.out.contains(word), "{}", done.out);
}

/// The first difference is told: another file, another card, another version, another result.
#[test]
fn cli_verify_tells_the_first_difference() {
    let folder = Folder::new("verify-different");
    let recording = signal_file("surviving.csv");
    let stored = verdict(&folder, &[&recording, "--members", "128"]);
    let text = text_of(&stored);
    let document: Value = serde_json::from_str(&text).unwrap();

    let sha = document["recording"]["sha256"].as_str().unwrap();
    let other = folder.write("other.csv", text_of(&recording).replacen("0.0", "0.1", 1));
    std::fs::copy(format!("{recording}.toml"), format!("{other}.toml")).unwrap();
    check_different(&stored, &other, "file", "recording.sha256", sha);

    let copy = folder.write("copy.csv", text_of(&recording));
    check_different(&stored, &copy, "card", "recording.card_sha256", "card");

    let peak = document["nominal"]["peak_angle_rad"].to_string();
    let changed = "0.0123456";
    let forged = folder.write(
        "forged.json",
        text.replacen(
            &format!("\"peak_angle_rad\": {peak}"),
            &format!("\"peak_angle_rad\": {changed}"),
            1,
        ),
    );
    check_different(
        &forged,
        &recording,
        "result",
        "nominal.peak_angle_rad",
        changed,
    );

    let version = format!("\"version\": \"{}\"", env!("CARGO_PKG_VERSION"));
    let older = folder.write(
        "older.json",
        text_of(&forged).replacen(&version, "\"version\": \"0.0.9\"", 1),
    );
    check_different(
        &older,
        &recording,
        "version",
        "nominal.peak_angle_rad",
        "0.0.9",
    );
    // Another version that comes to the same numbers is the same.
    let same = folder.write(
        "same.json",
        text.replacen(&version, "\"version\": \"0.0.9\"", 1),
    );
    let done = latchgate(&["verify", &same, "--recording", &recording]);
    assert_eq!(done.code, 0, "{}", done.out);
    assert!(done.out.contains("0.0.9 in the verdict"), "{}", done.out);

    let passed = folder.write(
        "passed.json",
        text.replacen("\"verdict\": \"pass\"", "\"verdict\": \"fail\"", 1),
    );
    check_different(
        &passed,
        &recording,
        "result",
        "verdict",
        "fail in the verdict, pass now",
    );
}

#[track_caller]
fn check_refused(verdict: &str, word: &str) {
    let done = latchgate(&["verify", verdict]);
    assert_eq!(done.code, 4, "{}", done.out);
    assert!(done.err.contains(word), "{}", done.err);
    assert!(done.out.is_empty(), "{}", done.out);
}

/// What cannot be verified ends with 4 and says why; nothing inside a verdict is run or read that
/// is not a replay of a file of that name.
#[test]
fn cli_verify_refuses_what_it_cannot_repeat() {
    let folder = Folder::new("verify-refused");
    let recording = signal_file("surviving.csv");
    let stored = verdict(&folder, &[&recording, "--members", "0"]);
    check_refused(&stored, "--recording");
    check_refused("no-such-verdict.json", "no-such-verdict.json");
    std::fs::copy(&recording, folder.path().join("surviving.csv")).unwrap();
    let text = text_of(&stored);
    for (from, to, word) in [
        (
            "latchgate.verdict/1",
            "latchgate.margin/1",
            "latchgate.margin/1",
        ),
        ("\"mass_kg\": 0.1475", "\"mass_kg\": -1.0", "mass_kg"),
        ("\"mass_kg\": 0.1475", "\"mess_kg\": 1.0", "mess_kg"),
        ("\"mass_kg\": 0.1475", "\"mass_kg\": null", "mass_kg"),
        // Question and design belong together, whichever of them was changed.
        ("\"mass_kg\": 0.1475", "\"mass_kg\": 0.2", "report_id"),
        ("\"name\": \"paper\"", "\"name\": \"other\"", "report_id"),
        ("\"members\": 0,", "\"members\": 128,", "report_id"),
        (
            "\"members\": 0,",
            "\"mambers\": 0,",
            "did you mean `members`?",
        ),
        (
            "\"members\": 0,",
            "\"members\": \"many\",",
            "--members: must be",
        ),
        ("\"version\": ", "\"edition\": ", "run.version"),
        ("{\n", "{{\n", "JSON"),
    ] {
        assert!(text.contains(from), "{from}");
        let file = folder.write("spoiled.json", text.replacen(from, to, 1));
        check_refused(&file, word);
    }
    // A path inside the verdict is not followed.
    let elsewhere = folder.write(
        "elsewhere.json",
        text.replacen("\"file\": \"", "\"file\": \"../../", 1),
    );
    check_refused(&elsewhere, "report_id");
    assert_eq!(latchgate(&["verify"]).code, 2);
}

/// Nothing can be left out of a verdict, or put into it, without verify saying so, not in its identity either.
#[test]
fn regress_stripped_and_forged_verdicts_do_not_verify() {
    let folder = Folder::new("verify-stripped");
    let recording = signal_file("surviving.csv");
    let card = std::fs::read(format!("{recording}.toml")).unwrap();
    std::fs::copy(&recording, folder.path().join("surviving.csv")).unwrap();
    folder.write("surviving.csv.toml", card);
    let verified = |document: &Value| {
        let file = folder.write("verdict.json", document.to_string());
        latchgate(&["verify", &file]).code
    };
    let newer = verdict(&folder, &[&recording, "--members", "0"]);
    let newer: Value = serde_json::from_str(&text_of(&newer)).unwrap();
    assert_eq!(verified(&newer), 0);
    for pointer in ["", "/recording", "/request"] {
        let block = newer.pointer(pointer).unwrap().as_object().unwrap();
        for key in block.keys() {
            // What is not an answer: time, and what a whole table rests on.
            if ["run", "schema", "design", "file", "recording", "request"].contains(&key.as_str())
                || (pointer.is_empty() && ["filters", "preload_answer"].contains(&key.as_str()))
            {
                continue;
            }
            let mut stripped = newer.clone();
            let block = stripped
                .pointer_mut(pointer)
                .unwrap()
                .as_object_mut()
                .unwrap();
            block.remove(key);
            assert_ne!(verified(&stripped), 0, "{pointer}/{key} was left out");
        }
    }
    let forged = |change: &dyn Fn(&mut Value)| {
        let mut document = newer.clone();
        change(&mut document);
        verified(&document)
    };
    assert_ne!(forged(&|d| d["report_id"] = "0".repeat(64).into()), 0);
    assert_ne!(
        forged(&|d| {
            d["report_id"] = "0".repeat(64).into();
            d["run"]["numbers_revision"] = 0.into();
        }),
        0
    );
    let without =
        |key: &'static str| forged(&move |d| drop(d.as_object_mut().unwrap().remove(key)));
    for key in ["report_id", "verdict", "findings", "request", "recording"] {
        assert_ne!(without(key), 0, "{key} was left out");
    }
    let twice = text_of(&folder.write("a.json", newer.to_string())).replacen(
        "{",
        "{\"verdict\":\"fail\",",
        1,
    );
    let file = folder.write("verdict.json", twice);
    check_refused(&file, "`verdict` twice");
    // Other limits than those of the verdict, as long as the answer is the same.
    let file = folder.write("verdict.json", newer.to_string());
    let within = ["verify", &file, "--limit", "text_bytes=1GiB"];
    assert_eq!(latchgate(&within).code, 0, "{}", latchgate(&within).out);
}

/// A name that looks like an option is found beside the verdict, and where it is named.
#[test]
fn cli_verify_finds_a_recording_whose_name_begins_with_a_hyphen() {
    let folder = Folder::new("verify-hyphen");
    folder.file("-rf.csv", std::fs::read(signal_file("burst.csv")).unwrap());
    let run = |arguments: &[&str]| finish(program().args(arguments).current_dir(folder.path()));
    let options = ["--opens-when", "negative", "--members", "0", "--no-report"];
    let done = run(&[&["replay", "./-rf.csv", "--format", "json"], &options[..]].concat());
    folder.file("verdict.json", done.out);
    for own in [
        &["verify", "verdict.json"][..],
        &["verify", "verdict.json", "--recording", "-rf.csv"],
    ] {
        let done = run(own);
        assert_eq!(done.code, 0, "{own:?}: {}{}", done.out, done.err);
    }
}

/// People read the report, not the document: a file beside the verdict that is not the one that belongs to the run is
/// told, and what was not compared is named.
#[test]
fn cli_verify_compares_the_report_beside_the_verdict() {
    let folder = Folder::new("verify-files");
    let out = folder.path().join("report");
    let shown = out.to_str().unwrap();
    let burst = signal_file("burst.csv");
    let done = latchgate(&["replay", &burst, "--members", "128", "--out", shown]);
    assert_eq!(done.code, 1, "{}", done.err);
    let verdict = out.join("verdict.json");
    let verify = |code: i32| {
        let verdict = verdict.to_str().unwrap();
        let done = latchgate(&["verify", verdict, "--recording", &burst, "--format", "json"]);
        assert_eq!(done.code, code, "{}{}", done.out, done.err);
        done.document()
    };
    let whole = verify(0);
    let same = whole["report"]["same"].as_array().unwrap();
    assert!(same.len() >= 8, "{whole:#}");
    assert_eq!(
        whole["report"]["not_compared"],
        serde_json::json!(["recording.path"])
    );
    for name in ["report.html", "event.svg", "series.csv"] {
        let path = out.join(name);
        let kept = std::fs::read_to_string(&path).unwrap();
        let edited = match name {
            "report.html" => kept.replacen("FAIL", "PASS", 1),
            _ => kept.replacen('1', "2", 1),
        };
        assert_ne!(edited, kept);
        std::fs::write(&path, edited).unwrap();
        let told = verify(1);
        assert_eq!(told["report"]["different"], serde_json::json!([name]));
        assert_eq!(told["same"], false);
        std::fs::write(&path, kept).unwrap();
    }
    std::fs::write(out.join("report.pdf"), "a print").unwrap();
    let told = verify(0);
    assert_eq!(
        told["report"]["not_compared"],
        serde_json::json!(["report.pdf", "recording.path"])
    );
    std::fs::remove_file(out.join("series.csv")).unwrap();
    let told = verify(1);
    assert_eq!(told["report"]["missing"], serde_json::json!(["series.csv"]));
    // A verdict that is kept without its page lacks nothing.
    std::fs::remove_file(out.join("report.html")).unwrap();
    let told = verify(0);
    assert_eq!(told["report"]["missing"], serde_json::json!([]));
}
