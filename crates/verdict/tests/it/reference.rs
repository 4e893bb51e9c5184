//! Quad-precision reference runs.

use crate::support::{columns, json, number};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::signal::{Reading, Signal};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};
use latchgate_verdict::conditioning::between::{self, Between};
use std::borrow::Cow;

fn stop(name: &str) -> StopModel {
    if name == "rigid" {
        StopModel::Rigid
    } else {
        StopModel::Soft
    }
}

/// What may be off: angles [rad], instants [s], angular velocities [rad/s].
#[derive(Debug, Clone, Copy)]
struct Bar {
    angle: f64,
    time: f64,
    velocity: f64,
}

/// Of a shock with few impacts: a digit above what was seen, so that losing one more fails.
const SHOCK: Bar = Bar {
    angle: 1e-13,
    time: 1e-15,
    velocity: 5e-12,
};

/// The same within the samples' band.
const SMOOTH_SHOCK: Bar = Bar {
    angle: 2e-12,
    time: 1e-13,
    velocity: 5e-11,
};

/// Of a well-conditioned real channel.
const CHANNEL: Bar = Bar {
    angle: 1e-11,
    time: 1e-12,
    velocity: 1e-9,
};

#[track_caller]
fn check_close(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got:e}, want {want:e}, off by {:e}, tolerated {tolerance:e}",
        got - want
    );
}

/// Event-driven replay of every reference shock: release, crossing, peak and impacts.
#[test]
fn val_shocks_agree_with_quad_precision() {
    check_shocks(&json("reference/shocks.json"), Between::Linear, &SHOCK);
    check_shocks(
        &json("reference/between.json"),
        Between::BandLimited,
        &SMOOTH_SHOCK,
    );
}

fn read(signal: &Signal, between: Between) -> Reading<'_> {
    between::read(Cow::Borrowed(signal), between).unwrap()
}

#[track_caller]
fn check_shocks(cases: &serde_json::Value, between: Between, bar: &Bar) {
    let mut checked = 0;
    for (name, case) in cases["cases"].as_object().unwrap() {
        let Some(file) = case["signal"].as_str() else {
            continue;
        };
        checked += 1;
        let rows = columns(&format!("reference/{file}"));
        let signal = Signal {
            start_s: 0.0,
            rate: SampleRate::from_hertz(case["fs"].as_f64().unwrap()).unwrap(),
            samples: rows.iter().map(|row| row.1).collect(),
        };
        let options = RunOptions::new(stop(case["model"].as_str().unwrap()), OpensWhen::Negative);
        let reading = read(&signal, between);
        let run = replay::run(&reading, &Design::reference(), &options)
            .unwrap()
            .run;
        let error = (run.peak_angle_rad - number(&case["peak"])).abs();
        println!(
            "{name}: peak error {error:.1e} stated {:.1e} impacts {} of {} work {:?}",
            run.numerical_error_rad, run.impacts, case["n_impacts_gt_1e_3"], run.work
        );
        check_close(name, run.peak_angle_rad, number(&case["peak"]), bar.angle);
        for (what, got, want) in [
            ("peak", Some(run.peak_time_s), &case["t_peak"]),
            ("release", run.first_release_s, &case["first_release"]),
            ("crossing", run.first_crossing_s, &case["first_crossing"][0]),
        ] {
            let what = format!("{name}: instant of the {what}");
            check_close(&what, got.unwrap(), number(want), bar.time);
        }
        assert!(
            error <= run.numerical_error_rad,
            "{name}: error {error:e} stated {:e}",
            run.numerical_error_rad
        );
        assert_eq!(
            run.impacts,
            case["n_impacts_gt_1e_3"].as_u64().unwrap(),
            "{name}"
        );
        for (got, want) in run
            .impact_list
            .iter()
            .zip(case["impacts"].as_array().unwrap())
            .take(10)
        {
            check_close(name, got[0], number(&want[0]), bar.time);
            check_close(name, got[1], number(&want[1]), bar.velocity);
        }
    }
    assert_eq!(checked, 32);
}

/// Event-driven replay of the real channels: where double precision can follow, it agrees;
/// where it cannot, the stated error covers the true one.
#[test]
fn val_real_channels_agree_with_quad_precision() {
    check_channels(&json("reference/nhtsa.json"), Between::Linear);
    check_channels(&json("reference/between.json"), Between::BandLimited);
}

#[track_caller]
fn check_channels(cases: &serde_json::Value, between: Between) {
    let mut checked = 0;
    // On curves a step lets 1e-15 of its motion pass, which the stated error counts.
    let (times, least) = match between {
        Between::Linear => (200.0, 1e-12),
        _ => (2000.0, 1e-10),
    };
    for (name, case) in cases["cases"].as_object().unwrap() {
        let Some(file) = case["file"].as_str() else {
            continue;
        };
        checked += 1;
        let rows = columns(file);
        let signal = Signal {
            start_s: rows[0].0,
            rate: SampleRate::from_hertz(12500.0).unwrap(),
            samples: rows.iter().map(|row| row.1 * STANDARD_GRAVITY).collect(),
        };
        let opens_when = if case["opens_when"] == "negative" {
            OpensWhen::Negative
        } else {
            OpensWhen::Positive
        };
        let options = RunOptions::new(stop(case["model"].as_str().unwrap()), opens_when);
        let reading = read(&signal, between);
        let run = replay::run(&reading, &Design::reference(), &options)
            .unwrap()
            .run;
        let peak = number(&case["peak_angle_rad"]);
        let rounding = number(&case["rounding_error_rad"]);
        let error = (run.peak_angle_rad - peak).abs();
        println!(
            "{name}: peak error {error:.1e} stated {:.1e} rounding {rounding:.1e} impacts {} of {} work {:?}",
            run.numerical_error_rad, run.impacts, case["impacts_faster_than_1e_3"], run.work
        );
        assert!(
            error <= run.numerical_error_rad,
            "{name}: error {error:e} stated {:e}",
            run.numerical_error_rad
        );
        assert!(
            run.numerical_error_rad <= (times * rounding).max(least),
            "{name}: stated {:e}",
            run.numerical_error_rad
        );
        // Where rounding alone moves the peak by more than the bar, no double can meet it.
        check_close(
            name,
            run.peak_angle_rad,
            peak,
            (10.0 * rounding).max(CHANNEL.angle),
        );
        assert_eq!(
            run.first_crossing_s.is_some(),
            !case["first_crossing_s"].is_null(),
            "{name}"
        );
        if let Some(crossing) = run.first_crossing_s {
            let tolerance = (10.0 * rounding).max(CHANNEL.time);
            check_close(name, crossing, number(&case["first_crossing_s"]), tolerance);
        }
        check_close(
            name,
            run.first_release_s.unwrap(),
            number(&case["first_release_s"]),
            CHANNEL.time,
        );
        let first = case["first_impacts_t_from_first_sample_v"]
            .as_array()
            .unwrap();
        for (got, want) in run.impact_list.iter().zip(first) {
            check_close(
                name,
                got[0] - signal.start_s,
                number(&want[0]),
                CHANNEL.time,
            );
            check_close(name, got[1], number(&want[1]), CHANNEL.velocity);
        }
    }
    assert_eq!(checked, 12);
}
