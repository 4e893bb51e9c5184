//! Error of the peak against time, one panel per case and stop.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas};
use super::panel::LETTER;
use super::series::{self, Mark};
use super::{Figure, WIDTH};
use crate::report::number::significant;
use crate::study::work_precision::{PAPER_STEPS, Row, Status, Truth, WorkPrecision};

const NAME: &str = "work-precision";

/// Left edges and width of the two columns of panels.
const COLUMNS: [f64; 2] = [74.0, 516.0];
const PANEL_WIDTH: f64 = 366.0;
const PANEL_HEIGHT: f64 = 262.0;
const ROW_HEIGHT: f64 = 366.0;

/// The error that matters to a verdict: a hundredth of the usual threshold [rad].
const MATTERS_RAD: f64 = 1e-3;

pub(super) fn draw(result: &WorkPrecision) -> Figure {
    let mut canvas = Canvas::with_capacity(64 * 1024);
    canvas.text(
        "title",
        (COLUMNS[0], 24.0),
        Anchor::Start,
        "Error of the peak angle against computing time",
    );
    canvas.text(
        "muted",
        (COLUMNS[0], 45.0),
        Anchor::Start,
        "Down is more exact, left is faster. A red cross has failed:",
    );
    let mut y = legend(&mut canvas, result, 68.0);
    canvas.text(
        "muted",
        (COLUMNS[0], y),
        Anchor::Start,
        "u unstable, t tunnelled, m missed impacts, x impacts too many; ring: rk4 at the paper's step;",
    );
    y += 20.0;
    canvas.text(
        "muted",
        (COLUMNS[0], y),
        Anchor::Start,
        "dotted: an error that matters to a verdict (0.001 rad), and the bound on the truth's own error.",
    );
    y += 16.0;
    let (times, errors) = ranges(result);
    for (index, truth) in result.truths.iter().enumerate() {
        let (column, row) = (index % 2, index / 2);
        #[expect(clippy::cast_precision_loss, reason = "a few panels")]
        let top = y + 30.0 + row as f64 * ROW_HEIGHT;
        panel(
            &mut canvas,
            result,
            truth,
            (COLUMNS[column], top),
            times,
            errors,
        );
    }
    let rows = result.truths.len().div_ceil(2);
    #[expect(clippy::cast_precision_loss, reason = "a few panels")]
    let height = y + 10.0 + rows as f64 * ROW_HEIGHT;
    Figure {
        name: NAME,
        title: "Error of the peak angle against computing time".into(),
        caption: "Each method at several settings, on each case and stop.".into(),
        description: description(result),
        height,
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

fn methods(result: &WorkPrecision) -> Vec<&'static str> {
    let mut methods = Vec::new();
    for row in &result.rows {
        if !methods.contains(&row.method) {
            methods.push(row.method);
        }
    }
    methods
}

fn legend(canvas: &mut Canvas, result: &WorkPrecision, top: f64) -> f64 {
    let (mut x, mut y) = (COLUMNS[0], top);
    for method in methods(result) {
        #[expect(clippy::cast_precision_loss, reason = "a few letters")]
        let width = 34.0 + method.len() as f64 * (LETTER - 1.2) + 18.0;
        if x + width > WIDTH - 10.0 {
            (x, y) = (COLUMNS[0], y + 21.0);
        }
        let class = series::class(method);
        canvas.line(&format!("line {class}"), (x, y - 5.0), (x + 26.0, y - 5.0));
        series::mark(canvas, Mark::of(method), class, (x + 13.0, y - 5.0));
        canvas.text("", (x + 34.0, y), Anchor::Start, method);
        x += width;
    }
    y + 22.0
}

/// The same axes for every panel, so that panels compare: whole decades around all points.
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
    let decades = |(low, high): (f64, f64)| {
        (
            libm::pow(10.0, libm::log10(low).floor()),
            libm::pow(10.0, libm::log10(high * 1.0001).ceil()),
        )
    };
    let (times, errors) = (decades(times), decades(errors));
    (
        (times.0.max(1e-3), times.1.min(1e6)),
        (errors.0.max(1e-18), errors.1.min(1e2)),
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
    let (right, bottom) = (left + PANEL_WIDTH, top + PANEL_HEIGHT);
    let x = Axis::logarithmic(times.0, times.1, left, right);
    let y = Axis::logarithmic(errors.0, errors.1, bottom, top);
    canvas.text(
        "strong",
        (left, top - 9.0),
        Anchor::Start,
        &format!("{}, {} stop", truth.title, truth.model.name()),
    );
    series::grid(canvas, &x, &y, (left, right), (top, bottom));
    canvas.text(
        "",
        (f64::midpoint(left, right), bottom + 40.0),
        Anchor::Middle,
        "time over event-driven [–]",
    );
    canvas.upward_text(
        "",
        (left - 54.0, f64::midpoint(top, bottom)),
        "error of the peak [rad]",
    );
    for level in [MATTERS_RAD, truth.peak_angle_bound_rad] {
        if y.contains(level) {
            canvas.line("edge", (left, y.place(level)), (right, y.place(level)));
        }
    }
    for method in methods(result) {
        let rows: Vec<&Row> = result
            .rows
            .iter()
            .filter(|row| row.method == method)
            .filter(|row| row.case == truth.case && row.model == truth.model)
            .collect();
        let class = series::class(method);
        let place = |row: &Row| {
            let error = row
                .peak_angle_error_rad
                .map_or(errors.1, |error| error.clamp(errors.0, errors.1));
            (
                x.place(row.time_ratio.clamp(times.0, times.1)),
                y.place(error),
            )
        };
        canvas.polyline(
            &format!("line {class}"),
            rows.iter()
                .filter(|row| row.peak_angle_error_rad.is_some())
                .map(|row| place(row)),
        );
        for row in rows {
            let at = place(row);
            if row.status == Status::Ok {
                series::mark(canvas, Mark::of(method), class, at);
            } else {
                series::cross(canvas, at);
                canvas.text(
                    "tiny halo",
                    (at.0 + 6.0, at.1 - 4.0),
                    Anchor::Start,
                    letter(row.status),
                );
            }
            if method == "rk4" && row.steps_per_period == Some(PAPER_STEPS) {
                canvas.circle("ring", at, 9.0);
            }
        }
    }
    canvas.rectangle("frame", (left, top), (PANEL_WIDTH, PANEL_HEIGHT));
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
