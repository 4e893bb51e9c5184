//! `latchgate study restitution`.

use super::analysis::{Analysis, Session, StudyAnswer};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use clap::Args;
use latchgate_kernel::model::Design;
use latchgate_study::chart;
use latchgate_study::files::StudyTable;
use latchgate_study::restitution;
use serde_json::json;

/// Options of `study restitution`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Points of the curve
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=100_000), default_value_t = 200, allow_hyphen_values = true)]
    pub points: u32,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, _session: &Session) -> Result<StudyAnswer, Failure> {
        let options = restitution::Options {
            design: design.clone(),
            points: self.points,
        };
        let result = restitution::run(&options).map_err(Failure::Data)?;
        Ok(StudyAnswer {
            results: Some(json!({ "rebounds": result.rebounds })),
            tables: vec![StudyTable::of(&result.rows).map_err(Failure::Data)?],
            svg: chart::restitution(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
