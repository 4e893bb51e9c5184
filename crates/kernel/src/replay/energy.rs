//! How far energy and impulse may still take a lever.

use super::State;
use crate::model::lever::Lever;
use crate::model::stop::{Stop, StopModel};
use crate::signal::Pieces;

/// Returns the energy of a lever [J]: kinetic, of preload and spring, and what its soft stop holds.
pub(super) fn energy_of(
    lever: &Lever,
    stop: &Stop,
    model: StopModel,
    angle: f64,
    velocity: f64,
) -> f64 {
    let stiffness = stop.stiffness_at_nm_per_rad(model, lever, angle);
    0.5 * lever.moment_of_inertia_kg_m2 * velocity * velocity
        + lever.preload_torque_nm * angle
        + 0.5 * stiffness * angle * angle
}

/// Tells whether a lever in a state stays below the angle `best` [rad], whatever its
/// impacts do: its energy and the `impulse` still to come, ∫|a| dt [m/s], are too small.
///
/// # Source
///
/// d√E/dt ≤ mL|a|/√(2 I0), and its soft stop's counterpart.
pub(super) fn stays_below(
    (lever, stop, model): (&Lever, &Stop, StopModel),
    state: State,
    best: f64,
    impulse: f64,
) -> bool {
    /// Room for rounding and for the replay's own error.
    const ROOM: f64 = 1e-6;
    let stored = match model.yields() {
        false => 0.0,
        true => {
            let stiffness = stop.contact_stiffness_nm_per_rad(lever);
            0.5 * lever.preload_torque_nm * lever.preload_torque_nm / stiffness
        }
    };
    let inertia = lever.moment_of_inertia_kg_m2;
    let speed = |energy: f64| (2.0 * energy / inertia).sqrt();
    let energy = stored + energy_of(lever, stop, model, state.angle_rad, state.velocity_rad_s);
    let needed = stored + energy_of(lever, stop, model, best, 0.0);
    let gained = lever.unbalance_kg_m() / inertia * impulse;
    // At an angle of zero the potential does not tell a lever from its stop; a state that is
    // no number stays below nothing.
    best > 0.0
        && energy.is_finite()
        && speed(energy.max(0.0)) + gained < (1.0 - ROOM) * speed(needed)
}

/// Returns ∫(|a| + |a'|) dt [m/s], a' being what a second sensor recorded, from every `every`-th sample to sample `last`, or a little more: no polynomial has
/// a larger mean magnitude than its Bernstein coefficients.
pub(super) fn impulse_ahead<const K: usize>(
    pieces: &Pieces<'_, K>,
    last: usize,
    every: usize,
) -> Vec<f64> {
    let each = pieces.signal.rate.interval().seconds() / K as f64;
    let mut ahead = vec![0.0; last / every + 1];
    let mut sum = 0.0;
    let second = pieces.second();
    for (index, here) in ahead.iter_mut().enumerate().rev() {
        let first = index * every;
        for interval in first..(first + every).min(last) {
            let magnitudes: f64 = pieces.control(interval).iter().map(|b| b.abs()).sum();
            sum += each * magnitudes;
            if let Some(second) = &second {
                let magnitudes: f64 = second.control(interval).iter().map(|b| b.abs()).sum();
                sum += each * magnitudes;
            }
        }
        *here = sum;
    }
    ahead
}
