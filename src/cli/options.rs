//! Options that commands share, and what they ask as data.

use super::values::{
    ColorArgument, LogSettings, MethodArgument, ModelArgument, OutputFormat, Resample, ValueWords,
    parse_limit, parse_log, parse_name, parse_resample, words_shown,
};
use clap::Args;
use latchgate_document::request::{
    MEMBERS_DEFAULT, MarginRequest, Request, SEED_DEFAULT, STEPS_PER_PERIOD_DEFAULT, Word as _,
    parse_bias, parse_count, parse_finite, parse_phi0, parse_positive, parse_sensitivity,
    parse_time_unit, parse_tolerance, parse_velocity, parse_window,
};
use latchgate_kernel::range::Window;
use latchgate_kernel::units::{
    AccelerationUnit, DecimalMark, MessageClock, SensorSensitivity, TimeUnit,
};
use latchgate_recording::card::{AcceptedWord, CardPolarity};
use latchgate_recording::error::Error;
use latchgate_recording::setting::Setting;
use latchgate_recording::{Limits, Source, TransferRange};
use latchgate_verdict::conditioning::{Between, BiasWindow, FilterChoice, FilterStandard};
use latchgate_verdict::ensemble::MEMBERS_MAX;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Returns what reads a whole number within bounds, which may be written as `1e4`.
fn count(least: u32, most: u32) -> impl Fn(&str) -> Result<u32, String> + Clone {
    move |text| {
        let count = u32::try_from(parse_count(text)?).ok();
        let within = count.filter(|count| (least..=most).contains(count));
        within.ok_or_else(|| format!("{text} is not in {least}..={most}"))
    }
}

/// Options of every command.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Global")]
pub struct Common {
    /// Show how the answer was found, and log more to stderr: -v info, -vv debug, -vvv trace
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    /// Log to stderr as [text|json][:LEVEL], LEVEL one of error, warn, info, debug, trace
    #[arg(long, global = true, value_name = "FORMAT[:LEVEL]", value_parser = parse_log)]
    pub log: Option<LogSettings>,
    /// Threads to use; the numbers do not depend on it [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), allow_hyphen_values = true)]
    pub threads: Option<u16>,
    /// Format of the answer on stdout
    #[arg(long, global = true, value_enum, ignore_case = true, default_value_t = OutputFormat::Text)]
    pub format: OutputFormat,
    /// When the answer is coloured
    #[arg(long, global = true, value_enum, ignore_case = true, value_name = "WHEN", default_value_t = ColorArgument::Auto)]
    pub color: ColorArgument,
    /// Change a limit on input, for example text_bytes=512MiB; latchgate limits lists them
    #[arg(long, global = true, value_name = "KEY=VALUE", value_parser = parse_limit)]
    pub limit: Vec<String>,
}

impl Common {
    /// Returns the limits on input that `--limit` changes, by name.
    ///
    /// # Errors
    ///
    /// As [`Limits::set`].
    pub fn changed_limits(&self) -> Result<BTreeMap<String, u64>, Error> {
        self.limits().map(|limits| limits.changed())
    }

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
    pub fn thread_count(&self) -> usize {
        self.threads.map_or_else(
            || std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            usize::from,
        )
    }
}

/// How a recording is read.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Input")]
pub struct ReadArguments {
    /// Recording to read; - for standard input
    #[arg(value_name = "RECORDING")]
    pub recording: PathBuf,
    /// Format of the recording [default: detected]
    #[arg(long, value_name = "FORMAT", value_parser = ValueWords::of(Setting::InputFormat, |text| Ok(text.to_string())))]
    pub input_format: Option<String>,
    /// Column name, 1-based number or MCAP topic:field.path [default: the one lateral acceleration]
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    pub channel: Option<String>,
    /// Column name or 1-based number of the time [default: found]
    #[arg(
        long,
        value_name = "NAME",
        conflicts_with = "rate_hz",
        allow_hyphen_values = true
    )]
    pub time_column: Option<String>,
    /// Unit of the time column: s, ms, us, ns, min, h, day, or 10us [default: the file's, else s]
    #[arg(long, value_name = "UNIT", hide_possible_values = true, value_parser = ValueWords::of(Setting::TimeUnit, parse_time_unit))]
    pub time_unit: Option<TimeUnit>,
    /// Clock of a log's messages [default: header if the messages have stamps, else log]
    #[arg(long, value_name = words_shown(Setting::TimeSource), hide_possible_values = true, value_parser = ValueWords::of(Setting::TimeSource, MessageClock::from_word))]
    pub time_source: Option<MessageClock>,
    /// Sheet of a workbook [default: the one that holds something]
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    pub sheet: Option<String>,
    /// Line of a text table that names its columns [default: found]
    #[arg(long, value_name = "N", value_parser = count(1, u32::MAX), conflicts_with = "skip_lines", allow_hyphen_values = true)]
    pub header_line: Option<u32>,
    /// Line of a text table that holds the units of its columns [default: found]
    #[arg(long, value_name = "N", value_parser = count(1, u32::MAX), allow_hyphen_values = true)]
    pub unit_line: Option<u32>,
    /// Last line of a text table [default: the file's last line]
    #[arg(long, value_name = "N", value_parser = count(1, u32::MAX), allow_hyphen_values = true)]
    pub last_line: Option<u32>,
    /// Lines to skip at the start of a text table [default: found]
    #[arg(long, value_name = "N", value_parser = count(0, u32::MAX), allow_hyphen_values = true)]
    pub skip_lines: Option<u32>,
    /// Decimal mark of a text table; the other may separate thousands [default: found]
    #[arg(long, value_name = words_shown(Setting::Decimal), hide_possible_values = true, value_parser = ValueWords::of(Setting::Decimal, DecimalMark::from_word))]
    pub decimal: Option<DecimalMark>,
    /// Sample rate where the file holds no time or no unit of time [Hz]
    #[arg(long, value_name = "HZ", value_parser = parse_positive, allow_hyphen_values = true)]
    pub rate_hz: Option<f64>,
    /// First contact on the file's clock [s] [default: 0; MCAP: the first sample]
    #[arg(long, value_name = "S", value_parser = parse_finite, allow_hyphen_values = true)]
    pub time_zero: Option<f64>,
    /// Unit of acceleration [default: that of header, units row, card or format]
    #[arg(long, value_name = words_shown(Setting::Unit), hide_possible_values = true, value_parser = ValueWords::of(Setting::Unit, AccelerationUnit::from_word))]
    pub unit: Option<AccelerationUnit>,
    /// Sensitivity where samples are volts, counts or the like: '20 g/V' or '10 mV/g'
    #[arg(long, value_name = "NUMBER UNIT/UNIT", value_parser = parse_sensitivity, conflicts_with = "unit")]
    pub sensitivity: Option<SensorSensitivity>,
    /// Accept a remark by its text as shown, so that it does not block; may be repeated
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    pub accept_remark: Vec<String>,
}

/// Returns the source: `-` is standard input, `pulse:…` a pulse, anything else a path.
pub(super) fn source_of(recording: &Path) -> Result<Source, Error> {
    if recording == Path::new("-") {
        Ok(Source::Stdin)
    } else {
        latchgate_recording::pulse::source_at(recording)
    }
}

/// True of the word of a pulse.
pub(super) fn is_pulse(recording: &Path) -> bool {
    recording
        .to_string_lossy()
        .starts_with(latchgate_recording::pulse::PREFIX)
}

impl ReadArguments {
    /// Returns the source: `-` is standard input, anything else a path.
    ///
    /// # Errors
    ///
    /// As [`latchgate_recording::pulse::source_at`].
    pub(super) fn source(&self) -> Result<Source, Error> {
        source_of(&self.recording)
    }

    /// Returns how the recording is read, as a question of which the rest has its defaults.
    ///
    /// # Errors
    ///
    /// As [`Common::changed_limits`].
    pub fn request(&self, common: &Common) -> Result<Request, Error> {
        Ok(Request {
            input_format: self.input_format.clone(),
            channel: self.channel.clone(),
            time_column: self.time_column.clone(),
            time_unit: self.time_unit,
            time_source: self.time_source,
            sheet: self.sheet.clone(),
            header_line: self.header_line,
            unit_line: self.unit_line,
            last_line: self.last_line,
            skip_lines: self.skip_lines,
            decimal: self.decimal,
            rate_hz: self.rate_hz,
            time_zero: self.time_zero,
            unit: self.unit,
            sensitivity: self.sensitivity.clone(),
            accepted_remarks: {
                // Their order asks nothing else.
                let texts = self.accept_remark.iter().map(String::as_str);
                let texts: BTreeSet<&str> = texts.collect();
                texts.into_iter().map(String::from).collect()
            },
            limits: common.changed_limits()?,
            ..Request::default()
        })
    }
}

/// Options of `replay`.
#[derive(Debug, Clone, Args)]
pub struct ReplayArguments {
    /// How the recording is read.
    #[command(flatten)]
    pub read: ReadArguments,
    /// Second in-plane channel, for a design with an axis [default: none]
    #[arg(
        help_heading = "Signal",
        long,
        value_name = "NAME",
        allow_hyphen_values = true
    )]
    pub radial_channel: Option<String>,
    /// Velocity change of the sensor's place, from another source [m/s] [default: the card]
    #[arg(help_heading = "Signal", long, value_name = "M/S", value_parser = parse_positive, allow_hyphen_values = true)]
    pub velocity_change: Option<f64>,
    /// Confirm a doubt: clock (sample rate and length), axis (of a channel that is not lateral), noise (no more than the recorder's step), processed (samples unlike a raw recording's)
    #[arg(help_heading = "Signal", long, value_name = "WORD", value_delimiter = ',', value_parser = ValueWords::of(Setting::Accept, AcceptedWord::from_word))]
    pub accept: Vec<AcceptedWord>,
    /// Factor from the sensor's place to the latch; each is judged, the worst counts [default: the card; 1 at door or latch]
    #[arg(help_heading = "Signal", long, value_name = "LO..HI", value_parser = TransferRange::from_text, allow_hyphen_values = true)]
    pub transfer: Option<TransferRange>,
    /// Judge every lateral channel of that side in the file; the worst counts
    #[arg(help_heading = "Signal", long, conflicts_with = "radial_channel")]
    pub siblings: bool,
    /// Check the recording as a sled pulse of 49 CFR 571.206 and UN R11
    #[arg(help_heading = "Signal", long)]
    pub sled206: bool,
    /// Opening direction; both: the worse counts [default: the card, else both must agree]
    #[arg(help_heading = "Signal", long, value_name = words_shown(Setting::OpensWhen), hide_possible_values = true, value_parser = ValueWords::of(Setting::OpensWhen, CardPolarity::from_word))]
    pub opens_when: Option<CardPolarity>,
    /// Window in s whose mean is removed [default: t <= -1 ms if that spans at least 5 ms]
    #[arg(help_heading = "Signal", long, value_name = "START..END|none", hide_possible_values = true, value_parser = ValueWords::of(Setting::Bias, parse_bias), allow_hyphen_values = true)]
    pub bias: Option<BiasWindow>,
    /// Channel frequency class [default: cfc1000 from 10 kHz on, else none]
    #[arg(help_heading = "Signal", long, value_name = words_shown(Setting::Filter), hide_possible_values = true, value_parser = ValueWords::of(Setting::Filter, FilterChoice::from_word))]
    pub filter: Option<FilterChoice>,
    /// Filter constant and end treatment
    #[arg(help_heading = "Signal", long, value_name = words_shown(Setting::FilterStandard), hide_possible_values = true, value_parser = ValueWords::of(Setting::FilterStandard, FilterStandard::from_word), default_value = "iso6487")]
    pub filter_standard: FilterStandard,
    /// How the acceleration runs between samples; linear suits pulses with corners
    #[arg(help_heading = "Signal", long, value_name = words_shown(Setting::Between), hide_possible_values = true, value_parser = ValueWords::of(Setting::Between, Between::from_word), default_value = "band-limited")]
    pub between: Between,
    /// Rate fed to the model [Hz], or native
    #[arg(help_heading = "Signal", long, value_name = "HZ|native", hide_possible_values = true, value_parser = ValueWords::of(Setting::Resample, parse_resample), default_value = "native", allow_hyphen_values = true)]
    pub resample: Resample,
    /// Judge crossings in START..END only [s]; the whole record drives the lever
    #[arg(help_heading = "Signal", long, value_name = "START..END", value_parser = parse_window, allow_hyphen_values = true)]
    pub window: Option<Window>,
    /// Design file (TOML) [default: the paper's lever]
    #[arg(help_heading = "Design", long, value_name = "FILE")]
    pub design: Option<PathBuf>,
    /// Override one design key, for example lever.preload_torque_nm=2.82
    #[arg(help_heading = "Design", long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Stop model; auto: both must agree, else undecided
    #[arg(help_heading = "Design", long, value_enum, ignore_case = true, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// Integrator; all but event-driven are for comparison
    #[arg(help_heading = "Decision", long, value_enum, ignore_case = true, default_value_t = MethodArgument::EventDriven)]
    pub method: MethodArgument,
    /// Steps per natural period of the fixed-step methods
    #[arg(help_heading = "Decision", long, value_name = "N", value_parser = count(1, u32::MAX), default_value_t = STEPS_PER_PERIOD_DEFAULT, allow_hyphen_values = true)]
    pub steps_per_period: u32,
    /// Error per step of event-driven and dopri5 [rad] [default: 1e-17; dopri5: 1e-9]
    #[arg(help_heading = "Decision", long, value_name = "RAD", value_parser = parse_tolerance, allow_hyphen_values = true)]
    pub tolerance: Option<f64>,
    /// Largest number of varied levers; fewer if they decide; 0: the nominal lever alone
    #[arg(help_heading = "Decision", long, value_name = "N", default_value_t = MEMBERS_DEFAULT, value_parser = count(0, MEMBERS_MAX), allow_hyphen_values = true)]
    pub members: u32,
    /// Seed of the varied levers
    #[arg(help_heading = "Decision", long, value_name = "N", default_value_t = SEED_DEFAULT, value_parser = parse_count, allow_hyphen_values = true)]
    pub seed: u64,
    /// Initial angle [rad] [default: at rest on the stop]
    #[arg(help_heading = "Decision", long, value_name = "RAD", value_parser = parse_phi0, allow_hyphen_values = true)]
    pub phi0: Option<f64>,
    /// Initial angular velocity [rad/s] [default: at rest]
    #[arg(help_heading = "Decision", long, value_name = "RAD_S", value_parser = parse_velocity, allow_hyphen_values = true)]
    pub omega0: Option<f64>,
    /// Folder of the report [default: reports/out/RECORDING-DESIGN-ID]
    #[arg(help_heading = "Output", long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write no report
    #[arg(help_heading = "Output", long, conflicts_with = "out")]
    pub no_report: bool,
}

impl ReplayArguments {
    /// Returns the question that the options ask.
    ///
    /// # Errors
    ///
    /// As [`Common::changed_limits`].
    pub fn request(&self, common: &Common) -> Result<Request, Error> {
        Ok(Request {
            radial_channel: self.radial_channel.clone(),
            velocity_change_m_s: self.velocity_change,
            accepted: {
                let words: BTreeSet<AcceptedWord> = self.accept.iter().copied().collect();
                words.into_iter().collect()
            },
            transfer: self.transfer,
            siblings: self.siblings,
            sled206: self.sled206,
            opens_when: self.opens_when,
            bias: self.bias.unwrap_or(BiasWindow::PreEvent),
            filter: self.filter.unwrap_or(FilterChoice::Default),
            filter_standard: self.filter_standard,
            between: self.between,
            resample_hz: match self.resample {
                Resample::Native => None,
                Resample::Hertz(hertz) => Some(hertz),
            },
            window_s: self.window,
            model: self.model.choice(),
            method: self.method.method(self.steps_per_period),
            tolerance_rad: self.tolerance,
            members: self.members,
            seed: self.seed,
            phi0_rad: self.phi0,
            omega0_rad_s: self.omega0,
            ..self.read.request(common)?
        })
    }
}

/// Recordings to replay, and how.
#[derive(Debug, Clone, Args)]
pub struct ReplayCommand {
    /// What is replayed.
    #[command(flatten)]
    pub replay: ReplayArguments,
    /// More recordings; each is judged alone, and a table is printed
    #[arg(value_name = "RECORDING")]
    pub further: Vec<PathBuf>,
    /// Write time, acceleration, velocity and each run's angle to this file, as CSV
    #[arg(
        help_heading = "Output",
        long,
        value_name = "FILE",
        conflicts_with = "further"
    )]
    pub series: Option<PathBuf>,
    /// Leave out the search for the preload that would pass, which takes longer than the verdict
    #[arg(help_heading = "Output", long)]
    pub no_advice: bool,
    /// Who made the report, for its last page
    #[arg(help_heading = "Output", long, value_name = "NAME", value_parser = parse_name)]
    pub by: Option<String>,
    /// Open the report
    #[arg(help_heading = "Output", long, conflicts_with = "no_report")]
    pub open: bool,
    /// Write report.pdf too, with an installed Chromium or Chrome
    #[arg(help_heading = "Output", long, conflicts_with = "no_report")]
    pub pdf: bool,
}

/// Options of `margin`.
#[derive(Debug, Clone, Args)]
pub struct MarginArguments {
    /// What is replayed.
    #[command(flatten)]
    pub replay: ReplayArguments,
    /// Distance of the counterweight from the pivot, opposite the lever's centre of mass [m]
    #[arg(long, value_name = "M", value_parser = parse_positive, default_value_t = 0.03, allow_hyphen_values = true)]
    pub counterweight_radius: f64,
}

impl MarginArguments {
    /// Returns the question that the options ask.
    ///
    /// # Errors
    ///
    /// As [`Common::changed_limits`].
    pub fn request(&self, common: &Common) -> Result<MarginRequest, Error> {
        Ok(MarginRequest {
            replay: self.replay.request(common)?,
            counterweight_radius_m: self.counterweight_radius,
        })
    }
}

/// Options of `verify`.
#[derive(Debug, Clone, Args)]
pub struct VerifyArguments {
    /// Verdict to verify: a verdict.json of latchgate replay, or its output with --format json
    #[arg(value_name = "VERDICT.json")]
    pub verdict: PathBuf,
    /// The recording [default: by its name in the verdict, beside it or in the current folder]
    #[arg(long, value_name = "FILE", allow_hyphen_values = true)]
    pub recording: Option<PathBuf>,
}

/// Options of `compare`.
#[derive(Debug, Clone, Args)]
pub struct CompareArguments {
    /// Two to eight verdict.json of latchgate replay
    #[arg(value_name = "VERDICT.json", required = true, num_args = 2..=8)]
    pub verdicts: Vec<PathBuf>,
    /// Folder of the page [default: reports/out/compare-A-B, with the report ids]
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: Option<PathBuf>,
    /// Write no page
    #[arg(long, help_heading = "Output")]
    pub no_report: bool,
}

/// Options of `inspect`.
#[derive(Debug, Clone, Args)]
pub struct InspectArguments {
    /// How the recording is read.
    #[command(flatten)]
    pub read: ReadArguments,
    /// Check the channel as a sled pulse of 49 CFR 571.206 and UN R11
    #[arg(long)]
    pub sled206: bool,
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
    /// Override one design key, for example lever.preload_torque_nm=2.82
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}
