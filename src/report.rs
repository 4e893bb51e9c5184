//! What people and scripts read: `report.html`, `verdict.json`, plots and the terminal's text.
//!
//! This module computes nothing: every number it shows stands in the [`Document`] or in the
//! [`Evidence`] first. Units are converted for display and long signals thinned for drawing,
//! no more. The time that a run took is shown nowhere but in `verdict.json`, so that the same
//! input gives the same bytes.
//!
//! - `document`: the documents that a replay answers with, block by block;
//! - `escape`: makes text from files safe to show: in markup and on a terminal;
//! - `html`: `report.html`: one file that opens offline, in light and dark, and prints on A4;
//! - `json`: `verdict.json`: the document, key by key, with all digits of its numbers;
//! - `margin`: what `latchgate margin` hands over: its text, and the files of its report;
//! - `margin_document`: the document that a margin answers with;
//! - `margin_words`: what the terminal and the page of a margin say of an answer in the same words;
//! - `number`: numbers for people: significant digits, true minus signs, powers of ten;
//! - `page`: what every page of ours begins and ends with;
//! - `plot`: plots in SVG: the same drawing stands inline in the report and alone in a file;
//! - `sparkline`: a signal in one line of a terminal;
//! - `study`: files of a study: rows as CSV, headline figures as JSON, a chart as SVG;
//! - `text`: the verdict for a terminal;
//! - `words`: words that the terminal and the page share.

pub mod document;
pub mod escape;
pub mod html;
pub mod json;
pub mod margin;
pub mod margin_document;
mod margin_words;
pub mod number;
pub mod page;
pub mod plot;
pub mod sparkline;
pub mod study;
pub mod text;
mod words;

use crate::error::{Error, ErrorKind, Place};
pub use document::Document;
pub use margin_document::MarginDocument;

use crate::verdict::Evidence;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// File name of the report.
pub const REPORT_FILE: &str = "report.html";

/// File name of the verdict.
pub const VERDICT_FILE: &str = "verdict.json";

/// Returns the files of a report, names with bytes: `report.html`, `verdict.json` and each plot as
/// `.svg`, the report first. Who keeps them decides where.
#[must_use]
pub fn files(document: &Document, evidence: Option<&Evidence>) -> Vec<(String, Vec<u8>)> {
    let figures = plot::figures(document, evidence);
    let page = html::page(document, evidence, &figures);
    let mut files = vec![
        (REPORT_FILE.to_string(), page.into_bytes()),
        (
            VERDICT_FILE.to_string(),
            json::render(document).into_bytes(),
        ),
    ];
    for figure in &figures {
        let name = format!("{}.svg", figure.name);
        files.push((name, figure.stand_alone().into_bytes()));
    }
    files
}

/// Writes [`files`] into `dir`, which is created if absent, and returns the paths, the report's
/// first.
///
/// Files of these names that an earlier run left in `dir` are removed before the first is
/// written, so that a run that fails half-way, or has less to draw, never leaves an older
/// verdict or plot beside a newer one.
///
/// # Errors
///
/// [`ErrorKind::Io`] if `dir` cannot be made or a file not be removed or written.
pub fn write(
    dir: &Path,
    document: &Document,
    evidence: Option<&Evidence>,
) -> Result<Vec<PathBuf>, Error> {
    let earlier: Vec<String> = [REPORT_FILE, VERDICT_FILE]
        .into_iter()
        .map(String::from)
        .chain(plot::NAMES.iter().map(|name| format!("{name}.svg")))
        .collect();
    replace(dir, &earlier, files(document, evidence))
}

/// Removes the files of an earlier report from `dir`, made if absent, then writes the new ones.
fn replace(
    dir: &Path,
    earlier: &[impl AsRef<Path>],
    files: Vec<(String, Vec<u8>)>,
) -> Result<Vec<PathBuf>, Error> {
    fs::create_dir_all(dir).map_err(|error| failed("make the report folder", dir, &error))?;
    for name in earlier {
        let path = dir.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(failed("replace the earlier report", &path, &error));
            }
            _ => {}
        }
    }
    let mut written = Vec::with_capacity(files.len());
    for (name, content) in files {
        let path = dir.join(name);
        fs::write(&path, content).map_err(|error| failed("write the report", &path, &error))?;
        written.push(path);
    }
    tracing::info!(dir = %dir.display(), files = written.len(), "report written");
    Ok(written)
}

fn failed(action: &'static str, path: &Path, error: &io::Error) -> Error {
    Error::from(ErrorKind::Io {
        action,
        reason: error.to_string(),
    })
    .at(Place::file(path.display().to_string()))
}
