//! Panels of where methods fail: step against stiffness, grazing, chatter, situations.

use super::methods;
use crate::stability::{Grade, PAPER_STEPS, Row, Stability, paper_step_s, situations};
use latchgate_document::number::{exact, trimmed};
use latchgate_kernel::model::stop::StopModel;
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{Frame, LegendEntry, PanelPlace, Sample, Scale, header};
use latchgate_report::plot::{Figure, WIDTH};

const NAME: &str = "stability";

const COLUMNS: [f64; 2] = [74.0, 516.0];
const PANEL_WIDTH: f64 = 366.0;
const PANEL_HEIGHT: f64 = 250.0;

/// From row to row.
const ROW_HEIGHT: f64 = 362.0;

/// Methods in the order of the columns of the table.
const METHODS: [&str; 5] = [
    "dopri5-samples",
    "rk4-located",
    "dopri5",
    "rk4",
    "moreau-jean",
];

pub(super) fn draw(result: &Stability) -> Figure {
    let mut canvas = Canvas::with_capacity(256 * 1024);
    let title = "Where methods fail";
    let note = "The paper's step (N = 10 000 in a period of 20 rad/s), tolerances of 1e-9, unless an axis says otherwise.";
    let mut entries: Vec<LegendEntry> = METHODS.into_iter().map(methods::entry).collect();
    let bound = "event-driven: the bound that it states";
    entries.push(LegendEntry::line("line event-driven", bound));
    let failure = |canvas: &mut Canvas, _: &str, at: (f64, f64)| methods::cross(canvas, at);
    entries.push(LegendEntry::new(Sample::Marked("", failure), "no answer"));
    let top = header(&mut canvas, COLUMNS[0], title, &[note.into()], &entries) + 27.0;
    let place = |column: usize, row: f64| {
        let (left, top) = (COLUMNS[column], top + row * ROW_HEIGHT);
        (left, left + PANEL_WIDTH, top, top + PANEL_HEIGHT)
    };
    contact(&mut canvas, result, place(0, 0.0));
    map(&mut canvas, result, place(1, 0.0));
    graze(&mut canvas, result, place(0, 1.0));
    chatter(&mut canvas, result, place(1, 1.0));
    let height = table(&mut canvas, result, top + 2.0 * ROW_HEIGHT);
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

fn rows<'a>(result: &'a Stability, subject: &'a str) -> impl Iterator<Item = &'a Row> {
    result.rows.iter().filter(move |row| row.subject == subject)
}

/// Returns the scale of ω_R times step, of all that were run.
fn reaches(result: &Stability) -> Scale {
    let mut range = (0.01_f64, 5.0_f64);
    for row in rows(result, "contact") {
        if let Some(step) = row.step_s {
            let reach = step * result.contact_frequency_rad_s;
            range = (range.0.min(reach), range.1.max(reach));
        }
    }
    Scale::Logarithmic(range.0, range.1 * 1.02)
}

/// Marks where the steps amplify, and the paper's steps.
fn limits(canvas: &mut Canvas, result: &Stability, panel: &Frame) {
    let at = panel.x.place(result.contact_limit);
    canvas.line("limit", (at, panel.top), (at, panel.bottom));
    canvas.text(
        "tiny alarm halo",
        (at - 5.0, panel.top + 14.0),
        Anchor::End,
        &format!("|R(z)| = 1 at {}", trimmed(result.contact_limit, 3)),
    );
    for (steps, y) in PAPER_STEPS.into_iter().zip([50.0, 32.0]) {
        let reach = paper_step_s(steps) * result.contact_frequency_rad_s;
        let at = panel.x.place(reach);
        canvas.line("edge", (at, panel.top), (at, panel.bottom));
        let text = format!("N = {steps}");
        canvas.text("tiny halo", (at - 4.0, panel.top + y), Anchor::End, &text);
    }
}

fn contact(canvas: &mut Canvas, result: &Stability, place: PanelPlace) {
    const RATIOS: (f64, f64) = (0.0, 2.0);
    let panel = Frame::open(place, reaches(result), Scale::Linear(RATIOS.0, RATIOS.1));
    panel.title(canvas, "Soft contact: speed given back");
    panel.grid(
        canvas,
        Some("ω_R · step [–]"),
        Some("exit over entry speed [–]"),
    );
    panel.level(canvas, "zero", result.right_ratio);
    canvas.text(
        "tiny halo",
        (panel.left + 6.0, panel.y.place(result.right_ratio) - 6.0),
        Anchor::Start,
        &format!("right: {}", trimmed(result.right_ratio, 4)),
    );
    for row in rows(result, "contact") {
        let Some(step) = row.step_s else { continue };
        let at = panel.x.place(step * result.contact_frequency_rad_s);
        match row.value {
            Some(value) if (RATIOS.0..=RATIOS.1).contains(&value) => {
                canvas.circle(
                    &format!("dot-{}", row.method),
                    (at, panel.y.place(value)),
                    1.4,
                );
            }
            Some(value) if row.method == "rk4" => {
                let edge = if value > RATIOS.1 {
                    panel.top + 5.0
                } else {
                    panel.bottom - 5.0
                };
                canvas.line("failure", (at - 2.0, edge), (at + 2.0, edge));
            }
            _ => {}
        }
    }
    limits(canvas, result, &panel);
    panel.frame(canvas);
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

fn map(canvas: &mut Canvas, result: &Stability, place: PanelPlace) {
    let own: Vec<&Row> = rows(result, "contact")
        .filter(|row| row.method == "rk4")
        .collect();
    let panel = Frame::open(place, reaches(result), Scale::Linear(0.0, 1.0));
    panel.title(canvas, "Soft contact: how far rk4 is off");
    // Below the map: lines across it would be taken for its own.
    panel.grid(
        canvas,
        Some("ω_R · step [–]"),
        Some("phase of entry in a step [–]"),
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
                panel
                    .x
                    .place((step * other).sqrt() * result.contact_frequency_rad_s)
            })
        };
        let from = edge(
            index.checked_sub(1).and_then(|before| steps.get(before)),
            panel.left,
        );
        let to = edge(steps.get(index + 1), panel.right);
        let middle = panel.y.place(row.variable_value);
        canvas.rectangle(
            map_class(row),
            (from, middle - height / 2.0),
            (to - from + 0.3, height + 0.3),
        );
    }
    limits(canvas, result, &panel);
    panel.frame(canvas);
    map_legend(canvas, &panel);
}

/// Names the classes of the map below it.
fn map_legend(canvas: &mut Canvas, panel: &Frame) {
    let y = panel.bottom + 62.0;
    let mut x = panel.left;
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
    panel: &Frame,
    own: &[&Row],
    variable: impl Fn(&Row) -> Option<f64>,
) {
    let (x, y) = (panel.x, panel.y);
    let held = |error: f64| y.place(error.clamp(y.low(), y.high()));
    // The right answers' bounds, from edge to edge where there is one for all.
    let mut bounds: Vec<(f64, f64)> = own
        .iter()
        .filter_map(|row| Some((x.place(variable(row)?), held(row.right_bound))))
        .collect();
    bounds.sort_by(|a, b| a.0.total_cmp(&b.0));
    canvas.polyline("line event-driven", bounds.into_iter());
    for method in METHODS {
        let mut points: Vec<(f64, Option<f64>)> = own
            .iter()
            .filter(|row| row.method == method)
            .filter_map(|row| Some((x.place(variable(row)?), row.error.map(held))))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        canvas.polyline(
            &format!("line {method}"),
            points.iter().filter_map(|(x, y)| Some((*x, (*y)?))),
        );
        for (at, error) in points {
            match error {
                Some(error) => methods::point(canvas, method, (at, error)),
                None => methods::cross(canvas, (at, panel.top + 8.0)),
            }
        }
    }
    panel.frame(canvas);
}

fn graze(canvas: &mut Canvas, result: &Stability, place: PanelPlace) {
    let own: Vec<&Row> = rows(result, "graze")
        .filter(|row| row.model == StopModel::Rigid && row.variable_value < 0.0)
        .collect();
    let panel = Frame::open(
        place,
        Scale::Logarithmic(5e-13, 2e-3),
        Scale::Logarithmic(1e-15, 1e-2),
    );
    panel.title(canvas, "Graze of a rigid stop, 7 ms later");
    panel.grid(
        canvas,
        Some("speed brought in beyond the graze [rad/s]"),
        Some("error of the angle [rad]"),
    );
    errors(canvas, &panel, &own, |row| Some(-row.variable_value));
}

fn chatter(canvas: &mut Canvas, result: &Stability, place: PanelPlace) {
    let own: Vec<&Row> = rows(result, "chatter").collect();
    let panel = Frame::open(
        place,
        Scale::Logarithmic(5e-13, 1e-3),
        Scale::Logarithmic(1e-13, 1e-1),
    );
    panel.title(canvas, "Chatter on a rigid stop: time of rest");
    panel.grid(
        canvas,
        Some("step [s], or tolerance [rad]"),
        Some("error of the time [s]"),
    );
    errors(canvas, &panel, &own, |row| Some(row.variable_value));
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
