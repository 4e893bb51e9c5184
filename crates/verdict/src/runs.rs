//! The runs of one assessment: what they share, the nominal runs, and the peaks of members.

use super::Answer;
use super::decision::{VariantRun, combine};
use super::ensemble::MemberPeaks;
use super::in_plane::{self, InPlane};
use super::meter::Meter;
use super::policy::{AssessDetail, DrawnRuns, Policy, Variant};
use super::readings::Readings;
use super::usable_span::SampleSpan;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, MemberOf};
use latchgate_kernel::replay::{
    self, Breakdown, Method, Run, RunOptions, RunOutcome, State, double_double,
};
use latchgate_kernel::signal::{Projection, Reading, Signal};
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;

/// The detail that a run carries along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RunDetail {
    /// Its own error, what noise does to it, and the trajectory for a drawing.
    Trace,
    /// Its own error and what noise does to it.
    Errors,
    /// The trajectory alone, of a lever of an ensemble.
    Path,
    /// None of these: it is compared with a run that has them.
    PeakOnly,
}

/// Everything that the runs of one assessment share.
#[derive(Clone, Copy)]
pub(crate) struct RunSetup<'a> {
    pub(crate) design: &'a Design,
    pub(crate) policy: &'a Policy,
    /// Run every ensemble, whatever bounds show.
    pub(crate) follow_all: bool,
    /// How much is worked out.
    pub(crate) detail: AssessDetail,
    pub(crate) control: &'a Control<'a>,
    pub(crate) signal: &'a Signal,
    /// Which runs that could pass are drawn; none where a blocking finding forbids a pass.
    pub(crate) drawn_runs: Option<DrawnRuns>,
    /// Other readings of the samples.
    pub(crate) readings: Readings<'a>,
    /// First and last judged sample; `None` for all.
    pub(crate) window: Option<SampleSpan>,
    /// What all runs may take and have taken.
    pub(crate) work: &'a Meter,
}

/// Samples, of all runs, from which further threads gain more than their start costs.
const SHARED_SAMPLES: usize = 20_000;

impl RunSetup<'_> {
    pub(crate) fn threshold_rad(&self) -> f64 {
        self.design.criterion.threshold_rad
    }

    pub(crate) fn initial(&self, model: StopModel) -> Option<State> {
        let Design { stop, lever, .. } = self.design;
        self.policy.initial(model, stop, lever)
    }

    /// Returns how the recorded accelerations drive the lever.
    pub(super) fn projection(&self, opens_when: OpensWhen) -> Result<Projection, Error> {
        match self.readings.conditioned().second {
            Some(_) => Ok(InPlane::of(&self.design.lever)?.projection(opens_when)),
            None => Ok(Projection::ALIGNED),
        }
    }

    /// Returns how much the noise of each sensor counts.
    pub(super) fn weights(&self, projection: &Projection) -> [f64; 2] {
        in_plane::weights(projection, self.threshold_rad())
    }

    /// Does `of` each item and returns the results in the items' order; `runs` says how many runs
    /// an item takes, few of which on a short recording stay on one thread.
    ///
    /// # Errors
    ///
    /// The first of `of`, in the items' order; [`Stopped`](latchgate_kernel::error::Error::Stopped).
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
        self.work.share_out(items.len());
        let runs = runs.saturating_mul(items.len());
        let few = self.signal.samples.len().saturating_mul(runs) < SHARED_SAMPLES;
        let threads = if few { 1 } else { control.threads };
        control.with_threads(threads).try_map(items, of)
    }

    /// Runs one variant on a reading, of whose samples `window` are judged.
    pub(crate) fn run(
        &self,
        reading: &Reading<'_>,
        variant: Variant,
        window: Option<SampleSpan>,
        detail: RunDetail,
    ) -> Result<RunOutcome, Error> {
        let method = self.policy.method_on(variant.model);
        self.run_by(method, reading, variant, window, detail)
    }

    /// As [`Self::run`] by the kernel, whatever the method of the nominal runs.
    pub(super) fn run_by_kernel(
        &self,
        reading: &Reading<'_>,
        variant: Variant,
        window: Option<SampleSpan>,
        detail: RunDetail,
    ) -> Result<RunOutcome, Error> {
        self.run_by(
            (Method::EventDriven, None),
            reading,
            variant,
            window,
            detail,
        )
    }

    fn run_by(
        &self,
        (method, tolerance_rad): (Method, Option<f64>),
        reading: &Reading<'_>,
        variant: Variant,
        window: Option<SampleSpan>,
        detail: RunDetail,
    ) -> Result<RunOutcome, Error> {
        let with_errors = matches!(detail, RunDetail::Trace | RunDetail::Errors);
        let projection = self.projection(variant.opens_when)?;
        let noise_m2_s3 = match with_errors && method == Method::EventDriven {
            true => self.readings.noise_m2_s3(self.weights(&projection))?,
            false => None,
        };
        let options = RunOptions {
            stop: variant.model,
            projection,
            opens_when: variant.opens_when,
            method,
            tolerance_rad,
            step_s: None,
            initial: self.initial(variant.model),
            window,
            trace: matches!(detail, RunDetail::Trace | RunDetail::Path),
            error_bound: with_errors,
            noise_m2_s3,
            peak_only: detail == RunDetail::PeakOnly,
        };
        let within = self.work.within(self.control);
        let outcome = replay::run_within(reading, self.design, &options, &within)?;
        if detail == RunDetail::Path {
            // A drawing is left out of what the answer took.
            return Ok(outcome);
        }
        self.work.add(outcome.spent);
        if outcome.breakdown == Some(Breakdown::TooManySteps) {
            self.work.cut();
        }
        Ok(outcome)
    }

    /// Measures what a run states of its own error.
    pub(super) fn narrow(&self, outcome: &mut RunOutcome) -> Result<(), Error> {
        let run = &outcome.run;
        let options = RunOptions {
            projection: self.projection(run.opens_when)?,
            initial: self.initial(run.model),
            window: self.window,
            ..RunOptions::new(run.model, run.opens_when)
        };
        let within = self.work.within(self.control);
        let (reading, before) = (self.readings.own()?, outcome.spent);
        double_double::narrow(outcome, &reading, self.design, &options, &within)?;
        self.work.add(outcome.spent - before);
        Ok(())
    }

    /// Runs every variant on the samples.
    pub(super) fn nominal_runs(
        &self,
        variants: &[Variant],
        detail: RunDetail,
    ) -> Result<Vec<RunOutcome>, Error> {
        let reading = self.readings.own()?;
        self.share(1, variants, |variant| {
            self.run(&reading, *variant, self.window, detail)
        })
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

    /// Returns how far `count` members come on one variant; as far as
    /// that is `asked`.
    pub(super) fn peaks(
        &self,
        variant: Variant,
        count: usize,
        member: MemberOf<'_>,
        asked: AskedPeaks,
    ) -> Result<MemberPeaks, Error> {
        let parts = replay::subdivision(self.signal.rate, self.design, variant.model);
        let options = BatchOptions {
            stop: variant.model,
            projection: self.projection(variant.opens_when)?,
            opens_when: variant.opens_when,
            initial: self.initial(variant.model),
            window: self
                .window
                .map(|(first, last)| (parts * first, parts * last)),
            coast: true,
            asked,
            threshold_rad: self.threshold_rad(),
            threads: 1,
        };
        let within = self.work.within_of_members(self.control);
        let reading = self.readings.own()?;
        let reading = reading.divided(parts);
        let peaks = batch::peaks_within(&reading, count, member, &options, &within)?;
        self.work.add(peaks.iter().map(|peak| peak.spent).sum());
        // Infinity is said of members that are no lever, of none that overflowed.
        let number = |rad: f64| if rad.is_finite() { rad } else { f64::NAN };
        Ok(MemberPeaks {
            window_rad: peaks
                .iter()
                .map(|peak| number(peak.peak_angle_rad))
                .collect(),
            highest_rad: peaks
                .iter()
                .map(|peak| number(peak.highest_rad()))
                .collect(),
            crossings_s: peaks
                .iter()
                .map(|peak| peak.first_crossing_s.unwrap_or(f64::NAN))
                .collect(),
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
        let reading = self.readings.own()?;
        let whole_runs = self.share(1, &tasks, |variant| {
            self.run(&reading, *variant, None, RunDetail::PeakOnly)
        })?;
        let crossings = whole_runs
            .iter()
            .filter_map(|outcome| outcome.run.first_crossing_s);
        Ok(crossings.reduce(f64::min))
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

/// Returns the variant of a run.
pub(super) fn variant_of(outcome: &RunOutcome) -> Variant {
    Variant {
        opens_when: outcome.run.opens_when,
        model: outcome.run.model,
    }
}
