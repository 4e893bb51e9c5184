//! The shares of a gate for a cluster: judged, handed out, watched and collected.
//!
//! latchgate schedules nothing itself. It says what a share is, keeps what is finished and knows
//! what is missing; the engine that is there runs, restarts and accounts.

use super::slurm::{Slurm, SlurmJobs, ranges};
use super::{GateArguments, supervise};
use crate::cli::failure::{COULD_NOT, Failure};
use crate::cli::options::Common;
use crate::cli::output;
use crate::cli::progress::{self, Progress};
use crate::cli::values::OutputFormat;
use crate::gate::text::counted;
use crate::gate::{
    self, Asked, Collection, GateSummary, Plan, Share, ShareOutcome, ShareTask, Standing,
    Submission,
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

/// Times that the collecting job submits what is missing.
const RESUBMITS: u32 = 3;

/// Time that files of a share that is finished are waited for, since a shared file system may lag
/// [s].
const LAG_S: u64 = 60;

/// Time that a program of the engine has to answer [s].
const ANSWER_S: u64 = 30;

/// Time for which a collecting job tries to reach the engine.
const PATIENCE: Duration = Duration::from_secs(120);

/// Time between two looks at a store or a queue.
const EVERY: Duration = Duration::from_secs(1);

/// Collecting jobs that are begun anew where one is lost.
const COLLECTING_MAX: u32 = 3;

/// Pairs that are judged for an estimate.
const TRIED: usize = 5;

/// Bytes that a pair takes in the store, about.
const BYTES_A_PAIR: f64 = 300.0;

/// Minutes of a task below which starting it costs too much: about a second of the scheduler's.
const MINUTES_MIN: f64 = 2.0;

/// Recordings that are named in a text.
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
    /// Returns how long something is waited for that has so many seconds.
    fn patience(&self, usual_s: u64) -> Duration {
        Duration::from_secs(self.patience.unwrap_or(usual_s))
    }

    /// Tells whether shares are spoken of.
    pub(super) fn is_asked(&self) -> bool {
        let asked = self.status || self.resubmit || self.collect || self.estimate;
        self.part.is_some() || self.submit.is_some() || asked
    }
}

/// What collecting came to.
pub(super) enum Collected {
    /// All pairs are there.
    Summary(Box<GateSummary>),
    /// Some are missing, and were submitted again, with a job that collects behind them.
    SubmittedAgain,
    /// Some are missing.
    Missing,
}

/// A gate of which shares are judged.
pub(super) struct SweepCommand<'a> {
    pub(super) gate: &'a Path,
    pub(super) plan: &'a Plan,
    pub(super) store: &'a Path,
    pub(super) limits: &'a Limits,
    pub(super) own: &'a GateArguments,
    pub(super) common: &'a Common,
}

impl SweepCommand<'_> {
    /// Does what is asked but collecting; returns the exit code.
    pub(super) fn work(&self) -> Result<u8, Failure> {
        let own = &self.own.sweep;
        match (own.part, own.submit) {
            (Some(share), _) => self.part(share),
            (None, Some(Engine::Slurm)) => self.submit(own.parts.unwrap_or(1)),
            (None, None) if own.resubmit => self.resubmit(),
            (None, None) if own.estimate => self.try_some(),
            (None, None) => self.status(),
        }
    }

    /// Judges a share, in a process of its own that this one watches.
    fn part(&self, share: Share) -> Result<u8, Failure> {
        progress::listen_to_terminate();
        match self.own.sweep.worker {
            Some(threads) => {
                supervise::end_with_the_watch();
                self.judge(share, threads)
            }
            None => supervise::watch(self.store, share, self.common.thread_count()),
        }
    }

    fn judge(&self, share: Share, threads: usize) -> Result<u8, Failure> {
        let began = Instant::now();
        let submission = match &self.own.sweep.submission {
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
            ErrorKind::Kernel(KernelError::Stopped) if progress::terminated() => {
                Failure::Data(error)
            }
            _ => Failure::of_data(error),
        })?;
        Ok(told(share, &judged))
    }

    /// Submits the shares to Slurm, or prints their script.
    fn submit(&self, shares: u32) -> Result<u8, Failure> {
        if !self.own.sweep.untried {
            self.estimate(shares)?;
        }
        let progress = Progress::new("reading");
        let submission = progress.watch("reading", self.common.thread_count(), |control| {
            Submission::of(self.plan, shares, self.limits, control)
        });
        drop(progress);
        let submission = submission.map_err(Failure::of_data)?;
        let slurm = self.slurm(&submission, RESUBMITS);
        if self.own.sweep.print {
            return output::document(&slurm.share_script())
                .map(|()| 0)
                .map_err(Failure::Data);
        }
        submission
            .keep(self.store, &self.plan.gate)
            .map_err(Failure::Data)?;
        let all: Vec<u32> = (1..=shares).collect();
        let options = &self.own.sweep.engine_options;
        let jobs = slurm
            .submit(&all, Vec::new(), RESUBMITS, options)
            .map_err(Failure::Data)?;
        output::talk(&format!(
            "latchgate: {} submitted; job {} collects",
            counted(shares as usize, "share"),
            jobs.collecting
        ));
        if self.own.sweep.wait {
            return self.wait(&slurm, jobs);
        }
        Ok(0)
    }

    /// Waits for the last job that collects for what was submitted as `jobs`; returns its exit code.
    /// Tasks that will never run are cancelled meanwhile, since everything behind them waits for them.
    fn wait(&self, slurm: &Slurm<'_>, mut jobs: SlurmJobs) -> Result<u8, Failure> {
        let (mut absent, mut begun, mut told) = (0, 0, false);
        let progress = Progress::new("waiting");
        progress.watch("waiting", 1, |control| {
            loop {
                // What another one submitted since has an answer of its own.
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
                        told = false;
                    }
                    // A controller that is away comes back.
                    Err(error) if !told => {
                        output::talk(&format!("latchgate: {error}; waiting for it"));
                        told = true;
                    }
                    Err(_) => {}
                }
                if absent >= 5 {
                    if begun == COLLECTING_MAX {
                        let why = "the collecting job ended without an answer; see its output";
                        output::talk(&format!("latchgate: {why} in {}", slurm.folder.display()));
                        return Ok(COULD_NOT);
                    }
                    // Where that fails it is tried again.
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

    /// Says what all pairs will take, from a few that are judged in a process of their own: one of
    /// them may end it.
    fn estimate(&self, shares: u32) -> Result<(), Failure> {
        let words = self.command_line("", None);
        let tried = std::env::current_exe().and_then(|program| {
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
        let text = tried.map_or_else(|_| Vec::new(), |tried| tried.stdout);
        let Ok(seconds) = String::from_utf8_lossy(&text).trim().parse::<f64>() else {
            output::talk(
                "latchgate: the time of a pair is unknown: one of five trial pairs ended its \
                 process",
            );
            return Ok(());
        };
        let pairs = self.plan.recordings.len() * self.plan.designs.len();
        let whole_s = seconds * pairs as f64;
        let minutes = whole_s / 60.0 / f64::from(shares);
        output::talk(&format!(
            "latchgate: {}: about {:.2} processor hours, {:.1} MB in the store, {minutes:.1} \
             minutes for each of {}",
            counted(pairs, "pair"),
            whole_s / 3600.0,
            pairs as f64 * BYTES_A_PAIR / 1e6,
            counted(shares as usize, "share")
        ));
        if minutes < MINUTES_MIN {
            output::talk(&format!(
                "latchgate: a task costs about a second of scheduling, and sites expect 10 minutes \
                 or more; with {} a task takes about {MINUTES_MIN} minutes",
                counted(
                    (whole_s / 60.0 / MINUTES_MIN).ceil().max(1.0) as usize,
                    "share"
                )
            ));
        }
        Ok(())
    }

    /// Judges a few pairs spread over all, and prints the seconds of one.
    fn try_some(&self) -> Result<u8, Failure> {
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
        let own = self.own;
        let mut collect_command = share_command.clone();
        collect_command.extend([
            "--collect".into(),
            "--resubmits".into(),
            resubmits.to_string(),
            "--gate-sha256".into(),
            own.sweep
                .gate_sha256
                .clone()
                .unwrap_or_else(|| self.gate_sha256()),
        ]);
        let paths = [("--out", &own.out), ("--baseline", &own.baseline)];
        for (option, path) in paths {
            if let Some(path) = path {
                collect_command.extend([option.into(), path.display().to_string()]);
            }
        }
        let date = own
            .date
            .iter()
            .flat_map(|date| ["--date".into(), date.clone()]);
        collect_command.extend(date);
        let reports = own.reports.to_possible_value();
        let reports = reports.map_or_else(String::new, |value| value.get_name().into());
        collect_command.extend(["--reports".into(), reports]);
        for (option, is_asked) in [
            ("--allow-removed", own.allow_removed),
            ("--no-worse", own.no_worse),
        ] {
            collect_command.extend(is_asked.then(|| option.to_string()));
        }
        Slurm {
            folder: gate::collect::engine_folder(self.store),
            gate: &self.plan.gate,
            submission: id,
            shares: submission.shares,
            share_command,
            collect_command,
            answer: own.sweep.answer,
            answer_within: own.sweep.patience(ANSWER_S),
        }
    }

    /// Returns the SHA-256 of the gate file as it is now; nothing if it cannot be read.
    fn gate_sha256(&self) -> String {
        std::fs::read(self.gate).map_or_else(|_| String::new(), |text| sha256(&text))
    }

    fn submission(&self) -> Result<Option<Submission>, Failure> {
        let read = match &self.own.sweep.submission {
            Some(id) => Submission::read_as(self.store, &self.plan.gate, id).map(Some),
            None => Submission::read(self.store, &self.plan.gate),
        };
        read.map_err(Failure::Data)
    }

    fn collection(&self, submission: Option<&Submission>) -> Result<Collection<'_>, Failure> {
        let progress = Progress::new("reading");
        let (plan, store) = (self.plan, self.store);
        let found = progress.watch("reading", self.common.thread_count(), |control| {
            Collection::of(plan, store, submission, self.limits, control)
        });
        drop(progress);
        let found = found.map_err(Failure::of_data)?;
        for damage in found.damages() {
            output::talk(&format!("latchgate: store: {damage}"));
        }
        Ok(found)
    }

    fn status(&self) -> Result<u8, Failure> {
        let submission = self.submission()?;
        let standing = self.collection(submission.as_ref())?.standing();
        self.print(&standing, submission.as_ref())
            .map_err(Failure::Data)?;
        Ok(0)
    }

    /// Prints what stands where, with what the engine has of it.
    fn print(&self, standing: &Standing, submission: Option<&Submission>) -> Result<(), Error> {
        let mut text = text(standing, submission);
        let mut document = serde_json::json!(standing);
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
        let standing = self.collection(Some(&submission))?.standing();
        if standing.missing == 0 {
            output::talk("latchgate: nothing is missing");
            return Ok(0);
        }
        let slurm = self.slurm(&submission, RESUBMITS);
        let options = &self.own.sweep.engine_options;
        let options = (!options.is_empty()).then_some(options.as_slice());
        let again = slurm
            .resubmit(&standing.shares, RESUBMITS, options)
            .map_err(Failure::Data)?;
        output::talk(&format!(
            "latchgate: shares {} submitted again",
            shown(&again)
        ));
        Ok(0)
    }

    /// Reads the store into one summary. Where something is missing it is said, and submitted again
    /// where this is a job that may; then there is no summary.
    pub(super) fn collect(&self, asked: Asked<'_>) -> Result<Collected, Failure> {
        let submitted = &self.own.sweep.gate_sha256;
        if submitted
            .as_ref()
            .is_some_and(|then| *then != self.gate_sha256())
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
        let mut standing = collection.standing();
        let (began, lag) = (Instant::now(), self.own.sweep.patience(LAG_S));
        let mut late = collection.late();
        while standing.missing > 0 && !late.is_empty() && began.elapsed() < lag {
            if progress::stopped() {
                return Err(Failure::Interrupted);
            }
            std::thread::sleep(EVERY);
            collection = self.collection(submission.as_ref())?;
            standing = collection.standing();
            late = collection.late();
        }
        if standing.missing == 0 {
            self.check_unchanged(&collection)?;
            let judged = collection.judged().map_err(Failure::Data)?;
            drop(collection);
            let summary = gate::hold(self.plan, judged, asked);
            return Ok(Collected::Summary(Box::new(summary)));
        }
        for file in late {
            output::talk(&format!(
                "latchgate: {file} is marked as finished, but is missing or too short"
            ));
        }
        self.print(&standing, submission.as_ref())
            .map_err(Failure::Data)?;
        if let (Some(left @ 1..), Some(submission)) = (self.own.sweep.resubmits, &submission) {
            let slurm = self.slurm(submission, left - 1);
            let submit = || slurm.resubmit(&standing.shares, left - 1, None);
            let again = patiently(submit).map_err(Failure::Data)?;
            output::talk(&format!(
                "latchgate: shares {} submitted again",
                shown(&again)
            ));
            return Ok(Collected::SubmittedAgain);
        }
        Ok(Collected::Missing)
    }

    /// Refuses a recording that changed since the shares judged it: the answer would not be of what
    /// lies there.
    fn check_unchanged(&self, collection: &Collection<'_>) -> Result<(), Failure> {
        let progress = Progress::new("reading");
        progress
            .watch("reading", self.common.thread_count(), |control| {
                collection.check_unchanged(self.limits, control)
            })
            .map_err(Failure::of_data)
    }

    /// Keeps the exit code of a collecting job for whoever waits for it.
    pub(super) fn keep_answer(&self, exit_code: u8) -> Result<(), Failure> {
        match (self.own.sweep.answer, self.submission()?) {
            (Some(answer), Some(submission)) => {
                let slurm = self.slurm(&submission, 0);
                slurm.keep_answer(answer, exit_code).map_err(Failure::Data)
            }
            _ => Ok(()),
        }
    }
}

/// Tries again while an engine does not answer: nobody else will.
fn patiently<T>(mut ask: impl FnMut() -> Result<T, Error>) -> Result<T, Error> {
    let began = Instant::now();
    loop {
        match ask() {
            Err(_) if began.elapsed() < PATIENCE => std::thread::sleep(EVERY),
            answer => return answer,
        }
    }
}

fn text(standing: &Standing, submission: Option<&Submission>) -> String {
    let mut text = format!(
        "SWEEP  {} of {} judged, {} missing\n",
        standing.done,
        counted(standing.pairs, "pair"),
        standing.missing
    );
    for (recording, pairs) in standing.missing_of.iter().take(NAMED) {
        let recording = escape::terminal(recording);
        let _ = writeln!(
            text,
            "  {:<10} {recording}: {}",
            "missing",
            counted(*pairs, "pair")
        );
    }
    if standing.missing_of.len() > NAMED {
        let _ = writeln!(text, "  {:<10} further recordings", "");
    }
    for recording in standing.never_ended.iter().take(NAMED) {
        let recording = escape::terminal(recording);
        let _ = writeln!(
            text,
            "  {:<10} {recording}: begun twice and never finished; shares skip it",
            "left"
        );
    }
    if let Some(submission) = submission
        && !standing.shares.is_empty()
    {
        let _ = writeln!(
            text,
            "  {:<10} {} of {}",
            "shares",
            shown(&standing.shares),
            submission.shares
        );
    }
    text
}

fn shown(shares: &[u32]) -> String {
    ranges(shares.iter().copied())
}

/// Says what became of a share; returns its exit code.
fn told(share: Share, judged: &ShareOutcome) -> u8 {
    for error in &judged.refused {
        output::talk(&format!("latchgate: {error}"));
    }
    output::talk(&format!(
        "latchgate: share {share}: {}, {} judged, {} in the store before",
        counted(judged.recordings, "recording"),
        counted(judged.judged, "pair"),
        judged.known
    ));
    if judged.refused.is_empty() {
        0
    } else {
        COULD_NOT
    }
}
