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

impl pulp::WithSimd for Derivatives<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        /// Sums side by side, which do not wait for one another.
        const LANES: usize = 8;
        let windows = self.extended.array_windows::<TAPS>();
        for window in windows {
            let middle = window[HALF];
            let (mut first, mut second) = ([0.0; LANES], [0.0; LANES]);
            for block in 0..HALF / LANES {
                for lane in 0..LANES {
                    let n = block * LANES + lane;
                    let (after, before) = (window[HALF + 1 + n], window[HALF - 1 - n]);
                    first[lane] += self.weights[0][n] * (after - before);
                    second[lane] += self.weights[1][n] * ((after - middle) + (before - middle));
                }
            }
            self.to.0.push(sum(first));
            self.to.1.push(sum(second));
        }
    }
}

/// The lanes' sum, always in the same order.
#[inline(always)]
fn sum(x: [f64; 8]) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}
