//! The contest: what latchgate itself enters, and the tables that come of it.

use super::contest::{Entry, Off, Table, race};
use super::scenes;
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::batch::{self, MemberPeak};
use latchgate_kernel::replay::{self, Method, Run, RunOptions};
use latchgate_kernel::signal::{Reading, Signal};
use latchgate_kernel::units::OpensWhen;
use latchgate_verdict::conditioning::between::{self, Between};
use std::borrow::Cow;
use std::hint::black_box;
use std::ops::Range;

/// Rounds of a race where times count.
const ROUNDS: usize = 24;

/// The readings that are timed: the default of a verdict, and the one that the other programs solve.
const READINGS: [Between; 2] = [Between::BandLimited, Between::Linear];

/// Races on the recording and on its chattering twentieth, both stops, and prints the tables: by the default
/// reading of the samples first, then by straight lines.
///
/// `others` adds entries to those on straight lines through the recording. Unless `timed` each program runs
/// for one round, to show that it runs.
pub fn contest(
    timed: bool,
    others: &dyn for<'a> Fn(&'a Signal, StopModel, &Run) -> Vec<Entry<'a>>,
) {
    let rounds = if timed { ROUNDS } else { 1 };
    let rounds_said = if timed {
        format!("up to {ROUNDS} rounds")
    } else {
        "one round".into()
    };
    println!("Time: the least of {rounds_said}, in which the programs of a table run in turns,");
    println!("lap by lap (two threads: as a whole), per sample interval of one lever.");
    println!("Off: distance from the kernel's answer on the same reading.\n");
    for (scale, scene) in [
        (1.0, "recording of 0.3 s, 10 kHz, 200 g"),
        (scenes::CHATTER, "the same times 0.05: chatter"),
    ] {
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let signal = scenes::recording(scale);
            let [band_limited, straight] = READINGS.map(|between| read(&signal, between));
            let mut entries = of_reading("band-limited", &band_limited, stop);
            entries.extend(of_reading("straight", &straight, stop));
            let truth = truth(&straight, stop);
            entries.push(paper(&signal, stop, &truth));
            if scale >= 1.0 {
                entries.extend(others(&signal, stop, &truth));
            }
            let rows = race(entries, rounds);
            let title = format!("{scene}; {} stop", stop.name());
            print!("{}", Table(&title, &rows));
            let million: Vec<String> = rows
                .iter()
                .filter(|row| row.levers > 1)
                .map(|row| {
                    let samples = 1e6 * (signal.samples.len() - 1) as f64;
                    format!("{:.1} s", row.ns_per_sample * 1e-9 * samples)
                })
                .collect();
            println!("  a million levers, scaled: {}\n", million.join(" and "));
        }
    }
}

/// Returns the samples of `signal` as they are read between.
fn read(signal: &Signal, between: Between) -> Reading<'static> {
    between::read(Cow::Owned(signal.clone()), between).expect("the scene is valid")
}

/// Returns the kernel and its batches on one reading.
fn of_reading<'a>(name: &str, reading: &'a Reading<'static>, stop: StopModel) -> Vec<Entry<'a>> {
    let mut entries = kernel(reading, stop);
    entries.extend(batches(reading, stop));
    for entry in &mut entries {
        entry.name = format!("{name}: {}", entry.name);
    }
    entries
}

/// Returns what the kernel says of a reading for the reference lever, with its error bound.
fn truth(reading: &Reading<'_>, stop: StopModel) -> Run {
    run(reading, &RunOptions::new(stop, OpensWhen::Negative))
}

fn run<'a>(reading: impl Into<Reading<'a>>, options: &RunOptions) -> Run {
    replay::run(reading, &Design::reference(), options)
        .expect("the scene is valid")
        .run
}

/// Returns how far an answer is off the kernel's.
pub fn distance(truth: &Run, peak_rad: f64, final_rad: f64, crossing_s: Option<f64>) -> Off {
    Off {
        peak_rad: Some((peak_rad - truth.peak_angle_rad).abs()),
        final_rad: Some((final_rad - truth.final_angle_rad).abs()),
        crossing_s: crossing_s
            .zip(truth.first_crossing_s)
            .map(|(got, want)| (got - want).abs()),
    }
}

/// The kernel without and with its error bound, on two axes and beside a catch.
fn kernel<'a>(reading: &'a Reading<'static>, stop: StopModel) -> Vec<Entry<'a>> {
    let with_bound = RunOptions::new(stop, OpensWhen::Negative);
    let bound = Off {
        peak_rad: Some(truth(reading, stop).numerical_error_rad),
        ..Off::default()
    };
    let plain = scenes::plain(stop, Method::EventDriven);
    let two_axes = reading.clone().beside(reading.scaled(0.5, 0.0));
    let beside_a_catch = Design {
        lever: Design::reference().lever,
        ..latchgate_study::catch::example()
    };
    let own = Design::reference();
    vec![
        single(
            "kernel",
            reading,
            own.clone(),
            plain.clone(),
            Off::default(),
        ),
        single(
            "kernel, error bound shown",
            reading,
            own.clone(),
            with_bound,
            bound,
        ),
        single(
            "two in-plane axes",
            two_axes.expect("both have one clock"),
            own,
            plain.clone(),
            Off::default(),
        ),
        single(
            "beside a catch",
            reading,
            beside_a_catch,
            plain,
            Off::default(),
        ),
    ]
}

/// The paper's method at the paper's step.
fn paper<'a>(signal: &'a Signal, stop: StopModel, truth: &Run) -> Entry<'a> {
    let options = scenes::as_in_the_paper(stop);
    let got = run(signal, &options);
    let off = distance(
        truth,
        got.peak_angle_rad,
        got.final_angle_rad,
        got.first_crossing_s,
    );
    single(
        "straight: the paper's RK4, 3 steps a sample",
        signal,
        Design::reference(),
        options,
        off,
    )
}

fn single<'a>(
    name: &str,
    reading: impl Into<Reading<'a>>,
    design: Design,
    options: RunOptions,
    off: Off,
) -> Entry<'a> {
    let reading = reading.into();
    Entry {
        name: name.into(),
        samples: reading.signal().samples.len() - 1,
        levers: 1,
        off,
        run: Box::new(move |_| {
            black_box(replay::run(black_box(&reading), &design, &options).expect("ran before"));
        }),
    }
}

/// A batch on one and on two threads, and how far the farthest of 25 members is off its own
/// scalar run.
fn batches<'a>(reading: &'a Reading<'static>, stop: StopModel) -> Vec<Entry<'a>> {
    let peaks = peaks(reading, stop, 1, 0..scenes::LEVERS);
    let farthest = (0..scenes::LEVERS)
        .step_by(scenes::LEVERS / 25)
        .map(|index| {
            let design = Design {
                lever: scenes::lever(index).lever,
                ..Design::reference()
            };
            let alone = replay::run(reading, &design, &scenes::plain(stop, Method::EventDriven))
                .expect("the scene is valid");
            (alone.run.peak_angle_rad - peaks[index].peak_angle_rad).abs()
        })
        .fold(0.0, f64::max);
    let entry = |name: &str, run| Entry {
        name: format!("batch of {}, {name}", scenes::LEVERS),
        samples: reading.signal().samples.len() - 1,
        levers: scenes::LEVERS,
        off: Off {
            peak_rad: Some(farthest),
            ..Off::default()
        },
        run,
    };
    vec![
        entry(
            "1 thread",
            Box::new(move |laps| {
                for first in (0..scenes::LEVERS).step_by(LAP_LEVERS) {
                    let last = scenes::LEVERS.min(first + LAP_LEVERS);
                    black_box(self::peaks(black_box(reading), stop, 1, first..last));
                    laps.end_lap();
                }
            }),
        ),
        entry(
            "2 threads",
            Box::new(move |_| {
                black_box(self::peaks(black_box(reading), stop, 2, 0..scenes::LEVERS));
            }),
        ),
    ]
}

/// Levers that a batch on one thread takes in a lap: some milliseconds, and whole vectors of any width.
const LAP_LEVERS: usize = 64;

fn peaks(
    reading: &Reading<'_>,
    stop: StopModel,
    threads: usize,
    levers: Range<usize>,
) -> Vec<MemberPeak> {
    let options = scenes::peaks_only(stop, threads);
    let lever = |index| scenes::lever(levers.start + index);
    let parts = replay::subdivision(reading.signal().rate, &Design::reference(), stop);
    batch::peaks(reading.divided(parts), levers.len(), &lever, &options)
        .expect("the scene is valid")
}
