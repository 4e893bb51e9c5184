//! Situations with an event inside a sample or a step.

use super::{MethodSetting, Options, Stability, StabilityCase};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::pulse::Pulse;
use latchgate_kernel::replay::State;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::SampleRate;
use latchgate_recording::error::Error;
use std::f64::consts::TAU;

/// A situation: name, stops that it applies to, and the excitation with its start.
struct Situation {
    subject: &'static str,
    models: &'static [StopModel],
    signal: Signal,
    initial: Option<State>,
}

const BOTH: &[StopModel] = &[StopModel::Rigid, StopModel::Soft];
const RIGID: &[StopModel] = &[StopModel::Rigid];
const SOFT: &[StopModel] = &[StopModel::Soft];

/// Names of the situations, in the order of the study.
pub const SUBJECTS: [&str; 9] = [
    "release-and-landing-inside-samples",
    "spike-of-one-sample",
    "torque-changes-sign-inside-samples",
    "contact-shorter-than-a-sample",
    "contacts-under-strong-excitation",
    "several-impacts-in-a-step",
    "jumps-between-samples",
    "beyond-a-right-angle",
    "late-on-the-clock",
];

pub(super) fn run(options: &Options, answer: &mut Stability) -> Result<(), Error> {
    for situation in situations(options)? {
        for &model in situation.models {
            let problem = StabilityCase {
                design: &options.design,
                model,
                signal: situation.signal.clone(),
                initial: situation.initial,
            };
            let truth = problem.ask(&MethodSetting::kernel(), false)?.run;
            let impacts = truth.impacts as f64;
            for setting in MethodSetting::usual(model) {
                let outcome = problem.ask(&setting, false)?;
                let run = &outcome.run;
                let sound = !outcome.broke_down;
                answer.rows.push(setting.row(
                    situation.subject,
                    model,
                    ("", 0.0),
                    "peak angle [rad]",
                    sound.then_some(run.peak_angle_rad),
                    (truth.peak_angle_rad, truth.numerical_error_rad),
                ));
                let counted = run.impacts as f64;
                answer.rows.push(setting.row(
                    situation.subject,
                    model,
                    ("", 0.0),
                    "impacts faster than 1e-3 rad/s [-]",
                    sound.then_some(counted),
                    (impacts, 0.0),
                ));
            }
        }
    }
    Ok(())
}

fn situations(options: &Options) -> Result<Vec<Situation>, Error> {
    let g = options.gravity_m_s2;
    // Amplitudes are multiples of the lift-off, so that a lever of any preload leaves the stop.
    let lift_off = options.design.lever.lift_off_acceleration_m_s2();
    let sampled = |rate_hz: f64, last: u32, formula: &dyn Fn(u32, f64) -> f64| {
        Ok::<Signal, Error>(Signal {
            start_s: 0.0,
            rate: SampleRate::from_hertz(rate_hz)?,
            samples: (0..=last)
                .map(|index| formula(index, f64::from(index) / rate_hz))
                .collect(),
        })
    };
    let half_sine = |amplitude: f64, duration_s: f64| {
        let pulse = Pulse::HalfSine {
            peak: -amplitude,
            duration_s,
        };
        move |_: u32, t: f64| pulse.at(t)
    };
    let mut late = sampled(10_000.0, 1000, &half_sine(30.0 * g, 0.011))?;
    // At 1e6 s, eleven days, a double resolves 1e-10 s.
    late.start_s = 1e6;
    let signals = [
        (
            BOTH,
            sampled(1000.0, 50, &|index, _| {
                if index == 2 { -20.0 * lift_off } else { 0.0 }
            })?,
            None,
        ),
        (
            BOTH,
            sampled(20_000.0, 100, &|index, _| {
                if index == 2 { -20.0 * lift_off } else { 0.0 }
            })?,
            None,
        ),
        (
            RIGID,
            sampled(1000.0, 50, &|index, _| {
                -lift_off * if index % 2 == 0 { 1.05 } else { 0.9 }
            })?,
            None,
        ),
        (
            SOFT,
            sampled(500.0, 500, &half_sine(30.0 * g, 0.011))?,
            None,
        ),
        (
            BOTH,
            sampled(500.0, 150, &|_, t| {
                if t < 0.1 {
                    -30.0 * g * libm::sin(TAU * 90.0 * t)
                } else {
                    0.0
                }
            })?,
            None,
        ),
        // From 1e-5 rad the bounces of the reference lever are over within 4 ms.
        (
            RIGID,
            sampled(100.0, 2, &|_, _| 0.0)?,
            Some(State::new(1e-5, 0.0)),
        ),
        (
            BOTH,
            sampled(1000.0, 60, &|index, _| match index {
                5..=9 => -50.0 * g,
                10..=14 => 50.0 * g,
                _ => 0.0,
            })?,
            None,
        ),
        (
            BOTH,
            sampled(10_000.0, 1500, &half_sine(100.0 * g, 0.035))?,
            None,
        ),
        (BOTH, late, None),
    ];
    Ok(SUBJECTS
        .into_iter()
        .zip(signals)
        .map(|(subject, (models, signal, initial))| Situation {
            subject,
            models,
            signal,
            initial,
        })
        .collect())
}
