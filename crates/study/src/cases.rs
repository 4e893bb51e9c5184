//! Cases for the comparison of methods, given by formula.
//!
//! Every method gets the same problem: samples joined by straight lines, or a smooth sine. So the
//! differences shown are those of the methods, not of the way in which a formula is sampled. In one case the
//! truth is the formula itself, and the loss between the samples counts.

use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::pulse::{Pulse, tones};
use latchgate_kernel::replay::{self, RunOptions, RunOutcome, State};
use latchgate_kernel::signal::{Reading, Signal};
use latchgate_kernel::units::SampleRate;
use latchgate_recording::error::Error;
use latchgate_verdict::conditioning::between::{self, Between};
use latchgate_verdict::conditioning::resample;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// One excitation with its initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyCase {
    /// Short name.
    pub name: &'static str,
    /// Description in a few words.
    pub title: String,
    /// Motion of the base; negative acceleration opens.
    pub drive: Drive,
    /// Initial state; `None` for rest.
    pub initial: Option<State>,
}

/// Motion of the base.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// Samples [m/s²] joined by straight lines.
    Samples(Signal),
    /// Samples [m/s²] with a way to read between them, which each replay works out anew.
    Read(Signal, SampleReading),
    /// A smooth sine.
    Sine {
        /// The sine.
        excitation: Harmonic,
        /// Its duration [s].
        end_s: f64,
    },
}

/// A way to read samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleReading {
    /// Straight lines between so many times as many samples, resampled within their band.
    Lines(u32),
    /// Polynomials of fifth degree within the samples' band.
    BandLimited,
}

impl SampleReading {
    /// Returns the reading's name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lines(1) => "linear",
            Self::Lines(4) => "linear-4",
            Self::Lines(16) => "linear-16",
            Self::Lines(_) => "linear-finer",
            Self::BandLimited => "band-limited",
        }
    }

    fn apply(self, signal: &Signal) -> Result<Reading<'_>, Error> {
        match self {
            Self::Lines(1) => Ok(signal.into()),
            Self::Lines(times) => {
                let rate = SampleRate::from_hertz(signal.rate.hertz() * f64::from(times))?;
                let finer = resample::resample(signal, rate)?;
                between::read(Cow::Owned(finer), Between::Linear)
            }
            Self::BandLimited => between::read(Cow::Borrowed(signal), Between::BandLimited),
        }
    }
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
            Drive::Read(signal, reading) => {
                let reading = reading.apply(signal)?;
                Ok(replay::run(&reading, design, options)?)
            }
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
            Drive::Read(signal, reading) => {
                let reading = reading.apply(signal)?;
                let rate = reading.signal().rate;
                let index = ((time_s - signal.start_s) * rate.hertz()) as usize;
                let options = RunOptions {
                    window: Some((0, index + 1)),
                    ..options.clone()
                };
                Ok(replay::run(&reading, design, &options)?)
            }
            Drive::Sine { excitation, .. } => {
                Ok(replay::run_harmonic(excitation, time_s, design, options)?)
            }
        }
    }

    /// Returns the name of the reading between the samples, if there are any.
    pub fn between(&self) -> Option<&'static str> {
        match &self.drive {
            Drive::Samples(_) => Some(SampleReading::Lines(1).name()),
            Drive::Read(_, reading) => Some(reading.name()),
            Drive::Sine { .. } => None,
        }
    }

    /// Returns the samples, if there are any.
    pub fn signal(&self) -> Option<&Signal> {
        match &self.drive {
            Drive::Samples(signal) | Drive::Read(signal, _) => Some(signal),
            Drive::Sine { .. } => None,
        }
    }
}

fn sampled(rate_hz: f64, intervals: u32, formula: impl Fn(f64) -> f64) -> Result<Signal, Error> {
    Ok(Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(rate_hz)?,
        samples: (0..=intervals)
            .map(|index| formula(f64::from(index) / rate_hz))
            .collect(),
    })
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
        drive: Drive::Samples(sampled(10_000.0, 3000, |t| {
            28.7534 * gravity * (t / TAU_S) * libm::exp(1.0 - t / TAU_S) * tones(t, 1.0)
        })?),
        initial: None,
    })
}

/// Returns the tones of [`recording`] under a bell curve, which begins without a corner, at so many times
/// 10 kHz.
fn bell(gravity: f64, times: u32) -> Result<Signal, Error> {
    const MIDDLE_S: f64 = 0.1;
    const WIDTH_S: f64 = 0.02;
    sampled(10_000.0 * f64::from(times), 3000 * times, |t| {
        let place = (t - MIDDLE_S) / WIDTH_S;
        28.7534 * gravity * libm::exp(-place * place) * tones(t, 1.0)
    })
}

/// Name of the case whose truth is the formula between the samples.
pub const BETWEEN_SAMPLES: &str = "between-samples";

/// A recording of 0.3 s, by its formula and by its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct BetweenSamples {
    /// The formula, so finely sampled that the reading between those samples does not matter.
    pub truth: StudyCase,
    /// The formula, sampled half as finely.
    pub check: StudyCase,
    /// The samples as recorded, in each way of reading them; the last is that of a verdict.
    pub read: Vec<StudyCase>,
}

/// Returns a recording of 0.3 s by its formula and as its samples are read.
///
/// # Errors
///
/// None for any `gravity` [m/s²]; the rates are valid.
pub fn between_samples(gravity: f64) -> Result<BetweenSamples, Error> {
    let case = |times: u32, reading: SampleReading| -> Result<StudyCase, Error> {
        Ok(StudyCase {
            name: BETWEEN_SAMPLES,
            title: "bell, truth by formula, 10 kHz".into(),
            drive: Drive::Read(bell(gravity, times)?, reading),
            initial: None,
        })
    };
    let lines = [1, 4, 16].map(SampleReading::Lines);
    let read = lines.into_iter().chain([SampleReading::BandLimited]);
    Ok(BetweenSamples {
        truth: case(32, SampleReading::BandLimited)?,
        check: case(16, SampleReading::BandLimited)?,
        read: read
            .map(|reading| case(1, reading))
            .collect::<Result<_, _>>()?,
    })
}

/// Returns `periods` periods of a smooth sine of `amplitude_g` [g] and `angular_frequency`
/// [rad/s] from the state (0.1 rad, 0).
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
        initial: Some(State::new(0.1, 0.0)),
    }
}
