//! What a recording holds, and the form that asks for a verdict.

use super::history::margins;
use super::{show, table, whole};
use crate::app::App;
use crate::auth::Visitor;
use crate::http::Caller;
use crate::http::recordings::{Recording, deleted, look};
use crate::http::verdicts::{Wanted, listed};
use crate::problem::{Placed, Problem, Queried};
use axum::extract::{Extension, State};
use axum::response::Redirect;
use latchgate::pipeline::{Design, Setting, words_of};
use maud::{Markup, html};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Settings of reading that the form offers: key, label, what it is left at unless that was found.
const READING: &[(Setting, &str, &str)] = &[
    (Setting::InputFormat, "Format", "found"),
    (Setting::TimeColumn, "Time column", "found"),
    (Setting::TimeUnit, "Unit of time", "s"),
    (Setting::TimeSource, "Clock of a log", "header"),
    (Setting::RateHz, "Sample rate [Hz]", "from the time"),
    (Setting::HeaderLine, "Line of the names", "found"),
    (Setting::UnitLine, "Line of the units", "beside the names"),
    (Setting::LastLine, "Last line of the table", "the file's"),
    (Setting::SkipLines, "Lines to pass over", "0"),
    (Setting::Decimal, "Decimal mark", "found"),
    (Setting::Unit, "Unit of acceleration", "as stated"),
    (Setting::Sensitivity, "Sensitivity, as 20 g/V", "none"),
    (Setting::TimeZero, "Time of first contact [s]", "0"),
];

/// Units of time with a number that the form suggests beside the plain ones.
const COUNTED_TIME_UNITS: &[&str] = &["10us", "100us", "100ns"];

/// Settings of judging that the form offers, with their labels.
const JUDGING: &[(Setting, &str)] = &[
    (Setting::OpensWhen, "Opening direction"),
    (Setting::Filter, "Filter"),
    (Setting::Model, "Stop"),
];

/// Shows a recording, read as the query's settings say.
pub(super) async fn page(
    State(app): State<App>,
    Placed(id): Placed<String>,
    Queried(settings): Queried<BTreeMap<String, String>>,
) -> Result<Markup, Problem> {
    let stated: Map<String, Value> = settings
        .iter()
        .filter(|(key, value)| {
            !value.is_empty() && READING.iter().any(|(setting, ..)| setting.key() == *key)
        })
        .map(|(key, value)| (key.clone(), typed(value)))
        .collect();
    let request = (!stated.is_empty()).then(|| Value::Object(stated.clone()));
    let recording = look(&app, &id, request).await?;
    let designs = app
        .on_disk(|parts| parts.ledger.designs(0, 200))
        .await?
        .entries;
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
    let has_channels = recording.listing["channels"][0].is_object();
    let body = html! {
        h1 { (recording.name) }
        p.muted { (show::bytes(recording.bytes)) ", " (recording.listing["format"].as_str().unwrap_or("format not known")) }
        (problem(&recording.listing))
        (reading(&settings, &recording.listing, !stated.is_empty()))
        @if has_channels { form id="ask" data-recording=(recording.id) data-request=(Value::Object(stated).to_string()) {
            (channels(&recording))
            (question(&designs))
        } }
        (findings("Findings", &recording.listing["findings"]))
        (margins(&judged.verdicts))
        h2 { "Verdicts on this recording" }
        form method="get" action="/compare" { (table(&judged.verdicts)) }
    };
    Ok(whole(&recording.name, &body))
}

/// Deletes a recording, and shows the list it stood in.
pub(super) async fn delete(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Extension(caller): Extension<Caller>,
    Placed(id): Placed<String>,
) -> Result<Redirect, Problem> {
    deleted(&app, id, visitor, caller).await?;
    Ok(Redirect::to("/"))
}

/// Reads a value of the form: a number where it is one.
fn typed(text: &str) -> Value {
    let number = text.parse::<i64>().map(Value::from).ok();
    let number = number.or_else(|| text.parse::<f64>().ok().map(|number| json!(number)));
    number.unwrap_or_else(|| Value::from(text))
}

/// Words a text for whoever sees the form: its fields have names of their own.
fn on_the_page(text: &str) -> String {
    let mut text = text.replace("; choose one with the field `request.channel` = NAME", "");
    for (setting, label, _) in READING {
        let key = setting.key();
        text = text.replace(
            &format!("the field `request.{key}` ="),
            &format!("“{label}” as"),
        );
        text = text.replace(&format!("the field `request.{key}`"), &format!("“{label}”"));
    }
    text
}

fn problem(listing: &Value) -> Markup {
    let text = listing["problem"]["detail"].as_str();
    html! {
        @if let Some(text) = text {
            div.notice role="alert" {
                strong { "It cannot be read as it is. " } (on_the_page(text))
            }
        } @else if let Some(reason) = listing["reason"].as_str().filter(|_| listing["channel"].is_null()) {
            div.notice role="alert" { strong { "Choose a channel. " } (on_the_page(reason)) }
        }
    }
}

/// The first lines, what was found out about them, and every guess to be overridden.
fn reading(settings: &BTreeMap<String, String>, listing: &Value, is_stated: bool) -> Markup {
    let mapping = &listing["mapping"];
    let stated = |key: &str| settings.get(key).map_or("", String::as_str);
    // Where a person is asked nothing was taken yet.
    let is_open = listing["problem"].is_object();
    let word = if is_open { "perhaps" } else { "found" };
    let left = |key: &str, otherwise: &str| {
        match key {
            "input_format" => shown(&listing["format"]),
            key => shown(&mapping[key]),
        }
        .map_or_else(|| otherwise.to_string(), |found| format!("{word}: {found}"))
    };
    html! {
        details open[is_open || is_stated] {
            summary { "How the file is read" }
            (preview(listing))
            @if let Some(separator) = shown(&mapping["separator"]) {
                p id="mapping" {
                    @if is_open { "It seems: " } "cells separated by " strong { (separator) }
                    @if !is_open { "; decimal mark " strong { (shown(&mapping["decimal"]).as_deref().unwrap_or("not seen")) } }
                    "; names on line " strong { (shown(&mapping["header_line"]).as_deref().unwrap_or("none")) }
                    ", samples from line " strong { (shown(&mapping["data_line"]).as_deref().unwrap_or("–")) }
                    @if !is_open { "; time in " strong { (shown(&mapping["time_column"]).as_deref().unwrap_or("no column")) } }
                    @if let Some(unit) = shown(&mapping["time_unit"]) { ", in " (unit) } "."
                }
            }
            form.fields method="get" {
                @for (setting, label, otherwise) in READING {
                    @let (key, value) = (setting.key(), stated(setting.key()));
                    @let is_choice = matches!(setting, Setting::InputFormat | Setting::TimeSource | Setting::Decimal);
                    label { (label) " "
                        @if is_choice {
                            select name=(key) {
                                option value="" { (left(key, otherwise)) }
                                @for choice in words_of(*setting) { option value=(choice) selected[choice == value] { (choice) } }
                            }
                        } @else {
                            input name=(key) placeholder=(left(key, otherwise)) value=(value)
                                list=[(*setting == Setting::TimeUnit).then_some("time-units")];
                        }
                    }
                }
                datalist id="time-units" {
                    @for unit in words_of(Setting::TimeUnit).iter().chain(COUNTED_TIME_UNITS) { option value=(unit) {} }
                }
                @if let Some(search) = settings.get("search") { input type="hidden" name="search" value=(search); }
                button { "Read again" }
            }
        }
    }
}

/// The first lines of a text, each with what it was taken for.
fn preview(listing: &Value) -> Markup {
    let lines = listing["preview"].as_array();
    let lines = lines.map_or(&[][..], Vec::as_slice);
    let line_of = |key: &str| listing["mapping"][key].as_u64();
    let (names, data) = (line_of("header_line"), line_of("data_line"));
    let taken_for = |number: u64| match (names, data) {
        (Some(names), _) if number == names => "names",
        (_, Some(data)) if number == data => "first sample",
        (_, Some(data)) if number < data => "not samples",
        _ => "",
    };
    html! {
        @if !lines.is_empty() {
            ol.preview tabindex="0" aria-label="First lines of the file" {
                @for (number, line) in (1..).zip(lines) {
                    li { code { (line.as_str().unwrap_or("")) } " " span.muted { (taken_for(number)) } }
                }
            }
        }
    }
}

/// Shows a text or a number; nothing where there is none.
fn shown(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

fn channels(recording: &Recording) -> Markup {
    let chosen = recording.listing["channel"].as_str();
    let list = recording.listing["channels"].as_array();
    let channels = list.map_or(&[][..], Vec::as_slice);
    html! {
        h2 { "Channel" }
        @if channels.len() > 8 {
            p { label { "Search " input id="channel-search" type="search"; } " " span.muted id="channel-count" role="status" {} }
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
        latchgate::document::number::significant(number, 4)
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
            @for (setting, label) in JUDGING {
                label { (label) " "
                    select name=(setting.key()) {
                        option value="" { "as the card says, or the default" }
                        @for choice in words_of(*setting) { option value=(choice) { (choice) } }
                    }
                }
            }
            label { "Overrides of the design " input name="set" size="32" placeholder="lever.preload_torque_nm=2.82"; }
        }
        p.muted id="design-differences" role="status" {}
        p { button.primary { "Judge" } }
        progress id="judging" hidden aria-label="Judging" {}
        p id="judging-told" role="alert" {}
    }
}
