//! Acceleration, velocity and angle on one time axis, zoomed to the event.
//!
//! The drawing knows curves, marks and panels alone: the report of one verdict fills it here, the
//! page of two verdicts in `overlay`.

use super::canvas::{Anchor, Canvas};
use super::frame::{self, Frame, LEFT, LegendEntry, RIGHT, Scale};
use super::{Figure, PlotContext, WIDTH, acceleration, angle};
use crate::words;
use latchgate_document::number::exact;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_verdict::SeriesRun;
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
pub(super) struct EventMark {
    pub(super) at_s: f64,
    pub(super) text: String,
    pub(super) class: &'static str,
}

/// A curve of a panel: its class, its name, what stands behind its value where a cursor reads it off, its column in the page's table of series, its values at
/// the samples in the table's unit.
pub(super) struct EventCurve<'a> {
    pub(super) class: &'static str,
    pub(super) name: String,
    pub(super) read: String,
    pub(super) column: usize,
    pub(super) values: &'a [f64],
}

/// A panel: its title, its curves, the factor from the table's unit to the one shown, and its least
/// and largest value in view.
pub(super) struct EventPanel<'a> {
    title: String,
    curves: Vec<EventCurve<'a>>,
    factor: f64,
    range: (f64, f64),
}

/// Acceleration, velocity and angle over one time axis.
pub(super) struct EventDrawing<'a> {
    pub(super) title: &'a str,
    /// Samples of all curves [s].
    pub(super) time_s: &'a [f64],
    /// What is shown at first [s].
    pub(super) view: (f64, f64),
    /// The panels; the last is that of the angle.
    pub(super) panels: [EventPanel<'a>; 3],
    /// The limit angle [rad], and how it is named.
    pub(super) limit: (f64, String),
    pub(super) marks: Vec<EventMark>,
    /// Factor from seconds to the time shown, and its unit.
    pub(super) time_unit: (f64, &'static str),
    /// What identifies the drawing away from its page.
    pub(super) origin: &'a str,
}

/// Draws the figure, and returns with it what a script needs to draw it anew.
pub(super) fn draw(context: &PlotContext) -> Option<(Figure, Value)> {
    let series = &context.evidence.series;
    if series.time_s.len() < 2 {
        return None;
    }
    let view = view(context);
    let drawing = EventDrawing {
        title: "Acceleration, velocity and angle of the lever",
        time_s: &series.time_s,
        view,
        panels: panels(context, view),
        limit: (
            context.document.threshold_rad,
            limit_name(context.document.threshold_rad),
        ),
        marks: marks(context, view),
        time_unit: (context.time_scale, context.time_unit),
        origin: &context.origin,
    };
    let sentence = angle::result_sentence(context);
    let caption = caption(context, &drawing.panels);
    let description = format!(
        "Acceleration, its integral and the angle of the lever over time, from {} to {}. {sentence}",
        words::instant(view.0),
        words::instant(view.1)
    );
    Some(drawing.draw(caption, description))
}

impl EventDrawing<'_> {
    /// Draws the figure, and returns with it what a script needs to draw it anew.
    pub(super) fn draw(&self, caption: String, description: String) -> (Figure, Value) {
        let mut canvas = Canvas::with_capacity(96 * 1024);
        let curves = self.panels.iter().flat_map(|panel| &panel.curves);
        let mut entries: Vec<LegendEntry> = curves
            .map(|curve| LegendEntry::line(curve.class, curve.name.clone()))
            .collect();
        entries.push(LegendEntry::line("limit", self.limit.1.clone()));
        canvas.begin_group("legend");
        let head = frame::header(&mut canvas, LEFT, self.title, &[], &entries);
        canvas.end_group();
        canvas.begin_group("drawn");
        let rows = self.rows();
        let lines = rows.iter().copied().max().map_or(0, |row| row + 1);
        let first_top = head + 8.0 + 18.0 * lines as f64;
        let (bottom, drawn) = self.draw_panels(&mut canvas, first_top);
        self.draw_labels(&mut canvas, &rows, first_top);
        canvas.end_group();
        let height = bottom + frame::FOOTER;
        frame::footer(&mut canvas, self.origin, height);
        let figure = Figure {
            name: NAME,
            title: self.title.into(),
            caption,
            description,
            height,
            body: canvas.into_string(),
        };
        (figure, self.script_data(drawn))
    }

    /// Returns where the last panel ends, and the places of all.
    fn draw_panels(&self, canvas: &mut Canvas, first_top: f64) -> (f64, Vec<Value>) {
        let (scale, unit) = self.time_unit;
        let mut top = first_top;
        let mut drawn = Vec::new();
        let label = format!("time [{unit}]");
        for (index, (panel, height)) in self.panels.iter().zip(HEIGHTS).enumerate() {
            let time = Scale::Linear(self.view.0 * scale, self.view.1 * scale);
            let place = Frame::wide(
                (top, top + height),
                time,
                Scale::Linear(panel.range.0, panel.range.1),
            );
            let last = index + 1 == self.panels.len();
            place.grid(canvas, last.then_some(&*label), Some(&panel.title));
            place.level(canvas, "zero", 0.0);
            place.begin_inside(canvas, ["event-a", "event-v", "event-phi"][index]);
            if last {
                place.level(canvas, "limit", self.limit.0);
            }
            for curve in &panel.curves {
                let points = self.time_s.iter().zip(curve.values);
                let points = points.map(|(at, value)| (at * scale, value * panel.factor));
                place.function(canvas, curve.class, points);
            }
            canvas.end_group();
            for mark in &self.marks {
                place.upright(canvas, mark.class, mark.at_s * scale);
            }
            if last {
                place.right_scale(canvas, f64::to_degrees(1.0), "angle φ [°]");
            }
            place.frame(canvas);
            drawn.push(
                json!({"top": top, "bottom": top + height, "title": panel.title,
                "range": [panel.range.0, panel.range.1]}),
            );
            top += height + GAP;
        }
        (top - GAP, drawn)
    }

    fn draw_labels(&self, canvas: &mut Canvas, rows: &[usize], first_top: f64) {
        let axis = self.axis();
        for (mark, row) in self.marks.iter().zip(rows) {
            let x = axis.place(mark.at_s * self.time_unit.0);
            let y = first_top - 6.0 - 18.0 * *row as f64;
            canvas.line(mark.class, (x, y + 1.0), (x, first_top));
            canvas.text(
                "muted",
                (held(x, &mark.text), y - 2.0),
                Anchor::Middle,
                &mark.text,
            );
        }
    }

    fn axis(&self) -> super::axis::Axis {
        let (scale, _) = self.time_unit;
        super::axis::Axis::linear(self.view.0 * scale, self.view.1 * scale, LEFT, RIGHT)
    }

    /// Returns the row above the panels in which each mark's label stands, so that none meets another.
    fn rows(&self) -> Vec<usize> {
        let axis = self.axis();
        let mut taken: Vec<Vec<(f64, f64)>> = Vec::new();
        self.marks
            .iter()
            .map(|mark| {
                let middle = held(axis.place(mark.at_s * self.time_unit.0), &mark.text);
                let half = width(&mark.text) / 2.0 + 6.0;
                let own = (middle - half, middle + half);
                let free = |row: &Vec<(f64, f64)>| {
                    row.iter().all(|other| own.1 < other.0 || own.0 > other.1)
                };
                let row = taken.iter().position(free).unwrap_or(taken.len());
                if row == taken.len() {
                    taken.push(Vec::new());
                }
                taken[row].push(own);
                row
            })
            .collect()
    }

    /// Returns geometry and marks; the numbers themselves stand in the series.
    fn script_data(&self, drawn: Vec<Value>) -> Value {
        let places = drawn.into_iter().zip(&self.panels);
        let panels: Vec<Value> = places
            .map(|(mut place, panel)| {
                let curves: Vec<Value> = panel
                    .curves
                    .iter()
                    .map(|curve| {
                        json!({
                            "column": curve.column, "class": curve.class,
                            "name": curve.name, "read": curve.read,
                        })
                    })
                    .collect();
                place["curves"] = json!(curves);
                place["factor"] = json!(panel.factor);
                place
            })
            .collect();
        let marks: Vec<Value> = self
            .marks
            .iter()
            .map(|mark| json!({"at": mark.at_s, "text": mark.text, "class": mark.class}))
            .collect();
        json!({
            "left": LEFT,
            "right": RIGHT,
            "span": [self.time_s[0], self.time_s[self.time_s.len() - 1]],
            "view": [self.view.0, self.view.1],
            "scale": self.time_unit.0,
            "unit": self.time_unit.1,
            "limit": self.limit.0,
            "panels": panels,
            "marks": marks,
        })
    }
}

fn caption(context: &PlotContext, panels: &[EventPanel<'_>]) -> String {
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
        Some(run) if words::has_figure(context.document, run) => {
            let peak = words::short_peak(context.document, run);
            let at = words::brief_time(run.peak_time_s);
            marks.push(EventMark {
                at_s: run.peak_time_s,
                text: format!("largest angle {peak} at {at}"),
                class: "peak",
            });
        }
        _ => {}
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

fn panels<'a>(context: &PlotContext<'a>, view: (f64, f64)) -> [EventPanel<'a>; 3] {
    let series = &context.evidence.series;
    let acceleration = vec![
        EventCurve {
            class: "raw",
            name: "as recorded".into(),
            read: "recorded".into(),
            column: 1,
            values: &series.recorded_m_s2,
        },
        EventCurve {
            class: "used",
            name: acceleration::used_text(context),
            read: "used".into(),
            column: 2,
            values: &series.used_m_s2,
        },
    ];
    let velocity = vec![EventCurve {
        class: "velocity",
        name: "velocity ∫a dt".into(),
        read: String::new(),
        column: 3,
        values: &series.velocity_m_s,
    }];
    let classes = angle::classes(series.runs.iter().map(|run| (run.model, run.opens_when)));
    // The angular velocity follows the angle.
    let columns = (4..).step_by(2);
    let angles = series.runs.iter().zip(classes).zip(columns);
    let angles = angles
        .map(|((run, class), column)| EventCurve {
            class,
            name: run_name(context, run),
            read: run_name(context, run),
            column,
            values: &run.angle_rad,
        })
        .collect();
    let side = match &context.document.nominal {
        Some(run) if context.document.polarities.len() < 2 => match run.opens_when {
            latchgate_kernel::units::OpensWhen::Negative => ", − opens",
            latchgate_kernel::units::OpensWhen::Positive => ", + opens",
        },
        _ => "",
    };
    let limit = context.document.threshold_rad;
    let shown = (&*series.time_s, view);
    let in_g = 1.0 / STANDARD_GRAVITY;
    [
        EventPanel::new(format!("a [g]{side}"), acceleration, in_g, shown, None),
        EventPanel::new("velocity [m/s]".into(), velocity, 1.0, shown, None),
        EventPanel::new("angle φ [rad]".into(), angles, 1.0, shown, Some(limit)),
    ]
}

impl<'a> EventPanel<'a> {
    /// Shows the least and largest value in view, zero included; of the angle at most a few times
    /// the limit angle, which is included.
    pub(super) fn new(
        title: String,
        curves: Vec<EventCurve<'a>>,
        factor: f64,
        (time_s, view): (&[f64], (f64, f64)),
        limit: Option<f64>,
    ) -> Self {
        let seen = curves
            .iter()
            .flat_map(|curve| time_s.iter().zip(curve.values));
        let seen = seen
            .filter(|(at, _)| (view.0..=view.1).contains(*at))
            .map(|(_, value)| value * factor);
        let (low, high) = frame::extent(seen);
        let (mut low, mut high) = (low.min(0.0), high.max(0.0));
        if let Some(limit) = limit {
            high = high.clamp(1.2 * limit, REACH * limit);
            low = low.max(-0.5 * limit);
        }
        let room = 0.06 * (high - low).max(1e-9);
        Self {
            title,
            curves,
            factor,
            range: (low - room, high + room),
        }
    }
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

pub(super) fn limit_name(limit: f64) -> String {
    format!("limit angle {}\u{00A0}rad", exact(limit))
}
