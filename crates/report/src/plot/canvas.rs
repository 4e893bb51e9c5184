//! One growing string of SVG, with coordinates to a hundredth of a unit.

use crate::escape::markup;
use std::fmt::{Display, Formatter, Write as _};

/// SVG elements in drawing order.
#[derive(Debug, Default)]
pub struct Canvas {
    out: String,
}

/// Where a text is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Text begins at its point.
    Start,
    /// Text is centred on its point.
    Middle,
    /// Text ends at its point.
    End,
}

/// A coordinate with at most two decimals; what is not finite or far off the page is held at a
/// million units, where nothing is seen of it.
struct Unit(f64);

impl Display for Unit {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        const FAR: f64 = 1e6;
        let held = if self.0.is_nan() {
            FAR
        } else {
            self.0.clamp(-FAR, FAR)
        };
        // Zero is added since it turns a negative zero into one without a sign.
        ((held * 100.0).round() / 100.0 + 0.0).fmt(formatter)
    }
}

/// Writes a line of SVG.
macro_rules! draw {
    ($canvas:expr, $($text:tt)*) => {
        // Writing into a String cannot fail.
        let _ = writeln!($canvas.out, $($text)*);
    };
}

impl Canvas {
    /// Returns an empty drawing with room for `bytes`.
    pub fn with_capacity(bytes: usize) -> Self {
        Self {
            out: String::with_capacity(bytes),
        }
    }

    /// Returns the elements drawn.
    pub fn into_string(self) -> String {
        self.out
    }

    /// Draws a straight line.
    pub fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        let [x1, y1, x2, y2] = [from.0, from.1, to.0, to.1].map(Unit);
        draw!(
            self,
            r#"<line class="{class}" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"/>"#
        );
    }

    /// Draws a rectangle.
    pub fn rectangle(&mut self, class: &str, corner: (f64, f64), size: (f64, f64)) {
        draw!(self, r#"<rect class="{class}"{}/>"#, extent(corner, size));
    }

    /// Begins a group that is cut at the edges of a rectangle; `id` is its own in the drawing.
    pub fn begin_clipped(&mut self, id: &str, corner: (f64, f64), size: (f64, f64)) {
        let extent = extent(corner, size);
        draw!(self, r#"<clipPath id="{id}"><rect{extent}/></clipPath>"#);
        draw!(self, r#"<g clip-path="url(#{id})">"#);
    }

    /// Begins a group of a class.
    pub fn begin_group(&mut self, class: &str) {
        draw!(self, r#"<g class="{class}">"#);
    }

    /// Ends the innermost group.
    pub fn end_group(&mut self) {
        draw!(self, "</g>");
    }

    /// Draws a circle.
    pub fn circle(&mut self, class: &str, (x, y): (f64, f64), radius: f64) {
        let [x, y, radius] = [x, y, radius].map(Unit);
        draw!(
            self,
            r#"<circle class="{class}" cx="{x}" cy="{y}" r="{radius}"/>"#
        );
    }

    /// Draws a square on its corner.
    pub fn diamond(&mut self, class: &str, (x, y): (f64, f64), r: f64) {
        let corners = [(x, y - r), (x + r, y), (x, y + r), (x - r, y)];
        draw!(
            self,
            r#"<path class="{class}" d="{}Z"/>"#,
            path(corners.into_iter())
        );
    }

    /// Writes a text; `text` is escaped here.
    pub fn text(&mut self, class: &str, (x, y): (f64, f64), anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => r#" text-anchor="middle""#,
            Anchor::End => r#" text-anchor="end""#,
        };
        let (x, y, text) = (Unit(x), Unit(y), markup(text));
        draw!(
            self,
            r#"<text class="{class}" x="{x}" y="{y}"{anchor}>{text}</text>"#
        );
    }

    /// Writes a text that reads upwards, centred at a point.
    pub fn upward_text(&mut self, class: &str, (x, y): (f64, f64), text: &str) {
        let (x, y, text) = (Unit(x), Unit(y), markup(text));
        draw!(
            self,
            r#"<text class="{class}" text-anchor="middle" transform="translate({x} {y}) rotate(-90)">{text}</text>"#
        );
    }

    /// Places a PNG, given as base64, stretched over a rectangle.
    pub fn png(&mut self, base64: &str, corner: (f64, f64), size: (f64, f64)) {
        draw!(
            self,
            r#"<image{} preserveAspectRatio="none" href="data:image/png;base64,{base64}"/>"#,
            extent(corner, size)
        );
    }

    /// Draws straight lines through points; a point that is not finite breaks the line.
    pub fn polyline(&mut self, class: &str, points: impl Iterator<Item = (f64, f64)>) {
        draw!(self, r#"<path class="{class}" d="{}"/>"#, path(points));
    }
}

fn extent(corner: (f64, f64), size: (f64, f64)) -> String {
    let [x, y] = [corner.0, corner.1].map(Unit);
    let [width, height] = [size.0, size.1].map(|length| Unit(length.max(0.0)));
    format!(r#" x="{x}" y="{y}" width="{width}" height="{height}""#)
}

fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    let mut command = 'M';
    for (x, y) in points {
        if x.is_finite() && y.is_finite() {
            // Writing into a String cannot fail.
            let _ = write!(path, "{command}{} {}", Unit(x), Unit(y));
            command = 'L';
        } else {
            command = 'M';
        }
    }
    path
}

/// Shape of a mark, with its radius [units].
#[derive(Debug, Clone, Copy)]
pub enum Shape {
    /// A circle.
    Circle(f64),
    /// A square on its corner.
    Diamond(f64),
    /// Two strokes across each other.
    Cross(f64),
}

impl Shape {
    /// Draws the mark.
    pub fn draw(self, canvas: &mut Canvas, class: &str, (x, y): (f64, f64)) {
        match self {
            Self::Circle(radius) => canvas.circle(class, (x, y), radius),
            Self::Diamond(radius) => canvas.diamond(class, (x, y), radius),
            Self::Cross(r) => {
                canvas.line(class, (x - r, y - r), (x + r, y + r));
                canvas.line(class, (x - r, y + r), (x + r, y - r));
            }
        }
    }
}
