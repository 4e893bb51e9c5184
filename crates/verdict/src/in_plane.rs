//! Two in-plane axes: the accelerations of two sensors along and across the way of a lever's centre of mass.
//!
//! The judged channel is the lateral one, Y. The second is X of a lever that turns about a vertical axis, Z of
//! one that turns about a longitudinal one. Both have the signs of SAE J211 but for the door's side, which the
//! opening direction tells.

use crate::conditioning::Conditioned;
use latchgate_kernel::model::lever::Lever;
use latchgate_kernel::signal::{Projection, Signal};
use latchgate_kernel::units::{OpensWhen, plain};
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

/// Place of Y among X, Y and Z.
const Y: usize = 1;

/// Largest direction cosine of the axis that no channel measures [-].
const OUT_OF_PLANE_MAX: f64 = 0.02;

/// Least direction cosine of the lateral axis on the way of the centre of mass [-].
const LATERAL_MIN: f64 = 0.02;

/// How a lever sees the lateral and a second axis: direction cosines of a left door's [-].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InPlane {
    /// The axis of the second channel, X or Z.
    pub second_axis: char,
    /// Of Y and of the second axis, on the way of the centre of mass at φ = 0.
    pub tangential: [f64; 2],
    /// The same, from the pivot to the centre of mass.
    pub radial: [f64; 2],
}

impl InPlane {
    /// Returns what a lever sees of two axes.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a lever without directions, one whose
    /// plane is not spanned by Y and another axis, and one that lateral acceleration does not turn.
    pub fn of(lever: &Lever) -> Result<Self, Error> {
        let refuse = |expected: &str, found: String| {
            Error::out_of_range(
                "lever.axis and lever.center_of_mass, for the setting `radial_channel`,",
                expected,
                found,
            )
        };
        let (Some(directions), Some(axis)) = (lever.directions(), lever.axis) else {
            return Err(refuse("both", "a design without them".into()));
        };
        let [nx, _, nz] = axis.0.map(f64::abs);
        let (second, second_axis, third) = match nz >= nx {
            true => (0, 'X', 2),
            false => (2, 'Z', 0),
        };
        let (tangential, radial) = (directions.tangential.0, directions.radial.0);
        let out_of_plane = tangential[third].abs().max(radial[third].abs());
        if out_of_plane > OUT_OF_PLANE_MAX {
            return Err(refuse(
                "an axis along X or Z, so that Y and one other channel are in the lever's plane; else make two in-plane channels of the three",
                format!("{} of the third axis in the plane", plain(out_of_plane, 2)),
            ));
        }
        if tangential[Y].abs() < LATERAL_MIN {
            return Err(refuse(
                "a lever that lateral acceleration turns",
                format!(
                    "{} of Y along the way of its centre of mass",
                    plain(tangential[Y], 2)
                ),
            ));
        }
        Ok(Self {
            second_axis,
            tangential: [tangential[Y], tangential[second]],
            radial: [radial[Y], radial[second]],
        })
    }

    /// Returns how recorded accelerations drive the lever where this sign of the lateral one opens.
    pub fn projection(&self, opens_when: OpensWhen) -> Projection {
        let sign = opens_when.sign();
        let side = sign * self.tangential[0].signum();
        Projection {
            tangential: [self.tangential[0].abs(), sign * self.tangential[1]],
            radial: [side * self.radial[0], self.radial[1]],
        }
    }

    /// Returns the door that this sign of the judged channel opens, `left` or `right`; of one whose sign is against
    /// SAE J211 the other.
    pub fn door(&self, opens_when: OpensWhen, is_reversed: bool) -> &'static str {
        match (self.tangential[0] * opens_when.sign() > 0.0) != is_reversed {
            true => "left",
            false => "right",
        }
    }
}

/// How much each sensor counts in an acceleration that acts like one along the way of the centre of mass, at most,
/// up to an angle [-].
pub(super) fn weights(projection: &Projection, angle_rad: f64) -> [f64; 2] {
    let sine = libm::sin(angle_rad.min(FRAC_PI_2));
    let weight = |sensor: usize| {
        libm::hypot(
            projection.tangential[sensor],
            sine * projection.radial[sensor],
        )
    };
    [weight(0), weight(1)]
}

/// Returns the acceleration that drives the lever at φ = 0, in the polarity of the judged channel [m/s²].
pub(super) fn tangential<'a>(
    conditioned: &'a Conditioned,
    lever: &Lever,
    opens_when: OpensWhen,
) -> Result<Cow<'a, Signal>, Error> {
    let Some(second) = &conditioned.second else {
        return Ok(Cow::Borrowed(&conditioned.used));
    };
    let [first, across] = InPlane::of(lever)?.projection(opens_when).tangential;
    let pairs = conditioned
        .used
        .samples
        .iter()
        .zip(&second.conditioned.used.samples);
    Ok(Cow::Owned(Signal {
        samples: pairs.map(|(y, other)| first * y + across * other).collect(),
        ..conditioned.used
    }))
}
