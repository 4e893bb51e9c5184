//! What lies between samples and is not known: the interpolation error of a peak.
//!
//! The lever is replayed on other readings of its samples: by cubics in place of quintics, and with
//! corners and jumps between two samples, which no reading finds, as far as their trace in the samples as
//! recorded lets them be: once and twice, to either side. The error is the change by the cubics plus the
//! largest by corners; where the course of impacts differs on any of the six, at least three times the
//! range of their peaks. To it comes twice what a noise as strong as the cubics' change would do ([`noise`]).

use super::Answer;
use super::decision::ROUNDING_PART;
use super::decision::{NOISE_TIMES, NoiseDraws, VariantRun};
use super::noise::{self, CarriedNoise};
use super::policy::Variant;
use super::readings::{CORNERS, SampleReading};
use super::runs::{RunDetail, RunSetup, variant_of};
use crate::conditioning::Between;
use latchgate_kernel::replay::{MethodKind, Run, RunOutcome};
use latchgate_kernel::signal::Signal;
use latchgate_recording::error::Error;

/// Times the range of the peaks on all readings by which a peak is in doubt where the course of impacts
/// differs between two of them.
pub(crate) const DIFFERING_TIMES: f64 = 3.0;

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

/// The peaks of one variant on the six readings.
struct ReadPeaks<'a> {
    quintic: ReadPeak,
    cubic: ReadPeak,
    corners: &'a [ReadPeak],
    /// See [`apart_s`].
    apart_s: f64,
}

impl ReadPeaks<'_> {
    /// Returns the error that these readings tell of [rad].
    fn error_rad(&self) -> f64 {
        let reruns = || self.corners.iter().chain([&self.cubic]);
        if !self.quintic.followed || reruns().any(|read| !read.followed) {
            // A rerun that could not be followed bounds nothing.
            return f64::MAX;
        }
        let change = |read: &ReadPeak| self.quintic.change(read);
        let by_corners = self.corners.iter().map(change).fold(0.0, f64::max);
        let error = change(&self.cubic) + by_corners;
        let unmoved = |read: &ReadPeak| {
            let moved_s = self.quintic.course.moved_s(&read.course);
            moved_s.is_some_and(|moved_s| moved_s <= self.apart_s)
        };
        if reruns().all(unmoved) {
            return error;
        }
        let range = |which: usize| {
            let angles = || reruns().map(|read| read.angles[which]);
            let quintic = self.quintic.angles[which];
            angles().fold(quintic, f64::max) - angles().fold(quintic, f64::min)
        };
        error.max(DIFFERING_TIMES * range(0).max(range(1)))
    }
}

impl RunSetup<'_> {
    /// Runs every variant on the samples, with its errors.
    pub(super) fn full_runs(
        &self,
        variants: &[Variant],
        detail: RunDetail,
    ) -> Result<Vec<VariantRun>, Error> {
        let runs = self.nominal_runs(variants, detail)?;
        self.with_their_errors(runs, true)
    }

    /// Runs every variant on the samples, with its errors as far as an answer could hang on them.
    pub(super) fn answering_runs(&self, variants: &[Variant]) -> Result<Vec<VariantRun>, Error> {
        let runs = self.nominal_runs(variants, RunDetail::Errors)?;
        self.with_their_errors(runs, false)
    }

    /// Gives each run its errors; noise that is not `told` is looked at more closely only where an answer
    /// hangs on it.
    fn with_their_errors(
        &self,
        mut runs: Vec<RunOutcome>,
        told: bool,
    ) -> Result<Vec<VariantRun>, Error> {
        let interpolation = self.interpolation_errors_rad(&runs)?;
        for (run, error_rad) in runs.iter_mut().zip(&interpolation) {
            if self.rounding_decides(run, *error_rad) {
                self.narrow(run)?;
            }
        }
        let reruns = match self.readings.conditioned().noise.may_be_offset() {
            true => noise::HALF_STEPS.len(),
            false => 0,
        };
        let mut noises = self.share(reruns, &runs, |run| CarriedNoise::of(self, run))?;
        let threshold = self.threshold_rad();
        let answer = |place: usize, noise_rad| {
            let (run, error_rad) = (runs[place].clone(), interpolation[place]);
            with_errors(run, error_rad, (noise_rad, None)).nominal_answer(threshold)
        };
        noise::draw(self, &runs, &mut noises, told, answer)?;
        let runs_with_errors = runs.into_iter().zip(interpolation).zip(noises);
        Ok(runs_with_errors
            .map(|((outcome, error_rad), noise)| {
                let [noise_rad, between_rad] = noise.parts_rad();
                let error_rad = (error_rad + NOISE_TIMES * between_rad).min(f64::MAX);
                with_errors(outcome, error_rad, (noise_rad, noise.draws()))
            })
            .collect())
    }

    /// Tells whether the nominal run is decided but for what it states of its own error, where that is worth a finding.
    fn rounding_decides(&self, run: &RunOutcome, interpolation_error_rad: f64) -> bool {
        let error_rad = run.run.numerical_error_rad.max(run.coast_error_rad);
        let is_large = error_rad > ROUNDING_PART * self.threshold_rad();
        if !is_large || run.run.method != MethodKind::EventDriven {
            return false;
        }
        let answer = |run: RunOutcome| {
            with_errors(run, interpolation_error_rad, (0.0, None))
                .nominal_answer(self.threshold_rad())
        };
        let mut exact = run.clone();
        exact.run.numerical_error_rad = 0.0;
        exact.coast_error_rad = 0.0;
        answer(run.clone()) == Answer::Undecided && answer(exact) != Answer::Undecided
    }

    /// Returns the interpolation error of each run [rad].
    fn interpolation_errors_rad(&self, runs: &[RunOutcome]) -> Result<Vec<f64>, Error> {
        if self.readings.is_exact() {
            return Ok(vec![0.0; runs.len()]);
        }
        let mut readings = vec![SampleReading::Cubic];
        readings.extend(CORNERS.map(SampleReading::Corners));
        if self.readings.conditioned().second.is_some() {
            readings.extend(CORNERS.map(SampleReading::OpposedCorners));
        }
        let corners_end = readings.len();
        if self.readings.between() == Between::Linear {
            readings.push(SampleReading::Quintic);
        }
        let of_readings = |run| {
            readings
                .iter()
                .map(move |reading| (variant_of(run), *reading))
        };
        let tasks: Vec<(Variant, SampleReading)> = runs.iter().flat_map(of_readings).collect();
        let peaks = self.share(1, &tasks, |(variant, reading)| {
            let reading = self.readings.reading(*reading)?;
            let outcome = self.run(&reading, *variant, self.window, RunDetail::PeakOnly)?;
            Ok(ReadPeak::of(&outcome))
        })?;
        let error_rad = |(run, peaks): (&RunOutcome, &[ReadPeak])| {
            let run_peak = ReadPeak::of(run);
            let (reruns, quintic) = peaks.split_at(corners_end);
            let quintic = *quintic.first().unwrap_or(&run_peak);
            let peaks = ReadPeaks {
                quintic,
                cubic: reruns[0],
                corners: &reruns[1..],
                apart_s: apart_s(self.signal),
            };
            run_peak.change(&quintic) + peaks.error_rad()
        };
        let of_runs = peaks.chunks(readings.len());
        Ok(runs.iter().zip(of_runs).map(error_rad).collect())
    }
}

/// Returns a run with its errors [rad].
fn with_errors(
    outcome: RunOutcome,
    interpolation_error_rad: f64,
    (noise_rad, noise_draws): (f64, Option<NoiseDraws>),
) -> VariantRun {
    VariantRun {
        outcome,
        interpolation_error_rad,
        noise_rad,
        noise_draws,
        share: None,
        bound: None,
    }
}
