//! `latchgate study spectrogram`.

use super::analysis::{Analysis, Session, StudyAnswer};
use super::sweep::{parse_periods, start};
use crate::cli::failure::Failure;
use crate::cli::options::StudyCommon;
use crate::cli::values::StopArgument;
use clap::Args;
use latchgate_document::request::{parse_phi0, parse_positive, parse_velocity};
use latchgate_kernel::model::Design;
use latchgate_recording::error::Error;
use latchgate_study::chart;
use latchgate_study::files::StudyTable;
use latchgate_study::spectrogram;
use serde_json::json;

/// Options of `study spectrogram`.
#[derive(Debug, Clone, Args)]
pub struct Arguments {
    /// Lever and files.
    #[command(flatten)]
    pub study: StudyCommon,
    /// Stop model
    #[arg(long, value_enum, default_value_t = StopArgument::Soft)]
    pub model: StopArgument,
    /// Initial angle [rad]
    #[arg(long, value_name = "RAD", value_parser = parse_phi0, allow_hyphen_values = true, default_value_t = 0.5)]
    pub phi0: f64,
    /// Initial angular velocity [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_velocity, allow_hyphen_values = true, default_value_t = 0.0)]
    pub omega0: f64,
    /// Length [natural periods]
    #[arg(long, value_name = "N", value_parser = parse_periods, default_value_t = 3.0, allow_hyphen_values = true)]
    pub periods: f64,
    /// Window of the transform [natural periods]
    #[arg(long, value_name = "N", value_parser = parse_window, default_value_t = 0.75, allow_hyphen_values = true)]
    pub window: f64,
}

/// Longest window [natural periods]: its memory grows with its length.
const WINDOW_MAX: f64 = 8.0;

fn parse_window(text: &str) -> Result<f64, String> {
    parse_positive(text).and_then(|window| {
        if (0.05..=WINDOW_MAX).contains(&window) {
            Ok(window)
        } else {
            Err(format!("must lie between 0.05 and {WINDOW_MAX}"))
        }
    })
}

impl Analysis for Arguments {
    fn run(&self, design: &Design, _session: &Session) -> Result<StudyAnswer, Failure> {
        let start = start(self.phi0, self.omega0, &[self.model.stop()])?;
        if self.window >= self.periods {
            return Err(Failure::Usage(Error::out_of_range(
                "--window [natural periods]",
                format!("less than --periods, which is {}", self.periods),
                self.window.to_string(),
            )));
        }
        let options = spectrogram::Options {
            design: design.clone(),
            model: self.model.stop(),
            angle_rad: start.angle_rad,
            velocity_rad_s: start.velocity_rad_s,
            periods: self.periods,
            window_periods: self.window,
        };
        let result = spectrogram::run(&options).map_err(Failure::Data)?;
        let rows: Vec<_> = result.rows().collect();
        Ok(StudyAnswer {
            results: Some(json!({ "bounces": result.bounces, "motion": result.motion })),
            tables: vec![StudyTable::of(&rows).map_err(Failure::Data)?],
            svg: chart::spectrogram(&result),
            headlines: result.headlines,
            ..StudyAnswer::to(&options)
        })
    }
}
