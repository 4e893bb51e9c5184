//! `latchgate gate`: many recordings and designs, one exit code.
//!
//! - `supervise`: the worker process of a share, and the cause of its end;
//! - `sweep`: the shares of a gate for a cluster: judging, watching and collecting.

mod supervise;
pub mod sweep;

use super::clock;
use super::failure::{COULD_NOT, Failure};
use super::options::Common;
use super::output;
use super::progress::Progress;
use super::values::{OutputFormat, parse_date};
use crate::gate::files::Reports;
use crate::gate::{self, Baseline, ERRORS_MAX, GateFile, GateSummary, Plan, Store, SummaryOptions};
use crate::pipeline::Request;
use clap::{Args, ValueEnum};
use latchgate_recording::error::{Error, Place};
use latchgate_recording::{Limits, read_within};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;
use sweep::{SweepArguments, SweepCommand};

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

/// Choice of the pairs that get a full report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ReportsArgument {
    /// None.
    None,
    /// What is not as required.
    Failing,
    /// Every pair.
    All,
}

/// CI system of annotations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Annotations {
    /// GitHub Actions.
    Github,
}

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &GateArguments, common: &Common) -> Result<u8, Failure> {
    let limits = common.limits().map_err(Failure::Usage)?;
    if arguments.schema {
        let text = format!("{:#}\n", gate::schema::schema());
        return output::document(&text).map(|()| 0).map_err(Failure::Data);
    }
    if let Some(folder) = &arguments.init {
        return init(folder, &limits, common);
    }
    // clap requires the file where neither `--init` nor `--schema` is given.
    let path = arguments.gate.as_deref().unwrap_or(Path::new(""));
    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| default_folder(path));
    let store_path = store_folder(arguments, path);
    let output_folders = [folder.clone(), store_path.clone()];
    let Some(mut plan) = plan(path, &output_folders, &limits)? else {
        return Ok(COULD_NOT);
    };
    let pairs_in_gate = plan.recordings.len() * plan.designs.len();
    plan.only(&arguments.only_recording, &arguments.only_design)
        .map_err(Failure::Data)?;
    if arguments.list {
        return list(&plan, common).map(|()| 0).map_err(Failure::Data);
    }
    let sweep = arguments.sweep.is_requested().then(|| SweepCommand {
        plan: &plan,
        store: &store_path,
        limits: &limits,
        arguments,
        common,
    });
    if let Some(sweep) = sweep.as_ref().filter(|_| !arguments.sweep.collect) {
        return sweep.run();
    }
    let baseline = arguments
        .baseline
        .as_deref()
        .map(|path| baseline(path, &limits))
        .transpose()
        .map_err(Failure::Data)?;
    check_baseline(arguments, &folder)?;
    let date = arguments.date.clone().unwrap_or_else(clock::today);
    let options = SummaryOptions {
        date: &date,
        baseline: baseline.as_ref(),
        allow_removed: arguments.allow_removed,
        no_worse: arguments.no_worse,
    };
    if let Some(sweep) = sweep {
        return match sweep.collect(options)? {
            Some(summary) => answer(
                arguments,
                common,
                (&plan, &Store::unkept()),
                summary,
                &folder,
            ),
            None => Ok(COULD_NOT),
        };
    }
    let store = match arguments.no_store {
        true => Store::unkept(),
        false => Store::open(&store_path, "").map_err(Failure::Data)?,
    };
    let began = Instant::now();
    let progress = Progress::new("gate").that_keeps();
    let judged = progress.watch("gate", common.thread_count(), |control| {
        gate::run(&plan, &limits, &store, &|| began.elapsed(), control)
    });
    drop(progress);
    let run = judged.map_err(Failure::of_data).inspect_err(|failure| {
        if matches!(failure, Failure::Interrupted) && !arguments.no_store {
            output::talk(&format!(
                "latchgate: judged pairs are kept in {}; the same command continues from there",
                store_path.display()
            ));
        }
    })?;
    for damage in &run.damages {
        output::talk(&format!("latchgate: store: {damage}"));
    }
    let cached: usize = run.recordings.iter().map(|judged| judged.cached).sum();
    let summary = gate::summarise(&plan, run.recordings, options);
    let judged = summary.counts.pairs;
    let code = answer(arguments, common, (&plan, &store), summary, &folder);
    if plan.part {
        output::talk(&format!(
            "latchgate: judged the {judged} chosen of {pairs_in_gate} pairs; the gate's answer needs all"
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
    arguments: &GateArguments,
    common: &Common,
    (plan, store): (&Plan, &Store),
    mut summary: GateSummary,
    folder: &Path,
) -> Result<u8, Failure> {
    if plan.part {
        // Files of chosen pairs could be mistaken for those of the whole gate.
        print(arguments, common, plan, &summary, None).map_err(Failure::Data)?;
        return Ok(summary.exit_code);
    }
    let limits = common.limits().map_err(Failure::Usage)?;
    let date = arguments.date.clone().unwrap_or_else(clock::date_of_run);
    let reports = match arguments.reports {
        ReportsArgument::None => Reports::None,
        ReportsArgument::Failing => Reports::Failing,
        ReportsArgument::All => Reports::All,
    };
    let progress = Progress::new("reports").that_keeps();
    let written = progress.watch("reports", common.thread_count(), |control| {
        gate::files::write(
            folder,
            (plan, store),
            (&summary, &date),
            reports,
            &limits,
            control,
        )
    });
    drop(progress);
    if let Err(error) = &written {
        summary.add_problem("report-not-written", &error.to_string());
    }
    let shown = written.is_ok().then_some(folder);
    let printed = print(arguments, common, plan, &summary, shown);
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

/// Writes settings that are options of this command as options. The settings of a replay stay as
/// they are: here they are keys of the gate file.
fn worded(text: &str) -> String {
    output::with_options_but(text, &Request::keys().collect::<Vec<_>>())
}

/// Prints the answer, even without a report.
fn print(
    arguments: &GateArguments,
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
        let path = arguments.gate.as_deref().unwrap_or(Path::new(""));
        let line_of = |name: &str| {
            let mut recordings = plan.recordings.iter();
            recordings.find(|recording| recording.name == name)?.line
        };
        gate::markdown::annotations(summary, &path.display().to_string(), line_of)
    };
    match arguments.annotate {
        // GitHub reads annotations from either stream; on stdout they would spoil the JSON document.
        Some(Annotations::Github) if common.format == OutputFormat::Json => {
            output::talk(annotations().trim_end());
            Ok(())
        }
        Some(Annotations::Github) => output::document(&annotations()),
        None => Ok(()),
    }
}

/// Reads a gate file and looks up its recordings and designs; shows all its errors and returns `None`
/// if it has any.
fn plan(path: &Path, output_folders: &[PathBuf], limits: &Limits) -> Result<Option<Plan>, Failure> {
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
        .and_then(|file| Plan::of(&name, &file, folder, output_folders, limits));
    match plan {
        Ok(plan) => Ok(Some(plan)),
        Err(errors) => {
            let messages: BTreeSet<String> = errors.iter().map(ToString::to_string).collect();
            for error in messages {
                output::talk_plainly(&worded(&format!("latchgate: {error}")));
            }
            if errors.len() >= ERRORS_MAX {
                output::talk(&format!(
                    "latchgate: {name}: there may be more; {ERRORS_MAX} errors are told at a time"
                ));
            }
            Ok(None)
        }
    }
}

fn read(path: &Path, limits: &Limits) -> Result<Vec<u8>, Error> {
    let limit = ("settings_bytes", limits.settings_bytes);
    read_within(
        path,
        &path.display().to_string(),
        "read the gate file",
        limit,
    )
}

fn baseline(path: &Path, limits: &Limits) -> Result<Baseline, Error> {
    let shown = path.display().to_string();
    // A summary grows with its pairs, so the limit is that of tables.
    let limit = ("text_bytes", limits.text_bytes);
    Baseline::from_json(
        &shown,
        &read_within(path, &shown, "read the baseline", limit)?,
    )
}

/// Refuses a baseline that this run would replace: the next run would then compare with this one.
fn check_baseline(arguments: &GateArguments, folder: &Path) -> Result<(), Failure> {
    let above = arguments.baseline.as_deref().and_then(Path::parent);
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
    if !arguments.no_worse || !above.is_some_and(same) {
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

fn store_folder(arguments: &GateArguments, gate: &Path) -> PathBuf {
    let beside = || {
        gate.parent()
            .unwrap_or(Path::new(""))
            .join(gate::STORE_FOLDER)
    };
    arguments.store.clone().unwrap_or_else(beside)
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
