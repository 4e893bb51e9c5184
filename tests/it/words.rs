//! The lists of words that readers know: in order, each word once, none in two lists that
//! contradict one another.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Lists of which no word may stand in both, since they say the opposite.
const APART: &[(&str, &str)] = &[
    ("fault-words", "remark-empty"),
    ("fault-words", "instant-after"),
    ("fault-words", "instant-beside"),
    ("instant-after", "instant-beside"),
    ("status-well", "status-fault"),
    ("status-valid", "status-fault"),
    ("status-state", "remark-keys"),
    ("name-plain", "name-scales"),
    ("name-plain", "name-lateral"),
    ("name-filters", "name-negations"),
];

/// Every list, by the name of its file.
fn lists() -> BTreeMap<String, Vec<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/recording/words");
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
    for (one, other) in APART {
        let words: BTreeSet<&String> = lists[*one].iter().collect();
        let both: Vec<&String> = lists[*other].iter().filter(|w| words.contains(w)).collect();
        assert!(both.is_empty(), "{one} and {other}: {both:?}");
    }
}

/// Each list is read by the program, and each that it reads is there.
#[test]
fn tidy_every_list_of_words_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/recording");
    let mut source = std::fs::read_to_string(folder.with_extension("rs")).unwrap();
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
