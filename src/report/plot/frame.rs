//! A framed panel anywhere in the drawing, for charts of several panels.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas};
use super::panel::LETTER;
use super::thin;

/// Rules of the charts of motions, in terms of the colours' variables.
pub(super) const RULES: &str = "\
.plot .line{fill:none;stroke-width:1.4;stroke-linejoin:round}
.plot .fine{stroke-width:.9}
.plot .bold{stroke-width:2.2}
.plot .nothing{stroke:var(--raw);stroke-dasharray:5 3}
.plot .rigid{stroke:var(--first)}
.plot .soft{stroke:var(--second)}
.plot .third{stroke:var(--third)}
.plot .ink{stroke:var(--ink)}
.plot .failing{stroke:var(--fail)}
.plot .dash{stroke-dasharray:6 4}
.plot .dotted{stroke-dasharray:1.5 3.5}
.plot .ridge{fill:none;stroke:#ffffff;stroke-width:1.6}
.plot .ridge-edge{fill:none;stroke:#000000;stroke-width:3.4;stroke-opacity:.55}
.plot .ridge-dot{fill:#ffffff;stroke:#000000;stroke-width:.8}
.plot .pull{fill:var(--fail);opacity:.22}
.plot .between{fill:var(--second);opacity:.25}
.plot .small{font-size:12px}
.plot .spot{fill:var(--ink);stroke:var(--paper);stroke-width:1}
";

/// A panel with its two axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

/// Where a panel stands: left, right, top, bottom.
pub(super) type Place = (f64, f64, f64, f64);

impl Frame {
    /// Lays two linear axes on a place.
    pub(super) fn linear(place: Place, x: (f64, f64), y: (f64, f64)) -> Self {
        let (left, right, top, bottom) = place;
        Self::of(
            place,
            Axis::linear(x.0, x.1, left, right),
            Axis::linear(y.0, y.1, bottom, top),
        )
    }

    /// Lays a logarithmic axis across and a linear one up.
    pub(super) fn logarithmic_x(place: Place, x: (f64, f64), y: (f64, f64)) -> Self {
        let (left, right, top, bottom) = place;
        Self::of(
            place,
            Axis::logarithmic(x.0, x.1, left, right),
            Axis::linear(y.0, y.1, bottom, top),
        )
    }

    fn of((left, right, top, bottom): Place, x: Axis, y: Axis) -> Self {
        Self {
            left,
            right,
            top,
            bottom,
            x,
            y,
        }
    }

    pub(super) fn place(&self, x: f64, y: f64) -> (f64, f64) {
        (self.x.place(x), self.y.place(y))
    }

    /// Writes the panel's own title above it.
    pub(super) fn title(&self, canvas: &mut Canvas, text: &str) {
        canvas.text("strong", (self.left, self.top - 9.0), Anchor::Start, text);
    }

    /// Draws grid, ticks and titles of the axes. The y title stands `away` left of the frame.
    pub(super) fn grid(
        &self,
        canvas: &mut Canvas,
        x_title: Option<&str>,
        y_title: Option<(&str, f64)>,
    ) {
        for tick in self.x.ticks(80.0, LETTER) {
            if tick.label.is_empty() {
                continue;
            }
            let x = self.x.place(tick.value);
            canvas.line("grid", (x, self.top), (x, self.bottom));
            canvas.line("tick", (x, self.bottom), (x, self.bottom + 4.0));
            if x_title.is_some() {
                canvas.text(
                    "muted small",
                    (x, self.bottom + 18.0),
                    Anchor::Middle,
                    &tick.label,
                );
            }
        }
        for tick in self.y.ticks(38.0, 0.0) {
            if tick.label.is_empty() {
                continue;
            }
            let y = self.y.place(tick.value);
            canvas.line("grid", (self.left, y), (self.right, y));
            canvas.line("tick", (self.left - 4.0, y), (self.left, y));
            canvas.text(
                "muted small",
                (self.left - 8.0, y + 4.0),
                Anchor::End,
                &tick.label,
            );
        }
        if let Some(title) = x_title {
            canvas.text(
                "",
                (f64::midpoint(self.left, self.right), self.bottom + 37.0),
                Anchor::Middle,
                title,
            );
        }
        if let Some((title, away)) = y_title {
            canvas.upward_text(
                "",
                (self.left - away, f64::midpoint(self.top, self.bottom)),
                title,
            );
        }
    }

    /// Draws the frame; it comes after the curves.
    pub(super) fn frame(&self, canvas: &mut Canvas) {
        canvas.rectangle(
            "frame",
            (self.left, self.top),
            (self.right - self.left, self.bottom - self.top),
        );
    }

    /// Opens a group that draws inside the panel only; `id` is its own in the drawing.
    pub(super) fn begin_inside(&self, canvas: &mut Canvas, id: &str) {
        canvas.clip(
            id,
            (self.left, self.top),
            (self.right - self.left, self.bottom - self.top),
        );
        canvas.begin_clipped(id);
    }

    /// Draws a function of x, thinned to what can be seen.
    pub(super) fn function(
        &self,
        canvas: &mut Canvas,
        class: &str,
        points: impl Iterator<Item = (f64, f64)>,
    ) {
        let placed = points
            .map(|(x, y)| self.place(x, y))
            .filter(|(x, _)| *x >= self.left - 40.0 && *x <= self.right + 40.0);
        canvas.polyline(class, thin::columns(placed, 0.7).into_iter());
    }

    /// Draws a curve that may turn back, thinned to at most `most` points.
    pub(super) fn curve(
        &self,
        canvas: &mut Canvas,
        class: &str,
        points: impl Iterator<Item = (f64, f64)>,
        most: usize,
    ) {
        let placed: Vec<(f64, f64)> = points.map(|(x, y)| self.place(x, y)).collect();
        canvas.polyline(class, thin::curve(&placed, 0.5, most).into_iter());
    }

    /// Draws a line across at `y`.
    pub(super) fn level(&self, canvas: &mut Canvas, class: &str, y: f64) {
        if self.y.contains(y) {
            let at = self.y.place(y);
            canvas.line(class, (self.left, at), (self.right, at));
        }
    }

    /// Draws a line upright at `x`.
    pub(super) fn upright(&self, canvas: &mut Canvas, class: &str, x: f64) {
        if self.x.contains(x) {
            let at = self.x.place(x);
            canvas.line(class, (at, self.top), (at, self.bottom));
        }
    }
}

/// Writes the chart's title, a line of explanation, and a legend of strokes; returns where the
/// panels may start.
pub(super) fn header(
    canvas: &mut Canvas,
    left: f64,
    title: &str,
    note: &str,
    legend: &[(&str, &str)],
) -> f64 {
    canvas.text("title", (left, 24.0), Anchor::Start, title);
    canvas.text("muted", (left, 45.0), Anchor::Start, note);
    let (mut x, y) = (left, 70.0);
    for (class, text) in legend {
        canvas.line(class, (x, y - 5.0), (x + 28.0, y - 5.0));
        canvas.text("", (x + 35.0, y), Anchor::Start, text);
        let width = text.chars().count() as f64 * (LETTER - 1.2);
        x += 35.0 + width + 20.0;
    }
    if legend.is_empty() { 56.0 } else { 84.0 }
}

/// Returns the least and largest of finite values, with a margin on both sides as a share of the
/// range between; `0..1` of none.
pub(super) fn range(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low > high {
        return (0.0, 1.0);
    }
    let room = ((high - low) * margin).max(1e-9);
    (low - room, high + room)
}
