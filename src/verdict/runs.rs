//! The runs of one assessment: what they share, the nominal runs with their fourfold, and the
//! peaks of members.

use super::Answer;
use super::decision::{VariantRun, combine};
use super::ensemble::MemberPeaks;
use super::policy::{Policy, Variant};
use super::usable_span::SampleSpan;
use crate::conditioning::Signal;
use crate::error::Error;
use crate::model::Design;
use crate::model::stop::StopModel;
use crate::parallel::Control;
use crate::replay::batch::{self, BatchOptions, Member, MemberPeak};
use crate::replay::{self, Run, RunOptions, RunOutcome};
use crate::units::OpensWhen;

/// The detail that a run carries along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RunDetail {
    /// Its own error, and the trajectory for a drawing.
    Trace,
    /// Its own error.
    ErrorBound,
    /// Neither: it is compared with a run that has them.
    PeakOnly,
}

/// Everything that the runs of one assessment share.
#[derive(Clone, Copy)]
pub(crate) struct RunSetup<'a> {
    pub(crate) design: &'a Design,
    pub(crate) policy: &'a Policy,
    /// Follow every stop in full, whatever bounds prove.
    pub(crate) follow_all: bool,
    pub(crate) control: &'a Control<'a>,
    pub(crate) signal: &'a Signal,
    /// The band-limited fourfold of the samples.
    pub(crate) fine: &'a Signal,
    /// First and last judged sample; `None` for all.
    pub(crate) window: Option<SampleSpan>,
}

/// SampleSpan, of all runs, from which further threads gain more than their start costs.
const SHARED_SAMPLES: usize = 20_000;

impl RunSetup<'_> {
    pub(crate) fn threshold_rad(&self) -> f64 {
        self.design.criterion.threshold_rad
    }

    /// The judged window in samples of the fourfold.
    pub(crate) fn fine_window(&self) -> Option<SampleSpan> {
        self.window.map(|(first, last)| (4 * first, 4 * last))
    }

    pub(crate) fn initial(&self, model: StopModel) -> Option<(f64, f64)> {
        let Design { stop, lever, .. } = self.design;
        self.policy.initial(model, stop, lever)
    }

    /// Does `of` each item and returns the results in the items' order; `runs` says how many runs
    /// that takes on all of them, few of which on a short recording stay on one thread.
    ///
    /// # Errors
    ///
    /// The first of `of`, in the items' order; [`crate::error::ErrorKind::Stopped`].
    pub(crate) fn share<T: Sync, R: Send>(
        &self,
        runs: usize,
        items: &[T],
        of: impl Fn(&T) -> Result<R, Error> + Sync,
    ) -> Result<Vec<R>, Error> {
        self.control
            .unmeasured(|control| self.share_by(control, runs, items, of))
    }

    /// As [`Self::share`]; `control` is told how many of the items are done.
    pub(super) fn share_by<T: Sync, R: Send>(
        &self,
        control: &Control<'_>,
        runs: usize,
        items: &[T],
        of: impl Fn(&T) -> Result<R, Error> + Sync,
    ) -> Result<Vec<R>, Error> {
        control.check()?;
        let few = self.signal.samples.len().saturating_mul(runs) < SHARED_SAMPLES;
        let threads = if few { 1 } else { control.threads };
        control.with_threads(threads).try_map(items, of)
    }

    /// Runs one variant on `signal`, of whose samples `window` are judged.
    pub(crate) fn run(
        &self,
        signal: &Signal,
        variant: Variant,
        window: Option<SampleSpan>,
        detail: RunDetail,
    ) -> Result<RunOutcome, Error> {
        let (method, tolerance_rad) = self.policy.method_on(variant.model);
        replay::run(
            signal,
            self.design,
            &RunOptions {
                stop: variant.model,
                opens_when: variant.opens_when,
                method,
                tolerance_rad,
                step_s: None,
                initial: self.initial(variant.model),
                window,
                trace: detail == RunDetail::Trace,
                error_bound: detail != RunDetail::PeakOnly,
            },
        )
    }

    /// Runs every variant on the samples.
    pub(super) fn nominal_runs(
        &self,
        variants: &[Variant],
        detail: RunDetail,
    ) -> Result<Vec<RunOutcome>, Error> {
        self.share(1, variants, |variant| {
            self.run(self.signal, *variant, self.window, detail)
        })
    }

    /// Sets each run beside the same on the fourfold of its samples; one with a `stand_in`, which
    /// states its error without a further run, becomes that.
    pub(super) fn refined(
        &self,
        runs: Vec<RunOutcome>,
        stand_ins: Vec<Option<VariantRun>>,
    ) -> Result<Vec<VariantRun>, Error> {
        let tasks: Vec<(RunOutcome, Option<VariantRun>)> =
            runs.into_iter().zip(stand_ins).collect();
        let fine = self.share(4, &tasks, |(run, stand_in)| {
            let variant = Variant {
                opens_when: run.run.opens_when,
                model: run.run.model,
            };
            let refined = || self.run_fine(variant);
            stand_in.is_none().then(refined).transpose()
        })?;
        let refined = tasks.into_iter().zip(fine);
        Ok(refined
            .filter_map(|((run, stand_in), fine)| stand_in.or_else(|| Some(compared(run, &fine?))))
            .collect())
    }

    /// Runs every variant on the samples and on their fourfold.
    pub(super) fn full_runs(
        &self,
        variants: &[Variant],
        detail: RunDetail,
    ) -> Result<Vec<VariantRun>, Error> {
        let runs = self.nominal_runs(variants, detail)?;
        let none = vec![None; runs.len()];
        self.refined(runs, none)
    }

    fn run_fine(&self, variant: Variant) -> Result<RunOutcome, Error> {
        self.run(self.fine, variant, self.fine_window(), RunDetail::PeakOnly)
    }

    /// Returns what a nominal run says alone. Of one that was left out because nearly all
    /// scattered levers cross, the error is not known: its fourfold is run.
    pub(super) fn nominal_answer(&self, of: &VariantRun) -> Result<Answer, Error> {
        let threshold = self.threshold_rad();
        let answer = of.nominal_answer(threshold);
        if !(of.left_out && answer == Answer::Undecided) {
            return Ok(answer);
        }
        let fine = self.run_fine(of.variant())?;
        Ok(compared(of.outcome.clone(), &fine).nominal_answer(threshold))
    }

    /// Joins what runs say by parts 3 and 4 of the rule.
    pub(super) fn joined(&self, runs: &[&VariantRun]) -> Answer {
        let threshold = self.threshold_rad();
        let answers: Vec<(OpensWhen, Answer)> = runs
            .iter()
            .map(|run| (run.variant().opens_when, run.answer(threshold)))
            .collect();
        combine(self.policy.polarity, &answers)
    }

    /// Returns how far `count` members come on one variant.
    pub(super) fn peaks(
        &self,
        variant: Variant,
        count: usize,
        member: &(impl Fn(usize) -> Member + Sync),
    ) -> Result<MemberPeaks, Error> {
        let options = BatchOptions {
            stop: variant.model,
            opens_when: variant.opens_when,
            initial: self.initial(variant.model),
            window: self.window,
            coast: true,
            threads: 1,
        };
        let peaks = batch::peaks(self.signal, count, member, &options)?;
        Ok(MemberPeaks {
            window_rad: peaks.iter().map(|peak| peak.peak_angle_rad).collect(),
            highest_rad: peaks.iter().map(MemberPeak::highest_rad).collect(),
        })
    }

    /// Returns when the lever first crosses the threshold outside the judged window [s], if it
    /// does so on a variant that does not cross inside.
    pub(super) fn crossing_outside(&self, runs: &[&VariantRun]) -> Result<Option<f64>, Error> {
        let stays = |of: &&&VariantRun| of.run().first_crossing_s.is_none();
        let tasks: Vec<Variant> = runs
            .iter()
            .filter(|_| self.window.is_some())
            .filter(stays)
            .map(|of| of.variant())
            .collect();
        let whole = self.share(1, &tasks, |variant| {
            self.run(self.signal, *variant, None, RunDetail::PeakOnly)
        })?;
        let crossings = whole
            .iter()
            .filter_map(|outcome| outcome.run.first_crossing_s);
        Ok(crossings.reduce(f64::min))
    }
}

/// Sets a run beside the same on the fourfold of its samples.
fn compared(outcome: RunOutcome, fine: &RunOutcome) -> VariantRun {
    let highest = |run: &Run| {
        run.coast_peak_angle_rad
            .map_or(run.peak_angle_rad, |coast| coast.max(run.peak_angle_rad))
    };
    let of_peak = (fine.run.peak_angle_rad - outcome.run.peak_angle_rad).abs();
    let of_coast = if outcome.run.coast_peak_angle_rad.is_some() {
        (highest(&fine.run) - highest(&outcome.run)).abs()
    } else {
        0.0
    };
    VariantRun {
        outcome,
        // A rerun that could not be followed bounds nothing.
        interpolation_error_rad: if fine.broke_down {
            f64::MAX
        } else {
            of_peak.max(of_coast)
        },
        share: None,
        left_out: false,
    }
}

/// Returns the place of the run with the largest peak, the first of several.
pub(super) fn index_of_largest<'a>(runs: impl Iterator<Item = &'a Run>) -> usize {
    let peaks: Vec<f64> = runs.map(|run| run.peak_angle_rad).collect();
    let mut largest = 0;
    for (index, peak) in peaks.iter().enumerate() {
        if *peak > peaks[largest] {
            largest = index;
        }
    }
    largest
}
