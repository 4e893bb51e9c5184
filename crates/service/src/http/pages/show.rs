//! Numbers and words for people.

use latchgate::document::number;
use maud::{Markup, html};
use serde_json::Value;
use std::f64::consts::FRAC_PI_2;

/// Shows a verdict: a sign, a word, a colour.
pub(super) fn verdict(word: &str) -> Markup {
    html! { span.verdict.(word) { span aria-hidden="true" { (sign(word)) } " " (word.to_uppercase()) } }
}

/// Returns the sign of a verdict.
pub(super) fn sign(word: &str) -> &'static str {
    match word {
        "pass" => "✓",
        "fail" => "✗",
        "undecided" => "?",
        _ => "∅",
    }
}

/// Shows an angle, in degrees with radians beside; beyond a right angle only that it is.
pub(super) fn angle(radians: Option<f64>) -> String {
    match radians {
        None => number::ABSENT.into(),
        Some(radians) if radians > FRAC_PI_2 => "> 90°".into(),
        Some(radians) => format!(
            "{}° ({} rad)",
            number::trimmed(radians.to_degrees(), 3),
            number::trimmed(radians, 3)
        ),
    }
}

/// Shows a value of a document in a cell.
pub(super) fn value(value: &Value) -> String {
    match value {
        Value::Null => number::ABSENT.into(),
        Value::String(text) => text.clone(),
        // More digits than anybody compares by eye stand in the document.
        Value::Number(own) if own.to_string().len() > 12 => {
            number::significant(own.as_f64().unwrap_or(f64::NAN), 7)
        }
        other => other.to_string(),
    }
}

/// Shows an instant in UTC, to the minute.
pub(super) fn instant(ms: i64) -> Markup {
    let minutes = ms.div_euclid(60_000);
    let day = latchgate::gate::file::day(minutes.div_euclid(1440));
    let minute = minutes.rem_euclid(1440);
    let time = format!("{:02}:{:02}", minute / 60, minute % 60);
    html! { time datetime=(format!("{day}T{time}Z")) { (day) " " (time) } }
}

/// Counts things: `1 recording`, `2 recordings`.
pub(super) fn count(number: usize, what: &str) -> String {
    let ending = if number == 1 { "" } else { "s" };
    format!("{number} {what}{ending}")
}

/// Shows a number of bytes.
pub(super) fn bytes(bytes: u64) -> String {
    match bytes {
        ..1000 => count(bytes as usize, "byte"),
        1000..1_000_000 => format!("{} kB", number::significant(bytes as f64 / 1e3, 3)),
        _ => format!("{} MB", number::significant(bytes as f64 / 1e6, 3)),
    }
}

/// Lists the numbers in which a design differs from another: key, value, and that of the other.
pub(super) fn differences(design: &Value, base: &Value) -> Vec<String> {
    let mut found = Vec::new();
    let tables = design.as_object().into_iter().flatten();
    for (table, values) in tables.filter(|(table, _)| *table != "modified_from") {
        for (key, own) in values.as_object().into_iter().flatten() {
            let other = &base[table][key];
            if own.is_number() && own.as_f64() != other.as_f64() {
                found.push(format!(
                    "{table}.{key} {} (was {})",
                    value(own),
                    value(other)
                ));
            }
        }
    }
    found
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

/// Says how many rows a list leaves out because they are damaged.
pub(super) fn damaged(count: usize) -> Markup {
    html! {
        @if count > 0 {
            p.muted role="status" { (self::count(count, "damaged row")) " left out; " code { "latchgate-serve fsck" } " names what is damaged." }
        }
    }
}
