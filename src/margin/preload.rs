//! The preload that a recording asks for, as a report quotes it.

use super::margin_search::MarginSearch;
use super::quantity::SearchRange;
use super::search::{Crossing, Edge};
use super::{Basis, MarginOptions, NominalAnswer, Quantity};
use crate::conditioning::Conditioned;
use crate::error::Error;
use crate::model::Design;
use crate::parallel::Control;
use crate::recording::Finding;
use crate::verdict::Policy;
use crate::verdict::early::MemberCache;
use crate::verdict::meter::Meter;
use serde::{Deserialize, Serialize};

/// The preload that a recording asks for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PreloadAnswer {
    /// The preload at present [N m].
    pub present_nm: f64,
    /// A preload at which the verdict by the whole rule is a pass, the nominal lever staying below
    /// the limit from a smaller one on [N m]; the present one where that passes; `None` if none
    /// was found.
    pub passes_from_nm: Option<f64>,
    /// The last preload found at which the nominal lever comes to stay at or below the limit [N m],
    /// as it does at every greater value that was searched, which proves nothing of those between;
    /// `None` if it does not at the greatest.
    pub nominal_from_nm: Option<f64>,
    /// Least and greatest preload searched [N m].
    pub searched_nm: (f64, f64),
    /// Values looked at before a change was narrowed down.
    pub values: usize,
    /// Changes of the nominal runs between pass and no pass.
    pub changes: usize,
    /// In a sentence.
    pub text: String,
}

/// Values of the preload that the search of an ordinary recording begins with.
const PRELOADS: usize = 160;

/// Largest ensemble that is asked at another preload: a pass at its looks is one of any larger
/// ensemble, which looks at the same members.
const MEMBERS_ASKED: u32 = 128;

/// Steps beyond the preload that the nominal lever asks for, at which the whole rule is asked.
const STEPS: [f64; 8] = [1.001, 1.01, 1.03, 1.06, 1.1, 1.2, 1.5, 2.0];

/// Finds the preload from which on the recording passes; `passes` says whether it does at
/// present, by the whole rule.
///
/// # Errors
///
/// As [`crate::verdict::assess()`].
pub fn preload_answer(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
    passes: bool,
    control: &Control<'_>,
) -> Result<PreloadAnswer, Error> {
    let signal = &conditioned.used;
    let options = MarginOptions {
        policy: Policy {
            members: policy.members.min(MEMBERS_ASKED),
            ..policy.clone()
        },
        basis: Basis::Verdict,
        counterweight_radius_m: 1.0,
        points: Some((PRELOADS * 4_000 / signal.samples.len().max(1)).clamp(24, PRELOADS)),
        map: None,
        limit: false,
    };
    control.unmeasured(|control| {
        let work = Meter::new(policy.work);
        let search = MarginSearch::new(conditioned, findings, design, &options, control, &work)?;
        answer(&search, passes)
    })
}

/// Searches the preloads: nominal runs first, and the whole rule from where those pass on.
fn answer(search: &MarginSearch<'_>, passes: bool) -> Result<PreloadAnswer, Error> {
    let range = search.range(Quantity::Preload);
    let found = search.changes(Quantity::Preload, &range)?;
    let changes: Vec<&Crossing> = found
        .crossings
        .iter()
        .filter(|crossing| crossing.edge == Edge::Pass)
        .collect();
    let nominal_from_nm = match changes.last() {
        Some(last) => (last.high.1.pass <= 0.0).then_some(last.high.0),
        None => (search.state == NominalAnswer::Pass).then_some(range.low),
    };
    let passes_from_nm = if passes {
        Some(range.present)
    } else {
        match nominal_from_nm {
            Some(from) => first_pass(search, from, range.high)?,
            None => None,
        }
    };
    Ok(PreloadAnswer {
        present_nm: range.present,
        passes_from_nm,
        nominal_from_nm,
        searched_nm: (range.low, range.high),
        values: found.points.len(),
        changes: changes.len(),
        text: text(passes, passes_from_nm, nominal_from_nm, &range),
    })
}

/// Returns the first preload in steps from `from` on at which the whole rule passes.
fn first_pass(search: &MarginSearch<'_>, from: f64, high: f64) -> Result<Option<f64>, Error> {
    let mut cache = MemberCache::default();
    for value in STEPS.map(|step| step * from) {
        if value <= high && search.verdict_passes(Quantity::Preload, value, &mut cache, false)? {
            return Ok(Some(value));
        }
    }
    Ok(None)
}

fn text(
    passes: bool,
    passes_from_nm: Option<f64>,
    nominal_from_nm: Option<f64>,
    range: &SearchRange,
) -> String {
    let number = |value: f64| crate::units::plain(value, 4);
    let (low, high) = (number(range.low), number(range.high));
    match (passes, passes_from_nm, nominal_from_nm) {
        (true, _, Some(from)) => format!(
            "Passes with T0 = {} N·m; the nominal lever was found below the limit at every greater T0 searched, as from {} N·m.",
            number(range.present),
            number(from)
        ),
        (true, _, None) => format!(
            "Passes with T0 = {} N·m, but the nominal lever does not stay below the limit up to T0 = {high} N·m.",
            number(range.present)
        ),
        (false, Some(at), Some(from)) => format!(
            "Would pass at T0 = {} N·m (present {} N·m), by the whole rule; nothing is said of greater values, of which only the nominal lever was searched and found below the limit from {} N·m. Check the preload that is chosen.",
            number(at),
            number(range.present),
            number(from)
        ),
        (false, None, Some(from)) => format!(
            "The nominal lever was found below the limit at every T0 searched from {} N·m (present {} N·m), but no preload up to {high} N·m was found at which the whole rule says pass.",
            number(from),
            number(range.present)
        ),
        (false, _, None) => format!("No preload from {low} to {high} N·m was found to pass."),
    }
}
