//! `latchgate study` for the studies of sines: files, what is refused, and Ctrl-C.

use super::super::report::check_balanced;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("sines-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

fn command(arguments: &[&str], out: &Path) -> Command {
    let mut command = crate::support::program();
    command
        .arg("study")
        .args(arguments)
        .arg("--out")
        .arg(out)
        .env("NO_COLOR", "1")
        .stdin(Stdio::null());
    command
}

/// One study's smallest run.
struct Case {
    name: &'static str,
    arguments: &'static [&'static str],
    columns: &'static str,
    parameters: &'static [&'static str],
    results: &'static [&'static str],
    labels: &'static [&'static str],
}

const CASES: [Case; 4] = [
    Case {
        name: "bifurcation",
        arguments: &[
            "--amplitude",
            "0.9..1.7",
            "--points",
            "9",
            "--transient",
            "40",
            "--periods",
            "10",
            "--phi0",
            "0.07",
            "--omega0",
            "2.7",
            "--doublings",
            "1",
        ],
        columns: "amplitude_g,angle_rad,angular_velocity_rad_s",
        parameters: &["amplitude_g", "points", "sweep", "initial", "omega_rad_s"],
        results: &["branches", "columns", "complete", "model"],
        labels: &["amplitude A [g]", "angular velocity [rad/s]"],
    },
    Case {
        name: "attractor",
        arguments: &[
            "--amplitude",
            "1.2",
            "--transient",
            "200",
            "--periods",
            "40",
            "--phi0",
            "0.07",
            "--omega0",
            "2.9",
        ],
        columns: "method,amplitude_g,angle_rad,angular_velocity_rad_s",
        parameters: &["amplitude_g", "transient", "periods", "gravity_m_s2"],
        results: &["periods", "superstable", "complete", "model"],
        labels: &["angle [rad]", "angular velocity [rad/s]"],
    },
    Case {
        name: "basins",
        arguments: &["--amplitude", "0.7", "--grid", "8x6", "--transient", "100"],
        columns: "angle_rad,angular_velocity_rad_s,attractor",
        parameters: &["angle_rad", "velocity_rad_s", "grid", "transient"],
        results: &["attractors", "boundary_share", "complete", "model"],
        labels: &["initial angle [rad]", "initial angular velocity [rad/s]"],
    },
    Case {
        name: "excitation-map",
        arguments: &["--grid", "8x6", "--periods", "4"],
        columns: "amplitude_g,angular_frequency_rad_s,peak_angle_rad",
        parameters: &["amplitude_g", "omega_rad_s", "grid", "periods"],
        results: &["boundary", "lift_off_g", "complete", "model"],
        labels: &["angular frequency ω [rad/s]", "amplitude A [g]"],
    },
];

#[track_caller]
fn check_chart(path: &Path, labels: &[&str]) {
    let svg = std::fs::read_to_string(path).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    check_balanced(&path.display().to_string(), &svg);
    for label in labels {
        assert!(svg.contains(label), "{}: no `{label}`", path.display());
    }
    for wrong in ["\"NaN", ">NaN", "NaN ", "\"inf", " inf", "var(--"] {
        assert!(!svg.contains(wrong), "{}: {wrong}", path.display());
    }
}

#[track_caller]
fn check_files(case: &Case, model: &str, stops: &[&str]) {
    let name = case.name;
    let out = folder(&format!("{name}-{model}"));
    let output = command(&[&[name], case.arguments].concat(), &out)
        .args(["--model", model, "--format", "json"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{name}: {said}");
    assert!(said.is_empty(), "{name} talks without a terminal: {said}");
    let stored = std::fs::read(out.join(format!("{name}.json"))).unwrap();
    assert_eq!(stored, output.stdout, "{name}.json is what stdout got");
    let printed: serde_json::Value = serde_json::from_slice(&stored).unwrap();
    assert_eq!(printed["schema"], "latchgate.study/1");
    assert_eq!(printed["study"], name);
    assert!(printed["elapsed_s"].as_f64().unwrap() >= 0.0);
    assert!(printed["parameters"]["design"]["lever"].is_object());
    for key in case.parameters {
        assert!(!printed["parameters"][key].is_null(), "{name}: {key}");
    }
    assert!(!printed["headlines"].as_array().unwrap().is_empty());
    let results = printed["results"].as_array().unwrap();
    assert_eq!(results.len(), stops.len(), "{name}");
    for (result, stop) in results.iter().zip(stops) {
        for key in case.results {
            assert!(!result[key].is_null(), "{name}: {key}");
        }
        assert_eq!(result["model"], *stop);
        assert_eq!(result["complete"], true);
        let file = if stops.len() > 1 {
            format!("{name}-{stop}.csv")
        } else {
            format!("{name}.csv")
        };
        let csv = std::fs::read_to_string(out.join(&file)).unwrap();
        assert_eq!(csv.lines().next(), Some(case.columns), "{file}");
        assert!(csv.lines().count() > 20, "{file}");
        assert!(!csv.contains("NaN") && !csv.contains("inf"), "{file}");
    }
    check_chart(&out.join(format!("{name}.svg")), case.labels);
    let files = std::fs::read_dir(&out).unwrap().count();
    assert_eq!(files, stops.len() + 2, "{name}: files in {}", out.display());
}

#[test]
fn cli_studies_of_sines_write_rows_results_and_charts() {
    for case in &CASES {
        check_files(case, "auto", &["rigid", "soft"]);
    }
    check_files(&CASES[0], "soft", &["soft"]);
    check_files(&CASES[3], "rigid", &["rigid"]);
}

/// Two threads write what one does, but for the time it took.
#[test]
fn cli_threads_change_no_byte() {
    for case in CASES.iter().filter(|case| case.name != "basins") {
        let written = |threads: &str| {
            let out = folder(&format!("{}-threads-{threads}", case.name));
            let arguments = [&[case.name], case.arguments].concat();
            let output = command(&arguments, &out)
                .args(["--threads", threads])
                .output()
                .unwrap();
            assert_eq!(output.status.code(), Some(0));
            let mut files: Vec<PathBuf> = std::fs::read_dir(&out)
                .unwrap()
                .map(|file| file.unwrap().path())
                .collect();
            files.sort();
            files
                .iter()
                .map(|file| {
                    let text = std::fs::read_to_string(file).unwrap();
                    text.lines()
                        .filter(|line| !line.contains("\"elapsed_s\""))
                        .map(str::to_owned)
                        .collect()
                })
                .collect::<Vec<Vec<String>>>()
        };
        assert!(written("1") == written("2"), "{}", case.name);
    }
}

#[track_caller]
fn check_refused(arguments: &[&str], words: &[&str]) {
    let out = folder("refused");
    let Output {
        status,
        stdout,
        stderr,
    } = command(arguments, &out).output().unwrap();
    let said = String::from_utf8_lossy(&stderr);
    assert_eq!(status.code(), Some(2), "{arguments:?}: {said}");
    assert!(stdout.is_empty() && !out.exists(), "{arguments:?}");
    for word in words {
        assert!(said.contains(word), "{arguments:?}: no `{word}` in: {said}");
    }
    let messages = said.matches("error:").count() + said.matches("latchgate: ").count();
    assert_eq!(messages, 1, "{arguments:?}: {said}");
}

#[test]
fn cli_studies_of_sines_refuse_wrong_usage() {
    for study in ["bifurcation", "attractor"] {
        check_refused(&[study, "--amplitude", "5..1"], &["--amplitude", "LO"]);
        check_refused(&[study, "--amplitude=-1..2"], &["from 0 to 50000 g"]);
        check_refused(&[study, "--amplitude", "NaN"], &["--amplitude"]);
        check_refused(&[study, "--amplitude", "0..inf"], &["--amplitude"]);
        check_refused(&[study, "--points", "1"], &["--points", "2"]);
        check_refused(&[study, "--omega", "0"], &["--omega"]);
        check_refused(&[study, "--gravity=-9.81"], &["--gravity"]);
        check_refused(&[study, "--phi0", "-0.1"], &["--phi0", "--model soft"]);
        check_refused(
            &[study, "--model", "rigid", "--phi0=-1e-9"],
            &["--phi0", "--model soft"],
        );
    }
    check_refused(&["bifurcation", "--sweep", "both"], &["none", "up", "down"]);
    check_refused(&["bifurcation", "--doublings", "9"], &["--doublings", "8"]);
    check_refused(&["bifurcation", "--grid", "5x5"], &["--grid"]);
    check_refused(&["attractor", "--compare-steps", "10"], &["100"]);
    check_refused(&["attractor", "--periods", "2"], &["--periods", "3"]);
    for study in ["basins", "excitation-map"] {
        for grid in ["5", "0x5", "5x", "5x4001", "-1x5", "5x5x5"] {
            let given = format!("--grid={grid}");
            check_refused(&[study, &given], &["--grid", "NxM", "200x200"]);
        }
    }
    // Where nothing of the numbers would be left, there was an answer all the same.
    for study in ["basins", "histories", "shock", "work-precision"] {
        check_refused(&[study, "--amplitude=1e300"], &["--amplitude", "50000 g"]);
        check_refused(&[study, "--amplitude=-1"], &["--amplitude"]);
    }
    check_refused(&["basins", "--angle", "1..1"], &["LO below HI"]);
    check_refused(&["basins", "--velocity", "20..-20"], &["--velocity"]);
    check_refused(&["basins", "--amplitude", "0..1"], &["--amplitude"]);
    check_refused(&["excitation-map", "--periods", "0"], &["--periods"]);
}

/// A map down to no frequency, or of negative amplitudes, used to be begun and then end as if the
/// data were at fault, or give a contour that was none.
#[test]
fn regress_a_map_is_asked_for_excitations_that_exist() {
    check_refused(&["excitation-map", "--omega", "0..10"], &["above 0"]);
    check_refused(&["excitation-map", "--omega=-5..10"], &["above 0"]);
    check_refused(
        &["excitation-map", "--amplitude=-5..-1"],
        &["from 0 to 50000 g"],
    );
    check_refused(&["excitation-map", "--amplitude", "3"], &["LO below HI"]);
}

/// Ctrl-C on studies that would take minutes.
#[cfg(unix)]
#[track_caller]
fn check_interrupted(name: &str, arguments: &[&str]) {
    let out = folder(&format!("interrupted-{name}"));
    let child = command(&[&[name], arguments].concat(), &out)
        .args(["--model", "rigid", "--threads", "1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1000));
    let asked = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(asked.success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{name}: {said}");
    assert!(said.contains("interrupted"), "{name}: {said}");
    let printed: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join(format!("{name}.json"))).unwrap()).unwrap();
    assert_eq!(printed["results"][0]["complete"], false, "{name}");
    assert_eq!(printed["complete"], false, "{name}");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("interrupted"), "{name}: {text}");
    // A share of what was never counted used to be 0.
    if name == "basins" {
        assert!(printed["results"][0]["boundary_share"].is_null());
        assert!(text.contains("share of the cells [-]: none"), "{text}");
    }
    let rows = std::fs::read_to_string(out.join(format!("{name}.csv"))).unwrap();
    assert!(
        rows.starts_with("a") || rows.starts_with("method"),
        "{name}: {rows:.80}"
    );
    check_chart(&out.join(format!("{name}.svg")), &[]);
}

#[cfg(unix)]
#[test]
fn cli_ctrl_c_keeps_what_is_done() {
    check_interrupted(
        "bifurcation",
        &["--points", "20000", "--periods", "400", "--doublings", "0"],
    );
    check_interrupted("basins", &["--amplitude", "0.7", "--grid", "1000x1000"]);
    check_interrupted("excitation-map", &["--grid", "40x4000"]);
    check_interrupted(
        "attractor",
        &[
            "--compare-steps",
            "100000",
            "--periods",
            "3000",
            "--transient",
            "10",
        ],
    );
}
