//! Levers, stops and signals, given and random.

use super::Random;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, RunOptions, RunOutcome};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, SampleRate};

/// A signal that starts at `start_s`.
pub fn signal_from(rate_hz: f64, start_s: f64, samples: Vec<f64>) -> Signal {
    Signal {
        start_s,
        rate: SampleRate::from_hertz(rate_hz).unwrap(),
        samples,
    }
}

/// A signal that starts at time zero.
pub fn signal(rate_hz: f64, samples: Vec<f64>) -> Signal {
    signal_from(rate_hz, 0.0, samples)
}

/// Options of a nominal run with the trajectory kept.
pub fn options(stop: StopModel) -> RunOptions {
    RunOptions {
        trace: true,
        ..RunOptions::new(stop, OpensWhen::Negative)
    }
}

#[track_caller]
pub fn replay(signal: &Signal, design: &Design, options: &RunOptions) -> RunOutcome {
    replay::run(signal, design, options).unwrap()
}

/// A lever within a factor of a few of the reference, any restitution, and now and then one
/// quantity at the end of its range.
pub fn random_design(random: &mut Random) -> Design {
    let mut design = Design::reference();
    let lever = &mut design.lever;
    lever.moment_of_inertia_kg_m2 *= random.scale(0.9, 5.0);
    lever.pivot_damping_nm_s_per_rad *= random.scale(0.1, 10.0);
    lever.spring_stiffness_nm_per_rad *= random.scale(0.2, 5.0);
    lever.preload_torque_nm *= random.scale(0.1, 10.0);
    lever.mass_kg *= random.scale(0.5, 1.0);
    design.stop.restitution = random.between(0.05, 0.95);
    design.stop.stiffness_n_per_m *= random.scale(0.05, 5.0);
    design.stop.damping_n_s_per_m *= random.scale(0.1, 5.0);
    match random.below(16) {
        0 => design.stop.restitution = 0.0,
        1 => design.stop.restitution = 0.99,
        2 => design.lever.preload_torque_nm = 0.0,
        3 => design.lever.spring_stiffness_nm_per_rad = 0.0,
        4 => design.lever.pivot_damping_nm_s_per_rad = 0.0,
        5 => design.stop.damping_n_s_per_m = 0.0,
        6 => design.stop.damping_n_s_per_m = 3000.0,
        7 => {
            design.lever.spring_stiffness_nm_per_rad = 0.0;
            design.lever.pivot_damping_nm_s_per_rad = 0.0;
        }
        _ => {}
    }
    design
}

/// A recording of 2 to `longest` samples: noise, pulse, burst, spike, plateau or ramp, of
/// `weakest` to `strongest` m/s².
pub fn random_signal(random: &mut Random, longest: usize, weakest: f64, strongest: f64) -> Signal {
    let count = 2 + random.below(longest - 1);
    let rate = match random.below(4) {
        0 => random.scale(250.0, 1e6).round(),
        1 => 12_500.0,
        _ => 10_000.0,
    };
    let amplitude = random.scale(weakest, strongest);
    let (phase, cycles) = (random.between(0.0, 6.3), random.scale(0.5, 20.0));
    let kind = random.below(6);
    let place = random.below(count);
    let samples = (0..count)
        .map(|k| {
            let x = k as f64 / count as f64;
            let shape = match kind {
                0 => random.between(-1.0, 1.0),
                1 => -libm::sin(std::f64::consts::PI * x),
                2 => {
                    libm::sin(std::f64::consts::PI * x).powi(2)
                        * libm::sin(std::f64::consts::TAU * cycles * x + phase)
                }
                3 => f64::from(u8::from(k == place)) * if phase > 1.0 { -1.0 } else { 1.0 },
                4 => -f64::from(u8::from(k >= place)),
                _ => 0.2 - x,
            };
            amplitude * shape
        })
        .collect();
    signal(rate, samples)
}
