//! The lever's angle over time, with the limit, the impacts, the first crossing and the peak.

use super::canvas::{Anchor, Canvas};
use super::frame::{self, Frame, LEFT, LegendEntry, RIGHT, Sample};
use super::{Figure, PlotContext, acceleration, thin};
use crate::{opening, words};
use latchgate_document::number::exact;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::Run;
use latchgate_kernel::units::OpensWhen;
use latchgate_verdict::Trace;

pub(super) const NAME: &str = "angle";

/// Most traces of a drawing: two stops, each with two opening directions.
const TRACES: usize = 4;

/// Returns the class of each run: a colour for each stop, the same in every picture, and another
/// dash for a second opening direction.
pub(super) fn classes(
    runs: impl Iterator<Item = (StopModel, OpensWhen)>,
) -> impl Iterator<Item = &'static str> {
    let mut first = None;
    runs.map(move |(model, opens_when)| {
        let same = *first.get_or_insert(opens_when) == opens_when;
        match (model, same) {
            (StopModel::Rigid, true) => "run-rigid",
            (StopModel::Rigid, false) => "run-rigid other",
            (StopModel::Soft, true) => "run-soft",
            (StopModel::Soft, false) => "run-soft other",
        }
    })
}

/// As [`classes`], of traces.
pub(super) fn trace_classes(traces: &[&Trace]) -> Vec<&'static str> {
    classes(traces.iter().map(|trace| (trace.model, trace.opens_when))).collect()
}

const DEGREES_PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// A peak this many times above or below the limit gets a second panel.
const FAR: f64 = 5.0;

pub(super) fn draw(context: &PlotContext) -> Option<Figure> {
    let traces = drawn_traces(context);
    traces.first()?;
    let document = context.document;
    let nominal = document.nominal.as_ref();
    let (main_range, zoom_range, above) = ranges(context, &traces);
    let mut entries = legend(&traces, nominal.is_some());
    entries.push(LegendEntry::line("limit", "limit"));
    if nominal.is_some_and(|run| !run.impact_list.is_empty()) {
        entries.push(LegendEntry::new(
            Sample::Tick("impact"),
            "impacts, nominal run",
        ));
    }
    let mut canvas = Canvas::with_capacity(160 * 1024);
    let title = "Angle of the lever";
    let top = frame::header(&mut canvas, LEFT, title, &[], &entries);
    let main_bottom = top + if zoom_range.is_some() { 240.0 } else { 290.0 };
    let main = Frame::over_time(context, main_range, top, main_bottom);
    let zoom = zoom_range
        .map(|range| Frame::over_time(context, range, main_bottom + 16.0, main_bottom + 186.0));
    let last = zoom.unwrap_or(main);
    let height = last.bottom + frame::FOOTER;

    let drawing = Drawing {
        context,
        traces: &traces,
        nominal,
    };
    let label = context.time_label();
    let main_label = if zoom.is_none() { Some(&*label) } else { None };
    drawing.panel(&mut canvas, &main, "angle-clip", main_label, zoom.is_none());
    if let Some(zoom) = &zoom {
        drawing.panel(&mut canvas, zoom, "angle-zoom-clip", Some(&label), true);
        canvas.text(
            "muted halo",
            (RIGHT - 8.0, zoom.top + 18.0),
            Anchor::End,
            if above {
                "around the limit"
            } else {
                "below the limit"
            },
        );
    }
    drawing.marks(&mut canvas, &main, zoom.as_ref());
    frame::footer(&mut canvas, &context.origin, height);

    let result = result_sentence(context);
    Some(Figure {
        name: NAME,
        title: title.into(),
        caption: format!(
            "Positive angles lead away from the stop; the door counts as lost above {}. {result}",
            words::limit(document.threshold_rad)
        ),
        description: format!(
            "Angle of the lever in radians over time, with the limit of {}. {result}",
            words::limit(document.threshold_rad)
        ),
        height,
        body: canvas.into_string(),
    })
}

/// Returns the range of the angle, that of a second panel where one needs it to be seen against
/// the limit, and whether a run exceeds the limit.
fn ranges(context: &PlotContext, traces: &[&Trace]) -> ((f64, f64), Option<(f64, f64)>, bool) {
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
    let main_range = (least - (high - least) * 0.03, high + (high - least) * 0.14);
    let zoom_range = if largest > FAR * threshold {
        Some((least.max(-threshold) - 0.06 * threshold, 1.5 * threshold))
    } else if largest > 0.0 && largest < threshold / FAR {
        let least = least.max(-largest);
        Some((
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
            let stop = words::stop(trace.model);
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

pub(super) fn result_sentence(context: &PlotContext) -> String {
    let Some(run) = &context.document.nominal else {
        return "There is no nominal run.".into();
    };
    let crossing = opening::of_run(context.document, run);
    let crossing = crossing.unwrap_or_else(|| "it stays below the limit angle".into());
    format!(
        "The nominal lever ({}, {}): {}; {crossing}.",
        words::stop(run.model),
        words::opens(run.opens_when),
        words::peak(context.document, run),
    )
}

struct Drawing<'a> {
    context: &'a PlotContext<'a>,
    traces: &'a [&'a Trace],
    nominal: Option<&'a Run>,
}

impl Drawing<'_> {
    fn panel(
        &self,
        canvas: &mut Canvas,
        panel: &Frame,
        clip: &str,
        x_title: Option<&str>,
        impacts: bool,
    ) {
        panel.grid(canvas, x_title, Some("angle φ [rad]"));
        panel.right_scale(canvas, DEGREES_PER_RADIAN, "angle φ [°]");
        panel.level(canvas, "zero", 0.0);
        panel.begin_inside(canvas, clip);
        let scale = self.context.time_scale;
        for (trace, class) in self.traces.iter().zip(trace_classes(self.traces)) {
            let points = thin::columns(
                trace
                    .points
                    .iter()
                    .map(|point| panel.place(point.time_s * scale, point.angle_rad)),
                0.5,
            );
            canvas.polyline(class, points.into_iter());
        }
        canvas.end_group();
        acceleration::judged_window(canvas, self.context, panel);
        if impacts {
            for [at_s, _] in self.nominal.iter().flat_map(|run| &run.impact_list) {
                let value = at_s * scale;
                if panel.x.contains(value) {
                    let x = panel.x.place(value);
                    canvas.line("impact", (x, panel.bottom - 9.0), (x, panel.bottom));
                }
            }
        }
        let threshold = self.context.document.threshold_rad;
        if panel.y.contains(threshold) {
            panel.limit(
                canvas,
                threshold,
                &format!("limit {} rad", exact(threshold)),
            );
        }
        panel.frame(canvas);
    }

    /// Marks peak and first crossing of the nominal run, each in the panel that shows it best.
    fn marks(&self, canvas: &mut Canvas, main: &Frame, zoom: Option<&Frame>) {
        let Some(run) = self.nominal else {
            return;
        };
        let scale = self.context.time_scale;
        let best = |value: f64| zoom.filter(|panel| panel.y.contains(value)).unwrap_or(main);
        if let Some(at_s) = run.first_crossing_s {
            let threshold = self.context.document.threshold_rad;
            let panel = best(threshold);
            let at = panel.place(at_s * scale, threshold);
            canvas.diamond("cross", at, 6.0);
            // Away from the limit's own label at the left, below the line.
            panel.label(
                canvas,
                "alarm halo",
                (at.0, at.1 + 20.0),
                &format!("opens at {}", opening::nominal_instant(at_s)),
            );
        }
        let panel = best(run.peak_angle_rad);
        let at = panel.place(run.peak_time_s * scale, run.peak_angle_rad);
        canvas.circle("mark", at, 4.5);
        panel.label(
            canvas,
            "strong halo",
            (at.0, at.1 - 7.0),
            &format!("peak {}", words::short_peak(self.context.document, run)),
        );
    }
}
