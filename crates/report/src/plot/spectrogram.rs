//! Spectrogram of the excitation as used.

use super::PlotContext;
use super::chart::{At, Chart};
use super::frame::Scale;
use super::heat::{self, Bar};
use crate::words::instant;
use latchgate_document::number::trimmed;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::conditioning::spectrum::Spectrogram;

pub(super) const NAME: &str = "spectrogram";

/// Depth of the colour scale [dB].
const DEPTH_DB: f64 = 60.0;

/// Largest number of cells of the picture in time and in frequency; more are joined, the largest value kept.
const MOST_CELLS: (usize, usize) = (744, 256);

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let data = &context.evidence.spectrogram;
    let rows = data.time_s.len().min(data.amplitude_m_s2.len());
    let bins = data.frequency_hz.len();
    let largest = data
        .amplitude_m_s2
        .iter()
        .flatten()
        .copied()
        .filter(|amplitude| amplitude.is_finite())
        .fold(0.0, f64::max);
    if rows == 0 || bins < 2 || largest <= 0.0 {
        return None;
    }
    let high_db = (decibels(largest) / 5.0).ceil() * 5.0;
    let low_db = high_db - DEPTH_DB;
    let shown = shown_bins(data, low_db);
    let frequency_step = data.frequency_hz[1] - data.frequency_hz[0];
    let top_hz = data.frequency_hz[shown - 1] + frequency_step / 2.0;
    let base64 = picture(data, rows, shown, low_db, high_db)?;

    let half = if rows > 1 {
        (data.time_s[rows - 1] - data.time_s[0]) / (rows - 1) as f64 / 2.0
    } else {
        data.window_s / 2.0
    };
    let corner = |time_s: f64, hz: f64| {
        let x = At::Value(time_s * context.time_scale, 0.0);
        (x, At::Value(hz / 1e3, 0.0))
    };
    let low_hz = data.frequency_hz[0] - frequency_step / 2.0;
    let panel = context
        .over_time(250.0)
        .y("frequency [kHz]", Scale::Linear(0.0, top_hz / 1e3))
        .picture(
            Some(base64),
            corner(data.time_s[0] - half, top_hz),
            corner(data.time_s[rows - 1] + half, low_hz),
        )
        .bar(Bar {
            scale: Scale::Linear(low_db, high_db),
            title: "dB re 1 g".into(),
            ..Bar::default()
        });
    let resolution = format!(
        "windows of {}, lines {} Hz apart",
        instant(data.window_s),
        trimmed(frequency_step, 4)
    );
    let above = if shown < bins {
        format!(
            " Above the frequencies shown nothing exceeds {} dB.",
            trimmed(low_db, 3)
        )
    } else {
        String::new()
    };
    Some(Chart {
        name: NAME,
        title: "Spectrogram of the acceleration as used".into(),
        panels: vec![panel],
        caption: format!("Amplitude in decibels, 0 dB being 1 g ({resolution}).{above}"),
        description: format!(
            "Short-time amplitude of the acceleration as used over time and frequency up to {} \
             kHz; {resolution}; colours from {} to {} dB re 1 g.",
            trimmed(top_hz / 1e3, 4),
            trimmed(low_db, 3),
            trimmed(high_db, 3)
        ),
        ..context.chart()
    })
}

fn decibels(amplitude_m_s2: f64) -> f64 {
    20.0 * libm::log10(amplitude_m_s2 / STANDARD_GRAVITY)
}

/// Returns how many bins hold anything above the scale's low end, with a tenth of room.
fn shown_bins(data: &Spectrogram, low_db: f64) -> usize {
    let bins = data.frequency_hz.len();
    let last = (0..bins)
        .rev()
        .find(|&bin| {
            data.amplitude_m_s2
                .iter()
                .any(|row| row.get(bin).is_some_and(|&value| decibels(value) > low_db))
        })
        .unwrap_or(bins - 1);
    (last + 2 + last / 10).clamp(2, bins)
}

/// Returns the picture as base64 of a PNG, high frequencies at the top.
fn picture(
    data: &Spectrogram,
    rows: usize,
    bins: usize,
    low_db: f64,
    high_db: f64,
) -> Option<String> {
    let (width, height) = (rows.min(MOST_CELLS.0), bins.min(MOST_CELLS.1));
    heat::cells((width, height), |column, line| {
        let of_line = cells_of(line, height, bins);
        let largest = data.amplitude_m_s2[cells_of(column, width, rows)]
            .iter()
            .flat_map(|row| row.get(of_line.clone()).unwrap_or_default())
            .copied()
            .fold(0.0, f64::max);
        Some((decibels(largest) - low_db) / (high_db - low_db))
    })
}

/// Returns the cells that fall to one of `parts`.
fn cells_of(part: usize, parts: usize, cells: usize) -> std::ops::Range<usize> {
    let from = part * cells / parts;
    from..((part + 1) * cells / parts).max(from + 1)
}
