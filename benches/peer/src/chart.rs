//! The methods of latchgate and `diffsol` as entrants of `./chart`, and the scene that all entrants share.

use crate::lever::{self, Stops, Task};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, Method, RunOptions};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate_study::cases::{self, BetweenSamples, StudyCase};
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::time::Instant;

const STOPS: [StopModel; 2] = [StopModel::Rigid, StopModel::Soft];

/// The scene of `study work-precision` whose truth is a formula.
fn scene() -> BetweenSamples {
    cases::between_samples(STANDARD_GRAVITY).expect("the rates are valid")
}

/// Its samples.
fn signal() -> Signal {
    scene().read[0].signal().expect("it has samples").clone()
}

fn peaks_of(case: &StudyCase) -> [f64; 2] {
    STOPS.map(|stop| {
        let options = RunOptions::new(stop, OpensWhen::Negative);
        let outcome = case.replay(&Design::reference(), &options);
        outcome.expect("the scene is valid").run.peak_angle_rad
    })
}

/// Prints the scene: a line for each quantity of the lever in SI units, then the samples [m/s²].
pub fn print_scene() {
    let scene = scene();
    let signal = signal();
    let Design { lever, stop, .. } = Design::reference();
    // What is left open by how finely the formula is sampled.
    let (truth, check) = (peaks_of(&scene.truth), peaks_of(&scene.check));
    let apart = |index: usize| (truth[index] - check[index]).abs();
    let floor = apart(0).max(apart(1));
    let quantities = [
        ("start", signal.start_s),
        ("rate", signal.rate.hertz()),
        ("inertia", lever.moment_of_inertia_kg_m2),
        ("unbalance", lever.unbalance_kg_m()),
        ("preload", lever.preload_torque_nm),
        ("stiffness", lever.spring_stiffness_nm_per_rad),
        ("damping", lever.pivot_damping_nm_s_per_rad),
        (
            "contact_stiffness",
            stop.contact_stiffness_nm_per_rad(&lever),
        ),
        ("contact_damping", stop.contact_damping_nm_s_per_rad(&lever)),
        ("rest_angle", stop.rest_angle_rad(&lever)),
        ("restitution", stop.restitution),
        ("lift_off", lever.lift_off_acceleration_m_s2()),
        ("rigid_truth", truth[0]),
        ("soft_truth", truth[1]),
        ("floor", floor),
        ("samples", signal.samples.len() as f64),
    ];
    for (name, value) in quantities {
        println!("{name} {value:e}");
    }
    for sample in &signal.samples {
        println!("{sample:e}");
    }
}

/// What one run of both stops gave.
struct Peaks {
    /// Peak angles on the rigid and the soft stop [rad].
    peaks_rad: [f64; 2],
    /// The uncertainty that a verdict states [rad]; not a number where none is stated.
    bound_rad: f64,
}

type Entrant<'a> = (String, Box<dyn Fn() -> Peaks + 'a>);

/// Prints the name of each entrant, then answers each line with a number of theirs: two peaks [rad],
/// bound [rad] and time [s].
pub fn answer() {
    let scene = scene();
    let signal = signal();
    let mut entrants = entrants(&signal);
    for case in scene.read.iter().rev() {
        let between = case.between().expect("it has samples");
        let run = || Peaks {
            peaks_rad: peaks_of(case),
            bound_rad: f64::NAN,
        };
        entrants.insert(0, (format!("latchgate\t{between}"), Box::new(run)));
    }
    for (name, _) in &entrants {
        println!("{name}");
    }
    println!();
    for line in std::io::stdin().lock().lines() {
        let line = line.expect("standard input is text");
        let (_, run) = &entrants[line.parse::<usize>().expect("the number of an entrant")];
        let started = Instant::now();
        let peaks = black_box(run());
        let seconds = started.elapsed().as_secs_f64();
        let [rigid, soft] = peaks.peaks_rad;
        println!("{rigid:e} {soft:e} {:e} {seconds:e}", peaks.bound_rad);
        std::io::stdout().flush().expect("somebody listens");
    }
}

fn entrants(signal: &Signal) -> Vec<Entrant<'_>> {
    let mut entrants: Vec<Entrant<'_>> = Vec::new();
    let steps = [3000, 10_000, 30_000, 100_000, 300_000, 1_000_000];
    for steps_per_period in steps {
        let setting = format!("N = {steps_per_period}");
        let methods = [
            ("paper", Method::Rk4 { steps_per_period }),
            ("rk4-located", Method::Rk4Located { steps_per_period }),
        ];
        for (name, method) in methods {
            entrants.push(own(name, &setting, method, None, signal));
        }
    }
    for tolerance in [1e-5, 1e-7, 1e-9, 1e-11, 1e-13] {
        for (name, at_samples) in [("dopri5", false), ("dopri5-samples", true)] {
            let method = Method::Dopri5 { at_samples };
            entrants.push(own(
                name,
                &format!("{tolerance:e}"),
                method,
                Some(tolerance),
                signal,
            ));
        }
    }
    for tolerance in [1e-6, 1e-9, 1e-12, 1e-14] {
        for (name, stops) in [
            ("diffsol", Stops::AtEvents),
            ("diffsol-samples", Stops::AtSamplesToo),
        ] {
            let run = move || {
                let peaks_rad = STOPS.map(|stop| {
                    let design = Design::reference();
                    let task = Task {
                        signal,
                        design,
                        stop,
                        stops,
                        tolerance,
                    };
                    lever::run(&task, &mut || ()).map_or(f64::NAN, |answer| answer.peak_angle_rad)
                });
                Peaks {
                    peaks_rad,
                    bound_rad: f64::NAN,
                }
            };
            entrants.push((format!("{name}\t{tolerance:e}"), Box::new(run)));
        }
    }
    entrants
}

/// A method of latchgate to compare with, on straight lines.
fn own<'a>(
    name: &str,
    setting: &str,
    method: Method,
    tolerance_rad: Option<f64>,
    signal: &'a Signal,
) -> Entrant<'a> {
    let run = move || {
        let runs = STOPS.map(|stop| {
            let options = RunOptions {
                method,
                tolerance_rad,
                error_bound: false,
                ..RunOptions::new(stop, OpensWhen::Negative)
            };
            replay::run(signal, &Design::reference(), &options).expect("the scene is valid")
        });
        Peaks {
            peaks_rad: [0, 1].map(|index: usize| {
                let outcome = &runs[index];
                if outcome.broke_down {
                    f64::NAN
                } else {
                    outcome.run.peak_angle_rad
                }
            }),
            bound_rad: f64::NAN,
        }
    };
    (format!("{name}\t{setting}"), Box::new(run))
}
