//! What the noise of a recording does to a peak, and what nobody knows between its samples.
//!
//! The raw samples carry a white noise: that of the quiet stretch before contact, and at least that of
//! rounding to the recorder's step. To it comes a noise as strong as what cubics leave out: impacts amplify
//! what is small, and the one rerun by cubics moves a peak by chance a little or much, a noise every way.
//! The kernel carries the variance of both along with the lever, through impacts, to first order; a filter or
//! a reading leaves what counts of it, that at frequencies a lever follows, as it is. Where that says much,
//! impacts may have made more of it than there is room for: then the noise is drawn, conditioned and
//! replayed.

use super::ensemble::draw::philox;
use super::runs::{RunDetail, RunSetup, variant_of};
use crate::conditioning;
use latchgate_kernel::replay::{MethodKind, RunOutcome};
use latchgate_recording::error::Error;

/// Standard deviation of a peak from which on the noise is drawn [rad].
const DRAWN_FROM_RAD: f64 = 0.02;

/// Times the standard deviation to first order that the draws may come to: an answer that so much of it would
/// change hangs on them.
const ROOM: f64 = 8.0;

/// Draws where an answer hangs on them.
const DRAWS: u32 = 16;

/// Draws where they are told and no more.
const DRAWS_TOLD: u32 = 4;

/// Steps of the recorder that are added to every sample in turn.
pub(super) const HALF_STEPS: [f64; 2] = [-0.5, 0.5];

/// White noises of the raw samples, and what both do to a run's peak, or to its coast's if that is larger.
pub(super) struct CarriedNoise {
    /// Standard deviation of the recorder's and the channel's own [m/s²].
    recorded: f64,
    /// That of one as strong as what cubics leave out between the samples [m/s²].
    between: f64,
    /// Half of what half a step of the recorder does to the peak, where rounding is all the noise [rad].
    half_steps_rad: f64,
    /// Standard deviation of the peak [rad].
    deviation_rad: f64,
}

impl CarriedNoise {
    /// Takes over what a run carried along, to first order.
    pub(super) fn of(setup: &RunSetup<'_>, outcome: &RunOutcome) -> Result<Self, Error> {
        let projection = setup.projection(outcome.run.opens_when)?;
        let [recorded, between] = setup.readings.noises_m_s2(setup.weights(&projection))?;
        let half_steps_rad = of_half_steps_rad(setup, outcome)?;
        let event_driven = outcome.run.method == MethodKind::EventDriven;
        let deviation_rad = match outcome.deviation_rad {
            _ if outcome.broke_down => 0.0,
            Some(first_order_rad) => first_order_rad.max(half_steps_rad),
            // What the draws tell stands instead; without a recorded noise nothing is drawn for such a method.
            None if !event_driven && recorded > 0.0 => f64::MAX,
            None => 0.0,
        };
        Ok(Self {
            recorded,
            between,
            half_steps_rad,
            deviation_rad,
        })
    }

    /// Returns the standard deviation of both together [m/s²].
    fn both(&self) -> f64 {
        libm::hypot(self.recorded, self.between)
    }

    /// Returns the parts of the peak's deviation: of the recorded noise, and of what lies between the samples
    /// [rad].
    pub(super) fn parts_rad(&self) -> [f64; 2] {
        let both = self.both();
        if both <= 0.0 || self.deviation_rad >= f64::MAX {
            return [self.deviation_rad, 0.0];
        }
        [self.recorded, self.between].map(|part| self.deviation_rad * (part / both))
    }
}

/// Returns what half a step of the recorder does to a peak, taken as two standard deviations [rad]: along a
/// flat top rounding is no noise but an offset. None where other noise spreads the samples.
fn of_half_steps_rad(setup: &RunSetup<'_>, outcome: &RunOutcome) -> Result<f64, Error> {
    let conditioned = setup.readings.conditioned();
    if !conditioned
        .sensors()
        .any(|sensor| sensor.noise.may_be_offset())
    {
        return Ok(0.0);
    }
    let mut change = 0.0_f64;
    let of_second: &[f64] = match conditioned.second {
        Some(_) => &HALF_STEPS,
        None => &[0.0],
    };
    // Two sensors are off independently: both signs of either.
    let pairs = HALF_STEPS
        .iter()
        .flat_map(|first| of_second.iter().map(move |second| (*first, *second)));
    for (first, second) in pairs {
        let moved = setup.readings.read(|sensor| {
            let mut moved = sensor.used.clone();
            if sensor.noise.may_be_offset() {
                let is_judged = std::ptr::eq(sensor, conditioned);
                let half = if is_judged { first } else { second };
                let offset = half * sensor.noise.step_m_s2;
                moved.samples.iter_mut().for_each(|a| *a += offset);
            }
            Ok(moved)
        })?;
        let run = setup.run(
            &moved,
            variant_of(outcome),
            setup.window,
            RunDetail::PeakOnly,
        )?;
        change = change.max(change_rad(&run, outcome));
    }
    Ok((0.5 * change).min(f64::MAX))
}

/// Draws noises that are large to first order, which is no measure there: those of all runs where they are
/// `told`, else that of a run, by its place, whose answer `hangs` on so large a deviation.
pub(super) fn draw(
    setup: &RunSetup<'_>,
    runs: &[RunOutcome],
    noises: &mut [CarriedNoise],
    told: bool,
    hangs: impl Fn(usize, f64) -> bool,
) -> Result<(), Error> {
    let deviation = |place: usize| noises[place].deviation_rad;
    let much = |place: &usize| deviation(*place) >= DRAWN_FROM_RAD;
    let hanging = |place: &usize| much(place) && hangs(*place, ROOM * deviation(*place));
    let needed: Vec<usize> = (0..runs.len()).filter(hanging).collect();
    let draws = match needed.is_empty() {
        true => DRAWS_TOLD,
        false => DRAWS,
    };
    let candidates: Vec<usize> = match told {
        true => (0..runs.len()).filter(much).collect(),
        false => needed.clone(),
    };
    let allowed = |places: &[usize]| {
        let spent: u64 = places.iter().map(|place| runs[*place].spent).sum();
        setup.work.allows(u64::from(draws).saturating_mul(spent))
    };
    let open = match (allowed(&candidates), allowed(&needed)) {
        (true, _) => candidates,
        (false, true) => needed,
        // First order does not tell what an answer hangs on.
        (false, false) => {
            for place in needed {
                noises[place].deviation_rad = f64::MAX;
            }
            return Ok(());
        }
    };
    if open.is_empty() {
        return Ok(());
    }
    // The runs are of one recording, and so are their noises. Those of two sensors are drawn on the judged one.
    let projection = setup.projection(runs[open[0]].run.opens_when)?;
    let strength = noises[open[0]].both() / projection.tangential[0];
    let conditioned = setup.readings.conditioned();
    let seeds: Vec<u32> = (0..draws).collect();
    let squares = setup.share(open.len(), &seeds, |&seed| {
        let count = conditioned.raw.samples.len();
        let raw = drawn(strength, count, setup.policy.seed, seed);
        let mut noisy = conditioning::through(conditioned, raw)?;
        for (a, own) in noisy.samples.iter_mut().zip(&conditioned.used.samples) {
            *a += own;
        }
        let noisy = setup.readings.read(|sensor| {
            let is_judged = std::ptr::eq(sensor, conditioned);
            Ok(if is_judged {
                noisy.clone()
            } else {
                sensor.used.clone()
            })
        })?;
        let square = |place: &usize| {
            let (run, window) = (&runs[*place], setup.window);
            let drawn = setup.run(&noisy, variant_of(run), window, RunDetail::PeakOnly)?;
            let change = change_rad(&drawn, run);
            Ok(change * change)
        };
        open.iter().map(square).collect::<Result<Vec<f64>, Error>>()
    })?;
    for (of_open, place) in open.iter().enumerate() {
        let sum: f64 = squares.iter().map(|draw| draw[of_open]).sum();
        let drawn = (sum / f64::from(draws)).sqrt().min(f64::MAX);
        noises[*place].deviation_rad = drawn.max(noises[*place].half_steps_rad);
    }
    Ok(())
}

/// Returns by how much a rerun's peak differs, or the larger of peak and coast [rad]; infinite if it could not be
/// followed.
fn change_rad(rerun: &RunOutcome, run: &RunOutcome) -> f64 {
    if rerun.broke_down {
        return f64::INFINITY;
    }
    let pairs = peaks(rerun).into_iter().zip(peaks(run));
    pairs
        .map(|(peak, own)| (peak - own).abs())
        .fold(0.0, f64::max)
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
