//! The free bounces of the paper's Fig. 3: exit over entry speed, bounce after bounce.
//!
//! The ratio is read in two ways. At φ = 0, corrected for spring and preload up to the nearest grid
//! points, it is the effect of the stop on the energy. From the first grid point inside to the first
//! outside, as read off the points of a phase diagram, it is larger: it misses the speed that was
//! lost inside before the first point.

use super::{
    MethodSetting, Options, Stability, StabilityCase, contact, paper_step_s, rk4, rk4_located,
    silence,
};
use crate::Headline;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::State;
use latchgate_recording::error::Error;

pub(super) const SUBJECT: &str = "bounces";

/// Start of the free vibration [rad].
const START_RAD: f64 = 0.5;

/// Number of bounces.
const BOUNCES: usize = 8;

/// Length of the run [s]: eight bounces of the reference lever and a little more.
const LENGTH_S: f64 = 0.6;

pub(super) fn run(options: &Options, answer: &mut Stability) -> Result<(), Error> {
    let design = &options.design;
    let problem = |intervals| {
        Ok::<_, Error>(StabilityCase {
            design,
            model: StopModel::Soft,
            signal: silence(LENGTH_S, intervals)?,
            initial: Some(State::new(START_RAD, 0.0)),
        })
    };
    // The kernel gets samples so close that its trace has points inside each contact. The other methods get
    // a single interval, so that their steps lie on their own grid.
    let (dense, problem) = (problem(6000)?, problem(1)?);
    let kernel = dense.ask(&MethodSetting::kernel(), true)?.trace;
    let right: Vec<f64> = contact::contacts(design, &kernel)
        .iter()
        .map(|contact| contact.at_stop)
        .collect();
    for steps in [1000, 2000, 10_000] {
        for method in [rk4, rk4_located] {
            let setting = MethodSetting::fixed(method, paper_step_s(steps));
            let compared = contact::contacts(design, &problem.ask(&setting, true)?.trace);
            for (index, right) in right.iter().take(BOUNCES).enumerate() {
                let contact = compared.get(index);
                let number = index as f64 + 1.0;
                for (quantity, value) in [
                    (
                        "exit speed over entry speed, both at φ = 0 [-]",
                        contact.map(|contact| contact.at_stop),
                    ),
                    (
                        "speed at the first point outside over that at the first inside [-]",
                        contact.map(|contact| contact.on_grid),
                    ),
                ] {
                    answer.rows.push(setting.row(
                        SUBJECT,
                        StopModel::Soft,
                        ("bounce [-]", number),
                        quantity,
                        value,
                        (*right, 0.0),
                    ));
                }
            }
        }
    }
    headlines(answer);
    Ok(())
}

/// Adds the least and the largest ratio of a bounce with the finest grid.
fn headlines(answer: &mut Stability) {
    for (what, quantity) in [
        (
            "both at φ = 0",
            "exit speed over entry speed, both at φ = 0 [-]",
        ),
        (
            "at grid points outside and inside",
            "speed at the first point outside over that at the first inside [-]",
        ),
    ] {
        let step = Some(paper_step_s(10_000));
        let ratios = || {
            answer
                .rows
                .iter()
                .filter(|row| row.subject == SUBJECT && row.method == "rk4")
                .filter(|row| row.step_s == step && row.quantity == quantity)
                .filter_map(|row| row.value)
        };
        let (least, largest) = (
            ratios().fold(f64::INFINITY, f64::min),
            ratios().fold(f64::NEG_INFINITY, f64::max),
        );
        for (which, value) in [("least", least), ("largest", largest)] {
            answer.headlines.push(Headline {
                digits: Headline::DIGITS,
                subject: SUBJECT.into(),
                model: Some(StopModel::Soft),
                what: format!("rk4 at N = 10000: {which} ratio of a bounce, {what} [-]"),
                value: value.is_finite().then_some(value),
            });
        }
    }
}
