//! The files of a gate: summary, its renderings, and full reports of pairs that are not as required.

use super::pairs::Pair;
use super::plan::Plan;
use super::store::{Advised, Store};
use super::summary::{GateSummary, unwritten};
use super::{junit, markdown, page};
use crate::pipeline::{Control, Extras, Limits, Prepared};
use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::error::{Error, Place};
use latchgate_report::Unplaced;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Largest number of full reports, unless all are requested. One takes as much time as a hundred
/// rows, and a megabyte.
pub const REPORTS_MAX: usize = 5;

/// Folder of the full reports.
const REPORTS: &str = "reports";

/// Choice of the pairs that get a full report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Reports {
    /// None.
    None,
    /// Those that are not as required, the worst first, five at most.
    #[default]
    Failing,
    /// Every one.
    All,
}

/// Writes `summary.json`, `summary.csv`, `junit.xml`, `summary.md` and `index.html` into a folder, and the full
/// reports below it; returns how many of these were left out. What a report searches beside its verdict is kept in the
/// store, so that it is searched once. The reports state `date` as the day of the run.
///
/// The folder is made beside and put in place at the end, so that it holds the files of one run.
///
/// # Errors
///
/// [`ErrorKind::Io`] if something cannot be written, [`Stopped`](latchgate_kernel::error::Error::Stopped).
pub fn write(
    folder: &Path,
    (plan, store): (&Plan, &Store),
    (summary, date): (&GateSummary, &str),
    reports: Reports,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<usize, Error> {
    let mut numbers: Vec<usize> = match reports {
        Reports::None => Vec::new(),
        Reports::Failing => summary.worst(),
        Reports::All => (0..summary.pairs.len()).collect(),
    };
    let requested = numbers.len();
    if reports == Reports::Failing {
        numbers.truncate(REPORTS_MAX);
    }
    let left_out = requested - numbers.len();
    Unplaced::remove_left(folder);
    let beside = Unplaced::beside(folder)?;
    let rows = numbers
        .iter()
        .map(|number| &*summary.pairs[*number].row.report_id);
    let known = store.advised(&rows.collect())?;
    let folders = control.try_map(&numbers, |&number| {
        control.unmeasured(|control| {
            let control = control.with_threads(1);
            write_report(
                (beside.path(), date),
                (plan, number),
                &summary.pairs[number],
                (store, &known),
                limits,
                &control,
            )
        })
    })?;
    let folders = numbers.into_iter().zip(folders).collect();
    let file = |name: &str| {
        let path = beside.path().join(name);
        let made = File::create(&path).map(BufWriter::new);
        made.map_err(|error| Error::io_at("write the gate's report", &path, &error))
    };
    // A drop would flush as well, but swallow the error.
    let end = |mut out: BufWriter<File>| out.flush().map_err(unwritten);
    let mut out = file("summary.json")?;
    summary.write_json(&mut out).and_then(|()| end(out))?;
    let mut out = file("junit.xml")?;
    junit::write(summary, &mut out).and_then(|()| end(out))?;
    let mut out = file("summary.csv")?;
    summary.write_csv(&mut out).and_then(|()| end(out))?;
    for (name, text) in [
        ("index.html", page::render(summary, &folders)),
        ("summary.md", markdown::render(summary)),
    ] {
        let mut out = file(name)?;
        out.write_all(text.as_bytes()).map_err(unwritten)?;
        end(out)?;
    }
    beside.settle(folder, |_| refuse_foreign_files(folder))?;
    Ok(left_out)
}

/// Writes the full report of a pair; returns its folder, relative to `folder`.
fn write_report(
    (folder, date): (&Path, &str),
    (plan, number): (&Plan, usize),
    pair: &Pair,
    (store, known): (&Store, &BTreeMap<String, Advised>),
    limits: &Limits,
    control: &Control<'_>,
) -> Result<String, Error> {
    let recording = &plan.recordings[number / plan.designs.len()];
    let design = &plan.designs[number % plan.designs.len()];
    let source = recording.source();
    let extras = Extras {
        filter_table: true,
        preload_answer: false,
        evidence: true,
    };
    let (prepared, mut outcome) = match Prepared::open(&source, &recording.request, limits, control)
    {
        Ok(prepared) => {
            let outcome = prepared.judge(design, extras, control);
            (Some(prepared), outcome)
        }
        Err(refused) => (None, refused.outcome(design)),
    };
    if outcome.was_stopped() {
        return Err(KernelError::Stopped.into());
    }
    if outcome.document.report_id != pair.row.report_id {
        let error = Error::malformed(
            "the recording as it was judged",
            "another one, or another card, when its report was written",
            "run the gate again when no program writes there",
        );
        return Err(error.at(Place::file(pair.recording.as_str())));
    }
    let prepared = prepared.filter(|_| outcome.refusal.is_none());
    let document = &mut outcome.document;
    document.run.date = Some(date.into());
    let design_file = plan.design_files.get(&design.name);
    document.run.set_design_file(design_file.cloned());
    match (known.get(&document.report_id), prepared) {
        (Some(advised), _) => {
            document.preload_answer.clone_from(&advised.preload);
            document.restitution_answer.clone_from(&advised.restitution);
        }
        (None, Some(prepared)) => {
            prepared.advise(design, document, control)?;
            let advised = Advised {
                preload: document.preload_answer.clone(),
                restitution: document.restitution_answer.clone(),
            };
            store.put_advised(&document.report_id, &advised)?;
        }
        (None, None) => {}
    }
    let id: String = pair.row.report_id.chars().take(12).collect();
    let report_folder = format!("{REPORTS}/{id}");
    let files =
        latchgate_report::files_without_series(&outcome.document, outcome.evidence.as_ref());
    let path = (!recording.is_pulse()).then_some(&*recording.path);
    latchgate_report::write(&folder.join(&report_folder), files, path)?;
    Ok(report_folder)
}

/// Files and folders that a gate writes. A folder with any other file is not replaced.
const GATE_FILES: [&str; 6] = [
    "summary.json",
    "summary.csv",
    "junit.xml",
    "summary.md",
    "index.html",
    REPORTS,
];

/// Refuses to replace a folder with a file that no gate wrote; `None` if there is none.
fn refuse_foreign_files(folder: &Path) -> Option<Result<(), Error>> {
    let names: BTreeSet<String> = fs::read_dir(folder)
        .ok()?
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let foreign = names
        .iter()
        .find(|name| !GATE_FILES.contains(&name.as_str()))?;
    let error = Error::malformed(
        "a folder for the gate alone, since it is replaced",
        format!("`{foreign}` in it"),
        "state another folder with the setting `out` = DIR",
    );
    Some(Err(error.at(Place::path(folder))))
}
