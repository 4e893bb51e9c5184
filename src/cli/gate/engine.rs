//! The programs of a batch system, called with a limit on time.

use latchgate_recording::error::Error;
use std::io::Read;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Time between two looks whether it has.
const EVERY: Duration = Duration::from_millis(10);

/// Time for which a pipe is listened to that what a program left behind holds open.
const SILENCE: Duration = Duration::from_secs(1);

/// Longest answer that is read: a line for each of a million tasks [bytes].
const ANSWER_MAX: u64 = 64 << 20;

/// Longest reason that is told of a program [characters].
const REASON_MAX: usize = 400;

/// Runs a program, which has that long to answer, and returns what it printed.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] that says whether it is not installed, does not answer, finds no
/// configuration or no controller, or refuses, in its own words.
pub(super) fn ask(program: &str, arguments: &[String], within: Duration) -> Result<String, Error> {
    let begun = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = begun.map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => failed(format!(
            "{program} is not installed or not on the path; run this where the cluster takes jobs"
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
            Ok(None) if began.elapsed() < within => std::thread::sleep(EVERY),
            other => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(failed(match other {
                    Err(error) => format!("{program} cannot be watched: {error}"),
                    Ok(_) => format!(
                        "{program} did not answer in {} s; its controller may be down or the \
                         configuration wrong; try scontrol ping",
                        within.as_secs()
                    ),
                }));
            }
        }
    };
    let (out, err) = (text_of(&out), text_of(&err));
    if status.success() {
        return Ok(out);
    }
    Err(failed(reason(program, &err)))
}

fn read_aside(pipe: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let (Some(pipe), mut bytes) = (pipe, [0; 4096]) else {
            return;
        };
        let mut pipe = pipe.take(ANSWER_MAX);
        while let Ok(read @ 1..) = pipe.read(&mut bytes) {
            if sender.send(bytes[..read].to_vec()).is_err() {
                break;
            }
        }
    });
    receiver
}

fn text_of(pipe: &Receiver<Vec<u8>>) -> String {
    let mut bytes = Vec::new();
    while let Ok(some) = pipe.recv_timeout(SILENCE) {
        bytes.extend(some);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Says why a program refused.
fn reason(program: &str, err: &str) -> String {
    let said: String = err.split_whitespace().collect::<Vec<_>>().join(" ");
    let said: String = said.chars().take(REASON_MAX).collect();
    let known = [
        (
            "configuration source",
            "it has no configuration; set SLURM_CONF, or run this where the cluster takes jobs",
        ),
        (
            "contact slurm controller",
            "its controller is down; try again when scontrol ping says it is up",
        ),
    ];
    match known.iter().find(|(words, _)| said.contains(words)) {
        Some((_, told)) => format!("{program}: {told} ({said})"),
        None => format!("{program} refuses: {said}"),
    }
}

fn failed(reason: String) -> Error {
    Error::io("speak with the batch system", &reason)
}
