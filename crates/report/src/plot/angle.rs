//! The lever's angle over time, with the limit, the impacts, the first crossing and the peak.

use super::PlotContext;
use super::chart::{At, Chart, Panel, Point, Shape};
use super::error_bar::{BAR_END, ErrorBar};
use super::frame::{LegendEntry, Sample, Scale, StopClasses};
use crate::{opening, words};
use latchgate_document::Document;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;
use latchgate_kernel::units::OpensWhen;
use latchgate_verdict::{Answer, Trace};

pub(super) const NAME: &str = "angle";

/// Most traces of a drawing: each stop with two opening directions.
const TRACES: usize = 2 * StopModel::ALL.len();

/// Returns the class of each run: a colour for each stop, the same in every picture, and another
/// dash for a second opening direction.
pub(super) fn classes(
    runs: impl Iterator<Item = (StopModel, OpensWhen)>,
) -> impl Iterator<Item = &'static str> {
    let mut first = None;
    runs.map(move |(model, opens_when)| {
        let same = *first.get_or_insert(opens_when) == opens_when;
        let classes = StopClasses::of(model);
        match same {
            true => classes.run,
            false => classes.other,
        }
    })
}

/// As [`classes`], of traces.
pub(super) fn trace_classes(traces: &[&Trace]) -> Vec<&'static str> {
    classes(traces.iter().map(|trace| (trace.model, trace.opens_when))).collect()
}

/// A peak this many times above or below the limit gets a second panel.
const FAR: f64 = 5.0;

pub(super) fn chart(context: &PlotContext) -> Option<Chart> {
    let traces = drawn_traces(context);
    traces.first()?;
    let document = context.document;
    let nominal = document.nominal.as_ref();
    let (main_range, zoom_range, above) = ranges(context, &traces);
    let mut legend = legend(&traces, nominal.is_some());
    legend.push(LegendEntry::line("limit", "limit"));
    if nominal.is_some_and(|run| !run.impact_list.is_empty()) {
        let impacts = Sample::Tick("impact");
        legend.push(LegendEntry::new(impacts, "impacts, nominal run"));
    }
    let panels = match zoom_range {
        None => {
            let panel = panel(context, &traces, 290.0, main_range);
            vec![marks(context, impacts(context, panel), main_range, |_| {
                true
            })]
        }
        Some(zoom) => {
            let is_in_zoom = |angle: f64| zoom.contains(angle);
            let main = panel(context, &traces, 240.0, main_range).x("", context.time());
            let main = marks(context, main, main_range, |angle| !is_in_zoom(angle));
            let lower = impacts(context, panel(context, &traces, 170.0, zoom));
            let side = if above {
                "around the limit"
            } else {
                "below the limit"
            };
            let lower = lower.text("muted halo", (At::High(-8.0), At::High(18.0)), side);
            vec![main, marks(context, lower, zoom, is_in_zoom)]
        }
    };
    let result = result_sentence(document);
    let limit = words::limit(document.threshold_rad);
    Some(Chart {
        name: NAME,
        title: "Angle of the lever".into(),
        legend,
        panels,
        caption: format!(
            "Positive angles lead away from the stop; the door counts as lost above {limit}. {result}"
        ),
        description: format!(
            "Angle of the lever in radians over time, with the limit of {limit}. {result}"
        ),
        ..context.chart()
    })
}

/// Returns the range of the angle, that of a second panel where one needs it to be seen against
/// the limit, and whether a run exceeds the limit.
fn ranges(context: &PlotContext, traces: &[&Trace]) -> (Range, Option<Range>, bool) {
    let document = context.document;
    let threshold = document.threshold_rad;
    let angles = || {
        traces
            .iter()
            .flat_map(|trace| trace.points.iter().map(|point| point.angle_rad))
            .chain(document.nominal.iter().map(|run| run.peak_angle_rad))
            .filter(|angle| angle.is_finite())
    };
    let largest = angles().fold(f64::NEG_INFINITY, f64::max);
    let least = angles().fold(0.0, f64::min);
    let high = largest.max(threshold);
    let main_range = Range::new(least - (high - least) * 0.03, high + (high - least) * 0.14);
    let zoom_range = if largest > FAR * threshold {
        Some(Range::new(
            least.max(-threshold) - 0.06 * threshold,
            1.5 * threshold,
        ))
    } else if largest > 0.0 && largest < threshold / FAR {
        let least = least.max(-largest);
        Some(Range::new(
            least - (largest - least) * 0.08,
            largest + (largest - least) * 0.25,
        ))
    } else {
        None
    };
    (main_range, zoom_range, largest > threshold)
}

/// Returns the traces that hold points, four at most, the nominal run's first.
pub(super) fn drawn_traces<'a>(context: &PlotContext<'a>) -> Vec<&'a Trace> {
    context
        .evidence
        .traces
        .iter()
        .filter(|trace| !trace.points.is_empty())
        .take(TRACES)
        .collect()
}

pub(super) fn legend(traces: &[&Trace], nominal: bool) -> Vec<LegendEntry> {
    traces
        .iter()
        .zip(trace_classes(traces))
        .enumerate()
        .map(|(index, (trace, class))| {
            let stop = trace.model.label();
            let opens = words::opens(trace.opens_when);
            let nominal = if index == 0 && nominal {
                " (nominal)"
            } else {
                ""
            };
            LegendEntry::line(class, format!("{stop}, {opens}{nominal}"))
        })
        .collect()
}

pub(super) fn result_sentence(document: &Document) -> String {
    if document.verdict == Answer::Unusable {
        return "The recording is unusable: the curves rest on faulty samples.".into();
    }
    let Some(run) = &document.nominal else {
        return "There is no nominal run.".into();
    };
    let crossing = opening::of_run(document, run);
    let crossing = crossing.unwrap_or_else(|| "it stays below the limit angle".into());
    format!(
        "The nominal lever ({}, {}): {}; {crossing}.",
        run.model.label(),
        words::opens(run.opens_when),
        words::peak(document, run),
    )
}

/// Returns the angles of all traces in a range, with the limit where it lies in it.
fn panel(context: &PlotContext, traces: &[&Trace], height: f64, range: Range) -> Panel {
    let curves = traces.iter().zip(trace_classes(traces));
    let panel = context
        .over_time(height)
        .y("angle φ [rad]", Scale::Linear(range.low, range.high))
        .right(f64::to_degrees(1.0), "angle φ [°]")
        .level("zero", 0.0)
        .each(curves, |panel, (trace, class)| {
            panel.function(class, context.angles(trace))
        });
    let panel = context.judged_window(panel);
    match range.contains(context.document.threshold_rad) {
        true => context.limit(panel),
        false => panel,
    }
}

/// Adds a stroke at the foot for each impact of the nominal run.
fn impacts(context: &PlotContext, panel: Panel) -> Panel {
    let runs = context.document.nominal.iter();
    panel.each(runs.flat_map(|run| &run.impact_list), |panel, [at_s, _]| {
        let x = At::Value(at_s * context.time_scale, 0.0);
        panel.segment("impact", (x, At::Low(-9.0)), (x, At::Low(0.0)))
    })
}

/// Marks peak and first crossing of the nominal run, where this panel shows their angle best.
fn marks(
    context: &PlotContext,
    panel: Panel,
    range: Range,
    is_best: impl Fn(f64) -> bool,
) -> Panel {
    // Faulty samples show no event.
    let usable = context.document.verdict != Answer::Unusable;
    let run = context.document.nominal.as_ref().filter(|_| usable);
    let scale = context.time_scale;
    let limit = context.document.threshold_rad;
    let crossing = run
        .and_then(|run| run.first_crossing_s)
        .filter(|_| is_best(limit));
    let peak = run.filter(|run| is_best(run.peak_angle_rad));
    panel
        .each(crossing, |panel, at_s| {
            // Away from the limit's own label at the left, below the line.
            let label_place = (At::Value(at_s * scale, 0.0), At::Value(limit, 20.0));
            panel
                .marks(
                    "cross",
                    Shape::Diamond(6.0),
                    [Point::new(at_s * scale, limit)],
                )
                .beside(
                    "alarm halo",
                    label_place,
                    format!("opens at {}", opening::nominal_instant(at_s)),
                )
        })
        .each(peak, |panel, run| {
            let (x, y) = (run.peak_time_s * scale, run.peak_angle_rad);
            let text = format!("peak {}", words::short_peak(context.document, run));
            let bar = ErrorBar::of_run(context.document, run);
            panel
                .each(
                    bar.and_then(|bar| bar.within(range)),
                    |panel, (span, ends)| {
                        let place = |angle: f64| (At::Value(x, 0.0), At::Value(angle, 0.0));
                        let panel =
                            panel.segment("mark error-bar", place(span.low), place(span.high));
                        panel.each(ends.into_iter().flatten(), |panel, end| {
                            let (left, right) = (At::Value(x, -BAR_END), At::Value(x, BAR_END));
                            let end = At::Value(end, 0.0);
                            panel.segment("mark error-bar", (left, end), (right, end))
                        })
                    },
                )
                .marks("mark", Shape::Circle(4.5), [Point::new(x, y)])
                .beside("strong halo", (At::Value(x, 0.0), At::Value(y, -7.0)), text)
        })
}
