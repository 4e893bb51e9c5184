//! What the terminal and the page of `latchgate margin` say of an answer in the same words.

use latchgate_document::margin_document::MarginDocument;
use latchgate_document::number::plain;
use latchgate_kernel::units::shortest;
use latchgate_verdict::margin::Margin;

/// Returns a bracket with as many digits as tell its ends apart, 17 at most.
pub(super) fn bracket((low, high): (f64, f64)) -> String {
    let digits = (4..=17)
        .find(|digits| plain(low, *digits) != plain(high, *digits))
        .unwrap_or(17);
    format!("[{}, {}]", plain(low, digits), plain(high, digits))
}

/// Returns an answer's value with its unit.
pub(super) fn with_unit(value: f64, unit: &str) -> String {
    of_unit(plain(value, 6), unit)
}

fn of_unit(number: String, unit: &str) -> String {
    if unit.is_empty() {
        number
    } else {
        format!("{number} {unit}")
    }
}

/// Returns the change in percent with its sign.
pub(super) fn change(answer: &Margin) -> String {
    answer.change_percent.map_or_else(
        || "-".to_string(),
        |percent| {
            let sign = if percent >= 0.0 { "+" } else { "" };
            format!("{sign}{} %", plain(percent, 4))
        },
    )
}

/// Returns a number with four digits at most and its unit.
pub(super) fn shown(value: f64, unit: &str) -> String {
    of_unit(shortest(value), unit)
}

/// Returns the value from which on every value searched passes, and to which side.
pub(super) fn advised(answer: &Margin) -> String {
    let side = if answer.quantity.is_safer_above() {
        "and above"
    } else {
        "and below"
    };
    answer.advice.safe_from.map_or_else(
        || "none found".into(),
        |from| format!("{} {side}", shown(from, &answer.unit)),
    )
}

/// Returns what happens where the answer changes.
pub(super) fn direction(answer: &Margin) -> &'static str {
    let above = answer.at.is_some_and(|at| at > answer.present);
    match (answer.passes_at_present, above) {
        (true, true) => "no pass just above",
        (true, false) => "no pass just below",
        (false, _) if answer.isolated => "an isolated pass",
        (false, true) => "passes just above",
        (false, false) => "passes just below",
    }
}

/// Returns each quantity without an advice, and why, those with the same reason together.
pub(super) fn never(document: &MarginDocument) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    for answer in &document.answers {
        let Some(why) = &answer.advice.reason else {
            continue;
        };
        match found.iter_mut().find(|(_, known)| known == why) {
            Some((titles, _)) => {
                titles.push_str(", ");
                titles.push_str(&answer.title);
            }
            None => found.push((answer.title.to_string(), why.clone())),
        }
    }
    found
}
