//! `latchgate study work-precision`.

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
use latchgate_study::work_precision;

/// Options of `study work-precision`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model; auto: both
    #[arg(long, value_enum, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// Angular frequency of the sine [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_positive, default_value_t = 100.0, allow_hyphen_values = true)]
    pub omega: f64,
    /// Amplitude of the sine [g]
    #[arg(long, value_name = "A", value_parser = sweep::parse_positive_amplitude, default_value_t = 5.0, allow_hyphen_values = true)]
    pub amplitude: f64,
    /// Length of the sine [periods of the excitation]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 100, allow_hyphen_values = true)]
    pub periods: u32,
    /// Settings of each method, from coarse to fine
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=50), default_value_t = 6, allow_hyphen_values = true)]
    pub points: u32,
    /// Repetitions of each run; the fastest counts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = 5, allow_hyphen_values = true)]
    pub repetitions: u32,
    /// What one g is [m/s²]
    #[arg(long, value_name = "M_S2", value_parser = parse_positive, default_value_t = latchgate_kernel::units::STANDARD_GRAVITY, allow_hyphen_values = true)]
    pub gravity: f64,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure> {
        let options = work_precision::Options {
            design: design.clone(),
            models: self.model.stops(),
            gravity_m_s2: self.gravity,
            angular_frequency_rad_s: self.omega,
            amplitude_g: self.amplitude,
            periods: self.periods,
            points: self.points,
            repetitions: self.repetitions,
        };
        let result =
            work_precision::run(&options, &|| session.elapsed_s()).map_err(Failure::Data)?;
        Ok(StudyAnswer {
            tables: vec![StudyTable::of(&result.rows).map_err(Failure::Data)?],
            svg: chart::work_precision(&result),
            headlines: result.headlines,
            cases: result.truths,
            ..StudyAnswer::to(&options)
        })
    }
}
