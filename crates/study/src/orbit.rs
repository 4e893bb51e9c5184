//! Periodic orbits of the stroboscopic map, their birth and the doubling of their period.
//!
//! An orbit is a solution of P^p(x) = x, found by Newton's method with the exact derivative of P
//! through impacts. A bifurcation is a solution of that and of one equation on the multipliers,
//! 1 − tr + det = 0 for a saddle-node and 1 + tr + det = 0 for a period doubling.
//!
//! # Source
//!
//! Kuznetsov, "Elements of Applied Bifurcation Theory", ch. 10; the map is section 3 of the paper.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::strobe_batch::{self, Followed, HarmonicStart, StrobeBatchOptions};
use latchgate_kernel::replay::{Section, State, Strobe};
use latchgate_recording::error::Error;
use serde::Serialize;

/// A lever on sines of one frequency.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForcedLever {
    /// The lever.
    pub design: Design,
    /// Its stop.
    #[serde(rename = "model")]
    pub stop: StopModel,
    /// Acceleration of one g [m/s²].
    pub gravity_m_s2: f64,
    /// ω [rad/s].
    #[serde(rename = "omega_rad_s")]
    pub angular_frequency_rad_s: f64,
}

impl ForcedLever {
    /// Returns the sine of `amplitude_g` [g].
    pub fn sine(&self, amplitude_g: f64) -> Harmonic {
        Harmonic {
            amplitude_m_s2: amplitude_g * self.gravity_m_s2,
            angular_frequency_rad_s: self.angular_frequency_rad_s,
            phase_rad: 0.0,
        }
    }

    /// Returns a strobe of the lever from `state` under a sine of `amplitude_g` [g].
    ///
    /// # Errors
    ///
    /// As [`Strobe::new`].
    pub fn strobe(&self, amplitude_g: f64, state: Option<State>) -> Result<Strobe, Error> {
        Ok(Strobe::new(
            &self.design,
            self.stop,
            &self.sine(amplitude_g),
            state,
        )?)
    }

    /// Returns the options of a batch of such levers, each followed over `periods_max` periods, of which the last
    /// `keep` are kept.
    pub(super) fn batch(
        &self,
        periods_max: u32,
        keep: u32,
        peaks: bool,
        threads: usize,
    ) -> StrobeBatchOptions {
        StrobeBatchOptions {
            stop: self.stop,
            angular_frequency_rad_s: self.angular_frequency_rad_s,
            phase_rad: 0.0,
            periods_max,
            keep: keep as usize,
            peaks,
            threads,
        }
    }

    /// Returns the start of such a lever in a batch: rest unless `initial` says otherwise, under a sine of
    /// `amplitude_g` [g].
    pub(super) fn start(&self, initial: Option<State>, amplitude_g: f64) -> HarmonicStart {
        HarmonicStart {
            initial,
            amplitude_m_s2: self.sine(amplitude_g).amplitude_m_s2,
        }
    }

    /// Follows `count` such levers side by side, each from its [`Self::start`], by the options of
    /// [`Self::batch`].
    pub(super) fn follow(
        &self,
        count: usize,
        start: impl Fn(usize) -> HarmonicStart + Sync,
        options: &StrobeBatchOptions,
        control: &Control<'_>,
    ) -> Result<Vec<Followed>, Error> {
        Ok(strobe_batch::follow(
            &self.design,
            count,
            &start,
            options,
            &|_, _, _| false,
            Some(&|done| (control.proceed)(Some(done as f64 / count as f64))),
        )?)
    }

    /// Returns the amplitude at which a lever at rest leaves the rigid stop [g].
    pub fn lift_off_g(&self) -> f64 {
        let lever = &self.design.lever;
        lever.preload_torque_nm / (lever.unbalance_kg_m() * self.gravity_m_s2)
    }

    /// Returns the size of a change of state [rad], the velocity over ω.
    fn size(&self, change: State) -> f64 {
        let turn = change.velocity_rad_s.abs() / self.angular_frequency_rad_s;
        change.angle_rad.abs().max(turn)
    }

    /// Returns the distance of two states [rad].
    pub fn distance(&self, a: State, b: State) -> f64 {
        self.size(a - b)
    }
}

/// A periodic orbit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Orbit {
    /// Amplitude [g].
    pub amplitude_g: f64,
    /// Period, in periods of the excitation.
    pub period: u32,
    /// State at the start of each period.
    pub points: Vec<State>,
    /// Trace of the map's derivative over the whole orbit.
    pub trace: f64,
    /// Its determinant.
    pub determinant: f64,
    /// Largest angle on the orbit [rad].
    pub peak_angle_rad: f64,
    /// Impacts on it.
    pub impacts: u64,
}

impl Orbit {
    /// Returns the left side of the equation that the multipliers fulfil where the orbit changes.
    pub fn condition(&self, kind: BifurcationKind) -> f64 {
        kind.condition(self.trace, self.determinant)
    }

    /// Returns the multipliers: real and imaginary part of each.
    pub fn multipliers(&self) -> [(f64, f64); 2] {
        let half = 0.5 * self.trace;
        let discriminant = half * half - self.determinant;
        if discriminant < 0.0 {
            let imaginary = (-discriminant).sqrt();
            return [(half, imaginary), (half, -imaginary)];
        }
        // The larger first, the smaller by the product, so that nothing cancels.
        let larger = half + half.signum() * discriminant.sqrt();
        let smaller = if larger == 0.0 {
            0.0
        } else {
            self.determinant / larger
        };
        [(larger, 0.0), (smaller, 0.0)]
    }

    /// Returns the larger modulus of the multipliers: below one the orbit attracts.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers()
            .iter()
            .map(|(re, im)| libm::hypot(*re, *im))
            .fold(0.0, f64::max)
    }
}

/// Kind of a bifurcation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BifurcationKind {
    /// An orbit is born together with an unstable one: a multiplier of +1.
    SaddleNode,
    /// An orbit gives way to one of twice the period: a multiplier of −1.
    PeriodDoubling,
}

impl BifurcationKind {
    fn condition(self, trace: f64, determinant: f64) -> f64 {
        match self {
            Self::SaddleNode => 1.0 - trace + determinant,
            Self::PeriodDoubling => 1.0 + trace + determinant,
        }
    }
}

/// A change of an orbit with the amplitude.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bifurcation {
    /// Its kind.
    pub kind: BifurcationKind,
    /// The orbit at the change.
    pub orbit: Orbit,
}

/// Image of a state after `period` periods, with its derivatives.
struct Image {
    to: State,
    points: Vec<State>,
    /// d(to)/d(from), row by row.
    by_state: [[f64; 2]; 2],
    /// A d(to)/dA.
    by_amplitude: [f64; 2],
    peak_angle_rad: f64,
    impacts: u64,
}

fn image(forced: &ForcedLever, amplitude_g: f64, from: State, period: u32) -> Option<Image> {
    let mut strobe = forced.strobe(amplitude_g, Some(from)).ok()?;
    strobe.start_map();
    let mut image = Image {
        to: from,
        points: Vec::with_capacity(period as usize),
        by_state: [[0.0; 2]; 2],
        by_amplitude: [0.0; 2],
        peak_angle_rad: f64::NEG_INFINITY,
        impacts: 0,
    };
    for _ in 0..period {
        image.points.push(strobe.state());
        let section = strobe.advance()?;
        image.peak_angle_rad = image.peak_angle_rad.max(section.peak_angle_rad);
        image.impacts += section.impacts;
    }
    let map = strobe.map()?;
    (image.to, image.by_state, image.by_amplitude) =
        (strobe.state(), map.by_state, map.by_amplitude);
    Some(image)
}

impl Image {
    fn residual(&self, from: State) -> State {
        self.to - from
    }

    fn trace(&self) -> f64 {
        self.by_state[0][0] + self.by_state[1][1]
    }

    fn determinant(&self) -> f64 {
        let [[a, b], [c, d]] = self.by_state;
        a * d - b * c
    }

    fn condition(&self, kind: BifurcationKind) -> f64 {
        kind.condition(self.trace(), self.determinant())
    }

    fn into_orbit(self, amplitude_g: f64, period: u32) -> Orbit {
        Orbit {
            amplitude_g,
            period,
            trace: self.trace(),
            determinant: self.determinant(),
            points: self.points,
            peak_angle_rad: self.peak_angle_rad,
            impacts: self.impacts,
        }
    }
}

/// Largest number of steps of Newton's method.
pub(super) const STEPS_MAX: u32 = 40;

/// Largest number of steps where an equation on the multipliers is solved as well.
const LOCATE_STEPS_MAX: u32 = 25;

/// Size of a step [rad] at which the method has converged if the next is no smaller.
const CONVERGED: f64 = 1e-11;

/// Longest step [rad]; the derivative is of no use further away.
pub(super) const STEP_MAX: f64 = 0.05;

/// Distance below which two points of an orbit are the same [rad].
const SAME_POINT: f64 = 1e-8;

/// Returns the least period of an orbit, which may have been found as several rounds of a shorter one.
fn least_period(forced: &ForcedLever, orbit: &Orbit) -> u32 {
    (1..orbit.period)
        .filter(|divisor| orbit.period.is_multiple_of(*divisor))
        .find(|divisor| {
            forced.distance(orbit.points[0], orbit.points[*divisor as usize]) <= SAME_POINT
        })
        .unwrap_or(orbit.period)
}

/// Finds the orbit of `period` periods near `guess`, or the shorter one of which it is several rounds; `None` if
/// there is none within reach.
///
/// A superstable orbit, one that rests, is found as well: there the map's derivative is zero and
/// a step is an iteration.
pub fn find(forced: &ForcedLever, amplitude_g: f64, period: u32, guess: State) -> Option<Orbit> {
    find_within(forced, amplitude_g, period, guess, STEPS_MAX, &mut 0)
}

/// As [`find()`], in at most `steps` steps; adds the periods computed to `spent`.
pub(super) fn find_within(
    forced: &ForcedLever,
    amplitude_g: f64,
    period: u32,
    guess: State,
    steps: u32,
    spent: &mut u32,
) -> Option<Orbit> {
    let mut state = guess;
    let mut least = f64::INFINITY;
    for _ in 0..steps {
        *spent = spent.saturating_add(period);
        let image = image(forced, amplitude_g, state, period)?;
        let (f, g) = image.residual(state).into();
        let [[a, b], [c, d]] = image.by_state;
        let (a, d) = (a - 1.0, d - 1.0);
        let determinant = a * d - b * c;
        let step = State::new((b * g - d * f) / determinant, (c * f - a * g) / determinant);
        let size = forced.size(step);
        if !size.is_finite() || size > 1e3 * STEP_MAX {
            return None;
        }
        // Rounding ends the shrinking of the steps.
        if size <= 1e-15 || (least <= CONVERGED && size >= 0.5 * least) {
            let orbit = image.into_orbit(amplitude_g, period);
            let least = least_period(forced, &orbit);
            return if least < period {
                find(forced, amplitude_g, least, orbit.points[0])
            } else {
                Some(orbit)
            };
        }
        least = least.min(size);
        let part = (STEP_MAX / size).min(1.0);
        state.angle_rad += part * step.angle_rad;
        state.velocity_rad_s += part * step.velocity_rad_s;
        if !forced.stop.yields() && state.angle_rad < 0.0 {
            state.angle_rad = 0.0;
        }
    }
    None
}

/// Solves three linear equations by elimination with the largest pivot.
fn solve(mut rows: [[f64; 4]; 3]) -> Option<[f64; 3]> {
    for column in 0..3 {
        let pivot =
            (column..3).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()))?;
        rows.swap(column, pivot);
        let head = rows[column];
        if head[column] == 0.0 || !head[column].is_finite() {
            return None;
        }
        for (index, row) in rows.iter_mut().enumerate() {
            if index != column {
                let factor = row[column] / head[column];
                for (to, from) in row.iter_mut().zip(head) {
                    *to -= factor * from;
                }
            }
        }
    }
    Some([0, 1, 2].map(|n| rows[n][3] / rows[n][n]))
}

/// Finds the bifurcation of the orbit of `period` periods near `guess` and `amplitude_g` [g]; adds
/// the periods computed to `spent`.
///
/// The equation on the multipliers is differentiated by differences, which slows the method down and does not move
/// its solution.
pub(super) fn locate(
    forced: &ForcedLever,
    kind: BifurcationKind,
    period: u32,
    guess: State,
    amplitude_g: f64,
    spent: &mut u32,
) -> Option<Bifurcation> {
    /// Steps of the differences: angle [rad], velocity over ω [rad], relative amplitude.
    const STEP: f64 = 1e-7;
    let omega = forced.angular_frequency_rad_s;
    let (mut state, mut amplitude) = (guess, amplitude_g);
    let mut least = f64::INFINITY;
    for _ in 0..LOCATE_STEPS_MAX {
        *spent = spent.saturating_add(7 * period);
        let current = image(forced, amplitude, state, period)?;
        let (f, g) = current.residual(state).into();
        let condition = |state: State, amplitude: f64| {
            image(forced, amplitude, state, period).map(|image| image.condition(kind))
        };
        let slope = |angle: f64, velocity: f64, strength: f64| -> Option<f64> {
            let towards = |way: f64| {
                let step = way * STEP;
                condition(
                    State::new(
                        state.angle_rad + step * angle,
                        state.velocity_rad_s + step * velocity * omega,
                    ),
                    amplitude * (1.0 + step * strength),
                )
            };
            Some((towards(1.0)? - towards(-1.0)?) / (2.0 * STEP))
        };
        let [[a, b], [c, d]] = current.by_state;
        let [step_angle, step_velocity, step_strength] = solve([
            [a - 1.0, b * omega, current.by_amplitude[0], -f],
            [c, (d - 1.0) * omega, current.by_amplitude[1], -g],
            [
                slope(1.0, 0.0, 0.0)?,
                slope(0.0, 1.0, 0.0)?,
                slope(0.0, 0.0, 1.0)?,
                -current.condition(kind),
            ],
        ])?;
        let size = step_angle
            .abs()
            .max(step_velocity.abs())
            .max(step_strength.abs());
        if !size.is_finite() {
            return None;
        }
        if size <= 1e-15 || (least <= CONVERGED && size >= 0.5 * least) {
            return Some(Bifurcation {
                kind,
                orbit: current.into_orbit(amplitude, period),
            });
        }
        least = least.min(size);
        let part = (0.2 * STEP_MAX / size).min(1.0);
        state.angle_rad += part * step_angle;
        state.velocity_rad_s += part * step_velocity * omega;
        amplitude *= 1.0 + part * step_strength;
    }
    None
}

/// Returns the state after `periods` periods; `None` if the lever can no longer be followed.
///
/// # Errors
///
/// As [`Strobe::new`].
pub fn settle(
    forced: &ForcedLever,
    amplitude_g: f64,
    state: Option<State>,
    periods: u32,
) -> Result<Option<State>, Error> {
    let mut strobe = forced.strobe(amplitude_g, state)?;
    for _ in 0..periods {
        if strobe.advance().is_none() {
            return Ok(None);
        }
    }
    Ok(Some(strobe.state()))
}

/// Returns the period of a settled sequence of sections: the least p with which it repeats
/// itself to `tolerance` [rad]; `None` if none up to a third of its length does.
pub fn period_of(forced: &ForcedLever, sections: &[Section], tolerance: f64) -> Option<u32> {
    (1..=sections.len() / 3)
        .find(|p| {
            sections
                .iter()
                .zip(&sections[*p..])
                .all(|(a, b)| forced.distance(a.state(), b.state()) <= tolerance)
        })
        .and_then(|p| u32::try_from(p).ok())
}

/// Growth of small differences.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Growth {
    /// Mean exponent per period of the excitation, over the periods that did not erase all differences [-].
    pub per_period: f64,
    /// Standard error from means over batches.
    pub standard_error: f64,
    /// Periods followed.
    pub periods: u32,
    /// Periods in which the lever rested.
    pub rests: u32,
    /// Periods after which a trajectory returned to the same bits: rounding has made it repeat itself, and the
    /// exponent is that of the repeated part alone.
    pub returned: Option<u32>,
    /// Largest shrinking over any stretch of periods, in decades [-]; 15 of them erase a difference as large as
    /// the motion.
    pub shrunk_max: f64,
    /// Largest growth over any stretch of periods, in decades [-]; 16 of them make rounding as large as the
    /// motion.
    pub decades_max: f64,
}

impl Growth {
    /// Returns the largest Lyapunov exponent per period. `None` if rest on the stop, or a long contact with a
    /// soft one, erases differences, or if the bits repeat themselves: no exponent then describes the motion.
    pub fn lyapunov(&self) -> Option<f64> {
        (!self.forgets() && self.returned.is_none()).then_some(self.per_period)
    }

    /// Returns true if the motion erases differences of any size that a double holds.
    pub fn forgets(&self) -> bool {
        /// Decades that a double holds.
        const DECADES: f64 = 15.0;
        self.rests > 0 || self.shrunk_max > DECADES
    }

    /// Returns true if rounding stays far below the motion.
    pub fn resolved(&self) -> bool {
        /// Decades of growth that leave four of the fifteen digits of a double.
        const DECADES: f64 = 11.0;
        self.decades_max <= DECADES
    }
}

/// Part of a [`Growth`] that one trajectory adds.
#[derive(Debug, Clone, Default)]
pub(super) struct GrowthSegment {
    logs: Vec<f64>,
    periods: u32,
    rests: u32,
    returned: Option<u32>,
    largest: f64,
    shrunk: f64,
}

/// Follows a small difference over `periods` periods after `transient`; `None` if the lever
/// cannot be followed.
pub(super) fn stretch(
    forced: &ForcedLever,
    amplitude_g: f64,
    state: Option<State>,
    transient: u32,
    periods: u32,
) -> Result<Option<GrowthSegment>, Error> {
    let mut strobe = forced.strobe(amplitude_g, state)?;
    for _ in 0..transient {
        if strobe.advance().is_none() {
            return Ok(None);
        }
    }
    let omega = forced.angular_frequency_rad_s;
    let start = [1.0, omega];
    let mut way = start;
    let (mut sum, mut fall): (f64, f64) = (0.0, 0.0);
    let mut states = Vec::with_capacity(periods as usize);
    let mut segment = GrowthSegment {
        logs: Vec::with_capacity(periods as usize),
        periods,
        ..GrowthSegment::default()
    };
    for _ in 0..periods {
        strobe.start_map();
        let Some(section) = strobe.advance() else {
            return Ok(None);
        };
        let Some(map) = strobe.map() else {
            return Ok(None);
        };
        segment.rests += u32::from(section.rested);
        states.push((
            section.angle_rad.to_bits(),
            section.velocity_rad_s.to_bits(),
        ));
        let [[a, b], [c, d]] = map.by_state;
        let moved = [a * way[0] + b * way[1], c * way[0] + d * way[1]];
        let length = |way: [f64; 2]| libm::hypot(way[0], way[1] / omega);
        let factor = length(moved) / length(way);
        if factor > 0.0 {
            let log = libm::log(factor);
            segment.logs.push(log);
            sum = (sum + log).max(0.0);
            segment.largest = segment.largest.max(sum);
            fall = (fall - log).max(0.0);
            segment.shrunk = segment.shrunk.max(fall);
            let scale = 1.0 / length(moved);
            way = moved.map(|part| part * scale);
        } else {
            (sum, fall) = (0.0, 0.0);
            way = start;
        }
    }
    // The same bits are followed by the same motion, so the trajectory repeats itself from here on.
    if let Some((last, before)) = states.split_last() {
        let ago = before.iter().rev().position(|state| state == last);
        segment.returned = ago.and_then(|ago| u32::try_from(ago + 1).ok());
    }
    Ok(Some(segment))
}

/// Combines trajectories.
pub(super) fn growth(stretches: &[GrowthSegment]) -> Option<Growth> {
    /// Batches of each trajectory, for the standard error.
    const BATCHES: usize = 10;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let logs: Vec<f64> = stretches
        .iter()
        .flat_map(|segment| segment.logs.clone())
        .collect();
    if logs.is_empty() {
        return None;
    }
    let mean_log = mean(&logs);
    let batches: Vec<f64> = stretches
        .iter()
        .flat_map(|segment| {
            segment
                .logs
                .chunks(segment.logs.len().div_ceil(BATCHES).max(1))
        })
        .map(mean)
        .collect();
    let spread: f64 = batches
        .iter()
        .map(|batch| (batch - mean_log) * (batch - mean_log))
        .sum();
    let count = batches.len() as f64;
    Some(Growth {
        per_period: mean_log,
        standard_error: (spread / (count * (count - 1.0).max(1.0))).sqrt(),
        periods: stretches.iter().map(|segment| segment.periods).sum(),
        rests: stretches.iter().map(|segment| segment.rests).sum(),
        returned: stretches.iter().find_map(|segment| segment.returned),
        shrunk_max: stretches
            .iter()
            .map(|segment| segment.shrunk / std::f64::consts::LN_10)
            .fold(0.0, f64::max),
        decades_max: stretches
            .iter()
            .map(|segment| segment.largest / std::f64::consts::LN_10)
            .fold(0.0, f64::max),
    })
}

/// Measures the growth of small differences over `periods` periods after `transient`; `None` if the lever cannot be
/// followed, or if every period erases all differences.
///
/// # Errors
///
/// As [`Strobe::new`].
///
/// # Source
///
/// Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980) 9, with saltation at impacts:
/// Müller, Chaos, Solitons & Fractals 5 (1995) 1671.
pub fn difference_growth(
    forced: &ForcedLever,
    amplitude_g: f64,
    state: Option<State>,
    transient: u32,
    periods: u32,
) -> Result<Option<Growth>, Error> {
    let segment = stretch(forced, amplitude_g, state, transient, periods)?;
    Ok(segment.and_then(|segment| growth(&[segment])))
}
