//! A replay in one breath: [`replay`] begins it, [`Replay::judge`] answers.

use crate::pipeline::{
    self, CardPolarity, Control, Design, Error, Extras, FilterChoice, Limits, Outcome, Request,
    units::AccelerationUnit,
};
use std::path::{Path, PathBuf};

/// A question that is put together step by step; each step fills a field of its [`Request`].
#[derive(Debug, Clone)]
#[must_use = "nothing is read before `judge`"]
pub struct Replay {
    recording: PathBuf,
    request: Request,
    design: Design,
    threads: usize,
}

/// Begins a replay of a recording: a file or folder, or a pulse by its word.
///
/// # Examples
///
/// ```
/// use latchgate::pipeline::{Answer, CardPolarity::Negative, Design};
///
/// let outcome = latchgate::replay("signals/burst.csv")
///     .opens_when(Negative)
///     .design(Design::reference())
///     .judge()?;
/// assert_eq!(outcome.document.verdict, Answer::Fail);
/// assert!(outcome.to_string().starts_with("✗ FAIL"));
/// # Ok::<(), latchgate::pipeline::Error>(())
/// ```
pub fn replay(recording: impl AsRef<Path>) -> Replay {
    let threads = std::thread::available_parallelism();
    Replay {
        recording: recording.as_ref().to_path_buf(),
        request: Request::default(),
        design: Design::reference(),
        threads: threads.map_or(1, std::num::NonZero::get),
    }
}

impl Replay {
    /// Names the channel, as [`Request::channel`] does.
    pub fn channel(mut self, name: impl Into<String>) -> Self {
        self.request.channel = Some(name.into());
        self
    }

    /// States the unit of acceleration.
    pub fn unit(mut self, unit: AccelerationUnit) -> Self {
        self.request.unit = Some(unit);
        self
    }

    /// States the sign of the recorded acceleration that opens the lever.
    pub fn opens_when(mut self, sign: CardPolarity) -> Self {
        self.request.opens_when = Some(sign);
        self
    }

    /// Chooses the channel frequency class.
    pub fn filter(mut self, filter: FilterChoice) -> Self {
        self.request.filter = filter;
        self
    }

    /// States the largest number of varied levers; 0 for the nominal lever alone.
    pub fn members(mut self, members: u32) -> Self {
        self.request.members = members;
        self
    }

    /// Asks this instead of all that was stated before, for settings that have no step here.
    pub fn request(mut self, request: Request) -> Self {
        self.request = request;
        self
    }

    /// Judges this lever; the paper's unless stated.
    pub fn design(mut self, design: Design) -> Self {
        self.design = design;
        self
    }

    /// Works on so many threads; on all cores unless stated. The numbers do not depend on it.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads.max(1);
        self
    }

    /// Reads the recording, replays the lever and decides, with all that the terminal and a report show:
    /// the answer after other filters, the preload from which on it passes, and the curves. Whoever wants
    /// the verdict alone, or to stop it, calls [`pipeline::judge`].
    ///
    /// # Errors
    ///
    /// Any [`ErrorKind`](pipeline::ErrorKind) that leaves nothing to judge.
    pub fn judge(&self) -> Result<Outcome, Error> {
        let extras = Extras {
            filter_table: true,
            preload_answer: true,
            evidence: true,
        };
        let control = Control::unwatched(self.threads);
        let outcome = pipeline::judge(
            &pipeline::pulse::source_at(&self.recording)?,
            &self.request,
            &self.design,
            extras,
            &Limits::default(),
            &control,
        );
        match outcome.refusal {
            Some(error) => Err(error),
            None => Ok(outcome),
        }
    }
}
