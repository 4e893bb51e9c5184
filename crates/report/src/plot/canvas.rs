//! One growing string of SVG, with coordinates to a hundredth of a unit.

use crate::escape;

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

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
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
        self.open("line", class);
        self.number("x1", from.0);
        self.number("y1", from.1);
        self.number("x2", to.0);
        self.number("y2", to.1);
        self.out.push_str("/>\n");
    }

    /// Draws a rectangle.
    pub fn rectangle(&mut self, class: &str, corner: (f64, f64), size: (f64, f64)) {
        self.open("rect", class);
        self.box_attributes(corner, size);
        self.out.push_str("/>\n");
    }

    /// Defines a clip path of the shape of a rectangle.
    pub fn clip(&mut self, id: &str, corner: (f64, f64), size: (f64, f64)) {
        self.out.push_str("<clipPath id=\"");
        self.out.push_str(id);
        self.out.push_str("\"><rect");
        self.box_attributes(corner, size);
        self.out.push_str("/></clipPath>\n");
    }

    /// Begins a group that is clipped by the path of that id.
    pub fn begin_clipped(&mut self, id: &str) {
        self.out.push_str("<g clip-path=\"url(#");
        self.out.push_str(id);
        self.out.push_str(")\">\n");
    }

    /// Begins a group of a class.
    pub fn begin_group(&mut self, class: &str) {
        self.open("g", class);
        self.out.push_str(">\n");
    }

    /// Ends the innermost group.
    pub fn end_group(&mut self) {
        self.out.push_str("</g>\n");
    }

    /// Draws a circle.
    pub fn circle(&mut self, class: &str, centre: (f64, f64), radius: f64) {
        self.open("circle", class);
        self.number("cx", centre.0);
        self.number("cy", centre.1);
        self.number("r", radius);
        self.out.push_str("/>\n");
    }

    /// Draws a square on its corner.
    pub fn diamond(&mut self, class: &str, centre: (f64, f64), radius: f64) {
        let (x, y) = centre;
        self.begin_path(class);
        self.move_to((x, y - radius));
        for point in [(x + radius, y), (x, y + radius), (x - radius, y)] {
            self.line_to(point);
        }
        self.out.push_str("Z\"/>\n");
    }

    /// Writes a text; `text` is escaped here.
    pub fn text(&mut self, class: &str, at: (f64, f64), anchor: Anchor, text: &str) {
        self.open("text", class);
        self.number("x", at.0);
        self.number("y", at.1);
        if anchor != Anchor::Start {
            self.out.push_str(" text-anchor=\"");
            self.out.push_str(anchor.name());
            self.out.push('"');
        }
        self.out.push('>');
        self.out.push_str(&escape::markup(text));
        self.out.push_str("</text>\n");
    }

    /// Writes a text that reads upwards, centred at a point.
    pub fn upward_text(&mut self, class: &str, at: (f64, f64), text: &str) {
        self.open("text", class);
        self.out
            .push_str(" text-anchor=\"middle\" transform=\"translate(");
        coordinate(&mut self.out, at.0);
        self.out.push(' ');
        coordinate(&mut self.out, at.1);
        self.out.push_str(") rotate(-90)\">");
        self.out.push_str(&escape::markup(text));
        self.out.push_str("</text>\n");
    }

    /// Places a PNG, given as base64, stretched over a rectangle.
    pub fn png(&mut self, base64: &str, corner: (f64, f64), size: (f64, f64)) {
        self.out.push_str("<image");
        self.box_attributes(corner, size);
        self.out
            .push_str(" preserveAspectRatio=\"none\" href=\"data:image/png;base64,");
        self.out.push_str(base64);
        self.out.push_str("\"/>\n");
    }

    /// Begins a path of a class.
    pub fn begin_path(&mut self, class: &str) {
        self.open("path", class);
        self.out.push_str(" d=\"");
    }

    /// Lifts the pen to a point.
    pub fn move_to(&mut self, point: (f64, f64)) {
        self.out.push('M');
        self.point(point);
    }

    /// Draws on to a point.
    pub fn line_to(&mut self, point: (f64, f64)) {
        self.out.push('L');
        self.point(point);
    }

    /// Ends the path.
    pub fn end_path(&mut self) {
        self.out.push_str("\"/>\n");
    }

    /// Draws straight lines through points; a point that is not finite breaks the line.
    pub fn polyline(&mut self, class: &str, points: impl Iterator<Item = (f64, f64)>) {
        self.begin_path(class);
        let mut drawing = false;
        for point in points {
            if !(point.0.is_finite() && point.1.is_finite()) {
                drawing = false;
            } else if drawing {
                self.line_to(point);
            } else {
                self.move_to(point);
                drawing = true;
            }
        }
        self.end_path();
    }

    fn point(&mut self, (x, y): (f64, f64)) {
        coordinate(&mut self.out, x);
        self.out.push(' ');
        coordinate(&mut self.out, y);
    }

    fn open(&mut self, element: &str, class: &str) {
        self.out.push('<');
        self.out.push_str(element);
        self.out.push_str(" class=\"");
        self.out.push_str(class);
        self.out.push('"');
    }

    fn box_attributes(&mut self, corner: (f64, f64), size: (f64, f64)) {
        self.number("x", corner.0);
        self.number("y", corner.1);
        self.number("width", size.0.max(0.0));
        self.number("height", size.1.max(0.0));
    }

    fn number(&mut self, name: &str, value: f64) {
        self.out.push(' ');
        self.out.push_str(name);
        self.out.push_str("=\"");
        coordinate(&mut self.out, value);
        self.out.push('"');
    }
}

/// Appends a coordinate with at most two decimals; what is not finite or far off the page is
/// held at a million units, where nothing is seen of it.
pub fn coordinate(out: &mut String, value: f64) {
    const FAR: f64 = 1e6;
    let held = if value.is_nan() {
        FAR
    } else {
        value.clamp(-FAR, FAR)
    };
    let hundredths = (held * 100.0).round() as i64;
    if hundredths < 0 {
        out.push('-');
    }
    let magnitude = hundredths.unsigned_abs();
    let (whole, part) = (magnitude / 100, magnitude % 100);
    push_integer(out, whole);
    if part != 0 {
        out.push('.');
        out.push(digit(part / 10));
        if part % 10 != 0 {
            out.push(digit(part % 10));
        }
    }
}

fn push_integer(out: &mut String, value: u64) {
    if value >= 10 {
        push_integer(out, value / 10);
    }
    out.push(digit(value % 10));
}

fn digit(value: u64) -> char {
    char::from(b'0' + u8::try_from(value % 10).unwrap_or(0))
}
