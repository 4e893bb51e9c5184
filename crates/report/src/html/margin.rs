//! The page of `latchgate margin`.

use super::markup::{channel_and_design, code_fact, figure, heads};
use super::results::NO_FINDINGS;
use super::sources::{judged, lever, signature};
use crate::escape::terminal as line;
use crate::margin_words::{advised, bracket, change, direction, headline, titled, without_advice};
use crate::page::PageFrame;
use crate::plot::{Figure, MARGIN_RULES};
use crate::words;
use latchgate_document::MarginDocument;
use latchgate_document::number::{ABSENT, significant};
use latchgate_kernel::units::shortest;
use latchgate_verdict::Answer;
use latchgate_verdict::margin::{Change, Margin};
use maud::{Markup, html};

/// Returns the page as one self-contained HTML document.
pub(crate) fn page(document: &MarginDocument, figures: &[Figure]) -> String {
    let recording = &document.recording;
    let frame = PageFrame {
        title: &format!("margin · {} · latchgate", line(&recording.file)),
        identity: "margin",
        style: MARGIN_RULES,
        script: "",
    };
    let usable = document.verdict != Answer::Unusable;
    let body = html! {
                main {
                    header {
                        div {
                            p { "Margin of a door latch verdict" }
                            h1 { (line(&recording.file)) }
                            p { (channel_and_design(recording, &document.design)) }
                        }
                        div.id { p { "latchgate " (line(&document.run.version)) } }
                    }
                    (card(document))
                    (judged(&document.test, recording, &document.design, None, document.conditioning.as_ref(), document.transfer.as_ref(), &[]))
                    (lever(&document.design))
                    @if usable {
                        (answers(document))
                        (boundaries(document))
                        section #charts { h2 { "Charts" } @for drawing in figures { (figure(drawing)) } }
                    }
                    (findings(document))
                    section #provenance {
                        h2 { "Provenance" }
                        table.facts {
                            tbody {
                                (code_fact("Report", &document.report_id))
                                (code_fact("SHA-256", recording.sha256.as_deref().unwrap_or(ABSENT)))
                                (code_fact("Settings", &words::settings(&document.request)))
                            }
                        }
                        (signature())
                    }
                }
    };
    frame.head() + &body.into_string() + &frame.tail()
}

fn card(document: &MarginDocument) -> Markup {
    let headline = headline(document);
    html! {
        section #verdict .card.(document.verdict.name()) {
            div.answer { div { strong { (words::answer(document.verdict)) } span { (line(&headline)) } } }
            ul.why { @for note in &document.notes { li { (line(note)) } } }
        }
    }
}

fn answers(document: &MarginDocument) -> Markup {
    let counterweight = &document.counterweight;
    let number = |value: Option<f64>| value.map_or_else(|| ABSENT.into(), |v| significant(v, 5));
    html! {
        // A phone scrolls the tables sideways; the tab index lets keys scroll them too.
        section #margins tabindex="0" {
            h2 { "What would change the answer" }
            table.margins {
                (heads(&["Quantity", "#Present", "#Passes from", "#Tried to", "#Nearest change", "#Change", "There"]))
                tbody { @for answer in &document.answers { (nearest_change(answer, counterweight.radius_m)) } }
            }
            @for (title, why) in without_advice(document) { p.note { (line(&title)) ": " (line(&why)) "." } }
            (searched(document))
            @if let Some(mass) = counterweight.mass_kg {
                p.note {
                    "A counterweight of " (significant(mass, 5)) " kg, fixed to the lever at " (counterweight.radius_m)
                    " m, leaves an unbalance of " (number(counterweight.unbalance_kg_m))
                    " kg·m and a moment of inertia of " (number(counterweight.moment_of_inertia_kg_m2)) " kg·m²."
                }
            }
        }
    }
}

/// Returns the row of a quantity: where the answer changes.
fn nearest_change(answer: &Margin, counterweight_radius_m: f64) -> Markup {
    let change = change(answer).map(|change| change.replace('-', "\u{2212}"));
    html! {
        tr {
            th { (line(&titled(answer, counterweight_radius_m))) }
            td.number { (shortest(answer.present)) }
            td.number.nominal { (advised(answer)) }
            td.number { (shortest(answer.advice.until)) }
            @if let Some(nearest) = answer.at() {
                td.number { (shortest(nearest)) }
                td.number { (change.as_deref().unwrap_or(ABSENT)) }
                td { (direction(answer)) }
            } @else {
                td.number { "none" }
                td.number { (ABSENT) }
                td { (ABSENT) }
            }
        }
    }
}

/// Returns both bases of each number, its range and its convention.
fn searched(document: &MarginDocument) -> Markup {
    let columns = [
        "Quantity",
        "#Nominal peak meets the limit at",
        "#Verdict changes at",
        "#Width of the bracket",
        "#Tried",
        "What stays and what moves along",
    ];
    let passes = |change: Option<Change>| {
        change.map_or_else(|| ABSENT.into(), |change| significant(change.passes, 6))
    };
    html! {
        table.margins {
            (heads(&columns))
            tbody {
                @for answer in &document.answers {
                    tr {
                        th { (line(&answer.title)) }
                        td.number { (passes(answer.nominal_change)) }
                        td.number { (passes(answer.verdict_change)) }
                        td.number {
                            @if let Some((low, high)) = answer.change.map(|change| change.bracket()) {
                                (significant(high - low, 2))
                            } @else {
                                (ABSENT)
                            }
                        }
                        td.number {
                            (significant(answer.searched.0, 3)) " to " (significant(answer.searched.1, 3))
                            ", " (answer.values) " values"
                        }
                        td { (line(&words::sentence(&answer.convention))) }
                    }
                }
            }
        }
    }
}

/// Changes of the nominal runs' answer that the page lists.
const BOUNDARIES_SHOWN: usize = 12;

fn boundaries(document: &MarginDocument) -> Markup {
    let more = document.boundaries.len().saturating_sub(BOUNDARIES_SHOWN);
    html! {
        section #boundaries tabindex="0" {
            h2 { "Changes of the nominal runs’ answer" }
            @if document.boundaries.is_empty() {
                p { "None between the values tried." }
            } @else {
                table.findings {
                    (heads(&["Quantity", "#At", "Below", "Above", "#Bracket"]))
                    tbody {
                        @for boundary in document.boundaries.iter().take(BOUNDARIES_SHOWN) {
                            @let answer = document.answers.iter().find(|answer| answer.quantity.name() == boundary.quantity);
                            @let unit = if boundary.unit.is_empty() { ABSENT } else { &boundary.unit };
                            tr {
                                th { (line(answer.map_or(&boundary.quantity, |answer| &answer.title))) " [" (line(unit)) "]" }
                                td.number { (significant(boundary.at, 9)) }
                                td { (boundary.below.name()) }
                                td { (boundary.above.name()) }
                                td.number { (bracket(boundary.bracket)) }
                            }
                        }
                    }
                }
                @if more > 0 { p.note { (more) " more stand in margin.json." } }
            }
        }
    }
}

fn findings(document: &MarginDocument) -> Markup {
    html! {
        section #findings {
            h2 { "Findings" }
            @if document.findings.is_empty() {
                p { (NO_FINDINGS) }
            } @else {
                table.findings {
                    (heads(&["Severity", "What was found"]))
                    tbody {
                        @for finding in &document.findings {
                            tr {
                                td { (words::severity(finding.severity)) }
                                td { (line(&words::sentence(&finding.text))) code { (line(&finding.code)) } }
                            }
                        }
                    }
                }
            }
        }
    }
}
