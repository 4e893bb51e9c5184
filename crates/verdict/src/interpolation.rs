//! What straight lines between samples leave out: a bound on the interpolation error of a peak.
//!
//! The lever is replayed on other readings of the samples. Refined twofold and fourfold within
//! their band the change of the peak falls by four each time where the motion is regular, and its
//! limit follows. Where it does not, or where impacts come in another order, the samples are
//! refined sixteenfold and the largest change counts twice; where they differ even then, the
//! peak may be off by several times the largest angle seen. What no refinement can see, corners and
//! jumps between two samples, is added: the largest change by their trace, once and twice, to either
//! side; it counts twice where it changes the order of impacts. Where that differs on any reading, the
//! error is at least three times the range of all peaks.

use super::Answer;
use super::decision::VariantRun;
use super::policy::Variant;
use super::proof;
use super::readings::{CORNERS, FINE_FACTOR, SampleReading};
use super::runs::{RunDetail, RunSetup};
use super::screen::{self, Decided, Subject};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{Method, Run, RunOutcome};
use latchgate_kernel::signal::Signal;
use latchgate_recording::error::Error;

/// Largest part of one refinement's change that the next may bring, for the change to be taken
/// as of second order, whose part is a quarter.
const REGULAR_PART: f64 = 0.35;

/// Change of a second-order error in the limit, by that from one sample to four.
const LIMIT: f64 = 16.0 / 15.0;

/// Returns the times the largest angle seen by which a peak is in doubt where refinement does not end:
/// by the nominal run alone, or with an ensemble, in which chaos shows as scatter. In 257 such scenes of
/// 3000 the formula went 3.4 times as far beyond the samples' own peak, once.
pub(crate) fn doubt_part(with_members: bool) -> f64 {
    if with_members { 1.5 } else { 4.0 }
}

/// The same where refinement ends and corners alone change the order of impacts; twice it was needed.
const CORNER_DOUBT_PART: f64 = 1.5;

/// Times the range of the peaks on all readings by which a peak is in doubt where the course of impacts
/// differs between two of them.
pub(crate) const DIFFERING_TIMES: f64 = 3.0;

/// Times that the samples are run, counted as such, for the bound of one run.
const RUNS_OF_A_BOUND: usize = 10;

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
}

/// The peaks of one variant on the readings that every bound needs.
struct ReadPeaks {
    own: ReadPeak,
    twofold: ReadPeak,
    fourfold: ReadPeak,
    /// With each multiple of [`CORNERS`].
    corners: [ReadPeak; CORNERS.len()],
    /// A coast was followed on the samples themselves.
    coasts: bool,
    numerical_error_rad: f64,
    /// See [`apart_s`].
    apart_s: f64,
}

impl ReadPeaks {
    fn same_course(&self, a: &ReadPeak, b: &ReadPeak) -> bool {
        let moved_s = a.course.moved_s(&b.course);
        moved_s.is_some_and(|moved_s| moved_s <= self.apart_s)
    }

    /// The angles that count: that of the window, and with a coast that of both.
    fn counted(&self) -> std::ops::Range<usize> {
        0..1 + usize::from(self.coasts)
    }

    /// Tells whether refinement shows a change of second order and the same impacts throughout.
    fn regular(&self) -> bool {
        let Self {
            own,
            twofold,
            fourfold,
            ..
        } = self;
        let quarters = |which: usize| {
            let before = (twofold.angles[which] - own.angles[which]).abs();
            let after = (fourfold.angles[which] - twofold.angles[which]).abs();
            after <= (REGULAR_PART * before).max(self.numerical_error_rad)
        };
        self.counted().all(quarters)
            && self.same_course(own, twofold)
            && self.same_course(own, fourfold)
    }

    /// Returns the bound [rad]; `sixteenfold` is the peak of that refinement, if it was made,
    /// `doubt_part` the times by which a peak is in doubt where refinement does not end.
    fn bound(&self, sixteenfold: Option<&ReadPeak>, doubt_part: f64) -> f64 {
        let refined = [Some(&self.twofold), Some(&self.fourfold), sixteenfold];
        let refined = refined.into_iter().flatten();
        let all = refined.clone().chain(&self.corners);
        if all.clone().any(|read| !read.followed) {
            // A rerun that could not be followed bounds nothing.
            return f64::MAX;
        }
        let regular = self.regular();
        let ends = sixteenfold.is_some_and(|finest| self.same_course(&self.fourfold, finest));
        // Where corners change the order of impacts they may do so to more effect than was tried.
        let unmoved = |read: &ReadPeak| self.same_course(&self.own, read);
        let by_corners = !self.corners.iter().all(unmoved);
        let by_any = !all.clone().all(unmoved);
        let of_one = |which: usize| {
            let angle = |read: &ReadPeak| read.angles[which];
            let own = angle(&self.own);
            let change = |read: &ReadPeak| (angle(read) - own).abs();
            let times = if by_corners { 2.0 } else { 1.0 };
            let corners = times * self.corners.iter().map(change).fold(0.0, f64::max);
            let highest = all.clone().map(angle).fold(own, f64::max);
            let lowest = all.clone().map(angle).fold(own, f64::min);
            let refinement = if regular {
                // A sixteenth of the whole is missing, a third of the second change; the whole of it
                // leaves room for an order below the second.
                let second = (angle(&self.fourfold) - angle(&self.twofold)).abs();
                change(&self.fourfold) + second
            } else {
                let last = |finest| (angle(finest) - angle(&self.fourfold)).abs();
                let changes = refined.clone().map(change).chain(sixteenfold.map(last));
                let part = match (ends, by_corners) {
                    (true, false) => 0.0,
                    (true, true) => CORNER_DOUBT_PART,
                    (false, _) => doubt_part,
                };
                (2.0 * LIMIT * changes.fold(0.0, f64::max)).max(part * highest)
            };
            let differing = if by_any { DIFFERING_TIMES } else { 0.0 };
            (refinement + corners).max(differing * (highest - lowest))
        };
        self.counted().map(of_one).fold(0.0, f64::max)
    }
}

/// What [`RunSetup::change_at_most`] says of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum KnownChange {
    /// It was not asked.
    Unasked,
    /// No bound keeps the lever below the threshold.
    Unproven,
    /// The peak moves by no more [rad].
    AtMost(f64),
}

impl From<Option<f64>> for KnownChange {
    fn from(proven: Option<f64>) -> Self {
        proven.map_or(Self::Unproven, Self::AtMost)
    }
}

impl RunSetup<'_> {
    fn read(&self, reading: SampleReading, variant: Variant) -> Result<RunOutcome, Error> {
        let factor = reading.factor();
        let window = self
            .window
            .map(|(first, last)| (factor * first, factor * last));
        let signal = self.readings.signal(reading)?;
        self.run(&signal, variant, window, RunDetail::PeakOnly)
    }

    /// Sets each run beside the same on other readings of its samples; one with a `stand_in`, which
    /// states its error without a further run, becomes that. `proven` says of the runs, in their order,
    /// what [`Self::change_at_most`] does, as far as it was asked.
    pub(super) fn refined(
        &self,
        runs: Vec<RunOutcome>,
        stand_ins: Vec<Option<VariantRun>>,
        proven: &[KnownChange],
    ) -> Result<Vec<VariantRun>, Error> {
        let unasked = std::iter::repeat(KnownChange::Unasked);
        let known = proven.iter().copied().chain(unasked);
        let open: Vec<(&RunOutcome, KnownChange)> = runs
            .iter()
            .zip(known)
            .zip(&stand_ins)
            .filter(|(_, stand_in)| stand_in.is_none())
            .map(|(open, _)| open)
            .collect();
        let mut bounds = self.bounds(&open)?.into_iter();
        let all = runs.into_iter().zip(stand_ins);
        Ok(all
            .filter_map(|(outcome, stand_in)| {
                stand_in.or_else(|| Some(with_error(outcome, bounds.next()?)))
            })
            .collect())
    }

    /// Returns what each run says alone, as [`Self::refined`] would have it, with no more further
    /// runs than that takes: three readings show most answers beyond doubt.
    pub(super) fn answers(
        &self,
        runs: &[RunOutcome],
        stand_ins: Vec<Option<VariantRun>>,
    ) -> Result<Vec<Answer>, Error> {
        let threshold = self.threshold_rad();
        let stand_ins: Vec<(&RunOutcome, Option<VariantRun>)> =
            runs.iter().zip(stand_ins).collect();
        let rough = self.share(6, &stand_ins, |(outcome, stand_in)| match stand_in {
            Some(stand_in) => Ok(Some(stand_in.nominal_answer(threshold))),
            None => self.clear_answer(outcome),
        })?;
        let open = runs.iter().zip(&rough);
        let open: Vec<RunOutcome> = open
            .filter(|(_, answer)| answer.is_none())
            .map(|(outcome, _)| outcome.clone())
            .collect();
        let none = vec![None; open.len()];
        let mut refined = self.refined(open, none, &[])?.into_iter();
        let answers = rough.into_iter();
        Ok(answers
            .filter_map(|answer| answer.or_else(|| Some(refined.next()?.nominal_answer(threshold))))
            .collect())
    }

    /// Returns what a run says alone where its fourfold and twice the trace of corners put that beyond
    /// doubt: no answer, which a larger error could only confirm; or a peak below a third or above three
    /// times the threshold that lies eight times further away than any of them moves it.
    fn clear_answer(&self, outcome: &RunOutcome) -> Result<Option<Answer>, Error> {
        const TIMES: f64 = 3.0;
        const ROOM: f64 = 8.0;
        let threshold = self.threshold_rad();
        let own = ReadPeak::of(outcome);
        let answer_with = |interpolation_error_rad: f64| {
            with_error(outcome.clone(), interpolation_error_rad).nominal_answer(threshold)
        };
        let mut change = 0.0_f64;
        let corners = CORNERS.into_iter().take(2).map(SampleReading::Corners);
        for reading in std::iter::once(SampleReading::Fourfold).chain(corners) {
            let read = ReadPeak::of(&self.read(reading, variant_of(outcome))?);
            for which in [0, 1] {
                change = change.max((read.angles[which] - own.angles[which]).abs());
            }
            if !read.followed {
                change = f64::MAX;
            }
            if answer_with(change) == Answer::Undecided {
                return Ok(Some(Answer::Undecided));
            }
        }
        let far = own.angles[1] < threshold / TIMES || own.angles[0] > threshold * TIMES;
        let answer = answer_with(change);
        let clear = far && answer_with(ROOM * change) == answer;
        Ok(clear.then_some(answer))
    }

    /// Bounds the interpolation error of each run [rad].
    fn bounds(&self, runs: &[(&RunOutcome, KnownChange)]) -> Result<Vec<f64>, Error> {
        self.share(RUNS_OF_A_BOUND, runs, |(run, known)| {
            let proven = match known {
                KnownChange::Unasked => self.change_at_most(run),
                KnownChange::Unproven => None,
                KnownChange::AtMost(change_rad) => Some(*change_rad),
            };
            self.bound(run, proven, |_| false)
        })
    }

    /// Bounds the interpolation error of a run [rad], of which `proven` is a bound already; where less
    /// than the whole of it is `enough`, it may be that.
    fn bound(
        &self,
        run: &RunOutcome,
        proven: Option<f64>,
        enough: impl Fn(f64) -> bool,
    ) -> Result<f64, Error> {
        let own = ReadPeak::of(run);
        let variant = variant_of(run);
        let read = |reading| Ok::<_, Error>(ReadPeak::of(&self.read(reading, variant)?));
        let least = |measured: f64| proven.map_or(measured, |proven| measured.min(proven));
        let change = |of: &ReadPeak| (of.angles[0] - own.angles[0]).abs();
        // The cheap ones first: what corners and the fourfold change is part of every bound.
        let mut corners = [own; CORNERS.len()];
        let mut seen = 0.0_f64;
        for (peak, times) in corners.iter_mut().zip(CORNERS) {
            *peak = read(SampleReading::Corners(times))?;
            seen = seen.max(change(peak));
            if enough(least(seen)) {
                return Ok(least(seen));
            }
        }
        let fourfold = read(SampleReading::Fourfold)?;
        seen += change(&fourfold);
        if enough(least(seen)) {
            return Ok(least(seen));
        }
        let peaks = ReadPeaks {
            own,
            twofold: read(SampleReading::Twofold)?,
            fourfold,
            corners,
            coasts: run.run.coast_peak_angle_rad.is_some(),
            numerical_error_rad: run.run.numerical_error_rad,
            apart_s: apart_s(self.signal),
        };
        let regular = peaks.regular();
        // The finest can but add to what is seen without it.
        let seen = if regular { 0.0 } else { peaks.bound(None, 0.0) };
        if enough(least(seen)) {
            return Ok(least(seen));
        }
        let wanted = !regular && self.readings.has_sixteenfold();
        let finest = wanted
            .then(|| read(SampleReading::Sixteenfold))
            .transpose()?;
        let doubt_part = doubt_part(self.policy.members > 0);
        Ok(least(peaks.bound(finest.as_ref(), doubt_part)))
    }

    /// Runs every variant on the samples and on their other readings.
    pub(super) fn full_runs(
        &self,
        variants: &[Variant],
        detail: RunDetail,
    ) -> Result<Vec<VariantRun>, Error> {
        let runs = self.nominal_runs(variants, detail)?;
        let none = vec![None; runs.len()];
        self.refined(runs, none, &[])
    }

    /// Runs every variant, in the order given, with no more further runs than it takes to know
    /// whether all of them pass alone, or else the first one seen that does not. Where a proof in
    /// closed form is enough for that, it stands for the error.
    pub(super) fn passing_runs(
        &self,
        variants: &[Variant],
    ) -> Result<Result<Vec<VariantRun>, Variant>, Error> {
        let passes = |run: &VariantRun| run.nominal_answer(self.threshold_rad()) == Answer::Pass;
        let mut outcomes = Vec::with_capacity(variants.len());
        for variant in variants {
            let alone = self.nominal_runs(&[*variant], RunDetail::ErrorBound)?;
            let alone = alone.into_iter().map(|outcome| with_error(outcome, 0.0));
            outcomes.extend(alone);
            // A larger error could only confirm it.
            if !outcomes.last().is_some_and(passes) {
                return Ok(Err(*variant));
            }
        }
        let mut runs = Vec::with_capacity(variants.len());
        for run in outcomes {
            let run = self.enough_known(run.outcome, passes, |run| !passes(run))?;
            if !passes(&run) {
                return Ok(Err(run.variant()));
            }
            runs.push(run);
        }
        Ok(Ok(runs))
    }

    /// Returns a run with the error that a proof in closed form leaves, where that is `enough`; with
    /// the error of its other readings where it is not, or that part of it which is `too_much`.
    pub(super) fn enough_known(
        &self,
        outcome: RunOutcome,
        enough: impl Fn(&VariantRun) -> bool,
        too_much: impl Fn(&VariantRun) -> bool,
    ) -> Result<VariantRun, Error> {
        let may_be_proven = proof::decided(self, variant_of(&outcome)) == Some(Decided::Pass);
        let proven = may_be_proven
            .then(|| self.change_at_most(&outcome))
            .flatten();
        if let Some(error_rad) = proven {
            let run = with_error(outcome.clone(), error_rad);
            if enough(&run) {
                return Ok(run);
            }
        }
        let error_rad = self.bound(&outcome, proven, |error_rad| {
            too_much(&with_error(outcome.clone(), error_rad))
        })?;
        Ok(with_error(outcome, error_rad))
    }

    /// Returns what a nominal run says alone. Of one that was left out because nearly all
    /// scattered levers cross, the error is not known: its other readings are run.
    pub(super) fn nominal_answer(&self, of: &VariantRun) -> Result<Answer, Error> {
        let answer = of.nominal_answer(self.threshold_rad());
        if !(of.left_out && answer == Answer::Undecided) {
            return Ok(answer);
        }
        let refined = self.refined(vec![of.outcome.clone()], vec![None], &[])?;
        Ok(refined
            .first()
            .map_or(answer, |run| run.nominal_answer(self.threshold_rad())))
    }

    /// Bounds the change of peak and of coast peak by any reading of the samples, where a bound in
    /// closed form keeps the lever below the threshold on all of them.
    ///
    /// With F the largest such bound and −δ the angle at rest, at which every run begins, the peak
    /// on any reading lies between −δ and F. So it differs from a peak P by at most F − P or
    /// P + δ, and with H the larger of P and the coast's peak, F − P and H + δ bound both changes.
    pub(super) fn change_at_most(&self, outcome: &RunOutcome) -> Option<f64> {
        let Variant { opens_when, model } = variant_of(outcome);
        let rest = match model {
            StopModel::Rigid => 0.0,
            // In a window that begins later the lever may have been pressed deeper.
            StopModel::Soft if self.window.is_some() => return None,
            StopModel::Soft => -self.design.stop.rest_angle_rad(&self.design.lever),
        };
        // No bound keeps a lever that crosses on its own samples.
        if outcome.broke_down
            || outcome.run.peak_angle_rad > self.threshold_rad()
            || self.initial(model).is_some()
            || self.policy.method != Method::EventDriven
        {
            return None;
        }
        let subject = Subject {
            lever: self.design.lever,
            stop: self.design.stop,
            model,
            threshold_rad: self.threshold_rad(),
            initial: None,
            window: self
                .window
                .map(|(first, last)| (FINE_FACTOR * first, FINE_FACTOR * last)),
        };
        let mut most = 0.0_f64;
        for seen in self.readings.fine(opens_when) {
            most = most.max(screen::peak_at_most(&subject, &seen.ok()?)?);
        }
        let [peak, highest] = ReadPeak::of(outcome).angles;
        Some((most - peak).max(highest + rest).max(0.0))
    }
}

/// Returns a run with its interpolation error [rad].
fn with_error(outcome: RunOutcome, interpolation_error_rad: f64) -> VariantRun {
    VariantRun {
        outcome,
        interpolation_error_rad,
        share: None,
        left_out: false,
    }
}

fn variant_of(outcome: &RunOutcome) -> Variant {
    Variant {
        opens_when: outcome.run.opens_when,
        model: outcome.run.model,
    }
}
