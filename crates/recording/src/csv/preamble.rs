//! Preambles: rows above the names of a table that say what its columns are, such as unit, rate, filter
//! class, range, code and sensor.
//!
//! The first cell of such a row is its key. A value stands in the column of which it speaks; one alone
//! behind its key speaks of all. What a known key says is held against options and samples, and a
//! contradiction blocks, for nobody knows which of the two is right; every row is shown. Comments are no
//! such rows: one that states a rate with its unit is held against the samples all the same, and tells.
//!
//! - `findings`: what the rows above the names say, held against the samples and their clock;
//! - `row`: rows above the names: a key, and a value for each column.

mod findings;
mod row;

use super::dialect::{LineScan, Separator};
use crate::Stated;
use crate::channel_name::filtered::{Filtered, filter_in};
use crate::channel_name::{self, ChannelName};
use crate::code::Code;
use crate::remarks::{self, Remark, RemarkPlace};
use crate::text::shown;
pub(super) use findings::HeldAgainst;
use latchgate_kernel::units::{AccelerationUnit, SampleRate, TimeUnit};
use row::{PreambleRow, PreambleTopic, measure, says_none};

/// The rows above a table.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Preamble {
    rows: Vec<PreambleRow>,
    /// Comments that state a rate with its unit.
    comments: Vec<PreambleRow>,
    /// The line of the names, where nobody stated it.
    found: Option<u32>,
}

impl Preamble {
    /// Reads what stands around a table of `width` columns; `found` is the line of the names where nobody
    /// stated it.
    pub(super) fn read(lines: &LineScan, shape: (Separator, usize), found: Option<u32>) -> Self {
        let row = |(line, text): &(u64, String)| PreambleRow::read(*line, text, shape);
        let states_rate = |row: &PreambleRow| {
            use PreambleTopic::{Interval, Rate};
            let value = row
                .only()
                .filter(|_| matches!(row.topic, Some(Rate | Interval)));
            let rates = value.and_then(|value| row.rates(value));
            rates.is_some_and(|rates| rates.len() == 1)
        };
        let pairs = lines.above.windows(2);
        let pairs = pairs.flat_map(|pair| PreambleRow::of_pair([&pair[0], &pair[1]], shape));
        Self {
            rows: lines.above.iter().filter_map(row).chain(pairs).collect(),
            comments: lines
                .words
                .iter()
                .filter_map(row)
                .filter(states_rate)
                .collect(),
            found,
        }
    }

    /// Returns what the first rows say, each as key and values.
    pub(super) fn listed(&self) -> Vec<String> {
        const SHOWN: usize = 40;
        let shown = |row: &PreambleRow| {
            let values = row.values.iter().filter(|value| !value.is_empty());
            let values: Vec<&str> = values.map(String::as_str).collect();
            shown(format!("{} {}", row.key, values.join(", ")))
        };
        self.rows.iter().take(SHOWN).map(shown).collect()
    }

    /// Returns the rows of a topic.
    fn of(&self, topic: PreambleTopic) -> impl Iterator<Item = &PreambleRow> {
        self.rows.iter().filter(move |row| row.topic == Some(topic))
    }

    /// Returns what is said of a column on a topic.
    fn said(
        &self,
        topic: PreambleTopic,
        column: usize,
    ) -> impl Iterator<Item = (&PreambleRow, &str)> {
        self.of(topic).filter_map(move |row| {
            let value = row.value(column).filter(|value| !says_none(value))?;
            Some((row, value))
        })
    }

    /// Tells the columns what is said of them. With `with_units` rows of units count.
    pub(super) fn apply(&self, columns: &mut [ChannelName], with_units: bool) {
        for (index, column) in columns.iter_mut().enumerate() {
            if column.says_time() {
                let units = self
                    .of(PreambleTopic::TimeUnit)
                    .filter_map(PreambleRow::only);
                let units = units.map(String::as_str).chain(self.units_in_place(index));
                for unit in units {
                    *column = std::mem::take(column).with_unit(unit, SOURCE);
                }
                continue;
            }
            if let Some(words) = self.described(index, column) {
                column.describe(words);
            }
            let units = self.said(PreambleTopic::Unit, index).filter(|_| with_units);
            for (_, unit) in units {
                *column = std::mem::take(column).with_unit(unit, SOURCE);
            }
            column.say(self.stated(index, column));
        }
    }

    /// Returns the units of time that stand above a column in rows of units.
    fn units_in_place(&self, column: usize) -> impl Iterator<Item = &str> {
        let rows = self.of(PreambleTopic::Unit);
        let cells = rows.filter_map(move |row| row.values.get(column));
        let is_time = |cell: &&str| {
            let unit = channel_name::strip_brackets(cell.trim());
            TimeUnit::from_spelling(unit).is_some()
        };
        cells.map(String::as_str).filter(is_time)
    }

    /// Returns what a column is called by code and name above it and by the words of its header that
    /// are no number of channel or sensor; `None` where nothing is said of it.
    fn described(&self, index: usize, column: &ChannelName) -> Option<String> {
        let own = |topic| self.said(topic, index).map(|(_, text)| text);
        let sensors: Vec<String> = own(PreambleTopic::Sensor)
            .flat_map(channel_name::words)
            .collect();
        let names: Vec<&str> = own(PreambleTopic::Code)
            .chain(own(PreambleTopic::Name))
            .collect();
        if names.is_empty() && sensors.is_empty() {
            return None;
        }
        let is_number = |word: &String| {
            let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
            ["", "ch", "chan", "channel", "kanal"].contains(&stem) || sensors.contains(word)
        };
        let header = channel_name::words(&column.label);
        let rest = header.into_iter().filter(|word| !is_number(word));
        let names = names.into_iter().map(String::from);
        Some(names.chain(rest).collect::<Vec<_>>().join(" "))
    }

    /// Returns what is stated of a column's samples.
    fn stated(&self, index: usize, column: &ChannelName) -> Stated {
        let text = |topic| {
            let texts: Vec<&str> = self.said(topic, index).map(|(_, text)| text).collect();
            (!texts.is_empty()).then(|| texts.join(" "))
        };
        let mut stated = Stated {
            location: text(PreambleTopic::Code).filter(|code| Code::new(code).is_some()),
            full_scale: self.full_scale(index, column),
            ..Stated::default()
        };
        let mut corner = |hertz: f64| {
            let least = stated.prefilter_hz.map_or(hertz, |known| known.min(hertz));
            stated.prefilter_hz = Some(least);
        };
        for (row, text) in self.said(PreambleTopic::Corner, index) {
            row.corner_hz(text).into_iter().for_each(&mut corner);
        }
        for (row, text) in self.said(PreambleTopic::Class, index) {
            match filter_in(&format!("class {text}")) {
                Some(Filtered::Class(class)) => stated.filter_class = Some(class),
                _ => row.corner_hz(text).into_iter().for_each(&mut corner),
            }
        }
        let facts = &mut stated.test;
        facts.test = text(PreambleTopic::Test);
        facts.vehicle = text(PreambleTopic::Vehicle);
        facts.laboratory = text(PreambleTopic::Laboratory);
        facts.date = text(PreambleTopic::Date);
        facts.sensor = text(PreambleTopic::Sensor);
        facts.location = text(PreambleTopic::Name).or(text(PreambleTopic::Location));
        stated
    }

    /// Returns the full scale in the column's unit, where its own unit is stated.
    fn full_scale(&self, index: usize, column: &ChannelName) -> Option<f64> {
        self.said(PreambleTopic::Range, index)
            .find_map(|(row, text)| {
                let last = text.rsplit("..").next()?;
                let (number, unit) = measure(last)?;
                let unit = match unit {
                    "" => row.unit(),
                    unit => unit,
                };
                let factor = match (AccelerationUnit::from_spelling(unit), column.unit) {
                    (Some(unit), Some(own)) => {
                        unit.metres_per_second_squared() / own.metres_per_second_squared()
                    }
                    (None, own) => {
                        let is_own = column.unit_text.as_deref() == Some(unit);
                        let engineering = unit.eq_ignore_ascii_case("EU") && own.is_some();
                        (is_own || engineering).then_some(1.0)?
                    }
                    (Some(_), None) => return None,
                };
                Some(number.abs() * factor).filter(|full| *full > 0.0)
            })
    }

    /// Returns the rate that is stated with its unit [Hz], if one is and all agree.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        let rows = [PreambleTopic::Rate, PreambleTopic::Interval].map(|topic| self.of(topic));
        let rows = rows.into_iter().flatten();
        let values = rows.flat_map(|row| row.values.iter().map(move |text| (row, text)));
        let values = values.filter(|(_, text)| !text.is_empty());
        let rates: Vec<Option<Vec<f64>>> = values.map(|(row, text)| row.rates(text)).collect();
        let [Some(first), rest @ ..] = rates.as_slice() else {
            return None;
        };
        let [rate] = first.as_slice() else {
            return None;
        };
        let agrees = |other: &Option<Vec<f64>>| other.as_ref() == Some(first);
        rest.iter().all(agrees).then_some(*rate)
    }

    /// Returns how many samples lie before time zero, at a rate.
    fn before(&self, rate: SampleRate) -> Option<(&PreambleRow, f64)> {
        self.of(PreambleTopic::Before).find_map(|row| {
            let text = row.values.iter().find(|text| !text.is_empty())?;
            let (number, unit) = measure(text)?;
            let unit = match unit {
                "" => row.unit(),
                unit => unit,
            };
            let samples = match (TimeUnit::from_spelling(unit), unit) {
                (Some(unit), _) => unit.to_seconds(number) * rate.hertz(),
                (None, "") => number,
                _ => return None,
            };
            (samples >= 0.0).then_some((row, samples))
        })
    }

    /// Returns the time of the first sample where no stamp tells it [s].
    pub(super) fn start_s(&self, rate: SampleRate) -> f64 {
        let before = self.before(rate).map_or(0.0, |(_, samples)| samples);
        // No negative zero.
        0.0 - before / rate.hertz()
    }

    /// Returns what is written in words, of a column or of the whole table.
    pub(super) fn remarks(&self, columns: usize) -> Vec<(Option<usize>, Remark)> {
        let mut all = Vec::new();
        for row in self.rows.iter().filter(|row| !row.is_measure()) {
            let teller = format!("line {} says", row.line);
            let remark = |value: &str| {
                let of_person = remarks::is_key(&row.key) && row.topic.is_none();
                let (text, place) = match (of_person, row.key.is_empty() || value.is_empty()) {
                    (true, _) => (value.to_string(), RemarkPlace::Channel),
                    (false, true) => (format!("{}{value}", row.key), RemarkPlace::Apart),
                    (false, false) => (format!("{}: {value}", row.key), RemarkPlace::Apart),
                };
                Remark::new(&text, place, teller.clone())
            };
            match row.only() {
                Some(value) if row.is_short => all.push((None, remark(value))),
                None if row.values.iter().all(String::is_empty) => all.push((None, remark(""))),
                _ => {
                    let of = |index: usize| Some((Some(index), remark(row.values.get(index)?)));
                    let filled = (0..columns).filter(|index| {
                        row.values
                            .get(*index)
                            .is_some_and(|value| !value.is_empty())
                    });
                    all.extend(filled.filter_map(of));
                }
            }
        }
        all
    }
}

/// Returns the rates that a column of one number means, whose name is a key for rate or interval [Hz].
pub(super) fn rates_of_column(name: &str, number: f64) -> Option<Vec<f64>> {
    let row = PreambleRow::of_key(name);
    let is_rate = matches!(
        row.topic,
        Some(PreambleTopic::Rate | PreambleTopic::Interval)
    );
    is_rate.then(|| row.rates(&number.to_string()))?
}

/// What states a unit above the table, as documents have it.
const SOURCE: &str = "preamble";
