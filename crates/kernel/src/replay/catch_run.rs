//! What an inertia catch did in a run.

use serde::{Deserialize, Serialize};

/// What an inertia catch did beside a lever.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CatchRun {
    /// First time it reaches its engagement angle [s].
    pub engaged_s: Option<f64>,
    /// Time at which one that does not fall back comes to its end stop [s].
    pub locked_s: Option<f64>,
    /// First time the lever comes to the angle at which it can be stopped [s].
    pub lever_arrives_s: Option<f64>,
    /// Its angular velocity then [rad/s].
    pub lever_arrives_rad_s: Option<f64>,
    /// Times it has stopped the lever.
    pub stops: u64,
    /// First time the lever goes past it [s].
    pub lever_passes_s: Option<f64>,
    /// Its largest angle [rad].
    pub peak_angle_rad: f64,
    /// First time at which the errors do not tell which of the two came first [s]; the lever's peak is
    /// unknown from then on.
    pub tie_s: Option<f64>,
}
