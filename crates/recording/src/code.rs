//! Channel codes: 16 characters for place and quantity of a channel.

use crate::words::{Words, word_list};
use crate::{Finding, SensorPlace};

/// Locations that are plainly on the structure of a vehicle.
static STRUCTURE: Words = word_list!("iso-mme-structure");

/// A side of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VehicleSide {
    Left,
    Right,
}

/// A channel code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Code([u8; 16]);

impl Code {
    /// Reads a code: 16 letters, digits or question marks. Some programs write small letters.
    pub(super) fn new(text: &str) -> Option<Self> {
        let capitals = text.trim().to_ascii_uppercase();
        let bytes: [u8; 16] = capitals.as_bytes().try_into().ok()?;
        bytes
            .iter()
            .all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit() || *byte == b'?')
            .then_some(Self(bytes))
    }

    fn location(&self) -> &[u8] {
        &self.0[2..6]
    }

    /// True if the physical dimension is a linear acceleration.
    pub(super) fn is_acceleration(&self) -> bool {
        &self.0[12..14] == b"AC"
    }

    /// True if the physical dimension is time.
    pub(super) fn is_time(&self) -> bool {
        &self.0[12..14] == b"TI" || self.location() == b"TIRS"
    }

    /// True if it is an acceleration along Y, whatever its sign.
    pub(super) fn is_lateral(&self) -> bool {
        self.is_acceleration() && matches!(self.0[14], b'Y' | b'2')
    }

    /// Returns the axis of the direction, whatever its sign.
    pub(super) fn axis(&self) -> Option<&'static str> {
        match self.0[14] {
            b'X' | b'1' => Some("X"),
            b'Y' | b'2' => Some("Y"),
            b'Z' | b'3' => Some("Z"),
            _ => None,
        }
    }

    /// Tells whether another code is of the same place: all but quantity, direction and filter is alike.
    pub(super) fn is_same_place(&self, other: &Self) -> bool {
        self.0[..12] == other.0[..12]
    }

    /// Returns the finding that the sign differs from SAE J211, as it does in directions 1, 2 and 3.
    pub(super) fn sign_finding(&self) -> Option<Finding> {
        let text = format!(
            "the sign of {} differs from SAE J211, by its direction. State the opening direction \
             of these samples with the setting `opens_when`",
            self.text()
        );
        let diverges = matches!(self.0[14], b'1' | b'2' | b'3');
        diverges.then(|| Finding::warning("sign-diverges", text))
    }

    /// True if the sensor sits on a vehicle's structure, not in a dummy or on a barrier.
    pub(super) fn is_structure(&self) -> bool {
        let is_here = |location: &&str| location.as_bytes() == self.location();
        !matches!(self.0[0], b'M' | b'B') && STRUCTURE.iter().any(is_here)
    }

    /// Returns the place of a sensor on a vehicle's structure.
    pub(super) fn place(&self) -> Option<SensorPlace> {
        self.is_structure().then(|| match self.location() {
            b"LATC" | b"LOCK" | b"LOSY" => SensorPlace::Latch,
            b"DOOR" | b"DOPA" => SensorPlace::Door,
            _ => SensorPlace::Body,
        })
    }

    /// Returns the side that position or fine location names.
    pub(super) fn side(&self) -> Option<VehicleSide> {
        match self.0[1] {
            b'1' | b'4' | b'7' => return Some(VehicleSide::Left),
            b'3' | b'6' | b'9' => return Some(VehicleSide::Right),
            _ => {}
        }
        self.0[6..12].chunks(2).find_map(|fine| match fine {
            b"LE" => Some(VehicleSide::Left),
            b"RI" => Some(VehicleSide::Right),
            _ => None,
        })
    }

    /// Returns the channel frequency class that the last character states.
    pub(super) fn filter_class(&self) -> Option<&'static str> {
        class_of(self.0[15])
    }

    /// True if the last character states that the channel is unfiltered.
    pub(super) fn says_unfiltered(&self) -> bool {
        self.0[15] == b'0'
    }

    /// Returns the character of the test object that the sensor belongs to.
    pub(super) fn object(&self) -> u8 {
        self.0[0]
    }

    pub(super) fn text(&self) -> String {
        String::from_utf8_lossy(&self.0).into_owned()
    }

    /// True if two codes may mean one channel: a question mark matches any character.
    pub(super) fn agrees_with(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(letter, other_letter)| {
            letter == other_letter || *letter == b'?' || *other_letter == b'?'
        })
    }
}

/// The channel frequency classes.
pub(super) const CLASSES: &[&str] = &["20", "60", "180", "600", "1000"];

/// Returns the channel frequency class of a letter.
pub(super) fn class_of(letter: u8) -> Option<&'static str> {
    match letter {
        b'L' => Some("20"),
        b'D' | b'H' => Some("60"),
        b'C' | b'G' => Some("180"),
        b'B' | b'F' => Some("600"),
        b'A' | b'E' => Some("1000"),
        _ => None,
    }
}

/// True if `text` fits a pattern: `?` for one character, `[Y2]` for one of several, `*` for any number
/// of them. Case does not count.
pub(super) fn fits(pattern: &str, text: &str) -> bool {
    let [pattern, text] = [pattern, text].map(|text| text.trim().to_uppercase());
    glob::Pattern::new(&pattern).is_ok_and(|pattern| pattern.matches(&text))
}
