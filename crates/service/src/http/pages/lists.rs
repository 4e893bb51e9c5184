//! Lists of verdicts and recordings.

use super::{layout, show, walls};
use crate::app::App;
use crate::auth::Visitor;
use crate::http::recordings::{Part, listed};
use crate::http::verdicts::VerdictEntry;
use crate::problem::{Problem, Queried};
use crate::store::ListedRecording;
use crate::store::Summary;
use axum::extract::{Extension, State};
use latchgate::report::angle::KnownPeak;
use latchgate::report::escape::terminal as line;
use maud::{Markup, html};
use serde::Serialize;
use serde_json::json;

/// How a list is sorted, and what else its address asks for.
pub(super) struct Sorting {
    path: &'static str,
    order: String,
    query: String,
}

impl Sorting {
    /// Describes the list at `path`, sorted by `order`, whose address states the keys that are not empty.
    pub(super) fn new(path: &'static str, order: &impl Serialize, keys: &[(&str, &str)]) -> Self {
        let keys = keys.iter().filter(|(_, value)| !value.is_empty());
        Self {
            path,
            order: json!(order).as_str().unwrap_or("").into(),
            query: keys
                .map(|(key, value)| format!("&{key}={}", show::encoded(value)))
                .collect(),
        }
    }

    /// Leads to the next part of the list.
    pub(super) fn older(&self, next: Option<i64>) -> Markup {
        let word = if self.order == "newest" {
            "Older"
        } else {
            "More"
        };
        html! {
            @if let Some(next) = next {
                p { a href=(format!("{}?cursor={next}&sort={}{}", self.path, self.order, self.query)) { (word) } }
            }
        }
    }

    /// A column's head that sorts by it.
    fn head(&self, title: &str, order: &str) -> Markup {
        // The same column once more turns the dates round.
        let next_order = if order == "newest" && self.order == "newest" {
            "oldest"
        } else {
            order
        };
        let is_by_date = matches!(self.order.as_str(), "newest" | "oldest");
        let is_sorted = self.order == order || (order == "newest" && is_by_date);
        let descends = matches!(self.order.as_str(), "newest" | "size");
        let sort = if descends { "descending" } else { "ascending" };
        html! {
            th scope="col" aria-sort=[is_sorted.then_some(sort)] {
                a href=(format!("{}?sort={next_order}{}", self.path, self.query)) { (title) }
                @if is_sorted { span aria-hidden="true" { @if descends { " ↓" } @else { " ↑" } } }
            }
        }
    }
}

/// Draws a table of verdicts, with boxes that choose runs to compare; some columns sort it.
pub(super) fn verdicts(verdicts: &[VerdictEntry], sorting: Option<&Sorting>) -> Markup {
    let head = |title: &str, order: &str| match sorting {
        Some(sorting) => sorting.head(title, order),
        None => html! { th scope="col" { (title) } },
    };
    html! {
        form method="get" action="/compare" {
            input type="hidden" name="sort" value="oldest";
            div.wide tabindex="0" role="region" aria-label="Verdicts" {
                table.rows {
                    thead { tr {
                        th scope="col" { "Compare" } (head("Verdict", "verdict")) (head("File", "file"))
                        th scope="col" { "Channel" } th scope="col" { "Opens on" } (head("Design", "design"))
                        th scope="col" { "Largest angle" } (head("Date (UTC)", "newest"))
                    } }
                    tbody { @for entry in verdicts { (verdict(entry)) } }
                }
            }
            p { button { "Compare the chosen ones" } " " span.muted { "Choose two to eight." } }
        }
    }
}

fn verdict(entry: &VerdictEntry) -> Markup {
    let summary = &entry.summary;
    let short = entry.report_id.get(..8).unwrap_or("");
    let design = line(&summary.full_design()).into_owned();
    let doubtful = matches!(summary.verdict.as_str(), "undecided" | "unusable");
    html! {
        tr {
            td data-label="Compare" { input type="checkbox" name="id" value=(entry.report_id) aria-label=(format!("Compare {} with {design}, report {short}", line(&summary.file))); }
            td data-label="Verdict" {
                a href=(format!("/verdicts/{}", entry.report_id)) { (show::verdict(&summary.verdict)) }
                @if doubtful && !summary.headline.is_empty() { span.doubt { (super::words::on_the_page(&summary.headline)) } }
            }
            td data-label="File" { a href=(format!("/recordings/{}", entry.recording)) { (line(&summary.file)) } }
            td data-label="Channel" { (line(summary.channel.as_deref().unwrap_or("–"))) }
            td data-label="Opens on" { (direction(summary)) }
            td data-label="Design" { (design) }
            td.number data-label="Largest angle" { (largest_angle(summary)) }
            td.number data-label="Date (UTC)" { (show::instant(entry.created_ms)) }
        }
    }
}

/// Says which acceleration opens the lever, where somebody declared it.
fn direction(summary: &Summary) -> &str {
    summary.opens_when.as_deref().unwrap_or("not declared")
}

/// Shows the largest angle, if its error allows that; an unusable recording has none.
fn largest_angle(summary: &Summary) -> String {
    let Some(peak_rad) = summary
        .peak_angle_rad
        .filter(|_| summary.verdict != "unusable")
    else {
        return "–".into();
    };
    let (error_rad, limit_rad) = (summary.uncertainty_rad, summary.threshold_rad);
    match KnownPeak::of(peak_rad, error_rad, limit_rad, summary.verdict == "fail") {
        KnownPeak::Open(_) => "not known".into(),
        known => known.short(),
    }
}

/// Lists recordings.
pub(super) async fn page(
    State(app): State<App>,
    Extension(visitor): Extension<Visitor>,
    Queried(part): Queried<Part>,
) -> Result<Markup, Problem> {
    let filter = part.filter.clone().unwrap_or_default();
    let sorting = Sorting::new("/recordings", &part.sort, &[("filter", &filter)]);
    let list = listed(&app, part).await?;
    let body = html! {
        h1 { "Recordings" }
        p { (walls()) }
        form.filters method="get" action="/recordings" {
            label { "File or person " input type="search" name="filter" value=(filter); }
            input type="hidden" name="sort" value=(sorting.order);
            button { "Show" }
            @if !filter.is_empty() { a href="/recordings" { "Show all" } }
        }
        @if !list.recordings.is_empty() { (recordings(&list.recordings, &sorting)) }
        @else if filter.is_empty() { p { "None yet. " a href="/" { "Upload one" } "." } }
        @else { p role="status" { "No recording fits this search. " a href="/recordings" { "Clear the search" } } }
        (show::damaged(list.damaged))
        (sorting.older(list.next))
    };
    Ok(layout(Some(&visitor), "Recordings", &body))
}

fn recordings(recordings: &[ListedRecording], sorting: &Sorting) -> Markup {
    html! {
        div.wide tabindex="0" role="region" aria-label="Recordings" {
            table.rows {
                thead { tr {
                    (sorting.head("File", "name")) (sorting.head("Date (UTC)", "newest")) (sorting.head("Uploaded by", "owner"))
                    (sorting.head("Size", "size")) th scope="col" { "Channels" } th scope="col" { "Verdicts" }
                } }
                tbody { @for recording in recordings { tr {
                    td data-label="File" { a href=(format!("/recordings/{}", recording.id)) { (line(&recording.name)) } }
                    td.number data-label="Date (UTC)" { (show::instant(recording.created_ms)) }
                    td data-label="Uploaded by" { (line(&recording.owner)) }
                    td.number data-label="Size" { (show::bytes(recording.bytes)) }
                    td.number data-label="Channels" { @match recording.channels { Some(count) => (count), None => "–" } }
                    td.number data-label="Verdicts" { (recording.verdicts) }
                } } }
            }
        }
    }
}
