//! The section at one amplitude, by the mechanics and by a fixed step.

use super::dynamics::{empty, widened};
use crate::attractor::Attractor;
use latchgate_document::number::{count, significant};
use latchgate_report::plot::axis::Axis;
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{Frame, LEFT, PanelPlace, extent, header};
use latchgate_report::plot::raster::{self, BLUE, ORANGE};
use latchgate_report::plot::{Figure, WIDTH};
use std::collections::BTreeSet;

/// Draws the section at one amplitude: for each stop what the mechanics do, and beside it what the
/// fixed-step method makes of it.
pub(super) fn draw(attractors: &[Attractor]) -> Figure {
    const HEIGHT: f64 = 330.0;
    const GAP: f64 = 74.0;
    let mut canvas = Canvas::with_capacity(512 * 1024);
    let Some(first) = attractors.first() else {
        return empty("attractor");
    };
    let title = title(first);
    let compared = attractors
        .iter()
        .any(|a| a.options.compared_steps.is_some());
    let lines = notes(attractors, compared);
    let mut top = header(&mut canvas, LEFT, &title, &lines, &[]);
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
        let place = |left: f64| (left, left + width, top, top + HEIGHT);
        let summary = summary(attractor);
        panel(
            &mut canvas,
            attractor,
            "event-driven",
            &summary,
            place(LEFT),
        );
        if let Some(steps) = attractor.options.compared_steps {
            let name = format!("RK4, {} steps a period", count(u64::from(steps)));
            panel(
                &mut canvas,
                attractor,
                "rk4",
                &name,
                place(LEFT + width + GAP),
            );
        }
        let stop = attractor.options.forced.stop.name();
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

fn title(attractor: &Attractor) -> String {
    let (low, high) = attractor.options.amplitudes_g;
    let amplitude = if attractor.options.amplitudes() > 1 {
        format!("{low} to {high}")
    } else {
        low.to_string()
    };
    format!(
        "Stroboscopic section, A = {amplitude} g, ω = {} rad/s",
        attractor.options.forced.angular_frequency_rad_s
    )
}

fn notes(attractors: &[Attractor], compared: bool) -> Vec<String> {
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
    lines
}

/// Draws the section that one method finds.
fn panel(canvas: &mut Canvas, attractor: &Attractor, method: &str, name: &str, place: PanelPlace) {
    // One scale for all methods, so that they can be compared.
    let angles = extent(attractor.rows.iter().map(|row| row.angle_rad));
    let velocities = extent(attractor.rows.iter().map(|row| row.angular_velocity_rad_s));
    let panel = Frame::open(place, widened(angles, 0.06), widened(velocities, 0.06));
    let stop = attractor.options.forced.stop.name();
    title_of(canvas, panel.corner(), panel.size().0, stop, name);
    panel.grid(
        canvas,
        Some("angle [rad]"),
        Some("angular velocity [rad/s]"),
    );
    let rows: Vec<(f64, f64)> = attractor
        .rows
        .iter()
        .filter(|row| row.method == method)
        .map(|row| (row.angle_rad, row.angular_velocity_rad_s))
        .collect();
    let places = places(&rows, &panel.x, &panel.y);
    if places.len() <= FEW {
        let radius = if places.len() > 100 { 2.2 } else { 3.5 };
        for at in places {
            canvas.circle(&format!("few-{method}"), at, radius);
        }
    } else {
        let dot = if places.len() < MANY { 5 } else { 2 };
        let colour = if method == "rk4" { ORANGE } else { BLUE };
        let points = rows.iter().copied();
        if let Some(png) = raster::cloud(points, &panel.x, &panel.y, panel.size(), dot, colour) {
            canvas.png(&png, panel.corner(), panel.size());
        }
    }
    if method == "event-driven"
        && let Some(orbit) = &attractor.orbit
    {
        for point in &orbit.points {
            canvas.circle("ring", panel.place(point.0, point.1), 7.0);
        }
    }
    panel.frame(canvas);
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
