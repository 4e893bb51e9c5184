//! One growing string of SVG, with coordinates to a hundredth of a unit.

use crate::escape::markup;
use std::fmt::{Display, Formatter, Write as _};

/// SVG elements in drawing order.
#[derive(Debug, Default)]
pub struct Canvas {
    out: String,
}

/// A place in the drawing [units], or a pair of values in a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// To the right.
    pub x: f64,
    /// Downwards in the drawing, upwards in a panel.
    pub y: f64,
}

impl Point {
    /// Returns the point of two coordinates.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// True unless a coordinate is infinite or none.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

/// A rectangle of the drawing [units].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

/// Point of a text that lies at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Text begins at its point.
    Start,
    /// Text is centred on its point.
    Middle,
    /// Text ends at its point.
    End,
}

/// A coordinate with at most two decimals, limited to a million units, which is far off the page. NaN is
/// drawn there too.
struct Unit(f64);

impl Display for Unit {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        const FAR: f64 = 1e6;
        let coordinate = if self.0.is_nan() {
            FAR
        } else {
            self.0.clamp(-FAR, FAR)
        };
        // Zero is added since it turns a negative zero into one without a sign.
        ((coordinate * 100.0).round() / 100.0 + 0.0).fmt(formatter)
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
    pub fn line(&mut self, class: &str, from: Point, to: Point) {
        let [x1, y1, x2, y2] = [from.x, from.y, to.x, to.y].map(Unit);
        draw!(
            self,
            r#"<line class="{class}" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"/>"#
        );
    }

    /// Draws a rectangle.
    pub fn rectangle(&mut self, class: &str, rectangle: Rectangle) {
        draw!(self, r#"<rect class="{class}"{}/>"#, extent(rectangle));
    }

    /// Begins a group that is cut at the edges of a rectangle; `id` is its own in the drawing.
    pub fn begin_clipped(&mut self, id: &str, rectangle: Rectangle) {
        let extent = extent(rectangle);
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
    pub fn circle(&mut self, class: &str, centre: Point, radius: f64) {
        let [x, y, radius] = [centre.x, centre.y, radius].map(Unit);
        draw!(
            self,
            r#"<circle class="{class}" cx="{x}" cy="{y}" r="{radius}"/>"#
        );
    }

    /// Draws a square on its corner.
    pub fn diamond(&mut self, class: &str, Point { x, y }: Point, r: f64) {
        let corners = [(x, y - r), (x + r, y), (x, y + r), (x - r, y)];
        let corners = corners.map(|(x, y)| Point::new(x, y));
        draw!(
            self,
            r#"<path class="{class}" d="{}Z"/>"#,
            path(corners.into_iter())
        );
    }

    /// Writes a text; `text` is escaped here.
    pub fn text(&mut self, class: &str, point: Point, anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => r#" text-anchor="middle""#,
            Anchor::End => r#" text-anchor="end""#,
        };
        let (x, y, text) = (Unit(point.x), Unit(point.y), markup(text));
        draw!(
            self,
            r#"<text class="{class}" x="{x}" y="{y}"{anchor}>{text}</text>"#
        );
    }

    /// Writes a text that reads upwards, centred at a point.
    pub fn upward_text(&mut self, class: &str, point: Point, text: &str) {
        let (x, y, text) = (Unit(point.x), Unit(point.y), markup(text));
        draw!(
            self,
            r#"<text class="{class}" text-anchor="middle" transform="translate({x} {y}) rotate(-90)">{text}</text>"#
        );
    }

    /// Places a PNG, given as base64, stretched over a rectangle.
    pub fn png(&mut self, base64: &str, rectangle: Rectangle) {
        draw!(
            self,
            r#"<image{} preserveAspectRatio="none" href="data:image/png;base64,{base64}"/>"#,
            extent(rectangle)
        );
    }

    /// Draws straight lines through points; a point that is not finite breaks the line.
    pub fn polyline(&mut self, class: &str, points: impl Iterator<Item = Point>) {
        draw!(self, r#"<path class="{class}" d="{}"/>"#, path(points));
    }
}

fn extent(rectangle: Rectangle) -> String {
    let [x, y] = [rectangle.left, rectangle.top].map(Unit);
    let sides = [rectangle.width, rectangle.height];
    let [width, height] = sides.map(|length| Unit(length.max(0.0)));
    format!(r#" x="{x}" y="{y}" width="{width}" height="{height}""#)
}

fn path(points: impl Iterator<Item = Point>) -> String {
    let mut path = String::new();
    let mut command = 'M';
    for point in points {
        if point.is_finite() {
            // Writing into a String cannot fail.
            let _ = write!(path, "{command}{} {}", Unit(point.x), Unit(point.y));
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
    /// Two strokes across each other, on the diagonals.
    Cross(f64),
    /// Two strokes across each other, upright and level.
    Plus(f64),
    /// A cross and a plus.
    Star(f64),
    /// A triangle on its tip.
    Triangle(f64),
}

impl Shape {
    /// Draws the mark.
    pub fn draw(self, canvas: &mut Canvas, class: &str, point: Point) {
        let beside = |right, down| Point::new(point.x + right, point.y + down);
        match self {
            Self::Circle(radius) => canvas.circle(class, point, radius),
            Self::Diamond(radius) => canvas.diamond(class, point, radius),
            Self::Cross(r) => {
                canvas.line(class, beside(-r, -r), beside(r, r));
                canvas.line(class, beside(-r, r), beside(r, -r));
            }
            Self::Plus(r) => {
                canvas.line(class, beside(-r, 0.0), beside(r, 0.0));
                canvas.line(class, beside(0.0, -r), beside(0.0, r));
            }
            Self::Star(r) => {
                Self::Cross(0.8 * r).draw(canvas, class, point);
                Self::Plus(1.1 * r).draw(canvas, class, point);
            }
            Self::Triangle(r) => {
                let corners = [
                    beside(-r, -r),
                    beside(r, -r),
                    beside(0.0, r),
                    beside(-r, -r),
                ];
                canvas.polyline(class, corners.into_iter());
            }
        }
    }
}
