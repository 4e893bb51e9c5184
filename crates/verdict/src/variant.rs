//! One variant of an assessment with everything that it came to.

use super::decision::VariantRun;
use super::ensemble::Ensemble;
use super::policy::Variant;

/// A stop and a sign that opens, with everything that they came to.
pub(super) struct VariantResult {
    pub(super) variant: Variant,
    /// The nominal run over the judged window.
    pub(super) run: VariantRun,
    /// The same up to the first bad sample, where a fault ends what is usable.
    pub(super) before_fault: Option<VariantRun>,
    /// The ensemble; `None` where a bound spares it.
    pub(super) ensemble: Option<Ensemble>,
    /// When the levers of the ensemble cross.
    pub(super) crossings: Crossings,
}

impl VariantResult {
    /// Returns the run over the samples that count.
    pub(super) fn counted(&self) -> &VariantRun {
        self.before_fault.as_ref().unwrap_or(&self.run)
    }

    pub(super) fn counted_mut(&mut self) -> &mut VariantRun {
        self.before_fault.as_mut().unwrap_or(&mut self.run)
    }
}

/// First crossings of the varied levers of one stop and sign [s]; NaN of one that does not cross.
#[derive(Debug, Clone, Default)]
pub(super) struct Crossings(pub(super) Vec<f64>);

impl Crossings {
    /// Returns them in ascending order, those that do not cross left out.
    pub(super) fn sorted(&self) -> Vec<f64> {
        let crossing = self.0.iter().copied().filter(|at| at.is_finite());
        let mut sorted: Vec<f64> = crossing.collect();
        sorted.sort_unstable_by(f64::total_cmp);
        sorted
    }
}
