//! A run of which the peak alone is needed ends early only where neither the lever's energy nor the
//! impulse still to come can raise the peak.
//!
//! The pushes lie about those that just reach the peak so far, so that a bound that counts less
//! than all of the energy or the impulse ends a run that would have gone on to a higher peak. The
//! whole run, which never ends early, is what the short ones are compared with.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, Member, SensorView};
use latchgate_kernel::replay::{self, RunOptions, State};
use latchgate_kernel::signal::{Projection, Reading, Signal};
use latchgate_kernel::units::{OpensWhen, SampleRate};

const RATE_HZ: f64 = 10_000.0;

/// Part of the peak that the truncation of a run without a stated error may change. A run that ends too
/// early is off by a thousand times as much.
const TRUNCATED: f64 = 1e-12;

/// Zeros but for impulses, each a triangle one sample high: sample, ∫a dt [m/s].
fn impulses(impulses: &[(usize, f64)]) -> Signal {
    let mut samples = vec![0.0; 4000];
    for (sample, impulse_m_s) in impulses {
        samples[*sample] = impulse_m_s * RATE_HZ;
    }
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(RATE_HZ).unwrap(),
        samples,
    }
}

/// The paper's lever without spring and dampers: all its energy is that of speed, preload and stop.
fn lossless_design(preload_torque_nm: f64) -> Design {
    let mut design = Design::reference();
    design.lever.preload_torque_nm = preload_torque_nm;
    design.lever.spring_stiffness_nm_per_rad = 0.0;
    design.lever.pivot_damping_nm_s_per_rad = 0.0;
    design.stop.damping_n_s_per_m = 0.0;
    design
}

/// Returns the impulse [m/s] that changes the lever's angular velocity by that which holds this energy [J].
fn impulse_m_s(design: &Design, energy_j: f64) -> f64 {
    let inertia = design.lever.moment_of_inertia_kg_m2;
    (2.0 * energy_j * inertia).sqrt() / design.lever.unbalance_kg_m()
}

/// Runs whole, for the peak alone and as a member of a batch that needs peaks from `from_rad` on; returns
/// true if the lever rises beyond that angle.
#[track_caller]
fn check_short_runs_find_the_peak(
    what: &str,
    reading: &Reading<'_>,
    design: &Design,
    options: &RunOptions,
    from_rad: f64,
) -> bool {
    let whole = replay::run(reading, design, options).unwrap().run;
    let (peak, stated) = (whole.peak_angle_rad, whole.numerical_error_rad);
    let allowed = 2.0 * stated + TRUNCATED * peak;
    for error_bound in [true, false] {
        let peak_only = RunOptions {
            error_bound,
            peak_only: true,
            ..options.clone()
        };
        let alone = replay::run(reading, design, &peak_only).unwrap().run;
        let off = (alone.peak_angle_rad - peak).abs();
        assert!(
            off <= allowed,
            "{what}: the peak alone is off by {off:e}, stated {stated:e}"
        );
    }
    let batch_options = BatchOptions {
        stop: options.stop,
        projection: Projection::ALIGNED,
        opens_when: options.opens_when,
        initial: options.initial,
        window: None,
        coast: false,
        asked: AskedPeaks {
            from_rad,
            to_rad: f64::INFINITY,
        },
        threshold_rad: f64::INFINITY,
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
    let found = batch::peaks(reading, 1, &member, &batch_options).unwrap()[0].peak_angle_rad;
    let rises = peak > from_rad;
    if rises {
        let off = (found - peak).abs();
        assert!(
            off <= allowed,
            "{what}: the member is off by {off:e}, stated {stated:e}"
        );
    } else {
        assert!(found <= from_rad, "{what}: the member comes to {found}");
    }
    rises
}

/// A lever falls from a low peak into an undamped soft stop, is braked there to less energy than its peak
/// needs, and is thrown out as it passes its place of rest on the way up. At that place
/// its energy is that of speed alone, and counts in full only together with what the stop holds,
/// T0²/(2 kR): √(2E/I0) grows by all of the impulse.
#[test]
fn verif_a_run_ends_early_only_beyond_what_a_compressed_soft_stop_may_give_back() {
    /// The peak before the stop [rad].
    const PEAK_RAD: f64 = 0.002;
    /// Part of what the lever has that the brake leaves.
    const LEFT: f64 = 2.0 / 7.0;
    let mut design = lossless_design(1.0);
    design.stop.stiffness_n_per_m = 1e4;
    let (lever, stop) = (&design.lever, &design.stop);
    let torque = lever.preload_torque_nm;
    let held_j = 0.5 * torque * torque / stop.contact_stiffness_nm_per_rad(lever);
    let needed_j = held_j + torque * PEAK_RAD;
    let root = |energy_j: f64| impulse_m_s(&design, energy_j);
    let brake = root(needed_j) - root(LEFT * needed_j);
    let reaches = root(needed_j) - root(LEFT * needed_j);

    // From the peak to the stop, then from the stop to the place of rest on the way up.
    let falls_s = (2.0 * PEAK_RAD * lever.moment_of_inertia_kg_m2 / torque).sqrt();
    let frequency = stop.contact_angular_frequency_rad_s(lever);
    let entry_phase = (held_j / needed_j).sqrt().acos();
    let rises_s = (1.5 * std::f64::consts::PI - entry_phase) / frequency;
    let period_s = std::f64::consts::TAU / frequency;
    let sample = |time_s: f64| (time_s * RATE_HZ).round() as usize;
    let brake_at = sample(falls_s + rises_s);

    let (mut beyond, mut below) = (0, 0);
    for opens_when in [OpensWhen::Negative, OpensWhen::Positive] {
        let options = RunOptions {
            initial: Some(State::new(PEAK_RAD, 0.0)),
            ..RunOptions::new(StopModel::Soft, opens_when)
        };
        for turns in 1..4 {
            let push_at = sample(falls_s + rises_s + f64::from(turns) * period_s);
            for percent in 90..130 {
                let push = reaches * f64::from(percent) / 100.0;
                let sign = opens_when.sign();
                let signal = impulses(&[(brake_at, sign * brake), (push_at, -sign * push)]);
                let what = format!("{opens_when:?}, {turns} turns, {percent} %");
                let reading = Reading::from(&signal);
                let rises =
                    check_short_runs_find_the_peak(&what, &reading, &design, &options, PEAK_RAD);
                // A percent of the impulse is more than what falls between two samples.
                assert!(percent > 99 || !rises, "{what}: beyond the energy");
                assert!(percent < 103 || rises, "{what}: the energy suffices");
                beyond += u32::from(rises);
                below += u32::from(!rises);
            }
        }
    }
    assert!(beyond > 60 && below > 30, "{beyond} beyond, {below} below");
}

/// What acts across the lever's way throws a lever that stands across its stop's face, where nothing along the
/// way could: at a quarter and three quarters of a turn, outwards and inwards.
#[test]
fn verif_a_run_ends_early_only_beyond_the_impulse_of_both_sensors() {
    use std::f64::consts::PI;
    let design = lossless_design(0.1);
    let torque = design.lever.preload_torque_nm;
    let (mut beyond, mut below) = (0, 0);
    for stop in [StopModel::Rigid, StopModel::Soft] {
        for (start_rad, outwards) in [(0.5 * PI, 1.0), (1.5 * PI, -1.0)] {
            let from_rad = start_rad + 4.5;
            let options = RunOptions {
                initial: Some(State::new(start_rad, 0.0)),
                ..RunOptions::new(stop, OpensWhen::Negative)
            };
            let reaches = impulse_m_s(&design, torque * 4.5);
            for push_at in [40, 130, 200] {
                // The lever falls until then, and has its fall to make up for.
                let fall_s = push_at as f64 / RATE_HZ;
                let fall_m_s = torque * fall_s / design.lever.unbalance_kg_m();
                for percent in (40..140).step_by(5) {
                    let push = outwards * (reaches * f64::from(percent) / 100.0 + fall_m_s);
                    let tangential = impulses(&[]);
                    let radial = impulses(&[(push_at, push)]);
                    let reading = Reading::from(&tangential).beside((&radial).into()).unwrap();
                    let what = format!("{stop:?}, {start_rad}, sample {push_at}, {percent} %");
                    let rises = check_short_runs_find_the_peak(
                        &what, &reading, &design, &options, from_rad,
                    );
                    beyond += u32::from(rises);
                    below += u32::from(!rises);
                }
            }
        }
    }
    assert!(beyond > 50 && below > 50, "{beyond} beyond, {below} below");
}
