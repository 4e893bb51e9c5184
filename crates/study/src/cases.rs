//! The cases that methods are compared on, by formula.
//!
//! Every method gets the same problem: samples joined by straight lines, or a smooth sine. So the
//! differences shown are those of the methods, not of the way in which a formula is sampled.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::pulse::{Pulse, tones};
use latchgate_kernel::replay::{self, RunOptions, RunOutcome};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::units::SampleRate;
use latchgate_recording::error::Error;
use std::f64::consts::TAU;

/// One excitation with its initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyCase {
    /// Short name.
    pub name: &'static str,
    /// What it is, in a few words.
    pub title: String,
    /// What moves the base; negative opens.
    pub drive: Drive,
    /// Initial angle [rad] and angular velocity [rad/s]; `None` for rest.
    pub initial: Option<(f64, f64)>,
}

/// What moves the base.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// Samples [m/s²] joined by straight lines.
    Samples(Signal),
    /// A smooth sine.
    Sine {
        /// The sine.
        excitation: Harmonic,
        /// How long it lasts [s].
        end_s: f64,
    },
}

impl StudyCase {
    /// Replays the case.
    ///
    /// # Errors
    ///
    /// As [`replay::run`] and [`replay::run_harmonic`].
    pub fn replay(&self, design: &Design, options: &RunOptions) -> Result<RunOutcome, Error> {
        match &self.drive {
            Drive::Samples(signal) => Ok(replay::run(signal, design, options)?),
            Drive::Sine { excitation, end_s } => {
                Ok(replay::run_harmonic(excitation, *end_s, design, options)?)
            }
        }
    }

    /// Replays the case up to `time_s` [s], or to the sample after it.
    ///
    /// # Errors
    ///
    /// As [`replay::run`] and [`replay::run_harmonic`].
    pub fn replay_until(
        &self,
        time_s: f64,
        design: &Design,
        options: &RunOptions,
    ) -> Result<RunOutcome, Error> {
        match &self.drive {
            Drive::Samples(signal) => {
                let index = ((time_s - signal.start_s) * signal.rate.hertz()) as usize;
                let options = RunOptions {
                    window: Some((0, index + 1)),
                    ..options.clone()
                };
                Ok(replay::run(signal, design, &options)?)
            }
            Drive::Sine { excitation, .. } => {
                Ok(replay::run_harmonic(excitation, time_s, design, options)?)
            }
        }
    }

    /// Returns the samples, if there are any.
    #[must_use]
    pub fn signal(&self) -> Option<&Signal> {
        match &self.drive {
            Drive::Samples(signal) => Some(signal),
            Drive::Sine { .. } => None,
        }
    }
}

fn sampled(rate_hz: f64, intervals: u32, formula: impl Fn(f64) -> f64) -> Result<Drive, Error> {
    Ok(Drive::Samples(Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate_hz)?,
        samples: (0..=intervals)
            .map(|index| formula(f64::from(index) / rate_hz))
            .collect(),
    }))
}

/// Returns the shock of 35 ms: the burst of `signals/burst.csv` without its noise, near 1000 g,
/// at 20 kHz.
///
/// # Errors
///
/// None for any `gravity` [m/s²]; the rate is valid.
pub fn shock(gravity: f64) -> Result<StudyCase, Error> {
    let burst = Pulse::Burst {
        scale: 148.8 * gravity,
        duration_s: 0.035,
        phases: 5.0,
    };
    Ok(StudyCase {
        name: "shock",
        title: "shock of 35 ms, 1000 g, 20 kHz".into(),
        drive: Drive::Samples(burst.signal(20_000.0)?),
        initial: None,
    })
}

/// Returns the recording of 0.3 s: a rise and decay with τ = 30 ms over the same tones, near
/// 200 g, at 10 kHz.
///
/// # Errors
///
/// None for any `gravity` [m/s²]; the rate is valid.
pub fn recording(gravity: f64) -> Result<StudyCase, Error> {
    const TAU_S: f64 = 0.03;
    Ok(StudyCase {
        name: "recording",
        title: "recording of 0.3 s, 200 g, 10 kHz".into(),
        drive: sampled(10_000.0, 3000, |t| {
            28.7534 * gravity * (t / TAU_S) * libm::exp(1.0 - t / TAU_S) * tones(t, 1.0)
        })?,
        initial: None,
    })
}

/// Returns `periods` periods of a smooth sine of `amplitude_g` [g] and `angular_frequency`
/// [rad/s] from the state (0.1 rad, 0).
#[must_use]
pub fn harmonic(gravity: f64, amplitude_g: f64, angular_frequency: f64, periods: u32) -> StudyCase {
    StudyCase {
        name: "harmonic",
        title: format!("{periods} periods, A = {amplitude_g} g, ω = {angular_frequency} rad/s"),
        drive: Drive::Sine {
            excitation: Harmonic {
                amplitude_m_s2: amplitude_g * gravity,
                angular_frequency_rad_s: angular_frequency,
                phase_rad: 0.0,
            },
            end_s: f64::from(periods) * TAU / angular_frequency,
        },
        initial: Some((0.1, 0.0)),
    }
}
