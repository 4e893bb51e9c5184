//! The line on which a table seems to end, if a line after it stops the reading: a footer, or another
//! section.

use super::begin;
use super::dialect::is_row;
use super::layout::TableLayout;
use crate::error::{Error, ErrorKind};
use crate::number;
use crate::setting::Setting;
use latchgate_kernel::error::Error as KernelError;

/// Adds the line on which the table seems to end to an error that a line after it made: one without a
/// number, or one of another shape after which no row of the table follows.
pub(super) fn named(error: Error, text: &[u8], layout: &TableLayout) -> Error {
    let (expected, found) = match error.kind() {
        ErrorKind::RaggedRow { expected, found } => (
            format!("{expected} cells as in the rows before"),
            found.to_string(),
        ),
        ErrorKind::Malformed {
            expected, found, ..
        } => (expected.clone(), found.clone()),
        // Such as `NaN,NaN` and `0,0` after the samples.
        ErrorKind::TimeNotIncreasing { previous, found } if found < previous => {
            (format!("a time after {previous} s"), format!("{found} s"))
        }
        ErrorKind::Kernel(KernelError::NonFinite { found }) => {
            ("a finite number".to_string(), format!("`{found}`"))
        }
        _ => return error,
    };
    let line = error.place().line;
    let Some((last, seems_clear)) = line.and_then(|line| last_line(text, layout, line)) else {
        return error;
    };
    let setting = Setting::LastLine;
    let hint = match seems_clear {
        true => format!("the table seems to end on line {last}; if so, state {setting} = {last}"),
        false => {
            format!(
                "correct the export; if the table ends on line {last}, state {setting} = {last}"
            )
        }
    };
    Error::malformed(expected, found, hint).at(error.place().clone())
}

/// Returns the last line of the table, if line `odd`, counted from 1, may be outside it; true with it if
/// that line does not begin as a row does.
fn last_line(text: &[u8], layout: &TableLayout, odd: u64) -> Option<(u64, bool)> {
    let lines = text.split(|byte| *byte == b'\n').zip(1_u64..);
    let mut last = None;
    let (mut rows, mut seems_clear) = (0, false);
    for (line, number) in lines.filter(|(line, _)| is_row(line)) {
        let cells = begin::cells(line, layout.separator);
        if number < odd {
            rows += 1;
            last = Some(number);
        } else if number == odd {
            // Where stamps are words, a row with a wrong one is still a row.
            if layout.worded.first() == Some(&true) && layout.is_shaped(&cells) {
                return None;
            }
            seems_clear = !cells.first().is_some_and(|cell| number::is_numeric(cell));
            // A line of words alone is no row, whatever follows.
            if !cells.iter().any(|cell| number::is_numeric(cell)) {
                break;
            }
        } else if layout.is_shaped(&cells) {
            return None;
        }
    }
    last.filter(|_| rows > layout.header_rows)
        .map(|last| (last, seems_clear))
}
