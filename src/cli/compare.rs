//! `latchgate compare`: two verdicts side by side, as far as they differ.

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
use latchgate_report::{escape, terminal};
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
    pub report_ids: [Option<String>; 2],
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
    /// In the one verdict; `None` where the key is absent or null.
    pub one: Option<Value>,
    /// In the other.
    pub other: Option<Value>,
    /// The part it belongs to: `recording`, `settings`, `design` or `results`.
    pub part: Cow<'static, str>,
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &CompareArguments, common: &Common) -> Result<u8, Failure> {
    let documents = [verdict(&own.one)?, verdict(&own.other)?];
    let mut found = Vec::new();
    for (part, keys) in PARTS {
        for key in keys {
            let values = documents.each_ref().map(|document| document.get(*key));
            walk(part, key, values, &mut found);
        }
    }
    let written = (!own.no_report).then(|| page(own, &documents, &found));
    let text = match common.format {
        OutputFormat::Json => {
            let id = |document: &Map<String, Value>| {
                document.get("report_id")?.as_str().map(String::from)
            };
            latchgate_document::json::render(&VerdictComparison {
                differences: found.clone(),
                report_ids: documents.each_ref().map(id),
                same: found.is_empty(),
                schema: "latchgate.compare/1".into(),
            })
        }
        OutputFormat::Text => {
            let page = written.as_ref().and_then(|written| written.as_ref().ok());
            let line = page.map(|path| format!("page  {}\n", path.display()));
            table(&found, &documents) + &line.unwrap_or_default()
        }
    };
    output::document(&text).map_err(Failure::Data)?;
    // What differs is told even where the page could not be written.
    written.transpose().map_err(Failure::Data)?;
    Ok(if found.is_empty() { 0 } else { DIFFERENT })
}

/// Writes the page of both, with the series that lie beside them; returns its path.
fn page(
    own: &CompareArguments,
    verdicts: &[Map<String, Value>; 2],
    found: &[DifferingValue],
) -> Result<PathBuf, Error> {
    let paths = [&own.one, &own.other];
    let mut documents = Vec::new();
    let mut tables = Vec::new();
    for (path, verdict) in paths.into_iter().zip(verdicts) {
        let document: Document =
            serde_json::from_value(Value::Object(verdict.clone())).map_err(|error| {
                Error::from(ErrorKind::Malformed {
                    expected: "a verdict of this version, for the page".into(),
                    found: error.to_string(),
                    hint: "replay the recording again".into(),
                })
                .at(place(path))
            })?;
        let beside = path.with_file_name(latchgate_report::SERIES_FILE);
        // Nothing was replayed where there is no nominal run.
        if document.nominal.is_some() && beside.exists() {
            let shown = beside.display().to_string();
            let most = ("text_bytes", Limits::default().text_bytes);
            let text = read_within(&beside, &shown, "read the series", most)?;
            tables.push(SeriesTable::from_csv(&text).map_err(|error| error.at(place(&beside)))?);
        }
        documents.push(document);
    }
    let rows: Vec<DifferenceRow> = found
        .iter()
        .map(|row| DifferenceRow {
            part: row.part.to_string(),
            key: row.key.clone(),
            values: [&row.one, &row.other].map(|value| short_value(value.as_ref(), PAGE_CELL)),
        })
        .collect();
    let ids = [&documents[0], &documents[1]].map(|document| short(&document.report_id));
    let default = || Path::new("reports/out").join(format!("compare-{}-{}", ids[0], ids[1]));
    let folder = own.out.clone().unwrap_or_else(default);
    let tables = <[SeriesTable; 2]>::try_from(tables).ok();
    let tables = tables.as_ref().map(|tables| tables.each_ref());
    latchgate_report::write_comparison(&folder, [&documents[0], &documents[1]], tables, &rows)
}

fn short(id: &str) -> String {
    id.chars().take(8).filter(char::is_ascii_hexdigit).collect()
}

/// Returns the text of a key; of one that is absent or no text, nothing.
fn text_at<'a>(document: &'a Map<String, Value>, key: &str) -> &'a str {
    document.get(key).and_then(Value::as_str).unwrap_or("")
}

/// Reads a verdict.
fn verdict(path: &Path) -> Result<Map<String, Value>, Failure> {
    let bytes = read(path).map_err(Failure::Data)?;
    let document: Option<Value> = serde_json::from_slice(&bytes).ok();
    match document {
        Some(Value::Object(document)) if text_at(&document, "schema") == "latchgate.verdict/1" => {
            Ok(document)
        }
        _ => Err(Failure::Data(
            Error::from(ErrorKind::Malformed {
                expected: "a verdict".into(),
                found: "something else".into(),
                hint: "give the verdict.json that latchgate replay wrote".into(),
            })
            .at(place(path)),
        )),
    }
}

/// Notes the values that differ; lists are taken whole, but for those of what has a code.
fn walk(
    part: &'static str,
    key: &str,
    values: [Option<&Value>; 2],
    found: &mut Vec<DifferingValue>,
) {
    if let [Some(one), Some(other)] = values.map(|value| value.and_then(by_code)) {
        walk(part, key, [Some(&one), Some(&other)], found);
    } else if let [Some(Value::Object(one)), Some(Value::Object(other))] = values {
        let keys: BTreeSet<&String> = one.keys().chain(other.keys()).collect();
        for inner in keys {
            let name = format!("{key}.{inner}");
            walk(part, &name, [one.get(inner), other.get(inner)], found);
        }
    } else if values[0] != values[1] {
        let [one, other] = values.map(Option::<&Value>::cloned);
        found.push(DifferingValue {
            key: key.to_string(),
            one,
            other,
            part: part.into(),
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

fn table(found: &[DifferingValue], documents: &[Map<String, Value>; 2]) -> String {
    let head = |index: usize| {
        let document: &Map<String, Value> = &documents[index];
        let answer = match text_at(document, "verdict") {
            "" => "–".to_string(),
            answer => answer.to_uppercase(),
        };
        format!("{answer} ({})", short(text_at(document, "report_id")))
    };
    let mut rows = vec![vec![String::new(), String::new(), head(0), head(1)]];
    let mut part = "";
    for row in found {
        let name = if row.part == part { "" } else { &*row.part };
        part = &*row.part;
        let [one, other] = [&row.one, &row.other]
            .map(|value| escape::terminal(&short_value(value.as_ref(), CELL)).into_owned());
        rows.push(vec![name.into(), row.key.clone(), one, other]);
    }
    if found.is_empty() {
        return format!("SAME  {}\n", head(0));
    }
    terminal::table(&rows, &[])
}

/// Letters of a value in a cell of a terminal, and of the page.
const CELL: usize = 36;
const PAGE_CELL: usize = 400;

/// Returns a value in at most so many letters: numbers in six digits, long lists by their length.
fn short_value(value: Option<&Value>, letters: usize) -> String {
    let text = match value {
        None | Some(Value::Null) => "–".into(),
        Some(Value::Number(number)) => match number.as_f64() {
            Some(number) if number.fract() != 0.0 => number::plain(number, 6),
            _ => number.to_string(),
        },
        Some(Value::String(text)) => text.clone(),
        Some(Value::Array(list)) if list.len() > 3 => format!("{} entries", list.len()),
        Some(other) => other.to_string(),
    };
    let mut short: String = text.chars().take(letters).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
