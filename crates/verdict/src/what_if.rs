//! What would change the answer: one input at a time, moved by one standard deviation.

use super::ensemble::Scatter;
use super::policy::Variant;
use super::runs::{RunDetail, RunSetup};
use super::variant::VariantResult;
use crate::conditioning::{self, Conditioned};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::batch::AskedPeaks;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Levers that processors with narrow vectors take side by side, at least.
const IN_A_VECTOR: usize = 4;

/// The way an input is moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Change {
    /// By one standard deviation upwards.
    #[serde(rename = "one standard deviation more")]
    More,
    /// By one standard deviation downwards.
    #[serde(rename = "one standard deviation less")]
    Less,
    /// The bias that was removed is left in.
    #[serde(rename = "bias not removed")]
    BiasKept,
}

/// The nominal runs with one input moved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WhatIf {
    /// Design key of the input.
    pub input: Cow<'static, str>,
    /// The way it is moved.
    pub how: Change,
    /// By how much, in the key's unit.
    pub change: f64,
    /// Largest angle then, of the stops and polarities that count [rad].
    pub peak_angle_rad: f64,
    /// Stops and polarities whose nominal peak lies on the other side of the limit.
    pub changes_side: Vec<ChangedSide>,
}

/// A stop and polarity whose peak lies on the other side of the limit than before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ChangedSide {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Its peak then [rad].
    pub peak_angle_rad: f64,
}

impl ChangedSide {
    pub(super) fn variant(&self) -> Variant {
        Variant {
            opens_when: self.opens_when,
            model: self.model,
        }
    }
}

/// Runs the nominal lever of every variant again, with one input moved at a time.
pub(super) fn reruns(
    setup: &RunSetup<'_>,
    conditioned: &Conditioned,
    scatter: &Scatter,
    results: &[VariantResult],
) -> Result<Vec<WhatIf>, Error> {
    let variants: Vec<Variant> = results.iter().map(|result| result.variant).collect();
    let moves: Vec<(&'static str, f64, Change)> = scatter
        .parameters()
        .iter()
        .flat_map(|parameter| {
            [
                (parameter.name, parameter.deviation, Change::More),
                (parameter.name, -parameter.deviation, Change::Less),
            ]
        })
        .collect();
    let mut what_ifs = Vec::with_capacity(moves.len() + 1);
    if conditioned.bias_m_s2.abs() > 0.0 {
        let peaks = with_bias_kept(setup, conditioned, &variants)?;
        let change = conditioned.bias_m_s2 / STANDARD_GRAVITY;
        let moved = ("input.bias_g", change, Change::BiasKept);
        what_ifs.extend(compared(setup, results, moved, &peaks));
    }
    // Two levers side by side take as long as a whole vector of them.
    let of_variants = setup.share(moves.len().max(IN_A_VECTOR), &variants, |variant| {
        let member = |index: usize| {
            let (name, _, how) = moves[index];
            scatter.moved(name, if how == Change::More { 1.0 } else { -1.0 })
        };
        setup.peaks(*variant, moves.len(), &member, AskedPeaks::ALL)
    })?;
    for (index, moved) in moves.iter().enumerate() {
        let peaks: Vec<f64> = of_variants.iter().map(|of| of.window_rad[index]).collect();
        what_ifs.extend(compared(setup, results, *moved, &peaks));
    }
    Ok(what_ifs)
}

/// Returns the peak of each variant on the recording with its bias left in [rad]; NaN where the
/// lever could not be followed.
fn with_bias_kept(
    setup: &RunSetup<'_>,
    conditioned: &Conditioned,
    variants: &[Variant],
) -> Result<Vec<f64>, Error> {
    let biased = setup.readings.read(|sensor| {
        let biased = Conditioned {
            bias_m_s2: 0.0,
            ..sensor.clone()
        };
        conditioning::filtered(&biased, conditioned.filter)
    })?;
    setup.share(1, variants, |variant| {
        let outcome = setup.run(&biased, *variant, setup.window, RunDetail::PeakOnly)?;
        Ok(if outcome.broke_down {
            f64::NAN
        } else {
            outcome.run.peak_angle_rad
        })
    })
}

/// Sets the peaks of a rerun beside the nominal ones; nothing, if none could be followed.
fn compared(
    setup: &RunSetup<'_>,
    results: &[VariantResult],
    (input, change, how): (&'static str, f64, Change),
    peaks: &[f64],
) -> Option<WhatIf> {
    let threshold = setup.threshold_rad();
    let largest = peaks.iter().copied().filter(|peak| peak.is_finite());
    let changes_side = results
        .iter()
        .zip(peaks)
        .filter(|(result, peak)| {
            let before = result.run.run().peak_angle_rad;
            !result.run.outcome.broke_down
                && peak.is_finite()
                && (**peak > threshold) != (before > threshold)
        })
        .map(|(result, peak)| ChangedSide {
            model: result.variant.model,
            opens_when: result.variant.opens_when,
            peak_angle_rad: *peak,
        })
        .collect();
    Some(WhatIf {
        input: input.into(),
        how,
        change,
        peak_angle_rad: largest.reduce(f64::max)?,
        changes_side,
    })
}
