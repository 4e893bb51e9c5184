//! Several numbers side by side, in the machine's vectors.
//!
//! Every operation is the IEEE operation of its element, so a lane's result does not depend on
//! its neighbours, nor on the width of the machine's vectors. [`Real`] lets one formula serve one
//! number and several alike, with the same bits for each.

use pulp::{Simd, bytemuck};
use std::ops::{Add, BitAnd, BitOr, Mul, Neg, Not, Sub};

/// Vectors that are worked on together, so that one's waits are the other's work.
const TOGETHER: usize = 2;

/// Most lanes that any machine has: two vectors of 512 bits.
pub const LANES_MAX: usize = 8 * TOGETHER;

/// Returns what `of` gives for each of the vectors; written out, since a call that is not taken
/// apart here leaves all around it in memory.
#[inline(always)]
fn together<T>(of: impl Fn(usize) -> T) -> [T; TOGETHER] {
    [of(0), of(1)]
}

/// Returns the lanes of the machine's vectors that `S` stands for.
pub const fn lanes<S: Simd>() -> usize {
    S::F64_LANES * TOGETHER
}

/// What a formula needs of a number, or of several side by side.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
{
    /// Returns `value`, as many times as `self` has lanes.
    fn constant(self, value: f64) -> Self;

    /// Returns `self`·`factor` + `term` with one rounding.
    ///
    /// The machine's own instruction where the code around is compiled for it; else a slow
    /// routine with the same result.
    fn fused(self, factor: Self, term: Self) -> Self;

    /// Returns the absolute value.
    fn magnitude(self) -> Self;

    /// Returns the smaller of two.
    fn lower(self, other: Self) -> Self;

    /// Returns the larger of two.
    fn upper(self, other: Self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn fused(self, factor: Self, term: Self) -> Self {
        self.mul_add(factor, term)
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn lower(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn upper(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// [`lanes`] numbers.
#[derive(Debug, Clone, Copy)]
pub struct Lanes<S: Simd> {
    simd: S,
    vectors: [S::f64s; TOGETHER],
}

impl<S: Simd> Lanes<S> {
    /// Puts `value` into every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            vectors: [simd.splat_f64s(value); TOGETHER],
        }
    }

    /// Fills every lane by its number.
    #[inline(always)]
    pub fn from_fn(simd: S, value: impl Fn(usize) -> f64) -> Self {
        let mut filled = Self::splat(simd, 0.0);
        for lane in 0..lanes::<S>() {
            filled.set(lane, value(lane));
        }
        filled
    }

    /// Returns one lane's number.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> f64 {
        bytemuck::cast_slice::<S::f64s, f64>(&self.vectors)[lane]
    }

    /// Sets one lane's number.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: f64) {
        bytemuck::cast_slice_mut::<S::f64s, f64>(&mut self.vectors)[lane] = value;
    }

    /// Tells of every lane whether it is greater than the other's.
    #[inline(always)]
    pub fn above(self, other: Self) -> Mask<S> {
        let simd = self.simd;
        Mask {
            simd,
            vectors: together(|n| simd.less_than_f64s(other.vectors[n], self.vectors[n])),
        }
    }

    /// Tells of every lane whether it is less than the other's, or equal.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> Mask<S> {
        let simd = self.simd;
        Mask {
            simd,
            vectors: together(|n| simd.less_than_or_equal_f64s(self.vectors[n], other.vectors[n])),
        }
    }

    #[inline(always)]
    fn each(self, function: impl Fn(S, S::f64s) -> S::f64s) -> Self {
        let Self { simd, vectors } = self;
        Self {
            simd,
            vectors: together(|n| function(simd, vectors[n])),
        }
    }

    #[inline(always)]
    fn with(self, other: Self, function: impl Fn(S, S::f64s, S::f64s) -> S::f64s) -> Self {
        let Self { simd, vectors } = self;
        Self {
            simd,
            vectors: together(|n| function(simd, vectors[n], other.vectors[n])),
        }
    }
}

impl<S: Simd> Real for Lanes<S> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    fn fused(self, factor: Self, term: Self) -> Self {
        let Self { simd, vectors } = self;
        Self {
            simd,
            vectors: together(|n| {
                simd.mul_add_f64s(vectors[n], factor.vectors[n], term.vectors[n])
            }),
        }
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.each(|simd, a| simd.abs_f64s(a))
    }

    #[inline(always)]
    fn lower(self, other: Self) -> Self {
        self.with(other, |simd, a, b| simd.min_f64s(a, b))
    }

    #[inline(always)]
    fn upper(self, other: Self) -> Self {
        self.with(other, |simd, a, b| simd.max_f64s(a, b))
    }
}

/// A yes or no for every lane.
#[derive(Debug, Clone, Copy)]
pub struct Mask<S: Simd> {
    simd: S,
    vectors: [S::m64s; TOGETHER],
}

impl<S: Simd> Mask<S> {
    /// Returns the lanes that say yes, each as the bit of its number.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        let Self { simd, vectors } = self;
        let place = Lanes::from_fn(simd, |lane| f64::from(1_u32 << lane));
        let none = simd.splat_f64s(0.0);
        let bits_of = |n: usize| simd.select_f64s(vectors[n], place.vectors[n], none);
        // Every sum of powers of two is exact.
        simd.reduce_sum_f64s(simd.add_f64s(bits_of(0), bits_of(1))) as u32
    }

    /// Tells whether every lane says yes.
    #[inline(always)]
    pub fn all(self) -> bool {
        let both = self.simd.and_m64s(self.vectors[0], self.vectors[1]);
        self.simd.first_true_m64s(self.simd.not_m64s(both)) >= S::F64_LANES
    }

    /// Takes `yes` where the lane says yes, else `no`.
    #[inline(always)]
    pub fn choose(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        let Self { simd, vectors } = self;
        Lanes {
            simd,
            vectors: together(|n| simd.select_f64s(vectors[n], yes.vectors[n], no.vectors[n])),
        }
    }

    #[inline(always)]
    fn with(self, other: Self, function: impl Fn(S, S::m64s, S::m64s) -> S::m64s) -> Self {
        let Self { simd, vectors } = self;
        Self {
            simd,
            vectors: together(|n| function(simd, vectors[n], other.vectors[n])),
        }
    }
}

impl<S: Simd> BitAnd for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        self.with(other, |simd, a, b| simd.and_m64s(a, b))
    }
}

impl<S: Simd> BitOr for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        self.with(other, |simd, a, b| simd.or_m64s(a, b))
    }
}

impl<S: Simd> Not for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        let Self { simd, vectors } = self;
        Self {
            simd,
            vectors: together(|n| simd.not_m64s(vectors[n])),
        }
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, |simd, a, b| simd.add_f64s(a, b))
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, |simd, a, b| simd.sub_f64s(a, b))
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, |simd, a, b| simd.mul_f64s(a, b))
    }
}

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.each(|simd, a| simd.mul_f64s(a, simd.splat_f64s(other)))
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|simd, a| simd.neg_f64s(a))
    }
}
