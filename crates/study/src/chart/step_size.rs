//! Phase diagrams of the fixed-step method, and the limit of its step.

use crate::step_size::{FixedStepRun, StepScan, StepSize};
use latchgate_document::number::{count, significant};
use latchgate_report::plot::canvas::{Anchor, Canvas};
use latchgate_report::plot::frame::{self, Frame, LegendEntry, Scale};
use latchgate_report::plot::{Figure, WIDTH};

const NAME: &str = "step-size";

/// Points of a phase diagram at most.
const MOST_POINTS: usize = 5000;

pub(super) fn draw(result: &StepSize) -> Figure {
    let mut canvas = Canvas::with_capacity(128 * 1024);
    let title = "Free impacts by Runge–Kutta with a fixed step, soft stop";
    let mut top = frame::header(
        &mut canvas,
        72.0,
        title,
        &[
            "The step is the period of the excitation over N; event-driven is the motion as it is."
                .into(),
        ],
        &[
            LegendEntry::line("line nothing", "event-driven"),
            LegendEntry::line("line soft", "Runge–Kutta"),
        ],
    ) + 24.0;
    let columns = [(72.0, 438.0), (522.0, WIDTH - 16.0)];
    for (index, run) in result.runs.iter().enumerate() {
        let (left, right) = columns[index % 2];
        phase(
            &mut canvas,
            result,
            run,
            index,
            (left, right, top, top + 270.0),
        );
        if index % 2 == 1 || index + 1 == result.runs.len() {
            top += 270.0 + 82.0;
        }
    }
    limit(&mut canvas, result, (72.0, WIDTH - 16.0, top, top + 230.0));
    Figure {
        name: NAME,
        title: title.into(),
        caption: "The paper's Fig. 3, and where the step's limit lies.".into(),
        description: description(result),
        height: top + 230.0 + 54.0,
        body: canvas.into_string(),
    }
}

fn description(result: &StepSize) -> String {
    let mut text = String::from("Phase diagrams of free impacts on the soft stop.");
    for run in &result.runs {
        text.push_str(&format!(
            " N = {}: step times contact frequency {}, {}.",
            run.steps_per_period,
            significant(run.reach, 3),
            if run.gains_energy {
                "gains energy"
            } else {
                "gains no energy"
            }
        ));
    }
    text.push_str(&format!(
        " Below: exit over entry speed of one contact against N; steps amplify below N = {}.",
        significant(result.limit_steps_per_period, 4)
    ));
    text
}

fn phase(
    canvas: &mut Canvas,
    result: &StepSize,
    run: &FixedStepRun,
    index: usize,
    place: frame::PanelPlace,
) {
    let exact = &result.exact.trace;
    let both = || exact.iter().chain(&run.trace);
    let panel = Frame::narrow(
        place,
        frame::range(both().map(|point| point.angle_rad.clamp(-1e3, 1e3)), 0.04),
        frame::range(
            both().map(|point| point.velocity_rad_s.clamp(-1e5, 1e5)),
            0.06,
        ),
    );
    let letter = char::from(b'a' + u8::try_from(index.min(25)).unwrap_or(25));
    let verdict = if run.gains_energy {
        "gains energy, fails"
    } else if run.amplification > 1.0 {
        "amplifies in contact"
    } else {
        "stable"
    };
    panel.title(
        canvas,
        &format!(
            "({letter}) N = {}, ωR·Δt = {}: {verdict}",
            count(u64::from(run.steps_per_period)),
            significant(run.reach, 3)
        ),
    );
    panel.grid(
        canvas,
        Some("angle φ [rad]"),
        Some("angular velocity φ′ [rad/s]"),
    );
    panel.begin_inside(canvas, &format!("{NAME}-phase-{index}"));
    panel.level(canvas, "zero", 0.0);
    panel.upright(canvas, "zero", 0.0);
    let points = run
        .trace
        .iter()
        .map(|point| (point.angle_rad, point.velocity_rad_s));
    panel.curve(canvas, "line soft", points, MOST_POINTS);
    let points = exact
        .iter()
        .map(|point| (point.angle_rad, point.velocity_rad_s));
    panel.curve(canvas, "line nothing", points, MOST_POINTS);
    canvas.end_group();
    panel.frame(canvas);
    speed_ratios(canvas, &panel, result, run);
}

/// Writes the first ratios of exit to entry speed, against the right one.
fn speed_ratios(canvas: &mut Canvas, panel: &Frame, result: &StepSize, run: &FixedStepRun) {
    if run.exit_over_entry.is_empty() {
        return;
    }
    let ratios: Vec<String> = run
        .exit_over_entry
        .iter()
        .take(4)
        .map(|ratio| significant(*ratio, 3))
        .collect();
    let right = result
        .right_ratio
        .map_or_else(|| "none".into(), |right| significant(right, 3));
    canvas.text(
        "small halo",
        (panel.right - 8.0, panel.bottom - 26.0),
        Anchor::End,
        "exit/entry speed, contact by contact:",
    );
    canvas.text(
        "small halo",
        (panel.right - 8.0, panel.bottom - 10.0),
        Anchor::End,
        &format!("{} (right: {right})", ratios.join(", ")),
    );
}

/// Speed ratios that the panel of the limit shows.
const RATIOS: (f64, f64) = (0.0, 1.6);

fn limit(canvas: &mut Canvas, result: &StepSize, place: frame::PanelPlace) {
    let steps = Scale::Logarithmic(
        result
            .scan
            .first()
            .map_or(1.0, |scan| scan.steps_per_period),
        result
            .scan
            .last()
            .map_or(10.0, |scan| scan.steps_per_period),
    );
    let panel = Frame::narrow(place, steps, Scale::Linear(RATIOS.0, RATIOS.1));
    panel.title(
        canvas,
        "Speed that one contact gives back, over all phases at which a step can meet the stop",
    );
    panel.grid(
        canvas,
        Some("steps per period of the excitation, N [–]"),
        Some("exit speed/entry speed [–]"),
    );
    panel.begin_inside(canvas, "step-size-limit");
    let (failing, _) = panel.place(result.limit_steps_per_period, 0.0);
    if failing > panel.left {
        let size = (failing - panel.left, panel.bottom - panel.top);
        canvas.rectangle("pull", panel.corner(), size);
    }
    panel.level(canvas, "edge", 1.0);
    ratios(canvas, &panel, result);
    if let Some(right) = result.right_ratio {
        panel.level(canvas, "line nothing", right);
    }
    for run in &result.runs {
        panel.upright(canvas, "edge", f64::from(run.steps_per_period));
    }
    panel.upright(canvas, "limit", result.limit_steps_per_period);
    canvas.end_group();
    panel.frame(canvas);
    limit_words(canvas, &panel, result);
}

/// Draws the least and the largest ratio over the phases, and what lies between.
fn ratios(canvas: &mut Canvas, panel: &Frame, result: &StepSize) {
    let seen: Vec<&StepScan> = result
        .scan
        .iter()
        .filter(|scan| scan.least_ratio.is_finite() && scan.largest_ratio.is_finite())
        .collect();
    canvas.begin_path("between");
    let hold = |ratio: f64| ratio.clamp(RATIOS.0 - 1.0, RATIOS.1 + 1.0);
    let upper = seen.iter().map(|scan| (scan, scan.largest_ratio));
    let lower = seen.iter().rev().map(|scan| (scan, scan.least_ratio));
    for (index, (scan, ratio)) in upper.chain(lower).enumerate() {
        let at = panel.place(scan.steps_per_period, hold(ratio));
        if index == 0 {
            canvas.move_to(at);
        } else {
            canvas.line_to(at);
        }
    }
    canvas.end_path();
    for bound in [
        |scan: &&StepScan| scan.least_ratio,
        |scan: &&StepScan| scan.largest_ratio,
    ] {
        let points = seen
            .iter()
            .map(|scan| (scan.steps_per_period, hold(bound(scan))));
        panel.function(canvas, "line soft", points);
    }
}

fn limit_words(canvas: &mut Canvas, panel: &Frame, result: &StepSize) {
    let (failing, _) = panel.place(result.limit_steps_per_period, 0.0);
    for run in &result.runs {
        let steps = f64::from(run.steps_per_period);
        let (x, _) = panel.place(steps, 0.0);
        if x > panel.left && x < panel.right {
            let (x, anchor) = if steps < result.limit_steps_per_period {
                (x - 6.0, Anchor::End)
            } else {
                (x + 6.0, Anchor::Start)
            };
            let text = format!("N = {}", count(u64::from(run.steps_per_period)));
            canvas.text("small halo", (x, panel.bottom - 10.0), anchor, &text);
        }
    }
    canvas.text(
        "alarm small halo",
        (failing + 8.0, panel.top + 18.0),
        Anchor::Start,
        &format!(
            "left of N = {} each step amplifies: ωR·Δt > {}",
            significant(result.limit_steps_per_period, 4),
            significant(result.limit, 4)
        ),
    );
    canvas.text(
        "muted small halo",
        (panel.right - 8.0, panel.y.place(1.0) - 6.0),
        Anchor::End,
        "above this line the contact gives energy",
    );
}
