//! Recordings that are unlike a raw one: smoothed, limited, rectified, repaired, faded, scaled to a round peak, or of
//! a gain that changes. Nothing in a file need say so.
//!
//! Each statistic asks for something that raw channels do not have, and none proves anything: a pass then waits for a
//! person's word. The ranges of raw channels are those of docs/accuracy.md.
//!
//! - `content`: high frequencies that are missing under a motion that should have them;
//! - `levels`: samples that pile up at a level, lose a sign, or end at a round number;
//! - `pieces`: straight lines, grids of values that differ along the record, ends that fade to nothing;
//! - `spectra`: spectra of short blocks.

mod content;
mod levels;
mod pieces;
mod spectra;

use super::{ConditioningOptions, Signal, bandwidth};
use latchgate_recording::{Channel, Finding, Severity};
use spectra::BlockSpectra;

/// Fewest samples that are looked at.
const FEWEST: usize = 64;

/// A statistic beyond what raw recordings have.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Statistic {
    /// What it is, with its value: `37 samples lie within 2 % of the largest`.
    evidence: String,
    /// The range of raw channels: `raw channels have 1 to 4`.
    raw: &'static str,
    /// What makes it so.
    cause: &'static str,
}

/// What the statistics share.
struct Samples<'a> {
    /// In the file's unit.
    values: &'a [f64],
    hertz: f64,
    /// The printed digit: the least power of ten of which all samples are multiples; 0 if none is.
    digit: f64,
    /// Least difference of two different samples: the recorder's step.
    step: f64,
    /// Median, and the distance of the largest value from the least.
    rest: f64,
    span: f64,
    /// Largest magnitude.
    largest: f64,
    spectra: BlockSpectra,
}

impl<'a> Samples<'a> {
    fn new(values: &'a [f64], hertz: f64) -> Self {
        let digit = printed_digit(values);
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let rest = sorted[sorted.len() / 2];
        let largest = values
            .iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        let least = match digit > 0.0 {
            true => 0.5 * digit,
            false => 1e-9 * largest,
        };
        let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
        let step = steps
            .filter(|step| *step > least)
            .fold(f64::INFINITY, f64::min);
        Self {
            values,
            hertz,
            digit,
            step: if step.is_finite() { step } else { 0.0 },
            rest,
            span: sorted[sorted.len() - 1] - sorted[0],
            largest,
            spectra: BlockSpectra::of(values, hertz),
        }
    }
}

/// Returns the least power of ten, down to 10⁻⁹, of which all samples are multiples; 0 if none is.
fn printed_digit(values: &[f64]) -> f64 {
    let digits = (0..10).map(|places| libm::pow(10.0, f64::from(places)));
    let is_multiple = |value: &f64, factor: f64| {
        let scaled = value * factor;
        (scaled - scaled.round()).abs() <= 1e-6 + 1e-15 * scaled.abs()
    };
    let mut fitting =
        digits.filter(|factor| values.iter().all(|value| is_multiple(value, *factor)));
    fitting.next().map_or(0.0, |factor| 1.0 / factor)
}

/// Says of a channel that no raw recording looks like it, by the first statistic and the number of others. `said` is
/// what was found in it before.
pub(super) fn finding(
    raw: &Signal,
    channel: &Channel,
    said: &[Finding],
    options: &ConditioningOptions,
) -> Option<Finding> {
    // Samples between those of the file were made here.
    let is_filled = channel
        .findings
        .iter()
        .any(|finding| finding.severity == Severity::Blocking || finding.code == "time-irregular");
    if options.synthetic || channel.values.len() < FEWEST || is_filled {
        return None;
    }
    let is_aliased = said
        .iter()
        .any(|finding| finding.code == "aliasing-suspected");
    // What the file itself says of its filter is told already.
    let is_told = is_aliased || bandwidth::says_filtered(channel);
    let statistics = statistics(raw, &channel.values, is_told);
    let (first, others) = statistics.split_first()?;
    let also: Vec<&str> = others.iter().map(|other| &*other.evidence).collect();
    let also = match also.is_empty() {
        true => String::new(),
        false => format!(" Also: {}.", also.join("; ")),
    };
    let text = format!("{}; {}: {}.{also}", first.evidence, first.raw, first.cause);
    if options.processed_accepted {
        let text = format!("{text} A person has accepted that");
        return Some(Finding::info("processed-accepted", text));
    }
    let text = format!(
        "{text} Use the channel as it was recorded. If it was, a pass needs the setting `accept` = processed"
    );
    Some(Finding::warning("processed", text).needing_word())
}

/// Returns every statistic that raw recordings do not have.
fn statistics(raw: &Signal, values: &[f64], is_told: bool) -> Vec<Statistic> {
    let samples = Samples::new(values, raw.rate.hertz());
    let content = || {
        let level_db = bandwidth::level_db(raw)?;
        content::poor(&samples, level_db)
    };
    let content = match is_told {
        true => None,
        false => content(),
    };
    [
        levels::piled_up(&samples),
        levels::one_sign(&samples),
        levels::mirrored(&samples),
        pieces::straight(&samples),
        pieces::gain(&samples),
        pieces::faded(&samples),
        levels::round_peak(&samples),
        content,
    ]
    .into_iter()
    .flatten()
    .collect()
}
