//! Panels of where methods fail: step against stiffness, grazing, chatter, situations.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas};
use super::panel::LETTER;
use super::series::{self, Mark};
use super::{Figure, WIDTH};
use crate::model::stop::StopModel;
use crate::report::number::{exact, trimmed};
use crate::study::stability::{Grade, PAPER_STEPS, Row, Stability, paper_step_s, situations};

const NAME: &str = "stability";

const COLUMNS: [f64; 2] = [74.0, 516.0];
const PANEL_WIDTH: f64 = 366.0;
const PANEL_HEIGHT: f64 = 250.0;

/// Upper edge of the first panels, and from row to row.
const TOP: f64 = 130.0;
const ROW_HEIGHT: f64 = 362.0;

/// Methods in the order of the columns of the table.
const METHODS: [&str; 5] = [
    "dopri5-samples",
    "rk4-located",
    "dopri5",
    "rk4",
    "moreau-jean",
];

/// A panel's frame.
#[derive(Clone, Copy)]
struct Frame {
    left: f64,
    top: f64,
}

impl Frame {
    fn right(self) -> f64 {
        self.left + PANEL_WIDTH
    }

    fn bottom(self) -> f64 {
        self.top + PANEL_HEIGHT
    }

    fn titles(self, canvas: &mut Canvas, title: &str, x: &str, y: &str) {
        canvas.text("strong", (self.left, self.top - 9.0), Anchor::Start, title);
        canvas.text(
            "",
            (self.left + PANEL_WIDTH / 2.0, self.bottom() + 40.0),
            Anchor::Middle,
            x,
        );
        canvas.upward_text("", (self.left - 54.0, self.top + PANEL_HEIGHT / 2.0), y);
    }

    fn close(self, canvas: &mut Canvas) {
        canvas.rectangle("frame", (self.left, self.top), (PANEL_WIDTH, PANEL_HEIGHT));
    }
}

pub(super) fn draw(result: &Stability) -> Figure {
    let mut canvas = Canvas::with_capacity(256 * 1024);
    let title = "Where methods fail";
    canvas.text("title", (COLUMNS[0], 24.0), Anchor::Start, title);
    canvas.text(
        "muted",
        (COLUMNS[0], 45.0),
        Anchor::Start,
        "The paper's step (N = 10 000 in a period of 20 rad/s), tolerances of 1e-9, unless an axis says otherwise.",
    );
    legend(&mut canvas, 68.0);
    let frame = |column: usize, row: f64| Frame {
        left: COLUMNS[column],
        top: TOP + row * ROW_HEIGHT,
    };
    contact(&mut canvas, result, frame(0, 0.0));
    map(&mut canvas, result, frame(1, 0.0));
    graze(&mut canvas, result, frame(0, 1.0));
    chatter(&mut canvas, result, frame(1, 1.0));
    let height = table(&mut canvas, result, TOP + 2.0 * ROW_HEIGHT);
    Figure {
        name: NAME,
        title: title.into(),
        caption: "Step against stiffness, grazing, chatter, and what happens inside a sample."
            .into(),
        description: format!(
            "Exit over entry speed of the soft contact by fixed-step Runge-Kutta against ω_R times step, \
             with the limit |R(z)| = 1 at {}; errors at a graze and of the time at which chatter ends; \
             a table of methods and situations.",
            trimmed(result.contact_limit, 4)
        ),
        height,
        body: canvas.into_string(),
    }
}

fn legend(canvas: &mut Canvas, y: f64) {
    let mut x = COLUMNS[0];
    for method in METHODS {
        canvas.line(
            &format!("line {}", series::class(method)),
            (x, y - 5.0),
            (x + 26.0, y - 5.0),
        );
        series::mark(canvas, Mark::of(method), method, (x + 13.0, y - 5.0));
        canvas.text("", (x + 34.0, y), Anchor::Start, method);
        let width = 34.0 + method.len() as f64 * (LETTER - 1.2) + 18.0;
        x += width;
    }
    let (x, y) = (COLUMNS[0], y + 21.0);
    canvas.line("line event-driven", (x, y - 5.0), (x + 26.0, y - 5.0));
    let bound = "event-driven: the bound that it states";
    canvas.text("", (x + 34.0, y), Anchor::Start, bound);
    let x = COLUMNS[1];
    series::cross(canvas, (x + 6.0, y - 5.0));
    canvas.text("", (x + 18.0, y), Anchor::Start, "no answer");
}

fn rows<'a>(result: &'a Stability, subject: &'a str) -> impl Iterator<Item = &'a Row> {
    result.rows.iter().filter(move |row| row.subject == subject)
}

/// Returns the least and largest ω_R times step of the map.
fn reaches(result: &Stability) -> (f64, f64) {
    let mut range = (0.01_f64, 5.0_f64);
    for row in rows(result, "contact") {
        if let Some(step) = row.step_s {
            let reach = step * result.contact_frequency_rad_s;
            range = (range.0.min(reach), range.1.max(reach));
        }
    }
    range
}

fn limits(canvas: &mut Canvas, result: &Stability, x: &Axis, frame: Frame) {
    let at = x.place(result.contact_limit);
    canvas.line("limit", (at, frame.top), (at, frame.bottom()));
    canvas.text(
        "tiny alarm halo",
        (at - 5.0, frame.top + 14.0),
        Anchor::End,
        &format!("|R(z)| = 1 at {}", trimmed(result.contact_limit, 3)),
    );
    for (steps, y, anchor, shift) in [
        (PAPER_STEPS[0], 50.0, Anchor::End, -4.0),
        (PAPER_STEPS[1], 32.0, Anchor::End, -4.0),
    ] {
        let at = x.place(paper_step_s(steps) * result.contact_frequency_rad_s);
        canvas.line("edge", (at, frame.top), (at, frame.bottom()));
        canvas.text(
            "tiny halo",
            (at + shift, frame.top + y),
            anchor,
            &format!("N = {steps}"),
        );
    }
}

fn contact(canvas: &mut Canvas, result: &Stability, frame: Frame) {
    const RATIOS: (f64, f64) = (0.0, 2.0);
    let (low, high) = reaches(result);
    let x = Axis::logarithmic(low, high * 1.02, frame.left, frame.right());
    let y = Axis::linear(RATIOS.0, RATIOS.1, frame.bottom(), frame.top);
    frame.titles(
        canvas,
        "Soft contact: speed given back",
        "ω_R · step [–]",
        "exit over entry speed [–]",
    );
    series::grid(
        canvas,
        &x,
        &y,
        (frame.left, frame.right()),
        (frame.top, frame.bottom()),
    );
    let right = y.place(result.right_ratio);
    canvas.line("zero", (frame.left, right), (frame.right(), right));
    canvas.text(
        "tiny halo",
        (frame.left + 6.0, right - 6.0),
        Anchor::Start,
        &format!("right: {}", trimmed(result.right_ratio, 4)),
    );
    for row in rows(result, "contact") {
        let Some(step) = row.step_s else { continue };
        let at = x.place(step * result.contact_frequency_rad_s);
        match row.value {
            Some(value) if (RATIOS.0..=RATIOS.1).contains(&value) => {
                canvas.circle(&format!("dot-{}", row.method), (at, y.place(value)), 1.4);
            }
            Some(value) if row.method == "rk4" => {
                let edge = if value > RATIOS.1 {
                    frame.top + 5.0
                } else {
                    frame.bottom() - 5.0
                };
                canvas.line("failure", (at - 2.0, edge), (at + 2.0, edge));
            }
            _ => {}
        }
    }
    limits(canvas, result, &x, frame);
    frame.close(canvas);
}

fn grade_class(grade: Grade) -> &'static str {
    match grade {
        Grade::Right => "good",
        Grade::Close => "fair",
        Grade::Poor => "poor",
        Grade::Wrong => "bad",
        Grade::Failed => "gone",
    }
}

/// Grades of the map: by share of the right ratio, worse where energy is gained.
fn map_class(row: &Row) -> &'static str {
    match row.value {
        None => "gone",
        Some(value) if value.abs() > 1.0 || value < 0.0 => "gone",
        Some(_) => {
            let off = row.relative_error.unwrap_or(f64::INFINITY);
            if off <= 1e-3 {
                "good"
            } else if off <= 1e-2 {
                "fair"
            } else if off <= 0.1 {
                "poor"
            } else {
                "bad"
            }
        }
    }
}

fn map(canvas: &mut Canvas, result: &Stability, frame: Frame) {
    let own: Vec<&Row> = rows(result, "contact")
        .filter(|row| row.method == "rk4")
        .collect();
    let (low, high) = reaches(result);
    let x = Axis::logarithmic(low, high * 1.02, frame.left, frame.right());
    let y = Axis::linear(0.0, 1.0, frame.bottom(), frame.top);
    frame.titles(
        canvas,
        "Soft contact: how far rk4 is off",
        "ω_R · step [–]",
        "phase of entry in a step [–]",
    );
    // Below the map: lines across it would be taken for its own.
    series::grid(
        canvas,
        &x,
        &y,
        (frame.left, frame.right()),
        (frame.top, frame.bottom()),
    );
    let mut steps: Vec<f64> = own.iter().filter_map(|row| row.step_s).collect();
    steps.dedup();
    let phases = own
        .iter()
        .filter(|row| row.step_s == steps.first().copied())
        .count()
        .max(1);
    let height = PANEL_HEIGHT / phases as f64;
    for row in &own {
        let Some(step) = row.step_s else { continue };
        let index = steps.partition_point(|known| *known < step);
        let edge = |other: Option<&f64>, fallback: f64| {
            other.map_or(fallback, |other| {
                x.place((step * other).sqrt() * result.contact_frequency_rad_s)
            })
        };
        let from = edge(
            index.checked_sub(1).and_then(|before| steps.get(before)),
            frame.left,
        );
        let to = edge(steps.get(index + 1), frame.right());
        let middle = y.place(row.variable_value);
        canvas.rectangle(
            map_class(row),
            (from, middle - height / 2.0),
            (to - from + 0.3, height + 0.3),
        );
    }
    limits(canvas, result, &x, frame);
    frame.close(canvas);
    map_legend(canvas, frame);
}

/// Names the classes of the map below it.
fn map_legend(canvas: &mut Canvas, frame: Frame) {
    let y = frame.bottom() + 62.0;
    let mut x = frame.left;
    for (class, text) in [
        ("good", "≤ 0.1 %"),
        ("fair", "≤ 1 %"),
        ("poor", "≤ 10 %"),
        ("bad", "more"),
        ("gone", "gains, or stays in"),
    ] {
        canvas.rectangle(class, (x, y - 9.0), (11.0, 11.0));
        canvas.text("tiny", (x + 15.0, y), Anchor::Start, text);
        let width = 15.0 + text.chars().count() as f64 * 6.2 + 12.0;
        x += width;
    }
}

/// Draws the error of every method against a variable, both by decades.
fn errors(
    canvas: &mut Canvas,
    frame: Frame,
    own: &[&Row],
    variable: impl Fn(&Row) -> Option<f64>,
    (x, y): (Axis, Axis),
) {
    series::grid(
        canvas,
        &x,
        &y,
        (frame.left, frame.right()),
        (frame.top, frame.bottom()),
    );
    // The right answers' bounds, from edge to edge where there is one for all.
    let mut bounds: Vec<(f64, f64)> = own
        .iter()
        .filter_map(|row| Some((x.place(variable(row)?), row.right_bound)))
        .map(|(at, bound)| (at, y.place(bound.clamp(y.low(), y.high()))))
        .collect();
    bounds.sort_by(|a, b| a.0.total_cmp(&b.0));
    canvas.polyline("line event-driven", bounds.into_iter());
    for method in METHODS {
        let mut points: Vec<(f64, Option<f64>)> = own
            .iter()
            .filter(|row| row.method == method)
            .filter_map(|row| {
                let at = x.place(variable(row)?);
                Some((at, row.error.map(|e| y.place(e.clamp(y.low(), y.high())))))
            })
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        canvas.polyline(
            &format!("line {}", series::class(method)),
            points.iter().filter_map(|(x, y)| Some((*x, (*y)?))),
        );
        for (at, error) in points {
            match error {
                Some(error) => series::mark(canvas, Mark::of(method), method, (at, error)),
                None => series::cross(canvas, (at, frame.top + 8.0)),
            }
        }
    }
    frame.close(canvas);
}

fn graze(canvas: &mut Canvas, result: &Stability, frame: Frame) {
    let own: Vec<&Row> = rows(result, "graze")
        .filter(|row| row.model == StopModel::Rigid && row.variable_value < 0.0)
        .collect();
    frame.titles(
        canvas,
        "Graze of a rigid stop, 7 ms later",
        "speed brought in beyond the graze [rad/s]",
        "error of the angle [rad]",
    );
    errors(
        canvas,
        frame,
        &own,
        |row| Some(-row.variable_value),
        (
            Axis::logarithmic(5e-13, 2e-3, frame.left, frame.right()),
            Axis::logarithmic(1e-15, 1e-2, frame.bottom(), frame.top),
        ),
    );
}

fn chatter(canvas: &mut Canvas, result: &Stability, frame: Frame) {
    let own: Vec<&Row> = rows(result, "chatter").collect();
    frame.titles(
        canvas,
        "Chatter on a rigid stop: time of rest",
        "step [s], or tolerance [rad]",
        "error of the time [s]",
    );
    errors(
        canvas,
        frame,
        &own,
        |row| Some(row.variable_value),
        (
            Axis::logarithmic(5e-13, 1e-3, frame.left, frame.right()),
            Axis::logarithmic(1e-13, 1e-1, frame.bottom(), frame.top),
        ),
    );
}

/// Draws methods against situations; returns the height of the whole drawing.
fn table(canvas: &mut Canvas, result: &Stability, top: f64) -> f64 {
    const NAMES_WIDTH: f64 = 338.0;
    const ROW_HEIGHT: f64 = 23.0;
    canvas.text(
        "strong",
        (COLUMNS[0] - 60.0, top - 9.0),
        Anchor::Start,
        "Situations: relative error of the peak; impacts seen of those there are, where they differ",
    );
    let left = COLUMNS[0] - 60.0 + NAMES_WIDTH;
    let width = (WIDTH - 18.0 - left) / METHODS.len() as f64;
    let mut x = left;
    for method in METHODS {
        canvas.text(
            "tiny strong",
            (x + width / 2.0, top + 14.0),
            Anchor::Middle,
            method,
        );
        x += width;
    }
    let mut y = top + 22.0;
    for subject in situations::SUBJECTS {
        for model in [StopModel::Rigid, StopModel::Soft] {
            let own: Vec<&Row> = rows(result, subject)
                .filter(|row| row.model == model)
                .collect();
            if own.is_empty() {
                continue;
            }
            canvas.text(
                "",
                (COLUMNS[0] - 60.0, y + 16.0),
                Anchor::Start,
                &format!("{}, {}", subject.replace('-', " "), model.name()),
            );
            let mut x = left;
            for method in METHODS {
                let pair: Vec<&&Row> = own.iter().filter(|row| row.method == method).collect();
                if let [peak, impacts] = pair.as_slice() {
                    let grade = peak.grade.max(impacts.grade);
                    canvas.rectangle(
                        grade_class(grade),
                        (x + 1.0, y + 1.0),
                        (width - 2.0, ROW_HEIGHT - 2.0),
                    );
                    canvas.text(
                        "tiny halo",
                        (x + width / 2.0, y + 15.5),
                        Anchor::Middle,
                        &cell(peak, impacts),
                    );
                }
                x += width;
            }
            y += ROW_HEIGHT;
        }
    }
    y + 16.0
}

fn cell(peak: &Row, impacts: &Row) -> String {
    let Some(off) = peak.relative_error else {
        return "no answer".into();
    };
    let mut text = if off < 1e-12 {
        "exact".to_string()
    } else {
        format!("{off:.0e}")
    };
    if let Some(got) = impacts.value
        && impacts.grade != Grade::Right
    {
        text.push_str(&format!(" · {} of {}", exact(got), exact(impacts.right)));
    }
    text
}
