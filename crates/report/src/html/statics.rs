//! The page of `latchgate static`: one sheet to file.

use super::markup::{fact, heads};
use crate::escape::terminal as line;
use crate::page::PageFrame;
use crate::sheet;
use crate::statics::{
    FORMULAS, HEADS, LINKAGE_HEADS, cells, clauses, facts, headlines, linkage_rows, word,
};
use latchgate_document::static_document::StaticDocument;
use maud::html;

/// Returns the page as one self-contained HTML document.
pub(crate) fn page(document: &StaticDocument) -> String {
    let frame = PageFrame {
        title: &format!("static · {} · latchgate", line(&document.design)),
        identity: "static",
        style: sheet::STATIC,
        script: "",
    };
    let (tone, word) = word(document);
    let body = html! {
        main {
            header {
                div {
                    p { "Static thresholds of a door latch" }
                    h1 { (line(&document.design)) }
                }
                div.id { p { "latchgate " (line(&document.run.version)) } }
            }
            section #verdict .card.(tone) {
                div.answer {
                    div {
                        strong { (word) }
                        @for sentence in headlines(document) { p { (line(&sentence)) } }
                    }
                }
            }
            section #lever {
                h2 { "Lever" }
                table.facts { tbody { @for (name, value) in facts(document) { (fact(name, &value)) } } }
            }
            @if !document.linkage.is_empty() {
                section #linkage tabindex="0" {
                    h2 { "Linkage, reduced to the pawl's pivot" }
                    table {
                        (heads(&LINKAGE_HEADS))
                        tbody {
                            @for row in linkage_rows(document) { (cells_row(&row)) }
                        }
                    }
                }
            }
            section #thresholds tabindex="0" {
                h2 { "Constant acceleration of the door that opens the latch" }
                table {
                    (heads(&HEADS))
                    tbody { @for row in &document.rows { (cells_row(&cells(row))) } }
                }
                p.note { (FORMULAS) }
            }
            section #clauses {
                h2 { "Which clause each row answers" }
                table.facts { tbody { @for (rows, clause) in clauses(document) { (fact(&rows, clause)) } } }
            }
            section #notes {
                h2 { "What the numbers cover" }
                ul { @for note in &document.notes { li { (line(note)) } } }
                @if let Some(sha256) = &document.design_sha256 {
                    p.note { "Design file, SHA-256 " code { (sha256) } }
                }
                div.sign { span { "Checked by" } span { "Date" } span { "Signature" } }
            }
        }
    };
    frame.head() + &body.into_string() + &frame.tail()
}

fn cells_row<const N: usize>(cells: &[String; N]) -> maud::Markup {
    html! {
        tr {
            @for (column, cell) in cells.iter().enumerate() {
                @if column == 0 { th { (line(cell)) } } @else { td.number { (line(cell)) } }
            }
        }
    }
}
