//! One variant of an assessment with everything that it came to.

use super::ScreenedRun;
use super::decision::VariantRun;
use super::ensemble::Ensemble;
use super::policy::Variant;
use super::proof::Proof;

/// A stop and a sign that opens, with everything that they came to.
pub(super) struct VariantResult {
    pub(super) variant: Variant,
    /// What bounds say of the nominal lever.
    pub(super) screened: ScreenedRun,
    /// What bounds prove of error and members; `None` where they were not asked.
    pub(super) proof: Option<Proof>,
    /// The nominal run over the judged window.
    pub(super) run: VariantRun,
    /// The same up to the first bad sample, where a fault ends what is usable.
    pub(super) before_fault: Option<VariantRun>,
    /// The ensemble; `None` of a variant that was left out.
    pub(super) ensemble: Option<Ensemble>,
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
