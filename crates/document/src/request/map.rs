//! A request as keys and values, both ways.
//!
//! What is written and what is read of a setting stand in one file, so that one is not added
//! without the other; the keys of a margin are those of a replay and a few more.

use super::value::{self, STEPS_PER_PERIOD_DEFAULT};
use super::{Request, parse_method};
use latchgate_recording::Limits;
use latchgate_recording::card::AcceptedWord;
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_recording::setting::Setting;
use latchgate_verdict::conditioning::{BiasWindow, FilterChoice};
use latchgate_verdict::ensemble::MEMBERS_MAX;
use latchgate_verdict::margin::{MapAxis, MapRequest, map::GRID_MAX};
use serde::de::{Deserializer, Error as _, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Settings by key, as JSON, TOML or a form states them.
type Entries = BTreeMap<String, Value>;

impl From<Request> for Entries {
    fn from(request: Request) -> Self {
        all(&request)
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
    #[must_use]
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
        let request = from_entries(&mut entries)?;
        refuse_unknown(&entries, OF_REPLAY)?;
        Ok(request)
    }
}

/// Settings as a document states them: each key once, since of two some readers take the first.
pub(super) struct SettingsAsStated(Entries);

impl<'de> Deserialize<'de> for SettingsAsStated {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct EachKeyOnce;

        impl<'de> Visitor<'de> for EachKeyOnce {
            type Value = SettingsAsStated;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table of settings")
            }

            fn visit_map<A: MapAccess<'de>>(
                self,
                mut map: A,
            ) -> Result<SettingsAsStated, A::Error> {
                let mut entries = Entries::new();
                while let Some((key, value)) = map.next_entry::<String, Value>()? {
                    if entries.insert(key.clone(), value).is_some() {
                        return Err(A::Error::custom(format!("the key `{key}` stands twice")));
                    }
                }
                Ok(SettingsAsStated(entries))
            }
        }

        deserializer.deserialize_map(EachKeyOnce)
    }
}

impl TryFrom<SettingsAsStated> for Request {
    type Error = Error;

    fn try_from(stated: SettingsAsStated) -> Result<Self, Error> {
        Self::try_from(stated.0)
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
    Setting::TimeColumn,
    Setting::TimeUnit,
    Setting::TimeSource,
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
    Setting::OpensWhen,
    Setting::Bias,
    Setting::Filter,
    Setting::FilterStandard,
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
const OF_MARGIN: &[Setting] = &[
    Setting::CounterweightRadius,
    Setting::Points,
    Setting::Map,
    Setting::MapGrid,
];

/// Returns every setting that has a value, defaults among them.
fn all(request: &Request) -> Entries {
    let mut found = Entries::new();
    let mut put = |setting: Setting, value: Option<Value>| {
        if let Some(value) = value {
            found.insert(setting.key().to_string(), value);
        }
    };
    let text = |text: &Option<String>| text.as_ref().map(|text| json!(text));
    let number = |number: Option<f64>| number.map(|number| json!(number + 0.0));
    put(Setting::InputFormat, text(&request.input_format));
    put(Setting::Channel, text(&request.channel));
    put(Setting::TimeColumn, text(&request.time_column));
    put(
        Setting::TimeUnit,
        request.time_unit.map(|unit| json!(unit.to_string())),
    );
    put(
        Setting::TimeSource,
        request.time_source.map(|clock| json!(clock.name())),
    );
    let count = |count: Option<u32>| count.map(|count| json!(count));
    put(Setting::HeaderLine, count(request.header_line));
    put(Setting::UnitLine, count(request.unit_line));
    put(Setting::LastLine, count(request.last_line));
    put(Setting::SkipLines, count(request.skip_lines));
    put(
        Setting::Decimal,
        request.decimal.map(|mark| json!(mark.name())),
    );
    put(Setting::RateHz, number(request.rate_hz));
    put(Setting::TimeZero, number(request.time_zero));
    put(Setting::Unit, request.unit.map(|unit| json!(unit.name())));
    let sensitivity = request.sensitivity.as_ref();
    put(
        Setting::Sensitivity,
        sensitivity.map(|sensitivity| json!(sensitivity.to_string())),
    );
    put(
        Setting::AcceptedRemarks,
        (!request.accepted_remarks.is_empty()).then(|| json!(request.accepted_remarks)),
    );
    put(Setting::VelocityChange, number(request.velocity_change_m_s));
    put(
        Setting::Accept,
        (!request.accepted.is_empty()).then(|| json!(request.accepted)),
    );
    put(
        Setting::OpensWhen,
        request.opens_when.map(|sign| json!(sign.name())),
    );
    put(
        Setting::Bias,
        match request.bias {
            BiasWindow::PreEvent => None,
            BiasWindow::None => Some(json!("none")),
            BiasWindow::Window(start, end) => Some(json!(value::interval((start, end)))),
        },
    );
    put(
        Setting::Filter,
        match request.filter {
            FilterChoice::Default => None,
            FilterChoice::None => Some(json!("none")),
            FilterChoice::Class(class) => Some(json!(class.name())),
        },
    );
    put(
        Setting::FilterStandard,
        Some(json!(request.filter_standard.name())),
    );
    put(Setting::Resample, number(request.resample_hz));
    put(
        Setting::Window,
        request
            .window_s
            .map(|window| json!(value::interval(window))),
    );
    put(Setting::Model, Some(json!(request.model.name())));
    put(Setting::Method, Some(json!(request.method.name())));
    put(
        Setting::StepsPerPeriod,
        request.method.steps_per_period().map(|steps| json!(steps)),
    );
    put(Setting::Tolerance, number(request.tolerance_rad));
    put(Setting::Members, Some(json!(request.members)));
    put(Setting::Seed, Some(json!(request.seed)));
    put(Setting::Phi0, number(request.phi0_rad));
    put(Setting::Omega0, number(request.omega0_rad_s));
    put(
        Setting::Limit,
        (!request.limits.is_empty()).then(|| json!(request.limits)),
    );
    found
}

/// Takes a request out of `entries`, where other settings may be left.
///
/// # Errors
///
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a value that its setting does not take.
fn from_entries(entries: &mut Entries) -> Result<Request, Error> {
    let mut request = Request::default();
    let mut steps_per_period = STEPS_PER_PERIOD_DEFAULT;
    for &setting in OF_REPLAY {
        // A null says nothing, as an absent key does.
        if let Some(value) = entries
            .remove(setting.key())
            .filter(|value| !value.is_null())
        {
            set(&mut request, &mut steps_per_period, setting, &value)
                .map_err(|wrong| refused(setting, &value, wrong))?;
        }
    }
    request.method =
        parse_method(request.method.name(), steps_per_period).unwrap_or(request.method);
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

fn refuse_unknown(entries: &Entries, known: &[Setting]) -> Result<(), Error> {
    let Some(key) = entries.keys().next() else {
        return Ok(());
    };
    let known: Vec<&str> = known.iter().map(|setting| setting.key()).collect();
    Err(Error::unknown("setting", key.clone(), &known))
}

/// Sets one value; an error says what was expected.
fn set(
    request: &mut Request,
    steps_per_period: &mut u32,
    setting: Setting,
    value: &Value,
) -> Result<(), String> {
    match setting {
        Setting::InputFormat => request.input_format = Some(text(value)?.into()),
        Setting::Channel => request.channel = Some(name(value)?),
        Setting::TimeColumn => request.time_column = Some(name(value)?),
        Setting::TimeUnit => request.time_unit = Some(value::parse_time_unit(text(value)?)?),
        Setting::TimeSource => request.time_source = Some(value::parse_time_source(text(value)?)?),
        Setting::HeaderLine => request.header_line = Some(count(value, 1, u32::MAX)?),
        Setting::UnitLine => request.unit_line = Some(count(value, 1, u32::MAX)?),
        Setting::LastLine => request.last_line = Some(count(value, 1, u32::MAX)?),
        Setting::SkipLines => request.skip_lines = Some(count(value, 0, u32::MAX)?),
        Setting::Decimal => request.decimal = Some(value::parse_decimal(text(value)?)?),
        Setting::RateHz => request.rate_hz = Some(value::positive(number(value)?)?),
        Setting::TimeZero => request.time_zero = Some(value::finite(number(value)?)?),
        Setting::Unit => request.unit = Some(value::parse_unit(text(value)?)?),
        Setting::Sensitivity => {
            request.sensitivity = Some(value::parse_sensitivity(text(value)?)?);
        }
        Setting::AcceptedRemarks => request.accepted_remarks = texts(value)?,
        Setting::VelocityChange => {
            request.velocity_change_m_s = Some(value::positive(number(value)?)?);
        }
        Setting::Accept => request.accepted = accepted(value)?,
        Setting::OpensWhen => request.opens_when = Some(value::parse_polarity(text(value)?)?),
        Setting::Bias => request.bias = value::parse_bias(text(value)?)?,
        Setting::Filter => request.filter = value::parse_filter(text(value)?)?,
        Setting::FilterStandard => request.filter_standard = value::parse_standard(text(value)?)?,
        Setting::Resample => {
            request.resample_hz = match value {
                Value::String(text) => value::parse_resample(text)?,
                _ => Some(value::rate_to_resample(number(value)?)?),
            };
        }
        Setting::Window => request.window_s = Some(value::parse_window(text(value)?)?),
        Setting::Model => request.model = value::parse_model(text(value)?)?,
        Setting::Method => request.method = parse_method(text(value)?, *steps_per_period)?,
        Setting::StepsPerPeriod => *steps_per_period = count(value, 1, u32::MAX)?,
        Setting::Tolerance => request.tolerance_rad = Some(value::tolerance(number(value)?)?),
        Setting::Members => request.members = count(value, 0, MEMBERS_MAX)?,
        Setting::Seed => {
            request.seed = value
                .as_u64()
                .ok_or("must be a whole number, not negative".to_string())?;
        }
        Setting::Phi0 => request.phi0_rad = Some(value::phi0(number(value)?)?),
        Setting::Omega0 => request.omega0_rad_s = Some(value::velocity(number(value)?)?),
        Setting::Limit => request.limits = limits(value)?,
        _ => return Err("must be a setting of a replay".into()),
    }
    Ok(())
}

fn text(value: &Value) -> Result<&str, String> {
    value.as_str().ok_or_else(|| "must be a text".into())
}

fn texts(value: &Value) -> Result<Vec<String>, String> {
    let list = value.as_array().ok_or("must be a list of texts")?;
    list.iter()
        .map(|one| text(one).map(str::to_string))
        .collect()
}

/// Words to accept: a list, or one alone.
fn accepted(value: &Value) -> Result<Vec<AcceptedWord>, String> {
    let words = match value {
        Value::String(word) => vec![word.clone()],
        list => texts(list)?,
    };
    let words: Result<BTreeSet<AcceptedWord>, String> = words
        .iter()
        .map(|word| value::parse_accepted(word))
        .collect();
    words.map(|words| words.into_iter().collect())
}

/// A name, or a number that counts from 1.
fn name(value: &Value) -> Result<String, String> {
    match value {
        Value::String(text) => Ok(text.clone()),
        Value::Number(number) if number.as_u64().is_some_and(|number| number > 0) => {
            Ok(number.to_string())
        }
        _ => Err("must be a name, or a number from 1".into()),
    }
}

fn number(value: &Value) -> Result<f64, String> {
    value.as_f64().ok_or_else(|| "must be a number".into())
}

fn count(value: &Value, least: u32, most: u32) -> Result<u32, String> {
    value
        .as_u64()
        .and_then(|count| u32::try_from(count).ok())
        .filter(|count| (least..=most).contains(count))
        .ok_or_else(|| format!("must be a whole number from {least} to {most}"))
}

fn limits(value: &Value) -> Result<BTreeMap<String, u64>, String> {
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
}

/// The question of a margin: that of a replay, and what is searched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SettingsAsStated", into = "BTreeMap<String, Value>")]
pub struct MarginRequest {
    /// What is replayed.
    pub replay: Request,
    /// Distance of the counterweight from the pivot, on its far side [m].
    pub counterweight_radius_m: f64,
    /// Values of each quantity that the search begins with; `None` for as many as the length of
    /// the recording allows.
    pub points: Option<u32>,
    /// The map over two design keys.
    pub map: Option<MapRequest>,
}

/// Distance of the counterweight unless a request says otherwise [m].
const COUNTERWEIGHT_RADIUS_M: f64 = 0.03;

/// Values a side of a map unless a request says otherwise.
const GRID: usize = 61;

impl Default for MarginRequest {
    fn default() -> Self {
        Self {
            replay: Request::default(),
            counterweight_radius_m: COUNTERWEIGHT_RADIUS_M,
            points: None,
            map: None,
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
        if let Some(points) = request.points {
            put(Setting::Points, json!(points));
        }
        if let Some(map) = request.map {
            let axis = |axis: &MapAxis| format!("{}={}..{}", axis.key, axis.low, axis.high);
            put(Setting::Map, json!([axis(&map.x), axis(&map.y)]));
            put(
                Setting::MapGrid,
                json!(format!("{}x{}", map.columns, map.rows)),
            );
        }
        entries
    }
}

impl TryFrom<Entries> for MarginRequest {
    type Error = Error;

    fn try_from(mut entries: Entries) -> Result<Self, Error> {
        let mut request = Self {
            replay: from_entries(&mut entries)?,
            ..Self::default()
        };
        let mut take = |setting: Setting| {
            let value = entries.remove(setting.key());
            value.filter(|value| !value.is_null())
        };
        if let Some(value) = take(Setting::CounterweightRadius) {
            request.counterweight_radius_m = number(&value)
                .and_then(value::positive)
                .map_err(|expected| refused(Setting::CounterweightRadius, &value, expected))?;
        }
        if let Some(value) = take(Setting::Points) {
            let points = count(&value, 50, 20_000)
                .map_err(|expected| refused(Setting::Points, &value, expected))?;
            request.points = Some(points);
        }
        let grid = take(Setting::MapGrid);
        if let (Some(grid), false) = (&grid, entries.contains_key(Setting::Map.key())) {
            let wrong = format!("needs {}", Setting::Map);
            return Err(refused(Setting::MapGrid, grid, wrong));
        }
        let mut take = |setting: Setting| {
            let value = entries.remove(setting.key());
            value.filter(|value| !value.is_null())
        };
        let (columns, rows) = match grid {
            None => (GRID, GRID),
            Some(value) => text(&value)
                .and_then(parse_grid)
                .map_err(|expected| refused(Setting::MapGrid, &value, expected))?,
        };
        if let Some(value) = take(Setting::Map) {
            let [x, y] = axes(&value).map_err(|what| refused(Setting::Map, &value, what))?;
            request.map = Some(MapRequest {
                x,
                y,
                columns,
                rows,
            });
        }
        let known: Vec<Setting> = [OF_REPLAY, OF_MARGIN].concat();
        refuse_unknown(&entries, &known)?;
        Ok(request)
    }
}

fn axes(value: &Value) -> Result<[MapAxis; 2], String> {
    let expected = "must be two of KEY=LO..HI";
    let [x, y] = value.as_array().map(Vec::as_slice).ok_or(expected)? else {
        return Err(expected.into());
    };
    Ok([
        value::parse_map_axis(text(x)?)?,
        value::parse_map_axis(text(y)?)?,
    ])
}

/// Reads the values a side of a map, NxM.
///
/// # Errors
///
/// Says what was expected.
pub fn parse_grid(text: &str) -> Result<(usize, usize), String> {
    let counts = text
        .split_once('x')
        .and_then(|(columns, rows)| Some((columns.parse().ok()?, rows.parse().ok()?)));
    counts
        .filter(|(columns, rows)| (2..=GRID_MAX).contains(columns) && (2..=GRID_MAX).contains(rows))
        .ok_or_else(|| format!("expected NxM, each 2 to {GRID_MAX}, for example 61x61"))
}
