//! The kernel's fast lane: whole samples of free flight in which nothing can happen.
//!
//! A sample belongs here if bounds known before the step exclude an impact, a turning point that
//! could be the peak, and a crossing of the threshold. Then only the state at its end is wanted:
//! no polynomial is kept and no root sought. Every other sample is left to
//! [`super::kernel::Kernel::advance`].
//!
//! The arithmetic is fused (one rounding for a product and a sum), by the machine's instruction
//! where there is one and by a slow but equal routine where there is none: the numbers are the
//! same on every machine.

use super::eventless_step::{Bounds, LaneState, Push, StepCoefficients, TURN_MAX};
use super::kernel::{Kernel, PEAK_TRUNCATION};
use super::sensitivity::Smooths;
use super::taylor::{Tolerance, Turned};
use crate::signal::{Pieces, STRAIGHT, value};

/// Steps whose error is carried along together.
const TOGETHER: u32 = 16;

/// Samples after which sine and cosine are computed afresh, so that their rounding does not add
/// up; a multiple of [`TOGETHER`].
const FRESH_EVERY: usize = 64;

/// A lever's flight with time in sample intervals.
#[derive(Debug, Clone, Copy)]
pub(super) struct FastFlight {
    /// Sample interval [s].
    interval: f64,
    coefficients: StepCoefficients<f64>,
    /// Recorded acceleration to b, sign included.
    gain: f64,
    /// The same of what acts across, which has no sign.
    gain_across: f64,
    /// Truncation let pass.
    tolerance: Tolerance,
    /// Six orders are tried, which mostly suffice for refined samples; never where an error is
    /// stated, since what they leave out is an estimate.
    six: bool,
}

/// What excludes events for the next few samples.
struct Calm {
    /// A turning point up to here cannot be the peak.
    peak: f64,
    /// No impact, nor a doubt about one, above here.
    floor: f64,
    threshold: f64,
    above: bool,
    /// A stop or a gate, or a doubt about one, from here on.
    ceiling: f64,
}

impl FastFlight {
    /// Scales the right-hand side of `kernel` to samples of `interval` [s] of accelerations that
    /// count with `sign`; `None` if a sample is too long for the lever's own motion.
    pub(super) fn new(kernel: &Kernel, interval: f64, sign: f64) -> Option<Self> {
        Some(Self {
            interval,
            coefficients: StepCoefficients::scaled(kernel.free_branch(), interval)?,
            gain: sign * kernel.gain() * interval * interval,
            gain_across: kernel.gain() * interval * interval,
            tolerance: kernel.tolerance(),
            six: !kernel.states_error() && kernel.tolerance().relative >= PEAK_TRUNCATION,
        })
    }

    /// Flies through the intervals between the samples of `signal` from `first` to `last` until
    /// one has an event; returns how many it has taken.
    #[inline(always)]
    pub(super) fn fly<const K: usize>(
        &self,
        kernel: &mut Kernel,
        pieces: &Pieces<'_, K>,
        first: usize,
        last: usize,
    ) -> usize {
        if !kernel.flies_free() {
            return 0;
        }
        match pieces.second() {
            Some(across) => self.fly_by::<false, K, true>(kernel, (pieces, &across), first, last),
            None if self.six && K == STRAIGHT => {
                self.fly_by::<true, K, false>(kernel, (pieces, pieces), first, last)
            }
            None => self.fly_by::<false, K, false>(kernel, (pieces, pieces), first, last),
        }
    }

    /// The same by steps that try six orders first, or do not, under what acts along and, where `ACROSS`,
    /// across.
    #[inline(always)]
    fn fly_by<const SIX: bool, const K: usize, const ACROSS: bool>(
        &self,
        kernel: &mut Kernel,
        (pieces, across): (&Pieces<'_, K>, &Pieces<'_, K>),
        first: usize,
        last: usize,
    ) -> usize {
        let mut samples = 0;
        let turned = kernel.turned();
        let mut state = LaneState {
            angle: kernel.angle,
            slope: kernel.velocity * self.interval,
            sine: turned.sine,
            cosine: turned.cosine,
        };
        let mut calm = Calm::of(kernel, self.interval);
        let mut gathered = Gathered::default();
        let mut orders = 0;
        for index in first..last {
            let piece = pieces.of(index);
            let mut strongest = piece.strongest(self.gain, 0.0);
            let along = piece.scaled(self.gain, 0.0);
            let mut b = Push::<f64, K, ACROSS> {
                along,
                across: along,
            };
            if ACROSS {
                let piece = across.of(index);
                b.across = piece.scaled(self.gain_across, 0.0);
                strongest += piece.strongest(self.gain_across, 0.0);
            }
            let bounds = self.coefficients.bounds(&state, strongest);
            if calm.may_be_disturbed(&state, &bounds) {
                break;
            }
            let Some((after, tail, count)) = self.step::<SIX, K, ACROSS>(&state, &bounds, &b)
            else {
                break;
            };
            gathered.take(self, &state, &bounds, &b, tail);
            orders += count;
            state = after;
            samples += 1;
            if kernel.recorder.trace.is_some() {
                let time = pieces.signal.time_s(first + samples);
                kernel
                    .recorder
                    .point(time, state.angle, state.slope / self.interval);
            }
            if gathered.count == TOGETHER {
                gathered.give(self, kernel);
                calm = Calm::of(kernel, self.interval);
                if samples.is_multiple_of(FRESH_EVERY) {
                    let turned = Turned::of(state.angle);
                    (state.sine, state.cosine) = (turned.sine, turned.cosine);
                }
            }
        }
        if samples > 0 {
            gathered.give(self, kernel);
            let turned = Turned {
                sine: state.sine,
                cosine: state.cosine,
            };
            kernel.put(state.angle, state.slope / self.interval, turned);
            kernel.work.steps += samples as u64;
            kernel.work.rhs += orders;
        }
        samples
    }

    /// Takes one step over a whole sample: new state, neglected part [rad], orders.
    #[inline(always)]
    fn step<const SIX: bool, const K: usize, const ACROSS: bool>(
        &self,
        state: &LaneState<f64>,
        bounds: &Bounds<f64>,
        b: &Push<f64, K, ACROSS>,
    ) -> Option<(LaneState<f64>, f64, u64)> {
        let mut orders = self.coefficients.orders(state, bounds, b);
        let allowed = self.tolerance.of(orders.motion());
        if SIX {
            let tail = orders.tail_of_six(&[b.along[0], b.along[1]]);
            let turned = orders.tail_turned_of_six();
            if tail <= allowed && turned <= PEAK_TRUNCATION && bounds.turn <= TURN_MAX[0] {
                return Some((orders.end_of_six(state), tail, 6));
            }
        }
        self.coefficients.up_to_eight(&mut orders, b);
        self.coefficients.up_to_nine(&mut orders, b);
        let (nine, tail) = if K == STRAIGHT {
            (orders.end_of_nine(state), orders.tail_of_nine())
        } else {
            let beyond = orders.beyond_nine(&self.coefficients, b);
            (orders.end_beyond_nine(state, beyond), beyond[2])
        };
        if tail <= allowed && bounds.turn <= TURN_MAX[2] {
            return Some((nine, tail, 9));
        }
        self.coefficients.up_to_eleven(&mut orders, b);
        let tail = if K == STRAIGHT {
            orders.tail_of_eleven()
        } else {
            orders.tail_of_products(b)
        };
        (tail <= allowed && bounds.turn <= TURN_MAX[3])
            .then(|| (orders.end_of_eleven(state), tail, 11))
    }
}

impl Calm {
    #[inline(always)]
    fn of(kernel: &mut Kernel, interval: f64) -> Self {
        let error = kernel.error_soon(f64::from(TOGETHER) * interval);
        let (peak, threshold, above) = kernel.recorder.awaits(error);
        Self {
            peak,
            floor: error.max(kernel.ends.gate_below + error),
            threshold,
            above,
            ceiling: kernel.ends.above.angle - error,
        }
    }

    /// Tells whether the sample may hold an impact, a peak or a crossing.
    #[inline(always)]
    fn may_be_disturbed(&self, state: &LaneState<f64>, bounds: &Bounds<f64>) -> bool {
        let turns = state.slope.abs() <= 1.01 * bounds.curve;
        (bounds.lowest <= self.floor)
            | (bounds.highest >= self.ceiling)
            | bounds.lowest.is_nan()
            | (turns & (bounds.highest > self.peak))
            | ((bounds.lowest <= self.threshold) & ((bounds.highest > self.threshold) | self.above))
    }
}

/// What the steps do to the error, in a sample's time.
#[derive(Default)]
struct Gathered {
    stiffness: f64,
    push: f64,
    angle_square: f64,
    slope_square: f64,
    truncation: f64,
    count: u32,
}

impl Gathered {
    #[inline(always)]
    fn take<const K: usize, const ACROSS: bool>(
        &mut self,
        of: &FastFlight,
        state: &LaneState<f64>,
        bounds: &Bounds<f64>,
        b: &Push<f64, K, ACROSS>,
        tail: f64,
    ) {
        let middle = value(&b.along, 0.5);
        let speed = state.slope.abs();
        let angle = state.angle.abs() + speed + bounds.curve;
        // The slope, its change, and the terms that the change is the sum of.
        let slope = speed + 2.0 * bounds.curve;
        self.stiffness += of.coefficients.stiffness - middle * state.sine;
        self.push += middle * state.cosine;
        if ACROSS {
            let middle = value(&b.across, 0.5);
            self.stiffness -= middle * state.cosine;
            self.push -= middle * state.sine;
        }
        self.angle_square += angle * angle;
        self.slope_square += slope * slope;
        self.truncation += tail;
        self.count += 1;
    }

    #[inline(always)]
    fn give(&mut self, of: &FastFlight, kernel: &mut Kernel) {
        let gathered = std::mem::take(self);
        kernel.take_error(&Smooths {
            count: gathered.count,
            time: f64::from(gathered.count) * of.interval,
            stiffness: gathered.stiffness / of.interval,
            push: gathered.push / of.interval,
            angle_square: gathered.angle_square,
            velocity_square: gathered.slope_square / (of.interval * of.interval),
            truncation: gathered.truncation,
            truncation_velocity: if of.tolerance.counts() {
                10.0 * gathered.truncation / of.interval
            } else {
                0.0
            },
        });
    }
}
