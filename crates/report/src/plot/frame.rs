//! The frame of a chart: axes, grid and scales of a panel, and the chart's header and footer.

pub use super::axis::Scale;
use super::axis::{At, Axis};
use super::canvas::{Anchor, Canvas, Point, Rectangle, Shape};
use super::raster::{self, Rgb};
use super::{WIDTH, thin};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;

/// Left and right edge of every panel across the drawing, so that time axes of all plots stand
/// under one another.
pub const LEFT: f64 = 78.0;
/// Right end of the panels.
pub const RIGHT: f64 = WIDTH - 92.0;

/// Assumed width of a letter [units]; that of a wide font, so that labels do not touch.
pub const LETTER: f64 = 8.6;

/// Sizes and distances of the lettering around a panel [units].
#[derive(Debug)]
pub struct Lettering {
    /// Least distance of ticks on the axis below.
    spacing_x: f64,
    /// Least distance of ticks on the axis at the left.
    spacing_y: f64,
    /// Least distance of ticks on a second scale at the right.
    spacing_right: f64,
    /// Length of a tick's stroke.
    tick: f64,
    /// Class of tick labels.
    class: &'static str,
    /// Distance of the tick labels' baseline below the panel.
    label_below: f64,
    /// Distance of tick labels beside the panel.
    label_beside: f64,
    /// Distance of the baseline of a label beside the panel below its tick, which centres it there.
    label_drop: f64,
    /// Distance of the title's baseline below the panel.
    title_below: f64,
    /// Distance of the title left of the panel.
    title_left: f64,
    /// True if a logarithmic axis has lines within its decades; among points they would hide them.
    minor: bool,
}

/// Lettering of a panel across the drawing.
pub static WIDE: Lettering = Lettering {
    spacing_x: 95.0,
    spacing_y: 46.0,
    spacing_right: 56.0,
    tick: 5.0,
    class: "muted",
    label_below: 20.0,
    label_beside: 9.0,
    label_drop: 5.0,
    title_below: 42.0,
    title_left: 61.0,
    minor: true,
};

/// Lettering of one of several panels.
pub static NARROW: Lettering = Lettering {
    spacing_x: 80.0,
    spacing_y: 38.0,
    spacing_right: 46.0,
    tick: 4.0,
    class: "muted small",
    label_below: 18.0,
    label_beside: 8.0,
    label_drop: 4.0,
    title_below: 37.0,
    title_left: 54.0,
    minor: false,
};

/// Lettering of a panel of points, whose labels are read from afar.
pub static OPEN: Lettering = Lettering {
    spacing_x: 80.0,
    spacing_y: 40.0,
    spacing_right: 46.0,
    tick: 0.0,
    class: "muted",
    label_below: 19.0,
    label_beside: 7.0,
    label_drop: 5.0,
    title_below: 40.0,
    title_left: 54.0,
    minor: false,
};

/// A panel with its two axes.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Left edge.
    pub left: f64,
    /// Right edge.
    pub right: f64,
    /// Upper edge.
    pub top: f64,
    /// Lower edge.
    pub bottom: f64,
    /// Axis from left to right.
    pub x: Axis,
    /// Axis from bottom to top.
    pub y: Axis,
    lettering: &'static Lettering,
}

impl Frame {
    /// Lays a panel on a rectangle of the drawing.
    pub fn new(lettering: &'static Lettering, area: Rectangle, x: Scale, y: Scale) -> Self {
        let Rectangle { left, top, .. } = area;
        let (right, bottom) = (left + area.width, top + area.height);
        Self {
            left,
            right,
            top,
            bottom,
            x: Axis::new(x, left, right),
            y: Axis::new(y, bottom, top),
            lettering,
        }
    }

    /// Lays a panel of a height across the drawing.
    pub fn wide(top: f64, height: f64, x: Scale, y: Scale) -> Self {
        let area = Rectangle {
            left: LEFT,
            top,
            width: RIGHT - LEFT,
            height,
        };
        Self::new(&WIDE, area, x, y)
    }

    /// Returns the point of a pair of values.
    pub fn place(&self, values: Point) -> Point {
        Point::new(self.x.place(values.x), self.y.place(values.y))
    }

    /// Returns the point of a place in the panel.
    pub fn at(&self, (x, y): (At, At)) -> Point {
        let along = |axis: &Axis, at: At| match at {
            At::Value(value, further) => axis.place(value) + further,
            At::Low(further) => axis.place(axis.low()) + further,
            At::High(further) => axis.place(axis.high()) + further,
        };
        Point::new(along(&self.x, x), along(&self.y, y))
    }

    /// Returns the points of pairs of values.
    pub fn placed(&self, points: &[Point]) -> Vec<Point> {
        points.iter().map(|values| self.place(*values)).collect()
    }

    /// Returns the rectangle between two places.
    pub fn rectangle(&self, from: (At, At), to: (At, At)) -> Rectangle {
        let (from, to) = (self.at(from), self.at(to));
        Rectangle {
            left: from.x.min(to.x),
            top: from.y.min(to.y),
            width: (to.x - from.x).abs(),
            height: (to.y - from.y).abs(),
        }
    }

    /// Returns the rectangle of the panel.
    pub fn area(&self) -> Rectangle {
        Rectangle {
            left: self.left,
            top: self.top,
            width: self.right - self.left,
            height: self.bottom - self.top,
        }
    }

    /// Writes the panel's own title above it.
    pub fn title(&self, canvas: &mut Canvas, text: &str) {
        let title_point = Point::new(self.left, self.top - 9.0);
        canvas.text("strong", title_point, Anchor::Start, text);
    }

    /// Draws grid, ticks, tick labels and titles of the axes; the frame comes after the curves.
    /// A panel that shares its axis with one below it has no `x_title` and no labels there.
    pub fn grid(&self, canvas: &mut Canvas, x_title: Option<&str>, y_title: Option<&str>) {
        let lettering = self.lettering;
        for tick in self.x.ticks(lettering.spacing_x, LETTER) {
            let x = self.x.place(tick.value);
            let (top, bottom) = (Point::new(x, self.top), Point::new(x, self.bottom));
            if !self.grid_line(canvas, &tick.label, top, bottom) {
                continue;
            }
            if x_title.is_some() {
                self.tick(canvas, bottom, 0.0, 1.0);
                let label_point = Point::new(x, self.bottom + lettering.label_below);
                canvas.text(lettering.class, label_point, Anchor::Middle, &tick.label);
            }
        }
        for tick in self.y.ticks(lettering.spacing_y, 0.0) {
            let y = self.y.place(tick.value);
            let (left, right) = (Point::new(self.left, y), Point::new(self.right, y));
            if self.grid_line(canvas, &tick.label, left, right) {
                let outside = Point::new(self.left - lettering.tick, y);
                self.tick(canvas, outside, 1.0, 0.0);
                let label_x = self.left - lettering.label_beside;
                let label_point = Point::new(label_x, y + lettering.label_drop);
                canvas.text(lettering.class, label_point, Anchor::End, &tick.label);
            }
        }
        if let Some(text) = y_title {
            let middle = f64::midpoint(self.top, self.bottom);
            let title_point = Point::new(self.left - lettering.title_left, middle);
            canvas.upward_text("", title_point, text);
        }
        if let Some(text) = x_title {
            let middle = f64::midpoint(self.left, self.right);
            let title_point = Point::new(middle, self.bottom + lettering.title_below);
            canvas.text("", title_point, Anchor::Middle, text);
        }
    }

    /// Draws a line of the grid; returns false for one between labelled ones.
    fn grid_line(&self, canvas: &mut Canvas, label: &str, from: Point, to: Point) -> bool {
        if !label.is_empty() {
            canvas.line("grid", from, to);
        } else if self.lettering.minor {
            canvas.line("minor", from, to);
        }
        !label.is_empty()
    }

    fn tick(&self, canvas: &mut Canvas, from: Point, right: f64, down: f64) {
        let length = self.lettering.tick;
        if length > 0.0 {
            let to = Point::new(from.x + right * length, from.y + down * length);
            canvas.line("tick", from, to);
        }
    }

    /// Draws a second scale at the right: `factor` turns values of the left one into its own.
    pub fn right_scale(&self, canvas: &mut Canvas, factor: f64, title: &str) {
        /// Width of a figure of a tick's label, and what is left free beside the widest label.
        const FIGURE: f64 = 8.5;
        const FREE: f64 = 16.0;
        let lettering = self.lettering;
        let axis = Axis::linear(
            self.y.low() * factor,
            self.y.high() * factor,
            self.bottom,
            self.top,
        );
        let mut figures = 0;
        for tick in axis.ticks(lettering.spacing_right, 0.0) {
            let y = axis.place(tick.value);
            figures = figures.max(tick.label.chars().count());
            self.tick(canvas, Point::new(self.right, y), 1.0, 0.0);
            let label_x = self.right + lettering.label_beside;
            let label_point = Point::new(label_x, y + lettering.label_drop);
            canvas.text(
                self.lettering.class,
                label_point,
                Anchor::Start,
                &tick.label,
            );
        }
        let middle = f64::midpoint(self.top, self.bottom);
        let beside = self.right + lettering.label_beside + FIGURE * figures as f64 + FREE;
        canvas.upward_text("", Point::new(beside.min(WIDTH - 8.0), middle), title);
    }

    /// Draws the frame; it comes after the curves.
    pub fn frame(&self, canvas: &mut Canvas) {
        canvas.rectangle("frame", self.area());
    }

    /// Opens a group that draws inside the panel only; `id` is its own in the drawing.
    pub fn begin_inside(&self, canvas: &mut Canvas, id: &str) {
        canvas.begin_clipped(id, self.area());
    }

    /// Draws a function of x, thinned to what can be seen.
    pub fn function(&self, canvas: &mut Canvas, class: &str, points: impl Iterator<Item = Point>) {
        let placed = points
            .map(|values| self.place(values))
            .filter(|point| point.x >= self.left - 40.0 && point.x <= self.right + 40.0);
        canvas.polyline(class, thin::columns(placed, 0.7).into_iter());
    }

    /// Draws a line across at `y`.
    pub fn level(&self, canvas: &mut Canvas, class: &str, y: f64) {
        if self.y.contains(y) {
            let line_y = self.y.place(y);
            canvas.line(
                class,
                Point::new(self.left, line_y),
                Point::new(self.right, line_y),
            );
        }
    }

    /// Draws a line upright at `x`.
    pub fn upright(&self, canvas: &mut Canvas, class: &str, x: f64) {
        if self.x.contains(x) {
            let line_x = self.x.place(x);
            canvas.line(
                class,
                Point::new(line_x, self.top),
                Point::new(line_x, self.bottom),
            );
        }
    }

    /// Shades a span of `x` over the whole height.
    pub fn shade(&self, canvas: &mut Canvas, class: &str, from: f64, to: f64) {
        let (left, right) = (self.x.place(from), self.x.place(to));
        let shaded = Rectangle {
            left,
            width: right - left,
            ..self.area()
        };
        canvas.rectangle(class, shaded);
    }

    /// Writes a text beside a point, on the side where the panel has more room, inside it.
    pub fn label(&self, canvas: &mut Canvas, class: &str, point: Point, text: &str) {
        let left_half = point.x < f64::midpoint(self.left, self.right);
        let (x, anchor) = if left_half {
            (point.x + 11.0, Anchor::Start)
        } else {
            (point.x - 11.0, Anchor::End)
        };
        let y = point.y.clamp(self.top + 16.0, self.bottom - 8.0);
        canvas.text(class, Point::new(x, y), anchor, text);
    }
}

/// A line of the legend: a sample and a text.
pub struct LegendEntry {
    sample: Sample,
    text: String,
}

/// Sample of a line, patch or mark in a legend.
#[derive(Debug)]
pub enum Sample {
    /// A stroke of this class.
    Line(&'static str),
    /// A filled patch of this class.
    Patch(&'static str),
    /// A short upright stroke of this class.
    Tick(&'static str),
    /// A stroke of the first class, and on it a mark of the second.
    Marked(String, String, Shape),
    /// A patch of a colour that no theme changes.
    Colour(Rgb),
}

impl LegendEntry {
    /// Returns an entry with a sample and a text.
    pub fn new(sample: Sample, text: impl Into<String>) -> Self {
        Self {
            sample,
            text: text.into(),
        }
    }

    /// Returns an entry with a stroke.
    pub fn line(class: &'static str, text: impl Into<String>) -> Self {
        Self::new(Sample::Line(class), text)
    }
}

/// Returns an entry for each stop that is `shown`, drawn as its `class`.
pub fn stop_legend(
    class: fn(StopModel) -> &'static str,
    shown: &dyn Fn(StopModel) -> bool,
) -> Vec<LegendEntry> {
    let stops = StopModel::ALL.into_iter().filter(|model| shown(*model));
    stops
        .map(|model| LegendEntry::line(class(model), model.label()))
        .collect()
}

/// Style classes of what is drawn of a stop, in its colour.
pub(super) struct StopClasses {
    /// Its run.
    pub(super) run: &'static str,
    /// Its run in a second opening direction.
    pub(super) other: &'static str,
    /// The band of its varied levers.
    pub(super) ribbon: &'static str,
}

impl StopClasses {
    /// Returns those of a stop.
    pub(super) fn of(model: StopModel) -> Self {
        match model {
            StopModel::Rigid => Self {
                run: "run-rigid",
                other: "run-rigid other",
                ribbon: "ribbon of-rigid",
            },
            StopModel::Soft => Self {
                run: "run-soft",
                other: "run-soft other",
                ribbon: "ribbon of-soft",
            },
        }
    }
}

/// Writes title, notes and legend at the top and returns the height at which the first panel may start.
pub fn header(
    canvas: &mut Canvas,
    left: f64,
    title: &str,
    notes: &[String],
    entries: &[LegendEntry],
) -> f64 {
    let mut y = if notes.is_empty() { 22.0 } else { 24.0 };
    canvas.text("title", Point::new(left, y), Anchor::Start, title);
    for note in notes {
        y += 20.0;
        canvas.text("muted", Point::new(left, y), Anchor::Start, note);
    }
    if entries.is_empty() {
        return y + 16.0;
    }
    legend(canvas, Point::new(left, y + 24.0), entries) + 14.0
}

/// Writes entries in lines from a place on and returns the height of the last line.
pub fn legend(canvas: &mut Canvas, first: Point, entries: &[LegendEntry]) -> f64 {
    let Point { mut x, mut y } = first;
    for entry in entries {
        let width = 34.0 + entry.text.chars().count() as f64 * (LETTER - 1.2) + 16.0;
        if x > first.x && x + width > WIDTH - 4.0 {
            x = first.x;
            y += 21.0;
        }
        let right_of = |distance, up| Point::new(x + distance, y - up);
        let (from, to) = (right_of(0.0, 5.0), right_of(26.0, 5.0));
        let patch = Rectangle {
            left: x,
            top: y - 12.0,
            width: 26.0,
            height: 14.0,
        };
        match &entry.sample {
            Sample::Line(class) => canvas.line(class, from, to),
            Sample::Patch(class) => canvas.rectangle(class, patch),
            Sample::Tick(class) => canvas.line(class, right_of(13.0, 12.0), right_of(13.0, -2.0)),
            Sample::Marked(line, mark, shape) => {
                canvas.line(line, from, to);
                shape.draw(canvas, mark, right_of(13.0, 5.0));
            }
            Sample::Colour(colour) => {
                if let Some(png) = raster::encode(colour, 1, 1) {
                    canvas.png(&png, patch);
                }
            }
        }
        canvas.text("", right_of(34.0, 0.0), Anchor::Start, &entry.text);
        x += width;
    }
    y
}

/// Height that [`footer`] needs below the last panel.
pub const FOOTER: f64 = 66.0;

/// Writes the drawing's identity at the bottom right.
pub fn footer(canvas: &mut Canvas, origin: &str, height: f64) {
    let text_end = Point::new(RIGHT, height - 6.0);
    canvas.text("origin", text_end, Anchor::End, origin);
}

/// Returns the range of finite values; [`Range::EMPTY`] of none.
pub fn extent(values: impl Iterator<Item = f64>) -> Range {
    let finite = values.filter(|value| value.is_finite());
    finite.fold(Range::EMPTY, Range::including)
}

/// Returns the scale of finite values, with a margin on both sides as a share of the range between,
/// or of one where all are equal; `0..1` of none.
pub fn range(values: impl Iterator<Item = f64>, margin: f64) -> Scale {
    let Range { low, high } = extent(values);
    if low > high {
        return Scale::Linear(0.0, 1.0);
    }
    let room = if high > low {
        ((high - low) * margin).max(1e-9)
    } else {
        1.0
    };
    Scale::Linear(low - room, high + room)
}
