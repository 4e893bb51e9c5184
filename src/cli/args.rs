//! Options, as contract and help state them.

use crate::conditioning::resample::LEAST_RATE_HZ;
use crate::conditioning::{BiasWindow, Cfc, FilterChoice, FilterStandard};
use crate::error::Error;
use crate::margin::MapAxis;
use crate::margin::map::GRID_MAX;
use crate::model::stop::StopModel;
use crate::recording::Limits;
use crate::recording::card::CardPolarity;
use crate::replay::Method;
use crate::units::{AccelerationUnit, TimeUnit};
use crate::verdict::ensemble::MEMBERS_MAX;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use tracing::level_filters::LevelFilter;

/// Replays measured crash accelerations through a model of a door-latch lever and says, with
/// evidence, whether the door stays shut.
///
/// Exit codes of replay: 0 pass, 1 fail, 2 wrong usage, 3 undecided, 4 unusable.
#[derive(Debug, Parser)]
#[command(
    name = "latchgate",
    version,
    propagate_version = true,
    max_term_width = 100
)]
pub struct Arguments {
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// Largest ensemble unless an option says otherwise.
pub const MEMBERS_DEFAULT: u32 = 10_000;

/// Seed of the ensemble unless an option says otherwise.
pub const SEED_DEFAULT: u64 = 1;

/// Options of every command.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Say more on stderr: -v info, -vv debug, -vvv trace
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    /// Log to stderr as [text|json][:LEVEL], LEVEL one of error, warn, info, debug, trace
    #[arg(long, global = true, value_name = "FORMAT[:LEVEL]", value_parser = parse_log)]
    pub log: Option<Log>,
    /// Threads to use; the numbers do not depend on it [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Form of the answer on stdout
    #[arg(long, global = true, value_enum, default_value_t = OutputFormat::Text)]
    pub format: OutputFormat,
    /// Change a limit on input, for example text_bytes=512MiB; latchgate limits lists them
    #[arg(long, global = true, value_name = "KEY=VALUE", value_parser = parse_limit)]
    pub limit: Vec<String>,
}

impl Common {
    /// Returns the limits on input, with those that `--limit` changes.
    ///
    /// # Errors
    ///
    /// As [`Limits::set`].
    pub fn limits(&self) -> Result<Limits, Error> {
        let mut limits = Limits::default();
        for assignment in &self.limit {
            limits.set(assignment)?;
        }
        Ok(limits)
    }

    /// Returns the number of threads to use.
    #[must_use]
    pub fn thread_count(&self) -> usize {
        self.threads.map_or_else(
            || std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            usize::from,
        )
    }
}

/// Form of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OutputFormat {
    /// For people.
    Text,
    /// One JSON document.
    Json,
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
pub struct Log {
    /// Form.
    pub format: LogFormat,
    /// Least severe level shown.
    pub level: LevelFilter,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Replay one recording: verdict and report
    Replay(Box<ReplayArguments>),
    /// List channels, rates, units, peaks and findings; judges nothing
    Inspect(InspectArguments),
    /// How far the verdict is from changing, and what design would change it
    ///
    /// Each quantity is varied alone over a range that the answer states: scale of the recording,
    /// preload, unbalance, counterweight, restitution. With --members 0 the numbers are those of
    /// the nominal run's peak, else those of the verdict. Exit codes: 0 answered, 2 wrong usage,
    /// 4 could not answer, or a blocking finding spoils the recording.
    Margin(Box<MarginArguments>),
    /// Make the run inside a verdict again and compare
    ///
    /// What was asked, the design and the file's name stand in the verdict. Every key but the time
    /// it took is compared, every number to its last digit. Exit codes: 0 same, 1 different, 4
    /// could not.
    Verify(VerifyArguments),
    /// What the methods cost and how far they are off, and where each of them fails
    Study(StudyArguments),
    /// List every limit on input, with its value and how to change it
    Limits,
    /// Print completions for a shell
    Completions(CompletionsArguments),
    /// Print the manual page of latchgate or of one of its commands
    Man(ManArguments),
}

/// How a recording is read.
#[derive(Debug, Clone, Args)]
pub struct ReadArguments {
    /// Recording to read; - for standard input
    #[arg(value_name = "RECORDING")]
    pub recording: PathBuf,
    /// Format of the recording, if it shall not be detected [possible values: csv, ev5, iso-mme, lvm, mcap]
    #[arg(long, value_name = "FORMAT")]
    pub input_format: Option<String>,
    /// Column name or 1-based number, or MCAP topic:field.path [default: the one lateral acceleration]
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// Column name or 1-based number of the time [default: found]
    #[arg(long, value_name = "NAME", conflicts_with = "rate_hz")]
    pub time_column: Option<String>,
    /// Unit of the time column [default: as the file states, else s]
    #[arg(long, value_name = "s|ms|us", value_parser = parse_time_unit)]
    pub time_unit: Option<TimeUnit>,
    /// Sample rate where the file holds no time [Hz]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_negative_numbers = true)]
    pub rate_hz: Option<f64>,
    /// Instant of first contact on the file's clock [s] [default: 0 of that clock; MCAP: the first sample]
    #[arg(long, value_name = "S", value_parser = parse_finite, allow_negative_numbers = true)]
    pub time_zero: Option<f64>,
    /// Unit of acceleration [default: as header, units row, card or format states]
    #[arg(long, value_name = "g|m/s2|mm/s2|mm/ms2|ft/s2", value_parser = parse_unit)]
    pub unit: Option<AccelerationUnit>,
}

/// Options of `replay`.
#[derive(Debug, Clone, Args)]
pub struct ReplayArguments {
    /// How the recording is read.
    #[command(flatten)]
    pub read: ReadArguments,
    /// Sign of the recorded acceleration that opens the lever; both: judge each, the worse counts
    /// [default: the card; else both are judged and must agree]
    #[arg(long, value_name = "negative|positive|both", value_parser = parse_polarity)]
    pub opens_when: Option<CardPolarity>,
    /// Window whose mean is removed, START..END in s, or none [default: all samples at t <= -1 ms
    /// if they span at least 5 ms]
    #[arg(long, value_name = "START..END|none", value_parser = parse_bias, allow_hyphen_values = true)]
    pub bias: Option<BiasWindow>,
    /// Channel frequency class [default: cfc1000 where the rate is at least 10 kHz, else none]
    #[arg(long, value_name = "none|cfc60|cfc180|cfc600|cfc1000", value_parser = parse_filter)]
    pub filter: Option<FilterChoice>,
    /// Filter constant and end treatment
    #[arg(long, value_name = "iso6487|saej211", value_parser = parse_standard, default_value = "iso6487")]
    pub filter_standard: FilterStandard,
    /// Rate fed to the model [Hz], or native
    #[arg(long, value_name = "HZ|native", value_parser = parse_resample, default_value = "native", allow_negative_numbers = true)]
    pub resample: Resample,
    /// Judge only crossings inside START..END in s; the whole record drives the lever
    #[arg(long, value_name = "START..END", value_parser = parse_window, allow_hyphen_values = true)]
    pub window: Option<Window>,
    /// Design file (TOML) [default: the paper's lever]
    #[arg(long, value_name = "FILE")]
    pub design: Option<PathBuf>,
    /// Override of one design key, for example lever.preload_torque_nm=2.82
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Stop model; auto: the answer both give, undecided where they differ
    #[arg(long, value_enum, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// Integrator; all but event-driven are there to be compared with
    #[arg(long, value_enum, default_value_t = MethodArgument::EventDriven)]
    pub method: MethodArgument,
    /// Steps of the fixed-step methods per natural period of the lever
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = 10_000, allow_negative_numbers = true)]
    pub steps_per_period: u32,
    /// Error that event-driven and dopri5 let pass in a step [rad] [default: 1e-17; dopri5: 1e-9,
    /// absolute and relative, 1e-14 at least]
    #[arg(long, value_name = "RAD", value_parser = parse_tolerance, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Largest ensemble of levers scattered as design and input are uncertain; it ends earlier
    /// where fewer decide; 0: the nominal runs alone
    #[arg(long, value_name = "N", default_value_t = MEMBERS_DEFAULT, value_parser = clap::value_parser!(u32).range(..=i64::from(MEMBERS_MAX)), allow_negative_numbers = true)]
    pub members: u32,
    /// Seed of the ensemble
    #[arg(long, value_name = "N", default_value_t = SEED_DEFAULT, allow_negative_numbers = true)]
    pub seed: u64,
    /// Initial angle [rad] [default: at rest on the stop]
    #[arg(long, value_name = "RAD", value_parser = parse_angle, allow_negative_numbers = true)]
    pub phi0: Option<f64>,
    /// Initial angular velocity [rad/s] [default: at rest]
    #[arg(long, value_name = "RAD_S", value_parser = parse_velocity, allow_negative_numbers = true)]
    pub omega0: Option<f64>,
    /// Folder of the report [default: reports/out/RECORDING-DESIGN]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write no report
    #[arg(long, conflicts_with = "out")]
    pub no_report: bool,
}

/// Options of `margin`.
#[derive(Debug, Clone, Args)]
pub struct MarginArguments {
    /// What is replayed.
    #[command(flatten)]
    pub replay: ReplayArguments,
    /// Distance of the counterweight from the pivot, on its far side [m]
    #[arg(long, value_name = "M", value_parser = parse_positive, default_value_t = 0.03, allow_negative_numbers = true)]
    pub counterweight_radius: f64,
    /// Values of each quantity that the search begins with [default: 200 to 1200, fewer the longer
    /// the recording]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(50..=20_000), allow_negative_numbers = true)]
    pub points: Option<u32>,
    /// Map of the peak angle over two design keys, with the boundary of the pass, for example
    /// --map lever.preload_torque_nm=0.1..3 lever.mass_kg=0.05..0.2
    #[arg(long, num_args = 2, value_names = ["KEY=LO..HI", "KEY=LO..HI"], value_parser = parse_axis)]
    pub map: Option<Vec<MapAxis>>,
    /// Values of the map's keys, the first key's times the second's
    #[arg(long, value_name = "NxM", value_parser = parse_grid, default_value = "61x61", requires = "map")]
    pub map_grid: Grid,
}

/// Values to the right and upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// To the right.
    pub columns: usize,
    /// Upwards.
    pub rows: usize,
}

/// Options of `verify`.
#[derive(Debug, Clone, Args)]
pub struct VerifyArguments {
    /// Verdict to verify: a verdict.json of latchgate replay, or its output with --format json
    #[arg(value_name = "VERDICT.json")]
    pub verdict: PathBuf,
    /// The recording, under whatever name [default: that of the verdict's name, beside the verdict
    /// or in the current folder]
    #[arg(long, value_name = "FILE")]
    pub recording: Option<PathBuf>,
}

/// Options of `inspect`.
#[derive(Debug, Clone, Args)]
pub struct InspectArguments {
    /// How the recording is read.
    #[command(flatten)]
    pub read: ReadArguments,
}

/// Options of `study`.
#[derive(Debug, Clone, Args)]
pub struct StudyArguments {
    /// The study.
    #[command(subcommand)]
    pub study: super::study::Study,
}

/// The lever of a study, and where its files go.
#[derive(Debug, Clone, Args)]
pub struct StudyCommon {
    /// Folder of the study's files [default: reports/out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Design file (TOML) [default: the paper's lever]
    #[arg(long, value_name = "FILE")]
    pub design: Option<PathBuf>,
    /// Override of one design key, for example lever.preload_torque_nm=2.82
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Options of `completions`.
#[derive(Debug, Clone, Args)]
pub struct CompletionsArguments {
    /// Shell to complete for
    pub shell: clap_complete::Shell,
}

/// Options of `man`.
#[derive(Debug, Clone, Args)]
pub struct ManArguments {
    /// Command whose page to print [default: the page of latchgate itself]
    pub command: Option<String>,
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
    /// Returns the stops that a study runs; `auto` are both.
    #[must_use]
    pub fn stops(self) -> Vec<StopModel> {
        match self {
            Self::Auto => vec![StopModel::Rigid, StopModel::Soft],
            Self::Rigid => vec![StopModel::Rigid],
            Self::Soft => vec![StopModel::Soft],
        }
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
    #[must_use]
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
    #[must_use]
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

/// An interval of time [s].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Its start [s].
    pub start_s: f64,
    /// Its end [s].
    pub end_s: f64,
}

fn parse_log(text: &str) -> Result<Log, String> {
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
    Ok(Log { format, level })
}

fn parse_limit(text: &str) -> Result<String, String> {
    Limits::default()
        .set(text)
        .map(|()| text.to_string())
        .map_err(|error| error.to_string())
}

pub(super) fn parse_number(text: &str) -> Result<f64, String> {
    text.trim()
        .parse::<f64>()
        .map_err(|_| format!("`{text}` is not a number"))
}

pub(super) fn parse_finite(text: &str) -> Result<f64, String> {
    parse_number(text).and_then(|value| {
        if value.is_finite() {
            Ok(value)
        } else {
            Err("must be finite".into())
        }
    })
}

pub(super) fn parse_positive(text: &str) -> Result<f64, String> {
    parse_finite(text).and_then(|value| {
        if value > 0.0 {
            Ok(value)
        } else {
            Err("must be positive".into())
        }
    })
}

/// Refuses what [`crate::replay::run`] would refuse on either stop.
fn parse_within(text: &str, most: f64, unit: &str) -> Result<f64, String> {
    parse_finite(text).and_then(|value| {
        if value.abs() <= most {
            Ok(value)
        } else {
            Err(format!("must be at most {most} {unit} in magnitude"))
        }
    })
}

pub(super) fn parse_angle(text: &str) -> Result<f64, String> {
    parse_within(text, 100.0, "rad")
}

pub(super) fn parse_velocity(text: &str) -> Result<f64, String> {
    parse_within(text, 1e5, "rad/s")
}

fn parse_tolerance(text: &str) -> Result<f64, String> {
    parse_positive(text).and_then(|value| {
        if (1e-20..=1e-2).contains(&value) {
            Ok(value)
        } else {
            Err("must lie between 1e-20 and 1e-2 rad".into())
        }
    })
}

fn parse_unit(text: &str) -> Result<AccelerationUnit, String> {
    AccelerationUnit::from_spelling(text)
        .ok_or_else(|| "expected g, m/s2, mm/s2, mm/ms2 or ft/s2".into())
}

fn parse_time_unit(text: &str) -> Result<TimeUnit, String> {
    TimeUnit::from_spelling(text).ok_or_else(|| "expected s, ms or us".into())
}

fn parse_polarity(text: &str) -> Result<CardPolarity, String> {
    CardPolarity::from_name(text).ok_or_else(|| "expected negative, positive or both".into())
}

fn parse_filter(text: &str) -> Result<FilterChoice, String> {
    if text == "none" {
        return Ok(FilterChoice::None);
    }
    Cfc::ALL
        .into_iter()
        .find(|cfc| cfc.name() == text)
        .map(FilterChoice::Class)
        .ok_or_else(|| "expected none, cfc60, cfc180, cfc600 or cfc1000".into())
}

fn parse_standard(text: &str) -> Result<FilterStandard, String> {
    [FilterStandard::Iso6487, FilterStandard::SaeJ211]
        .into_iter()
        .find(|standard| standard.name() == text)
        .ok_or_else(|| "expected iso6487 or saej211".into())
}

fn parse_axis(text: &str) -> Result<MapAxis, String> {
    let parts = text.split_once('=').and_then(|(key, range)| {
        let (low, high) = range.split_once("..")?;
        Some((key.trim(), low, high))
    });
    let Some((key, low, high)) = parts else {
        return Err("expected KEY=LO..HI, for example lever.preload_torque_nm=0.1..3".into());
    };
    Ok(MapAxis {
        key: key.to_string(),
        low: parse_finite(low)?,
        high: parse_finite(high)?,
    })
}

fn parse_grid(text: &str) -> Result<Grid, String> {
    let counts = text
        .split_once('x')
        .and_then(|(columns, rows)| Some((columns.parse().ok()?, rows.parse().ok()?)));
    match counts {
        Some((columns, rows))
            if (2..=GRID_MAX).contains(&columns) && (2..=GRID_MAX).contains(&rows) =>
        {
            Ok(Grid { columns, rows })
        }
        _ => Err(format!(
            "expected NxM, each 2 to {GRID_MAX}, for example 61x61"
        )),
    }
}

fn parse_resample(text: &str) -> Result<Resample, String> {
    if text == "native" {
        return Ok(Resample::Native);
    }
    let hertz = parse_positive(text)?;
    if hertz < LEAST_RATE_HZ {
        return Err(format!(
            "must be at least {LEAST_RATE_HZ} Hz, the least rate that is judged"
        ));
    }
    Ok(Resample::Hertz(hertz))
}

fn parse_window(text: &str) -> Result<Window, String> {
    let (start, end) = text
        .split_once("..")
        .ok_or("expected START..END in seconds, for example -0.02..0.3")?;
    let (start_s, end_s) = (parse_finite(start)?, parse_finite(end)?);
    if start_s < end_s {
        Ok(Window { start_s, end_s })
    } else {
        Err("START must lie before END".into())
    }
}

fn parse_bias(text: &str) -> Result<BiasWindow, String> {
    if text == "none" {
        return Ok(BiasWindow::None);
    }
    parse_window(text).map(|window| BiasWindow::Window(window.start_s, window.end_s))
}
