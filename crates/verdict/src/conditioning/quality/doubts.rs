//! What is odd in a signal and no proof: velocities, levels and noise that speak of a wrong
//! channel, unit, sign or zero. Each asks for a look.

use super::{EVENT_PART, QUIET_PART, SignalFacts, in_g};
use crate::conditioning::bias;
use latchgate_kernel::range::Range;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::Finding;

/// Part of a signal's power beyond which what lies near half the sample rate is too much.
const ALIASED_PART: f64 = 0.5;

/// Mean before the event that speaks of gravity [g], and its largest standard error.
const GRAVITY_G: Range = Range::new(0.9, 1.1);
const GRAVITY_ERROR_G: f64 = 0.05;

/// Part of all pushes that must add up to one side before a sign is told from them.
const ONE_SIDED_PART: f64 = 0.3;

/// Part of all pushes that the first one must have to count.
const LOBE_PART: f64 = 0.1;

/// Change of velocity below which a record has no sign [m/s].
const SIGN_VELOCITY: f64 = 0.5;

/// Peaks of vehicle structures near a door [g].
const PLAUSIBLE_PEAK_G: Range = Range::new(5.0, 2000.0);

/// Velocity that a wrong zero has to add to be worth a look [m/s]: what opens the paper's lever.
const ADDED_VELOCITY: f64 = 0.48;

/// Largest velocity of a crash channel from which a return to nought is odd [m/s]; part of it, and
/// velocity on top [m/s], that count as nought. Struck bodies keep more than half of it.
const RETURNING_VELOCITY: f64 = 0.3;
const RETURNED_PART: f64 = 0.1;
const RETURNED_VELOCITY: f64 = 0.1;

/// Stretch at the end of a record that must be calm [s], and the part of the peak that is not.
const CALM_S: f64 = 1e-2;
const CALM_PART: f64 = 0.25;

/// Returns what is odd in a record that is not dead.
pub(super) fn findings(facts: &SignalFacts<'_>) -> Vec<Finding> {
    [
        aliasing(facts),
        gravity(facts),
        sign_suspicion(facts),
        ends_early(facts),
        implausible_peak(facts),
        spike(facts),
        pre_event_not_quiet(facts),
        drift(facts),
        zero_shift(facts),
        velocity_returns(facts),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Most of the power lies near half the sample rate, so that more lies beyond and is folded in.
fn aliasing(facts: &SignalFacts<'_>) -> Option<Finding> {
    let event = &facts.samples[facts.pre_event..];
    let power: f64 = event.iter().map(|value| value * value).sum();
    // The power of differences over four times that of the samples is sin²(πf/fs) on average.
    let differences: f64 = event
        .windows(2)
        .map(|pair| (pair[1] - pair[0]) * (pair[1] - pair[0]))
        .sum();
    let part = differences / (4.0 * power);
    (event.len() >= 32 && part > ALIASED_PART).then(|| {
        let text = format!(
            "most of the signal's power lies above a quarter of the sample rate of {} Hz. Motion \
             above half the rate may show as a slower one. Record at a higher rate",
            facts.raw.rate.rounded()
        );
        Finding::warning("aliasing-suspected", text)
    })
}

/// The mean before the event is that of a sensor that stands upright.
fn gravity(facts: &SignalFacts<'_>) -> Option<Finding> {
    let mean_g = facts.pre_mean / STANDARD_GRAVITY;
    (facts.pre_event > 0
        && GRAVITY_G.contains(mean_g.abs())
        && facts.pre_mean_error <= GRAVITY_ERROR_G * STANDARD_GRAVITY)
        .then(|| {
            let text = format!(
                "the mean before the event is {mean_g:.4} g, as if from gravity. A lateral axis \
                 reads none. Check that the channel is not vertical and that the sensor was not \
                 tilted"
            );
            Finding::warning("gravity-suspected", text)
        })
}

/// The first push and the velocity that the record adds up to have opposite signs.
fn sign_suspicion(facts: &SignalFacts<'_>) -> Option<Finding> {
    let event: Vec<f64> = facts.samples[facts.pre_event..]
        .iter()
        .map(|value| value - facts.pre_mean)
        .collect();
    let sum: f64 = event.iter().sum();
    let size: f64 = event.iter().map(|value| value.abs()).sum();
    let velocity = sum / facts.raw.rate.hertz();
    if sum.abs() < ONE_SIDED_PART * size || velocity.abs() < SIGN_VELOCITY {
        return None;
    }
    let threshold = (5.0 * facts.pre_deviation).max(EVENT_PART * facts.peak);
    let first = event.iter().position(|value| value.abs() > threshold)?;
    if (event[first] > 0.0) == (sum > 0.0) {
        return None;
    }
    // A lobe, not a flicker: what it pushes until it changes sign.
    let lobe: f64 = event[first..]
        .iter()
        .take_while(|value| (**value > 0.0) == (event[first] > 0.0))
        .sum();
    if lobe.abs() < LOBE_PART * size {
        return None;
    }
    let at_s = facts.raw.time_s(facts.pre_event + first);
    let text = format!(
        "the first push, at {at_s:.5} s, has the opposite sign of the velocity of {velocity:.3} \
         m/s that the record adds up to. Check the setting `opens_when`, and that the part neither \
         rotates nor rebounds"
    );
    Some(Finding::warning("sign-suspected", text).at(at_s))
}

/// The record stops soon after loud samples: what would have come is missing.
fn ends_early(facts: &SignalFacts<'_>) -> Option<Finding> {
    let calm = (CALM_S * facts.raw.rate.hertz()).round() as usize;
    let count = facts.samples.len();
    let tail = &facts.samples[count.saturating_sub(calm)..];
    let largest = super::reach(tail, facts.bias);
    (calm > 0 && largest > CALM_PART * facts.peak).then(|| {
        let text = format!(
            "the last {:.0} ms still reach {}, more than a quarter of the peak. The end of the \
             event may be missing. Export the whole event",
            1e3 * CALM_S,
            in_g(largest)
        );
        Finding::warning("ends-early", text).at(facts.raw.end_s())
    })
}

fn implausible_peak(facts: &SignalFacts<'_>) -> Option<Finding> {
    let peak_g = facts.peak / STANDARD_GRAVITY;
    let Range { low, high } = PLAUSIBLE_PEAK_G;
    (!PLAUSIBLE_PEAK_G.contains(peak_g)).then(|| {
        let text = format!(
            "the peak is {peak_g:.4} g. Channels near a door reach {low} to {high} g in a crash. \
             Check the unit and the channel"
        );
        Finding::warning("implausible-peak", text)
    })
}

/// One sample that jumps by more than half the peak and comes back at once.
fn spike(facts: &SignalFacts<'_>) -> Option<Finding> {
    let jump = 0.5 * facts.peak;
    let index = facts.samples.windows(3).position(|three| {
        let (up, down) = (three[1] - three[0], three[1] - three[2]);
        up.abs() > jump
            && down.abs() > jump
            && (up > 0.0) == (down > 0.0)
            && (three[2] - three[0]).abs() < 0.1 * facts.peak
    })? + 1;
    let at_s = facts.raw.time_s(index);
    let text = format!(
        "the sample at {at_s:.5} s jumps to {} and back within one interval. That looks like a \
         drop-out or a disturbance. Look at the sample",
        in_g(facts.samples[index])
    );
    Some(Finding::warning("spike", text).at(at_s))
}

fn pre_event_not_quiet(facts: &SignalFacts<'_>) -> Option<Finding> {
    let largest = facts.loudest_before();
    (largest > QUIET_PART * facts.peak).then(|| {
        let text = format!(
            "samples before -1 ms lie up to {} off their mean, more than a quarter of the peak. \
             The bias or time zero may be wrong. Check the setting `bias` and the setting \
             `time_zero`",
            in_g(largest)
        );
        Finding::warning("pre-event-not-quiet", text)
    })
}

/// The bias moves while it is measured, so much that it matters for the velocity: a line through
/// the pre-event samples rises by more than what is left beside the line can explain.
fn drift(facts: &SignalFacts<'_>) -> Option<Finding> {
    let samples = &facts.samples[..facts.pre_event];
    if samples.len() < 4 {
        return None;
    }
    let middle = 0.5 * (samples.len() - 1) as f64;
    let (mut rise, mut run) = (0.0, 0.0);
    for (index, value) in samples.iter().enumerate() {
        let step = index as f64 - middle;
        rise += step * (value - facts.pre_mean);
        run += step * step;
    }
    let slope = rise / run;
    let beside = |(index, value): (usize, &f64)| value - slope * (index as f64 - middle);
    let beside: Vec<f64> = samples.iter().enumerate().map(beside).collect();
    let change = slope * 2.0 * middle;
    // The rise of a fitted line over its length has √12 times the error of the mean.
    let error = 12.0_f64.sqrt() * bias::standard_error_of_mean(&beside);
    // Half of it is how far the zero at contact lies from the mean.
    let added_velocity_m_s = 0.5 * change.abs() * facts.raw.end_s();
    let matters = added_velocity_m_s > ADDED_VELOCITY;
    (matters && change.abs() > (5.0 * error).max(0.1 * STANDARD_GRAVITY)).then(|| {
        let text = format!(
            "the samples before the event drift by {} while the bias is taken. The bias may not \
             fit the event: the rest adds up to {added_velocity_m_s:.2} m/s. Check the sensor's warm-up",
            in_g(change)
        );
        Finding::warning("drift", text)
    })
}

/// The tail lies steadily away from the mean before the event, so far that it matters for the
/// velocity. A body that still moves does not do so steadily.
fn zero_shift(facts: &SignalFacts<'_>) -> Option<Finding> {
    let ten_ms = (0.01 * facts.raw.rate.hertz()).round() as usize;
    let count = facts.samples.len();
    let length = ten_ms.max(count / 20);
    if facts.pre_event == 0 || length < 2 || 3 * length > count - facts.pre_event {
        return None;
    }
    let tail = &facts.samples[count - length..];
    let earlier = &facts.samples[count - 2 * length..count - length];
    let shift = bias::mean(tail) - facts.pre_mean;
    let steady = (bias::mean(earlier) - bias::mean(tail)).abs() < 0.4 * shift.abs();
    let error = libm::hypot(bias::standard_error_of_mean(tail), facts.pre_mean_error);
    let added = 0.5 * shift.abs() * facts.raw.end_s();
    let matters = steady && added > ADDED_VELOCITY;
    (matters && shift.abs() > (5.0 * error).max(0.01 * facts.peak)).then(|| {
        let text = format!(
            "the mean of the last {:.1} ms lies {} off the mean before the event, and so does that \
             of the same length before. The zero may have shifted in the impact. Look at the end \
             of the recording",
            1e3 * length as f64 / facts.raw.rate.hertz(),
            in_g(shift)
        );
        Finding::warning("zero-shift", text)
    })
}

/// The velocity comes back to nought: of a channel whose lowest frequencies were taken away it always does,
/// of a struck body it seldom does.
fn velocity_returns(facts: &SignalFacts<'_>) -> Option<Finding> {
    let (mut end, mut largest) = (0.0, 0.0_f64);
    for value in &facts.samples[facts.contact.min(facts.samples.len())..] {
        end += (value - facts.bias) / facts.raw.rate.hertz();
        largest = largest.max(f64::abs(end));
    }
    let unsure = (facts.pre_mean_error * facts.raw.end_s()).min(RETURNED_VELOCITY);
    let returned = end.abs() < RETURNED_PART * largest + RETURNED_VELOCITY + unsure;
    (facts.pre_event > 0 && returned && largest > RETURNING_VELOCITY).then(|| {
        let text = format!(
            "the velocity reaches {:.2} m/s and ends at {:.3} m/s, as behind a high pass (AC \
             coupling). A high pass hides a lasting push. Check amplifier and filter, unless the \
             body came to rest again",
            largest, end
        );
        Finding::warning("velocity-returns", text)
    })
}
