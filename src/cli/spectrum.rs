//! `latchgate spectrum`: what any latch must have to survive the recordings.

use super::design;
use super::failure::Failure;
use super::inputs::Inputs;
use super::options::{Common, ReadArguments, source_of};
use super::output;
use super::progress::Progress;
use super::values::{OutputFormat, Resample, ValueWords, parse_range, parse_resample, words_shown};
use crate::pipeline::{self, Design};
use clap::Args;
use latchgate_document::request::{
    Request, SEED_DEFAULT, Word as _, parse_bias, parse_count, parse_positive,
};
use latchgate_document::spectrum_document::SpectrumRequest;
use latchgate_recording::card::CardPolarity;
use latchgate_recording::error::Error;
use latchgate_recording::setting::Setting;
use latchgate_recording::{Limits, Source};
use latchgate_verdict::conditioning::{BiasWindow, FilterChoice, FilterStandard};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Options of `spectrum`.
#[derive(Debug, Clone, Args)]
pub struct SpectrumArguments {
    /// How the recordings are read.
    #[command(flatten)]
    pub read: ReadArguments,
    /// More recordings; the envelope is that of all
    #[arg(value_name = "RECORDING")]
    pub further: Vec<PathBuf>,
    /// Opening direction; both: a curve each [default: the card, else both]
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
    /// Rate fed to the model [Hz], or native
    #[arg(help_heading = "Signal", long, value_name = "HZ|native", hide_possible_values = true, value_parser = ValueWords::of(Setting::Resample, parse_resample), default_value = "native", allow_hyphen_values = true)]
    pub resample: Resample,
    /// Design file (TOML) to place beside the curves; may be repeated
    #[arg(help_heading = "Levers", long, value_name = "FILE")]
    pub design: Vec<PathBuf>,
    /// Restitution of the stop: a value, or bounds between which it is drawn evenly
    #[arg(help_heading = "Levers", long, value_name = "R|LO..HI", value_parser = parse_range, default_value = "0.8", allow_hyphen_values = true)]
    pub restitution: (f64, f64),
    /// Angle beyond which the door is lost [rad]
    #[arg(help_heading = "Levers", long, value_name = "RAD", value_parser = parse_positive, default_value_t = 0.1, allow_hyphen_values = true)]
    pub limit_angle: f64,
    /// Seed of the varied levers
    #[arg(help_heading = "Levers", long, value_name = "N", default_value_t = SEED_DEFAULT, value_parser = parse_count, allow_hyphen_values = true)]
    pub seed: u64,
    /// Also the curve that covers this share of the curves, for example 0.95
    #[arg(help_heading = "Envelope", long, value_name = "SHARE", value_parser = parse_positive, allow_hyphen_values = true)]
    pub share: Option<f64>,
    /// Go on without the recordings that have no spectrum, and name them
    #[arg(help_heading = "Envelope", long)]
    pub leave_out_unusable: bool,
    /// Folder of page, charts and tables [default: reports/out/spectrum-RECORDING-ID]
    #[arg(help_heading = "Output", long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write no page
    #[arg(help_heading = "Output", long, conflicts_with = "out")]
    pub no_report: bool,
}

impl SpectrumArguments {
    fn request(&self, common: &Common) -> Result<SpectrumRequest, Error> {
        let request = SpectrumRequest {
            replay: Request {
                opens_when: self.opens_when,
                bias: self.bias.unwrap_or(BiasWindow::PreEvent),
                filter: self.filter.unwrap_or(FilterChoice::Default),
                filter_standard: self.filter_standard,
                resample_hz: match self.resample {
                    Resample::Native => None,
                    Resample::Hertz(hertz) => Some(hertz),
                },
                seed: self.seed,
                ..self.read.request(common)?
            },
            restitution: self.restitution,
            limit_angle_rad: self.limit_angle,
            share: self.share,
            leave_out_unusable: self.leave_out_unusable,
        };
        request.check()?;
        request.replay.check()?;
        Ok(request)
    }

    fn recordings(&self) -> impl Iterator<Item = &Path> {
        let first = std::iter::once(&self.read.recording);
        first.chain(&self.further).map(PathBuf::as_path)
    }
}

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &SpectrumArguments, common: &Common) -> Result<u8, Failure> {
    let started = Instant::now();
    let request = arguments.request(common).map_err(Failure::Usage)?;
    let limits = common.limits().map_err(Failure::Usage)?;
    let files = arguments.design.iter();
    let designs = files
        .map(|file| design::design(Design::reference(), Some(file), &[], &limits))
        .collect::<Result<Vec<_>, Failure>>()?;
    let sources: Vec<Source> = arguments
        .recordings()
        .map(source_of)
        .collect::<Result<_, _>>()
        .map_err(Failure::Data)?;
    if let Some(out) = &arguments.out {
        let inputs = Inputs::of_files(arguments.recordings(), &arguments.design);
        inputs.check_report_folder(out).map_err(Failure::Data)?;
    }
    let progress = Progress::new("spectrum");
    let outcome = progress.watch("spectrum", common.thread_count(), |control| {
        pipeline::spectrum(&sources, &request, &designs, &Limits::default(), control)
    });
    drop(progress);
    let mut document = outcome.map_err(Failure::of_data)?;
    document.run.elapsed_s = started.elapsed().as_secs_f64();
    let folder = (!arguments.no_report).then(|| {
        let subject = match arguments.further.len() {
            0 => sources[0].name(),
            more => format!("{}-recordings", more + 1),
        };
        let name = latchgate_report::folder_name("spectrum", &subject, &document.report_id);
        let default = || Path::new("reports/out").join(name);
        arguments.out.clone().unwrap_or_else(default)
    });
    if let Some(folder) = &folder {
        latchgate_report::spectrum::write(folder, &document).map_err(Failure::Data)?;
    }
    match common.format {
        OutputFormat::Json => output::document(&latchgate_document::json::render(&document)),
        OutputFormat::Text => output::text(&latchgate_report::spectrum::text(
            &document,
            folder.as_deref(),
            output::look(common),
        )),
    }
    .map_err(Failure::Data)?;
    Ok(0)
}
