//! What drives the peak, and how it is spread.

use super::{Driver, Parameter, PeakQuantiles};
use crate::Answer;

/// Returns quantiles of the peaks that could be followed; `None` if there is none.
///
/// Between two members the quantile is interpolated linearly: that of share p stands at
/// position p (n − 1) of the sorted peaks, counted from 0.
pub(super) fn quantiles(peaks: &[f64]) -> Option<PeakQuantiles> {
    let mut sorted: Vec<f64> = peaks.iter().copied().filter(|p| p.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let max = *sorted.last()?;
    Some(PeakQuantiles {
        p05: quantile(&sorted, 0.05),
        p50: quantile(&sorted, 0.50),
        p95: quantile(&sorted, 0.95),
        max,
    })
}

/// Returns the quantile of share `share` of sorted values, of which there is at least one.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = share * last as f64;
    let below = (place.floor() as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (place - place.floor()) * (sorted[above] - sorted[below])
}

/// Returns rank correlations of each parameter's draws with the peak, the strongest first, ties
/// by name; `draws` gives a member's draw of a parameter.
pub(super) fn drivers(
    peaks: &[f64],
    parameters: &[Parameter],
    draw: impl Fn(usize, usize) -> f64,
) -> Vec<Driver> {
    let followed: Vec<usize> = (0..peaks.len()).filter(|i| peaks[*i].is_finite()).collect();
    // Adding 0 makes one zero of both, so that levers that never move share a rank.
    let peak_ranks = ranks(&followed.iter().map(|i| peaks[*i] + 0.0).collect::<Vec<_>>());
    let correlations: Vec<Option<f64>> = (0..parameters.len())
        .map(|parameter| {
            let draws: Vec<f64> = followed.iter().map(|i| draw(*i, parameter)).collect();
            correlation(&ranks(&draws), &peak_ranks)
        })
        .collect();
    let sum: f64 = correlations.iter().flatten().map(|c| c * c).sum();
    let mut drivers: Vec<Driver> = parameters
        .iter()
        .zip(correlations)
        .map(|(parameter, correlation)| Driver {
            parameter: parameter.name.into(),
            standard_deviation: parameter.deviation,
            rank_correlation: correlation,
            share: correlation
                .filter(|_| sum > 0.0)
                .map(|correlation| correlation * correlation / sum),
            answer_if_known: Answer::Undecided,
        })
        .collect();
    let strength = |driver: &Driver| driver.rank_correlation.map_or(-1.0, f64::abs);
    drivers.sort_by(|a, b| {
        strength(b)
            .total_cmp(&strength(a))
            .then_with(|| a.parameter.cmp(&b.parameter))
    });
    drivers
}

/// Returns the rank of each value, equal values sharing their mean rank.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    while first < order.len() {
        let same = order[first..]
            .iter()
            .take_while(|i| values[**i].total_cmp(&values[order[first]]).is_eq())
            .count();
        let mean = first as f64 + 0.5 * (same as f64 - 1.0);
        for index in &order[first..first + same] {
            ranks[*index] = mean;
        }
        first += same;
    }
    ranks
}

/// Returns the correlation of two lists; `None` if one of them does not vary.
fn correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let count = a.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        ab += a * b;
        aa += a * a;
        bb += b * b;
    }
    (aa > 0.0 && bb > 0.0).then(|| (ab / (aa * bb).sqrt()).clamp(-1.0, 1.0))
}
