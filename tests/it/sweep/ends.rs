//! Shares whose process is ended, and recordings that are not what they were.

use super::{SweepYard, told};
use crate::support::{Done, Random, finish};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn kill(signal: &str, process: u32) {
    let _ = Command::new("kill")
        .args([signal, &process.to_string()])
        .status();
}

/// Judges the whole gate under limits that a shell sets.
fn limited(yard: &SweepYard, limits: &str, threads: &str) -> Done {
    let command = yard.command(&["--store", "store", "--part", "1/1", "--threads", threads]);
    let mut shell = Command::new("sh");
    shell
        .current_dir(yard.folder.path())
        .args(["-c", &format!("{limits}; exec \"$0\" \"$@\"")])
        .arg(command.get_program())
        .args(command.get_args());
    finish(&mut shell)
}

#[test]
fn cli_a_share_that_is_terminated_keeps_what_is_done() {
    let yard = SweepYard::new("terminated", 15, 16, 512);
    let mut command = yard.command(&["--store", "store", "--part", "1/1", "--threads", "1"]);
    let child = command.stderr(Stdio::piped()).spawn().unwrap();
    // A line says that a pair was begun, a further one what came of it.
    yard.wait_for_lines(3);
    kill("-TERM", child.id());
    let output = child.wait_with_output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{err}");
    let rest = yard.part("1/1", &[]);
    assert_eq!(rest.code, 0, "{}", rest.err);
    assert!(told(&rest, "in the store before") > 0, "{}", rest.err);
    assert_eq!(
        told(&rest, "in the store before") + told(&rest, "pairs judged"),
        240
    );
}

/// A process that does not hear that it is to end is ended before an engine's patience is.
#[test]
fn cli_a_process_that_is_deaf_is_ended() {
    let yard = SweepYard::new("deaf", 15, 16, 512);
    let mut command = yard.command(&["--store", "store", "--part", "1/1", "--threads", "1"]);
    let child = command.stderr(Stdio::piped()).spawn().unwrap();
    let children = format!("/proc/{0}/task/{0}/children", child.id());
    let worker = loop {
        let listed = fs::read_to_string(&children).unwrap();
        if let Some(worker) = listed.split_whitespace().next() {
            break worker.parse().unwrap();
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    yard.wait_for_lines(1);
    kill("-STOP", worker);
    kill("-TERM", child.id());
    let began = Instant::now();
    let output = child.wait_with_output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{err}");
    assert!(began.elapsed() < Duration::from_secs(20), "{err}");
    assert!(
        err.contains("was ended by a time limit: it did not end on request"),
        "{err}"
    );
    assert!(!PathBuf::from(format!("/proc/{worker}")).exists());
    // What it had begun is tried again once, and only once more.
    let begun = fs::read_to_string(&yard.files()[0]).unwrap();
    assert!(begun.contains("\"note\":\"begun\""), "{begun}");
    let rest = yard.part("1/1", &[]);
    assert_eq!(rest.code, 0, "{}", rest.err);
}

/// However often a share is killed, it ends, and little is done twice.
#[test]
fn cli_kills_cost_little_and_change_nothing() {
    let yard = SweepYard::new("kills", 12, 20, 512);
    yard.gate(&["--no-store", "--out", "whole"]);
    let mut random = Random::new(5);
    let mut judged = 0;
    for _ in 0..25 {
        let log = yard.path("log");
        let mut command = yard.command(&["--store", "store", "--part", "1/1", "--log", "debug"]);
        let mut child = command
            .stderr(fs::File::create(&log).unwrap())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(100 + random.below(400) as u64));
        kill("-KILL", child.id());
        child.wait().unwrap();
        // The process that was watched ends by itself.
        std::thread::sleep(Duration::from_millis(100));
        judged += fs::read_to_string(&log)
            .unwrap()
            .matches("judged recording")
            .count();
    }
    let last = yard.part("1/1", &["--log", "debug"]);
    assert_eq!(last.code, 0, "{}", last.err);
    judged += last.err.matches("judged recording").count();
    assert!(judged >= 240, "the log tells of {judged} pairs");
    assert!(
        judged <= 240 + 25 * 2,
        "{judged} pairs judged instead of 240"
    );
    yard.collect(&[]);
    assert_eq!(
        yard.text("collected/summary.json"),
        yard.text("whole/summary.json")
    );
}

/// A recording for which the memory does not suffice aborts the process that judges it. After the second
/// time shares pass over it; the others are judged.
#[test]
fn cli_a_recording_that_ends_its_process_is_passed_over_and_named() {
    let yard = SweepYard::new("abort", 5, 3, 0);
    let long: String = (0..400_000)
        .map(|k| format!("{:.5},{}\n", f64::from(k) / 1e5 - 0.02, k % 7))
        .collect();
    yard.folder
        .write("recordings/r0002.csv", format!("time_s,acc_y_g\n{long}"));
    let done = limited(&yard, "ulimit -c 0; ulimit -v 60000", "2");
    assert_eq!(done.code, 4, "{}", done.err);
    assert_eq!(
        done.err.matches("was ended by signal 6 (SIGABRT)").count(),
        2,
        "{}",
        done.err
    );
    assert!(
        done.err.contains("recordings/r0002.csv: ")
            && done.err.contains("begun 2 times and never finished"),
        "{}",
        done.err
    );
    let judged = told(&done, "pairs judged") + told(&done, "in the store before");
    assert_eq!(judged, 12, "{}", done.err);
    let collected = yard.collect(&[]);
    assert_eq!(collected.code, 4, "{}", collected.err);
    assert!(!yard.path("collected").exists());
    for line in [
        "recordings/r0002.csv: 3 pairs",
        "recordings/r0002.csv: begun twice and never finished",
    ] {
        assert!(collected.out.contains(line), "{}", collected.out);
    }
    // Another share passes over it, however much memory it has; the gate itself does not.
    assert_eq!(yard.part("1/1", &[]).code, 4);
    let desk = yard.gate(&["--store", "store", "--out", "desk"]);
    assert!(desk.err.contains("12 of 15 pairs cached"), "{}", desk.err);
    let collected = yard.collect(&[]);
    assert_eq!(collected.code, desk.code, "{}", collected.err);
    assert_eq!(
        yard.text("collected/summary.json"),
        yard.text("desk/summary.json")
    );
}

#[test]
fn cli_what_changed_since_the_submission_is_refused() {
    let yard = SweepYard::new("changed", 4, 2, 0);
    let id = yard.submit(1);
    let gate = yard.text("gate.toml");
    yard.recording(1, 99.0);
    let done = yard.part("1/1", &["--submission", &id]);
    assert_eq!(done.code, 4, "{}", done.err);
    assert!(done.err.contains("recordings/r0001.csv: "), "{}", done.err);
    assert!(
        done.err.contains("its hash changed since it was submitted"),
        "{}",
        done.err
    );
    assert_eq!(told(&done, "pairs judged"), 6, "{}", done.err);
    let collected = yard.collect(&[]);
    assert_eq!(collected.code, 4);
    assert!(
        collected.out.contains("recordings/r0001.csv: 2 pairs"),
        "{}",
        collected.out
    );
    // A card is part of the recording.
    yard.recording(1, 4.0 + 30.0 / 4.0);
    yard.folder.write(
        "recordings/r0001.csv.toml",
        "synthetic = true\nrange_g = 1000\n",
    );
    assert_eq!(yard.part("1/1", &["--submission", &id]).code, 4);
    yard.recording(1, 4.0 + 30.0 / 4.0);
    assert_eq!(yard.part("1/1", &["--submission", &id]).code, 0);
    // Of another design nothing is judged, and an older submission's tasks end.
    yard.folder
        .write("gate.toml", gate.replace("0.6000", "0.7000"));
    let done = yard.part("1/1", &["--submission", &id]);
    assert_eq!(done.code, 4);
    assert!(
        done.err.contains("design `d000` as it was submitted"),
        "{}",
        done.err
    );
    assert_eq!(yard.collect(&[]).code, 4);
    yard.submit(1);
    let done = yard.part("1/1", &["--submission", &id]);
    assert!(
        done.err.contains("the sweep was submitted again since"),
        "{}",
        done.err
    );
}

/// A process that cannot write ends with 4, and blames no recording for it.
#[test]
fn cli_a_full_disk_is_no_recordings_fault() {
    let yard = SweepYard::new("full", 3, 40, 0);
    fs::create_dir_all(yard.path("store")).unwrap();
    for _ in 0..4 {
        // Files of two kilobytes at most, and a write beyond fails instead of ending the process.
        let done = limited(&yard, "trap '' XFSZ; ulimit -f 4", "1");
        assert_eq!(done.code, 4, "{}", done.err);
    }
    let done = yard.part("1/1", &[]);
    assert_eq!(done.code, 0, "{}", done.err);
}
