//! Findings of the replay itself.

use super::decision::{ROUNDING_PART, VariantRun};
use super::mechanism;
use super::policy::{Polarity, Policy};
use super::wording::{degrees, instant};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::linkage::parting;
use latchgate_kernel::model::parameters::Slot;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::{Range, Window};
use latchgate_kernel::replay::Method;
use latchgate_kernel::units::{SampleInterval, short};
use latchgate_recording::Finding;

/// Returns the finding of a crossing that the window leaves out.
pub(super) fn crossing_outside_window(at_s: f64) -> Finding {
    Finding::warning(
        "crossing-outside-window",
        format!(
            "Outside the judged window the lever opens, first at {}. The setting `window` leaves that out.",
            instant(at_s)
        ),
    )
    .at(at_s)
}

/// Returns the finding of a window that ends far behind a record that ends at `end_s`, as one in
/// milliseconds does.
pub(super) fn window_in_milliseconds(
    Window { from_s, until_s }: Window,
    end_s: f64,
) -> Option<Finding> {
    /// A window that only takes the rest of the record along ends nearer.
    const FAR_TIMES: f64 = 10.0;
    /// How far in milliseconds it may end behind the record all the same.
    const NEAR_TIMES: f64 = 2.0;
    let as_milliseconds = until_s / 1e3 <= NEAR_TIMES * end_s;
    (until_s > FAR_TIMES * end_s && as_milliseconds).then(|| {
        let (from, to, end) = (short(from_s / 1e3, 6), short(until_s / 1e3, 6), short(end_s, 3));
        let text = format!(
            "The window ends at {} s, the record at {end} s. If milliseconds are meant, state the setting `window` = {from}..{to}.",
            short(until_s, 6)
        );
        Finding::warning("window-in-milliseconds", text)
    })
}

/// Returns the finding of a question that took more than it may.
pub(super) fn work_limit_reached(limit: u64) -> Finding {
    Finding::warning(
        "work-limit",
        format!(
            "The answer takes more than {limit} steps, the limit `work`: runs were left out. Raise it: the setting `limit` = work={}. Or ask for fewer varied levers with the setting `members`.",
            limit.saturating_mul(10)
        ),
    )
}

/// Returns what the nominal runs show to be odd.
pub(super) fn replay_findings(
    design: &Design,
    policy: &Policy,
    interval: SampleInterval,
    runs: &[&VariantRun],
) -> Vec<Finding> {
    let mut findings = implausible(design);
    findings.extend(of_design(design));
    findings.extend(mechanism::finding(design));
    if policy.polarity == Polarity::Undeclared {
        findings.push(Finding::warning(
            "polarity-undeclared",
            "The opening direction is not declared, so both were judged. State it with the setting `opens_when`.",
        ));
    }
    if runs
        .iter()
        .any(|of| of.run().peak_angle_rad > std::f64::consts::FRAC_PI_2)
    {
        findings.push(Finding::info(
            "beyond-geometry",
            "The angle exceeds 90°, where a lever meets other parts. That it opens is valid; how far is not.",
        ));
    }
    if let Some(of) = runs.iter().find(|of| of.outcome.broke_down) {
        findings.push(Finding::warning(
            "method-broke-down",
            format!("The {} method could not follow the lever on the {} stop{}. Its figures mean nothing.", of.run().method.name(), of.run().model.name(), of.outcome.breakdown.map_or_else(String::new, |why| format!(": {}", why.text()))),
        ));
    }
    findings.extend(method_findings(design, policy, interval, runs));
    for of in runs {
        let run = of.run();
        if run.numerical_error_rad > ROUNDING_PART * design.criterion.threshold_rad
            && policy.method == Method::EventDriven
        {
            findings.push(Finding::warning(
                "rounding-amplified",
                format!(
                    "{} impacts on the {} stop have carried rounding to {}: the largest angle is not known better.",
                    run.impacts,
                    run.model.name(),
                    degrees(run.numerical_error_rad, 2)
                ),
            ));
        }
        if run.first_crossing_s.is_some_and(|time| time < 0.0) {
            findings.push(
                Finding::warning(
                    "crossing-before-contact",
                    format!("On the {} stop the lever opens before first contact, time zero. Check bias, filter and time zero.", run.model.name()),
                )
                .at(run.first_crossing_s.unwrap_or(0.0)),
            );
        }
    }
    findings
}

/// Share of a value below which a stated standard deviation is one that no production keeps [-].
const SCATTER_LOW: f64 = 1e-4;

/// Returns the numbers of the design that no latch has; what rests on them comes after.
pub(crate) fn implausible(design: &Design) -> Vec<Finding> {
    let scattered = design.tolerance.iter().filter_map(|(key, tolerance)| {
        let known = design.parameters().find(|known| known.tolerance_key() == key)?;
        let value = design.value(known);
        let share = tolerance.deviation(value) / value.abs();
        (share > 0.0 && share < SCATTER_LOW).then(|| {
            let text = format!(
                "The design's tolerance.{key} is {tolerance}, less than {} % of the value; no production keeps that. \
                 Check the design file; 0 says that the value is not varied.",
                short(100.0 * SCATTER_LOW, 3)
            );
            Finding::warning("design-implausible", text)
        })
    });
    let of_each = design.implausible();
    of_each
        .map(|(parameter, value)| {
            let Range { low, high } = parameter.plausible;
            let whose = match parameter.slot {
                Slot::Criterion(_) => "a criterion",
                _ => "a latch",
            };
            let unit = match parameter.unit {
                "1" => String::new(),
                unit => format!(" {unit}"),
            };
            Finding::warning(
                "design-implausible",
                format!(
                    "The design's {} is {value}{unit}; {whose} has {low} to {}{unit}. Check the design file.",
                    parameter.name,
                    short(high, 4)
                ),
            )
        })
        .chain(scattered)
        .collect()
}

/// Code of the finding of a design that does not state its scatter.
pub(super) const SCATTER_UNSTATED: &str = "scatter-unstated";

/// Returns the findings of a design, whatever it is replayed with, that hold a pass back.
pub(super) fn of_design(design: &Design) -> Vec<Finding> {
    let findings = [scatter_unstated(design), linkage_may_part(design)];
    findings.into_iter().flatten().collect()
}

/// Returns the finding of a design that does not state how far preload and unbalance scatter: springs and masses that
/// differ from the drawing opened doors, and a pass must know of them. 0 is a statement.
fn scatter_unstated(design: &Design) -> Option<Finding> {
    let missing = design.missing_tolerances();
    let named: Vec<String> = missing
        .iter()
        .map(|key| match *key {
            "mass_kg" => "tolerance.mass_kg (or center_of_mass_m)".to_string(),
            key => format!("tolerance.{key}"),
        })
        .collect();
    (!named.is_empty()).then(|| {
        Finding::warning(
            SCATTER_UNSTATED,
            format!(
                "The design does not state {}: how far levers made by it differ. A pass needs it; 0 states that they do not.",
                named.join(" and ")
            ),
        )
        .needing_word()
    })
}

/// Returns the finding of a linkage of which elements can part: a replay moves all of them as one lever.
fn linkage_may_part(design: &Design) -> Option<Finding> {
    let parting = parting(&design.linkage).into_iter();
    let names: Vec<String> = parting
        .map(|element| format!("`{}`", element.name))
        .collect();
    (!names.is_empty()).then(|| {
        Finding::warning(
            "linkage-may-part",
            format!(
                "The replay moves {} as one lever; of elements that are only pushed one can stay while another flies \
                 off. A pass needs `pinned = true` in the design's [[linkage]] for every element that cannot part, all \
                 but one at least.",
                names.join(", ")
            ),
        )
        .needing_word()
    })
}

/// Returns what is known of the method that was asked for.
fn method_findings(
    design: &Design,
    policy: &Policy,
    interval: SampleInterval,
    runs: &[&VariantRun],
) -> Vec<Finding> {
    let method = policy.method;
    let mut findings = Vec::new();
    match method {
        Method::EventDriven => return findings,
        Method::Rk4 { .. } => findings.push(Finding::warning(
            "fixed-step-method",
            "The fixed-step method sees impacts only at the end of a step. Its error is an estimate from halving the step.",
        )),
        _ => findings.push(Finding::warning(
            "comparison-method",
            format!(
                "The {} method is for comparison. Its error is an estimate from a second run with {}.",
                method.name(),
                if method.steps_per_period().is_some() { "half the step" } else { "a tenth of the tolerance" }
            ),
        )),
    }
    for stop in StopModel::ALL {
        if runs.iter().any(|of| of.run().model == stop) {
            for text in method.known_failures(design, stop, interval, policy.tolerance_rad) {
                if !findings.iter().any(|known| known.text == text) {
                    findings.push(Finding::warning("method-known-to-fail", text));
                }
            }
        }
    }
    findings
}
