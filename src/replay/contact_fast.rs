//! The kernel's fast lane in contact: whole samples in which the lever stays in the soft stop.
//!
//! In contact the equation is linear but for cos φ, and φ is small: with cos φ = 1 − (1 − cos φ)
//! the small part acts like an excitation of its own, d = b (1 − cos φ). The linear part of a
//! sample is an exact propagator; what d adds is the convolution of d with the impulse response,
//! by Gauss's quadrature over the sample, on the linear motion first and, if that is not enough,
//! once more on the motion it gives.
//!
//! # Source
//!
//! Variation of constants (Duhamel's integral); the bound on the acceleration within a sample is
//! the decay of the energy of a damped oscillator, which the acceleration itself is under an
//! excitation that is linear in time.

use super::kernel::Kernel;
use super::sensitivity::{Smooths, StateMap};
use super::taylor::Branch;
use crate::conditioning::Signal;
use std::ops::{Add, Mul, Sub};

/// Largest phase of the stop's own oscillation in a sample, and largest damping [-]: up to here
/// the quadrature is exact to 1e-13 of d.
pub(super) const PHASE_MAX: f64 = 2.0;

/// Smallest phase: below it a step by series is as cheap.
const PHASE_MIN: f64 = 0.02;

/// Samples whose error is carried along together.
const TOGETHER: u32 = 16;

/// Nodes of Gauss's quadrature with eight points on -1..1, the positive half, and their weights
/// (Abramowitz and Stegun, table 25.4).
const NODES: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// Points of the quadrature.
const POINTS: usize = 8;

/// Places of the points in a sample, in rising order, and their weights.
const PLACES: ([f64; POINTS], [f64; POINTS]) = {
    let (mut places, mut weights) = ([0.0; POINTS], [0.0; POINTS]);
    let mut n = 0;
    while n < NODES.len() {
        let (node, weight) = NODES[n];
        (places[3 - n], places[4 + n]) = (0.5 - 0.5 * node, 0.5 + 0.5 * node);
        (weights[3 - n], weights[4 + n]) = (0.5 * weight, 0.5 * weight);
        n += 1;
    }
    (places, weights)
};

/// For the quadrature from the sample's start to each point, at each point of that shorter
/// stretch: the value there of the polynomial that is one at a point and zero at all others.
static SHAPES: [[[f64; POINTS]; POINTS]; POINTS] = {
    let places = PLACES.0;
    let mut shapes = [[[1.0; POINTS]; POINTS]; POINTS];
    let mut at = 0;
    while at < POINTS {
        let mut inner = 0;
        while inner < POINTS {
            let place = places[at] * places[inner];
            let mut node = 0;
            while node < POINTS {
                let mut other = 0;
                while other < POINTS {
                    if other != node {
                        shapes[at][inner][node] *=
                            (place - places[other]) / (places[node] - places[other]);
                    }
                    other += 1;
                }
                node += 1;
            }
            inner += 1;
        }
        at += 1;
    }
    shapes
};

/// A number at each point.
#[derive(Debug, Clone, Copy)]
struct Eight([f64; POINTS]);

impl Eight {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; POINTS])
    }
}

impl Add for Eight {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|n| self.0[n] + other.0[n]))
    }
}

impl Sub for Eight {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|n| self.0[n] - other.0[n]))
    }
}

impl Mul for Eight {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|n| self.0[n] * other.0[n]))
    }
}

impl Mul<f64> for Eight {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        Self(self.0.map(|a| a * other))
    }
}

/// What a state and an excitation have become: factors of the angle, the slope, a constant and a
/// linear excitation of unit size, each against the angle and the slope.
#[derive(Debug, Clone, Copy)]
struct StepResponse {
    /// Of a unit angle: angle and slope.
    angle: (f64, f64),
    /// Of a unit slope: the impulse response and its derivative.
    slope: (f64, f64),
    /// Of a unit acceleration.
    constant: (f64, f64),
    /// Of an acceleration that grows by one per sample.
    linear: (f64, f64),
}

impl StepResponse {
    /// At `part` of a sample, of x'' = −damping x' − stiffness x + acceleration.
    fn at(stiffness: f64, damping: f64, part: f64) -> Self {
        // The impulse response; the others are its derivative and integrals.
        let x = impulse_response(stiffness, damping, part);
        // From the small to the large.
        let (mut impulse, mut once, mut twice, mut rate) = (0.0, 0.0, 0.0, 0.0);
        let mut order = f64::from(TERMS);
        for ((x, one), two) in x.iter().zip(&INVERSE[1..]).zip(&INVERSE[2..]).rev() {
            order -= 1.0;
            impulse += x;
            rate += order * x;
            once += x * one;
            twice += x * one * two;
        }
        let (rate, once, twice) = (rate / part, once * part, twice * part * part);
        Self {
            angle: (rate + damping * impulse, -stiffness * impulse),
            slope: (impulse, rate),
            constant: (once, impulse),
            linear: (twice, once),
        }
    }
}

/// Terms of a series over a sample: 2.8^32/32! is below 1e-21.
const TERMS: u8 = 32;

/// 1/n.
const INVERSE: [f64; TERMS as usize + 2] = {
    let mut table = [0.0; TERMS as usize + 2];
    let mut n = 1;
    while n < table.len() {
        table[n] = 1.0 / n as f64;
        n += 1;
    }
    table
};

/// Terms of the answer at `part` of a sample to a unit slope at its start.
fn impulse_response(stiffness: f64, damping: f64, part: f64) -> [f64; TERMS as usize] {
    let mut x = [0.0; TERMS as usize];
    x[1] = part;
    let (first, second) = (-damping * part, -stiffness * part * part);
    for n in 2..x.len() {
        x[n] = (first * x[n - 1] + second * x[n - 2] * INVERSE[n - 1]) * INVERSE[n];
    }
    x
}

/// The answers at eight parts of a sample, side by side.
fn impulse_responses(stiffness: f64, damping: f64, parts: Eight) -> Eight {
    let mut x = [Eight::splat(0.0); TERMS as usize];
    x[1] = parts;
    let (first, second) = (parts * -damping, parts * -stiffness * parts);
    for n in 2..x.len() {
        x[n] = (first * x[n - 1] + second * x[n - 2] * INVERSE[n - 1]) * INVERSE[n];
    }
    // From the small to the large.
    let largest_last = x.iter().rev();
    largest_last.fold(Eight::splat(0.0), |sum, term| sum + *term)
}

/// The propagator of a sample in contact, with time in sample intervals.
#[derive(Debug, Clone)]
pub(super) struct FastContact {
    /// Sample interval [s].
    interval: f64,
    pressing: f64,
    damping: f64,
    stiffness: f64,
    /// 1/√stiffness.
    softness: f64,
    /// Recorded acceleration to b: factor and offset.
    gain: f64,
    offset: f64,
    tolerance: (f64, f64),
    end: StepResponse,
    /// Nodes and the responses there.
    nodes: Eight,
    angle: Eight,
    slope: Eight,
    constant: Eight,
    linear: Eight,
    /// Weights of d in the angle and the slope at the end.
    angle_weights: Eight,
    slope_weights: Eight,
    /// What d at each node does to the angle at all nodes.
    mutual: [Eight; POINTS],
    /// What the samples carried along together do to a deviation.
    map: StateMap,
}

impl FastContact {
    /// Builds the propagator for samples of `interval` [s] of accelerations that count `scale`
    /// times, with `bias` [m/s²] added; `None` where a sample is too long for it, or so short that it does not pay.
    pub(super) fn new(kernel: &Kernel, interval: f64, scale: f64, bias: f64) -> Option<Self> {
        let Branch {
            pressing,
            damping,
            stiffness,
        } = *kernel.contact_branch()?;
        let square = interval * interval;
        let (scaled_damping, scaled) = (damping * interval, stiffness * square);
        let phase = scaled.sqrt();
        if !(PHASE_MIN..=PHASE_MAX).contains(&phase) || scaled_damping > PHASE_MAX {
            return None;
        }
        let (nodes, weights) = PLACES;
        let respond = |part: f64| StepResponse::at(scaled, scaled_damping, part);
        let at: [StepResponse; POINTS] = nodes.map(respond);
        let from: [StepResponse; POINTS] = nodes.map(|node| respond(1.0 - node));
        let lanes = |value: &dyn Fn(usize) -> f64| Eight(std::array::from_fn(value));
        // Through the polynomial that d's values at the nodes define.
        let mut mutual = [Eight::splat(0.0); POINTS];
        for (at, reach) in nodes.iter().enumerate() {
            let left = Eight(nodes.map(|node| reach * (1.0 - node)));
            let responses = impulse_responses(scaled, scaled_damping, left).0;
            for (inner, (shapes, response)) in SHAPES[at].iter().zip(responses).enumerate() {
                for (column, shape) in mutual.iter_mut().zip(shapes) {
                    column.0[at] += reach * weights[inner] * shape * response;
                }
            }
        }
        Some(Self {
            interval,
            pressing: pressing * square,
            damping: scaled_damping,
            stiffness: scaled,
            softness: 1.0 / phase,
            gain: scale * kernel.gain() * square,
            offset: bias * kernel.gain() * square,
            tolerance: kernel.truncation(),
            end: respond(1.0),
            nodes: Eight(nodes),
            angle: lanes(&|node| at[node].angle.0),
            slope: lanes(&|node| at[node].slope.0),
            constant: lanes(&|node| at[node].constant.0),
            linear: lanes(&|node| at[node].linear.0),
            angle_weights: lanes(&|node| weights[node] * from[node].slope.0),
            slope_weights: lanes(&|node| weights[node] * from[node].slope.1),
            mutual,
            map: StateMap::oscillator(stiffness, damping, f64::from(TOGETHER) * interval),
        })
    }

    /// Carries the lever through the intervals between the samples of `signal` from `first` to
    /// `last` until one may hold an event; returns how many it has taken.
    #[inline(always)]
    pub(super) fn press(
        &self,
        kernel: &mut Kernel,
        signal: &Signal,
        first: usize,
        last: usize,
    ) -> usize {
        if !kernel.is_pressed() {
            return 0;
        }
        let (mut angle, velocity) = kernel.state();
        let mut slope = velocity * self.interval;
        let error = kernel.error_soon(0.0);
        let (peak, threshold, above) = kernel.recorder.awaits(2.0 * error);
        if threshold <= 0.0 || above {
            return 0;
        }
        // A turn above the peak so far, or φ = 0.
        let ceiling = peak.min(0.0);
        let mut taken = 0;
        let mut gathered = Smooths::default();
        let mut twice = 0;
        let mut b0 = self.gain.mul_add(signal.samples[first], self.offset);
        for sample in &signal.samples[first + 1..=last] {
            let next = self.gain.mul_add(*sample, self.offset);
            let (b1, strongest) = (next - b0, b0.abs().max(next.abs()));
            let push = self.pressing + b0;
            // The acceleration is a damped oscillator of its own.
            let bent = push + self.damping * slope + self.stiffness * angle;
            let bent_rate = b1 - self.damping * bent + self.stiffness * slope;
            let curve = 1.01 * (bent.abs() + bent_rate.abs() * self.softness) + 1e-5 * strongest;
            let reach = angle.abs() + slope.abs() + curve;
            let square = reach * reach;
            let allowed = self
                .tolerance
                .0
                .max(self.tolerance.1 * (angle.abs() + slope.abs()));
            // What the first and the second quadrature still neglect.
            let neglected = (
                0.125 * strongest * square * square,
                0.0625 * strongest * square * square * square,
            );
            let linear =
                self.angle * angle + self.slope * slope - self.constant * push - self.linear * b1;
            let excitation = self.nodes * b1 + Eight::splat(b0);
            let mut small = excitation * lessened(linear);
            let mut tail = neglected.0;
            if tail > allowed {
                tail = neglected.1;
                if tail > allowed {
                    break;
                }
                let mut moved = linear;
                for (column, small) in self.mutual.iter().zip(small.0) {
                    moved = moved + *column * small;
                }
                small = excitation * lessened(moved);
                twice += 1;
            }
            let after = self.end.angle.0 * angle + self.end.slope.0 * slope
                - self.end.constant.0 * push
                - self.end.linear.0 * b1
                + sum(self.angle_weights * small);
            let slope_after = self.end.angle.1 * angle + self.end.slope.1 * slope
                - self.end.constant.1 * push
                - self.end.linear.1 * b1
                + sum(self.slope_weights * small);
            // Between the ends it cannot rise above them by more than an eighth of its bend.
            if angle.max(after) + 0.125 * curve >= ceiling || after.is_nan() {
                break;
            }
            let middle = b0 + 0.5 * b1;
            let size = angle.abs() + slope.abs() + push.abs() + b1.abs();
            let slope_size = size + self.stiffness * angle.abs();
            gathered.stiffness += self.stiffness - middle * angle;
            gathered.push += middle;
            gathered.angle_square += size * size;
            gathered.velocity_square += slope_size * slope_size;
            gathered.truncation += tail;
            gathered.count += 1;
            (angle, slope, b0) = (after, slope_after, next);
            taken += 1;
            if kernel.recorder.trace.is_some() {
                let time = signal.time_s(first + taken);
                kernel.recorder.point(time, angle, slope / self.interval);
            }
            if gathered.count == TOGETHER {
                kernel.take_pressed_error(&self.in_seconds(&gathered), &self.map);
                gathered = Smooths::default();
            }
        }
        if taken > 0 {
            kernel.take_error(&self.in_seconds(&gathered));
            kernel.put_pressed(angle, slope / self.interval);
            kernel.work.steps += taken as u64;
            kernel.work.rhs += taken as u64 + twice;
        }
        taken
    }

    /// Takes what was gathered in samples' time to seconds.
    #[inline(always)]
    fn in_seconds(&self, gathered: &Smooths) -> Smooths {
        let per_second = 1.0 / self.interval;
        Smooths {
            time: f64::from(gathered.count) * self.interval,
            stiffness: gathered.stiffness * per_second,
            push: gathered.push * per_second,
            velocity_square: gathered.velocity_square * per_second * per_second,
            ..*gathered
        }
    }
}

/// 1 − cos of small angles: the next term is below 1e-20 up to 2e-3 rad.
#[inline(always)]
fn lessened(angle: Eight) -> Eight {
    let square = angle * angle;
    square * (Eight::splat(0.5) - square * (1.0 / 24.0))
}

/// The lanes' sum, always in the same order.
#[inline(always)]
fn sum(Eight(x): Eight) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}
