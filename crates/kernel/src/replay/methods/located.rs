//! Located events around any one-step method: flight, contact, impact, rest.
//!
//! The method gives a trial step and an interpolant of the angle over it. Where the
//! interpolant meets the stop, the instant is refined by Newton's method on shorter steps of
//! the method itself, so that the event has the method's order. A rigid stop then returns
//! −R times the velocity, and the lever is taken to rest once it leaves slower than
//! [`REST_SPEED_RAD_S`] while the torque presses it; at rest the instant of release is the root
//! of the torque. On a soft stop the branch changes at φ = 0.

use super::lever::SmoothBranch;
use super::record::Record;
use super::{Breakdown, Problem, Raw, STEPS_MAX, State, Work};
use crate::model::excitation::Excitation;
use crate::numerics::event;

/// A bounce slower than this is taken for rest [rad/s]: with a pressed reference lever the
/// bounces left out last less than 1e-10 s together.
pub const REST_SPEED_RAD_S: f64 = 1e-9;

/// Rounds of Newton's method on an event at most.
const ROUNDS_MAX: u32 = 12;

/// A trial step.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepTrial<D> {
    pub(super) q: f64,
    pub(super) v: f64,
    /// The angle in powers of the part of the step.
    pub(super) dense: D,
    pub(super) rhs: u64,
    /// False if the step is to be tried again, shorter.
    pub(super) kept: bool,
}

/// A one-step method with its step control.
pub(super) trait Stepper {
    /// Coefficients of the interpolant.
    type Dense: AsRef<[f64]>;

    /// Returns the length of the next step [s], at most `reach`.
    fn propose(&mut self, reach: f64) -> f64;

    /// Tries a step of `h` [s].
    fn step<E: Excitation>(
        &mut self,
        branch: &SmoothBranch<'_, E>,
        t: f64,
        h: f64,
        q: f64,
        v: f64,
    ) -> StepTrial<Self::Dense>;

    /// Steps without control; returns state and right-hand sides used.
    fn part<E: Excitation>(
        &self,
        branch: &SmoothBranch<'_, E>,
        t: f64,
        h: f64,
        q: f64,
        v: f64,
    ) -> (f64, f64, u64);

    /// The right-hand side or the state has jumped; `rested` if the lever comes from rest.
    fn branch_changed(&mut self, rested: bool);
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LocatedPhase {
    Dwell,
    Flight,
    Contact,
}

struct EventDriver<'a, E, S> {
    problem: Problem<'a, E>,
    stepper: S,
    at_samples: bool,
    free: SmoothBranch<'a, E>,
    contact: SmoothBranch<'a, E>,
    phase: LocatedPhase,
    t: f64,
    q: f64,
    v: f64,
    record: Record,
    work: Work,
    breakdown: Option<Breakdown>,
}

/// Runs `stepper` over the problem; with `at_samples` no step crosses a kink.
pub(super) fn run<E: Excitation, S: Stepper>(
    problem: &Problem<'_, E>,
    stepper: S,
    at_samples: bool,
) -> Raw {
    let start = problem.start_state();
    let (q, v) = (start.angle_rad, start.velocity_rad_s);
    let phase = match problem.stop.yields() {
        false if problem.initial.is_none() => LocatedPhase::Dwell,
        true if q < 0.0 => LocatedPhase::Contact,
        _ => LocatedPhase::Flight,
    };
    let mut driver = EventDriver {
        problem: *problem,
        stepper,
        at_samples,
        free: SmoothBranch::free(problem),
        contact: SmoothBranch::contact(problem),
        phase,
        t: problem.start_s,
        q,
        v,
        record: Record::new(problem, q, v),
        work: Work::default(),
        breakdown: None,
    };
    if phase == LocatedPhase::Flight && q <= 0.0 {
        driver.meet_stop();
    }
    driver.go();
    Raw {
        record: driver.record,
        state: State::new(driver.q, driver.v),
        work: driver.work,
        breakdown: driver.breakdown,
    }
}

impl<E: Excitation, S: Stepper> EventDriver<'_, E, S> {
    fn go(&mut self) {
        let mut looked = 0;
        while self.t < self.problem.end_s && self.breakdown.is_none() {
            if self.phase == LocatedPhase::Dwell {
                self.dwell();
            } else {
                self.step();
            }
            if let Some(ended) = self.problem.ended(&self.work, &mut looked) {
                self.breakdown = Some(ended);
            }
            if self.work.steps >= STEPS_MAX {
                self.breakdown = Some(Breakdown::TooManySteps);
            }
            if !self.q.is_finite() || !self.v.is_finite() {
                self.breakdown = Some(Breakdown::NotFinite);
            }
        }
    }

    /// Returns the instant that no step may cross.
    fn barrier(&self) -> f64 {
        let mut barrier = self.problem.end_s;
        if self.t < self.problem.judged_from_s {
            barrier = barrier.min(self.problem.judged_from_s);
        }
        if self.at_samples {
            barrier = barrier.min(self.problem.excitation.next_kink(self.t));
        }
        barrier
    }

    /// Rest on the rigid stop until the torque changes sign.
    fn dwell(&mut self) {
        let kink = self.problem.excitation.next_kink(self.t);
        let to = kink
            .min(self.t + self.problem.longest_step_s)
            .min(self.problem.end_s);
        if self.free.pressed(self.t) < 0.0 {
            self.lift_off(self.t);
        } else if self.free.pressed(to) < 0.0 {
            let instant = event::root(|t| self.free.pressed(t), self.t, to);
            self.lift_off(instant);
        } else {
            self.t = to;
            self.record.keep(to, 0.0, 0.0);
        }
    }

    fn lift_off(&mut self, instant: f64) {
        self.t = instant;
        self.phase = LocatedPhase::Flight;
        self.work.events += 1;
        self.record.release(instant);
        self.record.keep(instant, 0.0, 0.0);
        self.stepper.branch_changed(true);
    }

    fn step(&mut self) {
        let flying = self.phase == LocatedPhase::Flight;
        let branch = if flying { &self.free } else { &self.contact };
        let barrier = self.barrier();
        let reach = barrier - self.t;
        let h = self.stepper.propose(reach);
        if self.t + h <= self.t {
            if h < reach {
                self.breakdown = Some(Breakdown::StepVanished);
            } else {
                self.t = barrier;
            }
            return;
        }
        let trial = self.stepper.step(branch, self.t, h, self.q, self.v);
        self.work.steps += 1;
        self.work.rhs += trial.rhs;
        if !trial.kept {
            return;
        }
        let side = if flying { 1.0 } else { -1.0 };
        let dense = trial.dense.as_ref();
        let mut hit = event::first_contact(dense, side);
        if hit.is_none() && side * trial.q < 0.0 {
            // The interpolant and the step disagree by their rounding: met at the very end.
            hit = Some(1.0);
        }
        let Some(guess) = hit else {
            self.record.stretch(dense, 1.0, self.t, h);
            self.t = if h >= reach { barrier } else { self.t + h };
            (self.q, self.v) = (trial.q, trial.v);
            self.record.keep(self.t, self.q, self.v);
            return;
        };
        let (part, velocity) = self.refine(h, guess, side);
        self.record.stretch(dense, part, self.t, h);
        self.t = if part >= 1.0 && h >= reach {
            barrier
        } else {
            self.t + part * h
        };
        self.q = 0.0;
        self.v = side * (side * velocity).min(0.0);
        self.meet_stop();
    }

    /// Returns the part of the step at which the angle is zero, and the velocity there.
    fn refine(&mut self, h: f64, guess: f64, side: f64) -> (f64, f64) {
        let branch = if self.phase == LocatedPhase::Flight {
            &self.free
        } else {
            &self.contact
        };
        let mut part = guess;
        let mut velocity = self.v;
        for _ in 0..ROUNDS_MAX {
            let (q, v, rhs) = self.stepper.part(branch, self.t, part * h, self.q, self.v);
            self.work.rhs += rhs;
            velocity = v;
            if side * v >= 0.0 {
                // A graze: the interpolant's word stands.
                break;
            }
            let next = part - q / (v * h);
            if !(next > 0.0 && next <= 1.0) {
                break;
            }
            let moved = (next - part).abs();
            part = next;
            if moved <= 4.0 * f64::EPSILON * part {
                break;
            }
        }
        (part, velocity)
    }

    /// The lever is at φ = 0 with some velocity: flies on, enters the stop, bounces or rests.
    fn meet_stop(&mut self) {
        self.q = 0.0;
        self.work.events += 1;
        let pressed = self.free.pressed(self.t);
        let leaves = self.v > 0.0 || (self.v >= 0.0 && pressed < 0.0);
        if leaves {
            self.phase = LocatedPhase::Flight;
            self.record.release(self.t);
        } else if self.problem.stop.yields() {
            self.record.impact(self.t, self.v);
            self.phase = LocatedPhase::Contact;
        } else {
            self.record.impact(self.t, self.v);
            self.record.keep(self.t, 0.0, self.v);
            let after = -self.problem.design.stop.restitution * self.v;
            self.v = after;
            self.phase = LocatedPhase::Flight;
            if after <= REST_SPEED_RAD_S && pressed >= 0.0 {
                self.v = 0.0;
                self.phase = LocatedPhase::Dwell;
            }
        }
        self.record.keep(self.t, 0.0, self.v);
        self.stepper.branch_changed(false);
    }
}
