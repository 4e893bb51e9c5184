//! What differs between verdicts, in a sentence and a few rows.

use super::{opening, words};
use latchgate_document::Document;
use latchgate_document::number::exact;
use latchgate_kernel::model::parameters::{CATCH_PARAMETERS, PARAMETERS};
use latchgate_verdict::Answer;
use serde_json::Value;
use std::collections::BTreeSet;

/// Largest number of verdicts compared.
pub const VERDICTS_MAX: usize = 8;

/// Largest number of inputs that the sentence names.
const NAMED_INPUTS: usize = 3;

/// A row of the comparison.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComparedRow {
    /// Name of the quantity, such as `largest angle`.
    pub name: String,
    /// Its value in words, one for each verdict.
    pub values: Vec<String>,
}

impl ComparedRow {
    fn of(
        name: impl Into<String>,
        documents: &[&Document],
        value: impl Fn(&Document) -> String,
    ) -> Self {
        Self {
            name: name.into(),
            values: documents.iter().map(|document| value(document)).collect(),
        }
    }

    fn differs(&self) -> bool {
        self.values.iter().any(|value| *value != self.values[0])
    }
}

/// Returns the letter of a verdict by its place: A, B and so on.
pub fn letter(place: usize) -> char {
    char::from(b'A' + u8::try_from(place).unwrap_or(0).min(25))
}

/// Returns what a verdict is of: recording, channel, design.
pub fn subject(document: &Document) -> String {
    let recording = &document.recording;
    let channel = recording.channel.as_ref();
    let channel = channel.map_or_else(String::new, |channel| format!(", channel {channel}"));
    let design = words::design(&document.design);
    format!("{}{channel}, design: {design}", recording.file)
}

/// Returns what was changed and its effect: `preload torque 0.1 → 5 N·m, all else equal: FAIL → PASS`.
pub fn sentence(documents: &[&Document]) -> String {
    let answers = ComparedRow::of("", documents, |document| {
        words::answer(document.verdict).into()
    });
    let inputs = inputs(documents);
    let answers = joined(&answers.values);
    match inputs.len() {
        0 => format!("The same question: {answers}."),
        1..=NAMED_INPUTS => {
            let named = inputs
                .iter()
                .map(|row| format!("{} {}", row.name, joined(&row.values)));
            let named: Vec<String> = named.collect();
            let named = words::capital(&named.join("; "));
            format!("{named}; all else equal: {answers}.")
        }
        many => format!("{many} inputs differ: {answers}."),
    }
}

fn joined(values: &[String]) -> String {
    if values.iter().all(|value| *value == values[0]) {
        return format!("{} in all", values[0]);
    }
    values.join(" → ")
}

/// Returns the answers of each, and the inputs that differ.
pub fn rows(documents: &[&Document]) -> Vec<ComparedRow> {
    let row =
        |name: &str, value: &dyn Fn(&Document) -> String| ComparedRow::of(name, documents, value);
    let mut rows = vec![
        row("verdict", &|document| {
            words::answer(document.verdict).into()
        }),
        row("largest angle", &largest_angle),
        row("opens", &opens),
        row("varied levers or readings that open", &varied),
        row("limit angle", &|document| {
            words::limit_angle(document.threshold_rad)
        }),
        row("opening direction", &direction),
    ];
    for input in inputs(documents) {
        if rows.iter().all(|row| row.name != input.name) {
            rows.push(input);
        }
    }
    rows
}

fn largest_angle(document: &Document) -> String {
    let usable = document.verdict != Answer::Unusable;
    let run = words::leading_run(document).filter(|_| usable);
    run.map_or_else(|| "–".into(), |run| words::short_peak(document, run))
}

fn opens(document: &Document) -> String {
    match (&document.opens, document.verdict) {
        (Some(opens), Answer::Undecided) => format!("perhaps {}", opening::cell(opens)),
        (Some(opens), _) => opening::cell(opens),
        (None, Answer::Unusable) => "–".into(),
        (None, _) => "stays".into(),
    }
}

fn varied(document: &Document) -> String {
    match &document.ensemble {
        Some(ensemble) => format!("{} of {}", ensemble.exceeded, ensemble.members),
        None if words::sparing_bound(document).is_some() => "none can".into(),
        None => "–".into(),
    }
}

fn direction(document: &Document) -> String {
    let declared = document.recording.opens_when;
    declared.map_or_else(|| "not declared".into(), |sign| sign.name().into())
}

/// Returns the inputs that differ: recording, direction, numbers of the design, settings.
fn inputs(documents: &[&Document]) -> Vec<ComparedRow> {
    let row =
        |name: &str, value: &dyn Fn(&Document) -> String| ComparedRow::of(name, documents, value);
    let mut rows = vec![
        row("recording", &|document| {
            let recording = &document.recording;
            let channel = recording.channel.as_ref();
            let channel = channel.map_or_else(String::new, |channel| format!(" ({channel})"));
            format!("{}{channel}", recording.file)
        }),
        row("content", &|document| {
            let hash = document.recording.content_sha256.as_ref();
            hash.map_or_else(|| "–".into(), |hash| hash.chars().take(8).collect())
        }),
        row("card", &|document| {
            let hash = document.recording.card_sha256.as_ref();
            hash.map_or_else(|| "none".into(), |hash| hash.chars().take(8).collect())
        }),
        row("opening direction", &direction),
    ];
    let has_catch = documents
        .iter()
        .any(|document| document.design.catch.is_some());
    let of_catch = if has_catch { CATCH_PARAMETERS } else { &[] };
    for parameter in PARAMETERS.iter().chain(of_catch) {
        let unit = match parameter.unit {
            "1" => String::new(),
            unit => format!("\u{00A0}{}", unit.replace(' ', "·")),
        };
        rows.push(row(
            parameter.noun,
            &|document| match document.design.value(parameter) {
                value if value.is_nan() => "no catch".into(),
                value => format!("{}{unit}", exact(value)),
            },
        ));
        rows.push(row(
            &format!("tolerance of the {}", parameter.noun),
            &|document| {
                let stated = document.design.tolerance.get(parameter.tolerance_key());
                stated.map_or_else(|| "none".into(), ToString::to_string)
            },
        ));
    }
    let settings: Vec<Value> = documents
        .iter()
        .map(|document| serde_json::to_value(&document.request).unwrap_or_default())
        .collect();
    let keys: BTreeSet<&String> = settings
        .iter()
        .filter_map(Value::as_object)
        .flat_map(|settings| settings.keys())
        .collect();
    for key in keys {
        // Rows above show both already.
        if ["channel", "opens_when"].contains(&key.as_str()) {
            continue;
        }
        let values = settings.iter().map(|settings| match &settings[key] {
            Value::Null => "default".to_string(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        });
        rows.push(ComparedRow {
            name: key.replace('_', " "),
            values: values.collect(),
        });
    }
    rows.retain(ComparedRow::differs);
    // Another channel has another hash, so its row would repeat that of the recording.
    if rows.iter().any(|row| row.name == "recording") {
        rows.retain(|row| row.name != "content");
    }
    rows
}
