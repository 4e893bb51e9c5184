//! Panels of the failures of methods: step against stiffness, grazing, chatter, situations.

use super::methods;
use crate::stability::{Grade, PAPER_STEPS, Row, Stability, paper_step_s, situations};
use latchgate_document::number::{exact, trimmed};
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::range::Range;
use latchgate_report::plot::WIDTH;
use latchgate_report::plot::chart::At::{self, High, Low, Value};
use latchgate_report::plot::chart::{Chart, Edges, HALVES, Panel, Point, Shape};
use latchgate_report::plot::frame::{LegendEntry, OPEN, Sample, Scale};

/// Height of a panel.
const HEIGHT: f64 = 250.0;

/// Methods in the order of the columns of the table.
const METHODS: [&str; 5] = [
    "dopri5-samples",
    "rk4-located",
    "dopri5",
    "rk4",
    "moreau-jean",
];

pub(super) fn chart(result: &Stability) -> Chart {
    let mut legend: Vec<LegendEntry> = METHODS.into_iter().map(methods::entry).collect();
    let bound = "event-driven: the bound that it states";
    legend.push(LegendEntry::line("line event-driven", bound));
    let failure = Sample::Marked("line".into(), "failure".into(), methods::CROSS);
    legend.push(LegendEntry::new(failure, "no answer"));
    Chart {
        name: "stability",
        title: "Where methods fail".into(),
        notes: vec!["The paper's step (N = 10 000 in a period of 20 rad/s), tolerances of 1e-9, unless an axis says otherwise.".into()],
        legend,
        panels: vec![
            contact(result),
            map(result),
            graze(result),
            chatter(result),
            table(result),
        ],
        room: [27.0, 134.0, 16.0],
        caption: "Step against stiffness, grazing, chatter, and what happens inside a sample."
            .into(),
        description: format!(
            "Exit over entry speed of the soft contact by fixed-step Runge-Kutta against ω_R times step, \
             with the limit |R(z)| = 1 at {}; errors at a graze and of the time at which chatter ends; \
             a table of methods and situations.",
            trimmed(result.contact_limit, 4)
        ),
        ..Chart::default()
    }
}

fn rows<'a>(result: &'a Stability, subject: &'a str) -> impl Iterator<Item = &'a Row> {
    result.rows.iter().filter(move |row| row.subject == subject)
}

/// Returns ω_R times step of each row of the contact.
fn reach(result: &Stability, row: &Row) -> Option<f64> {
    Some(row.step_s? * result.contact_frequency_rad_s)
}

/// Returns the scale of ω_R times step over all runs.
fn reaches(result: &Stability) -> Scale {
    let reaches = rows(result, "contact").filter_map(|row| reach(result, row));
    let Range { low, high } = reaches.fold(Range::new(0.01, 5.0), Range::including);
    Scale::Logarithmic(low, high * 1.02)
}

/// Adds the limit beyond which steps amplify, and the paper's steps.
fn limits(panel: Panel, result: &Stability) -> Panel {
    let limit = result.contact_limit;
    let text = format!("|R(z)| = 1 at {}", trimmed(limit, 3));
    panel
        .upright("limit", limit)
        .text("tiny alarm halo", (Value(limit, -5.0), High(14.0)), text)
        .each(
            PAPER_STEPS.into_iter().zip([50.0, 32.0]),
            |panel, (steps, y)| {
                let reach = paper_step_s(steps) * result.contact_frequency_rad_s;
                let label_place = (Value(reach, -4.0), High(y));
                panel
                    .upright("edge", reach)
                    .text("tiny halo", label_place, format!("N = {steps}"))
            },
        )
}

fn contact(result: &Stability) -> Panel {
    const RATIO_MAX: f64 = 2.0;
    let right = result.right_ratio;
    let rows = rows(result, "contact");
    let rows = rows.filter_map(|row| Some((row.method, reach(result, row)?, row.value?)));
    let panel = Panel::new(&OPEN, HALVES[0], HEIGHT)
        .title("Soft contact: speed given back")
        .x("ω_R · step [–]", reaches(result))
        .y("exit over entry speed [–]", Scale::Linear(0.0, RATIO_MAX))
        .level("zero", right)
        .text(
            "tiny halo",
            (Low(6.0), Value(right, -6.0)),
            format!("right: {}", trimmed(right, 4)),
        )
        .each(rows, |panel, (method, reach, ratio)| {
            if (0.0..=RATIO_MAX).contains(&ratio) {
                let class = format!("dot-{method}");
                return panel.marks(class, Shape::Circle(1.4), [Point::new(reach, ratio)]);
            }
            // A ratio of rk4 beyond the scale is a stroke at the edge.
            let edge = if ratio > RATIO_MAX {
                High(5.0)
            } else {
                Low(-5.0)
            };
            panel.each((method == "rk4").then_some(edge), |panel, edge| {
                panel.segment(
                    "failure",
                    (Value(reach, -2.0), edge),
                    (Value(reach, 2.0), edge),
                )
            })
        });
    limits(panel, result)
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

/// Returns the class of a cell of the map: by its relative error, the worst if it gains energy.
fn map_class(row: &Row) -> &'static str {
    let off = row.relative_error.unwrap_or(f64::INFINITY);
    match row.value {
        None => "gone",
        Some(value) if value.abs() > 1.0 || value < 0.0 => "gone",
        Some(_) if off <= 1e-3 => "good",
        Some(_) if off <= 1e-2 => "fair",
        Some(_) if off <= 0.1 => "poor",
        Some(_) => "bad",
    }
}

fn map(result: &Stability) -> Panel {
    let rk4_rows = || rows(result, "contact").filter(|row| row.method == "rk4");
    let mut reaches: Vec<f64> = rk4_rows().filter_map(|row| reach(result, row)).collect();
    reaches.dedup();
    let first = rk4_rows().filter(|row| reach(result, row) == reaches.first().copied());
    let half = HEIGHT / first.count().max(1) as f64 / 2.0;
    // A cell reaches to the geometric mean of its step and the next.
    let edge = |step: f64, neighbour: Option<&f64>, outer: At| {
        neighbour.map_or(outer, |neighbour| Value((step * neighbour).sqrt(), 0.0))
    };
    let grades = [
        ("good", "≤ 0.1 %"),
        ("fair", "≤ 1 %"),
        ("poor", "≤ 10 %"),
        ("bad", "more"),
        ("gone", "gains, or stays in"),
    ];
    let rows = rk4_rows().filter_map(|row| Some((row, reach(result, row)?)));
    let panel = Panel::new(&OPEN, HALVES[1], HEIGHT)
        .title("Soft contact: how far rk4 is off")
        .x("ω_R · step [–]", self::reaches(result))
        .y("phase of entry in a step [–]", Scale::Linear(0.0, 1.0))
        .legend(grades.map(|(class, text)| LegendEntry::new(Sample::Patch(class), text)))
        .each(rows, |panel, (row, step)| {
            let index = reaches.partition_point(|other| *other < step);
            let before = index.checked_sub(1).and_then(|before| reaches.get(before));
            let from = edge(step, before, Low(0.0));
            let to = edge(step, reaches.get(index + 1), High(0.0));
            let y = |down| Value(row.variable_value, down);
            panel.patch(map_class(row), (from, y(-half)), (to, y(half + 0.3)))
        });
    limits(panel, result)
}

/// Adds the error of every method against a variable, both by decades.
fn errors<'a>(
    panel: Panel,
    rows: impl Iterator<Item = (f64, &'a Row)>,
    title: &str,
    Range { low, high }: Range,
) -> Panel {
    let mut rows: Vec<(f64, &Row)> = rows.collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The line of the bounds on the right answers.
    let bounds = rows.iter();
    let bounds = bounds.map(|(x, row)| Point::new(*x, row.right_bound.clamp(low, high)));
    // Failures have no error; their marks stand a little below the upper edge.
    let failed = high * libm::pow(low / high, 8.0 / HEIGHT);
    panel
        .y(title, Scale::Logarithmic(low, high))
        .lines("line event-driven", bounds)
        .each(METHODS, |panel, method| {
            let method_rows = rows.iter().copied().filter(|(_, row)| row.method == method);
            let (points, failures): (Vec<_>, Vec<_>) =
                method_rows.partition(|(_, row)| row.error.is_some());
            let points = points.into_iter();
            let points =
                points.filter_map(|(x, row)| Some(Point::new(x, row.error?.clamp(low, high))));
            let failures = failures.into_iter().map(|(x, _)| Point::new(x, failed));
            panel
                .lines(format!("line {method}"), points.clone())
                .marks(format!("dot dot-{method}"), methods::shape(method), points)
                .marks("failure", methods::CROSS, failures)
        })
}

fn graze(result: &Stability) -> Panel {
    let rows = rows(result, "graze")
        .filter(|row| row.model == StopModel::Rigid && row.variable_value < 0.0);
    let panel = Panel::new(&OPEN, HALVES[0], HEIGHT)
        .title("Graze of a rigid stop, 7 ms later")
        .x(
            "speed brought in beyond the graze [rad/s]",
            Scale::Logarithmic(5e-13, 2e-3),
        );
    let rows = rows.map(|row| (-row.variable_value, row));
    errors(
        panel,
        rows,
        "error of the angle [rad]",
        Range::new(1e-15, 1e-2),
    )
}

fn chatter(result: &Stability) -> Panel {
    let points = rows(result, "chatter").map(|row| (row.variable_value, row));
    let panel = Panel::new(&OPEN, HALVES[1], HEIGHT)
        .title("Chatter on a rigid stop: time of rest")
        .x(
            "step [s], or tolerance [rad]",
            Scale::Logarithmic(5e-13, 1e-3),
        );
    errors(
        panel,
        points,
        "error of the time [s]",
        Range::new(1e-13, 1e-1),
    )
}

/// Returns the table of methods against situations.
fn table(result: &Stability) -> Panel {
    let situations = situations::SUBJECTS
        .into_iter()
        .flat_map(|subject| [StopModel::Rigid, StopModel::Soft].map(|model| (subject, model)));
    let situations: Vec<(String, Vec<&Row>)> = situations
        .map(|(subject, model)| {
            let situation_rows = rows(result, subject).filter(|row| row.model == model);
            let name = format!("{}, {}", subject.replace('-', " "), model.name());
            (name, situation_rows.collect())
        })
        .filter(|(_, rows): &(_, Vec<_>)| !rows.is_empty())
        .collect();
    let columns = || {
        METHODS
            .into_iter()
            .zip(0..)
            .map(|(method, column)| (method, f64::from(column)))
    };
    let lines = situations.iter().rev().zip(0..);
    Panel::new(&OPEN, Edges::new(352.0, WIDTH - 18.0), 23.0 * situations.len() as f64)
        .x("", Scale::Cells(METHODS.len()))
        .y("", Scale::Cells(situations.len()))
        .text(
            "strong",
            (High(-1.0), High(-31.0)),
            "Situations: relative error of the peak; impacts seen of those there are, where they differ",
        )
        .each(columns(), |panel, (method, x)| {
            panel.text("tiny strong", (Value(x + 0.5, 0.0), High(-8.0)), method)
        })
        .each(lines, |panel, ((name, rows), line)| {
            let y = f64::from(line);
            let text_y = Value(y + 0.5, 4.0);
            let panel = panel.text("", (Low(-12.0), text_y), name);
            panel.each(columns(), |panel, (method, x)| {
                let pair: Vec<&&Row> = rows.iter().filter(|row| row.method == method).collect();
                let [peak, impacts] = pair.as_slice() else {
                    return panel;
                };
                let class = grade_class(peak.grade.max(impacts.grade));
                let from = (Value(x, 1.0), Value(y, -1.0));
                let to = (Value(x + 1.0, -1.0), Value(y + 1.0, 1.0));
                panel
                    .patch(class, from, to)
                    .text("tiny halo", (Value(x + 0.5, 0.0), text_y), cell(peak, impacts))
            })
        })
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
