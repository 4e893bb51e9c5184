//! The classical Runge-Kutta method of fourth order with a fixed step.

use super::Motion;

/// Right-hand sides that one step costs.
pub const STAGES: u64 = 4;

/// Limit of |z| on the imaginary axis up to which the method is stable: |R(z)| ≤ 1 for
/// z = iωh needs ωh ≤ 2√2.
pub const STABILITY_LIMIT: f64 = 2.828_427_124_746_190_3;

/// Advances (q, v) from `t` by `step` [s].
#[inline]
pub fn step<M: Motion>(motion: &M, t: f64, step: f64, q: f64, v: f64) -> (f64, f64) {
    let half = 0.5 * step;
    let a1 = motion.acceleration(t, q, v);
    let v2 = v + half * a1;
    let a2 = motion.acceleration(t + half, q + half * v, v2);
    let v3 = v + half * a2;
    let a3 = motion.acceleration(t + half, q + half * v2, v3);
    let v4 = v + step * a3;
    let a4 = motion.acceleration(t + step, q + step * v3, v4);
    (
        q + step / 6.0 * (v + 2.0 * (v2 + v3) + v4),
        v + step / 6.0 * (a1 + 2.0 * (a2 + a3) + a4),
    )
}
