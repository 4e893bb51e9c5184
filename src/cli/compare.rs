//! `latchgate compare`: verdicts side by side, first in a sentence and a few rows, then key by key.

use super::failure::Failure;
use super::options::{Common, CompareArguments};
use super::output;
use super::values::OutputFormat;
use super::verify::{place, read};
use latchgate_document::{Document, number};
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_recording::{Limits, read_within};
use latchgate_report::html::DifferenceRow;
use latchgate_report::series::SeriesTable;
use latchgate_report::{comparison, escape, terminal};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Exit code for verdicts that differ.
const DIFFERENT: u8 = 1;

/// What is shown, in this order: the head of a part, and the keys of a verdict that belong to it.
const PARTS: [(&str, &[&str]); 4] = [
    ("recording", &["recording", "test", "conditioning"]),
    ("settings", &["request"]),
    ("design", &["design", "threshold_rad"]),
    (
        "results",
        &[
            "verdict", "why", "nominal", "models", "ensemble", "findings",
        ],
    ),
];

/// The document that `compare --format json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VerdictComparison {
    /// What differs.
    pub differences: Vec<DifferingValue>,
    /// What names each verdict.
    pub report_ids: Vec<String>,
    /// Whether nothing does.
    pub same: bool,
    /// `latchgate.compare/1`.
    pub schema: Cow<'static, str>,
}

/// A value that differs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DifferingValue {
    /// Its key, from the document's root.
    pub key: String,
    /// The part it belongs to: `recording`, `settings`, `design` or `results`.
    pub part: Cow<'static, str>,
    /// In each verdict; null where the key is absent.
    pub values: Vec<Value>,
}

/// A verdict as it was read.
struct Stored {
    keys: Map<String, Value>,
    document: Document,
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &CompareArguments, common: &Common) -> Result<u8, Failure> {
    let verdicts: Vec<Stored> = own
        .verdicts
        .iter()
        .map(|path| verdict(path))
        .collect::<Result<_, _>>()?;
    let mut found = Vec::new();
    for (part, keys) in PARTS {
        for key in keys {
            let values = verdicts
                .iter()
                .map(|verdict| verdict.keys.get(*key))
                .collect();
            walk(part, key, values, &mut found);
        }
    }
    let written = (!own.no_report).then(|| page(own, &verdicts, &found));
    let text = match common.format {
        OutputFormat::Json => latchgate_document::json::render(&VerdictComparison {
            differences: found.clone(),
            report_ids: verdicts
                .iter()
                .map(|verdict| verdict.document.report_id.clone())
                .collect(),
            same: found.is_empty(),
            schema: "latchgate.compare/1".into(),
        }),
        OutputFormat::Text => {
            let page = written.as_ref().and_then(|written| written.as_ref().ok());
            let line = page.map(|path| format!("page  {}\n", path.display()));
            text(&verdicts, &found, common) + &line.unwrap_or_default()
        }
    };
    output::document(&text).map_err(Failure::Data)?;
    // What differs is told even where the page could not be written.
    written.transpose().map_err(Failure::Data)?;
    Ok(if found.is_empty() { 0 } else { DIFFERENT })
}

/// Writes the page of all, with the series that lie beside them; returns its path.
fn page(
    own: &CompareArguments,
    verdicts: &[Stored],
    found: &[DifferingValue],
) -> Result<PathBuf, Error> {
    let mut tables = Vec::new();
    for (path, verdict) in own.verdicts.iter().zip(verdicts) {
        let beside = path.with_file_name(latchgate_report::SERIES_FILE);
        // Nothing was replayed where there is no nominal run.
        if verdict.document.nominal.is_some() && beside.exists() {
            let shown = beside.display().to_string();
            let most = ("text_bytes", Limits::default().text_bytes);
            let text = read_within(&beside, &shown, "read the series", most)?;
            tables.push(SeriesTable::from_csv(&text).map_err(|error| error.at(place(&beside)))?);
        }
    }
    let rows: Vec<DifferenceRow> = found
        .iter()
        .map(|row| DifferenceRow {
            part: row.part.to_string(),
            key: row.key.clone(),
            values: row
                .values
                .iter()
                .map(|value| short_value(value, PAGE_CELL))
                .collect(),
        })
        .collect();
    let documents: Vec<&Document> = verdicts.iter().map(|verdict| &verdict.document).collect();
    let ids: Vec<String> = documents
        .iter()
        .map(|document| short(&document.report_id))
        .collect();
    let default = || Path::new("reports/out").join(format!("compare-{}", ids.join("-")));
    let folder = own.out.clone().unwrap_or_else(default);
    let tables = (tables.len() == documents.len()).then_some(&*tables);
    latchgate_report::write_comparison(&folder, &documents, tables, &rows)
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
                let found = error.to_string();
                refused(
                    "a verdict of this version",
                    found,
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

/// Notes the values that differ; lists are taken whole, but for those of what has a code.
fn walk(
    part: &'static str,
    key: &str,
    values: Vec<Option<&Value>>,
    found: &mut Vec<DifferingValue>,
) {
    let coded: Option<Vec<Value>> = values.iter().map(|value| by_code((*value)?)).collect();
    if let Some(coded) = coded {
        return walk(part, key, coded.iter().map(Some).collect(), found);
    }
    let objects: Option<Vec<&Map<String, Value>>> =
        values.iter().map(|value| (*value)?.as_object()).collect();
    if let Some(objects) = objects {
        let keys: BTreeSet<&String> = objects.iter().flat_map(|object| object.keys()).collect();
        for inner in keys {
            let name = format!("{key}.{inner}");
            let values = objects.iter().map(|object| object.get(inner)).collect();
            walk(part, &name, values, found);
        }
    } else if values.iter().any(|value| *value != values[0]) {
        found.push(DifferingValue {
            key: key.to_string(),
            part: part.into(),
            values: values
                .into_iter()
                .map(|value| value.cloned().unwrap_or_default())
                .collect(),
        });
    }
}

/// Returns a list of reasons or findings as a table of their texts by code.
fn by_code(list: &Value) -> Option<Value> {
    let mut texts: Map<String, Value> = Map::new();
    for entry in list.as_array()? {
        let (code, text) = (entry.get("code")?.as_str()?, entry.get("text")?.as_str()?);
        let all = match texts.get(code).and_then(Value::as_str) {
            Some(earlier) => format!("{earlier} {text}"),
            None => text.to_string(),
        };
        texts.insert(code.into(), all.into());
    }
    Some(Value::Object(texts))
}

/// Returns what was changed and what that did, a row for each answer and each input that differs, and, if asked
/// for, every key.
fn text(verdicts: &[Stored], found: &[DifferingValue], common: &Common) -> String {
    let documents: Vec<&Document> = verdicts.iter().map(|verdict| &verdict.document).collect();
    if found.is_empty() {
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
        return out + &format!("\n{} keys differ; -v lists them\n", found.len());
    }
    let head = ["part", "key"].map(String::from).into_iter().chain(letters);
    let mut rows = vec![head.collect::<Vec<_>>()];
    let mut part = "";
    for row in found {
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

/// Letters of a value in a cell of a terminal, and of the page.
const CELL: usize = 36;
const PAGE_CELL: usize = 400;

/// Returns a value in at most so many letters: numbers in six digits, long lists by their length.
fn short_value(value: &Value, letters: usize) -> String {
    let text = match value {
        Value::Null => "–".into(),
        Value::Number(number) => match number.as_f64() {
            Some(number) if number.fract() != 0.0 => number::plain(number, 6),
            _ => number.to_string(),
        },
        Value::String(text) => text.clone(),
        Value::Array(list) if list.len() > 3 => format!("{} entries", list.len()),
        other => other.to_string(),
    };
    let mut short: String = text.chars().take(letters).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
