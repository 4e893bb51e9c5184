//! Where something happens inside a step: interpolation and bracketed roots.

use super::polynomial;

/// Returns the cubic through (`q0`, `v0`) and (`q1`, `v1`) of a step of `step` [s], in powers
/// of the part σ of the step.
///
/// Its error is of fourth order in the step.
#[inline]
pub fn hermite(step: f64, q0: f64, v0: f64, q1: f64, v1: f64) -> [f64; 4] {
    let (s0, s1, rise) = (v0 * step, v1 * step, q1 - q0);
    [q0, s0, 3.0 * rise - 2.0 * s0 - s1, s0 + s1 - 2.0 * rise]
}

/// Returns the first part of the step, in (0, 1), at which the interpolant of the angle comes
/// down to zero; `side` is +1 for an angle above zero and −1 for one below.
///
/// A step that begins at zero has a known root there, which is divided out. A pair of close
/// roots inside the step is not overlooked; an interpolant that touches zero without crossing
/// is no event.
#[inline]
pub fn first_contact(coefficients: &[f64], side: f64) -> Option<f64> {
    let (start, slope) = (side * coefficients[0], side * coefficients[1]);
    let bend: f64 = coefficients[2..].iter().map(|c| c.abs()).sum();
    if start + slope.min(0.0) - bend > 0.0 {
        return None;
    }
    let mut signed = [0.0; polynomial::CAPACITY];
    let signed = &mut signed[..coefficients.len()];
    for (to, from) in signed.iter_mut().zip(coefficients) {
        *to = side * from;
    }
    let skip = signed.iter().position(|c| *c != 0.0)?;
    if skip == 0 && signed[0] < 0.0 {
        return None;
    }
    polynomial::first_fall(&signed[skip..], 1.0)
}

/// Returns the root of `function` between `low` and `high`, at which it must have different
/// signs; the regula falsi of Illinois, halving where that is slow.
pub fn root(function: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let (mut a, mut b) = (low, high);
    let (mut fa, mut fb) = (function(a), function(b));
    for round in 0..200 {
        if fb == 0.0 || (b - a).abs() <= 2.0 * f64::EPSILON * a.abs().max(b.abs()) {
            break;
        }
        let secant = b - fb * (b - a) / (fb - fa);
        let inside = secant > a.min(b) && secant < a.max(b);
        let c = if inside && round % 8 != 7 {
            secant
        } else {
            f64::midpoint(a, b)
        };
        let fc = function(c);
        if (fc < 0.0) == (fb < 0.0) {
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
        }
        (b, fb) = (c, fc);
    }
    b
}
