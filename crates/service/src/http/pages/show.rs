//! Numbers and words for people.

use super::fields;
use latchgate::document::number;
use latchgate::pipeline::{CATCH_PARAMETERS, PARAMETERS};
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

/// Shows an instant in UTC, to the minute.
pub(super) fn instant(ms: i64) -> Markup {
    let minutes = ms.div_euclid(60_000);
    let day = latchgate::pipeline::calendar::day(minutes.div_euclid(1440));
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

/// Lists the numbers in which a design differs from another, in words.
pub(super) fn differences(design: &Value, base: &Value) -> Vec<String> {
    let value_of = |design: &Value, name: &str| {
        let (table, key) = name.split_once('.')?;
        design[table][key].as_f64()
    };
    let differing = PARAMETERS
        .iter()
        .chain(CATCH_PARAMETERS)
        .filter_map(|parameter| {
            let (value, base_value) = (
                value_of(design, parameter.name)?,
                value_of(base, parameter.name)?,
            );
            // As they stand: a number that was kept is read as it was written.
            (value.to_bits() != base_value.to_bits()).then(|| {
                let (value, unit) = (number::exact(value), fields::unit(parameter.unit));
                format!(
                    "{} {value}{unit} (was {})",
                    parameter.noun,
                    number::exact(base_value)
                )
            })
        });
    differing.collect()
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
