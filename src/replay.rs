//! Replay: drives the lever with a signal and records what it does.

pub mod batch;
mod kernel;
mod rk4;
mod sensitivity;
mod tally;
mod taylor;

use crate::conditioning::Signal;
use crate::error::{Error, ErrorKind};
use crate::model::Design;
use crate::model::lever::Lever;
use crate::model::stop::{Stop, StopModel};
/// Limit of the contact's angular frequency times the step, beyond which the fixed-step
/// method gains energy on a soft stop.
pub use crate::numerics::rk4::STABILITY_LIMIT as RK4_STABILITY_LIMIT;
use crate::units::OpensWhen;
pub use rk4::step_seconds as fixed_step_s;

use kernel::Kernel;
use serde::Serialize;
use tally::Tally;

/// How a run is integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// Every release, impact, contact and rest located; the default.
    EventDriven,
    /// Fixed-step Runge-Kutta of fourth order with events on its own grid, as in the paper:
    /// step = natural period 2π/ω0 over `steps_per_period`.
    Rk4 {
        /// Steps per natural period.
        steps_per_period: u32,
    },
}

impl Method {
    /// Returns the name that options and verdicts use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::EventDriven => "event-driven",
            Self::Rk4 { .. } => "rk4",
        }
    }
}

/// What a run cost.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Integration steps.
    pub steps: u64,
    /// Evaluations of the right-hand side; for a Taylor step the orders computed.
    pub rhs: u64,
    /// Releases, impacts, contacts and rests.
    pub events: u64,
}

/// What the lever did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    /// Stop model.
    pub model: StopModel,
    /// Integrator.
    pub method: &'static str,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Largest angle in the window [rad].
    pub peak_angle_rad: f64,
    /// When [s].
    pub peak_time_s: f64,
    /// First time the angle exceeds the threshold in the window [s].
    pub first_crossing_s: Option<f64>,
    /// Total time above the threshold in the window [s].
    pub time_above_threshold_s: f64,
    /// First time the angle becomes positive [s].
    pub first_release_s: Option<f64>,
    /// Impacts (soft stop: contact entries) faster than 1e-3 rad/s.
    pub impacts: u64,
    /// The first 200 of them: time [s], velocity before [rad/s].
    pub impact_list: Vec<[f64; 2]>,
    /// Angle at the window's last sample [rad].
    pub final_angle_rad: f64,
    /// Angular velocity there [rad/s].
    pub final_velocity_rad_s: f64,
    /// Whether the lever's energy exceeds 1e-9 J there.
    pub moving_at_end: bool,
    /// Largest angle after the window's last sample under no excitation [rad]; `None` if at rest.
    pub coast_peak_angle_rad: Option<f64>,
    /// Bound on the error of the peak angle from integration and rounding [rad].
    pub numerical_error_rad: f64,
    /// What it cost.
    pub work: Work,
}

/// One point of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracePoint {
    /// Time [s].
    pub time_s: f64,
    /// Angle [rad].
    pub angle_rad: f64,
    /// Angular velocity [rad/s].
    pub velocity_rad_s: f64,
}

/// What a run is asked beside signal and design.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOptions {
    /// Stop model.
    pub stop: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Integrator.
    pub method: Method,
    /// Truncation let pass in a step [rad]; `None` for the method's own.
    pub tolerance_rad: Option<f64>,
    /// Initial angle [rad] and angular velocity [rad/s]; `None` for rest on the stop.
    pub initial: Option<(f64, f64)>,
    /// First and last sample of the judged window; `None` for all.
    pub window: Option<(usize, usize)>,
    /// Keep the trajectory for drawing.
    pub trace: bool,
    /// Bound the error; without it `numerical_error_rad` is infinite, and the run cheaper.
    pub error_bound: bool,
}

impl RunOptions {
    /// Returns the options of a nominal run: event-driven, from rest, the whole record judged.
    #[must_use]
    pub fn new(stop: StopModel, opens_when: OpensWhen) -> Self {
        Self {
            stop,
            opens_when,
            method: Method::EventDriven,
            tolerance_rad: None,
            initial: None,
            window: None,
            trace: false,
            error_bound: true,
        }
    }
}

/// A run with what is not part of its result.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// What the lever did.
    pub run: Run,
    /// The trajectory, if it was asked for; else empty.
    pub trace: Vec<TracePoint>,
    /// Bound on the error of the coast's peak [rad].
    pub coast_error_rad: f64,
    /// The method could not follow the lever: its numbers mean nothing.
    pub broke_down: bool,
}

/// Drives the lever of `design` with `signal`.
///
/// The whole signal up to the window's last sample drives the lever; peak, crossing and time
/// above the threshold are those inside the window. After its last sample the lever coasts
/// without excitation until it can no longer rise above what it has reached.
///
/// # Errors
///
/// [`ErrorKind::TooShort`] for a signal of fewer than two samples,
/// [`ErrorKind::OutOfRange`] for an initial state that the stop does not admit, a sample that
/// is not finite, or a fixed step that would need more than 10⁹ steps.
pub fn run(signal: &Signal, design: &Design, options: &RunOptions) -> Result<Outcome, Error> {
    let count = signal.samples.len();
    if count < 2 {
        return Err(ErrorKind::TooShort {
            what: "a replay",
            needed: 2,
            found: count,
        }
        .into());
    }
    check_initial(options)?;
    if let Some(bad) = signal.samples.iter().find(|a| !a.is_finite()) {
        return Err(ErrorKind::NonFinite {
            found: bad.to_string(),
        }
        .into());
    }
    let (first, last) = options.window.unwrap_or((0, count - 1));
    let (first, last) = (first.min(count - 1), last.min(count - 1));
    let outcome = match options.method {
        Method::EventDriven => event_driven(signal, design, options, first, last),
        Method::Rk4 { steps_per_period } => {
            fixed_step(signal, design, options, steps_per_period, last)?
        }
    };
    tracing::debug!(
        model = outcome.run.model.name(),
        opens_when = outcome.run.opens_when.name(),
        peak_angle_rad = outcome.run.peak_angle_rad,
        steps = outcome.run.work.steps,
        "lever replayed"
    );
    Ok(outcome)
}

fn check_initial(options: &RunOptions) -> Result<(), Error> {
    let Some((angle, velocity)) = options.initial else {
        return Ok(());
    };
    let least = if options.stop == StopModel::Rigid {
        0.0
    } else {
        -ANGLE_LIMIT
    };
    if !(least..=ANGLE_LIMIT).contains(&angle)
        || !velocity.is_finite()
        || velocity.abs() > VELOCITY_LIMIT
    {
        return Err(ErrorKind::OutOfRange {
            what: "initial state (phi0 [rad], omega0 [rad/s])".into(),
            expected: format!(
                "{least} to {ANGLE_LIMIT} rad on a {} stop and at most {VELOCITY_LIMIT} rad/s",
                options.stop.name()
            ),
            found: format!("({angle}, {velocity})"),
        }
        .into());
    }
    Ok(())
}

/// Largest initial angle taken [rad].
const ANGLE_LIMIT: f64 = 100.0;

/// Largest initial angular velocity taken [rad/s].
const VELOCITY_LIMIT: f64 = 1e5;

fn event_driven(
    signal: &Signal,
    design: &Design,
    options: &RunOptions,
    first: usize,
    last: usize,
) -> Outcome {
    let tally = Tally::new(design.criterion.threshold_rad, options.trace);
    let mut kernel = Kernel::new(
        design,
        options.stop,
        options.initial,
        options.tolerance_rad,
        tally,
    )
    .for_samples(last);
    if !options.error_bound {
        kernel = kernel.without_error_bound();
    }
    let (sign, interval) = (options.opens_when.sign(), signal.rate.interval().seconds());
    let lift_off = kernel.lift_off_acceleration();
    let (angle, velocity) = kernel.state();
    if angle > 0.0 || (angle >= 0.0 && velocity > 0.0) {
        kernel.tally.release(signal.start_s);
    }
    kernel.tally.point(signal.start_s, angle, velocity);
    let mut index = 0;
    while index < last {
        if index == first {
            let error = kernel.angle_error();
            let angle = kernel.state().0;
            kernel.tally.open_window(angle, signal.time_s(index), error);
        }
        if kernel.dwells() {
            // Pressed onto the rigid stop all through the samples: nothing moves.
            let stop_at = if index < first { first } else { last };
            let moved = index + pressed_samples(&signal.samples[index..=stop_at], sign, lift_off);
            if moved > index {
                index = moved;
                continue;
            }
        }
        let (from, to) = (
            sign * signal.samples[index],
            sign * signal.samples[index + 1],
        );
        kernel.advance(signal.time_s(index), interval, from, to);
        index += 1;
        if kernel.stuck {
            break;
        }
    }
    if first >= last {
        let error = kernel.angle_error();
        kernel
            .tally
            .open_window(kernel.state().0, signal.time_s(last), error);
    }
    let end = signal.time_s(last);
    let (angle, velocity) = kernel.state();
    let error = kernel.angle_error();
    kernel.tally.close_window(angle, end, error);
    kernel.tally.point(end, angle, velocity);
    let moving = energy_j(design, options.stop, angle, velocity) > MOVING_ENERGY_J;
    let stuck = kernel.stuck;
    let (peak, work, trace) = (kernel.tally.peak, kernel.work, kernel.tally.trace.take());
    let finished = kernel.tally.clone();
    let coast = if moving && !stuck {
        kernel.coast(end)
    } else {
        None
    };
    let broke_down = stuck
        || (moving && coast.is_none())
        || !peak.angle.is_finite()
        || !peak.bound().is_finite();
    Outcome {
        run: Run {
            model: options.stop,
            method: options.method.name(),
            opens_when: options.opens_when,
            peak_angle_rad: finite(peak.angle),
            peak_time_s: peak.time,
            first_crossing_s: finished.first_crossing,
            time_above_threshold_s: finished.time_above,
            first_release_s: finished.first_release,
            impacts: finished.impacts,
            impact_list: finished.impact_list,
            final_angle_rad: finite(angle),
            final_velocity_rad_s: finite(velocity),
            moving_at_end: moving,
            coast_peak_angle_rad: coast.map(|peak| peak.angle),
            numerical_error_rad: if !options.error_bound {
                f64::INFINITY
            } else if peak.bound().is_finite() {
                peak.bound()
            } else {
                f64::MAX
            },
            work,
        },
        trace: trace.unwrap_or_default(),
        coast_error_rad: coast.map_or(0.0, |peak| finite(peak.bound())),
        broke_down,
    }
}

/// The number, or the largest there is in place of what is none: a run that broke down still
/// has to be written down.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::MAX }
}

/// Returns how many sample intervals from the first on lie wholly above `lift_off`, in the
/// model's sign: the lever stays on the rigid stop through them.
fn pressed_samples(samples: &[f64], sign: f64, lift_off: f64) -> usize {
    /// Samples looked at together, so that the compiler compares them side by side.
    const BLOCK: usize = 16;
    let mut pressed = 0;
    for block in samples.chunks_exact(BLOCK) {
        if !block
            .iter()
            .fold(true, |all, a| all & (sign * a > lift_off))
        {
            break;
        }
        pressed += BLOCK;
    }
    let rest = samples[pressed..]
        .iter()
        .take_while(|a| sign * **a > lift_off);
    (pressed + rest.count()).saturating_sub(1)
}

/// Energy above which a lever counts as moving [J].
const MOVING_ENERGY_J: f64 = 1e-9;

/// Steps of a fixed-step run at most.
const FIXED_STEPS_MAX: f64 = 1e9;

/// Returns the lever's energy I0 φ'²/2 + T0 φ + k φ²/2 [J], k being the contact's stiffness
/// inside the soft stop, so that what a compressed stop holds is counted.
#[must_use]
pub fn energy_j(design: &Design, stop: StopModel, angle_rad: f64, velocity_rad_s: f64) -> f64 {
    energy_of(&design.lever, &design.stop, stop, angle_rad, velocity_rad_s)
}

fn energy_of(lever: &Lever, stop: &Stop, model: StopModel, angle: f64, velocity: f64) -> f64 {
    let stiffness = if angle < 0.0 && model == StopModel::Soft {
        stop.contact_stiffness_nm_per_rad(lever)
    } else {
        lever.spring_stiffness_nm_per_rad
    };
    0.5 * lever.moment_of_inertia_kg_m2 * velocity * velocity
        + lever.preload_torque_nm * angle
        + 0.5 * stiffness * angle * angle
}

fn fixed_step(
    signal: &Signal,
    design: &Design,
    options: &RunOptions,
    steps_per_period: u32,
    last: usize,
) -> Result<Outcome, Error> {
    let step = rk4::step_seconds(design, steps_per_period);
    if !step.is_finite() {
        return Err(ErrorKind::OutOfRange {
            what: "lever.spring_stiffness_nm_per_rad".into(),
            expected: "positive, since the fixed step is a part of the natural period".into(),
            found: "0".into(),
        }
        .into());
    }
    let steps = (signal.time_s(last) - signal.start_s) / step;
    if steps.is_nan() || 2.0 * steps > FIXED_STEPS_MAX {
        return Err(ErrorKind::OutOfRange {
            what: "steps of the fixed-step method".into(),
            expected: format!("at most {FIXED_STEPS_MAX:e}; lower --steps-per-period"),
            found: format!("{:e}", 2.0 * steps),
        }
        .into());
    }
    let coarse = rk4::run(
        signal,
        design,
        options.stop,
        options,
        steps_per_period,
        last,
    );
    let fine = rk4::run(
        signal,
        design,
        options.stop,
        &RunOptions {
            trace: false,
            ..options.clone()
        },
        steps_per_period.saturating_mul(2),
        last,
    );
    let (angle, velocity) = coarse.state;
    let broke_down = !angle.is_finite() || !velocity.is_finite() || !coarse.peak.0.is_finite();
    // Events on the grid make the method one of first order: the error is about twice the
    // change that halving the step brings; twice that again is stated.
    let error = 4.0 * (coarse.peak.0 - fine.peak.0).abs();
    let moving = !broke_down && energy_j(design, options.stop, angle, velocity) > MOVING_ENERGY_J;
    let coast = if moving {
        let start = match options.stop {
            StopModel::Rigid => (angle.max(0.0), velocity),
            StopModel::Soft => (angle, velocity),
        };
        let tally = Tally::new(design.criterion.threshold_rad, false);
        Kernel::new(design, options.stop, Some(start), None, tally).coast(signal.time_s(last))
    } else {
        None
    };
    Ok(Outcome {
        run: Run {
            model: options.stop,
            method: options.method.name(),
            opens_when: options.opens_when,
            peak_angle_rad: finite(coarse.peak.0),
            peak_time_s: coarse.peak.1,
            first_crossing_s: coarse.first_crossing,
            time_above_threshold_s: coarse.time_above,
            first_release_s: coarse.first_release,
            impacts: coarse.impacts,
            impact_list: coarse.impact_list,
            final_angle_rad: finite(angle),
            final_velocity_rad_s: finite(velocity),
            moving_at_end: moving,
            coast_peak_angle_rad: coast.map(|peak| peak.angle),
            numerical_error_rad: finite(error),
            work: coarse.work,
        },
        trace: coarse.trace,
        coast_error_rad: error,
        broke_down: broke_down || (moving && coast.is_none()),
    })
}
