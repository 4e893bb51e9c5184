//! Spectrogram of the excitation as used.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas};
use super::colour::viridis;
use super::panel::{self, Panel, RIGHT};
use super::raster::encode;
use super::{Context, Figure};
use crate::conditioning::spectrum::Spectrogram;
use crate::report::number::trimmed;
use crate::report::words::instant;
use crate::units::STANDARD_GRAVITY;

pub(super) const NAME: &str = "spectrogram";

/// Depth of the colour scale [dB].
const DEPTH_DB: f64 = 60.0;

/// Cells of the picture at most, in time and in frequency; more are joined, the largest kept.
const MOST_CELLS: (usize, usize) = (744, 256);

pub(super) fn draw(context: &Context) -> Option<Figure> {
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
    let top = panel::header(&mut canvas, title, &[]) + 8.0;
    let bottom = top + 250.0;
    let height = bottom + panel::FOOTER;
    let panel = Panel::over_time(context, (0.0, top_hz / 1e3), top, bottom);
    panel.grid(&mut canvas, Some(&context.time_label()), "frequency [kHz]");
    panel.clip(&mut canvas, "spectrogram-clip");
    canvas.begin_clipped("spectrogram-clip");
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
    colour_bar(&mut canvas, &panel, low_db, high_db)?;
    panel::footer(&mut canvas, context, height);

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
    let mut pixels = Vec::with_capacity(width * height * 3);
    for line in (0..height).rev() {
        let of_line = stretch(line, height, bins);
        for column in 0..width {
            let largest = data.amplitude_m_s2[stretch(column, width, rows)]
                .iter()
                .flat_map(|row| row.get(of_line.clone()).unwrap_or_default())
                .copied()
                .fold(0.0, f64::max);
            let share = (decibels(largest) - low_db) / (high_db - low_db);
            pixels.extend_from_slice(&viridis(share));
        }
    }
    encode(&pixels, width, height)
}

/// Returns the cells that fall to one of `parts` stretches.
fn stretch(part: usize, parts: usize, cells: usize) -> std::ops::Range<usize> {
    let from = part * cells / parts;
    from..((part + 1) * cells / parts).max(from + 1)
}

fn colour_bar(canvas: &mut Canvas, panel: &Panel, low_db: f64, high_db: f64) -> Option<()> {
    decibel_bar(
        canvas,
        (RIGHT + 10.0, panel.top, panel.bottom),
        (low_db, high_db),
        "dB re 1 g",
    )
}

/// Draws the scale of colours at `left` from `top` to `bottom`, its unit above; `None` only if the
/// encoder refuses.
pub(super) fn decibel_bar(
    canvas: &mut Canvas,
    (left, top, bottom): (f64, f64, f64),
    (low_db, high_db): (f64, f64),
    unit: &str,
) -> Option<()> {
    let steps: Vec<u8> = (0..64)
        .rev()
        .flat_map(|step| viridis((f64::from(step) + 0.5) / 64.0))
        .collect();
    let corner = (left, top);
    let size = (14.0, bottom - top);
    canvas.png(&encode(&steps, 1, 64)?, corner, size);
    canvas.rectangle("frame", corner, size);
    let axis = Axis::linear(low_db, high_db, bottom, top);
    for tick in axis.ticks(46.0, 0.0) {
        let y = axis.place(tick.value);
        canvas.line("tick", (left + 14.0, y), (left + 19.0, y));
        canvas.text("muted", (left + 23.0, y + 5.0), Anchor::Start, &tick.label);
    }
    canvas.text("", (left + 70.0, top - 12.0), Anchor::End, unit);
    Some(())
}
