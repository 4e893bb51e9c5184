//! Blocking findings against the judged window: from when on they spoil it, or why they do not.

use super::wording::instant;
use crate::conditioning::{Cfc, Conditioned, FilterStandard, cfc, resample};
use latchgate_kernel::range::Window;
use latchgate_recording::{Finding, Severity};

/// Length of a filter's reach by its design frequency [-].
///
/// Both passes together answer an impulse by (ωd/√8)·e^−u·(cos u + sin u) with u = ωd·|t|/√2.
/// Beyond 1.5/fd, where u = 6.66, e^−u/√2 leaves less than a thousandth of its area.
const REACH_PERIODS: f64 = 1.5;

/// Returns how far a filter without phase carries a sample backwards in time [s]: less than a
/// thousandth of its weight lies further away.
fn filter_reach_s(filter: Option<Cfc>, standard: FilterStandard) -> f64 {
    filter.map_or(0.0, |class| {
        REACH_PERIODS / cfc::design_frequency_hz(class, standard)
    })
}

/// From when on blocking findings spoil a recording, and which of them do not.
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
        window: Option<Window>,
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
            .map(|window| window.until_s);
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
            let from_s = finding.at_s.unwrap_or(f64::NEG_INFINITY);
            // A bias taken from bad samples spoils every sample that it was removed from.
            let spoils_all = bias_end_s.is_some_and(|end| from_s <= end);
            let end = window.map_or(f64::INFINITY, |window| window.until_s);
            if spoils_all || from_s - reach_s <= end {
                let bad = if spoils_all {
                    f64::NEG_INFINITY
                } else {
                    from_s
                };
                faults.first_bad = earliest(faults.first_bad, bad);
                if from_s > end {
                    faults.carried = earliest(faults.carried, from_s);
                }
            } else {
                faults.late = earliest(faults.late, from_s);
            }
        }
        faults
    }

    /// Returns the findings of faults after the judged window.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        findings.extend(self.late.map(|from_s| {
            Finding::warning(
                "fault-after-window",
                format!(
                    "The recording is faulty from {} on, after the judged window. The verdict is about the window alone.",
                    instant(from_s)
                ),
            )
            .at(from_s)
        }));
        findings.extend(self.carried.map(|from_s| {
            Finding::warning(
                "fault-reaches-window",
                format!(
                    "The recording is faulty from {} on, after the judged window. Bias, filter or resampling carry the fault into it, the filter by {}. End the window earlier, or take the bias from other samples.",
                    instant(from_s),
                    instant(self.reach_s)
                ),
            )
            .at(from_s)
        }));
        findings
    }
}
