//! `latchgate study free-vibration`.

use super::analysis::{Analysis, Session, StudyAnswer};
use super::sweep::{parse_periods, start};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::Args;
use latchgate_document::request::{parse_phi0, parse_velocity};
use latchgate_kernel::model::Design;
use latchgate_study::chart;
use latchgate_study::files::StudyTable;
use latchgate_study::{free, free_vibration};
use serde_json::json;

/// Options of `study free-vibration`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model; auto: both
    #[arg(long, value_enum, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// Initial angle [rad]
    #[arg(long, value_name = "RAD", value_parser = parse_phi0, allow_hyphen_values = true, default_value_t = 0.5)]
    pub phi0: f64,
    /// Initial angular velocity [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_velocity, allow_hyphen_values = true, default_value_t = 0.0)]
    pub omega0: f64,
    /// Length [natural periods]
    #[arg(long, value_name = "N", value_parser = parse_periods, default_value_t = 5.0, allow_hyphen_values = true)]
    pub periods: f64,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, _session: &Session) -> Result<StudyAnswer, Failure> {
        let start = start(self.phi0, self.omega0, &self.model.stops())?;
        let options = free_vibration::Options {
            design: design.clone(),
            models: self.model.stops(),
            angle_rad: start.angle_rad,
            velocity_rad_s: start.velocity_rad_s,
            periods: self.periods,
        };
        let result = free_vibration::run(&options).map_err(Failure::Data)?;
        let rows: Vec<_> = result
            .motions
            .iter()
            .flat_map(free::FreeMotion::rows)
            .collect();
        Ok(StudyAnswer {
            results: Some(json!({ "motions": result.motions })),
            tables: vec![StudyTable::of(&rows).map_err(Failure::Data)?],
            svg: chart::free_vibration(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
