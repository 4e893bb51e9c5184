//! `report.html`: one file that opens offline, in light and dark, and prints on A4.
//!
//! The page fetches nothing and is complete without its script, which lets the first plot be read
//! off and zoomed. Page one decides: verdict, event, findings, test and design. Page two says how
//! sure that is. The rest is folded; in print it stands where it was unfolded.
//!
//! `card` is the head of the page, `results` what the runs say, `ensemble` the scattered levers,
//! `sources` what all rests on; `margin` is the page of margins, `overlay` that of two verdicts. `markup` escapes every text,
//! `sheet` is the style.

mod card;
mod ensemble;
mod margin;
mod markup;
mod overlay;
mod results;
mod sources;

pub(super) use self::margin::page as margin_page;
use self::markup::Page;
pub use self::overlay::DifferenceRow;
pub(super) use self::overlay::page as overlay_page;
use super::page::PageFrame;
use super::plot::{self, Figure};
use super::{series, sheet, words};
use latchgate_document::Document;
use latchgate_verdict::Evidence;

/// Returns the report as one self-contained HTML document.
pub fn render(document: &Document, evidence: Option<&Evidence>) -> String {
    page(document, evidence, &plot::figures(document, evidence))
}

/// As [`render`], with plots that are already drawn.
pub(super) fn page(document: &Document, evidence: Option<&Evidence>, figures: &[Figure]) -> String {
    let name = words::report_name(document);
    let data = evidence.and_then(|evidence| {
        let data = plot::event_data(document, evidence)?;
        Some((data, series::csv(&evidence.series)))
    });
    let title = format!(
        "{} · {} · latchgate",
        words::answer(document.verdict),
        document.recording.file
    );
    let style = sheet::of_report(&name);
    let frame = PageFrame {
        title: &title,
        style: &style,
        script: if data.is_some() { SCRIPT } else { "" },
    };
    let bytes: usize = figures.iter().map(Figure::size).sum();
    let bytes = bytes + data.as_ref().map_or(0, |(_, table)| table.len());
    let mut page = Page::with_capacity(bytes + 96 * 1024);
    page.raw(&frame.head());
    page.raw("<main>\n");
    first_page(&mut page, document, figures, &name);
    second_page(&mut page, document);
    appendix(&mut page, document, evidence, figures);
    sources::end(&mut page, &name);
    page.raw("</main>\n");
    if let Some((data, table)) = data {
        block(&mut page, "event-data", "application/json", &data);
        // A page that holds very long series would open slowly; they stand beside it.
        if table.len() > SERIES_BYTES {
            block(&mut page, "series", "text/csv", "");
        } else {
            block(&mut page, "series", "text/csv", &table);
        }
    }
    page.raw(&frame.tail());
    page.into_string()
}

/// Bytes of series that a page takes in.
pub(super) const SERIES_BYTES: usize = 6 << 20;

/// What lets the first plot be read off and zoomed.
const SCRIPT: &str = include_str!("html/event.js");

/// Writes a block of data that nothing runs.
fn block(page: &mut Page, id: &str, kind: &str, text: &str) {
    page.raw(&format!("<script type=\"{kind}\" id=\"{id}\">"));
    // Names of what was measured do not stand here, so that nothing ends the block but its end.
    page.raw(&text.replace('<', "\\u003c").replace('&', "\\u0026"));
    page.raw("</script>\n");
}

fn figure<'a>(figures: &'a [Figure], name: &str) -> Option<&'a Figure> {
    figures.iter().find(|figure| figure.name == name)
}

/// Writes what decides.
fn first_page(page: &mut Page, document: &Document, figures: &[Figure], name: &str) {
    card::head(page, document, name);
    card::verdict(page, document);
    if let Some(event) = figure(figures, plot::EVENT) {
        page.figure(event);
    }
    results::main_findings(page, document);
    sources::judged(page, document);
}

/// Writes how sure the answer is.
fn second_page(page: &mut Page, document: &Document) {
    page.raw("<div class=\"second\">\n");
    results::budget(page, document);
    ensemble::ensemble(page, document);
    ensemble::filters(page, document);
    sources::limits(page, document);
    page.raw("</div>\n");
}

/// A part of the page: its name, its title, and what writes it.
type PagePart<'a> = (&'a str, &'a str, &'a dyn Fn(&mut Page));

/// Writes everything else, folded.
fn appendix(page: &mut Page, document: &Document, evidence: Option<&Evidence>, figures: &[Figure]) {
    page.section("appendix", "Appendix");
    if figures.is_empty() {
        page.paragraph(if evidence.is_none() {
            "Nothing was conditioned or replayed, so there is nothing to draw."
        } else {
            "The recording holds nothing that could be drawn."
        });
    }
    page.note("Unfold what is to be printed with the report.");
    let parts: [PagePart<'_>; 10] = [
        ("reasons", "Why", &|page| card::why(page, document)),
        ("runs", "Runs compared", &|page| {
            results::runs(page, document)
        }),
        ("impacts", "Impacts of the nominal run", &|page| {
            results::impacts(page, document)
        }),
        ("inputs", "What the peak is sensitive to", &|page| {
            ensemble::sensitivity(page, document, figure(figures, plot::DRIVERS));
        }),
        ("bounds", "Bounds that need no integration", &|page| {
            results::screens(page, document)
        }),
        ("all-findings", "All findings", &|page| {
            results::findings(page, document)
        }),
        ("plots", "Signal and response, all plots", &|page| {
            plots(page, figures)
        }),
        ("recording", "Recording and conditioning", &|page| {
            sources::recording(page, document);
            sources::conditioning(page, document);
        }),
        ("design", "Design", &|page| sources::design(page, document)),
        ("provenance", "How to repeat it", &|page| {
            sources::provenance(page, document)
        }),
    ];
    for (id, title, write) in parts {
        page.fold(id, title, write);
    }
    page.end_section();
}

fn plots(page: &mut Page, figures: &[Figure]) {
    for figure in figures {
        if ![plot::DRIVERS, plot::EVENT].contains(&figure.name) {
            page.figure(figure);
        }
    }
}
