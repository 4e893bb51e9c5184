//! Grazing: a lever that touches the rigid stop with no speed. An error δ that adds a depth d becomes an
//! impact of speed √(2 a d), so δ grows to its square root.

use super::{MethodSetting, Options, Stability, StabilityCase};
use crate::{Headline, fitted_order};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::{Excitation, Sampled};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::numerics::{Motion, rk4};
use latchgate_kernel::replay::State;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::SampleRate;
use latchgate_recording::error::Error;
use latchgate_report::plot::chart::Point;
use std::ops::RangeInclusive;

pub(super) const SUBJECT: &str = "graze";

/// Sample rate [Hz].
const RATE_HZ: f64 = 100_000.0;

/// Sample at which the lever touches with no speed.
const TOUCH: u32 = 500;

/// Last sample.
const LAST: u32 = 1200;

/// Start farthest from the stop that counts as flight [rad].
const FARTHEST_RAD: f64 = 10.0;

/// Amplitude [g]; a(t) = −A g sin(100 t + 1).
const AMPLITUDE_G: f64 = 5.0;

/// Changes of speed whose growth is a headline [rad/s], with room for the rounding of powers.
const LOOKED_AT: RangeInclusive<f64> = 0.99e-9..=1.01e-5;

pub(super) fn run(options: &Options, answer: &mut Stability) -> Result<(), Error> {
    let design = &options.design;
    let amplitude = AMPLITUDE_G * options.gravity_m_s2;
    let signal = Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(RATE_HZ)?,
        samples: (0..=LAST)
            .map(|index| -amplitude * libm::sin(100.0 * f64::from(index) / RATE_HZ + 1.0))
            .collect(),
    };
    let start = before_touch(design, &signal);
    let (angle, velocity) = (start.angle_rad, start.velocity_rad_s);
    if !(0.0..=FARTHEST_RAD).contains(&angle) || !velocity.is_finite() {
        // The motion backwards in time meets the stop or diverges: this excitation cannot bring this lever
        // to a touch without speed.
        return Ok(());
    }
    let exponents = (3..=12).rev().map(|n| -n);
    let changes: Vec<f64> = exponents
        .clone()
        .map(|n| -libm::pow(10.0, f64::from(n)))
        .chain(exponents.rev().map(|n| libm::pow(10.0, f64::from(n))))
        .collect();
    for model in [StopModel::Rigid, StopModel::Soft] {
        let ask = |change: f64, setting: &MethodSetting| {
            let problem = StabilityCase {
                design,
                model,
                signal: signal.clone(),
                initial: Some(State::new(angle, velocity + change)),
            };
            problem.ask(setting, false)
        };
        let mut steepest: f64 = 0.0;
        let mut grown = Vec::new();
        let unchanged = ask(0.0, &MethodSetting::kernel())?.run.final_angle_rad;
        for &change in &changes {
            let truth = ask(change, &MethodSetting::kernel())?.run;
            // The peak lies at the end, so that its bound is that of the angle there.
            let right = (truth.final_angle_rad, truth.numerical_error_rad);
            if LOOKED_AT.contains(&change.abs()) {
                let moved = (right.0 - unchanged).abs();
                steepest = steepest.max(moved / change.abs());
                // Only a change towards the stop makes an impact; with the other sign the lever misses it.
                if change < 0.0 {
                    grown.push(Point::new(-change, moved));
                }
            }
            for setting in MethodSetting::usual(model) {
                let outcome = ask(change, &setting)?;
                let value = (!outcome.broke_down).then_some(outcome.run.final_angle_rad);
                answer.rows.push(setting.row(
                    SUBJECT,
                    model,
                    ("change of the initial velocity [rad/s]", change),
                    "angle at the end [rad]",
                    value,
                    right,
                ));
            }
        }
        answer.headlines.push(Headline {
            digits: Headline::DIGITS,
            subject: SUBJECT.into(),
            model: Some(model),
            what: "largest growth of a change of 1e-5 to 1e-9 rad/s until the end [s]".into(),
            value: Some(steepest),
        });
        answer.headlines.push(Headline {
            digits: Headline::DIGITS,
            subject: SUBJECT.into(),
            model: Some(model),
            what: "order of that growth for changes towards the stop, fitted [-]".into(),
            value: fitted_order(&grown),
        });
    }
    Ok(())
}

/// The lever's flight run backwards from the instant at which it touches.
struct Backwards<'a> {
    design: &'a Design,
    excitation: Sampled<'a>,
    touch_s: f64,
}

impl Motion for Backwards<'_> {
    fn acceleration(&self, t: f64, q: f64, v: f64) -> f64 {
        let lever = &self.design.lever;
        let push = lever.unbalance_kg_m() * self.excitation.acceleration(self.touch_s - t);
        -(lever.preload_torque_nm + lever.spring_stiffness_nm_per_rad * q
            - lever.pivot_damping_nm_s_per_rad * v
            + push * libm::cos(q))
            / lever.moment_of_inertia_kg_m2
    }
}

/// Returns the state at time 0 from which the lever reaches (0, 0) at sample [`TOUCH`].
fn before_touch(design: &Design, signal: &Signal) -> State {
    /// Steps in a sample; the error of fourth order is far below rounding.
    const STEPS: u32 = 4;
    let motion = Backwards {
        design,
        excitation: Sampled::straight(signal, 1.0),
        touch_s: signal.time_s(TOUCH as usize),
    };
    let step = 1.0 / (RATE_HZ * f64::from(STEPS));
    let (mut q, mut v) = (0.0, 0.0);
    for index in 0..TOUCH * STEPS {
        (q, v) = rk4::step(&motion, f64::from(index) * step, step, q, v);
    }
    State::new(q, -v)
}
