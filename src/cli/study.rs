//! `latchgate study`: one file per study, one line each in [`Study`] and in [`Study::analysis`].

mod stability;
mod work_precision;

use super::args::{Common, OutputFormat, StudyArguments, StudyCommon};
use super::{Failure, output};
use crate::model::Design;
use crate::report;
use crate::report::study::{Files, Summary, Table};
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
    /// Error against cost of each method, on a shock, a recording and a sine, on both stops
    WorkPrecision(work_precision::Arguments),
    /// Where each method fails: step against stiffness, grazing, chatter, events inside a sample
    Stability(stability::Arguments),
}

impl Study {
    fn analysis(&self) -> &dyn Analysis {
        match self {
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
    common: &'a Common,
}

impl Session<'_> {
    /// Returns the seconds since the study began.
    fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Returns the number of threads to use.
    #[expect(dead_code, reason = "for studies that run in parallel")]
    fn threads(&self) -> usize {
        self.common.thread_count()
    }
}

/// What a study answers; name, design, version and time are added to it in one place.
#[derive(Default)]
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
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &StudyArguments, common: &Common) -> Result<u8, Failure> {
    let analysis = own.study.analysis();
    let session = Session {
        started: Instant::now(),
        common,
    };
    let StudyCommon { out, design, set } = analysis.common();
    let design = super::replay::design(
        design.as_deref(),
        set,
        &common.limits().map_err(Failure::Usage)?,
    )?;
    let answer = analysis.run(&design, &session)?;
    let mut parameters = answer.parameters;
    parameters.insert("design", json!(design));
    let summary = Summary {
        schema: "latchgate.study/1",
        study: analysis.name(),
        parameters,
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
        OutputFormat::Json => output::data(&files.json),
        OutputFormat::Text => output::data(&report::study::text(&summary, &written)),
    }
    .map_err(Failure::Data)?;
    Ok(0)
}
