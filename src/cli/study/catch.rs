//! `latchgate study catch`.

use super::analysis::{Analysis, Session, StudyAnswer};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::ModelArgument;
use clap::Args;
use latchgate_document::request::parse_positive;
use latchgate_kernel::model::Design;
use latchgate_study::files::StudyTable;
use latchgate_study::{catch, chart};

/// Options of `study catch`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever, catch and files; without a design, an example of no vehicle.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model; auto: both
    #[arg(long, value_enum, default_value_t = ModelArgument::Rigid)]
    pub model: ModelArgument,
    /// Plateau of each of the two pulses [g]
    #[arg(long, value_name = "G", value_parser = parse_positive, default_value_t = 40.0, allow_hyphen_values = true)]
    pub pulse: f64,
    /// Amplitude of the ringing [g]
    #[arg(long, value_name = "G", value_parser = parse_positive, default_value_t = 300.0, allow_hyphen_values = true)]
    pub ringing: f64,
    /// Values of gap and frequency
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=i64::from(catch::POINTS_MAX)), default_value_t = 161, allow_hyphen_values = true)]
    pub points: u32,
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, session: &Session) -> Result<StudyAnswer, Failure> {
        let is_named = self.study.design.is_some() || !self.study.set.is_empty();
        let options = catch::Options {
            design: if is_named {
                design.clone()
            } else {
                catch::example()
            },
            models: self.model.stops(),
            pulse_g: self.pulse,
            ringing_g: self.ringing,
            points: self.points,
        };
        let result = session.watch("catch", |control| catch::run(&options, control))?;
        Ok(StudyAnswer {
            tables: vec![StudyTable::of(&result.rows).map_err(Failure::Data)?],
            svg: chart::catch(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
