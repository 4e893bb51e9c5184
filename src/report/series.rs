//! Signal and trajectories as a table, sample by sample, with all digits.

use crate::error::{Error, ErrorKind, Place};
use crate::verdict::SampledSeries;
use std::fmt::Write as _;
use std::path::Path;

/// Returns the series as CSV: time, acceleration as recorded and as used, its integral, and angle
/// and angular velocity of each run.
#[must_use]
pub fn csv(series: &SampledSeries) -> String {
    let mut out = String::with_capacity(series.time_s.len() * (4 + 2 * series.runs.len()) * 20);
    out.push_str("time_s,acceleration_recorded_m_s2,acceleration_used_m_s2,velocity_m_s");
    for run in &series.runs {
        let name = format!("{}_{}", run.model.name(), run.opens_when.name());
        // Writing into a String cannot fail.
        let _ = write!(out, ",angle_{name}_rad,angular_velocity_{name}_rad_s");
    }
    out.push('\n');
    for (index, time) in series.time_s.iter().enumerate() {
        cell(&mut out, *time);
        for values in [
            &series.recorded_m_s2,
            &series.used_m_s2,
            &series.velocity_m_s,
        ] {
            out.push(',');
            cell(&mut out, values[index]);
        }
        for run in &series.runs {
            for values in [&run.angle_rad, &run.velocity_rad_s] {
                out.push(',');
                cell(&mut out, values[index]);
            }
        }
        out.push('\n');
    }
    out
}

/// Writes [`csv`] to a file.
///
/// # Errors
///
/// [`ErrorKind::Io`] if it cannot be written.
pub fn write(path: &Path, series: &SampledSeries) -> Result<(), Error> {
    std::fs::write(path, csv(series)).map_err(|error| {
        Error::from(ErrorKind::Io {
            action: "write the series",
            reason: error.to_string(),
        })
        .at(Place::file(path.display().to_string()))
    })
}

/// Writes a number with all its digits; nothing for one that is not finite.
fn cell(out: &mut String, value: f64) {
    if value.is_finite() {
        let _ = write!(out, "{value}");
    }
}
