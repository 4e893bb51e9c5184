//! The question of a replay as data: how a recording is read and conditioned, and what decides.
//!
//! A [`Request`] says what a user asked, in the words of [`Setting`]: every door (the command
//! line, a file, a service) makes one, every document holds the one that it answers. Precedence is
//! decided here and nowhere else: what the request states comes before the card beside the
//! recording, the card before what the file itself says. How many threads work, who watches and
//! which report is drawn are no part of it: they change no number.
//!
//! - `fields`: the fields of a request in and out of serde;
//! - `map`: a request as keys and values, both ways;
//! - `read`: how each field is read and written;
//! - `value`: the values of settings as words, for options, files and documents alike.

mod fields;
mod map;
mod read;
mod value;

pub use map::MarginRequest;
pub use value::{
    MEMBERS_DEFAULT, SEED_DEFAULT, STEPS_PER_PERIOD_DEFAULT, Word, parse_bias, parse_count,
    parse_finite, parse_method, parse_number, parse_phi0, parse_positive, parse_resample,
    parse_sensitivity, parse_time_unit, parse_tolerance, parse_velocity, parse_window, words_of,
};

use latchgate_kernel::model::Design;
use latchgate_kernel::range::Window;
use latchgate_kernel::replay::{ADAPTIVE_TOLERANCE_MIN, Method};
use latchgate_kernel::units::{
    AccelerationUnit, DecimalMark, MessageClock, OpensWhen, SensorSensitivity, TimeUnit,
};
use latchgate_recording::card::{AcceptedWord, CardPolarity};
use latchgate_recording::error::Error;
use latchgate_recording::setting::Setting;
use latchgate_recording::{AcceptedRemark, Card, FORMATS, Limits, ReadOptions, TransferRange};
use latchgate_verdict::conditioning::{
    Between, BiasWindow, ConditioningOptions, FilterChoice, FilterStandard,
};
use latchgate_verdict::in_plane::InPlane;
use latchgate_verdict::{ModelChoice, Polarity, Policy, ensemble};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// The question of a replay. `None` leaves a setting to the card, the file or its default.
///
/// As JSON it is an object with the keys of [`Setting`]. What is left to card or file is absent,
/// defaults are written out, so that a stored question keeps its meaning; an unknown key is an
/// error that names the nearest known one.
///
/// # Examples
///
/// ```
/// use latchgate_document::Request;
///
/// let request: Request = serde_json::from_str(r#"{"channel": "acc_y", "members": 0}"#)?;
/// assert_eq!(request.channel.as_deref(), Some("acc_y"));
/// let unknown = serde_json::from_str::<Request>(r#"{"chanel": "acc_y"}"#).unwrap_err();
/// assert!(unknown.to_string().contains("did you mean `channel`?"));
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self", default, deny_unknown_fields)]
pub struct Request {
    /// Format name of [`FORMATS`]; recognised if absent.
    #[serde(
        deserialize_with = "read::some_text",
        skip_serializing_if = "Option::is_none"
    )]
    pub input_format: Option<String>,
    /// Channel to judge: a name, a number, `topic:field.path`, a code or pattern.
    #[serde(
        deserialize_with = "read::name",
        skip_serializing_if = "Option::is_none"
    )]
    pub channel: Option<String>,
    /// Second in-plane channel, named as the judged one, for a design with an axis.
    #[serde(
        deserialize_with = "read::name",
        skip_serializing_if = "Option::is_none"
    )]
    pub radial_channel: Option<String>,
    /// Name or number of the column that holds the time.
    #[serde(
        deserialize_with = "read::name",
        skip_serializing_if = "Option::is_none"
    )]
    pub time_column: Option<String>,
    /// Unit of that column.
    #[serde(
        deserialize_with = "read::time_unit",
        serialize_with = "read::write_text",
        skip_serializing_if = "Option::is_none"
    )]
    pub time_unit: Option<TimeUnit>,
    /// Whose clock tells the time of a log's messages.
    #[serde(
        deserialize_with = "read::some_word",
        serialize_with = "read::write_some_word",
        skip_serializing_if = "Option::is_none"
    )]
    pub time_source: Option<MessageClock>,
    /// Name of the sheet of a workbook.
    #[serde(
        deserialize_with = "read::some_text",
        skip_serializing_if = "Option::is_none"
    )]
    pub sheet: Option<String>,
    /// Line of a text table that names its columns, counted from 1; what stands above is no sample.
    #[serde(
        deserialize_with = "read::line",
        skip_serializing_if = "Option::is_none"
    )]
    pub header_line: Option<u32>,
    /// Line of a text table that holds the units of its columns.
    #[serde(
        deserialize_with = "read::line",
        skip_serializing_if = "Option::is_none"
    )]
    pub unit_line: Option<u32>,
    /// Last line of a text table; what stands below is no sample.
    #[serde(
        deserialize_with = "read::line",
        skip_serializing_if = "Option::is_none"
    )]
    pub last_line: Option<u32>,
    /// Lines at the start of a text table that are passed over.
    #[serde(
        deserialize_with = "read::lines",
        skip_serializing_if = "Option::is_none"
    )]
    pub skip_lines: Option<u32>,
    /// Decimal mark of a text table.
    #[serde(
        deserialize_with = "read::some_word",
        serialize_with = "read::write_some_word",
        skip_serializing_if = "Option::is_none"
    )]
    pub decimal: Option<DecimalMark>,
    /// Sample rate where the file holds no time [Hz].
    #[serde(
        deserialize_with = "read::positive",
        serialize_with = "read::write_number",
        skip_serializing_if = "Option::is_none"
    )]
    pub rate_hz: Option<f64>,
    /// Instant of first contact on the file's clock [s].
    #[serde(
        deserialize_with = "read::finite",
        serialize_with = "read::write_number",
        skip_serializing_if = "Option::is_none"
    )]
    pub time_zero: Option<f64>,
    /// Unit of acceleration.
    #[serde(
        deserialize_with = "read::some_word",
        serialize_with = "read::write_some_word",
        skip_serializing_if = "Option::is_none"
    )]
    pub unit: Option<AccelerationUnit>,
    /// What one of the samples means as an acceleration, where they are another quantity.
    #[serde(
        deserialize_with = "read::sensitivity",
        serialize_with = "read::write_text",
        skip_serializing_if = "Option::is_none"
    )]
    pub sensitivity: Option<SensorSensitivity>,
    /// Remarks that a person has read and accepts, as they are shown; those of the card join them.
    #[serde(
        deserialize_with = "read::remarks",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub accepted_remarks: Vec<String>,
    /// Velocity change that a person knows from another source [m/s].
    #[serde(
        rename = "velocity_change",
        deserialize_with = "read::positive",
        serialize_with = "read::write_number",
        skip_serializing_if = "Option::is_none"
    )]
    pub velocity_change_m_s: Option<f64>,
    /// What a person accepts of the recording; that of the card joins it.
    #[serde(
        rename = "accept",
        deserialize_with = "read::accepted",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub accepted: Vec<AcceptedWord>,
    /// Factors between the acceleration at the sensor's place and the one at the latch.
    #[serde(
        deserialize_with = "read::transfer",
        serialize_with = "read::write_text",
        skip_serializing_if = "Option::is_none"
    )]
    pub transfer: Option<TransferRange>,
    /// Judge every lateral channel of that side in the file; the worst answer counts.
    #[serde(
        deserialize_with = "read::flag",
        skip_serializing_if = "std::ops::Not::not"
    )]
    pub siblings: bool,
    /// Check the recording as a sled pulse.
    #[serde(
        deserialize_with = "read::flag",
        skip_serializing_if = "std::ops::Not::not"
    )]
    pub sled206: bool,
    /// Sign of the recorded acceleration that opens the lever.
    #[serde(
        deserialize_with = "read::some_word",
        serialize_with = "read::write_some_word",
        skip_serializing_if = "Option::is_none"
    )]
    pub opens_when: Option<CardPolarity>,
    /// Samples whose mean is removed.
    #[serde(
        deserialize_with = "read::bias",
        serialize_with = "read::write_bias",
        skip_serializing_if = "is_default_bias"
    )]
    pub bias: BiasWindow,
    /// Channel frequency class.
    #[serde(
        deserialize_with = "read::word",
        serialize_with = "read::write_word",
        skip_serializing_if = "is_default_filter"
    )]
    pub filter: FilterChoice,
    /// Whose filter.
    #[serde(deserialize_with = "read::word", serialize_with = "read::write_word")]
    pub filter_standard: FilterStandard,
    /// How the acceleration runs between samples.
    #[serde(deserialize_with = "read::word", serialize_with = "read::write_word")]
    pub between: Between,
    /// Rate fed to the model [Hz]; `None` for the recording's.
    #[serde(
        rename = "resample",
        deserialize_with = "read::resample",
        serialize_with = "read::write_number",
        skip_serializing_if = "Option::is_none"
    )]
    pub resample_hz: Option<f64>,
    /// Judged window; `None` for the whole record.
    #[serde(
        rename = "window",
        deserialize_with = "read::window",
        serialize_with = "read::write_window",
        skip_serializing_if = "Option::is_none"
    )]
    pub window_s: Option<Window>,
    /// Stop models that decide.
    #[serde(deserialize_with = "read::word", serialize_with = "read::write_word")]
    pub model: ModelChoice,
    /// Integrator.
    #[serde(
        deserialize_with = "read::method",
        serialize_with = "read::write_method"
    )]
    pub method: Method,
    /// Truncation let pass in a step [rad]; `None` for the method's own.
    #[serde(
        rename = "tolerance",
        deserialize_with = "read::tolerance",
        serialize_with = "read::write_number",
        skip_serializing_if = "Option::is_none"
    )]
    pub tolerance_rad: Option<f64>,
    /// Largest ensemble; 0 for nominal runs alone.
    #[serde(deserialize_with = "read::members")]
    pub members: u32,
    /// Seed of the ensemble.
    #[serde(deserialize_with = "read::seed")]
    pub seed: u64,
    /// Initial angle [rad]; `None` for that of rest on the stop.
    #[serde(
        rename = "phi0",
        deserialize_with = "read::phi0",
        serialize_with = "read::write_number",
        skip_serializing_if = "Option::is_none"
    )]
    pub phi0_rad: Option<f64>,
    /// Initial angular velocity [rad/s]; `None` for rest.
    #[serde(
        rename = "omega0",
        deserialize_with = "read::velocity",
        serialize_with = "read::write_number",
        skip_serializing_if = "Option::is_none"
    )]
    pub omega0_rad_s: Option<f64>,
    /// Limits on input that are changed, by name.
    #[serde(
        rename = "limit",
        deserialize_with = "read::limits",
        skip_serializing_if = "BTreeMap::is_empty"
    )]
    pub limits: BTreeMap<String, u64>,
}

fn is_default_bias(bias: &BiasWindow) -> bool {
    *bias == BiasWindow::PreEvent
}

fn is_default_filter(filter: &FilterChoice) -> bool {
    *filter == FilterChoice::Default
}

impl Default for Request {
    fn default() -> Self {
        Self {
            input_format: None,
            channel: None,
            radial_channel: None,
            time_column: None,
            time_unit: None,
            time_source: None,
            sheet: None,
            header_line: None,
            unit_line: None,
            last_line: None,
            skip_lines: None,
            decimal: None,
            rate_hz: None,
            time_zero: None,
            unit: None,
            sensitivity: None,
            accepted_remarks: Vec::new(),
            velocity_change_m_s: None,
            accepted: Vec::new(),
            transfer: None,
            siblings: false,
            sled206: false,
            opens_when: None,
            bias: BiasWindow::PreEvent,
            filter: FilterChoice::Default,
            filter_standard: FilterStandard::Iso6487,
            between: Between::default(),
            resample_hz: None,
            window_s: None,
            model: ModelChoice::Auto,
            method: Method::EventDriven,
            tolerance_rad: None,
            members: MEMBERS_DEFAULT,
            seed: SEED_DEFAULT,
            phi0_rad: None,
            omega0_rad_s: None,
            limits: BTreeMap::new(),
        }
    }
}

/// Who declares which sign of the recorded acceleration opens the lever.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PolaritySource {
    /// The request.
    Option,
    /// The card beside the recording.
    Card,
    /// The word of a pulse.
    Pulse,
    /// Nobody.
    #[default]
    Undeclared,
}

/// Who states the factors between the sensor's place and the latch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TransferSource {
    /// The request.
    Option,
    /// The card beside the recording.
    Card,
}

impl TransferSource {
    /// Returns the word that documents use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Option => "option",
            Self::Card => "card",
        }
    }
}

impl PolaritySource {
    /// Returns the word that documents use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Option => "option",
            Self::Card => "card",
            Self::Pulse => "pulse",
            Self::Undeclared => "undeclared",
        }
    }
}

impl Request {
    /// Refuses what no recording and no design could make right.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::UnknownName`] for a format that no reader bears,
    /// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for an initial angle inside a rigid stop, a method
    /// that does not know the soft stop, or a tolerance finer than the method's rounding.
    pub fn check(&self) -> Result<(), Error> {
        self.check_values()?;
        self.check_format()?;
        if let Some(angle) = self.phi0_rad.filter(|angle| *angle < 0.0)
            && self.model.stops().iter().any(|stop| !stop.yields())
        {
            return Err(Error::out_of_range(
                "the setting `phi0` [rad]",
                "0 or more on the rigid stop; choose the setting `model` = soft for an \
                 angle inside the stop",
                angle.to_string(),
            ));
        }
        self.check_method()
    }

    /// Refuses values that no document could state: what is written must be read back.
    fn check_values(&self) -> Result<(), Error> {
        if self.time_column.is_some() && self.rate_hz.is_some() {
            return Err(Error::out_of_range(
                Setting::RateHz.to_string(),
                format!(
                    "absent where {} says where the time is",
                    Setting::TimeColumn
                ),
                "both",
            ));
        }
        if self.header_line.is_some() && self.skip_lines.is_some() {
            return Err(Error::out_of_range(
                Setting::SkipLines.to_string(),
                format!("absent where {} is stated", Setting::HeaderLine),
                "both",
            ));
        }
        if self.radial_channel.is_some() && self.sensitivity.is_some() {
            return Err(Error::out_of_range(
                Setting::RadialChannel.to_string(),
                format!(
                    "absent where {} is that of one sensor; convert the samples of both first",
                    Setting::Sensitivity
                ),
                "both",
            ));
        }
        if self.radial_channel.is_some() && self.siblings {
            return Err(Error::out_of_range(
                Setting::Siblings.to_string(),
                format!(
                    "absent where {} is the one beside one sensor",
                    Setting::RadialChannel
                ),
                "both",
            ));
        }
        if self.unit.is_some() && self.sensitivity.is_some() {
            return Err(Error::out_of_range(
                Setting::Unit.to_string(),
                format!(
                    "absent where {} says what the samples are",
                    Setting::Sensitivity
                ),
                "both",
            ));
        }
        let stated = BTreeMap::<String, Value>::from(self.clone());
        if Self::try_from(stated)? == *self {
            return Ok(());
        }
        Err(Error::out_of_range(
            "every number of a request",
            "finite",
            format!("{self:?}"),
        ))
    }

    fn check_format(&self) -> Result<(), Error> {
        let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
        match &self.input_format {
            Some(name) if !names.contains(&name.as_str()) => {
                Err(Error::unknown("input format", name.clone(), &names))
            }
            _ => Ok(()),
        }
    }

    fn check_method(&self) -> Result<(), Error> {
        let name = self.method.name();
        let mut stops = self.model.stops().iter();
        if stops.any(|stop| !self.method.admits(*stop)) {
            return Err(Error::out_of_range(
                Setting::Method.to_string(),
                format!(
                    "one that knows the soft stop; {name} knows the rigid one only, choose the \
                     setting `model` = rigid"
                ),
                format!("{name} with the setting `model` = {}", self.model.name()),
            ));
        }
        if let Some(tolerance) = self
            .tolerance_rad
            .filter(|tolerance| *tolerance < ADAPTIVE_TOLERANCE_MIN)
            && matches!(self.method, Method::Dopri5 { .. })
        {
            return Err(Error::out_of_range(
                format!("{} of {name}", Setting::Tolerance),
                format!("at least {ADAPTIVE_TOLERANCE_MIN:e}"),
                tolerance.to_string(),
            ));
        }
        Ok(())
    }

    /// Refuses a design that no lever can have, or whose tolerances leave what is physical, where
    /// levers are to be scattered by them.
    ///
    /// # Errors
    ///
    /// As [`Design::validate`] and [`ensemble::check`].
    pub fn check_design(&self, design: &Design) -> Result<(), Error> {
        design.validate()?;
        if self.radial_channel.is_some() {
            InPlane::of(&design.lever)?;
            if design.catch.is_some() {
                return Err(Error::out_of_range(
                    Setting::RadialChannel.to_string(),
                    "absent for a design with an inertia catch, of whose directions nothing is stated",
                    "both",
                ));
            }
        }
        if self.members == 0 {
            return Ok(());
        }
        ensemble::check(design)
    }

    /// Returns how the second in-plane channel is read, if there is one: as the judged one but for its name.
    pub fn radial_read_options(&self, card: &Card) -> Option<ReadOptions> {
        Some(ReadOptions {
            channel: Some(self.radial_channel.clone()?),
            ..self.read_options(card)
        })
    }

    /// Returns `limits` with those that the request changes.
    ///
    /// # Errors
    ///
    /// As [`Limits::set`].
    pub fn limits(&self, limits: &Limits) -> Result<Limits, Error> {
        let mut limits = limits.clone();
        for (name, value) in &self.limits {
            limits.set(&format!("{name}={value}"))?;
        }
        Ok(limits)
    }

    /// Returns how the recording is read: as asked, else as its card says.
    pub fn read_options(&self, card: &Card) -> ReadOptions {
        // Unit and sensitivity are one statement: that of the request counts, or that of the card.
        let is_requested = self.unit.is_some() || self.sensitivity.is_some();
        let (unit, sensitivity) = match is_requested {
            true => (self.unit, &self.sensitivity),
            false => (card.unit, &card.sensitivity),
        };
        ReadOptions {
            channel: self.channel.clone().or_else(|| card.channel.clone()),
            time_column: self.time_column.clone(),
            time_unit: self.time_unit,
            time_source: self.time_source.or(card.time_source),
            sheet: self.sheet.clone().or_else(|| card.sheet.clone()),
            // Of the two ways to say where a table begins, that of the request counts alone.
            header_line: self
                .header_line
                .or(card.header_line.filter(|_| self.skip_lines.is_none())),
            skip_lines: self
                .skip_lines
                .or(card.skip_lines.filter(|_| self.header_line.is_none())),
            unit_line: self.unit_line.or(card.unit_line),
            last_line: self.last_line.or(card.last_line),
            decimal: self.decimal.or(card.decimal),
            rate_hz: self.rate_hz.or(card.rate),
            time_zero_s: self.time_zero,
            unit,
            sensitivity: sensitivity.clone(),
            unit_from_card: !is_requested && (unit.is_some() || sensitivity.is_some()),
            input_format: self.input_format.clone(),
            accepted_remarks: self.accepted_remarks(card),
        }
    }

    fn accepted_remarks(&self, card: &Card) -> Vec<AcceptedRemark> {
        let accept = |texts: &[String], by_card| -> Vec<AcceptedRemark> {
            let accept = |text: &String| AcceptedRemark {
                text: text.clone(),
                by_card,
            };
            texts.iter().map(accept).collect()
        };
        let requested = accept(&self.accepted_remarks, false);
        [requested, accept(&card.accepted_remarks, true)].concat()
    }

    /// Returns how the channel is conditioned.
    pub fn conditioning_options(&self, card: &Card) -> ConditioningOptions {
        ConditioningOptions {
            judged_peak_m_s2: None,
            bias: self.bias,
            filter: self.filter,
            filter_standard: self.filter_standard,
            resample_hz: self.resample_hz,
            range_g: card.range_g,
            synthetic: card.synthetic,
            wide_band: card.says_wide_band(),
            velocity_change_m_s: self.velocity_change_m_s.or(card.velocity_change_m_s),
            clock_accepted: self.accepts(card, AcceptedWord::Clock),
            noise_accepted: self.accepts(card, AcceptedWord::Noise),
            processed_accepted: self.accepts(card, AcceptedWord::Processed),
        }
    }

    /// True if a person accepts a doubt, by request or card.
    pub fn accepts(&self, card: &Card, word: AcceptedWord) -> bool {
        [&self.accepted, &card.accepted]
            .iter()
            .any(|words| words.contains(&word))
    }

    /// Returns the factors between the sensor's place and the latch that a person states, and who does.
    pub fn transfer(&self, card: &Card) -> Option<(TransferRange, TransferSource)> {
        let requested = self.transfer.map(|range| (range, TransferSource::Option));
        requested.or(card.transfer.map(|range| (range, TransferSource::Card)))
    }

    /// Returns which sign opens, and who says so: as asked, else as the card says.
    pub fn polarity(&self, card: &Card) -> (Polarity, PolaritySource) {
        let requested = self.opens_when.map(|sign| (sign, PolaritySource::Option));
        let declared = requested.or(card.opens_when.map(|sign| (sign, PolaritySource::Card)));
        match declared {
            None => (Polarity::Undeclared, PolaritySource::Undeclared),
            Some((CardPolarity::Negative, source)) => {
                (Polarity::Declared(OpensWhen::Negative), source)
            }
            Some((CardPolarity::Positive, source)) => {
                (Polarity::Declared(OpensWhen::Positive), source)
            }
            Some((CardPolarity::Both, source)) => (Polarity::Both, source),
        }
    }

    /// Returns what decides, for a recording whose opening sign is known or not.
    pub fn policy(&self, polarity: Polarity) -> Policy {
        Policy {
            model: self.model,
            polarity,
            between: self.between,
            method: self.method,
            tolerance_rad: self.tolerance_rad,
            initial_angle_rad: self.phi0_rad,
            initial_velocity_rad_s: self.omega0_rad_s,
            window_s: self.window_s,
            members: self.members,
            seed: self.seed,
            work: self
                .limits
                .get("work")
                .copied()
                .unwrap_or(Limits::default().work),
        }
    }
}
