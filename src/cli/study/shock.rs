//! `latchgate study shock`.

use super::analysis::{Analysis, Session, StudyAnswer};
use super::sweep;
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::Args;
use latchgate_document::request::parse_positive;
use latchgate_kernel::model::Design;
use latchgate_study::chart;
use latchgate_study::files::StudyTable;
use latchgate_study::shock;
use serde_json::json;

/// Options of `study shock`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model; auto: both
    #[arg(long, value_enum, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// Approximate peak of the shock [g]
    #[arg(long, value_name = "A", value_parser = sweep::parse_positive_amplitude, default_value_t = 1000.0, allow_hyphen_values = true)]
    pub amplitude: f64,
    /// Length of the run [s]
    #[arg(long, value_name = "S", value_parser = parse_duration, default_value_t = 0.3, allow_hyphen_values = true)]
    pub duration: f64,
    /// What one g is [m/s²]
    #[arg(long, value_name = "M_S2", value_parser = parse_positive, default_value_t = latchgate_kernel::units::STANDARD_GRAVITY, allow_hyphen_values = true)]
    pub gravity: f64,
}

fn parse_duration(text: &str) -> Result<f64, String> {
    parse_positive(text).and_then(|duration| {
        if duration <= shock::DURATION_MAX_S {
            Ok(duration)
        } else {
            Err(format!("must be at most {} s", shock::DURATION_MAX_S))
        }
    })
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, _session: &Session) -> Result<StudyAnswer, Failure> {
        let options = shock::Options {
            design: design.clone(),
            models: self.model.stops(),
            gravity_m_s2: self.gravity,
            amplitude_g: self.amplitude,
            duration_s: self.duration,
        };
        let result = shock::run(&options).map_err(Failure::Data)?;
        let rows: Vec<_> = result.rows().collect();
        Ok(StudyAnswer {
            results: Some(json!({ "responses": result.responses })),
            tables: vec![StudyTable::of(&rows).map_err(Failure::Data)?],
            svg: chart::shock(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
