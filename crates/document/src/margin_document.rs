//! The document that a margin answers with.

use super::blocks::{ConditioningBlock, RecordingBlock, RunBlock, TransferBlock};
use crate::request::MarginRequest;
use latchgate_kernel::model::Design;
use latchgate_recording::{Finding, TestFacts};
use latchgate_verdict::Answer;
use latchgate_verdict::margin::{
    Basis, Boundary, Change, LimitCurve, Margin, Margins, NominalAnswer, Quantity,
};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

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
    /// The numbers of every quantity but the counterweight, each under its key: the value next to the nearest
    /// change, `…_bracket`, and the advice, `…_safe_from`; where one is missing, `…_reason` says why.
    #[serde(flatten)]
    pub numbers: BTreeMap<String, MarginValue>,
    /// Counterweight at which the answer changes.
    pub counterweight: Counterweight,
    /// Every change of the nominal runs' answer.
    pub boundaries: Vec<Boundary>,
    /// The answers with what they rest on.
    pub answers: Vec<Margin>,
    /// What a reader should know before the numbers.
    pub notes: Vec<String>,
    /// The design's limit under half-sine pulses.
    pub limit: Option<LimitCurve>,
    /// The factors between the sensor's place and the latch, where a person states them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer: Option<TransferBlock>,
    /// Everything odd about the recording.
    pub findings: Vec<Finding>,
    /// What was read.
    pub recording: RecordingBlock,
    /// How it was conditioned.
    pub conditioning: Option<ConditioningBlock>,
    /// The design.
    pub design: Design,
    /// What file and card say of the test.
    #[serde(default)]
    pub test: TestFacts,
    /// What was asked.
    pub request: MarginRequest,
    /// Version and time; last.
    pub run: RunBlock,
}

/// A value of [`MarginDocument::numbers`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum MarginValue {
    /// A value of a quantity, in its unit; `None` beside a reason.
    Number(Option<f64>),
    /// The two ends of a bracket, in ascending order.
    Bracket(f64, f64),
    /// A reason.
    Reason(String),
}

/// Returns the key of a quantity's numbers in the document.
fn key(quantity: Quantity) -> Option<&'static str> {
    Some(match quantity {
        Quantity::Scale => "scale_to_flip",
        Quantity::Preload => "least_preload_torque_nm",
        Quantity::SpringStiffness => "least_spring_stiffness_nm_per_rad",
        Quantity::Unbalance => "greatest_unbalance_kg_m",
        Quantity::Arm => "greatest_center_of_mass_m",
        Quantity::Counterweight => return None,
        Quantity::Restitution => "restitution",
        Quantity::LimitAngle => "least_threshold_rad",
    })
}

/// Returns the numbers of one quantity under their keys.
fn numbers(margin: &Margin) -> Vec<(String, MarginValue)> {
    let Some(key) = key(margin.quantity) else {
        return Vec::new();
    };
    let bracket = margin.change.map(Change::bracket);
    let bracket = bracket.map_or(MarginValue::Number(None), |(low, high)| {
        MarginValue::Bracket(low, high)
    });
    let mut numbers = vec![
        (key.to_string(), MarginValue::Number(margin.at())),
        (format!("{key}_bracket"), bracket),
        (
            format!("{key}_safe_from"),
            MarginValue::Number(margin.advice.safe_from),
        ),
    ];
    let reasons = [
        ("reason", &margin.reason),
        ("safe_from_reason", &margin.advice.reason),
    ];
    for (suffix, reason) in reasons {
        if let Some(reason) = reason {
            let reason = MarginValue::Reason(reason.clone());
            numbers.push((format!("{key}_{suffix}"), reason));
        }
    }
    numbers
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
    /// The factors between the sensor's place and the latch, where a person states them.
    pub transfer: Option<TransferBlock>,
    /// Channels that were judged together, where there are several.
    pub together: Vec<String>,
    /// Everything odd.
    pub findings: Vec<Finding>,
    /// What was read.
    pub recording: RecordingBlock,
    /// How it was conditioned.
    pub conditioning: Option<ConditioningBlock>,
    /// What file and card say of the test.
    pub test: TestFacts,
    /// What was asked.
    pub request: MarginRequest,
    /// Version and time.
    pub run: RunBlock,
}

impl MarginDocument {
    /// Returns a number by its key; `None` where there is none.
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.numbers.get(key)? {
            MarginValue::Number(value) => *value,
            MarginValue::Bracket(..) | MarginValue::Reason(_) => None,
        }
    }

    /// Puts a document together.
    pub fn new(margins: &Margins, design: &Design, context: Context) -> Self {
        let margin = |quantity: Quantity| {
            margins
                .answers
                .iter()
                .find(|margin| margin.quantity == quantity)
        };
        let counterweight = margin(Quantity::Counterweight);
        let mass_kg = counterweight.and_then(Margin::at);
        let radius_m = context.request.counterweight_radius_m;
        let balanced = mass_kg.map(|mass_kg| {
            let (design, _) = Quantity::Counterweight.applied(design, radius_m, mass_kg);
            design.lever
        });
        Self {
            schema: "latchgate.margin/1".into(),
            report_id: context.report_id.clone(),
            verdict: context.verdict,
            threshold_rad: design.criterion.threshold_rad,
            basis: margins.basis,
            nominal_state: margins.state,
            numbers: margins.answers.iter().flat_map(numbers).collect(),
            counterweight: Counterweight {
                mass_kg,
                mass_kg_bracket: counterweight
                    .and_then(|margin| margin.change)
                    .map(Change::bracket),
                mass_kg_safe_from: counterweight.and_then(|margin| margin.advice.safe_from),
                mass_kg_safe_from_reason: counterweight
                    .and_then(|margin| margin.advice.reason.clone()),
                radius_m,
                unbalance_kg_m: balanced.map(|lever| lever.unbalance_kg_m()),
                moment_of_inertia_kg_m2: balanced.map(|lever| lever.moment_of_inertia_kg_m2),
                reason: counterweight.and_then(|margin| margin.reason.clone()),
            },
            boundaries: margins.boundaries.clone(),
            answers: margins.answers.clone(),
            notes: notes(margins, &context),
            limit: margins.limit.clone(),
            transfer: context.transfer,
            findings: context.findings,
            recording: context.recording,
            conditioning: context.conditioning,
            design: design.clone(),
            test: context.test,
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
            "A blocking finding makes the recording unusable: these numbers are no evidence that anything passes.".to_string(),
        );
    }
    notes.push(
        "Use a value of \"passes from\" or beyond, and replay it: it was tried, not proven.".into(),
    );
    if margins.answers.iter().any(Margin::is_isolated) {
        notes.push("An isolated pass has values between it and \"passes from\" that do not pass: do not design to it.".into());
    }
    notes.push(match margins.basis {
        Basis::NominalRun => "The nearest change is where the nominal lever meets the limit angle, without errors and tolerances.".to_string(),
        Basis::Verdict => "The nearest change is where the verdict changes on the grid; it is no advice.".to_string(),
    });
    if let Some(block) = context
        .transfer
        .as_ref()
        .filter(|block| block.judged.len() > 1)
    {
        notes.push(format!(
            "\"Passes from\" holds at all {} factors from {} to {} between the sensor's place and the latch; the rest is at the worst, {}.",
            block.judged.len(),
            block.from,
            block.to,
            block.worst
        ));
    }
    if context.together.len() > 1 {
        notes.push(format!(
            "\"Passes from\" holds for all channels that were judged together ({}); the rest is of the worst, {}.",
            context.together.join(", "),
            context.recording.channel.as_deref().unwrap_or("")
        ));
    }
    if context.word_missing {
        notes.push("The verdict needs a person's word on the recording; the margins are judged as if it were given.".into());
    }
    let passes = margins.state == NominalAnswer::Pass;
    let verdict_passes = context.verdict == Answer::Pass || context.word_missing;
    if verdict_passes != passes && !margins.spoiled {
        notes.push(format!(
            "The verdict is {}, while the nominal largest angle is {} the limit angle. The errors and tolerances of the rule make the difference.",
            context.verdict.name(),
            if passes { "at or below" } else { "above" }
        ));
    }
    notes
}
