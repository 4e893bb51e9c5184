//! Chatter: infinitely many bounces that end at a finite time, on a rigid stop.

use super::{
    MethodSetting, Options, Stability, StabilityCase, moreau_jean, paper_step_s, rk4, rk4_located,
    silence,
};
use crate::Headline;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{State, TracePoint};
use latchgate_recording::error::Error;

pub(super) const SUBJECT: &str = "chatter";

/// Start of the free vibration [rad].
const START_RAD: f64 = 0.5;

/// Length of the run [s].
const LENGTH_S: f64 = 1.0;

/// Largest speed of a lever at rest [rad/s].
const RESTING: f64 = 1e-12;

/// Steps per period of 20 rad/s.
const STEPS: [u32; 5] = [1000, 3000, 10_000, 30_000, 100_000];

/// Tolerances of the adaptive pair.
const TOLERANCES: [f64; 5] = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12];

pub(super) fn run(options: &Options, answer: &mut Stability) -> Result<(), Error> {
    let problem = StabilityCase {
        design: &options.design,
        model: StopModel::Rigid,
        signal: silence(LENGTH_S, 1000)?,
        initial: Some(State::new(START_RAD, 0.0)),
    };
    let Some(right) = rest_time(&problem.ask(&MethodSetting::kernel(), true)?.trace) else {
        // A lever that does not come to rest within the run has no end of chatter to compare.
        return Ok(());
    };
    answer.headlines.push(Headline {
        digits: Headline::DIGITS,
        subject: SUBJECT.into(),
        model: Some(StopModel::Rigid),
        what: "event-driven: accumulation time of free bounces from 0.5 rad [s]".into(),
        value: Some(right),
    });
    let mut settings = Vec::new();
    for at_samples in [true, false] {
        settings.extend(TOLERANCES.map(|tolerance| MethodSetting::adaptive(at_samples, tolerance)));
    }
    for method in [rk4_located, rk4, moreau_jean] {
        settings.extend(STEPS.map(|steps| MethodSetting::fixed(method, paper_step_s(steps))));
    }
    for setting in settings {
        let value = rest_time(&problem.ask(&setting, true)?.trace);
        let variable = setting
            .step_s
            .map_or(("tolerance [rad]", setting.tolerance_rad), |step| {
                ("step [s]", Some(step))
            });
        answer.rows.push(setting.row(
            SUBJECT,
            StopModel::Rigid,
            (variable.0, variable.1.unwrap_or(0.0)),
            "time of rest [s]",
            value,
            // The kernel sums the last bounces to second order, hence the bound.
            (right, 1e-12),
        ));
    }
    Ok(())
}

/// Returns the instant from which the lever rests.
fn rest_time(points: &[TracePoint]) -> Option<f64> {
    let moving = points
        .iter()
        .rposition(|point| point.velocity_rad_s.abs() > RESTING)?;
    points.get(moving + 1).map(|point| point.time_s)
}
