//! Channels beside one another: lateral sensors of one body move alike, and two at one place
//! measure the same.
//!
//! What differs says that one of them is wrong, not which; so these are warnings. Three axes at rest
//! feel gravity, which tells their unit.

use super::{BiasWindow, Signal, bias, velocity_m_s, without_bias};
use latchgate_kernel::units::{AccelerationUnit, STANDARD_GRAVITY, plain};
use latchgate_recording::{Channel, Finding, Severity, is_lateral};

/// Correlation from which two channels see the same motion, or its mirror image.
const ALIKE: f64 = 0.7;

/// Difference of velocity at the end of the record at one rigid place that is worth a look [m/s].
const SAME_PLACE_VELOCITY: f64 = 0.45;

/// Part of that velocity that may differ at one place on top.
const SAME_PLACE_PART: f64 = 0.1;

/// Most channels that are compared, each with each.
pub const MOST: usize = 64;

/// A lateral channel as it is compared.
struct Neighbour<'a> {
    index: usize,
    name: &'a str,
    place: String,
    signal: Signal,
    velocity: f64,
}

/// Compares the lateral channels of a recording; returns the index of a channel with each
/// finding. A channel whose reader found it to be no evidence is left aside; of many only the first 64 are compared, and
/// none of different rates or starts.
pub fn findings(channels: &[Channel]) -> Vec<(usize, Finding)> {
    let lateral: Vec<Neighbour<'_>> = channels
        .iter()
        .enumerate()
        .filter(|(_, channel)| is_lateral(channel) && !is_refuted(channel))
        .take(MOST)
        .filter_map(|(index, channel)| neighbour(index, channel))
        .collect();
    let mut findings = Vec::new();
    for (later, two) in lateral.iter().enumerate() {
        for one in &lateral[..later] {
            if let Some(finding) = compare(one, two) {
                findings.push((one.index, finding(two.name)));
                findings.push((two.index, finding(one.name)));
            }
        }
    }
    findings
}

/// Tells whether a channel is known to be no evidence, and none against another one either.
fn is_refuted(channel: &Channel) -> bool {
    let mut findings = channel.findings.iter();
    findings.any(|finding| finding.severity == Severity::Blocking)
}

fn neighbour(index: usize, channel: &Channel) -> Option<Neighbour<'_>> {
    let raw = super::in_si(channel).ok()?;
    let (bias, _) = bias::bias(&raw, BiasWindow::PreEvent).ok()?;
    let signal = without_bias(&raw, bias.mean_m_s2);
    Some(Neighbour {
        index,
        name: &channel.name,
        place: place(channel),
        velocity: velocity_m_s(&signal).last().copied()?,
        signal,
    })
}

/// Names the place of a sensor: what the file states, else its name without numbers and without
/// words for a second one.
fn place(channel: &Channel) -> String {
    if let Some(place) = &channel.stated.location {
        return place.clone();
    }
    channel
        .name
        .to_lowercase()
        .replace("redundant", "")
        .replace("secondary", "")
        .replace("backup", "")
        .chars()
        .filter(char::is_ascii_alphabetic)
        .collect()
}

/// Part by which a resting norm may differ from gravity: tilt and offset of a sound sensor.
const GRAVITY_PART: f64 = 0.1;

/// Least norm that may be gravity in another unit; below it lie the offsets of sensors set to zero.
const LEAST_NORM: f64 = 0.85;

/// Holds what the three axes of a channel's sensor read at rest against gravity. It blocks where type or
/// words say that gravity is in the samples; a crash sensor may read an offset of that size.
pub fn gravity(channels: &[Channel], index: usize) -> Option<Finding> {
    let channel = channels.get(index)?;
    let unit = channel.unit?;
    let norm = resting_norm(&axes(channels, index)?)?;
    let in_g = |unit: AccelerationUnit| norm * unit.metres_per_second_squared() / STANDARD_GRAVITY;
    let is_gravity = |unit: AccelerationUnit| (in_g(unit) - 1.0).abs() <= GRAVITY_PART;
    if is_gravity(unit) || norm < LEAST_NORM {
        return None;
    }
    let mut units = AccelerationUnit::ALL.into_iter();
    let (_, meant) = units.find(|(other, _)| is_gravity(*other))?;
    let gravity = STANDARD_GRAVITY / unit.metres_per_second_squared();
    let text = format!(
        "at rest the three axes read {} {}, but gravity is {} {}. They seem to be in {meant}. If \
         so, state the setting `unit` = {meant}",
        plain(norm, 3),
        unit.name(),
        plain(gravity, 3),
        unit.name(),
    );

    Some(match channel.stated.gravity {
        true => Finding::blocking("gravity-contradicts-unit", text),
        false => Finding::warning("gravity-contradicts-unit", text),
    })
}

/// Returns the largest magnitudes of the channels that differ from the judged one by their axis alone.
pub fn of_other_axes(channels: &[Channel], judged: &Channel) -> Vec<super::Neighbour> {
    let is_judged = |channel: &Channel| channel.name == judged.name;
    let Some(index) = channels.iter().position(is_judged) else {
        return Vec::new();
    };
    let of_axis = |channel: &Channel| {
        let axis = latchgate_recording::axis_of(channel)?.letter;
        let signal = neighbour(index, channel)?.signal;
        let peak_m_s2 = signal
            .samples
            .iter()
            .fold(0.0_f64, |most, a| most.max(a.abs()));
        Some(super::Neighbour {
            name: channel.name.clone(),
            axis,
            peak_m_s2,
        })
    };
    let neighbours = families(channels, index).map(|family| {
        let channels = family.into_iter().flatten();
        let channels = channels.filter(|channel| !is_judged(channel) && !is_refuted(channel));
        channels.filter_map(of_axis).collect::<Vec<_>>()
    });
    let mut neighbours = neighbours.filter(|neighbours| !neighbours.is_empty());
    neighbours.next().unwrap_or_default()
}

/// Finds the channels of the three axes of one sensor: those whose names differ by x, y and z alone,
/// or the three that there are.
fn axes(channels: &[Channel], index: usize) -> Option<[&Channel; 3]> {
    let mut families = families(channels, index);
    let by_name = families.find_map(|family| match family {
        [Some(x), Some(y), Some(z)] => Some([x, y, z]),
        _ => None,
    });
    by_name.or_else(|| {
        let same_clock: Vec<&Channel> = channels
            .iter()
            .filter(|other| is_of_one_clock(&channels[index], other))
            .collect();
        <[&Channel; 3]>::try_from(same_clock).ok()
    })
}

/// Tells whether two channels have one unit and one clock.
fn is_of_one_clock(one: &Channel, other: &Channel) -> bool {
    other.unit == one.unit
        && other.values.len() == one.values.len()
        && other.rate == one.rate
        && other.start_s.total_cmp(&one.start_s).is_eq()
}

/// Lists, for each letter of a channel's name that may be its axis, the channels that there are for x, y and z.
fn families(channels: &[Channel], index: usize) -> impl Iterator<Item = [Option<&Channel>; 3]> {
    let judged = &channels[index];
    let named = |name: String| {
        channels
            .iter()
            .filter(|other| is_of_one_clock(judged, other))
            .find(|other| other.name == name)
    };
    judged
        .name
        .char_indices()
        .rev()
        .filter_map(move |(place, letter)| {
            let families = [['x', 'y', 'z'], ['X', 'Y', 'Z']];
            let family = families.iter().find(|family| family.contains(&letter))?;
            let (before, after) = (&judged.name[..place], &judged.name[place + 1..]);
            Some(family.map(|axis| named(format!("{before}{axis}{after}"))))
        })
}

/// Returns the length of what three axes read at rest, in their unit: before the event, or, where
/// nothing stands before it, of most samples if these agree.
fn resting_norm(axes: &[&Channel; 3]) -> Option<f64> {
    let length = |one: [f64; 3]| one.iter().map(|value| value * value).sum::<f64>().sqrt();
    let first = super::in_si(axes[0]).ok()?;
    if let Some(count) = bias::pre_event_samples(&first) {
        return Some(length(axes.map(|axis| bias::mean(&axis.values[..count]))));
    }
    let norm = |index: usize| length(axes.map(|axis| axis.values[index]));
    let mut norms: Vec<f64> = (0..first.samples.len()).map(norm).collect();
    norms.sort_unstable_by(f64::total_cmp);
    let median = norms[norms.len() / 2];
    let near = norms
        .iter()
        .filter(|norm| (*norm - median).abs() <= GRAVITY_PART * median);
    (2 * near.count() > norms.len()).then_some(median)
}

/// What is to be said of a channel, given the name of the other one.
type Saying = Box<dyn Fn(&str) -> Finding>;

/// Returns what is to be said of a pair, given the name of the other one. Channels that do not move
/// alike, sample by sample, measure two motions: a vehicle turns and bends, and no difference is odd.
fn compare(one: &Neighbour<'_>, two: &Neighbour<'_>) -> Option<Saying> {
    let (v1, v2) = (one.velocity, two.velocity);
    let correlation = correlation(&one.signal, &two.signal)?;
    if correlation < -ALIKE {
        return Some(Box::new(move |other| {
            Finding::warning(
                "sign-suspected",
                format!(
                    "the channel moves opposite to {other}, sample by sample (correlation \
                     {correlation:.2}). One of the two has the wrong sign. Check the setting \
                     `opens_when`"
                ),
            )
        }));
    }
    let allowed = SAME_PLACE_VELOCITY + SAME_PLACE_PART * v1.abs().max(v2.abs());
    let disagree = one.place == two.place && correlation > ALIKE && (v1 - v2).abs() > allowed;
    disagree.then(|| -> Saying {
        Box::new(move |other| {
            Finding::warning(
                "neighbours-disagree",
                format!(
                    "{other} at the same place moves alike but ends at another velocity: {v1:.2} \
                     and {v2:.2} m/s. One of the two is wrong. Compare units, scales and zeros"
                ),
            )
        })
    })
}

/// Returns the correlation of two signals on one clock, over their common samples.
fn correlation(one: &Signal, two: &Signal) -> Option<f64> {
    let interval = one.rate.interval().seconds();
    let same_clock = (one.rate.hertz() / two.rate.hertz() - 1.0).abs() < 1e-6
        && (one.start_s - two.start_s).abs() < 0.01 * interval;
    if !same_clock {
        return None;
    }
    let (mut products, mut first, mut second) = (0.0, 0.0, 0.0);
    for (a, b) in one.samples.iter().zip(&two.samples) {
        products += a * b;
        first += a * a;
        second += b * b;
    }
    let size = (first * second).sqrt();
    (size > 0.0).then(|| products / size)
}
