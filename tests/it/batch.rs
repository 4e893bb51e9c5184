//! Batches of levers against the scalar kernel, which they must agree with to its stated error,
//! whatever the neighbours and the threads.

use latchgate::conditioning::Signal;
use latchgate::model::Design;
use latchgate::model::stop::StopModel;
use latchgate::replay::batch::{self, BatchOptions, Member, MemberPeak};
use latchgate::replay::{self, RunOptions};
use latchgate::units::{OpensWhen, SampleRate};

/// A decaying burst of a few tones [m/s²], like a door's.
fn burst(amplitude: f64, samples: usize) -> Signal {
    let rate = 10_000.0;
    let value = |k: usize| {
        let t = k as f64 / rate;
        let tones: f64 = (1..=12)
            .map(|j| {
                libm::sin(
                    std::f64::consts::TAU * (20.0 * f64::from(j) * t + 0.618 * f64::from(j * j)),
                )
            })
            .sum();
        amplitude * t / 0.02 * libm::exp(1.0 - t / 0.02) * tones
    };
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate).unwrap(),
        samples: (0..samples).map(value).collect(),
    }
}

/// Members spread over preload, stiffness, restitution, scale and bias.
fn member(index: usize) -> Member {
    let design = Design::reference();
    let part = |step: f64| (index as f64 * step).fract();
    let mut lever = design.lever;
    let mut stop = design.stop;
    lever.preload_torque_nm *= 0.5 + 2.0 * part(0.618_034);
    lever.spring_stiffness_nm_per_rad *= 0.5 + part(0.414_214);
    stop.restitution = 0.5 + 0.45 * part(0.732_051);
    Member {
        lever,
        stop,
        scale: 0.9 + 0.2 * part(0.236_068),
        bias_m_s2: part(0.302_776) - 0.5,
    }
}

fn options(stop: StopModel, threads: usize) -> BatchOptions {
    BatchOptions {
        stop,
        opens_when: OpensWhen::Negative,
        initial: None,
        window: None,
        coast: true,
        threads,
    }
}

/// Runs one member by the scalar kernel.
fn scalar(signal: &Signal, index: usize, stop: StopModel) -> replay::Outcome {
    let member = member(index);
    let mut seen = signal.clone();
    for a in &mut seen.samples {
        *a = member.scale * *a + member.bias_m_s2;
    }
    let design = Design {
        lever: member.lever,
        stop: member.stop,
        ..Design::reference()
    };
    replay::run(&seen, &design, &RunOptions::new(stop, OpensWhen::Negative)).unwrap()
}

#[track_caller]
fn check_agrees(amplitude: f64, stop: StopModel) {
    let signal = burst(amplitude, 1500);
    let count = 203;
    let peaks = batch::peaks(&signal, count, &member, &options(stop, 1)).unwrap();
    assert_eq!(peaks.len(), count);
    for (index, peak) in peaks.iter().enumerate() {
        let one = scalar(&signal, index, stop);
        let bound = 4.0 * one.run.numerical_error_rad + 1e-13;
        let off = (peak.peak_angle_rad - one.run.peak_angle_rad).abs();
        assert!(
            off <= bound,
            "member {index} at {amplitude} m/s², {stop:?}: off by {off:e}, bound {bound:e}"
        );
        assert_eq!(
            peak.coast_peak_angle_rad.is_some(),
            one.run.coast_peak_angle_rad.is_some(),
            "member {index}"
        );
    }
}

#[test]
fn verif_rigid_members_agree_with_the_scalar_kernel() {
    for amplitude in [5.0, 30.0, 300.0] {
        check_agrees(amplitude, StopModel::Rigid);
    }
}

#[test]
fn verif_soft_members_agree_with_the_scalar_kernel() {
    for amplitude in [5.0, 30.0, 300.0] {
        check_agrees(amplitude, StopModel::Soft);
    }
}

/// A member's digits depend on nothing but the member.
#[test]
fn verif_threads_and_neighbours_change_no_digit() {
    let signal = burst(60.0, 800);
    let bits = |peaks: &[MemberPeak]| -> Vec<u64> {
        peaks
            .iter()
            .map(|peak| peak.peak_angle_rad.to_bits())
            .collect()
    };
    let one = batch::peaks(&signal, 600, &member, &options(StopModel::Rigid, 1)).unwrap();
    let three = batch::peaks(&signal, 600, &member, &options(StopModel::Rigid, 3)).unwrap();
    assert_eq!(bits(&one), bits(&three));
    // The same members in another order, so that every lane has other neighbours.
    let reversed = batch::peaks(
        &signal,
        600,
        &|index| member(599 - index),
        &options(StopModel::Rigid, 2),
    )
    .unwrap();
    let mut back = bits(&reversed);
    back.reverse();
    assert_eq!(bits(&one), back);
}

/// Plain flight is taken side by side: few samples fall to the scalar kernel.
#[test]
fn verif_flight_needs_the_scalar_kernel_seldom() {
    let signal = burst(300.0, 1500);
    let peaks = batch::peaks(&signal, 64, &member, &options(StopModel::Rigid, 1)).unwrap();
    let scalar: u32 = peaks.iter().map(|peak| peak.scalar_samples).sum();
    let share = f64::from(scalar) / (64.0 * 1499.0);
    assert!(share < 0.25, "{share}");
}
