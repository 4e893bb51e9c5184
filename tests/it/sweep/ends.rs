//! Shares whose process is ended, and recordings that are not what they were.

use super::{SweepYard, told};
use crate::support::{Done, Random, finish, program};
use latchgate::pipeline::NUMBERS_REVISION;
use sha2::{Digest, Sha256};
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

/// A process that does not hear that it is to end is ended before its batch system kills both.
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

/// The keys in the store decide: of another recording, card, design, setting, limit or revision no decision
/// is collected, its pairs are missing.
#[test]
fn cli_nothing_is_collected_of_what_is_not_there_any_more() {
    let yard = SweepYard::new("changed", 4, 2, 0);
    let collect = || {
        let _ = fs::remove_dir_all(yard.path("collected"));
        yard.collect(&[])
    };
    assert_eq!(yard.part("1/1", &[]).code, 0);
    let code = collect().code;
    assert_ne!(code, 4);
    let summary = yard.text("collected/summary.json");
    let gate = yard.text("gate.toml");
    let file = yard.files().remove(0);
    let lines = fs::read_to_string(&file).unwrap();
    let card = "recordings/r0001.csv.toml";
    let judged_peak_g = 4.0 + 30.0 / 4.0;
    let set_gate =
        |from: &str, to: &str| drop(yard.folder.write("gate.toml", gate.replace(from, to)));
    let ranged = "synthetic = true\nrange_g = 1000\n";
    let changes: [(&str, &dyn Fn(), usize); 6] = [
        ("recording", &|| yard.recording(1, 99.0), 2),
        ("card", &|| drop(yard.folder.write(card, ranged)), 2),
        ("a new recording", &|| yard.recording(9, 5.0), 2),
        ("design", &|| set_gate("0.6000", "0.7000"), 4),
        ("setting", &|| set_gate("members = 0", "members = 1"), 8),
        (
            "revision",
            &|| fs::write(&file, of_the_revision_before(&lines)).unwrap(),
            8,
        ),
    ];
    for (change, make, missing) in changes {
        make();
        let done = collect();
        assert_eq!(done.code, 4, "{change}: {}", done.err);
        assert!(
            done.out.contains(&format!(", {missing} missing\n")),
            "{change}: {}",
            done.out
        );
        assert!(!yard.path("collected").exists(), "{change}");
        // As it was, it is collected as it was.
        yard.recording(1, judged_peak_g);
        let _ = fs::remove_file(yard.path("recordings/r0009.csv"));
        let _ = fs::remove_file(yard.path("recordings/r0009.csv.toml"));
        yard.folder.write("gate.toml", &gate);
        fs::write(&file, &lines).unwrap();
        assert_eq!(collect().code, code, "{change}");
        assert_eq!(yard.text("collected/summary.json"), summary, "{change}");
    }
    let done = yard.collect(&["--limit", "text_bytes=100000000"]);
    assert_eq!(done.code, 4, "{}", done.err);
    assert!(done.out.contains(", 8 missing\n"), "{}", done.out);
    // The next share judges what changed, and the summary is that of one process.
    yard.recording(1, 99.0);
    let done = yard.part("1/1", &[]);
    assert_eq!(
        (
            told(&done, "pairs judged"),
            told(&done, "in the store before")
        ),
        (2, 6)
    );
    let whole = yard.gate(&["--no-store", "--out", "whole"]);
    assert_eq!(collect().code, whole.code);
    assert_eq!(
        yard.text("collected/summary.json"),
        yard.text("whole/summary.json")
    );
    // A design or recording that is gone from the gate is gone from its summary.
    fs::remove_file(yard.path("recordings/r0001.csv")).unwrap();
    let whole = yard.gate(&["--no-store", "--out", "fewer"]);
    assert_eq!(collect().code, whole.code);
    assert_eq!(
        yard.text("collected/summary.json"),
        yard.text("fewer/summary.json")
    );
}

/// Lines of a store with the revision before in each decision, sealed again.
fn of_the_revision_before(lines: &str) -> String {
    let now = format!("\"rev\":{NUMBERS_REVISION}");
    let before = format!("\"rev\":{}", NUMBERS_REVISION - 1);
    let sealed = |line: &str| {
        let (body, _) = line.rsplit_once(",\"sum\"").unwrap();
        let body = body.replace(&now, &before);
        let digest = Sha256::digest(body.as_bytes());
        let sum: String = digest[..8]
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        format!("{body},\"sum\":\"{sum}\"}}\n")
    };
    lines.lines().map(sealed).collect()
}

/// Whatever stands behind a `--`, a share is judged by one process and watched by one other.
#[test]
fn cli_a_share_is_watched_once() {
    let yard = SweepYard::new("behind", 2, 2, 0);
    let mut command = program();
    command.current_dir(yard.folder.path());
    command.args([
        "gate",
        "--store",
        "store",
        "--part",
        "1/1",
        "--",
        "gate.toml",
    ]);
    let done = finish(&mut command);
    assert_eq!(done.code, 0, "{}", done.err);
    assert_eq!(told(&done, "pairs judged"), 4, "{}", done.err);
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
