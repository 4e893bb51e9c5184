//! What the replay itself finds odd, and which findings count.

use super::decision::Judged;
use super::policy::{Polarity, Policy};
use super::why;
use crate::conditioning::{Cfc, Conditioned, FilterStandard, cfc, resample};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::recording::{Finding, Severity};
use crate::replay::Method;
use crate::units::SampleInterval;

/// Length of a filter's reach by its design frequency [-].
///
/// Both passes together answer an impulse by (ωd/√8)·e^−u·(cos u + sin u) with u = ωd·|t|/√2.
/// Beyond 1.5/fd, where u = 6.66, e^−u/√2 leaves less than a thousandth of its area.
const REACH_PERIODS: f64 = 1.5;

/// Returns how far a filter without phase carries a sample backwards in time [s]: less than a
/// thousandth of its weight lies further away.
pub(crate) fn filter_reach_s(filter: Option<Cfc>, standard: FilterStandard) -> f64 {
    filter.map_or(0.0, |class| {
        REACH_PERIODS / cfc::design_frequency_hz(class, standard)
    })
}

/// What blocking findings leave of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Faults {
    /// From when on findings declare the samples bad [s], −∞ where a bias taken from bad ones
    /// spoils all; `None` if no fault counts.
    pub(crate) first_bad: Option<f64>,
    /// When the first fault begins that lies after the judged window and does not count [s].
    pub(crate) late: Option<f64>,
    /// When the first fault begins that lies after the judged window and counts all the same,
    /// since a filter carries it back into the window [s].
    pub(crate) carried: Option<f64>,
    /// How far conditioning carries a fault backwards [s].
    pub(crate) reach_s: f64,
}

impl Faults {
    /// Finds them for a recording as it is used with `filter`.
    pub(crate) fn of(
        conditioned: &Conditioned,
        filter: Option<Cfc>,
        findings: &[Finding],
        window_s: Option<(f64, f64)>,
    ) -> Self {
        let resampled_s = if conditioned.resample_hz.is_some() {
            resample::end_padding_s(conditioned.raw.rate, conditioned.used.rate)
        } else {
            0.0
        };
        let reach_s = filter_reach_s(filter, conditioned.filter_standard) + resampled_s;
        let bias_end_s = conditioned
            .bias_window_s
            .filter(|_| conditioned.bias_samples > 0)
            .map(|(_, end)| end);
        let mut faults = Self {
            first_bad: None,
            late: None,
            carried: None,
            reach_s,
        };
        let earliest = |known: Option<f64>, at: f64| Some(known.map_or(at, |known| known.min(at)));
        for finding in findings
            .iter()
            .filter(|finding| finding.severity == Severity::Blocking)
        {
            let at = finding.at_s.unwrap_or(f64::NEG_INFINITY);
            // A bias taken from bad samples spoils every sample that it was removed from.
            let spoils_all = bias_end_s.is_some_and(|end| at <= end);
            let end = window_s.map_or(f64::INFINITY, |(_, end)| end);
            if spoils_all || at - reach_s <= end {
                let bad = if spoils_all { f64::NEG_INFINITY } else { at };
                faults.first_bad = earliest(faults.first_bad, bad);
                if at > end {
                    faults.carried = earliest(faults.carried, at);
                }
            } else {
                faults.late = earliest(faults.late, at);
            }
        }
        faults
    }

    /// Returns what there is to say of faults after the judged window.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        found.extend(self.late.map(|at| {
            Finding::warning(
                "fault-after-window",
                format!(
                    "What blocks a verdict from {} on lies after the end of the judged window and does not count; the verdict says nothing about what follows the window.",
                    why::instant(at)
                ),
            )
            .at(at)
        }));
        found.extend(self.carried.map(|at| {
            Finding::warning(
                "fault-reaches-window",
                format!(
                    "What blocks a verdict from {} on lies after the end of the judged window, but bias, filter or resampling carry it into the window; a filter without phase does so by {}. End the window earlier, or take the bias from other samples.",
                    why::instant(at),
                    why::instant(self.reach_s)
                ),
            )
            .at(at)
        }));
        found
    }
}

pub(crate) fn crossing_outside_window(at_s: f64, design: &Design) -> Finding {
    Finding::warning(
        "crossing-outside-window",
        format!(
            "Outside the judged window the lever crosses the limit of {} rad, first at {}; with the setting `window` that does not count.",
            design.criterion.threshold_rad,
            why::instant(at_s)
        ),
    )
    .at(at_s)
}

/// What the replay itself found odd.
pub(crate) fn replay_findings(
    design: &Design,
    policy: &Policy,
    interval: SampleInterval,
    judged: &[Judged],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if policy.polarity == Polarity::Undeclared {
        findings.push(Finding::warning(
            "polarity-undeclared",
            "Neither option nor card says which sign of the recorded acceleration opens the lever; both were judged. State it with the setting `opens_when` or in the card.",
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
    findings.extend(method_findings(design, policy, interval, judged));
    for j in judged {
        let run = j.run();
        if run.numerical_error_rad > 0.01 * design.criterion.threshold_rad
            && policy.method == Method::EventDriven
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
pub(crate) fn method_findings(
    design: &Design,
    policy: &Policy,
    interval: SampleInterval,
    judged: &[Judged],
) -> Vec<Finding> {
    let method = policy.method;
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
            for text in method.known_failures(design, stop, interval, policy.tolerance_rad) {
                if !findings.iter().any(|known| known.text == text) {
                    findings.push(Finding::warning("method-known-to-fail", text));
                }
            }
        }
    }
    findings
}
