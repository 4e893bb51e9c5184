//! The spectrum of a channel's noise, fitted to its quiet stretch, and draws of it.
//!
//! An autoregression of at most fourteenth order by Burg's method: of a stretch of a few hundred samples it
//! resolves less than a periodogram and is far less ragged. Its variance is that of the stretch, taken one
//! standard error high.
//!
//! - A stretch below 200 samples gets one order for every twenty, and a spectrum that does not fall towards
//!   low frequencies: what four periods in the stretch could not show is held at the upper bound, at 99.5 %, of
//!   the largest value up to there, and at least at what the standard error of the stretch's mean says of
//!   frequency zero.
//! - Rounding to the recorder's step is white, and no noise has less of it than step/√12.
//! - Where no stretch tells, or its samples are all equal, rounding is all there is.
//!
//! # Source
//!
//! J. P. Burg, Maximum entropy spectral analysis, thesis, Stanford University (1975); S. M. Kay and
//! S. L. Marple, Spectrum analysis: a modern perspective, Proceedings of the IEEE 69 (1981), section II-E.

use crate::conditioning::{Noise, Signal, bias};
use crate::ensemble::draw::{inverse_normal, philox};
use std::f64::consts::TAU;

/// Samples of a quiet stretch from which on its spectrum is taken as it is fitted.
pub const QUIET_SAMPLES: usize = 200;

/// Largest order of the autoregression.
pub const ORDER_MAX: usize = 14;

/// Periods that a short stretch must hold to show a frequency.
const PERIODS: f64 = 4.0;

/// Times the power that so many periods show which is not exceeded in 99.5 % of cases: 8/χ², of eight degrees of
/// freedom.
const POWER_TIMES: f64 = 8.0 / 1.3444;

/// A stationary noise: an autoregression, and beside it what the stretch cannot show.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseSpectrum {
    /// Predictors of a sample from those before it, the nearest first: from none, from one, up to the order.
    /// The first samples of a draw take the lower ones, so that it is stationary from its beginning.
    predictors: Vec<Predictor>,
    /// Standard deviation of the white noise beside it [m/s²].
    white_m_s2: f64,
    /// Slow noise of a stretch too short to show it.
    slow: Option<Slow>,
}

#[derive(Debug, Clone, PartialEq)]
struct Predictor {
    coefficients: Vec<f64>,
    /// Standard deviation of what it leaves over [m/s²].
    innovation_m_s2: f64,
}

/// An autoregression of first order.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Slow {
    correlation: f64,
    innovation_m_s2: f64,
}

impl NoiseSpectrum {
    /// Fits the noise of a recording to its samples before −1 ms.
    pub fn of(raw: &Signal, noise: &Noise) -> Self {
        let count = bias::noise_samples(raw).unwrap_or(0);
        Self::fitted(&raw.samples[..count], noise.deviation_m_s2, noise.step_m_s2)
    }

    /// Fits a noise of this standard deviation to a quiet stretch, recorded in steps of `step` [m/s²].
    pub fn fitted(quiet: &[f64], deviation_m_s2: f64, step_m_s2: f64) -> Self {
        let rounding = step_m_s2 / 12.0_f64.sqrt();
        let order = match quiet.len() {
            count if count >= QUIET_SAMPLES => ORDER_MAX,
            count => count / bias::SAMPLES_PER_ORDER,
        };
        let reflections = if deviation_m_s2 > rounding {
            burg(quiet, order)
        } else {
            // The stretch shows nothing but its grid.
            Vec::new()
        };
        let mut spectrum = Self::of_reflections(&reflections, deviation_m_s2);
        let quiet_error = bias::standard_error_of_mean(quiet);
        if deviation_m_s2 > rounding && quiet_error > 0.0 {
            let high = deviation_m_s2 * (1.0 + spectrum.variance_error(quiet.len())).sqrt();
            spectrum = Self::of_reflections(&reflections, high);
            if quiet.len() < QUIET_SAMPLES {
                // The mean of n samples has the variance S(0)/n.
                let power_of_mean = quiet.len() as f64 * quiet_error * quiet_error;
                let cycles = PERIODS / quiet.len() as f64;
                spectrum.slow = spectrum.held_flat_below(cycles, power_of_mean);
            }
        }
        let missing = rounding * rounding - spectrum.least_power();
        spectrum.white_m_s2 = missing.max(0.0).sqrt();
        spectrum
    }

    /// Returns the autoregression of these reflection coefficients and standard deviation.
    ///
    /// # Source
    ///
    /// Levinson's recursion: Kay and Marple, equations (2.53) and (2.54).
    fn of_reflections(reflections: &[f64], deviation_m_s2: f64) -> Self {
        let mut predictors = vec![Predictor {
            coefficients: Vec::new(),
            innovation_m_s2: deviation_m_s2,
        }];
        for reflection in reflections {
            let before = &predictors[predictors.len() - 1];
            let mirrored = before.coefficients.iter().rev();
            let pairs = before.coefficients.iter().zip(mirrored);
            let mut coefficients: Vec<f64> = pairs.map(|(a, b)| a - reflection * b).collect();
            coefficients.push(*reflection);
            let left = (1.0 - reflection * reflection).max(0.0).sqrt();
            let innovation_m_s2 = before.innovation_m_s2 * left;
            predictors.push(Predictor {
                coefficients,
                innovation_m_s2,
            });
        }
        Self {
            predictors,
            white_m_s2: 0.0,
            slow: None,
        }
    }

    fn last(&self) -> &Predictor {
        // There is always the predictor from no sample.
        &self.predictors[self.predictors.len() - 1]
    }

    /// Returns the order of the autoregression.
    pub fn order(&self) -> usize {
        self.predictors.len() - 1
    }

    /// True if there is no noise at all.
    pub fn is_silent(&self) -> bool {
        self.predictors[0].innovation_m_s2 <= 0.0 && self.white_m_s2 <= 0.0
    }

    /// Returns the power at a frequency [m²/s⁴ per cycle a sample, two-sided: that of a white noise is its
    /// variance]; the frequency is in cycles a sample.
    pub fn power(&self, cycles: f64) -> f64 {
        let of = |coefficients: &[f64], innovation: f64| {
            let (mut real, mut imaginary, mut lag) = (1.0, 0.0, 1.0);
            for coefficient in coefficients {
                let (sine, cosine) = libm::sincos(TAU * cycles * lag);
                real -= coefficient * cosine;
                imaginary += coefficient * sine;
                lag += 1.0;
            }
            innovation * innovation / (real * real + imaginary * imaginary)
        };
        let Predictor {
            coefficients,
            innovation_m_s2,
        } = self.last();
        let slow = self
            .slow
            .map_or(0.0, |slow| of(&[slow.correlation], slow.innovation_m_s2));
        of(coefficients, *innovation_m_s2) + self.white_m_s2 * self.white_m_s2 + slow
    }

    fn least_power(&self) -> f64 {
        const PARTS: u32 = 256;
        let powers = (0..=PARTS).map(|part| self.power(0.5 * f64::from(part) / f64::from(PARTS)));
        powers.fold(f64::INFINITY, f64::min)
    }

    /// Returns the standard error of the variance of so many samples, by the variance [-].
    ///
    /// # Source
    ///
    /// M. S. Bartlett, On the theoretical specification and sampling properties of autocorrelated time-series,
    /// Journal of the Royal Statistical Society, supplement 8 (1946): of normal samples 2 Σ γ(k)²/n, over all k; by
    /// Parseval Σ γ(k)² is the integral of the squared power.
    fn variance_error(&self, count: usize) -> f64 {
        const PARTS: u32 = 512;
        let (mut sum, mut squares) = (0.0, 0.0);
        for part in 0..PARTS {
            let power = self.power(0.5 * (f64::from(part) + 0.5) / f64::from(PARTS));
            (sum, squares) = (sum + power, squares + power * power);
        }
        let correlated = squares * f64::from(PARTS) / (sum * sum);
        (2.0 * correlated / count as f64).sqrt().min(1.0)
    }

    /// Returns the slow noise that lifts the power at frequency zero to the upper bound of the largest below a
    /// frequency [cycles a sample], and at least to this one.
    fn held_flat_below(&self, cycles: f64, least_power: f64) -> Option<Slow> {
        const PARTS: u32 = 32;
        let cycles = cycles.min(0.5);
        let parts = (0..=PARTS).map(|part| cycles * f64::from(part) / f64::from(PARTS));
        let largest = parts.map(|part| self.power(part)).fold(0.0, f64::max);
        let largest = least_power.max(POWER_TIMES * largest);
        let missing = largest - self.power(0.0);
        let correlation = libm::exp(-TAU * cycles);
        (missing > 0.0).then(|| Slow {
            correlation,
            innovation_m_s2: (1.0 - correlation) * missing.sqrt(),
        })
    }

    /// Draws so many samples of it [m/s²]: a function of seed, sensor and draw alone.
    pub fn drawn(&self, count: usize, seed: u64, sensor: u32, draw: u32) -> Vec<f64> {
        let mut normal = Normals::new(seed, [draw, 2 + 3 * sensor]);
        let mut samples: Vec<f64> = Vec::with_capacity(count);
        for index in 0..count {
            let Predictor {
                coefficients,
                innovation_m_s2,
            } = &self.predictors[index.min(self.order())];
            let before = samples.iter().rev();
            let predicted: f64 = coefficients.iter().zip(before).map(|(c, a)| c * a).sum();
            samples.push(predicted + innovation_m_s2 * normal.next());
        }
        if self.white_m_s2 > 0.0 {
            let mut normal = Normals::new(seed, [draw, 3 + 3 * sensor]);
            for a in &mut samples {
                *a += self.white_m_s2 * normal.next();
            }
        }
        if let Some(slow) = self.slow {
            let mut normal = Normals::new(seed, [draw, 4 + 3 * sensor]);
            let left = (1.0 - slow.correlation * slow.correlation).sqrt();
            let mut level = slow.innovation_m_s2 / left * normal.next();
            for a in &mut samples {
                *a += level;
                level = slow.correlation * level + slow.innovation_m_s2 * normal.next();
            }
        }
        samples
    }
}

/// Returns the reflection coefficients of the autoregression that predicts a stretch best forwards and
/// backwards, its mean removed; none of equal samples. Each is below 1 in magnitude.
fn burg(quiet: &[f64], order: usize) -> Vec<f64> {
    /// Part of the power below which what is left over is rounding.
    const ROUNDING: f64 = 1e-12;
    let mean = quiet.iter().sum::<f64>() / quiet.len().max(1) as f64;
    let mut forward: Vec<f64> = quiet.iter().map(|a| a - mean).collect();
    let mut backward = forward.clone();
    let power = forward.iter().map(|a| a * a).sum::<f64>();
    let mut reflections = Vec::with_capacity(order);
    for lag in 1..=order.min(quiet.len().saturating_sub(1)) {
        let (mut product, mut squares) = (0.0, 0.0);
        for index in lag..quiet.len() {
            let (ahead, behind) = (forward[index], backward[index - 1]);
            product += ahead * behind;
            squares += ahead * ahead + behind * behind;
        }
        if squares <= ROUNDING * power {
            break;
        }
        let reflection = 2.0 * product / squares;
        reflections.push(reflection);
        for index in (lag..quiet.len()).rev() {
            let (ahead, behind) = (forward[index], backward[index - 1]);
            forward[index] = ahead - reflection * behind;
            backward[index] = behind - reflection * ahead;
        }
    }
    reflections
}

/// Standard normal numbers of a counter-based generator.
struct Normals {
    key: [u32; 2],
    stream: [u32; 2],
    block: u32,
    words: [u32; 4],
    used: usize,
}

impl Normals {
    fn new(seed: u64, stream: [u32; 2]) -> Self {
        Self {
            key: [(seed >> 32) as u32, seed as u32],
            stream,
            block: 0,
            words: [0; 4],
            used: 4,
        }
    }

    fn next(&mut self) -> f64 {
        if self.used == self.words.len() {
            let [draw, stream] = self.stream;
            self.words = philox([self.block, draw, stream, 0], self.key);
            (self.block, self.used) = (self.block + 1, 0);
        }
        let word = self.words[self.used];
        self.used += 1;
        inverse_normal((f64::from(word) + 0.5) / 4_294_967_296.0)
    }
}
