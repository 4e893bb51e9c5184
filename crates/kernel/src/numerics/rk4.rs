//! The classical Runge-Kutta method of fourth order with a fixed step.

use super::Motion;

/// Right-hand sides that one step costs.
pub const STAGES: u64 = 4;

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

/// Returns |R(z)|, the factor by which one step multiplies a solution of y' = λy with
/// z = λ·step = `re` + i·`im`.
///
/// R(z) = 1 + z + z²/2 + z³/6 + z⁴/24.
pub fn amplification(re: f64, im: f64) -> f64 {
    // Horner's rule in complex numbers.
    let (mut r, mut i) = (1.0, 0.0);
    for n in [4.0, 3.0, 2.0, 1.0] {
        (r, i) = (1.0 + (re * r - im * i) / n, (re * i + im * r) / n);
    }
    libm::hypot(r, i)
}

/// Returns the largest angular frequency times step up to which an oscillator of
/// `damping_ratio` ξ [-] does not grow: the first ωh at which |R(ωh(−ξ ± i√(1−ξ²)))| = 1 is
/// passed upwards.
///
/// Without damping it is 2√2; a damping ratio of 1 or more gives the limit of
/// the real axis for its faster rate.
pub fn stability_limit(damping_ratio: f64) -> f64 {
    let xi = damping_ratio.max(0.0);
    let growth = |reach: f64| {
        if xi < 1.0 {
            amplification(-reach * xi, reach * (1.0 - xi * xi).sqrt())
        } else {
            amplification(-reach * (xi + (xi * xi - 1.0).sqrt()), 0.0)
        }
    };
    // Stable all through up to half the smaller of the limits on both axes; a damped
    // oscillator passes 1 once beyond it.
    let (mut low, mut high) = (1.3 / xi.max(1.0) / 2.0, 4.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if growth(middle) > 1.0 + 1e-12 {
            high = middle;
        } else {
            low = middle;
        }
    }
    low
}
