//! One plain sample of free flight: a Taylor step over the whole of it, with nothing kept but
//! the state at its end, and bounds known before the step that tell whether it may be taken.
//!
//! The formulas are written once, for one lever and for several side by side.

use crate::numerics::lanes::Real;

/// Largest bound on the turn within a sample [rad] for which the sine's and cosine's own series
/// are good to 1e-18, after seven and after nine orders.
pub(super) const TURN_MAX: (f64, f64) = (0.014, 0.07);

/// Largest part of the lever's own stiffness and damping in a sample: beyond it the bounds on
/// the curvature are not worth having.
pub(super) const OWN_MAX: f64 = 0.25;

/// Right-hand side off the stop with time in sample intervals; b, the excitation, comes apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coefficients<T> {
    pub(super) pressing: T,
    pub(super) damping: T,
    pub(super) stiffness: T,
    /// What makes a bound on the second derivative of its terms at the start of a sample.
    slack: T,
}

/// Angle [rad], its derivative by the sample interval, and its sine and cosine.
#[derive(Debug, Clone, Copy)]
pub(super) struct State<T> {
    pub(super) angle: T,
    pub(super) slope: T,
    pub(super) sine: T,
    pub(super) cosine: T,
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
}

impl Coefficients<f64> {
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

impl<T: Real> Coefficients<T> {
    /// Gathers the coefficients of several levers.
    #[inline(always)]
    pub(super) fn gather(of: impl Fn(fn(&Coefficients<f64>) -> f64) -> T) -> Self {
        Self {
            pressing: of(|one| one.pressing),
            damping: of(|one| one.damping),
            stiffness: of(|one| one.stiffness),
            slack: of(|one| one.slack),
        }
    }

    /// Returns bounds over the sample from `state`, the excitation going from `from` to `to`.
    #[inline(always)]
    pub(super) fn bounds(&self, state: &State<T>, from: T, to: T) -> Bounds<T> {
        let zero = state.slope.constant(0.0);
        let speed = state.slope.magnitude();
        let own = self.damping * speed + self.stiffness * (state.angle.magnitude() + speed);
        let strongest = from.magnitude().upper(to.magnitude());
        let curve = (self.pressing.magnitude() + own + strongest) * self.slack;
        Bounds {
            curve,
            turn: speed + curve,
            lowest: state.angle + state.slope.lower(zero) - curve * 0.5,
            highest: state.angle + state.slope.upper(zero) + curve * 0.5,
        }
    }

    /// Computes the coefficients up to order 9, for an excitation b0 + b1 σ.
    #[inline(always)]
    pub(super) fn orders(&self, state: &State<T>, bounds: &Bounds<T>, b0: T, b1: T) -> Orders<T> {
        let zero = b0.constant(0.0);
        let mut x = [zero; 12];
        let mut w = [zero; 12];
        let mut s = [zero; 10];
        let mut c = [zero; 10];
        (x[0], x[1], w[1]) = (state.angle, state.slope, state.slope);
        (s[0], c[0]) = (state.sine, state.cosine);
        let own = self
            .stiffness
            .fused(state.angle, self.damping.fused(state.slope, self.pressing));
        w[2] = -b0.fused(state.cosine, own);
        x[2] = w[2] * 0.5;
        let mut orders = Orders {
            x,
            w,
            s,
            c,
            next: bounds.turn + self.damping + self.stiffness,
        };
        orders.order(self, b0, b1, 1, []);
        orders.order(self, b0, b1, 2, []);
        orders.order(self, b0, b1, 3, [2]);
        orders.order(self, b0, b1, 4, [3, 2]);
        orders.order(self, b0, b1, 5, [3, 4, 2]);
        orders.order(self, b0, b1, 6, [4, 3, 5, 2]);
        orders.order(self, b0, b1, 7, [4, 5, 3, 6, 2]);
        orders
    }

    /// Computes two orders more.
    #[inline(always)]
    pub(super) fn more_orders(&self, orders: &mut Orders<T>, b0: T, b1: T) {
        orders.order(self, b0, b1, 8, [5, 4, 6, 3, 7, 2]);
        orders.order(self, b0, b1, 9, [5, 6, 4, 7, 3, 8, 2]);
    }
}

impl<T: Real> Orders<T> {
    /// Computes order `n` of sine and cosine and order n + 2 of the angle:
    /// S_n = Σ j x_j C_(n−j)/n, C_n = −Σ j x_j S_(n−j)/n, summed in the order in which the terms
    /// become ready: those of `inner` from the middle outwards, then j = n, whose n x_n/n is x_n,
    /// and last j = 1, for which alone the next order waits.
    #[inline(always)]
    #[expect(clippy::cast_precision_loss, reason = "a small order")]
    fn order<const M: usize>(
        &mut self,
        of: &Coefficients<T>,
        b0: T,
        b1: T,
        n: usize,
        inner: [usize; M],
    ) {
        let Self { x, w, s, c, .. } = self;
        let inverse = 1.0 / n as f64;
        let (mut sine, mut cosine) = (b0.constant(0.0), b0.constant(0.0));
        if M > 0 {
            (sine, cosine) = (w[inner[0]] * c[n - inner[0]], w[inner[0]] * s[n - inner[0]]);
            for j in &inner[1..] {
                sine = w[*j].fused(c[n - j], sine);
                cosine = w[*j].fused(s[n - j], cosine);
            }
            (sine, cosine) = (sine * inverse, cosine * inverse);
        }
        if n > 1 {
            sine = x[n].fused(c[0], sine);
            cosine = x[n].fused(s[0], cosine);
        }
        let first = w[1] * inverse;
        s[n] = first.fused(c[n - 1], sine);
        c[n] = -first.fused(s[n - 1], cosine);
        // The damping's term is ready last.
        let force = b0.fused(c[n], b1.fused(c[n - 1], of.stiffness * x[n]));
        let force = of.damping.fused(w[n + 1], force);
        w[n + 2] = force * (-1.0 / (n + 1) as f64);
        x[n + 2] = force * (-1.0 / ((n + 1) * (n + 2)) as f64);
    }

    /// Returns the size of the motion over the sample [rad], by its slope and first two bends:
    /// what is neglected has to be small against it, for the slope's sake.
    #[inline(always)]
    pub(super) fn motion(&self) -> T {
        self.x[1].magnitude() + (self.x[2].magnitude() + self.x[3].magnitude())
    }

    /// Returns a bound on what is neglected [rad] after order 9.
    #[inline(always)]
    pub(super) fn tail_of_nine(&self) -> T {
        (self.x[9].magnitude() + self.x[8].magnitude()) * self.next
    }

    /// Returns the same after order 11.
    #[inline(always)]
    pub(super) fn tail_of_eleven(&self) -> T {
        (self.x[11].magnitude() + self.x[10].magnitude()) * self.next
    }

    /// Returns the state at the end of the sample from the orders up to 9.
    #[inline(always)]
    pub(super) fn end_of_nine(&self, state: &State<T>) -> State<T> {
        // In pairs, so that none waits for many others; the late ones last.
        let sum = |x: &[T; 12]| ((x[4] + x[5]) + (x[2] + x[3])) + ((x[6] + x[7]) + (x[8] + x[9]));
        let turned = |s: &[T; 10]| ((s[3] + s[4]) + (s[1] + s[2])) + ((s[5] + s[6]) + s[7]);
        self.end(state, sum, turned)
    }

    /// Returns the same from the orders up to 11.
    #[inline(always)]
    pub(super) fn end_of_eleven(&self, state: &State<T>) -> State<T> {
        let sum = |x: &[T; 12]| {
            (((x[4] + x[5]) + (x[2] + x[3])) + ((x[6] + x[7]) + (x[8] + x[9]))) + (x[10] + x[11])
        };
        let turned = |s: &[T; 10]| {
            (((s[3] + s[4]) + (s[1] + s[2])) + ((s[5] + s[6]) + s[7])) + (s[8] + s[9])
        };
        self.end(state, sum, turned)
    }

    #[inline(always)]
    fn end(
        &self,
        state: &State<T>,
        sum: impl Fn(&[T; 12]) -> T,
        turned: impl Fn(&[T; 10]) -> T,
    ) -> State<T> {
        State {
            angle: state.angle + (state.slope + sum(&self.x)),
            slope: state.slope + sum(&self.w),
            sine: state.sine + turned(&self.s),
            cosine: state.cosine + turned(&self.c),
        }
    }
}
