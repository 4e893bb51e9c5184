//! A line of progress on a terminal, and Ctrl-C, which ends a command.

use super::failure::{COULD_NOT, INTERRUPTED};
use super::output;
use latchgate_kernel::parallel::Control;
use latchgate_report::escape;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Set by Ctrl-C.
static STOPPED: AtomicBool = AtomicBool::new(false);

/// Set by SIGTERM: the command ends with exit code 4 instead of 130.
static TERMINATED: AtomicBool = AtomicBool::new(false);

/// Set once a command that keeps its results has seen the request to stop.
static KEEPING: AtomicBool = AtomicBool::new(false);

/// True while a line of progress is on the terminal.
static LINE_SHOWN: AtomicBool = AtomicBool::new(false);

/// Time that a command has to end by itself: Ctrl-C ends it within a second in any case.
const GRACE: Duration = Duration::from_millis(900);

/// Further time for keeping results; a second Ctrl-C cuts it short.
const GRACE_TO_KEEP: Duration = Duration::from_secs(10);

/// Run time before progress is shown.
const QUIET: Duration = Duration::from_secs(1);

/// Interval between two lines.
const EVERY: Duration = Duration::from_millis(100);

/// Message of a command that Ctrl-C ended.
pub(super) const INTERRUPTED_MESSAGE: &str = "latchgate: interrupted";

/// Makes the first Ctrl-C request the end of the command, which comes within a second; a second
/// Ctrl-C ends it at once.
pub(super) fn listen() {
    on_signal(SIGINT, request_end);
}

/// Calls `handler` for each such signal, on a thread. It fails only for signals that cannot be
/// caught, which then keep their usual effect.
#[cfg(unix)]
fn on_signal(signal: i32, handler: fn()) {
    if let Ok(mut signals) = signal_hook::iterator::Signals::new([signal]) {
        std::thread::spawn(move || signals.forever().for_each(|_| handler()));
    }
}

/// The same by polling, where a thread cannot wait for signals.
#[cfg(not(unix))]
fn on_signal(signal: i32, handler: fn()) {
    let received = std::sync::Arc::new(AtomicBool::new(false));
    if signal_hook::flag::register(signal, std::sync::Arc::clone(&received)).is_ok() {
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(EVERY);
                if received.swap(false, Ordering::Relaxed) {
                    handler();
                }
            }
        });
    }
}

fn request_end() {
    if STOPPED.swap(true, Ordering::Relaxed) {
        end();
    }
    std::thread::spawn(|| {
        std::thread::sleep(GRACE);
        if KEEPING.load(Ordering::Relaxed) {
            std::thread::sleep(GRACE_TO_KEEP);
        }
        end();
    });
}

/// Ends the command as Ctrl-C does, with exit code 4. A second call does not end it at once: a batch
/// system may signal a process and its group.
pub(super) fn terminate() {
    TERMINATED.store(true, Ordering::Relaxed);
    if !stopped() {
        request_end();
    }
}

/// Makes SIGTERM end the command, which keeps its results.
pub(super) fn listen_to_terminate() {
    KEEPING.store(true, Ordering::Relaxed);
    on_signal(SIGTERM, terminate);
}

/// True if the command must end with exit code 4.
pub(super) fn terminated() -> bool {
    TERMINATED.load(Ordering::Relaxed)
}

fn end() -> ! {
    wipe();
    output::talk(INTERRUPTED_MESSAGE);
    std::process::exit(i32::from(if terminated() {
        COULD_NOT
    } else {
        INTERRUPTED
    }));
}

/// True if the command must end.
pub(super) fn stopped() -> bool {
    STOPPED.load(Ordering::Relaxed)
}

/// Removes the line of progress from the terminal.
pub(super) fn wipe() {
    if LINE_SHOWN.swap(false, Ordering::Relaxed) {
        let mut err = std::io::stderr().lock();
        let _ = write!(err, "\r\x1b[K");
        let _ = err.flush();
    }
}

/// A line on a terminal's stderr: the step, the part that is done, and the time left.
pub(super) struct Progress {
    on_terminal: bool,
    /// True if the command keeps its results when it is stopped.
    keeps: bool,
    state: Mutex<State>,
}

struct State {
    step: String,
    began: Instant,
    shown: Instant,
}

impl Progress {
    /// Begins with the step of that name.
    pub(super) fn new(step: &str) -> Self {
        let now = Instant::now();
        Self {
            on_terminal: std::io::stderr().is_terminal(),
            keeps: false,
            state: Mutex::new(State {
                step: step.into(),
                began: now,
                shown: now,
            }),
        }
    }

    /// Marks a command that keeps its results when it is stopped.
    pub(super) fn that_keeps(mut self) -> Self {
        self.keeps = true;
        self
    }

    /// Does a step of the work on that many threads, and shows its progress.
    pub(super) fn watch<T>(
        &self,
        step: &str,
        threads: usize,
        work: impl FnOnce(&Control<'_>) -> T,
    ) -> T {
        if let Ok(mut state) = self.state.lock() {
            state.step = step.into();
            state.began = Instant::now();
        }
        work(&Control {
            threads,
            proceed: &|part| self.proceed(part),
        })
    }

    /// Shows the part of the step that is done; false if the work must stop.
    fn proceed(&self, part: Option<f64>) -> bool {
        if self.on_terminal
            && let Some(part) = part
            // Not `lock`: a thread that works need not wait for another one's line.
            && let Ok(mut state) = self.state.try_lock()
            && state.began.elapsed() >= QUIET
            && state.shown.elapsed() >= EVERY
        {
            state.shown = Instant::now();
            let mut err = std::io::stderr().lock();
            LINE_SHOWN.store(true, Ordering::Relaxed);
            let _ = write!(
                err,
                "\r\x1b[K{} {} {:.0} %{}",
                short_name(&state.step),
                bar(part),
                100.0 * part,
                time_left(state.began.elapsed(), part)
            );
            let _ = err.flush();
        }
        if stopped() && self.keeps {
            KEEPING.store(true, Ordering::Relaxed);
        }
        !stopped()
    }
}

/// Length of a bar [characters].
const BAR: usize = 20;

/// Longest name of a step, so that the line fits a terminal of 80 columns [characters].
const NAME_MAX: usize = 40;

/// Draws the part of a step that is done.
fn bar(part: f64) -> String {
    let done = (part.clamp(0.0, 1.0) * BAR as f64) as usize;
    format!("{}{}", "█".repeat(done), "░".repeat(BAR - done))
}

/// Returns the name of a step, cut at its beginning: the end of a path says more.
fn short_name(step: &str) -> String {
    let step = escape::terminal(step);
    let excess = step.chars().count().saturating_sub(NAME_MAX);
    match excess {
        0 => step.into_owned(),
        excess => format!("…{}", step.chars().skip(excess + 1).collect::<String>()),
    }
}

/// Returns the time left at the speed so far; nothing while too little is done for an estimate.
fn time_left(elapsed: Duration, part: f64) -> String {
    if part < 0.02 {
        return String::new();
    }
    let seconds = (elapsed.as_secs_f64() * (1.0 - part) / part).ceil();
    if seconds < 100.0 {
        format!(", {seconds:.0} s left")
    } else {
        format!(", {:.0} min left", (seconds / 60.0).ceil())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        wipe();
    }
}

#[cfg(test)]
mod tests {
    use super::{BAR, GRACE, NAME_MAX, bar, short_name};
    use std::time::Duration;

    /// Ctrl-C ends a command within a second.
    #[test]
    fn verif_the_grace_is_below_a_second() {
        assert!(GRACE < Duration::from_secs(1));
    }

    #[test]
    fn verif_a_line_of_progress_fits_and_tells_the_part() {
        for (part, full) in [(-1.0, 0), (0.0, 0), (0.5, 10), (1.0, 20), (7.0, 20)] {
            let bar = bar(part);
            assert_eq!(bar.matches('█').count(), full);
            assert_eq!(bar.chars().count(), BAR);
        }
        assert_eq!(short_name("replay a.csv"), "replay a.csv");
        let long = short_name(&format!("replay {}/the-end.csv", "long/".repeat(40)));
        assert_eq!(long.chars().count(), NAME_MAX);
        assert!(
            long.starts_with('…') && long.ends_with("/the-end.csv"),
            "{long}"
        );
    }
}
