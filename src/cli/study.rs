//! `latchgate study`: what the methods cost and where they fail.

use super::args::{
    Common, ModelArgument, OutputFormat, StabilityArguments, Study, StudyArguments, StudyCommon,
    WorkPrecisionArguments,
};
use super::{Failure, output};
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::recording::Limits;
use crate::report;
use crate::report::study::{Files, Summary};
use crate::study::{stability, work_precision};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// Runs the command; returns the exit code.
pub(super) fn command(own: &StudyArguments, common: &Common) -> Result<u8, Failure> {
    let (study, files, summary) = match &own.study {
        Study::WorkPrecision(own) => {
            let (files, summary) = run_work_precision(own)?;
            (&own.study, files, summary)
        }
        Study::Stability(own) => {
            let (files, summary) = run_stability(own)?;
            (&own.study, files, summary)
        }
    };
    let folder = study
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from("reports/out").join(files.name));
    files.write(&folder).map_err(Failure::Data)?;
    match common.format {
        OutputFormat::Json => output::data(&files.json),
        OutputFormat::Text => output::data(&report::study::text(&summary, &folder)),
    }
    .map_err(Failure::Data)?;
    Ok(0)
}

fn lever(study: &StudyCommon) -> Result<Design, Failure> {
    super::replay::design(study.design.as_deref(), &study.set, &Limits::default())
}

fn run_work_precision(own: &WorkPrecisionArguments) -> Result<(Files, Summary), Failure> {
    let started = Instant::now();
    let design = lever(&own.study)?;
    let models = match own.model {
        ModelArgument::Auto => vec![StopModel::Rigid, StopModel::Soft],
        ModelArgument::Rigid => vec![StopModel::Rigid],
        ModelArgument::Soft => vec![StopModel::Soft],
    };
    let options = work_precision::Options {
        design,
        models,
        gravity_m_s2: own.gravity,
        angular_frequency_rad_s: own.omega,
        amplitude_g: own.amplitude,
        periods: own.periods,
        points: own.points,
        repetitions: own.repetitions,
    };
    let clock = || started.elapsed().as_secs_f64();
    let result = work_precision::run(&options, &clock).map_err(Failure::Data)?;
    let summary = Summary {
        schema: "latchgate.study/1",
        study: "work-precision",
        parameters: BTreeMap::from([
            ("amplitude_g", json!(own.amplitude)),
            ("design", json!(options.design)),
            ("gravity_m_s2", json!(own.gravity)),
            ("model", json!(options.models)),
            ("omega_rad_s", json!(own.omega)),
            ("periods", json!(own.periods)),
            ("points", json!(own.points)),
            ("repetitions", json!(own.repetitions)),
        ]),
        headlines: result.headlines.clone(),
        cases: result.truths.clone(),
        version: env!("CARGO_PKG_VERSION"),
        elapsed_s: started.elapsed().as_secs_f64(),
    };
    let files = Files::work_precision(&result, &summary).map_err(Failure::Data)?;
    Ok((files, summary))
}

fn run_stability(own: &StabilityArguments) -> Result<(Files, Summary), Failure> {
    let started = Instant::now();
    let design = lever(&own.study)?;
    let result = stability::run(&stability::Options {
        design: design.clone(),
        gravity_m_s2: own.gravity,
        points: own.points,
    })
    .map_err(Failure::Data)?;
    let summary = Summary {
        schema: "latchgate.study/1",
        study: "stability",
        parameters: BTreeMap::from([
            ("design", json!(design)),
            ("gravity_m_s2", json!(own.gravity)),
            ("points", json!(own.points)),
        ]),
        headlines: result.headlines.clone(),
        cases: Vec::new(),
        version: env!("CARGO_PKG_VERSION"),
        elapsed_s: started.elapsed().as_secs_f64(),
    };
    let files = Files::stability(&result, &summary).map_err(Failure::Data)?;
    Ok((files, summary))
}
