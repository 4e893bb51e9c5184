//! Wall-clock times of the parts that a verdict is made of. Run with `cargo bench --bench speed`.
//!
//! Times differ from machine to machine and hour to hour: compare the rows of one run, or take
//! `cargo bench --bench ratios`, which measures in turns.

#![allow(
    missing_docs,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "benches are run, not linked"
)]

#[path = "../examples/support/imu.rs"]
mod imu;
#[path = "support/scenes.rs"]
mod scenes;

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, black_box};
use latchgate_kernel::model::Design;
use latchgate_kernel::model::excitation::Harmonic;
use latchgate_kernel::model::stop::StopModel;
use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::{self, Method, RunOptions, Section, State, Strobe};
use latchgate_kernel::replay::{batch, strobe_batch};
use latchgate_kernel::units::{AccelerationUnit, OpensWhen};
use latchgate_recording::{Limits, ReadOptions, Recording, Selection, Source};
use latchgate_verdict::conditioning::between::{self, Between};
use latchgate_verdict::conditioning::{
    self, Cfc, ConditioningOptions, FilterStandard, Signal, cfc::CfcFilter,
};
use latchgate_verdict::{AssessExtras, ModelChoice, Polarity, Policy, assess};
use std::borrow::Cow;
use std::fmt::Write as _;

fn main() {
    divan::main();
}

/// What a lever does all through a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// Impacts and flights of the reference lever.
    Recording,
    /// A lever that meets no stop.
    Flight,
    /// Mostly bounces that die away.
    Chatter,
    /// Nothing: a rigid stop carries the lever, or it sinks into a soft one by less than 1e-5 rad.
    Rest,
    /// Motion inside the soft stop, pressed by 150 g and more.
    PressedContact,
}

impl Phase {
    fn signal(self) -> Signal {
        match self {
            Self::Recording | Self::Flight => scenes::recording(1.0),
            Self::Chatter => scenes::recording(scenes::CHATTER),
            Self::Rest => scenes::recording(scenes::QUIET),
            Self::PressedContact => {
                let mut signal = scenes::recording(0.5);
                for sample in &mut signal.samples {
                    *sample += 150.0 * 9.81;
                }
                signal
            }
        }
    }

    /// A lever that does so, with options without an error statement.
    fn run(self, stop: StopModel) -> (Design, RunOptions) {
        let mut design = Design::reference();
        let mut options = scenes::plain(stop, Method::EventDriven);
        if self == Self::Flight {
            // A weak spring and a start far out keep it away from the stop.
            design.lever.spring_stiffness_nm_per_rad = 1e-3;
            design.lever.preload_torque_nm = 1e-3;
            options.initial = Some(State::new(20.0, 0.0));
        }
        (design, options)
    }
}

/// Kernel per sample.
#[divan::bench(args = [
    (Phase::Recording, StopModel::Rigid),
    (Phase::Recording, StopModel::Soft),
    (Phase::Flight, StopModel::Rigid),
    (Phase::Chatter, StopModel::Rigid),
    (Phase::Chatter, StopModel::Soft),
    (Phase::Rest, StopModel::Rigid),
    (Phase::Rest, StopModel::Soft),
    (Phase::PressedContact, StopModel::Soft),
])]
fn kernel(bencher: Bencher<'_, '_>, (phase, stop): (Phase, StopModel)) {
    let signal = phase.signal();
    let (design, options) = phase.run(stop);
    let run = replay::run(&signal, &design, &options).unwrap().run;
    let as_meant = match phase {
        Phase::Recording | Phase::Chatter => run.impacts > 0,
        Phase::Flight => run.impacts == 0 && run.peak_angle_rad > 20.0,
        Phase::Rest | Phase::PressedContact => run.impacts == 0 && run.peak_angle_rad <= 0.0,
    };
    assert!(as_meant, "{phase:?} is another motion: {run:?}");
    bencher
        .counter(ItemsCount::new(signal.samples.len() - 1))
        .bench(|| replay::run(black_box(&signal), &design, &options).unwrap());
}

/// Kernel per sample with the bound on its error.
#[divan::bench(args = [StopModel::Rigid, StopModel::Soft])]
fn kernel_with_error_bound(bencher: Bencher<'_, '_>, stop: StopModel) {
    let signal = scenes::recording(1.0);
    let options = RunOptions::new(stop, OpensWhen::Negative);
    bencher
        .counter(ItemsCount::new(signal.samples.len() - 1))
        .bench(|| replay::run(black_box(&signal), &Design::reference(), &options).unwrap());
}

/// The paper's method at the paper's step, three to a sample.
#[divan::bench(args = [StopModel::Rigid, StopModel::Soft])]
fn rk4_of_the_paper(bencher: Bencher<'_, '_>, stop: StopModel) {
    let signal = scenes::recording(1.0);
    let options = scenes::as_in_the_paper(stop);
    bencher
        .counter(ItemsCount::new(signal.samples.len() - 1))
        .bench(|| replay::run(black_box(&signal), &Design::reference(), &options).unwrap());
}

/// Batch per lane-sample: 1000 designs, peak only.
#[divan::bench(sample_count = 20, args = [
    (Phase::Recording, StopModel::Rigid),
    (Phase::Recording, StopModel::Soft),
    (Phase::Chatter, StopModel::Rigid),
    (Phase::Chatter, StopModel::Soft),
], consts = [1, 2])]
fn batch_on_threads<const THREADS: usize>(
    bencher: Bencher<'_, '_>,
    (phase, stop): (Phase, StopModel),
) {
    let signal = phase.signal();
    let options = scenes::peaks_only(stop, THREADS);
    bencher
        .counter(ItemsCount::new(scenes::LEVERS * (signal.samples.len() - 1)))
        .bench(|| {
            batch::peaks(black_box(&signal), scenes::LEVERS, &scenes::lever, &options).unwrap()
        });
}

/// Periods followed of each lever on a sine.
const PERIODS: u32 = 40;

/// A lever from anywhere in the paper's plane of basins, ω = 100 rad/s and A = 1.
fn basin_start(index: usize) -> strobe_batch::HarmonicStart {
    let part = |step: f64| (index as f64 * step).fract();
    strobe_batch::HarmonicStart {
        initial: Some(State::new(part(0.618_034), 40.0 * part(0.414_214) - 20.0)),
        amplitude_m_s2: 9.81,
    }
}

/// Lever-period on a sine by lanes, 200 levers from anywhere.
#[divan::bench(sample_count = 10, args = [StopModel::Rigid, StopModel::Soft])]
fn fan_on_a_sine(bencher: Bencher<'_, '_>, stop: StopModel) {
    let options = strobe_batch::StrobeBatchOptions {
        stop,
        angular_frequency_rad_s: 100.0,
        phase_rad: 0.0,
        periods_max: PERIODS,
        keep: 1,
        peaks: false,
        threads: 1,
    };
    let design = Design::reference();
    bencher
        .counter(ItemsCount::new(200 * PERIODS as usize))
        .bench(|| {
            strobe_batch::follow(
                black_box(&design),
                200,
                &basin_start,
                &options,
                &|_, _, _: &Section| false,
                None,
            )
            .unwrap()
        });
}

/// The same one by one.
#[divan::bench(sample_count = 10, args = [StopModel::Rigid, StopModel::Soft])]
fn strobe_on_a_sine(bencher: Bencher<'_, '_>, stop: StopModel) {
    let design = Design::reference();
    let follow = |index: usize| {
        let start = basin_start(index);
        let excitation = Harmonic {
            amplitude_m_s2: start.amplitude_m_s2,
            angular_frequency_rad_s: 100.0,
            phase_rad: 0.0,
        };
        let mut strobe = Strobe::new(&design, stop, &excitation, start.initial).unwrap();
        (0..PERIODS).map(|_| strobe.advance()).last()
    };
    bencher
        .counter(ItemsCount::new(200 * PERIODS as usize))
        .bench(|| {
            (0..200)
                .map(|index| follow(black_box(index)))
                .collect::<Vec<_>>()
        });
}

/// Channel frequency class 1000, both passes and both paddings, per sample.
#[divan::bench(args = [FilterStandard::Iso6487, FilterStandard::SaeJ211])]
fn cfc_1000(bencher: Bencher<'_, '_>, standard: FilterStandard) {
    let signal = scenes::recording(1.0);
    let filter = CfcFilter::new(Cfc::Cfc1000, standard);
    bencher
        .counter(ItemsCount::new(signal.samples.len()))
        .bench(|| filter.apply(black_box(&signal)).unwrap());
}

/// Derivatives of the samples within their band.
#[divan::bench]
fn band_limited(bencher: Bencher<'_, '_>) {
    let signal = scenes::recording(1.0);
    bencher
        .counter(ItemsCount::new(signal.samples.len()))
        .bench(|| between::read(Cow::Borrowed(black_box(&signal)), Between::BandLimited).unwrap());
}

/// The recording `times` times over as a CSV file of two columns.
fn csv_file(times: usize) -> Vec<u8> {
    let signal = scenes::recording(1.0);
    let mut text = String::from("time_s,acc_y\n");
    let samples = signal.samples.iter().cycle();
    for (k, a) in samples.take(times * signal.samples.len()).enumerate() {
        writeln!(text, "{:.4},{a:.5}", k as f64 / 1e4).unwrap();
    }
    text.into_bytes()
}

/// The recording `times` times over as an MCAP log of IMU messages.
fn mcap_file(times: usize) -> Vec<u8> {
    let signal = scenes::recording(1.0);
    let count = times * signal.samples.len();
    let lateral: Vec<f64> = signal.samples.iter().copied().cycle().take(count).collect();
    imu::imu_recording("/imu", 1_000_000_000, 100_000, &lateral)
}

fn read(source: &Source) -> Recording {
    let options = ReadOptions {
        unit: Some(AccelerationUnit::MetrePerSecondSquared),
        ..ReadOptions::default()
    };
    latchgate_recording::read(source, &options, Selection::Lateral, &Limits::default()).unwrap()
}

fn file(name: &str, bytes: Vec<u8>) -> Source {
    Source::bytes(name, bytes)
}

/// Reading a CSV file from memory, its hash included: one recording, and twenty of them.
#[divan::bench(sample_count = 20, args = [1, 20])]
fn parse_csv(bencher: Bencher<'_, '_>, times: usize) {
    let bytes = csv_file(times);
    let count = BytesCount::of_slice(&bytes);
    let source = file("bench.csv", bytes);
    bencher.counter(count).bench(|| read(black_box(&source)));
}

/// Reading an MCAP log from memory, its hash included: one recording, and twenty of them.
#[divan::bench(sample_count = 20, args = [1, 20])]
fn parse_mcap(bencher: Bencher<'_, '_>, times: usize) {
    let bytes = mcap_file(times);
    let count = BytesCount::of_slice(&bytes);
    let source = file("bench.mcap", bytes);
    bencher.counter(count).bench(|| read(black_box(&source)));
}

/// A whole replay without its report: read, condition, both stops with error budget, decide.
#[divan::bench(sample_count = 20)]
fn whole_replay(bencher: Bencher<'_, '_>) {
    let bytes = csv_file(1);
    let count = BytesCount::of_slice(&bytes);
    let source = file("bench.csv", bytes);
    let policy = Policy::new(ModelChoice::Auto, Polarity::Declared(OpensWhen::Negative));
    bencher.counter(count).bench(|| {
        let recording = read(black_box(&source));
        let channel = &recording.channels[0];
        let conditioned =
            conditioning::condition(channel, &ConditioningOptions::default()).unwrap();
        let mut findings = recording.findings.clone();
        findings.extend(channel.findings.iter().cloned());
        findings.extend(conditioned.findings.iter().cloned());
        assess(
            &conditioned,
            &findings,
            &Design::reference(),
            &policy,
            AssessExtras::default(),
            &Control::default(),
        )
        .unwrap()
    });
}
