//! Scales: what turns stored numbers into the quantity of a channel, as far as that is plain
//! arithmetic.
//!
//! Counts of a converter that are taken for accelerations would be a wrong pass, so whatever is not
//! understood to the end is refused.

use super::object::Object;
use super::segment::CONVERT;
use super::value::Value;
use crate::error::Error;
use crate::text;

/// Scales of a channel that are read.
const MOST: usize = 64;

/// Coefficients of a polynomial that are read.
const MOST_COEFFICIENTS: usize = 64;

/// One scale.
#[derive(Debug, Clone, PartialEq)]
enum Scale {
    Linear {
        slope: f64,
        intercept: f64,
    },
    /// Coefficients, that of the power 0 first.
    Polynomial(Vec<f64>),
}

impl Scale {
    fn apply(&self, value: f64) -> f64 {
        match self {
            Self::Linear { slope, intercept } => value * slope + intercept,
            Self::Polynomial(coefficients) => {
                let powers = coefficients.iter().rev().copied();
                powers.reduce(|sum, next| next + sum * value).unwrap_or(0.0)
            }
        }
    }
}

/// The scales of a channel, in the order in which they are applied.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Scales(Vec<Scale>);

impl Scales {
    /// Finds the scales of a channel: its own, else those of its group, else those of the file.
    pub(super) fn find(objects: &[&Object]) -> Result<Self, Error> {
        for object in objects {
            if let Some(scales) = Self::of(object)? {
                return Ok(scales);
            }
        }
        Ok(Self::default())
    }

    /// Reads the scales that an object states; `None` if it states none, or that they were applied
    /// before the samples were stored.
    fn of(object: &Object) -> Result<Option<Self>, Error> {
        let number = |key: &str| object.property(key).and_then(Value::number);
        let numbers = object.properties().filter_map(|(key, _)| scale_number(key));
        let listed = numbers.max().map_or(0, |last| last.saturating_add(1));
        let stated = object.property("NI_Number_Of_Scales").map(Value::number);
        let is_whole = |count: &f64| (0.0..=MOST as f64).contains(count) && count.fract() <= 0.0;
        let count = match stated {
            None => Some(listed),
            Some(count) => count.filter(is_whole).map(|count| count as usize),
        };
        let Some(count) = count.filter(|count| (listed..=MOST).contains(count)) else {
            return Err(refused("NI_Number_Of_Scales", object));
        };
        if count == 0 {
            return Ok(None);
        }
        match object
            .property("NI_Scaling_Status")
            .map(Value::text)
            .as_deref()
        {
            Some("scaled") => return Ok(None),
            None | Some("unscaled") => {}
            Some(_) => return Err(refused("NI_Scaling_Status", object)),
        }
        // The last one gives the quantity; each names the one before it, or the stored numbers.
        let (mut next, mut scales) = (Some(count - 1), Vec::new());
        while let Some(at) = next {
            let key = |name: &str| format!("NI_Scale[{at}]_{name}");
            let kind = object.property(&key("Scale_Type")).map(Value::text);
            let kind = kind.unwrap_or_default();
            let need = |name: &str| {
                let key = key(name);
                number(&key)
                    .filter(|number| number.is_finite())
                    .ok_or_else(|| refused(&key, object))
            };
            scales.push(match kind.as_str() {
                "Linear" => Scale::Linear {
                    slope: need("Linear_Slope")?,
                    intercept: need("Linear_Y_Intercept")?,
                },
                "Polynomial" => {
                    let size = number(&key("Polynomial_Coefficients_Size")).unwrap_or(4.0);
                    if !(1.0..=MOST_COEFFICIENTS as f64).contains(&size) || size.fract() > 0.0 {
                        return Err(refused(&key("Polynomial_Coefficients_Size"), object));
                    }
                    let coefficient = |power| need(&format!("Polynomial_Coefficients[{power}]"));
                    let coefficients: Result<Vec<f64>, Error> =
                        (0..size as usize).map(coefficient).collect();
                    Scale::Polynomial(coefficients?)
                }
                _ => return Err(refused(&key("Scale_Type"), object)),
            });
            let source = key(&format!("{kind}_Input_Source"));
            next = match number(&source) {
                None => None,
                Some(stored) if stored.total_cmp(&f64::from(u32::MAX)).is_eq() => None,
                Some(before) if before >= 0.0 && before < at as f64 && before.fract() <= 0.0 => {
                    Some(before as usize)
                }
                Some(_) => return Err(refused(&source, object)),
            };
        }
        scales.reverse();
        Ok(Some(Self(scales)))
    }

    /// Tells whether stored numbers are the quantity.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns what a stored number means.
    pub(super) fn apply(&self, value: f64) -> f64 {
        self.0.iter().fold(value, |value, scale| scale.apply(value))
    }
}

/// Returns the number of the scale that a key speaks of.
fn scale_number(key: &str) -> Option<usize> {
    let rest = key.strip_prefix("NI_Scale[")?;
    let (number, rest) = rest.split_once(']')?;
    (rest == "_Scale_Type")
        .then(|| number.parse().ok())
        .flatten()
}

/// Refuses a scale that is not read, or not whole.
fn refused(key: &str, object: &Object) -> Error {
    let found = match object.property(key) {
        Some(value) => format!("{key} `{}`", text::shown(value.text())),
        None => format!("no {key}"),
    };
    let expected = "scales that are linear or polynomial";
    Error::malformed(expected, found, CONVERT)
}
