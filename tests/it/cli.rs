//! Guards the process boundary: arguments in, data on stdout, talk on stderr, an exit code out.

mod evidence;
mod init;
#[cfg(unix)]
mod interrupt;
mod reports;
mod settings;
mod slips;

use crate::support::{
    Done, Folder, data, fed, finish, half_sine, latchgate, program, signal_file, table, weak,
    without_run,
};
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

// ---------------------------------------------------------------- exit codes and streams

#[track_caller]
fn check_verdict(arguments: &[&str], code: i32, verdict: &str) -> Value {
    let arguments = [arguments, &["--no-report", "--format", "json"]].concat();
    let done = latchgate(&arguments);
    assert_eq!(done.code, code, "{arguments:?}: {}", done.err);
    let document = done.document();
    assert_eq!(document["verdict"], verdict, "{arguments:?}");
    let lines = done.err.lines().count();
    assert_eq!(lines, usize::from(code == 4), "{arguments:?}: {}", done.err);
    assert!(!document["why"].as_array().unwrap().is_empty());
    document
}

#[test]
fn cli_every_answer_has_its_exit_code() {
    let folder = Folder::new("codes");
    let held = folder.write("held.csv", table(|t| half_sine(t, 0.0, 0.03, 12.0)));
    check_verdict(&["replay", &signal_file("surviving.csv")], 0, "pass");
    check_verdict(&["replay", &signal_file("burst.csv")], 1, "fail");
    let told = [
        "replay",
        &held,
        "--opens-when",
        "negative",
        "--transfer",
        "1",
    ];
    // Silent before its event and after it: no word is asked.
    check_verdict(&told, 0, "pass");
    check_verdict(&["replay", &held, "--opens-when", "positive"], 1, "fail");
    check_verdict(&["replay", &held, "--opens-when", "both"], 1, "fail");
    let document = check_verdict(&["replay", &held], 3, "undecided");
    assert_eq!(document["recording"]["opens_when_source"], "undeclared");
    assert!(document["error_budget_rad"]["polarity"].as_f64().unwrap() > 0.1);
    let missing = folder.path().join("missing.csv");
    check_verdict(&["replay", missing.to_str().unwrap()], 4, "unusable");
}

/// Each option of `replay` does what it says, where the document shows it.
#[test]
fn cli_every_option_reaches_the_verdict() {
    let folder = Folder::new("options");
    let design = folder.write(
        "d.toml",
        "name = \"mine\"\nbase = \"paper\"\n[lever]\npreload_torque_nm = 0.2\n[tolerance]\npreload_torque_nm = 0\nmass_kg = 0\nrestitution = 0.02\n",
    );
    let plain = folder.write("plain.csv", table(weak));
    let in_ms = folder.write(
        "ms.csv",
        (0..3000).fold("clock,acc_y_g\n".to_string(), |text, index| {
            let time = f64::from(index) / 10.0;
            text + &format!("{time:.1},{:.6}\n", weak(time / 1000.0 - 0.05))
        }),
    );
    let no_time = folder.write(
        "values.csv",
        (-500..2500).fold("acc_y_g\n".to_string(), |text, index| {
            text + &format!("{:.6}\n", weak(f64::from(index) / 10_000.0))
        }),
    );
    let mcap = signal_file("burst_imu.mcap");
    let negative: &[&str] = &[
        "--opens-when",
        "negative",
        "--transfer",
        "1",
        "--accept",
        "noise",
    ];
    let check = |file: &str, options: &[&str], pointer: &str, expected: Value| {
        let arguments = [
            &["replay", file, "--no-report", "--format", "json"],
            negative,
            options,
        ]
        .concat();
        let done = latchgate(&arguments);
        // A method that states no bound decides no pass, and a push in m/s² is none of a crash.
        let doubtful = ["--method", "--unit"]
            .iter()
            .any(|own| options.contains(own));
        let undecided = done.code == 3 && doubtful;
        assert!(
            done.code < 2 || undecided,
            "{arguments:?}: {} {}",
            done.code,
            done.err
        );
        let document = done.document();
        assert_eq!(
            document.pointer(pointer),
            Some(&expected),
            "{arguments:?} {pointer}"
        );
        assert_eq!(done.err, "", "{arguments:?}");
    };
    let accel_x = "/door/imu:linear_acceleration.x";
    let cases: &[(&str, &[&str], &str, Value)] = &[
        (
            &plain,
            &["--channel", "acc_y_g"],
            "/recording/channel",
            "acc_y_g".into(),
        ),
        (
            &plain,
            &["--channel", "2"],
            "/recording/channel",
            "acc_y_g".into(),
        ),
        (
            &mcap,
            &["--channel", "/door/imu:linear_acceleration.y"],
            "/recording/unit",
            "m/s2".into(),
        ),
        (
            &plain,
            &["--time-column", "time_s"],
            "/recording/start_s",
            (-0.05).into(),
        ),
        (
            &plain,
            &["--time-column", "1"],
            "/recording/sample_rate_hz",
            10_000.0.into(),
        ),
        (
            &in_ms,
            &["--time-column", "1", "--time-unit", "ms"],
            "/recording/end_s",
            0.2999.into(),
        ),
        (
            &in_ms,
            &[
                "--time-column",
                "clock",
                "--time-unit",
                "ms",
                "--time-zero",
                "0.05",
            ],
            "/recording/start_s",
            (-0.05).into(),
        ),
        (
            &no_time,
            &["--rate-hz", "10000"],
            "/recording/end_s",
            0.2999.into(),
        ),
        (
            &no_time,
            &["--rate-hz", "10000", "--time-zero", "0.05"],
            "/recording/start_s",
            (-0.05).into(),
        ),
        (
            &plain,
            &["--unit", "m/s2"],
            "/recording/unit_source",
            "option".into(),
        ),
        (
            &plain,
            &["--unit", "ft/s2"],
            "/recording/unit",
            "ft/s2".into(),
        ),
        (
            &plain,
            &["--bias", "none"],
            "/conditioning/bias_window_s",
            Value::Null,
        ),
        (
            &plain,
            &["--bias", "-0.05..-0.025"],
            "/conditioning/bias_window_s",
            vec![-0.05, -0.025].into(),
        ),
        (
            &plain,
            &["--filter", "cfc180"],
            "/conditioning/filter",
            "cfc180".into(),
        ),
        (
            &plain,
            &["--filter", "none"],
            "/error_budget_rad/filter",
            0.0.into(),
        ),
        (&plain, &[], "/conditioning/filter", "cfc1000".into()),
        (
            &plain,
            &["--filter-standard", "saej211"],
            "/conditioning/filter_standard",
            "saej211".into(),
        ),
        (
            &plain,
            &["--resample", "20000"],
            "/conditioning/resample_hz",
            20_000.0.into(),
        ),
        (
            &plain,
            &["--resample", "native"],
            "/conditioning/resample_hz",
            Value::Null,
        ),
        (
            &plain,
            &["--window", "-0.01..0.2"],
            "/request/window",
            "-0.01..0.2".into(),
        ),
        (
            &plain,
            &["--design", &design],
            "/design/name",
            "mine".into(),
        ),
        (
            &plain,
            &["--design", &design],
            "/design/lever/preload_torque_nm",
            0.2.into(),
        ),
        (
            &plain,
            &["--set", "lever.preload_torque_nm=2.82"],
            "/design/lever/preload_torque_nm",
            2.82.into(),
        ),
        (
            &plain,
            &[
                "--design",
                &design,
                "--set",
                "lever.preload_torque_nm=0.3",
                "--set",
                "name=his",
            ],
            "/design/name",
            "his".into(),
        ),
        (
            &plain,
            &["--model", "rigid"],
            "/nominal/model",
            "rigid".into(),
        ),
        (
            &plain,
            &["--model", "soft"],
            "/nominal/model",
            "soft".into(),
        ),
        (
            &plain,
            &["--model", "auto"],
            "/request/model",
            "auto".into(),
        ),
        (
            &plain,
            &["--method", "event-driven"],
            "/nominal/method",
            "event-driven".into(),
        ),
        (
            &plain,
            &["--method", "rk4", "--model", "rigid"],
            "/nominal/method",
            "rk4".into(),
        ),
        (
            &plain,
            &["--members", "0", "--seed", "7"],
            "/ensemble",
            Value::Null,
        ),
        (
            &plain,
            &["--phi0", "0.25"],
            "/nominal/first_crossing_s",
            (-0.05).into(),
        ),
        (
            &plain,
            &["--phi0", "-0.001", "--model", "soft"],
            "/request/phi0",
            (-0.001).into(),
        ),
        (
            &plain,
            &["--omega0", "-2.5"],
            "/request/omega0",
            (-2.5).into(),
        ),
        (
            &plain,
            &["--input-format", "csv"],
            "/recording/format",
            "csv".into(),
        ),
        (
            &mcap,
            &["--input-format", "mcap"],
            "/recording/format",
            "mcap".into(),
        ),
        (
            &plain,
            &["--opens-when", "negative"][..0],
            "/recording/opens_when_source",
            "option".into(),
        ),
        (
            &plain,
            &["--threads", "3", "--tolerance", "1e-12"],
            "/verdict",
            "pass".into(),
        ),
    ];
    for (file, options, pointer, expected) in cases {
        check(file, options, pointer, expected.clone());
    }
    // A channel that is named although it points forward is taken, and its faults count.
    let done = latchgate(&[
        "replay",
        &mcap,
        "--channel",
        accel_x,
        "--no-report",
        "--format",
        "json",
    ]);
    assert_eq!(done.document()["recording"]["channel"], accel_x);
    assert_eq!(done.code, 4);
    let few = latchgate(&[
        "replay",
        &plain,
        "--no-report",
        "--format",
        "json",
        "--opens-when",
        "negative",
        "--method",
        "rk4",
        "--model",
        "rigid",
        "--steps-per-period",
        "500",
    ]);
    let many = latchgate(&[
        "replay",
        &plain,
        "--no-report",
        "--format",
        "json",
        "--opens-when",
        "negative",
        "--method",
        "rk4",
        "--model",
        "rigid",
        "--steps-per-period",
        "1000",
    ]);
    let steps = |done: &Done| {
        done.document()["nominal"]["work"]["steps"]
            .as_f64()
            .unwrap()
    };
    let ratio = steps(&many) / steps(&few);
    assert!((ratio - 2.0).abs() < 0.01, "{ratio}");
}

#[track_caller]
fn check_usage(arguments: &[&str], fragment: &str) {
    let done = latchgate(arguments);
    assert_eq!(done.code, 2, "{arguments:?}: {}", done.err);
    assert_eq!(done.out, "", "{arguments:?}");
    assert!(
        done.err.contains(fragment),
        "{arguments:?}: `{fragment}` not in {}",
        done.err
    );
    assert!(done.err.contains("--help"), "{arguments:?}: {}", done.err);
}

#[test]
fn cli_wrong_usage_is_told_before_any_file_is_opened() {
    // The recording does not exist: what is wrong must be seen without it.
    let with = |options: &[&str], fragment: &str| {
        check_usage(
            &[&["replay", "/nowhere/nothing.csv"], options].concat(),
            fragment,
        );
    };
    check_usage(&["replay"], "<RECORDING>");
    check_usage(
        &["inspect", "a.csv", "b.csv"],
        "unexpected argument 'b.csv'",
    );
    check_usage(
        &["replya", "a.csv"],
        "a similar subcommand exists: 'replay'",
    );
    check_usage(&["replay", "a.csv", "--chanel", "y"], "'--channel'");
    check_usage(&["completions", "tcsh"], "zsh");
    check_usage(&["man", "repaly"], "did you mean `replay`?");
    check_usage(
        &["inspect", "a.csv", "--opens-when", "both"],
        "--opens-when",
    );
    check_usage(
        &["inspect", "a.csv", "--input-format", "cvs"],
        "did you mean `csv`?",
    );
    with(&["--input-format", "mpac"], "did you mean `mcap`?");
    with(
        &["--time-unit", "fortnight"],
        "expected s, ms, us, ns, min, h or day, or a number with one",
    );
    with(&["--time-unit", "0us"], "as in 10us");
    with(
        &["--time-column", "t", "--rate-hz", "1000"],
        "cannot be used with",
    );
    with(&["--rate-hz", "0"], "must be positive");
    with(&["--rate-hz", "-5"], "must be positive");
    with(&["--rate-hz", "fast"], "`fast` is not a number");
    with(&["--time-zero", "inf"], "must be finite");
    with(
        &["--unit", "furlong"],
        "expected g, mg, m/s2, cm/s2, mm/s2, mm/ms2, ft/s2, in/s2 or kilo-g",
    );
    for (value, why) in [
        ("20", "expected NUMBER UNIT/UNIT"),
        ("20 V", "for example 20 g/V or 10 mV/g"),
        ("g/V", "expected NUMBER UNIT/UNIT"),
        ("20 g/m/s2", "expected NUMBER UNIT/UNIT"),
        ("0 g/V", "must be positive"),
    ] {
        with(&["--sensitivity", value], why);
    }
    with(
        &["--sensitivity", "20 g/V", "--unit", "g"],
        "cannot be used with",
    );
    with(
        &["--opens-when", "up"],
        "expected negative, positive or both",
    );
    with(&["--bias", "0.1"], "expected START..END in seconds");
    with(&["--bias", "0.2..0.1"], "START must lie before END");
    with(
        &["--filter", "cfc999"],
        "expected none, cfc60, cfc180, cfc600 or cfc1000",
    );
    with(&["--filter-standard", "din"], "expected iso6487 or saej211");
    with(&["--resample", "0"], "must be positive");
    with(&["--resample", "-1"], "must be positive");
    with(&["--window", "0.3..-0.1"], "START must lie before END");
    with(&["--window", "0..nan"], "must be finite");
    with(&["--set", "lever.mass_kg"], "expected KEY=VALUE");
    with(
        &["--set", "lever.mas_kg=1"],
        "did you mean `lever.mass_kg`?",
    );
    with(
        &["--set", "lever.mass_kg=heavy"],
        "expected a number for lever.mass_kg",
    );
    with(
        &["--set", "lever.mass_kg=-1"],
        "must be positive and finite",
    );
    with(&["--set", "stop.restitution=1.2"], "0 to 1");
    with(&["--set", "lever.mass_kg=5"], "parallel-axis");
    with(
        &[
            "--design",
            "/nowhere/design.toml",
            "--set",
            "lever.mas_kg=1",
        ],
        "did you mean",
    );
    with(&["--model", "hard"], "[possible values: auto, rigid, soft]");
    with(
        &["--method", "euler"],
        "[possible values: event-driven, rk4, rk4-located, dopri5, dopri5-samples, moreau-jean]",
    );
    with(&["--steps-per-period", "0"], "0 is not in");
    with(&["--tolerance", "1"], "must lie between 1e-20 and 1e-2 rad");
    with(&["--tolerance", "-1"], "must be positive");
    with(&["--members", "-1"], "'-1'");
    with(&["--seed", "-1"], "'-1'");
    with(&["--phi0", "nan"], "must be finite");
    with(&["--phi0", "-0.1"], "choose --model soft");
    with(&["--phi0", "101"], "at most 100 rad");
    with(&["--omega0", "-1e6"], "at most 100000 rad/s");
    with(&["--out", "x", "--no-report"], "cannot be used with");
    with(&["--threads", "0"], "0 is not in 1..=65535");
    with(&["--format", "xml"], "[possible values: text, json]");
    with(&["--log", "xml:info"], "expected [text|json][:LEVEL]");
    with(&["--log", "json:loud"], "unknown level `loud`");
}

/// The limits on the initial state that the command line states are those of the replay.
#[test]
fn cli_initial_states_at_their_limit_are_replayed() {
    let done = latchgate(&[
        "replay",
        &signal_file("surviving.csv"),
        "--no-report",
        "--phi0",
        "100",
        "--omega0",
        "-100000",
    ]);
    assert_eq!(done.code, 1, "{}", done.err);
}

#[test]
fn cli_success_is_silent_on_stderr_and_json_is_all_there_is() {
    for file in ["surviving.csv", "burst.csv", "burst_imu.mcap", "ugly.csv"] {
        for command in ["replay", "inspect"] {
            let mut arguments = vec![command];
            let path = signal_file(file);
            arguments.extend([path.as_str(), "--format", "json"]);
            if command == "replay" {
                arguments.push("--no-report");
            }
            let done = latchgate(&arguments);
            assert_eq!(done.err, "", "{arguments:?}");
            let schema = format!(
                "latchgate.{}/1",
                if command == "replay" {
                    "verdict"
                } else {
                    "inspect"
                }
            );
            assert_eq!(done.document()["schema"], schema.as_str());
            assert!(
                done.out.starts_with('{') && done.out.ends_with("}\n"),
                "{arguments:?}"
            );
            let text = latchgate(
                &arguments[..2]
                    .iter()
                    .copied()
                    .chain(arguments[4..].iter().copied())
                    .collect::<Vec<_>>(),
            );
            assert_eq!(text.err, "");
            assert!(!text.out.contains('\x1b') && text.out.ends_with('\n'));
        }
    }
}

#[test]
fn cli_standard_input_reads_as_the_file_does() {
    for (file, format) in [("burst.csv", "csv"), ("burst_imu.mcap", "mcap")] {
        let bytes = fs::read(signal_file(file)).unwrap();
        let own: &[&str] = &[
            "--opens-when",
            "negative",
            "--no-report",
            "--format",
            "json",
        ];
        let of_file = latchgate(&[&["replay", &signal_file(file)], own].concat()).document();
        for named in [&[][..], &["--input-format", format][..]] {
            let done = fed(&[&["replay", "-"], own, named].concat(), &bytes);
            assert_eq!((done.code, done.err.as_str()), (1, ""), "{file} {named:?}");
            let document = done.document();
            assert_eq!(document["nominal"], of_file["nominal"], "{file}");
            assert_eq!(
                document["recording"]["sha256"],
                of_file["recording"]["sha256"]
            );
            assert_eq!(document["recording"]["file"], "-");
            let listed = fed(
                &[&["inspect", "-", "--format", "json"], named].concat(),
                &bytes,
            );
            assert_eq!((listed.code, listed.err.as_str()), (0, ""));
        }
    }
    let wrong = fed(
        &["replay", "-", "--input-format", "mcap", "--no-report"],
        b"time_s,acc_y_g\n0,1\n",
    );
    assert_eq!(wrong.code, 4);
    assert!(wrong.err.contains("expected MCAP's magic"), "{}", wrong.err);
    let empty = fed(&["replay", "-", "--no-report"], b"");
    assert_eq!(empty.code, 4);
    assert!(
        empty.err.starts_with("latchgate: -: the file is empty"),
        "{}",
        empty.err
    );
}

#[test]
fn cli_logs_go_to_stderr_and_change_nothing_on_stdout() {
    let file = signal_file("surviving.csv");
    let own = ["replay", &file, "--no-report", "--format", "json"];
    let silent = latchgate(&own);
    for options in [
        &["-v"][..],
        &["-vvv"],
        &["--log", "debug"],
        &["--log", "text:trace"],
    ] {
        let done = latchgate(&[&own, options].concat());
        assert_eq!(
            without_run(&done.out),
            without_run(&silent.out),
            "{options:?}"
        );
        assert!(
            done.err
                .contains("INFO latchgate_recording: recording read"),
            "{options:?}: {}",
            done.err
        );
    }
    for options in [
        &["--log", "json"][..],
        &["-vv", "--log", "json"],
        &["--log", "json:trace"],
    ] {
        let done = latchgate(&[&own, options].concat());
        assert_eq!(
            without_run(&done.out),
            without_run(&silent.out),
            "{options:?}"
        );
        assert!(!done.err.is_empty());
        for line in done.err.lines() {
            let entry: Value = serde_json::from_str(line).unwrap();
            assert!(
                entry["level"].is_string() && entry["message"].is_string(),
                "{line}"
            );
        }
    }
    // Nothing at this level: nothing said.
    assert_eq!(
        latchgate(&[&own[..], &["--log", "json:error"]].concat()).err,
        ""
    );
}

/// On a terminal, which `script` provides, the log is coloured unless NO_COLOR asks otherwise.
#[cfg(target_os = "linux")]
#[test]
fn cli_no_color_is_honoured_on_a_terminal() {
    let command = format!(
        "{} replay {} --no-report -v",
        env!("CARGO_BIN_EXE_latchgate"),
        signal_file("surviving.csv")
    );
    let on_terminal = |no_color: Option<&str>| {
        let mut script = Command::new("script");
        script
            .args(["-qec", &command, "/dev/null"])
            .env_remove("NO_COLOR")
            .stdin(Stdio::null());
        if let Some(value) = no_color {
            script.env("NO_COLOR", value);
        }
        finish(&mut script).out
    };
    assert!(on_terminal(None).contains('\x1b'));
    assert!(
        on_terminal(Some("")).contains('\x1b'),
        "an empty NO_COLOR asks for nothing"
    );
    let plain = on_terminal(Some("1"));
    assert!(!plain.contains('\x1b') && plain.contains("PASS"), "{plain}");
}

#[test]
fn cli_a_reader_that_goes_away_changes_no_exit_code() {
    let burst = signal_file("burst.csv");
    let cases: [(&[&str], i32); 5] = [
        (&["replay", &burst, "--no-report", "--format", "json"], 1),
        (&["replay", &burst, "--no-report"], 1),
        (&["inspect", &burst], 0),
        (&["completions", "bash"], 0),
        (&["--help"], 0),
    ];
    for (arguments, code) in cases {
        let mut child = program()
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut err = String::new();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut err)
            .unwrap();
        assert_eq!(
            child.wait().unwrap().code(),
            Some(code),
            "{arguments:?}: {err}"
        );
        assert_eq!(err, "", "{arguments:?}");
    }
}

/// A pass that could not be written once ended with 0: a script behind it took the empty
/// answer for one.
#[cfg(target_os = "linux")]
#[test]
fn regress_cli_an_answer_that_cannot_be_written_is_no_pass() {
    let surviving = signal_file("surviving.csv");
    for arguments in [
        &["replay", &surviving, "--no-report"][..],
        &["replay", &surviving, "--no-report", "--format", "json"],
        &["inspect", &surviving],
        &["man"],
    ] {
        let full = fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let output = program()
            .args(arguments)
            .stdout(full)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
            .wait_with_output()
            .unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(4), "{arguments:?}");
        assert!(
            err.contains("cannot write the answer"),
            "{arguments:?}: {err}"
        );
    }
}

// ---------------------------------------------------------------- help, completions, manual

#[test]
fn cli_help_completions_and_manual_name_every_option() {
    let help = latchgate(&["replay", "--help"]);
    assert_eq!((help.code, help.err.as_str()), (0, ""));
    let options: Vec<String> = help
        .out
        .split_whitespace()
        .filter(|word| word.starts_with("--") && word.len() > 4)
        .map(|word| {
            word.trim_end_matches([',', '.', ';', ']'])
                .trim_end_matches("...")
                .to_string()
        })
        .collect();
    for expected in [
        "--channel",
        "--time-column",
        "--time-unit",
        "--rate-hz",
        "--time-zero",
        "--unit",
        "--opens-when",
        "--bias",
        "--filter",
        "--filter-standard",
        "--resample",
        "--window",
        "--design",
        "--set",
        "--model",
        "--method",
        "--steps-per-period",
        "--tolerance",
        "--members",
        "--seed",
        "--phi0",
        "--omega0",
        "--out",
        "--no-report",
        "--input-format",
        "--threads",
        "--format",
        "--log",
        "--verbose",
    ] {
        assert!(
            options.iter().any(|option| option == expected),
            "{expected} not in --help"
        );
        for shell in ["bash", "zsh", "fish"] {
            let script = latchgate(&["completions", shell]);
            assert_eq!((script.code, script.err.as_str()), (0, ""));
            // fish writes `-l name`.
            let word = if shell == "fish" {
                format!("-l {}", &expected[2..])
            } else {
                expected.to_string()
            };
            assert!(script.out.contains(&word), "{word} not in {shell}");
        }
        let page = latchgate(&["man", "replay"]);
        assert!(
            page.out.replace('\\', "").contains(expected),
            "{expected} not in the manual page"
        );
    }
    let page = latchgate(&["man"]);
    assert!(
        page.out.contains(".TH latchgate 1") && page.out.contains("replay"),
        "{}",
        page.out
    );
    let short = latchgate(&["--version"]);
    assert_eq!(
        short.out,
        format!("latchgate {}\n", env!("CARGO_PKG_VERSION"))
    );
}

/// A negative number is a value, also where its exponent is negative.
#[test]
fn cli_negative_numbers_with_exponents_are_values() {
    let file = signal_file("surviving.csv");
    let own = [
        "replay",
        &file,
        "--members",
        "0",
        "--no-report",
        "--format",
        "json",
    ];
    for (option, value, pointer, expected) in [
        ("--phi0", "-1e-6", "/request/phi0", -1e-6),
        ("--omega0", "-2e-3", "/request/omega0", -2e-3),
        ("--time-zero", "-5e-3", "/request/time_zero", -5e-3),
    ] {
        let done = latchgate(&[&own[..], &["--model", "soft", option, value]].concat());
        assert_ne!(done.code, 2, "{option}: {}", done.err);
        let found = done.document().pointer(pointer).unwrap().as_f64();
        assert_eq!(found, Some(expected), "{option}");
    }
}

/// The service is a program of its own: where it does not lie beside, the command says how to build it.
#[test]
#[cfg(unix)]
fn cli_serve_starts_the_program_beside_or_says_how_to_build_it() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("serve");
    let program = folder.path().join("latchgate");
    fs::copy(env!("CARGO_BIN_EXE_latchgate"), &program).unwrap();
    let serve = || {
        let output = Command::new(&program)
            .args(["serve", "--listen", "127.0.0.1:0"])
            .env("PATH", "")
            .output()
            .unwrap();
        let text = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(text).unwrap())
    };
    let (code, text) = serve();
    assert_eq!(code, Some(4), "{text}");
    assert!(
        text.contains("cargo run --release -p latchgate-service"),
        "{text}"
    );
    let service = folder.path().join("latchgate-serve");
    fs::write(&service, "#!/bin/sh\necho \"$@\"\nexit 7\n").unwrap();
    fs::set_permissions(&service, fs::Permissions::from_mode(0o755)).unwrap();
    assert_eq!(serve(), (Some(7), "--listen 127.0.0.1:0\n".into()));
}
