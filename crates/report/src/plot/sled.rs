//! A sled pulse after CFC 60 in the corridor of the door-latch regulations.

use super::PlotContext;
use super::chart::{Chart, Point};
use super::frame::{LegendEntry, Scale};
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::sled::{LEVEL_G, LOWER, UPPER};

pub(super) const NAME: &str = "sled206";

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let check = context.document.sled206.as_ref()?;
    let signal = context.evidence.sled206.as_ref()?;
    let scale = context.time_scale;
    let highest = check.peak_g.max(36.0);
    let bound =
        |bound: [(f64, f64); 4]| bound.map(|(time_s, level)| Point::new(time_s * scale, level));
    let samples = signal.samples.iter().enumerate();
    let points = samples.map(|(index, value)| {
        let level = check.sign * value / STANDARD_GRAVITY;
        Point::new(signal.time_s(index) * scale, level)
    });
    let mut panel = context
        .over_time(270.0)
        .y(
            "acceleration [g]",
            Scale::Linear(-0.1 * highest, 1.1 * highest),
        )
        .level("zero", 0.0)
        .level("edge", LEVEL_G)
        .function("limit", bound(LOWER))
        .function("limit", bound(UPPER))
        .function("used", points);
    if let Some(below) = check.below {
        panel = panel.upright("fault", below.time_s * scale);
    }
    Some(Chart {
        name: NAME,
        title: "Sled pulse in its corridor".into(),
        legend: vec![
            LegendEntry::line("used", "after CFC 60"),
            LegendEntry::line("limit", "corridor (unverified)"),
            LegendEntry::line("edge", "30 g"),
        ],
        panels: vec![panel],
        caption: check.sentences().join(" "),
        description: check.sentences().join(" "),
        ..context.chart()
    })
}
