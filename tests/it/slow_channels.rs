//! Guards what tells a slow channel on a fast raster: straight lines between the samples of its own
//! clock, or curves that leave the high frequencies empty.

use crate::support::{Folder, Random, data, latchgate};
use latchgate::pipeline::Severity;
use latchgate_kernel::units::{AccelerationUnit, SampleRate};
use latchgate_recording::{Channel, Finding, Limits, ReadOptions, Selection, Source, read};
use latchgate_recording::{Stated, card::Card};
use latchgate_verdict::conditioning::{ConditioningOptions, condition};
use std::f64::consts::{PI, TAU};

/// A push that rings [g], as a body in a crash does, and what its sensor adds.
fn motion(t: f64, random: &mut Random) -> f64 {
    let push = match t {
        0.0..0.06 => -25.0 * (PI * t / 0.06).sin().powi(2),
        _ => 0.0,
    };
    let ring = |amplitude: f64, hertz: f64, decay: f64| match t > 0.002 {
        true => amplitude * (-t / decay).exp() * (TAU * hertz * t).sin(),
        false => 0.0,
    };
    push + ring(12.0, 45.0, 0.03) + ring(9.0, 230.0, 0.02) + 0.05 * random.normal()
}

fn channel(rate_hz: f64, start_s: f64, values: Vec<f64>) -> Channel {
    Channel {
        name: "acc_y".into(),
        unit: Some(AccelerationUnit::StandardGravity),
        unit_source: "option",
        start_s,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        values,
        stated: Stated::default(),
        findings: Vec::new(),
        pulse: None,
    }
}

fn findings(channel: &Channel) -> Vec<Finding> {
    let options = ConditioningOptions::default();
    condition(channel, &options).unwrap().findings
}

/// Samples of a clock of so many hertz, brought to another one by straight lines.
fn by_lines(slow_hz: f64, rate_hz: f64) -> Vec<f64> {
    let mut random = Random::new(slow_hz as u64);
    let slow: Vec<f64> = (0..)
        .map(|index| f64::from(index) / slow_hz - 0.1003)
        .take_while(|t| *t < 0.22)
        .map(|t| (motion(t, &mut random) * 100.0).round() / 100.0)
        .collect();
    let count = (0.3 * rate_hz) as usize;
    let at = |index: usize| {
        let place = (index as f64 / rate_hz + 0.0003) * slow_hz;
        let before = place as usize;
        slow[before] + (slow[before + 1] - slow[before]) * place.fract()
    };
    (0..count).map(at).collect()
}

fn printed(values: &[f64], decimals: usize) -> Vec<f64> {
    let text = |value: &f64| format!("{value:.decimals$}").parse().unwrap();
    values.iter().map(text).collect()
}

/// However a slow channel is written, its own clock is told within 2 %; at 250 Hz and below it blocks,
/// above it no filter is taken that its clock does not carry.
#[test]
fn verif_lines_between_the_samples_of_a_slow_clock_are_told() {
    for (slow_hz, rate_hz) in [
        (100.0, 2_000.0),
        (100.0, 10_000.0),
        (200.0, 12_500.0),
        (250.0, 10_000.0),
        (250.0, 20_000.0),
        (333.0, 10_000.0),
        (500.0, 12_500.0),
        (1_000.0, 10_000.0),
        (2_000.0, 20_000.0),
    ] {
        let exact = by_lines(slow_hz, rate_hz);
        let scaled: Vec<f64> = printed(&exact, 3)
            .iter()
            .map(|v| v * 9.806_65 + 3.3)
            .collect();
        let single = exact.iter().map(|value| f64::from(*value as f32)).collect();
        let mut random = Random::new(7);
        // Written at stamps that tremble by 1 % of the interval and are taken for uniform.
        let trembling: Vec<f64> = exact
            .windows(2)
            .map(|pair| pair[0] + 0.01 * random.unit() * (pair[1] - pair[0]))
            .collect();
        for (spelling, values) in [
            ("2 decimals", printed(&exact, 2)),
            ("3 decimals", printed(&exact, 3)),
            ("6 decimals", printed(&exact, 6)),
            ("all digits", exact.clone()),
            ("gain and offset", scaled),
            ("32 bits", single),
            ("trembling stamps", trembling),
        ] {
            let what = format!("{slow_hz} Hz on {rate_hz} Hz, {spelling}");
            let done = condition(
                &channel(rate_hz, -0.1, values),
                &ConditioningOptions::default(),
            );
            let done = done.unwrap();
            let clock = done
                .slow_clock
                .unwrap_or_else(|| panic!("{what}: not told"));
            assert!(
                (clock.rate_hz / slow_hz - 1.0).abs() < 0.02,
                "{what}: {clock:?}"
            );
            let code = if slow_hz <= 250.0 {
                "low-rate"
            } else {
                "interpolated"
            };
            let finding = done.findings.iter().find(|one| one.code == code);
            let finding = finding.unwrap_or_else(|| panic!("{what}: {:?}", done.findings));
            let blocks = finding.severity == Severity::Blocking;
            assert_eq!(blocks, slow_hz <= 250.0, "{what}");
            assert_eq!(done.filter, None, "{what}");
            let codes = done.findings.iter().map(|one| &*one.code);
            assert!(
                codes
                    .clone()
                    .any(|code| code == "rate-below-default-filter")
            );
        }
    }
}

/// A stretch of the event alone is enough.
#[test]
fn verif_a_stretch_that_was_interpolated_is_told() {
    let mut random = Random::new(3);
    let mut values: Vec<f64> = (0..3000)
        .map(|index| motion(f64::from(index) / 1e4 - 0.1, &mut random))
        .collect();
    values[1000..1400].copy_from_slice(&by_lines(200.0, 1e4)[1000..1400]);
    let found = findings(&channel(1e4, -0.1, printed(&values, 3)));
    let blocking = found.iter().find(|one| one.code == "low-rate");
    assert_eq!(blocking.unwrap().severity, Severity::Blocking, "{found:?}");
}

/// What a formula draws straight is meant so, and the card says it.
#[test]
fn verif_a_formula_may_be_straight() {
    let trapezoid = |t: f64| 20.3 * (t / 0.0217).min((0.08 - t) / 0.0237).clamp(0.0, 1.0);
    let values = (0..3000).map(|index| trapezoid(f64::from(index) / 1e4 - 0.1));
    let straight = channel(1e4, -0.1, values.collect());
    let synthetic = ConditioningOptions {
        synthetic: true,
        ..ConditioningOptions::default()
    };
    let done = condition(&straight, &synthetic).unwrap();
    assert_eq!(done.slow_clock, None);
    assert!(
        condition(&straight, &ConditioningOptions::default())
            .unwrap()
            .slow_clock
            .is_some()
    );
}

/// Smooth pulses bend everywhere, however few digits they have.
#[test]
fn verif_smooth_pulses_are_none_of_a_slow_clock() {
    for decimals in 0..5 {
        for (peak, length) in [(30.0, 0.011), (30.0, 0.04), (30.0, 0.06), (60.0, 0.1)] {
            for power in [1, 2] {
                let value = |t: f64| match t >= 0.0 && t <= length {
                    true => peak * (PI * t / length).sin().powi(power),
                    false => 0.0,
                };
                let values = (0..3000).map(|index| value(f64::from(index) / 1e4 - 0.1));
                let values = printed(&values.collect::<Vec<f64>>(), decimals);
                let done = condition(&channel(1e4, -0.1, values), &ConditioningOptions::default());
                let clock = done.unwrap().slow_clock;
                assert_eq!(clock, None, "{peak} g, {length} s, {decimals} decimals");
            }
        }
    }
}

fn curve(number: u32) -> Channel {
    let path = data(&format!("recordings/nhtsa_v07292.{number:03}"));
    let options = ReadOptions {
        unit: Some(AccelerationUnit::StandardGravity),
        ..ReadOptions::default()
    };
    let read = read(
        &Source::File(path),
        &options,
        Selection::Lateral,
        &Limits::default(),
    );
    read.unwrap().channels.remove(0)
}

/// Of the channels of a real crash test none is told for slow, and none for empty at high frequencies.
#[test]
fn val_real_channels_are_as_fast_as_their_raster() {
    for number in 145..=150 {
        let found = findings(&curve(number));
        let speaks =
            |one: &&Finding| ["interpolated", "low-rate", "band-empty"].contains(&&*one.code);
        assert_eq!(found.iter().find(speaks), None, "{number}");
    }
}

/// Passes through the values of a slow clock by a natural cubic spline, at every `step`th of an interval.
fn by_spline(values: &[f64], step: usize) -> Vec<f64> {
    let count = values.len();
    let (mut bends, mut weights) = (vec![0.0; count], vec![0.0; count]);
    for index in 1..count - 1 {
        let pivot = 0.5 * bends[index - 1] + 2.0;
        bends[index] = -0.5 / pivot;
        let second = values[index + 1] - 2.0 * values[index] + values[index - 1];
        weights[index] = (3.0 * second - 0.5 * weights[index - 1]) / pivot;
    }
    for index in (0..count - 1).rev() {
        bends[index] = bends[index] * bends[index + 1] + weights[index];
    }
    let at = |place: f64| {
        let (index, right) = (place as usize, place.fract());
        let left = 1.0 - right;
        let cubic = |part: f64| part * part * part - part;
        left * values[index]
            + right * values[index + 1]
            + (cubic(left) * bends[index] + cubic(right) * bends[index + 1]) / 6.0
    };
    (0..(count - 1) * step)
        .map(|index| at(index as f64 / step as f64))
        .collect()
}

/// Curves through the samples of a slow clock leave nothing above 500 Hz. Where file or card claim
/// CFC 1000, or no filter, less is missing until it is told; what is told as filtered is told once.
#[test]
fn verif_channels_that_are_empty_at_high_frequencies_are_told() {
    let mut random = Random::new(11);
    let mut slow = |hertz: f64| -> Vec<f64> {
        let count = (0.32 * hertz) as i32;
        let at = |index: i32| motion(f64::from(index) / hertz - 0.1, &mut random);
        (0..count).map(at).collect()
    };
    let (hundred, five_hundred) = (by_spline(&slow(100.0), 100), by_spline(&slow(500.0), 20));
    let mut whole = slow(10_000.0);
    for (index, value) in whole.iter_mut().enumerate().skip(1020) {
        let t = index as f64 / 1e4 - 0.1;
        *value += 6.0 * (-t / 0.01).exp() * (TAU * 800.0 * t).sin();
    }
    let wide = |change: fn(&mut Stated)| {
        let mut stated = Stated::default();
        change(&mut stated);
        stated
    };
    let silent = || wide(|_| {});
    let class = || wide(|stated| stated.filter_class = Some("1000".into()));
    let corner = || wide(|stated| stated.prefilter_hz = Some(1650.0));
    let unfiltered = || wide(|stated| stated.unfiltered = true);
    for (what, values, stated, told) in [
        ("100 Hz, nothing claimed", &hundred, silent(), true),
        ("100 Hz, CFC 1000", &hundred, class(), true),
        ("500 Hz, nothing claimed", &five_hundred, silent(), false),
        ("500 Hz, CFC 1000", &five_hundred, class(), true),
        ("500 Hz, filter at 1650 Hz", &five_hundred, corner(), true),
        ("500 Hz, unfiltered", &five_hundred, unfiltered(), true),
        ("as recorded, CFC 1000", &whole, class(), false),
        ("as recorded, unfiltered", &whole, unfiltered(), false),
    ] {
        let mut channel = channel(10_000.0, -0.1, printed(values, 4));
        channel.stated = stated;
        let found = findings(&channel);
        let empty = found.iter().find(|one| one.code == "band-empty");
        assert_eq!(empty.is_some(), told, "{what}: {found:?}");
        assert!(empty.is_none_or(|one| one.severity == Severity::Warning));
    }
    // A card claims it in words; a channel whose name says CFC 60 claims the contrary.
    for notes in ["CFC 1000", "unfiltered", "Rohdaten, ohne Filter"] {
        let card = Card::from_toml(&format!("notes = \"{notes}\"")).unwrap();
        assert!(card.says_wide_band(), "{notes}");
    }
    assert!(
        !Card::from_toml("notes = \"CFC 60\"")
            .unwrap()
            .says_wide_band()
    );
    let folder = Folder::new("band-empty");
    for (name, told) in [
        ("acc_y_cfc60 (g)", false),
        ("acc_y filtered (g)", false),
        ("acc_y unfiltered (g)", true),
        ("acc_y_cfc1000 (g)", true),
        ("acc_y ungefiltert (g)", true),
        ("acc_y (g)", false),
    ] {
        let rows: String = five_hundred
            .iter()
            .enumerate()
            .map(|(index, value)| format!("{:.4},{value:.4}\n", index as f64 / 1e4 - 0.1))
            .collect();
        let path = folder.write("a.csv", format!("time_s,{name}\n{rows}"));
        let listed = latchgate(&["inspect", &path, "--format", "json"]);
        assert_eq!(listed.out.contains("band-empty"), told, "{name}");
    }
}
