//! The kernel's fast lane in contact: whole samples in which the lever stays in the soft stop.
//!
//! In contact the equation is linear but for cos φ, and φ is small: with cos φ = 1 − (1 − cos φ)
//! the small part acts like an excitation of its own, d = b (1 − cos φ). The linear part of a
//! sample is an exact propagator; what d adds is the convolution of d with the impulse response,
//! by Gauss's quadrature over the sample, on the linear motion first and, if that is not enough,
//! once more on the motion it gives. Where the damping lasts a fraction of a sample, the response
//! comes from two exponentials, the weights of d from stretches as short as the damping, and one
//! pass is enough: what it neglects is stated.
//!
//! # Source
//!
//! Variation of constants (Duhamel's integral); the bound on the acceleration within a sample is
//! the decay of the energy of a damped oscillator, which the acceleration itself is under an
//! excitation that is linear in time.

use super::kernel::Kernel;
use super::sensitivity::{Smooths, StateMap};
use super::taylor::Branch;
use crate::signal::Signal;
use std::ops::{Add, Mul, Sub};

/// Largest phase of the stop's own oscillation in a sample [-]: up to here, and up to as large a damping,
/// the quadrature is exact to 1e-13 of d.
pub(super) const PHASE_MAX: f64 = 2.0;

/// Damping in a part of a sample [-] up to which the series of a response is summed as it is.
const SERIES_DAMPING_MAX: f64 = 2.0;

/// Damping in a part of a sample [-] up to which a response is that of half the part, twice; beyond it the
/// stop is overdamped, whatever its phase, and its two exponentials are far apart.
const DOUBLED_DAMPING_MAX: f64 = 16.0;

/// Largest damping of a sample [-]; more of it makes a sample in which the lever leaves the stop too long.
const DAMPING_MAX: f64 = 8000.0;

/// Largest part of angle and slope that a strongly damped sample may neglect; what it does is stated.
const NEGLECTED_PART: f64 = 1e-14;

/// Smallest phase: below it a step by series is as cheap, but in a strongly damped stop.
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
                shapes[at][inner][node] = shape(node, place);
                node += 1;
            }
            inner += 1;
        }
        at += 1;
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
        if damping * part <= SERIES_DAMPING_MAX {
            Self::by_series(stiffness, damping, part)
        } else if damping * part <= DOUBLED_DAMPING_MAX {
            Self::at(stiffness, damping, 0.5 * part).twice(0.5 * part)
        } else {
            Self::overdamped(stiffness, damping, part)
        }
    }

    fn by_series(stiffness: f64, damping: f64, part: f64) -> Self {
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

    /// After the same stretch of `part` once more.
    fn twice(&self, part: f64) -> Self {
        let mapped = |(angle, slope): (f64, f64)| {
            (
                self.angle.0 * angle + self.slope.0 * slope,
                self.angle.1 * angle + self.slope.1 * slope,
            )
        };
        let plus = |a: (f64, f64), b: (f64, f64)| (a.0 + b.0, a.1 + b.1);
        let grown = (part * self.constant.0, part * self.constant.1);
        Self {
            angle: mapped(self.angle),
            slope: mapped(self.slope),
            constant: plus(mapped(self.constant), self.constant),
            linear: plus(plus(mapped(self.linear), grown), self.linear),
        }
    }

    /// By the two exponentials, which are far apart.
    fn overdamped(stiffness: f64, damping: f64, part: f64) -> Self {
        let half_apart = (0.25 * damping * damping - stiffness).sqrt();
        let fast = 0.5 * damping + half_apart;
        let slow = stiffness / fast;
        // e^(−rate t), and its first and second integral.
        let gone = libm::exp(-fast * part);
        let fast_once = (1.0 - gone) / fast;
        let fast_twice = (part - fast_once) / fast;
        let left = libm::exp(-slow * part);
        let slow_once = -libm::expm1(-slow * part) / slow;
        let x = -slow * part;
        // Of x below a quarter.
        let series = (2..16)
            .rev()
            .fold(0.0, |sum, n| (1.0 + sum * x) / f64::from(n + 1));
        let slow_twice = 0.5 * part * part * (1.0 + x * series);
        let over = 0.5 / half_apart;
        let impulse = over * (left - gone);
        let rate = gone - slow * impulse;
        let (once, twice) = (
            over * (slow_once - fast_once),
            over * (slow_twice - fast_twice),
        );
        Self {
            angle: (rate + damping * impulse, -stiffness * impulse),
            slope: (impulse, rate),
            constant: (once, impulse),
            linear: (twice, once),
        }
    }
}

/// Weights of d at the nodes in angle and slope at the end of a sample, through the polynomial that d's
/// values at the nodes define, of a stop whose response bends too sharply for their quadrature.
fn strongly_damped_weights(stiffness: f64, damping: f64) -> (Eight, Eight) {
    /// Stretches, each to one and a half times the time of the one before; by the end of the last but one
    /// nothing is left of the fast exponential.
    const STRETCHES: i32 = 11;
    let (places, weights) = PLACES;
    let (mut of_angle, mut of_slope) = (Eight::splat(0.0), Eight::splat(0.0));
    let mut from = 0.0;
    for stretch in 0..=STRETCHES {
        let time_constants = libm::pow(1.5, f64::from(stretch));
        let to = if stretch == STRETCHES {
            1.0
        } else {
            (time_constants / damping).min(1.0)
        };
        for (place, weight) in places.iter().zip(weights) {
            let left = from + (to - from) * place;
            let (impulse, rate) = StepResponse::at(stiffness, damping, left).slope;
            for node in 0..POINTS {
                let shape = weight * (to - from) * shape(node, 1.0 - left);
                of_angle.0[node] += shape * impulse;
                of_slope.0[node] += shape * rate;
            }
        }
        from = to;
    }
    (of_angle, of_slope)
}

/// What one pass of the quadrature leaves out where the damping is large.
#[derive(Debug, Clone, Copy)]
struct StrongDamping {
    /// See [`FastContact::softness`].
    softness: f64,
    /// At most, what an acceleration of one does to the angle in a sample: the impulse response h stays
    /// above zero, and its integral below 1/damping.
    response: f64,
    /// Of an angular acceleration as large as it gets: what the polynomial of d misses.
    smooth: f64,
    /// Of the angular acceleration and of its forced rate of change at the start: what the fast exponential
    /// leaves in d that no polynomial follows.
    sharp: (f64, f64),
}

impl StrongDamping {
    /// What stands where there is none: numbers all the same, since a product of what is not set, computed
    /// ahead of the question whether it is, may take a hundred times as long.
    const NONE: Self = Self {
        softness: 0.0,
        response: 0.0,
        smooth: 0.0,
        sharp: (0.0, 0.0),
    };

    /// Returns it for a damping beyond what the quadrature follows.
    fn of(stiffness: f64, damping: f64) -> Option<Self> {
        /// From this damping on the two exponentials are far apart, whatever the phase.
        const FAR_APART: f64 = 8.0;
        if damping <= PHASE_MAX {
            return None;
        }
        let apart = (damping * damping - 4.0 * stiffness).max(0.0).sqrt();
        // Of e^(−fast t) all of it, and all that the nodes see of it, twice for their weights in the end.
        let fast = 0.5 * (damping + apart);
        let (nodes, weights) = PLACES;
        let seen = nodes.iter().zip(weights);
        let seen: f64 = seen
            .map(|(node, weight)| (weight + 1.0 / damping) * libm::exp(-fast * node))
            .sum();
        let sharp = if damping > FAR_APART {
            let missed = 2.0 * (1.0 / fast + seen) / (fast * fast * apart);
            (missed * fast, missed)
        } else {
            (f64::INFINITY, f64::INFINITY)
        };
        // The eighth derivative of the angle's square, no derivative of the angle being above twice the
        // acceleration times powers of the damping; as much again for the excitation's growth.
        let eighth = libm::pow(damping, 4.0) * (damping * (damping + 8.0) + 119.0);
        Some(Self {
            softness: (1.0 / stiffness.sqrt()).min(1.0 / apart),
            response: 1.0 / damping,
            smooth: 4.0 * INTERPOLATION * eighth,
            sharp,
        })
    }

    /// Returns what a sample neglects [rad], of angles up to `reach` and angular accelerations up to `curve`;
    /// at its start these are `bent` and their forced rate of change `turn`.
    #[inline(always)]
    fn neglected(
        &self,
        strongest: f64,
        (reach, curve): (f64, f64),
        (bent, turn): (f64, f64),
    ) -> f64 {
        let square = reach * reach;
        let again = 0.5 * strongest * self.response * strongest * square * reach;
        let beyond = strongest * square * square * square / 720.0;
        let sharp = self.sharp.0 * bent.abs() + self.sharp.1 * turn.abs();
        let unfollowed = strongest * reach * (self.smooth * curve).min(sharp);
        self.response * (again + beyond + unfollowed)
    }
}

/// Largest product of the distances from the nodes in a sample, over 8!: what an eighth derivative of one
/// leaves of an interpolation at the nodes. The product is that polynomial of Legendre with a first
/// coefficient of one, which is largest at the ends: 8!²/16!.
const INTERPOLATION: f64 = 1.93e-9;

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
    /// At most, what an acceleration's rate of change at the start does to it in a sample.
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
    /// The damping is too large for the quadrature alone.
    strongly_damped: bool,
    /// Where it is.
    strong: StrongDamping,
    /// What the samples carried along together do to a deviation.
    map: StateMap,
}

/// What d at each node does to the angle at all nodes, through the polynomial that d's values there define.
fn mutual_weights(stiffness: f64, damping: f64) -> [Eight; POINTS] {
    let (nodes, weights) = PLACES;
    let mut mutual = [Eight::splat(0.0); POINTS];
    for (at, reach) in nodes.iter().enumerate() {
        let left = Eight(nodes.map(|node| reach * (1.0 - node)));
        let responses = impulse_responses(stiffness, damping, left).0;
        for (inner, (shapes, response)) in SHAPES[at].iter().zip(responses).enumerate() {
            for (column, shape) in mutual.iter_mut().zip(shapes) {
                column.0[at] += reach * weights[inner] * shape * response;
            }
        }
    }
    mutual
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
        if !(PHASE_MIN..=PHASE_MAX).contains(&phase)
            || !(0.0..=DAMPING_MAX).contains(&scaled_damping)
        {
            return None;
        }
        let (nodes, weights) = PLACES;
        let respond = |part: f64| StepResponse::at(scaled, scaled_damping, part);
        let at: [StepResponse; POINTS] = nodes.map(respond);
        let lanes = |value: &dyn Fn(usize) -> f64| Eight(std::array::from_fn(value));
        let strong_damping = StrongDamping::of(scaled, scaled_damping);
        let ((angle_weights, slope_weights), mutual) = if strong_damping.is_some() {
            let weights = strongly_damped_weights(scaled, scaled_damping);
            (weights, [Eight::splat(0.0); POINTS])
        } else {
            let from = nodes.map(|node| respond(1.0 - node));
            let angle_weights = lanes(&|node| weights[node] * from[node].slope.0);
            let slope_weights = lanes(&|node| weights[node] * from[node].slope.1);
            let mutual = mutual_weights(scaled, scaled_damping);
            ((angle_weights, slope_weights), mutual)
        };
        Some(Self {
            interval,
            pressing: pressing * square,
            damping: scaled_damping,
            stiffness: scaled,
            softness: strong_damping.map_or(1.0 / phase, |of| of.softness),
            gain: scale * kernel.gain() * square,
            offset: bias * kernel.gain() * square,
            tolerance: kernel.truncation(),
            end: respond(1.0),
            nodes: Eight(nodes),
            angle: lanes(&|node| at[node].angle.0),
            slope: lanes(&|node| at[node].slope.0),
            constant: lanes(&|node| at[node].constant.0),
            linear: lanes(&|node| at[node].linear.0),
            angle_weights,
            slope_weights,
            mutual,
            strongly_damped: strong_damping.is_some(),
            strong: strong_damping.unwrap_or(StrongDamping::NONE),
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
            let (reach, curve) = self.reached((angle, slope), (bent, bent_rate), strongest);
            let square = reach * reach;
            let moves = angle.abs() + slope.abs();
            let allowed = self.tolerance.0.max(self.tolerance.1 * moves);
            let linear =
                self.angle * angle + self.slope * slope - self.constant * push - self.linear * b1;
            let excitation = self.nodes * b1 + Eight::splat(b0);
            let mut small = excitation * lessened(linear);
            let mut tail;
            if self.strongly_damped {
                let turn = b1 + self.stiffness * slope;
                tail = self
                    .strong
                    .neglected(strongest, (reach, curve), (bent, turn));
                if tail > allowed.max(NEGLECTED_PART * moves) {
                    break;
                }
            } else {
                // What the first and the second quadrature still neglect.
                tail = 0.125 * strongest * square * square;
                if tail > allowed {
                    tail = 0.0625 * strongest * square * square * square;
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
            }
            let (after, slope_after) = self.after((angle, slope), (push, b1), small);
            // Between the ends it cannot rise above them by more than an eighth of its bend.
            if angle.max(after) + 0.125 * curve >= ceiling || after.is_nan() {
                break;
            }
            let middle = b0 + 0.5 * b1;
            let (size, slope_size) = self.rounded((angle, slope), (push, b1));
            gathered.stiffness += self.stiffness - middle * angle;
            gathered.push += middle;
            gathered.angle_square += size * size;
            gathered.velocity_square += slope_size * slope_size;
            gathered.truncation += tail;
            if self.strongly_damped {
                // The impulse response rises and falls once: what d lacks moves the slope by twice as much.
                gathered.truncation_velocity += 2.0 * tail;
            }
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

    /// Returns bounds of angle and angular acceleration within a sample.
    #[inline(always)]
    fn reached(
        &self,
        (angle, slope): (f64, f64),
        (bent, bent_rate): (f64, f64),
        strongest: f64,
    ) -> (f64, f64) {
        let curve = 1.01 * (bent.abs() + bent_rate.abs() * self.softness) + 1e-5 * strongest;
        let reach = angle.abs() + slope.abs() + curve;
        if !self.strongly_damped {
            return (reach, curve);
        }
        // Strongly damped it may be so deep that the cosine adds more.
        let curve = curve + 1.5 * strongest * reach * reach;
        (angle.abs() + slope.abs() + curve, curve)
    }

    /// Returns angle and slope at the end of a sample under an acceleration that begins as `push` and grows by
    /// `growth`, with the small part of it at the nodes.
    #[inline(always)]
    fn after(
        &self,
        (angle, slope): (f64, f64),
        (push, growth): (f64, f64),
        small: Eight,
    ) -> (f64, f64) {
        // What is left of the angle after a strongly damped sample is so near to it that its factor would be
        // off by as much as the angle moves: what moves it is summed instead.
        let (kept, turned, force) = if self.strongly_damped {
            (angle, 0.0, push + self.stiffness * angle)
        } else {
            (self.end.angle.0 * angle, self.end.angle.1 * angle, push)
        };
        let after = kept + self.end.slope.0 * slope
            - self.end.constant.0 * force
            - self.end.linear.0 * growth
            + sum(self.angle_weights * small);
        let slope_after = turned + self.end.slope.1 * slope
            - self.end.constant.1 * force
            - self.end.linear.1 * growth
            + sum(self.slope_weights * small);
        (after, slope_after)
    }

    /// Returns the sizes of what is added up to angle and slope at the end of a sample.
    #[inline(always)]
    fn rounded(&self, (angle, slope): (f64, f64), (push, growth): (f64, f64)) -> (f64, f64) {
        let size = angle.abs() + slope.abs() + push.abs() + growth.abs();
        let slope_size = size + self.stiffness * angle.abs();
        if !self.strongly_damped {
            return (size, slope_size);
        }
        let moved = self.strong.response * slope_size;
        (angle.abs() + moved, slope.abs() + moved)
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

/// The lanes' sum, always in the same order.
#[inline(always)]
fn sum(Eight(x): Eight) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}
