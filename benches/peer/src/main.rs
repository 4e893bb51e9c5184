//! The kernel, batches, the paper's method and `diffsol` on one recording, timed in turns.
//!
//! `cargo run --release` in this folder; `-- --once` does without repetitions, to see that it runs.
//! The program first proves that the other one solves the same problem, and stops if it does not.
//! `-- scene` and `-- methods` are the part of this program in `./chart`.

mod chart;
#[path = "../../support/contest.rs"]
mod contest;
mod lever;
#[path = "../../support/own.rs"]
mod own;
#[path = "../../support/scenes.rs"]
#[allow(dead_code, reason = "each program uses a part of it")]
mod scenes;

use contest::Entry;
use latchgate_kernel::signal::Signal;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::Run;
use lever::{Answer, Stops, Task};
use std::hint::black_box;

/// Tolerances that the other program is given, relative and absolute alike.
const TOLERANCES: [f64; 3] = [1e-6, 1e-9, 1e-12];

/// Distance from the kernel's peak and final angle [rad] and first crossing [s] that the other
/// program must reach at its tightest tolerance, lest a broken run be timed.
const FAIR: f64 = 1e-6;

fn main() {
    match std::env::args().nth(1).as_deref() {
        Some("scene") => return chart::print_scene(),
        Some("methods") => return chart::answer(),
        _ => (),
    }
    let timed = !std::env::args().any(|argument| argument == "--once");
    own::contest(timed, &peers);
}

fn peers<'a>(signal: &'a Signal, stop: StopModel, truth: &Run) -> Vec<Entry<'a>> {
    [Stops::AtEvents, Stops::AtSamplesToo]
        .into_iter()
        .flat_map(|stops| TOLERANCES.map(|tolerance| peer(signal, stop, truth, stops, tolerance)))
        .collect()
}

fn peer<'a>(
    signal: &'a Signal,
    stop: StopModel,
    truth: &Run,
    stops: Stops,
    tolerance: f64,
) -> Entry<'a> {
    let design = Design::reference();
    let task = Task {
        signal,
        design,
        stop,
        stops,
        tolerance,
    };
    let answer = lever::run(&task, &mut || ()).expect("diffsol follows the lever");
    let where_stopped = match stops {
        Stops::AtEvents => "",
        Stops::AtSamplesToo => " at samples",
    };
    let name = format!(
        "diffsol {tolerance:.0e}{where_stopped}, {} steps",
        answer.steps
    );
    let entry = Entry {
        name,
        samples: signal.samples.len() - 1,
        levers: 1,
        off: own::distance(
            truth,
            answer.peak_angle_rad,
            answer.final_angle_rad,
            answer.first_crossing_s,
        ),
        run: Box::new(move |laps| {
            let mut end_lap = || laps.end_lap();
            black_box(lever::run(black_box(&task), &mut end_lap).expect("ran before"));
        }),
    };
    if tolerance <= TOLERANCES[TOLERANCES.len() - 1] {
        check_fair(&entry, &answer, truth);
    }
    entry
}

/// Panics unless the other program solved the kernel's problem.
fn check_fair(entry: &Entry<'_>, answer: &Answer, truth: &Run) {
    let near = |what: Option<f64>| what.is_some_and(|distance| distance < FAIR);
    assert!(
        near(entry.off.peak_rad)
            && near(entry.off.final_rad)
            && near(entry.off.crossing_s)
            && (answer.final_velocity_rad_s - truth.final_velocity_rad_s).abs() < 100.0 * FAIR
            && answer.impacts == truth.impacts,
        "{} solves another problem: {answer:?}, {:?}; the kernel: {truth:?}",
        entry.name,
        entry.off
    );
}
