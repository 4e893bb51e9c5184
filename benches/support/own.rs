//! The entries of a contest that latchgate itself provides.

use super::contest::{Entry, Off};
use super::scenes;
use latchgate::conditioning::Signal;
use latchgate::model::Design;
use latchgate::model::stop::StopModel;
use latchgate::replay::batch::{self, MemberPeak};
use latchgate::replay::{self, Method, Run, RunOptions};
use latchgate::units::OpensWhen;
use std::hint::black_box;

/// Rounds of a contest: as many as `cargo bench` needs for steady minima, one where the program
/// only has to show that it runs.
#[must_use]
pub fn rounds(timed: bool) -> usize {
    if timed { 24 } else { 1 }
}

/// Returns what the kernel says of `signal` for the reference lever, with its error bound.
#[must_use]
pub fn truth(signal: &Signal, stop: StopModel) -> Run {
    let options = RunOptions::new(stop, OpensWhen::Negative);
    run(signal, &options)
}

fn run(signal: &Signal, options: &RunOptions) -> Run {
    replay::run(signal, &Design::reference(), options)
        .expect("the scene is valid")
        .run
}

/// Returns how far an answer is off the kernel's, no closer than the kernel itself claims to be.
#[must_use]
pub fn distance(truth: &Run, peak_rad: f64, final_rad: f64, crossing_s: Option<f64>) -> Off {
    Off {
        peak_rad: Some((peak_rad - truth.peak_angle_rad).abs()),
        final_rad: Some((final_rad - truth.final_angle_rad).abs()),
        crossing_s: crossing_s
            .zip(truth.first_crossing_s)
            .map(|(got, want)| (got - want).abs()),
    }
}

/// The kernel without and with its error bound.
#[must_use]
pub fn kernel<'a>(signal: &'a Signal, stop: StopModel, truth: &Run) -> Vec<Entry<'a>> {
    let with_bound = RunOptions::new(stop, OpensWhen::Negative);
    let bound = Off {
        peak_rad: Some(truth.numerical_error_rad),
        ..Off::default()
    };
    vec![
        single(
            "kernel",
            signal,
            scenes::plain(stop, Method::EventDriven),
            Off::default(),
        ),
        single(
            "kernel, error bound (shown) included",
            signal,
            with_bound,
            bound,
        ),
    ]
}

/// The paper's method at the paper's step.
#[must_use]
pub fn paper<'a>(signal: &'a Signal, stop: StopModel, truth: &Run) -> Entry<'a> {
    let options = scenes::as_in_the_paper(stop);
    let got = run(signal, &options);
    let off = distance(
        truth,
        got.peak_angle_rad,
        got.final_angle_rad,
        got.first_crossing_s,
    );
    single("the paper's RK4, 3 steps a sample", signal, options, off)
}

fn single<'a>(name: &str, signal: &'a Signal, options: RunOptions, off: Off) -> Entry<'a> {
    let design = Design::reference();
    Entry {
        name: name.into(),
        samples: signal.samples.len() - 1,
        off,
        run: Box::new(move || {
            black_box(replay::run(black_box(signal), &design, &options).expect("ran before"));
        }),
    }
}

/// A batch on one and on two threads, and how far the farthest of 25 members is off its own
/// scalar run.
#[must_use]
pub fn batches<'a>(signal: &'a Signal, stop: StopModel) -> Vec<Entry<'a>> {
    let peaks = all_peaks(signal, stop, 1);
    let farthest = (0..scenes::LEVERS)
        .step_by(scenes::LEVERS / 25)
        .map(|index| {
            let design = Design {
                lever: scenes::lever(index).lever,
                ..Design::reference()
            };
            let alone = replay::run(signal, &design, &scenes::plain(stop, Method::EventDriven))
                .expect("the scene is valid");
            (alone.run.peak_angle_rad - peaks[index].peak_angle_rad).abs()
        })
        .fold(0.0, f64::max);
    [1, 2]
        .into_iter()
        .map(|threads| Entry {
            name: format!(
                "batch of {}, {threads} thread{}",
                scenes::LEVERS,
                if threads == 1 { "" } else { "s" }
            ),
            samples: (signal.samples.len() - 1) * scenes::LEVERS,
            off: Off {
                peak_rad: Some(farthest),
                ..Off::default()
            },
            run: Box::new(move || {
                black_box(all_peaks(black_box(signal), stop, threads));
            }),
        })
        .collect()
}

fn all_peaks(signal: &Signal, stop: StopModel, threads: usize) -> Vec<MemberPeak> {
    let options = scenes::peaks_only(stop, threads);
    batch::peaks(signal, scenes::LEVERS, &scenes::lever, &options).expect("the scene is valid")
}
