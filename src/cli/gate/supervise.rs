//! The process of a share, and what ended it.
//!
//! A recording may end the process that judges it: an abort, too little memory, a limit on time. So
//! a share is judged by a process that another one watches, and begins again. The store tells which
//! recordings were begun and never ended. The two are bound by a pipe: where the watch ends, the other
//! one does, too.

use crate::cli::failure::{COULD_NOT, Failure};
use crate::cli::{output, progress};
use crate::gate::{self, Share};
use latchgate_recording::error::Error;
use std::ffi::OsString;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Time between two looks at the process.
const EVERY: Duration = Duration::from_millis(20);

/// Time that the process has to end by itself once it is asked to: less than this one has.
const GRACE: Duration = Duration::from_secs(9);

/// Ends before anything was begun after which nothing is begun again.
const IDLE_ENDS_MAX: u32 = 3;

/// Ends this process in good order where the one that watches it is gone.
pub(super) fn end_with_the_watch() {
    std::thread::spawn(|| {
        let mut nothing = [0; 64];
        let mut pipe = std::io::stdin().lock();
        while pipe.read(&mut nothing).is_ok_and(|read| read > 0) {}
        progress::terminate();
    });
}

/// Judges a share in a process of its own, which is begun again when a recording ends it; returns
/// its exit code.
pub(super) fn watch(store: &Path, share: Share, threads: usize) -> Result<u8, Failure> {
    let (mut threads, mut idle_ends) = (threads, 0);
    loop {
        let kept = || gate::share_bytes(store, share).unwrap_or(0);
        let before = kept();
        let mut worker = begin(threads).map_err(Failure::Data)?;
        let (status, asked) =
            wait(&mut worker).map_err(|error| Failure::Data(unwatched(&error)))?;
        let how = match status.code() {
            Some(code) if code != PANIC => return Ok(u8::try_from(code).unwrap_or(COULD_NOT)),
            Some(_) => "a panic".to_string(),
            None if asked => "a time limit: it did not end on request".to_string(),
            None => signal(status),
        };
        output::talk(&format!(
            "latchgate: share {share}: its process was ended by {how}"
        ));
        idle_ends += u32::from(kept() == before);
        if asked || idle_ends >= IDLE_ENDS_MAX {
            return Ok(COULD_NOT);
        }
        // One at a time, so that it shows which recording it is.
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

/// Returns the words of a process that does not watch but judge. Behind a `--` its number of threads would
/// be no option, and it would watch another one in its turn.
fn worker_words(words: impl Iterator<Item = OsString>, threads: usize) -> Vec<OsString> {
    let mut words: Vec<OsString> = words.collect();
    let end = words.iter().position(|word| word == "--");
    let at = end.unwrap_or(words.len());
    words.splice(at..at, ["--worker".into(), threads.to_string().into()]);
    words
}

/// Waits for the process; returns how it ended, and whether it was ended because it did not when it
/// was asked to.
fn wait(worker: &mut Child) -> std::io::Result<(ExitStatus, bool)> {
    let mut pipe = worker.stdin.take();
    let mut asked_at: Option<Instant> = None;
    loop {
        if let Some(status) = worker.try_wait()? {
            return Ok((status, asked_at.is_some_and(|at| at.elapsed() >= GRACE)));
        }
        if progress::stopped() {
            drop(pipe.take());
            if asked_at.get_or_insert_with(Instant::now).elapsed() >= GRACE {
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

/// Where there are no signals none is named.
#[cfg(not(unix))]
fn signal(status: ExitStatus) -> String {
    status.to_string()
}
