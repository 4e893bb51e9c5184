//! What readers of text share: lines within limits, decimal numbers as the file writes them.

use super::Limits;
use super::number::{self, Decimal, Marks, NumberFault, PrintedDigits};
use crate::error::{Error, ErrorKind, Place};

/// Refuses a text with a line that is too long.
pub(super) fn check_line_lengths(text: &[u8], limits: &Limits) -> Result<(), Error> {
    let mut start = 0_u64;
    for (index, line) in text.split(|byte| *byte == b'\n').enumerate() {
        if line.len() as u64 > limits.line_bytes {
            return Err(limits
                .over("line_bytes", "a longer line")
                .at(Place::default()
                    .line(index as u64 + 1)
                    .byte(start + limits.line_bytes)));
        }
        start += line.len() as u64 + 1;
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
pub(super) fn sample(cell: &str, decimal: &mut Decimal) -> Result<f64, Error> {
    number::parse(cell.as_bytes(), decimal).map_err(|fault| {
        let found = shown(cell);
        let (expected, found, hint) = match fault {
            NumberFault::NonFinite => return ErrorKind::NonFinite { found }.into(),
            NumberFault::Empty => {
                let hint = "a missing sample is not taken for zero; mend the export";
                ("a number", "nothing".into(), hint)
            }
            NumberFault::Text => ("a number", format!("`{found}`"), "mend the export"),
            NumberFault::OtherMark => {
                let hint = "export again with decimal points";
                (
                    "the same decimal mark in all numbers",
                    format!("`{found}`"),
                    hint,
                )
            }
        };
        Error::malformed(expected, found, hint)
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

/// What the marks in the numbers of a column may be, with the first that may separate thousands
/// and where it stands.
#[derive(Debug, Clone, Default)]
pub(super) struct ColumnMarks {
    pub(super) marks: Marks,
    first: Option<(Place, String)>,
}

impl ColumnMarks {
    /// Takes in a number that was read.
    pub(super) fn look(&mut self, cell: &[u8], place: impl FnOnce() -> Place) {
        if self.marks.look(cell) {
            self.first = Some((place(), shown(&String::from_utf8_lossy(cell))));
        }
    }

    /// Refuses a column whose marks are not clear by that number and all marks.
    pub(super) fn check(
        &self,
        is_clear: impl FnOnce(&str, Marks) -> bool,
        hint: &str,
    ) -> Result<(), Error> {
        let doubtful = self.first.as_ref();
        let doubtful = doubtful.filter(|(_, cell)| !is_clear(cell, self.marks));
        doubtful.map_or(Ok(()), |(place, cell)| {
            let found = format!(
                "`{cell}`, and no number in the column whose mark can only be a decimal one"
            );
            Err(Error::malformed("numbers whose mark is clear", found, hint).at(place.clone()))
        })
    }
}
