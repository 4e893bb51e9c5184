//! What is wrong with the text of an answer: lines that do not fit, instants that are not the
//! document's, an error as large as its peak.

use latchgate_document::Document;
use latchgate_report::terminal::Look;
use latchgate_report::{opening, text};
use latchgate_verdict::Answer;
use std::collections::BTreeSet;

/// Columns of what is written to a file.
const COLUMNS: usize = 100;

/// Says what is wrong with the text of an answer.
pub(crate) fn faults(document: &Document) -> Vec<String> {
    let look = Look {
        width: Some(COLUMNS),
        ..Look::default()
    };
    let shown = text::render(document, None, look);
    let mut faults = Vec::new();
    for line in shown.lines() {
        let longest_word = line.split(' ').map(|word| word.chars().count()).max();
        // A word cannot be wrapped.
        if line.chars().count() > COLUMNS && longest_word < Some(COLUMNS - 20) {
            faults.push(format!("more than {COLUMNS} columns: {line}"));
        }
    }
    let whole = shown.split_whitespace().collect::<Vec<_>>().join(" ");
    let known = instants(document);
    for (at, _) in whole.match_indices("opens ") {
        let said = &whole[at + "opens ".len()..];
        if (said.starts_with("at ") || said.starts_with("between "))
            && !known.iter().any(|instant| said.starts_with(instant))
        {
            let said: String = said.chars().take(40).collect();
            faults.push(format!(
                "`opens {said}` is no instant of the document: {known:?}"
            ));
        }
    }
    faults.extend(large_error(&whole));
    faults.extend(pass_too_low(document, &whole));
    faults
}

/// Finds a pass that claims to stay further from the limit than some run with its error does.
fn pass_too_low(document: &Document, whole: &str) -> Option<String> {
    if document.verdict != Answer::Pass {
        return None;
    }
    let said = whole.split("at most ").nth(1)?.split(' ').next()?;
    let said: f64 = said.parse().ok()?;
    let runs = document
        .polarities
        .values()
        .flat_map(|stops| stops.values());
    let runs: Vec<_> = document.models.values().chain(runs).collect();
    let most = document.answers.iter().filter_map(|answer| {
        let mut own = runs
            .iter()
            .filter(|run| (run.model, run.opens_when) == (answer.model, answer.opens_when));
        Some(own.next()?.peak_angle_rad + answer.uncertainty_rad?)
    });
    let most = 100.0 * most.fold(0.0, f64::max) / document.threshold_rad;
    if said < most {
        return Some(format!("at most {said} % is said, {most} % may be"));
    }
    varied_too_low(document, whole, said)
}

/// Finds a pass that hides how far its varied levers come, of whatever stop and opening direction.
fn varied_too_low(document: &Document, whole: &str, nominal: f64) -> Option<String> {
    let ensembles = document.ensembles.iter().chain(&document.ensemble);
    let opening = ensembles.clone().map(|ensemble| ensemble.exceeded).max()?;
    if opening > 0 {
        let shown = whole.contains(&format!("; {opening} of "));
        return (!shown)
            .then(|| format!("{opening} varied levers open, and the headline hides it"));
    }
    let peaks = ensembles.filter_map(|ensemble| ensemble.peak_angle_rad);
    let most = 100.0 * peaks.map(|peak| peak.max).fold(0.0, f64::max) / document.threshold_rad;
    let varied = whole.split("varied levers up to ").nth(1);
    let varied = varied.and_then(|text| text.split(' ').next()?.parse().ok());
    let shown = varied.unwrap_or(nominal);
    (shown < most).then(|| format!("{shown} % is said, varied levers come to {most} %"))
}

/// Returns every instant of opening that may be shown, as it is shown.
fn instants(document: &Document) -> BTreeSet<String> {
    let runs = document
        .polarities
        .values()
        .flat_map(|stops| stops.values());
    let runs = document
        .models
        .values()
        .chain(runs)
        .chain(&document.nominal);
    let nominal = runs
        .filter_map(|run| run.first_crossing_s)
        .map(|at| format!("at {}", opening::nominal_instant(at)));
    let openings = document.opens.iter();
    let openings = openings.chain(document.opens_by_direction.values());
    let named = openings.map(|opens| {
        let sentence = opening::sentence(opens, opening::OPENS);
        let instant = sentence.trim_start_matches("opens ");
        instant.split(" (").next().unwrap_or(instant).to_string()
    });
    let plain = |text: String| text.replace('\u{00A0}', " ");
    nominal.chain(named).map(plain).collect()
}

/// Finds an error that is as large as its peak, in a text like `2.9° ± 0.4°`.
fn large_error(text: &str) -> Option<String> {
    let words: Vec<&str> = text.split(' ').collect();
    let number = |word: &str| {
        let digits = word.trim_matches(|c: char| !c.is_ascii_digit());
        digits.parse::<f64>().ok()
    };
    words.windows(3).find_map(|three| match three {
        [value, "±", error] => {
            let (value, error) = (number(value)?, number(error)?);
            (error > value).then(|| format!("{} is no error of a peak", three.join(" ")))
        }
        _ => None,
    })
}

#[test]
fn verif_an_error_above_its_peak_is_found() {
    assert!(large_error("largest angle 0.4° ± 2.9° (0.1 rad)").is_some());
    assert!(large_error("largest angle 2.9° ± 0.4° (0.1 rad)").is_none());
}
