//! The methods to compare with, behind one interface: each takes a [`Problem`] and gives a
//! [`Raw`] result. They share the lever's equations, the record of what happened and the way
//! in which failure is told; how time is stepped and an impact met is each one's own.
//!
//! | method | events | stops | error stated |
//! | --- | --- | --- | --- |
//! | `rk4` | on the grid, as in the paper | both | by halving the step |
//! | `rk4-located` | located, steps end at samples | both | by halving the step it takes |
//! | `dopri5` | located, steps regardless of samples | both | by a tenth of the tolerance |
//! | `dopri5-samples` | located, restarted at each sample | both | by a tenth of the tolerance |
//! | `moreau-jean` | none: impacts at velocity level | rigid | by halving the step |
//!
//! An error stated from a second run of the same kind is an estimate: it does not see rounding
//! that impacts amplify, nor what both runs get wrong alike.
//!
//! - `lever`: equations (2.1) and (2.2) divided by the moment of inertia, for methods that see a
//!   motion;
//! - `located`: located events around any one-step method: flight, contact, impact, rest;
//! - `moreau_jean`: time-stepping after Moreau and Jean: the θ-method on the smooth forces,
//!   Newton's impact law as a complementarity between velocity and percussion, no event looked
//!   for;
//! - `record`: what is kept of a motion that a method gives step by step;
//! - `rk4_located`: Runge-Kutta of fourth order with a fixed step on the smooth branches, events
//!   located.

mod dopri5;
mod lever;
mod located;
mod moreau_jean;
mod record;
mod rk4;
mod rk4_located;

use super::breakdown::Breakdown;
use super::drive::finite;
use super::kernel::{Coasting, Kernel};
use super::recorder::Recorder;
use super::{
    ErrorStatement, MOVING_ENERGY_J, Method, Run, RunOptions, RunOutcome, State, TracePoint,
    Within, Work, energy_j,
};
use crate::error::Error;
use crate::model::design::Design;
use crate::model::excitation::Excitation;
use crate::model::stop::StopModel;
use crate::numerics;
use crate::units::SampleInterval;
use record::Record;

pub use located::REST_SPEED_RAD_S;
pub use rk4::step_seconds;

/// Steps of a fixed-step run at most.
const FIXED_STEPS_MAX: f64 = 1e9;

/// Steps of a run with located events at most; a run that needs more is given up.
const STEPS_MAX: u64 = 200_000_000;

/// Tolerance of the adaptive method where none is stated.
pub const ADAPTIVE_TOLERANCE: f64 = 1e-9;

/// Least tolerance of the adaptive method; below it rounding decides the step.
pub const ADAPTIVE_TOLERANCE_MIN: f64 = 1e-14;

/// Tolerance beyond which the adaptive method is known to be wrong by more than a thousandth of
/// a radian on recordings.
const LOOSE_TOLERANCE: f64 = 1e-6;

/// Contact angular frequency times step beyond which the events on the grid make the soft stop
/// give back several per cent of the speed too much or too little.
const COARSE_CONTACT: f64 = 0.03;

/// Contact angular frequency times step beyond which located events no longer help: a contact
/// is fewer than ten steps, and the peak was seen off by 4e-4 to 4e-2 rad.
const COARSE_LOCATED: f64 = 0.3;

/// What a method is to solve.
#[derive(Debug)]
pub(super) struct Problem<'a, E> {
    pub(super) excitation: &'a E,
    pub(super) design: &'a Design,
    pub(super) stop: StopModel,
    pub(super) initial: Option<State>,
    /// First instant [s].
    pub(super) start_s: f64,
    /// Last instant [s].
    pub(super) end_s: f64,
    /// From when peak and crossings count [s].
    pub(super) judged_from_s: f64,
    /// Longest step of an adaptive method [s], so that none steps over a sample.
    pub(super) longest_step_s: f64,
    /// Step of a fixed-step method [s], if not by steps per natural period.
    pub(super) step_s: Option<f64>,
    pub(super) trace: bool,
    /// What it may take.
    pub(super) within: &'a Within<'a>,
}

impl<E> Clone for Problem<'_, E> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E> Copy for Problem<'_, E> {}

impl<E> Problem<'_, E> {
    /// Returns the step of a fixed-step method [s].
    fn fixed_step(&self, steps_per_period: u32) -> f64 {
        self.step_s
            .unwrap_or_else(|| step_seconds(self.design, steps_per_period))
    }

    /// Returns why a run that has taken `work` may not go on, if it may not; of one that was
    /// stopped whatever, since nobody reads it.
    fn ended(&self, work: &Work, looked: &mut u64) -> Option<Breakdown> {
        let too_many = work.counted() > self.within.steps_max;
        (too_many || self.within.ends(work.steps, looked)).then_some(Breakdown::TooManySteps)
    }

    /// Returns the state to start from.
    fn start_state(&self) -> State {
        self.initial.unwrap_or_else(|| {
            let Design { stop, lever, .. } = self.design;
            State::new(stop.rest_angle_rad(self.stop, lever), 0.0)
        })
    }
}

/// What a method gives.
#[derive(Debug, Clone)]
pub(super) struct Raw {
    pub(super) record: Record,
    pub(super) state: State,
    pub(super) work: Work,
    pub(super) breakdown: Option<Breakdown>,
}

/// Runs a method other than the event-driven one, with the error that its refinement shows.
pub(super) fn run<E: Excitation>(
    problem: &Problem<'_, E>,
    options: &RunOptions,
) -> Result<RunOutcome, Error> {
    check(problem, options)?;
    let tolerance = options.tolerance_rad.unwrap_or(ADAPTIVE_TOLERANCE);
    let coarse = integrate(problem, options.method, tolerance);
    let error = if options.error_bound {
        let quiet = Problem {
            trace: false,
            step_s: finer_step(problem, options.method),
            ..*problem
        };
        // A fixed-step method knows no tolerance, an adaptive one no step.
        let fine = integrate(&quiet, options.method, 0.1 * tolerance);
        if coarse.breakdown.is_some() || fine.breakdown.is_some() {
            f64::MAX
        } else {
            // Of first order, as a method with events on its grid is, the error is twice the
            // change that refining brings; twice that again is stated. Two runs that agree by
            // chance do not make the error zero: rounding adds up, and no adaptive run is
            // better than its tolerance.
            let change = 4.0 * (coarse.record.peak_angle - fine.record.peak_angle).abs();
            let rounding = f64::EPSILON * coarse.work.steps as f64 * coarse.record.peak_angle.abs();
            let floor = match options.method {
                Method::Dopri5 { .. } => tolerance,
                _ => 0.0,
            };
            change.max(rounding).max(floor)
        }
    } else {
        f64::INFINITY
    };
    Ok(outcome(problem, options, coarse, error))
}

fn integrate<E: Excitation>(problem: &Problem<'_, E>, method: Method, tolerance: f64) -> Raw {
    match method {
        Method::EventDriven => unreachable!("the event-driven kernel is no method to compare with"),
        Method::Rk4 { steps_per_period } => rk4::run(problem, steps_per_period),
        Method::Rk4Located { steps_per_period } => rk4_located::run(problem, steps_per_period),
        Method::Dopri5 { at_samples } => dopri5::run(problem, tolerance, at_samples),
        Method::MoreauJean { steps_per_period } => moreau_jean::run(problem, steps_per_period),
    }
}

/// Returns half the step that a fixed-step method takes [s].
///
/// A method whose steps end at samples may take shorter ones than it was asked for. Half of what
/// was asked for could be the same run once more, which would agree with itself to the last digit.
fn finer_step<E>(problem: &Problem<'_, E>, method: Method) -> Option<f64> {
    let step = problem.fixed_step(method.steps_per_period()?);
    let used_step = match method {
        Method::Rk4Located { .. } => rk4_located::whole_part(problem.longest_step_s, step),
        _ => step,
    };
    Some(0.5 * used_step)
}

fn check<E>(problem: &Problem<'_, E>, options: &RunOptions) -> Result<(), Error> {
    let method = options.method;
    if !method.admits(problem.stop) {
        return Err(Error::out_of_range(
            format!("stop model of the method {}", method.name()),
            "rigid; choose the setting `model` = rigid",
            problem.stop.name(),
        ));
    }
    if let Some(tolerance) = options.tolerance_rad
        && matches!(method, Method::Dopri5 { .. })
        && tolerance < ADAPTIVE_TOLERANCE_MIN
    {
        return Err(Error::out_of_range(
            format!("tolerance of the method {}", method.name()),
            format!("at least {ADAPTIVE_TOLERANCE_MIN:e}"),
            format!("{tolerance:e}"),
        ));
    }
    if let Some(steps_per_period) = method.steps_per_period() {
        let step = problem.fixed_step(steps_per_period);
        if problem.step_s.is_some() && !(step > 0.0 && step.is_finite()) {
            return Err(Error::NotPositive {
                what: "fixed step [s]",
                found: step,
            });
        }
        if !step.is_finite() {
            return Err(Error::out_of_range(
                "lever.spring_stiffness_nm_per_rad",
                "positive, since the fixed step is a part of the natural period",
                "0",
            ));
        }
        let steps = (problem.end_s - problem.start_s) / step;
        if steps.is_nan() || 2.0 * steps > FIXED_STEPS_MAX {
            return Err(Error::out_of_range(
                "steps of the fixed-step method",
                format!("at most {FIXED_STEPS_MAX:e}; lower the setting `steps_per_period`"),
                format!("{:e}", 2.0 * steps),
            ));
        }
    }
    Ok(())
}

fn outcome<E>(problem: &Problem<'_, E>, options: &RunOptions, raw: Raw, error: f64) -> RunOutcome {
    let (angle, velocity) = (raw.state.angle_rad, raw.state.velocity_rad_s);
    let record = raw.record;
    let sound = angle.is_finite() && velocity.is_finite() && record.peak_angle.is_finite();
    let breakdown = raw.breakdown.or((!sound).then_some(Breakdown::NotFinite));
    let moving = breakdown.is_none()
        && energy_j(problem.design, problem.stop, angle, velocity) > MOVING_ENERGY_J;
    let coast = if moving {
        let start_angle = match problem.stop.yields() {
            true => angle,
            false => angle.max(0.0),
        };
        let start = State::new(start_angle, velocity);
        let recorder = Recorder::new(problem.design.criterion.threshold_rad, false);
        Kernel::new(problem.design, problem.stop, Some(start), None, recorder)
            .coast(problem.end_s, problem.within)
    } else {
        None
    };
    let numerical_error_rad = if options.error_bound {
        finite(error)
    } else {
        f64::INFINITY
    };
    RunOutcome {
        catch: None,
        catch_trace: Vec::new(),
        run: Run {
            model: problem.stop,
            method: options.method.kind(),
            opens_when: options.opens_when,
            peak_angle_rad: finite(record.peak_angle),
            peak_time_s: record.peak_time,
            first_crossing_s: record.first_crossing,
            time_above_threshold_s: record.time_above,
            first_release_s: record.first_release,
            impacts: record.impacts,
            impact_list: record.impact_list,
            final_angle_rad: finite(angle),
            final_velocity_rad_s: finite(velocity),
            moving_at_end: moving,
            coast_peak_angle_rad: coast.map(|peak| peak.angle),
            numerical_error_rad,
            error: ErrorStatement::Estimate(numerical_error_rad),
            work: raw.work,
        },
        trace: record.trace.unwrap_or_default(),
        spent: raw.work.counted(),
        coast_error_rad: error,
        deviation_rad: None,
        final_error_rad: None,
        broke_down: breakdown.is_some() || (moving && coast.is_none()),
        breakdown,
        lowest_angle_rad: Some(record.lowest),
    }
}

impl Method {
    /// Tells whether the method knows this stop.
    pub fn admits(self, stop: StopModel) -> bool {
        !(matches!(self, Self::MoreauJean { .. }) && stop.yields())
    }

    /// Returns the steps per natural period of a fixed-step method.
    pub fn steps_per_period(self) -> Option<u32> {
        match self {
            Self::EventDriven | Self::Dopri5 { .. } => None,
            Self::Rk4 { steps_per_period }
            | Self::Rk4Located { steps_per_period }
            | Self::MoreauJean { steps_per_period } => Some(steps_per_period),
        }
    }

    /// Returns, in words, what is known to go wrong with this method on a stop, a design and a
    /// recording of this sample interval; empty where nothing is.
    ///
    /// `docs/accuracy.md` shows each in figures.
    pub fn known_failures(
        self,
        design: &Design,
        stop: StopModel,
        interval: SampleInterval,
        tolerance_rad: Option<f64>,
    ) -> Vec<String> {
        let mut weaknesses = Vec::new();
        let interval = interval.seconds();
        let step = self
            .steps_per_period()
            .map(|steps| step_seconds(design, steps));
        let frequency = design.stop.contact_angular_frequency_rad_s(&design.lever);
        let soft = stop.yields();
        match (self, step) {
            (Self::Rk4 { .. }, Some(step)) => {
                let reach = frequency * step;
                let limit = numerics::rk4::stability_limit(design.contact_damping_ratio());
                if soft && reach > limit {
                    weaknesses.push(format!("On the soft stop ω_R times the step is {reach:.2}, beyond the method's limit of {limit:.2}: the run gains energy in contact."));
                } else if soft && reach > COARSE_CONTACT {
                    weaknesses.push(format!("On the soft stop ω_R times the step is {reach:.2}; entry and exit lie on the grid, so that the stop gives back too much or too little speed, by some per cent above {COARSE_CONTACT}, impact after impact."));
                }
                if !soft {
                    weaknesses.push("On the rigid stop an impact is met up to one step late and deep, and a lever that bounces never comes to rest.".into());
                }
                if step > interval {
                    weaknesses.push(format!("The step of {step:.1e} s is longer than the sample interval of {interval:.1e} s: samples are stepped over."));
                }
            }
            (Self::Rk4Located { .. }, Some(step)) => {
                let reach = frequency * rk4_located::whole_part(interval, step);
                let limit = numerics::rk4::stability_limit(design.contact_damping_ratio());
                if soft && reach > limit {
                    weaknesses.push(format!("On the soft stop ω_R times the step is {reach:.2}, beyond the method's limit of {limit:.2}: the run gains energy in contact."));
                } else if soft && reach > COARSE_LOCATED {
                    weaknesses.push(format!("On the soft stop ω_R times the step is {reach:.2}: a contact of half a period is {:.1} steps, where ten would be few, and gives back a wrong speed.", std::f64::consts::PI / reach));
                }
            }
            (Self::MoreauJean { .. }, Some(step)) => {
                weaknesses.push("Impacts are met up to one step late: the method is of first order, and the lever may stand a step's way beyond the stop.".into());
                if step > interval {
                    weaknesses.push(format!("The step of {step:.1e} s is longer than the sample interval of {interval:.1e} s: samples are stepped over."));
                }
            }
            (Self::Dopri5 { at_samples }, _) => {
                let tolerance = tolerance_rad.unwrap_or(ADAPTIVE_TOLERANCE);
                if tolerance > LOOSE_TOLERANCE {
                    weaknesses.push(format!("A tolerance of {tolerance:e} is loose: errors of a step add up over impacts to thousands of times as much."));
                }
                if !at_samples {
                    weaknesses.push("Steps run across the kinks of the recording, where the method loses its order: the error is larger than the tolerance suggests.".into());
                }
            }
            _ => {}
        }
        weaknesses
    }
}

/// Adds a point to a trace, if one is kept.
#[inline]
fn point(trace: &mut Option<Vec<TracePoint>>, time_s: f64, angle_rad: f64, velocity_rad_s: f64) {
    if let Some(trace) = trace {
        trace.push(TracePoint {
            time_s,
            angle_rad,
            velocity_rad_s,
        });
    }
}
