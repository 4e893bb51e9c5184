//! When the lever opens, and how far varied levers spread around that instant.

use super::ensemble::drivers::quantile;
use super::ensemble::{LOOKS, Scatter, Varied};
use super::looks;
use super::policy::Variant;
use super::runs::RunSetup;
use super::variant::{Crossings, VariantResult};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The instant at which the lever first exceeds the limit angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Opening {
    /// Of the earliest nominal run that crosses [s]; `None` if varied levers alone do.
    pub first_s: Option<f64>,
    /// The stop of that run.
    pub model: StopModel,
    /// Its sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Of the varied levers that cross, five in a hundred do so before [s]; `None` where none was asked.
    pub p05_s: Option<f64>,
    /// Their median [s].
    pub p50_s: Option<f64>,
    /// Five in a hundred cross later [s].
    pub p95_s: Option<f64>,
    /// Varied levers of that stop and sign that were asked.
    pub members: u32,
    /// How many of these cross.
    pub exceeded: u32,
    /// What differs between them; `None` where none was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub varied: Option<Varied>,
}

/// Returns when the lever opens in each opening direction in which a nominal or varied lever does.
pub(super) fn by_direction(
    setup: &RunSetup<'_>,
    scatter: Option<&Scatter>,
    results: &[VariantResult],
) -> Result<BTreeMap<OpensWhen, Opening>, Error> {
    let mut openings = BTreeMap::new();
    for sign in setup.policy.polarity.signs() {
        let results = results.iter();
        let of_sign: Vec<&VariantResult> = results
            .filter(|result| result.variant.opens_when == *sign)
            .collect();
        let opening = opening(setup, scatter, &of_sign)?.map(|opening| Opening {
            varied: scatter.and_then(Scatter::varied),
            ..opening
        });
        openings.extend(opening.map(|opening| (*sign, opening)));
    }
    Ok(openings)
}

/// Returns the opening of the earliest nominal run; where none crosses, that of most varied levers.
pub(super) fn earliest<'a>(openings: impl Iterator<Item = &'a Opening>) -> Option<Opening> {
    openings.copied().min_by(|one, other| {
        let first = |opening: &Opening| opening.first_s.unwrap_or(f64::INFINITY);
        first(one)
            .total_cmp(&first(other))
            .then(other.exceeded.cmp(&one.exceeded))
    })
}

/// Finds the earliest nominal run that crosses, or, where none does, the stop of which most varied levers
/// cross. A stop whose ensemble was not needed for the verdict is asked here for as many levers as the first
/// look takes.
fn opening(
    setup: &RunSetup<'_>,
    scatter: Option<&Scatter>,
    results: &[&VariantResult],
) -> Result<Option<Opening>, Error> {
    let crossing = |result: &&&VariantResult| result.counted().run().first_crossing_s.is_some();
    let instant = |result: &VariantResult| result.counted().run().first_crossing_s;
    let earliest = results.iter().filter(crossing).min_by(|one, other| {
        let [one_s, other_s] = [one, other].map(|result| instant(result).unwrap_or(f64::NAN));
        one_s.total_cmp(&other_s)
    });
    if let Some(result) = earliest {
        let crossings = match scatter {
            Some(scatter) if result.crossings.0.is_empty() => first_look(setup, scatter, result)?,
            _ => result.crossings.clone(),
        };
        return Ok(Some(Opening::of(
            result.variant,
            instant(result),
            &crossings,
        )));
    }
    let most_crossed = results
        .iter()
        .map(|result| Opening::of(result.variant, None, &result.crossings))
        .filter(|opening| opening.exceeded > 0)
        .reduce(|largest, other| match other.exceeded > largest.exceeded {
            true => other,
            false => largest,
        });
    Ok(most_crossed)
}

/// Asks the first varied levers of a stop and sign when they cross; none near the limit of work.
fn first_look(
    setup: &RunSetup<'_>,
    scatter: &Scatter,
    result: &VariantResult,
) -> Result<Crossings, Error> {
    let count = LOOKS[0].min(setup.policy.members);
    if !(setup.work).allows(u64::from(count) * result.counted().outcome.spent) {
        return Ok(Crossings::default());
    }
    looks::crossings(setup, scatter, result.variant, count).map(Crossings)
}

impl Opening {
    fn of(variant: Variant, first_s: Option<f64>, crossings: &Crossings) -> Self {
        let sorted = crossings.sorted();
        let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let quantile_at = |share: f64| (!sorted.is_empty()).then(|| quantile(&sorted, share));
        Self {
            first_s,
            model: variant.model,
            opens_when: variant.opens_when,
            p05_s: quantile_at(0.05),
            p50_s: quantile_at(0.5),
            p95_s: quantile_at(0.95),
            members: number(crossings.0.len()),
            exceeded: number(sorted.len()),
            varied: None,
        }
    }
}
