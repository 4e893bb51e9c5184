//! The lever: one degree of freedom, an angle φ that leads away from the stop.

use super::vector::Vector;
use serde::{Deserialize, Serialize};

/// A latch lever (eq. 2.1): I0 φ'' + c0 φ' + k0 φ = −T0 − m a L cos φ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lever {
    /// Moment of inertia about the pivot, I0 [kg m²].
    pub moment_of_inertia_kg_m2: f64,
    /// Damping at the pivot, c0 [N m s/rad].
    pub pivot_damping_nm_s_per_rad: f64,
    /// Stiffness of the spring, k0 [N m/rad].
    pub spring_stiffness_nm_per_rad: f64,
    /// Preload torque of the spring at φ = 0, T0 [N m].
    pub preload_torque_nm: f64,
    /// Mass, m [kg].
    pub mass_kg: f64,
    /// Distance of the centre of mass from the pivot, L [m]; negative beyond the pivot, where a weight fixed to
    /// the lever outweighs it and the other sign of acceleration opens.
    pub center_of_mass_m: f64,
    /// Axis of the pivot about which it opens, in the vehicle's axes, of the left door [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<Vector>,
    /// From the pivot to the centre of mass, in the vehicle's axes [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub center_of_mass: Option<Vector>,
}

/// Directions of a lever's centre of mass at φ = 0, in the vehicle's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Directions {
    /// In which it moves as the lever opens.
    pub tangential: Vector,
    /// From the pivot to it, across the axis.
    pub radial: Vector,
    /// Its distance from the axis [m].
    pub distance_m: f64,
}

impl Lever {
    /// Returns the lever of eq. (3.1).
    pub fn reference() -> Self {
        Self {
            moment_of_inertia_kg_m2: 8.888e-4,
            pivot_damping_nm_s_per_rad: 9.3e-5,
            spring_stiffness_nm_per_rad: 0.370,
            preload_torque_nm: 0.1,
            mass_kg: 0.1475,
            center_of_mass_m: 0.065,
            axis: None,
            center_of_mass: None,
        }
    }

    /// Returns where its centre of mass lies and moves; `None` unless axis and centre are stated and apart.
    pub fn directions(&self) -> Option<Directions> {
        let axis = self.axis?.direction()?;
        let center = self.center_of_mass.filter(|center| center.is_finite())?;
        let across = center.plus(axis.times(-axis.dot(center)));
        let radial = across.direction()?;
        Some(Directions {
            tangential: axis.cross(radial),
            radial,
            distance_m: across.length(),
        })
    }

    /// Returns the unbalance m·L, without its sign [kg m].
    pub fn unbalance_kg_m(&self) -> f64 {
        self.mass_kg * self.center_of_mass_m.abs()
    }

    /// Returns the sign of the model's acceleration that opens, negated: −1 of an overbalanced lever.
    pub fn unbalance_sign(&self) -> f64 {
        self.center_of_mass_m.signum()
    }

    /// Returns the magnitude of the base acceleration at which a lever at rest leaves a rigid stop, T0/(mL) [m/s²].
    ///
    /// # Source
    ///
    /// Eq. (2.1) at φ = 0.
    pub fn lift_off_acceleration_m_s2(&self) -> f64 {
        self.preload_torque_nm / self.unbalance_kg_m()
    }

    /// Returns the angular frequency out of contact, ω0 = √(k0/I0) [rad/s].
    pub fn angular_frequency_rad_s(&self) -> f64 {
        (self.spring_stiffness_nm_per_rad / self.moment_of_inertia_kg_m2).sqrt()
    }
}

impl Default for Lever {
    fn default() -> Self {
        Self::reference()
    }
}
