//! How far the scattered levers spread around the nominal one, over time.

use super::PlotContext;
use super::angle::result_sentence;
use super::chart::{Chart, Point, Points};
use super::frame::{LegendEntry, Sample, Scale, StopClasses, extent};
use crate::words;
use latchgate_document::number::count;
use latchgate_kernel::range::Range;
use latchgate_verdict::ensemble::Varied;

pub(super) const NAME: &str = "spread";

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let band = context.evidence.quantile_band.as_ref()?;
    let mut traces = context.evidence.traces.iter();
    let nominal =
        traces.find(|trace| trace.model == band.model && trace.opens_when == band.opens_when);
    let angles = nominal.into_iter().flat_map(|trace| &trace.points);
    let angles = angles.map(|point| point.angle_rad);
    let angles = angles.chain(band.p05.iter().chain(&band.p95).copied());
    let Range { low, high } = extent(angles.chain([0.0, context.document.threshold_rad]));
    let room = high - low;
    let along = |values: &[f64]| -> Points {
        let points = band.time_s.iter().zip(values);
        points
            .map(|(time, angle)| Point::new(time * context.time_scale, *angle))
            .collect()
    };
    let outline = along(&band.p95);
    let outline = outline
        .into_iter()
        .chain(along(&band.p05).into_iter().rev());
    let StopClasses { ribbon, run, .. } = StopClasses::of(band.model);
    let panel = context
        .over_time(250.0)
        .y(
            "angle φ [rad]",
            Scale::Linear(low - room * 0.03, high + room * 0.10),
        )
        .level("zero", 0.0)
        .lines(ribbon, outline)
        .each(nominal, |panel, trace| {
            panel.function(run, context.angles(trace))
        })
        .lines("median", along(&band.p50));
    let ensemble = context.document.ensemble.as_ref();
    let members_word = ensemble
        .map_or(Varied::Levers, |ensemble| ensemble.varied)
        .members();
    let members = count(u64::try_from(band.members).unwrap_or(u64::MAX));
    let which = format!("{}, {}", band.model.label(), words::opens(band.opens_when));
    Some(Chart {
        name: NAME,
        title: format!("Spread of the {members_word}"),
        legend: vec![
            LegendEntry::new(Sample::Patch(ribbon), "90 % of the members at each instant"),
            LegendEntry::line("median", "median"),
            LegendEntry::line(run, "nominal run"),
            LegendEntry::line("limit", "limit"),
        ],
        panels: vec![context.limit(context.judged_window(panel))],
        caption: format!(
            "The first {members} members of the ensemble ({which}), the nominal lever among them. \
             At each instant five in a hundred lie above the band and five below; single levers \
             leave it for a moment, so peaks are read from the table of the ensemble, not from \
             the band."
        ),
        description: format!(
            "Band between the 5 % and 95 % quantile of the angle of {members} {members_word} \
             over time ({which}), with their median and the nominal run. {}",
            result_sentence(context.document)
        ),
        ..context.chart()
    })
}
