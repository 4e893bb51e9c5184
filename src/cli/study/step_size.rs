//! `latchgate study step-size`.

use super::analysis::{Analysis, Session, StudyAnswer};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use clap::Args;
use latchgate_document::request::{parse_phi0, parse_positive, parse_velocity};
use latchgate_kernel::model::Design;
use latchgate_study::chart;
use latchgate_study::files::StudyTable;
use latchgate_study::step_size;
use serde_json::json;

/// Options of `study step-size`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Angular frequency of the excitation [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_positive, default_value_t = 20.0, allow_hyphen_values = true)]
    pub omega: f64,
    /// Steps per period of each run
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(10..=1_000_000), default_values_t = [10_000, 1000], allow_hyphen_values = true)]
    pub steps_per_period: Vec<u32>,
    /// Length [periods of the excitation]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100), default_value_t = 3, allow_hyphen_values = true)]
    pub periods: u32,
    /// Step sizes of the scan for the limit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1000), default_value_t = 120, allow_hyphen_values = true)]
    pub points: u32,
    /// Initial angle [rad]
    #[arg(long, value_name = "RAD", value_parser = parse_phi0, allow_hyphen_values = true, default_value_t = 0.5)]
    pub phi0: f64,
    /// Initial angular velocity [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_velocity, allow_hyphen_values = true, default_value_t = 0.0)]
    pub omega0: f64,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, _session: &Session) -> Result<StudyAnswer, Failure> {
        let options = step_size::Options {
            design: design.clone(),
            angular_frequency_rad_s: self.omega,
            steps_per_period: self.steps_per_period.clone(),
            angle_rad: self.phi0,
            velocity_rad_s: self.omega0,
            periods: self.periods,
            points: self.points,
        };
        let result = step_size::run(&options).map_err(Failure::Data)?;
        let rows: Vec<_> = result.rows().collect();
        Ok(StudyAnswer {
            results: Some(json!({ "runs": result.runs, "scan": result.scan })),
            tables: vec![StudyTable::of(&rows).map_err(Failure::Data)?],
            svg: chart::step_size(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
