//! The same recording after each filter: what the nominal runs say then.

use super::Answer;
use super::assess::{Scope, combine, filter_name};
use super::bench::{Bench, Pair, Purpose, follow_all};
use super::decision::Judged;
use crate::conditioning::{self, Cfc, Conditioned, Signal, cfc, resample};
use crate::error::Error;
use crate::recording::Finding;
use crate::replay::Outcome;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What the nominal runs say after one filter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FilterRow {
    /// Filter: `none`, `cfc1000`, `cfc600`, `cfc180`, `cfc60`.
    pub filter: Cow<'static, str>,
    /// What the rule says of the nominal runs, as with no ensemble; `None` if the filter cannot
    /// be applied.
    pub verdict: Option<Answer>,
    /// Largest angle in the judged window, of the stops and polarities that count [rad].
    pub peak_angle_rad: Option<f64>,
    /// The filter that the verdict rests on.
    pub chosen: bool,
    /// Why the filter cannot be applied, where it cannot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// A row with the peak of each stop and polarity [rad].
pub(super) struct Filtered {
    pub(super) row: FilterRow,
    peaks: Vec<f64>,
}

/// Samples of a recording beyond which the filters follow one another, so that memory holds the
/// signals of one at a time.
const SAMPLES_AT_ONCE: usize = 100_000;

/// Judges the recording after each filter; the one that was chosen is not run again. `scopes`
/// says how many samples faults leave after a filter, which carries them backwards.
pub(super) fn table(
    bench: &Bench<'_>,
    conditioned: &Conditioned,
    pairs: &[Pair],
    window: Option<(usize, usize)>,
    scopes: &(dyn Fn(Option<Cfc>) -> Scope + Sync),
    judged: &[Judged],
    before: &[Judged],
) -> Result<Vec<Filtered>, Error> {
    let filters: Vec<Option<Cfc>> = std::iter::once(None).chain(Cfc::ALL.map(Some)).collect();
    let runs = if bench.signal.samples.len() > SAMPLES_AT_ONCE {
        0
    } else {
        8 * pairs.len()
    };
    bench.share(runs, &filters, |filter| {
        let scope = scopes(*filter);
        if *filter == conditioned.filter {
            let answers = bench.nominal_answers(pairs, window, judged)?;
            return Ok(row(
                bench, *filter, true, pairs, scope, judged, &answers, before,
            ));
        }
        let signal = match filtered(conditioned, *filter) {
            Ok(signal) => signal,
            Err(error) => {
                return Ok(Filtered {
                    row: FilterRow {
                        filter: filter_name(*filter).into(),
                        verdict: None,
                        peak_angle_rad: None,
                        chosen: false,
                        reason: Some(error.to_string()),
                    },
                    peaks: Vec::new(),
                });
            }
        };
        let fine = resample::upsample_fourfold(&signal);
        let other = Bench {
            signal: &signal,
            fine: &fine,
            ..*bench
        };
        let spare = |outcomes: &[Outcome]| other.spare_nominal(pairs, window, scope, outcomes);
        let all = other.judge_all(pairs, window, Purpose::Deciding, &spare)?;
        let good = match scope {
            Scope::Until(good) => {
                other.judge_all(pairs, Some(good), Purpose::Deciding, &follow_all)?
            }
            Scope::Whole | Scope::Nothing => Vec::new(),
        };
        let answers = other.nominal_answers(pairs, window, &all)?;
        Ok(row(
            bench, *filter, false, pairs, scope, &all, &answers, &good,
        ))
    })
}

#[expect(
    clippy::too_many_arguments,
    reason = "one call for the filter that was chosen, one for the others"
)]
fn row(
    bench: &Bench<'_>,
    filter: Option<Cfc>,
    chosen: bool,
    pairs: &[Pair],
    scope: Scope,
    judged: &[Judged],
    answers: &[Answer],
    before: &[Judged],
) -> Filtered {
    let threshold = bench.design.criterion.threshold_rad;
    let polarity = bench.policy.polarity;
    let of_good: Vec<Answer> = before
        .iter()
        .map(|run| run.nominal_answer(threshold))
        .collect();
    let peaks: Vec<f64> = judged.iter().map(|run| run.run().peak_angle_rad).collect();
    Filtered {
        row: FilterRow {
            filter: filter_name(filter).into(),
            verdict: Some(scope.answer(
                combine(polarity, pairs, answers),
                combine(polarity, pairs, &of_good),
            )),
            peak_angle_rad: peaks.iter().copied().reduce(f64::max),
            chosen,
            reason: None,
        },
        peaks,
    }
}

/// Returns the recording as it would be used with another filter: bias removed and resampled
/// alike.
pub(super) fn filtered(conditioned: &Conditioned, filter: Option<Cfc>) -> Result<Signal, Error> {
    let signal = conditioning::without_filter(conditioned)?;
    match filter {
        None => Ok(signal),
        Some(class) => cfc::CfcFilter::new(class, conditioned.filter_standard).apply(&signal),
    }
}

/// Returns the peak that stop and polarity `pair` reaches without a filter [rad].
pub(super) fn unfiltered_peak(table: &[Filtered], pair: usize) -> Option<f64> {
    table
        .iter()
        .find(|filtered| filtered.row.filter == filter_name(None))
        .and_then(|filtered| filtered.peaks.get(pair).copied())
}

/// Returns a finding if the nominal runs answer differently after different filters.
pub(super) fn filter_decides(rows: &[FilterRow]) -> Option<Finding> {
    let mut answers: Vec<(Answer, Vec<&str>)> = Vec::new();
    for row in rows {
        let Some(answer) = row.verdict else {
            continue;
        };
        match answers.iter_mut().find(|(known, _)| *known == answer) {
            Some((_, filters)) => filters.push(&row.filter),
            None => answers.push((answer, vec![&row.filter])),
        }
    }
    if answers.len() < 2 {
        return None;
    }
    let list: Vec<String> = answers
        .iter()
        .map(|(answer, filters)| format!("{} with {}", answer.name(), filters.join(", ")))
        .collect();
    Some(Finding::warning(
        "filter-decides",
        format!(
            "The filter decides what the nominal runs say: {}. A heavier filter takes away what opens the lever, so its pass is the weaker evidence.",
            list.join("; ")
        ),
    ))
}
