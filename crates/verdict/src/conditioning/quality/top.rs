//! Sides of a signal that are missing: clipped, rectified, or run over.
//!
//! Clipping needs evidence beside the flat top, which a formula may give as well: a declared
//! range, the limit of a converter, or a channel whose own noise vanishes at the top. What clipping
//! took away cannot be had back, so its finding blocks.

use super::noise::{self, Noise};
use super::{QUIET_QUANTA, SignalFacts, in_g, is_cut, same};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::Finding;

/// Part of the declared full scale at which a channel counts as saturated.
const SATURATED_PART: f64 = 0.98;

/// Part of the declared full scale below which a short flat top is no saturation.
const WELL_INSIDE_PART: f64 = 0.96;

/// Least number of equal samples at the extreme that can be a clipped top.
const CLIPPED_RUN: usize = 3;

/// From this many equal samples on, entered and left steeply, no declared range explains a
/// flat top away: the amplifier may have saturated before the sensor did.
const CLIPPED_BEYOND_DOUBT: usize = 5;

/// Part of the peak below which an extreme is not told from rest.
const EXTREME_PART: f64 = 0.02;

/// Samples at exactly the extreme, in runs between steep flanks, that are no chance: each is less
/// likely than one in four.
const CUT_SAMPLES: usize = 16;

/// Step of a steep flank [quanta].
const STEEP_QUANTA: f64 = 6.0;

/// Least number of samples of a top that flickers.
const FLICKER_RUN: usize = 6;

/// Least number of samples of a top that only noise moves.
const NOISY_RUN: usize = 20;

/// Turns at zero that chance does not make in place of as many crossings: each is one of two.
const TURNS: usize = 30;

/// Part of the whole span that a step takes if the converter wrapped around.
const WRAP_PART: f64 = 0.6;

/// Largest part of such a step that the others may have, once it is undone, if it certainly wrapped.
const CERTAINLY_WRAPPED_PART: f64 = 1.0 / 3.0;

/// The same if it may have wrapped.
const PERHAPS_WRAPPED_PART: f64 = 0.75;

/// Returns what speaks of saturation, the surest first.
pub(super) fn clipping(facts: &SignalFacts<'_>, range_g: Option<f64>) -> Vec<Finding> {
    if let Some(finding) = beyond_range(facts, range_g) {
        return vec![finding];
    }
    let extremes = [facts.levels.last(), facts.levels.first()];
    let sides = extremes.into_iter().flatten().copied();
    let mut findings: Vec<Finding> = sides
        .filter_map(|extreme| {
            flat_top(facts, extreme, range_g).or_else(|| cut_side(facts, extreme))
        })
        .collect();
    if findings.is_empty() {
        findings.extend(converter_limit(facts));
    }
    findings
}

fn beyond_range(facts: &SignalFacts<'_>, range_g: Option<f64>) -> Option<Finding> {
    let range = range_g.filter(|range| range.is_finite() && *range > 0.0)?;
    let limit = range * SATURATED_PART * STANDARD_GRAVITY;
    let first = facts
        .samples
        .iter()
        .position(|value| value.abs() >= limit)?;
    let at_s = facts.raw.time_s(first);
    let text = format!(
        "the channel was saturated: {} at {at_s:.5} s reaches {:.0} % of the declared full scale \
         of {range} g. Motion beyond full scale is lost from there on. Record with a wider range",
        in_g(facts.samples[first]),
        100.0 * SATURATED_PART
    );
    Some(Finding::blocking("clipping", text).at(at_s))
}

/// Tells whether an extreme lies beyond what the channel shows at rest.
fn is_away(facts: &SignalFacts<'_>, extreme: f64) -> bool {
    let away = (extreme - facts.bias).abs();
    extreme.abs() > QUIET_QUANTA * facts.quantum
        && away > EXTREME_PART * facts.own_peak
        && away > 5.0 * facts.pre_deviation
}

/// Equal samples at an extreme that the signal enters or leaves more steeply than any smooth
/// top would.
fn flat_top(facts: &SignalFacts<'_>, extreme: f64, range_g: Option<f64>) -> Option<Finding> {
    if !is_away(facts, extreme) {
        return None;
    }
    // A channel that holds its samples holds the one at its top as well.
    let least = CLIPPED_RUN.max(facts.noise.map_or(1, |noise| noise.hold) + 1);
    let runs = noise::equal_runs(facts.samples, least);
    let (first, length) = runs
        .into_iter()
        .filter(|(first, length)| {
            same(facts.samples[*first], extreme) && is_cut(facts, *first, *length, 1.0)
        })
        .max_by_key(|(_, length)| *length)?;
    // Samples that touched the limit before the run are clipped as well.
    let onset = facts.samples.iter().position(|value| same(*value, extreme));
    let observation = format!(
        "{length} equal samples of {} at the record's extreme from {:.5} s on, entered or left \
         steeply",
        in_g(extreme),
        facts.raw.time_s(first)
    );
    let inside = |range: &f64| extreme.abs() < WELL_INSIDE_PART * range * STANDARD_GRAVITY;
    let finding = match range_g.filter(inside) {
        Some(range) if length < CLIPPED_BEYOND_DOUBT => {
            let doubt = format!("The declared full scale of {range} g is far above that");
            Finding::warning(
                "flat-top",
                format!("{observation}. {doubt}, so this may be chance. Look at the peak"),
            )
        }
        _ => {
            let text = format!(
                "the channel was saturated: {observation}. Motion beyond that is lost. Record with a \
                 wider range. If a formula made the signal, write `synthetic = true` in the card"
            );
            Finding::blocking("clipping", text)
        }
    };
    Some(finding.at(facts.raw.time_s(onset.unwrap_or(first))))
}

/// Samples at exactly the record's extreme, again and again between steep flanks, at whatever
/// height: a side that was cut off.
fn cut_side(facts: &SignalFacts<'_>, extreme: f64) -> Option<Finding> {
    let steep = |index: Option<usize>| {
        let beside = index.and_then(|index| facts.samples.get(index));
        beside.is_some_and(|value| (value - extreme).abs() >= STEEP_QUANTA * facts.quantum)
    };
    let runs = noise::equal_runs(facts.samples, 2);
    let cut: Vec<(usize, usize)> = runs
        .into_iter()
        .filter(|(first, length)| {
            same(facts.samples[*first], extreme)
                && first + length > facts.contact
                && steep(first.checked_sub(1))
                && steep(Some(first + length))
        })
        .collect();
    let count: usize = cut.iter().map(|(_, length)| length).sum();
    let (first, _) = *cut.first()?;
    let at_s = facts.raw.time_s(first);
    let text = format!(
        "the channel was saturated: {count} samples in {} runs lie at exactly {}, the record's \
         extreme, between steep flanks. Motion beyond that is lost. Record with a wider range",
        cut.len(),
        in_g(extreme)
    );
    (count >= CUT_SAMPLES && cut.len() > 1).then(|| Finding::blocking("clipping", text).at(at_s))
}

/// A top that the last bit, or the noise before the event, holds, entered or left steeply: a limit
/// with a flicker on it.
pub(super) fn flickering(facts: &SignalFacts<'_>) -> Option<Finding> {
    facts.noise.filter(Noise::is_lively)?;
    let noise = 6.0 * facts.pre_deviation / facts.quantum;
    let widths = [(1.25, FLICKER_RUN), (noise, NOISY_RUN)];
    let extremes = [facts.levels.last(), facts.levels.first()];
    let sides = extremes.into_iter().flatten().copied();
    sides
        .filter(|extreme| is_away(facts, *extreme))
        .find_map(|extreme| {
            widths.into_iter().find_map(|(quanta, least)| {
            let inside = |value: &f64| (value - extreme).abs() <= quanta * facts.quantum;
            let (mut first, mut longest) = (0, None);
            for run in facts.samples.chunk_by(|a, b| inside(a) == inside(b)) {
                let cut = run.len() >= least
                    && inside(&run[0])
                    && is_cut(facts, first, run.len(), quanta);
                longest = longest.max(cut.then_some((run.len(), first)));
                first += run.len();
            }
            let (length, first) = longest?;
            let at_s = facts.raw.time_s(first);
            let text = format!(
                "{length} samples from {at_s:.5} s on lie within {} of the record's extreme of {}, \
                 entered or left steeply. The channel may have been saturated, with a flicker on \
                 it. Declare its full scale, `range_g` in the card",
                in_g(quanta * facts.quantum),
                in_g(extreme)
            );
            Some(Finding::warning("flat-top", text).at(at_s))
        })
        })
}

/// The record's extreme is the last code of a 12- to 24-bit converter: on a grid of quanta
/// through zero, ±2ⁿ or ±(2ⁿ − 1).
fn converter_limit(facts: &SignalFacts<'_>) -> Option<Finding> {
    let mut sizes: Vec<f64> = facts.levels.iter().map(|level| level.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    // Stamps of few digits blur the least difference; the grid is refined as it is climbed.
    let (mut products, mut squares, mut quantum) = (0.0, 0.0, facts.quantum);
    let mut code = 0.0;
    for size in &sizes {
        code = (size / quantum).round();
        if (size - code * quantum).abs() > 0.25 * quantum {
            return None;
        }
        products += size * code;
        squares += code * code;
        if squares > 0.0 {
            quantum = products / squares;
        }
    }
    let mut ends = (11..=23).map(|bits| f64::from(1_u32 << bits));
    // Two's complement ends at −2ⁿ and 2ⁿ − 1.
    let limit = ends.find(|full| same(code, *full) || same(code, full - 1.0))?;
    let largest = *sizes.last()?;
    let first = facts
        .samples
        .iter()
        .position(|value| value.abs() >= largest)?;
    let at_s = facts.raw.time_s(first);
    let text = format!(
        "the channel was saturated: its largest sample, {} at {at_s:.5} s, is the last code of a \
         converter ({limit} quanta of {:.5} g). Record with a wider range",
        in_g(facts.samples[first]),
        quantum / STANDARD_GRAVITY
    );
    Some(Finding::blocking("clipping", text).at(at_s))
}

/// A record without a change of sign that comes down to zero again and again and turns there: the
/// channel was rectified, or cannot show the other sign. A sensor that is off by more than its
/// noise shows one sign as well, but stays away from zero.
pub(super) fn one_signed(facts: &SignalFacts<'_>) -> Option<Finding> {
    let (low, high) = (*facts.levels.first()?, *facts.levels.last()?);
    let sign = if low >= 0.0 {
        1.0
    } else if high <= 0.0 {
        -1.0
    } else {
        return None;
    };
    // The line through the samples before or after leads beyond zero.
    let turns = facts.samples.windows(3).filter(|three| {
        let [before, middle, after] = [three[0], three[1], three[2]].map(|value| sign * value);
        let step = before.min(after) - middle;
        2.0 * middle < step && step >= STEEP_QUANTA * facts.quantum
    });
    let count = turns.count();
    let near = low.abs().min(high.abs()) < EXTREME_PART * facts.own_peak;
    if !near || count == 0 || facts.noise.is_none() {
        return None;
    }
    let evidence = format!(
        "no sample is {}, and the samples turn at zero {count} times",
        if sign > 0.0 { "negative" } else { "positive" }
    );
    Some(if count >= TURNS {
        let text = format!(
            "the channel was rectified or cannot show the other sign: {evidence}. The direction of the \
             motion is lost. Use the channel as it was measured"
        );
        Finding::blocking("one-signed", text)
    } else {
        let text =
            format!("{evidence}. Check that the channel was not rectified and shows both signs");
        Finding::warning("one-signed", text)
    })
}

/// Steps from one end of the converter to the other, with a smooth signal beyond that end once
/// they are undone: the code ran over. A record that does not come back is only doubted.
pub(super) fn wrap_around(facts: &SignalFacts<'_>) -> Option<Finding> {
    let (low, high) = (*facts.levels.first()?, *facts.levels.last()?);
    let span = high - low + facts.quantum;
    if low >= 0.0 || high <= 0.0 {
        return None;
    }
    let (mut turns, mut wraps, mut first) = (0_i32, 0_usize, None);
    let (mut least_wrap, mut largest_rest, mut largest) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    for (index, pair) in facts.samples.windows(2).enumerate() {
        let step = pair[1] - pair[0];
        let undone = if step.abs() > WRAP_PART * span {
            wraps += 1;
            first = first.or(Some(index + 1));
            least_wrap = least_wrap.min(step.abs());
            turns = turns.saturating_add(if step > 0.0 { -1 } else { 1 });
            step - span.copysign(step)
        } else {
            step
        };
        largest_rest = largest_rest.max(undone.abs());
        largest = largest.max((pair[1] + f64::from(turns) * span).abs());
    }
    let first = first?;
    let smooth = largest_rest <= PERHAPS_WRAPPED_PART * least_wrap;
    let few = wraps <= (facts.samples.len() / 20).max(16);
    let at_the_ends = (high + low).abs() <= 2.0 * largest_rest + 4.0 * facts.quantum;
    let beyond = largest > high.max(-low) + 5.0 * facts.quantum + 5.0 * facts.pre_deviation;
    if !(smooth && few && at_the_ends && beyond) {
        return None;
    }
    let at_s = facts.raw.time_s(first);
    let text = format!(
        "the converter overflowed: the samples step from {} to {} at {at_s:.5} s, from one end of \
         all values to the other. With {wraps} such steps undone the signal is smooth. Values from \
         there on are wrong. Record with a wider range",
        in_g(facts.samples[first - 1]),
        in_g(facts.samples[first])
    );
    let finding = if turns == 0 && largest_rest <= CERTAINLY_WRAPPED_PART * least_wrap {
        Finding::blocking("wrap-around", text)
    } else {
        Finding::warning("wrap-around", text)
    };
    Some(finding.at(at_s))
}
