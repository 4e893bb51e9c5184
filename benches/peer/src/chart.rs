//! The methods of latchgate and `diffsol` as entrants of `./chart`, and the scene that all entrants share.

use crate::lever::{self, Stops, Task};
use latchgate_kernel::signal::Signal;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::{self, Method, RunOptions};
use latchgate_kernel::units::{OpensWhen, STANDARD_GRAVITY, SampleRate};
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::time::Instant;

/// Channel 150 of NHTSA test 7292: a car's centre of gravity, sideways [s, g].
const RECORDING: &str = include_str!("../../../tests/data/recordings/nhtsa_v07292.150");

/// Its sample rate [Hz].
const RATE_HZ: f64 = 12_500.0;

const STOPS: [StopModel; 2] = [StopModel::Rigid, StopModel::Soft];

/// The recording, its sign changed: positive accelerations open this door, negative ones the model's.
fn signal() -> Signal {
    let rows = RECORDING.lines().map(|line| {
        let mut cells = line.split('\t').map(|cell| cell.trim().parse::<f64>());
        let mut next = || cells.next().expect("two columns").expect("a number");
        (next(), next())
    });
    let rows: Vec<(f64, f64)> = rows.collect();
    Signal {
        start_s: rows[0].0,
        rate: SampleRate::from_hertz(RATE_HZ).expect("the rate is valid"),
        samples: rows.iter().map(|row| -row.1 * STANDARD_GRAVITY).collect(),
    }
}

/// Prints the scene: a line for each quantity of the lever in SI units, then the samples [m/s²].
pub fn print_scene() {
    let signal = signal();
    let Design { lever, stop, .. } = Design::reference();
    let quantities = [
        ("start", signal.start_s),
        ("rate", RATE_HZ),
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
    /// The larger error bound of the two [rad]; not a number where none is stated.
    bound_rad: f64,
}

type Entrant<'a> = (String, Box<dyn Fn() -> Peaks + 'a>);

/// Prints the name of each entrant, then answers each line with a number of theirs: two peaks [rad],
/// bound [rad] and time [s].
pub fn answer() {
    let signal = signal();
    let entrants = entrants(&signal);
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
    entrants.push(own(
        "latchgate",
        "default",
        Method::EventDriven,
        None,
        signal,
    ));
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

/// A method of latchgate. The event-driven one states a bound of its error; the others need a second run for theirs
/// and go without.
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
                error_bound: method == Method::EventDriven,
                ..RunOptions::new(stop, OpensWhen::Negative)
            };
            replay::run(signal, &Design::reference(), &options).expect("the scene is valid")
        });
        let bound = |index: usize| runs[index].run.numerical_error_rad;
        let stated = method == Method::EventDriven;
        Peaks {
            peaks_rad: [0, 1].map(|index: usize| {
                let outcome = &runs[index];
                if outcome.broke_down {
                    f64::NAN
                } else {
                    outcome.run.peak_angle_rad
                }
            }),
            bound_rad: if stated {
                bound(0).max(bound(1))
            } else {
                f64::NAN
            },
        }
    };
    (format!("{name}\t{setting}"), Box::new(run))
}
