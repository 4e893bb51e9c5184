//! What would change the answer: one input at a time, moved by one standard deviation.

use super::bench::{Bench, Pair, Purpose};
use super::decision::Judged;
use super::ensemble::Scatter;
use super::filters;
use crate::conditioning::Conditioned;
use crate::error::Error;
use crate::model::stop::StopModel;
use crate::units::{OpensWhen, STANDARD_GRAVITY};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// How an input is moved.
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

/// What the nominal run does with one input moved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WhatIf {
    /// Design key of the input.
    pub input: Cow<'static, str>,
    /// How it is moved.
    pub how: Change,
    /// By how much, in the key's unit.
    pub change: f64,
    /// Largest angle then, of the stops and polarities that count [rad].
    pub peak_angle_rad: f64,
    /// Stops and polarities whose nominal peak lies on the other side of the limit.
    pub changes_side: Vec<Side>,
}

/// A stop and polarity whose peak lies on the other side of the limit than before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Side {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Its peak then [rad].
    pub peak_angle_rad: f64,
}

/// Runs the nominal lever of every pair again, with one input moved at a time.
pub(super) fn reruns(
    bench: &Bench<'_>,
    conditioned: &Conditioned,
    scatter: &Scatter,
    pairs: &[Pair],
    judged: &[Judged],
    window: Option<(usize, usize)>,
) -> Result<Vec<WhatIf>, Error> {
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
    let mut found = Vec::with_capacity(moves.len() + 1);
    if conditioned.bias_m_s2.abs() > 0.0 {
        let biased = filters::filtered(
            &Conditioned {
                bias_m_s2: 0.0,
                ..conditioned.clone()
            },
            conditioned.filter,
        )?;
        let peaks = bench.share(1, pairs, |pair| {
            let outcome = bench.run(&biased, *pair, window, Purpose::Comparison)?;
            Ok(if outcome.broke_down {
                f64::NAN
            } else {
                outcome.run.peak_angle_rad
            })
        })?;
        let change = conditioned.bias_m_s2 / STANDARD_GRAVITY;
        found.extend(compared(
            bench,
            pairs,
            judged,
            ("input.bias_g", change, Change::BiasKept),
            &peaks,
        ));
    }
    let of_pairs = bench.share(moves.len(), pairs, |pair| {
        bench.peaks(*pair, window, moves.len(), &|index| {
            let (name, _, how) = moves[index];
            scatter.moved(name, if how == Change::More { 1.0 } else { -1.0 })
        })
    })?;
    for (index, moved) in moves.iter().enumerate() {
        let peaks: Vec<f64> = of_pairs
            .iter()
            .map(|reached| reached.peaks[index])
            .collect();
        found.extend(compared(bench, pairs, judged, *moved, &peaks));
    }
    Ok(found)
}

/// Sets the peaks of a rerun beside the nominal ones; nothing, if none could be followed.
fn compared(
    bench: &Bench<'_>,
    pairs: &[Pair],
    judged: &[Judged],
    (input, change, how): (&'static str, f64, Change),
    peaks: &[f64],
) -> Option<WhatIf> {
    let threshold = bench.design.criterion.threshold_rad;
    let largest = peaks.iter().copied().filter(|p| p.is_finite());
    let changes_side = pairs
        .iter()
        .zip(judged.iter().zip(peaks))
        .filter(|(_, (judged, peak))| {
            let before = judged.run().peak_angle_rad;
            !judged.outcome.broke_down
                && peak.is_finite()
                && (**peak > threshold) != (before > threshold)
        })
        .map(|((opens_when, model), (_, peak))| Side {
            model: *model,
            opens_when: *opens_when,
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
