//! `latchgate compare`: verdicts side by side, first in a sentence and a few rows, then key by key.

use super::failure::Failure;
use super::options::{Common, CompareArguments};
use super::output;
use super::values::OutputFormat;
use super::verify::{place, read};
use latchgate_document::Document;
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_recording::{Limits, read_within};
use latchgate_report::differences::{self, DifferingValue, short_value};
use latchgate_report::{comparison, escape, series, terminal};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Exit code for verdicts that differ.
const DIFFERENT: u8 = 1;

/// Longest value in a cell of a terminal [characters].
const CELL: usize = 36;

/// The document that `compare --format json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VerdictComparison {
    /// Values that differ.
    pub differences: Vec<DifferingValue>,
    /// The `report_id` of each verdict.
    pub report_ids: Vec<String>,
    /// True if no value differs.
    pub same: bool,
    /// `latchgate.compare/1`.
    pub schema: Cow<'static, str>,
}

/// A verdict as it was read.
struct Stored {
    keys: Map<String, Value>,
    document: Document,
}

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &CompareArguments, common: &Common) -> Result<u8, Failure> {
    let verdicts: Vec<Stored> = arguments
        .verdicts
        .iter()
        .map(|path| verdict(path))
        .collect::<Result<_, _>>()?;
    let keys: Vec<&Map<String, Value>> = verdicts.iter().map(|verdict| &verdict.keys).collect();
    let differences = differences::between(&keys);
    let written = (!arguments.no_report).then(|| page(arguments, &verdicts, &differences));
    let text = match common.format {
        OutputFormat::Json => latchgate_document::json::render(&VerdictComparison {
            differences: differences.clone(),
            report_ids: verdicts
                .iter()
                .map(|verdict| verdict.document.report_id.clone())
                .collect(),
            same: differences.is_empty(),
            schema: "latchgate.compare/1".into(),
        }),
        OutputFormat::Text => {
            let page = written.as_ref().and_then(|written| written.as_ref().ok());
            let line = page.map(|path| format!("page  {}\n", path.display()));
            text(&verdicts, &differences, common) + &line.unwrap_or_default()
        }
    };
    output::document(&text).map_err(Failure::Data)?;
    // After the answer, which is printed even if the page could not be written.
    written.transpose().map_err(Failure::Data)?;
    Ok(if differences.is_empty() { 0 } else { DIFFERENT })
}

/// Writes the page of the comparison, with the series beside the verdicts; returns its path.
fn page(
    arguments: &CompareArguments,
    verdicts: &[Stored],
    differences: &[DifferingValue],
) -> Result<PathBuf, Error> {
    let mut tables = Vec::new();
    for (path, verdict) in arguments.verdicts.iter().zip(verdicts) {
        let beside = path.with_file_name(latchgate_report::SERIES_FILE);
        // Without a nominal run nothing was replayed, and a series is that of an earlier report.
        if verdict.document.nominal.is_some() && beside.exists() {
            let shown = beside.display().to_string();
            let limit = ("text_bytes", Limits::default().text_bytes);
            let text = read_within(&beside, &shown, "read the series", limit)?;
            tables.push(series::from_csv(&text).map_err(|error| error.at(place(&beside)))?);
        }
    }
    let documents: Vec<&Document> = verdicts.iter().map(|verdict| &verdict.document).collect();
    let ids: Vec<String> = documents
        .iter()
        .map(|document| short(&document.report_id))
        .collect();
    let default = || Path::new("reports/out").join(format!("compare-{}", ids.join("-")));
    let folder = arguments.out.clone().unwrap_or_else(default);
    let tables = (tables.len() == documents.len()).then_some(&*tables);
    latchgate_report::write_comparison(&folder, &documents, tables, differences)
}

fn short(id: &str) -> String {
    id.chars().take(8).filter(char::is_ascii_hexdigit).collect()
}

/// Reads a verdict.
fn verdict(path: &Path) -> Result<Stored, Failure> {
    let refused = |expected: &str, found: String, hint: &str| {
        let error = Error::from(ErrorKind::Malformed {
            expected: expected.into(),
            found,
            hint: hint.into(),
        });
        Failure::Data(error.at(place(path)))
    };
    let bytes = read(path).map_err(Failure::Data)?;
    let stored: Option<Value> = serde_json::from_slice(&bytes).ok();
    match stored {
        Some(Value::Object(keys)) if keys.get("schema") == Some(&"latchgate.verdict/1".into()) => {
            let document = serde_json::from_value(Value::Object(keys.clone()));
            let document = document.map_err(|error| {
                refused(
                    "a verdict of this version",
                    error.to_string(),
                    "replay the recording again",
                )
            })?;
            Ok(Stored { keys, document })
        }
        _ => Err(refused(
            "a verdict",
            "something else".into(),
            "give a verdict.json that latchgate replay wrote",
        )),
    }
}

/// Returns a sentence on the change and its effect, a row for each answer and each input that differs, and with
/// `-v` every key.
fn text(verdicts: &[Stored], differences: &[DifferingValue], common: &Common) -> String {
    let documents: Vec<&Document> = verdicts.iter().map(|verdict| &verdict.document).collect();
    if differences.is_empty() {
        return format!("SAME  {}\n", comparison::subject(documents[0]));
    }
    let shown = |text: &str| escape::terminal(text).replace('\u{00A0}', " ");
    let width = output::look(common).width;
    let sentence = shown(&comparison::sentence(&documents));
    let mut out = format!("{}\n\n", terminal::wrapped(&sentence, width, 0));
    for (place, document) in documents.iter().enumerate() {
        let (letter, id) = (comparison::letter(place), short(&document.report_id));
        let subject = shown(&comparison::subject(document));
        let line = format!("  {letter}  {subject}, report {id}");
        out += &terminal::wrapped(&line, width, 5);
        out.push('\n');
    }
    let letters = (0..documents.len()).map(|place| comparison::letter(place).to_string());
    let mut rows = vec![
        [String::new()]
            .into_iter()
            .chain(letters.clone())
            .collect::<Vec<_>>(),
    ];
    for row in comparison::rows(&documents) {
        rows.push(
            [row.name]
                .iter()
                .chain(&row.values)
                .map(|cell| shown(cell))
                .collect(),
        );
    }
    out += &format!("\n{}", terminal::fitted_table(&rows, 1, width));
    if common.verbose == 0 {
        return out + &format!("\n{} keys differ; -v lists them\n", differences.len());
    }
    let head = ["part", "key"].map(String::from).into_iter().chain(letters);
    let mut rows = vec![head.collect::<Vec<_>>()];
    let mut part = "";
    for row in differences {
        let name = if row.part == part { "" } else { &*row.part };
        part = &*row.part;
        let values = row
            .values
            .iter()
            .map(|value| shown(&short_value(value, CELL)));
        rows.push(
            [name.to_string(), row.key.clone()]
                .into_iter()
                .chain(values)
                .collect(),
        );
    }
    out + "\n" + &terminal::fitted_table(&rows, 2, width)
}
