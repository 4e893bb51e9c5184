//! What tells a record of a crash from another one: its velocity change, and its clock.
//!
//! Samples in a wrong unit, with a lost decimal or on a wrong clock are samples all the same. The
//! velocity that they add up to gives them away, and how fast and how long they were recorded. A
//! record that is unlike a crash may be right, so it is no fault; only a pass on it waits until a
//! person has said what the samples cannot say of themselves.

use super::{ConditioningOptions, Signal, velocity_m_s};
use latchgate_kernel::units::plain;
use latchgate_recording::{Finding, Stated};

/// Stretch over which a velocity change is taken [s]: that of a crash, with the restitution.
pub const VELOCITY_STRETCH_S: f64 = 0.3;

/// Velocity changes of crashes [m/s]. The sills and centres of vehicles that were at hand went
/// through 3.9 to 7.5 m/s sideways; the same channels read in m/s² for g stay below 0.8.
const CRASH_VELOCITY: std::ops::RangeInclusive<f64> = 2.0..=30.0;

/// Factor by which samples and a stated velocity change may differ: a sill goes through another one
/// than the vehicle, and g for m/s² is 9.8.
const STATED_FACTOR: f64 = 2.0;

/// Sample rate beyond which a clock is doubted [Hz]; crash recorders take 10 to 20 kHz.
const FASTEST_HZ: f64 = 50e3;

/// Part of the peak from which a sample belongs to the event.
const EVENT_PART: f64 = 0.1;

/// Shortest record after the event has begun [s]; crash recorders take 200 ms and more.
const SHORTEST_S: f64 = 0.06;

/// Returns the velocity change [m/s] of a signal without bias that is linear between its samples:
/// the largest |∫a dt| over any 0.3 s of it, or over all of it where it is shorter.
pub fn velocity_change_m_s(signal: &Signal) -> f64 {
    let velocity = velocity_m_s(signal);
    let steps = (VELOCITY_STRETCH_S * signal.rate.hertz()).round() as usize;
    let steps = steps.min(velocity.len().saturating_sub(1));
    let later = velocity.iter().skip(steps);
    let changes = velocity.iter().zip(later);
    changes
        .map(|(from, to)| (to - from).abs())
        .fold(0.0, f64::max)
}

/// Returns what is unlike a crash in a signal without bias, and what a person has said of that.
pub(super) fn findings(
    unbiased: &Signal,
    options: &ConditioningOptions,
    stated: &Stated,
) -> Vec<Finding> {
    let velocity = velocity_finding(unbiased, options);
    let clock = clock_finding(unbiased, options, stated);
    velocity.into_iter().chain(clock).collect()
}

fn velocity_finding(unbiased: &Signal, options: &ConditioningOptions) -> Option<Finding> {
    let velocity = velocity_change_m_s(unbiased);
    let (low, high) = (CRASH_VELOCITY.start(), CRASH_VELOCITY.end());
    let shown = plain(velocity, 3);
    if let Some(stated) = options.velocity_change_m_s {
        let alike = (stated / STATED_FACTOR..=stated * STATED_FACTOR).contains(&velocity);
        if !alike {
            let text = format!(
                "the samples give a velocity change of {shown} m/s, but {stated} m/s is stated. \
                 Check unit, scale, clock and channel, and the setting `velocity_change`"
            );
            return Some(Finding::blocking("velocity-contradicted", text));
        }
        let text = format!(
            "the velocity change is {shown} m/s. Crashes give {low} to {high} m/s. A person states \
             {stated} m/s from another source"
        );
        let odd = !CRASH_VELOCITY.contains(&velocity);
        return odd.then(|| Finding::info("velocity-stated", text));
    }
    let moves = unbiased.samples.iter().any(|sample| sample.abs() > 0.0);
    let odd = !CRASH_VELOCITY.contains(&velocity) && moves;
    (odd && !options.synthetic).then(|| {
        let text = format!(
            "the velocity change is {shown} m/s. Crashes give {low} to {high} m/s. Check unit, \
             scale, channel and bias. A pass needs the value from another source: the setting \
             `velocity_change` = M/S"
        );
        Finding::warning("implausible-velocity", text).needing_word()
    })
}

fn clock_finding(
    unbiased: &Signal,
    options: &ConditioningOptions,
    stated: &Stated,
) -> Option<Finding> {
    let sizes = unbiased.samples.iter().map(|sample| sample.abs());
    let peak = sizes.clone().fold(0.0, f64::max);
    let first = sizes
        .into_iter()
        .position(|size| size > EVENT_PART * peak)?;
    let rest_s = unbiased.end_s() - unbiased.time_s(first);
    let rate = unbiased.rate.rounded();
    let fast = (rate > FASTEST_HZ).then(|| format!("the sample rate is {rate} Hz"));
    // Half a nanosecond is less than any recorder tells.
    let short = (rest_s < SHORTEST_S - 5e-10).then(|| {
        let rest_ms = plain(1e3 * rest_s, 3);
        format!("{rest_ms} ms of record follow the first sample beyond a tenth of the peak")
    });
    let unlike: Vec<String> = fast.into_iter().chain(short).collect();
    let unlike = (!unlike.is_empty() && stated.clock_confirmed_by.is_none()).then(|| {
        format!(
            "{}. Crash recorders sample at {} kHz at most, and for at least {} ms after contact",
            unlike.join(", and "),
            FASTEST_HZ / 1e3,
            SHORTEST_S * 1e3
        )
    });
    let doubts: Vec<String> = unlike
        .into_iter()
        .chain(stated.clock_doubt.clone())
        .collect();
    if doubts.is_empty() || options.synthetic {
        return None;
    }
    let text = doubts.join(". ");
    if options.clock_accepted {
        let text = format!("{text}. A person has accepted the clock");
        return Some(Finding::info("clock-accepted", text));
    }
    let text = format!(
        "{text}. Check the sample rate and the unit of time. If both are right, a pass needs the \
         setting `accept` = clock"
    );
    Some(Finding::warning("clock-implausible", text).needing_word())
}
