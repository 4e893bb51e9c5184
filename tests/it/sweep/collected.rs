//! What is collected is what one process says; what is missing is said.

use super::{SweepYard, told};
use crate::gate::without_times;
use crate::support::Random;
use latchgate::gate::Share;
use serde_json::Value;
use std::fs;
use std::time::Duration;

#[test]
fn cli_shares_together_are_the_gate() {
    let yard = SweepYard::new("whole", 9, 5, 128);
    let whole = yard.gate(&["--no-store", "--out", "whole"]);
    let mut recordings = 0;
    for part in ["1/3", "2/3", "3/3"] {
        let done = yard.part(part, &[]);
        assert_eq!((done.code, done.out.as_str()), (0, ""), "{}", done.err);
        assert_eq!(told(&done, "pairs judged"), 5 * told(&done, "recordings"));
        recordings += told(&done, "recordings");
    }
    assert_eq!(recordings, 9);
    // A second process of a share finds all of it done.
    let again = yard.part("2/3", &[]);
    assert_eq!(
        (again.code, told(&again, "pairs judged")),
        (0, 0),
        "{}",
        again.err
    );
    let collected = yard.collect(&[]);
    assert_eq!(collected.code, whole.code, "{}", collected.err);
    for name in [
        "summary.json",
        "summary.csv",
        "junit.xml",
        "summary.md",
        "index.html",
    ] {
        // Only a run that judges knows how long it took.
        let whole = without_times(&yard.text(&format!("whole/{name}")));
        assert!(
            yard.text(&format!("collected/{name}")) == whole,
            "{name} differs"
        );
    }
    // A gate finds what shares have judged.
    let cached = yard.gate(&["--store", "store", "--out", "third"]);
    assert!(
        cached.err.contains("45 of 45 pairs cached"),
        "{}",
        cached.err
    );
    // Shares of another number find it, too.
    let other = yard.part("1/1", &[]);
    assert_eq!(told(&other, "in the store before"), 45, "{}", other.err);
}

/// A name's share is its hash's, for good: from `printf r0000.csv | sha256sum`, its first sixteen
/// bytes modulo the number of shares, plus one.
#[test]
fn val_a_recording_stays_in_its_share() {
    for (name, of, number) in [
        ("r0000.csv", 7, 5),
        ("r0001.csv", 7, 3),
        ("a/b.csv#12", 100, 52),
    ] {
        assert_eq!(Share::number_of(name, of), number, "{name}");
    }
    for wrong in ["0/3", "4/3", "1", "a/b", "1/0", "-1/3"] {
        assert!(Share::parse(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn cli_a_missing_pair_is_an_error_and_no_summary() {
    let yard = SweepYard::new("missing", 6, 3, 0);
    yard.part("1/2", &[]);
    let done = yard.collect(&[]);
    assert_eq!(done.code, 4, "{}", done.err);
    let of_second = (0..6).map(|number| format!("recordings/r{number:04}.csv"));
    for name in of_second.filter(|name| Share::number_of(name, 2) == 2) {
        assert!(
            done.out.contains(&format!("{name}: 3 pairs")),
            "{}",
            done.out
        );
    }
    assert!(!yard.path("collected").exists());
    let status = yard.gate(&["--store", "store", "--status", "--format", "json"]);
    let standing: Value = serde_json::from_str(&status.out).unwrap();
    let sum = ["done", "missing"].map(|key| standing[key].as_u64().unwrap());
    assert_eq!(sum.iter().sum::<u64>(), 18);
    assert!(sum[1] > 0);
    // A design that joins is missing for every recording; the others are not judged again.
    yard.part("2/2", &[]);
    let more = format!("{}[[designs]]\nname = \"a\"\n", yard.text("gate.toml"));
    yard.folder.write("gate.toml", more);
    assert_eq!(yard.collect(&[]).code, 4);
    let done = yard.part("1/1", &[]);
    assert_eq!(
        (
            told(&done, "pairs judged"),
            told(&done, "in the store before")
        ),
        (6, 18)
    );
    assert_ne!(yard.collect(&[]).code, 4);
}

#[test]
fn cli_a_damaged_line_is_never_taken_for_one() {
    let yard = SweepYard::new("damaged", 3, 4, 0);
    yard.part("1/1", &[]);
    let file = yard.files().remove(0);
    let text = fs::read_to_string(&file).unwrap();
    let collected = || {
        let _ = fs::remove_dir_all(yard.path("collected"));
        yard.collect(&[])
    };
    let code = collected().code;
    assert_ne!(code, 4);
    let whole = yard.text("collected/summary.json");
    let mut start = 0;
    let mut missed = 0;
    for line in text.lines() {
        let mut bytes = text.clone().into_bytes();
        bytes[start + line.len() / 2] ^= 4;
        fs::write(&file, &bytes).unwrap();
        let done = collected();
        assert!(done.err.contains("judged again"), "{}", done.err);
        // What is begun and ended is no decision.
        if line.contains("\"note\":\"begun\"") || line.contains("\"note\":\"ended\"") {
            assert_eq!(done.code, code, "{}", done.err);
            assert_eq!(yard.text("collected/summary.json"), whole);
        } else {
            assert_eq!(done.code, 4, "{line}\n{}", done.err);
            assert!(!yard.path("collected").exists());
            missed += 1;
        }
        start += line.len() + 1;
    }
    assert!(missed >= 12 + 3, "{missed} lines");
    let again = yard.part("1/1", &[]);
    assert_eq!(again.code, 0, "{}", again.err);
    assert_eq!(collected().code, code);
    assert_eq!(yard.text("collected/summary.json"), whole);
}

/// A shared file system shows a file late: it is waited for, as its owner said that it is done.
#[test]
fn cli_a_late_file_is_waited_for() {
    let yard = SweepYard::new("late", 3, 2, 0);
    let done = yard.part("1/1", &[]);
    assert_eq!(done.code, 0, "{}", done.err);
    let file = yard.files().remove(0);
    let away = yard.path("away");
    fs::rename(&file, &away).unwrap();
    let waiting = yard
        .command(&["--store", "store", "--collect", "--out", "collected"])
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(2500));
    assert!(!yard.path("collected").exists());
    fs::rename(&away, &file).unwrap();
    let output = waiting.wait_with_output().unwrap();
    assert_ne!(output.status.code(), Some(4));
    assert!(yard.path("collected/summary.json").exists());
}

/// What never comes is named, and nothing is made of the rest. A file that a list does not show yet
/// is opened by the name that its owner told.
#[test]
fn cli_a_file_that_never_comes_is_named() {
    let yard = SweepYard::new("never", 3, 2, 0);
    assert_eq!(yard.part("1/1", &[]).code, 0);
    let file = yard.files().remove(0);
    let bytes = fs::read(&file).unwrap();
    let name = file.file_name().unwrap().to_str().unwrap().to_string();
    let collect = || yard.collect(&["--patience", "2"]);
    // Absent; then a part of it, as a cache may hold it.
    for part in [0, bytes.len() / 2] {
        fs::remove_file(&file).unwrap();
        if part > 0 {
            fs::write(&file, &bytes[..part]).unwrap();
        }
        let done = collect();
        assert_eq!(done.code, 4, "{}", done.err);
        let told = format!("{name} is marked as finished, but is missing or too short");
        assert!(done.err.contains(&told), "{}", done.err);
        assert!(!yard.path("collected").exists());
        fs::write(&file, &bytes).unwrap();
    }
    // No list of the store holds a file of such a name.
    let unlisted = file.with_extension("unlisted");
    fs::rename(&file, &unlisted).unwrap();
    let said = yard.text("store/done-share-1-of-1.json");
    let now = name.replace(".jsonl", ".unlisted");
    yard.folder
        .write("store/done-share-1-of-1.json", said.replace(&name, &now));
    assert_ne!(collect().code, 4);
    assert!(yard.path("collected/summary.json").exists());
}

/// Of what is no line of the store nothing is taken, and nothing of it is in the way.
#[cfg(unix)]
#[test]
fn cli_foreign_files_in_a_store_change_nothing() {
    let yard = SweepYard::new("foreign", 4, 3, 0);
    let code = yard.gate(&["--no-store", "--out", "whole"]).code;
    let other = SweepYard::new("foreign-other", 6, 3, 128);
    other.part("1/1", &[]);
    let foreign = fs::read(other.files().remove(0)).unwrap();
    let mut random = Random::new(3);
    let noise: Vec<u8> = (0..100_000).map(|_| random.below(256) as u8).collect();
    yard.folder.write("store/noise.jsonl", &noise);
    yard.folder.write("store/empty.jsonl", "");
    yard.folder
        .write("store/a-1-0-share-1-of-1.jsonl", &foreign);
    yard.folder.write(
        "store/a-2-0-share-9-of-1.jsonl",
        &foreign[..foreign.len() / 3],
    );
    yard.folder.write("store/folder.jsonl/x", "x");
    yard.folder.write(
        "store/done-share-1-of-1.json",
        "{\"files\":{\"../../etc\":9",
    );
    std::os::unix::fs::symlink("nowhere", yard.path("store/gone.jsonl")).unwrap();
    let pipe = std::process::Command::new("mkfifo")
        .arg(yard.path("store/pipe.jsonl"))
        .status();
    assert!(pipe.unwrap().success());
    let done = yard.part("1/1", &[]);
    assert_eq!(
        (done.code, told(&done, "pairs judged")),
        (0, 12),
        "{}",
        done.err
    );
    assert_eq!(yard.part("1/1", &[]).code, 0);
    let done = yard.collect(&[]);
    assert_eq!(done.code, code, "{}", done.err);
    assert!(
        done.err.contains("noise.jsonl: ") && done.err.contains(" lines with a wrong checksum"),
        "{}",
        done.err
    );
    assert_eq!(
        yard.text("collected/summary.json"),
        yard.text("whole/summary.json")
    );
    // With a design more the others are known.
    let more = format!("{}[[designs]]\nname = \"a\"\n", yard.text("gate.toml"));
    yard.folder.write("gate.toml", more);
    let done = yard.part("1/1", &[]);
    assert_eq!(told(&done, "in the store before"), 12, "{}", done.err);
}

/// A gate of very many pairs is summed up like any other.
#[test]
fn cli_many_pairs_are_summed_up() {
    let yard = SweepYard::new("many", 0, 350, 0);
    for number in 0..300 {
        let name = format!("recordings/r{number:04}.csv");
        yard.folder.write(&name, format!("nothing {number}\n"));
    }
    let done = yard.part("1/1", &["--threads", "2"]);
    assert_eq!(
        (done.code, told(&done, "pairs judged")),
        (0, 105_000),
        "{}",
        done.err
    );
    let done = yard.collect(&[]);
    assert_eq!(done.code, 4, "{}", done.err);
    let summary: Value = serde_json::from_str(&yard.text("collected/summary.json")).unwrap();
    assert_eq!(summary["counts"]["unusable"], 105_000);
    assert_eq!(summary["pairs"].as_array().unwrap().len(), 105_000);
    assert_eq!(yard.text("collected/summary.csv").lines().count(), 105_001);
    let markdown = yard.text("collected/summary.md");
    assert!(
        markdown.contains("further pairs in summary.csv"),
        "{markdown}"
    );
}
