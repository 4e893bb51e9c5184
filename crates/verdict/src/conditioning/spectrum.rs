//! Amplitude spectra and spectrograms, for reports.
//!
//! Transforms run on the scalar planner of `rustfft`, which takes the same path on every
//! processor, so that the same signal gives the same bytes.

use super::{Signal, peak};
use latchgate_kernel::units::SampleRate;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Longest stretch that one amplitude spectrum takes in.
const LONGEST_SPECTRUM: usize = 1 << 20;

/// Longest window of a spectrogram [s].
const WINDOW_S: f64 = 0.025;

/// Shortest and longest window of a spectrogram in samples.
const WINDOW_SAMPLES: (usize, usize) = (8, 4096);

/// Most windows of a spectrogram.
const MOST_COLUMNS: usize = 300;

/// One-sided amplitude spectrum: a pure tone of amplitude A shows A at its frequency.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AmplitudeSpectrum {
    /// Frequencies [Hz].
    pub frequency_hz: Vec<f64>,
    /// Amplitudes [m/s²].
    pub amplitude_m_s2: Vec<f64>,
}

/// Short-time amplitude spectrum.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spectrogram {
    /// Centres of the windows [s].
    pub time_s: Vec<f64>,
    /// Frequencies [Hz].
    pub frequency_hz: Vec<f64>,
    /// Amplitudes [m/s²], one row per time, `frequency_hz.len()` long.
    pub amplitude_m_s2: Vec<Vec<f64>>,
    /// Length of the window [s].
    pub window_s: f64,
}

/// Returns the amplitude spectrum of the whole signal: rectangular window, mean left in, no
/// zeros added.
///
/// A tone whose period divides the record shows its amplitude; one between two frequencies
/// shows down to 64 % of it. The squares add up to the signal's mean square: half the square of
/// each amplitude, the whole square at 0 and at the Nyquist frequency. Of records beyond
/// 1 048 576 samples, that many around the largest are taken.
pub fn amplitude_spectrum(signal: &Signal) -> AmplitudeSpectrum {
    let samples = stretch_around_peak(signal);
    let count = samples.len();
    if count == 0 {
        return AmplitudeSpectrum::default();
    }
    let mut work: Vec<Complex<f64>> = samples
        .iter()
        .map(|value| Complex::new(*value, 0.0))
        .collect();
    FftPlannerScalar::new()
        .plan_fft_forward(count)
        .process(&mut work);
    AmplitudeSpectrum {
        frequency_hz: frequencies(signal.rate, count),
        amplitude_m_s2: amplitudes(&work, count as f64),
    }
}

/// Returns the spectrogram of the signal.
///
/// Hann windows of a power of two samples, at most 25 ms long and at most a quarter of the record,
/// each a quarter of a window after the one before; long records are thinned to 300 windows, between
/// which samples may be left out. A tone shows its amplitude (85 % of it between two frequencies).
/// Records of fewer than 8 samples give none.
pub fn spectrogram(signal: &Signal) -> Spectrogram {
    let count = signal.samples.len();
    let (shortest, longest) = WINDOW_SAMPLES;
    if count < shortest {
        return Spectrogram::default();
    }
    let window_samples = (WINDOW_S * signal.rate.hertz()) as usize;
    let window_samples = window_samples.min(count / 4).clamp(shortest, longest);
    let length = 1_usize << window_samples.ilog2();
    let hop = (length / 4)
        .max((count - length).div_ceil(MOST_COLUMNS - 1))
        .max(1);
    let (firsts, amplitudes) = hann_windows(&signal.samples, length, length, hop);
    Spectrogram {
        time_s: firsts
            .into_iter()
            .map(|first| signal.time_s(first + length / 2))
            .collect(),
        frequency_hz: frequencies(signal.rate, length),
        amplitude_m_s2: amplitudes,
        window_s: length as f64 / signal.rate.hertz(),
    }
}

/// Short-time amplitude spectrum of anything.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShortTime {
    /// Centres of the windows [s].
    pub time_s: Vec<f64>,
    /// Frequencies [Hz].
    pub frequency_hz: Vec<f64>,
    /// Amplitudes in the unit of the samples, one row per time, `frequency_hz.len()` long.
    pub amplitudes: Vec<Vec<f64>>,
    /// Length of the window [s].
    pub window_s: f64,
}

/// Returns the short-time amplitudes of `samples`: Hann windows of `length` samples, about
/// `columns` of them, filled up with zeros to a power of two of at least four times their length, so
/// that lines stand closer than the window resolves. A tone shows its amplitude.
///
/// Fewer samples than a window, or a window of fewer than 8 samples, give none.
pub fn short_time(
    samples: &[f64],
    start_s: f64,
    rate: SampleRate,
    length: usize,
    columns: usize,
) -> ShortTime {
    let count = samples.len();
    if length < WINDOW_SAMPLES.0 || count < length {
        return ShortTime::default();
    }
    let padded = (4 * length).next_power_of_two();
    let hop = (count - length).div_ceil(columns.max(2) - 1).max(1);
    let (firsts, amplitudes) = hann_windows(samples, length, padded, hop);
    ShortTime {
        time_s: firsts
            .into_iter()
            .map(|first| start_s + (first as f64 + 0.5 * length as f64) / rate.hertz())
            .collect(),
        frequency_hz: frequencies(rate, padded),
        amplitudes,
        window_s: length as f64 / rate.hertz(),
    }
}

/// Returns the first sample of each window, and its amplitudes; `padded` is the length of the
/// transform.
fn hann_windows(
    samples: &[f64],
    length: usize,
    padded: usize,
    hop: usize,
) -> (Vec<usize>, Vec<Vec<f64>>) {
    let window: Vec<f64> = (0..length)
        .map(|index| 0.5 - 0.5 * libm::cos(2.0 * PI * index as f64 / length as f64))
        .collect();
    let weight: f64 = window.iter().sum();
    let transform = FftPlannerScalar::new().plan_fft_forward(padded);
    let mut work = vec![Complex::new(0.0, 0.0); padded];
    let mut scratch = vec![Complex::new(0.0, 0.0); transform.get_inplace_scratch_len()];
    let (mut firsts, mut rows) = (Vec::new(), Vec::new());
    for first in (0..=samples.len() - length).step_by(hop) {
        work.fill(Complex::new(0.0, 0.0));
        for ((slot, value), weight) in work.iter_mut().zip(&samples[first..]).zip(&window) {
            *slot = Complex::new(value * weight, 0.0);
        }
        transform.process_with_scratch(&mut work, &mut scratch);
        firsts.push(first);
        rows.push(amplitudes(&work, weight));
    }
    (firsts, rows)
}

fn stretch_around_peak(signal: &Signal) -> &[f64] {
    let count = signal.samples.len();
    if count <= LONGEST_SPECTRUM {
        return &signal.samples;
    }
    let first = peak(signal)
        .unwrap_or(0)
        .saturating_sub(LONGEST_SPECTRUM / 2)
        .min(count - LONGEST_SPECTRUM);
    &signal.samples[first..first + LONGEST_SPECTRUM]
}

fn frequencies(rate: SampleRate, length: usize) -> Vec<f64> {
    (0..=length / 2)
        .map(|line| line as f64 * rate.hertz() / length as f64)
        .collect()
}

/// One-sided amplitudes of a transform; `weight` is the sum of the window.
fn amplitudes(transform: &[Complex<f64>], weight: f64) -> Vec<f64> {
    let length = transform.len();
    (0..=length / 2)
        .map(|line| {
            let both_sides = if line == 0 || 2 * line == length {
                1.0
            } else {
                2.0
            };
            let value = transform[line];
            both_sides * libm::hypot(value.re, value.im) / weight
        })
        .collect()
}
