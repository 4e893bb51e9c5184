//! The files of a gate: summary, its renderings, and the full reports of what is not as required.

use super::plan::Plan;
use super::summary::{GateSummary, Pair};
use super::{junit, markdown, page};
use crate::error::{Error, ErrorKind, Place};
use crate::pipeline::{Control, Extras, Limits, Prepared, Source};
use crate::report;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

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
    let beside = beside(folder)?;
    let written = control
        .try_map(&pairs, |pair| {
            control
                .unmeasured(|control| full(&beside, plan, pair, limits, &control.with_threads(1)))
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
                let path = beside.join(name);
                fs::write(&path, text)
                    .map_err(|error| failed("write the gate's report", &path, &error))
            })
        });
    let placed = written.and_then(|()| place(&beside, folder));
    if placed.is_err() {
        // What is left of a run that failed says nothing.
        let _ = fs::remove_dir_all(&beside);
    }
    placed.map(|()| left_out)
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

/// Makes an empty folder beside `folder`.
fn beside(folder: &Path) -> Result<PathBuf, Error> {
    if let Some(parent) = folder.parent() {
        fs::create_dir_all(parent)
            .map_err(|error| failed("make the report folder", parent, &error))?;
    }
    let mut number = 0_u32;
    loop {
        let mut name = folder.as_os_str().to_os_string();
        name.push(format!(".{}-{number}.part", std::process::id()));
        let path = PathBuf::from(name);
        match fs::create_dir(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(failed("make the report folder", &path, &error)),
        }
    }
}

/// Files and folders that a gate writes: all that may stand in a folder that is replaced.
const OURS: [&str; 5] = [
    "summary.json",
    "junit.xml",
    "summary.md",
    "index.html",
    REPORTS,
];

/// Puts the finished folder in the place of an older one.
fn place(beside: &Path, folder: &Path) -> Result<(), Error> {
    let unplaced = |error: std::io::Error| failed("put the report in place", folder, &error);
    if let Ok(entries) = fs::read_dir(folder) {
        let names: BTreeSet<String> = entries
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        if let Some(other) = names.iter().find(|name| !OURS.contains(&name.as_str())) {
            return Err(Error::from(ErrorKind::Malformed {
                expected: "a folder of a gate's own, since it is replaced".into(),
                found: format!("`{other}` in it"),
                hint: "name another folder with the setting `out`".into(),
            })
            .at(Place::file(folder.display().to_string())));
        }
        let mut old = beside.as_os_str().to_os_string();
        old.push(".old");
        fs::rename(folder, &old).map_err(unplaced)?;
        fs::rename(beside, folder).map_err(unplaced)?;
        return fs::remove_dir_all(&old).map_err(unplaced);
    }
    fs::rename(beside, folder).map_err(unplaced)
}

fn failed(action: &'static str, path: &Path, error: &std::io::Error) -> Error {
    Error::from(ErrorKind::Io {
        action,
        reason: error.to_string(),
    })
    .at(Place::file(path.display().to_string()))
}
