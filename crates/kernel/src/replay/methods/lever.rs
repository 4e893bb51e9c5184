//! Equations (2.1) and (2.2) divided by the moment of inertia, for methods that see a motion.

use super::Problem;
use crate::model::excitation::Excitation;
use crate::numerics::Motion;

/// u'' = −pressing − damping·u' − stiffness·u − gain·(a_t cos u − a_r sin u) on one smooth branch.
#[derive(Debug)]
pub(super) struct SmoothBranch<'a, E> {
    excitation: &'a E,
    /// T0/I0 [rad/s²].
    pub(super) pressing: f64,
    /// m L/I0 [1/m].
    pub(super) gain: f64,
    /// c/I0 [1/s].
    pub(super) damping: f64,
    /// k/I0 [1/s²].
    pub(super) stiffness: f64,
}

impl<E: Excitation> SmoothBranch<'_, E> {
    /// Returns the lever's equation off the stop.
    pub(super) fn free<'a>(problem: &Problem<'a, E>) -> SmoothBranch<'a, E> {
        let lever = &problem.design.lever;
        let inertia = lever.moment_of_inertia_kg_m2;
        SmoothBranch {
            excitation: problem.excitation,
            pressing: lever.preload_torque_nm / inertia,
            gain: lever.unbalance_kg_m() / inertia,
            damping: lever.pivot_damping_nm_s_per_rad / inertia,
            stiffness: lever.spring_stiffness_nm_per_rad / inertia,
        }
    }

    /// Returns the lever's equation below φ = 0: in the soft stop, or off a rigid one.
    pub(super) fn contact<'a>(problem: &Problem<'a, E>) -> SmoothBranch<'a, E> {
        let free = Self::free(problem);
        if !problem.stop.yields() {
            return free;
        }
        let (lever, stop) = (&problem.design.lever, &problem.design.stop);
        let inertia = lever.moment_of_inertia_kg_m2;
        SmoothBranch {
            damping: stop.contact_damping_nm_s_per_rad(lever) / inertia,
            stiffness: stop.contact_stiffness_nm_per_rad(lever) / inertia,
            ..free
        }
    }

    /// Returns what presses the lever at φ = 0 onto the stop, T0/I0 + b [rad/s²].
    #[inline]
    pub(super) fn pressed(&self, t: f64) -> f64 {
        self.pressing + self.push(t)
    }

    /// Returns b = m L a/I0 at φ = 0 [rad/s²].
    #[inline]
    fn push(&self, t: f64) -> f64 {
        self.gain * self.excitation.acceleration(t)
    }

    /// Returns m L (a_t cos q − a_r sin q)/I0 at angle `q` [rad/s²].
    #[inline]
    pub(super) fn turned_push(&self, t: f64, q: f64) -> f64 {
        let along = self.push(t) * libm::cos(q);
        match self.excitation.radial(t) {
            Some(radial) => along - self.gain * radial * libm::sin(q),
            None => along,
        }
    }
}

impl<E: Excitation> Motion for SmoothBranch<'_, E> {
    #[inline]
    fn acceleration(&self, t: f64, q: f64, v: f64) -> f64 {
        -self.pressing - self.damping * v - self.stiffness * q - self.turned_push(t, q)
    }
}

/// Both branches, told apart by the sign of the angle inside each stage.
#[derive(Debug)]
pub(super) struct Switching<'a, E> {
    pub(super) free: SmoothBranch<'a, E>,
    pub(super) contact: SmoothBranch<'a, E>,
}

impl<E: Excitation> Motion for Switching<'_, E> {
    #[inline]
    fn acceleration(&self, t: f64, q: f64, v: f64) -> f64 {
        if q < 0.0 {
            self.contact.acceleration(t, q, v)
        } else {
            self.free.acceleration(t, q, v)
        }
    }
}
