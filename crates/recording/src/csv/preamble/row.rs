//! Rows above the names: a key, and a value for each column.

use crate::channel_name;
use crate::csv::begin;
use crate::csv::dialect::Separator;
use crate::csv::preamble::TableShape;
use crate::examine::clock::RateStatement;
use crate::examine::worded::{hertz_of_unit, worded_clocks};
use crate::held::Statement;
use crate::text::{self, shown};
use crate::words::{Words, word_list};
use latchgate_kernel::units::{AccelerationUnit, TimeUnit};

// The head of the list explains it.
static KEYS: Words = word_list!("preamble-keys");

/// Topic of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PreambleTopic {
    /// The unit of the samples.
    Unit,
    /// The unit of the times.
    TimeUnit,
    /// Samples per second, or the time from one to the next.
    Rate,
    Interval,
    /// The channel frequency class, or another filter.
    Class,
    /// The corner of an analogue or digital filter.
    Corner,
    /// Samples in all, before time zero, and from there on.
    Count,
    Before,
    After,
    /// Time of the first and the last sample, and from one to the other.
    Start,
    End,
    Duration,
    /// Full scale, and what one unit of acceleration gives.
    Range,
    Sensitivity,
    /// The channel's code and its name.
    Code,
    Name,
    /// Facts of the test and of the sensor.
    Sensor,
    Location,
    Test,
    Vehicle,
    Laboratory,
    Date,
}

impl PreambleTopic {
    const ALL: [(Self, &'static str); 22] = [
        (Self::Unit, "unit"),
        (Self::TimeUnit, "time-unit"),
        (Self::Rate, "rate"),
        (Self::Interval, "interval"),
        (Self::Class, "class"),
        (Self::Corner, "corner"),
        (Self::Count, "count"),
        (Self::Before, "before"),
        (Self::After, "after"),
        (Self::Start, "start"),
        (Self::End, "end"),
        (Self::Duration, "duration"),
        (Self::Range, "range"),
        (Self::Sensitivity, "sensitivity"),
        (Self::Code, "code"),
        (Self::Name, "name"),
        (Self::Sensor, "sensor"),
        (Self::Location, "location"),
        (Self::Test, "test"),
        (Self::Vehicle, "vehicle"),
        (Self::Laboratory, "laboratory"),
        (Self::Date, "date"),
    ];

    /// Returns the topic of a key, by its words with those in brackets, without them, and without the unit
    /// at the end: `fs_Hz`.
    fn of_key(key: &str) -> Option<Self> {
        let bare = key.split(['(', '[']).next().unwrap_or_default();
        let words = [key, bare].map(channel_name::words);
        let without_unit = words[1].split_last().map_or(&[][..], |(last, front)| {
            let is_unit = is_unit_of_clock(last);
            if is_unit { front } else { &[] }
        });
        let keys = [&words[0], &words[1], without_unit];
        keys.into_iter().find_map(|words| {
            let words = words.join(" ");
            let mut entries = KEYS.iter().filter_map(|line| line.split_once('\t'));
            let (_, name) = entries.find(|(keyword, _)| *keyword == words)?;
            let topic = Self::ALL.iter().find(|(_, topic_name)| *topic_name == name);
            topic.map(|(topic, _)| *topic)
        })
    }

    /// Returns the topic of a row whose key is not known, by its values: units of acceleration, or rates and
    /// intervals with their units where the key holds a word for sampling.
    fn of_values(key: &str, values: &[String]) -> Option<Self> {
        let filled: Vec<&String> = values.iter().filter(|value| !value.is_empty()).collect();
        let is_acceleration = |value: &&String| {
            AccelerationUnit::from_spelling(channel_name::strip_brackets(value.trim())).is_some()
        };
        let are_units = filled
            .iter()
            .all(|value| channel_name::is_known_unit(value));
        if are_units && filled.iter().any(is_acceleration) {
            return Some(Self::Unit);
        }
        let words = channel_name::words(key);
        let samples = |word: &String| SAMPLING.iter().any(|stem| word.starts_with(stem));
        let row = PreambleRow::of_key(key);
        let units = filled.iter().map(|value| match measure(value) {
            Some((_, "")) => row.unit(),
            Some((_, unit)) => unit,
            None => "",
        });
        let units: Vec<&str> = units.collect();
        if filled.is_empty()
            || !words.iter().any(samples)
            || !units.iter().all(|unit| is_unit_of_clock(unit))
        {
            return None;
        }
        let is_rate = units.iter().all(|unit| hertz_of_unit(unit).is_some());
        // A longer time is that of the recording.
        let is_short = |value: &&String| row.seconds(value).is_some_and(|s| s <= 0.01);
        let is_interval = || filled.iter().all(is_short).then_some(Self::Interval);
        is_rate.then_some(Self::Rate).or_else(is_interval)
    }

    /// True if a value in one column alone does not concern the others.
    fn is_of_one_column(self) -> bool {
        use PreambleTopic::{Code, Location, Name, Range, Sensitivity, Sensor, Unit};
        matches!(
            self,
            Unit | Range | Sensitivity | Code | Name | Sensor | Location
        )
    }
}

/// A row above the names.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PreambleRow {
    pub(super) line: u64,
    /// The first cell; empty in a row of units without one.
    pub(super) key: String,
    pub(super) topic: Option<PreambleTopic>,
    /// Cells by column, that of the key empty.
    pub(super) values: Vec<String>,
    /// True if the row ends after its one value, so that it concerns all columns.
    pub(super) is_short: bool,
}

impl PreambleRow {
    /// Reads a line above a table; `None` for an empty one.
    pub(super) fn read(line: u64, text: &str, shape: TableShape) -> Option<Self> {
        let TableShape { separator, width } = shape;
        let mut cells = cells(text, separator);
        let first = cells.first()?.clone();
        let filled = cells.iter().filter(|cell| !cell.is_empty());
        let units = filled.clone().all(|cell| channel_name::is_unit(cell)) && filled.count() > 1;
        let (key, topic) = match units && cells.len() <= width.max(2) {
            true => (String::new(), Some(PreambleTopic::Unit)),
            false => {
                let key = first.trim_end_matches([':', '=']).trim_end().to_string();
                cells[0].clear();
                let topic = PreambleTopic::of_key(&key);
                let topic = topic.or_else(|| PreambleTopic::of_values(&key, &cells));
                (key, topic)
            }
        };
        let mut key = key;
        if cells.len() > width.max(2) {
            // The key is before the first column: `Units,s,g,g` above three of them.
            if topic.is_some() && cells.len() == width + 1 {
                cells.remove(0);
            } else {
                cells[0] = first;
                key = std::mem::take(&mut cells).join(", ");
                return Some(Self {
                    line,
                    key,
                    topic: None,
                    is_short: false,
                    values: cells,
                });
            }
        }
        Some(Self {
            line,
            key,
            topic,
            // Empty cells after the value show that the other columns have none.
            is_short: cells.len() == 2 && marks(text, separator) < 2,
            values: cells,
        })
    }

    /// Returns a row without values.
    pub(super) fn of_key(key: &str) -> Self {
        Self {
            line: 0,
            key: key.to_string(),
            topic: PreambleTopic::of_key(key),
            values: Vec::new(),
            is_short: false,
        }
    }

    /// Reads two lines above a table of which the second holds the values of the first, as in
    /// `X,CH1,Start,Increment` over `Sequence,Volt,-0.1,2e-4`: one row for each known key of time or number that
    /// stands over a number, and a row of units above the columns.
    pub(super) fn of_pair([names, values]: [&(u64, String); 2], shape: TableShape) -> Vec<Self> {
        let TableShape { separator, width } = shape;
        let [keys, cells] = [names, values].map(|(_, text)| cells(text, separator));
        if keys.len() != cells.len() || keys.len() < 3 {
            return Vec::new();
        }
        let row = |key: &str, topic, values| Self {
            line: names.0,
            key: key.to_string(),
            topic: Some(topic),
            is_short: true,
            values,
        };
        let rows_of_keys = keys.iter().zip(&cells).skip(1).filter_map(|(key, cell)| {
            use PreambleTopic::{Before, Count, End, Interval, Rate, Start};
            let topic = PreambleTopic::of_key(key).filter(|_| measure(cell).is_some())?;
            let is_of_all = matches!(topic, Before | Count | End | Interval | Rate | Start);
            let is_it = is_of_all || keys.len() > width;
            is_it.then(|| row(key, topic, vec![String::new(), cell.clone()]))
        });
        let mut rows: Vec<Self> = rows_of_keys.collect();
        if !rows.is_empty() {
            let unit = |cell: &String| match channel_name::is_unit(cell) {
                true => cell.clone(),
                false => String::new(),
            };
            let units = cells[..width.min(cells.len())].iter().map(unit).collect();
            rows.push(row("", PreambleTopic::Unit, units));
        }
        rows
    }

    /// Returns the value that concerns a column.
    pub(super) fn value(&self, column: usize) -> Option<&str> {
        let value = self.values.get(column).filter(|value| !value.is_empty());
        let is_of_one = self.topic.is_some_and(PreambleTopic::is_of_one_column);
        value
            .or_else(|| self.only().filter(|_| self.is_short || !is_of_one))
            .map(String::as_str)
    }

    /// Returns its one value, if it has no other.
    pub(super) fn only(&self) -> Option<&String> {
        let mut filled = self.values.iter().filter(|value| !value.is_empty());
        filled.next().filter(|_| filled.next().is_none())
    }

    /// Returns the unit in brackets after the key, or its last word: `fs_Hz`.
    pub(super) fn unit(&self) -> &str {
        let inner = self.key.rsplit_once(['(', '[']).map(|(_, inner)| inner);
        let inner = inner.map(|inner| inner.trim_end_matches([')', ']']).trim());
        let last = self.key.rsplit_once([' ', '_']).map(|(_, last)| last);
        let last = last.filter(|last| is_unit_of_clock(last));
        inner.or(last).unwrap_or_default()
    }

    /// Names the row in a message.
    pub(super) fn named(&self) -> String {
        format!("`{}` on line {}", shown(&self.key), self.line)
    }

    pub(super) fn statement<'a>(&'a self, text: &'a str) -> Statement<'a> {
        Statement {
            key: &self.key,
            text,
        }
    }

    /// Returns the rates that a value of one number and one unit may mean [Hz]: several where no unit decides.
    fn plain_rates(&self, text: &str) -> Option<Vec<f64>> {
        let (number, unit) = measure(text)?;
        let unit = match unit {
            "" => self.unit(),
            unit => unit,
        };
        let rates = match (
            hertz_of_unit(unit),
            TimeUnit::from_spelling(unit),
            self.topic,
        ) {
            (Some(factor), ..) => vec![number * factor],
            (None, Some(unit), _) => vec![1.0 / unit.to_seconds(number)],
            (None, None, Some(PreambleTopic::Interval)) => {
                [1.0, 1e3, 1e6].map(|factor| factor / number).into()
            }
            (None, None, _) if unit.is_empty() => [1.0, 1e3].map(|factor| factor * number).into(),
            _ => return None,
        };
        let is_rate = |rate: &f64| rate.is_finite() && *rate > 0.0;
        rates.iter().all(is_rate).then_some(rates)
    }

    /// Returns the rate that a text under the row's name states: several where no unit decides, or where a sign may
    /// part thousands.
    pub(super) fn rate_statement(&self, text: &str) -> Option<RateStatement> {
        if let Some(rates) = self.plain_rates(text) {
            return Some(RateStatement::of(rates, text));
        }
        let worded = worded_clocks(&format!("{}: {text}", self.key));
        worded.into_iter().next().map(|clock| clock.rate)
    }

    /// Returns a time that is stated with its unit [s].
    pub(super) fn seconds(&self, text: &str) -> Option<f64> {
        let (number, unit) = measure(text)?;
        let unit = match unit {
            "" => self.unit(),
            unit => unit,
        };
        Some(TimeUnit::from_spelling(unit)?.to_seconds(number))
    }

    /// Returns the corner of a filter [Hz].
    pub(super) fn corner_hz(&self, text: &str) -> Option<f64> {
        let (number, unit) = measure(text)?;
        let unit = match unit {
            "" => self.unit(),
            unit => unit,
        };
        let factor = match unit.eq_ignore_ascii_case("khz") {
            true => 1e3,
            false => 1.0,
        };
        Some(number * factor).filter(|hertz| *hertz > 0.0)
    }
}

impl PreambleRow {
    /// True if its values are units and numbers, not words.
    pub(super) fn is_measure(&self) -> bool {
        use PreambleTopic::{
            After, Before, Class, Corner, Count, Interval, Range, Rate, Sensitivity, TimeUnit, Unit,
        };
        let measures = [
            Unit,
            TimeUnit,
            Rate,
            Interval,
            Class,
            Corner,
            Count,
            Before,
            After,
            Range,
            Sensitivity,
        ];
        self.topic.is_some_and(|topic| measures.contains(&topic))
    }
}

/// Beginnings of words that say that a rate or an interval is that of the samples.
const SAMPLING: [&str; 11] = [
    "abtast", "acqui", "adc", "campion", "digiti", "logging", "muestr", "sampl", "scan", "takt",
    "échant",
];

/// True if a text is the unit of a rate or of a time.
fn is_unit_of_clock(text: &str) -> bool {
    hertz_of_unit(text).is_some() || TimeUnit::from_spelling(text).is_some()
}

/// Counts the marks between the cells of a line.
fn marks(text: &str, separator: Separator) -> usize {
    match separator {
        Separator::Blanks | Separator::None => 0,
        separator => text.matches(char::from(separator.byte())).count(),
    }
}

/// Splits a number and its unit, without a sign for both directions; `None` where a comma may separate
/// thousands.
pub(super) fn measure(text: &str) -> Option<(f64, &str)> {
    let text = text.trim().trim_start_matches(['±', '<', '~']).trim_start();
    let text = text.strip_prefix("+/-").unwrap_or(text).trim_start();
    let ends = text
        .char_indices()
        .map(|(index, _)| index)
        .chain([text.len()]);
    let ends: Vec<usize> = ends.collect();
    ends.into_iter().rev().find_map(|end| {
        let digits = text[..end].trim_end();
        let thousands = digits
            .split_once(',')
            .is_some_and(|(_, decimals)| decimals.len() == 3);
        let number = text::header_number(digits).filter(|_| !thousands)?;
        Some((number, text[end..].trim()))
    })
}

/// True if a value means none, such as no filter.
pub(super) fn says_none(text: &str) -> bool {
    let words = channel_name::words(text).join(" ");
    let none = [
        "",
        "0",
        "aus",
        "keine",
        "keiner",
        "n a",
        "no",
        "none",
        "off",
        "unfiltered",
    ];
    none.contains(&words.as_str())
}

/// Splits a line above the table: at the table's separator, else after a key.
fn cells(line: &str, separator: Separator) -> Vec<String> {
    let cells: Vec<String> = match separator {
        Separator::Blanks | Separator::None => {
            let parts = line.split('\t').flat_map(|part| part.split("  "));
            let parts = parts.map(str::trim).filter(|part| !part.is_empty());
            parts.map(String::from).collect()
        }
        _ => begin::cells(line.as_bytes(), separator)
            .into_iter()
            .map(|cell| String::from_utf8_lossy(cell).into_owned())
            .collect(),
    };
    match cells.as_slice() {
        [only] => match only.split_once([':', '=', ',', ';']) {
            // A time of day is no key.
            Some((key, value)) if !value.trim().is_empty() && !cuts_a_number(key, value) => {
                [key, value].map(|part| part.trim().to_string()).into()
            }
            _ => cells,
        },
        _ => cells,
    }
}

/// True if the sign between two texts is between digits.
fn cuts_a_number(before: &str, behind: &str) -> bool {
    let is_digit = |c: char| c.is_ascii_digit();
    before.ends_with(is_digit) && behind.starts_with(is_digit)
}
