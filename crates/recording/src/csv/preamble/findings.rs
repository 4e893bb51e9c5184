//! Comparison of the rows above the names with the samples and their clock.

use super::row::{PreambleRow, PreambleTopic, measure};
use super::{Preamble, WordedLine};
use crate::Finding;
use crate::channel_name::filtered::{Filtered, filter_in};
use crate::examine::clock::{Comparison, RateStatement, Relation, UsedClock};
use crate::held;
use crate::setting::Setting;
use crate::text::shown;
use latchgate_kernel::units::{SampleRate, SensorSensitivity};

/// Facts of the samples and their clock, with which the preamble is compared.
#[derive(Debug, Clone)]
pub(in crate::csv) struct TableFacts {
    pub(in crate::csv) rate: SampleRate,
    /// Name of the clock in a message.
    pub(in crate::csv) clock_name: String,
    /// Time of the first sample, and of the last one, on the file's clock [s].
    pub(in crate::csv) start_s: f64,
    pub(in crate::csv) end_s: f64,
    /// Number of rows, if all of them were read; and true if each has a stamp.
    pub(in crate::csv) samples: Option<usize>,
    pub(in crate::csv) is_stamped: bool,
    /// The instant on the file's clock that a person states as time zero [s].
    pub(in crate::csv) zero_s: Option<f64>,
    /// The rate that a person states [Hz].
    pub(in crate::csv) stated_hz: Option<f64>,
    /// The sensitivity that a person states.
    pub(in crate::csv) sensitivity: Option<SensorSensitivity>,
}

impl TableFacts {
    fn used_clock(&self) -> UsedClock<'_> {
        UsedClock {
            name: &self.clock_name,
            hertz: self.rate.hertz(),
            stated_hz: self.stated_hz,
        }
    }
}

impl Preamble {
    /// Returns the findings on a column: its rows, and contradictions of samples or options. What a person must
    /// accept of the clock joins `doubts`.
    pub(in crate::csv) fn findings(
        &self,
        index: usize,
        facts: &TableFacts,
        doubts: &mut Vec<String>,
    ) -> Vec<Finding> {
        let mut findings: Vec<Finding> = self.shown(index).into_iter().collect();
        for topic in [PreambleTopic::Rate, PreambleTopic::Interval] {
            for (row, text) in self.values_on(topic, index) {
                match row.rate_statement(text) {
                    Some(rate) => {
                        let comparison = row_comparison(row, text, &rate, facts);
                        comparison.tell(&mut findings, doubts);
                    }
                    None => findings.push(row.statement(text).unread()),
                }
            }
        }
        for (row, text) in self.values_on(PreambleTopic::Class, index) {
            let read = filter_in(&format!("class {text}"));
            match read {
                Some(Filtered::Class(_)) => {}
                Some(Filtered::Unclassed) if row.corner_hz(text).is_none() => {
                    let reason = format!("{} is `{}`, without its class", row.named(), shown(text));
                    findings.push(Finding::filtered(&reason));
                }
                _ if row.corner_hz(text).is_none() => findings.push(row.statement(text).unread()),
                _ => {}
            }
        }
        for line in &self.worded {
            worded_comparison(line, facts, &mut findings, doubts);
        }
        findings.extend(self.sensitivity_finding(index, facts));
        findings.extend(self.zero_finding(facts));
        findings.extend(self.count_finding(index, facts));
        findings
    }

    /// Returns the name of the row that states the rate with its unit, where the stamps give the same.
    pub(in crate::csv) fn confirms(&self, facts: &TableFacts) -> Option<String> {
        let rows = [PreambleTopic::Rate, PreambleTopic::Interval].map(|topic| self.rows_on(topic));
        let agrees = |row: &&PreambleRow| {
            let mut filled = row.values.iter().filter(|text| !text.is_empty()).peekable();
            let is_same = |text: &String| {
                let rate = row
                    .rate_statement(text)
                    .filter(|rate| rate.rates().len() == 1);
                rate.is_some_and(|rate| rate.relation(facts.rate.hertz()) == Relation::Confirmed)
            };
            filled.peek().is_some() && filled.all(is_same)
        };
        let row = rows.into_iter().flatten().find(agrees);
        row.filter(|_| facts.is_stamped).map(PreambleRow::named)
    }

    /// Returns a doubt where the stated begin, end or length is not that of the samples. The table may be a
    /// part of what was recorded, so that the difference proves nothing.
    pub(in crate::csv) fn span_doubt(&self, facts: &TableFacts) -> Option<String> {
        let length_s = facts.end_s - facts.start_s;
        if let Some(doubt) = self.ends_doubt(facts).filter(|_| !facts.is_stamped) {
            return Some(doubt);
        }
        let measured = [
            (PreambleTopic::Start, facts.start_s),
            (PreambleTopic::End, facts.end_s),
            (PreambleTopic::Duration, length_s),
        ];
        measured.into_iter().find_map(|(topic, measured_s)| {
            self.rows_on(topic).find_map(|row| {
                let text = row.values.iter().find(|text| !text.is_empty())?;
                let stated_s = row.seconds(text)?;
                let is_near = (stated_s - measured_s).abs() <= 0.05 * length_s;
                // A zero may be another one.
                // Two zeros may be on different clocks, so a zero counts as no nearer than the ratio below.
                let ratio = (stated_s / measured_s).abs();
                let off = if stated_s * measured_s == 0.0 {
                    1.0
                } else {
                    ratio.max(1.0 / ratio)
                };
                let text = format!(
                    "{} is `{}`, but by {} it is {} s",
                    row.named(),
                    shown(text),
                    facts.clock_name,
                    latchgate_kernel::units::short(measured_s, 7)
                );
                (!is_near && off > OF_A_PART).then_some(text)
            })
        })
    }

    /// Returns a doubt where a start and an end without units are those of no rate near the stated one.
    fn ends_doubt(&self, facts: &TableFacts) -> Option<String> {
        let bare = |topic| {
            self.rows_on(topic).find_map(|row| {
                let (number, unit) = measure(row.only()?)?;
                unit.is_empty().then_some((row, number))
            })
        };
        let (first_row, start) = bare(PreambleTopic::Start)?;
        let (last_row, end) = bare(PreambleTopic::End)?;
        let steps = facts.samples?.saturating_sub(1) as f64;
        // Some count the time after the last sample as well.
        let rates = [steps, steps + 1.0].map(|steps| steps / (end - start));
        let rates = rates
            .iter()
            .flat_map(|rate| [1.0, 1e3, 1e6].map(|factor| rate * factor));
        let rates: Vec<f64> = rates.filter(|rate| *rate > 0.0).collect();
        let rate = RateStatement::of(rates, "");
        let said = format!(
            "{} and {} are {start} and {end}",
            first_row.named(),
            last_row.named()
        );
        let (difference, relation) = facts.used_clock().difference(&said, &rate);
        (relation == Relation::Contradicted).then_some(difference)
    }

    /// Returns the finding that shows the rows on a column.
    fn shown(&self, index: usize) -> Option<Finding> {
        let rows = self.rows.iter().filter(|row| !row.key.is_empty());
        // Titles alone do not concern the columns.
        if !rows.clone().any(|row| row.value(index).is_some()) {
            return None;
        }
        let statements: Vec<String> = rows
            .filter_map(|row| match row.value(index) {
                Some(value) => Some(format!("{}: {value}", row.key)),
                None => row
                    .values
                    .iter()
                    .all(String::is_empty)
                    .then(|| row.key.clone()),
            })
            .collect();
        let intro = self.found_header.map_or(String::new(), |line| {
            format!("the columns are named on line {line}. ")
        });
        let text = format!(
            "{intro}The rows above say of this channel: {}",
            cut(&statements.join("; "))
        );
        Some(Finding::info("preamble", text))
    }

    /// Compares the sensor's sensitivity with the stated one; an amplifier may be between them.
    fn sensitivity_finding(&self, index: usize, facts: &TableFacts) -> Option<Finding> {
        let used = facts.sensitivity.as_ref()?;
        self.values_on(PreambleTopic::Sensitivity, index).find_map(|(row, text)| {
            let with_unit = format!("{text} {}", row.unit());
            let texts = [text, &with_unit];
            let stated = texts.iter().find_map(|text| SensorSensitivity::from_text(text).ok())?;
            let si = |sensitivity: &SensorSensitivity| sensitivity.unit().metres_per_second_squared();
            let stated_si = stated.scale_of(used.quantity())? * si(&stated);
            let ratio = stated_si / (used.scale() * si(used));
            let text = format!(
                "{} is `{}`, but {used} was stated and used. Check that an amplifier between them \
                 makes the factor of {}",
                row.named(),
                shown(text),
                latchgate_kernel::units::short(ratio, 3)
            );
            ((ratio - 1.0).abs() > 0.02).then(|| Finding::warning("unit-overridden", text))
        })
    }

    /// Compares the samples before time zero with the clock.
    fn zero_finding(&self, facts: &TableFacts) -> Option<Finding> {
        let (row, before) = self.samples_before_zero(facts.rate)?;
        let interval_s = facts.rate.interval().seconds();
        let stated_s = facts.start_s + before * interval_s;
        let zero_s = facts.zero_s.unwrap_or(0.0);
        let text = format!(
            "{} puts time zero at {} s on the file's clock, but it is at {zero_s} s. State the \
             right one with {} = S",
            row.named(),
            latchgate_kernel::units::short(stated_s, 7),
            Setting::TimeZero
        );
        let differs = (stated_s - zero_s).abs() > 1.5 * interval_s;
        // The stated time zero counts, so that the difference only warns.
        differs.then(|| match facts.zero_s {
            Some(_) => Finding::warning("time-zero-contradicted", text),
            None => Finding::blocking("time-contradicted", text),
        })
    }

    /// Compares the stated numbers of samples with the rows.
    fn count_finding(&self, index: usize, facts: &TableFacts) -> Option<Finding> {
        let row_count = facts.samples?;
        let number = |topic| {
            let mut values = self.values_on(topic, index);
            values.find_map(|(row, text)| {
                Some((
                    row,
                    measure(text).filter(|measured| measured.1.is_empty())?.0,
                ))
            })
        };
        let (row, stated) = number(PreambleTopic::Count).or_else(|| {
            let (row, before) = number(PreambleTopic::Before)?;
            let total = before + number(PreambleTopic::After)?.1;
            // Laboratories count the sample at time zero twice, once or not at all.
            let count = row_count as f64;
            Some((
                row,
                if (total - count).abs() <= 1.0 {
                    count
                } else {
                    total
                },
            ))
        })?;
        let (is_stamped, end_s) = (facts.is_stamped, facts.end_s);
        held::count(&row.named(), stated, row_count, is_stamped, end_s)
    }
}

/// Most characters of a list of rows that are shown.
const SHOWN: usize = 600;

/// Ratio up to which a stated begin, end or length may be that of a part of the record.
const OF_A_PART: f64 = 1.5;

/// Compares what a line states in words. It may speak of another clock than the table's: where each sample has a
/// stamp, a difference is told if a word says that the clock is that of samples; where none has, a person weighs
/// each that contradicts.
fn worded_comparison(
    line: &WordedLine,
    facts: &TableFacts,
    findings: &mut Vec<Finding>,
    doubts: &mut Vec<String>,
) {
    for clock in &line.clocks {
        let (difference, relation) = facts.used_clock().difference(&line.said, &clock.rate);
        match relation {
            Relation::Confirmed => {}
            Relation::Contradicted if !facts.is_stamped => doubts.push(difference),
            Relation::Silent | Relation::Contradicted if clock.is_named && clock.has_unit => {
                let text = format!("{difference}. Check the clock");
                findings.push(Finding::warning("time-differs", text));
            }
            Relation::Silent | Relation::Contradicted => {}
        }
    }
}

/// Compares the rate that a row states with that of the samples.
fn row_comparison(
    row: &PreambleRow,
    text: &str,
    rate: &RateStatement,
    facts: &TableFacts,
) -> Comparison {
    let said = format!("{} is `{}`", row.named(), shown(text));
    facts.used_clock().compare(&said, rate)
}

fn cut(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
