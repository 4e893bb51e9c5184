//! The worker process of a share, and the cause of its end.
//!
//! A recording may end the process that judges it: an abort, too little memory, a time limit. So a
//! share is judged by a worker, which its parent watches and begins again. The store lists the
//! recordings that were begun and never ended. A pipe binds the two: a worker ends with its parent.

use crate::cli::failure::{COULD_NOT, Failure};
use crate::cli::{output, progress};
use crate::gate::{self, Share};
use latchgate_recording::error::Error;
use std::ffi::OsString;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Interval of polling the worker.
const EVERY: Duration = Duration::from_millis(20);

/// Time that the worker has to end on request: less than the 15 s between SIGTERM and SIGKILL that
/// docs/scale.md asks of batch systems, so that the parent can still report it.
const GRACE: Duration = Duration::from_secs(9);

/// Number of ends without any progress in the store, after which no worker is begun again.
const IDLE_ENDS_MAX: u32 = 3;

/// Ends this worker in good order when its parent is gone: its standard input ends with the parent.
pub(super) fn end_with_parent() {
    std::thread::spawn(|| {
        let mut buffer = [0; 64];
        let mut pipe = std::io::stdin().lock();
        while pipe.read(&mut buffer).is_ok_and(|read| read > 0) {}
        progress::terminate();
    });
}

/// Judges a share in a worker, which is begun again when a recording ends it; returns its exit code.
pub(super) fn watch(store: &Path, share: Share, threads: usize) -> Result<u8, Failure> {
    let (mut threads, mut idle_ends) = (threads, 0);
    loop {
        let kept_bytes = || gate::share_bytes(store, share).unwrap_or(0);
        let before = kept_bytes();
        let mut worker = begin(threads).map_err(Failure::Data)?;
        let (status, was_killed) =
            wait(&mut worker).map_err(|error| Failure::Data(unwatched(&error)))?;
        let cause = match status.code() {
            Some(code) if code != PANIC => return Ok(u8::try_from(code).unwrap_or(COULD_NOT)),
            Some(_) => "a panic".to_string(),
            None if was_killed => "a time limit: it did not end on request".to_string(),
            None => signal(status),
        };
        output::talk(&format!(
            "latchgate: share {share}: its process was ended by {cause}"
        ));
        idle_ends += u32::from(kept_bytes() == before);
        if was_killed || idle_ends >= IDLE_ENDS_MAX {
            return Ok(COULD_NOT);
        }
        // With one thread only one recording is begun at a time, so the store shows which ends it.
        threads = 1;
    }
}

/// Exit code of a process that panicked.
const PANIC: i32 = 101;

fn begin(threads: usize) -> Result<Child, Error> {
    std::env::current_exe()
        .and_then(|program| {
            Command::new(program)
                .args(worker_words(std::env::args_os().skip(1), threads))
                .stdin(Stdio::piped())
                .spawn()
        })
        .map_err(|error| unwatched(&error))
}

/// Returns the arguments of a worker. `--worker` goes before any `--`: behind it, it would be no
/// option, and the worker would watch a worker in turn.
fn worker_words(words: impl Iterator<Item = OsString>, threads: usize) -> Vec<OsString> {
    let mut words: Vec<OsString> = words.collect();
    let end = words.iter().position(|word| word == "--");
    let index = end.unwrap_or(words.len());
    words.splice(
        index..index,
        ["--worker".into(), threads.to_string().into()],
    );
    words
}

/// Waits for the worker; returns its status, and true if it was killed since it did not end on
/// request.
fn wait(worker: &mut Child) -> std::io::Result<(ExitStatus, bool)> {
    let mut pipe = worker.stdin.take();
    let mut requested: Option<Instant> = None;
    loop {
        if let Some(status) = worker.try_wait()? {
            let was_killed = requested.is_some_and(|requested| requested.elapsed() >= GRACE);
            return Ok((status, was_killed));
        }
        if progress::stopped() {
            // The end of its input is the request.
            drop(pipe.take());
            if requested.get_or_insert_with(Instant::now).elapsed() >= GRACE {
                worker.kill()?;
            }
        }
        std::thread::sleep(EVERY);
    }
}

fn unwatched(error: &std::io::Error) -> Error {
    Error::io("watch the process of the share", error)
}

/// Names the signal that ended a process.
#[cfg(unix)]
fn signal(status: ExitStatus) -> String {
    use signal_hook::low_level::signal_name;
    use std::os::unix::process::ExitStatusExt;
    let number = status.signal().unwrap_or_default();
    format!(
        "signal {number} ({})",
        signal_name(number).unwrap_or("unknown")
    )
}

/// Names the exit status, on systems without signals.
#[cfg(not(unix))]
fn signal(status: ExitStatus) -> String {
    status.to_string()
}
