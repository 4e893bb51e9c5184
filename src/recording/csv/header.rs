//! Headers: names, units, and what a column's name says about its content.
//!
//! - `derived`: names of what was computed from an acceleration, or is none: rectified, held,
//!   averaged, modelled;
//! - `filtered`: words that say that a channel was filtered before it was stored;
//! - `place`: names of places: what is not the structure of the struck vehicle.

mod derived;
pub(in crate::recording) mod filtered;
mod place;

use crate::recording::words::{Words, word_list};
use crate::recording::{Finding, Stated};
use crate::units::{AccelerationUnit, TimeUnit};
use filtered::Filtered;
use place::Coded;

/// A column as its header describes it.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::recording) struct Column {
    /// The header cell as it stands, or `column N`.
    pub(in crate::recording) name: String,
    /// The header cell without a unit that was recognised in it.
    pub(in crate::recording) label: String,
    /// The unit as it stands, be it one of acceleration or not.
    pub(in crate::recording) unit_text: Option<String>,
    /// The unit of acceleration.
    pub(in crate::recording) unit: Option<AccelerationUnit>,
    /// What states the unit: `header` or `units row`.
    pub(in crate::recording) unit_source: &'static str,
    /// The unit of time.
    pub(in crate::recording) time_unit: Option<TimeUnit>,
    /// Whether the header cell holds what looks like a unit and does not say what one of the
    /// column's numbers is, such as `100 us`, `mV / g` or `_min`.
    pub(in crate::recording) doubtful: bool,
}

impl Column {
    /// Describes a column without a header; `number` counts from 1.
    pub(in crate::recording) fn unnamed(number: usize) -> Self {
        Self {
            name: format!("column {number}"),
            ..Self::default()
        }
    }

    /// Reads a header cell.
    pub(in crate::recording) fn from_header(cell: &str, number: usize) -> Self {
        let cell = cell.trim();
        if cell.is_empty() {
            return Self::unnamed(number);
        }
        let mut column = Self {
            name: cell.to_string(),
            label: cell.to_string(),
            ..Self::default()
        };
        match find_unit(cell) {
            Found::Unit(label, unit) => {
                column.label = label.trim().to_string();
                column.take_unit(&unit, "header");
            }
            Found::Doubtful => column.doubtful = true,
            Found::Nothing => column.doubtful = says_time(cell) && says_other_time(cell),
        }
        column
    }

    /// Takes in the cell of a units row. Returns false if it contradicts the header cell.
    pub(in crate::recording) fn take_units_row(&mut self, cell: &str) -> bool {
        let text = strip_brackets(cell.trim());
        if text.is_empty() || text == "-" {
            return true;
        }
        if self.doubtful {
            return false;
        }
        if self.is_contradicted_by(text) {
            return false;
        }
        self.take_unit(text, "units row");
        true
    }

    /// Tells whether the header cell states another unit than `text`, or holds what makes
    /// another one of it: a number, a prefix, arithmetic.
    fn is_contradicted_by(&self, text: &str) -> bool {
        let before = (self.unit, self.time_unit);
        let mut stated = Self::default();
        stated.take_unit(text, "units row");
        let after = (stated.unit, stated.time_unit);
        if before != (None, None) {
            return before != after;
        }
        // `acc y (V)` over `g`.
        let foreign = self.unit_text.is_some() && after != (None, None);
        foreign
            || (after.0.is_some()
                && (is_scaled(&self.label, "")
                    || says_other_unit(&self.label, "", text)
                    || is_spoilt(&self.label, "")))
    }

    fn take_unit(&mut self, text: &str, source: &'static str) {
        self.unit_text = Some(text.to_string());
        self.unit = AccelerationUnit::from_spelling(text);
        self.time_unit = TimeUnit::from_spelling(text);
        self.unit_source = source;
    }

    /// Tells whether the header states a unit that is not one of acceleration.
    pub(in crate::recording) fn has_foreign_unit(&self) -> bool {
        self.unit_text.is_some() && self.unit.is_none()
    }

    /// Tells whether the name is one for time.
    pub(in crate::recording) fn says_time(&self) -> bool {
        says_time(&self.label)
    }

    /// Tells whether the name is one for a running number.
    pub(in crate::recording) fn says_index(&self) -> bool {
        INDEX.contains(&words(&self.label).join(" ").as_str()) || self.label == "#"
    }

    /// Tells whether the name says lateral acceleration.
    pub(in crate::recording) fn says_lateral_acceleration(&self) -> bool {
        if self.has_foreign_unit() {
            return false;
        }
        let words = words(&self.label);
        let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
        if self.is_no_acceleration() {
            return false;
        }
        let accelerates = has(&ACCELERATION) || self.unit.is_some();
        // `acc_y2` is a second sensor of that axis.
        let numbered = |list: &[&str]| {
            let bare = |word: &String| {
                word.trim_end_matches(|c: char| c.is_ascii_digit())
                    .to_string()
            };
            words
                .iter()
                .map(bare)
                .any(|word| list.contains(&word.as_str()))
        };
        numbered(&LATERAL_ACCELERATION)
            || (accelerates && numbered(&LATERAL))
            || place::code_in(&self.label).is_some_and(|code| code.is_lateral())
    }

    /// Tells whether the name says something computed, or another quantity.
    fn is_no_acceleration(&self) -> bool {
        derived::says_computed(&self.label)
            || derived::says_other_quantity(&self.label)
            || place::coded(&self.label) == Some(Coded::OtherQuantity)
    }

    /// Tells whether the name says a second sensor at a place that has one.
    pub(in crate::recording) fn says_redundant(&self) -> bool {
        let words = words(&self.label);
        words
            .iter()
            .any(|word| matches!(word.as_str(), "redundant" | "red" | "backup" | "secondary"))
    }

    /// Takes the unit that stands in a header line of its own. Where it contradicts the name,
    /// neither counts.
    pub(in crate::recording) fn with_unit(mut self, text: &str) -> Self {
        let text = strip_brackets(text.trim());
        if text.is_empty() {
            return self;
        }
        if self.doubtful || self.is_contradicted_by(text) {
            return Self {
                doubtful: true,
                unit_text: None,
                unit: None,
                unit_source: "",
                time_unit: None,
                ..self
            };
        }
        self.take_unit(text, "header");
        self
    }

    /// Tells whether the name says a place that is not the structure of the struck vehicle.
    pub(in crate::recording) fn says_elsewhere(&self) -> bool {
        place::says_elsewhere(&self.label)
    }

    fn says(&self, list: &[&str]) -> bool {
        let words = words(&self.label);
        words.iter().any(|word| list.contains(&word.as_str()))
    }

    /// Warns of a name that says another axis than the lateral one, a dummy, a barrier, another
    /// quantity, or what was computed.
    pub(in crate::recording) fn not_lateral_finding(&self) -> Option<Finding> {
        let reason = if self.is_no_acceleration() && derived::says_computed(&self.label) {
            "says something derived or computed, not an acceleration as it was measured, with its \
             sign"
        } else if self.is_no_acceleration() {
            "says another quantity than a linear acceleration"
        } else if (self.says(&OTHER_AXES) && !self.says_lateral_acceleration())
            || place::coded(&self.label) == Some(Coded::OtherAxis)
        {
            "says another axis than the lateral one"
        } else if self.says_elsewhere() {
            "says a dummy, a barrier or another place, not the structure of the struck vehicle"
        } else {
            return None;
        };
        Some(Finding::warning(
            "channel-not-lateral",
            format!("the name of `{}` {reason}", self.name),
        ))
    }

    /// Returns what the name says of the filter that was applied.
    fn filter(&self) -> Option<Filtered> {
        let coded = place::code_in(&self.name).and_then(|code| code.filter_class());
        let stated = coded.map(|class| Filtered::Class(class.to_string()));
        stated.or_else(|| filtered::filter_in(&self.name))
    }

    /// Tells whether the name says that the samples were filtered.
    pub(in crate::recording) fn says_filtered(&self) -> bool {
        self.filter().is_some()
    }

    /// Tells whether the name is that of `other` but for words that `other` has beside it.
    pub(in crate::recording) fn is_short_for(&self, other: &Self) -> bool {
        let others = words(&other.label);
        let own = words(&self.label);
        !own.is_empty() && own.iter().all(|word| others.contains(word))
    }

    /// Returns what the name states beside axis and unit.
    pub(in crate::recording) fn stated(&self) -> Stated {
        Stated {
            filter_class: match self.filter() {
                Some(Filtered::Class(class)) => Some(class),
                _ => None,
            },
            ..Stated::default()
        }
    }

    /// Returns what else the name says that bears on the samples: a filter without a class, a
    /// code whose sign is another one.
    pub(in crate::recording) fn name_findings(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        if self.filter() == Some(Filtered::Unclassed) {
            found.push(Finding::warning(
                "already-filtered",
                format!(
                    "the name of `{}` says that the channel was filtered, not with which class; \
                     what that took away no choice of filter brings back",
                    self.name
                ),
            ));
        }
        if let Some(code) = place::code_in(&self.name).filter(|code| code.diverges()) {
            found.push(Finding::warning(
                "sign-diverges",
                format!(
                    "{} has a direction whose sign diverges from SAE J211: state with \
                     the setting `opens_when` which sign of these samples opens",
                    code.text()
                ),
            ));
        }
        found
    }
}

/// Words for acceleration.
static ACCELERATION: Words = word_list!("name-acceleration");

/// Words for the lateral axis.
static LATERAL: Words = word_list!("name-lateral");

/// Words that say both.
static LATERAL_ACCELERATION: Words = word_list!("name-lateral-acceleration");

/// Words for the other axes.
static OTHER_AXES: Words = word_list!("name-other-axes");

/// Units that tell that a header cell's brackets hold a unit, though none of acceleration.
static FOREIGN_UNITS: Words = word_list!("name-other-units");

/// Names of a column that counts the rows.
static INDEX: Words = word_list!("name-index");

/// Words of which one in a name says that a column holds times.
static TIMES: Words = word_list!("name-time");

/// Names of a column of times that are such only alone.
static TIMES_ALONE: Words = word_list!("name-time-alone");

fn says_time(label: &str) -> bool {
    let words = words(label);
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    match words.as_slice() {
        [only] if TIMES_ALONE.contains(&only.as_str()) => true,
        _ => has(&TIMES),
    }
}

/// Splits a name into lower-case words, at everything but letters and digits and where a
/// small letter meets a capital one (`accY`).
fn words(label: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut last_small = false;
    for character in label.chars() {
        if !character.is_alphanumeric() || (last_small && character.is_uppercase()) {
            words.push(String::new());
        }
        last_small = character.is_lowercase();
        if character.is_alphanumeric()
            && let Some(word) = words.last_mut()
        {
            word.extend(character.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Tells whether a text is a unit of acceleration or time.
pub(in crate::recording) fn is_known_unit(text: &str) -> bool {
    let text = strip_brackets(text.trim());
    AccelerationUnit::from_spelling(text).is_some() || TimeUnit::from_spelling(text).is_some()
}

fn strip_brackets(text: &str) -> &str {
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')] {
        if let Some(inner) = text.strip_prefix(open).and_then(|t| t.strip_suffix(close)) {
            return inner.trim();
        }
    }
    text
}

/// What a header cell says of its unit.
enum Found {
    /// The label and the unit.
    Unit(String, String),
    /// Something like a unit that says nothing for sure.
    Doubtful,
    Nothing,
}

/// Finds the unit in a header cell.
fn find_unit(cell: &str) -> Found {
    match bracketed_units(cell).as_slice() {
        [] => match unit_after_word(cell) {
            Found::Nothing => unit_suffix(cell),
            found => found,
        },
        [(before, content, after)] => {
            let known = is_known_unit(content);
            let doubtful = is_scaled(before, after)
                || says_other_unit(before, after, content)
                || is_spoilt(before, after);
            if known && doubtful {
                return Found::Doubtful;
            }
            Found::Unit(format!("{before} {after}"), (*content).to_string())
        }
        // Two units in one cell say nothing for sure.
        _ => Found::Doubtful,
    }
}

/// Finds `a (m/s^2)`, `Time [s]`, `acc (g) y`; brackets may hold brackets, as in `(m/(s*s))`.
/// Returns each with what stands before and after it.
fn bracketed_units(cell: &str) -> Vec<(&str, &str, &str)> {
    let mut found = Vec::new();
    let mut opened: Vec<(usize, char)> = Vec::new();
    for (index, character) in cell.char_indices() {
        match character {
            '(' => opened.push((index, ')')),
            '[' => opened.push((index, ']')),
            '{' => opened.push((index, '}')),
            ')' | ']' | '}' => {
                let Some((start, close)) = opened.pop() else {
                    continue;
                };
                if !opened.is_empty() || character != close {
                    continue;
                }
                let content = cell[start + 1..index].trim();
                if is_known_unit(content) || FOREIGN_UNITS.contains(&content) {
                    found.push((&cell[..start], content, &cell[index + 1..]));
                }
            }
            _ => {}
        }
    }
    found
}

/// Characters of arithmetic that no name holds.
const OPERATORS: [char; 8] = ['*', '×', '^', '=', '±', '·', '⋅', '%'];

/// Tells whether a word is a number, or a factor such as `x10`; `X1` is a sensor.
fn is_factor(word: &str) -> bool {
    let is_digit = |first: char| first.is_ascii_digit();
    let number = word.trim_start_matches(['/', '+', '-', '.']);
    let times = word.strip_prefix(['x', 'X']).unwrap_or_default();
    number.starts_with(is_digit) || (times.len() > 1 && times.starts_with(is_digit))
}

/// Tells whether arithmetic around a unit in brackets changes what it means: `(g) x10`,
/// `(m/s2) / g`, `acc/10 (g)`.
fn is_scaled(before: &str, after: &str) -> bool {
    let digit = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_digit);
    let computes = |text: &str| {
        let text: String = text.split_whitespace().collect();
        text.match_indices(['*', '×', '·', '⋅', '^', '/'])
            .any(|(at, operator)| {
                let left = digit(text.as_bytes()[..at].last());
                let right = digit(text.as_bytes().get(at + operator.len()));
                // `1/2` counts channels.
                if operator == "/" {
                    right && !left
                } else {
                    right || left
                }
            })
    };
    let words: Vec<&str> = before.split_whitespace().collect();
    let times = words
        .windows(2)
        .any(|pair| matches!(pair[0], "x" | "X") && is_factor(pair[1]));
    let after = after.trim_start();
    times
        || after.starts_with(['/', '*', '×', '·', '⋅', '^'])
        || after
            .split_whitespace()
            .any(|word| word.starts_with(['x', 'X']) && is_factor(word))
        || computes(before)
        || computes(after)
}

/// Tells whether the text around a unit in brackets names another one: `acc_y_g (m/s2)`.
fn says_other_unit(before: &str, after: &str, content: &str) -> bool {
    let meaning = |text: &str| {
        (
            AccelerationUnit::from_spelling(text),
            TimeUnit::from_spelling(text),
        )
    };
    let stated = meaning(strip_brackets(content));
    let tokens = before.split_whitespace().chain(after.split_whitespace());
    let mut others = tokens.filter(|token| {
        let found = meaning(token);
        (found != (None, None) && found != stated) || is_foreign(token)
    });
    let suffixed = match unit_suffix(before.trim()) {
        Found::Unit(_, unit) => meaning(&unit) != stated,
        _ => false,
    };
    suffixed || others.next().is_some()
}

/// Tells whether a word is another unit. Single letters may be parts of names, and so may bars.
fn is_foreign(word: &str) -> bool {
    word.chars().count() > 1 && word != "bar" && FOREIGN_UNITS.contains(&word)
}

/// Words that make another unit of the one behind them, or tell that it is not the column's.
static NO_NAMES: Words = word_list!("name-prefixes");

/// Words that scale, beside [`NO_NAMES`].
static SCALES: Words = word_list!("name-scales");

/// Tells whether the name around a unit in brackets, or over one in a row of units, holds what
/// makes another unit of it: `ay x10`, `ay counts`, `ay % of FS`, `ay E3`, `ay k`, `ay (100 g)`.
fn is_spoilt(before: &str, after: &str) -> bool {
    let bare = |word: &str| -> String {
        let edge = |c: char| matches!(c, '(' | ')' | '[' | ']' | '{' | '}' | ',' | ';' | ':');
        word.trim_matches(edge).to_string()
    };
    let tokens: Vec<String> = before
        .split_whitespace()
        .chain(after.split_whitespace())
        .map(bare)
        .collect();
    let small: Vec<String> = words(before).into_iter().chain(words(after)).collect();
    let scales =
        |word: &String| NO_NAMES.contains(&word.as_str()) || SCALES.contains(&word.as_str());
    // `x10`, and in a name that says the lateral axis already `x2`; `X1` is a sensor.
    let lateral = small.iter().any(|word| {
        LATERAL.contains(&word.as_str()) || LATERAL_ACCELERATION.contains(&word.as_str())
    });
    let times = |word: &String| {
        let digits = |text: &str| {
            !text.is_empty()
                && text
                    .chars()
                    .all(|c| c.is_ascii_digit() || matches!(c, '.' | ','))
        };
        let factor = |text: &str, least: usize| digits(text) && text.len() >= least;
        word.strip_prefix('x')
            .is_some_and(|rest| factor(rest, if lateral { 1 } else { 2 }))
            || word.strip_prefix('X').is_some_and(|rest| factor(rest, 2))
    };
    // `E3`, `1e-3`, `10E3`.
    let power = |word: &String| {
        word.split_once(['e', 'E'])
            .is_some_and(|(mantissa, power)| {
                let power = power.trim_start_matches(['+', '-']);
                mantissa.chars().all(|c| c.is_ascii_digit() || c == '.')
                    && !power.is_empty()
                    && power.chars().all(|c| c.is_ascii_digit())
            })
    };
    let prefix = before
        .split_whitespace()
        .last()
        .is_some_and(|word| matches!(word, "k" | "µ" | "μ"));
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    let stated = |word: &str| AccelerationUnit::from_spelling(word).is_some();
    let amount = tokens
        .windows(2)
        .any(|pair| is_number(&pair[0]) && stated(&pair[1]));
    before.contains(['%', '±'])
        || after.contains(['%', '±'])
        || small.iter().any(scales)
        || tokens.iter().any(|word| times(word) || power(word))
        || prefix
        || amount
}

/// Tells whether the text before a unit without brackets is a name and nothing else, so that
/// the unit is that of the column: no number, no prefix, no operator, no other unit. In
/// `suffixed` names, `acc_y_2_g`, a last part of one digit counts sensors.
fn is_name(label: &str, suffixed: bool) -> bool {
    let mut depth = 0_i32;
    for character in label.chars() {
        depth += i32::from(matches!(character, '(' | '[' | '{'));
        depth -= i32::from(matches!(character, ')' | ']' | '}'));
        if depth < 0 {
            return false;
        }
    }
    if depth != 0 || label.contains(OPERATORS) || (!suffixed && label.contains('/')) {
        return false;
    }
    let parts: Vec<&str> = label
        .split(|character: char| !character.is_alphanumeric())
        .filter(|part| !part.is_empty())
        .collect();
    let is_number = |part: &str| part.starts_with(|first: char| first.is_ascii_digit());
    let numbered = if suffixed {
        match parts.as_slice() {
            [.., before, last] if is_number(last) => {
                is_number(before) || last.len() > 1 || *last == "0"
            }
            _ => false,
        }
    } else {
        label.split_whitespace().any(is_factor)
    };
    let is_unit = |part: &str| {
        is_foreign(part)
            || AccelerationUnit::from_spelling(part).is_some()
            || TimeUnit::from_spelling(part).is_some()
    };
    let other = parts
        .iter()
        .any(|part| NO_NAMES.contains(&part.to_lowercase().as_str()) || is_unit(part));
    // Before a unit these are prefixes, a volt, or the word that leads to the unit.
    let spoilt = matches!(parts.last(), Some(&("k" | "m" | "µ" | "μ" | "V" | "in")));
    !numbered && !other && !spoilt
}

/// Words behind a name for time that are units and not read.
static OTHER_TIMES: Words = word_list!("name-other-times");

/// Tells whether a name for time holds a unit that is not read, or a number with a unit.
fn says_other_time(cell: &str) -> bool {
    words(cell).iter().any(|word| {
        OTHER_TIMES.contains(&word.as_str())
            || (word.starts_with(|first: char| first.is_ascii_digit())
                && word.chars().any(char::is_alphabetic))
    })
}

/// Finds `a / m/s^2`, `t/s`, `a in g`, `a, g` and `Acceleration y g`, provided that the words
/// before mean what the unit measures: in `v m/s` the `s` is no unit of time.
fn unit_after_word(cell: &str) -> Found {
    let fits = |label: &str, unit: &str| {
        let means = |list: &[&str]| words(label).iter().any(|w| list.contains(&w.as_str()));
        if AccelerationUnit::from_spelling(unit).is_some() {
            means(&ACCELERATION) || means(&LATERAL_ACCELERATION) || means(&LATERAL)
        } else {
            TimeUnit::from_spelling(unit).is_some() && says_time(label)
        }
    };
    let found = [" / ", " in ", ", ", "/"]
        .iter()
        .filter_map(|separator| cell.split_once(separator))
        .chain(cell.rsplit_once(' '))
        .find(|(label, unit)| fits(label, unit));
    match found {
        Some((label, unit)) if is_name(label, false) => {
            Found::Unit(label.to_string(), unit.trim().to_string())
        }
        Some(_) => Found::Doubtful,
        None => Found::Nothing,
    }
}

/// Endings of names that are units, with the unit they mean. `_ms2` is not among them, since it
/// may stand for m/s² as well as for ms².
const SUFFIXES: &[(&str, &str)] = &[
    ("_mm_ms2", "mm/ms2"),
    ("_mm_s2", "mm/s2"),
    ("_ft_s2", "ft/s2"),
    ("_m_s2", "m/s2"),
    ("_m_per_s2", "m/s2"),
    ("_mps2", "m/s2"),
    ("_m/s2", "m/s2"),
    ("_m/s^2", "m/s2"),
    ("_g", "g"),
];

/// Endings of names for time.
const TIME_SUFFIXES: &[(&str, &str)] = &[
    ("_s", "s"),
    ("_sec", "s"),
    ("_seconds", "s"),
    ("_ms", "ms"),
    ("_msec", "ms"),
    ("_us", "us"),
    ("_usec", "us"),
];

fn unit_suffix(cell: &str) -> Found {
    let lower = cell.to_ascii_lowercase();
    let ends_with = |list: &[(&'static str, &'static str)]| {
        list.iter().find_map(|(ending, unit)| {
            let label = lower.strip_suffix(ending)?;
            (!label.is_empty()).then(|| (cell[..label.len()].to_string(), (*unit).to_string()))
        })
    };
    let found = ends_with(SUFFIXES)
        .or_else(|| ends_with(TIME_SUFFIXES).filter(|(label, _)| says_time(label)));
    match found {
        Some((label, unit)) if is_name(&label, true) => Found::Unit(label, unit),
        Some(_) => Found::Doubtful,
        // `seconds` and `ms` are name and unit at once.
        None if says_time(cell) && TimeUnit::from_spelling(cell).is_some() => {
            Found::Unit(cell.to_string(), cell.to_string())
        }
        None => Found::Nothing,
    }
}
