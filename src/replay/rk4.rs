//! The paper's way: Runge-Kutta of fourth order with a fixed step, events on its own grid.
//!
//! Kept to be compared with, not to be trusted: an impact is seen only at the end of the
//! step in which it happened, a lever on a rigid stop never quite rests, and a soft stop
//! whose frequency times the step exceeds 2√2 makes the run explode.

use super::tally::{COUNTED_SPEED, LISTED_IMPACTS};
use super::{RunOptions, TracePoint, Work};
use crate::conditioning::Signal;
use crate::model::design::Design;
use crate::model::stop::StopModel;
use crate::numerics::{Motion, rk4};

/// What a fixed-step run gives.
#[derive(Debug, Clone)]
pub(super) struct FixedStepRun {
    pub(super) peak: (f64, f64),
    pub(super) first_crossing: Option<f64>,
    pub(super) time_above: f64,
    pub(super) first_release: Option<f64>,
    pub(super) impacts: u64,
    pub(super) impact_list: Vec<[f64; 2]>,
    pub(super) state: (f64, f64),
    pub(super) work: Work,
    pub(super) trace: Vec<TracePoint>,
}

/// Equations (2.1) and (2.2) with the excitation of a recording.
struct LeverMotion<'a> {
    signal: &'a Signal,
    sign: f64,
    pressing: f64,
    gain: f64,
    free: (f64, f64),
    contact: (f64, f64),
}

impl LeverMotion<'_> {
    fn excitation(&self, t: f64) -> f64 {
        let place = (t - self.signal.start_s) * self.signal.rate.hertz();
        if place < 0.0 {
            return 0.0;
        }
        let index = place as usize;
        let samples = &self.signal.samples;
        match (samples.get(index), samples.get(index + 1)) {
            #[expect(clippy::cast_precision_loss, reason = "indices stay far below 2^53")]
            (Some(from), Some(to)) => from + (to - from) * (place - index as f64),
            (Some(last), None) if place <= samples.len() as f64 - 1.0 + 1e-9 => *last,
            _ => 0.0,
        }
    }
}

impl Motion for LeverMotion<'_> {
    fn acceleration(&self, t: f64, q: f64, v: f64) -> f64 {
        let (damping, stiffness) = if q < 0.0 { self.contact } else { self.free };
        -self.pressing
            - damping * v
            - stiffness * q
            - self.gain * self.sign * self.excitation(t) * libm::cos(q)
    }
}

/// Returns the step of the fixed-step method [s]: natural period 2π/ω0 over the steps per
/// period.
#[must_use]
pub fn step_seconds(design: &Design, steps_per_period: u32) -> f64 {
    std::f64::consts::TAU
        / design.lever.angular_frequency_rad_s()
        / f64::from(steps_per_period.max(1))
}

/// Runs with `steps_per_period` steps in a natural period.
pub(super) fn run(
    signal: &Signal,
    design: &Design,
    stop: StopModel,
    options: &RunOptions,
    steps_per_period: u32,
    last: usize,
) -> FixedStepRun {
    let inertia = design.lever.moment_of_inertia_kg_m2;
    let free = (
        design.lever.pivot_damping_nm_s_per_rad / inertia,
        design.lever.spring_stiffness_nm_per_rad / inertia,
    );
    let motion = LeverMotion {
        signal,
        sign: options.opens_when.sign(),
        pressing: design.lever.preload_torque_nm / inertia,
        gain: design.lever.unbalance_kg_m() / inertia,
        free,
        contact: match stop {
            StopModel::Rigid => free,
            StopModel::Soft => (
                design.stop.contact_damping_nm_s_per_rad(&design.lever) / inertia,
                design.stop.contact_stiffness_nm_per_rad(&design.lever) / inertia,
            ),
        },
    };
    let (mut q, mut v) = options.initial.unwrap_or(match stop {
        StopModel::Rigid => (0.0, 0.0),
        StopModel::Soft => (design.stop.rest_angle_rad(&design.lever), 0.0),
    });
    let (start, end) = (signal.start_s, signal.time_s(last));
    let judged_from = options
        .window
        .map_or(start, |(from, _)| signal.time_s(from));
    let step = step_seconds(design, steps_per_period);
    let threshold = design.criterion.threshold_rad;
    let mut result = FixedStepRun {
        peak: if judged_from <= start {
            (q, start)
        } else {
            (f64::NEG_INFINITY, start)
        },
        first_crossing: (judged_from <= start && q > threshold).then_some(start),
        time_above: 0.0,
        first_release: (q > 0.0).then_some(start),
        impacts: 0,
        impact_list: Vec::new(),
        state: (q, v),
        work: Work::default(),
        trace: vec![],
    };
    let steps = ((end - start) / step).ceil() as u64;
    let keep_every = (steps / 20_000).max(1);
    for k in 0..steps {
        #[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
        let t = start + k as f64 * step;
        let h = step.min(end - t);
        if h <= 0.0 {
            break;
        }
        let before = (q, v);
        (q, v) = rk4::step(&motion, t, h, q, v);
        let now = t + h;
        result.work.steps += 1;
        result.work.rhs += rk4::STAGES;
        if stop == StopModel::Rigid && q < 0.0 {
            q = 0.0;
            if v < 0.0 {
                count(&mut result, now, v);
                v *= -design.stop.restitution;
            }
        } else if stop == StopModel::Soft && q < 0.0 && before.0 >= 0.0 {
            count(&mut result, now, v);
        }
        if q > 0.0 && result.first_release.is_none() {
            result.first_release = Some(now);
        }
        if now >= judged_from {
            if q > result.peak.0 {
                result.peak = (q, now);
            }
            if q > threshold {
                result.first_crossing.get_or_insert(now);
                result.time_above += h;
            }
        }
        if options.trace && k % keep_every == 0 {
            result.trace.push(TracePoint {
                time_s: now,
                angle_rad: q,
                velocity_rad_s: v,
            });
        }
        if !q.is_finite() || !v.is_finite() {
            break;
        }
    }
    result.state = (q, v);
    result
}

fn count(result: &mut FixedStepRun, time: f64, velocity: f64) {
    result.work.events += 1;
    if velocity.abs() > COUNTED_SPEED {
        result.impacts += 1;
        if result.impact_list.len() < LISTED_IMPACTS {
            result.impact_list.push([time, velocity]);
        }
    }
}
