//! Amplitude and frequency that open the latch, one panel per stop.

use crate::excitation_map::ExcitationMap;
use latchgate_document::number::{significant, trimmed};
use latchgate_report::plot::chart::{ACROSS, Chart, Panel, Point, Points};
use latchgate_report::plot::frame::{Scale, WIDE};
use latchgate_report::plot::heat::{self, Bar};

/// Classes of a line on the map and on its bar, which crosses dark and light colours.
const CONTOUR: [&str; 2] = ["contour", "contour-ink"];

/// Returns the largest angle over amplitude and frequency with the threshold's contour.
pub(super) fn chart(maps: &[ExcitationMap]) -> Chart {
    let Some(first) = maps.first() else {
        return Chart::default();
    };
    let threshold = first.options.forced.design.criterion.threshold_rad;
    let notes = vec![
        format!(
            "Colour: largest angle from rest within {} periods. White dashes: lift-off at A = {} g.",
            first.options.periods,
            significant(first.lift_off_g, 5)
        ),
        format!(
            "Red: below it no amplitude of the grid exceeds {threshold} rad; where it lies between two is found by halving."
        ),
        "Where motion is chaotic, amplitudes between those of the grid may pass it earlier.".into(),
    ];
    let mut description = String::from("Map of the largest angle over amplitude and frequency.");
    for map in maps {
        let least = map.boundary.iter().filter_map(|at| at.amplitude_g);
        description.push_str(&format!(
            " {} stop: least amplitude of the contour {} g.",
            map.options.forced.stop.name(),
            trimmed(least.fold(f64::INFINITY, f64::min), 5)
        ));
    }
    Chart {
        name: "excitation-map",
        title: "What excitation opens the latch".into(),
        caption: notes.join(" "),
        notes,
        panels: maps.iter().map(|map| panel(map, threshold)).collect(),
        room: [30.0, 78.0, 56.0],
        description,
        ..Chart::default()
    }
}

/// Returns the largest angles, the threshold's contour and the lift-off.
fn panel(map: &ExcitationMap, threshold: f64) -> Panel {
    // The scale has four decades, with the threshold in the upper two.
    let decade = libm::log10(threshold).round();
    let (low, high) = (libm::pow(10.0, decade - 3.0), libm::pow(10.0, decade + 1.0));
    let (amplitudes, frequencies) = (map.options.grid.0 as usize, map.options.grid.1 as usize);
    let cells = heat::cells((frequencies, amplitudes), |column, line| {
        let row = map.rows.get(column * amplitudes + line)?;
        Some(libm::log10(row.peak_angle_rad.max(low) / low) / libm::log10(high / low))
    });
    let contour = map.boundary.iter().map(|at| {
        let amplitude = at.amplitude_g.unwrap_or(f64::NAN);
        Point::new(at.angular_frequency_rad_s, amplitude)
    });
    let contour: Points = contour.collect();
    let (x, y) = (
        map.options.angular_frequencies_rad_s,
        map.options.amplitudes_g,
    );
    Panel::new(&WIDE, ACROSS, 380.0)
        .title(format!("{} stop", map.options.forced.stop.name()))
        .x(
            "angular frequency ω [rad/s]",
            Scale::Logarithmic(x.low, x.high),
        )
        .y("amplitude A [g]", Scale::Linear(y.low, y.high))
        .map(cells)
        .each(CONTOUR, |panel, class| panel.lines(class, contour.clone()))
        .level("lift-edge", map.lift_off_g)
        .level("lift", map.lift_off_g)
        .bar(Bar {
            scale: Scale::Logarithmic(low, high),
            title: "angle [rad]".into(),
            marked: CONTOUR.map(|class| (class, threshold)).to_vec(),
            open: true,
        })
}
