//! High frequencies that are missing under a motion that should have them.
//!
//! A clean pulse has few high frequencies by its nature, so a low share of them says nothing by itself. A structure
//! that rings has many extremes at uneven distances; where such a motion has no high frequencies, and its noise has
//! none either, it was smoothed.

use super::spectra::{FLOOR_PART, decibels, mean};
use super::{Samples, Statistic};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

const MID_HZ: RangeInclusive<f64> = 100.0..=300.0;
const HIGH_HZ: RangeInclusive<f64> = 500.0..=1500.0;
/// Frequencies by which the blocks of the event are told from the others [Hz].
const BUSY_HZ: RangeInclusive<f64> = 40.0..=450.0;

/// Least rate at which the high band is the recorder's [Hz].
const LEAST_HZ: f64 = 4000.0;

/// Fewest blocks.
const BLOCKS: usize = 5;

/// High band against low one of the record below which it is poor [dB]: raw channels have -17 and more. The second
/// holds where the event's high band is as much below its middle one.
const POOR_DB: f64 = -22.0;
const NEARLY_POOR_DB: f64 = -19.0;
const EVENT_COLOUR_DB: f64 = -11.0;

/// The event's high band above the floor that shows motion there [dB]; high against middle band of the floor that a
/// smoothed noise has, with such motion, and without it where the floor is that of rounding [dB]: raw channels have
/// -8 to 5.
const LOUD_DB: f64 = 17.0;
const SOFT_FLOOR_DB: f64 = -8.5;
const SMOOTH_FLOOR_DB: f64 = -35.0;

/// Part of the range by which neighbouring extremes differ at least [-], the fewest of a motion that rings, and the
/// least unevenness of their distances: the median change of their logarithms [-].
const EXTREME_PART: f64 = 0.03;
const EXTREMES: usize = 9;
const UNEVEN: f64 = 0.25;

/// High band against low one of a derivative [dB].
const JERK_DB: f64 = 14.0;

/// Least rate at which the zeros of a moving mean are looked for [Hz], their mean depth [dB], their fewest where the
/// first is below a frequency [Hz] and else, the longest mean [s] and the highest frequency of the first zero [Hz].
const LEAST_OF_MEAN_HZ: f64 = 8000.0;
const ZEROS_DB: f64 = 9.0;
const ZEROS_BELOW: (f64, usize) = (600.0, 3);
const ZEROS: usize = 2;
const LONGEST_MEAN_S: f64 = 0.006;
const FIRST_ZERO_HZ: f64 = 2000.0;

/// Says that a motion that rings has no high frequencies. `level_db` is the high band against the low one of the
/// record.
pub(super) fn poor(samples: &Samples<'_>, level_db: f64) -> Option<Statistic> {
    if samples.hertz < LEAST_HZ {
        return None;
    }
    let spectra = &samples.spectra;
    if spectra.blocks.len() < BLOCKS {
        return None;
    }
    let (middle, high) = (spectra.band_power(MID_HZ), spectra.band_power(HIGH_HZ));
    let event = event_blocks(&spectra.band_power(BUSY_HZ));
    let of_event = |powers: &[f64]| mean(powers, &event);
    // The middle one of its blocks, so that no single corner counts.
    let mut loudest: Vec<f64> = event.iter().map(|block| high[*block]).collect();
    loudest.sort_unstable_by(f64::total_cmp);
    let usual_high = *loudest.get(loudest.len().saturating_sub(1) / 2)?;
    let floor = spectra.floor();
    let floor_of = |band| mean(&floor, &spectra.bins(band));
    let (floor_high, floor_middle) = (floor_of(HIGH_HZ), floor_of(MID_HZ));
    let rounding = samples.step * samples.step / 12.0;
    let loud_db = decibels(usual_high, floor_high.max(rounding));
    let colour_db = decibels(of_event(&high), of_event(&middle));
    let floor_db = decibels(floor_high, floor_middle);
    if level_db > JERK_DB && loud_db >= LOUD_DB {
        return Some(Statistic {
            evidence: format!("500 to 1500 Hz lie {level_db:.0} dB above 5 to 60 Hz"),
            raw: "raw channels have -17 to -2 dB",
            cause: "as in a derivative",
        });
    }
    if !rings(samples) {
        return None;
    }
    if let Some(mean_s) = moving_mean(samples) {
        return Some(Statistic {
            evidence: format!(
                "the spectrum vanishes at every multiple of {:.0} Hz",
                1.0 / mean_s
            ),
            raw: "no raw channel's does",
            cause: "as after a moving mean",
        });
    }
    let is_poor = level_db < POOR_DB || (level_db < NEARLY_POOR_DB && colour_db < EVENT_COLOUR_DB);
    let is_smooth = (loud_db >= LOUD_DB && floor_db <= SOFT_FLOOR_DB)
        || (floor_db <= SMOOTH_FLOOR_DB && floor_high <= 2.0 * rounding);
    (is_poor && is_smooth).then(|| Statistic {
        evidence: format!(
            "500 to 1500 Hz lie {:.0} dB below 5 to 60 Hz, and in the quietest blocks {:.0} dB below 100 to 300 Hz",
            -level_db, -floor_db
        ),
        raw: "raw channels lie 17 and 8 dB below at most",
        cause: "motion and noise were smoothed",
    })
}

/// Returns the fewest blocks that hold nine tenths of the motion.
fn event_blocks(busy: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..busy.len()).collect();
    order.sort_by(|one, other| busy[*other].total_cmp(&busy[*one]));
    let all: f64 = busy.iter().sum();
    let mut held = 0.0;
    let is_needed = |block: &usize| {
        let is_needed = held < 0.9 * all;
        held += busy[*block];
        is_needed
    };
    order.into_iter().take_while(is_needed).collect()
}

/// True of a motion of many extremes at uneven distances.
fn rings(samples: &Samples<'_>) -> bool {
    let spectra = &samples.spectra;
    let from = *BUSY_HZ.start();
    let bins = spectra.bins(from..=f64::INFINITY);
    let mut powers: Vec<f64> = spectra
        .blocks
        .iter()
        .map(|block| mean(block, &bins))
        .collect();
    let place = (FLOOR_PART * powers.len() as f64) as usize;
    let quiet = libm::sqrt(*powers.select_nth_unstable_by(place, f64::total_cmp).1);
    let height = (EXTREME_PART * samples.span).max(6.0 * quiet);
    let extremes = extremes(samples.values, height);
    let logs = extremes
        .windows(2)
        .map(|pair| libm::log((pair[1] - pair[0]).max(1) as f64));
    let logs: Vec<f64> = logs.collect();
    let mut changes: Vec<f64> = logs
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .collect();
    changes.sort_unstable_by(f64::total_cmp);
    let uneven = changes.get(changes.len() / 2).copied().unwrap_or(0.0);
    far_extremes(samples, &extremes, height) >= EXTREMES && uneven >= UNEVEN
}

/// Counts extremes that lie farther from rest than a height.
fn far_extremes(samples: &Samples<'_>, extremes: &[usize], height: f64) -> usize {
    let is_far = |place: &&usize| (samples.values[**place] - samples.rest).abs() > height;
    extremes.iter().filter(is_far).count()
}

/// True of a motion of many extremes, whatever their distances.
pub(super) fn is_rich(samples: &Samples<'_>) -> bool {
    let height = EXTREME_PART * samples.span;
    far_extremes(samples, &extremes(samples.values, height), height) >= EXTREMES
}

/// Returns the places of extremes, in turn high and low, that differ by a height at least.
fn extremes(values: &[f64], height: f64) -> Vec<usize> {
    let (mut low, mut high) = (0, 0);
    let mut rises: Option<bool> = None;
    let mut places = Vec::new();
    for (place, value) in values.iter().enumerate() {
        if rises != Some(true) && *value < values[low] {
            low = place;
        }
        if rises != Some(false) && *value > values[high] {
            high = place;
        }
        match rises {
            None if values[high] - values[low] >= height => {
                rises = Some(high > low);
                places.push(low.min(high));
            }
            Some(true) if values[high] - value >= height => {
                places.push(high);
                (rises, low) = (Some(false), place);
            }
            Some(false) if value - values[low] >= height => {
                places.push(low);
                (rises, high) = (Some(true), place);
            }
            _ => {}
        }
    }
    places
}

/// Returns the length of a moving mean [s] whose zeros the spectrum has, the deepest of them.
fn moving_mean(samples: &Samples<'_>) -> Option<f64> {
    if samples.hertz < LEAST_OF_MEAN_HZ {
        return None;
    }
    let (powers, length) = whole_spectrum(samples);
    let mut sums = vec![0.0];
    sums.extend(powers.iter().scan(0.0, |sum, power| {
        *sum += power;
        Some(*sum)
    }));
    let rounding = (samples.digit * samples.digit / 12.0).max(1e-30);
    let shortest = libm::ceil(samples.hertz / FIRST_ZERO_HZ).max(3.0) as usize;
    let longest = ((LONGEST_MEAN_S * samples.hertz) as usize).max(3);
    // Too few lines between two zeros tell nothing.
    let is_fine = |count: &usize| 0.08 * length / *count as f64 >= 4.0;
    let counts = (shortest..=longest).take_while(is_fine);
    let depths = counts.map(|count| {
        let spectrum = ZeroSpacing {
            sums: &sums,
            bins: length / count as f64,
            count,
            hertz: samples.hertz / count as f64,
            rounding,
        };
        (spectrum.mean_depth_db(), count)
    });
    let deepest = depths.max_by(|one, other| one.0.total_cmp(&other.0));
    deepest
        .filter(|(depth_db, _)| *depth_db >= ZEROS_DB)
        .map(|(_, count)| count as f64 / samples.hertz)
}

/// A power spectrum beside the zeros that a mean over so many samples would have.
struct ZeroSpacing<'a> {
    /// Sums of the bins up to each.
    sums: &'a [f64],
    /// From zero to zero, in bins and [Hz].
    bins: f64,
    hertz: f64,
    count: usize,
    /// Power of rounding to the printed digit.
    rounding: f64,
}

impl ZeroSpacing<'_> {
    /// Returns the mean power from one place to another, in distances of zeros.
    fn between(&self, from: f64, to: f64) -> f64 {
        let from = libm::ceil(from * self.bins).max(1.0) as usize;
        let to = ((to * self.bins) as usize + 1).min(self.sums.len() - 1);
        match to > from {
            true => (self.sums[to] - self.sums[from]) / (to - from) as f64,
            false => 0.0,
        }
    }

    /// Returns the mean depth of the zeros [dB]; the least where one is shallow.
    fn mean_depth_db(&self) -> f64 {
        let mut depths = Vec::new();
        for number in 1..=(self.count - 1) / 2 {
            let zero = number as f64;
            let is_beyond = zero + 0.18 > 0.45 * self.count as f64;
            let below = self.between(zero - 0.18, zero - 0.10);
            let beside = below.min(self.between(zero + 0.10, zero + 0.18));
            if is_beyond || beside < 20.0 * self.rounding || depths.len() >= 8 {
                break;
            }
            let at = self.between(zero - 0.04, zero + 0.04).max(self.rounding);
            depths.push(decibels(beside, at));
        }
        let least = depths.iter().copied().fold(f64::INFINITY, f64::min);
        let fewest = match self.hertz < ZEROS_BELOW.0 {
            true => ZEROS_BELOW.1,
            false => ZEROS,
        };
        match depths.len() {
            found if found < fewest => f64::NEG_INFINITY,
            _ if least < 3.0 => least,
            found => depths.iter().sum::<f64>() / found as f64,
        }
    }
}

/// Returns the power spectrum of the record under a Hann window, and the length of its transform.
fn whole_spectrum(samples: &Samples<'_>) -> (Vec<f64>, f64) {
    use rustfft::{FftPlannerScalar, num_complex::Complex};
    // Of a long record the part around the largest sample.
    let count = samples.values.len().min(LONGEST);
    let most = (0..samples.values.len()).max_by(|one, other| {
        let off = |place: &usize| (samples.values[*place] - samples.rest).abs();
        off(one).total_cmp(&off(other))
    });
    let from = most.unwrap_or(0).saturating_sub(count / 2);
    let from = from.min(samples.values.len() - count);
    let part = &samples.values[from..from + count];
    let length = count.next_multiple_of(512);
    let weight = |index: usize| 0.5 - 0.5 * libm::cos(2.0 * PI * index as f64 / count as f64);
    let power: f64 = (0..count).map(|index| weight(index) * weight(index)).sum();
    let weighted = part.iter().enumerate();
    let mut work: Vec<Complex<f64>> = weighted
        .map(|(index, value)| Complex::from((value - samples.rest) * weight(index)))
        .collect();
    work.resize(length, Complex::default());
    FftPlannerScalar::new()
        .plan_fft_forward(length)
        .process(&mut work);
    let bins = work[..=length / 2].iter().map(|bin| bin.norm_sqr() / power);
    (bins.collect(), length as f64)
}

/// Most samples of a spectrum.
const LONGEST: usize = 1 << 20;
