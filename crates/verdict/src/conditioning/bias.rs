//! Bias: the mean of the samples before the event, with its standard error.
//!
//! For a latch lever the bias is the most dangerous error of a recording: 0.1 g that is left
//! in over 0.33 s is 0.32 m/s, most of the velocity that opens a weak lever.

use super::{BiasWindow, Conditioned, Signal};
use latchgate_kernel::range::Window;
use latchgate_kernel::units::{STANDARD_GRAVITY, plain};
use latchgate_recording::Finding;
use latchgate_recording::error::Error;

/// How the standard error counts correlated samples.
pub const STANDARD_ERROR_METHOD: &str = "the largest of: integrated autocorrelation time by Geyer's initial positive sequence; a first-order autoregression of the samples and of means of 4 and 16, its coefficient taken one standard deviation high; σ/√n of independent samples; the noise itself, where it is at most half the recorder's step";

/// The pre-event window ends this long before time zero [s].
pub const PRE_EVENT_END_S: f64 = -1e-3;

/// The pre-event window spans at least this long [s].
pub const PRE_EVENT_LEAST_SPAN_S: f64 = 5e-3;

/// Samples of a quiet stretch that show one order of the noise's spectrum.
pub const SAMPLES_PER_ORDER: usize = 20;

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
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) if a named window is not an interval or holds fewer than
/// two samples.
pub fn bias(signal: &Signal, window: BiasWindow) -> Result<(Bias, Vec<Finding>), Error> {
    match window {
        BiasWindow::None => Ok((Bias::default(), Vec::new())),
        BiasWindow::PreEvent => Ok(match pre_event_samples(signal) {
            Some(count) => {
                let bias = of_samples(signal, 0, count);
                let findings = too_short(signal, &bias).into_iter().collect();
                (bias, findings)
            }
            None => (
                Bias::default(),
                vec![Finding::warning(
                    "no-pre-event-data",
                    "no bias was removed: fewer than 5 ms of samples lie before -1 ms. An unknown \
                     bias adds velocity over the whole record. Name a quiet window with the \
                     setting `bias` = START..END, or first contact with the setting `time_zero` = \
                     S",
                )],
            ),
        }),
        BiasWindow::Window(window) => named(signal, window).map(|bias| {
            let doubtful = doubtful(signal, &bias).into_iter();
            let findings = doubtful.chain(too_short(signal, &bias)).collect();
            (bias, findings)
        }),
    }
}

/// Returns how many samples lie at t ≤ −1 ms, if they span at least 5 ms.
pub fn pre_event_samples(signal: &Signal) -> Option<usize> {
    let count = samples_until(signal, PRE_EVENT_END_S);
    let span = count.saturating_sub(1) as f64;
    let least = PRE_EVENT_LEAST_SPAN_S * signal.rate.hertz() - INDEX_TOLERANCE;
    (count >= 2 && span >= least).then_some(count)
}

/// Returns how many samples lie at t ≤ −1 ms, if they show the noise: the quiet stretch of the bias, or a shorter
/// one for which one order can be fitted.
pub fn noise_samples(signal: &Signal) -> Option<usize> {
    let count = samples_until(signal, PRE_EVENT_END_S);
    pre_event_samples(signal).or((count >= SAMPLES_PER_ORDER).then_some(count))
}

/// The white noise of recorded samples.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Noise {
    /// Standard deviation: that of the samples before the event, where there are enough, and at least that of
    /// rounding to the recorder's step [m/s²].
    pub deviation_m_s2: f64,
    /// The recorder's step, or the least difference between neighbours where the samples lie on no grid [m/s²].
    pub step_m_s2: f64,
    /// The samples lie on a grid of that step.
    pub on_grid: bool,
}

impl Noise {
    /// Tells whether rounding to the recorder's step is all there is.
    pub fn is_rounding(&self) -> bool {
        let spread = 12.0_f64.sqrt() * self.deviation_m_s2;
        self.on_grid && spread <= self.step_m_s2 * (1.0 + 1e-9)
    }

    /// Tells whether the samples of a flat top may all be off to the same side: the noise spreads them over no more
    /// than half a step of the recorder.
    pub fn may_be_offset(&self) -> bool {
        self.on_grid && self.deviation_m_s2 <= 0.5 * self.step_m_s2
    }
}

/// Returns the white noise of recorded samples.
pub(super) fn noise(raw: &Signal) -> Noise {
    let (step_m_s2, on_grid) = step_m_s2(&raw.samples);
    let rounding = step_m_s2 / 12.0_f64.sqrt();
    let deviation_m_s2 = noise_samples(raw).map_or(rounding, |count| {
        let quiet = &raw.samples[..count];
        let variance = sum_of_squares(quiet, mean(quiet)) / (count - 1) as f64;
        rounding.max(variance.sqrt())
    });
    Noise {
        deviation_m_s2,
        step_m_s2,
        on_grid,
    }
}

/// Returns the recorder's step [m/s²], and whether the samples lie on a grid of it; the least difference
/// between neighbours that are not equal where they do not.
fn step_m_s2(samples: &[f64]) -> (f64, bool) {
    /// Part of the largest magnitude below which a difference is that of two roundings of one number.
    const ROUNDING: f64 = 1e-12;
    /// Of so many differences one may be none of the grid, and of fewer one as well.
    const ODD: usize = 20;
    /// Multiples of the step that are held against the grid: larger ones tell a step that is known to few
    /// digits.
    const MULTIPLES: f64 = 8.0;
    /// Part of a step by which a multiple may miss.
    const MISS: f64 = 0.02;
    let largest = samples.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    let steps = samples.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > ROUNDING * largest).collect();
    if steps.len() < 2 {
        return (steps.first().copied().unwrap_or(0.0), false);
    }
    let few = (steps.len() / ODD).clamp(1, steps.len() - 1);
    let (_, step, _) = steps.select_nth_unstable_by(few, f64::total_cmp);
    let step = *step;
    let multiples = steps
        .iter()
        .map(|of| of / step)
        .filter(|of| *of < MULTIPLES);
    let off = multiples.filter(|of| (of - of.round()).abs() > MISS);
    if off.count() <= few {
        return (step, true);
    }
    (steps.into_iter().fold(f64::INFINITY, f64::min), false)
}

/// Part of the recording's peak beyond which a window that moves so far from its mean is loud.
const LOUD_PART: f64 = 0.1;

/// Part of the peak beyond which a window holds signal.
const SIGNAL_PART: f64 = 0.25;

/// Returns the largest distance of a window's samples from their mean by the recording's largest
/// magnitude [-].
fn loudness(signal: &Signal, first: usize, count: usize, mean_m_s2: f64) -> f64 {
    let largest_distance = |samples: &[f64], from: f64| {
        let sizes = samples.iter().map(|a| (a - from).abs());
        sizes.fold(0.0, f64::max)
    };
    let peak = largest_distance(&signal.samples, mean_m_s2);
    if peak > 0.0 {
        largest_distance(&signal.samples[first..first + count], mean_m_s2) / peak
    } else {
        0.0
    }
}

fn reaches_event(signal: &Signal, first: usize, count: usize) -> bool {
    first + count > samples_until(signal, PRE_EVENT_END_S)
}

/// Returns a finding for a window that was named where nothing is quiet.
fn doubtful(signal: &Signal, bias: &Bias) -> Option<Finding> {
    let (first, count) = bias.window?;
    let loudness = loudness(signal, first, count, bias.mean_m_s2);
    let reaches = reaches_event(signal, first, count);
    if !reaches && loudness <= LOUD_PART {
        return None;
    }
    let where_it_lies = if reaches {
        "reaches past -1 ms, into the event"
    } else {
        "is not quiet"
    };
    let end_s = signal.time_s(first + count - 1);
    Some(
        Finding::warning(
            "bias-window-doubtful",
            format!(
                "the removed bias of {} g is the mean from {} to {} s. That window \
                 {where_it_lies}. Its samples lie up to {} % of the peak off the mean. Name a \
                 quiet window before contact with the setting `bias` = START..END",
                plain(bias.mean_m_s2 / STANDARD_GRAVITY, 4),
                plain(signal.time_s(first), 6),
                plain(end_s, 6),
                plain(100.0 * loudness, 2),
            ),
        )
        .at(end_s),
    )
}

/// Returns a finding for a window in which the zero moves too slowly for its mean to be known to a
/// tenth of g, the scatter of a design that states none.
fn too_short(signal: &Signal, bias: &Bias) -> Option<Finding> {
    const KNOWN_TO_G: f64 = 0.1;
    // Of the peak; below it the bias is no matter.
    const KNOWN_TO_PART: f64 = 2e-3;
    let error_g = bias.standard_error_m_s2 / STANDARD_GRAVITY;
    let sizes = signal.samples.iter().map(|a| a.abs() / STANDARD_GRAVITY);
    let peak_g = sizes.fold(0.0, f64::max);
    let (first, count) = bias.window?;
    if loudness(signal, first, count, bias.mean_m_s2) > SIGNAL_PART {
        // That it is not quiet is said.
        return None;
    }
    (error_g > KNOWN_TO_G.max(KNOWN_TO_PART * peak_g)).then(|| {
        Finding::warning(
            "bias-uncertain",
            format!(
                "the sensor's zero is uncertain by ±{} g (one standard error). Its samples drift \
                 slowly, and a drift slower than their window does not show. Record a longer quiet \
                 stretch before contact",
                plain(error_g, 2)
            ),
        )
    })
}

/// Tells whether the bias that was removed is so doubtful that the recording must pass without it
/// as well: its window holds signal, or reaches past −1 ms or is loud with a mean beyond 1 g.
pub fn must_pass_without(conditioned: &Conditioned) -> bool {
    let (raw, mean) = (&conditioned.raw, conditioned.bias_m_s2);
    let Some(window) = conditioned.bias_window_s else {
        return false;
    };
    let (first, count) = (samples_before(raw, window.from_s), conditioned.bias_samples);
    let loudness = loudness(raw, first, count, mean);
    let doubtful = loudness > LOUD_PART || reaches_event(raw, first, count);
    loudness > SIGNAL_PART || (doubtful && mean.abs() > STANDARD_GRAVITY)
}

fn named(signal: &Signal, Window { from_s, until_s }: Window) -> Result<Bias, Error> {
    let refuse = |expected: String, found: String| -> Error {
        Error::out_of_range("bias window [s]", expected, found)
    };
    if !(from_s.is_finite() && until_s.is_finite() && from_s < until_s) {
        return Err(refuse(
            "a start before an end".into(),
            format!("{from_s}..{until_s}"),
        ));
    }
    let until = samples_until(signal, until_s);
    let first = samples_before(signal, from_s).min(until);
    let count = until - first;
    if count < 2 {
        return Err(refuse(
            format!(
                "an interval with at least two samples of the record, which runs from {} to {}",
                signal.start_s,
                signal.end_s()
            ),
            format!("{from_s}..{until_s} with {count}"),
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
/// is. A window that is not several correlation times long holds too little of slow noise for
/// any sum: there the noise is taken to be an autoregression of first order, whose coefficient,
/// corrected for the mean that was removed and taken one standard deviation high, says what the
/// window cannot see. The larger of both is the error, at most 1.2 standard deviations of the
/// samples. On such noise the bias is 0.6 to 1.1 errors (rms) up to a correlation of 0.995 a sample
/// in 500; where white noise covers a slow one of equal size it may be 1.6.
///
/// # Source
///
/// C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992), section 3.3;
/// M. G. Kendall, Note on bias in the estimation of autocorrelation, Biometrika 41 (1954).
pub fn standard_error_of_mean(samples: &[f64]) -> f64 {
    /// Neighbours averaged before the autoregression is fitted.
    const MEANS_OF: [usize; 3] = [1, 4, 16];
    let count = samples.len();
    if count < 2 {
        return 0.0;
    }
    let total = count as f64;
    let independent = (sum_of_squares(samples, mean(samples)) / (total - 1.0) / total).sqrt();
    let block = count.div_ceil(CORRELATED_SAMPLES);
    let means_of =
        |values: &[f64], of: usize| -> Vec<f64> { values.chunks_exact(of).map(mean).collect() };
    let averaged = means_of(samples, block);
    let slow = MEANS_OF.map(|of| autoregressive_error(&means_of(&averaged, of)));
    slow.into_iter()
        .fold(correlated_error(&averaged).max(independent), f64::max)
}

/// Returns the standard error of the mean of an autoregression of first order that fits `values`;
/// 0 of too few, and of values that none fits: the steps of one do not go on as they began, as
/// those of a vibration do, which the sum of correlations sees.
fn autoregressive_error(values: &[f64]) -> f64 {
    /// Correlation of a step with the next beyond which the values are a smooth motion; that of
    /// means of a random walk is a quarter.
    const SMOOTH_PART: f64 = 0.4;
    /// Values below which no coefficient is fitted.
    const LEAST: usize = 24;
    /// Largest part of the noise's variance that the mean may take.
    const MEAN_PART_MAX: f64 = 0.6;
    let count = values.len();
    if count < LEAST {
        return 0.0;
    }
    let total = count as f64;
    let centre = mean(values);
    let variance = sum_of_squares(values, centre) / total;
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let on_and_on: f64 = steps.windows(2).map(|pair| pair[0] * pair[1]).sum();
    if variance <= 0.0 || on_and_on > SMOOTH_PART * sum_of_squares(&steps, 0.0) {
        return 0.0;
    }
    let pairs = values.iter().zip(&values[1..]);
    let lagged: f64 = pairs.map(|(a, b)| (a - centre) * (b - centre)).sum();
    let ratio = lagged / total / variance;
    // Low by (1 + 4ρ)/n, since the mean was taken from the same values.
    let deviation = ((1.0 - ratio * ratio).max(0.0) / total).sqrt();
    let r = (ratio + (1.0 + 4.0 * ratio) / total + deviation).clamp(0.0, 1.0 - 0.5 / total);
    let tail = 2.0 * r * (1.0 - libm::pow(r, total)) / (total * (1.0 - r) * (1.0 - r));
    let part = (((1.0 + r) / (1.0 - r) - tail) / total).min(MEAN_PART_MAX);
    (variance * part / (1.0 - part)).sqrt()
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
    let summed_lags = (2 * lags + 1) as f64;
    (summed / (total - summed_lags).max(total / 2.0)).sqrt()
}

pub(super) fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len().max(1) as f64
}

fn sum_of_squares(samples: &[f64], centre: f64) -> f64 {
    samples
        .iter()
        .map(|value| (value - centre) * (value - centre))
        .sum()
}
