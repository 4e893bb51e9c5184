//! Spectrogram of a free vibration, with the frequency of its bounces over it.

use super::angles;
use crate::spectrogram::MotionSpectrogram;
use latchgate_document::number::{exact, significant, trimmed};
use latchgate_report::plot::chart::At::{Low, Value};
use latchgate_report::plot::chart::{ACROSS, Chart, Panel, Point, Shape};
use latchgate_report::plot::frame::{NARROW, Scale, range};
use latchgate_report::plot::heat::{self, Bar};

/// Depth of the colours [dB].
const DEPTH_DB: f64 = 45.0;

/// Largest number of cells of the picture, in time and in frequency.
const MOST_CELLS: (usize, usize) = (320, 200);

pub(super) fn chart(result: &MotionSpectrogram) -> Chart {
    let motion = &result.motion;
    let points = || angles(&motion.trace, 1.0);
    let history = Panel::new(&NARROW, ACROSS, 120.0)
        .x("", Scale::Linear(0.0, result.duration_s))
        .y("angle φ [rad]", range(points().map(|point| point.y), 0.06))
        .function("line rigid", points());
    Chart {
        name: "spectrogram",
        title: "Spectrogram of free impact oscillations".into(),
        notes: vec![format!(
            "T0 = {} N·m, {} stop. Colour: angular velocity in windows of {} s; line: 1/time between impacts.",
            exact(motion.preload_torque_nm),
            motion.against.name(),
            significant(result.amplitudes.window_s, 3)
        )],
        panels: vec![history, picture(result)],
        room: [6.0, 40.0, 54.0],
        caption: "The paper's Fig. 5.".into(),
        description: description(result),
        ..Chart::default()
    }
}

fn description(result: &MotionSpectrogram) -> String {
    let frequency_text = |index: usize| {
        result.bounces.get(index).map_or_else(
            || "none".into(),
            |bounce| significant(bounce.frequency_hz, 4),
        )
    };
    format!(
        "Short-time amplitude over time and frequency; the bounce frequency rises from {} Hz over {} \
         Hz (fifth bounce) to {} Hz (tenth).",
        frequency_text(0),
        frequency_text(4),
        frequency_text(9)
    )
}

fn picture(result: &MotionSpectrogram) -> Panel {
    let (data, highest) = (&result.amplitudes, result.highest_hz);
    let bins = data.frequency_hz.len();
    let shown = data.amplitudes.iter().flat_map(|row| row.iter().take(bins));
    let largest = shown.copied().fold(0.0, f64::max);
    let ridge = result.bounces.iter();
    let ridge = ridge.map(|bounce| Point::new(bounce.time_s, bounce.frequency_hz));
    let mut panel = Panel::new(&NARROW, ACROSS, 350.0)
        .x("time [s]", Scale::Linear(0.0, result.duration_s))
        .y("frequency [Hz]", Scale::Linear(0.0, highest))
        .bar(Bar {
            scale: Scale::Linear(-DEPTH_DB, 0.0),
            title: format!("dB re {} rad/s", trimmed(largest, 3)),
            ..Bar::default()
        });
    if let ([first, .., last], true) = (&*data.time_s, largest > 0.0 && bins > 1) {
        let high_db = 20.0 * libm::log10(largest);
        let columns = data.amplitudes.len();
        let (width, height) = (columns.min(MOST_CELLS.0), bins.min(MOST_CELLS.1));
        let cells = heat::cells((width, height), |column, line| {
            let amplitude = data.amplitudes[column * columns / width][line * bins / height];
            Some((20.0 * libm::log10(amplitude) - high_db + DEPTH_DB) / DEPTH_DB)
        });
        let from = (Value(*first, 0.0), Value(data.frequency_hz[bins - 1], 0.0));
        panel = panel
            .picture(cells, from, (Value(*last, 0.0), Low(0.0)))
            .upright("edge", *first)
            .upright("edge", *last);
    }
    panel
        .lines("ridge-edge", ridge.clone())
        .lines("ridge", ridge.clone())
        .marks(
            "ridge-dot",
            Shape::Circle(3.0),
            ridge.filter(|point| point.y <= highest),
        )
}
