//! The peak under a shock against each of the lever's numbers.

use crate::parameters::{Number, Parameters};
use latchgate_document::number::exact;
use latchgate_kernel::model::stop::StopModel;
use latchgate_report::plot::chart::{Chart, HALVES, Panel, Point};
use latchgate_report::plot::frame::{LegendEntry, NARROW, Scale, stop_legend};

/// Range of angles of the panels [rad], from a hundredth of the paper's limit.
const SHOWN: (f64, f64) = (1e-3, 10.0);

pub(super) fn chart(result: &Parameters) -> Chart {
    let is_shown = |model| result.rows.iter().any(|row| row.stop == model);
    let mut legend = stop_legend(class, &is_shown);
    legend.push(LegendEntry::line("limit", "limit"));
    legend.push(LegendEntry::line("edge", "the paper's value"));
    let panels = Number::ALL.into_iter().zip(HALVES.into_iter().cycle());
    Chart {
        name: "parameters",
        title: "Peak under the shock of a side impact against each number of the lever".into(),
        notes: vec!["One number at a time, the others as they are; angles below 0.001 rad are drawn there.".into()],
        legend,
        panels: panels.map(|(number, edges)| panel(result, number, edges)).collect(),
        room: [24.0, 72.0, 54.0],
        caption: "The paper's conclusion that parameters cannot reduce the response, over their whole range.".into(),
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

fn panel(
    result: &Parameters,
    number: Number,
    edges: latchgate_report::plot::chart::Edges,
) -> Panel {
    let of_number = || result.rows.iter().filter(|row| row.number == number);
    let values = || of_number().map(|row| row.value);
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(f64::NEG_INFINITY, f64::max);
    let scale = match number {
        Number::Restitution => Scale::Linear(0.0, 1.0),
        _ => Scale::Logarithmic(low, high),
    };
    let limit = result.design.criterion.threshold_rad;
    Panel::new(&NARROW, edges, 190.0)
        .x(number.title(), scale)
        .y("peak φ [rad]", Scale::Logarithmic(SHOWN.0, SHOWN.1))
        .each([StopModel::Rigid, StopModel::Soft], |panel, model| {
            let rows = of_number().filter(|row| row.stop == model);
            let points = rows.filter_map(|row| {
                let peak = row.peak_angle_rad?.clamp(SHOWN.0, SHOWN.1);
                Some(Point::new(row.value, peak))
            });
            panel.function(class(model), points.collect::<Vec<_>>())
        })
        .level("limit", limit)
        .upright("edge", number.of(&result.design))
}

fn description(result: &Parameters) -> String {
    let limit = exact(result.design.criterion.threshold_rad);
    let mut text = format!("Peak angle against six numbers, with the limit of {limit} rad.");
    for line in &result.headlines {
        if let (Some(model), Some(value)) = (line.model, line.value)
            && line.what.starts_with("least")
        {
            text += &format!(
                " {}, {} stop: least {}.",
                line.subject,
                model.name(),
                exact(value)
            );
        }
    }
    text
}
