//! Stretches in which sensor, cable, recorder or converter lost the motion: runs of samples that
//! the channel's own noise does not make, and values that were lost one by one.

use super::noise::{self, LEAST_SAMPLES, Noise, RunKind};
use super::{EVENT_PART, LOUD_PART, QUIET_QUANTA, SignalFacts, in_g, is_cut, same};
use latchgate_recording::Finding;

/// Longest stretch of equal samples that a moving body can give [s], and the fewest samples of it.
const FROZEN_S: f64 = 5e-3;
const FROZEN_RUN: usize = 8;

/// Stretch right before a run that tells whether the channel had come to rest [s], and its least
/// number of samples.
const LOCAL_S: f64 = 1e-2;
const LOCAL_SAMPLES: usize = 64;

/// Stretch at the end of the record that tells what a channel silent at its beginning can show [s].
const TAIL_S: f64 = 2e-2;

/// Time after first contact from which silence since the beginning is no rest [s].
const SILENT_UNTIL_S: f64 = 1e-3;

/// Innovation at the end of a record that is noise and no rounding of a formula [quanta].
const TAIL_QUANTA: f64 = 3.0;

/// Least number of samples that were lost one by one.
const LOST_SAMPLES: usize = 3;

/// The first run after −1 ms that chance does not make on this channel.
pub(super) fn held(facts: &SignalFacts<'_>) -> Option<Finding> {
    let equal = noise::equal_runs(facts.samples, 4);
    let line = noise::line_runs(facts.samples, facts.quantum, 6);
    let impossible = |kind: RunKind, runs: Vec<(usize, usize)>| {
        runs.into_iter()
            .filter(|(first, length)| first + length > facts.contact)
            .find(|(first, length)| no_chance(facts, kind, *first, *length))
    };
    let stretches = [
        impossible(RunKind::Equal, equal),
        impossible(RunKind::Line, line),
        silent_head(facts),
    ];
    let (first, length) = stretches.into_iter().flatten().min()?;
    let (begin, end) = (facts.samples[first], facts.samples[first + length - 1]);
    let from_s = facts.raw.time_s(first);
    let to_s = facts.raw.time_s(first + length - 1);
    let explanation = "The channel's noise does this with a chance below 1e-9. Sensor, cable or recorder \
                failed, or the samples were filled in. If an export added them after the record, \
                judge the part before with the setting `window` = START..END";
    let finding = if (begin - end).abs() > 2.0 * facts.quantum {
        let text = format!(
            "{length} samples from {from_s:.5} s to {to_s:.5} s lie on a straight line from {} to \
             {}. {explanation}",
            in_g(begin),
            in_g(end)
        );
        Finding::blocking("straight-line", text)
    } else {
        let run = &facts.samples[first..first + length];
        let how = if run.iter().all(|value| same(*value, begin)) {
            "are equal"
        } else {
            "differ by no more than the last digit"
        };
        let message = format!(
            "{length} samples from {from_s:.5} s to {to_s:.5} s {how}, at {}. {explanation}",
            in_g(begin)
        );
        Finding::blocking("frozen", message)
    };
    Some(finding.at(from_s))
}

/// Tells whether neither the noise before the event nor what comes right before a run makes it.
fn no_chance(facts: &SignalFacts<'_>, kind: RunKind, first: usize, length: usize) -> bool {
    let total = facts.samples.len();
    let learn_before = |_| Noise::learn(&facts.samples[..first], facts.quantum);
    let before = match first >= facts.pre_event {
        true => facts.noise,
        // What a run reaches into tells nothing of noise.
        false => facts.noise.and_then(learn_before),
    };
    let exceeds = |noise: Noise| {
        let least = noise.least_run(kind, total);
        least.is_some_and(|least| length as f64 >= least)
            && (noise.is_lively() || is_cut(facts, first, length, 1.0))
    };
    let reach = (LOCAL_S * facts.raw.rate.hertz()) as usize;
    let local = &facts.samples[first.saturating_sub(reach.max(LOCAL_SAMPLES))..first];
    before.is_some_and(exceeds) && Noise::learn(local, facts.quantum).is_none_or(exceeds)
}

/// Silence from the first sample until after first contact, on a channel that shows noise at rest
/// when the event is over. A formula, or a converter too coarse for the noise, shows none.
fn silent_head(facts: &SignalFacts<'_>) -> Option<(usize, usize)> {
    let (first, length) = *noise::equal_runs(facts.samples, LEAST_SAMPLES).first()?;
    let total = facts.samples.len();
    let tail = total.checked_sub((TAIL_S * facts.raw.rate.hertz()) as usize)?;
    let after_event = &facts.samples[tail.max(first + length)..];
    let quantum = noise::quantum(&noise::levels(after_event));
    let noise = Noise::learn(after_event, quantum)?;
    let middle = after_event.iter().sum::<f64>() / after_event.len() as f64;
    let is_silent_head = first < LEAST_SAMPLES
        && facts.raw.time_s(first + length - 1) > SILENT_UNTIL_S
        && facts.raw.time_s(0) <= 0.0
        && super::reach(after_event, middle) <= super::QUIET_PART * facts.peak
        && noise.exceeds(TAIL_QUANTA)
        && super::turns_like_noise(after_event, 0.0)
        && noise.least_run(RunKind::Equal, total)? <= length as f64;
    is_silent_head.then_some((first, length))
}

/// Equal samples away from rest for longer than a moving body stands still, on a channel whose
/// noise is not known. A slow signal on a coarse grid may stand still at its top; it comes and goes gently.
pub(super) fn stands_still(facts: &SignalFacts<'_>) -> Option<Finding> {
    let still = (FROZEN_S * facts.raw.rate.hertz()).floor() as usize;
    let least = still.saturating_add(2).max(FROZEN_RUN);
    let runs = noise::equal_runs(facts.samples, least);
    let (first, length) = runs.into_iter().find(|(first, length)| {
        let away = (facts.samples[*first] - facts.bias).abs();
        away > QUIET_QUANTA * facts.quantum
            && away > 5.0 * facts.pre_deviation
            && away > 0.01 * facts.peak
            && is_cut(facts, *first, *length, 1.0)
    })?;
    let at_s = facts.raw.time_s(first);
    let observation = format!(
        "{length} equal samples of {} from {at_s:.5} s to {:.5} s: a moving body does not stand \
         still for more than {} ms",
        in_g(facts.samples[first]),
        facts.raw.time_s(first + length - 1),
        1e3 * FROZEN_S
    );
    let text = format!(
        "{observation}. Check sensor, cable and recorder. If a formula made the signal, write `synthetic \
         = true` in the card"
    );
    let finding = Finding::blocking("frozen", text);
    Some(finding.at(at_s))
}

/// Samples of exactly zero amid loud ones of one sign: several on end, or single ones again and
/// again. The values were lost, not the motion. Ringing dips as well, but not always to zero.
pub(super) fn drop_out(facts: &SignalFacts<'_>) -> Option<Finding> {
    let loud = |value: &f64| value.abs() > LOUD_PART * facts.peak;
    let (mut lost, mut longest, mut begin) = (0, 0, None);
    for (first, length) in noise::equal_runs(facts.samples, 1) {
        let before = first.checked_sub(1).map(|index| facts.samples[index]);
        let after = facts.samples.get(first + length).copied();
        let (Some(before), Some(after)) = (before, after) else {
            continue;
        };
        if same(facts.samples[first], 0.0)
            && loud(&before)
            && loud(&after)
            && (before > 0.0) == (after > 0.0)
        {
            lost += length;
            longest = longest.max(length);
            begin = begin.or(Some(first));
        }
    }
    let dips = facts.samples.windows(3).filter(|three| {
        loud(&three[0])
            && loud(&three[2])
            && (three[0] > 0.0) == (three[2] > 0.0)
            && three[1].abs() <= EVENT_PART * facts.peak
    });
    let again = lost >= LOST_SAMPLES && 10 * lost >= 9 * dips.count();
    let first = begin.filter(|_| longest >= 2 || again)?;
    let at_s = facts.raw.time_s(first);
    let text = format!(
        "{lost} samples from {at_s:.5} s on are zero between loud ones of one sign: their values \
         were lost. Record or export again"
    );
    Some(Finding::blocking("drop-out", text).at(at_s))
}
