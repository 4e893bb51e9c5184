//! Channel frequency classes: the two-pass Butterworth low-pass of SAE J211-1 and ISO 6487.
//!
//! Both standards run a two-pole Butterworth filter, made by the bilinear transform with
//! pre-warping, once forwards and once backwards. They differ in the constant that ties the
//! design frequency to the class, and in what they do at the ends of a record; a report has
//! to name both. The two passes together have no phase, so the output may move before
//! its cause.

use super::{Cfc, FilterStandard, Signal};
use latchgate_kernel::units::SampleRate;
use latchgate_recording::error::{Error, ErrorKind};
use std::f64::consts::{PI, SQRT_2};

/// fd/CFC of ISO 6487: 1.25/0.6, which puts the two passes at −2.98 dB at CFC/0.6.
///
/// # Source
///
/// ISO 6487, annex A.
pub const ISO_6487_CONSTANT: f64 = 25.0 / 12.0;

/// fd/CFC of SAE J211-1: (5/3)/(√2 − 1)^¼ to five digits, which puts the two passes at
/// −3.01 dB at CFC/0.6.
///
/// # Source
///
/// SAE J211-1, appendix C.
pub const SAE_J211_CONSTANT: f64 = 2.0775;

/// Samples whose mean starts each pass of ISO 6487.
const START_MEAN_SAMPLES: usize = 10;

/// Least length of ISO 6487's padding in samples.
const LEAST_PADDING_SAMPLES: f64 = 100.0;

/// Returns the least duration of the padding at each end of a record [s].
///
/// # Source
///
/// ISO 6487, annex A: 10 ms, and not less than 100 samples.
pub fn end_padding_s() -> f64 {
    0.01
}

/// Returns the design frequency fd of each pass [Hz].
pub fn design_frequency_hz(cfc: Cfc, standard: FilterStandard) -> f64 {
    let constant = match standard {
        FilterStandard::Iso6487 => ISO_6487_CONSTANT,
        FilterStandard::SaeJ211 => SAE_J211_CONSTANT,
    };
    f64::from(cfc.class()) * constant
}

/// Returns what a standard's filter does at the ends of a record, in words.
pub fn end_treatment(standard: FilterStandard) -> &'static str {
    match standard {
        FilterStandard::Iso6487 => {
            "each end extended by its point mirror over 10 ms, at least 100 samples; both passes start from the mean of their first 10 samples"
        }
        FilterStandard::SaeJ211 => {
            "no extension; both passes start from two zeros, so the last two samples are zero"
        }
    }
}

/// Returns the least sample rate that carries a class [Hz]: ten times the class.
pub fn least_rate_hz(cfc: Cfc) -> f64 {
    10.0 * f64::from(cfc.class())
}

/// Returns the filter of ISO 6487 for a class.
pub fn iso_6487(cfc: Cfc) -> CfcFilter {
    CfcFilter::new(cfc, FilterStandard::Iso6487)
}

/// Returns the filter of SAE J211-1 for a class.
pub fn sae_j211(cfc: Cfc) -> CfcFilter {
    CfcFilter::new(cfc, FilterStandard::SaeJ211)
}

/// The low-pass of one class after one standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CfcFilter {
    class: Cfc,
    standard: FilterStandard,
}

/// One pass: y\[n\] = a0 x\[n\] + a1 x\[n−1\] + a2 x\[n−2\] + b1 y\[n−1\] + b2 y\[n−2\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// Weight of the present sample.
    pub a0: f64,
    /// Weight of the sample before.
    pub a1: f64,
    /// Weight of the sample before that.
    pub a2: f64,
    /// Weight of the output before.
    pub b1: f64,
    /// Weight of the output before that.
    pub b2: f64,
}

impl CfcFilter {
    /// Builds the filter of a class after a standard.
    pub fn new(class: Cfc, standard: FilterStandard) -> Self {
        Self { class, standard }
    }

    /// Returns the coefficients of one pass at a sample rate.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::RateTooLow`] if the rate, rounded to 1e-4 Hz, is below ten times the class.
    ///
    /// # Source
    ///
    /// SAE J211-1, appendix C, and ISO 6487, annex A: ωa = tan(π fd T).
    pub fn coefficients(&self, rate: SampleRate) -> Result<Coefficients, Error> {
        let needed_hz = least_rate_hz(self.class);
        let found_hz = rate.rounded();
        if found_hz < needed_hz {
            return Err(ErrorKind::RateTooLow {
                class: self.class.class(),
                needed_hz,
                found_hz,
            }
            .into());
        }
        let warped = libm::tan(PI * design_frequency_hz(self.class, self.standard) / rate.hertz());
        let square = warped * warped;
        let scale = 1.0 + SQRT_2 * warped + square;
        let a0 = square / scale;
        Ok(Coefficients {
            a0,
            a1: 2.0 * a0,
            a2: a0,
            b1: -2.0 * (square - 1.0) / scale,
            b2: (-1.0 + SQRT_2 * warped - square) / scale,
        })
    }

    /// Filters a signal forwards, then backwards.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::RateTooLow`] if the rate, rounded to 1e-4 Hz, is below ten times the class.
    pub fn apply(&self, signal: &Signal) -> Result<Signal, Error> {
        let coefficients = self.coefficients(signal.rate)?;
        let samples = match self.standard {
            FilterStandard::Iso6487 => {
                let padding = padding_samples(signal.rate, signal.samples.len());
                let mut work = extend(&signal.samples, padding);
                both_passes(&mut work, |work| {
                    one_pass(work, coefficients, start_mean(work));
                });
                work.truncate(padding + signal.samples.len());
                work.drain(..padding);
                work
            }
            FilterStandard::SaeJ211 => {
                let mut work = signal.samples.clone();
                both_passes(&mut work, |work| one_pass(work, coefficients, 0.0));
                work
            }
        };
        Ok(Signal {
            start_s: signal.start_s,
            rate: signal.rate,
            samples,
        })
    }
}

/// Returns the number of samples by which ISO 6487 extends each end: 10 ms, at least 100
/// samples, at most one less than there are.
///
/// The duration is counted at the rounded rate: 0.01 s over an interval of 8e-5 s falls just
/// short of 125 in binary arithmetic and would be cut to 124.
pub fn padding_samples(rate: SampleRate, samples: usize) -> usize {
    let padding = (end_padding_s() * rate.rounded())
        .round()
        .max(LEAST_PADDING_SAMPLES);
    let padding = padding as usize;
    padding.min(samples.saturating_sub(1))
}

/// Extends a record by `padding` < `samples.len()` points at each end, mirrored at the end points.
pub(super) fn extend(samples: &[f64], padding: usize) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (samples.first(), samples.last()) else {
        return Vec::new();
    };
    let count = samples.len();
    let mut extended = Vec::with_capacity(count + 2 * padding);
    extended.extend((1..=padding).rev().map(|i| 2.0 * first - samples[i]));
    extended.extend_from_slice(samples);
    extended.extend((1..=padding).map(|i| 2.0 * last - samples[count - 1 - i]));
    extended
}

fn both_passes(work: &mut [f64], pass: impl Fn(&mut [f64])) {
    pass(work);
    work.reverse();
    pass(work);
    work.reverse();
}

fn start_mean(work: &[f64]) -> f64 {
    let head = &work[..work.len().min(START_MEAN_SAMPLES)];
    let count = head.len().max(1) as f64;
    head.iter().sum::<f64>() / count
}

/// Runs one pass in place; the first two outputs are `start`.
fn one_pass(work: &mut [f64], c: Coefficients, start: f64) {
    let (mut x2, mut x1) = (0.0, 0.0);
    let (mut y2, mut y1) = (start, start);
    for (index, value) in work.iter_mut().enumerate() {
        let x0 = *value;
        if index < 2 {
            *value = start;
        } else {
            let y0 = c.a0 * x0 + c.a1 * x1 + c.a2 * x2 + c.b1 * y1 + c.b2 * y2;
            y2 = y1;
            y1 = y0;
            *value = y0;
        }
        x2 = x1;
        x1 = x0;
    }
}
