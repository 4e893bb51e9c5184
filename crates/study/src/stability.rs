//! Failures of each method: step against stiffness, grazing, chatter, and situations with an event inside
//! a sample or a step.
//!
//! Right answers come from the event-driven kernel on the same samples, with the bound it states;
//! those of the contact and of free chatter are checked against closed forms and quad precision
//! by the tests.
//!
//! - `bounces`: the free bounces of the paper's Fig. 3: exit over entry speed, bounce after
//!   bounce;
//! - `chatter`: chatter: infinitely many bounces that end at a finite time, on a rigid stop;
//! - `contact`: one contact with the soft stop: the exit speed by a fixed step;
//! - `graze`: grazing: a lever that touches the rigid stop with no speed;
//! - `situations`: situations with an event inside a sample or a step.

mod bounces;
mod chatter;
pub(crate) mod contact;
mod graze;
pub mod situations;

use super::Headline;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, Method, RunOptions, RunOutcome, State};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_recording::error::Error;
use serde::Serialize;

/// Options of the study of the failures of methods.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever.
    pub design: Design,
    /// Acceleration of one g [m/s²].
    pub gravity_m_s2: f64,
    /// Number of steps on the map of step against stiffness.
    pub points: u32,
}

/// Quality of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Grade {
    /// Error within a millionth of the right answer, or within its bound.
    Right,
    /// Error within a thousandth.
    Close,
    /// Error within a tenth.
    Poor,
    /// Error above a tenth.
    Wrong,
    /// No answer: the method broke down, or the lever never left the stop or never came to rest.
    Failed,
}

impl Grade {
    /// Grades an answer against the right one, known to within `bound`.
    pub fn of(value: Option<f64>, right: f64, bound: f64) -> Self {
        let Some(value) = value.filter(|value| value.is_finite()) else {
            return Self::Failed;
        };
        let off = (value - right).abs();
        let within = |share: f64| off <= (share * right.abs()).max(bound);
        if within(1e-6) {
            Self::Right
        } else if within(1e-3) {
            Self::Close
        } else if within(0.1) {
            Self::Poor
        } else {
            Self::Wrong
        }
    }
}

/// One answer of one method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Part of the study.
    pub subject: &'static str,
    /// Stop model.
    pub model: StopModel,
    /// Method.
    pub method: &'static str,
    /// Step [s], of a method with a fixed step.
    pub step_s: Option<f64>,
    /// Tolerance [rad], of a method that takes one.
    pub tolerance_rad: Option<f64>,
    /// Quantity varied beside the setting.
    pub variable: &'static str,
    /// Its value.
    pub variable_value: f64,
    /// Quantity computed, with its unit.
    pub quantity: &'static str,
    /// The method's answer.
    pub value: Option<f64>,
    /// The right answer.
    pub right: f64,
    /// Bound on the error of the right answer.
    pub right_bound: f64,
    /// Distance of the answer from the right one.
    pub error: Option<f64>,
    /// Error relative to the right answer [-]; absent if that is zero.
    pub relative_error: Option<f64>,
    /// Quality of the answer.
    pub grade: Grade,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// Every answer, by subject.
    pub rows: Vec<Row>,
    /// Headline figures.
    pub headlines: Vec<Headline>,
    /// Contact angular frequency times step beyond which |R(z)| > 1 [-].
    pub contact_limit: f64,
    /// Contact angular frequency of the soft stop [rad/s].
    pub contact_frequency_rad_s: f64,
    /// The right ratio of exit to entry speed of a contact [-].
    pub right_ratio: f64,
}

/// Steps per period 2π/(20 rad/s) of the two runs of the paper's Fig. 3.
pub const PAPER_STEPS: [u32; 2] = [1000, 10_000];

/// Returns the paper's step [s] for so many steps per period of 20 rad/s.
pub fn paper_step_s(steps: u32) -> f64 {
    std::f64::consts::TAU / (20.0 * f64::from(steps))
}

/// Runs every part.
///
/// # Errors
///
/// As [`replay::run`].
pub fn run(options: &Options) -> Result<Stability, Error> {
    let design = &options.design;
    let mut answer = Stability {
        rows: Vec::new(),
        headlines: Vec::new(),
        contact_limit: latchgate_kernel::numerics::rk4::stability_limit(
            design.contact_damping_ratio(),
        ),
        contact_frequency_rad_s: design.stop.contact_angular_frequency_rad_s(&design.lever),
        right_ratio: 0.0,
    };
    contact::run(options, &mut answer)?;
    bounces::run(options, &mut answer)?;
    graze::run(options, &mut answer)?;
    chatter::run(options, &mut answer)?;
    situations::run(options, &mut answer)?;
    Ok(answer)
}

/// A method at one setting.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MethodSetting {
    method: Method,
    step_s: Option<f64>,
    tolerance_rad: Option<f64>,
}

impl MethodSetting {
    fn fixed(method: fn(u32) -> Method, step_s: f64) -> Self {
        Self {
            // `step_s` overrides the steps per period, so their number has no effect.
            method: method(1),
            step_s: Some(step_s),
            tolerance_rad: None,
        }
    }

    fn adaptive(at_samples: bool, tolerance: f64) -> Self {
        Self {
            method: Method::Dopri5 { at_samples },
            step_s: None,
            tolerance_rad: Some(tolerance),
        }
    }

    fn kernel() -> Self {
        Self {
            method: Method::EventDriven,
            step_s: None,
            tolerance_rad: None,
        }
    }

    /// Returns every method at its usual setting: the paper's step, or a tolerance of 1e-9.
    fn usual(model: StopModel) -> Vec<Self> {
        let step = paper_step_s(10_000);
        [
            Self::adaptive(true, 1e-9),
            Self::adaptive(false, 1e-9),
            Self::fixed(rk4_located, step),
            Self::fixed(rk4, step),
            Self::fixed(moreau_jean, step),
        ]
        .into_iter()
        .filter(|setting| setting.method.admits(model))
        .collect()
    }

    fn row(
        &self,
        subject: &'static str,
        model: StopModel,
        variable: (&'static str, f64),
        quantity: &'static str,
        value: Option<f64>,
        (right, right_bound): (f64, f64),
    ) -> Row {
        let value = value.filter(|value| value.is_finite());
        let error = value.map(|value| (value - right).abs());
        Row {
            subject,
            model,
            method: self.method.name(),
            step_s: self.step_s,
            tolerance_rad: self.tolerance_rad,
            variable: variable.0,
            variable_value: variable.1,
            quantity,
            value,
            right,
            right_bound,
            error,
            relative_error: error
                .map(|error| error / right.abs())
                .filter(|share| share.is_finite()),
            grade: Grade::of(value, right, right_bound),
        }
    }
}

fn rk4(steps_per_period: u32) -> Method {
    Method::Rk4 { steps_per_period }
}

fn rk4_located(steps_per_period: u32) -> Method {
    Method::Rk4Located { steps_per_period }
}

fn moreau_jean(steps_per_period: u32) -> Method {
    Method::MoreauJean { steps_per_period }
}

/// A lever, an excitation and a start.
#[derive(Debug, Clone, PartialEq)]
struct StabilityCase<'a> {
    design: &'a Design,
    model: StopModel,
    signal: Signal,
    initial: Option<State>,
}

impl StabilityCase<'_> {
    fn ask(&self, setting: &MethodSetting, trace: bool) -> Result<RunOutcome, Error> {
        Ok(replay::run(
            &self.signal,
            self.design,
            &RunOptions {
                method: setting.method,
                step_s: setting.step_s,
                tolerance_rad: setting.tolerance_rad,
                initial: self.initial,
                trace,
                error_bound: setting.method == Method::EventDriven,
                ..RunOptions::new(self.model, OpensWhen::Negative)
            },
        )?)
    }
}

/// Returns no excitation for `length` [s] in `intervals` samples.
fn silence(length: f64, intervals: u32) -> Result<Signal, Error> {
    Ok(Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(f64::from(intervals) / length)?,
        samples: vec![0.0; intervals as usize + 1],
    })
}

/// Returns the speed at φ = 0 of a lever at (`angle`, `velocity`) without excitation, with the sign of `velocity`.
/// Only spring and preload act in between.
fn speed_at_stop(design: &Design, angle: f64, velocity: f64) -> f64 {
    let lever = &design.lever;
    let potential =
        lever.preload_torque_nm * angle + 0.5 * lever.spring_stiffness_nm_per_rad * angle * angle;
    let square = velocity * velocity + 2.0 * potential / lever.moment_of_inertia_kg_m2;
    square.max(0.0).sqrt().copysign(velocity)
}
