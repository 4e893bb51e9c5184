//! The lever with `diffsol`, as its manual shows: Tsitouras' explicit pair with a root function
//! for the stop, the state set anew after each event.

use diffsol::{
    DiffsolError, NalgebraMat, NalgebraVec, OdeBuilder, OdeSolverMethod, OdeSolverStopReason,
    Vector,
};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use std::cell::Cell;

type M = NalgebraMat<f64>;
type V = NalgebraVec<f64>;

/// Where the solver ends a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stops {
    /// At impacts, contact entries and lift-offs alone.
    AtEvents,
    /// At each sample as well, where the excitation has a kink. Nobody has to know that it
    /// helps; those who do get more for their time.
    AtSamplesToo,
}

/// What is solved, and how.
#[derive(Debug, Clone)]
pub struct Task<'a> {
    /// Base acceleration; negative opens.
    pub signal: &'a Signal,
    /// The lever.
    pub design: Design,
    /// Its stop.
    pub stop: StopModel,
    /// Where steps end.
    pub stops: Stops,
    /// Tolerance, relative and absolute alike.
    pub tolerance: f64,
}

/// What the lever did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Largest angle [rad].
    pub peak_angle_rad: f64,
    /// First time the angle exceeds the threshold [s].
    pub first_crossing_s: Option<f64>,
    /// Angle at the last sample [rad].
    pub final_angle_rad: f64,
    /// Angular velocity there [rad/s].
    pub final_velocity_rad_s: f64,
    /// Impacts (soft stop: contact entries) faster than 1e-3 rad/s.
    pub impacts: u64,
    /// Steps taken.
    pub steps: usize,
}

/// Angle by which a lever stands off the stop's face after an event [rad]: a root function that
/// starts at zero exactly has no sign to change.
const ASIDE: f64 = 1e-18;

/// Times closer than this are one instant [s].
const INSTANT: f64 = 1e-12;

/// Solver steps of a lap: half a millisecond.
const LAP_STEPS: usize = 500;

/// Follows the lever through the recording, and tells the end of each lap.
///
/// # Errors
///
/// What the solver reports: a step too small, or a root where it cannot be.
pub fn run(task: &Task<'_>, end_lap: &mut impl FnMut()) -> Result<Answer, DiffsolError> {
    let Task { signal, design, .. } = task;
    let (lever, stop) = (design.lever, design.stop);
    let threshold = design.criterion.threshold_rad;
    let unbalance = lever.unbalance_kg_m();
    let excitation = Excitation::new(signal);
    let rigid = task.stop == StopModel::Rigid;
    let in_contact = Cell::new(!rigid);
    let free_constants = (
        lever.spring_stiffness_nm_per_rad,
        lever.pivot_damping_nm_s_per_rad,
    );
    let contact_constants = (
        stop.contact_stiffness_nm_per_rad(&lever),
        stop.contact_damping_nm_s_per_rad(&lever),
    );
    let slope = |t: f64, angle: f64, velocity: f64| {
        let (stiffness, damping) = if in_contact.get() {
            contact_constants
        } else {
            free_constants
        };
        let torque = -lever.preload_torque_nm
            - unbalance * excitation.at(t) * angle.cos()
            - damping * velocity
            - stiffness * angle;
        torque / lever.moment_of_inertia_kg_m2
    };
    let start_angle = if rigid {
        ASIDE
    } else {
        stop.rest_angle_rad(&lever)
    };
    let problem = OdeBuilder::<M>::new()
        .t0(excitation.start)
        .rtol(task.tolerance)
        .atol([task.tolerance])
        .rhs(|y: &[f64], _p: &[f64], t: f64, dy: &mut [f64]| {
            dy[0] = y[1];
            dy[1] = slope(t, y[0], y[1]);
        })
        .init(
            |_p: &[f64], _t: f64, y: &mut [f64]| {
                y[0] = start_angle;
                y[1] = 0.0;
            },
            2,
        )
        .root(
            |y: &[f64], _p: &[f64], _t: f64, g: &mut [f64]| g[0] = y[0],
            1,
        )
        .build()?;
    let mut solver = problem.tsit45()?;

    let end = excitation.end;
    let mut now = Point {
        t: excitation.start,
        angle: start_angle,
        velocity: 0.0,
    };
    let mut answer = Answer {
        peak_angle_rad: if rigid { 0.0 } else { start_angle },
        first_crossing_s: None,
        final_angle_rad: 0.0,
        final_velocity_rad_s: 0.0,
        impacts: 0,
        steps: 0,
    };
    let mut between = V::zeros(2, *problem.context());
    let mut resting = rigid;
    let mut stop_is_set = false;
    let mut steps = 0;
    loop {
        if resting {
            // Pressed onto a rigid stop nothing moves until the samples say otherwise.
            let lift_off = excitation.first_below(-lever.lift_off_acceleration_m_s2(), now.t);
            now = Point {
                t: lift_off.unwrap_or(end),
                angle: if lift_off.is_some() { ASIDE } else { 0.0 },
                velocity: 0.0,
            };
            resting = false;
            restart(&mut solver, now, slope(now.t, now.angle, 0.0));
            stop_is_set = false;
        }
        if end - now.t < INSTANT {
            break;
        }
        if !stop_is_set {
            solver.set_stop_time(match task.stops {
                Stops::AtEvents => end,
                Stops::AtSamplesToo => excitation.next_sample(now.t),
            })?;
            stop_is_set = true;
        }
        let reason = solver.step()?;
        steps += 1;
        if steps % LAP_STEPS == 0 {
            end_lap();
        }
        let root = match reason {
            OdeSolverStopReason::RootFound(t, _) => Some(t),
            _ => None,
        };
        let mut at = |t: f64| -> Result<Point, DiffsolError> {
            solver.interpolate_inplace(t, &mut between)?;
            Ok(Point {
                t,
                angle: between[0],
                velocity: between[1],
            })
        };
        let next = match root {
            Some(t) => at(t)?,
            None => {
                let state = solver.state();
                Point {
                    t: state.t,
                    angle: state.y[0],
                    velocity: state.y[1],
                }
            }
        };
        observe(&mut answer, threshold, now, next, &mut at)?;
        now = next;
        if matches!(reason, OdeSolverStopReason::TstopReached) {
            stop_is_set = false;
        }
        if root.is_none() {
            continue;
        }
        if now.velocity < -1e-3 && !in_contact.get() {
            answer.impacts += 1;
        }
        if rigid {
            now.angle = ASIDE;
            now.velocity *= -stop.restitution;
            // A bounce lower than the tolerance is none.
            let pressed = -slope(now.t, 0.0, 0.0);
            resting = 0.5 * now.velocity * now.velocity <= pressed * task.tolerance;
        } else {
            in_contact.set(now.velocity < 0.0);
            now.angle = ASIDE.copysign(now.velocity);
        }
        restart(&mut solver, now, slope(now.t, now.angle, now.velocity));
        stop_is_set = false;
    }
    answer.final_angle_rad = now.angle;
    answer.final_velocity_rad_s = now.velocity;
    answer.steps = steps;
    Ok(answer)
}

/// A point of the motion.
#[derive(Debug, Clone, Copy)]
struct Point {
    t: f64,
    angle: f64,
    velocity: f64,
}

/// Sets the solver's state after an event; its next step starts from there.
fn restart<'a, Eqn, S>(solver: &mut S, at: Point, acceleration: f64)
where
    Eqn: diffsol::OdeEquations<T = f64, V = V> + 'a,
    S: OdeSolverMethod<'a, Eqn>,
{
    let state = solver.state_mut();
    *state.t = at.t;
    state.y[0] = at.angle;
    state.y[1] = at.velocity;
    state.dy[0] = at.velocity;
    state.dy[1] = acceleration;
}

/// Notes the peak and the first crossing within a step; `at` interpolates in it.
fn observe(
    answer: &mut Answer,
    threshold: f64,
    from: Point,
    to: Point,
    at: &mut impl FnMut(f64) -> Result<Point, DiffsolError>,
) -> Result<(), DiffsolError> {
    let mut highest = to;
    let within = to.t - from.t;
    if from.velocity > 0.0 && to.velocity < 0.0 {
        let reach = from.angle.max(to.angle) + from.velocity.max(-to.velocity) * within;
        let asked = answer.first_crossing_s.is_none() && reach > threshold;
        if reach > answer.peak_angle_rad || asked {
            highest = root_between(from, to, at, |point| point.velocity)?;
        }
    }
    answer.peak_angle_rad = answer.peak_angle_rad.max(highest.angle);
    if answer.first_crossing_s.is_none() && highest.angle > threshold {
        let crossing = root_between(from, highest, at, |point| point.angle - threshold)?;
        answer.first_crossing_s = Some(crossing.t);
    }
    Ok(())
}

/// Returns the point between two at which `value` changes sign, by the Illinois method.
fn root_between(
    mut low: Point,
    mut high: Point,
    at: &mut impl FnMut(f64) -> Result<Point, DiffsolError>,
    value: impl Fn(&Point) -> f64,
) -> Result<Point, DiffsolError> {
    let (mut value_low, mut value_high) = (value(&low), value(&high));
    let mut middle = high;
    let mut kept_high = None;
    for _ in 0..60 {
        let t = (low.t * value_high - high.t * value_low) / (value_high - value_low);
        let moved = (t - middle.t).abs();
        middle = at(t.clamp(low.t, high.t))?;
        let found = value(&middle);
        if found == 0.0 || moved <= 1e-15 {
            break;
        }
        if (found > 0.0) == (value_high > 0.0) {
            (high, value_high) = (middle, found);
            if kept_high == Some(false) {
                value_low *= 0.5;
            }
            kept_high = Some(false);
        } else {
            (low, value_low) = (middle, found);
            if kept_high == Some(true) {
                value_high *= 0.5;
            }
            kept_high = Some(true);
        }
    }
    Ok(middle)
}

/// The recording as a function of time: samples joined by straight lines.
struct Excitation<'a> {
    samples: &'a [f64],
    rate: f64,
    start: f64,
    end: f64,
}

impl<'a> Excitation<'a> {
    fn new(signal: &'a Signal) -> Self {
        Self {
            samples: &signal.samples,
            rate: signal.rate.hertz(),
            start: signal.start_s,
            end: signal.end_s(),
        }
    }

    /// Sample interval that `t` lies in, and how far inside it.
    fn place(&self, t: f64) -> (usize, f64) {
        let position = (t - self.start) * self.rate;
        let index = (position as usize).min(self.samples.len() - 2);
        (index, position - index as f64)
    }

    fn at(&self, t: f64) -> f64 {
        let (index, part) = self.place(t);
        self.samples[index] + part * (self.samples[index + 1] - self.samples[index])
    }

    fn time(&self, index: usize) -> f64 {
        self.start + index as f64 / self.rate
    }

    /// First sample later than `t`.
    fn next_sample(&self, t: f64) -> f64 {
        let (index, _) = self.place(t + INSTANT);
        self.time(index + 1)
    }

    /// First time from `t` on at which the acceleration lies below `limit`.
    fn first_below(&self, limit: f64, t: f64) -> Option<f64> {
        if self.at(t) < limit {
            return Some(t);
        }
        let (first, _) = self.place(t);
        let index = (first..self.samples.len() - 1).find(|&k| self.samples[k + 1] < limit)?;
        let (from, to) = (self.samples[index], self.samples[index + 1]);
        let part = ((from - limit) / (from - to)).clamp(0.0, 1.0);
        Some((self.time(index) + part / self.rate).max(t))
    }
}
