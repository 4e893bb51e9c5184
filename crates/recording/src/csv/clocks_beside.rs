//! Clocks beside the one that is used. A clock that contradicts it blocks: nothing shows which of the two
//! is right. Where a rate is stated, a column of words that change in each row is refused as a clock that
//! is not read: only it would show missing rows.

use super::clock;
use super::layout::{TableLayout, TimeSource};
use super::preamble::rates_under_name;
use super::records;
use super::stamp::StampClock;
use super::status;
use crate::error::{Error, Place};
use crate::examine::clock::{Comparison, Relation, UsedClock};
use crate::number::{self, Decimal, PrintedDigits};
use crate::text::{STAMPS, shown};
use crate::time_base::brief;
use crate::{Finding, ReadTask};
use latchgate_kernel::units::TimeUnit;

/// Share by which a factor may be off ten to be a slip by a decimal [-].
const DECIMAL: f64 = 0.05;

/// Share by which two clocks may differ and confirm one another, and by which steps may be off their mean
/// where a column rises evenly [-].
const ALIKE: f64 = 0.01;

/// Times the mean step beyond which one is a jump.
const JUMP: f64 = 3.0;

/// Result of the comparison of the table's clocks with the one that is used.
#[derive(Default)]
pub(super) struct ClockComparison {
    pub(super) findings: Vec<Finding>,
    /// The name of a clock that runs as the one that is used.
    pub(super) confirmed_by: Option<String>,
    /// Doubts for a person to weigh: a count that may be a clock, and then contradicts.
    pub(super) doubts: Vec<String>,
}

/// A table whose clocks are compared.
pub(super) struct Clocks<'a> {
    pub(super) text: &'a [u8],
    pub(super) layout: &'a TableLayout,
    /// The clock that is used.
    pub(super) time: &'a TimeSource,
    /// Columns of samples.
    pub(super) judged: &'a [usize],
    /// Time from row to row by the clock that is used [s].
    pub(super) interval_s: f64,
}

/// A clock beside the one that is used, as its cells are read.
struct ClockBeside {
    index: usize,
    words: Option<StampClock>,
    decimal: Decimal,
    digits: PrintedDigits,
    /// Row and value of the first and the last cell that was read.
    first: Option<(usize, f64)>,
    last: (usize, f64),
    longest_step: f64,
    shortest_step: f64,
    /// Sum and number of its steps forwards, and the rows that they take.
    rises: f64,
    rising_steps: usize,
    rising_rows: usize,
    /// The row of its last change, and the most rows for which it stood still.
    changed_row: usize,
    longest_stand: usize,
    /// True if it runs back somewhere, so that it is no clock.
    falls: bool,
}

impl ClockBeside {
    fn new(index: usize, worded: bool) -> Self {
        Self {
            index,
            words: worded.then(StampClock::default),
            decimal: Decimal::Unknown,
            digits: PrintedDigits::new(),
            first: None,
            last: (0, 0.0),
            longest_step: 0.0,
            shortest_step: f64::INFINITY,
            rises: 0.0,
            rising_steps: 0,
            rising_rows: 0,
            changed_row: 0,
            longest_stand: 0,
            falls: false,
        }
    }

    fn look(&mut self, row: usize, cell: &[u8]) {
        let value = match &mut self.words {
            Some(clock) => clock.read(cell, &mut self.decimal),
            None => number::parse(cell, &mut self.decimal).ok(),
        };
        let Some(value) = value else {
            return;
        };
        if self.words.is_none() {
            self.digits.count(cell);
        }
        if self.first.is_some() {
            let step = value - self.last.1;
            self.falls |= step < 0.0;
            self.longest_step = self.longest_step.max(step);
            self.shortest_step = self.shortest_step.min(step);
            if step > 0.0 {
                self.rises += step;
                self.rising_steps += 1;
                self.changed_row = row;
            }
            if step >= 0.0 {
                self.rising_rows += row - self.last.0;
            }
            self.longest_stand = self.longest_stand.max(row - self.changed_row);
        }
        self.first.get_or_insert((row, value));
        self.last = (row, value);
    }

    /// Returns the uncertainty of its span [in its unit]: its last digit, or its longest step where it does
    /// not change between updates; these may lie up to two such steps apart by the rows, `row` long. A step far
    /// beyond the others is a jump, and excuses nothing.
    fn resolution(&self, row: f64) -> f64 {
        let usual = self.rises / self.rising_steps.max(1) as f64;
        let longest = self.longest_step.min(JUMP * usual);
        let digit = match &self.words {
            Some(clock) => clock.last_digit(),
            None => self.digits.last_digit(),
        };
        let stand = row * self.longest_stand as f64;
        let apart = stand.min(2.0 * longest);
        digit.max(longest).max(apart)
    }

    /// True if it rises by like steps in every row, to its last digit.
    fn is_even(&self) -> bool {
        let digit = self.digits.last_digit();
        let slack = ALIKE * self.longest_step + 1.001 * digit;
        self.shortest_step > 0.0 && self.longest_step - self.shortest_step <= slack
    }

    /// True if it holds one number in all rows.
    fn is_constant(&self) -> bool {
        !self.falls && self.longest_step <= 0.0 && self.words.is_none()
    }
}

impl Clocks<'_> {
    /// Compares the clocks of the table with the one that is used; `instant` is the time of a row by that
    /// one [s].
    pub(super) fn compare(
        &self,
        instant: impl Fn(usize) -> Option<f64>,
        task: ReadTask,
    ) -> Result<ClockComparison, Error> {
        let mut comparison = ClockComparison::default();
        let candidates = (0..self.layout.columns.len()).filter(|index| self.is_candidate(*index));
        let mut clocks: Vec<ClockBeside> = candidates
            .map(|index| ClockBeside::new(index, self.layout.worded[index]))
            .collect();
        if clocks.is_empty() {
            return Ok(comparison);
        }
        let mut records = self.layout.records(self.text, task.limits)?;
        let mut number = 0;
        while let Some(row) = records.next()? {
            for clock in &mut clocks {
                clock.look(number, row.get(clock.index).unwrap_or_default());
            }
            number += 1;
        }
        let span = |clock: &ClockBeside| {
            let from = instant(clock.first?.0)?;
            Some((instant(clock.last.0).or_else(|| instant(number - 1))? - from).abs())
        };
        for clock in &clocks {
            if clock.falls {
                self.compare_falling(clock, task.options.rate_hz, &mut comparison);
            } else if clock.is_constant() {
                if let Some(found) = self.rate_comparison(clock, task.options.rate_hz) {
                    found.tell(&mut comparison.findings, &mut comparison.doubts);
                }
            } else if let Some(used_s) = span(clock) {
                self.compare_span(clock, used_s, task.options.rate_hz, &mut comparison);
            }
        }
        Ok(comparison)
    }

    /// Compares a named clock that runs back somewhere, as one that wraps, restarts or has a faulty cell. It confirms
    /// nothing; it contradicts where neither its steps forwards nor its whole span fit.
    fn compare_falling(
        &self,
        clock: &ClockBeside,
        stated_hz: Option<f64>,
        comparison: &mut ClockComparison,
    ) {
        let layout = self.layout;
        let is_named = layout.is_named_clock(clock.index) || layout.is_other_clock(clock.index);
        let Some((first_row, first)) = clock.first.filter(|_| is_named) else {
            return;
        };
        let (rows, rising_rows) = (clock.last.0 - first_row, clock.rising_rows);
        let step = clock.rises / rising_rows as f64;
        let Some(unit_s) = self.known_unit_s(clock, first, step) else {
            return;
        };
        // Mostly forwards, or it is no clock.
        if 10 * rising_rows < 9 * rows || clock.rises <= 0.0 {
            return;
        }
        let whole = (clock.last.1 - first) / rows as f64;
        let allowed_s = clock.resolution(self.interval_s / unit_s) * unit_s / rows as f64;
        let fits = |step: f64| {
            let (step_s, used_s) = (step * unit_s, self.interval_s);
            let nearest_s = used_s.clamp(step_s - allowed_s, step_s + allowed_s);
            Relation::between(used_s, nearest_s, 0.0) != Relation::Contradicted
        };
        if fits(step) || fits(whole) {
            return;
        }
        let text = format!(
            "`{}` runs back in places and else at {} Hz, but {} gives {} Hz",
            layout.columns[clock.index].name,
            brief(1.0 / (step * unit_s)),
            self.used(),
            brief(1.0 / self.interval_s)
        );
        let used = UsedClock {
            name: &self.used(),
            hertz: 1.0 / self.interval_s,
            stated_hz,
        };
        let outcome = used.outcome(Relation::Contradicted, &text);
        outcome.tell(&mut comparison.findings, &mut comparison.doubts);
    }

    /// Compares a column that states the rate, or the time from sample to sample, in every row.
    fn rate_comparison(&self, clock: &ClockBeside, stated_hz: Option<f64>) -> Option<Comparison> {
        let column = &self.layout.columns[clock.index];
        let number = clock.first?.1;
        let rate = rates_under_name(&column.name, &number.to_string())?;
        let rate = rate.written_to(clock.digits.last_digit(), number);
        let said = format!("`{}` is {} in every row", column.name, brief(clock.last.1));
        let used = UsedClock {
            name: &self.used(),
            hertz: 1.0 / self.interval_s,
            stated_hz,
        };
        Some(used.compare(&said, &rate))
    }

    /// Names the clock that is used in a message.
    fn used(&self) -> String {
        match self.time.column() {
            Some(used) => format!("`{}`", self.layout.columns[used].name),
            None => "the stated rate".into(),
        }
    }

    /// True if a column may be a clock that runs with the one that is used.
    fn is_candidate(&self, index: usize) -> bool {
        let layout = self.layout;
        let column = &layout.columns[index];
        // Where every channel is read, clocks are among the judged columns.
        let free = Some(index) != self.time.column() && self.judged != [index];
        let rises = layout.steps[index].is_some() && column.unit_text.is_none();
        let clock = layout.is_named_clock(index) || layout.is_other_clock(index);
        let states_rate = || rates_under_name(&column.name, "1").is_some();
        let counts =
            layout.numeric[index] && (rises || column.counts_at_hz().is_some() || states_rate());
        free && (layout.worded[index] || clock || counts) && !self.belongs_to_others(index)
    }

    /// True if a column of times is the clock of other channels: the table is one of pairs, each
    /// clock with its channels to the right, and the judged ones are not among them.
    fn belongs_to_others(&self, index: usize) -> bool {
        let layout = self.layout;
        let is_clock = |i: usize| layout.is_named_clock(i) || Some(i) == self.time.column();
        let has_channels = |i: usize| {
            let next = i + 1;
            next < layout.columns.len()
                && layout.numeric[next]
                && !is_clock(next)
                && !layout.is_index(next)
        };
        let Some(used) = self.time.column() else {
            return false;
        };
        let pairs =
            is_clock(index) && has_channels(index) && has_channels(used) && !layout.worded[used];
        let has_other_clock =
            |judged: &usize| (0..*judged).rev().find(|i| is_clock(*i)) != Some(index);
        pairs && (self.judged.len() > 1 || self.judged.iter().all(has_other_clock))
    }

    /// Compares a clock with the one that is used, which spans `used_s` [s] over the same rows.
    fn compare_span(
        &self,
        clock: &ClockBeside,
        used_s: f64,
        stated_hz: Option<f64>,
        comparison: &mut ClockComparison,
    ) {
        let column = &self.layout.columns[clock.index];
        let Some((first_row, first)) = clock.first else {
            return;
        };
        let span = clock.last.1 - first;
        let step = span / (clock.last.0 - first_row) as f64;
        let known_unit = self.known_unit_s(clock, first, step);
        let resolution = clock.resolution(self.interval_s / known_unit.unwrap_or(1.0));
        if span <= 0.0 && (clock.words.is_none() || resolution < 1.0) {
            // A constant is a number of the recording, or a stamp of its begin.
            return;
        }
        // A column that nothing names and that rises as the seconds of a recorder do.
        let is_index = self.layout.is_unnamed(clock.index) && clock.is_even();
        let in_seconds = is_index && clock::is_fractional(step) && clock::is_recorder_step(step);
        let unit = known_unit.or(in_seconds.then_some(1.0));
        let is_even = clock.is_even() && !column.hints_at_acceleration();
        let named =
            self.layout.is_named_clock(clock.index) || self.layout.is_other_clock(clock.index);
        let slips = span > 20.0 * resolution && is_slip_by_ten(span / used_s);
        let is_count = self.layout.is_unnamed(clock.index) && !clock::is_fractional(step);
        let text = format!(
            "`{}` spans {}{}, but {} {} s over the same rows",
            column.name,
            brief(span * unit.unwrap_or(1.0)),
            if unit.is_some() { " s" } else { "" },
            self.used(),
            brief(used_s)
        );
        let relation = match unit {
            Some(unit_s) => {
                let (span_s, slack_s) = (span * unit_s, resolution * unit_s);
                // A clock of few digits contradicts no more than they show, and confirms nothing.
                let nearest_s = used_s.max(span_s - slack_s).min(span_s + slack_s);
                let is_apart = (used_s - nearest_s).abs() > self.interval_s;
                // A unit that is assumed may be as wrong as that of the clock it was copied from.
                let is_fine = known_unit.is_some() && slack_s <= ALIKE * used_s;
                match Relation::between(used_s, nearest_s, 0.0) {
                    Relation::Contradicted if is_apart => Relation::Contradicted,
                    Relation::Silent if is_fine && is_apart => Relation::Silent,
                    Relation::Confirmed if is_fine => {
                        comparison.confirmed_by = Some(format!("`{}`", column.name));
                        return;
                    }
                    _ => return,
                }
            }
            // Without a unit, any power of a thousand may be meant, but not ten or a hundred. Steps of 1 count
            // the rows.
            None if slips && (named || is_even) && (step - 1.0).abs() > ALIKE => {
                if is_count {
                    // As pandas leaves its index where it keeps every tenth row.
                    comparison.doubts.push(text);
                    return;
                }
                Relation::Contradicted
            }
            None => return,
        };
        if relation == Relation::Contradicted && self.time.column().is_none() {
            // A whole column of times is the better witness: a rate that slipped is the likelier fault.
            let text = format!(
                "{text}. Check the rate, or choose the column with the setting `time_column`"
            );
            let finding = Finding::blocking("time-contradicted", text);
            comparison.findings.push(finding);
            return;
        }
        let used = UsedClock {
            name: &self.used(),
            hertz: 1.0 / self.interval_s,
            stated_hz,
        };
        let ClockComparison {
            findings, doubts, ..
        } = comparison;
        used.outcome(relation, &text).tell(findings, doubts);
    }

    /// Returns the unit of a clock [s], by its cells, head or name, or by its size.
    fn known_unit_s(&self, clock: &ClockBeside, first: f64, step: f64) -> Option<f64> {
        let column = &self.layout.columns[clock.index];
        let stated = match (&clock.words, column.time_unit, column.counts_at_hz()) {
            (Some(_), ..) => return Some(1.0),
            (None, Some(unit), _) => return Some(unit.seconds()),
            (None, None, Some(hertz)) => return Some(1.0 / hertz),
            (None, None, None) => column.time_unit_of_name(),
        };
        stated
            .or_else(|| clock::absolute_clock(first, 1.0 / step))
            .map(TimeUnit::seconds)
    }
}

/// True if two clocks differ by ten or a hundred, whatever thousands lie between their units.
fn is_slip_by_ten(mut ratio: f64) -> bool {
    if !(ratio.is_finite() && ratio > 0.0) {
        return false;
    }
    while ratio > 31.6 {
        ratio /= 1e3;
    }
    while ratio < 0.0316 {
        ratio *= 1e3;
    }
    let near = |factor: f64| (ratio / factor - 1.0).abs() <= DECIMAL;
    near(10.0) || near(0.1)
}

/// Refuses a column of words that is an unread clock, where only a rate gives the time.
pub(super) fn refuse_unread(
    text: &[u8],
    layout: &TableLayout,
    time: &TimeSource,
    judged: &[usize],
    task: ReadTask,
) -> Result<(), Error> {
    if time.column().is_some() {
        return Ok(());
    }
    let may_be_clock = |index: &usize| {
        let column = &layout.columns[*index];
        let first = *index == 0 && layout.columns.len() > 1 && column.unit_text.is_none();
        (column.says_time()
            || column.says_other_clock()
            || (first && !column.hints_at_acceleration()))
            && !(layout.numeric[*index] || layout.worded[*index] || judged.contains(index))
            && !status::is_of_words(column)
    };
    for index in (0..layout.columns.len()).filter(may_be_clock) {
        let mut records = layout.records(text, task.limits)?;
        let mut words = WordClock::default();
        while let Some(row) = records.next()? {
            words.look(row.get(index).unwrap_or_default(), || {
                records::line_of(text, row)
            });
        }
        let column = &layout.columns[index];
        let named = column.says_time() || column.says_other_clock();
        if let Some((line, cell)) = words.changing(named) {
            let error = Error::malformed(
                "times that latchgate reads, since a rate alone shows no missing row",
                format!(
                    "`{cell}` in `{}`, and the like in the rows beside",
                    column.name
                ),
                STAMPS,
            );
            return Err(error.at(Place::default().line(line).column(index as u64 + 1)));
        }
    }
    Ok(())
}

/// A column of words that may be a clock, as its cells are read.
#[derive(Default)]
struct WordClock {
    rows: usize,
    /// Rows that differ from the one before, digits being in both.
    changes: usize,
    /// The second of the first two that differ.
    changed: Option<(u64, String)>,
    last: Vec<u8>,
    /// Numbers of labels such as `S0001`; `None` once a cell is none.
    labels: Option<Vec<f64>>,
}

impl WordClock {
    fn look(&mut self, cell: &[u8], line: impl FnOnce() -> u64) {
        let has_digit = |text: &[u8]| text.iter().any(u8::is_ascii_digit);
        if has_digit(&self.last) && has_digit(cell) && self.last != cell {
            self.changes += 1;
            if self.changed.is_none() {
                self.changed = Some((line(), shown(cell)));
            }
        }
        let label = label_number(cell);
        self.labels = match (self.labels.take(), label, self.rows) {
            (_, Some(number), 0) => Some(vec![number]),
            (Some(mut numbers), Some(number), _) => {
                numbers.push(number);
                Some(numbers)
            }
            _ => None,
        };
        self.rows += 1;
        self.last.clear();
        self.last.extend_from_slice(cell);
    }

    /// Returns the place where the column changes, if it does as a clock; one with no name for time
    /// changes in most rows, and not by one label after the other.
    fn changing(self, named: bool) -> Option<(u64, String)> {
        let counts = |numbers: &Vec<f64>| {
            let steps = numbers.windows(2).map(|pair| pair[1] - pair[0]);
            numbers.len() > 1 && steps.clone().all(|step| step.total_cmp(&1.0).is_eq())
        };
        let labels = self.labels.as_ref().is_some_and(counts);
        let mostly = 2 * self.changes >= self.rows.saturating_sub(1);
        self.changed.filter(|_| named || (mostly && !labels))
    }
}

/// Returns the number of a label: letters with one whole number after them.
fn label_number(cell: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    let name = text.trim_end_matches(|c: char| c.is_ascii_digit());
    let plain = !name.contains(|c: char| c.is_ascii_digit() || ".,:".contains(c));
    text[name.len()..].parse().ok().filter(|_| plain)
}
