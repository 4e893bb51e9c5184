//! Spectrogram of the excitation as used.

use super::canvas::Canvas;
use super::frame::{self, Frame, LEFT, RIGHT};
use super::{Figure, PlotContext, heat};
use crate::words::instant;
use latchgate_document::number::trimmed;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::conditioning::spectrum::Spectrogram;

pub(super) const NAME: &str = "spectrogram";

/// Depth of the colour scale [dB].
const DEPTH_DB: f64 = 60.0;

/// Cells of the picture at most, in time and in frequency; more are joined, the largest kept.
const MOST_CELLS: (usize, usize) = (744, 256);

pub(super) fn draw(context: &PlotContext) -> Option<Figure> {
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

    let mut canvas = Canvas::with_capacity(base64.len() + 16 * 1024);
    let title = "Spectrogram of the acceleration as used";
    let top = frame::header(&mut canvas, LEFT, title, &[], &[]) + 6.0;
    let bottom = top + 250.0;
    let height = bottom + frame::FOOTER;
    let panel = Frame::over_time(context, (0.0, top_hz / 1e3), top, bottom);
    let time = context.time_label();
    panel.grid(&mut canvas, Some(&time), Some("frequency [kHz]"));
    panel.begin_inside(&mut canvas, "spectrogram-clip");
    let half = if rows > 1 {
        (data.time_s[rows - 1] - data.time_s[0]) / count(rows - 1) / 2.0
    } else {
        data.window_s / 2.0
    };
    let scale = context.time_scale;
    let from = panel.place((data.time_s[0] - half) * scale, top_hz / 1e3);
    let to = panel.place(
        (data.time_s[rows - 1] + half) * scale,
        (data.frequency_hz[0] - frequency_step / 2.0) / 1e3,
    );
    canvas.png(&base64, from, (to.0 - from.0, to.1 - from.1));
    canvas.end_group();
    panel.frame(&mut canvas);
    let bar = (RIGHT + 10.0, panel.top, panel.bottom);
    heat::decibel_bar(&mut canvas, bar, (low_db, high_db), "dB re 1 g")?;
    frame::footer(&mut canvas, &context.origin, height);

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
    Some(Figure {
        name: NAME,
        title: title.into(),
        caption: format!("Amplitude in decibels, 0 dB being 1 g ({resolution}).{above}"),
        description: format!(
            "Short-time amplitude of the acceleration as used over time and frequency up to {} \
             kHz; {resolution}; colours from {} to {} dB re 1 g.",
            trimmed(top_hz / 1e3, 4),
            trimmed(low_db, 3),
            trimmed(high_db, 3)
        ),
        height,
        body: canvas.into_string(),
    })
}

fn decibels(amplitude_m_s2: f64) -> f64 {
    20.0 * libm::log10(amplitude_m_s2 / STANDARD_GRAVITY)
}

fn count(number: usize) -> f64 {
    number as f64
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
