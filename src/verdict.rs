//! The verdict: what the runs, their errors and the findings together say.

pub mod assess;
mod bench;
pub mod decision;
pub mod ensemble;
pub mod filters;
pub mod ladder;
pub mod margin;
mod remarks;
pub mod ribbon;
pub mod screen;
pub mod verify;
pub mod what_if;
mod why;

pub use assess::{AssessOptions, Assessment, ModelChoice, Polarity, assess};
pub use decision::{DECISION_RULE, NOMINAL_DECISION_RULE};
pub use ensemble::Ensemble;
pub use filters::FilterRow;
pub use ladder::Ladder;
pub use ribbon::Ribbon;
pub use what_if::WhatIf;

use crate::conditioning::Signal;
use crate::conditioning::spectrum::{AmplitudeSpectrum, Spectrogram};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::recording::{Finding, Part};
use crate::replay::{Run, TracePoint};
use crate::units::OpensWhen;
use serde::Serialize;
use std::collections::BTreeMap;

/// The answer for one recording and one design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Undecided => "undecided",
            Self::Unusable => "unusable",
        }
    }

    /// Returns the process's exit code: 0 pass, 1 fail, 3 undecided, 4 unusable.
    #[must_use]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reason {
    /// Stable name.
    pub code: &'static str,
    /// One sentence.
    pub text: String,
}

/// Where the nominal peak's uncertainty comes from; each part is a change of the nominal
/// peak measured by a rerun [rad], `None` where no rerun was possible or none applies.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ErrorBudget {
    /// Integration and rounding.
    pub numerical: Option<f64>,
    /// Linear samples against a band-limited fourfold of them.
    pub interpolation: Option<f64>,
    /// Rigid against soft stop.
    pub model: Option<f64>,
    /// The filter against none.
    pub filter: Option<f64>,
    /// The larger of plus and minus one standard error of the bias.
    pub bias: Option<f64>,
    /// As declared against reversed; `None` if declared by a card or option.
    pub polarity: Option<f64>,
}

/// Closed-form bounds that need no integration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Screens {
    /// T0/(mL) in g: below it in the opening direction a lever on a rigid stop never leaves.
    pub static_threshold_g: f64,
    /// The same in m/s².
    pub static_threshold_m_s2: f64,
    /// √(2 I0 (T0 φ* + k0 φ*²/2))/(mL) [m/s]: the least ∫|a| dt that can reach the threshold.
    pub impulse_threshold_m_s: f64,
    /// ∫|a| dt of the signal as used, over the whole record [m/s].
    pub impulse_m_s: Option<f64>,
    /// What each bound says, per polarity and stop that count.
    pub runs: Vec<ScreenedRun>,
}

/// What the closed-form bounds say of one polarity and stop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ScreenedRun {
    /// Stop model.
    pub model: StopModel,
    /// Polarity.
    pub opens_when: OpensWhen,
    /// What they prove; `None` where only a run can tell.
    pub answer: Option<screen::Decided>,
    /// The simplest bound that proves it.
    pub by: Option<screen::Screen>,
    /// Of a proven pass, an angle that the lever does not exceed [rad].
    pub peak_at_most_rad: Option<f64>,
    /// Every bound with its value and limit.
    pub bounds: [screen::Bound; 4],
}

/// What was read.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RecordingBlock {
    /// File name without folders.
    pub file: String,
    /// SHA-256 of its bytes; of a folder, that of its list of parts.
    pub sha256: Option<String>,
    /// Further files that were read with it, each with its SHA-256.
    pub parts: Vec<Part>,
    /// SHA-256 of the channel's signal, the same whatever file it comes from.
    pub content_sha256: Option<String>,
    /// Format name.
    pub format: Option<&'static str>,
    /// Channel name.
    pub channel: Option<String>,
    /// Unit of the channel.
    pub unit: Option<&'static str>,
    /// What stated the unit.
    pub unit_source: Option<&'static str>,
    /// Number of samples.
    pub samples: usize,
    /// Sample rate [Hz].
    pub sample_rate_hz: Option<f64>,
    /// Time of the first sample [s].
    pub start_s: Option<f64>,
    /// Time of the last sample [s].
    pub end_s: Option<f64>,
    /// Largest absolute acceleration as recorded [g].
    pub peak_g: Option<f64>,
    /// When [s].
    pub peak_time_s: Option<f64>,
    /// SHA-256 of the card beside the recording; `None` without a card.
    pub card_sha256: Option<String>,
}

/// How it was conditioned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditioningBlock {
    /// Mean removed [m/s²].
    pub bias_m_s2: f64,
    /// Its standard error [m/s²].
    pub bias_standard_error_m_s2: f64,
    /// How the standard error counts correlated samples.
    pub bias_standard_error_method: &'static str,
    /// Samples it was taken from.
    pub bias_samples: usize,
    /// First and last instant of the bias window [s].
    pub bias_window_s: Option<(f64, f64)>,
    /// Filter: `none`, `cfc60`, `cfc180`, `cfc600`, `cfc1000`.
    pub filter: &'static str,
    /// Standard of the filter.
    pub filter_standard: &'static str,
    /// Design frequency of the filter's two passes, fd [Hz].
    pub filter_design_frequency_hz: Option<f64>,
    /// End treatment in words.
    pub filter_end_treatment: Option<&'static str>,
    /// Rate fed to the model [Hz]; `None` for the native one.
    pub resample_hz: Option<f64>,
    /// Largest absolute acceleration as used [g].
    pub peak_g: Option<f64>,
    /// When [s].
    pub peak_time_s: Option<f64>,
    /// Change of velocity over the record, ∫a dt as used, in the recording's own sign [m/s].
    pub velocity_change_m_s: f64,
    /// Full scale that the card declares [g].
    pub range_g: Option<f64>,
    /// The card declares a signal made by a formula: clipping and dead sensors were not
    /// looked for.
    pub synthetic: bool,
}

/// What one stop and polarity says by part 3 of the rule, and how sure its peak is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunAnswer {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// What this run alone says. Not called a verdict: a script that looks for
    /// `"verdict": "pass"` shall find the document's alone.
    pub answer: Answer,
    /// Change of the peak when the samples are refined fourfold [rad]; `None` where a run
    /// could not be followed or was not needed.
    pub interpolation_error_rad: Option<f64>,
    /// U of the peak, numerical plus interpolation error [rad].
    pub uncertainty_rad: Option<f64>,
    /// U of the coast's peak [rad]; `None` where there is no coast.
    pub coast_uncertainty_rad: Option<f64>,
}

/// What the run was asked, so that it can be repeated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Request {
    /// The command line that repeats the run, with the file's name only.
    pub command: String,
    /// Where the polarity comes from: `option`, `card`, `undeclared`.
    pub opens_when_source: &'static str,
    /// Stop model asked for: `auto`, `rigid`, `soft`.
    pub model: &'static str,
    /// Judged window [s].
    pub window_s: Option<(f64, f64)>,
    /// Initial angle [rad]; `None` for rest on the stop.
    pub phi0_rad: Option<f64>,
    /// Initial angular velocity [rad/s].
    pub omega0_rad_s: Option<f64>,
    /// Largest ensemble; 0 for nominal runs alone.
    pub members: u32,
    /// Seed of the ensemble.
    pub seed: u64,
}

/// Version and time of the run; the only block that may differ between two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunBlock {
    /// latchgate's version.
    pub version: &'static str,
    /// Time the run took [s].
    pub elapsed_s: f64,
}

/// verdict.json, key by key.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Document {
    /// `latchgate.verdict/1`.
    pub schema: &'static str,
    /// The answer.
    pub verdict: Answer,
    /// The reasons, the weightiest first.
    pub why: Vec<Reason>,
    /// The threshold [rad].
    pub threshold_rad: f64,
    /// The run with the largest peak; `None` where nothing could be replayed.
    pub nominal: Option<Run>,
    /// Per stop, the run with the larger peak.
    pub models: BTreeMap<&'static str, Run>,
    /// Per polarity and stop, where two polarities were judged.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub polarities: BTreeMap<&'static str, BTreeMap<&'static str, Run>>,
    /// What each stop and polarity says by itself, where something was replayed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<RunAnswer>,
    /// The ensemble of the stop and polarity with the largest nominal peak; `None` where only
    /// nominal runs are judged.
    pub ensemble: Option<Ensemble>,
    /// That of each stop and polarity, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ensembles: Vec<Ensemble>,
    /// Which rung decided, and why nothing finer was needed; `None` where nothing was replayed.
    pub ladder: Option<Ladder>,
    /// The preload from which on the recording passes; `None` where it was not asked for, as
    /// without a report.
    pub preload_answer: Option<margin::PreloadAnswer>,
    /// What one input moved by one standard deviation does to the nominal run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub what_if: Vec<WhatIf>,
    /// Where the peak's uncertainty comes from.
    pub error_budget_rad: ErrorBudget,
    /// Closed-form bounds.
    pub screens: Screens,
    /// What the nominal runs say after each filter; empty where it was not asked for, as with
    /// nominal runs alone and no report.
    pub filters: Vec<FilterRow>,
    /// Everything odd.
    pub findings: Vec<Finding>,
    /// What was read.
    pub recording: RecordingBlock,
    /// How it was conditioned; `None` where nothing was.
    pub conditioning: Option<ConditioningBlock>,
    /// The design.
    pub design: Design,
    /// The decision rule in words.
    pub decision_rule: &'static str,
    /// What was asked.
    pub request: Request,
    /// Version and time; last.
    pub run: RunBlock,
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

/// What a report draws beside the document.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// The acceleration as recorded [m/s²].
    pub raw: Signal,
    /// The acceleration as used, in the recording's polarity [m/s²].
    pub used: Signal,
    /// Trajectories, the nominal run's first.
    pub traces: Vec<Trace>,
    /// How members of the nominal run's ensemble spread around it.
    pub ribbon: Option<Ribbon>,
    /// Amplitude spectrum before conditioning.
    pub spectrum_raw: AmplitudeSpectrum,
    /// Amplitude spectrum as used.
    pub spectrum_used: AmplitudeSpectrum,
    /// Spectrogram of the acceleration as used.
    pub spectrogram: Spectrogram,
}
