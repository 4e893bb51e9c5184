//! `latchgate static`: static thresholds by direction, with the clause that each answers.

use super::failure::Failure;
use super::options::Common;
use super::output;
use super::progress::Progress;
use super::values::OutputFormat;
use crate::pipeline::{self, read_within};
use clap::Args;
use latchgate_document::design_document::DesignDocument;
use latchgate_document::design_file::{StaticDesign, apply_override, static_from_bytes};
use latchgate_kernel::error::Error as OutOfRange;
use latchgate_kernel::model::Design;
use latchgate_recording::error::{Error, Place};
use latchgate_recording::source::sha256;
use latchgate_verdict::statics::{Door, SPRING_DEVIATIONS, Standard, StaticLever, StaticQuestion};
use std::path::{Path, PathBuf};

/// Options of `static`.
#[derive(Debug, Clone, Args)]
pub struct StaticArguments {
    /// Design file [default: the paper's lever]
    #[arg(value_name = "DESIGN")]
    pub design: Option<PathBuf>,
    /// Override one design key, for example lever.preload_torque_nm=2.82
    #[arg(long, value_name = "KEY=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,
    /// One standard asked about [default: all]
    #[arg(long, value_name = "206|r11|j839", value_parser = parse_standard)]
    pub standard: Option<Standard>,
    /// Door that the latch holds: which rows and clauses count
    #[arg(long, value_name = "hinged|sliding|back", default_value = "hinged", value_parser = parse_door)]
    pub door: Door,
    /// Standard deviations below its nominal output at which the spring counts
    #[arg(long, value_name = "K", default_value_t = SPRING_DEVIATIONS)]
    pub spring_deviations: f64,
    /// Least torque of the closed spring, in place of that [N m]
    #[arg(long, value_name = "T")]
    pub spring_torque_min: Option<f64>,
    /// Folder of the page [default: reports/out/static-DESIGN]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write no page
    #[arg(long)]
    pub no_report: bool,
}

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &StaticArguments, common: &Common) -> Result<u8, Failure> {
    let (design, sha256) = design(arguments, common)?;
    let question = question(arguments)?;
    let nominal = design.lever.preload_torque_nm;
    if let Some(least) = question
        .spring_torque_min_nm
        .filter(|least| *least > nominal)
    {
        let expected = format!("at most the nominal torque, {nominal}");
        let error =
            OutOfRange::out_of_range("--spring-torque-min [N m]", expected, least.to_string());
        return Err(Failure::Usage(Error::from(error)));
    }
    let progress = Progress::new("static");
    let document = progress.watch("static", common.thread_count(), |control| {
        pipeline::static_document(design, &question, sha256, control)
    });
    drop(progress);
    let document = document.map_err(Failure::of_data)?;
    let folder = (!arguments.no_report).then(|| {
        let name = latchgate_report::folder_name("static", &document.design, "");
        let default = || Path::new("reports/out").join(name);
        arguments.out.clone().unwrap_or_else(default)
    });
    if let Some(folder) = &folder {
        latchgate_report::statics::write(folder, &document).map_err(Failure::Data)?;
    }
    match common.format {
        OutputFormat::Json => output::document(&latchgate_document::json::render(&document)),
        OutputFormat::Text => output::text(&latchgate_report::statics::text(
            &document,
            folder.as_deref(),
            output::look(common),
        )),
    }
    .map_err(Failure::Data)?;
    Ok(0)
}

/// Returns what is asked.
fn question(arguments: &StaticArguments) -> Result<StaticQuestion, Failure> {
    let refuse = |what: &str, expected: &str, found: f64| {
        let error = OutOfRange::out_of_range(what, expected, found.to_string());
        Err(Failure::Usage(Error::from(error)))
    };
    let deviations = arguments.spring_deviations;
    if !(0.0..=DEVIATIONS_MAX).contains(&deviations) {
        return refuse("--spring-deviations", "from 0 to 6", deviations);
    }
    if let Some(least) = arguments.spring_torque_min
        && !(least >= 0.0 && least.is_finite())
    {
        return refuse("--spring-torque-min [N m]", "zero or positive", least);
    }
    Ok(StaticQuestion {
        standard: arguments.standard,
        door: arguments.door,
        spring_deviations: deviations,
        spring_torque_min_nm: arguments.spring_torque_min,
    })
}

/// Most standard deviations that a spring may be counted below its nominal output.
const DEVIATIONS_MAX: f64 = 6.0;

fn parse_standard(text: &str) -> Result<Standard, String> {
    let word = text.to_ascii_lowercase();
    let known = Standard::ALL.into_iter().find(|own| own.word() == word);
    known.ok_or_else(|| "one of 206, r11, j839".into())
}

fn parse_door(text: &str) -> Result<Door, String> {
    let word = text.to_ascii_lowercase();
    let known = Door::ALL.into_iter().find(|own| own.word() == word);
    known.ok_or_else(|| "one of hinged, sliding, back".into())
}

/// Returns the design, and the SHA-256 of its file.
fn design(
    arguments: &StaticArguments,
    common: &Common,
) -> Result<(StaticDesign, Option<String>), Failure> {
    let in_option = |error: Error| Failure::Usage(error.at(Place::file("--set")));
    let Some(path) = &arguments.design else {
        let mut design = Design::reference();
        for assignment in &arguments.set {
            apply_override(&mut design, assignment).map_err(in_option)?;
        }
        design
            .validate()
            .map_err(|error| Failure::Usage(error.into()))?;
        let design = StaticDesign {
            lever: StaticLever::from(&design),
            document: DesignDocument::default(),
            whole: Some(design),
        };
        return Ok((design, None));
    };
    for assignment in &arguments.set {
        // What no design takes is wrong on the command line, whatever the file holds.
        apply_override(&mut Design::reference(), assignment).map_err(in_option)?;
    }
    let limits = common.limits().map_err(Failure::Usage)?;
    let file = path
        .file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let limit = ("settings_bytes", limits.settings_bytes);
    let bytes = read_within(path, &file, "read the design file", limit).map_err(Failure::Data)?;
    let design =
        static_from_bytes(&file, &bytes, &arguments.set, &limits).map_err(Failure::Data)?;
    Ok((design, Some(sha256(&bytes))))
}
