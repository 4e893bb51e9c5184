//! Pulses by formula: their areas in closed form, their ends and their samples.

use latchgate_kernel::pulse::Pulse;
use std::f64::consts::PI;

/// Each shape of peak 30 and the mean of its values over its duration, as the integral has it.
fn shapes() -> [(Pulse, f64); 5] {
    let (peak, duration_s) = (30.0, 0.011);
    let trapezoid = Pulse::Trapezoid {
        peak,
        rise_s: 0.002,
        plateau_s: 0.005,
        fall_s: 0.004,
    };
    [
        (Pulse::HalfSine { peak, duration_s }, 60.0 / PI),
        (Pulse::Haversine { peak, duration_s }, 15.0),
        (Pulse::Sawtooth { peak, duration_s }, 15.0),
        (Pulse::Triangle { peak, duration_s }, 15.0),
        (trapezoid, 30.0 * (0.005 + 0.003) / 0.011),
    ]
}

#[test]
fn verif_pulses_have_the_area_of_their_formula() {
    const PARTS: u32 = 110_000;
    for (pulse, mean) in shapes() {
        let middle = |part: u32| (f64::from(part) + 0.5) / f64::from(PARTS) * pulse.duration_s();
        let sum: f64 = (0..PARTS).map(|part| pulse.at(middle(part))).sum();
        let found = sum / f64::from(PARTS);
        assert!((found - mean).abs() < 1e-8, "{pulse:?}: {found}, {mean}");
    }
}

#[test]
fn verif_pulses_are_zero_outside_and_peak_inside() {
    for (pulse, _) in shapes() {
        assert_eq!(pulse.duration_s(), 0.011, "{pulse:?}");
        for outside in [-1e-9, 0.011, 1.0] {
            assert_eq!(pulse.at(outside), 0.0, "{pulse:?} at {outside}");
        }
        let signal = pulse.signal(1e6).unwrap();
        assert_eq!(signal.samples.len(), 11_001, "{pulse:?}");
        assert_eq!(signal.samples.last(), Some(&0.0), "{pulse:?}");
        let largest = signal.samples.iter().fold(0.0_f64, |a, b| a.max(*b));
        assert!((largest - 30.0).abs() < 3e-3, "{pulse:?}: {largest}");
    }
    assert!(shapes()[0].0.signal(0.0).is_err());
}
