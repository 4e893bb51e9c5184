//! Lever and catch under two pulses and under ringing.

use crate::catch::{Beside, CatchStudy, FREQUENCIES_HZ, GAP_MAX_S, Row, Scene};
use latchgate_document::number::exact;
use latchgate_kernel::model::stop::StopModel;
use latchgate_report::plot::chart::{Chart, Panel, Point, WHOLE};
use latchgate_report::plot::frame::{LegendEntry, NARROW, Scale};

/// Angles that the panels show [rad].
const SHOWN: (f64, f64) = (0.01, 10.0);

pub(super) fn chart(result: &CatchStudy) -> Chart {
    let stops = [StopModel::Rigid, StopModel::Soft];
    let shown = stops
        .into_iter()
        .filter(|model| result.rows.iter().any(|row| row.stop == *model));
    let mut legend: Vec<LegendEntry> = Beside::ALL
        .into_iter()
        .map(|beside| LegendEntry::line(class(beside), beside.title()))
        .collect();
    legend.push(LegendEntry::line("limit", "limit"));
    let (low, high) = FREQUENCIES_HZ;
    let scenes = [
        (
            Scene::TwoPulses,
            "gap between two pulses [ms]",
            Scale::Linear(0.0, 1e3 * GAP_MAX_S),
            1e3,
        ),
        (
            Scene::Ringing,
            "frequency of a ringing [Hz]",
            Scale::Logarithmic(low, high),
            1.0,
        ),
    ];
    let panels = shown.flat_map(|model| {
        scenes.map(|(scene, title, scale, times)| {
            let rows = result.rows.iter();
            let rows = rows.filter(move |row| (row.scene, row.stop) == (scene, model));
            panel(result.threshold_rad, rows.collect(), times)
                .x(title, scale)
                .y(
                    format!("peak φ [rad], {} stop", model.name()),
                    Scale::Logarithmic(SHOWN.0, SHOWN.1),
                )
        })
    });
    Chart {
        name: "catch",
        title: "A lever alone and beside an inertia catch".into(),
        notes: vec![
            "Largest angle of each record; a gap in a curve: errors do not say which came first.".into(),
        ],
        legend,
        panels: panels.collect(),
        room: [24.0, 72.0, 54.0],
        caption: "Each of the two pulses alone is held: a catch that falls back can be overtaken in its rebound.".into(),
        description: description(result),
        ..Chart::default()
    }
}

fn class(beside: Beside) -> &'static str {
    match beside {
        Beside::Nothing => "line ink dotted",
        Beside::ReversibleCatch => "line rigid bold",
        Beside::IrreversibleCatch => "line soft dash",
    }
}

fn panel(threshold_rad: f64, rows: Vec<&Row>, times: f64) -> Panel {
    let panel = Panel::new(&NARROW, WHOLE, 190.0);
    panel
        .each(Beside::ALL, |panel, beside| {
            let of_beside = rows.iter().filter(|row| row.beside == beside);
            let point = |row: &&&Row| {
                let peak = row
                    .peak_angle_rad
                    .map_or(f64::NAN, |peak| peak.clamp(SHOWN.0, SHOWN.1));
                Point::new(times * row.value, peak)
            };
            panel.function(
                class(beside),
                of_beside.map(|row| point(&row)).collect::<Vec<_>>(),
            )
        })
        .level("limit", threshold_rad)
}

fn description(result: &CatchStudy) -> String {
    let limit = exact(result.threshold_rad);
    let mut text = format!(
        "Peak angle against the gap of two pulses and against the frequency of a ringing, with the limit of {limit} rad."
    );
    for line in &result.headlines {
        if let (Some(model), Some(value)) = (line.model, line.value)
            && line.what.starts_with("opens from")
        {
            text += &format!(
                " {}, {} stop: {} {}.",
                line.subject,
                model.name(),
                line.what,
                exact(value)
            );
        }
    }
    text
}
