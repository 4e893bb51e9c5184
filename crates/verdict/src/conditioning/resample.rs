//! Band-limited resampling with a Kaiser-windowed sinc.
//!
//! Decimating without a filter folds what lies above the new Nyquist frequency into the
//! lever's own band: a tone of 1040 Hz taken at 1 kHz becomes one of 40 Hz with its full
//! amplitude. Linear interpolation on the way up weakens a tone at a tenth of the rate by
//! 3 %. Both are avoided here.
//!
//! - Down: the pass band reaches to 0.8 of the new Nyquist frequency (ripple 1e-6), and from
//!   that frequency on everything is weakened by 120 dB; between them lies the transition.
//! - Up: the kernel is a Nyquist kernel of the old rate, so old samples that fall on new
//!   instants stay as they are. Tones up to 0.8 of the old Nyquist frequency are kept to 1e-6,
//!   and images above 1.2 of it are weakened by 120 dB.
//! - Ends: the record is extended by its point mirror, as ISO 6487 does, and beyond the
//!   mirrored record by the last mirrored value. Within the kernel's half-length of an end,
//!   the output is therefore partly assumed.
//! - The weights of each output sample are divided by their sum: a constant stays that constant.

use super::Signal;
use latchgate_kernel::units::SampleRate;
use latchgate_recording::Limits;
use latchgate_recording::error::Error;
use std::f64::consts::PI;

/// Kaiser's β for side lobes at −120 dB: 0.1102 (A − 8.7).
///
/// # Source
///
/// J. F. Kaiser, Nonrecursive digital filter design using the I0-sinh window function,
/// IEEE Symposium on Circuits and Systems, 1974.
pub(super) const KAISER_BETA: f64 = 0.1102 * (120.0 - 8.7);

/// Half-length of the kernel in intervals of the lower rate. Kaiser's formula asks for
/// (A − 8)/(2.285·2π·0.1)/2 = 39 for a transition over a tenth of the lower rate.
const HALF_LENGTH: usize = 40;

/// Cut-off when going down, as a part of the new Nyquist frequency: the middle of the transition.
const CUTOFF_DOWN: f64 = 0.9;

/// Entries of the kernel's table per interval of the lower rate. Four-point interpolation
/// then errs by less than 1e-9 of the kernel's peak.
const TABLE_DENSITY: usize = 256;

/// Least rate that is made [Hz]; below it no recording is judged.
pub const LEAST_RATE_HZ: f64 = 250.0;

/// Longest kernel in lengths of the record.
const LONGEST_KERNEL: usize = 4;

/// Returns the signal at another rate, its first sample at the same instant.
///
/// The native rate (equal when both are rounded to 1e-4 Hz) gives the signal bit for bit.
///
/// # Errors
///
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) below [`LEAST_RATE_HZ`] or if more samples would come
/// out than [`Limits`] lets in; [`TooShort`](latchgate_kernel::error::Error::TooShort) if the record is a small part
/// of the kernel.
pub fn resample(signal: &Signal, to: SampleRate) -> Result<Signal, Error> {
    if is_native(signal, to) {
        return Ok(signal.clone());
    }
    let (old_hz, new_hz) = (signal.rate.hertz(), to.hertz());
    if to.rounded() < LEAST_RATE_HZ {
        return Err(out_of_range(
            "resampled rate [Hz]",
            format!("at least {LEAST_RATE_HZ}, the least that is judged"),
            format!("{new_hz}"),
        ));
    }
    let count = signal.samples.len();
    if count == 0 {
        return Ok(Signal {
            start_s: signal.start_s,
            rate: to,
            samples: Vec::new(),
        });
    }
    // A new instant that misses the last sample by rounding alone still counts.
    let intervals = ((count - 1) as f64 * new_hz / old_hz + 1e-6).floor();
    let sample_limit = Limits::default().samples;
    if intervals + 1.0 > sample_limit as f64 {
        return Err(out_of_range(
            "resampled rate [Hz]",
            format!("low enough to give at most {sample_limit} samples"),
            format!("{new_hz}, which gives {}", intervals + 1.0),
        ));
    }
    let half = half_length_samples(signal.rate, to);
    if half > (LONGEST_KERNEL * count) as f64 {
        return Err(Error::too_short(
            "resampling to this rate",
            as_index(half / LONGEST_KERNEL as f64) + 1,
            count,
        ));
    }
    let padding = as_index(half) + 2;
    let extended = extend_and_hold(&signal.samples, padding);
    let kernel = SincKernel::new(if new_hz < old_hz { CUTOFF_DOWN } else { 1.0 });
    let step = (new_hz / old_hz).min(1.0);
    let samples = (0..=as_index(intervals))
        .map(|index| {
            let position = index as f64 * old_hz / new_hz + padding as f64;
            kernel.sum(&extended, position, step)
        })
        .collect();
    Ok(Signal {
        start_s: signal.start_s,
        rate: to,
        samples,
    })
}

/// Tells whether a rate is the signal's own, to 1e-4 Hz.
pub fn is_native(signal: &Signal, to: SampleRate) -> bool {
    (signal.rate.rounded() - to.rounded()).abs() < 0.5e-4
}

/// Returns the stretch at each end of a resampled record that rests on assumed samples [s].
pub fn end_padding_s(from: SampleRate, to: SampleRate) -> f64 {
    half_length_samples(from, to) / from.hertz()
}

fn half_length_samples(from: SampleRate, to: SampleRate) -> f64 {
    HALF_LENGTH as f64 * (from.hertz() / to.hertz()).max(1.0)
}

/// Returns Σ wᵢ xᵢ as four sums side by side, which do not wait for one another.
#[inline(always)]
fn weighted_sum<const TAPS: usize>(weights: &[f64; TAPS], values: &[f64; TAPS]) -> f64 {
    let mut sums = [0.0; 4];
    for (weights, values) in weights
        .as_chunks::<4>()
        .0
        .iter()
        .zip(values.as_chunks::<4>().0)
    {
        for lane in 0..4 {
            sums[lane] += weights[lane] * values[lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Returns what of the samples lies above 0.8 of the Nyquist frequency: a motion of six samples a period
/// or more leaves 2e-5 of itself, a corner or jump a part of its size. A sinc of 65 samples under
/// Kaiser's window is taken away.
pub fn near_nyquist(signal: &Signal) -> Vec<f64> {
    const HALF: usize = 32;
    const TAPS: usize = 2 * HALF + 4;
    const BETA: f64 = 10.0;
    let mut weights = [0.0; TAPS];
    for (tap, weight) in weights.iter_mut().enumerate().take(2 * HALF + 1) {
        let distance = tap as f64 - HALF as f64;
        *weight = sinc(0.8 * distance) * kaiser(distance / HALF as f64, BETA);
    }
    let sum: f64 = weights.iter().sum();
    let weights = weights.map(|weight| weight / sum);
    let mut extended = extend_and_hold(&signal.samples, HALF);
    extended.extend([0.0; TAPS - 2 * HALF - 1]);
    let of_each = signal.samples.iter().zip(extended.array_windows());
    of_each
        .map(|(sample, window)| sample - weighted_sum(&weights, window))
        .collect()
}

/// Extends by the point mirror as far as there are samples, then by the last mirrored value.
pub(super) fn extend_and_hold(samples: &[f64], padding: usize) -> Vec<f64> {
    let mirrored = padding.min(samples.len().saturating_sub(1));
    let middle = super::cfc::extend(samples, mirrored);
    let (Some(&first), Some(&last)) = (middle.first(), middle.last()) else {
        return Vec::new();
    };
    let repeated = padding - mirrored;
    let mut extended = Vec::with_capacity(middle.len() + 2 * repeated);
    extended.resize(repeated, first);
    extended.extend_from_slice(&middle);
    extended.resize(middle.len() + 2 * repeated, last);
    extended
}

/// The windowed sinc, tabulated over its right half.
struct SincKernel {
    table: Vec<f64>,
}

impl SincKernel {
    /// Builds a kernel whose cut-off is `cutoff` times the Nyquist frequency of the lower rate.
    fn new(cutoff: f64) -> Self {
        // One entry before zero and two after the end serve the four-point interpolation.
        let peak = kaiser(0.0, KAISER_BETA);
        let table = (0..HALF_LENGTH * TABLE_DENSITY + 4)
            .map(|entry| {
                let distance = (entry as f64 - 1.0) / TABLE_DENSITY as f64;
                sinc(cutoff * distance)
                    * (kaiser(distance / HALF_LENGTH as f64, KAISER_BETA) / peak)
            })
            .collect();
        Self { table }
    }

    /// Returns the kernel at a distance in intervals of the lower rate.
    fn at(&self, distance: f64) -> f64 {
        let scaled = distance.abs() * TABLE_DENSITY as f64;
        let entry = as_index(scaled.floor());
        let x = scaled - scaled.floor();
        match self.table.get(entry..entry + 4) {
            // Lagrange through the entries at −1, 0, 1 and 2.
            Some(&[a, b, c, d]) => {
                let (xm, x1, x2) = (x + 1.0, x - 1.0, x - 2.0);
                -a * x * x1 * x2 / 6.0 + b * xm * x1 * x2 / 2.0 - c * xm * x * x2 / 2.0
                    + d * xm * x * x1 / 6.0
            }
            _ => 0.0,
        }
    }

    /// Returns the weighted mean of `samples` around `position`; `step` is the distance of two
    /// samples in intervals of the lower rate.
    fn sum(&self, samples: &[f64], position: f64, step: f64) -> f64 {
        let reach = HALF_LENGTH as f64 / step;
        let first = as_index((position - reach).ceil().max(0.0));
        let last = as_index((position + reach).floor()).min(samples.len().saturating_sub(1));
        let (mut sum, mut weights) = (0.0, 0.0);
        for (index, sample) in samples.iter().enumerate().take(last + 1).skip(first) {
            let weight = self.at((index as f64 - position) * step);
            sum += weight * sample;
            weights += weight;
        }
        sum / weights
    }
}

/// sin(πx)/(πx), exactly 0 at every other whole number.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-12 {
        1.0
    } else if (x - x.round()).abs() < 1e-15 {
        0.0
    } else {
        libm::sin(PI * x) / (PI * x)
    }
}

/// Kaiser's window at `x` half-lengths from its middle, times I0(β), which the division of
/// the weights by their sum takes out again.
fn kaiser(x: f64, beta: f64) -> f64 {
    let inside = 1.0 - x * x;
    if inside < 0.0 {
        return 0.0;
    }
    bessel_i0(beta * inside.sqrt())
}

/// Modified Bessel function of the first kind and order zero, by its power series.
pub(super) fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut sum, mut term, mut order) = (1.0, 1.0, 1.0);
    while term > sum * 1e-17 {
        term *= quarter / (order * order);
        sum += term;
        order += 1.0;
    }
    sum
}

fn out_of_range(what: &str, expected: String, found: String) -> Error {
    Error::out_of_range(what, expected, found)
}

fn as_index(value: f64) -> usize {
    value as usize
}
