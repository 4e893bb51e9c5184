//! The question of a verdict: what decides, and what is told beside the answer.

use crate::conditioning::Between;
use latchgate_kernel::model::lever::Lever;
use latchgate_kernel::model::stop::{Stop, StopModel};
use latchgate_kernel::range::Window;
use latchgate_kernel::replay::{Method, State};
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::Limits;

/// The stop models that decide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelChoice {
    /// Both; undecided where they differ.
    Auto,
    /// One of them.
    Only(StopModel),
}

impl ModelChoice {
    /// Returns the word that options and verdicts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Only(stop) => stop.name(),
        }
    }

    /// Returns the stops that are judged.
    pub fn stops(self) -> &'static [StopModel] {
        match self {
            Self::Auto => &StopModel::ALL,
            Self::Only(stop) => stop.alone(),
        }
    }
}

/// The sign of the recorded acceleration that opens, and who says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarity {
    /// One sign, declared.
    Declared(OpensWhen),
    /// Both signs, declared: the worse counts.
    Both,
    /// Nobody says: both are judged, and if they differ the verdict is undecided.
    Undeclared,
}

impl Polarity {
    /// Returns the signs that are judged.
    pub fn signs(self) -> &'static [OpensWhen] {
        match self {
            Self::Declared(OpensWhen::Negative) => &[OpensWhen::Negative],
            Self::Declared(OpensWhen::Positive) => &[OpensWhen::Positive],
            Self::Both | Self::Undeclared => &[OpensWhen::Negative, OpensWhen::Positive],
        }
    }
}

/// The question of a verdict: every setting that can change its numbers, reading, conditioning
/// and design apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    /// Stop models that decide.
    pub model: ModelChoice,
    /// Polarity.
    pub polarity: Polarity,
    /// How the acceleration runs between samples.
    pub between: Between,
    /// Integrator.
    pub method: Method,
    /// Truncation let pass in a step [rad].
    pub tolerance_rad: Option<f64>,
    /// Initial angle [rad]; `None` for that of rest on the stop.
    pub initial_angle_rad: Option<f64>,
    /// Initial angular velocity [rad/s]; `None` for rest.
    pub initial_velocity_rad_s: Option<f64>,
    /// Judged window [s].
    pub window_s: Option<Window>,
    /// Largest ensemble; 0 for nominal runs alone.
    pub members: u32,
    /// Seed of the ensemble.
    pub seed: u64,
    /// Steps that all runs together may take.
    pub work: u64,
}

impl Policy {
    /// Returns the policy of nominal runs alone, by the event-driven method from rest on the
    /// stop, over the whole recording.
    pub fn new(model: ModelChoice, polarity: Polarity) -> Self {
        Self {
            model,
            polarity,
            between: Between::default(),
            method: Method::EventDriven,
            tolerance_rad: None,
            initial_angle_rad: None,
            initial_velocity_rad_s: None,
            window_s: None,
            members: 0,
            seed: 1,
            work: Limits::default().work,
        }
    }

    /// The variants that decide, sign by sign.
    pub(crate) fn variants(&self) -> Vec<Variant> {
        self.polarity
            .signs()
            .iter()
            .flat_map(|&opens_when| {
                let stops = self.model.stops().iter();
                stops.map(move |&model| Variant { opens_when, model })
            })
            .collect()
    }

    /// The initial state asked for, what is left open being that of rest on the stop; `None` if all
    /// of it is.
    pub(crate) fn initial(&self, model: StopModel, stop: &Stop, lever: &Lever) -> Option<State> {
        if self.initial_angle_rad.is_none() && self.initial_velocity_rad_s.is_none() {
            return None;
        }
        let rest_angle_rad = stop.rest_angle_rad(model, lever);
        Some(State::new(
            self.initial_angle_rad.unwrap_or(rest_angle_rad),
            self.initial_velocity_rad_s.unwrap_or(0.0),
        ))
    }

    /// The method and tolerance for one stop. The method asked for may not know the stop that a
    /// comparison needs; that one is followed by the method that knows both.
    pub(crate) fn method_on(&self, model: StopModel) -> (Method, Option<f64>) {
        if self.method.admits(model) {
            (self.method, self.tolerance_rad)
        } else {
            (Method::EventDriven, None)
        }
    }
}

/// A stop model and the sign that opens: one of the up to four cases whose answers a verdict joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Variant {
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Stop model.
    pub model: StopModel,
}

/// Results worked out beside the answer; none of them changes the answer or its numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AssessExtras {
    /// Judge the recording after each filter as well.
    pub filter_table: bool,
    /// Keep trajectories and spectra for a report.
    pub evidence: bool,
    /// Run every ensemble, also where bounds show that it is not needed; for comparison.
    pub follow_all: bool,
    /// How much is worked out.
    pub detail: AssessDetail,
    /// Which runs that could pass are drawn.
    pub drawn_runs: DrawnRuns,
}

/// Which runs that could pass are replayed under draws of the recorded noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DrawnRuns {
    /// All of them.
    #[default]
    All,
    /// Those that eight times the standard deviation to first order would keep from a pass, and of these all draws
    /// only where 16 leave the pass open: enough for a search that asks again, with [`Self::All`], at the value it
    /// names.
    Doubtful,
}

/// How much of an assessment is worked out; the answer is the same of each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum AssessDetail {
    /// What the decision takes, without budget, reruns with one input moved, and how the members'
    /// peaks are spread. Answer, peaks, their errors, shares and the first reason are there.
    Decision,
    /// All of it.
    #[default]
    Whole,
}
