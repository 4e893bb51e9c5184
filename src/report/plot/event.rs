//! Acceleration, velocity and angle on one time axis, zoomed to the event.

use super::canvas::{Anchor, Canvas};
use super::frame::{self, Frame, LEFT, LegendEntry, RIGHT, Scale};
use super::{Figure, PlotContext, WIDTH, acceleration, angle};
use crate::report::number::exact;
use crate::report::words;
use crate::units::STANDARD_GRAVITY;
use crate::verdict::SeriesRun;
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;

pub(super) const NAME: &str = "event";

/// Part of the largest magnitude from which on a sample belongs to the event.
const ACTIVE: f64 = 0.05;

/// How far above the limit angle the panel of the angle reaches, in limit angles.
const REACH: f64 = 4.0;

/// Heights of the three panels, and the gap between two.
const HEIGHTS: [f64; 3] = [150.0, 110.0, 190.0];
const GAP: f64 = 16.0;

/// An instant that is marked in all panels.
struct EventMark {
    at_s: f64,
    text: String,
    class: &'static str,
}

/// A curve of a panel: its class, its name, its values at the samples, in the panel's unit.
struct EventCurve {
    class: &'static str,
    name: String,
    values: Vec<f64>,
}

/// A panel: its title, its least and largest value in view, its curves.
struct EventPanel {
    title: String,
    range: (f64, f64),
    curves: Vec<EventCurve>,
}

/// Draws the figure, and returns with it what a script needs to draw it anew.
pub(super) fn draw(context: &PlotContext) -> Option<(Figure, Value)> {
    let series = &context.evidence.series;
    if series.time_s.len() < 2 {
        return None;
    }
    let view = view(context);
    let panels = panels(context, view);
    let marks = marks(context, view);
    let mut canvas = Canvas::with_capacity(96 * 1024);
    let entries: Vec<LegendEntry> = panels
        .iter()
        .flat_map(|panel| &panel.curves)
        .map(|curve| LegendEntry::line(curve.class, curve.name.clone()))
        .chain([LegendEntry::line("limit", limit_name(context))])
        .collect();
    let title = "Acceleration, velocity and angle of the lever";
    canvas.begin_group("legend");
    let head = frame::header(&mut canvas, LEFT, title, &[], &entries);
    canvas.end_group();
    canvas.begin_group("drawn");
    let rows = rows(&marks, context, view);
    let lines = rows.iter().copied().max().map_or(0, |row| row + 1);
    let mut top = head + 8.0 + 18.0 * lines as f64;
    let first_top = top;
    let mut drawn = Vec::new();
    let unit_view = (view.0 * context.time_scale, view.1 * context.time_scale);
    let label = context.time_label();
    for (index, (panel, height)) in panels.iter().zip(HEIGHTS).enumerate() {
        let time = Scale::Linear(unit_view.0, unit_view.1);
        let place = Frame::wide(
            (top, top + height),
            time,
            Scale::Linear(panel.range.0, panel.range.1),
        );
        let last = index + 1 == panels.len();
        place.grid(&mut canvas, last.then_some(&*label), Some(&panel.title));
        place.level(&mut canvas, "zero", 0.0);
        place.begin_inside(&mut canvas, ["event-a", "event-v", "event-phi"][index]);
        if last {
            place.level(&mut canvas, "limit", context.document.threshold_rad);
        }
        for curve in &panel.curves {
            place.function(&mut canvas, curve.class, points(context, curve));
        }
        canvas.end_group();
        for mark in &marks {
            place.upright(&mut canvas, mark.class, mark.at_s * context.time_scale);
        }
        if last {
            place.right_scale(&mut canvas, f64::to_degrees(1.0), "angle φ [°]");
        }
        place.frame(&mut canvas);
        drawn.push(
            json!({"top": top, "bottom": top + height, "title": panel.title,
            "range": [panel.range.0, panel.range.1]}),
        );
        top += height + GAP;
    }
    let bottom = top - GAP;
    let axis = super::axis::Axis::linear(unit_view.0, unit_view.1, LEFT, RIGHT);
    for (mark, row) in marks.iter().zip(&rows) {
        let x = axis.place(mark.at_s * context.time_scale);
        let y = first_top - 6.0 - 18.0 * *row as f64;
        canvas.line(mark.class, (x, y + 1.0), (x, first_top));
        canvas.text(
            "muted",
            (held(x, &mark.text), y - 2.0),
            Anchor::Middle,
            &mark.text,
        );
    }
    canvas.end_group();
    let height = bottom + frame::FOOTER;
    frame::footer(&mut canvas, context, height);
    let sentence = angle::result_sentence(context);
    let figure = Figure {
        name: NAME,
        title: title.into(),
        caption: caption(context, &panels),
        description: format!(
            "Acceleration, its integral and the angle of the lever over time, from {} to {}. {sentence}",
            words::instant(view.0),
            words::instant(view.1)
        ),
        height,
        body: canvas.into_string(),
    };
    Some((figure, script_data(context, view, &panels, drawn, &marks)))
}

fn caption(context: &PlotContext, panels: &[EventPanel]) -> String {
    let cut = panels.last().is_some_and(|panel| {
        context
            .document
            .nominal
            .iter()
            .any(|run| run.peak_angle_rad > panel.range.1)
    });
    let cut = if cut {
        " The curve of the angle leaves its panel; the angles it reaches stand in the appendix."
    } else {
        ""
    };
    format!("Zoomed to the event.{cut}")
}

/// Returns where a label of a mark stands so that it ends within the drawing.
fn held(x: f64, text: &str) -> f64 {
    let half = width(text) / 2.0;
    x.clamp(LEFT.min(half), WIDTH - half - 4.0).max(half)
}

fn width(text: &str) -> f64 {
    text.chars().count() as f64 * (frame::LETTER - 1.2)
}

/// Returns the row above the panels in which each mark's label stands, so that none meets another.
fn rows(marks: &[EventMark], context: &PlotContext, view: (f64, f64)) -> Vec<usize> {
    let scale = context.time_scale;
    let axis = super::axis::Axis::linear(view.0 * scale, view.1 * scale, LEFT, RIGHT);
    let mut taken: Vec<Vec<(f64, f64)>> = Vec::new();
    marks
        .iter()
        .map(|mark| {
            let middle = held(axis.place(mark.at_s * scale), &mark.text);
            let half = width(&mark.text) / 2.0 + 6.0;
            let own = (middle - half, middle + half);
            let free =
                |row: &Vec<(f64, f64)>| row.iter().all(|other| own.1 < other.0 || own.0 > other.1);
            let row = taken.iter().position(free).unwrap_or(taken.len());
            if row == taken.len() {
                taken.push(Vec::new());
            }
            taken[row].push(own);
            row
        })
        .collect()
}

fn marks(context: &PlotContext, view: (f64, f64)) -> Vec<EventMark> {
    let run = context.document.nominal.as_ref();
    let mut marks = vec![EventMark {
        at_s: 0.0,
        text: "first contact".into(),
        class: "contact",
    }];
    if let Some(at_s) = run.and_then(|run| run.first_crossing_s) {
        marks.push(EventMark {
            at_s,
            text: format!("opens at {}", words::brief_time(at_s)),
            class: "crossing",
        });
    }
    match run.filter(|run| run.peak_angle_rad > 0.0) {
        Some(run) if run.peak_angle_rad > FRAC_PI_2 => {
            marks.extend(past_a_right_angle(context).map(|at_s| EventMark {
                at_s,
                text: format!("> 90° from {}", words::brief_time(at_s)),
                class: "peak",
            }));
        }
        Some(run) => {
            let peak = words::short_peak(context.document, run);
            let at = words::brief_time(run.peak_time_s);
            marks.push(EventMark {
                at_s: run.peak_time_s,
                text: format!("largest angle {peak} at {at}"),
                class: "peak",
            });
        }
        None => {}
    }
    marks.retain(|mark| (view.0..=view.1).contains(&mark.at_s));
    marks
}

/// Returns the first sample at which the nominal lever is past 90° [s]; the first trajectory is its.
fn past_a_right_angle(context: &PlotContext) -> Option<f64> {
    let series = &context.evidence.series;
    let run = series.runs.first()?;
    let past = run.angle_rad.iter().position(|angle| *angle > FRAC_PI_2)?;
    Some(series.time_s[past])
}

/// Returns the stretch of time in which acceleration or lever are at work, with some room [s].
fn view(context: &PlotContext) -> (f64, f64) {
    let series = &context.evidence.series;
    let (first, last) = (series.time_s[0], series.time_s[series.time_s.len() - 1]);
    let magnitude = |value: &f64| if value.is_finite() { value.abs() } else { 0.0 };
    let largest = series.used_m_s2.iter().map(magnitude).fold(0.0, f64::max);
    let mut span = (f64::INFINITY, f64::NEG_INFINITY);
    let mut include = |time: f64| {
        if time.is_finite() {
            span = (span.0.min(time), span.1.max(time));
        }
    };
    for (time, value) in series.time_s.iter().zip(&series.used_m_s2) {
        if magnitude(value) > ACTIVE * largest {
            include(*time);
        }
    }
    if let Some(run) = &context.document.nominal {
        if run.peak_angle_rad > FRAC_PI_2 {
            past_a_right_angle(context)
                .into_iter()
                .for_each(&mut include);
        } else if run.peak_angle_rad > 0.0 {
            include(run.peak_time_s);
        }
        run.first_crossing_s.into_iter().for_each(&mut include);
    }
    if (first..=last).contains(&0.0) {
        include(0.0);
    }
    let length = span.1 - span.0;
    if length.is_nan() || length <= 0.0 || length > 0.8 * (last - first) {
        return (first, last);
    }
    (
        (span.0 - 0.1 * length).max(first),
        (span.1 + 0.25 * length).min(last),
    )
}

fn panels(context: &PlotContext, view: (f64, f64)) -> [EventPanel; 3] {
    let series = &context.evidence.series;
    let in_g = |values: &[f64]| {
        values
            .iter()
            .map(|value| value / STANDARD_GRAVITY)
            .collect()
    };
    let acceleration = vec![
        EventCurve {
            class: "raw",
            name: "as recorded".into(),
            values: in_g(&series.recorded_m_s2),
        },
        EventCurve {
            class: "used",
            name: acceleration::used_text(context),
            values: in_g(&series.used_m_s2),
        },
    ];
    let velocity = vec![EventCurve {
        class: "velocity",
        name: "velocity ∫a dt".into(),
        values: series.velocity_m_s.clone(),
    }];
    let angles = series
        .runs
        .iter()
        .zip(angle::classes(
            series.runs.iter().map(|run| (run.model, run.opens_when)),
        ))
        .map(|(run, class)| EventCurve {
            class,
            name: run_name(context, run),
            values: run.angle_rad.clone(),
        })
        .collect();
    let side = match &context.document.nominal {
        Some(run) if context.document.polarities.len() < 2 => match run.opens_when {
            crate::units::OpensWhen::Negative => ", − opens",
            crate::units::OpensWhen::Positive => ", + opens",
        },
        _ => "",
    };
    let panel = |title: String, curves: Vec<EventCurve>, reach: Option<f64>| EventPanel {
        range: range(context, &curves, view, reach),
        title,
        curves,
    };
    let limit = context.document.threshold_rad;
    [
        panel(format!("a [g]{side}"), acceleration, None),
        panel("velocity [m/s]".into(), velocity, None),
        panel("angle φ [rad]".into(), angles, Some(limit)),
    ]
}

fn run_name(context: &PlotContext, run: &SeriesRun) -> String {
    if context.document.polarities.len() > 1 {
        format!(
            "{}, {}",
            words::stop(run.model),
            words::opens(run.opens_when)
        )
    } else {
        words::stop(run.model).into()
    }
}

fn limit_name(context: &PlotContext) -> String {
    format!(
        "limit angle {}\u{00A0}rad",
        exact(context.document.threshold_rad)
    )
}

/// Returns the least and largest value in view, zero included; of the angle at most a few times
/// the limit angle, which is included.
fn range(
    context: &PlotContext,
    curves: &[EventCurve],
    view: (f64, f64),
    limit: Option<f64>,
) -> (f64, f64) {
    let time = &context.evidence.series.time_s;
    let seen = curves
        .iter()
        .flat_map(|curve| time.iter().zip(&curve.values));
    let seen = seen
        .filter(|(at, _)| (view.0..=view.1).contains(*at))
        .map(|(_, value)| *value);
    let (low, high) = frame::extent(seen);
    let (mut low, mut high) = (low.min(0.0), high.max(0.0));
    if let Some(limit) = limit {
        high = high.clamp(1.2 * limit, REACH * limit);
        low = low.max(-0.5 * limit);
    }
    let room = 0.06 * (high - low).max(1e-9);
    (low - room, high + room)
}

/// Returns the points of a curve in the unit of time shown.
fn points<'a>(
    context: &'a PlotContext,
    curve: &'a EventCurve,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let time = context.evidence.series.time_s.iter();
    let scale = context.time_scale;
    time.zip(&curve.values)
        .map(move |(at, value)| (at * scale, *value))
}

/// Returns geometry and marks; the numbers themselves stand in the series.
fn script_data(
    context: &PlotContext,
    view: (f64, f64),
    panels: &[EventPanel],
    drawn: Vec<Value>,
    marks: &[EventMark],
) -> Value {
    let time = &context.evidence.series.time_s;
    let mut column = 1;
    let drawn: Vec<Value> = drawn
        .into_iter()
        .zip(panels)
        .enumerate()
        .map(|(index, (mut place, panel))| {
            let curves: Vec<Value> = panel
                .curves
                .iter()
                .map(|curve| {
                    let own = column;
                    // The angular velocity follows the angle.
                    column += if index == 2 { 2 } else { 1 };
                    json!({"column": own, "class": curve.class, "name": curve.name})
                })
                .collect();
            place["curves"] = json!(curves);
            place["factor"] = json!(if index == 0 {
                1.0 / STANDARD_GRAVITY
            } else {
                1.0
            });
            place
        })
        .collect();
    json!({
        "left": LEFT,
        "right": RIGHT,
        "span": [time[0], time[time.len() - 1]],
        "view": [view.0, view.1],
        "scale": context.time_scale,
        "unit": context.time_unit,
        "limit": context.document.threshold_rad,
        "panels": drawn,
        "marks": marks.iter().map(|mark| json!({"at": mark.at_s, "text": mark.text, "class": mark.class})).collect::<Vec<_>>(),
    })
}
