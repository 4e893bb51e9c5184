//! Rows as cells, by the table reader of the `csv` crate.

use super::dialect::{Separator, is_row};
use crate::Limits;
use crate::error::{Error, Place};
use crate::text::line_at;
use ::csv::{ByteRecord, Reader, ReaderBuilder};

/// The rows of a table, one after the other.
pub(super) struct Records<'a> {
    text: &'a [u8],
    reader: Reader<&'a [u8]>,
    row: ByteRecord,
    limits: &'a Limits,
}

impl<'a> Records<'a> {
    /// Reads marked text from its first row on; `quoted` is true if it has quotes.
    pub(super) fn new(
        text: &'a [u8],
        separator: Separator,
        quoted: bool,
        limits: &'a Limits,
    ) -> Self {
        let mut builder = ReaderBuilder::new();
        builder.has_headers(false).flexible(true).quoting(quoted);
        builder.delimiter(separator.byte()).comment(Some(b'#'));
        builder.buffer_capacity(text.len().clamp(1 << 10, 1 << 16));
        Self {
            text,
            reader: builder.from_reader(text),
            row: ByteRecord::new(),
            limits,
        }
    }

    /// Returns the next row; `None` at the end. A row of more cells than allowed, and one with a
    /// quoted cell that runs over its line's end, are refused.
    pub(super) fn next(&mut self) -> Result<Option<&ByteRecord>, Error> {
        let more = self.reader.read_byte_record(&mut self.row);
        let more = more.map_err(|error| Error::io("read the table", &error))?;
        if !more {
            return Ok(None);
        }
        let place = || Place::default().line(line_of(self.text, &self.row));
        if memchr::memchr(b'\n', self.row.as_slice()).is_some() {
            let hint = "add the quote, or remove the line break in the cell";
            let expected = "a quoted cell to end on its line";
            return Err(Error::malformed(expected, "no closing quote", hint).at(place()));
        }
        let cells = self.row.len();
        if cells as u64 > self.limits.columns {
            let error = self
                .limits
                .over("columns", format!("{cells} cells on a line"));
            return Err(error.at(place().byte(byte_of(&self.row) as u64)));
        }
        Ok(Some(&self.row))
    }

    /// Skips that many rows.
    pub(super) fn after(mut self, rows: usize) -> Result<Self, Error> {
        for _ in 0..rows {
            self.next()?;
        }
        Ok(self)
    }
}

/// Returns the byte of the text at which the table reader looked for a row; comments may come first.
pub(super) fn byte_of(row: &ByteRecord) -> usize {
    let byte = row.position().map_or(0, ::csv::Position::byte);
    usize::try_from(byte).unwrap_or(usize::MAX)
}

/// Returns the line of a row.
pub(super) fn line_of(text: &[u8], row: &ByteRecord) -> u64 {
    let start = byte_of(row).min(text.len());
    let before = text[start..]
        .split_inclusive(|byte| *byte == b'\n')
        .take_while(|line| !is_row(line))
        .count();
    line_at(text, start) + before as u64
}
