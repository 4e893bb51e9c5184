//! The section at one amplitude, by the event-driven method and by a fixed step.

use crate::attractor::Attractor;
use latchgate_document::number::{count, significant};
use latchgate_kernel::range::Range;
use latchgate_report::plot::axis::Axis;
use latchgate_report::plot::chart::At::{High, Low};
use latchgate_report::plot::chart::{Chart, Edges, HALVES, Panel, Point, Points, Shape, WHOLE};
use latchgate_report::plot::frame::{OPEN, Scale, range};
use latchgate_report::plot::raster::{BLUE, ORANGE};
use std::collections::BTreeSet;

/// Height of a panel.
const HEIGHT: f64 = 330.0;

/// Returns the section at one amplitude: for each stop that of the event-driven method, and beside it that of the
/// fixed-step method.
pub(super) fn chart(attractors: &[Attractor]) -> Chart {
    let compared = attractors
        .iter()
        .any(|a| a.options.compared_steps.is_some());
    let notes = notes(attractors, compared);
    let mut description = String::from("Angular velocity against angle once a period.");
    let mut panels = Vec::new();
    for attractor in attractors {
        let summary = summary(attractor);
        let stop = attractor.options.forced.stop.name();
        description.push_str(&format!(" {stop} stop: {summary}."));
        let edges = if compared { HALVES[0] } else { WHOLE };
        panels.push(panel(attractor, "event-driven", &summary, edges));
        if let Some(steps) = attractor.options.compared_steps {
            let name = format!("RK4, {} steps a period", count(u64::from(steps)));
            panels.push(panel(attractor, "rk4", &name, HALVES[1]));
        }
    }
    Chart {
        name: "attractor",
        title: attractors.first().map(title).unwrap_or_default(),
        caption: notes.join(" "),
        notes,
        panels,
        // Beside a second panel the words need a line more.
        room: if compared {
            [48.0, 96.0, 56.0]
        } else {
            [30.0, 78.0, 56.0]
        },
        description,
        ..Chart::default()
    }
}

fn title(attractor: &Attractor) -> String {
    let Range { low, high } = attractor.options.amplitudes_g;
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

/// Largest number of points of a section drawn as marks, since a few small dots would be overlooked.
const FEW: usize = 1000;

/// Number of points from which on a section is a cloud of the smallest dots.
const MANY: usize = 8000;

/// Returns the section by one method.
fn panel(attractor: &Attractor, method: &str, name: &str, edges: Edges) -> Panel {
    // All methods share one scale, so that they can be compared.
    let rows = attractor.rows.iter();
    let x = range(rows.clone().map(|row| row.angle_rad), 0.06);
    let y = range(rows.clone().map(|row| row.angular_velocity_rad_s), 0.06);
    let points: Points = rows
        .filter(|row| row.method == method)
        .map(|row| Point::new(row.angle_rad, row.angular_velocity_rad_s))
        .collect();
    let distinct = distinct(&points, x, y, edges);
    let (class, colour) = match method {
        "rk4" => ("few-rk4", ORANGE),
        _ => ("few-event-driven", BLUE),
    };
    let panel = Panel::new(&OPEN, edges, HEIGHT)
        .x("angle [rad]", x)
        .y("angular velocity [rad/s]", y);
    let panel = if distinct.len() <= FEW {
        let radius = if distinct.len() > 100 { 2.2 } else { 3.5 };
        panel.marks(class, Shape::Circle(radius), distinct)
    } else {
        let dot = if distinct.len() < MANY { 5 } else { 2 };
        panel.cloud(colour, points, dot)
    };
    let orbit = attractor.orbit.iter().filter(|_| method == "event-driven");
    let panel = panel.each(orbit, |panel, orbit| {
        let points = orbit.points.iter();
        let points = points.map(|state| Point::new(state.angle_rad, state.velocity_rad_s));
        panel.marks("ring", Shape::Circle(7.0), points)
    });
    let stop = attractor.options.forced.stop.name();
    if edges == WHOLE {
        return panel.title(format!("{stop} stop: {name}"));
    }
    // A panel that has another beside it is narrow: the words stand below the title, long ones in small
    // letters.
    let class = if name.chars().count() > 46 {
        "tiny"
    } else {
        ""
    };
    panel
        .text("strong", (Low(1.0), High(-27.0)), format!("{stop} stop"))
        .text(class, (Low(1.0), High(-9.0)), name)
}

/// Returns the visible points, one of those that share a square of a quarter unit, [`MANY`] at most.
fn distinct(points: &Points, x: Scale, y: Scale, edges: Edges) -> Points {
    let x = Axis::new(x, edges.left, edges.right);
    let y = Axis::new(y, HEIGHT, 0.0);
    let mut used_cells: BTreeSet<(i64, i64)> = BTreeSet::new();
    let quarter = |place: f64| (4.0 * place).round() as i64;
    let mut is_new =
        |point: &Point| used_cells.insert((quarter(x.place(point.x)), quarter(y.place(point.y))));
    let shown = points.iter().copied();
    let shown = shown.filter(|point| x.contains(point.x) && y.contains(point.y));
    shown.filter(|point| is_new(point)).take(MANY).collect()
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
