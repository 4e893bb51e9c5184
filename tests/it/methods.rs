//! The methods to compare with: their orders, and where each of them fails.

use latchgate_kernel::error::Error as KernelError;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::{Excitation, Harmonic, Sampled};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::numerics::{Motion, dopri5, event, rk4};
use latchgate_kernel::replay::{
    self, Method, REST_SPEED_RAD_S, RunOptions, RunOutcome, State, TracePoint,
};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_study::cases;

const RK4: Method = Method::Rk4 {
    steps_per_period: 10_000,
};
const LOCATED: Method = Method::Rk4Located {
    steps_per_period: 10_000,
};
const MOREAU_JEAN: Method = Method::MoreauJean {
    steps_per_period: 10_000,
};
const DOPRI5: Method = Method::Dopri5 { at_samples: false };
const DOPRI5_SAMPLES: Method = Method::Dopri5 { at_samples: true };

/// Gravity of the quad-precision reference values [m/s²].
const REFERENCE_GRAVITY: f64 = 9.81;

fn options(stop: StopModel, method: Method) -> RunOptions {
    RunOptions {
        method,
        error_bound: false,
        ..RunOptions::new(stop, OpensWhen::Negative)
    }
}

fn silence(length_s: f64, intervals: u32) -> Signal {
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(f64::from(intervals) / length_s).unwrap(),
        samples: vec![0.0; intervals as usize + 1],
    }
}

#[track_caller]
fn ask(signal: &Signal, options: &RunOptions) -> RunOutcome {
    replay::run(signal, &Design::reference(), options).unwrap()
}

#[track_caller]
fn check_near(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got:e}, want {want:e}, off by {:e}, tolerated {tolerance:e}",
        got - want
    );
}

struct Oscillator;

impl Motion for Oscillator {
    fn acceleration(&self, _t: f64, q: f64, _v: f64) -> f64 {
        -q
    }
}

/// q'' = −q from (1, 0) to t = 1: the error of the state by order `p` falls by 2^p.
#[track_caller]
fn check_order(what: &str, errors: &[f64], order: f64) {
    for pair in errors.windows(2) {
        let measured = (pair[0] / pair[1]).log2();
        assert!(
            (measured - order).abs() < 0.4,
            "{what}: order {measured}, expected {order}; errors {errors:?}"
        );
    }
}

#[test]
fn verif_dormand_prince_is_of_fifth_order_and_its_dense_output_of_fourth() {
    let mut ends = Vec::new();
    let mut insides = Vec::new();
    for steps in [8_u32, 16, 32] {
        let h = 1.0 / f64::from(steps);
        let (mut q, mut v, mut a) = (1.0, 0.0, -1.0);
        let mut inside: f64 = 0.0;
        for k in 0..steps {
            let t = f64::from(k) * h;
            let step = dopri5::step(&Oscillator, t, h, q, v, a);
            for part in [0.25, 0.5, 0.75] {
                let got = step.dense.iter().rev().fold(0.0, |sum, c| sum * part + c);
                // Against the flow from the step's own start: the local error.
                let (sine, cosine) = (part * h).sin_cos();
                inside = inside.max((got - (q * cosine + v * sine)).abs());
            }
            (q, v, a) = (step.q, step.v, step.a);
        }
        ends.push((q - 1.0_f64.cos()).hypot(v + 1.0_f64.sin()));
        insides.push(inside);
    }
    check_order("state", &ends, 5.0);
    // A dense output of fourth order has a local error of fifth.
    check_order("dense output", &insides, 5.0);
}

#[test]
fn val_the_stability_limit_of_rk4_on_both_axes() {
    check_near(
        "imaginary axis",
        rk4::stability_limit(0.0),
        8.0_f64.sqrt(),
        1e-5,
    );
    check_near(
        "real axis",
        rk4::stability_limit(1.0),
        2.785_293_563_405_282,
        1e-9,
    );
    // The reference contact: damping moves the limit from 2.83 to 2.93.
    let xi = Design::reference().contact_damping_ratio();
    let limit = rk4::stability_limit(xi);
    let growth = |reach: f64| rk4::amplification(-xi * reach, reach * (1.0 - xi * xi).sqrt());
    check_near("|R| at the limit", growth(limit), 1.0, 1e-9);
    check_near("limit of the reference contact", limit, 2.931, 5e-4);
    assert!(growth(1.001 * limit) > 1.0 && growth(0.999 * limit) < 1.0);
}

#[test]
fn verif_an_interpolant_that_dips_below_zero_and_comes_back_is_a_contact() {
    // q = (σ − 0.5)² − 1e-6: positive at both ends.
    let dip = [0.25 - 1e-6, -1.0, 1.0, 0.0];
    check_near("dip", event::first_contact(&dip, 1.0).unwrap(), 0.499, 1e-9);
    let touch = [0.25, -1.0, 1.0, 0.0];
    assert_eq!(
        event::first_contact(&touch, 1.0),
        None,
        "a touch is no event"
    );
    let bounce = [0.0, 1.0, -2.0, 0.0];
    check_near(
        "bounce",
        event::first_contact(&bounce, 1.0).unwrap(),
        0.5,
        1e-12,
    );
}

#[test]
fn verif_a_root_is_found_between_its_brackets() {
    check_near(
        "root",
        event::root(|x| x * x * x - 2.0, 0.0, 2.0),
        2.0_f64.cbrt(),
        1e-15,
    );
}

#[test]
fn verif_a_sampled_excitation_is_linear_between_its_samples_and_zero_beyond() {
    let signal = Signal {
        start_s: 1.0,
        rate: SampleRate::from_hertz(10.0).unwrap(),
        samples: vec![0.0, 2.0, -2.0],
    };
    let sampled = Sampled::straight(&signal, -1.0);
    for (t, want) in [
        (0.9, 0.0),
        (1.05, -1.0),
        (1.15, 0.0),
        (1.2, 2.0),
        (1.21, 0.0),
    ] {
        check_near(&format!("a({t})"), sampled.acceleration(t), want, 1e-12);
    }
    assert_eq!(sampled.next_kink(0.5), 1.0);
    assert_eq!(sampled.next_kink(1.0), 1.1);
    assert_eq!(sampled.next_kink(1.1), 1.2);
    assert_eq!(sampled.next_kink(1.2), f64::INFINITY);
}

/// Every sample of ten thousand is a kink, and none is met twice.
#[test]
fn verif_kinks_are_visited_once_each_far_from_time_zero() {
    let signal = Signal {
        start_s: 86_400.0,
        rate: SampleRate::from_hertz(9_999.7).unwrap(),
        samples: vec![0.0; 10_001],
    };
    let sampled = Sampled::straight(&signal, 1.0);
    let (mut t, mut count) = (signal.start_s, 0);
    while sampled.next_kink(t).is_finite() {
        t = sampled.next_kink(t);
        count += 1;
    }
    assert_eq!(count, 10_000);
}

/// Errors of a method's final angle on a coarse recording with impacts, for halved steps.
fn errors_at_steps(stop: StopModel, method: Method, steps: &[f64]) -> Vec<f64> {
    let signal = Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(1000.0).unwrap(),
        samples: (0..=100)
            .map(|k| -60.0 * (2.0 * std::f64::consts::PI * 12.0 * f64::from(k) / 1000.0).sin())
            .collect(),
    };
    let truth = ask(&signal, &options(stop, Method::EventDriven)).run;
    assert!(truth.impacts >= 1, "{} impacts", truth.impacts);
    steps
        .iter()
        .map(|step| {
            let run = RunOptions {
                step_s: Some(*step),
                ..options(stop, method)
            };
            (ask(&signal, &run).run.final_angle_rad - truth.final_angle_rad).abs()
        })
        .collect()
}

#[test]
fn verif_located_events_keep_the_fourth_order_through_impacts_and_samples() {
    let rigid = errors_at_steps(StopModel::Rigid, LOCATED, &[1e-3, 5e-4, 2.5e-4]);
    check_order("rigid", &rigid, 4.0);
    let soft = errors_at_steps(StopModel::Soft, LOCATED, &[1e-5, 5e-6, 2.5e-6]);
    check_order("soft", &soft, 4.0);
}

#[test]
fn verif_events_on_the_grid_leave_first_order_only() {
    for (stop, method) in [
        (StopModel::Rigid, RK4),
        (StopModel::Rigid, MOREAU_JEAN),
        (StopModel::Soft, RK4),
    ] {
        let errors = errors_at_steps(stop, method, &[1e-4, 1e-5, 1e-6]);
        // A method of second order would gain 1e4; one of first gains about 1e2, unevenly.
        let gain = errors[0] / errors[2];
        assert!(
            (5.0..3000.0).contains(&gain),
            "{} {}: {errors:?}",
            method.name(),
            stop.name()
        );
    }
}

#[test]
fn verif_kinks_cost_the_adaptive_pair_its_order_unless_it_restarts_at_samples() {
    let case = cases::recording(REFERENCE_GRAVITY).unwrap();
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let truth = ask(case.signal().unwrap(), &options(stop, Method::EventDriven)).run;
        let error = |method| {
            let run = RunOptions {
                tolerance_rad: Some(1e-9),
                ..options(stop, method)
            };
            (ask(case.signal().unwrap(), &run).run.peak_angle_rad - truth.peak_angle_rad).abs()
        };
        let (across, at_samples) = (error(DOPRI5), error(DOPRI5_SAMPLES));
        assert!(
            at_samples < 2e-8 && across > 1e3 * at_samples,
            "{}: across {across:e}, at samples {at_samples:e}",
            stop.name()
        );
    }
}

/// Ratios of speed over each contact in a trace: (at the first grid points outside and inside,
/// at φ = 0 by energy).
fn contact_ratios(points: &[TracePoint]) -> Vec<(f64, f64)> {
    let lever = Design::reference().lever;
    let at_stop = |point: &TracePoint| {
        let potential = lever.preload_torque_nm * point.angle_rad
            + 0.5 * lever.spring_stiffness_nm_per_rad * point.angle_rad.powi(2);
        (point.velocity_rad_s.powi(2) + 2.0 * potential / lever.moment_of_inertia_kg_m2)
            .sqrt()
            .copysign(point.velocity_rad_s)
    };
    let mut ratios = Vec::new();
    let mut entry = None;
    for pair in points.windows(2) {
        if pair[0].angle_rad >= 0.0 && pair[1].angle_rad < 0.0 {
            entry = Some((pair[1].velocity_rad_s, at_stop(&pair[0])));
        } else if pair[0].angle_rad < 0.0
            && pair[1].angle_rad >= 0.0
            && let Some((inside, before)) = entry.take()
        {
            ratios.push((
                -pair[1].velocity_rad_s / inside,
                -at_stop(&pair[1]) / before,
            ));
        }
    }
    ratios
}

fn figure_3(steps: u32) -> Vec<(f64, f64)> {
    let run = RunOptions {
        step_s: Some(std::f64::consts::TAU / (20.0 * f64::from(steps))),
        initial: Some(State::new(0.5, 0.0)),
        trace: true,
        ..options(StopModel::Soft, RK4)
    };
    // 0.6 s hold at most 20 000 steps, so that the trace keeps each of them.
    contact_ratios(&ask(&silence(0.6, 1), &run).trace)
}

/// The paper's Fig. 3 at N = 10 000. Read off the grid points outside and inside, the stop gives
/// back 0.81 to 0.85 of the speed; at φ = 0 it is 0.79 to 0.81, with 0.7998 right.
///
/// The ratios on the grid are those of an independent program.
#[test]
fn val_the_papers_step_gives_back_a_wrong_speed() {
    let ratios = figure_3(10_000);
    for (got, want) in ratios
        .iter()
        .zip([0.837, 0.816, 0.853, 0.809, 0.851, 0.852, 0.847])
    {
        check_near("ratio on the grid", got.0, want, 2e-3);
    }
    for (got, want) in ratios
        .iter()
        .zip([0.796, 0.805, 0.791, 0.803, 0.791, 0.791, 0.792])
    {
        check_near("ratio at φ = 0", got.1, want, 2e-3);
    }
    assert!(ratios.len() >= 7, "{ratios:?}");
}

/// At N = 1000 the product of stiffness and step is 3.33, beyond the limit: energy is gained, and
/// the run says what it is.
#[test]
fn val_a_tenth_of_the_papers_steps_gains_energy() {
    let ratios = figure_3(1000);
    check_near("first ratio", ratios[0].0, -1.017, 2e-3);
    check_near("second ratio", ratios[1].0, 9.80, 2e-2);
    let design = Design::reference();
    let known = Method::Rk4 {
        steps_per_period: 980,
    }
    .known_failures(
        &design,
        StopModel::Soft,
        SampleRate::from_hertz(1000.0).unwrap().interval(),
        None,
    );
    assert!(
        known.iter().any(|text| text.contains("gains energy")),
        "{known:?}"
    );
}

#[track_caller]
fn check_known(method: Method, rate_hz: f64, words: Option<&str>) {
    let known = method.known_failures(
        &Design::reference(),
        StopModel::Soft,
        SampleRate::from_hertz(rate_hz).unwrap().interval(),
        None,
    );
    match words {
        Some(words) => assert!(
            known.iter().any(|text| text.contains(words)),
            "{method:?} at {rate_hz} Hz: expected `{words}` in {known:?}"
        ),
        None => assert!(known.is_empty(), "{method:?} at {rate_hz} Hz: {known:?}"),
    }
}

/// What is known to fail is told by the step that is taken, which no sample interval lengthens,
/// and by one limit: that of the damped contact, 2.93.
#[test]
fn verif_coarse_steps_in_contact_are_known_to_fail() {
    let located = |steps_per_period| Method::Rk4Located { steps_per_period };
    let rk4 = |steps_per_period| Method::Rk4 { steps_per_period };
    // ω_R times step: 0.53 and 1.06, samples being shorter than the step asked for.
    check_known(located(1000), 20_000.0, Some("0.53: a contact"));
    check_known(located(1), 10_000.0, Some("1.06: a contact"));
    check_known(located(1), 1000.0, Some("limit of 2.93: the run gains"));
    check_known(located(10_000), 10_000.0, None);
    // 2.85 and 3.0 lie on either side of the damped limit and beyond the undamped one.
    check_known(rk4(1145), 1000.0, Some("is 2.85; entry and exit lie"));
    check_known(rk4(1088), 1000.0, Some("limit of 2.93: the run gains"));
}

/// Time at which free bounces from 0.5 rad end, in quad precision [s].
const ACCUMULATION_S: f64 = 0.829_523_400_832_410_4;

fn rest_time(points: &[TracePoint]) -> Option<f64> {
    let moving = points
        .iter()
        .rposition(|point| point.velocity_rad_s.abs() > 1e-12)?;
    points.get(moving + 1).map(|point| point.time_s)
}

#[test]
fn val_chatter_ends_at_its_accumulation_time() {
    let signal = silence(1.0, 1000);
    let rest = |method| {
        let run = RunOptions {
            initial: Some(State::new(0.5, 0.0)),
            trace: true,
            ..options(StopModel::Rigid, method)
        };
        rest_time(&ask(&signal, &run).trace)
    };
    // The bounces left out below the cut-off last 2 v/(α (1 − R)).
    let left_out = 2.0 * REST_SPEED_RAD_S / (0.1 / 8.888e-4 * 0.2);
    check_near(
        "event-driven",
        rest(Method::EventDriven).unwrap(),
        ACCUMULATION_S,
        1e-12,
    );
    for method in [LOCATED, DOPRI5, DOPRI5_SAMPLES] {
        check_near(
            method.name(),
            rest(method).unwrap(),
            ACCUMULATION_S,
            left_out + 5e-11,
        );
    }
    // Time-stepping rests, late by about the steps its bounces are late.
    let late = rest(MOREAU_JEAN).unwrap() - ACCUMULATION_S;
    assert!((1e-5..5e-3).contains(&late), "moreau-jean late by {late:e}");
    assert_eq!(rest(RK4), None, "the paper's method never rests");
}

/// The sine of the reference graze: a = −5 g sin(100 t + 1).
fn graze(change: f64, stop: StopModel, tolerance: f64) -> f64 {
    let excitation = Harmonic {
        amplitude_m_s2: -5.0 * REFERENCE_GRAVITY,
        angular_frequency_rad_s: 100.0,
        phase_rad: 1.0,
    };
    let run = RunOptions {
        tolerance_rad: Some(tolerance),
        initial: Some(State::new(
            0.004_973_986_935_791_459,
            -1.918_939_039_055_295 + change,
        )),
        ..options(stop, DOPRI5)
    };
    replay::run_harmonic(&excitation, 0.012, &Design::reference(), &run)
        .unwrap()
        .run
        .final_angle_rad
}

/// A lever that all but touches: quad-precision angles 7 ms later. A millionth more speed makes
/// an impact, and 26 times as much of it arrives.
#[test]
fn val_a_graze_amplifies_by_the_square_root_on_a_rigid_stop_only() {
    for (change, stop, want, tolerance) in [
        (1e-6, StopModel::Rigid, 9.843_747_595_135_812e-3, 1e-13),
        (1e-6, StopModel::Soft, 9.843_747_595_135_812e-3, 1e-13),
        (-1e-6, StopModel::Rigid, 9.869_295_186_840_881e-3, 1e-10),
        (-1e-6, StopModel::Soft, 9.843_749_261_039_37e-3, 1e-12),
    ] {
        let got = graze(change, stop, 1e-14);
        check_near(&format!("{} {change:e}", stop.name()), got, want, tolerance);
    }
}

/// 100 periods at ω = 100 rad/s and A = 5 on the smooth sine: quad-precision state at the end,
/// after 51 impacts.
#[test]
fn val_a_hundred_periods_of_a_smooth_sine() {
    let excitation = Harmonic {
        amplitude_m_s2: 5.0 * REFERENCE_GRAVITY,
        angular_frequency_rad_s: 100.0,
        phase_rad: 0.0,
    };
    for (stop, angle, tolerance) in [
        (StopModel::Rigid, 0.772_335_922_557_793_9, 1e-9),
        (StopModel::Soft, 0.432_963_818_103_593_6, 1e-6),
    ] {
        let run = RunOptions {
            tolerance_rad: Some(1e-12),
            initial: Some(State::new(0.1, 0.0)),
            ..options(stop, DOPRI5)
        };
        let end = 100.0 * std::f64::consts::TAU / 100.0;
        let got = replay::run_harmonic(&excitation, end, &Design::reference(), &run)
            .unwrap()
            .run;
        check_near(stop.name(), got.final_angle_rad, angle, tolerance);
    }
}

#[test]
fn verif_run_harmonic_refuses_what_it_cannot_do() {
    let excitation = Harmonic {
        amplitude_m_s2: 49.05,
        angular_frequency_rad_s: 100.0,
        phase_rad: 0.0,
    };
    let design = Design::reference();
    let good = options(StopModel::Rigid, Method::EventDriven);
    assert!(replay::run_harmonic(&excitation, 0.1, &design, &good).is_ok());
    assert!(replay::run_harmonic(&excitation, f64::NAN, &design, &good).is_err());
    assert!(replay::run_harmonic(&excitation, 1e9, &design, &good).is_err());
    let windowed = RunOptions {
        window: Some((0, 1)),
        ..good.clone()
    };
    assert!(replay::run_harmonic(&excitation, 0.1, &design, &windowed).is_err());
    let still = Harmonic {
        angular_frequency_rad_s: 0.0,
        ..excitation
    };
    assert!(replay::run_harmonic(&still, 0.1, &design, &good).is_err());
    let lost = Harmonic {
        phase_rad: f64::INFINITY,
        ..excitation
    };
    assert!(replay::run_harmonic(&lost, 0.1, &design, &good).is_err());
}

#[test]
fn verif_what_a_method_cannot_do_is_an_error() {
    let signal = silence(0.1, 100);
    let refused = |options: &RunOptions| {
        replay::run(&signal, &Design::reference(), options)
            .map(|outcome| outcome.run.method)
            .unwrap_err()
    };
    let soft = refused(&options(StopModel::Soft, MOREAU_JEAN));
    assert!(matches!(soft, KernelError::OutOfRange { .. }), "{soft}");
    assert!(soft.to_string().contains("`model` = rigid"), "{soft}");
    let tight = refused(&RunOptions {
        tolerance_rad: Some(1e-18),
        ..options(StopModel::Rigid, DOPRI5)
    });
    assert!(tight.to_string().contains("1e-14"), "{tight}");
    for step in [0.0, f64::NAN, -1e-3] {
        let zero = refused(&RunOptions {
            step_s: Some(step),
            ..options(StopModel::Rigid, RK4)
        });
        assert!(matches!(zero, KernelError::NotPositive { .. }), "{zero}");
    }
    let endless = refused(&RunOptions {
        step_s: Some(1e-12),
        ..options(StopModel::Rigid, LOCATED)
    });
    assert!(endless.to_string().contains("1e9"), "{endless}");
}

/// A run that explodes says so and gives finite numbers, whatever the method's stated error.
#[test]
fn verif_a_run_that_explodes_is_told() {
    let case = cases::harmonic(REFERENCE_GRAVITY, 5.0, 100.0, 20);
    let run = RunOptions {
        step_s: Some(3.6e-4),
        initial: case.initial,
        error_bound: true,
        ..options(StopModel::Soft, RK4)
    };
    let outcome = case.replay(&Design::reference(), &run).unwrap();
    let kernel = RunOptions {
        initial: case.initial,
        ..options(StopModel::Soft, Method::EventDriven)
    };
    let truth = case.replay(&Design::reference(), &kernel).unwrap();
    assert!(outcome.run.peak_angle_rad.is_finite());
    assert!(
        outcome.broke_down || outcome.run.peak_angle_rad > 3.0 * truth.run.peak_angle_rad,
        "{:?}",
        outcome.run
    );
    assert!(
        outcome.run.numerical_error_rad > 1.0,
        "{}",
        outcome.run.numerical_error_rad
    );
}

/// At coarse, usual and default settings, the error that each method with located events states
/// covers the true one. A step longer than a sample ends at each sample: halving what was asked
/// for would give the same run again, and an error of zero.
#[test]
fn verif_stated_errors_cover_the_true_ones() {
    for case in [
        cases::shock(REFERENCE_GRAVITY).unwrap(),
        cases::recording(REFERENCE_GRAVITY).unwrap(),
    ] {
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let truth = ask(case.signal().unwrap(), &options(stop, Method::EventDriven)).run;
            let located = [1, 1000, 2885, 10_000]
                .map(|steps_per_period| Method::Rk4Located { steps_per_period });
            for method in located.into_iter().chain([DOPRI5, DOPRI5_SAMPLES]) {
                let run = RunOptions {
                    error_bound: true,
                    ..options(stop, method)
                };
                let run = ask(case.signal().unwrap(), &run).run;
                let error = (run.peak_angle_rad - truth.peak_angle_rad).abs();
                assert!(
                    error <= run.numerical_error_rad,
                    "{} {} {method:?}: error {error:e}, stated {:e}",
                    case.name,
                    stop.name(),
                    run.numerical_error_rad
                );
            }
        }
    }
}

#[test]
fn verif_work_counts_are_those_of_the_methods() {
    let signal = silence(0.05, 50);
    let work = |method| {
        let run = RunOptions {
            step_s: Some(1e-4),
            initial: Some(State::new(0.5, 0.0)),
            ..options(StopModel::Rigid, method)
        };
        ask(&signal, &run).run.work
    };
    // 0.05 s before the first impact: 500 steps of four stages, no event.
    for method in [RK4, LOCATED] {
        let work = work(method);
        assert!(
            (500..=501).contains(&work.steps),
            "{}: {work:?}",
            method.name()
        );
        assert_eq!(
            (work.rhs, work.events),
            (4 * work.steps, 0),
            "{}",
            method.name()
        );
    }
    let work = work(DOPRI5);
    assert!(
        work.rhs == 6 * work.steps + 1 && work.events == 0,
        "{work:?}"
    );
}
