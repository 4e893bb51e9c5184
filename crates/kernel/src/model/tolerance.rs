//! How far a number of a design scatters, as the design states it.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt::{Display, Formatter};

/// Share of a value at and beyond which a standard deviation is refused [-]: draws reach three of them.
pub const SHARE_MAX: f64 = 0.33;

/// One standard deviation of a number of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// In the number's unit.
    Deviation(f64),
    /// As a share of the number's value [-], which it follows.
    Share(f64),
}

impl Tolerance {
    /// Reads a share such as `5 %`.
    ///
    /// # Errors
    ///
    /// Says what is wrong with it: no number before `%`, or one outside 0 to 33.
    pub fn from_percent(text: &str) -> Result<Self, String> {
        let written = text.trim();
        let number = written.strip_suffix('%').map(str::trim_end);
        let Some(percent) = number.and_then(|number| number.parse::<f64>().ok()) else {
            return Err(format!("`{text}`, which is no number with %"));
        };
        let share = Self::Share(percent / 100.0);
        match share.is_share_refused() {
            true => Err(format!(
                "`{text}`, which is not from 0 % to less than 33 %: draws reach three standard deviations"
            )),
            false => Ok(share),
        }
    }

    /// Returns true of a share that is negative, no number, or as large as a third.
    pub(super) fn is_share_refused(self) -> bool {
        matches!(self, Self::Share(share) if !(0.0..SHARE_MAX).contains(&share))
    }

    /// Returns the standard deviation of a number of this value, in its unit.
    pub fn deviation(self, value: f64) -> f64 {
        match self {
            Self::Deviation(deviation) => deviation,
            Self::Share(share) => share * value.abs(),
        }
    }

    /// Returns the number that it is written with: the deviation, or the percent.
    pub fn number(self) -> f64 {
        match self {
            Self::Deviation(deviation) => deviation,
            // The shortest digits of 5 % are those of 5, not of 100 × 0.05.
            Self::Share(share) => (100.0 * share * 1e12).round() / 1e12,
        }
    }
}

impl From<f64> for Tolerance {
    fn from(deviation: f64) -> Self {
        Self::Deviation(deviation)
    }
}

impl Display for Tolerance {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Deviation(deviation) => write!(f, "{deviation}"),
            Self::Share(_) => write!(f, "{} %", self.number()),
        }
    }
}

impl Serialize for Tolerance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Deviation(deviation) => serializer.serialize_f64(*deviation),
            Self::Share(_) => serializer.collect_str(self),
        }
    }
}

/// As documents write it.
#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Number(f64),
    Text(String),
}

impl<'de> Deserialize<'de> for Tolerance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Written::deserialize(deserializer)? {
            Written::Number(deviation) => Ok(Self::Deviation(deviation)),
            Written::Text(text) => Self::from_percent(&text).map_err(serde::de::Error::custom),
        }
    }
}
