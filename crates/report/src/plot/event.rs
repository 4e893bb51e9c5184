//! Acceleration, velocity and angle on one time axis, zoomed to the event.
//!
//! The drawing knows curves, marks and panels alone: the report of one verdict fills it here, the
//! page of two verdicts in `overlay`.

use super::canvas::{Anchor, Canvas, Point};
use super::error_bar::ErrorBar;
use super::frame::{self, Frame, LEFT, LegendEntry, RIGHT, Sample, Scale};
use super::{Figure, WIDTH, acceleration, angle, origin, time_unit};
use crate::{opening, words};
use latchgate_document::Document;
use latchgate_document::number::exact;
use latchgate_kernel::range::{Range, Window};
use latchgate_kernel::replay::Run;
use latchgate_kernel::units::STANDARD_GRAVITY;
use latchgate_recording::Severity;
use latchgate_verdict::{Answer, SampledSeries, SeriesRun};
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;

pub(super) const NAME: &str = "event";

/// Part of the largest magnitude from which on a sample belongs to the event.
const ACTIVE: f64 = 0.05;

/// How far above the limit angle the panel of the angle reaches, in limit angles.
const REACH: f64 = 4.0;

/// Heights of the three panels, and the gap between two: as wide as a printed page, the drawing leaves room for the
/// rest of page one.
const HEIGHTS: [f64; 3] = [84.0, 60.0, 122.0];
const GAP: f64 = 12.0;

/// An instant or a span that is marked in all panels.
pub(super) struct EventMark {
    span: Window,
    text: String,
    class: &'static str,
}

impl EventMark {
    /// Marks an instant by a line.
    pub(super) fn at(at_s: f64, text: String, class: &'static str) -> Self {
        Self::span(Window::new(at_s, at_s), text, class)
    }

    /// Marks a span by a shade.
    fn span(span: Window, text: String, class: &'static str) -> Self {
        Self { span, text, class }
    }

    /// Marks when a lever opens, if it does: the span of the varied levers, or one instant.
    pub(super) fn opening(document: &Document, name: &str) -> Option<Self> {
        let opens = document.opens.as_ref()?;
        let first_s = opens.first_s?;
        let word = opening::opens_or_may(document.verdict);
        let text = format!("{name}{word} {}", opening::cell(opens));
        Some(match opening::span(opens) {
            Some(span) => Self::span(Window::new(span.start_s, span.end_s), text, "crossing"),
            None => Self::at(first_s, text, "crossing"),
        })
    }

    /// Returns the part of it that is in view.
    pub(super) fn in_view(&self, view: Window) -> Option<Window> {
        let from_s = self.span.from_s.max(view.from_s);
        let until_s = self.span.until_s.min(view.until_s);
        (from_s <= until_s).then_some(Window { from_s, until_s })
    }

    /// Returns where its label is centred [s]: in the middle of the part in view.
    fn middle_s(&self, view: Window) -> f64 {
        let Window { from_s, until_s } = self.in_view(view).unwrap_or(self.span);
        0.5 * (from_s + until_s)
    }
}

/// A curve of a panel.
pub(super) struct EventCurve<'a> {
    /// Class of its line.
    pub(super) class: &'static str,
    /// Name in the legend.
    pub(super) name: String,
    /// Words behind its value where a cursor reads it off.
    pub(super) read: String,
    /// Its column in the page's table of series.
    pub(super) column: usize,
    /// Values at the samples, in the table's unit.
    pub(super) values: &'a [f64],
}

/// A panel: its title, its curves, the factor from the table's unit to the one shown, and its least
/// and largest value in view.
pub(super) struct EventPanel<'a> {
    title: String,
    curves: Vec<EventCurve<'a>>,
    factor: f64,
    range: Range,
}

/// Data of the figure: acceleration, velocity and angle over one time axis.
pub(super) struct EventDrawing<'a> {
    pub(super) title: &'a str,
    /// Samples of all curves [s].
    pub(super) time_s: &'a [f64],
    /// The window shown at first.
    pub(super) view: Window,
    /// The panels; the last is that of the angle.
    pub(super) panels: [EventPanel<'a>; 3],
    /// The limit angle [rad], and how it is named.
    pub(super) limit: (f64, String),
    pub(super) marks: Vec<EventMark>,
    /// The largest angle with its error.
    pub(super) bar: Option<ErrorBar>,
    /// Factor from seconds to the time shown, and its unit.
    pub(super) time_unit: (f64, &'static str),
    /// Identity of the drawing outside its page.
    pub(super) origin: &'a str,
}

/// Draws the figure, and returns with it what a script needs to draw it anew.
pub(crate) fn draw(document: &Document, series: &SampledSeries) -> Option<(Figure, Value)> {
    let (first, last) = (*series.time_s.first()?, *series.time_s.last()?);
    if series.time_s.len() < 2 {
        return None;
    }
    let view = view(document, series);
    let limit = document.threshold_rad;
    // Faulty samples show no event.
    let usable = document.verdict != Answer::Unusable;
    let leading = words::leading_run(document).filter(|_| usable);
    // How far a lever opens that fails may be unknown, and does not matter.
    let leading =
        leading.filter(|run| document.verdict != Answer::Fail || words::has_figure(document, run));
    let bar = leading.and_then(|run| ErrorBar::of_run(document, run));
    let drawing = EventDrawing {
        title: "Acceleration, velocity and angle of the lever",
        time_s: &series.time_s,
        view,
        panels: panels(document, series, view, bar),
        bar,
        limit: (limit, limit_name(limit)),
        marks: marks(document, series, view),
        time_unit: time_unit(Window::new(first, last)),
        origin: &origin(document),
    };
    let sentence = angle::result_sentence(document);
    let caption = caption(document, &drawing.panels);
    let description = format!(
        "Acceleration, its integral and the angle of the lever over time, from {} to {}. {sentence}",
        words::instant(view.from_s),
        words::instant(view.until_s)
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
        if self.bar.is_some() {
            let sample = Sample::Tick("mark error-bar");
            entries.push(LegendEntry::new(sample, "largest angle with its error"));
        }
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

    /// Draws the panels; returns the lower edge of the last, and the geometry of all.
    fn draw_panels(&self, canvas: &mut Canvas, first_top: f64) -> (f64, Vec<Value>) {
        let (scale, unit) = self.time_unit;
        let mut top = first_top;
        let mut drawn = Vec::new();
        let label = format!("time [{unit}]");
        for (index, (panel, height)) in self.panels.iter().zip(HEIGHTS).enumerate() {
            let time = Scale::Linear(self.view.from_s * scale, self.view.until_s * scale);
            let values = Scale::Linear(panel.range.low, panel.range.high);
            let frame = Frame::wide(top, height, time, values);
            let last = index + 1 == self.panels.len();
            frame.grid(canvas, last.then_some(&*label), Some(&panel.title));
            frame.level(canvas, "zero", 0.0);
            frame.begin_inside(canvas, ["event-a", "event-v", "event-phi"][index]);
            if last {
                frame.level(canvas, "limit", self.limit.0);
            }
            for curve in &panel.curves {
                let points = self.time_s.iter().zip(curve.values);
                let points = points.map(|(at, value)| Point::new(at * scale, value * panel.factor));
                frame.function(canvas, curve.class, points);
            }
            if let Some(bar) = self.bar.filter(|_| last) {
                bar.draw(canvas, &frame, panel.range, scale);
            }
            canvas.end_group();
            for mark in &self.marks {
                let Some(Window { from_s, until_s }) = mark.in_view(self.view) else {
                    continue;
                };
                if until_s > from_s {
                    frame.shade(canvas, mark.class, from_s * scale, until_s * scale);
                } else {
                    frame.upright(canvas, mark.class, from_s * scale);
                }
            }
            if last {
                frame.right_scale(canvas, f64::to_degrees(1.0), "angle φ [°]");
            }
            frame.frame(canvas);
            drawn.push(
                json!({"top": top, "bottom": top + height, "title": panel.title,
                "range": panel.range}),
            );
            top += height + GAP;
        }
        (top - GAP, drawn)
    }

    fn draw_labels(&self, canvas: &mut Canvas, rows: &[usize], first_top: f64) {
        let axis = self.axis();
        for (mark, row) in self.marks.iter().zip(rows) {
            let x = axis.place(mark.middle_s(self.view) * self.time_unit.0);
            let y = first_top - 6.0 - 18.0 * *row as f64;
            canvas.line(mark.class, Point::new(x, y + 1.0), Point::new(x, first_top));
            let label_point = Point::new(label_middle(x, &mark.text), y - 2.0);
            canvas.text("muted", label_point, Anchor::Middle, &mark.text);
        }
    }

    fn axis(&self) -> super::axis::Axis {
        let (scale, _) = self.time_unit;
        let Window { from_s, until_s } = self.view;
        super::axis::Axis::linear(from_s * scale, until_s * scale, LEFT, RIGHT)
    }

    /// Returns the row of each mark's label above the panels, such that no two labels overlap.
    fn rows(&self) -> Vec<usize> {
        let axis = self.axis();
        let mut row_ranges: Vec<Vec<Range>> = Vec::new();
        self.marks
            .iter()
            .map(|mark| {
                let mark_x = axis.place(mark.middle_s(self.view) * self.time_unit.0);
                let middle = label_middle(mark_x, &mark.text);
                let half = width(&mark.text) / 2.0 + 6.0;
                let range = Range::new(middle - half, middle + half);
                let free = |row: &Vec<Range>| {
                    row.iter()
                        .all(|other| range.high < other.low || range.low > other.high)
                };
                let row = row_ranges.iter().position(free).unwrap_or(row_ranges.len());
                if row == row_ranges.len() {
                    row_ranges.push(Vec::new());
                }
                row_ranges[row].push(range);
                row
            })
            .collect()
    }

    /// Returns geometry and marks for the script; the numbers themselves are in the series.
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
            .map(|mark| json!({"start": mark.span.from_s, "end": mark.span.until_s, "text": mark.text, "class": mark.class}))
            .collect();
        json!({
            "left": LEFT,
            "right": RIGHT,
            "span": [self.time_s[0], self.time_s[self.time_s.len() - 1]],
            "view": [self.view.from_s, self.view.until_s],
            "scale": self.time_unit.0,
            "unit": self.time_unit.1,
            "limit": self.limit.0,
            "panels": panels,
            "marks": marks,
            "bar": self.bar,
        })
    }
}

fn caption(document: &Document, panels: &[EventPanel<'_>]) -> String {
    // The angle that faulty samples give is shown nowhere.
    let usable = document.verdict != Answer::Unusable;
    let cut = panels.last().filter(|_| usable).is_some_and(|panel| {
        document
            .nominal
            .iter()
            .any(|run| run.peak_angle_rad > panel.range.high)
    });
    let cut = if cut {
        " The curve of the angle leaves its panel; the angles it reaches stand in the appendix."
    } else {
        ""
    };
    format!("Zoomed to the event.{cut}")
}

/// Returns the middle of a mark's label, moved so that the label lies within the drawing.
fn label_middle(x: f64, text: &str) -> f64 {
    let half = width(text) / 2.0;
    x.clamp(LEFT.min(half), WIDTH - half - 4.0).max(half)
}

fn width(text: &str) -> f64 {
    text.chars().count() as f64 * (frame::LETTER - 1.2)
}

fn marks(document: &Document, series: &SampledSeries, view: Window) -> Vec<EventMark> {
    let mut marks = vec![EventMark::at(0.0, "t = 0".into(), "contact")];
    match &document.nominal {
        // Faulty samples show no event.
        _ if document.verdict == Answer::Unusable => {
            marks.extend(bad_span(document, &series.time_s))
        }
        Some(run) => {
            marks.extend(EventMark::opening(document, ""));
            let run = words::leading_run(document).unwrap_or(run);
            let has_figure = words::has_figure(document, run);
            let shown = match has_figure {
                true => Some(format!(
                    "largest angle {}",
                    words::short_peak(document, run)
                )),
                false if document.verdict == Answer::Undecided => {
                    Some("largest angle not known".into())
                }
                false => None,
            };
            if let Some(text) = shown
                && run.peak_angle_rad > 0.0
                && run.peak_angle_rad <= FRAC_PI_2
            {
                marks.push(EventMark::at(run.peak_time_s, text, "peak"));
            }
        }
        None => {}
    }
    marks.retain(|mark| mark.in_view(view).is_some());
    marks
}

/// Marks the samples from the first that a blocking finding declares bad; all, if it names no instant.
fn bad_span(document: &Document, time_s: &[f64]) -> Option<EventMark> {
    let findings = document.findings.iter();
    let blocking = findings.filter(|finding| finding.severity == Severity::Blocking);
    let from = blocking
        .map(|finding| finding.at_s.unwrap_or(f64::NEG_INFINITY))
        .reduce(f64::min)?;
    let (first, last) = (time_s[0], time_s[time_s.len() - 1]);
    let text = if from > first {
        format!("not usable from {}", words::instant(from))
    } else {
        "not usable".into()
    };
    Some(EventMark::span(
        Window::new(from.clamp(first, last), last),
        text,
        "bad",
    ))
}

/// Returns the first sample at which the lever of a run is past 90° [s].
fn past_a_right_angle(series: &SampledSeries, nominal: &Run) -> Option<f64> {
    let mut runs = series.runs.iter();
    let run =
        runs.find(|run| (run.model, run.opens_when) == (nominal.model, nominal.opens_when))?;
    let past = run.angle_rad.iter().position(|angle| *angle > FRAC_PI_2)?;
    Some(series.time_s[past])
}

/// Returns the window in which the pulse acts or the lever moves, with some room.
fn view(document: &Document, series: &SampledSeries) -> Window {
    let (first, last) = (series.time_s[0], series.time_s[series.time_s.len() - 1]);
    let magnitude = |value: &f64| if value.is_finite() { value.abs() } else { 0.0 };
    let largest = series.used_m_s2.iter().map(magnitude).fold(0.0, f64::max);
    let mut span = Range::EMPTY;
    let mut include = |time: f64| {
        if time.is_finite() {
            span = span.including(time);
        }
    };
    for (time, value) in series.time_s.iter().zip(&series.used_m_s2) {
        if magnitude(value) > ACTIVE * largest {
            include(*time);
        }
    }
    for run in [document.nominal.as_ref(), words::leading_run(document)]
        .into_iter()
        .flatten()
    {
        if run.peak_angle_rad > FRAC_PI_2 {
            past_a_right_angle(series, run)
                .into_iter()
                .for_each(&mut include);
        } else if run.peak_angle_rad > 0.0 {
            include(run.peak_time_s);
        }
    }
    if let Some(opens) = &document.opens {
        let instants = [opens.first_s, opens.p05_s, opens.p95_s];
        instants.into_iter().flatten().for_each(&mut include);
    }
    if (first..=last).contains(&0.0) {
        include(0.0);
    }
    with_room(span, Window::new(first, last))
}

/// Returns the window of a span with some room, within the record; the whole record if the span takes
/// most of it.
pub(super) fn with_room(span: Range, record: Window) -> Window {
    let length = span.width();
    if length.is_nan() || length <= 0.0 || length > 0.8 * (record.until_s - record.from_s) {
        return record;
    }
    Window {
        from_s: (span.low - 0.1 * length).max(record.from_s),
        until_s: (span.high + 0.25 * length).min(record.until_s),
    }
}

fn panels<'a>(
    document: &Document,
    series: &'a SampledSeries,
    view: Window,
    bar: Option<ErrorBar>,
) -> [EventPanel<'a>; 3] {
    let side = match &document.nominal {
        Some(run) if document.polarities.len() < 2 => format!(", {}", words::opens(run.opens_when)),
        _ => String::new(),
    };
    let acceleration = vec![
        EventCurve {
            class: "raw",
            name: format!("as recorded{side}"),
            read: "recorded".into(),
            column: 1,
            values: &series.recorded_m_s2,
        },
        EventCurve {
            class: "used",
            name: acceleration::used_text(document),
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
    let ordered = crate::series::ordered(series);
    let classes = angle::classes(ordered.iter().map(|run| (run.model, run.opens_when)));
    // Angle and angular velocity alternate from the fifth column on.
    let columns = (4..).step_by(2);
    let angles = ordered.iter().zip(classes).zip(columns);
    let angles = angles
        .map(|((run, class), column)| EventCurve {
            class,
            name: run_name(document, run),
            read: run_name(document, run),
            column,
            values: &run.angle_rad,
        })
        .collect();
    let limit = document.threshold_rad;
    let shown = (&*series.time_s, view);
    let in_g = 1.0 / STANDARD_GRAVITY;
    [
        EventPanel::new("a [g]".into(), acceleration, in_g, shown, None),
        EventPanel::new("v [m/s]".into(), velocity, 1.0, shown, None),
        EventPanel::new("angle φ [rad]".into(), angles, 1.0, shown, Some(limit))
            .reaching(bar.map_or(0.0, |bar| bar.high), limit),
    ]
}

impl<'a> EventPanel<'a> {
    /// Shows the end of an error bar [rad] as well, at most a few times the limit angle.
    fn reaching(mut self, high_rad: f64, limit_rad: f64) -> Self {
        let room = 0.06 * (self.range.high - self.range.low);
        self.range.high = self.range.high.max(high_rad.min(REACH * limit_rad) + room);
        self
    }

    /// Shows the least and largest value in view, zero included; of the angle at most a few times
    /// the limit angle, which is included.
    pub(super) fn new(
        title: String,
        curves: Vec<EventCurve<'a>>,
        factor: f64,
        (time_s, view): (&[f64], Window),
        limit: Option<f64>,
    ) -> Self {
        let values_in_view = curves
            .iter()
            .flat_map(|curve| time_s.iter().zip(curve.values));
        let values_in_view = values_in_view
            .filter(|(time, _)| (view.from_s..=view.until_s).contains(*time))
            .map(|(_, value)| value * factor);
        let Range { mut low, mut high } = frame::extent(values_in_view).including(0.0);
        if let Some(limit) = limit {
            high = high.clamp(1.2 * limit, REACH * limit);
            low = low.max(-0.5 * limit);
        }
        let room = 0.06 * (high - low).max(1e-9);
        Self {
            title,
            curves,
            factor,
            range: Range::new(low - room, high + room),
        }
    }
}

fn run_name(document: &Document, run: &SeriesRun) -> String {
    if document.polarities.len() > 1 {
        format!("{}, {}", run.model.label(), words::opens(run.opens_when))
    } else {
        run.model.label().into()
    }
}

pub(super) fn limit_name(limit: f64) -> String {
    format!("limit angle {}\u{00A0}rad", exact(limit))
}
