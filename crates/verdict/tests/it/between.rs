//! Guards the reading within the samples' band: its derivatives, its polynomials, and the kernel on them.

use crate::support::{Random, random_design, random_signal};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::replay::batch::{self, AskedPeaks, BatchOptions, Member, SensorView};
use latchgate_kernel::replay::{self, Method, RunOptions};
use latchgate_kernel::signal::{Projection, Reading};
use latchgate_kernel::units::{OpensWhen, SampleRate};
use latchgate_verdict::conditioning::between::{self, Between};
use latchgate_verdict::conditioning::{Signal, resample};
use std::borrow::Cow;
use std::f64::consts::TAU;

fn read(signal: &Signal) -> Reading<'_> {
    between::read(Cow::Borrowed(signal), Between::BandLimited).unwrap()
}

fn sampled(count: usize, of: impl Fn(f64) -> f64) -> Signal {
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(1e4).unwrap(),
        samples: (0..count).map(|index| of(index as f64)).collect(),
    }
}

/// Samples are met bit for bit, and value, slope and bend go on from one polynomial to the next.
#[test]
fn verif_polynomials_meet_samples_and_each_other() {
    let mut random = Random(1);
    let signal = sampled(200, |_| 0.0);
    let samples = signal.samples.iter().map(|_| random.between(-50.0, 50.0));
    let signal = Signal {
        samples: samples.collect(),
        ..signal
    };
    let reading = read(&signal);
    for index in 0..signal.samples.len() - 1 {
        assert_eq!(reading.at(index, 0.0), Some(signal.samples[index]));
        let end = reading.at(index, 1.0).unwrap();
        assert!((end - signal.samples[index + 1]).abs() < 1e-11);
    }
    // The third difference of a course with two derivatives is of third order in the step.
    let step = 1e-3;
    for index in 1..signal.samples.len() - 1 {
        let of = |n: i32| {
            let part = f64::from(n) * step;
            let (index, part) = if part < 0.0 {
                (index - 1, 1.0 + part)
            } else {
                (index, part)
            };
            reading.at(index, part).unwrap()
        };
        let third = of(2) - 3.0 * of(1) + 3.0 * of(0) - of(-1);
        assert!(third.abs() < 3e-5, "{index}: {third}");
    }
    assert_eq!(reading.at(signal.samples.len() - 1, 0.0), None);
}

/// A reading times a factor and moved by an offset is that of such samples, within the intervals too.
#[test]
fn verif_a_scaled_reading_is_scaled_everywhere() {
    let tone = sampled(80, |index| 30.0 * (0.4 * index).sin());
    for reading in [read(&tone), Reading::from(&tone)] {
        let scaled = reading.scaled(-1.3, 0.7);
        for index in 0..79 {
            for part in [0.0, 0.31, 0.5, 0.9] {
                let expected = -1.3 * reading.at(index, part).unwrap() + 0.7;
                let found = scaled.at(index, part).unwrap();
                assert!((found - expected).abs() < 1e-12, "{index} {part}");
            }
        }
    }
}

/// A constant stays one; a tone is met between its samples, up to 0.35 of the rate.
#[test]
fn verif_constants_and_tones_are_met_between_their_samples() {
    let constant = sampled(80, |_| 3.7);
    for index in 0..79 {
        assert_eq!(read(&constant).at(index, 0.37), Some(3.7));
    }
    for part_of_rate in [0.02, 0.1, 0.2, 0.3, 0.35] {
        // Hermite's remainder, f⁽⁶⁾/6! x³(1 − x)³, and what the derivatives are off by.
        let tolerance = libm::pow(TAU * part_of_rate, 6.0) / (720.0 * 64.0) + 3e-6;
        let tone = |place: f64| (TAU * part_of_rate * place + 0.3).sin();
        let signal = sampled(400, tone);
        let reading = read(&signal);
        // Far from the ends, beyond which the samples are assumed.
        for index in 40..360 {
            for part in [0.25, 0.5, 0.7] {
                let error = reading.at(index, part).unwrap() - tone(index as f64 + part);
                assert!(error.abs() < tolerance, "{part_of_rate}: {error:e}");
            }
        }
    }
}

/// Between the samples it is what resampling finds there, of a smooth signal.
#[test]
fn verif_it_agrees_with_resampling() {
    let pulse = |place: f64| -300.0 * (-0.5 * ((place - 150.2) / 6.0).powi(2)).exp();
    let signal = sampled(300, pulse);
    let fine = resample::resample(&signal, SampleRate::from_hertz(4e4).unwrap()).unwrap();
    let reading = read(&signal);
    for (index, want) in fine.samples.iter().enumerate().take(1196) {
        let got = reading.at(index / 4, 0.25 * (index % 4) as f64).unwrap();
        assert!((got - want).abs() < 1e-3, "{index}: {got} {want}");
    }
}

/// What is told of the way from cubics is the difference of the two halfway.
#[test]
fn verif_the_way_beyond_cubics_is_that_halfway() {
    let signal = sampled(300, |t| {
        20.0 * (TAU * 0.21 * t).sin() + if t > 150.0 { 7.0 } else { 0.0 }
    });
    let reading = read(&signal);
    let (cubic, mut most) = (reading.cubic(), 0.0_f64);
    assert_eq!(reading.beyond_cubic().count(), 299);
    for (index, away) in reading.beyond_cubic().enumerate() {
        let halfway = reading.at(index, 0.5).unwrap() - cubic.at(index, 0.5).unwrap();
        assert!((away - halfway).abs() < 1e-12, "{index}: {away} {halfway}");
        most = most.max(away.abs());
    }
    assert!(most > 0.1);
    assert_eq!(Reading::from(&signal).beyond_cubic().count(), 0);
}

/// A reading whose intervals are divided is the same everywhere; by cubics as well.
#[test]
fn verif_divided_intervals_change_nothing() {
    let mut random = Random(7);
    let signal = random_signal(&mut random, 60, 5.0, 3e3);
    let quintic = read(&signal);
    for reading in [quintic.cubic(), (&quintic).into(), (&signal).into()] {
        let divided = reading.divided(3);
        assert_eq!(divided.is_straight(), reading.is_straight());
        for index in 0..signal.samples.len() - 1 {
            for part in [0.1, 0.5, 0.9] {
                let third = (3.0_f64 * part) as usize;
                let want = reading.at(index, part).unwrap();
                let got = divided
                    .at(3 * index + third, 3.0 * part - third as f64)
                    .unwrap();
                assert!(
                    (got - want).abs() < 1e-10 * (1.0 + want.abs()),
                    "{got} {want}"
                );
            }
        }
    }
}

/// Members side by side do what the scalar kernel does, with the same bits with and without vectors.
#[test]
fn prop_members_agree_with_the_scalar_kernel_on_curves() {
    let mut worst = 0.0_f64;
    for seed in 0..12 {
        let mut random = Random(50_000 + seed);
        let signal = random_signal(&mut random, 300, 20.0, 1e4);
        let reading = read(&signal);
        let members: Vec<Member> = (0..40)
            .map(|_| {
                let Design { lever, stop, .. } = random_design(&mut random);
                Member {
                    lever,
                    stop,
                    scale: random.between(0.8, 1.2),
                    bias_m_s2: random.between(-1.0, 1.0),
                    second: SensorView::default(),
                    catch: None,
                }
            })
            .collect();
        for stop in [StopModel::Rigid, StopModel::Soft] {
            let options = BatchOptions {
                stop,
                projection: Projection::ALIGNED,
                opens_when: OpensWhen::Negative,
                initial: None,
                window: None,
                coast: true,
                asked: AskedPeaks::ALL,
                threshold_rad: f64::INFINITY,
                threads: 2,
            };
            let of = |index: usize| members[index];
            let peaks = batch::peaks(&reading, members.len(), &of, &options).unwrap();
            let plain =
                batch::peaks_without_vectors(&reading, members.len(), &of, &options).unwrap();
            assert_eq!(peaks, plain, "seed {seed}");
            for (member, peak) in members.iter().zip(&peaks) {
                let moved = Signal {
                    samples: signal
                        .samples
                        .iter()
                        .map(|a| member.scale * a + member.bias_m_s2)
                        .collect(),
                    ..signal.clone()
                };
                let design = Design {
                    lever: member.lever,
                    stop: member.stop,
                    ..Design::reference()
                };
                let run = replay::run(
                    read(&moved),
                    &design,
                    &RunOptions::new(stop, OpensWhen::Negative),
                )
                .unwrap()
                .run;
                let off = (run.peak_angle_rad - peak.peak_angle_rad).abs();
                // The scaled samples are rounded once more, and a step of a member lets ten times as much pass.
                let allowed = 4.0 * run.numerical_error_rad;
                worst = worst.max(off / run.numerical_error_rad);
                assert!(
                    off <= allowed,
                    "seed {seed} {stop:?}: off by {off:e}, stated {:e}",
                    run.numerical_error_rad
                );
            }
        }
    }
    println!("at most {worst:.1} times the stated error apart");
}

/// The methods to compare with see the same polynomials: with finer steps they come to the event-driven peak.
#[test]
fn verif_other_methods_come_to_the_same_peak_on_curves() {
    let pulse = |place: f64| -200.0 * (-0.5 * ((place - 120.2) / 15.0).powi(2)).exp();
    let signal = sampled(2_000, pulse);
    let reading = read(&signal);
    for stop in [StopModel::Rigid, StopModel::Soft] {
        let peak = |method: Method, tolerance_rad: Option<f64>| {
            let options = RunOptions {
                method,
                tolerance_rad,
                ..RunOptions::new(stop, OpensWhen::Negative)
            };
            replay::run(&reading, &Design::reference(), &options)
                .unwrap()
                .run
                .peak_angle_rad
        };
        let own = peak(Method::EventDriven, None);
        let steps_per_period = 200_000;
        for (method, tolerance_rad, tolerance) in [
            (Method::Rk4Located { steps_per_period }, None, 1e-9),
            (Method::Dopri5 { at_samples: true }, Some(1e-12), 1e-9),
        ] {
            let other = peak(method, tolerance_rad);
            assert!(
                (own - other).abs() < tolerance,
                "{stop:?} {method:?}: {own} {other}"
            );
        }
        assert!(own > 0.1);
    }
}
