//! The interface of a study to the command line: its run, its session, its answer.

use crate::cli::failure::Failure;
use crate::cli::progress::Progress;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_recording::error::Error;
use latchgate_study::Headline;
use latchgate_study::files::StudyTable;
use latchgate_study::work_precision::Truth;
use serde::Serialize;
use serde_json::{Value, json};
use std::time::Instant;

/// A study as the command line sees it: options that can be run.
pub(super) trait Analysis {
    /// Runs it on `design`.
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure>;
}

/// Clock, threads and progress of a study.
pub(super) struct Session {
    started: Instant,
    progress: Progress,
    threads: usize,
}

impl Session {
    pub(super) fn new(name: &str, threads: usize) -> Self {
        Self {
            started: Instant::now(),
            progress: Progress::new(name).that_keeps(),
            threads,
        }
    }

    /// Returns the seconds since the study began.
    pub(super) fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Does a step of the work by all threads, and shows its progress on a terminal.
    pub(super) fn watch<T>(
        &self,
        step: &str,
        work: impl FnOnce(&Control<'_>) -> Result<T, Error>,
    ) -> Result<T, Failure> {
        self.progress
            .watch(step, self.threads, work)
            .map_err(Failure::Data)
    }
}

/// The answer of a study; name, version and time are added to it in one place.
pub(super) struct StudyAnswer {
    /// The study's options, as its JSON states them.
    pub(super) parameters: Value,
    pub(super) headlines: Vec<Headline>,
    /// Truth of each case, of a study that has cases.
    pub(super) cases: Vec<Truth>,
    /// Further results of the JSON.
    pub(super) results: Option<Value>,
    pub(super) tables: Vec<StudyTable>,
    pub(super) svg: String,
    /// True unless the work was stopped.
    pub(super) complete: bool,
}

impl StudyAnswer {
    /// Returns an empty answer with the parameters `options`.
    pub(super) fn to(options: &impl Serialize) -> Self {
        Self {
            parameters: json!(options),
            headlines: Vec::new(),
            cases: Vec::new(),
            results: None,
            tables: Vec::new(),
            svg: String::new(),
            complete: true,
        }
    }

    /// Returns the answer of a study that is run once for each of `stops`, whose options are the
    /// same but for the stop.
    pub(super) fn of_stops(options: &impl Serialize, stops: &[StopModel]) -> Self {
        let mut answer = Self::to(options);
        answer.parameters["model"] = json!(stops);
        answer
    }

    /// Adds the results of `stop`, one of `stops`: rows, headline figures and further results, which
    /// are complete or not.
    pub(super) fn add<T: Serialize + Default>(
        &mut self,
        stop: StopModel,
        stops: &[StopModel],
        rows: &[T],
        headlines: Vec<Headline>,
        complete: bool,
        mut results: Value,
    ) -> Result<(), Failure> {
        let table = StudyTable::of_stops(stops, stop, rows).map_err(Failure::Data)?;
        self.tables.push(table);
        self.headlines.extend(headlines);
        self.complete &= complete;
        results["model"] = json!(stop);
        results["complete"] = json!(complete);
        if let Value::Array(list) = self.results.get_or_insert_with(|| json!([])) {
            list.push(results);
        }
        Ok(())
    }
}
