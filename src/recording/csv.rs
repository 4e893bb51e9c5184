//! Text tables: CSV and its relatives.
//!
//! A table is read in three steps: its bytes become UTF-8 text (`encoding`), its separator,
//! comments and line lengths are found and checked (`dialect`), and its header says what the
//! columns hold (`header`). Only then are the rows read, the needed columns alone.
//!
//! What the file does not say is asked for, not guessed: a missing unit or time is an error,
//! and so is a header that does not fit its rows. Units never come from a comment.

mod counter;
mod date;
mod dialect;
pub(super) mod encoding;
pub(super) mod header;
mod layout;
pub(super) mod number;
mod plain;
mod remarks;
mod rows;

use super::source::Reader;
use super::time_base::TimeBase;
use super::{Channel, Finding, Head, Limits, ReadOptions, ReadOutcome, Selection, laboratory};
use crate::error::{Error, ErrorKind, Place};
use crate::units::{AccelerationUnit, SampleRate};
use layout::{Layout, TimeSource};
use rows::{Fate, Rows};

/// Rates outside of which a stated unit of time is doubted [Hz].
pub(super) const PLAUSIBLE_STATED: (f64, f64) = (1.0, 200e3);

/// Rates outside of which an assumed unit of time is doubted [Hz]; no crash recording is slower.
const PLAUSIBLE_ASSUMED: (f64, f64) = (250.0, 200e3);

/// Rate from which on only the user's word for the unit of time counts [Hz]: a header that says
/// milliseconds over seconds makes 1 MHz of 1 kHz, and the pulse a thousandth of its length.
pub(super) const INCREDIBLE: f64 = 500e3;

/// Tells whether the head looks like text.
#[must_use]
pub fn recognises(head: &Head<'_>) -> bool {
    !head.is_folder && encoding::looks_like_text(head.bytes)
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
    selection: Selection,
    limits: &Limits,
) -> Result<ReadOutcome, Error> {
    let bytes = source.read_text(limits)?;
    let (mut text, mut findings) = encoding::decode(bytes, limits)?;
    let marked = dialect::mark_lines(&mut text, limits)?;
    // The table reader takes a comment without a line end for an empty row.
    let last = memchr::memrchr(b'\n', &text).map_or(0, |end| end + 1);
    if text.get(last) == Some(&b'#') {
        text.truncate(last);
    }
    let separator = marked
        .separator
        .unwrap_or_else(|| dialect::find_separator(&text));
    if separator == dialect::Separator::Blanks {
        dialect::collapse_blanks(&mut text);
    }
    let quoted = memchr::memchr(b'"', &text).is_some();
    dialect::check_lines(&text, separator, quoted, limits)?;
    let layout = Layout::find(&text, separator, quoted, options, &mut findings)?;
    let Some(time) = layout.time_or_left_out(options, selection, &mut findings)? else {
        return Ok(ReadOutcome {
            channels: Vec::new(),
            findings,
        });
    };
    if let (TimeSource::Rate(_), Some(line)) = (&time, marked.break_after(layout.header_rows)) {
        return Err(Error::from(ErrorKind::Malformed {
            expected: "rows of samples without a break, since no column tells their time".into(),
            found: "a line that is empty or a comment".into(),
            hint: "remove the line if no sample is missing there, or export with a time column"
                .into(),
        })
        .at(Place::default().line(line)));
    }
    refuse_lost_rows(&text, &marked, &layout, &time, &mut findings)?;
    let choice = layout.choose(options, selection, &time)?;
    let wanted = &choice.columns;
    let counters = layout.counters(&time, wanted);
    let counted: Vec<usize> = counters.iter().map(|(column, _)| *column).collect();
    let columns = (wanted.as_slice(), counted.as_slice());
    let rows = Rows::read(&text, &layout, &time, columns, (options, selection), limits)?;
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
                layout.columns[index].name
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
    let mut base = find_base(&text, &rows, &layout, &time, options, limits, &mut findings)?;
    let at_s = |row: usize| instant_of(row, &rows, &base);
    let counts = faulty_counts(&text, &rows, &layout, &counters, at_s);
    let mut passed = choice.columns.clone();
    if let TimeSource::Column { index, .. } = time {
        passed.push(index);
    }
    let told = remarks::of_columns(&text, &layout, &passed, at_s)?;
    base.findings.extend(counts);
    if marked.more_words {
        findings.push(Finding::info(
            "notes",
            "the file holds more comments than are read for what they say of the samples",
        ));
    }
    let zero = options.time_zero_s.unwrap_or(0.0);
    let mut channels = Vec::with_capacity(choice.columns.len());
    for (index, fate) in choice.columns.iter().zip(rows.values) {
        let column = &layout.columns[*index];
        let values = match fate {
            Fate::Kept(values) => values,
            Fate::LeftOut(why) => {
                findings.push(Finding::warning(
                    "channel-left-out",
                    format!("{} is left out: {why}", column.name),
                ));
                continue;
            }
        };
        let values = match &base.fitted {
            Some(fitted) => fitted.apply(&rows.stamps_s, values)?,
            None => values,
        };
        let (unit, unit_source, unit_finding) = unit_of(column, options);
        if unit.is_none() && selection == Selection::Lateral {
            return Err(Error::from(ErrorKind::MissingUnit)
                .at(Place::default().channel(column.name.clone())));
        }
        let mut own = choice.findings.clone();
        own.extend(unit_finding);
        let stated = column.stated();
        own.extend(stated.findings(base.rate));
        own.extend(column.name_findings());
        own.extend(base.findings.iter().cloned());
        own.extend(
            told.iter()
                .filter(|told| told.of.is_none_or(|of| of == *index))
                .map(|told| told.finding.clone()),
        );
        let end_s = base.start_s + base.rate.interval().seconds() * last_index(&values);
        for mut finding in remarks::of_comments(&marked.words, &layout.columns, *index) {
            let interval_s = base.rate.interval().seconds();
            laboratory::hold_against_record(&mut finding, base.start_s, end_s, interval_s);
            own.push(finding);
        }
        // The choice has no instants; all others are on the file's clock.
        for finding in &mut own {
            finding.at_s = finding.at_s.map(|at| at - zero);
        }
        channels.push(Channel {
            name: column.name.clone(),
            unit,
            unit_source,
            start_s: base.start_s - zero,
            rate: base.rate,
            values,
            stated,
            findings: own,
        });
    }
    Ok(ReadOutcome { channels, findings })
}

fn to_f64(count: usize) -> f64 {
    count as f64
}

fn last_index(values: &[f64]) -> f64 {
    to_f64(values.len().saturating_sub(1))
}

/// Returns the instant of a row on the file's clock [s]; of rows that repeat others none later
/// than it.
fn instant_of(row: usize, rows: &Rows, base: &Base) -> Option<f64> {
    if rows.stamps_s.is_empty() {
        return Some(base.start_s + base.rate.interval().seconds() * to_f64(row));
    }
    let repeated = rows.repeated.map_or(0, |(count, _)| count);
    rows.stamps_s.get(row.saturating_sub(repeated)).copied()
}

/// Returns what is wrong with the columns that count the rows.
fn faulty_counts(
    text: &[u8],
    rows: &Rows,
    layout: &Layout,
    counters: &[(usize, bool)],
    at_s: impl Fn(usize) -> Option<f64>,
) -> Vec<Finding> {
    let stamped = !rows.stamps_s.is_empty();
    let mut findings = Vec::new();
    for ((column, named), counts) in counters.iter().zip(&rows.counts) {
        let name = &layout.columns[*column].name;
        let counts = match counts {
            Fate::Kept(counts) => counts,
            Fate::LeftOut(_) if stamped || !named => continue,
            Fate::LeftOut(why) => {
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

/// Refuses comments that are rows in disguise where no stamp shows what is missing by them, and
/// tells of them where one does.
fn refuse_lost_rows(
    text: &[u8],
    marked: &dialect::Marked,
    layout: &Layout,
    time: &TimeSource,
    findings: &mut Vec<Finding>,
) -> Result<(), Error> {
    let (columns, _) = layout.widths();
    if let (1, Some(line)) = (columns, marked.hashes) {
        return Err(dialect::damaged_row(b"####").at(Place::default().line(line).column(1)));
    }
    let Some((count, line, followed)) =
        marked.rows_made_comments(text, layout.separator, layout.header_rows, columns)
    else {
        return Ok(());
    };
    if followed && matches!(time, TimeSource::Rate(_)) {
        return Err(Error::from(ErrorKind::Malformed {
            expected: "rows of samples without a break, since no column tells their time".into(),
            found: "a comment that holds as many numbers as a row".into(),
            hint: "take the # away if it is a sample, or the line if it is none".into(),
        })
        .at(Place::default().line(line)));
    }
    findings.push(Finding::warning(
        "rows-made-comments",
        format!(
            "{count} {} as many numbers as a row, the first on line {line}; samples may have been taken out by hand",
            if count == 1 { "comment holds" } else { "comments hold" }
        ),
    ));
    Ok(())
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
    layout: &Layout,
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
    if let (true, Some(stated)) = (rows.stamps_repeat, options.rate_hz) {
        return coarse_base(rows, name, SampleRate::from_hertz(stated)?);
    }
    let fitted = TimeBase::fit(&rows.stamps_s, rows.printed_digit_s, limits)
        .map_err(|error| at_longest_gap(error, text, rows, layout))?;
    let rate = fitted.rate.hertz();
    options.check_rate(
        rate,
        &format!("the time column `{name}`"),
        "state the setting `time_unit`, or leave out the rate",
    )?;
    if rate > INCREDIBLE && options.time_unit.is_none() && options.rate_hz.is_none() {
        return Err(Error::from(ErrorKind::Malformed {
            expected: "a time column of a rate that crash recordings have".into(),
            found: format!(
                "{rate} Hz by `{name}`{}",
                if unit_stated { "" } else { ", seconds assumed" }
            ),
            hint:
                "its unit is likely another than the header says; state it with the setting `time_unit` = s|ms|us"
                    .into(),
        })
        .at(Place::default().channel(name.clone())));
    }
    let (low, high) = if unit_stated {
        PLAUSIBLE_STATED
    } else {
        PLAUSIBLE_ASSUMED
    };
    if !(low..=high).contains(&rate) {
        findings.push(Finding::warning(
            "time-unit-implausible",
            format!(
                "the time column `{}` gives {rate} Hz, which no crash recording has; state its unit with the setting `time_unit` = s|ms|us",
                layout.columns[column].name
            ),
        ));
    }
    Ok(Base {
        start_s: fitted.start_s,
        rate: fitted.rate,
        findings: fitted.findings.clone(),
        fitted: Some(fitted),
    })
}

/// Finds the time base of stamps that repeat, since they have too few digits, at a stated rate:
/// each of them must be the instant of its row, to a printed digit.
fn coarse_base(rows: &Rows, name: &str, rate: SampleRate) -> Result<Base, Error> {
    let interval = rate.interval().seconds();
    let digit = rows.printed_digit_s;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut instant = 0.0;
    for stamp in &rows.stamps_s {
        let residual = stamp - instant * interval;
        instant += 1.0;
        low = low.min(residual);
        high = high.max(residual);
    }
    let slack = 1e-9 * digit + 8.0 * f64::EPSILON * (instant * interval);
    if high - low > digit + slack {
        return Err(Error::from(ErrorKind::Malformed {
            expected: format!(
                "stamps that follow {} Hz to a printed digit, as option or card say",
                rate.hertz()
            ),
            found: format!(
                "stamps of `{name}` that repeat and are off by up to {} s",
                crate::units::plain(high - low, 3)
            ),
            hint: "rows are doubled or missing, or the rate is another; export the stamps with more digits".into(),
        })
        .at(Place::default().channel(name.to_string())));
    }
    // Rounded stamps lie within half a digit of the clock on either side.
    let (earliest, latest) = (high - 0.5 * digit, low + 0.5 * digit);
    let start = |at: f64| {
        (earliest - slack..=latest + slack)
            .contains(&at)
            .then_some(at)
    };
    let first = rows.stamps_s[0];
    let start_s = start(first)
        .or_else(|| start((first / interval).round() * interval))
        .unwrap_or(0.5 * (low + high));
    Ok(Base {
        start_s,
        rate,
        findings: vec![Finding::warning(
            "stamps-coarse",
            format!(
                "the stamps of `{name}` have too few digits and repeat; the stated {} Hz was used, which they follow to a printed digit, so that the start is known to {} s",
                rate.hertz(),
                crate::units::plain(digit, 3)
            ),
        )],
        fitted: None,
    })
}

/// Says where the longest gap stands if filling the gaps takes more samples than allowed.
fn at_longest_gap(error: Error, text: &[u8], rows: &Rows, layout: &Layout) -> Error {
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

/// Returns the unit of a column, what states it, and a finding if option and file disagree.
fn unit_of(
    column: &header::Column,
    options: &ReadOptions,
) -> (Option<AccelerationUnit>, &'static str, Option<Finding>) {
    let Some(unit) = options.unit else {
        let source = if column.unit.is_some() {
            column.unit_source
        } else {
            "none"
        };
        return (column.unit, source, None);
    };
    let source = if options.unit_from_card {
        "card"
    } else {
        "option"
    };
    let finding = match &column.unit_text {
        Some(text) if column.unit != Some(unit) => Some(Finding::warning(
            "unit-overridden",
            format!(
                "the {} says `{text}` for `{}`, the {source} says `{}`, which was used",
                column.unit_source,
                column.name,
                unit.name()
            ),
        )),
        _ => None,
    };
    (Some(unit), source, finding)
}

/// Returns the line, counted from 1, in which the byte at `position` stands.
pub(super) fn line_at(text: &[u8], position: usize) -> u64 {
    let before = &text[..position.min(text.len())];
    memchr::memchr_iter(b'\n', before).count() as u64 + 1
}
