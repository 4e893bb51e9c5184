//! What people and scripts read: `report.html`, `verdict.json`, plots and the terminal's text.
//!
//! This crate computes nothing: every number it shows stands in the [`Document`] or in the
//! [`Evidence`] first. Units are converted for display and long signals thinned for drawing,
//! no more. The time that a run took is shown nowhere but in `verdict.json`, so that the same
//! input gives the same bytes.
//!
//! - `angle`: angles as people read them: degrees first, no more digits than are known;
//! - `codes`: places and axes of sensors spelt out, by tables beside it;
//! - `comparison`: what differs between verdicts, in a sentence and a few rows;
//! - `differences`: every key in which verdicts differ;
//! - `escape`: makes text from files safe to show: in markup and on a terminal;
//! - `folder`: a report's folder: its name; it holds the earlier report, the new one or none;
//! - `html`: `report.html`: one file that opens offline, in light and dark, and prints on A4;
//! - `margin`: what `latchgate margin` hands over: its text, and the files of its report;
//! - `margin_words`: what the terminal and the page of a margin say of an answer in the same words;
//! - `headline`: the first line of a verdict: what the lever does, or what would decide;
//! - `opening`: the instant at which a lever opens, with the digits that its spread deserves;
//! - `page`: the start and the end of every page;
//! - `plot`: plots in SVG: the same drawing stands inline in the report and alone in a file;
//! - `sensor_place`: the sensor's place and the factors to the latch, in words;
//! - `series`: signal and trajectories as a table, sample by sample;
//! - `sheet`: the style of pages: screen in light and dark, paper in light alone;
//! - `sparkline`: a signal in one line of a terminal;
//! - `spectrum`: what `latchgate spectrum` hands over: its text, and the files of its report;
//! - `spectrum_words`: what terminal, page and chart of spectra say in the same words;
//! - `statics`: what `latchgate static` hands over: its text, and a page to file;
//! - `terminal`: lines of a terminal: wrapped, coloured, in tables;
//! - `text`: the verdict for a terminal;
//! - `words`: words that the terminal and the page share.

pub mod angle;
pub mod codes;
pub mod comparison;
pub mod differences;
pub mod escape;
mod folder;
mod headline;
pub mod html;
pub mod margin;
mod margin_words;
pub mod opening;
pub mod page;
pub mod plot;
mod sensor_place;
pub mod series;
mod sheet;
pub mod sparkline;
pub mod spectrum;
mod spectrum_words;
pub mod statics;
pub mod terminal;
pub mod text;
mod words;

pub use folder::{COMPARE_FILE, Unplaced, VERDICT_FILE, folder_name};
pub use headline::headline;
use latchgate_recording::error::Error;
pub use words::{UNSEEN, test_facts};

pub use latchgate_document::{Document, json};
use latchgate_verdict::{Evidence, SampledSeries};
use std::path::{Path, PathBuf};

/// Returns the design's name with the keys that were overridden, their values and what these took
/// the place of: `paper, modified: preload torque 5 N m (0.1)`; or that every value is the paper's.
pub fn full_design(design: &latchgate_kernel::model::Design) -> String {
    words::design(design)
}

/// File name of the report.
pub const REPORT_FILE: &str = "report.html";

/// File name of the page as printed.
pub const PDF_FILE: &str = "report.pdf";

/// File name of the series.
pub const SERIES_FILE: &str = "series.csv";

/// File name of the note that says which recording was replayed: its path as it was given, from
/// the folder where that was.
pub const SOURCE_FILE: &str = "recording.path";

/// Returns the identity of the report in a folder, if there is one.
pub fn id_in(dir: &Path) -> Option<String> {
    let text = std::fs::read_to_string(dir.join(VERDICT_FILE)).ok()?;
    let document: serde_json::Value = text.parse().ok()?;
    document["report_id"].as_str().map(String::from)
}

/// Returns the files of a report, names with bytes: `report.html`, each plot as `.svg`, the
/// series and `verdict.json`, the page first and the document last.
pub fn files(document: &Document, evidence: Option<&Evidence>) -> Vec<(String, Vec<u8>)> {
    let figures = plot::figures(document, evidence);
    let page = html::page(document, evidence, &figures);
    let mut files = vec![(REPORT_FILE.to_string(), page.into_bytes())];
    for figure in &figures {
        let name = format!("{}.svg", figure.name);
        files.push((name, figure.stand_alone().into_bytes()));
    }
    if let Some(evidence) = evidence {
        let table = series::csv(&evidence.series);
        files.push((SERIES_FILE.to_string(), table.into_bytes()));
    }
    files.push((
        VERDICT_FILE.to_string(),
        json::render(document).into_bytes(),
    ));
    files
}

/// As [`files`], without series that the page holds as well.
pub fn files_without_series(
    document: &Document,
    evidence: Option<&Evidence>,
) -> Vec<(String, Vec<u8>)> {
    let mut files = files(document, evidence);
    files.retain(|(name, bytes)| name != SERIES_FILE || bytes.len() > html::SERIES_BYTES);
    files
}

/// Writes the files of a report into `dir`, which is created if absent, in place of those of an earlier
/// report, and returns the paths, the page's first. A reader meets the earlier report, this one or
/// none. `recording` is the path that was replayed, kept for a later verification.
///
/// # Errors
///
/// [`ErrorKind::Io`](latchgate_recording::error::ErrorKind::Io) if `dir` cannot be made or a file not be replaced
/// or written.
pub fn write(
    dir: &Path,
    mut files: Vec<(String, Vec<u8>)>,
    recording: Option<&Path>,
) -> Result<Vec<PathBuf>, Error> {
    if let Some(path) = recording {
        let note = format!("{}\n", path.display());
        files.insert(1, (SOURCE_FILE.to_string(), note.into_bytes()));
    }
    folder::put(dir, &names(), &files)
}

/// Returns the name of every file that a report may hold.
pub fn names() -> Vec<String> {
    let plots = plot::NAMES.iter().map(|name| format!("{name}.svg"));
    [
        REPORT_FILE,
        PDF_FILE,
        VERDICT_FILE,
        SERIES_FILE,
        SOURCE_FILE,
    ]
    .into_iter()
    .map(String::from)
    .chain(plots)
    .collect()
}

/// Writes the page that shows verdicts side by side into `dir`, and returns its path. `tables` are their
/// series, where all have them.
///
/// # Errors
///
/// As [`write`].
pub fn write_comparison(
    dir: &Path,
    documents: &[&Document],
    tables: Option<&[SampledSeries]>,
    differences: &[differences::DifferingValue],
) -> Result<PathBuf, Error> {
    let page = html::overlay_page(documents, tables, differences);
    let files = [(COMPARE_FILE.to_string(), page.into_bytes())];
    let paths = folder::put(dir, &[COMPARE_FILE], &files)?;
    Ok(paths
        .into_iter()
        .next()
        .unwrap_or_else(|| dir.join(COMPARE_FILE)))
}
