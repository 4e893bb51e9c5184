//! The excitation: what the base of the lever does over time.

/// The acceleration of the base, in the model's sign: negative opens.
pub trait Excitation {
    /// Returns the acceleration [m/s²] at time `t` [s].
    fn acceleration(&self, t: f64) -> f64;

    /// Returns the first instant after `t` [s] at which the acceleration or its slope jumps;
    /// infinity where it is smooth from `t` on.
    fn next_kink(&self, t: f64) -> f64 {
        let _ = t;
        f64::INFINITY
    }
}

/// Samples joined by straight lines; zero before the first and after the last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled<'a> {
    /// Time of the first sample [s].
    pub start_s: f64,
    /// Samples per second [Hz].
    pub rate_hz: f64,
    /// Samples [m/s²].
    pub samples: &'a [f64],
    /// Factor that brings the samples to the model's sign, +1 or −1 [-].
    pub sign: f64,
}

impl Sampled<'_> {
    fn time_s(&self, index: usize) -> f64 {
        self.start_s + index as f64 / self.rate_hz
    }
}

impl Excitation for Sampled<'_> {
    #[inline]
    fn acceleration(&self, t: f64) -> f64 {
        let place = (t - self.start_s) * self.rate_hz;
        if place < 0.0 {
            return 0.0;
        }
        let index = place as usize;
        let value = match (self.samples.get(index), self.samples.get(index + 1)) {
            (Some(from), Some(to)) => from + (to - from) * (place - index as f64),
            // The last sample itself, met up to the rounding of its time.
            (Some(last), None) if place <= index as f64 + 1e-9 => *last,
            _ => 0.0,
        };
        self.sign * value
    }

    #[inline]
    fn next_kink(&self, t: f64) -> f64 {
        let place = (t - self.start_s) * self.rate_hz;
        if place < 0.0 {
            return self.start_s;
        }
        // Rounding may put a sample's own time just before it.
        let mut index = place as usize + 1;
        if self.time_s(index) <= t {
            index += 1;
        }
        if index < self.samples.len() {
            self.time_s(index)
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
