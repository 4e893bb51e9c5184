//! A verdict with its plots, cursors and what-if.

use super::recording::findings;
use super::{show, whole};
use crate::app::App;
use crate::problem::{Placed, Problem, for_http};
use crate::store::{StoreError, StoredResult};
use axum::extract::State;
use latchgate::pipeline::PASS_SHARE_MAX;
use latchgate::report::VERDICT_FILE;
use maud::{Markup, html};
use serde_json::{Map, Value, json};
use std::io::Read;

/// Bytes of a document that a page shows.
const DOCUMENT_BYTES: u64 = 8 << 20;

/// What can be varied: key of the design, label, unit, least and largest share of its value.
const VARIED: &[(&str, &str, &str, f64, f64)] = &[
    ("lever.preload_torque_nm", "Preload", "N·m", 0.0, 4.0),
    (
        "lever.spring_stiffness_nm_per_rad",
        "Spring stiffness",
        "N·m/rad",
        0.0,
        4.0,
    ),
    (
        "lever.center_of_mass_m",
        "Unbalance, by its arm",
        "m",
        0.0,
        2.0,
    ),
    ("stop.restitution", "Restitution", "–", 0.0, 1.0),
];

/// Finds a verdict and its document.
pub(super) async fn find(app: &App, report_id: &str) -> Result<(StoredResult, Value), Problem> {
    let wanted = report_id.to_string();
    let found = app
        .on_disk(move |parts| {
            let Some(result) = parts.ledger.result(&wanted)? else {
                return Ok(None);
            };
            let Some(file) = result
                .files
                .get(VERDICT_FILE)
                .filter(|file| file.bytes <= DOCUMENT_BYTES)
            else {
                return Ok(None);
            };
            let mut text = String::new();
            parts.blobs.open(&file.sha256)?.read_to_string(&mut text)?;
            let damaged = |_| StoreError::Damaged {
                what: format!("the document of {wanted}"),
            };
            let document = serde_json::from_str::<Value>(&text).map_err(damaged)?;
            Ok(Some((result, document)))
        })
        .await?;
    found.ok_or_else(|| Problem::not_found("such verdict"))
}

/// Shows a verdict.
pub(super) async fn page(
    State(app): State<App>,
    Placed(report_id): Placed<String>,
) -> Result<Markup, Problem> {
    let (result, document) = find(&app, &report_id).await?;
    let summary = &result.summary;
    let base = format!("/v1/verdicts/{report_id}");
    let body = html! {
        h1 { (summary.file) " · " (summary.channel.as_deref().unwrap_or("no channel")) }
        p.muted {
            "Design " strong { (summary.full_design()) }
            " · report " code { (report_id.get(..8).unwrap_or("")) }
            " · " a href=(format!("/recordings/{}", result.recording)) { "the recording" }
        }
        (card(&document))
        @if document["nominal"].is_object() { (plots(&base, &report_id, &document)) }
        @if document["nominal"].is_object() { (what_if(&result, &document)) }
        (findings("Findings", &document["findings"]))
        h2 { "Whole report" }
        ul {
            li { a href=(format!("{base}/report.html")) { "Open the report" } " · " a href=(format!("{base}/report.html?download=true")) { "download it (HTML)" } }
            li { a href=(format!("{base}/verdict.json?download=true")) { "The document, every digit (JSON)" } }
            @if result.files.contains_key("series.csv") { li { a href=(format!("{base}/series.csv")) { "The whole series (CSV)" } } }
        }
    };
    let title = format!("{} · {}", summary.verdict, summary.file);
    Ok(whole(&title, &body))
}

/// The verdict in plain words, with the limit beside every number that is held against it.
fn card(document: &Value) -> Markup {
    let word = document["verdict"].as_str().unwrap_or("unusable");
    let limit = document["threshold_rad"].as_f64();
    let nominal = &document["nominal"];
    let meaning = match word {
        "pass" => "The lever stays below the limit angle, uncertainty included.",
        "fail" => "The lever opens: it crosses the limit angle.",
        "undecided" => "What is known does not decide whether the lever stays or opens.",
        _ => "The recording cannot carry an answer.",
    };
    html! {
        section.card.(word) aria-label="Verdict" {
            p.answer { (show::verdict(word)) }
            p { (meaning) }
            ul { @for reason in document["why"].as_array().into_iter().flatten() {
                li { (for_http(reason["text"].as_str().unwrap_or(""))) }
            } }
            @if word != "unusable" { dl { (numbers(document, nominal, limit)) } }
        }
    }
}

fn numbers(document: &Value, nominal: &Value, limit: Option<f64>) -> Markup {
    let part = |name: &str| document["error_budget_rad"][name].as_f64().unwrap_or(0.0);
    let error = part("numerical") + part("interpolation") + 2.0 * part("noise");
    let against = format!("limit {}", show::angle(limit));
    let ensemble = &document["ensemble"];
    let percent = |value: &Value| {
        value.as_f64().map_or("–".into(), |share| {
            format!(
                "{} %",
                latchgate::document::number::significant(100.0 * share, 2)
            )
        })
    };
    html! {
        @if let Some(peak) = nominal["peak_angle_rad"].as_f64() {
            dt { "Peak angle of the nominal lever" } dd { (show::peak(peak, error)) " · " (against) }
        }
        @if let Some(coast) = nominal["coast_peak_angle_rad"].as_f64() {
            dt { "Largest angle after the record" } dd { (show::angle(Some(coast))) " · " (against) }
        }
        @if let Some(first) = nominal["first_crossing_s"].as_f64() {
            dt { "Crosses the limit at" } dd { (latchgate::document::number::milliseconds(first, 4)) " ms" }
        }
        @if ensemble.is_object() {
            dt { "Levers of the ensemble that cross" }
            dd { (show::value(&ensemble["exceeded"])) " of " (show::value(&ensemble["members"])) ", at most "
                (percent(&ensemble["p_upper"])) " · limit "
                (latchgate::document::number::trimmed(100.0 * PASS_SHARE_MAX, 2)) " % for a pass" }
        }
    }
}

/// Names the column of the series that holds the angle of a run.
pub(super) fn column(run: &Value) -> String {
    let word = |key: &str| run[key].as_str().unwrap_or("");
    format!("angle_{}_{}_rad", word("model"), word("opens_when"))
}

/// Two plots on one axis of time, drawn by the script, with their buttons.
pub(super) fn stage(one_run: bool) -> Markup {
    html! {
        div.tools role="toolbar" aria-label="Plots" {
            button type="button" data-do="a" { "Cursor A" } button type="button" data-do="b" { "Cursor B" }
            button type="button" data-do="clear" { "No cursors" }
            button type="button" data-do="in" { "Zoom in" } button type="button" data-do="out" { "Zoom out" }
            button type="button" data-do="whole" { "Whole record" }
            @if one_run { button type="button" data-do="csv" { "CSV of this range" } }
            button type="button" data-do="svg" { "SVG" } button type="button" data-do="png" { "PNG" }
            button type="button" data-do="link" { "Copy the link" }
        }
        div id="motion" tabindex="0" role="group" aria-label="Plots of acceleration and angle over time; arrow keys move the cursor chosen last, with shift farther; a and b set cursors, plus and minus zoom" {
            div id="plot-acceleration" {} div id="plot-angle" {}
        }
    }
}

/// What happened over time: plots, cursors, uncertainty.
fn plots(base: &str, report_id: &str, document: &Value) -> Markup {
    // U of each run, by the column that holds its angle.
    let answers = document["answers"].as_array().into_iter().flatten();
    let errors: Map<String, Value> = answers
        .map(|answer| (column(answer), answer["uncertainty_rad"].clone()))
        .collect();
    let peaks = &document["ensemble"]["peak_angle_rad"];
    let range = peaks["p05"].as_f64().zip(peaks["p95"].as_f64());
    html! {
        section id="plots" data-run=(column(&document["nominal"])) data-base=(base) data-report=(report_id) data-limit=(show::value(&document["threshold_rad"]))
            data-errors=(Value::Object(errors).to_string()) data-range=(json!(range).to_string()) {
            h2 { "What happened" }
            (stage(true))
            fieldset id="columns" { legend { "Shown" } }
            table id="cursors" { caption { "Cursors" }
                thead { tr { th scope="col" { "Cursor" } th scope="col" { "Time" } th scope="col" id="cursor-angle" { "Angle" } th scope="col" { "Acceleration as used" } } }
                tbody {
                    tr { th scope="row" { "A" } td id="a-time" { "–" } td id="a-angle" { "–" } td id="a-acceleration" { "–" } }
                    tr { th scope="row" { "B" } td id="b-time" { "–" } td id="b-angle" { "–" } td id="b-acceleration" { "–" } }
                    tr { th scope="row" { "Δ" } td id="d-time" { "–" } td id="d-angle" { "–" } td id="d-acceleration" { "–" } }
                }
            }
            p.muted {
                "Limit angle " (show::angle(document["threshold_rad"].as_f64())) " as a dashed line; the band around each angle is the uncertainty of its computation"
                @if let Some((low, high)) = range { ", the level band the peaks of 90 % of the scattered levers, " (show::angle(Some(low))) " to " (show::angle(Some(high))) }
                "."
            }
        }
    }
}

fn what_if(result: &StoredResult, document: &Value) -> Markup {
    let design = &document["design"];
    html! {
        section id="what-if" data-recording=(result.recording) data-request=(document["request"].to_string()) data-design=(design.to_string()) {
            h2 { "What if" }
            p { "Answers of the " strong { "nominal" } " lever alone, until the ensemble has answered." }
            div.fields {
                @for (key, label, unit, least, largest) in VARIED {
                    @let (table, name) = key.split_once('.').unwrap_or(("", ""));
                    @let value = design[table][name].as_f64().unwrap_or(0.0);
                    @let top = if *key == "stop.restitution" { 1.0 } else { (value * largest).max(0.01) };
                    label { (label) " "
                        input type="range" data-key=(key) data-was=(value.to_string()) min=(value * least) max=(top) step="any" value=(value);
                        output { (latchgate::document::number::significant(value, 4)) " " (unit) }
                    }
                }
            }
            p id="what-if-told" role="status" { "Move a slider." }
            p { button type="button" id="what-if-judge" disabled { "Judge with the ensemble" } }
        }
    }
}
