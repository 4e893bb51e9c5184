//! Replay: drives the lever with a signal and records what it does.
//!
//! `drive` is the one loop: it carries a body through the samples. The body's `kernel` takes flight,
//! contact, dwell and chatter from event to event, some of which `ends` names, by the steps of
//! `taylor` under `forcing`; whole samples without events go to `flight_fast`, by `eventless_step`,
//! and to `contact_fast`. `sensitivity` carries the bound on rounding along, `tangent` the exact
//! derivatives, and `recorder` keeps peak, crossings, impacts and trace.
//!
//! Around it: `batch` follows many levers on one recording, `harmonic` one on a sine and
//! `strobe_batch` many of these; `energy` bounds how far a lever may still come; `methods` are the
//! integrators to compare with, `double_double` is one that says how far rounding has carried a peak, and
//! `breakdown` says why a lever could not be followed.

pub mod batch;
mod body;
mod breakdown;
mod catch;
mod catch_run;
mod contact_fast;
pub mod double_double;
mod drive;
mod ends;
mod energy;
mod eventless_step;
mod flight_fast;
mod forcing;
mod harmonic;
mod kernel;
mod methods;
mod recorder;
mod sensitivity;
pub mod strobe_batch;
mod tangent;
mod taylor;

use crate::error::Error;
use crate::model::Design;
use crate::model::excitation::{Harmonic, Sampled};
use crate::model::stop::StopModel;
use crate::parallel::Control;
use crate::signal::{CURVED, Pieces, Projection, Reading, STRAIGHT};
use crate::units::{OpensWhen, SampleRate};
pub use breakdown::Breakdown;
pub use catch_run::CatchRun;
pub use methods::{
    ADAPTIVE_TOLERANCE, ADAPTIVE_TOLERANCE_MIN, REST_SPEED_RAD_S, step_seconds as fixed_step_s,
};
use std::ops::Sub;

pub use harmonic::{Section, Strobe, StrobeMap};

use drive::EventDriven;
use energy::energy_of;
use methods::Problem;
use serde::{Deserialize, Serialize};

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
    /// The same with steps that end at samples and events.
    Rk4Located {
        /// Steps per natural period, at least.
        steps_per_period: u32,
    },
    /// The adaptive pair of Dormand and Prince with located events.
    Dopri5 {
        /// Ends a step at each sample, where the excitation has a kink.
        at_samples: bool,
    },
    /// Time-stepping after Moreau and Jean; the rigid stop only.
    MoreauJean {
        /// Steps per natural period.
        steps_per_period: u32,
    },
}

impl Method {
    /// Returns the method without its numbers.
    pub fn kind(self) -> MethodKind {
        match self {
            Self::EventDriven => MethodKind::EventDriven,
            Self::Rk4 { .. } => MethodKind::Rk4,
            Self::Rk4Located { .. } => MethodKind::Rk4Located,
            Self::Dopri5 { at_samples: false } => MethodKind::Dopri5,
            Self::Dopri5 { at_samples: true } => MethodKind::Dopri5Samples,
            Self::MoreauJean { .. } => MethodKind::MoreauJean,
        }
    }

    /// Returns the name that options and verdicts use.
    pub fn name(self) -> &'static str {
        self.kind().name()
    }
}

/// A method without its numbers, as documents state it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MethodKind {
    /// [`Method::EventDriven`].
    EventDriven,
    /// [`Method::Rk4`].
    Rk4,
    /// [`Method::Rk4Located`].
    Rk4Located,
    /// [`Method::Dopri5`] with steps of its own.
    Dopri5,
    /// [`Method::Dopri5`] with steps that end at samples.
    Dopri5Samples,
    /// [`Method::MoreauJean`].
    MoreauJean,
}

impl MethodKind {
    /// Returns the name that options and verdicts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::EventDriven => "event-driven",
            Self::Rk4 => "rk4",
            Self::Rk4Located => "rk4-located",
            Self::Dopri5 => "dopri5",
            Self::Dopri5Samples => "dopri5-samples",
            Self::MoreauJean => "moreau-jean",
        }
    }
}

/// What a run cost.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Integration steps.
    pub steps: u64,
    /// Evaluations of the right-hand side; for a Taylor step the orders computed.
    pub rhs: u64,
    /// Releases, impacts, contacts and rests.
    pub events: u64,
}

impl Work {
    /// Returns the work as limits count it, in steps of a whole sample: a step with more than eight
    /// evaluations counts as more.
    pub fn counted(&self) -> u64 {
        self.steps.max(self.rhs / 8)
    }
}

/// How much a run may take, and whose wish to stop it heeds.
#[derive(Debug, Clone, Copy)]
pub struct Within<'a> {
    /// Steps after which it is given up.
    pub steps_max: u64,
    /// Asked from time to time whether to go on.
    pub control: &'a Control<'a>,
}

impl Within<'_> {
    /// As many steps as a run takes, and nothing that stops it.
    pub const UNBOUNDED: Within<'static> = Within {
        steps_max: u64::MAX,
        control: &Control::unwatched(1),
    };

    /// Steps between two looks at the control, some hundredths of a second.
    const LOOK_EVERY: u64 = 1 << 17;

    /// Tells whether `steps` taken, of which `looked` had been taken at the last look, are too
    /// many or the wish to stop has come.
    fn ends(&self, steps: u64, looked: &mut u64) -> bool {
        if steps >= *looked + Self::LOOK_EVERY {
            *looked = steps;
            return self.control.check().is_err();
        }
        false
    }
}

/// What a run states of the error of its peak angle [rad].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "rad", rename_all = "lowercase")]
pub enum ErrorStatement {
    /// The error is at most this.
    Bound(f64),
    /// The error is about this; nothing proves it. A run that only estimates its error decides no pass.
    Estimate(f64),
}

impl ErrorStatement {
    /// Returns the number [rad], whatever its kind.
    pub fn rad(self) -> f64 {
        match self {
            Self::Bound(rad) | Self::Estimate(rad) => rad,
        }
    }

    /// True if the error is bounded.
    pub fn is_bound(self) -> bool {
        matches!(self, Self::Bound(_))
    }
}

/// What the lever did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Stop model.
    pub model: StopModel,
    /// Integrator.
    pub method: MethodKind,
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
    /// Error of the peak angle from integration and rounding [rad].
    pub numerical_error_rad: f64,
    /// The same with its kind.
    pub error: ErrorStatement,
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

/// Where a lever is and how fast it turns; written as a pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(into = "(f64, f64)")]
pub struct State {
    /// Angle [rad].
    pub angle_rad: f64,
    /// Angular velocity [rad/s].
    pub velocity_rad_s: f64,
}

impl State {
    /// Returns the state of an angle [rad] and an angular velocity [rad/s].
    pub const fn new(angle_rad: f64, velocity_rad_s: f64) -> Self {
        Self {
            angle_rad,
            velocity_rad_s,
        }
    }
}

impl From<State> for (f64, f64) {
    fn from(state: State) -> Self {
        (state.angle_rad, state.velocity_rad_s)
    }
}

impl Sub for State {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::new(
            self.angle_rad - other.angle_rad,
            self.velocity_rad_s - other.velocity_rad_s,
        )
    }
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
    /// Step of a fixed-step method [s]; `None` for its steps per natural period.
    pub step_s: Option<f64>,
    /// Initial state; `None` for rest on the stop.
    pub initial: Option<State>,
    /// What two sensors' accelerations are along and across the way of the centre of mass.
    pub projection: Projection,
    /// First and last sample of the judged window; `None` for all.
    pub window: Option<(usize, usize)>,
    /// Keep the trajectory for drawing.
    pub trace: bool,
    /// Bound the error; without it `numerical_error_rad` is infinite, and the run cheaper.
    pub error_bound: bool,
    /// White noise of the base acceleration whose effect on the peak is asked for, as the variance of a
    /// sample times its interval [m²/s³]; of an event-driven run that bounds its error.
    pub noise_m2_s3: Option<f64>,
    /// Only the peak, and what came before it, is asked for: the event-driven run ends where nothing to
    /// come can raise the peak, and the rest tells of the time until then.
    pub peak_only: bool,
}

impl RunOptions {
    /// Returns the options of a nominal run: event-driven, from rest, the whole record judged.
    pub fn new(stop: StopModel, opens_when: OpensWhen) -> Self {
        Self {
            stop,
            opens_when,
            method: Method::EventDriven,
            tolerance_rad: None,
            step_s: None,
            initial: None,
            projection: Projection::ALIGNED,
            window: None,
            trace: false,
            error_bound: true,
            noise_m2_s3: None,
            peak_only: false,
        }
    }
}

/// A run with what is not part of its result.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOutcome {
    /// What the lever did.
    pub run: Run,
    /// The trajectory, if it was asked for; else empty.
    pub trace: Vec<TracePoint>,
    /// What an inertia catch did, if the design has one.
    pub catch: Option<CatchRun>,
    /// Its trajectory, if it was asked for; else empty.
    pub catch_trace: Vec<TracePoint>,
    /// What run and coast cost, as limits count it.
    pub spent: u64,
    /// Bound on the error of the coast's peak [rad].
    pub coast_error_rad: f64,
    /// Standard deviation of the peak, or of the coast's if that is larger, to first order in the noise
    /// asked about [rad]; of a lever that nearly grazes its stop more.
    pub deviation_rad: Option<f64>,
    /// Bound on the error of the final angle [rad]; only the event-driven method states it.
    pub final_error_rad: Option<f64>,
    /// The method could not follow the lever: its numbers mean nothing.
    pub broke_down: bool,
    /// Why, where the method can say it.
    pub breakdown: Option<Breakdown>,
    /// Lowest angle at the end of a step [rad]; the event-driven method does not keep it.
    pub lowest_angle_rad: Option<f64>,
}

/// Drives the lever of `design` with a signal as it is read; a [`Signal`](crate::signal::Signal) alone is
/// read by straight lines.
///
/// The whole signal up to the window's last sample drives the lever; peak, crossing and time
/// above the threshold are those inside the window. After its last sample the lever coasts
/// without excitation until it can no longer rise above what it has reached.
///
/// # Errors
///
/// [`Error::TooShort`] for a signal of fewer than two samples,
/// [`Error::OutOfRange`] for an initial state that the stop does not admit, a sample that
/// is not finite, or a fixed step that would need more than 10⁹ steps.
pub fn run<'a>(
    reading: impl Into<Reading<'a>>,
    design: &Design,
    options: &RunOptions,
) -> Result<RunOutcome, Error> {
    run_within(reading, design, options, &Within::UNBOUNDED)
}

/// As [`run`], of a run that may be stopped or take too much: one that needs more steps than it may
/// take breaks down.
///
/// # Errors
///
/// As [`run`]; [`Error::Stopped`].
pub fn run_within<'a>(
    reading: impl Into<Reading<'a>>,
    design: &Design,
    options: &RunOptions,
    within: &Within<'_>,
) -> Result<RunOutcome, Error> {
    let reading = reading.into();
    let signal = reading.signal();
    let count = signal.samples.len();
    if count < 2 {
        return Err(Error::TooShort {
            what: "a replay",
            needed: 2,
            found: count,
        });
    }
    check_initial(options)?;
    check_finite(&reading)?;
    check_catch(&reading, design, options)?;
    let (first, last) = options.window.unwrap_or((0, count - 1));
    let (first, last) = (first.min(count - 1), last.min(count - 1));
    let parts = match options.method {
        Method::EventDriven => subdivision(signal.rate, design, options.stop),
        _ => 1,
    };
    let projected = reading.projected(&options.projection);
    let reading = projected.divided(parts);
    let question = Question {
        design,
        options,
        first: parts * first,
        last: parts * last,
        within,
    };
    let outcome = if reading.is_straight() {
        followed(reading.pieces::<STRAIGHT>(), question)?
    } else {
        followed(reading.pieces::<CURVED>(), question)?
    };
    within.control.check()?;
    Ok(outcome)
}

/// What is asked of a run beside what drives it.
#[derive(Clone, Copy)]
struct Question<'a> {
    design: &'a Design,
    options: &'a RunOptions,
    /// First and last judged sample.
    first: usize,
    last: usize,
    within: &'a Within<'a>,
}

fn followed<const K: usize>(
    pieces: Pieces<'_, K>,
    question: Question<'_>,
) -> Result<RunOutcome, Error> {
    match question.options.method {
        Method::EventDriven => Ok(pulp::Arch::new().dispatch(EventDriven { pieces, question })),
        _ => compared(pieces, question),
    }
}

/// Returns into how many parts each sample interval is divided before a replay, so that the soft
/// stop's own oscillation turns, and dies away, by no more than its whole samples in contact allow.
/// Between the samples nothing changes.
pub fn subdivision(rate: SampleRate, design: &Design, stop: StopModel) -> usize {
    /// Beyond it a sample is as cheap by series.
    const PARTS_MAX: f64 = 64.0;
    if !stop.yields() {
        return 1;
    }
    let Design { lever, stop, .. } = design;
    let frequency = stop.contact_angular_frequency_rad_s(lever);
    let damping = stop.contact_damping_nm_s_per_rad(lever) / lever.moment_of_inertia_kg_m2;
    // A tenth less leaves room for the levers of an ensemble.
    let allowed = 0.9 * contact_fast::PHASE_MAX;
    let parts = (frequency.max(damping) * rate.interval().seconds() / allowed).ceil();
    if parts > 1.0 && parts <= PARTS_MAX {
        parts as usize
    } else {
        1
    }
}

/// Refuses what an inertia catch does not go with.
fn check_catch(reading: &Reading<'_>, design: &Design, options: &RunOptions) -> Result<(), Error> {
    if design.catch.is_none() {
        return Ok(());
    }
    if options.method != Method::EventDriven {
        let expected = "event-driven for a design with an inertia catch";
        return Err(Error::out_of_range(
            "method",
            expected,
            options.method.name(),
        ));
    }
    if reading.second().is_some() {
        let expected =
            "one for a design with an inertia catch, of whose directions nothing is stated";
        return Err(Error::out_of_range("channels", expected, "two"));
    }
    Ok(())
}

/// Refuses samples, of either sensor, that are no numbers.
fn check_finite(reading: &Reading<'_>) -> Result<(), Error> {
    let second = reading.second().into_iter();
    let mut samples = second
        .chain([reading])
        .flat_map(|reading| &reading.signal().samples);
    match samples.find(|a| !a.is_finite()) {
        Some(bad) => Err(Error::NonFinite {
            found: bad.to_string(),
        }),
        None => Ok(()),
    }
}

fn check_initial(options: &RunOptions) -> Result<(), Error> {
    let Some(state) = options.initial else {
        return Ok(());
    };
    let (angle, velocity) = (state.angle_rad, state.velocity_rad_s);
    let least = match options.stop.yields() {
        true => -ANGLE_LIMIT,
        false => 0.0,
    };
    if !(least..=ANGLE_LIMIT).contains(&angle)
        || !velocity.is_finite()
        || velocity.abs() > VELOCITY_LIMIT
    {
        return Err(Error::out_of_range(
            "initial state (phi0 [rad], omega0 [rad/s])",
            format!(
                "{least} to {ANGLE_LIMIT} rad on a {} stop and at most {VELOCITY_LIMIT} rad/s",
                options.stop.name()
            ),
            format!("({angle}, {velocity})"),
        ));
    }
    Ok(())
}

/// Largest initial angle taken [rad].
const ANGLE_LIMIT: f64 = 100.0;

/// Largest initial angular velocity taken [rad/s].
const VELOCITY_LIMIT: f64 = 1e5;

/// Energy above which a lever counts as moving [J].
const MOVING_ENERGY_J: f64 = 1e-9;

/// Returns the lever's energy I0 φ'²/2 + T0 φ + k φ²/2 [J], k being the contact's stiffness
/// inside the soft stop, so that what a compressed stop holds is counted.
pub fn energy_j(design: &Design, stop: StopModel, angle_rad: f64, velocity_rad_s: f64) -> f64 {
    energy_of(&design.lever, &design.stop, stop, angle_rad, velocity_rad_s)
}

/// Runs a method to compare with on the samples up to the last judged one.
fn compared<const K: usize>(
    pieces: Pieces<'_, K>,
    question: Question<'_>,
) -> Result<RunOutcome, Error> {
    let Question {
        design,
        options,
        first,
        last,
        within,
    } = question;
    let signal = pieces.signal;
    let excitation = Sampled {
        pieces,
        sign: options.opens_when.sign() * design.lever.unbalance_sign(),
        radial: pieces.second(),
    };
    methods::run(
        &Problem {
            excitation: &excitation,
            design,
            stop: options.stop,
            initial: options.initial,
            start_s: signal.start_s,
            end_s: signal.time_s(last),
            judged_from_s: signal.time_s(first),
            longest_step_s: signal.rate.interval().seconds(),
            step_s: options.step_s,
            trace: options.trace,
            within,
        },
        options,
    )
}

/// Drives the lever with a smooth sine from time 0 to `end_s` [s], without samples between.
///
/// The event-driven method takes the sine as it is, a quarter of a period at a time; the others
/// evaluate it at their own instants.
///
/// # Errors
///
/// As [`run`]; [`Error::OutOfRange`] for a window, an end that is not positive or more than
/// 10⁷ periods away, an amplitude or a phase that is not finite.
pub fn run_harmonic(
    excitation: &Harmonic,
    end_s: f64,
    design: &Design,
    options: &RunOptions,
) -> Result<RunOutcome, Error> {
    check_initial(options)?;
    let refuse =
        |what: &str, expected: &str, found: String| Err(Error::out_of_range(what, expected, found));
    if options.window.is_some() {
        return refuse("window", "none on a smooth sine", "a window".into());
    }
    if !(end_s > 0.0 && end_s.is_finite()) {
        return refuse("end [s]", "positive and finite", end_s.to_string());
    }
    if !(excitation.amplitude_m_s2.is_finite() && excitation.phase_rad.is_finite()) {
        return refuse(
            "amplitude [m/s²] and phase [rad]",
            "finite",
            format!("{} and {}", excitation.amplitude_m_s2, excitation.phase_rad),
        );
    }
    // A hundredth of a period stands in for the sample interval.
    let longest_step_s = std::f64::consts::TAU / (100.0 * excitation.angular_frequency_rad_s);
    if !(longest_step_s > 0.0 && longest_step_s.is_finite()) {
        return refuse(
            "angular frequency [rad/s]",
            "positive and finite",
            excitation.angular_frequency_rad_s.to_string(),
        );
    }
    if end_s > harmonic::PERIODS_MAX * 100.0 * longest_step_s {
        return refuse(
            "end [s]",
            "at most 10⁷ periods of the sine",
            end_s.to_string(),
        );
    }
    let excitation = Harmonic {
        amplitude_m_s2: options.opens_when.sign()
            * design.lever.unbalance_sign()
            * excitation.amplitude_m_s2,
        ..*excitation
    };
    if options.method == Method::EventDriven {
        return Ok(harmonic::run(&excitation, end_s, design, options));
    }
    methods::run(
        &Problem {
            within: &Within::UNBOUNDED,
            excitation: &excitation,
            design,
            stop: options.stop,
            initial: options.initial,
            start_s: 0.0,
            end_s,
            judged_from_s: 0.0,
            longest_step_s,
            step_s: options.step_s,
            trace: options.trace,
        },
        options,
    )
}
