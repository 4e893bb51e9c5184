//! Layouts: the rows of the header, the column of time, the one of the lateral acceleration.
//!
//! The layout is found in steps, each of which needs the one before: the end of the header, the names
//! of its columns, the one of time, the ones of samples.

use super::begin::{self, Begin};
use super::dialect::{LineScan, Separator};
use super::preamble::{Preamble, TableShape};
use super::records::{self, Records};
use super::stamp;
use super::unnamed;
use crate::channel_name::{self, ChannelName, is_known_unit};
use crate::error::{Candidate, Candidates, Error, ErrorKind, Place};
use crate::lateral::{self, ChannelOffer};
use crate::number::{self, Decimal};
use crate::text::{ONE_CELL, shown};
use crate::{Finding, Limits, ReadOptions, ReadTask, Selection};
use ::csv::ByteRecord;
use latchgate_kernel::units::{DecimalMark, SampleRate, TimeUnit};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Number of first rows, and of their bytes, that are enough for the layout: one row may be long.
const FEW_ROWS: usize = 8;
const SAMPLE_BYTES: usize = 4 << 20;

/// Most first rows by which the layout is found.
const SAMPLE_ROWS: usize = 64;

/// Source of the time of the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TimeSource {
    /// A column.
    Column {
        /// Its index, counted from 0.
        index: usize,
        /// The unit of its stamps.
        unit: TimeUnit,
        /// Source of that unit.
        origin: UnitOrigin,
        /// True if its stamps are words, such as dates and times of day.
        worded: bool,
    },
    /// A stated rate.
    Rate(SampleRate),
}

/// Source of the unit of a column of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum UnitOrigin {
    /// Option, card or file.
    Stated,
    /// Nothing: seconds are assumed.
    Assumed,
    /// The file, in a way that is not read.
    Unread,
}

impl TimeSource {
    /// Returns the index of its column, if it is one.
    pub(super) fn column(&self) -> Option<usize> {
        match self {
            Self::Column { index, .. } => Some(*index),
            Self::Rate(_) => None,
        }
    }
}

/// The columns to read, with the findings on their choice.
#[derive(Debug, Default)]
pub(super) struct ColumnChoice {
    /// Indices, counted from 0.
    pub(super) columns: Vec<usize>,
    pub(super) findings: Vec<Finding>,
}

/// A column that counts the rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counter {
    /// Its index, counted from 0.
    pub(super) column: usize,
    /// True if its name says so, false if only its numbers do.
    pub(super) is_named: bool,
}

/// Mapping of a text table or a sheet, for a person to check and to correct.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableMapping {
    /// The sheet of a workbook.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sheet: Option<String>,
    /// Separator of cells: `tab`, `semicolon`, `comma`, `blanks`, `nothing` or `the sheet`.
    pub separator: Cow<'static, str>,
    /// The decimal mark, `.` or `,`; `None` where no number of the first rows has one.
    pub decimal: Option<Cow<'static, str>>,
    /// The first rows above the names, each as key and values.
    #[serde(default)]
    pub above: Vec<String>,
    /// The line that names the columns, counted from 1.
    pub header_line: Option<u64>,
    /// The line of their units, where it is one of its own.
    #[serde(default)]
    pub unit_line: Option<u64>,
    /// The line of the first sample.
    pub data_line: Option<u64>,
    /// The column of time.
    pub time_column: Option<String>,
    /// Its unit.
    pub time_unit: Option<String>,
}

/// Layout of a table.
#[derive(Debug)]
pub(super) struct TableLayout {
    pub(super) separator: Separator,
    /// True if there are quotes in the text.
    pub(super) quoted: bool,
    /// Rows before the data.
    pub(super) header_rows: usize,
    pub(super) columns: Vec<ChannelName>,
    /// Cells of each data row, empty ones after the last column included.
    cells: usize,
    /// True if at least half of a column's first cells are numbers; the others are then faults.
    pub(super) numeric: Vec<bool>,
    /// True if at least half of a column's first cells are stamps as words, and true if those have a
    /// date.
    pub(super) worded: Vec<bool>,
    pub(super) dated: Vec<bool>,
    /// The usual step of columns of numbers that rise steadily over the first rows.
    pub(super) steps: Vec<Option<f64>>,
    /// True if a header names the columns.
    pub(super) named: bool,
    /// The rows above the names.
    pub(super) preamble: Preamble,
}

/// Results of the scan of a table, by which its layout is found.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableStart<'a> {
    pub(super) separator: Separator,
    /// The line of the names, where it was found below a preamble.
    pub(super) found_header: Option<u32>,
    pub(super) lines: &'a LineScan,
}

impl TableLayout {
    /// Finds the layout from the first rows.
    pub(super) fn find(text: &[u8], start: TableStart<'_>, task: ReadTask) -> Result<Self, Error> {
        let (options, separator) = (task.options, start.separator);
        let quoted = memchr::memchr(b'"', text).is_some();
        let rows = first_rows(Records::new(text, separator, quoted, task.limits))?;
        let header_line = options.header_line.or(start.found_header);
        let stated = header_line.is_some() || options.skip_lines.is_some();
        let step_of = |index: usize| usual_step(&rows, index);
        if !stated && let Some(error) = unnamed::refusal(text, &rows, options, step_of) {
            return Err(error);
        }
        let header_rows = match header_line {
            Some(line) => rows_of_header(text, &rows, line)?,
            None => count_header_rows(text, &rows, stated)?,
        };
        let (header, data) = rows.split_at(header_rows);
        let first = &data[0];
        if let Some(names) = header.first().filter(|_| separator == Separator::None) {
            check_one_column(text, names, first)?;
        }
        let named = !header.is_empty();
        let mut columns: Vec<ChannelName> = match named {
            false => (1..=filled_cells(first))
                .map(ChannelName::unnamed)
                .collect(),
            true => name_columns(header, first, options.unit_line.is_none()).map_err(|count| {
                let found = format!("{count} header cells over rows of {}", first.len());
                let expected = "as many header cells as the rows have";
                unclear_begin(text, &rows[0], expected, &found)
            })?,
        };
        let shape = TableShape {
            separator,
            width: columns.len(),
        };
        let preamble = Preamble::read(start.lines, shape, start.found_header);
        preamble.apply(&mut columns, options.unit_line.is_none());
        if let Some(line) = options.unit_line {
            let units = unit_cells(text, start, header, line)?;
            take_units(&mut columns, &units)
                .map_err(|error| error.at(Place::default().line(u64::from(line))))?;
        }
        channel_name::mark_columns(columns.iter_mut().collect(), options);
        let ragged = data.iter().any(|row| row.len() != first.len());
        let data_line = line_of(text, first).line.unwrap_or(0);
        if !stated && ragged && begin::find(text).is_some_and(|begin| begin.data > data_line) {
            let found = "rows of different lengths";
            return Err(unclear_begin(text, first, "rows of one length", found));
        }
        Ok(Self {
            separator,
            quoted,
            header_rows,
            cells: first.len(),
            numeric: mostly(&columns, data, number::is_numeric),
            worded: mostly(&columns, data, stamp::is_stamp),
            dated: mostly(&columns, data, stamp::is_dated),
            steps: (0..columns.len()).map(|i| usual_step(data, i)).collect(),
            columns,
            named,
            preamble,
        })
    }

    /// Returns the rows of data.
    pub(super) fn records<'a>(
        &self,
        text: &'a [u8],
        limits: &'a Limits,
    ) -> Result<Records<'a>, Error> {
        Records::new(text, self.separator, self.quoted, limits).after(self.header_rows)
    }

    /// Returns the mapping of the table.
    pub(super) fn mapping(&self, text: &[u8], task: ReadTask) -> Result<TableMapping, Error> {
        let options = task.options;
        let rows = Records::new(text, self.separator, self.quoted, task.limits);
        let rows = first_rows(rows)?;
        let (header, data) = rows.split_at(self.header_rows.min(rows.len()));
        let line = |row: &ByteRecord| records::line_of(text, row);
        let time = self.time_or_left_out(options, Selection::Every, &mut Vec::new());
        let (time_column, time_unit) = match time {
            Ok(Some(TimeSource::Column { index, unit, .. })) => {
                let name = self.columns.get(index).map(|column| column.name.clone());
                (name, Some(unit.to_string()))
            }
            _ => (None, None),
        };
        let has = |mark: &DecimalMark| {
            let mut cells = data.iter().flatten();
            let mark = mark.name().as_bytes()[0];
            cells.any(|cell| cell.contains(&mark) && number::is_numeric(cell))
        };
        let marks = [DecimalMark::Comma, DecimalMark::Point];
        let first_mark = || marks.into_iter().find(has);
        let units = header.iter().skip(1).find(|row| has_unit(row));
        Ok(TableMapping {
            sheet: None,
            separator: self.separator.name().into(),
            decimal: options
                .decimal
                .or_else(first_mark)
                .map(|mark| mark.name().into()),
            above: self.preamble.listed(),
            header_line: header.first().filter(|_| self.named).map(line),
            unit_line: options.unit_line.map(u64::from).or(units.map(line)),
            data_line: data.first().map(line),
            time_column,
            time_unit,
        })
    }

    /// True if cells could be a row of the table.
    pub(super) fn is_shaped(&self, cells: &[&[u8]]) -> bool {
        let numeric = self.numeric.iter().zip(cells);
        (self.columns.len()..=self.cells).contains(&cells.len())
            && numeric
                .filter(|(numeric, _)| **numeric)
                .all(|(_, cell)| number::is_numeric(cell))
    }

    /// Checks that a data row has the cells of the first one.
    pub(super) fn check_row(&self, row: &ByteRecord) -> Result<(), (usize, Error)> {
        let (expected, found) = (self.cells, row.len());
        if found != expected {
            return Err((found, ErrorKind::RaggedRow { expected, found }.into()));
        }
        let mut beyond = self.columns.len()..self.cells;
        let Some(index) = beyond.find(|index| !row[*index].trim_ascii().is_empty()) else {
            return Ok(());
        };
        let found = format!("`{}`", shown(&row[index]));
        let hint = "name the column in the header, or remove the cell";
        let error = Error::malformed("nothing after the last column", found, hint);
        Err((index, error))
    }

    /// Returns the columns that count the rows and are not read for anything else: those whose
    /// names say so, and without stamps also those whose numbers do.
    pub(super) fn counters(&self, time: &TimeSource, judged: &[usize]) -> Vec<Counter> {
        // Each counter is held in memory as a channel is.
        const MOST: usize = 8;
        let stamped = time.column();
        let free = |index: &usize| {
            Some(*index) != stamped
                && !judged.contains(index)
                && self.numeric[*index]
                && self.columns[*index].unit_text.is_none()
        };
        let counters = (0..self.columns.len()).filter(free);
        let counter = |column| Counter {
            column,
            is_named: self.is_index(column),
        };
        let mut counters: Vec<Counter> = counters.map(counter).collect();
        counters.retain(|counter| counter.is_named || stamped.is_none());
        counters.sort_by_key(|counter| !counter.is_named);
        counters.truncate(MOST);
        counters
    }

    /// Chooses the columns to read.
    pub(super) fn choose(
        &self,
        options: &ReadOptions,
        selection: Selection,
        time: &TimeSource,
    ) -> Result<ColumnChoice, Error> {
        let time = time.column();
        let candidates: Vec<usize> = (0..self.columns.len())
            .filter(|i| Some(*i) != time && self.numeric[*i] && !self.is_index(*i))
            .collect();
        if selection == Selection::Every {
            let (columns, findings) = (candidates, Vec::new());
            return Ok(ColumnChoice { columns, findings });
        }
        if let Some(requested) = &options.channel {
            let index = self.find_column(requested, "channel")?;
            if Some(index) == time {
                return Err(Error::malformed(
                    "a channel of acceleration",
                    format!("the time column `{}`", self.columns[index].name),
                    "choose another column, or state the time column with the setting \
                     `time_column` = NAME",
                ));
            }
            let findings = self.columns[index].not_lateral_finding().into_iter();
            let findings = findings.chain(self.by_name_finding(requested, index));
            return Ok(ColumnChoice {
                columns: vec![index],
                findings: findings.filter(|_| self.named).collect(),
            });
        }
        // A column that is named lateral, or is the only candidate, is read even if its first cells are
        // faults, so that the error names the cell.
        let is_clock = |i: usize| Some(i) == time || self.is_other_clock(i);
        let sample_columns =
            (0..self.columns.len()).filter(|i| !is_clock(*i) && !self.is_index(*i));
        let alone = sample_columns.clone().count() == 1;
        let offered = sample_columns
            .filter(|i| alone || self.numeric[*i] || self.columns[*i].says_lateral_acceleration());
        let offered: Vec<usize> = offered.collect();
        let columns = offered
            .iter()
            .map(|index| (index + 1, &self.columns[*index]));
        let choices = ChannelOffer::of_words(&columns.collect::<Vec<_>>(), "column");
        let (index, finding) = lateral::take(&choices, self.list(0..self.columns.len()))?;
        Ok(ColumnChoice {
            columns: vec![offered[index]],
            // The finding speaks of the column's name, and an unnamed column has none.
            findings: finding.into_iter().filter(|_| self.named).collect(),
        })
    }

    /// Finds a column by its name (as it stands, then without unit, then whatever its case) or
    /// by its number, counted from 1.
    pub(super) fn find_column(&self, requested: &str, what: &'static str) -> Result<usize, Error> {
        let small = requested.trim().to_lowercase();
        let ways: [&dyn Fn(&ChannelName) -> bool; 4] = [
            &|column| column.name == requested,
            &|column| !column.label.is_empty() && column.label == requested.trim(),
            &|column| {
                column.name.to_lowercase() == small
                    || (!small.is_empty() && column.label.to_lowercase() == small)
            },
            &|column| column.is_described_as(&small),
        ];
        let indices = 0..self.columns.len();
        for way in ways {
            let matches: Vec<usize> = indices.clone().filter(|i| way(&self.columns[*i])).collect();
            match matches.as_slice() {
                [] => {}
                [only] => return Ok(*only),
                several => {
                    let expected = format!("one column `{requested}`");
                    let found = self.list(several.iter().copied());
                    return Err(Error::malformed(expected, found, "choose it by number"));
                }
            }
        }
        if let Ok(number) = requested.trim().parse::<usize>()
            && (1..=self.columns.len()).contains(&number)
        {
            return Ok(number - 1);
        }
        let (known, requested) = (self.list(indices), requested.to_string());
        if what == "channel" {
            return Err(ErrorKind::NoSuchChannel { requested, known }.into());
        }
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        Err(Error::from(ErrorKind::UnknownName {
            what,
            nearest: crate::error::nearest_name(&requested, &names),
            found: requested,
            known,
        }))
    }

    /// Returns a finding where the stated channel is both the name of one column and the number of
    /// another.
    pub(super) fn by_name_finding(&self, requested: &str, index: usize) -> Option<Finding> {
        let number: usize = requested.trim().parse().ok()?;
        let numbered = self.columns.get(number.checked_sub(1)?)?;
        let text = format!(
            "`{number}` is the name of column {}, which was used. Column number {number} is named \
             `{}`. State the name of the one you mean",
            index + 1,
            shown(&numbered.name)
        );
        (number != index + 1).then(|| Finding::warning("column-by-name", text))
    }

    /// True if a column is a running number: by its name, or as the first one where only others
    /// are named.
    pub(super) fn is_index(&self, index: usize) -> bool {
        let column = &self.columns[index];
        let alone = self.columns.len() == 1;
        column.says_index() || (index == 0 && self.named && !alone && column.label.is_empty())
    }

    /// Lists columns for a message, at most a screenful; equal names get their number.
    pub(super) fn list(&self, indices: impl IntoIterator<Item = usize>) -> String {
        let candidate = |index: usize| {
            let name = shown(&self.columns[index].name);
            let same = |column: &&ChannelName| column.name == self.columns[index].name;
            match self.columns.iter().filter(same).count() {
                1 => Candidate::named(name),
                _ => Candidate::numbered(name, "column", index + 1),
            }
        };
        Candidates(indices.into_iter().map(candidate).collect()).to_string()
    }
}

/// Returns true for each column of which at least half of the first cells match.
fn mostly(columns: &[ChannelName], data: &[ByteRecord], matches: fn(&[u8]) -> bool) -> Vec<bool> {
    let is_mostly = |index: usize| {
        let cells = data
            .iter()
            .filter(|row| row.get(index).is_some_and(matches));
        2 * cells.count() >= data.len()
    };
    (0..columns.len()).map(is_mostly).collect()
}

/// Returns the usual step of a column of numbers, if it rises by like steps but for one of ten.
fn usual_step(data: &[ByteRecord], index: usize) -> Option<f64> {
    let mut decimal = Decimal::Unknown;
    let cells = data.iter().map(|row| row.get(index).unwrap_or_default());
    let numbers = cells.map(|cell| number::parse(cell, &mut decimal));
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().ok()?;
    let mut steps: Vec<f64> = numbers.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let usual = match steps.len() {
        0 | 1 => return None,
        _ => *steps.select_nth_unstable_by(middle, f64::total_cmp).1,
    };
    let alike = steps
        .iter()
        .filter(|step| (**step - usual).abs() <= 0.5 * usual);
    (usual > 0.0 && 10 * alike.count() >= 9 * steps.len()).then_some(usual)
}

fn first_rows(mut records: Records<'_>) -> Result<Vec<ByteRecord>, Error> {
    let (mut rows, mut bytes) = (Vec::new(), 0);
    while let Some(row) = records.next()? {
        bytes += row.as_slice().len();
        rows.push(row.clone());
        if rows.len() == SAMPLE_ROWS || (rows.len() >= FEW_ROWS && bytes > SAMPLE_BYTES) {
            break;
        }
    }
    Ok(rows)
}

fn has_number(row: &ByteRecord) -> bool {
    row.iter().any(number::is_numeric)
}

fn has_unit(row: &ByteRecord) -> bool {
    // A unit of time beside a number, such as `10 us`, is not the unit of another column.
    let has_digit = |text: &str| text.contains(|c: char| c.is_ascii_digit());
    let is_time = |text: &str| has_digit(text) && TimeUnit::from_spelling(text).is_some();
    row.iter().any(|cell| {
        let text = String::from_utf8_lossy(cell);
        is_known_unit(&text) || is_time(&text)
    })
}

fn no_rows(found: &str) -> Error {
    Error::empty(found, "rows of numbers")
}

/// Refuses names of several columns above rows of one cell.
fn check_one_column(text: &[u8], names: &ByteRecord, first: &ByteRecord) -> Result<(), Error> {
    let cell = text_of(names, 0);
    let separators = [',', ';', '\t', '|'];
    let names = separators.map(|separator| cell.split(separator).map(str::trim));
    let names = names.map(|names| names.filter(|name| !name.is_empty()).collect());
    let longest: Option<Vec<&str>> = names.into_iter().max_by_key(Vec::len);
    let names = longest.unwrap_or_default();
    // `a, g` is a name with its unit.
    let unit = matches!(names.as_slice(), [_, unit] if is_known_unit(unit));
    if names.len() < 2 || unit {
        return Ok(());
    }
    let error = Error::malformed(
        format!("rows of {} cells, as the header has names", names.len()),
        format!("rows of one cell, such as `{}`", shown(&first[0])),
        "export the columns of the other names as well, or only the one column with its name",
    );
    Err(error.at(line_of(text, first)))
}

/// Counts the rows before the data where a person states the line of the names: that line, and the
/// rows between it and the first number.
fn rows_of_header(text: &[u8], rows: &[ByteRecord], line: u32) -> Result<usize, Error> {
    let names = rows
        .first()
        .ok_or_else(|| no_rows("the file holds no rows"))?;
    let place = line_of(text, names);
    if place.line != Some(u64::from(line)) {
        let expected = format!("the names of the columns on line {line}");
        let hint = "state another line with the setting `header_line`";
        let error = Error::malformed(expected, "an empty line or a comment", hint);
        return Err(error.at(Place::default().line(u64::from(line))));
    }
    let data = rows.iter().skip(1).position(has_number);
    data.map(|between| between + 1)
        .ok_or_else(|| no_rows("no row of numbers follows the header"))
}

/// Counts the rows before the data: names, or names and units, or none where a person has `stated`
/// where the table begins.
fn count_header_rows(text: &[u8], rows: &[ByteRecord], stated: bool) -> Result<usize, Error> {
    let words = |row: &ByteRecord, expected: &str| {
        let cell = row.iter().find(|cell| !cell.trim_ascii().is_empty());
        let found = format!("`{}`", shown(cell.unwrap_or_default()));
        Err(unclear_begin(text, row, expected, &found))
    };
    let Some(names) = rows.first() else {
        return Err(no_rows("the file holds no rows"));
    };
    if has_number(names) {
        // A row of units is never below a row of samples: `x-axis,1,2` over `second,Volt,Volt`.
        if let [units, row, ..] = &rows[1..]
            && has_unit(units)
            && !has_number(units)
            && has_number(row)
        {
            return Ok(2);
        }
        if stated {
            return Ok(0);
        }
        let cells = names.iter().map(|cell| format!("`{}`", shown(cell)));
        let cells: Vec<String> = cells.take(SHOWN_CELLS).collect();
        let more = match names.len() {
            0..=SHOWN_CELLS => String::new(),
            all => format!(" and {} further cells", all - SHOWN_CELLS),
        };
        let expected = "a line that names the columns";
        return Err(unclear_begin(
            text,
            names,
            expected,
            &(cells.join(" and ") + &more),
        ));
    }
    match &rows[1..] {
        [row, ..] if has_number(row) => Ok(1),
        [units, row, ..] if has_unit(units) && has_number(row) => Ok(2),
        [units, row, ..] if has_unit(units) => words(row, "numbers after names and units"),
        [row, ..] if !has_unit(row) => words(row, "numbers or a row of units after the header"),
        _ => Err(no_rows("the file holds a header and no rows")),
    }
}

/// Most cells that a message shows.
const SHOWN_CELLS: usize = 3;

/// Returns the error for a table whose begin is not clear, with the setting that makes it clear.
fn unclear_begin(text: &[u8], row: &ByteRecord, expected: &str, found: &str) -> Error {
    let hint = match begin::find(text) {
        Some(Begin {
            header: Some(line), ..
        }) => format!(
            "the column names seem to be on line {line}; if so, state the setting `header_line` = \
             {line}"
        ),
        Some(Begin { data, .. }) => format!(
            "samples without names seem to begin on line {data}; if so, state the setting \
             `skip_lines` = {}",
            data - 1
        ),
        None => ONE_CELL.into(),
    };
    Error::malformed(expected, found, hint).at(line_of(text, row))
}

/// Builds the columns from the header rows; the number of header cells if they do not fit.
fn name_columns(
    header: &[ByteRecord],
    first: &ByteRecord,
    with_units: bool,
) -> Result<Vec<ChannelName>, usize> {
    let names = &header[0];
    let count = filled_cells(names);
    if count > first.len() || filled_cells(first) > count {
        return Err(count);
    }
    let name = |index: usize| ChannelName::from_header(&text_of(names, index), index + 1);
    let mut columns: Vec<ChannelName> = (0..count).map(name).collect();
    // Only one row of units is read; rows of descriptions are skipped.
    let units = header[1..].iter().find(|row| has_unit(row));
    if let Some(units) = units.filter(|_| with_units) {
        if filled_cells(units) > count {
            return Err(filled_cells(units));
        }
        for (index, column) in columns.iter_mut().enumerate() {
            *column = std::mem::take(column).with_unit(&text_of(units, index), "units row");
        }
    }
    Ok(columns)
}

/// Returns the cells of the line that the setting `unit_line` names.
fn unit_cells(
    text: &[u8],
    start: TableStart<'_>,
    header: &[ByteRecord],
    line: u32,
) -> Result<Vec<String>, Error> {
    let line = u64::from(line);
    let above = start.lines.above.iter().chain(&start.lines.words);
    let above = above.filter(|(number, _)| *number == line);
    let split = |row: &[u8]| -> Vec<String> {
        let cells = begin::cells(row, start.separator).into_iter();
        cells
            .map(|cell| String::from_utf8_lossy(cell).into_owned())
            .collect()
    };
    let mut above = above.map(|(_, row)| split(row.as_bytes()));
    let below = header
        .iter()
        .find(|row| records::line_of(text, row) == line);
    let below = || below.map(|row| (0..row.len()).map(|index| text_of(row, index)).collect());
    above.next().or_else(below).ok_or_else(|| {
        let expected = format!("the units of the columns on line {line}");
        let hint = "state another line with the setting `unit_line`";
        let found = "no line of words above the samples";
        Error::malformed(expected, found, hint).at(Place::default().line(line))
    })
}

/// Gives the columns the units of a row, whose first cell may be its key.
fn take_units(columns: &mut [ChannelName], units: &[String]) -> Result<(), Error> {
    if units.len() > columns.len() {
        let expected = format!("units of {} columns", columns.len());
        let found = format!("{} cells", units.len());
        let hint = "state another line with the setting `unit_line`";
        return Err(Error::malformed(expected, found, hint));
    }
    let is_key = units
        .first()
        .is_some_and(|cell| !channel_name::is_unit(cell));
    for (column, unit) in columns.iter_mut().zip(units).skip(usize::from(is_key)) {
        *column = std::mem::take(column).with_unit(unit, "units row");
    }
    Ok(())
}

/// Returns the number of cells, empty ones at the end left out.
fn filled_cells(row: &ByteRecord) -> usize {
    (0..row.len())
        .rfind(|index| !row[*index].trim_ascii().is_empty())
        .map_or(0, |index| index + 1)
}

fn text_of(row: &ByteRecord, index: usize) -> String {
    String::from_utf8_lossy(row.get(index).unwrap_or_default()).into_owned()
}

fn line_of(text: &[u8], row: &ByteRecord) -> Place {
    Place::default().line(records::line_of(text, row))
}
