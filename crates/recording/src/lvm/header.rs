//! The two headers of a LabVIEW measurement file.

use crate::channel_name::ChannelName;
use crate::error::{Error, ErrorKind, Place};
use crate::held::Statement;
use crate::number::Decimal;
use crate::remarks::{self, Remark, RemarkPlace};
use crate::words::{Words, word_list};
use crate::{Finding, Limits, TestFacts, fact, joined_facts, text};
use latchgate_kernel::units::TimeUnit;
use std::collections::BTreeMap;

/// Line that closes each header.
const END: &str = "***End_of_Header***";

/// Separators of cells.
const SEPARATORS: [char; 3] = ['\t', ',', ';'];

/// Keys of both headers whose values are not the operator's words.
static KEYS: Words = word_list!("lvm-keys");

/// Position of the times of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeColumns {
    /// None: start and interval are in the header.
    No,
    /// The first column, for all channels.
    One,
    /// A column before each channel.
    Multi,
}

/// Description of a channel in the second header.
#[derive(Debug)]
pub(super) struct ChannelDescription {
    /// Column of the table, counted from 0.
    pub(super) index: usize,
    pub(super) column: ChannelName,
    /// Number of samples as printed.
    pub(super) samples: Option<String>,
    /// Time of the first sample as printed, where there is no time column.
    pub(super) start: f64,
    /// Interval as printed.
    pub(super) interval: Option<String>,
    /// Name that the header gives to the unit of both and of stamps.
    pub(super) time_label: Option<String>,
    /// The unit of both and of stamps.
    pub(super) time_unit: TimeUnit,
}

impl ChannelDescription {
    /// True if a requested name means this channel: its name, with or without unit, or its number, counted
    /// from 1.
    pub(super) fn answers_to(&self, requested: &str, index: usize) -> bool {
        let requested = requested.trim();
        self.column.name == requested
            || (!self.column.label.trim().is_empty() && self.column.label.trim() == requested)
            || requested.parse() == Ok(index + 1)
    }
}

/// Both headers.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) separator: char,
    pub(super) time: TimeColumns,
    pub(super) channels: Vec<ChannelDescription>,
    /// Column of the Comment, counted from 0; beyond the last one if there is none.
    pub(super) comment_column: usize,
    /// Words of the operator.
    pub(super) remarks: Vec<Remark>,
    /// Facts of the test in the first header.
    pub(super) test: TestFacts,
    /// The decimal mark that the header declares.
    pub(super) decimal: Option<char>,
    /// Findings on entries that cannot be read.
    pub(super) findings: Vec<Finding>,
}

impl Header {
    /// Reads both headers; returns them with the line on which the table begins.
    pub(super) fn read(content: &str, limits: &Limits) -> Result<(Self, u64), Error> {
        let mut header = Self {
            separator: '\t',
            time: TimeColumns::One,
            channels: Vec::new(),
            comment_column: 0,
            remarks: Vec::new(),
            test: TestFacts::default(),
            decimal: None,
            findings: Vec::new(),
        };
        let mut lines = text::lines(content);
        let first = lines
            .by_ref()
            .take_while(|(_, line)| !line.starts_with(END));
        let mut closed = 0;
        let mut facts: BTreeMap<&str, String> = BTreeMap::new();
        for (number, line) in first {
            closed = number;
            let (key, value) = line.split_once(SEPARATORS).unwrap_or((line, ""));
            header
                .take(key.trim(), value, line)
                .map_err(|error| error.at(Place::default().line(number)))?;
            // Empty cells may follow the value.
            if let Some(value) = fact(value.trim_matches([' ', '\t', ',', ';'])) {
                facts.entry(key.trim()).or_insert(value);
            }
        }
        header.test = TestFacts {
            test: joined_facts([facts.remove("Project"), facts.remove("Description")]),
            // LabVIEW names only the person.
            laboratory: facts
                .remove("Operator")
                .map(|name| format!("operator {name}")),
            date: facts.remove("Date"),
            ..TestFacts::default()
        };
        let mut rows: Vec<(u64, Vec<String>)> = Vec::new();
        let (mut names, mut last, mut ended) = (None, closed, false);
        for (number, line) in lines {
            last = number;
            if line.starts_with(END) {
                // An empty line between the two headers does not end the second one.
                ended |= rows.iter().any(|(_, cells)| !cells[0].is_empty());
                continue;
            }
            let cells = line.split(header.separator);
            let cells: Vec<String> = cells.map(|cell| cell.trim().to_string()).collect();
            if cells.len() as u64 > limits.columns {
                let error = limits.over("columns", format!("{} cells on a line", cells.len()));
                return Err(error.at(Place::default().line(number)));
            }
            if cells[0] == "X_Value" || (ended && !line.trim().is_empty()) {
                names = Some((number, cells));
                break;
            }
            // A header is short; more lines than this are a table without headings.
            if rows.len() > 64 {
                break;
            }
            rows.push((number, cells));
        }
        let is_number = |cell: &String| text::header_number(cell).is_some();
        let (line, found_after) = match &names {
            Some((line, cells)) if cells.iter().any(is_number) => (*line, "a row of numbers"),
            Some((line, _)) => (*line, ""),
            None if ended => (last, "the end of the file"),
            None => (closed + 1, "no second header that is closed"),
        };
        let Some((_, names)) = names.filter(|_| found_after.is_empty()) else {
            return Err(Error::malformed(
                "a second header, and after it a line X_Value with the channels' names",
                found_after,
                "the file does not name its columns; write it again with headings, or read its \
                 rows as a table with the setting `input_format` = csv",
            )
            .at(Place::default().line(line)));
        };
        header
            .describe(&names, &rows)
            .map_err(|error| error.at(Place::default().line(line)))?;
        Ok((header, line + 1))
    }

    /// Sets the unit of times to the stated one, else to that of the header.
    pub(super) fn take_time_units(&mut self, stated: Option<TimeUnit>) -> Result<(), Error> {
        let mut overridden = None;
        for channel in &mut self.channels {
            // `Samples` is the label where no timing is attached.
            let counts = |label: &String| ChannelName::from_header(label, 1).says_index();
            channel.time_label = channel.time_label.take().filter(|label| !counts(label));
            let label = channel.time_label.as_deref();
            let label_unit = label.and_then(TimeUnit::from_spelling);
            channel.time_unit = match (stated, label_unit, label) {
                (Some(stated), ..) => stated,
                (None, Some(own), _) => own,
                (None, None, None) => TimeUnit::SECOND,
                (None, None, Some(label)) => {
                    let found = format!("X_Unit_Label `{}`", text::shown(label));
                    let hint = "state it with the setting `time_unit` = s|ms|us|ns";
                    return Err(Error::malformed("a unit of time", found, hint));
                }
            };
            if let Some(label) = label.filter(|_| label_unit != Some(channel.time_unit)) {
                overridden.get_or_insert_with(|| (label.to_string(), channel.time_unit));
            }
        }
        self.findings.extend(overridden.map(|(label, used_unit)| {
            let text = format!(
                "X_Unit_Label is `{}`, but the setting `time_unit` is `{}`. The setting was used. \
                 Check which is right",
                text::shown(&label),
                used_unit
            );
            Finding::warning("time-unit-overridden", text)
        }));
        Ok(())
    }

    /// True if a row of the table is the start of another header.
    pub(super) fn begins_again(cells: &[&str]) -> bool {
        let begins = |cell: &&str| {
            ["Channels", "X_Value", "LabVIEW Measurement"].contains(cell) || cell.starts_with(END)
        };
        cells.first().is_some_and(begins)
    }

    fn take(&mut self, key: &str, value: &str, line: &str) -> Result<(), Error> {
        let quoted = || format!("`{}`", text::shown(line));
        let unknown = |expected| Error::malformed(expected, quoted(), "export the file as CSV");
        match key {
            "Separator" => {
                let word = value.trim_matches([' ', '\t']);
                let name = word.trim_end_matches([' ', '\t', ',', ';']);
                self.separator = match if name.is_empty() { word } else { name } {
                    "Tab" | "" => '\t',
                    "Comma" => ',',
                    "Semicolon" => ';',
                    mark if mark.starts_with(',') => ',',
                    mark if mark.starts_with(';') => ';',
                    _ => return Err(unknown("Separator Tab, Comma or Semicolon")),
                };
            }
            "X_Columns" => {
                self.time = match value.trim_end_matches([' ', '\t', ',', ';']).trim() {
                    "No" => TimeColumns::No,
                    "One" => TimeColumns::One,
                    "Multi" => TimeColumns::Multi,
                    _ => return Err(unknown("X_Columns No, One or Multi")),
                };
            }
            "Decimal_Separator" => self.decimal = value.trim_start().chars().next(),
            _ => self.keep_words(key, value),
        }
        Ok(())
    }

    /// Keeps entries that are not the format's: notes, and lines of any other key, since a note may go on
    /// on the next line.
    fn keep_words(&mut self, key: &str, value: &str) {
        if KEYS.iter().any(|entry| entry.eq_ignore_ascii_case(key)) {
            return;
        }
        let (text, place) = match remarks::is_key(key) {
            true => (value.to_string(), RemarkPlace::Channel),
            false => (format!("{key} {value}"), RemarkPlace::Apart),
        };
        self.remarks
            .push(Remark::new(&text, place, "the file's header says"));
    }

    fn describe(&mut self, names: &[String], rows: &[(u64, Vec<String>)]) -> Result<(), Error> {
        let cell = |key: &str, index: usize| -> Option<String> {
            let (_, row) = rows.iter().find(|(_, cells)| cells[0] == key)?;
            row.get(index).filter(|cell| !cell.is_empty()).cloned()
        };
        for (_, cells) in rows {
            self.keep_words(&cells[0], &cells[1..].join(" "));
        }
        let comment = names.iter().rposition(|name| name == "Comment");
        let filled = names.iter().rposition(|name| !name.is_empty()).unwrap_or(0);
        self.comment_column = comment.unwrap_or(filled + 1);
        let columns = self.comment_column;
        let is_multi = self.time == TimeColumns::Multi;
        for index in (1..columns).step_by(if is_multi { 2 } else { 1 }) {
            let mut column = ChannelName::from_header(&names[index], index);
            if let Some(unit) = cell("Y_Unit_Label", index) {
                column = column.with_unit(&unit, "header");
            }
            let start_text = cell("X0", index).unwrap_or_else(|| "0".into());
            let Some(start) = text::header_number(&start_text) else {
                let found = format!("`{}`", text::shown(&start_text));
                return Err(Error::malformed(
                    "X0 as a number",
                    found,
                    "correct the header",
                ));
            };
            self.channels.push(ChannelDescription {
                index,
                column,
                samples: cell("Samples", index),
                start,
                interval: cell("Delta_X", index),
                // One clock serves all channels.
                time_label: cell("X_Unit_Label", index).or_else(|| cell("X_Unit_Label", 1)),
                time_unit: TimeUnit::SECOND,
            });
        }
        let mut dimensions = (1..columns).filter_map(|index| cell("X_Dimension", index));
        if let Some(dimension) =
            dimensions.find(|dimension| !dimension.eq_ignore_ascii_case("Time"))
        {
            let found = format!("`{}`", text::shown(&dimension));
            let hint = "export a signal over time";
            return Err(Error::malformed("X_Dimension Time", found, hint));
        }
        let (key, text) = ("Channels", cell("Channels", 1));
        let stated = text.and_then(|text| {
            let text = &*text;
            Statement { key, text }.number(|_| true, &mut self.findings)
        });
        let count = self.channels.len();
        if let Some(stated) = stated.filter(|stated| stated.total_cmp(&(count as f64)).is_ne()) {
            let expected = format!("{stated} channel names, as the header states");
            let hint = "correct the names in the header";
            return Err(Error::malformed(expected, count.to_string(), hint));
        }
        if count == 0 {
            let names = "no channel".into();
            return Err(ErrorKind::NoChannel { known: names }.into());
        }
        Ok(())
    }

    /// Returns the finding on the numbers' decimal mark, where it is a comma or not the declared one.
    pub(super) fn decimal_finding(&self, used: Decimal) -> Option<Finding> {
        let mark = match used {
            Decimal::Comma => ',',
            Decimal::Point | Decimal::PointOnly | Decimal::Stated(_) => '.',
            Decimal::Unknown => return None,
        };
        match self.decimal {
            Some(stated) if stated != mark => Some(Finding::warning(
                "decimal-contradicted",
                format!(
                    "the header states the decimal mark `{stated}`, but the numbers have `{mark}`. \
                     Check the values"
                ),
            )),
            _ if mark == ',' => Some(Finding::info(
                "decimal-comma",
                "the numbers have a decimal comma",
            )),
            _ => None,
        }
    }
}
