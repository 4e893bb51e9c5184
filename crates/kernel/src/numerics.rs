//! Integrators and root location that know no latch and no file: a time, a state, a function.
//!
//! `rk4` and `dopri5` take steps; `event` finds where something happens inside one, `polynomial`
//! the roots of a Taylor step; `lanes` computes with several numbers at once.

pub mod dopri5;
pub mod event;
pub mod lanes;
pub mod polynomial;
pub mod rk4;

/// One degree of freedom, advanced in SI units.
pub trait Motion {
    /// Returns the angular acceleration [rad/s²] at time `t` [s], angle `q`
    /// [rad] and angular velocity `v` [rad/s].
    fn acceleration(&self, t: f64, q: f64, v: f64) -> f64;
}
