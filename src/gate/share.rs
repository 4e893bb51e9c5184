//! A share: one of several equal parts of a gate.

use super::key::Key;
use std::fmt;

/// One of several equal parts of a gate: recordings by the hash of their name, so that they stay
/// where they are when others join.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// Its number, from 1.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Share {
    /// Reads `I/N`.
    ///
    /// # Errors
    ///
    /// What was expected, if the text is no share.
    pub fn parse(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            Some(Self {
                number: number.trim().parse().ok()?,
                of: of.trim().parse().ok()?,
            })
        });
        numbers
            .filter(|share| (1..=share.of).contains(&share.number))
            .ok_or_else(|| "expected I/N, from 1/N to N/N, for example 3/100".into())
    }

    /// Tells whether a recording of that name is of the share.
    pub fn holds(&self, recording: &str) -> bool {
        Self::number_of(recording, self.of) == self.number
    }

    /// Returns the number of the share that holds a recording.
    pub fn number_of(recording: &str, of: u32) -> u32 {
        Key::of(recording.as_bytes()).below(of) + 1
    }

    /// Returns what the names of its files hold.
    pub(super) fn label(&self) -> String {
        format!("-share-{}-of-{}", self.number, self.of)
    }

    /// Returns the share that a file's name tells of.
    pub(super) fn of_file(name: &str) -> Option<Self> {
        let (_, rest) = name.split_once("-share-")?;
        let (number, rest) = rest.split_once("-of-")?;
        let (of, _) = rest.split_once('.')?;
        Self::parse(&format!("{number}/{of}")).ok()
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}
