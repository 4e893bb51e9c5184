//! `latchgate study histories`.

use super::analysis::{Analysis, Session, StudyAnswer};
use super::sweep::{self, start};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::Args;
use latchgate_document::request::{parse_phi0, parse_positive, parse_velocity};
use latchgate_kernel::model::Design;
use latchgate_kernel::replay::State;
use latchgate_study::chart;
use latchgate_study::files::StudyTable;
use latchgate_study::histories;
use serde_json::json;

/// Options of `study histories`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model; auto: both
    #[arg(long, value_enum, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// Amplitude of the sine [g]
    #[arg(long, value_name = "A", value_parser = sweep::parse_amplitude, allow_hyphen_values = true, default_value_t = 1.0)]
    pub amplitude: f64,
    /// Angular frequency of the sine [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_positive, default_value_t = 100.0, allow_hyphen_values = true)]
    pub omega: f64,
    /// Initial angle of one start [rad] [default: the paper's three]
    #[arg(long, value_name = "RAD", value_parser = parse_phi0, allow_hyphen_values = true)]
    pub phi0: Option<f64>,
    /// Initial angular velocity [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_velocity, allow_hyphen_values = true, default_value_t = 0.0)]
    pub omega0: f64,
    /// Periods shown
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 40, allow_hyphen_values = true)]
    pub periods: u32,
    /// Periods until the motion counts as settled
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=10_000_000), default_value_t = 1000, allow_hyphen_values = true)]
    pub transient: u32,
    /// What one g is [m/s²]
    #[arg(long, value_name = "M_S2", value_parser = parse_positive, default_value_t = latchgate_kernel::units::STANDARD_GRAVITY, allow_hyphen_values = true)]
    pub gravity: f64,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, _session: &Session) -> Result<StudyAnswer, Failure> {
        let starts = match self.phi0 {
            Some(angle) => vec![start(angle, self.omega0, &self.model.stops())?],
            None => histories::STARTS
                .iter()
                .map(|start| State::new(start.angle_rad, self.omega0))
                .collect(),
        };
        let options = histories::Options {
            design: design.clone(),
            models: self.model.stops(),
            gravity_m_s2: self.gravity,
            amplitude_g: self.amplitude,
            angular_frequency_rad_s: self.omega,
            starts,
            periods: self.periods,
            transient: self.transient,
        };
        let result = histories::run(&options).map_err(Failure::Data)?;
        let rows: Vec<_> = result.rows().collect();
        Ok(StudyAnswer {
            results: Some(json!({ "histories": result.histories })),
            tables: vec![StudyTable::of(&rows).map_err(Failure::Data)?],
            svg: chart::histories(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
