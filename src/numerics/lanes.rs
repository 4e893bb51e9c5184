//! Several numbers side by side: plain arrays whose element-wise arithmetic the compiler turns
//! into vector instructions of whatever width the code around is compiled for.
//!
//! Every operation is the IEEE operation of its element, so a lane's result does not depend on
//! its neighbours, nor on the width of the machine's vectors.

use std::ops::{Add, Mul, Neg, Sub};

/// Lanes of a vector: two registers of four where there are 256 bits.
pub const LANES: usize = 8;

/// A vector of [`LANES`] numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// Puts `value` into every lane.
    #[inline(always)]
    #[must_use]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// Returns the absolute values.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    /// Applies `function` to every lane.
    #[inline(always)]
    #[must_use]
    pub fn map(mut self, function: impl Fn(f64) -> f64) -> Self {
        for value in &mut self.0 {
            *value = function(*value);
        }
        self
    }

    /// Combines two vectors lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn zip(mut self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        for (value, other) in self.0.iter_mut().zip(other.0) {
            *value = function(*value, other);
        }
        self
    }

    /// Returns the smaller values; of a NaN and a number the number.
    #[inline(always)]
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    /// Returns the larger values.
    #[inline(always)]
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.map(|a| a * other)
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}
