//! Guards the coast after the record's end: it is the same motion as under zeros, and it is
//! known as well.
//!
//! Steps of a coast are long. In a soft contact the terms of so long a step grow far beyond
//! the angle before they fall; a truncation relative to their sum let an error of a tenth of a
//! radian stand in the coast's bound, enough to make a pass undecided.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::pulse::Pulse;
use latchgate_kernel::replay::{self, RunOptions};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};

const RATE_HZ: f64 = 10_000.0;

/// A half-sine of 30 g and 11 ms in a record of `seconds`, the rest zero.
fn half_sine(seconds: f64) -> Signal {
    let count = (seconds * RATE_HZ).round() as u32;
    let pulse = Pulse::HalfSine {
        peak: -30.0 * STANDARD_GRAVITY,
        duration_s: 0.011,
    };
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(RATE_HZ).unwrap(),
        samples: (0..=count)
            .map(|n| pulse.at(f64::from(n) / RATE_HZ))
            .collect(),
    }
}

/// Ends the record while the lever falls towards the stop, so that the coast goes through an
/// impact, and compares with the same instants under recorded zeros.
#[track_caller]
fn check_coast_is_replay_of_zeros(stop: StopModel) {
    let (short, long) = (half_sine(0.13), half_sine(0.4));
    let last = short.samples.len() - 1;
    let options = RunOptions::new(stop, OpensWhen::Negative);
    let coasting = replay::run(&short, &Design::reference(), &options).unwrap();
    let replayed = replay::run(
        &long,
        &Design::reference(),
        &RunOptions {
            window: Some((last, long.samples.len() - 1)),
            ..options
        },
    )
    .unwrap()
    .run;
    let coast = coasting.run.coast_peak_angle_rad.unwrap();
    assert!(
        replayed.peak_time_s > 0.15 && replayed.impacts > coasting.run.impacts,
        "the coast shall go through an impact: {replayed:?}"
    );
    let error = (coast - replayed.peak_angle_rad).abs();
    assert!(
        error <= 1e-12,
        "coast {coast}, under zeros {}",
        replayed.peak_angle_rad
    );
    assert!(
        coasting.coast_error_rad < 1e-10,
        "coast known to {:e} rad only",
        coasting.coast_error_rad
    );
}

#[test]
fn verif_a_coast_off_the_rigid_stop_is_a_replay_of_zeros() {
    check_coast_is_replay_of_zeros(StopModel::Rigid);
}

#[test]
fn regress_a_coast_through_a_soft_contact_is_a_replay_of_zeros_and_known() {
    check_coast_is_replay_of_zeros(StopModel::Soft);
}
