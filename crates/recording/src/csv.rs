//! Text tables: CSV and its relatives.
//!
//! A table is read in three steps: its bytes become UTF-8 text (`encoding`), its separator,
//! comments and line lengths are found and checked (`dialect`), and its header says what the
//! columns hold (`channel_name` of all readers). Only then are the rows read, the needed columns alone.
//!
//! What the file does not state is requested, not guessed: a missing unit or time is an error,
//! and so is a header that does not fit its rows. Units never come from a comment.
//!
//! - `begin`: where a table begins, and what separates its cells;
//! - `clock`: clocks: which column holds the time, and in which unit;
//! - `clocks_beside`: other clocks of the table, compared with the one that is used;
//! - `counter`: columns that count the rows: without stamps they alone show a missing row;
//! - `ends`: the line on which a table seems to end, if a line after it stops the reading;
//! - `layout`: layouts: the rows of the header, the column of time, the one of the lateral
//!   acceleration;
//! - `long_table`: refusal of several channels below one another in one column;
//! - `preamble`: preambles: rows above the names that describe the columns;
//! - `marks`: marks of a workbook's sheet besides its cells: hidden columns, merged cells;
//! - `records`: rows as cells, by the table reader of the `csv` crate;
//! - `rows`: rows: the stamps and the samples of the selected columns;
//! - `stamp`: stamps as words: dates, times of day, lengths of time, numbers with their unit;
//! - `status`: words on the samples: comment lines, and columns that hold the state of a channel
//!   or notes row by row;
//! - `unnamed`: tables of numbers without names: one message names everything that is missing.

mod begin;
mod clock;
mod clocks_beside;
mod counter;
mod dialect;
mod ends;
mod layout;
mod long_table;
mod marks;
mod preamble;
mod records;
mod rows;
pub mod stamp;
mod status;
mod unnamed;

use super::draft::{self, Draft, UniformSamples, Unit};
use super::held;
use super::source::Reader;
use super::time_base::{self, MEND, TimeBase, brief};
use super::{Finding, Head, Outcomes, ReadOptions, ReadOutcome, ReadTask, Selection};
use crate::channel_name::ChannelName;
use crate::channel_name::gravity::says_gravity;
use crate::error::{Error, Place};
use crate::remarks::{self, Remark, RemarkPlace};
use crate::setting::Setting;
use latchgate_kernel::units::{AccelerationUnit, SampleRate, TimeUnit};
pub use layout::TableMapping;
use layout::{Counter, TableLayout, TableStart, TimeSource, UnitOrigin};
pub(crate) use marks::{Merged, Sheet, SheetMarks, column_letters};
use preamble::TableFacts;
pub(crate) use preamble::rates_under_name;
use rows::{ColumnResult, Rows, SelectedColumns};
use status::TableWords;
pub(crate) use status::says_bad;

/// True if the head looks like text.
pub fn recognises(head: &Head<'_>) -> bool {
    !head.is_folder && super::encoding::looks_like_text(head.bytes)
}

/// True if the head of a text shows two rows of a table, with numbers in them.
pub(super) fn looks_like_table(head: &[u8]) -> bool {
    begin::has_rows(head)
}

/// Reads a text table.
///
/// # Errors
///
/// - [`ErrorKind::Empty`] without a data row,
/// - [`ErrorKind::MissingTime`] and [`ErrorKind::MissingUnit`] where neither file nor options say,
/// - [`ErrorKind::NoSuchChannel`], [`ErrorKind::AmbiguousChannel`] or [`ErrorKind::NoChannel`]
///   where the channel is not clear,
/// - [`ErrorKind::Malformed`], [`NonFinite`](latchgate_kernel::error::Error::NonFinite), [`ErrorKind::RaggedRow`] or
///   [`ErrorKind::TimeNotIncreasing`] at the line and column of the first bad cell,
/// - [`ErrorKind::LimitExceeded`] where the file is larger than allowed.
pub fn read(source: &mut Reader, task: ReadTask) -> Result<Outcomes, Error> {
    let table = TableText::open(source.read_text(task.limits)?, task)?;
    Ok(task.each(|selection| table.outcome(selection)))
}

/// Reads the table of a sheet, by the same rules.
///
/// # Errors
///
/// As [`read`].
pub(crate) fn read_sheet(sheet: Sheet, task: ReadTask) -> Result<Outcomes, Error> {
    let table = TableText::of_sheet(sheet, task)?;
    Ok(task.each(|selection| table.outcome(selection)))
}

/// Returns the mapping of the table of a sheet.
///
/// # Errors
///
/// As [`read`].
pub(crate) fn mapping_of_sheet(sheet: Sheet, task: ReadTask) -> Result<TableMapping, Error> {
    TableText::of_sheet(sheet, task)?.mapping()
}

/// Returns the mapping of a text table. Where a setting is missing, it is a guess for a person to
/// correct.
///
/// # Errors
///
/// As [`read`], where nothing like a table is found.
pub fn mapping(source: &mut Reader, task: ReadTask) -> Result<TableMapping, Error> {
    let bytes = source.read_text(task.limits)?;
    let head = bytes[..bytes.len().min(begin::LOOKED_AT)].to_vec();
    let mapping = TableText::open(bytes, task).and_then(|table| table.mapping());
    mapping.or_else(|error| {
        let (text, _) = super::encoding::decode(head, task.limits)?;
        let begin = begin::find(&text).ok_or(error)?;
        let decimal = task.options.decimal;
        Ok(TableMapping {
            sheet: None,
            separator: begin::find_separator(&text, decimal).name().into(),
            decimal: decimal.map(|mark| mark.name().into()),
            above: Vec::new(),
            header_line: begin.header,
            unit_line: None,
            data_line: Some(begin.data),
            time_column: None,
            time_unit: None,
        })
    })
}

/// A table with its layout, whose rows are not read yet.
struct TableText<'a> {
    text: Vec<u8>,
    lines: dialect::LineScan,
    layout: TableLayout,
    /// Findings so far.
    findings: Vec<Finding>,
    /// Name of the sheet; `None` for a text file.
    sheet: Option<String>,
    /// Marks of the sheet; none for a text file.
    marks: SheetMarks,
    /// Remarks of the workbook outside the sheet.
    workbook_remarks: Vec<Remark>,
    task: ReadTask<'a>,
}

impl<'a> TableText<'a> {
    fn open(bytes: Vec<u8>, task: ReadTask<'a>) -> Result<Self, Error> {
        let (text, findings) = super::encoding::decode(bytes, task.limits)?;
        Self::of_text(text, findings, None, task)
    }

    fn of_sheet(sheet: Sheet, task: ReadTask<'a>) -> Result<Self, Error> {
        let separator = match sheet.width > 1 {
            true => dialect::Separator::Tab,
            false => dialect::Separator::None,
        };
        let mut table = Self::of_text(sheet.text, sheet.findings, Some(separator), task)?;
        for (line, note) in &sheet.notes {
            table.lines.keep(*line, note.as_bytes());
        }
        // Text outside the sheet may be about another sheet, so it counts only if it has a fault word.
        let faults = sheet.beside.into_iter();
        let mut bytes_left = dialect::COMMENT_BYTES;
        for (source, text) in faults.filter(|(_, text)| remarks::has_fault(text)) {
            match bytes_left.checked_sub(text.len() + dialect::LINE_OVERHEAD) {
                Some(remaining) => bytes_left = remaining,
                None => {
                    table.lines.more_words = true;
                    break;
                }
            }
            let remark = Remark::new(&text, RemarkPlace::Apart, source);
            table.workbook_remarks.push(remark);
        }
        (table.sheet, table.marks) = (Some(sheet.name), sheet.marks);
        Ok(table)
    }

    /// Finds the layout of decoded text; `known_separator` is that of a sheet.
    fn of_text(
        mut text: Vec<u8>,
        mut findings: Vec<Finding>,
        known_separator: Option<dialect::Separator>,
        task: ReadTask<'a>,
    ) -> Result<Self, Error> {
        let options = task.options;
        let bounds = |header_line: Option<u32>| {
            let above = header_line.map(|line| line.saturating_sub(1));
            dialect::TableBounds {
                above: u64::from(above.or(options.skip_lines).unwrap_or(0)),
                named: above.is_some(),
                last: options.last_line.map_or(u64::MAX, u64::from),
            }
        };
        let stated_bounds = bounds(options.header_line);
        let mut lines = dialect::scan_lines(&mut text, stated_bounds, task.limits)?;
        let separator =
            known_separator.unwrap_or_else(|| begin::find_separator(&text, options.decimal));
        let is_stated = options.header_line.is_some() || options.skip_lines.is_some();
        let found_header = (!is_stated)
            .then(|| begin::below_preamble(&text, known_separator))
            .flatten();
        if found_header.is_some() {
            lines = dialect::scan_lines(&mut text, bounds(found_header), task.limits)?;
        }
        // The table reader takes a comment without a line end for an empty row.
        let last_start = memchr::memrchr(b'\n', &text).map_or(0, |end| end + 1);
        if text.get(last_start) == Some(&b'#') {
            text.push(b'\n');
        }
        if separator == dialect::Separator::Blanks {
            dialect::collapse_blanks(&mut text);
        }
        let start = TableStart {
            separator,
            found_header,
            lines: &lines,
        };
        let mut layout = TableLayout::find(&text, start, task)?;
        let used = if found_header.is_some() {
            bounds(found_header)
        } else {
            stated_bounds
        };
        if let Some(unit) = clock::take_unit_above(&mut lines.words, used.above) {
            layout.take_time_unit(&unit);
        }
        if text.last() != Some(&b'\n') {
            let start = memchr::memrchr(b'\n', &text).map_or(0, |end| end + 1);
            // A line without a number is not a row that was cut.
            let is_row = dialect::is_row(&text[start..])
                && begin::cells(&text[start..], separator)
                    .iter()
                    .any(|cell| cell.first().is_some_and(|byte| dialect::begins_row(*byte)));
            let decoded = std::str::from_utf8(&text).ok().filter(|_| is_row);
            let cut = decoded.and_then(held::cut_line);
            match cut {
                // The rest of a cut number is not a measured value.
                Some(_) => text.truncate(start),
                // The table reader would take an open quote for a closed one.
                None => text.push(b'\n'),
            }
            findings.extend(cut);
        }
        Ok(Self {
            text,
            lines,
            layout,
            findings,
            sheet: None,
            marks: SheetMarks::default(),
            workbook_remarks: Vec::new(),
            task,
        })
    }

    /// Returns the mapping of the table.
    fn mapping(&self) -> Result<TableMapping, Error> {
        let mut mapping = self.layout.mapping(&self.text, self.task)?;
        if let Some(sheet) = &self.sheet {
            (mapping.sheet, mapping.separator) = (Some(sheet.clone()), "the sheet".into());
        }
        Ok(mapping)
    }

    /// Reads the channels of a selection; none where neither column nor rate gives the time.
    fn outcome(&self, selection: Selection) -> Result<ReadOutcome, Error> {
        let (layout, options) = (&self.layout, self.task.options);
        let mut outcome = ReadOutcome {
            findings: self.findings.clone(),
            ..ReadOutcome::default()
        };
        if selection == Selection::Every {
            outcome.table = self.mapping().ok();
        }
        if selection == Selection::Lateral {
            long_table::refuse(&self.text, layout, self.task)?;
        }
        let findings = &mut outcome.findings;
        let Some(time) = layout.time_or_left_out(options, selection, findings)? else {
            return Ok(outcome);
        };
        self.refuse_lost_rows(&time, findings)?;
        let choice = layout.choose(options, selection, &time)?;
        if selection == Selection::Lateral {
            let head = self.lines_of_head();
            let marks = &self.marks;
            let end = options
                .last_line
                .map_or(u64::MAX, |last| u64::from(last) + 1);
            let samples = head.end..end;
            let judged = choice.columns.iter();
            for (index, is_requested) in judged
                .map(|index| (*index, options.channel.is_some()))
                .chain(time.column().map(|index| (index, true)))
            {
                let name = &layout.columns[index].name;
                findings.extend(marks.doubts(index, name, &head, is_requested)?);
                marks.refuse_merged(index, &samples)?;
            }
            for index in &choice.columns {
                let column = &layout.columns[*index];
                marks.refuse_other_words(*index, &head, |words| {
                    match AccelerationUnit::from_spelling(words) {
                        Some(unit) => options.unit.or(column.unit) == Some(unit),
                        None => column.unit_text.as_deref().map(str::trim) == Some(words),
                    }
                })?;
            }
            if let TimeSource::Column { index, unit, .. } = &time {
                let is_unit = |words: &str| TimeUnit::from_spelling(words) == Some(*unit);
                marks.refuse_other_words(*index, &head, is_unit)?;
            }
        }
        let counters = layout.counters(&time, &choice.columns);
        let counting = counters.iter().map(|counter| counter.column);
        let selected = SelectedColumns {
            selection,
            samples: choice.columns.len(),
            columns: choice.columns.iter().copied().chain(counting).collect(),
        };
        clocks_beside::refuse_unread(&self.text, layout, &time, &choice.columns, self.task)?;
        let rows = rows::read(&self.text, layout, &time, &selected, self.task);
        let mut rows = rows.map_err(|error| ends::named(error, &self.text, layout))?;
        let mut time = time;
        if let Some(rate) = options.rate_hz
            && rows.drop_date(rate)
        {
            time = TimeSource::Rate(SampleRate::from_hertz(rate)?);
            self.refuse_lost_rows(&time, findings)?;
        }
        let counts = rows.values.split_off(choice.columns.len());
        let mut values = std::mem::take(&mut rows.values).into_iter();
        let mut clock_findings = Vec::new();
        let shown_zero = self.shown_zero(&counters, &counts);
        let mut base = self.find_base(&mut rows, &time, shown_zero, &mut clock_findings)?;
        findings.extend(self.row_findings(&rows, &time));
        findings.append(&mut clock_findings);
        let instant = |row: usize| instant_of(row, &rows, &base);
        let clocks = clocks_beside::Clocks {
            text: &self.text,
            layout,
            time: &time,
            judged: &choice.columns,
            interval_s: base.rate.interval().seconds(),
        };
        let mut comparison = clocks.compare(instant, self.task)?;
        findings.append(&mut comparison.findings);
        let counts = self.count_findings(&counters, counts, &rows, &base);
        let facts = self.facts(&time, &rows, &base);
        let confirmed_by = layout.preamble.confirms(&facts).or(comparison.confirmed_by);
        let mut doubts = comparison.doubts;
        let odd_steps = counts.iter().filter(|finding| finding.code == "index-step");
        doubts.extend(odd_steps.map(|finding| finding.text.clone()));
        doubts.extend(layout.preamble.span_doubt(&facts));
        let words = self.words(&choice.columns, &time, &rows, &base)?;
        base.findings.extend(counts);
        if self.lines.more_words {
            findings.push(Finding::blocking(
                "laboratory-remark",
                "the file has more comments than latchgate can check for remarks. Read them, and \
                 export with fewer",
            ));
        }
        let lines = self.lines.words.iter().chain(&self.lines.above);
        let gravity = lines.into_iter().any(|(_, text)| says_gravity(text));
        let remarks_on = |subject: Option<usize>| {
            let remarks = words.remarks.iter();
            let remarks = remarks.filter(move |(column, _)| *column == subject);
            remarks.map(|(_, remark)| remark.clone())
        };
        outcome.remarks = remarks_on(None).collect();
        // `rows::read` has checked this limit.
        let limit = ("table_cells", u64::MAX);
        draft::deliver(selection, choice.columns, outcome, limit, |index, _| {
            let column = &layout.columns[index];
            let read = values.next().expect("one result for each column");
            let channel = read.and_then(|values| {
                let mut findings = choice.findings.clone();
                let unit = unit_of(column, options, selection, &mut findings)?;
                let clock = UniformSamples {
                    start_s: base.start_s,
                    rate: base.rate,
                    values: base.apply(&rows.stamps_s, values)?,
                };
                let mut draft = Draft::of_words(column, unit, clock, findings);
                draft.stated.gravity |= gravity;
                draft.stated.clock_confirmed_by.clone_from(&confirmed_by);
                let mut doubts = doubts.clone();
                let of_preamble = layout.preamble.findings(index, &facts, &mut doubts);
                draft.stated.clock_doubt = (!doubts.is_empty()).then(|| doubts.join("; "));
                draft.findings.extend(base.findings.iter().cloned());
                let flags = words.flags.iter();
                let flags = flags.filter(|(subject, _)| subject.is_none_or(|i| i == index));
                let flags = flags.map(|(_, finding)| finding.clone());
                draft.findings.extend(flags);
                draft.findings.extend(of_preamble);
                draft.remarks.extend(remarks_on(Some(index)));
                draft.finish(options.zero_s(), options)
            });
            channel
                .map(Some)
                .map_err(|error| (column.name.clone(), error))
        })
    }

    /// Returns the lines of the header: names and units.
    fn lines_of_head(&self) -> std::ops::Range<u64> {
        let line = |row| line_of_row(&self.text, row).unwrap_or(u64::MAX);
        line(0)..line(self.layout.header_rows)
    }

    /// Returns the remarks of comments, columns of words, preamble and workbook, and the flags.
    fn words(
        &self,
        chosen: &[usize],
        time: &TimeSource,
        rows: &Rows,
        base: &TimeBase,
    ) -> Result<TableWords, Error> {
        let layout = &self.layout;
        let passed: Vec<usize> = chosen.iter().copied().chain(time.column()).collect();
        let statuses = status::read(&self.text, layout, self.task.limits)?;
        let instant = |row: usize| instant_of(row, rows, base);
        let mut words = status::of_columns(&statuses, layout, &passed, instant);
        let remarks = &mut words.remarks;
        remarks.extend(layout.preamble.remarks(layout.columns.len()));
        let lines = self.lines.words.iter();
        remarks.extend(lines.map(|(line, text)| status::of_comment(*line, text, &layout.columns)));
        let workbook_remarks = self.workbook_remarks.iter().cloned();
        remarks.extend(workbook_remarks.map(|remark| (None, remark)));
        Ok(words)
    }

    /// Refuses comments that look like rows where no stamp would show the missing samples. With
    /// stamps, a finding names them.
    fn refuse_lost_rows(
        &self,
        time: &TimeSource,
        findings: &mut Vec<Finding>,
    ) -> Result<(), Error> {
        let (layout, lines) = (&self.layout, &self.lines);
        let (separator, rows) = (layout.separator, layout.header_rows);
        let columns = layout.columns.len();
        let interruptions = lines.interruptions(&self.text, separator, rows, columns);
        if let Some((line, cell)) = interruptions.damaged {
            let error = Error::malformed(
                "a number in the first cell, or a comment",
                format!(
                    "`{cell}`, as spreadsheets show a number too wide for its column or one not \
                     computed"
                ),
                "widen the column or correct the cell in the spreadsheet, and export again",
            );
            return Err(error.at(Place::default().line(line).column(1)));
        }
        let numbers = interruptions.numbers_at;
        let numbers = numbers.map(|line| (line, "a comment that holds as many numbers as a row"));
        let broken = interruptions.broken_at;
        let lost = numbers.or(broken.map(|line| (line, "a line that is empty or a comment")));
        if let (TimeSource::Rate(_), Some((line, what))) = (time, lost) {
            let expected = "rows of samples without a break, since no column tells their time";
            let hint = "export with a time column; a sample may be missing there";
            let error = Error::malformed(expected, what, hint);
            return Err(error.at(Place::default().line(line)));
        }
        if let Some(line) = interruptions.numbers_at {
            let text = format!(
                "{} comments hold as many numbers as a row, the first on line {line}. Samples may \
                 have been removed by hand. Look at these lines",
                interruptions.numbers
            );
            findings.push(Finding::warning("rows-made-comments", text));
        }
        Ok(())
    }

    /// Returns the findings on columns that count the rows: gaps, repeats, other steps than 1.
    fn count_findings(
        &self,
        counters: &[Counter],
        counts: Vec<ColumnResult>,
        rows: &Rows,
        base: &TimeBase,
    ) -> Vec<Finding> {
        let stamped = !rows.stamps_s.is_empty();
        let stated_hz = (!stamped).then(|| base.rate.hertz());
        let place = |row: usize| {
            let line = line_of_row(&self.text, self.layout.header_rows + row + 1);
            let line = line.filter(|_| rows.repeated.is_none());
            (line, instant_of(row, rows, base))
        };
        let finding = |(counter, counts): (&Counter, ColumnResult)| {
            let name = &self.layout.columns[counter.column].name;
            match counts {
                Ok(counts) => counter::finding(name, &counts, counter.is_named, stated_hz, place),
                Err(error) => (counter.is_named && !stamped).then(|| {
                    let text = format!("`{name}` could not be compared with the rows: {error}");
                    Finding::warning("index-gap", text)
                }),
            }
        };
        counters.iter().zip(counts).filter_map(finding).collect()
    }

    /// Returns who shows the first sample's place before time zero, and its number: a column that counts the samples
    /// from a negative number on.
    fn shown_zero(&self, counters: &[Counter], counts: &[ColumnResult]) -> Option<(String, f64)> {
        let mut named = counters
            .iter()
            .zip(counts)
            .filter(|(counter, _)| counter.is_named);
        named.find_map(|(counter, counts)| {
            let counts = counts.as_ref().ok()?;
            let (first, last) = (*counts.first()?, *counts.last()?);
            let steps = (counts.len() - 1) as f64;
            let is_whole = first.fract().abs() <= 0.0 && (last - first - steps).abs() <= 0.0;
            let name = &self.layout.columns[counter.column].name;
            (is_whole && first < 0.0).then(|| (format!("the sample numbers of `{name}`"), first))
        })
    }

    /// Returns the facts that the preamble is compared with.
    fn facts(&self, time: &TimeSource, rows: &Rows, base: &TimeBase) -> TableFacts {
        let clock_name = match time {
            TimeSource::Column { index, .. } => {
                format!("the time column `{}`", self.layout.columns[*index].name)
            }
            TimeSource::Rate(_) => "the stated rate".to_string(),
        };
        let interval_s = base.rate.interval().seconds();
        TableFacts {
            rate: base.rate,
            clock_name,
            start_s: base.start_s,
            end_s: base.start_s + base.samples.saturating_sub(1) as f64 * interval_s,
            samples: (rows.ended.is_none()).then_some(rows.count),
            is_stamped: time.column().is_some(),
            zero_s: self.task.options.time_zero_s,
            stated_hz: self.task.options.rate_hz,
            sensitivity: self.task.options.sensitivity.clone(),
        }
    }

    /// Returns the findings on the form of the rows: decimal mark, dates, repeats, rows left out.
    fn row_findings(&self, rows: &Rows, time: &TimeSource) -> Vec<Finding> {
        let mut findings = Vec::new();
        if rows.decimal_comma {
            let text = "the numbers have a decimal comma";
            findings.push(Finding::info("decimal-comma", text));
        }
        if let (Some(index), true) = (time.column(), rows.stamp_facts.is_absolute) {
            let name = &self.layout.columns[index].name;
            let text = format!(
                "the stamps of `{name}` are dates or times of day. Time counts from the first of \
                 them, and so does the setting `time_zero`"
            );
            findings.push(Finding::info("time-absolute", text));
            if rows.stamp_facts.order_is_assumed {
                let text = format!(
                    "the dates of `{name}` do not show whether day or month comes first. They were \
                     read so that the next date follows sooner. Check the dates"
                );
                findings.push(Finding::warning("date-order-assumed", text));
            }
        }
        findings.extend(
            rows.ended
                .as_ref()
                .map(|ended| ended.finding(time, &self.layout)),
        );
        if self.lines.rows_below > 0 {
            let text = format!(
                "{} rows of numbers after the table's last line were left out. Check {}",
                self.lines.rows_below,
                Setting::LastLine
            );
            findings.push(Finding::warning("rows-left-out", text));
        }
        if let Some((count, line)) = rows.repeated {
            let text = format!(
                "{count} rows repeat the one before in every cell, the first on line {line}. Each \
                 was used once. Look at the recorder's buffer"
            );
            findings.push(Finding::warning("rows-repeated", text));
        }
        findings
    }

    /// Finds the time base: that of the stamps, or the stated one.
    fn find_base(
        &self,
        rows: &mut Rows,
        time: &TimeSource,
        shown_zero: Option<(String, f64)>,
        findings: &mut Vec<Finding>,
    ) -> Result<TimeBase, Error> {
        let (options, limits) = (self.task.options, self.task.limits);
        let (column, unit, origin, worded) = match time {
            TimeSource::Rate(_) if rows.count < 2 => {
                return Err(Error::too_short("a recording", 2, rows.count));
            }
            TimeSource::Rate(rate) => {
                let preamble = &self.layout.preamble;
                let start_s = match preamble.before_zero_s(*rate) {
                    Some(start_s) => start_s,
                    None => {
                        let stated = preamble.start_s(*rate, rows.count);
                        let counted = shown_zero.map(|(by, first)| (by, first / rate.hertz()));
                        let (by, start_s) = stated.or(counted).unwrap_or_default();
                        if start_s != 0.0 {
                            findings.push(zero_shown(&by, start_s, options.time_zero_s));
                        }
                        start_s
                    }
                };
                return Ok(TimeBase::stated(start_s, *rate, rows.count, Vec::new()));
            }
            TimeSource::Column {
                index,
                unit,
                origin,
                worded,
            } => (*index, *unit, *origin, *worded),
        };
        let name = &self.layout.columns[column].name;
        if let (Some(digits), Some(stated)) = (&rows.coarse_digits_s, options.rate_hz) {
            let rate = SampleRate::from_hertz(stated)?;
            let from_first = rows.stamp_facts.count_from_first;
            return coarse_base(&rows.stamps_s, digits, name, from_first, rate);
        }
        // Day numbers of spreadsheets count from 1900; the file's clock then starts at the first stamp.
        if unit == TimeUnit::DAY && !worded {
            rows.count_days_from_first(1.0 / unit.seconds());
        }
        let mut fitted = TimeBase::fit(&rows.stamps_s, rows.printed_digit_s, limits)?;
        let in_seconds = fitted.rate.hertz();
        if let (Some(stated), true) = (options.rate_hz, origin != UnitOrigin::Stated) {
            let agrees = time_base::rates_agree(stated, in_seconds);
            let first_stamp = rows.stamps_s.first().copied().unwrap_or(0.0);
            let unit_s = clock::unit_by_rate(in_seconds, stated, origin, first_stamp);
            if let Some(unit_s) = unit_s.filter(|_| !agrees) {
                rows.scale_stamps(unit_s);
                rows.count_days_from_first(1.0 / unit_s);
                fitted = TimeBase::fit(&rows.stamps_s, rows.printed_digit_s, limits)?;
                let text = format!(
                    "the unit of the time column `{name}` is not known. By the stated rate it is \
                     {} s. Check it, or state the setting `time_unit` = UNIT",
                    brief(unit_s)
                );
                findings.push(Finding::warning("time-unit-assumed", text));
            } else {
                findings.push(clock::seconds_assumed(name));
            }
        }
        if !worded && origin == UnitOrigin::Stated {
            let (first_s, rate_hz) = (rows.stamps_s[0], fitted.rate.hertz());
            findings.extend(clock::unit_contradiction(name, first_s, rate_hz, unit));
        }
        let clock_name = format!("the time column `{name}`");
        let mend = if worded { MEND } else { clock::STATE_UNIT };
        let assumed = origin == UnitOrigin::Assumed;
        findings.extend(options.check_rate(fitted.rate.hertz(), (&clock_name, assumed), mend)?);
        Ok(fitted)
    }
}

/// Returns the finding that a file without stamps shows its time zero, and where.
fn zero_shown(by: &str, start_s: f64, stated_zero_s: Option<f64>) -> Finding {
    let text = format!(
        "the first sample is at {} s by {by}; the file's clock begins there",
        brief(start_s)
    );
    match stated_zero_s.filter(|zero_s| *zero_s != 0.0) {
        None => Finding::info("time-zero-shown", text),
        Some(zero_s) => Finding::warning(
            "time-zero-contradicted",
            format!(
                "{text}, and zero on it is time zero, but it was stated at {zero_s} s. Check the setting {}",
                Setting::TimeZero
            ),
        ),
    }
}

/// Returns the unit of a column, with its source.
fn unit_of(
    column: &ChannelName,
    options: &ReadOptions,
    selection: Selection,
    findings: &mut Vec<Finding>,
) -> Result<Unit, Error> {
    let source = match column.unit_text {
        Some(_) => column.unit_source,
        None => "header",
    };
    let place = format!("the {source} of `{}`", column.name);
    Unit::of_words(column, (source, &place), options, selection, findings)
}

/// Returns the instant of a row on the file's clock [s]. Where rows repeat others, it is no later
/// than the true one.
fn instant_of(row: usize, rows: &Rows, base: &TimeBase) -> Option<f64> {
    if rows.stamps_s.is_empty() {
        return Some(base.start_s + base.rate.interval().seconds() * row as f64);
    }
    // Repeated rows have no stamp, so that the stamp of this row lies up to as many places earlier.
    let repeated = rows.repeated.map_or(0, |(count, _)| count);
    rows.stamps_s.get(row.saturating_sub(repeated)).copied()
}

/// Returns the line of a row, header rows counted, from 0.
fn line_of_row(text: &[u8], row: usize) -> Option<u64> {
    text.split(|byte| *byte == b'\n')
        .enumerate()
        .filter(|(_, line)| dialect::is_row(line))
        .nth(row)
        .map(|(line, _)| line as u64 + 1)
}

/// A range of instants [s].
#[derive(Debug, Clone, Copy)]
struct Bracket {
    low: f64,
    high: f64,
}

impl Bracket {
    const EVERYWHERE: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };
}

/// Finds the time base of stamps that repeat, since they have too few digits, at a stated rate:
/// each of them must be the instant of its row to its own last digit, all rounded or all cut off.
fn coarse_base(
    stamps_s: &[f64],
    digits_s: &[f64],
    name: &str,
    from_first: bool,
    rate: SampleRate,
) -> Result<TimeBase, Error> {
    let interval = rate.interval().seconds();
    // Possible instants of the first row if stamps are rounded, cut off downwards, towards zero or upwards.
    let mut starts = [Bracket::EVERYWHERE; 4];
    for ((stamp, digit), row) in stamps_s.iter().zip(digits_s).zip(0_u32..) {
        let instant = f64::from(row) * interval;
        // Slack for rounding: of the digit itself, and of the last bits of the numbers compared.
        let slack = 1e-9 * digit + 8.0 * f64::EPSILON * (instant + stamp.abs());
        let below = if *stamp > 0.0 { 0.0 } else { 1.0 };
        let above = if *stamp < 0.0 { 0.0 } else { 1.0 };
        let ranges = [(0.5, 0.5), (0.0, 1.0), (below, above), (1.0, 0.0)];
        for (start, (below, above)) in starts.iter_mut().zip(ranges) {
            start.low = start.low.max(stamp - instant - below * digit - slack);
            start.high = start.high.min(stamp - instant + above * digit + slack);
        }
    }
    let coarsest = digits_s.iter().copied().fold(0.0, f64::max);
    let off_s = starts.map(|start| start.low - start.high);
    let off_s = off_s.into_iter().fold(f64::INFINITY, f64::min);
    let possible = starts.into_iter().filter(|start| start.low <= start.high);
    let low = possible
        .clone()
        .fold(f64::INFINITY, |low, start| low.min(start.low));
    let high = possible
        .clone()
        .fold(f64::NEG_INFINITY, |high, start| high.max(start.high));
    // The first stamp itself is preferred, then a multiple of the interval, so that a plain start stays
    // plain.
    let first = stamps_s[0];
    let on_grid = (first / interval).round() * interval;
    let plain = |start: Bracket| {
        let mut instants = [first, on_grid].into_iter();
        instants.find(|instant| (start.low..=start.high).contains(instant))
    };
    let middle = |start: Bracket| 0.5 * (start.low + start.high);
    let start_s = possible
        .clone()
        .find_map(plain)
        .or(possible.clone().next().map(middle));
    let Some(start_s) = start_s else {
        return Err(Error::malformed(
            format!(
                "stamps that follow the stated {} Hz to a printed digit",
                rate.hertz()
            ),
            format!(
                "stamps of `{name}` that repeat and are off by up to {} s",
                latchgate_kernel::units::plain(off_s + coarsest, 3)
            ),
            "rows are doubled or missing, or the rate is wrong; state the right one with the \
             setting `rate_hz` = HZ",
        )
        .at(Place::default().channel(name.to_string())));
    };
    let start_s = if from_first { 0.0 } else { start_s };
    let text = format!(
        "the stamps of `{name}` have too few digits and repeat. The stated {} Hz was used, which \
         fits them. The start is known to {} s. Export the stamps with more digits",
        rate.hertz(),
        latchgate_kernel::units::plain((high - low).max(0.0), 3)
    );
    let coarse = Finding::warning("stamps-coarse", text);
    Ok(TimeBase::stated(
        start_s,
        rate,
        stamps_s.len(),
        vec![coarse],
    ))
}
