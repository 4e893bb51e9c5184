//! The files of a gate: summary, its renderings, and the full reports of what is not as required.

use super::plan::Plan;
use super::summary::{GateSummary, Pair};
use super::{junit, markdown, page};
use crate::error::{Error, ErrorKind, Place};
use crate::pipeline::{Control, Extras, Limits, Prepared, Source};
use crate::report::{self, Unplaced};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Most full reports: one costs as much time as a hundred rows, and a megabyte.
pub const REPORTS_MAX: usize = 50;

/// Folder of the full reports.
const REPORTS: &str = "reports";

/// Which pairs get a full report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Reports {
    /// None.
    None,
    /// Those that are not as required, the worst first, fifty at most.
    #[default]
    Failing,
    /// Every one.
    All,
}

/// Writes `summary.json`, `junit.xml`, `summary.md` and `index.html` into a folder, and the full
/// reports below it; returns how many of these were left out.
///
/// The folder is made beside and put in place at the end, so that it holds the files of one run.
///
/// # Errors
///
/// [`ErrorKind::Io`] if something cannot be written, [`ErrorKind::Stopped`].
pub fn write(
    folder: &Path,
    plan: &Plan,
    summary: &GateSummary,
    reports: Reports,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<usize, Error> {
    let mut pairs: Vec<&Pair> = match reports {
        Reports::None => Vec::new(),
        Reports::Failing => summary.worst(),
        Reports::All => summary.pairs.iter().collect(),
    };
    let all = pairs.len();
    if reports == Reports::Failing {
        pairs.truncate(REPORTS_MAX);
    }
    let left_out = all - pairs.len();
    let beside = Unplaced::beside(folder)?;
    let written = control
        .try_map(&pairs, |pair| {
            control.unmeasured(|control| {
                full(beside.path(), plan, pair, limits, &control.with_threads(1))
            })
        })
        .and_then(|folders| {
            let found: BTreeMap<Named, String> = folders.into_iter().flatten().collect();
            let files = [
                ("summary.json", summary.to_json()),
                ("junit.xml", junit::render(summary)),
                ("summary.md", markdown::render(summary)),
                ("index.html", page::render(summary, &found)),
            ];
            files.iter().try_for_each(|(name, text)| {
                let path = beside.path().join(name);
                fs::write(&path, text)
                    .map_err(|error| failed("write the gate's report", &path, &error))
            })
        });
    written?;
    beside.settle(folder, |_| others(folder))?;
    Ok(left_out)
}

/// A pair by recording and design.
type Named = (String, String);

/// Writes the full report of a pair; returns its folder by recording and design.
fn full(
    folder: &Path,
    plan: &Plan,
    pair: &Pair,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<Option<(Named, String)>, Error> {
    let recording = plan
        .recordings
        .iter()
        .find(|recording| recording.name == pair.recording);
    let design = plan
        .designs
        .iter()
        .find(|design| design.name == pair.design);
    let (Some(recording), Some(design)) = (recording, design) else {
        return Ok(None);
    };
    let source = Source::File(recording.path.clone());
    let extras = Extras {
        filter_table: true,
        preload_answer: true,
        evidence: true,
    };
    let outcome = match Prepared::open(&source, &recording.request, limits, control) {
        Ok(prepared) => prepared.judge(design, extras, control),
        Err(refused) => refused.outcome(design),
    };
    if outcome.was_stopped() {
        return Err(ErrorKind::Stopped.into());
    }
    let id: String = pair.row.report_id.chars().take(12).collect();
    let own = format!("{REPORTS}/{id}");
    report::write(
        &folder.join(&own),
        &outcome.document,
        outcome.evidence.as_ref(),
        Some(&recording.path),
    )?;
    Ok(Some(((pair.recording.clone(), pair.design.clone()), own)))
}

/// Files and folders that a gate writes: all that may stand in a folder that is replaced.
const OURS: [&str; 5] = [
    "summary.json",
    "junit.xml",
    "summary.md",
    "index.html",
    REPORTS,
];

/// Refuses to replace a folder that holds what no gate wrote.
fn others(folder: &Path) -> Option<Result<(), Error>> {
    let names: BTreeSet<String> = fs::read_dir(folder)
        .ok()?
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let other = names.iter().find(|name| !OURS.contains(&name.as_str()))?;
    let error = Error::from(ErrorKind::Malformed {
        expected: "a folder of a gate's own, since it is replaced".into(),
        found: format!("`{other}` in it"),
        hint: "name another folder with the setting `out`".into(),
    });
    Some(Err(error.at(Place::file(folder.display().to_string()))))
}

fn failed(action: &'static str, path: &Path, error: &std::io::Error) -> Error {
    Error::from(ErrorKind::Io {
        action,
        reason: error.to_string(),
    })
    .at(Place::file(path.display().to_string()))
}
