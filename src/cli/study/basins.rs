//! `latchgate study basins`.

use super::sweep::{self, Sine, Span};
use super::{Analysis, Answer, Failure, Session};
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use crate::model::Design;
use crate::report::plot;
use crate::report::study::Table;
use crate::study::basins;
use clap::Args;
use serde_json::json;
use std::collections::BTreeMap;

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
    pub sine: Sine,
    /// Amplitude [g]
    #[arg(long, value_name = "A", value_parser = sweep::parse_amplitude, default_value_t = 1.0, allow_negative_numbers = true)]
    pub amplitude: f64,
    /// Initial angles [rad]
    #[arg(long, value_name = "LO..HI", value_parser = sweep::parse_range, default_value = "0..1", allow_hyphen_values = true)]
    pub angle: Span,
    /// Initial angular velocities [rad/s]
    #[arg(long, value_name = "LO..HI", value_parser = sweep::parse_range, default_value = "-20..20", allow_hyphen_values = true)]
    pub velocity: Span,
    /// Initial states: angles × velocities
    #[arg(long, value_name = "NxM", value_parser = sweep::parse_grid, default_value = "200x200", allow_hyphen_values = true)]
    pub grid: (u32, u32),
    /// Periods after which motion is taken for settled
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=100_000), default_value_t = 300, allow_negative_numbers = true)]
    pub transient: u32,
}

impl Analysis for Arguments {
    fn name(&self) -> &'static str {
        "basins"
    }

    fn common(&self) -> &StudyCommon {
        &self.study
    }

    fn run(&self, design: &Design, session: &Session) -> Result<Answer, Failure> {
        let mut answer = Answer {
            parameters: BTreeMap::from([
                ("amplitude_g", json!(self.amplitude)),
                ("angle_rad", json!([self.angle.low, self.angle.high])),
                ("gravity_m_s2", json!(self.sine.gravity)),
                ("grid", json!(self.grid)),
                ("model", json!(self.model.stops())),
                ("omega_rad_s", json!(self.sine.omega)),
                ("transient", json!(self.transient)),
                (
                    "velocity_rad_s",
                    json!([self.velocity.low, self.velocity.high]),
                ),
            ]),
            ..Answer::default()
        };
        let stops = self.model.stops();
        let mut all = Vec::new();
        for stop in &stops {
            let options = basins::Options {
                rig: sweep::rig(design, *stop, self.sine.gravity, self.sine.omega),
                amplitude_g: self.amplitude,
                angle_rad: (self.angle.low, self.angle.high),
                velocity_rad_s: (self.velocity.low, self.velocity.high),
                grid: self.grid,
                transient: self.transient,
            };
            let basins = session
                .watch(stop.name(), |control| basins::run(&options, control))
                .map_err(Failure::Data)?;
            answer
                .tables
                .push(Table::of_stops(&stops, *stop, &basins.rows()).map_err(Failure::Data)?);
            answer.headlines.extend(basins.headlines());
            answer.complete &= basins.complete;
            all.push(basins);
        }
        answer.results = Some(json!(
            all.iter()
                .map(|basins| json!({
                    "model": basins.options.rig.stop,
                    "complete": basins.complete,
                    "boundary_share": basins.boundary_share,
                    "uncertainty_exponent": basins.uncertainty_exponent,
                    "attractors": basins.attractors,
                }))
                .collect::<Vec<_>>()
        ));
        answer.svg = plot::basins(&all);
        Ok(answer)
    }
}
