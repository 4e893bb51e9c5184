//! One Taylor step of the lever between two events of its own.
//!
//! Time is scaled by the step: σ = τ/step runs from 0 to 1, and coefficient n of the angle
//! carries step^n, so that the size of the last coefficients is the size of the truncation.
//! The recurrence follows from eq. (2.1)/(2.2) with a(τ) linear, and from
//! (cos u)' = −u' sin u, (sin u)' = u' cos u.

use crate::numerics::polynomial;

/// Right-hand side of eq. (2.1) or (2.2) divided by the moment of inertia:
/// u'' = −pressing − damping·u' − stiffness·u − b(t) cos u + r(t) sin u.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Branch {
    /// T0/I0 [rad/s²].
    pub(super) pressing: f64,
    /// c/I0 [1/s].
    pub(super) damping: f64,
    /// k/I0 [1/s²].
    pub(super) stiffness: f64,
}

impl Branch {
    /// Returns the time in which a free lever turns or slows down by a few radians or factors
    /// of e [s].
    pub(super) fn step_max(&self) -> f64 {
        STEP_MAX / (self.stiffness.sqrt() + self.damping)
    }

    /// Returns what the damping alone leaves of it [s].
    pub(super) fn damped_step_max(&self) -> f64 {
        STEP_MAX / self.damping
    }
}

/// Excitation of a step, in powers of σ.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepExcitation<'a> {
    /// b = m L a_t/I0 [rad/s²].
    pub(super) along: &'a [f64],
    /// r = m L a_r/I0 [rad/s²]; none where nothing acts across.
    pub(super) across: &'a [f64],
    /// Coefficients that the angle's series has at least:
    /// [`Forcing::COUNT_MIN`](super::forcing::Forcing::COUNT_MIN).
    pub(super) count_min: usize,
}

/// Sine and cosine of an angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turned {
    /// Sine.
    pub(super) sine: f64,
    /// Cosine.
    pub(super) cosine: f64,
}

impl Turned {
    /// Of angle zero, exactly.
    pub(super) const ZERO: Self = Self {
        sine: 0.0,
        cosine: 1.0,
    };

    /// Computes them afresh.
    pub(super) fn of(angle: f64) -> Self {
        let (sine, cosine) = libm::sincos(angle);
        Self { sine, cosine }
    }

    /// Turns on by a small `angle` [rad]: addition theorems with series that are good to
    /// rounding up to [`Turned::SMALL`].
    #[inline]
    pub(super) fn by(self, angle: f64) -> Self {
        let square = angle * angle;
        let sine = angle
            * (1.0
                - square
                    * (1.0 / 6.0)
                    * (1.0
                        - square
                            * (1.0 / 20.0)
                            * (1.0 - square * (1.0 / 42.0) * (1.0 - square * (1.0 / 72.0)))));
        let versine = 0.5
            * square
            * (1.0
                - square
                    * (1.0 / 12.0)
                    * (1.0
                        - square
                            * (1.0 / 30.0)
                            * (1.0 - square * (1.0 / 56.0) * (1.0 - square * (1.0 / 90.0)))));
        Self {
            sine: self.sine + (self.cosine * sine - self.sine * versine),
            cosine: self.cosine - (self.sine * sine + self.cosine * versine),
        }
    }

    /// Largest angle of [`Turned::by`] [rad].
    pub(super) const SMALL: f64 = 0.06;
}

/// State at the start of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    /// Angle [rad].
    pub(super) angle: f64,
    /// Sine and cosine of the angle.
    pub(super) turned: Turned,
    /// Angular velocity [rad/s].
    pub(super) velocity: f64,
    /// The lever leaves rest at the instant at which the net torque is zero; the
    /// coefficient of τ² is then zero by definition, not by rounding.
    pub(super) lifting: bool,
}

/// An angle and its derivative by the part of a step, σ.
#[derive(Debug, Clone, Copy)]
pub(super) struct AngleSlope {
    /// [rad].
    pub(super) angle: f64,
    /// [rad].
    pub(super) slope: f64,
}

impl AngleSlope {
    #[inline(always)]
    pub(super) fn new(angle: f64, slope: f64) -> Self {
        Self { angle, slope }
    }
}

/// Coefficients of the angle over a step, in powers of σ, as many as the step needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct TaylorSeries<const N: usize> {
    coefficients: [f64; N],
    count: usize,
    /// At the end of the step.
    pub(super) end: AngleSlope,
    /// Bounds on what bends the step.
    pub(super) curved: Curved,
    /// Truncation let pass in this step [rad].
    allowed: f64,
    tolerance: Tolerance,
}

/// Truncation, relative to the angle and its change, of a run whose error is not stated, since only its peak
/// is asked for: as much as rounding does to it, by an estimate.
pub(super) const PEAK_TRUNCATION: f64 = 1e-16;

/// Truncation let pass in a step: the larger of two.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerance {
    /// In itself [rad].
    pub(super) absolute: f64,
    /// Relative to the angle and its change over the step [-]: a bounce of a nanoradian is
    /// followed with as many digits as a swing.
    pub(super) relative: f64,
}

/// Bounds on what bends a step, over the whole of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curved {
    /// Σ_{n≥2} |x_n| [rad].
    pub(super) angle: f64,
    /// Σ_{n≥2} n |x_n|, of the derivative by σ [rad].
    pub(super) slope: f64,
}

/// Longest step, times the lever's own frequency and damping: far beyond what the series can
/// follow, close enough for its terms to stay finite.
pub(super) const STEP_MAX: f64 = 4.0;

/// Coefficients that a series has at least from rest: without spring and damper, the orders 4 to 7 of a lever that lifts off
/// under a ramp are zero, and what the cosine adds comes with order 8.
const COUNT_MIN_FROM_REST: usize = 11;

impl Tolerance {
    /// Tells whether so much may pass that the angular velocity's share has to be stated as well: below,
    /// the last terms kept are below rounding and those cut off far below.
    pub(super) fn counts(&self) -> bool {
        self.absolute > 0.0 || self.relative > PEAK_TRUNCATION
    }

    /// Returns the truncation let pass at an angle and change of this size [rad].
    #[inline(always)]
    pub(super) fn of(&self, size: f64) -> f64 {
        self.absolute.max(self.relative * size)
    }
}

/// The recurrence, order by order.
struct Recurrence<'a, const N: usize> {
    x: [f64; N],
    /// j·x_j.
    weighted: [f64; N],
    /// (−sin, cos) side by side: one multiplication serves both recurrences.
    turned: [[f64; 2]; N],
    /// Coefficients that are known.
    count: usize,
    /// Those that the series has at least.
    count_min: usize,
    /// Σ |x_n| [rad].
    size: f64,
    /// Stiffness · step² [-].
    stiffness: f64,
    /// Damping · step [-].
    damping: f64,
    /// step² [s²].
    step2: f64,
    excitation: StepExcitation<'a>,
    tolerance: &'a Tolerance,
}

impl<const N: usize> Recurrence<'_, N> {
    /// Takes one order: C_n = −Σ j x_j S_{n−j}/n, S_n = Σ j x_j C_{n−j}/n, then x_{n+2}. True once
    /// the last two terms are small.
    ///
    /// Inlined, so that the sums of an order that is known are loops without a count.
    #[inline(always)]
    fn order(&mut self, n: usize) -> bool {
        let Self {
            x,
            weighted,
            turned,
            excitation,
            ..
        } = self;
        let mut sum = [0.0; 2];
        // The newest pair last, so that the sum is ready when it arrives.
        for j in 0..n {
            let (w, t) = (weighted[n - j], turned[j]);
            sum[0] += w * t[0];
            sum[1] += w * t[1];
        }
        let inverse = INVERSE[n];
        turned[n] = [-sum[1] * inverse, sum[0] * inverse];
        let mut push = 0.0;
        let StepExcitation { along, across, .. } = excitation;
        for k in (1..along.len().min(n + 1)).rev() {
            push += along[k] * turned[n - k][1];
        }
        for k in (0..across.len().min(n + 1)).rev() {
            push += across[k] * turned[n - k][0];
        }
        let b0 = along[0] * self.step2;
        let force = -self.stiffness * x[n]
            - self.damping * weighted[n + 1]
            - b0 * turned[n][1]
            - push * self.step2;
        weighted[n + 2] = force * INVERSE[n + 1];
        x[n + 2] = weighted[n + 2] * INVERSE[n + 2];
        let last = x[n + 2].abs();
        let two = last + x[n + 1].abs();
        self.count = n + 3;
        self.size += last;
        self.count >= self.count_min && two <= self.tolerance.of(self.size)
    }
}

impl<const N: usize> TaylorSeries<N> {
    /// Computes the coefficients for a step of `step` [s]: until two in a row fall below the
    /// tolerance together, or N of them.
    #[inline]
    pub(super) fn new(
        branch: &Branch,
        start: &Start,
        step: f64,
        excitation: StepExcitation<'_>,
        tolerance: &Tolerance,
    ) -> Self {
        const { assert!(N >= 13, "the orders below are written out to the tenth") };
        let StepExcitation {
            along,
            across,
            count_min,
        } = excitation;
        let step2 = step * step;
        let stiffness = branch.stiffness * step2;
        let damping = branch.damping * step;
        let Turned { sine, cosine } = start.turned;
        let (x0, x1) = (start.angle, start.velocity * step);
        let b0 = along[0] * step2;
        let turning = across.first().map_or(0.0, |r0| r0 * step2 * sine);
        let x2 = if start.lifting {
            0.0
        } else {
            0.5 * (-branch.pressing * step2 - stiffness * x0 - damping * x1 - b0 * cosine + turning)
        };
        let mut recurrence = Recurrence {
            x: [0.0; N],
            weighted: [0.0; N],
            turned: [[0.0; 2]; N],
            count: 3,
            count_min: match start.lifting || x0 == 0.0 && x1 == 0.0 {
                true => COUNT_MIN_FROM_REST,
                false => count_min,
            },
            size: x0.abs() + x1.abs() + x2.abs(),
            stiffness,
            damping,
            step2,
            excitation,
            tolerance,
        };
        (recurrence.x[0], recurrence.x[1], recurrence.x[2]) = (x0, x1, x2);
        (recurrence.weighted[1], recurrence.weighted[2]) = (x1, 2.0 * x2);
        recurrence.turned[0] = [-sine, cosine];
        // The orders that most steps need are written out, for the compiler to unroll.
        let done = recurrence.order(1)
            || recurrence.order(2)
            || recurrence.order(3)
            || recurrence.order(4)
            || recurrence.order(5)
            || recurrence.order(6)
            || recurrence.order(7)
            || recurrence.order(8)
            || recurrence.order(9)
            || recurrence.order(10);
        if !done {
            for n in 11..N - 2 {
                if recurrence.order(n) {
                    break;
                }
            }
        }
        let Recurrence {
            x,
            weighted,
            count,
            size,
            ..
        } = recurrence;
        let (mut end, mut end_slope) = (0.0, 0.0);
        let mut curved = Curved {
            angle: 0.0,
            slope: 0.0,
        };
        // From the small to the large.
        for (x, w) in x[2..count].iter().zip(&weighted[2..count]).rev() {
            end += x;
            end_slope += w;
            curved.angle += x.abs();
            curved.slope += w.abs();
        }
        Self {
            end: AngleSlope::new(x0 + (x1 + end), x1 + end_slope),
            coefficients: x,
            count,
            curved,
            allowed: tolerance.of(size),
            tolerance: *tolerance,
        }
    }

    /// Returns the coefficients [rad].
    #[inline]
    pub(super) fn coefficients(&self) -> &[f64] {
        &self.coefficients[..self.count]
    }

    /// Returns the angle at the start [rad].
    #[inline]
    pub(super) fn start(&self) -> f64 {
        self.coefficients[0]
    }

    /// Returns the derivative by σ at the start [rad].
    #[inline]
    pub(super) fn slope(&self) -> f64 {
        self.coefficients[1]
    }

    /// Returns half the second derivative by σ at the start [rad].
    #[inline]
    pub(super) fn bend(&self) -> f64 {
        self.coefficients[2]
    }

    /// Returns the orders that were computed.
    #[inline]
    pub(super) fn orders(&self) -> u64 {
        self.count as u64 - 1
    }

    /// Returns the part of the step, at most 1, over which the neglected terms stay below
    /// the tolerance.
    #[inline]
    pub(super) fn valid_part(&self) -> f64 {
        let tail = self.tail();
        if tail <= self.allowed {
            1.0
        } else {
            self.shortened(tail)
        }
    }

    /// Returns the part over which `tail`, the size of the last two terms at the end of the
    /// step, is small against the motion over that part: the motion over the whole step, where
    /// the series may not even converge, is no measure.
    #[cold]
    #[inline(never)]
    fn shortened(&self, tail: f64) -> f64 {
        let mut part = 1.0;
        for _ in 0..20 {
            let size = self
                .coefficients()
                .iter()
                .rev()
                .fold(0.0, |sum, c| sum * part + c.abs());
            let allowed = self.tolerance.of(size);
            if part < 1.0 && self.tail_at(part) <= allowed {
                break;
            }
            part = 0.9 * libm::pow(allowed / tail, 1.0 / self.tail_order()).min(part);
        }
        part
    }

    /// Returns the size of the last two terms at the end of the step [rad].
    #[inline]
    fn tail(&self) -> f64 {
        self.coefficients[self.count - 1].abs() + self.coefficients[self.count - 2].abs()
    }

    pub(super) fn tail_order(&self) -> f64 {
        (self.count - 2) as f64
    }

    /// Returns the size of the last two terms at `part` of the step [rad].
    #[inline]
    pub(super) fn tail_at(&self, part: f64) -> f64 {
        if part >= 1.0 {
            self.tail()
        } else {
            self.tail() * libm::pow(part, self.tail_order())
        }
    }

    /// Returns the angle and its derivative by σ at `part` of the step.
    #[inline]
    pub(super) fn at(&self, part: f64) -> AngleSlope {
        if part >= 1.0 {
            return self.end;
        }
        let (angle, slope) = polynomial::evaluate_with_derivative(self.coefficients(), part);
        AngleSlope { angle, slope }
    }

    /// Returns the coefficients of the derivative by σ, and how many they are.
    pub(super) fn derivative(&self) -> ([f64; N], usize) {
        let mut d = [0.0; N];
        let mut n = 1.0;
        for (to, from) in d.iter_mut().zip(&self.coefficients()[1..]) {
            *to = n * from;
            n += 1.0;
        }
        (d, self.count - 1)
    }
}

/// 1/n, so that the recurrence divides nowhere.
const INVERSE: [f64; 32] = {
    let mut table = [0.0; 32];
    let mut n = 1;
    while n < 32 {
        table[n] = 1.0 / n as f64;
        n += 1;
    }
    table
};
