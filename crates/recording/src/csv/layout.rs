//! Layouts: which rows are header, which column is time, which one is the lateral acceleration.
//!
//! The first rows answer one question after the other: where the header ends, what its columns are
//! called, which holds the time, which the samples. Each answer needs the one before.

use super::begin::{self, Begin};
use super::dialect::{LineScan, Separator};
use super::preamble::Preamble;
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

/// Rows and bytes from which on fewer rows do: rows may be long.
const FEW_ROWS: usize = 8;
const SAMPLE_BYTES: usize = 4 << 20;

/// Data rows from which the meaning of an unnamed first column is found.
const SAMPLE_ROWS: usize = 64;

/// Where the time of the samples comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TimeSource {
    /// A column.
    Column {
        /// Its index, counted from 0.
        index: usize,
        /// The unit of its stamps.
        unit: TimeUnit,
        /// What states that unit.
        origin: UnitOrigin,
        /// True if its stamps are words, such as dates and times of day.
        worded: bool,
    },
    /// A stated rate.
    Rate(SampleRate),
}

/// What states the unit of a column of times.
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

/// The columns to read, and what is to be said about the choice.
#[derive(Debug, Default)]
pub(super) struct ColumnChoice {
    /// Indices, counted from 0.
    pub(super) columns: Vec<usize>,
    pub(super) findings: Vec<Finding>,
}

/// How a text table or a sheet was understood: what a person can see and correct.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableMapping {
    /// The sheet of a workbook.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sheet: Option<String>,
    /// What separates the cells of a row: `tab`, `semicolon`, `comma`, `blanks`, `nothing` or `the sheet`.
    pub separator: Cow<'static, str>,
    /// The decimal mark, `.` or `,`; `None` where no number of the first rows has one.
    pub decimal: Option<Cow<'static, str>>,
    /// What the first rows above the names say, each as key and values.
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

/// How a table is laid out.
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
    /// True if they are stamps as words, and whether such with a date.
    pub(super) worded: Vec<bool>,
    pub(super) dated: Vec<bool>,
    /// The usual step of columns of numbers that rise steadily over the first rows.
    pub(super) steps: Vec<Option<f64>>,
    /// True if a header names the columns.
    pub(super) named: bool,
    /// What stands above the names.
    pub(super) preamble: Preamble,
}

/// What is known of a table before its layout is.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableStart<'a> {
    pub(super) separator: Separator,
    /// The line of the names, where it was found below a preamble.
    pub(super) found: Option<u32>,
    pub(super) lines: &'a LineScan,
}

impl TableLayout {
    /// Finds the layout from the first rows.
    pub(super) fn find(text: &[u8], start: TableStart<'_>, asked: ReadTask) -> Result<Self, Error> {
        let (options, separator) = (asked.options, start.separator);
        let quoted = memchr::memchr(b'"', text).is_some();
        let rows = first_rows(Records::new(text, separator, quoted, asked.limits))?;
        let header_line = options.header_line.or(start.found);
        let stated = header_line.is_some() || options.skip_lines.is_some();
        if !stated {
            let step_of = |index: usize| usual_step(&rows, index);
            unnamed::refusal(text, &rows, options, step_of).map_or(Ok(()), Err)?;
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
            true => name_columns(header, first, options.unit_line.is_none()).map_err(|found| {
                let found = format!("{found} header cells over rows of {}", first.len());
                let expected = "as many header cells as the rows have";
                where_it_begins(text, &rows[0], expected, &found)
            })?,
        };
        let shape = (separator, columns.len());
        let preamble = Preamble::read(start.lines, shape, start.found);
        preamble.apply(&mut columns, options.unit_line.is_none());
        if let Some(line) = options.unit_line {
            let units = unit_cells(text, start, header, line)?;
            take_units(&mut columns, &units)
                .map_err(|error| error.at(Place::default().line(u64::from(line))))?;
        }
        channel_name::mark_columns(columns.iter_mut().collect(), options);
        let ragged = data.iter().any(|row| row.len() != first.len());
        let data_line = line_of(text, first).line.unwrap_or(0);
        if !stated && ragged && begin::find(text).is_some_and(|found| found.data > data_line) {
            let found = "rows of different lengths";
            return Err(where_it_begins(text, first, "rows of one length", found));
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

    /// Says how the table was understood.
    pub(super) fn mapping(&self, text: &[u8], asked: ReadTask) -> Result<TableMapping, Error> {
        let options = asked.options;
        let rows = Records::new(text, self.separator, self.quoted, asked.limits);
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
        let seen = || marks.into_iter().find(has);
        let units = header.iter().skip(1).find(|row| has_unit(row));
        Ok(TableMapping {
            sheet: None,
            separator: self.separator.name().into(),
            decimal: options.decimal.or_else(seen).map(|mark| mark.name().into()),
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

    /// Returns the number of columns, and that of the cells of each row.
    pub(super) fn widths(&self) -> (usize, usize) {
        (self.columns.len(), self.cells)
    }

    /// Returns the columns that count the rows and are not read for anything else: those whose
    /// names say so, and without stamps also those whose numbers do; each with whether its name
    /// says so.
    pub(super) fn counters(&self, time: &TimeSource, wanted: &[usize]) -> Vec<(usize, bool)> {
        const MOST: usize = 8;
        let stamped = time.column();
        let free = |index: &usize| {
            Some(*index) != stamped
                && !wanted.contains(index)
                && self.numeric[*index]
                && self.columns[*index].unit_text.is_none()
        };
        let all = (0..self.columns.len()).filter(free);
        let mut all: Vec<_> = all.map(|index| (index, self.is_index(index))).collect();
        all.retain(|(_, named)| *named || stamped.is_none());
        all.sort_by_key(|(_, named)| !named);
        all.truncate(MOST);
        all
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
        if let Some(wanted) = &options.channel {
            let index = self.find_column(wanted, "channel")?;
            if Some(index) == time {
                return Err(Error::malformed(
                    "a channel of acceleration",
                    format!("the time column `{}`", self.columns[index].name),
                    "choose another column, or state the time column with the setting \
                     `time_column` = NAME",
                ));
            }
            let findings = self.columns[index].not_lateral_finding().into_iter();
            let findings = findings.chain(self.by_name_finding(wanted, index));
            return Ok(ColumnChoice {
                columns: vec![index],
                findings: findings.filter(|_| self.named).collect(),
            });
        }
        // One that says that it is the one, or alone could be, is read though its first cells are
        // faults: reading it says what is wrong, and where.
        let is_clock = |i: usize| Some(i) == time || self.is_other_clock(i);
        let others = (0..self.columns.len()).filter(|i| !is_clock(*i) && !self.is_index(*i));
        let alone = others.clone().count() == 1;
        let meant = others
            .filter(|i| alone || self.numeric[*i] || self.columns[*i].says_lateral_acceleration());
        let meant: Vec<usize> = meant.collect();
        let columns = meant.iter().map(|index| (index + 1, &self.columns[*index]));
        let choices = ChannelOffer::of_words(&columns.collect::<Vec<_>>(), "column");
        let (index, finding) = lateral::take(&choices, self.list(0..self.columns.len()))?;
        Ok(ColumnChoice {
            columns: vec![meant[index]],
            // What an unnamed column is called says nothing.
            findings: finding.into_iter().filter(|_| self.named).collect(),
        })
    }

    /// Finds a column by its name (as it stands, then without unit, then whatever its case) or
    /// by its number, counted from 1.
    pub(super) fn find_column(&self, wanted: &str, what: &'static str) -> Result<usize, Error> {
        let small = wanted.trim().to_lowercase();
        let ways: [&dyn Fn(&ChannelName) -> bool; 4] = [
            &|column| column.name == wanted,
            &|column| !column.label.is_empty() && column.label == wanted.trim(),
            &|column| {
                column.name.to_lowercase() == small
                    || (!small.is_empty() && column.label.to_lowercase() == small)
            },
            &|column| column.is_described_as(&small),
        ];
        let all = 0..self.columns.len();
        for way in ways {
            let found: Vec<usize> = all.clone().filter(|i| way(&self.columns[*i])).collect();
            match found.as_slice() {
                [] => {}
                [only] => return Ok(*only),
                several => {
                    let expected = format!("one column `{wanted}`");
                    let found = self.list(several.iter().copied());
                    return Err(Error::malformed(expected, found, "choose it by number"));
                }
            }
        }
        if let Ok(number) = wanted.trim().parse::<usize>()
            && (1..=self.columns.len()).contains(&number)
        {
            return Ok(number - 1);
        }
        let (known, wanted) = (self.list(all), wanted.to_string());
        if what == "channel" {
            return Err(ErrorKind::NoSuchChannel {
                requested: wanted,
                known,
            }
            .into());
        }
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        Err(Error::from(ErrorKind::UnknownName {
            what,
            nearest: crate::error::nearest_name(&wanted, &names),
            found: wanted,
            known,
        }))
    }

    /// Says that a number which a person states is the name of another column than the one of that
    /// number.
    pub(super) fn by_name_finding(&self, wanted: &str, index: usize) -> Option<Finding> {
        let number: usize = wanted.trim().parse().ok()?;
        let other = self.columns.get(number.checked_sub(1)?)?;
        let text = format!(
            "`{number}` is the name of column {}, which was used. Column number {number} is named \
             `{}`. State the name of the one you mean",
            index + 1,
            shown(&other.name)
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
        let one = |index: usize| {
            let name = shown(&self.columns[index].name);
            let same = |other: &&ChannelName| other.name == self.columns[index].name;
            match self.columns.iter().filter(same).count() {
                1 => Candidate::named(name),
                _ => Candidate::numbered(name, "column", index + 1),
            }
        };
        Candidates(indices.into_iter().map(one).collect()).to_string()
    }
}

/// Tells of each column whether at least half of its first cells are such.
fn mostly(columns: &[ChannelName], data: &[ByteRecord], such: fn(&[u8]) -> bool) -> Vec<bool> {
    let is_mostly = |index: usize| {
        let cells = data.iter().filter(|row| row.get(index).is_some_and(such));
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
    // A unit of time beside a number, such as `10 us`, is none of another column.
    let counted = |text: &str| text.contains(|c: char| c.is_ascii_digit());
    let of_time = |text: &str| counted(text) && TimeUnit::from_spelling(text).is_some();
    row.iter().any(|cell| {
        let text = String::from_utf8_lossy(cell);
        is_known_unit(&text) || of_time(&text)
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

/// Counts the rows before the data where a person states the line of the names: these, and what
/// stands between them and the first number.
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
        Err(where_it_begins(text, row, expected, &found))
    };
    let Some(names) = rows.first() else {
        return Err(no_rows("the file holds no rows"));
    };
    if has_number(names) {
        // No row of samples stands above one of units: `x-axis,1,2` over `second,Volt,Volt`.
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
        let cells: Vec<String> = cells.collect();
        let expected = "a line that names the columns";
        return Err(where_it_begins(text, names, expected, &cells.join(" and ")));
    }
    match &rows[1..] {
        [row, ..] if has_number(row) => Ok(1),
        [units, row, ..] if has_unit(units) && has_number(row) => Ok(2),
        [units, row, ..] if has_unit(units) => words(row, "numbers after names and units"),
        [row, ..] if !has_unit(row) => words(row, "numbers or a row of units after the header"),
        _ => Err(no_rows("the file holds a header and no rows")),
    }
}

/// Says that it is not clear where the table begins, and with which setting it would be.
fn where_it_begins(text: &[u8], row: &ByteRecord, expected: &str, found: &str) -> Error {
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
    // Of further rows only one of units is read; descriptions are passed over.
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

/// Returns the cells of the line that a person states to hold the units.
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
