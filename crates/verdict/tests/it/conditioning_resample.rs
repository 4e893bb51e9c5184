//! Guards resampling: what must stay, and what must vanish.

use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::SampleRate;
use latchgate_recording::error::ErrorKind;
use latchgate_verdict::conditioning::between::{self, Between};
use latchgate_verdict::conditioning::resample::{near_nyquist, resample};
use std::borrow::Cow;
use std::f64::consts::PI;

fn rate(hertz: f64) -> SampleRate {
    SampleRate::from_hertz(hertz).unwrap()
}

fn tone(rate_hz: f64, frequency_hz: f64, count: usize) -> Signal {
    Signal {
        start_s: -0.05,
        rate: rate(rate_hz),
        samples: (0..count)
            .map(|n| 100.0 * (2.0 * PI * frequency_hz * n as f64 / rate_hz + 0.3).sin())
            .collect(),
    }
}

/// Largest difference to the tone itself, away from the ends.
fn deviation(signal: &Signal, frequency_hz: f64, margin_s: f64) -> f64 {
    let margin = (margin_s * signal.rate.hertz()) as usize;
    let last = signal.samples.len() - margin;
    (margin..last)
        .map(|n| {
            let phase = 2.0 * PI * frequency_hz * n as f64 / signal.rate.hertz() + 0.3;
            (signal.samples[n] - 100.0 * phase.sin()).abs()
        })
        .fold(0.0, f64::max)
}

#[track_caller]
fn check_kept(from_hz: f64, to_hz: f64, frequency_hz: f64) {
    let lower = from_hz.min(to_hz);
    let made = resample(&tone(from_hz, frequency_hz, 6000), rate(to_hz)).unwrap();
    let worst = deviation(&made, frequency_hz, 45.0 / lower);
    assert!(worst < 2e-4, "{frequency_hz} Hz is off by {worst:e} of 100");
    assert_eq!(made.start_s, -0.05);
}

#[track_caller]
fn check_vanishes(from_hz: f64, to_hz: f64, frequency_hz: f64) {
    let made = resample(&tone(from_hz, frequency_hz, 12_000), rate(to_hz)).unwrap();
    let margin = 45;
    let worst = made.samples[margin..made.samples.len() - margin]
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    let decibels = 20.0 * (worst / 100.0).log10();
    assert!(
        decibels < -100.0,
        "{frequency_hz} Hz is left at {decibels} dB"
    );
}

#[test]
fn val_tones_in_the_pass_band_are_kept() {
    for (from_hz, to_hz) in [
        (12_500.0, 10_000.0),
        (10_000.0, 12_500.0),
        (10_000.0, 20_000.0),
        (20_000.0, 3_333.3),
        (10_000.0, 44_100.0),
    ] {
        let nyquist = 0.5 * f64::min(from_hz, to_hz);
        for part in [0.01, 0.3, 0.6, 0.79] {
            check_kept(from_hz, to_hz, part * nyquist);
        }
    }
}

/// A tone of 1040 Hz taken at 1 kHz without a filter is one of 40 Hz with its full amplitude.
#[test]
fn val_a_tone_above_the_new_nyquist_frequency_vanishes() {
    check_vanishes(10_000.0, 1_000.0, 1_040.0);
    check_vanishes(10_000.0, 1_000.0, 501.0);
    check_vanishes(10_000.0, 1_000.0, 4_900.0);
    check_vanishes(12_500.0, 10_000.0, 5_001.0);
    check_vanishes(20_000.0, 3_333.3, 1_700.0);
}

#[test]
fn verif_the_native_rate_changes_no_bit() {
    let mut signal = tone(12_500.0, 777.0, 500);
    assert_eq!(resample(&signal, rate(12_500.0)).unwrap(), signal);
    signal.rate = rate(1.0 / 8e-5);
    assert_eq!(resample(&signal, rate(12_500.0)).unwrap(), signal);
}

#[test]
fn verif_a_constant_and_shared_instants_stay() {
    for to_hz in [1_000.0, 7_777.0, 10_000.0, 31_000.0] {
        let flat = Signal {
            start_s: 0.0,
            rate: rate(12_500.0),
            samples: vec![-3.7; 900],
        };
        for value in resample(&flat, rate(to_hz)).unwrap().samples {
            assert!((value + 3.7).abs() < 1e-14, "{value}");
        }
    }
    // Going up by a whole number keeps the old samples bit for bit.
    let signal = tone(10_000.0, 4_000.0, 300);
    let made = resample(&signal, rate(30_000.0)).unwrap();
    assert_eq!(made.samples.len(), 898);
    for (index, value) in signal.samples.iter().enumerate() {
        assert_eq!(made.samples[3 * index], *value);
    }
}

/// A pulse keeps the velocity it carries.
#[test]
fn verif_the_velocity_of_a_pulse_is_kept() {
    let samples: Vec<f64> = (0..3000)
        .map(|n| {
            let part = (f64::from(n) - 1000.0) / 400.0;
            if (0.0..=1.0).contains(&part) {
                300.0 * (PI * part).sin().powi(2)
            } else {
                0.0
            }
        })
        .collect();
    let signal = Signal {
        start_s: 0.0,
        rate: rate(12_500.0),
        samples,
    };
    let velocity = |signal: &Signal| signal.samples.iter().sum::<f64>() / signal.rate.hertz();
    for to_hz in [2_000.0, 10_000.0, 17_000.0] {
        let made = resample(&signal, rate(to_hz)).unwrap();
        assert!((velocity(&made) / velocity(&signal) - 1.0).abs() < 1e-7);
        assert!(made.end_s() <= signal.end_s() + 1e-9);
        assert!(made.end_s() > signal.end_s() - 1.0 / to_hz);
    }
}

#[track_caller]
fn check_refused(signal: &Signal, to_hz: f64, expected: fn(&ErrorKind) -> bool) {
    let error = resample(signal, rate(to_hz)).unwrap_err();
    assert!(expected(error.kind()), "{error}");
}

#[test]
fn verif_rates_that_cannot_be_made_are_refused() {
    let signal = tone(10_000.0, 100.0, 2_000);
    let out_of_range =
        |kind: &ErrorKind| matches!(kind, ErrorKind::Kernel(KernelError::OutOfRange { .. }));
    check_refused(&signal, 5e7, out_of_range);
    check_refused(&signal, 1e300, out_of_range);
    check_refused(&signal, 249.9, out_of_range);
    check_refused(&signal, 1e-300, out_of_range);
    check_refused(&tone(1e9, 100.0, 10), 300.0, |kind| {
        matches!(kind, ErrorKind::Kernel(KernelError::TooShort { .. }))
    });
}

#[test]
fn verif_short_records_are_resampled_without_panic() {
    for count in 0..40 {
        let signal = tone(10_000.0, 300.0, count);
        for to_hz in [5_000.0, 9_000.0, 25_000.0] {
            match resample(&signal, rate(to_hz)) {
                Ok(made) => assert!(made.samples.iter().all(|value| value.is_finite())),
                Err(error) => assert!(matches!(
                    error.kind(),
                    ErrorKind::Kernel(KernelError::TooShort { .. })
                )),
            }
        }
        let reading = between::read(Cow::Borrowed(&signal), Between::BandLimited).unwrap();
        let of_each = (0..count.saturating_sub(1)).map(|index| reading.at(index, 0.5));
        assert!(of_each.into_iter().all(|value| value.unwrap().is_finite()));
    }
}

/// Smooth motion leaves next to nothing near the Nyquist frequency; a jump at least the half of itself
/// that its unknown place within an interval may add, a corner at least half of its twelfth: twice the trace covers it.
#[test]
fn verif_corners_and_jumps_show_near_the_nyquist_frequency() {
    let magnitudes = |samples: Vec<f64>| -> f64 {
        let signal = Signal {
            start_s: 0.0,
            rate: rate(10_000.0),
            samples,
        };
        near_nyquist(&signal).iter().map(|a| a.abs()).sum()
    };
    for (frequency_hz, low, high) in [
        (500.0, 0.0, 2e-5),
        (2_000.0, 0.0, 2e-5),
        (3_500.0, 0.0, 2e-5),
        (4_600.0, 0.99, 1.01),
    ] {
        let left = near_nyquist(&tone(10_000.0, frequency_hz, 1_000));
        let largest = |most: f64, a: &f64| most.max(a.abs());
        let middle = left[100..900].iter().fold(0.0, largest) / 100.0;
        assert!(
            (low..=high).contains(&middle),
            "{frequency_hz} Hz leaves {middle}"
        );
    }
    for part in [0.0, 0.25, 0.5, 0.75] {
        let after = |index: i32| (f64::from(index) - 200.0 - part).max(0.0);
        let jump = magnitudes((0..400).map(|k| after(k).min(1.0).ceil()).collect());
        assert!((0.5..2.0).contains(&jump), "a jump leaves {jump}");
        let corner = magnitudes((0..400).map(|k| after(k).min(100.0)).collect());
        // Two of them.
        assert!(
            (1.0 / 12.0..2.0).contains(&corner),
            "corners leave {corner}"
        );
    }
}
