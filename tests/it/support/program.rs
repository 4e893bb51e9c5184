//! The program: arguments in, what it left behind out.

use serde_json::Value;
use std::io::Write;
use std::process::{Command, Stdio};

/// What a run of the program left behind.
pub(crate) struct Done {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Done {
    /// Returns stdout as the one JSON document that it must be.
    #[track_caller]
    pub(crate) fn document(&self) -> Value {
        serde_json::from_str(&self.out)
            .unwrap_or_else(|error| panic!("stdout is no JSON document ({error}): {}", self.out))
    }
}

/// The program, with no settings of the desk in its environment.
pub(crate) fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_latchgate"));
    command.env_remove("NO_COLOR").stdin(Stdio::null());
    command
}

pub(crate) fn finish(command: &mut Command) -> Done {
    let output = command.output().unwrap();
    Done {
        code: output.status.code().expect("ended by itself"),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// Runs the program; a replay without the search for advice, which takes longer than all that most tests ask.
pub(crate) fn latchgate(arguments: &[&str]) -> Done {
    match arguments {
        // A command line that the program offers repeats its own words.
        ["replay", rest @ ..] if !rest.contains(&"--no-advice") => {
            finish(program().args(["replay", "--no-advice"]).args(rest))
        }
        _ => advised(arguments),
    }
}

/// Runs the program as it is asked, with its advice.
pub(crate) fn advised(arguments: &[&str]) -> Done {
    finish(program().args(arguments))
}

pub(crate) fn fed(arguments: &[&str], input: &[u8]) -> Done {
    let mut child = program()
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that stops reading early is no fault of the test.
    let _ = child.stdin.take().unwrap().write_all(input);
    let output = child.wait_with_output().unwrap();
    Done {
        code: output.status.code().unwrap(),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// Cuts the run block off, the only one that may differ between two runs.
pub(crate) fn without_run(document: &str) -> &str {
    let end = document
        .find("\n  \"run\":")
        .expect("a run block, the last");
    &document[..end]
}
