//! The exact step of a damped linear oscillator under a force that is linear in time.

/// Below this size of ω²h² + γh the power series is used, above it the closed form.
const SHORT: f64 = 0.5;

/// Terms of the series: 0.5^12/24! is far below rounding.
const TERMS: u32 = 24;

/// Advances q'' = −`damping`·q' − `stiffness`·q + `force` + `slope`·t from t = 0 by `step` [s];
/// returns (q, q').
///
/// Exact but for rounding at any step; stiffness must not be negative.
#[must_use]
pub fn step(
    damping: f64,
    stiffness: f64,
    force: f64,
    slope: f64,
    step: f64,
    q: f64,
    v: f64,
) -> (f64, f64) {
    if stiffness * step * step + damping * step < SHORT {
        return series(damping, stiffness, force, slope, step, q, v);
    }
    if stiffness <= 0.0 {
        // q'' = −γ q' + f + s t: one integral fewer than with a spring.
        let (late, early) = (slope / damping, (force - slope / damping) / damping);
        let rest = v - early;
        let decay = libm::exp(-damping * step);
        return (
            q + early * step + 0.5 * late * step * step + rest * (1.0 - decay) / damping,
            early + late * step + rest * decay,
        );
    }
    // The particular solution p + r t, and the free motion around it.
    let r = slope / stiffness;
    let p = (force - damping * r) / stiffness;
    let (free_q, free_v) = (q - p, v - r);
    let half = 0.5 * damping;
    let square = stiffness - half * half;
    let decay = libm::exp(-half * step);
    let (even, odd) = if square > 0.0 {
        let omega = square.sqrt();
        (libm::cos(omega * step), libm::sin(omega * step) / omega)
    } else if square < 0.0 {
        let rate = (-square).sqrt();
        (libm::cosh(rate * step), libm::sinh(rate * step) / rate)
    } else {
        (1.0, step)
    };
    let (even, odd) = (decay * even, decay * odd);
    (
        p + r * step + (even + half * odd) * free_q + odd * free_v,
        r - stiffness * odd * free_q + (even - half * odd) * free_v,
    )
}

fn series(
    damping: f64,
    stiffness: f64,
    force: f64,
    slope: f64,
    step: f64,
    q: f64,
    v: f64,
) -> (f64, f64) {
    // Terms c_n step^n of q, and n c_n step^n for the velocity.
    let (mut c0, mut c1) = (q, v * step);
    let (mut angle, mut speed) = (c0 + c1, c1);
    let mut forcing = [force * step * step, slope * step * step * step];
    for n in 2..=TERMS {
        let n = f64::from(n);
        let push = forcing[0];
        forcing = [forcing[1], 0.0];
        let c2 = (push - damping * step * (n - 1.0) * c1 - stiffness * step * step * c0)
            / (n * (n - 1.0));
        angle += c2;
        speed += n * c2;
        (c0, c1) = (c1, c2);
    }
    (angle, speed / step)
}
