//! The kernel's fast lane in contact: whole samples in which the lever stays in the soft stop.
//!
//! In contact the equation is linear but for cos φ, and φ is small: with cos φ = 1 − (1 − cos φ)
//! the small part acts like an excitation of its own, d = b (1 − cos φ). The linear part of a
//! sample is an exact propagator; what d adds is the convolution of d with the impulse response,
//! by Gauss's quadrature over the sample, on the linear motion first and, if that is not enough,
//! once more on the motion it gives. What acts across adds −r sin φ to d, and further rounds.
//!
//! # Source
//!
//! Variation of constants (Duhamel's integral); the bound on the acceleration within a sample is
//! the decay of the energy of a damped oscillator, which the acceleration itself is, driven by the
//! excitation's second derivative.

#![expect(
    clippy::needless_range_loop,
    reason = "in code compiled for the machine's vectors adaptors such as zip stay calls"
)]

use super::kernel::Kernel;
use super::sensitivity::{Smooths, StateMap};
use super::taylor::{AngleSlope, Branch, Tolerance};
use crate::signal::{CURVED, Mix, Pieces, bend_at_most, value};
use std::ops::{Add, Mul, Sub};

/// Largest phase of the stop's own oscillation in a sample [-]: up to here, and up to as large a damping,
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
    let mut outer = 0;
    while outer < POINTS {
        let mut inner = 0;
        while inner < POINTS {
            let place = places[outer] * places[inner];
            let mut node = 0;
            while node < POINTS {
                shapes[outer][inner][node] = shape(node, place);
                node += 1;
            }
            inner += 1;
        }
        outer += 1;
    }
    shapes
};

/// The value at a place of the polynomial that is one at a point and zero at the others.
const fn shape(point: usize, place: f64) -> f64 {
    let places = PLACES.0;
    let mut value = 1.0;
    let mut other = 0;
    while other < POINTS {
        if other != point {
            value *= (place - places[other]) / (places[point] - places[other]);
        }
        other += 1;
    }
    value
}

/// A number at each point. Its operations have no closures, which would not be compiled for the machine's
/// vectors.
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
    fn add(mut self, other: Self) -> Self {
        for n in 0..POINTS {
            self.0[n] += other.0[n];
        }
        self
    }
}

impl Sub for Eight {
    type Output = Self;

    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for n in 0..POINTS {
            self.0[n] -= other.0[n];
        }
        self
    }
}

impl Mul for Eight {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for n in 0..POINTS {
            self.0[n] *= other.0[n];
        }
        self
    }
}

impl Mul<f64> for Eight {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, other: f64) -> Self {
        for a in &mut self.0 {
            *a *= other;
        }
        self
    }
}

/// What a unit of each does in part of a sample, to angle and slope, of x'' = −damping x' − stiffness x +
/// acceleration.
#[derive(Debug, Clone, Copy)]
struct StepResponse<const K: usize> {
    /// Of the angle at the start.
    to_angle: AngleSlope,
    /// Of the slope: the impulse response and its derivative.
    to_slope: AngleSlope,
    /// Of an acceleration that is a power of the part of the sample.
    to_powers: [AngleSlope; K],
}

impl<const K: usize> StepResponse<K> {
    /// At `part` of a sample.
    fn at(stiffness: f64, damping: f64, part: f64) -> Self {
        // The impulse response; the others are its derivative and integrals.
        let x = impulse_response(stiffness, damping, part);
        let integrals = integrals::<K>(x, part);
        let terms = x.iter().enumerate().rev();
        let rate = terms.fold(0.0, |sum, (j, x)| sum + j as f64 * x) / part;
        let impulse = integrals[0];
        let mut factorial = 1.0;
        let to_powers = std::array::from_fn(|n| {
            factorial *= n.max(1) as f64;
            AngleSlope::new(factorial * integrals[n + 1], factorial * integrals[n])
        });
        Self {
            to_angle: AngleSlope::new(rate + damping * impulse, -stiffness * impulse),
            to_slope: AngleSlope::new(impulse, rate),
            to_powers,
        }
    }
}

/// Returns a series over a part of a sample, and its first to K-th integrals there, from its `terms`.
fn integrals<const K: usize>(mut terms: [f64; TERMS as usize], part: f64) -> [f64; CURVED + 1] {
    let mut integrals = [0.0; CURVED + 1];
    for (times, integral) in integrals[..=K].iter_mut().enumerate() {
        if times > 0 {
            // n times integrated a power j of the part is divided by j+1 … j+n.
            for (j, term) in terms.iter_mut().enumerate() {
                *term *= part * INVERSE[j + times];
            }
        }
        // From the small to the large.
        *integral = terms.iter().rev().fold(0.0, |sum, term| sum + term);
    }
    integrals
}

/// Terms of a series over a sample: 2.8^32/32! is below 1e-21.
const TERMS: u8 = 32;

/// 1/n.
const INVERSE: [f64; TERMS as usize + CURVED + 2] = {
    let mut table = [0.0; TERMS as usize + CURVED + 2];
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

/// Rounds on the motion that what acts across bends, at most: each leaves a thousandth or less of what is
/// neglected.
const ROUNDS_MAX: u64 = 6;

/// What acts across in a sample, r, with time in sample intervals.
struct Turning<const K: usize> {
    terms: [f64; K],
    /// Largest size.
    strongest: f64,
}

impl<const K: usize> Default for Turning<K> {
    fn default() -> Self {
        Self {
            terms: [0.0; K],
            strongest: 0.0,
        }
    }
}

/// The propagator of a sample in contact, with time in sample intervals, under an excitation of `K` terms.
#[derive(Debug, Clone)]
pub(super) struct FastContact<const K: usize> {
    /// Sample interval [s].
    interval: f64,
    pressing: f64,
    damping: f64,
    stiffness: f64,
    /// At most, what an acceleration's rate of change at the start does to it in a sample.
    softness: f64,
    /// Recorded accelerations to b, and to r of what acts across.
    along: Mix,
    across: Mix,
    tolerance: Tolerance,
    end: StepResponse<K>,
    /// Powers of the nodes.
    nodes: [Eight; K],
    /// Responses of the angle at the nodes: to angle, slope and each power of the excitation.
    angle: Eight,
    slope: Eight,
    powers: [Eight; K],
    /// Weights of d in the angle and the slope at the end.
    angle_weights: Eight,
    slope_weights: Eight,
    /// What d at each node does to the angle at all nodes.
    mutual: [Eight; POINTS],
    /// What the samples carried along together do to a deviation.
    map: StateMap,
}

/// What d at each node does to the angle at all nodes, through the polynomial that d's values there define.
fn mutual_weights(stiffness: f64, damping: f64) -> [Eight; POINTS] {
    let (nodes, weights) = PLACES;
    let mut mutual = [Eight::splat(0.0); POINTS];
    for (at, reach) in nodes.iter().enumerate() {
        let remaining = Eight(nodes.map(|node| reach * (1.0 - node)));
        let responses = impulse_responses(stiffness, damping, remaining).0;
        for (inner, (shapes, response)) in SHAPES[at].iter().zip(responses).enumerate() {
            for (column, shape) in mutual.iter_mut().zip(shapes) {
                column.0[at] += reach * weights[inner] * shape * response;
            }
        }
    }
    mutual
}

impl<const K: usize> FastContact<K> {
    /// Builds the propagator for samples of `interval` [s] of accelerations of which these mixtures act along
    /// and across; `None` where a sample is too long for it, or so short that it does not pay.
    pub(super) fn new(kernel: &Kernel, interval: f64, along: Mix, across: Mix) -> Option<Self> {
        let Branch {
            pressing,
            damping,
            stiffness,
        } = *kernel.contact_branch()?;
        let square = interval * interval;
        let (scaled_damping, scaled) = (damping * interval, stiffness * square);
        let phase = scaled.sqrt();
        if !(PHASE_MIN..=PHASE_MAX).contains(&phase) || !(0.0..=PHASE_MAX).contains(&scaled_damping)
        {
            return None;
        }
        let (nodes, weights) = PLACES;
        let respond = |part: f64| StepResponse::<K>::at(scaled, scaled_damping, part);
        let at: [StepResponse<K>; POINTS] = nodes.map(respond);
        let from = nodes.map(|node| respond(1.0 - node));
        let lanes = |value: &dyn Fn(usize) -> f64| Eight(std::array::from_fn(value));
        let power = |n: usize, node: usize| (0..n).fold(1.0, |power, _| power * nodes[node]);
        Some(Self {
            interval,
            pressing: pressing * square,
            damping: scaled_damping,
            stiffness: scaled,
            softness: 1.0 / phase,
            along: along.times(kernel.gain()).times(square),
            across: across.times(kernel.gain()).times(square),
            tolerance: kernel.tolerance(),
            end: respond(1.0),
            nodes: std::array::from_fn(|n| lanes(&|node| power(n, node))),
            angle: lanes(&|node| at[node].to_angle.angle),
            slope: lanes(&|node| at[node].to_slope.angle),
            powers: std::array::from_fn(|n| lanes(&|node| at[node].to_powers[n].angle)),
            angle_weights: lanes(&|node| weights[node] * from[node].to_slope.angle),
            slope_weights: lanes(&|node| weights[node] * from[node].to_slope.slope),
            mutual: mutual_weights(scaled, scaled_damping),
            map: StateMap::oscillator(stiffness, damping, f64::from(TOGETHER) * interval),
        })
    }

    /// Carries the lever through the intervals of `pieces` from `first` to `last` until one may hold an
    /// event; returns how many it has taken.
    #[inline(always)]
    pub(super) fn press(
        &self,
        kernel: &mut Kernel,
        pieces: &Pieces<'_, K>,
        first: usize,
        last: usize,
    ) -> usize {
        if !kernel.is_pressed() {
            return 0;
        }
        match pieces.second() {
            Some(across) => self.press_by::<true>(kernel, (pieces, &across), first, last),
            None => self.press_by::<false>(kernel, (pieces, pieces), first, last),
        }
    }

    /// The same under what acts along and, where `ACROSS`, across.
    #[inline(always)]
    fn press_by<const ACROSS: bool>(
        &self,
        kernel: &mut Kernel,
        (pieces, across): (&Pieces<'_, K>, &Pieces<'_, K>),
        first: usize,
        last: usize,
    ) -> usize {
        let (mut angle, mut slope) = (kernel.angle, kernel.velocity * self.interval);
        let error = kernel.error_soon(0.0);
        let (peak, threshold, above) = kernel.recorder.awaits(2.0 * error);
        if threshold <= 0.0 || above {
            return 0;
        }
        // A turn above the peak so far, or φ = 0.
        let ceiling = peak.min(0.0);
        let mut samples = 0;
        let mut gathered = Smooths::default();
        let mut twice = 0;
        for index in first..last {
            let piece = pieces.of(index);
            let other = if ACROSS { across.of(index) } else { piece };
            let (b, strongest) = if ACROSS {
                self.along.of(&piece, &other)
            } else {
                let Mix { own, offset, .. } = self.along;
                (piece.scaled(own, offset), piece.strongest(own, offset))
            };
            let driven = bend_at_most(&b);
            let push = self.pressing + b[0];
            // The acceleration is a damped oscillator of its own.
            let bent = push + self.damping * slope + self.stiffness * angle;
            let bent_rate = b[1] - self.damping * bent + self.stiffness * slope;
            let bend = bent.abs() + bent_rate.abs() * self.softness + 0.5 * driven;
            let mut curve = 1.01 * bend + 1e-5 * strongest;
            let mut turning = Turning::<K>::default();
            if ACROSS {
                (turning.terms, turning.strongest) = self.across.of(&other, &piece);
                // Directly, and by the stop's answer to it.
                curve += 4.0 * turning.strongest * (angle.abs() + slope.abs() + curve);
            }
            let reach = angle.abs() + slope.abs() + curve;
            let square = reach * reach;
            let moves = angle.abs() + slope.abs();
            let allowed = self.tolerance.of(moves);
            let mut linear = self.angle * angle + self.slope * slope - self.powers[0] * push;
            for n in 1..K {
                linear = linear - self.powers[n] * b[n];
            }
            let excitation = self.at_nodes(&b);
            let mut small = excitation * lessened(linear);
            // What the first and the second quadrature still neglect.
            let mut tail = 0.125 * strongest * square * square;
            if ACROSS {
                let acting = self.at_nodes(&turning.terms);
                small = small + acting * sine(linear);
                // A motion so far from the true one is followed by one that is `bent` times as far.
                let bent = strongest * reach + turning.strongest;
                tail = bent * (0.25 * strongest * square + 0.5 * turning.strongest * reach);
                let mut round = 0;
                while tail > allowed && round < ROUNDS_MAX {
                    let moved = self.moved(linear, small);
                    small = excitation * lessened(moved) + acting * sine(moved);
                    tail *= bent;
                    round += 1;
                }
                if tail > allowed || tail.is_nan() {
                    break;
                }
                twice += round;
            } else if tail > allowed {
                tail = 0.0625 * strongest * square * square * square;
                if tail > allowed {
                    break;
                }
                small = excitation * lessened(self.moved(linear, small));
                twice += 1;
            }
            let after = self.after(AngleSlope { angle, slope }, push, &b, small);
            // Between the ends it cannot rise above them by more than an eighth of its bend.
            if angle.max(after.angle) + 0.125 * curve >= ceiling || after.angle.is_nan() {
                break;
            }
            let middle = value(&b, 0.5);
            let size = angle.abs() + slope.abs() + push.abs() + b[1].abs() + driven;
            let slope_size = size + self.stiffness * angle.abs();
            gathered.stiffness += self.stiffness - middle * angle;
            gathered.push += middle;
            if ACROSS {
                let middle = value(&turning.terms, 0.5);
                gathered.stiffness -= middle;
                gathered.push -= middle * angle;
            }
            gathered.angle_square += size * size;
            gathered.velocity_square += slope_size * slope_size;
            gathered.truncation += tail;
            gathered.count += 1;
            AngleSlope { angle, slope } = after;
            samples += 1;
            if kernel.recorder.trace.is_some() {
                let time = pieces.signal.time_s(first + samples);
                kernel.recorder.point(time, angle, slope / self.interval);
            }
            if gathered.count == TOGETHER {
                kernel.take_pressed_error(&self.in_seconds(&gathered), &self.map);
                gathered = Smooths::default();
            }
        }
        if samples > 0 {
            kernel.take_error(&self.in_seconds(&gathered));
            kernel.put_pressed(angle, slope / self.interval);
            kernel.work.steps += samples as u64;
            kernel.work.rhs += samples as u64 + twice;
        }
        samples
    }

    /// Returns a polynomial's values at the nodes.
    #[inline(always)]
    fn at_nodes(&self, terms: &[f64; K]) -> Eight {
        let mut values = Eight::splat(terms[0]);
        for n in 1..K {
            values = values + self.nodes[n] * terms[n];
        }
        values
    }

    /// Returns the motion at the nodes that the linear one and `small` there make.
    #[inline(always)]
    fn moved(&self, linear: Eight, small: Eight) -> Eight {
        let mut moved = linear;
        for n in 0..POINTS {
            moved = moved + self.mutual[n] * small.0[n];
        }
        moved
    }

    /// Returns angle and slope at the end of a sample that begins with the acceleration `push`, of which
    /// `small` is what is left out at the nodes.
    #[inline(always)]
    fn after(
        &self,
        AngleSlope { angle, slope }: AngleSlope,
        push: f64,
        b: &[f64; K],
        small: Eight,
    ) -> AngleSlope {
        let (to_angle, to_slope, to_powers) =
            (&self.end.to_angle, &self.end.to_slope, &self.end.to_powers);
        let mut forced = AngleSlope::new(to_powers[0].angle * push, to_powers[0].slope * push);
        for n in 1..K {
            forced.angle += to_powers[n].angle * b[n];
            forced.slope += to_powers[n].slope * b[n];
        }
        let kept = AngleSlope::new(
            to_angle.angle * angle + to_slope.angle * slope,
            to_angle.slope * angle + to_slope.slope * slope,
        );
        AngleSlope::new(
            kept.angle - forced.angle + sum(self.angle_weights * small),
            kept.slope - forced.slope + sum(self.slope_weights * small),
        )
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
            truncation_velocity: gathered.truncation_velocity * per_second,
            ..*gathered
        }
    }
}

/// 1 − cos of small angles: the next term is below 1e-20 up to 2e-3 rad, and stated where deeper.
#[inline(always)]
fn lessened(angle: Eight) -> Eight {
    let square = angle * angle;
    square * (Eight::splat(0.5) - square * (1.0 / 24.0))
}

/// Sine of small angles, as good.
#[inline(always)]
fn sine(angle: Eight) -> Eight {
    let square = angle * angle;
    angle * (Eight::splat(1.0) - square * (Eight::splat(1.0 / 6.0) - square * (1.0 / 120.0)))
}

/// The lanes' sum, always in the same order.
#[inline(always)]
fn sum(Eight(x): Eight) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}
