//! What a channel does at rest, and how long a run of samples chance makes on it.
//!
//! A sensor at rest shows noise. Given all samples before it, the next one is spread by at least
//! the innovation of that noise: what a linear prediction from the samples before leaves over. So
//! it hits one value of a grid with a probability below grid over innovation, whatever the
//! correlation, and a run of `L` equal samples, or of samples on one straight line, has a
//! probability that falls with every sample. Motion adds to the noise and makes runs rarer.
//!
//! The probability by the normal law is held against the longest run that the stretch itself
//! shows, and dropped where that contradicts it. Where the noise is below one step of the grid the runs of
//! the stretch alone tell, with a wide margin, since the zero may lie elsewhere in the step later on.

use super::same;
use std::f64::consts::TAU;

/// Probability below which a run anywhere in a record is no chance.
const CHANCE: f64 = 1e-9;

/// Probability below which a run in the stretch contradicts its spread.
const UNEXPLAINED: f64 = 1e-3;

/// Least number of samples that tell anything of noise.
pub(super) const LEAST_SAMPLES: usize = 32;

/// Largest order of the linear prediction.
const ORDER: usize = 8;

/// Innovation from which a channel is lively [quanta]. Below it rounding is most of what is seen.
const LIVELY_QUANTA: f64 = 1.0;

/// How many times the run that the stretch's own runs lead to expect is no chance on a coarse channel.
const COARSE_FACTOR: f64 = 3.0;

/// Values below which nobody tells that a channel holds them.
const HELD_VALUES: usize = LEAST_SAMPLES;

/// Half the width of the corridor in which samples count as lying on a line [quanta].
const CORRIDOR_QUANTA: f64 = 1.1;

/// Spacings of levels below this part of their median are digits of the print, not of the grid.
const GRID_PART: f64 = 0.02;

/// How samples hang together in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RunKind {
    /// One value throughout.
    Equal,
    /// On a straight line to a rounding of the grid; a last digit that flickers is one.
    Line,
}

/// Runs of samples as first index and length.
pub(super) type Runs = Vec<(usize, usize)>;

/// A stretch at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    count: usize,
    quantum: f64,
    /// Standard deviation of what a prediction leaves over, by its median; a lower bound.
    innovation: f64,
    longest_equal: usize,
    longest_line: usize,
    /// Samples for which the channel holds each value.
    pub(super) hold: usize,
}

impl Noise {
    /// Learns from a stretch how noise looks while nothing is lost, so that lost or held samples elsewhere can be told
    /// from chance; `None` if it is too short or silent.
    pub(super) fn learn(samples: &[f64], quantum: f64) -> Option<Self> {
        let first = samples.first()?;
        if samples.len() < LEAST_SAMPLES || samples.iter().all(|value| same(*value, *first)) {
            return None;
        }
        let (shift, hold) = held(samples);
        // What a channel that holds its values tells are the values, not the copies.
        let values: Vec<f64> = samples[shift..].iter().step_by(hold).copied().collect();
        let longest = |runs: Runs| runs.iter().map(|(_, length)| *length).max().unwrap_or(1);
        Some(Self {
            count: values.len(),
            quantum,
            innovation: innovation(&values),
            longest_equal: longest(equal_runs(&values, 1)),
            longest_line: longest(line_runs(&values, quantum, 1)),
            hold,
        })
    }

    /// Tells whether single samples are spread over several steps of the grid.
    pub(super) fn is_lively(&self) -> bool {
        self.exceeds(LIVELY_QUANTA)
    }

    /// Tells whether the noise of single samples is at least so many steps of the grid.
    pub(super) fn exceeds(&self, quanta: f64) -> bool {
        self.innovation >= quanta * self.quantum
    }

    /// Returns the number of samples from which on a run is no chance anywhere in a record of
    /// `total` samples; `None` where the stretch does not tell.
    pub(super) fn least_run(&self, kind: RunKind, total: usize) -> Option<f64> {
        let total = total.div_ceil(self.hold);
        // Free samples lie on any level or line; the others have to hit a width.
        let (longest, free, width) = match kind {
            RunKind::Equal => (self.longest_equal, 1.0, self.quantum),
            RunKind::Line => (
                self.longest_line,
                3.0,
                (4.0 * CORRIDOR_QUANTA + 1.0) * self.quantum,
            ),
        };
        let rarity = libm::log(total as f64 / CHANCE);
        let observed_run = rarity / libm::log(self.count as f64) * (longest as f64 + 1.0);
        let chance = width / (TAU.sqrt() * self.innovation);
        let values = if !self.is_lively() {
            (kind == RunKind::Equal).then_some(COARSE_FACTOR * observed_run)?
        } else if chance >= 1.0 || self.contradicts(chance, longest as f64 - free) {
            observed_run
        } else {
            observed_run.min(free - rarity / libm::log(chance))
        };
        Some(values * self.hold as f64)
    }

    /// Tells whether the stretch shows a run that its spread does not explain.
    fn contradicts(&self, chance: f64, hits: f64) -> bool {
        hits > 0.0 && self.count as f64 * libm::pow(chance, hits) < UNEXPLAINED
    }

    /// Tells whether the longest run of equal samples is one that the spread explains.
    pub(super) fn is_explained(&self) -> bool {
        let chance = self.quantum / (TAU.sqrt() * self.innovation);
        !self.is_lively() || !self.contradicts(chance, self.longest_equal as f64 - 1.0)
    }
}

/// Returns the place of the first whole value and the number of samples for which the channel holds each:
/// the greatest that divides the length of every run of equal ones, but for the first and the last,
/// which go on outside; 0 and 1 where too few tell.
fn held(samples: &[f64]) -> (usize, usize) {
    let runs = equal_runs(samples, 1);
    match runs.as_slice() {
        [_, inner @ .., _] if inner.len() >= HELD_VALUES => {
            let common = inner
                .iter()
                .fold(0, |common, (_, length)| gcd(common, *length));
            (inner[0].0 % common, common)
        }
        _ => (0, 1),
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Least spacing of the levels of some samples; 0 if there is one level only.
pub(super) fn quantum(levels: &[f64]) -> f64 {
    let mut spacings: Vec<f64> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
    spacings.sort_unstable_by(f64::total_cmp);
    let Some(median) = spacings.get(spacings.len() / 2) else {
        return 0.0;
    };
    let least = GRID_PART * median;
    let spacing = spacings.iter().find(|spacing| **spacing >= least);
    spacing.copied().unwrap_or(*median)
}

/// Different values, rising.
pub(super) fn levels(samples: &[f64]) -> Vec<f64> {
    let mut levels = samples.to_vec();
    levels.sort_unstable_by(f64::total_cmp);
    levels.dedup_by(|a, b| same(*a, *b));
    levels
}

/// Runs of at least `least` equal samples.
pub(super) fn equal_runs(samples: &[f64], least: usize) -> Runs {
    let mut runs = Vec::new();
    let mut first = 0;
    for run in samples.chunk_by(|a, b| same(*a, *b)) {
        if run.len() >= least {
            runs.push((first, run.len()));
        }
        first += run.len();
    }
    runs
}

/// Runs of at least `least` samples within a corridor about a straight line through their first.
pub(super) fn line_runs(samples: &[f64], quantum: f64, least: usize) -> Runs {
    let half = CORRIDOR_QUANTA * quantum;
    let mut runs = Vec::new();
    let (mut first, mut low, mut high) = (0, f64::NEG_INFINITY, f64::INFINITY);
    for (index, value) in samples.iter().enumerate().skip(1) {
        let steps = (index - first) as f64;
        let rise = value - samples[first];
        low = low.max((rise - half) / steps);
        high = high.min((rise + half) / steps);
        if low > high {
            if index - first >= least {
                runs.push((first, index - first));
            }
            (first, low, high) = (index, f64::NEG_INFINITY, f64::INFINITY);
        }
    }
    if samples.len() - first >= least {
        runs.push((first, samples.len() - first));
    }
    runs
}

/// Standard deviation of what a linear prediction leaves over, by the median of its size, less
/// two of its own standard errors.
///
/// # Source
///
/// J. P. Burg, Maximum entropy spectral analysis, 37th meeting of the Society of Exploration
/// Geophysicists, 1967.
fn innovation(samples: &[f64]) -> f64 {
    let count = samples.len();
    let mean = samples.iter().sum::<f64>() / count as f64;
    let mut forward: Vec<f64> = samples.iter().map(|value| value - mean).collect();
    let mut backward = forward.clone();
    for order in 1..=ORDER.min(count / 8) {
        let (mut products, mut squares) = (0.0, 0.0);
        for index in order..count {
            products += forward[index] * backward[index - 1];
            squares += forward[index] * forward[index] + backward[index - 1] * backward[index - 1];
        }
        if squares <= 0.0 {
            return 0.0;
        }
        let reflection = 2.0 * products / squares;
        for index in (order..count).rev() {
            let (ahead, behind) = (forward[index], backward[index - 1]);
            forward[index] = ahead - reflection * behind;
            backward[index] = behind - reflection * ahead;
        }
    }
    let start = ORDER.min(count / 8);
    let mut residuals: Vec<f64> = forward[start..].iter().map(|value| value.abs()).collect();
    residuals.sort_unstable_by(f64::total_cmp);
    let median = residuals.get(residuals.len() / 2).copied().unwrap_or(0.0);
    median / 0.6745 * (1.0 - 2.0 / (count as f64).sqrt()).max(0.0)
}
