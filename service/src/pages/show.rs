//! Numbers and words for people.

use latchgate::report::number;
use maud::{Markup, html};
use serde_json::Value;
use std::f64::consts::FRAC_PI_2;

/// Shows a verdict: a sign, a word, a colour.
pub(super) fn verdict(word: &str) -> Markup {
    let sign = match word {
        "pass" => "✓",
        "fail" => "✗",
        "undecided" => "?",
        _ => "∅",
    };
    html! { span.verdict.(word) { span aria-hidden="true" { (sign) } " " (word.to_uppercase()) } }
}

/// Shows an angle, in radians with degrees beside; beyond a right angle only that it is.
pub(super) fn angle(radians: Option<f64>) -> String {
    match radians {
        None => number::ABSENT.into(),
        Some(radians) if radians > FRAC_PI_2 => "> 90°".into(),
        Some(radians) => format!(
            "{} rad ({}°)",
            number::significant(radians, 3),
            number::significant(radians.to_degrees(), 3)
        ),
    }
}

/// Shows an angle with its uncertainty.
pub(super) fn peak(radians: f64, error: f64) -> String {
    if radians > FRAC_PI_2 {
        return "> 90°".into();
    }
    // The uncertainty has two digits, the angle as many as it leaves.
    let digits = if error > 0.0 {
        (1.0 - error.log10().floor()).clamp(0.0, 6.0)
    } else {
        6.0
    };
    let digits = digits as usize;
    let shown = |value: f64| format!("{value:.digits$}").replace('-', "−");
    let (degrees, degrees_error) = (radians.to_degrees(), error.to_degrees());
    let few = digits.saturating_sub(1);
    format!(
        "{} ± {} rad ({:.few$} ± {:.few$}°)",
        shown(radians),
        shown(error),
        degrees,
        degrees_error
    )
}

/// Shows a value of a document in a cell.
pub(super) fn value(value: &Value) -> String {
    match value {
        Value::Null => number::ABSENT.into(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Encodes a text as part of an address.
pub(super) fn encoded(text: &str) -> String {
    let letter = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' => {
            char::from(byte).to_string()
        }
        other => format!("%{other:02X}"),
    };
    text.bytes().map(letter).collect()
}
