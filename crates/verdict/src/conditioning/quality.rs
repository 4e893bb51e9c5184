//! Faults of a raw channel: sides and stretches that are missing, records cut inside the event.
//!
//! A channel is judged by its own noise: `noise` learns from the samples before the event how they are
//! spread and how they hang together, and says from which length on a run of samples is no chance.
//! They are looked for before anything is removed or filtered, since a filter rounds off what an
//! overload leaves. Only the question whether a record starts or ends inside its event is asked of
//! samples without their bias: an offset is no event.
//!
//! - `noise`: the channel at rest, and what chance makes on it;
//! - `interpolated`: a slow channel on a fast raster;
//! - `held`: stretches in which the motion was lost;
//! - `top`: sides that were cut off, rectified, or ran over;
//! - `doubts`: what is odd and proves nothing.

mod doubts;
mod held;
mod interpolated;
mod noise;
mod top;

use super::{ConditioningOptions, Signal, bias};
use crate::noise_spectrum::QUIET_SAMPLES;
pub use interpolated::SlowClock;
use latchgate_kernel::units::{STANDARD_GRAVITY, plain};
use latchgate_recording::{Finding, Severity};
use noise::Noise;

/// Quanta above which a level is told from noise around zero: healthy channels repeat
/// values near zero three to seven times.
const QUIET_QUANTA: f64 = 20.0;

/// Largest part of the peak that samples before the event may reach if they shall tell noise.
const QUIET_PART: f64 = 0.25;

/// Part of the bends that change sides in noise; a motion of eight samples a period has as many.
const TURNING_PART: f64 = 0.25;

/// Part of the peak from which a sample is certainly inside the event, for drop-outs.
const LOUD_PART: f64 = 0.25;

/// Part of the peak that counts as "inside the event" at either end of a record.
const EVENT_PART: f64 = 0.1;

/// Least sample rate of a crash recording [Hz].
const LEAST_RATE_HZ: f64 = 250.0;

/// Two levels further apart than this are a signal, nearer than this a flickering last bit [g].
const FLICKER_G: f64 = 1.0;

/// Returns what is odd in a raw signal [m/s²]. `options` holds the bias as it will be removed, the
/// declared range and whether the signal was made by a formula.
pub fn findings(raw: &Signal, options: &ConditioningOptions) -> Vec<Finding> {
    examine(raw, options).findings
}

/// What a raw signal shows of itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawQuality {
    /// What is odd in it.
    pub findings: Vec<Finding>,
    /// The clock that it was interpolated from, if it was.
    pub slow_clock: Option<SlowClock>,
}

/// As [`findings`], with the clock that the signal was interpolated from.
pub fn examine(raw: &Signal, options: &ConditioningOptions) -> RawQuality {
    if raw.samples.is_empty() {
        return RawQuality::default();
    }
    let facts = SignalFacts::new(raw, options);
    // A formula may be made of straight lines.
    let slow_clock = match options.synthetic {
        true => None,
        false => interpolated::slow_clock(facts.samples, &facts.levels, raw.rate),
    };
    let mut findings = Vec::new();
    findings.extend(low_rate(raw));
    findings.extend(slow_clock.map(interpolated_finding));
    let dead = dead_sensor(&facts);
    let is_dead = dead.is_some();
    if options.synthetic {
        findings.push(Finding::info(
            "synthetic",
            "the card says that a formula made the signal. Clipping, frozen and dead sensors were \
             not checked",
        ));
    } else if is_dead {
        findings.extend(dead);
    } else {
        findings.extend(top::clipping(&facts, options.range_g));
        let standstill = held::held(&facts).or_else(|| held::stands_still(&facts));
        // A clipped top stands still as well, and is told once.
        let is_reported = |finding: &Finding| {
            let before =
                |one: &Finding| one.severity == Severity::Blocking && one.at_s <= finding.at_s;
            findings.iter().any(before)
        };
        let standstill = standstill.filter(|finding| !is_reported(finding));
        findings.extend(standstill);
        findings.extend(held::drop_out(&facts));
        findings.extend(top::wrap_around(&facts));
        findings.extend(top::one_signed(&facts));
        if findings.is_empty() {
            findings.extend(top::flickering(&facts));
        }
        findings.extend(noise_unknown(&facts, options.noise_accepted));
    }
    if facts.own_peak > 0.0 && !is_dead {
        findings.extend(starts_inside_event(&facts));
        findings.extend(ends_inside_event(&facts));
        findings.extend(doubts::findings(&facts));
    }
    RawQuality {
        findings,
        slow_clock,
    }
}

/// What the detectors share.
struct SignalFacts<'a> {
    raw: &'a Signal,
    samples: &'a [f64],
    /// What will be removed as bias [m/s²].
    bias: f64,
    /// Largest magnitude without the bias [m/s²], that of the judged channel if that is larger.
    peak: f64,
    /// Its own.
    own_peak: f64,
    /// Different values, rising.
    levels: Vec<f64>,
    /// Step of the grid on which the samples lie [m/s²]; 0 if there is one value only.
    quantum: f64,
    /// First sample after −1 ms.
    contact: usize,
    /// Number of samples before the event; 0 if they are too few to tell.
    pre_event: usize,
    /// Their mean and standard deviation [m/s²].
    pre_mean: f64,
    pre_deviation: f64,
    pre_mean_error: f64,
    /// What they tell of the channel at rest.
    noise: Option<Noise>,
}

impl<'a> SignalFacts<'a> {
    fn new(raw: &'a Signal, options: &ConditioningOptions) -> Self {
        let samples = raw.samples.as_slice();
        let removed = bias::bias(raw, options.bias).map_or(0.0, |(bias, _)| bias.mean_m_s2);
        let count = bias::pre_event_samples(raw).unwrap_or(0);
        let before = bias::bias(raw, super::BiasWindow::PreEvent)
            .map(|(bias, _)| bias)
            .unwrap_or_default();
        let levels = noise::levels(samples);
        let grid = noise::quantum(&noise::levels(&samples[..count]));
        let position = (bias::PRE_EVENT_END_S - raw.start_s) * raw.rate.hertz();
        let own_peak = reach(samples, removed);
        let mut facts = Self {
            raw,
            samples,
            bias: removed,
            peak: own_peak.max(options.judged_peak_m_s2.unwrap_or(0.0)),
            own_peak,
            quantum: match grid > 0.0 {
                true => grid,
                false => noise::quantum(&levels),
            },
            levels,
            contact: (position + 1.01).floor().max(0.0) as usize,
            pre_event: count,
            pre_mean: before.mean_m_s2,
            pre_deviation: before.standard_deviation_m_s2,
            pre_mean_error: before.standard_error_m_s2,
            noise: None,
        };
        // Where the event is lost, noise is the largest that is left.
        let loudest = facts.loudest_before();
        if loudest <= QUIET_PART * facts.peak || loudest <= 5.0 * facts.pre_deviation {
            facts.noise = Noise::learn(&samples[..count], facts.quantum);
        }
        facts
    }

    /// Noise of single samples, as far as it can make neighbours equal by chance [quanta];
    /// one where no samples before the event tell.
    fn noise_quanta(&self) -> f64 {
        if self.pre_event == 0 || self.quantum <= 0.0 {
            return 1.0;
        }
        (self.pre_deviation / self.quantum).min(3.0)
    }

    /// How far the samples before the event lie from their mean at most.
    fn loudest_before(&self) -> f64 {
        reach(&self.samples[..self.pre_event], self.pre_mean)
    }
}

/// Whether samples are all one number; `None` without samples.
fn all_equal(samples: &[f64]) -> Option<bool> {
    let first = samples.first()?;
    Some(samples.iter().all(|value| same(*value, *first)))
}

/// Tells whether one value stands on end for more than half of some samples.
fn is_mostly_held(samples: &[f64]) -> bool {
    let (mut longest, mut run) = (0, 1);
    for pair in samples.windows(2) {
        run = if same(pair[0], pair[1]) { run + 1 } else { 1 };
        longest = longest.max(run);
    }
    2 * longest > samples.len()
}

/// How far samples lie from a level at most.
fn reach(samples: &[f64], level: f64) -> f64 {
    let distances = samples.iter().map(|value| (value - level).abs());
    distances.fold(0.0, f64::max)
}

/// Tells whether samples bend to and fro as noise does, bends up to `least` left aside.
fn turns_like_noise(samples: &[f64], least: f64) -> bool {
    let (mut turns, mut bends, mut last) = (0_usize, 0_usize, 0.0);
    for three in samples.windows(3) {
        let bend = three[0] - 2.0 * three[1] + three[2];
        if bend.abs() <= least {
            continue;
        }
        bends += 1;
        turns += usize::from(bend * last < 0.0);
        last = bend;
    }
    bends >= 20 && turns as f64 > TURNING_PART * bends as f64
}

/// A channel that is silent before its event, holds values longer than its spread explains, or has no samples
/// there, teaches nothing of its noise.
fn noise_unknown(facts: &SignalFacts<'_>, is_accepted: bool) -> Option<Finding> {
    let Some(count) = bias::noise_samples(facts.raw) else {
        return Some(noise_unrecorded(is_accepted));
    };
    let how = match facts.noise {
        None if all_equal(&facts.samples[..count]) == Some(true) => "are all equal",
        _ if is_mostly_held(&facts.samples[..count]) => {
            "hold one value for more than half of the time"
        }
        Some(noise) if !noise.is_explained() => {
            "repeat one value for longer than their spread explains"
        }
        _ if count < QUIET_SAMPLES => return Some(noise_short(count)),
        _ => return None,
    };
    let text =
        format!("the {count} samples before the event {how}, so the channel's noise is unknown");
    if is_accepted {
        let text = format!("{text}. A person has accepted that");
        return Some(Finding::info("noise-accepted", text));
    }
    let text = format!(
        "{text}. Held, filled and cut stretches were checked by shape and long runs alone. If a formula made the \
         signal, write `synthetic = true` in the card"
    );
    // A formula's signal is silent on both sides and smooth between; noise beside a silence shows that the silence was
    // made.
    let rest = &facts.samples[count..];
    let end = &rest[rest.len().saturating_sub(count)..];
    if is_mostly_held(end) && !turns_like_noise(rest, 2.0 * facts.quantum) {
        return Some(Finding::warning("noise-unknown", text));
    }
    let text = format!(
        "{text}. If the channel has no other noise, a pass needs the setting `accept` = noise"
    );
    Some(Finding::warning("noise-unknown", text).needing_word())
}

/// Says that nothing shows the noise. A recording that loses its quiet stretch must not gain a pass by it.
fn noise_unrecorded(is_accepted: bool) -> Finding {
    let text = "too few samples lie before -1 ms to show the channel's noise: the recorder's step alone was counted";
    if is_accepted {
        let text = format!("{text}. A person has accepted that");
        return Finding::info("noise-accepted", text);
    }
    let text = format!(
        "{text}. Export samples before contact, or name first contact with the setting `time_zero` = S. If the \
         channel has no other noise, a pass needs the setting `accept` = noise"
    );
    Finding::warning("noise-unknown", text).needing_word()
}

/// Says that a quiet stretch shows the spectrum of its noise coarsely.
fn noise_short(count: usize) -> Finding {
    let text = format!(
        "{count} samples lie before the event, and {QUIET_SAMPLES} show the spectrum of a noise: it \
         was taken coarser, and its slow part at an upper bound"
    );
    Finding::info("noise-short", text)
}

fn low_rate(raw: &Signal) -> Option<Finding> {
    let rate = raw.rate.rounded();
    (rate < LEAST_RATE_HZ).then(|| {
        let text = format!(
            "the sample rate of {rate} Hz is below {LEAST_RATE_HZ} Hz: an impact falls between two \
             samples. Use a channel at a crash recorder's rate"
        );
        Finding::blocking("low-rate", text)
    })
}

/// A channel that was interpolated is judged by its own clock.
fn interpolated_finding(clock: SlowClock) -> Finding {
    let observation = format!(
        "the channel was interpolated by straight lines from a clock of about {} Hz. {:.0} % of its \
         motion lies on lines of {} samples",
        plain(clock.rate_hz, 3),
        100.0 * clock.part,
        plain(clock.spacing, 3),
    );
    if clock.is_at_most(LEAST_RATE_HZ) {
        let text = format!(
            "{observation}. At {LEAST_RATE_HZ} Hz or less an impact falls between two samples. Use a \
             channel that was recorded at a crash recorder's rate"
        );
        return Finding::blocking("low-rate", text);
    }
    let text = format!(
        "{observation}. Nothing above {} Hz was measured. Export it on its recorder's clock, or use a \
         channel that was recorded at the full rate",
        plain(0.5 * clock.rate_hz, 3)
    );
    Finding::warning("interpolated", text)
}

/// A record of one value, or one that flickers between two, carries no motion.
fn dead_sensor(facts: &SignalFacts<'_>) -> Option<Finding> {
    let text = match facts.levels.as_slice() {
        [] => return None,
        [only] => format!("every sample is {}", in_g(*only)),
        [low, high] => {
            let changes = facts.samples.chunk_by(|a, b| same(*a, *b)).count() - 1;
            if high - low > FLICKER_G * STANDARD_GRAVITY && changes <= 4 {
                return None;
            }
            let (low, high) = (in_g(*low), in_g(*high));
            format!("the samples flicker between {low} and {high}")
        }
        _ => return None,
    };
    let message = format!("{text}: the channel measured no motion. Check sensor and cable");
    Some(Finding::blocking("dead-sensor", message))
}

/// Tells a cut top from the flat top that quantisation gives to a smooth one.
///
/// Near its top a smooth signal is a parabola. If r of its samples share one quantum q, it has
/// fallen by at most q (1 + 2s/(r−1))² after s samples beyond the run, plus one quantum of
/// rounding. A signal that has fallen further was cut: at s = 1, where nothing but the next
/// sample counts, or both at half and at the whole length of the run. Noise of a few quanta
/// lets three or four samples of a sharper top share a value by chance; q grows for them. A run
/// may take several `quanta`.
fn is_cut(facts: &SignalFacts<'_>, first: usize, length: usize, quanta: f64) -> bool {
    let end = first + length - 1;
    let level = facts.samples[first];
    let reaches = |steps: usize| {
        let ratio = 2.0 * steps as f64 / (length - 1) as f64;
        (1.0 + ratio) * (1.0 + ratio)
    };
    let chance = match length {
        ..=4 => 1.0 + 3.0 * facts.noise_quanta(),
        5..=6 => 1.0 + 1.5 * facts.noise_quanta(),
        _ => 1.0,
    };
    [true, false].into_iter().any(|before| {
        let available = if before {
            first
        } else {
            facts.samples.len() - 1 - end
        };
        let exceeds = |steps: usize, spare: f64| {
            let steps = steps.min(available);
            if steps == 0 {
                return false;
            }
            let beyond = if before { first - steps } else { end + steps };
            let fallen = (level - facts.samples[beyond]).abs() / facts.quantum;
            fallen > spare * chance * quanta * reaches(steps) + 0.5 + quanta
        };
        exceeds(1, 1.0) || (exceeds(length / 2, 1.25) && exceeds(length, 1.25))
    })
}

/// Says what the channel does before the event: bias with its standard error, and noise. `None`
/// without samples before the event.
pub fn before_event(raw: &Signal) -> Option<Finding> {
    let count = bias::pre_event_samples(raw).filter(|count| *count > 1)?;
    let (bias, _) = bias::bias(raw, super::BiasWindow::PreEvent).ok()?;
    let text = format!(
        "before the event, over {count} samples: bias {} ± {} (standard error), noise {} rms",
        in_g(bias.mean_m_s2),
        in_g(bias.standard_error_m_s2),
        in_g(bias.standard_deviation_m_s2)
    );
    Some(Finding::info("pre-event", text))
}

fn starts_inside_event(facts: &SignalFacts<'_>) -> Option<Finding> {
    let head = &facts.samples[..facts.samples.len().min(3)];
    let text = inside_event(facts, head, "first", "start")?;
    Some(Finding::blocking("starts-inside-event", text))
}

fn ends_inside_event(facts: &SignalFacts<'_>) -> Option<Finding> {
    let tail = &facts.samples[facts.samples.len().saturating_sub(3)..];
    let text = inside_event(facts, tail, "last", "end")?;
    Some(Finding::blocking("ends-inside-event", text).at(facts.raw.end_s()))
}

fn inside_event(facts: &SignalFacts<'_>, ends: &[f64], which: &str, side: &str) -> Option<String> {
    let level = median_magnitude(ends, facts.bias);
    let (shown, peak) = (in_g(level), in_g(facts.peak));
    let text = format!(
        "the {side} of the event is missing. The {which} three samples are at {shown} (median, \
         bias removed), above a tenth of the peak of {peak}. Export the whole event"
    );
    (level > EVENT_PART * facts.peak).then_some(text)
}

fn median_magnitude(samples: &[f64], bias: f64) -> f64 {
    let mut sizes: Vec<f64> = samples.iter().map(|value| (value - bias).abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    // Of two, the smaller is the one that both exceed.
    let middle = sizes.len().saturating_sub(1) / 2;
    sizes.get(middle).copied().unwrap_or(0.0)
}

/// Tells whether two samples are the same number; +0 and −0 are.
#[expect(
    clippy::float_cmp,
    reason = "samples of one converter code are the same number, and nothing else is"
)]
fn same(a: f64, b: f64) -> bool {
    a == b
}

fn in_g(acceleration: f64) -> String {
    let rounded = (acceleration / STANDARD_GRAVITY * 1e4).round() / 1e4;
    // Nothing is no less than nothing.
    format!("{:.4} g", rounded + 0.0)
}
