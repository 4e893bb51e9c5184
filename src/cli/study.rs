//! `latchgate study`: one file per study, one line each in [`Study`] and in its `analysis`.

mod attractor;
mod basins;
mod bifurcation;
mod excitation_map;
mod free_vibration;
mod histories;
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
use super::progress::{self, Progress};
use super::values::OutputFormat;
use crate::error::ErrorKind;
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::parallel::Control;
use crate::report;
use crate::report::study::{Files, Summary, Table};
use crate::request::parse_positive;
use crate::study::Headline;
use crate::study::work_precision::Truth;
use clap::Subcommand;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// The studies.
#[derive(Debug, Clone, Subcommand)]
pub enum Study {
    /// Fig. 2: the damping ratio that stands for a restitution, and how far that holds
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
    /// Fig. 10: where the lever ends up from different starts under one sine
    Histories(histories::Arguments),
    /// Fig. 11: response to the shock of a side impact
    Shock(shock::Arguments),
    /// Error against cost of each method, on a shock, a recording and a sine, on both stops
    WorkPrecision(work_precision::Arguments),
    /// Where each method fails: step against stiffness, grazing, chatter, events inside a sample
    Stability(stability::Arguments),
}

impl Study {
    fn analysis(&self) -> &dyn Analysis {
        match self {
            Self::Restitution(own) => own,
            Self::StepSize(own) => own,
            Self::FreeVibration(own) => own,
            Self::Spectrogram(own) => own,
            Self::Bifurcation(own) => own,
            Self::Attractor(own) => own,
            Self::Basins(own) => own,
            Self::ExcitationMap(own) => own,
            Self::Histories(own) => own,
            Self::Shock(own) => own,
            Self::WorkPrecision(own) => own,
            Self::Stability(own) => own,
        }
    }
}

/// A study as the command line sees it: options that can be run.
trait Analysis {
    /// Returns the study's name, which its files take.
    fn name(&self) -> &'static str;

    /// Returns the options of every study.
    fn common(&self) -> &StudyCommon;

    /// Runs it on `design`.
    fn run(&self, design: &Design, session: &Session) -> Result<Answer, Failure>;
}

/// What surrounds a study: its clock, its threads.
struct Session<'a> {
    started: Instant,
    progress: Progress,
    common: &'a Common,
}

impl Session<'_> {
    /// Returns the seconds since the study began.
    fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Does a step of the work by all threads, showing on a terminal how far it is.
    fn watch<T>(&self, step: &str, work: impl FnOnce(&Control<'_>) -> T) -> T {
        self.progress.watch(step, self.common.thread_count(), work)
    }
}

/// What a study answers; name, design, version and time are added to it in one place.
struct Answer {
    /// What was asked for, beside the design.
    parameters: BTreeMap<&'static str, serde_json::Value>,
    headlines: Vec<Headline>,
    /// Truth of each case, of a study that has cases.
    cases: Vec<Truth>,
    /// What else the JSON lists.
    results: Option<serde_json::Value>,
    tables: Vec<Table>,
    svg: String,
    /// Whether the work was done to its end.
    complete: bool,
}

impl Default for Answer {
    fn default() -> Self {
        Self {
            parameters: BTreeMap::new(),
            headlines: Vec::new(),
            cases: Vec::new(),
            results: None,
            tables: Vec::new(),
            svg: String::new(),
            complete: true,
        }
    }
}

/// Returns an initial state that every one of `stops` admits.
fn start(phi0: f64, omega0: f64, stops: &[StopModel]) -> Result<(f64, f64), Failure> {
    if phi0 < 0.0 && stops.contains(&StopModel::Rigid) {
        return Err(Failure::Usage(
            ErrorKind::OutOfRange {
                what: "--phi0 [rad]".into(),
                expected: "0 or more on a rigid stop; choose --model soft to start inside the stop"
                    .into(),
                found: phi0.to_string(),
            }
            .into(),
        ));
    }
    Ok((phi0, omega0))
}

/// Most natural periods that a free motion is followed for.
const PERIODS_MAX: f64 = 1000.0;

fn parse_periods(text: &str) -> Result<f64, String> {
    parse_positive(text).and_then(|periods| {
        if periods <= PERIODS_MAX {
            Ok(periods)
        } else {
            Err(format!("must be at most {PERIODS_MAX}"))
        }
    })
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &Study, common: &Common) -> Result<u8, Failure> {
    let analysis = own.analysis();
    let session = Session {
        started: Instant::now(),
        progress: Progress::new(analysis.name()),
        common,
    };
    let StudyCommon { out, design, set } = analysis.common();
    let design = super::design::design(
        design.as_deref(),
        set,
        &common.limits().map_err(Failure::Usage)?,
    )?;
    let answer = analysis.run(&design, &session)?;
    let complete = answer.complete;
    let mut parameters = answer.parameters;
    parameters.insert("design", json!(design));
    let summary = Summary {
        schema: "latchgate.study/1",
        study: analysis.name(),
        parameters,
        complete,
        headlines: answer.headlines,
        cases: answer.cases,
        results: answer.results,
        version: env!("CARGO_PKG_VERSION"),
        elapsed_s: session.elapsed_s(),
    };
    let files = Files::new(&summary, answer.tables, answer.svg);
    let folder = out
        .clone()
        .unwrap_or_else(|| PathBuf::from("reports/out").join(files.name));
    let written = files.write(&folder).map_err(Failure::Data)?;
    match common.format {
        OutputFormat::Json => output::document(&files.json),
        OutputFormat::Text => output::text(&report::study::text(&summary, &written)),
    }
    .map_err(Failure::Data)?;
    if !complete {
        output::talk(&format!(
            "{}; what was done until then is written",
            progress::WORD
        ));
        return Ok(INTERRUPTED);
    }
    Ok(0)
}
