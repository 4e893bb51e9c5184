//! Cards: a recording's full name plus `.toml`, saying what the file itself does not.

use crate::units::{AccelerationUnit, OpensWhen};
use serde::Deserialize;

/// What a card says about the recording beside it. Every key is optional.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// Channel to use.
    pub channel: Option<String>,
    /// Unit of acceleration.
    pub unit: Option<AccelerationUnit>,
    /// Sign of the recorded acceleration that swings the lever open: `negative`, `positive`, `both`.
    pub opens_when: Option<CardPolarity>,
    /// Sample rate [Hz].
    pub rate: Option<f64>,
    /// Full scale of the channel, in the channel's unit if one is stated there, else g.
    pub range_g: Option<f64>,
    /// True for a signal made by a formula: no clipping or dead-sensor findings.
    #[serde(default)]
    pub synthetic: bool,
    /// Where it comes from.
    pub source: Option<String>,
    /// Its licence.
    pub licence: Option<String>,
    /// Anything else.
    pub notes: Option<String>,
}

/// A polarity as a card or option states it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
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
    /// Returns the polarities to judge.
    #[must_use]
    pub fn polarities(self) -> &'static [OpensWhen] {
        match self {
            Self::Negative => &[OpensWhen::Negative],
            Self::Positive => &[OpensWhen::Positive],
            Self::Both => &[OpensWhen::Negative, OpensWhen::Positive],
        }
    }
}
