//! The page of `latchgate compare`: verdicts side by side, what differs, their curves overlaid.

use super::markup::figure;
use super::{SCRIPT, SERIES_BYTES, block};
use crate::differences::{DifferingValue, short_value};
use crate::escape::terminal as line;
use crate::folder::COMPARE_TITLE;
use crate::page::PageFrame;
use crate::plot::overlay;
use crate::{Document, comparison, headline, sheet, words};
use latchgate_verdict::SampledSeries;
use maud::{Markup, html};

/// Letters of a value in a cell.
const CELL: usize = 400;

/// Returns the page as one self-contained HTML document.
pub(crate) fn page(
    documents: &[&Document],
    tables: Option<&[SampledSeries]>,
    differences: &[DifferingValue],
) -> String {
    let names: Vec<String> = documents
        .iter()
        .map(|document| words::report_name(document))
        .collect();
    let style = format!("{}{}", sheet::REPORT, overlay::RULES);
    let frame = PageFrame {
        title: COMPARE_TITLE,
        identity: &names.join(" "),
        style: &style,
        script: SCRIPT,
    };
    let body = html! { main { (compared(documents, tables, differences)) } };
    frame.head() + &body.into_string() + &frame.tail()
}

/// Returns what differs between verdicts with their curves, for a page that holds [`super::style`] and loads
/// [`SCRIPT`].
pub fn compared(
    documents: &[&Document],
    tables: Option<&[SampledSeries]>,
    differences: &[DifferingValue],
) -> Markup {
    let series = tables.and_then(overlay::CommonSeries::of);
    let drawn = series.map(|series| {
        let view = overlay::view(&series, documents);
        let (figure, data) = overlay::draw(&series, documents, view);
        let table = Some(series.csv()).filter(|table| table.len() <= SERIES_BYTES);
        (figure, data, table)
    });
    html! {
        header {
            div {
                p { "Verdicts compared" }
                h1 { (line(&comparison::sentence(documents))) }
            }
        }
        div.pair { @for (place, document) in documents.iter().enumerate() { (card(document, comparison::letter(place))) } }
        (rows(documents))
        @if let Some((overlay, _, _)) = &drawn {
            (figure(overlay))
        } @else {
            p {
                "There are no curves: the table of series beside one of the verdicts is missing, or the "
                "records have no instant in common."
            }
        }
        section #differences {
            details {
                summary { "Every key that differs" }
                @if differences.is_empty() { p { "None." } } @else { (table(differences, documents.len())) }
            }
        }
        @if let Some((_, data, Some(table))) = &drawn {
            (block("event-data", "application/json", &data.to_string()))
            (block("series", "text/csv", table))
        }
    }
}

/// Returns the answers of each, and the inputs that differ.
fn rows(documents: &[&Document]) -> Markup {
    html! {
        table.compared {
            (heads_of("What", documents.len()))
            tbody {
                @for row in comparison::rows(documents) {
                    tr { th { (line(&words::capital(&row.name))) } @for value in &row.values { td { (line(value)) } } }
                }
            }
        }
    }
}

/// Returns the head of a table with a column for each verdict behind those named.
fn heads_of(names: &str, verdicts: usize) -> Markup {
    html! {
        thead {
            tr {
                @for name in names.split('|') { th scope="col" { (name) } }
                @for place in 0..verdicts { th scope="col" { (comparison::letter(place)) } }
            }
        }
    }
}

fn card(document: &Document, letter: char) -> Markup {
    html! {
        section.card.(document.verdict.name()) aria-label={ "Verdict " (letter) } {
            p {
                (letter) " · " (line(&comparison::subject(document))) " · report " (line(&words::report_name(document)))
            }
            div.answer {
                div { strong { (words::answer(document.verdict)) } span { (line(&headline::headline(document))) } }
            }
        }
    }
}

/// Returns what differs, each part named in its first row alone.
fn table(differences: &[DifferingValue], verdicts: usize) -> Markup {
    html! {
        table.differences {
            (heads_of("part|key", verdicts))
            tbody {
                @for rows in differences.chunk_by(|row, next| row.part == next.part) {
                    @for (index, row) in rows.iter().enumerate() {
                        tr {
                            td { @if index == 0 { (line(&row.part)) } }
                            td { code { (line(&row.key)) } }
                            @for value in &row.values { td { (line(&short_value(value, CELL))) } }
                        }
                    }
                }
            }
        }
    }
}
