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

const REPORT_FILES: [&str; 9] = [
    "acceleration.svg",
    "amplitude-spectra.svg",
    "angle.svg",
    "drivers.svg",
    "phase-plane.svg",
    "report.html",
    "spectrogram.svg",
    "spread.svg",
    "verdict.json",
];

#[test]
fn cli_reports_go_where_they_are_asked_to_and_nowhere_else() {
    let folder = Folder::new("reports");
    let run = |arguments: &[&str]| finish(program().args(arguments).current_dir(folder.path()));
    let file = signal_file("surviving.csv");
    let quiet = run(&["replay", &file, "--no-report"]);
    assert_eq!(quiet.code, 0);
    assert!(!quiet.out.contains("  report "));
    assert!(listing(folder.path()).is_empty());

    let done = run(&["replay", &file]);
    let default = "reports/out/surviving.csv-paper";
    assert!(
        done.out
            .contains(&format!("  report          {default}/report.html\n")),
        "{}",
        done.out
    );
    assert_eq!(listing(&folder.path().join(default)), REPORT_FILES);
    assert_eq!(listing(folder.path()), ["reports"]);

    let out = run(&[
        "replay",
        &file,
        "--out",
        "there/it is",
        "--set",
        "name=a/b c",
        "--format",
        "json",
    ]);
    assert_eq!(listing(&folder.path().join("there/it is")), REPORT_FILES);
    assert_eq!(
        listing(&folder.path().join("reports/out")),
        ["surviving.csv-paper"]
    );
    let stored = fs::read_to_string(folder.path().join("there/it is/verdict.json")).unwrap();
    assert_eq!(without_run(&stored), without_run(&out.out));

    run(&["replay", &file, "--set", "name=../a/b c"]);
    assert_eq!(
        listing(&folder.path().join("reports/out")),
        ["surviving.csv-.._a_b_c", "surviving.csv-paper"]
    );

    // A pass does not outlive a later run into its folder that had no answer.
    let place = folder.path().join("there/it is");
    let cut = folder.write("cut.csv", "time_s,acc_y_g\n0,1\n0.0001,x\n");
    for recording in [cut.as_str(), "missing.csv"] {
        run(&["replay", &file, "--out", "there/it is"]);
        assert_eq!(listing(&place), REPORT_FILES);
        let refused = run(&["replay", recording, "--out", "there/it is"]);
        assert_eq!(refused.code, 4);
        assert_eq!(listing(&place), ["report.html", "verdict.json"]);
        let page = fs::read_to_string(place.join("report.html")).unwrap();
        assert!(
            page.contains("UNUSABLE") && !page.contains("PASS"),
            "{recording}"
        );
    }
    // A name that no file bears makes no folder.
    assert_eq!(run(&["replay", "missing.csv", "--out", "fresh"]).code, 4);
    assert!(!folder.path().join("fresh").exists());

    let blocked = run(&["replay", &file, "--out", "cut.csv"]);
    assert_eq!(blocked.code, 4);
    assert!(
        blocked
            .err
            .contains("cut.csv: cannot make the report folder"),
        "{}",
        blocked.err
    );
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

/// `reports/burst/` is what `latchgate replay signals/burst.csv` writes, byte for byte but for
/// the run block. `LATCHGATE_RENEW=1 cargo test --test it cli_the_reference_report` renews it;
/// renewing is a commit of its own.
#[test]
fn cli_the_reference_report_of_the_burst_is_reproduced() {
    let stored = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/burst");
    let folder = Folder::new("reference");
    let made = folder.path().join("burst");
    let done = latchgate(&[
        "replay",
        &signal_file("burst.csv"),
        "--out",
        made.to_str().unwrap(),
    ]);
    assert_eq!(done.code, 1, "{}", done.err);
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
            "reports/burst/{name} differs, first in line {}; run LATCHGATE_RENEW=1 cargo test --test it cli_the_reference_report and look at the difference",
            first.map_or(0, |index| index + 1)
        );
    }
}
