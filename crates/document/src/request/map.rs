//! A request as keys and values, both ways.
//!
//! A field of [`Request`] carries how it is read and written; its key stands in the list here. The keys of a
//! margin are those of a replay and a few more.

use super::fields::{self, SettingsAsStated};
use super::{Request, parse_method, read, value};
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_recording::setting::Setting;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Settings by key, as JSON, TOML or a form states them.
type Entries = BTreeMap<String, Value>;

impl From<Request> for Entries {
    fn from(request: Request) -> Self {
        let mut entries = fields::write(&request);
        if let Some(steps) = request.method.steps_per_period() {
            entries.insert(Setting::StepsPerPeriod.key().to_string(), json!(steps));
        }
        entries
    }
}

impl Request {
    /// Lists the keys that a request may have.
    pub fn keys() -> impl Iterator<Item = &'static str> {
        OF_REPLAY.iter().map(|setting| setting.key())
    }

    /// Reads a request from keys and values, as a file or a form states them.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::UnknownName`] for an unknown key, [`ErrorKind::BadSetting`] for a value that its
    /// setting does not take.
    pub fn from_entries(entries: BTreeMap<String, Value>) -> Result<Self, Error> {
        Self::try_from(entries)
    }

    /// Returns the settings that differ from their defaults, so that a setting which a later
    /// version adds does not change what an older question is.
    pub fn stated(&self) -> BTreeMap<String, Value> {
        let default = Entries::from(Self::default());
        let mut stated = Entries::from(self.clone());
        stated.retain(|key, value| default.get(key) != Some(value));
        stated
    }
}

impl TryFrom<Entries> for Request {
    type Error = Error;

    fn try_from(mut entries: Entries) -> Result<Self, Error> {
        let request = take_request(&mut entries)?;
        refuse_unknown(&entries, OF_REPLAY)?;
        Ok(request)
    }
}

impl TryFrom<SettingsAsStated> for MarginRequest {
    type Error = Error;

    fn try_from(stated: SettingsAsStated) -> Result<Self, Error> {
        Self::try_from(stated.0)
    }
}

/// Settings of a replay.
const OF_REPLAY: &[Setting] = &[
    Setting::InputFormat,
    Setting::Channel,
    Setting::RadialChannel,
    Setting::TimeColumn,
    Setting::TimeUnit,
    Setting::TimeSource,
    Setting::Sheet,
    Setting::HeaderLine,
    Setting::UnitLine,
    Setting::LastLine,
    Setting::SkipLines,
    Setting::Decimal,
    Setting::RateHz,
    Setting::TimeZero,
    Setting::Unit,
    Setting::Sensitivity,
    Setting::AcceptedRemarks,
    Setting::VelocityChange,
    Setting::Accept,
    Setting::Transfer,
    Setting::Siblings,
    Setting::Sled206,
    Setting::OpensWhen,
    Setting::Bias,
    Setting::Filter,
    Setting::FilterStandard,
    Setting::Between,
    Setting::Resample,
    Setting::Window,
    Setting::Model,
    Setting::Method,
    Setting::StepsPerPeriod,
    Setting::Tolerance,
    Setting::Members,
    Setting::Seed,
    Setting::Phi0,
    Setting::Omega0,
    Setting::Limit,
];

/// Settings that a margin adds.
const OF_MARGIN: &[Setting] = &[Setting::CounterweightRadius];

/// Takes a request out of `entries`, where other settings may be left.
///
/// # Errors
///
/// [`ErrorKind::BadSetting`] for a value that its setting does not take.
fn take_request(entries: &mut Entries) -> Result<Request, Error> {
    let keys = OF_REPLAY
        .iter()
        .filter(|setting| **setting != Setting::StepsPerPeriod);
    let stated: serde_json::Map<String, Value> = keys
        .filter_map(|setting| entries.remove_entry(setting.key()))
        // A null says nothing, as an absent key does.
        .filter(|(_, value)| !value.is_null())
        .collect();
    let values = stated.clone();
    let mut request = fields::read(stated).map_err(|(key, wrong)| {
        let setting = OF_REPLAY.iter().find(|setting| setting.key() == key);
        match (setting, values.get(&key)) {
            (Some(setting), Some(value)) => refused(*setting, value, wrong),
            _ => Error::malformed(
                "a table of settings",
                wrong,
                "state each setting by its key",
            ),
        }
    })?;
    // The steps are part of the method, and a setting of their own.
    if let Some(value) = entries
        .remove(Setting::StepsPerPeriod.key())
        .filter(|value| !value.is_null())
    {
        let steps = read::whole(&value, 1, u32::MAX)
            .map_err(|wrong| refused(Setting::StepsPerPeriod, &value, wrong))?;
        request.method = parse_method(request.method.name(), steps).unwrap_or(request.method);
    }
    Ok(request)
}

/// Says what is wrong with the value of a setting.
fn refused(setting: Setting, value: &Value, wrong: String) -> Error {
    ErrorKind::BadSetting {
        setting,
        wrong,
        found: value.to_string(),
    }
    .into()
}

/// Refuses what is left of the entries once every known setting was taken out.
fn refuse_unknown(entries: &Entries, settings: &[Setting]) -> Result<(), Error> {
    let Some(key) = entries.keys().next() else {
        return Ok(());
    };
    let keys: Vec<&str> = settings.iter().map(|setting| setting.key()).collect();
    Err(Error::unknown("setting", key.clone(), &keys))
}

/// The question of a margin: that of a replay, and what is searched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SettingsAsStated", into = "BTreeMap<String, Value>")]
pub struct MarginRequest {
    /// What is replayed.
    pub replay: Request,
    /// Distance of the counterweight from the pivot, on its far side [m].
    pub counterweight_radius_m: f64,
}

/// Distance of the counterweight unless a request says otherwise [m].
const COUNTERWEIGHT_RADIUS_M: f64 = 0.03;

impl Default for MarginRequest {
    fn default() -> Self {
        Self {
            replay: Request::default(),
            counterweight_radius_m: COUNTERWEIGHT_RADIUS_M,
        }
    }
}

impl From<MarginRequest> for Entries {
    fn from(request: MarginRequest) -> Self {
        let mut entries = Self::from(request.replay);
        let mut put = |setting: Setting, value| entries.insert(setting.key().to_string(), value);
        put(
            Setting::CounterweightRadius,
            json!(request.counterweight_radius_m),
        );
        entries
    }
}

impl TryFrom<Entries> for MarginRequest {
    type Error = Error;

    fn try_from(mut entries: Entries) -> Result<Self, Error> {
        let mut request = Self {
            replay: take_request(&mut entries)?,
            ..Self::default()
        };
        let mut take = |setting: Setting| {
            let value = entries.remove(setting.key());
            value.filter(|value| !value.is_null())
        };
        if let Some(value) = take(Setting::CounterweightRadius) {
            request.counterweight_radius_m = read::number(&value)
                .and_then(value::positive)
                .map_err(|expected| refused(Setting::CounterweightRadius, &value, expected))?;
        }
        let settings: Vec<Setting> = [OF_REPLAY, OF_MARGIN].concat();
        refuse_unknown(&entries, &settings)?;
        Ok(request)
    }
}
