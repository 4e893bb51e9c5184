//! Rows: the stamps and the samples of the wanted columns, in one pass for all selections.

use super::cell::{bad_cell, no_date, shown};
use super::date;
use super::dialect::{self, Separator};
use super::layout::{TableLayout, TimeSource};
use super::records::{Records, Row};
use crate::error::{Error, ErrorKind, Place};
use crate::recording::number::{self, Decimal, Marks, PrintedDigits};
use crate::recording::{Limits, ReadOptions, Selection};
use crate::units::DecimalMark;

/// What became of a wanted column.
#[derive(Debug, Clone)]
pub(super) enum ColumnResult {
    /// Its samples, in its own unit.
    Kept(Vec<f64>),
    /// Why it holds no channel; only where every channel is read.
    LeftOut(String),
}

/// Columns to read for one selection.
#[derive(Debug, PartialEq)]
pub(super) struct WantedColumns<'a> {
    pub(super) selection: Selection,
    /// Columns of samples.
    pub(super) columns: &'a [usize],
    /// Columns that count the rows, which are held against them.
    pub(super) counters: Vec<usize>,
}

/// The rows of a table.
#[derive(Debug, Clone)]
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
    /// The counts of the columns that count the rows, in their order; of one with a cell that is
    /// no number the reason.
    pub(super) counts: Vec<ColumnResult>,
}

impl Rows {
    /// Returns the size of the coarsest stamp's last digit [s]; 0 unless stamps repeat.
    fn coarsest_digit_s(&self) -> f64 {
        let digits = self.coarse_digits_s.iter().flatten();
        digits.copied().fold(0.0, f64::max)
    }
}

/// Reads the rows once for all that is wanted; gives the rows, or the first bad cell at its line
/// and column, for each. Where every channel is read, a column with a bad cell is left out instead.
pub(super) fn read(
    text: &[u8],
    layout: &TableLayout,
    time: &TimeSource,
    wanted: &[WantedColumns<'_>],
    options: &ReadOptions,
    limits: &Limits,
) -> Vec<Result<Rows, Error>> {
    let table = RowTable {
        text,
        layout,
        time,
        decimal: options.decimal,
    };
    let mut rows = table.pass(wanted, false, limits);
    let stamps_are_numbers = !matches!(time, TimeSource::Column { dated: true, .. });
    if let (true, Some(rate)) = (stamps_are_numbers, options.rate_hz) {
        // Stamps of too few digits: the stated rate is held against them later.
        for (wanted, rows) in wanted.iter().zip(&mut rows) {
            if rows.as_ref().is_err_and(is_repeated)
                && let Some(Ok(again)) =
                    table.pass(std::slice::from_ref(wanted), true, limits).pop()
                && again.coarsest_digit_s() * rate > 1.01
            {
                *rows = Ok(again);
            }
        }
    }
    rows
}

/// A table whose rows are read.
#[derive(Clone, Copy)]
struct RowTable<'a> {
    text: &'a [u8],
    layout: &'a TableLayout,
    time: &'a TimeSource,
    /// The decimal mark that a person states.
    decimal: Option<DecimalMark>,
}

impl RowTable<'_> {
    /// Goes over the rows; with `repeating` a stamp may be that of the row before.
    fn pass(
        self,
        wanted: &[WantedColumns<'_>],
        repeating: bool,
        limits: &Limits,
    ) -> Vec<Result<Rows, Error>> {
        let mut gathered: Vec<Result<Gathering<'_>, Error>> = wanted
            .iter()
            .map(|wanted| {
                check_counts(self.text, self.layout, wanted, limits)?;
                Ok(Gathering::new(self, wanted, repeating))
            })
            .collect();
        if let Err(error) = self.hand_out(&mut gathered) {
            return wanted.iter().map(|_| Err(error.clone())).collect();
        }
        let finish = |one: Result<Gathering<'_>, Error>| one?.finish();
        gathered.into_iter().map(finish).collect()
    }
}

impl RowTable<'_> {
    /// Hands each row to all that gather and have not failed.
    fn hand_out(self, gathered: &mut [Result<Gathering<'_>, Error>]) -> Result<(), Error> {
        let layout = self.layout;
        let mut records = Records::after_header(
            self.text,
            layout.separator,
            layout.quoted,
            layout.header_rows,
        )?;
        while gathered.iter().any(Result::is_ok)
            && let Some(row) = records.next()?
        {
            for one in &mut *gathered {
                if let Ok(rows) = one
                    && let Err(error) = rows.take(row)
                {
                    *one = Err(error);
                }
            }
        }
        Ok(())
    }
}

/// Rows as they are gathered for one selection.
struct Gathering<'a> {
    table: RowTable<'a>,
    wanted: &'a WantedColumns<'a>,
    rows: Rows,
    /// The column of stamps, with their number per second.
    stamped: Option<(usize, f64)>,
    /// The clock of stamps that are dates.
    dates: Option<date::DateClock>,
    /// Mark of stamps and samples.
    decimal: Decimal,
    /// Mark of each counter, which are no samples.
    count_decimals: Vec<Decimal>,
    digits: PrintedDigits,
    stamp_marks: AmbiguousMarks,
    marks: Vec<AmbiguousMarks>,
    /// Byte at which the last row that was kept begins.
    last_byte: u64,
}

impl<'a> Gathering<'a> {
    fn new(table: RowTable<'a>, wanted: &'a WantedColumns<'a>, repeating: bool) -> Self {
        let (stamped, dated) = match table.time {
            TimeSource::Column {
                index, unit, dated, ..
            } => (Some((*index, unit.per_second())), *dated),
            TimeSource::Rate(_) => (None, false),
        };
        // Between commas only quotes can hold a number with a comma together.
        let decimal = match table.decimal {
            Some(mark) => Decimal::Stated(mark),
            None if table.between_commas() && !table.layout.quoted => Decimal::PointOnly,
            None => Decimal::Unknown,
        };
        let none_yet = |columns: &[usize]| vec![ColumnResult::Kept(Vec::new()); columns.len()];
        Self {
            table,
            wanted,
            rows: Rows {
                stamps_s: Vec::new(),
                printed_digit_s: 0.0,
                values: none_yet(wanted.columns),
                count: 0,
                repeated: None,
                coarse_digits_s: repeating.then(Vec::new),
                decimal_comma: false,
                counts: none_yet(&wanted.counters),
            },
            stamped,
            dates: dated.then(date::DateClock::default),
            decimal,
            count_decimals: vec![decimal; wanted.counters.len()],
            digits: PrintedDigits::new(),
            stamp_marks: AmbiguousMarks::default(),
            marks: vec![AmbiguousMarks::default(); wanted.columns.len()],
            last_byte: 0,
        }
    }

    /// Takes in one row.
    fn take(&mut self, row: Row<'_>) -> Result<(), Error> {
        self.table
            .layout
            .check_row(row)
            .map_err(|(column, error)| {
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
                self.stamp_marks.look(row, column);
                if let Some(digits) = &mut self.rows.coarse_digits_s {
                    // Zero has the digits of its neighbours.
                    let own = PrintedDigits::of_cell(&row[column]) / per_second;
                    let before = digits.last().copied().unwrap_or(0.0);
                    digits.push(if own > 0.0 { own } else { before });
                }
            }
            self.rows.stamps_s.push(stamp);
            self.last_byte = row.byte;
        }
        self.rows.count += 1;
        let columns = self.wanted.columns.iter().zip(&mut self.rows.values);
        for ((column, result), marks) in columns.zip(&mut self.marks) {
            let ColumnResult::Kept(samples) = result else {
                continue;
            };
            match number::parse(&row[*column], &mut self.decimal) {
                Ok(value) => {
                    samples.push(value);
                    marks.look(row, *column);
                }
                Err(fault) => {
                    let error = self.table.bad_cell(row, *column, fault);
                    if self.wanted.selection == Selection::Lateral {
                        return Err(error);
                    }
                    *result = ColumnResult::LeftOut(error.to_string());
                }
            }
        }
        let counters = self.wanted.counters.iter().zip(&mut self.rows.counts);
        for ((column, result), decimal) in counters.zip(&mut self.count_decimals) {
            let ColumnResult::Kept(samples) = result else {
                continue;
            };
            match number::parse(&row[*column], decimal) {
                Ok(value) => samples.push(value),
                Err(fault) => {
                    let error = self.table.bad_cell(row, *column, fault);
                    *result = ColumnResult::LeftOut(error.to_string());
                }
            }
        }
        Ok(())
    }

    /// Reads a stamp [s].
    fn stamp(&mut self, row: Row<'_>, column: usize, per_second: f64) -> Result<f64, Error> {
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
    ///
    /// # Errors
    ///
    /// [`ErrorKind::TimeNotIncreasing`] where another row has no later stamp.
    fn repeats_row(&mut self, row: Row<'_>, column: usize, stamp: f64) -> Result<bool, Error> {
        let Some(previous) = self.rows.stamps_s.last().copied() else {
            return Ok(false);
        };
        let repeating = self.rows.coarse_digits_s.is_some();
        if stamp > previous || (stamp >= previous && repeating) {
            return Ok(false);
        }
        let text = self.table.text;
        let place = self.table.place(row, column);
        if row_at(text, self.last_byte) == row_at(text, row.byte) {
            let first = place.line.unwrap_or(0);
            let (rows, first) = self.rows.repeated.unwrap_or((0, first));
            self.rows.repeated = Some((rows + 1, first));
            return Ok(true);
        }
        Err(Error::from(ErrorKind::TimeNotIncreasing {
            previous,
            found: stamp,
        })
        .at(place))
    }

    /// Judges what only all rows together show: marks that may separate thousands.
    fn finish(mut self) -> Result<Rows, Error> {
        let text = self.table.text;
        // Between commas a comma in a number more often separates thousands.
        let strict = self.table.between_commas() && self.decimal == Decimal::Comma;
        let doubted = self.table.decimal.is_none();
        if let Some(error) = self.stamp_marks.error(text, strict).filter(|_| doubted) {
            return Err(error);
        }
        if doubted && !self.stamp_marks.marks.decimal {
            for (result, marks) in self.rows.values.iter_mut().zip(&self.marks) {
                if let (Some(error), ColumnResult::Kept(_)) = (marks.error(text, strict), &result) {
                    if self.wanted.selection == Selection::Lateral {
                        return Err(error);
                    }
                    *result = ColumnResult::LeftOut(error.to_string());
                }
            }
        }
        self.rows.printed_digit_s = match (&self.dates, self.stamped) {
            (Some(clock), _) => clock.last_digit(),
            (None, stamped) => {
                self.digits.last_digit() / stamped.map_or(1.0, |(_, per_second)| per_second)
            }
        };
        self.rows.decimal_comma =
            self.decimal == Decimal::Comma || self.decimal == Decimal::Stated(DecimalMark::Comma);
        Ok(self.rows)
    }
}

impl RowTable<'_> {
    fn between_commas(self) -> bool {
        self.layout.separator == Separator::Comma
    }

    fn place(self, row: Row<'_>, column: usize) -> Place {
        Place::default()
            .line(dialect::line_of_record(self.text, row.byte))
            .column(column as u64 + 1)
    }

    fn bad_cell(self, row: Row<'_>, column: usize, fault: number::NumberFault) -> Error {
        bad_cell(&row[column], fault).at(self.place(row, column))
    }
}

/// What the marks of a column may be, and where the first doubtful one stands.
#[derive(Clone, Default)]
struct AmbiguousMarks {
    marks: Marks,
    /// Byte at which its row was begun, its column, and the cell.
    first: Option<(u64, usize, String)>,
}

impl AmbiguousMarks {
    fn look(&mut self, row: Row<'_>, column: usize) {
        let cell = &row[column];
        if self.marks.look(cell) {
            self.first = Some((row.byte, column, shown(cell)));
        }
    }

    /// Returns the error for a column whose marks may separate thousands; with `strict` for one
    /// in which no number tells that they do not.
    fn error(&self, text: &[u8], strict: bool) -> Option<Error> {
        let (byte, column, cell) = self.first.as_ref()?;
        let doubtful = self.marks.may_be_thousands() || (strict && !self.marks.decimal);
        doubtful.then(|| {
            Error::from(ErrorKind::Malformed {
                expected: "numbers whose mark is clear".into(),
                found: format!(
                    "`{cell}`, and no number in the column whose mark can only be a decimal one"
                ),
                hint: "state the setting `decimal` = . or the setting `decimal` = , ; the other mark then separates thousands".into(),
            })
            .at(Place::default()
                .line(dialect::line_of_record(text, *byte))
                .column(*column as u64 + 1))
        })
    }
}

/// Tells whether a stamp is refused for being that of the row before.
fn is_repeated(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::TimeNotIncreasing { previous, found } if found >= previous)
}

/// Counts the rows of data before any of them is kept.
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] at the first row beyond `samples` or `table_cells`.
fn check_counts(
    text: &[u8],
    layout: &TableLayout,
    wanted: &WantedColumns<'_>,
    limits: &Limits,
) -> Result<(), Error> {
    let columns = wanted.columns.len() + wanted.counters.len();
    let by_cells = limits.table_cells / (columns as u64).max(1);
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
            let error = if limits.samples <= by_cells {
                over("samples", limits.samples, "more rows")
            } else {
                over("table_cells", limits.table_cells, "more cells")
            };
            return Err(error.at(Place::default().line(index as u64 + 1).byte(start)));
        }
        start += line.len() as u64;
    }
    Ok(())
}

/// Returns the row that the table reader began to read at `byte`, comments passed over.
fn row_at(text: &[u8], byte: u64) -> Option<&[u8]> {
    let start = usize::try_from(byte).ok()?;
    text.get(start..)?
        .split(|byte| *byte == b'\n')
        .find(|line| dialect::is_row(line))
        .map(<[u8]>::trim_ascii_end)
}

fn over(limit: &'static str, value: u64, found: &str) -> Error {
    ErrorKind::LimitExceeded {
        limit,
        value,
        found: found.into(),
    }
    .into()
}
