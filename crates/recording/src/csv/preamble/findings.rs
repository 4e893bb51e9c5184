//! What the rows above the names say, held against the samples and their clock.

use super::Preamble;
use super::row::{PreambleRow, PreambleTopic, measure};
use crate::Finding;
use crate::channel_name::filtered::{Filtered, filter_in};
use crate::held;
use crate::setting::Setting;
use crate::text::shown;
use latchgate_kernel::units::{SampleRate, SensorSensitivity};

/// What the samples and their clock are, for what is said above the table to be held against them.
#[derive(Debug, Clone)]
pub(in crate::csv) struct HeldAgainst {
    pub(in crate::csv) rate: SampleRate,
    /// What gives the rate, in a message.
    pub(in crate::csv) by: String,
    /// Time of the first sample, and of the last one, on the file's clock [s].
    pub(in crate::csv) start_s: f64,
    pub(in crate::csv) end_s: f64,
    /// Rows, if all of them were read, and whether each has a stamp.
    pub(in crate::csv) samples: Option<usize>,
    pub(in crate::csv) is_stamped: bool,
    /// The instant on the file's clock that a person states as time zero [s].
    pub(in crate::csv) zero_s: Option<f64>,
    /// What a person says that one of the samples means.
    pub(in crate::csv) sensitivity: Option<SensorSensitivity>,
}

impl Preamble {
    /// Says what is stated of a column, and where the samples or options contradict it.
    pub(in crate::csv) fn findings(&self, index: usize, samples: &HeldAgainst) -> Vec<Finding> {
        let mut findings: Vec<Finding> = self.shown(index).into_iter().collect();
        for topic in [PreambleTopic::Rate, PreambleTopic::Interval] {
            for (row, text) in self.said(topic, index) {
                match row.rates(text) {
                    Some(rates) => findings.extend(rate_finding(row, text, &rates, samples)),
                    None => findings.push(row.statement(text).unread()),
                }
            }
        }
        for (row, text) in self.said(PreambleTopic::Class, index) {
            let read = filter_in(&format!("class {text}"));
            match read {
                Some(Filtered::Class(_)) => {}
                Some(Filtered::Unclassed) if row.corner_hz(text).is_none() => {
                    let by = format!("{} is `{}`, without its class", row.named(), shown(text));
                    findings.push(Finding::filtered(&by));
                }
                _ if row.corner_hz(text).is_none() => findings.push(row.statement(text).unread()),
                _ => {}
            }
        }
        for row in &self.comments {
            let text = row.only().map_or("", String::as_str);
            let rates = row.rates(text).unwrap_or_default();
            let finding = rate_finding(row, text, &rates, samples);
            findings.extend(finding.map(|one| Finding::warning("rate-contradicted", one.text)));
        }
        findings.extend(self.sensitivity_finding(index, samples));
        findings.extend(self.zero_finding(samples));
        findings.extend(self.count_finding(index, samples));
        findings
    }

    /// Names the row that states the rate with its unit, where the stamps give the same.
    pub(in crate::csv) fn confirms(&self, samples: &HeldAgainst) -> Option<String> {
        let rows = [PreambleTopic::Rate, PreambleTopic::Interval].map(|topic| self.of(topic));
        let agrees = |row: &&PreambleRow| {
            let mut filled = row.values.iter().filter(|text| !text.is_empty()).peekable();
            let is_same = |text: &String| match row.rates(text).as_deref() {
                Some([rate]) => (rate / samples.rate.hertz() - 1.0).abs() <= SAME - 1.0,
                _ => false,
            };
            filled.peek().is_some() && filled.all(is_same)
        };
        let row = rows.into_iter().flatten().find(agrees);
        row.filter(|_| samples.is_stamped).map(PreambleRow::named)
    }

    /// Says where begin, end or length that are stated are not those of the samples. The table may be a part of
    /// what was recorded, so that it proves nothing.
    pub(in crate::csv) fn span_doubt(&self, samples: &HeldAgainst) -> Option<String> {
        let length_s = samples.end_s - samples.start_s;
        let found = [
            (PreambleTopic::Start, samples.start_s),
            (PreambleTopic::End, samples.end_s),
            (PreambleTopic::Duration, length_s),
        ];
        found.into_iter().find_map(|(topic, found_s)| {
            self.of(topic).find_map(|row| {
                let text = row.values.iter().find(|text| !text.is_empty())?;
                let stated_s = row.seconds(text)?;
                let is_near = (stated_s - found_s).abs() <= 0.05 * length_s;
                // A zero may be another one.
                let ratio = (stated_s / found_s).abs();
                let off = if stated_s * found_s == 0.0 {
                    1.0
                } else {
                    ratio.max(1.0 / ratio)
                };
                let text = format!(
                    "{} is `{}`, but by {} it is {} s",
                    row.named(),
                    shown(text),
                    samples.by,
                    latchgate_kernel::units::short(found_s, 7)
                );
                (!is_near && off > NOMINAL).then_some(text)
            })
        })
    }

    /// Shows the rows that speak of a column.
    fn shown(&self, index: usize) -> Option<Finding> {
        let rows = self.rows.iter().filter(|row| !row.key.is_empty());
        // Titles alone say nothing of the columns.
        if !rows.clone().any(|row| row.value(index).is_some()) {
            return None;
        }
        let said: Vec<String> = rows
            .filter_map(|row| match row.value(index) {
                Some(value) => Some(format!("{}: {value}", row.key)),
                None => row
                    .values
                    .iter()
                    .all(String::is_empty)
                    .then(|| row.key.clone()),
            })
            .collect();
        let found = self.found.map_or(String::new(), |line| {
            format!("the columns are named on line {line}. ")
        });
        let text = format!(
            "{found}The rows above say of this channel: {}",
            cut(&said.join("; "))
        );
        Some(Finding::info("preamble", text))
    }

    /// Holds the sensor's sensitivity against what a person says; an amplifier may lie between them.
    fn sensitivity_finding(&self, index: usize, samples: &HeldAgainst) -> Option<Finding> {
        let used = samples.sensitivity.as_ref()?;
        self.said(PreambleTopic::Sensitivity, index).find_map(|(row, text)| {
            let with_unit = format!("{text} {}", row.unit());
            let texts = [text, &with_unit];
            let stated = texts.iter().find_map(|text| SensorSensitivity::from_text(text).ok())?;
            let si = |one: &SensorSensitivity| one.unit().metres_per_second_squared();
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

    /// Holds the samples before time zero against the clock.
    fn zero_finding(&self, samples: &HeldAgainst) -> Option<Finding> {
        let (row, before) = self.before(samples.rate)?;
        let interval_s = samples.rate.interval().seconds();
        let stated_s = samples.start_s + before * interval_s;
        let zero_s = samples.zero_s.unwrap_or(0.0);
        let text = format!(
            "{} puts time zero at {} s on the file's clock, but it is at {zero_s} s. State the \
             right one with {} = S",
            row.named(),
            latchgate_kernel::units::short(stated_s, 7),
            Setting::TimeZero
        );
        let differs = (stated_s - zero_s).abs() > 1.5 * interval_s;
        // A person's word decides.
        differs.then(|| match samples.zero_s {
            Some(_) => Finding::warning("time-zero-contradicted", text),
            None => Finding::blocking("time-contradicted", text),
        })
    }

    /// Holds numbers of samples against the rows.
    fn count_finding(&self, index: usize, samples: &HeldAgainst) -> Option<Finding> {
        let found = samples.samples?;
        let number = |topic| {
            let mut said = self.said(topic, index);
            said.find_map(|(row, text)| {
                Some((row, measure(text).filter(|one| one.1.is_empty())?.0))
            })
        };
        let (row, stated) = number(PreambleTopic::Count).or_else(|| {
            let (row, before) = number(PreambleTopic::Before)?;
            let all = before + number(PreambleTopic::After)?.1;
            // Whether the sample at time zero is counted twice, once or not at all is a custom.
            let count = found as f64;
            Some((
                row,
                if (all - count).abs() <= 1.0 {
                    count
                } else {
                    all
                },
            ))
        })?;
        let (is_stamped, end_s) = (samples.is_stamped, samples.end_s);
        held::count(&row.named(), stated, found, is_stamped, end_s)
    }
}

/// Letters of a list of rows that are shown.
const SHOWN: usize = 600;

/// Largest ratio of two rates that are one, and of two that may be the nominal and the true one.
const SAME: f64 = 1.01;
const NOMINAL: f64 = 1.5;

/// Holds a stated rate against the one of the samples.
fn rate_finding(
    row: &PreambleRow,
    text: &str,
    rates: &[f64],
    samples: &HeldAgainst,
) -> Option<Finding> {
    let ratio = |rate: &f64| (rate / samples.rate.hertz()).max(samples.rate.hertz() / rate);
    let nearest = rates.iter().map(ratio).fold(f64::INFINITY, f64::min);
    let text = format!(
        "{} is `{}`, but {} gives {} Hz. One of the two is wrong. Find out which is right",
        row.named(),
        shown(text),
        samples.by,
        latchgate_kernel::units::short(samples.rate.hertz(), 7)
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
