//! What ends a lever's flight: its stop, and what a mechanism puts above or below it.

use super::taylor::{TaylorSeries, Turned};
use crate::numerics::polynomial;

/// What ends a flight beside the lever's own stop, and what came of it.
#[derive(Debug, Clone)]
pub(super) struct Ends {
    /// What is above.
    pub(super) above: Ceiling,
    /// Angle below which a flight ends at a gate; −∞ where only the lever's own stop is below [rad].
    pub(super) gate_below: f64,
    /// The lever has come to a gate, and waits there.
    pub(super) at_gate: bool,
    /// It turned so close to a gate that it may as well have passed it.
    pub(super) grazes_gate: bool,
    /// Times it met the stop above.
    pub(super) strikes: u64,
    /// The first and the last of them since they were looked at.
    pub(super) new_strikes: Option<[Arrival; 2]>,
}

impl Ends {
    /// Nothing beside the lever's own stop.
    pub(super) const NONE: Self = Self {
        above: Ceiling::NONE,
        gate_below: f64::NEG_INFINITY,
        at_gate: false,
        grazes_gate: false,
        strikes: 0,
        new_strikes: None,
    };

    /// Returns where a step of flight comes to what is below and above, up to `reach`.
    #[inline]
    pub(super) fn crossings<const N: usize>(
        &self,
        series: &TaylorSeries<N>,
        reach: f64,
    ) -> Crossings {
        let (below, above) = (self.gate_below, self.above.angle);
        let has_gate = below.is_finite();
        Crossings {
            stop: match has_gate {
                true => None,
                false => hit(series, reach, 1.0, 0.0),
            },
            gate_below: match has_gate {
                true => hit(series, reach, 1.0, below),
                false => None,
            },
            above: match above.is_finite() {
                true => hit(series, reach, -1.0, above),
                false => None,
            },
        }
    }
}

/// What ends a flight above: a stop, or a gate at which whoever drives the lever decides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ceiling {
    /// Its angle [rad].
    pub(super) angle: f64,
    /// Sine and cosine of that.
    pub(super) turned: Turned,
    /// Coefficient of restitution of a stop [-]; `None` of a gate.
    pub(super) restitution: Option<f64>,
}

impl Ceiling {
    /// Nothing.
    pub(super) const NONE: Self = Self {
        angle: f64::INFINITY,
        turned: Turned::ZERO,
        restitution: None,
    };

    /// Returns a stop.
    pub(super) fn stop(angle: f64, restitution: f64) -> Self {
        Self {
            restitution: Some(restitution),
            ..Self::gate(angle)
        }
    }

    /// Returns a gate.
    pub(super) fn gate(angle: f64) -> Self {
        let turned = match angle.is_finite() {
            true => Turned::of(angle),
            false => Turned::ZERO,
        };
        Self {
            angle,
            turned,
            restitution: None,
        }
    }
}

/// How a lever comes to a stop above or to a gate.
///
/// An impact scales the error of the angle by its restitution, and rest wipes it out: how uncertain the
/// arrival was is known only before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival {
    /// When [s].
    pub(super) time: f64,
    /// Angular velocity [rad/s].
    pub(super) velocity: f64,
    /// Bound on the error of the angle [rad].
    pub(super) error: f64,
    /// Standard deviation of the angle from the noise [rad].
    pub(super) deviation: f64,
}

/// What a lever in flight comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Met {
    /// Its stop at φ = 0.
    Stop,
    /// The gate below.
    GateBelow,
    /// The stop or the gate above.
    Above,
}

/// Where a step of flight comes to what is below and above, as parts of the step.
pub(super) struct Crossings {
    stop: Option<f64>,
    gate_below: Option<f64>,
    above: Option<f64>,
}

impl Crossings {
    /// Returns the first of them.
    pub(super) fn first(&self) -> Option<f64> {
        let all = [self.stop, self.gate_below, self.above];
        all.into_iter().flatten().reduce(f64::min)
    }

    /// Returns what the lever meets: its stop, unless what is above comes before.
    pub(super) fn met(&self) -> Option<Met> {
        let hits = |part: f64| self.above.is_none_or(|above| part <= above);
        match (self.stop, self.above, self.gate_below) {
            (Some(part), ..) if hits(part) => Some(Met::Stop),
            (_, Some(_), _) => Some(Met::Above),
            (_, _, Some(_)) => Some(Met::GateBelow),
            _ => None,
        }
    }

    pub(super) fn passes_a_gate(&self) -> bool {
        self.gate_below.is_some() || self.above.is_some()
    }
}

/// Returns the part of the step at which the angle reaches `level`, from above with `side` +1, from below with
/// −1.
#[inline]
pub(super) fn hit<const N: usize>(
    series: &TaylorSeries<N>,
    reach: f64,
    side: f64,
    level: f64,
) -> Option<f64> {
    let slope = side * series.slope();
    let start = side * (series.start() - level);
    if start + (slope - series.curved.angle).min(0.0) > 0.0 {
        return None;
    }
    let mut signed = [0.0; N];
    let signed = &mut signed[..series.coefficients().len()];
    for (to, from) in signed.iter_mut().zip(series.coefficients()) {
        *to = side * from;
    }
    signed[0] = start;
    first_fall(signed, reach)
}

/// Returns the first place up to `reach` at which a polynomial falls through zero; a start at zero is none.
#[inline]
fn first_fall(polynomial: &[f64], reach: f64) -> Option<f64> {
    // A step that begins at zero has a known root there; it is divided out.
    let skip = polynomial.iter().position(|c| *c != 0.0)?;
    if skip == 0 && polynomial[0] < 0.0 {
        return None;
    }
    polynomial::first_fall(&polynomial[skip..], reach)
}
