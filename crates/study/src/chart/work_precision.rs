//! Error of the peak against time, one panel per case and stop.

use super::methods;
use crate::cases::BETWEEN_SAMPLES;
use crate::work_precision::{PAPER_STEPS, Row, Status, Truth, WorkPrecision};
use latchgate_document::number::significant;
use latchgate_report::plot::Figure;
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{Frame, LegendEntry, Scale, header};

const NAME: &str = "work-precision";

/// Left edges and width of the two columns of panels.
const COLUMNS: [f64; 2] = [74.0, 516.0];
const PANEL_WIDTH: f64 = 366.0;
const PANEL_HEIGHT: f64 = 262.0;
const ROW_HEIGHT: f64 = 366.0;

/// Factor between the upper edge and the highest point, so that no mark stands on the edge.
const HEADROOM: f64 = 30.0;

/// The error that matters to a verdict: a hundredth of the usual threshold [rad].
const MATTERS_RAD: f64 = 1e-3;

pub(super) fn draw(result: &WorkPrecision) -> Figure {
    let mut canvas = Canvas::with_capacity(64 * 1024);
    let title = "Error of the peak angle against computing time";
    let notes = [
        "Down is more exact, left is faster. A red cross has failed: u unstable, t tunnelled, m missed".into(),
        "impacts, x impacts too many; ring: rk4 at the paper's step; dotted: an error that matters to a".into(),
        "verdict (0.001 rad), and the bound on the truth's own error. In the last row the truth is a".into(),
        "formula, and the event-driven method follows four readings of its samples.".into(),
    ];
    let entries: Vec<LegendEntry> = drawn(result).into_iter().map(methods::entry).collect();
    let top = header(&mut canvas, COLUMNS[0], title, &notes, &entries) + 38.0;
    let (times, errors) = ranges(result);
    for (index, truth) in result.truths.iter().enumerate() {
        let corner = (COLUMNS[index % 2], top + (index / 2) as f64 * ROW_HEIGHT);
        panel(&mut canvas, result, truth, corner, times, errors);
    }
    let rows = result.truths.len().div_ceil(2);
    Figure {
        name: NAME,
        title: title.into(),
        caption: "Each method at several settings, on each case and stop.".into(),
        description: description(result),
        height: top - 20.0 + rows as f64 * ROW_HEIGHT,
        body: canvas.into_string(),
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

/// The same axes for every panel, so that panels compare.
fn ranges(result: &WorkPrecision) -> ((f64, f64), (f64, f64)) {
    let mut times = (1.0_f64, 1.0_f64);
    let mut errors = (1e-6_f64, 1.0_f64);
    for row in &result.rows {
        if row.time_ratio.is_finite() && row.time_ratio > 0.0 {
            times = (times.0.min(row.time_ratio), times.1.max(row.time_ratio));
        }
        if let Some(error) = row.peak_angle_error_rad.filter(|error| *error > 0.0) {
            errors = (errors.0.min(error), errors.1.max(error));
        }
    }
    let decade = |value: f64, round: fn(f64) -> f64| libm::pow(10.0, round(libm::log10(value)));
    (
        // Not up to a whole decade, whose label would stand out of the drawing.
        (
            decade(times.0, f64::floor).max(1e-3),
            (1.5 * times.1).min(1e6),
        ),
        (
            decade(errors.0, f64::floor).max(1e-18),
            decade(errors.1.min(1e2) * HEADROOM, f64::ceil),
        ),
    )
}

fn panel(
    canvas: &mut Canvas,
    result: &WorkPrecision,
    truth: &Truth,
    (left, top): (f64, f64),
    times: (f64, f64),
    errors: (f64, f64),
) {
    let panel = Frame::open(
        (left, left + PANEL_WIDTH, top, top + PANEL_HEIGHT),
        Scale::Logarithmic(times.0, times.1),
        Scale::Logarithmic(errors.0, errors.1),
    );
    panel.title(
        canvas,
        &format!("{}, {} stop", truth.title, truth.model.name()),
    );
    panel.grid(
        canvas,
        Some("time over event-driven [–]"),
        Some("error of the peak [rad]"),
    );
    for level in [MATTERS_RAD, truth.peak_angle_bound_rad] {
        panel.level(canvas, "edge", level);
    }
    // Failures that have no error, or a larger one, stand a little below the upper edge.
    let highest = panel.y.high() / HEADROOM;
    let place = |row: &Row| {
        let error = row
            .peak_angle_error_rad
            .map_or(highest, |error| error.clamp(errors.0, highest));
        panel.place(row.time_ratio.clamp(times.0, times.1), error)
    };
    let own = || {
        result
            .rows
            .iter()
            .filter(|row| row.case == truth.case && row.model == truth.model)
    };
    let mut failures = Vec::new();
    for method in drawn(result) {
        let rows = || own().filter(|row| row.method == method);
        canvas.polyline(
            &format!("line {method}"),
            rows()
                .filter(|row| row.peak_angle_error_rad.is_some())
                .filter(|row| reading(row) != Some("band-limited"))
                .map(place),
        );
        for row in rows() {
            let at = place(row);
            if row.status == Status::Ok {
                methods::point(canvas, method, at);
            } else {
                methods::cross(canvas, at);
                failures.push((at, letter(row.status)));
            }
            if let Some(text) = reading(row) {
                canvas.text("tiny halo", (at.0, at.1 + 16.0), Anchor::Middle, text);
            }
            if method == "rk4" && row.steps_per_period == Some(PAPER_STEPS) {
                canvas.circle("ring", at, 9.0);
            }
        }
    }
    letters(canvas, &failures);
    panel.frame(canvas);
}

/// Names the reading of the samples, where readings are compared.
fn reading(row: &Row) -> Option<&'static str> {
    let compared = row.case == BETWEEN_SAMPLES && row.method == "event-driven";
    match row.between.filter(|_| compared)? {
        "linear" => Some("lines"),
        "linear-4" => Some("lines ×4"),
        "linear-16" => Some("lines ×16"),
        other => Some(other),
    }
}

/// Writes the letter of each failure where neither a cross nor another letter stands.
fn letters(canvas: &mut Canvas, failures: &[((f64, f64), &str)]) {
    /// Half of a letter's width and height, and of a cross's, with a little air.
    const LETTER_HALF: (f64, f64) = (4.0, 5.0);
    const CROSS_HALF: f64 = 4.0;
    /// Middle of the letter from that of its cross, best first.
    const PLACES: [(f64, f64); 10] = [
        (10.0, -8.0),
        (-10.0, -8.0),
        (10.0, 9.0),
        (-10.0, 9.0),
        (0.0, -12.0),
        (0.0, 13.0),
        (0.0, -23.0),
        (0.0, 24.0),
        (0.0, -34.0),
        (0.0, 35.0),
    ];
    let mut written: Vec<(f64, f64)> = Vec::new();
    for &((x, y), letter) in failures {
        let free = |at: &(f64, f64)| {
            let apart = |other: (f64, f64), half: (f64, f64)| {
                (at.0 - other.0).abs() >= LETTER_HALF.0 + half.0
                    || (at.1 - other.1).abs() >= LETTER_HALF.1 + half.1
            };
            written.iter().all(|other| apart(*other, LETTER_HALF))
                && failures
                    .iter()
                    .all(|(other, _)| apart(*other, (CROSS_HALF, CROSS_HALF)))
        };
        let at = PLACES
            .iter()
            .map(|(right, down)| (x + right, y + down))
            .find(free)
            .unwrap_or((x + PLACES[0].0, y + PLACES[0].1));
        written.push(at);
        canvas.text("tiny halo", (at.0, at.1 + 4.0), Anchor::Middle, letter);
    }
}

fn letter(status: Status) -> &'static str {
    match status {
        Status::Ok => "",
        Status::Unstable => "u",
        Status::Tunnelled => "t",
        Status::MissedImpacts => "m",
        Status::ExtraImpacts => "x",
    }
}
