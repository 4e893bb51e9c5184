//! Every key in which verdicts differ.

use latchgate_document::number;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Parts in the order shown: the head of each, and the keys of a verdict that belong to it.
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

/// A value that differs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DifferingValue {
    /// Its key, from the document's root.
    pub key: String,
    /// The part it belongs to: `recording`, `settings`, `design` or `results`.
    pub part: Cow<'static, str>,
    /// Its value in each verdict; null where the key is absent.
    pub values: Vec<Value>,
}

/// Lists the keys of verdicts whose values differ.
pub fn between(verdicts: &[&Map<String, Value>]) -> Vec<DifferingValue> {
    let mut differing = Vec::new();
    for (part, keys) in PARTS {
        for key in keys {
            let values = verdicts.iter().map(|verdict| verdict.get(*key)).collect();
            walk(part, key, values, &mut differing);
        }
    }
    differing
}

/// Adds the values that differ. A list is one value, except a list of entries with codes.
fn walk(
    part: &'static str,
    key: &str,
    values: Vec<Option<&Value>>,
    differing: &mut Vec<DifferingValue>,
) {
    let coded: Option<Vec<Value>> = values.iter().map(|value| by_code((*value)?)).collect();
    if let Some(coded) = coded {
        return walk(part, key, coded.iter().map(Some).collect(), differing);
    }
    let objects: Option<Vec<&Map<String, Value>>> =
        values.iter().map(|value| (*value)?.as_object()).collect();
    if let Some(objects) = objects {
        let keys: BTreeSet<&String> = objects.iter().flat_map(|object| object.keys()).collect();
        for inner in keys {
            let name = format!("{key}.{inner}");
            let values = objects.iter().map(|object| object.get(inner)).collect();
            walk(part, &name, values, differing);
        }
    } else if values.iter().any(|value| *value != values[0]) {
        differing.push(DifferingValue {
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
        let joined = match texts.get(code).and_then(Value::as_str) {
            Some(earlier) => format!("{earlier} {text}"),
            None => text.to_string(),
        };
        texts.insert(code.into(), joined.into());
    }
    Some(Value::Object(texts))
}

/// Returns a value in at most so many letters: numbers in six digits, long lists by their length.
pub fn short_value(value: &Value, letters: usize) -> String {
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
