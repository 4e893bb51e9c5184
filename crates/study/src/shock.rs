//! The paper's Fig. 11: the lever's answer to the shock of a side impact.
//!
//! The acceleration of Fig. 11a was measured by a car maker and is not public. The burst of
//! [`cases::shock`] replaces it, of the same length and peak, given by formula. The axis of the paper's
//! figure is in m/s², its text speaks of "almost A = 1000" g; the two differ by a factor of one g, so
//! both readings are answered.

use super::{Figures, Headline, cases};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, Run, RunOptions, TracePoint};
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
use latchgate_verdict::conditioning::{self, Signal};
use serde::Serialize;

/// Options of the study of a shock.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Options {
    /// The lever.
    pub design: Design,
    /// Stops to run.
    #[serde(rename = "model")]
    pub models: Vec<StopModel>,
    /// Acceleration of one g [m/s²].
    pub gravity_m_s2: f64,
    /// Approximate peak of the shock [g].
    pub amplitude_g: f64,
    /// Duration of the motion [s].
    pub duration_s: f64,
}

/// The lever's answer to one signal on one stop.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Response {
    /// Peak of the signal [m/s²].
    pub peak_acceleration_m_s2: f64,
    /// Run of the lever.
    #[serde(flatten)]
    pub run: Run,
    /// The history.
    #[serde(skip)]
    pub trace: Vec<TracePoint>,
}

/// A row of the histories.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Peak of the signal [m/s²].
    pub peak_acceleration_m_s2: f64,
    /// Stop model.
    pub stop: StopModel,
    /// Time [s].
    pub time_s: f64,
    /// Acceleration of the base [m/s²].
    pub acceleration_m_s2: f64,
    /// Angle [rad].
    pub angle_rad: f64,
    /// Angular velocity [rad/s].
    pub angular_velocity_rad_s: f64,
}

/// Result of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct Shock {
    /// The two readings of the peak: in g as in the text, in m/s² as on the axis.
    pub signals: [Signal; 2],
    /// The answers, reading by reading.
    pub responses: Vec<Response>,
    /// Threshold of the angle [rad].
    pub threshold_rad: f64,
    /// Acceleration of one g [m/s²].
    pub gravity_m_s2: f64,
    /// Length of the shock [s].
    pub shock_s: f64,
    /// Headline figures.
    pub headlines: Vec<Headline>,
}

/// Peak of the burst by its formula [g].
const PEAK_G: f64 = 1000.0;

/// Longest duration of the motion [s].
pub const DURATION_MAX_S: f64 = 100.0;

/// Replays the paper's burst with the amplitude of its text, a multiple of g, and with that of its figure's axis,
/// the same number in m/s².
///
/// # Errors
///
/// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a duration beyond 100 s; as [`replay::run`].
pub fn run(options: &Options) -> Result<Shock, Error> {
    if options.duration_s.is_nan() || options.duration_s > DURATION_MAX_S {
        return Err(Error::out_of_range(
            "duration [s]",
            format!("at most {DURATION_MAX_S}"),
            options.duration_s.to_string(),
        ));
    }
    let (text, shock_s) = burst(options, 1.0)?;
    let (axis, _) = burst(options, 1.0 / options.gravity_m_s2)?;
    let signals = [text, axis];
    let mut responses = Vec::new();
    for signal in &signals {
        for model in &options.models {
            responses.push(respond(signal, &options.design, *model)?);
        }
    }
    Ok(Shock {
        headlines: headlines(options, &responses),
        signals,
        responses,
        threshold_rad: options.design.criterion.threshold_rad,
        gravity_m_s2: options.gravity_m_s2,
        shock_s,
    })
}

/// Returns the burst times `factor`, followed by zeros up to the duration of the motion, and the length of the
/// burst [s].
fn burst(options: &Options, factor: f64) -> Result<(Signal, f64), Error> {
    let case = cases::shock(options.gravity_m_s2)?;
    let mut signal = case
        .signal()
        .cloned()
        .ok_or_else(|| Error::too_short("a replay", 2, 0))?;
    for sample in &mut signal.samples {
        *sample *= factor * options.amplitude_g / PEAK_G;
    }
    let shock_s = signal.end_s();
    let count = (options.duration_s * signal.rate.hertz()).ceil().max(0.0) as usize + 1;
    if count > signal.samples.len() {
        signal.samples.resize(count, 0.0);
    }
    Ok((signal, shock_s))
}

/// Replays a lever at rest through `signal` [m/s²], negative opening.
///
/// # Errors
///
/// As [`replay::run`].
pub fn respond(signal: &Signal, design: &Design, model: StopModel) -> Result<Response, Error> {
    let outcome = replay::run(
        signal,
        design,
        &RunOptions {
            trace: true,
            ..RunOptions::new(model, OpensWhen::Negative)
        },
    )?;
    Ok(Response {
        peak_acceleration_m_s2: conditioning::peak(signal)
            .map_or(0.0, |peak| signal.samples[peak].abs()),
        run: outcome.run,
        trace: outcome.trace,
    })
}

fn headlines(options: &Options, responses: &[Response]) -> Vec<Headline> {
    let mut headlines = Vec::new();
    for response in responses {
        let run = &response.run;
        let mut figures = Figures::of(
            format!(
                "peak {} g",
                latchgate_kernel::units::plain(
                    response.peak_acceleration_m_s2 / options.gravity_m_s2,
                    4
                )
            ),
            run.model,
        );
        figures.say("peak acceleration [m/s²]", response.peak_acceleration_m_s2);
        figures.say("peak angle [rad]", run.peak_angle_rad);
        figures.say("bound on its error [rad]", run.numerical_error_rad);
        figures.say("when [s]", run.peak_time_s);
        figures.say("threshold crossed first [s]", run.first_crossing_s);
        figures.say("first release [s]", run.first_release_s);
        figures.say("impacts [-]", run.impacts as f64);
        headlines.extend(figures.lines);
    }
    headlines
}

impl Shock {
    /// Returns the histories as rows.
    pub fn rows(&self) -> impl Iterator<Item = Row> {
        let per_signal = self.responses.len() / self.signals.len();
        self.responses
            .iter()
            .enumerate()
            .flat_map(move |(index, response)| {
                let signal = &self.signals[(index / per_signal.max(1)).min(1)];
                response.trace.iter().map(move |point| Row {
                    peak_acceleration_m_s2: response.peak_acceleration_m_s2,
                    stop: response.run.model,
                    time_s: point.time_s,
                    acceleration_m_s2: value_at(signal, point.time_s),
                    angle_rad: point.angle_rad,
                    angular_velocity_rad_s: point.velocity_rad_s,
                })
            })
    }
}

/// Returns the signal at an instant, linear between samples, zero outside.
fn value_at(signal: &Signal, time_s: f64) -> f64 {
    let place = (time_s - signal.start_s) * signal.rate.hertz();
    if place.is_nan() || place < 0.0 {
        return 0.0;
    }
    let index = place as usize;
    match (signal.samples.get(index), signal.samples.get(index + 1)) {
        (Some(from), Some(to)) => from + place.fract() * (to - from),
        (Some(last), None) => *last,
        _ => 0.0,
    }
}
