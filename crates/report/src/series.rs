//! Signal and trajectories as a table, sample by sample, with all digits.

use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::units::OpensWhen;
use latchgate_recording::error::Error;
pub use latchgate_verdict::SampledSeries;
use latchgate_verdict::SeriesRun;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Returns the runs of a series in the order of its columns, the same in every file: rigid stop before soft, negative
/// opens before positive opens.
pub fn ordered(series: &SampledSeries) -> Vec<&SeriesRun> {
    let mut runs: Vec<&SeriesRun> = series.runs.iter().collect();
    runs.sort_by_key(|run| (run.model, run.opens_when));
    runs
}

/// Returns the columns of a series, each with its name: time, acceleration as recorded and as used, its
/// integral, and angle and angular velocity of each run.
pub fn columns(series: &SampledSeries) -> Vec<(String, &[f64])> {
    let signal: [&[f64]; 4] = [
        &series.time_s,
        &series.recorded_m_s2,
        &series.used_m_s2,
        &series.velocity_m_s,
    ];
    let signal = HEAD.split(',').map(String::from).zip(signal);
    let runs = ordered(series).into_iter().flat_map(|run| {
        let name = format!("{}_{}", run.model.name(), run.opens_when.name());
        [
            (format!("angle_{name}_rad"), &*run.angle_rad),
            (
                format!("angular_velocity_{name}_rad_s"),
                &*run.velocity_rad_s,
            ),
        ]
    });
    signal.chain(runs).collect()
}

/// Returns the [`columns`] of a series as CSV.
pub fn csv(series: &SampledSeries) -> String {
    let columns = columns(series);
    let mut out = String::with_capacity(series.time_s.len() * columns.len() * 20);
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    out.push_str(&names.join(","));
    out.push('\n');
    for index in 0..series.time_s.len() {
        for (number, (_, values)) in columns.iter().enumerate() {
            if number > 0 {
                out.push(',');
            }
            cell(&mut out, values[index]);
        }
        out.push('\n');
    }
    out
}

/// Reads back what [`csv`] wrote.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Malformed`] if it is no such table.
pub fn from_csv(text: &[u8]) -> Result<SampledSeries, Error> {
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
        .map_err(|error| malformed(error.to_string()))?
        .clone();
    let mut columns = vec![Vec::new(); heads.len()];
    for record in reader.records() {
        let record = record.map_err(|error| malformed(error.to_string()))?;
        for ((name, cell), values) in heads.iter().zip(&record).zip(&mut columns) {
            // A value that is not finite is an empty cell.
            let value = if cell.is_empty() { "NaN" } else { cell };
            let line = || record.position().map_or(0, csv::Position::line);
            let value = value.parse();
            values.push(value.map_err(|_| malformed(format!("no {name} in line {}", line())))?);
        }
    }
    let mut columns = heads.iter().zip(columns);
    let mut column = |expected: &str| match columns.next() {
        Some((name, values)) if name == expected => Ok(values),
        _ => Err(malformed(format!("no column {expected}"))),
    };
    let mut series = SampledSeries {
        time_s: column("time_s")?,
        recorded_m_s2: column("acceleration_recorded_m_s2")?,
        used_m_s2: column("acceleration_used_m_s2")?,
        velocity_m_s: column("velocity_m_s")?,
        runs: Vec::new(),
    };
    while let Some((name, angle_rad)) = columns.next() {
        let odd = || malformed(format!("a column {name}"));
        let (model, opens_when) = run_of(name).ok_or_else(odd)?;
        let (_, velocity_rad_s) = columns.next().ok_or_else(odd)?;
        series.runs.push(SeriesRun {
            model,
            opens_when,
            angle_rad,
            velocity_rad_s,
        });
    }
    let time_s = &series.time_s;
    if time_s.len() < 2 || !time_s.is_sorted_by(|a, b| a < b) {
        return Err(malformed("instants that do not ascend".into()));
    }
    Ok(series)
}

/// Returns stop and opening direction of a column of angles by its name.
fn run_of(name: &str) -> Option<(StopModel, OpensWhen)> {
    let words = name.strip_prefix("angle_")?.strip_suffix("_rad")?;
    let (model, opens_when) = words.split_once('_')?;
    let model = serde_json::from_value(model.into()).ok()?;
    Some((model, serde_json::from_value(opens_when.into()).ok()?))
}

/// First columns of a series.
const HEAD: &str = "time_s,acceleration_recorded_m_s2,acceleration_used_m_s2,velocity_m_s";

/// Returns true if a file holds a series.
pub fn is_one(path: &Path) -> bool {
    let mut head = [0; HEAD.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && head == HEAD.as_bytes()
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

/// Writes a number with all its digits, a very small one with its power of ten; nothing for one that is not finite.
fn cell(out: &mut String, value: f64) {
    let is_tiny = value.abs() < 1e-12 && value.abs() > 0.0;
    // Writing into a String cannot fail.
    let _ = match value.is_finite() {
        true if is_tiny => write!(out, "{value:e}"),
        true => write!(out, "{value}"),
        false => Ok(()),
    };
}
