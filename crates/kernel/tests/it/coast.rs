//! Guards the coast after the record's end: it is the same motion as under zeros, and it is
//! known as well.
//!
//! Steps of a coast are long. In a soft contact the terms of so long a step grow far beyond
//! the angle before they fall; a truncation relative to their sum let an error of a tenth of a
//! radian stand in the coast's bound, enough to make a pass undecided.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::catch::Catch;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::pulse::Pulse;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, Member, SensorView};
use latchgate_kernel::replay::{self, Breakdown, RunOptions, RunOutcome, State, Within};
use latchgate_kernel::signal::{Projection, Signal};
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
    // The same motion is as uncertain, but for what shorter steps round more often.
    let ratio = coasting.coast_error_rad / replayed.numerical_error_rad;
    assert!(
        (0.5..=2.0).contains(&ratio),
        "coast known to {:e} rad, under zeros to {:e}",
        coasting.coast_error_rad,
        replayed.numerical_error_rad
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

/// Zeros [m/s²].
fn silence(samples: usize) -> Signal {
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(RATE_HZ).unwrap(),
        samples: vec![0.0; samples],
    }
}

/// A lever without dampers, thrown up at the end of a record of zeros, comes to
/// √((φ + T0/k0)² + ω²I0/k0) − T0/k0. The stated error covers what the coast is off; over so many levers some
/// are off by a rounding at least.
#[test]
fn verif_the_error_of_a_coast_covers_the_closed_form() {
    let mut worst = 0.0_f64;
    for stop in [StopModel::Rigid, StopModel::Soft] {
        for step in 0..60 {
            let mut design = Design::reference();
            let lever = &mut design.lever;
            lever.pivot_damping_nm_s_per_rad = 0.0;
            lever.spring_stiffness_nm_per_rad = 0.2 + 0.01 * f64::from(step);
            let (angle, velocity) = (0.01, 2.0 + 0.3 * f64::from(step));
            let initial = Some(State::new(angle, velocity));
            let options = RunOptions {
                initial,
                window: Some((0, 1)),
                ..RunOptions::new(stop, OpensWhen::Negative)
            };
            let outcome = replay::run(silence(2), &design, &options).unwrap();
            let level = design.lever.preload_torque_nm / design.lever.spring_stiffness_nm_per_rad;
            let swing = velocity / design.lever.angular_frequency_rad_s();
            let peak = (angle + level).hypot(swing) - level;
            let off = (outcome.run.coast_peak_angle_rad.unwrap() - peak).abs();
            let rounded = 2.0 * f64::EPSILON * (peak + level);
            let stated = outcome.coast_error_rad;
            assert!(
                off <= stated + rounded,
                "{stop:?}, {velocity} rad/s: off by {off:e}, stated {stated:e}"
            );
            // No peak is known beyond the last digit of its number.
            assert!(
                stated >= f64::EPSILON * peak,
                "{stop:?}, {velocity} rad/s: stated {stated:e}"
            );
            worst = worst.max(stated / peak);
        }
    }
    assert!(worst < 1e-12, "known to {worst:e} of the peak only");
}

/// A short push under white noise throws a lever far beyond where its record ends. Without spring and dampers
/// the peak moves by δφ + (I0 ω/T0) δω, and the noise q of the angular acceleration leaves behind
/// var δφ = q t³/3, cov = q t²/2 and var δω = q t. Stated is at least that; at most what the same noise leaves
/// behind that goes on through the coast, q (t + I0 ω/T0)³/3.
#[test]
fn verif_the_noise_of_a_coast_is_that_of_the_closed_form() {
    const NOISE_M2_S3: f64 = 1e-6;
    const PUSH_M_S2: f64 = 200.0;
    const SAMPLES: usize = 21;
    let mut design = Design::reference();
    let lever = &mut design.lever;
    lever.pivot_damping_nm_s_per_rad = 0.0;
    lever.spring_stiffness_nm_per_rad = 0.0;
    let gain = lever.unbalance_kg_m() / lever.moment_of_inertia_kg_m2;
    let pressing = lever.preload_torque_nm / lever.moment_of_inertia_kg_m2;
    let time = (SAMPLES - 1) as f64 / RATE_HZ;
    let (start_rad, start_rad_s) = (0.001, 1.0);
    let end_rad_s = start_rad_s + (gain * PUSH_M_S2 - pressing) * time;
    let arm = end_rad_s / pressing;
    let spectral = NOISE_M2_S3 * gain * gain;
    let variance = spectral * (time.powi(3) / 3.0 + arm * time * time + arm * arm * time);
    let least = variance.sqrt();
    let most = (spectral * (time + arm).powi(3) / 3.0).sqrt();
    let in_window = (spectral * time.powi(3) / 3.0).sqrt();
    assert!(least > 30.0 * in_window, "the coast is to decide");
    for stop in [StopModel::Rigid, StopModel::Soft] {
        for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
            let mut signal = silence(SAMPLES);
            signal.samples.fill(opens_when.sign() * -PUSH_M_S2);
            let options = RunOptions {
                initial: Some(State::new(start_rad, start_rad_s)),
                noise_m2_s3: Some(NOISE_M2_S3),
                ..RunOptions::new(stop, opens_when)
            };
            let outcome = replay::run(&signal, &design, &options).unwrap();
            assert!(outcome.run.coast_peak_angle_rad.unwrap() > outcome.run.peak_angle_rad);
            let stated = outcome.deviation_rad.unwrap();
            // The cosine of the angle takes a thousandth.
            assert!(
                0.99 * least <= stated && stated <= 1.01 * most,
                "{stop:?}, {opens_when:?}: {stated:e}, not {least:e} to {most:e}"
            );
        }
    }
}

/// A lever that falls at the end of its record faster than it ever rose: only a coast through the stop shows how
/// far it comes.
fn falling(stop: StopModel) -> RunOptions {
    RunOptions {
        initial: Some(State::new(0.05, -20.0)),
        window: Some((0, 3)),
        ..RunOptions::new(stop, OpensWhen::Negative)
    }
}

fn member_of(design: &Design, options: &RunOptions, within: &Within<'_>) -> batch::MemberPeak {
    let batch_options = BatchOptions {
        stop: options.stop,
        projection: Projection::ALIGNED,
        opens_when: options.opens_when,
        initial: options.initial,
        window: options.window,
        coast: true,
        asked: AskedPeaks::ALL,
        threshold_rad: f64::INFINITY,
        threads: 1,
    };
    let member = |_: usize| Member {
        lever: design.lever,
        stop: design.stop,
        scale: 1.0,
        bias_m_s2: 0.0,
        second: SensorView::default(),
        catch: design.catch,
    };
    batch::peaks_within(silence(4), 1, &member, &batch_options, within).unwrap()[0]
}

#[track_caller]
fn check_coast_is_lost(
    what: &str,
    outcome: &RunOutcome,
    why: Breakdown,
    member: &batch::MemberPeak,
) {
    assert!(outcome.run.moving_at_end, "{what}: there is a coast");
    assert_eq!(outcome.run.coast_peak_angle_rad, None, "{what}");
    assert!(outcome.broke_down, "{what}: no breakdown");
    assert_eq!(outcome.breakdown, Some(why), "{what}");
    assert!(member.highest_rad().is_nan(), "{what}: {member:?}");
}

/// A coast that could not be followed to its end says nothing of how far the lever comes: the run broke down,
/// and a member has no highest angle. In the window itself both were followed.
#[test]
fn verif_a_coast_that_could_not_be_followed_is_a_breakdown() {
    let idle_catch = Catch {
        moment_of_inertia_kg_m2: 1e-6,
        unbalance_kg_m: 1e-5,
        preload_torque_nm: 0.01,
        engagement_angle_rad: 0.1,
        end_stop_angle_rad: 0.2,
        lever_angle_rad: 10.0,
        ..Catch::default()
    };
    for stop in [StopModel::Rigid, StopModel::Soft] {
        for catch in [None, Some(idle_catch)] {
            let what = format!("{stop:?}, beside {catch:?}");
            let design = Design {
                catch,
                ..Design::reference()
            };
            let options = falling(stop);
            let whole = replay::run(silence(4), &design, &options).unwrap();
            assert!(!whole.broke_down && whole.run.coast_peak_angle_rad.is_some());
            assert!(member_of(&design, &options, &Within::UNBOUNDED).highest_rad() > 0.05);
            let within = Within {
                steps_max: whole.run.work.counted() + 1,
                ..Within::UNBOUNDED
            };
            let cut = replay::run_within(silence(4), &design, &options, &within).unwrap();
            let member = member_of(&design, &options, &within);
            assert_eq!(cut.run.peak_angle_rad, whole.run.peak_angle_rad, "{what}");
            check_coast_is_lost(&what, &cut, Breakdown::TooManySteps, &member);
        }
    }
    // In such a stop the first stretch of the coast takes more steps than a stretch may.
    let mut design = Design::reference();
    design.stop.damping_n_s_per_m = 1e12;
    let options = falling(StopModel::Soft);
    let outcome = replay::run(silence(4), &design, &options).unwrap();
    let member = member_of(&design, &options, &Within::UNBOUNDED);
    check_coast_is_lost(
        "a stop too damped",
        &outcome,
        Breakdown::TooManyEvents,
        &member,
    );
}
