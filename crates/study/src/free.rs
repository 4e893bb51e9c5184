//! Free motion: the lever released away from the stop, without excitation.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, RunOptions, State, TracePoint};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_recording::error::Error;
use serde::Serialize;
use std::f64::consts::TAU;

/// Obstacle at φ = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Against {
    /// Nothing: it swings through.
    Nothing,
    /// The rigid stop.
    Rigid,
    /// The soft stop.
    Soft,
}

impl Against {
    /// Returns the obstacle of a lever on `stop`.
    pub fn stop(stop: StopModel) -> Self {
        match stop {
            StopModel::Rigid => Self::Rigid,
            StopModel::Soft => Self::Soft,
        }
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Rigid => "rigid",
            Self::Soft => "soft",
        }
    }
}

/// Release of the lever, and the duration of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Release {
    /// Preload torque in place of the design's own [N m].
    pub preload_torque_nm: f64,
    /// Initial state.
    pub start: State,
    /// Duration [s].
    pub duration_s: f64,
    /// Points per second of the history, at least [Hz].
    pub rate_hz: f64,
}

/// A free motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FreeMotion {
    /// Obstacle at φ = 0.
    pub against: Against,
    /// Preload torque [N m].
    pub preload_torque_nm: f64,
    /// Impacts (soft stop: contact entries) faster than 1e-3 rad/s, the first 200: time [s],
    /// velocity before [rad/s].
    pub impacts: Vec<[f64; 2]>,
    /// Instant from which it stays on the stop [s]: rest on the rigid one, the last contact entry on the
    /// soft one; `None` if it does not stay.
    pub settled_s: Option<f64>,
    /// Angle at the end [rad].
    pub final_angle_rad: f64,
    /// Angular velocity at the end [rad/s].
    pub final_velocity_rad_s: f64,
    /// Bound on the error of the final angle [rad].
    pub final_error_rad: Option<f64>,
    /// The history: samples, and both sides of each impact.
    #[serde(skip)]
    pub trace: Vec<TracePoint>,
}

/// Largest number of samples of a free motion.
const SAMPLES_MAX: f64 = 4e6;

/// Returns the period of the lever out of contact, 2π/ω0 [s].
///
/// # Errors
///
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) if it has no spring.
pub fn natural_period_s(design: &Design) -> Result<f64, Error> {
    let period = TAU / design.lever.angular_frequency_rad_s();
    if period.is_finite() && period > 0.0 {
        return Ok(period);
    }
    Err(Error::out_of_range(
        "lever.spring_stiffness_nm_per_rad",
        "positive, since this study counts time in natural periods",
        design.lever.spring_stiffness_nm_per_rad.to_string(),
    ))
}

/// Computes the motion after a release.
///
/// Without a stop the lever is on a soft stop without stiffness and damping, so that the same kernel
/// carries it through φ = 0.
///
/// # Errors
///
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for an initial state that the stop does not admit, or
/// for more than four million samples.
pub fn run(design: &Design, against: Against, release: &Release) -> Result<FreeMotion, Error> {
    let mut design = design.clone();
    design.lever.preload_torque_nm = release.preload_torque_nm;
    let stop = match against {
        Against::Rigid => StopModel::Rigid,
        Against::Soft => StopModel::Soft,
        Against::Nothing => {
            design.stop.stiffness_n_per_m = 0.0;
            design.stop.damping_n_s_per_m = 0.0;
            StopModel::Soft
        }
    };
    let intervals = (release.duration_s * release.rate_hz).ceil().max(1.0);
    if intervals.is_nan() || intervals > SAMPLES_MAX {
        return Err(Error::out_of_range(
            "samples of a free motion",
            format!("at most {SAMPLES_MAX:e}; ask for fewer periods"),
            format!("{intervals:e}"),
        ));
    }
    let count = intervals as usize + 1;
    let silence = Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(intervals / release.duration_s)?,
        samples: vec![0.0; count],
    };
    let outcome = replay::run(
        &silence,
        &design,
        &RunOptions {
            initial: Some(release.start),
            trace: true,
            ..RunOptions::new(stop, OpensWhen::Negative)
        },
    )?;
    let run = outcome.run;
    let settled_s = match against {
        Against::Nothing => None,
        Against::Rigid => outcome
            .trace
            .iter()
            .find(|point| point.angle_rad == 0.0 && point.velocity_rad_s == 0.0)
            .map(|point| point.time_s),
        Against::Soft => (run.final_angle_rad < 0.0 && !run.moving_at_end)
            .then(|| run.impact_list.last().map(|impact| impact[0]))
            .flatten(),
    };
    Ok(FreeMotion {
        against,
        preload_torque_nm: release.preload_torque_nm,
        // The stop without stiffness still counts contacts, which are no impacts.
        impacts: if against == Against::Nothing {
            Vec::new()
        } else {
            run.impact_list
        },
        settled_s,
        final_angle_rad: run.final_angle_rad,
        final_velocity_rad_s: run.final_velocity_rad_s,
        final_error_rad: outcome.final_error_rad,
        trace: outcome.trace,
    })
}

/// The time from an impact to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImpactInterval {
    /// Middle between the two [s].
    pub middle_s: f64,
    /// Length [s].
    pub length_s: f64,
}

impl FreeMotion {
    /// Returns the time from each impact to the next.
    pub fn intervals(&self) -> Vec<ImpactInterval> {
        self.impacts
            .windows(2)
            .map(|pair| ImpactInterval {
                middle_s: f64::midpoint(pair[0][0], pair[1][0]),
                length_s: pair[1][0] - pair[0][0],
            })
            .collect()
    }
}

/// A row of a history.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Preload torque [N m].
    pub preload_torque_nm: f64,
    /// Obstacle at φ = 0.
    pub stop: Against,
    /// Time [s].
    pub time_s: f64,
    /// Angle [rad].
    pub angle_rad: f64,
    /// Angular velocity [rad/s].
    pub angular_velocity_rad_s: f64,
}

impl FreeMotion {
    /// Returns the history as rows.
    pub fn rows(&self) -> impl Iterator<Item = Row> {
        self.trace.iter().map(|point| Row {
            preload_torque_nm: self.preload_torque_nm,
            stop: self.against,
            time_s: point.time_s,
            angle_rad: point.angle_rad,
            angular_velocity_rad_s: point.velocity_rad_s,
        })
    }
}
