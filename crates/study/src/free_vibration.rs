//! The paper's Fig. 4: free vibration with and without impact, without and with preload.

use super::free::{self, Against, FreeMotion, Release};
use super::{Figures, Headline};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::State;
use latchgate_recording::error::Error;
use serde::Serialize;
use std::f64::consts::PI;

/// Options of the study of free vibration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever.
    pub design: Design,
    /// Stops to run.
    #[serde(rename = "model")]
    pub models: Vec<StopModel>,
    /// Initial angle [rad].
    #[serde(rename = "phi0_rad")]
    pub angle_rad: f64,
    /// Initial angular velocity [rad/s].
    #[serde(rename = "omega0_rad_s")]
    pub velocity_rad_s: f64,
    /// Length [natural periods].
    pub periods: f64,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeVibration {
    /// Motions without preload and with the design's, each without a stop and with the requested ones.
    pub motions: Vec<FreeMotion>,
    /// Headline figures.
    pub headlines: Vec<Headline>,
    /// Length [s].
    pub duration_s: f64,
    /// Half the natural period, π/ω0 [s].
    pub half_period_s: f64,
}

/// Points of a history in a natural period.
const POINTS_PER_PERIOD: f64 = 400.0;

/// Runs the study.
///
/// # Errors
///
/// As [`free::natural_period_s`] and [`free::run`].
pub fn run(options: &Options) -> Result<FreeVibration, Error> {
    let design = &options.design;
    let period = free::natural_period_s(design)?;
    let preload_nm = design.lever.preload_torque_nm;
    let preloads = if preload_nm > 0.0 {
        vec![0.0, preload_nm]
    } else {
        vec![preload_nm]
    };
    let stops: Vec<Against> = std::iter::once(Against::Nothing)
        .chain(options.models.iter().copied().map(Against::stop))
        .collect();
    let mut motions = Vec::new();
    for preload_torque_nm in preloads {
        let release = Release {
            preload_torque_nm,
            start: State::new(options.angle_rad, options.velocity_rad_s),
            duration_s: options.periods * period,
            rate_hz: POINTS_PER_PERIOD / period,
        };
        for against in &stops {
            motions.push(free::run(design, *against, &release)?);
        }
    }
    let half_period_s = PI / design.lever.angular_frequency_rad_s();
    Ok(FreeVibration {
        headlines: headlines(&motions, half_period_s),
        motions,
        duration_s: options.periods * period,
        half_period_s,
    })
}

fn headlines(motions: &[FreeMotion], half_period_s: f64) -> Vec<Headline> {
    let mut headlines = Vec::new();
    for motion in motions {
        let model = match motion.against {
            Against::Nothing => continue,
            Against::Rigid => StopModel::Rigid,
            Against::Soft => StopModel::Soft,
        };
        let subject = format!(
            "T0 = {} N·m",
            latchgate_kernel::units::plain(motion.preload_torque_nm, 4)
        );
        let mut figures = Figures::of(subject, model).digits(Headline::EXACT);
        let intervals = motion.intervals();
        figures.say(
            "first impact [s]",
            motion.impacts.first().map(|impact| impact[0]),
        );
        figures.say(
            "velocity before it [rad/s]",
            motion.impacts.first().map(|impact| impact[1]),
        );
        figures.say(
            "first time from impact to impact [s]",
            intervals.first().map(|interval| interval.length_s),
        );
        figures.say(
            "the same over π/ω0 [-]",
            intervals
                .first()
                .map(|interval| interval.length_s / half_period_s),
        );
        figures.say(
            "fifth over first time from impact to impact [-]",
            intervals
                .get(4)
                .map(|fifth| fifth.length_s / intervals[0].length_s),
        );
        figures.say("impacts, at most 200 [-]", motion.impacts.len() as f64);
        figures.say("stays on the stop from [s]", motion.settled_s);
        headlines.extend(figures.lines);
    }
    headlines
}
