//! Words for a filter that was applied before a channel was stored.

use super::words;
use crate::code::CLASSES;
use crate::words::{Words, word_list};

// The head of each list explains it.
static FILTERS: Words = word_list!("name-filters");
static UNFILTERED: Words = word_list!("name-unfiltered");
static NEGATIONS: Words = word_list!("name-negations");

/// A filter that a text states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Filtered {
    /// A channel frequency class.
    Class(String),
    /// A filter whose class is not stated.
    Unclassed,
}

/// True if a name or a comment says that nothing was filtered: `unfiltered`, `ohne Filter`.
pub(crate) fn says_unfiltered(text: &str) -> bool {
    let words = words(text);
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    has(&UNFILTERED) || (has(&FILTERS) && has(&NEGATIONS))
}

/// Finds a filter in a name or a comment: `CFC60`, `SAE 180`, `class 60`, `filtered`.
pub(crate) fn filter_in(text: &str) -> Option<Filtered> {
    let words = words(text);
    let class = |number: &str| CLASSES.iter().find(|class| **class == number);
    let named = words.iter().enumerate().find_map(|(index, word)| {
        ["cfc", "sae", "class", "klasse", "filterklasse"]
            .iter()
            .filter_map(|start| word.strip_prefix(start))
            .find_map(|suffix| match suffix {
                "" => class(words.get(index + 1)?),
                number => class(number),
            })
    });
    if let Some(class) = named {
        return Some(Filtered::Class((*class).to_string()));
    }
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let low_pass = words
        .windows(2)
        .any(|pair| matches!(pair[0].as_str(), "low" | "high" | "band") && pair[1] == "pass");
    let class_without_number = has(&["cfc"]);
    if class_without_number || ((has(&FILTERS) || low_pass) && !has(&NEGATIONS)) {
        return Some(Filtered::Unclassed);
    }
    None
}
