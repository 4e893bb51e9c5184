//! Findings of a lever with an axis: whose door opens, and what a single channel leaves out.

use super::decision::VariantRun;
use super::in_plane::InPlane;
use super::policy::Variant;
use super::runs::RunSetup;
use crate::conditioning::{Conditioned, Neighbour, between};
use latchgate_kernel::replay::{self, Method, RunOptions};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, plain};
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

/// Code of the finding that one channel leaves out a part of what drives a lever with an axis.
pub(super) const LEFT_OUT: &str = "radial-left-out";

/// Returns what two in-plane axes, or the lack of a second, give cause to say.
pub(super) fn plane_findings(
    setup: &RunSetup<'_>,
    conditioned: &Conditioned,
    runs: &[&VariantRun],
    is_pass: bool,
) -> Result<Vec<Finding>, Error> {
    let lever = &setup.design.lever;
    if lever.directions().is_none() {
        return Ok(Vec::new());
    }
    if conditioned.second.is_none() {
        return Ok(vec![left_out(setup, conditioned, runs, is_pass)?]);
    }
    let in_plane = InPlane::of(lever)?;
    let door = |opens_when: &OpensWhen| {
        let text = format!(
            "With the signs of SAE J211 {} acceleration opens the {} door. If the recording is of the other one, change the setting `opens_when`.",
            opens_when.name(),
            in_plane.door(*opens_when)
        );
        Finding::info("in-plane-door", text)
    };
    Ok(setup.policy.polarity.signs().iter().map(door).collect())
}

/// Says what one channel leaves out of a lever with an axis, and whether that could take a pass.
fn left_out(
    setup: &RunSetup<'_>,
    conditioned: &Conditioned,
    runs: &[&VariantRun],
    is_pass: bool,
) -> Result<Finding, Error> {
    let limit = setup.threshold_rad();
    let part = libm::sin(limit.min(FRAC_PI_2));
    let mut text = format!(
        "The design states an axis, the recording is one channel: acceleration along the lever's arm was left out. At the limit angle it counts with {:.0} % of its size.",
        100.0 * part
    );
    let axis = InPlane::of(&setup.design.lever).map_or('X', |in_plane| in_plane.second_axis);
    let beside = conditioned
        .neighbours
        .iter()
        .find(|neighbour| neighbour.axis == axis);
    if let Some(Neighbour {
        name, peak_m_s2, ..
    }) = beside
    {
        let in_g = |a: f64| plain(a / STANDARD_GRAVITY, 1);
        text += &format!(
            " {name} reaches {} g, which acts like {} g there.",
            in_g(*peak_m_s2),
            in_g(part * peak_m_s2)
        );
        if is_pass && could_take(setup, runs, *peak_m_s2)? {
            text += " That much along the arm, all the time, would open the lever: this pass hangs on what was left out.";
        }
        text += &format!(" Name it with the setting `radial_channel` = {name}.");
    } else if is_pass {
        text += " How large it was is not known, and this pass is without it.";
    }
    Ok(Finding::warning(LEFT_OUT, text))
}

/// Tells whether a nominal lever would open under a constant acceleration along its arm, outwards.
fn could_take(setup: &RunSetup<'_>, runs: &[&VariantRun], peak_m_s2: f64) -> Result<bool, Error> {
    // Of an inertia catch no directions are stated: the lever alone opens no later.
    let mut design = setup.design.clone();
    design.catch = None;
    let reading = setup.readings.own()?;
    let constant = Signal {
        samples: vec![peak_m_s2; setup.signal.samples.len()],
        ..*setup.signal
    };
    let pushed = match reading.beside(between::read(
        Cow::Owned(constant),
        setup.readings.between(),
    )?) {
        Ok(pushed) => pushed,
        // A pulse has no sensor beside it.
        Err(_) => return Ok(false),
    };
    let variants: Vec<Variant> = runs.iter().map(|run| run.variant()).collect();
    let opens = setup.share(1, &variants, |variant| {
        let options = RunOptions {
            method: Method::EventDriven,
            initial: setup.initial(variant.model),
            window: setup.window,
            error_bound: false,
            peak_only: true,
            ..RunOptions::new(variant.model, variant.opens_when)
        };
        let within = setup.work.within(setup.control);
        let outcome = replay::run_within(&pushed, &design, &options, &within)?;
        setup.work.add(outcome.spent);
        let coast = outcome.run.coast_peak_angle_rad.unwrap_or_default();
        let highest = outcome.run.peak_angle_rad.max(coast);
        Ok(outcome.broke_down || highest > setup.threshold_rad())
    })?;
    Ok(opens.contains(&true))
}
