//! The reasons of a verdict, in sentences.

use super::assess::{AssessOptions, ModelChoice, Polarity};
use super::decision::Judged;
use super::{Answer, ErrorBudget, Reason};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::recording::{Finding, Severity};
use crate::units::{OpensWhen, plain};

/// What the sentences are about.
pub(super) struct Case<'a> {
    pub(super) answer: Answer,
    pub(super) design: &'a Design,
    pub(super) options: &'a AssessOptions,
    pub(super) pairs: &'a [(OpensWhen, StopModel)],
    pub(super) judged: &'a [Judged],
    pub(super) nominal: usize,
    pub(super) findings: &'a [Finding],
    pub(super) first_bad: Option<f64>,
    /// First crossing outside the judged window [s].
    pub(super) outside: Option<f64>,
    /// When the first blocking finding after the judged window begins [s].
    pub(super) late_fault: Option<f64>,
    pub(super) budget: &'a ErrorBudget,
}

/// Returns the reasons, the weightiest first.
pub(super) fn reasons(case: &Case<'_>) -> Vec<Reason> {
    let mut reasons = Vec::new();
    if case.answer == Answer::Unusable {
        reasons.extend(blocking(case.findings));
    }
    if case.answer == Answer::Undecided {
        // What stands in the way of an answer comes before the size of the peak.
        reasons.extend(disagreement(case));
    }
    reasons.push(peak(case));
    reasons.extend(before_fault(case));
    reasons.extend(case.outside.map(|at| Reason {
        code: "crossing-outside-window",
        text: format!(
            "Outside the judged window the lever crosses the limit, first at {}: this verdict is not about that.",
            instant(at)
        ),
    }));
    reasons.extend(case.late_fault.map(|at| Reason {
        code: "fault-after-window",
        text: format!(
            "From {} on, after the judged window, the recording is faulty: this verdict is not about what follows the window.",
            instant(at)
        ),
    }));
    if case.answer != Answer::Unusable {
        reasons.extend(coast(case));
        if case.answer != Answer::Undecided {
            reasons.extend(disagreement(case));
        }
        reasons.extend(uncertainty(case));
    }
    reasons.push(Reason {
        code: "nominal-runs-only",
        text: "Only nominal runs were judged, as with --members 0: the scatter of lever, stop and sensor is not part of this verdict.".into(),
    });
    reasons
}

/// One reason for each blocking finding.
fn blocking(findings: &[Finding]) -> impl Iterator<Item = Reason> + '_ {
    findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking)
        .map(|finding| Reason {
            code: finding.code,
            text: sentence(&finding.text),
        })
}

/// Makes a sentence of a finding's text: a capital first, a full stop last.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let mut sentence: String = letters
        .next()
        .map(|first| first.to_uppercase().chain(letters).collect())
        .unwrap_or_default();
    if !sentence.ends_with(['.', '!', '?']) {
        sentence.push('.');
    }
    sentence
}

/// Returns an instant with its unit: milliseconds below ten seconds, as in the report.
pub(super) fn instant(seconds: f64) -> String {
    if seconds.abs() < 10.0 {
        format!("{} ms", plain(1e3 * seconds, 5))
    } else {
        format!("{} s", plain(seconds, 7))
    }
}

fn peak(case: &Case<'_>) -> Reason {
    let judged = &case.judged[case.nominal];
    let run = judged.run();
    let threshold = case.design.criterion.threshold_rad;
    let place = describe(case.pairs[case.nominal], case.options);
    if judged.outcome.broke_down {
        return Reason {
            code: "method-broke-down",
            text: format!(
                "The {} method could not follow the lever ({place}); its figures mean nothing.",
                run.method
            ),
        };
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
                "crosses the limit of {threshold} rad at {} and reaches {} rad at {}, {} times the limit ({place})",
                instant(crossing),
                plain(run.peak_angle_rad, 4),
                instant(run.peak_time_s),
                plain(run.peak_angle_rad / threshold, 3),
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
        code,
        text: format!("{lever} {text}{proviso}."),
    }
}

fn coast_words(coast: Option<f64>) -> String {
    coast.map_or_else(String::new, |coast| {
        format!(
            "; left to itself after the last judged sample it still reaches {} rad",
            plain(coast, 4)
        )
    })
}

fn describe((sign, stop): (OpensWhen, StopModel), options: &AssessOptions) -> String {
    let word = match options.polarity {
        Polarity::Declared(_) => "opens",
        Polarity::Both | Polarity::Undeclared => "taken to open",
    };
    format!("{} stop, {} acceleration {word}", stop.name(), sign.name())
}

/// Says that a fault came too late to matter.
fn before_fault(case: &Case<'_>) -> Option<Reason> {
    let bad = case
        .first_bad
        .filter(|bad| case.answer == Answer::Fail && bad.is_finite())?;
    Some(Reason {
        code: "failed-before-fault",
        text: format!(
            "From {} on the recording is faulty, but the samples before that alone give fail; figures from later instants rest on faulty samples.",
            instant(bad)
        ),
    })
}

/// Says that a lever which stayed below the limit may reach it after the last judged sample.
fn coast(case: &Case<'_>) -> Option<Reason> {
    let threshold = case.design.criterion.threshold_rad;
    let (pair, judged) = case
        .pairs
        .iter()
        .zip(case.judged)
        .find(|(_, judged)| judged.held_back_by_coast(threshold))?;
    Some(Reason {
        code: "coast-reaches-limit",
        text: format!(
            "After the last judged sample the lever moves on and reaches {} rad, ±{} rad, with no further acceleration ({}): the record or window ends too early for a pass.",
            plain(judged.run().coast_peak_angle_rad.unwrap_or(0.0), 4),
            plain(judged.coast_uncertainty_rad(), 2),
            describe(*pair, case.options),
        ),
    })
}

/// Says which stops or polarities answer differently.
fn disagreement(case: &Case<'_>) -> Vec<Reason> {
    let threshold = case.design.criterion.threshold_rad;
    let answers: Vec<Answer> = case
        .judged
        .iter()
        .map(|judged| judged.answer(threshold))
        .collect();
    if answers.iter().all(|answer| *answer == answers[0]) {
        return Vec::new();
    }
    let list = |wanted: &dyn Fn((OpensWhen, StopModel)) -> bool| {
        case.pairs
            .iter()
            .zip(case.judged.iter().zip(&answers))
            .filter(|(pair, _)| wanted(**pair))
            .map(|((sign, stop), (judged, answer))| {
                let coast = judged
                    .run()
                    .coast_peak_angle_rad
                    .filter(|_| judged.held_back_by_coast(threshold))
                    .map_or_else(String::new, |coast| {
                        format!(", coasting to {} rad", plain(coast, 4))
                    });
                format!(
                    "{} stop, {} opens: {} with a peak of {} rad{coast}",
                    stop.name(),
                    sign.name(),
                    answer.name(),
                    plain(judged.run().peak_angle_rad, 4)
                )
            })
            .collect::<Vec<_>>()
            .join("; ")
    };
    let mut reasons = Vec::new();
    let signs = distinct(case.pairs.iter().map(|pair| pair.0));
    let stops_differ = signs.iter().any(|sign| {
        let own: Vec<Answer> = case
            .pairs
            .iter()
            .zip(&answers)
            .filter(|(pair, _)| pair.0 == *sign)
            .map(|(_, a)| *a)
            .collect();
        own.iter().any(|answer| *answer != own[0])
    });
    let per_sign = |sign: OpensWhen| -> Vec<Answer> {
        case.pairs
            .iter()
            .zip(&answers)
            .filter(|(pair, _)| pair.0 == sign)
            .map(|(_, a)| *a)
            .collect()
    };
    let signs_differ = signs.len() > 1 && per_sign(signs[0]) != per_sign(signs[1]);
    if signs_differ {
        let text = match case.options.polarity {
            Polarity::Both => format!(
                "The two polarities answer differently, and the worse counts: {}.",
                list(&|_| true)
            ),
            _ => format!(
                "The sign that opens is not declared, and the two polarities answer differently: {}. State it with --opens-when.",
                list(&|_| true)
            ),
        };
        reasons.push(Reason {
            code: "polarity-decides",
            text,
        });
    }
    if stops_differ && case.options.model == ModelChoice::Auto && !signs_differ {
        reasons.push(Reason {
            code: "stop-model-decides",
            text: format!(
                "The two stop models answer differently: {}.",
                list(&|_| true)
            ),
        });
    } else if stops_differ && signs_differ {
        reasons.push(Reason {
            code: "stop-model-decides",
            text: "The two stop models answer differently as well.".into(),
        });
    }
    reasons
}

fn distinct(signs: impl Iterator<Item = OpensWhen>) -> Vec<OpensWhen> {
    let mut known = Vec::new();
    for sign in signs {
        if !known.contains(&sign) {
            known.push(sign);
        }
    }
    known
}

/// Sets the error of the computation beside the distance from peak to limit, and names the
/// largest influence that the rule does not count.
fn uncertainty(case: &Case<'_>) -> Option<Reason> {
    let judged = &case.judged[case.nominal];
    if judged.outcome.broke_down {
        return None;
    }
    let run = judged.run();
    let total = judged.uncertainty_rad();
    let distance = (run.peak_angle_rad - case.design.criterion.threshold_rad).abs();
    let parts = format!(
        "±{} rad (integration {} rad, straight lines between samples {} rad)",
        plain(total, 2),
        plain(run.numerical_error_rad, 2),
        plain(judged.interpolation_error_rad, 2)
    );
    let largest = case
        .budget
        .ranked()
        .into_iter()
        .find(|(name, value)| !matches!(*name, "numerical" | "interpolation") && *value > 0.0)
        .map_or_else(String::new, |(name, value)| {
            format!(
                " Not counted in it, the largest influence measured is {}: {} rad{}.",
                influence(name),
                plain(value, 2),
                if value > distance {
                    ", more than that distance"
                } else {
                    ""
                }
            )
        });
    let spans = distance <= total;
    Some(Reason {
        code: if spans {
            "uncertainty-spans-threshold"
        } else {
            "uncertainty"
        },
        text: format!(
            "The error of the computation, {parts}, is {} than the {} rad between peak and limit.{largest}",
            if spans { "no less" } else { "less" },
            plain(distance, 3)
        ),
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
