//! Preambles: rows above the names of a table that describe its columns: unit, rate, filter class,
//! range, code, sensor and the like.
//!
//! The first cell of such a row is its key. A value in a column concerns that column; a single value
//! right after the key concerns all. The value of a known key is compared with options and samples, and
//! a contradiction blocks: nothing shows which of the two is right. Every row is shown. Comments are no
//! such rows; one that states a rate with its unit is compared all the same, and only warns.
//!
//! - `findings`: comparison of the rows above the names with the samples and their clock;
//! - `row`: rows above the names: a key, and a value for each column.

mod findings;
mod row;

use super::dialect::{LineScan, Separator};
use crate::Stated;
use crate::channel_name::filtered::{Filtered, filter_in};
use crate::channel_name::{self, ChannelName};
use crate::code::Code;
use crate::examine::clock::RateStatement;
use crate::examine::worded::{WordedClock, worded_clocks};
use crate::remarks::{self, Remark, RemarkPlace};
use crate::text::shown;
pub(super) use findings::TableFacts;
use latchgate_kernel::units::{AccelerationUnit, SampleRate, TimeUnit};
use row::{PreambleRow, PreambleTopic, measure, says_none};

/// A line that states a rate or an interval in words.
#[derive(Debug, Clone, PartialEq)]
struct WordedLine {
    /// Names it in a message, with what it says.
    said: String,
    clocks: Vec<WordedClock>,
}

impl WordedLine {
    fn read(line: u64, text: &str) -> Option<Self> {
        let said = format!("line {line} says `{}`", shown(text));
        let clocks = worded_clocks(text);
        (!clocks.is_empty()).then_some(Self { said, clocks })
    }
}

/// Part by which an interval without a unit may be off the rate that shows its unit [-].
const UNIT_BY_RATE: f64 = 0.01;

/// Most such lines that are compared; a file that has more is no table of one clock.
const WORDED_LINES: usize = 1000;

/// The rows above a table.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Preamble {
    rows: Vec<PreambleRow>,
    /// Lines that state a rate or an interval in words: comments, and rows without a key that is known.
    worded: Vec<WordedLine>,
    /// The line of the names, where it was found and not stated.
    found_header: Option<u32>,
}

/// Shape of a table, by which lines above it are split.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableShape {
    pub(super) separator: Separator,
    /// Number of its columns.
    pub(super) width: usize,
}

impl Preamble {
    /// Reads the lines around a table; `found_header` is the line of the names where it was not stated.
    pub(super) fn read(lines: &LineScan, shape: TableShape, found_header: Option<u32>) -> Self {
        let row = |(line, text): &(u64, String)| PreambleRow::read(*line, text, shape);
        let rows: Vec<PreambleRow> = lines.above.iter().filter_map(row).collect();
        let is_keyed = |line: u64| {
            let mut rows = rows.iter();
            let is_read = |row: &PreambleRow| {
                row.topic.is_some() && row.values.iter().any(|value| !value.is_empty())
            };
            rows.any(|row| row.line == line && is_read(row))
        };
        let unkeyed = lines.above.iter().filter(|(line, _)| !is_keyed(*line));
        let worded = lines.words.iter().chain(unkeyed);
        let worded = worded.filter_map(|(line, text)| WordedLine::read(*line, text));
        let worded = worded.take(WORDED_LINES).collect();
        let pairs = lines.above.windows(2);
        let pairs = pairs.flat_map(|pair| PreambleRow::of_pair([&pair[0], &pair[1]], shape));
        Self {
            rows: rows.iter().cloned().chain(pairs).collect(),
            worded,
            found_header,
        }
    }

    /// Returns the first rows, each as key and values.
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
    fn rows_on(&self, topic: PreambleTopic) -> impl Iterator<Item = &PreambleRow> {
        self.rows.iter().filter(move |row| row.topic == Some(topic))
    }

    /// Returns the values on a topic that concern a column, each with its row.
    fn values_on(
        &self,
        topic: PreambleTopic,
        column: usize,
    ) -> impl Iterator<Item = (&PreambleRow, &str)> {
        self.rows_on(topic).filter_map(move |row| {
            let value = row.value(column).filter(|value| !says_none(value))?;
            Some((row, value))
        })
    }

    /// Applies the rows to the columns. `with_units` is true if rows of units count.
    pub(super) fn apply(&self, columns: &mut [ChannelName], with_units: bool) {
        for (index, column) in columns.iter_mut().enumerate() {
            if column.says_time() {
                let units = self
                    .rows_on(PreambleTopic::TimeUnit)
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
            let units = self
                .values_on(PreambleTopic::Unit, index)
                .filter(|_| with_units);
            for (_, unit) in units {
                *column = std::mem::take(column).with_unit(unit, SOURCE);
            }
            column.state(self.stated(index, column));
        }
    }

    /// Returns the units of time above a column in rows of units.
    fn units_in_place(&self, column: usize) -> impl Iterator<Item = &str> {
        let rows = self.rows_on(PreambleTopic::Unit);
        let cells = rows.filter_map(move |row| row.values.get(column));
        let is_time = |cell: &&str| {
            let unit = channel_name::strip_brackets(cell.trim());
            TimeUnit::from_spelling(unit).is_some()
        };
        cells.map(String::as_str).filter(is_time)
    }

    /// Returns the name of a column by the code and name above it and the words of its header that are no
    /// number of channel or sensor; `None` without any above it.
    fn described(&self, index: usize, column: &ChannelName) -> Option<String> {
        let texts_on = |topic| self.values_on(topic, index).map(|(_, text)| text);
        let sensors: Vec<String> = texts_on(PreambleTopic::Sensor)
            .flat_map(channel_name::words)
            .collect();
        let names: Vec<&str> = texts_on(PreambleTopic::Code)
            .chain(texts_on(PreambleTopic::Name))
            .collect();
        if names.is_empty() && sensors.is_empty() {
            return None;
        }
        let is_number = |word: &String| {
            let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
            ["", "ch", "chan", "channel", "kanal"].contains(&stem) || sensors.contains(word)
        };
        let header = channel_name::words(&column.label);
        let other_words = header.into_iter().filter(|word| !is_number(word));
        let names = names.into_iter().map(String::from);
        Some(names.chain(other_words).collect::<Vec<_>>().join(" "))
    }

    /// Returns the facts that are stated of a column's samples.
    fn stated(&self, index: usize, column: &ChannelName) -> Stated {
        let text = |topic| {
            let texts: Vec<&str> = self.values_on(topic, index).map(|(_, text)| text).collect();
            (!texts.is_empty()).then(|| texts.join(" "))
        };
        let mut stated = Stated {
            location: text(PreambleTopic::Code).filter(|code| Code::new(code).is_some()),
            full_scale: self.full_scale(index, column),
            ..Stated::default()
        };
        let mut corner = |hertz: f64| {
            let least = stated
                .prefilter_hz
                .map_or(hertz, |lowest| lowest.min(hertz));
            stated.prefilter_hz = Some(least);
        };
        for (row, text) in self.values_on(PreambleTopic::Corner, index) {
            row.corner_hz(text).into_iter().for_each(&mut corner);
        }
        for (row, text) in self.values_on(PreambleTopic::Class, index) {
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
        self.values_on(PreambleTopic::Range, index)
            .find_map(|(row, text)| {
                let last = text.rsplit("..").next()?;
                let (number, unit) = measure(last)?;
                let unit = match unit {
                    "" => row.unit(),
                    unit => unit,
                };
                let factor = match (AccelerationUnit::from_spelling(unit), column.unit) {
                    (Some(unit), Some(column_unit)) => {
                        unit.metres_per_second_squared() / column_unit.metres_per_second_squared()
                    }
                    (None, column_unit) => {
                        let is_same = column.unit_text.as_deref() == Some(unit);
                        let engineering = unit.eq_ignore_ascii_case("EU") && column_unit.is_some();
                        (is_same || engineering).then_some(1.0)?
                    }
                    (Some(_), None) => return None,
                };
                Some(number.abs() * factor).filter(|full| *full > 0.0)
            })
    }

    /// Returns the rate that is stated with its unit [Hz], if one is and all agree.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        let rows = [PreambleTopic::Rate, PreambleTopic::Interval].map(|topic| self.rows_on(topic));
        let rows = rows.into_iter().flatten();
        let values = rows.flat_map(|row| row.values.iter().map(move |text| (row, text)));
        let values = values.filter(|(_, text)| !text.is_empty());
        let rates = values.map(|(row, text)| row.rate_statement(text));
        let rates: Vec<Option<RateStatement>> = rates.collect();
        let [Some(first), other_rates @ ..] = rates.as_slice() else {
            return None;
        };
        let [rate] = first.rates() else {
            return None;
        };
        let agrees = |other: &Option<RateStatement>| {
            other
                .as_ref()
                .is_some_and(|other| other.rates() == first.rates())
        };
        other_rates.iter().all(agrees).then_some(*rate)
    }

    /// Returns the number of samples before time zero, at a rate, with its row.
    fn samples_before_zero(&self, rate: SampleRate) -> Option<(&PreambleRow, f64)> {
        self.rows_on(PreambleTopic::Before).find_map(|row| {
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

    /// Returns the time of the first sample by the samples before time zero, where no stamp gives it [s].
    pub(super) fn before_zero_s(&self, rate: SampleRate) -> Option<f64> {
        let (_, before) = self.samples_before_zero(rate)?;
        // No negative zero.
        Some(0.0 - before / rate.hertz())
    }

    /// Returns who states the time of the first sample of so many as a start, and that time [s].
    pub(super) fn start_s(&self, rate: SampleRate, samples: usize) -> Option<(String, f64)> {
        self.rows_on(PreambleTopic::Start).find_map(|row| {
            let text = row.only()?;
            let start_s = match row.seconds(text) {
                Some(start_s) => start_s,
                None => {
                    let (number, unit) = measure(text)?;
                    let factor = self
                        .unit_by_rate(rate, samples)
                        .filter(|_| unit.is_empty())?;
                    number * factor
                }
            };
            Some((row.named(), start_s))
        })
    }

    /// Returns the unit [s] in which a head without units gives the rate: by its interval, or by its end and start.
    fn unit_by_rate(&self, rate: SampleRate, samples: usize) -> Option<f64> {
        let interval_s = rate.interval().seconds();
        let bare = |topic| {
            let texts = self.rows_on(topic).filter_map(PreambleRow::only);
            let numbers = texts
                .filter_map(|text| measure(text))
                .filter(|(_, unit)| unit.is_empty());
            numbers.map(|(number, _)| number).next()
        };
        let of_interval = bare(PreambleTopic::Interval);
        let span = || Some(bare(PreambleTopic::End)? - bare(PreambleTopic::Start)?);
        let intervals: Vec<f64> = match of_interval {
            Some(interval) => vec![interval],
            None => {
                let span = span()?;
                [samples.saturating_sub(1), samples]
                    .map(|steps| span / steps as f64)
                    .into()
            }
        };
        let fits = |factor: &f64| {
            let mut intervals = intervals.iter();
            intervals.any(|interval| (interval * factor / interval_s - 1.0).abs() <= UNIT_BY_RATE)
        };
        [1.0, 1e-3, 1e-6].into_iter().find(fits)
    }

    /// Returns the rows of words as remarks, on a column or on the whole table.
    pub(super) fn remarks(&self, columns: usize) -> Vec<(Option<usize>, Remark)> {
        let mut remarks = Vec::new();
        for row in self.rows.iter().filter(|row| !row.is_measure()) {
            let source = format!("line {} says", row.line);
            let remark = |value: &str| {
                let is_comment = remarks::is_key(&row.key) && row.topic.is_none();
                let (text, place) = match (is_comment, row.key.is_empty() || value.is_empty()) {
                    (true, _) => (value.to_string(), RemarkPlace::Channel),
                    (false, true) => (format!("{}{value}", row.key), RemarkPlace::Apart),
                    (false, false) => (format!("{}: {value}", row.key), RemarkPlace::Apart),
                };
                Remark::new(&text, place, source.clone())
            };
            match row.only() {
                Some(value) if row.is_short => remarks.push((None, remark(value))),
                None if row.values.iter().all(String::is_empty) => remarks.push((None, remark(""))),
                _ => {
                    let remark_on =
                        |index: usize| Some((Some(index), remark(row.values.get(index)?)));
                    let filled = (0..columns).filter(|index| {
                        row.values
                            .get(*index)
                            .is_some_and(|value| !value.is_empty())
                    });
                    remarks.extend(filled.filter_map(remark_on));
                }
            }
        }
        remarks
    }
}

/// Returns the rates [Hz] that a number under a name may mean, if the name is a key for rate or interval.
pub(crate) fn rates_under_name(name: &str, number: &str) -> Option<RateStatement> {
    let row = PreambleRow::of_key(name);
    let is_rate = matches!(
        row.topic,
        Some(PreambleTopic::Rate | PreambleTopic::Interval)
    );
    is_rate.then(|| row.rate_statement(number))?
}

/// Source of a unit above the table, as documents name it.
const SOURCE: &str = "preamble";
