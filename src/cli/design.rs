//! The design of a command line: a file, or the paper's, with overrides.

use super::failure::Failure;
use super::options::{Common, ReplayArguments};
use crate::pipeline::{design_from_bytes, read_within};
use latchgate_document::blocks::DesignFile;
use latchgate_document::design_file::apply_override;
use latchgate_document::request::Request;
use latchgate_kernel::model::Design;
use latchgate_recording::Limits;
use latchgate_recording::error::{Error, Place};
use latchgate_recording::source::sha256;
use std::path::Path;

/// Returns the design of the options, checked together with the request.
pub(super) fn requested_design(
    arguments: &ReplayArguments,
    request: &Request,
    common: &Common,
) -> Result<RequestedDesign, Failure> {
    request.check().map_err(Failure::Usage)?;
    let limits = common.limits().map_err(Failure::Usage)?;
    let file = arguments.design.as_deref();
    let requested = with_file(Design::reference(), file, &arguments.set, &limits)?;
    request
        .check_design(&requested.design)
        .map_err(match arguments.design {
            None => Failure::Usage,
            // The error lies in the file, not in the command line.
            Some(_) => Failure::Data,
        })?;
    Ok(requested)
}

/// A design of a command line.
pub(super) struct RequestedDesign {
    /// With the overrides.
    pub(super) design: Design,
    /// The file that it comes from.
    pub(super) file: Option<DesignFile>,
}

/// Reads the design file, if one is named, else takes the `default` one, and applies the overrides.
pub(super) fn design(
    default: Design,
    file: Option<&Path>,
    overrides: &[String],
    limits: &Limits,
) -> Result<Design, Failure> {
    with_file(default, file, overrides, limits).map(|requested| requested.design)
}

fn with_file(
    default: Design,
    file: Option<&Path>,
    overrides: &[String],
    limits: &Limits,
) -> Result<RequestedDesign, Failure> {
    let mut design = default;
    let mut design_file = None;
    // Keys of a catch are those of a file that has one.
    let is_of_catch = |key: &&String| file.is_some() && key.contains("catch.");
    let known: Vec<String> = overrides
        .iter()
        .filter(|key| !is_of_catch(key))
        .cloned()
        .collect();
    override_keys(&mut design, &known).map_err(Failure::Usage)?;
    match file {
        None => design
            .validate()
            .map_err(|error| Failure::Usage(error.into()))?,
        Some(path) => {
            let read = read(path, limits).map_err(Failure::Data)?;
            (design, design_file) = (read.design, read.file);
            override_keys(&mut design, overrides).map_err(Failure::Usage)?;
            // The error lies in the file, not in the command line.
            design
                .validate()
                .map_err(|error| Failure::Data(error.into()))?;
        }
    }
    Ok(RequestedDesign {
        design,
        file: design_file,
    })
}

fn override_keys(design: &mut Design, overrides: &[String]) -> Result<(), Error> {
    overrides
        .iter()
        .try_for_each(|assignment| apply_override(design, assignment))
        .map_err(|error| error.at(Place::file("--set")))
}

fn read(path: &Path, limits: &Limits) -> Result<RequestedDesign, Error> {
    let name = path
        .file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let limit = ("settings_bytes", limits.settings_bytes);
    let bytes = read_within(path, &name, "read the design file", limit)?;
    let design = design_from_bytes(&name, &bytes, limits)?;
    let sha256 = sha256(&bytes);
    Ok(RequestedDesign {
        design,
        file: Some(DesignFile { name, sha256 }),
    })
}
