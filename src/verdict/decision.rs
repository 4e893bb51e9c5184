//! The decision rule: what one run says, and what several say together.

use super::{Answer, ErrorBudget, RunAnswer};
use crate::replay::{Outcome, Run};

/// The rule in words, as every verdict and report states it.
pub const DECISION_RULE: &str = "Nominal runs alone (as with --members 0). U = numerical + interpolation error. \
(1) fail, if the runs say so by (3) on the samples before the first that a blocking finding declares bad. \
(2) Otherwise unusable, if any finding is blocking; one that begins after the judged window does not count. \
(3) Otherwise, for each stop and polarity that counts: pass if the peak angle plus U and the coast's peak angle plus its own error, never less than U, are at or below the threshold; \
fail if the peak angle minus U exceeds the threshold; else undecided. \
(4) Two stops (model auto) or two undeclared polarities that answer differently: undecided; polarities declared as both: the worse counts.";

/// What one stop and polarity gave: the run, its error, and the same on finer samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// The nominal run.
    pub outcome: Outcome,
    /// Change of the larger of peak and coast peak when the samples are refined fourfold [rad].
    pub interpolation_error_rad: f64,
}

impl Judged {
    /// Returns the run.
    #[must_use]
    pub fn run(&self) -> &Run {
        &self.outcome.run
    }

    /// Returns U, numerical plus interpolation error [rad].
    #[must_use]
    pub fn uncertainty_rad(&self) -> f64 {
        self.run().numerical_error_rad + self.interpolation_error_rad
    }

    /// Returns the error of the coast's peak [rad], never less than U.
    #[must_use]
    pub fn coast_uncertainty_rad(&self) -> f64 {
        self.uncertainty_rad()
            .max(self.outcome.coast_error_rad + self.interpolation_error_rad)
    }

    /// Returns what this run says by part 3 of the rule, with the errors it says it with.
    #[must_use]
    pub fn stated(&self, threshold_rad: f64) -> RunAnswer {
        // An error as large as no number can be is that of a run that was not followed.
        let followed = |error: f64| (!self.outcome.broke_down && error < f64::MAX).then_some(error);
        let run = self.run();
        RunAnswer {
            model: run.model,
            opens_when: run.opens_when,
            answer: self.answer(threshold_rad),
            interpolation_error_rad: followed(self.interpolation_error_rad),
            uncertainty_rad: followed(self.uncertainty_rad()),
            coast_uncertainty_rad: run
                .coast_peak_angle_rad
                .and_then(|_| followed(self.coast_uncertainty_rad())),
        }
    }

    fn coast_stays_below(&self, threshold_rad: f64) -> bool {
        self.run()
            .coast_peak_angle_rad
            .is_none_or(|coast| coast + self.coast_uncertainty_rad() <= threshold_rad)
    }

    /// Returns whether only the motion after the last judged sample forbids a pass.
    #[must_use]
    pub fn held_back_by_coast(&self, threshold_rad: f64) -> bool {
        !self.outcome.broke_down
            && self.run().peak_angle_rad + self.uncertainty_rad() <= threshold_rad
            && !self.coast_stays_below(threshold_rad)
    }

    /// Returns what this run says by part 3 of the rule.
    #[must_use]
    pub fn answer(&self, threshold_rad: f64) -> Answer {
        if self.outcome.broke_down {
            return Answer::Undecided;
        }
        let uncertainty = self.uncertainty_rad();
        let run = self.run();
        if run.peak_angle_rad + uncertainty <= threshold_rad {
            if self.coast_stays_below(threshold_rad) {
                Answer::Pass
            } else {
                Answer::Undecided
            }
        } else if run.peak_angle_rad - uncertainty > threshold_rad {
            Answer::Fail
        } else {
            Answer::Undecided
        }
    }
}

/// Joins the answers of stops, or of undeclared polarities: one answer if all agree.
#[must_use]
pub fn unanimous(answers: &[Answer]) -> Answer {
    match answers {
        [] => Answer::Undecided,
        [first, rest @ ..] if rest.iter().all(|answer| answer == first) => *first,
        _ => Answer::Undecided,
    }
}

/// Joins the answers of polarities that were declared as both: the worse counts.
#[must_use]
pub fn worse(answers: &[Answer]) -> Answer {
    [Answer::Fail, Answer::Undecided]
        .into_iter()
        .find(|answer| answers.contains(answer))
        .unwrap_or_else(|| unanimous(answers))
}

impl ErrorBudget {
    /// Returns the parts with their names, the largest first; parts not measured are left out.
    #[must_use]
    pub fn ranked(&self) -> Vec<(&'static str, f64)> {
        let mut parts: Vec<(&'static str, f64)> = [
            ("numerical", self.numerical),
            ("interpolation", self.interpolation),
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
