//! Shares on a Slurm that is none: what it says at the wrong time, and what lies there from before.

use super::SweepYard;
use crate::support::{Done, finish};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A gate beside which a Slurm lies that counts its jobs from 1.
struct FakeSlurm {
    yard: SweepYard,
}

impl FakeSlurm {
    fn new(name: &str, recordings: usize, designs: usize) -> Self {
        let yard = SweepYard::new(name, recordings, designs, 0);
        let tool = yard
            .folder
            .file("tools/slurm.sh", include_str!("fake_slurm.sh"));
        fs::set_permissions(&tool, PermissionsExt::from_mode(0o755)).unwrap();
        for name in ["sbatch", "squeue", "scontrol", "scancel"] {
            symlink("slurm.sh", tool.with_file_name(name)).unwrap();
        }
        Self { yard }
    }

    /// Calls the gate where this Slurm is on the path.
    fn gate(&self, more: &[&str]) -> Done {
        self.gate_into("out", more)
    }

    fn gate_into(&self, out: &str, more: &[&str]) -> Done {
        let own = ["--store", "store", "--out", out];
        let mut command = self.yard.command(&[&own[..], more].concat());
        let path = format!(
            "{}:{}",
            self.yard.path("tools").display(),
            std::env::var("PATH").unwrap()
        );
        finish(command.env("PATH", path))
    }

    fn submit(&self, shares: &str, more: &[&str]) -> Done {
        self.gate(&[&["--submit", "slurm", "--parts", shares], more].concat())
    }

    fn state(&self, name: &str) -> PathBuf {
        self.yard.path("tools/state").join(name)
    }

    /// Sets one of the faults that the script lists.
    fn set(&self, fault: &str, text: &str) {
        self.yard
            .folder
            .write(&format!("tools/state/{fault}"), text);
    }

    /// What was asked of it, a line for each.
    fn told(&self, name: &str) -> String {
        fs::read_to_string(self.state(name)).unwrap_or_default()
    }
}

/// A cluster that was set up anew gives its jobs the numbers of those before: what such a job once
/// answered is no answer of this one.
#[test]
fn cli_an_answer_of_an_earlier_job_of_that_number_is_none() {
    let slurm = FakeSlurm::new("answers", 1, 1);
    let done = slurm.submit("2", &["--wait"]);
    assert_eq!(done.code, 0, "{}{}", done.err, slurm.told("log"));
    slurm.yard.recording(0, 99.0);
    fs::remove_dir_all(slurm.state("")).unwrap();
    let done = slurm.submit("2", &["--wait"]);
    assert_eq!(done.code, 1, "{}{}", done.err, slurm.told("log"));
    assert_eq!(slurm.told("submitted"), "1 1-2\n2\n");
}

/// What others submit meanwhile under that name, or write into the gate file, decides nothing of what
/// one waits for.
#[test]
fn cli_whoever_waits_gets_the_answer_to_his_own_question() {
    let slurm = FakeSlurm::new("two-wait", 1, 1);
    slurm.yard.recording(0, 99.0);
    let failing = slurm.yard.gate(&["--no-store", "--out", "base"]);
    assert_eq!(failing.code, 1, "{}", failing.err);
    let submitted = |lines: usize| {
        while slurm.told("submitted").lines().count() < lines {
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    let no_worse = ["--baseline", "base/summary.json", "--no-worse"];
    for (shares, of_the_first) in [("1", 1), ("2", 4)] {
        let _ = fs::remove_dir_all(slurm.state(""));
        let _ = fs::remove_dir_all(slurm.yard.path("store"));
        let (first, second) = std::thread::scope(|scope| {
            let first = scope.spawn(|| slurm.submit("1", &["--wait"]));
            submitted(2);
            let own = ["--submit", "slurm", "--parts", shares, "--wait"];
            let second = slurm.gate_into("second", &[&own[..], &no_worse].concat());
            (first.join().unwrap(), second)
        });
        let log = slurm.told("log");
        // Of another submission nothing is left to collect: that is no pass either.
        assert_eq!(first.code, of_the_first, "{}{log}", first.err);
        assert_eq!(second.code, 0, "{}{log}", second.err);
    }
    // The rules are those of the gate file as it was submitted.
    let _ = fs::remove_dir_all(slurm.state(""));
    let text = slurm.yard.text("gate.toml");
    let done = std::thread::scope(|scope| {
        let done = scope.spawn(|| slurm.submit("1", &["--wait"]));
        submitted(2);
        let lenient = format!("{text}\n[[require]]\nverdict = \"fail\"\n");
        slurm.yard.folder.write("gate.toml", lenient);
        done.join().unwrap()
    });
    let log = slurm.told("log");
    assert_eq!(done.code, 4, "{}{log}", done.err);
    assert!(log.contains("the gate file as it was submitted"), "{log}");
}

/// A recording that changed after its share judged it is not what the answer would be of.
#[test]
fn cli_a_recording_that_changed_since_is_not_collected() {
    let slurm = FakeSlurm::new("changed", 2, 1);
    slurm.yard.recording(1, 99.0);
    let done = slurm.submit("1", &["--wait"]);
    assert_eq!(done.code, 1, "{}", done.err);
    slurm.yard.recording(1, 0.1);
    let collected = slurm.gate(&["--collect"]);
    assert_eq!(collected.code, 4, "{}", collected.err);
    let told = "recordings/r0001.csv: expected the recording as it was submitted and judged";
    assert!(collected.err.contains(told), "{}", collected.err);
}

/// What is only printed has no answer to wait for.
#[test]
fn cli_printing_does_not_wait() {
    let slurm = FakeSlurm::new("print-wait", 1, 1);
    let words = ["--submit", "slurm", "--parts", "1", "--print", "--wait"];
    assert_eq!(slurm.gate(&words).code, 2);
}

/// A task that Slurm holds since it could not be launched will never run: it is cancelled, and its
/// share submitted again.
#[test]
fn cli_a_task_that_is_held_counts_as_lost() {
    let slurm = FakeSlurm::new("held", 6, 1);
    slurm.set("held", "");
    let done = slurm.submit("2", &[]);
    assert_eq!(done.code, 0, "{}", done.err);
    let status = slurm.gate(&["--status"]);
    assert!(
        status.out.contains("0 tasks running, 0 waiting, 2 stuck"),
        "{}",
        status.out
    );
    // By hand.
    let again = slurm.gate(&["--resubmit"]);
    assert_eq!(again.code, 0, "{}", again.err);
    assert_eq!(slurm.told("cancelled"), "1_1 1_2 2\n");
    assert_eq!(slurm.told("submitted"), "1 1-2\n2\n3 1-2\n4\n");
    // By the one who waits, and by the collecting job.
    fs::remove_dir_all(slurm.state("")).unwrap();
    fs::remove_dir_all(slurm.yard.path("store")).unwrap();
    slurm.set("held", "");
    let done = slurm.submit("2", &["--wait"]);
    let alone = slurm.yard.gate(&["--no-store", "--out", "alone"]);
    assert_eq!(done.code, alone.code, "{}{}", done.err, slurm.told("log"));
    assert_eq!(slurm.told("cancelled"), "1_1 1_2\n");
    assert_eq!(slurm.told("submitted"), "1 1-2\n2\n3 1-2\n4\n");
}

#[test]
fn cli_what_is_missing_is_submitted_three_times_and_no_more() {
    let slurm = FakeSlurm::new("lost", 6, 2);
    slurm.set("lost", "");
    let done = slurm.submit("2", &["--wait"]);
    let log = slurm.told("log");
    assert_eq!(done.code, 4, "{}{log}", done.err);
    let submitted = "1 1-2\n2\n3 1-2\n4\n5 1-2\n6\n7 1-2\n8\n";
    assert_eq!(slurm.told("submitted"), submitted, "{log}");
    assert_eq!(
        log.matches("shares 1-2 submitted again").count(),
        3,
        "{log}"
    );
    let list = log.rsplit("SWEEP").next().unwrap();
    for number in 0..6 {
        let missing = format!("missing    recordings/r000{number}.csv: 2 pairs");
        assert!(list.contains(&missing), "{list}");
    }
    assert!(list.contains("shares     1-2 of 2"), "{list}");
    assert!(!slurm.yard.path("out").exists());
}

/// A program of the engine that never answers ends the command, and the text names it.
#[test]
fn cli_an_engine_that_hangs_is_not_waited_for_for_ever() {
    let slurm = FakeSlurm::new("hangs", 1, 1);
    for program in ["scontrol", "sbatch"] {
        slurm.set("silent", program);
        let began = Instant::now();
        let done = slurm.submit("1", &["--wait", "--patience", "2"]);
        assert_eq!(done.code, 4, "{}", done.err);
        let told = format!("{program} did not answer in 2 s; its controller may be down");
        assert!(done.err.contains(&told), "{}", done.err);
        assert!(began.elapsed() < Duration::from_secs(20));
    }
    slurm.set("silent", "");
    assert_eq!(slurm.submit("1", &["--wait"]).code, 0);
    slurm.set("silent", "squeue");
    // What the store tells is told all the same; nothing is submitted twice unseen.
    let status = slurm.gate(&["--status", "--patience", "2"]);
    assert_eq!(status.code, 0, "{}", status.err);
    assert!(status.out.contains("1 of 1 pair judged"), "{}", status.out);
    assert!(
        status.err.contains("squeue did not answer"),
        "{}",
        status.err
    );
    slurm.yard.recording(1, 9.0);
    slurm.set("silent", "");
    slurm.set("lost", "");
    slurm.submit("1", &[]);
    slurm.set("silent", "squeue");
    let submitted = slurm.told("submitted");
    let again = slurm.gate(&["--resubmit", "--patience", "2"]);
    assert_eq!(again.code, 4, "{}", again.err);
    assert_eq!(slurm.told("submitted"), submitted);
}

/// What a program of the engine leaves behind may hold its output open: the answer counts.
#[test]
fn cli_an_answer_is_taken_though_its_pipe_stays_open() {
    let slurm = FakeSlurm::new("pipe", 1, 1);
    let tool = slurm.yard.path("tools/scontrol");
    fs::remove_file(&tool).unwrap();
    let text = "#!/bin/sh\nsleep 20 &\necho 'MaxArraySize = 3'\n";
    slurm.yard.folder.write("tools/scontrol", text);
    fs::set_permissions(&tool, PermissionsExt::from_mode(0o755)).unwrap();
    let began = Instant::now();
    let done = slurm.submit("5", &[]);
    assert_eq!(done.code, 0, "{}", done.err);
    assert!(began.elapsed() < Duration::from_secs(15));
    assert_eq!(slurm.told("submitted"), "1 1-2\n2 1-2\n3 1\n4\n");
}
