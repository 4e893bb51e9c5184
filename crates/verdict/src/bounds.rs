//! Bounds that spare an ensemble: no lever as far out as the scatter goes can come to the limit.
//!
//! Both hold of the loosest lever there is, every parameter at three standard deviations where its draws end,
//! and so of every member; and of every angle inside or outside the judged window. They are exact for the
//! polynomials between the samples, by their Bernstein coefficients.

use super::decision::Bound;
use super::ensemble::Scatter;
use super::policy::Variant;
use super::runs::RunSetup;
use super::statics::StaticLever;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::lever::Lever;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::Method;
use latchgate_kernel::replay::batch::SensorView;
use latchgate_kernel::signal::{Reading, Signal};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Returns the least ∫|a| dt that takes a lever from rest to an angle: √(2 I0 (T0 φ + k0 φ²/2))/(m L) [m/s].
///
/// # Source
///
/// With E the energy, d√E/dt ≤ m L |a|/√(2 I0): the excitation's work is −m L a cos φ φ', impacts and
/// damping take energy away.
fn impulse_threshold_m_s(lever: &Lever, angle_rad: f64) -> f64 {
    let stiffness = lever.spring_stiffness_nm_per_rad;
    let energy = lever.preload_torque_nm * angle_rad + 0.5 * stiffness * angle_rad * angle_rad;
    (2.0 * lever.moment_of_inertia_kg_m2 * energy).sqrt() / lever.unbalance_kg_m()
}

/// Returns the bound that spares the ensemble of one variant; none under an initial state, or by a method to
/// compare with.
pub(super) fn bound(
    setup: &RunSetup<'_>,
    scatter: &Scatter,
    Variant { opens_when, model }: Variant,
) -> Result<Option<Bound>, Error> {
    /// Room for rounding and for the replay's own error.
    const ROOM: f64 = 1e-6;
    if setup.policy.method != Method::EventDriven || setup.initial(model).is_some() {
        return Ok(None);
    }
    let sign = opens_when.sign() * setup.design.lever.unbalance_sign();
    let loosest = scatter.loosest(sign);
    let reading = setup.readings.own()?;
    let projection = setup.projection(opens_when)?;
    let sine = libm::sin(setup.threshold_rad().min(FRAC_PI_2));
    let sensor = |reading: &Reading<'_>, number: usize, scale: f64, bias_m_s2: f64| SensorBounds {
        ranges: reading.ranges(),
        along: sign * projection.tangential[number],
        // Across, it acts by the sine of the angle, at most that of the limit.
        weight: projection.tangential[number].abs() + sine * projection.radial[number].abs(),
        scale,
        bias_m_s2: bias_m_s2.abs(),
    };
    let mut sensors = vec![sensor(&reading, 0, loosest.scale, loosest.bias_m_s2)];
    if let Some(second) = reading.second() {
        let SensorView { scale, bias_m_s2 } = loosest.second;
        sensors.push(sensor(second, 1, scale, bias_m_s2));
    }
    let least = |index: usize| {
        sensors
            .iter()
            .map(|sensor| sensor.least(index))
            .sum::<f64>()
    };
    let strongest = |index: usize| {
        sensors
            .iter()
            .map(|sensor| sensor.strongest(index))
            .sum::<f64>()
    };
    let intervals = sensors[0].ranges.len();
    let lifts = (1.0 - ROOM) * -loosest.lever.lift_off_acceleration_m_s2();
    let first = match model.yields() {
        false => (0..intervals).find(|index| least(*index) < lifts),
        // In a stop that yields it moves from the first sample on.
        true => Some(0),
    };
    let Some(first) = first else {
        return Ok(Some(Bound::NeverLifts));
    };
    let interval = reading.signal().rate.interval().seconds();
    let impulse = interval * (first..intervals).map(strongest).sum::<f64>();
    let needed = impulse_threshold_m_s(&loosest.lever, setup.threshold_rad());
    Ok((impulse < (1.0 - ROOM) * needed).then_some(Bound::CannotReach))
}

/// What a sensor may have measured in each interval, with its uncertainty and its part in the lever's motion.
struct SensorBounds {
    ranges: Vec<Range>,
    /// Factor on the acceleration along the way of the centre of mass, positive where it holds the lever.
    along: f64,
    /// Largest factor on anything that it does up to the limit angle.
    weight: f64,
    /// Largest scale; the least is as far below 1.
    scale: f64,
    /// Largest bias [m/s²].
    bias_m_s2: f64,
}

impl SensorBounds {
    /// Returns the least acceleration in an interval at φ = 0; negative opens.
    fn least(&self, index: usize) -> f64 {
        let Range { low, high } = self.ranges[index];
        let opening = (self.along * low).min(self.along * high);
        // What holds the lever is scaled down, what opens it up.
        let (up, down) = (self.scale, 2.0 - self.scale);
        (up * opening).min(down * opening) - self.along.abs() * self.bias_m_s2
    }

    /// Returns the largest magnitude of what it does in an interval.
    fn strongest(&self, index: usize) -> f64 {
        let Range { low, high } = self.ranges[index];
        self.weight * (self.scale.abs() * low.abs().max(high.abs()) + self.bias_m_s2)
    }
}

/// Static and impulse threshold of a design, and what a recording holds against the latter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Screens {
    /// T0/(mL) in g: below it in the opening direction a lever on a rigid stop never leaves.
    pub static_threshold_g: f64,
    /// The same in m/s².
    pub static_threshold_m_s2: f64,
    /// By SAE J839, the spring's average: (T0 + k0 φ*/2)/(mL) in g.
    pub j839_threshold_g: f64,
    /// What counts of it in the worst direction, with gravity where that opens or its direction is not stated.
    pub static_counts_g: f64,
    /// Holds the lever at the limit angle, its arm turned with it, in g; `None` of a linkage.
    pub hold_threshold_g: Option<f64>,
    /// As a step in the worst direction, brings an undamped lever to the limit angle, in g; `None` of a linkage.
    pub step_threshold_g: Option<f64>,
    /// √(2 I0 (T0 φ* + k0 φ*²/2))/(mL) [m/s]: the least ∫|a| dt that can reach the threshold.
    pub impulse_threshold_m_s: f64,
    /// ∫|a| dt of the signal as used, over the whole record [m/s].
    pub impulse_m_s: Option<f64>,
}

impl Screens {
    /// Works them out.
    pub fn of(design: &Design, signal: Option<&Signal>) -> Self {
        let lever = &design.lever;
        let level = lever.lift_off_acceleration_m_s2();
        let impulse = |signal: &Signal| {
            let interval = signal.rate.interval().seconds();
            let area = |pair: &[f64]| {
                let (from, to) = (pair[0], pair[1]);
                if from * to < 0.0 {
                    // Two triangles on either side of the zero.
                    0.5 * (from * from + to * to) / (to - from).abs()
                } else {
                    0.5 * (from + to).abs()
                }
            };
            interval * signal.samples.windows(2).map(area).sum::<f64>()
        };
        let worst = StaticLever::from(design).worst();
        Self {
            j839_threshold_g: worst.j839_g.unwrap_or(f64::INFINITY),
            static_counts_g: worst.counts_g.unwrap_or(f64::NAN),
            hold_threshold_g: worst.hold_g,
            step_threshold_g: worst.step_g,
            static_threshold_g: level / STANDARD_GRAVITY,
            static_threshold_m_s2: level,
            impulse_threshold_m_s: impulse_threshold_m_s(lever, design.criterion.threshold_rad),
            impulse_m_s: signal.map(impulse),
        }
    }
}
