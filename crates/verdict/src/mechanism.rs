//! What a mechanism beside the lever did: an inertia catch.

use super::variant::VariantResult;
use super::wording::{brief_instant, degrees, place};
use super::{Reason, Trace};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::catch::Catch;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::CatchRun;
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, plain};
use latchgate_recording::Finding;
use serde::{Deserialize, Serialize};

/// The mechanism beside the lever, and what it did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Mechanism {
    /// An inertia catch.
    InertiaCatch {
        /// χ = (S₂/(I₂ ψb))/(S₁/(I₁ φb)) [-]; `None` of a catch that blocks at rest.
        speed_ratio: Option<f64>,
        /// Base acceleration at which the catch leaves its rest stop, T₂/S₂ [g]; `None` of one without unbalance.
        lift_off_g: Option<f64>,
        /// What it did beside each nominal run over the judged window.
        runs: Vec<CatchAnswer>,
    },
}

/// What an inertia catch did beside the nominal lever of one stop and opening direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CatchAnswer {
    /// Stop model.
    pub model: StopModel,
    /// Sign of the recorded acceleration that opens.
    pub opens_when: OpensWhen,
    /// What it did.
    #[serde(flatten)]
    pub run: CatchRun,
}

impl Mechanism {
    /// Returns what the mechanism of a design did in these runs; `None` of the lever alone.
    pub(super) fn of(design: &Design, results: &[VariantResult]) -> Option<Self> {
        let catch = design.catch?;
        let finite = |value: f64| value.is_finite().then_some(value);
        let answers = results.iter().filter_map(|result| {
            Some(CatchAnswer {
                model: result.variant.model,
                opens_when: result.variant.opens_when,
                run: result.run.outcome.catch?,
            })
        });
        Some(Self::InertiaCatch {
            speed_ratio: finite(catch.speed_ratio(&design.lever)),
            lift_off_g: finite(catch.lift_off_acceleration_m_s2() / STANDARD_GRAVITY),
            runs: answers.collect(),
        })
    }
}

/// Returns the finding of a catch whose numbers do not promise to hold.
pub(super) fn finding(design: &Design) -> Option<Finding> {
    let catch = design.catch?;
    let (lever, limit) = (&design.lever, design.criterion.threshold_rad);
    let mut doubts = Vec::new();
    if catch.lever_angle_rad >= limit {
        doubts.push(format!(
            "it stops the lever at {}, which is not below the limit angle of {}",
            degrees(catch.lever_angle_rad, 3),
            degrees(limit, 3)
        ));
    }
    let in_g = |a: f64| plain(a / STANDARD_GRAVITY, 3);
    let leaves = [
        catch.lift_off_acceleration_m_s2(),
        lever.lift_off_acceleration_m_s2(),
    ];
    if leaves[0] >= leaves[1] {
        doubts.push(format!(
            "it leaves its rest at {} g, the lever at {} g",
            in_g(leaves[0]),
            in_g(leaves[1])
        ));
    }
    let ratio = catch.speed_ratio(lever);
    if ratio < 1.0 {
        doubts.push(format!(
            "in a blow from rest the lever comes first (speed ratio {}, wanted at least 1)",
            plain(ratio, 2)
        ));
    }
    let text = doubts.join("; ");
    (!text.is_empty()).then(|| {
        Finding::info(
            "catch-weak",
            format!("The numbers of the catch do not promise that it holds the lever: {text}. The verdict rests on the replay."),
        )
    })
}

/// Returns the trajectories of the catch, in the order of the results.
pub(super) fn catch_traces(results: &[VariantResult]) -> Vec<Trace> {
    let moved = results
        .iter()
        .filter(|result| !result.run.outcome.catch_trace.is_empty());
    moved
        .map(|result| Trace {
            model: result.variant.model,
            opens_when: result.variant.opens_when,
            points: result.run.outcome.catch_trace.clone(),
        })
        .collect()
}

/// Says where the errors do not tell which of catch and lever comes first, which leaves the peak unknown.
pub(super) fn tie(results: &[VariantResult]) -> Option<Reason> {
    let (variant, at) = results.iter().find_map(|result| {
        let at = result.counted().outcome.catch?.tie_s?;
        Some((result.variant, at))
    })?;
    Some(Reason {
        code: "catch-tie".into(),
        text: format!(
            "Catch and lever come together at {}: the errors do not say which is first ({}). A finer record, or a faster catch, would decide.",
            brief_instant(at),
            place(variant)
        ),
    })
}

/// Says what the catch did beside the nominal lever.
pub(super) fn reason(design: &Design, nominal: &VariantResult) -> Option<Reason> {
    let (catch, run) = (design.catch?, nominal.counted().outcome.catch?);
    let text = format!("{} ({}).", sentence(&catch, &run), place(nominal.variant));
    Some(Reason {
        code: "catch".into(),
        text,
    })
}

/// Says in a sentence, without its full stop, what a catch did.
fn sentence(catch: &Catch, run: &CatchRun) -> String {
    let Some(arrives) = run.lever_arrives_s else {
        return format!(
            "The lever never comes to the catch, which stands at {}",
            degrees(catch.lever_angle_rad, 3)
        );
    };
    let engaged = run.engaged_s.map_or_else(
        || {
            let reached = match run.peak_angle_rad < catch.engagement_angle_rad {
                true => format!("comes to {}", degrees(run.peak_angle_rad, 3)),
                false => "is late".into(),
            };
            let engagement = degrees(catch.engagement_angle_rad, 3);
            format!("The catch does not engage at {engagement}: it {reached}")
        },
        |at| format!("The catch engages at {}", brief_instant(at)),
    );
    let outcome = match run.lever_passes_s {
        Some(at) => format!("passes it at {}", brief_instant(at)),
        None => "is held".into(),
    };
    format!(
        "{engaged}; the lever comes to it at {} and {outcome}",
        brief_instant(arrives)
    )
}
