//! The excitation over a stretch of smooth motion, as the kernel needs it.

use crate::numerics::polynomial;
use crate::signal::{CURVED, bend_at_most, slope, value};
use std::f64::consts::{PI, TAU};

/// b = m L a/I0 over a stretch [rad/s²]; a local time [s] counts from the stretch's start.
pub(super) trait Forcing {
    /// Whether its steps are so long that each one's error is carried along by itself.
    const LONG: bool;

    /// Coefficients that a series under it has at least: fewer could look finished by a chance zero.
    const COUNT_MIN: usize;

    /// Coefficients of b over a step.
    type Series: AsRef<[f64]> + AsMut<[f64]>;

    /// Returns the time of its start [s].
    fn time(&self) -> f64;

    /// Returns its length [s].
    fn length(&self) -> f64;

    /// Returns the longest step that the series is good for [s].
    fn step_max(&self) -> f64;

    /// Returns b at `local` [rad/s²].
    fn at(&self, local: f64) -> f64;

    /// Returns the slope of b at `local` [rad/s³].
    fn slope_at(&self, local: f64) -> f64;

    /// Returns a bound on the second derivative of b [rad/s⁴].
    fn bend(&self) -> f64;

    /// Returns b from `local` on in powers of the time over `step`.
    fn series(&self, local: f64, step: f64) -> Self::Series;

    /// Returns what acts across, m L a_r/I0, in the same way; `None` where nothing does.
    fn across(&self, local: f64, step: f64) -> Option<Self::Series> {
        let _ = (local, step);
        None
    }

    /// Returns what acts across at `local` [rad/s²].
    fn across_at(&self, local: f64) -> f64 {
        let _ = local;
        0.0
    }

    /// Returns a bound on what acts across [rad/s²].
    fn across_most(&self) -> f64 {
        0.0
    }

    /// Returns what presses a lever onto a stop above, at an angle of this sine and cosine: −b cos u + r sin u.
    fn onto(&self, sine: f64, cosine: f64) -> Self;

    /// Returns the first instant from `local` on, at the latest the stretch's end, at which
    /// `level` + b falls below zero; at `local` it is not below.
    fn falls_below(&self, level: f64, local: f64) -> Option<f64>;
}

/// A polynomial between two samples, of `K` terms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polynomial<const K: usize> {
    /// Time of its start [s].
    pub(super) time: f64,
    /// Its length [s].
    pub(super) length: f64,
    /// b = Σ c_n (τ/length)^n [rad/s²].
    pub(super) terms: [f64; K],
    /// The same of what acts across.
    pub(super) across: Option<[f64; K]>,
}

impl<const K: usize> Polynomial<K> {
    /// Returns what is left of it from `local` on, up to `end`.
    pub(super) fn between(&self, local: f64, end: f64) -> Self {
        if local <= 0.0 && end >= self.length {
            return *self;
        }
        let length = end - local;
        Self {
            time: self.time + local,
            length,
            terms: self.part(&self.terms, local, length),
            across: self.across(local, length),
        }
    }

    /// Returns the coefficients from `local` on in powers of the time over `step`.
    #[inline]
    fn part(&self, terms: &[f64; K], local: f64, step: f64) -> [f64; K] {
        if local <= 0.0 && step >= self.length {
            return *terms;
        }
        let mut c = about(terms, local / self.length);
        let part = step / self.length;
        let mut power = 1.0;
        for c in &mut c {
            *c *= power;
            power *= part;
        }
        c
    }

    /// Returns the first place from `from` on at which `level` + b falls below zero, b having more than
    /// two terms.
    fn falls_at(&self, level: f64, from: f64) -> Option<f64> {
        /// Places at which it may touch zero, to rounding, before one is where it falls.
        const TOUCHES: usize = 2 * CURVED;
        /// As much further on, it is another place.
        const BESIDE: f64 = 1e-7;
        let mut from = from;
        for _ in 0..TOUCHES {
            let mut c = about(&self.terms, from);
            c[0] += level;
            if c[0] <= 0.0 && c[1] < 0.0 {
                return Some(from);
            }
            let remaining = 1.0 - from;
            let root = if remaining > 0.0 {
                polynomial::first_fall(&c, remaining)
            } else {
                None
            };
            let Some(root) = root else {
                // The end itself, which the search leaves out.
                return (value(&c, remaining) < 0.0).then_some(1.0);
            };
            if slope(&self.terms, from + root) < 0.0 {
                return Some((from + root).min(1.0));
            }
            from += root + BESIDE;
            if from >= 1.0 {
                return None;
            }
            if level + value(&self.terms, from) < 0.0 {
                return Some(from);
            }
        }
        None
    }
}

/// Returns the coefficients of a polynomial about another origin.
#[inline]
fn about<const K: usize>(terms: &[f64; K], part: f64) -> [f64; K] {
    let mut c = *terms;
    for i in 0..K - 1 {
        for j in (i..K - 1).rev() {
            c[j] += part * c[j + 1];
        }
    }
    c
}

impl<const K: usize> Forcing for Polynomial<K> {
    const LONG: bool = false;

    const COUNT_MIN: usize = if K > 2 { 10 } else { 7 };

    type Series = [f64; K];

    #[inline]
    fn time(&self) -> f64 {
        self.time
    }

    #[inline]
    fn length(&self) -> f64 {
        self.length
    }

    #[inline]
    fn step_max(&self) -> f64 {
        f64::INFINITY
    }

    #[inline]
    fn at(&self, local: f64) -> f64 {
        value(&self.terms, local / self.length)
    }

    #[inline]
    fn slope_at(&self, local: f64) -> f64 {
        slope(&self.terms, local / self.length) / self.length
    }

    #[inline]
    fn bend(&self) -> f64 {
        bend_at_most(&self.terms) / (self.length * self.length)
    }

    #[inline]
    fn series(&self, local: f64, step: f64) -> [f64; K] {
        self.part(&self.terms, local, step)
    }

    #[inline]
    fn across(&self, local: f64, step: f64) -> Option<[f64; K]> {
        self.across
            .as_ref()
            .map(|terms| self.part(terms, local, step))
    }

    #[inline]
    fn across_at(&self, local: f64) -> f64 {
        let value_of = |terms: &[f64; K]| value(terms, local / self.length);
        self.across.as_ref().map_or(0.0, value_of)
    }

    #[inline]
    fn across_most(&self) -> f64 {
        let sum = |terms: &[f64; K]| terms.iter().map(|term| term.abs()).sum();
        self.across.as_ref().map_or(0.0, sum)
    }

    #[inline]
    fn onto(&self, sine: f64, cosine: f64) -> Self {
        let mut terms = self.terms.map(|term| -cosine * term);
        if let Some(across) = &self.across {
            for (term, across) in terms.iter_mut().zip(across) {
                *term += sine * across;
            }
        }
        Self {
            terms,
            across: None,
            ..*self
        }
    }

    #[inline]
    fn falls_below(&self, level: f64, local: f64) -> Option<f64> {
        if K > 2 {
            let place = self.falls_at(level, local / self.length)?;
            return Some((place * self.length).clamp(local, self.length));
        }
        let end = level + self.at(self.length);
        if end >= 0.0 {
            return None;
        }
        let now = level + self.at(local);
        Some(local + (self.length - local) * (now / (now - end)))
    }
}

/// A piece of a sine, b = B sin(θ + ω τ), with B ≥ 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sine {
    /// Time of its start [s].
    pub(super) time: f64,
    /// Its length [s].
    pub(super) length: f64,
    /// B [rad/s²].
    pub(super) amplitude: f64,
    /// ω [rad/s].
    pub(super) angular_frequency: f64,
    /// θ, the phase at its start [rad].
    pub(super) phase: f64,
}

/// Coefficients of a sine over a step: the terms beyond are below 1/22! of it.
pub(super) const SINE_ORDER: usize = 22;

/// Rounding of a phase, in turns.
const ROUNDING: f64 = 1e-14;

/// Size of a term of the unit sine that is left out.
const NEGLIGIBLE: f64 = 1e-20;

/// As many terms of a sine's series as count.
pub(super) struct SineTerms {
    terms: [f64; SINE_ORDER],
    count: usize,
}

impl AsRef<[f64]> for SineTerms {
    fn as_ref(&self) -> &[f64] {
        &self.terms[..self.count]
    }
}

impl AsMut<[f64]> for SineTerms {
    fn as_mut(&mut self) -> &mut [f64] {
        &mut self.terms[..self.count]
    }
}

impl Sine {
    fn turned(&self, local: f64) -> (f64, f64) {
        libm::sincos(self.phase + self.angular_frequency * local)
    }
}

impl Forcing for Sine {
    const LONG: bool = true;

    const COUNT_MIN: usize = 7;

    type Series = SineTerms;

    fn time(&self) -> f64 {
        self.time
    }

    fn length(&self) -> f64 {
        self.length
    }

    fn step_max(&self) -> f64 {
        1.0 / self.angular_frequency
    }

    fn at(&self, local: f64) -> f64 {
        self.amplitude * self.turned(local).0
    }

    fn slope_at(&self, local: f64) -> f64 {
        self.amplitude * self.angular_frequency * self.turned(local).1
    }

    fn bend(&self) -> f64 {
        self.amplitude * self.angular_frequency * self.angular_frequency
    }

    fn series(&self, local: f64, step: f64) -> SineTerms {
        let (sine, cosine) = self.turned(local);
        let turn = self.angular_frequency * step;
        // The derivatives go round: sine, cosine, −sine, −cosine.
        let round = [sine, cosine, -sine, -cosine];
        let mut series = SineTerms {
            terms: [0.0; SINE_ORDER],
            count: 0,
        };
        let (mut factor, mut order) = (1.0, 0.0);
        for (n, term) in series.terms.iter_mut().enumerate() {
            if factor < NEGLIGIBLE {
                break;
            }
            *term = self.amplitude * factor * round[n % 4];
            order += 1.0;
            factor *= turn / order;
            series.count = n + 1;
        }
        series
    }

    fn onto(&self, _: f64, cosine: f64) -> Self {
        let turned = if cosine > 0.0 { PI } else { 0.0 };
        Self {
            amplitude: self.amplitude * cosine.abs(),
            phase: self.phase + turned,
            ..*self
        }
    }

    fn falls_below(&self, level: f64, local: f64) -> Option<f64> {
        if self.amplitude <= level {
            return None;
        }
        // sin x = −level/B on its way down, at π + asin(level/B) and every turn later; where the
        // lever is there but for rounding, that is the instant.
        let down = PI + libm::asin((level / self.amplitude).max(-1.0));
        let phase = self.phase + self.angular_frequency * local;
        let turns = libm::ceil((phase - down) / TAU - ROUNDING);
        let instant = (down + turns * TAU - self.phase) / self.angular_frequency;
        if self.slope_at(instant) >= 0.0 {
            // It touches zero, to rounding, and does not fall below.
            return None;
        }
        (instant <= self.length).then_some(instant.max(local))
    }
}
