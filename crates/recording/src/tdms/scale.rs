//! Scales: what turns stored numbers into the quantity of a channel, as far as that is plain
//! arithmetic.
//!
//! Counts of a converter that are taken for accelerations would be a wrong pass, so whatever is not
//! understood to the end is refused.

use super::object::{Object, is_technical};
use super::segment::CONVERT;
use super::value::Value;
use crate::channel_name::words;
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
        let (mut stated_scales, mut scaled, mut unscaled) = (None, None, None);
        for object in objects {
            let scales = Self::of(object)?;
            stated_scales = stated_scales.or(scales);
            match object.stated(STATUS).map(Value::text).as_deref() {
                None => {}
                Some("scaled") => scaled = scaled.or(Some(*object)),
                Some("unscaled") => unscaled = unscaled.or(Some(*object)),
                Some(_) => return Err(refused(STATUS, object)),
            }
        }
        match (stated_scales, scaled, unscaled) {
            // Stored numbers would be scaled twice, or not at all.
            (Some(_), Some(object), _) | (None, _, Some(object)) => Err(refused(STATUS, object)),
            (stated_scales, _, _) => Ok(stated_scales.unwrap_or_default()),
        }
    }

    /// Refuses a channel whose numbers are needed as they are stored, where something says that they have a
    /// scale; for whole numbers (`is_whole`) in words of the writer's own as well.
    pub(super) fn refuse_any(objects: &[&Object], is_whole: bool) -> Result<(), Error> {
        let scale = match Self::find(objects)?.is_empty() {
            false => "a scale (NI_Scale)".to_string(),
            true => match objects
                .first()
                .filter(|_| is_whole)
                .and_then(|object| scale_in_words(object))
            {
                Some(scale) => scale,
                None => return Ok(()),
            },
        };
        let expected = "times and flags without a scale";
        Err(Error::malformed(expected, scale, CONVERT))
    }

    /// Reads the scales that an object states; `None` if it states none, or that they were applied
    /// before the samples were stored.
    fn of(object: &Object) -> Result<Option<Self>, Error> {
        let number = |key: &str| object.property(key).and_then(Value::number);
        let mut listed = 0;
        for key in object.keys_from(KEY_START) {
            let number = scale_number(key).ok_or_else(|| refused(key, object))?;
            listed = listed.max(number.saturating_add(1));
        }
        let stated = object.stated("NI_Number_Of_Scales").map(Value::number);
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
        match object.stated(STATUS).map(Value::text).as_deref() {
            Some("scaled") => return Ok(None),
            None | Some("unscaled") => {}
            Some(_) => return Err(refused(STATUS, object)),
        }
        // The last one gives the quantity; each names the one before it, or the stored numbers.
        let (mut next, mut scales) = (Some(count - 1), Vec::new());
        while let Some(index) = next {
            let key = |name: &str| format!("NI_Scale[{index}]_{name}");
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
                    let start = key("Polynomial_Coefficients[").to_lowercase();
                    let listed = object.keys_from(&start).count() as f64;
                    let size_key = key("Polynomial_Coefficients_Size");
                    let size = match object.stated(&size_key) {
                        None => 4.0,
                        Some(size) => size.number().unwrap_or(0.0),
                    };
                    let fits = (1.0..=MOST_COEFFICIENTS as f64).contains(&size);
                    if !fits || size.fract() > 0.0 || listed > size {
                        return Err(refused(&size_key, object));
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
                // A missing link of a longer chain would leave out the scales before it.
                None if count == 1 => None,
                None => return Err(refused(&source, object)),
                Some(stored) if stored.total_cmp(&f64::from(u32::MAX)).is_eq() => None,
                Some(before) if before >= 0.0 && before < index as f64 && before.fract() <= 0.0 => {
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

/// Says whether stored numbers were scaled before they were stored.
const STATUS: &str = "NI_Scaling_Status";

/// How the key of a scale begins, in small letters.
const KEY_START: &str = "ni_scale[";

/// Returns the number of the scale that a key speaks of.
fn scale_number(key: &str) -> Option<usize> {
    let small = key.to_lowercase();
    let (number, _) = small.strip_prefix(KEY_START)?.split_once(']')?;
    number.parse().ok()
}

/// Stems of keys that may turn counts into a quantity, as letters alone.
const STEMS: [&str; 24] = [
    "auflösung",
    "aufloesung",
    "calib",
    "conversion",
    "empfindlich",
    "eucount",
    "eupercount",
    "factor",
    "faktor",
    "gain",
    "kalib",
    "lsb",
    "mvg",
    "mvperg",
    "multiplier",
    "offset",
    "percount",
    "perdigit",
    "perg",
    "resolution",
    "scal",
    "sensitiv",
    "skal",
    "slope",
];

/// Returns what an object says of a scale in words of its writer's own.
pub(super) fn scale_in_words(object: &Object) -> Option<String> {
    let is_scale = |key: &str| {
        let small = key.to_lowercase();
        let is_standard = small.starts_with("ni_scal") || small == "ni_number_of_scales";
        let is_read = is_technical(key) && !small.starts_with("ni_");
        let letters: String = small.chars().filter(|c| c.is_alphabetic()).collect();
        let is_short = |word: &String| matches!(word.as_str(), "cal" | "kal" | "sens");
        let names =
            words(key).iter().any(is_short) || STEMS.iter().any(|stem| letters.contains(stem));
        names && !is_standard && !is_read
    };
    let is_number = |value: &Value| match value {
        Value::Number(..) | Value::Other => true,
        Value::Text(text) => text.contains(|c: char| c.is_ascii_digit()),
        Value::Instant(_) => false,
    };
    let mut properties = object.properties();
    let (key, value) = properties.find(|(key, value)| is_number(value) && is_scale(key))?;
    let (key, value) = (text::shown(key), text::shown(value.text()));
    Some(format!("whole numbers beside `{key}` {value}"))
}

/// Refuses a scale that is not read, or not whole.
fn refused(key: &str, object: &Object) -> Error {
    let statement = match object.property(key) {
        Some(value) => format!("{key} `{}`", text::shown(value.text())),
        None => format!("no {key}"),
    };
    let expected = "scales that are linear or polynomial";
    Error::malformed(expected, statement, CONVERT)
}
