//! The preload that a recording asks for, as a report quotes it.

use super::margin_search::MarginSearch;
use super::{Basis, MarginOptions, Quantity};
use crate::Policy;
use crate::conditioning::Conditioned;
use crate::meter::Meter;
use latchgate_kernel::model::Design;
use latchgate_kernel::parallel::Control;
use latchgate_recording::Finding;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};

/// The preload that a recording asks for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PreloadAnswer {
    /// The preload at present [N m].
    pub present_nm: f64,
    /// The preload from which on every greater one that was searched passes by the whole rule
    /// [N m], as a search for margins gives it; `None` with the reason in `text`.
    pub safe_from_nm: Option<f64>,
    /// A preload at which the verdict is a pass [N m]: the present one where it does, else
    /// `safe_from_nm`.
    pub passes_from_nm: Option<f64>,
    /// Least and greatest preload searched [N m].
    pub searched_nm: (f64, f64),
    /// Values looked at before a change was narrowed down.
    pub values: usize,
    /// In a sentence.
    pub text: String,
}

/// Finds the preload from which on the recording passes; `passes` says whether it does at
/// present, by the whole rule.
///
/// # Errors
///
/// As [`crate::assess()`].
pub fn preload_answer(
    conditioned: &Conditioned,
    findings: &[Finding],
    design: &Design,
    policy: &Policy,
    passes: bool,
    control: &Control<'_>,
) -> Result<PreloadAnswer, Error> {
    let options = MarginOptions {
        policy: policy.clone(),
        basis: Basis::Verdict,
        counterweight_radius_m: 1.0,
        points: None,
        map: None,
        limit: false,
    };
    control.unmeasured(|control| {
        let work = Meter::new(policy.work);
        let search = MarginSearch::new(conditioned, findings, design, &options, control, &work)?;
        let range = search.range(Quantity::Preload);
        let found = search.changes(Quantity::Preload, &range)?;
        let advice = search.advice(Quantity::Preload, &range, &found)?;
        let present = passes.then_some(range.present);
        Ok(PreloadAnswer {
            present_nm: range.present,
            safe_from_nm: advice.safe_from,
            passes_from_nm: present.or(advice.safe_from),
            searched_nm: (range.low, range.high),
            values: found.points.len(),
            text: advice.text,
        })
    })
}
