//! Phase diagrams of the fixed-step method, and the limit of its step.

use crate::step_size::{FixedStepRun, StepScan, StepSize};
use latchgate_document::number::{count, significant};
use latchgate_kernel::replay::TracePoint;
use latchgate_report::plot::chart::At::{High, Low, Value};
use latchgate_report::plot::chart::{Chart, Edges, HALVES, Panel, Point, Points, WHOLE};
use latchgate_report::plot::frame::{LegendEntry, NARROW, Scale, range};

/// Largest number of points of a phase diagram.
const MOST_POINTS: usize = 5000;

pub(super) fn chart(result: &StepSize) -> Chart {
    let runs = result
        .runs
        .iter()
        .zip('a'..)
        .zip(HALVES.into_iter().cycle());
    let phases = runs.map(|((run, letter), edges)| phase(result, run, letter, edges));
    Chart {
        name: "step-size",
        title: "Free impacts by Runge–Kutta with a fixed step, soft stop".into(),
        notes: vec![
            "The step is the period of the excitation over N; event-driven is the motion as it is."
                .into(),
        ],
        legend: vec![
            LegendEntry::line("line nothing", "event-driven"),
            LegendEntry::line("line soft", "Runge–Kutta"),
        ],
        panels: phases.chain([limit(result)]).collect(),
        room: [24.0, 82.0, 54.0],
        caption: "The paper's Fig. 3, and where the step's limit lies.".into(),
        description: description(result),
        ..Chart::default()
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

fn phase(result: &StepSize, run: &FixedStepRun, letter: char, edges: Edges) -> Panel {
    let exact = &result.exact.trace;
    let points = |trace: &[TracePoint]| -> Points {
        let points = trace.iter();
        points
            .map(|point| Point::new(point.angle_rad, point.velocity_rad_s))
            .collect()
    };
    let ratios = run.exit_over_entry.iter().take(4);
    let ratios: Vec<String> = ratios.map(|ratio| significant(*ratio, 3)).collect();
    let right = result.right_ratio;
    let right = right.map_or_else(|| "none".into(), |right| significant(right, 3));
    let words = [
        (-26.0, "exit/entry speed, contact by contact:".into()),
        (-10.0, format!("{} (right: {right})", ratios.join(", "))),
    ];
    let words = words.into_iter().filter(|_| !ratios.is_empty());
    let verdict = if run.gains_energy {
        "gains energy, fails"
    } else if run.amplification > 1.0 {
        "amplifies in contact"
    } else {
        "stable"
    };
    let both = || exact.iter().chain(&run.trace);
    let angles = both().map(|point| point.angle_rad.clamp(-1e3, 1e3));
    let velocities = both().map(|point| point.velocity_rad_s.clamp(-1e5, 1e5));
    let steps = count(u64::from(run.steps_per_period));
    let reach = significant(run.reach, 3);
    Panel::new(&NARROW, edges, 270.0)
        .title(format!(
            "({letter}) N = {steps}, ωR·Δt = {reach}: {verdict}"
        ))
        .x("angle φ [rad]", range(angles, 0.04))
        .y("angular velocity φ′ [rad/s]", range(velocities, 0.06))
        .level("zero", 0.0)
        .upright("zero", 0.0)
        .curve("line soft", points(&run.trace), MOST_POINTS)
        .curve("line nothing", points(exact), MOST_POINTS)
        .each(words, |panel, (y, text)| {
            panel.text("small halo", (High(-8.0), Low(y)), text)
        })
}

fn limit(result: &StepSize) -> Panel {
    let limit = result.limit_steps_per_period;
    let steps_per_period = || result.scan.iter().map(|scan| scan.steps_per_period);
    let (low, high) = (
        steps_per_period().next().unwrap_or(1.0),
        steps_per_period().next_back().unwrap_or(10.0),
    );
    let is_shown = |run: &&FixedStepRun| (low..high).contains(&f64::from(run.steps_per_period));
    let runs = result.runs.iter().filter(is_shown);
    // The band between the least and the largest ratio over the phases.
    let bound = |ratio: fn(&StepScan) -> f64| -> Points {
        let points = result.scan.iter();
        let points = points.filter(|scan| ratio(scan).is_finite());
        points
            .map(|scan| Point::new(scan.steps_per_period, ratio(scan).clamp(-1.0, 3.0)))
            .collect()
    };
    let (least, largest) = (
        bound(|scan| scan.least_ratio),
        bound(|scan| scan.largest_ratio),
    );
    let outline: Points = largest.iter().chain(least.iter().rev()).copied().collect();
    Panel::new(&NARROW, WHOLE, 230.0)
        .title(
            "Speed that one contact gives back, over all phases at which a step can meet the stop",
        )
        .x(
            "steps per period of the excitation, N [–]",
            Scale::Logarithmic(low, high),
        )
        .y("exit speed/entry speed [–]", Scale::Linear(0.0, 1.6))
        .band("pull", low, limit.max(low))
        .level("edge", 1.0)
        .lines("between", outline)
        .function("line soft", least)
        .function("line soft", largest)
        .each(result.right_ratio, |panel, right| {
            panel.level("line nothing", right)
        })
        .each(runs, |panel, run| {
            let steps = f64::from(run.steps_per_period);
            let beside = if steps < limit { -6.0 } else { 6.0 };
            let text = format!("N = {}", count(u64::from(run.steps_per_period)));
            panel.upright("edge", steps).text(
                "small halo",
                (Value(steps, beside), Low(-10.0)),
                text,
            )
        })
        .upright("limit", limit)
        .text(
            "alarm small halo",
            (Value(limit, 8.0), High(18.0)),
            format!(
                "left of N = {} each step amplifies: ωR·Δt > {}",
                significant(limit, 4),
                significant(result.limit, 4)
            ),
        )
        .text(
            "muted small halo",
            (High(-8.0), Value(1.0, -6.0)),
            "above this line the contact gives energy",
        )
}
