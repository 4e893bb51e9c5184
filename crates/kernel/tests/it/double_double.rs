//! The replay in double-double arithmetic against the independent integrator, and what it makes of a run's stated error.

use crate::oracle;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::double_double::{heights, narrow};
use latchgate_kernel::replay::{RunOptions, Within};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_test_support::{Random, random_design, random_signal, replay, signal};

/// Checks one lever on one record against the independent integrator; returns how far doubles are off the truth, `None`
/// where the replay in double-double arithmetic has no answer.
#[track_caller]
fn check(label: &str, record: &Signal, design: &Design, stop: StopModel) -> Option<f64> {
    let options = RunOptions::new(stop, OpensWhen::Negative);
    let heights = heights(record, design, &options, false, &Within::UNBOUNDED)
        .unwrap()
        .0?;
    let truth = oracle::follow(record, 1.0, design, stop, None)
        .peak
        .to_f64();
    let off = (heights.peak_rad - truth).abs();
    let mut outcome = replay(record, design, &options);
    let stated = outcome.run.numerical_error_rad;
    assert!(
        off <= 1e-11 * stated + 1e-15 * truth.abs() + 1e-18,
        "{label}: {} off by {off:e} of {truth}, where {stated:e} is stated of doubles",
        heights.peak_rad
    );
    narrow(&mut outcome, record, design, &options, &Within::UNBOUNDED).unwrap();
    let narrowed = outcome.run.numerical_error_rad;
    let true_error = (outcome.run.peak_angle_rad - truth).abs();
    assert!(
        true_error <= narrowed && narrowed <= stated,
        "{label}: {true_error:e} <= {narrowed:e} <= {stated:e}"
    );
    assert!(outcome.run.error.is_bound());
    Some(true_error)
}

/// Random levers and records: both integrators come to the double next to the truth, or as close as a tenth of what is
/// left of the stated bound.
#[test]
fn prop_heights_are_those_of_the_independent_integrator() {
    let mut found = 0;
    for seed in 7_000_000..7_000_150 {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let record = random_signal(&mut random, 200, 5.0, 3e3);
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let label = format!("seed {seed} {}", stop.name());
            found += u32::from(check(&label, &record, &design, stop).is_some());
        }
    }
    println!("{found} of 300 heights");
    assert!(found >= 290, "{found}");
}

/// A lever that never rests, on a sine: after 45 periods doubles have lost half of their digits, and the stated bound
/// more than that; the replay in double-double arithmetic is as close to the truth as is claimed of it.
#[test]
fn val_heights_hold_where_doubles_are_lost() {
    let rate_hz = 2_000.0;
    let count = (45.0 * std::f64::consts::TAU / 100.0 * rate_hz) as usize;
    let at = |k: usize| 2.5 * STANDARD_GRAVITY * libm::sin(100.0 * k as f64 / rate_hz);
    let record = signal(rate_hz, (0..=count).map(at).collect());
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let off = check(stop.name(), &record, &Design::reference(), stop).unwrap();
        println!("{} stop: doubles are off by {off:e} rad", stop.name());
        assert!(off > 1e-13, "{off:e}");
    }
}

/// What was taken counts, whether an answer came of it or the limit on it came first.
#[test]
fn verif_what_a_height_costs_is_counted_with_and_without_it() {
    let record = random_signal(&mut Random(7_000_003), 200, 5.0, 3e3);
    let options = RunOptions::new(StopModel::Rigid, OpensWhen::Negative);
    let find = |steps_max| {
        let within = Within {
            steps_max,
            ..Within::UNBOUNDED
        };
        heights(&record, &Design::reference(), &options, false, &within).unwrap()
    };
    let (found, whole) = find(u64::MAX);
    assert!(found.is_some() && whole > 1000, "{found:?} {whole}");
    let (cut, spent) = find(whole / 2);
    assert_eq!(cut, None);
    assert!(
        spent > whole / 2 - 100 && spent < whole,
        "{spent} of {whole}"
    );
}
