//! Quad-precision reference runs.

use crate::support::{columns, json, number};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};

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
    let cases = json("reference/shocks.json");
    for (name, case) in cases["cases"].as_object().unwrap() {
        let rows = columns(&format!("reference/{}", case["signal"].as_str().unwrap()));
        let signal = Signal {
            start_s: 0.0,
            rate: SampleRate::from_hertz(case["fs"].as_f64().unwrap()).unwrap(),
            samples: rows.iter().map(|row| row.1).collect(),
        };
        let options = RunOptions::new(stop(case["model"].as_str().unwrap()), OpensWhen::Negative);
        let run = replay::run(&signal, &Design::reference(), &options)
            .unwrap()
            .run;
        let error = (run.peak_angle_rad - number(&case["peak"])).abs();
        println!(
            "{name}: peak error {error:.1e} stated {:.1e} impacts {} of {} work {:?}",
            run.numerical_error_rad, run.impacts, case["n_impacts_gt_1e_3"], run.work
        );
        check_close(name, run.peak_angle_rad, number(&case["peak"]), SHOCK.angle);
        for (what, got, want) in [
            ("peak", Some(run.peak_time_s), &case["t_peak"]),
            ("release", run.first_release_s, &case["first_release"]),
            ("crossing", run.first_crossing_s, &case["first_crossing"][0]),
        ] {
            let what = format!("{name}: instant of the {what}");
            check_close(&what, got.unwrap(), number(want), SHOCK.time);
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
            check_close(name, got[0], number(&want[0]), SHOCK.time);
            check_close(name, got[1], number(&want[1]), SHOCK.velocity);
        }
    }
}

/// Event-driven replay of the real channels: where double precision can follow, it agrees;
/// where it cannot, the stated error covers the true one.
#[test]
fn val_real_channels_agree_with_quad_precision() {
    let cases = json("reference/nhtsa.json");
    for (name, case) in cases["cases"].as_object().unwrap() {
        let rows = columns(case["file"].as_str().unwrap());
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
        let run = replay::run(&signal, &Design::reference(), &options)
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
            run.numerical_error_rad <= (200.0 * rounding).max(1e-12),
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
}
