//! Rows as cells: split at the separator where no quote stands in the text, by the table reader
//! of the `csv` crate where one does.

use super::cell::unreadable;
use super::dialect::{self, Separator};
use crate::error::Error;
use ::csv::ByteRecord;
use std::ops::{Index, Range};

/// A row of a table.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    bytes: &'a [u8],
    cells: &'a [Range<usize>],
    /// Byte of the text from which on the row was looked for; comments may come first.
    pub(super) byte: u64,
}

impl Row<'_> {
    /// Returns the number of cells.
    pub(super) fn len(&self) -> usize {
        self.cells.len()
    }
}

impl Index<usize> for Row<'_> {
    type Output = [u8];

    fn index(&self, column: usize) -> &[u8] {
        &self.bytes[self.cells[column].clone()]
    }
}

/// The rows of a table, one after the other.
pub(super) struct Records<'a> {
    text: &'a [u8],
    separator: u8,
    /// Byte of the text at which the next line begins.
    next: usize,
    /// Ends of the cells of the row at hand.
    cells: Vec<Range<usize>>,
    /// Who knows quotes, and old line ends, with the row at hand.
    reader: Option<(::csv::Reader<&'a [u8]>, ByteRecord)>,
}

impl<'a> Records<'a> {
    /// Reads from the row after `header_rows` on.
    ///
    /// # Errors
    ///
    /// Those of the table reader.
    pub(super) fn after_header(
        text: &'a [u8],
        separator: Separator,
        quoted: bool,
        header_rows: usize,
    ) -> Result<Self, Error> {
        let ends_alone = |at: usize| text.get(at + 1) != Some(&b'\n');
        let needs_reader = quoted || memchr::memchr_iter(b'\r', text).any(ends_alone);
        let mut records = Self {
            text,
            separator: separator.byte(),
            next: 0,
            cells: Vec::new(),
            reader: needs_reader
                .then(|| (dialect::reader(text, separator, quoted), ByteRecord::new())),
        };
        for _ in 0..header_rows {
            records.next()?;
        }
        Ok(records)
    }

    /// Returns the next row; `None` at the end.
    ///
    /// # Errors
    ///
    /// Those of the table reader.
    pub(super) fn next(&mut self) -> Result<Option<Row<'_>>, Error> {
        self.cells.clear();
        if let Some((reader, record)) = &mut self.reader {
            let more = reader.read_byte_record(record);
            if !more.map_err(|error| unreadable(&error))? {
                return Ok(None);
            }
            let cells = (0..record.len()).filter_map(|column| record.range(column));
            self.cells.extend(cells);
            return Ok(Some(Row {
                bytes: record.as_slice(),
                cells: &self.cells,
                byte: record.position().map_or(0, ::csv::Position::byte),
            }));
        }
        loop {
            let start = self.next;
            let rest = &self.text[start..];
            let Some(first) = rest.first() else {
                return Ok(None);
            };
            let length = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
            self.next = self.text.len().min(start + length + 1);
            if matches!(first, b'#' | b'\r' | b'\n') {
                continue;
            }
            let line = &rest[..length];
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            let mut begin = 0;
            for end in memchr::memchr_iter(self.separator, line) {
                self.cells.push(begin..end);
                begin = end + 1;
            }
            self.cells.push(begin..line.len());
            return Ok(Some(Row {
                bytes: line,
                cells: &self.cells,
                byte: start as u64,
            }));
        }
    }
}
