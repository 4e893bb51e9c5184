//! How serde reads and writes the fields of a request: each by the rule of its setting, so that a
//! message says what the setting takes.

use super::value::{self, Word};
use latchgate_kernel::range::Window;
use latchgate_kernel::replay::Method;
use latchgate_kernel::units::{SensorSensitivity, TimeUnit};
use latchgate_recording::card::AcceptedWord;
use latchgate_recording::{Limits, TransferRange};
use latchgate_verdict::conditioning::BiasWindow;
use latchgate_verdict::ensemble::MEMBERS_MAX;
use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::Serializer;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn text(value: &Value) -> Result<&str, String> {
    value.as_str().ok_or_else(|| "must be a text".into())
}

pub(super) fn number(value: &Value) -> Result<f64, String> {
    value.as_f64().ok_or_else(|| "must be a number".into())
}

pub(super) fn whole(value: &Value, least: u32, most: u32) -> Result<u32, String> {
    value
        .as_u64()
        .and_then(|count| u32::try_from(count).ok())
        .filter(|count| (least..=most).contains(count))
        .ok_or_else(|| format!("must be a whole number from {least} to {most}"))
}

fn texts(value: &Value) -> Result<Vec<String>, String> {
    let list = value.as_array().ok_or("must be a list of texts")?;
    list.iter()
        .map(|one| text(one).map(str::to_string))
        .collect()
}

/// Makes functions that serde calls for a field, each from a rule on the value.
macro_rules! readers {
    ($($name:ident: $result:ty = $rule:expr;)+) => {$(
        pub(super) fn $name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<$result, D::Error> {
            let rule: fn(&Value) -> Result<$result, String> = $rule;
            rule(&Value::deserialize(deserializer)?).map_err(D::Error::custom)
        }
    )+};
}

readers! {
    some_text: Option<String> = |value| Ok(Some(text(value)?.into()));
    // A name, or a number that counts from 1.
    name: Option<String> = |value| match value {
        Value::String(text) => Ok(Some(text.clone())),
        Value::Number(number) if number.as_u64().is_some_and(|number| number > 0) => {
            Ok(Some(number.to_string()))
        }
        _ => Err("must be a name, or a number from 1".into()),
    };
    time_unit: Option<TimeUnit> = |value| value::parse_time_unit(text(value)?).map(Some);
    sensitivity: Option<SensorSensitivity> = |value| value::parse_sensitivity(text(value)?).map(Some);
    line: Option<u32> = |value| whole(value, 1, u32::MAX).map(Some);
    lines: Option<u32> = |value| whole(value, 0, u32::MAX).map(Some);
    positive: Option<f64> = |value| value::positive(number(value)?).map(Some);
    finite: Option<f64> = |value| value::finite(number(value)?).map(Some);
    tolerance: Option<f64> = |value| value::tolerance(number(value)?).map(Some);
    phi0: Option<f64> = |value| value::phi0(number(value)?).map(Some);
    velocity: Option<f64> = |value| value::velocity(number(value)?).map(Some);
    remarks: Vec<String> = texts;
    // Words to accept: a list, or one alone.
    accepted: Vec<AcceptedWord> = |value| {
        let words = match value {
            Value::String(word) => vec![word.clone()],
            list => texts(list)?,
        };
        let words: Result<BTreeSet<_>, _> =
            words.iter().map(|word| AcceptedWord::from_word(word)).collect();
        Ok(words?.into_iter().collect())
    };
    transfer: Option<TransferRange> = |value| match value {
        Value::Number(_) => number(value).and_then(|factor| TransferRange::new(factor, factor)),
        Value::String(text) => TransferRange::from_text(text),
        _ => Err("must be a factor, or a text as 0.8..1.5".into()),
    }
    .map(Some);
    bias: BiasWindow = |value| value::parse_bias(text(value)?);
    resample: Option<f64> = |value| match value {
        Value::String(text) => value::parse_resample(text),
        _ => value::rate_to_resample(number(value)?).map(Some),
    };
    window: Option<Window> = |value| value::parse_window(text(value)?).map(Some);
    method: Method = |value| value::parse_method(text(value)?, value::STEPS_PER_PERIOD_DEFAULT);
    members: u32 = |value| whole(value, 0, MEMBERS_MAX);
    seed: u64 = |value| {
        let seed = value.as_u64();
        seed.ok_or_else(|| "must be a whole number, not negative".into())
    };
    limits: BTreeMap<String, u64> = |value| {
        let table = value.as_object().ok_or("must be a table of limits")?;
        let mut changed = BTreeMap::new();
        for (name, value) in table {
            let value = value.as_u64().ok_or("must hold whole numbers")?;
            Limits::default()
                .set(&format!("{name}={value}"))
                .map_err(|error| error.to_string())?;
            changed.insert(name.clone(), value);
        }
        // A limit that is stated as it stands is none that was changed.
        for limit in Limits::default().entries() {
            if changed.get(&*limit.name) == Some(&limit.value) {
                changed.remove(&*limit.name);
            }
        }
        Ok(changed)
    };
}

pub(super) fn word<'de, T: Word, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    let value = Value::deserialize(deserializer)?;
    text(&value)
        .and_then(T::from_word)
        .map_err(D::Error::custom)
}

pub(super) fn some_word<'de, T: Word, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    word(deserializer).map(Some)
}

pub(super) fn write_word<T: Word, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(value.word())
}

pub(super) fn write_some_word<T: Word, S: Serializer>(
    value: &Option<T>,
    to: S,
) -> Result<S::Ok, S::Error> {
    to.serialize_str(value.map_or("", Word::word))
}

/// Reads whether something is asked for: a truth value, or its word as a form has it.
pub(super) fn flag<'de, D: Deserializer<'de>>(from: D) -> Result<bool, D::Error> {
    match Value::deserialize(from)? {
        Value::Bool(flag) => Ok(flag),
        Value::String(word) if word == "true" => Ok(true),
        Value::String(word) if word == "false" || word.is_empty() => Ok(false),
        other => Err(D::Error::custom(format!(
            "must be true or false, found {other}"
        ))),
    }
}

pub(super) fn write_text<T: ToString, S: Serializer>(
    value: &Option<T>,
    to: S,
) -> Result<S::Ok, S::Error> {
    to.serialize_str(&value.as_ref().map_or_else(String::new, T::to_string))
}

/// Writes a number; a negative zero asks nothing else than a plain one.
pub(super) fn write_number<S: Serializer>(value: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_f64(value.unwrap_or(0.0) + 0.0)
}

pub(super) fn write_bias<S: Serializer>(value: &BiasWindow, to: S) -> Result<S::Ok, S::Error> {
    match value {
        BiasWindow::PreEvent | BiasWindow::None => to.serialize_str("none"),
        BiasWindow::Window(window) => to.serialize_str(&value::window(*window)),
    }
}

pub(super) fn write_window<S: Serializer>(
    value: &Option<Window>,
    to: S,
) -> Result<S::Ok, S::Error> {
    to.serialize_str(&value.map_or_else(String::new, value::window))
}

pub(super) fn write_method<S: Serializer>(value: &Method, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(value.name())
}
