//! The linear motion that a lever is compared with: y'' + γ y' + κ y = F(t), F linear over a
//! sample, solved exactly.

/// Exact solution over a step, from state and the forcing at both ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    /// Response to a unit of velocity, K, and its derivative.
    response: f64,
    response_rate: f64,
    /// What a unit of angle becomes, K' + γ K, and its derivative, −κ K.
    kept: f64,
    kept_rate: f64,
    /// What a unit of forcing at the start and at the end adds to angle and velocity.
    angle: (f64, f64),
    velocity: (f64, f64),
}

/// The solution that the angle cannot be below.
pub(super) struct LowerSolution {
    pub(super) state: (f64, f64),
    pub(super) elapsed: f64,
    pub(super) size: f64,
    pub(super) start_angle: f64,
    /// Sample before which it started.
    pub(super) since: usize,
}

/// Terms of the series; with γh + κh²/2 < 1 the last are below 1e-20.
const TERMS: u32 = 24;

impl Arc {
    /// Builds the solution over `step` [s]; nothing if the step is too long for the comparison
    /// (γh + κh²/2 ≥ 1, where K' may be negative).
    pub(super) fn new(step: f64, damping: f64, stiffness: f64) -> Option<Self> {
        let (first, second) = (damping * step, stiffness * step * step);
        if !(step >= 0.0 && first + 0.5 * second < 1.0) {
            return None;
        }
        // K = Σ x_n h^n with x_1 = 1, (n+1)(n+2) x_{n+2} = −γ (n+1) x_{n+1} − κ x_n.
        let (mut before, mut term) = (0.0, 1.0);
        let (mut sum, mut rate, mut area, mut area_twice) = (0.0, 0.0, 0.0, 0.0);
        for n in 1..=TERMS {
            let order = f64::from(n);
            sum += term;
            rate += order * term;
            area += term / (order + 1.0);
            area_twice += term / ((order + 1.0) * (order + 2.0));
            let next = -(first * order * term + second * before) / (order * (order + 1.0));
            (before, term) = (term, next);
        }
        // `term` was x_n h^(n−1): the step's missing powers come in here.
        let response = step * sum;
        let square = step * step;
        Some(Self {
            response,
            response_rate: rate,
            kept: rate + damping * response,
            kept_rate: -stiffness * response,
            angle: (square * (area - area_twice), square * area_twice),
            velocity: (step * (sum - area), step * area),
        })
    }

    /// Returns angle and velocity at the step's end.
    pub(super) fn advance(&self, (angle, velocity): (f64, f64), from: f64, to: f64) -> (f64, f64) {
        (
            self.kept * angle + self.response * velocity + self.angle.0 * from + self.angle.1 * to,
            self.kept_rate * angle
                + self.response_rate * velocity
                + self.velocity.0 * from
                + self.velocity.1 * to,
        )
    }
}

/// How long after its start the comparison of velocities holds: K' ≥ 1 − γt − κt²/2.
pub(super) fn velocities_compare(elapsed: f64, damping: f64, stiffness: f64) -> bool {
    damping * elapsed + 0.5 * stiffness * elapsed * elapsed < 1.0
}

/// How long after its start the comparison of angles holds: K ≥ t (1 − γt/2 − κt²/6).
pub(super) fn angles_compare(elapsed: f64, damping: f64, stiffness: f64) -> bool {
    0.5 * damping * elapsed + stiffness * elapsed * elapsed / 6.0 < 1.0
}
