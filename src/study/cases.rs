//! The cases that methods are compared on, by formula.
//!
//! Every method gets the same piecewise-linear problem: samples joined by straight lines. So the
//! differences shown are those of the methods, not of the way in which a formula is sampled.

use crate::conditioning::Signal;
use crate::error::Error;
use crate::units::SampleRate;
use std::f64::consts::{PI, TAU};

/// One excitation with its initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Short name.
    pub name: &'static str,
    /// What it is, in a few words.
    pub title: String,
    /// The samples [m/s²]; negative opens.
    pub signal: Signal,
    /// Initial angle [rad] and angular velocity [rad/s]; `None` for rest.
    pub initial: Option<(f64, f64)>,
}

/// Samples of the harmonic case in a period of the excitation.
pub const SAMPLES_PER_PERIOD: u32 = 1000;

/// Σ sin(2π(20 j t + p_j)) over j = 1..24 with p_j = frac(q P j²) and P = (√5−1)/2: tones from 20
/// to 480 Hz whose phases follow the golden ratio.
fn tones(t: f64, q: f64) -> f64 {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    (1..=24)
        .map(|j| {
            let j = f64::from(j);
            let turns = q * golden * j * j;
            libm::sin(TAU * (20.0 * j * t + (turns - turns.floor())))
        })
        .sum()
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
pub fn shock(gravity: f64) -> Result<Case, Error> {
    const DURATION_S: f64 = 0.035;
    Ok(Case {
        name: "shock",
        title: "shock of 35 ms, 1000 g, 20 kHz".into(),
        signal: sampled(20_000.0, 700, |t| {
            let envelope = libm::sin(PI * t / DURATION_S);
            148.8 * gravity * envelope * envelope * tones(t, 5.0)
        })?,
        initial: None,
    })
}

/// Returns the recording of 0.3 s: a rise and decay with τ = 30 ms over the same tones, near
/// 200 g, at 10 kHz.
///
/// # Errors
///
/// None for any `gravity` [m/s²]; the rate is valid.
pub fn recording(gravity: f64) -> Result<Case, Error> {
    const TAU_S: f64 = 0.03;
    Ok(Case {
        name: "recording",
        title: "recording of 0.3 s, 200 g, 10 kHz".into(),
        signal: sampled(10_000.0, 3000, |t| {
            28.7534 * gravity * (t / TAU_S) * libm::exp(1.0 - t / TAU_S) * tones(t, 1.0)
        })?,
        initial: None,
    })
}

/// Returns `periods` periods of a sine of `amplitude_g` [g] and `angular_frequency` [rad/s] from
/// the state (0.1 rad, 0), in 1000 samples a period.
///
/// # Errors
///
/// [`crate::error::ErrorKind::NotPositive`] for an angular frequency that is not positive.
pub fn harmonic(
    gravity: f64,
    amplitude_g: f64,
    angular_frequency: f64,
    periods: u32,
) -> Result<Case, Error> {
    let rate_hz = f64::from(SAMPLES_PER_PERIOD) * angular_frequency / TAU;
    let amplitude = amplitude_g * gravity;
    Ok(Case {
        name: "harmonic",
        title: format!("{periods} periods, A = {amplitude_g} g, ω = {angular_frequency} rad/s"),
        signal: sampled(rate_hz, periods.saturating_mul(SAMPLES_PER_PERIOD), |t| {
            amplitude * libm::sin(angular_frequency * t)
        })?,
        initial: Some((0.1, 0.0)),
    })
}
