//! `latchgate study parameters`.

use super::analysis::{Analysis, Session, StudyAnswer};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::Args;
use latchgate_document::request::parse_positive;
use latchgate_kernel::model::Design;
use latchgate_study::files::StudyTable;
use latchgate_study::{chart, parameters};

/// Options of `study parameters`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model; auto: both
    #[arg(long, value_enum, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// Values of each number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=i64::from(parameters::POINTS_MAX)), default_value_t = 400, allow_hyphen_values = true)]
    pub points: u32,
    /// What one g is [m/s²]
    #[arg(long, value_name = "M_S2", value_parser = parse_positive, default_value_t = latchgate_kernel::units::STANDARD_GRAVITY, allow_hyphen_values = true)]
    pub gravity: f64,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure> {
        let options = parameters::Options {
            design: design.clone(),
            models: self.model.stops(),
            gravity_m_s2: self.gravity,
            points: self.points,
        };
        let result = session.watch("parameters", |control| parameters::run(&options, control))?;
        Ok(StudyAnswer {
            tables: vec![StudyTable::of(&result.rows).map_err(Failure::Data)?],
            svg: chart::parameters(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
