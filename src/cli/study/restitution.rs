//! `latchgate study restitution`.

use super::{Analysis, Answer, Failure, Session};
use crate::cli::options::StudyCommon;
use crate::model::Design;
use crate::report::plot;
use crate::report::study::Table;
use crate::study::restitution;
use clap::Args;
use serde_json::json;
use std::collections::BTreeMap;

/// Options of `study restitution`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Points of the curve
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=100_000), default_value_t = 200, allow_negative_numbers = true)]
    pub points: u32,
}

impl Analysis for Arguments {
    fn name(&self) -> &'static str {
        "restitution"
    }

    fn common(&self) -> &StudyCommon {
        &self.study
    }

    fn run(&self, design: &Design, _session: &Session) -> Result<Answer, Failure> {
        let result = restitution::run(&restitution::Options {
            design: design.clone(),
            points: self.points,
        })
        .map_err(Failure::Data)?;
        Ok(Answer {
            parameters: BTreeMap::from([("points", json!(self.points))]),
            results: Some(json!({ "rebounds": result.rebounds })),
            tables: vec![Table::of(&result.rows).map_err(Failure::Data)?],
            svg: plot::restitution(&result),
            headlines: result.headlines,
            ..Answer::default()
        })
    }
}
