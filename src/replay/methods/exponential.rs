//! Exponential steps: the linear part of each branch exactly, located events.
//!
//! The torque of the excitation, b(t) cos φ, is taken to be linear over the step, with cos φ at
//! its end by iteration. In contact, where φ is small, that is nearly exact at any stiffness:
//! no limit of stability. In flight cos φ bends, and the method is of second order. Steps end
//! at samples and events; the interpolant that finds events asks for several steps a contact.

use super::lever::Branch;
use super::located::{self, Stepper, Trial};
use super::rk4::step_seconds;
use super::{Problem, Raw};
use crate::model::excitation::Excitation;
use crate::numerics::{event, exponential};

/// Rounds of the iteration on cos φ at most; each gains the factor b·step² or better.
const ROUNDS_MAX: u32 = 20;

struct Exponential {
    step: f64,
}

/// Runs with at least `steps_per_period` steps in a natural period.
pub(super) fn run<E: Excitation>(problem: &Problem<'_, E>, steps_per_period: u32) -> Raw {
    located::run(
        problem,
        Exponential {
            step: step_seconds(problem.design, steps_per_period),
        },
        true,
    )
}

impl Stepper for Exponential {
    type Dense = [f64; 4];

    fn propose(&mut self, reach: f64) -> f64 {
        reach / (reach / self.step * (1.0 - 1e-9)).ceil().max(1.0)
    }

    fn step<E: Excitation>(
        &mut self,
        branch: &Branch<'_, E>,
        t: f64,
        h: f64,
        q: f64,
        v: f64,
    ) -> Trial<[f64; 4]> {
        let (q1, v1, rhs) = self.part(branch, t, h, q, v);
        Trial {
            q: q1,
            v: v1,
            dense: event::hermite(h, q, v, q1, v1),
            rhs,
            kept: true,
        }
    }

    fn part<E: Excitation>(
        &self,
        branch: &Branch<'_, E>,
        t: f64,
        h: f64,
        q: f64,
        v: f64,
    ) -> (f64, f64, u64) {
        let from = branch.push(t) * libm::cos(q);
        let late = branch.push(t + h);
        let mut end = (q + h * v, v);
        let mut rhs = 1;
        for _ in 0..ROUNDS_MAX {
            let to = late * libm::cos(end.0);
            let next = exponential::step(
                branch.damping,
                branch.stiffness,
                -branch.pressing - from,
                -(to - from) / h,
                h,
                q,
                v,
            );
            rhs += 1;
            let moved = (next.0 - end.0).abs();
            end = next;
            if moved <= 4.0 * f64::EPSILON * end.0.abs() {
                break;
            }
        }
        (end.0, end.1, rhs)
    }

    fn branch_changed(&mut self, _rested: bool) {}
}
