//! Phase plane: angular velocity against angle.

use super::PlotContext;
use super::angle::{drawn_traces, legend, trace_classes};
use super::chart::{ACROSS, At, Chart, Panel, Point};
use super::frame::{LegendEntry, WIDE, range};
use crate::words;
use latchgate_document::number::exact;

pub(super) const NAME: &str = "phase-plane";

/// Largest number of points drawn of a trace.
const MOST_POINTS: usize = 12_000;

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let traces = drawn_traces(context);
    traces.first()?;
    let limit = context.document.threshold_rad;
    let points = || traces.iter().flat_map(|trace| &trace.points);
    let angles = points().map(|point| point.angle_rad).chain([0.0, limit]);
    let velocities = points().map(|point| point.velocity_rad_s).chain([0.0]);
    let mut legend = legend(&traces, context.document.nominal.is_some());
    legend.push(LegendEntry::line("limit", "limit"));
    let panel = Panel::new(&WIDE, ACROSS, 320.0)
        .x("angle φ [rad]", range(angles, 0.04))
        .y("angular velocity φ′ [rad/s]", range(velocities, 0.06))
        .level("zero", 0.0)
        .upright("zero", 0.0)
        .each(
            traces.iter().zip(trace_classes(&traces)),
            |panel, (trace, class)| {
                let points = trace.points.iter();
                let points = points.map(|point| Point::new(point.angle_rad, point.velocity_rad_s));
                panel.curve(class, points, MOST_POINTS)
            },
        )
        .upright("limit", limit)
        .beside(
            "alarm halo",
            (At::Value(limit, 0.0), At::High(18.0)),
            format!("limit {} rad", exact(limit)),
        );
    Some(Chart {
        name: NAME,
        title: "Phase plane of the lever".into(),
        legend,
        panels: vec![panel],
        caption: "Each turn to the right is a swing away from the stop; a jump from negative to \
                  positive velocity near φ = 0 is an impact."
            .into(),
        description: format!(
            "Angular velocity of the lever against its angle, with the limit of {}.",
            words::limit(context.document.threshold_rad)
        ),
        ..context.chart()
    })
}
