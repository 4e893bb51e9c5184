//! The meaning of a channel's name: words, unit, time, and if it is plainly that of a lateral acceleration.
//!
//! A channel is chosen without being named where every word of its name is on a short list. Any other
//! word raises a doubt: the channel is offered, and a person chooses it or not.
//!
//! - `factor`: numbers that may be factors on the samples;
//! - `filtered`: words that say that a channel was filtered before it was stored;
//! - `gravity`: words that say that an acceleration holds gravity;
//! - `mangled`: names that R and MATLAB rewrote.

mod factor;
pub(crate) mod filtered;
pub(crate) mod gravity;
mod mangled;

use crate::code::Code;
use crate::words::{Words, word_list};
use crate::{Finding, ReadOptions, Stated};
use filtered::Filtered;
use latchgate_kernel::units::{AccelerationUnit, TimeUnit};

/// The name of a channel with its meaning, and the facts that rows above a table state of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct ChannelName {
    /// The header cell as written, or `column N`.
    pub(crate) name: String,
    /// The header cell without a unit that was recognised in it.
    pub(crate) label: String,
    /// The unit as written, of acceleration or not.
    pub(crate) unit_text: Option<String>,
    /// The unit of acceleration.
    pub(crate) unit: Option<AccelerationUnit>,
    /// Source of the unit: `header` or `units row`.
    pub(crate) unit_source: &'static str,
    /// The unit of time.
    pub(crate) time_unit: Option<TimeUnit>,
    /// True if the header holds something like a unit that does not fix the meaning of the column's
    /// numbers, such as `100 us`, `mV / g` or `_min`.
    pub(crate) doubtful: bool,
    /// The unit beside which a word may make another unit of it.
    doubted_unit: Option<String>,
    /// True if a stated sensitivity converts its numbers to accelerations.
    converted: bool,
    /// Its name in the rows above the table, which replaces the words of its header.
    described: Option<String>,
    /// Facts of its samples in the rows above the table.
    above: Stated,
    /// The acceleration beside it which shows that the `g` of its name is that of a turning rate.
    rival: Option<String>,
}

impl ChannelName {
    /// Describes a column without a header; `number` counts from 1.
    pub(crate) fn unnamed(number: usize) -> Self {
        Self {
            name: format!("column {number}"),
            ..Self::default()
        }
    }

    /// Reads a header cell.
    pub(crate) fn from_header(cell: &str, number: usize) -> Self {
        let cell = cell.trim();
        if cell.is_empty() {
            return Self::unnamed(number);
        }
        // The name that pandas gives to a column without one.
        let unnamed = cell.strip_prefix("Unnamed: ");
        if unnamed.is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit())) {
            return Self {
                name: cell.to_string(),
                ..Self::default()
            };
        }
        let mut column = Self {
            name: cell.to_string(),
            label: cell.to_string(),
            ..Self::default()
        };
        match bracketed_units(cell).as_slice() {
            [] => match mangled::name_and_unit(cell)
                .or_else(|| time_unit_at_the_end(cell))
                .or_else(|| unit_at_the_end(cell))
            {
                Some((label, unit)) if names_alone(&label, &unit) => {
                    column.label = label;
                    column.take_unit(&unit, "header");
                }
                unit_part => {
                    column.doubted_unit = unit_part.as_ref().map(|(_, unit)| unit.clone());
                    let odd = || !words(cell).iter().all(|word| is_time_word(word));
                    column.doubtful = unit_part.is_some() || (says_time(cell) && odd());
                    // `seconds` and `ms` are name and unit at once.
                    if says_time(cell) && TimeUnit::from_spelling(cell).is_some() {
                        column.take_unit(cell, "header");
                    }
                }
            },
            [(before, content, after)] => {
                column.label = format!("{before} {after}").trim().to_string();
                // No word beside a volt makes an acceleration of it, so that the unit still counts.
                if spoils_unit(&column.label) && !is_other_unit(content) {
                    column.doubtful = true;
                    column.doubted_unit = Some((*content).to_string());
                } else {
                    column.take_unit(content, "header");
                }
            }
            // Two units in one cell contradict each other.
            _ => column.doubtful = true,
        }
        column
    }

    /// Applies the unit beside the name, in a row of units or a header line of its own. Where it
    /// contradicts the name, neither counts.
    pub(crate) fn with_unit(mut self, text: &str, source: &'static str) -> Self {
        let text = strip_brackets(text.trim());
        if text.is_empty() || text == "-" {
            return self;
        }
        let acceleration = AccelerationUnit::from_spelling(text);
        let stated = (acceleration, time_unit_of(text, &self.label));
        let from_name = (self.unit, self.time_unit);
        let is_known = stated != (None, None);
        if (self.unit_text.is_some() && from_name != stated)
            || (is_known && spoils_unit(self.words()))
        {
            let texts = [self.unit_text.as_deref(), Some(text)];
            let other_unit = texts.into_iter().flatten().find(|text| is_other_unit(text));
            return Self {
                doubted_unit: Some(text.to_string()),
                unit_text: other_unit.map(String::from),
                unit_source: match other_unit == Some(text) {
                    true => source,
                    false => self.unit_source,
                },
                unit: None,
                time_unit: None,
                doubtful: true,
                ..self
            };
        }
        self.doubtful = false;
        self.take_unit(text, source);
        self
    }

    /// Sets the name in the rows above the table.
    pub(crate) fn describe(&mut self, words: String) {
        self.described = Some(words);
    }

    /// Sets the facts in the rows above the table.
    pub(crate) fn state(&mut self, stated: Stated) {
        self.above = stated;
    }

    /// True if a requested name is the column's name in the rows above the table.
    pub(crate) fn is_described_as(&self, requested: &str) -> bool {
        let described = self.described.as_deref().unwrap_or_default().to_lowercase();
        let mut words = described.split_whitespace();
        let is_name = described == requested || described.ends_with(&format!(" {requested}"));
        !requested.is_empty()
            && (is_name || words.any(|w| w == requested && Code::new(w).is_some()))
    }

    /// Returns the words by which the channel is judged.
    fn words(&self) -> &str {
        self.described.as_deref().unwrap_or(&self.label)
    }

    fn take_unit(&mut self, text: &str, source: &'static str) {
        self.unit_text = Some(text.to_string());
        self.unit = AccelerationUnit::from_spelling(text);
        self.time_unit = time_unit_of(text, &self.label);
        self.unit_source = source;
    }

    /// True if the header states a unit that is not one of acceleration.
    pub(crate) fn has_foreign_unit(&self) -> bool {
        self.unit_text.is_some() && self.unit.is_none() && !self.converted
    }

    /// Returns the unit as written, or, where none of acceleration is stated, the word of the name that is
    /// a unit of another quantity, as in `ay counts`, `ay_V` and `ay [V/V]`.
    pub(crate) fn stated_unit(&self) -> Option<String> {
        let word = || {
            let parts = self.words().split(|c: char| !c.is_alphanumeric());
            let mut words = parts.map(String::from).chain(words(self.words()));
            words.find(|word| OTHER_QUANTITIES.contains(&word.to_lowercase().as_str()))
        };
        let at_the_end = || {
            let label = self.words().trim_end();
            let marks = [" / ", " in ", "/"];
            let behind = marks.iter().filter_map(|mark| label.split_once(mark));
            let separators = [' ', '_'].into_iter();
            let last = separators.filter_map(|mark| label.rsplit_once(mark));
            let ends = behind.chain(last).map(|(_, text)| text);
            let quotient = |text: &&str| text.split('/').all(is_other_unit);
            let mut quotients = in_brackets(label).filter(quotient);
            quotients
                .next()
                .or_else(|| ends.into_iter().find(|text| is_other_unit(text)))
                .filter(|text| !is_plain_place(text))
                .map(String::from)
        };
        self.unit_text.clone().or_else(word).or_else(at_the_end)
    }

    /// Returns the text in the place of a unit that is not read as one: a unit with a word beside it that may
    /// make another unit of it, or words in brackets that name no place.
    pub(crate) fn unread_unit(&self) -> Option<String> {
        let doubted = self.doubted_unit.clone();
        let unread = |text: &&str| text.contains(char::is_alphanumeric) && !is_plain_place(text);
        let in_brackets = in_brackets(self.words()).find(unread).map(String::from);
        doubted
            .or(in_brackets)
            .filter(|_| self.stated_unit().is_none())
    }

    /// Returns the unit if another quantity has it as well and no word decides between them.
    fn ambiguous_unit(&self) -> Option<&str> {
        let text = self.unit_text.as_deref()?;
        let says = |word: &String| is_lateral(word) || listed(&ACCELERATION, word);
        let is_open = self.unit.is_some()
            && AccelerationUnit::is_ambiguous(text)
            && !words(self.words()).iter().any(says);
        is_open.then_some(text)
    }

    /// True if the name is one for time.
    pub(crate) fn says_time(&self) -> bool {
        says_time(&self.label)
    }

    /// True if the header names a unit that is not read: beside the name, or as a word such as
    /// `ticks`.
    pub(crate) fn names_unread_unit(&self) -> bool {
        let scale = |word: &String| SCALES.contains(&word.as_str());
        self.unit_text.is_some() || self.has_brackets() || words(&self.label).iter().any(scale)
    }

    /// True if the name has brackets; those of `(index)` enclose the name itself and do not count.
    pub(crate) fn has_brackets(&self) -> bool {
        self.name.contains(['(', '[']) && !self.says_index()
    }

    /// True if the name is one for a running number.
    pub(crate) fn says_index(&self) -> bool {
        INDEX.contains(&words(&self.label).join(" ").as_str()) || self.label == "#"
    }

    /// True if the name is one for a clock beside the column of times.
    pub(crate) fn says_other_clock(&self) -> bool {
        let words = words(&self.label);
        let names_clock = |word: &String| OTHER_CLOCKS.contains(&word.as_str());
        words.iter().any(names_clock)
            && words
                .iter()
                .all(|word| names_clock(word) || is_time_word(word))
    }

    /// Returns the unit of time that is the last word of a name, as in `ts_ns` and `tick_us`. Seconds do not
    /// count, since `v m/s` ends like them.
    pub(crate) fn time_unit_of_name(&self) -> Option<TimeUnit> {
        let words = words(&self.label);
        let unit = words.last().filter(|_| words.len() > 1)?;
        let unit = TimeUnit::from_spelling(unit).filter(|_| is_plain_time_unit(unit))?;
        (unit != TimeUnit::SECOND && !self.hints_at_acceleration()).then_some(unit)
    }

    /// Returns the rate [Hz] at which a column counts, where its name is that of a running number with
    /// the rate after it: `Sample (10 kHz)`, `n @ 10000 Hz`.
    pub(crate) fn counts_at_hz(&self) -> Option<f64> {
        let small = self.name.to_lowercase();
        let before = &small[..small.find("hz")?];
        let (factor, before) = match before.strip_suffix('k') {
            Some(before) => (1e3, before.trim_end()),
            None => (1.0, before.trim_end()),
        };
        let name = before.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
        let is_index = INDEX.contains(&words(name).join(" ").as_str());
        let hertz: f64 = before[name.len()..].parse().ok()?;
        (is_index && hertz > 0.0).then_some(factor * hertz)
    }

    /// True if some words of the name say lateral acceleration, whatever the other words are.
    pub(crate) fn says_lateral_acceleration(&self) -> bool {
        let words = words(self.words());
        let code = code_in(self.words()).is_some_and(|code| code.is_lateral());
        !self.has_foreign_unit()
            && (code || (words.iter().any(|word| is_lateral(word)) && self.accelerates(&words)))
    }

    /// True if the unit is one of acceleration, or a word says so or names the axis.
    pub(crate) fn hints_at_acceleration(&self) -> bool {
        let words = words(self.words());
        self.accelerates(&words) || words.iter().any(|word| is_lateral(word))
    }

    /// True if unit or words say acceleration.
    fn accelerates(&self, words: &[String]) -> bool {
        // `g lat`, as loggers of cars write it.
        let force = self.rival.is_none() && words.first().is_some_and(|word| word == "g");
        self.unit.is_some() || self.converted || force || words.iter().any(|w| accelerates(w))
    }

    /// True if the name is a `g` and an axis, which may be a turning rate as well as an
    /// acceleration.
    fn is_g_of_an_axis(&self) -> bool {
        let words = words(&self.label);
        let axis = |word: &String| ["x", "y", "z"].contains(&word.as_str());
        matches!(words.as_slice(), [g, word] if g == "g" && axis(word))
    }

    /// Returns the first word or sign of the name that is not one of plain names.
    pub(crate) fn odd_word(&self) -> Option<String> {
        odd_word(self.words())
    }

    /// Returns the evidence against a lateral acceleration of the struck vehicle's structure: the unit, or
    /// the word that raises the doubt.
    pub(crate) fn contradiction(&self) -> Option<String> {
        if let Some(unit) = self.unit_text.as_ref().filter(|_| self.has_foreign_unit()) {
            return Some(format!("the unit `{unit}`"));
        }
        if let Some(unit) = self.ambiguous_unit() {
            return Some(format!("the unit `{unit}`, which other quantities share"));
        }
        if let Some(rival) = &self.rival {
            return Some(format!(
                "its `g` beside `{rival}`, as turning rates are named"
            ));
        }
        if let Some(factor) = factor::factor_in(self.words()) {
            return Some(format!("the number `{factor}`, which may be a factor"));
        }
        if let Some(word) = self.odd_word() {
            return Some(match axis_of_word(&word) {
                Some(axis) => format!("`{word}` names the {axis} axis"),
                None if code_in(&word).is_some() => format!("its code is `{word}`"),
                None => format!("`{word}` is no known word"),
            });
        }
        // `ay1-ay2`, `acc y left - acc y right`.
        let sides = self.words().split(['-', '−', '–', '/']);
        let lateral = |side: &&str| words(side).iter().any(|word| is_lateral(word));
        (sides.filter(lateral).count() > 1).then(|| "a difference or ratio".into())
    }

    /// Returns the reason why this is not plainly a lateral acceleration of the struck vehicle's structure:
    /// the evidence against it, or the missing word. `None` for a plain name.
    pub(crate) fn doubt(&self) -> Option<String> {
        let words = words(self.words());
        let silent = || {
            if code_in(self.words()).is_some() {
                return None;
            }
            let lateral = words.iter().any(|word| is_lateral(word));
            let missing = match (lateral, self.accelerates(&words)) {
                (false, _) => "no word for lateral",
                (true, false) => "no unit and no word of acceleration",
                (true, true) => return None,
            };
            Some(missing.to_string())
        };
        self.contradiction().or_else(silent)
    }

    /// Warns of a name that is not plainly that of a lateral acceleration of the structure.
    pub(crate) fn not_lateral_finding(&self) -> Option<Finding> {
        let doubt = self.contradiction()?;
        Some(Finding::not_lateral(&self.name, &doubt))
    }

    /// Returns the filter that the name states.
    fn filter(&self) -> Option<Filtered> {
        let texts = [Some(&self.name), self.described.as_ref()];
        texts.into_iter().flatten().find_map(|text| {
            let coded = code_in(text).and_then(|code| code.filter_class());
            let stated = coded.map(|class| Filtered::Class(class.to_string()));
            stated.or_else(|| filtered::filter_in(text))
        })
    }

    /// True if the name says that the samples were filtered.
    pub(crate) fn says_filtered(&self) -> bool {
        self.filter().is_some() || self.above.filter_class.is_some()
    }

    /// Returns the facts that the name states beside axis and unit.
    pub(crate) fn stated(&self) -> Stated {
        let above = self.above.clone();
        let filter_class = match self.filter() {
            Some(Filtered::Class(class)) => Some(class),
            _ => above.filter_class,
        };
        Stated {
            filter_class,
            unfiltered: filtered::says_unfiltered(&self.name)
                || code_in(&self.name).is_some_and(|code| code.says_unfiltered()),
            gravity: gravity::says_gravity(&self.name),
            ..above
        }
    }

    /// Returns the findings of the name on the samples: a filter without a class, a code with the opposite
    /// sign.
    pub(crate) fn name_findings(&self) -> Vec<Finding> {
        let unclassed = self.filter() == Some(Filtered::Unclassed);
        let name = &self.name;
        let reason = format!(
            "the name of `{name}` says that the channel was filtered, but not with which class"
        );
        let filtered = unclassed.then(|| Finding::filtered(&reason));
        let sign = code_in(self.words()).and_then(|code| code.sign_finding());
        filtered.into_iter().chain(sign).collect()
    }
}

/// Marks the columns of a table by each other: those that are turning rates, and those that a stated
/// sensitivity converts to accelerations.
pub(crate) fn mark_columns(columns: Vec<&mut ChannelName>, options: &ReadOptions) {
    let says = |column: &&&mut ChannelName| {
        let words = words(&column.label);
        let has_axis = words
            .iter()
            .any(|word| accelerates(word) || word == "ax" || word == "az");
        has_axis && !column.has_foreign_unit()
    };
    let rival = columns.iter().find(says).map(|column| column.name.clone());
    for column in columns {
        if column.unit.is_none() && column.is_g_of_an_axis() {
            column.rival.clone_from(&rival);
        }
        let converts = |unit: String| {
            let sensitivity = options.sensitivity.as_ref()?;
            sensitivity.scale_of(&unit)
        };
        column.converted =
            column.unit.is_none() && column.stated_unit().and_then(converts).is_some();
    }
}

// The head of each list explains it.
static ACCELERATION: Words = word_list!("name-acceleration");
static LATERAL: Words = word_list!("name-lateral");
static LATERAL_ACCELERATION: Words = word_list!("name-lateral-acceleration");
static PLAIN: Words = word_list!("name-plain");
static FOREIGN_UNITS: Words = word_list!("name-other-units");
static OTHER_QUANTITIES: Words = word_list!("name-other-quantities");
static SCALES: Words = word_list!("name-scales");
static INDEX: Words = word_list!("name-index");
static OTHER_CLOCKS: Words = word_list!("name-other-clocks");
static TIMES: Words = word_list!("name-time");
static TIMES_ALONE: Words = word_list!("name-time-alone");
static PLAIN_TIMES: Words = word_list!("name-time-plain");

/// Attachments of a sensor close to a latch, as NHTSA codes them: doors, pillars, sills.
const ATTACHMENTS: [&str; 9] = ["ap", "bp", "cp", "do", "dr", "ds", "pi", "pl", "si"];

/// True if a word, or one with a number after it (`acc_y2`), is on a list.
fn listed(list: &[&str], word: &str) -> bool {
    list.contains(&word.trim_end_matches(|c: char| c.is_ascii_digit()))
}

/// True if a word says acceleration.
fn accelerates(word: &str) -> bool {
    listed(&ACCELERATION, word) || listed(&LATERAL_ACCELERATION, word)
}

/// Words for the longitudinal and the vertical axis.
const OTHER_AXES: [(&str, char); 8] = [
    ("hoch", 'Z'),
    ("laengs", 'X'),
    ("long", 'X'),
    ("longitudinal", 'X'),
    ("längs", 'X'),
    ("vert", 'Z'),
    ("vertical", 'Z'),
    ("vertikal", 'Z'),
];

/// Returns the axis of the vehicle that a word names, X, Y or Z: the lists of words for Y hold with each letter.
pub(crate) fn axis_of_word(word: &str) -> Option<char> {
    if is_lateral(word) {
        return Some('Y');
    }
    let other = OTHER_AXES.iter().find(|(name, _)| *name == word);
    let named = |letter: &char| word.contains(*letter) && is_lateral(&word.replace(*letter, "y"));
    let letter = || ['x', 'z'].into_iter().find(named);
    other
        .map(|(_, axis)| *axis)
        .or_else(|| letter().map(|letter| letter.to_ascii_uppercase()))
}

/// Returns a word without what it says of an axis; `None` if that was all.
pub(crate) fn without_axis(word: &str) -> Option<String> {
    let Some(axis) = axis_of_word(word) else {
        return Some(word.to_string());
    };
    let rest = word.replace(axis.to_ascii_lowercase(), "");
    // Of `lateral`, `xg` or `x` nothing is left but the axis.
    accelerates(&rest).then_some(rest)
}

fn is_lateral(word: &str) -> bool {
    listed(&LATERAL, word) || listed(&LATERAL_ACCELERATION, word)
}

/// True if a word is NHTSA's code of an attachment: `DS`, or `DSLF` with the side.
fn is_attachment(word: &str) -> bool {
    let (place, side) = word.split_at_checked(2).unwrap_or_default();
    ATTACHMENTS.contains(&place) && matches!(side, "" | "lf" | "rf" | "lr" | "rr")
}

fn says_time(label: &str) -> bool {
    let words = words(label);
    match words.as_slice() {
        [only] if TIMES_ALONE.contains(&only.as_str()) => true,
        // The name that LabVIEW gives to its column of times.
        [x, value] if x == "x" && value == "value" => true,
        _ => words.iter().any(|word| TIMES.contains(&word.as_str())),
    }
}

/// True if a word of a name for time cannot be a unit.
fn is_time_word(word: &str) -> bool {
    TIMES.contains(&word)
        || TIMES_ALONE.contains(&word)
        || PLAIN_TIMES.contains(&word)
        || word.chars().all(|c| c.is_ascii_digit())
}

/// Splits a name into lower-case words, at everything but letters and digits and where a
/// small letter meets a capital one (`accY`).
pub(crate) fn words(label: &str) -> Vec<String> {
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

/// Returns the texts in brackets.
fn in_brackets(label: &str) -> impl Iterator<Item = &str> {
    let inner = label.split(['(', '[', '{']).skip(1);
    inner.map(|inner| {
        inner
            .split([')', ']', '}'])
            .next()
            .unwrap_or_default()
            .trim()
    })
}

/// True if a text holds only words of plain names.
fn is_plain_place(text: &str) -> bool {
    let words = words(text);
    (0..words.len()).all(|index| is_plain(&words, index)) || code_in(text).is_some()
}

/// Returns the first word or sign that is not one of plain names; words before signs.
fn odd_word(label: &str) -> Option<String> {
    if let Some(code) = code_in(label) {
        let remainder = label.to_ascii_uppercase().replace(&code.text(), " ");
        return match code.is_lateral() && code.is_structure() {
            true => odd_word(&remainder),
            false => Some(code.text()),
        };
    }
    let name_words = words(label);
    let odd = (0..name_words.len()).find(|index| !is_plain(&name_words, *index));
    odd.map(|index| name_words[index].clone())
        .or_else(|| odd_sign(label))
}

/// True if a word of a name is one of plain names.
fn is_plain(words: &[String], index: usize) -> bool {
    let word = words[index].as_str();
    is_lateral(word)
        || listed(&ACCELERATION, word)
        || listed(&PLAIN, word)
        || (index == 0 && word == "g" && words.len() > 1)
        || is_attachment(word)
        // A sensor's number has at most three digits; a longer one may be a factor or a date.
        || (word.len() <= 3 && word.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Returns a sign that may be one of arithmetic: a minus before a word, a stroke but between digits, or
/// any sign that names do not hold.
fn odd_sign(label: &str) -> Option<String> {
    let letters: Vec<char> = label.trim().chars().collect();
    let letter_at = |index: Option<usize>| index.and_then(|index| letters.get(index)).copied();
    letters.iter().enumerate().find_map(|(index, letter)| {
        let (previous, next) = (letter_at(index.checked_sub(1)), letter_at(Some(index + 1)));
        let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
        let blank = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
        let plain = match letter {
            '-' => !blank(previous) || blank(next),
            '/' => digit(previous) && digit(next),
            ' ' | '\t' | '_' | '.' | ',' | ':' | '#' | '(' | ')' | '[' | ']' | '"' | '\'' => true,
            letter => letter.is_alphanumeric(),
        };
        (!plain).then(|| letter.to_string())
    })
}

/// Finds a channel code of ISO/TS 13499 in a name: 16 capitals and digits that state a known
/// dimension.
pub(crate) fn code_in(label: &str) -> Option<Code> {
    /// Dimensions beside AC: velocity, displacement, force, moment, angular motion.
    const OTHERS: &[&str] = &["VE", "DS", "FO", "MO", "AV", "AA", "AN"];
    label
        .split(|c: char| !c.is_alphanumeric() && c != '?')
        .filter(|part| {
            part.len() == 16
                && !part.contains(|c: char| c.is_ascii_lowercase())
                && part.contains(|c: char| c.is_ascii_digit() || c == '?')
        })
        .find_map(|part| {
            let axis = part.get(14..15)?;
            let is_known = matches!(axis, "X" | "Y" | "Z" | "R" | "1" | "2" | "3" | "0");
            let code = Code::new(part)?;
            (is_known && (code.is_acceleration() || OTHERS.contains(&part.get(12..14)?)))
                .then_some(code)
        })
}

/// True if a text is a unit of acceleration, or of time whatever the name beside it.
pub(crate) fn is_known_unit(text: &str) -> bool {
    let text = strip_brackets(text.trim());
    AccelerationUnit::from_spelling(text).is_some() || is_plain_time_unit(text)
}

/// True if a text is a unit of time and can mean nothing else. `min`, `d` and `3 ms` may be a least
/// value, a distance and a length of averages, and are units only beside a name for time.
fn is_plain_time_unit(text: &str) -> bool {
    let unit = TimeUnit::from_spelling(text);
    unit.is_some_and(|unit| unit.seconds() <= 1.0) && !text.contains(|c: char| c.is_ascii_digit())
}

/// Returns the unit of time in a text beside a name.
fn time_unit_of(text: &str, label: &str) -> Option<TimeUnit> {
    let unit = TimeUnit::from_spelling(text)?;
    (is_plain_time_unit(text) || says_time(label)).then_some(unit)
}

/// True if a text is a unit, of any quantity.
pub(crate) fn is_unit(text: &str) -> bool {
    is_known_unit(text) || is_other_unit(text)
}

/// True if a text is a unit of another quantity.
fn is_other_unit(text: &str) -> bool {
    let text = strip_brackets(text.trim());
    let small = text.to_lowercase();
    FOREIGN_UNITS.contains(&text) || OTHER_QUANTITIES.contains(&small.as_str())
}

pub(crate) fn strip_brackets(text: &str) -> &str {
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')] {
        if let Some(inner) = text.strip_prefix(open).and_then(|t| t.strip_suffix(close)) {
            return inner.trim();
        }
    }
    text
}

/// Finds the units in brackets in `a (m/s^2)`, `Time [s]`, `acc (g) y`; brackets may hold brackets, as
/// in `(m/(s*s))`. Returns each with the text before and after it.
fn bracketed_units(cell: &str) -> Vec<(&str, &str, &str)> {
    let mut units = Vec::new();
    let mut opened: Vec<(usize, char)> = Vec::new();
    for (index, character) in cell.char_indices() {
        match character {
            '(' => opened.push((index, ')')),
            '[' => opened.push((index, ']')),
            '{' => opened.push((index, '}')),
            ')' | ']' | '}' => {
                let opening = opened.pop().filter(|(_, close)| *close == character);
                let Some((start, _)) = opening.filter(|_| opened.is_empty()) else {
                    continue;
                };
                let content = cell[start + 1..index].trim();
                let is_time = time_unit_of(content, &cell[..start]).is_some();
                if is_known_unit(content) || is_time || is_other_unit(content) {
                    units.push((&cell[..start], content, &cell[index + 1..]));
                }
            }
            _ => {}
        }
    }
    units
}

/// True if a name beside a unit makes another unit of it, or may: `ay x10`, `ay counts`,
/// `ay % of FS`, `ay E3`, `ay k`, `acc_y_g`. A word that is merely unknown does not.
fn spoils_unit(label: &str) -> bool {
    const FACTORS: [char; 8] = ['*', '×', '^', '=', '±', '·', '⋅', '%'];
    let words = words(label);
    let (is_time, lateral) = (says_time(label), words.iter().any(|word| is_lateral(word)));
    let spoils = |word: &String| {
        let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
        let has = |test: fn(char) -> bool| word.contains(test);
        let mixed = has(|c| c.is_ascii_digit()) && has(char::is_alphabetic);
        // A second clock, a sensor of another axis.
        let counted = match stem {
            "t" | "time" => word.len() <= stem.len() + 1,
            _ => AXES.contains(&stem) && !lateral,
        };
        let unit = is_known_unit(word)
            || OTHER_QUANTITIES.contains(&word.as_str())
            || FOREIGN_UNITS
                .iter()
                .any(|unit_name| unit_name.to_lowercase() == *word);
        // `P1` and `CH1A` name a sensor; `x10`, `e3` and `2k` may be factors.
        let head = word
            .split(|c: char| c.is_ascii_digit())
            .next()
            .unwrap_or_default();
        let is_name = !head.is_empty()
            && !["x", "e"].contains(&head)
            && !SCALES.contains(&head)
            && AccelerationUnit::from_spelling(head).is_none();
        (mixed && !counted && !is_name)
            || (stem == "x" && lateral)
            || SCALES.contains(&word.as_str())
            || (unit && word.as_str() != "t" && !AXES.contains(&stem))
    };
    let odd = |index: &usize| match is_time {
        true => {
            let word = words[*index].as_str();
            is_plain_time_unit(word) || !is_time_word(word)
        }
        false => !is_plain(&words, *index),
    };
    let ratio = label
        .split('/')
        .skip(1)
        .any(|denominator| denominator.trim_start().starts_with(char::is_numeric))
        && odd_sign(label).is_some();
    let alone = is_time && words.len() == 1;
    let factor = || !is_time && factor::factor_in(label).is_some();
    code_in(label).is_none()
        && !alone
        && (label.contains(FACTORS)
            || ratio
            || factor()
            || (0..words.len())
                .filter(odd)
                .any(|index| spoils(&words[index])))
}

/// Names of the other axes, which do not change a unit.
const AXES: [&str; 4] = ["x", "z", "ax", "az"];

/// Endings of names that are units, with the unit they mean. `_ms2` is not among them, since it
/// may stand for m/s² as well as for ms².
const SUFFIXES: &[(&str, &str)] = &[
    ("_mm_ms2", "mm/ms2"),
    ("_mm_s2", "mm/s2"),
    ("_cm_s2", "cm/s2"),
    ("_in_s2", "in/s2"),
    ("_ft_s2", "ft/s2"),
    ("_m_s2", "m/s2"),
    ("_m_per_s2", "m/s2"),
    ("_mps2", "m/s2"),
    ("_m/s2", "m/s2"),
    ("_m/s^2", "m/s2"),
    ("_g", "g"),
];

/// Finds `time_ms`, `t/s`, `Zeit in 0.1 ms` and `time 100 us`. A whole number after a blank may count
/// clocks, as in `time 2 s`, unless it is a power of ten.
fn time_unit_at_the_end(cell: &str) -> Option<(String, String)> {
    let marks = cell.char_indices().filter(|(_, c)| " _/,".contains(*c));
    let (label, unit) = marks
        .map(|(index, mark)| (&cell[..index], cell[index + mark.len_utf8()..].trim()))
        .find(|(label, unit)| says_time(label) && TimeUnit::from_spelling(unit).is_some())?;
    let number = unit.trim_end_matches(|c: char| !c.is_ascii_digit());
    let power = number.trim_end_matches('0') == "1";
    let counts = !power && !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    let label = label.trim().trim_end_matches(" in").to_string();
    (!counts).then(|| (label, unit.to_string()))
}

/// Finds `a / m/s^2`, `t/s`, `a in g`, `a, g`, `Acceleration y g`, `acc_y_g` and `time_ms`.
fn unit_at_the_end(cell: &str) -> Option<(String, String)> {
    let lower = cell.to_ascii_lowercase();
    let suffixed = SUFFIXES.iter().find_map(|(ending, unit)| {
        let label = lower
            .strip_suffix(ending)
            .filter(|label| !label.is_empty())?;
        Some((&cell[..label.len()], *unit))
    });
    let split = [" / ", " in ", ", ", "/"]
        .iter()
        .filter_map(|separator| cell.split_once(separator))
        .chain(cell.rsplit_once(' '))
        .chain(cell.rsplit_once('_'))
        .filter(|(_, unit)| is_known_unit(unit));
    suffixed
        .into_iter()
        .chain(split)
        .map(|(label, unit)| (label.trim().to_string(), unit.trim().to_string()))
        .find(|(label, unit)| {
            let says = |word: &String| is_lateral(word) || listed(&ACCELERATION, word);
            // In `v m/s` the `s` is not a unit of time.
            match TimeUnit::from_spelling(unit).is_some() {
                true => says_time(label),
                false => words(label).iter().any(says),
            }
        })
}

/// True if the text before a unit without brackets is only a name, so that the unit is that of the
/// column: no number but one that counts sensors, as in `acc_y_2_g`.
fn names_alone(label: &str, unit: &str) -> bool {
    let words = words(label);
    if TimeUnit::from_spelling(unit).is_some() {
        let no_number = |word: &String| is_time_word(word) && !word.starts_with(char::is_numeric);
        return words.iter().all(no_number);
    }
    let counts =
        |word: &str| word.len() == 1 && word != "0" && label.ends_with(&format!("_{word}"));
    let last = words.last().map_or("", String::as_str);
    !spoils_unit(label) && (!last.starts_with(char::is_numeric) || counts(last))
}
