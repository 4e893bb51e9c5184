//! A verdict against the same run made again: the first difference, and how many there are.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeSet;

/// What kind of difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DifferenceKind {
    /// The recording is another file.
    File,
    /// The card beside it is another, or only one of the runs had one.
    Card,
    /// Another version of latchgate made the verdict, and comes to something else.
    Version,
    /// The same version comes to something else on the same files.
    Result,
}

/// The first difference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Its kind.
    pub kind: DifferenceKind,
    /// Key, from the document's root.
    pub at: String,
    /// In the verdict; `None` where the key is absent.
    pub stored: Option<Value>,
    /// In the run made again.
    pub now: Option<Value>,
    /// In a sentence.
    pub text: String,
}

/// What the comparison found.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Comparison {
    /// The first difference, in the order from file to verdict to report; `None` if there is none.
    pub(super) first: Option<Difference>,
    /// Keys that differ.
    pub(super) differences: usize,
}

/// Keys of the document in the order in which a difference is told: what goes in comes before
/// what comes out, and the answer before what it rests on.
const ORDER: [&str; 10] = [
    "schema",
    "recording",
    "conditioning",
    "design",
    "request",
    "verdict",
    "threshold_rad",
    "nominal",
    "models",
    "answers",
];

/// Compares a stored document with the same run made again, key by key and number by number, to
/// the last digit; `run` alone may differ. With `renamed` the file's name may, too.
pub(super) fn compare(stored: &Value, now: &Value, renamed: bool) -> Comparison {
    let mut found = Vec::new();
    let empty = serde_json::Map::new();
    let (before, after) = (
        stored.as_object().unwrap_or(&empty),
        now.as_object().unwrap_or(&empty),
    );
    let mut keys: Vec<&str> = ORDER.to_vec();
    let known: BTreeSet<&str> = ORDER.into_iter().collect();
    let others: BTreeSet<&str> = before
        .keys()
        .chain(after.keys())
        .map(String::as_str)
        .collect();
    keys.extend(others.into_iter().filter(|key| !known.contains(key)));
    for key in keys.into_iter().filter(|key| *key != "run") {
        walk(key.to_string(), before.get(key), after.get(key), &mut found);
    }
    if renamed {
        found.retain(|(at, _, _)| at != "recording.file");
    }
    // Another file explains every other difference, and so does another card.
    let place = |(at, _, _): &(String, Option<Value>, Option<Value>)| match at.as_str() {
        "recording.sha256" => 0,
        part if part.starts_with("recording.parts") => 0,
        "recording.card_sha256" => 1,
        _ => 2,
    };
    found.sort_by_key(place);
    let version = |document: &Value| {
        document["run"]["version"]
            .as_str()
            .unwrap_or("unknown")
            .to_string()
    };
    let versions = (version(stored), version(now));
    Comparison {
        differences: found.len(),
        first: found
            .into_iter()
            .next()
            .map(|(at, stored, now)| told(at, stored, now, &versions)),
    }
}

fn walk(
    at: String,
    stored: Option<&Value>,
    now: Option<&Value>,
    found: &mut Vec<(String, Option<Value>, Option<Value>)>,
) {
    match (stored, now) {
        (Some(Value::Object(before)), Some(Value::Object(after))) => {
            let keys = before.keys().chain(after.keys());
            let keys: BTreeSet<&str> = keys.map(String::as_str).collect();
            for key in keys {
                walk(
                    format!("{at}.{key}"),
                    before.get(key),
                    after.get(key),
                    found,
                );
            }
        }
        (Some(Value::Array(before)), Some(Value::Array(after))) => {
            for index in 0..before.len().max(after.len()) {
                let at = format!("{at}[{index}]");
                walk(at, before.get(index), after.get(index), found);
            }
        }
        (Some(before), Some(after)) if before == after => {}
        (None, None) => {}
        _ => found.push((at, stored.cloned(), now.cloned())),
    }
}

fn told(
    at: String,
    stored: Option<Value>,
    now: Option<Value>,
    versions: &(String, String),
) -> Difference {
    let words = |value: &Option<Value>| match value {
        None => "absent".to_string(),
        Some(Value::String(text)) => text.clone(),
        Some(other) => {
            let text = other.to_string();
            if text.chars().count() > 120 {
                format!("{}…", text.chars().take(120).collect::<String>())
            } else {
                text
            }
        }
    };
    let (before, after) = (words(&stored), words(&now));
    let (kind, text) = match at.as_str() {
        "recording.sha256" => (
            DifferenceKind::File,
            format!(
                "The recording is another file: its SHA-256 is {after}, in the verdict {before}."
            ),
        ),
        part if part.starts_with("recording.parts") => (
            DifferenceKind::File,
            format!(
                "A file beside the recording has changed, first in {at}: {before} in the verdict, \
                 {after} now."
            ),
        ),
        "recording.card_sha256" => (
            DifferenceKind::Card,
            format!(
                "The card beside the recording has changed: its SHA-256 is {after}, in the verdict \
                 {before}."
            ),
        ),
        _ if versions.0 != versions.1 => (
            DifferenceKind::Version,
            format!(
                "The verdict is by version {}, this is {}. The first difference is {at}: {before} \
                 in the verdict, {after} now.",
                versions.0, versions.1
            ),
        ),
        _ => (
            DifferenceKind::Result,
            format!(
                "The same file gives another result, first in {at}: {before} in the verdict, {after} now."
            ),
        ),
    };
    Difference {
        kind,
        at,
        stored,
        now,
        text,
    }
}
