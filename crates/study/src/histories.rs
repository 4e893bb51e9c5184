//! The paper's Fig. 10: the lasting motion of the lever from different initial states, under the same sine.

use super::{Figures, Headline};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, RunOptions, Section, State, Strobe, TracePoint};
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
use serde::Serialize;
use std::f64::consts::TAU;

/// The paper's initial states.
pub const STARTS: [State; 3] = [
    State::new(0.8, 0.0),
    State::new(0.56, 0.0),
    State::new(0.9, 0.0),
];

/// Options of the study of histories.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever.
    pub design: Design,
    /// Stops to run.
    #[serde(rename = "model")]
    pub models: Vec<StopModel>,
    /// Acceleration of one g [m/s²].
    pub gravity_m_s2: f64,
    /// Amplitude [g].
    pub amplitude_g: f64,
    /// Angular frequency [rad/s].
    #[serde(rename = "omega_rad_s")]
    pub angular_frequency_rad_s: f64,
    /// Initial states.
    pub starts: Vec<State>,
    /// Periods shown.
    pub periods: u32,
    /// Periods after which the motion counts as settled.
    pub transient: u32,
}

/// Lasting motion of the lever.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settled {
    /// True if it stays on the stop.
    pub rests: bool,
    /// Periods of the excitation after which the motion repeats; `None` if it does not within
    /// 64, or cannot be followed.
    pub period: Option<u32>,
    /// Largest angle [rad].
    pub peak_angle_rad: f64,
    /// Impacts in the motion's period, faster than 1e-3 rad/s.
    pub impacts: u64,
    /// Stroboscopic section: angle [rad], angular velocity [rad/s] at t = 0 mod 2π/ω.
    pub section: Vec<[f64; 2]>,
}

/// The motion from one start on one stop.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct History {
    /// Stop model.
    pub model: StopModel,
    /// Initial state.
    pub start: State,
    /// The first impacts (soft stop: contact entries), at most 200: time [s], velocity before
    /// [rad/s].
    pub impacts: Vec<[f64; 2]>,
    /// Largest angle in the last tenth of the periods shown [rad].
    pub late_peak_angle_rad: f64,
    /// Lasting motion.
    pub settled: Settled,
    /// The history.
    #[serde(skip)]
    pub trace: Vec<TracePoint>,
}

/// A row of the histories.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Stop model.
    pub stop: StopModel,
    /// Initial angle [rad].
    pub initial_angle_rad: f64,
    /// Initial angular velocity [rad/s].
    pub initial_angular_velocity_rad_s: f64,
    /// Time [s].
    pub time_s: f64,
    /// Angle [rad].
    pub angle_rad: f64,
    /// Angular velocity [rad/s].
    pub angular_velocity_rad_s: f64,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Histories {
    /// Each start on each stop, start by start.
    pub histories: Vec<History>,
    /// Period of the excitation [s].
    pub period_s: f64,
    /// Length shown [s].
    pub duration_s: f64,
    /// Amplitude of the excitation [g].
    pub amplitude_g: f64,
    /// Its angular frequency [rad/s].
    pub angular_frequency_rad_s: f64,
    /// Headline figures.
    pub headlines: Vec<Headline>,
}

/// Longest period sought.
const PERIOD_MAX: usize = 64;

/// Distance below which two sections are the same, relative to the larger of the state and the static
/// deflection.
const SAME: f64 = 1e-8;

/// Largest angle of a lever that stays on the stop [rad].
const ON_STOP: f64 = 1e-9;

/// Runs the study.
///
/// # Errors
///
/// As [`replay::run_harmonic`].
pub fn run(options: &Options) -> Result<Histories, Error> {
    let excitation = Harmonic {
        amplitude_m_s2: options.amplitude_g * options.gravity_m_s2,
        angular_frequency_rad_s: options.angular_frequency_rad_s,
        phase_rad: 0.0,
    };
    let period_s = TAU / options.angular_frequency_rad_s;
    let duration_s = f64::from(options.periods) * period_s;
    let mut histories = Vec::new();
    for start in &options.starts {
        for model in &options.models {
            histories.push(history(options, &excitation, *start, *model, duration_s)?);
        }
    }
    Ok(Histories {
        headlines: headlines(&histories),
        histories,
        period_s,
        duration_s,
        amplitude_g: options.amplitude_g,
        angular_frequency_rad_s: options.angular_frequency_rad_s,
    })
}

fn history(
    options: &Options,
    excitation: &Harmonic,
    start: State,
    model: StopModel,
    duration_s: f64,
) -> Result<History, Error> {
    let outcome = replay::run_harmonic(
        excitation,
        duration_s,
        &options.design,
        &RunOptions {
            initial: Some(start),
            trace: true,
            error_bound: false,
            ..RunOptions::new(model, OpensWhen::Negative)
        },
    )?;
    let late = 0.9 * duration_s;
    let late_peak_angle_rad = outcome
        .trace
        .iter()
        .filter(|point| point.time_s >= late)
        .map(|point| point.angle_rad)
        .fold(f64::NEG_INFINITY, f64::max);
    Ok(History {
        model,
        start,
        impacts: outcome.run.impact_list,
        late_peak_angle_rad,
        settled: settled(options, excitation, start, model)?,
        trace: outcome.trace,
    })
}

/// Follows the lever over the transient, and returns its motion after it.
fn settled(
    options: &Options,
    excitation: &Harmonic,
    start: State,
    model: StopModel,
) -> Result<Settled, Error> {
    let mut strobe = Strobe::new(&options.design, model, excitation, Some(start))?;
    let lost = Settled {
        rests: false,
        period: None,
        peak_angle_rad: f64::NAN,
        impacts: 0,
        section: Vec::new(),
    };
    for _ in 0..options.transient {
        if strobe.advance().is_none() {
            return Ok(lost);
        }
    }
    let before = strobe.state();
    let mut sections: Vec<Section> = Vec::new();
    for _ in 0..PERIOD_MAX {
        let Some(section) = strobe.advance() else {
            return Ok(lost);
        };
        sections.push(section);
        if near(before, section.state()) {
            break;
        }
    }
    let repeats = sections
        .last()
        .is_some_and(|last| near(before, last.state()));
    let peak_angle_rad = sections
        .iter()
        .map(|section| section.peak_angle_rad)
        .fold(f64::NEG_INFINITY, f64::max);
    Ok(Settled {
        rests: peak_angle_rad <= ON_STOP,
        period: if repeats {
            u32::try_from(sections.len()).ok()
        } else {
            None
        },
        peak_angle_rad,
        impacts: sections.iter().map(|section| section.impacts).sum(),
        section: sections
            .iter()
            .map(|section| [section.angle_rad, section.velocity_rad_s])
            .collect(),
    })
}

fn near(first: State, second: State) -> bool {
    let close = |a: f64, b: f64, floor: f64| (a - b).abs() <= SAME * a.abs().max(floor);
    close(first.angle_rad, second.angle_rad, 1e-3)
        && close(first.velocity_rad_s, second.velocity_rad_s, 1e-1)
}

impl Settled {
    /// Returns the motion in a few words: `rest`, or period, impacts and peak.
    pub fn words(&self) -> String {
        if self.rests {
            return "rest on the stop".into();
        }
        let impacts = if self.impacts == 1 {
            "impact"
        } else {
            "impacts"
        };
        match self.period {
            Some(period) => format!("period {period}, {} {impacts}", self.impacts),
            None => "no period up to 64".into(),
        }
    }
}

fn headlines(histories: &[History]) -> Vec<Headline> {
    let mut headlines = Vec::new();
    for history in histories {
        let settled = &history.settled;
        let mut figures = Figures::of(
            format!(
                "from ({}, {})",
                history.start.angle_rad, history.start.velocity_rad_s
            ),
            history.model,
        );
        figures.say(
            "rests in the end (1: yes) [-]",
            f64::from(u8::from(settled.rests)),
        );
        figures.say(
            "period [periods of the excitation]",
            settled.period.map(f64::from),
        );
        figures.say("impacts in it [-]", settled.impacts as f64);
        figures.say(
            "largest angle in it [rad]",
            Some(settled.peak_angle_rad).filter(|peak| peak.is_finite()),
        );
        headlines.extend(figures.lines);
    }
    headlines
}

impl Histories {
    /// Returns the histories as rows.
    pub fn rows(&self) -> impl Iterator<Item = Row> {
        self.histories.iter().flat_map(|history| {
            history.trace.iter().map(|point| Row {
                stop: history.model,
                initial_angle_rad: history.start.angle_rad,
                initial_angular_velocity_rad_s: history.start.velocity_rad_s,
                time_s: point.time_s,
                angle_rad: point.angle_rad,
                angular_velocity_rad_s: point.velocity_rad_s,
            })
        })
    }
}
