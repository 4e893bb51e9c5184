//! Straight lines, grids of values that differ along the record, and ends that fade to nothing.

use super::{Samples, Statistic};
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Fewest samples between two corners on one line, and the most such lines that chance makes [-].
const STRAIGHT: usize = 4;
const BY_CHANCE: f64 = 1e-3;

/// Share of samples on straight lines from which a channel is smooth to its printed digit [-].
const SMOOTH_PART: f64 = 0.4;

/// Most parts of a record whose grids are compared, and the fewest samples of one.
const PARTS: usize = 16;
const OF_PART: usize = 128;

/// Fewest different values that show a grid, and the fewest of them, with their share, that come twice: a ramp passes
/// each value once.
const GRID_VALUES: usize = 12;
const TWICE: (usize, f64) = (6, 0.25);

/// Fewest gaps of one step of a grid, and their share.
const STEPS: (usize, f64) = (5, 0.2);

/// How far values lie on a grid: on their own, and on one that is not theirs [-]; fewest values that tell.
const ON_OWN: f64 = 0.8;
const ON_OTHER: f64 = 0.3;
const TOLD_BY: usize = 16;

/// Pieces at either end of a record that are compared, a hundredth of it each.
const PIECES: usize = 12;

/// Exponents of a fade, and how far the pieces may lie about it [-].
const FADES: std::ops::RangeInclusive<f64> = 1.25..=3.0;
const OFF_FADE: f64 = 0.4;

/// Says that samples were replaced by straight lines.
pub(super) fn straight(samples: &Samples<'_>) -> Option<Statistic> {
    let values = samples.values;
    let bends: Vec<f64> = values
        .windows(3)
        .map(|three| (three[2] - 2.0 * three[1] + three[0]).abs())
        .collect();
    let tolerance = 2.0 * samples.digit + 1e-9 * samples.largest;
    let is_flat = |place: usize| bends[place] <= tolerance;
    let flat = (0..bends.len()).filter(|place| is_flat(*place)).count();
    if flat == bends.len() || flat as f64 > SMOOTH_PART * bends.len() as f64 {
        return None;
    }
    let mut corners: Vec<f64> = bends
        .iter()
        .copied()
        .filter(|bend| *bend > tolerance)
        .collect();
    let place = corners.len() / 10;
    // A grid shows in the bends even below a trend.
    let grid = samples
        .step
        .max(*corners.select_nth_unstable_by(place, f64::total_cmp).1);
    let (corner, slope) = (8.0 * tolerance + 4.0 * grid, 4.0 * grid + 4.0 * tolerance);
    let is_steep = |place: usize| 0.5 * (values[place + 2] - values[place]).abs() >= slope;
    let steep = (0..bends.len()).filter(|place| is_steep(*place)).count();
    let (mut runs, mut place) = (Vec::new(), 0);
    while place < bends.len() {
        let is_on = |place: &usize| is_flat(*place) && is_steep(*place);
        let length = (place..bends.len()).take_while(is_on).count();
        if length > 0 {
            runs.push(place..place + length);
        }
        place += length + 1;
    }
    let short: usize = runs
        .iter()
        .map(ExactSizeIterator::len)
        .filter(|length| *length < 3)
        .sum();
    let chance = (short + 1) as f64 / (steep + 1) as f64;
    let is_line = |run: &&std::ops::Range<usize>| {
        let between_corners = run.start > 0
            && run.end < bends.len()
            && bends[run.start - 1] >= corner
            && bends[run.end] >= corner;
        let line = &values[run.start..run.end + 2];
        let step = (line[line.len() - 1] - line[0]) / (line.len() - 1) as f64;
        let off = |(index, value): (usize, &f64)| (value - line[0] - step * index as f64).abs();
        between_corners && line.iter().enumerate().map(off).all(|off| off <= tolerance)
    };
    let lengths = runs.iter().filter(is_line).map(ExactSizeIterator::len);
    let longest = lengths.max()?;
    let by_chance = steep as f64 * libm::pow(chance, longest as f64);
    (longest >= STRAIGHT && by_chance < BY_CHANCE).then(|| Statistic {
        evidence: format!("{longest} samples lie on one sloping line, to the printed digit"),
        raw: "raw channels have 2 at most",
        cause: "samples were replaced by lines",
    })
}

/// Says that the values of one part of the record lie on a grid and those of another do not: the gain changed.
pub(super) fn gain(samples: &Samples<'_>) -> Option<Statistic> {
    let count = (samples.values.len() / OF_PART).clamp(2, PARTS);
    let bound = |part: usize| part * samples.values.len() / count;
    let part = |number: usize| levels(&samples.values[bound(number)..bound(number + 1)]);
    let parts: Vec<Levels> = (0..count).map(part).collect();
    let mut least = 1.0_f64;
    for part in &parts {
        let Some(step) = grid(part, samples.digit) else {
            continue;
        };
        if on_grid(&part.values, step) < ON_OWN {
            continue;
        }
        // A step is known well enough for values as far apart as those that gave it.
        let reach = 0.5 * (part.values[part.values.len() - 1] - part.values[0]);
        for other in &parts {
            let middle = other.values[other.values.len() / 2];
            let near = other.values.iter().copied();
            let small: Vec<f64> = near
                .filter(|value| (value - middle).abs() <= reach)
                .collect();
            if small.len() >= TOLD_BY {
                least = least.min(on_grid(&small, step));
            }
        }
    }
    (least < ON_OTHER).then(|| Statistic {
        evidence: "the values of one part of the record lie on a grid, and those of another do not"
            .into(),
        raw: "raw channels keep their recorder's step",
        cause: "the gain was changed",
    })
}

/// Returns the step of a grid on which nearly all values lie, if it is coarser than the printed digit: it climbs from
/// the least gap, and each value makes it finer.
fn grid(of_part: &Levels, digit: f64) -> Option<f64> {
    let levels = &of_part.values;
    let share = |part: f64| part * levels.len() as f64;
    let is_passed_once = of_part.twice < TWICE.0 || (of_part.twice as f64) < share(TWICE.1);
    if levels.len() < GRID_VALUES || is_passed_once {
        return None;
    }
    let gaps = levels.windows(2).map(|pair| pair[1] - pair[0]);
    let gaps: Vec<f64> = gaps.filter(|gap| *gap > 0.5 * digit + 1e-12).collect();
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    if !least.is_finite() || least < 2.5 * digit {
        return None;
    }
    let near = gaps
        .iter()
        .copied()
        .filter(|gap| *gap <= least + 1.01 * digit);
    let (sum, count) = near.fold((0.0, 0_usize), |(sum, count), gap| (sum + gap, count + 1));
    // Too few to show a grid.
    if count < STEPS.0 || (count as f64) < STEPS.1 * gaps.len() as f64 {
        return None;
    }
    let mut step = sum / count as f64;
    let middle = levels[levels.len() / 2];
    let mut distances: Vec<f64> = levels.iter().map(|level| (level - middle).abs()).collect();
    distances.sort_unstable_by(f64::total_cmp);
    let (mut product, mut square, mut off) = (0.0, 0.0, 0);
    for distance in &distances {
        let steps = (distance / step).round();
        if (distance - steps * step).abs() > 0.2 * step + 0.5 * digit {
            off += 1;
            if off > 2 + distances.len() / 10 {
                return None;
            }
            continue;
        }
        product += distance * steps;
        square += steps * steps;
        if square > 0.0 {
            step = product / square;
        }
    }
    Some(step)
}

/// The different values of a part, rising, and how many of them come twice at least.
struct Levels {
    values: Vec<f64>,
    twice: usize,
}

fn levels(part: &[f64]) -> Levels {
    let mut sorted = part.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let mut levels = Levels {
        values: Vec::new(),
        twice: 0,
    };
    for run in sorted.chunk_by(|one, other| one.total_cmp(other).is_eq()) {
        levels.values.push(run[0]);
        levels.twice += usize::from(run.len() > 1);
    }
    levels
}

/// Returns how far values lie on a grid of a step: 1 for all, near 0 for values of no such grid.
fn on_grid(values: &[f64], step: f64) -> f64 {
    let turn = |value: &f64| {
        let angle = TAU * value / step;
        Complex::new(libm::cos(angle), libm::sin(angle))
    };
    let turns = values.iter().map(turn);
    turns.sum::<Complex<f64>>().norm() / values.len().max(1) as f64
}

/// Says that both ends fade to nothing, as under the window of a transform.
pub(super) fn faded(samples: &Samples<'_>) -> Option<Statistic> {
    let length = (samples.values.len() / 100).max(16);
    if samples.values.len() < 2 * PIECES * length {
        return None;
    }
    let first: Vec<f64> = samples.values[..PIECES * length].to_vec();
    let last: Vec<f64> = samples
        .values
        .iter()
        .rev()
        .take(PIECES * length)
        .copied()
        .collect();
    let [begin, end] = [first, last].map(|piece| fade(&piece, length, samples.digit));
    let (begin, end) = (begin?, end?);
    (begin || end).then(|| Statistic {
        evidence: "both ends fade to nothing".into(),
        raw: "raw channels keep their noise",
        cause: "as under the window of a transform",
    })
}

/// Returns whether an end grows as a power of the distance from it; `None` unless its outermost piece is empty.
fn fade(values: &[f64], length: usize, digit: f64) -> Option<bool> {
    let half = &values[..length / 2];
    let zero = half.iter().sum::<f64>() / half.len() as f64;
    let root = |piece: &[f64]| {
        let squares: f64 = piece
            .iter()
            .map(|value| (value - zero) * (value - zero))
            .sum();
        libm::sqrt(squares / piece.len() as f64)
    };
    let roots: Vec<f64> = values.chunks_exact(length).map(root).collect();
    if roots[0] > digit.max(0.02 * roots[9]) {
        return None;
    }
    let seen: Vec<usize> = (0..PIECES)
        .filter(|place| roots[*place] > 2.0 * digit)
        .take(7)
        .collect();
    let is_whole = seen.len() == 7 && seen[0] <= 5 && seen[6] == seen[0] + 6;
    if !is_whole {
        return Some(false);
    }
    let points = seen
        .iter()
        .map(|place| [libm::log(*place as f64 + 0.5), libm::log(roots[*place])]);
    let points: Vec<[f64; 2]> = points.collect();
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / 7.0;
    let centre = [mean(0), mean(1)];
    let spread: f64 = points
        .iter()
        .map(|[x, _]| (x - centre[0]) * (x - centre[0]))
        .sum();
    let product: f64 = points
        .iter()
        .map(|[x, y]| (x - centre[0]) * (y - centre[1]))
        .sum();
    let exponent = product / spread;
    let off = |[x, y]: &[f64; 2]| y - centre[1] - exponent * (x - centre[0]);
    let squares: f64 = points.iter().map(|point| off(point) * off(point)).sum();
    Some(FADES.contains(&exponent) && libm::sqrt(squares / 7.0) <= OFF_FADE)
}
