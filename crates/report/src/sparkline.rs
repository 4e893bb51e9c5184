//! A signal in one line of a terminal.

use latchgate_kernel::range::Range;

/// The eight heights.
const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Returns `values` as at most `width` block characters, from the least value (▁) to the
/// largest (█).
///
/// Each character shows the value of its stretch that lies farthest from the median of the
/// stretches' midpoints, so that a spike of one sample is seen however long the signal is.
/// A stretch without a finite value is a space; a constant signal is a row of ▁.
pub fn render(values: &[f64], width: usize) -> String {
    let columns = width.min(values.len());
    if columns == 0 {
        return String::new();
    }
    let mut ranges: Vec<Option<Range>> = Vec::with_capacity(columns);
    for column in 0..columns {
        let from = column * values.len() / columns;
        let to = ((column + 1) * values.len() / columns).max(from + 1);
        ranges.push(range(&values[from..to.min(values.len())]));
    }
    let mut middles: Vec<f64> = ranges
        .iter()
        .flatten()
        .map(|range| range.low / 2.0 + range.high / 2.0)
        .collect();
    middles.sort_unstable_by(f64::total_cmp);
    let Some(&centre) = middles.get(middles.len() / 2) else {
        return " ".repeat(columns);
    };
    let shown: Vec<Option<f64>> = ranges
        .iter()
        .map(|range| {
            range.map(|Range { low, high }| {
                if high - centre >= centre - low {
                    high
                } else {
                    low
                }
            })
        })
        .collect();
    let extremes = shown.iter().flatten().copied();
    let Range { low, high } = extremes.fold(Range::EMPTY, Range::including);
    shown
        .into_iter()
        .map(|value| value.map_or(' ', |value| block(value, low, high)))
        .collect()
}

fn range(values: &[f64]) -> Option<Range> {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let range = finite.fold(Range::EMPTY, Range::including);
    (range != Range::EMPTY).then_some(range)
}

fn block(value: f64, low: f64, high: f64) -> char {
    // Halves keep the difference of the largest finite numbers finite.
    let span = high / 2.0 - low / 2.0;
    let share = if span > 0.0 {
        (value / 2.0 - low / 2.0) / span
    } else {
        0.0
    };
    BLOCKS[((share * 8.0) as usize).min(7)]
}
