//! Tables of numbers without names: one message names everything that a person has to state.

use super::begin::{self, Begin};
use super::{records, stamp};
use crate::ReadOptions;
use crate::error::{Error, ErrorKind, Place};
use crate::number;
use crate::setting::Setting;
use ::csv::ByteRecord;
use latchgate_kernel::units::TimeUnit;

/// Rates of recorders of crashes [Hz].
const LIKELY_HZ: std::ops::RangeInclusive<f64> = 250.0..=1e6;

/// Units of acceleration that most such tables have.
const UNITS: [&str; 2] = ["g", "m/s2"];

/// Returns the refusal of a table whose first rows hold numbers and stamps alone, with every setting
/// that is missing; `None` of any other table. `step_of` finds the usual step of a column that rises
/// steadily.
pub(super) fn refusal(
    text: &[u8],
    rows: &[ByteRecord],
    options: &ReadOptions,
    step_of: impl Fn(usize) -> Option<f64>,
) -> Option<Error> {
    let Begin { header, data } = begin::find(text)?;
    let first = rows.first()?;
    let width = first
        .iter()
        .rposition(|cell| !cell.trim_ascii().is_empty())?
        + 1;
    let is_sample = |cell: &[u8]| number::is_numeric(cell) || stamp::is_stamp(cell);
    let all_samples = rows
        .iter()
        .all(|row| row.len() == first.len() && row.iter().take(width).all(is_sample));
    if header.is_some() || records::line_of(text, first) != data || !all_samples {
        return None;
    }
    let mut settings = vec![(Setting::SkipLines, vec![(data - 1).to_string()])];
    let time = options.time_column.is_none() && options.rate_hz.is_none();
    let time = time.then(|| time_column(rows, width, step_of));
    let mut channels: Vec<usize> = (0..width).collect();
    match time {
        Some(Some((index, unit))) => {
            channels.retain(|channel| *channel != index);
            settings.push((Setting::TimeColumn, vec![(index + 1).to_string()]));
            let unit = unit.filter(|_| options.time_unit.is_none());
            settings.extend(unit.map(|unit| (Setting::TimeUnit, vec![unit.to_string()])));
        }
        Some(None) => settings.push((Setting::RateHz, vec!["HZ".into()])),
        None => {}
    }
    // The only column beside the times needs no name.
    let is_clear = channels.len() == 1 && width > 1;
    if options.channel.is_none() && !is_clear && options.time_column.is_none() {
        let numbers = channels.iter().map(|channel| (channel + 1).to_string());
        settings.push((Setting::Channel, numbers.collect()));
    }
    if options.unit.is_none() && options.sensitivity.is_none() {
        settings.push((Setting::Unit, UNITS.map(String::from).to_vec()));
    }
    let columns = match width {
        1 => "one column".into(),
        2 => "two columns".into(),
        3 => "three columns".into(),
        more => format!("{more} columns"),
    };
    let error = Error::from(ErrorKind::UnnamedColumns { columns, settings });
    Some(error.at(Place::default().line(data)))
}

/// Finds the column that looks like the time: one of stamps, else one of numbers that rise by like
/// steps, with its unit where that is not seconds. Steps of one count rows.
fn time_column(
    rows: &[ByteRecord],
    width: usize,
    step_of: impl Fn(usize) -> Option<f64>,
) -> Option<(usize, Option<&'static str>)> {
    let is_worded = |index: &usize| {
        let mut cells = rows.iter().filter_map(|row| row.get(*index));
        cells.all(|cell| stamp::is_stamp(cell) && !number::is_numeric(cell))
    };
    if let Some(index) = (0..width).find(is_worded) {
        return Some((index, None));
    }
    (0..width).find_map(|index| {
        let step = step_of(index).filter(|step| (step - 1.0).abs() > f64::EPSILON)?;
        let likely = |unit: &&str| {
            let unit = TimeUnit::from_spelling(unit);
            unit.is_some_and(|unit| LIKELY_HZ.contains(&(1.0 / unit.to_seconds(step))))
        };
        let unit = ["s", "ms", "us", "ns"].into_iter().find(likely)?;
        Some((index, Some(unit).filter(|unit| *unit != "s")))
    })
}
