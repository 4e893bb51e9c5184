//! Time-stepping after Moreau and Jean: the θ-method on the smooth forces, Newton's impact law
//! as a complementarity between velocity and percussion, no event looked for.
//!
//! Where the lever stands on or below the stop by the predicted angle, the velocity at the end
//! of the step is the larger of the free one and −R times the one before; a lever at rest
//! needs no rule of its own. Impacts are met up to one step late: the method is of first order,
//! robust through chatter, and never exact. It knows the rigid stop only.
//!
//! # Source
//!
//! Moreau (1988), "Unilateral contact and dry friction in finite freedom dynamics"; Jean,
//! Comput. Methods Appl. Mech. Eng. 177 (1999) 235; as in Acary and Brogliato, "Numerical Methods
//! for Nonsmooth Dynamical Systems" (2008), ch. 10.

use super::lever::SmoothBranch;
use super::record::Record;
use super::{Breakdown, Problem, Raw, State, Work};
use crate::model::excitation::Excitation;
use crate::numerics::Motion;

/// Weight of the end of the step; a half is of second order in flight.
const THETA: f64 = 0.5;

/// Rounds of the fixed-point iteration on cos φ at most; each gains the factor (step·ω)².
const ROUNDS_MAX: u32 = 20;

/// Runs with `steps_per_period` steps in a natural period.
pub(super) fn run<E: Excitation>(problem: &Problem<'_, E>, steps_per_period: u32) -> Raw {
    let lever = SmoothBranch::free(problem);
    let restitution = problem.design.stop.restitution;
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
    for k in 0..steps {
        let t = start + k as f64 * step;
        let h = step.min(end - t);
        if h <= 0.0 {
            break;
        }
        let (free, rounds) = free_velocity(&lever, t, h, q, v);
        work.steps += 1;
        work.rhs += 1 + u64::from(rounds);
        let mut next = free;
        if q + 0.5 * h * v <= 0.0 && free < -restitution * v {
            next = -restitution * v;
            if v < 0.0 {
                work.events += 1;
                record.impact(t, v);
            }
        }
        q += h * (THETA * next + (1.0 - THETA) * v);
        v = next;
        let now = t + h;
        record.grid_point(now, h, q);
        record.keep(now, q, v);
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

/// Returns the velocity at the end of a step without contact, and the rounds it took: linear
/// forces implicitly, cos φ by iteration.
fn free_velocity<E: Excitation>(
    lever: &SmoothBranch<'_, E>,
    t: f64,
    h: f64,
    q: f64,
    v: f64,
) -> (f64, u32) {
    let early = h * (1.0 - THETA);
    let late = h * THETA;
    let explicit = v + early * lever.acceleration(t, q, v)
        - late * (lever.pressing + lever.stiffness * (q + early * v));
    let inertia = 1.0 + late * lever.damping + late * late * lever.stiffness;
    let mut next = v;
    for round in 1..=ROUNDS_MAX {
        let angle = q + early * v + late * next;
        let better = (explicit - late * lever.turned_push(t + h, angle)) / inertia;
        let moved = (better - next).abs();
        next = better;
        if moved <= 4.0 * f64::EPSILON * next.abs() {
            return (next, round);
        }
    }
    (next, ROUNDS_MAX)
}
