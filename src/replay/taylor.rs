//! One Taylor step of the lever between two events of its own.
//!
//! Time is scaled by the step: σ = τ/step runs from 0 to 1, and coefficient n of the angle
//! carries step^n, so that the size of the last coefficients is the size of the truncation.
//! The recurrence follows from eq. (2.1)/(2.2) with a(τ) linear, and from
//! (cos u)' = −u' sin u, (sin u)' = u' cos u.

/// Right-hand side of eq. (2.1) or (2.2) divided by the moment of inertia:
/// u'' = −pressing − damping·u' − stiffness·u − b(t) cos u.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Branch {
    /// T0/I0 [rad/s²].
    pub(super) pressing: f64,
    /// c/I0 [1/s].
    pub(super) damping: f64,
    /// k/I0 [1/s²].
    pub(super) stiffness: f64,
}

/// State and excitation at the start of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    /// Angle [rad].
    pub(super) angle: f64,
    /// Angular velocity [rad/s].
    pub(super) velocity: f64,
    /// b = m L a/I0 at the start [rad/s²].
    pub(super) excitation: f64,
    /// Its rate of change [rad/s³].
    pub(super) excitation_slope: f64,
    /// The lever leaves rest at the instant at which the net torque is zero; the
    /// coefficient of τ² is then zero by definition, not by rounding.
    pub(super) lifting: bool,
}

/// Coefficients of the angle over a step, in powers of σ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series<const N: usize> {
    /// Coefficient n [rad].
    pub(super) x: [f64; N],
    /// Sine of the angle at the start.
    pub(super) sine: f64,
    /// Cosine of the angle at the start.
    pub(super) cosine: f64,
}

/// Bounds on what bends a step, over the whole of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curved {
    /// Σ_{n≥2} |x_n| [rad].
    pub(super) angle: f64,
    /// Σ_{n≥2} n |x_n|, of the derivative by σ [rad].
    pub(super) slope: f64,
}

impl<const N: usize> Series<N> {
    /// Computes the coefficients for a step of `step` [s].
    #[inline]
    pub(super) fn new(branch: &Branch, start: &Start, step: f64) -> Self {
        let mut x = [0.0; N];
        let mut cosine = [0.0; N];
        let mut sine = [0.0; N];
        let mut weighted = [0.0; N]; // j·x_j
        let step2 = step * step;
        let stiffness = branch.stiffness * step2;
        let damping = branch.damping * step;
        let b0 = start.excitation * step2;
        let b1 = start.excitation_slope * step2 * step;
        x[0] = start.angle;
        x[1] = start.velocity * step;
        weighted[1] = x[1];
        let (s, c) = libm::sincos(start.angle);
        cosine[0] = c;
        sine[0] = s;
        x[2] = if start.lifting {
            0.0
        } else {
            0.5 * (-branch.pressing * step2 - stiffness * x[0] - damping * x[1] - b0 * c)
        };
        weighted[2] = 2.0 * x[2];
        for n in 1..N - 2 {
            let mut c = 0.0;
            let mut s = 0.0;
            for j in 1..=n {
                c -= weighted[j] * sine[n - j];
                s += weighted[j] * cosine[n - j];
            }
            let inverse = INVERSE[n];
            cosine[n] = c * inverse;
            sine[n] = s * inverse;
            let force =
                -stiffness * x[n] - damping * weighted[n + 1] - b0 * cosine[n] - b1 * cosine[n - 1];
            x[n + 2] = force * INVERSE[n + 1] * INVERSE[n + 2];
            weighted[n + 2] = force * INVERSE[n + 1];
        }
        Self {
            x,
            sine: sine[0],
            cosine: cosine[0],
        }
    }

    /// Returns the part of the step, at most 1, over which the neglected terms stay below
    /// `tolerance` [rad].
    #[inline]
    pub(super) fn valid_part(&self, tolerance: f64) -> f64 {
        let tail = self.tail();
        if tail <= tolerance {
            1.0
        } else {
            #[expect(clippy::cast_precision_loss, reason = "N is a small order")]
            let root = 1.0 / (N - 2) as f64;
            0.9 * libm::pow(tolerance / tail, root)
        }
    }

    /// Returns the size of the last two terms at the end of the step [rad].
    #[inline]
    pub(super) fn tail(&self) -> f64 {
        self.x[N - 1].abs() + self.x[N - 2].abs()
    }

    /// Returns the size of the last two terms at `part` of the step [rad].
    #[inline]
    pub(super) fn tail_at(&self, part: f64) -> f64 {
        if part >= 1.0 {
            return self.tail();
        }
        #[expect(clippy::cast_precision_loss, reason = "N is a small order")]
        let power = libm::pow(part, (N - 2) as f64);
        self.tail() * power
    }

    /// Returns the angle and its derivative by σ at `part` of the step.
    #[inline]
    pub(super) fn at(&self, part: f64) -> (f64, f64) {
        crate::numerics::polynomial::evaluate_with_derivative(&self.x, part)
    }

    /// Returns bounds on the curved part of the step.
    #[inline]
    pub(super) fn curved(&self) -> Curved {
        let mut curved = Curved {
            angle: 0.0,
            slope: 0.0,
        };
        let mut n = 2.0;
        for x in &self.x[2..] {
            curved.angle += x.abs();
            curved.slope += n * x.abs();
            n += 1.0;
        }
        curved
    }

    /// Returns the coefficients of the derivative by σ.
    #[inline]
    pub(super) fn derivative(&self) -> [f64; N] {
        let mut d = [0.0; N];
        let mut n = 1.0;
        for i in 1..N {
            d[i - 1] = n * self.x[i];
            n += 1.0;
        }
        d
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
