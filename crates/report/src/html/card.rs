//! The head of the page and the verdict card.

use super::markup::channel_and_design;
use crate::escape::terminal as line;
use crate::{headline, opening, words};
use latchgate_document::Document;
use latchgate_document::number::{count, trimmed};
use latchgate_verdict::Answer;
use maud::{Markup, PreEscaped, html};
use std::f64::consts::FRAC_PI_2;

/// Returns the report's title and identity.
pub(super) fn head(document: &Document, identity: &str) -> Markup {
    let recording = &document.recording;
    html! {
        header {
            div {
                p { "Door latch replay report" }
                h1 { (line(&recording.file)) }
                p { (channel_and_design(recording, &document.design)) }
            }
            div.id {
                p { "Report " code { (line(identity)) } }
                p { "latchgate " (line(&document.run.version)) }
            }
        }
    }
}

/// Returns the verdict card: the word, its meaning, the figures behind it, the directions and the reasons.
pub(super) fn verdict(document: &Document) -> Markup {
    html! {
        section #verdict .card.(document.verdict.name()) {
            (answer(document))
            @if document.verdict == Answer::Unusable {
                @if let Some(text) = words::before_fault(document) { p { (line(text)) } }
            } @else {
                (rests_on(document))
            }
        }
    }
}

/// Returns the word of the verdict, its meaning, and the figures behind it.
pub(super) fn answer(document: &Document) -> Markup {
    html! {
        div.answer {
            (icon(document.verdict))
            div { strong { (words::answer(document.verdict)) } span { (line(&headline::headline(document))) } }
        }
        // Figures of an unusable recording would be read as an answer.
        @if document.verdict != Answer::Unusable {
            @if document.polarities.len() > 1 { (directions(document)) } @else { (key_figures(document)) }
        }
    }
}

/// Returns the answer of each opening direction, side by side.
fn directions(document: &Document) -> Markup {
    html! {
        dl.key.two {
            @for row in words::directions(document) {
                (item(&format!("If {} acceleration opens", row.sign), row.word, &row.text))
            }
        }
    }
}

fn key_figures(document: &Document) -> Markup {
    let Some(run) = words::leading_run(document) else {
        return html! {};
    };
    let (time, stop) = (words::brief_time(run.peak_time_s), run.model.label());
    let degrees = trimmed(document.threshold_rad.to_degrees(), 3);
    html! {
        dl.key {
            @if run.peak_angle_rad > FRAC_PI_2 {
                (item("Largest angle", &words::short_peak(document, run), stop))
            } @else if words::has_figure(document, run) {
                (item("Largest angle", &words::short_peak(document, run), &format!("at {time}, {stop}")))
            } @else {
                (item("Largest angle", "not known", &words::short_peak(document, run)))
            }
            (item("Limit angle", &format!("{degrees}°"), &words::limit(document.threshold_rad)))
            @if let Some(opens) = document.opens.filter(|opens| opens.first_s.is_some()) {
                @let place = words::place(opens.model, opens.opens_when);
                (item(&words::capital(opening::opens_or_may(document.verdict)), &opening::cell(&opens), &place))
            } @else if document.verdict == Answer::Undecided {
                (item("Opens", "not known", "the nominal lever stays"))
            } @else {
                (item("Opens", "no", "in the judged window"))
            }
            (varied_levers(document))
        }
    }
}

fn varied_levers(document: &Document) -> Markup {
    if let Some(ensemble) = words::decisive_ensemble(document) {
        let crossing = count(u64::from(ensemble.exceeded));
        let crossing = format!("{crossing} of {}", count(u64::from(ensemble.members)));
        let name = format!("{} that open", words::capital(ensemble.varied.members()));
        let others = words::other_shares(document, ensemble);
        let share = match others.is_empty() {
            true => words::share(ensemble),
            false => format!(
                "{}: {}; {}",
                ensemble.model.label(),
                words::share(ensemble),
                others.join("; ")
            ),
        };
        return item(&name, &crossing, &share);
    }
    match words::sparing_bound(document) {
        Some(bound) => {
            let why = format!("the worst {}", bound.name());
            item("Varied levers that open", "none can", &why)
        }
        None if words::is_alone(document) => {
            item("Varied", "nothing", "this one lever, on this one reading")
        }
        None => item("Varied levers", "none", "the nominal lever alone"),
    }
}

/// Returns the grounds of the verdict, a line each.
fn rests_on(document: &Document) -> Markup {
    let run = document.nominal.as_ref();
    let mut lines = Vec::new();
    if document.polarities.len() < 2 {
        let stops = words::stops(document);
        lines.extend(stops.map(|text| format!("{}.", words::capital(&text))));
    }
    lines.extend(words::in_plane(document).map(|text| format!("In plane: {text}.")));
    lines.extend(words::catch(document).map(String::from));
    let leading = words::leading_run(document);
    lines.extend(leading.and_then(|run| words::computation(document, run)));
    // A lever that opens within the record needs no word on what follows the record.
    let later = run.filter(|_| document.verdict != Answer::Fail);
    let later = later.and_then(|run| {
        Some(run.coast_peak_angle_rad?).filter(|coast| *coast > run.peak_angle_rad)
    });
    if let Some(coast) = later {
        let coast = words::bounded_angle(coast);
        lines.push(format!(
            "After the record ends the lever could still reach {coast}."
        ));
    }
    // An isolated pass is told first and in the colour of a warning.
    let mut cautions = Vec::new();
    for (text, is_isolated) in [
        (words::preload(document), words::is_isolated_pass(document)),
        (
            words::restitution(document),
            words::is_isolated_restitution(document),
        ),
    ] {
        let place = if is_isolated {
            &mut cautions
        } else {
            &mut lines
        };
        place.extend(text.map(|text| words::sentence(&text)));
    }
    lines.extend(words::what_was_varied(document).map(|text| format!("Varied: {text}.")));
    if document.verdict == Answer::Pass {
        lines.push(format!("{}.", words::capital(words::UNSEEN)));
    }
    html! {
        ul.why {
            @for text in &cautions { li.caution { (line(text)) } }
            @for text in &lines { li { (line(text)) } }
        }
    }
}

/// Returns every reason.
pub(super) fn why(document: &Document) -> Markup {
    html! {
        ul.why {
            @for reason in &document.why {
                li { (line(&words::sentence(&reason.text))) code { (line(&reason.code)) } }
            }
        }
        p.note { (line(&words::polarity_sentence(document))) }
    }
}

fn item(name: &str, value: &str, below: &str) -> Markup {
    html! { div { dt { (name) } dd.value { (line(value)) } dd { (line(below)) } } }
}

/// Returns the verdict's sign. Each verdict has another shape, so that colour is not needed.
fn icon(answer: Answer) -> Markup {
    let shape = match answer {
        Answer::Pass => {
            r#"<circle cx="32" cy="32" r="29" fill="var(--tone)"/>
<path d="M18 33l10 10 19-21" fill="none" stroke="var(--paper)" stroke-width="7" stroke-linecap="round" stroke-linejoin="round"/>"#
        }
        Answer::Fail => {
            r#"<path d="M20 3h24l17 17v24L44 61H20L3 44V20z" fill="var(--tone)"/>
<path d="M22 22l20 20M42 22L22 42" fill="none" stroke="var(--paper)" stroke-width="7" stroke-linecap="round"/>"#
        }
        Answer::Undecided => {
            r#"<path d="M32 2l30 30-30 30L2 32z" fill="var(--tone)"/>
<path d="M24 26c0-11 17-11 17-1 0 7-8 7-9 14" fill="none" stroke="var(--paper)" stroke-width="6" stroke-linecap="round"/>
<circle cx="32" cy="49" r="3.8" fill="var(--paper)"/>"#
        }
        Answer::Unusable => {
            r#"<path d="M32 4l30 55H2z" fill="var(--tone)" stroke="var(--tone)" stroke-width="3" stroke-linejoin="round"/>
<path d="M32 24v17" fill="none" stroke="var(--paper)" stroke-width="6.5" stroke-linecap="round"/>
<circle cx="32" cy="50" r="3.9" fill="var(--paper)"/>"#
        }
    };
    html! { svg viewBox="0 0 64 64" aria-hidden="true" { (PreEscaped(shape)) } }
}
