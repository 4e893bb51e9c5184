//! `latchgate static`: static thresholds by direction, with the clause that each answers.

use super::failure::Failure;
use super::options::Common;
use super::output;
use super::values::OutputFormat;
use crate::pipeline::read_within;
use clap::Args;
use latchgate_document::design_file::{apply_override, static_from_bytes};
use latchgate_document::static_document::StaticDocument;
use latchgate_kernel::model::Design;
use latchgate_recording::error::{Error, Place};
use latchgate_recording::source::sha256;
use latchgate_verdict::statics::StaticLever;
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
    /// Folder of the page [default: reports/out/static-DESIGN]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write no page
    #[arg(long)]
    pub no_report: bool,
}

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &StaticArguments, common: &Common) -> Result<u8, Failure> {
    let (lever, sha256) = lever(arguments, common)?;
    let document = StaticDocument::of(&lever, sha256, crate::pipeline::run_block());
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

/// Returns the lever, and the SHA-256 of its file.
fn lever(
    arguments: &StaticArguments,
    common: &Common,
) -> Result<(StaticLever, Option<String>), Failure> {
    let in_option = |error: Error| Failure::Usage(error.at(Place::file("--set")));
    let Some(path) = &arguments.design else {
        let mut design = Design::reference();
        for assignment in &arguments.set {
            apply_override(&mut design, assignment).map_err(in_option)?;
        }
        design
            .validate()
            .map_err(|error| Failure::Usage(error.into()))?;
        return Ok((StaticLever::from(&design), None));
    };
    let limits = common.limits().map_err(Failure::Usage)?;
    let file = path
        .file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let limit = ("settings_bytes", limits.settings_bytes);
    let bytes = read_within(path, &file, "read the design file", limit).map_err(Failure::Data)?;
    let lever = static_from_bytes(&file, &bytes, &arguments.set, &limits).map_err(Failure::Data)?;
    Ok((lever, Some(sha256(&bytes))))
}
