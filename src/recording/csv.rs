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
//! - `cell`: what is said of a cell that cannot be used, and what to do about it;
//! - `counter`: columns that count the rows: where no stamp tells the time, they alone show a
//!   missing row;
//! - `date`: stamps that are dates: `2024-05-01T10:00:00.0001`, as ISO 8601 writes them, with a
//!   `T` or a blank between date and time, and with a zone or without;
//! - `layout`: layouts: which rows are header, which column is time, which one is the lateral
//!   acceleration;
//! - `records`: rows as cells: split at the separator where no quote stands in the text, by the
//!   table reader of the `csv` crate where one does;
//! - `rows`: rows: the stamps and the samples of the wanted columns, in one pass for all
//!   selections;
//! - `status`: what a table says of its samples in words: comment lines, and columns that hold
//!   the state of a channel or notes row by row.

mod begin;
mod cell;
mod counter;
mod date;
mod dialect;
pub(super) mod header;
mod layout;
mod records;
mod rows;
mod status;

use super::draft::{self, Draft, Unit};
use super::held;
use super::source::Reader;
use super::time_base::TimeBase;
use super::{Finding, Head, Limits, Outcomes, ReadOptions, ReadOutcome, Selection};
use crate::error::{Error, ErrorKind, Place};
use crate::units::SampleRate;
use layout::{ColumnChoice, TableLayout, TimeSource};
use rows::{ColumnResult, Rows, WantedColumns};
use status::StatusColumn;

/// Rates outside of which a stated unit of time is doubted [Hz].
pub(super) const PLAUSIBLE_STATED: (f64, f64) = (1.0, 200e3);

/// Rates outside of which an assumed unit of time is doubted [Hz]; no crash recording is slower.
const PLAUSIBLE_ASSUMED: (f64, f64) = (250.0, 200e3);

/// Rate from which on only the user's word for the unit of time counts [Hz]: a header that says
/// milliseconds over seconds makes 1 MHz of 1 kHz, and the pulse a thousandth of its length.
pub(super) const INCREDIBLE: f64 = 500e3;

/// Rate below which seconds are not assumed [Hz]: nanoseconds and microseconds taken for them make
/// such.
const LEAST_ASSUMED: f64 = 0.2;

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
    let plans: Vec<Result<ReadPlan, Error>> = selections
        .iter()
        .map(|selection| table.plan(options, *selection))
        .collect();
    let rows = table.rows(&plans, options, limits);
    let statuses = if rows.iter().flatten().any(Result::is_ok) {
        status::read(&table.text, &table.layout)?
    } else {
        Vec::new()
    };
    Ok(plans
        .into_iter()
        .zip(rows)
        .map(|(plan, rows)| table.deliver(plan?, rows, &statuses, options, limits))
        .collect())
}

/// A table whose layout is known and whose rows are not read yet.
struct TableText {
    text: Vec<u8>,
    lines: dialect::LineScan,
    layout: TableLayout,
    /// What was found odd up to here.
    findings: Vec<Finding>,
}

/// What is read of a table for one selection.
struct ReadPlan {
    selection: Selection,
    /// `None` where nothing tells the time, so that no channel can be read.
    time: Option<TimeSource>,
    choice: ColumnChoice,
    /// Columns that count the rows, each with whether its name says so.
    counters: Vec<(usize, bool)>,
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
        let separator = lines
            .separator
            .unwrap_or_else(|| begin::find_separator(&text, options.decimal));
        if separator == dialect::Separator::Blanks {
            dialect::collapse_blanks(&mut text);
        }
        let quoted = memchr::memchr(b'"', &text).is_some();
        dialect::check_lines(&text, separator, quoted, limits)?;
        let layout = TableLayout::find(&text, separator, quoted, options)?;
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

    /// Finds the time and the columns of a selection.
    fn plan(&self, options: &ReadOptions, selection: Selection) -> Result<ReadPlan, Error> {
        let mut findings = self.findings.clone();
        let time = self
            .layout
            .time_or_left_out(options, selection, &mut findings)?;
        let mut plan = ReadPlan {
            selection,
            time,
            choice: ColumnChoice::default(),
            counters: Vec::new(),
            findings,
        };
        let Some(time) = &plan.time else {
            return Ok(plan);
        };
        self.refuse_lost_rows(time, &mut plan.findings)?;
        plan.choice = self.layout.choose(options, selection, time)?;
        plan.counters = self.layout.counters(time, &plan.choice.columns);
        Ok(plan)
    }

    /// Refuses comments that are rows in disguise where no stamp shows what is missing by them, and
    /// tells of them where one does.
    fn refuse_lost_rows(
        &self,
        time: &TimeSource,
        findings: &mut Vec<Finding>,
    ) -> Result<(), Error> {
        let (columns, _) = self.layout.widths();
        if let (1, Some(line)) = (columns, self.lines.hashes) {
            return Err(dialect::damaged_row(b"####").at(Place::default().line(line).column(1)));
        }
        let layout = &self.layout;
        let found =
            self.lines
                .interruptions(&self.text, layout.separator, layout.header_rows, columns);
        let lost = match (
            found.numbers_at.filter(|_| found.numbers_inside),
            found.broken_at,
        ) {
            (Some(line), _) => Some((line, "a comment that holds as many numbers as a row")),
            (None, Some(line)) => Some((line, "a line that is empty or a comment")),
            (None, None) => None,
        };
        if let (TimeSource::Rate(_), Some((line, what))) = (time, lost) {
            return Err(Error::from(ErrorKind::Malformed {
                expected: "rows of samples without a break, since no column tells their time"
                    .into(),
                found: what.into(),
                hint: "a sample may be missing there; export with a time column".into(),
            })
            .at(Place::default().line(line)));
        }
        let told = |line| {
            let (count, hold) = (
                found.numbers,
                if found.numbers == 1 {
                    "comment holds"
                } else {
                    "comments hold"
                },
            );
            let text = format!(
                "{count} {hold} as many numbers as a row, the first on line {line}; samples may have been taken out by hand"
            );
            Finding::warning("rows-made-comments", text)
        };
        findings.extend(found.numbers_at.map(told));
        Ok(())
    }

    /// Reads the rows that the plans ask for in one pass; nothing for a plan without a time.
    fn rows(
        &self,
        plans: &[Result<ReadPlan, Error>],
        options: &ReadOptions,
        limits: &Limits,
    ) -> Vec<Option<Result<Rows, Error>>> {
        let time_of =
            |plan: &Result<ReadPlan, Error>| plan.as_ref().ok().and_then(|plan| plan.time);
        // Header and options tell the time, so that it is the same for all selections.
        let Some(time) = plans.iter().find_map(time_of) else {
            return plans.iter().map(|_| None).collect();
        };
        let wanted: Vec<WantedColumns<'_>> = plans
            .iter()
            .flatten()
            .filter(|plan| plan.time.is_some())
            .map(|plan| WantedColumns {
                selection: plan.selection,
                columns: &plan.choice.columns,
                counters: plan.counters.iter().map(|(column, _)| *column).collect(),
            })
            .collect();
        let read = rows::read(&self.text, &self.layout, &time, &wanted, options, limits);
        let mut read = read.into_iter();
        let of = |plan| time_of(plan).and_then(|_| read.next());
        plans.iter().map(of).collect()
    }

    /// Makes channels of the rows that were read for a plan.
    fn deliver(
        &self,
        plan: ReadPlan,
        rows: Option<Result<Rows, Error>>,
        statuses: &[StatusColumn],
        options: &ReadOptions,
        limits: &Limits,
    ) -> Result<ReadOutcome, Error> {
        let ReadPlan {
            selection,
            time,
            choice,
            counters,
            mut findings,
        } = plan;
        let (Some(time), Some(rows)) = (time, rows) else {
            return Ok(ReadOutcome {
                findings,
                ..ReadOutcome::default()
            });
        };
        let mut rows = rows?;
        findings.extend(self.row_findings(&rows, &time));
        let (text, layout) = (&self.text, &self.layout);
        let mut base = find_base(text, &rows, layout, &time, options, limits, &mut findings)?;
        let at_s = |row: usize| instant_of(row, &rows, &base);
        let counts = faulty_counts(text, &rows, layout, &counters, at_s);
        let mut passed = choice.columns.clone();
        if let TimeSource::Column { index, .. } = time {
            passed.push(index);
        }
        let (mut remarks, flags) = status::of_columns(statuses, layout, &passed, at_s);
        base.findings.extend(counts);
        let lines = self.lines.words.iter();
        remarks.extend(lines.map(|(line, text)| status::of_comment(*line, text, &layout.columns)));
        if self.lines.more_words {
            findings.push(Finding::blocking(
                "laboratory-remark",
                "the file holds more comments than are read for what they say of the samples",
            ));
        }
        let mut channels = Vec::with_capacity(choice.columns.len());
        for (index, result) in choice.columns.iter().zip(std::mem::take(&mut rows.values)) {
            let column = &layout.columns[*index];
            let values = match result {
                ColumnResult::Kept(values) => values,
                ColumnResult::LeftOut(why) => {
                    findings.push(draft::left_out(&column.name, &why));
                    continue;
                }
            };
            let values = match &base.fitted {
                Some(fitted) => fitted.apply(&rows.stamps_s, values)?,
                None => values,
            };
            let mut own = choice.findings.clone();
            let unit = unit_of(column, options, &mut own);
            if unit.unit.is_none() && selection == Selection::Lateral {
                return Err(Error::from(ErrorKind::MissingUnit)
                    .at(Place::default().channel(column.name.clone())));
            }
            self.tell(*index, &base, &mut own);
            let flags = flags
                .iter()
                .filter(|(of, _)| of.is_none_or(|of| of == *index));
            own.extend(flags.map(|(_, finding)| finding.clone()));
            let channel = Draft {
                name: column.name.clone(),
                unit,
                start_s: base.start_s,
                rate: base.rate,
                values,
                stated: column.stated(),
                findings: own,
                remarks: remarks
                    .iter()
                    .filter(|(of, _)| *of == Some(*index))
                    .map(|(_, remark)| remark.clone())
                    .collect(),
            };
            channels.push(channel.finish(options.time_zero_s, &options.accepted_remarks));
        }
        let of_all = remarks.into_iter().filter(|(of, _)| of.is_none());
        Ok(ReadOutcome {
            channels,
            findings,
            remarks: of_all.map(|(_, remark)| remark).collect(),
            ..ReadOutcome::default()
        })
    }

    /// Says of a column what its name and header, and its clock tell.
    fn tell(&self, index: usize, base: &Base, findings: &mut Vec<Finding>) {
        let column = &self.layout.columns[index];
        findings.extend(column.stated().findings(base.rate));
        findings.extend(column.name_findings());
        findings.extend(base.findings.iter().cloned());
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
                    "the stamps of `{}` are dates; time was counted from the first of them, and the setting `time_zero` is meant so as well",
                    self.layout.columns[*index].name
                ),
            ));
        }
        if let Some((count, line)) = rows.repeated {
            findings.push(Finding::warning(
                "rows-repeated",
                format!(
                    "{count} {} to the last cell, the first on line {line}; each was taken once",
                    if count == 1 {
                        "row repeats the one before"
                    } else {
                        "rows repeat the ones before"
                    }
                ),
            ));
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

/// Returns what is wrong with the columns that count the rows.
fn faulty_counts(
    text: &[u8],
    rows: &Rows,
    layout: &TableLayout,
    counters: &[(usize, bool)],
    at_s: impl Fn(usize) -> Option<f64>,
) -> Vec<Finding> {
    let stamped = !rows.stamps_s.is_empty();
    let mut findings = Vec::new();
    for ((column, named), counts) in counters.iter().zip(&rows.counts) {
        let name = &layout.columns[*column].name;
        let counts = match counts {
            ColumnResult::Kept(counts) => counts,
            ColumnResult::LeftOut(_) if stamped || !named => continue,
            ColumnResult::LeftOut(why) => {
                findings.push(Finding::warning(
                    "index-gap",
                    format!("`{name}` could not be held against the rows: {why}"),
                ));
                continue;
            }
        };
        match counter::judge(counts, *named) {
            Some((_, Some(fault))) => {
                let line = rows
                    .repeated
                    .is_none()
                    .then(|| line_of_row(text, layout.header_rows + fault.row + 1))
                    .flatten();
                let at_s = at_s(fault.row);
                findings.push(counter::finding(name, &fault, line, at_s, stamped));
            }
            Some((usual, None)) if *named && !stamped && (usual - 1.0).abs() > 1e-9 => {
                findings.push(Finding::warning(
                    "index-step",
                    format!(
                        "`{name}` counts by {usual}; if samples were left out, the stated rate is that many times too high"
                    ),
                ));
            }
            _ => {}
        }
    }
    findings
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
    text: &[u8],
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
                return Err(ErrorKind::TooShort {
                    what: "a recording",
                    needed: 2,
                    found: rows.count,
                }
                .into());
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
    let fitted = TimeBase::fit(&rows.stamps_s, rows.printed_digit_s, limits)
        .map_err(|error| at_longest_gap(error, text, rows, layout))?;
    let rate = fitted.rate.hertz();
    options.check_rate(
        rate,
        &format!("the time column `{name}`"),
        "state the setting `time_unit`, or leave out the rate",
    )?;
    findings.extend(implausible_rate(rate, name, unit_stated, options)?);
    Ok(Base {
        start_s: fitted.start_s,
        rate: fitted.rate,
        findings: fitted.findings.clone(),
        fitted: Some(fitted),
    })
}

/// Doubts a rate [Hz] that crash recordings do not have: beyond all belief only the user's word
/// counts.
fn implausible_rate(
    rate: f64,
    name: &str,
    unit_stated: bool,
    options: &ReadOptions,
) -> Result<Option<Finding>, Error> {
    let incredible = rate > INCREDIBLE || (rate < LEAST_ASSUMED && !unit_stated);
    if incredible && options.time_unit.is_none() && options.rate_hz.is_none() {
        return Err(Error::from(ErrorKind::Malformed {
            expected: "a time column of a rate that crash recordings have".into(),
            found: format!(
                "{rate} Hz by `{name}`{}",
                if unit_stated { "" } else { ", seconds assumed" }
            ),
            hint:
                "its unit is likely another than the header says; state it with the setting `time_unit` = s|ms|us|ns"
                    .into(),
        })
        .at(Place::default().channel(name.to_string())));
    }
    let (low, high) = if unit_stated {
        PLAUSIBLE_STATED
    } else {
        PLAUSIBLE_ASSUMED
    };
    Ok((!(low..=high).contains(&rate)).then(|| {
        Finding::warning(
            "time-unit-implausible",
            format!(
                "the time column `{name}` gives {rate} Hz, which no crash recording has; state its unit with the setting `time_unit` = s|ms|us|ns"
            ),
        )
    }))
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
        return Err(Error::from(ErrorKind::Malformed {
            expected: format!(
                "stamps that follow {} Hz to a printed digit, as option or card say",
                rate.hertz()
            ),
            found: format!(
                "stamps of `{name}` that repeat and are off by up to {} s",
                crate::units::plain(low - high + 2.0 * coarsest, 3)
            ),
            hint: "rows are doubled or missing, or the rate is another; state the right one with the setting `rate_hz`".into(),
        })
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
                "the stamps of `{name}` have too few digits and repeat; the stated {} Hz was used, which they follow to their printed digits, so that the start is known to {} s",
                rate.hertz(),
                crate::units::plain((high - low).max(0.0), 3)
            ),
        )],
        fitted: None,
    })
}

/// Says where the longest gap stands if filling the gaps takes more samples than allowed.
fn at_longest_gap(error: Error, text: &[u8], rows: &Rows, layout: &TableLayout) -> Error {
    let ErrorKind::LimitExceeded { limit, value, .. } = error.kind() else {
        return error;
    };
    let step = |index: usize| rows.stamps_s[index + 1] - rows.stamps_s[index];
    let Some(longest) =
        (0..rows.stamps_s.len().saturating_sub(1)).max_by(|a, b| step(*a).total_cmp(&step(*b)))
    else {
        return error;
    };
    let found = format!(
        "more on a uniform time base: after the stamp {} s the next one comes {} s later",
        rows.stamps_s[longest],
        crate::units::plain(step(longest), 6)
    );
    let place = if rows.repeated.is_some() {
        Place::default()
    } else {
        let row = layout.header_rows + longest + 1;
        line_of_row(text, row).map_or(Place::default(), |line| Place::default().line(line))
    };
    let (limit, value) = (*limit, *value);
    Error::from(ErrorKind::LimitExceeded {
        limit,
        value,
        found,
    })
    .at(place)
}
