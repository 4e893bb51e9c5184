//! Replay: drives the lever with a signal and records what it does.

use crate::model::stop::StopModel;
use crate::units::OpensWhen;
use serde::Serialize;

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
