//! How far a study has come, on a terminal, and Ctrl-C, which ends it with what is done.

use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Set by Ctrl-C.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Makes the first Ctrl-C ask for an end and the second one enforce it.
pub(super) fn listen() {
    // Fails only if somebody else listens already; then Ctrl-C does what it does without us.
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}

/// Returns whether Ctrl-C was pressed.
pub(super) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// A line on a terminal's stderr that is written over.
pub(super) struct Progress {
    on_terminal: bool,
    state: Mutex<State>,
}

struct State {
    step: String,
    shown: Instant,
    written: bool,
}

/// Time between two lines.
const EVERY: Duration = Duration::from_millis(100);

impl Progress {
    pub(super) fn new() -> Self {
        Self {
            on_terminal: std::io::stderr().is_terminal(),
            state: Mutex::new(State {
                step: String::new(),
                shown: Instant::now(),
                written: false,
            }),
        }
    }

    /// Names what is being done now.
    pub(super) fn step(&self, name: &str) {
        if let Ok(mut state) = self.state.lock() {
            state.step = name.into();
        }
    }

    /// Takes in which part of the step is done; false asks for an end.
    pub(super) fn proceed(&self, part: Option<f64>) -> bool {
        if self.on_terminal
            && let Some(part) = part
            && let Ok(mut state) = self.state.try_lock()
            && state.shown.elapsed() >= EVERY
        {
            state.shown = Instant::now();
            state.written = true;
            let mut err = std::io::stderr().lock();
            let _ = write!(err, "\r\x1b[K{}: {:.0} %", state.step, 100.0 * part);
            let _ = err.flush();
        }
        !interrupted()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Ok(state) = self.state.lock()
            && state.written
        {
            let _ = write!(std::io::stderr().lock(), "\r\x1b[K");
        }
    }
}
