//! Channels beside one another: lateral sensors of one body move alike, and two at one place
//! measure the same.
//!
//! What differs says that one of them is wrong, not which; so these are warnings.

use super::{BiasWindow, Signal, bias, velocity_change_m_s};
use crate::recording::{Channel, Finding, Severity, is_lateral};

/// Correlation from which two channels see the same motion, or its mirror image.
const ALIKE: f64 = 0.7;

/// Difference of velocity change at one rigid place that is worth a look [m/s].
const SAME_PLACE_VELOCITY: f64 = 0.45;

/// Part of the velocity change that may differ at one place on top.
const SAME_PLACE_PART: f64 = 0.1;

/// Most channels that are compared, each with each.
const MOST: usize = 64;

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
#[must_use]
pub fn findings(channels: &[Channel]) -> Vec<(usize, Finding)> {
    let lateral: Vec<Neighbour<'_>> = channels
        .iter()
        .enumerate()
        .filter(|(_, channel)| is_lateral(channel) && !is_refuted(channel))
        .take(MOST)
        .filter_map(|(index, channel)| neighbour(index, channel))
        .collect();
    let mut found = Vec::new();
    for (later, two) in lateral.iter().enumerate() {
        for one in &lateral[..later] {
            if let Some(finding) = compare(one, two) {
                found.push((one.index, finding(two.name)));
                found.push((two.index, finding(one.name)));
            }
        }
    }
    found
}

/// Tells whether a channel is known to be no evidence, and none against another one either.
fn is_refuted(channel: &Channel) -> bool {
    let mut findings = channel.findings.iter();
    findings.any(|finding| finding.severity == Severity::Blocking)
}

fn neighbour(index: usize, channel: &Channel) -> Option<Neighbour<'_>> {
    let mut signal = super::in_si(channel).ok()?;
    let (bias, _) = bias::bias(&signal, BiasWindow::PreEvent).ok()?;
    for sample in &mut signal.samples {
        *sample -= bias.mean_m_s2;
    }
    Some(Neighbour {
        index,
        name: &channel.name,
        place: place(channel),
        velocity: velocity_change_m_s(&signal),
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
                    "the channel runs against {other}, sample by sample (correlation \
                     {correlation:.2}): one of them has the wrong sign"
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
                    "{other} at the same place moves alike and ends at another velocity: {v1:.2} \
                     and {v2:.2} m/s; one of them is wrong"
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
