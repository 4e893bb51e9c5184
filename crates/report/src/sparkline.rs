//! A signal in one line of a terminal.

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
    let mut ranges: Vec<Option<(f64, f64)>> = Vec::with_capacity(columns);
    for column in 0..columns {
        let from = column * values.len() / columns;
        let to = ((column + 1) * values.len() / columns).max(from + 1);
        ranges.push(range(&values[from..to.min(values.len())]));
    }
    let mut middles: Vec<f64> = ranges
        .iter()
        .flatten()
        .map(|(low, high)| low / 2.0 + high / 2.0)
        .collect();
    middles.sort_unstable_by(f64::total_cmp);
    let Some(&centre) = middles.get(middles.len() / 2) else {
        return " ".repeat(columns);
    };
    let shown: Vec<Option<f64>> = ranges
        .iter()
        .map(|range| {
            range.map(|(low, high)| {
                if high - centre >= centre - low {
                    high
                } else {
                    low
                }
            })
        })
        .collect();
    let (low, high) = shown
        .iter()
        .flatten()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
            (low.min(value), high.max(value))
        });
    shown
        .into_iter()
        .map(|value| value.map_or(' ', |value| block(value, low, high)))
        .collect()
}

fn range(values: &[f64]) -> Option<(f64, f64)> {
    values
        .iter()
        .filter(|value| value.is_finite())
        .fold(None, |range, &value| {
            Some(range.map_or((value, value), |(low, high): (f64, f64)| {
                (low.min(value), high.max(value))
            }))
        })
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
