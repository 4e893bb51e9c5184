//! Replays what fuzzing once found, and the seeds it starts from, through the functions that
//! fuzzing calls: each panics where a reader breaks its word (`docs/testing.md`).

#[allow(dead_code, unreachable_pub, reason = "shared with the fuzzer")]
#[path = "../../fuzz/src/seeds.rs"]
mod seeds;
#[allow(dead_code, unreachable_pub, reason = "shared with the fuzzer")]
#[path = "../../fuzz/src/targets.rs"]
mod targets;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Inputs of fuzzing are small; none may take long, even in a build that is not optimised.
const PATIENCE: Duration = Duration::from_secs(5);

#[track_caller]
fn check(target: fn(&[u8]), name: &str, input: &str, bytes: &[u8]) {
    println!("{name}: {input}, {} bytes", bytes.len());
    let started = Instant::now();
    target(bytes);
    let took = started.elapsed();
    assert!(took < PATIENCE, "{name}: {input} took {took:?}");
}

#[test]
fn regress_what_fuzzing_found_stays_mended() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/kept");
    let mut replayed = 0;
    for folder in fs::read_dir(kept).unwrap() {
        let folder = folder.unwrap().path();
        let name = folder.file_name().unwrap().to_str().unwrap().to_string();
        let (_, target) = targets::ALL
            .iter()
            .find(|(known, _)| *known == name)
            .unwrap_or_else(|| panic!("fuzz/kept/{name} is no target"));
        for input in fs::read_dir(&folder).unwrap() {
            let input = input.unwrap().path();
            let bytes = fs::read(&input).unwrap();
            check(*target, &name, &input.display().to_string(), &bytes);
            replayed += 1;
        }
    }
    assert!(replayed > 0, "fuzz/kept holds what was found");
}

#[test]
fn verif_every_seed_keeps_the_word_of_its_reader() {
    for (name, target) in targets::ALL {
        let seeds = seeds::of(name);
        assert!(!seeds.is_empty(), "{name}");
        for (index, bytes) in seeds.iter().enumerate() {
            check(*target, name, &format!("seed {index}"), bytes);
        }
    }
}
