//! The programs of a batch system, run with a time limit.

use latchgate_recording::error::Error;
use std::io::Read;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Interval of polling a program for its end.
const EVERY: Duration = Duration::from_millis(10);

/// Time after which a silent pipe counts as finished: a background process may hold it open after
/// the program has ended.
const SILENCE: Duration = Duration::from_secs(1);

/// Longest answer that is read: a line for each of a million tasks [bytes].
const ANSWER_MAX: u64 = 64 << 20;

/// Longest message of a program that is shown [characters].
const REASON_MAX: usize = 400;

/// Runs a program for at most `time_limit` and returns its output.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] that names the cause: not installed, no answer, no configuration,
/// no controller, or the program's own message.
pub(super) fn run_program(
    program: &str,
    arguments: &[String],
    time_limit: Duration,
) -> Result<String, Error> {
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
    // On threads: a program waits for ever where nothing reads its full pipe.
    let out = read_on_thread(child.stdout.take());
    let err = read_on_thread(child.stderr.take());
    let began = Instant::now();
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if began.elapsed() < time_limit => std::thread::sleep(EVERY),
            polled => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(failed(match polled {
                    Err(error) => format!("{program} cannot be watched: {error}"),
                    Ok(_) => format!(
                        "{program} did not answer in {} s; its controller may be down or the \
                         configuration wrong; try scontrol ping",
                        time_limit.as_secs()
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

fn read_on_thread(pipe: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
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

/// Returns the reason why a program refused, with the remedy where it is known.
fn reason(program: &str, err: &str) -> String {
    let message: String = err.split_whitespace().collect::<Vec<_>>().join(" ");
    let message: String = message.chars().take(REASON_MAX).collect();
    let remedies = [
        (
            "configuration source",
            "it has no configuration; set SLURM_CONF, or run this where the cluster takes jobs",
        ),
        (
            "contact slurm controller",
            "its controller is down; try again when scontrol ping says it is up",
        ),
    ];
    match remedies.iter().find(|(words, _)| message.contains(words)) {
        Some((_, remedy)) => format!("{program}: {remedy} ({message})"),
        None => format!("{program} refuses: {message}"),
    }
}

fn failed(reason: String) -> Error {
    Error::io("speak with the batch system", &reason)
}
