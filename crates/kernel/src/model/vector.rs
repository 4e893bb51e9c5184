//! Vectors in the vehicle's axes: X forward, Y to the right, Z down (SAE J211).

use serde::{Deserialize, Serialize};

/// Components along X, Y and Z.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector(pub [f64; 3]);

impl Vector {
    /// Returns the length.
    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// True if every component is a number and not too large for one.
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|component| component.is_finite())
    }

    /// Returns the scalar product.
    pub fn dot(self, other: Self) -> f64 {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    /// Returns the vector product.
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    /// Returns the sum.
    pub fn plus(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }

    /// Returns the vector times a number.
    pub fn times(self, factor: f64) -> Self {
        Self(self.0.map(|component| factor * component))
    }

    /// Returns the vector of length 1 in its direction; `None` of one without a length.
    pub fn direction(self) -> Option<Self> {
        let length = self.length();
        (length > 0.0 && length.is_finite()).then(|| self.times(1.0 / length))
    }
}
