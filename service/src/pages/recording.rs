//! What a recording holds, and the form that asks for a verdict.

use super::history::margins;
use super::{show, table, whole};
use crate::app::App;
use crate::http::recordings::{Recording, look};
use crate::http::verdicts::{Wanted, listed};
use crate::problem::{Placed, Problem, Queried};
use axum::extract::State;
use latchgate::pipeline::Design;
use maud::{Markup, html};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Settings of reading that the form offers: key, label, what it is left at.
const READING: &[(&str, &str, &str)] = &[
    ("time_column", "Time column", "found"),
    ("time_unit", "Unit of time", "s"),
    ("rate_hz", "Sample rate [Hz]", "from the time"),
    ("header_line", "Line of the names", "found"),
    ("skip_lines", "Lines to pass over", "0"),
    ("decimal", "Decimal mark", "found"),
    ("unit", "Unit of acceleration", "as stated"),
    ("time_zero", "Time of first contact [s]", "0"),
];

/// Settings of judging that the form offers: key, label, choices.
const JUDGING: &[(&str, &str, &[&str])] = &[
    (
        "opens_when",
        "Opening direction",
        &["", "negative", "positive", "both"],
    ),
    (
        "filter",
        "Filter",
        &["", "none", "cfc60", "cfc180", "cfc600", "cfc1000"],
    ),
    ("model", "Stop", &["", "auto", "rigid", "soft"]),
];

/// Shows a recording, read as the query's settings say.
pub(super) async fn page(
    State(app): State<App>,
    Placed(id): Placed<String>,
    Queried(settings): Queried<BTreeMap<String, String>>,
) -> Result<Markup, Problem> {
    let stated: Map<String, Value> = settings
        .iter()
        .filter(|(key, value)| !value.is_empty() && READING.iter().any(|(known, ..)| known == key))
        .map(|(key, value)| (key.clone(), typed(value)))
        .collect();
    let request = (!stated.is_empty()).then(|| Value::Object(stated.clone()));
    let recording = look(&app, &id, request).await?;
    let designs = app.on_disk(|parts| parts.ledger.designs()).await?;
    let wanted = Wanted {
        recording: Some(id),
        limit: Some(200),
        ..Wanted::default()
    };
    let judged = listed(&app, wanted).await?;
    let paper = json!(Design::reference());
    let designs: Vec<(String, String)> = designs
        .iter()
        .map(|design| {
            let differences = show::differences(&design.design, &paper);
            (design.reference(), differences.join(", "))
        })
        .collect();
    let body = html! {
        h1 { (recording.name) }
        p.muted { (recording.bytes) " bytes, " (recording.listing["format"].as_str().unwrap_or("format not known")) }
        (problem(&recording.listing))
        (reading(&settings, &recording.listing))
        form id="ask" data-recording=(recording.id) data-request=(Value::Object(stated).to_string()) {
            (channels(&recording))
            (question(&designs))
        }
        (findings("Findings", &recording.listing["findings"]))
        (margins(&judged.verdicts))
        h2 { "Verdicts on this recording" }
        form method="get" action="/compare" { (table(&judged.verdicts)) }
    };
    Ok(whole(&recording.name, &body))
}

/// Reads a value of the form: a number where it is one.
fn typed(text: &str) -> Value {
    let number = text.parse::<i64>().map(Value::from).ok();
    let number = number.or_else(|| text.parse::<f64>().ok().map(|number| json!(number)));
    number.unwrap_or_else(|| Value::from(text))
}

fn problem(listing: &Value) -> Markup {
    let text = listing["problem"]["detail"].as_str();
    html! {
        @if let Some(text) = text {
            div.notice role="alert" {
                strong { "It cannot be read as it is. " } (text)
            }
        } @else if let Some(reason) = listing["reason"].as_str().filter(|_| listing["channel"].is_null()) {
            div.notice role="alert" { strong { "Choose a channel. " } (reason) }
        }
    }
}

/// The first lines, and every guess about them to be overridden.
fn reading(settings: &BTreeMap<String, String>, listing: &Value) -> Markup {
    let lines: Vec<&str> = listing["preview"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .collect();
    let open = listing["problem"].is_object() || !settings.is_empty();
    html! {
        details open[open] {
            summary { "How the file is read" }
            @if !lines.is_empty() {
                ol.preview tabindex="0" aria-label="First lines of the file" { @for line in &lines { li { code { (line) } } } }
            }
            form.fields method="get" {
                @for (key, label, left) in READING {
                    label { (label) " "
                        input name=(key) placeholder=(left) value=(settings.get(*key).map_or("", String::as_str));
                    }
                }
                button { "Read again" }
            }
        }
    }
}

fn channels(recording: &Recording) -> Markup {
    let chosen = recording.listing["channel"].as_str();
    let list = recording.listing["channels"].as_array();
    let channels = list.map_or(&[][..], Vec::as_slice);
    html! {
        h2 { "Channel" }
        @if channels.len() > 8 {
            p { label { "Search " input id="channel-search" type="search"; } }
        }
        div.wide tabindex="0" role="region" aria-label="Channels" {
            table id="channels" {
                thead { tr {
                    th scope="col" { "Judge" } th scope="col" { "Channel" } th scope="col" { "Shape" }
                    th scope="col" { "Peak" } th scope="col" { "Rate" } th scope="col" { "From, to" } th scope="col" { "Findings" }
                } }
                tbody {
                    @for (number, channel) in (1..).zip(channels) {
                        @let name = channel["name"].as_str().unwrap_or("");
                        @let unit = channel["unit"].as_str().unwrap_or("no unit");
                        tr {
                            td { input type="radio" name="channel" value=(name) id=(format!("channel-{number}")) checked[chosen == Some(name)]; }
                            td { label for=(format!("channel-{number}")) { (name) } }
                            td.spark aria-hidden="true" { (channel["spark"].as_str().unwrap_or("")) }
                            td.number { (short(&channel["peak"])) " " (unit) }
                            td.number { (short(&channel["sample_rate_hz"])) " Hz" }
                            td.number { (short(&channel["start_s"])) " to " (short(&channel["end_s"])) " s" }
                            td { (marks(&channel["findings"])) }
                        }
                    }
                }
            }
        }
    }
}

fn short(value: &Value) -> String {
    let number = value.as_f64();
    number.map_or("–".into(), |number| {
        latchgate::report::number::significant(number, 4)
    })
}

fn marks(list: &Value) -> Markup {
    html! {
        @for finding in list.as_array().into_iter().flatten() {
            @let severity = finding["severity"].as_str().unwrap_or("");
            details.finding {
                summary { (severity) ": " (finding["code"].as_str().unwrap_or("")) }
                (finding["text"].as_str().unwrap_or(""))
            }
        }
    }
}

/// Lists findings.
pub(super) fn findings(title: &str, list: &Value) -> Markup {
    let some = list.as_array().is_some_and(|list| !list.is_empty());
    html! {
        @if some { h2 { (title) } (marks(list)) }
    }
}

fn question(designs: &[(String, String)]) -> Markup {
    html! {
        h2 { "Question" }
        div.fields {
            label { "Design "
                select name="design" {
                    option value="" { "the paper's lever" }
                    @for (design, differences) in designs { option value=(design) data-differences=(differences) { (design) } }
                }
            }
            @for (key, label, choices) in JUDGING {
                label { (label) " "
                    select name=(key) {
                        @for choice in *choices { option value=(choice) { @if choice.is_empty() { "as the card says, or the default" } @else { (choice) } } }
                    }
                }
            }
            label { "Overrides of the design " input name="set" placeholder="lever.preload_torque_nm=2.82"; }
        }
        p.muted id="design-differences" role="status" {}
        p { button.primary { "Judge" } }
        progress id="judging" hidden aria-label="Judging" {}
        p id="judging-told" role="alert" {}
    }
}
