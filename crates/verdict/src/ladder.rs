//! The ladder: bounds before runs, runs before an ensemble, and no more of an ensemble than the
//! decision needs; told in words.

use super::Answer;
use super::ensemble::{self, End, Ensemble};
use super::policy::{Policy, Variant};
use super::proof::{ProvenMembers, may_leave_out};
use super::usable_span::UsableSpan;
use super::variant::VariantResult;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::units::OpensWhen;
use serde::{Deserialize, Serialize};

/// A rung of the ladder: the kind of evidence that an answer rests on, the coarsest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Rung {
    /// Bounds in closed form, of the nominal lever and of the scattered ones.
    #[serde(rename = "bounds")]
    Bounds,
    /// Nominal runs.
    #[serde(rename = "nominal runs")]
    NominalRuns,
    /// An ensemble.
    #[serde(rename = "ensemble")]
    Ensemble,
    /// A blocking finding, before any run.
    #[serde(rename = "findings")]
    Findings,
}

impl Rung {
    /// Returns the words that verdicts use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bounds => "bounds",
            Self::NominalRuns => "nominal runs",
            Self::Ensemble => "ensemble",
            Self::Findings => "findings",
        }
    }
}

/// The way to the answer of one stop and polarity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LadderStep {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Its own answer.
    pub answer: Answer,
    /// The evidence for it.
    pub by: Rung,
    /// Nothing but its nominal run was made, since bounds prove its answer.
    pub left_out: bool,
    /// Scattered levers of which bounds prove that they stay below the limit; `None` where no
    /// bound was asked.
    pub proven_below: Option<u32>,
    /// Scattered levers of which bounds prove that they cross.
    pub proven_crossing: Option<u32>,
    /// Of how many.
    pub proven_of: Option<u32>,
    /// In a sentence.
    pub text: String,
}

/// The rung that decided, and the reason why nothing finer was needed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ladder {
    /// The finest rung that the answer needed.
    pub rung: Rung,
    /// Why nothing finer was needed, in a sentence or two.
    pub text: String,
    /// Samples that were replayed for the decision, of nominal runs, of their fourfold and of
    /// the ensembles together.
    pub samples_replayed: u64,
    /// Each stop and polarity.
    pub stops: Vec<LadderStep>,
}

/// The finished assessment that a ladder describes.
pub(super) struct LadderInput<'a> {
    pub(super) policy: &'a Policy,
    pub(super) follow_all: bool,
    pub(super) threshold_rad: f64,
    /// Samples of the recording.
    pub(super) samples: usize,
    pub(super) span: UsableSpan,
    pub(super) results: &'a [VariantResult],
}

/// Puts into words how far the decision went.
pub(super) fn ladder(of: &LadderInput<'_>) -> Ladder {
    let members = of.policy.members;
    let stops: Vec<LadderStep> = if of.span == UsableSpan::Nothing {
        Vec::new()
    } else {
        of.results.iter().map(|result| step(of, result)).collect()
    };
    let rung = if of.span == UsableSpan::Nothing {
        Rung::Findings
    } else if !stops.is_empty() && stops.iter().all(|step| step.by == Rung::Bounds) {
        Rung::Bounds
    } else if members == 0 {
        Rung::NominalRuns
    } else {
        Rung::Ensemble
    };
    let text = match rung {
        Rung::Findings => "A blocking finding holds from the first sample that counts on: no run could change that.".into(),
        Rung::Bounds => format!(
            "Bounds in closed form prove the answer of every stop and polarity{}. What was run beside that gives the figures, and could not change the answer.",
            if members > 0 { ", of the nominal lever and of enough scattered ones" } else { "" }
        ),
        Rung::NominalRuns => format!(
            "The nominal runs decide, as asked for with the setting `members` = 0; {}.",
            left_out(of, &stops)
        ),
        Rung::Ensemble => format!("{}; {}.", looked(of), left_out(of, &stops)),
    };
    Ladder {
        rung,
        text,
        samples_replayed: samples_replayed(of),
        stops,
    }
}

fn step(of: &LadderInput<'_>, result: &VariantResult) -> LadderStep {
    let Variant { opens_when, model } = result.variant;
    let run = result.counted();
    let answer = run.answer(of.threshold_rad);
    let proven = result.proof.and_then(|proof| {
        let stand_in = proof.proven(&run.outcome, of.threshold_rad, of.policy.members)?;
        Some(stand_in.answer(of.threshold_rad))
    });
    let by = if proven == Some(answer) {
        Rung::Bounds
    } else if of.policy.members == 0 {
        Rung::NominalRuns
    } else {
        Rung::Ensemble
    };
    let members = result.proof.and_then(|proof| proof.members);
    let text = match by {
        Rung::Bounds => by_bounds(result, answer, members),
        Rung::Ensemble => match &result.ensemble {
            Some(ensemble) => format!(
                "No bound proves the rule's answer; its ensemble ended at look {} with {} members: {}.",
                ensemble.look,
                ensemble.members,
                why_ended(ensemble.ended)
            ),
            None => "Not looked at.".into(),
        },
        _ => "No bound proves the rule's answer; its nominal run and its fourfold do.".into(),
    };
    LadderStep {
        model,
        opens_when,
        answer,
        by,
        left_out: run.left_out,
        proven_below: members.map(|of| of.below),
        proven_crossing: members.map(|of| of.crossing),
        proven_of: members.map(|of| of.of),
        text,
    }
}

/// Says which bound proves the answer, of how many levers, and what was run all the same.
fn by_bounds(result: &VariantResult, answer: Answer, members: Option<ProvenMembers>) -> String {
    let bound = result
        .screened
        .by
        .map_or("closed-form", |screen| screen.name());
    let share = members.map_or_else(String::new, |members| {
        let proven = if answer == Answer::Pass {
            members.below
        } else {
            members.crossing
        };
        let of = members.of;
        format!(", and {proven} of {of} scattered levers do so by bounds alone")
    });
    let rest = if result.counted().left_out {
        "; beyond its nominal run nothing was run, since it could only say the same"
    } else {
        "; it has the larger peak and was run in full, for the figures"
    };
    match answer {
        Answer::Pass => format!(
            "The {bound} bound keeps the nominal lever below the limit, on the samples and on their fourfold{share}{rest}."
        ),
        _ => format!("The {bound} bound takes the nominal lever beyond the limit{share}{rest}."),
    }
}

fn why_ended(end: End) -> &'static str {
    match end {
        End::Decided => "the rule decided there",
        End::LastLook => "there is no further look",
        End::NoMatter => "more could not change the answer",
        End::WorkLimit => "more would take more than the limit `work` allows",
    }
}

/// Says at which look the ensembles ended, and why not later.
fn looked(of: &LadderInput<'_>) -> String {
    let ran: Vec<&Ensemble> = ensembles(of).collect();
    let Some(furthest) = ran.iter().max_by_key(|ensemble| ensemble.members) else {
        return "No ensemble was run".into();
    };
    let looks = ensemble::looks(of.policy.members).len();
    let end = if ran.iter().any(|ensemble| ensemble.ended == End::LastLook) {
        "which is the last: nothing finer was asked for"
    } else if ran.iter().any(|ensemble| ensemble.ended == End::WorkLimit) {
        "where the limit `work` ended it"
    } else if ran.iter().all(|ensemble| ensemble.ended == End::Decided) {
        "where the rule decided; its bounds allow for the looks that were not needed"
    } else {
        "where no answer that was still open could change the verdict"
    };
    format!(
        "The ensemble decides at look {} of {looks}, with {} members, {end}",
        furthest.look, furthest.members
    )
}

/// Says which stops were left out.
fn left_out(of: &LadderInput<'_>, stops: &[LadderStep]) -> String {
    if let Err(why) = may_leave_out(of.policy, of.follow_all, of.span) {
        return format!("no stop was left out: {why}");
    }
    let names: Vec<String> = stops
        .iter()
        .filter(|step| step.left_out)
        .map(|step| {
            format!(
                "the {} stop, {} opening, {}",
                step.model.name(),
                step.opens_when.name(),
                step.answer.name()
            )
        })
        .collect();
    if names.is_empty() {
        "no bound proves what a stop that was followed would have said, so none was left out".into()
    } else {
        format!("proven by bounds and left out: {}", names.join("; "))
    }
}

fn ensembles<'a>(of: &LadderInput<'a>) -> impl Iterator<Item = &'a Ensemble> {
    let results = of.results.iter();
    results.filter_map(|result| result.ensemble.as_ref())
}

/// Counts the samples of nominal runs, of their fourfold and of all members.
fn samples_replayed(of: &LadderInput<'_>) -> u64 {
    let in_full = |result: &VariantResult| if result.counted().left_out { 1 } else { 5 };
    let runs: u64 = of.results.iter().map(in_full).sum();
    let members: u64 = ensembles(of).map(|of| u64::from(of.members)).sum();
    of.samples as u64 * (runs + members)
}
