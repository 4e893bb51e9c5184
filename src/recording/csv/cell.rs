//! What is said of a cell that cannot be used, and what to do about it.

use crate::error::{Error, ErrorKind};
use crate::recording::number::NumberFault;

/// Says what is wrong with a cell that should hold a number.
pub(super) fn bad_cell(cell: &[u8], fault: NumberFault) -> Error {
    let found = shown(cell);
    let malformed = |expected: &str, found: String, hint: &str| ErrorKind::Malformed {
        expected: expected.into(),
        found,
        hint: hint.into(),
    };
    match fault {
        NumberFault::NonFinite => ErrorKind::NonFinite { found },
        NumberFault::Empty => malformed(
            "a number",
            "an empty cell".into(),
            "remove the row or fill the cell; a missing sample is not taken for zero",
        ),
        NumberFault::Text => malformed(
            "a number",
            format!("`{found}`{}", hidden(&found)),
            hint_for(&found),
        ),
        NumberFault::OtherMark => malformed(
            "the same decimal mark in all numbers",
            format!("`{found}`"),
            "a comma may be a decimal or a thousands mark; export with decimal points, or with ; between cells",
        ),
    }
    .into()
}

/// Returns what to do about a cell that is no number.
fn hint_for(cell: &str) -> &'static str {
    let digits = cell.chars().any(|c| c.is_ascii_digit());
    if digits && (cell.contains(':') || cell.matches('/').count() == 2) {
        DATES
    } else if digits && cell.contains([',', ';', '|', '\t']) {
        ONE_CELL
    } else if cell.replacen(['D', 'd'], "e", 1).parse::<f64>().is_ok() {
        "write the exponent with E, as in 1.0E+00"
    } else {
        "mend the cell; lines of words begin with #"
    }
}

/// What to do where a date is of a form that is not read.
const DATES: &str = "dates are read as 2024-05-01T10:00:00.0001, date and time of day in one column; export them so, or as seconds, or leave the column out and state the setting `rate_hz`";

/// What to do where a row is one cell.
pub(super) const ONE_CELL: &str = "the row is one cell: export with a comma, a semicolon or a tab between cells, and without quotes around whole rows";

/// Names the characters of a cell that cannot be seen or are taken for others.
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

/// Says that a cell of a column of dates holds none.
pub(super) fn no_date(cell: &[u8]) -> Error {
    Error::malformed(
        "a date and time such as 2024-05-01T10:00:00.0001, as in the rows before",
        format!("`{}`", shown(cell)),
        "mend the cell, or name another column with the setting `time_column`",
    )
}

/// Shortens a cell for a message.
pub(super) fn shown(cell: &[u8]) -> String {
    const MOST: usize = 40;
    let text = String::from_utf8_lossy(cell);
    let text = text.trim();
    if text.chars().count() > MOST {
        format!("{}…", text.chars().take(MOST).collect::<String>())
    } else {
        text.to_string()
    }
}
