//! `latchgate study excitation-map`.

use super::analysis::{Analysis, Session, StudyAnswer};
use super::sweep;
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::Args;
use latchgate_document::request::parse_positive;
use latchgate_kernel::model::Design;
use latchgate_kernel::range::Range;
use latchgate_study::chart;
use latchgate_study::excitation_map;
use serde_json::json;

/// Options of `study excitation-map`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model; auto: both
    #[arg(long, value_enum, default_value_t = ModelArgument::Auto)]
    pub model: ModelArgument,
    /// Amplitudes [g]
    #[arg(long, value_name = "LO..HI", value_parser = sweep::parse_amplitude_range, default_value = "0..10", allow_hyphen_values = true)]
    pub amplitude: Range,
    /// Angular frequencies [rad/s], on a logarithmic scale
    #[arg(long, value_name = "LO..HI", value_parser = sweep::parse_frequencies, default_value = "5..1000", allow_hyphen_values = true)]
    pub omega: Range,
    /// Amplitudes × frequencies
    #[arg(long, value_name = "NxM", value_parser = sweep::parse_grid, default_value = "100x160", allow_hyphen_values = true)]
    pub grid: (u32, u32),
    /// Excitation periods of each run, from rest
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000), default_value_t = 30, allow_hyphen_values = true)]
    pub periods: u32,
    /// What one g is [m/s²]
    #[arg(long, value_name = "M_S2", value_parser = parse_positive, default_value_t = latchgate_kernel::units::STANDARD_GRAVITY, allow_hyphen_values = true)]
    pub gravity: f64,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure> {
        let stops = self.model.stops();
        let base = |stop| excitation_map::Options {
            forced: sweep::forced(design, stop, self.gravity, self.omega.low),
            amplitudes_g: self.amplitude,
            angular_frequencies_rad_s: self.omega,
            grid: self.grid,
            periods: self.periods,
        };
        let mut answer = StudyAnswer::of_stops(&base(stops[0]), &stops);
        let mut maps = Vec::new();
        for stop in &stops {
            let options = base(*stop);
            let map = session.watch(stop.name(), |control| {
                excitation_map::run(&options, control)
            })?;
            answer.add(
                *stop,
                &stops,
                &map.rows,
                map.headlines(),
                map.complete,
                json!({ "lift_off_g": map.lift_off_g, "boundary": map.boundary }),
            )?;
            maps.push(map);
        }
        answer.svg = chart::excitation_map(&maps);
        Ok(answer)
    }
}
