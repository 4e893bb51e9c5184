//! Spectrogram of a free vibration, with the frequency of its bounces over it.

use crate::spectrogram::MotionSpectrogram;
use latchgate_document::number::{exact, significant, trimmed};
use latchgate_report::plot::canvas::Canvas;
use latchgate_report::plot::frame::{self, Frame, Scale};
use latchgate_report::plot::{Figure, WIDTH, heat};

const NAME: &str = "spectrogram";

/// Depth of the colours [dB].
const DEPTH_DB: f64 = 45.0;

/// Cells of the picture at most, in time and in frequency.
const MOST_CELLS: (usize, usize) = (320, 200);

pub(super) fn draw(result: &MotionSpectrogram) -> Figure {
    let mut canvas = Canvas::with_capacity(160 * 1024);
    let title = "Spectrogram of free impact oscillations";
    let motion = &result.motion;
    let top = frame::header(
        &mut canvas,
        72.0,
        title,
        &[format!(
            "T0 = {} N·m, {} stop. Colour: angular velocity in windows of {} s; line: 1/time between impacts.",
            exact(motion.preload_torque_nm),
            motion.against.name(),
            significant(result.amplitudes.window_s, 3)
        )],
        &[],
    );
    let right = WIDTH - 96.0;
    let history = Frame::narrow(
        (72.0, right, top + 6.0, top + 126.0),
        Scale::Linear(0.0, result.duration_s),
        frame::range(motion.trace.iter().map(|point| point.angle_rad), 0.06),
    );
    history.grid(&mut canvas, None, Some("angle φ [rad]"));
    history.begin_inside(&mut canvas, "spectrogram-history");
    let points = motion
        .trace
        .iter()
        .map(|point| (point.time_s, point.angle_rad));
    history.function(&mut canvas, "line rigid", points);
    canvas.end_group();
    history.frame(&mut canvas);

    let place = (72.0, right, top + 166.0, top + 516.0);
    picture(&mut canvas, result, place);
    Figure {
        name: NAME,
        title: title.into(),
        caption: "The paper's Fig. 5.".into(),
        description: description(result),
        height: top + 516.0 + 54.0,
        body: canvas.into_string(),
    }
}

fn description(result: &MotionSpectrogram) -> String {
    let at = |index: usize| {
        result.bounces.get(index).map_or_else(
            || "none".into(),
            |bounce| significant(bounce.frequency_hz, 4),
        )
    };
    format!(
        "Short-time amplitude over time and frequency; the bounce frequency rises from {} Hz over {} \
         Hz (fifth bounce) to {} Hz (tenth).",
        at(0),
        at(4),
        at(9)
    )
}

fn picture(canvas: &mut Canvas, result: &MotionSpectrogram, place: frame::PanelPlace) {
    let data = &result.amplitudes;
    let highest = result.highest_hz;
    let panel = Frame::narrow(
        place,
        Scale::Linear(0.0, result.duration_s),
        Scale::Linear(0.0, highest),
    );
    let bins = data.frequency_hz.len();
    let largest = data
        .amplitudes
        .iter()
        .flat_map(|row| row.iter().take(bins))
        .copied()
        .fold(0.0, f64::max);
    panel.grid(canvas, Some("time [s]"), Some("frequency [Hz]"));
    panel.begin_inside(canvas, "spectrogram-picture");
    if let (Some(first), Some(last), true) = (
        data.time_s.first(),
        data.time_s.last(),
        largest > 0.0 && bins > 1,
    ) {
        let high_db = 20.0 * libm::log10(largest);
        let columns = data.amplitudes.len();
        let (width, height) = (columns.min(MOST_CELLS.0), bins.min(MOST_CELLS.1));
        let cells = heat::cells((width, height), |column, line| {
            let amplitude = data.amplitudes[column * columns / width][line * bins / height];
            Some((20.0 * libm::log10(amplitude) - high_db + DEPTH_DB) / DEPTH_DB)
        });
        if let Some(base64) = cells {
            let from = panel.place(*first, data.frequency_hz[bins - 1]);
            let to = panel.place(*last, 0.0);
            canvas.png(&base64, from, (to.0 - from.0, to.1 - from.1));
        }
        for edge in [first, last] {
            panel.upright(canvas, "edge", *edge);
        }
    }
    let ridge: Vec<(f64, f64)> = result
        .bounces
        .iter()
        .map(|bounce| (bounce.time_s, bounce.frequency_hz))
        .collect();
    for class in ["ridge-edge", "ridge"] {
        canvas.polyline(
            class,
            ridge
                .iter()
                .map(|(time, frequency)| panel.place(*time, *frequency)),
        );
    }
    for (time, frequency) in ridge.iter().filter(|at| at.1 <= highest) {
        canvas.circle("ridge-dot", panel.place(*time, *frequency), 3.0);
    }
    canvas.end_group();
    panel.frame(canvas);
    let _ = heat::decibel_bar(
        canvas,
        (panel.right + 10.0, panel.top, panel.bottom),
        (-DEPTH_DB, 0.0),
        &format!("dB re {} rad/s", trimmed(largest, 3)),
    );
}
