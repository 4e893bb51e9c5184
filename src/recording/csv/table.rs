//! The table reader: rows of cells, comments and empty lines passed over, quotes undone.

use super::dialect::Separator;
use csv_core::ReadRecordResult;
use std::cell::Cell;
use std::ops::Index;

/// A reader of rows from marked text.
pub(super) struct Table<'a> {
    /// Gone only while it is dropped.
    machine: Option<Box<csv_core::Reader>>,
    separator: Separator,
    quoted: bool,
    rest: &'a [u8],
    /// Bytes taken so far.
    taken: u64,
    ended: bool,
}

impl<'a> Table<'a> {
    pub(super) fn new(text: &'a [u8], separator: Separator, quoted: bool) -> Self {
        Self {
            machine: Some(machine(separator, quoted)),
            separator,
            quoted,
            rest: text,
            taken: 0,
            ended: false,
        }
    }

    /// Reads the next row into `row`; false after the last.
    pub(super) fn next(&mut self, row: &mut Row) -> bool {
        (row.cells, row.start) = (0, self.taken);
        let Some(machine) = &mut self.machine else {
            return false;
        };
        let (mut written, mut cells) = (0, 0);
        while !self.ended {
            let (result, taken, more_written, more_cells) =
                machine.read_record(self.rest, &mut row.bytes[written..], &mut row.ends[cells..]);
            self.rest = &self.rest[taken..];
            self.taken += taken as u64;
            written += more_written;
            cells += more_cells;
            match result {
                // Asked once more without input, it ends the last row.
                ReadRecordResult::InputEmpty => {}
                ReadRecordResult::OutputFull => row.bytes.resize((2 * written).max(256), 0),
                ReadRecordResult::OutputEndsFull => row.ends.resize((2 * cells).max(16), 0),
                ReadRecordResult::Record => {
                    row.cells = cells;
                    return true;
                }
                ReadRecordResult::End => self.ended = true,
            }
        }
        false
    }
}

thread_local! {
    /// The machines that split rows, one for each separator with and without quotes. Building
    /// one takes longer than reading a small table; its copy would not work.
    static MACHINES: [Cell<Option<Box<csv_core::Reader>>>; 10] =
        const { [const { Cell::new(None) }; 10] };
}

fn place_of_machine(separator: Separator, quoted: bool) -> usize {
    2 * separator as usize + usize::from(quoted)
}

fn machine(separator: Separator, quoted: bool) -> Box<csv_core::Reader> {
    let used = MACHINES.with(|machines| {
        machines
            .get(place_of_machine(separator, quoted))
            .and_then(Cell::take)
    });
    used.map_or_else(
        || {
            Box::new(
                csv_core::ReaderBuilder::new()
                    .delimiter(separator.byte())
                    .comment(Some(b'#'))
                    .quoting(quoted)
                    .build(),
            )
        },
        |mut machine| {
            machine.reset();
            machine
        },
    )
}

impl Drop for Table<'_> {
    fn drop(&mut self) {
        let machine = self.machine.take();
        // A thread that ends keeps none.
        let _ = MACHINES.try_with(|machines| {
            if let Some(place) = machines.get(place_of_machine(self.separator, self.quoted)) {
                place.set(machine);
            }
        });
    }
}

/// A row of a table.
#[derive(Debug, Default)]
pub(super) struct Row {
    /// The cells one after another, and room for more.
    bytes: Vec<u8>,
    /// Where each cell ends, and room for more.
    ends: Vec<usize>,
    cells: usize,
    /// Byte at which the table reader began to read, maybe with comments before the row.
    start: u64,
}

impl Row {
    /// Returns the byte at which the table reader began to read the row.
    pub(super) fn byte(&self) -> u64 {
        self.start
    }

    /// Returns the number of cells.
    pub(super) fn len(&self) -> usize {
        self.cells
    }

    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        let end = *self.ends[..self.cells].get(index)?;
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        Some(&self.bytes[start..end])
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.cells).filter_map(|index| self.get(index))
    }

    /// Returns a copy without the room for more.
    pub(super) fn kept(&self) -> Self {
        let ends = self.ends[..self.cells].to_vec();
        Self {
            bytes: self.bytes[..ends.last().copied().unwrap_or(0)].to_vec(),
            ends,
            ..*self
        }
    }
}

impl Index<usize> for Row {
    type Output = [u8];

    fn index(&self, index: usize) -> &[u8] {
        self.get(index).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::{Row, Table};
    use crate::recording::csv::dialect::Separator;

    type Rows = Vec<(u64, Vec<Vec<u8>>)>;

    fn by_table(text: &[u8], separator: Separator, quoted: bool) -> Rows {
        let mut table = Table::new(text, separator, quoted);
        let mut row = Row::default();
        let mut rows = Vec::new();
        while table.next(&mut row) {
            let kept = row.kept();
            assert_eq!((kept.len(), kept.byte()), (row.len(), row.byte()));
            assert!(kept.iter().eq(row.iter()));
            rows.push((row.byte(), row.iter().map(<[u8]>::to_vec).collect()));
        }
        assert!(!table.next(&mut row), "nothing follows the last row");
        rows
    }

    /// The same by the crate `csv`, whose machine this is.
    fn by_crate(text: &[u8], separator: Separator, quoted: bool) -> Rows {
        ::csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(separator.byte())
            .comment(Some(b'#'))
            .quoting(quoted)
            .from_reader(text)
            .into_byte_records()
            .map(|record| {
                let record = record.expect("bytes in memory");
                let byte = record.position().map_or(0, ::csv::Position::byte);
                (byte, record.iter().map(<[u8]>::to_vec).collect())
            })
            .collect()
    }

    #[test]
    fn prop_rows_are_those_of_the_crate_csv() {
        const PIECES: &[&str] = &[
            "1.5",
            "a b",
            ",",
            ",",
            ";",
            "\t",
            " ",
            "\n",
            "\n",
            "\r\n",
            "#",
            "\"",
            "\"\"",
            "é",
            "\u{feff}",
            "0123456789012345678901234567890123456789",
        ];
        let mut seed = 1_u64;
        let mut below = |bound: usize| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            usize::try_from(seed >> 33).unwrap_or(0) % bound
        };
        for case in 0..3000 {
            // Now and then a row longer than the room that a row begins with.
            let most = if case % 50 == 0 { 2000 } else { 40 };
            let text: String = (0..below(most))
                .map(|_| PIECES[below(PIECES.len())])
                .collect();
            for separator in [
                Separator::Tab,
                Separator::Semicolon,
                Separator::Comma,
                Separator::Blanks,
                Separator::None,
            ] {
                for quoted in [false, true] {
                    assert_eq!(
                        by_table(text.as_bytes(), separator, quoted),
                        by_crate(text.as_bytes(), separator, quoted),
                        "case {case}: {text:?} at {separator:?}, quoted {quoted}"
                    );
                }
            }
        }
    }
}
