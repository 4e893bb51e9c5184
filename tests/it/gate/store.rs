//! Guards the store of decisions: what is damaged is found and judged again, nothing else is.

use super::Yard;
use crate::support::{Random, finish};
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
        .filter(|path| path.extension().is_some_and(|end| end == "rows"))
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

/// Every flipped byte is found, said, and changes no answer.
#[test]
fn prop_flipped_bytes_change_no_answer() {
    use latchgate::gate::Store;
    use latchgate::pipeline::DecisionRow;

    let yard = Yard::new("flipped");
    yard.gate(GATE, &[]);
    let folder = yard.folder.path().join(".latchgate");
    let whole = fs::read(&files(&yard)[0]).unwrap();
    let known = Store::open(&folder).unwrap();
    assert!(known.damages().is_empty());
    let row = |store: &Store, id: &str| {
        let address = store.find(id)?;
        Some(store.rows(&[address]).unwrap().remove(0))
    };
    let ids: Vec<String> = yard.summary()["pairs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pair| pair["row"]["report_id"].as_str().unwrap().to_string())
        .collect();
    let undamaged: Vec<DecisionRow> = ids.iter().map(|id| row(&known, id).unwrap()).collect();
    let mut random = Random::new(7);
    for turn in 0..1000 {
        let (at, bit) = (random.below(whole.len()), random.below(8));
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << bit;
        fs::write(&files(&yard)[0], &bytes).unwrap();
        let store = Store::open(&folder).unwrap();
        assert!(
            !store.damages().is_empty(),
            "turn {turn}: byte {at}, bit {bit}"
        );
        let mut lost = 0;
        for (id, undamaged) in ids.iter().zip(&undamaged) {
            match row(&store, id) {
                Some(row) => assert_eq!(row, *undamaged, "turn {turn}"),
                None => lost += 1,
            }
        }
        assert!(lost > 0, "turn {turn}: no row was lost with byte {at}");
    }
    // The gate says it, judges again, and answers as before.
    let before = yard.text("summary.json");
    let mut bytes = whole.clone();
    bytes[whole.len() / 2] ^= 1;
    fs::write(&files(&yard)[0], &bytes).unwrap();
    let done = yard.gate(GATE, &[]);
    assert!(done.err.contains("judged again"), "{}", done.err);
    assert_eq!(yard.text("summary.json"), before);
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
}
