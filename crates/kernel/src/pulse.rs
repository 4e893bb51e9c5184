//! Pulses: accelerations by formula.

use crate::error::Error;
use crate::signal::Signal;
use crate::units::SampleRate;
use std::f64::consts::{PI, TAU};

/// An acceleration that lasts from 0 to its duration and is zero elsewhere, in the unit of its peak.
///
/// # Source
///
/// Half-sine, final-peak sawtooth and trapezoid are the shapes of IEC 60068-2-27.
///
/// # Examples
///
/// ```
/// use latchgate_kernel::pulse::Pulse;
///
/// let pulse = Pulse::HalfSine { peak: 30.0, duration_s: 0.011 };
/// assert_eq!(pulse.at(0.0055), 30.0);
/// assert_eq!(pulse.at(0.011), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pulse {
    /// Half a period of a sine.
    HalfSine {
        /// Largest value.
        peak: f64,
        /// Duration [s].
        duration_s: f64,
    },
    /// A sine squared: smooth at both ends.
    Haversine {
        /// Largest value.
        peak: f64,
        /// Duration [s].
        duration_s: f64,
    },
    /// A straight rise that ends at the peak at once.
    Sawtooth {
        /// Value at the end of the rise.
        peak: f64,
        /// Duration [s].
        duration_s: f64,
    },
    /// A straight rise and a straight fall, equally long.
    Triangle {
        /// Value in the middle.
        peak: f64,
        /// Duration [s].
        duration_s: f64,
    },
    /// A straight rise, a plateau and a straight fall.
    Trapezoid {
        /// Value of the plateau.
        peak: f64,
        /// Duration of the rise [s].
        rise_s: f64,
        /// Duration of the plateau [s].
        plateau_s: f64,
        /// Duration of the fall [s].
        fall_s: f64,
    },
    /// Tones under a haversine; see [`tones`].
    Burst {
        /// Factor of the tones.
        scale: f64,
        /// Duration [s].
        duration_s: f64,
        /// Set of phases, as [`tones`] takes it.
        phases: f64,
    },
}

impl Pulse {
    /// Returns the duration [s].
    pub fn duration_s(&self) -> f64 {
        match *self {
            Self::HalfSine { duration_s, .. }
            | Self::Haversine { duration_s, .. }
            | Self::Sawtooth { duration_s, .. }
            | Self::Triangle { duration_s, .. }
            | Self::Burst { duration_s, .. } => duration_s,
            Self::Trapezoid {
                rise_s,
                plateau_s,
                fall_s,
                ..
            } => rise_s + plateau_s + fall_s,
        }
    }

    /// Returns the value at `time_s` after the pulse's begin.
    pub fn at(&self, time_s: f64) -> f64 {
        if !(0.0..self.duration_s()).contains(&time_s) {
            return 0.0;
        }
        match *self {
            Self::HalfSine { peak, duration_s } => peak * libm::sin(PI * time_s / duration_s),
            Self::Haversine { peak, duration_s } => {
                let sine = libm::sin(PI * (time_s / duration_s));
                peak * (sine * sine)
            }
            Self::Sawtooth { peak, duration_s } => peak * time_s / duration_s,
            Self::Triangle { peak, duration_s } => {
                peak * (1.0 - (2.0 * time_s / duration_s - 1.0).abs())
            }
            Self::Trapezoid {
                peak,
                rise_s,
                plateau_s,
                fall_s,
            } => {
                let since_plateau_s = time_s - rise_s - plateau_s;
                if time_s < rise_s {
                    peak * time_s / rise_s
                } else if since_plateau_s <= 0.0 {
                    peak
                } else {
                    peak * (1.0 - since_plateau_s / fall_s)
                }
            }
            Self::Burst {
                scale,
                duration_s,
                phases,
            } => {
                let envelope = libm::sin(PI * time_s / duration_s);
                scale * envelope * envelope * tones(time_s, phases)
            }
        }
    }

    /// Returns samples of the pulse from its begin to its end, the last one included.
    ///
    /// # Errors
    ///
    /// [`Error::NotPositive`] for a rate that is none.
    pub fn signal(&self, rate_hz: f64) -> Result<Signal, Error> {
        let rate = SampleRate::from_hertz(rate_hz)?;
        // 0.035 s at 20 kHz come out a little above 700 intervals.
        let intervals = (self.duration_s() * rate_hz - 1e-6).ceil() as u64;
        Ok(Signal {
            start_s: 0.0,
            rate,
            samples: (0..=intervals)
                .map(|index| self.at(index as f64 / rate_hz))
                .collect(),
        })
    }
}

/// Returns 24 tones from 20 to 480 Hz at `time_s`: Σ sin(2π (20 j t + frac(n P j²))), P the golden
/// ratio's fraction, which spreads the phases; another `phases` n is another set of them.
pub fn tones(time_s: f64, phases: f64) -> f64 {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    (1..=24)
        .map(|j| {
            let j = f64::from(j);
            let turns = phases * golden * j * j;
            libm::sin(TAU * (20.0 * j * time_s + (turns - turns.floor())))
        })
        .sum()
}
