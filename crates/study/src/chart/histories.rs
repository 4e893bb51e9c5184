//! Histories from several initial states, each in full and in its last periods.

use super::angles;
use crate::histories::{Histories, History};
use latchgate_document::number::{exact, significant};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;
use latchgate_report::plot::WIDTH;
use latchgate_report::plot::chart::At::High;
use latchgate_report::plot::chart::{Chart, Edges, Panel};
use latchgate_report::plot::frame::{NARROW, Scale, extent, range, stop_legend};

/// Periods of the excitation in the panels at the right.
const LATE_PERIODS: f64 = 6.0;

pub(super) fn chart(result: &Histories) -> Chart {
    let is_shown = |model| {
        result
            .histories
            .iter()
            .any(|history| history.model == model)
    };
    let by_start = result.histories.chunk_by(|a, b| a.start == b.start);
    let rows = ('a'..).zip(by_start);
    Chart {
        name: "histories",
        title: format!(
            "Where different starts end up: A = {} g, ω = {} rad/s",
            exact(result.amplitude_g),
            exact(result.angular_frequency_rad_s)
        ),
        notes: vec![
            "Left: from the start. Right: the last periods shown, on a scale of their own.".into(),
        ],
        legend: stop_legend(class, &is_shown),
        panels: rows
            .flat_map(|(letter, group)| row(result, group, letter))
            .collect(),
        room: [22.0, 92.0, 70.0],
        caption: "The paper's Fig. 10.".into(),
        description: description(result),
        ..Chart::default()
    }
}

fn class(model: StopModel) -> &'static str {
    match model {
        StopModel::Rigid => "line rigid",
        StopModel::Soft => "line soft",
    }
}

fn description(result: &Histories) -> String {
    let mut text = String::from("Angle against time.");
    for history in &result.histories {
        text.push_str(&format!(
            " From ({}, {}), {} stop: {}.",
            history.start.angle_rad,
            history.start.velocity_rad_s,
            history.model.name(),
            history.settled.words()
        ));
    }
    text
}

/// Returns the histories from one start, in full and in the last periods.
fn row(result: &Histories, group: &[History], letter: char) -> [Panel; 2] {
    let end = result.duration_s;
    let from = (end - LATE_PERIODS * result.period_s).max(0.0);
    let points = || group.iter().flat_map(|history| angles(&history.trace, 1.0));
    let late = points().filter(|point| point.x >= from);
    let Range { low, high } = extent(late.map(|point| point.y));
    let room = 0.08 * (high - low);
    // A scale of a lever at rest would magnify rounding, so it has a least range.
    let late = Scale::Linear((low - room).min(-0.002), (high + room).max(0.02));
    let panel = |edges, from| {
        Panel::new(&NARROW, edges, 170.0)
            .x("time [s]", Scale::Linear(from, end))
            .level("zero", 0.0)
            .each(group, |panel, history| {
                panel.function(class(history.model), angles(&history.trace, 1.0))
            })
    };
    let start = group[0].start;
    let (angle, velocity) = (exact(start.angle_rad), exact(start.velocity_rad_s));
    let full = panel(Edges::new(72.0, 560.0), 0.0)
        .title(format!(
            "({letter}) from φ = {angle} rad, φ′ = {velocity} rad/s"
        ))
        .y("angle φ [rad]", range(points().map(|point| point.y), 0.05))
        .each(group.iter().zip(0..), |panel, (history, line)| {
            let settled = &history.settled;
            let peak = match settled.rests {
                true => String::new(),
                false => format!(", up to {} rad", significant(settled.peak_angle_rad, 4)),
            };
            let text = format!("{} stop: {}{peak}", history.model.name(), settled.words());
            let y = High(18.0 + 17.0 * f64::from(line));
            panel.text("small halo", (High(-8.0), y), text)
        });
    [
        full,
        panel(Edges::new(640.0, WIDTH - 16.0), from).y("", late),
    ]
}
