//! What the charts of the lever's motion on sines share.

use latchgate_report::plot::Figure;
use latchgate_report::plot::frame::Scale;

/// Rules of these charts.
pub(super) const RULES: &str = "\
.plot image{image-rendering:pixelated}
.plot .birth{fill:none;stroke:var(--pass);stroke-width:1.5}
.plot .doubling{fill:none;stroke:var(--fail);stroke-width:1.5}
.plot .contour{fill:none;stroke:var(--paper);stroke-width:4;stroke-linejoin:round}
.plot .contour-ink{fill:none;stroke:#e02020;stroke-width:2;stroke-linejoin:round}
.plot .lift{fill:none;stroke:#ffffff;stroke-width:2;stroke-dasharray:11 7}
.plot .lift-edge{fill:none;stroke:#000000;stroke-width:4;stroke-opacity:.45}
.plot .few-event-driven{fill:#2d7dcd;stroke:var(--paper);stroke-width:.75}
.plot .few-rk4{fill:#de7020;stroke:var(--paper);stroke-width:.75}
.plot .ring{fill:none;stroke:var(--ink);stroke-width:1.5}
.plot .tiny{font-size:11.5px}
";

/// Returns the scale of a range widened by a part of it at both ends.
pub(super) fn widened((low, high): (f64, f64), part: f64) -> Scale {
    if low.is_finite() && high > low {
        let room = part * (high - low);
        Scale::Linear(low - room, high + room)
    } else if low.is_finite() {
        Scale::Linear(low - 1.0, low + 1.0)
    } else {
        Scale::Linear(0.0, 1.0)
    }
}

/// Returns the chart of a study that computed nothing.
pub(super) fn empty(name: &'static str) -> Figure {
    Figure {
        name,
        title: "nothing computed".into(),
        caption: String::new(),
        description: "nothing computed".into(),
        height: 60.0,
        body: String::new(),
    }
}
