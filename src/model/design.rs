//! A design: lever, stop, criterion, tolerances, as a TOML file states them.

use super::lever::Lever;
use super::stop::Stop;
use crate::error::{Error, ErrorKind, Place, nearest_name};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The angle beyond which the door is lost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Criterion {
    /// Largest angle that keeps the door shut [rad].
    pub threshold_rad: f64,
}

impl Default for Criterion {
    fn default() -> Self {
        Self { threshold_rad: 0.1 }
    }
}

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

/// A latch design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Design {
    /// Name, used in folders and reports.
    pub name: String,
    /// The lever.
    pub lever: Lever,
    /// The stop.
    pub stop: Stop,
    /// What loses the door.
    pub criterion: Criterion,
    /// One standard deviation of any key of `lever` and `stop`, in that key's unit.
    pub tolerance: BTreeMap<String, f64>,
    /// Uncertainty of the input.
    pub input: InputUncertainty,
}

impl Default for Design {
    fn default() -> Self {
        Self::reference()
    }
}

/// Every key that a design file or an override may name, with the condition on its value.
const KEYS: &[(&str, Range)] = &[
    ("lever.moment_of_inertia_kg_m2", Range::Positive),
    ("lever.pivot_damping_nm_s_per_rad", Range::NotNegative),
    ("lever.spring_stiffness_nm_per_rad", Range::NotNegative),
    ("lever.preload_torque_nm", Range::NotNegative),
    ("lever.mass_kg", Range::Positive),
    ("lever.center_of_mass_m", Range::Positive),
    ("stop.restitution", Range::Ratio),
    ("stop.stiffness_n_per_m", Range::Positive),
    ("stop.damping_n_s_per_m", Range::NotNegative),
    ("stop.radius_m", Range::Positive),
    ("criterion.threshold_rad", Range::Positive),
    ("input.scale", Range::NotNegative),
    ("input.bias_g", Range::NotNegative),
];

#[derive(Debug, Clone, Copy)]
enum Range {
    Positive,
    NotNegative,
    Ratio,
}

impl Design {
    /// Returns the design of eq. (3.1) with the threshold of section 2 of the paper.
    #[must_use]
    pub fn reference() -> Self {
        Self {
            name: "paper".into(),
            lever: Lever::reference(),
            stop: Stop::reference(),
            criterion: Criterion::default(),
            tolerance: BTreeMap::from([("restitution".to_string(), 0.02)]),
            input: InputUncertainty::default(),
        }
    }

    /// Reads a design file; keys that are absent take the reference design's values.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Malformed`] if the text is not TOML or a value is of the wrong type,
    /// [`ErrorKind::UnknownName`] for an unknown key, with the nearest known one,
    /// [`ErrorKind::OutOfRange`] for a value that no lever can have.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let table: toml::Table = text
            .parse()
            .map_err(|error: toml::de::Error| malformed(&error, text))?;
        let mut design = Self::reference();
        design.name = "design".into();
        for (key, value) in &table {
            match (key.as_str(), value) {
                ("name", toml::Value::String(name)) => design.name.clone_from(name),
                (
                    section @ ("lever" | "stop" | "criterion" | "input"),
                    toml::Value::Table(entries),
                ) => {
                    for (key, value) in entries {
                        number(key, value)
                            .and_then(|value| design.set_number(&format!("{section}.{key}"), value))
                            .map_err(|error| error.at(place_of_key(text, Some(section), key)))?;
                    }
                }
                ("tolerance", toml::Value::Table(entries)) => {
                    // A file that names its tolerances names all of them.
                    design.tolerance.clear();
                    for (key, value) in entries {
                        number(key, value)
                            .and_then(|value| design.set_number(&format!("tolerance.{key}"), value))
                            .map_err(|error| {
                                error.at(place_of_key(text, Some("tolerance"), key))
                            })?;
                    }
                }
                ("name" | "lever" | "stop" | "criterion" | "input" | "tolerance", other) => {
                    return Err(Error::from(ErrorKind::Malformed {
                        expected: if key == "name" {
                            "a text for `name`".into()
                        } else {
                            format!("a table [{key}]")
                        },
                        found: with_article(other.type_str()),
                        hint: "see the design file in the README".into(),
                    })
                    .at(place_of_key(text, None, key)));
                }
                _ => {
                    return Err(unknown(
                        key,
                        &["name", "lever", "stop", "criterion", "tolerance", "input"],
                    )
                    .at(place_of_key(text, None, key)));
                }
            }
        }
        design.validate()?;
        Ok(design)
    }

    /// Applies an override such as `lever.preload_torque_nm=2.82`.
    ///
    /// # Errors
    ///
    /// As [`Design::from_toml`].
    pub fn set(&mut self, assignment: &str) -> Result<(), Error> {
        let Some((key, value)) = assignment.split_once('=') else {
            return Err(ErrorKind::Malformed {
                expected: "KEY=VALUE".into(),
                found: format!("`{assignment}`"),
                hint: "for example the setting `set` = lever.preload_torque_nm=2.82".into(),
            }
            .into());
        };
        let (key, value) = (key.trim(), value.trim());
        if key == "name" {
            self.name = value.to_string();
            return Ok(());
        }
        let parsed: f64 = value.parse().map_err(|_| {
            Error::from(ErrorKind::Malformed {
                expected: format!("a number for {key}"),
                found: format!("`{value}`"),
                hint: "write a decimal number with a dot".into(),
            })
        })?;
        self.set_number(key, parsed)
    }

    fn set_number(&mut self, key: &str, value: f64) -> Result<(), Error> {
        if let Some(name) = key.strip_prefix("tolerance.") {
            let names = tolerance_names();
            if !names.contains(&name) {
                return Err(unknown(
                    key,
                    &names
                        .iter()
                        .map(|name| format!("tolerance.{name}"))
                        .collect::<Vec<_>>(),
                ));
            }
            check_range(key, value, Range::NotNegative)?;
            self.tolerance.insert(name.to_string(), value);
            return Ok(());
        }
        let Some((_, range)) = KEYS.iter().find(|(name, _)| *name == key) else {
            return Err(unknown(
                key,
                &KEYS.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
            ));
        };
        check_range(key, value, *range)?;
        *self
            .number_mut(key)
            .expect("every name in KEYS has its field") = value;
        Ok(())
    }

    fn number_mut(&mut self, key: &str) -> Option<&mut f64> {
        Some(match key {
            "lever.moment_of_inertia_kg_m2" => &mut self.lever.moment_of_inertia_kg_m2,
            "lever.pivot_damping_nm_s_per_rad" => &mut self.lever.pivot_damping_nm_s_per_rad,
            "lever.spring_stiffness_nm_per_rad" => &mut self.lever.spring_stiffness_nm_per_rad,
            "lever.preload_torque_nm" => &mut self.lever.preload_torque_nm,
            "lever.mass_kg" => &mut self.lever.mass_kg,
            "lever.center_of_mass_m" => &mut self.lever.center_of_mass_m,
            "stop.restitution" => &mut self.stop.restitution,
            "stop.stiffness_n_per_m" => &mut self.stop.stiffness_n_per_m,
            "stop.damping_n_s_per_m" => &mut self.stop.damping_n_s_per_m,
            "stop.radius_m" => &mut self.stop.radius_m,
            "criterion.threshold_rad" => &mut self.criterion.threshold_rad,
            "input.scale" => &mut self.input.scale,
            "input.bias_g" => &mut self.input.bias_g,
            _ => return None,
        })
    }

    /// Returns the damping ratio ξ of the lever in contact with the soft stop [-].
    #[must_use]
    pub fn contact_damping_ratio(&self) -> f64 {
        self.stop.contact_damping_nm_s_per_rad(&self.lever)
            / (2.0
                * self.lever.moment_of_inertia_kg_m2
                * self.stop.contact_angular_frequency_rad_s(&self.lever))
    }

    /// Checks what single ranges cannot see.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::OutOfRange`] if neither spring nor preload presses the lever onto the
    /// stop, or the inertia is less than that of the mass at its own centre.
    pub fn validate(&self) -> Result<(), Error> {
        let lever = &self.lever;
        if lever.preload_torque_nm + lever.spring_stiffness_nm_per_rad <= 0.0 {
            return Err(ErrorKind::OutOfRange {
                what: "lever.preload_torque_nm and lever.spring_stiffness_nm_per_rad".into(),
                expected: "positive, at least one of them, or nothing closes the lever".into(),
                found: "0 and 0".into(),
            }
            .into());
        }
        let least = lever.mass_kg * lever.center_of_mass_m * lever.center_of_mass_m;
        if lever.moment_of_inertia_kg_m2 < least {
            return Err(ErrorKind::OutOfRange {
                what: "lever.moment_of_inertia_kg_m2 [kg m²]".into(),
                expected: format!("at least m·L² = {least:e} (parallel-axis theorem)"),
                found: format!("{:e}", lever.moment_of_inertia_kg_m2),
            }
            .into());
        }
        Ok(())
    }
}

fn tolerance_names() -> Vec<&'static str> {
    KEYS.iter()
        .filter_map(|(key, _)| {
            key.strip_prefix("lever.")
                .or_else(|| key.strip_prefix("stop."))
        })
        .collect()
}

fn check_range(key: &str, value: f64, range: Range) -> Result<(), Error> {
    let (good, expected) = match range {
        Range::Positive => (value > 0.0 && value.is_finite(), "positive and finite"),
        Range::NotNegative => (
            value >= 0.0 && value.is_finite(),
            "zero or positive, and finite",
        ),
        Range::Ratio => ((0.0..=1.0).contains(&value), "0 to 1"),
    };
    if good {
        Ok(())
    } else {
        Err(ErrorKind::OutOfRange {
            what: key.into(),
            expected: expected.into(),
            found: format!("{value}"),
        }
        .into())
    }
}

fn number(key: &str, value: &toml::Value) -> Result<f64, Error> {
    match value {
        toml::Value::Float(number) => Ok(*number),
        toml::Value::Integer(number) => Ok(*number as f64),
        other => Err(ErrorKind::Malformed {
            expected: format!("a number for `{key}`"),
            found: with_article(other.type_str()),
            hint: "write a decimal number with a dot, without quotes".into(),
        }
        .into()),
    }
}

fn with_article(kind: &str) -> String {
    let article = if kind.starts_with(['a', 'i']) {
        "an"
    } else {
        "a"
    };
    format!("{article} {kind}")
}

fn unknown<T: AsRef<str>>(key: &str, known: &[T]) -> Error {
    let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
    ErrorKind::UnknownName {
        what: "design key",
        found: key.into(),
        nearest: nearest_name(key, &known),
        known: known.join(", "),
    }
    .into()
}

fn malformed(error: &toml::de::Error, text: &str) -> Error {
    let line = error.span().map_or(1, |span| {
        let before = text.as_bytes().iter().take(span.start);
        1 + before.filter(|byte| **byte == b'\n').count() as u64
    });
    Error::from(ErrorKind::Malformed {
        expected: "a design file in TOML".into(),
        found: error.message().to_string(),
        hint: "see the design file in the README".into(),
    })
    .at(Place::default().line(line))
}

/// Finds the line on which `key` stands, below the line of its `[section]` if it has one.
fn place_of_key(text: &str, section: Option<&str>, key: &str) -> Place {
    let names = |line: &str, name: &str| {
        let line = line.trim_start_matches(['[', '"', '\'', ' ']);
        line.strip_prefix(name)
            .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
    };
    let lines = || text.lines().map(str::trim_start).zip(1_u64..);
    let start = section.map_or(Some(0), |section| {
        lines()
            .find(|(line, _)| line.starts_with('[') && names(line, section))
            .map(|(_, number)| number)
    });
    // A table written in one line, or a dotted key, holds its keys on the line of its name.
    let found = match (section, start) {
        (Some(section), None) => lines().find(|(line, _)| names(line, section)),
        (_, start) => {
            lines().find(|(line, number)| *number > start.unwrap_or(0) && names(line, key))
        }
    };
    found.map_or_else(Place::default, |(_, number)| Place::default().line(number))
}
