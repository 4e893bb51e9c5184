//! The basins of attraction, one panel per stop.

use super::dynamics::empty;
use crate::basins::Basins;
use latchgate_document::number::significant;
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{Frame, LEFT, Scale, header};
use latchgate_report::plot::{Figure, raster};

/// Colours of up to eight attractors; more go round.
const BASIN_COLOURS: [[u8; 3]; 8] = [
    [206, 214, 222],
    [222, 112, 32],
    [45, 125, 205],
    [44, 150, 116],
    [150, 88, 186],
    [200, 170, 30],
    [190, 60, 60],
    [90, 100, 110],
];

/// Draws the basins, one panel per stop.
pub(super) fn draw(all: &[Basins]) -> Figure {
    const HEIGHT: f64 = 400.0;
    let mut canvas = Canvas::with_capacity(1024 * 1024);
    let Some(first) = all.first() else {
        return empty("basins");
    };
    let title = format!(
        "Basins of attraction, A = {} g, ω = {} rad/s",
        first.options.amplitude_g, first.options.forced.angular_frequency_rad_s
    );
    let (columns, rows) = first.options.grid;
    let mut lines = vec![format!(
        "Where the lever ends up from each of {columns} × {rows} initial states, and the share of them."
    )];
    if all.iter().any(|basins| !basins.fine.is_empty()) {
        lines.push(
            "Cells at a boundary are drawn cut in four; the shares are those of whole cells."
                .into(),
        );
    }
    let mut top = header(&mut canvas, LEFT, &title, &lines, &[]);
    let mut description = String::new();
    for basins in all {
        top += 30.0;
        let stop = basins.options.forced.stop.name();
        let (angles, velocities) = (basins.options.angle_rad, basins.options.velocity_rad_s);
        let panel = Frame::wide(
            (top, top + HEIGHT),
            Scale::Linear(angles.0, angles.1),
            Scale::Linear(velocities.0, velocities.1),
        );
        panel.title(&mut canvas, &format!("{stop} stop"));
        for text in legend(&mut canvas, basins, top) {
            description.push_str(&format!(" {stop} stop, {text}."));
        }
        panel.grid(
            &mut canvas,
            Some("initial angle [rad]"),
            Some("initial angular velocity [rad/s]"),
        );
        if let Some(png) = cells(basins) {
            canvas.png(&png, panel.corner(), panel.size());
        }
        panel.frame(&mut canvas);
        top += HEIGHT + 48.0;
    }
    Figure {
        name: "basins",
        title,
        caption: lines.join(" "),
        description: format!("Map of initial states by attractor.{description}"),
        height: top + 8.0,
        body: canvas.into_string(),
    }
}

fn basin_colour(index: u32) -> [u8; 3] {
    BASIN_COLOURS[index as usize % BASIN_COLOURS.len()]
}

/// Names the attractors with their shares beside the panel's title; returns the texts.
fn legend(canvas: &mut Canvas, basins: &Basins, top: f64) -> Vec<String> {
    let mut texts = Vec::new();
    let mut x = LEFT + 110.0;
    for attractor in &basins.attractors {
        let share = attractor.share.map_or_else(
            || "share not known, interrupted".into(),
            |share| format!("{} %", significant(100.0 * share, 4)),
        );
        let text = format!("{}: {share}", attractor.name);
        if let Some(png) = raster::encode(&basin_colour(attractor.index), 1, 1) {
            canvas.png(&png, (x, top - 21.0), (22.0, 13.0));
        }
        canvas.text("", (x + 29.0, top - 9.0), Anchor::Start, &text);
        let width = 29.0 + text.chars().count() as f64 * 7.6 + 20.0;
        x += width;
        texts.push(text);
    }
    texts
}

/// Returns the finest cells there are as base64 of a PNG; a cell without an attractor is clear.
fn cells(basins: &Basins) -> Option<String> {
    let (columns, rows) = basins.options.grid;
    let (mut columns, mut rows) = (columns as usize, rows as usize);
    let mut cells = &basins.cells;
    if !basins.fine.is_empty() {
        (columns, rows, cells) = (2 * columns, 2 * rows, &basins.fine);
    }
    let mut pixels = Vec::with_capacity(4 * columns * rows);
    for row in (0..rows).rev() {
        for cell in &cells[row * columns..(row + 1) * columns] {
            match cell {
                Some(index) => {
                    let [r, g, b] = basin_colour(*index);
                    pixels.extend_from_slice(&[r, g, b, 255]);
                }
                None => pixels.extend_from_slice(&[0; 4]),
            }
        }
    }
    raster::encode(&pixels, columns, rows)
}
