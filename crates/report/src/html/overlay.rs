//! The page of `latchgate compare`: two verdicts side by side, what differs, their curves overlaid.

use super::markup::Page;
use super::{SCRIPT, SERIES_BYTES, block};
use crate::page::PageFrame;
use crate::plot::overlay;
use crate::series::SeriesTable;
use crate::{Document, sheet, words};

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
    let mut page = Page::with_capacity(256 * 1024);
    page.raw(&frame.head());
    page.raw("<main>\n<header>\n<div>\n<p>Two verdicts compared</p>\n");
    let files = documents.map(|document| document.recording.file.as_str());
    let title = if files[0] == files[1] {
        files[0].to_string()
    } else {
        files.join(" and ")
    };
    page.element("h1", "", &title);
    page.raw("\n</div>\n</header>\n<div class=\"pair\">\n");
    for (document, letter) in documents.into_iter().zip(["A", "B"]) {
        card(&mut page, document, letter);
    }
    page.raw("</div>\n");
    match &drawn {
        Some((figure, _, _)) => page.figure(figure),
        None => page.paragraph(
            "There are no curves: the table of series beside one of the verdicts is missing, or the \
             records have no instant in common.",
        ),
    }
    page.section("differences", "What differs");
    if differences.is_empty() {
        page.paragraph("Nothing.");
    } else {
        page.table("differences", &["part", "key", "A", "B"]);
        let mut part = "";
        for row in differences {
            let name = if row.part == part { "" } else { &row.part };
            part = &row.part;
            page.raw("<tr>");
            page.element("td", "", name);
            page.raw("<td>");
            page.element("code", "", &row.key);
            page.raw("</td>");
            row.values
                .iter()
                .for_each(|value| page.element("td", "", value));
            page.raw("</tr>\n");
        }
        page.end_table();
    }
    page.end_section();
    page.raw("</main>\n");
    if let Some((_, data, Some(table))) = drawn {
        block(
            &mut page,
            "event-data",
            "application/json",
            &data.to_string(),
        );
        block(&mut page, "series", "text/csv", &table);
    }
    page.raw(&frame.tail());
    page.into_string()
}

fn card(page: &mut Page, document: &Document, letter: &str) {
    page.raw("<section class=\"card ");
    page.raw(document.verdict.name());
    page.raw("\" aria-label=\"Verdict ");
    page.raw(letter);
    page.raw("\">\n<p>");
    page.text(&format!(
        "{letter} · {} · design {} · report {}",
        document.recording.file,
        words::design(&document.design),
        words::report_name(document)
    ));
    page.raw("</p>\n<div class=\"answer\"><div>");
    page.element("strong", "", words::answer(document.verdict));
    page.element("span", "", &words::headline(document));
    page.raw("</div></div>\n</section>\n");
}
