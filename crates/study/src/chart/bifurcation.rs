//! Sections against the amplitude, one panel per stop.

use crate::bifurcation::Diagram;
use crate::orbit::BifurcationKind;
use latchgate_kernel::range::Range;
use latchgate_report::plot::chart::At::{Low, Value};
use latchgate_report::plot::chart::{ACROSS, Chart, Panel, Point};
use latchgate_report::plot::frame::{Scale, WIDE, range};
use latchgate_report::plot::raster::BLUE;

/// Returns sections against the amplitude, one panel per stop, with births and doublings.
pub(super) fn chart(diagrams: &[Diagram]) -> Chart {
    let options = diagrams.first().map(|diagram| &diagram.options);
    let omega = options.map_or(0.0, |options| options.forced.angular_frequency_rad_s);
    let mut notes = vec![
        "State at the start of each period of the excitation; the darker, the more points.".into(),
    ];
    notes.extend(marks(diagrams));
    // All panels share one scale, so that the stops can be compared.
    let columns = diagrams.iter().flat_map(|diagram| &diagram.columns);
    let sections = columns.flat_map(|column| &column.sections);
    let velocities = range(sections.map(|section| section.velocity_rad_s), 0.04);
    let mut description = String::from("Scatter of angular velocity against amplitude.");
    for diagram in diagrams {
        description.push_str(&format!(
            " {} stop: {} points at {} amplitudes, {} births and doublings.",
            diagram.options.forced.stop.name(),
            diagram.rows().len(),
            diagram.columns.len(),
            diagram.bifurcations().count()
        ));
    }
    let panels = diagrams.iter().map(|diagram| panel(diagram, velocities));
    Chart {
        name: "bifurcation",
        title: format!("Stroboscopic sections against amplitude, ω = {omega} rad/s"),
        caption: notes.join(" "),
        notes,
        panels: panels.collect(),
        room: [30.0, 74.0, 52.0],
        description,
        ..Chart::default()
    }
}

fn panel(diagram: &Diagram, velocities: Scale) -> Panel {
    let Range { low, high } = diagram.options.amplitudes_g;
    let rows = diagram.rows();
    let points = rows
        .iter()
        .map(|row| Point::new(row.amplitude_g, row.angular_velocity_rad_s));
    let dot = (2000 / diagram.columns.len().max(1)).clamp(2, 6);
    Panel::new(&WIDE, ACROSS, 330.0)
        .title(format!("{} stop", diagram.options.forced.stop.name()))
        .x("amplitude A [g]", Scale::Linear(low, high))
        .y("angular velocity [rad/s]", velocities)
        .cloud(BLUE, points.collect(), dot)
        .each(diagram.bifurcations(), |panel, bifurcation| {
            let (class, height) = match bifurcation.kind {
                BifurcationKind::SaddleNode => ("birth", 26.0),
                BifurcationKind::PeriodDoubling => ("doubling", 13.0),
            };
            let x = Value(bifurcation.orbit.amplitude_g, 0.0);
            panel.segment(class, (x, Low(-height)), (x, Low(0.0)))
        })
}

/// Returns an explanation of the marks at the foot of the panels, if there are any.
fn marks(diagrams: &[Diagram]) -> Option<String> {
    let Range { low, high } = diagrams.first()?.options.amplitudes_g;
    let shown = |kind: BifurcationKind| {
        diagrams
            .iter()
            .flat_map(Diagram::bifurcations)
            .any(|bifurcation| {
                bifurcation.kind == kind && (low..=high).contains(&bifurcation.orbit.amplitude_g)
            })
    };
    let birth = shown(BifurcationKind::SaddleNode)
        .then_some("Long green marks at the foot: an orbit is born.");
    let doubling = shown(BifurcationKind::PeriodDoubling)
        .then_some("Short red marks at the foot: a period doubles.");
    let words: Vec<&str> = birth.into_iter().chain(doubling).collect();
    (!words.is_empty()).then(|| words.join(" "))
}
