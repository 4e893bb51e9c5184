//! What the plots share: a framed panel with ticks and labels, a legend, a footer.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas};
use super::{Context, WIDTH};

/// Left and right edge of every panel, so that time axes of all plots stand under one another.
pub(super) const LEFT: f64 = 78.0;
pub(super) const RIGHT: f64 = WIDTH - 92.0;

/// Width that a letter is taken to need [units]; a wide font's, so that labels keep apart.
pub(super) const LETTER: f64 = 8.6;

/// A framed stretch of the drawing with its two axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

impl Panel {
    pub(super) fn linear(x: (f64, f64), y: (f64, f64), top: f64, bottom: f64) -> Self {
        Self {
            top,
            bottom,
            x: Axis::linear(x.0, x.1, LEFT, RIGHT),
            y: Axis::linear(y.0, y.1, bottom, top),
        }
    }

    /// Lays the plots' common time axis, in the unit shown, under a panel.
    pub(super) fn over_time(context: &Context, y: (f64, f64), top: f64, bottom: f64) -> Self {
        let scale = context.time_scale;
        let (start, end) = context.span_s;
        Self::linear((start * scale, end * scale), y, top, bottom)
    }

    pub(super) fn place(&self, x: f64, y: f64) -> (f64, f64) {
        (self.x.place(x), self.y.place(y))
    }

    pub(super) fn clip(&self, canvas: &mut Canvas, id: &str) {
        canvas.clip(id, (LEFT, self.top), (RIGHT - LEFT, self.bottom - self.top));
    }

    /// Draws grid, ticks, tick labels and axis titles; the frame comes after the curves.
    /// A panel that shares its time axis with one below it has no `x_title` and no labels there.
    pub(super) fn grid(&self, canvas: &mut Canvas, x_title: Option<&str>, y_title: &str) {
        let middle = f64::midpoint(self.top, self.bottom);
        for tick in self.x.ticks(95.0, LETTER) {
            let x = self.x.place(tick.value);
            let class = if tick.label.is_empty() {
                "minor"
            } else {
                "grid"
            };
            canvas.line(class, (x, self.top), (x, self.bottom));
            if x_title.is_some() && !tick.label.is_empty() {
                canvas.line("tick", (x, self.bottom), (x, self.bottom + 5.0));
                canvas.text(
                    "muted",
                    (x, self.bottom + 20.0),
                    Anchor::Middle,
                    &tick.label,
                );
            }
        }
        for tick in self.y.ticks(46.0, 0.0) {
            let y = self.y.place(tick.value);
            let class = if tick.label.is_empty() {
                "minor"
            } else {
                "grid"
            };
            canvas.line(class, (LEFT, y), (RIGHT, y));
            if !tick.label.is_empty() {
                canvas.line("tick", (LEFT - 5.0, y), (LEFT, y));
                canvas.text("muted", (LEFT - 9.0, y + 5.0), Anchor::End, &tick.label);
            }
        }
        canvas.upward_text("", (17.0, middle), y_title);
        if let Some(title) = x_title {
            canvas.text(
                "",
                (f64::midpoint(LEFT, RIGHT), self.bottom + 42.0),
                Anchor::Middle,
                title,
            );
        }
    }

    /// Draws a second scale at the right: `factor` turns values of the left one into its own.
    pub(super) fn second_scale(&self, canvas: &mut Canvas, factor: f64, title: &str) {
        let axis = Axis::linear(
            self.y.low() * factor,
            self.y.high() * factor,
            self.bottom,
            self.top,
        );
        for tick in axis.ticks(56.0, 0.0) {
            let y = axis.place(tick.value);
            canvas.line("tick", (RIGHT, y), (RIGHT + 5.0, y));
            canvas.text("muted", (RIGHT + 9.0, y + 5.0), Anchor::Start, &tick.label);
        }
        canvas.upward_text(
            "",
            (WIDTH - 8.0, f64::midpoint(self.top, self.bottom)),
            title,
        );
    }

    pub(super) fn frame(&self, canvas: &mut Canvas) {
        canvas.rectangle(
            "frame",
            (LEFT, self.top),
            (RIGHT - LEFT, self.bottom - self.top),
        );
    }

    /// Writes a text beside a point, on the side where the panel has more room, inside it.
    pub(super) fn label(&self, canvas: &mut Canvas, class: &str, at: (f64, f64), text: &str) {
        let left_half = at.0 < f64::midpoint(LEFT, RIGHT);
        let (x, anchor) = if left_half {
            (at.0 + 11.0, Anchor::Start)
        } else {
            (at.0 - 11.0, Anchor::End)
        };
        let y = at.1.clamp(self.top + 16.0, self.bottom - 8.0);
        canvas.text(class, (x, y), anchor, text);
    }
}

/// A line of the legend: how it is drawn and what it is.
pub(super) struct Entry {
    pub(super) mark: Mark,
    pub(super) text: String,
}

/// How a legend shows its thing.
#[derive(Debug, Clone, Copy)]
pub(super) enum Mark {
    /// A stroke of this class.
    Line(&'static str),
    /// A filled patch of this class.
    Patch(&'static str),
    /// A short upright stroke of this class.
    Tick(&'static str),
}

impl Entry {
    pub(super) fn new(mark: Mark, text: impl Into<String>) -> Self {
        Self {
            mark,
            text: text.into(),
        }
    }
}

/// Writes title and legend at the top and returns where the first panel may start.
pub(super) fn header(canvas: &mut Canvas, title: &str, entries: &[Entry]) -> f64 {
    canvas.text("title", (LEFT, 22.0), Anchor::Start, title);
    let (mut x, mut y) = (LEFT, 46.0);
    for entry in entries {
        let width = 34.0 + entry.text.chars().count() as f64 * (LETTER - 1.2) + 16.0;
        if x > LEFT && x + width > WIDTH - 4.0 {
            x = LEFT;
            y += 21.0;
        }
        match entry.mark {
            Mark::Line(class) => canvas.line(class, (x, y - 5.0), (x + 26.0, y - 5.0)),
            Mark::Patch(class) => canvas.rectangle(class, (x, y - 12.0), (26.0, 14.0)),
            Mark::Tick(class) => canvas.line(class, (x + 13.0, y - 12.0), (x + 13.0, y + 2.0)),
        }
        canvas.text("", (x + 34.0, y), Anchor::Start, &entry.text);
        x += width;
    }
    if entries.is_empty() { 36.0 } else { y + 14.0 }
}

/// Height that [`footer`] needs below the last panel.
pub(super) const FOOTER: f64 = 66.0;

/// Writes at the bottom right what the drawing belongs to.
pub(super) fn footer(canvas: &mut Canvas, context: &Context, height: f64) {
    canvas.text(
        "origin",
        (RIGHT, height - 6.0),
        Anchor::End,
        &context.origin,
    );
}
