//! Check of a recorded sled pulse against what the door-latch regulations ask of it.
//!
//! After CFC 60: at least 30 g for 30 ms on end, within the corridor with t = 0 as stated, never shifted to
//! fit. What exceeds 36 g alone, the corridor's upper level, leaves a pulse valid if the latch held with all else met:
//! it was the harder pulse. Below the lower bound, or above the upper one at less than 36 g, a pulse is outside.
//!
//! # Source
//!
//! 49 CFR 571.206 S5.1.1.4(b)(3), (iv) for what exceeds 36 g; UN R11 Annex 4. The corridor's points stand from memory.

use crate::conditioning::{self, Cfc, Conditioned, Signal};
use latchgate_kernel::range::Window;
use latchgate_kernel::units::{STANDARD_GRAVITY, short};
use latchgate_recording::error::Error;
use latchgate_recording::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// Acceleration that is to be held [g].
pub const LEVEL_G: f64 = 30.0;

/// Upper level of the corridor, beyond which a pulse that is met all the same is the harder one [g].
pub const UPPER_LEVEL_G: f64 = 36.0;

/// Time for which it is to be held on end [s].
pub const HELD_S: f64 = 0.030;

/// Vertices of the corridor's lower bound: time [s], acceleration [g].
pub const LOWER: [(f64, f64); 4] = [(0.005, 0.0), (0.025, 30.0), (0.055, 30.0), (0.070, 0.0)];

/// Vertices of its upper bound.
pub const UPPER: [(f64, f64); 4] = [(0.0, 6.0), (0.020, 36.0), (0.060, 36.0), (0.100, 0.0)];

/// Largest acceleration of either sign before and after the corridor, that with which its upper bound begins [g]: a second
/// blow makes another pulse.
pub const OUTSIDE_G: f64 = UPPER[0].1;

/// Where a pulse lies farthest beyond a bound.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Beyond {
    /// When [s].
    pub time_s: f64,
    /// By how much [g].
    pub by_g: f64,
}

/// What a sled pulse is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SledAnswer {
    /// Within the corridor, and the level is held.
    Valid,
    /// The same, but for what exceeds 36 g: valid if the latch held.
    ValidIfHeld,
    /// No pulse of the regulation.
    NotValid,
}

/// What was found of a sled pulse.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SledCheck {
    /// What it is worth: whether the level is held, the pulse lies within the corridor, and all of it was recorded
    /// without a fault.
    pub answer: SledAnswer,
    /// True if the record covers the corridor from where its lower bound begins.
    pub covered: bool,
    /// True if a finding blocks the recording.
    pub faulty: bool,
    /// Sign of the acceleration that was taken for the pulse, by its largest magnitude.
    pub sign: f64,
    /// Longest time at or above 30 g [s].
    pub held_s: f64,
    /// When that begins and ends [s]; `None` if it never is.
    pub held_window_s: Option<(f64, f64)>,
    /// Where it lies farthest below the corridor.
    pub below: Option<Beyond>,
    /// Where it lies farthest above the corridor at up to 36 g.
    pub above: Option<Beyond>,
    /// Where it lies farthest above 36 g.
    pub above_level: Option<Beyond>,
    /// Where it lies farthest above 6 g, of either sign, before or after the corridor's time.
    pub outside: Option<Beyond>,
    /// Largest acceleration [g].
    pub peak_g: f64,
    /// When [s].
    pub peak_time_s: f64,
    /// Bias that was removed before [g].
    #[serde(default)]
    pub bias_removed_g: f64,
}

/// Checks a channel as a sled pulse, with what was found of it; returns it after CFC 60, by which it is checked, too.
///
/// # Errors
///
/// As [`conditioning::condition`] for the filter.
pub fn check(
    conditioned: &Conditioned,
    findings: &[Finding],
) -> Result<(SledCheck, Signal), Error> {
    let filtered = conditioning::filtered(conditioned, Some(Cfc::Cfc60))?;
    let mut check = checked(&filtered);
    check.bias_removed_g = conditioned.bias_m_s2 / STANDARD_GRAVITY;
    check.faulty = findings
        .iter()
        .any(|finding| finding.severity == Severity::Blocking);
    if check.faulty {
        check.answer = SledAnswer::NotValid;
    }
    Ok((check, filtered))
}

/// Checks a signal that is filtered, by straight lines between its samples.
pub fn checked(signal: &Signal) -> SledCheck {
    let peak = conditioning::peak(signal).unwrap_or(0);
    let sign = match signal.samples.get(peak) {
        Some(value) if *value < 0.0 => -1.0,
        _ => 1.0,
    };
    let points: Vec<(f64, f64)> = (signal.samples.iter().enumerate())
        .map(|(index, value)| (signal.time_s(index), sign * value / STANDARD_GRAVITY))
        .collect();
    let held_window = held(&points);
    let held_s = held_window.map_or(0.0, |window| window.until_s - window.from_s);
    let below = farthest(&points, &LOWER, |pulse, bound| bound - pulse);
    let above = farthest(&points, &UPPER, |pulse, bound| {
        pulse.min(UPPER_LEVEL_G) - bound
    });
    let above_level = farthest(&points, &UPPER, |pulse, _| pulse - UPPER_LEVEL_G);
    let corridor = UPPER[0].0..=UPPER[3].0;
    let beside = points.iter().filter(|point| !corridor.contains(&point.0));
    let beyond = beside.map(|(time_s, level_g)| Beyond {
        time_s: *time_s,
        by_g: level_g.abs() - OUTSIDE_G,
    });
    let outside = beyond
        .filter(|beyond| beyond.by_g > 0.0)
        .reduce(|a, b| if b.by_g > a.by_g { b } else { a });
    // The last sample may lie just before the corridor's end.
    let end_s = signal.end_s() + 1.5 * signal.rate.interval().seconds();
    let covered = signal.start_s <= LOWER[0].0 && end_s >= UPPER[3].0;
    let is_met =
        held_s >= HELD_S && below.is_none() && above.is_none() && outside.is_none() && covered;
    SledCheck {
        answer: match is_met {
            true if above_level.is_none() => SledAnswer::Valid,
            true => SledAnswer::ValidIfHeld,
            false => SledAnswer::NotValid,
        },
        covered,
        faulty: false,
        sign,
        held_s,
        held_window_s: held_window.map(|window| (window.from_s, window.until_s)),
        below,
        above,
        above_level,
        outside,
        peak_g: points.get(peak).map_or(0.0, |point| point.1),
        peak_time_s: signal.time_s(peak),
        bias_removed_g: 0.0,
    }
}

/// Returns the longest time on end at or above the level.
fn held(points: &[(f64, f64)]) -> Option<Window> {
    let mut longest: Option<Window> = None;
    let mut from = points
        .first()
        .filter(|first| first.1 >= LEVEL_G)
        .map(|first| first.0);
    let mut end = |from_s: f64, until_s: f64| {
        let window = Window::new(from_s, until_s);
        let length = |window: &Window| window.until_s - window.from_s;
        if longest
            .as_ref()
            .is_none_or(|longest| length(longest) < length(&window))
        {
            longest = Some(window);
        }
    };
    for pair in points.windows(2) {
        let [(t, a), (next_t, next)] = [pair[0], pair[1]];
        let crossing = t + (next_t - t) * (LEVEL_G - a) / (next - a);
        match (a >= LEVEL_G, next >= LEVEL_G) {
            (false, true) => from = Some(crossing),
            (true, false) => end(from.take().unwrap_or(t), crossing),
            _ => {}
        }
    }
    if let (Some(from), Some(last)) = (from, points.last()) {
        end(from, last.0);
    }
    longest
}

/// Returns where a pulse lies farthest beyond a bound, over the bound's own time; where no sample is, the pulse
/// is zero.
fn farthest(
    points: &[(f64, f64)],
    bound: &[(f64, f64)],
    beyond: impl Fn(f64, f64) -> f64,
) -> Option<Beyond> {
    let (first, last) = (bound[0].0, bound[bound.len() - 1].0);
    let inside = points.iter().map(|point| point.0);
    let times = inside
        .filter(|time| (first..=last).contains(time))
        .chain(bound.iter().map(|vertex| vertex.0));
    let farthest = times
        .map(|time_s| Beyond {
            time_s,
            by_g: beyond(at(points, time_s), at(bound, time_s)),
        })
        .reduce(|a, b| if b.by_g > a.by_g { b } else { a });
    // Rounding puts no pulse beyond its own bound.
    farthest.filter(|farthest| farthest.by_g > 1e-9)
}

/// Returns the value on straight lines between points; zero before the first and after the last.
fn at(points: &[(f64, f64)], time_s: f64) -> f64 {
    let next = points.partition_point(|point| point.0 < time_s);
    match (
        next.checked_sub(1).map(|before| points[before]),
        points.get(next),
    ) {
        (_, Some(point)) if point.0 <= time_s => point.1,
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (time_s - a.0) / (b.0 - a.0),
        _ => 0.0,
    }
}

impl SledCheck {
    /// Says what was found, the answer first.
    pub fn sentences(&self) -> Vec<String> {
        let ms = |seconds: f64| format!("{:.2} ms", 1e3 * seconds);
        // No "0.00 g" of what decides.
        let level = |by_g: f64| match by_g < 0.01 {
            true => format!("{by_g:.1e} g"),
            false => format!("{by_g:.2} g"),
        };
        let mut sentences = Vec::new();
        sentences.push(
            match self.answer {
                SledAnswer::Valid => {
                    "A valid sled pulse of 49 CFR 571.206 S5.1.1.4(b)(3), after CFC 60: within the corridor."
                }
                SledAnswer::ValidIfHeld => {
                    "Above 36 g with all else met, after CFC 60: a valid sled pulse if the latch held (49 CFR 571.206 \
                     S5.1.1.4(b)(3)(iv))."
                }
                SledAnswer::NotValid => {
                    "Not a valid sled pulse of 49 CFR 571.206 S5.1.1.4(b)(3), after CFC 60."
                }
            }
            .to_string(),
        );
        sentences.push(match self.held_window_s {
            Some((from_s, until_s)) => format!(
                "At or above 30 g for {} on end, from {} to {}; 30 ms are needed.",
                ms(self.held_s),
                ms(from_s),
                ms(until_s)
            ),
            None => format!("Never at 30 g: the largest is {:.2} g.", self.peak_g),
        });
        sentences.push(match self.below {
            Some(Beyond { time_s, by_g }) => {
                format!(
                    "Below the corridor by up to {}, at {}.",
                    level(by_g),
                    ms(time_s)
                )
            }
            None => "Nowhere below the corridor.".into(),
        });
        sentences.push(match self.above {
            Some(Beyond { time_s, by_g }) => format!(
                "Above the corridor by up to {}, at {}.",
                level(by_g),
                ms(time_s)
            ),
            None => "Nowhere above the corridor at up to 36 g.".into(),
        });
        if let Some(Beyond { time_s, by_g }) = self.above_level {
            sentences.push(format!(
                "Above 36 g by up to {}, at {}.",
                level(by_g),
                ms(time_s)
            ));
        }
        if let Some(Beyond { time_s, by_g }) = self.outside {
            sentences.push(format!(
                "Another blow beside the corridor, {} above 6 g, at {}.",
                level(by_g),
                ms(time_s)
            ));
        }
        if self.bias_removed_g != 0.0 {
            let bias = short(self.bias_removed_g, 2);
            sentences.push(format!("A bias of {bias} g was removed before."));
        }
        if !self.covered {
            sentences.push("The record does not cover the corridor from 5 to 100 ms.".into());
        }
        if self.faulty {
            sentences.push("A finding blocks the recording: see there.".into());
        }
        sentences.push(
            "The corridor's points are from memory and unverified, its t = 0 is the file's, or as stated."
                .into(),
        );
        sentences
    }
}
