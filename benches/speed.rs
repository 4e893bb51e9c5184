//! Wall-clock times of the parts that a verdict is made of. Run with `cargo bench`.
//!
//! Times differ from machine to machine and hour to hour: compare the rows of one run.

#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "benches are run, not linked"
)]

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, black_box};
use latchgate::conditioning::{Cfc, FilterStandard, Signal, cfc::CfcFilter, resample};
use latchgate::model::Design;
use latchgate::model::stop::StopModel;
use latchgate::recording::{self, Limits, ReadOptions, Selection, Source};
use latchgate::replay::batch::{self, BatchOptions, Member};
use latchgate::replay::{self, Method, RunOptions};
use latchgate::units::{AccelerationUnit, OpensWhen, SampleRate};

fn main() {
    divan::main();
}

/// Samples of a recording of 0.3 s at 10 kHz.
const SAMPLES: usize = 3000;

/// A decaying sum of 24 tones up to 480 Hz whose largest value is near `peak` [m/s²].
fn recording_of(peak: f64) -> Signal {
    let value = |k: usize| {
        let t = k as f64 / 1e4;
        let tones: f64 = (1..=24)
            .map(|j| {
                let phase = (0.618_033_988_749_895 * f64::from(j * j)).fract();
                libm::sin(std::f64::consts::TAU * (20.0 * f64::from(j) * t + phase))
            })
            .sum();
        peak / 8.0 * (t / 0.03) * libm::exp(1.0 - t / 0.03) * tones
    };
    Signal {
        start_s: 0.0,
        rate: SampleRate::from_hertz(1e4).unwrap(),
        samples: (0..SAMPLES).map(value).collect(),
    }
}

/// Kernel per sample: a lever that flies, one that chatters, one that only rests.
#[divan::bench(args = [("flight", 2000.0), ("chatter", 100.0), ("rest", 5.0)], consts = [true, false])]
fn kernel<const RIGID: bool>(bencher: Bencher<'_, '_>, (_, peak): (&str, f64)) {
    let signal = recording_of(peak);
    let stop = if RIGID {
        StopModel::Rigid
    } else {
        StopModel::Soft
    };
    let options = RunOptions::new(stop, OpensWhen::Negative);
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench(|| replay::run(black_box(&signal), &Design::reference(), &options).unwrap());
}

/// The paper's method at the paper's step, on the same recording as `kernel`'s flight.
#[divan::bench]
fn rk4_of_the_paper(bencher: Bencher<'_, '_>) {
    let signal = recording_of(2000.0);
    let mut options = RunOptions::new(StopModel::Rigid, OpensWhen::Negative);
    options.method = Method::Rk4 {
        steps_per_period: 10_000,
    };
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench(|| replay::run(black_box(&signal), &Design::reference(), &options).unwrap());
}

/// Batch per lane-sample: 1000 designs on one thread.
#[divan::bench(args = [("flight", 2000.0), ("chatter", 100.0)], consts = [true, false])]
fn batch_of_1000<const RIGID: bool>(bencher: Bencher<'_, '_>, (_, peak): (&str, f64)) {
    let signal = recording_of(peak);
    let design = Design::reference();
    let member = |index: usize| {
        let mut lever = design.lever;
        lever.preload_torque_nm *= 0.5 + 1.5 * (index % 40) as f64 / 40.0;
        lever.spring_stiffness_nm_per_rad *= 0.5 + 1.5 * (index / 40) as f64 / 25.0;
        Member {
            lever,
            stop: design.stop,
            scale: 1.0,
            bias_m_s2: 0.0,
        }
    };
    let options = BatchOptions {
        stop: if RIGID {
            StopModel::Rigid
        } else {
            StopModel::Soft
        },
        opens_when: OpensWhen::Negative,
        initial: None,
        window: None,
        coast: false,
        threads: 1,
    };
    bencher
        .counter(ItemsCount::new(1000 * SAMPLES))
        .bench(|| batch::peaks(black_box(&signal), 1000, &member, &options).unwrap());
}

/// Channel frequency class 1000, both passes and both paddings.
#[divan::bench]
fn cfc_1000(bencher: Bencher<'_, '_>) {
    let signal = recording_of(2000.0);
    let filter = CfcFilter::new(Cfc::Cfc1000, FilterStandard::Iso6487);
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench(|| filter.apply(black_box(&signal)).unwrap());
}

/// Band-limited fourfold of the samples.
#[divan::bench]
fn fourfold(bencher: Bencher<'_, '_>) {
    let signal = recording_of(2000.0);
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .bench(|| resample::upsample_fourfold(black_box(&signal)));
}

/// Reading a two-column CSV from memory, its hash included.
#[divan::bench]
fn parse_csv(bencher: Bencher<'_, '_>) {
    let signal = recording_of(2000.0);
    let mut text = String::from("time_s,acc_y\n");
    for (k, a) in signal.samples.iter().enumerate() {
        text.push_str(&format!("{:.4},{a:.5}\n", k as f64 / 1e4));
    }
    let bytes = text.into_bytes();
    let options = ReadOptions {
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        ..ReadOptions::default()
    };
    let source = Source::Bytes {
        name: "bench.csv".into(),
        bytes: bytes.clone(),
    };
    bencher.counter(BytesCount::of_slice(&bytes)).bench(|| {
        recording::read(
            black_box(&source),
            &options,
            Selection::Lateral,
            &Limits::default(),
        )
        .unwrap()
    });
}
