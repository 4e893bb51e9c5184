//! The ladder: bounds before runs, runs before an ensemble, and no more of an ensemble than the
//! decision needs.
//!
//! A stop and polarity is left out, its nominal run apart, only where bounds prove what the whole
//! rule would say of it; `docs/decision.md` has the argument.

use super::assess::Scope;
use super::bench::{Bench, Pair};
use super::decision::{FAIL_SHARE_MIN, Judged, PASS_SHARE_MAX, Share};
use super::ensemble::{self, End, Ensemble, Scatter, bounds};
use super::policy::{ModelChoice, Policy};
use super::screen::{self, Decided, Seen, Subject};
use super::{Answer, ScreenedRun};
use crate::conditioning::Signal;
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::replay::{Method, Outcome};
use crate::units::OpensWhen;
use serde::{Deserialize, Serialize};

/// What an answer rests on, the coarsest first.
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

/// How far one stop and polarity was followed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// What it says by itself.
    pub answer: Answer,
    /// What says so.
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

/// Which rung decided, and why nothing finer was needed.
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
    pub stops: Vec<Step>,
}

/// What bounds know of one stop and polarity.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Known {
    /// An interpolation error that is not exceeded [rad].
    pub(super) interpolation_at_most_rad: Option<f64>,
    /// Scattered levers that stay below, that cross, and how many were asked.
    pub(super) members: Option<(u32, u32, u32)>,
}

impl Known {
    /// Bounds of the share that crosses, as those of the first look, which are no wider.
    fn share(&self) -> Option<Share> {
        self.members.map(|(below, crossing, of)| {
            let upper = bounds::upper(
                u64::from(of.saturating_sub(below)),
                u64::from(of),
                bounds::LOOK_CONFIDENCE,
            );
            Share {
                lower: bounds::lower(u64::from(crossing), u64::from(of), bounds::LOOK_CONFIDENCE),
                upper,
                // What stays below by the bounds does so in the coast as well.
                upper_with_coast: upper,
            }
        })
    }

    /// Returns the run with what is known in place of what would be measured.
    ///
    /// Every condition of the rule for a pass or a fail gets easier with a smaller error and with
    /// bounds of the share that lie closer together: what the rule says of this it also says of
    /// the run that was followed to the first look.
    pub(super) fn judged(&self, outcome: Outcome) -> Judged {
        Judged {
            outcome,
            interpolation_error_rad: self.interpolation_at_most_rad.unwrap_or(f64::MAX),
            share: self.share(),
            left_out: true,
        }
    }

    /// Returns the answer that is proven, by the rule with an ensemble if there is one.
    pub(super) fn proves(&self, outcome: &Outcome, threshold: f64, members: u32) -> Option<Answer> {
        if members > 0 && self.members.is_none() {
            return None;
        }
        let answer = self.judged(outcome.clone()).answer(threshold);
        (answer != Answer::Undecided).then_some(answer)
    }
}

/// Returns whether a stop may be left out at all; otherwise why not.
pub(super) fn may_leave_out(
    policy: &Policy,
    follow_all: bool,
    scope: Scope,
) -> Result<(), &'static str> {
    if policy.model != ModelChoice::Auto {
        Err("the stop model is given")
    } else if follow_all {
        Err("every stop was to be followed in full")
    } else if policy.method != Method::EventDriven {
        Err("a method for comparison was asked for")
    } else if policy.initial_angle_rad.is_some() || policy.initial_velocity_rad_s.is_some() {
        Err("an initial state is given")
    } else if scope != Scope::Whole {
        Err("a blocking finding ends the samples that count")
    } else {
        Ok(())
    }
}

/// Asks the bounds about one stop and polarity, of which `screened` is what they say of the
/// nominal lever on the samples.
pub(super) fn known(
    bench: &Bench<'_>,
    scatter: Option<&Scatter>,
    pair: Pair,
    window: Option<(usize, usize)>,
    outcome: &Outcome,
    screened: Option<Decided>,
) -> Known {
    let interpolation_at_most_rad = (screened != Some(Decided::Fail))
        .then(|| interpolation_at_most(bench, pair, window, outcome))
        .flatten();
    let members = match (scatter, screened) {
        (Some(scatter), Some(wanted)) if of_use(wanted, interpolation_at_most_rad) => {
            members(bench, scatter, pair, window, wanted)
        }
        _ => None,
    };
    Known {
        interpolation_at_most_rad,
        members,
    }
}

/// A pass needs the error of the nominal peak; a fail by nearly all members does not.
fn of_use(wanted: Decided, interpolation_at_most_rad: Option<f64>) -> bool {
    wanted == Decided::Fail || interpolation_at_most_rad.is_some()
}

/// Bounds the change of peak and of coast peak when the samples are refined fourfold.
///
/// With F the bound on the angle under the refined samples and −δ the angle at rest, at which
/// every run begins, the refined peak lies between −δ and F. So it differs from a peak P by at
/// most F − P or P + δ, and with H the larger of P and the coast's peak, F − P and H + δ bound
/// both changes.
fn interpolation_at_most(
    bench: &Bench<'_>,
    (opens_when, model): Pair,
    window: Option<(usize, usize)>,
    outcome: &Outcome,
) -> Option<f64> {
    let rest = match model {
        StopModel::Rigid => 0.0,
        // In a window that begins later the lever may have been pressed deeper.
        StopModel::Soft if window.is_some() => return None,
        StopModel::Soft => -bench.design.stop.rest_angle_rad(&bench.design.lever),
    };
    if outcome.broke_down {
        return None;
    }
    let fine_window = window.map(|(first, last)| (4 * first, 4 * last));
    let subject = subject(bench.design, model, fine_window);
    let most = screen::screen(&subject, &Seen::of(bench.fine, opens_when)).peak_at_most_rad?;
    let peak = outcome.run.peak_angle_rad;
    let highest = outcome
        .run
        .coast_peak_angle_rad
        .map_or(peak, |coast| coast.max(peak));
    Some((most - peak).max(highest + rest).max(0.0))
}

fn subject(design: &Design, model: StopModel, window: Option<(usize, usize)>) -> Subject {
    Subject {
        lever: design.lever,
        stop: design.stop,
        model,
        threshold_rad: design.criterion.threshold_rad,
        initial: None,
        window,
    }
}

/// Asks the bounds about the members of the first look, until it is clear that `wanted` cannot
/// be proven of enough of them.
fn members(
    bench: &Bench<'_>,
    scatter: &Scatter,
    (opens_when, model): Pair,
    window: Option<(usize, usize)>,
    wanted: Decided,
) -> Option<(u32, u32, u32)> {
    let of = *ensemble::looks(bench.policy.members).first()?;
    let seen = Seen::of(bench.signal, opens_when);
    let nominal = subject(bench.design, model, window);
    let (mut below, mut crossing) = (0, 0);
    for index in 0..of {
        let member = scatter.member(index);
        let own = Subject {
            lever: member.lever,
            stop: member.stop,
            ..nominal
        };
        let decided = screen::decide(&own, &seen.changed(member.scale, member.bias_m_s2));
        match decided {
            Some(Decided::Pass) => below += 1,
            Some(Decided::Fail) => crossing += 1,
            None => {}
        }
        if decided == Some(wanted) {
            continue;
        }
        let open = Known {
            interpolation_at_most_rad: None,
            members: Some((of - (index + 1 - below), of - (index + 1 - crossing), of)),
        };
        let hopeless = open.share().is_none_or(|best| match wanted {
            Decided::Pass => best.upper > PASS_SHARE_MAX,
            Decided::Fail => best.lower < FAIL_SHARE_MIN,
        });
        if hopeless {
            return None;
        }
    }
    Some((below, crossing, of))
}

/// What a ladder is told about.
pub(super) struct Climbed<'a> {
    pub(super) policy: &'a Policy,
    pub(super) follow_all: bool,
    pub(super) design: &'a Design,
    pub(super) signal: &'a Signal,
    pub(super) scope: Scope,
    pub(super) pairs: &'a [Pair],
    /// Of the samples that count.
    pub(super) judged: &'a [Judged],
    /// What bounds say of each pair, where they were asked.
    pub(super) known: &'a [Option<Known>],
    pub(super) screens: &'a [ScreenedRun],
    pub(super) ensembles: &'a [Option<Ensemble>],
}

/// Puts into words how far the decision went.
pub(super) fn climbed(of: &Climbed<'_>) -> Ladder {
    let threshold = of.design.criterion.threshold_rad;
    let members = of.policy.members;
    let stops: Vec<Step> = if of.scope == Scope::Nothing {
        Vec::new()
    } else {
        (0..of.pairs.len())
            .map(|index| step(of, index, threshold))
            .collect()
    };
    let rung = if of.scope == Scope::Nothing {
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
        samples_replayed: samples(of),
        stops,
    }
}

fn step(of: &Climbed<'_>, index: usize, threshold: f64) -> Step {
    let (opens_when, model) = of.pairs[index];
    let judged = &of.judged[index];
    let known = of.known.get(index).copied().flatten();
    let proven =
        known.and_then(|known| known.proves(&judged.outcome, threshold, of.policy.members));
    let answer = judged.answer(threshold);
    let by = if proven == Some(answer) {
        Rung::Bounds
    } else if of.policy.members == 0 {
        Rung::NominalRuns
    } else {
        Rung::Ensemble
    };
    let members = known.and_then(|known| known.members);
    let text = match (by, judged.left_out) {
        (Rung::Bounds, left_out) => {
            let bound = of
                .screens
                .iter()
                .find(|run| (run.opens_when, run.model) == (opens_when, model))
                .and_then(|run| run.by)
                .map_or("", |screen| screen.name());
            let share = members.map_or_else(String::new, |(below, crossing, asked)| {
                format!(
                    ", and {} of {asked} scattered levers do so by bounds alone",
                    if answer == Answer::Pass {
                        below
                    } else {
                        crossing
                    }
                )
            });
            let rest = if left_out {
                "; beyond its nominal run nothing was run, since it could only say the same"
            } else {
                "; it has the larger peak and was run in full, for the figures"
            };
            match answer {
                Answer::Pass => format!(
                    "The {bound} bound keeps the nominal lever below the limit, on the samples and on their fourfold{share}{rest}."
                ),
                _ => format!(
                    "The {bound} bound takes the nominal lever beyond the limit{share}{rest}."
                ),
            }
        }
        (Rung::Ensemble, _) => match of.ensembles.get(index).and_then(Option::as_ref) {
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
    Step {
        model,
        opens_when,
        answer,
        by,
        left_out: judged.left_out,
        proven_below: members.map(|(below, _, _)| below),
        proven_crossing: members.map(|(_, crossing, _)| crossing),
        proven_of: members.map(|(_, _, asked)| asked),
        text,
    }
}

fn why_ended(end: End) -> &'static str {
    match end {
        End::Decided => "the rule decided there",
        End::LastLook => "there is no further look",
        End::NoMatter => "more could not change the answer",
    }
}

/// Says at which look the ensembles ended, and why not later.
fn looked(of: &Climbed<'_>) -> String {
    let ran: Vec<&Ensemble> = of.ensembles.iter().flatten().collect();
    let Some(furthest) = ran.iter().max_by_key(|ensemble| ensemble.members) else {
        return "No ensemble was run".into();
    };
    let looks = ensemble::looks(of.policy.members).len();
    let end = if ran.iter().any(|ensemble| ensemble.ended == End::LastLook) {
        "which is the last: nothing finer was asked for"
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
fn left_out(of: &Climbed<'_>, stops: &[Step]) -> String {
    if let Err(why) = may_leave_out(of.policy, of.follow_all, of.scope) {
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

fn samples(of: &Climbed<'_>) -> u64 {
    let length = of.signal.samples.len() as u64;
    let runs: u64 = of
        .judged
        .iter()
        .map(|judged| if judged.left_out { 1 } else { 5 })
        .sum();
    let members: u64 = of
        .ensembles
        .iter()
        .flatten()
        .map(|ensemble| u64::from(ensemble.members))
        .sum();
    length * (runs + members)
}
