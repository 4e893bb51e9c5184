//! A slow channel on a fast raster: an export puts every channel on one clock, and lays what is missing
//! between two samples of a slow one on the straight line through them.
//!
//! Such a channel bends at the samples of its own clock and nowhere else, to the printed digits. A smooth
//! signal bends everywhere a little, noise bends everywhere. Where few digits hide the bends, they show
//! from one second, fourth … sample to the next, over which they are larger.

use super::noise;
use latchgate_kernel::units::SampleRate;

/// Part of the motion on straight lines between bends from which a channel is taken for interpolated:
/// real channels of crash tests at 10 and 12.5 kHz have at most 0.03, interpolated ones 0.15 and more.
const LEAST_PART: f64 = 0.1;

/// Samples that are passed over from one that is looked at to the next.
const STRIDES: [usize; 5] = [1, 2, 4, 8, 16];

/// Bend that rounding can make [quanta]: half of one at either side, and twice that in the middle.
const ROUNDED_QUANTA: f64 = 2.0;

/// Rounding of numbers that were kept with 24 bits, in a bend [-].
const ROUNDED_PART: f64 = 4e-7;

/// Part of a step from sample to sample that counts as none: stamps may be off the raster by half that.
const STEP_PART: f64 = 0.04;

/// Times a bend that counts as none from which one is plain.
const PLAIN_BEND: f64 = 4.0;

/// Samples that a bend spreads over at most where it lies between two samples of the raster.
const BEND_SAMPLES: usize = 3;

/// Part of the range of the samples that a line goes at least.
const LEAST_RISE: f64 = 0.01;

/// Fewest lines that tell a clock.
const LEAST_LINES: usize = 2;

/// The clock of a channel that was interpolated by straight lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowClock {
    /// Its rate [Hz].
    pub rate_hz: f64,
    /// Samples of the raster from one of its samples to the next.
    pub spacing: f64,
    /// Part of the motion that lies on the lines [-].
    pub part: f64,
}

impl SlowClock {
    /// Tells whether the rate is at or below `hertz`, as far as half a sample of the raster tells.
    pub(super) fn is_at_most(&self, hertz: f64) -> bool {
        self.rate_hz * self.spacing / (self.spacing + 0.5) < hertz
    }
}

/// Finds the clock of a channel that was interpolated, if it was; `levels` are its different values, rising.
pub(super) fn slow_clock(samples: &[f64], levels: &[f64], rate: SampleRate) -> Option<SlowClock> {
    let quantum = noise::quantum(levels);
    let range = levels.last()? - levels.first()?;
    STRIDES.into_iter().find_map(|stride| {
        let thinned: Vec<f64> = samples.iter().step_by(stride).copied().collect();
        let mut lines = straight_lines(&thinned, quantum, STEP_PART / stride as f64);
        lines.retain(|line| line.motion >= LEAST_RISE * range);
        let motion: f64 = thinned
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .sum();
        let part = lines.iter().map(|line| line.motion).sum::<f64>() / motion;
        if lines.len() < LEAST_LINES || part < LEAST_PART {
            return None;
        }
        let spacing = typical_length(lines) * stride as f64;
        Some(SlowClock {
            rate_hz: rate.hertz() / spacing,
            spacing,
            part,
        })
    })
}

/// A straight line from one bend to the next.
struct Line {
    /// Samples from bend to bend.
    length: f64,
    /// How far the signal goes on it.
    motion: f64,
}

/// A place where the signal bends, by indices of the middles of three samples.
struct Bend {
    place: f64,
    first: usize,
    last: usize,
    plain: bool,
}

/// Finds the straight lines, rising or falling, that end in plain bends at both sides; a bend up to
/// `step_part` of a step is none.
fn straight_lines(samples: &[f64], quantum: f64, step_part: f64) -> Vec<Line> {
    let bends: Vec<f64> = samples
        .windows(3)
        .map(|three| (three[0] - 2.0 * three[1] + three[2]).abs())
        .collect();
    let rounded = ROUNDED_QUANTA * quantum * 1.001;
    let step = |index: usize| 0.5 * (samples[index + 2] - samples[index]).abs();
    let none = |index: usize| {
        let sizes = samples[index..index + 3].iter().map(|value| value.abs());
        rounded + ROUNDED_PART * sizes.fold(0.0, f64::max) + step_part * step(index)
    };
    let joined_bends = bends_in(&bends, none);
    let pairs = joined_bends
        .windows(2)
        .filter(|pair| pair[0].plain && pair[1].plain);
    pairs
        .filter_map(|pair| {
            let inner = pair[0].last + 1..pair[1].first;
            let run = samples.get(inner.start..inner.end + 2)?;
            let (from, to) = (*run.first()?, *run.last()?);
            let step = (to - from) / (run.len() - 1) as f64;
            let largest = from.abs().max(to.abs());
            let off_most = rounded + ROUNDED_PART * largest + step_part * step.abs();
            let is_straight = run.iter().enumerate().all(|(index, value)| {
                let on_line = from + step * index as f64;
                (value - on_line).abs() <= off_most
            });
            (!inner.is_empty() && is_straight && step.abs() > 2.0 * rounded).then(|| Line {
                length: pair[1].place - pair[0].place,
                motion: step.abs() * inner.len() as f64,
            })
        })
        .collect()
}

/// Joins neighbouring bends above what counts as none.
fn bends_in(bends: &[f64], none: impl Fn(usize) -> f64) -> Vec<Bend> {
    let mut joined_bends = Vec::new();
    let mut index = 0;
    while index < bends.len() {
        let first = index;
        while index < bends.len() && bends[index] > none(index) {
            index += 1;
        }
        let run = &bends[first..index];
        index += 1;
        if run.is_empty() {
            continue;
        }
        let place = run
            .iter()
            .zip(first..)
            .map(|(bend, position)| bend * position as f64);
        let mut plain = run.iter().zip(first..);
        let plain = plain.any(|(bend, position)| *bend >= PLAIN_BEND * none(position));
        joined_bends.push(Bend {
            place: place.sum::<f64>() / run.iter().sum::<f64>(),
            first,
            last: first + run.len() - 1,
            plain: plain && run.len() <= BEND_SAMPLES,
        });
    }
    joined_bends
}

/// Returns the mean length of the lines that are as long as the one in the middle, by samples. A bend may
/// be too small to be seen, so that two lines are one; few are.
fn typical_length(mut lines: Vec<Line>) -> f64 {
    lines.sort_unstable_by(|one, two| one.length.total_cmp(&two.length));
    let half = 0.5 * lines.iter().map(|line| line.length).sum::<f64>();
    let mut sum = 0.0;
    let middle = lines.iter().find(|line| {
        sum += line.length;
        sum >= half
    });
    let middle = middle.map_or(1.0, |line| line.length);
    let alike = lines.iter().map(|line| line.length);
    let alike: Vec<f64> = alike
        .filter(|length| (length - middle).abs() <= 1.01)
        .collect();
    alike.iter().sum::<f64>() / alike.len() as f64
}
