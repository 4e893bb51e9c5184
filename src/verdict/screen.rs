//! Closed-form bounds that need no integration.

use super::Screens;
use crate::conditioning::Signal;
use crate::model::Design;
use crate::units::STANDARD_GRAVITY;

/// Returns the bounds of `design`, with the impulse of `signal` over its judged samples.
///
/// # Source
///
/// Static: eq. (2.1) at rest. Impulse: with E = I0 φ'²/2 + T0 φ + k0 φ²/2, damping and
/// impacts only lower E, so d√E/dt ≤ mL|a|/√(2 I0); reaching φ* from rest needs
/// ∫|a| dt ≥ √(2 I0 (T0 φ* + k0 φ*²/2))/(mL). It holds for a rigid stop with R ≤ 1.
#[must_use]
pub fn screens(design: &Design, signal: Option<&Signal>) -> Screens {
    let lever = &design.lever;
    let threshold = design.criterion.threshold_rad;
    let energy = lever.preload_torque_nm * threshold
        + 0.5 * lever.spring_stiffness_nm_per_rad * threshold * threshold;
    let static_threshold = lever.lift_off_acceleration_m_s2();
    Screens {
        static_threshold_g: static_threshold / STANDARD_GRAVITY,
        static_threshold_m_s2: static_threshold,
        impulse_threshold_m_s: (2.0 * lever.moment_of_inertia_kg_m2 * energy).sqrt()
            / lever.unbalance_kg_m(),
        impulse_m_s: signal.map(absolute_impulse),
    }
}

/// Returns ∫|a| dt [m/s] of a signal that is linear between its samples.
fn absolute_impulse(signal: &Signal) -> f64 {
    let sum: f64 = signal
        .samples
        .windows(2)
        .map(|pair| {
            let (from, to) = (pair[0], pair[1]);
            if (from < 0.0) == (to < 0.0) {
                0.5 * (from.abs() + to.abs())
            } else {
                // Two triangles on either side of the zero.
                0.5 * (from * from + to * to) / (to - from).abs()
            }
        })
        .sum();
    sum / signal.rate.hertz()
}
