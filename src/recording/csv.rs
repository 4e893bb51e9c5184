//! Text tables: CSV and its relatives.
//!
//! A table is read in three steps: its bytes become UTF-8 text (`encoding`), its separator,
//! comments and line lengths are found and checked (`dialect`), and its header says what the
//! columns hold (`header`). Only then are the rows read, the needed columns alone.
//!
//! What the file does not say is asked for, not guessed: a missing unit or time is an error,
//! and so is a header that does not fit its rows. Units never come from a comment.
//!
//! - `begin`: where a table begins, and what separates its cells;
//! - `counter`: columns that count the rows: where no stamp tells the time, they alone show a
//!   missing row;
//! - `date`: stamps that are dates: `2024-05-01T10:00:00.0001`, as ISO 8601 writes them, with a
//!   `T` or a blank between date and time, and with a zone or without;
//! - `layout`: layouts: which rows are header, which column is time, which one is the lateral
//!   acceleration;
//! - `records`: rows as cells, by the table reader of the `csv` crate;
//! - `rows`: rows: the stamps and the samples of the wanted columns;
//! - `status`: what a table says of its samples in words: comment lines, and columns that hold
//!   the state of a channel or notes row by row.

mod begin;
mod counter;
pub mod date;
mod dialect;
pub(super) mod header;
mod layout;
mod records;
mod rows;
mod status;

use super::draft::{self, Draft, UniformSamples, Unit};
use super::held;
use super::source::Reader;
use super::time_base::{self, TimeBase};
use super::{Finding, Head, Limits, Outcomes, ReadOptions, ReadOutcome, Selection};
use crate::error::{Error, ErrorKind, Place};
use crate::units::SampleRate;
pub use layout::TableMapping;
use layout::{ColumnChoice, TableLayout, TimeSource};
use rows::{ColumnResult, Rows, WantedColumns};
use status::AllSaid;

/// Tells whether the head looks like text.
#[must_use]
pub fn recognises(head: &Head<'_>) -> bool {
    !head.is_folder && super::encoding::looks_like_text(head.bytes)
}

/// Reads a text table.
///
/// # Errors
///
/// - [`ErrorKind::Empty`] without a data row,
/// - [`ErrorKind::MissingTime`] and [`ErrorKind::MissingUnit`] where neither file nor options say,
/// - [`ErrorKind::NoSuchChannel`], [`ErrorKind::AmbiguousChannel`] or [`ErrorKind::NoChannel`]
///   where the channel is not clear,
/// - [`ErrorKind::Malformed`], [`ErrorKind::NonFinite`], [`ErrorKind::RaggedRow`] or
///   [`ErrorKind::TimeNotIncreasing`] at the line and column of the first bad cell,
/// - [`ErrorKind::LimitExceeded`] where the file is larger than allowed.
pub fn read(
    source: &mut Reader,
    options: &ReadOptions,
    selections: &[Selection],
    limits: &Limits,
) -> Result<Outcomes, Error> {
    let table = TableText::open(source.read_text(limits)?, options, limits)?;
    let outcome = |selection: &Selection| table.outcome(*selection, options, limits);
    Ok(selections.iter().map(outcome).collect())
}

/// Says how a text table was understood, or, where a person is asked for that, how it seems to be.
///
/// # Errors
///
/// As [`read`], where nothing like a table is found.
pub fn mapping(
    source: &mut Reader,
    options: &ReadOptions,
    limits: &Limits,
) -> Result<TableMapping, Error> {
    let bytes = source.read_text(limits)?;
    let head = bytes[..bytes.len().min(begin::LOOKED_AT)].to_vec();
    let found = TableText::open(bytes, options, limits)
        .and_then(|table| table.layout.mapping(&table.text, options, limits));
    found.or_else(|error| {
        let (text, _) = super::encoding::decode(head, limits)?;
        let begin = begin::find(&text).ok_or(error)?;
        Ok(TableMapping {
            separator: begin::find_separator(&text, options.decimal).name(),
            decimal: options.decimal.map(crate::units::DecimalMark::name),
            header_line: begin.header,
            data_line: Some(begin.data),
            time_column: None,
            time_unit: None,
        })
    })
}

/// A table whose layout is known and whose rows are not read yet.
struct TableText {
    text: Vec<u8>,
    lines: dialect::LineScan,
    layout: TableLayout,
    /// What was found odd up to here.
    findings: Vec<Finding>,
}

impl TableText {
    fn open(bytes: Vec<u8>, options: &ReadOptions, limits: &Limits) -> Result<Self, Error> {
        let (mut text, mut findings) = super::encoding::decode(bytes, limits)?;
        let named = options.header_line.map(|line| line.saturating_sub(1));
        let above = dialect::Above {
            lines: u64::from(named.or(options.skip_lines).unwrap_or(0)),
            named: named.is_some(),
        };
        let lines = dialect::scan_lines(&mut text, above, limits)?;
        // The table reader takes a comment without a line end for an empty row.
        let last = memchr::memrchr(b'\n', &text).map_or(0, |end| end + 1);
        if text.get(last) == Some(&b'#') {
            text.truncate(last);
        }
        let separator = begin::find_separator(&text, options.decimal);
        if separator == dialect::Separator::Blanks {
            dialect::collapse_blanks(&mut text);
        }
        let quoted = memchr::memchr(b'"', &text).is_some();
        let layout = TableLayout::find(&text, separator, quoted, options, limits)?;
        if text.last() != Some(&b'\n')
            && let Some(cut) = std::str::from_utf8(&text).ok().and_then(held::cut_line)
        {
            // What is left of its number is none that was measured.
            let start = memchr::memrchr(b'\n', &text).map_or(0, |end| end + 1);
            text.truncate(start);
            findings.push(cut);
        }
        Ok(Self {
            text,
            lines,
            layout,
            findings,
        })
    }

    /// Reads what a selection asks for; nothing where nothing tells the time.
    fn outcome(
        &self,
        selection: Selection,
        options: &ReadOptions,
        limits: &Limits,
    ) -> Result<ReadOutcome, Error> {
        let (text, layout) = (&self.text, &self.layout);
        let mut findings = self.findings.clone();
        let Some(time) = layout.time_or_left_out(options, selection, &mut findings)? else {
            return Ok(ReadOutcome {
                findings,
                ..ReadOutcome::default()
            });
        };
        self.refuse_lost_rows(&time, &mut findings)?;
        let choice = layout.choose(options, selection, &time)?;
        let counters = layout.counters(&time, &choice.columns);
        let counting = counters.iter().map(|(column, _)| *column);
        let wanted = WantedColumns {
            selection,
            samples: choice.columns.len(),
            columns: choice.columns.iter().copied().chain(counting).collect(),
        };
        let mut rows = rows::read(text, layout, &time, &wanted, options, limits)?;
        let mut values = std::mem::take(&mut rows.values);
        let counts = values.split_off(choice.columns.len());
        findings.extend(self.row_findings(&rows, &time));
        let mut base = find_base(&rows, layout, &time, options, limits, &mut findings)?;
        let counts = self.count_findings(&counters, counts, &rows, &base);
        let said = self.said(&choice.columns, &time, &rows, &base, limits)?;
        base.findings.extend(counts);
        if self.lines.more_words {
            findings.push(Finding::blocking(
                "laboratory-remark",
                "the file holds more comments than are read for what they say of the samples",
            ));
        }
        self.deliver(
            selection,
            choice,
            values,
            (&rows, &base),
            said,
            findings,
            options,
        )
    }

    /// Returns what comments and columns of words say, and what their flags mean.
    fn said(
        &self,
        chosen: &[usize],
        time: &TimeSource,
        rows: &Rows,
        base: &Base,
        limits: &Limits,
    ) -> Result<AllSaid, Error> {
        let layout = &self.layout;
        let mut passed = chosen.to_vec();
        if let TimeSource::Column { index, .. } = time {
            passed.push(*index);
        }
        let statuses = status::read(&self.text, layout, limits)?;
        let at_s = |row: usize| instant_of(row, rows, base);
        let (mut remarks, flags) = status::of_columns(&statuses, layout, &passed, at_s);
        let lines = self.lines.words.iter();
        remarks.extend(lines.map(|(line, text)| status::of_comment(*line, text, &layout.columns)));
        Ok((remarks, flags))
    }

    /// Refuses comments that are rows in disguise where no stamp shows what is missing by them, and
    /// tells of them where one does.
    fn refuse_lost_rows(
        &self,
        time: &TimeSource,
        findings: &mut Vec<Finding>,
    ) -> Result<(), Error> {
        let (columns, _) = self.layout.widths();
        let layout = &self.layout;
        let found =
            self.lines
                .interruptions(&self.text, layout.separator, layout.header_rows, columns);
        if let Some((line, cell)) = found.damaged {
            let error = Error::malformed(
                "a number in the first cell, or a comment",
                format!(
                    "`{cell}`, as spreadsheets write for a number that does not fit into its \
                     column or could not be computed"
                ),
                "widen the column or mend the cell there, and export again; the sample of this \
                 row would be missing",
            );
            return Err(error.at(Place::default().line(line).column(1)));
        }
        let numbers = found.numbers_at;
        let numbers = numbers.map(|line| (line, "a comment that holds as many numbers as a row"));
        let broken = found.broken_at;
        let lost = numbers.or(broken.map(|line| (line, "a line that is empty or a comment")));
        if let (TimeSource::Rate(_), Some((line, what))) = (time, lost) {
            return Err(Error::malformed(
                "rows of samples without a break, since no column tells their time",
                what,
                "a sample may be missing there; export with a time column",
            )
            .at(Place::default().line(line)));
        }
        let told = |line| {
            let text = format!(
                "{} comments hold as many numbers as a row, the first on line {line}; samples may \
                 have been taken out by hand",
                found.numbers
            );
            Finding::warning("rows-made-comments", text)
        };
        findings.extend(found.numbers_at.map(told));
        Ok(())
    }

    /// Makes channels of the columns that were read.
    #[expect(clippy::too_many_arguments, reason = "all that was found out before")]
    fn deliver(
        &self,
        selection: Selection,
        choice: ColumnChoice,
        values: Vec<ColumnResult>,
        (rows, base): (&Rows, &Base),
        (remarks, flags): AllSaid,
        mut findings: Vec<Finding>,
        options: &ReadOptions,
    ) -> Result<ReadOutcome, Error> {
        let layout = &self.layout;
        let mut channels = Vec::with_capacity(choice.columns.len());
        for (index, result) in choice.columns.iter().copied().zip(values) {
            let values = match result {
                Ok(values) => values,
                Err(why) => {
                    findings.push(draft::left_out(&layout.columns[index].name, &why));
                    continue;
                }
            };
            let values = match &base.fitted {
                Some(fitted) => fitted.apply(&rows.stamps_s, values)?,
                None => values,
            };
            let mut draft = self.draft(index, values, base, options, &choice.findings);
            if draft.unit.unit.is_none() && selection == Selection::Lateral {
                let place = Place::default().channel(draft.name);
                return Err(Error::from(ErrorKind::MissingUnit).at(place));
            }
            let flags = flags
                .iter()
                .filter(|(of, _)| of.is_none_or(|of| of == index));
            draft
                .findings
                .extend(flags.map(|(_, finding)| finding.clone()));
            let own = remarks.iter().filter(|(of, _)| *of == Some(index));
            draft.remarks.extend(own.map(|(_, remark)| remark.clone()));
            match draft.finish(options.time_zero_s, &options.accepted_remarks) {
                Ok(channel) => channels.push(channel),
                Err(error) if selection == Selection::Lateral => return Err(error),
                Err(error) => findings.push(draft::left_out(&layout.columns[index].name, &error)),
            }
        }
        let of_all = remarks.into_iter().filter(|(of, _)| of.is_none());
        Ok(ReadOutcome {
            channels,
            findings,
            remarks: of_all.map(|(_, remark)| remark).collect(),
            ..ReadOutcome::default()
        })
    }

    /// Makes a channel of a column, with what its name and header, and its clock tell.
    fn draft(
        &self,
        index: usize,
        values: Vec<f64>,
        base: &Base,
        options: &ReadOptions,
        chosen: &[Finding],
    ) -> Draft {
        let column = &self.layout.columns[index];
        let mut findings = chosen.to_vec();
        let unit = unit_of(column, options, &mut findings);
        let clock = UniformSamples {
            start_s: base.start_s,
            rate: base.rate,
            values,
        };
        let mut draft = Draft::of_words(column, unit, clock, findings);
        draft.findings.extend(base.findings.iter().cloned());
        draft
    }

    /// Says where columns that count the rows do not.
    fn count_findings(
        &self,
        counters: &[(usize, bool)],
        counts: Vec<ColumnResult>,
        rows: &Rows,
        base: &Base,
    ) -> Vec<Finding> {
        let stamped = !rows.stamps_s.is_empty();
        let place = |row: usize| {
            let line = line_of_row(&self.text, self.layout.header_rows + row + 1);
            (
                line.filter(|_| rows.repeated.is_none()),
                instant_of(row, rows, base),
            )
        };
        let finding = |(&(column, named), counts): (&(usize, bool), ColumnResult)| {
            let name = &self.layout.columns[column].name;
            match counts {
                Ok(counts) => counter::finding(name, &counts, (named, stamped), place),
                Err(why) => (named && !stamped).then(|| {
                    let text = format!("`{name}` could not be held against the rows: {why}");
                    Finding::warning("index-gap", text)
                }),
            }
        };
        counters.iter().zip(counts).filter_map(finding).collect()
    }

    /// Says what is odd about the rows as they were written.
    fn row_findings(&self, rows: &Rows, time: &TimeSource) -> Vec<Finding> {
        let mut findings = Vec::new();
        if rows.decimal_comma {
            findings.push(Finding::info(
                "decimal-comma",
                "the numbers are written with a decimal comma",
            ));
        }
        if let TimeSource::Column {
            dated: true, index, ..
        } = time
        {
            findings.push(Finding::info(
                "time-absolute",
                format!(
                    "the stamps of `{}` are dates; time was counted from the first of them, and \
                     the setting `time_zero` is meant so as well",
                    self.layout.columns[*index].name
                ),
            ));
        }
        if let Some((count, line)) = rows.repeated {
            let text = format!(
                "{count} rows repeat the one before to the last cell, the first on line {line}; each \
                 was taken once"
            );
            findings.push(Finding::warning("rows-repeated", text));
        }
        findings
    }
}

/// Returns the unit of a column, and what states it.
fn unit_of(column: &header::Column, options: &ReadOptions, findings: &mut Vec<Finding>) -> Unit {
    let own = column.unit.map(|unit| (unit, column.unit_source));
    Unit::find(own, options, findings, |source, used| {
        let text = column.unit_text.as_ref()?;
        Some(format!(
            "the {} says `{text}` for `{}`, the {source} says `{used}`, which was used",
            column.unit_source, column.name
        ))
    })
}

/// Returns the instant of a row on the file's clock [s]; of rows that repeat others none later
/// than it.
fn instant_of(row: usize, rows: &Rows, base: &Base) -> Option<f64> {
    if rows.stamps_s.is_empty() {
        return Some(base.start_s + base.rate.interval().seconds() * row as f64);
    }
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

/// The time base of a table, with the fit if there is a time column.
struct Base {
    start_s: f64,
    rate: SampleRate,
    findings: Vec<Finding>,
    fitted: Option<TimeBase>,
}

fn find_base(
    rows: &Rows,
    layout: &TableLayout,
    time: &TimeSource,
    options: &ReadOptions,
    limits: &Limits,
    findings: &mut Vec<Finding>,
) -> Result<Base, Error> {
    let (column, unit_stated) = match time {
        TimeSource::Rate(rate) => {
            if rows.count < 2 {
                return Err(Error::too_short("a recording", 2, rows.count));
            }
            return Ok(Base {
                start_s: 0.0,
                rate: *rate,
                findings: Vec::new(),
                fitted: None,
            });
        }
        TimeSource::Column {
            index, unit_stated, ..
        } => (*index, *unit_stated),
    };
    let name = &layout.columns[column].name;
    if let (Some(digits), Some(stated)) = (&rows.coarse_digits_s, options.rate_hz) {
        return coarse_base(
            &rows.stamps_s,
            digits,
            name,
            SampleRate::from_hertz(stated)?,
        );
    }
    let fitted = TimeBase::fit(&rows.stamps_s, rows.printed_digit_s, limits)?;
    let rate = fitted.rate.hertz();
    options.check_rate(
        rate,
        &format!("the time column `{name}`"),
        "state the setting `time_unit`, or leave out the rate",
    )?;
    let confirmed = options.time_unit.is_some() || options.rate_hz.is_some();
    let by = format!("`{name}`");
    let hint = "if its unit is another, state it with the setting `time_unit` = s|ms|us|ns";
    let odd = time_base::implausible_rate(rate, &by, (unit_stated, confirmed), hint);
    findings.extend(odd.map_err(|error| error.at(Place::default().channel(name)))?);
    Ok(Base {
        start_s: fitted.start_s,
        rate: fitted.rate,
        findings: fitted.findings.clone(),
        fitted: Some(fitted),
    })
}

/// Finds the time base of stamps that repeat, since they have too few digits, at a stated rate:
/// each of them must be the instant of its row to its own last digit, rounded or cut off.
fn coarse_base(
    stamps_s: &[f64],
    digits_s: &[f64],
    name: &str,
    rate: SampleRate,
) -> Result<Base, Error> {
    let interval = rate.interval().seconds();
    // Where the start may lie if stamps are cut off towards zero or rounded up, and if rounded.
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut rounded_low, mut rounded_high) = (low, high);
    for ((stamp, digit), row) in stamps_s.iter().zip(digits_s).zip(0_u32..) {
        let instant = f64::from(row) * interval;
        let slack = 1e-9 * digit + 8.0 * f64::EPSILON * (instant + stamp.abs());
        let start = stamp - instant;
        low = low.max(start - digit - slack);
        high = high.min(start + digit + slack);
        rounded_low = rounded_low.max(start - 0.5 * digit - slack);
        rounded_high = rounded_high.min(start + 0.5 * digit + slack);
    }
    let coarsest = digits_s.iter().copied().fold(0.0, f64::max);
    if low > high {
        return Err(Error::malformed(
            format!(
                "stamps that follow {} Hz to a printed digit, as option or card say",
                rate.hertz()
            ),
            format!(
                "stamps of `{name}` that repeat and are off by up to {} s",
                crate::units::plain(low - high + 2.0 * coarsest, 3)
            ),
            "rows are doubled or missing, or the rate is another; state the right one with the \
             setting `rate_hz`",
        )
        .at(Place::default().channel(name.to_string())));
    }
    if rounded_low <= rounded_high {
        (low, high) = (rounded_low, rounded_high);
    }
    let fits = |at: &f64| (low..=high).contains(at);
    let first = stamps_s[0];
    let on_grid = (first / interval).round() * interval;
    let start_s = [first, on_grid].into_iter().find(fits);
    Ok(Base {
        start_s: start_s.unwrap_or(0.5 * (low + high)),
        rate,
        findings: vec![Finding::warning(
            "stamps-coarse",
            format!(
                "the stamps of `{name}` have too few digits and repeat; the stated {} Hz was \
                 used, which they follow to their printed digits, so that the start is known to \
                 {} s",
                rate.hertz(),
                crate::units::plain((high - low).max(0.0), 3)
            ),
        )],
        fitted: None,
    })
}
