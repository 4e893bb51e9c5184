//! Recordings made by formula, as a sensor with noise, an offset and a grid would give them.

use super::Chance;
use latchgate_kernel::pulse::Pulse;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{STANDARD_GRAVITY, SampleRate};
use std::f64::consts::TAU;

/// A body that rings after the impact: amplitude [g], frequency [Hz], decay [s], onset [s], phase.
type Mode = [f64; 5];

/// Returns a lateral crash channel whose negative side opens: a push of 20 to 80 ms, up to six modes
/// of the structure that ring after it, and a slow residual motion.
pub(super) fn recording(chance: &mut Chance) -> Signal {
    let rate_hz = [10_000.0, 12_500.0, 20_000.0][(chance.next() % 3) as usize];
    let start_s = -[0.02, 0.03, 0.05][(chance.next() % 3) as usize];
    let end_s = chance.between(0.12, 0.25);
    let width = chance.between(0.02, 0.08);
    let velocity = chance.scale(0.8, 8.0);
    let onset = chance.between(0.0, 0.004);
    let modes: Vec<Mode> = (0..1 + chance.next() % 6)
        .map(|_| {
            [
                chance.scale(3.0, 60.0),
                chance.scale(60.0, 1_200.0),
                chance.between(0.004, 0.03),
                chance.between(0.0, 0.008),
                chance.between(0.0, TAU),
            ]
        })
        .collect();
    let (residual_g, slow) = (chance.between(-0.6, 0.6), chance.between(4.0, 15.0));
    let offset = chance.between(-0.4, 0.4);
    // One channel of ten is coarse: its noise is near one step of its grid.
    let noise = chance.scale(0.02, 0.4);
    let quantum = match chance.next() % 10 {
        0 => noise / chance.scale(0.4, 2.0),
        _ => noise / chance.scale(4.0, 200.0),
    };
    let memory = chance.between(0.0, 0.8);
    let push = Pulse::Haversine {
        peak: -2.0 * velocity / width / STANDARD_GRAVITY,
        duration_s: width,
    };
    let motion = |t: f64| {
        if t < onset {
            return 0.0;
        }
        let mut value = push.at(t - onset);
        for [amplitude, frequency, decay, begin, phase] in &modes {
            let since = t - onset - begin;
            if since > 0.0 {
                let rise = 1.0 - libm::exp(-since / 5e-4);
                let ring = libm::sin(TAU * frequency * since + phase);
                value += amplitude * rise * libm::exp(-since / decay) * ring;
            }
        }
        let since = t - onset;
        value + residual_g * libm::sin(TAU * slow * since) * (1.0 - libm::exp(-since / 0.02))
    };
    let count = ((end_s - start_s) * rate_hz) as usize;
    let mut wander = 0.0;
    let samples = (0..count)
        .map(|index| {
            let fresh = chance.normal();
            wander = memory * wander + (1.0 - memory * memory).sqrt() * fresh;
            let value = motion(start_s + index as f64 / rate_hz) + offset + noise * wander;
            (value / quantum).round() * quantum * STANDARD_GRAVITY
        })
        .collect();
    Signal {
        start_s,
        rate: SampleRate::from_hertz(rate_hz).expect("a positive rate"),
        samples,
    }
}
