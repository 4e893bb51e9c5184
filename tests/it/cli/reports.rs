//! Guards what a replay leaves on disk: where, which files, and the same bytes each time.

use super::*;

pub(super) fn listing(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

const REPORT_FILES: [&str; 11] = [
    "acceleration.svg",
    "amplitude-spectra.svg",
    "angle.svg",
    "drivers.svg",
    "event.svg",
    "phase-plane.svg",
    "report.html",
    "series.csv",
    "spectrogram.svg",
    "spread.svg",
    "verdict.json",
];

/// The files of a report with the note of where the recording was.
fn kept() -> Vec<&'static str> {
    let mut names = REPORT_FILES.to_vec();
    names.push("recording.path");
    names.sort_unstable();
    names
}

fn id_of(folder: &Path) -> String {
    let text = fs::read_to_string(folder.join("verdict.json")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    document["report_id"].as_str().unwrap().to_string()
}

#[test]
fn cli_reports_go_where_they_are_asked_to_and_nowhere_else() {
    let folder = Folder::new("reports");
    let run = |arguments: &[&str]| finish(program().args(arguments).current_dir(folder.path()));
    let out = folder.path().join("reports/out");
    let file = signal_file("surviving.csv");
    let quiet = run(&["replay", &file, "--no-report", "--no-advice"]);
    assert_eq!(quiet.code, 0);
    assert!(listing(folder.path()).is_empty());

    // The text is the same but for the lines with paths.
    let done = run(&["replay", &file, "--no-advice"]);
    let report = |line: &&str| !(line.contains("reports/out") || line.contains("verify"));
    let words: Vec<&str> = done.out.lines().filter(report).collect();
    assert_eq!(words, quiet.out.lines().collect::<Vec<_>>());

    // The folder's name carries the identity, and so do page and plots.
    let names = listing(&out);
    let [name] = names.as_slice() else {
        panic!("{names:?}")
    };
    let id = id_of(&out.join(name));
    assert_eq!(*name, format!("surviving.csv-paper-{}", &id[..8]));
    assert_eq!(listing(&out.join(name)), kept());
    assert_eq!(listing(folder.path()), ["reports"]);
    assert!(
        done.out
            .contains(&format!("reports/out/{name}/report.html\n"))
    );
    let verify = format!("latchgate verify reports/out/{name}/verdict.json\n");
    assert!(done.out.contains(&verify), "{}", done.out);
    for file in ["report.html", "angle.svg"] {
        let text = fs::read_to_string(out.join(name).join(file)).unwrap();
        assert!(text.contains(&id[..8]), "{file}");
    }

    // Another question has another folder, and names what is modified.
    let heavier = run(&[
        "replay",
        &file,
        "--set",
        "lever.mass_kg=0.16",
        "--no-advice",
    ]);
    assert_eq!(listing(&out).len(), 2);
    let modified = "design       the paper's example lever, modified: mass 0.16 kg (0.1475)\n";
    assert!(heavier.out.contains(modified), "{}", heavier.out);
    let other = listing(&out)
        .into_iter()
        .find(|other| other != name)
        .unwrap();
    let page = fs::read_to_string(out.join(&other).join("report.html")).unwrap();
    assert!(
        page.contains("the paper's example lever, modified: mass 0.16")
            && page.contains("Mass, modified")
    );

    let there = folder.path().join("there/it is");
    let set = ["--set", "name=../a/b c", "--format", "json"];
    let json = run(&[&["replay", &file, "--out", "there/it is"], &set[..]].concat());
    assert_eq!(listing(&there), kept());
    let stored = fs::read_to_string(there.join("verdict.json")).unwrap();
    assert_eq!(without_run(&stored), without_run(&json.out));
    // The search for what passes is made for a report.
    let mut advised: Value = serde_json::from_str(&json.out).unwrap();
    assert!(advised["preload_answer"].take().is_object());
    let keys = advised.as_object_mut().unwrap();
    assert!(keys.remove("restitution_answer").is_some());
    let words = ["replay", &file, "--no-report"];
    let unkept = run(&[&words[..], &set[..]].concat());
    let mut unkept: Value = serde_json::from_str(&unkept.out).unwrap();
    advised["run"].take();
    unkept["run"].take();
    assert_eq!(advised, unkept);

    // A run that judges nothing touches no report and makes no folder.
    let cut = folder.write("cut.csv", "time_s,acc_y_g\n0,1\n0.0001,x\n");
    for (recording, options) in [
        (cut.as_str(), &[][..]),
        ("missing.csv", &[]),
        (file.as_str(), &["--channel", "nope"]),
    ] {
        let before = fs::read(there.join("verdict.json")).unwrap();
        let words = ["replay", recording, "--out", "there/it is"];
        let refused = run(&[&words, options].concat());
        assert_eq!((refused.code, refused.out.as_str()), (4, ""));
        assert_eq!(refused.err.lines().count(), 1, "{}", refused.err);
        assert_eq!(listing(&there), kept());
        assert_eq!(fs::read(there.join("verdict.json")).unwrap(), before);
        assert_eq!(
            run(&[&["replay", recording, "--out", "fresh"], options].concat()).code,
            4
        );
        assert!(!folder.path().join("fresh").exists());
    }

    // What others put into the folder stays, and another's report is not replaced in silence.
    fs::write(there.join("notes.txt"), "mine").unwrap();
    let again = run(&["replay", &file, "--out", "there/it is"]);
    assert!(
        again.err.contains("an earlier report was replaced"),
        "{}",
        again.err
    );
    assert_ne!(
        stored,
        fs::read_to_string(there.join("verdict.json")).unwrap()
    );
    assert!(there.join("notes.txt").exists());
    assert_eq!(listing(&there).len(), kept().len() + 1);
}

/// A folder is a report's if its document says so, not because a file has the name of one and tells of latchgate.
#[test]
fn regress_a_folder_that_tells_of_latchgate_is_no_report() {
    let folder = Folder::new("told");
    let file = signal_file("surviving.csv");
    let replay = |out: &str| {
        let words = ["replay", &file, "--members", "0", "--out", out];
        finish(program().args(words).current_dir(folder.path()))
    };
    for (number, (name, text)) in [
        ("verdict.json", "seen with latchgate, to be discussed"),
        (
            "verdict.json",
            r#"{"tool": "latchgate", "schema": "ours/1"}"#,
        ),
        (
            "verdict.json",
            r#"{"based_on": {"schema": "latchgate.verdict/1"}}"#,
        ),
        ("verdict.json", r#"{"schema": "latchgate.margin/1"}"#),
        ("static.json", r#"{"by": ["latchgate.static/1"]}"#),
        ("compare.html", "<title>latchgate, three years on</title>"),
    ]
    .into_iter()
    .enumerate()
    {
        let path = folder.write(&format!("own{number}/{name}"), text);
        let refused = replay(&format!("own{number}"));
        assert_eq!(refused.code, 4, "{name}: {}", refused.err);
        assert!(refused.err.contains("an empty folder"), "{}", refused.err);
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        assert_eq!(
            listing(&folder.path().join(format!("own{number}"))).len(),
            1
        );
    }
    // The page of several verdicts and every later report are replaced.
    assert_eq!(replay("a").code, 0);
    let compare = || {
        let words = [
            "compare",
            "a/verdict.json",
            "a/verdict.json",
            "--out",
            "both",
        ];
        finish(program().args(words).current_dir(folder.path()))
    };
    for round in 0..2 {
        let done = compare();
        assert_eq!(done.code, 0, "{round}: {}", done.err);
    }
}

/// The series that is asked for is that of the report's folder.
#[test]
fn cli_the_series_is_that_of_the_report() {
    let folder = Folder::new("series");
    let file = signal_file("surviving.csv");
    let run = |words: &[&str]| finish(program().args(words).current_dir(folder.path()));
    let asked = [
        "replay",
        &file,
        "--members",
        "0",
        "--series",
        "s.csv",
        "--out",
        "report",
    ];
    assert_eq!(run(&asked).code, 0);
    let alone = fs::read(folder.path().join("s.csv")).unwrap();
    assert!(alone == fs::read(folder.path().join("report/series.csv")).unwrap());
    let without = [
        "replay",
        &file,
        "--members",
        "0",
        "--series",
        "t.csv",
        "--no-report",
    ];
    assert_eq!(run(&without).code, 0);
    assert!(alone == fs::read(folder.path().join("t.csv")).unwrap());
    assert_eq!(run(&["replay", &file, &file, "--series", "u.csv"]).code, 2);
}

/// Verdicts side by side: what was changed and what that did, then only what differs, settings and design
/// before results.
#[test]
fn cli_two_verdicts_are_compared() {
    let folder = Folder::new("compare");
    let file = signal_file("burst.csv");
    let run = |words: &[&str]| finish(program().args(words).current_dir(folder.path()));
    let base = ["replay", &file, "--members", "0", "--out"];
    assert_eq!(run(&[&base[..], &["a"]].concat()).code, 1);
    let other = ["b", "--set", "lever.mass_kg=0.15", "--filter", "none"];
    assert_eq!(run(&[&base[..], &other].concat()).code, 1);
    let same = run(&["compare", "a/verdict.json", "a/verdict.json"]);
    assert_eq!((same.code, same.out.split(' ').next()), (0, Some("SAME")));
    let brief = run(&["compare", "a/verdict.json", "b/verdict.json", "--no-report"]);
    let first = "Mass of the lever 0.1475 kg → 0.15 kg; filter default → none; all else equal: FAIL in all.\n";
    assert!(brief.out.starts_with(first), "{}", brief.out);
    assert!(
        brief
            .out
            .contains("channel acceleration y (g), design: the paper's example lever")
    );
    assert!(!brief.out.contains("nominal."), "{}", brief.out);
    let several = run(&[
        "compare",
        "a/verdict.json",
        "a/verdict.json",
        "b/verdict.json",
        "--no-report",
    ]);
    assert!(
        several.out.contains("0.1475 kg → 0.1475 kg → 0.15 kg"),
        "{}",
        several.out
    );
    let three = [
        "compare",
        "a/verdict.json",
        "a/verdict.json",
        "b/verdict.json",
        "--out",
        "d",
    ];
    assert_eq!(run(&three).code, 1);
    let page = fs::read_to_string(folder.path().join("d/compare.html")).unwrap();
    assert!(
        page.contains("<path class=\"verdict-c\"") && page.contains("C opens 14.4"),
        "three curves"
    );
    let done = run(&["compare", "a/verdict.json", "b/verdict.json", "-v"]);
    assert_eq!((done.code, done.err.as_str()), (1, ""));
    let at = |words: &str| {
        done.out
            .find(words)
            .unwrap_or_else(|| panic!("{words}: {}", done.out))
    };
    assert!(at("request.filter") < at("design.lever.mass_kg"));
    assert!(at("design.lever.mass_kg") < at("nominal.peak_angle_rad"));
    assert!(!done.out.contains("spring_stiffness") && !done.out.contains("elapsed"));
    let json = run(&[
        "compare",
        "a/verdict.json",
        "b/verdict.json",
        "--format",
        "json",
    ]);
    assert_eq!(json.document()["same"], false);
    // The page holds both curves of each panel, and the table they are drawn from.
    let pages: Vec<_> = fs::read_dir(folder.path().join("reports/out"))
        .unwrap()
        .collect();
    assert_eq!(pages.len(), 2, "A with itself, and with B");
    let line = done.out.lines().last().unwrap();
    let page = line.strip_prefix("page  ").expect(line);
    let page = fs::read_to_string(folder.path().join(page)).unwrap();
    for class in ["verdict-a", "verdict-b"] {
        assert_eq!(
            page.matches(&format!("<path class=\"{class}\"")).count(),
            3,
            "{class}"
        );
    }
    assert!(
        page.contains("request.filter") && page.contains("id=\"series\">time_s,a_acceleration")
    );
    // Without the series of one there is no curve, and that is said.
    fs::remove_file(folder.path().join("b/series.csv")).unwrap();
    assert_eq!(
        run(&["compare", "a/verdict.json", "b/verdict.json", "--out", "c"]).code,
        1
    );
    let page = fs::read_to_string(folder.path().join("c/compare.html")).unwrap();
    assert!(page.contains("There are no curves") && !page.contains("<path class=\"verdict-a\""));
    // A page that cannot be written costs the exit code, not the answer.
    fs::write(folder.path().join("blocked"), "a file").unwrap();
    let done = run(&[
        "compare",
        "a/verdict.json",
        "b/verdict.json",
        "--out",
        "blocked",
    ]);
    assert_eq!(done.code, 4);
    assert!(done.out.contains("all else equal") && done.err.contains("make the report folder"));
    assert_eq!(run(&["compare", "a/verdict.json", "a/series.csv"]).code, 4);
}

/// Without a browser the verdict stands, its page too, and the message says what to do.
#[test]
fn cli_a_report_that_cannot_be_printed_costs_the_exit_code() {
    let folder = Folder::new("unprinted");
    let file = signal_file("surviving.csv");
    let out = folder.path().join("out");
    let asked = [
        "replay",
        &file,
        "--members",
        "0",
        "--pdf",
        "--out",
        out.to_str().unwrap(),
    ];
    for (variable, path) in [("/nowhere/chromium", "/usr/bin"), ("", "")] {
        let mut command = program();
        let command = command
            .args(asked)
            .env("CHROMIUM", variable)
            .env("PATH", path);
        let done = finish(command);
        assert_eq!(done.code, 4, "{}", done.err);
        assert!(done.out.starts_with("✓ PASS"), "{}", done.out);
        assert!(done.err.contains("report.pdf: expected "), "{}", done.err);
        assert!(out.join("report.html").exists() && !out.join("report.pdf").exists());
    }
}

/// What is JSON but no verdict is refused, and so is a verdict that lost its keys; both ended in a panic.
#[test]
fn regress_verdicts_that_lost_keys_are_refused() {
    let folder = Folder::new("compare-bare");
    folder.write("empty.json", "{}");
    folder.write("bare.json", "{\"schema\": \"latchgate.verdict/1\"}");
    let compared = |name: &str, format: &str| {
        let words = ["compare", name, name, "--no-report", "--format", format];
        finish(program().args(words).current_dir(folder.path()))
    };
    for format in ["text", "json"] {
        let done = compared("empty.json", format);
        assert_eq!(done.code, 4, "{}", done.err);
        assert!(done.err.contains("expected a verdict"), "{}", done.err);
        let done = compared("bare.json", format);
        assert_eq!(done.code, 4, "{}", done.err);
    }
}

/// A verdict is printed even where its report cannot be written.
#[test]
fn cli_a_verdict_does_not_wait_for_its_report() {
    let folder = Folder::new("unwritable");
    let blocked = folder.write("cut.csv", "a file where the folder should be");
    let done = latchgate(&["replay", &signal_file("burst.csv"), "--out", &blocked]);
    assert_eq!(done.code, 4);
    assert!(done.out.starts_with("✗ FAIL"), "{}", done.out);
    let said = "cut.csv: cannot make the report folder";
    assert!(done.err.contains(said));
    assert_eq!(done.err.lines().count(), 1, "{}", done.err);
}

/// Several recordings: a report each, a table with the worst first, the worst exit code.
#[test]
fn cli_several_recordings_are_a_table() {
    let folder = Folder::new("several");
    let [pass, fail] = ["surviving.csv", "burst.csv"].map(signal_file);
    let run = |words: &[&str]| finish(program().args(words).current_dir(folder.path()));
    let done = run(&["replay", &pass, &fail]);
    assert_eq!((done.code, done.err.as_str()), (1, ""));
    let lines: Vec<&str> = done.out.lines().collect();
    assert_eq!(lines[0], "✗ FAIL  2 recordings: 1 fail, 1 pass");
    assert!(lines[2].starts_with("✗ FAIL") && lines[3].starts_with("✓ PASS"));
    assert_eq!(listing(&folder.path().join("reports/out")).len(), 2);
    let with_missing = run(&["replay", &pass, "missing.csv", "--no-report"]);
    assert_eq!(with_missing.code, 4);
    assert!(with_missing.out.contains("! NOT JUDGED  missing.csv"));
    assert_eq!(with_missing.err.lines().count(), 1);
    let both = run(&["replay", &pass, &fail, "--format", "json", "--no-report"]);
    let document = both.document();
    assert_eq!(document["verdict"], "fail");
    assert_eq!(document["verdicts"][0]["verdict"], "pass");
    assert_eq!(document["verdicts"][1]["recording"]["file"], "burst.csv");
}

/// Where a report is written, whoever looks finds the earlier one, the new one or none, whole:
/// runs that are killed at any instant, and runs that write at once, do no harm.
#[test]
fn prop_a_report_is_there_whole_or_not_at_all() {
    let folder = Folder::new("killed");
    let out = folder.path().join("report");
    let begin = |preload: usize| {
        let set = format!("lever.preload_torque_nm=0.{preload}");
        let mut run = program();
        run.args([
            "replay",
            &signal_file("surviving.csv"),
            "--set",
            &set,
            "--out",
        ])
        .arg(&out)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
        run.spawn().unwrap()
    };
    let whole = || {
        if !out.exists() {
            return;
        }
        assert_eq!(listing(&out), kept());
        let id = id_of(&out);
        for name in ["report.html", "angle.svg", "spectrogram.svg"] {
            let text = fs::read_to_string(out.join(name)).unwrap();
            assert!(text.contains(&id[..8]), "{name} is another report's");
            assert!(text.ends_with("</html>\n") || text.ends_with("</svg>\n"));
        }
    };
    assert!(begin(11).wait().unwrap().success());
    for round in 0..24_u64 {
        let mut child = begin(12 + round as usize);
        std::thread::sleep(std::time::Duration::from_millis(40 + 13 * round));
        child.kill().unwrap();
        child.wait().unwrap();
        whole();
    }
    let many: Vec<_> = (40..46).map(begin).collect();
    for mut child in many {
        assert!(child.wait().unwrap().success());
    }
    assert!(out.exists());
    whole();
}

/// `verify` finds the recording beside the verdict, and from wherever the report lies below the
/// folder where it was replayed.
#[test]
fn cli_verify_finds_the_recording_where_it_was_replayed() {
    let folder = Folder::new("verify-where");
    let data = folder.path().join("data");
    fs::create_dir(&data).unwrap();
    for name in ["surviving.csv", "surviving.csv.toml"] {
        fs::copy(signal_file(name), data.join(name)).unwrap();
    }
    let run = |words: &[&str], at: &Path| finish(program().args(words).current_dir(at));
    let done = run(
        &["replay", "data/surviving.csv", "--members", "0"],
        folder.path(),
    );
    assert_eq!(done.code, 0, "{}", done.err);
    let line = done
        .out
        .lines()
        .find(|line| line.contains("latchgate verify"));
    let verdict = line.unwrap().rsplit(' ').next().unwrap();
    assert_eq!(run(&["verify", verdict], folder.path()).code, 0);
    let from_elsewhere = folder.path().join(verdict);
    let from_elsewhere = from_elsewhere.to_str().unwrap();
    assert_eq!(run(&["verify", from_elsewhere], Path::new("/")).code, 0);
    fs::copy(from_elsewhere, data.join("verdict.json")).unwrap();
    assert_eq!(run(&["verify", "data/verdict.json"], folder.path()).code, 0);
    // A note of another file is not followed.
    let note = Path::new(from_elsewhere).with_file_name("recording.path");
    fs::write(note, "/etc/hostname\n").unwrap();
    assert_eq!(run(&["verify", from_elsewhere], Path::new("/")).code, 4);
}

#[test]
fn cli_the_same_input_gives_the_same_bytes() {
    let folder = Folder::new("same");
    let mut seen = Vec::new();
    let settings = [
        ("a", "1", &[][..]),
        (
            "b",
            "2",
            &[
                ("TZ", "Asia/Tokyo"),
                ("LANG", "de_DE.UTF-8"),
                ("LC_ALL", "de_DE.UTF-8"),
            ],
        ),
        ("c", "8", &[("TZ", "America/St_Johns"), ("LC_ALL", "C")]),
        ("d e", "2", &[("NO_COLOR", "1"), ("HOME", "/nonexistent")]),
    ];
    for (name, threads, variables) in settings {
        let place = folder.path().join(name);
        fs::create_dir(&place).unwrap();
        let file = place.join("burst.csv");
        fs::copy(signal_file("burst.csv"), &file).unwrap();
        let done = finish(
            program()
                .args([
                    "replay",
                    file.to_str().unwrap(),
                    "--threads",
                    threads,
                    "--format",
                    "json",
                    "--out",
                    "report",
                ])
                .envs(variables.iter().copied())
                .current_dir(&place),
        );
        assert_eq!(done.code, 1, "{}", done.err);
        let report = place.join("report");
        let files: Vec<Vec<u8>> = REPORT_FILES
            .iter()
            .map(|name| {
                let bytes = fs::read(report.join(name)).unwrap();
                if *name == "verdict.json" {
                    without_run(&String::from_utf8(bytes).unwrap())
                        .as_bytes()
                        .to_vec()
                } else {
                    bytes
                }
            })
            .collect();
        seen.push((without_run(&done.out).to_string(), done.err, files));
    }
    for other in &seen[1..] {
        assert!(*other == seen[0], "a run differs from the first");
    }
}

/// `reports/sill/` is what `latchgate replay signals/sill_60g.csv` writes, byte for byte but for
/// the run block. `LATCHGATE_RENEW=1 cargo test --test it cli_the_reference_report` renews it;
/// renewing is a commit of its own.
#[test]
fn cli_the_reference_report_is_reproduced() {
    let stored = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/sill");
    let folder = Folder::new("reference");
    let made = folder.path().join("sill");
    // The stored report is of the first day of 2026.
    let done = finish(
        program()
            .env("SOURCE_DATE_EPOCH", "1767225600")
            .args(["replay", &signal_file("sill_60g.csv"), "--out"])
            .arg(&made),
    );
    assert_eq!(done.code, 1, "{}", done.err);
    let page = fs::read_to_string(made.join("report.html")).unwrap();
    assert!(page.contains("2026-01-01"));
    if std::env::var_os("LATCHGATE_RENEW").is_some() {
        for name in REPORT_FILES {
            fs::copy(made.join(name), stored.join(name)).unwrap();
        }
    }
    assert_eq!(listing(&stored), REPORT_FILES);
    for name in REPORT_FILES {
        let [new, old] =
            [&made, &stored].map(|folder| fs::read_to_string(folder.join(name)).unwrap());
        let (new, old) = if name == "verdict.json" {
            (without_run(&new), without_run(&old))
        } else {
            (&*new, &*old)
        };
        let first = new
            .lines()
            .zip(old.lines())
            .position(|(new, old)| new != old);
        assert!(
            new == old,
            "reports/sill/{name} differs, first in line {}; run LATCHGATE_RENEW=1 cargo test --test it cli_the_reference_report and look at the difference",
            first.map_or(0, |index| index + 1)
        );
    }
}

/// The last page names who made the report, of which design file, on which day, and what the recording was.
#[test]
fn cli_a_report_names_its_maker() {
    let folder = Folder::new("maker");
    let design = folder.write("my-latch.toml", "base = \"paper\"\n");
    let out = folder.path().join("out");
    let done = finish(
        program()
            .env("SOURCE_DATE_EPOCH", "951782400")
            .args([
                "replay",
                &signal_file("burst.csv"),
                "--no-advice",
                "--design",
                &design,
            ])
            .args(["--by", " E. Muster & Co ", "--out"])
            .arg(&out),
    );
    assert_eq!(done.code, 1, "{}", done.err);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let verdict = out.join("verdict.json");
    let document: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&verdict).unwrap()).unwrap();
    let sha256 = document["recording"]["sha256"].as_str().unwrap();
    for text in [
        "E. Muster &amp; Co<",
        "my-latch.toml",
        "2000-02-29",
        "Clopper",
        sha256,
    ] {
        assert!(page.contains(text), "{text}");
    }
    let (record, sign) = (
        page.find("id=\"record\"").unwrap(),
        page.find("Signature").unwrap(),
    );
    let appendix = page.find("id=\"appendix\"").unwrap();
    assert!(record < sign && sign < appendix);
    // Another day repeats the page of the day on which it was written.
    let verified = latchgate(&["verify", verdict.to_str().unwrap()]);
    assert_eq!(verified.code, 0, "{}{}", verified.out, verified.err);
    let long = "n".repeat(101);
    for name in ["", "two\nlines", &long] {
        let done = latchgate(&["replay", "x.csv", "--by", name]);
        assert_eq!(done.code, 2, "{name:?}");
    }
}

/// What a signer looks for: the maker, of the card unless one is stated, and the design file with its hash.
#[test]
fn cli_a_report_names_its_maker_and_the_hash_of_its_design_file() {
    let folder = Folder::new("maker-of-card");
    let recording = folder.write("a.csv", table(weak));
    folder.write("a.csv.toml", "unit = \"g\"\nby = \"B. Card\"\n");
    let design = "name = \"mine\"\nbase = \"paper\"\n";
    let file = folder.write("mine.toml", design);
    let run = |more: &[&str]| {
        let words = ["replay", &recording, "--design", &file, "--members", "0"];
        let answer = ["--no-report", "--format", "json"];
        let done = latchgate(&[&words[..], &answer, more].concat());
        let document: Value = serde_json::from_str(&done.out).unwrap();
        document["run"].clone()
    };
    let of_card = run(&[]);
    assert_eq!(of_card["by"], "B. Card");
    assert_eq!(of_card["design_file"], "mine.toml");
    let sha256 = latchgate_recording::source::sha256(design.as_bytes());
    assert_eq!(of_card["design_file_sha256"], sha256.as_str());
    assert_eq!(run(&["--by", "A. Option"])["by"], "A. Option");
}
