//! What amplitude and frequency open the latch, one panel per stop.

use super::dynamics::empty;
use crate::excitation_map::ExcitationMap;
use latchgate_document::number::{significant, trimmed};
use latchgate_report::plot::axis::Tick;
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{Frame, LEFT, RIGHT, Scale, header};
use latchgate_report::plot::{Figure, heat};

/// Draws the largest angle over amplitude and frequency with the threshold's contour.
pub(super) fn draw(maps: &[ExcitationMap]) -> Figure {
    const HEIGHT: f64 = 380.0;
    let mut canvas = Canvas::with_capacity(512 * 1024);
    let Some(first) = maps.first() else {
        return empty("excitation-map");
    };
    let threshold = first.options.forced.design.criterion.threshold_rad;
    let colours = ColourScale::around(threshold);
    let title = "What excitation opens the latch".to_string();
    let lines = [
        format!(
            "Colour: largest angle from rest within {} periods. White dashes: lift-off at A = {} g.",
            first.options.periods,
            significant(first.lift_off_g, 5)
        ),
        format!(
            "Red: below it no amplitude of the grid passes {threshold} rad; where it lies between two is found by halving."
        ),
        "Where motion is chaotic, amplitudes between those of the grid may pass it earlier.".into(),
    ];
    let mut top = header(&mut canvas, LEFT, &title, &lines, &[]);
    let mut description = String::new();
    for map in maps {
        top += 30.0;
        let stop = map.options.forced.stop.name();
        let (frequencies, amplitudes) = (
            map.options.angular_frequencies_rad_s,
            map.options.amplitudes_g,
        );
        let panel = Frame::wide(
            (top, top + HEIGHT),
            Scale::Logarithmic(frequencies.0, frequencies.1),
            Scale::Linear(amplitudes.0, amplitudes.1),
        );
        panel.title(&mut canvas, &format!("{stop} stop"));
        panel.grid(
            &mut canvas,
            Some("angular frequency ω [rad/s]"),
            Some("amplitude A [g]"),
        );
        draw_map(&mut canvas, &panel, map, &colours);
        panel.frame(&mut canvas);
        bar(&mut canvas, &panel, threshold, &colours);
        let least = map
            .boundary
            .iter()
            .filter_map(|at| at.amplitude_g)
            .fold(f64::INFINITY, f64::min);
        description.push_str(&format!(
            " {stop} stop: least amplitude of the contour {} g.",
            trimmed(least, 5)
        ));
        top += HEIGHT + 48.0;
    }
    Figure {
        name: "excitation-map",
        title,
        caption: lines.join(" "),
        description: format!("Map of the largest angle over amplitude and frequency.{description}"),
        height: top + 8.0,
        body: canvas.into_string(),
    }
}

/// Draws the largest angles, the threshold's contour and the lift-off.
fn draw_map(canvas: &mut Canvas, panel: &Frame, map: &ExcitationMap, colours: &ColourScale) {
    let (amplitudes, frequencies) = (map.options.grid.0 as usize, map.options.grid.1 as usize);
    let cells = heat::cells((frequencies, amplitudes), |column, line| {
        let row = map.rows.get(column * amplitudes + line)?;
        Some(colours.share(row.peak_angle_rad))
    });
    if let Some(png) = cells {
        canvas.png(&png, panel.corner(), panel.size());
    }
    for class in ["contour", "contour-ink"] {
        canvas.polyline(
            class,
            map.boundary.iter().map(|at| {
                panel.place(
                    at.angular_frequency_rad_s,
                    at.amplitude_g.unwrap_or(f64::NAN),
                )
            }),
        );
    }
    panel.level(canvas, "lift-edge", map.lift_off_g);
    panel.level(canvas, "lift", map.lift_off_g);
}

/// A colour scale by decades; what lies beyond an end has the end's colour.
struct ColourScale {
    low: f64,
    high: f64,
}

impl ColourScale {
    /// Four decades, the threshold within the upper two.
    fn around(threshold: f64) -> Self {
        let decade = libm::log10(threshold).round();
        Self {
            low: libm::pow(10.0, decade - 3.0),
            high: libm::pow(10.0, decade + 1.0),
        }
    }

    fn share(&self, value: f64) -> f64 {
        if value > self.low {
            libm::log10(value / self.low) / libm::log10(self.high / self.low)
        } else {
            0.0
        }
    }
}

/// Draws the bar of the colours with the threshold on it.
fn bar(canvas: &mut Canvas, panel: &Frame, threshold: f64, colours: &ColourScale) {
    let left = RIGHT + 10.0;
    let scale = Scale::Logarithmic(colours.low, colours.high);
    // Both ends hold all beyond them.
    let label = |tick: &Tick| match colours.share(tick.value) {
        share if share > 0.999 => format!("≥ {}", trimmed(tick.value, 3)),
        share if share < 0.001 => format!("≤ {}", tick.label),
        _ => tick.label.clone(),
    };
    let place = (left, panel.top, panel.bottom);
    if let Some(axis) = heat::colour_bar(canvas, place, scale, label) {
        let y = axis.place(threshold);
        for class in ["contour", "contour-ink"] {
            canvas.line(class, (left, y), (left + 14.0, y));
        }
    }
    let unit = (left, panel.top - 12.0);
    canvas.text("", unit, Anchor::Start, "angle [rad]");
}
