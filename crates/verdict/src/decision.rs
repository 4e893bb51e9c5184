//! The decision rule: what one run says, and what several say together.

use super::ensemble::bounds::LOOKS;
use super::policy::{Polarity, Variant};
use super::wording::percent;
use super::{Answer, ErrorBudget, RunAnswer};
use latchgate_kernel::model::criterion::Criterion;
use latchgate_kernel::replay::{Run, RunOutcome};
use latchgate_kernel::units::{OpensWhen, short};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Returns the rule in words, as every verdict and report that rests on an ensemble states it.
pub fn decision_rule(criterion: &Criterion) -> String {
    let (pass, nearly_all) = (percent(criterion.open_share), percent(FAIL_SHARE_MIN));
    let fail_share_with_nominal = percent(FAIL_SHARE_WITH_NOMINAL);
    let (looks, count) = (looks_in_words(u32::to_string), LOOKS.len());
    let error = short(1.0 - criterion.confidence, 4);
    format!(
        "U = numerical + interpolation error + noise (the larger of twice its standard deviation and the 97.5 % quantile of what its draws change); p = the share of levers and readings, scattered as design and input are uncertain, whose peak exceeds the threshold. \
{BEFORE_THE_RUNS}\
(3) Otherwise, for each stop and polarity that counts, by the nominal run and an ensemble, which is looked at after {looks} members (or at the setting `members`) with one-sided Clopper-Pearson bounds of p, each at confidence 1 - {error}/{count}; members that could not be followed count against either answer: \
pass, if the upper bound of p, those that exceed the threshold only in the coast after the last judged sample counted as well, is at most {pass} % and the nominal peak angle plus U and the nominal coast's peak angle plus its own error, never less than U, are at or below the threshold, and at most {OPENING_DRAWS_MAX} of {PASS_DRAWS} draws of the recorded noise opens the lever, unless the method states no error that can be trusted; \
fail, if the lower bound of p is at least {nearly_all} %, or the nominal peak angle minus U exceeds the threshold and the lower bound of p exceeds {fail_share_with_nominal} %; \
undecided, if neither holds at the last look, or earlier where the nominal run forbids a pass and the upper bound of p is below what a fail needs. \
{JOINED}"
    )
}

/// The rule in words where only nominal runs are judged.
pub static NOMINAL_DECISION_RULE: LazyLock<String> = LazyLock::new(|| {
    format!(
        "Nominal runs alone (as with the setting `members` = 0, or where nothing varies). U = numerical + interpolation error + noise (the larger of twice its standard deviation and the 97.5 % quantile of what its draws change). \
{BEFORE_THE_RUNS}\
(3) Otherwise, for each stop and polarity that counts: pass if the peak angle plus U and the coast's peak angle plus its own error, never less than U, are at or below the threshold, and at most {OPENING_DRAWS_MAX} of {PASS_DRAWS} draws of the recorded noise opens the lever, unless the method states no error that can be trusted; \
fail if the peak angle minus U exceeds the threshold; else undecided. \
{JOINED}"
    )
});

/// Parts 1 and 2 of the rule.
const BEFORE_THE_RUNS: &str = "(1) fail, if the runs say so by (3) on the samples before the first that a blocking finding declares bad. \
(2) Otherwise unusable, if any finding is blocking; one that begins after the judged window, and further away than the filter reaches, does not count. ";

/// Parts 4 and 5 of the rule.
const JOINED: &str = "(4) Two stops (model auto) or two undeclared polarities that answer differently: undecided; polarities declared as both: the worse counts. (5) A pass is undecided while a finding asks for a person's word.";

/// Lists the looks: "128, 512, 2048 and 10000", each number as `written`.
pub fn looks_in_words(written: impl Fn(&u32) -> String) -> String {
    let words: Vec<String> = LOOKS.iter().map(written).collect();
    match words.split_last() {
        Some((last, before)) => format!("{} and {last}", before.join(", ")),
        None => String::new(),
    }
}

/// Least share that fails whatever the nominal run says [-], as the lower bound has it.
pub const FAIL_SHARE_MIN: f64 = 0.95;

/// Share beyond which a nominal run that fails does fail [-], as the lower bound has it.
pub const FAIL_SHARE_WITH_NOMINAL: f64 = 0.5;

/// Standard deviations of the peak from noise that U counts.
pub const NOISE_TIMES: f64 = 2.0;

/// Part of the limit angle from which on the error that a run states of itself is told, and looked at twice.
pub(crate) const ROUNDING_PART: f64 = 0.01;

/// Draws of the recorded noise under which a run that could pass is replayed.
pub const PASS_DRAWS: u32 = 128;

/// Draws of the recorded noise, of [`PASS_DRAWS`], that a pass lets open.
pub const OPENING_DRAWS_MAX: u32 = 1;

/// Bounds of the share of an ensemble that exceeds the threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShareBounds {
    /// Lower bound [-].
    pub lower: f64,
    /// Upper bound [-].
    pub upper: f64,
    /// Upper bound of the share that exceeds it in the judged window or coasting after it [-].
    pub upper_with_coast: f64,
    /// Share that a pass allows [-].
    pub allowed: f64,
}

impl ShareBounds {
    /// Those of an ensemble none of whose levers crosses.
    pub const NONE_CROSSES: Self = Self {
        lower: 0.0,
        upper: 0.0,
        upper_with_coast: 0.0,
        allowed: 0.0,
    };

    /// Those of an ensemble all of whose levers cross.
    pub const ALL_CROSS: Self = Self {
        lower: 1.0,
        upper: 1.0,
        upper_with_coast: 1.0,
        allowed: 0.0,
    };

    /// Those of which nothing is known.
    pub const UNKNOWN: Self = Self {
        lower: 0.0,
        upper: 1.0,
        upper_with_coast: 1.0,
        allowed: 0.0,
    };
}

/// Replays of a run under draws of the recorded noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseDraws {
    /// Draws whose largest angle of window and coast exceeds the limit, or that could not be followed.
    pub opening: u32,
    /// The 97.5 % quantile of the change of peak or coast's peak [rad].
    pub quantile_rad: f64,
}

/// The peaks of a nominal run with their errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakEstimate {
    /// Largest angle in the window [rad].
    pub peak_angle_rad: f64,
    /// U of the peak [rad].
    pub uncertainty_rad: f64,
    /// Largest angle after the window, its error on top [rad]; `None` without a coast.
    pub coast_at_most_rad: Option<f64>,
    /// The method could follow the lever: else the numbers above mean nothing.
    pub followed: bool,
    /// The method bounds its error; one that only estimates it decides no pass.
    pub bounded: bool,
    /// Draws of the recorded noise under which the lever opens; 0 where nothing was drawn.
    pub opening_draws: u32,
}

impl PeakEstimate {
    fn stays_below(&self, threshold_rad: f64) -> bool {
        self.followed && self.peak_angle_rad + self.uncertainty_rad <= threshold_rad
    }

    fn coast_stays_below(&self, threshold_rad: f64) -> bool {
        self.coast_at_most_rad
            .is_none_or(|coast| coast <= threshold_rad)
    }

    fn exceeds(&self, threshold_rad: f64) -> bool {
        self.followed && self.peak_angle_rad - self.uncertainty_rad > threshold_rad
    }
}

/// Returns what one stop and polarity says by part 3 of the rule; without `share` by the nominal
/// run alone. At a look that is not the last, undecided means that the next one follows.
pub fn decide(estimate: &PeakEstimate, threshold_rad: f64, share: Option<ShareBounds>) -> Answer {
    let few_exceed = share.is_none_or(|share| share.upper_with_coast <= share.allowed);
    let most_exceed = share.is_none_or(|share| share.lower > FAIL_SHARE_WITH_NOMINAL);
    let nearly_all_exceed = share.is_some_and(|share| share.lower >= FAIL_SHARE_MIN);
    if few_exceed
        && estimate.bounded
        && estimate.stays_below(threshold_rad)
        && estimate.coast_stays_below(threshold_rad)
        && estimate.opening_draws <= OPENING_DRAWS_MAX
    {
        Answer::Pass
    } else if nearly_all_exceed || (most_exceed && estimate.exceeds(threshold_rad)) {
        Answer::Fail
    } else {
        Answer::Undecided
    }
}

/// Returns the answers that part 3 of the rule may still give where the share ends between `fewest` and
/// `most`: [`decide`] asked at both ends, since a larger share never passes and a smaller one never fails.
pub fn reachable(
    estimate: &PeakEstimate,
    threshold_rad: f64,
    fewest: ShareBounds,
    most: ShareBounds,
) -> Vec<Answer> {
    let mut answers = vec![Answer::Undecided];
    if decide(estimate, threshold_rad, Some(fewest)) == Answer::Pass {
        answers.push(Answer::Pass);
    }
    if decide(estimate, threshold_rad, Some(most)) == Answer::Fail {
        answers.push(Answer::Fail);
    }
    answers
}

/// Returns whether further members are not worth their time: whatever their share, the run makes no pass, and the
/// share so far is below what a fail needs, by its upper bound.
pub fn awaits_nothing(estimate: &PeakEstimate, threshold_rad: f64, share: ShareBounds) -> bool {
    let fail_share = match estimate.exceeds(threshold_rad) {
        true => FAIL_SHARE_WITH_NOMINAL,
        false => FAIL_SHARE_MIN,
    };
    let best = Some(ShareBounds::NONE_CROSSES);
    decide(estimate, threshold_rad, best) != Answer::Pass && share.upper < fail_share
}

/// What shows that no scattered lever comes to the limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bound {
    /// The acceleration never reaches T0/(m L) in the opening direction: the lever stays on its rigid
    /// stop.
    NeverLifts,
    /// Energy and impulse are too small for the limit.
    CannotReach,
}

impl Bound {
    /// Returns the words that verdicts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::NeverLifts => "never lifts",
            Self::CannotReach => "cannot reach the limit",
        }
    }
}

/// The nominal run of one variant, with its error and the share of scattered levers that cross.
#[derive(Debug, Clone, PartialEq)]
pub struct VariantRun {
    /// The nominal run.
    pub outcome: RunOutcome,
    /// What lies between samples and is not known, of peak and coast peak [rad].
    pub interpolation_error_rad: f64,
    /// Standard deviation of peak and coast peak from the noise of the recording [rad].
    pub noise_rad: f64,
    /// Replays under draws of that noise; `None` where it has none, or the run could not pass.
    pub noise_draws: Option<NoiseDraws>,
    /// What an ensemble adds; `None` where the nominal run alone is judged.
    pub share: Option<ShareBounds>,
    /// The bound that spares its ensemble, from which the share follows.
    pub bound: Option<Bound>,
}

impl VariantRun {
    /// Returns the variant that was run.
    pub fn variant(&self) -> Variant {
        let Run {
            opens_when, model, ..
        } = self.outcome.run;
        Variant { opens_when, model }
    }

    /// Returns the run.
    pub fn run(&self) -> &Run {
        &self.outcome.run
    }

    /// Returns U, numerical plus interpolation error plus what noise does [rad].
    pub fn uncertainty_rad(&self) -> f64 {
        self.run().numerical_error_rad + self.of_recording_rad()
    }

    /// Returns the part of U that the recording leaves [rad].
    fn of_recording_rad(&self) -> f64 {
        self.interpolation_error_rad + self.noise_error_rad()
    }

    /// Returns the part of U that noise has: twice its standard deviation, and at least the 97.5 % quantile of what
    /// its draws change [rad].
    pub fn noise_error_rad(&self) -> f64 {
        let drawn = self.noise_draws.map_or(0.0, |draws| draws.quantile_rad);
        (NOISE_TIMES * self.noise_rad).max(drawn)
    }

    /// Returns the draws of the recorded noise under which the lever opens.
    pub(super) fn opening_draws(&self) -> u32 {
        self.noise_draws.map_or(0, |draws| draws.opening)
    }

    /// Returns whether nothing but the draws of the recorded noise that open forbids the nominal run to pass.
    pub(super) fn held_back_by_draws(&self, threshold_rad: f64) -> bool {
        let estimate = self.estimate();
        let undrawn = PeakEstimate {
            opening_draws: 0,
            ..estimate
        };
        decide(&estimate, threshold_rad, None) != Answer::Pass
            && decide(&undrawn, threshold_rad, None) == Answer::Pass
    }

    /// Returns the error of the coast's peak [rad], never less than U.
    pub fn coast_uncertainty_rad(&self) -> f64 {
        self.uncertainty_rad()
            .max(self.outcome.coast_error_rad + self.of_recording_rad())
    }

    /// Returns what this run says by part 3 of the rule, with the errors it says it with.
    pub fn stated(&self, threshold_rad: f64) -> RunAnswer {
        // An error as large as no number can be is that of a run that was not followed.
        let measured = !self.outcome.broke_down;
        let followed = |error: f64| (measured && error < f64::MAX).then_some(error);
        let run = self.run();
        RunAnswer {
            model: run.model,
            opens_when: run.opens_when,
            answer: self.answer(threshold_rad),
            interpolation_error_rad: followed(self.interpolation_error_rad),
            noise_rad: followed(self.noise_rad),
            noise_97_5_rad: self
                .noise_draws
                .and_then(|draws| followed(draws.quantile_rad)),
            opening_draws: self.noise_draws.map(|draws| draws.opening),
            uncertainty_rad: followed(self.uncertainty_rad()),
            coast_uncertainty_rad: run
                .coast_peak_angle_rad
                .and_then(|_| followed(self.coast_uncertainty_rad())),
            bound: self.bound,
        }
    }

    /// Returns the peaks with their errors.
    pub fn estimate(&self) -> PeakEstimate {
        let run = self.run();
        PeakEstimate {
            peak_angle_rad: run.peak_angle_rad,
            uncertainty_rad: self.uncertainty_rad(),
            coast_at_most_rad: run
                .coast_peak_angle_rad
                .map(|coast| coast + self.coast_uncertainty_rad()),
            followed: !self.outcome.broke_down,
            bounded: run.error.is_bound(),
            opening_draws: self.opening_draws(),
        }
    }

    /// Returns whether nothing but the method, which states no error that can be trusted, forbids
    /// the nominal run to pass.
    pub fn held_back_by_method(&self, threshold_rad: f64) -> bool {
        let estimate = self.estimate();
        !estimate.bounded
            && estimate.stays_below(threshold_rad)
            && estimate.coast_stays_below(threshold_rad)
    }

    /// Returns whether only the motion after the last judged sample forbids the nominal run to
    /// pass.
    pub fn held_back_by_coast(&self, threshold_rad: f64) -> bool {
        let estimate = self.estimate();
        estimate.stays_below(threshold_rad) && !estimate.coast_stays_below(threshold_rad)
    }

    /// Returns what this stop and polarity says by part 3 of the rule.
    pub fn answer(&self, threshold_rad: f64) -> Answer {
        decide(&self.estimate(), threshold_rad, self.share)
    }

    /// Returns what the nominal run alone says.
    pub fn nominal_answer(&self, threshold_rad: f64) -> Answer {
        decide(&self.estimate(), threshold_rad, None)
    }
}

/// Joins the answers of variants by part 4 of the rule; no answers, no pass.
pub(super) fn combine(polarity: Polarity, answers: &[(OpensWhen, Answer)]) -> Answer {
    let per_sign: Vec<Answer> = polarity
        .signs()
        .iter()
        .map(|sign| {
            let of_sign = answers.iter().filter(|(opens_when, _)| opens_when == sign);
            unanimous(&of_sign.map(|(_, answer)| *answer).collect::<Vec<_>>())
        })
        .collect();
    match polarity {
        Polarity::Both => worse(&per_sign),
        Polarity::Declared(_) | Polarity::Undeclared => unanimous(&per_sign),
    }
}

/// Returns whether every answer that the open variants may still give leads to one; each variant
/// stands with its answer, `None` while it is open.
pub(super) fn settled<'a>(
    polarity: Polarity,
    variants: impl IntoIterator<Item = (&'a VariantRun, Option<Answer>)>,
    threshold_rad: f64,
) -> bool {
    let mut joined: Vec<Vec<(OpensWhen, Answer)>> = vec![Vec::new()];
    for (run, answer) in variants {
        let (none_cross, all_cross) = (ShareBounds::NONE_CROSSES, ShareBounds::ALL_CROSS);
        let possible = match answer {
            Some(answer) => vec![answer],
            None => reachable(&run.estimate(), threshold_rad, none_cross, all_cross),
        };
        let sign = run.variant().opens_when;
        // At most four variants of three answers.
        joined = joined
            .iter()
            .flat_map(|before| {
                let with = |answer: &Answer| [before.as_slice(), &[(sign, *answer)]].concat();
                possible.iter().map(with)
            })
            .collect();
    }
    let mut outcomes = joined.iter().map(|answers| combine(polarity, answers));
    let first = outcomes.next();
    outcomes.all(|outcome| Some(outcome) == first)
}

/// Joins the answers of stops, or of undeclared polarities: one answer if all agree.
pub fn unanimous(answers: &[Answer]) -> Answer {
    match answers {
        [] => Answer::Undecided,
        [first, rest @ ..] if rest.iter().all(|answer| answer == first) => *first,
        _ => Answer::Undecided,
    }
}

/// Joins the answers of polarities that were declared as both: the worse counts.
pub fn worse(answers: &[Answer]) -> Answer {
    [Answer::Fail, Answer::Undecided]
        .into_iter()
        .find(|answer| answers.contains(answer))
        .unwrap_or_else(|| unanimous(answers))
}

impl ErrorBudget {
    /// Returns the parts with their names, the largest first; parts not measured are left out.
    pub fn ranked(&self) -> Vec<(&'static str, f64)> {
        let mut parts: Vec<(&'static str, f64)> = [
            ("numerical", self.numerical),
            ("interpolation", self.interpolation),
            ("noise", self.noise),
            ("noise_97_5", self.noise_97_5),
            ("model", self.model),
            ("filter", self.filter),
            ("bias", self.bias),
            ("polarity", self.polarity),
        ]
        .into_iter()
        .filter_map(|(name, value)| value.map(|value| (name, value)))
        .collect();
        parts.sort_by(|a, b| b.1.total_cmp(&a.1));
        parts
    }
}
