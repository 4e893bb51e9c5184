//! `report.html`: one file that opens offline, in light and dark, and prints on A4.
//!
//! The page fetches nothing and is complete without its script, which adds cursors and zoom to the
//! first plot. Page one has verdict, event, findings and what was judged; page two the lever, the certainty of the
//! verdict, its limits and the lines to sign on. The rest is folded; print shows what was unfolded.
//!
//! `card` is the head of the page, `results` what the runs say, `ensemble` the varied levers,
//! `sources` the inputs; `margin` is the page of margins, `spectrum` that of latch response spectra, `statics` that of static thresholds, `overlay` that of two verdicts.
//! `markup` holds what they share, `sheet` is the style.

mod card;
mod conditions;
mod ensemble;
mod margin;
mod markup;
mod overlay;
mod results;
mod sources;
mod spectrum;
mod statics;

pub(super) use self::margin::page as margin_page;
use self::markup::{figure, fold};
pub use self::overlay::compared;
pub(super) use self::overlay::page as overlay_page;
pub(super) use self::spectrum::page as spectrum_page;
pub(super) use self::statics::page as static_page;
use super::escape::terminal as line;
use super::page::PageFrame;
use super::plot::{self, Figure};
use super::{series, sheet, words};
use latchgate_document::Document;
use latchgate_verdict::{Answer, Evidence, SampledSeries};
use maud::{Markup, PreEscaped, html};

/// Returns the report as one self-contained HTML document.
pub fn render(document: &Document, evidence: Option<&Evidence>) -> String {
    page(document, evidence, &plot::figures(document, evidence))
}

/// As [`render`], with plots that are already drawn.
pub(super) fn page(document: &Document, evidence: Option<&Evidence>, figures: &[Figure]) -> String {
    let name = words::report_name(document);
    let data = evidence.and_then(|evidence| {
        let (_, data) = plot::event::draw(document, &evidence.series)?;
        Some((data.to_string(), series::csv(&evidence.series)))
    });
    let title = format!(
        "{} · {} · latchgate",
        words::answer(document.verdict),
        document.recording.file
    );
    let frame = PageFrame {
        title: &title,
        identity: &name,
        style: sheet::REPORT,
        script: if data.is_some() { SCRIPT } else { "" },
    };
    let body = html! {
        main {
            (first_page(document, figures, &name))
            (second_page(document))
            (appendix(document, evidence, figures))
            p.end { "End of report " (line(&name)) }
        }
        @if let Some((data, table)) = &data {
            (block("event-data", "application/json", data))
            // A page with very long series would open slowly; their own file holds them.
            (block("series", "text/csv", if table.len() > SERIES_BYTES { "" } else { table }))
        }
    };
    frame.head() + &body.into_string() + &frame.tail()
}

/// Largest number of bytes of series in a page.
pub(super) const SERIES_BYTES: usize = 6 << 20;

/// Script that adds cursors and zoom to the first plot.
pub const SCRIPT: &str = include_str!("html/event.js");

/// Returns a block of data, which the browser does not run.
fn block(id: &str, kind: &str, text: &str) -> Markup {
    // A `<` in a name could end the block early.
    let text = text.replace('<', "\\u003c").replace('&', "\\u0026");
    html! { script type=(kind) id=(id) { (PreEscaped(text)) } }
}

/// Returns the first page: verdict, event, findings, and what was judged.
fn first_page(document: &Document, figures: &[Figure], name: &str) -> Markup {
    let event = figures.iter().find(|drawing| drawing.name == plot::EVENT);
    html! {
        (deciding(document, event, name))
        (asked(document))
    }
}

fn deciding(document: &Document, event: Option<&Figure>, name: &str) -> Markup {
    html! {
        (card::head(document, name))
        (card::verdict(document))
        @if let Some(event) = event { (figure(event)) }
        (results::main_findings(document))
    }
}

/// Returns the start of the first page, head, card, plot and findings, for a page that holds [`style`] and
/// loads [`SCRIPT`]; the folded findings follow. The script takes the samples from an element `#series`.
pub fn first_block(document: &Document, series: Option<&SampledSeries>) -> Markup {
    let drawn = series.and_then(|series| plot::event::draw(document, series));
    let event = drawn.as_ref().map(|(event, _)| event);
    html! {
        (deciding(document, event, &words::report_name(document)))
        (all_findings(document))
        @if let Some((_, data)) = &drawn { (block("event-data", "application/json", &data.to_string())) }
    }
}

/// Returns what was judged: test, channel, direction, filter, and the lever.
pub fn judged(document: &Document) -> Markup {
    html! {
        (asked(document))
        (sources::lever(&document.design))
    }
}

/// Returns what was judged without the lever's numbers.
fn asked(document: &Document) -> Markup {
    sources::judged(
        &document.test,
        &document.recording,
        &document.design,
        Some(document.screens.static_threshold_g),
        document.conditioning.as_ref(),
        document.transfer.as_ref(),
        &document.siblings,
    )
}

/// Returns the card with answer and figures alone.
pub fn answer(document: &Document) -> Markup {
    html! { div.card.(document.verdict.name()) { (card::answer(document)) } }
}

/// Returns the rules of reports and comparisons, without an identity at the foot.
pub fn style() -> String {
    sheet::plain() + plot::overlay::RULES
}

fn all_findings(document: &Document) -> Markup {
    fold("all-findings", "All findings", &results::findings(document))
}

/// Returns the second page: the lever, the certainty of the answer, its limits, and the lines to sign on.
fn second_page(document: &Document) -> Markup {
    html! {
        div.second {
            (sources::lever(&document.design))
            // Results of faulty samples mean nothing.
            @if document.verdict != Answer::Unusable {
                (results::budget(document))
                (conditions::conditions(document))
            }
            (results::sled(document))
            (sources::limits(document))
            (sources::record(document))
        }
    }
}

/// Returns everything else, folded.
fn appendix(document: &Document, evidence: Option<&Evidence>, figures: &[Figure]) -> Markup {
    let drivers = figures.iter().find(|drawing| drawing.name == plot::DRIVERS);
    let plots = html! {
        @for drawing in figures {
            @if ![plot::DRIVERS, plot::EVENT].contains(&drawing.name) { (figure(drawing)) }
        }
    };
    let recording = html! { (sources::recording(document)) (sources::conditioning(document)) };
    html! {
        section #appendix {
            h2 { "Appendix" }
            @if evidence.is_none() && figures.is_empty() {
                p { "Nothing was conditioned or replayed, so there is nothing to draw." }
            } @else if figures.is_empty() {
                p { "The recording holds nothing that could be drawn." }
            }
            p.note { "Unfold what is to be printed with the report." }
            (fold("reasons", "Why", &card::why(document)))
            @if document.verdict != Answer::Unusable {
                (fold("runs", "Runs compared", &results::runs(document)))
                (fold("ensemble", "Levers and readings by stop", &ensemble::ensemble(document)))
                (fold("filters", "After each filter, the nominal lever alone", &ensemble::filters(document)))
                (fold("impacts", "Impacts of the nominal run", &results::impacts(document)))
                (fold("inputs", "What the peak is sensitive to", &ensemble::sensitivity(document, drivers)))
            }
            (fold("bounds", "Bounds that need no integration", &results::screens(document)))
            (all_findings(document))
            (fold("plots", "Signal and response, all plots", &plots))
            (fold("recording", "Recording and conditioning", &recording))
            (fold("design", "Design", &sources::design(document)))
            (fold("provenance", "How to repeat it", &sources::provenance(document)))
        }
    }
}
