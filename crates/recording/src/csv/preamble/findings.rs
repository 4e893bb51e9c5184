//! What the rows above the names say, held against the samples and their clock.

use super::Preamble;
use super::row::{PreambleRow, PreambleTopic, measure};
use crate::Finding;
use crate::csv::header::filtered::{Filtered, filter_in};
use crate::held;
use crate::setting::Setting;
use crate::text::shown;
use latchgate_kernel::units::SampleRate;

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
                    let by = format!("{} is `{}`, not with which class", row.named(), shown(text));
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
        findings.extend(self.zero_finding(samples));
        findings.extend(self.count_finding(index, samples));
        findings
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
            format!("the columns are named on line {line}; ")
        });
        let text = format!(
            "{found}the rows above say of this channel: {}",
            cut(&said.join("; "))
        );
        Some(Finding::info("preamble", text))
    }

    /// Holds the samples before time zero against the clock.
    fn zero_finding(&self, samples: &HeldAgainst) -> Option<Finding> {
        let (row, before) = self.before(samples.rate)?;
        let interval_s = samples.rate.interval().seconds();
        let stated_s = samples.start_s + before * interval_s;
        let zero_s = samples.zero_s.unwrap_or(0.0);
        let text = format!(
            "{} puts time zero at {} s on the file's clock, where it is {zero_s} s; state the right \
             one with {} = S",
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

/// Holds a stated rate against the one of the samples.
fn rate_finding(
    row: &PreambleRow,
    text: &str,
    rates: &[f64],
    samples: &HeldAgainst,
) -> Option<Finding> {
    /// Largest ratio of two rates that are one, and of two that may be the nominal and the true one.
    const SAME: f64 = 1.01;
    const NOMINAL: f64 = 1.5;
    let ratio = |rate: &f64| (rate / samples.rate.hertz()).max(samples.rate.hertz() / rate);
    let nearest = rates.iter().map(ratio).fold(f64::INFINITY, f64::min);
    let text = format!(
        "{} is `{}`, and {} gives {} Hz: one of the two is wrong",
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
