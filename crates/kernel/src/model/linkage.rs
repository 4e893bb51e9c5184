//! A linkage: elements that turn together, reduced to one lever about the pawl's pivot.

use super::lever::Lever;
use super::vector::Vector;
use crate::error::Error;
use serde::{Deserialize, Serialize};

/// An element of a linkage, which turns `ratio` times as far as the lever that it is reduced to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkageElement {
    /// What it is.
    pub name: String,
    /// Mass [kg].
    pub mass_kg: f64,
    /// Distance of its centre of mass from its pivot, across the acceleration that opens [m]; negative where
    /// that acceleration closes. Or `axis` and `center_of_mass`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm_m: Option<f64>,
    /// Axis about which it opens, in the vehicle's axes [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<Vector>,
    /// From its pivot to its centre of mass, in the vehicle's axes [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center_of_mass: Option<Vector>,
    /// Angle that it turns by for each of the lever [-]; negative where it turns the other way.
    #[serde(default = "one")]
    pub ratio: f64,
    /// Torque of its spring that closes, at its own pivot [N m].
    #[serde(default)]
    pub spring_torque_nm: f64,
    /// Force of its spring that closes [N], at `spring_arm_m`.
    #[serde(default)]
    pub spring_force_n: f64,
    /// Distance of that force from its pivot [m].
    #[serde(default)]
    pub spring_arm_m: f64,
    /// Stiffness of its spring, at its own pivot [N m/rad].
    #[serde(default)]
    pub spring_stiffness_nm_per_rad: f64,
    /// Moment of inertia about its own pivot [kg m²]; a static calculation needs none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment_of_inertia_kg_m2: Option<f64>,
    /// It cannot part from the lever in either sense, as by a pin or teeth; an element that is only pushed can.
    #[serde(default, skip_serializing_if = "is_false")]
    pub pinned: bool,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature of serde")]
fn is_false(value: &bool) -> bool {
    !value
}

fn one() -> f64 {
    1.0
}

/// Returns the elements that may part from one another: those that are not pinned, if they are several. One that is
/// not is the lever that the others are pinned to.
pub fn parting(linkage: &[LinkageElement]) -> Vec<&LinkageElement> {
    let unpinned: Vec<_> = linkage.iter().filter(|element| !element.pinned).collect();
    if unpinned.len() > 1 {
        unpinned
    } else {
        Vec::new()
    }
}

/// What an element, or all of them, comes to about the lever's pivot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Reduced {
    /// Mass [kg].
    pub mass_kg: f64,
    /// Closing torque at φ = 0 [N m].
    pub preload_torque_nm: f64,
    /// Stiffness [N m/rad].
    pub spring_stiffness_nm_per_rad: f64,
    /// Unbalance, where arms are stated [kg m].
    pub unbalance_kg_m: f64,
    /// Unbalance along the vehicle's axes, where vectors are stated [kg m].
    pub unbalance_vector_kg_m: Option<Vector>,
    /// Moment of inertia [kg m²].
    pub moment_of_inertia_kg_m2: Option<f64>,
}

impl LinkageElement {
    /// Checks its numbers.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for one that no element can have, and unless it states an arm or both vectors.
    pub fn check(&self) -> Result<(), Error> {
        let refuse = |what: &str, expected: &str, found: f64| {
            let name = format!("linkage element `{}`: {what}", self.name);
            Err(Error::out_of_range(name, expected, found.to_string()))
        };
        let not_negative = [
            ("mass_kg", self.mass_kg),
            (
                "spring_stiffness_nm_per_rad",
                self.spring_stiffness_nm_per_rad,
            ),
            (
                "moment_of_inertia_kg_m2",
                self.moment_of_inertia_kg_m2.unwrap_or(0.0),
            ),
        ];
        for (key, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                return refuse(key, "zero or positive, and finite", value);
            }
        }
        let finite = [
            ("arm_m", self.arm_m.unwrap_or(0.0)),
            ("ratio", self.ratio),
            ("spring_torque_nm", self.spring_torque_nm),
            ("spring_force_n", self.spring_force_n),
            ("spring_arm_m", self.spring_arm_m),
        ];
        for (key, value) in finite {
            if !value.is_finite() {
                return refuse(key, "finite", value);
            }
        }
        if self.ratio.abs() <= 0.0 {
            return refuse(
                "ratio",
                "not 0: an element that does not turn is none",
                self.ratio,
            );
        }
        if (self.spring_force_n.abs() > 0.0) != (self.spring_arm_m.abs() > 0.0) {
            let found = self.spring_force_n;
            return refuse(
                "spring_force_n",
                "with spring_arm_m, neither of them 0",
                found,
            );
        }
        match (self.arm_m, self.axis, self.center_of_mass) {
            (Some(_), None, None) => Ok(()),
            (None, Some(axis), Some(center))
                if axis.direction().is_some() && center.is_finite() =>
            {
                Ok(())
            }
            _ => refuse(
                "arm_m, or axis and center_of_mass",
                "one or the other",
                f64::NAN,
            ),
        }
    }

    /// Returns its mass times the way of its centre of mass when the lever has turned by `angle` [kg m]; `None` of one
    /// by its arm.
    pub fn moved_kg_m(&self, angle: f64) -> Option<Vector> {
        let (axis, center) = (self.axis?.direction()?, self.center_of_mass?);
        let (sine, cosine) = libm::sincos(self.ratio * angle);
        let along = axis.cross(center);
        let way = along
            .times(sine)
            .plus(axis.cross(along).times(1.0 - cosine));
        Some(way.times(self.mass_kg))
    }

    /// Reduces it to the lever's pivot: T = i (T_j + F_j r_j), k = i² k_j, m·L = i m_j L_j, I = i² I_j.
    pub fn reduced(&self) -> Reduced {
        let ratio = self.ratio;
        let torque = self.spring_torque_nm + self.spring_force_n * self.spring_arm_m;
        let vector = self.axis.zip(self.center_of_mass).map(|(axis, center)| {
            // Of an axis without a direction nothing is told, and the sum is refused.
            let axis = axis.direction().unwrap_or(Vector([f64::NAN; 3]));
            axis.cross(center).times(ratio * self.mass_kg)
        });
        Reduced {
            mass_kg: self.mass_kg,
            preload_torque_nm: ratio * torque,
            spring_stiffness_nm_per_rad: ratio * ratio * self.spring_stiffness_nm_per_rad,
            unbalance_kg_m: ratio * self.mass_kg * self.arm_m.unwrap_or(0.0),
            unbalance_vector_kg_m: vector,
            moment_of_inertia_kg_m2: self.moment_of_inertia_kg_m2.map(|own| ratio * ratio * own),
        }
    }
}

impl Reduced {
    /// Adds up the elements of a linkage.
    ///
    /// # Errors
    ///
    /// As [`LinkageElement::check`]; [`Error::OutOfRange`] for no element, for arms beside vectors, and where
    /// nothing closes the linkage or nothing is out of balance.
    pub fn of(elements: &[LinkageElement]) -> Result<Self, Error> {
        elements.iter().try_for_each(LinkageElement::check)?;
        let vectors = elements
            .iter()
            .filter(|element| element.axis.is_some())
            .count();
        if elements.is_empty() || (vectors > 0 && vectors < elements.len()) {
            return Err(Error::out_of_range(
                "linkage",
                "elements that all state arm_m, or all state axis and center_of_mass",
                format!("{} elements, {vectors} with an axis", elements.len()),
            ));
        }
        let mut sum = Self {
            unbalance_vector_kg_m: (vectors > 0).then_some(Vector::default()),
            moment_of_inertia_kg_m2: Some(0.0),
            ..Self::default()
        };
        for own in elements.iter().map(LinkageElement::reduced) {
            sum.mass_kg += own.mass_kg;
            sum.preload_torque_nm += own.preload_torque_nm;
            sum.spring_stiffness_nm_per_rad += own.spring_stiffness_nm_per_rad;
            sum.unbalance_kg_m += own.unbalance_kg_m;
            let vectors = sum.unbalance_vector_kg_m.zip(own.unbalance_vector_kg_m);
            sum.unbalance_vector_kg_m = vectors.map(|(all, own)| all.plus(own));
            let inertias = sum.moment_of_inertia_kg_m2.zip(own.moment_of_inertia_kg_m2);
            sum.moment_of_inertia_kg_m2 = inertias.map(|(all, own)| all + own);
        }
        if let Some(vector) = sum.unbalance_vector_kg_m {
            sum.unbalance_kg_m = vector.length();
        }
        let numbers = [
            sum.mass_kg,
            sum.preload_torque_nm,
            sum.spring_stiffness_nm_per_rad,
            sum.unbalance_kg_m,
            sum.moment_of_inertia_kg_m2.unwrap_or(0.0),
        ];
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(Error::out_of_range(
                "linkage",
                "elements whose sums are finite",
                "a number that is none, or too large",
            ));
        }
        let closes = sum.preload_torque_nm + sum.spring_stiffness_nm_per_rad > 0.0
            && sum.preload_torque_nm >= 0.0;
        if !closes || sum.unbalance_kg_m.abs() <= 0.0 {
            return Err(Error::out_of_range(
                "linkage",
                "springs that close it, and masses out of balance",
                format!(
                    "{} N m and {} kg m",
                    sum.preload_torque_nm, sum.unbalance_kg_m
                ),
            ));
        }
        Ok(sum)
    }

    /// Adds up what stays together under an acceleration of the base along `along`, of elements by vectors, or the one
    /// that opens, of elements by arms: all but those that it presses shut and that are not pinned. `None` where all
    /// stay.
    pub fn staying(elements: &[LinkageElement], along: Option<Vector>) -> Option<Self> {
        /// Part of an element's unbalance that counts as none.
        const NOTHING: f64 = 1e-9;
        let mut sum = Self {
            unbalance_vector_kg_m: along.map(|_| Vector::default()),
            ..Self::default()
        };
        let mut parts = false;
        for element in elements {
            let own = element.reduced();
            let (pushed, size) = match along.zip(own.unbalance_vector_kg_m) {
                Some((along, own)) => (-along.dot(own), own.length()),
                None => (own.unbalance_kg_m, own.unbalance_kg_m.abs()),
            };
            // An element without an unbalance is pushed by nothing and presses by its spring alone.
            if !element.pinned && size > 0.0 && pushed <= NOTHING * size {
                parts = true;
                continue;
            }
            sum.mass_kg += own.mass_kg;
            sum.preload_torque_nm += own.preload_torque_nm;
            sum.spring_stiffness_nm_per_rad += own.spring_stiffness_nm_per_rad;
            sum.unbalance_kg_m += pushed;
            let vectors = sum.unbalance_vector_kg_m.zip(own.unbalance_vector_kg_m);
            sum.unbalance_vector_kg_m = vectors.map(|(all, own)| all.plus(own));
        }
        parts.then_some(sum)
    }

    /// Returns the lever that a replay takes; `None` where an element states no moment of inertia.
    pub fn lever(&self, pivot_damping_nm_s_per_rad: f64) -> Option<Lever> {
        Some(Lever {
            moment_of_inertia_kg_m2: self.moment_of_inertia_kg_m2?,
            pivot_damping_nm_s_per_rad,
            spring_stiffness_nm_per_rad: self.spring_stiffness_nm_per_rad,
            preload_torque_nm: self.preload_torque_nm,
            mass_kg: self.mass_kg,
            center_of_mass_m: self.unbalance_kg_m / self.mass_kg,
            ..Lever::reference()
        })
    }
}
