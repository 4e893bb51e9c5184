//! A verdict: the first block of its report, and what can be done with it here.

use super::{fields, layout, show};
use crate::app::{App, Parts};
use crate::auth::{Scope, Visitor};
use crate::http::verdicts::made_whole;
use crate::problem::{Placed, Problem};
use crate::store::{Deletion, StoreError, StoredResult};
use axum::extract::{Extension, State};
use latchgate::document::number::exact;
use latchgate::pipeline::{Answer, Document, PARAMETERS};
use latchgate::report::escape::terminal as line;
use latchgate::report::series::{self, SampledSeries};
use latchgate::report::{REPORT_FILE, SERIES_FILE, VERDICT_FILE, html as report};
use maud::{Markup, html};
use serde_json::{Map, Value};
use std::io::Read;

/// Bytes of a document that a page shows.
const DOCUMENT_BYTES: u64 = 8 << 20;

/// Bytes of a table of series that a page draws: some 150 000 samples.
pub(super) const SERIES_BYTES: u64 = 16 << 20;

/// Numbers of the design that a slider varies.
const VARIED: [&str; 4] = [
    "lever.preload_torque_nm",
    "lever.spring_stiffness_nm_per_rad",
    "lever.center_of_mass_m",
    "stop.restitution",
];

/// A verdict as pages show it.
pub(super) struct StoredVerdict {
    pub(super) result: StoredResult,
    /// The document, key by key.
    pub(super) keys: Map<String, Value>,
    /// What remains of its recording, where that was deleted.
    deletion: Option<Deletion>,
    /// `None` where another version wrote it.
    pub(super) document: Option<Document>,
    /// `None` where nothing was conditioned, or the table is too long.
    pub(super) series: Option<SampledSeries>,
}

/// Reads a verdict, its series unless that is longer than `series_bytes`.
pub(super) fn find(
    parts: &Parts,
    report_id: &str,
    series_bytes: u64,
) -> Result<StoredVerdict, Problem> {
    let missing = || Problem::not_found("such verdict");
    let result = parts.ledger.result(report_id)?.ok_or_else(missing)?;
    let text = read(parts, &result, VERDICT_FILE, DOCUMENT_BYTES)?.ok_or_else(missing)?;
    let damaged = |_| StoreError::Damaged {
        what: format!("the document of {report_id}"),
    };
    let keys: Map<String, Value> = serde_json::from_slice(&text).map_err(damaged)?;
    let table = read(parts, &result, SERIES_FILE, series_bytes)?;
    Ok(StoredVerdict {
        document: serde_json::from_value(Value::Object(keys.clone())).ok(),
        series: table.and_then(|table| series::from_csv(&table).ok()),
        deletion: parts.ledger.deletion(&result.recording)?,
        keys,
        result,
    })
}

/// Reads a file of a verdict; `None` where there is none, or it is longer than `bytes_max`.
fn read(
    parts: &Parts,
    result: &StoredResult,
    name: &str,
    bytes_max: u64,
) -> Result<Option<Vec<u8>>, StoreError> {
    let file = result
        .files
        .get(name)
        .filter(|file| file.bytes <= bytes_max);
    let Some(file) = file else {
        return Ok(None);
    };
    let mut bytes = Vec::new();
    parts.blobs.open(&file.sha256)?.read_to_end(&mut bytes)?;
    Ok(Some(bytes))
}

/// Shows a verdict.
pub(super) async fn page(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Placed(report_id): Placed<String>,
) -> Result<Markup, Problem> {
    let id = report_id.clone();
    let first_visitor = visitor.clone();
    let place = app.pages.acquire().await;
    let shown = app.apart(move |parts| Ok(drawn(&first_visitor, &find(parts, &id, SERIES_BYTES)?)));
    match shown.await {
        Err(problem) if problem.code == "damaged" => drop(place),
        shown => return shown,
    }
    made_whole(&app, &report_id).await?;
    let _place = app.pages.acquire().await;
    app.apart(move |parts| Ok(drawn(&visitor, &find(parts, &report_id, SERIES_BYTES)?)))
        .await
}

fn drawn(visitor: &Visitor, verdict: &StoredVerdict) -> Markup {
    let StoredVerdict {
        result,
        deletion,
        document,
        series,
        ..
    } = verdict;
    let summary = &result.summary;
    // What faulty samples come to under another lever says nothing.
    let usable = document
        .as_ref()
        .filter(|document| document.nominal.is_some() && document.verdict != Answer::Unusable)
        .filter(|_| deletion.is_none());
    let body = html! {
        (actions(result))
        @if let Some(deletion) = deletion {
            div.notice role="status" {
                "The recording was deleted on " (show::instant(deletion.deleted_ms)) " UTC by " (line(&deletion.by))
                ". Its samples and plots are gone. Upload it again to see them."
            }
        }
        @if let Some(document) = document {
            (report::first_block(document, series.as_ref()))
        } @else {
            h1 { (line(&summary.file)) }
            p { "Another version of latchgate wrote this verdict. Its report shows it." }
        }
        @if series.is_some() {
            script id="series" type="text/csv" data-from={ "/v1/verdicts/" (result.report_id) "/series.csv" } {}
            script src="/assets/event.js" defer {}
        } @else if result.files.contains_key("event.svg") {
            figure {
                img src={ "/v1/verdicts/" (result.report_id) "/event.svg" } alt="Acceleration, velocity and angle of the lever over time";
                figcaption { "The series is too long to be read off here; it can be downloaded." }
            }
        }
        @if let Some(document) = usable.filter(|_| visitor.may(Scope::Submit)) { (what_if(verdict, document)) }
        @if let Some(document) = document { (report::judged(document)) }
    };
    let title = format!("{} · {}", summary.verdict, summary.file);
    layout(Some(visitor), &title, &body)
}

/// Says when and by whom this was asked, and what can be had of it.
fn actions(result: &StoredResult) -> Markup {
    let base = format!("/v1/verdicts/{}", result.report_id);
    html! {
        p.asked {
            "Asked " (show::instant(result.created_ms)) " UTC"
            @if !result.asked_by.is_empty() { " by " strong { (line(&result.asked_by)) } }
            " · Design " strong { (line(&result.summary.full_design())) }
        }
        ul.actions {
            @if result.files.contains_key(REPORT_FILE) {
                li { a href={ (base) "/report.html" } { "Whole report" } }
                li { a href={ (base) "/report.html?download=true" } { "Download report (HTML)" } }
            }
            li { a href={ (base) "/verdict.json?download=true" } { "Document, every digit (JSON)" } }
            @if result.files.contains_key(SERIES_FILE) { li { a href={ (base) "/series.csv" } { "Series (CSV)" } } }
            li { a href={ "/recordings/" (result.recording) } { "Recording" } }
        }
    }
}

fn what_if(verdict: &StoredVerdict, document: &Document) -> Markup {
    let (request, design) = (&verdict.keys["request"], &verdict.keys["design"]);
    let advice = document.preload_answer.as_ref();
    let advice = advice.and_then(|advice| advice.safe_from);
    let varied = VARIED.map(|name| PARAMETERS.iter().find(|parameter| parameter.name == name));
    html! {
        section id="what-if" data-recording=(verdict.result.recording) data-request=(request) data-design=(design) {
            h2 { "What if" }
            p { "The nominal lever answers at once. Ask the varied levers before you decide." }
            div.fields {
                @for parameter in varied.into_iter().flatten() {
                    @let value = document.design.value(parameter);
                    @let advised = advice.filter(|_| parameter.name == VARIED[0]);
                    @let (low, high) = if parameter.unit == "1" { (0.0, 1.0) } else { slider_range(value, advised) };
                    @let id = parameter.key();
                    div.varied data-key=(parameter.name) data-low=(low) data-high=(high) data-unit=(fields::unit(parameter.unit).trim_start()) {
                        label for=(id) { (parameter.what) (fields::bracketed(parameter.unit)) }
                        input id=(id) inputmode="decimal" autocomplete="off" value=(value);
                        input type="range" min="0" max="1" step="any" aria-label=(parameter.what);
                        span.muted { "now " (exact(value)) @if let Some(advised) = advised { "; advice: " (exact(advised)) } }
                    }
                }
            }
            p id="what-if-told" role="status" { "Type a number or move a slider." }
            (fields::waiting("judging"))
            div id="what-if-card" {}
            p {
                button type="button" id="what-if-judge" disabled { "Judge with varied levers" } " "
                button type="button" id="what-if-back" disabled { "Back to this lever" }
            }
        }
    }
}

/// Returns where the slider of a number begins and ends: a tenth of it, twice the advice; around a zero as
/// the advice, or ten milliunits, would have it.
fn slider_range(value: f64, advice: Option<f64>) -> (f64, f64) {
    let values = [Some(value), advice].into_iter().flatten();
    let positive: Vec<f64> = values.filter(|value| *value > 0.0).collect();
    let smallest = positive.iter().copied().reduce(f64::min).unwrap_or(0.1);
    let largest = positive.iter().copied().reduce(f64::max).unwrap_or(0.5);
    // Without advice the search goes as far up as down.
    let reach = if advice.is_some() { 2.0 } else { 10.0 };
    (smallest / 10.0, largest * reach)
}
