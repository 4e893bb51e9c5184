//! A second way to the same answer: the lever under piecewise linear excitation, integrated
//! with 106-bit numbers.
//!
//! It shares no code with the library and none of its choices: Taylor steps of order 28 at
//! most that are shortened until their last terms vanish, events isolated by bisection with
//! bounds on the derivative instead of Bernstein coefficients, every bounce resolved. It is
//! slow, and meant to be read.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::State;
use latchgate_kernel::signal::Signal;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An unevaluated sum of two doubles, the second below half an ulp of the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wide {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

impl Wide {
    pub(crate) const ZERO: Self = Self {
        high: 0.0,
        low: 0.0,
    };

    /// a + b, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        Self {
            high,
            low: (a - (high - part)) + (b - part),
        }
    }

    /// a · b, exactly (Dekker).
    fn product(a: f64, b: f64) -> Self {
        let split = |x: f64| {
            let t = 134_217_729.0 * x;
            let high = t - (t - x);
            (high, x - high)
        };
        let high = a * b;
        let ((a1, a2), (b1, b2)) = (split(a), split(b));
        Self {
            high,
            low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2,
        }
    }

    pub(crate) fn to_f64(self) -> f64 {
        self.high
    }

    fn abs(self) -> f64 {
        self.high.abs()
    }

    fn positive(self) -> bool {
        self.high > 0.0
    }

    fn negative(self) -> bool {
        self.high < 0.0
    }
}

impl From<f64> for Wide {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Wide {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let s = Self::sum(self.high, other.high);
        let t = Self::sum(self.low, other.low);
        let s = Self::sum(s.high, s.low + t.high);
        Self::sum(s.high, s.low + t.low)
    }
}

impl Neg for Wide {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for Wide {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = Self::product(self.high, other.high);
        Self::sum(
            p.high,
            p.low + (self.high * other.low + self.low * other.high),
        )
    }
}

impl Div for Wide {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = Self::from(self.high / other.high);
        let rest = self - first * other;
        let second = Self::from(rest.high / other.high);
        let rest = rest - second * other;
        first + second + Self::from(rest.high / other.high)
    }
}

/// Sine and cosine to about 1e-30.
pub(crate) fn sine_cosine(angle: Wide) -> (Wide, Wide) {
    let quarter = Wide {
        high: std::f64::consts::FRAC_PI_2,
        low: 6.123_233_995_736_766e-17,
    };
    let turns = (angle.high / quarter.high).round();
    let r = angle - quarter * Wide::from(turns);
    let square = r * r;
    let (mut sine, mut cosine) = (Wide::ZERO, Wide::ZERO);
    // Horner from the 29th power down.
    for n in (0..=14).rev() {
        let n = f64::from(n);
        sine = Wide::from(1.0) - square * sine / Wide::from((2.0 * n + 2.0) * (2.0 * n + 3.0));
        cosine = Wide::from(1.0) - square * cosine / Wide::from((2.0 * n + 1.0) * (2.0 * n + 2.0));
    }
    let (sine, cosine) = (r * sine, cosine);
    match turns.rem_euclid(4.0) as i32 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Highest order of the Taylor steps.
const ORDER: usize = 28;

/// Last terms of a step, relative to the motion in it.
const TAIL: f64 = 1e-30;

/// A bounce this slow [rad/s] on a pressed lever is rest: the rest of them last less than
/// any number here can tell.
const REST_SPEED: f64 = 1e-16;

/// Sizes of the first terms and of the last.
fn size_and_tail(x: &[Wide]) -> (f64, f64) {
    let size = |part: &[Wide]| part.iter().map(|c| c.abs()).sum();
    // Six in a row: from rest, up to five are zero by structure.
    (size(&x[..4]), size(&x[x.len() - 6..]))
}

fn value(p: &[Wide], x: Wide) -> Wide {
    p.iter().rev().fold(Wide::ZERO, |sum, c| sum * x + *c)
}

fn derivative(p: &[Wide]) -> Vec<Wide> {
    p.iter()
        .enumerate()
        .skip(1)
        .map(|(n, c)| *c * Wide::from(n as f64))
        .collect()
}

/// Bound of the second derivative on [0, 1].
fn bend(p: &[Wide]) -> f64 {
    p.iter()
        .enumerate()
        .skip(2)
        .map(|(n, c)| (n * (n - 1)) as f64 * c.abs())
        .sum()
}

/// First place in (low, high) where `p` falls from above to below zero.
fn first_fall(p: &[Wide], slope: &[Wide], bend: f64, low: f64, high: f64) -> Option<Wide> {
    let (at_low, at_high) = (value(p, low.into()), value(p, high.into()));
    let width = high - low;
    let slack = bend * width * width / 8.0;
    if at_low.high.max(at_high.high) == 0.0 && slack == 0.0 {
        return None;
    }
    if at_low.high.min(at_high.high) > slack || at_low.high.max(at_high.high) < -slack {
        return None;
    }
    let middle = 0.5 * (low + high);
    let steep = value(slope, middle.into()).high;
    if steep.abs() > 0.5 * bend * width || width < 1e-13 {
        // Monotone: one root at most.
        if !(steep < 0.0 && !at_low.negative() && at_high.negative()) {
            return None;
        }
        let (mut low, mut high) = (low, high);
        let mut x = Wide::from(middle);
        for turn in 0..200 {
            let here = value(p, x);
            if here.positive() {
                low = low.max(x.high);
            } else {
                high = high.min(x.high);
            }
            let next = x - here / value(slope, x);
            let inside = next.high >= low && next.high <= high;
            let step = (next - x).abs();
            x = if inside {
                next
            } else {
                Wide::from(0.5 * (low + high))
            };
            if inside && step <= 1e-31 * x.abs() || turn > 150 {
                break;
            }
        }
        return Some(x);
    }
    first_fall(p, slope, bend, low, middle).or_else(|| first_fall(p, slope, bend, middle, high))
}

#[derive(Debug, Clone, Copy)]
struct Branch {
    damping: Wide,
    stiffness: Wide,
}

/// What really happens.
#[derive(Debug, Clone)]
pub(crate) struct Truth {
    pub(crate) peak: Wide,
    pub(crate) peak_time: f64,
    pub(crate) first_release: Option<f64>,
    pub(crate) first_crossing: Option<f64>,
    /// Time [s], angular velocity before [rad/s]; contact entries on the soft stop.
    pub(crate) impacts: Vec<(f64, f64)>,
    pub(crate) angle: Wide,
    pub(crate) velocity: Wide,
}

impl Truth {
    pub(crate) fn counted(&self) -> usize {
        self.impacts.iter().filter(|(_, v)| v.abs() > 1e-3).count()
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Dwell,
    Flight,
    Contact,
}

struct Oracle {
    rigid: bool,
    pressing: Wide,
    free: Branch,
    contact: Branch,
    restitution: Wide,
    gain: Wide,
    threshold: f64,
    phase: Phase,
    angle: Wide,
    velocity: Wide,
    lifting: bool,
    truth: Truth,
}

/// Follows the lever over the whole signal, `sign` times its samples being the model's.
pub(crate) fn follow(
    signal: &Signal,
    sign: f64,
    design: &Design,
    stop: StopModel,
    initial: Option<State>,
) -> Truth {
    let lever = &design.lever;
    let w = Wide::from;
    let inertia = w(lever.moment_of_inertia_kg_m2);
    let radius2 = w(design.stop.radius_m) * w(design.stop.radius_m);
    let free = Branch {
        damping: w(lever.pivot_damping_nm_s_per_rad) / inertia,
        stiffness: w(lever.spring_stiffness_nm_per_rad) / inertia,
    };
    let contact = Branch {
        damping: (w(lever.pivot_damping_nm_s_per_rad) + w(design.stop.damping_n_s_per_m) * radius2)
            / inertia,
        stiffness: (w(lever.spring_stiffness_nm_per_rad)
            + w(design.stop.stiffness_n_per_m) * radius2)
            / inertia,
    };
    let pressing = w(lever.preload_torque_nm) / inertia;
    let rigid = stop == StopModel::Rigid;
    let (phase, angle, velocity) = match initial {
        None if rigid => (Phase::Dwell, Wide::ZERO, Wide::ZERO),
        None => (Phase::Contact, -(pressing / contact.stiffness), Wide::ZERO),
        Some(state) => {
            let pressed = !rigid && state.angle_rad < 0.0;
            let phase = if pressed {
                Phase::Contact
            } else {
                Phase::Flight
            };
            (phase, w(state.angle_rad), w(state.velocity_rad_s))
        }
    };
    let mut oracle = Oracle {
        rigid,
        pressing,
        free,
        contact,
        restitution: w(design.stop.restitution),
        gain: w(lever.mass_kg) * w(lever.center_of_mass_m) / inertia,
        threshold: design.criterion.threshold_rad,
        phase,
        angle,
        velocity,
        lifting: false,
        truth: Truth {
            peak: angle,
            peak_time: signal.start_s,
            first_release: None,
            first_crossing: (angle.high > design.criterion.threshold_rad).then_some(signal.start_s),
            impacts: vec![],
            angle,
            velocity,
        },
    };
    let length = w(1.0) / w(signal.rate.hertz());
    for (index, pair) in signal.samples.windows(2).enumerate() {
        let time = w(signal.start_s) + w(index as f64) / w(signal.rate.hertz());
        oracle.sample(time, length, w(sign * pair[0]), w(sign * pair[1]));
    }
    oracle.truth.angle = oracle.angle;
    oracle.truth.velocity = oracle.velocity;
    oracle.truth
}

impl Oracle {
    fn sample(&mut self, time: Wide, length: Wide, from: Wide, to: Wide) {
        let start = self.gain * from;
        let rate = self.gain * (to - from) / length;
        let mut now = Wide::ZERO;
        let mut rounds = 0;
        while (length - now).positive() {
            rounds += 1;
            assert!(rounds < 1_000_000, "the oracle does not end");
            let push = start + rate * now;
            let torque = self.pressing + push;
            if self.phase == Phase::Dwell {
                let end = self.pressing + start + rate * length;
                if torque.negative() {
                    self.lifting = false;
                } else if end.negative() {
                    now = -(self.pressing + start) / rate;
                    self.lifting = true;
                } else {
                    return;
                }
                self.phase = Phase::Flight;
                self.angle = Wide::ZERO;
                self.velocity = Wide::ZERO;
                self.release(time + now);
                continue;
            }
            if self.angle == Wide::ZERO && !self.lifting {
                let away = if self.velocity == Wide::ZERO {
                    torque.negative() || (!torque.positive() && rate.negative())
                } else {
                    self.velocity.positive()
                };
                if self.phase == Phase::Flight && !away {
                    self.meet(time + now, torque);
                    continue;
                }
                if self.phase == Phase::Contact && away {
                    self.phase = Phase::Flight;
                    self.release(time + now);
                }
                if self.phase == Phase::Flight {
                    self.release(time + now);
                }
            }
            if self.phase == Phase::Flight && self.angle.positive() {
                self.release(time + now);
            }
            now = now + self.step(time + now, length - now, push, rate, torque);
        }
    }

    fn release(&mut self, time: Wide) {
        self.truth.first_release.get_or_insert(time.high);
    }

    /// The lever meets the stop with a velocity ≤ 0.
    fn meet(&mut self, time: Wide, torque: Wide) {
        self.truth.impacts.push((time.high, self.velocity.high));
        if !self.rigid {
            self.phase = Phase::Contact;
            return;
        }
        self.velocity = -(self.restitution * self.velocity);
        if self.velocity.high < REST_SPEED {
            self.velocity = Wide::ZERO;
            if !torque.negative() {
                self.phase = Phase::Dwell;
            }
        }
    }

    /// One step, at most `longest`; returns the time it took.
    fn step(&mut self, time: Wide, longest: Wide, push: Wide, rate: Wide, torque: Wide) -> Wide {
        let branch = if self.phase == Phase::Contact {
            self.contact
        } else {
            self.free
        };
        let mut step = longest;
        if self.angle == Wide::ZERO && self.velocity.positive() && torque.positive() {
            let flight = 2.5 * self.velocity.high / torque.high;
            if flight < step.high {
                step = flight.into();
            }
        }
        let frequency = branch.stiffness.high.sqrt() + branch.damping.high;
        if frequency * step.high > 1.0 {
            step = (1.0 / frequency).into();
        }
        let x = loop {
            let x = self.series(&branch, step, push, rate);
            let (size, tail) = size_and_tail(&x);
            if tail <= TAIL * size && (!self.lifting || x[3].abs() < 1e-3) {
                break x;
            }
            let shrink = (TAIL * size / tail).powf(1.0 / 20.0).clamp(1e-3, 0.7);
            step = step * Wide::from(shrink);
        };
        self.lifting = false;
        let whole = step.high >= longest.high;
        // A root at the start is divided out exactly.
        let skip = x.iter().position(|c| *c != Wide::ZERO).unwrap_or(0);
        let p: Vec<Wide> = x[skip..]
            .iter()
            .map(|c| {
                if self.phase == Phase::Contact {
                    -*c
                } else {
                    *c
                }
            })
            .collect();
        let hit = first_fall(&p, &derivative(&p), bend(&p), 0.0, 1.0);
        let part = hit.unwrap_or(Wide::from(1.0));
        let slope = derivative(&x);
        self.keep(&x, &slope, part.high, time.high, step.high);
        self.angle = value(&x, part);
        self.velocity = value(&slope, part) / step;
        if hit.is_some() {
            self.angle = Wide::ZERO;
        }
        if hit.is_none() && whole {
            longest
        } else {
            part * step
        }
    }

    /// Peak and crossing within a step.
    fn keep(&mut self, x: &[Wide], slope: &[Wide], part: f64, time: f64, step: f64) {
        let size = x[1..].iter().map(|c| c.abs()).sum::<f64>();
        if size <= 1e-25 * x[0].abs() {
            // At rest: what moves is rounding.
            return;
        }
        if (x[0] + Wide::from(size) - self.truth.peak).positive() {
            let bend = bend(slope);
            let second = derivative(slope);
            let mut from = 0.0;
            while let Some(top) = first_fall(slope, &second, bend, from, part) {
                self.offer(value(x, top), time + top.high * step);
                from = top.high + 1e-9;
                if from >= part {
                    break;
                }
            }
            self.offer(value(x, part.into()), time + part * step);
        }
        if self.truth.first_crossing.is_none()
            && x[0].high <= self.threshold
            && x[0].high + size > self.threshold
        {
            // Rising through the threshold is falling of its distance to it.
            let mut p: Vec<Wide> = x.iter().map(|c| -*c).collect();
            p[0] = p[0] + Wide::from(self.threshold);
            if let Some(place) = first_fall(&p, &derivative(&p), bend(&p), 0.0, part) {
                self.truth.first_crossing = Some(time + place.high * step);
            }
        }
    }

    fn offer(&mut self, angle: Wide, time: f64) {
        if (angle - self.truth.peak).positive() {
            self.truth.peak = angle;
            self.truth.peak_time = time;
        }
    }

    /// Taylor coefficients of the angle in powers of time/step.
    fn series(&self, branch: &Branch, step: Wide, push: Wide, rate: Wide) -> Vec<Wide> {
        let mut x = [Wide::ZERO; ORDER + 1];
        let mut weighted = [Wide::ZERO; ORDER + 1];
        let mut sine = [Wide::ZERO; ORDER + 1];
        let mut cosine = [Wide::ZERO; ORDER + 1];
        let square = step * step;
        let (stiffness, damping) = (branch.stiffness * square, branch.damping * step);
        let (push, rate) = (push * square, rate * square * step);
        x[0] = self.angle;
        x[1] = self.velocity * step;
        weighted[1] = x[1];
        (sine[0], cosine[0]) = sine_cosine(self.angle);
        for n in 0..ORDER - 1 {
            if n > 0 {
                for j in 1..=n {
                    cosine[n] = cosine[n] - weighted[j] * sine[n - j];
                    sine[n] = sine[n] + weighted[j] * cosine[n - j];
                }
                let inverse = Wide::from(n as f64);
                cosine[n] = cosine[n] / inverse;
                sine[n] = sine[n] / inverse;
            }
            let mut force = -(stiffness * x[n]) - damping * weighted[n + 1] - push * cosine[n];
            if n == 0 {
                force = force - self.pressing * square;
                if self.lifting {
                    force = Wide::ZERO;
                }
            } else {
                force = force - rate * cosine[n - 1];
            }
            weighted[n + 2] = force / Wide::from((n + 1) as f64);
            x[n + 2] = weighted[n + 2] / Wide::from((n + 2) as f64);
            if n > 10 {
                let (size, tail) = size_and_tail(&x[..n + 3]);
                if tail <= TAIL * size {
                    return x[..n + 3].to_vec();
                }
            }
        }
        x.to_vec()
    }
}
