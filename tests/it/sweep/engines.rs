//! What is handed to engines, without one.

use super::SweepYard;
use crate::support::finish;
use std::os::unix::fs::PermissionsExt;

#[test]
fn cli_the_script_of_a_share_is_printed() {
    let yard = SweepYard::new("script", 3, 2, 0);
    let done = yard.gate(&["--submit", "slurm", "--parts", "20", "--print"]);
    assert_eq!(done.code, 0, "{}", done.err);
    assert!(done.out.starts_with("#!/bin/bash\n"), "{}", done.out);
    assert!(
        done.out
            .contains("--part \"$((SLURM_ARRAY_TASK_ID + ${1:-0}))/20\""),
        "{}",
        done.out
    );
    assert!(done.err.contains("6 pairs: about"), "{}", done.err);
    assert!(
        done.err
            .contains("a task costs about a second of scheduling"),
        "{}",
        done.err
    );
    assert!(!yard.path(".latchgate").exists());
}

#[test]
fn cli_what_only_shares_have_is_no_option_of_a_gate() {
    let yard = SweepYard::new("alone", 2, 2, 0);
    assert_eq!(yard.gate(&["--", "--time=1"]).code, 2);
}

#[test]
fn cli_an_engine_that_does_not_answer_is_told_of() {
    let yard = SweepYard::new("silent", 2, 2, 0);
    let submit = |tools: &str| {
        let mut command = yard.command(&["--store", "store", "--submit", "slurm", "--parts", "2"]);
        finish(command.env("PATH", tools))
    };
    let done = submit("/nowhere");
    assert_eq!(done.code, 4);
    assert!(
        done.err
            .contains("scontrol is not installed or not on the path"),
        "{}",
        done.err
    );
    for (said, told) in [
        (
            "slurm_load_ctl_conf error: Unable to contact slurm controller (connect failure)",
            "its controller is down",
        ),
        (
            "error: Could not establish a configuration source",
            "set SLURM_CONF",
        ),
        (
            "Invalid job array specification",
            "scontrol refuses: Invalid job array specification",
        ),
    ] {
        let tool = yard.folder.file(
            "tools/scontrol",
            format!("#!/bin/sh\necho '{said}' >&2\nexit 1\n"),
        );
        std::fs::set_permissions(&tool, PermissionsExt::from_mode(0o755)).unwrap();
        let done = submit(tool.parent().unwrap().to_str().unwrap());
        assert_eq!(done.code, 4);
        assert!(done.err.contains(told), "{}", done.err);
    }
}

/// What is an engine's is no share's; whatever stands behind a `--`, a share is judged by one process and
/// watched by one other.
#[test]
fn cli_a_share_takes_no_options_of_an_engine() {
    let yard = SweepYard::new("behind", 2, 2, 0);
    let done = yard.part("1/1", &["--", "--time=1"]);
    assert_eq!(done.code, 2, "{}", done.err);
    let done = yard.part("1/1", &["--"]);
    assert_eq!(done.code, 0, "{}", done.err);
}
