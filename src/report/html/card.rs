//! The head of the page and the verdict card.

use super::ensemble;
use super::markup::Page;
use crate::recording::Severity;
use crate::replay::Run;
use crate::report::Document;
use crate::report::number::{exact, significant};
use crate::report::words::{self, angle, margin, time};
use crate::verdict::Answer;
use std::fmt::Write as _;

/// Writes the report's title and identity.
pub(super) fn head(page: &mut Page, document: &Document, identity: &str) {
    let recording = &document.recording;
    page.raw("<header>\n<div>\n<p>Door latch replay report</p>\n");
    page.element("h1", "", &recording.file);
    page.raw("\n<p>");
    if let Some(channel) = &recording.channel {
        page.text("channel ");
        page.text(channel);
        page.text(" · ");
    }
    page.text("design ");
    page.text(&document.design.name);
    page.raw("</p>\n</div>\n<div class=\"id\">\n<p>Report ");
    page.element("code", "", identity);
    page.raw("</p>\n<p>latchgate ");
    page.text(&document.run.version);
    page.raw("</p>\n</div>\n</header>\n");
}

/// Writes the verdict card.
pub(super) fn verdict(page: &mut Page, document: &Document) {
    page.raw("<section id=\"verdict\" class=\"card ");
    page.raw(document.verdict.name());
    page.raw("\">\n<div class=\"answer\">\n");
    page.raw(icon(document.verdict));
    page.raw("<div>");
    page.element("strong", "", words::answer(document.verdict));
    page.element("span", "", words::meaning(document));
    page.raw("</div>\n<div class=\"exit\">exit code ");
    page.text(&document.verdict.exit_code().to_string());
    page.raw("</div>\n</div>\n");
    key_figures(page, document);
    if let Some(run) = &document.nominal {
        gauge(page, document, run);
        coast(page, run);
    }
    ensemble::gauge(page, document);
    if let Some(preload) = &document.preload_answer {
        page.raw("<p class=\"sum\"><strong>Design.</strong> ");
        page.text(&words::sentence(&preload.text));
        page.raw("</p>\n");
    }
    if let Some(ladder) = &document.ladder {
        page.raw("<p class=\"sum\"><strong>Decided by</strong> ");
        page.text(ladder.rung.name());
        page.raw(". <a href=\"#ladder\">How far the decision went</a></p>\n");
    }
    page.raw("<ul class=\"why\">\n");
    for reason in &document.why {
        page.raw("<li>");
        page.text(&words::sentence(&reason.text));
        page.element("code", "", &reason.code);
        page.raw("</li>\n");
    }
    page.raw("</ul>\n<p class=\"sum\">");
    page.text(&words::polarity_sentence(document));
    page.raw("</p>\n<p class=\"sum\">");
    page.text(&findings_sum(document));
    page.raw(" <a href=\"#findings\">Findings</a></p>\n</section>\n");
}

fn key_figures(page: &mut Page, document: &Document) {
    if document.verdict == Answer::Unusable && document.nominal.is_some() {
        page.raw("<p class=\"caution\">");
        page.text(
            "The figures below describe the replay of a recording that carries no answer. They \
             are no evidence that the door stays shut.",
        );
        page.raw("</p>\n");
    }
    let Some(run) = &document.nominal else {
        page.raw("<dl class=\"key\">\n");
        item(page, "Peak angle", "not judged", "nothing was replayed");
        item(page, "Limit", &words::limit(document), "of the design");
        page.raw("</dl>\n");
        return;
    };
    page.raw("<dl class=\"key\">\n");
    let which = format!(
        "{}, {}",
        words::stop(run.model),
        words::opens(run.opens_when)
    );
    item(
        page,
        "Peak angle",
        &angle(run.peak_angle_rad),
        &format!("at {}; {which}", time(run.peak_time_s)),
    );
    item(
        page,
        "Limit",
        &words::limit(document),
        "the angle must not exceed it",
    );
    let (margin, share) = margin(document.threshold_rad, run.peak_angle_rad);
    item(
        page,
        "Margin (limit − peak)",
        &angle(margin),
        &format!("{}\u{00A0}% of the limit", significant(share, 4)),
    );
    match run.first_crossing_s {
        Some(at) => item(
            page,
            "First crossing",
            &time(at),
            &format!(
                "above the limit for {} in all",
                time(run.time_above_threshold_s)
            ),
        ),
        None => item(page, "First crossing", "none", "in the judged window"),
    }
    page.raw("</dl>\n");
}

fn coast(page: &mut Page, run: &Run) {
    if let Some(coast) = run.coast_peak_angle_rad {
        let compared = if coast > run.peak_angle_rad {
            "more than the peak above"
        } else {
            "no more than the peak above"
        };
        page.note(&format!(
            "After the last judged sample the lever coasts on to {} at most, {compared}.",
            angle(coast)
        ));
    }
}

fn item(page: &mut Page, name: &str, value: &str, below: &str) {
    page.raw("<div>");
    page.element("dt", "", name);
    page.element("dd", "value", value);
    page.element("dd", "", below);
    page.raw("</div>\n");
}

/// Draws the peak as a bar against the limit.
fn gauge(page: &mut Page, document: &Document, run: &Run) {
    let (peak, limit) = (run.peak_angle_rad.max(0.0), document.threshold_rad);
    let full = peak.max(limit) * 1.12;
    if !(full.is_finite() && full > 0.0) {
        return;
    }
    let x = |value: f64| value / full * 860.0;
    let limit_x = x(limit);
    let anchor = if limit_x > 640.0 { "end" } else { "start" };
    let text_x = if limit_x > 640.0 {
        limit_x - 7.0
    } else {
        limit_x + 7.0
    };
    let mut svg = String::new();
    // Writing into a String cannot fail.
    let _ = writeln!(
        svg,
        "<svg class=\"gauge\" viewBox=\"0 0 860 38\" aria-hidden=\"true\">\
         <rect class=\"track\" x=\"0\" y=\"20\" width=\"860\" height=\"12\" rx=\"2\"/>\
         <rect class=\"bar\" x=\"0\" y=\"20\" width=\"{:.2}\" height=\"12\" rx=\"2\"/>\
         <line class=\"limit\" x1=\"{limit_x:.2}\" y1=\"6\" x2=\"{limit_x:.2}\" y2=\"36\"/>\
         <text x=\"{text_x:.2}\" y=\"14\" text-anchor=\"{anchor}\">limit {} rad</text></svg>",
        x(peak).max(1.0),
        exact(limit)
    );
    page.raw(&svg);
}

fn findings_sum(document: &Document) -> String {
    let number = |severity| {
        document
            .findings
            .iter()
            .filter(|finding| finding.severity == severity)
            .count()
    };
    let parts: Vec<String> = [
        (number(Severity::Blocking), "blocking", "blocking"),
        (number(Severity::Warning), "warning", "warnings"),
        (number(Severity::Info), "note", "notes"),
    ]
    .into_iter()
    .filter(|(number, _, _)| *number > 0)
    .map(|(number, one, many)| format!("{number} {}", if number == 1 { one } else { many }))
    .collect();
    if parts.is_empty() {
        "Nothing odd was found in the recording.".into()
    } else {
        format!(
            "Found in the recording and its replay: {}.",
            parts.join(", ")
        )
    }
}

/// Returns the verdict's sign: a shape of its own for each, so that colour is not needed.
fn icon(answer: Answer) -> &'static str {
    match answer {
        Answer::Pass => {
            "<svg viewBox=\"0 0 64 64\" aria-hidden=\"true\"><circle cx=\"32\" cy=\"32\" r=\"29\" fill=\"var(--tone)\"/>\
             <path d=\"M18 33l10 10 19-21\" fill=\"none\" stroke=\"var(--paper)\" stroke-width=\"7\" stroke-linecap=\"round\" stroke-linejoin=\"round\"/></svg>\n"
        }
        Answer::Fail => {
            "<svg viewBox=\"0 0 64 64\" aria-hidden=\"true\"><path d=\"M20 3h24l17 17v24L44 61H20L3 44V20z\" fill=\"var(--tone)\"/>\
             <path d=\"M22 22l20 20M42 22L22 42\" fill=\"none\" stroke=\"var(--paper)\" stroke-width=\"7\" stroke-linecap=\"round\"/></svg>\n"
        }
        Answer::Undecided => {
            "<svg viewBox=\"0 0 64 64\" aria-hidden=\"true\"><path d=\"M32 2l30 30-30 30L2 32z\" fill=\"var(--tone)\"/>\
             <path d=\"M24 26c0-11 17-11 17-1 0 7-8 7-9 14\" fill=\"none\" stroke=\"var(--paper)\" stroke-width=\"6\" stroke-linecap=\"round\"/>\
             <circle cx=\"32\" cy=\"49\" r=\"3.8\" fill=\"var(--paper)\"/></svg>\n"
        }
        Answer::Unusable => {
            "<svg viewBox=\"0 0 64 64\" aria-hidden=\"true\"><path d=\"M32 4l30 55H2z\" fill=\"var(--tone)\" stroke=\"var(--tone)\" stroke-width=\"3\" stroke-linejoin=\"round\"/>\
             <path d=\"M32 24v17\" fill=\"none\" stroke=\"var(--paper)\" stroke-width=\"6.5\" stroke-linecap=\"round\"/>\
             <circle cx=\"32\" cy=\"50\" r=\"3.9\" fill=\"var(--paper)\"/></svg>\n"
        }
    }
}
