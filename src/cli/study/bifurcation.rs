//! `latchgate study bifurcation`.

use super::analysis::{Analysis, Session, StudyAnswer};
use super::sweep::{self, SineArguments, StartArguments};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::{Args, ValueEnum};
use latchgate_kernel::model::Design;
use latchgate_kernel::range::Range;
use latchgate_study::bifurcation::{self, Sweep};
use latchgate_study::chart;
use serde_json::json;

/// Options of `study bifurcation`.
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
    /// Amplitudes [g]
    #[arg(long, value_name = "LO..HI", value_parser = sweep::parse_amplitudes, default_value = "0..5", allow_hyphen_values = true)]
    pub amplitude: Range,
    /// Number of amplitudes
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=20_000), default_value_t = 500, allow_hyphen_values = true)]
    pub points: u32,
    /// Periods discarded at each amplitude
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=100_000), default_value_t = 100, allow_hyphen_values = true)]
    pub transient: u32,
    /// Periods kept at each amplitude
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000), default_value_t = 100, allow_hyphen_values = true)]
    pub periods: u32,
    /// Where every amplitude starts.
    #[command(flatten)]
    pub start: StartArguments,
    /// Carry the state from one amplitude to the next
    #[arg(long, value_enum, default_value_t = SweepArgument::None)]
    pub sweep: SweepArgument,
    /// Doublings searched on each branch of periodic orbits; 0: follow none
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=8), default_value_t = 6, allow_hyphen_values = true)]
    pub doublings: u32,
}

/// Direction of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SweepArgument {
    /// Every amplitude starts anew.
    None,
    /// From the least amplitude to the largest.
    Up,
    /// From the largest amplitude to the least.
    Down,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure> {
        let stops = self.model.stops();
        let initial = self.start.state(&stops)?;
        let base = |stop| bifurcation::Options {
            forced: sweep::forced(design, stop, self.sine.gravity, self.sine.omega),
            amplitudes_g: self.amplitude,
            points: self.points,
            transient: self.transient,
            periods: self.periods,
            initial,
            sweep: match self.sweep {
                SweepArgument::None => Sweep::None,
                SweepArgument::Up => Sweep::Up,
                SweepArgument::Down => Sweep::Down,
            },
            doublings: self.doublings,
        };
        let mut answer = StudyAnswer::of_stops(&base(stops[0]), &stops);
        let mut diagrams = Vec::new();
        for stop in &stops {
            let options = base(*stop);
            let diagram =
                session.watch(stop.name(), |control| bifurcation::run(&options, control))?;
            let branches = diagram.branches.iter().map(|branch| {
                json!({
                    "birth": branch.birth,
                    "doublings": branch.doublings,
                    "ratios": branch.ratios(),
                    "accumulation_g": branch.accumulation_g(),
                })
            });
            answer.add(
                *stop,
                &stops,
                &diagram.rows(),
                diagram.headlines(),
                diagram.complete,
                json!({
                    "branches": branches.collect::<Vec<_>>(),
                    "columns": diagram.columns,
                }),
            )?;
            diagrams.push(diagram);
        }
        answer.svg = chart::bifurcation(&diagrams);
        Ok(answer)
    }
}
