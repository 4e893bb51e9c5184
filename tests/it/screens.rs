//! Guards the closed-form bounds: never wrong against replays, sharp where they can be, and
//! decisive on the cases they were made for.

use crate::lever_cases::{Random, random_design, signal};
use latchgate::conditioning::Signal;
use latchgate::model::Design;
use latchgate::model::stop::StopModel;
use latchgate::replay::batch::{self, BatchOptions, Member};
use latchgate::replay::{self, RunOptions};
use latchgate::units::{OpensWhen, STANDARD_GRAVITY};
use latchgate::verdict::screen::{self, Decided, Screen, Screened, Seen, Subject};
use std::collections::BTreeMap;
use std::f64::consts::PI;

const OPENS: OpensWhen = OpensWhen::Negative;

fn subject(design: &Design, model: StopModel) -> Subject {
    Subject {
        lever: design.lever,
        stop: design.stop,
        model,
        threshold_rad: design.criterion.threshold_rad,
        initial: None,
        window: None,
    }
}

fn screened(design: &Design, model: StopModel, signal: &Signal) -> Screened {
    screen::screen(&subject(design, model), &Seen::of(signal, OPENS))
}

/// The largest angle, coast included.
fn peak(design: &Design, model: StopModel, signal: &Signal) -> f64 {
    let run = replay::run(signal, design, &RunOptions::new(model, OPENS))
        .unwrap()
        .run;
    run.peak_angle_rad
        .max(run.coast_peak_angle_rad.unwrap_or(f64::NEG_INFINITY))
}

fn scaled(signal: &Signal, scale: f64) -> Signal {
    Signal {
        samples: signal.samples.iter().map(|a| scale * a).collect(),
        ..signal.clone()
    }
}

/// Pulses one after another: amplitude [g] (negative opens), duration [s], shape.
#[derive(Clone, Copy)]
enum Shape {
    HalfSine,
    /// Terminal-peak sawtooth.
    Sawtooth,
    Pause,
}

fn pulses(rate: f64, parts: &[(Shape, f64, f64)]) -> Signal {
    let total: f64 = parts.iter().map(|part| part.2).sum();
    let count = (total * rate).round() as usize;
    let samples = (0..=count)
        .map(|k| {
            let mut t = k as f64 / rate;
            for &(shape, amplitude, duration) in parts {
                if t < duration - 1e-9 / rate {
                    return STANDARD_GRAVITY
                        * amplitude
                        * match shape {
                            Shape::HalfSine => libm::sin(PI * t / duration),
                            Shape::Sawtooth => t / duration,
                            Shape::Pause => 0.0,
                        };
                }
                t -= duration;
            }
            0.0
        })
        .collect();
    signal(rate, samples)
}

/// The largest scale, to 1e-9, at which `holds` is true; it is at `low`, not at `high`.
fn flip(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    assert!(holds(low) && !holds(high));
    while high > low * (1.0 + 1e-9) {
        let middle = (low * high).sqrt();
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

// What the bounds are held to on single recordings.

/// The scales at which the proof of a pass ends, the threshold is exceeded, and the proof of a
/// failure begins.
fn boundaries(design: &Design, model: StopModel, signal: &Signal) -> [f64; 3] {
    let of = |scale: f64| {
        screen::decide(
            &subject(design, model),
            &Seen::of(signal, OPENS).changed(scale, 0.0),
        )
    };
    [
        flip(1e-3, 1e3, |scale| of(scale) == Some(Decided::Pass)),
        flip(1e-3, 1e3, |scale| {
            peak(design, model, &scaled(signal, scale)) <= design.criterion.threshold_rad
        }),
        flip(1e-3, 1e3, |scale| of(scale) != Some(Decided::Fail)),
    ]
}

/// The proofs of pass and failure enclose the truth, each within its share.
#[track_caller]
fn check_sharp(label: &str, design: &Design, model: StopModel, signal: &Signal, within: (f64, f64)) {
    let [pass, truth, fail] = boundaries(design, model, signal);
    let (below, above) = (truth / pass - 1.0, fail / truth - 1.0);
    println!("{label}: truth {truth:.6}, pass proven to {below:.2e} below, failure from {above:.2e} above");
    assert!(below >= -1e-8 && above >= -1e-8, "{label}: a bound is wrong");
    assert!(
        below < within.0 && above < within.1,
        "{label}: {below:e} and {above:e}, expected {within:?}"
    );
}

/// One half-sine on the paper's lever: the amplitudes at which 0.1 rad is just reached, on
/// which the bounds close in from both sides.
#[test]
fn val_bounds_enclose_the_half_sine_that_just_opens() {
    let design = Design::reference();
    for (milliseconds, amplitude) in [
        (1.0, 77.6),
        (2.0, 39.2),
        (3.0, 26.4),
        (5.0, 16.2),
        (8.0, 10.45),
        (10.0, 8.53),
        (15.0, 5.98),
        (20.0, 4.71),
        (35.0, 3.08),
    ] {
        let pulse = pulses(
            50_000.0,
            &[
                (Shape::HalfSine, -amplitude, 1e-3 * milliseconds),
                (Shape::Pause, 0.0, 0.12),
            ],
        );
        let label = format!("{milliseconds} ms");
        check_sharp(&label, &design, StopModel::Rigid, &pulse, (0.012, 0.012));
        let [_, truth, _] = boundaries(&design, StopModel::Rigid, &pulse);
        assert!((truth - 1.0).abs() < 1.5e-3, "{label}: {truth}");
        let [pass, truth, fail] = boundaries(&design, StopModel::Soft, &pulse);
        println!("{label} soft: {pass} {truth} {fail}");
        assert!(pass <= truth && truth <= fail && fail < 1.02 * truth, "{label} soft");
    }
}
