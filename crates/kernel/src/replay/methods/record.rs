//! What is kept of a motion that a method gives step by step.

use super::super::TracePoint;
use super::super::recorder::{COUNTED_SPEED, LISTED_IMPACTS};
use super::{Problem, point};
use crate::numerics::polynomial;

/// Peak, crossings, impacts and trace.
#[derive(Debug, Clone)]
pub(in super::super) struct Record {
    threshold: f64,
    judged_from: f64,
    /// Largest angle [rad].
    pub(in super::super) peak_angle: f64,
    /// Time of it [s].
    pub(in super::super) peak_time: f64,
    /// Lowest angle at the end of a step [rad].
    pub(in super::super) lowest: f64,
    pub(in super::super) first_crossing: Option<f64>,
    pub(in super::super) time_above: f64,
    above: bool,
    pub(in super::super) first_release: Option<f64>,
    pub(in super::super) impacts: u64,
    pub(in super::super) impact_list: Vec<[f64; 2]>,
    pub(in super::super) trace: Option<Vec<TracePoint>>,
}

impl Record {
    /// Starts with the lever where it is when the run starts.
    pub(super) fn new<E>(problem: &Problem<'_, E>, angle: f64, velocity: f64) -> Self {
        let (start, threshold) = (problem.start_s, problem.design.criterion.threshold_rad);
        let judged_from = problem.judged_from_s;
        let mut record = Self {
            threshold,
            judged_from,
            peak_angle: f64::NEG_INFINITY,
            peak_time: start,
            lowest: angle,
            first_crossing: None,
            time_above: 0.0,
            above: false,
            first_release: None,
            impacts: 0,
            impact_list: Vec::new(),
            trace: problem.trace.then(Vec::new),
        };
        if angle > 0.0 || (angle >= 0.0 && velocity > 0.0) {
            record.first_release = Some(start);
        }
        record.offer(angle, start);
        if start >= judged_from && angle > threshold {
            record.first_crossing = Some(start);
            record.above = true;
        }
        record.keep(start, angle, velocity);
        record
    }

    /// Adds a point to the trace.
    #[inline]
    pub(super) fn keep(&mut self, time: f64, angle: f64, velocity: f64) {
        point(&mut self.trace, time, angle, velocity);
    }

    /// Takes in an angle that was reached.
    #[inline]
    pub(super) fn offer(&mut self, angle: f64, time: f64) {
        self.lowest = self.lowest.min(angle);
        if time >= self.judged_from && angle > self.peak_angle {
            (self.peak_angle, self.peak_time) = (angle, time);
        }
    }

    /// Takes in the end of a step of `length` [s] whose inside is not known.
    #[inline]
    pub(super) fn grid_point(&mut self, time: f64, length: f64, angle: f64) {
        self.offer(angle, time);
        if angle > 0.0 {
            self.release(time);
        }
        if time >= self.judged_from && angle > self.threshold {
            self.first_crossing.get_or_insert(time);
            self.time_above += length;
        }
    }

    /// Takes in the part up to `part` of a step that starts at `time` and lasts `length` [s],
    /// over which the angle is a polynomial in the part of the step.
    #[inline]
    pub(super) fn stretch(&mut self, coefficients: &[f64], part: f64, time: f64, length: f64) {
        let end = polynomial::evaluate(coefficients, part);
        self.lowest = self.lowest.min(end);
        if time < self.judged_from {
            return;
        }
        let (start, slope) = (coefficients[0], coefficients[1]);
        let bend: f64 = coefficients[2..].iter().map(|c| c.abs()).sum();
        let highest = start + slope.max(0.0) + bend;
        if highest > self.peak_angle {
            self.offer(end, time + part * length);
            self.offer_maxima(coefficients, part, time, length);
        }
        let lowest = start + slope.min(0.0) - bend;
        if lowest <= self.threshold && (highest > self.threshold || self.above) {
            self.cross(coefficients, part, time, length, end);
        } else if self.above {
            self.time_above += part * length;
        }
    }

    #[cold]
    fn cross(&mut self, coefficients: &[f64], part: f64, time: f64, length: f64, end: f64) {
        let mut shifted = [0.0; polynomial::CAPACITY];
        let shifted = &mut shifted[..coefficients.len()];
        shifted.copy_from_slice(coefficients);
        shifted[0] -= self.threshold;
        let mut from = 0.0;
        polynomial::sign_changes(shifted, part, &mut |x, rises| {
            if rises && !self.above {
                self.first_crossing.get_or_insert(time + x * length);
                self.above = true;
            } else if !rises && self.above {
                self.time_above += (x - from) * length;
                self.above = false;
            }
            from = x;
            true
        });
        // A crossing on the joint of two steps is seen by neither.
        if end > self.threshold && !self.above {
            self.first_crossing.get_or_insert(time + part * length);
            self.above = true;
        } else if self.above {
            self.time_above += (part - from) * length;
            self.above = end > self.threshold;
        }
    }

    fn offer_maxima(&mut self, coefficients: &[f64], part: f64, time: f64, length: f64) {
        let mut slopes = [0.0; polynomial::CAPACITY];
        let mut n = 1.0;
        for (to, from) in slopes.iter_mut().zip(&coefficients[1..]) {
            *to = n * from;
            n += 1.0;
        }
        polynomial::sign_changes(&slopes[..coefficients.len() - 1], part, &mut |x, rises| {
            if !rises {
                self.offer(polynomial::evaluate(coefficients, x), time + x * length);
            }
            true
        });
    }

    /// Takes in the instant at which the angle becomes positive.
    #[inline]
    pub(super) fn release(&mut self, time: f64) {
        if self.first_release.is_none() {
            self.first_release = Some(time);
        }
    }

    /// Takes in an impact, or an entry into contact, with the angular velocity before it.
    pub(super) fn impact(&mut self, time: f64, velocity: f64) {
        if velocity.abs() > COUNTED_SPEED {
            self.impacts += 1;
            if self.impact_list.len() < LISTED_IMPACTS {
                self.impact_list.push([time, velocity]);
            }
        }
    }
}
