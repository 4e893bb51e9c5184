//! Findings of a lever with an axis: whose door opens, and what a single channel leaves out.

use super::decision::VariantRun;
use super::in_plane::InPlane;
use super::policy::Variant;
use super::runs::{RunDetail, RunSetup};
use crate::conditioning::{Conditioned, Neighbour, between};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::{STANDARD_GRAVITY, plain};
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

/// Code of the finding that one channel leaves out a part of what drives a lever with an axis.
pub(super) const LEFT_OUT: &str = "radial-left-out";

/// What two in-plane axes, or the lack of a second, give cause to say.
#[derive(Default)]
pub(super) struct PlaneFindings {
    pub(super) findings: Vec<Finding>,
    /// Why a pass cannot stand: what was not measured, or a contradiction, may open the lever.
    pub(super) forbids_pass: Option<Finding>,
}

/// Largest velocity change that a channel across may have in a pass [m/s].
const VELOCITY_CHANGE_MAX_M_S: f64 = 30.0;

/// Returns what is to be said of two in-plane axes, or of the lack of a second.
pub(super) fn plane_findings(
    setup: &RunSetup<'_>,
    conditioned: &Conditioned,
    runs: &[&VariantRun],
    is_pass: bool,
) -> Result<PlaneFindings, Error> {
    let lever = &setup.design.lever;
    if lever.directions().is_none() {
        return Ok(PlaneFindings::default());
    }
    let Some(second) = conditioned.second.as_deref() else {
        return left_out(setup, conditioned, runs, is_pass);
    };
    let in_plane = InPlane::of(lever)?;
    let mut outcome = PlaneFindings::default();
    let mut contradictions = Vec::new();
    let signs = setup.policy.polarity.signs();
    for opens_when in signs {
        let door = in_plane.door(*opens_when, second.judged_is_reversed);
        let name = opens_when.name();
        let text = format!(
            "With the signs of SAE J211 {name} acceleration opens the {door} door. If the recording is of the other one, change the setting `opens_when`."
        );
        outcome.findings.push(Finding::info("in-plane-door", text));
        if let ([_], Some(side)) = (signs, second.judged_side.filter(|side| *side != door)) {
            contradictions.push(Finding::warning(
                "in-plane-side",
                format!(
                    "The judged channel is of the {side} side by its code, but {name} acceleration opens the {door} door. Check the setting `opens_when` and the signs of both channels."
                ),
            ));
        }
    }
    let velocity_m_s = second.conditioned.velocity_change_m_s;
    if velocity_m_s > VELOCITY_CHANGE_MAX_M_S {
        contradictions.push(Finding::warning(
            "in-plane-velocity",
            format!(
                "`{}` changes the velocity by {} m/s, which no crash does. Check its unit.",
                second.name,
                plain(velocity_m_s, 1)
            ),
        ));
    }
    outcome.forbids_pass = contradictions.first().cloned();
    outcome.findings.extend(contradictions);
    Ok(outcome)
}

/// Says what one channel leaves out of a lever with an axis, and whether that could take a pass.
fn left_out(
    setup: &RunSetup<'_>,
    conditioned: &Conditioned,
    runs: &[&VariantRun],
    is_pass: bool,
) -> Result<PlaneFindings, Error> {
    /// Least part of another axis along the way of the centre of mass that a pass cannot do without [-].
    const OBLIQUE: f64 = 0.02;
    let lever = &setup.design.lever;
    let Some(directions) = lever.directions() else {
        return Ok(PlaneFindings::default());
    };
    let sine = libm::sin(setup.threshold_rad().min(FRAC_PI_2));
    let parts = |axis: char| {
        let place = ['X', 'Y', 'Z'].iter().position(|letter| *letter == axis);
        let place = place.unwrap_or_default();
        (
            directions.tangential.0[place].abs(),
            directions.radial.0[place].abs(),
        )
    };
    // By formula a pulse is what drives the lever along the way of its centre of mass.
    let is_measured = conditioned.formula.is_none();
    // A channel that is stated to be along another axis than Y may be the one that drives the lever.
    let drives_alone = |axis: char| {
        let others = ['X', 'Y', 'Z'].into_iter().filter(|other| *other != axis);
        others.into_iter().all(|other| parts(other).0 <= OBLIQUE)
    };
    let is_oblique =
        is_measured && !drives_alone('Y') && !conditioned.axis.is_some_and(drives_alone);
    let mut text = format!(
        "The design states an axis, the recording is one channel: acceleration along the lever's arm was left out. At the limit angle it counts with {:.0} % of its size.",
        100.0 * sine
    );
    if is_oblique {
        text += " The way of the centre of mass is oblique to Y: other axes drive the lever at every angle, so that one channel cannot pass it.";
    }
    let second_axis = InPlane::of(lever).map(|in_plane| in_plane.second_axis);
    for Neighbour {
        name,
        axis,
        peak_m_s2,
    } in conditioned.neighbours.iter()
    {
        let (along, across) = parts(*axis);
        let acts_m_s2 = (along + sine * across) * peak_m_s2;
        if along.max(across) <= OBLIQUE {
            continue;
        }
        let in_g = |a: f64| plain(a / STANDARD_GRAVITY, 1);
        text += &format!(
            " {name} reaches {} g, which acts like up to {} g there.",
            in_g(*peak_m_s2),
            in_g(acts_m_s2)
        );
        let pushes = [along * peak_m_s2, across * peak_m_s2];
        if is_pass && could_take(setup, runs, pushes)? {
            text += " That much, all the time, would open the lever: this pass hangs on what was left out.";
        }
        if second_axis.as_ref().is_ok_and(|second| second == axis) {
            text += &format!(" Name it with the setting `radial_channel` = {name}.");
        }
    }
    if is_pass && is_measured && conditioned.neighbours.is_empty() {
        text += " How large it was is not known, and this pass is without it.";
    }
    let finding = Finding::warning(LEFT_OUT, text);
    Ok(PlaneFindings {
        forbids_pass: is_oblique.then(|| finding.clone()),
        findings: vec![finding],
    })
}

/// Tells whether a nominal lever would open under constant accelerations on top, opening along the way of its
/// centre of mass and outwards along its arm.
fn could_take(
    setup: &RunSetup<'_>,
    runs: &[&VariantRun],
    [along_m_s2, across_m_s2]: [f64; 2],
) -> Result<bool, Error> {
    // Of an inertia catch no directions are stated: the lever alone opens no later.
    let mut design = setup.design.clone();
    design.catch = None;
    let alone = RunSetup {
        design: &design,
        ..*setup
    };
    let constant = Signal {
        samples: vec![across_m_s2; setup.signal.samples.len()],
        ..*setup.signal
    };
    let across = between::read(Cow::Owned(constant), setup.readings.between())?;
    let judged = setup.readings.own()?;
    let variants: Vec<Variant> = runs.iter().map(|run| run.variant()).collect();
    let opens = setup.share(1, &variants, |variant| {
        let pushed = judged.scaled(1.0, -variant.opens_when.sign() * along_m_s2);
        // A pulse has no sensor beside it.
        let Ok(pushed) = pushed.beside((&across).into()) else {
            return Ok(false);
        };
        let outcome = alone.run_by_kernel(&pushed, *variant, setup.window, RunDetail::PeakOnly)?;
        let coast = outcome.run.coast_peak_angle_rad.unwrap_or_default();
        let highest = outcome.run.peak_angle_rad.max(coast);
        Ok(outcome.broke_down || highest > setup.threshold_rad())
    })?;
    Ok(opens.contains(&true))
}
