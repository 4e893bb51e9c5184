//! Runs side by side: what differs between them, and their angles on one axis.

use super::verdict::{column, find, stage};
use super::{show, whole};
use crate::app::App;
use crate::problem::Problem;
use axum::extract::{RawQuery, State};
use latchgate::document::number;
use maud::{Markup, html};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Runs that are compared at most.
const RUNS: usize = 8;

/// Parts of a document that are compared, in the order in which they are shown.
const PARTS: &[&str] = &[
    "verdict",
    "recording",
    "request",
    "design",
    "conditioning",
    "threshold_rad",
    "nominal",
    "ensemble",
    "error_budget_rad",
];

/// Compares the runs that the query names; the others are held against `baseline`, or the first.
pub(super) async fn page(
    State(app): State<App>,
    RawQuery(query): RawQuery,
) -> Result<Markup, Problem> {
    let query = query.unwrap_or_default();
    let named = |key: &'static str| {
        let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
        pairs
            .filter(move |(name, _)| *name == key)
            .map(|(_, id)| id)
    };
    let mut ids: Vec<&str> = Vec::new();
    for id in named("id") {
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    if ids.is_empty() || ids.len() > RUNS {
        let text = format!("choose one to {RUNS} verdicts, {} were chosen", ids.len());
        return Err(Problem::bad_request(text));
    }
    let baseline = named("baseline").next_back();
    ids.sort_by_key(|id| Some(*id) != baseline);
    let mut runs = Vec::new();
    for id in ids {
        let (result, document) = find(&app, id).await?;
        let short = result.report_id.get(..8).unwrap_or("");
        let summary = &result.summary;
        runs.push(ComparedRun {
            name: format!("{} · {} · {short}", summary.file, summary.full_design()),
            id: result.report_id.clone(),
            document,
        });
    }
    let plain = runs.iter().map(|run| {
        let nominal = &run.document["nominal"];
        json!({
            "id": run.id, "name": run.name, "column": column(nominal),
            "limit": run.document["threshold_rad"], "release_s": nominal["first_release_s"],
        })
    });
    let plain = Value::Array(plain.collect());
    let body = html! {
        h1 { "Runs side by side" }
        section id="compare" data-runs=(plain.to_string()) {
            fieldset.fields { legend { "Aligned" }
                label { "at " select id="align" {
                    option value="zero" { "time zero" } option value="trigger" { "a trigger" }
                    option value="release" { "first release" } option value="hand" { "by hand" }
                } }
                label { "Acceleration that triggers [m/s²] " input id="level" type="number" min="0" step="any" value="50"; }
                span id="offsets" {}
                p id="align-told" role="status" {}
            }
            (stage(false))
            (cursors(&runs))
        }
        h2 { "What differs" }
        form.fields method="get" action="/compare" {
            @for run in &runs { input type="hidden" name="id" value=(run.id); }
            label { "Held against " select name="baseline" { @for run in &runs { option value=(run.id) { (run.name) } } } }
            button { "Compare" }
        }
        p { label { input type="checkbox" id="show-all"; " Show what is the same, too" } }
        (differences(&runs))
    };
    Ok(whole("Compare", &body))
}

/// A run with the name that tells it from the others.
struct ComparedRun {
    id: String,
    name: String,
    document: Value,
}

/// What each run does at the cursors, filled in by the script.
fn cursors(runs: &[ComparedRun]) -> Markup {
    html! {
        div.wide tabindex="0" role="region" aria-label="Cursors" {
            table id="cursors" { caption { "Cursors" }
                thead { tr { th scope="col" { "Run" } th scope="col" { "Angle at A" } th scope="col" { "Angle at B" } th scope="col" { "Δφ" }
                    th scope="col" { "Acceleration at A" } th scope="col" { "at B" } } }
                tbody {
                    tr { th scope="row" { "Time" } td id="a-time" { "–" } td id="b-time" { "–" } td id="d-time" { "–" } td {} td {} }
                    @for (index, run) in runs.iter().enumerate() { tr {
                        th scope="row" { (run.name) }
                        @for cell in ["a-angle", "b-angle", "d-angle", "a-acceleration", "b-acceleration"] { td id=(format!("{cell}-{index}")) { "–" } }
                    } }
                }
            }
        }
    }
}

/// Lists what differs; the first run is the one that the others are held against.
fn differences(runs: &[ComparedRun]) -> Markup {
    let flat: Vec<BTreeMap<String, &Value>> =
        runs.iter().map(|run| flattened(&run.document)).collect();
    let keys = |part: &str| -> BTreeSet<&String> {
        let belongs = |key: &&String| key.split('.').next() == Some(part);
        flat.iter()
            .flat_map(|values| values.keys().filter(belongs))
            .collect()
    };
    html! {
        div.wide tabindex="0" role="region" aria-label="What differs" {
            table id="differences" {
                thead { tr { th scope="col" { "Value" } @for (index, run) in runs.iter().enumerate() {
                    th scope="col" { a href=(format!("/verdicts/{}", run.id)) { (run.name) } @if index == 0 { " (baseline)" } }
                } } }
                tbody {
                    @for part in PARTS { @for key in keys(part) {
                        @let values: Vec<Option<&Value>> = flat.iter().map(|values| values.get(key).copied()).collect();
                        @let same = values.windows(2).all(|pair| pair[0] == pair[1]);
                        tr.same[same] hidden[same] {
                            th scope="row" { (key) }
                            @for value in &values { td.changed[*value != values[0]] { (shown(*value, values[0])) } }
                        }
                    } }
                }
            }
        }
    }
}

/// Shows a value, and how far a number is from that of the baseline.
fn shown(value: Option<&Value>, baseline: Option<&Value>) -> String {
    let text = value.map_or_else(|| number::ABSENT.into(), show::value);
    let numbers = value
        .and_then(Value::as_f64)
        .zip(baseline.and_then(Value::as_f64));
    match numbers {
        Some((own, base)) if own > base => {
            format!("{text} (+{})", number::significant(own - base, 3))
        }
        Some((own, base)) if own < base => {
            format!("{text} (−{})", number::significant(base - own, 3))
        }
        _ => text,
    }
}

/// Lists the plain values of the compared parts by their path.
fn flattened(document: &Value) -> BTreeMap<String, &Value> {
    fn walk<'a>(path: String, value: &'a Value, out: &mut BTreeMap<String, &'a Value>) {
        match value {
            Value::Object(table) => {
                for (key, value) in table {
                    walk(format!("{path}.{key}"), value, out);
                }
            }
            Value::Array(list)
                if list
                    .iter()
                    .any(|entry| entry.is_array() || entry.is_object()) => {}
            plain => {
                out.insert(path, plain);
            }
        }
    }
    let mut out = BTreeMap::new();
    for part in PARTS {
        walk((*part).into(), &document[*part], &mut out);
    }
    out
}
