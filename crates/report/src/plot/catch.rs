//! The lever's angle with that of an inertia catch below it, and where the catch engages.

use super::PlotContext;
use super::angle::{drawn_traces, legend, trace_classes};
use super::chart::{At, Chart, Panel};
use super::frame::Scale;
use crate::words;
use latchgate_document::number::exact;
use latchgate_verdict::{Mechanism, Trace};

pub(super) const NAME: &str = "catch";

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let document = context.document;
    let catch = document.design.catch?;
    let Mechanism::InertiaCatch { runs, .. } = document.mechanism.as_ref()?;
    let levers = drawn_traces(context);
    let catches: Vec<&Trace> = levers
        .iter()
        .filter_map(|lever| {
            let mut traces = context.evidence.catch_traces.iter();
            traces.find(|trace| (trace.model, trace.opens_when) == (lever.model, lever.opens_when))
        })
        .collect();
    catches.first()?;
    let nominal = runs.iter().find(|run| {
        let lever = levers.first();
        lever.is_some_and(|lever| (lever.model, lever.opens_when) == (run.model, run.opens_when))
    })?;
    let blocked = catch.lever_angle_rad;
    let lever_high = (1.5 * document.threshold_rad).max(1.5 * blocked);
    let upper = panel(context, &levers, 190.0)
        .y(
            "lever φ [rad]",
            Scale::Linear(-0.1 * lever_high, lever_high),
        )
        .x("", context.time());
    let upper = context.limit(upper).level("edge", blocked).text(
        "muted halo",
        (At::High(-8.0), At::Value(blocked, 14.0)),
        format!(
            "stopped at φb = {} rad while the catch is engaged",
            exact(blocked)
        ),
    );
    let catch_high = 1.15 * catch.end_stop_angle_rad.max(nominal.run.peak_angle_rad);
    let engagement = catch.engagement_angle_rad;
    let lower = panel(context, &catches, 190.0)
        .y(
            "catch ψ [rad]",
            Scale::Linear(-0.1 * catch_high, catch_high),
        )
        .x(format!("time [{}]", context.time_unit), context.time())
        .level("edge", engagement)
        .text(
            "muted halo",
            (At::High(-8.0), At::Value(engagement, -6.0)),
            format!("engaged from ψb = {} rad", exact(engagement)),
        );
    let instants = [
        (nominal.run.engaged_s, "edge"),
        (nominal.run.lever_passes_s, "fault"),
    ];
    let mark = |panel: Panel| {
        panel.each(instants, |panel, (instant, class)| match instant {
            Some(instant) => panel.upright(class, instant * context.time_scale),
            None => panel,
        })
    };
    let words = words::catch(document).unwrap_or_default();
    Some(Chart {
        name: NAME,
        title: "Lever and inertia catch".into(),
        legend: legend(&levers, true),
        panels: vec![mark(upper), mark(lower)],
        caption: format!(
            "The upright lines mark where the catch engages and where the lever passes it. {words}"
        ),
        description: format!("Angles of lever and catch in radians over time. {words}"),
        ..context.chart()
    })
}

/// Returns a panel with one curve of each trace.
fn panel(context: &PlotContext, traces: &[&Trace], height: f64) -> Panel {
    let mut panel = context.over_time(height).level("zero", 0.0);
    for (trace, class) in traces.iter().zip(trace_classes(traces)) {
        panel = panel.function(class, context.angles(trace));
    }
    panel
}
