//! The lever: one degree of freedom, an angle φ that leads away from the stop.

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
    /// Distance of the centre of mass from the pivot, L [m].
    pub center_of_mass_m: f64,
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
        }
    }

    /// Returns the unbalance m·L [kg m].
    pub fn unbalance_kg_m(&self) -> f64 {
        self.mass_kg * self.center_of_mass_m
    }

    /// Returns the base acceleration at which a lever at rest leaves a rigid stop, T0/(mL) [m/s²].
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
