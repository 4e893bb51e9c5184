//! What lies between samples: the reading of a signal within its band.
//!
//! The samples' interpolant is their sum of sincs under Kaiser's window, 16 samples to either side. Its first
//! and second derivatives at the samples are two filters of 33 taps; a polynomial of fifth degree through
//! samples and derivatives follows it in each interval.
//!
//! - Tones up to 0.76 of the Nyquist frequency keep their derivatives to 3e-6. The first derivative is not
//!   scaled to make a ramp exact, which would put 3e-5 on every tone: a ramp's slope is 3e-5 too steep, and
//!   the same at both ends of an interval.
//! - The second is that of the differences to the sample itself: a constant stays one.
//! - Beyond the ends the record is extended as for resampling.

use super::Signal;
use super::resample::{KAISER_BETA, bessel_i0, extend_and_hold};
use latchgate_kernel::signal::Reading;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// How the acceleration runs between samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Between {
    /// Within the samples' band, by polynomials of fifth degree.
    #[default]
    BandLimited,
    /// By straight lines.
    Linear,
    /// As the formula of a pulse runs; never asked for.
    Exact,
}

impl Between {
    /// Returns the name that options and verdicts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::BandLimited => "band-limited",
            Self::Linear => "linear",
            Self::Exact => "exact",
        }
    }
}

/// Returns a signal as it is read.
///
/// # Errors
///
/// None that a signal could cause.
pub fn read(signal: Cow<'_, Signal>, between: Between) -> Result<Reading<'_>, Error> {
    if between == Between::Linear {
        return Ok(match signal {
            Cow::Borrowed(signal) => signal.into(),
            Cow::Owned(signal) => signal.into(),
        });
    }
    let (slopes, bends) = derivatives(&signal.samples);
    Ok(Reading::quintic(signal, slopes, bends)?)
}

/// Half-length of the interpolant's kernel in samples.
const HALF: usize = 16;

/// Samples that a derivative rests on.
const TAPS: usize = 2 * HALF + 1;

/// Returns the interpolant's first and second derivative at each sample, per interval.
fn derivatives(samples: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut slopes_and_bends = (
        Vec::with_capacity(samples.len()),
        Vec::with_capacity(samples.len()),
    );
    if samples.is_empty() {
        return slopes_and_bends;
    }
    pulp::Arch::new().dispatch(Derivatives {
        extended: &extend_and_hold(samples, HALF),
        weights: &weights(),
        to: &mut slopes_and_bends,
    });
    slopes_and_bends
}

/// Weights of the differences and of the sums of the samples to either side, the nearest first:
/// D1_n = −w'(n) and D2_n = w''(n) of w(x) = sinc(x) K(x).
fn weights() -> [[f64; HALF]; 2] {
    let peak = bessel_i0(KAISER_BETA);
    let half = HALF as f64;
    let (mut first, mut second) = ([0.0; HALF], [0.0; HALF]);
    let (mut n, mut sign) = (1.0, 1.0);
    for (first, second) in first.iter_mut().zip(&mut second) {
        let argument = KAISER_BETA * (1.0 - (n / half) * (n / half)).max(0.0).sqrt();
        let window = bessel_i0(argument) / peak;
        let slope =
            -KAISER_BETA * KAISER_BETA * n / (half * half) * bessel_i1_by_x(argument) / peak;
        *first = sign * window / n;
        *second = -sign * 2.0 * (slope / n - window / (n * n));
        n += 1.0;
        sign = -sign;
    }
    [first, second]
}

/// Modified Bessel function of the first kind and order one by its argument, by its power series.
fn bessel_i1_by_x(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut sum, mut term, mut order) = (0.5, 0.5, 1.0);
    while term > sum * 1e-17 {
        term *= quarter / (order * (order + 1.0));
        sum += term;
        order += 1.0;
    }
    sum
}

/// Both derivatives at each sample, compiled for what the machine has: products and sums are rounded each by
/// itself, so that the numbers are the same on every machine.
struct Derivatives<'a> {
    extended: &'a [f64],
    weights: &'a [[f64; HALF]; 2],
    to: &'a mut (Vec<f64>, Vec<f64>),
}

/// Samples whose derivatives are taken side by side: the machine's vectors lie along the signal.
const SIDE_BY_SIDE: usize = 8;

impl pulp::WithSimd for Derivatives<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let count = self.extended.len() + 1 - TAPS;
        let mut first = 0;
        while first + SIDE_BY_SIDE <= count {
            let (slopes, bends) = side_by_side::<SIDE_BY_SIDE>(self.extended, first, self.weights);
            self.to.0.extend_from_slice(&slopes);
            self.to.1.extend_from_slice(&bends);
            first += SIDE_BY_SIDE;
        }
        for last in first..count {
            let ([slope], [bend]) = side_by_side::<1>(self.extended, last, self.weights);
            self.to.0.push(slope);
            self.to.1.push(bend);
        }
    }
}

/// Returns the derivatives at so many samples from the first on, whose windows begin there.
#[inline(always)]
fn side_by_side<const N: usize>(
    extended: &[f64],
    first: usize,
    weights: &[[f64; HALF]; 2],
) -> ([f64; N], [f64; N]) {
    let window = &extended[first..first + TAPS + N - 1];
    // Weight n and weight n + 8 are summed first, then those pairs two by two: always in this order.
    let pair = |n: usize| {
        let (mut slopes, mut bends) = ([0.0; N], [0.0; N]);
        for n in [n, n + HALF / 2] {
            let after = &window[HALF + 1 + n..][..N];
            let before = &window[HALF - 1 - n..][..N];
            let middle = &window[HALF..][..N];
            let [slope_weight, bend_weight] = [weights[0][n], weights[1][n]];
            for k in 0..N {
                let (ahead, behind) = (after[k] - middle[k], before[k] - middle[k]);
                slopes[k] += slope_weight * (after[k] - before[k]);
                bends[k] += bend_weight * (ahead + behind);
            }
        }
        (slopes, bends)
    };
    let plus = |a: ([f64; N], [f64; N]), b: ([f64; N], [f64; N])| {
        let mut sum = a;
        for k in 0..N {
            sum.0[k] += b.0[k];
            sum.1[k] += b.1[k];
        }
        sum
    };
    let even = plus(plus(pair(0), pair(4)), plus(pair(2), pair(6)));
    let odd = plus(plus(pair(1), pair(5)), plus(pair(3), pair(7)));
    plus(even, odd)
}
