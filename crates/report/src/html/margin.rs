//! The page of `latchgate margin`.

use super::markup::Page;
use crate::margin_words::{advised, bracket, change, direction, never};
use crate::plot::{Figure, MARGIN_RULES};
use crate::sheet;
use crate::words;
use latchgate_document::MarginDocument;
use latchgate_document::number::{ABSENT, significant};
use latchgate_verdict::margin::{Change, Quantity};

/// Returns the page as one self-contained HTML document.
pub(crate) fn page(document: &MarginDocument, figures: &[Figure]) -> String {
    let bytes: usize = figures.iter().map(Figure::size).sum();
    let mut page = Page::with_capacity(bytes + 64 * 1024);
    let recording = &document.recording;
    page.raw("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n");
    page.raw("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n");
    page.raw("<meta name=\"color-scheme\" content=\"light dark\"/>\n<title>margin · ");
    page.text(&recording.file);
    page.raw(" · latchgate</title>\n<style>\n");
    page.raw(&sheet::style("margin"));
    page.raw(MARGIN_RULES);
    page.raw("</style>\n</head>\n<body>\n<main>\n<header>\n<div>\n<p>Margin of a door latch verdict</p>\n");
    page.element("h1", "", &recording.file);
    page.raw("\n<p>");
    if let Some(channel) = &recording.channel {
        page.text(&format!("channel {channel} · "));
    }
    page.text(&format!("design {}", words::design(&document.design)));
    page.raw("</p>\n</div>\n<div class=\"id\">\n<p>latchgate ");
    page.text(&document.run.version);
    page.raw("</p>\n</div>\n</header>\n");
    card(&mut page, document);
    answers(&mut page, document);
    boundaries(&mut page, document);
    page.section("charts", "Charts");
    for figure in figures {
        page.raw("<figure id=\"");
        page.raw(figure.name);
        page.raw("\">\n");
        page.raw(&figure.inline());
        page.raw("<figcaption>");
        page.text(&figure.caption);
        page.raw("</figcaption>\n</figure>\n");
    }
    page.end_section();
    findings(&mut page, document);
    page.section("provenance", "Provenance");
    page.facts();
    page.code_fact("Report", &document.report_id);
    page.code_fact("SHA-256", recording.sha256.as_deref().unwrap_or(ABSENT));
    page.code_fact("Settings", &words::settings(&document.request));
    page.end_table();
    page.end_section();
    page.raw("</main>\n</body>\n</html>\n");
    page.into_string()
}

fn card(page: &mut Page, document: &MarginDocument) {
    page.raw("<section id=\"verdict\" class=\"card ");
    page.raw(document.verdict.name());
    page.raw("\">\n<div class=\"answer\"><div>");
    page.element("strong", "", words::answer(document.verdict));
    let of_preload = document
        .answers
        .iter()
        .find(|answer| answer.quantity == Quantity::Preload);
    let answer = of_preload.map_or("", |answer| answer.advice.text.as_str());
    page.element("span", "", answer);
    page.raw("</div>\n</div>\n<ul class=\"why\">\n");
    for note in &document.notes {
        page.element("li", "", note);
        page.raw("\n");
    }
    page.raw("</ul>\n</section>\n");
}

fn answers(page: &mut Page, document: &MarginDocument) {
    page.wide_section("margins", "What would change the answer");
    flips(page, document);
    searched(page, document);
    if let Some(mass) = document.counterweight.mass_kg {
        page.note(&format!(
            "A counterweight of {} kg, fixed to the lever at {} m, leaves an unbalance of {} kg·m and a moment of inertia of {} kg·m².",
            significant(mass, 5),
            document.counterweight.radius_m,
            document.counterweight.unbalance_kg_m.map_or_else(|| ABSENT.into(), |v| significant(v, 5)),
            document.counterweight.moment_of_inertia_kg_m2.map_or_else(|| ABSENT.into(), |v| significant(v, 5)),
        ));
    }
    page.end_section();
}

/// Writes where the answer changes, a line for each quantity.
fn flips(page: &mut Page, document: &MarginDocument) {
    page.table(
        "margins",
        &[
            "Quantity",
            "#Present",
            "#Passes from",
            "#Tried to",
            "#Nearest change",
            "#Change",
            "There",
        ],
    );
    for answer in &document.answers {
        page.raw("<tr>");
        page.element("th", "", &answer.title);
        let shown = |value: f64| answer.quantity.shown(value);
        page.element("td", "number", &shown(answer.present));
        page.element("td", "number nominal", &advised(answer));
        page.element("td", "number", &shown(answer.advice.until));
        match answer.at() {
            Some(at) => {
                page.element("td", "number", &shown(at));
                let change = change(answer).map(|change| change.replace('-', "\u{2212}"));
                page.element("td", "number", change.as_deref().unwrap_or(ABSENT));
                page.element("td", "", direction(answer));
            }
            None => {
                page.element("td", "number", "none");
                page.element("td", "number", ABSENT);
                page.element("td", "", ABSENT);
            }
        }
        page.raw("</tr>\n");
    }
    page.end_table();
    for (title, why) in never(document) {
        page.note(&format!("{title}: {why}."));
    }
}

/// Writes both bases of each number, its range and its convention.
fn searched(page: &mut Page, document: &MarginDocument) {
    page.table(
        "margins",
        &[
            "Quantity",
            "#Nominal peak meets the limit at",
            "#Verdict changes at",
            "#Width of the bracket",
            "#Tried",
            "What stays and what moves along",
        ],
    );
    let number =
        |value: Option<f64>| value.map_or_else(|| ABSENT.to_string(), |v| significant(v, 6));
    for answer in &document.answers {
        page.raw("<tr>");
        page.element("th", "", &answer.title);
        let change = |change: Option<Change>| number(change.map(|change| change.passes));
        page.element("td", "number", &change(answer.nominal_change));
        page.element("td", "number", &change(answer.verdict_change));
        let width = answer.change.map(|change| {
            let (low, high) = change.bracket();
            significant(high - low, 2)
        });
        page.element("td", "number", width.as_deref().unwrap_or(ABSENT));
        page.element(
            "td",
            "number",
            &format!(
                "{} to {}, {} values",
                significant(answer.searched.0, 3),
                significant(answer.searched.1, 3),
                answer.values
            ),
        );
        page.element("td", "", &words::sentence(&answer.convention));
        page.raw("</tr>\n");
    }
    page.end_table();
}

fn boundaries(page: &mut Page, document: &MarginDocument) {
    page.wide_section("boundaries", "Changes of the nominal runs’ answer");
    if document.boundaries.is_empty() {
        page.paragraph("None between the values tried.");
        page.end_section();
        return;
    }
    page.table(
        "findings",
        &["Quantity", "#At", "Below", "Above", "#Bracket"],
    );
    for boundary in document.boundaries.iter().take(BOUNDARIES_SHOWN) {
        let title = document
            .answers
            .iter()
            .find(|answer| answer.quantity.name() == boundary.quantity)
            .map_or(&boundary.quantity, |answer| &answer.title);
        let unit = match &*boundary.unit {
            "" => "–",
            unit => unit,
        };
        page.raw("<tr>");
        page.element("th", "", &format!("{title} [{unit}]"));
        page.element("td", "number", &significant(boundary.at, 9));
        page.element("td", "", boundary.below.name());
        page.element("td", "", boundary.above.name());
        page.element("td", "number", &bracket(boundary.bracket));
        page.raw("</tr>\n");
    }
    page.end_table();
    let more = document.boundaries.len().saturating_sub(BOUNDARIES_SHOWN);
    if more > 0 {
        page.note(&format!("{more} more stand in margin.json."));
    }
    page.end_section();
}

/// Changes of the nominal runs' answer that the page lists.
const BOUNDARIES_SHOWN: usize = 12;

fn findings(page: &mut Page, document: &MarginDocument) {
    page.section("findings", "Findings");
    if document.findings.is_empty() {
        page.paragraph("Nothing odd was found in the recording, its conditioning or its replay.");
    } else {
        page.table("findings", &["Severity", "What was found"]);
        for finding in &document.findings {
            page.raw("<tr>");
            page.element("td", "", words::severity(finding.severity));
            page.raw("<td>");
            page.text(&words::sentence(&finding.text));
            page.element("code", "", &finding.code);
            page.raw("</td></tr>\n");
        }
        page.end_table();
    }
    page.end_section();
}
