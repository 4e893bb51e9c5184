//! The head of the page and the verdict card.

use super::markup::Page;
use crate::words;
use latchgate_document::Document;
use latchgate_document::number::{count, trimmed};
use latchgate_verdict::Answer;

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
    page.text(&words::design(&document.design));
    page.raw("</p>\n</div>\n<div class=\"id\">\n<p>Report ");
    page.element("code", "", identity);
    page.raw("</p>\n<p>latchgate ");
    page.text(&document.run.version);
    page.raw("</p>\n</div>\n</header>\n");
}

/// Writes the verdict card: the word, what it means, the figures it rests on.
pub(super) fn verdict(page: &mut Page, document: &Document) {
    page.raw("<section id=\"verdict\" class=\"card ");
    page.raw(document.verdict.name());
    page.raw("\">\n<div class=\"answer\">\n");
    page.raw(icon(document.verdict));
    page.raw("<div>");
    page.element("strong", "", words::answer(document.verdict));
    page.element("span", "", &words::headline(document));
    page.raw("</div>\n</div>\n");
    // Figures of a recording that carries no answer would be taken for one.
    if document.verdict != Answer::Unusable {
        if document.polarities.len() > 1 {
            directions(page, document);
        } else {
            key_figures(page, document);
        }
        rests_on(page, document);
    }
    page.raw("</section>\n");
}

/// Writes what each opening direction comes to, side by side.
fn directions(page: &mut Page, document: &Document) {
    page.raw("<dl class=\"key two\">\n");
    for row in words::directions(document) {
        let name = format!("If {} acceleration opens", row.sign);
        item(page, &name, row.word, &row.text);
    }
    page.raw("</dl>\n");
}

fn key_figures(page: &mut Page, document: &Document) {
    let Some(run) = &document.nominal else {
        return;
    };
    page.raw("<dl class=\"key\">\n");
    let at = format!(
        "at {}, {}",
        words::brief_time(run.peak_time_s),
        words::stop(run.model)
    );
    item(
        page,
        "Largest angle",
        &words::short_peak(document, run),
        &at,
    );
    let degrees = trimmed(document.threshold_rad.to_degrees(), 3);
    let limit = words::limit(document);
    item(page, "Limit angle", &limit, &format!("{degrees}°"));
    match run.first_crossing_s {
        Some(at) => {
            let above = words::brief_time(run.time_above_threshold_s);
            let above = format!("above the limit angle for {above}");
            item(page, "Opens at", &words::brief_time(at), &above);
        }
        None => item(page, "Opens", "not", "in the judged window"),
    }
    match &document.ensemble {
        Some(ensemble) => {
            let crossing = count(u64::from(ensemble.exceeded));
            let of = count(u64::from(ensemble.members));
            let share = words::share(ensemble);
            item(
                page,
                "Varied levers that open",
                &format!("{crossing} of {of}"),
                &share,
            );
        }
        None => match words::spared(document) {
            Some(bound) => {
                let why = format!("the loosest {}", bound.name());
                item(page, "Varied levers that open", "none can", &why);
            }
            None => item(page, "Varied levers", "none", "the nominal lever alone"),
        },
    }
    page.raw("</dl>\n");
}

/// Writes what the verdict rests on, a line each.
fn rests_on(page: &mut Page, document: &Document) {
    let run = document.nominal.as_ref();
    let mut lines = Vec::new();
    if document.polarities.len() < 2 {
        let stops = words::stops(document);
        lines.extend(stops.map(|text| format!("{}.", words::capital(&text))));
    }
    lines.extend(run.and_then(|run| words::computation(document, run)));
    if let Some(coast) = run.and_then(|run| run.coast_peak_angle_rad) {
        let coast = words::bounded_angle(coast);
        lines.push(format!(
            "After the record ends the lever could still reach {coast}."
        ));
    }
    if let Some(preload) = &document.preload_answer {
        lines.push(words::sentence(&preload.text));
    }
    if document.verdict == Answer::Pass {
        lines.push(format!("{}.", words::capital(words::UNSEEN)));
    }
    page.raw("<ul class=\"why\">\n");
    for line in lines {
        page.element("li", "", &line);
        page.raw("\n");
    }
    page.raw("</ul>\n");
}

/// Writes every reason.
pub(super) fn why(page: &mut Page, document: &Document) {
    page.raw("<ul class=\"why\">\n");
    for reason in &document.why {
        page.raw("<li>");
        page.text(&words::sentence(&reason.text));
        page.element("code", "", &reason.code);
        page.raw("</li>\n");
    }
    page.raw("</ul>\n");
    page.note(&words::polarity_sentence(document));
}

fn item(page: &mut Page, name: &str, value: &str, below: &str) {
    page.raw("<div>");
    page.element("dt", "", name);
    page.element("dd", "value", value);
    page.element("dd", "", below);
    page.raw("</div>\n");
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
