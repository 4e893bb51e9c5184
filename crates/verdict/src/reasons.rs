//! The reasons of a verdict, in sentences.
//!
//! Each function tells one reason, or none where the case gives no cause; `reasons` asks them in
//! the order of their weight. They share the case that they explain.

use super::decision::{
    FAIL_SHARE_MIN, FAIL_SHARE_WITH_NOMINAL, NOISE_TIMES, OPENING_DRAWS_MAX, PASS_DRAWS,
    VariantRun, unanimous,
};
use super::ensemble::bounds::members_needed;
use super::ensemble::{Ensemble, Varied};
use super::faults::Faults;
use super::mechanism;
use super::opening::Opening;
use super::policy::{ModelChoice, Polarity, Policy, Variant};
use super::variant::VariantResult;
use super::what_if::{Change, ChangedSide, WhatIf};
use super::wording::{
    angle, brief_instant, degrees, degrees_at_most, instant, percent, percent_bound, place,
    sentence, signed,
};
use super::{Answer, ErrorBudget, Reason};
use crate::conditioning::Noise;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::parameters::DesignParameter;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, plain, short};
use latchgate_recording::{Finding, Severity};
use std::f64::consts::FRAC_PI_2;

/// The verdict that the sentences explain.
#[derive(Clone, Copy)]
pub(super) struct Explained<'a> {
    pub(super) answer: Answer,
    pub(super) design: &'a Design,
    pub(super) policy: &'a Policy,
    pub(super) results: &'a [VariantResult],
    /// The one with the largest peak.
    pub(super) nominal: &'a VariantResult,
    pub(super) findings: &'a [Finding],
    pub(super) faults: &'a Faults,
    /// First crossing outside the judged window [s].
    pub(super) outside: Option<f64>,
    /// The limit of work, if it was reached.
    pub(super) work_limit: Option<u64>,
    pub(super) budget: &'a ErrorBudget,
    pub(super) noise: Noise,
    pub(super) what_if: &'a [WhatIf],
    /// What differs from member to member of an ensemble; `None` where none was asked for or nothing does.
    pub(super) varied: Option<Varied>,
    /// When the lever opens; `None` of an unusable recording.
    pub(super) opens: Option<&'a Opening>,
}

impl Explained<'_> {
    fn threshold_rad(&self) -> f64 {
        self.design.criterion.threshold_rad
    }

    /// The stop and opening direction that the figures speak of: of a pass that which comes nearest to the
    /// limit angle, errors included, else the nominal one.
    fn leading(&self) -> &VariantResult {
        if self.answer != Answer::Pass {
            return self.nominal;
        }
        let highest = |result: &VariantResult| {
            result.run.run().peak_angle_rad.max(0.0) + result.run.uncertainty_rad()
        };
        let results = self.results.iter();
        let leading = results.max_by(|one, other| highest(one).total_cmp(&highest(other)));
        leading.unwrap_or(self.nominal)
    }
}

/// Returns the reasons, the weightiest first.
pub(super) fn reasons(case: &Explained<'_>) -> Vec<Reason> {
    let mut reasons = Vec::new();
    if case.answer == Answer::Unusable {
        reasons.extend(blocking(case.findings));
    }
    if case.answer == Answer::Undecided {
        // What stands in the way of an answer comes before the size of the peak.
        reasons.extend(case.work_limit.map(work_limit));
        reasons.extend(mechanism::tie(case.results));
        reasons.extend(too_few_members(case));
        reasons.extend(others_not_followed(case));
        reasons.extend(method_without_bound(case));
        reasons.extend(coast(case));
        reasons.extend(coast_of_members(case));
        reasons.extend(disagreement(case));
        reasons.extend(undeclared(case));
        reasons.extend(noise(case));
        reasons.extend(ensemble(case));
        reasons.extend(deciding_inputs(case));
    }
    // What proves a fail comes before a nominal lever that could not be followed.
    let by_members = case.answer == Answer::Fail && case.nominal.run.outcome.broke_down;
    if by_members {
        reasons.extend(ensemble(case));
    }
    // What comes of faulty samples is no event.
    if case.answer != Answer::Unusable {
        reasons.push(peak(case));
        reasons.extend(mechanism::reason(case.design, case.leading()));
    }
    if case.answer != Answer::Undecided {
        reasons.extend(others_not_followed(case));
    }
    reasons.extend(before_fault(case));
    reasons.extend(case.outside.map(|at| Reason {
        code: "crossing-outside-window".into(),
        text: format!(
            "Outside the judged window the lever opens, first at {}. This verdict is not about that.",
            instant(at)
        ),
    }));
    reasons.extend(case.faults.late.map(|at| Reason {
        code: "fault-after-window".into(),
        text: format!(
            "From {} on, after the judged window, the recording is faulty. This verdict is about the window alone.",
            instant(at)
        ),
    }));
    if !matches!(case.answer, Answer::Undecided | Answer::Unusable) {
        if !by_members {
            reasons.extend(ensemble(case));
        }
        reasons.extend(deciding_inputs(case));
        reasons.extend(coast(case));
        reasons.extend(disagreement(case));
    }
    if case.answer != Answer::Unusable {
        reasons.extend(uncertainty(case));
    }
    if case.answer != Answer::Unusable {
        reasons.extend(nothing_asked(case));
    }
    reasons
}

/// Code of the reason and the finding of a question that took more work than it may.
pub(super) const WORK_LIMIT: &str = "work-limit";

/// Says that an answer takes more work than it may.
pub(super) fn work_limit(limit: u64) -> Reason {
    Reason {
        code: WORK_LIMIT.into(),
        text: format!(
            "An answer takes more than {limit} steps, the limit `work`. Raise it: the setting `limit` = work={}. Or ask for fewer varied levers with the setting `members`.",
            limit.saturating_mul(10)
        ),
    }
}

/// Code of the reason that nothing about lever and reading was varied.
pub(super) const NOTHING_VARIED: &str = "nothing-varied";

/// Says why there is no ensemble: none was asked for, or all of its members would be alike.
fn nothing_asked(case: &Explained<'_>) -> Option<Reason> {
    let (code, text) = match (case.policy.members, case.varied) {
        (0, _) => (
            "nominal-runs-only",
            "No varied lever was asked (the setting `members` = 0). The scatter of lever, stop and sensor is not judged.",
        ),
        (_, None) => (
            NOTHING_VARIED,
            "No tolerance or input uncertainty moves it: this one lever was judged on this one reading, and no share is stated.",
        ),
        _ => return None,
    };
    Some(Reason {
        code: code.into(),
        text: text.into(),
    })
}

/// Tells whether the first reason of an undecided verdict may be one that reruns with an input
/// moved would give: no other comes before it.
pub(super) fn inputs_may_come_first(case: &Explained<'_>) -> bool {
    case.answer == Answer::Undecided && reasons(case).first() == Some(&peak(case))
}

/// Says how many of the scattered levers cross, and what that is worth.
fn ensemble(case: &Explained<'_>) -> Option<Reason> {
    let Some(nominal) = case.nominal.ensemble.as_ref() else {
        return spared(case);
    };
    // Where an answer is missing, every variant that has none is named.
    let threshold = case.threshold_rad();
    let open = |result: &&VariantResult| {
        case.answer == Answer::Undecided && result.run.answer(threshold) == Answer::Undecided
    };
    let mut named: Vec<&Ensemble> = case
        .results
        .iter()
        .filter(open)
        .filter_map(|result| result.ensemble.as_ref())
        .collect();
    if named.is_empty() {
        named.push(decisive(case).unwrap_or(nominal));
    }
    let list: Vec<String> = named
        .iter()
        .map(|ensemble| who_cross(ensemble, case.answer))
        .collect();
    let until = nominal.judged_until_s.map_or_else(String::new, |at| {
        format!(" Judged on the samples up to {}.", instant(at))
    });
    let (code, rule) = rule_of_shares(case.answer, nominal, &named);
    Some(Reason {
        code: code.into(),
        text: format!(
            "{} {rule}.{until}{}",
            list.join(" "),
            lost_to_rounding(case, &named)
        ),
    })
}

/// Returns the ensemble on which the answer hangs: of a pass the one of which most may open, else the nominal one; of
/// equal ones that of the stop whose angle is told.
fn decisive<'a>(case: &Explained<'a>) -> Option<&'a Ensemble> {
    if case.answer != Answer::Pass {
        return case.nominal.ensemble.as_ref();
    }
    let told = case.leading().variant;
    let ensembles = case
        .results
        .iter()
        .filter_map(|result| result.ensemble.as_ref());
    ensembles.max_by(|a, b| {
        let by_share = a.p_upper_with_coast.total_cmp(&b.p_upper_with_coast);
        by_share.then_with(|| (a.variant() == told).cmp(&(b.variant() == told)))
    })
}

/// Says of which of these ensembles rounding has lost the runs.
fn lost_to_rounding(case: &Explained<'_>, named: &[&Ensemble]) -> String {
    let sentences = named.iter().filter_map(|ensemble| {
        let mut results = case.results.iter();
        let result = results.find(|result| result.variant == ensemble.variant())?;
        let error_rad = result.run.run().numerical_error_rad;
        ensemble.rounding_in_words(error_rad, case.threshold_rad())
    });
    sentences.map(|sentence| format!(" {sentence}.")).collect()
}

/// Says why the levers of the ensemble were not followed.
fn spared(case: &Explained<'_>) -> Option<Reason> {
    let bound = case.nominal.counted().bound?;
    Some(Reason {
        code: "no-member-can-cross".into(),
        text: format!(
            "No {} can open the door: the worst of them {} ({}).",
            case.varied.map_or("varied lever", Varied::member),
            bound.name(),
            place(case.nominal.variant)
        ),
    })
}

/// Says how many levers of one ensemble cross, with the bound that the answer rests on.
fn who_cross(ensemble: &Ensemble, answer: Answer) -> String {
    let lost = ensemble.lost_in_words(answer);
    let lost = lost.map_or_else(String::new, |lost| format!(", {lost}"));
    format!(
        "{} open{lost}: {} ({}).",
        ensemble.who_opens(),
        ensemble.share_that_opens(answer),
        place(ensemble.variant()),
    )
}

/// Says that even if no member opened, too few were asked to show that so few open as a pass allows.
fn too_few_members(case: &Explained<'_>) -> Option<Reason> {
    let criterion = case.design.criterion;
    let needed = members_needed(criterion.open_share, criterion.confidence);
    let asked = case.policy.members;
    let threshold = case.threshold_rad();
    let waits = |result: &VariantResult| {
        result.run.answer(threshold) == Answer::Undecided
            && result.run.nominal_answer(threshold) == Answer::Pass
    };
    let is_alone = case.results.iter().any(waits);
    (case.varied.is_some() && is_alone && asked < needed).then(|| Reason {
        code: "members-too-few".into(),
        text: format!(
            "A pass allows {} %, and {asked} members cannot show so little: {needed} of which none opens can. State at least as many with the setting `members`.",
            percent(criterion.open_share)
        ),
    })
}

/// Returns the reason's code, and the rule that the shares are held against.
fn rule_of_shares(answer: Answer, own: &Ensemble, named: &[&Ensemble]) -> (&'static str, String) {
    let (pass, fail) = (percent(own.open_share), percent(FAIL_SHARE_WITH_NOMINAL));
    let nearly_all = percent(FAIL_SHARE_MIN);
    match answer {
        Answer::Pass => ("few-members-cross", format!("A pass allows {pass} %")),
        Answer::Fail if own.p_lower >= FAIL_SHARE_MIN => {
            ("most-members-cross", format!("A fail needs {nearly_all} %"))
        }
        Answer::Fail => (
            "most-members-cross",
            format!("A fail needs more than {fail} % where the nominal lever opens"),
        ),
        Answer::Undecided if named.iter().all(|ensemble| few_cross(ensemble)) => (
            "few-members-cross",
            format!("A pass allows {pass} %, which is met: other reasons keep it undecided"),
        ),
        Answer::Undecided | Answer::Unusable => (
            "members-cross",
            format!(
                "A pass allows {pass} %. A fail needs {nearly_all} %, or more than {fail} % and a nominal lever that opens"
            ),
        ),
    }
}

/// Names the noise of the recording where without it every nominal lever would be on one side of the limit, and
/// all on the same.
fn noise(case: &Explained<'_>) -> Option<Reason> {
    let threshold = case.threshold_rad();
    let quiet_answer = |result: &VariantResult| {
        let quiet = VariantRun {
            noise_rad: 0.0,
            noise_draws: None,
            ..result.run.clone()
        };
        if quiet.outcome.broke_down {
            return Answer::Undecided;
        }
        quiet.nominal_answer(threshold)
    };
    let quiet_answers: Vec<Answer> = case.results.iter().map(quiet_answer).collect();
    if unanimous(&quiet_answers) == Answer::Undecided {
        return None;
    }
    let open = |result: &&VariantResult| result.run.nominal_answer(threshold) == Answer::Undecided;
    let decided = case.results.iter().find(open)?;
    let Noise {
        deviation_m_s2,
        step_m_s2,
        ..
    } = case.noise;
    let in_g = |a: f64| plain(a / STANDARD_GRAVITY, 2);
    let (what, cure) = if case.noise.is_rounding() {
        (
            format!("The recorder's step of {} g", in_g(step_m_s2)),
            "finer recorder",
        )
    } else {
        (
            format!("The noise before contact, {} g,", in_g(deviation_m_s2)),
            "quieter channel",
        )
    };
    let run = &decided.run;
    let effect = if run.held_back_by_draws(threshold) {
        format!(
            "it opens the lever in {} of {PASS_DRAWS} draws ({}), a pass allows {OPENING_DRAWS_MAX}",
            run.opening_draws(),
            place(decided.variant)
        )
    } else {
        format!(
            "it moves the largest angle by {} (one standard deviation; {})",
            degrees(run.noise_rad, 2),
            place(decided.variant)
        )
    };
    Some(Reason {
        code: "noise-decides".into(),
        text: format!("{what} decides: {effect}. A {cure} would decide."),
    })
}

/// Names the undeclared polarity where both signs are in doubt alike.
fn undeclared(case: &Explained<'_>) -> Option<Reason> {
    let open = case.policy.polarity == Polarity::Undeclared
        && case.results.iter().any(|result| result.ensemble.is_some());
    if !open || signs_differ(case) {
        return None;
    }
    Some(Reason {
        code: "polarity-undeclared".into(),
        text: format!(
            "The opening direction is not declared: {}. State it with the setting `opens_when`.",
            each_direction(case)
        ),
    })
}

/// Names the inputs of which one standard deviation moves a nominal lever across the limit; the
/// bias comes first.
fn deciding_inputs(case: &Explained<'_>) -> Vec<Reason> {
    let moved = |what_if: &&WhatIf| !what_if.changes_side.is_empty();
    let is_bias = |what_if: &&WhatIf| what_if.input == "input.bias_g";
    let bias: Vec<String> = case
        .what_if
        .iter()
        .filter(moved)
        .filter(is_bias)
        .filter_map(|what_if| {
            let how = match what_if.how {
                Change::More => "one standard deviation more",
                Change::Less => "one standard deviation less",
                Change::BiasKept => "left in the recording",
            };
            let (side, result) = side(case, what_if)?;
            let before_rad = result.run.run().peak_angle_rad;
            let effect = match has_figure(case, result) {
                true => format!(
                    "gives {} instead of {}",
                    degrees(side.peak_angle_rad, 3),
                    degrees(before_rad, 3)
                ),
                false => format!("computes one that {}", opens_or_stays(case, side)),
            };
            Some(format!(
                "{how} ({} g) {effect} ({})",
                signed(what_if.change),
                place(side.variant()),
            ))
        })
        .collect();
    let mut reasons = Vec::new();
    if !bias.is_empty() {
        reasons.push(Reason {
            code: "bias-decides".into(),
            text: format!(
                "The bias decides whether a nominal lever opens: {}.",
                bias.join("; ")
            ),
        });
    }
    let tolerances: Vec<String> = case
        .what_if
        .iter()
        .filter(moved)
        .filter(|what_if| !is_bias(what_if))
        .filter_map(|what_if| {
            let (side, result) = side(case, what_if)?;
            let effect = match has_figure(case, result) {
                true => degrees(side.peak_angle_rad, 3),
                false => opens_or_stays(case, side).into(),
            };
            let parameter = DesignParameter::named(&what_if.input);
            let noun = parameter.map_or(&*what_if.input, |parameter| parameter.noun);
            let unit = parameter.map_or("1", |parameter| parameter.unit);
            let unit = unit.trim_matches('1').replace(' ', "·");
            let blank = if unit.is_empty() { "" } else { " " };
            Some(format!(
                "{noun} {}{blank}{unit} ({effect})",
                signed(what_if.change)
            ))
        })
        .collect();
    if !tolerances.is_empty() {
        reasons.push(Reason {
            code: "tolerance-decides".into(),
            text: format!(
                "One standard deviation of one tolerance decides whether a nominal lever opens: {}.",
                tolerances.join(", ")
            ),
        });
    }
    reasons
}

/// Returns true if the largest angle of a run has a figure: its error is smaller than itself, or keeps it below the
/// limit.
fn has_figure(case: &Explained<'_>, result: &VariantResult) -> bool {
    let peak_rad = result.run.run().peak_angle_rad;
    let error_rad = result.run.uncertainty_rad();
    1.1 * error_rad < peak_rad.abs() || peak_rad.max(0.0) + error_rad <= case.threshold_rad()
}

/// Returns the largest angle with its error of a run whose error is as large as the angle [rad].
fn upper_of_small(result: &VariantResult) -> Option<f64> {
    let peak_rad = result.run.run().peak_angle_rad;
    let error_rad = result.run.uncertainty_rad();
    (peak_rad > 0.0 && 1.1 * error_rad >= peak_rad).then_some(peak_rad + error_rad)
}

/// Names the side of the limit angle on which a moved input puts the nominal lever, as computed.
fn opens_or_stays(case: &Explained<'_>, side: ChangedSide) -> &'static str {
    match side.peak_angle_rad > case.threshold_rad() {
        true => "opens",
        false => "stays",
    }
}

/// Returns the stop and polarity that changes sides, that of the nominal run if it is among
/// them, and its result.
fn side<'a>(case: &Explained<'a>, what_if: &WhatIf) -> Option<(ChangedSide, &'a VariantResult)> {
    let side = what_if
        .changes_side
        .iter()
        .find(|side| side.variant() == case.nominal.variant)
        .or(what_if.changes_side.first())?;
    let mut results = case.results.iter();
    let result = results.find(|result| result.variant == side.variant())?;
    Some((*side, result))
}

/// One reason for each blocking finding.
fn blocking(findings: &[Finding]) -> impl Iterator<Item = Reason> + '_ {
    findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking)
        .map(|finding| Reason {
            code: finding.code.clone(),
            text: sentence(&finding.text),
        })
}

/// Says when the lever opens, and the largest angle.
fn peak(case: &Explained<'_>) -> Reason {
    let leading = case.leading();
    let run = leading.run.run();
    let largest_place = place(leading.variant);
    if case.nominal.run.outcome.broke_down {
        return not_followed(run.method.name(), &largest_place);
    }
    let largest = if run.peak_angle_rad > FRAC_PI_2 {
        format!("The largest angle is more than 90° ({largest_place})")
    } else if !has_figure(case, leading) {
        // As pages show it: an angle whose error is as large as itself has no figure.
        let what = match case.answer {
            Answer::Fail => "How far it opens",
            _ => "Whether it opens",
        };
        format!("{what} cannot be computed ({largest_place})")
    } else if let Some(upper_rad) = upper_of_small(leading) {
        // An error as large as the angle leaves it two digits and an upper bound.
        format!(
            "The largest angle is {}, with its error at most {}, at {} ({largest_place})",
            degrees(run.peak_angle_rad, 2),
            degrees_at_most(upper_rad),
            brief_instant(run.peak_time_s),
        )
    } else {
        let ratio = run.peak_angle_rad / case.threshold_rad();
        let share = if ratio > 1.0 {
            format!("{} times", short(ratio, 2))
        } else {
            format!("{} % of", short(100.0 * ratio, 3))
        };
        format!(
            "The largest angle is {} at {} ({largest_place}), {share} the limit angle",
            angle(run.peak_angle_rad, 3),
            brief_instant(run.peak_time_s),
        )
    };
    let first = case.opens.filter(|opens| opens.first_s.is_some());
    let (code, text) = if let Some(opens) = first {
        let opening_place = place(Variant {
            model: opens.model,
            opens_when: opens.opens_when,
        });
        let instant = brief_instant(opens.first_s.unwrap_or(f64::NAN));
        let verb = match case.answer {
            Answer::Fail => "opens",
            _ => "may open",
        };
        (
            "threshold-crossed",
            format!("The nominal lever {verb} first at {instant} ({opening_place}). {largest}."),
        )
    } else if run.peak_angle_rad > 0.0 {
        (
            "threshold-not-crossed",
            format!("{largest}.{}", coast_words(run.coast_peak_angle_rad)),
        )
    } else {
        (
            "never-released",
            format!(
                "The lever never leaves its stop ({largest_place}).{}",
                coast_words(run.coast_peak_angle_rad)
            ),
        )
    };
    Reason {
        code: code.into(),
        text,
    }
}

fn not_followed(method: &str, places: &str) -> Reason {
    Reason {
        code: "method-broke-down".into(),
        text: format!(
            "The {method} method could not follow the lever ({places}). Its figures mean nothing."
        ),
    }
}

/// Names the stops and polarities beside that of the nominal run which could not be followed.
fn others_not_followed(case: &Explained<'_>) -> Option<Reason> {
    let lost: Vec<&VariantResult> = case
        .results
        .iter()
        .filter(|result| result.run.outcome.broke_down && result.variant != case.nominal.variant)
        .collect();
    let first = lost.first()?;
    let places: Vec<String> = lost.iter().map(|result| place(result.variant)).collect();
    Some(not_followed(
        first.run.run().method.name(),
        &places.join("; "),
    ))
}

/// Says that only the method stands in the way of a pass.
fn method_without_bound(case: &Explained<'_>) -> Option<Reason> {
    let threshold = case.threshold_rad();
    let mut results = case.results.iter();
    let result = results.find(|result| result.run.held_back_by_method(threshold))?;
    Some(Reason {
        code: "method-without-bound".into(),
        text: format!(
            "The {} method only estimates its error, so it decides no pass. Leave out the setting `method`.",
            result.run.run().method.name()
        ),
    })
}

fn coast_words(coast: Option<f64>) -> String {
    coast.map_or_else(String::new, |coast| {
        format!(
            " After the last judged sample it still reaches {}.",
            angle(coast, 3)
        )
    })
}

/// Says what the samples before a fault give: the fail that they decide, or the direction that would fail.
fn before_fault(case: &Explained<'_>) -> Option<Reason> {
    let bad = case.faults.first_bad.filter(|bad| bad.is_finite())?;
    let bad = instant(bad);
    let text = match case.answer {
        Answer::Fail => {
            let reach = case.faults.reach_s;
            let mixed = if reach > 0.0 {
                let reach = instant(reach);
                format!(" The filter mixes faulty samples into the last {reach} before.")
            } else {
                String::new()
            };
            format!(
                "From {bad} on the recording is faulty. The samples before give fail.{mixed} Figures of later instants rest on faulty samples."
            )
        }
        Answer::Unusable => {
            let failing = case.policy.polarity.signs().iter().find(|sign| {
                let mut of_sign = case
                    .results
                    .iter()
                    .filter(|result| result.variant.opens_when == **sign)
                    .map(|result| result.before_fault.as_ref());
                of_sign.all(|run| {
                    run.is_some_and(|run| run.answer(case.threshold_rad()) == Answer::Fail)
                })
            })?;
            format!(
                "If {} acceleration opens, the samples before {bad} give fail. State the opening direction with the setting `opens_when`.",
                failing.name()
            )
        }
        Answer::Pass | Answer::Undecided => return None,
    };
    Some(Reason {
        code: "failed-before-fault".into(),
        text,
    })
}

/// Says that a lever which stayed below the limit may reach it after the last judged sample.
fn coast(case: &Explained<'_>) -> Option<Reason> {
    let threshold = case.threshold_rad();
    let mut results = case.results.iter();
    let result = results.find(|result| result.run.held_back_by_coast(threshold))?;
    Some(Reason {
        code: "coast-reaches-limit".into(),
        text: format!(
            "After the last judged sample the lever still reaches {} ± {} ({}). The record or window ends too early for a pass.",
            angle(result.run.run().coast_peak_angle_rad.unwrap_or(0.0), 3),
            degrees(result.run.coast_uncertainty_rad(), 2),
            place(result.variant),
        ),
    })
}

/// Tells whether few enough members cross for a pass, in window and coast.
fn few_cross(ensemble: &Ensemble) -> bool {
    ensemble.p_upper_with_coast <= ensemble.open_share
}

/// Says that scattered levers which stayed below the limit in the window reach it afterwards.
fn coast_of_members(case: &Explained<'_>) -> Option<Reason> {
    let ensemble = case
        .results
        .iter()
        .filter_map(|result| result.ensemble.as_ref())
        .find(|ensemble| ensemble.p_upper <= ensemble.open_share && !few_cross(ensemble))?;
    Some(Reason {
        code: "members-coast-beyond".into(),
        text: format!(
            "After the last judged sample {} of {} {} open. Up to {} % of all open in the end, and a pass allows {} % ({}). The record or window ends too early for a pass.",
            ensemble.exceeded_in_coast,
            ensemble.members,
            ensemble.varied.members(),
            percent_bound(ensemble.p_upper_with_coast, f64::ceil),
            percent(ensemble.open_share),
            place(ensemble.variant()),
        ),
    })
}

/// Returns the answer of each stop, in one list.
fn each_stop(case: &Explained<'_>) -> String {
    let answers = case.results.iter().map(|result| {
        let answer = result.run.answer(case.threshold_rad()).name();
        format!("{}: {answer}", place(result.variant))
    });
    answers.collect::<Vec<_>>().join("; ")
}

/// Returns the answer of each opening direction, in one list.
fn each_direction(case: &Explained<'_>) -> String {
    let signs = case.policy.polarity.signs().iter();
    let answers = signs.map(|sign| {
        let answer = unanimous(&of_sign(case, *sign)).name();
        format!("{answer} if {} acceleration opens", sign.name())
    });
    answers.collect::<Vec<_>>().join(", ")
}

/// Returns what the stops say of one polarity.
fn of_sign(case: &Explained<'_>, sign: OpensWhen) -> Vec<Answer> {
    case.results
        .iter()
        .filter(|result| result.variant.opens_when == sign)
        .map(|result| result.run.answer(case.threshold_rad()))
        .collect()
}

fn signs_differ(case: &Explained<'_>) -> bool {
    match case.policy.polarity.signs() {
        [first, second] => of_sign(case, *first) != of_sign(case, *second),
        _ => false,
    }
}

/// Says which stops or polarities answer differently.
fn disagreement(case: &Explained<'_>) -> Vec<Reason> {
    // A stop that is undecided by itself does not differ by being another stop.
    let stops_differ = case.policy.polarity.signs().iter().any(|sign| {
        let answers = of_sign(case, *sign);
        answers.contains(&Answer::Pass) && answers.contains(&Answer::Fail)
    });
    let signs_differ = signs_differ(case);
    let mut reasons = Vec::new();
    if signs_differ {
        let text = match case.policy.polarity {
            Polarity::Both => format!(
                "The opening directions answer differently, and the worse counts: {}.",
                each_direction(case)
            ),
            _ => format!(
                "The opening direction is not declared, and it decides: {}. State it with the setting `opens_when`.",
                each_direction(case)
            ),
        };
        reasons.push(Reason {
            code: "polarity-decides".into(),
            text,
        });
    }
    if stops_differ && case.policy.model == ModelChoice::Auto && !signs_differ {
        reasons.push(Reason {
            code: "stop-model-decides".into(),
            text: format!("The two stops answer differently: {}.", each_stop(case)),
        });
    } else if stops_differ && signs_differ {
        reasons.push(Reason {
            code: "stop-model-decides".into(),
            text: "The two stops answer differently as well.".into(),
        });
    }
    reasons
}

/// Compares the error of the largest angle with its distance to the limit angle, and names the largest
/// influence that the rule does not count.
fn uncertainty(case: &Explained<'_>) -> Option<Reason> {
    let nominal = &case.leading().run;
    if nominal.outcome.broke_down {
        return None;
    }
    let run = nominal.run();
    let total = nominal.uncertainty_rad();
    let distance = (run.peak_angle_rad - case.threshold_rad()).abs();
    let spans = distance <= total;
    let code = if spans {
        "uncertainty-spans-threshold"
    } else {
        "uncertainty"
    };
    let stays = run.peak_angle_rad + total <= case.threshold_rad();
    let text = if total < run.peak_angle_rad || stays {
        let less = if spans { "not less" } else { "less" };
        // Beyond 90° the largest angle has no figure, and so the distance has none.
        let to_limit = if run.peak_angle_rad > FRAC_PI_2 {
            "its distance to the limit angle".to_string()
        } else {
            format!("the {} to the limit angle", degrees(distance, 3))
        };
        let influence = case.budget.ranked().into_iter().find(|(name, value)| {
            let counted = matches!(
                *name,
                "numerical" | "interpolation" | "noise" | "noise_97_5"
            );
            !counted && *value > 0.0
        });
        let influence = influence.map_or_else(String::new, |(name, value)| {
            format!(
                " The largest influence not included is {}: {}.",
                influence_name(name),
                degrees(value, 2)
            )
        });
        let noise_is = if nominal.noise_error_rad() > NOISE_TIMES * nominal.noise_rad {
            "97.5 % of draws"
        } else {
            "two standard deviations"
        };
        format!(
            "The error of the largest angle is ±{}, {less} than {to_limit}. Its parts: integration {}, between samples {}, noise {} ({noise_is}).{influence}",
            degrees(total, 2),
            degrees(run.numerical_error_rad, 2),
            degrees(nominal.interpolation_error_rad, 2),
            degrees(nominal.noise_error_rad(), 2),
        )
    } else if case.answer == Answer::Fail {
        "How far the lever opens cannot be computed: impacts let the smallest differences grow. That it opens can.".into()
    } else {
        "Whether the lever opens cannot be computed: impacts let the smallest differences grow beyond the largest angle.".into()
    };
    Some(Reason {
        code: code.into(),
        text,
    })
}

fn influence_name(name: &str) -> &str {
    match name {
        "model" => "the stop (rigid against soft)",
        "filter" => "the filter (as chosen against none)",
        "bias" => "the bias (one standard error)",
        "polarity" => "the opening direction (reversed)",
        other => other,
    }
}
