//! A row: the decision of one recording and one design, and no more than it takes to show it.

use super::answer;
use super::place::Decided;
use super::prepared::{Prepared, Refused};
use latchgate_document::Document;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::range::Range;
use latchgate_recording::error::Error;
use latchgate_verdict::{Answer, AssessDetail, AssessExtras, Reason};
use serde::{Deserialize, Serialize};

/// The decision of one recording and one design. What a report adds (what-ifs, error budget,
/// tables, curves) is left out; [`Prepared::judge`] gives it, and the same answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DecisionRow {
    /// What the question and what was read for it hash to, as [`Document::report_id`].
    pub report_id: String,
    /// The answer.
    pub verdict: Answer,
    /// The weightiest reason.
    pub reason: Reason,
    /// The angle that loses the door [rad].
    pub threshold_rad: f64,
    /// Largest angle of the nominal run [rad]; `None` where nothing was replayed, or where the
    /// recording is unusable.
    pub peak_angle_rad: Option<f64>,
    /// Its U, numerical plus interpolation error [rad].
    pub uncertainty_rad: Option<f64>,
    /// Largest angle after the judged window [rad].
    pub coast_peak_angle_rad: Option<f64>,
    /// Bounds of the share of varied levers that cross; `None` without an
    /// ensemble.
    pub share: Option<Range>,
}

impl DecisionRow {
    /// Returns how far the peak stays below the threshold, error taken off, as part of the
    /// threshold; below zero where it does not. `None` without a peak.
    pub fn margin(&self) -> Option<f64> {
        let highest = self.peak_angle_rad? + self.uncertainty_rad.unwrap_or(0.0);
        Some((self.threshold_rad - highest) / self.threshold_rad)
    }

    fn of(document: &Document) -> Self {
        let reason = document.why.first().cloned().unwrap_or(Reason {
            code: "none".into(),
            text: "no reason is known".into(),
        });
        let usable = document.verdict != Answer::Unusable;
        let nominal = document.nominal.as_ref().filter(|_| usable);
        let answered = nominal.and_then(|run| document.answer_of(run));
        Self {
            report_id: document.report_id.clone(),
            verdict: document.verdict,
            reason,
            threshold_rad: document.threshold_rad,
            peak_angle_rad: nominal.map(|run| run.peak_angle_rad),
            uncertainty_rad: answered.and_then(|answer| answer.uncertainty_rad),
            coast_peak_angle_rad: nominal.and_then(|run| run.coast_peak_angle_rad),
            share: document
                .ensemble
                .as_ref()
                .filter(|_| usable)
                .map(|ensemble| Range::new(ensemble.p_lower, ensemble.p_upper)),
        }
    }
}

impl Prepared {
    /// Replays the lever of `design` and decides, with no more than the decision takes.
    ///
    /// # Errors
    ///
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work. Anything else that leaves
    /// nothing to judge is a row that says `unusable`.
    pub fn row(&self, design: &Design, control: &Control<'_>) -> Result<DecisionRow, Error> {
        match self.facts.request.siblings {
            true => self.row_of_siblings(design, control),
            false => self.row_alone(design, control),
        }
    }

    /// Decides on this channel alone.
    pub(super) fn row_alone(
        &self,
        design: &Design,
        control: &Control<'_>,
    ) -> Result<DecisionRow, Error> {
        let extras = AssessExtras {
            detail: AssessDetail::Decision,
            ..AssessExtras::default()
        };
        let facts = &self.facts;
        let document = match self.decide(design, extras, control) {
            Ok(Decided {
                assessment,
                conditioned,
                transfer,
            }) => answer::answered(facts, &conditioned, design, assessment, transfer),
            Err(error) if error.is_stopped() => return Err(error),
            Err(error) => answer::refused(facts, Some(&self.conditioned), design, &error),
        };
        Ok(DecisionRow::of(&document))
    }
}

impl Refused {
    /// Returns the row of a design: that it could not be judged, and why.
    pub fn row(&self, design: &Design) -> DecisionRow {
        DecisionRow::of(&answer::refused(self.facts(), None, design, &self.error))
    }
}
