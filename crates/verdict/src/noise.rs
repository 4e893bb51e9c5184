//! What the noise of a recording does to a peak.
//!
//! The raw samples carry a white noise: that of the quiet stretch before contact, and at least that of
//! rounding to the recorder's step. The kernel carries its variance along with the lever, through
//! impacts, to first order; a filter or a reading leaves what counts of it, that at frequencies a lever
//! follows, as it is. Where that says much, impacts may have made more of it than there is room for:
//! then the noise is drawn, conditioned and replayed.

use super::ensemble::draw::philox;
use super::runs::{RunDetail, RunSetup, variant_of};
use crate::conditioning;
use crate::conditioning::between;
use latchgate_kernel::replay::{Method, RunOutcome};
use latchgate_recording::error::Error;
use std::borrow::Cow;

/// Standard deviation of a peak from which on the noise is drawn [rad].
const DRAWN_FROM_RAD: f64 = 0.02;

/// Times the standard deviation to first order that the draws may come to: an answer that so much of it would
/// change hangs on them.
const ROOM: f64 = 8.0;

/// Draws where an answer hangs on them.
const DRAWS: u32 = 16;

/// Draws where they are told and no more.
const DRAWS_TOLD: u32 = 4;

/// A first-order deviation from which on it is no angle of a lever [rad].
const NO_ANGLE_RAD: f64 = 1.0;

/// Returns the standard deviation of a run's peak, or of its coast's if that is larger, to first order
/// [rad].
pub(super) fn carried_rad(setup: &RunSetup<'_>, run: &RunOutcome) -> Result<f64, Error> {
    let conditioned = setup.readings.conditioned();
    let noise = conditioned.noise.deviation_m_s2;
    if noise <= 0.0 || run.broke_down {
        return Ok(0.0);
    }
    let variant = variant_of(run);
    if setup.policy.method_on(variant.model).0 != Method::EventDriven {
        // What the draws tell stands instead.
        return Ok(f64::MAX);
    }
    let variance = noise * noise * conditioned.raw.rate.interval().seconds();
    let own = setup.readings.own()?;
    let carried = setup.run(&own, variant, setup.window, RunDetail::Noise(variance))?;
    Ok(carried.deviation_rad.unwrap_or(f64::MAX))
}

/// Returns the standard deviations of runs, of which `deviations` are those to first order. Where these are
/// large, first order is no measure: the draws that tell are made of a run, by its place, whose answer `hangs`
/// on so large a deviation, and of the one that is `told`.
pub(super) fn deviations_rad(
    setup: &RunSetup<'_>,
    runs: &[RunOutcome],
    mut deviations: Vec<f64>,
    told: Option<usize>,
    hangs: impl Fn(usize, f64) -> bool,
) -> Result<Vec<f64>, Error> {
    let conditioned = setup.readings.conditioned();
    let noise = conditioned.noise.deviation_m_s2;
    if noise <= 0.0 {
        return Ok(deviations);
    }
    let spent: u64 = runs.iter().map(|run| run.spent).sum();
    if !setup.work.allows(u64::from(DRAWS).saturating_mul(spent)) {
        return Ok(deviations);
    }
    let much = |place: &usize| deviations[*place] >= DRAWN_FROM_RAD;
    let hanging = |place: &usize| much(place) && hangs(*place, ROOM * deviations[*place]);
    let mut open: Vec<usize> = (0..runs.len()).filter(hanging).collect();
    let draws = if open.is_empty() { DRAWS_TOLD } else { DRAWS };
    open.extend(told.filter(|place| much(place) && !open.contains(place)));
    if told.is_some() {
        // A document shows every run's: where impacts amplify it, first order says millions of radians.
        let absurd = |place: &usize| deviations[*place] >= NO_ANGLE_RAD && !open.contains(place);
        let further: Vec<usize> = (0..runs.len()).filter(absurd).collect();
        open.extend(further);
    }
    if open.is_empty() {
        return Ok(deviations);
    }
    let seeds: Vec<u32> = (0..draws).collect();
    let squares = setup.share(open.len(), &seeds, |&seed| {
        let count = conditioned.raw.samples.len();
        let raw = drawn(noise, count, setup.policy.seed, seed);
        let mut noisy = conditioning::through(conditioned, raw)?;
        for (a, own) in noisy.samples.iter_mut().zip(&conditioned.used.samples) {
            *a += own;
        }
        let noisy = between::read(Cow::Owned(noisy), setup.readings.between())?;
        let square = |place: &usize| {
            let (run, window) = (&runs[*place], setup.window);
            let drawn = setup.run(&noisy, variant_of(run), window, RunDetail::PeakOnly)?;
            let change = peaks(&drawn).into_iter().zip(peaks(run));
            let change = change.map(|(drawn, own)| (drawn - own).abs());
            let change = change.fold(0.0, f64::max);
            Ok(change * change)
        };
        open.iter().map(square).collect::<Result<Vec<f64>, Error>>()
    })?;
    for (of_open, place) in open.iter().enumerate() {
        let sum: f64 = squares.iter().map(|draw| draw[of_open]).sum();
        deviations[*place] = (sum / f64::from(draws)).sqrt();
    }
    Ok(deviations)
}

/// Returns the peak of a run, and the larger of peak and coast [rad].
fn peaks(outcome: &RunOutcome) -> [f64; 2] {
    let peak = outcome.run.peak_angle_rad;
    let coast = outcome.run.coast_peak_angle_rad;
    [peak, coast.map_or(peak, |coast| coast.max(peak))]
}

/// Draws a white noise of this standard deviation [m/s²], evenly spread as that of rounding is: sample by
/// sample a function of seed and draw alone.
fn drawn(deviation: f64, count: usize, seed: u64, draw: u32) -> Vec<f64> {
    let key = [(seed >> 32) as u32, seed as u32];
    let scale = deviation * 12.0_f64.sqrt() / 4_294_967_296.0;
    let blocks = (0..).map(|block: u32| philox([block, draw, 1, 0], key));
    let even = blocks
        .flatten()
        .map(|word| scale * (f64::from(word) - 2_147_483_647.5));
    even.take(count).collect()
}
