//! The page of `latchgate compare`: two verdicts side by side, what differs, their curves overlaid.

use super::markup::{figure, heads};
use super::{SCRIPT, SERIES_BYTES, block};
use crate::escape::terminal as line;
use crate::page::PageFrame;
use crate::plot::overlay;
use crate::series::SeriesTable;
use crate::{Document, sheet, words};
use maud::{Markup, html};

/// A value that differs: the part it belongs to, its key, and what it is in A and in B.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DifferenceRow {
    /// As in "settings".
    pub part: String,
    /// As in `request.filter`.
    pub key: String,
    /// In words.
    pub values: [String; 2],
}

/// Returns the page as one self-contained HTML document.
pub(crate) fn page(
    documents: [&Document; 2],
    tables: Option<[&SeriesTable; 2]>,
    differences: &[DifferenceRow],
) -> String {
    let names = documents.map(words::report_name);
    let style = format!("{}{}", sheet::of_report(&names.join(" ")), overlay::RULES);
    let series = tables.and_then(overlay::CommonSeries::of);
    let drawn = series.map(|series| {
        let view = overlay::view(&series, documents);
        let (figure, data) = overlay::draw(&series, documents, view);
        let table = Some(series.csv()).filter(|table| table.len() <= SERIES_BYTES);
        (figure, data, table)
    });
    let live = drawn.as_ref().is_some_and(|(_, _, table)| table.is_some());
    let frame = PageFrame {
        title: "Two verdicts compared · latchgate",
        style: &style,
        script: if live { SCRIPT } else { "" },
    };
    let [file, other] = documents.map(|document| line(&document.recording.file));
    let body = html! {
        main {
            header {
                div {
                    p { "Two verdicts compared" }
                    h1 { (file) @if other != file { " and " (other) } }
                }
            }
            div.pair { (card(documents[0], "A")) (card(documents[1], "B")) }
            @if let Some((overlay, _, _)) = &drawn {
                (figure(overlay))
            } @else {
                p {
                    "There are no curves: the table of series beside one of the verdicts is missing, or the "
                    "records have no instant in common."
                }
            }
            section #differences {
                h2 { "What differs" }
                @if differences.is_empty() { p { "Nothing." } } @else { (table(differences)) }
            }
        }
        @if let Some((_, data, Some(table))) = &drawn {
            (block("event-data", "application/json", &data.to_string()))
            (block("series", "text/csv", table))
        }
    };
    frame.head() + &body.into_string() + &frame.tail()
}

fn card(document: &Document, letter: &str) -> Markup {
    html! {
        section.card.(document.verdict.name()) aria-label={ "Verdict " (letter) } {
            p {
                (letter) " · " (line(&document.recording.file)) " · design " (line(&words::design(&document.design)))
                " · report " (line(&words::report_name(document)))
            }
            div.answer {
                div { strong { (words::answer(document.verdict)) } span { (line(&words::headline(document))) } }
            }
        }
    }
}

/// Returns what differs, each part named in its first row alone.
fn table(differences: &[DifferenceRow]) -> Markup {
    html! {
        table.differences {
            (heads(&["part", "key", "A", "B"]))
            tbody {
                @for rows in differences.chunk_by(|row, next| row.part == next.part) {
                    @for (index, row) in rows.iter().enumerate() {
                        tr {
                            td { @if index == 0 { (line(&row.part)) } }
                            td { code { (line(&row.key)) } }
                            @for value in &row.values { td { (line(value)) } }
                        }
                    }
                }
            }
        }
    }
}
