//! The shares of a gate for a cluster: judging, watching and collecting.
//!
//! latchgate schedules nothing itself. It divides a gate into shares, keeps decisions and lists what
//! is missing. The batch system submits, runs, restarts and accounts.

use super::{GateArguments, supervise};
use crate::cli::failure::{COULD_NOT, Failure};
use crate::cli::options::Common;
use crate::cli::output;
use crate::cli::progress::{self, Progress};
use crate::cli::values::OutputFormat;
use crate::gate::text::counted;
use crate::gate::{
    self, Collection, GateSummary, Plan, Share, ShareOutcome, ShareTask, SummaryOptions,
    SweepStatus,
};
use clap::Args;
use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::Limits;
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_report::escape;
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

/// Waiting time for files of finished shares, since a shared file system may lag [s].
const LAG_S: u64 = 60;

/// Interval of polling a store.
const EVERY: Duration = Duration::from_secs(1);

/// Number of recordings that are named in a text.
const NAMED: usize = 20;

/// Options of `gate` for shares.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Shares of a gate, for a cluster")]
pub struct SweepArguments {
    /// Judge share I of N into the store, without a report; exit code 0 when complete
    #[arg(long, value_name = "I/N", value_parser = Share::parse, group = "sweep", conflicts_with = "no_store")]
    pub part: Option<Share>,
    /// Show what is done and missing
    #[arg(long, group = "sweep", conflicts_with = "no_store")]
    pub status: bool,
    /// Collect the shares into one summary; a missing pair is an error
    #[arg(long, group = "sweep", conflicts_with = "no_store")]
    pub collect: bool,
    /// Threads of a process that another one watches.
    #[arg(long, hide = true, requires = "part")]
    pub worker: Option<usize>,
    /// Seconds for which late files are waited for.
    #[arg(long, hide = true, default_value_t = LAG_S, requires = "collect")]
    pub patience: u64,
}

impl SweepArguments {
    /// True if an option of shares was given.
    pub(super) fn is_requested(&self) -> bool {
        self.part.is_some() || self.status || self.collect
    }
}

/// A command about the shares of a gate.
pub(super) struct SweepCommand<'a> {
    pub(super) plan: &'a Plan,
    pub(super) store: &'a Path,
    pub(super) limits: &'a Limits,
    pub(super) arguments: &'a GateArguments,
    pub(super) common: &'a Common,
}

impl SweepCommand<'_> {
    /// Runs the command, except for collecting; returns the exit code.
    pub(super) fn run(&self) -> Result<u8, Failure> {
        match self.arguments.sweep.part {
            Some(share) => self.part(share),
            None => self.status(),
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
        let task = ShareTask {
            share,
            folder: self.store,
            limits: self.limits,
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

    fn collection(&self) -> Result<Collection<'_>, Failure> {
        let progress = Progress::new("reading");
        let (plan, store) = (self.plan, self.store);
        let collection = progress.watch("reading", self.common.thread_count(), |control| {
            Collection::of(plan, store, self.limits, control)
        });
        drop(progress);
        let collection = collection.map_err(Failure::of_data)?;
        for damage in collection.damages() {
            output::talk(&format!("latchgate: store: {damage}"));
        }
        Ok(collection)
    }

    fn status(&self) -> Result<u8, Failure> {
        let status = self.collection()?.status();
        self.print(&status).map_err(Failure::Data)?;
        Ok(0)
    }

    /// Prints what is done and what is missing.
    fn print(&self, status: &SweepStatus) -> Result<(), Error> {
        match self.common.format {
            OutputFormat::Json => {
                let document = serde_json::json!(status);
                output::document(&format!("{document:#}\n"))
            }
            OutputFormat::Text => output::text(&text(status)),
        }
    }

    /// Reads the store into one summary. If pairs are missing there is none, and they are listed.
    pub(super) fn collect(
        &self,
        options: SummaryOptions<'_>,
    ) -> Result<Option<GateSummary>, Failure> {
        let (began, lag) = (
            Instant::now(),
            Duration::from_secs(self.arguments.sweep.patience),
        );
        let mut collection = self.collection()?;
        let mut status = collection.status();
        while status.missing > 0 && !collection.late().is_empty() && began.elapsed() < lag {
            if progress::stopped() {
                return Err(Failure::Interrupted);
            }
            std::thread::sleep(EVERY);
            collection = self.collection()?;
            status = collection.status();
        }
        if status.missing == 0 {
            let judged = collection.judged().map_err(Failure::Data)?;
            drop(collection);
            return Ok(Some(gate::summarise(self.plan, judged, options)));
        }
        for file in collection.late() {
            output::talk(&format!(
                "latchgate: {file} is marked as finished, but is missing or too short"
            ));
        }
        self.print(&status).map_err(Failure::Data)?;
        Ok(None)
    }
}

fn text(status: &SweepStatus) -> String {
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
    text
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
