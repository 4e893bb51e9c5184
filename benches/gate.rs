//! What a gate costs: processor time per pair, memory, and what a second run saves.
//!
//! ```sh
//! cargo bench --bench gate                  # 100 recordings, 20 designs
//! cargo bench --bench gate -- 1000 20       # 1 000 recordings and, for memory, a tenth of them
//! cargo bench --bench gate -- 1000 20 0     # the same without ensembles
//! ```

#![allow(clippy::disallowed_methods, reason = "benches read the clock")]
#![expect(clippy::print_stdout, reason = "a bench prints")]

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Samples of a recording.
const SAMPLES: u32 = 3000;

fn main() -> Result<(), Box<dyn Error>> {
    let numbers: Vec<u32> = std::env::args()
        .skip(1)
        .filter_map(|word| word.parse().ok())
        .collect();
    let number = |index: usize, other: u32| numbers.get(index).copied().unwrap_or(other);
    let (recordings, designs, members) = (number(0, 100), number(1, 20), number(2, 10_000));
    println!("recordings designs pairs run  clock_s  cpu_s  ms_per_pair  peak_mib  cached");
    for count in [recordings.div_ceil(10), recordings] {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gate-bench");
        let _ = fs::remove_dir_all(&folder);
        fill(&folder, count, designs, members)?;
        for name in ["first", "second"] {
            let cost = run(&folder)?;
            println!(
                "{count:10} {designs:7} {:5} {name:6} {:6.1} {:6.2} {:12.2} {:9.1}  {}",
                count * designs,
                cost.clock_s,
                cost.processor_s,
                1e3 * cost.processor_s / f64::from(count * designs),
                cost.peak_mib,
                cost.told
            );
        }
    }
    Ok(())
}

/// Writes a gate of pulses and ringing by formula, of which some open the weaker levers.
fn fill(folder: &Path, recordings: u32, designs: u32, members: u32) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder.join("recordings"))?;
    for number in 0..recordings {
        let peak_g = 4.0 + 30.0 * f64::from(number) / f64::from(recordings);
        let mut noise = 0x9E37_79B9_u64 + u64::from(number);
        let mut text = String::from("time_s,acc_y_g\n");
        for index in 0..SAMPLES {
            let time = f64::from(index) / 10_000.0 - 0.05;
            let pulse = if (0.0..0.03).contains(&time) {
                -peak_g * (std::f64::consts::PI * time / 0.03).sin()
            } else {
                0.0
            };
            let ringing = if time > 0.0 {
                0.4 * peak_g * (-time / 0.02).exp() * (1_600.0 * time).sin()
            } else {
                0.0
            };
            noise = noise
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let rough = 0.1 * ((noise >> 40) as f64 / f64::from(1 << 24) - 0.5);
            writeln!(text, "{time:.4},{:.3}", pulse + ringing + rough)?;
        }
        fs::write(folder.join(format!("recordings/r{number:05}.csv")), text)?;
    }
    let mut gate = format!(
        "[[recordings]]\nfiles = \"recordings/*.csv\"\nopens_when = \"negative\"\nmembers = {members}\n"
    );
    for number in 0..designs {
        let preload = 0.6 + 6.0 * f64::from(number) / f64::from(designs);
        write!(
            gate,
            "[[designs]]\nname = \"d{number:02}\"\nset = {{ \"lever.preload_torque_nm\" = {preload:.4} }}\n"
        )?;
    }
    fs::write(folder.join("gate.toml"), gate)?;
    Ok(())
}

/// What one run of the program took.
struct Cost {
    clock_s: f64,
    processor_s: f64,
    peak_mib: f64,
    told: String,
}

fn run(folder: &Path) -> Result<Cost, Box<dyn Error>> {
    let (before, started) = (children_s()?, Instant::now());
    let errors = folder.join("stderr");
    let mut child = Command::new(env!("CARGO_BIN_EXE_latchgate"))
        .args(["gate", "gate.toml", "--out", "out", "--reports", "none"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(fs::File::create(&errors)?)
        .spawn()?;
    let status = PathBuf::from(format!("/proc/{}/status", child.id()));
    let mut peak_mib = 0.0;
    while child.try_wait()?.is_none() {
        if let Ok(text) = fs::read_to_string(&status) {
            let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
            peak_mib = kib.map_or(peak_mib, |kib| kib / 1024.0);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let told = fs::read_to_string(&errors)?;
    Ok(Cost {
        clock_s: started.elapsed().as_secs_f64(),
        processor_s: children_s()? - before,
        peak_mib,
        told: told.lines().last().unwrap_or("none").to_string(),
    })
}

/// Returns the processor time of all children that ended [s], from /proc/self/stat.
fn children_s() -> Result<f64, Box<dyn Error>> {
    const TICKS_PER_SECOND: f64 = 100.0;
    let text = fs::read_to_string("/proc/self/stat")?;
    let after_name = text.rsplit(')').next().unwrap_or_default();
    // Counted from the state, the third field: cutime and cstime are the sixteenth and seventeenth.
    let fields: Vec<f64> = after_name
        .split_whitespace()
        .map(|field| field.parse().unwrap_or(0.0))
        .collect();
    Ok((fields[13] + fields[14]) / TICKS_PER_SECOND)
}
