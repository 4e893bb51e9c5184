//! Rows: the stamps and the samples of the wanted columns.

use super::date;
use super::dialect::{self, Separator};
use super::layout::{TableLayout, TimeSource};
use super::records;
use crate::error::{Error, ErrorKind, Place};
use crate::recording::number::{self, Decimal, Marks, PrintedDigits};
use crate::recording::text::{ColumnMarks, bad_cell, no_date};
use crate::recording::{Limits, ReadTask, Selection};
use crate::units::DecimalMark;
use ::csv::ByteRecord;

/// What became of a wanted column: its samples, in its own unit, or why it holds no channel, which is so
/// only where every channel is read.
pub(super) type ColumnResult = Result<Vec<f64>, Error>;

/// Columns to read for one selection.
#[derive(Debug, PartialEq)]
pub(super) struct WantedColumns {
    pub(super) selection: Selection,
    /// Columns of samples, and behind them those that count the rows.
    pub(super) columns: Vec<usize>,
    /// How many are of samples.
    pub(super) samples: usize,
}

/// The rows of a table.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    /// Stamps [s]; empty without a time column.
    pub(super) stamps_s: Vec<f64>,
    /// Size of the last printed digit of a stamp [s]; 0 if unknown.
    pub(super) printed_digit_s: f64,
    /// Samples of the wanted columns, in their order.
    pub(super) values: Vec<ColumnResult>,
    /// Number of rows.
    pub(super) count: usize,
    /// Rows that repeat the one before to the last cell, and the line of the first.
    pub(super) repeated: Option<(usize, u64)>,
    /// Size of each stamp's last digit [s], where stamps repeat those before, so that only a
    /// stated rate can tell the time.
    pub(super) coarse_digits_s: Option<Vec<f64>>,
    /// Whether the numbers have a decimal comma.
    pub(super) decimal_comma: bool,
}

impl Rows {
    /// Returns the size of the coarsest stamp's last digit [s]; 0 unless stamps repeat.
    fn coarsest_digit_s(&self) -> f64 {
        let digits = self.coarse_digits_s.iter().flatten();
        digits.copied().fold(0.0, f64::max)
    }
}

/// Reads the rows; an error at line and column of the first bad cell. Where every channel is read, a
/// column with a bad cell is left out instead.
pub(super) fn read(
    text: &[u8],
    layout: &TableLayout,
    time: &TimeSource,
    wanted: &WantedColumns,
    asked: ReadTask,
) -> Result<Rows, Error> {
    let table = RowTable {
        text,
        layout,
        time,
        asked,
    };
    check_counts(text, layout, wanted, asked.limits)?;
    let rows = table.pass(wanted, false);
    let stamps_are_numbers = !matches!(time, TimeSource::Column { dated: true, .. });
    if let (Err(error), true, Some(rate)) = (&rows, stamps_are_numbers, asked.options.rate_hz)
        && is_repeated(error)
        // Stamps of too few digits: the stated rate is held against them later.
        && let Ok(again) = table.pass(wanted, true)
        && again.coarsest_digit_s() * rate > 1.01
    {
        return Ok(again);
    }
    rows
}

/// A table whose rows are read.
#[derive(Clone, Copy)]
struct RowTable<'a> {
    text: &'a [u8],
    layout: &'a TableLayout,
    time: &'a TimeSource,
    asked: ReadTask<'a>,
}

impl RowTable<'_> {
    /// Goes over the rows; with `repeating` a stamp may be that of the row before.
    fn pass(self, wanted: &WantedColumns, repeating: bool) -> Result<Rows, Error> {
        let layout = self.layout;
        let mut gathered = Gathering::new(self, wanted, repeating);
        let mut records = layout.records(self.text, self.asked.limits)?;
        while let Some(row) = records.next()? {
            gathered.take(row)?;
        }
        gathered.finish()
    }

    fn between_commas(self) -> bool {
        self.layout.separator == Separator::Comma
    }

    fn place(self, row: &ByteRecord, column: usize) -> Place {
        Place::default()
            .line(records::line_of(self.text, row))
            .column(column as u64 + 1)
    }

    fn bad_cell(self, row: &ByteRecord, column: usize, fault: number::NumberFault) -> Error {
        bad_cell(&row[column], fault).at(self.place(row, column))
    }
}

/// Rows as they are gathered for one selection.
struct Gathering<'a> {
    table: RowTable<'a>,
    wanted: &'a WantedColumns,
    rows: Rows,
    /// The column of stamps, with their number per second.
    stamped: Option<(usize, f64)>,
    /// The clock of stamps that are dates.
    dates: Option<date::DateClock>,
    /// Mark of stamps and samples.
    decimal: Decimal,
    digits: PrintedDigits,
    stamp_marks: ColumnMarks,
    marks: Vec<ColumnMarks>,
    /// Byte at which the last row that was kept begins.
    last_byte: usize,
}

impl<'a> Gathering<'a> {
    fn new(table: RowTable<'a>, wanted: &'a WantedColumns, repeating: bool) -> Self {
        let (stamped, dated) = match table.time {
            TimeSource::Column {
                index, unit, dated, ..
            } => (Some((*index, unit.per_second())), *dated),
            TimeSource::Rate(_) => (None, false),
        };
        // Between commas only quotes can hold a number with a comma together.
        let decimal = match table.asked.options.decimal {
            Some(mark) => Decimal::Stated(mark),
            None if table.between_commas() && !table.layout.quoted => Decimal::PointOnly,
            None => Decimal::Unknown,
        };
        Self {
            table,
            wanted,
            rows: Rows {
                values: vec![Ok(Vec::new()); wanted.columns.len()],
                coarse_digits_s: repeating.then(Vec::new),
                ..Rows::default()
            },
            stamped,
            dates: dated.then(date::DateClock::default),
            decimal,
            digits: PrintedDigits::new(),
            stamp_marks: ColumnMarks::default(),
            marks: vec![ColumnMarks::default(); wanted.columns.len()],
            last_byte: 0,
        }
    }

    /// Takes in one row.
    fn take(&mut self, row: &ByteRecord) -> Result<(), Error> {
        let checked = self.table.layout.check_row(row);
        checked.map_err(|(column, error)| {
            let place = self.table.place(row, column);
            error.at(Place {
                column: place.column.filter(|_| column < row.len()),
                ..place
            })
        })?;
        if let Some((column, per_second)) = self.stamped {
            let stamp = self.stamp(row, column, per_second)?;
            if self.repeats_row(row, column, stamp)? {
                return Ok(());
            }
            if self.dates.is_none() {
                self.digits.count(&row[column]);
                self.stamp_marks
                    .look(&row[column], || self.table.place(row, column));
                if let Some(digits) = &mut self.rows.coarse_digits_s {
                    // Zero has the digits of its neighbours.
                    let own = PrintedDigits::of_cell(&row[column]) / per_second;
                    let before = digits.last().copied().unwrap_or(0.0);
                    digits.push(if own > 0.0 { own } else { before });
                }
            }
            self.rows.stamps_s.push(stamp);
            self.last_byte = records::byte_of(row);
        }
        self.rows.count += 1;
        let columns = self.wanted.columns.iter().zip(&mut self.rows.values);
        for (place, ((column, result), marks)) in columns.zip(&mut self.marks).enumerate() {
            let Ok(samples) = result else {
                continue;
            };
            let is_sample = place < self.wanted.samples;
            // What counts rows tells nothing of the samples' mark.
            let mut own = self.decimal;
            let decimal = match is_sample {
                true => &mut self.decimal,
                false => &mut own,
            };
            match number::parse(&row[*column], decimal) {
                Ok(value) => {
                    samples.push(value);
                    if is_sample {
                        marks.look(&row[*column], || self.table.place(row, *column));
                    }
                }
                Err(fault) => {
                    let error = self.table.bad_cell(row, *column, fault);
                    if is_sample && self.wanted.selection == Selection::Lateral {
                        return Err(error);
                    }
                    *result = Err(error);
                }
            }
        }
        Ok(())
    }

    /// Reads a stamp [s].
    fn stamp(&mut self, row: &ByteRecord, column: usize, per_second: f64) -> Result<f64, Error> {
        let cell = &row[column];
        match &mut self.dates {
            Some(clock) => clock
                .seconds(cell)
                .ok_or_else(|| no_date(cell).at(self.table.place(row, column))),
            None => number::parse(cell, &mut self.decimal)
                .map(|stamp| stamp / per_second)
                .map_err(|fault| self.table.bad_cell(row, column, fault)),
        }
    }

    /// Tells whether a row is the one before once more, which says nothing new and takes no
    /// sample away.
    fn repeats_row(&mut self, row: &ByteRecord, column: usize, stamp: f64) -> Result<bool, Error> {
        let Some(previous) = self.rows.stamps_s.last().copied() else {
            return Ok(false);
        };
        let repeating = self.rows.coarse_digits_s.is_some();
        if stamp > previous || (stamp >= previous && repeating) {
            return Ok(false);
        }
        let text = self.table.text;
        // The line of a row is counted from the file's beginning, and so only where it is told.
        let place = || self.table.place(row, column);
        if row_at(text, self.last_byte) == row_at(text, records::byte_of(row)) {
            let known = self.rows.repeated;
            let (rows, first) = known.unwrap_or_else(|| (0, place().line.unwrap_or(0)));
            self.rows.repeated = Some((rows + 1, first));
            return Ok(true);
        }
        let found = stamp;
        Err(Error::from(ErrorKind::TimeNotIncreasing { previous, found }).at(place()))
    }

    /// Judges what only all rows together show: marks that may separate thousands.
    fn finish(mut self) -> Result<Rows, Error> {
        // Between commas a comma in a number more often separates thousands.
        let strict = self.table.between_commas() && self.decimal == Decimal::Comma;
        let is_clear =
            |_: &str, marks: Marks| !(marks.may_be_thousands() || (strict && !marks.decimal));
        let is_stated = self.table.asked.options.decimal.is_some();
        if !is_stated {
            self.stamp_marks.check(is_clear, THOUSANDS)?;
        }
        if !is_stated && !self.stamp_marks.marks.decimal {
            for (result, marks) in self.rows.values.iter_mut().zip(&self.marks) {
                if let (Err(error), Ok(_)) = (marks.check(is_clear, THOUSANDS), &result) {
                    if self.wanted.selection == Selection::Lateral {
                        return Err(error);
                    }
                    *result = Err(error);
                }
            }
        }
        let per_second = self.stamped.map_or(1.0, |(_, per_second)| per_second);
        self.rows.printed_digit_s = match &self.dates {
            Some(clock) => clock.last_digit(),
            None => self.digits.last_digit() / per_second,
        };
        self.rows.decimal_comma =
            self.decimal == Decimal::Comma || self.decimal == Decimal::Stated(DecimalMark::Comma);
        Ok(self.rows)
    }
}

/// What to do where marks may separate thousands.
const THOUSANDS: &str = "state the setting `decimal` = . or the setting `decimal` = , ; the other mark then separates thousands";

/// Tells whether a stamp is refused for being that of the row before.
fn is_repeated(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::TimeNotIncreasing { previous, found } if found >= previous)
}

/// Counts the rows of data before any of them is kept.
fn check_counts(
    text: &[u8],
    layout: &TableLayout,
    wanted: &WantedColumns,
    limits: &Limits,
) -> Result<(), Error> {
    let by_cells = limits.table_cells / (wanted.columns.len() as u64).max(1);
    let most = limits.samples.min(by_cells);
    // Too few bytes for too many rows, whatever they hold: no need to look at each line.
    let lines = memchr::memchr_iter(b'\n', text).count() + 1;
    if lines as u64 <= most {
        return Ok(());
    }
    let (mut rows, mut start) = (0_u64, 0);
    for (index, line) in text.split_inclusive(|byte| *byte == b'\n').enumerate() {
        rows += u64::from(dialect::is_row(line));
        if rows > most.saturating_add(layout.header_rows as u64) {
            let error = match limits.samples <= by_cells {
                true => limits.over("samples", "more rows"),
                false => limits.over("table_cells", "more cells"),
            };
            return Err(error.at(Place::default().line(index as u64 + 1).byte(start)));
        }
        start += line.len() as u64;
    }
    Ok(())
}

/// Returns the row that the table reader began to read at a byte, comments passed over.
fn row_at(text: &[u8], start: usize) -> Option<&[u8]> {
    text.get(start..)?
        .split(|byte| *byte == b'\n')
        .find(|line| dialect::is_row(line))
        .map(<[u8]>::trim_ascii_end)
}
