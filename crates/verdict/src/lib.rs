//! From a channel to an answer: conditioning, verdict, margin.
//!
//! [`conditioning`] makes a channel into the acceleration that drives the lever, the modules beside this
//! text say what the runs, their errors and the findings together mean, and [`margin`] says how far that
//! answer is from changing.
//!
//! [`assess()`] goes from a conditioned channel to an answer. Below it stand, from the bottom up:
//! the question (`policy`), the samples that count (`faults`, `usable_span`), the work that may be
//! done (`meter`) and the words (`wording`); the rule (`decision`) and the scatter (`ensemble`); the
//! runs (`runs`), on several `readings` of the samples for their `interpolation` error and with their
//! `noise`, drawn with its spectrum (`noise_spectrum`); one record of each stop and sign with all that it came to (`variant`); the ensembles
//! (`looks`), spared where `bounds` show that none of their
//! levers comes to the limit; when the lever opens (`opening`), what a catch beside it did (`mechanism`), what a second sensor across adds (`in_plane`) and what is said of it (`plane_findings`); the reruns (`budget`, `filters`, `what_if`, `quantile_band`); and the
//! sentences (`replay_findings`, `reasons`); `response_spectrum` says what any lever must have; `statics` has closed forms of a constant acceleration, `sled` checks a platform's pulse; `word` holds a pass back until a person has spoken; `transfer` has the factors from the sensor's place to the latch;
//! `series` lays signal and trajectories side by side.
//!
//! - `assess`: from a conditioned channel to an answer: which runs are made, and what they say
//!   together.

pub mod conditioning;

pub mod assess;
mod bounds;
mod budget;
pub mod decision;
pub mod ensemble;
pub(crate) mod faults;
pub mod filters;
pub mod in_plane;
pub(crate) mod interpolation;
mod looks;
pub mod margin;
mod mechanism;
pub(crate) mod meter;
mod noise;
pub mod noise_spectrum;
mod opening;
mod plane_findings;
pub mod policy;
mod quantile_band;
pub mod readings;
mod reasons;
mod replay_findings;
pub mod response_spectrum;
mod runs;
mod series;
pub mod sled;
pub mod statics;
pub mod transfer;
pub(crate) mod usable_span;
mod variant;
pub mod what_if;
mod word;
pub mod wording;

pub use assess::{Assessment, assess};
pub use bounds::Screens;
pub use decision::{Bound, NOMINAL_DECISION_RULE, decision_rule};
pub use ensemble::Ensemble;
pub use filters::FilterRow;

pub use mechanism::{CatchAnswer, Mechanism};
pub use opening::Opening;
pub use policy::{AssessDetail, AssessExtras, DrawnRuns, ModelChoice, Polarity, Policy, Variant};
pub use quantile_band::QuantileBand;
pub use series::{SampledSeries, SeriesRun};
pub use what_if::WhatIf;
pub use word::{TOGETHER, awaited};

use crate::conditioning::spectrum::{AmplitudeSpectrum, Spectrogram};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::TracePoint;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::OpensWhen;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The answer for one recording and one design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Answer {
    /// The lever stays below the threshold, uncertainty included.
    Pass,
    /// The lever crosses the threshold, uncertainty included.
    Fail,
    /// The uncertainty of input, model or method spans the threshold.
    Undecided,
    /// The recording cannot carry an answer.
    Unusable,
}

impl Answer {
    /// Returns the word that verdicts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Undecided => "undecided",
            Self::Unusable => "unusable",
        }
    }

    /// Returns the process's exit code: 0 pass, 1 fail, 3 undecided, 4 unusable.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Pass => 0,
            Self::Fail => 1,
            Self::Undecided => 3,
            Self::Unusable => 4,
        }
    }
}

/// A reason for the verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reason {
    /// Stable name.
    pub code: Cow<'static, str>,
    /// One sentence.
    pub text: String,
}

/// The parts of the nominal peak's uncertainty; each is a change of the nominal
/// peak measured by a rerun [rad], `None` where no rerun was possible or none applies.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorBudget {
    /// Integration and rounding.
    pub numerical: Option<f64>,
    /// What lies between samples and is not known.
    pub interpolation: Option<f64>,
    /// Standard deviation by the noise of the raw samples.
    pub noise: Option<f64>,
    /// The 97.5 % quantile of the change by draws of that noise; `None` where it has none, or the run could not
    /// pass.
    pub noise_97_5: Option<f64>,
    /// Rigid against soft stop.
    pub model: Option<f64>,
    /// The filter against none.
    pub filter: Option<f64>,
    /// The larger of plus and minus one standard error of the bias.
    pub bias: Option<f64>,
    /// As declared against reversed; `None` if declared by a card or option.
    pub polarity: Option<f64>,
}

/// The answer of one stop and polarity by part 3 of the rule, with the errors of its peak.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunAnswer {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// The answer of this run alone. Not called a verdict: a script that looks for
    /// `"verdict": "pass"` shall find the document's alone.
    pub answer: Answer,
    /// What lies between samples and is not known, of the peak [rad]; `None` where a run
    /// could not be followed.
    pub interpolation_error_rad: Option<f64>,
    /// Standard deviation of the peak from the noise of the recording [rad].
    pub noise_rad: Option<f64>,
    /// The 97.5 % quantile of the change of the peak by draws of that noise [rad]; `None` where nothing was drawn.
    pub noise_97_5_rad: Option<f64>,
    /// Draws of it under which the lever opens; a pass lets one of 128.
    pub opening_draws: Option<u32>,
    /// U of the peak: numerical plus interpolation error, plus the larger of twice the noise and its 97.5 %
    /// quantile [rad].
    pub uncertainty_rad: Option<f64>,
    /// U of the coast's peak [rad]; `None` where there is no coast.
    pub coast_uncertainty_rad: Option<f64>,
    /// What shows that no scattered lever comes to the limit, where a bound does: its ensemble is spared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<Bound>,
}

/// The trajectory of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Stop model.
    pub model: StopModel,
    /// Polarity.
    pub opens_when: OpensWhen,
    /// Points in time order, dense enough to draw.
    pub points: Vec<TracePoint>,
}

/// The curves that a report draws beside the document.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// The acceleration as recorded [m/s²].
    pub raw: Signal,
    /// The acceleration as used, in the recording's polarity [m/s²].
    pub used: Signal,
    /// The acceleration of a second in-plane sensor as used, if there is one [m/s²].
    pub second: Option<Signal>,
    /// Trajectories, the nominal run's first.
    pub traces: Vec<Trace>,
    /// Trajectories of an inertia catch, if the design has one.
    pub catch_traces: Vec<Trace>,
    /// Signal, velocity and trajectories sample by sample.
    pub series: SampledSeries,
    /// The spread of members around the nominal run.
    pub quantile_band: Option<QuantileBand>,
    /// Amplitude spectrum before conditioning.
    pub spectrum_raw: AmplitudeSpectrum,
    /// Amplitude spectrum as used.
    pub spectrum_used: AmplitudeSpectrum,
    /// Spectrogram of the acceleration as used.
    pub spectrogram: Spectrogram,
    /// The channel after CFC 60, where it was checked as a sled pulse.
    pub sled206: Option<Signal>,
}
