//! What lies between samples and is not known: the interpolation error of a peak.
//!
//! The lever is replayed on other readings of its samples: by cubics in place of quintics, and with
//! corners and jumps between two samples, which no reading finds, as far as their trace in the samples as
//! recorded lets them be: once and twice, to either side. The error is the change by the cubics plus the
//! largest by corners; where the course of impacts differs on any of the six, at least three times the
//! range of their peaks. To it comes twice what a noise as strong as the cubics' change would do ([`noise`]).

use super::Answer;
use super::decision::{NOISE_TIMES, VariantRun};
use super::noise::{self, CarriedNoise};
use super::policy::Variant;
use super::readings::{CORNERS, SampleReading};
use super::runs::{RunDetail, RunSetup, index_of_largest, variant_of};
use crate::conditioning::Between;
use latchgate_kernel::replay::{Run, RunOutcome};
use latchgate_kernel::signal::Signal;
use latchgate_recording::error::Error;

/// Times the range of the peaks on all readings by which a peak is in doubt where the course of impacts
/// differs between two of them.
pub(crate) const DIFFERING_TIMES: f64 = 3.0;

/// Times that the samples are run, counted as such, for the errors of one run.
const RUNS_OF_A_BOUND: usize = 6;

/// What one reading of the samples leads to.
#[derive(Debug, Clone, Copy)]
struct ReadPeak {
    /// Largest angle in the window, and in window and coast [rad].
    angles: [f64; 2],
    course: Course,
    followed: bool,
}

/// How a lever came to its peak.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course {
    /// When [s].
    at_s: f64,
    /// Impacts before the peak, as far as they are listed.
    impacts_before: usize,
}

impl Course {
    pub(super) fn of(run: &Run) -> Self {
        let before = |impact: &&[f64; 2]| impact[0] <= run.peak_time_s;
        Self {
            at_s: run.peak_time_s,
            impacts_before: run.impact_list.iter().filter(before).count(),
        }
    }

    /// Returns by how much the peak's time moves from this course to another [s]; `None` if that has
    /// another number of impacts before it.
    pub(crate) fn moved_s(&self, other: &Self) -> Option<f64> {
        let same = self.impacts_before == other.impacts_before;
        same.then(|| (self.at_s - other.at_s).abs())
    }
}

/// Returns the time by which peaks are apart that are different ones [s]: two sample intervals.
pub(crate) fn apart_s(signal: &Signal) -> f64 {
    2.0 * signal.rate.interval().seconds()
}

impl ReadPeak {
    fn of(outcome: &RunOutcome) -> Self {
        let run = &outcome.run;
        let peak = run.peak_angle_rad;
        Self {
            angles: [
                peak,
                run.coast_peak_angle_rad
                    .map_or(peak, |coast| coast.max(peak)),
            ],
            course: Course::of(run),
            followed: !outcome.broke_down,
        }
    }

    /// Returns the larger change of the two angles to another reading [rad].
    fn change(&self, other: &Self) -> f64 {
        let [window, both] = [0, 1].map(|which| (self.angles[which] - other.angles[which]).abs());
        window.max(both)
    }
}

/// The peaks of one variant on some of the six readings.
struct ReadPeaks {
    quintic: ReadPeak,
    cubic: Option<ReadPeak>,
    corners: Vec<ReadPeak>,
    /// See [`apart_s`].
    apart_s: f64,
}

impl ReadPeaks {
    /// Returns the error as far as these readings tell [rad]; a further one can but add to it.
    fn error_rad(&self) -> f64 {
        let others = || self.corners.iter().chain(&self.cubic);
        if !self.quintic.followed || others().any(|read| !read.followed) {
            // A rerun that could not be followed bounds nothing.
            return f64::MAX;
        }
        let change = |read: &ReadPeak| self.quintic.change(read);
        let by_corners = self.corners.iter().map(change).fold(0.0, f64::max);
        let error = self.cubic.as_ref().map_or(0.0, change) + by_corners;
        let unmoved = |read: &ReadPeak| {
            let moved_s = self.quintic.course.moved_s(&read.course);
            moved_s.is_some_and(|moved_s| moved_s <= self.apart_s)
        };
        if others().all(unmoved) {
            return error;
        }
        let range = |which: usize| {
            let angles = || others().map(|read| read.angles[which]);
            let own = self.quintic.angles[which];
            angles().fold(own, f64::max) - angles().fold(own, f64::min)
        };
        error.max(DIFFERING_TIMES * range(0).max(range(1)))
    }
}

impl RunSetup<'_> {
    fn read(&self, reading: SampleReading, variant: Variant) -> Result<ReadPeak, Error> {
        let reading = self.readings.reading(reading)?;
        let outcome = self.run(&reading, variant, self.window, RunDetail::PeakOnly)?;
        Ok(ReadPeak::of(&outcome))
    }

    /// Runs every variant on the samples, with its errors.
    pub(super) fn full_runs(
        &self,
        variants: &[Variant],
        detail: RunDetail,
    ) -> Result<Vec<VariantRun>, Error> {
        let runs = self.nominal_runs(variants, detail)?;
        // The budget tells of the largest peak.
        let largest = index_of_largest(runs.iter().map(|outcome| &outcome.run));
        self.with_their_errors(runs, Some(largest), |_| false)
    }

    /// Runs every variant on the samples, with no more of its errors than its answer takes.
    pub(super) fn answering_runs(&self, variants: &[Variant]) -> Result<Vec<VariantRun>, Error> {
        let runs = self.nominal_runs(variants, RunDetail::ErrorBound)?;
        let threshold = self.threshold_rad();
        let undecided = |run: &VariantRun| run.nominal_answer(threshold) == Answer::Undecided;
        self.with_their_errors(runs, None, undecided)
    }

    /// Gives each run its errors, or that part of the interpolation error which is `too_much`; the noise of
    /// the one that is `told`, by its place, is looked at more closely.
    pub(super) fn with_their_errors(
        &self,
        runs: Vec<RunOutcome>,
        told: Option<usize>,
        too_much: impl Fn(&VariantRun) -> bool + Sync,
    ) -> Result<Vec<VariantRun>, Error> {
        // One after the other on one thread: threads begin once for both.
        let errors = self.share(RUNS_OF_A_BOUND, &runs, |run| {
            let interpolation = self.interpolation_error(run, |error_rad| {
                too_much(&with_errors(run.clone(), error_rad, 0.0))
            })?;
            Ok((interpolation, CarriedNoise::of(self, run)?))
        })?;
        let (interpolation, mut noises): (Vec<f64>, Vec<CarriedNoise>) = errors.into_iter().unzip();
        let threshold = self.threshold_rad();
        let hangs = |place: usize, noise_rad: f64| {
            let answer = |noise_rad| {
                let (run, error_rad) = (runs[place].clone(), interpolation[place]);
                with_errors(run, error_rad, noise_rad).nominal_answer(threshold)
            };
            answer(noise_rad) != answer(0.0)
        };
        noise::draw(self, &runs, &mut noises, told, hangs)?;
        let all = runs.into_iter().zip(interpolation).zip(noises);
        Ok(all
            .map(|((outcome, error_rad), noise)| {
                let [noise_rad, between_rad] = noise.parts_rad();
                let error_rad = (error_rad + NOISE_TIMES * between_rad).min(f64::MAX);
                with_errors(outcome, error_rad, noise_rad)
            })
            .collect())
    }

    /// Returns the interpolation error of a run [rad], or as much of it as is `enough`.
    fn interpolation_error(
        &self,
        run: &RunOutcome,
        enough: impl Fn(f64) -> bool,
    ) -> Result<f64, Error> {
        let (own, variant) = (ReadPeak::of(run), variant_of(run));
        let (quintic, of_reading) = match self.readings.between() {
            Between::BandLimited => (own, 0.0),
            Between::Linear => {
                let quintic = self.read(SampleReading::Quintic, variant)?;
                (quintic, own.change(&quintic))
            }
        };
        let mut peaks = ReadPeaks {
            quintic,
            cubic: None,
            corners: Vec::new(),
            apart_s: apart_s(self.signal),
        };
        for times in CORNERS {
            let read = self.read(SampleReading::Corners(times), variant)?;
            peaks.corners.push(read);
            let error_rad = of_reading + peaks.error_rad();
            if enough(error_rad) {
                return Ok(error_rad);
            }
        }
        peaks.cubic = Some(self.read(SampleReading::Cubic, variant)?);
        Ok(of_reading + peaks.error_rad())
    }
}

/// Returns a run with its errors [rad].
fn with_errors(outcome: RunOutcome, interpolation_error_rad: f64, noise_rad: f64) -> VariantRun {
    VariantRun {
        outcome,
        interpolation_error_rad,
        noise_rad,
        share: None,
        bound: None,
    }
}
