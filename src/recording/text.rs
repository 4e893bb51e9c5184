//! What readers of text share: lines within limits, decimal numbers as the file writes them.

use super::Limits;
use super::number::{self, Decimal, NumberFault, PrintedDigits};
use crate::error::{Error, ErrorKind, Place};

/// Refuses a text with a line that is too long.
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] at the line, with the byte where the limit was crossed.
pub(super) fn check_line_lengths(text: &[u8], limits: &Limits) -> Result<(), Error> {
    let mut start = 0_u64;
    for (index, line) in text.split(|byte| *byte == b'\n').enumerate() {
        if line.len() as u64 > limits.line_bytes {
            return Err(Error::from(ErrorKind::LimitExceeded {
                limit: "line_bytes",
                value: limits.line_bytes,
                found: "a longer line".into(),
            })
            .at(Place::default()
                .line(index as u64 + 1)
                .byte(start + limits.line_bytes)));
        }
        check_fields(line, start, |byte| matches!(byte, b'\t' | b' '), limits)
            .map_err(|error| error.at(Place::default().line(index as u64 + 1)))?;
        start += line.len() as u64 + 1;
    }
    Ok(())
}

/// Refuses a line with a cell that is too long.
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] with the byte where the limit was crossed; `start` is where the
/// line begins.
pub(super) fn check_fields(
    line: &[u8],
    start: u64,
    separates: impl Fn(u8) -> bool,
    limits: &Limits,
) -> Result<(), Error> {
    if line.len() as u64 <= limits.field_bytes {
        return Ok(());
    }
    let mut cell = 0_u64;
    for (position, byte) in line.iter().enumerate() {
        cell = if separates(*byte) { 0 } else { cell + 1 };
        if cell > limits.field_bytes {
            return Err(Error::from(ErrorKind::LimitExceeded {
                limit: "field_bytes",
                value: limits.field_bytes,
                found: "a longer cell".into(),
            })
            .at(Place::default().byte(start + position as u64)));
        }
    }
    Ok(())
}

/// Returns the line, counted from 1, in which the byte at `position` stands.
pub(super) fn line_at(text: &[u8], position: usize) -> u64 {
    let before = &text[..position.min(text.len())];
    memchr::memchr_iter(b'\n', before).count() as u64 + 1
}

/// Splits decoded text into lines without their ends, counted from 1.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (u64, &str)> {
    text.split('\n')
        .enumerate()
        .map(|(index, line)| (index as u64 + 1, line.strip_suffix('\r').unwrap_or(line)))
}

/// Reads a number of a header, with decimal point or comma; `None` if it is none.
pub(super) fn header_number(cell: &str) -> Option<f64> {
    number::parse(cell.as_bytes(), &mut Decimal::Unknown).ok()
}

/// Returns the size of a printed number's last digit, in its own unit.
pub(super) fn last_digit(cell: &str) -> f64 {
    PrintedDigits::of_cell(cell.trim().as_bytes())
}

/// Reads a sample.
///
/// # Errors
///
/// [`ErrorKind::Malformed`] or [`ErrorKind::NonFinite`] for what is no finite number.
pub(super) fn sample(cell: &str, decimal: &mut Decimal) -> Result<f64, Error> {
    number::parse(cell.as_bytes(), decimal).map_err(|fault| {
        let found = shown(cell);
        match fault {
            NumberFault::NonFinite => ErrorKind::NonFinite { found },
            NumberFault::Empty => ErrorKind::Malformed {
                expected: "a number".into(),
                found: "nothing".into(),
                hint: "a missing sample is not taken for zero; mend the export".into(),
            },
            NumberFault::Text => ErrorKind::Malformed {
                expected: "a number".into(),
                found: format!("`{found}`"),
                hint: "mend the export".into(),
            },
            NumberFault::OtherMark => ErrorKind::Malformed {
                expected: "the same decimal mark in all numbers".into(),
                found: format!("`{found}`"),
                hint: "export again with decimal points".into(),
            },
        }
        .into()
    })
}

/// Shortens a text for a message.
pub(super) fn shown(text: &str) -> String {
    const MOST: usize = 60;
    let text = text.trim();
    if text.chars().count() > MOST {
        format!("{}…", text.chars().take(MOST).collect::<String>())
    } else {
        text.to_string()
    }
}

/// Returns an error for more samples than allowed.
pub(super) fn too_many_samples(limits: &Limits) -> Error {
    ErrorKind::LimitExceeded {
        limit: "samples",
        value: limits.samples,
        found: "more samples".into(),
    }
    .into()
}
