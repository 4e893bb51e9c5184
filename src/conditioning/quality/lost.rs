//! Stretches in which sensor, cable, recorder or converter lost the motion.

use super::{
    EVENT_PART, FROZEN_RUN, LOUD_PART, QUIET_QUANTA, SignalFacts, in_g, inside_event, is_cut, mean,
    same,
};
use crate::recording::Finding;

/// Longest stretch of equal samples that a moving body can give [s].
const FROZEN_S: f64 = 5e-3;
/// How many times the longest run of equal samples before the event one inside it has to last until
/// it is not chance.
const CHANCE_RUNS: usize = 4;
/// Noise before the event that does not fit into one quantum for long [quanta].
const LIVELY_QUANTA: f64 = 2.0;
/// Least number of samples that were lost one by one.
const LOST_SAMPLES: usize = 3;
/// Part of the whole span that a step takes if the converter wrapped around.
const WRAP_PART: f64 = 0.6;
/// Largest part of such a step that the others may have, once it is undone.
const UNWRAPPED_PART: f64 = 1.0 / 3.0;

/// Samples before the event from which the lean of noise is told; by chance it is then 0.17.
const LEAN_SAMPLES: usize = 200;
/// Skewness of noise that leans.
const LEAN: f64 = 0.6;

/// Equal samples for longer than a moving body can stand still, away from zero; or at any level,
/// if they begin inside the event and the channel's own noise vanishes with them. A slow
/// signal on a coarse grid may stand still at its top; it comes and goes gently.
pub(super) fn frozen(facts: &SignalFacts<'_>) -> Option<Finding> {
    let least = ((FROZEN_S * facts.raw.rate.hertz()).floor() as usize + 2).max(FROZEN_RUN);
    let noisy = facts.pre_deviation >= 0.5 * facts.quantum && facts.pre_deviation > 0.0;
    // A coarse converter holds its noise still now and then, so that chance counts.
    let longest_before = facts
        .runs(FROZEN_RUN)
        .iter()
        .filter(|(first, _)| *first < facts.pre_event)
        .map(|(first, length)| (*length).min(facts.pre_event - first))
        .max()
        .unwrap_or(0);
    facts.runs(least).into_iter().find_map(|(first, length)| {
        let level = facts.samples[first];
        let away = (level.abs() > QUIET_QUANTA * facts.quantum
            && (level - facts.pre_mean).abs() > 5.0 * facts.pre_deviation)
            && level.abs() > 0.01 * facts.peak
            && is_cut(facts, first, length, 1.0);
        let lost =
            noisy && length > CHANCE_RUNS * longest_before && inside_event(facts, first, least);
        (away || lost).then(|| {
            let at_s = facts.raw.time_s(first);
            let seen = format!(
                "{length} equal samples of {} from {at_s:.5} s to {:.5} s: a body in motion does \
                 not stand still for longer than {} ms",
                in_g(level),
                facts.raw.time_s(first + length - 1),
                1e3 * FROZEN_S
            );
            if facts.is_still() {
                Finding::warning(
                    "frozen",
                    format!(
                        "{seen}. The record stands as still at rest, which no sensor does: if a \
                         formula made it, say `synthetic = true` in a card; if it was measured, \
                         sensor, cable or recorder failed"
                    ),
                )
            } else {
                Finding::blocking(
                    "frozen",
                    format!("{seen}; sensor, cable or recorder failed"),
                )
            }
            .at(at_s)
        })
    })
}

/// A stretch that one quantum holds, begun inside the event, on a channel whose noise takes
/// several: the last bit flickers where sensor or cable failed.
pub(super) fn stilled(facts: &SignalFacts<'_>) -> Option<Finding> {
    if facts.quantum <= 0.0 || facts.pre_deviation < LIVELY_QUANTA * facts.quantum {
        return None;
    }
    let least = ((FROZEN_S * facts.raw.rate.hertz()).floor() as usize + 2).max(FROZEN_RUN);
    let longest_before = facts
        .bands(2)
        .iter()
        .filter(|(first, _)| *first < facts.pre_event)
        .map(|(first, length)| (*length).min(facts.pre_event - first))
        .max()
        .unwrap_or(0);
    let (first, length) = facts.bands(least).into_iter().find(|(first, length)| {
        *length > CHANCE_RUNS * longest_before && inside_event(facts, *first, least)
    })?;
    let at_s = facts.raw.time_s(first);
    Some(
        Finding::blocking(
            "frozen",
            format!(
                "{length} samples from {at_s:.5} s to {:.5} s differ by no more than the last \
                 digit, at {}, on a channel whose noise before the event is {}: sensor, cable or \
                 recorder failed",
                facts.raw.time_s(first + length - 1),
                in_g(facts.samples[first]),
                in_g(facts.pre_deviation)
            ),
        )
        .at(at_s),
    )
}

/// Single samples of zero amid loud ones of one sign, again and again. Ringing dips as well,
/// but not always to zero.
pub(super) fn lost_one_by_one(facts: &SignalFacts<'_>) -> Option<Finding> {
    let loud = LOUD_PART * facts.peak;
    let (mut first, mut lost, mut dips) = (None, 0_usize, 0_usize);
    for (index, three) in facts.samples.windows(3).enumerate() {
        let amid =
            three[0].abs() > loud && three[2].abs() > loud && (three[0] > 0.0) == (three[2] > 0.0);
        if !amid || three[1].abs() > EVENT_PART * facts.peak {
            continue;
        }
        dips += 1;
        if same(three[1], 0.0) {
            lost += 1;
            first = first.or(Some(index + 1));
        }
    }
    let first = first.filter(|_| lost >= LOST_SAMPLES && 10 * lost >= 9 * dips)?;
    let at_s = facts.raw.time_s(first);
    let text = format!(
        "{lost} single samples from {at_s:.5} s on are zero between loud ones of one sign: the \
         values were lost there"
    );
    Some(
        if facts.has_noise() {
            Finding::blocking("drop-out", text)
        } else {
            Finding::warning("drop-out", text)
        }
        .at(at_s),
    )
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
    let smooth = largest_rest <= UNWRAPPED_PART * least_wrap;
    let few = wraps <= (facts.samples.len() / 20).max(16);
    let at_the_ends = (high + low).abs() <= 2.0 * largest_rest + 4.0 * facts.quantum;
    let beyond = largest > facts.peak + 5.0 * facts.quantum + 5.0 * facts.pre_deviation;
    if !(smooth && few && at_the_ends && beyond) {
        return None;
    }
    let at_s = facts.raw.time_s(first);
    let text = format!(
        "the samples step from {} to {} at {at_s:.5} s, from one end of all values to the other, \
         {wraps} such steps in all, and the signal is smooth where they are undone: the converter \
         ran over, and from there on the values are none",
        in_g(facts.samples[first - 1]),
        in_g(facts.samples[first])
    );
    Some(
        if turns == 0 {
            Finding::blocking("wrap-around", text)
        } else {
            Finding::warning("wrap-around", text)
        }
        .at(at_s),
    )
}

/// Samples of zero amid loud ones of one sign: the value was lost, not the motion.
pub(super) fn drop_out(facts: &SignalFacts<'_>) -> Option<Finding> {
    let loud = LOUD_PART * facts.peak;
    let (first, length) = facts.runs(2).into_iter().find(|(first, length)| {
        let before = first.checked_sub(1).map(|index| facts.samples[index]);
        let after = facts.samples.get(first + length);
        let (Some(before), Some(after)) = (before, after) else {
            return false;
        };
        same(facts.samples[*first], 0.0)
            && before.abs() > loud
            && after.abs() > loud
            && (before > 0.0) == (*after > 0.0)
    })?;
    let at_s = facts.raw.time_s(first);
    let text = format!(
        "{length} samples from {at_s:.5} s on are zero between {} and {}: the values were lost there",
        in_g(facts.samples[first - 1]),
        in_g(facts.samples[first + length])
    );
    Some(
        if facts.has_noise() {
            Finding::blocking("drop-out", text)
        } else {
            Finding::warning("drop-out", text)
        }
        .at(at_s),
    )
}

/// A record without a change of sign whose noise before the event leans against zero: the
/// channel was rectified, or its converter shows one sign only.
///
/// Noise of a sensor that is off by a little has no lean: its skewness (third standardised
/// moment) is zero, that of rectified normal noise 0.995.
pub(super) fn one_signed(facts: &SignalFacts<'_>) -> Option<Finding> {
    let (low, high) = (*facts.levels.first()?, *facts.levels.last()?);
    let sign = if low >= 0.0 {
        1.0
    } else if high <= 0.0 {
        -1.0
    } else {
        return None;
    };
    let before = &facts.samples[..facts.pre_event];
    if before.len() < LEAN_SAMPLES || facts.pre_deviation < 2.0 * facts.quantum {
        return None;
    }
    let near = sign * facts.pre_mean < 2.0 * facts.pre_deviation;
    // Of noise two samples of three are turning points; a slow onset has none.
    let turns = before
        .windows(3)
        .filter(|three| (three[1] - three[0]) * (three[2] - three[1]) < 0.0)
        .count();
    let third = |value: &f64| {
        let off = sign * (value - facts.pre_mean) / facts.pre_deviation;
        off * off * off
    };
    let skewness = mean(&before.iter().map(third).collect::<Vec<_>>());
    (near && 3 * turns > before.len() && skewness > LEAN).then(|| {
        Finding::blocking(
            "one-signed",
            format!(
                "no sample is {}, and the {} before the event, {} in the mean and {} about it, \
                 lean against zero (skewness {skewness:.2}): the channel was rectified or cannot \
                 show the other sign, so that the direction of the motion is lost",
                if sign > 0.0 { "negative" } else { "positive" },
                before.len(),
                in_g(facts.pre_mean),
                in_g(facts.pre_deviation)
            ),
        )
    })
}
