//! `latchgate gate`: many recordings and designs, one exit code.
//!
//! - `engine`: the programs of a batch system, called with a limit on time;
//! - `slurm`: shares as job arrays of Slurm;
//! - `supervise`: the process of a share, and what ended it;
//! - `sweep`: the shares of a gate for a cluster: judged, handed out, watched and collected.

mod engine;
mod slurm;
mod supervise;
pub mod sweep;

use super::failure::{COULD_NOT, Failure};
use super::options::Common;
use super::output;
use super::progress::Progress;
use super::values::{OutputFormat, parse_date};
use crate::gate::files::Reports;
use crate::gate::{self, Asked, Baseline, ERRORS_TOLD, GateFile, GateSummary, Plan, Store};
use crate::pipeline::Request;
use clap::{Args, ValueEnum};
use latchgate_recording::error::{Error, Place};
use latchgate_recording::{Limits, read_within};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime, UNIX_EPOCH};
use sweep::{Collected, SweepArguments, SweepCommand};

/// Options of `gate`.
#[derive(Debug, Clone, Args)]
pub struct GateArguments {
    /// Gate file: recordings, designs and what is required
    #[arg(value_name = "GATE.toml", required_unless_present_any = ["init", "schema"])]
    pub gate: Option<PathBuf>,
    /// Folder of summary and reports; it is replaced [default: reports/out/gate-NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Folder of decisions for the next run [default: .latchgate beside the gate file]
    #[arg(long, value_name = "DIR")]
    pub store: Option<PathBuf>,
    /// Judge every pair again and keep nothing
    #[arg(long, conflicts_with = "store")]
    pub no_store: bool,
    /// Full reports: the worst five pairs not as required; every pair; or none
    #[arg(long, value_enum, default_value_t = ReportsArgument::Failing)]
    pub reports: ReportsArgument,
    /// The summary.json of an earlier run to compare with
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// Allow pairs of the baseline to be missing
    #[arg(long, requires = "baseline")]
    pub allow_removed: bool,
    /// Ignore pairs not as required that are no worse than in the baseline
    #[arg(long, requires = "baseline")]
    pub no_worse: bool,
    /// Day for exceptions that expire [default: today, UTC]
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = parse_date)]
    pub date: Option<String>,
    /// Print the pairs and what is required; judge none
    #[arg(long, conflicts_with_all = ["sweep", "baseline"])]
    pub list: bool,
    /// Judge only recordings that match, and write no files; may be repeated
    #[arg(long, value_name = "PATTERN", conflicts_with_all = ["sweep", "baseline", "out"])]
    pub only_recording: Vec<String>,
    /// Judge only with designs that match, and write no files; may be repeated
    #[arg(long, value_name = "PATTERN", conflicts_with_all = ["sweep", "baseline", "out"])]
    pub only_design: Vec<String>,
    /// Print pairs not as required as annotations of a CI system, at most ten
    #[arg(long, value_enum)]
    pub annotate: Option<Annotations>,
    /// Write a first gate.toml into a folder of recordings; never replaces a file
    #[arg(long, value_name = "DIR", conflicts_with_all = ["gate", "schema"])]
    pub init: Option<PathBuf>,
    /// Print the JSON Schema of gate files
    #[arg(long, conflicts_with = "gate")]
    pub schema: bool,
    /// Shares of it.
    #[command(flatten)]
    pub sweep: SweepArguments,
}

/// Which pairs get a full report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ReportsArgument {
    /// None.
    None,
    /// What is not as required.
    Failing,
    /// Every pair.
    All,
}

/// Whose annotations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Annotations {
    /// GitHub Actions.
    Github,
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &GateArguments, common: &Common) -> Result<u8, Failure> {
    let limits = common.limits().map_err(Failure::Usage)?;
    if own.schema {
        let text = format!("{:#}\n", gate::schema::schema());
        return output::document(&text).map(|()| 0).map_err(Failure::Data);
    }
    if let Some(folder) = &own.init {
        return init(folder, &limits, common);
    }
    // clap asks for the file where none of the two is given.
    let path = own.gate.as_deref().unwrap_or(Path::new(""));
    let folder = own.out.clone().unwrap_or_else(|| default_folder(path));
    let at = store_folder(own, path);
    let ours = [folder.clone(), at.clone()];
    let Some(mut plan) = plan(path, &ours, &limits)? else {
        return Ok(COULD_NOT);
    };
    let all = plan.recordings.len() * plan.designs.len();
    plan.only(&own.only_recording, &own.only_design)
        .map_err(Failure::Data)?;
    if own.list {
        return list(&plan, common).map(|()| 0).map_err(Failure::Data);
    }
    let sweep = own.sweep.is_asked().then(|| SweepCommand {
        gate: path,
        plan: &plan,
        store: &at,
        limits: &limits,
        own,
        common,
    });
    if let Some(sweep) = sweep.as_ref().filter(|_| !own.sweep.collect) {
        return sweep.work();
    }
    let baseline = own
        .baseline
        .as_deref()
        .map(|path| baseline(path, &limits))
        .transpose()
        .map_err(Failure::Data)?;
    check_baseline(own, &folder)?;
    let date = own.date.clone().unwrap_or_else(today);
    let asked = Asked {
        date: &date,
        baseline: baseline.as_ref(),
        allow_removed: own.allow_removed,
        no_worse: own.no_worse,
    };
    if let Some(sweep) = sweep {
        let collected = sweep.collect(asked);
        if matches!(collected, Ok(Collected::SubmittedAgain)) {
            // The job behind it has the answer.
            return Ok(COULD_NOT);
        }
        let collected = collected.and_then(|collected| match collected {
            Collected::Summary(summary) => answer(own, common, &plan, *summary, &folder),
            Collected::SubmittedAgain | Collected::Missing => Ok(COULD_NOT),
        });
        sweep.keep_answer(*collected.as_ref().unwrap_or(&COULD_NOT))?;
        return collected;
    }
    let store = match own.no_store {
        true => Store::unkept(),
        false => Store::open(&at, "").map_err(Failure::Data)?,
    };
    let began = Instant::now();
    let progress = Progress::new("gate").that_keeps();
    let judged = progress.watch("gate", common.thread_count(), |control| {
        gate::run(&plan, &limits, &store, &|| began.elapsed(), control)
    });
    drop(progress);
    let run = judged.map_err(Failure::of_data).inspect_err(|failure| {
        if matches!(failure, Failure::Interrupted) && !own.no_store {
            output::talk(&format!(
                "latchgate: judged pairs are kept in {}; the same command continues from there",
                at.display()
            ));
        }
    })?;
    for damage in &run.damages {
        output::talk(&format!("latchgate: store: {damage}"));
    }
    let cached: usize = run.recordings.iter().map(|judged| judged.cached).sum();
    let summary = gate::hold(&plan, run.recordings, asked);
    let judged = summary.counts.pairs;
    let code = answer(own, common, &plan, summary, &folder);
    if plan.part {
        output::talk(&format!(
            "latchgate: judged the {judged} chosen of {all} pairs; the gate's answer needs all"
        ));
    }
    if cached > 0 {
        let pairs = gate::text::counted(judged, "pair");
        output::talk(&format!("latchgate: {cached} of {pairs} cached"));
    }
    code
}

/// Writes the files of a gate and prints its answer; returns the exit code.
fn answer(
    own: &GateArguments,
    common: &Common,
    plan: &Plan,
    mut summary: GateSummary,
    folder: &Path,
) -> Result<u8, Failure> {
    if plan.part {
        // Files of some pairs could be taken for those of all.
        print(own, common, plan, &summary, None).map_err(Failure::Data)?;
        return Ok(summary.exit_code);
    }
    let limits = common.limits().map_err(Failure::Usage)?;
    let reports = match own.reports {
        ReportsArgument::None => Reports::None,
        ReportsArgument::Failing => Reports::Failing,
        ReportsArgument::All => Reports::All,
    };
    let progress = Progress::new("reports").that_keeps();
    let written = progress.watch("reports", common.thread_count(), |control| {
        gate::files::write(folder, plan, &summary, reports, &limits, control)
    });
    drop(progress);
    if let Err(error) = &written {
        summary.add_problem("report-not-written", &error.to_string());
    }
    let shown = written.is_ok().then_some(folder);
    let printed = print(own, common, plan, &summary, shown);
    let left_out = written.map_err(Failure::of_data)?;
    printed.map_err(Failure::Data)?;
    if left_out > 0 {
        output::talk(&format!(
            "latchgate: pairs without a full report, which the worst have: {}",
            gate::text::counted(left_out, "pair")
        ));
    }
    Ok(summary.exit_code)
}

/// Words the settings of a gate that are options of this command.
fn worded(text: &str) -> String {
    output::with_options_but(text, &Request::keys().collect::<Vec<_>>())
}

/// Prints the answer, even where its report could not be written, or is none.
fn print(
    own: &GateArguments,
    common: &Common,
    plan: &Plan,
    summary: &GateSummary,
    folder: Option<&Path>,
) -> Result<(), Error> {
    match common.format {
        OutputFormat::Json => {
            let mut text = Vec::new();
            summary.write_json(&mut text)?;
            output::document(&String::from_utf8_lossy(&text))?;
        }
        OutputFormat::Text => {
            let page = folder.map(|folder| folder.join("index.html").display().to_string());
            output::document(&worded(&gate::text::render(summary, page.as_deref())))?;
        }
    }
    let annotations = || {
        let path = own.gate.as_deref().unwrap_or(Path::new(""));
        let line_of = |name: &str| {
            let mut recordings = plan.recordings.iter();
            recordings.find(|own| own.name == name)?.line
        };
        gate::markdown::annotations(summary, &path.display().to_string(), line_of)
    };
    match own.annotate {
        // Workflow commands are read from either stream; a JSON document is to stay one.
        Some(Annotations::Github) if common.format == OutputFormat::Json => {
            output::talk(annotations().trim_end());
            Ok(())
        }
        Some(Annotations::Github) => output::document(&annotations()),
        None => Ok(()),
    }
}

/// Reads and looks up a gate file; says everything that is wrong with it and returns `None`.
fn plan(path: &Path, own: &[PathBuf], limits: &Limits) -> Result<Option<Plan>, Failure> {
    let name = file_name(path);
    let bytes = read(path, limits).map_err(Failure::Data)?;
    let text = String::from_utf8(bytes).map_err(|_| {
        Failure::Data(
            Error::malformed("UTF-8", "other bytes", "save the gate file as UTF-8")
                .at(Place::file(name.clone())),
        )
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let plan = GateFile::from_toml(&name, text, limits)
        .and_then(|file| Plan::of(&name, &file, folder, own, limits));
    match plan {
        Ok(plan) => Ok(Some(plan)),
        Err(errors) => {
            let told: BTreeSet<String> = errors.iter().map(ToString::to_string).collect();
            for error in told {
                output::talk_plainly(&worded(&format!("latchgate: {error}")));
            }
            if errors.len() >= ERRORS_TOLD {
                output::talk(&format!(
                    "latchgate: {name}: there may be more; {ERRORS_TOLD} errors are told at a time"
                ));
            }
            Ok(None)
        }
    }
}

fn read(path: &Path, limits: &Limits) -> Result<Vec<u8>, Error> {
    let most = ("settings_bytes", limits.settings_bytes);
    read_within(
        path,
        &path.display().to_string(),
        "read the gate file",
        most,
    )
}

/// A summary grows with its pairs, and so may be as large as a table of text.
fn baseline(path: &Path, limits: &Limits) -> Result<Baseline, Error> {
    let shown = path.display().to_string();
    let most = ("text_bytes", limits.text_bytes);
    Baseline::from_json(
        &shown,
        &read_within(path, &shown, "read the baseline", most)?,
    )
}

/// Refuses a baseline that the run would replace: what it lets stand would be lost for the next.
fn check_baseline(own: &GateArguments, folder: &Path) -> Result<(), Failure> {
    let above = own.baseline.as_deref().and_then(Path::parent);
    let same = |above: &Path| {
        let above = if above.as_os_str().is_empty() {
            Path::new(".")
        } else {
            above
        };
        match (above.canonicalize(), folder.canonicalize()) {
            (Ok(above), Ok(folder)) => above == folder,
            _ => false,
        }
    };
    if !own.no_worse || !above.is_some_and(same) {
        return Ok(());
    }
    Err(Failure::Usage(
        Error::malformed(
            "a baseline outside the gate's report folder",
            format!("it in {}", folder.display()),
            "keep it elsewhere, or state another folder with the setting `out` = DIR",
        )
        .at(Place::file("--baseline")),
    ))
}

fn store_folder(own: &GateArguments, gate: &Path) -> PathBuf {
    let beside = || {
        gate.parent()
            .unwrap_or(Path::new(""))
            .join(gate::STORE_FOLDER)
    };
    own.store.clone().unwrap_or_else(beside)
}

fn init(folder: &Path, limits: &Limits, common: &Common) -> Result<u8, Failure> {
    let progress = Progress::new("reading");
    let text = progress.watch("reading", common.thread_count(), |control| {
        gate::init::first(folder, limits, control)
    });
    drop(progress);
    let text = text.map_err(Failure::of_data)?;
    let path = folder.join("gate.toml");
    super::init::create(&path, &text).map_err(Failure::Data)?;
    output::text(&format!("{}\n", path.display())).map_err(Failure::Data)?;
    Ok(0)
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Prints the pairs of a gate.
fn list(plan: &Plan, common: &Common) -> Result<(), Error> {
    let mut text = String::new();
    let mut listed = Vec::new();
    for recording in &plan.recordings {
        for design in &plan.designs {
            let (recording, design) = (&recording.name, &design.name);
            let required = plan.required(recording, design).name();
            let line = format!("{recording} with {design}: {required} required");
            text.push_str(&latchgate_report::escape::terminal(&line));
            text.push('\n');
            listed.push(serde_json::json!({
                "recording": recording, "design": design, "required": required,
            }));
        }
    }
    match common.format {
        OutputFormat::Text => output::document(&text),
        OutputFormat::Json => output::document(&format!("{:#}\n", serde_json::Value::from(listed))),
    }
}

/// `reports/out/gate-<name of the gate file>`.
fn default_folder(gate: &Path) -> PathBuf {
    let stem = gate
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Path::new("reports/out").join(format!("gate-{stem}"))
}

/// Returns the day of now, UTC, `YYYY-MM-DD`.
fn today() -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let days = now.map_or(0, |since| since.as_secs() / 86_400) as i64;
    gate::file::day(days)
}
