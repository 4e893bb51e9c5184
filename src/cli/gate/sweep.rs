//! The shares of a gate for a cluster: judging, submitting, watching and collecting.
//!
//! latchgate schedules nothing itself. It divides a gate into shares, keeps decisions and lists what
//! is missing. The batch system runs, restarts and accounts.

use super::slurm::{Slurm, SlurmJobs, ranges};
use super::{GateArguments, supervise};
use crate::cli::failure::{COULD_NOT, Failure};
use crate::cli::options::Common;
use crate::cli::output;
use crate::cli::progress::{self, Progress};
use crate::cli::values::OutputFormat;
use crate::gate::text::counted;
use crate::gate::{
    self, Collection, GateSummary, Plan, Share, ShareOutcome, ShareTask, Submission,
    SummaryOptions, SweepStatus,
};
use clap::{Args, ValueEnum};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::parallel::Control;
use latchgate_recording::Limits;
use latchgate_recording::error::{Error, ErrorKind, Place};
use latchgate_recording::source::sha256;
use latchgate_report::escape;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Number of times that the collecting job submits missing shares again.
const RESUBMITS: u32 = 3;

/// Waiting time for files of finished shares, since a shared file system may lag [s].
const LAG_S: u64 = 60;

/// Time limit for a program of the batch system [s].
const ANSWER_S: u64 = 30;

/// Time for which a collecting job tries to reach the batch system.
const PATIENCE: Duration = Duration::from_secs(120);

/// Interval of polling a store or a queue.
const EVERY: Duration = Duration::from_secs(1);

/// Number of lost collecting jobs that are replaced.
const COLLECTING_MAX: u32 = 3;

/// Number of pairs that are judged for an estimate.
const TRIED: usize = 5;

/// Mean size of a pair in the store, about; a row takes 400 at most [bytes].
const BYTES_A_PAIR: f64 = 300.0;

/// Shortest task that is worth its start, which takes about a second of the scheduler [min].
const MINUTES_MIN: f64 = 2.0;

/// Number of recordings that are named in a text.
const NAMED: usize = 20;

/// Options of `gate` for shares.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Shares of a gate, for a cluster")]
pub struct SweepArguments {
    /// Judge share I of N into the store, without a report; exit code 0 when complete
    #[arg(long, value_name = "I/N", value_parser = Share::parse, group = "sweep", conflicts_with = "no_store")]
    pub part: Option<Share>,
    /// Submit the shares to an engine, with a job that collects them
    #[arg(
        long,
        value_enum,
        value_name = "ENGINE",
        group = "sweep",
        requires = "parts",
        conflicts_with = "no_store"
    )]
    pub submit: Option<Engine>,
    /// Number of shares
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000), requires = "submit")]
    pub parts: Option<u32>,
    /// Print the script of a share, or the manifest; submit nothing
    #[arg(long, requires = "submit")]
    pub print: bool,
    /// Wait for the collecting job, and exit with its code
    #[arg(long, requires = "submit", conflicts_with = "print")]
    pub wait: bool,
    /// Show what is done and missing, and what the engine is doing
    #[arg(long, group = "sweep", conflicts_with = "no_store")]
    pub status: bool,
    /// Submit the missing shares again
    #[arg(long, group = "sweep", conflicts_with = "no_store")]
    pub resubmit: bool,
    /// Collect the shares into one summary; a missing pair is an error
    #[arg(long, group = "sweep", conflicts_with = "no_store")]
    pub collect: bool,
    /// The submission that the share is of.
    #[arg(long, hide = true)]
    pub submission: Option<String>,
    /// Threads of a process that another one watches.
    #[arg(long, hide = true, requires = "part")]
    pub worker: Option<usize>,
    /// Judge a few pairs and print the seconds of one.
    #[arg(long, hide = true, group = "sweep")]
    pub estimate: bool,
    /// Submit without trying what a pair takes, since recordings are not to be read here.
    #[arg(long, hide = true, requires = "submit")]
    pub untried: bool,
    /// Times that this collecting job may still submit what is missing.
    #[arg(long, hide = true, requires = "collect")]
    pub resubmits: Option<u32>,
    /// What names the answer of this collecting job.
    #[arg(long, hide = true, requires = "collect")]
    pub answer: Option<u64>,
    /// SHA-256 of the gate file as it was submitted.
    #[arg(long, hide = true, requires = "collect")]
    pub gate_sha256: Option<String>,
    /// Seconds for which programs of the engine and late files are waited for.
    #[arg(long, hide = true)]
    pub patience: Option<u64>,
    /// Options passed to the engine, for example -- --partition=short --time=04:00:00
    #[arg(
        last = true,
        value_name = "OPTIONS",
        requires = "sweep",
        conflicts_with = "part"
    )]
    pub engine_options: Vec<String>,
}

/// An engine that runs shares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    /// Job arrays of Slurm.
    Slurm,
}

impl SweepArguments {
    /// Returns the waiting time that was set, or the usual one.
    fn patience(&self, usual_s: u64) -> Duration {
        Duration::from_secs(self.patience.unwrap_or(usual_s))
    }

    /// True if an option of shares was given.
    pub(super) fn is_requested(&self) -> bool {
        self.part.is_some()
            || self.submit.is_some()
            || self.status
            || self.resubmit
            || self.collect
            || self.estimate
    }
}

/// Result of collecting.
pub(super) enum Collected {
    /// All pairs are in the store.
    Summary(Box<GateSummary>),
    /// Some pairs are missing and were submitted again, with another collecting job.
    SubmittedAgain,
    /// Some pairs are missing.
    Missing,
}

/// A command about the shares of a gate.
pub(super) struct SweepCommand<'a> {
    pub(super) gate: &'a Path,
    pub(super) plan: &'a Plan,
    pub(super) store: &'a Path,
    pub(super) limits: &'a Limits,
    pub(super) arguments: &'a GateArguments,
    pub(super) common: &'a Common,
}

impl SweepCommand<'_> {
    /// Runs the command, except for collecting; returns the exit code.
    pub(super) fn run(&self) -> Result<u8, Failure> {
        let options = &self.arguments.sweep;
        match (options.part, options.submit) {
            (Some(share), _) => self.part(share),
            (None, Some(Engine::Slurm)) => self.submit(options.parts.unwrap_or(1)),
            (None, None) if options.resubmit => self.resubmit(),
            (None, None) if options.estimate => self.print_trial_time(),
            (None, None) => self.status(),
        }
    }

    /// Judges a share in a child process that this one watches.
    fn part(&self, share: Share) -> Result<u8, Failure> {
        progress::listen_to_terminate();
        match self.arguments.sweep.worker {
            Some(threads) => {
                supervise::end_with_parent();
                self.judge(share, threads)
            }
            None => supervise::watch(self.store, share, self.common.thread_count()),
        }
    }

    fn judge(&self, share: Share, threads: usize) -> Result<u8, Failure> {
        let began = Instant::now();
        let submission = match &self.arguments.sweep.submission {
            Some(id) => {
                Some(Submission::read_as(self.store, &self.plan.gate, id).map_err(Failure::Data)?)
            }
            None => None,
        };
        let task = ShareTask {
            share,
            folder: self.store,
            limits: self.limits,
            submission: submission.as_ref(),
            clock: &|| began.elapsed(),
        };
        let progress = Progress::new("share").that_keeps();
        let judged = progress.watch("share", threads, |control| {
            gate::judge_share(self.plan, &task, control)
        });
        drop(progress);
        let judged = judged.map_err(|error| match error.kind() {
            // SIGTERM comes from the batch system, not from a person: an incomplete share (exit 4).
            ErrorKind::Kernel(KernelError::Stopped) if progress::terminated() => {
                Failure::Data(error)
            }
            _ => Failure::of_data(error),
        })?;
        Ok(report_share(share, &judged))
    }

    /// Submits the shares to Slurm, or prints their script.
    fn submit(&self, shares: u32) -> Result<u8, Failure> {
        if !self.arguments.sweep.untried {
            self.estimate(shares)?;
        }
        let progress = Progress::new("reading");
        let submission = progress.watch("reading", self.common.thread_count(), |control| {
            Submission::of(self.plan, shares, self.limits, control)
        });
        drop(progress);
        let submission = submission.map_err(Failure::of_data)?;
        let slurm = self.slurm(&submission, RESUBMITS);
        if self.arguments.sweep.print {
            return output::document(&slurm.share_script())
                .map(|()| 0)
                .map_err(Failure::Data);
        }
        submission
            .keep(self.store, &self.plan.gate)
            .map_err(Failure::Data)?;
        let numbers: Vec<u32> = (1..=shares).collect();
        let options = &self.arguments.sweep.engine_options;
        let jobs = slurm
            .submit(&numbers, Vec::new(), RESUBMITS, options)
            .map_err(Failure::Data)?;
        output::talk(&format!(
            "latchgate: {} submitted; job {} collects",
            counted(shares as usize, "share"),
            jobs.collecting
        ));
        if self.arguments.sweep.wait {
            return self.wait(&slurm, jobs);
        }
        Ok(0)
    }

    /// Waits for the last collecting job of the submission `jobs`; returns its exit code. Tasks that
    /// will never run are cancelled meanwhile, since the collecting job waits for them.
    fn wait(&self, slurm: &Slurm<'_>, mut jobs: SlurmJobs) -> Result<u8, Failure> {
        // Polls in a row without a collecting job, and collecting jobs that were begun anew.
        let (mut absent, mut begun) = (0, 0);
        let mut error_shown = false;
        let progress = Progress::new("waiting");
        progress.watch("waiting", 1, |control| {
            loop {
                // The collecting job may have submitted another one, which gives the same answer. A
                // submission by another command has a different answer.
                let last = slurm.jobs().map_err(Failure::Data)?;
                if let Some(last) = last.filter(|last| last.answer == jobs.answer) {
                    jobs = last;
                }
                if let Some(exit_code) = slurm.answer(&jobs).map_err(Failure::Data)? {
                    return Ok(exit_code);
                }
                match slurm.queue(&jobs) {
                    Ok(queue) => {
                        let _ = slurm.cancel(&queue.stuck);
                        absent = if queue.is_collecting { 0 } else { absent + 1 };
                        error_shown = false;
                    }
                    // A controller that is down usually comes back.
                    Err(error) if !error_shown => {
                        output::talk(&format!("latchgate: {error}; waiting for it"));
                        error_shown = true;
                    }
                    Err(_) => {}
                }
                // It may leave the queue before its answer is visible here.
                if absent >= 5 {
                    if begun == COLLECTING_MAX {
                        let why = "the collecting job ended without an answer; see its output";
                        output::talk(&format!("latchgate: {why} in {}", slurm.folder.display()));
                        return Ok(COULD_NOT);
                    }
                    // After a failure the loop tries again.
                    let _ = slurm.collect(&mut jobs);
                    (absent, begun) = (0, begun + 1);
                }
                for _ in 0..10 {
                    control
                        .check()
                        .map_err(|error| Failure::of_data(error.into()))?;
                    std::thread::sleep(EVERY / 10);
                }
            }
        })
    }

    /// Shows the estimated cost of all pairs. A few are judged for it, in a child process, since a
    /// recording may end the process that judges it.
    fn estimate(&self, shares: u32) -> Result<(), Failure> {
        let words = self.command_line("", None);
        let trial = std::env::current_exe().and_then(|program| {
            Command::new(program)
                .args(&words[1..])
                .arg("--estimate")
                .stdin(Stdio::null())
                .stderr(Stdio::null())
                .output()
        });
        if progress::stopped() {
            return Err(Failure::Interrupted);
        }
        let text = trial.map_or_else(|_| Vec::new(), |trial| trial.stdout);
        let Ok(seconds) = String::from_utf8_lossy(&text).trim().parse::<f64>() else {
            output::talk(
                "latchgate: the time of a pair is unknown: one of five trial pairs ended its \
                 process",
            );
            return Ok(());
        };
        let pairs = self.plan.recordings.len() * self.plan.designs.len();
        let total_s = seconds * pairs as f64;
        let minutes = total_s / 60.0 / f64::from(shares);
        output::talk(&format!(
            "latchgate: {}: about {:.2} processor hours, {:.1} MB in the store, {minutes:.1} \
             minutes for each of {}",
            counted(pairs, "pair"),
            total_s / 3600.0,
            pairs as f64 * BYTES_A_PAIR / 1e6,
            counted(shares as usize, "share")
        ));
        if minutes < MINUTES_MIN {
            output::talk(&format!(
                "latchgate: a task costs about a second of scheduling, and sites expect 10 minutes \
                 or more; with {} a task takes about {MINUTES_MIN} minutes",
                counted(
                    (total_s / 60.0 / MINUTES_MIN).ceil().max(1.0) as usize,
                    "share"
                )
            ));
        }
        Ok(())
    }

    /// Judges a few pairs spread over all, and prints the seconds of one.
    fn print_trial_time(&self) -> Result<u8, Failure> {
        let (recordings, designs) = (&self.plan.recordings, &self.plan.designs);
        let (began, control) = (Instant::now(), Control::default());
        for number in 0..TRIED {
            let recording = &recordings[number * (recordings.len() - 1) / (TRIED - 1)];
            let design = &designs[number * (designs.len() - 1) / (TRIED - 1)];
            gate::judge_pair(recording, design, self.limits, &control).map_err(Failure::Data)?;
        }
        let seconds = began.elapsed().as_secs_f64() / TRIED as f64;
        output::document(&format!("{seconds}\n"))
            .map(|()| 0)
            .map_err(Failure::Data)
    }

    /// Returns the command line of a share up to its number.
    fn command_line(&self, program: &str, submission: Option<&str>) -> Vec<String> {
        let mut words = vec![
            program.to_string(),
            "gate".into(),
            self.gate.display().to_string(),
            "--store".into(),
            self.store.display().to_string(),
        ];
        let mut add = |option: &str, value: String| words.extend([option.to_string(), value]);
        if let Some(submission) = submission {
            add("--submission", submission.into());
        }
        for (name, value) in self.limits.changed() {
            add("--limit", format!("{name}={value}"));
        }
        words.extend((0..self.common.verbose).map(|_| "-v".to_string()));
        words
    }

    fn slurm(&self, submission: &Submission, resubmits: u32) -> Slurm<'_> {
        let id = submission.id();
        let program = std::env::current_exe().unwrap_or_else(|_| "latchgate".into());
        let share_command = self.command_line(&program.display().to_string(), Some(&id));
        let arguments = self.arguments;
        let mut collect_command = share_command.clone();
        collect_command.extend([
            "--collect".into(),
            "--resubmits".into(),
            resubmits.to_string(),
            "--gate-sha256".into(),
            arguments
                .sweep
                .gate_sha256
                .clone()
                .unwrap_or_else(|| self.gate_sha256()),
        ]);
        for (option, path) in [
            ("--out", &arguments.out),
            ("--baseline", &arguments.baseline),
        ] {
            if let Some(path) = path {
                collect_command.extend([option.into(), path.display().to_string()]);
            }
        }
        if let Some(date) = &arguments.date {
            collect_command.extend(["--date".into(), date.clone()]);
        }
        let reports = arguments.reports.to_possible_value();
        let reports = reports.map_or_else(String::new, |value| value.get_name().into());
        collect_command.extend(["--reports".into(), reports]);
        for (option, is_set) in [
            ("--allow-removed", arguments.allow_removed),
            ("--no-worse", arguments.no_worse),
        ] {
            collect_command.extend(is_set.then(|| option.to_string()));
        }
        Slurm {
            folder: gate::collect::engine_folder(self.store),
            gate: &self.plan.gate,
            submission: id,
            shares: submission.shares,
            share_command,
            collect_command,
            answer: arguments.sweep.answer,
            time_limit: arguments.sweep.patience(ANSWER_S),
        }
    }

    /// Returns the SHA-256 of the gate file as it is now; nothing if it cannot be read.
    fn gate_sha256(&self) -> String {
        std::fs::read(self.gate).map_or_else(|_| String::new(), |text| sha256(&text))
    }

    fn submission(&self) -> Result<Option<Submission>, Failure> {
        let read = match &self.arguments.sweep.submission {
            Some(id) => Submission::read_as(self.store, &self.plan.gate, id).map(Some),
            None => Submission::read(self.store, &self.plan.gate),
        };
        read.map_err(Failure::Data)
    }

    fn collection(&self, submission: Option<&Submission>) -> Result<Collection<'_>, Failure> {
        let progress = Progress::new("reading");
        let (plan, store) = (self.plan, self.store);
        let collection = progress.watch("reading", self.common.thread_count(), |control| {
            Collection::of(plan, store, submission, self.limits, control)
        });
        drop(progress);
        let collection = collection.map_err(Failure::of_data)?;
        for damage in collection.damages() {
            output::talk(&format!("latchgate: store: {damage}"));
        }
        Ok(collection)
    }

    fn status(&self) -> Result<u8, Failure> {
        let submission = self.submission()?;
        let status = self.collection(submission.as_ref())?.status();
        self.print(&status, submission.as_ref())
            .map_err(Failure::Data)?;
        Ok(0)
    }

    /// Prints what is done and missing, and the tasks in the queue of the batch system.
    fn print(&self, status: &SweepStatus, submission: Option<&Submission>) -> Result<(), Error> {
        let mut text = text(status, submission);
        let mut document = serde_json::json!(status);
        if let Some(submission) = submission {
            let slurm = self.slurm(submission, 0);
            if let Some(jobs) = slurm.jobs()? {
                match slurm.queue(&jobs) {
                    Ok(queue) => {
                        let (running, waiting) = (queue.running, queue.waiting);
                        let stuck = queue.stuck.len();
                        let _ = writeln!(
                            text,
                            "  {:<10} {} running, {waiting} waiting, {stuck} stuck",
                            "slurm",
                            counted(running, "task")
                        );
                        document["engine"] = serde_json::json!({
                            "name": "slurm", "running": running, "waiting": waiting, "stuck": stuck,
                            "collecting": queue.is_collecting,
                        });
                    }
                    Err(error) => {
                        output::talk(&format!("latchgate: {error}"));
                        document["engine"] =
                            serde_json::json!({"name": "slurm", "error": error.to_string()});
                    }
                }
            }
        }
        match self.common.format {
            OutputFormat::Json => output::document(&format!("{document:#}\n")),
            OutputFormat::Text => output::text(&text),
        }
    }

    fn resubmit(&self) -> Result<u8, Failure> {
        let Some(submission) = self.submission()? else {
            return Err(Failure::Data(Error::malformed(
                "a submission in the store",
                "none",
                "submit the shares first, with --submit",
            )));
        };
        let status = self.collection(Some(&submission))?.status();
        if status.missing == 0 {
            output::talk("latchgate: nothing is missing");
            return Ok(0);
        }
        let slurm = self.slurm(&submission, RESUBMITS);
        let options = &self.arguments.sweep.engine_options;
        let options = (!options.is_empty()).then_some(options.as_slice());
        let again = slurm
            .resubmit(&status.shares, RESUBMITS, options)
            .map_err(Failure::Data)?;
        output::talk(&format!(
            "latchgate: shares {} submitted again",
            shown(&again)
        ));
        Ok(0)
    }

    /// Reads the store into one summary. If pairs are missing there is none: they are listed, and
    /// submitted again if this collecting job still may.
    pub(super) fn collect(&self, asked: SummaryOptions<'_>) -> Result<Collected, Failure> {
        let submitted = &self.arguments.sweep.gate_sha256;
        if submitted
            .as_ref()
            .is_some_and(|submitted| *submitted != self.gate_sha256())
        {
            let error = Error::malformed(
                "the gate file as it was submitted",
                "another one",
                "submit the shares again",
            );
            let place = Place::path(self.gate);
            return Err(Failure::Data(error.at(place)));
        }
        let submission = self.submission()?;
        let mut collection = self.collection(submission.as_ref())?;
        let mut status = collection.status();
        let (began, lag) = (Instant::now(), self.arguments.sweep.patience(LAG_S));
        let mut late = collection.late();
        while status.missing > 0 && !late.is_empty() && began.elapsed() < lag {
            if progress::stopped() {
                return Err(Failure::Interrupted);
            }
            std::thread::sleep(EVERY);
            collection = self.collection(submission.as_ref())?;
            status = collection.status();
            late = collection.late();
        }
        if status.missing == 0 {
            self.check_unchanged(&collection)?;
            let judged = collection.judged().map_err(Failure::Data)?;
            drop(collection);
            let summary = gate::summarise(self.plan, judged, asked);
            return Ok(Collected::Summary(Box::new(summary)));
        }
        for file in late {
            output::talk(&format!(
                "latchgate: {file} is marked as finished, but is missing or too short"
            ));
        }
        self.print(&status, submission.as_ref())
            .map_err(Failure::Data)?;
        if let (Some(resubmits @ 1..), Some(submission)) =
            (self.arguments.sweep.resubmits, &submission)
        {
            let slurm = self.slurm(submission, resubmits - 1);
            let submit = || slurm.resubmit(&status.shares, resubmits - 1, None);
            let again = patiently(submit).map_err(Failure::Data)?;
            output::talk(&format!(
                "latchgate: shares {} submitted again",
                shown(&again)
            ));
            return Ok(Collected::SubmittedAgain);
        }
        Ok(Collected::Missing)
    }

    /// Refuses a recording that changed since the shares judged it: the summary would describe
    /// another content.
    fn check_unchanged(&self, collection: &Collection<'_>) -> Result<(), Failure> {
        let progress = Progress::new("reading");
        progress
            .watch("reading", self.common.thread_count(), |control| {
                collection.check_unchanged(self.limits, control)
            })
            .map_err(Failure::of_data)
    }

    /// Keeps the exit code of a collecting job for a `--wait` elsewhere.
    pub(super) fn keep_answer(&self, exit_code: u8) -> Result<(), Failure> {
        match (self.arguments.sweep.answer, self.submission()?) {
            (Some(answer), Some(submission)) => {
                let slurm = self.slurm(&submission, 0);
                slurm.keep_answer(answer, exit_code).map_err(Failure::Data)
            }
            _ => Ok(()),
        }
    }
}

/// Repeats a request while the batch system does not answer. A collecting job has no successor that
/// would do it.
fn patiently<T>(mut ask: impl FnMut() -> Result<T, Error>) -> Result<T, Error> {
    let began = Instant::now();
    loop {
        match ask() {
            Err(_) if began.elapsed() < PATIENCE => std::thread::sleep(EVERY),
            answer => return answer,
        }
    }
}

fn text(status: &SweepStatus, submission: Option<&Submission>) -> String {
    let mut text = format!(
        "SWEEP  {} of {} judged, {} missing\n",
        status.done,
        counted(status.pairs, "pair"),
        status.missing
    );
    for (recording, pairs) in status.missing_of.iter().take(NAMED) {
        let recording = escape::terminal(recording);
        let _ = writeln!(
            text,
            "  {:<10} {recording}: {}",
            "missing",
            counted(*pairs, "pair")
        );
    }
    if status.missing_of.len() > NAMED {
        let _ = writeln!(text, "  {:<10} further recordings", "");
    }
    for recording in status.never_ended.iter().take(NAMED) {
        let recording = escape::terminal(recording);
        let _ = writeln!(
            text,
            "  {:<10} {recording}: begun twice and never finished; shares skip it",
            "left"
        );
    }
    if let Some(submission) = submission
        && !status.shares.is_empty()
    {
        let _ = writeln!(
            text,
            "  {:<10} {} of {}",
            "shares",
            shown(&status.shares),
            submission.shares
        );
    }
    text
}

fn shown(shares: &[u32]) -> String {
    ranges(shares.iter().copied())
}

/// Shows the result of a share; returns its exit code.
fn report_share(share: Share, judged: &ShareOutcome) -> u8 {
    for error in &judged.refused {
        output::talk(&format!("latchgate: {error}"));
    }
    output::talk(&format!(
        "latchgate: share {share}: {}, {} judged, {} in the store before",
        counted(judged.recordings, "recording"),
        counted(judged.judged, "pair"),
        judged.stored
    ));
    if judged.refused.is_empty() {
        0
    } else {
        COULD_NOT
    }
}
