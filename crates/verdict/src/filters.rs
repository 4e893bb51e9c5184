//! The same recording after each filter: what the nominal runs say then.

use super::Answer;
use super::decision::{VariantRun, combine};
use super::faults::Faults;
use super::policy::{Polarity, Variant};
use super::readings::{ReadingCache, Readings};
use super::runs::{RunDetail, RunSetup};
use super::usable_span::UsableSpan;
use super::variant::VariantResult;
use super::wording::filter_name;
use crate::conditioning::{self, Cfc, Conditioned};
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};

/// The answer and peak of the nominal runs after one filter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FilterRow {
    /// Filter: `none`, `cfc1000`, `cfc600`, `cfc180`, `cfc60`.
    #[serde(with = "conditioning::applied_filter")]
    pub filter: Option<Cfc>,
    /// The answer of the nominal runs by the rule without an ensemble; `None` if the filter cannot
    /// be applied.
    pub verdict: Option<Answer>,
    /// Largest angle in the judged window, of the stops and polarities that count [rad].
    pub peak_angle_rad: Option<f64>,
    /// The same for each opening direction, where both are judged.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_direction: Vec<FilteredDirection>,
    /// The filter that the verdict rests on.
    pub chosen: bool,
    /// Why the filter cannot be applied, where it cannot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// The answer and peak of the nominal runs after one filter, in one opening direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FilteredDirection {
    /// The sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// The answer of the nominal runs by the rule without an ensemble.
    pub answer: Answer,
    /// Largest angle in the judged window, of the stops [rad].
    pub peak_angle_rad: Option<f64>,
}

/// A row with the peak of each variant [rad].
pub(super) struct FilteredRow {
    pub(super) row: FilterRow,
    peaks: Vec<(Variant, f64)>,
}

/// Judges the recording after each filter; the one that was chosen is not run again.
pub(super) fn table(
    setup: &RunSetup<'_>,
    conditioned: &Conditioned,
    findings: &[Finding],
    results: &[VariantResult],
) -> Result<Vec<FilteredRow>, Error> {
    let filters: Vec<Option<Cfc>> = std::iter::once(None).chain(Cfc::ALL.map(Some)).collect();
    let spent: u64 = results.iter().map(|result| result.run.outcome.spent).sum();
    if !setup.work.allows(15 * spent) {
        return Ok(Vec::new());
    }
    let of_filter = |filter: Option<Cfc>| {
        // A filter carries a fault backwards, each by its own reach.
        let faults = Faults::of(conditioned, filter, findings, setup.policy.window_s);
        let span = UsableSpan::of(&faults, setup.signal, setup.window);
        if filter == conditioned.filter {
            let of_each = |result: &VariantResult| {
                let answer = result.run.nominal_answer(setup.threshold_rad());
                (result.variant, answer, result.run.run().peak_angle_rad)
            };
            let of_all: Vec<_> = results.iter().map(of_each).collect();
            let good = results
                .iter()
                .filter_map(|result| result.before_fault.as_ref());
            let mut filtered = judged(setup, filter, span, &of_all, good);
            filtered.row.chosen = true;
            return Ok(filtered);
        }
        match conditioning::refiltered(conditioned, filter) {
            Ok(refiltered) => after(setup, span, &refiltered, results),
            Err(error) => Ok(FilteredRow {
                row: FilterRow {
                    filter,
                    verdict: None,
                    peak_angle_rad: None,
                    by_direction: Vec::new(),
                    chosen: false,
                    reason: Some(error.to_string()),
                },
                peaks: Vec::new(),
            }),
        }
    };
    // One after the other: memory holds the signals of one at a time, and what each may take is
    // known before it.
    filters.into_iter().map(of_filter).collect()
}

/// Judges the recording after another filter.
fn after(
    setup: &RunSetup<'_>,
    span: UsableSpan,
    refiltered: &Conditioned,
    results: &[VariantResult],
) -> Result<FilteredRow, Error> {
    let variants: Vec<Variant> = results.iter().map(|result| result.variant).collect();
    let cache = ReadingCache::default();
    let setup = RunSetup {
        signal: &refiltered.used,
        drawn_runs: setup.drawn_runs.filter(|_| span == UsableSpan::Whole),
        readings: Readings::of(refiltered, &cache, setup.policy.between),
        ..*setup
    };
    let runs = setup.answering_runs(&variants)?;
    let threshold = setup.threshold_rad();
    let of_each = |run: &VariantRun| {
        let peak = run.run().peak_angle_rad;
        (run.variant(), run.nominal_answer(threshold), peak)
    };
    let of_all: Vec<(Variant, Answer, f64)> = runs.iter().map(of_each).collect();
    let good = match span {
        UsableSpan::Until(good) => RunSetup {
            window: Some(good),
            ..setup
        }
        .full_runs(&variants, RunDetail::Errors)?,
        UsableSpan::Whole | UsableSpan::Nothing => Vec::new(),
    };
    Ok(judged(
        &setup,
        refiltered.filter,
        span,
        &of_all,
        good.iter(),
    ))
}

/// Joins what the nominal runs say after one filter, each with its peak [rad], and those before a
/// fault.
fn judged<'a>(
    setup: &RunSetup<'_>,
    filter: Option<Cfc>,
    span: UsableSpan,
    of_all: &[(Variant, Answer, f64)],
    good: impl Iterator<Item = &'a VariantRun>,
) -> FilteredRow {
    let polarity = setup.policy.polarity;
    let of_good: Vec<_> = good
        .map(|run| {
            let answer = run.nominal_answer(setup.threshold_rad());
            (run.variant().opens_when, answer)
        })
        .collect();
    let signed: Vec<_> = of_all
        .iter()
        .map(|(variant, answer, _)| (variant.opens_when, *answer))
        .collect();
    let peaks: Vec<(Variant, f64)> = of_all
        .iter()
        .map(|(variant, _, peak)| (*variant, *peak))
        .collect();
    let direction = |opens_when: &OpensWhen| {
        let polarity = Polarity::Declared(*opens_when);
        let joined = |answers: &[(OpensWhen, Answer)]| {
            let answers = answers.iter().filter(|(sign, _)| sign == opens_when);
            combine(polarity, &answers.copied().collect::<Vec<_>>())
        };
        let peaks = peaks.iter();
        let peaks = peaks.filter(|(variant, _)| variant.opens_when == *opens_when);
        FilteredDirection {
            opens_when: *opens_when,
            answer: span.answer(joined(&signed), joined(&of_good)),
            peak_angle_rad: peaks.map(|(_, peak)| *peak).reduce(f64::max),
        }
    };
    let signs = polarity.signs();
    let several = if signs.len() > 1 { signs } else { &[] };
    FilteredRow {
        row: FilterRow {
            filter,
            verdict: Some(span.answer(combine(polarity, &signed), combine(polarity, &of_good))),
            peak_angle_rad: peaks.iter().map(|(_, peak)| *peak).reduce(f64::max),
            by_direction: several.iter().map(direction).collect(),
            chosen: false,
            reason: None,
        },
        peaks,
    }
}

/// Returns the peak that a variant reaches without a filter [rad].
pub(super) fn unfiltered_peak(table: &[FilteredRow], variant: Variant) -> Option<f64> {
    let unfiltered = table
        .iter()
        .find(|filtered| filtered.row.filter.is_none())?;
    let unfiltered_row = unfiltered.peaks.iter().find(|(of, _)| *of == variant)?;
    Some(unfiltered_row.1)
}

/// Returns a finding if the filter decides what the nominal runs say: one passes where another fails, or the
/// largest angles lie on both sides of the limit.
pub(super) fn filter_decides(rows: &[FilterRow], threshold_rad: f64) -> Option<Finding> {
    let names = |is_meant: &dyn Fn(&FilterRow) -> bool| {
        let meant = rows.iter().filter(|row| is_meant(row));
        let names: Vec<&str> = meant.map(|row| filter_name(row.filter)).collect();
        names.join(", ")
    };
    let answering = |answer: Answer| names(&|row| row.verdict == Some(answer));
    let (pass, fail) = (answering(Answer::Pass), answering(Answer::Fail));
    let peak = |row: &FilterRow| row.peak_angle_rad.filter(|_| row.verdict.is_some());
    let above = names(&|row| peak(row).is_some_and(|peak| peak > threshold_rad));
    let below = names(&|row| peak(row).is_some_and(|peak| peak <= threshold_rad));
    let text = if !pass.is_empty() && !fail.is_empty() {
        format!("The filter decides: fail with {fail}; pass with {pass}.")
    } else if !above.is_empty() && !below.is_empty() {
        format!(
            "The filter decides on which side of the limit the nominal lever stays: above with {above}; below with {below}."
        )
    } else {
        return None;
    };
    let advice = "Trust the lighter filter: a heavier one takes away what opens the lever.";
    Some(Finding::warning(
        "filter-decides",
        format!("{text} {advice}"),
    ))
}
