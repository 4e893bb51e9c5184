//! The quantities that a margin varies: what each does to the lever, and on which grid.

use latchgate_kernel::model::Design;
use latchgate_kernel::units::shortest;
use serde::{Deserialize, Serialize};

/// A quantity that is varied alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Factor on the recorded acceleration.
    Scale,
    /// Preload torque T0.
    Preload,
    /// Stiffness of the spring, k0.
    SpringStiffness,
    /// Unbalance m·L at an unchanged distance L and moment of inertia.
    Unbalance,
    /// Distance L of the centre of mass from the pivot, at an unchanged mass and moment of inertia.
    Arm,
    /// Mass fixed to the lever on the far side of the pivot.
    Counterweight,
    /// Restitution R, the soft stop's damping with it through ξ(R).
    Restitution,
    /// Angle beyond which the door is lost.
    LimitAngle,
}

/// Words of a quantity.
struct Words {
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    convention: &'static str,
}

/// The largest magnitude of the recording, and what else bounds a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridBounds {
    /// The strongest sample in an opening direction [m/s²].
    pub strongest_m_s2: f64,
    /// Distance of the counterweight from the pivot [m].
    pub counterweight_radius_m: f64,
}

/// Values in a decade, of the preferred numbers E48 (IEC 60063).
const E48: [u16; 48] = [
    100, 105, 110, 115, 121, 127, 133, 140, 147, 154, 162, 169, 178, 187, 196, 205, 215, 226, 237,
    249, 261, 274, 287, 301, 316, 332, 348, 365, 383, 402, 422, 442, 464, 487, 511, 536, 562, 590,
    619, 649, 681, 715, 750, 787, 825, 866, 909, 953,
];

/// Equal steps of a grid whose values are differences.
const STEPS: u32 = 100;

impl Quantity {
    /// Every quantity, in the order of answers.
    pub const ALL: [Self; 8] = [
        Self::Scale,
        Self::Preload,
        Self::SpringStiffness,
        Self::Unbalance,
        Self::Arm,
        Self::Counterweight,
        Self::Restitution,
        Self::LimitAngle,
    ];

    fn words(self) -> Words {
        let (name, title, unit, convention) = match self {
            Self::Scale => (
                "scale",
                "scale of the recording",
                "",
                "every sample as used is multiplied, and the noise with it; what is uncertain of the bias stays as it is",
            ),
            Self::Preload => (
                "preload_torque_nm",
                "preload",
                "N·m",
                "lever.preload_torque_nm alone changes",
            ),
            Self::SpringStiffness => (
                "spring_stiffness_nm_per_rad",
                "spring stiffness",
                "N·m/rad",
                "lever.spring_stiffness_nm_per_rad alone changes; the preload at rest stays",
            ),
            Self::Unbalance => (
                "unbalance_kg_m",
                "unbalance m·L",
                "kg·m",
                "the mass changes, its distance from the pivot and the moment of inertia stay",
            ),
            Self::Arm => (
                "center_of_mass_m",
                "arm L",
                "m",
                "the distance of the centre of mass changes, mass and moment of inertia stay",
            ),
            Self::Counterweight => (
                "counterweight_kg",
                "counterweight",
                "kg",
                "a mass fixed to the lever at the stated radius beyond the pivot takes mass times radius off the unbalance and adds mass times radius squared to the moment of inertia",
            ),
            Self::Restitution => (
                "restitution",
                "restitution",
                "",
                "the soft stop's damping moves along by ξ(R)/ξ(present R), ξ being the damping ratio that takes as much speed",
            ),
            Self::LimitAngle => (
                "threshold_rad",
                "limit angle",
                "rad",
                "criterion.threshold_rad alone changes",
            ),
        };
        Words {
            name,
            title,
            unit,
            convention,
        }
    }

    /// Returns its name in `boundaries` and tables.
    pub fn name(self) -> &'static str {
        self.words().name
    }

    /// Returns what people call it.
    pub fn title(self) -> &'static str {
        self.words().title
    }

    /// Returns its unit; empty for a ratio.
    pub fn unit(self) -> &'static str {
        self.words().unit
    }

    /// Says what stays and what moves along.
    pub fn convention(self) -> &'static str {
        self.words().convention
    }

    /// Returns a value of it with its unit, four digits at most.
    pub fn shown(self, value: f64) -> String {
        match self.unit() {
            "" => shortest(value),
            unit => format!("{} {unit}", shortest(value)),
        }
    }

    /// Tells whether more of it holds the lever, rather than less.
    pub fn is_safer_above(self) -> bool {
        matches!(
            self,
            Self::Preload | Self::SpringStiffness | Self::Counterweight | Self::LimitAngle
        )
    }

    /// Tells whether distances between values are ratios, rather than differences.
    pub fn is_ratio(self) -> bool {
        matches!(
            self,
            Self::Scale | Self::Preload | Self::SpringStiffness | Self::LimitAngle
        )
    }

    /// Returns its value in a design.
    pub fn present(self, design: &Design) -> f64 {
        let lever = &design.lever;
        match self {
            Self::Scale => 1.0,
            Self::Preload => lever.preload_torque_nm,
            Self::SpringStiffness => lever.spring_stiffness_nm_per_rad,
            Self::Unbalance => lever.unbalance_kg_m(),
            Self::Arm => lever.center_of_mass_m.abs(),
            Self::Counterweight => 0.0,
            Self::Restitution => design.stop.restitution,
            Self::LimitAngle => design.criterion.threshold_rad,
        }
    }

    /// Returns the values that are tried, in ascending order, each of three digits. The present value
    /// has no part in them.
    ///
    /// A preload is tried up to twice that which the strongest opening sample lifts, a stiffness up to
    /// four times that which holds this sample at the limit angle, a limit angle up to 1.54 rad. Unbalance
    /// and arm end where the moment of inertia is that of a point mass, m L², a counterweight where it
    /// balances the lever.
    pub fn grid(self, design: &Design, bounds: &GridBounds) -> Vec<f64> {
        let lever = &design.lever;
        let lift_off_nm = lever.unbalance_kg_m() * bounds.strongest_m_s2;
        let inertia = lever.moment_of_inertia_kg_m2;
        match self {
            Self::Scale => preferred(1e-2, 1e2),
            Self::Preload => preferred(1e-3, (2.0 * lift_off_nm).clamp(1e-2, 1e6)),
            Self::SpringStiffness => {
                let limit = design.criterion.threshold_rad;
                preferred(1e-2, (4.0 * lift_off_nm / limit).clamp(1e-1, 1e6))
            }
            Self::LimitAngle => preferred(1e-3, 1.5),
            Self::Unbalance => even(1, inertia / lever.center_of_mass_m.abs()),
            Self::Arm => even(1, (inertia / lever.mass_kg).sqrt()),
            Self::Counterweight => even(0, lever.unbalance_kg_m() / bounds.counterweight_radius_m),
            Self::Restitution => even(0, 1.0),
        }
    }

    /// Returns the design and the scale of the recording with the quantity at `value`.
    pub fn applied(
        self,
        design: &Design,
        counterweight_radius_m: f64,
        value: f64,
    ) -> (Design, f64) {
        let mut changed = design.clone();
        let mut scale = 1.0;
        let lever = &mut changed.lever;
        match self {
            Self::Scale => scale = value,
            Self::Preload => lever.preload_torque_nm = value,
            Self::SpringStiffness => lever.spring_stiffness_nm_per_rad = value,
            Self::Unbalance => lever.mass_kg = value / lever.center_of_mass_m.abs(),
            Self::Arm => lever.center_of_mass_m = lever.unbalance_sign() * value,
            Self::Counterweight => {
                let unbalance_kg_m = lever.unbalance_kg_m() - value * counterweight_radius_m;
                lever.mass_kg = unbalance_kg_m.max(0.0) / lever.center_of_mass_m.abs();
                lever.moment_of_inertia_kg_m2 +=
                    value * counterweight_radius_m * counterweight_radius_m;
            }
            Self::Restitution => {
                changed.stop.restitution = value;
                changed.stop.follow_restitution(&design.stop, &design.lever);
            }
            Self::LimitAngle => changed.criterion.threshold_rad = value,
        }
        (changed, scale)
    }
}

/// Returns the preferred numbers E48 from the last at or below `low` to the first at or above `high`.
pub(crate) fn preferred(low: f64, high: f64) -> Vec<f64> {
    let mut values: Vec<f64> = (decade(low)..=decade(high))
        .flat_map(|decade| E48.map(|number| decimal(i64::from(number), decade - 2)))
        .collect();
    values.push(decimal(100, decade(high) - 1));
    let from = values.partition_point(|value| *value <= low);
    let to = values.partition_point(|value| *value < high);
    values.truncate(to + 1);
    values.drain(..from.saturating_sub(1));
    values
}

/// Returns [`STEPS`] equal steps to `end`, from the one named on, each value cut to three digits.
fn even(first: u32, end: f64) -> Vec<f64> {
    let step = |index: u32| three_digits(end * f64::from(index) / f64::from(STEPS), false);
    let mut values: Vec<f64> = (first..=STEPS).map(step).collect();
    values.dedup_by(|a, b| a.to_bits() == b.to_bits());
    values
}

/// Returns the power of ten of a value's first digit, the value rounded to three.
fn decade(value: f64) -> i32 {
    let text = format!("{value:.2e}");
    let exponent = text
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok());
    exponent.unwrap_or(0)
}

/// Returns `number`·10^`exponent`, as a decimal number is read.
fn decimal(number: i64, exponent: i32) -> f64 {
    format!("{number}e{exponent}").parse().unwrap_or(f64::NAN)
}

/// Returns the nearest number of three digits not above `value`, or not below it.
pub fn three_digits(value: f64, up: bool) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return value;
    }
    let nearest: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    let exponent = decade(nearest) - 2;
    let number = libm::round(nearest / decimal(1, exponent)) as i64;
    match (up, nearest < value, nearest > value) {
        (true, true, _) => decimal(number + 1, exponent),
        // Below a power of ten numbers of three digits are ten times as close.
        (false, _, true) if number == 100 => decimal(999, exponent - 1),
        (false, _, true) => decimal(number - 1, exponent),
        _ => nearest,
    }
}

/// Numbers that a cell of the grid is asked at, at most: 0.25 % apart where its ends are 5 % apart.
const CELL_VALUES: usize = 20;

/// Returns numbers of three digits between two neighbours of a grid, evenly drawn, twenty at most, from
/// `from` on, neither end among them.
pub fn within_cell(from: f64, to: f64) -> Vec<f64> {
    let values = between(from, to);
    let stride = values.len().div_ceil(CELL_VALUES).max(1);
    values
        .into_iter()
        .skip(stride - 1)
        .step_by(stride)
        .collect()
}

/// Returns the numbers of three digits between two values, from `from` towards `to`, neither end among
/// them; below half of the larger as close together as there.
pub fn between(from: f64, to: f64) -> Vec<f64> {
    let (low, high) = (from.min(to), from.max(to));
    let mut values = Vec::new();
    let mut value = low;
    while values.len() < 1000 {
        let exponent = decade(value.max(0.5 * high)) - 2;
        // A little more, lest a quotient just below a whole number gives the same value again.
        let number = libm::floor(value / decimal(1, exponent) + 1e-6) as i64 + 1;
        value = decimal(number, exponent);
        if value >= high {
            break;
        }
        values.push(value);
    }
    if to < from {
        values.reverse();
    }
    values
}
