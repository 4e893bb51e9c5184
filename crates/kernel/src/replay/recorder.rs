//! What is kept of a trajectory: peak, crossings of the threshold, impacts, trace.

use super::TracePoint;
use super::taylor::{AngleSlope, TaylorSeries};
use crate::numerics::polynomial;

/// Impacts slower than this are not counted [rad/s].
pub(super) const COUNTED_SPEED: f64 = 1e-3;

/// Impacts listed at most.
pub(super) const LISTED_IMPACTS: usize = 200;

/// Points that a step of the kernel adds to the trace at most.
const POINTS_WITHIN_MAX: f64 = 1e4;

/// Largest angle so far, with the error it carries.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peak {
    /// Angle [rad].
    pub(super) angle: f64,
    /// Time [s].
    pub(super) time: f64,
    /// Bound on the angle's error [rad].
    pub(super) error: f64,
    /// Largest angle plus error of any local maximum [rad]: a later, less certain maximum
    /// may be the true peak.
    pub(super) upper: f64,
}

impl Peak {
    pub(super) fn at(angle: f64, time: f64, error: f64) -> Self {
        Self {
            angle,
            time,
            error,
            upper: angle + error,
        }
    }

    /// Takes in a candidate.
    #[inline]
    pub(super) fn offer(&mut self, angle: f64, time: f64, error: f64) {
        self.upper = self.upper.max(angle + error);
        if angle > self.angle {
            self.angle = angle;
            self.time = time;
            self.error = error;
        }
    }

    /// Returns the bound on the error of the peak [rad].
    pub(super) fn bound(&self) -> f64 {
        self.error.max(self.upper - self.angle)
    }
}

/// Everything that is kept of one run.
#[derive(Debug, Clone)]
pub(super) struct Recorder {
    pub(super) threshold: f64,
    /// False before the judged window.
    pub(super) judging: bool,
    /// Turns that stay below need not be noted [rad].
    asked_from: f64,
    pub(super) peak: Peak,
    pub(super) first_crossing: Option<f64>,
    pub(super) time_above: f64,
    above_since: Option<f64>,
    pub(super) first_release: Option<f64>,
    pub(super) impacts: u64,
    /// Neither impacts are asked for nor when the lever comes to rest.
    pub(super) peak_alone: bool,
    pub(super) impact_list: Vec<[f64; 2]>,
    pub(super) trace: Option<Vec<TracePoint>>,
    /// Longest time between points of the trace in motion [s]: a longer step of the kernel gets
    /// points in between, from its own series.
    pub(super) trace_gap_s: f64,
}

impl Recorder {
    pub(super) fn new(threshold: f64, trace: bool) -> Self {
        Self {
            threshold,
            judging: false,
            asked_from: f64::NEG_INFINITY,
            peak: Peak::at(f64::NEG_INFINITY, 0.0, 0.0),
            first_crossing: None,
            time_above: 0.0,
            above_since: None,
            first_release: None,
            impacts: 0,
            peak_alone: false,
            impact_list: Vec::with_capacity(LISTED_IMPACTS),
            trace: trace.then(Vec::new),
            trace_gap_s: f64::INFINITY,
        }
    }

    /// Keeps the peak alone.
    pub(super) fn peak_only() -> Self {
        Self {
            impact_list: Vec::new(),
            ..Self::new(f64::INFINITY, false)
        }
    }

    /// Keeps the peak alone of a lever of whose impacts and rests nothing is asked, nor of turns below
    /// `angle` [rad].
    pub(super) fn peak_from(angle: f64) -> Self {
        Self {
            asked_from: angle,
            peak_alone: true,
            ..Self::peak_only()
        }
    }

    /// Starts judging at `time` with the lever at `angle`.
    pub(super) fn open_window(&mut self, angle: f64, time: f64, error: f64) {
        self.judging = true;
        self.peak = Peak::at(angle, time, error);
        if angle > self.threshold {
            self.first_crossing = Some(time);
            self.above_since = Some(time);
        }
    }

    /// Ends judging at `time` with the lever at `angle`.
    pub(super) fn close_window(&mut self, angle: f64, time: f64, error: f64) {
        self.peak.offer(angle, time, error);
        self.judging = false;
        if let Some(since) = self.above_since.take() {
            self.time_above += time - since;
        }
        // A maximum within rounding of the threshold: the peak decides.
        if self.peak.angle <= self.threshold {
            self.first_crossing = None;
            self.time_above = 0.0;
        } else {
            self.first_crossing.get_or_insert(self.peak.time);
        }
    }

    /// Returns the angle above which a turn is noted [rad].
    pub(super) fn highest(&self) -> f64 {
        self.peak.angle.max(self.asked_from)
    }

    /// Returns what a stretch must stay clear of to need no look: the height up to which a turn
    /// cannot be the peak, given the angle's `error` [rad], the threshold, and whether the lever is
    /// above it.
    #[inline]
    pub(super) fn awaits(&self, error: f64) -> (f64, f64, bool) {
        if self.judging {
            let peak = self.peak.angle.min(self.peak.upper - error);
            (
                peak.max(self.asked_from),
                self.threshold,
                self.above_since.is_some(),
            )
        } else {
            (f64::INFINITY, f64::INFINITY, false)
        }
    }

    /// Takes in the stretch of `series` up to `part`, which starts at `time` and whose whole
    /// step is `step` [s].
    #[inline]
    pub(super) fn stretch<const N: usize>(
        &mut self,
        series: &TaylorSeries<N>,
        part: f64,
        time: f64,
        step: f64,
        error: impl FnOnce() -> f64,
    ) {
        if part * step > self.trace_gap_s {
            self.points_within(series, part, time, step);
        }
        if !self.judging {
            return;
        }
        let (start, slope, curved) = (series.start(), series.slope(), series.curved);
        let highest = start + (slope + curved.angle).max(0.0);
        // Only a turning point can be a peak; the ends of the window are offered apart. A
        // hundredth more keeps a turn on the joint of two stretches from falling through.
        if slope.abs() <= 1.01 * curved.slope && highest > self.asked_from {
            let error = error();
            // An earlier, less certain maximum must not hide a higher one.
            if highest > self.peak.angle || highest + error > self.peak.upper {
                self.offer_maxima(series, part, time, step, error);
            }
        }
        let lowest = start + (slope - curved.angle).min(0.0);
        if lowest <= self.threshold && (highest > self.threshold || self.above_since.is_some()) {
            self.cross_threshold(series, part, time, step);
        }
    }

    #[cold]
    #[inline(never)]
    fn cross_threshold<const N: usize>(
        &mut self,
        series: &TaylorSeries<N>,
        part: f64,
        time: f64,
        step: f64,
    ) {
        let mut shifted = [0.0; N];
        let shifted = &mut shifted[..series.coefficients().len()];
        shifted.copy_from_slice(series.coefficients());
        shifted[0] -= self.threshold;
        if shifted[0] >= 0.0 && series.slope() > 0.0 && self.above_since.is_none() {
            // A rise that begins on the threshold is no change of sign.
            self.first_crossing.get_or_insert(time);
            self.above_since = Some(time);
        }
        polynomial::sign_changes(shifted, part, &mut |x, rises| {
            let instant = time + x * step;
            if rises && self.above_since.is_none() {
                self.first_crossing.get_or_insert(instant);
                self.above_since = Some(instant);
            } else if !rises && let Some(since) = self.above_since.take() {
                self.time_above += instant - since;
            }
            true
        });
        // A crossing that falls on the joint of two stretches is seen by neither.
        let end = series.at(part).angle;
        let instant = time + part * step;
        if end > self.threshold && self.above_since.is_none() {
            let instant = if shifted[0] >= 0.0 { time } else { instant };
            self.first_crossing.get_or_insert(instant);
            self.above_since = Some(instant);
        } else if end < self.threshold
            && let Some(since) = self.above_since.take()
        {
            self.time_above += instant - since;
        }
    }

    #[cold]
    #[inline(never)]
    fn offer_maxima<const N: usize>(
        &mut self,
        series: &TaylorSeries<N>,
        part: f64,
        time: f64,
        step: f64,
        error: f64,
    ) {
        let (derivative, count) = series.derivative();
        polynomial::sign_changes(&derivative[..count], part, &mut |x, rises| {
            if !rises {
                self.peak.offer(series.at(x).angle, time + x * step, error);
            }
            true
        });
        self.peak.offer(series.start(), time, error);
        self.peak
            .offer(series.at(part).angle, time + part * step, error);
    }

    /// Adds points inside a step to the trace.
    #[cold]
    #[inline(never)]
    fn points_within<const N: usize>(
        &mut self,
        series: &TaylorSeries<N>,
        part: f64,
        time: f64,
        step: f64,
    ) {
        let pieces = (part * step / self.trace_gap_s)
            .ceil()
            .min(POINTS_WITHIN_MAX);
        let mut piece = 1.0;
        while piece < pieces {
            let x = part * piece / pieces;
            let AngleSlope { angle, slope } = series.at(x);
            self.point(time + x * step, angle, slope / step);
            piece += 1.0;
        }
    }

    /// Takes in an impact or contact entry with `velocity` before it.
    pub(super) fn impact(&mut self, time: f64, velocity: f64) {
        if velocity.abs() > COUNTED_SPEED {
            self.impacts += 1;
            if self.impact_list.len() < self.impact_list.capacity().min(LISTED_IMPACTS) {
                self.impact_list.push([time, velocity]);
            }
        }
    }

    /// Takes in the instant at which the angle becomes positive.
    pub(super) fn release(&mut self, time: f64) {
        self.first_release.get_or_insert(time);
    }

    /// Adds a point to the trace, if one is kept.
    #[inline]
    pub(super) fn point(&mut self, time_s: f64, angle_rad: f64, velocity_rad_s: f64) {
        if let Some(trace) = &mut self.trace {
            trace.push(TracePoint {
                time_s,
                angle_rad,
                velocity_rad_s,
            });
        }
    }
}
