//! Two in-plane axes: the lever under −m·L (a_t cos φ − a_r sin φ).
//!
//! Peaks are those of a Taylor series at 200 bits, from knot to knot of the two trapezoids.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, Member, SensorView};
use latchgate_kernel::replay::{self, Method, RunOptions};
use latchgate_kernel::signal::{Projection, Reading, Signal};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};

/// A trapezoid of 5 g-units: rise to 5 ms, plateau to 15 ms, zero at 20 ms.
const SHORT: [(f64, f64); 4] = [(0.0, 0.0), (0.005, 1.0), (0.015, 1.0), (0.02, 0.0)];
/// The trapezoid of the sled: rise to 22 ms, plateau to 57 ms, zero at 85 ms.
const SLED: [(f64, f64); 4] = [(0.0, 0.0), (0.022, 1.0), (0.057, 1.0), (0.085, 0.0)];

/// One case: preload torque [N m] where it is not the paper's, knots, tangential and radial
/// amplitude [g], peak of the lever on the rigid stop [rad].
type Case = (Option<f64>, [(f64, f64); 4], f64, f64, f64);

const CASES: [Case; 10] = [
    (None, SHORT, -5.0, 0.0, 0.156_747_191_175_469_43),
    (None, SHORT, -5.0, 20.0, 0.173_842_738_004_834_8),
    (None, SHORT, -5.0, -20.0, 0.140_978_543_813_911),
    (None, SHORT, -5.0, 100.0, 0.256_354_150_461_219_4),
    // The radial axis turns the verdict.
    (None, SHORT, -5.0, -100.0, 0.090_203_050_940_178_45),
    (Some(2.85), SLED, -33.0, 0.0, 0.254_167_395_408_209_5),
    (Some(2.85), SLED, -33.0, 33.0, 0.625_432_453_518_876_5),
    (Some(2.85), SLED, -33.0, -33.0, 0.128_898_864_856_852_66),
    (Some(2.85), SLED, -33.0, 150.0, 5.174_130_701_300_08),
    (Some(2.85), SLED, -33.0, -150.0, 0.034_776_437_487_374_54),
];

/// Samples straight lines between knots, times an amplitude in g, for 0.1 s.
fn sampled(knots: &[(f64, f64)], amplitude_g: f64, rate_hz: f64) -> Signal {
    let value = |time: f64| {
        let segment = knots
            .windows(2)
            .rfind(|pair| (pair[0].0..=pair[1].0).contains(&time));
        segment.map_or(0.0, |pair| {
            let part = (time - pair[0].0) / (pair[1].0 - pair[0].0);
            pair[0].1 + (pair[1].1 - pair[0].1) * part
        })
    };
    let count = (0.1 * rate_hz).round() as usize + 1;
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        samples: (0..count)
            .map(|index| value(index as f64 / rate_hz) * amplitude_g * STANDARD_GRAVITY)
            .collect(),
    }
}

fn design_of(preload_torque_nm: Option<f64>) -> Design {
    let mut design = Design::reference();
    if let Some(torque) = preload_torque_nm {
        design.lever.preload_torque_nm = torque;
    }
    design
}

#[test]
fn verif_peaks_under_two_axes_are_those_of_the_series() {
    for (preload, knots, tangential_g, radial_g, peak) in CASES {
        let design = design_of(preload);
        for rate_hz in [1000.0, 10_000.0] {
            let tangential = sampled(&knots, tangential_g, rate_hz);
            let radial = sampled(&knots, radial_g, rate_hz);
            let reading = Reading::from(&tangential).beside((&radial).into()).unwrap();
            let options = RunOptions::new(StopModel::Rigid, OpensWhen::Negative);
            let run = replay::run(&reading, &design, &options).unwrap().run;
            let away = (run.peak_angle_rad - peak).abs();
            let case = format!("{tangential_g} g, {radial_g} g at {rate_hz} Hz: {away:e}");
            assert!(away <= 4e-15 * peak.max(1.0), "{case}");
            assert!(away <= run.numerical_error_rad + 2e-15, "{case}");
        }
    }
}

#[test]
fn verif_members_and_another_method_follow_two_axes_as_the_kernel_does() {
    for stop in [StopModel::Rigid, StopModel::Soft] {
        for (preload, knots, tangential_g, radial_g, _) in CASES {
            let design = design_of(preload);
            let tangential = sampled(&knots, tangential_g, 10_000.0);
            let radial = sampled(&knots, radial_g, 10_000.0);
            let reading = Reading::from(&tangential).beside((&radial).into()).unwrap();
            let options = RunOptions::new(stop, OpensWhen::Negative);
            let kernel = replay::run(&reading, &design, &options).unwrap().run;
            let other = RunOptions {
                method: Method::Dopri5 { at_samples: true },
                tolerance_rad: Some(1e-12),
                ..options
            };
            let dopri5 = replay::run(&reading, &design, &other).unwrap().run;
            let batch_options = BatchOptions {
                stop,
                projection: Projection::ALIGNED,
                opens_when: OpensWhen::Negative,
                initial: None,
                window: None,
                coast: true,
                asked: AskedPeaks::ALL,
                threshold_rad: 0.1,
                threads: 1,
            };
            let member = |_: usize| Member {
                lever: design.lever,
                stop: design.stop,
                scale: 1.0,
                bias_m_s2: 0.0,
                second: SensorView::default(),
                catch: None,
            };
            let members = batch::peaks(&reading, 3, &member, &batch_options).unwrap();
            for (name, peak) in [
                ("Dormand-Prince", dopri5.peak_angle_rad),
                ("a member", members[1].peak_angle_rad),
            ] {
                let away = (peak - kernel.peak_angle_rad).abs();
                assert!(
                    away <= 1e-9 * kernel.peak_angle_rad.max(0.1),
                    "{name}, {stop:?}, {tangential_g} g and {radial_g} g: {away:e}"
                );
            }
        }
    }
}

/// A radial axis that stays at zero changes no bit.
#[test]
fn verif_a_radial_axis_of_zeros_changes_nothing() {
    let design = Design::reference();
    let tangential = sampled(&SHORT, -5.0, 10_000.0);
    let radial = sampled(&SHORT, 0.0, 10_000.0);
    let alone = Reading::from(&tangential);
    let reading = alone.clone().beside((&radial).into()).unwrap();
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let options = RunOptions::new(stop, OpensWhen::Negative);
        let one_axis = replay::run(&alone, &design, &options).unwrap();
        let two_axes = replay::run(&reading, &design, &options).unwrap();
        assert_eq!(one_axis, two_axes, "{stop:?}");
    }
}

/// Both channels turned by an angle, and the projection turned back, give the same peak.
#[test]
fn verif_a_projection_turns_the_axes() {
    let design = Design::reference();
    let (tangential, radial) = (
        sampled(&SHORT, -5.0, 10_000.0),
        sampled(&SHORT, -100.0, 10_000.0),
    );
    let turned = |cosine: f64, sine: f64| {
        let mut signal = tangential.clone();
        for (sample, other) in signal.samples.iter_mut().zip(&radial.samples) {
            *sample = *sample * cosine + *other * sine;
        }
        signal
    };
    let (sine, cosine) = 0.6_f64.sin_cos();
    let first = turned(cosine, sine);
    let mut second = turned(-sine, 0.0);
    for (sample, other) in second.samples.iter_mut().zip(&radial.samples) {
        *sample += *other * cosine;
    }
    let reading = Reading::from(&first).beside((&second).into()).unwrap();
    let options = RunOptions {
        projection: Projection {
            tangential: [cosine, -sine],
            radial: [sine, cosine],
        },
        ..RunOptions::new(StopModel::Rigid, OpensWhen::Negative)
    };
    let run = replay::run(&reading, &design, &options).unwrap().run;
    let away = (run.peak_angle_rad - 0.090_203_050_940_178_45).abs();
    assert!(away <= 1e-13, "{away:e}");
}
