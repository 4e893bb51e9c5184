//! Marks of methods: a colour and a shape for each, crosses for failures.

use crate::work_precision::Status;
use latchgate_report::plot::chart::Shape;
use latchgate_report::plot::frame::{LegendEntry, Sample};

/// Rules of these charts, in terms of the colours' variables.
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

/// Cross of a failure.
pub(super) const CROSS: Shape = Shape::Cross(4.0);

/// Marks of failures with what they say.
pub(super) const FAILURES: [(Status, Shape, &str); 4] = [
    (Status::ExtraImpacts, CROSS, "too many impacts"),
    (Status::MissedImpacts, Shape::Plus(5.0), "missed impacts"),
    (
        Status::Tunnelled,
        Shape::Triangle(4.5),
        "went through the stop",
    ),
    (Status::Unstable, Shape::Star(4.5), "unstable"),
];

/// Returns the shape of a method's points: a circle if it locates events, a diamond if they lie on
/// its grid.
pub(super) fn shape(method: &str) -> Shape {
    match method {
        "rk4" | "moreau-jean" => Shape::Diamond(4.8),
        _ => Shape::Circle(3.6),
    }
}

/// Returns the entry of a method in the legend.
pub(super) fn entry(method: &str) -> LegendEntry {
    let (line, dot) = (format!("line {method}"), format!("dot dot-{method}"));
    LegendEntry::new(Sample::Marked(line, dot, shape(method)), name(method))
}

/// Returns what a method is, in words.
fn name(method: &str) -> &str {
    match method {
        "rk4" => "Runge-Kutta 4 on a grid (rk4)",
        "rk4-located" => "Runge-Kutta 4, events located",
        "dopri5" => "Dormand-Prince 5(4)",
        "dopri5-samples" => "Dormand-Prince, sample by sample",
        "moreau-jean" => "Moreau-Jean time stepping",
        other => other,
    }
}
