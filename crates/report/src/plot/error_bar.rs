//! The largest angle of a run with its error, as a bar in the plots of the angle.

use super::canvas::{Canvas, Point};
use super::frame::Frame;
use crate::words;
use latchgate_document::Document;
use latchgate_kernel::range::Range;
use latchgate_kernel::replay::Run;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// A largest angle with its error, as a bar.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct ErrorBar {
    /// When the angle is reached [s].
    pub(super) at_s: f64,
    /// The angle less its error, not below the stop [rad].
    pub(super) low: f64,
    /// The angle with its error [rad].
    pub(super) high: f64,
}

impl ErrorBar {
    /// Returns that of a run; none where its error is not known, and of an angle without a figure beyond 90°.
    pub(super) fn of_run(document: &Document, run: &Run) -> Option<Self> {
        let error_rad = words::uncertainty(document, run)?;
        let (low, high) = (
            run.peak_angle_rad - error_rad,
            run.peak_angle_rad + error_rad,
        );
        (error_rad > 0.0 && run.peak_angle_rad <= FRAC_PI_2).then_some(Self {
            at_s: run.peak_time_s,
            low: low.max(0.0),
            high: high.max(0.0),
        })
    }

    /// Returns its ends that lie in a range; one beyond has none there, and goes on to the range's edge.
    pub(super) fn within(self, range: Range) -> Option<(Range, [Option<f64>; 2])> {
        let (low, high) = (self.low.max(range.low), self.high.min(range.high));
        let end = |value: f64| range.contains(value).then_some(value);
        (low < high).then(|| (Range::new(low, high), [self.low, self.high].map(end)))
    }
}

impl ErrorBar {
    /// Draws it in a panel; `scale` leads from seconds to the panel's time.
    pub(super) fn draw(self, canvas: &mut Canvas, frame: &Frame, range: Range, scale: f64) {
        let Some((span, ends)) = self.within(range) else {
            return;
        };
        let place = |angle: f64| frame.place(Point::new(self.at_s * scale, angle));
        canvas.line("mark error-bar", place(span.low), place(span.high));
        for end in ends.into_iter().flatten() {
            let Point { x, y } = place(end);
            canvas.line(
                "mark error-bar",
                Point::new(x - BAR_END, y),
                Point::new(x + BAR_END, y),
            );
        }
    }
}

/// Half the width of the end of an error bar [units].
pub(super) const BAR_END: f64 = 5.0;
