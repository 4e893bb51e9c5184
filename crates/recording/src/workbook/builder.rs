//! From cells to a table of text: what a cell holds, as it stands in a text table.

use super::number_format::NumberFormat;
use super::{MEND, SheetPass};
use crate::calendar;
use crate::csv::{Sheet, SheetMarks, column_letters};
use crate::error::{Error, Place};
use crate::{Finding, Limits, remarks};
use std::ops::Range;
use std::sync::Arc;

/// What a cell holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Value<'a> {
    Number(f64),
    Text(&'a str),
    Bool(bool),
    /// A value of which the program that stored it says why it is none: `#N/A`.
    Fault(&'a str),
    /// A formula whose result is not stored.
    NotComputed,
}

/// How dates count days.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Epoch {
    /// From 1900, with a 29th of February in that year, as Lotus had it.
    Of1900,
    /// From 1904.
    Of1904,
}

/// A sheet while its cells come, row by row.
pub(super) struct SheetBuilder<'a> {
    limits: &'a Limits,
    pass: SheetPass,
    /// Bytes of texts in which fault words were looked for.
    heard: u64,
    epoch: Epoch,
    /// The rows so far, each without the empty cells at its end.
    text: String,
    /// Cells of each row.
    cells: Vec<u32>,
    /// What is known of each column.
    columns: Vec<ColumnCells>,
    pub(super) marks: SheetMarks,
    pub(super) notes: Vec<(u64, String)>,
    /// Whether a cell holds the result of a formula.
    pub(super) has_formulas: bool,
    /// Headers and footers of its pages.
    page_words: Vec<String>,
    /// Rows that are hidden, counted from 1.
    pub(super) hidden_rows: Vec<Range<u64>>,
}

/// The cells of a column.
#[derive(Debug, Clone, Default)]
struct ColumnCells {
    count: u32,
    /// The line of the first, and what it says if that is words.
    line: u64,
    words: String,
}

impl<'a> SheetBuilder<'a> {
    pub(super) fn new(epoch: Epoch, pass: SheetPass, limits: &'a Limits) -> Self {
        Self {
            limits,
            pass,
            heard: 0,
            epoch,
            text: String::new(),
            cells: vec![0],
            columns: Vec::new(),
            marks: SheetMarks::default(),
            notes: Vec::new(),
            has_formulas: false,
            page_words: Vec::new(),
            hidden_rows: Vec::new(),
        }
    }

    /// Tells whether what a probe looks for is found.
    pub(super) fn is_probed(&self) -> bool {
        self.pass == SheetPass::Probe && !self.text.is_empty()
    }

    /// Takes all columns for hidden, since those of which the sheet says nothing are.
    pub(super) fn hide_all_columns(&mut self) {
        self.marks.hidden_columns.push(0..usize::MAX);
    }

    /// Takes all rows for hidden, since those of which the sheet says nothing are.
    pub(super) fn hide_all_rows(&mut self) {
        self.hidden_rows.push(1..u64::MAX);
    }

    /// Takes in a header or footer of its pages, `&C&"Arial"&12words`.
    pub(super) fn put_page_words(&mut self, code: &str) {
        let mut words = String::new();
        let mut letters = code.chars().peekable();
        while let Some(letter) = letters.next() {
            if letter != '&' {
                words.push(letter);
                continue;
            }
            match letters.next() {
                Some('&') => words.push('&'),
                Some('"') => letters.by_ref().take_while(|c| *c != '"').for_each(drop),
                // A colour.
                Some('K') => letters.by_ref().take(6).for_each(drop),
                Some('0'..='9') => while letters.next_if(char::is_ascii_digit).is_some() {},
                _ => words.push(' '),
            }
        }
        self.page_words.push(words);
    }

    /// Keeps a text that holds a fault word.
    fn hear(&mut self, row: u32, value: Value<'_>) -> Result<(), Error> {
        let Value::Text(text) = value else {
            return Ok(());
        };
        self.heard += text.len() as u64;
        if self.heard > self.limits.text_bytes {
            let excess = "more bytes of text in a sheet that is not judged";
            return Err(self.limits.over("text_bytes", excess));
        }
        if remarks::has_fault(text) {
            self.notes.push((u64::from(row) + 1, text.to_string()));
        }
        Ok(())
    }

    /// Takes in a cell; row and column are counted from 0.
    pub(super) fn put(
        &mut self,
        row: u32,
        column: u32,
        value: Value<'_>,
        format: NumberFormat,
    ) -> Result<(), Error> {
        if matches!(value, Value::Text(text) if text.trim().is_empty()) {
            return Ok(());
        }
        if self.pass == SheetPass::Words {
            return self.hear(row, value);
        }
        let place = || place(row, column);
        if u64::from(column) >= self.limits.columns {
            return Err(self.limits.over("columns", "more columns").at(place()));
        }
        if u64::from(row) >= self.limits.lines {
            return Err(self.limits.over("lines", "more rows").at(place()));
        }
        let last = self.cells.len() - 1;
        if (row as usize) < last || (row as usize == last && column < self.cells[last]) {
            let misplaced_cell = format!("{} after a later cell", name_of(row, column));
            let expected = "cells in the order of rows and columns";
            return Err(Error::malformed(expected, misplaced_cell, MEND).at(place()));
        }
        for _ in last..row as usize {
            self.text.push('\n');
            self.cells.push(0);
        }
        let cells = &mut self.cells[row as usize];
        for _ in (*cells).max(1)..=column {
            self.text.push('\t');
        }
        *cells = column + 1;
        self.count(row, column as usize, value);
        if let (Value::Number(_), NumberFormat::Worded(words)) = (value, &format) {
            let cell = (column as usize, Arc::clone(words));
            self.marks.words_of_formats.insert(cell, u64::from(row) + 1);
        }
        self.write(value, format);
        if self.text.len() as u64 > self.limits.text_bytes {
            return Err(self
                .limits
                .over("text_bytes", "more bytes as text")
                .at(place()));
        }
        Ok(())
    }

    fn count(&mut self, row: u32, column: usize, value: Value<'_>) {
        if self.columns.len() <= column {
            self.columns.resize(column + 1, ColumnCells::default());
        }
        let cells = &mut self.columns[column];
        cells.count += 1;
        if let (1, Value::Text(words)) = (cells.count, value) {
            (cells.line, cells.words) = (u64::from(row) + 1, words.to_string());
        }
    }

    fn write(&mut self, value: Value<'_>, format: NumberFormat) {
        let text = &mut self.text;
        match (value, format) {
            (Value::Number(number), NumberFormat::Plain | NumberFormat::Worded(_)) => {
                text.push_str(&digits(number))
            }
            // What a person sees in such a cell is another number than the one that is stored.
            (Value::Number(number), NumberFormat::Other) => {
                text.push_str(&format!("{number} (its format shows another number)"));
            }
            (
                Value::Number(days),
                NumberFormat::Date {
                    has_time,
                    is_elapsed,
                },
            ) => {
                let stamp = stamp(days, self.epoch, has_time, is_elapsed);
                let stamp = stamp.unwrap_or_else(|| format!("{days} (its format shows no date)"));
                text.push_str(&stamp);
            }
            (Value::Text(cell), _) => {
                // Quotes would hold cells together, tabs and line ends take them apart.
                let mark = |c: char| match c {
                    '"' => '\'',
                    c if c.is_control() => ' ',
                    c => c,
                };
                text.extend(cell.trim().chars().map(mark));
            }
            (Value::Bool(is_true), _) => text.push_str(if is_true { "TRUE" } else { "FALSE" }),
            (Value::Fault(fault), _) => {
                text.push_str("error ");
                text.extend(fault.chars().filter(|c| !c.is_control()));
            }
            (Value::NotComputed, _) => text.push_str("formula without a stored value"),
        }
    }

    /// Returns the table; `name` is that of the sheet.
    pub(super) fn finish(self, name: &str) -> Result<Sheet, Error> {
        let width = self.cells.iter().copied().max().unwrap_or(0) as usize;
        let mut text = Vec::with_capacity(self.text.len() + self.cells.len());
        for (line, cells) in self.text.split('\n').zip(&self.cells) {
            text.extend_from_slice(line.as_bytes());
            if *cells > 0 {
                text.resize(text.len() + width - (*cells as usize).max(1), b'\t');
            }
            text.push(b'\n');
            if text.len() as u64 > self.limits.text_bytes {
                return Err(self.limits.over("text_bytes", "more bytes as text"));
            }
        }
        let mut hidden = Vec::new();
        let column = |one: &Range<usize>| match one.len() {
            1 => column_letters(one.start),
            _ => format!(
                "{} to {}",
                column_letters(one.start),
                column_letters(one.end - 1)
            ),
        };
        let columns = self.marks.hidden_columns.iter();
        let columns = columns.filter(|one| one.start < width);
        let columns: Vec<String> = columns
            .map(|one| column(&(one.start..one.end.min(width))))
            .collect();
        if !columns.is_empty() {
            hidden.push(format!("columns {}", listed(&columns)));
        }
        let rows = self
            .hidden_rows
            .iter()
            .filter(|one| one.start <= self.cells.len() as u64);
        let last = |one: &Range<u64>| (one.end - 1).min(self.cells.len() as u64);
        let row = |one: &Range<u64>| match last(one) == one.start {
            true => one.start.to_string(),
            false => format!("{} to {}", one.start, last(one)),
        };
        let rows: Vec<String> = rows.map(row).collect();
        if !rows.is_empty() {
            hidden.push(format!("rows {}", listed(&rows)));
        }
        let finding = (!hidden.is_empty()).then(|| {
            let text = format!(
                "the sheet `{name}` hides {}. They were read all the same. Look at the sheet",
                hidden.join(" and ")
            );
            Finding::warning("hidden-cells", text)
        });
        // Words that stand alone in a column beside others are written to a person.
        let alone = self
            .columns
            .into_iter()
            .filter(|one| one.count == 1 && width > 1);
        let words = alone.map(|one| (one.line, one.words));
        let mut notes = self.notes;
        notes.extend(words.filter(|(_, words)| !words.is_empty()));
        let teller = || {
            let name = crate::text::shown(name);
            format!("a page header or footer of the sheet `{name}` says")
        };
        let page_words = self.page_words.into_iter().map(|words| (teller(), words));
        Ok(Sheet {
            name: name.to_string(),
            text,
            width,
            marks: self.marks,
            notes,
            beside: page_words.collect(),
            findings: finding.into_iter().collect(),
        })
    }
}

/// Lists the first of several texts.
fn listed(all: &[String]) -> String {
    const SHOWN: usize = 4;
    let first = all[..all.len().min(SHOWN)].join(", ");
    match all.len() > SHOWN {
        true => format!("{first} and others"),
        false => first,
    }
}

/// Returns the place of a cell, row and column counted from 0.
pub(super) fn place(row: u32, column: u32) -> Place {
    Place::default()
        .line(u64::from(row) + 1)
        .column(u64::from(column) + 1)
}

/// Returns what a spreadsheet calls a cell, `B7`.
fn name_of(row: u32, column: u32) -> String {
    format!("{}{}", column_letters(column as usize), u64::from(row) + 1)
}

/// Returns the shortest digits that read back as the same number. The mark of a number is a decimal one,
/// and so must it look: `1.234` could be a thousand.
fn digits(number: f64) -> String {
    let size = number.abs();
    let plain = number.to_string();
    let is_long = size >= 1e16 || (size < 1e-5 && size > 0.0);
    let looks_like_thousands = plain.split_once('.').is_some_and(|(whole, decimals)| {
        decimals.len() == 3 && whole.trim_start_matches('-') != "0"
    });
    match is_long || looks_like_thousands {
        true => format!("{number:e}"),
        false => plain,
    }
}

/// Seconds of a day.
const DAY_S: u64 = 86_400;

/// Days from 1970 to the first one of each epoch, from March 1900 on.
const EPOCH_1900: i64 = -25_569;
const EPOCH_1904: i64 = -24_107;

/// Writes days as date and time of day, or as hours, minutes and seconds, with no more digits than the
/// number holds; `None` if no calendar has the day.
fn stamp(days: f64, epoch: Epoch, has_time: bool, is_elapsed: bool) -> Option<String> {
    /// Days up to the end of the year 9999.
    const LAST: f64 = 2_958_466.0;
    let size = Some(days.abs()).filter(|size| *size < LAST)?;
    // The distance to the next number is what a clock that was stored like this can tell apart.
    let resolution_s = (size.next_up() - size) * DAY_S as f64;
    let decimals = (1..=9_usize)
        .rev()
        .find(|decimals| {
            format!("1e-{decimals}")
                .parse()
                .is_ok_and(|last: f64| last >= resolution_s)
        })
        .unwrap_or(0);
    let parts = 10_u64.pow(u32::try_from(decimals).unwrap_or(0));
    let of_day = ((size - size.floor()) * DAY_S as f64 * parts as f64).round() as u64;
    let day = size.floor() as u64 + of_day / (DAY_S * parts);
    let of_day = of_day % (DAY_S * parts);
    let clock = |hours_before: u64| {
        let (seconds, part) = (of_day / parts, of_day % parts);
        let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
        let decimals = match decimals {
            0 => String::new(),
            width => format!(".{part:0width$}"),
        };
        format!(
            "{:02}:{minutes:02}:{seconds:02}{decimals}",
            hours_before + hours
        )
    };
    if is_elapsed || day == 0 || days < 0.0 {
        let sign = if days < 0.0 { "-" } else { "" };
        return Some(format!("{sign}{}", clock(24 * day)));
    }
    let day = i64::try_from(day).ok()?;
    let since_1970 = match epoch {
        Epoch::Of1904 => day + EPOCH_1904,
        // The 60th day is one that never was.
        Epoch::Of1900 if day == 60 => return None,
        Epoch::Of1900 => day + EPOCH_1900 + i64::from(day < 60),
    };
    let date = calendar::day(since_1970);
    Some(match !has_time && of_day == 0 {
        true => date,
        false => format!("{date} {}", clock(0)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dates as openpyxl reads them.
    #[test]
    fn val_days_are_the_dates_of_openpyxl() {
        let cases = [
            (1.0, Epoch::Of1900, "1900-01-01"),
            (59.0, Epoch::Of1900, "1900-02-28"),
            (61.0, Epoch::Of1900, "1900-03-01"),
            (45_413.0, Epoch::Of1900, "2024-05-01"),
            (45_413.5, Epoch::Of1900, "2024-05-01 12:00:00.000000"),
            (43_951.0, Epoch::Of1904, "2024-05-01"),
            (0.5, Epoch::Of1904, "12:00:00.000000000"),
            (1e-4 / 86_400.0, Epoch::Of1900, "00:00:00.000100000"),
            (-0.05 / 86_400.0, Epoch::Of1900, "-00:00:00.050000000"),
        ];
        for (days, epoch, text) in cases {
            assert_eq!(stamp(days, epoch, false, false).as_deref(), Some(text));
        }
        assert_eq!(
            stamp(1.5, Epoch::Of1900, true, true).as_deref(),
            Some("36:00:00.000000000")
        );
        for days in [60.0, 3e6, f64::NAN] {
            assert_eq!(stamp(days, Epoch::Of1900, false, false), None, "{days}");
        }
    }

    #[test]
    fn verif_digits_read_back_and_show_no_thousands() {
        for (number, text) in [
            (1.234, "1.234e0"),
            (-12.5, "-12.5"),
            (0.125, "0.125"),
            (1e-7, "1e-7"),
            (7292.0, "7292"),
        ] {
            assert_eq!(digits(number), text);
            assert_eq!(text.parse(), Ok(number));
        }
    }
}
