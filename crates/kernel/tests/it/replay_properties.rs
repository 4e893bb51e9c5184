//! What holds of every replay, over random levers and recordings; the seed of a failing case
//! is in its message.

use crate::oracle;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{RunOptions, RunOutcome, State};
use latchgate_kernel::signal::Reading;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::OpensWhen;
use latchgate_test_support::{Random, options, random_design, random_signal, replay, signal};

/// Cases more in release mode, where they cost less.
const MORE: u64 = if cfg!(debug_assertions) { 1 } else { 10 };

#[track_caller]
fn check_consistent(label: &str, outcome: &RunOutcome, design: &Design, options: &RunOptions) {
    let run = &outcome.run;
    assert!(!outcome.broke_down, "{label}: broke down");
    for (name, number) in [
        ("peak", run.peak_angle_rad),
        ("peak time", run.peak_time_s),
        ("time above", run.time_above_threshold_s),
        ("final angle", run.final_angle_rad),
        ("final velocity", run.final_velocity_rad_s),
        ("error", run.numerical_error_rad),
        ("coast error", outcome.coast_error_rad),
        ("coast", run.coast_peak_angle_rad.unwrap_or(0.0)),
    ] {
        assert!(number.is_finite(), "{label}: {name} {number}");
    }
    let threshold = design.criterion.threshold_rad;
    assert_eq!(
        run.first_crossing_s.is_some(),
        run.peak_angle_rad > threshold,
        "{label}: peak {} crossing {:?}",
        run.peak_angle_rad,
        run.first_crossing_s
    );
    assert_eq!(
        run.first_release_s.is_some(),
        run.peak_angle_rad > 0.0,
        "{label}: peak {} release {:?}",
        run.peak_angle_rad,
        run.first_release_s
    );
    if let Some(crossing) = run.first_crossing_s {
        assert!(crossing <= run.peak_time_s, "{label}: crossing after peak");
    } else {
        assert_eq!(run.time_above_threshold_s, 0.0, "{label}");
    }
    if let Some(coast) = run.coast_peak_angle_rad {
        assert!(
            coast >= run.final_angle_rad,
            "{label}: coast {coast} from {}",
            run.final_angle_rad
        );
    }
    assert_eq!(
        run.impact_list.len() as u64,
        run.impacts.min(200),
        "{label}"
    );
    let mut before = f64::NEG_INFINITY;
    for point in &outcome.trace {
        assert!(
            point.time_s >= before - 1e-12,
            "{label}: time runs backwards at {}",
            point.time_s
        );
        before = point.time_s;
        assert!(
            point.angle_rad <= run.peak_angle_rad,
            "{label}: {} at {} above the peak {}",
            point.angle_rad,
            point.time_s,
            run.peak_angle_rad
        );
        if options.stop == StopModel::Rigid {
            assert!(
                point.angle_rad >= -1e-12,
                "{label}: {} at {} inside the stop",
                point.angle_rad,
                point.time_s
            );
        }
    }
}

/// Every stated quantity is finite, agrees with the others and with the trace.
#[test]
fn prop_random_replays_are_consistent() {
    for seed in 0..1000 * MORE {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let signal = random_signal(&mut random, 150, 1.0, 1e4);
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let options = options(stop);
            let outcome = replay(&signal, &design, &options);
            let label = format!("seed {seed} {}", stop.name());
            check_consistent(&label, &outcome, &design, &options);
        }
    }
}

/// A run that states no error takes fewer orders, and its peak lies where the error that is stated of the
/// same run allows it.
#[test]
fn prop_a_run_for_its_peak_alone_has_the_peak() {
    let mut orders = [0, 0];
    for seed in 0..300 * MORE {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let signal = random_signal(&mut random, 60, 1.0, 1e4);
        // Refined, where six orders mostly suffice.
        let signal = Reading::from(&signal).divided(16).signal().clone();
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let options = options(stop);
            let stated = replay(&signal, &design, &options);
            let alone = RunOptions {
                error_bound: false,
                peak_only: true,
                ..options
            };
            let alone = replay(&signal, &design, &alone);
            let (peak, error) = (stated.run.peak_angle_rad, stated.run.numerical_error_rad);
            let off = (alone.run.peak_angle_rad - peak).abs();
            assert!(
                off <= error,
                "seed {seed} {}: {peak} +- {error} is off by {off}",
                stop.name()
            );
            orders[0] += stated.run.work.rhs;
            orders[1] += alone.run.work.rhs;
        }
    }
    assert!(5 * orders[1] < 4 * orders[0], "{orders:?}");
}

/// True and stated error of one replay.
struct Errors {
    label: String,
    truth: f64,
    stated: f64,
    value: f64,
}

impl Errors {
    fn of(label: &str, got: f64, stated: f64, truth: oracle::Wide) -> Self {
        // What no double can hold is no error of the method.
        let rounding = 0.5 * f64::EPSILON * truth.to_f64().abs();
        let difference = (truth - got.into()).to_f64().abs();
        Self {
            label: label.into(),
            truth: (difference - rounding).max(0.0),
            stated,
            value: truth.to_f64(),
        }
    }
}

/// Errors of the peak and of the angle at the end.
fn errors_of(
    label: &str,
    signal: &Signal,
    design: &Design,
    stop: StopModel,
    initial: Option<State>,
) -> [Errors; 2] {
    let options = RunOptions {
        initial,
        ..RunOptions::new(stop, OpensWhen::Negative)
    };
    let outcome = replay(signal, design, &options);
    let (run, at_end) = (&outcome.run, outcome.final_error_rad.unwrap());
    let truth = oracle::follow(signal, 1.0, design, stop, initial);
    [
        Errors::of(
            label,
            run.peak_angle_rad,
            run.numerical_error_rad,
            truth.peak,
        ),
        Errors::of(label, run.final_angle_rad, at_end, truth.angle),
    ]
}

/// The stated error covers the true one in 99.9 % of cases and exceeds it by less than two
/// orders of magnitude in the middle.
#[track_caller]
fn check_coverage(what: &str, errors: &[Errors]) {
    let bad: Vec<&Errors> = errors.iter().filter(|e| e.truth > e.stated).collect();
    let mut ratios: Vec<f64> = errors
        .iter()
        .filter(|e| e.truth > 0.0)
        .map(|e| e.stated / e.truth)
        .collect();
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    println!(
        "{what}: {} cases, {} not covered, stated/true: median {median:.1}, 5 % {:.1}, 95 % {:.1}",
        errors.len(),
        bad.len(),
        ratios[ratios.len() / 20],
        ratios[ratios.len() * 19 / 20]
    );
    for e in &bad {
        println!(
            "  {}: true {:.2e} stated {:.2e} of {:.3e}",
            e.label, e.truth, e.stated, e.value
        );
    }
    // Of fewer than a thousand cases one may be the one.
    let most = errors.len().div_ceil(1000);
    assert!(bad.len() <= most, "{what}: {}", bad.len());
    assert!(median < 100.0, "{what}: median {median}");
}

/// Random levers and records from a base seed on, both stops; `started` gives the lever a
/// swing to begin with. Errors of the peak, and of the angle at the end.
fn random_errors(base: u64, cases: u64, longest: usize, started: bool) -> [Vec<Errors>; 2] {
    let mut errors = [vec![], vec![]];
    for seed in base..base + cases {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let signal = random_signal(&mut random, longest, 5.0, 3e3);
        let initial =
            started.then(|| State::new(random.between(0.0, 0.5), random.between(-20.0, 20.0)));
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let label = format!("seed {seed} {}", stop.name());
            let [peak, end] = errors_of(&label, &signal, &design, stop, initial);
            errors[0].push(peak);
            errors[1].push(end);
        }
    }
    errors
}

#[track_caller]
fn check_both(what: &str, errors: &[Vec<Errors>; 2]) {
    check_coverage(&format!("{what}, peak"), &errors[0]);
    check_coverage(&format!("{what}, end"), &errors[1]);
}

/// The stated error covers the true one on soft stops in which a motion dies away many times within a sample.
#[test]
fn prop_stated_error_covers_the_true_one_far_beyond_critical_damping() {
    let mut errors = [vec![], vec![]];
    for seed in 5_000_000..5_000_000 + 100 * MORE {
        let mut random = Random(seed);
        let mut design = random_design(&mut random);
        let signal = random_signal(&mut random, 40, 5.0, 3e3);
        let (inertia, radius) = (design.lever.moment_of_inertia_kg_m2, design.stop.radius_m);
        let a_sample = 10.0_f64.powf(random.between(0.3, 2.0)) * signal.rate.hertz();
        design.stop.damping_n_s_per_m = a_sample * inertia / (radius * radius);
        let label = format!("seed {seed}");
        let found = errors_of(&label, &signal, &design, StopModel::Soft, None);
        for (errors, found) in errors.iter_mut().zip(found) {
            errors.push(found);
        }
    }
    check_both("far beyond critical damping", &errors);
}

#[test]
fn prop_stated_error_covers_the_true_one_from_rest() {
    check_both(
        "from rest",
        &random_errors(1_000_000, 400 * MORE, 40, false),
    );
}

#[test]
fn prop_stated_error_covers_the_true_one_of_a_swing() {
    check_both("swing", &random_errors(2_000_000, 100 * MORE, 40, true));
}

/// Longer records: dozens of impacts, by which the error grows a thousandfold.
#[test]
fn prop_stated_error_covers_the_true_one_after_many_impacts() {
    check_both("long", &random_errors(3_000_000, 50 * MORE, 400, false));
}

/// Levers that a push barely lifts against their preload, sample after sample: what is rounded in both is the same in
/// every step, and adds up.
#[test]
fn prop_stated_error_covers_the_true_one_near_balance() {
    let mut errors = [vec![], vec![]];
    for seed in 6_000_000..6_000_000 + 20 * MORE {
        let mut random = Random(seed);
        let mut design = random_design(&mut random);
        design.lever.preload_torque_nm = random.scale(0.1, 1.0);
        let push = design.lever.lift_off_acceleration_m_s2() * (1.0 + random.scale(1e-4, 1e-2));
        let signal = signal(10_000.0, vec![-push; 300]);
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let label = format!("seed {seed} {}", stop.name());
            let found = errors_of(&label, &signal, &design, stop, None);
            for (errors, found) in errors.iter_mut().zip(found) {
                errors.push(found);
            }
        }
    }
    check_both("near balance", &errors);
}

/// Longest coast that is followed under zeros [samples].
const COAST_SAMPLES: f64 = 3000.0;

/// Samples that a rising lever needs at most to its turn: a quarter of its free period. `None`
/// where that is too long to follow.
fn samples_to_the_turn(design: &Design, rate_hz: f64) -> Option<usize> {
    let quarter = 0.5 * std::f64::consts::PI / design.lever.angular_frequency_rad_s();
    // Damping of a few per cent at most delays the turn of the heaviest lever here by less.
    let samples = 1.5 * quarter * rate_hz;
    (samples < COAST_SAMPLES).then(|| samples as usize + 2)
}

/// Recordings that end while the lever rises: the coast's peak, which a pass rests on, against the
/// same lever under as many zeros as it needs to turn.
#[test]
fn prop_stated_error_of_the_coast_covers_the_true_one() {
    let mut errors = vec![];
    for seed in 4_000_000..4_000_000 + 300 * MORE {
        let mut random = Random(seed);
        let design = random_design(&mut random);
        let mut record = random_signal(&mut random, 60, 5.0, 3e3);
        // A coast has no excitation; nothing ramps down after the last sample.
        record.samples.push(0.0);
        let Some(more) = samples_to_the_turn(&design, record.rate.hertz()) else {
            continue;
        };
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let options = RunOptions::new(stop, OpensWhen::Negative);
            let outcome = replay(&record, &design, &options);
            let Some(coast) = outcome.run.coast_peak_angle_rad else {
                continue;
            };
            if coast <= outcome.run.peak_angle_rad {
                continue;
            }
            let mut extended = record.clone();
            extended.samples.extend(vec![0.0; more]);
            let truth = oracle::follow(&extended, 1.0, &design, stop, None);
            let label = format!("seed {seed} {}", stop.name());
            errors.push(Errors::of(
                &label,
                coast,
                outcome.coast_error_rad,
                truth.peak,
            ));
        }
    }
    assert!(errors.len() > 100, "{} coasts", errors.len());
    check_coverage("coast", &errors);
}
