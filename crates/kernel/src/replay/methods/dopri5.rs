//! Dormand and Prince's pair with step control and located events.
//!
//! The tolerance is absolute [rad, rad/s] and relative at once, per step. No step is longer
//! than a sample interval, so that none passes over a pulse unseen; apart from that
//! `dopri5` steps as it likes across the kinks of the recording, as such solvers do when they
//! are handed an interpolated recording, and loses its order there. `dopri5-samples` ends a
//! step at each sample.

use super::lever::SmoothBranch;
use super::located::{self, StepTrial, Stepper};
use super::{Problem, Raw};
use crate::model::excitation::Excitation;
use crate::numerics::{Motion, dopri5};

struct Adaptive {
    tolerance: f64,
    longest: f64,
    /// Step to start with after a rest [s].
    first: f64,
    /// Step to try next [s].
    next: f64,
    /// Acceleration at the end of the last step kept [rad/s²], if nothing jumped since.
    reused: Option<f64>,
}

/// Runs with this tolerance, ending steps at samples if asked to.
pub(super) fn run<E: Excitation>(
    problem: &Problem<'_, E>,
    tolerance: f64,
    at_samples: bool,
) -> Raw {
    // A hundredth of a swing, less for a tight tolerance; the control mends it at once.
    let first = (0.1 * libm::pow(tolerance, 0.2)
        / problem.design.lever.angular_frequency_rad_s().max(1.0))
    .min(problem.longest_step_s);
    located::run(
        problem,
        Adaptive {
            tolerance,
            longest: problem.longest_step_s,
            first,
            next: first,
            reused: None,
        },
        at_samples,
    )
}

impl Adaptive {
    fn scaled_error(&self, q: f64, v: f64, step: &dopri5::IntegrationStep) -> f64 {
        let scale = |a: f64, b: f64| self.tolerance * (1.0 + a.abs().max(b.abs()));
        let q = step.error_q / scale(q, step.q);
        let v = step.error_v / scale(v, step.v);
        (0.5 * (q * q + v * v)).sqrt()
    }
}

impl Stepper for Adaptive {
    type Dense = [f64; 5];

    fn propose(&mut self, reach: f64) -> f64 {
        let step = self.next.min(self.longest);
        if step >= reach {
            reach
        } else if 2.0 * step > reach {
            // Two equal steps rather than a long one and a splinter.
            0.5 * reach
        } else {
            step
        }
    }

    fn step<E: Excitation>(
        &mut self,
        branch: &SmoothBranch<'_, E>,
        t: f64,
        h: f64,
        q: f64,
        v: f64,
    ) -> StepTrial<[f64; 5]> {
        let mut rhs = dopri5::STAGES;
        let start = self.reused.unwrap_or_else(|| {
            rhs += 1;
            branch.acceleration(t, q, v)
        });
        let step = dopri5::step(branch, t, h, q, v, start);
        let error = self.scaled_error(q, v, &step);
        let kept = error <= 1.0;
        let proposed = h * dopri5::step_factor(error);
        // A step cut short by an end says little about the next one.
        self.next = if kept && h < self.next {
            proposed.max(self.next)
        } else {
            proposed
        };
        self.reused = Some(if kept { step.a } else { start });
        StepTrial {
            q: step.q,
            v: step.v,
            dense: step.dense,
            rhs,
            kept,
        }
    }

    fn part<E: Excitation>(
        &self,
        branch: &SmoothBranch<'_, E>,
        t: f64,
        h: f64,
        q: f64,
        v: f64,
    ) -> (f64, f64, u64) {
        let start = branch.acceleration(t, q, v);
        let step = dopri5::step(branch, t, h, q, v, start);
        (step.q, step.v, dopri5::STAGES + 1)
    }

    fn branch_changed(&mut self, rested: bool) {
        self.reused = None;
        if rested {
            // Rest forgets the state; the step's history must go with it.
            self.next = self.first;
        }
    }
}
