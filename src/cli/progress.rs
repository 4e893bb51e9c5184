//! What a command is doing and how far it has come, on a terminal, and Ctrl-C, which ends it.

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

/// Set where the command is to end with the exit code of something that could not be done.
static TERMINATED: AtomicBool = AtomicBool::new(false);

/// Set once a command that writes down what was done has heard the wish to stop.
static KEEPING: AtomicBool = AtomicBool::new(false);

/// Whether a line of progress stands on the terminal.
static LINE_STANDS: AtomicBool = AtomicBool::new(false);

/// Time that a command has to end by itself before it is ended.
const GRACE: Duration = Duration::from_millis(900);

/// Time beyond it for writing down what was done; a second Ctrl-C ends that at once.
const GRACE_TO_KEEP: Duration = Duration::from_secs(10);

/// Time that a command takes before its progress is shown.
const QUIET: Duration = Duration::from_secs(1);

/// Time between two lines.
const EVERY: Duration = Duration::from_millis(100);

/// What is said of a command that Ctrl-C ended.
pub(super) const WORD: &str = "latchgate: interrupted";

/// Makes the first Ctrl-C ask the command to end, and see to it that it does within a second; a
/// second one ends it at once.
pub(super) fn listen() {
    on_signal(SIGINT, ask_to_end);
}

/// Does `then` each time the signal comes, on a thread of its own. Nothing but signals that nobody may
/// catch fail; then the signal does what it does without us.
#[cfg(unix)]
fn on_signal(signal: i32, then: fn()) {
    if let Ok(mut signals) = signal_hook::iterator::Signals::new([signal]) {
        std::thread::spawn(move || signals.forever().for_each(|_| then()));
    }
}

/// The same by looking from time to time, where signals cannot be waited for.
#[cfg(not(unix))]
fn on_signal(signal: i32, then: fn()) {
    let heard = std::sync::Arc::new(AtomicBool::new(false));
    if signal_hook::flag::register(signal, std::sync::Arc::clone(&heard)).is_ok() {
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(EVERY);
                if heard.swap(false, Ordering::Relaxed) {
                    then();
                }
            }
        });
    }
}

fn ask_to_end() {
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

/// Ends the command as Ctrl-C does, but as something that could not be done. A second wish changes
/// nothing: whoever ends a batch of processes may say so to each of them and to all.
pub(super) fn terminate() {
    TERMINATED.store(true, Ordering::Relaxed);
    if !stopped() {
        ask_to_end();
    }
}

/// Makes SIGTERM end the command with what it has done kept.
pub(super) fn listen_to_terminate() {
    KEEPING.store(true, Ordering::Relaxed);
    on_signal(SIGTERM, terminate);
}

/// Returns whether the command is to end as something that could not be done.
pub(super) fn terminated() -> bool {
    TERMINATED.load(Ordering::Relaxed)
}

fn end() -> ! {
    wipe();
    output::talk(WORD);
    std::process::exit(i32::from(if terminated() {
        COULD_NOT
    } else {
        INTERRUPTED
    }));
}

/// Returns whether the command is to end.
pub(super) fn stopped() -> bool {
    STOPPED.load(Ordering::Relaxed)
}

/// Takes the line of progress off the terminal.
pub(super) fn wipe() {
    if LINE_STANDS.swap(false, Ordering::Relaxed) {
        let mut err = std::io::stderr().lock();
        let _ = write!(err, "\r\x1b[K");
        let _ = err.flush();
    }
}

/// A line on a terminal's stderr that is written over: what is done, how far, how long yet.
pub(super) struct Progress {
    on_terminal: bool,
    /// Whether the command writes down what was done when it is stopped.
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

    /// Says that the command writes down what was done when it is stopped.
    pub(super) fn that_keeps(mut self) -> Self {
        self.keeps = true;
        self
    }

    /// Does a step of the work on so many threads, watched.
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

    /// Takes in which part of the step is done; false asks for an end.
    fn proceed(&self, part: Option<f64>) -> bool {
        if self.on_terminal
            && let Some(part) = part
            && let Ok(mut state) = self.state.try_lock()
            && state.began.elapsed() >= QUIET
            && state.shown.elapsed() >= EVERY
        {
            state.shown = Instant::now();
            let mut err = std::io::stderr().lock();
            LINE_STANDS.store(true, Ordering::Relaxed);
            let _ = write!(
                err,
                "\r\x1b[K{} {} {:.0} %{}",
                named(&state.step),
                bar(part),
                100.0 * part,
                left(state.began.elapsed(), part)
            );
            let _ = err.flush();
        }
        if stopped() && self.keeps {
            KEEPING.store(true, Ordering::Relaxed);
        }
        !stopped()
    }
}

/// Characters of a bar.
const BAR: usize = 20;

/// Characters of a step's name, so that the line fits a terminal of 80 columns.
const NAMED: usize = 40;

/// Draws how much of a step is done.
fn bar(part: f64) -> String {
    let done = (part.clamp(0.0, 1.0) * BAR as f64) as usize;
    format!("{}{}", "█".repeat(done), "░".repeat(BAR - done))
}

/// Returns the name of a step, cut in front where it is long: the end of a path tells more.
fn named(step: &str) -> String {
    let step = escape::terminal(step);
    let long = step.chars().count().saturating_sub(NAMED);
    match long {
        0 => step.into_owned(),
        long => format!("…{}", step.chars().skip(long + 1).collect::<String>()),
    }
}

/// Says how long the step takes yet, if it goes on as it did, once enough of it is done to say so.
fn left(elapsed: Duration, part: f64) -> String {
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
    use super::{BAR, GRACE, NAMED, bar, named};
    use std::time::Duration;

    /// A command that Ctrl-C asks to end is gone within a second.
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
        assert_eq!(named("replay a.csv"), "replay a.csv");
        let long = named(&format!("replay {}/the-end.csv", "long/".repeat(40)));
        assert_eq!(long.chars().count(), NAMED);
        assert!(
            long.starts_with('…') && long.ends_with("/the-end.csv"),
            "{long}"
        );
    }
}
