//! Cards: a recording's full name plus `.toml`, saying what the file itself does not.

use super::limits::Limits;
use super::source::{Source, sha256};
use super::text::line_at;
use crate::error::{Error, ErrorKind, Place, nearest_name};
use crate::units::{AccelerationUnit, DecimalMark, OpensWhen, SampleRate};
use serde::{Deserialize, Serialize};

/// The keys a card may hold.
const KEYS: [&str; 13] = [
    "channel",
    "unit",
    "opens_when",
    "rate",
    "header_line",
    "skip_lines",
    "decimal",
    "range_g",
    "synthetic",
    "accepted_remarks",
    "source",
    "licence",
    "notes",
];

/// What a card says about the recording beside it. Every key is optional.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Card {
    /// Channel to use: a name, or a 1-based number.
    pub channel: Option<String>,
    /// Unit of acceleration.
    pub unit: Option<AccelerationUnit>,
    /// Sign of the recorded acceleration that swings the lever open: `negative`, `positive`, `both`.
    pub opens_when: Option<CardPolarity>,
    /// Sample rate [Hz].
    pub rate: Option<f64>,
    /// Line of a text table that names its columns, counted from 1.
    pub header_line: Option<u32>,
    /// Lines at the start of a text table that are passed over.
    pub skip_lines: Option<u32>,
    /// Decimal mark of a text table.
    pub decimal: Option<DecimalMark>,
    /// Full scale of the channel [g].
    pub range_g: Option<f64>,
    /// True for a signal made by a formula: no clipping or dead-sensor findings.
    pub synthetic: bool,
    /// Remarks that a person has read and accepts, as they are shown.
    pub accepted_remarks: Vec<String>,
    /// Where it comes from.
    pub source: Option<String>,
    /// Its licence.
    pub licence: Option<String>,
    /// Anything else.
    pub notes: Option<String>,
}

impl Card {
    /// Reads a card from its TOML text.
    ///
    /// # Errors
    ///
    /// - [`ErrorKind::Malformed`] where the text is no TOML or a value has the wrong type,
    /// - [`ErrorKind::UnknownName`] for a key, unit or polarity that is not known,
    /// - [`ErrorKind::NotPositive`] for a rate or range that is not finite and positive.
    ///
    /// # Examples
    ///
    /// ```
    /// # use latchgate::recording::Card;
    /// let card = Card::from_toml("unit = \"g\"\nrange_g = 2000").unwrap();
    /// assert_eq!(card.range_g, Some(2000.0));
    /// assert!(Card::from_toml("units = \"g\"").is_err());
    /// ```
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let table: toml::Table = toml::from_str(text).map_err(|error| {
            let line = error
                .span()
                .map_or(1, |span| line_at(text.as_bytes(), span.start));
            Error::from(ErrorKind::Malformed {
                expected: "TOML".into(),
                found: error.message().to_string(),
                hint: "write lines such as unit = \"g\"".into(),
            })
            .at(Place::default().line(line))
        })?;
        let mut card = Self::default();
        for (key, value) in &table {
            card.set(key, value)
                .map_err(|error| error.at(place_of_key(text, key)))?;
        }
        Ok(card)
    }

    fn set(&mut self, key: &str, value: &toml::Value) -> Result<(), Error> {
        match key {
            "channel" => {
                self.channel = Some(match value {
                    toml::Value::Integer(number) => number.to_string(),
                    other => text_of(key, other, "a name in quotes or a column number")?,
                });
            }
            "unit" => {
                let name = text_of(key, value, "a unit in quotes")?;
                let known = AccelerationUnit::ALL.map(|(_, name)| name);
                self.unit = AccelerationUnit::from_spelling(&name);
                if self.unit.is_none() {
                    return Err(unknown("unit", name, &known));
                }
            }
            "opens_when" => {
                let name = text_of(key, value, "\"negative\", \"positive\" or \"both\"")?;
                self.opens_when = CardPolarity::from_name(&name);
                if self.opens_when.is_none() {
                    let known = CardPolarity::ALL.map(CardPolarity::name);
                    return Err(unknown("polarity", name, &known));
                }
            }
            "rate" => {
                let rate = number_of(key, value)?;
                self.rate = Some(SampleRate::from_hertz(rate)?.hertz());
            }
            "header_line" => self.header_line = Some(line_of(key, value, 1)?),
            "skip_lines" => self.skip_lines = Some(line_of(key, value, 0)?),
            "decimal" => {
                let name = text_of(key, value, "\".\" or \",\"")?;
                self.decimal = DecimalMark::ALL
                    .into_iter()
                    .find(|mark| mark.name() == name);
                if self.decimal.is_none() {
                    return Err(unknown("decimal mark", name, &[".", ","]));
                }
            }
            "range_g" => {
                let range = number_of(key, value)?;
                if !(range.is_finite() && range > 0.0) {
                    return Err(ErrorKind::NotPositive {
                        what: "range_g [g]",
                        found: range,
                    }
                    .into());
                }
                self.range_g = Some(range);
            }
            "synthetic" => {
                self.synthetic = value
                    .as_bool()
                    .ok_or_else(|| wrong_type(key, value, "true or false"))?;
            }
            "accepted_remarks" => {
                const EXPECTED: &str = "a list of texts in quotes";
                let list = value
                    .as_array()
                    .ok_or_else(|| wrong_type(key, value, EXPECTED))?;
                self.accepted_remarks = list
                    .iter()
                    .map(|one| text_of(key, one, EXPECTED))
                    .collect::<Result<_, _>>()?;
            }
            "source" => self.source = Some(text_of(key, value, "a text in quotes")?),
            "licence" => self.licence = Some(text_of(key, value, "a text in quotes")?),
            "notes" => self.notes = Some(text_of(key, value, "a text in quotes")?),
            _ => return Err(unknown("card key", key.to_string(), &KEYS)),
        }
        Ok(())
    }
}

/// A card as it lies beside a recording: bytes that are not yet read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CardFile {
    place: Place,
    bytes: Vec<u8>,
}

impl CardFile {
    /// Finds the card beside a recording, if there is one. Standard input has none.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if the card is there but cannot be read, [`ErrorKind::LimitExceeded`] if
    /// it is larger than settings may be, each at the card's name.
    pub fn beside(source: &Source, limits: &Limits) -> Result<Option<Self>, Error> {
        let place = Place::file(format!("{}.toml", source.name()));
        let read = source.read_card(limits.settings_bytes.saturating_add(1));
        let Some(bytes) = read.map_err(|error| error.at(place.clone()))? else {
            return Ok(None);
        };
        if bytes.len() as u64 > limits.settings_bytes {
            return Err(Error::from(ErrorKind::LimitExceeded {
                limit: "settings_bytes",
                value: limits.settings_bytes,
                found: "a larger card".into(),
            })
            .at(place));
        }
        Ok(Some(Self { place, bytes }))
    }

    /// Returns the SHA-256 of its bytes.
    #[must_use]
    pub fn sha256(&self) -> String {
        sha256(&self.bytes)
    }

    /// Reads it.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] if it is no UTF-8, and the errors of [`Card::from_toml`], each at
    /// the card's name.
    pub fn read(&self) -> Result<Card, Error> {
        let text = std::str::from_utf8(&self.bytes).map_err(|error| {
            let line = line_at(&self.bytes, error.valid_up_to());
            Error::from(ErrorKind::Malformed {
                expected: "a card in UTF-8".into(),
                found: "other bytes".into(),
                hint: "save the card as UTF-8".into(),
            })
            .at(self.place.clone().line(line))
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Card::from_toml(text).map_err(|error| error.at(self.place.clone()))
    }
}

/// Reads the card beside a recording, if there is one, with the SHA-256 of its bytes.
///
/// # Errors
///
/// Those of [`CardFile::beside`] and [`CardFile::read`].
pub fn read_beside(source: &Source, limits: &Limits) -> Result<Option<(Card, String)>, Error> {
    let Some(file) = CardFile::beside(source, limits)? else {
        return Ok(None);
    };
    Ok(Some((file.read()?, file.sha256())))
}

/// A polarity as a card or option states it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CardPolarity {
    /// A negative recorded acceleration opens.
    Negative,
    /// A positive recorded acceleration opens.
    Positive,
    /// Judge each; the worse counts.
    Both,
}

impl CardPolarity {
    /// Lists every polarity.
    pub const ALL: [Self; 3] = [Self::Negative, Self::Positive, Self::Both];

    /// Returns the polarities to judge.
    #[must_use]
    pub fn polarities(self) -> &'static [OpensWhen] {
        match self {
            Self::Negative => &[OpensWhen::Negative],
            Self::Positive => &[OpensWhen::Positive],
            Self::Both => &[OpensWhen::Negative, OpensWhen::Positive],
        }
    }

    /// Returns the word that options and cards use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Negative => "negative",
            Self::Positive => "positive",
            Self::Both => "both",
        }
    }

    /// Returns the polarity of that word, if it is one.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|one| one.name().eq_ignore_ascii_case(name.trim()))
    }
}

fn unknown(what: &'static str, found: String, known: &[&str]) -> Error {
    ErrorKind::UnknownName {
        what,
        nearest: nearest_name(&found, known),
        found,
        known: known.join(", "),
    }
    .into()
}

fn text_of(key: &str, value: &toml::Value, expected: &str) -> Result<String, Error> {
    value
        .as_str()
        .map(ToString::to_string)
        .ok_or_else(|| wrong_type(key, value, expected))
}

fn number_of(key: &str, value: &toml::Value) -> Result<f64, Error> {
    match value {
        toml::Value::Float(number) => Ok(*number),
        toml::Value::Integer(number) => Ok(*number as f64),
        other => Err(wrong_type(key, other, "a number without quotes")),
    }
}

fn line_of(key: &str, value: &toml::Value, least: u32) -> Result<u32, Error> {
    let number = value
        .as_integer()
        .and_then(|number| u32::try_from(number).ok());
    number
        .filter(|number| *number >= least)
        .ok_or_else(|| wrong_type(key, value, &format!("a whole number from {least}")))
}

fn wrong_type(key: &str, value: &toml::Value, expected: &str) -> Error {
    ErrorKind::Malformed {
        expected: format!("`{key}` to be {expected}"),
        found: match value.type_str() {
            kind @ ("integer" | "array") => format!("an {kind}"),
            kind => format!("a {kind}"),
        },
        hint: "mend the card".into(),
    }
    .into()
}

/// Finds the line on which a top-level key stands.
fn place_of_key(text: &str, key: &str) -> Place {
    let found = text.lines().position(|line| {
        let line = line.trim_start().trim_start_matches(['[', '"', '\'', ' ']);
        line.strip_prefix(key)
            .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
    });
    match found {
        Some(index) => Place::default().line(index as u64 + 1),
        None => Place::default(),
    }
}
