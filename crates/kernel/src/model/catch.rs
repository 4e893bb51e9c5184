//! An inertia catch: a second lever that blocks the first where it is fast enough.

use super::lever::Lever;
use super::stop::Stop;
use serde::{Deserialize, Serialize};

/// An inertia catch beside the lever: I₂ ψ'' + c₂ ψ' + k₂ ψ = −T₂ − S₂ a cos ψ, 0 ≤ ψ ≤ ψm.
///
/// The lever cannot go beyond φb while ψ ≥ ψb, nor the catch beyond ψb while φ > φb. The faces that meet pass
/// their force through the catch's pivot, so that neither drives the other: all that couples the two is
/// which of them comes first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Catch {
    /// Moment of inertia about its pivot, I₂ [kg m²].
    pub moment_of_inertia_kg_m2: f64,
    /// Damping at its pivot, c₂ [N m s/rad].
    pub pivot_damping_nm_s_per_rad: f64,
    /// Stiffness of its spring, k₂ [N m/rad].
    pub spring_stiffness_nm_per_rad: f64,
    /// Preload torque of its spring at ψ = 0, T₂ [N m].
    pub preload_torque_nm: f64,
    /// Unbalance, mass times arm, S₂ [kg m].
    pub unbalance_kg_m: f64,
    /// Angle from which on it blocks the lever, ψb [rad].
    pub engagement_angle_rad: f64,
    /// Angle of its end stop, ψm [rad].
    pub end_stop_angle_rad: f64,
    /// Angle at which it blocks the lever, φb [rad].
    pub lever_angle_rad: f64,
    /// Coefficient of restitution of its rest stop, e₀ [-].
    pub rest_restitution: f64,
    /// Coefficient of restitution of its end stop, em [-].
    pub end_stop_restitution: f64,
    /// Coefficient of restitution between lever and catch, eb [-].
    pub engagement_restitution: f64,
    /// It falls back; one that does not stays at its end stop once there.
    pub reversible: bool,
}

impl Catch {
    /// True if it never moves: nothing drives it.
    pub fn never_moves(&self) -> bool {
        self.unbalance_kg_m <= 0.0 && self.engagement_angle_rad > 0.0
    }

    /// Returns the base acceleration at which it leaves its rest stop, T₂/S₂ [m/s²].
    pub fn lift_off_acceleration_m_s2(&self) -> f64 {
        self.preload_torque_nm / self.unbalance_kg_m
    }

    /// Returns the speed ratio χ = (S₂/(I₂ ψb))/(S₁/(I₁ φb)) [-]: for blows, and for ever stronger
    /// accelerations, the catch reaches ψb before the lever reaches φb where this is at least one.
    ///
    /// # Source
    ///
    /// Closed form of both motions under a constant acceleration, without springs and with cos ψ = 1.
    pub fn speed_ratio(&self, lever: &Lever) -> f64 {
        let of_catch =
            self.unbalance_kg_m / (self.moment_of_inertia_kg_m2 * self.engagement_angle_rad);
        let of_lever =
            lever.unbalance_kg_m() / (lever.moment_of_inertia_kg_m2 * self.lever_angle_rad);
        of_catch / of_lever
    }

    /// Returns it as a lever, whose mass is its unbalance at an arm of one metre.
    pub(crate) fn as_lever(&self) -> Lever {
        Lever {
            moment_of_inertia_kg_m2: self.moment_of_inertia_kg_m2,
            pivot_damping_nm_s_per_rad: self.pivot_damping_nm_s_per_rad,
            spring_stiffness_nm_per_rad: self.spring_stiffness_nm_per_rad,
            preload_torque_nm: self.preload_torque_nm,
            mass_kg: self.unbalance_kg_m,
            center_of_mass_m: 1.0,
            axis: None,
            center_of_mass: None,
        }
    }

    /// Returns its rest stop.
    pub(crate) fn rest_stop(&self) -> Stop {
        Stop {
            restitution: self.rest_restitution,
            ..Stop::reference()
        }
    }
}
