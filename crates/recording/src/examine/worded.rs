//! Statements of time in words: numbers with the unit of a clock, in a comment or a line above a table, whatever
//! sign stands between key and number.
//!
//! A number is a clock's unless a word near it says what else it is: the corner of a filter, a duration, a
//! trigger. A word for sampling, or none, leaves it to be compared.

use super::clock::RateStatement;
use crate::text::header_number;
use crate::words::{Words, word_list};
use latchgate_kernel::units::TimeUnit;

// The head of the list explains it.
static WORDS: Words = word_list!("clock-words");

/// Longest interval of samples [s]: where words say that it is one, where they speak of samples, and where no word
/// says what it is.
const LONGEST_STATED_S: f64 = 0.1;
const LONGEST_OF_CLOCK_S: f64 = 0.01;
const LONGEST_UNNAMED_S: f64 = 1e-3;

/// A rate or an interval in a text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WordedClock {
    pub(crate) rate: RateStatement,
    /// True if a word says that it is of samples.
    pub(crate) is_named: bool,
    pub(crate) has_unit: bool,
}

/// What the words near a number say of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Subject {
    Unknown,
    Rate,
    Interval,
    Clock,
    Other,
}

impl Subject {
    fn of_word(word: &str) -> Self {
        let topic = WORDS.iter().find_map(|line| {
            let (entry, topic) = line.split_once('\t')?;
            let is_it = match entry.strip_suffix('*') {
                Some(stem) => word.starts_with(stem),
                None => word == entry,
            };
            is_it.then_some(topic)
        });
        match topic {
            Some("rate") => Self::Rate,
            Some("interval") => Self::Interval,
            Some("clock") => Self::Clock,
            Some("other") => Self::Other,
            _ => Self::Unknown,
        }
    }

    /// Of all words of a text: one that names something else decides, else the last that names a clock.
    fn of(text: &str) -> Self {
        let words = text.split(|c: char| !c.is_alphanumeric());
        let words = words.filter(|word| !word.is_empty()).map(str::to_lowercase);
        words.fold(Self::Unknown, |before, word| {
            match (before, Self::of_word(&word)) {
                (Self::Other, _) | (_, Self::Other) => Self::Other,
                (_, Self::Unknown | Self::Clock) if before != Self::Unknown => before,
                (_, of_word) => of_word,
            }
        })
    }
}

/// A number in a text: where it begins and ends, and what it may mean.
struct WrittenNumber<'a> {
    begin: usize,
    end: usize,
    printed: &'a str,
    values: Vec<f64>,
}

/// Returns the rates and intervals that a line states, in order.
pub(crate) fn worded_clocks(line: &str) -> Vec<WordedClock> {
    let numbers = numbers(line);
    let mut clocks = Vec::new();
    let (mut from, mut inherited) = (0, Subject::Unknown);
    for (index, number) in numbers.iter().enumerate() {
        // The 1 of `1/s` is of the unit before it.
        if number.begin < from {
            continue;
        }
        let after = &line[number.end..];
        let unit = ClockUnit::leading(after);
        let mut before = &line[from..number.begin];
        let unit_s = match unit {
            Some((unit, length)) => {
                from = number.end + length;
                Some(unit)
            }
            None => {
                from = number.end;
                // A number of another unit is no clock's.
                let is_bare = !after.trim_start().starts_with(char::is_alphabetic);
                let trailing = ClockUnit::trailing(before).filter(|_| is_bare);
                trailing.map(|(unit, begin)| {
                    before = &before[..begin];
                    unit
                })
            }
        };
        let own = Subject::of(before);
        let begins_anew = before.contains([';', '|', '\t']) || before.contains(". ");
        let subject = match (own, begins_anew) {
            (Subject::Unknown, false) => inherited,
            (own, _) => own,
        };
        let subject = match subject {
            Subject::Unknown => {
                let next = numbers.get(index + 1).map(|one| one.begin);
                let behind = line.get(from..next.unwrap_or(line.len())).unwrap_or("");
                match behind.split_once([',', ';', '|', '\t']) {
                    Some((clause, _)) => Subject::of(clause),
                    None if next.is_none() => Subject::of(behind),
                    // Words before another number are that number's.
                    None => Subject::Unknown,
                }
            }
            subject => subject,
        };
        inherited = subject;
        let rates = match (unit_s, own) {
            (Some(unit), _) => unit.rates(&number.values, subject),
            (None, Subject::Rate | Subject::Interval) if is_alone(after) => {
                unitless(&number.values, own)
            }
            _ => Vec::new(),
        };
        if subject != Subject::Other && !rates.is_empty() {
            clocks.push(WordedClock {
                rate: RateStatement::of(rates, number.printed),
                is_named: subject != Subject::Unknown,
                has_unit: unit_s.is_some(),
            });
        }
    }
    clocks
}

/// True if no unit follows a number.
fn is_alone(after: &str) -> bool {
    !after
        .trim_start_matches([' ', '(', '['])
        .starts_with(char::is_alphabetic)
}

/// Returns the rates that a number without a unit may mean [Hz].
fn unitless(values: &[f64], subject: Subject) -> Vec<f64> {
    let of_value = |value: &f64| match subject {
        Subject::Rate => vec![*value, 1e3 * value],
        _ => [1.0, 1e3, 1e6].map(|factor| factor / value).into(),
    };
    fitting(values.iter().flat_map(of_value))
}

fn fitting(rates: impl Iterator<Item = f64>) -> Vec<f64> {
    rates
        .filter(|rate| rate.is_finite() && *rate > 0.0)
        .collect()
}

/// The unit of a rate or of an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ClockUnit {
    /// So many samples a second.
    Hertz(f64),
    /// So many seconds.
    Seconds(f64),
}

impl ClockUnit {
    fn of(spelling: &str) -> Option<Self> {
        let is_word = spelling.starts_with(|c: char| c.is_alphabetic() || c == '1');
        let seconds = || TimeUnit::from_spelling(spelling).filter(|_| !spelling.starts_with('1'));
        let known = hertz_of_unit(spelling).map(Self::Hertz);
        known
            .or_else(|| Some(Self::Seconds(seconds()?.to_seconds(1.0))))
            .filter(|_| is_word)
    }

    /// Returns the unit at the begin of a text, in brackets or not, and where it ends: the longest.
    fn leading(text: &str) -> Option<(Self, usize)> {
        let begin = text.len() - text.trim_start_matches([' ', '(', '[']).len();
        let rest = &text[begin..];
        let ends = rest.char_indices().map(|(index, _)| index);
        let ends = ends.chain([rest.len()]).take(LONGEST_UNIT);
        let ends: Vec<usize> = ends.collect();
        ends.into_iter().rev().find_map(|end| {
            let is_whole = !rest[end..].starts_with(|c: char| c.is_alphanumeric() || c == '/');
            let unit = Self::of(&rest[..end]).filter(|_| is_whole)?;
            Some((unit, begin + end))
        })
    }

    /// Returns the unit at the end of a text, before signs such as a colon, and where it begins: the longest.
    fn trailing(text: &str) -> Option<(Self, usize)> {
        let rest = text.trim_end_matches([' ', '\t', ')', ']', ':', '=', ',', ';', '-', '"', '\'']);
        let begins = rest.char_indices().rev().map(|(index, _)| index);
        let begins: Vec<usize> = begins.take(LONGEST_UNIT).collect();
        begins.into_iter().rev().find_map(|begin| {
            let is_whole = !rest[..begin].ends_with(|c: char| c.is_alphanumeric() || c == '/');
            let unit = Self::of(&rest[begin..]).filter(|_| is_whole)?;
            Some((unit, begin))
        })
    }

    /// Returns the rates that numbers of this unit may mean [Hz], on this subject.
    fn rates(self, values: &[f64], subject: Subject) -> Vec<f64> {
        let longest_s = match subject {
            Subject::Interval | Subject::Rate => LONGEST_STATED_S,
            Subject::Clock => LONGEST_OF_CLOCK_S,
            Subject::Unknown | Subject::Other => LONGEST_UNNAMED_S,
        };
        let of_value = |value: &f64| match self {
            Self::Hertz(hertz) => Some(value * hertz),
            Self::Seconds(seconds) => {
                let interval_s = value * seconds;
                // A number written for a person is off by last bits.
                (interval_s <= longest_s * (1.0 + 1e-9)).then_some(1.0 / interval_s)
            }
        };
        fitting(values.iter().filter_map(of_value))
    }
}

/// Most characters of a unit: `samples per second` has 18.
const LONGEST_UNIT: usize = 20;

/// Returns the number of samples a second in one of a unit.
pub(crate) fn hertz_of_unit(unit: &str) -> Option<f64> {
    let unit = unit.trim().to_lowercase();
    match unit.as_str() {
        "hz" | "hertz" | "1/s" | "s/s" | "sa/s" | "sps" => return Some(1.0),
        "khz" | "kilohertz" | "ks/s" | "ksa/s" | "ksps" => return Some(1e3),
        "mhz" | "megahertz" | "ms/s" | "msa/s" | "msps" => return Some(1e6),
        _ => {}
    }
    let (sample, second) = ["/", " per ", " a ", "per "]
        .iter()
        .find_map(|sign| unit.split_once(sign))?;
    let samples = [
        "", "sample", "samples", "scans", "points", "pts", "readings", "werte",
    ];
    let seconds = ["s", "sec", "second", "sekunde"];
    let is_rate = samples.contains(&sample.trim()) && seconds.contains(&second.trim());
    is_rate.then_some(1.0)
}

/// Returns the numbers in a text, without digits of names (`J211`), dates, times of day and versions.
fn numbers(text: &str) -> Vec<WrittenNumber<'_>> {
    let bytes = text.as_bytes();
    let is_digit = |index: usize| bytes.get(index).is_some_and(u8::is_ascii_digit);
    let mut numbers = Vec::new();
    let mut next = 0;
    while next < bytes.len() {
        let begins = is_digit(next) || (bytes[next] == b'.' && is_digit(next + 1));
        if !begins {
            next += 1;
            continue;
        }
        let begin = next;
        // A group of digits, with one sign between any two.
        while next < bytes.len()
            && (is_digit(next) || (b".,'".contains(&bytes[next]) && is_digit(next + 1)))
        {
            next += 1;
        }
        let exponent = matches!(bytes.get(next), Some(b'e' | b'E')).then(|| {
            let sign = usize::from(matches!(bytes.get(next + 1), Some(b'+' | b'-')));
            next + 1 + sign
        });
        if let Some(digits) = exponent.filter(|digits| is_digit(*digits)) {
            next = digits;
            while is_digit(next) {
                next += 1;
            }
        }
        let before = text[..begin].chars().next_back();
        let part_of_name = before.is_some_and(char::is_alphabetic);
        let joins = |sign: Option<u8>| sign.is_some_and(|sign| b"/:-".contains(&sign));
        let joined_before = joins(begin.checked_sub(1).map(|at| bytes[at]))
            && begin.checked_sub(2).is_some_and(is_digit);
        let joined_after = joins(bytes.get(next).copied()) && is_digit(next + 1);
        if part_of_name || joined_before || joined_after {
            continue;
        }
        let printed = &text[begin..next];
        let values = values(printed);
        if !values.is_empty() {
            numbers.push(WrittenNumber {
                begin,
                end: next,
                printed,
                values,
            });
        }
    }
    numbers
}

/// Returns what a printed number may mean: a sign before three digits at its end may part thousands.
fn values(printed: &str) -> Vec<f64> {
    let mut parts = printed.split([',', '.', '\'']);
    let first = parts.next().unwrap_or_default();
    let groups: Vec<&str> = parts.collect();
    let may_be_thousands = (1..=3).contains(&first.len())
        && !first.starts_with('0')
        && !groups.is_empty()
        && groups
            .iter()
            .all(|group| group.len() == 3 && group.bytes().all(|byte| byte.is_ascii_digit()));
    let whole = || printed.replace([',', '.', '\''], "").parse::<f64>().ok();
    let decimal = || header_number(printed).filter(|_| groups.len() < 2 && !printed.contains('\''));
    let mut values: Vec<f64> = decimal().into_iter().collect();
    if may_be_thousands {
        values.extend(whole());
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examine::clock::Relation;

    /// What lines say of a clock of 10 kHz.
    #[test]
    fn val_lines_that_state_a_clock_of_ten_kilohertz() {
        for line in [
            "Sampling Frequency - 10000",
            "Scan rate (Hz) 10000",
            "Rate 10 kS/s",
            "10 kHz",
            "one sample every 100 us",
            "Frequency: 10000",
            "XINCR 1.0E-4",
            "SR,10000 Hz",
            "10,000 Hz",
            "10'000 Hz",
            "Sampling,10000 per second",
            "10 kHz (nominal)",
            "10000 1/s",
            "Sampled at 10 kHz, anti-alias filter 2 kHz",
            "Filter CFC 180, 300 Hz; sampling frequency 10 kHz",
            "samples per second: 10000",
            "10000 samples per second",
            "dt_us 100",
            "Abtastrate = 10,0 kHz",
            "17/11/2010 10:25:13 recorded at 10000 S/s",
            "resolution 0.1 ms",
            "time step 0.0001",
            "100 us",
        ] {
            let clocks = worded_clocks(line);
            let [clock] = clocks.as_slice() else {
                panic!("{line}: {clocks:?}");
            };
            assert_eq!(clock.rate.relation(1e4), Relation::Confirmed, "{line}");
            assert_eq!(clock.rate.relation(2e4), Relation::Contradicted, "{line}");
            let is_bare = line.starts_with("10") || line.starts_with("samples");
            assert_eq!(clock.is_named, !is_bare, "{line}");
        }
    }

    /// What says nothing of a clock.
    #[test]
    fn val_lines_that_state_no_clock() {
        for line in [
            "CFC 1000, 1650 Hz",
            "anti-alias filter 4 kHz",
            "4 kHz low pass",
            "cutoff frequency 1650 Hz",
            "Duration: 260 ms",
            "pulse of 11 ms",
            "0.5 ms delay of the trigger",
            "time zero 0.1 ms before contact",
            "mounted resonance 26 kHz",
            "camera frame rate 1000 Hz",
            "Test 7292, 17/11/2010",
            "J211 class 1000",
            "113.4 km/h",
            "12:30:15 s",
            "Number of samples 2600",
            "airbag fired at 0.5 ms",
            "serial rate 115200 baud",
            "range 2000 g",
            "",
        ] {
            assert_eq!(worded_clocks(line), [], "{line}");
        }
    }

    /// Whatever a line holds, it is read.
    #[test]
    fn prop_any_line_is_read() {
        const PIECES: [&str; 24] = [
            "0",
            "1",
            "9",
            "10",
            ".",
            ",",
            "'",
            "e",
            "-",
            "/",
            ":",
            ";",
            " ",
            "(",
            "]",
            "Hz",
            "kS/s",
            "1/s",
            "µs",
            "per second",
            "sample",
            "filter",
            "間",
            "s",
        ];
        let mut state = 1_u64;
        for _ in 0..20_000 {
            let mut line = String::new();
            for _ in 0..12 {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                line += PIECES[(state >> 33) as usize % PIECES.len()];
            }
            for clock in worded_clocks(&line) {
                assert!(!clock.rate.rates().is_empty(), "{line}");
            }
        }
    }
}
