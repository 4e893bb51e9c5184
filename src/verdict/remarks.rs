//! What the replay itself finds odd, and which findings count.

use super::assess::{AssessOptions, Polarity};
use super::decision::Judged;
use super::why;
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::recording::{Finding, Severity};
use crate::replay::Method;
use crate::units::SampleInterval;

/// A fault that begins after the judged window does not count.
pub(super) fn counts(finding: &Finding, window_s: Option<(f64, f64)>) -> bool {
    match (window_s, finding.at_s) {
        (Some((_, end)), Some(at)) => at <= end,
        _ => true,
    }
}

pub(super) fn late_faults(findings: &[Finding], window_s: Option<(f64, f64)>) -> Option<Finding> {
    let first = first_late_fault(findings, window_s)?;
    Some(Finding::warning(
        "fault-after-window",
        format!(
            "What blocks a verdict from {} on lies after the end of the judged window and does not count; the verdict says nothing about what follows the window.",
            why::instant(first)
        ),
    )
    .at(first))
}

/// When the first blocking finding begins that lies after the judged window.
pub(super) fn first_late_fault(findings: &[Finding], window_s: Option<(f64, f64)>) -> Option<f64> {
    findings
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking && !counts(finding, window_s))
        .filter_map(|finding| finding.at_s)
        .min_by(f64::total_cmp)
}

pub(super) fn crossing_outside_window(at_s: f64, design: &Design) -> Finding {
    Finding::warning(
        "crossing-outside-window",
        format!(
            "Outside the judged window the lever crosses the limit of {} rad, first at {}; with --window that does not count.",
            design.criterion.threshold_rad,
            why::instant(at_s)
        ),
    )
    .at(at_s)
}

/// What the replay itself found odd.
pub(super) fn replay_findings(
    design: &Design,
    options: &AssessOptions,
    interval: SampleInterval,
    judged: &[Judged],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if options.polarity == Polarity::Undeclared {
        findings.push(Finding::warning(
            "polarity-undeclared",
            "Neither option nor card says which sign of the recorded acceleration opens the lever; both were judged. State it with --opens-when or in the card.",
        ));
    }
    if judged
        .iter()
        .any(|j| j.run().peak_angle_rad > std::f64::consts::FRAC_PI_2)
    {
        findings.push(Finding::info(
            "beyond-geometry",
            "The angle exceeds π/2, where a lever on a latch has long met other parts: the crossing of the threshold stands, the size of the peak does not.",
        ));
    }
    if let Some(j) = judged.iter().find(|j| j.outcome.broke_down) {
        findings.push(Finding::warning(
            "method-broke-down",
            format!("The {} method could not follow the lever on the {} stop{}; its numbers mean nothing.", j.run().method, j.run().model.name(), j.outcome.breakdown.map_or_else(String::new, |why| format!(": {}", why.text()))),
        ));
    }
    findings.extend(method_findings(design, options, interval, judged));
    for j in judged {
        let run = j.run();
        if run.numerical_error_rad > 0.01 * design.criterion.threshold_rad
            && options.method == Method::EventDriven
        {
            findings.push(Finding::warning(
                "rounding-amplified",
                format!(
                    "{} impacts on the {} stop have carried rounding to {:.1e} rad: the peak is not known better than that.",
                    run.impacts,
                    run.model.name(),
                    run.numerical_error_rad
                ),
            ));
        }
        if run.first_crossing_s.is_some_and(|time| time < 0.0) {
            findings.push(
                Finding::warning(
                    "crossing-before-contact",
                    format!("On the {} stop the threshold is crossed before time zero, the instant of first contact: check bias, filter and time zero.", run.model.name()),
                )
                .at(run.first_crossing_s.unwrap_or(0.0)),
            );
        }
    }
    findings
}

/// What is known of the method that was asked for.
pub(super) fn method_findings(
    design: &Design,
    options: &AssessOptions,
    interval: SampleInterval,
    judged: &[Judged],
) -> Vec<Finding> {
    let method = options.method;
    let mut findings = Vec::new();
    match method {
        Method::EventDriven => return findings,
        Method::Rk4 { .. } => findings.push(Finding::warning(
            "fixed-step-method",
            "The fixed-step method sees impacts only at the end of a step; it is for comparison, and its stated error is an estimate from halving the step.",
        )),
        _ => findings.push(Finding::warning(
            "comparison-method",
            format!(
                "The {} method is for comparison; its stated error is an estimate from a second run with {}.",
                method.name(),
                if method.steps_per_period().is_some() { "half the step" } else { "a tenth of the tolerance" }
            ),
        )),
    }
    for stop in [StopModel::Rigid, StopModel::Soft] {
        if judged.iter().any(|j| j.run().model == stop) {
            for text in method.known_failures(design, stop, interval, options.tolerance_rad) {
                if !findings.iter().any(|known| known.text == text) {
                    findings.push(Finding::warning("method-known-to-fail", text));
                }
            }
        }
    }
    findings
}
