//! Runs side by side: what differs between them, and their angles on one axis.

use super::verdict::{column, find};
use super::{Failed, show, whole};
use crate::app::App;
use crate::problem::Problem;
use axum::extract::{RawQuery, State};
use axum::http::StatusCode;
use maud::{Markup, html};
use serde_json::Value;
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

/// Compares the runs that the query names, the first being the one that the others are held against.
pub(super) async fn page(
    State(app): State<App>,
    RawQuery(query): RawQuery,
) -> Result<Markup, Failed> {
    let query = query.unwrap_or_default();
    let mut ids: Vec<&str> = Vec::new();
    for id in query.split('&').filter_map(|pair| pair.strip_prefix("id=")) {
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    if ids.is_empty() || ids.len() > RUNS {
        let text = format!("choose one to {RUNS} verdicts, {} were chosen", ids.len());
        return Err(Problem::new(
            StatusCode::BAD_REQUEST,
            "bad-request",
            "Nothing to compare",
            text,
        )
        .into());
    }
    let mut runs = Vec::new();
    for id in ids {
        runs.push(find(&app, id).await?);
    }
    let names: Vec<String> = runs
        .iter()
        .map(|(result, _)| {
            let summary = &result.summary;
            let design = summary.design_version.as_ref().unwrap_or(&summary.design);
            let changed = summary.modified.join(", ");
            let changed = if changed.is_empty() {
                changed
            } else {
                format!(" ({changed})")
            };
            let short = result.report_id.get(..8).unwrap_or("");
            format!("{} · {design}{changed} · {short}", summary.file)
        })
        .collect();
    let series: Vec<Value> = runs
        .iter()
        .zip(&names)
        .map(|((result, document), name)| {
            serde_json::json!({
                "id": result.report_id, "name": name, "column": column(document), "limit": document["threshold_rad"],
                "crossing_s": document["nominal"]["first_crossing_s"],
                "release_s": document["nominal"]["first_release_s"],
            })
        })
        .collect();
    let body = html! {
        h1 { "Runs side by side" }
        section id="compare" data-runs=(Value::Array(series).to_string()) {
            fieldset.fields { legend { "Aligned" }
                label { "at " select id="align" {
                    option value="zero" { "time zero" } option value="release" { "first release" } option value="hand" { "by hand" }
                } }
                span id="offsets" {}
            }
            div id="compare-motion" tabindex="0" role="group" aria-label="Angles of all runs over time; plus and minus zoom" { div id="plot-compare" {} }
            p.tools { button type="button" id="compare-whole" { "Whole record" } }
        }
        h2 { "What differs" }
        p { label { input type="checkbox" id="show-all"; " Show what is the same, too" } }
        (differences(&runs.iter().map(|(_, document)| document).collect::<Vec<_>>(), &names))
    };
    Ok(whole("Compare", &body))
}

fn differences(documents: &[&Value], names: &[String]) -> Markup {
    let flat: Vec<BTreeMap<String, String>> = documents
        .iter()
        .map(|document| flattened(document))
        .collect();
    let ids = documents
        .iter()
        .map(|document| document["report_id"].as_str().unwrap_or(""));
    let keys = |part: &str| -> BTreeSet<&String> {
        let belongs = |key: &&String| key.split('.').next() == Some(part);
        flat.iter()
            .flat_map(|values| values.keys().filter(belongs))
            .collect()
    };
    html! {
        div.wide tabindex="0" role="region" aria-label="What differs" {
            table id="differences" {
                thead { tr { th scope="col" { "Value" } @for (name, id) in names.iter().zip(ids) { th scope="col" { a href=(format!("/verdicts/{id}")) { (name) } } } } }
                tbody {
                    @for part in PARTS { @for key in keys(part) {
                        @let values: Vec<&str> = flat.iter().map(|values| values.get(key).map_or("–", String::as_str)).collect();
                        @let same = values.windows(2).all(|pair| pair[0] == pair[1]);
                        tr.same[same] hidden[same] {
                            th scope="row" { (key) }
                            @for value in &values { td.changed[*value != values[0]] { (value) } }
                        }
                    } }
                }
            }
        }
    }
}

/// Lists the plain values of the compared parts by their path.
fn flattened(document: &Value) -> BTreeMap<String, String> {
    fn walk(path: String, value: &Value, out: &mut BTreeMap<String, String>) {
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
                out.insert(path, show::value(plain));
            }
        }
    }
    let mut out = BTreeMap::new();
    for part in PARTS {
        walk((*part).into(), &document[*part], &mut out);
    }
    out
}
