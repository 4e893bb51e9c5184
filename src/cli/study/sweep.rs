//! Options that studies share: sine, initial state, ranges, grids, lengths.

use crate::cli::failure::Failure;
use clap::Args;
use latchgate_document::request::{parse_finite, parse_phi0, parse_positive, parse_velocity};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::State;
use latchgate_recording::error::Error;
use latchgate_study::orbit::ForcedLever;

/// Frequency, gravity and initial state.
#[derive(Debug, Clone, Args)]
pub struct SineArguments {
    /// Angular frequency ω [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_positive, default_value_t = 100.0, allow_hyphen_values = true)]
    pub omega: f64,
    /// What one g is [m/s²]
    #[arg(long, value_name = "M_S2", value_parser = parse_positive, default_value_t = latchgate_kernel::units::STANDARD_GRAVITY, allow_hyphen_values = true)]
    pub gravity: f64,
}

/// Initial state of every lever.
#[derive(Debug, Clone, Args)]
pub struct StartArguments {
    /// Initial angle [rad] [default: at rest on the stop]
    #[arg(long, value_name = "RAD", value_parser = parse_phi0, allow_hyphen_values = true)]
    pub phi0: Option<f64>,
    /// Initial angular velocity [rad/s]
    #[arg(long, value_name = "RAD_S", value_parser = parse_velocity, allow_hyphen_values = true)]
    pub omega0: Option<f64>,
}

impl StartArguments {
    /// Returns the initial state, which every one of `stops` admits; `None` for rest.
    pub(super) fn state(&self, stops: &[StopModel]) -> Result<Option<State>, Failure> {
        if self.phi0.is_none() && self.omega0.is_none() {
            return Ok(None);
        }
        let (angle, velocity) = (self.phi0.unwrap_or(0.0), self.omega0.unwrap_or(0.0));
        start(angle, velocity, stops).map(Some)
    }
}

/// Returns the lever on its stop under sines.
pub(super) fn forced(design: &Design, stop: StopModel, gravity: f64, omega: f64) -> ForcedLever {
    ForcedLever {
        design: design.clone(),
        stop,
        gravity_m_s2: gravity,
        angular_frequency_rad_s: omega,
    }
}

/// Reads `A` or `LO..HI`.
pub(super) fn parse_span(text: &str) -> Result<Range, String> {
    let (low, high) = text.split_once("..").unwrap_or((text, text));
    let (low, high) = (parse_finite(low)?, parse_finite(high)?);
    if low <= high {
        Ok(Range { low, high })
    } else {
        Err("LO must not lie above HI in LO..HI".into())
    }
}

/// As [`parse_span`], two different numbers.
pub(super) fn parse_range(text: &str) -> Result<Range, String> {
    parse_span(text).and_then(|span| {
        if span.low < span.high {
            Ok(span)
        } else {
            Err("expected LO..HI with LO below HI, for example 0..5".into())
        }
    })
}

/// Largest amplitude [g]: fifty times the shock of the paper's Fig. 11, and far beyond any crash.
const AMPLITUDE_MAX_G: f64 = 50_000.0;

/// As [`parse_span`], from 0 or above.
pub(super) fn parse_amplitudes(text: &str) -> Result<Range, String> {
    parse_span(text).and_then(|span| {
        if span.low >= 0.0 && span.high <= AMPLITUDE_MAX_G {
            Ok(span)
        } else {
            Err(format!(
                "expected an amplitude from 0 to {AMPLITUDE_MAX_G} g"
            ))
        }
    })
}

/// Reads one amplitude.
pub(super) fn parse_amplitude(text: &str) -> Result<f64, String> {
    let value = parse_finite(text)?;
    parse_amplitudes(text).map(|_| value)
}

/// As [`parse_amplitude`], above 0.
pub(super) fn parse_positive_amplitude(text: &str) -> Result<f64, String> {
    parse_positive(text).and_then(|_| parse_amplitude(text))
}

/// As [`parse_amplitudes`], two different numbers.
pub(super) fn parse_amplitude_range(text: &str) -> Result<Range, String> {
    parse_range(text).and_then(|_| parse_amplitudes(text))
}

/// As [`parse_range`], above 0.
pub(super) fn parse_frequencies(text: &str) -> Result<Range, String> {
    parse_range(text).and_then(|span| {
        if span.low > 0.0 {
            Ok(span)
        } else {
            Err("expected an angular frequency above 0".into())
        }
    })
}

/// Reads `NxM`.
pub(super) fn parse_grid(text: &str) -> Result<(u32, u32), String> {
    /// Largest number of cells along one side.
    const SIDE_MAX: u32 = 4000;
    let expected = || format!("expected NxM, each from 1 to {SIDE_MAX}, for example 200x200");
    let (columns, rows) = text.split_once(['x', 'X', '×']).ok_or_else(expected)?;
    let side = |text: &str| {
        text.trim()
            .parse::<u32>()
            .ok()
            .filter(|side| (1..=SIDE_MAX).contains(side))
            .ok_or_else(expected)
    };
    Ok((side(columns)?, side(rows)?))
}

/// Returns an initial state that every one of `stops` admits.
pub(super) fn start(phi0: f64, omega0: f64, stops: &[StopModel]) -> Result<State, Failure> {
    if phi0 < 0.0 && stops.iter().any(|stop| !stop.yields()) {
        return Err(Failure::Usage(Error::out_of_range(
            "--phi0 [rad]",
            "0 or more on a rigid stop; choose --model soft to start inside the stop",
            phi0.to_string(),
        )));
    }
    Ok(State::new(phi0, omega0))
}

/// Longest free motion [natural periods].
const PERIODS_MAX: f64 = 1000.0;

pub(super) fn parse_periods(text: &str) -> Result<f64, String> {
    parse_positive(text).and_then(|periods| {
        if periods <= PERIODS_MAX {
            Ok(periods)
        } else {
            Err(format!("must be at most {PERIODS_MAX}"))
        }
    })
}
