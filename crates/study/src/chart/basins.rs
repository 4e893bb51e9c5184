//! The basins of attraction, one panel per stop.

use crate::basins::{BasinAttractor, Basins};
use latchgate_document::number::significant;
use latchgate_report::plot::chart::{ACROSS, Chart, Panel};
use latchgate_report::plot::frame::{LegendEntry, Sample, Scale, WIDE};
use latchgate_report::plot::raster;

/// Colours of the attractors; a ninth takes the first again.
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

/// Returns the basins, one panel per stop.
pub(super) fn chart(results: &[Basins]) -> Chart {
    let title = results.first().map_or_else(String::new, |first| {
        let (amplitude, forced) = (first.options.amplitude_g, &first.options.forced);
        let omega = forced.angular_frequency_rad_s;
        format!("Basins of attraction, A = {amplitude} g, ω = {omega} rad/s")
    });
    let (columns, rows) = results.first().map_or((0, 0), |first| first.options.grid);
    let mut notes = vec![format!(
        "Where the lever ends up from each of {columns} × {rows} initial states, and the share of them."
    )];
    if results.iter().any(|basins| !basins.fine.is_empty()) {
        notes.push(
            "Cells at a boundary are drawn cut in four; the shares are those of whole cells."
                .into(),
        );
    }
    let mut description = String::from("Map of initial states by attractor.");
    for basins in results {
        let stop = basins.options.forced.stop.name();
        for text in basins.attractors.iter().map(share) {
            description.push_str(&format!(" {stop} stop, {text}."));
        }
    }
    Chart {
        name: "basins",
        title,
        caption: notes.join(" "),
        notes,
        panels: results.iter().map(panel).collect(),
        room: [30.0, 110.0, 90.0],
        description,
        ..Chart::default()
    }
}

fn panel(basins: &Basins) -> Panel {
    let (angles, velocities) = (basins.options.angle_rad, basins.options.velocity_rad_s);
    let entries = basins.attractors.iter().map(|attractor| {
        let colour = Sample::Colour(basin_colour(attractor.index));
        LegendEntry::new(colour, share(attractor))
    });
    let stop = basins.options.forced.stop.name();
    Panel::new(&WIDE, ACROSS, 400.0)
        .title(format!("{stop} stop"))
        .x(
            "initial angle [rad]",
            Scale::Linear(angles.low, angles.high),
        )
        .y(
            "initial angular velocity [rad/s]",
            Scale::Linear(velocities.low, velocities.high),
        )
        .map(cells(basins))
        .legend(entries)
}

fn basin_colour(index: u32) -> [u8; 3] {
    BASIN_COLOURS[index as usize % BASIN_COLOURS.len()]
}

/// Returns the name of an attractor with its share.
fn share(attractor: &BasinAttractor) -> String {
    let share = attractor.share.map_or_else(
        || "share not known, interrupted".into(),
        |share| format!("{} %", significant(100.0 * share, 4)),
    );
    format!("{}: {share}", attractor.name)
}

/// Returns the finest cells as base64 of a PNG; a cell without an attractor is transparent.
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
