//! `latchgate study attractor`.

use super::analysis::{Analysis, Session, StudyAnswer};
use super::sweep::{self, SineArguments, StartArguments};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::Args;
use latchgate_kernel::model::Design;
use latchgate_kernel::range::Range;
use latchgate_study::attractor;
use latchgate_study::chart;
use serde_json::json;

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
    pub sine: SineArguments,
    /// Amplitude [g], or several for statistics over them
    #[arg(long, value_name = "A|LO..HI", value_parser = sweep::parse_amplitudes, default_value = "2.5", allow_hyphen_values = true)]
    pub amplitude: Range,
    /// Number of amplitudes, if there are several
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=20_000), default_value_t = 401, allow_hyphen_values = true)]
    pub points: u32,
    /// Periods discarded
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1_000_000), default_value_t = 200, allow_hyphen_values = true)]
    pub transient: u32,
    /// Periods kept
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=10_000_000), default_value_t = 10_000, allow_hyphen_values = true)]
    pub periods: u32,
    /// Where the lever starts.
    #[command(flatten)]
    pub start: StartArguments,
    /// Compare with fixed-step Runge-Kutta of this many steps per period, as in the paper
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000), allow_hyphen_values = true)]
    pub compare_steps: Option<u32>,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure> {
        let stops = self.model.stops();
        let initial = self.start.state(&stops)?;
        let base = |stop| attractor::Options {
            forced: sweep::forced(design, stop, self.sine.gravity, self.sine.omega),
            amplitudes_g: self.amplitude,
            points: self.points,
            transient: self.transient,
            periods: self.periods,
            initial,
            compared_steps: self.compare_steps,
        };
        let mut answer = StudyAnswer::of_stops(&base(stops[0]), &stops);
        let mut attractors = Vec::new();
        for stop in &stops {
            let options = base(*stop);
            let attractor =
                session.watch(stop.name(), |control| attractor::run(&options, control))?;
            answer.add(
                *stop,
                &stops,
                &attractor.rows,
                attractor.headlines(),
                attractor.complete,
                json!({
                    "periods": attractor.periods,
                    "orbit": attractor.orbit,
                    "superstable": attractor.superstable,
                    "growth": attractor.growth,
                    "statistics": attractor.statistics,
                }),
            )?;
            attractors.push(attractor);
        }
        answer.svg = chart::attractor(&attractors);
        Ok(answer)
    }
}
