//! A key: the first half of a SHA-256, by which a recording or a design is found again.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fmt;

/// A key, written as 32 hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub(super) struct Key(u128);

impl Key {
    /// Returns the key of bytes.
    pub(super) fn of(bytes: &[u8]) -> Self {
        let digest = Sha256::digest(bytes);
        let half = digest.iter().take(16);
        Self(half.fold(0, |key, byte| key << 8 | u128::from(*byte)))
    }

    /// Returns one of `count` numbers from 0 on, each for about as many keys.
    pub(super) fn below(self, count: u32) -> u32 {
        (self.0 % u128::from(count.max(1))) as u32
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{:032x}", self.0))
    }
}

impl From<Key> for String {
    fn from(key: Key) -> Self {
        key.to_string()
    }
}

impl TryFrom<String> for Key {
    type Error = &'static str;

    fn try_from(digits: String) -> Result<Self, Self::Error> {
        let number = u128::from_str_radix(&digits, 16);
        match number {
            Ok(number) if digits.len() == 32 => Ok(Self(number)),
            _ => Err("expected 32 hexadecimal digits"),
        }
    }
}
