//! The lists of words that readers know: in order, each word once, none in two lists that
//! contradict one another.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Words that stand in two lists, each with the reason; any other word stands in one alone.
const SHARED: &[(&str, &str, &[&str], &str)] = &[
    (
        "clock-words",
        "preamble-keys",
        &[
            "abtastintervall\tinterval",
            "abtastperiode\tinterval",
            "abtastzeit\tinterval",
            "bemonsteringsfrequentie\trate",
            "dt\tinterval",
            "fs\trate",
            "messrate\trate",
            "rate\trate",
            "sps\trate",
            "timestep\tinterval",
            "xincr\tinterval",
            "zeitschritt\tinterval",
            "サンプリングレート\trate",
            "サンプリング周期\tinterval",
            "サンプリング周波数\trate",
            "サンプリング間隔\tinterval",
            "采样周期\tinterval",
            "采样率\trate",
            "采样间隔\tinterval",
            "采样频率\trate",
        ],
        "a key of a row, and a word near a number in a sentence",
    ),
    (
        "instant-after",
        "remark-empty",
        &["NA"],
        "Dutch for after, and a remark that is not available",
    ),
    (
        "iso-mme-measured",
        "name-acceleration",
        &["accelerometer"],
        "a sensor that measures says what it measures",
    ),
    (
        "iso-mme-measured",
        "name-plain",
        &["accelerometer", "sensor"],
        "what measures is plain in a name",
    ),
    (
        "iso-mme-measured",
        "name-time-plain",
        &["sensor"],
        "a clock may be that of a sensor",
    ),
    (
        "name-acceleration",
        "name-plain",
        &[
            "a",
            "ac",
            "acc",
            "accel",
            "acceleration",
            "accelerometer",
            "beschl",
            "beschleunigung",
        ],
        "what says acceleration raises no doubt in the name of one",
    ),
    (
        "name-acceleration",
        "name-time-plain",
        &["a"],
        "an acceleration beside an axis, an article beside time",
    ),
    (
        "name-filters",
        "name-plain",
        &["filtered", "gefiltert"],
        "a filter that is told raises no doubt of the place",
    ),
    ("name-index", "name-negations", &["no"], "number, and none"),
    (
        "name-index",
        "name-plain",
        &["no", "nr", "number"],
        "a running number, and the number of a sensor",
    ),
    (
        "name-index",
        "name-scales",
        &["count"],
        "a running number, and steps of a converter",
    ),
    (
        "name-gravity",
        "name-plain",
        &["gravity"],
        "gravity in the samples, and the centre of gravity as a place",
    ),
    (
        "name-gravity-without",
        "name-plain",
        &["center", "centre"],
        "a place, and no word for gravity in the samples",
    ),
    (
        "name-index",
        "name-time-plain",
        &["sample"],
        "a running number, and the time of a sample",
    ),
    (
        "name-index",
        "status-well",
        &["n", "no"],
        "a column of numbers, and no fault in a column of faults",
    ),
    ("name-negations", "name-plain", &["no"], "none, and number"),
    (
        "name-other-clocks",
        "name-time-plain",
        &["elapsed"],
        "a clock by itself, and plain in a name for time",
    ),
    (
        "name-negations",
        "status-well",
        &["no", "none", "off"],
        "no filter in a name, and no fault in a column of faults",
    ),
    (
        "name-other-units",
        "name-scales",
        &["bit", "bits", "digit", "m"],
        "a unit by itself, and what makes another of the one beside it",
    ),
    (
        "name-plain",
        "name-time-plain",
        &["a", "axis", "channel", "in", "of", "sensor", "test", "the"],
        "small words, plain in any name",
    ),
    (
        "name-plain",
        "name-unfiltered",
        &["raw", "unfiltered", "ungefiltert"],
        "what was not filtered raises no doubt of the place",
    ),
    (
        "name-plain",
        "status-well",
        &["no"],
        "number, and no fault in a column of faults",
    ),
    (
        "name-time-alone",
        "name-time-plain",
        &["t"],
        "time by its letter, alone and beside the word",
    ),
    (
        "status-valid",
        "status-well",
        &["gültig", "valid"],
        "the name of a column, and what stands in it",
    ),
];

/// Every list, by the name of its file.
fn lists() -> BTreeMap<String, Vec<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/recording/src/words");
    let mut lists = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|end| end == "txt") {
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.starts_with("# "), "{}: no purpose", path.display());
            let words = text.lines().filter(|line| !line.starts_with('#'));
            let name = path.file_stem().unwrap().to_str().unwrap().to_string();
            lists.insert(name, words.map(str::to_string).collect());
        }
    }
    lists
}

#[test]
fn tidy_lists_of_words_are_sorted_and_hold_each_word_once() {
    for (name, words) in lists() {
        assert!(!words.is_empty(), "{name} is empty");
        for pair in words.windows(2) {
            assert!(pair[0] < pair[1], "{name}: {} before {}", pair[0], pair[1]);
        }
        for word in &words {
            assert_eq!(word.trim(), word, "{name}");
            assert!(!word.is_empty(), "{name}: an empty line");
        }
    }
}

#[test]
fn tidy_lists_of_words_do_not_contradict_one_another() {
    let lists = lists();
    let names: Vec<&String> = lists.keys().collect();
    let mut found = Vec::new();
    for (index, one) in names.iter().enumerate() {
        let words: BTreeSet<&String> = lists[*one].iter().collect();
        for other in &names[index + 1..] {
            let both = lists[*other].iter().filter(|word| words.contains(word));
            let both: Vec<&str> = both.map(String::as_str).collect();
            let known = SHARED
                .iter()
                .find(|known| known.0 == *one && known.1 == *other);
            let known = known.map_or(&[][..], |(_, _, words, _)| words);
            if both != known {
                found.push(format!("{one} and {other}: {both:?}, known are {known:?}"));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    for (one, other, words, reason) in SHARED {
        assert!(one < other && !words.is_empty() && !reason.is_empty());
        assert!(lists.contains_key(*one) && lists.contains_key(*other));
    }
}

/// Each list is read by the program, and each that it reads is there.
#[test]
fn tidy_every_list_of_words_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/recording/src");
    let mut source = String::new();
    let mut folders = vec![folder];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                source += &std::fs::read_to_string(path).unwrap();
            }
        }
    }
    for name in lists().keys() {
        assert!(
            source.contains(&format!("\"{name}\"")),
            "nobody reads {name}"
        );
    }
}
