//! Headers: names, units, and what a column's name says about its content.

use crate::recording::Finding;
use crate::units::{AccelerationUnit, TimeUnit};

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
        let (label, unit) = split_unit(cell);
        let mut column = Self {
            name: cell.to_string(),
            label,
            ..Self::default()
        };
        if let Some(unit) = unit {
            column.take_unit(&unit, "header");
        }
        column
    }

    /// Takes in the cell of a units row. Returns false if it contradicts the header cell.
    pub(in crate::recording) fn take_units_row(&mut self, cell: &str) -> bool {
        let text = strip_brackets(cell.trim());
        if text.is_empty() || text == "-" {
            return true;
        }
        let before = (self.unit, self.time_unit);
        let mut stated = Self::default();
        stated.take_unit(text, "units row");
        if (before.0.is_some() || before.1.is_some()) && before != (stated.unit, stated.time_unit) {
            return false;
        }
        self.take_unit(text, "units row");
        true
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
        matches!(
            words(&self.label).join(" ").as_str(),
            "index"
                | "idx"
                | "i"
                | "n"
                | "nr"
                | "no"
                | "number"
                | "sample"
                | "samples"
                | "sample no"
                | "sample nr"
                | "sample number"
                | "sample index"
                | "count"
                | "counter"
                | "row"
                | "line"
                | "scan"
                | "scan number"
                | "messwert nr"
                | "nummer"
        ) || self.label == "#"
    }

    /// Tells whether the name says lateral acceleration.
    pub(in crate::recording) fn says_lateral_acceleration(&self) -> bool {
        if self.has_foreign_unit() {
            return false;
        }
        let words = words(&self.label);
        let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
        if has(OTHER_MOTIONS) {
            return false;
        }
        let accelerates = has(ACCELERATION) || self.unit.is_some();
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
        numbered(LATERAL_ACCELERATION)
            || (accelerates && numbered(LATERAL))
            || is_mme_lateral(&self.label)
    }

    /// Tells whether the name says a second sensor at a place that has one.
    pub(in crate::recording) fn says_redundant(&self) -> bool {
        let words = words(&self.label);
        words
            .iter()
            .any(|word| matches!(word.as_str(), "redundant" | "red" | "backup" | "secondary"))
    }

    /// Takes the unit that stands in a header line of its own.
    pub(in crate::recording) fn with_unit(mut self, text: &str) -> Self {
        let text = strip_brackets(text.trim());
        if !text.is_empty() {
            self.take_unit(text, "header");
        }
        self
    }

    /// Tells whether the name says a place that is not the vehicle's structure.
    pub(in crate::recording) fn says_elsewhere(&self) -> bool {
        self.says(OFF_THE_STRUCTURE)
    }

    fn says(&self, list: &[&str]) -> bool {
        let words = words(&self.label);
        words.iter().any(|word| list.contains(&word.as_str()))
    }

    /// Warns of a name that says another axis than the lateral one, a dummy or a barrier.
    pub(in crate::recording) fn not_lateral_finding(&self) -> Option<Finding> {
        let reason = if self.says(OTHER_AXES) && !self.says_lateral_acceleration() {
            "says another axis than the lateral one"
        } else if self.says_elsewhere() {
            "says a dummy or a barrier, not the vehicle's structure"
        } else {
            return None;
        };
        Some(Finding::warning(
            "channel-not-lateral",
            format!("the name of `{}` {reason}", self.name),
        ))
    }
}

/// Words for acceleration.
const ACCELERATION: &[&str] = &[
    "a",
    "ac",
    "acc",
    "accel",
    "acceleration",
    "accelerometer",
    "beschl",
    "beschleunigung",
];

/// Words for the lateral axis.
const LATERAL: &[&str] = &["y", "yl", "yg", "lat", "lateral", "quer"];

/// Words that say both.
const LATERAL_ACCELERATION: &[&str] = &[
    "ay",
    "accy",
    "accely",
    "accelerationy",
    "acy",
    "yacc",
    "yaccel",
    "alat",
    "aquer",
    "querbeschleunigung",
];

/// Words for the other axes.
const OTHER_AXES: &[&str] = &[
    "x",
    "z",
    "xl",
    "zl",
    "xg",
    "zg",
    "ax",
    "az",
    "accx",
    "accz",
    "accelx",
    "accelz",
    "acx",
    "acz",
    "longitudinal",
    "long",
    "vertical",
    "resultant",
    "längs",
    "hoch",
];

/// Words for places in a dummy or on a barrier.
const OFF_THE_STRUCTURE: &[&str] = &[
    "dummy", "head", "neck", "chest", "thorax", "spine", "rib", "ribs", "shoulder", "abdomen",
    "pelvis", "femur", "tibia", "barrier", "mdb", "kopf", "brust", "becken", "barriere",
];

/// Words for motions that are no linear acceleration.
const OTHER_MOTIONS: &[&str] = &[
    "angular",
    "ang",
    "rot",
    "rotational",
    "gyro",
    "gyroscope",
    "jerk",
    "velocity",
    "speed",
    "displacement",
    "force",
    "mag",
    "magnetic",
];

/// Units that tell that a header cell's brackets hold a unit, though none of acceleration.
const FOREIGN_UNITS: &[&str] = &[
    "V", "mV", "µV", "N", "kN", "Nm", "N·m", "mm", "cm", "m", "m/s", "km/h", "mph", "deg", "°",
    "deg/s", "°/s", "rad", "rad/s", "rad/s2", "rad/s^2", "rad/s²", "deg/s2", "deg/s^2", "°/s²",
    "%", "bar", "kPa", "Pa", "MPa", "°C", "K", "Hz", "µm/m", "A", "mA", "kg", "m/s3", "m/s^3",
    "cm/s2", "cm/s^2", "cm/s²", "gal", "mg", "µg", "in/s2", "in/s^2",
];

fn says_time(label: &str) -> bool {
    let words = words(label);
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    match words.as_slice() {
        [only]
            if [
                "t",
                "sec",
                "secs",
                "second",
                "seconds",
                "ms",
                "msec",
                "millis",
                "milliseconds",
                "us",
                "usec",
                "microseconds",
            ]
            .contains(&only.as_str()) =>
        {
            true
        }
        _ => has(&[
            "time",
            "zeit",
            "timestamp",
            "temps",
            "tiempo",
            "tempo",
            "tijd",
            "czas",
        ]),
    }
}

/// Tells whether a name is an ISO/TS 13499 channel code for a lateral acceleration: 16
/// characters with the dimension AC and the direction Y.
fn is_mme_lateral(label: &str) -> bool {
    let code = label.as_bytes();
    code.len() == 16
        && code
            .iter()
            .all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit() || *byte == b'?')
        // Direction 2 is Y with a sign that diverges from SAE J211.
        && (&code[12..15] == b"ACY" || &code[12..15] == b"AC2")
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

/// Splits a header cell into its label and its unit.
fn split_unit(cell: &str) -> (String, Option<String>) {
    let mut bracketed = bracketed_units(cell);
    let found = match bracketed.len() {
        0 => unit_after_word(cell).or_else(|| unit_suffix(cell)),
        1 => bracketed.pop(),
        // Two units in one cell say nothing for sure.
        _ => None,
    };
    found.map_or_else(
        || (cell.to_string(), None),
        |(label, unit)| (label.trim().to_string(), Some(unit)),
    )
}

/// Finds `a (m/s^2)`, `Time [s]`, `acc (g) y`; brackets may hold brackets, as in `(m/(s*s))`.
fn bracketed_units(cell: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut opened: Vec<usize> = Vec::new();
    for (index, character) in cell.char_indices() {
        match character {
            '(' | '[' | '{' => opened.push(index),
            ')' | ']' | '}' => {
                let Some(start) = opened.pop() else { continue };
                if !opened.is_empty() {
                    continue;
                }
                let content = cell[start + 1..index].trim();
                if is_known_unit(content) || FOREIGN_UNITS.contains(&content) {
                    let rest = &cell[index + 1..];
                    found.push((format!("{} {rest}", &cell[..start]), content.to_string()));
                }
            }
            _ => {}
        }
    }
    found
}

/// Finds `a / m/s^2`, `t/s`, `a in g`, `a, g` and `Acceleration y g`, provided that the words
/// before mean what the unit measures: in `v m/s` the `s` is no unit of time.
fn unit_after_word(cell: &str) -> Option<(String, String)> {
    let fits = |label: &str, unit: &str| {
        let means = |list: &[&str]| words(label).iter().any(|w| list.contains(&w.as_str()));
        if AccelerationUnit::from_spelling(unit).is_some() {
            means(ACCELERATION) || means(LATERAL_ACCELERATION) || means(LATERAL)
        } else {
            TimeUnit::from_spelling(unit).is_some() && says_time(label)
        }
    };
    [" / ", " in ", ", ", "/"]
        .iter()
        .filter_map(|separator| cell.split_once(separator))
        .chain(cell.rsplit_once(' '))
        .find(|(label, unit)| fits(label, unit))
        .map(|(label, unit)| (label.to_string(), unit.trim().to_string()))
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

fn unit_suffix(cell: &str) -> Option<(String, String)> {
    let lower = cell.to_ascii_lowercase();
    let ends_with = |list: &[(&'static str, &'static str)]| {
        list.iter().find_map(|(ending, unit)| {
            let label = lower.strip_suffix(ending)?;
            (!label.is_empty()).then(|| (cell[..label.len()].to_string(), (*unit).to_string()))
        })
    };
    ends_with(SUFFIXES)
        .or_else(|| ends_with(TIME_SUFFIXES).filter(|(label, _)| says_time(label)))
        .or_else(|| {
            // `seconds` and `ms` are name and unit at once.
            (says_time(cell) && TimeUnit::from_spelling(cell).is_some())
                .then(|| (cell.to_string(), cell.to_string()))
        })
}
