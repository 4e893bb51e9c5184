//! Signal, velocity and trajectories on one time axis, sample by sample.

use super::Trace;
use crate::conditioning::{Signal, velocity_m_s};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::TracePoint;
use latchgate_kernel::units::OpensWhen;

/// Signal, velocity and trajectories at the samples of the signal as used.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SampledSeries {
    /// Instants [s].
    pub time_s: Vec<f64>,
    /// The acceleration as recorded [m/s²], on straight lines between its samples.
    pub recorded_m_s2: Vec<f64>,
    /// The acceleration as used [m/s²].
    pub used_m_s2: Vec<f64>,
    /// ∫a dt of the acceleration as used, from its first sample on [m/s].
    pub velocity_m_s: Vec<f64>,
    /// What each run did.
    pub runs: Vec<SeriesRun>,
}

/// What one run did, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesRun {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Angle [rad].
    pub angle_rad: Vec<f64>,
    /// Angular velocity [rad/s].
    pub velocity_rad_s: Vec<f64>,
}

impl SampledSeries {
    /// Lays recording and trajectories on the samples of `used`; of a trajectory, on straight lines
    /// between its points.
    pub fn of(raw: &Signal, used: &Signal, traces: &[Trace]) -> Self {
        let time_s: Vec<f64> = (0..used.samples.len())
            .map(|index| used.time_s(index))
            .collect();
        let runs = traces.iter().map(|trace| {
            let resampled = |value: fn(&TracePoint) -> f64| {
                let points = trace.points.iter();
                on_lines(points.map(|point| (point.time_s, value(point))), &time_s)
            };
            SeriesRun {
                model: trace.model,
                opens_when: trace.opens_when,
                angle_rad: resampled(|point| point.angle_rad),
                velocity_rad_s: resampled(|point| point.velocity_rad_s),
            }
        });
        let samples = raw.samples.iter().enumerate();
        let recorded = samples.map(|(index, value)| (raw.time_s(index), *value));
        Self {
            recorded_m_s2: on_lines(recorded, &time_s),
            used_m_s2: used.samples.clone(),
            velocity_m_s: velocity_m_s(used),
            runs: runs.collect(),
            time_s,
        }
    }
}

/// Returns the value at each instant on straight lines between points in order of time; before
/// the first and after the last, that point's own.
fn on_lines(points: impl Iterator<Item = (f64, f64)>, instants: &[f64]) -> Vec<f64> {
    let mut points = points.peekable();
    let mut before: Option<(f64, f64)> = None;
    instants
        .iter()
        .map(|instant| {
            while let Some(point) = points.next_if(|point| point.0 <= *instant) {
                before = Some(point);
            }
            match (before, points.peek()) {
                (Some(a), Some(b)) if *instant > a.0 => {
                    a.1 + (instant - a.0) / (b.0 - a.0) * (b.1 - a.1)
                }
                (Some(point), _) => point.1,
                (None, Some(point)) => point.1,
                (None, None) => 0.0,
            }
        })
        .collect()
}
