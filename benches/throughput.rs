//! Reading large files: megabytes a second of a CSV file, and of an MCAP log beside what the
//! bare crate does with it. Run with `cargo bench --bench throughput`.
//!
//! The readers hash what they read and check it; the bare crate streams the messages and looks
//! at none. Both run in turns, and the fastest of each counts.

#![allow(clippy::disallowed_methods, reason = "benches read the clock")]
#![allow(
    missing_docs,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "benches are run, not linked"
)]

#[path = "../examples/support/imu.rs"]
mod imu;

use latchgate_recording::{Limits, ReadOptions, Selection, Source};
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Turns each program gets.
const ROUNDS: usize = 7;

fn acceleration(k: u32) -> f64 {
    let t = f64::from(k) * 1e-4;
    40.0 * (97.0 * t).sin() * (1.3 * t).sin() + 3.0 * (8_111.0 * t).sin()
}

fn write(name: &str, bytes: &[u8]) -> PathBuf {
    let path = std::env::temp_dir().join(format!("latchgate-{}-{name}", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    path
}

/// A table of `columns` columns of acceleration beside the time.
fn csv_file(rows: u32, columns: u32) -> Vec<u8> {
    let mut text = String::from("time_s,acc_y_g");
    for column in 1..columns {
        write!(text, ",acc_x{column}_g").unwrap();
    }
    text.push('\n');
    for k in 0..rows {
        write!(text, "{:.6}", f64::from(k) * 1e-5).unwrap();
        for column in 0..columns {
            write!(text, ",{:.6}", acceleration(k + 977 * column)).unwrap();
        }
        text.push('\n');
    }
    text.into_bytes()
}

fn read(path: &Path) {
    let recording = latchgate_recording::read(
        &Source::File(path.to_path_buf()),
        &ReadOptions::default(),
        Selection::Lateral,
        &Limits::default(),
    )
    .unwrap();
    black_box(&recording.channels[0].values);
}

/// Seconds of the clock, and of the processor for the calling thread, where the system tells them.
/// A reader may have helpers; where a core is free for them, the calling thread sets the pace.
#[derive(Clone, Copy)]
struct Took {
    clock: f64,
    processor: f64,
}

impl Took {
    const FOREVER: Self = Self {
        clock: f64::INFINITY,
        processor: f64::INFINITY,
    };

    fn least(self, other: Self) -> Self {
        Self {
            clock: self.clock.min(other.clock),
            processor: self.processor.min(other.processor),
        }
    }

    /// Megabytes a second, by the clock and by the processor.
    fn rates(self, megabytes: f64) -> String {
        format!(
            "{:.0} MB/s ({:.0} MB/s of this thread's processor time)",
            megabytes / self.clock,
            megabytes / self.processor
        )
    }
}

/// Time that this thread has had of a processor [s]; NaN where the system does not tell.
fn processor_s() -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split(' ').next()?.parse::<f64>().ok())
        .map_or(f64::NAN, |nanoseconds| nanoseconds * 1e-9)
}

fn seconds(run: impl FnOnce()) -> Took {
    let (started, before) = (Instant::now(), processor_s());
    run();
    Took {
        clock: started.elapsed().as_secs_f64(),
        processor: processor_s() - before,
    }
}

fn main() {
    for (name, rows, columns) in [
        ("two columns", 6_000_000, 1),
        ("nine columns", 1_500_000, 8),
    ] {
        let bytes = csv_file(rows, columns);
        let megabytes = bytes.len() as f64 / 1e6;
        let path = write("bench.csv", &bytes);
        drop(bytes);
        let best = (0..ROUNDS)
            .map(|_| seconds(|| read(&path)))
            .fold(Took::FOREVER, Took::least);
        println!(
            "csv, {name}: {megabytes:.0} MB at {}",
            best.rates(megabytes)
        );
        std::fs::remove_file(path).unwrap();
    }

    let lateral: Vec<f64> = (0..400_000).map(acceleration).collect();
    let bytes = imu::imu_recording("/imu", 1_000_000_000, 100_000, &lateral);
    let megabytes = bytes.len() as f64 / 1e6;
    let path = write("bench.mcap", &bytes);
    drop(bytes);
    let (mut own, mut bare) = (Took::FOREVER, Took::FOREVER);
    for _ in 0..ROUNDS {
        own = own.least(seconds(|| read(&path)));
        bare = bare.least(seconds(|| {
            let bytes = std::fs::read(&path).unwrap();
            let mut sum = 0;
            for message in mcap::MessageStream::new(&bytes).unwrap() {
                sum += message.unwrap().data.len();
            }
            black_box(sum);
        }));
    }
    println!(
        "mcap: {megabytes:.0} MB at {}; the bare crate {}; ratio {:.2} ({:.2} of processor time)",
        own.rates(megabytes),
        bare.rates(megabytes),
        bare.clock / own.clock,
        bare.processor / own.processor
    );
    std::fs::remove_file(path).unwrap();
}
