//! A design: lever, stop, criterion, tolerances.
//!
//! A number comes from a file, a document or an override; each way in ends at the same check
//! against the table of parameters.

use super::catch::Catch;
use super::criterion::Criterion;
use super::lever::Lever;
use super::linkage::{LinkageElement, Reduced};
use super::parameters::{CATCH_PARAMETERS, Condition, DesignParameter, PARAMETERS, Slot};
use super::stop::Stop;
use super::tolerance::Tolerance;
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Uncertainty of the input, one standard deviation each.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InputUncertainty {
    /// Of the acceleration's scale, relative [-].
    pub scale: f64,
    /// Of the acceleration's bias [g].
    pub bias_g: f64,
}

impl Default for InputUncertainty {
    fn default() -> Self {
        Self {
            scale: 0.01,
            bias_g: 0.1,
        }
    }
}

/// A latch design. One that is read, from TOML or JSON, is one that a lever can have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "DesignAsWritten")]
pub struct Design {
    /// Name, used in folders and reports.
    pub name: String,
    /// The lever.
    pub lever: Lever,
    /// The stop.
    pub stop: Stop,
    /// What loses the door.
    pub criterion: Criterion,
    /// One standard deviation of any key of `lever` and `stop`.
    pub tolerance: BTreeMap<String, Tolerance>,
    /// Uncertainty of the input.
    pub input: InputUncertainty,
    /// Keys whose values the design file did not state, so that they are those of the paper's example.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_stated: Vec<String>,
    /// Keys that an override gave another value than the design file, or the paper, has.
    pub modified: Vec<String>,
    /// The values that the overrides took the place of, where there were any.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub modified_from: BTreeMap<String, f64>,
    /// The elements that the lever was reduced from, where it was.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub linkage: Vec<LinkageElement>,
    /// An inertia catch beside the lever.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub catch: Option<Catch>,
}

/// A design as a document states it, before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct DesignAsWritten {
    name: String,
    lever: Lever,
    stop: Stop,
    criterion: Criterion,
    tolerance: BTreeMap<String, Tolerance>,
    input: InputUncertainty,
    not_stated: Vec<String>,
    modified: Vec<String>,
    modified_from: BTreeMap<String, f64>,
    linkage: Vec<LinkageElement>,
    catch: Option<Catch>,
}

impl Default for DesignAsWritten {
    fn default() -> Self {
        let Design {
            name,
            lever,
            stop,
            criterion,
            tolerance,
            input,
            not_stated,
            modified,
            modified_from,
            linkage,
            catch,
        } = Design::reference();
        Self {
            name,
            lever,
            stop,
            criterion,
            tolerance,
            input,
            not_stated,
            modified,
            modified_from,
            linkage,
            catch,
        }
    }
}

impl TryFrom<DesignAsWritten> for Design {
    type Error = Error;

    fn try_from(written: DesignAsWritten) -> Result<Self, Error> {
        let design = Self {
            name: written.name,
            lever: written.lever,
            stop: written.stop,
            criterion: written.criterion,
            tolerance: written.tolerance,
            input: written.input,
            not_stated: written.not_stated,
            modified: written.modified,
            modified_from: written.modified_from,
            linkage: written.linkage,
            catch: written.catch,
        };
        design.validate()?;
        Ok(design)
    }
}

impl Default for Design {
    fn default() -> Self {
        Self::reference()
    }
}

impl Design {
    /// Returns the design of eq. (3.1) with the threshold of section 2 of the paper.
    pub fn reference() -> Self {
        Self {
            name: "paper".into(),
            lever: Lever::reference(),
            stop: Stop::reference(),
            criterion: Criterion::default(),
            tolerance: BTreeMap::from([
                ("mass_kg".to_string(), Tolerance::Share(0.02)),
                ("preload_torque_nm".to_string(), Tolerance::Share(0.05)),
                ("restitution".to_string(), Tolerance::Deviation(0.02)),
            ]),
            input: InputUncertainty::default(),
            not_stated: Vec::new(),
            modified: Vec::new(),
            modified_from: BTreeMap::new(),
            linkage: Vec::new(),
            catch: None,
        }
    }

    /// Tells whether a design of another name has every value of the paper's, of catch and tolerances aside, as a file to start from
    /// has that nobody has filled in.
    pub fn repeats_reference(&self) -> bool {
        let reference = Self::reference();
        let is_renamed = self.name != reference.name;
        let (name, catch) = (self.name.clone(), self.catch);
        is_renamed
            && *self
                == Self {
                    name,
                    catch,
                    tolerance: self.tolerance.clone(),
                    not_stated: self.not_stated.clone(),
                    ..reference
                }
    }

    /// Tells whether it is the paper's example, overridden keys aside.
    pub fn is_reference_overridden(&self) -> bool {
        let reference = Self::reference();
        let mut base = self.clone();
        for (key, value) in &self.modified_from {
            let is_put = match key.strip_prefix("tolerance.") {
                // A share follows the value that was overridden; what it was is the reference's.
                Some(name) => match reference.tolerance.get(name) {
                    Some(tolerance) => base.override_tolerance(name, *tolerance).is_ok(),
                    None => false,
                },
                None => base.override_number(key, *value).is_ok(),
            };
            if !is_put {
                return false;
            }
        }
        base.modified.clear();
        base.modified_from.clear();
        base == reference
    }

    /// Gives the number of `key`, such as `lever.mass_kg`, another value and notes it as overridden.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownName`] for an unknown key, [`Error::OutOfRange`] for a value that no lever can
    /// have.
    pub fn override_number(&mut self, key: &str, value: f64) -> Result<(), Error> {
        self.overriding(key, |design| design.put_number(key, value))
    }

    /// Gives the number `key` of lever, stop or catch another tolerance and notes it as overridden.
    ///
    /// # Errors
    ///
    /// As [`Self::override_number`].
    pub fn override_tolerance(&mut self, key: &str, tolerance: Tolerance) -> Result<(), Error> {
        let name = format!("tolerance.{key}");
        self.overriding(&name, |design| design.put_tolerance(key, tolerance))
    }

    fn overriding(
        &mut self,
        key: &str,
        put: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let criterion = self.criterion;
        let before = self.number(key);
        put(self)?;
        self.not_stated.retain(|name| name != key);
        self.mark(key, before);
        let stated = criterion.raised_from_rad.unwrap_or(criterion.threshold_rad);
        self.criterion.raised_from_rad = (self.criterion.threshold_rad > stated).then_some(stated);
        Ok(())
    }

    /// Returns the number of a key such as `lever.mass_kg` or `tolerance.mass_kg`, in its unit.
    pub fn number(&self, key: &str) -> Option<f64> {
        match key.strip_prefix("tolerance.") {
            Some(key) => {
                let mut known = self.parameters();
                let parameter = known.find(|parameter| parameter.tolerance_key() == key)?;
                let tolerance = self.tolerance.get(key)?;
                Some(tolerance.deviation(self.value(parameter)))
            }
            None => self.parameter(key).map(|known| self.value(known)),
        }
    }

    /// Returns the numbers of preload and unbalance, of which mass or arm will do, whose tolerances are not stated, 0
    /// being a statement: without them nobody knows what a pass on the nominal lever is worth.
    pub fn missing_tolerances(&self) -> Vec<&'static str> {
        let lacks = |key: &str| !self.tolerance.contains_key(key);
        let mut missing = Vec::new();
        if lacks("preload_torque_nm") {
            missing.push("preload_torque_nm");
        }
        if lacks("mass_kg") && lacks("center_of_mass_m") {
            missing.push("mass_kg");
        }
        missing
    }

    /// Returns its parameter of this name.
    fn parameter(&self, name: &str) -> Option<&'static DesignParameter> {
        self.parameters().find(|parameter| parameter.name == name)
    }

    /// Notes that `key` was overridden, unless it has its first value again.
    fn mark(&mut self, key: &str, before: Option<f64>) {
        let marked = self.modified.iter().position(|marked| marked == key);
        let first = match marked {
            Some(_) => self.modified_from.get(key).copied(),
            None => before,
        };
        if self.number(key) == first {
            self.modified.retain(|marked| marked != key);
            self.modified_from.remove(key);
        } else if marked.is_none() {
            self.modified.push(key.to_string());
            self.modified.sort();
            self.modified_from
                .extend(first.map(|first| (key.to_string(), first)));
        }
    }

    /// Returns the numbers that it has, in the order of a design file.
    pub fn parameters(&self) -> impl Iterator<Item = &'static DesignParameter> + use<> {
        let of_catch = match self.catch {
            Some(_) => CATCH_PARAMETERS,
            None => &[],
        };
        PARAMETERS.iter().chain(of_catch)
    }

    /// Returns the limit of the angle that is judged without overrides and within what a latch can
    /// bear [rad]: that of the design, at most π/2.
    pub fn default_threshold_rad(&self) -> f64 {
        let Criterion {
            threshold_rad,
            raised_from_rad,
            ..
        } = self.criterion;
        raised_from_rad
            .unwrap_or(threshold_rad)
            .min(std::f64::consts::FRAC_PI_2)
    }

    /// Returns the numbers that no latch of this world has, with their values.
    pub fn implausible(&self) -> impl Iterator<Item = (&'static DesignParameter, f64)> + '_ {
        let of_each = self.parameters().map(|known| (known, self.value(known)));
        let size = |known: &DesignParameter, value: f64| match known.condition {
            Condition::NotZero => value.abs(),
            _ => value,
        };
        of_each.filter(move |(known, value)| !known.plausible.contains(size(known, *value)))
    }

    /// Gives the number of `name` a value, as a design file states it.
    ///
    /// # Errors
    ///
    /// As [`Design::override_number`].
    pub fn put_number(&mut self, name: &str, value: f64) -> Result<(), Error> {
        if let Some(key) = name.strip_prefix("tolerance.") {
            return self.put_tolerance(key, Tolerance::Deviation(value + 0.0));
        }
        let Some(parameter) = self.parameter(name) else {
            let names: Vec<_> = self.parameters().map(|known| known.name).collect();
            return Err(unknown(name, &names));
        };
        parameter.condition.check(name, value)?;
        self.put(parameter, value);
        Ok(())
    }

    /// Gives the number `key` of lever, stop or catch a tolerance, as a design file states it.
    ///
    /// # Errors
    ///
    /// As [`Design::override_number`].
    pub fn put_tolerance(&mut self, key: &str, tolerance: Tolerance) -> Result<(), Error> {
        self.check_tolerance(key, tolerance)?;
        self.tolerance.insert(key.to_string(), tolerance);
        Ok(())
    }

    /// Returns the value of `parameter`, in its unit; NaN of a catch that it has not.
    pub fn value(&self, parameter: &DesignParameter) -> f64 {
        match parameter.slot {
            Slot::Lever(field) => *field(&mut { self.lever }),
            Slot::Stop(field) => *field(&mut { self.stop }),
            Slot::Catch(field) => self.catch.map_or(f64::NAN, |mut catch| *field(&mut catch)),
            Slot::Criterion(field) => *field(&mut { self.criterion }),
            Slot::InputScale => self.input.scale,
            Slot::InputBias => self.input.bias_g,
        }
    }

    /// Sets `parameter` to a value that has been checked.
    fn put(&mut self, parameter: &DesignParameter, value: f64) {
        *match parameter.slot {
            Slot::Lever(field) => field(&mut self.lever),
            Slot::Stop(field) => field(&mut self.stop),
            Slot::Catch(field) => match &mut self.catch {
                Some(catch) => field(catch),
                None => return,
            },
            Slot::Criterion(field) => field(&mut self.criterion),
            Slot::InputScale => &mut self.input.scale,
            Slot::InputBias => &mut self.input.bias_g,
            // A negative zero says nothing else than a plain one.
        } = value + 0.0;
    }

    /// Returns one standard deviation of `parameter`, in its unit, where the design states one.
    pub fn deviation(&self, parameter: &DesignParameter) -> Option<f64> {
        match parameter.slot {
            Slot::Lever(_) | Slot::Stop(_) | Slot::Catch(_) => {
                let tolerance = self.tolerance.get(parameter.tolerance_key())?;
                Some(tolerance.deviation(self.value(parameter)))
            }
            Slot::InputScale | Slot::InputBias => Some(self.value(parameter)),
            Slot::Criterion(_) => None,
        }
    }

    /// Returns the damping ratio ξ of the lever in contact with the soft stop [-].
    pub fn contact_damping_ratio(&self) -> f64 {
        self.stop.contact_damping_nm_s_per_rad(&self.lever)
            / (2.0
                * self.lever.moment_of_inertia_kg_m2
                * self.stop.contact_angular_frequency_rad_s(&self.lever))
    }

    /// Checks every number against its range, and what single ranges cannot see.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::OutOfRange`] for a number that no lever can have, or if neither
    /// spring nor preload presses the lever onto the stop, or the inertia is less than that of the
    /// mass at its own centre, or the soft stop is damped beyond [`CONTACT_DAMPING_RATIO_MAX`];
    /// [`crate::error::Error::UnknownName`] for a tolerance of what has none.
    pub fn validate(&self) -> Result<(), Error> {
        for parameter in self.parameters() {
            parameter
                .condition
                .check(parameter.name, self.value(parameter))?;
        }
        for (key, tolerance) in &self.tolerance {
            self.check_tolerance(key, *tolerance)?;
            self.check_share(key, *tolerance)?;
        }
        let lever = &self.lever;
        if lever.preload_torque_nm + lever.spring_stiffness_nm_per_rad <= 0.0 {
            return Err(Error::out_of_range(
                "lever.preload_torque_nm and lever.spring_stiffness_nm_per_rad",
                "positive, at least one of them, or nothing closes the lever",
                "0 and 0",
            ));
        }
        self.validate_catch()?;
        self.validate_directions()?;
        self.validate_linkage()?;
        let least = lever.mass_kg * lever.center_of_mass_m * lever.center_of_mass_m;
        if lever.moment_of_inertia_kg_m2 < least {
            return Err(Error::out_of_range(
                "lever.moment_of_inertia_kg_m2 [kg m²]",
                format!("at least m·L² = {least:e} (parallel-axis theorem)"),
                format!("{:e}", lever.moment_of_inertia_kg_m2),
            ));
        }
        let ratio = self.contact_damping_ratio();
        if ratio > CONTACT_DAMPING_RATIO_MAX {
            return Err(Error::out_of_range(
                "the damping ratio ξ in contact, from stop.damping_n_s_per_m and lever.pivot_damping_nm_s_per_rad,",
                format!("at most {CONTACT_DAMPING_RATIO_MAX}: such a stop is glue"),
                format!("{ratio:.3e}"),
            ));
        }
        Ok(())
    }
}

impl Design {
    /// Refuses a share of nothing, which would scatter nothing in silence.
    fn check_share(&self, key: &str, tolerance: Tolerance) -> Result<(), Error> {
        let is_share = matches!(tolerance, Tolerance::Share(share) if share > 0.0);
        let mut parameters = self.parameters();
        let parameter = parameters.find(|parameter| parameter.tolerance_key() == key);
        match parameter {
            Some(parameter) if is_share && self.value(parameter) == 0.0 => {
                Err(Error::out_of_range(
                    format!("tolerance.{key}"),
                    format!(
                        "a number with its unit, {}, since {} is 0 and no share of it scatters",
                        parameter.unit, parameter.name
                    ),
                    tolerance.to_string(),
                ))
            }
            _ => Ok(()),
        }
    }

    /// Refuses a tolerance of a number that has none, or one that is no standard deviation.
    fn check_tolerance(&self, key: &str, tolerance: Tolerance) -> Result<(), Error> {
        let name = format!("tolerance.{key}");
        let scattered = || {
            self.parameters()
                .filter(|parameter| parameter.has_tolerance())
        };
        if !scattered().any(|parameter| parameter.tolerance_key() == key) {
            let names: Vec<_> = scattered()
                .map(|parameter| format!("tolerance.{}", parameter.tolerance_key()))
                .collect();
            return Err(unknown(&name, &names));
        }
        match tolerance {
            Tolerance::Deviation(deviation) => Condition::NotNegative.check(&name, deviation),
            Tolerance::Share(_) if tolerance.is_share_refused() => Err(Error::out_of_range(
                name,
                "from 0 % to less than 33 %: draws reach three standard deviations",
                tolerance.to_string(),
            )),
            Tolerance::Share(_) => Ok(()),
        }
    }

    /// Checks what the ranges of a catch's single numbers cannot see.
    fn validate_catch(&self) -> Result<(), Error> {
        let Some(catch) = &self.catch else {
            return Ok(());
        };
        let (engagement, end) = (catch.engagement_angle_rad, catch.end_stop_angle_rad);
        if engagement <= 0.0 {
            return Err(Error::out_of_range(
                "catch.engagement_angle_rad [rad]",
                "positive: a catch that blocks at rest lets no handle open",
                engagement.to_string(),
            ));
        }
        if end <= engagement {
            return Err(Error::out_of_range(
                "catch.end_stop_angle_rad [rad]",
                format!("more than catch.engagement_angle_rad = {engagement}"),
                end.to_string(),
            ));
        }
        if self.lever.center_of_mass_m < 0.0 {
            return Err(Error::out_of_range(
                "lever.center_of_mass_m [m] beside a catch",
                "positive: the acceleration that opens the lever is the one that moves the catch",
                self.lever.center_of_mass_m.to_string(),
            ));
        }
        if catch.preload_torque_nm + catch.spring_stiffness_nm_per_rad <= 0.0 {
            return Err(Error::out_of_range(
                "catch.preload_torque_nm and catch.spring_stiffness_nm_per_rad",
                "positive, at least one of them, or nothing returns the catch",
                "0 and 0",
            ));
        }
        Ok(())
    }

    /// Checks that axis and centre of mass are both stated, apart, and of the lever's own distance.
    fn validate_directions(&self) -> Result<(), Error> {
        let lever = &self.lever;
        if lever.axis.is_none() && lever.center_of_mass.is_none() {
            return Ok(());
        }
        let Some(directions) = lever.directions() else {
            return Err(Error::out_of_range(
                "lever.axis and lever.center_of_mass",
                "both, neither of length 0, and the centre off the axis",
                "others",
            ));
        };
        let stated = lever.center_of_mass_m;
        if stated < 0.0 {
            return Err(Error::out_of_range(
                "lever.center_of_mass_m [m]",
                "positive beside an axis: turn lever.center_of_mass",
                stated.to_string(),
            ));
        }
        let is_overridden = |key: &String| key == "lever.center_of_mass_m";
        if !differ(directions.distance_m, stated) || self.modified.iter().any(is_overridden) {
            return Ok(());
        }
        Err(Error::out_of_range(
            "lever.center_of_mass_m [m]",
            format!(
                "{}, the distance of lever.center_of_mass from the axis",
                directions.distance_m
            ),
            stated.to_string(),
        ))
    }

    /// Checks that the lever is the one that the linkage comes to, overridden keys aside.
    fn validate_linkage(&self) -> Result<(), Error> {
        if self.linkage.is_empty() {
            return Ok(());
        }
        let reduced = Reduced::of(&self.linkage)?;
        let lever = reduced.lever(self.lever.pivot_damping_nm_s_per_rad);
        let Some(lever) = lever else {
            return Err(Error::out_of_range(
                "linkage",
                "moment_of_inertia_kg_m2 of every element, which a replay needs",
                "none of some",
            ));
        };
        if self.lever.center_of_mass_m.signum() * lever.center_of_mass_m.signum() < 0.0 {
            return Err(Error::out_of_range(
                "lever.center_of_mass_m [m]",
                "of the sign that the linkage comes to",
                self.lever.center_of_mass_m.to_string(),
            ));
        }
        let mut reduced = self.clone();
        reduced.lever = lever;
        for parameter in PARAMETERS {
            let (stated, derived) = (self.value(parameter), reduced.value(parameter));
            let is_overridden = self.modified.iter().any(|key| key == parameter.name);
            if differ(stated, derived) && !is_overridden {
                return Err(Error::out_of_range(
                    parameter.name,
                    format!("{derived}, what the linkage comes to; leave it out"),
                    stated.to_string(),
                ));
            }
        }
        Ok(())
    }
}

/// Tells whether two numbers differ beyond rounding.
fn differ(a: f64, b: f64) -> bool {
    (a - b).abs() > 1e-9 * a.abs().max(b.abs())
}

/// Largest damping ratio of a soft stop that is judged [-]. One of 1 returns no lever any more.
pub const CONTACT_DAMPING_RATIO_MAX: f64 = 50.0;

fn unknown<T: ToString>(key: &str, known: &[T]) -> Error {
    Error::UnknownName {
        what: "design key",
        found: key.to_string(),
        known: known.iter().map(T::to_string).collect(),
    }
}
