//! `latchgate study attractor`.

use super::sweep::{self, Sine, Span, Start};
use super::{Analysis, Answer, Failure, Session};
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use crate::model::Design;
use crate::report::plot;
use crate::report::study::Table;
use crate::study::attractor;
use clap::Args;
use serde_json::json;
use std::collections::BTreeMap;

/// Options of `study attractor`.
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
    /// Amplitude [g], or several for statistics over them
    #[arg(long, value_name = "A|LO..HI", value_parser = sweep::parse_amplitudes, default_value = "2.5", allow_hyphen_values = true)]
    pub amplitude: Span,
    /// Number of amplitudes, if there are several
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=20_000), default_value_t = 401, allow_negative_numbers = true)]
    pub points: u32,
    /// Periods left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1_000_000), default_value_t = 200, allow_negative_numbers = true)]
    pub transient: u32,
    /// Periods kept
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=10_000_000), default_value_t = 10_000, allow_negative_numbers = true)]
    pub periods: u32,
    /// Where the lever starts.
    #[command(flatten)]
    pub start: Start,
    /// Show beside it what fixed-step Runge-Kutta with this many steps per period of the excitation
    /// and events on its grid makes of the same, as in the paper
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000), allow_negative_numbers = true)]
    pub compare_steps: Option<u32>,
}

impl Analysis for Arguments {
    fn name(&self) -> &'static str {
        "attractor"
    }

    fn common(&self) -> &StudyCommon {
        &self.study
    }

    fn run(&self, design: &Design, session: &Session) -> Result<Answer, Failure> {
        let stops = self.model.stops();
        let initial = self.start.state(&stops)?;
        let mut answer = Answer {
            parameters: BTreeMap::from([
                (
                    "amplitude_g",
                    json!([self.amplitude.low, self.amplitude.high]),
                ),
                ("compare_steps", json!(self.compare_steps)),
                ("gravity_m_s2", json!(self.sine.gravity)),
                ("initial", json!(initial)),
                ("model", json!(stops)),
                ("omega_rad_s", json!(self.sine.omega)),
                ("periods", json!(self.periods)),
                ("points", json!(self.points)),
                ("transient", json!(self.transient)),
            ]),
            ..Answer::default()
        };
        let mut attractors = Vec::new();
        for stop in &stops {
            let several = self.amplitude.low < self.amplitude.high;
            let options = attractor::Options {
                rig: sweep::rig(design, *stop, self.sine.gravity, self.sine.omega),
                amplitudes_g: (self.amplitude.low, self.amplitude.high),
                points: if several { self.points } else { 1 },
                transient: self.transient,
                periods: self.periods,
                initial,
                compared_steps: self.compare_steps,
            };
            let attractor = session
                .watch(stop.name(), |control| attractor::run(&options, control))
                .map_err(Failure::Data)?;
            answer
                .tables
                .push(Table::of_stops(&stops, *stop, &attractor.rows).map_err(Failure::Data)?);
            answer.headlines.extend(attractor.headlines());
            answer.complete &= attractor.complete;
            attractors.push(attractor);
        }
        answer.results = Some(json!(
            attractors
                .iter()
                .map(|attractor| json!({
                    "model": attractor.options.rig.stop,
                    "complete": attractor.complete,
                    "periods": attractor.periods,
                    "orbit": attractor.orbit,
                    "superstable": attractor.superstable,
                    "growth": attractor.growth,
                    "statistics": attractor.statistics,
                }))
                .collect::<Vec<_>>()
        ));
        answer.svg = plot::attractor(&attractors);
        Ok(answer)
    }
}
