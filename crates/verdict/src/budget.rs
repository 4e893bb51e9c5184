//! The error budget: by how much the nominal peak changes when one part of the way to it does.

use super::ErrorBudget;
use super::policy::{Polarity, Variant};
use super::runs::{RunDetail, RunSetup};
use super::variant::VariantResult;
use crate::conditioning::{self, Conditioned, Signal};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::signal::Reading;
use latchgate_recording::error::Error;

/// The part of the budget that a rerun measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BudgetPart {
    Filter,
    Bias,
    Model,
}

/// One change of the nominal run.
struct Rerun<'a> {
    part: BudgetPart,
    reading: Reading<'a>,
    variant: Variant,
}

/// Measures the budget of `nominal`; `unfiltered_peak` is its peak without a filter [rad], where
/// that is known.
pub(super) fn budget(
    setup: &RunSetup<'_>,
    conditioned: &Conditioned,
    results: &[VariantResult],
    nominal: &VariantResult,
    unfiltered_peak: Option<f64>,
) -> Result<ErrorBudget, Error> {
    let variant = nominal.variant;
    let peak = nominal.run.run().peak_angle_rad;
    let peak_of = |variant| {
        let result = results.iter().find(|result| result.variant == variant)?;
        Some(result.run.run().peak_angle_rad)
    };
    let others = StopModel::ALL
        .into_iter()
        .filter(|model| *model != variant.model);
    let others: Vec<Variant> = others.map(|model| Variant { model, ..variant }).collect();
    let mut reruns = own_reruns(setup, conditioned, variant, unfiltered_peak.is_none())?;
    for variant in &others {
        if peak_of(*variant).is_none() && admits_start(setup, variant.model) {
            reruns.push(Rerun {
                part: BudgetPart::Model,
                reading: setup.readings.own()?,
                variant: *variant,
            });
        }
    }
    if !setup
        .work
        .allows(reruns.len() as u64 * nominal.run.outcome.spent)
    {
        reruns.clear();
    }
    let outcomes = setup.share(1, &reruns, |rerun| {
        let detail = RunDetail::PeakOnly;
        setup.run(&rerun.reading, rerun.variant, setup.window, detail)
    })?;
    let change = |other: f64| (other - peak).abs();
    let mut budget = ErrorBudget {
        numerical: Some(nominal.run.run().numerical_error_rad),
        interpolation: Some(nominal.run.interpolation_error_rad),
        noise: Some(nominal.run.noise_rad),
        noise_97_5: nominal.run.noise_draws.map(|draws| draws.quantile_rad),
        model: others
            .iter()
            .filter_map(|other| peak_of(*other))
            .map(change)
            .reduce(f64::max),
        filter: unfiltered_peak
            .or(conditioned.filter.is_none().then_some(peak))
            .map(change),
        bias: None,
        polarity: None,
    };
    for (rerun, outcome) in reruns.iter().zip(outcomes) {
        let change = change(outcome.run.peak_angle_rad);
        let entry = match rerun.part {
            BudgetPart::Filter => &mut budget.filter,
            BudgetPart::Bias => &mut budget.bias,
            BudgetPart::Model => &mut budget.model,
        };
        *entry = Some(entry.map_or(change, |before| before.max(change)));
    }
    if setup.policy.polarity == Polarity::Undeclared {
        let reversed = Variant {
            opens_when: variant.opens_when.reversed(),
            ..variant
        };
        budget.polarity = peak_of(reversed).map(change);
    }
    Ok(budget)
}

/// The reruns of a variant itself: without a filter if that is `unfiltered_wanted`, and with the
/// bias moved.
fn own_reruns<'a>(
    setup: &RunSetup<'a>,
    conditioned: &Conditioned,
    variant: Variant,
    unfiltered_wanted: bool,
) -> Result<Vec<Rerun<'a>>, Error> {
    let mut reruns = Vec::new();
    if unfiltered_wanted && conditioned.filter.is_some() {
        reruns.push(Rerun {
            part: BudgetPart::Filter,
            reading: setup
                .readings
                .read(|sensor| conditioning::filtered(sensor, None))?,
            variant,
        });
    }
    for sensor in conditioned
        .sensors()
        .filter(|sensor| sensor.bias_samples > 0)
    {
        for direction in [-1.0, 1.0] {
            let shift = direction * sensor.bias_standard_error_m_s2;
            let moved = |other: &Conditioned| {
                let is_moved = std::ptr::eq(other, sensor);
                Ok(shifted(&other.used, if is_moved { shift } else { 0.0 }))
            };
            reruns.push(Rerun {
                part: BudgetPart::Bias,
                reading: setup.readings.read(moved)?,
                variant,
            });
        }
    }
    Ok(reruns)
}

/// A lever that starts inside a stop that yields has no counterpart on one that does not.
fn admits_start(setup: &RunSetup<'_>, model: StopModel) -> bool {
    let outside = |angle| angle >= 0.0;
    model.yields() || setup.policy.initial_angle_rad.is_none_or(outside)
}

fn shifted(signal: &Signal, shift: f64) -> Signal {
    let mut shifted = signal.clone();
    shifted.samples.iter_mut().for_each(|a| *a += shift);
    shifted
}
