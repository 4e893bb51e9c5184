//! Bias: the mean of the samples before the event, with its standard error.
//!
//! For a latch lever the bias is the most dangerous error of a recording: 0.1 g that is left
//! in over 0.33 s is 0.32 m/s, most of the velocity that opens a weak lever.

use super::{BiasWindow, Signal};
use crate::error::{Error, ErrorKind};
use crate::recording::Finding;

/// How the standard error counts correlated samples.
pub const STANDARD_ERROR_METHOD: &str = "integrated autocorrelation time, Geyer's initial positive sequence; never below σ/√n of independent samples";

/// The pre-event window ends this long before time zero [s].
pub const PRE_EVENT_END_S: f64 = -1e-3;

/// The pre-event window spans at least this long [s].
pub const PRE_EVENT_LEAST_SPAN_S: f64 = 5e-3;

/// Part of a sample interval by which an instant may miss a sample and still mean it.
///
/// Windows are counted by sample index; stamps are printed with few digits.
const INDEX_TOLERANCE: f64 = 0.01;

/// Samples, or means of neighbouring samples, whose autocorrelation is summed.
const CORRELATED_SAMPLES: usize = 4096;

/// The bias of a channel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bias {
    /// Mean to remove [m/s²]; 0 if there is no window.
    pub mean_m_s2: f64,
    /// Standard error of the mean, correlation of the samples counted [m/s²].
    pub standard_error_m_s2: f64,
    /// Standard deviation of the samples [m/s²].
    pub standard_deviation_m_s2: f64,
    /// First sample of the window and the number of samples.
    pub window: Option<(usize, usize)>,
}

/// Returns the bias in a window, and what is odd about it.
///
/// # Errors
///
/// [`ErrorKind::OutOfRange`] if a named window is not an interval or holds fewer than two samples.
pub fn bias(signal: &Signal, window: BiasWindow) -> Result<(Bias, Vec<Finding>), Error> {
    match window {
        BiasWindow::None => Ok((Bias::default(), Vec::new())),
        BiasWindow::PreEvent => Ok(match pre_event_samples(signal) {
            Some(count) => (of_samples(signal, 0, count), Vec::new()),
            None => (
                Bias::default(),
                vec![Finding::warning(
                    "no-pre-event-data",
                    "fewer than 5 ms of samples before -1 ms, so no bias was removed; an unknown \
                     bias adds velocity over the whole record. Name a quiet window with the setting `bias` = \
                     START..END, or the instant of first contact with the setting `time_zero`",
                )],
            ),
        }),
        BiasWindow::Window(from_s, to_s) => named(signal, from_s, to_s).map(|bias| (bias, vec![])),
    }
}

/// Returns how many samples lie at t ≤ −1 ms, if they span at least 5 ms.
#[must_use]
pub fn pre_event_samples(signal: &Signal) -> Option<usize> {
    let count = samples_until(signal, PRE_EVENT_END_S);
    let span = count.saturating_sub(1) as f64;
    let least = PRE_EVENT_LEAST_SPAN_S * signal.rate.hertz() - INDEX_TOLERANCE;
    (count >= 2 && span >= least).then_some(count)
}

fn named(signal: &Signal, from_s: f64, to_s: f64) -> Result<Bias, Error> {
    let refuse = |expected: String, found: String| -> Error {
        ErrorKind::OutOfRange {
            what: "bias window [s]".into(),
            expected,
            found,
        }
        .into()
    };
    if !(from_s.is_finite() && to_s.is_finite() && from_s < to_s) {
        return Err(refuse(
            "a start before an end".into(),
            format!("{from_s}..{to_s}"),
        ));
    }
    let until = samples_until(signal, to_s);
    let first = samples_before(signal, from_s).min(until);
    let count = until - first;
    if count < 2 {
        return Err(refuse(
            format!(
                "an interval that holds at least two samples of the record, which runs from {} to {}",
                signal.start_s,
                signal.end_s()
            ),
            format!("{from_s}..{to_s} with {count}"),
        ));
    }
    Ok(of_samples(signal, first, count))
}

fn of_samples(signal: &Signal, first: usize, count: usize) -> Bias {
    let samples = &signal.samples[first..first + count];
    let mean = mean(samples);
    Bias {
        mean_m_s2: mean,
        standard_error_m_s2: standard_error_of_mean(samples),
        standard_deviation_m_s2: (sum_of_squares(samples, mean)
            / count.saturating_sub(1).max(1) as f64)
            .sqrt(),
        window: Some((first, count)),
    }
}

/// Returns the number of samples at or before an instant.
fn samples_until(signal: &Signal, instant_s: f64) -> usize {
    let position = (instant_s - signal.start_s) * signal.rate.hertz();
    count_from((position + INDEX_TOLERANCE).floor() + 1.0, signal)
}

/// Returns the number of samples before an instant.
fn samples_before(signal: &Signal, instant_s: f64) -> usize {
    let position = (instant_s - signal.start_s) * signal.rate.hertz();
    count_from((position - INDEX_TOLERANCE).ceil(), signal)
}

fn count_from(count: f64, signal: &Signal) -> usize {
    (count as usize).min(signal.samples.len())
}

/// Returns the standard error of the mean of correlated samples.
///
/// The variance of the mean is v = (γ(0) + 2 Σ γ(k))/n. The sum ends before the first pair
/// γ(2m) + γ(2m+1) that is not positive. As the mean is estimated from the same samples, each of
/// the 2K + 1 terms is low by v itself, which turns n into n − 2K − 1 (at least n/2).
/// More than 4096 samples are first averaged over neighbours, which leaves their mean as it
/// is. A window that is not several correlation times long cannot tell its own error: drift
/// over the whole of it is seen in part only.
///
/// # Source
///
/// C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992), section 3.3.
#[must_use]
pub fn standard_error_of_mean(samples: &[f64]) -> f64 {
    let count = samples.len();
    if count < 2 {
        return 0.0;
    }
    let total = count as f64;
    let independent = (sum_of_squares(samples, mean(samples)) / (total - 1.0) / total).sqrt();
    let block = count.div_ceil(CORRELATED_SAMPLES);
    let averaged: Vec<f64> = samples.chunks_exact(block).map(mean).collect();
    correlated_error(&averaged).max(independent)
}

fn correlated_error(values: &[f64]) -> f64 {
    let count = values.len();
    let total = count as f64;
    let centre = mean(values);
    let deviations: Vec<f64> = values.iter().map(|value| value - centre).collect();
    let covariance = |lag: usize| -> f64 {
        deviations
            .iter()
            .zip(&deviations[lag..])
            .map(|(a, b)| a * b)
            .sum::<f64>()
            / total
    };
    let variance = covariance(0);
    if variance <= 0.0 {
        return 0.0;
    }
    let (mut pairs, mut lags) = (0.0, 0);
    for even in (0..count.saturating_sub(1)).step_by(2) {
        let pair = covariance(even) + covariance(even + 1);
        if pair <= 0.0 {
            break;
        }
        pairs += pair;
        lags = even + 1;
    }
    let summed = (2.0 * pairs - variance).max(variance);
    let taken = (2 * lags + 1) as f64;
    (summed / (total - taken).max(total / 2.0)).sqrt()
}

fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len().max(1) as f64
}

fn sum_of_squares(samples: &[f64], centre: f64) -> f64 {
    samples
        .iter()
        .map(|value| (value - centre) * (value - centre))
        .sum()
}
