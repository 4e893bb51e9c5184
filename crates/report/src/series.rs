//! Signal and trajectories as a table, sample by sample, with all digits.

use latchgate_recording::error::Error;
use latchgate_verdict::SampledSeries;
use std::fmt::Write as _;
use std::path::Path;

/// Returns the series as CSV: time, acceleration as recorded and as used, its integral, and angle
/// and angular velocity of each run.
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

/// The series of a report as far as two verdicts are compared by them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SeriesTable {
    /// Instants, at least two, ascending [s].
    pub time_s: Vec<f64>,
    /// Acceleration as used [m/s²].
    pub used_m_s2: Vec<f64>,
    /// Its integral [m/s].
    pub velocity_m_s: Vec<f64>,
    /// Angle of the first run, which is the nominal one [rad].
    pub angle_rad: Vec<f64>,
}

impl SeriesTable {
    /// Reads back what [`csv`] wrote.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] if it is no such table.
    pub fn from_csv(text: &[u8]) -> Result<Self, Error> {
        let malformed = |found: String| {
            Error::malformed(
                "the series of a report",
                found,
                "replay the recording again; its report holds the series",
            )
        };
        let mut reader = csv::Reader::from_reader(text);
        let heads = reader
            .headers()
            .map_err(|error| malformed(error.to_string()))?;
        let of = |name: &str| heads.iter().position(|head| head.starts_with(name));
        let names = ["time_s", "acceleration_used_m_s2", "velocity_m_s", "angle_"];
        let columns = names.map(of);
        let mut read = names.map(|_| Vec::new());
        for record in reader.records() {
            let record = record.map_err(|error| malformed(error.to_string()))?;
            for ((column, name), values) in columns.iter().zip(names).zip(&mut read) {
                let cell = column.and_then(|column| record.get(column));
                let value = cell.and_then(|cell| cell.parse::<f64>().ok());
                let line = || record.position().map_or(0, csv::Position::line);
                values
                    .push(value.ok_or_else(|| malformed(format!("no {name} in line {}", line())))?);
            }
        }
        let [time_s, used_m_s2, velocity_m_s, angle_rad] = read;
        if time_s.len() < 2 || !time_s.is_sorted_by(|a, b| a < b) {
            return Err(malformed("instants that do not ascend".into()));
        }
        Ok(Self {
            time_s,
            used_m_s2,
            velocity_m_s,
            angle_rad,
        })
    }
}

/// Writes [`csv`] to a file.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written.
pub fn write(path: &Path, series: &SampledSeries) -> Result<(), Error> {
    std::fs::write(path, csv(series))
        .map_err(|error| Error::io_at("write the series", path, &error))
}

/// Writes a number with all its digits; nothing for one that is not finite.
fn cell(out: &mut String, value: f64) {
    if value.is_finite() {
        let _ = write!(out, "{value}");
    }
}
