//! The signal that drives a lever.

use crate::units::SampleRate;

/// A uniformly sampled acceleration [m/s²], linear between samples, zero after the last.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Time of the first sample [s].
    pub start_s: f64,
    /// Sample rate.
    pub rate: SampleRate,
    /// Samples [m/s²], in the recording's own polarity.
    pub samples: Vec<f64>,
}

impl Signal {
    /// Returns the time of sample `index` [s].
    #[must_use]
    pub fn time_s(&self, index: usize) -> f64 {
        self.start_s + index as f64 / self.rate.hertz()
    }

    /// Returns the time of the last sample [s], or the start of an empty signal.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.time_s(self.samples.len().saturating_sub(1))
    }
}
