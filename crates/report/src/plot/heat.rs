//! Heat maps: a colour map in which equal steps look equal, also in grey and to colour-blind eyes,
//! the cells of a map, and the bar that explains them.

use super::axis::{Axis, Scale};
use super::canvas::{Anchor, Canvas, Point, Rectangle};
use super::frame::Frame;
use super::raster::encode;
use latchgate_document::number::trimmed;

/// Nine points of the viridis map, from its dark end to its light one, evenly spaced.
///
/// # Source
///
/// viridis, S. van der Walt and N. Smith, released under CC0.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

/// Returns the colour at `share` of the way, straight between the points; a share outside
/// 0..=1 takes the nearer end.
fn viridis(share: f64) -> [u8; 3] {
    let place = if share.is_nan() {
        0.0
    } else {
        share.clamp(0.0, 1.0) * 8.0
    };
    let index = (place as usize).min(7);
    let part = place - index as f64;
    let (from, to) = (VIRIDIS[index], VIRIDIS[index + 1]);
    std::array::from_fn(|channel| {
        (from[channel] + part * (to[channel] - from[channel])).round() as u8
    })
}

/// Returns a map as base64 of a PNG: `share` of a column from the left and a row from the bottom
/// is its place on the colour map; a cell without one is grey. `None` only if the encoder refuses.
pub fn cells(
    (columns, rows): (usize, usize),
    share: impl Fn(usize, usize) -> Option<f64>,
) -> Option<String> {
    let mut pixels = Vec::with_capacity(3 * columns * rows);
    for row in (0..rows).rev() {
        for column in 0..columns {
            pixels.extend(share(column, row).map_or([128; 3], viridis));
        }
    }
    encode(&pixels, columns, rows)
}

/// A bar that explains the colours of a map.
#[derive(Default)]
pub struct Bar {
    /// Values from its dark end to its light one.
    pub scale: Scale,
    /// Name of the quantity, with its unit.
    pub title: String,
    /// Values marked on it, each with a class.
    pub marked: Vec<(&'static str, f64)>,
    /// True if the colours of both ends are those of all beyond them as well, and the labels say so.
    pub open: bool,
}

impl Bar {
    /// Draws the bar at the right of a panel.
    pub(super) fn draw(&self, canvas: &mut Canvas, panel: &Frame) {
        let (left, top, bottom) = (panel.right + 10.0, panel.top, panel.bottom);
        let bar = Rectangle {
            left,
            width: 14.0,
            ..panel.area()
        };
        let right_of = |distance, y| Point::new(left + distance, y);
        let steps = cells((1, 64), |_, step| Some((step as f64 + 0.5) / 64.0));
        if let Some(steps) = steps {
            canvas.png(&steps, bar);
        }
        canvas.rectangle("frame", bar);
        let axis = Axis::new(self.scale, bottom, top);
        for tick in axis.ticks(46.0, 0.0) {
            if tick.label.is_empty() {
                continue;
            }
            let y = axis.place(tick.value);
            canvas.line("tick", right_of(14.0, y), right_of(19.0, y));
            let label = if self.open && y < top + 0.5 {
                format!("≥ {}", trimmed(tick.value, 3))
            } else if self.open && y > bottom - 0.5 {
                format!("≤ {}", tick.label)
            } else {
                tick.label
            };
            canvas.text("muted", right_of(23.0, y + 5.0), Anchor::Start, &label);
        }
        for (class, value) in &self.marked {
            let y = axis.place(*value);
            canvas.line(class, right_of(0.0, y), right_of(14.0, y));
        }
        canvas.text("", right_of(70.0, top - 12.0), Anchor::End, &self.title);
    }
}
