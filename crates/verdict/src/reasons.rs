//! The reasons of a verdict, in sentences.
//!
//! Each function tells one reason, or none where the case gives no cause; `reasons` asks them in
//! the order of their weight. They share the case that they explain.

use super::decision::{
    FAIL_SHARE_MIN, FAIL_SHARE_WITH_NOMINAL, NOISE_TIMES, PASS_SHARE_MAX, VariantRun,
};
use super::ensemble::Ensemble;
use super::faults::Faults;
use super::policy::{ModelChoice, Polarity, Policy};
use super::variant::VariantResult;
use super::what_if::{Change, ChangedSide, WhatIf};
use super::wording::{angle, angle_error, briefly, describe, instant, percent, sentence, signed};
use super::{Answer, ErrorBudget, Reason};
use crate::conditioning::Noise;
use latchgate_kernel::model::Design;
use latchgate_kernel::replay::Run;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, plain};
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
}

impl Explained<'_> {
    fn threshold_rad(&self) -> f64 {
        self.design.criterion.threshold_rad
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
        reasons.extend(case.work_limit.map(|limit| Reason {
            code: "work-limit".into(),
            text: format!(
                "An answer would take more than {limit} steps, the limit `work`. Ask for fewer levers with the setting `members`, or raise it with the setting `limit` = work={}.",
                limit.saturating_mul(10)
            ),
        }));
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
    reasons.push(peak(case));
    if case.answer != Answer::Undecided {
        reasons.extend(others_not_followed(case));
    }
    reasons.extend(before_fault(case));
    reasons.extend(case.outside.map(|at| Reason {
        code: "crossing-outside-window".into(),
        text: format!(
            "Outside the judged window the lever crosses the limit, first at {}: this verdict is not about that.",
            instant(at)
        ),
    }));
    reasons.extend(case.faults.late.map(|at| Reason {
        code: "fault-after-window".into(),
        text: format!(
            "From {} on, after the judged window, the recording is faulty: this verdict is not about what follows the window.",
            instant(at)
        ),
    }));
    if case.answer != Answer::Undecided {
        if !by_members {
            reasons.extend(ensemble(case));
        }
        reasons.extend(deciding_inputs(case));
    }
    if case.answer != Answer::Unusable {
        if case.answer != Answer::Undecided {
            reasons.extend(coast(case));
        }
        if case.answer != Answer::Undecided {
            reasons.extend(disagreement(case));
        }
        reasons.extend(uncertainty(case));
    }
    if case.policy.members == 0 {
        reasons.push(Reason {
            code: "nominal-runs-only".into(),
            text: "Only nominal runs were judged, as with the setting `members` = 0: the scatter of lever, stop and sensor is not part of this verdict.".into(),
        });
    }
    reasons
}

/// Tells whether the first reason of an undecided verdict may be one that reruns with an input
/// moved would give: no other comes before it.
pub(super) fn inputs_may_come_first(case: &Explained<'_>) -> bool {
    case.answer == Answer::Undecided && reasons(case).first() == Some(&peak(case))
}

/// Says how many of the scattered levers cross, and what that is worth.
fn ensemble(case: &Explained<'_>) -> Option<Reason> {
    let Some(own) = case.nominal.ensemble.as_ref() else {
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
        named.push(own);
    }
    let list: Vec<String> = named
        .iter()
        .map(|ensemble| who_cross(ensemble, case.answer))
        .collect();
    let until = own.judged_until_s.map_or_else(String::new, |at| {
        format!(" on the samples up to {}", instant(at))
    });
    let (code, rule) = rule_of_shares(case.answer, own, &named);
    Some(Reason {
        code: code.into(),
        text: format!(
            "Scattered as design and input are uncertain, the limit is crossed{until} by {}; {rule}.",
            list.join("; by ")
        ),
    })
}

/// Says why the levers of the ensemble were not followed.
fn spared(case: &Explained<'_>) -> Option<Reason> {
    let bound = case.nominal.counted().bound?;
    Some(Reason {
        code: "no-member-can-cross".into(),
        text: format!(
            "Scattered as design and input are uncertain, no lever can cross the limit: the loosest of them {} ({}).",
            bound.name(),
            briefly(case.nominal.variant)
        ),
    })
}

/// Says how many levers of one ensemble cross, with the bound that the answer rests on.
fn who_cross(ensemble: &Ensemble, answer: Answer) -> String {
    let lost = match ensemble.failed_to_run {
        0 => String::new(),
        lost => format!(", {lost} not followed"),
    };
    let (lower, upper) = (percent(ensemble.p_lower), percent(ensemble.p_upper));
    let share = match answer {
        Answer::Pass => format!("at most {upper} %"),
        Answer::Fail => format!("at least {lower} %"),
        Answer::Undecided | Answer::Unusable => format!("{lower} to {upper} %"),
    };
    format!(
        "{} of {} levers{lost}, {share} of all such ({})",
        ensemble.exceeded,
        ensemble.members,
        briefly(ensemble.variant()),
    )
}

/// Returns the reason's code, and the rule that the shares are held against.
fn rule_of_shares(answer: Answer, own: &Ensemble, named: &[&Ensemble]) -> (&'static str, String) {
    let (pass, fail) = (percent(PASS_SHARE_MAX), percent(FAIL_SHARE_WITH_NOMINAL));
    let nearly_all = percent(FAIL_SHARE_MIN);
    match answer {
        Answer::Pass => ("few-members-cross", format!("a pass allows {pass} %")),
        Answer::Fail if own.p_lower >= FAIL_SHARE_MIN => {
            ("most-members-cross", format!("a fail needs {nearly_all} %"))
        }
        Answer::Fail => (
            "most-members-cross",
            format!("a fail needs more than {fail} % if the nominal lever crosses"),
        ),
        Answer::Undecided if named.iter().all(|ensemble| few_cross(ensemble)) => (
            "few-members-cross",
            format!("a pass allows {pass} %, but that is not all it asks"),
        ),
        Answer::Undecided | Answer::Unusable => (
            "members-cross",
            format!(
                "a pass allows {pass} %, a fail needs more than {fail} % and a nominal lever that crosses, or {nearly_all} %"
            ),
        ),
    }
}

/// Names the noise of the recording where without it a nominal lever would be on one side of the limit.
fn noise(case: &Explained<'_>) -> Option<Reason> {
    let threshold = case.threshold_rad();
    let decides = |result: &&VariantResult| {
        let quiet = VariantRun {
            noise_rad: 0.0,
            ..result.run.clone()
        };
        let open = |run: &VariantRun| run.nominal_answer(threshold) == Answer::Undecided;
        !quiet.outcome.broke_down && open(&result.run) && !open(&quiet)
    };
    let decided = case.results.iter().find(decides)?;
    let Noise {
        deviation_m_s2,
        step_m_s2,
        ..
    } = case.noise;
    let in_g = |a: f64| plain(a / STANDARD_GRAVITY, 2);
    let (what, cure) = if case.noise.is_rounding() {
        (
            format!("The recorder's step of {} g", in_g(step_m_s2)),
            "a finer recorder",
        )
    } else {
        (
            format!("The noise before contact, {} g,", in_g(deviation_m_s2)),
            "a quieter channel",
        )
    };
    Some(Reason {
        code: "noise-decides".into(),
        text: format!(
            "{what} decides here: it moves the peak by {} (one standard deviation; {}). This is not decidable from this recording; {cure} would tell.",
            angle(decided.run.noise_rad, 2),
            briefly(decided.variant)
        ),
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
            "The sign that opens is not declared, and neither polarity answers by itself: {}. State it with the setting `opens_when`.",
            each(case)
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
            let (side, before) = side(case, what_if)?;
            Some(format!(
                "{how} ({} g), {} instead of {} ({})",
                signed(what_if.change),
                angle(side.peak_angle_rad, 4),
                angle(before, 4),
                briefly(side.variant()),
            ))
        })
        .collect();
    let mut reasons = Vec::new();
    if !bias.is_empty() {
        reasons.push(Reason {
            code: "bias-decides".into(),
            text: format!(
                "The bias decides on which side of the limit a nominal lever stays: {}.",
                bias.join("; ")
            ),
        });
    }
    let others: Vec<String> = case
        .what_if
        .iter()
        .filter(moved)
        .filter(|what_if| !is_bias(what_if))
        .filter_map(|what_if| {
            let (side, _) = side(case, what_if)?;
            Some(format!(
                "{} {} ({})",
                what_if.input,
                signed(what_if.change),
                angle(side.peak_angle_rad, 4)
            ))
        })
        .collect();
    if !others.is_empty() {
        reasons.push(Reason {
            code: "tolerance-decides".into(),
            text: format!(
                "One standard deviation of a single tolerance takes a nominal lever across the limit: {}.",
                others.join(", ")
            ),
        });
    }
    reasons
}

/// Returns the stop and polarity that changes sides, that of the nominal run if it is among
/// them, and its nominal peak [rad].
fn side(case: &Explained<'_>, what_if: &WhatIf) -> Option<(ChangedSide, f64)> {
    let side = what_if
        .changes_side
        .iter()
        .find(|side| side.variant() == case.nominal.variant)
        .or(what_if.changes_side.first())?;
    let mut results = case.results.iter();
    let own = results.find(|result| result.variant == side.variant())?;
    Some((*side, own.run.run().peak_angle_rad))
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

fn peak(case: &Explained<'_>) -> Reason {
    let nominal = &case.nominal.run;
    let run = nominal.run();
    let threshold = case.threshold_rad();
    let place = describe(case.nominal.variant, case.policy);
    if nominal.outcome.broke_down {
        return not_followed(run.method.name(), &place);
    }
    // What is found on faulty samples is told, but not as if it were known.
    let (lever, proviso) = if case.answer == Answer::Unusable {
        (
            "With the faulty samples taken as they are, the lever",
            "; no verdict rests on that",
        )
    } else {
        ("The lever", "")
    };
    let (code, text) = match run.first_crossing_s {
        Some(crossing) => (
            "threshold-crossed",
            format!(
                "crosses the limit of {threshold} rad at {} and reaches {}{} ({place})",
                instant(crossing),
                angle(run.peak_angle_rad, 4),
                how_far(run, threshold),
            ),
        ),
        None if run.peak_angle_rad > 0.0 => (
            "threshold-not-crossed",
            format!(
                "reaches at most {} rad, {} % of the limit of {threshold} rad, at {} ({place}){}",
                plain(run.peak_angle_rad, 4),
                plain(100.0 * run.peak_angle_rad / threshold, 3),
                instant(run.peak_time_s),
                coast_words(run.coast_peak_angle_rad),
            ),
        ),
        None => (
            "never-released",
            format!(
                "never leaves its stop ({place}){}",
                coast_words(run.coast_peak_angle_rad)
            ),
        ),
    };
    Reason {
        code: code.into(),
        text: format!("{lever} {text}{proviso}."),
    }
}

/// Returns when a lever that crossed reached its peak, and how far above the limit; nothing beyond
/// 90°, where only the crossing counts.
fn how_far(run: &Run, threshold_rad: f64) -> String {
    if run.peak_angle_rad > FRAC_PI_2 {
        return String::new();
    }
    format!(
        " at {}, {} times the limit",
        instant(run.peak_time_s),
        plain(run.peak_angle_rad / threshold_rad, 3),
    )
}

fn not_followed(method: &str, places: &str) -> Reason {
    Reason {
        code: "method-broke-down".into(),
        text: format!(
            "The {method} method could not follow the lever ({places}); its figures mean nothing."
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
    let places: Vec<String> = lost
        .iter()
        .map(|result| describe(result.variant, case.policy))
        .collect();
    Some(not_followed(
        first.run.run().method.name(),
        &places.join("; "),
    ))
}

/// Says that only the method stands in the way of a pass.
fn method_without_bound(case: &Explained<'_>) -> Option<Reason> {
    let threshold = case.threshold_rad();
    let mut results = case.results.iter();
    let held = results.find(|result| result.run.held_back_by_method(threshold))?;
    Some(Reason {
        code: "method-without-bound".into(),
        text: format!(
            "The {} method only estimates its error: it may have stepped over what opens the lever, so it decides no pass. Judge by the event-driven method.",
            held.run.run().method.name()
        ),
    })
}

fn coast_words(coast: Option<f64>) -> String {
    coast.map_or_else(String::new, |coast| {
        format!(
            "; left to itself after the last judged sample it still reaches {}",
            angle(coast, 4)
        )
    })
}

/// Says that a fault came too late to matter.
fn before_fault(case: &Explained<'_>) -> Option<Reason> {
    let bad = case
        .faults
        .first_bad
        .filter(|bad| case.answer == Answer::Fail && bad.is_finite())?;
    let reach = case.faults.reach_s;
    let mixed = if reach > 0.0 {
        format!(
            ", of which the filter mixes the last {} with faulty ones",
            instant(reach)
        )
    } else {
        String::new()
    };
    Some(Reason {
        code: "failed-before-fault".into(),
        text: format!(
            "From {} on the recording is faulty, but the samples before that alone give fail{mixed}; figures from later instants rest on faulty samples.",
            instant(bad)
        ),
    })
}

/// Says that a lever which stayed below the limit may reach it after the last judged sample.
fn coast(case: &Explained<'_>) -> Option<Reason> {
    let threshold = case.threshold_rad();
    let mut results = case.results.iter();
    let held = results.find(|result| result.run.held_back_by_coast(threshold))?;
    Some(Reason {
        code: "coast-reaches-limit".into(),
        text: format!(
            "After the last judged sample the lever moves on and reaches {}, {}, with no further acceleration ({}): the record or window ends too early for a pass.",
            angle(held.run.run().coast_peak_angle_rad.unwrap_or(0.0), 4),
            angle_error(held.run.coast_uncertainty_rad(), 2),
            describe(held.variant, case.policy),
        ),
    })
}

/// Tells whether few enough members cross for a pass, in window and coast.
fn few_cross(ensemble: &Ensemble) -> bool {
    ensemble.p_upper_with_coast <= PASS_SHARE_MAX
}

/// Says that scattered levers which stayed below the limit in the window reach it afterwards.
fn coast_of_members(case: &Explained<'_>) -> Option<Reason> {
    let ensemble = case
        .results
        .iter()
        .filter_map(|result| result.ensemble.as_ref())
        .find(|ensemble| ensemble.p_upper <= PASS_SHARE_MAX && !few_cross(ensemble))?;
    Some(Reason {
        code: "members-coast-beyond".into(),
        text: format!(
            "After the last judged sample {} of {} scattered levers move on beyond the limit with no further acceleration; with those that cross before, up to {} % of all such do, and a pass allows {} % ({}): the record or window ends too early for a pass.",
            ensemble.exceeded_in_coast,
            ensemble.members,
            percent(ensemble.p_upper_with_coast),
            percent(PASS_SHARE_MAX),
            briefly(ensemble.variant()),
        ),
    })
}

/// Returns the answer of each variant, in one list.
fn each(case: &Explained<'_>) -> String {
    let threshold = case.threshold_rad();
    let of_each = case.results.iter().map(|result| {
        let (name, run) = (briefly(result.variant), result.run.run());
        let answer = result.run.answer(threshold).name();
        if result.run.outcome.broke_down {
            return format!("{name}: {answer}, since it could not be followed");
        }
        let coast = run
            .coast_peak_angle_rad
            .filter(|_| result.run.held_back_by_coast(threshold))
            .map_or_else(String::new, |coast| {
                format!(", coasting to {}", angle(coast, 4))
            });
        let peak = angle(run.peak_angle_rad, 4);
        format!("{name}: {answer} with a peak of {peak}{coast}")
    });
    of_each.collect::<Vec<_>>().join("; ")
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
        let own = of_sign(case, *sign);
        own.contains(&Answer::Pass) && own.contains(&Answer::Fail)
    });
    let signs_differ = signs_differ(case);
    let mut reasons = Vec::new();
    if signs_differ {
        let text = match case.policy.polarity {
            Polarity::Both => format!(
                "The two polarities answer differently, and the worse counts: {}.",
                each(case)
            ),
            _ => format!(
                "The sign that opens is not declared, and the two polarities answer differently: {}. State it with the setting `opens_when`.",
                each(case)
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
            text: format!("The two stop models answer differently: {}.", each(case)),
        });
    } else if stops_differ && signs_differ {
        reasons.push(Reason {
            code: "stop-model-decides".into(),
            text: "The two stop models answer differently as well.".into(),
        });
    }
    reasons
}

/// Sets the error of the peak beside the distance from peak to limit, and names the
/// largest influence that the rule does not count.
fn uncertainty(case: &Explained<'_>) -> Option<Reason> {
    let nominal = &case.nominal.run;
    if nominal.outcome.broke_down {
        return None;
    }
    let run = nominal.run();
    let total = nominal.uncertainty_rad();
    let distance = (run.peak_angle_rad - case.threshold_rad()).abs();
    let parts = format!(
        "{} (integration {}, between samples {}, noise of the recording {})",
        angle_error(total, 2),
        angle(run.numerical_error_rad, 2),
        angle(nominal.interpolation_error_rad, 2),
        angle(NOISE_TIMES * nominal.noise_rad, 2)
    );
    let largest = case
        .budget
        .ranked()
        .into_iter()
        .find(|(name, value)| {
            !matches!(*name, "numerical" | "interpolation" | "noise") && *value > 0.0
        })
        .map_or_else(String::new, |(name, value)| {
            format!(
                " Not counted in it, the largest influence measured is {}: {}{}.",
                influence(name),
                angle(value, 2),
                if value > distance {
                    ", more than that distance"
                } else {
                    ""
                }
            )
        });
    let spans = distance <= total;
    // Beyond 90° the peak has no figure, and so the distance has none.
    let between = if run.peak_angle_rad > FRAC_PI_2 {
        "distance".to_string()
    } else {
        format!("{} rad", plain(distance, 3))
    };
    let stays = run.peak_angle_rad + total <= case.threshold_rad();
    let text = if total < run.peak_angle_rad || stays {
        let less = if spans { "no less" } else { "less" };
        format!(
            "The error of the peak, {parts}, is {less} than the {between} between peak and limit.{largest}"
        )
    } else if case.answer == Answer::Fail {
        "How far the lever opens cannot be computed, since impacts let the smallest differences grow; that it opens can.".into()
    } else {
        format!(
            "Whether the lever opens cannot be computed: impacts let the smallest differences between samples and of the noise grow beyond the peak itself.{largest}"
        )
    };
    Some(Reason {
        code: if spans {
            "uncertainty-spans-threshold".into()
        } else {
            "uncertainty".into()
        },
        text,
    })
}

fn influence(name: &str) -> &str {
    match name {
        "model" => "the stop model (rigid against soft)",
        "filter" => "the filter (as chosen against none)",
        "bias" => "the bias (one standard error more or less)",
        "polarity" => "the polarity (reversed)",
        other => other,
    }
}
