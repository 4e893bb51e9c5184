//! Cards: a recording's full name plus `.toml`, with facts that the file itself lacks.

use super::TestFacts;
use super::channel_name::filtered::{Filtered, filter_in, says_unfiltered};
use super::limits::Limits;
use super::sensor_place::{SensorPlace, TransferRange};
use super::source::{Source, sha256};
use super::text::line_at;
use crate::error::{Error, Place, with_article};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::units::{
    AccelerationUnit, DecimalMark, MessageClock, OpensWhen, SampleRate, SensorSensitivity,
};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::num::NonZeroU32;

/// The keys of a card besides those of texts, as they are listed.
const KEYS: [&str; 19] = [
    "channel",
    "unit",
    "sensitivity",
    "opens_when",
    "rate",
    "time_source",
    "header_line",
    "unit_line",
    "last_line",
    "sheet",
    "skip_lines",
    "decimal",
    "range_g",
    "synthetic",
    "accepted_remarks",
    "velocity_change_m_s",
    "accepted",
    "place",
    "transfer",
];

/// The remedy for a wrong value.
const MEND: &str = "correct the card";

/// Facts that a card states of the recording beside it. Every key is optional.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Card {
    /// Channel to use: a name, or a 1-based number.
    pub channel: Option<String>,
    /// Unit of acceleration.
    pub unit: Option<AccelerationUnit>,
    /// Acceleration that one of the samples means, where they are another quantity.
    pub sensitivity: Option<SensorSensitivity>,
    /// Sign of the recorded acceleration that swings the lever open: `negative`, `positive`, `both`.
    pub opens_when: Option<CardPolarity>,
    /// Sample rate [Hz].
    pub rate: Option<f64>,
    /// Clock of a log's messages that gives the time: `header`, `log`, `publish`.
    pub time_source: Option<MessageClock>,
    /// Line of a text table that names its columns, counted from 1.
    pub header_line: Option<u32>,
    /// Line of a text table that holds the units of its columns.
    pub unit_line: Option<u32>,
    /// Last line of a text table; lines below hold no samples.
    pub last_line: Option<u32>,
    /// Name of the sheet of a workbook.
    pub sheet: Option<String>,
    /// Lines at the start of a text table that are skipped.
    pub skip_lines: Option<u32>,
    /// Decimal mark of a text table.
    pub decimal: Option<DecimalMark>,
    /// Full scale of the channel [g].
    pub range_g: Option<f64>,
    /// True for a signal made by a formula: no clipping or dead-sensor findings.
    pub synthetic: bool,
    /// Remarks that a person has read and accepts, as they are shown.
    pub accepted_remarks: Vec<String>,
    /// Velocity change of the sensor's place, known from another source [m/s].
    pub velocity_change_m_s: Option<f64>,
    /// Doubts about the recording that a person has settled.
    pub accepted: Vec<AcceptedWord>,
    /// Place of the sensor: `latch`, `door`, `body`.
    pub place: Option<SensorPlace>,
    /// Factors between the acceleration at that place and the one at the latch.
    pub transfer: Option<TransferRange>,
    /// Facts of test and sensor.
    pub test: TestFacts,
    /// Origin of the recording.
    pub source: Option<String>,
    /// Its licence.
    pub licence: Option<String>,
    /// Anything else.
    pub notes: Option<String>,
    /// Who makes the reports of it.
    pub by: Option<String>,
}

impl Card {
    /// Reads a card from its TOML text.
    ///
    /// # Errors
    ///
    /// - [`ErrorKind::Malformed`] where the text is no TOML or a value has the wrong type,
    /// - [`ErrorKind::UnknownName`] for a key, unit or polarity that is not known,
    /// - [`NotPositive`](latchgate_kernel::error::Error::NotPositive) for a rate, range or velocity change that is not finite and
    ///   positive.
    ///
    /// # Examples
    ///
    /// ```
    /// # use latchgate_recording::Card;
    /// let card = Card::from_toml("unit = \"g\"\nrange_g = 2000").unwrap();
    /// assert_eq!(card.range_g, Some(2000.0));
    /// assert!(Card::from_toml("units = \"g\"").is_err());
    /// ```
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let table: toml::Table = toml::from_str(text).map_err(|error| {
            Error::malformed("TOML", error.message(), "write lines such as unit = \"g\"")
                .at(Place::of_span(text, error.span()))
        })?;
        let mut card = Self::default();
        for (key, value) in &table {
            card.set(key, value)
                .map_err(|error| error.at(Place::of_key(text, None, key)))?;
        }
        Ok(card)
    }

    /// True if its words state that the channel holds what CFC 1000 lets pass, or was not filtered.
    pub fn says_wide_band(&self) -> bool {
        let texts = [&self.test.sensor, &self.source, &self.notes];
        texts.into_iter().flatten().any(|text| {
            says_unfiltered(text) || filter_in(text) == Some(Filtered::Class("1000".into()))
        })
    }

    /// Lists every key of a card.
    pub fn keys() -> Vec<&'static str> {
        let mut card = Self::default();
        let texts = card.texts().map(|(name, _)| name);
        KEYS.into_iter().chain(texts).collect()
    }

    /// Lists the keys of texts with their places.
    fn texts(&mut self) -> [(&'static str, &mut Option<String>); 10] {
        [
            ("test", &mut self.test.test),
            ("vehicle", &mut self.test.vehicle),
            ("laboratory", &mut self.test.laboratory),
            ("date", &mut self.test.date),
            ("sensor", &mut self.test.sensor),
            ("location", &mut self.test.location),
            ("source", &mut self.source),
            ("licence", &mut self.licence),
            ("notes", &mut self.notes),
            ("by", &mut self.by),
        ]
    }

    fn set(&mut self, key: &str, value: &toml::Value) -> Result<(), Error> {
        match key {
            "channel" => {
                self.channel = Some(match value {
                    toml::Value::Integer(number) => number.to_string(),
                    value => take(key, value, "a name in quotes or a column number")?,
                });
            }
            "unit" => {
                let name: String = take(key, value, "a unit in quotes")?;
                let names = AccelerationUnit::ALL.map(|(_, name)| name);
                let unit = AccelerationUnit::from_spelling(&name);
                self.unit = Some(unit.ok_or_else(|| Error::unknown("unit", name, &names))?);
            }
            "sensitivity" => {
                let text: String = take(key, value, "a text such as \"20 g/V\"")?;
                let stated = SensorSensitivity::from_text(&text).map_err(|reason| {
                    Error::malformed(format!("`{key}`: {reason}"), format!("`{text}`"), MEND)
                })?;
                self.sensitivity = Some(stated);
            }
            "opens_when" => {
                let name: String = take(key, value, "\"negative\", \"positive\" or \"both\"")?;
                let names = CardPolarity::ALL.map(CardPolarity::name);
                let polarity = CardPolarity::from_name(&name);
                let polarity = polarity.ok_or_else(|| Error::unknown("polarity", name, &names));
                self.opens_when = Some(polarity?);
            }
            "rate" => {
                let rate = take(key, value, "a number without quotes")?;
                self.rate = Some(SampleRate::from_hertz(rate)?.hertz());
            }
            "time_source" => {
                let name: String = take(key, value, "\"header\", \"log\" or \"publish\"")?;
                let names = MessageClock::ALL.map(MessageClock::name);
                let mut clocks = MessageClock::ALL.into_iter();
                let clock = clocks.find(|clock| clock.name().eq_ignore_ascii_case(name.trim()));
                let unknown = || Error::unknown("clock", name, &names);
                self.time_source = Some(clock.ok_or_else(unknown)?);
            }
            "header_line" | "unit_line" | "last_line" => {
                let line: NonZeroU32 = take(key, value, "a whole number from 1")?;
                let place = match key {
                    "header_line" => &mut self.header_line,
                    "unit_line" => &mut self.unit_line,
                    _ => &mut self.last_line,
                };
                *place = Some(line.get());
            }
            "sheet" => self.sheet = Some(take(key, value, "a name in quotes")?),
            "skip_lines" => self.skip_lines = Some(take(key, value, "a whole number from 0")?),
            "decimal" => {
                let name: String = take(key, value, "\".\" or \",\"")?;
                let mut marks = DecimalMark::ALL.into_iter();
                let mark = marks.find(|mark| mark.name() == name);
                let unknown = || Error::unknown("decimal mark", name, &[".", ","]);
                self.decimal = Some(mark.ok_or_else(unknown)?);
            }
            "range_g" => {
                self.range_g = Some(take_positive(key, value, "range_g [g]")?);
            }
            "velocity_change_m_s" => {
                let velocity = take_positive(key, value, "velocity_change_m_s [m/s]")?;
                self.velocity_change_m_s = Some(velocity);
            }
            "accepted" => {
                let words: Vec<String> = take(key, value, "a list of words in quotes")?;
                let words = words.iter().map(|word| {
                    let names = AcceptedWord::ALL.map(AcceptedWord::name);
                    AcceptedWord::from_name(word)
                        .ok_or_else(|| Error::unknown("word to accept", word, &names))
                });
                self.accepted = words.collect::<Result<_, Error>>()?;
            }
            "place" => {
                let name: String = take(key, value, "\"latch\", \"door\" or \"body\"")?;
                let names = SensorPlace::ALL.map(SensorPlace::name);
                let place = SensorPlace::from_name(&name);
                self.place = Some(place.ok_or_else(|| Error::unknown("place", name, &names))?);
            }
            "transfer" => self.transfer = Some(transfer(key, value)?),
            "synthetic" => self.synthetic = take(key, value, "true or false")?,
            "date" if value.is_datetime() => {
                self.test.date = value.as_datetime().map(ToString::to_string);
            }
            "accepted_remarks" => {
                self.accepted_remarks = take(key, value, "a list of texts in quotes")?;
            }
            _ => {
                let mut texts = self.texts();
                let Some((_, slot)) = texts.iter_mut().find(|(name, _)| *name == key) else {
                    return Err(Error::unknown("card key", key, &Self::keys()));
                };
                **slot = Some(take(key, value, "a text in quotes")?);
            }
        }
        Ok(())
    }
}

/// A card file beside a recording, as bytes that are not parsed yet.
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
            return Err(limits.over("settings_bytes", "a larger card").at(place));
        }
        Ok(Some(Self { place, bytes }))
    }

    /// Returns the SHA-256 of its bytes.
    pub fn sha256(&self) -> String {
        sha256(&self.bytes)
    }

    /// Parses it.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] if it is no UTF-8, and the errors of [`Card::from_toml`], each at
    /// the card's name.
    pub fn read(&self) -> Result<Card, Error> {
        let text = std::str::from_utf8(&self.bytes).map_err(|error| {
            let line = line_at(&self.bytes, error.valid_up_to());
            Error::malformed("a card in UTF-8", "other bytes", "save the card as UTF-8")
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
    pub fn polarities(self) -> &'static [OpensWhen] {
        match self {
            Self::Negative => &[OpensWhen::Negative],
            Self::Positive => &[OpensWhen::Positive],
            Self::Both => &[OpensWhen::Negative, OpensWhen::Positive],
        }
    }

    /// Returns the word that options and cards use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Negative => "negative",
            Self::Positive => "positive",
            Self::Both => "both",
        }
    }

    /// Returns the polarity of that word, if it is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|polarity| polarity.name().eq_ignore_ascii_case(name.trim()))
    }
}

/// A doubt about a recording unlike a crash that a person settles, by its word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AcceptedWord {
    /// Sample rate and length of the record.
    Clock,
    /// Axis of a channel that is not lateral.
    Axis,
    /// The recorder's step as all the noise of a record without a quiet stretch.
    Noise,
    /// Samples that are unlike those of a raw recording.
    Processed,
}

impl AcceptedWord {
    /// Lists every word.
    pub const ALL: [Self; 4] = [Self::Clock, Self::Axis, Self::Noise, Self::Processed];

    /// Returns the word that options and cards use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clock => "clock",
            Self::Axis => "axis",
            Self::Noise => "noise",
            Self::Processed => "processed",
        }
    }

    /// Returns the doubt of that word, if it is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|word| word.name().eq_ignore_ascii_case(name.trim()))
    }
}

/// Reads factors: one as a number, or a text.
fn transfer(key: &str, value: &toml::Value) -> Result<TransferRange, Error> {
    let (read, found) = match value {
        toml::Value::Integer(factor) => {
            let factor = *factor as f64;
            (TransferRange::new(factor, factor), factor.to_string())
        }
        toml::Value::Float(factor) => (TransferRange::new(*factor, *factor), factor.to_string()),
        value => {
            let text: String = take(key, value, "a number, or a text such as \"0.8..1.5\"")?;
            (TransferRange::from_text(&text), format!("`{text}`"))
        }
    };
    read.map_err(|wrong| Error::malformed(format!("`{key}`: {wrong}"), found, MEND))
}

fn take_positive(key: &str, value: &toml::Value, what: &'static str) -> Result<f64, Error> {
    let number: f64 = take(key, value, "a number without quotes")?;
    match number.is_finite() && number > 0.0 {
        true => Ok(number),
        false => Err(KernelError::NotPositive {
            what,
            found: number,
        }
        .into()),
    }
}

fn take<T: DeserializeOwned>(key: &str, value: &toml::Value, expected: &str) -> Result<T, Error> {
    value.clone().try_into().map_err(|_| {
        let found = with_article(value.type_str());
        Error::malformed(format!("`{key}` to be {expected}"), found, MEND)
    })
}
