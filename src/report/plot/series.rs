//! What the charts of the studies share: one colour and mark per method, crosses for failures.

use super::axis::{Axis, Tick};
use super::canvas::{Anchor, Canvas};

/// Rules of the studies' charts, in terms of the colours' variables.
pub(super) const RULES: &str = "\
.plot .line{fill:none;stroke-width:1.5;stroke-linejoin:round}
.plot .ink-line{stroke:var(--ink)}
.plot .event-driven{stroke:var(--first)}
.plot .rk4{stroke:var(--second)}
.plot .rk4-located{stroke:var(--third)}
.plot .dopri5{stroke:var(--ink);stroke-dasharray:6 3}
.plot .dopri5-samples{stroke:var(--fourth)}
.plot .moreau-jean{stroke:var(--raw)}
.plot .dot{stroke:var(--paper);stroke-width:.75}
.plot .dot-event-driven{fill:var(--first)}
.plot .dot-rk4{fill:var(--second)}
.plot .dot-rk4-located{fill:var(--third)}
.plot .dot-dopri5{fill:var(--ink)}
.plot .dot-dopri5-samples{fill:var(--fourth)}
.plot .dot-moreau-jean{fill:var(--raw)}
.plot .failure{fill:none;stroke:var(--fail);stroke-width:2}
.plot .ring{fill:none;stroke:var(--ink);stroke-width:1.5}
.plot .tiny{font-size:11px}
.plot .good{fill:var(--pass);opacity:.75}
.plot .fair{fill:var(--third);opacity:.35}
.plot .poor{fill:var(--undecided);opacity:.55}
.plot .bad{fill:var(--fail);opacity:.45}
.plot .gone{fill:var(--fail);opacity:.9}
";

/// Returns the class of a method's line: its name.
pub(super) fn class(method: &str) -> &str {
    method
}

/// The shape of a method's points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// Events are located.
    Circle,
    /// Events lie on the grid.
    Diamond,
}

impl Mark {
    pub(super) fn of(method: &str) -> Self {
        match method {
            "rk4" | "moreau-jean" => Self::Diamond,
            _ => Self::Circle,
        }
    }
}

/// Draws a point of a method.
pub(super) fn mark(canvas: &mut Canvas, mark: Mark, method: &str, at: (f64, f64)) {
    let class = format!("dot dot-{method}");
    match mark {
        Mark::Circle => canvas.circle(&class, at, 3.6),
        Mark::Diamond => canvas.diamond(&class, at, 4.8),
    }
}

/// Draws the cross of a failure.
pub(super) fn cross(canvas: &mut Canvas, (x, y): (f64, f64)) {
    canvas.line("failure", (x - 4.0, y - 4.0), (x + 4.0, y + 4.0));
    canvas.line("failure", (x - 4.0, y + 4.0), (x + 4.0, y - 4.0));
}

/// Draws grid and tick labels of a panel.
pub(super) fn grid(
    canvas: &mut Canvas,
    x: &Axis,
    y: &Axis,
    (left, right): (f64, f64),
    (top, bottom): (f64, f64),
) {
    // Lines inside the decades would hide the points.
    let labelled = |tick: &Tick| !tick.label.is_empty();
    for tick in x.ticks(80.0, 8.6).into_iter().filter(labelled) {
        let at = x.place(tick.value);
        canvas.line("grid", (at, top), (at, bottom));
        canvas.text("muted", (at, bottom + 19.0), Anchor::Middle, &tick.label);
    }
    for tick in y.ticks(40.0, 0.0).into_iter().filter(labelled) {
        let at = y.place(tick.value);
        canvas.line("grid", (left, at), (right, at));
        canvas.text("muted", (left - 7.0, at + 5.0), Anchor::End, &tick.label);
    }
}
