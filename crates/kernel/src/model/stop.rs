//! The stop: rigid (Newton's restitution) or soft (spring and damper).

use crate::units::Restitution;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use super::lever::Lever;

/// Which stop a run uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StopModel {
    /// Newton's restitution.
    Rigid,
    /// Spring and damper.
    Soft,
}

impl StopModel {
    /// Every model, in the order in which they are named.
    pub const ALL: [Self; 2] = [Self::Rigid, Self::Soft];

    /// Returns the word that options and verdicts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rigid => "rigid",
            Self::Soft => "soft",
        }
    }

    /// Returns what people are told of it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Rigid => "rigid stop",
            Self::Soft => "soft stop",
        }
    }

    /// Returns it as a list of one.
    pub fn alone(self) -> &'static [Self] {
        match self {
            Self::Rigid => &[Self::Rigid],
            Self::Soft => &[Self::Soft],
        }
    }

    /// Tells whether a lever sinks into it: it has angles below 0, holds energy there and gives speed back over
    /// time. What does not yield turns a lever round at φ = 0 and carries it at rest.
    pub fn yields(self) -> bool {
        match self {
            Self::Rigid => false,
            Self::Soft => true,
        }
    }
}

/// The stop of a design, as both models see it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Stop {
    /// Coefficient of restitution of the rigid stop, R [-].
    pub restitution: f64,
    /// Stiffness of the soft stop, ks [N/m].
    pub stiffness_n_per_m: f64,
    /// Damping of the soft stop, cs [N s/m].
    pub damping_n_s_per_m: f64,
    /// Distance of the stop from the pivot, ls [m].
    pub radius_m: f64,
}

impl Stop {
    /// Returns the stop of eq. (3.1).
    pub fn reference() -> Self {
        Self {
            restitution: 0.8,
            stiffness_n_per_m: 1e7,
            damping_n_s_per_m: 133.59,
            radius_m: 0.1,
        }
    }

    /// Returns the rotational stiffness in contact, k0 + ks ls² [N m/rad].
    pub fn contact_stiffness_nm_per_rad(&self, lever: &Lever) -> f64 {
        lever.spring_stiffness_nm_per_rad + self.stiffness_n_per_m * self.radius_m * self.radius_m
    }

    /// Returns the rotational damping in contact, c0 + cs ls² [N m s/rad].
    pub fn contact_damping_nm_s_per_rad(&self, lever: &Lever) -> f64 {
        lever.pivot_damping_nm_s_per_rad + self.damping_n_s_per_m * self.radius_m * self.radius_m
    }

    /// Returns the angular frequency in contact, ωR = √(kR/I0) [rad/s].
    pub fn contact_angular_frequency_rad_s(&self, lever: &Lever) -> f64 {
        (self.contact_stiffness_nm_per_rad(lever) / lever.moment_of_inertia_kg_m2).sqrt()
    }

    /// Returns the angle of a lever at rest without excitation [rad]: 0 on a stop that does not yield, else −T0/kR.
    pub fn rest_angle_rad(&self, model: StopModel, lever: &Lever) -> f64 {
        match model.yields() {
            true => -lever.preload_torque_nm / self.contact_stiffness_nm_per_rad(lever),
            false => 0.0,
        }
    }

    /// Returns the stiffness that turns a lever back at an angle [N m/rad]: below 0 that of a stop that yields.
    pub fn stiffness_at_nm_per_rad(&self, model: StopModel, lever: &Lever, angle_rad: f64) -> f64 {
        match model.yields() && angle_rad < 0.0 {
            true => self.contact_stiffness_nm_per_rad(lever),
            false => lever.spring_stiffness_nm_per_rad,
        }
    }

    /// Moves the soft stop's damping along with a restitution that was moved away from that of
    /// `nominal`, through ξ(R): by ξ(R)/ξ(R0), so that the nominal damping belongs to the nominal
    /// restitution whatever a design says of both; where ξ(R0) is 0, by what ξ(R) adds to the
    /// nominal stop of the nominal `lever`.
    pub fn follow_restitution(&mut self, nominal: &Self, lever: &Lever) {
        // A restitution that was not moved is the same number.
        if self.restitution.to_bits() == nominal.restitution.to_bits() {
            return;
        }
        let ratio =
            |restitution: f64| Restitution::from_ratio(restitution).map_or(0.0, damping_ratio);
        let (moved, present) = (ratio(self.restitution), ratio(nominal.restitution));
        if present > 0.0 {
            self.damping_n_s_per_m *= moved / present;
        } else {
            let critical = 2.0
                * lever.moment_of_inertia_kg_m2
                * nominal.contact_angular_frequency_rad_s(lever);
            self.damping_n_s_per_m += moved * critical / (nominal.radius_m * nominal.radius_m);
        }
    }
}

impl Default for Stop {
    fn default() -> Self {
        Self::reference()
    }
}

/// Returns the damping ratio ξ of a visco-elastic stop that takes away as much
/// speed as a rigid stop with restitution `restitution` [-].
///
/// ξ = −ln R / √(π² + ln² R). It holds for a half-period of free contact, so
/// it leaves out the preload: compare speeds well above lift-off. R = 0 gives 1, the
/// limit of critical damping.
///
/// # Source
///
/// Warmiński et al., eq. (2.5). The paper prints ξ = c_R/(I0 ω_R²), which has the unit of
/// time; its own c_s = 133.59 N s/m fits ξ = c_s l_s²/(2 I0 ω_R), which is what latchgate uses.
pub fn damping_ratio(restitution: Restitution) -> f64 {
    if restitution.ratio() <= 0.0 {
        return 1.0;
    }
    let ln_r = libm::log(restitution.ratio());
    -ln_r / libm::hypot(PI, ln_r)
}
