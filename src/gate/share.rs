//! A share: one of several equal parts of a gate.

use super::key::Key;
use std::fmt;

/// One of several equal parts of a gate: recordings by the hash of their name, so that they stay
/// where they are when others join.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// Its number, from 1.
    pub number: u32,
    /// Number of shares.
    pub of: u32,
}

impl Share {
    /// Reads `I/N`.
    ///
    /// # Errors
    ///
    /// The expected form, if the text is no share.
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

    /// True if the share holds a recording of that name.
    pub fn holds(&self, recording: &str) -> bool {
        Self::number_of(recording, self.of) == self.number
    }

    /// Returns the number of the share that holds a recording.
    pub fn number_of(recording: &str, of: u32) -> u32 {
        Key::of(recording.as_bytes()).below(of) + 1
    }

    /// Returns the part that the names of its files have in common.
    pub(super) fn label(&self) -> String {
        format!("-share-{}-of-{}", self.number, self.of)
    }

    /// Returns the share of a file's name, which [`Self::label`] made.
    pub(super) fn of_file(name: &str) -> Option<Self> {
        let (_, label) = name.split_once("-share-")?;
        let (number, end) = label.split_once("-of-")?;
        let (count, _) = end.split_once('.')?;
        Self::parse(&format!("{number}/{count}")).ok()
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}
