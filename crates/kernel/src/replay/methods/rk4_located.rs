//! Runge-Kutta of fourth order with a fixed step on the smooth branches, events located.
//!
//! Steps end at each sample, where the excitation has a kink, and at each event: between two
//! such instants there are as many equal steps as keep each at or below the step asked for. So
//! the order of the method survives recording and impacts. A soft stop whose frequency times
//! the step exceeds 2√2 still makes the run explode.

use super::lever::SmoothBranch;
use super::located::{self, StepTrial, Stepper};
use super::{Problem, Raw};
use crate::model::excitation::Excitation;
use crate::numerics::{event, rk4};

struct FixedStep {
    step: f64,
}

/// Runs with at least `steps_per_period` steps in a natural period.
pub(super) fn run<E: Excitation>(problem: &Problem<'_, E>, steps_per_period: u32) -> Raw {
    located::run(
        problem,
        FixedStep {
            step: problem.fixed_step(steps_per_period),
        },
        true,
    )
}

/// Returns the length of the equal steps that fill `reach` [s], each at or below `step` [s].
pub(super) fn whole_part(reach: f64, step: f64) -> f64 {
    reach / (reach / step * (1.0 - 1e-9)).ceil().max(1.0)
}

impl Stepper for FixedStep {
    type Dense = [f64; 4];

    fn propose(&mut self, reach: f64) -> f64 {
        whole_part(reach, self.step)
    }

    fn step<E: Excitation>(
        &mut self,
        branch: &SmoothBranch<'_, E>,
        t: f64,
        h: f64,
        q: f64,
        v: f64,
    ) -> StepTrial<[f64; 4]> {
        let (q1, v1) = rk4::step(branch, t, h, q, v);
        StepTrial {
            q: q1,
            v: v1,
            dense: event::hermite(h, q, v, q1, v1),
            rhs: rk4::STAGES,
            kept: true,
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
        let (q1, v1) = rk4::step(branch, t, h, q, v);
        (q1, v1, rk4::STAGES)
    }

    fn branch_changed(&mut self, _rested: bool) {}
}
