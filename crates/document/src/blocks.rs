//! The documents that a replay answers with, block by block.

use crate::request::{PolaritySource, Request, TransferSource};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::Run;
use latchgate_kernel::units::{AccelerationUnit, OpensWhen};
use latchgate_recording::card::CardPolarity;
use latchgate_recording::{Finding, Part, SensorPlace, TestFacts};
use latchgate_verdict::conditioning::{Between, Cfc, FilterStandard};
use latchgate_verdict::in_plane::InPlane;
use latchgate_verdict::margin::Advice;
use latchgate_verdict::sled::SledCheck;
use latchgate_verdict::{
    Answer, Ensemble, ErrorBudget, FilterRow, Mechanism, Opening, Reason, RunAnswer, Screens,
    WhatIf,
};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// What was read.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
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
    pub format: Option<Cow<'static, str>>,
    /// Channel name.
    pub channel: Option<String>,
    /// Unit of the channel.
    pub unit: Option<AccelerationUnit>,
    /// What stated the unit.
    pub unit_source: Option<Cow<'static, str>>,
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
    /// Largest |∫a dt| over any 0.3 s of the record, without bias and unfiltered [m/s].
    pub velocity_change_m_s: Option<f64>,
    /// SHA-256 of the card beside the recording; `None` without a card.
    pub card_sha256: Option<String>,
    /// Sign of the recorded acceleration that opens, as declared; `None` where nobody says.
    pub opens_when: Option<CardPolarity>,
    /// Who declares it.
    pub opens_when_source: PolaritySource,
    /// Place of the sensor; `None` where nothing says.
    #[serde(default)]
    pub place: Option<SensorPlace>,
}

/// How it was conditioned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditioningBlock {
    /// Mean removed [m/s²].
    pub bias_m_s2: f64,
    /// Its standard error [m/s²].
    pub bias_standard_error_m_s2: f64,
    /// How the standard error counts correlated samples.
    pub bias_standard_error_method: Cow<'static, str>,
    /// Samples it was taken from.
    pub bias_samples: usize,
    /// First and last instant of the bias window [s].
    pub bias_window_s: Option<(f64, f64)>,
    /// Filter: `none`, `cfc60`, `cfc180`, `cfc600`, `cfc1000`.
    #[serde(with = "latchgate_verdict::conditioning::applied_filter")]
    pub filter: Option<Cfc>,
    /// Standard of the filter.
    pub filter_standard: FilterStandard,
    /// Design frequency of the filter's two passes, fd [Hz].
    pub filter_design_frequency_hz: Option<f64>,
    /// End treatment in words.
    pub filter_end_treatment: Option<Cow<'static, str>>,
    /// Rate fed to the model [Hz]; `None` for the native one.
    pub resample_hz: Option<f64>,
    /// How the acceleration runs between samples.
    pub between: Between,
    /// Standard deviation of the raw samples' white noise [m/s²].
    pub noise_m_s2: f64,
    /// Largest absolute acceleration as used [g].
    pub peak_g: Option<f64>,
    /// When [s].
    pub peak_time_s: Option<f64>,
    /// Full scale that the card declares [g].
    pub range_g: Option<f64>,
    /// The card declares a signal made by a formula: clipping and dead sensors were not
    /// looked for.
    pub synthetic: bool,
}

/// The second in-plane channel, and how the lever sees both.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InPlaneBlock {
    /// Name of the channel.
    pub radial_channel: String,
    /// Door that the declared opening direction means, `left` or `right`; `None` where both directions were judged.
    pub door: Option<Cow<'static, str>>,
    /// Axis of it, and direction cosines of both channels for a left door.
    #[serde(flatten)]
    pub directions: InPlane,
    /// Mean removed [m/s²].
    pub bias_m_s2: f64,
    /// Its standard error [m/s²].
    pub bias_standard_error_m_s2: f64,
    /// Standard deviation of the raw samples' white noise [m/s²].
    pub noise_m_s2: f64,
    /// Largest absolute acceleration as used [g].
    pub peak_g: Option<f64>,
    /// When [s].
    pub peak_time_s: Option<f64>,
}

/// Version, day, maker and time of the run; the only block that may differ between two runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunBlock {
    /// latchgate's version.
    pub version: Cow<'static, str>,
    /// Revision of the numbers, [`crate::identity::NUMBERS_REVISION`]; `None` in documents of
    /// versions that counted none.
    pub numbers_revision: Option<u32>,
    /// Day of the run, UTC, `YYYY-MM-DD`.
    pub date: Option<String>,
    /// Who made it, as stated.
    pub by: Option<String>,
    /// Name of the design file, where there is one.
    pub design_file: Option<String>,
    /// SHA-256 of its bytes.
    #[serde(default)]
    pub design_file_sha256: Option<String>,
    /// Time the run took [s].
    pub elapsed_s: f64,
}

impl RunBlock {
    /// Names the file from which the design was read.
    pub fn set_design_file(&mut self, file: Option<DesignFile>) {
        (self.design_file, self.design_file_sha256) =
            file.map(|file| (file.name, file.sha256)).unzip();
    }
}

/// A design file as it was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DesignFile {
    /// Its name without folders.
    pub name: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

/// The factors between the sensor's place and the latch, as a person states them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TransferBlock {
    /// Least factor.
    pub from: f64,
    /// Largest factor.
    pub to: f64,
    /// Factors that were judged: both ends and every value of E48 between.
    pub judged: Vec<f64>,
    /// The answer at each of them, before a person's word is asked for.
    pub answers: Vec<Answer>,
    /// The factor whose answer counts, to which the document's numbers belong.
    pub worst: f64,
    /// Who states them.
    pub source: TransferSource,
}

/// One of the lateral channels of a side that were judged together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SiblingBlock {
    /// Name of the channel.
    pub channel: Option<String>,
    /// Place of its sensor; `None` where nothing says.
    pub place: Option<SensorPlace>,
    /// Its answer.
    pub answer: Answer,
    /// Largest angle of its nominal lever [rad]; `None` where nothing was replayed.
    pub peak_angle_rad: Option<f64>,
    /// Its weightiest reason.
    pub reason: Option<Reason>,
}

impl Document {
    /// Returns the answer for the stop and opening direction of a run.
    pub fn answer_of(&self, run: &Run) -> Option<&RunAnswer> {
        let mut answers = self.answers.iter();
        answers.find(|answer| (answer.model, answer.opens_when) == (run.model, run.opens_when))
    }
}

/// verdict.json, key by key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Document {
    /// `latchgate.verdict/1`.
    pub schema: Cow<'static, str>,
    /// What the question and what was read for it hash to: the same question gives the same
    /// report, any other another.
    pub report_id: String,
    /// The answer.
    pub verdict: Answer,
    /// The reasons, the weightiest first.
    pub why: Vec<Reason>,
    /// The threshold [rad].
    pub threshold_rad: f64,
    /// The run with the largest peak; `None` where nothing could be replayed.
    pub nominal: Option<Run>,
    /// Per stop, the run with the larger peak.
    pub models: BTreeMap<StopModel, Run>,
    /// Per polarity and stop, where two polarities were judged.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub polarities: BTreeMap<OpensWhen, BTreeMap<StopModel, Run>>,
    /// What each stop and polarity says by itself, where something was replayed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<RunAnswer>,
    /// When the lever opens; `None` where no run crosses, and where the recording is unusable.
    #[serde(default)]
    pub opens: Option<Opening>,
    /// The same by opening direction, where two were judged.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub opens_by_direction: BTreeMap<OpensWhen, Opening>,
    /// The ensemble of the stop and polarity with the largest nominal peak; `None` where only
    /// nominal runs are judged.
    pub ensemble: Option<Ensemble>,
    /// That of each stop and polarity, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ensembles: Vec<Ensemble>,
    /// The preload from which on the recording passes; `None` where it was not asked for, as
    /// without a report.
    pub preload_answer: Option<Advice>,
    /// Up to which restitution a pass stays one; `None` of any other answer, and where it was not asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution_answer: Option<Advice>,
    /// What the recording is as a sled pulse, where that was asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sled206: Option<SledCheck>,
    /// The second in-plane channel, where one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_plane: Option<InPlaneBlock>,
    /// The factors between the sensor's place and the latch, where a person states them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer: Option<TransferBlock>,
    /// Every lateral channel of that side, where they were judged together; the document is that of the worst.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub siblings: Vec<SiblingBlock>,
    /// The mechanism beside the lever, and what it did; absent of the lever alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mechanism: Option<Mechanism>,
    /// What one input moved by one standard deviation does to the nominal run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub what_if: Vec<WhatIf>,
    /// Where the peak's uncertainty comes from.
    pub error_budget_rad: ErrorBudget,
    /// Static and impulse threshold.
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
    pub decision_rule: Cow<'static, str>,
    /// What file and card say of the test.
    #[serde(default)]
    pub test: TestFacts,
    /// The question; `verify` and services repeat it from here.
    pub request: Request,
    /// Version and time; last.
    pub run: RunBlock,
}

/// What a replay of several recordings prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdicts {
    /// `latchgate.verdicts/1`.
    pub schema: Cow<'static, str>,
    /// The worst answer of them.
    pub verdict: Option<Answer>,
    /// Each recording's, in the order they were named.
    pub verdicts: Vec<Document>,
}
