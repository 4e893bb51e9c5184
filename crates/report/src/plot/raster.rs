//! Pictures made of pixels: clouds of points by their density, maps by their cells.

use super::axis::Axis;
use super::canvas::{Point, Rectangle};
use base64::Engine as _;

/// Pixels per unit of the drawing.
const SCALE: f64 = 2.0;

/// Returns pixels, three or four bytes each, as base64 of a PNG; `None` only if the encoder
/// refuses, which it does for sizes that do not occur here.
pub fn encode(pixels: &[u8], width: usize, height: usize) -> Option<String> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(
        &mut file,
        u32::try_from(width).ok()?,
        u32::try_from(height).ok()?,
    );
    let colour = if pixels.len() == 4 * width * height {
        png::ColorType::Rgba
    } else {
        png::ColorType::Rgb
    };
    encoder.set_color(colour);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(pixels).ok()?;
    writer.finish().ok()?;
    Some(base64::engine::general_purpose::STANDARD.encode(&file))
}

/// A colour that shows on light and on dark paper.
pub type Rgb = [u8; 3];

/// Blue of points.
pub const BLUE: Rgb = [45, 125, 205];
/// Orange of points.
pub const ORANGE: Rgb = [222, 112, 32];

/// Returns a cloud of points as base64 of a transparent PNG over the panel that `x` and `y` span:
/// the more points fall on a pixel the denser, by their logarithm, and a single point can still
/// be seen. Each point is a square of `dot` pixels.
pub fn cloud(
    points: impl Iterator<Item = Point>,
    x: &Axis,
    y: &Axis,
    area: Rectangle,
    dot: usize,
    colour: Rgb,
) -> Option<String> {
    let (width, height) = (
        (area.width * SCALE).round() as usize,
        (area.height * SCALE).round() as usize,
    );
    let mut counts = vec![0_u32; width * height];
    let (left_x, top_y) = (x.place(x.low()), y.place(y.high()));
    for point in points {
        if !(x.contains(point.x) && y.contains(point.y)) {
            continue;
        }
        let column = (((x.place(point.x) - left_x) * SCALE) as usize).saturating_sub(dot / 2);
        let row = (((y.place(point.y) - top_y) * SCALE) as usize).saturating_sub(dot / 2);
        for row in row..(row + dot).min(height) {
            for column in column..(column + dot).min(width) {
                counts[row * width + column] += 1;
            }
        }
    }
    let densest = counts.iter().copied().max().unwrap_or(0).max(1);
    let full = libm::log1p(f64::from(densest).min(40.0));
    let mut pixels = Vec::with_capacity(4 * counts.len());
    for count in counts {
        let alpha = if count == 0 {
            0.0
        } else {
            0.4 + 0.6 * (libm::log1p(f64::from(count)) / full).min(1.0)
        };
        let [r, g, b] = if alpha > 0.0 { colour } else { [0; 3] };
        pixels.extend_from_slice(&[r, g, b, (255.0 * alpha).round() as u8]);
    }
    encode(&pixels, width, height)
}
