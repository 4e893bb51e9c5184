//! Faults of a raw channel: clipping, dead and frozen sensors, records cut inside the event.
//!
//! Clipping needs evidence beside the flat top, which a formula may give as well: a declared
//! range, the limit of a converter, or a channel whose own noise vanishes at the top.
//!
//! They are looked for before anything is removed or filtered, since a filter rounds off the
//! flat tops by which an overload shows. Each detector is one function; thresholds are
//! constants with their reason. What clipping took away cannot be had back, so its finding
//! blocks, and a detector in doubt leans towards blocking.
//!
//! - `lost`: stretches in which sensor, cable, recorder or converter lost the motion.

mod lost;

use super::{ConditioningOptions, Signal, bias, peak};
use crate::recording::Finding;
use crate::units::STANDARD_GRAVITY;

/// Part of the declared full scale at which a channel counts as saturated.
const SATURATED_PART: f64 = 0.98;

/// Part of the declared full scale below which a short flat top is no saturation.
const WELL_INSIDE_PART: f64 = 0.96;

/// Least number of equal samples at the extreme that can be a clipped top.
const CLIPPED_RUN: usize = 3;

/// From this many equal samples on, entered and left steeply, no declared range explains a
/// flat top away: the amplifier may have saturated before the sensor did.
const CLIPPED_BEYOND_DOUBT: usize = 5;

/// Quanta above which a level is told from noise around zero: healthy channels repeat
/// values near zero three to seven times.
const QUIET_QUANTA: f64 = 20.0;

/// Part of the largest magnitude below which an extreme is not looked at for clipping.
const EXTREME_PART: f64 = 0.25;

/// Largest part of the peak that samples before the event may reach if they shall tell noise.
const QUIET_PART: f64 = 0.25;

/// Part of the peak up to which a bend may be a rounded digit.
const ROUNDING_PART: f64 = 3e-4;

/// Part of the bends that change sides in noise; a motion of eight samples a period has as many.
const TURNING_PART: f64 = 0.25;

/// Largest relative distance of a clipped level from a power of two quanta: a bias that was
/// taken off moves it.
const CONVERTER_PART: f64 = 2e-3;

/// Part of the peak from which a sample is certainly inside the event, for drop-outs.
const LOUD_PART: f64 = 0.25;

/// Part of a signal's power beyond which what lies near half the sample rate is too much.
const ALIASED_PART: f64 = 0.5;

/// Mean before the event that speaks of gravity [g], and its largest standard error.
const GRAVITY_G: (f64, f64) = (0.9, 1.1);
const GRAVITY_ERROR_G: f64 = 0.05;

/// Part of all pushes that must add up to one side before a sign is told from them.
const ONE_SIDED_PART: f64 = 0.3;

/// Part of all pushes that the first one must have to count.
const LOBE_PART: f64 = 0.05;

/// Change of velocity below which a record has no sign [m/s].
const SIGN_VELOCITY: f64 = 0.5;

/// Least number of equal samples of a frozen run, for slow channels.
const FROZEN_RUN: usize = 8;

/// Part of the peak that counts as "inside the event" at either end of a record.
const EVENT_PART: f64 = 0.1;

/// Least sample rate of a crash recording [Hz].
const LEAST_RATE_HZ: f64 = 250.0;

/// Peaks of vehicle structures near a door [g].
const PLAUSIBLE_PEAK_G: (f64, f64) = (20.0, 2000.0);

/// Spread of samples of which only the last bit flickers [quanta], rounding of the grid included.
const BAND_QUANTA: f64 = 1.25;

/// Least number of samples of a top that flickers.
const FLICKER_RUN: usize = 6;

/// Two levels further apart than this are a signal, nearer than this a flickering last bit [g].
const FLICKER_G: f64 = 1.0;

/// Returns what is odd in a raw signal [m/s²]. `options` holds the declared range and whether
/// the signal was made by a formula.
#[must_use]
pub fn findings(raw: &Signal, options: &ConditioningOptions) -> Vec<Finding> {
    let Some((peak_value, _)) = peak(raw) else {
        return Vec::new();
    };
    let facts = SignalFacts::new(raw, peak_value.abs());
    let mut found = Vec::new();
    found.extend(low_rate(raw));
    let dead = dead_sensor(&facts);
    let is_dead = dead.is_some();
    if options.synthetic {
        found.push(Finding::info(
            "synthetic",
            "the card says that the signal was made by a formula: clipping, frozen and dead \
             sensors were not looked for",
        ));
    } else {
        found.extend(dead);
        if !is_dead {
            found.extend(clipping(&facts, options.range_g));
            found.extend(lost::frozen(&facts).or_else(|| lost::stilled(&facts)));
            found.extend(lost::drop_out(&facts).or_else(|| lost::lost_one_by_one(&facts)));
            found.extend(lost::wrap_around(&facts));
            found.extend(lost::one_signed(&facts));
        }
    }
    if facts.peak > 0.0 && !is_dead {
        found.extend(aliasing(&facts));
        found.extend(gravity(&facts));
        found.extend(sign_suspicion(&facts));
    }
    if facts.peak > 0.0 {
        found.extend(starts_inside_event(&facts));
        found.extend(ends_inside_event(&facts));
        found.extend(implausible_peak(&facts));
        found.extend(spike(&facts));
        found.extend(pre_event_not_quiet(&facts));
        found.extend(drift(&facts));
        found.extend(zero_shift(&facts));
    }
    found
}

/// What the detectors share.
struct SignalFacts<'a> {
    raw: &'a Signal,
    samples: &'a [f64],
    /// Largest magnitude [m/s²].
    peak: f64,
    /// Different values, rising.
    levels: Vec<f64>,
    /// Least difference of two values [m/s²]; 0 if there is one value only.
    quantum: f64,
    /// Number of samples before the event; 0 if they are too few to tell.
    pre_event: usize,
    /// Their mean and standard deviation [m/s²].
    pre_mean: f64,
    pre_deviation: f64,
    pre_mean_error: f64,
}

impl<'a> SignalFacts<'a> {
    fn new(raw: &'a Signal, peak: f64) -> Self {
        let samples = raw.samples.as_slice();
        let mut levels = samples.to_vec();
        levels.sort_unstable_by(f64::total_cmp);
        levels.dedup_by(|a, b| same(*a, *b));
        let quantum = levels
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold(f64::INFINITY, f64::min);
        let pre_event = bias::pre_event_samples(raw).unwrap_or(0);
        let (pre_mean, pre_deviation, pre_mean_error) = if pre_event > 1 {
            bias::bias(raw, super::BiasWindow::PreEvent).map_or((0.0, 0.0, 0.0), |(bias, _)| {
                (
                    bias.mean_m_s2,
                    bias.standard_deviation_m_s2,
                    bias.standard_error_m_s2,
                )
            })
        } else {
            (0.0, 0.0, 0.0)
        };
        Self {
            raw,
            samples,
            peak,
            quantum: if quantum.is_finite() { quantum } else { 0.0 },
            levels,
            pre_event,
            pre_mean,
            pre_deviation,
            pre_mean_error,
        }
    }

    /// Noise of single samples, as far as it can make neighbours equal by chance [quanta];
    /// one where no samples before the event tell.
    fn noise_quanta(&self) -> f64 {
        if self.pre_event == 0 || self.quantum <= 0.0 {
            return 1.0;
        }
        (self.pre_deviation / self.quantum).min(3.0)
    }

    /// Whether the samples before the event are all one number; `None` without such samples.
    fn silent_before(&self) -> Option<bool> {
        let samples = self.samples.get(..self.pre_event)?;
        let first = samples.first()?;
        Some(samples.iter().all(|value| same(*value, *first)))
    }

    /// Tells whether the channel shows noise, as one that measures does: its samples before a
    /// quiet event differ, or those of the whole record go up and down from one to the next.
    fn has_noise(&self) -> bool {
        let largest = self.samples[..self.pre_event]
            .iter()
            .fold(0.0_f64, |most, value| {
                most.max((value - self.pre_mean).abs())
            });
        if self.silent_before() == Some(false) && largest <= QUIET_PART * self.peak {
            return true;
        }
        if self.pre_event == 0 && self.trembles_at_rest() {
            return true;
        }
        let least = ROUNDING_PART * self.peak;
        let (mut turns, mut seen, mut last) = (0_usize, 0_usize, 0.0);
        for three in self.samples.windows(3) {
            let bend = three[0] - 2.0 * three[1] + three[2];
            if bend.abs() <= least {
                continue;
            }
            seen += 1;
            turns += usize::from(bend * last < 0.0);
            last = bend;
        }
        seen >= 20 && turns as f64 > TURNING_PART * seen as f64
    }

    /// Tells whether the samples up to the first loud one go up and down.
    fn trembles_at_rest(&self) -> bool {
        let loud = EVENT_PART * self.peak;
        let quiet = self.samples.iter().take_while(|value| value.abs() <= loud);
        let rest = &self.samples[..quiet.count()];
        let turns = rest
            .windows(3)
            .filter(|three| (three[1] - three[0]) * (three[2] - three[1]) < 0.0);
        turns.count() >= 3
    }

    /// Tells whether the channel stands perfectly still at rest, as a formula does and no
    /// sensor.
    fn is_still(&self) -> bool {
        self.silent_before().unwrap_or_else(|| {
            self.runs(FROZEN_RUN)
                .iter()
                .any(|(first, _)| self.samples[*first].abs() <= 0.01 * self.peak)
        })
    }

    /// Stretches of at least `least` samples that one quantum holds: first index and length.
    fn bands(&self, least: usize) -> Vec<(usize, usize)> {
        let mut bands = Vec::new();
        let (mut first, mut low, mut high) = (0, f64::INFINITY, f64::NEG_INFINITY);
        for (index, value) in self.samples.iter().enumerate() {
            let (lower, higher) = (low.min(*value), high.max(*value));
            if index > first && higher - lower > BAND_QUANTA * self.quantum {
                if index - first >= least {
                    bands.push((first, index - first));
                }
                (first, low, high) = (index, *value, *value);
            } else {
                (low, high) = (lower, higher);
            }
        }
        if self.samples.len() - first >= least {
            bands.push((first, self.samples.len() - first));
        }
        bands
    }

    /// Runs of at least `least` equal samples: first index and length.
    fn runs(&self, least: usize) -> Vec<(usize, usize)> {
        let mut runs = Vec::new();
        let mut first = 0;
        for run in self.samples.chunk_by(|a, b| same(*a, *b)) {
            if run.len() >= least {
                runs.push((first, run.len()));
            }
            first += run.len();
        }
        runs
    }
}

fn low_rate(raw: &Signal) -> Option<Finding> {
    let rate = raw.rate.rounded();
    (rate < LEAST_RATE_HZ).then(|| {
        Finding::blocking(
            "low-rate",
            format!(
                "the sample rate is {rate} Hz; below {LEAST_RATE_HZ} Hz this is no crash recording: \
                 an impact falls between its samples"
            ),
        )
    })
}

/// A record of one value, or one that flickers between two, carries no motion.
fn dead_sensor(facts: &SignalFacts<'_>) -> Option<Finding> {
    let text = match facts.levels.as_slice() {
        [] => return None,
        [only] => format!("every sample is {}", in_g(*only)),
        [low, high] => {
            let changes = facts
                .samples
                .windows(2)
                .filter(|pair| !same(pair[0], pair[1]))
                .count();
            if high - low > FLICKER_G * STANDARD_GRAVITY && changes <= 4 {
                return None;
            }
            format!(
                "the samples flicker between {} and {}",
                in_g(*low),
                in_g(*high)
            )
        }
        _ => return None,
    };
    Some(Finding::blocking(
        "dead-sensor",
        format!("{text}: the channel measured no motion; check sensor and cable"),
    ))
}

fn clipping(facts: &SignalFacts<'_>, range_g: Option<f64>) -> Vec<Finding> {
    if let Some(first) = beyond_range(facts, range_g) {
        let range = range_g.unwrap_or_default();
        return vec![
            Finding::blocking(
                "clipping",
                format!(
                    "{} at {:.5} s reaches {:.0} % of the declared full scale of {range} g; what \
                     lay beyond full scale is lost from there on",
                    in_g(facts.samples[first]),
                    facts.raw.time_s(first),
                    100.0 * SATURATED_PART
                ),
            )
            .at(facts.raw.time_s(first)),
        ];
    }
    let mut found: Vec<Finding> = [facts.levels.last(), facts.levels.first()]
        .into_iter()
        .flatten()
        .filter_map(|extreme| flat_top(facts, *extreme, range_g))
        .collect();
    found.extend(converter_limit(facts).filter(|_| found.is_empty()));
    if found.is_empty() {
        found.extend(flickering_top(facts));
    }
    found
}

/// A top within one quantum, entered or left steeply: a limit of which the last bit flickers.
fn flickering_top(facts: &SignalFacts<'_>) -> Option<Finding> {
    let bands = facts.bands(FLICKER_RUN);
    let extremes = [facts.levels.last(), facts.levels.first()];
    extremes.into_iter().flatten().find_map(|extreme| {
        if extreme.abs() <= QUIET_QUANTA * facts.quantum
            || extreme.abs() <= EXTREME_PART * facts.peak
        {
            return None;
        }
        let (first, length) = bands
            .iter()
            .copied()
            .filter(|(first, length)| {
                let top = &facts.samples[*first..first + length];
                top.iter()
                    .all(|value| (value - extreme).abs() <= BAND_QUANTA * facts.quantum)
                    && is_cut(facts, *first, *length, 2.0)
            })
            .max_by_key(|(_, length)| *length)?;
        let at_s = facts.raw.time_s(first);
        Some(
            Finding::warning(
                "flat-top",
                format!(
                    "{length} samples within one quantum of the record's extreme of {} from \
                     {at_s:.5} s on, entered or left steeply: the channel may have been \
                     saturated, with its last bit flickering; declare the range (`range_g`)",
                    in_g(*extreme)
                ),
            )
            .at(at_s),
        )
    })
}

fn beyond_range(facts: &SignalFacts<'_>, range_g: Option<f64>) -> Option<usize> {
    let limit = range_g.filter(|range| range.is_finite() && *range > 0.0)?
        * SATURATED_PART
        * STANDARD_GRAVITY;
    facts.samples.iter().position(|value| value.abs() >= limit)
}

/// Equal samples at an extreme that the signal enters or leaves more steeply than any smooth
/// top would.
fn flat_top(facts: &SignalFacts<'_>, extreme: f64, range_g: Option<f64>) -> Option<Finding> {
    if extreme.abs() <= QUIET_QUANTA * facts.quantum || extreme.abs() <= EXTREME_PART * facts.peak {
        return None;
    }
    let (first, length) = facts
        .runs(CLIPPED_RUN)
        .into_iter()
        .filter(|(first, length)| {
            same(facts.samples[*first], extreme) && is_cut(facts, *first, *length, 1.0)
        })
        .max_by_key(|(_, length)| *length)?;
    // Samples that touched the limit before the run are clipped as well.
    let onset = facts
        .samples
        .iter()
        .position(|value| same(*value, extreme))
        .unwrap_or(first);
    let at_s = facts.raw.time_s(onset);
    let seen = format!(
        "{length} equal samples of {} at the record's extreme from {:.5} s on, entered or left \
         steeply",
        in_g(extreme),
        facts.raw.time_s(first)
    );
    let inside_range =
        range_g.is_some_and(|range| extreme.abs() < WELL_INSIDE_PART * range * STANDARD_GRAVITY);
    let evidence = if facts.has_noise() {
        Some("where the channel's own noise vanishes")
    } else if near_converter_limit(extreme.abs() / facts.quantum) {
        Some("at the limit of a converter")
    } else {
        None
    };
    Some(
        match evidence {
            None => Finding::warning(
                "flat-top",
                format!(
                    "{seen}. Nothing else speaks of saturation: no range is declared, the level is no \
                     converter's limit, and the record has no noise that vanishes there. A pulse \
                     made by a formula may be meant so (`synthetic = true` in a card); of a measured \
                     one, declare the range (`range_g`)"
                ),
            ),
            Some(_) if inside_range && length < CLIPPED_BEYOND_DOUBT => Finding::warning(
                "flat-top",
                format!(
                    "{seen}; the declared full scale of {} g lies well above, so this may be chance",
                    range_g.unwrap_or_default()
                ),
            ),
            Some(evidence) => Finding::blocking(
                "clipping",
                format!("{seen}, {evidence}: the channel was saturated, and what lay beyond is lost"),
            ),
        }
        .at(at_s),
    )
}

/// Tells whether a level is that of a converter of 9 to 24 bits at its end.
fn near_converter_limit(quanta: f64) -> bool {
    (8..=23).any(|bits| {
        let full = f64::from(1_u32 << bits);
        (quanta - full).abs() <= CONVERTER_PART * full
    })
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

/// The record's extreme is the last code of a 12- to 24-bit converter: on a grid of quanta
/// through zero, ±2ⁿ or ±(2ⁿ − 1).
fn converter_limit(facts: &SignalFacts<'_>) -> Option<Finding> {
    let mut sizes: Vec<f64> = facts.levels.iter().map(|level| level.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    // Stamps of few digits blur the least difference; the grid is refined as it is climbed.
    let (mut products, mut squares, mut quantum) = (0.0, 0.0, facts.quantum);
    let mut code = 0.0;
    for size in sizes {
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
    let limit = (11..=23)
        .map(|bits| f64::from(1_u32 << bits))
        .find(|full| {
            // Two's complement ends at −2ⁿ and 2ⁿ − 1.
            same(code, *full) || same(code, full - 1.0)
        })?;
    let first = facts
        .samples
        .iter()
        .position(|value| value.abs() >= facts.peak)?;
    let at_s = facts.raw.time_s(first);
    Some(
        Finding::blocking(
            "clipping",
            format!(
                "the largest sample, {} at {at_s:.5} s, is the last code of a converter ({limit} \
                 quanta of {:.5} g): the channel was saturated",
                in_g(facts.samples[first]),
                quantum / STANDARD_GRAVITY
            ),
        )
        .at(at_s),
    )
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
        Finding::warning(
            "aliasing-suspected",
            format!(
                "most of the signal's power lies above a quarter of the sample rate of {} Hz: what \
                 lies beyond half of it may be folded into the samples as another, lower motion",
                facts.raw.rate.rounded()
            ),
        )
    })
}

/// The mean before the event is that of a sensor that stands upright.
fn gravity(facts: &SignalFacts<'_>) -> Option<Finding> {
    let mean_g = facts.pre_mean / STANDARD_GRAVITY;
    let (least, most) = GRAVITY_G;
    (facts.pre_event > 0
        && (least..=most).contains(&mean_g.abs())
        && facts.pre_mean_error <= GRAVITY_ERROR_G * STANDARD_GRAVITY)
        .then(|| {
            Finding::warning(
                "gravity-suspected",
                format!(
                    "the mean before the event is {mean_g:.4} g, as of a sensor that feels gravity: \
                     a lateral axis does not; check that the channel is not a vertical one, and \
                     that the sensor was not tilted"
                ),
            )
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
    Some(
        Finding::warning(
            "sign-suspected",
            format!(
                "the first push, at {at_s:.5} s, has the opposite sign of the velocity of \
                 {velocity:.3} m/s that the record adds up to: check the polarity of the channel \
                 (the setting `opens_when`), and that it is not a rotating or a rebounding part"
            ),
        )
        .at(at_s),
    )
}

/// Says what the channel does before the event: bias with its standard error, and noise. `None`
/// without samples before the event.
#[must_use]
pub fn before_event(raw: &Signal) -> Option<Finding> {
    let count = bias::pre_event_samples(raw).filter(|count| *count > 1)?;
    let (bias, _) = bias::bias(raw, super::BiasWindow::PreEvent).ok()?;
    Some(Finding::info(
        "pre-event",
        format!(
            "before the event, over {count} samples: bias {} ± {} (standard error), noise {} rms",
            in_g(bias.mean_m_s2),
            in_g(bias.standard_error_m_s2),
            in_g(bias.standard_deviation_m_s2)
        ),
    ))
}

fn inside_event(facts: &SignalFacts<'_>, index: usize, reach: usize) -> bool {
    facts.samples[index.saturating_sub(reach)..index]
        .iter()
        .any(|value| value.abs() > EVENT_PART * facts.peak)
}

fn starts_inside_event(facts: &SignalFacts<'_>) -> Option<Finding> {
    let head = &facts.samples[..facts.samples.len().min(3)];
    let level = median_magnitude(head);
    (level > EVENT_PART * facts.peak).then(|| {
        Finding::blocking(
            "starts-inside-event",
            format!(
                "the first three samples are at {} (median), more than a tenth of the peak of {}: \
                 what came before is missing",
                in_g(level),
                in_g(facts.peak)
            ),
        )
    })
}

fn ends_inside_event(facts: &SignalFacts<'_>) -> Option<Finding> {
    let tail = &facts.samples[facts.samples.len().saturating_sub(3)..];
    let level = median_magnitude(tail);
    (level > EVENT_PART * facts.peak).then(|| {
        Finding::blocking(
            "ends-inside-event",
            format!(
                "the last three samples are at {} (median), more than a tenth of the peak of {}: \
                 what came after is missing",
                in_g(level),
                in_g(facts.peak)
            ),
        )
        .at(facts.raw.end_s())
    })
}

fn median_magnitude(samples: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = samples.iter().map(|value| value.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    match sizes.as_slice() {
        [] => 0.0,
        [one] => *one,
        // Of two, the smaller is the one that both exceed.
        [low, _] => *low,
        more => more[more.len() / 2],
    }
}

fn implausible_peak(facts: &SignalFacts<'_>) -> Option<Finding> {
    let peak_g = facts.peak / STANDARD_GRAVITY;
    let (least, most) = PLAUSIBLE_PEAK_G;
    (!(least..=most).contains(&peak_g)).then(|| {
        Finding::warning(
            "implausible-peak",
            format!(
                "the peak is {peak_g:.4} g; channels near a door reach {least} to {most} g in a \
                 crash. Check the unit and the channel"
            ),
        )
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
    Some(
        Finding::warning(
            "spike",
            format!(
                "the sample at {at_s:.5} s jumps to {} and back within one interval: a drop-out or \
                 disturbance rather than motion",
                in_g(facts.samples[index])
            ),
        )
        .at(at_s),
    )
}

fn pre_event_not_quiet(facts: &SignalFacts<'_>) -> Option<Finding> {
    let largest = facts.samples[..facts.pre_event]
        .iter()
        .fold(0.0_f64, |most, value| {
            most.max((value - facts.pre_mean).abs())
        });
    (largest > 0.25 * facts.peak).then(|| {
        Finding::warning(
            "pre-event-not-quiet",
            format!(
                "samples before -1 ms reach {} beside their mean, more than a quarter of the peak: \
                 their mean may be no bias, or time zero may be wrong (the setting `time_zero`, the setting `bias`)",
                in_g(largest)
            ),
        )
    })
}

/// The bias moves while it is measured: a line through the pre-event samples rises by more than
/// what is left beside the line can explain.
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
    let beside: Vec<f64> = samples
        .iter()
        .enumerate()
        .map(|(index, value)| value - slope * (index as f64 - middle))
        .collect();
    let change = slope * 2.0 * middle;
    // The rise of a fitted line over its length has √12 times the error of the mean.
    let error = 12.0_f64.sqrt() * bias::standard_error_of_mean(&beside);
    (change.abs() > (5.0 * error).max(0.1 * STANDARD_GRAVITY)).then(|| {
        Finding::warning(
            "drift",
            format!(
                "the samples before the event drift by {} while the bias is taken: it may not hold \
                 for the event",
                in_g(change)
            ),
        )
    })
}

/// The mean of the tail lies away from the mean before the event.
fn zero_shift(facts: &SignalFacts<'_>) -> Option<Finding> {
    let ten_ms = (0.01 * facts.raw.rate.hertz()).round() as usize;
    let count = facts.samples.len();
    let length = ten_ms.max(count / 20);
    if facts.pre_event == 0 || length < 2 || 2 * length > count - facts.pre_event {
        return None;
    }
    let tail = &facts.samples[count - length..];
    let shift = mean(tail) - facts.pre_mean;
    let error = libm::hypot(bias::standard_error_of_mean(tail), facts.pre_mean_error);
    (shift.abs() > (5.0 * error).max(0.01 * facts.peak)).then(|| {
        Finding::warning(
            "zero-shift",
            format!(
                "the mean of the last {:.1} ms lies {} from the mean before the event: the zero may \
                 have shifted in the impact, or the body is still moving",
                1e3 * (facts.raw.end_s() - facts.raw.time_s(count - length)),
                in_g(shift)
            ),
        )
    })
}

fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len().max(1) as f64
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
    format!("{:.4} g", acceleration / STANDARD_GRAVITY)
}
