//! Error of the peak against time, one panel per case and stop.

use super::methods;
use crate::cases::BETWEEN_SAMPLES;
use crate::work_precision::{PAPER_STEPS, Row, Status, Truth, WorkPrecision};
use latchgate_document::number::significant;
use latchgate_kernel::range::Range;
use latchgate_report::plot::chart::At::Value;
use latchgate_report::plot::chart::{Chart, Edges, HALVES, Panel, Point, Shape};
use latchgate_report::plot::frame::{LegendEntry, OPEN, Sample, Scale};

/// Factor between the upper edge and the highest point, so that no mark stands on the edge.
const HEADROOM: f64 = 30.0;

/// Error that matters to a verdict [rad]: a hundredth of the usual threshold.
const MATTERS_RAD: f64 = 1e-3;

pub(super) fn chart(result: &WorkPrecision) -> Chart {
    let axes = ranges(result);
    let panels = result.truths.iter().zip(HALVES.into_iter().cycle());
    let notes = [
        "Down is more exact, left is faster. A red mark has failed. Ring: Runge-Kutta 4 at the paper's",
        "step. Dotted: an error that matters to a verdict (0.001 rad), and the bound on the truth's own",
        "error. In the last row the truth is a formula, and the event-driven method follows four",
        "readings of its samples.",
    ];
    Chart {
        name: "work-precision",
        title: "Error of the peak angle against computing time".into(),
        notes: notes.map(String::from).into(),
        legend: drawn(result)
            .into_iter()
            .map(methods::entry)
            .chain(failed(result))
            .collect(),
        panels: panels
            .zip('a'..)
            .map(|((truth, edges), letter)| panel(result, truth, letter, edges, axes))
            .collect(),
        room: [38.0, 104.0, 84.0],
        caption: "Each method at several settings, on each case and stop.".into(),
        description: description(result),
        ..Chart::default()
    }
}

fn description(result: &WorkPrecision) -> String {
    let mut text = String::from(
        "Log-log charts of the error of the peak angle in rad against time as a multiple of the event-driven kernel's.",
    );
    for truth in &result.truths {
        text.push_str(&format!(
            " {}, {} stop: {} impacts, peak {} rad.",
            truth.title,
            truth.model.name(),
            truth.impacts,
            significant(truth.peak_angle_rad, 5)
        ));
    }
    text
}

/// Returns the methods that were run, in the order of the rows.
fn drawn(result: &WorkPrecision) -> Vec<&'static str> {
    let mut methods = Vec::new();
    for row in &result.rows {
        if !methods.contains(&row.method) {
            methods.push(row.method);
        }
    }
    methods
}

/// Returns the marks of the failures that there are.
fn failed(result: &WorkPrecision) -> impl Iterator<Item = LegendEntry> {
    let found = methods::FAILURES.into_iter().filter(|(status, _, _)| {
        let mut rows = result.rows.iter();
        rows.any(|row| row.status == *status)
    });
    found.map(|(_, shape, text)| {
        LegendEntry::new(Sample::Marked(String::new(), "failure".into(), shape), text)
    })
}

/// Returns the ranges of both axes, which all panels share so that they can be compared.
fn ranges(result: &WorkPrecision) -> (Range, Range) {
    let mut times = Range::new(1.0, 1.0);
    let mut errors = Range::new(1e-6, 1.0);
    for row in &result.rows {
        if row.time_ratio.is_finite() && row.time_ratio > 0.0 {
            times = times.including(row.time_ratio);
        }
        if let Some(error) = row.peak_angle_error_rad.filter(|error| *error > 0.0) {
            errors = errors.including(error);
        }
    }
    let decade = |value: f64, round: fn(f64) -> f64| libm::pow(10.0, round(libm::log10(value)));
    (
        // The range ends short of a whole decade, whose label would leave the drawing.
        Range::new(
            decade(times.low, f64::floor).max(1e-3),
            (1.5 * times.high).min(1e6),
        ),
        Range::new(
            decade(errors.low, f64::floor).max(1e-18),
            decade(errors.high.min(1e2) * HEADROOM, f64::ceil),
        ),
    )
}

fn panel(
    result: &WorkPrecision,
    truth: &Truth,
    letter: char,
    edges: Edges,
    (times, errors): (Range, Range),
) -> Panel {
    // The marks of failures without an error, or with a larger one, stand a little below the upper edge.
    let highest = errors.high / HEADROOM;
    let place = |row: &Row| {
        let error = row.peak_angle_error_rad;
        let error = error.map_or(highest, |error| error.clamp(errors.low, highest));
        Point::new(row.time_ratio.clamp(times.low, times.high), error)
    };
    let case_rows = || {
        let rows = result.rows.iter();
        rows.filter(|row| row.case == truth.case && row.model == truth.model)
    };
    let readings = case_rows().filter_map(|row| Some((place(row), reading(row)?)));
    Panel::new(&OPEN, edges, 262.0)
        .title(format!(
            "({letter}) {}, {}",
            truth.title,
            truth.model.name()
        ))
        .x(
            "time over event-driven [–]",
            Scale::Logarithmic(times.low, times.high),
        )
        .y(
            "error of the peak [rad]",
            Scale::Logarithmic(errors.low, errors.high),
        )
        .level("edge", MATTERS_RAD)
        .level("edge", truth.peak_angle_bound_rad)
        .each(drawn(result), |panel, method| {
            let rows = case_rows().filter(|row| row.method == method);
            let on_line = rows.clone().filter(|row| {
                row.peak_angle_error_rad.is_some() && reading(row) != Some("band-limited")
            });
            let right = rows.clone().filter(|row| row.status == Status::Ok);
            let is_paper =
                |row: &&Row| method == "rk4" && row.steps_per_period == Some(PAPER_STEPS);
            let dot = format!("dot dot-{method}");
            panel
                .lines(format!("line {method}"), on_line.map(place))
                .marks(dot, methods::shape(method), right.map(place))
                .each(methods::FAILURES, |panel, (status, shape, _)| {
                    let failed = rows.clone().filter(|row| row.status == status);
                    panel.marks("failure", shape, failed.map(place))
                })
                .marks("ring", Shape::Circle(9.0), rows.filter(is_paper).map(place))
        })
        .each(readings, |panel, (point, text)| {
            panel.text(
                "tiny halo",
                (Value(point.x, 0.0), Value(point.y, 16.0)),
                text,
            )
        })
}

/// Returns the name of the reading of the samples, where readings are compared.
fn reading(row: &Row) -> Option<&'static str> {
    let compared = row.case == BETWEEN_SAMPLES && row.method == "event-driven";
    match row.between.filter(|_| compared)? {
        "linear" => Some("lines"),
        "linear-4" => Some("lines ×4"),
        "linear-16" => Some("lines ×16"),
        other => Some(other),
    }
}
