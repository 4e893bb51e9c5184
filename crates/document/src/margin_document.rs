//! The document that a margin answers with.

use super::blocks::{ConditioningBlock, RecordingBlock, RunBlock};
use crate::request::MarginRequest;
use latchgate_kernel::model::Design;
use latchgate_recording::Finding;
use latchgate_verdict::Answer;
use latchgate_verdict::margin::quantity::applied;
use latchgate_verdict::margin::{
    Basis, Boundary, LimitCurve, Map, Margin, Margins, NominalAnswer, Quantity,
};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// margin.json, key by key.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MarginDocument {
    /// `latchgate.margin/1`.
    pub schema: Cow<'static, str>,
    /// SHA-256 of the question: recording, card, design and every setting.
    pub report_id: String,
    /// The verdict on the recording as it is.
    pub verdict: Answer,
    /// The threshold [rad].
    pub threshold_rad: f64,
    /// What the margins rest on.
    pub basis: Basis,
    /// What the nominal runs say at present, no error counted.
    pub nominal_state: NominalAnswer,
    /// Factor on the recording at which the answer changes.
    pub scale_to_flip: Option<f64>,
    /// Its bracket.
    pub scale_to_flip_bracket: Option<(f64, f64)>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale_to_flip_reason: Option<String>,
    /// Factor on the recording from which on every value searched passes by the whole rule.
    pub scale_to_flip_safe_from: Option<f64>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale_to_flip_safe_from_reason: Option<String>,
    /// Preload torque at which the answer changes [N m].
    pub least_preload_torque_nm: Option<f64>,
    /// Its bracket [N m].
    pub least_preload_torque_nm_bracket: Option<(f64, f64)>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_preload_torque_nm_reason: Option<String>,
    /// Preload torque from which on every value searched passes by the whole rule [N m].
    pub least_preload_torque_nm_safe_from: Option<f64>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_preload_torque_nm_safe_from_reason: Option<String>,
    /// Unbalance m·L at which the answer changes [kg m].
    pub greatest_unbalance_kg_m: Option<f64>,
    /// Its bracket [kg m].
    pub greatest_unbalance_kg_m_bracket: Option<(f64, f64)>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub greatest_unbalance_kg_m_reason: Option<String>,
    /// Unbalance from which on every value searched passes by the whole rule [kg m].
    pub greatest_unbalance_kg_m_safe_from: Option<f64>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub greatest_unbalance_kg_m_safe_from_reason: Option<String>,
    /// Counterweight at which the answer changes.
    pub counterweight: Counterweight,
    /// Restitution at which the answer changes [-].
    pub restitution: Option<f64>,
    /// Its bracket [-].
    pub restitution_bracket: Option<(f64, f64)>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution_reason: Option<String>,
    /// Restitution from which on every value searched passes by the whole rule [-].
    pub restitution_safe_from: Option<f64>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution_safe_from_reason: Option<String>,
    /// Every change of the nominal runs' answer.
    pub boundaries: Vec<Boundary>,
    /// The answers with what they rest on.
    pub answers: Vec<Margin>,
    /// What a reader should know before the numbers.
    pub notes: Vec<String>,
    /// The design's limit under half-sine pulses.
    pub limit: Option<LimitCurve>,
    /// The map; its values stand in the CSV files.
    pub map: Option<Map>,
    /// Everything odd about the recording.
    pub findings: Vec<Finding>,
    /// What was read.
    pub recording: RecordingBlock,
    /// How it was conditioned.
    pub conditioning: Option<ConditioningBlock>,
    /// The design.
    pub design: Design,
    /// What was asked.
    pub request: MarginRequest,
    /// Version and time; last.
    pub run: RunBlock,
}

/// A mass on the far side of the pivot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Counterweight {
    /// The mass [kg]; `None` if none changes the answer.
    pub mass_kg: Option<f64>,
    /// Its bracket [kg].
    pub mass_kg_bracket: Option<(f64, f64)>,
    /// Mass from which on every value searched passes by the whole rule [kg].
    pub mass_kg_safe_from: Option<f64>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg_safe_from_reason: Option<String>,
    /// Its distance from the pivot [m].
    pub radius_m: f64,
    /// Unbalance that is left [kg m].
    pub unbalance_kg_m: Option<f64>,
    /// Moment of inertia then [kg m²].
    pub moment_of_inertia_kg_m2: Option<f64>,
    /// Why there is no mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// What a document says beside the margins.
#[derive(Debug, Clone, PartialEq)]
pub struct Context {
    /// Hash of the question.
    pub report_id: String,
    /// The verdict.
    pub verdict: Answer,
    /// That it is undecided because a person has not said what the recording needs.
    pub word_missing: bool,
    /// Everything odd.
    pub findings: Vec<Finding>,
    /// What was read.
    pub recording: RecordingBlock,
    /// How it was conditioned.
    pub conditioning: Option<ConditioningBlock>,
    /// What was asked.
    pub request: MarginRequest,
    /// Version and time.
    pub run: RunBlock,
}

impl MarginDocument {
    /// Puts a document together.
    #[must_use]
    pub fn new(margins: &Margins, design: &Design, context: Context) -> Self {
        let counterweight_radius_m = context.request.counterweight_radius_m;
        let of = |quantity: Quantity| {
            margins
                .answers
                .iter()
                .find(|answer| answer.quantity == quantity)
        };
        let at = |quantity| of(quantity).and_then(|answer| answer.at);
        let bracket = |quantity| of(quantity).and_then(|answer| answer.bracket);
        let reason = |quantity| of(quantity).and_then(|answer| answer.reason.clone());
        let safe_from = |quantity| of(quantity).and_then(|answer| answer.advice.safe_from);
        let unsafe_reason = |quantity| of(quantity).and_then(|answer| answer.advice.reason.clone());
        let counterweight = at(Quantity::Counterweight).map(|mass| {
            applied(
                Quantity::Counterweight,
                design,
                counterweight_radius_m,
                mass,
            )
            .0
            .lever
        });
        Self {
            schema: "latchgate.margin/1".into(),
            report_id: context.report_id.clone(),
            verdict: context.verdict,
            threshold_rad: design.criterion.threshold_rad,
            basis: margins.basis,
            nominal_state: margins.state,
            scale_to_flip: at(Quantity::Scale),
            scale_to_flip_bracket: bracket(Quantity::Scale),
            scale_to_flip_reason: reason(Quantity::Scale),
            scale_to_flip_safe_from: safe_from(Quantity::Scale),
            scale_to_flip_safe_from_reason: unsafe_reason(Quantity::Scale),
            least_preload_torque_nm: at(Quantity::Preload),
            least_preload_torque_nm_bracket: bracket(Quantity::Preload),
            least_preload_torque_nm_reason: reason(Quantity::Preload),
            least_preload_torque_nm_safe_from: safe_from(Quantity::Preload),
            least_preload_torque_nm_safe_from_reason: unsafe_reason(Quantity::Preload),
            greatest_unbalance_kg_m: at(Quantity::Unbalance),
            greatest_unbalance_kg_m_bracket: bracket(Quantity::Unbalance),
            greatest_unbalance_kg_m_reason: reason(Quantity::Unbalance),
            greatest_unbalance_kg_m_safe_from: safe_from(Quantity::Unbalance),
            greatest_unbalance_kg_m_safe_from_reason: unsafe_reason(Quantity::Unbalance),
            counterweight: Counterweight {
                mass_kg: at(Quantity::Counterweight),
                mass_kg_bracket: bracket(Quantity::Counterweight),
                mass_kg_safe_from: safe_from(Quantity::Counterweight),
                mass_kg_safe_from_reason: unsafe_reason(Quantity::Counterweight),
                radius_m: counterweight_radius_m,
                unbalance_kg_m: counterweight.map(|lever| lever.unbalance_kg_m()),
                moment_of_inertia_kg_m2: counterweight.map(|lever| lever.moment_of_inertia_kg_m2),
                reason: reason(Quantity::Counterweight),
            },
            restitution: at(Quantity::Restitution),
            restitution_bracket: bracket(Quantity::Restitution),
            restitution_reason: reason(Quantity::Restitution),
            restitution_safe_from: safe_from(Quantity::Restitution),
            restitution_safe_from_reason: unsafe_reason(Quantity::Restitution),
            boundaries: margins.boundaries.clone(),
            answers: margins.answers.clone(),
            notes: notes(margins, &context),
            limit: margins.limit.clone(),
            map: margins.map.clone(),
            findings: context.findings,
            recording: context.recording,
            conditioning: context.conditioning,
            design: design.clone(),
            request: context.request,
            run: context.run,
        }
    }
}

fn notes(margins: &Margins, context: &Context) -> Vec<String> {
    let mut notes = Vec::new();
    if margins.stopped {
        notes.push("The search was stopped: what it had found until then stands here.".into());
    }
    if margins.spoiled {
        notes.push(
            "A blocking finding spoils the recording: the numbers are those of the nominal run on the samples as they are, and no evidence that anything passes.".to_string(),
        );
    }
    notes.push("\"Passes from\" is the advice: that value and every one searched beyond it, up to the end of the range, passes by the whole rule with a tenth of the limit to spare. Values between those searched were not asked; check the one that is chosen by a replay.".into());
    notes.push(match margins.basis {
        Basis::NominalRun => "The nearest change is where the nominal peak angle, in the record or the coast after it, meets the limit; no error and no tolerance is counted. Where the verdict changes stands in verdict_at.".to_string(),
        Basis::Verdict => "The nearest change is where the verdict by the whole rule changes, as far as it was found. Where the nominal peak angle meets the limit stands in nominal_at.".to_string(),
    });
    if context.word_missing {
        notes.push("The verdict waits for a person's word on the recording; the margins are those with it.".into());
    }
    let passes = margins.state == NominalAnswer::Pass;
    let verdict_passes = context.verdict == Answer::Pass || context.word_missing;
    if verdict_passes != passes && !margins.spoiled {
        notes.push(format!(
            "The verdict is {}, while the nominal peak alone is {} the threshold: the doubt counted by the rule lies between them.",
            context.verdict.name(),
            if passes { "at or below" } else { "above" }
        ));
    }
    notes
}
