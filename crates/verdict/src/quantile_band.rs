//! How members of an ensemble spread around the nominal trajectory.

use super::ensemble::Scatter;
use super::ensemble::drivers::quantile;
use super::policy::Variant;
use super::runs::{RunDetail, RunSetup};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::TracePoint;
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;

/// Quantiles of the angle at each instant, of the first members of an ensemble.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantileBand {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// Members that it shows, the nominal one included.
    pub members: usize,
    /// Instants [s].
    pub time_s: Vec<f64>,
    /// Five in a hundred lie below [rad].
    pub p05: Vec<f64>,
    /// The median [rad].
    pub p50: Vec<f64>,
    /// Five in a hundred lie above [rad].
    pub p95: Vec<f64>,
}

/// Members shown of a recording of ordinary length.
const MEMBERS_MAX: usize = 64;

/// Members shown of the longest recording.
const MEMBERS_MIN: usize = 16;

/// Samples of all members together that are run for the drawing's sake.
const SAMPLES_RUN: usize = 1_500_000;

/// Instants of the band.
const INSTANTS: u32 = 480;

/// Runs the first members of a variant's ensemble again, by the scalar kernel, for their
/// trajectories; `None` if fewer than two could be followed.
pub(super) fn around(
    setup: &RunSetup<'_>,
    scatter: &Scatter,
    variant: Variant,
) -> Result<Option<QuantileBand>, Error> {
    let signal = setup.signal;
    let last = setup
        .window
        .map_or(signal.samples.len() - 1, |(_, last)| last);
    let (start, end) = (signal.start_s, signal.time_s(last));
    let time_s: Vec<f64> = (0..=INSTANTS)
        .map(|index| start + (end - start) * f64::from(index) / f64::from(INSTANTS))
        .collect();
    let member_limit = usize::try_from(setup.policy.members).unwrap_or(usize::MAX);
    let shown = (SAMPLES_RUN / signal.samples.len().max(1))
        .clamp(MEMBERS_MIN, MEMBERS_MAX)
        .min(member_limit);
    let members: Vec<u32> = (0..).take(shown).collect();
    let reading = setup.readings.own()?;
    let paths = setup.share(1, &members, |index| {
        let member = scatter.lever(*index);
        let second = member.second;
        let scaled = reading
            .scaled(member.scale, member.bias_m_s2)
            .with_second_scaled(second.scale, second.bias_m_s2);
        let design = Design {
            lever: member.lever,
            stop: member.stop,
            catch: member.catch,
            ..setup.design.clone()
        };
        let drawn = RunSetup {
            design: &design,
            ..*setup
        };
        let outcome = drawn.run_by_kernel(&scaled, variant, setup.window, RunDetail::Path)?;
        Ok((!outcome.broke_down).then(|| sampled(&outcome.trace, &time_s)))
    })?;
    let followed: Vec<Vec<f64>> = paths.into_iter().flatten().collect();
    if followed.len() < 2 {
        return Ok(None);
    }
    let mut column = vec![0.0; followed.len()];
    let mut band = QuantileBand {
        model: variant.model,
        opens_when: variant.opens_when,
        members: followed.len(),
        p05: Vec::with_capacity(time_s.len()),
        p50: Vec::with_capacity(time_s.len()),
        p95: Vec::with_capacity(time_s.len()),
        time_s,
    };
    for index in 0..band.time_s.len() {
        for (value, path) in column.iter_mut().zip(&followed) {
            *value = path[index];
        }
        column.sort_unstable_by(f64::total_cmp);
        band.p05.push(quantile(&column, 0.05));
        band.p50.push(quantile(&column, 0.50));
        band.p95.push(quantile(&column, 0.95));
    }
    Ok(Some(band))
}

/// Returns the angle at each instant, on straight lines between the points of a trajectory.
fn sampled(trace: &[TracePoint], instants: &[f64]) -> Vec<f64> {
    let mut next = 0;
    instants
        .iter()
        .map(|instant| {
            while next < trace.len() && trace[next].time_s < *instant {
                next += 1;
            }
            match (next.checked_sub(1).map(|i| trace[i]), trace.get(next)) {
                (Some(a), Some(b)) if b.time_s > a.time_s => {
                    let share = (instant - a.time_s) / (b.time_s - a.time_s);
                    a.angle_rad + share * (b.angle_rad - a.angle_rad)
                }
                (_, Some(point)) => point.angle_rad,
                (Some(point), None) => point.angle_rad,
                (None, None) => 0.0,
            }
        })
        .collect()
}
