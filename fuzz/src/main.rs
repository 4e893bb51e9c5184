//! Runs a target without any tool: seeds, mutated by a seeded generator, in turns until the
//! executions or the seconds are used up.
//!
//!     cargo run --release --bin run -- TARGET [--executions N] [--seconds N] [--seed N]
//!     cargo run --release --bin run -- seeds FOLDER      write the seeds, a folder per target
//!
//! An input that panics, holds more memory than allowed or takes longer than a second is
//! written to `found/` and ends the run with exit code 1.

use latchgate_fuzz::{allocator, seeds, targets};
use std::panic::catch_unwind;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Longest time for one input.
const PATIENCE: Duration = Duration::from_secs(1);

/// Times that an input which took too long is tried again.
const AGAIN: u32 = 4;

/// Executions after which a run says how far it is.
const SAID: u64 = 500_000;

/// Longest input.
const LONGEST: usize = 16 << 10;

/// Bytes one input may hold at most.
const MEMORY: usize = 64 << 20;

/// Pieces that formats turn on.
const TOKENS: &[&[u8]] = &[
    b"\n",
    b"\r\n",
    b"\r",
    b",",
    b";",
    b"\t",
    b" ",
    b"\"",
    b"#",
    b".",
    b"-",
    b"e",
    b"E+3",
    b"nan",
    b"inf",
    b"1e308",
    b"1e-320",
    b"0",
    b"-0",
    b"99999999999999999999",
    b"g",
    b"m/s2",
    b"time",
    b"acc_y_g",
    b"NOVALUE",
    b"|",
    b":",
    b"***End_of_Header***",
    b"\xFF\xFE",
    b"\xEF\xBB\xBF",
    b"\x00",
    b"\xFF\xFF\xFF\xFF",
    b"\x00\x00\x00\x80",
    b"PK\x01\x02",
    b"PK\x05\x06",
    b"\x1F\x8B",
    b"\x89MCAP0\r\n",
    b"zstd",
    b"lz4",
    b"=",
    b"[",
    b"]",
    b"lever.",
    b"true",
];

/// The generator SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        usize::try_from(self.next() % (bound.max(1) as u64)).unwrap_or(0)
    }
}

fn mutate(random: &mut Random, bytes: &mut Vec<u8>, others: &[Vec<u8>]) {
    for _ in 0..=random.below(5) {
        let at = random.below(bytes.len() + 1);
        match random.below(10) {
            0 => bytes.truncate(at),
            1 => {
                let end = (at + 1 + random.below(24)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            2 => {
                let end = (at + 1 + random.below(200)).min(bytes.len());
                let piece = bytes[at.min(end)..end].to_vec();
                let to = random.below(bytes.len() + 1);
                bytes.splice(to..to, piece);
            }
            3 | 4 => {
                let token = TOKENS[random.below(TOKENS.len())];
                let end = if random.below(2) == 0 {
                    at
                } else {
                    (at + token.len()).min(bytes.len())
                };
                bytes.splice(at..end, token.iter().copied());
            }
            5 => {
                let other = &others[random.below(others.len())];
                let from = random.below(other.len() + 1);
                let end = (from + random.below(400)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
            6 => {
                // A number of four or eight bytes, as lengths are.
                let value = match random.below(4) {
                    0 => u64::MAX,
                    1 => random.next(),
                    2 => random.next() % 300,
                    _ => 1 << random.below(64),
                };
                let width = if random.below(2) == 0 { 4 } else { 8 };
                let end = (at + width).min(bytes.len());
                bytes.splice(at..end, value.to_le_bytes()[..width].iter().copied());
            }
            7 if at < bytes.len() => bytes[at] = bytes[at].wrapping_add(1),
            8 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            _ if at < bytes.len() => bytes[at] = (random.next() & 0xFF) as u8,
            _ => {}
        }
    }
    bytes.truncate(LONGEST);
}

fn keep(target: &str, number: u64, bytes: &[u8], why: &str) -> ExitCode {
    let _ = std::fs::create_dir_all("found");
    let path = format!("found/{target}-{number}");
    let written = std::fs::write(&path, bytes);
    eprintln!("{target}: {why} with input {number}, kept as {path} ({written:?})");
    ExitCode::FAILURE
}

fn write_seeds(folder: &str) -> std::io::Result<()> {
    for (name, _) in targets::ALL {
        let folder = Path::new(folder).join(name);
        std::fs::create_dir_all(&folder)?;
        for (index, bytes) in seeds::of(name).iter().enumerate() {
            std::fs::write(folder.join(format!("seed-{index:02}")), bytes)?;
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [command, folder] = arguments.as_slice()
        && command == "seeds"
    {
        return match write_seeds(folder) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("{error}");
                ExitCode::FAILURE
            }
        };
    }
    let option = |name: &str, default: u64| {
        arguments
            .windows(2)
            .find(|pair| pair[0] == name)
            .and_then(|pair| pair[1].parse().ok())
            .unwrap_or(default)
    };
    let Some((name, target)) = targets::ALL
        .iter()
        .find(|(name, _)| arguments.first().is_some_and(|wanted| wanted == name))
    else {
        eprintln!(
            "name a target: {}",
            targets::ALL
                .iter()
                .map(|(name, _)| *name)
                .collect::<Vec<_>>()
                .join(", ")
        );
        return ExitCode::from(2);
    };
    let target = if *name == "csv" {
        &(targets::csv_lightly as fn(&[u8]))
    } else {
        target
    };
    let executions = option("--executions", u64::MAX);
    let seconds = Duration::from_secs(option("--seconds", 60));
    let seed = option("--seed", 1);
    let others = seeds::of(name);
    let started = Instant::now();
    let (mut done, mut slowest, mut most) = (0_u64, Duration::ZERO, 0_usize);
    while done < executions && started.elapsed() < seconds {
        // The number of an input and the seed give the input.
        let mut random = Random(seed.wrapping_mul(0x1000_0001).wrapping_add(done));
        let mut bytes = others[random.below(others.len())].clone();
        if done >= others.len() as u64 {
            mutate(&mut random, &mut bytes, &others);
        }
        allocator::take_most();
        let before = Instant::now();
        if catch_unwind(|| target(&bytes)).is_err() {
            return keep(name, done, &bytes, "a panic");
        }
        let mut took = before.elapsed();
        let held = allocator::take_most();
        // On a busy machine any input may have to wait; one that is slow is so each time.
        for _ in 0..AGAIN {
            if took > PATIENCE {
                let before = Instant::now();
                target(&bytes);
                took = took.min(before.elapsed());
            }
        }
        if took > PATIENCE {
            return keep(name, done, &bytes, &format!("{took:?}"));
        }
        if held > MEMORY {
            return keep(name, done, &bytes, &format!("{held} bytes held"));
        }
        slowest = slowest.max(took);
        most = most.max(held);
        done += 1;
        if done.is_multiple_of(SAID) {
            eprintln!(
                "{name}: {done} executions from seed {seed}, {:.0} s",
                started.elapsed().as_secs_f64()
            );
        }
    }
    let per_second = done as f64 / started.elapsed().as_secs_f64();
    println!(
        "{name}: {done} executions from seed {seed}, {per_second:.0} a second; slowest {slowest:?}, most memory {} KiB; nothing found",
        most >> 10
    );
    ExitCode::SUCCESS
}
