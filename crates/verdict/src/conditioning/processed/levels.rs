//! Samples that pile up at a level, lose a sign, or end at a round number.

use super::content::is_rich;
use super::{Samples, Statistic};
use std::ops::RangeInclusive;

/// Fewest separate visits to a level, and the samples within the outermost band there with how many times as many
/// these are as those of the next band: a plateau is one visit, a peak thins out.
const VISITS: usize = 3;
const PILES: [(usize, f64); 2] = [(16, 3.5), (10, 5.0)];

/// Longest flat top between two steep sides that a limiter makes alone [s].
const CORNER_S: f64 = 0.0025;

/// Share of the sample rate at which a recorder's filter leaves white noise alone [-].
const WHITE: RangeInclusive<f64> = 0.36..=0.48;

/// Fewest returns into the noise without a crossing.
const RETURNS: usize = 30;

/// Fewest jumps from one side's end to beyond it on the other.
const JUMPS: usize = 6;

/// Part of the peak that the recorder's step may be where it is exactly 1, and exactly 10 or 100 [-].
const STEP_PART_OF_ONE: f64 = 0.02;
const STEP_PART: f64 = 0.002;

/// Says that samples pile up at the end of a side with noise on top of them.
pub(super) fn piled_up(samples: &Samples<'_>) -> Option<Statistic> {
    let noise = white_noise(samples);
    // What a channel at rest reaches is no end of a side.
    let (_, at_rest) = quietest(samples)?;
    let of_side = |sign| piled_up_on(samples, sign, noise, noise.max(at_rest));
    [1.0, -1.0].into_iter().find_map(of_side)
}

fn piled_up_on(samples: &Samples<'_>, sign: f64, noise: f64, at_rest: f64) -> Option<Statistic> {
    let step = samples.step;
    let values: Vec<f64> = samples
        .values
        .iter()
        .map(|value| sign * (value - samples.rest))
        .collect();
    let top = values.iter().copied().fold(f64::MIN, f64::max);
    let width = (0.02 * top).max(5.0 * noise) + step;
    if top < 10.0 * at_rest + 4.0 * step || top <= 3.0 * width {
        return None;
    }
    let back = top - 2.0 * width - (0.1 * top).max(6.0 * noise);
    let outer = values.iter().filter(|value| **value >= top - width).count();
    let is_inner = |value: &&f64| (top - 2.0 * width..top - width).contains(*value);
    let inner = values.iter().filter(is_inner).count();
    let (mut visits, mut is_there) = (0, false);
    for value in &values {
        if *value < back {
            is_there = false;
        } else if *value >= top - width && !is_there {
            is_there = true;
            visits += 1;
        }
    }
    let evidence =
        |count: usize| format!("{count} samples lie at the end of the {} side", side(sign));
    let is_pile = |(count, ratio): &(usize, f64)| {
        outer >= *count && outer as f64 >= ratio * (inner as f64 + 1.0)
    };
    if visits >= VISITS && PILES.iter().any(is_pile) {
        return Some(Statistic {
            evidence: format!(
                "{}, in {visits} visits, and {inner} just before it",
                evidence(outer)
            ),
            raw: "raw channels have 3 at most",
            cause: "as behind a limiter",
        });
    }
    let width = (6.0 * noise).max(3.0 * step).max(0.005 * top) + step;
    let longest = (CORNER_S * samples.hertz).max(4.0) as usize;
    let corner = |run: &[f64], before: f64, after: f64| {
        let is_short = (4..=longest).contains(&run.len());
        is_short && before.max(after) <= top - 10.0 * width
    };
    let mut place = 0;
    while place < values.len() {
        let length = values[place..]
            .iter()
            .take_while(|value| **value >= top - width)
            .count();
        let end = place + length;
        if length > 0
            && place > 0
            && end < values.len()
            && corner(&values[place..end], values[place - 1], values[end])
        {
            return Some(Statistic {
                evidence: format!("{}, between two steep sides", evidence(length)),
                raw: "no raw channel has such a top",
                cause: "as behind a limiter",
            });
        }
        place = end + 1;
    }
    None
}

fn side(sign: f64) -> &'static str {
    match sign > 0.0 {
        true => "positive",
        false => "negative",
    }
}

/// Returns the standard deviation of the white noise at the top of the band, by the quietest blocks.
fn white_noise(samples: &Samples<'_>) -> f64 {
    // The 20 % quantile of an exponential distribution of mean 1, which the power of a bin has.
    const QUANTILE: f64 = 0.223_143_551_314_209_76;
    let spectra = &samples.spectra;
    let floor = spectra.floor();
    let band = WHITE.start() * samples.hertz..=WHITE.end() * samples.hertz;
    let mut powers: Vec<f64> = spectra.bins(band).iter().map(|bin| floor[*bin]).collect();
    powers.sort_unstable_by(f64::total_cmp);
    let middle = powers.get(powers.len() / 2).copied().unwrap_or(0.0);
    libm::sqrt(middle / QUANTILE)
}

/// Returns mean and standard deviation of the quietest hundredth of a second.
fn quietest(samples: &Samples<'_>) -> Option<(f64, f64)> {
    let length = ((0.01 * samples.hertz).round() as usize).max(16);
    let pieces = samples.values.chunks_exact(length);
    if pieces.len() < 4 {
        return None;
    }
    pieces
        .map(moments)
        .min_by(|one, other| one.1.total_cmp(&other.1))
}

/// Returns mean and standard deviation of some values.
pub(super) fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values
        .iter()
        .map(|value| (value - mean) * (value - mean))
        .sum();
    (mean, libm::sqrt(squares / count))
}

/// Says that all samples beyond the noise have one sign although the motion comes back to nought again and again.
pub(super) fn one_sign(samples: &Samples<'_>) -> Option<Statistic> {
    let (rest, deviation) = quietest(samples)?;
    let noise = deviation.max(samples.step);
    let beyond = |sign: f64| {
        let is_beyond = |value: &&f64| sign * (**value - rest) > 6.0 * noise;
        samples.values.iter().filter(is_beyond).count()
    };
    let (up, down) = (beyond(1.0), beyond(-1.0));
    if (up == 0) == (down == 0) {
        return None;
    }
    let sign = if up > 0 { 1.0 } else { -1.0 };
    // The largest of this excursion; 0 while there is none.
    let (mut top, mut returns) = (0.0_f64, 0);
    for value in samples.values {
        let value = sign * (value - rest);
        if value > 6.0 * noise {
            top = top.max(value);
        }
        if top > 0.0 && value < (3.0 * noise).max(0.1 * top) {
            top = 0.0;
            returns += 1;
        }
    }
    (returns >= RETURNS).then(|| Statistic {
        evidence: format!(
            "all {} samples beyond the noise are on the {} side, and the motion comes back into it {returns} times",
            up.max(down),
            side(sign)
        ),
        raw: "of raw channels 51 to 96 % are",
        cause: "the other sign was lost",
    })
}

/// Says that one side ends where the samples jump to beyond its end on the other side: a minus lost beyond a level.
pub(super) fn mirrored(samples: &Samples<'_>) -> Option<Statistic> {
    let (_, deviation) = quietest(samples)?;
    let values = samples.values.iter().map(|value| value - samples.rest);
    let (low, high) = values.fold((0.0_f64, 0.0_f64), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let (end, sign) = match -low <= high {
        true => (-low, 1.0),
        false => (high, -1.0),
    };
    if end <= 6.0 * deviation.max(samples.step) {
        return None;
    }
    let near = |value: f64| sign * (value - samples.rest) < -0.6 * end;
    let far = |value: f64| sign * (value - samples.rest) > 0.95 * end;
    let is_jump =
        |pair: &&[f64]| (near(pair[0]) && far(pair[1])) || (far(pair[0]) && near(pair[1]));
    let jumps = samples.values.windows(2).filter(is_jump).count();
    (jumps >= JUMPS).then(|| Statistic {
        evidence: format!(
            "the {} side ends at {}, and from there {jumps} steps lead beyond it on the other side",
            side(-sign),
            latchgate_kernel::units::plain(end, 3)
        ),
        raw: "raw channels have 1 at most",
        cause: "larger samples lost their sign",
    })
}

/// Says that the largest sample is exactly 1, 10 or 100 in the file's unit although the recorder's step is fine.
pub(super) fn round_peak(samples: &Samples<'_>) -> Option<Statistic> {
    let peak = samples.largest;
    let is_it = |round: &f64| (peak - round).abs() <= 1e-9 * round;
    let round = [1.0, 10.0, 100.0].into_iter().find(is_it)?;
    let reach = peak * (1.0 - 1e-9);
    let tops = samples
        .values
        .iter()
        .filter(|value| value.abs() >= reach)
        .count();
    let step = samples.digit.max(samples.step);
    let pieces = samples
        .values
        .chunks_exact((samples.values.len() / 100).max(16));
    let mut deviations: Vec<f64> = pieces.map(|piece| moments(piece).1).collect();
    deviations.sort_unstable_by(f64::total_cmp);
    // Without noise beyond the step, or with few extremes, a formula rounds to its peak.
    let middle = deviations.get(deviations.len() / 2);
    let is_alive = middle.is_some_and(|middle| *middle >= 2.0 * step) && is_rich(samples);
    let limit = match round > 1.0 {
        true => STEP_PART,
        false => STEP_PART_OF_ONE,
    };
    (tops <= 2 && is_alive && step <= limit * peak).then(|| Statistic {
        evidence: format!("the largest sample is exactly {round}"),
        raw: "raw channels end at no round number",
        cause: "as of a curve that was normalised",
    })
}
