//! The place of a sensor, and what lies between it and the latch.
//!
//! A lever in the door sees the door's acceleration. A sensor on a sill or a pillar sees another one, stronger
//! or weaker by a factor that no file states.

use super::Channel;
use super::lateral::code_of;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Where a sensor sits, as far as a latch is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SensorPlace {
    /// At the latch.
    Latch,
    /// On the door that holds it.
    Door,
    /// Elsewhere on the vehicle's structure: sill, pillar, floor.
    Body,
}

impl SensorPlace {
    /// Lists every place.
    pub const ALL: [Self; 3] = [Self::Latch, Self::Door, Self::Body];

    /// Returns the word that cards and documents use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Latch => "latch",
            Self::Door => "door",
            Self::Body => "body",
        }
    }

    /// Returns the place of that word, if it is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|place| place.name().eq_ignore_ascii_case(name.trim()))
    }

    /// True if the lever's base moves as the sensor does.
    pub fn moves_as_latch(self) -> bool {
        matches!(self, Self::Latch | Self::Door)
    }
}

/// Returns the place of a channel's sensor, as its code or the head of its file states it; `None` where neither
/// does, and of a sensor that is not on a vehicle's structure.
pub fn place_of(channel: &Channel) -> Option<SensorPlace> {
    match code_of(channel) {
        Some(code) => code.place(),
        None => channel.stated.place,
    }
}

/// Least and largest factor of a transfer range. Two sills of one car differ by up to 8.6; a hundredfold is a slip.
const FACTORS: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// A range of factors between the acceleration at a sensor's place and the one at the latch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferRange {
    from: f64,
    to: f64,
}

impl TransferRange {
    /// The latch moves as the sensor does.
    pub const ONE: Self = Self { from: 1.0, to: 1.0 };

    /// Returns the range from a least to a largest factor.
    ///
    /// # Errors
    ///
    /// Says what was expected, of factors that are not positive, beyond what a car can have, or in the wrong order.
    pub fn new(from: f64, to: f64) -> Result<Self, String> {
        if !(FACTORS.contains(&from) && FACTORS.contains(&to)) {
            return Err(format!(
                "must be factors from {} to {}, as 0.8..1.5, or 1",
                FACTORS.start(),
                FACTORS.end()
            ));
        }
        match from <= to {
            true => Ok(Self { from, to }),
            false => Err("LO must not be above HI".into()),
        }
    }

    /// Reads `LO..HI`, or one factor.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    ///
    /// # Examples
    ///
    /// ```
    /// # use latchgate_recording::TransferRange;
    /// let range = TransferRange::from_text("0.8..1.5").unwrap();
    /// assert_eq!((range.from(), range.to()), (0.8, 1.5));
    /// assert_eq!(TransferRange::from_text("1"), Ok(TransferRange::ONE));
    /// assert!(TransferRange::from_text("1.5..0.8").is_err());
    /// ```
    pub fn from_text(text: &str) -> Result<Self, String> {
        let (from, to) = text.split_once("..").unwrap_or((text, text));
        let factor = |text: &str| {
            let number = text.trim().parse::<f64>();
            number.map_err(|_| "expected LO..HI, as 0.8..1.5, or one factor".to_string())
        };
        Self::new(factor(from)?, factor(to)?)
    }

    /// Returns the least factor.
    pub fn from(self) -> f64 {
        self.from
    }

    /// Returns the largest factor.
    pub fn to(self) -> f64 {
        self.to
    }
}

/// Writes it so that [`TransferRange::from_text`] reads it back.
impl fmt::Display for TransferRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.from < self.to {
            true => write!(f, "{}..{}", self.from, self.to),
            false => write!(f, "{}", self.from),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::TransferRange;

    #[test]
    fn verif_a_range_is_positive_and_in_order_and_reads_back() {
        for text in ["0.8..1.5", "1", "2.5", "0.01..100", " 1e0 .. 3 "] {
            let range = TransferRange::from_text(text);
            let again = range
                .clone()
                .and_then(|range| TransferRange::from_text(&range.to_string()));
            assert!(range.is_ok(), "{text}: {range:?}");
            assert_eq!(again, range, "{text}");
        }
        for text in [
            "1.5..0.8",
            "0",
            "0..1",
            "-1",
            "-1..2",
            "nan",
            "1..nan",
            "inf",
            "1..inf",
            "",
            "..",
            "1..",
            "a..b",
            "0.5..1000",
            "1,5",
            "1..2..3",
        ] {
            assert!(TransferRange::from_text(text).is_err(), "{text}");
        }
    }
}
