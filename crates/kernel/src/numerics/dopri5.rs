//! The embedded Runge-Kutta pair 5(4) of Dormand and Prince with its dense output.
//!
//! Order and error estimate hold where the right-hand side is smooth. Across a kink of the
//! excitation, as every sample of a recording is, the step is of second order and the
//! estimate sees it late: the step falls, many times per recording.
//!
//! # Source
//!
//! Dormand and Prince, J. Comp. Appl. Math. 6 (1980) 19; dense output and step control as in
//! Hairer, Nørsett and Wanner, "Solving Ordinary Differential Equations I", II.4 to II.6.

use super::Motion;

/// Right-hand sides that a step costs; the last serves the next step as its first.
pub const STAGES: u64 = 6;

const NODES: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

const TABLEAU: [[f64; 6]; 6] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Difference of the pair's weights.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Weights of the dense output's last coefficient.
const DENSE: [f64; 7] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// What a step gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegrationStep {
    /// Angle at its end [rad].
    pub q: f64,
    /// Angular velocity there [rad/s].
    pub v: f64,
    /// Angular acceleration there [rad/s²], the next step's first stage.
    pub a: f64,
    /// Estimated error of the angle [rad].
    pub error_q: f64,
    /// Estimated error of the angular velocity [rad/s].
    pub error_v: f64,
    /// The angle over the step, in powers of the part σ of the step; of fourth order.
    pub dense: [f64; 5],
}

/// Advances (q, v) from `t` by `step` [s]; `a` is the acceleration at the start.
#[inline]
pub fn step<M: Motion>(motion: &M, t: f64, step: f64, q: f64, v: f64, a: f64) -> IntegrationStep {
    let mut slopes_q = [v, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut slopes_v = [a, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (mut q1, mut v1) = (q, v);
    for stage in 0..6 {
        let (mut sum_q, mut sum_v) = (0.0, 0.0);
        for (j, weight) in TABLEAU[stage][..=stage].iter().enumerate() {
            sum_q += weight * slopes_q[j];
            sum_v += weight * slopes_v[j];
        }
        (q1, v1) = (q + step * sum_q, v + step * sum_v);
        slopes_q[stage + 1] = v1;
        slopes_v[stage + 1] = motion.acceleration(t + NODES[stage] * step, q1, v1);
    }
    let sum = |weights: &[f64; 7], slopes: &[f64; 7]| -> f64 {
        step * weights.iter().zip(slopes).map(|(w, k)| w * k).sum::<f64>()
    };
    let rise = q1 - q;
    let bend = step * v - rise;
    let close = rise - step * v1 - bend;
    let last = sum(&DENSE, &slopes_q);
    IntegrationStep {
        q: q1,
        v: v1,
        a: slopes_v[6],
        error_q: sum(&ERROR, &slopes_q),
        error_v: sum(&ERROR, &slopes_v),
        dense: [
            q,
            rise + bend,
            close + last - bend,
            -close - 2.0 * last,
            last,
        ],
    }
}

/// Returns the factor for the next step from the scaled error of this one, at most 1 for a
/// step that is kept.
#[inline]
pub fn step_factor(scaled_error: f64) -> f64 {
    if scaled_error.is_nan() {
        return 0.1;
    }
    (0.9 * libm::pow(scaled_error.max(1e-10), -0.2)).clamp(0.2, 5.0)
}
