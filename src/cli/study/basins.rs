//! `latchgate study basins`.

use super::analysis::{Analysis, Session, StudyAnswer};
use super::sweep::{self, SineArguments};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::Args;
use latchgate_kernel::model::Design;
use latchgate_kernel::range::Range;
use latchgate_study::basins;
use latchgate_study::chart;
use serde_json::json;

/// Options of `study basins`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model; auto: both
    #[arg(long, value_enum, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// The sine.
    #[command(flatten)]
    pub sine: SineArguments,
    /// Amplitude [g]
    #[arg(long, value_name = "A", value_parser = sweep::parse_amplitude, default_value_t = 1.0, allow_hyphen_values = true)]
    pub amplitude: f64,
    /// Initial angles [rad]
    #[arg(long, value_name = "LO..HI", value_parser = sweep::parse_range, default_value = "0..1", allow_hyphen_values = true)]
    pub angle: Range,
    /// Initial angular velocities [rad/s]
    #[arg(long, value_name = "LO..HI", value_parser = sweep::parse_range, default_value = "-20..20", allow_hyphen_values = true)]
    pub velocity: Range,
    /// Initial states: angles × velocities
    #[arg(long, value_name = "NxM", value_parser = sweep::parse_grid, default_value = "200x200", allow_hyphen_values = true)]
    pub grid: (u32, u32),
    /// Periods until motion counts as settled
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=100_000), default_value_t = 300, allow_hyphen_values = true)]
    pub transient: u32,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure> {
        let stops = self.model.stops();
        let base = |stop| basins::Options {
            forced: sweep::forced(design, stop, self.sine.gravity, self.sine.omega),
            amplitude_g: self.amplitude,
            angle_rad: self.angle,
            velocity_rad_s: self.velocity,
            grid: self.grid,
            transient: self.transient,
        };
        let mut answer = StudyAnswer::of_stops(&base(stops[0]), &stops);
        let mut basins_by_stop = Vec::new();
        for stop in &stops {
            let options = base(*stop);
            let basins = session.watch(stop.name(), |control| basins::run(&options, control))?;
            answer.add(
                *stop,
                &stops,
                &basins.rows(),
                basins.headlines(),
                basins.complete,
                json!({
                    "boundary_share": basins.boundary_share,
                    "uncertainty_exponent": basins.uncertainty_exponent,
                    "attractors": basins.attractors,
                }),
            )?;
            basins_by_stop.push(basins);
        }
        answer.svg = chart::basins(&basins_by_stop);
        Ok(answer)
    }
}
