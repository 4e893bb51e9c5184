//! Ctrl-C ends every command soon, with a word and an exit code of its own; nothing half-made is
//! left for an answer.

use crate::support::{Folder, finish, program};
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Presses Ctrl-C on a command that would take far longer. A program that goes on is waited for
/// until it is sure that it does not end by the wish; how soon it ends is no test's to measure.
#[track_caller]
fn check_ended(folder: &Folder, arguments: &[&str]) {
    let mut child = program()
        .args(arguments)
        .current_dir(folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(700));
    assert!(
        child.try_wait().unwrap().is_none(),
        "ended before: {arguments:?}"
    );
    let asked = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(asked.success());
    let pressed = Instant::now();
    // Its standard input stays open until it ends.
    while child.try_wait().unwrap().is_none() {
        if pressed.elapsed() > Duration::from_secs(20) {
            child.kill().unwrap();
            panic!("{arguments:?} went on");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{arguments:?}: {said}");
    assert_eq!(said, "latchgate: interrupted\n", "{arguments:?}");
    assert!(output.stdout.is_empty(), "{arguments:?} left an answer");
    assert!(
        !folder.path().join("reports").exists() && !folder.path().join("out").exists(),
        "{arguments:?} left a report"
    );
}

#[test]
fn cli_ctrl_c_ends_every_command() {
    let folder = Folder::new("interrupt");
    let path = format!("{}/signals/burst.csv", env!("CARGO_MANIFEST_DIR"));
    check_ended(&folder, &["margin", &path]);
    // Two million samples, and a lever that is never at rest.
    let (short, long) = (square(&folder, 20_000), square(&folder, 2_000_000));
    let asked = ["--rate-hz", "20000"];
    check_ended(&folder, &[&["replay", &long][..], &asked].concat());
    check_ended(&folder, &[&["margin", &long][..], &asked].concat());
    // The question of a short recording, asked of the long one.
    let mut verdict = program();
    verdict.args(["replay", &short, "--members", "0", "--out"]);
    verdict.arg(folder.path().join("short")).args(asked);
    assert_eq!(finish(&mut verdict).code, 4, "it flickers");
    let verdict = "short/verdict.json";
    check_ended(&folder, &["verify", verdict, "--recording", &long]);
    let gate = "[[recordings]]\nfiles = [\"2000000.csv\"]\nrate_hz = 20000\nmembers = 0\n\
                [[designs]]\nname = \"paper\"\n";
    folder.write("gate.toml", gate);
    let judged = ["gate", "gate.toml", "--out", "out", "--no-store"];
    check_ended(&folder, &judged);
    // A recording that never ends: nobody writes to its standard input.
    check_ended(&folder, &["inspect", "-"]);
}

/// Once the verdict is printed, Ctrl-C ends the search for advice with the verdict's own code.
#[test]
fn cli_ctrl_c_after_a_printed_verdict_leaves_its_code() {
    let folder = Folder::new("interrupt-late");
    let path = format!("{}/signals/surviving.csv", env!("CARGO_MANIFEST_DIR"));
    // Seconds of search, after a tenth of one for the verdict.
    let mut child = program()
        .args(["replay", &path])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut first = String::new();
    out.read_line(&mut first).unwrap();
    let asked = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(asked.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(first.contains("PASS"), "{first}");
    assert_eq!(output.status.code(), Some(0), "{first}{said}");
    assert!(
        said.ends_with("latchgate: interrupted: the verdict stands, without advice and report\n"),
        "{said}"
    );
    assert!(!folder.path().join("reports").exists());
}

/// Writes a recording of so many samples, and returns its path.
fn square(folder: &Folder, samples: u32) -> String {
    let rows: String = (0..samples)
        .map(|k| format!("{}.0\n", if k % 40 < 20 { 20 } else { -20 }))
        .collect();
    folder.write(&format!("{samples}.csv"), format!("acc_y_g\n{rows}"))
}
