//! Charts of the lever's motion on sines: diagrams over the amplitude, sections, basins, and what
//! excitation opens.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas};
use super::colour::viridis;
use super::panel::{LEFT, Panel, RIGHT};
use super::raster::{self, BLUE, ORANGE};
use super::{Figure, WIDTH};
use crate::report::number::{count, significant, trimmed};
use crate::study::attractor::Attractor;
use crate::study::basins::Basins;
use crate::study::bifurcation::Diagram;
use crate::study::excitation_map::ExcitationMap;
use crate::study::orbit::Kind;
use std::collections::BTreeSet;

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

/// Widens a stretch by a part of it at both ends.
fn widened((low, high): (f64, f64), part: f64) -> (f64, f64) {
    if low.is_finite() && high > low {
        let room = part * (high - low);
        (low - room, high + room)
    } else if low.is_finite() {
        (low - 1.0, low + 1.0)
    } else {
        (0.0, 1.0)
    }
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
}

fn heading(canvas: &mut Canvas, title: &str, lines: &[String]) -> f64 {
    canvas.text("title", (LEFT, 24.0), Anchor::Start, title);
    let mut y = 24.0;
    for line in lines {
        y += 20.0;
        canvas.text("muted", (LEFT, y), Anchor::Start, line);
    }
    y + 16.0
}

fn cloud_panel(
    canvas: &mut Canvas,
    panel: &Panel,
    points: impl Iterator<Item = (f64, f64)>,
    dot: usize,
    colour: raster::Colour,
) {
    let size = (RIGHT - LEFT, panel.bottom - panel.top);
    if let Some(png) = raster::cloud(points, &panel.x, &panel.y, size, dot, colour) {
        canvas.png(&png, (LEFT, panel.top), size);
    }
}

/// Draws sections against the amplitude, one panel per stop, with births and doublings.
pub(super) fn bifurcation(diagrams: &[Diagram]) -> Figure {
    const HEIGHT: f64 = 330.0;
    let mut canvas = Canvas::with_capacity(512 * 1024);
    let Some(first) = diagrams.first() else {
        return empty("bifurcation");
    };
    let omega = first.options.rig.angular_frequency_rad_s;
    let title = format!("Stroboscopic sections against amplitude, ω = {omega} rad/s");
    let mut lines = vec![
        "State at the start of each period of the excitation; the darker, the more points.".into(),
    ];
    lines.extend(marks(diagrams));
    let mut top = heading(&mut canvas, &title, &lines);
    let amplitudes = first.options.amplitudes_g;
    // One scale for all, so that the stops can be compared.
    let velocities = widened(
        span(
            diagrams
                .iter()
                .flat_map(|diagram| &diagram.columns)
                .flat_map(|column| &column.sections)
                .map(|section| section.velocity_rad_s),
        ),
        0.04,
    );
    let mut description = String::new();
    for diagram in diagrams {
        top += 30.0;
        let stop = diagram.options.rig.stop.name();
        let rows = diagram.rows();
        let panel = Panel::linear(amplitudes, velocities, top, top + HEIGHT);
        canvas.text(
            "strong",
            (LEFT, top - 9.0),
            Anchor::Start,
            &format!("{stop} stop"),
        );
        panel.grid(
            &mut canvas,
            Some("amplitude A [g]"),
            "angular velocity [rad/s]",
        );
        let dot = (2000 / diagram.columns.len().max(1)).clamp(2, 6);
        let points = rows
            .iter()
            .map(|row| (row.amplitude_g, row.angular_velocity_rad_s));
        cloud_panel(&mut canvas, &panel, points, dot, BLUE);
        for found in diagram.found() {
            let x = panel.x.place(found.orbit.amplitude_g);
            let (class, height) = match found.kind {
                Kind::SaddleNode => ("birth", 26.0),
                Kind::PeriodDoubling => ("doubling", 13.0),
            };
            if panel.x.contains(found.orbit.amplitude_g) {
                canvas.line(class, (x, panel.bottom - height), (x, panel.bottom));
            }
        }
        panel.frame(&mut canvas);
        description.push_str(&format!(
            " {stop} stop: {} points at {} amplitudes, {} births and doublings.",
            rows.len(),
            diagram.columns.len(),
            diagram.found().count()
        ));
        top += HEIGHT + 44.0;
    }
    Figure {
        name: "bifurcation",
        title,
        caption: lines.join(" "),
        description: format!("Scatter of angular velocity against amplitude.{description}"),
        height: top + 8.0,
        body: canvas.into_string(),
    }
}

/// Explains the marks at the foot of the panels, if there are any.
fn marks(diagrams: &[Diagram]) -> Option<String> {
    let (low, high) = diagrams.first()?.options.amplitudes_g;
    let shown = |kind: Kind| {
        diagrams
            .iter()
            .flat_map(Diagram::found)
            .any(|found| found.kind == kind && (low..=high).contains(&found.orbit.amplitude_g))
    };
    let birth =
        shown(Kind::SaddleNode).then_some("Long green marks at the foot: an orbit is born.");
    let doubling =
        shown(Kind::PeriodDoubling).then_some("Short red marks at the foot: a period doubles.");
    let words: Vec<&str> = birth.into_iter().chain(doubling).collect();
    (!words.is_empty()).then(|| words.join(" "))
}

fn empty(name: &'static str) -> Figure {
    Figure {
        name,
        title: "nothing computed".into(),
        caption: String::new(),
        description: "nothing computed".into(),
        height: 60.0,
        body: String::new(),
    }
}

/// Draws the section at one amplitude: for each stop what the mechanics do, and beside it what the
/// fixed-step method makes of it.
pub(super) fn attractor(attractors: &[Attractor]) -> Figure {
    const HEIGHT: f64 = 330.0;
    const GAP: f64 = 74.0;
    let mut canvas = Canvas::with_capacity(512 * 1024);
    let Some(first) = attractors.first() else {
        return empty("attractor");
    };
    let (low, high) = first.options.amplitudes_g;
    let amplitude = if first.options.points > 1 {
        format!("{low} to {high}")
    } else {
        low.to_string()
    };
    let title = format!(
        "Stroboscopic section, A = {amplitude} g, ω = {} rad/s",
        first.options.rig.angular_frequency_rad_s
    );
    let compared = attractors
        .iter()
        .any(|a| a.options.compared_steps.is_some());
    let mut line =
        String::from("State at the start of each period of the excitation, after the transient.");
    let mut lines = Vec::new();
    if compared {
        lines.push(std::mem::take(&mut line));
        line.push_str("Left: event-driven. Right: Runge-Kutta of fixed step, impacts on its grid.");
    }
    if attractors.iter().any(|a| a.orbit.is_some()) {
        line.push_str(" Rings: the periodic orbit.");
    }
    lines.push(line);
    let mut top = heading(&mut canvas, &title, &lines);
    let right = WIDTH - 24.0;
    let width = if compared {
        0.5 * (right - LEFT - GAP)
    } else {
        right - LEFT
    };
    let mut description = String::new();
    for attractor in attractors {
        // Beside a second panel the words take a line of their own.
        top += if compared { 48.0 } else { 30.0 };
        let stop = attractor.options.rig.stop.name();
        let angles = widened(span(attractor.rows.iter().map(|row| row.angle_rad)), 0.06);
        let velocities = widened(
            span(attractor.rows.iter().map(|row| row.angular_velocity_rad_s)),
            0.06,
        );
        let summary = summary(attractor);
        let canvas = &mut canvas;
        let mut draw = |left: f64, method: &str, name: &str, colour: raster::Colour| {
            let bottom = top + HEIGHT;
            let x = Axis::linear(angles.0, angles.1, left, left + width);
            let y = Axis::linear(velocities.0, velocities.1, bottom, top);
            title_of(canvas, (left, top), width, stop, name);
            super::series::grid(canvas, &x, &y, (left, left + width), (top, bottom));
            let rows: Vec<(f64, f64)> = attractor
                .rows
                .iter()
                .filter(|row| row.method == method)
                .map(|row| (row.angle_rad, row.angular_velocity_rad_s))
                .collect();
            let size = (width, HEIGHT);
            let places = places(&rows, &x, &y);
            if places.len() <= FEW {
                let radius = if places.len() > 100 { 2.2 } else { 3.5 };
                for at in places {
                    canvas.circle(&format!("few-{method}"), at, radius);
                }
            } else {
                let dot = if places.len() < MANY { 5 } else { 2 };
                let points = rows.iter().copied();
                if let Some(png) = raster::cloud(points, &x, &y, size, dot, colour) {
                    canvas.png(&png, (left, top), size);
                }
            }
            if method == "event-driven"
                && let Some(orbit) = &attractor.orbit
            {
                for point in &orbit.points {
                    canvas.circle("ring", (x.place(point.0), y.place(point.1)), 7.0);
                }
            }
            canvas.rectangle("frame", (left, top), size);
            canvas.text(
                "",
                (left + 0.5 * width, bottom + 40.0),
                Anchor::Middle,
                "angle [rad]",
            );
            canvas.upward_text(
                "",
                (left - 60.0, f64::midpoint(top, bottom)),
                "angular velocity [rad/s]",
            );
        };
        draw(LEFT, "event-driven", &summary, BLUE);
        if let Some(steps) = attractor.options.compared_steps {
            let name = format!("RK4, {} steps a period", count(u64::from(steps)));
            draw(LEFT + width + GAP, "rk4", &name, ORANGE);
        }
        description.push_str(&format!(" {stop} stop: {summary}."));
        top += HEIGHT + 48.0;
    }
    Figure {
        name: "attractor",
        title,
        caption: lines.join(" "),
        description: format!("Angular velocity against angle once a period.{description}"),
        height: top + 8.0,
        body: canvas.into_string(),
    }
}

/// Writes which stop a panel shows, and what was found there: behind it, or, in a panel of half the
/// width, below it.
fn title_of(canvas: &mut Canvas, corner: (f64, f64), width: f64, stop: &str, name: &str) {
    let (left, top) = corner;
    if width > 0.5 * WIDTH {
        let text = format!("{stop} stop: {name}");
        canvas.text("strong", (left, top - 9.0), Anchor::Start, &text);
    } else {
        let text = format!("{stop} stop");
        canvas.text("strong", (left, top - 27.0), Anchor::Start, &text);
        // Long ones are still inside the panel's width in small letters.
        let class = if name.chars().count() > 46 {
            "tiny"
        } else {
            ""
        };
        canvas.text(class, (left, top - 9.0), Anchor::Start, name);
    }
}

/// Places up to which a section is drawn point by point: small dots would be overlooked.
const FEW: usize = 1000;

/// Places from which on a section is a cloud of the smallest dots.
const MANY: usize = 8000;

/// Returns where points lie, those within a quarter of a unit once, [`MANY`] at most.
fn places(points: &[(f64, f64)], x: &Axis, y: &Axis) -> Vec<(f64, f64)> {
    let mut taken: BTreeSet<(i64, i64)> = BTreeSet::new();
    points
        .iter()
        .filter(|(px, py)| x.contains(*px) && y.contains(*py))
        .map(|(px, py)| (x.place(*px), y.place(*py)))
        .filter(|at| taken.insert(((4.0 * at.0).round() as i64, (4.0 * at.1).round() as i64)))
        .take(MANY)
        .collect()
}

fn summary(attractor: &Attractor) -> String {
    if let Some(orbit) = &attractor.orbit {
        let how = if attractor.superstable {
            ", through rest"
        } else {
            ""
        };
        return format!("period {}{how}", orbit.period);
    }
    if let Some(growth) = &attractor.growth {
        return growth.lyapunov().map_or_else(
            || {
                let what = match (growth.rests, growth.returned) {
                    (0, None) => "differences die out".into(),
                    (_, None) => "rests now and then".into(),
                    (_, Some(periods)) => format!("digits repeat after {periods}"),
                };
                format!(
                    "no period can be told ({what}); rounding grows by {} decades",
                    significant(growth.decades_max, 2)
                )
            },
            |exponent| {
                format!(
                    "Lyapunov exponent {} per period, 95 % interval ±{}",
                    significant(exponent, 3),
                    significant(1.96 * growth.standard_error, 2)
                )
            },
        );
    }
    attractor.statistics.map_or_else(
        || "event-driven".into(),
        |statistics| {
            format!(
                "{} of {} amplitudes with a period",
                statistics.periodic, statistics.amplitudes
            )
        },
    )
}

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
pub(super) fn basins(all: &[Basins]) -> Figure {
    const HEIGHT: f64 = 400.0;
    let mut canvas = Canvas::with_capacity(1024 * 1024);
    let Some(first) = all.first() else {
        return empty("basins");
    };
    let title = format!(
        "Basins of attraction, A = {} g, ω = {} rad/s",
        first.options.amplitude_g, first.options.rig.angular_frequency_rad_s
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
    let mut top = heading(&mut canvas, &title, &lines);
    let mut description = String::new();
    for basins in all {
        top += 30.0;
        let stop = basins.options.rig.stop.name();
        canvas.text(
            "strong",
            (LEFT, top - 9.0),
            Anchor::Start,
            &format!("{stop} stop"),
        );
        let mut x = LEFT + 110.0;
        for attractor in &basins.attractors {
            let share = attractor.share.map_or_else(
                || "share not known, interrupted".into(),
                |share| format!("{} %", significant(100.0 * share, 4)),
            );
            let text = format!("{}: {share}", attractor.name);
            let [r, g, b] = basin_colour(attractor.index);
            if let Some(png) = raster::encode(&[r, g, b], 1, 1) {
                canvas.png(&png, (x, top - 21.0), (22.0, 13.0));
            }
            canvas.text("", (x + 29.0, top - 9.0), Anchor::Start, &text);
            let width = 29.0 + text.chars().count() as f64 * 7.6 + 20.0;
            x += width;
            description.push_str(&format!(" {stop} stop, {text}."));
        }
        let panel = Panel::linear(
            basins.options.angle_rad,
            basins.options.velocity_rad_s,
            top,
            top + HEIGHT,
        );
        panel.grid(
            &mut canvas,
            Some("initial angle [rad]"),
            "initial angular velocity [rad/s]",
        );
        let (mut columns, mut rows) = (
            basins.options.grid.0 as usize,
            basins.options.grid.1 as usize,
        );
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
        if let Some(png) = raster::encode(&pixels, columns, rows) {
            canvas.png(&png, (LEFT, top), (RIGHT - LEFT, HEIGHT));
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

/// Draws the largest angle over amplitude and frequency with the threshold's contour.
pub(super) fn excitation_map(maps: &[ExcitationMap]) -> Figure {
    const HEIGHT: f64 = 380.0;
    let mut canvas = Canvas::with_capacity(512 * 1024);
    let Some(first) = maps.first() else {
        return empty("excitation-map");
    };
    let threshold = first.options.rig.design.criterion.threshold_rad;
    let scale = Scale::around(threshold);
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
    let mut top = heading(&mut canvas, &title, &lines);
    let mut description = String::new();
    for map in maps {
        top += 30.0;
        let stop = map.options.rig.stop.name();
        canvas.text(
            "strong",
            (LEFT, top - 9.0),
            Anchor::Start,
            &format!("{stop} stop"),
        );
        let bottom = top + HEIGHT;
        let (low, high) = map.options.angular_frequencies_rad_s;
        let panel = Panel {
            top,
            bottom,
            x: Axis::logarithmic(low, high, LEFT, RIGHT),
            y: Axis::linear(
                map.options.amplitudes_g.0,
                map.options.amplitudes_g.1,
                bottom,
                top,
            ),
        };
        panel.grid(
            &mut canvas,
            Some("angular frequency ω [rad/s]"),
            "amplitude A [g]",
        );
        let (amplitudes, lines) = (map.options.grid.0 as usize, map.options.grid.1 as usize);
        let mut pixels = vec![0_u8; 3 * amplitudes * lines];
        for (index, row) in map.rows.iter().enumerate() {
            let (column, line) = (index / amplitudes, index % amplitudes);
            let share = scale.share(row.peak_angle_rad);
            let at = 3 * ((amplitudes - 1 - line) * lines + column);
            pixels[at..at + 3].copy_from_slice(&viridis(share));
        }
        if let Some(png) = raster::encode(&pixels, lines, amplitudes) {
            canvas.png(&png, (LEFT, top), (RIGHT - LEFT, HEIGHT));
        }
        for class in ["contour", "contour-ink"] {
            canvas.polyline(
                class,
                map.boundary.iter().map(|at| {
                    (
                        panel.x.place(at.angular_frequency_rad_s),
                        at.amplitude_g.map_or(f64::NAN, |a| panel.y.place(a)),
                    )
                }),
            );
        }
        if panel.y.contains(map.lift_off_g) {
            let y = panel.y.place(map.lift_off_g);
            canvas.line("lift-edge", (LEFT, y), (RIGHT, y));
            canvas.line("lift", (LEFT, y), (RIGHT, y));
        }
        panel.frame(&mut canvas);
        bar(&mut canvas, &panel, threshold, &scale);
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

/// A colour scale by decades; what lies beyond an end has the end's colour.
struct Scale {
    low: f64,
    high: f64,
}

impl Scale {
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

fn bar(canvas: &mut Canvas, panel: &Panel, threshold: f64, scale: &Scale) {
    let steps: Vec<u8> = (0..64)
        .rev()
        .flat_map(|step| viridis((f64::from(step) + 0.5) / 64.0))
        .collect();
    let corner = (RIGHT + 10.0, panel.top);
    let size = (14.0, panel.bottom - panel.top);
    if let Some(png) = raster::encode(&steps, 1, 64) {
        canvas.png(&png, corner, size);
    }
    canvas.rectangle("frame", corner, size);
    let axis = Axis::logarithmic(scale.low, scale.high, panel.bottom, panel.top);
    for tick in axis.ticks(46.0, 0.0) {
        if tick.label.is_empty() {
            continue;
        }
        // Both ends hold all beyond them.
        let share = scale.share(tick.value);
        let label = if share > 0.999 {
            format!("≥ {}", trimmed(tick.value, 3))
        } else if share < 0.001 {
            format!("≤ {}", tick.label)
        } else {
            tick.label
        };
        let y = axis.place(tick.value);
        canvas.line("tick", (RIGHT + 24.0, y), (RIGHT + 29.0, y));
        canvas.text("muted", (RIGHT + 33.0, y + 5.0), Anchor::Start, &label);
    }
    let y = axis.place(threshold);
    for class in ["contour", "contour-ink"] {
        canvas.line(class, (corner.0, y), (corner.0 + size.0, y));
    }
    canvas.text(
        "",
        (RIGHT + 10.0, panel.top - 12.0),
        Anchor::Start,
        "angle [rad]",
    );
}
