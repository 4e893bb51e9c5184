//! Comparison of the rows above the names with the samples and their clock.

use super::Preamble;
use super::row::{PreambleRow, PreambleTopic, measure};
use crate::Finding;
use crate::channel_name::filtered::{Filtered, filter_in};
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
    /// The sensitivity that a person states.
    pub(in crate::csv) sensitivity: Option<SensorSensitivity>,
}

impl Preamble {
    /// Returns the findings on a column: its rows, and contradictions of samples or options.
    pub(in crate::csv) fn findings(&self, index: usize, facts: &TableFacts) -> Vec<Finding> {
        let mut findings: Vec<Finding> = self.shown(index).into_iter().collect();
        for topic in [PreambleTopic::Rate, PreambleTopic::Interval] {
            for (row, text) in self.values_on(topic, index) {
                match row.rates(text) {
                    Some(rates) => findings.extend(row_finding(row, text, &rates, facts)),
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
        for row in &self.comments {
            let text = row.only().map_or("", String::as_str);
            let rates = row.rates(text).unwrap_or_default();
            let finding = row_finding(row, text, &rates, facts);
            findings
                .extend(finding.map(|finding| Finding::warning("rate-contradicted", finding.text)));
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
            let is_same = |text: &String| match row.rates(text).as_deref() {
                Some([rate]) => (rate / facts.rate.hertz() - 1.0).abs() <= SAME - 1.0,
                _ => false,
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
                (!is_near && off > NOMINAL).then_some(text)
            })
        })
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

/// Largest ratio of two rates that are the same, and of two that may be nominal and true one.
const SAME: f64 = 1.01;
const NOMINAL: f64 = 1.5;

/// Compares the rates [Hz] of a row with that of the samples.
fn row_finding(
    row: &PreambleRow,
    text: &str,
    rates: &[f64],
    facts: &TableFacts,
) -> Option<Finding> {
    let statement = format!("{} is `{}`", row.named(), shown(text));
    rate_finding(&statement, rates, (&facts.clock_name, facts.rate.hertz()))
}

/// Compares the rates [Hz] that `statement` may mean, as `SampleRate is 10000`, with that of the clock.
pub(crate) fn rate_finding(
    statement: &str,
    rates: &[f64],
    (clock_name, hertz): (&str, f64),
) -> Option<Finding> {
    let ratio = |rate: &f64| (rate / hertz).max(hertz / rate);
    let nearest = rates.iter().map(ratio).fold(f64::INFINITY, f64::min);
    let text = format!(
        "{statement}, but {clock_name} gives {} Hz. One of the two is wrong. Find out which is right",
        latchgate_kernel::units::short(hertz, 7)
    );
    (nearest > SAME).then(|| match nearest > NOMINAL {
        true => Finding::blocking("time-contradicted", text),
        false => Finding::warning("rate-contradicted", text),
    })
}

fn cut(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
