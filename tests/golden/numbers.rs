//! Guards `NUMBERS_REVISION`: it moves whenever a number or a finding of any golden case or of a
//! recording of `signals/` does, so that no stored answer passes for one of today.
//!
//! `tests/data/numbers.txt` holds the revision and a hash for each answer. What is hashed: the
//! document as canonical JSON without the question (`request`, `design`), its name (`report_id`,
//! `schema`), `run`, what is null or empty, and every text with a blank in it, which is written for
//! people; numbers, codes of findings and reasons, instants, names and hashes stay.

use super::process::latchgate;
use super::{TABLES, Table, hex};
use latchgate_document::identity::NUMBERS_REVISION;
use latchgate_test_support::{root, signal_file};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write as _;

const FILE: &str = "tests/data/numbers.txt";

/// What of an answer is a number or a finding; `None` where nothing is.
fn essence(value: &Value) -> Option<Value> {
    match value {
        Value::Null => None,
        Value::String(text) => (!text.contains(' ')).then(|| value.clone()),
        Value::Array(list) => {
            // Places in a list stay, so that a null in it is not taken for a shorter one.
            let list: Vec<Value> = list
                .iter()
                .map(|one| essence(one).unwrap_or_default())
                .collect();
            (!list.is_empty()).then_some(Value::Array(list))
        }
        Value::Object(table) => {
            let kept: serde_json::Map<String, Value> = table
                .iter()
                .filter(|(key, _)| {
                    !["run", "report_id", "schema", "request", "design"].contains(&key.as_str())
                })
                .filter_map(|(key, value)| Some((key.clone(), essence(value)?)))
                .collect();
            (!kept.is_empty()).then_some(Value::Object(kept))
        }
        number => Some(number.clone()),
    }
}

/// Hash of the exit code and the essence of an answer.
pub(super) fn hash(code: i32, document: &Value) -> String {
    let text = essence(document).unwrap_or_default().to_string();
    hex(&Sha256::digest(format!("{code} {text}").as_bytes()))
}

fn hash_of_program(arguments: &[&str]) -> String {
    let done = latchgate(&[arguments, &["--no-report", "--format", "json"]].concat());
    hash(done.code, &done.document())
}

/// Adds the hashes of the recordings of `signals/`.
fn of_signals(hashes: &mut BTreeMap<String, String>) {
    let names = std::fs::read_dir(root().join("signals")).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    for name in names.filter(|name| !name.ends_with(".toml")) {
        let file = signal_file(&name);
        for options in [
            "replay --members 128",
            "replay --members 128 --seed 7 --opens-when both --filter none --bias none",
            "replay --members 0 --method dopri5",
            "replay --members 0 --model soft --set stop.damping_n_s_per_m=3e4",
            "margin --members 0",
        ] {
            let (command, options) = options.split_once(' ').unwrap();
            let words: Vec<&str> = [command, &file]
                .into_iter()
                .chain(options.split(' '))
                .collect();
            hashes.insert(
                format!("signals {name} {command} {options}"),
                hash_of_program(&words),
            );
        }
    }
}

fn written(hashes: &BTreeMap<String, String>) -> String {
    hashes.iter().fold(
        format!("revision {NUMBERS_REVISION}\n"),
        |mut text, (name, hash)| {
            let _ = writeln!(text, "{hash} {name}");
            text
        },
    )
}

/// A renewal that moves hashes of cases that stay is refused while the revision stands.
#[test]
fn regress_numbers_move_with_their_revision_alone() {
    let mut hashes = BTreeMap::new();
    std::thread::scope(|scope| {
        let signals = scope.spawn(|| {
            let mut hashes = BTreeMap::new();
            of_signals(&mut hashes);
            hashes
        });
        for answered in TABLES.iter().flat_map(Table::answers) {
            hashes.insert(answered.name.clone(), answered.essence.clone());
        }
        hashes.extend(signals.join().unwrap());
    });
    let renew = std::env::var_os("LATCHGATE_RENEW").is_some();
    let path = root().join(FILE);
    if renew && !path.exists() {
        std::fs::write(&path, written(&hashes)).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap();
    let (first, lines) = stored.split_once('\n').expect("a first line");
    let revision: u32 = first.strip_prefix("revision ").unwrap().parse().unwrap();
    let known: BTreeMap<&str, &str> = lines
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(h, name)| (name, h))
        .collect();
    let moved: Vec<&str> = known
        .iter()
        .filter(|(name, hash)| hashes.get(**name).is_some_and(|new| new != *hash))
        .map(|(name, _)| *name)
        .collect();
    assert!(
        moved.is_empty() || revision != NUMBERS_REVISION,
        "numbers or findings of {} answers moved, and NUMBERS_REVISION is still {revision}. If they \
         shall move, raise it in crates/document/src/identity.rs, run `LATCHGATE_RENEW=1 cargo test --test golden \
         numbers_move_with` and say in CHANGELOG.md what moved:\n{}",
        moved.len(),
        moved.join("\n")
    );
    if renew {
        std::fs::write(&path, written(&hashes)).unwrap();
        return;
    }
    assert!(
        stored == written(&hashes),
        "{FILE} is not of today (revision {NUMBERS_REVISION}, cases added or removed); run \
         `LATCHGATE_RENEW=1 cargo test --test golden numbers_move_with`"
    );
}

#[test]
fn tidy_the_essence_of_an_answer_is_its_numbers_and_findings() {
    let of = |text: &str| {
        essence(&serde_json::from_str(text).unwrap())
            .unwrap()
            .to_string()
    };
    let whole = r#"{"a": 1.5, "b": {"text": "two words", "code": "clipping"}, "run": {"x": 1}}"#;
    assert_eq!(of(whole), r#"{"a":1.5,"b":{"code":"clipping"}}"#);
    assert_eq!(
        of(r#"{"z": [null, 1], "y": [], "x": null}"#),
        r#"{"z":[null,1]}"#
    );
    assert_eq!(
        of(r#"{"request": {"seed": 1}, "c": {"design": 2, "d": true}}"#),
        r#"{"c":{"d":true}}"#
    );
}
