//! The one table of a design's numbers: key, symbol, unit, range and meaning.
//!
//! Design files, overrides, tolerances, the ensemble and the report all draw from it: a number
//! with a row here is read, checked, scattered and shown.

use super::catch::Catch;
use super::criterion::Criterion;
use super::lever::Lever;
use super::stop::{Stop, StopModel};
use crate::error::Error;
use crate::range::Range;

/// A number of a design.
#[derive(Debug, Clone, Copy)]
pub struct DesignParameter {
    /// Name in design files and overrides: section, dot, key.
    pub name: &'static str,
    /// Symbol in formulas; empty for a number without one.
    pub symbol: &'static str,
    /// Unit; `1` for a ratio.
    pub unit: &'static str,
    /// Condition on its value.
    pub condition: Condition,
    /// Least and greatest value that a latch of this world may have, generously; beyond it a
    /// verdict is warned of.
    pub plausible: Range,
    /// Number of the generator's stream that draws it in an ensemble; `None` of a number that
    /// is not scattered.
    ///
    /// A new row takes the next free number: one that changed would change every draw.
    pub stream: Option<u32>,
    /// What it is.
    pub what: &'static str,
    /// What it is called in a sentence.
    pub noun: &'static str,
    /// Where it stands in a design.
    pub slot: Slot,
}

/// The place of a number in a design: whoever matches on it deals with every number.
#[derive(Debug, Clone, Copy)]
pub enum Slot {
    /// A number of the lever.
    Lever(fn(&mut Lever) -> &mut f64),
    /// A number of the stop.
    Stop(fn(&mut Stop) -> &mut f64),
    /// A number of the catch, of a design that has one.
    Catch(fn(&mut Catch) -> &mut f64),
    /// A number of the criterion: the limit of the angle, and the share that may reach it.
    Criterion(fn(&mut Criterion) -> &mut f64),
    /// One standard deviation of the recording's scale.
    InputScale,
    /// One standard deviation of the recording's bias.
    InputBias,
}

/// A condition on one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// Greater than zero, and finite.
    Positive,
    /// Zero or greater, and finite.
    NotNegative,
    /// Of either sign, and finite.
    NotZero,
    /// From 0 to 1.
    Ratio,
    /// From 0.00001, which the largest ensemble can show, to 0.9999.
    Share,
}

impl Condition {
    /// Checks `value` of the number `name`.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::OutOfRange`] with the condition.
    pub fn check(self, name: &str, value: f64) -> Result<(), Error> {
        let (good, expected) = match self {
            Self::Positive => (value > 0.0 && value.is_finite(), "positive and finite"),
            Self::NotNegative => (
                value >= 0.0 && value.is_finite(),
                "zero or positive, and finite",
            ),
            Self::NotZero => (
                value.abs() > 0.0 && value.is_finite(),
                "finite and not zero",
            ),
            Self::Ratio => ((0.0..=1.0).contains(&value), "0 to 1"),
            Self::Share => ((1e-5..=0.9999).contains(&value), "from 0.00001 to 0.9999"),
        };
        if good {
            Ok(())
        } else {
            Err(Error::out_of_range(name, expected, format!("{value}")))
        }
    }

    /// Returns the value of this condition that is nearest to `value`; a number that must be
    /// positive or not zero has none and stays.
    pub fn hold(self, value: f64) -> f64 {
        match self {
            Self::Positive | Self::NotZero | Self::Share => value,
            Self::NotNegative => value.max(0.0),
            Self::Ratio => value.clamp(0.0, 1.0),
        }
    }
}

impl DesignParameter {
    /// Returns the parameter of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        let mut every = PARAMETERS.iter().chain(CATCH_PARAMETERS);
        every.find(|parameter| parameter.name == name)
    }

    /// Returns its name within its section.
    pub fn key(&self) -> &'static str {
        self.name.split_once('.').map_or(self.name, |(_, key)| key)
    }

    /// Returns its name in `[tolerance]`; that of a number of the catch has its section before it, since
    /// the lever has numbers of the same name.
    pub fn tolerance_key(&self) -> &'static str {
        match self.slot {
            Slot::Catch(_) => self.name,
            _ => self.key(),
        }
    }

    /// Returns whether `[tolerance]` may name it: whether it is a number of lever, stop or catch.
    pub fn has_tolerance(&self) -> bool {
        matches!(self.slot, Slot::Lever(_) | Slot::Stop(_) | Slot::Catch(_))
    }

    /// Returns whether it is a number of one of these stops, or of none: the rigid stop has its restitution alone.
    pub fn counts_at(&self, stops: &[StopModel]) -> bool {
        let is_of_stop = matches!(self.slot, Slot::Stop(_));
        !is_of_stop || self.key() == "restitution" || stops.iter().any(|stop| stop.yields())
    }
}

macro_rules! slot {
    (Lever $key:ident) => {
        Slot::Lever(|lever| &mut lever.$key)
    };
    (Stop $key:ident) => {
        Slot::Stop(|stop| &mut stop.$key)
    };
    (Catch $key:ident) => {
        Slot::Catch(|catch| &mut catch.$key)
    };
    (Criterion $key:ident) => {
        Slot::Criterion(|criterion| &mut criterion.$key)
    };
    ($slot:ident $key:ident) => {
        Slot::$slot
    };
}

macro_rules! parameters {
    ($(#[$meta:meta])* $table:ident: $($section:ident.$key:ident as $slot:ident, $condition:ident, $low:literal..$high:expr, $stream:expr, $symbol:literal, $unit:literal, $what:literal, $noun:literal;)*) => {
        $(#[$meta])*
        pub const $table: &[DesignParameter] = &[$(DesignParameter {
            name: concat!(stringify!($section), ".", stringify!($key)),
            symbol: $symbol,
            unit: $unit,
            condition: Condition::$condition,
            plausible: Range::new($low, $high),
            stream: $stream,
            what: $what,
            noun: $noun,
            slot: slot!($slot $key),
        }),*];
    };
}

parameters! {
    /// Every number of a design without a catch, in the order of a design file.
    PARAMETERS:
    lever.moment_of_inertia_kg_m2 as Lever, Positive, 1e-6..0.1, Some(2), "I₀", "kg m²", "Moment of inertia about the pivot", "moment of inertia";
    lever.pivot_damping_nm_s_per_rad as Lever, NotNegative, 0.0..0.1, Some(3), "c₀", "N m s/rad", "Damping at the pivot", "damping at the pivot";
    lever.spring_stiffness_nm_per_rad as Lever, NotNegative, 0.0..100.0, Some(4), "k₀", "N m/rad", "Stiffness of the spring", "stiffness of the spring";
    lever.preload_torque_nm as Lever, NotNegative, 0.0..100.0, Some(5), "T₀", "N m", "Preload torque", "preload torque";
    lever.mass_kg as Lever, Positive, 1e-3..5.0, Some(6), "m", "kg", "Mass", "mass of the lever";
    lever.center_of_mass_m as Lever, NotZero, 1e-3..0.5, Some(7), "L", "m", "Distance of the centre of mass", "distance of its centre of mass";
    stop.restitution as Stop, Ratio, 0.0..1.0, Some(8), "R", "1", "Restitution of the rigid stop", "restitution of the stop";
    stop.stiffness_n_per_m as Stop, Positive, 1e3..1e10, Some(9), "kₛ", "N/m", "Stiffness of the soft stop", "stiffness of the stop";
    stop.damping_n_s_per_m as Stop, NotNegative, 0.0..1e4, Some(10), "cₛ", "N s/m", "Damping of the soft stop", "damping of the stop";
    stop.radius_m as Stop, Positive, 1e-3..1.0, Some(11), "lₛ", "m", "Distance of the stop from the pivot", "distance of the stop";
    criterion.threshold_rad as Criterion, Positive, 1e-4..std::f64::consts::FRAC_PI_2, None, "φ*", "rad", "Limit of the angle", "limit of the angle";
    criterion.open_share as Criterion, Share, 1e-5..0.05, None, "", "1", "Share of levers and readings that may open", "share that may open";
    criterion.confidence as Criterion, Share, 0.95..0.9999, None, "", "1", "Confidence that fewer than that share open", "confidence of the share";
    input.scale as InputScale, NotNegative, 0.0..0.3, Some(0), "", "1", "Input: scale of the acceleration", "scale of the acceleration";
    input.bias_g as InputBias, NotNegative, 0.0..10.0, Some(1), "", "g", "Input: bias of the acceleration", "bias of the acceleration";
}

parameters! {
    /// Every number of an inertia catch, in the order of a design file.
    CATCH_PARAMETERS:
    catch.moment_of_inertia_kg_m2 as Catch, Positive, 1e-8..0.01, Some(12), "I₂", "kg m²", "Catch: moment of inertia about its pivot", "moment of inertia of the catch";
    catch.pivot_damping_nm_s_per_rad as Catch, NotNegative, 0.0..0.1, Some(13), "c₂", "N m s/rad", "Catch: damping at its pivot", "damping at the pivot of the catch";
    catch.spring_stiffness_nm_per_rad as Catch, NotNegative, 0.0..10.0, Some(14), "k₂", "N m/rad", "Catch: stiffness of its spring", "stiffness of the spring of the catch";
    catch.preload_torque_nm as Catch, NotNegative, 0.0..10.0, Some(15), "T₂", "N m", "Catch: preload torque", "preload torque of the catch";
    catch.unbalance_kg_m as Catch, NotNegative, 0.0..0.1, Some(16), "S₂", "kg m", "Catch: unbalance, mass times arm", "unbalance of the catch";
    catch.engagement_angle_rad as Catch, NotNegative, 0.0..std::f64::consts::FRAC_PI_2, Some(17), "ψb", "rad", "Catch: angle from which on it blocks the lever", "engagement angle of the catch";
    catch.end_stop_angle_rad as Catch, NotNegative, 0.0..std::f64::consts::FRAC_PI_2, Some(18), "ψm", "rad", "Catch: angle of its end stop", "angle of the end stop of the catch";
    catch.lever_angle_rad as Catch, Positive, 1e-4..std::f64::consts::FRAC_PI_2, Some(19), "φb", "rad", "Catch: angle of the lever at which it blocks", "angle at which the catch blocks the lever";
    catch.rest_restitution as Catch, Ratio, 0.0..1.0, Some(20), "e₀", "1", "Catch: restitution of its rest stop", "restitution of the catch at rest";
    catch.end_stop_restitution as Catch, Ratio, 0.0..1.0, Some(21), "eₘ", "1", "Catch: restitution of its end stop", "restitution of the end stop of the catch";
    catch.engagement_restitution as Catch, Ratio, 0.0..1.0, Some(22), "eb", "1", "Catch: restitution between it and the lever", "restitution between catch and lever";
}
