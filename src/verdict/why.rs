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
    pub(super) budget: &'a ErrorBudget,
}

/// Returns the reasons, the weightiest first.
pub(super) fn reasons(case: &Case<'_>) -> Vec<Reason> {
    let mut reasons = Vec::new();
    if case.answer == Answer::Unusable {
        reasons.extend(blocking(case.findings));
    }
    reasons.push(peak(case));
    if case.answer == Answer::Fail
        && let Some(bad) = case.first_bad.filter(|bad| bad.is_finite())
    {
        reasons.push(Reason {
                code: "failed-before-fault",
                text: format!(
                    "A blocking fault begins at {} s, but the lever was lost before it: the fault cannot bring the door back.",
                    plain(bad, 5)
                ),
            });
    }
    reasons.extend(disagreement(case));
    reasons.push(uncertainty(case));
    reasons.push(Reason {
        code: "nominal-runs-only",
        text: "No ensemble of tolerances was run: the verdict is that of the nominal runs, as with --members 0.".into(),
    });
    reasons
}

/// One reason for each blocking finding.
pub(super) fn blocking(findings: &[Finding]) -> impl Iterator<Item = Reason> + '_ {
    findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking)
        .map(|finding| Reason {
            code: finding.code,
            text: finding.text.clone(),
        })
}

fn peak(case: &Case<'_>) -> Reason {
    let judged = &case.judged[case.nominal];
    let run = judged.run();
    let threshold = case.design.criterion.threshold_rad;
    let place = describe(case.pairs[case.nominal], case.options);
    let share = 100.0 * run.peak_angle_rad / threshold;
    if judged.outcome.broke_down {
        return Reason {
            code: "method-broke-down",
            text: format!(
                "The {} method could not follow the lever ({place}).",
                run.method
            ),
        };
    }
    match run.first_crossing_s {
        Some(crossing) => Reason {
            code: "threshold-crossed",
            text: format!(
                "The lever crosses {} rad at {} s and reaches {} rad at {} s ({place}), {} times the limit.",
                plain(threshold, 3),
                plain(crossing, 5),
                plain(run.peak_angle_rad, 4),
                plain(run.peak_time_s, 5),
                plain(run.peak_angle_rad / threshold, 3),
            ),
        },
        None if run.peak_angle_rad > 0.0 => Reason {
            code: "threshold-not-crossed",
            text: format!(
                "The lever reaches at most {} rad, at {} s ({place}): {} % of the limit of {} rad{}.",
                plain(run.peak_angle_rad, 4),
                plain(run.peak_time_s, 5),
                plain(share, 3),
                plain(threshold, 3),
                coast_words(run.coast_peak_angle_rad),
            ),
        },
        None => Reason {
            code: "never-released",
            text: format!(
                "The lever never leaves its stop ({place}){}.",
                coast_words(run.coast_peak_angle_rad)
            ),
        },
    }
}

fn coast_words(coast: Option<f64>) -> String {
    coast.map_or_else(String::new, |coast| {
        format!(
            "; after the record's end it coasts to {} rad",
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
                format!(
                    "{} stop, {} opens: {} at {} rad",
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

fn uncertainty(case: &Case<'_>) -> Reason {
    let judged = &case.judged[case.nominal];
    let run = judged.run();
    let threshold = case.design.criterion.threshold_rad;
    let total = judged.uncertainty_rad();
    let parts = format!(
        "{} rad from integration and {} rad from interpolation between samples",
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
                " The largest other influence measured is {}: {} rad.",
                influence(name),
                plain(value, 2)
            )
        });
    if (run.peak_angle_rad - threshold).abs() <= total {
        return Reason {
            code: "uncertainty-spans-threshold",
            text: format!("The peak's uncertainty spans the limit: {parts}.{largest}"),
        };
    }
    Reason {
        code: "uncertainty",
        text: format!("The peak's uncertainty, {parts}, does not reach the limit.{largest}"),
    }
}

fn influence(name: &str) -> &str {
    match name {
        "model" => "the stop model (rigid against soft)",
        "filter" => "the filter (against none)",
        "bias" => "the bias (one standard error)",
        "polarity" => "the polarity (reversed)",
        other => other,
    }
}
