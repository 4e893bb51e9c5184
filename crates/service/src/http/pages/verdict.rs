//! A verdict: the first block of its report, and what can be done with it here.

use super::whole;
use crate::app::{App, Parts};
use crate::http::verdicts::made_whole;
use crate::problem::{Placed, Problem};
use crate::store::{StoreError, StoredResult};
use axum::extract::State;
use latchgate::document::number::trimmed;
use latchgate::pipeline::Document;
use latchgate::report::series::{self, SampledSeries};
use latchgate::report::{SERIES_FILE, VERDICT_FILE, html as report};
use maud::{Markup, html};
use serde_json::{Map, Value};
use std::io::Read;

/// Bytes of a document that a page shows.
const DOCUMENT_BYTES: u64 = 8 << 20;

/// Bytes of a table of series that a page draws: some 150 000 samples.
const SERIES_BYTES: u64 = 16 << 20;

/// What can be varied: key of the design, label, unit, largest share of its value.
const VARIED: &[(&str, &str, &str, f64)] = &[
    ("lever.preload_torque_nm", "Preload torque", "N·m", 4.0),
    (
        "lever.spring_stiffness_nm_per_rad",
        "Stiffness of the spring",
        "N·m/rad",
        4.0,
    ),
    (
        "lever.center_of_mass_m",
        "Distance of the centre of mass",
        "m",
        2.0,
    ),
    ("stop.restitution", "Restitution of the rigid stop", "", 1.0),
];

/// A verdict as pages show it.
pub(super) struct StoredVerdict {
    pub(super) result: StoredResult,
    /// The document, key by key.
    pub(super) keys: Map<String, Value>,
    /// `None` where another version wrote it.
    pub(super) document: Option<Document>,
    /// `None` where nothing was conditioned, or the table is too long.
    pub(super) series: Option<SampledSeries>,
}

/// Reads a verdict.
pub(super) fn find(parts: &Parts, report_id: &str) -> Result<StoredVerdict, Problem> {
    let missing = || Problem::not_found("such verdict");
    let result = parts.ledger.result(report_id)?.ok_or_else(missing)?;
    let text = read(parts, &result, VERDICT_FILE, DOCUMENT_BYTES)?.ok_or_else(missing)?;
    let damaged = |_| StoreError::Damaged {
        what: format!("the document of {report_id}"),
    };
    let keys: Map<String, Value> = serde_json::from_slice(&text).map_err(damaged)?;
    let table = read(parts, &result, SERIES_FILE, SERIES_BYTES)?;
    Ok(StoredVerdict {
        document: serde_json::from_value(Value::Object(keys.clone())).ok(),
        series: table.and_then(|table| series::from_csv(&table).ok()),
        keys,
        result,
    })
}

/// Reads a file of a verdict; `None` where there is none, or it is longer than `most`.
fn read(
    parts: &Parts,
    result: &StoredResult,
    name: &str,
    most: u64,
) -> Result<Option<Vec<u8>>, StoreError> {
    let file = result.files.get(name).filter(|file| file.bytes <= most);
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
    Placed(report_id): Placed<String>,
) -> Result<Markup, Problem> {
    let wanted = report_id.clone();
    let shown = app.apart(move |parts| Ok(drawn(&find(parts, &wanted)?)));
    match shown.await {
        Err(problem) if problem.code == "damaged" => {}
        shown => return shown,
    }
    made_whole(&app, &report_id).await?;
    app.apart(move |parts| Ok(drawn(&find(parts, &report_id)?)))
        .await
}

fn drawn(verdict: &StoredVerdict) -> Markup {
    let StoredVerdict {
        result,
        document,
        series,
        ..
    } = verdict;
    let summary = &result.summary;
    let base = format!("/v1/verdicts/{}", result.report_id);
    let body = html! {
        @if let Some(document) = document {
            (report::first_block(document, series.as_ref()))
        } @else {
            h1 { (summary.file) }
            p { "Another version of latchgate wrote this verdict. Its report shows it." }
        }
        @if series.is_some() {
            script id="series" type="text/csv" data-from={ (base) "/series.csv" } {}
            script src="/assets/event.js" defer {}
        } @else if result.files.contains_key("event.svg") {
            figure {
                img src={ (base) "/event.svg" } alt="Acceleration, velocity and angle of the lever over time";
                figcaption { "The series is too long to be read off here; it can be downloaded." }
            }
        }
        @if document.as_ref().is_some_and(|document| document.nominal.is_some()) { (what_if(verdict)) }
        h2 { "Report and recording" }
        p { "Design " strong { (summary.full_design()) } }
        ul {
            li { a href={ (base) "/report.html" } { "The whole report with its appendix" } " · " a href={ (base) "/report.html?download=true" } { "download it (HTML)" } }
            li { a href={ (base) "/verdict.json?download=true" } { "The document, every digit (JSON)" } }
            @if result.files.contains_key(SERIES_FILE) { li { a href={ (base) "/series.csv" } { "The series (CSV)" } } }
            li { a href={ "/recordings/" (result.recording) } { "The recording" } }
        }
    };
    whole(&format!("{} · {}", summary.verdict, summary.file), &body)
}

fn what_if(verdict: &StoredVerdict) -> Markup {
    let (request, design) = (&verdict.keys["request"], &verdict.keys["design"]);
    html! {
        section id="what-if" data-recording=(verdict.result.recording) data-request=(request) data-design=(design) {
            h2 { "What if" }
            p { "The nominal lever answers at once, the varied levers when they are asked." }
            div.fields {
                @for (key, label, unit, largest) in VARIED {
                    @let (table, name) = key.split_once('.').unwrap_or(("", ""));
                    @let value = design[table][name].as_f64().unwrap_or(0.0);
                    @let top = if *key == "stop.restitution" { 1.0 } else { (value * largest).max(0.01) };
                    label { (label) " "
                        input type="range" data-key=(key) data-unit=(unit) min="0" max=(top) step="any" value=(value);
                        output { (trimmed(value, 4)) " " (unit) }
                    }
                }
            }
            div id="what-if-told" role="status" { p { "Move a slider." } }
            p { button type="button" id="what-if-judge" disabled { "Judge with varied levers" } }
        }
    }
}
