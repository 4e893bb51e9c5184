//! One contact with the soft stop: the exit speed by a fixed step.

use super::{MethodSetting, Options, Stability, StabilityCase, paper_step_s, rk4, rk4_located};
use super::{silence, speed_at_stop};
use crate::Headline;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::{State, TracePoint};
use latchgate_recording::error::Error;

pub(super) const SUBJECT: &str = "contact";

/// Speed of entry [rad/s]: that of the first impact of the paper's Fig. 3.
const ENTRY_SPEED: f64 = 14.7;

/// Phases of entry within a step.
const PHASES: u32 = 16;

/// Least and largest contact angular frequency times step.
const REACH: Range = Range::new(0.01, 5.0);

pub(super) fn run(options: &Options, answer: &mut Stability) -> Result<(), Error> {
    let design = &options.design;
    let frequency = answer.contact_frequency_rad_s;
    let right = ratio(design, &MethodSetting::kernel(), 0.0, frequency)?.unwrap_or(f64::NAN);
    answer.right_ratio = right;
    let last = f64::from(options.points - 1);
    let mut reaches: Vec<f64> = (0..options.points)
        .map(|index| REACH.low * libm::pow(REACH.high / REACH.low, f64::from(index) / last))
        .collect();
    reaches.extend(super::PAPER_STEPS.map(|steps| frequency * paper_step_s(steps)));
    reaches.sort_unstable_by(f64::total_cmp);
    for reach in reaches {
        let step = reach / frequency;
        for phase in 0..PHASES {
            let phase = (f64::from(phase) + 0.5) / f64::from(PHASES);
            for method in [rk4, rk4_located] {
                let setting = MethodSetting::fixed(method, step);
                let value = ratio(design, &setting, phase, frequency)?;
                answer.rows.push(setting.row(
                    SUBJECT,
                    StopModel::Soft,
                    ("phase of entry [-]", phase),
                    "exit speed over entry speed, both at φ = 0 [-]",
                    value,
                    (right, 0.0),
                ));
            }
        }
    }
    let mut say = |what: &str, value: f64| {
        answer.headlines.push(Headline {
            digits: Headline::DIGITS,
            subject: SUBJECT.into(),
            model: Some(StopModel::Soft),
            what: what.into(),
            value: Some(value),
        });
    };
    say(
        "ω_R times step beyond which |R(z)| > 1 for rk4 [-]",
        answer.contact_limit,
    );
    say("exit speed over entry speed, right [-]", right);
    for steps in super::PAPER_STEPS {
        let reach = frequency * paper_step_s(steps);
        say(&format!("ω_R times step at N = {steps} [-]"), reach);
    }
    // The error of the paper's step depends on the phase of entry.
    let step = paper_step_s(10_000);
    let ratios: Vec<f64> = answer
        .rows
        .iter()
        .filter(|row| row.method == "rk4" && row.step_s == Some(step))
        .filter_map(|row| row.value)
        .collect();
    if !ratios.is_empty() {
        say(
            "rk4 at N = 10000: least ratio over the phases of entry [-]",
            ratios.iter().copied().fold(f64::INFINITY, f64::min),
        );
        say(
            "rk4 at N = 10000: largest ratio over the phases of entry [-]",
            ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        );
    }
    Ok(())
}

/// Returns exit speed over entry speed of one contact that begins at `phase` of a step; `None` if the lever does
/// not leave the stop.
fn ratio(
    design: &Design,
    setting: &MethodSetting,
    phase: f64,
    frequency: f64,
) -> Result<Option<f64>, Error> {
    let step = setting.step_s.unwrap_or(0.1 / frequency);
    let angle = phase * step * ENTRY_SPEED;
    // The run covers the entry, one and a half contacts, and a few steps after the exit.
    let length = angle / ENTRY_SPEED + 1.5 * std::f64::consts::PI / frequency + 4.0 * step;
    let intervals = if setting.step_s.is_some() { 1 } else { 16 };
    let problem = StabilityCase {
        design,
        model: StopModel::Soft,
        signal: silence(length, intervals)?,
        initial: Some(State::new(angle, -ENTRY_SPEED)),
    };
    let outcome = problem.ask(setting, true)?;
    let mut points = vec![TracePoint {
        time_s: 0.0,
        angle_rad: angle,
        velocity_rad_s: -ENTRY_SPEED,
    }];
    points.extend(outcome.trace);
    Ok(contacts(design, &points)
        .first()
        .map(|contact| contact.at_stop))
}

/// Change of speed in one contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpeedRatio {
    /// Exit speed over entry speed, both taken to φ = 0 [-].
    pub(crate) at_stop: f64,
    /// Speed at the first point outside over that at the first point inside [-].
    pub(crate) on_grid: f64,
}

/// Returns the change of speed in each contact of a trace.
pub(crate) fn contacts(design: &Design, points: &[TracePoint]) -> Vec<SpeedRatio> {
    let mut contacts = Vec::new();
    let mut entry = None;
    for pair in points.windows(2) {
        let (before, now) = (pair[0], pair[1]);
        if now.angle_rad < 0.0 && before.angle_rad >= 0.0 {
            let at_stop = speed_at_stop(design, before.angle_rad, before.velocity_rad_s);
            entry = Some((at_stop, now.velocity_rad_s));
        } else if now.angle_rad >= 0.0
            && before.angle_rad < 0.0
            && let Some((at_stop, inside)) = entry.take()
        {
            let exit = speed_at_stop(design, now.angle_rad, now.velocity_rad_s);
            contacts.push(SpeedRatio {
                at_stop: exit / -at_stop,
                on_grid: now.velocity_rad_s / -inside,
            });
        }
    }
    contacts
}
