//! Ranges of values and windows of time.

use serde::{Deserialize, Serialize};

/// A closed range of values, in a unit that its holder names; written as a pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "(f64, f64)", into = "(f64, f64)")]
pub struct Range {
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
}

impl Range {
    /// Returns the range from `low` to `high`.
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// The range of no value yet, to which [`Self::including`] adds.
    pub const EMPTY: Self = Self::new(f64::INFINITY, f64::NEG_INFINITY);

    /// Returns the least range that holds this one and a value.
    pub fn including(self, value: f64) -> Self {
        Self::new(self.low.min(value), self.high.max(value))
    }

    /// Tells whether a value lies in the range, ends included.
    pub fn contains(self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Returns the greatest value less the least.
    pub fn width(self) -> f64 {
        self.high - self.low
    }
}

impl From<(f64, f64)> for Range {
    fn from((low, high): (f64, f64)) -> Self {
        Self { low, high }
    }
}

impl From<Range> for (f64, f64) {
    fn from(range: Range) -> Self {
        (range.low, range.high)
    }
}

/// A window of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// First instant [s].
    pub from_s: f64,
    /// Last instant [s].
    pub until_s: f64,
}

impl Window {
    /// Returns the window between two instants [s].
    pub const fn new(from_s: f64, until_s: f64) -> Self {
        Self { from_s, until_s }
    }
}
