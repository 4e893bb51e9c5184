//! Rows above the names: a key, and a value for each column.

use crate::csv::begin;
use crate::csv::dialect::Separator;
use crate::csv::header;
use crate::held::Statement;
use crate::text::{self, shown};
use crate::words::{Words, word_list};
use latchgate_kernel::units::TimeUnit;

// What the list holds is told at its head.
static KEYS: Words = word_list!("preamble-keys");

/// What a row is about.
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
    /// Full scale.
    Range,
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
    const ALL: [(Self, &'static str); 18] = [
        (Self::Unit, "unit"),
        (Self::TimeUnit, "time-unit"),
        (Self::Rate, "rate"),
        (Self::Interval, "interval"),
        (Self::Class, "class"),
        (Self::Corner, "corner"),
        (Self::Count, "count"),
        (Self::Before, "before"),
        (Self::After, "after"),
        (Self::Range, "range"),
        (Self::Code, "code"),
        (Self::Name, "name"),
        (Self::Sensor, "sensor"),
        (Self::Location, "location"),
        (Self::Test, "test"),
        (Self::Vehicle, "vehicle"),
        (Self::Laboratory, "laboratory"),
        (Self::Date, "date"),
    ];

    /// Finds what a key is about, by its words with those in brackets, then without.
    fn of_key(key: &str) -> Option<Self> {
        let bare = key.split(['(', '[']).next().unwrap_or_default();
        [key, bare].into_iter().find_map(|key| {
            let words = header::words(key).join(" ");
            let mut entries = KEYS.iter().filter_map(|line| line.split_once('\t'));
            let (_, name) = entries.find(|(known, _)| *known == words)?;
            let topic = Self::ALL.iter().find(|(_, known)| *known == name);
            topic.map(|(topic, _)| *topic)
        })
    }

    /// Tells whether a value in one column alone says nothing of the others.
    fn is_of_one_column(self) -> bool {
        use PreambleTopic::{Code, Location, Name, Range, Sensor, Unit};
        matches!(self, Unit | Range | Code | Name | Sensor | Location)
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
    /// Whether the row ends behind its one value, so that it speaks of all columns.
    pub(super) is_short: bool,
}

impl PreambleRow {
    /// Reads a line above a table of `width` columns; `None` of an empty one.
    pub(super) fn read(
        line: u64,
        text: &str,
        (separator, width): (Separator, usize),
    ) -> Option<Self> {
        let mut cells = cells(text, separator);
        let first = cells.first()?.clone();
        let filled = cells.iter().filter(|cell| !cell.is_empty());
        let units = filled.clone().all(|cell| header::is_unit(cell)) && filled.count() > 1;
        let is_wide = cells.len() > width.max(2);
        let (key, topic) = match (units, is_wide) {
            (true, false) => (String::new(), Some(PreambleTopic::Unit)),
            (_, true) => (std::mem::take(&mut cells).join(", "), None),
            (false, false) => {
                let key = first.trim_end_matches([':', '=']).trim_end().to_string();
                cells[0].clear();
                let topic = PreambleTopic::of_key(&key);
                (key, topic)
            }
        };
        Some(Self {
            line,
            key,
            topic,
            // Empty cells behind the value say that the other columns have none.
            is_short: cells.len() == 2 && marks(text, separator) < 2,
            values: cells,
        })
    }

    /// Returns what it says of a column.
    pub(super) fn value(&self, column: usize) -> Option<&str> {
        let own = self.values.get(column).filter(|value| !value.is_empty());
        let is_of_one = self.topic.is_some_and(PreambleTopic::is_of_one_column);
        own.or_else(|| self.only().filter(|_| self.is_short || !is_of_one))
            .map(String::as_str)
    }

    /// Returns its one value, if it has no other.
    pub(super) fn only(&self) -> Option<&String> {
        let mut filled = self.values.iter().filter(|value| !value.is_empty());
        filled.next().filter(|_| filled.next().is_none())
    }

    /// Returns the unit that stands in brackets behind the key.
    pub(super) fn unit(&self) -> &str {
        let inner = self.key.rsplit_once(['(', '[']).map(|(_, inner)| inner);
        inner.map_or("", |inner| inner.trim_end_matches([')', ']']).trim())
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

    /// Returns the rates that a value may mean [Hz]: several where no unit says which.
    pub(super) fn rates(&self, text: &str) -> Option<Vec<f64>> {
        let (number, unit) = measure(text)?;
        let unit = match unit {
            "" => self.unit(),
            unit => unit,
        };
        let small = unit.to_lowercase();
        let per_second = match small.as_str() {
            "hz" | "1/s" | "s/s" | "sa/s" | "sps" | "samples/s" | "samples/sec" => Some(1.0),
            "khz" | "ks/s" | "ksa/s" | "ksps" => Some(1e3),
            "mhz" | "ms/s" | "msa/s" | "msps" => Some(1e6),
            _ => None,
        };
        let rates = match (per_second, TimeUnit::from_spelling(unit), self.topic) {
            (Some(factor), ..) => vec![number * factor],
            (None, Some(unit), _) => vec![1.0 / unit.to_seconds(number)],
            (None, None, Some(PreambleTopic::Interval)) => {
                [1.0, 1e3, 1e6].map(|one| one / number).into()
            }
            (None, None, _) if unit.is_empty() => [1.0, 1e3].map(|one| one * number).into(),
            _ => return None,
        };
        let is_rate = |rate: &f64| rate.is_finite() && *rate > 0.0;
        rates.iter().all(is_rate).then_some(rates)
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
    /// Tells whether its values are units and numbers, not words.
    pub(super) fn is_measure(&self) -> bool {
        use PreambleTopic::{
            After, Before, Class, Corner, Count, Interval, Range, Rate, TimeUnit, Unit,
        };
        let measures = [
            Unit, TimeUnit, Rate, Interval, Class, Corner, Count, Before, After, Range,
        ];
        self.topic.is_some_and(|topic| measures.contains(&topic))
    }
}

/// Counts the marks between the cells of a line.
fn marks(text: &str, separator: Separator) -> usize {
    match separator {
        Separator::Blanks | Separator::None => 0,
        other => text.matches(char::from(other.byte())).count(),
    }
}

/// Splits a number and its unit, a sign for both directions taken off; `None` where a comma may separate
/// thousands.
pub(super) fn measure(text: &str) -> Option<(f64, &str)> {
    let text = text.trim().trim_start_matches(['±', '<', '~']).trim_start();
    let text = text.strip_prefix("+/-").unwrap_or(text).trim_start();
    let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]);
    let ends: Vec<usize> = ends.collect();
    ends.into_iter().rev().find_map(|end| {
        let digits = text[..end].trim_end();
        let thousands = digits
            .split_once(',')
            .is_some_and(|(_, rest)| rest.len() == 3);
        let number = text::header_number(digits).filter(|_| !thousands)?;
        Some((number, text[end..].trim()))
    })
}

/// Tells whether a value says that there is nothing, such as no filter.
pub(super) fn says_none(text: &str) -> bool {
    let words = header::words(text).join(" ");
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

/// Splits a line above the table: at the table's separator, else behind a key.
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

/// Tells whether a sign between two texts stands between digits.
fn cuts_a_number(before: &str, behind: &str) -> bool {
    let is_digit = |c: char| c.is_ascii_digit();
    before.ends_with(is_digit) && behind.starts_with(is_digit)
}
