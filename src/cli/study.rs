//! `latchgate study`: one file per study, one line each in [`Study`] and in its `analysis`.
//!
//! - `attractor`: `latchgate study attractor`;
//! - `basins`: `latchgate study basins`;
//! - `bifurcation`: `latchgate study bifurcation`;
//! - `catch`: `latchgate study catch`;
//! - `damages`: `latchgate study damages`;
//! - `excitation_map`: `latchgate study excitation-map`;
//! - `free_vibration`: `latchgate study free-vibration`;
//! - `histories`: `latchgate study histories`;
//! - `parameters`: `latchgate study parameters`;
//! - `restitution`: `latchgate study restitution`;
//! - `shock`: `latchgate study shock`;
//! - `spectrogram`: `latchgate study spectrogram`;
//! - `stability`: `latchgate study stability`;
//! - `step_size`: `latchgate study step-size`;
//! - `sweep`: options that studies share: sine, initial state, ranges, grids, lengths;
//! - `work_precision`: `latchgate study work-precision`.

mod analysis;
mod attractor;
mod basins;
mod bifurcation;
mod catch;
mod damages;
mod excitation_map;
mod free_vibration;
mod histories;
mod parameters;
mod restitution;
mod shock;
mod spectrogram;
mod stability;
mod step_size;
mod sweep;
mod work_precision;

use super::failure::{Failure, INTERRUPTED};
use super::options::{Common, StudyCommon};
use super::output;
use super::progress;
use super::values::OutputFormat;
use analysis::{Analysis, Session};
use clap::Subcommand;
use latchgate_kernel::model::Design;
use latchgate_recording::error::Error;
use latchgate_study::files::{StudyFiles, Summary};
use std::path::PathBuf;

/// The studies.
#[derive(Debug, Clone, Subcommand)]
pub enum Study {
    /// Fig. 2: damping ratio against restitution, and how far that holds
    Restitution(restitution::Arguments),
    /// Fig. 3: fixed-step Runge-Kutta on free impacts, and the limit where it fails
    StepSize(step_size::Arguments),
    /// Fig. 4: free vibration with and without impact, without and with preload
    FreeVibration(free_vibration::Arguments),
    /// Fig. 5: spectrogram of the free vibration with preload, with its rising bounce frequency
    Spectrogram(spectrogram::Arguments),
    /// Figs. 6 and 8: stroboscopic sections against amplitude, with births and period doublings
    Bifurcation(bifurcation::Arguments),
    /// Fig. 7: the section at one amplitude, with its period or largest Lyapunov exponent
    Attractor(attractor::Arguments),
    /// Fig. 9: the attractor reached from each initial state
    Basins(basins::Arguments),
    /// Beyond the paper: what amplitude and frequency open the latch
    ExcitationMap(excitation_map::Arguments),
    /// Fig. 10: where the lever ends from three starts under one sine
    Histories(histories::Arguments),
    /// Fig. 11: response to the shock of a side impact
    Shock(shock::Arguments),
    /// Section 5: peak under the shock of Fig. 11 against each number of the lever
    Parameters(parameters::Arguments),
    /// Lever and inertia catch against the gap of two pulses and the frequency of ringing
    Catch(catch::Arguments),
    /// Error against cost of each method, on a shock, a recording and a sine, on both stops
    WorkPrecision(work_precision::Arguments),
    /// Where each method fails: step against stiffness, grazing, chatter, events inside a sample
    Stability(stability::Arguments),
    /// What damage to a recording is detected, by random damages
    Damages(damages::Arguments),
}

impl Study {
    /// Returns the name, which is that of the files, the shared options, and the study itself.
    fn analysis(&self) -> (&'static str, &StudyCommon, &dyn Analysis) {
        match self {
            Self::Restitution(arguments) => ("restitution", &arguments.study, arguments),
            Self::StepSize(arguments) => ("step-size", &arguments.study, arguments),
            Self::FreeVibration(arguments) => ("free-vibration", &arguments.study, arguments),
            Self::Spectrogram(arguments) => ("spectrogram", &arguments.study, arguments),
            Self::Bifurcation(arguments) => ("bifurcation", &arguments.study, arguments),
            Self::Attractor(arguments) => ("attractor", &arguments.study, arguments),
            Self::Basins(arguments) => ("basins", &arguments.study, arguments),
            Self::ExcitationMap(arguments) => ("excitation-map", &arguments.study, arguments),
            Self::Histories(arguments) => ("histories", &arguments.study, arguments),
            Self::Shock(arguments) => ("shock", &arguments.study, arguments),
            Self::Parameters(arguments) => ("parameters", &arguments.study, arguments),
            Self::Catch(arguments) => ("catch", &arguments.study, arguments),
            Self::WorkPrecision(arguments) => ("work-precision", &arguments.study, arguments),
            Self::Stability(arguments) => ("stability", &arguments.study, arguments),
            Self::Damages(arguments) => ("damages", &arguments.study, arguments),
        }
    }
}

/// Runs the command; returns the exit code.
pub(super) fn command(study_command: &Study, common: &Common) -> Result<u8, Failure> {
    let (name, StudyCommon { out, design, set }, analysis) = study_command.analysis();
    let session = Session::new(name, common.thread_count());
    let mut default = Design::reference();
    if name != "damages" {
        // Nothing scatters in the other studies, so that a value may be 0.
        default.tolerance.clear();
    }
    let design = super::design::design(
        default,
        design.as_deref(),
        set,
        &common.limits().map_err(Failure::Usage)?,
    )?;
    if design.catch.is_some() && name != "catch" {
        return Err(Failure::Data(Error::malformed(
            "a design of the lever alone, for this study",
            "one with an inertia catch",
            "latchgate study catch is the one that knows it",
        )));
    }
    let answer = analysis.run(&design, &session)?;
    let complete = answer.complete;
    let summary = Summary {
        schema: "latchgate.study/1".into(),
        study: name.into(),
        parameters: answer.parameters,
        complete,
        headlines: answer.headlines,
        cases: answer.cases,
        results: answer.results,
        version: env!("CARGO_PKG_VERSION").into(),
        elapsed_s: session.elapsed_s(),
    };
    let files = StudyFiles::new(&summary, answer.tables, answer.svg);
    let folder = out
        .clone()
        .unwrap_or_else(|| PathBuf::from("reports/out").join(&*files.name));
    let written = files.write(&folder).map_err(Failure::Data)?;
    match common.format {
        OutputFormat::Json => output::document(&files.json),
        OutputFormat::Text => output::text(&latchgate_study::files::text(&summary, &written)),
    }
    .map_err(Failure::Data)?;
    if !complete {
        output::talk(&format!(
            "{}; what was computed until then is written",
            progress::INTERRUPTED_MESSAGE
        ));
        return Ok(INTERRUPTED);
    }
    Ok(0)
}
