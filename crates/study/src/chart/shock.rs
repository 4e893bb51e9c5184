//! A shock and what the lever does in it and after.

use crate::shock::{Response, Shock};
use latchgate_document::number::{exact, significant, trimmed};
use latchgate_kernel::model::stop::StopModel;
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{self, Frame, LegendEntry, Scale};
use latchgate_report::plot::{Figure, WIDTH};

const NAME: &str = "shock";

pub(super) fn draw(result: &Shock) -> Figure {
    let mut canvas = Canvas::with_capacity(128 * 1024);
    let title = "Response to the shock of a side impact";
    let mut legend = frame::stop_legend(class, &|model| {
        let mut responses = result.responses.iter();
        responses.any(|response| response.run.model == model)
    });
    legend.push(LegendEntry::line("limit", "limit"));
    let top = frame::header(
        &mut canvas,
        78.0,
        title,
        &["A burst by formula stands for the paper's signal, which is not public.".into()],
        &legend,
    ) + 22.0;
    acceleration(&mut canvas, result, (78.0, WIDTH - 70.0, top, top + 190.0));
    let per_signal = result.responses.len() / 2;
    let (text, axis) = result.responses.split_at(per_signal);
    let second = top + 190.0 + 80.0;
    let third = second + 200.0 + 80.0;
    response(
        &mut canvas,
        result,
        text,
        'b',
        (78.0, WIDTH - 70.0, second, second + 200.0),
    );
    response(
        &mut canvas,
        result,
        axis,
        'c',
        (78.0, WIDTH - 70.0, third, third + 200.0),
    );
    Figure {
        name: NAME,
        title: title.into(),
        caption: "The paper's Fig. 11, with a substitute for its signal.".into(),
        description: description(result),
        height: third + 200.0 + 54.0,
        body: canvas.into_string(),
    }
}

fn class(model: StopModel) -> &'static str {
    match model {
        StopModel::Rigid => "line rigid",
        StopModel::Soft => "line soft dash",
    }
}

fn description(result: &Shock) -> String {
    let mut text =
        String::from("Acceleration of the base, and angle of the lever for two readings.");
    for response in &result.responses {
        text.push_str(&format!(
            " Peak {} m/s², {} stop: peak angle {} rad.",
            significant(response.peak_acceleration_m_s2, 4),
            response.run.model.name(),
            significant(response.run.peak_angle_rad, 5)
        ));
    }
    text
}

fn acceleration(canvas: &mut Canvas, result: &Shock, place: frame::PanelPlace) {
    let signal = &result.signals[0];
    let end_ms = 1e3 * (1.15 * result.shock_s);
    let panel = Frame::narrow(
        place,
        Scale::Linear(0.0, end_ms),
        frame::range(signal.samples.iter().map(|a| a * 1e-3), 0.06),
    );
    let peak = result
        .responses
        .first()
        .map_or(f64::NAN, |response| response.peak_acceleration_m_s2);
    panel.title(
        canvas,
        &format!(
            "(a) acceleration of the base, peak {} m/s² = {} g; negative opens",
            significant(peak, 4),
            significant(peak / result.gravity_m_s2, 4)
        ),
    );
    panel.grid(canvas, Some("time [ms]"), Some("acceleration [10³ m/s²]"));
    panel.begin_inside(canvas, "shock-acceleration");
    panel.level(canvas, "zero", 0.0);
    let points = signal
        .samples
        .iter()
        .enumerate()
        .map(|(index, a)| (signal.time_s(index) * 1e3, a * 1e-3));
    panel.function(canvas, "line ink", points);
    canvas.end_group();
    panel.frame(canvas);
    panel.right_scale(canvas, 1e3 / result.gravity_m_s2, "[g]");
}

fn response(
    canvas: &mut Canvas,
    result: &Shock,
    responses: &[Response],
    letter: char,
    place: frame::PanelPlace,
) {
    let threshold = result.threshold_rad;
    let points = |response: &Response| -> Vec<(f64, f64)> {
        response
            .trace
            .iter()
            .map(|point| (point.time_s * 1e3, point.angle_rad))
            .collect()
    };
    let angles = responses
        .iter()
        .flat_map(points)
        .map(|point| point.1)
        .chain([0.0, threshold]);
    let end_ms = result.signals[0].end_s() * 1e3;
    let (low, high) = frame::extent(angles);
    let room = 0.06 * (high - low);
    let (low, high) = (low - room, high + room);
    // Room for the words at the top.
    let high = high + 0.22 * (high - low);
    let panel = Frame::narrow(place, Scale::Linear(0.0, end_ms), Scale::Linear(low, high));
    let (peak, reading) = responses.first().map_or((f64::NAN, ""), |first| {
        let words = if letter == 'b' {
            "the text's reading, in g"
        } else {
            "the axis's reading, in m/s²"
        };
        (first.peak_acceleration_m_s2, words)
    });
    panel.title(
        canvas,
        &format!(
            "({letter}) lever under a peak of {} m/s² ({} g): {reading}",
            significant(peak, 4),
            significant(peak / result.gravity_m_s2, 4)
        ),
    );
    panel.grid(canvas, Some("time [ms]"), Some("angle φ [rad]"));
    panel.begin_inside(canvas, &format!("{NAME}-response-{letter}"));
    panel.level(canvas, "zero", 0.0);
    panel.upright(canvas, "edge", result.shock_s * 1e3);
    for response in responses {
        panel.function(
            canvas,
            class(response.run.model),
            points(response).into_iter(),
        );
    }
    panel.level(canvas, "limit", threshold);
    canvas.end_group();
    panel.frame(canvas);
    canvas.text(
        "muted small halo",
        (panel.x.place(result.shock_s * 1e3) + 6.0, panel.top + 18.0),
        Anchor::Start,
        "end of the shock",
    );
    peaks(canvas, &panel, responses, threshold);
}

/// Writes the peak of each response, and when it passes the threshold.
fn peaks(canvas: &mut Canvas, panel: &Frame, responses: &[Response], threshold: f64) {
    for (line, response) in responses.iter().enumerate() {
        let y = panel.top + 18.0 + 17.0 * line as f64;
        let run = &response.run;
        let crossing = run.first_crossing_s.map_or_else(
            || format!("stays below {} rad", exact(threshold)),
            |time| {
                format!(
                    "passes {} rad at {} ms",
                    exact(threshold),
                    trimmed(time * 1e3, 4)
                )
            },
        );
        canvas.text(
            "small halo",
            (panel.right - 8.0, y),
            Anchor::End,
            &format!(
                "{} stop: peak {} rad; {crossing}",
                run.model.name(),
                significant(run.peak_angle_rad, 4)
            ),
        );
    }
}
