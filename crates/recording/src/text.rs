//! Tools of all readers of text: lines within limits, decimal numbers as the file writes them.

use super::number::{self, Decimal, Marks, NumberFault, PrintedDigits};
use crate::error::{Error, Place};
use latchgate_kernel::error::Error as KernelError;

/// Returns the line of the byte at `position`, counted from 1.
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
    let cell = cell.as_bytes();
    number::parse(cell, decimal).map_err(|fault| bad_cell(cell, fault))
}

/// Returns the error of a cell that should hold a number.
pub(super) fn bad_cell(cell: &[u8], fault: NumberFault) -> Error {
    let found = shown(cell);
    match fault {
        NumberFault::NonFinite => KernelError::NonFinite { found }.into(),
        NumberFault::Empty => Error::malformed(
            "a number",
            "an empty cell",
            "remove the row or fill the cell; a missing sample is not zero",
        ),
        NumberFault::Text => {
            let hint = hint_for(&found);
            Error::malformed("a number", format!("`{found}`{}", hidden(&found)), hint)
        }
        NumberFault::OtherMark => Error::malformed(
            "the same decimal mark in all numbers",
            format!("`{found}`"),
            "a comma may be a decimal or a thousands mark; export with decimal points, or with ; between cells",
        ),
    }
}

/// Returns the remedy for a cell that is no number.
fn hint_for(cell: &str) -> &'static str {
    let digits = cell.chars().any(|c| c.is_ascii_digit());
    if digits && (cell.contains(':') || cell.matches('/').count() == 2) {
        STAMPS
    } else if digits && cell.contains([',', ';', '|', '\t']) {
        ONE_CELL
    } else if cell.replacen(['D', 'd'], "e", 1).parse::<f64>().is_ok() {
        "write the exponent with E, as in 1.0E+00"
    } else {
        "correct the cell; lines of words must begin with #"
    }
}

/// The remedy for a stamp of a form that is not read.
pub(super) const STAMPS: &str = "export times as seconds, 10:00:00.0001 or \
                                 2024-05-01T10:00:00.0001, with date and time in one column";

/// The remedy for a row that is one cell.
pub(super) const ONE_CELL: &str = "the row is one cell; export with a comma, semicolon or tab \
                                   between cells, and no quotes around rows";

/// Names the characters of a cell that are invisible or look like others.
fn hidden(cell: &str) -> String {
    let mut names: Vec<String> = cell
        .chars()
        .filter(|c| !c.is_ascii() && !c.is_alphanumeric())
        .map(|c| format!("U+{:04X}", u32::from(c)))
        .collect();
    names.dedup();
    names.truncate(4);
    if names.is_empty() {
        return String::new();
    }
    format!(", which holds {}", names.join(", "))
}

/// Returns the error of a cell that should hold a stamp.
pub(super) fn no_stamp(cell: &[u8]) -> Error {
    Error::malformed(
        "a time that latchgate reads",
        format!("`{}`", shown(cell)),
        STAMPS,
    )
}

/// Shortens a text for a message.
pub(super) fn shown(text: impl AsRef<[u8]>) -> String {
    const MOST: usize = 60;
    let text = String::from_utf8_lossy(text.as_ref());
    let text = text.trim();
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

/// Meaning of the marks in the numbers of a column, with the first that may separate thousands and its
/// place.
#[derive(Debug, Clone, Default)]
pub(super) struct ColumnMarks {
    pub(super) marks: Marks,
    first: Option<(Place, String)>,
}

impl ColumnMarks {
    /// Reads a number that was accepted.
    pub(super) fn look(&mut self, cell: &[u8], place: impl FnOnce() -> Place) {
        if self.marks.look(cell) {
            self.first = Some((place(), shown(cell)));
        }
    }

    /// Refuses a column whose marks are not clear, by that number and all marks.
    pub(super) fn check(
        &self,
        is_clear: impl FnOnce(&str, Marks) -> bool,
        hint: &str,
    ) -> Result<(), Error> {
        let doubtful = self.first.as_ref();
        let doubtful = doubtful.filter(|(_, cell)| !is_clear(cell, self.marks));
        doubtful.map_or(Ok(()), |(place, cell)| {
            let found = format!("`{cell}`, and no number in the column with a clear decimal mark");
            Err(Error::malformed("numbers whose mark is clear", found, hint).at(place.clone()))
        })
    }
}
