//! Phase plane: angular velocity against angle.

use super::angle::{drawn_traces, legend, trace_classes};
use super::canvas::{Anchor, Canvas};
use super::frame::{self, Frame, LEFT, LegendEntry, RIGHT, Scale};
use super::{Figure, PlotContext, thin};
use crate::words;
use latchgate_document::number::exact;

pub(super) const NAME: &str = "phase-plane";

/// Points of a trace that are drawn at most.
const MOST_POINTS: usize = 12_000;

pub(super) fn draw(context: &PlotContext) -> Option<Figure> {
    let traces = drawn_traces(context);
    traces.first()?;
    let threshold = context.document.threshold_rad;
    let mut x = (0.0_f64, threshold);
    let mut y = (0.0_f64, 0.0_f64);
    for point in traces.iter().flat_map(|trace| &trace.points) {
        if point.angle_rad.is_finite() && point.velocity_rad_s.is_finite() {
            x = (x.0.min(point.angle_rad), x.1.max(point.angle_rad));
            y = (y.0.min(point.velocity_rad_s), y.1.max(point.velocity_rad_s));
        }
    }
    let (x_margin, y_margin) = ((x.1 - x.0) * 0.04, ((y.1 - y.0) * 0.06).max(1e-9));

    let mut entries = legend(&traces, context.document.nominal.is_some());
    entries.push(LegendEntry::line("limit", "limit"));
    let mut canvas = Canvas::with_capacity(160 * 1024);
    let title = "Phase plane of the lever";
    let top = frame::header(&mut canvas, LEFT, title, &[], &entries);
    let bottom = top + 320.0;
    let height = bottom + frame::FOOTER;
    let panel = Frame::wide(
        (top, bottom),
        Scale::Linear(x.0 - x_margin, x.1 + x_margin),
        Scale::Linear(y.0 - y_margin, y.1 + y_margin),
    );
    panel.grid(
        &mut canvas,
        Some("angle φ [rad]"),
        Some("angular velocity φ′ [rad/s]"),
    );
    panel.level(&mut canvas, "zero", 0.0);
    panel.upright(&mut canvas, "zero", 0.0);
    panel.begin_inside(&mut canvas, "phase-plane-clip");
    for (trace, class) in traces.iter().zip(trace_classes(&traces)) {
        let points: Vec<(f64, f64)> = trace
            .points
            .iter()
            .map(|point| panel.place(point.angle_rad, point.velocity_rad_s))
            .collect();
        canvas.polyline(class, thin::curve(&points, 0.6, MOST_POINTS).into_iter());
    }
    canvas.end_group();
    let x = panel.x.place(threshold);
    canvas.line("limit", (x, top), (x, bottom));
    let (label_x, anchor) = if x > f64::midpoint(LEFT, RIGHT) {
        (x - 7.0, Anchor::End)
    } else {
        (x + 7.0, Anchor::Start)
    };
    canvas.text(
        "alarm halo",
        (label_x, top + 18.0),
        anchor,
        &format!("limit {} rad", exact(threshold)),
    );
    panel.frame(&mut canvas);
    frame::footer(&mut canvas, &context.origin, height);

    Some(Figure {
        name: NAME,
        title: title.into(),
        caption: "Each turn to the right is a swing away from the stop; a jump from negative to \
                  positive velocity near φ = 0 is an impact."
            .into(),
        description: format!(
            "Angular velocity of the lever against its angle, with the limit of {}.",
            words::limit(context.document.threshold_rad)
        ),
        height,
        body: canvas.into_string(),
    })
}
