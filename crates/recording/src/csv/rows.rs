//! Rows: the stamps and the samples of the selected columns.

use super::clock;
use super::dialect::{self, Separator};
use super::layout::{TableLayout, TimeSource};
use super::records;
use super::stamp::{self, StampClock};
use crate::error::{Error, ErrorKind, Place};
use crate::number::{self, Decimal, Marks, NumberFault, PrintedDigits};
use crate::setting::Setting;
use crate::text::{ColumnMarks, bad_cell, no_stamp};
use crate::time_base::round_to_digits;
use crate::{Finding, Limits, ReadTask, Selection};
use ::csv::ByteRecord;
use latchgate_kernel::units::{DecimalMark, TimeUnit};

/// Samples of a column in its own unit, or the reason why it is no channel. A reason is kept only where
/// every channel is read; else it ends the reading.
pub(super) type ColumnResult = Result<Vec<f64>, Error>;

/// Columns to read for one selection.
#[derive(Debug, PartialEq)]
pub(super) struct SelectedColumns {
    pub(super) selection: Selection,
    /// Columns of samples, and after them those that count the rows.
    pub(super) columns: Vec<usize>,
    /// Number of the columns of samples.
    pub(super) samples: usize,
}

/// The rows of a table.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    /// Stamps [s]; empty without a time column.
    pub(super) stamps_s: Vec<f64>,
    /// Size of the last printed digit of a stamp [s]; 0 if unknown.
    pub(super) printed_digit_s: f64,
    /// Samples of the selected columns, in their order.
    pub(super) values: Vec<ColumnResult>,
    /// Number of rows.
    pub(super) count: usize,
    /// Rows that repeat the one before to the last cell, and the line of the first.
    pub(super) repeated: Option<(usize, u64)>,
    /// The stamp that repeats the one before, where the usable rows end.
    pub(super) ended: Option<DoubledStamp>,
    /// Size of each stamp's last digit [s], where stamps repeat those before, so that only a
    /// stated rate can tell the time.
    pub(super) coarse_digits_s: Option<Vec<f64>>,
    /// True if the numbers have a decimal comma.
    pub(super) decimal_comma: bool,
    /// True if stamps are words.
    of_words: bool,
    pub(super) stamp_facts: StampFacts,
}

/// Facts of stamps as words.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StampFacts {
    /// True if time is counted from the first of them.
    pub(super) count_from_first: bool,
    /// True if the first of them is an instant of some day.
    pub(super) is_absolute: bool,
    /// True if the order of day and month was inferred from the next date alone.
    pub(super) order_is_assumed: bool,
}

/// A stamp that repeats the one before, with other samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DoubledStamp {
    at_s: f64,
    line: Option<u64>,
}

impl DoubledStamp {
    /// Returns the finding that nothing after it is used.
    pub(super) fn finding(&self, time: &TimeSource, layout: &TableLayout) -> Finding {
        let name = time
            .column()
            .map_or("", |index| &layout.columns[index].name);
        let line = self
            .line
            .map_or(String::new(), |line| format!(" on line {line}"));
        let text = format!(
            "`{name}` holds {} s twice, the second time{line}. Samples from there on have no known \
             time and were left out. Export again; if only digits are missing, state {} = HZ",
            self.at_s,
            Setting::RateHz
        );
        Finding::blocking("stamp-doubled", text).at(self.at_s)
    }
}

/// Fewest rows before a doubled stamp that are judged as a recording.
const FEWEST: usize = 64;

/// Treatment of a stamp that repeats the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Repeats {
    Refused,
    /// It has too few digits; the stated rate is compared with all of them later.
    Coarse,
    /// It ends the rows.
    End,
}

impl Rows {
    /// Scales the stamps to a unit of that length [s].
    pub(super) fn scale_stamps(&mut self, unit_s: f64) {
        // A quotient with a plain number of parts keeps the digits of a stamp.
        let parts = round_to_digits(1.0 / unit_s, 12);
        let seconds = |stamp: f64| match unit_s < 1.0 {
            true => stamp / parts,
            false => stamp * unit_s,
        };
        self.stamps_s
            .iter_mut()
            .for_each(|stamp| *stamp = seconds(*stamp));
        self.printed_digit_s *= unit_s;
    }

    /// Counts from the first stamp if that is a day of this century, `per_second` days being a second.
    pub(super) fn count_days_from_first(&mut self, per_second: f64) {
        let first = self.stamps_s.first().copied().unwrap_or(0.0);
        let unit = clock::absolute_unit(first * per_second);
        if unit == Some(TimeUnit::DAY) && per_second < 2.0 / TimeUnit::DAY.seconds() {
            self.stamps_s.iter_mut().for_each(|stamp| *stamp -= first);
            // The stamps were rounded as numbers of days, and keep that rounding.
            self.printed_digit_s += 4.0 * f64::EPSILON * first;
            self.stamp_facts.is_absolute = true;
        }
    }

    /// True if all stamps are the same.
    fn stand_still(&self) -> bool {
        self.stamps_s.first() == self.stamps_s.last()
    }

    /// Drops stamps as words that are the same in every row and would have to change by the stated rate
    /// [Hz]: they are a date of the recording. Returns true if they were.
    pub(super) fn drop_date(&mut self, stated_hz: f64) -> bool {
        let span_s = self.count.saturating_sub(1) as f64 / stated_hz;
        let coarse = self.coarse_digits_s.is_some() && self.coarsest_digit_s() < span_s;
        let dropped = coarse && self.of_words && self.stand_still();
        if dropped {
            self.stamps_s.clear();
            self.coarse_digits_s = None;
            self.stamp_facts = StampFacts::default();
        }
        dropped
    }

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
    selected: &SelectedColumns,
    task: ReadTask,
) -> Result<Rows, Error> {
    let table = RowTable {
        text,
        layout,
        time,
        task,
    };
    check_counts(text, layout, selected, task.limits)?;
    let rows = table.pass(selected, Repeats::Refused);
    if let (Err(error), Some(rate)) = (&rows, task.options.rate_hz)
        && is_repeated(error)
        // Stamps of too few digits: the stated rate is compared with them later.
        && let Ok(coarse) = table.pass(selected, Repeats::Coarse)
        && (coarse.coarsest_digit_s() * rate > 1.01 || coarse.stand_still())
    {
        return Ok(coarse);
    }
    match rows {
        Err(error) if is_repeated(&error) => {
            let rows_before = table.pass(selected, Repeats::End)?;
            match rows_before.count < FEWEST {
                true => Err(error),
                false => Ok(rows_before),
            }
        }
        rows => rows,
    }
}

/// A table whose rows are read.
#[derive(Clone, Copy)]
struct RowTable<'a> {
    text: &'a [u8],
    layout: &'a TableLayout,
    time: &'a TimeSource,
    task: ReadTask<'a>,
}

impl RowTable<'_> {
    /// Goes over the rows.
    fn pass(self, selected: &SelectedColumns, repeats: Repeats) -> Result<Rows, Error> {
        let layout = self.layout;
        let mut gathered = Gathering::new(self, selected, repeats);
        let mut records = layout.records(self.text, self.task.limits)?;
        while gathered.rows.ended.is_none()
            && let Some(row) = records.next()?
        {
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
    selected: &'a SelectedColumns,
    rows: Rows,
    repeats: Repeats,
    /// The column of stamps, with their unit.
    stamped: Option<(usize, TimeUnit)>,
    /// The clock of stamps that are words.
    words: Option<StampClock>,
    /// Mark of stamps and samples.
    decimal: Decimal,
    digits: PrintedDigits,
    stamp_marks: ColumnMarks,
    marks: Vec<ColumnMarks>,
    /// Byte at which the last row that was kept begins.
    last_byte: usize,
}

impl<'a> Gathering<'a> {
    fn new(table: RowTable<'a>, selected: &'a SelectedColumns, repeats: Repeats) -> Self {
        let (stamped, worded) = match table.time {
            TimeSource::Column {
                index,
                unit,
                worded,
                ..
            } => (Some((*index, *unit)), *worded),
            TimeSource::Rate(_) => (None, false),
        };
        // Between commas only quotes can hold a number with a comma together.
        let decimal = match table.task.options.decimal {
            Some(mark) => Decimal::Stated(mark),
            None if table.between_commas() && !table.layout.quoted => Decimal::PointOnly,
            None => Decimal::Unknown,
        };
        Self {
            table,
            selected,
            rows: Rows {
                values: vec![Ok(Vec::new()); selected.columns.len()],
                coarse_digits_s: (repeats == Repeats::Coarse).then(Vec::new),
                ..Rows::default()
            },
            repeats,
            stamped,
            words: worded.then(StampClock::default),
            decimal,
            digits: PrintedDigits::new(),
            stamp_marks: ColumnMarks::default(),
            marks: vec![ColumnMarks::default(); selected.columns.len()],
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
        if let Some((column, unit)) = self.stamped {
            let stamp = self.stamp(row, column, unit)?;
            if self.repeats_row(row, column, stamp)? {
                return Ok(());
            }
            let number = match self.words.is_some() {
                true => stamp::amount(&row[column]).map(|(number, _)| number),
                false => Some(&row[column]),
            };
            if let Some(number) = number {
                self.digits.count(number);
                self.stamp_marks
                    .look(number, || self.table.place(row, column));
            }
            if let (Some(digits), None) = (&mut self.rows.coarse_digits_s, &self.words) {
                // Zero has the digits of its neighbours.
                let digit = unit.to_seconds(PrintedDigits::of_cell(&row[column]));
                let previous = digits.last().copied().unwrap_or(0.0);
                digits.push(if digit > 0.0 { digit } else { previous });
            }
            self.rows.stamps_s.push(stamp);
            self.last_byte = records::byte_of(row);
        }
        self.rows.count += 1;
        let columns = self.selected.columns.iter().zip(&mut self.rows.values);
        for (place, ((column, result), marks)) in columns.zip(&mut self.marks).enumerate() {
            let Ok(samples) = result else {
                continue;
            };
            let is_sample = place < self.selected.samples;
            // The mark of a column that counts rows does not decide that of the samples.
            let mut counter_decimal = self.decimal;
            let decimal = match is_sample {
                true => &mut self.decimal,
                false => &mut counter_decimal,
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
                    if is_sample && self.selected.selection == Selection::Lateral {
                        return Err(error);
                    }
                    *result = Err(error);
                }
            }
        }
        Ok(())
    }

    /// Reads a stamp [s].
    fn stamp(&mut self, row: &ByteRecord, column: usize, unit: TimeUnit) -> Result<f64, Error> {
        let cell = &row[column];
        match &mut self.words {
            Some(clock) => clock
                .read(cell, &mut self.decimal)
                .ok_or_else(|| no_stamp(cell).at(self.table.place(row, column))),
            None => number::parse(cell, &mut self.decimal)
                .map(|stamp| unit.to_seconds(stamp))
                .map_err(|fault| {
                    // Stamps of an unread form; separators in a cell show that rows were not split.
                    let is_unread_stamp = !self.table.layout.numeric[column]
                        && cell.iter().any(u8::is_ascii_digit)
                        && !cell.iter().any(|byte| b",;|".contains(byte));
                    match fault {
                        NumberFault::Text if is_unread_stamp => {
                            no_stamp(cell).at(self.table.place(row, column))
                        }
                        fault => self.table.bad_cell(row, column, fault),
                    }
                }),
        }
    }

    /// True if a row is the one before once more, which says nothing new and takes no
    /// sample away.
    fn repeats_row(&mut self, row: &ByteRecord, column: usize, stamp: f64) -> Result<bool, Error> {
        let Some(previous) = self.rows.stamps_s.last().copied() else {
            return Ok(false);
        };
        let repeating = self.repeats == Repeats::Coarse;
        if stamp > previous || (stamp >= previous && repeating) {
            return Ok(false);
        }
        let text = self.table.text;
        // To find a line, the text is counted from its begin, so it is done only for a message.
        let place = || self.table.place(row, column);
        if row_at(text, self.last_byte) == row_at(text, records::byte_of(row)) {
            let repeated = self.rows.repeated;
            let (rows, first) = repeated.unwrap_or_else(|| (0, place().line.unwrap_or(0)));
            self.rows.repeated = Some((rows + 1, first));
            return Ok(true);
        }
        if stamp >= previous && self.repeats == Repeats::End {
            self.rows.ended = Some(DoubledStamp {
                at_s: previous,
                line: place().line,
            });
            return Ok(true);
        }
        if self.words.is_none() && is_compact_date(&row[column]) {
            return Err(no_stamp(&row[column]).at(place()));
        }
        let found = stamp;
        Err(Error::from(ErrorKind::TimeNotIncreasing { previous, found }).at(place()))
    }

    /// Checks what only all rows together show: marks that may separate thousands.
    fn finish(mut self) -> Result<Rows, Error> {
        // In a table with commas between cells, a comma in a number more often separates thousands.
        let strict = self.table.between_commas() && self.decimal == Decimal::Comma;
        let is_clear =
            |_: &str, marks: Marks| !(marks.may_be_thousands() || (strict && !marks.decimal));
        let is_stated = self.table.task.options.decimal.is_some();
        if !is_stated {
            self.stamp_marks.check(is_clear, THOUSANDS)?;
        }
        if !is_stated && !self.stamp_marks.marks.decimal {
            for (result, marks) in self.rows.values.iter_mut().zip(&self.marks) {
                if let (Err(error), Ok(_)) = (marks.check(is_clear, THOUSANDS), &result) {
                    if self.selected.selection == Selection::Lateral {
                        return Err(error);
                    }
                    *result = Err(error);
                }
            }
        }
        let unit = self.stamped.map_or(TimeUnit::SECOND, |(_, unit)| unit);
        self.rows.printed_digit_s = match &self.words {
            Some(clock) => clock.last_digit(),
            None => unit.to_seconds(self.digits.last_digit()),
        };
        if let Some(clock) = &self.words {
            self.rows.of_words = true;
            self.rows.stamp_facts = StampFacts {
                count_from_first: clock.counts_from_first(),
                is_absolute: clock.is_absolute(),
                order_is_assumed: clock.order_is_assumed(),
            };
            if let Some(digits) = &mut self.rows.coarse_digits_s {
                digits.resize(self.rows.stamps_s.len(), clock.last_digit());
            }
        } else if let Some(digits) = &mut self.rows.coarse_digits_s {
            let zeros = digits.iter().position(|digit| *digit > 0.0).unwrap_or(0);
            let first = digits.get(zeros).copied().unwrap_or(0.0);
            digits[..zeros].fill(first);
        }
        self.rows.decimal_comma =
            self.decimal == Decimal::Comma || self.decimal == Decimal::Stated(DecimalMark::Comma);
        Ok(self.rows)
    }
}

/// The remedy where marks may separate thousands.
const THOUSANDS: &str = "state the setting `decimal` = . or the setting `decimal` = , ; the other \
                         mark then separates thousands";

/// True if a number is a date and a time of day without marks between them, `20240501100000.0002`. No
/// floating-point number holds all of its digits.
fn is_compact_date(cell: &[u8]) -> bool {
    let digits = cell.trim_ascii().split(|byte| *byte == b'.').next();
    digits.is_some_and(|digits| {
        digits.len() == 14
            && digits.iter().all(u8::is_ascii_digit)
            && matches!(digits, [b'1', b'9', ..] | [b'2', b'0', ..])
            && matches!(&digits[4..6], month if *month <= b"12"[..])
    })
}

/// True if the error is a stamp equal to that of the row before.
fn is_repeated(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::TimeNotIncreasing { previous, found } if found >= previous)
}

/// Checks the number of rows and cells before any of them is kept.
fn check_counts(
    text: &[u8],
    layout: &TableLayout,
    selected: &SelectedColumns,
    limits: &Limits,
) -> Result<(), Error> {
    let by_cells = limits.table_cells / (selected.columns.len() as u64).max(1);
    let row_limit = limits.samples.min(by_cells);
    // Fewer lines than the limit cannot be too many rows, so that most files need no look at each.
    let lines = memchr::memchr_iter(b'\n', text).count() + 1;
    if lines as u64 <= row_limit {
        return Ok(());
    }
    let (mut rows, mut start) = (0_u64, 0);
    for (index, line) in text.split_inclusive(|byte| *byte == b'\n').enumerate() {
        rows += u64::from(dialect::is_row(line));
        if rows > row_limit.saturating_add(layout.header_rows as u64) {
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

/// Returns the row that the table reader began to read at a byte, comments skipped.
fn row_at(text: &[u8], start: usize) -> Option<&[u8]> {
    text.get(start..)?
        .split(|byte| *byte == b'\n')
        .find(|line| dialect::is_row(line))
        .map(<[u8]>::trim_ascii_end)
}
