//! What the terminal and the page of `latchgate margin` say of an answer in the same words.

use super::number::plain;
use crate::margin::Margin;

/// Returns a bracket with as many digits as tell its ends apart, 17 at most.
pub(super) fn bracket((low, high): (f64, f64)) -> String {
    let digits = (4..=17)
        .find(|digits| plain(low, *digits) != plain(high, *digits))
        .unwrap_or(17);
    format!("[{}, {}]", plain(low, digits), plain(high, digits))
}

/// Returns an answer's value with its unit.
pub(super) fn with_unit(value: f64, unit: &str) -> String {
    let number = plain(value, 6);
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

/// Returns what happens where the answer changes.
pub(super) fn direction(answer: &Margin) -> &'static str {
    let above = answer.at.is_some_and(|at| at > answer.present);
    match (answer.passes_at_present, above) {
        (true, true) => "no pass just above",
        (true, false) => "no pass just below",
        (false, true) => "passes just above",
        (false, false) => "passes just below",
    }
}
