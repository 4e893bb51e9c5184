//! `latchgate study stability`.

use super::{Analysis, Answer, Failure, Session};
use crate::cli::options::StudyCommon;
use crate::model::Design;
use crate::report::plot;
use crate::report::study::Table;
use crate::request::parse_positive;
use crate::study::stability;
use clap::Args;
use serde_json::json;
use std::collections::BTreeMap;

/// Options of `study stability`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Steps on the map of step against stiffness
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(8..=400), default_value_t = 96, allow_negative_numbers = true)]
    pub points: u32,
    /// What one g is [m/s²]
    #[arg(long, value_name = "M_S2", value_parser = parse_positive, default_value_t = crate::units::STANDARD_GRAVITY, allow_negative_numbers = true)]
    pub gravity: f64,
}

impl Analysis for Arguments {
    fn name(&self) -> &'static str {
        "stability"
    }

    fn common(&self) -> &StudyCommon {
        &self.study
    }

    fn run(&self, design: &Design, _session: &Session) -> Result<Answer, Failure> {
        let result = stability::run(&stability::Options {
            design: design.clone(),
            gravity_m_s2: self.gravity,
            points: self.points,
        })
        .map_err(Failure::Data)?;
        Ok(Answer {
            parameters: BTreeMap::from([
                ("gravity_m_s2", json!(self.gravity)),
                ("points", json!(self.points)),
            ]),
            tables: vec![Table::of(&result.rows).map_err(Failure::Data)?],
            svg: plot::stability(&result),
            headlines: result.headlines,
            ..Answer::default()
        })
    }
}
