//! Recordings that are unlike a raw one: real channels and noisy pulses are, and what is done to real channels is not.

use crate::support::{Random, columns, data, one};
use latchgate_recording::{Channel, Finding, ReadOptions, Severity};
use latchgate_verdict::conditioning::{self, ConditioningOptions};
use std::f64::consts::PI;

/// Returns a curve of NHTSA test 7292 [g], 12.5 kHz, three decimals.
fn curve(number: u32) -> Channel {
    let path = data(&format!("recordings/nhtsa_v07292.{number}"));
    let (channel, _) = one(&path, &ReadOptions::default());
    channel
}

/// Returns the findings on values printed to three decimals in place of a channel's.
fn findings(channel: &Channel, values: &[f64]) -> Vec<Finding> {
    let printed = values.iter().map(|value| (value * 1e3).round() / 1e3);
    let channel = Channel {
        values: printed.collect(),
        ..channel.clone()
    };
    conditioning::condition(&channel, &ConditioningOptions::default())
        .unwrap()
        .findings
}

/// Returns what is said of values that are unlike a raw recording.
fn told(channel: &Channel, values: &[f64]) -> Option<String> {
    let mut findings = findings(channel, values).into_iter();
    let found = findings.find(|finding| finding.code == "processed")?;
    assert!(found.needs_word, "{}", found.text);
    Some(found.text)
}

const CURVES: std::ops::RangeInclusive<u32> = 145..=150;

/// What is done to the samples of a channel.
type Change = fn(&[f64], &mut Random) -> Vec<f64>;

/// Sample at which the event is under way: 20 ms after contact.
const LATER: usize = 500;

fn rest(values: &[f64]) -> f64 {
    let quiet = &values[..200];
    quiet.iter().sum::<f64>() / 200.0
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

fn moving_mean(values: &[f64], count: usize) -> Vec<f64> {
    let at = |index: usize| {
        let from = index.saturating_sub(count / 2);
        let part = &values[from..(from + count).min(values.len())];
        part.iter().sum::<f64>() / part.len() as f64
    };
    (0..values.len()).map(at).collect()
}

fn limited(values: &[f64], low: f64, high: f64, random: &mut Random) -> Vec<f64> {
    let limited = values.iter().map(|value| value.clamp(low, high));
    limited.map(|value| value + 0.1 * random.normal()).collect()
}

/// Replaces samples farther than two standard deviations by lines.
fn repaired(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values
        .iter()
        .map(|value| (value - mean) * (value - mean))
        .sum();
    let limit = 2.0 * (squares / values.len() as f64).sqrt();
    let is_kept = |index: &usize| (values[*index] - mean).abs() <= limit;
    let kept: Vec<usize> = (0..values.len()).filter(is_kept).collect();
    let mut repaired = values.to_vec();
    for pair in kept.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        for (index, value) in repaired.iter_mut().enumerate().take(to).skip(from + 1) {
            let part = (index - from) as f64 / (to - from) as f64;
            *value = values[from] + part * (values[to] - values[from]);
        }
    }
    repaired
}

/// Each kind with a word of its message.
const KINDS: [(&str, Change, &str); 11] = [
    (
        "mean of 1 ms",
        |v, _| moving_mean(v, 13),
        "500 to 1500 Hz|spectrum vanishes",
    ),
    (
        "mean of 5 ms",
        |v, _| moving_mean(v, 63),
        "500 to 1500 Hz|spectrum vanishes",
    ),
    (
        "rectified, its mean removed",
        |v, _| {
            let values: Vec<f64> = v.iter().map(|value| value.abs()).collect();
            let zero = rest(&values);
            values.iter().map(|value| value - zero).collect()
        },
        "beyond the noise",
    ),
    (
        "minus lost from 10 g",
        |v, _| {
            v.iter()
                .map(|value| if *value < -10.0 { -value } else { *value })
                .collect()
        },
        "sign|beyond it",
    ),
    (
        "limited at half, noise on top",
        |v, random| limited(v, -0.5 * largest(v), 0.5 * largest(v), random),
        "limiter",
    ),
    (
        "limited at 10 g, noise on top",
        |v, random| limited(v, -10.0, 10.0, random),
        "limiter",
    ),
    ("repaired", |v, _| repaired(v), "sloping line"),
    (
        "gain halved later",
        |v, _| {
            let halved =
                |(index, value): (usize, &f64)| if index < LATER { *value } else { 0.5 * value };
            v.iter().enumerate().map(halved).collect()
        },
        "gain",
    ),
    (
        "Hann window",
        |v, _| {
            let last = (v.len() - 1) as f64;
            let faded = |(index, value): (usize, &f64)| {
                value * (0.5 - 0.5 * (2.0 * PI * index as f64 / last).cos())
            };
            v.iter().enumerate().map(faded).collect()
        },
        "fade",
    ),
    (
        "normalised to 10",
        |v, _| v.iter().map(|value| 10.0 * value / largest(v)).collect(),
        "exactly 10",
    ),
    (
        "normalised to 100",
        |v, _| v.iter().map(|value| 100.0 * value / largest(v)).collect(),
        "exactly 100",
    ),
];

#[test]
fn val_raw_channels_are_raw() {
    for number in CURVES {
        let channel = curve(number);
        let values = &channel.values;
        assert_eq!(told(&channel, values), None, "{number}");
        let scaled: Vec<f64> = values.iter().map(|value| 9.806_65 * value).collect();
        assert_eq!(told(&channel, &scaled), None, "{number} in m/s²");
        let late = &values[..values.len() / 2];
        assert_eq!(told(&channel, late), None, "{number}, its first half");
    }
}

/// Each kind is told of all six channels.
#[test]
fn val_processed_channels_wait_for_a_word() {
    let mut missed = Vec::new();
    for number in CURVES {
        let channel = curve(number);
        for (kind, change, words) in KINDS {
            let mut random = Random::new(u64::from(number));
            let values = change(&channel.values, &mut random);
            let text = told(&channel, &values).unwrap_or_default();
            if !words.split('|').any(|word| text.contains(word)) {
                missed.push(format!("{kind} of {number}: {text}"));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

/// A rectified channel turns at zero, which blocks.
#[test]
fn val_rectified_channels_are_blocked() {
    for number in CURVES {
        let channel = curve(number);
        let values: Vec<f64> = channel.values.iter().map(|value| value.abs()).collect();
        let mut findings = findings(&channel, &values).into_iter();
        let found = findings.find(|finding| finding.code == "one-signed");
        let severity = found.map(|finding| finding.severity);
        assert_eq!(severity, Some(Severity::Blocking), "{number}");
    }
}

/// Noisy pulses of a sled, a drop, a half-sine and bounces are no processed crash.
///
/// `LATCHGATE_SCENES=5000 cargo test -p latchgate-verdict processed::prop -- --nocapture`
#[test]
fn prop_noisy_pulses_are_raw() {
    let channel = curve(148);
    let mut random = Random::new(7);
    let mut alarms = Vec::new();
    let rounds = crate::interpolation::scenes_wanted(240);
    for round in 0..rounds {
        let hertz = [1e4, 12.5e3, 2e4][round % 3];
        let length = random.scale(0.004, 0.12);
        let peak = random.scale(15.0, 200.0);
        let noise = random.scale(0.02, 0.5);
        let coloured = random.one_in(2);
        let shape = random.below(6);
        let pulse = |time: f64| {
            let x = time / length;
            if !(0.0..1.0).contains(&x) {
                return 0.0;
            }
            match shape {
                0 => (PI * x).sin(),
                1 => 0.5 - 0.5 * (2.0 * PI * x).cos(),
                2 => (5.0 * x).min(1.0).min(5.0 - 5.0 * x),
                3 => 1.0 - (2.0 * x - 1.0).abs(),
                4 => 0.8 * (PI * x).sin() + 0.3 * (3.0 * PI * x).sin(),
                _ => 1.0 - x,
            }
        };
        let count = (0.25 * hertz) as usize;
        let (memory, step) = (random.between(0.0, 0.9), random.scale(0.003, 0.06));
        let mut last = 0.0;
        let values: Vec<f64> = (0..count)
            .map(|index| {
                let fresh = noise * random.normal();
                last = if coloured {
                    memory * last + fresh
                } else {
                    fresh
                };
                let value = peak * pulse(index as f64 / hertz - 0.05) + last;
                (value / step).round() * step
            })
            .collect();
        let rate = latchgate_kernel::units::SampleRate::from_hertz(hertz).unwrap();
        let made = Channel {
            rate,
            start_s: -0.05,
            ..channel.clone()
        };
        if let Some(text) = told(&made, &values) {
            alarms.push(format!(
                "{round}, shape {shape}, {length} s, {peak} g: {text}"
            ));
        }
    }
    println!("{} of {rounds}: {alarms:#?}", alarms.len());
    // One in a thousand may look like a change of the gain.
    assert!(1000 * alarms.len() <= rounds, "{alarms:#?}");
}

/// A person's word lifts the doubt, and what a formula made is not asked.
#[test]
fn verif_a_word_accepts_processed_samples() {
    let channel = curve(146);
    let values: Vec<f64> = channel
        .values
        .iter()
        .map(|value| 10.0 * value / largest(&channel.values))
        .collect();
    let printed = values.iter().map(|value| (value * 1e3).round() / 1e3);
    let channel = Channel {
        values: printed.collect(),
        ..channel
    };
    let codes = |options: &ConditioningOptions| {
        let conditioned = conditioning::condition(&channel, options).unwrap();
        let codes = conditioned
            .findings
            .into_iter()
            .map(|finding| finding.code.to_string());
        codes
            .filter(|code| code.starts_with("processed"))
            .collect::<Vec<_>>()
    };
    let accepted = ConditioningOptions {
        processed_accepted: true,
        ..ConditioningOptions::default()
    };
    let synthetic = ConditioningOptions {
        synthetic: true,
        ..ConditioningOptions::default()
    };
    assert_eq!(codes(&ConditioningOptions::default()), ["processed"]);
    assert_eq!(codes(&accepted), ["processed-accepted"]);
    assert_eq!(codes(&synthetic), [""; 0]);
    assert_eq!(
        columns("recordings/nhtsa_v07292.146").len(),
        channel.values.len()
    );
}
