//! Conditioning: units, bias, resampling and channel frequency class, in the order of
//! good practice: units → faults → bias → resample → filter. Polarity enters last, in the model.

pub mod bias;
pub mod cfc;
pub mod quality;
pub mod resample;
pub mod spectrum;

use crate::error::Error;
use crate::recording::{Channel, Finding};
use crate::units::SampleRate;
use serde::{Deserialize, Serialize};

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
    #[expect(clippy::cast_precision_loss, reason = "indices stay far below 2^53")]
    pub fn time_s(&self, index: usize) -> f64 {
        self.start_s + index as f64 / self.rate.hertz()
    }

    /// Returns the time of the last sample [s], or the start of an empty signal.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.time_s(self.samples.len().saturating_sub(1))
    }
}

/// Which samples give the bias that is removed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BiasWindow {
    /// All samples at t ≤ −1 ms if they span at least 5 ms; else none, with a warning.
    PreEvent,
    /// The samples from the first to the second instant [s], both included.
    Window(f64, f64),
    /// None is removed.
    None,
}

/// Channel frequency class of SAE J211-1 and ISO 6487.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Cfc {
    /// CFC 60: structures, for comparison.
    Cfc60,
    /// CFC 180: structures, for integration to velocity.
    Cfc180,
    /// CFC 600: components.
    Cfc600,
    /// CFC 1000: the widest class.
    Cfc1000,
}

impl Cfc {
    /// Every class, the widest first.
    pub const ALL: [Self; 4] = [Self::Cfc1000, Self::Cfc600, Self::Cfc180, Self::Cfc60];

    /// Returns the class's number, which is also its pass-band limit FH [Hz].
    #[must_use]
    pub fn class(self) -> u32 {
        match self {
            Self::Cfc60 => 60,
            Self::Cfc180 => 180,
            Self::Cfc600 => 600,
            Self::Cfc1000 => 1000,
        }
    }

    /// Returns the name that options and verdicts use, for example `cfc1000`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cfc60 => "cfc60",
            Self::Cfc180 => "cfc180",
            Self::Cfc600 => "cfc600",
            Self::Cfc1000 => "cfc1000",
        }
    }
}

/// Which filter to apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilterChoice {
    /// CFC 1000 where the rate is at least 10 kHz (rounded to 1e-4), else none with a warning.
    Default,
    /// No filter.
    None,
    /// This class, or an error where the rate does not carry it.
    Class(Cfc),
}

/// The standard whose filter constant and end treatment are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FilterStandard {
    /// ISO 6487: ωd = 2π·CFC·25/12, point-mirrored ends of 10 ms.
    #[serde(rename = "iso6487")]
    Iso6487,
    /// SAE J211-1: ωd = 2π·CFC·2.0775, both passes started at zero.
    #[serde(rename = "saej211")]
    SaeJ211,
}

impl FilterStandard {
    /// Returns the name that options and verdicts use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Iso6487 => "iso6487",
            Self::SaeJ211 => "saej211",
        }
    }
}

/// How a channel is conditioned.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditioningOptions {
    /// Samples whose mean is removed.
    pub bias: BiasWindow,
    /// Channel frequency class.
    pub filter: FilterChoice,
    /// Whose filter.
    pub filter_standard: FilterStandard,
    /// Rate fed to the model [Hz]; `None` for the native one.
    pub resample_hz: Option<f64>,
    /// Full scale of the sensor, as a card states it [g].
    pub range_g: Option<f64>,
    /// The signal was made by a formula: no clipping or dead-sensor findings.
    pub synthetic: bool,
}

impl Default for ConditioningOptions {
    fn default() -> Self {
        Self {
            bias: BiasWindow::PreEvent,
            filter: FilterChoice::Default,
            filter_standard: FilterStandard::Iso6487,
            resample_hz: None,
            range_g: None,
            synthetic: false,
        }
    }
}

/// A conditioned channel and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditioned {
    /// As recorded, in m/s².
    pub raw: Signal,
    /// As fed to the model, before polarity.
    pub used: Signal,
    /// Mean removed [m/s²]; 0 if none was.
    pub bias_m_s2: f64,
    /// Standard error of that mean, correlation of the samples counted [m/s²].
    pub bias_standard_error_m_s2: f64,
    /// Samples in the bias window; 0 if none.
    pub bias_samples: usize,
    /// First and last instant of the bias window [s].
    pub bias_window_s: Option<(f64, f64)>,
    /// Class applied.
    pub filter: Option<Cfc>,
    /// Whose filter.
    pub filter_standard: FilterStandard,
    /// Rate asked for and applied [Hz].
    pub resample_hz: Option<f64>,
    /// What was found odd, in the raw samples and on the way.
    pub findings: Vec<Finding>,
}

/// Conditions a channel: units → faults → bias → resample → filter.
///
/// # Errors
///
/// [`crate::error::ErrorKind::RateTooLow`] if a named class is not carried by the rate;
/// [`crate::error::ErrorKind::OutOfRange`] if a window or rate cannot be used;
/// [`crate::error::ErrorKind::MissingUnit`] for a channel without a unit.
pub fn condition(_channel: &Channel, _options: &ConditioningOptions) -> Result<Conditioned, Error> {
    Err(crate::error::ErrorKind::MissingUnit.into())
}
