//! `latchgate study stability`.

use super::analysis::{Analysis, Session, StudyAnswer};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use clap::Args;
use latchgate_document::request::parse_positive;
use latchgate_kernel::model::Design;
use latchgate_study::chart;
use latchgate_study::files::StudyTable;
use latchgate_study::stability;

/// Options of `study stability`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Steps on the map of step against stiffness
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(8..=400), default_value_t = 96, allow_hyphen_values = true)]
    pub points: u32,
    /// What one g is [m/s²]
    #[arg(long, value_name = "M_S2", value_parser = parse_positive, default_value_t = latchgate_kernel::units::STANDARD_GRAVITY, allow_hyphen_values = true)]
    pub gravity: f64,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, _session: &Session) -> Result<StudyAnswer, Failure> {
        let options = stability::Options {
            design: design.clone(),
            gravity_m_s2: self.gravity,
            points: self.points,
        };
        let result = stability::run(&options).map_err(Failure::Data)?;
        Ok(StudyAnswer {
            tables: vec![StudyTable::of(&result.rows).map_err(Failure::Data)?],
            svg: chart::stability(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
