//! The excitation: what the base of the lever does over time.

use crate::signal::{Pieces, STRAIGHT, Signal, value};

/// The acceleration of the base, in the model's sign: negative opens.
pub trait Excitation {
    /// Returns the acceleration [m/s²] at time `t` [s].
    fn acceleration(&self, t: f64) -> f64;

    /// Returns the acceleration across the way of the centre of mass at φ = 0, away from the pivot, at time `t`
    /// [s]; `None` of an excitation without [m/s²].
    fn radial(&self, t: f64) -> Option<f64> {
        let _ = t;
        None
    }

    /// Returns the first instant after `t` [s] at which the acceleration or its slope jumps;
    /// infinity where it is smooth from `t` on.
    fn next_kink(&self, t: f64) -> f64 {
        let _ = t;
        f64::INFINITY
    }
}

/// Samples with what runs between them; zero before the first and after the last.
#[derive(Debug, Clone, Copy)]
pub struct Sampled<'a, const K: usize = STRAIGHT> {
    /// The polynomials [m/s²].
    pub(crate) pieces: Pieces<'a, K>,
    /// Factor that brings the samples to the model's sign, +1 or −1 [-].
    pub(crate) sign: f64,
    /// The polynomials of what acts across [m/s²].
    pub(crate) radial: Option<Pieces<'a, K>>,
}

impl<'a> Sampled<'a, STRAIGHT> {
    /// Joins samples by straight lines; `sign` brings them to the model's sign.
    pub fn straight(signal: &'a Signal, sign: f64) -> Self {
        Self {
            pieces: Pieces::straight(signal),
            sign,
            radial: None,
        }
    }
}

impl<const K: usize> Sampled<'_, K> {
    /// Returns the place of an instant, in sample intervals.
    fn place(&self, t: f64) -> f64 {
        let signal = self.pieces.signal;
        (t - signal.start_s) * signal.rate.hertz()
    }

    /// Returns what one of the sensors' polynomials say at time `t` [s].
    fn at(&self, pieces: &Pieces<'_, K>, t: f64) -> f64 {
        let place = self.place(t);
        if place < 0.0 {
            return 0.0;
        }
        let index = place as usize;
        let samples = &pieces.signal.samples;
        match samples.get(index) {
            Some(_) if index + 1 < samples.len() => {
                value(&pieces.terms(index), place - index as f64)
            }
            // The last sample itself, met up to the rounding of its time.
            Some(last) if place <= index as f64 + 1e-9 => *last,
            _ => 0.0,
        }
    }
}

impl<const K: usize> Excitation for Sampled<'_, K> {
    #[inline]
    fn acceleration(&self, t: f64) -> f64 {
        self.sign * self.at(&self.pieces, t)
    }

    #[inline]
    fn radial(&self, t: f64) -> Option<f64> {
        let radial = self.radial.as_ref()?;
        Some(self.at(radial, t))
    }

    #[inline]
    fn next_kink(&self, t: f64) -> f64 {
        let (place, signal) = (self.place(t), self.pieces.signal);
        if place < 0.0 {
            return signal.start_s;
        }
        // Rounding may put a sample's own time just before it.
        let mut index = place as usize + 1;
        if signal.time_s(index) <= t {
            index += 1;
        }
        if index < signal.samples.len() {
            signal.time_s(index)
        } else {
            f64::INFINITY
        }
    }
}

/// A sine: a(t) = A sin(ω t + θ).
///
/// # Source
///
/// Section 2 of the paper, with A g written as one amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Amplitude [m/s²].
    pub amplitude_m_s2: f64,
    /// Angular frequency [rad/s].
    pub angular_frequency_rad_s: f64,
    /// Phase at time 0 [rad].
    pub phase_rad: f64,
}

impl Excitation for Harmonic {
    #[inline]
    fn acceleration(&self, t: f64) -> f64 {
        self.amplitude_m_s2 * libm::sin(self.angular_frequency_rad_s * t + self.phase_rad)
    }
}
