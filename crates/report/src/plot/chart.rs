//! Charts as data: panels of layers, laid out and drawn by one function.

pub use super::axis::At;
use super::canvas::{Anchor, Canvas, Rectangle};
pub use super::canvas::{Point, Shape};
use super::frame::{self, Frame, LEFT, LegendEntry, Lettering, RIGHT, Scale};
use super::heat::Bar;
use super::raster::{self, Rgb};
use super::{Figure, WIDTH, thin};

/// A chart: panels with title, notes, legend and foot.
#[derive(Default)]
pub struct Chart {
    /// Name: file name without `.svg`, and prefix of the ids inside.
    pub name: &'static str,
    /// Its content in a few words.
    pub title: String,
    /// Lines below the title.
    pub notes: Vec<String>,
    /// Lines and patches of all panels.
    pub legend: Vec<LegendEntry>,
    /// Panels in reading order.
    pub panels: Vec<Panel>,
    /// Room below the header, between rows of panels, and below the last [units].
    pub room: [f64; 3],
    /// Identity of the drawing outside its page, written at its foot.
    pub origin: String,
    /// How to read it, one or two sentences.
    pub caption: String,
    /// Text for a reader who does not see the drawing, with its numbers.
    pub description: String,
}

/// Edges of a panel [units]. A panel to the right of the one before stands beside it; any other
/// begins a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edges {
    /// Left edge.
    pub left: f64,
    /// Right edge.
    pub right: f64,
}

impl Edges {
    /// Returns the edges at two places.
    pub const fn new(left: f64, right: f64) -> Self {
        Self { left, right }
    }
}

/// Edges of a panel that has a second scale or a bar at its right.
pub const ACROSS: Edges = Edges::new(LEFT, RIGHT);
/// Edges of a panel over the whole width.
pub const WHOLE: Edges = Edges::new(72.0, WIDTH - 16.0);
/// Edges of two panels beside one another.
pub const HALVES: [Edges; 2] = [Edges::new(72.0, 438.0), Edges::new(520.0, WIDTH - 16.0)];

/// Pairs of values.
pub type Points = Vec<Point>;

impl Chart {
    /// Draws the chart.
    pub fn draw(self) -> Figure {
        let mut canvas = Canvas::default();
        let [above, between, below] = self.room;
        let left = self.panels.iter().map(|panel| panel.edges.left);
        let left = left.fold(LEFT, f64::min);
        let head = frame::header(&mut canvas, left, &self.title, &self.notes, &self.legend);
        let mut top = head + above;
        let (mut right, mut bottom) = (0.0, top);
        for (index, panel) in self.panels.iter().enumerate() {
            if panel.edges.left < right {
                top = bottom + between;
            }
            panel.draw(&mut canvas, top, &format!("{}-{index}", self.name));
            (right, bottom) = (panel.edges.right, top + panel.height);
        }
        let height = bottom + below;
        if !self.origin.is_empty() {
            frame::footer(&mut canvas, &self.origin, height);
        }
        Figure {
            name: self.name,
            title: self.title,
            caption: self.caption,
            description: self.description,
            height,
            body: canvas.into_string(),
        }
    }
}

/// Two axes and the layers drawn on them, added call by call.
pub struct Panel {
    lettering: &'static Lettering,
    edges: Edges,
    height: f64,
    x: (String, Scale),
    y: (String, Scale),
    title: String,
    right: Option<(f64, &'static str)>,
    bar: Option<Bar>,
    legend: Vec<LegendEntry>,
    below_grid: Vec<Layer>,
    inside: Vec<Layer>,
    above_frame: Vec<Layer>,
}

/// Draws one thing once the panel has its place.
type Layer = Box<dyn Fn(&mut Canvas, &Frame)>;

impl Panel {
    /// Returns an empty panel of a height [units].
    pub fn new(lettering: &'static Lettering, edges: Edges, height: f64) -> Self {
        Self {
            lettering,
            edges,
            height,
            x: (String::new(), Scale::default()),
            y: (String::new(), Scale::default()),
            title: String::new(),
            right: None,
            bar: None,
            legend: Vec::new(),
            below_grid: Vec::new(),
            inside: Vec::new(),
            above_frame: Vec::new(),
        }
    }

    /// Sets the axis below; without a title it has no labels either.
    pub fn x(mut self, title: impl Into<String>, scale: Scale) -> Self {
        self.x = (title.into(), scale);
        self
    }

    /// Sets the axis at the left.
    pub fn y(mut self, title: impl Into<String>, scale: Scale) -> Self {
        self.y = (title.into(), scale);
        self
    }

    /// Sets what is written above the panel.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Sets a second scale at the right: the factor from the left one, and its title.
    pub fn right(mut self, factor: f64, title: &'static str) -> Self {
        self.right = Some((factor, title));
        self
    }

    /// Sets a scale of colours at the right.
    pub fn bar(mut self, bar: Bar) -> Self {
        self.bar = Some(bar);
        self
    }

    /// Sets the legend of this panel alone, which stands below it.
    pub fn legend(mut self, entries: impl IntoIterator<Item = LegendEntry>) -> Self {
        self.legend = entries.into_iter().collect();
        self
    }

    /// Applies `add` once for each item.
    pub fn each<T>(
        self,
        items: impl IntoIterator<Item = T>,
        add: impl FnMut(Self, T) -> Self,
    ) -> Self {
        items.into_iter().fold(self, add)
    }

    fn inside(mut self, draw: impl Fn(&mut Canvas, &Frame) + 'static) -> Self {
        self.inside.push(Box::new(draw));
        self
    }

    fn above(mut self, draw: impl Fn(&mut Canvas, &Frame) + 'static) -> Self {
        self.above_frame.push(Box::new(draw));
        self
    }

    /// Adds a region of full height between two values, below the grid.
    pub fn band(mut self, class: &'static str, from: f64, to: f64) -> Self {
        self.below_grid.push(Box::new(move |canvas, frame| {
            let place = |x: f64| frame.x.place(x.clamp(frame.x.low(), frame.x.high()));
            let band = Rectangle {
                left: place(from),
                width: (place(to) - place(from)).max(1.0),
                ..frame.area()
            };
            canvas.rectangle(class, band);
        }));
        self
    }

    /// Adds a function of x, thinned to what can be seen.
    pub fn function(self, class: &'static str, points: impl IntoIterator<Item = Point>) -> Self {
        let points: Points = points.into_iter().collect();
        self.inside(move |canvas, frame| frame.function(canvas, class, points.iter().copied()))
    }

    /// Adds a curve that may turn back, thinned to at most `points_max` points.
    pub fn curve(
        self,
        class: &'static str,
        points: impl IntoIterator<Item = Point>,
        points_max: usize,
    ) -> Self {
        let points: Points = points.into_iter().collect();
        self.inside(move |canvas, frame| {
            canvas.polyline(
                class,
                thin::curve(&frame.placed(&points), 0.5, points_max).into_iter(),
            );
        })
    }

    /// Adds straight lines, broken where a value is not finite, or the outline of an area.
    pub fn lines(
        self,
        class: impl AsRef<str> + 'static,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        let points: Points = points.into_iter().collect();
        self.inside(move |canvas, frame| {
            canvas.polyline(class.as_ref(), frame.placed(&points).into_iter());
        })
    }

    /// Adds a line across.
    pub fn level(self, class: &'static str, y: f64) -> Self {
        self.inside(move |canvas, frame| frame.level(canvas, class, y))
    }

    /// Adds a line upright.
    pub fn upright(self, class: &'static str, x: f64) -> Self {
        self.inside(move |canvas, frame| frame.upright(canvas, class, x))
    }

    /// Adds a straight line between two places.
    pub fn segment(self, class: &'static str, from: (At, At), to: (At, At)) -> Self {
        self.inside(move |canvas, frame| canvas.line(class, frame.at(from), frame.at(to)))
    }

    /// Adds a rectangle between two corners.
    pub fn patch(self, class: &'static str, from: (At, At), to: (At, At)) -> Self {
        self.inside(move |canvas, frame| {
            canvas.rectangle(class, frame.rectangle(from, to));
        })
    }

    /// Adds a PNG as base64, stretched between two corners.
    pub fn picture(self, png: Option<String>, from: (At, At), to: (At, At)) -> Self {
        self.each(png, |panel, png| {
            panel.inside(move |canvas, frame| {
                canvas.png(&png, frame.rectangle(from, to));
            })
        })
    }

    /// Adds a PNG as base64 that fills the panel.
    pub fn map(self, png: Option<String>) -> Self {
        let (left, right) = (At::Low(0.0), At::High(0.0));
        self.picture(png, (left, right), (right, left))
    }

    /// Adds points by their density, each a square of `dot` pixels.
    pub fn cloud(self, colour: Rgb, points: Points, dot: usize) -> Self {
        self.inside(move |canvas, frame| {
            let points = points.iter().copied();
            let area = frame.area();
            if let Some(png) = raster::cloud(points, &frame.x, &frame.y, area, dot, colour) {
                canvas.png(&png, area);
            }
        })
    }

    /// Adds a mark at each point; it may reach out of the panel.
    pub fn marks(
        self,
        class: impl AsRef<str> + 'static,
        shape: Shape,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        let points: Points = points.into_iter().collect();
        self.above(move |canvas, frame| {
            for point in frame.placed(&points) {
                shape.draw(canvas, class.as_ref(), point);
            }
        })
    }

    /// Adds a text on the side of its place towards which it is moved, or centred there.
    pub fn text(self, class: &'static str, place: (At, At), text: impl Into<String>) -> Self {
        let text = text.into();
        let (At::Value(_, right) | At::Low(right) | At::High(right)) = place.0;
        let anchor = match right {
            right if right > 0.0 => Anchor::Start,
            right if right < 0.0 => Anchor::End,
            _ => Anchor::Middle,
        };
        self.above(move |canvas, frame| canvas.text(class, frame.at(place), anchor, &text))
    }

    /// Adds a text beside a place, on the side where the panel has more room.
    pub fn beside(self, class: &'static str, place: (At, At), text: impl Into<String>) -> Self {
        let text = text.into();
        self.above(move |canvas, frame| frame.label(canvas, class, frame.at(place), &text))
    }

    /// Draws the panel from `top` on; `id` is its own in the drawing.
    fn draw(&self, canvas: &mut Canvas, top: f64, id: &str) {
        let area = Rectangle {
            left: self.edges.left,
            top,
            width: self.edges.right - self.edges.left,
            height: self.height,
        };
        let frame = Frame::new(self.lettering, area, self.x.1, self.y.1);
        if !self.title.is_empty() {
            frame.title(canvas, &self.title);
        }
        self.below_grid.iter().for_each(|draw| draw(canvas, &frame));
        let titles = [&self.x.0, &self.y.0].map(|title| (!title.is_empty()).then_some(&**title));
        frame.grid(canvas, titles[0], titles[1]);
        if let Some((factor, title)) = self.right {
            frame.right_scale(canvas, factor, title);
        }
        frame.begin_inside(canvas, id);
        self.inside.iter().for_each(|draw| draw(canvas, &frame));
        canvas.end_group();
        frame.frame(canvas);
        self.above_frame
            .iter()
            .for_each(|draw| draw(canvas, &frame));
        if let Some(bar) = &self.bar {
            bar.draw(canvas, &frame);
        }
        let legend_point = Point::new(frame.left, frame.bottom + 62.0);
        frame::legend(canvas, legend_point, &self.legend);
    }
}
