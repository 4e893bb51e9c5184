//! One sample of free flight without events: a Taylor step over the whole of it, with nothing kept but
//! the state at its end, and bounds known before the step that tell whether it may be taken.
//!
//! The formulas are written once, for one lever and for several side by side.

#![expect(
    clippy::needless_range_loop,
    reason = "in code compiled for the machine's vectors adaptors such as zip stay calls"
)]

use crate::numerics::lanes::{Lanes, Mask, Real};

/// Largest bound on the turn within a sample [rad] for which sine and cosine, as power series of the
/// turn, are good to 1e-18 after four, six, seven and nine orders. That the turn is a series
/// itself, cut as well, is for the tails to cover.
pub(super) const TURN_MAX: [f64; 4] = [0.000_65, 0.009, 0.014, 0.07];

/// Largest part of the lever's own stiffness and damping in a sample: beyond it the bounds on
/// the curvature are not worth having.
pub(super) const OWN_MAX: f64 = 0.25;

/// Right-hand side off the stop with time in sample intervals; b, the excitation, comes apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepCoefficients<T> {
    pub(super) pressing: T,
    pub(super) damping: T,
    pub(super) stiffness: T,
    /// What makes a bound on the second derivative of its terms at the start of a sample.
    slack: T,
}

/// Excitation over a sample, Σ b_n σ^n, with time in sample intervals.
#[derive(Debug, Clone, Copy)]
pub(super) struct Push<T, const K: usize, const ACROSS: bool> {
    /// Along the way of the centre of mass at φ = 0; opens where negative.
    pub(super) along: [T; K],
    /// Across it, where `ACROSS`.
    pub(super) across: [T; K],
}

impl<T: Real, const K: usize> Push<T, K, false> {
    /// Returns one that acts along alone.
    #[inline(always)]
    pub(super) fn along(along: [T; K]) -> Self {
        Self {
            along,
            across: along,
        }
    }
}

impl<T: Real, const K: usize, const ACROSS: bool> Push<T, K, ACROSS> {
    /// Returns what makes the lever swing of itself: a bound on what acts across.
    #[inline(always)]
    fn swing(&self) -> T {
        let mut sum = self.along[0].constant(0.0);
        if ACROSS {
            for n in 0..K {
                sum = sum + self.across[n].magnitude();
            }
        }
        sum
    }

    /// Returns the sum of its terms' sizes.
    #[inline(always)]
    fn size(&self) -> T {
        let mut size = self.along[0].magnitude();
        for n in 1..K {
            size = size + self.along[n].magnitude();
        }
        if ACROSS {
            size = size + self.swing();
        }
        size
    }

    /// Returns a bound on how much it changes over a sample.
    #[inline(always)]
    pub(super) fn change(&self) -> T {
        let mut change = self.along[1].magnitude();
        for n in 2..K {
            change = change + self.along[n].magnitude() * n as f64;
        }
        if ACROSS {
            for n in 1..K {
                change = change + self.across[n].magnitude() * n as f64;
            }
        }
        change
    }
}

/// Angle [rad], its derivative by the sample interval, and its sine and cosine.
#[derive(Debug, Clone, Copy)]
pub(super) struct LaneState<T> {
    pub(super) angle: T,
    pub(super) slope: T,
    pub(super) sine: T,
    pub(super) cosine: T,
}

/// Takes the states of one or the other.
#[inline(always)]
pub(super) fn chosen<S: pulp::Simd>(
    which: Mask<S>,
    yes: &LaneState<Lanes<S>>,
    no: &LaneState<Lanes<S>>,
) -> LaneState<Lanes<S>> {
    LaneState {
        angle: which.choose(yes.angle, no.angle),
        slope: which.choose(yes.slope, no.slope),
        sine: which.choose(yes.sine, no.sine),
        cosine: which.choose(yes.cosine, no.cosine),
    }
}

/// Bounds over a sample, known at its start.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds<T> {
    /// Of the second derivative's size.
    pub(super) curve: T,
    /// Of the turn's size.
    pub(super) turn: T,
    pub(super) lowest: T,
    pub(super) highest: T,
}

/// Coefficients of a step's series: angle, n times the same, sine and cosine.
pub(super) struct Orders<T> {
    x: [T; 12],
    w: [T; 12],
    s: [T; 10],
    c: [T; 10],
    /// By how much a further order is smaller, at most.
    next: T,
    /// Size of the last two orders of the angle. Kept when they are computed: taken from the arrays
    /// afterwards they are fetched as a pair before both have arrived there.
    last: T,
}

impl StepCoefficients<f64> {
    /// Takes a branch of the right-hand side to samples of `interval` [s]; `None` if a sample is
    /// too long for the lever's own motion.
    pub(super) fn scaled(branch: &super::taylor::Branch, interval: f64) -> Option<Self> {
        let square = interval * interval;
        let (damping, stiffness) = (branch.damping * interval, branch.stiffness * square);
        (damping + stiffness <= OWN_MAX).then(|| Self {
            pressing: branch.pressing * square,
            damping,
            stiffness,
            // From A <= sum of the terms at the start + damping A + stiffness A/2.
            slack: (1.0 + 1e-12) / (1.0 - damping - stiffness),
        })
    }
}

impl<T: Real> StepCoefficients<T> {
    /// Gathers the coefficients of several levers.
    #[inline(always)]
    pub(super) fn gather(of: impl Fn(fn(&StepCoefficients<f64>) -> f64) -> T) -> Self {
        Self {
            pressing: of(|one| one.pressing),
            damping: of(|one| one.damping),
            stiffness: of(|one| one.stiffness),
            slack: of(|one| one.slack),
        }
    }

    /// Returns bounds over the sample from `state`, in which the excitation's size stays below
    /// `strongest`.
    #[inline(always)]
    pub(super) fn bounds(&self, state: &LaneState<T>, strongest: T) -> Bounds<T> {
        let zero = state.slope.constant(0.0);
        let speed = state.slope.magnitude();
        let passive = self.damping * speed + self.stiffness * (state.angle.magnitude() + speed);
        let curve = (self.pressing.magnitude() + passive + strongest) * self.slack;
        Bounds {
            curve,
            turn: speed + curve,
            // The angle lies between parabolas, which are extreme at the ends of the sample. Where the
            // state is no number neither is the turn, and no step stands.
            lowest: state.angle + zero.lower(state.slope - curve * 0.5),
            highest: state.angle + zero.upper(state.slope + curve * 0.5),
        }
    }

    /// Returns a bound on the third derivative's size over the sample, in which the excitation's size stays
    /// below `strongest` and changes by `change`.
    #[inline(always)]
    pub(super) fn third(&self, bounds: &Bounds<T>, strongest: T, change: T) -> T {
        let passive = self.damping * bounds.curve + self.stiffness * bounds.turn;
        (passive + change + strongest * bounds.turn) * (1.0 + 1e-12)
    }

    /// Computes the coefficients up to order 6.
    #[inline(always)]
    pub(super) fn orders<const K: usize, const ACROSS: bool>(
        &self,
        state: &LaneState<T>,
        bounds: &Bounds<T>,
        b: &Push<T, K, ACROSS>,
    ) -> Orders<T> {
        let zero = state.angle.constant(0.0);
        let mut orders = Orders {
            x: [zero; 12],
            w: [zero; 12],
            s: [zero; 10],
            c: [zero; 10],
            next: bounds.turn + self.damping + self.stiffness,
            last: zero,
        };
        if ACROSS {
            orders.next = orders.next + b.swing();
        }
        (orders.x[0], orders.x[1], orders.w[1]) = (state.angle, state.slope, state.slope);
        (orders.s[0], orders.c[0]) = (state.sine, state.cosine);
        let mut torque = self
            .stiffness
            .fused(state.angle, self.damping.fused(state.slope, self.pressing));
        if ACROSS {
            torque = (-b.across[0]).fused(state.sine, torque);
        }
        orders.w[2] = -b.along[0].fused(state.cosine, torque);
        orders.x[2] = orders.w[2] * 0.5;
        orders.order(self, b, 1, []);
        orders.order(self, b, 2, []);
        orders.order(self, b, 3, [2]);
        orders.order(self, b, 4, [3, 2]);
        orders
    }

    /// Goes on from order 6 to order 8.
    #[inline(always)]
    pub(super) fn up_to_eight<const K: usize, const ACROSS: bool>(
        &self,
        orders: &mut Orders<T>,
        b: &Push<T, K, ACROSS>,
    ) {
        orders.order(self, b, 5, [3, 4, 2]);
        orders.order(self, b, 6, [4, 3, 5, 2]);
    }

    /// Goes on from order 8 to order 9.
    #[inline(always)]
    pub(super) fn up_to_nine<const K: usize, const ACROSS: bool>(
        &self,
        orders: &mut Orders<T>,
        b: &Push<T, K, ACROSS>,
    ) {
        orders.order(self, b, 7, [4, 5, 3, 6, 2]);
    }

    /// Adds the coefficients of order 10 and 11 of the angle's power series, by those of order 8 and 9 of sine and
    /// cosine: for a step whose nine orders leave out more than may pass.
    #[inline(always)]
    pub(super) fn up_to_eleven<const K: usize, const ACROSS: bool>(
        &self,
        orders: &mut Orders<T>,
        b: &Push<T, K, ACROSS>,
    ) {
        orders.order(self, b, 8, [5, 4, 6, 3, 7, 2]);
        orders.order(self, b, 9, [5, 6, 4, 7, 3, 8, 2]);
    }
}

impl<T: Real> Orders<T> {
    /// Computes order `n` of sine and cosine and order n + 2 of the angle:
    /// S_n = Σ j x_j C_(n−j)/n, C_n = −Σ j x_j S_(n−j)/n, summed in the order in which the terms
    /// become ready: those of `inner` from the middle outwards, then j = n, whose n x_n/n is x_n,
    /// and last j = 1, for which alone the next order waits.
    #[inline(always)]
    fn order<const K: usize, const ACROSS: bool, const M: usize>(
        &mut self,
        of: &StepCoefficients<T>,
        b: &Push<T, K, ACROSS>,
        n: usize,
        inner: [usize; M],
    ) {
        let Self {
            x, w, s, c, last, ..
        } = self;
        let inverse = 1.0 / n as f64;
        let zero = x[0].constant(0.0);
        let (mut sine, mut cosine) = (zero, zero);
        if M > 0 {
            (sine, cosine) = (w[inner[0]] * c[n - inner[0]], w[inner[0]] * s[n - inner[0]]);
            for j in &inner[1..] {
                sine = w[*j].fused(c[n - j], sine);
                cosine = w[*j].fused(s[n - j], cosine);
            }
            (sine, cosine) = (sine * inverse, cosine * inverse);
        }
        let first = w[1] * inverse;
        let mut force = of.stiffness * x[n];
        if ACROSS {
            // x_n is ready last: what it does to sine and cosine acts through one product.
            (s[n], c[n]) = (first.fused(c[n - 1], sine), -first.fused(s[n - 1], cosine));
            force = zero;
            for k in (0..K.min(n + 1)).rev() {
                force = (-b.across[k]).fused(s[n - k], force);
                force = b.along[k].fused(c[n - k], force);
            }
            let mut stiffness = of.stiffness;
            if n > 1 {
                stiffness = (-b.along[0]).fused(s[0], (-b.across[0]).fused(c[0], stiffness));
                s[n] = x[n].fused(c[0], s[n]);
                c[n] = (-x[n]).fused(s[0], c[n]);
            }
            force = stiffness.fused(x[n], force);
        } else {
            if n > 1 {
                sine = x[n].fused(c[0], sine);
                cosine = x[n].fused(s[0], cosine);
            }
            s[n] = first.fused(c[n - 1], sine);
            c[n] = -first.fused(s[n - 1], cosine);
            for k in (0..K.min(n + 1)).rev() {
                force = b.along[k].fused(c[n - k], force);
            }
        }
        // The damping's term is ready last.
        let force = of.damping.fused(w[n + 1], force);
        w[n + 2] = force * (-1.0 / (n + 1) as f64);
        x[n + 2] = force * (-1.0 / ((n + 1) * (n + 2)) as f64);
        *last = x[n + 2].magnitude() + x[n + 1].magnitude();
    }

    /// Takes into account that the excitation itself turns, by `swing` [rad]: order n of a turn is
    /// smaller than the one before by the turn over n, and n is more than eight where it counts.
    #[inline(always)]
    pub(super) fn swinging(&mut self, swing: T) {
        self.next = (self.next + swing) * 0.125;
    }

    /// Returns a bound on what is neglected of sine and cosine after order 9, of a swinging
    /// excitation.
    #[inline(always)]
    pub(super) fn tail_turned(&self) -> T {
        let tail = |s: &[T; 10]| s[8].magnitude().fused(self.next, s[9].magnitude());
        tail(&self.s).upper(tail(&self.c)) * self.next
    }

    /// Returns the size of the motion over the sample [rad], by its slope and first two bends:
    /// what is neglected has to be small against it, for the slope's sake.
    #[inline(always)]
    pub(super) fn motion(&self) -> T {
        self.x[1].magnitude() + (self.x[2].magnitude() + self.x[3].magnitude())
    }

    /// Returns about how much is neglected after order 6, of angle and slope [rad], for an excitation of two
    /// terms: the order that comes next is the slope's seventh. Where the lever hardly moves, the bends
    /// alone turn the excitation, which no earlier order shows.
    #[inline(always)]
    pub(super) fn tail_of_six(&self, b: &[T; 2]) -> T {
        let bends = self.x[2].magnitude() + self.x[3].magnitude();
        let turned = (b[0].magnitude() + b[1].magnitude()) * bends * bends;
        let further = self.last * self.next * 6.0;
        turned * (1.0 / 6.0) + further
    }

    /// What the excitation's terms add beyond order 9 to angle and slope for each unit of order `m` of the
    /// cosine, their product being of order 8 or more.
    #[inline(always)]
    fn weights<const K: usize>(b: &[T; K], m: usize) -> [T; 2] {
        let zero = b[0].constant(0.0);
        let (mut angle, mut slope) = (zero, zero);
        for k in 0..K {
            let n = m + k;
            if n >= 8 {
                let (once, twice) = (-1.0 / (n + 1) as f64, -1.0 / ((n + 1) * (n + 2)) as f64);
                angle = b[k].fused(zero.constant(twice), angle);
                slope = b[k].fused(zero.constant(once), slope);
            }
        }
        [angle, slope]
    }

    /// Returns what the excitation's higher terms, the spring and the damper add beyond order 9 to angle and
    /// slope by the orders 3 to 8 of the cosine, which are known, and a bound on the rest.
    ///
    /// Orders that only products with the excitation's terms fill need no further order of the angle: the
    /// weights of the cosine's orders wait for nothing but the excitation.
    #[inline(always)]
    pub(super) fn beyond_nine<const K: usize, const ACROSS: bool>(
        &self,
        of: &StepCoefficients<T>,
        b: &Push<T, K, ACROSS>,
    ) -> [T; 3] {
        let Self { x, s, c, .. } = self;
        // Order 8 of the cosine: by the products of the angle's orders that sum to 8, to second order.
        let early = x[2].fused(x[6], x[3].fused(x[5], (x[4] * 0.5) * x[4]));
        let pairs = x[1].fused(x[7], early);
        let eighth = -s[0].fused(x[8], c[0] * pairs);
        let spring = of.stiffness * x[8];
        let none = [spring * (-1.0 / 90.0), spring * (-1.0 / 9.0)];
        // Written out: a loop would put the orders into memory. What is ready last comes last.
        let mut sum = none;
        if ACROSS {
            let eighth = c[0].fused(x[8], -(s[0] * pairs));
            sum = weighted(-s[3], Self::weights(&b.across, 3), sum);
            sum = weighted(-s[4], Self::weights(&b.across, 4), sum);
            sum = weighted(-s[5], Self::weights(&b.across, 5), sum);
            sum = weighted(-s[6], Self::weights(&b.across, 6), sum);
            sum = weighted(-eighth, Self::weights(&b.across, 8), sum);
            sum = weighted(-s[7], Self::weights(&b.across, 7), sum);
        }
        let b_along = &b.along;
        let sum = weighted(c[3], Self::weights(b_along, 3), sum);
        let sum = weighted(c[4], Self::weights(b_along, 4), sum);
        let sum = weighted(c[5], Self::weights(b_along, 5), sum);
        let sum = weighted(c[6], Self::weights(b_along, 6), sum);
        let sum = weighted(eighth, Self::weights(b_along, 8), sum);
        let [angle, slope] = weighted(c[7], Self::weights(b_along, 7), sum);
        let mut m = *x;
        for order in &mut m {
            *order = order.magnitude();
        }
        let products = m[2].fused(m[7], m[3].fused(m[6], m[4] * m[5]));
        let after = (m[9] + self.next * m[8]) + (products + x[1] * x[1] * (m[7] + m[6]));
        let passive = (of.stiffness + of.damping * 10.0) * (m[9] + m[8] * 0.1);
        let tail = b
            .size()
            .fused(after, passive + slope.magnitude() * of.damping)
            * (2.0 / 90.0);
        [angle, slope, tail]
    }

    /// Returns the state at the end of the sample from the orders up to 9 and what is `beyond` them. Sine and
    /// cosine turn by the sum of the early orders, as power series of it, and then by the small rest.
    #[inline(always)]
    pub(super) fn end_beyond_nine(&self, state: &LaneState<T>, beyond: [T; 3]) -> LaneState<T> {
        let Self { x, w, .. } = self;
        let one = x[0].constant(1.0);
        let turn = (state.slope + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
        let late = (x[8] + x[9]) + beyond[0];
        let square = turn * turn;
        let fourth = square * square;
        let sine = turn
            * fourth.fused(
                (square * (-1.0 / 5040.0)) + one.constant(1.0 / 120.0),
                one - square * (1.0 / 6.0),
            );
        let versine = square
            * fourth.fused(
                one.constant(1.0 / 720.0),
                one.constant(0.5) - square * (1.0 / 24.0),
            );
        let turned = (
            state.sine + state.cosine.fused(sine, -state.sine * versine),
            state.cosine - state.sine.fused(sine, state.cosine * versine),
        );
        LaneState {
            angle: state.angle + (turn + late),
            slope: state.slope + (beyond[1] + sum_of_nine(w)),
            sine: late.fused(turned.1, turned.0),
            cosine: (-late).fused(turned.0, turned.1),
        }
    }

    /// Returns about how much of sine and cosine is neglected after order 4.
    #[inline(always)]
    pub(super) fn tail_turned_of_six(&self) -> T {
        let x = |n: usize| self.x[n].magnitude();
        x(5) + x(1) * x(4) + x(2) * x(3)
    }

    /// Returns about how much is neglected after order 8, of angle and slope [rad]; up to 3e-13 of the
    /// motion in a sample more where a lever turns close to its stop.
    #[inline(always)]
    pub(super) fn tail_of_eight(&self) -> T {
        self.last * self.next * 8.0
    }

    /// Returns a bound on what is neglected [rad] after order 9.
    #[inline(always)]
    pub(super) fn tail_of_nine(&self) -> T {
        self.last * self.next
    }

    /// Returns the same after order 11.
    #[inline(always)]
    pub(super) fn tail_of_eleven(&self) -> T {
        self.last * self.next
    }

    /// Returns the same where the excitation has more than two terms: the next order by the cosine's known
    /// ones comes on top.
    #[inline(always)]
    pub(super) fn tail_of_products<const K: usize, const ACROSS: bool>(
        &self,
        b: &Push<T, K, ACROSS>,
    ) -> T {
        let mut next = b.along[1].magnitude() * self.c[9].magnitude();
        for k in 2..K {
            next = b.along[k]
                .magnitude()
                .fused(self.c[10 - k].magnitude(), next);
        }
        if ACROSS {
            for k in 1..K {
                next = b.across[k]
                    .magnitude()
                    .fused(self.s[10 - k].magnitude(), next);
            }
        }
        self.last.fused(self.next, next * (2.0 / 132.0))
    }

    /// Returns the state at the end of the sample from the orders up to 6.
    #[inline(always)]
    pub(super) fn end_of_six(&self, state: &LaneState<T>) -> LaneState<T> {
        let Self { x, w, s, c, .. } = self;
        state.moved([
            sum_of_six(x),
            sum_of_six(w),
            turn_of_four(s),
            turn_of_four(c),
        ])
    }

    /// Returns the same from the orders up to 8.
    #[inline(always)]
    pub(super) fn end_of_eight(&self, state: &LaneState<T>) -> LaneState<T> {
        let Self { x, w, s, c, .. } = self;
        let sums = [
            sum_of_eight(x),
            sum_of_eight(w),
            turn_of_six(s),
            turn_of_six(c),
        ];
        state.moved(sums)
    }

    /// Returns the same from the orders up to 9.
    #[inline(always)]
    pub(super) fn end_of_nine(&self, state: &LaneState<T>) -> LaneState<T> {
        let Self { x, w, s, c, .. } = self;
        let sums = [
            sum_of_nine(x),
            sum_of_nine(w),
            turn_of_seven(s),
            turn_of_seven(c),
        ];
        state.moved(sums)
    }

    /// Returns the same from the orders up to 11.
    #[inline(always)]
    pub(super) fn end_of_eleven(&self, state: &LaneState<T>) -> LaneState<T> {
        let Self { x, w, s, c, .. } = self;
        let (x, w) = (
            sum_of_nine(x) + (x[10] + x[11]),
            sum_of_nine(w) + (w[10] + w[11]),
        );
        let (s, c) = (
            turn_of_seven(s) + (s[8] + s[9]),
            turn_of_seven(c) + (c[8] + c[9]),
        );
        state.moved([x, w, s, c])
    }
}

/// Adds so many times what an order weighs in angle and slope.
#[inline(always)]
fn weighted<T: Real>(order: T, [angle, slope]: [T; 2], sum: [T; 2]) -> [T; 2] {
    [order.fused(angle, sum[0]), order.fused(slope, sum[1])]
}

// The sums go in pairs, so that none waits for many others, and the late ones come last.

#[inline(always)]
fn sum_of_six<T: Real>(x: &[T; 12]) -> T {
    ((x[2] + x[3]) + (x[4] + x[5])) + x[6]
}

#[inline(always)]
fn turn_of_four<T: Real>(s: &[T; 10]) -> T {
    (s[1] + s[2]) + (s[3] + s[4])
}

#[inline(always)]
fn sum_of_eight<T: Real>(x: &[T; 12]) -> T {
    ((x[4] + x[5]) + (x[2] + x[3])) + ((x[6] + x[7]) + x[8])
}

#[inline(always)]
fn turn_of_six<T: Real>(s: &[T; 10]) -> T {
    ((s[3] + s[4]) + (s[1] + s[2])) + (s[5] + s[6])
}

#[inline(always)]
fn sum_of_nine<T: Real>(x: &[T; 12]) -> T {
    ((x[4] + x[5]) + (x[2] + x[3])) + ((x[6] + x[7]) + (x[8] + x[9]))
}

#[inline(always)]
fn turn_of_seven<T: Real>(s: &[T; 10]) -> T {
    ((s[3] + s[4]) + (s[1] + s[2])) + ((s[5] + s[6]) + s[7])
}

impl<T: Real> LaneState<T> {
    /// Moves on by what the orders add to angle, slope, sine and cosine.
    #[inline(always)]
    fn moved(&self, [angle, slope, sine, cosine]: [T; 4]) -> Self {
        Self {
            angle: self.angle + (self.slope + angle),
            slope: self.slope + slope,
            sine: self.sine + sine,
            cosine: self.cosine + cosine,
        }
    }
}
