//! Guards the detectors of faults: what must block, and what must not.

use crate::support::{Random, data, signal_from as signal};
use latchgate_kernel::units::{AccelerationUnit, STANDARD_GRAVITY, SampleRate};
use latchgate_recording::{Channel, Finding, Severity, Stated};
use latchgate_verdict::conditioning::quality::{before_event, findings};
use latchgate_verdict::conditioning::{ConditioningOptions, Signal, condition, neighbours};
use std::f64::consts::PI;

/// Codes that block or speak of clipping, in order.
fn faults(found: &[Finding]) -> Vec<&str> {
    found
        .iter()
        .filter(|finding| finding.severity == Severity::Blocking || finding.code == "flat-top")
        .map(|finding| &*finding.code)
        .collect()
}

#[track_caller]
fn check_faults(record: &Signal, options: &ConditioningOptions, expected: &[&str]) -> Vec<Finding> {
    let found = findings(record, options);
    assert_eq!(faults(&found), expected, "{found:#?}");
    found
}

#[track_caller]
fn check_warns(record: &Signal, code: &str, expected: bool) {
    let found = findings(record, &ConditioningOptions::default());
    assert_eq!(
        found
            .iter()
            .any(|finding| finding.code == code && finding.severity == Severity::Warning),
        expected,
        "{code} in {found:#?}"
    );
}

/// A half-sine [g] of 200 samples after 300 quiet ones, with a grid of `quantum_g`.
fn pulse(peak_g: f64, quantum_g: f64) -> Vec<f64> {
    (0..1000)
        .map(|n| {
            let phase = f64::from(n - 300) / 200.0;
            let value = if (0.0..=1.0).contains(&phase) {
                peak_g * (PI * phase).sin()
            } else {
                // Two codes of noise keep the sensor alive.
                quantum_g * f64::from((n * 7 + n * n / 3) % 3 - 1)
            };
            (value / quantum_g).round() * quantum_g * STANDARD_GRAVITY
        })
        .collect()
}

fn pulse_signal(samples: Vec<f64>) -> Signal {
    signal(10_000.0, -0.03, samples)
}

fn clipped(samples: &[f64], limit_g: f64) -> Vec<f64> {
    let limit = limit_g * STANDARD_GRAVITY;
    samples
        .iter()
        .map(|value| value.clamp(-limit, limit))
        .collect()
}

#[test]
fn verif_a_smooth_pulse_has_no_fault_and_its_clipped_copy_has() {
    let whole = pulse(180.0, 0.061);
    let default = ConditioningOptions::default();
    check_faults(&pulse_signal(whole.clone()), &default, &[]);
    for part in [0.5, 0.7, 0.9, 0.95, 0.99] {
        let cut = clipped(&whole, (180.0 * part / 0.061_f64).round() * 0.061);
        // However long it stands there, it is told once.
        let found = check_faults(&pulse_signal(cut.clone()), &default, &["clipping"]);
        let first = cut
            .iter()
            .position(|value| *value >= cut.iter().copied().fold(0.0, f64::max))
            .unwrap();
        assert_eq!(found[0].at_s, Some(-0.03 + first as f64 / 10_000.0));
        // Upside down it is the same.
        let turned = cut.iter().map(|value| -value).collect();
        check_faults(&pulse_signal(turned), &default, &["clipping"]);
    }
}

#[test]
fn verif_a_declared_range_decides_where_it_can() {
    let with_range = |range_g: f64| ConditioningOptions {
        range_g: Some(range_g),
        ..ConditioningOptions::default()
    };
    let whole = pulse(180.0, 0.061);
    check_faults(&pulse_signal(whole.clone()), &with_range(200.0), &[]);
    // 180 g is 98 % of 183.6 g.
    check_faults(
        &pulse_signal(whole.clone()),
        &with_range(183.0),
        &["clipping"],
    );
    // Three equal samples on top of a coarse pulse are chance if the sensor reads far more ...
    let mut short = whole.clone();
    let top = short[399] + 3.0 * STANDARD_GRAVITY;
    short[399..402].fill(top);
    check_faults(
        &pulse_signal(short.clone()),
        &with_range(500.0),
        &["flat-top"],
    );
    check_faults(
        &pulse_signal(short),
        &ConditioningOptions::default(),
        &["clipping"],
    );
    // ... but a long flat top is a saturated amplifier, whatever the sensor could read.
    let long = clipped(&whole, 175.0);
    check_faults(&pulse_signal(long), &with_range(500.0), &["clipping"]);
}

/// One sample at 98 % of the declared full scale is saturated, on either side and wherever it lies; the
/// channel is lost from the first of several on.
#[test]
fn verif_the_first_sample_at_the_declared_full_scale_is_clipped() {
    let options = ConditioningOptions {
        range_g: Some(100.0),
        ..ConditioningOptions::default()
    };
    let reaches = |places: &[(usize, f64)]| {
        let mut record = pulse(60.0, 0.061);
        for (place, part) in places {
            record[*place] = part * 100.0 * STANDARD_GRAVITY;
        }
        record
    };
    for place in [0, 1, 299, 300, 399, 700, 998, 999] {
        for side in [1.0, -1.0] {
            let record = reaches(&[(place, side * 0.9801)]);
            check_begins(&record, &options, "clipping", Some(place));
            let record = reaches(&[(place, side * 0.9799)]);
            check_begins(&record, &options, "clipping", None);
        }
    }
    let both_sides = reaches(&[(120, -0.99), (390, 1.0), (800, 1.2)]);
    check_begins(&both_sides, &options, "clipping", Some(120));
}

/// A channel that was cut off is lost from the first sample at the limit on, also where a single one or a
/// shorter run comes before the run that shows it.
#[test]
fn verif_clipping_begins_at_the_first_sample_at_the_limit() {
    let default = ConditioningOptions::default();
    let limit_g = (130.0_f64 / 0.061).round() * 0.061;
    let cut = clipped(&pulse(180.0, 0.061), limit_g);
    let limit = limit_g * STANDARD_GRAVITY;
    let run = cut.iter().position(|value| *value >= limit).unwrap();
    let at_limit = cut.iter().filter(|value| **value >= limit).count();
    assert!(run > 340 && at_limit > 60, "{run} {at_limit}");
    check_begins(&cut, &default, "clipping", Some(run));
    for (touched, expected) in [
        (0..1, 0),
        (150..151, 150),
        (305..306, 305),
        (310..313, 310),
        (run - 2..run - 1, run - 2),
        (run - 1..run, run - 1),
        (600..601, run),
        (999..1000, run),
    ] {
        let mut touching = cut.clone();
        touching[touched].fill(limit);
        check_begins(&touching, &default, "clipping", Some(expected));
    }
}

#[test]
fn verif_a_signal_made_by_a_formula_has_no_sensor() {
    let synthetic = ConditioningOptions {
        synthetic: true,
        range_g: Some(100.0),
        ..ConditioningOptions::default()
    };
    let cut = clipped(&pulse(180.0, 0.061), 90.0);
    let found = check_faults(&pulse_signal(cut), &synthetic, &[]);
    // What was not looked for is said.
    assert!(found.iter().any(|finding| finding.code == "synthetic"));
    let mut frozen = pulse(180.0, 0.061);
    frozen[420..520].fill(1000.0);
    check_faults(&pulse_signal(frozen), &synthetic, &[]);
    check_faults(&pulse_signal(vec![0.0; 500]), &synthetic, &[]);
}

#[test]
fn verif_a_single_sample_at_the_last_code_of_a_converter_is_clipped() {
    for (codes, expected) in [
        (-32768.0, &["clipping"][..]),
        (32767.0, &["clipping"]),
        (-2048.0, &["clipping"]),
        (32761.0, &[]),
        (-2050.0, &[]),
    ] {
        let quantum = 0.05 * STANDARD_GRAVITY;
        let mut record: Vec<f64> = pulse(40.0, 0.05);
        // A sharp but smooth enough tooth up to the code.
        for (step, part) in [0.2_f64, 0.6, 1.0, 0.5, 0.1].into_iter().enumerate() {
            record[600 + step] = f64::round(codes * part) * quantum;
        }
        check_faults(
            &pulse_signal(record),
            &ConditioningOptions::default(),
            expected,
        );
    }
}

#[test]
fn verif_a_dead_sensor_is_told_from_a_pulse() {
    let default = ConditioningOptions::default();
    check_faults(&pulse_signal(vec![0.0; 1000]), &default, &["dead-sensor"]);
    let stuck = check_faults(&pulse_signal(vec![3.0; 1000]), &default, &["dead-sensor"]);
    assert_eq!(stuck[0].at_s, None);
    let flicker = (0..1000).map(|n| f64::from(n % 2) * 0.6).collect();
    let found = findings(&pulse_signal(flicker), &default);
    assert_eq!(found[0].code, "dead-sensor");
}

#[test]
fn verif_a_frozen_stretch_blocks_from_its_first_sample() {
    let default = ConditioningOptions::default();
    let mut frozen = pulse(180.0, 0.061);
    let level = frozen[450];
    frozen[450..560].fill(level);
    let found = check_faults(&pulse_signal(frozen), &default, &["frozen"]);
    assert!((found[0].at_s.unwrap() - 0.015).abs() < 1e-12);
    // A cable that breaks inside the event may well leave zero behind.
    let mut broken = pulse(180.0, 0.061);
    broken[420..].fill(0.0);
    let found = check_faults(&pulse_signal(broken), &default, &["frozen"]);
    assert!((found[0].at_s.unwrap() - 0.012).abs() < 1e-12);
    // Zeros after the event are padding.
    let mut padded = pulse(180.0, 0.061);
    padded[700..].fill(0.0);
    check_faults(&pulse_signal(padded), &default, &[]);
}

/// A coarse converter shows its noise now and then only; a dead sensor behind it is told all the
/// same, and such noise alone is no fault.
#[test]
fn verif_a_frozen_stretch_is_told_from_chance_runs_of_coarse_noise() {
    let default = ConditioningOptions::default();
    let quantum = 0.5 * STANDARD_GRAVITY;
    let mut random = Random::new(3);
    let mut record = pulse(60.0, 0.5);
    for (n, value) in record.iter_mut().enumerate() {
        if !(300..500).contains(&n) {
            *value = (0.6 * random.normal()).round() * quantum + 0.0;
        }
    }
    let runs = record[..300].chunk_by(|a, b| a.to_bits() == b.to_bits());
    let longest = runs.map(<[f64]>::len).max().unwrap();
    assert!(
        longest >= 8,
        "chance makes a run that looks frozen: {longest}"
    );
    check_faults(&pulse_signal(record.clone()), &default, &[]);
    record[420..].fill(0.0);
    let found = check_faults(&pulse_signal(record), &default, &["frozen"]);
    assert!((found[0].at_s.unwrap() - 0.012).abs() < 1e-12);
}

#[test]
fn verif_a_record_cut_inside_the_event_blocks() {
    let default = ConditioningOptions::default();
    let whole = pulse(180.0, 0.061);
    let found = check_faults(
        &signal(10_000.0, 0.0, whole[330..].to_vec()),
        &default,
        &["starts-inside-event"],
    );
    assert!(
        found
            .iter()
            .all(|finding| finding.at_s.is_none() || finding.code != "starts-inside-event")
    );
    let cut = pulse_signal(whole[..450].to_vec());
    let found = check_faults(&cut, &default, &["ends-inside-event"]);
    let end = found
        .iter()
        .find(|finding| finding.code == "ends-inside-event")
        .unwrap();
    assert_eq!(end.at_s, Some(cut.end_s()));
}

/// The first instant [s] of the blocking findings of a code, if there are any.
fn found_at(record: &Signal, options: &ConditioningOptions, code: &str) -> Option<Option<f64>> {
    let found = findings(record, options);
    let blocks = |one: &&Finding| one.code == code && one.severity == Severity::Blocking;
    let instants = found.iter().filter(blocks).map(|one| one.at_s);
    instants.min_by(|a, b| a.partial_cmp(b).unwrap())
}

/// A finding blocks from this sample on, or there is none; so it is of the record upside down, and of one that
/// begins at another time.
#[track_caller]
fn check_begins(
    samples: &[f64],
    options: &ConditioningOptions,
    code: &str,
    expected: Option<usize>,
) {
    for sign in [1.0, -1.0] {
        for start_s in [-0.03, -0.02, 0.0] {
            let turned = samples.iter().map(|value| sign * value).collect();
            let record = signal(10_000.0, start_s, turned);
            let found = found_at(&record, options, code).map(Option::unwrap);
            let expected_s = expected.map(|first| record.time_s(first));
            assert_eq!(found, expected_s, "sign {sign}, from {start_s} s on");
        }
    }
}

/// The end of an event is missing where two of the last three samples are beyond a tenth of the peak, its
/// start where two of the first three are; samples further inside say nothing.
#[test]
fn verif_two_of_three_samples_at_either_end_tell_a_cut_event() {
    let default = ConditioningOptions::default();
    for (loud, part, is_cut) in [
        (&[0, 1][..], 0.105, true),
        (&[0, 2], 0.105, true),
        (&[1, 2], 0.105, true),
        (&[0, 1, 2], 0.105, true),
        (&[0, 1, 2], 0.095, false),
        (&[0], 0.5, false),
        (&[1], 0.5, false),
        (&[2], 0.5, false),
        (&[2, 3, 4, 5], 0.5, false),
        (&[3, 4, 5], 0.5, false),
    ] {
        for sign in [1.0, -1.0] {
            let whole: Vec<f64> = pulse(180.0, 0.061).iter().map(|a| sign * a).collect();
            for level_sign in [1.0, -1.0] {
                let level = level_sign * part * 180.0 * STANDARD_GRAVITY;
                for (code, is_end) in [("starts-inside-event", false), ("ends-inside-event", true)]
                {
                    let mut record = whole.clone();
                    for place in loud {
                        let last = record.len() - 1;
                        record[if is_end { last - place } else { *place }] = level;
                    }
                    let record = pulse_signal(record);
                    let expected = is_cut.then(|| is_end.then(|| record.end_s()));
                    let found = found_at(&record, &default, code);
                    assert_eq!(found, expected, "{code}: {loud:?} at {part}, {sign}");
                }
            }
        }
    }
}

#[test]
fn verif_a_rate_below_250_hz_is_no_crash_recording() {
    let default = ConditioningOptions::default();
    let record = pulse(180.0, 0.061);
    check_faults(
        &signal(249.9, -1.0, record.clone()),
        &default,
        &["low-rate"],
    );
    check_faults(&signal(250.0, -1.0, record.clone()), &default, &[]);
    check_faults(&signal(249.999_99, -1.0, record), &default, &[]);
}

#[test]
fn verif_warnings_are_given_where_they_belong() {
    let whole = pulse(180.0, 0.061);
    for code in [
        "spike",
        "drift",
        "zero-shift",
        "implausible-peak",
        "pre-event-not-quiet",
    ] {
        check_warns(&pulse_signal(whole.clone()), code, false);
    }
    let mut spiked = whole.clone();
    spiked[700] = 120.0 * STANDARD_GRAVITY;
    check_warns(&pulse_signal(spiked), "spike", true);
    let shifted = whole
        .iter()
        .enumerate()
        .map(|(n, value)| value + if n > 500 { 3.0 * STANDARD_GRAVITY } else { 0.0 })
        .collect();
    check_warns(&pulse_signal(shifted), "zero-shift", true);
    let drifting = whole
        .iter()
        .enumerate()
        .map(|(n, value)| value + 0.06 * n as f64)
        .collect();
    check_warns(&pulse_signal(drifting), "drift", true);
    check_warns(&pulse_signal(pulse(3.0, 0.01)), "implausible-peak", true);
    check_warns(&pulse_signal(pulse(2500.0, 0.1)), "implausible-peak", true);
    // Behind a high pass of 20 Hz the velocity comes back.
    check_warns(&pulse_signal(whole.clone()), "velocity-returns", false);
    let (mut low, keep) = (0.0, 1.0 - 2.0 * PI * 20.0 / 10_000.0);
    let coupled = whole.iter().map(|value| {
        low = keep * low + (1.0 - keep) * value;
        value - low
    });
    check_warns(&pulse_signal(coupled.collect()), "velocity-returns", true);
    // A record cut at a quiet moment soon after its peak.
    check_warns(&pulse_signal(whole.clone()), "ends-early", false);
    check_warns(&pulse_signal(whole[..520].to_vec()), "ends-early", true);
    let early = signal(10_000.0, -0.06, whole);
    check_warns(&early, "pre-event-not-quiet", true);
}

/// A trapezium of 180 g [m/s²] that stands at its top for `flat` samples.
fn trapezium(flat: i32) -> Vec<f64> {
    (0..1000)
        .map(|n| {
            let rise = f64::from(n - 300) / 29.7;
            let fall = f64::from(360 + flat - n) / 30.3;
            180.0 * STANDARD_GRAVITY * rise.min(fall).clamp(0.0, 1.0)
        })
        .collect()
}

#[test]
fn verif_a_flat_top_blocks_until_a_person_says_that_a_formula_made_it() {
    let synthetic = ConditioningOptions {
        synthetic: true,
        ..ConditioningOptions::default()
    };
    for flat in [10, 30, 200] {
        let record = pulse_signal(trapezium(flat));
        let found = check_faults(&record, &ConditioningOptions::default(), &["clipping"]);
        let clipping = found.iter().find(|one| one.code == "clipping").unwrap();
        assert!(clipping.text.contains("synthetic = true"), "{found:?}");
        check_faults(&record, &synthetic, &[]);
        // Noise that vanishes at the top says the same.
        let mut noisy = trapezium(flat);
        for (n, value) in noisy.iter_mut().enumerate() {
            if !(290..361 + flat as usize).contains(&n) {
                *value += 0.05 * (n as f64 * 2.1).sin();
            }
        }
        let noisy = pulse_signal(noisy);
        check_faults(&noisy, &ConditioningOptions::default(), &["clipping"]);
    }
}

#[test]
fn verif_a_drop_out_blocks_where_it_begins() {
    let mut lost = pulse(180.0, 0.061);
    lost[380..384].fill(0.0);
    let found = check_faults(
        &pulse_signal(lost),
        &ConditioningOptions::default(),
        &["drop-out"],
    );
    let finding = found
        .iter()
        .find(|finding| finding.code == "drop-out")
        .unwrap();
    assert!((finding.at_s.unwrap() - 0.008).abs() < 1e-12);
    // Between two pulses of a formula it may be meant: a person says so.
    let mut pause = trapezium(40);
    pause[340..344].fill(0.0);
    let found = findings(&pulse_signal(pause), &ConditioningOptions::default());
    assert!(faults(&found).contains(&"drop-out"), "{found:#?}");
}

/// Two zeros on end between loud samples of one sign are lost values, and so are three single ones; one or two
/// single zeros may be motion.
#[test]
fn verif_two_lost_samples_on_end_or_three_single_ones_block() {
    let default = ConditioningOptions::default();
    let whole = pulse(180.0, 0.061);
    let lost = |stretches: &[std::ops::Range<usize>]| {
        let mut record = whole.clone();
        for stretch in stretches {
            record[stretch.clone()].fill(0.0);
        }
        record
    };
    // Above a quarter of the peak lie the samples from 317 to 483.
    for first in [320, 350, 399, 440, 477] {
        check_begins(
            &lost(std::slice::from_ref(&(first..first + 1))),
            &default,
            "drop-out",
            None,
        );
        for length in 2..=4 {
            let record = lost(std::slice::from_ref(&(first..first + length)));
            check_begins(&record, &default, "drop-out", Some(first));
        }
    }
    let single = |places: &[usize]| {
        let stretches: Vec<_> = places.iter().map(|place| *place..place + 1).collect();
        lost(&stretches)
    };
    check_begins(&single(&[350, 420]), &default, "drop-out", None);
    check_begins(&single(&[350, 420, 460]), &default, "drop-out", Some(350));
    // A single one before two on end is lost as well.
    check_begins(
        &lost(&[350..351, 420..422]),
        &default,
        "drop-out",
        Some(350),
    );
    // Between a loud and a quiet sample, or between two signs, the motion may pass through zero.
    for stretch in [290..302, 498..503] {
        check_begins(&lost(&[stretch]), &default, "drop-out", None);
    }
    let crossing = whole.iter().enumerate();
    let crossing = crossing.map(|(n, value)| if n < 400 { *value } else { -value });
    let mut crossing: Vec<f64> = crossing.collect();
    crossing[400..402].fill(0.0);
    check_begins(&crossing, &default, "drop-out", None);
}

/// A push of `peak_g` for `width` samples at 10 kHz, with noise of about eight quanta of 10 mg.
fn lively(peak_g: f64, width: i32) -> Vec<f64> {
    let mut random = Random::new(7);
    (-300..700)
        .map(|n| {
            let phase = f64::from(n) / f64::from(width);
            let push = if (0.0..=1.0).contains(&phase) {
                peak_g * (PI * phase).sin()
            } else {
                0.0
            };
            push + 0.08 * random.normal()
        })
        .collect()
}

/// Samples [g] as a file with two decimals holds them.
fn printed(samples: impl IntoIterator<Item = f64>) -> Signal {
    let rounded = samples.into_iter().map(|g| (g * 100.0).round() / 100.0);
    pulse_signal(rounded.map(|g| g * STANDARD_GRAVITY).collect())
}

/// A sample of a level of which the last digit flickers.
fn flicker(level_g: f64, n: usize) -> f64 {
    level_g - if n * n % 3 == 1 { 0.01 } else { 0.0 }
}

#[test]
fn verif_a_top_whose_last_bit_flickers_is_seen() {
    let default = ConditioningOptions::default();
    let cut = |record: Vec<f64>, limit_g: f64| {
        let samples = record.into_iter().enumerate();
        printed(samples.map(|(n, g)| if g > limit_g { flicker(limit_g, n) } else { g }))
    };
    check_faults(&printed(lively(300.0, 10)), &default, &[]);
    check_faults(&cut(lively(300.0, 10), 40.0), &default, &["flat-top"]);
    check_faults(&cut(lively(30.0, 100), 3.0), &default, &["frozen"]);
    check_faults(&cut(lively(30.0, 600), 12.0), &default, &["frozen"]);
}

#[test]
fn verif_a_dead_cable_whose_last_bit_flickers_blocks() {
    let mut record = lively(30.0, 200);
    for (n, g) in record.iter_mut().enumerate().skip(330) {
        *g = flicker(0.01, n);
    }
    let found = check_faults(
        &printed(record),
        &ConditioningOptions::default(),
        &["frozen"],
    );
    let finding = found
        .iter()
        .find(|finding| finding.code == "frozen")
        .unwrap();
    assert!((finding.at_s.unwrap() - 0.003).abs() < 2e-4, "{finding:?}");
}

#[test]
fn verif_samples_lost_one_by_one_block() {
    let default = ConditioningOptions::default();
    let record = lively(30.0, 30).into_iter().enumerate();
    let lost = printed(record.map(|(n, g)| if n % 2 == 0 { 0.0 } else { g }));
    check_faults(&lost, &default, &["drop-out"]);
    // Ringing dips too, but not always to zero.
    let ringing = lively(30.0, 200).into_iter().enumerate();
    let ringing = printed(ringing.map(|(n, g)| g * if n % 2 == 0 { 1.0 } else { 0.02 }));
    check_faults(&ringing, &default, &[]);
}

#[test]
fn verif_a_converter_that_runs_over_is_seen() {
    let wrapped = |record: Vec<f64>, limit_g: f64| {
        printed(
            record
                .into_iter()
                .map(move |g| (g + limit_g).rem_euclid(2.0 * limit_g) - limit_g),
        )
    };
    let default = ConditioningOptions::default();
    for (width, limit_g) in [(80, 16.0), (200, 16.0), (600, 10.0)] {
        let found = check_faults(
            &wrapped(lively(30.0, width), limit_g),
            &default,
            &["wrap-around"],
        );
        assert!(found.iter().any(|finding| finding.code == "wrap-around"));
    }
    // A square wave goes nowhere beyond its ends.
    let square = (0..1000).map(|n| if n % 100 < 50 { 30.0 } else { -30.0 });
    let square: Vec<f64> = square
        .zip(lively(0.0, 1))
        .map(|(g, noise)| g + noise)
        .collect();
    check_warns(&printed(square), "wrap-around", false);
}

#[test]
fn verif_gravity_aliasing_and_sign_are_suspected() {
    let whole = pulse(180.0, 0.061);
    for code in [
        "gravity-suspected",
        "aliasing-suspected",
        "sign-suspected",
        "drop-out",
    ] {
        check_warns(&pulse_signal(whole.clone()), code, false);
    }
    let upright = whole.iter().map(|value| value - STANDARD_GRAVITY).collect();
    check_warns(&pulse_signal(upright), "gravity-suspected", true);
    let folded = whole
        .iter()
        .enumerate()
        .map(|(n, value)| if n % 2 == 0 { *value } else { -value })
        .collect();
    check_warns(&pulse_signal(folded), "aliasing-suspected", true);
    // A push one way, then a longer one the other way.
    let mut turned: Vec<f64> = whole.iter().map(|value| -value).collect();
    for (n, value) in turned.iter_mut().enumerate().take(300).skip(240) {
        *value = 90.0 * STANDARD_GRAVITY * (PI * (n as f64 - 239.5) / 60.0).sin();
    }
    check_warns(&signal(10_000.0, -0.0235, turned), "sign-suspected", true);
}

/// A channel of the pulse times `factor`, under a name.
fn channel(name: &str, factor: f64) -> Channel {
    Channel {
        name: name.into(),
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        unit_source: "header",
        start_s: -0.03,
        rate: SampleRate::from_hertz(10_000.0).unwrap(),
        values: pulse(60.0, 0.061)
            .iter()
            .map(|value| value * factor)
            .collect(),
        stated: Stated::default(),
        findings: Vec::new(),
        pulse: None,
    }
}

#[track_caller]
fn check_neighbours(channels: &[(&str, f64)], expected: &[(usize, &str)]) {
    let channels: Vec<Channel> = channels
        .iter()
        .map(|(name, factor)| channel(name, *factor))
        .collect();
    let found = neighbours::findings(&channels);
    let codes: Vec<(usize, &str)> = found
        .iter()
        .map(|(index, finding)| (*index, &*finding.code))
        .collect();
    assert_eq!(codes, expected, "{found:#?}");
    assert!(
        found
            .iter()
            .all(|(_, finding)| finding.severity == Severity::Warning)
    );
}

#[test]
fn verif_neighbours_that_disagree_are_named() {
    check_neighbours(
        &[("acc_y_g", 1.0), ("acc_y2_g", 1.01), ("acc_x_g", -1.0)],
        &[],
    );
    let opposed = [(0, "sign-suspected"), (1, "sign-suspected")];
    check_neighbours(&[("acc_y_g", 1.0), ("acc_y2_g", -1.0)], &opposed);
    let disagree = [(0, "neighbours-disagree"), (1, "neighbours-disagree")];
    check_neighbours(&[("acc_y_g", 1.0), ("acc_y2_g", 0.7)], &disagree);
    check_neighbours(&[("sill_acc_y_g", 1.0), ("door_acc_y_g", -0.5)], &opposed);
    check_neighbours(&[("sill_acc_y_g", 1.0), ("door_acc_y_g", 0.5)], &[]);
}

#[test]
fn verif_velocities_that_no_crash_gives_are_named() {
    for (factor, expected) in [(1.0, false), (0.05, true), (6.0, true)] {
        // A push to either side changes the velocity alike.
        for sign in [1.0, -1.0] {
            let channel = channel("acc_y_g", sign * factor);
            let conditioned = condition(&channel, &ConditioningOptions::default()).unwrap();
            let found = conditioned
                .findings
                .iter()
                .any(|finding| finding.code == "implausible-velocity");
            assert_eq!(found, expected, "{factor}: {:#?}", conditioned.findings);
            // By hand: half a sine adds up to 2·peak·length/π.
            let by_hand_m_s = factor * 60.0 * STANDARD_GRAVITY * 2.0 * 0.02 / PI;
            let velocity_m_s = conditioned.velocity_change_m_s;
            assert!(
                (velocity_m_s / by_hand_m_s - 1.0).abs() < 2e-3,
                "{velocity_m_s} {by_hand_m_s}"
            );
        }
    }
}

/// What a reader doubts of a clock needs a person's word, whether or not another place of the file confirms
/// the rate, and whether or not rate and length are odd by themselves.
#[test]
fn verif_a_doubt_of_the_clock_needs_a_word() {
    const DOUBT: &str = "the header states another length";
    let default = ConditioningOptions::default();
    let accepted = ConditioningOptions {
        clock_accepted: true,
        ..default.clone()
    };
    let synthetic = ConditioningOptions {
        synthetic: true,
        ..default.clone()
    };
    for (doubt, confirmed, rate_hz, words) in [
        (None, false, 10_000.0, &[][..]),
        (Some(DOUBT), false, 10_000.0, &[DOUBT]),
        (Some(DOUBT), true, 10_000.0, &[DOUBT]),
        (Some(DOUBT), false, 60_000.0, &[DOUBT, "60000 Hz"]),
        (Some(DOUBT), true, 60_000.0, &[DOUBT]),
        (None, false, 60_000.0, &["60000 Hz"]),
        (None, true, 60_000.0, &[]),
    ] {
        let mut channel = channel("acc_y_g", 1.0);
        channel.rate = SampleRate::from_hertz(rate_hz).unwrap();
        channel.stated.clock_doubt = doubt.map(String::from);
        channel.stated.clock_confirmed_by = confirmed.then(|| "another column".into());
        let of_clock = |options| -> Vec<Finding> {
            let found = condition(&channel, options).unwrap().findings;
            let is_of_clock = |one: &Finding| one.code.starts_with("clock-");
            found.into_iter().filter(is_of_clock).collect()
        };
        let (open, answered) = (of_clock(&default), of_clock(&accepted));
        let expected = usize::from(!words.is_empty());
        assert_eq!([open.len(), answered.len()], [expected; 2], "{open:?}");
        for (found, code, needs_word) in [
            (&open, "clock-implausible", true),
            (&answered, "clock-accepted", false),
        ] {
            for finding in found {
                assert_eq!((&*finding.code, finding.needs_word), (code, needs_word));
                for word in words {
                    assert!(finding.text.contains(word), "{word}: {}", finding.text);
                }
            }
        }
        assert_eq!(of_clock(&synthetic), []);
    }
}

#[test]
fn verif_what_the_channel_does_before_the_event_is_said() {
    let said = before_event(&pulse_signal(pulse(180.0, 0.061))).unwrap();
    assert_eq!((&*said.code, said.severity), ("pre-event", Severity::Info));
    assert!(
        said.text.contains("over 291 samples") && said.text.contains("standard error"),
        "{}",
        said.text
    );
    assert_eq!(before_event(&signal(10_000.0, 0.0, vec![1.0; 50])), None);
}

/// One of five smooth shapes of unit peak, `width` samples wide, at `x` samples after its start.
fn smooth(kind: u64, x: f64, width: f64, cycles: f64, phase: f64) -> f64 {
    let part = x / width;
    if kind == 2 {
        let spread = (part - 0.5) / 0.15;
        return (-0.5 * spread * spread).exp();
    }
    if !(0.0..=1.0).contains(&part) {
        return 0.0;
    }
    match kind {
        0 => (PI * part).sin(),
        1 => (PI * part).sin().powi(2),
        3 => (PI * part).sin() * (2.0 * PI * cycles * part + phase).sin(),
        _ => {
            (PI * part).sin().powi(2)
                * ((2.0 * PI * cycles * part).sin()
                    + 0.5 * (4.7 * PI * cycles * part + phase).sin())
        }
    }
}

/// A random smooth pulse, sampled at least 15 times per period, with its largest magnitude.
fn random_pulse(random: &mut Random) -> (Vec<f64>, f64) {
    let kind = random.next() % 5;
    let width = random.between(60.0, 900.0);
    let cycles = random.between(1.0, (width / 36.0).min(12.0));
    let phase = random.between(0.0, 6.0);
    let offset = random.between(0.0, 1.0);
    let peak = random.between(200.0, 9000.0)
        * if random.next().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
    let record: Vec<f64> = (0..1600)
        .map(|n| peak * smooth(kind, f64::from(n) - 300.0 - offset, width, cycles, phase))
        .collect();
    let largest = record
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    (record, largest)
}

/// Quantised to 8 to 16 bits a smooth pulse shows no clipping; cut at 50 to 95 % of its peak it
/// always does, by the same converter, if at least seven neighbours lie two noise widths beyond the
/// limit: fewer samples may be equal by chance.
#[test]
fn prop_quantised_smooth_pulses_are_not_clipped_and_cut_ones_are() {
    let default = ConditioningOptions::default();
    for seed in 1..=2000 {
        let mut random = Random::new(seed);
        let (record, largest) = random_pulse(&mut random);
        let bits = 8 + random.next() % 9;
        let quantum = largest * random.between(1.02, 1.3) / f64::from(1_u32 << (bits - 1));
        let noise = random.between(0.0, 0.8);
        let quantise = |limit: f64, random: &mut Random| -> Vec<f64> {
            record
                .iter()
                .map(|value| {
                    let noisy = value / quantum + noise * random.normal();
                    noisy.round().clamp(-limit, limit) * quantum
                })
                .collect()
        };
        let whole = findings(
            &signal(10_000.0, -0.03, quantise(f64::INFINITY, &mut random)),
            &default,
        );
        assert_eq!(
            faults(&whole),
            [""; 0],
            "seed {seed}, {bits} bits: {whole:#?}"
        );
        // Without a word of noise a cut top may be a formula's, and is only warned of.
        let limit = (random.between(0.5, 0.95) * largest / quantum).floor();
        let beyond = |value: &f64| value.abs() / quantum > limit + 2.0 * noise;
        if !record.windows(7).any(|seven| seven.iter().all(beyond)) {
            continue;
        }
        let cut = signal(10_000.0, -0.03, quantise(limit, &mut random));
        let before = &cut.samples[..290];
        let alive = before.iter().any(|value| *value != before[0]);
        let cut = findings(&cut, &default);
        assert!(
            cut.iter().any(|finding| finding.code == "clipping"
                && finding.severity == Severity::Blocking
                || !alive && finding.code == "flat-top"),
            "seed {seed}, {bits} bits, cut at {limit} of {}: {cut:#?}",
            largest / quantum
        );
    }
}

/// Reads two tab-separated columns.
fn two_columns(text: &[u8]) -> (Vec<f64>, Vec<f64>) {
    String::from_utf8_lossy(text)
        .lines()
        .filter_map(|line| line.split_once(['\t', ',']))
        .filter_map(|(time, value)| Some((time.parse::<f64>().ok()?, value.parse::<f64>().ok()?)))
        .unzip()
}

#[track_caller]
fn check_file(name: &str, unit: f64, ignored: &[&str], expected: &[&str]) -> Vec<Finding> {
    let text = std::fs::read(data(name)).unwrap();
    let (time, values) = two_columns(&text);
    let rate_hz = (values.len() - 1) as f64 / (time[time.len() - 1] - time[0]);
    let record = signal(
        (rate_hz * 1e3).round() / 1e3,
        time[0],
        values.iter().map(|value| value * unit).collect(),
    );
    let found = findings(&record, &ConditioningOptions::default());
    let faults: Vec<&str> = faults(&found)
        .into_iter()
        .filter(|code| !ignored.contains(code))
        .collect();
    assert_eq!(faults, expected, "{name}: {found:#?}");
    println!(
        "{name}: {:?}",
        found.iter().map(|f| &*f.code).collect::<Vec<_>>()
    );
    found
}

/// Real channels of one vehicle test: six healthy, one dead, one clipped.
#[test]
fn val_real_channels_are_told_apart() {
    for curve in [145, 146, 147, 148, 149, 150] {
        let name = format!("recordings/nhtsa_v07292.{curve}");
        check_file(&name, STANDARD_GRAVITY, &[], &[]);
    }
    let dead = check_file(
        "recordings/nhtsa_v07292.038",
        STANDARD_GRAVITY,
        &["ends-inside-event"],
        &["clipping"],
    );
    let clipped = check_file(
        "recordings/nhtsa_v07292.056",
        STANDARD_GRAVITY,
        &[],
        &["clipping"],
    );
    for (found, at_s) in [(dead, 0.06456), (clipped, 0.062)] {
        for finding in found.iter().filter(|finding| finding.code == "clipping") {
            assert!((finding.at_s.unwrap() - at_s).abs() < 1e-9, "{finding:?}");
        }
    }
}

/// The number of samples in which a body may stand still had overflowed at such a rate.
#[test]
fn regress_a_rate_that_no_clock_has_freezes_nothing() {
    let record = signal(1e40, 0.0, vec![9.0, 28.0]);
    let found = findings(&record, &ConditioningOptions::default());
    assert!(
        found.iter().all(|finding| finding.code != "frozen"),
        "{found:?}"
    );
}

/// Formula signals without a card: none may look clipped or frozen.
#[test]
fn val_formula_signals_are_neither_clipped_nor_frozen() {
    for stem in [
        "burst1_1000g_35ms",
        "burst2_1000g_35ms",
        "burst3_1000g_35ms",
        "hs_100g_35ms",
        "hs_30g_11ms",
        "hv_100g_20ms",
        "rec_200g_300ms",
        "saw_100g_20ms",
    ] {
        for rate in ["10k", "20k"] {
            let name = format!("reference/signals/{stem}_{rate}.csv");
            check_file(&name, 1.0, &[], &[]);
        }
    }
    check_file("reference/signals/spike_1k.csv", 1.0, &[], &[]);
    check_file("reference/signals/spike_20k.csv", 1.0, &[], &[]);
    // Within three samples of 2 ms one is well inside its event, and the other never ends.
    let ignored = ["starts-inside-event", "ends-inside-event"];
    for stem in ["hs30_500Hz", "sine90_500Hz"] {
        check_file(&format!("reference/signals/{stem}.csv"), 1.0, &ignored, &[]);
    }
}

/// Magnitudes have lost the direction; a sensor that is off by as much as its noise has not.
#[test]
fn val_a_rectified_channel_is_no_evidence() {
    let mut random = Random::new(7);
    let noise: Vec<f64> = (0..1000).map(|_| 0.1 * random.normal()).collect();
    let record = |change: &dyn Fn(f64) -> f64| {
        let samples = (0..1000)
            .map(|n| {
                let phase = (n as f64 - 500.0) / 200.0;
                let push = if (0.0..=1.0).contains(&phase) {
                    30.0 * (PI * phase).sin()
                } else {
                    0.0
                };
                (change(noise[n] + push) / 0.001).round() * 0.001 * STANDARD_GRAVITY
            })
            .collect();
        signal(10_000.0, -0.05, samples)
    };
    let options = ConditioningOptions::default();
    let fault = |change: &dyn Fn(f64) -> f64| -> Vec<String> {
        let found = findings(&record(change), &options);
        faults(&found).into_iter().map(String::from).collect()
    };
    assert_eq!(fault(&|g| g), Vec::<String>::new());
    assert_eq!(fault(&f64::abs), ["one-signed"]);
    assert_eq!(fault(&|g| -g.abs()), ["one-signed"]);
    // A converter that knows no negative value.
    assert!(fault(&|g| g.max(0.0)).contains(&"one-signed".into()));
    // Off by three times its noise, no sample is negative either.
    assert_eq!(fault(&|g| (g + 0.35).max(0.001)), Vec::<String>::new());
}
