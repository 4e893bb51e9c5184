//! The programs of a batch system, called with a limit on time.

use crate::error::{Error, ErrorKind};
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Time that a program of the engine has to answer.
const ANSWER_WITHIN: Duration = Duration::from_secs(30);

/// Time between two looks whether it has.
const EVERY: Duration = Duration::from_millis(10);

/// Longest reason that is told of a program [characters].
const REASON_MAX: usize = 400;

/// Runs a program and returns what it printed.
///
/// # Errors
///
/// [`ErrorKind::Io`] that says whether it is not installed, does not answer, finds no configuration
/// or no controller, or refuses, in its own words.
pub(super) fn ask(program: &str, arguments: &[String]) -> Result<String, Error> {
    let begun = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = begun.map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => failed(format!(
            "{program} is not installed here, or not on the path; run this where the cluster takes jobs"
        )),
        _ => failed(format!("{program} cannot be started: {error}")),
    })?;
    // Read aside, since a long answer fills a pipe.
    let out = read_aside(child.stdout.take());
    let err = read_aside(child.stderr.take());
    let began = Instant::now();
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if began.elapsed() < ANSWER_WITHIN => std::thread::sleep(EVERY),
            other => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(failed(match other {
                    Err(error) => format!("{program} cannot be watched: {error}"),
                    Ok(_) => format!(
                        "{program} did not answer in {} s; its controller may be away, or the \
                         configuration wrong: try scontrol ping",
                        ANSWER_WITHIN.as_secs()
                    ),
                }));
            }
        }
    };
    let (out, err) = (text_of(out), text_of(err));
    if status.success() {
        return Ok(out);
    }
    Err(failed(reason(program, &err)))
}

fn read_aside(pipe: Option<impl Read + Send + 'static>) -> std::thread::JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            let _ = pipe.read_to_end(&mut bytes);
        }
        bytes
    })
}

fn text_of(reading: std::thread::JoinHandle<Vec<u8>>) -> String {
    String::from_utf8_lossy(&reading.join().unwrap_or_default()).into_owned()
}

/// Says why a program refused.
fn reason(program: &str, err: &str) -> String {
    let said: String = err.split_whitespace().collect::<Vec<_>>().join(" ");
    let said: String = said.chars().take(REASON_MAX).collect();
    let known = [
        (
            "configuration source",
            "it finds no configuration; set SLURM_CONF, or run this where the cluster takes jobs",
        ),
        (
            "contact slurm controller",
            "the controller is away; try again once scontrol ping says that it is up",
        ),
    ];
    match known.iter().find(|(words, _)| said.contains(words)) {
        Some((_, told)) => format!("{program}: {told} ({said})"),
        None => format!("{program} refuses: {said}"),
    }
}

fn failed(reason: String) -> Error {
    Error::from(ErrorKind::Io {
        action: "speak with the batch system",
        reason,
    })
}
