//! What a recording holds, and the form that asks for a verdict.

use super::fields::{self, DesignChoice};
use super::history::nearness;
use super::words::{is_about, label, on_the_page};
use super::{layout, lists, show};
use crate::app::App;
use crate::auth::{Scope, Visitor};
use crate::http::Caller;
use crate::http::recordings::{Recording, deleted, look};
use crate::http::verdicts::{Wanted, listed};
use crate::problem::{Placed, Problem, Queried};
use axum::extract::{Extension, State};
use axum::response::Redirect;
use latchgate::pipeline::{Setting, words_of};
use latchgate::report::escape::terminal as line;
use maud::{Markup, html};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Of which files a setting of reading is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AskedOf {
    Every,
    Table,
    Workbook,
    Log,
}

/// Settings of reading that the form offers, of which files, and what each is left at unless that was found.
const READING: &[(Setting, AskedOf, &str)] = &[
    (Setting::InputFormat, AskedOf::Every, "found"),
    (
        Setting::Sheet,
        AskedOf::Workbook,
        "the one that holds something",
    ),
    (Setting::TimeColumn, AskedOf::Table, "found"),
    (Setting::TimeUnit, AskedOf::Table, "seconds"),
    (Setting::TimeSource, AskedOf::Log, "header"),
    (Setting::RateHz, AskedOf::Every, "from the time"),
    (Setting::HeaderLine, AskedOf::Table, "found"),
    (Setting::UnitLine, AskedOf::Table, "beside the names"),
    (Setting::LastLine, AskedOf::Table, "the file's"),
    (Setting::SkipLines, AskedOf::Table, "0"),
    (Setting::Decimal, AskedOf::Table, "found"),
    (Setting::Unit, AskedOf::Every, "as stated"),
    (Setting::Sensitivity, AskedOf::Every, "none"),
    (Setting::TimeZero, AskedOf::Every, "0"),
];

/// Units of time with a number that the form suggests beside the plain ones.
const COUNTED_TIME_UNITS: &[&str] = &["10us", "100us", "100ns"];

/// Settings of judging that the form offers, what each is left at, and the word that says the same.
const JUDGING: &[(Setting, &str, &str)] = &[
    (
        Setting::OpensWhen,
        "as the card says; without a card both",
        "",
    ),
    (Setting::Filter, "CFC 1000; below 10 kHz none", "default"),
    (Setting::Model, "both stops; the worse counts", "auto"),
];

/// Shows a recording, read as the query's settings say.
pub(super) async fn page(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Placed(id): Placed<String>,
    Queried(settings): Queried<BTreeMap<String, String>>,
) -> Result<Markup, Problem> {
    let mut stated = Map::new();
    for (setting, ..) in READING {
        let value = settings.get(setting.key()).map_or("", |value| value.trim());
        if !value.is_empty() {
            stated.insert(setting.key().into(), typed(*setting, value));
        }
    }
    let request = (!stated.is_empty()).then(|| Value::Object(stated.clone()));
    let recording = look(&app, &visitor.name, &id, request).await?;
    let designs = app
        .on_disk(|parts| parts.ledger.designs(0, 200))
        .await?
        .entries;
    let query = Wanted {
        recording: Some(id),
        limit: Some(200),
        ..Wanted::default()
    };
    let judged = listed(&app, query).await?.verdicts;
    let designs: Vec<DesignChoice> = designs
        .into_iter()
        .map(|design| DesignChoice {
            reference: design.reference(),
            numbers: design.design,
        })
        .collect();
    let has_channels = recording.listing["channels"][0].is_object();
    let body = html! {
        h1 { (line(&recording.name)) }
        p.muted { (kept(&recording)) }
        (problem(&recording.listing))
        (reading(&settings, &recording.listing, !stated.is_empty()))
        @if has_channels { form id="ask" novalidate data-recording=(recording.id) data-request=(Value::Object(stated).to_string()) {
            (channels(&recording))
            @if visitor.may(Scope::Submit) { (question(&designs)) }
        } }
        (findings("Findings", &recording.listing["findings"]))
        (nearness(&judged))
        h2 { "Verdicts on this recording" }
        @if judged.is_empty() { p { "None yet." } } @else { (lists::verdicts(&judged, None)) }
        @if visitor.may(Scope::Delete) { (deletion(&recording.id)) }
    };
    Ok(layout(Some(&visitor), &recording.name, &body))
}

/// Deletes a recording, and shows the list it stood in.
pub(super) async fn delete(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Extension(caller): Extension<Caller>,
    Placed(id): Placed<String>,
) -> Result<Redirect, Problem> {
    deleted(&app, id, visitor, caller).await?;
    Ok(Redirect::to("/recordings"))
}

/// Asks once more before a recording is deleted.
fn deletion(id: &str) -> Markup {
    html! {
        details.delete {
            summary { "Delete this recording" }
            p { "Its samples and its plots go for good. The verdicts stay, with who deleted it and when." }
            form method="post" action=(format!("/recordings/{id}/delete")) { button { "Delete for good" } }
        }
    }
}

/// Says what is kept.
fn kept(recording: &Recording) -> Markup {
    let format = recording.listing["format"].as_str();
    html! {
        (show::bytes(recording.bytes)) ", " (format.unwrap_or("format not known"))
        " · uploaded " (show::instant(recording.created_ms)) " UTC by " strong { (line(&recording.owner)) }
    }
}

/// Reads a value of the form: a number where it is one; of a quantity with a decimal comma, too.
fn typed(setting: Setting, text: &str) -> Value {
    let is_quantity = matches!(
        setting,
        Setting::RateHz | Setting::TimeZero | Setting::Sensitivity
    );
    let text = if is_quantity {
        text.replace(',', ".")
    } else {
        text.to_string()
    };
    let number = text.parse::<i64>().map(Value::from).ok();
    let number = number.or_else(|| text.parse::<f64>().ok().map(|number| json!(number)));
    number.unwrap_or_else(|| Value::from(text))
}

/// Returns why nothing is read, or no channel taken, as it is.
fn reason(listing: &Value) -> Option<&str> {
    let problem = listing["problem"]["detail"].as_str();
    problem.or_else(|| {
        listing["reason"]
            .as_str()
            .filter(|_| listing["channel"].is_null())
    })
}

fn problem(listing: &Value) -> Markup {
    let lead = if listing["problem"].is_object() {
        "It cannot be read as it is."
    } else if listing["candidates"][0].is_string() {
        "Choose a channel."
    } else {
        "It cannot be judged as it is."
    };
    html! {
        @if let Some(text) = reason(listing) {
            div.notice role="alert" { strong { (lead) } " " (on_the_page(text)) }
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
    let placeholder = |key: &str, otherwise: &str| {
        match key {
            "input_format" => shown(&listing["format"]),
            key => shown(&mapping[key]),
        }
        .map_or_else(|| otherwise.to_string(), |value| format!("{word}: {value}"))
    };
    let reason = reason(listing).unwrap_or("");
    let is_text = listing["preview"][0].is_string();
    let format = listing["format"].as_str();
    let is_wrong = READING
        .iter()
        .any(|(setting, ..)| is_about(reason, *setting));
    // What is neither text nor of a known format is not read, whatever is stated of it.
    if !is_text && format.is_none() && !is_stated && !is_wrong {
        return html! {};
    }
    let is_asked = |setting: Setting, asked_of: AskedOf| match asked_of {
        AskedOf::Every => true,
        AskedOf::Table => !mapping.is_null() || (format.is_none() && is_text),
        AskedOf::Workbook => format == Some("workbook"),
        AskedOf::Log => format == Some("mcap"),
    } || is_about(reason, setting);
    let offered = READING
        .iter()
        .filter(|(setting, asked_of, _)| is_asked(*setting, *asked_of));
    html! {
        details open[is_open || is_stated || is_wrong] {
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
                @for (setting, _, otherwise) in offered {
                    @let (key, value) = (setting.key(), stated(setting.key()));
                    @let error = is_about(reason, *setting).then(|| format!("error-{key}"));
                    @let invalid = error.as_ref().map(|_| "true");
                    label { (label(*setting)) " "
                        @if matches!(setting, Setting::InputFormat | Setting::TimeSource | Setting::Decimal | Setting::Unit) {
                            select name=(key) aria-invalid=[invalid] aria-describedby=[error.as_deref()] {
                                option value="" { (placeholder(key, otherwise)) }
                                @for choice in words_of(*setting) { option value=(choice) selected[choice == value] { (choice) } }
                            }
                        } @else {
                            input name=(key) placeholder=(placeholder(key, otherwise)) value=(value) aria-invalid=[invalid] aria-describedby=[error.as_deref()]
                                list=[(*setting == Setting::TimeUnit).then_some("time-units")];
                        }
                        @if let Some(error) = &error { span.error id=(error) { (on_the_page(reason)) } }
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
                @for (number, text) in (1..).zip(lines) {
                    li { code { (line(text.as_str().unwrap_or(""))) } " " span.muted { (taken_for(number)) } }
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
    let mut channels: Vec<&Value> = list.into_iter().flatten().collect();
    let alone = channels.len() == 1;
    let is_offered =
        |channel: &Value| channel["status"] == "offered" || channel["status"] == "taken";
    channels.sort_by_key(|channel| !is_offered(channel));
    html! {
        h2 { "Channel" }
        @if channels.len() > 8 {
            p { label { "Search " input id="channel-search" type="search"; } " " span.muted id="channel-count" role="status" {} }
        }
        p.error id="channel-error" role="alert" {}
        div.wide tabindex="0" role="region" aria-label="Channels" {
            table.rows id="channels" {
                thead { tr {
                    th scope="col" { "Judge" } th scope="col" { "Channel" } th scope="col" { "Shape" }
                    th scope="col" { "Peak" } th scope="col" { "Rate" } th scope="col" { "From, to" } th scope="col" { "Findings" }
                } }
                tbody {
                    @for (number, channel) in (1..).zip(channels) {
                        @let name = channel["name"].as_str().unwrap_or("");
                        @let unit = channel["unit"].as_str().unwrap_or("no unit");
                        tr {
                            td data-label="Judge" { input type="radio" name="channel" value=(name) id=(format!("channel-{number}")) checked[alone || chosen == Some(name)]; }
                            td data-label="Channel" {
                                label for=(format!("channel-{number}")) { (line(name)) }
                                @if channel["status"] == "offered" { " " span.badge { "offered" } }
                                @if let Some(place) = channel["place"].as_str() { span.doubt { (line(place)) } }
                            }
                            td.spark data-label="Shape" aria-hidden="true" { (channel["spark"].as_str().unwrap_or("")) }
                            td.number data-label="Peak" { (short(&channel["peak"])) " " (unit) }
                            td.number data-label="Rate" { (short(&channel["sample_rate_hz"])) " Hz" }
                            td.number data-label="From, to" { (milliseconds(&channel["start_s"])) " to " (milliseconds(&channel["end_s"])) " ms" }
                            td data-label="Findings" { (counted(&channel["findings"])) }
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

fn milliseconds(value: &Value) -> String {
    let seconds = value.as_f64();
    seconds.map_or("–".into(), |seconds| {
        latchgate::document::number::trimmed(1e3 * seconds, 6)
    })
}

/// Lists findings, the gravest first.
fn sentences(list: &Value) -> Markup {
    let mut findings: Vec<&Value> = list.as_array().into_iter().flatten().collect();
    let severity = |finding: &&Value| GRAVITY.iter().position(|word| finding["severity"] == *word);
    findings.sort_by_key(severity);
    html! {
        ul.found {
            @for finding in findings {
                @let severity = finding["severity"].as_str().unwrap_or("");
                li {
                    span.badge.(severity) { (severity) } " " (on_the_page(finding["text"].as_str().unwrap_or("")))
                    code { (finding["code"].as_str().unwrap_or("")) }
                }
            }
        }
    }
}

/// Severities of findings, the gravest first.
const GRAVITY: [&str; 3] = ["blocking", "warning", "info"];

/// Counts findings by how grave they are, to be unfolded.
fn counted(list: &Value) -> Markup {
    let findings = list.as_array().map_or(&[][..], Vec::as_slice);
    let counts = GRAVITY.map(|word| {
        let count = findings
            .iter()
            .filter(|finding| finding["severity"] == word)
            .count();
        (count > 0).then(|| format!("{count} {word}"))
    });
    let counts: Vec<String> = counts.into_iter().flatten().collect();
    html! {
        @if counts.is_empty() { "none" } @else {
            details.finding { summary { (counts.join(", ")) } (sentences(list)) }
        }
    }
}

/// Lists findings under a title, if there are any.
fn findings(title: &str, list: &Value) -> Markup {
    html! {
        @if list[0].is_object() { h2 { (title) } (sentences(list)) }
    }
}

/// Asks for what a pass may wait for.
fn words() -> Markup {
    let field = |setting: Setting, hint: &str| {
        html! {
            label { (label(setting)) " " input name=(setting.key()) autocomplete="off" placeholder=(hint); }
        }
    };
    html! {
        details.change {
            summary { "What a pass may wait for" }
            div.fields {
                (field(Setting::Transfer, "1, or LO..HI; not needed at door or latch"))
                (field(Setting::VelocityChange, "from another source"))
                label { (label(Setting::Accept)) " "
                    select name=(Setting::Accept.key()) {
                        option value="" { "none" }
                        @for choice in words_of(Setting::Accept) { option value=(choice) { (choice) } }
                        option value=(words_of(Setting::Accept).join(",")) { "all of them" }
                    }
                }
                label { (label(Setting::Siblings)) " "
                    select name=(Setting::Siblings.key()) {
                        option value="" { "the chosen one alone" }
                        option value="true" { "all; the worst counts" }
                    }
                }
            }
        }
    }
}

fn question(designs: &[DesignChoice]) -> Markup {
    html! {
        h2 { "Question" }
        div.fields {
            (fields::design("design", "Design", designs))
            @for (setting, otherwise, same) in JUDGING {
                label { (label(*setting)) " "
                    select name=(setting.key()) {
                        option value="" { (otherwise) }
                        @for choice in words_of(*setting).into_iter().filter(|choice| choice != same) { option value=(choice) { (choice) } }
                    }
                }
            }
        }
        (words())
        (fields::lever())
        p { button.primary { "Judge" } }
        (fields::waiting("judging"))
        p.error id="judging-told" role="alert" {}
    }
}
