//! What the noise of a recording does to a peak, and what nobody knows between its samples.
//!
//! The raw samples carry a noise: that of the quiet stretch before contact, and at least that of
//! rounding to the recorder's step. To it comes a noise as strong as what cubics leave out: impacts amplify
//! what is small, and the one rerun by cubics moves a peak by chance a little or much, a noise every way.
//! The kernel carries the variance of both, taken as white, along with the lever, through impacts, to first
//! order; a filter or a reading leaves what counts of it, that at frequencies a lever follows, as it is.
//!
//! First order knows of the one maximum that is the peak; under noise another may take its place. So a run
//! that could pass is replayed under draws of the recorded noise with the spectrum of its quiet stretch
//! ([`NoiseSpectrum`]), conditioned as the samples are. Of a run that cannot pass, and of what lies between the
//! samples, draws are made where first order says much: there impacts may have made more of it than there is
//! room for.

use super::Answer;
use super::decision::{NoiseDraws, PASS_DRAWS};
use super::ensemble::draw::philox;
use super::policy::DrawnRuns;
use super::readings::Readings;
use super::runs::{RunDetail, RunSetup, variant_of};
use crate::conditioning;
use crate::noise_spectrum::NoiseSpectrum;
use latchgate_kernel::replay::{MethodKind, RunOutcome};
use latchgate_kernel::signal::Reading;
use latchgate_recording::error::Error;

/// Part of them below which the change that U counts lies.
const QUANTILE: f64 = 0.975;

/// Standard deviation of a peak from which on the noise of other runs is drawn [rad].
const DRAWN_FROM_RAD: f64 = 0.02;

/// Times the standard deviation to first order that the draws may come to: an answer that so much of it would
/// change hangs on them.
const ROOM: f64 = 8.0;

/// Draws where the answer of a run that cannot pass hangs on them, or one on what lies between the samples.
const DRAWS: u32 = 16;

/// Draws where they are told and no more.
const DRAWS_TOLD: u32 = 4;

/// Draws of a search at a value that is none of its answers.
const DRAWS_OF_SEARCH: u32 = 16;

/// Times the largest change by these draws that U must bear there.
const TIMES_OF_SEARCH: f64 = 3.0;

/// Steps of the recorder that are added to every sample in turn.
pub(super) const HALF_STEPS: [f64; 2] = [-0.5, 0.5];

/// Noises of the raw samples, and what both do to a run's peak, or to its coast's if that is larger.
pub(super) struct CarriedNoise {
    /// Standard deviation of the recorder's and the channel's own [m/s²].
    recorded: f64,
    /// That of one as strong as what cubics leave out between the samples [m/s²].
    between: f64,
    /// Half of what half a step of the recorder does to the peak, where rounding is all the noise [rad].
    half_steps_rad: f64,
    /// Standard deviation of the peak by both [rad].
    deviation_rad: f64,
    /// The parts of it: of the recorded noise, and of what lies between the samples [rad].
    parts_rad: [f64; 2],
    /// Draws of the recorded noise, of a run that could pass.
    draws: Option<NoiseDraws>,
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
        let mut carried = Self {
            recorded,
            between,
            half_steps_rad,
            deviation_rad: 0.0,
            parts_rad: [0.0; 2],
            draws: None,
        };
        carried.set_deviation(deviation_rad);
        Ok(carried)
    }

    /// Takes a standard deviation of the peak by both noises, each having its share of their strength.
    fn set_deviation(&mut self, deviation_rad: f64) {
        self.deviation_rad = deviation_rad;
        let both = libm::hypot(self.recorded, self.between);
        self.parts_rad = if both <= 0.0 || deviation_rad >= f64::MAX {
            [deviation_rad, 0.0]
        } else {
            [self.recorded, self.between].map(|part| deviation_rad * (part / both))
        };
    }

    /// Returns the parts of the peak's deviation: of the recorded noise, and of what lies between the samples
    /// [rad].
    pub(super) fn parts_rad(&self) -> [f64; 2] {
        self.parts_rad
    }

    /// Returns the draws of the recorded noise, if the run could pass.
    pub(super) fn draws(&self) -> Option<NoiseDraws> {
        self.draws
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

/// Draws the noises of runs, each by its place: the recorded one of those that could pass; of the others and
/// of what lies between the samples those that are large to first order, which is no measure there. The latter
/// where they are `told`, else where the answer hangs on them. `answer` is that of a run with a standard
/// deviation of its peak from noise.
pub(super) fn draw(
    setup: &RunSetup<'_>,
    runs: &[RunOutcome],
    noises: &mut [CarriedNoise],
    told: bool,
    answer: impl Fn(usize, f64) -> Answer,
) -> Result<(), Error> {
    let passes_with = |place: usize, noise_rad: f64| answer(place, noise_rad) == Answer::Pass;
    let passes = |noise: &CarriedNoise, place: usize| {
        let is_asked = match setup.drawn_runs {
            None => false,
            Some(DrawnRuns::All) => true,
            Some(DrawnRuns::Doubtful) => !passes_with(place, ROOM * noise.deviation_rad),
        };
        is_asked && noise.recorded > 0.0 && passes_with(place, noise.half_steps_rad)
    };
    let places = 0..runs.len();
    let (passing, others): (Vec<usize>, Vec<usize>) =
        places.partition(|place| passes(&noises[*place], *place));
    let hangs = |place: usize, noise_rad: f64| answer(place, noise_rad) != answer(place, 0.0);
    let whole = |noise: &CarriedNoise| noise.deviation_rad;
    for (place, deviation_rad) in large(setup, runs, noises, (&others, true), told, whole, hangs)? {
        let noise = &mut noises[place];
        noise.set_deviation(deviation_rad.max(noise.half_steps_rad));
    }
    let between = |noise: &CarriedNoise| noise.parts_rad[1];
    for (place, deviation_rad) in
        large(setup, runs, noises, (&passing, false), told, between, hangs)?
    {
        noises[place].parts_rad[1] = deviation_rad;
    }
    let still_passes = |place: &usize| {
        let noise = &noises[*place];
        let least_rad = noise.half_steps_rad.max(noise.parts_rad[1]);
        passes_with(*place, least_rad)
    };
    let mut candidates: Vec<usize> = passing.into_iter().filter(still_passes).collect();
    if setup.drawn_runs == Some(DrawnRuns::Doubtful) {
        let is_open = |place: usize, noise_rad: f64| !passes_with(place, noise_rad);
        candidates = left_open_by_few(setup, runs, noises, &candidates, is_open)?;
    }
    draw_of_passes(setup, runs, noises, &candidates)
}

/// Returns the runs, each by its place, whose pass few draws of the recorded noise leave open: one of them opens, or
/// the pass does not bear [`TIMES_OF_SEARCH`] their largest change. The others' noise is that.
fn left_open_by_few(
    setup: &RunSetup<'_>,
    runs: &[RunOutcome],
    noises: &mut [CarriedNoise],
    places: &[usize],
    is_open: impl Fn(usize, f64) -> bool,
) -> Result<Vec<usize>, Error> {
    if places.is_empty() || !are_allowed(setup, runs, places, DRAWS_OF_SEARCH) {
        return Ok(places.to_vec());
    }
    let mut left_open = Vec::new();
    let reruns = replayed(setup, runs, places, DRAWS_OF_SEARCH, (true, 0.0))?;
    for (&place, reruns) in places.iter().zip(reruns) {
        let noise = &mut noises[place];
        let changes = reruns.iter().map(|rerun| rerun.change_rad);
        let largest_rad = changes.fold(0.0, f64::max);
        // U counts a deviation twice.
        let deviation_rad = (0.5 * TIMES_OF_SEARCH * largest_rad).max(noise.half_steps_rad);
        // As U adds them.
        let with_between_rad = deviation_rad + noise.parts_rad[1];
        if reruns.iter().any(|rerun| rerun.opens) || is_open(place, with_between_rad) {
            left_open.push(place);
        } else {
            noise.parts_rad[0] = deviation_rad;
        }
    }
    Ok(left_open)
}

/// Draws the recorded noise of runs that could pass.
fn draw_of_passes(
    setup: &RunSetup<'_>,
    runs: &[RunOutcome],
    noises: &mut [CarriedNoise],
    places: &[usize],
) -> Result<(), Error> {
    if places.is_empty() {
        return Ok(());
    }
    if !are_allowed(setup, runs, places, PASS_DRAWS) {
        // A pass that nobody has drawn is none.
        for place in places {
            noises[*place].parts_rad[0] = f64::MAX;
        }
        return Ok(());
    }
    let reruns = replayed(setup, runs, places, PASS_DRAWS, (true, 0.0))?;
    for (place, reruns) in places.iter().zip(reruns) {
        let noise = &mut noises[*place];
        let opening = reruns.iter().filter(|rerun| rerun.opens).count();
        let quantile_rad = quantile(&reruns);
        noise.parts_rad[0] = deviation(&reruns).max(noise.half_steps_rad);
        noise.draws = Some(NoiseDraws {
            opening: u32::try_from(opening).unwrap_or(u32::MAX),
            quantile_rad,
        });
    }
    Ok(())
}

/// Returns the standard deviation of the peak by the noises of some runs that are large to first order:
/// the recorded one too, or that between the samples alone. Infinite is `f64::MAX`.
fn large(
    setup: &RunSetup<'_>,
    runs: &[RunOutcome],
    noises: &[CarriedNoise],
    (places, with_recorded): (&[usize], bool),
    told: bool,
    first_order_rad: impl Fn(&CarriedNoise) -> f64,
    hangs: impl Fn(usize, f64) -> bool,
) -> Result<Vec<(usize, f64)>, Error> {
    let deviation_rad = |place: usize| first_order_rad(&noises[place]);
    let much = |place: usize| deviation_rad(place) >= DRAWN_FROM_RAD;
    let hanging = |place: &usize| much(*place) && hangs(*place, ROOM * deviation_rad(*place));
    let needed: Vec<usize> = places.iter().copied().filter(hanging).collect();
    let draws = match needed.is_empty() {
        true => DRAWS_TOLD,
        false => DRAWS,
    };
    let candidates: Vec<usize> = match told {
        true => places
            .iter()
            .copied()
            .filter(|place| much(*place))
            .collect(),
        false => needed.clone(),
    };
    let allowed = |places: &[usize]| are_allowed(setup, runs, places, draws);
    let open = match (allowed(&candidates), allowed(&needed)) {
        (true, _) => candidates,
        (false, true) => needed,
        // First order does not tell what an answer hangs on.
        (false, false) => {
            return Ok(needed.into_iter().map(|place| (place, f64::MAX)).collect());
        }
    };
    let Some(first) = open.first() else {
        return Ok(Vec::new());
    };
    // The runs are of one recording, and so are their noises. What lies between the samples of two sensors is
    // drawn on the judged one.
    let projection = setup.projection(runs[*first].run.opens_when)?;
    let between = noises[*first].between / projection.tangential[0];
    let reruns = replayed(setup, runs, &open, draws, (with_recorded, between))?;
    let pairs = open.into_iter().zip(reruns);
    Ok(pairs
        .map(|(place, reruns)| (place, deviation(&reruns)))
        .collect())
}

/// Tells whether so many replays of some runs may still be made.
fn are_allowed(setup: &RunSetup<'_>, runs: &[RunOutcome], places: &[usize], draws: u32) -> bool {
    let spent: u64 = places.iter().map(|place| runs[*place].spent).sum();
    setup.work.allows(u64::from(draws).saturating_mul(spent))
}

/// What one draw came to.
#[derive(Debug, Clone, Copy)]
struct Rerun {
    /// Change of the peak, or of the larger of peak and coast [rad].
    change_rad: f64,
    opens: bool,
}

/// Replays each of some runs under draws of the recorded noise, and of a white one of this strength on the judged
/// sensor [m/s²].
fn replayed(
    setup: &RunSetup<'_>,
    runs: &[RunOutcome],
    places: &[usize],
    draws: u32,
    (with_recorded, between): (bool, f64),
) -> Result<Vec<Vec<Rerun>>, Error> {
    let threshold_rad = setup.threshold_rad();
    let spectra = setup.readings.noise_spectra();
    let spectra = with_recorded.then_some(spectra);
    let numbers: Vec<u32> = (0..draws).collect();
    let of_draws = setup.share(places.len(), &numbers, |&number| {
        let make = || noisy(&setup.readings, setup.policy.seed, spectra, between, number);
        let noisy = match with_recorded && between <= 0.0 {
            true => {
                let of = (number, PASS_DRAWS);
                setup.readings.drawn(setup.policy.seed, of, make)?
            }
            false => make()?,
        };
        let rerun = |place: &usize| {
            let (run, window) = (&runs[*place], setup.window);
            let drawn = setup.run(&noisy, variant_of(run), window, RunDetail::PeakOnly)?;
            let [_, highest_rad] = peaks(&drawn);
            Ok(Rerun {
                change_rad: change_rad(&drawn, run),
                opens: drawn.broke_down || highest_rad > threshold_rad,
            })
        };
        places.iter().map(rerun).collect::<Result<Vec<_>, Error>>()
    })?;
    let of_place = |index: usize| of_draws.iter().map(|draw| draw[index]).collect();
    Ok((0..places.len()).map(of_place).collect())
}

/// Returns the recording with a draw of its noises, conditioned as its samples are.
pub(super) fn noisy(
    readings: &Readings<'_>,
    seed: u64,
    spectra: Option<&[NoiseSpectrum]>,
    between: f64,
    draw: u32,
) -> Result<Reading<'static>, Error> {
    let judged = readings.conditioned();
    readings.read(|sensor| {
        let is_judged = std::ptr::eq(sensor, judged);
        let number = usize::from(!is_judged);
        let count = sensor.raw.samples.len();
        let mut raw = match spectra.and_then(|spectra| spectra.get(number)) {
            Some(spectrum) => spectrum.drawn(count, seed, u32::from(!is_judged), draw),
            None => vec![0.0; count],
        };
        if is_judged && between > 0.0 {
            let white = drawn(between, count, seed, draw);
            raw.iter_mut().zip(white).for_each(|(a, white)| *a += white);
        }
        let mut noisy = conditioning::through(sensor, raw)?;
        for (a, own) in noisy.samples.iter_mut().zip(&sensor.used.samples) {
            *a += own;
        }
        Ok(noisy)
    })
}

/// Returns the root mean square of the changes [rad].
fn deviation(reruns: &[Rerun]) -> f64 {
    let squares = reruns
        .iter()
        .map(|rerun| rerun.change_rad * rerun.change_rad);
    let count = reruns.len().max(1) as f64;
    (squares.sum::<f64>() / count).sqrt().min(f64::MAX)
}

/// Returns the change that 97.5 % of the draws do not exceed [rad].
fn quantile(reruns: &[Rerun]) -> f64 {
    let mut changes: Vec<f64> = reruns.iter().map(|rerun| rerun.change_rad).collect();
    changes.sort_unstable_by(f64::total_cmp);
    let place = (QUANTILE * changes.len() as f64).ceil() as usize;
    let change = changes.get(place.saturating_sub(1));
    change.map_or(0.0, |change| change.min(f64::MAX))
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
