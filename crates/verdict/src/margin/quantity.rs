//! The quantities that a margin varies: what each does to the lever, over which range, on which
//! grid.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::Stop;
use serde::{Deserialize, Serialize};

/// A quantity that is varied alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Factor on the recorded acceleration.
    Scale,
    /// Preload torque T0.
    Preload,
    /// Unbalance m·L at an unchanged moment of inertia.
    Unbalance,
    /// Mass on the far side of the pivot.
    Counterweight,
    /// Restitution R, the soft stop's damping with it through ξ(R).
    Restitution,
}

impl Quantity {
    /// Every quantity, in the order of answers.
    pub const ALL: [Self; 5] = [
        Self::Scale,
        Self::Preload,
        Self::Unbalance,
        Self::Counterweight,
        Self::Restitution,
    ];

    /// Returns its name in `boundaries`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scale => "scale",
            Self::Preload => "preload_torque_nm",
            Self::Unbalance => "unbalance_kg_m",
            Self::Counterweight => "counterweight_kg",
            Self::Restitution => "restitution",
        }
    }

    /// Returns what people call it.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Scale => "scale of the recording",
            Self::Preload => "preload torque",
            Self::Unbalance => "unbalance m·L",
            Self::Counterweight => "counterweight",
            Self::Restitution => "restitution",
        }
    }

    /// Tells whether more of it holds the lever, rather than less.
    #[must_use]
    pub fn is_safer_above(self) -> bool {
        matches!(self, Self::Preload | Self::Counterweight)
    }

    /// Returns its unit; empty for a ratio.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Scale | Self::Restitution => "",
            Self::Preload => "N m",
            Self::Unbalance => "kg m",
            Self::Counterweight => "kg",
        }
    }

    /// Says what stays and what moves along.
    #[must_use]
    pub fn convention(self) -> &'static str {
        match self {
            Self::Scale => {
                "every sample as used is multiplied; its bias and filter stay as they are"
            }
            Self::Preload => "lever.preload_torque_nm alone changes",
            Self::Unbalance => {
                "the product of mass and distance of its centre changes, the moment of inertia stays; the product alone enters the model, and only times the acceleration, so for a nominal lever this is the present product times the scale to flip; scattered levers differ, since their bias is not scaled with the recording"
            }
            Self::Counterweight => {
                "a mass at the stated radius beyond the pivot takes mass times radius off the unbalance and adds mass times radius squared to the moment of inertia"
            }
            Self::Restitution => {
                "the soft stop's damping moves along by ξ(R)/ξ(present R), ξ being the damping ratio that takes as much speed"
            }
        }
    }
}

/// The range of a quantity that is searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchRange {
    /// The value at present.
    pub present: f64,
    /// The least value searched.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// Values are spaced by equal ratios and distances measured by ratios.
    pub ratios: bool,
}

/// Factor to either side of the present value that ratios are searched over.
pub const FACTOR: f64 = 1000.0;

/// Relative width of a bracket.
const WIDTH: f64 = 1e-12;

impl SearchRange {
    /// Returns the range of a quantity; `lift_off_nm` [N m] is the preload below which the
    /// strongest opening sample lifts a lever off a rigid stop.
    #[must_use]
    pub fn of(
        quantity: Quantity,
        design: &Design,
        counterweight_radius_m: f64,
        lift_off_nm: f64,
    ) -> Self {
        let lever = &design.lever;
        let ratios = |present: f64, high: f64| Self {
            present,
            low: present / FACTOR,
            high,
            ratios: true,
        };
        match quantity {
            Quantity::Scale => ratios(1.0, FACTOR),
            Quantity::Preload => {
                let present = lever.preload_torque_nm;
                let high = (10.0 * present).max(2.0 * lift_off_nm);
                // By differences where there is nothing to take a ratio to.
                if present > 0.0 && high < FACTOR * FACTOR * present {
                    ratios(present, high)
                } else {
                    Self {
                        present,
                        low: 0.0,
                        high: if high > 0.0 { high } else { 1.0 },
                        ratios: false,
                    }
                }
            }
            Quantity::Unbalance => {
                let present = lever.unbalance_kg_m();
                ratios(present, FACTOR * present)
            }
            Quantity::Counterweight => Self {
                present: 0.0,
                low: 0.0,
                high: lever.unbalance_kg_m() / counterweight_radius_m,
                ratios: false,
            },
            Quantity::Restitution => Self {
                present: design.stop.restitution,
                low: 0.0,
                high: 1.0,
                ratios: false,
            },
        }
    }

    /// Returns about `count` values in ascending order, the ends and the present value among
    /// them.
    #[must_use]
    pub fn grid(&self, count: usize) -> Vec<f64> {
        let mut values = vec![self.low, self.present, self.high];
        for index in 1..count.max(2) {
            let share = index as f64 / count.max(2) as f64;
            if self.ratios {
                // Equal ratios to either side of the present value.
                let whole = libm::log(self.high / self.low);
                values.push(self.low * libm::exp(share * whole));
            } else {
                values.push(self.low + share * (self.high - self.low));
                // Finer towards the end, where little is left to be taken off.
                let rest = libm::exp(-14.0 * share);
                values.push(self.high - rest * (self.high - self.low));
            }
        }
        values.retain(|value| (self.low..=self.high).contains(value));
        values.sort_unstable_by(f64::total_cmp);
        values.dedup_by(|a, b| a.to_bits() == b.to_bits());
        values
    }

    /// Returns how far `value` is from the present one: by the logarithm of their ratio, or by
    /// their difference.
    #[must_use]
    pub fn distance(&self, value: f64) -> f64 {
        (self.place(value) - self.place(self.present)).abs()
    }

    /// Returns the value on the scale on which distances are differences.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        if self.ratios {
            libm::log(value / self.present)
        } else {
            value
        }
    }

    /// Returns the value at a place.
    #[must_use]
    pub fn value(&self, place: f64) -> f64 {
        let value = if self.ratios {
            self.present * libm::exp(place)
        } else {
            place
        };
        value.clamp(self.low, self.high)
    }

    /// Returns the width of the bracket around `value` that ends a search.
    #[must_use]
    pub fn width(&self, value: f64) -> f64 {
        if self.ratios {
            WIDTH * value.abs()
        } else {
            WIDTH * (self.high - self.low)
        }
    }
}

/// Returns the design and the scale of the recording with `quantity` at `value`.
#[must_use]
pub fn applied(
    quantity: Quantity,
    design: &Design,
    counterweight_radius_m: f64,
    value: f64,
) -> (Design, f64) {
    let mut changed = design.clone();
    let mut scale = 1.0;
    let lever = &mut changed.lever;
    match quantity {
        Quantity::Scale => scale = value,
        Quantity::Preload => lever.preload_torque_nm = value,
        Quantity::Unbalance => lever.mass_kg = value / lever.center_of_mass_m,
        Quantity::Counterweight => {
            let left = lever.unbalance_kg_m() - value * counterweight_radius_m;
            lever.mass_kg = left.max(0.0) / lever.center_of_mass_m;
            lever.moment_of_inertia_kg_m2 +=
                value * counterweight_radius_m * counterweight_radius_m;
        }
        Quantity::Restitution => changed.stop = with_restitution(design, value),
    }
    (changed, scale)
}

/// Returns the stop with another restitution, the soft stop's damping moving along.
#[must_use]
pub fn with_restitution(design: &Design, restitution: f64) -> Stop {
    let mut stop = design.stop;
    stop.restitution = restitution;
    stop.follow_restitution(&design.stop, &design.lever);
    stop
}
