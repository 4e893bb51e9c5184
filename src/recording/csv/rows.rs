//! Rows: the stamps and the samples of the wanted columns.

use super::date;
use super::dialect::{self, Separator};
use super::layout::{Layout, TimeSource};
use super::number::{self, Decimal, Fault, Marks, PrintedDigits};
use super::plain;
use crate::error::{Error, ErrorKind, Place};
use crate::recording::{Limits, ReadOptions, Selection};

/// What became of a wanted column.
#[derive(Debug)]
pub(super) enum Fate {
    /// Its samples, in its own unit.
    Kept(Vec<f64>),
    /// Why it holds no channel; only where every channel is read.
    LeftOut(String),
}

/// The rows of a table.
#[derive(Debug)]
pub(super) struct Rows {
    /// Stamps [s]; empty without a time column.
    pub(super) stamps_s: Vec<f64>,
    /// Size of the last printed digit of a stamp [s]; 0 if unknown.
    pub(super) printed_digit_s: f64,
    /// Samples of the wanted columns, in their order.
    pub(super) values: Vec<Fate>,
    /// Number of rows.
    pub(super) count: usize,
    /// Rows that repeat the one before to the last cell, and the line of the first.
    pub(super) repeated: Option<(usize, u64)>,
    /// Whether stamps repeat those before, so that only a stated rate can tell the time.
    pub(super) stamps_repeat: bool,
    /// Whether the numbers have a decimal comma.
    pub(super) decimal_comma: bool,
    /// The counts of the columns that count the rows, in their order; of one with a cell that is
    /// no number the reason.
    pub(super) counts: Vec<Fate>,
}

impl Rows {
    /// Reads the stamps, the `wanted` columns and the `counters` of all rows.
    ///
    /// # Errors
    ///
    /// The first bad cell, at its line and column. Where every channel is read, a column with
    /// a bad cell is left out instead.
    pub(super) fn read(
        text: &[u8],
        layout: &Layout,
        time: &TimeSource,
        (wanted, counters): (&[usize], &[usize]),
        (options, selection): (&ReadOptions, Selection),
        limits: &Limits,
    ) -> Result<Self, Error> {
        let all = [wanted, counters].concat();
        let in_all = check_counts(text, layout, &all, limits)?;
        let (stamped, dated) = match time {
            TimeSource::Column {
                index, unit, dated, ..
            } => (Some((*index, unit.per_second())), *dated),
            TimeSource::Rate(_) => (None, false),
        };
        if !dated
            && let Some(mut rows) =
                plain::read(text, layout, stamped, &all, in_all, options.one_thread)
        {
            rows.counts = rows.values.split_off(wanted.len());
            return Ok(rows);
        }
        let read = |repeating: bool| {
            let columns = (wanted, counters);
            Self::read_carefully(text, layout, time, columns, selection, repeating)
        };
        match read(false) {
            // Stamps of too few digits: the stated rate is held against them later.
            Err(error) if !dated && is_repeated(&error) => {
                let coarse = |rows: &Self| {
                    options
                        .rate_hz
                        .is_some_and(|rate| rows.printed_digit_s * rate > 1.01)
                };
                if options.rate_hz.is_none() {
                    return Err(error);
                }
                read(true).ok().filter(coarse).ok_or(error)
            }
            read => read,
        }
    }

    /// Reads rows of whatever kind; with `repeating` a stamp may be that of the row before.
    fn read_carefully(
        text: &[u8],
        layout: &Layout,
        time: &TimeSource,
        (wanted, counters): (&[usize], &[usize]),
        selection: Selection,
        repeating: bool,
    ) -> Result<Self, Error> {
        let (stamped, dated) = match time {
            TimeSource::Column {
                index, unit, dated, ..
            } => (Some((*index, unit.per_second())), *dated),
            TimeSource::Rate(_) => (None, false),
        };
        let mut clock = date::Clock::default();
        let mut reader = dialect::reader(text, layout.separator, layout.quoted);
        let mut record = ::csv::ByteRecord::new();
        let mut last_byte = 0_u64;
        let mut repeated: Option<(usize, u64)> = None;
        let mut stamps_s: Vec<f64> = Vec::new();
        let mut digits = PrintedDigits::new();
        let (time_column, per_second) =
            stamped.map_or((None, 1.0), |(index, per_second)| (Some(index), per_second));
        // Between commas only quotes can hold a number with a comma together.
        let between_commas = layout.separator == Separator::Comma;
        let mut decimal = if between_commas && !layout.quoted {
            Decimal::PointOnly
        } else {
            Decimal::Unknown
        };
        let mut values: Vec<Fate> = wanted.iter().map(|_| Fate::Kept(Vec::new())).collect();
        let mut doubts: Vec<Doubt> = wanted.iter().map(|_| Doubt::default()).collect();
        let mut stamp_doubt = Doubt::default();
        let mut counts: Vec<Fate> = counters.iter().map(|_| Fate::Kept(Vec::new())).collect();
        let mut count_decimal = vec![decimal; counters.len()];
        let mut count = 0_usize;
        let mut skipped = 0;
        while reader
            .read_byte_record(&mut record)
            .map_err(|error| unreadable(&error))?
        {
            if skipped < layout.header_rows {
                skipped += 1;
                continue;
            }
            let at = |column: usize| {
                let byte = record.position().map_or(0, ::csv::Position::byte);
                Place::default()
                    .line(dialect::line_of_record(text, byte))
                    .column(column as u64 + 1)
            };
            let fail =
                |column: usize, fault: Fault| bad_cell(&record[column], fault).at(at(column));
            layout.check_row(&record).map_err(|(column, error)| {
                let place = at(column);
                error.at(Place {
                    column: place.column.filter(|_| column < record.len()),
                    ..place
                })
            })?;
            count += 1;
            if let Some(column) = time_column {
                let cell = &record[column];
                let stamp = if dated {
                    clock
                        .seconds(cell)
                        .ok_or_else(|| no_date(cell).at(at(column)))?
                } else {
                    number::parse(cell, &mut decimal).map_err(|fault| fail(column, fault))?
                        / per_second
                };
                if let Some(previous) = stamps_s.last().copied()
                    && (stamp < previous || (stamp <= previous && !repeating))
                {
                    let byte = record.position().map_or(0, ::csv::Position::byte);
                    if row_at(text, last_byte) == row_at(text, byte) {
                        // A row written twice says nothing new; it takes no sample away.
                        let line = at(column).line.unwrap_or(0);
                        let (rows, first) = repeated.unwrap_or((0, line));
                        repeated = Some((rows + 1, first));
                        count -= 1;
                        continue;
                    }
                    return Err(Error::from(ErrorKind::TimeNotIncreasing {
                        previous,
                        found: stamp,
                    })
                    .at(at(column)));
                }
                if !dated {
                    digits.count(cell);
                    stamp_doubt.look(&record, column);
                }
                stamps_s.push(stamp);
                last_byte = record.position().map_or(0, ::csv::Position::byte);
            }
            for ((column, fate), doubt) in wanted.iter().zip(&mut values).zip(&mut doubts) {
                let Fate::Kept(samples) = fate else { continue };
                match number::parse(&record[*column], &mut decimal) {
                    Ok(value) => {
                        samples.push(value);
                        doubt.look(&record, *column);
                    }
                    Err(fault) => {
                        let error = fail(*column, fault);
                        if selection == Selection::Lateral {
                            return Err(error);
                        }
                        *fate = Fate::LeftOut(error.to_string());
                    }
                }
            }
            for ((column, fate), decimal) in
                counters.iter().zip(&mut counts).zip(&mut count_decimal)
            {
                let Fate::Kept(samples) = fate else { continue };
                match number::parse(&record[*column], decimal) {
                    Ok(value) => samples.push(value),
                    Err(fault) => *fate = Fate::LeftOut(fail(*column, fault).to_string()),
                }
            }
        }
        // Between commas a comma in a number more often separates thousands.
        let strict = between_commas && decimal == Decimal::Comma;
        if let Some(error) = stamp_doubt.error(text, strict) {
            return Err(error);
        }
        if !stamp_doubt.marks.decimal {
            for (fate, doubt) in values.iter_mut().zip(&doubts) {
                match (doubt.error(text, strict), &fate) {
                    (Some(error), Fate::Kept(_)) if selection == Selection::Lateral => {
                        return Err(error);
                    }
                    (Some(error), Fate::Kept(_)) => *fate = Fate::LeftOut(error.to_string()),
                    _ => {}
                }
            }
        }
        Ok(Self {
            stamps_repeat: repeating,
            printed_digit_s: if dated {
                clock.last_digit()
            } else {
                digits.last_digit() / per_second
            },
            stamps_s,
            values,
            count,
            repeated,
            decimal_comma: decimal == Decimal::Comma,
            counts,
        })
    }
}

/// What a column's marks may be, and where the first doubtful one stands.
#[derive(Default)]
struct Doubt {
    marks: Marks,
    /// Byte at which its row was begun, its column, and the cell.
    first: Option<(u64, usize, String)>,
}

impl Doubt {
    fn look(&mut self, record: &::csv::ByteRecord, column: usize) {
        let cell = &record[column];
        if self.marks.look(cell) {
            let byte = record.position().map_or(0, ::csv::Position::byte);
            self.first = Some((byte, column, shown(cell)));
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
                hint: "the mark may separate thousands or decimals; export without marks between thousands, and with the same number of decimals in every row".into(),
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
    layout: &Layout,
    wanted: &[usize],
    limits: &Limits,
) -> Result<usize, Error> {
    let by_cells = limits.table_cells / (wanted.len() as u64).max(1);
    let most = limits.samples.min(by_cells);
    // Too few bytes for too many rows, whatever they hold: no need to look at each line.
    let lines = memchr::memchr_iter(b'\n', text).count() + 1;
    if lines as u64 <= most {
        return Ok(lines);
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
    Ok(usize::try_from(rows).unwrap_or(0))
}

/// Returns the row that the table reader began to read at `byte`, comments passed over.
fn row_at(text: &[u8], byte: u64) -> Option<&[u8]> {
    let start = usize::try_from(byte).ok()?;
    text.get(start..)?
        .split(|byte| *byte == b'\n')
        .find(|line| dialect::is_row(line))
        .map(<[u8]>::trim_ascii_end)
}

/// Says that the table reader failed, which it cannot on bytes in memory.
pub(super) fn unreadable(error: &::csv::Error) -> Error {
    ErrorKind::Io {
        action: "read the table",
        reason: error.to_string(),
    }
    .into()
}

fn bad_cell(cell: &[u8], fault: Fault) -> Error {
    let found = shown(cell);
    let malformed = |expected: &str, found: String, hint: &str| ErrorKind::Malformed {
        expected: expected.into(),
        found,
        hint: hint.into(),
    };
    match fault {
        Fault::NonFinite => ErrorKind::NonFinite { found },
        Fault::Empty => malformed(
            "a number",
            "an empty cell".into(),
            "remove the row or fill the cell; a missing sample is not taken for zero",
        ),
        Fault::Text => malformed(
            "a number",
            format!("`{found}`{}", hidden(&found)),
            hint_for(&found),
        ),
        Fault::OtherMark => malformed(
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

fn no_date(cell: &[u8]) -> Error {
    ErrorKind::Malformed {
        expected: "a date and time such as 2024-05-01T10:00:00.0001, as in the rows before".into(),
        found: format!("`{}`", shown(cell)),
        hint: "mend the cell, or name another column with the setting `time_column`".into(),
    }
    .into()
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

fn over(limit: &'static str, value: u64, found: &str) -> Error {
    ErrorKind::LimitExceeded {
        limit,
        value,
        found: found.into(),
    }
    .into()
}
