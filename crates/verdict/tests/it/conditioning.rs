//! Guards the order of conditioning, the bias with its standard error, and the defaults.

use crate::support::{Random, data, signal_from as signal};
use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::range::Window;
use latchgate_kernel::units::{AccelerationUnit, STANDARD_GRAVITY, SampleRate};
use latchgate_recording::error::ErrorKind;
use latchgate_recording::{Channel, Severity};
use latchgate_verdict::conditioning::bias::{bias, standard_error_of_mean};
use latchgate_verdict::conditioning::{
    self, BiasWindow, Cfc, ConditioningOptions, FilterChoice, FilterStandard, condition, peak,
    reconditioned,
};
use std::f64::consts::PI;

fn channel(rate_hz: f64, start_s: f64, values: Vec<f64>) -> Channel {
    Channel {
        name: "door y".into(),
        unit: Some(AccelerationUnit::StandardGravity),
        unit_source: "option",
        stated: latchgate_recording::Stated::default(),
        start_s,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        values,
        findings: Vec::new(),
        pulse: None,
    }
}

/// A smooth 100 g pulse of 10 ms from 20 ms on, over a bias of 0.5 g.
fn pulse(rate_hz: f64, start_s: f64) -> Channel {
    let count = (0.15 * rate_hz) as usize;
    let values = (0..count)
        .map(|n| {
            let part = (start_s + n as f64 / rate_hz - 0.02) / 0.01;
            let hump = if (0.0..=1.0).contains(&part) {
                100.0 * (PI * part).sin().powi(2)
            } else {
                0.0
            };
            hump + 0.5 + 0.1 * f64::from((n as i32 * 7) % 5 - 2)
        })
        .collect();
    channel(rate_hz, start_s, values)
}

#[track_caller]
fn check_codes(channel: &Channel, options: &ConditioningOptions, expected: &[&str]) {
    let found = condition(channel, options).unwrap().findings;
    let codes: Vec<&str> = found.iter().map(|finding| &*finding.code).collect();
    assert_eq!(codes, expected, "{found:#?}");
}

/// Rounding to the recorder's step is noise, however coarse the step is.
#[test]
fn verif_the_step_of_a_coarse_recorder_is_noise() {
    let noise = |values: Vec<f64>| {
        let options = ConditioningOptions::default();
        let done = condition(&channel(10_000.0, -0.03, values), &options).unwrap();
        (
            done.noise.step_m_s2 / STANDARD_GRAVITY,
            done.noise.deviation_m_s2 / STANDARD_GRAVITY,
        )
    };
    let of = |step_g: f64, height_g: f64| {
        let rounded = (0..1500).map(|n| {
            let part = f64::from(n - 500) / 100.0;
            let within = (0.0..=1.0).contains(&part);
            let a = if within {
                height_g * (PI * part).sin()
            } else {
                0.0
            };
            (a / step_g).round() * step_g
        });
        noise(rounded.collect())
    };
    for step_g in [0.0625, 2.0, 7.0] {
        let (step, deviation) = of(step_g, 30.0);
        assert!((step - step_g).abs() < 1e-9, "{step_g}: {step}");
        assert!(
            (deviation - step_g / 12.0_f64.sqrt()).abs() < 1e-9,
            "{deviation}"
        );
    }
    // One odd sample hides no grid, and a formula lies on none.
    let odd = |n: i32| {
        let part = f64::from(n - 500) / 100.0;
        let within = (0.0..=1.0).contains(&part);
        let a = if within {
            30.0 * (PI * part).sin()
        } else {
            0.0
        };
        if n == 1499 {
            1e-6
        } else {
            (a / 2.0).round() * 2.0
        }
    };
    let (step, _) = noise((0..1500).map(odd).collect());
    assert!((step - 2.0).abs() < 1e-9, "{step}");
}

/// What a card calls synthetic has neither noise nor doubt by rounding, conditioned again as well; the same
/// samples as a recording have both.
#[test]
fn verif_a_formula_is_not_rounded() {
    let triangle = (0..1500).map(|n| 2.0 * f64::from(15 - (n - 600_i32).abs()).max(0.0));
    let triangle = channel(10_000.0, -0.03, triangle.collect());
    let done = |synthetic| {
        let options = ConditioningOptions {
            synthetic,
            ..ConditioningOptions::default()
        };
        condition(&triangle, &options).unwrap()
    };
    let formula = done(true);
    let again = reconditioned(&formula, &ConditioningOptions::default()).unwrap();
    for formula in [formula, again] {
        assert_eq!(formula.noise.deviation_m_s2, 0.0);
        assert_eq!(formula.bias_standard_error_m_s2, 0.0);
    }
    let recorded = done(false);
    let rounding = 2.0 * STANDARD_GRAVITY / 12.0_f64.sqrt();
    assert!((recorded.noise.deviation_m_s2 - rounding).abs() < 1e-9);
    assert!((recorded.bias_standard_error_m_s2 - rounding).abs() < 1e-9);
}

#[test]
fn verif_the_defaults_remove_the_bias_and_filter_with_cfc_1000() {
    let done = condition(&pulse(10_000.0, -0.03), &ConditioningOptions::default()).unwrap();
    assert_eq!(done.filter, Some(Cfc::Cfc1000));
    assert_eq!(done.bias_samples, 291);
    let Window { from_s, until_s } = done.bias_window_s.unwrap();
    assert!((from_s + 0.03).abs() < 1e-12 && (until_s + 0.001).abs() < 1e-12);
    assert!((done.bias_m_s2 - 0.5 * STANDARD_GRAVITY).abs() < 0.02);
    assert_eq!(done.findings, []);
    let index = peak(&done.used).unwrap();
    let (value, time_s) = (done.used.samples[index], done.used.time_s(index));
    assert!((value / STANDARD_GRAVITY - 100.0).abs() < 0.3 && (time_s - 0.025).abs() < 2e-4);
    assert_eq!(
        done.raw.samples[7],
        pulse(10_000.0, -0.03).values[7] * STANDARD_GRAVITY
    );
}

#[test]
fn verif_nothing_asked_leaves_every_bit() {
    let options = ConditioningOptions {
        bias: BiasWindow::None,
        filter: FilterChoice::None,
        ..ConditioningOptions::default()
    };
    let done = condition(&pulse(10_000.0, -0.03), &options).unwrap();
    assert_eq!(done.used, done.raw);
    assert_eq!(
        (done.bias_m_s2, done.bias_samples, done.filter),
        (0.0, 0, None)
    );
}

#[test]
fn verif_doubts_are_said() {
    let default = ConditioningOptions::default();
    check_codes(
        &pulse(9_600.0, -0.03),
        &default,
        &["rate-below-default-filter"],
    );
    // 9 999.999 96 Hz is 10 kHz printed with few digits.
    check_codes(&pulse(9_999.999_96, -0.03), &default, &[]);
    let nothing_before = ["noise-unknown", "no-pre-event-data"];
    check_codes(&pulse(10_000.0, 0.0), &default, &nothing_before);
    // 46 samples are too few for the zero, and show the noise coarsely.
    let short = ["noise-short", "no-pre-event-data"];
    check_codes(&pulse(10_000.0, -0.0055), &default, &short);
    check_codes(&pulse(10_000.0, -0.006), &default, &["noise-short"]);
    let heavy = ConditioningOptions {
        filter: FilterChoice::Class(Cfc::Cfc60),
        ..default.clone()
    };
    check_codes(&pulse(10_000.0, -0.03), &heavy, &["filter-not-causal"]);
    // The peak at 25 ms lies within 10 ms of this record's start.
    check_codes(
        &pulse(10_000.0, 0.0155),
        &default,
        &["noise-unknown", "no-pre-event-data", "peak-in-end-padding"],
    );
    let mut fast = pulse(10_000.0, -0.03);
    fast.unit = Some(AccelerationUnit::MillimetrePerMillisecondSquared);
    check_codes(
        &fast,
        &default,
        &["implausible-peak", "implausible-velocity"],
    );
}

#[test]
fn verif_resampling_comes_before_the_filter() {
    let options = ConditioningOptions {
        resample_hz: Some(5_000.0),
        ..ConditioningOptions::default()
    };
    let done = condition(&pulse(12_500.0, -0.03), &options).unwrap();
    assert_eq!(done.resample_hz, Some(5_000.0));
    assert_eq!(done.used.rate.hertz(), 5_000.0);
    assert_eq!(done.filter, None);
    assert_eq!(done.findings[0].code, "rate-below-default-filter");
    let native = ConditioningOptions {
        resample_hz: Some(12_500.0),
        ..ConditioningOptions::default()
    };
    let done = condition(&pulse(12_500.0, -0.03), &native).unwrap();
    assert_eq!((done.resample_hz, done.findings), (None, vec![]));
}

#[track_caller]
fn check_error(channel: &Channel, options: &ConditioningOptions, expected: fn(&ErrorKind) -> bool) {
    let error = condition(channel, options).unwrap_err();
    assert!(expected(error.kind()), "{error}");
    assert_eq!(error.place().channel.as_deref(), Some("door y"));
}

#[test]
fn verif_what_cannot_be_done_is_an_error() {
    let default = ConditioningOptions::default();
    let record = pulse(10_000.0, -0.03);
    let mut nameless = record.clone();
    nameless.unit = None;
    check_error(&nameless, &default, |kind| {
        matches!(kind, ErrorKind::MissingUnit)
    });
    let out_of_range: fn(&ErrorKind) -> bool =
        |kind| matches!(kind, ErrorKind::Kernel(KernelError::OutOfRange { .. }));
    for value in [f64::NAN, f64::INFINITY, 1e300, -1e9] {
        let mut wild = record.clone();
        wild.values[40] = value;
        check_error(&wild, &default, out_of_range);
    }
    for (from_s, to_s) in [
        (0.0, 0.0),
        (0.1, 0.0),
        (5.0, 6.0),
        (0.000_01, 0.000_09),
        (f64::NAN, 1.0),
    ] {
        let window = ConditioningOptions {
            bias: BiasWindow::Window(Window::new(from_s, to_s)),
            ..default.clone()
        };
        check_error(&record, &window, out_of_range);
    }
    let class = ConditioningOptions {
        filter: FilterChoice::Class(Cfc::Cfc1000),
        ..default.clone()
    };
    check_error(&pulse(9_999.0, -0.03), &class, |kind| {
        matches!(kind, ErrorKind::RateTooLow { .. })
    });
    for resample_hz in [0.0, -1.0, f64::NAN] {
        let options = ConditioningOptions {
            resample_hz: Some(resample_hz),
            ..default.clone()
        };
        check_error(&record, &options, |kind| {
            matches!(kind, ErrorKind::Kernel(KernelError::NotPositive { .. }))
        });
    }
    for count in [0, 1] {
        let short = channel(10_000.0, 0.0, vec![1.0; count]);
        check_error(&short, &default, |kind| {
            matches!(kind, ErrorKind::Kernel(KernelError::TooShort { .. }))
        });
    }
}

#[test]
fn prop_conditioning_of_wild_records_never_panics() {
    for seed in 1..=300 {
        println!("seed {seed}");
        let mut random = Random::new(seed);
        let count = (random.next() % 400) as usize;
        let size = 10.0_f64.powf(random.between(-6.0, 7.0));
        let values = (0..count)
            .map(|_| (random.normal() * size * 8.0).round() / 8.0)
            .collect();
        let rate_hz = 10.0_f64.powf(random.between(0.0, 6.0));
        let record = channel(rate_hz, random.between(-0.1, 0.1), values);
        for filter in [
            FilterChoice::Default,
            FilterChoice::Class(Cfc::Cfc60),
            FilterChoice::Class(Cfc::Cfc600),
        ] {
            for filter_standard in [FilterStandard::Iso6487, FilterStandard::SaeJ211] {
                let options = ConditioningOptions {
                    filter,
                    filter_standard,
                    resample_hz: Some(rate_hz * random.between(0.05, 4.0)),
                    range_g: Some(random.between(-1.0, 100.0)),
                    ..ConditioningOptions::default()
                };
                if let Ok(done) = condition(&record, &options) {
                    assert!(done.used.samples.iter().all(|value| value.is_finite()));
                }
            }
        }
    }
}

#[track_caller]
fn check_window(window: BiasWindow, first: usize, count: usize) {
    let record = signal(10_000.0, -0.02, (0..400).map(f64::from).collect());
    let (found, _) = bias(&record, window).unwrap();
    assert_eq!(found.window, Some((first, count)));
    let expected = first as f64 + (count as f64 - 1.0) / 2.0;
    assert!((found.mean_m_s2 - expected).abs() < 1e-12);
}

/// Windows count samples by index: an end that is meant to hit a sample does.
#[test]
fn verif_bias_windows_hold_the_samples_they_name() {
    check_window(BiasWindow::PreEvent, 0, 191);
    check_window(BiasWindow::Window(Window::new(-0.02, -0.001)), 0, 191);
    check_window(BiasWindow::Window(Window::new(-0.015, -0.0051)), 50, 100);
    check_window(BiasWindow::Window(Window::new(-0.01504, -0.00506)), 50, 100);
    check_window(BiasWindow::Window(Window::new(-1.0, 1.0)), 0, 400);
}

/// A pulse of 100 g from 20 ms on over an offset; the samples from -20 ms to the end of a bias window lie
/// `part` of the peak off it by turns.
fn with_restless_window(part: f64, offset_g: f64, sign: f64, until_s: f64) -> Channel {
    let rate_hz = 10_000.0;
    let values = (0..1500).map(|n| {
        let time_s = f64::from(n) / rate_hz - 0.03;
        let pulse = (time_s - 0.02) / 0.01;
        let a = if (0.0..=1.0).contains(&pulse) {
            100.0 * (PI * pulse).sin().powi(2)
        } else if (-0.02 - 1e-9..until_s + 1e-9).contains(&time_s) {
            100.0 * part * f64::from(1 - 2 * (n % 2))
        } else {
            0.0
        };
        sign * a + offset_g
    });
    channel(rate_hz, -0.03, values.collect())
}

/// A pass needs the recording with its bias left in as well where the bias window holds more than a quarter of
/// the peak, whatever its mean; and where it holds more than a tenth or reaches past −1 ms, if its mean is beyond
/// 1 g.
#[test]
fn verif_a_doubtful_bias_needs_a_pass_without_it() {
    let options = |until_s| ConditioningOptions {
        bias: BiasWindow::Window(Window::new(-0.02, until_s)),
        filter: FilterChoice::None,
        ..ConditioningOptions::default()
    };
    let without = |channel: &Channel, until_s| {
        let done = condition(channel, &options(until_s)).unwrap();
        conditioning::without_doubtful_bias(&done).unwrap()
    };
    for (part, reaches, offsets_g, expected) in [
        (0.0, false, &[0.0, 0.5, 3.0][..], false),
        (0.09, false, &[0.0, 0.5, 3.0], false),
        (0.11, false, &[0.0, 0.99], false),
        (0.11, false, &[1.01, 3.0], true),
        (0.24, false, &[0.0, 0.99], false),
        (0.24, false, &[1.01, 3.0], true),
        (0.26, false, &[0.0, 0.5, 0.99, 1.01, 3.0], true),
        (0.7, false, &[0.0, 0.5, 0.99, 1.01, 3.0], true),
        (0.0, true, &[0.0, 0.99], false),
        (0.0, true, &[1.01, 3.0], true),
        (0.26, true, &[0.0, 0.5, 3.0], true),
    ] {
        // Of as many samples to either side, so that the offset is their mean.
        let until_s = if reaches { -0.0005 } else { -0.0051 };
        for offset_g in offsets_g {
            for (offset_sign, sign) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                let restless = with_restless_window(part, offset_sign * offset_g, sign, until_s);
                let found = without(&restless, until_s);
                assert_eq!(
                    found.is_some(),
                    expected,
                    "{part} of the peak around {offset_g} g"
                );
                if let Some(biased) = found {
                    assert_eq!((biased.bias_m_s2, biased.bias_samples), (0.0, 0));
                    assert_eq!(biased.used, biased.raw);
                }
            }
        }
    }
    // That of a second sensor counts as well, and both are left in.
    let (quiet, restless) = (
        with_restless_window(0.0, 0.5, 1.0, -0.0051),
        with_restless_window(0.3, 0.5, 1.0, -0.0051),
    );
    for (judged, second) in [(&quiet, &restless), (&restless, &quiet)] {
        let options = options(-0.0051);
        let first = condition(judged, &options).unwrap();
        let both = conditioning::with_second(first, judged, second, &options).unwrap();
        let biased = conditioning::without_doubtful_bias(&both).unwrap().unwrap();
        for sensor in biased.sensors() {
            assert_eq!(sensor.used, sensor.raw);
        }
    }
}

/// Returns the bias by its standard error, rms over 150 draws of x(k) = ρ x(k−1) + e(k), whose true
/// mean is zero.
fn bias_in_errors(correlation: f64, count: usize) -> f64 {
    let seeds = 150;
    let squares = (1..=seeds).map(|seed| {
        let mut random = Random::new(seed);
        let mut value = random.normal() / (1.0 - correlation * correlation).sqrt();
        let noise: Vec<f64> = (0..count)
            .map(|_| {
                value = correlation * value + random.normal();
                value
            })
            .collect();
        let mean = noise.iter().sum::<f64>() / count as f64;
        (mean / standard_error_of_mean(&noise)).powi(2)
    });
    (squares.sum::<f64>() / seeds as f64).sqrt()
}

/// The error errs to the safe side, up to noise that moves as slowly as
/// its window is long.
#[test]
fn val_standard_error_of_first_order_noise() {
    for (correlation, count) in [
        (0.0, 500),
        (0.5, 2000),
        (0.9, 500),
        (0.97, 500),
        (0.99, 500),
        (0.995, 500),
        // Means of neighbours stand in for the samples of a long window.
        (0.9, 20_000),
    ] {
        let found = bias_in_errors(correlation, count);
        let near = 0.45 < found && found < 1.2;
        assert!(near, "ρ {correlation}, n {count}: {found}");
    }
}

/// A zero that moves more slowly than its window is long is said.
#[test]
fn verif_a_bias_that_its_window_cannot_tell_is_said() {
    let values = (0..3000)
        .map(|index| {
            let time = f64::from(index) / 1e4 - 0.1;
            if time < 0.0 {
                0.6 * (std::f64::consts::TAU * 6.0 * time).sin()
            } else {
                30.0 * (std::f64::consts::PI * time / 0.02).sin() * f64::from(u8::from(time < 0.02))
            }
        })
        .collect();
    let done = condition(
        &channel(10_000.0, -0.1, values),
        &ConditioningOptions::default(),
    )
    .unwrap();
    let codes: Vec<&str> = done.findings.iter().map(|finding| &*finding.code).collect();
    assert!(codes.contains(&"bias-uncertain"), "{codes:?}");
}

/// A slow vibration under the window: half a period of it and more is seen.
#[test]
fn val_standard_error_of_a_vibration() {
    for frequency_hz in [12.0, 35.0] {
        let squares = (0..40).map(|phase| {
            let samples: Vec<f64> = (0..500)
                .map(|index| {
                    let turn = frequency_hz * f64::from(index) / 1e4 + f64::from(phase) / 40.0;
                    (std::f64::consts::TAU * turn).sin()
                })
                .collect();
            let mean = samples.iter().sum::<f64>() / 500.0;
            (mean / standard_error_of_mean(&samples)).powi(2)
        });
        let found = (squares.sum::<f64>() / 40.0).sqrt();
        assert!(found < 1.2, "{frequency_hz} Hz: {found}");
    }
}

#[test]
fn verif_standard_error_never_falls_below_that_of_independent_samples() {
    let mut random = Random::new(7);
    let mut value = 0.0;
    let swinging: Vec<f64> = (0..1000)
        .map(|_| {
            value = -0.6 * value + random.normal();
            value
        })
        .collect();
    let mean = swinging.iter().sum::<f64>() / 1000.0;
    let square = swinging.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    let ratio = standard_error_of_mean(&swinging) / (square / 999.0 / 1000.0).sqrt();
    assert!((1.0..1.02).contains(&ratio), "{ratio}");
    assert_eq!(standard_error_of_mean(&[4.0; 50]), 0.0);
    assert_eq!(standard_error_of_mean(&[4.0]), 0.0);
    assert_eq!(standard_error_of_mean(&[]), 0.0);
}

/// A real channel with towing vibration before contact.
#[test]
fn val_bias_of_a_real_channel() {
    let values = std::fs::read_to_string(data("recordings/nhtsa_v07292.148"))
        .unwrap()
        .lines()
        .filter_map(|line| line.split_once('\t')?.1.trim().parse().ok())
        .collect();
    let done = condition(
        &channel(12_500.0, -0.02, values),
        &ConditioningOptions::default(),
    )
    .unwrap();
    assert_eq!(done.bias_samples, 238);
    let bias_g = done.bias_m_s2 / STANDARD_GRAVITY;
    assert!((bias_g - 0.0407).abs() < 1e-4, "{bias_g}");
    let error_g = done.bias_standard_error_m_s2 / STANDARD_GRAVITY;
    assert!((0.1..0.5).contains(&error_g), "{error_g}");
    assert!(
        done.findings
            .iter()
            .all(|finding| finding.severity != Severity::Blocking)
    );
}
