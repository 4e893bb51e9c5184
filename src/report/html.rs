//! `report.html`: one file that opens offline, in light and dark, and prints on A4.
//!
//! The page needs no script and fetches nothing. The verdict stands first, then what it rests
//! on; findings that block an answer come before everything else.
//!
//! `card` is the head of the page, `results` what the runs say, `ensemble` the scattered levers,
//! `sources` what all rests on; `margin` is the page of margins. `markup` escapes every text,
//! `sheet` is the style.

mod card;
mod ensemble;
mod margin;
mod markup;
mod results;
mod sheet;
mod sources;

pub(super) use self::margin::page as margin_page;
use self::markup::Page;
use super::plot::{self, Figure};
use super::words;
use crate::recording::Severity;
use crate::report::Document;
use crate::verdict::Evidence;

/// Returns the rules that all pages share.
pub(super) fn page_style() -> String {
    sheet::style("")
}

/// Returns the report as one self-contained HTML document.
#[must_use]
pub fn render(document: &Document, evidence: Option<&Evidence>) -> String {
    page(document, evidence, &plot::figures(document, evidence))
}

/// As [`render`], with plots that are already drawn.
pub(super) fn page(document: &Document, evidence: Option<&Evidence>, figures: &[Figure]) -> String {
    let identity = words::identity(document);
    let bytes: usize = figures.iter().map(Figure::size).sum();
    let mut page = Page::with_capacity(bytes + 64 * 1024);
    page.raw("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n");
    page.raw("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n");
    page.raw("<meta name=\"color-scheme\" content=\"light dark\"/>\n");
    page.raw("<meta name=\"generator\" content=\"latchgate ");
    page.text(&document.run.version);
    page.raw("\"/>\n<title>");
    page.text(words::answer(document.verdict));
    page.text(" · ");
    page.text(&document.recording.file);
    page.raw(" · latchgate</title>\n<style>\n");
    page.raw(&sheet::style(&identity));
    page.raw("</style>\n</head>\n<body>\n<main>\n");

    card::head(&mut page, document, &identity);
    card::verdict(&mut page, document);
    let blocked = document
        .findings
        .iter()
        .any(|finding| finding.severity == Severity::Blocking);
    if blocked {
        results::findings(&mut page, document);
    }
    plots(&mut page, evidence, figures);
    ensemble::ensemble(
        &mut page,
        document,
        figures.iter().find(|figure| figure.name == plot::DRIVERS),
    );
    results::runs(&mut page, document);
    results::impacts(&mut page, document);
    results::budget(&mut page, document);
    ensemble::filters(&mut page, document);
    results::screens(&mut page, document);
    results::ladder(&mut page, document);
    if !blocked {
        results::findings(&mut page, document);
    }
    sources::recording(&mut page, document);
    sources::conditioning(&mut page, document);
    sources::design(&mut page, document);
    sources::provenance(&mut page, document);
    sources::limits(&mut page, document);
    sources::end(&mut page, &identity);
    page.raw("</main>\n</body>\n</html>\n");
    page.into_string()
}

fn plots(page: &mut Page, evidence: Option<&Evidence>, figures: &[Figure]) {
    page.section("plots", "Signal and response");
    if figures.is_empty() {
        page.paragraph(if evidence.is_none() {
            "Nothing was conditioned or replayed, so there is nothing to draw."
        } else {
            "The recording holds nothing that could be drawn."
        });
    }
    for figure in figures {
        // What drives the peak stands beside the ensemble.
        if figure.name != plot::DRIVERS {
            page.figure(figure);
        }
    }
    page.end_section();
}
