//! The event-driven kernel on a smooth sine, against quad-precision runs.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, Method, Run, RunOptions, RunOutcome, Section, State, Strobe};
use latchgate_kernel::units::OpensWhen;
use latchgate_test_support::{json, number};
use std::f64::consts::TAU;

/// Gravity of the quad-precision reference values [m/s²].
const REFERENCE_GRAVITY: f64 = 9.81;

/// a = A g sin(ω t + θ).
fn sine(amplitude: f64, angular_frequency_rad_s: f64, phase_rad: f64, gravity: f64) -> Harmonic {
    Harmonic {
        amplitude_m_s2: amplitude * gravity,
        angular_frequency_rad_s,
        phase_rad,
    }
}

fn from(stop: StopModel, angle: f64, velocity: f64) -> RunOptions {
    RunOptions {
        initial: Some(State::new(angle, velocity)),
        ..RunOptions::new(stop, OpensWhen::Negative)
    }
}

#[track_caller]
fn drive(excitation: &Harmonic, end_s: f64, options: &RunOptions) -> RunOutcome {
    let outcome = replay::run_harmonic(excitation, end_s, &Design::reference(), options).unwrap();
    assert!(!outcome.broke_down);
    outcome
}

#[track_caller]
fn check_near(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!(
        (got - want).abs() <= tolerance,
        "{what}: got {got:e}, want {want:e}, off by {:e}, tolerated {tolerance:e}",
        got - want
    );
}

#[track_caller]
fn check_state(what: &str, run: &Run, want: State, tolerance: f64) {
    check_near(what, run.final_angle_rad, want.angle_rad, tolerance);
    // Around a hundred times the angle's: the motion's own rate.
    let (got, want) = (run.final_velocity_rad_s, want.velocity_rad_s);
    check_near(what, got, want, 1e2 * tolerance);
}

/// ω = 100 rad/s, A = 5, from (0.1, 0): quad-precision states after 10, 20, 50 and 100 periods,
/// with impacts all along the way.
#[test]
fn val_a_hundred_periods_of_a_smooth_sine_to_rounding() {
    let excitation = sine(5.0, 100.0, 0.0, REFERENCE_GRAVITY);
    for (stop, periods, angle, velocity, tolerance) in [
        (
            StopModel::Rigid,
            10.0,
            0.796_270_886_213_893_7,
            -10.515_503_517_365_19,
            1e-11,
        ),
        (
            StopModel::Rigid,
            20.0,
            0.715_517_941_461_530_4,
            -5.888_044_924_937_461,
            1e-11,
        ),
        (
            StopModel::Rigid,
            50.0,
            0.767_773_254_489_410_3,
            -5.162_692_526_416_47,
            1e-11,
        ),
        (
            StopModel::Rigid,
            100.0,
            0.772_335_922_557_793_9,
            -5.197_465_460_241_254,
            1e-11,
        ),
        (
            StopModel::Soft,
            10.0,
            0.388_896_298_956_473_9,
            11.247_880_634_473_441,
            1e-11,
        ),
        (
            StopModel::Soft,
            20.0,
            0.392_945_461_661_060_6,
            25.170_512_594_076_452,
            1e-11,
        ),
        (
            StopModel::Soft,
            50.0,
            0.434_332_035_045_035_26,
            22.392_514_130_523_573,
            1e-11,
        ),
        (
            StopModel::Soft,
            100.0,
            0.432_963_811_810_359_6,
            22.263_608_767_409_526,
            1e-11,
        ),
    ] {
        let run = drive(&excitation, periods * TAU / 100.0, &from(stop, 0.1, 0.0)).run;
        let what = format!("{} after {periods}", stop.name());
        check_state(&what, &run, State::new(angle, velocity), tolerance);
    }
}

/// A lever that all but touches, and the same a millionth of a radian per second faster: the
/// impact that this makes is found, and so is the soft stop's contact of 1e-9 rad.
#[test]
fn val_a_graze_is_told_from_an_impact() {
    let excitation = sine(-5.0, 100.0, 1.0, REFERENCE_GRAVITY);
    for (stop, change, impacts, angle, tolerance) in [
        (StopModel::Rigid, 1e-6, 0, 9.843_747_595_135_812e-3, 1e-14),
        (StopModel::Soft, 1e-6, 0, 9.843_747_595_135_812e-3, 1e-14),
        (StopModel::Rigid, -1e-6, 1, 9.869_295_186_840_881e-3, 1e-11),
        (StopModel::Soft, -1e-6, 1, 9.843_749_261_039_37e-3, 1e-13),
    ] {
        let options = from(
            stop,
            0.004_973_986_935_791_459,
            -1.918_939_039_055_295 + change,
        );
        let run = drive(&excitation, 0.012, &options).run;
        let what = format!("{} {change:e}", stop.name());
        check_near(&what, run.final_angle_rad, angle, tolerance);
        assert_eq!(run.impacts, impacts, "{what}");
        assert!(
            (run.final_angle_rad - angle).abs() <= run.numerical_error_rad,
            "{what}: bound {:e}",
            run.numerical_error_rad
        );
    }
}

/// A = 2, ω = 20 rad/s: the bounces die out within 1e-12 s of the instant at which the torque
/// turns; whichever comes first, the lever leaves at that instant.
#[test]
fn val_chatter_that_meets_the_release() {
    let excitation = sine(2.0, 20.0, 0.0, REFERENCE_GRAVITY);
    for start in [0.050_373_290_101_443_355, 0.050_373_290_101_443_36] {
        let run = drive(&excitation, 0.3, &from(StopModel::Rigid, start, 0.0)).run;
        let end = State::new(0.273_724_164_368_098_55, 1.005_226_848_157_122_2);
        check_state(&format!("from {start}"), &run, end, 1e-11);
    }
}

/// The lever at rest is thrown by the sine at the instant its torque turns, A sin(ω t + θ) =
/// −T0/(m L) on its way down, whatever the sign of A and the phase.
#[test]
fn verif_release_from_rest_is_where_the_torque_turns() {
    let lever = Design::reference().lever;
    let threshold = lever.preload_torque_nm / lever.unbalance_kg_m();
    for (amplitude, turns, want) in [
        // sin x = −threshold/A, falling: x = π + asin(threshold/A).
        (2.0 * threshold, 0.0, 7.0 / 6.0),
        // The negative sine falls at once.
        (-2.0 * threshold, 0.0, 1.0 / 6.0),
        (2.0 * threshold, 0.5, 1.0 / 6.0),
        (2.0 * threshold, -3.5, 1.0 / 6.0),
        (2.0 * threshold, 0.25, 2.0 / 3.0),
        (2.0 * threshold, 100.25, 2.0 / 3.0),
    ] {
        let excitation = Harmonic {
            amplitude_m_s2: amplitude,
            angular_frequency_rad_s: 100.0,
            phase_rad: turns * TAU,
        };
        let options = RunOptions::new(StopModel::Rigid, OpensWhen::Negative);
        let run = drive(&excitation, 0.06, &options).run;
        let what = format!("amplitude {amplitude}, {turns} turns");
        check_near(
            &what,
            run.first_release_s.unwrap(),
            want * 0.01 * std::f64::consts::PI,
            // 100.25 turns are rounded to 1e-13 rad.
            1e-15 + 1e-17 * turns.abs() * TAU,
        );
    }
}

/// Just below the threshold the lever never leaves; a preload of nothing lets go at once.
#[test]
fn verif_release_at_the_edges() {
    let mut design = Design::reference();
    let threshold = design.lever.preload_torque_nm / design.lever.unbalance_kg_m();
    let options = RunOptions::new(StopModel::Rigid, OpensWhen::Negative);
    for (factor, leaves) in [(1.0 - 1e-14, false), (1.0 + 1e-9, true)] {
        let excitation = Harmonic {
            amplitude_m_s2: factor * threshold,
            angular_frequency_rad_s: 20.0,
            phase_rad: 0.0,
        };
        let run = drive(&excitation, 3.0, &options).run;
        assert_eq!(run.first_release_s.is_some(), leaves, "{factor}");
        if leaves {
            // (3π/2 − √(2·1e-9))/ω, to the square root's next order.
            let want = (1.5 * std::f64::consts::PI - 2e-9_f64.sqrt()) / 20.0;
            check_near("release", run.first_release_s.unwrap(), want, 1e-12);
        }
    }
    design.lever.preload_torque_nm = 0.0;
    let excitation = sine(1.0, 20.0, 0.0, REFERENCE_GRAVITY);
    let run = replay::run_harmonic(&excitation, 1.0, &design, &options)
        .unwrap()
        .run;
    let half_turn = std::f64::consts::PI / 20.0;
    check_near("no preload", run.first_release_s.unwrap(), half_turn, 1e-15);
}

/// The same sine in samples, ever closer, comes ever nearer: its error falls with the square of
/// the interval, as that of straight lines must.
#[test]
fn verif_samples_of_the_sine_come_nearer() {
    use latchgate_kernel::signal::Signal;
    use latchgate_kernel::units::SampleRate;
    let excitation = sine(5.0, 100.0, 0.3, REFERENCE_GRAVITY);
    for (stop, opens_when) in [
        (StopModel::Rigid, OpensWhen::Negative),
        (StopModel::Soft, OpensWhen::Positive),
    ] {
        let options = RunOptions {
            opens_when,
            ..from(stop, 0.1, 0.0)
        };
        let exact = drive(&excitation, 0.1, &options).run.final_angle_rad;
        let error = |intervals: u32| {
            use latchgate_kernel::model::excitation::Excitation;
            let rate_hz = f64::from(intervals) / 0.1;
            let signal = Signal {
                start_s: 0.0,
                rate: SampleRate::from_hertz(rate_hz).unwrap(),
                samples: (0..=intervals)
                    .map(|i| excitation.acceleration(f64::from(i) / rate_hz))
                    .collect(),
            };
            let run = replay::run(&signal, &Design::reference(), &options)
                .unwrap()
                .run;
            (run.final_angle_rad - exact).abs()
        };
        let (coarse, fine) = (error(1_000), error(10_000));
        assert!(
            (60.0..160.0).contains(&(coarse / fine)),
            "{}: {coarse:e} against {fine:e}",
            stop.name()
        );
    }
}

/// Event-driven and adaptive runs agree, and the former needs an order of magnitude less work.
#[test]
fn verif_agrees_with_the_adaptive_pair() {
    let excitation = sine(5.0, 100.0, 0.0, REFERENCE_GRAVITY);
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let options = from(stop, 0.1, 0.0);
        let adaptive = RunOptions {
            method: Method::Dopri5 { at_samples: false },
            tolerance_rad: Some(1e-14),
            ..options.clone()
        };
        let (kernel, pair) = (
            drive(&excitation, 1.0, &options).run,
            drive(&excitation, 1.0, &adaptive).run,
        );
        check_near(
            stop.name(),
            kernel.peak_angle_rad,
            pair.peak_angle_rad,
            1e-8,
        );
        assert_eq!(kernel.impacts, pair.impacts);
        assert!(kernel.work.steps * 10 < pair.work.steps);
    }
}

/// The three histories of the paper's Fig. 10: impacts and where they end, both stops and both
/// values of gravity.
#[test]
fn val_histories_agree_with_quad_precision() {
    let cases = json("reference/fig10.json");
    for (name, case) in cases.as_object().unwrap() {
        let words: Vec<&str> = name.split([' ', '=']).collect();
        let stop = if words[0] == "rigid" {
            StopModel::Rigid
        } else {
            StopModel::Soft
        };
        let excitation = sine(1.0, 100.0, 0.0, words[4].parse().unwrap());
        let options = from(stop, words[2].parse().unwrap(), 0.0);
        let periods = 400.0 * TAU / 100.0;
        let run = drive(&excitation, periods, &options).run;
        let impacts = case["first_impacts"].as_array().unwrap();
        for (got, want) in run.impact_list.iter().zip(impacts) {
            check_near(name, got[0], number(&want[0]), 1e-12);
            check_near(name, got[1], number(&want[1]), 1e-9);
        }
        let section = case["section"].as_array().unwrap();
        let nearest = section
            .iter()
            .map(|state| {
                let angle = run.final_angle_rad - number(&state[0]);
                let velocity = run.final_velocity_rad_s - number(&state[1]);
                angle.abs().max(1e-2 * velocity.abs())
            })
            .fold(f64::INFINITY, f64::min);
        assert!(nearest <= 1e-11, "{name}: {nearest:e} off its attractor");
    }
}

/// ω = 100 rad/s, A g in its own unit, at the phase of a stroboscope.
fn strobe(stop: StopModel, amplitude: f64, start: State) -> Strobe {
    let excitation = sine(amplitude, 100.0, 0.0, REFERENCE_GRAVITY);
    Strobe::new(&Design::reference(), stop, &excitation, Some(start)).unwrap()
}

fn run_periods(strobe: &mut Strobe, periods: u32) -> Section {
    (0..periods)
        .map(|_| strobe.advance().unwrap())
        .last()
        .unwrap()
}

/// A stroboscope sees what a run over as many periods ends in, impacts and peak included.
#[test]
fn verif_a_stroboscope_sees_the_run() {
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let excitation = sine(5.0, 100.0, 0.0, REFERENCE_GRAVITY);
        let run = drive(&excitation, 20.0 * TAU / 100.0, &from(stop, 0.1, 0.0)).run;
        let mut strobe = strobe(stop, 5.0, State::new(0.1, 0.0));
        let sections: Vec<Section> = (0..20).map(|_| strobe.advance().unwrap()).collect();
        let last = sections.last().unwrap();
        check_near(stop.name(), last.angle_rad, run.final_angle_rad, 1e-12);
        let impacts: u64 = sections.iter().map(|section| section.impacts).sum();
        assert_eq!(impacts, run.impacts);
        let peak = sections
            .iter()
            .map(|section| section.peak_angle_rad)
            .fold(0.0, f64::max);
        check_near(stop.name(), peak, run.peak_angle_rad, 1e-12);
    }
}

/// Derivatives over a period with impacts agree with differences, and the excitation's with
/// those of the amplitude.
#[test]
fn verif_derivatives_agree_with_differences() {
    const STEP: f64 = 1e-4;
    for stop in [StopModel::Rigid, StopModel::Soft] {
        for start in [State::new(0.069, 2.7), State::new(0.3, -4.0)] {
            let end = |angle: f64, velocity: f64, factor: f64| {
                let moved = State::new(start.angle_rad + angle, start.velocity_rad_s + velocity);
                let mut strobe = strobe(stop, factor, moved);
                let section = run_periods(&mut strobe, 2);
                [section.angle_rad, section.velocity_rad_s]
            };
            // Of fourth order in the step.
            let slope = |of: &dyn Fn(f64) -> [f64; 2], row: usize, step: f64| {
                let at = |n: f64| of(n * step)[row];
                (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * step)
            };
            let mut exact = strobe(stop, 1.0, start);
            exact.start_map();
            run_periods(&mut exact, 2);
            let map = exact.map().unwrap();
            for row in 0..2 {
                let what = format!("{} from {start:?}, row {row}", stop.name());
                let by_angle = slope(&|x| end(x, 0.0, 1.0), row, 0.1 * STEP);
                let by_velocity = slope(&|x| end(0.0, x, 1.0), row, STEP);
                let by_amplitude = slope(&|x| end(0.0, 0.0, 1.0 + x), row, 0.1 * STEP);
                let scale = 1e-8 * (1.0 + by_angle.abs().max(by_velocity.abs()));
                check_near(&what, map.by_state[row][0], by_angle, scale);
                check_near(&what, map.by_state[row][1], by_velocity, scale);
                check_near(&what, map.by_amplitude[row], by_amplitude, scale);
            }
        }
    }
}

/// Liouville: with one impact a period on the rigid stop the map's determinant is
/// R² exp(−c0 T/I0), whatever the orbit.
#[test]
fn verif_the_map_shrinks_areas_as_it_must() {
    let design = Design::reference();
    let mut strobe = strobe(StopModel::Rigid, 1.0, State::new(0.0702, 2.7159));
    for _ in 0..5 {
        strobe.start_map();
        let section = strobe.advance().unwrap();
        assert_eq!(section.impacts, 1);
        let [[a, b], [c, d]] = strobe.map().unwrap().by_state;
        let lever = &design.lever;
        let decay = -lever.pivot_damping_nm_s_per_rad * TAU / 100.0 / lever.moment_of_inertia_kg_m2;
        let want = design.stop.restitution.powi(2) * decay.exp();
        check_near("determinant", a * d - b * c, want, 1e-13);
    }
}

/// A lever that rests forgets where it came from.
#[test]
fn verif_rest_wipes_out_every_difference() {
    let mut strobe = strobe(StopModel::Rigid, 1.0, State::new(0.56, 0.0));
    strobe.start_map();
    let section = run_periods(&mut strobe, 60);
    assert_eq!((section.angle_rad, section.velocity_rad_s), (0.0, 0.0));
    assert_eq!(strobe.map().unwrap().by_state, [[0.0; 2]; 2]);
}

#[test]
fn verif_a_stroboscope_refuses_what_it_cannot_do() {
    let design = Design::reference();
    let good = sine(1.0, 100.0, 0.0, REFERENCE_GRAVITY);
    let refused = |excitation: &Harmonic, start| {
        Strobe::new(&design, StopModel::Rigid, excitation, Some(start)).is_err()
    };
    let start = State::new(0.1, 0.0);
    assert!(!refused(&good, start));
    assert!(refused(&good, State::new(-0.1, 0.0)));
    assert!(refused(&good, State::new(0.1, f64::NAN)));
    for frequency in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&sine(1.0, frequency, 0.0, 9.81), start));
    }
    assert!(refused(&sine(f64::NAN, 100.0, 0.0, 9.81), start));
}
