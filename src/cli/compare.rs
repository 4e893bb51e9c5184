//! `latchgate compare`: two verdicts side by side, as far as they differ.

use super::failure::Failure;
use super::options::{Common, CompareArguments};
use super::output;
use super::values::OutputFormat;
use super::verify::{place, read};
use crate::error::{Error, ErrorKind};
use crate::report::{self, escape, number, terminal};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::path::Path;

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

/// A value that differs: the part it belongs to, its key, and what it is in each verdict.
struct Differing {
    part: &'static str,
    key: String,
    values: [Option<Value>; 2],
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
    let text = match common.format {
        OutputFormat::Json => {
            let rows: Vec<Value> = found
                .iter()
                .map(|row| {
                    let [one, other] = &row.values;
                    json!({"part": row.part, "key": row.key, "one": one, "other": other})
                })
                .collect();
            report::json::render(&json!({
                "schema": "latchgate.compare/1",
                "same": found.is_empty(),
                "report_ids": documents.each_ref().map(|document| &document["report_id"]),
                "differences": rows,
            }))
        }
        OutputFormat::Text => table(&found, &documents),
    };
    output::document(&text).map_err(Failure::Data)?;
    Ok(if found.is_empty() { 0 } else { DIFFERENT })
}

/// Reads a verdict.
fn verdict(path: &Path) -> Result<Map<String, Value>, Failure> {
    let bytes = read(path).map_err(Failure::Data)?;
    let document: Option<Value> = serde_json::from_slice(&bytes).ok();
    match document {
        Some(Value::Object(document)) if document["schema"] == "latchgate.verdict/1" => {
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

/// Notes the values that differ; lists are taken whole.
fn walk(part: &'static str, key: &str, values: [Option<&Value>; 2], found: &mut Vec<Differing>) {
    if let [Some(Value::Object(one)), Some(Value::Object(other))] = values {
        let keys: BTreeSet<&String> = one.keys().chain(other.keys()).collect();
        for inner in keys {
            let name = format!("{key}.{inner}");
            walk(part, &name, [one.get(inner), other.get(inner)], found);
        }
    } else if values[0] != values[1] {
        found.push(Differing {
            part,
            key: key.to_string(),
            values: values.map(Option::<&Value>::cloned),
        });
    }
}

fn table(found: &[Differing], documents: &[Map<String, Value>; 2]) -> String {
    let word = |index: usize, key: &str| documents[index][key].as_str().unwrap_or("–").to_string();
    let head = |index: usize| {
        let id: String = word(index, "report_id").chars().take(8).collect();
        format!("{} ({id})", word(index, "verdict").to_uppercase())
    };
    let mut rows = vec![vec![String::new(), String::new(), head(0), head(1)]];
    let mut part = "";
    for row in found {
        let name = if row.part == part { "" } else { row.part };
        part = row.part;
        let [one, other] = row.values.each_ref().map(|value| shown(value.as_ref()));
        rows.push(vec![name.into(), row.key.clone(), one, other]);
    }
    if found.is_empty() {
        return format!("SAME  {}\n", head(0));
    }
    terminal::table(&rows, &[])
}

/// Returns a value in a cell: numbers in six digits, lists by their length.
fn shown(value: Option<&Value>) -> String {
    const LETTERS: usize = 36;
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
    let short: String = text.chars().take(LETTERS).collect();
    let rest = if short.len() < text.len() { "…" } else { "" };
    format!("{}{rest}", escape::terminal(&short))
}
