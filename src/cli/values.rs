//! Values of options that only the command line knows, and how they are read.

use clap::ValueEnum;
use clap::builder::{PossibleValue, TypedValueParser};
use latchgate_document::request;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::Method;
use latchgate_recording::Limits;
use latchgate_recording::setting::Setting;
use latchgate_verdict::ModelChoice;
use std::ffi::OsStr;
use tracing::level_filters::LevelFilter;

/// Form of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OutputFormat {
    /// For people.
    Text,
    /// One JSON document.
    Json,
}

/// What reads a value, and the words of its setting, for completions; it may be others, too.
#[derive(Debug, Clone)]
pub struct ValueWords<T> {
    read: fn(&str) -> Result<T, String>,
    words: Vec<&'static str>,
}

impl<T> ValueWords<T> {
    /// Returns the reader `read` for a setting.
    pub fn of(setting: Setting, read: fn(&str) -> Result<T, String>) -> Self {
        let words = request::words_of(setting);
        Self { read, words }
    }
}

/// Returns the words of a setting as help shows them: `g|mg|m/s2`.
pub(super) fn words_shown(setting: Setting) -> String {
    request::words_of(setting).join("|")
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for ValueWords<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<T, clap::Error> {
        let read = self.read;
        (move |text: &str| read(text)).parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(
            self.words.iter().map(|word| PossibleValue::new(*word)),
        ))
    }
}

/// When colours are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ColorArgument {
    /// On a terminal, unless `NO_COLOR` is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// Form of the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogFormat {
    /// For people.
    Text,
    /// A JSON object per line.
    Json,
}

/// What `--log` asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LogSettings {
    /// Form.
    pub format: LogFormat,
    /// Least severe level shown.
    pub level: LevelFilter,
}

/// Stop model asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelArgument {
    /// The answer both give.
    Auto,
    /// Newton's restitution.
    Rigid,
    /// Spring and damper.
    Soft,
}

impl ModelArgument {
    /// Returns which stop models decide.
    pub fn choice(self) -> ModelChoice {
        match self {
            Self::Auto => ModelChoice::Auto,
            Self::Rigid => ModelChoice::Only(StopModel::Rigid),
            Self::Soft => ModelChoice::Only(StopModel::Soft),
        }
    }

    /// Returns the stops that a study runs; `auto` are both.
    pub fn stops(self) -> Vec<StopModel> {
        self.choice().stops().to_vec()
    }
}

/// One stop asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StopArgument {
    /// Newton's restitution.
    Rigid,
    /// Spring and damper.
    Soft,
}

impl StopArgument {
    /// Returns the stop.
    pub fn stop(self) -> StopModel {
        match self {
            Self::Rigid => StopModel::Rigid,
            Self::Soft => StopModel::Soft,
        }
    }
}

/// Integrator asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodArgument {
    /// Short Taylor series, every event located.
    EventDriven,
    /// The paper's: Runge-Kutta, fixed step, events on its grid.
    Rk4,
    /// The same with located events; steps end at samples.
    Rk4Located,
    /// Dormand and Prince, adaptive, located events, across samples.
    Dopri5,
    /// The same restarted at each sample.
    Dopri5Samples,
    /// Time-stepping with impacts at velocity level; rigid stop only.
    MoreauJean,
}

impl MethodArgument {
    /// Returns the method with its steps per natural period, where it has any.
    pub fn method(self, steps_per_period: u32) -> Method {
        match self {
            Self::EventDriven => Method::EventDriven,
            Self::Rk4 => Method::Rk4 { steps_per_period },
            Self::Rk4Located => Method::Rk4Located { steps_per_period },
            Self::Dopri5 => Method::Dopri5 { at_samples: false },
            Self::Dopri5Samples => Method::Dopri5 { at_samples: true },
            Self::MoreauJean => Method::MoreauJean { steps_per_period },
        }
    }
}

/// Rate asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resample {
    /// That of the recording.
    Native,
    /// This one [Hz].
    Hertz(f64),
}

pub(super) fn parse_log(text: &str) -> Result<LogSettings, String> {
    let (format, level) = text
        .split_once(':')
        .map_or((text, None), |(format, level)| (format, Some(level)));
    let (format, level) = match (format, level) {
        ("json", level) => (LogFormat::Json, level),
        ("text", level) => (LogFormat::Text, level),
        (level, None) => (LogFormat::Text, Some(level)),
        _ => return Err("expected [text|json][:LEVEL], for example json:debug".into()),
    };
    let level = match level.unwrap_or("info") {
        "error" => LevelFilter::ERROR,
        "warn" => LevelFilter::WARN,
        "info" => LevelFilter::INFO,
        "debug" => LevelFilter::DEBUG,
        "trace" => LevelFilter::TRACE,
        other => {
            return Err(format!(
                "unknown level `{other}`, expected error, warn, info, debug or trace"
            ));
        }
    };
    Ok(LogSettings { format, level })
}

pub(super) fn parse_date(text: &str) -> Result<String, String> {
    if crate::gate::file::is_day(text) {
        Ok(text.to_string())
    } else {
        Err("expected a day such as 2027-03-31".into())
    }
}

/// Reads a name that a page shows on one line.
pub(super) fn parse_name(text: &str) -> Result<String, String> {
    /// Most letters of a name.
    const LETTERS: usize = 100;
    let name = text.trim();
    match name.is_empty() || name.chars().count() > LETTERS || name.contains(char::is_control) {
        true => Err(format!(
            "expected a name of 1 to {LETTERS} letters on one line"
        )),
        false => Ok(name.into()),
    }
}

pub(super) fn parse_limit(text: &str) -> Result<String, String> {
    Limits::default()
        .set(text)
        .map(|()| text.to_string())
        .map_err(|error| error.to_string())
}

/// Reads a value, or `LO..HI`.
pub(super) fn parse_range(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = text.split_once("..").unwrap_or((text, text));
    let (from, to) = (request::parse_finite(from)?, request::parse_finite(to)?);
    match from <= to {
        true => Ok((from, to)),
        false => Err("LO must not be above HI".into()),
    }
}

pub(super) fn parse_resample(text: &str) -> Result<Resample, String> {
    request::parse_resample(text).map(|hertz| hertz.map_or(Resample::Native, Resample::Hertz))
}
