//! A shock and the lever's motion in it and after.

use super::angles;
use crate::shock::{Response, Shock};
use latchgate_document::number::{exact, significant, trimmed};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;
use latchgate_report::plot::chart::At::{High, Value};
use latchgate_report::plot::chart::{ACROSS, Chart, Panel, Point};
use latchgate_report::plot::frame::{LegendEntry, NARROW, Scale, extent, range, stop_legend};

pub(super) fn chart(result: &Shock) -> Chart {
    let responses = &result.responses;
    let is_shown = |model| responses.iter().any(|response| response.run.model == model);
    let mut legend = stop_legend(class, &is_shown);
    legend.push(LegendEntry::line("limit", "limit"));
    let (text, axis) = responses.split_at(responses.len() / 2);
    Chart {
        name: "shock",
        title: "Response to the shock of a side impact".into(),
        notes: vec![
            "A burst by formula stands for the paper's signal, which is not public.".into(),
        ],
        legend,
        panels: vec![
            acceleration(result),
            response(result, text, "(b)", "the text's reading, in g"),
            response(result, axis, "(c)", "the axis's reading, in m/s²"),
        ],
        room: [22.0, 80.0, 54.0],
        caption: "The paper's Fig. 11, with a substitute for its signal.".into(),
        description: description(result),
        ..Chart::default()
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

/// Returns the peak that the signals of the responses share, in both units.
fn peak(result: &Shock, responses: &[Response]) -> String {
    let peak = responses
        .first()
        .map_or(f64::NAN, |response| response.peak_acceleration_m_s2);
    let in_g = significant(peak / result.gravity_m_s2, 4);
    format!("{} m/s² ({in_g} g)", significant(peak, 4))
}

fn acceleration(result: &Shock) -> Panel {
    let signal = &result.signals[0];
    let points = signal.samples.iter().enumerate();
    let points = points.map(|(index, a)| Point::new(signal.time_s(index) * 1e3, a * 1e-3));
    let peak = peak(result, &result.responses);
    let accelerations = range(signal.samples.iter().map(|a| a * 1e-3), 0.06);
    Panel::new(&NARROW, ACROSS, 190.0)
        .title(format!(
            "(a) acceleration of the base, peak {peak}; negative opens"
        ))
        .x("time [ms]", Scale::Linear(0.0, 1.15e3 * result.shock_s))
        .y("acceleration [10³ m/s²]", accelerations)
        .right(1e3 / result.gravity_m_s2, "[g]")
        .level("zero", 0.0)
        .function("line ink", points)
}

fn response(result: &Shock, responses: &[Response], letter: &str, reading: &str) -> Panel {
    let (threshold, end_of_shock) = (result.threshold_rad, result.shock_s * 1e3);
    let points = responses
        .iter()
        .flat_map(|response| angles(&response.trace, 1e3));
    let Range { low, high } = extent(points.map(|point| point.y).chain([0.0, threshold]));
    let room = 0.06 * (high - low);
    // The text at the top needs room.
    let scale = Scale::Linear(low - room, high + room + 0.25 * (high - low));
    let peak = peak(result, responses);
    Panel::new(&NARROW, ACROSS, 200.0)
        .title(format!("{letter} lever under a peak of {peak}: {reading}"))
        .x(
            "time [ms]",
            Scale::Linear(0.0, result.signals[0].end_s() * 1e3),
        )
        .y("angle φ [rad]", scale)
        .level("zero", 0.0)
        .upright("edge", end_of_shock)
        .each(responses, |panel, response| {
            panel.function(class(response.run.model), angles(&response.trace, 1e3))
        })
        .level("limit", threshold)
        .text(
            "muted small halo",
            (Value(end_of_shock, 6.0), High(18.0)),
            "end of the shock",
        )
        .each(responses.iter().zip(0..), |panel, (response, line)| {
            let label_place = (High(-8.0), High(18.0 + 17.0 * f64::from(line)));
            panel.text("small halo", label_place, outcome(response, threshold))
        })
}

/// Returns the peak of a response and the instant at which it exceeds the threshold, in words.
fn outcome(response: &Response, threshold: f64) -> String {
    let run = &response.run;
    let threshold = exact(threshold);
    let crossing = match run.first_crossing_s {
        Some(time) => format!("exceeds {threshold} rad at {} ms", trimmed(time * 1e3, 4)),
        None => format!("stays below {threshold} rad"),
    };
    let peak = significant(run.peak_angle_rad, 4);
    format!("{} stop: peak {peak} rad; {crossing}", run.model.name())
}
