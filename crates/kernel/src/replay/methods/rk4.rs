//! The paper's way: Runge-Kutta of fourth order with a fixed step, events on its own grid.
//!
//! Kept to be compared with, not to be trusted: an impact is seen only at the end of the
//! step in which it happened, a lever on a rigid stop never quite rests, and a soft stop
//! whose frequency times the step exceeds 2√2 makes the run explode.

use super::lever::{SmoothBranch, Switching};
use super::record::Record;
use super::{Breakdown, Problem, Raw, State, Work};
use crate::model::design::Design;
use crate::model::excitation::Excitation;
use crate::numerics::rk4;

/// Points of a trace at most.
const TRACE_POINTS: u64 = 20_000;

/// Returns the step of the fixed-step methods [s]: natural period 2π/ω0 over the steps per
/// period.
pub fn step_seconds(design: &Design, steps_per_period: u32) -> f64 {
    std::f64::consts::TAU
        / design.lever.angular_frequency_rad_s()
        / f64::from(steps_per_period.max(1))
}

/// Runs with `steps_per_period` steps in a natural period.
pub(super) fn run<E: Excitation>(problem: &Problem<'_, E>, steps_per_period: u32) -> Raw {
    let motion = Switching {
        free: SmoothBranch::free(problem),
        contact: SmoothBranch::contact(problem),
    };
    let (start, end) = (problem.start_s, problem.end_s);
    let step = problem.fixed_step(steps_per_period);
    let State {
        angle_rad: mut q,
        velocity_rad_s: mut v,
    } = problem.start_state();
    let mut record = Record::new(problem, q, v);
    let mut work = Work::default();
    let (mut breakdown, mut looked) = (None, 0);
    let steps = ((end - start) / step).ceil() as u64;
    let keep_every = (steps / TRACE_POINTS).max(1);
    for k in 0..steps {
        let t = start + k as f64 * step;
        let h = step.min(end - t);
        if h <= 0.0 {
            break;
        }
        let before = q;
        (q, v) = rk4::step(&motion, t, h, q, v);
        let now = t + h;
        work.steps += 1;
        work.rhs += rk4::STAGES;
        if q < 0.0 && !problem.stop.yields() {
            record.lowest = record.lowest.min(q);
            q = 0.0;
            if v < 0.0 {
                work.events += 1;
                record.impact(now, v);
                v *= -problem.design.stop.restitution;
            }
        } else if q < 0.0 && before >= 0.0 {
            work.events += 1;
            record.impact(now, v);
        }
        record.grid_point(now, h, q);
        if k % keep_every == 0 {
            record.keep(now, q, v);
        }
        if !q.is_finite() || !v.is_finite() {
            breakdown = Some(Breakdown::NotFinite);
            break;
        }
        breakdown = problem.ended(&work, &mut looked);
        if breakdown.is_some() {
            break;
        }
    }
    Raw {
        record,
        state: State::new(q, v),
        work,
        breakdown,
    }
}
