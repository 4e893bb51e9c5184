//! Sections against the amplitude, one panel per stop.

use super::dynamics::{empty, widened};
use crate::bifurcation::Diagram;
use crate::orbit::BifurcationKind;
use latchgate_report::plot::Figure;
use latchgate_report::plot::canvas::Canvas;
use latchgate_report::plot::frame::{Frame, LEFT, Scale, extent, header};
use latchgate_report::plot::raster::{self, BLUE};

/// Draws sections against the amplitude, one panel per stop, with births and doublings.
pub(super) fn draw(diagrams: &[Diagram]) -> Figure {
    const HEIGHT: f64 = 330.0;
    let mut canvas = Canvas::with_capacity(512 * 1024);
    let Some(first) = diagrams.first() else {
        return empty("bifurcation");
    };
    let omega = first.options.forced.angular_frequency_rad_s;
    let title = format!("Stroboscopic sections against amplitude, ω = {omega} rad/s");
    let mut lines = vec![
        "State at the start of each period of the excitation; the darker, the more points.".into(),
    ];
    lines.extend(marks(diagrams));
    let mut top = header(&mut canvas, LEFT, &title, &lines, &[]);
    let (low, high) = first.options.amplitudes_g;
    let amplitudes = Scale::Linear(low, high);
    // One scale for all, so that the stops can be compared.
    let velocities = widened(
        extent(
            diagrams
                .iter()
                .flat_map(|diagram| &diagram.columns)
                .flat_map(|column| &column.sections)
                .map(|section| section.velocity_rad_s),
        ),
        0.04,
    );
    let mut description = String::new();
    for diagram in diagrams {
        top += 30.0;
        let stop = diagram.options.forced.stop.name();
        let rows = diagram.rows();
        let panel = Frame::wide((top, top + HEIGHT), amplitudes, velocities);
        panel.title(&mut canvas, &format!("{stop} stop"));
        panel.grid(
            &mut canvas,
            Some("amplitude A [g]"),
            Some("angular velocity [rad/s]"),
        );
        let dot = (2000 / diagram.columns.len().max(1)).clamp(2, 6);
        let points = rows
            .iter()
            .map(|row| (row.amplitude_g, row.angular_velocity_rad_s));
        if let Some(png) = raster::cloud(points, &panel.x, &panel.y, panel.size(), dot, BLUE) {
            canvas.png(&png, panel.corner(), panel.size());
        }
        for found in diagram.found() {
            let x = panel.x.place(found.orbit.amplitude_g);
            let (class, height) = match found.kind {
                BifurcationKind::SaddleNode => ("birth", 26.0),
                BifurcationKind::PeriodDoubling => ("doubling", 13.0),
            };
            if panel.x.contains(found.orbit.amplitude_g) {
                canvas.line(class, (x, panel.bottom - height), (x, panel.bottom));
            }
        }
        panel.frame(&mut canvas);
        description.push_str(&format!(
            " {stop} stop: {} points at {} amplitudes, {} births and doublings.",
            rows.len(),
            diagram.columns.len(),
            diagram.found().count()
        ));
        top += HEIGHT + 44.0;
    }
    Figure {
        name: "bifurcation",
        title,
        caption: lines.join(" "),
        description: format!("Scatter of angular velocity against amplitude.{description}"),
        height: top + 8.0,
        body: canvas.into_string(),
    }
}

/// Explains the marks at the foot of the panels, if there are any.
fn marks(diagrams: &[Diagram]) -> Option<String> {
    let (low, high) = diagrams.first()?.options.amplitudes_g;
    let shown = |kind: BifurcationKind| {
        diagrams
            .iter()
            .flat_map(Diagram::found)
            .any(|found| found.kind == kind && (low..=high).contains(&found.orbit.amplitude_g))
    };
    let birth = shown(BifurcationKind::SaddleNode)
        .then_some("Long green marks at the foot: an orbit is born.");
    let doubling = shown(BifurcationKind::PeriodDoubling)
        .then_some("Short red marks at the foot: a period doubles.");
    let words: Vec<&str> = birth.into_iter().chain(doubling).collect();
    (!words.is_empty()).then(|| words.join(" "))
}
