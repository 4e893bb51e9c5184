//! Guards the store of decisions: what is damaged is found and judged again, nothing else is.

use super::Yard;
use crate::support::{Random, finish, program};
use std::fs;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::Duration;

const GATE: &str = "[[recordings]]\nfiles = [\"pass.csv\", \"fail.csv\", \"doubt.csv\"]\nopens_when = \"negative\"\nmembers = 512\n\
                    [[designs]]\nname = \"paper\"\n[[designs]]\nfile = \"designs/stiff.toml\"\n";

fn files(yard: &Yard) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = fs::read_dir(yard.folder.path().join(".latchgate"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "jsonl"))
        .collect();
    found.sort();
    found
}

#[test]
fn cli_a_second_run_takes_every_decision_from_the_store() {
    let yard = Yard::new("cached");
    let first = yard.gate(GATE, &[]);
    assert!(!first.err.contains("cached"), "{}", first.err);
    let summary = yard.text("summary.json");
    let second = yard.gate(GATE, &[]);
    assert!(second.err.contains("6 of 6 pairs cached"), "{}", second.err);
    assert_eq!((second.out, second.code), (first.out, first.code));
    assert_eq!(yard.text("summary.json"), summary);
    // A run that had nothing to keep leaves no file.
    assert_eq!(files(&yard).len(), 1);
    let tag = fs::read_to_string(yard.folder.path().join(".latchgate/CACHEDIR.TAG")).unwrap();
    assert!(tag.starts_with("Signature: 8a477f597d28d172789f06886806bc55"));
    // Nobody commits it by accident.
    assert_eq!(
        fs::read_to_string(yard.folder.path().join(".latchgate/.gitignore")).unwrap(),
        "*\n"
    );
    // In a folder that was there other files must not vanish from git.
    fs::create_dir(yard.folder.path().join("kept")).unwrap();
    yard.gate(GATE, &["--store", "kept"]);
    assert!(yard.folder.path().join("kept/CACHEDIR.TAG").exists());
    assert!(!yard.folder.path().join("kept/.gitignore").exists());
}

/// The preload that a report advises is searched once: the next run takes it from the store.
#[test]
fn cli_a_second_run_searches_no_advice() {
    let yard = Yard::new("advised");
    let gate = "[[recordings]]\nfiles = \"fail.csv\"\nopens_when = \"negative\"\nmembers = 0\n\
                [[designs]]\nname = \"paper\"\n";
    let advised = || -> String {
        let report = fs::read_dir(yard.out("reports"))
            .unwrap()
            .next()
            .unwrap()
            .unwrap();
        let text = fs::read_to_string(report.path().join("verdict.json")).unwrap();
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        document["preload_answer"]["text"].as_str().unwrap().into()
    };
    let notes = || -> usize {
        let kept = files(&yard)
            .into_iter()
            .map(|file| fs::read_to_string(file).unwrap());
        kept.map(|text| text.matches("\"advised\"").count() / 2)
            .sum()
    };
    yard.gate(gate, &["--reports", "failing"]);
    let first = advised();
    assert_eq!(notes(), 1);
    yard.gate(gate, &["--reports", "failing"]);
    assert_eq!((advised(), notes()), (first.clone(), 1));
    // A damaged line is no advice: it is searched again.
    let file = files(&yard).remove(0);
    let text = fs::read_to_string(&file).unwrap();
    let spoilt: String = first.chars().rev().collect();
    fs::write(&file, text.replace(&first, &spoilt)).unwrap();
    yard.gate(gate, &["--reports", "failing"]);
    assert_eq!((advised(), notes()), (first, 2));
}

/// What the laboratory says of a file belongs to the question: a card changes the pair's name.
#[test]
fn cli_a_card_is_part_of_what_is_cached() {
    let yard = Yard::new("card");
    yard.gate(GATE, &[]);
    yard.folder.write("pass.csv.toml", "range_g = 4.9\n");
    let done = yard.gate(GATE, &[]);
    assert_eq!(done.code, 4, "{}{}", done.out, done.err);
    assert!(done.err.contains("4 of 6 pairs cached"), "{}", done.err);
}

/// A decision is kept under every file that it may rest on: of a test of several files one that changes is
/// enough for another question.
#[test]
fn cli_every_file_of_a_test_is_part_of_what_is_cached() {
    use crate::{ev5, mme};

    let files = mme::test_of(&[mme::File::new(mme::PILLAR)]);
    let (ev5, _) = ev5::test_of("gate-ev5", &[ev5::PLAIN]);
    let (tsv, _) = ev5::test_of("gate-tsv", &[ev5::PLAIN]);
    let curve = tsv.path().join("v00001.007");
    fs::rename(curve, tsv.path().join("v00001007.tsv")).unwrap();
    let mme = mme::folder_of("gate-mme", &files);
    for (folder, recordings, files) in [
        (
            &mme,
            "T7.mme",
            &["T7.mme", "Channel/T7.001", "Channel/T7.chn"][..],
        ),
        (
            &mme,
            "Channel/T7.chn",
            &["Channel/T7.001", "Channel/T7.chn"],
        ),
        (
            &mme,
            "Channel/T7.001",
            &["Channel/T7.001", "Channel/T7.chn"],
        ),
        (&ev5, "v00001.EV5", &["v00001.EV5", "v00001.007"]),
        (&tsv, "v00001.EV5", &["v00001.EV5", "v00001007.tsv"]),
        (&ev5, "v00001.007", &["v00001.EV5", "v00001.007"]),
    ] {
        folder.write(
            "gate.toml",
            format!("[[recordings]]\nfiles = \"{recordings}\"\nopens_when = \"negative\"\nmembers = 0\n[[designs]]\nname = \"paper\"\n"),
        );
        let cached = || {
            // A share that knows a pair by its key reads nothing; a gate would see what changed by reading.
            let words = ["gate", "gate.toml", "--store", "store", "--part", "1/1"];
            let done = finish(program().current_dir(folder.path()).args(words));
            assert_eq!(done.code, 0, "{}", done.err);
            done.err.contains("0 pairs judged, 1 in the store before")
        };
        assert!(!cached() && cached(), "{recordings}");
        for file in files {
            let path = folder.path().join(file);
            let text = fs::read_to_string(&path).unwrap();
            // A blank at the end changes no sample.
            fs::write(&path, format!("{text} ")).unwrap();
            assert!(!cached(), "{recordings} with another {file}");
            fs::write(&path, text).unwrap();
            assert!(cached(), "{recordings}");
        }
    }
}

/// Files of one name beside one another are recordings of their own, whatever else changes.
#[test]
fn regress_neighbours_of_one_name_are_two_recordings() {
    let yard = Yard::new("siblings");
    let copy = |from: &str, to: &str| {
        let text = fs::read(yard.folder.path().join(from)).unwrap();
        yard.folder.write(to, text);
    };
    copy("pass.csv", "run.csv");
    copy("fail.csv", "run.txt");
    let gate = |files: &str| {
        format!(
            "[[recordings]]\nfiles = {files}\nopens_when = \"negative\"\nmembers = 0\n[[designs]]\nname = \"paper\"\n"
        )
    };
    assert_eq!(yard.gate(&gate("\"run.csv\""), &[]).code, 0);
    for _ in 0..2 {
        let done = yard.gate(&gate("[\"run.csv\", \"run.txt\"]"), &[]);
        assert_eq!(done.code, 1, "{}{}", done.out, done.err);
        assert!(
            done.out.contains("run.txt with paper: peak"),
            "{}",
            done.out
        );
    }
    yard.gate(
        &gate("[\"run.csv\", \"run.txt\"]"),
        &["--store", "s", "--part", "1/1"],
    );
    let done = yard.gate(
        &gate("[\"run.csv\", \"run.txt\"]"),
        &["--store", "s", "--collect"],
    );
    assert_eq!(done.code, 1, "{}{}", done.out, done.err);
    // A card in other letters beside the real one, and a pipe that has no end.
    yard.folder.write("run.csv.TOML", "channel = \"none\"\n");
    yard.folder.write("run.csv.toml", "synthetic = true\n");
    let pipe = std::process::Command::new("mkfifo")
        .arg(yard.folder.path().join("run.pipe"))
        .status();
    assert!(pipe.unwrap().success());
    assert_eq!(yard.gate(&gate("\"run.csv\""), &[]).code, 0);
    yard.folder.write("run.csv.toml", "range_g = 4.9\n");
    assert_eq!(yard.gate(&gate("\"run.csv\""), &[]).code, 4);
}

/// A row at the end of a line that is too long, or with what no replay says, is none.
#[test]
fn regress_what_only_looks_like_a_row_is_none() {
    let yard = Yard::new("odd-rows");
    let gate = "[[recordings]]\nfiles = \"pass.csv\"\nopens_when = \"negative\"\nmembers = 0\n[[designs]]\nname = \"paper\"\n";
    yard.gate(gate, &[]);
    let file = files(&yard).remove(0);
    let text = fs::read_to_string(&file).unwrap();
    let row = text.lines().last().unwrap();
    let (others, _) = text.split_at(text.len() - row.len() - 1);
    fs::write(&file, format!("{others}{}{row}\n", "x".repeat(1 << 16))).unwrap();
    let done = yard.gate(gate, &[]);
    assert!(
        !done.err.contains("cached") && done.err.contains("judged again"),
        "{}",
        done.err
    );
    // Another limit angle is another question.
    fs::write(&file, &text).unwrap();
    fs::remove_file(&files(&yard)[1]).unwrap();
    let (said, _) = row.split_once(",\"sum\":").unwrap();
    let row = sealed(&said.replace("\"lim\":0.1", "\"lim\":9.0"));
    fs::write(&file, format!("{others}{row}")).unwrap();
    let done = yard.gate(gate, &["--collect"]);
    assert_eq!(done.code, 4, "{}{}", done.out, done.err);
}

/// Every flipped byte is found, said, and changes no answer.
#[test]
fn prop_flipped_bytes_change_no_answer() {
    use latchgate::gate::{self, GateFile, GateRun, Plan, Store};
    use latchgate::pipeline::{Control, DecisionRow, Limits};

    let yard = Yard::new("flipped");
    yard.gate(GATE, &[]);
    let folder = yard.folder.path().join(".latchgate");
    let file = files(&yard).remove(0);
    let whole = fs::read(&file).unwrap();
    let limits = Limits::default();
    let gate = GateFile::from_toml("gate.toml", GATE, &limits).unwrap();
    let plan = Plan::of("gate.toml", &gate, yard.folder.path(), &[], &limits).unwrap();
    let run = || {
        let store = Store::open(&folder, "").unwrap();
        let run = gate::run(
            &plan,
            &limits,
            &store,
            &|| Duration::ZERO,
            &Control::default(),
        );
        for other in files(&yard).iter().filter(|other| **other != file) {
            fs::remove_file(other).unwrap();
        }
        run.unwrap()
    };
    let rows = |run: &GateRun| -> Vec<DecisionRow> {
        let recordings = run.recordings.iter();
        recordings
            .flat_map(|own| own.rows.iter().cloned())
            .collect()
    };
    let cached = |run: &GateRun| run.recordings.iter().map(|own| own.cached).sum::<usize>();
    let undamaged = run();
    assert!(undamaged.damages.is_empty() && cached(&undamaged) == 6);
    let undamaged = rows(&undamaged);
    let mut random = Random::new(7);
    let mut lost = 0;
    for turn in 0..80 {
        let (at, bit) = (random.below(whole.len()), random.below(8));
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << bit;
        fs::write(&file, &bytes).unwrap();
        let run = run();
        let place = format!("turn {turn}: byte {at}, bit {bit}");
        assert!(!run.damages.is_empty(), "{place}");
        lost += usize::from(cached(&run) < 6);
        assert_eq!(rows(&run), undamaged, "{place}");
    }
    // What was read is no row.
    assert!(lost > 60, "rows were lost in {lost} turns");
    // The gate says it, judges again, and answers as before.
    let before = yard.text("summary.json");
    let mut bytes = whole.clone();
    bytes[whole.len() / 2] ^= 1;
    fs::write(&file, &bytes).unwrap();
    let done = yard.gate(GATE, &[]);
    assert!(done.err.contains("judged again"), "{}", done.err);
    assert_eq!(yard.text("summary.json"), before);
}

/// Two decisions of a pair that differ are a fault of a machine or of latchgate: no answer is made of them.
#[test]
fn cli_decisions_that_contradict_each_other_are_named() {
    let yard = Yard::new("contradiction");
    yard.gate(GATE, &[]);
    let text = fs::read_to_string(&files(&yard)[0]).unwrap();
    let line = text
        .lines()
        .find(|line| line.contains("\"peak\":"))
        .unwrap();
    let (before, rest) = line.split_once("\"peak\":").unwrap();
    let (_, rest) = rest.split_once(',').unwrap();
    let (said, _) = rest.split_once(",\"sum\":").unwrap();
    let other = format!("{before}\"peak\":0.0625,{said}");
    let reasons = text
        .lines()
        .filter(|line| line.contains("\"note\":\"reason\""));
    let mut lines: Vec<String> = reasons.map(|line| format!("{line}\n")).collect();
    lines.push(sealed(&other));
    yard.folder.write(".latchgate/zz-1-0.jsonl", lines.concat());
    let done = yard.gate(GATE, &[]);
    assert_eq!(done.code, 4, "{}{}", done.out, done.err);
    assert!(
        done.err.contains("zz-1-0.jsonl") && done.err.contains("two that differ"),
        "{}",
        done.err
    );
    assert!(done.err.contains(".csv with "), "{}", done.err);
}

/// A line with its checksum: the first sixteen digits of the SHA-256 of what stands before it.
fn sealed(said: &str) -> String {
    use sha2::{Digest, Sha256};
    let digest = Sha256::digest(said);
    let sum: String = digest[..8]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    format!("{said},\"sum\":\"{sum}\"}}\n")
}

/// A gate that is killed at any moment, and two gates at once, end as one undisturbed run.
#[test]
fn cli_kills_and_company_change_no_answer() {
    let yard = Yard::new("killed");
    let gate =
        format!("{GATE}[[designs]]\nname = \"heavy\"\nset = {{ \"lever.mass_kg\" = 0.16 }}\n");
    let undisturbed = yard.gate(&gate, &["--no-store"]);
    let expected = yard.text("summary.json");
    let mut random = Random::new(11);
    for _ in 0..100 {
        let mut child = yard
            .command(&[])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_micros(500 + random.below(60_000) as u64));
        let _ = child.kill();
        child.wait().unwrap();
        if let Ok(summary) = fs::read_to_string(yard.out("summary.json")) {
            assert_eq!(summary, expected);
        }
        if random.one_in(10) {
            let _ = fs::remove_dir_all(yard.folder.path().join(".latchgate"));
        }
    }
    let left = |name: &str| yard.folder.path().join(format!(".latchgate-{name}-0.part"));
    for name in ["1", "2"] {
        fs::create_dir_all(left(name).join("a")).unwrap();
    }
    let in_use = fs::File::open(left("2")).unwrap();
    in_use.lock().unwrap();
    let mut company = yard
        .command(&["--out", "other"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let done = finish(yard.command(&[]));
    company.wait().unwrap();
    assert_eq!(
        (done.out.replace("out/", ""), done.code),
        (undisturbed.out.replace("out/", ""), undisturbed.code)
    );
    for folder in ["out", "other"] {
        let path = yard.folder.path().join(folder).join("summary.json");
        assert_eq!(fs::read_to_string(path).unwrap(), expected, "{folder}");
    }
    // What the killed ones left goes with the next; what is in use stays.
    drop(finish(yard.command(&[])));
    let entries = fs::read_dir(yard.folder.path()).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let parts: Vec<String> = names.filter(|name| name.ends_with(".part")).collect();
    assert_eq!(parts, [".latchgate-2-0.part"]);
}
