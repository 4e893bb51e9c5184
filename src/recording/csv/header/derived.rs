//! Names of what was computed from an acceleration, or is none: rectified, held, averaged,
//! modelled. Such numbers lack the sign or the shape of the motion that a lever feels.

use super::{ACCELERATION, LATERAL_ACCELERATION, words};
use crate::recording::words::{Words, word_list};

/// Words for what is computed. Whole words only: `std` is one, `studs` holds none.
static COMPUTED: Words = word_list!("name-computed");

/// Words for other quantities than a linear acceleration.
static OTHER_QUANTITIES: Words = word_list!("name-other-quantities");

/// Tells whether a name says another quantity than a linear acceleration.
pub(super) fn says_other_quantity(label: &str) -> bool {
    words(label)
        .iter()
        .any(|word| OTHER_QUANTITIES.contains(&word.as_str()))
}

/// Tells whether a name says something computed: by a word, by bars (`|ay|`), by a sign before it
/// (`-ay`), or as a difference or sum of two of a kind (`ay1-ay2`).
pub(super) fn says_computed(label: &str) -> bool {
    let label = label.trim();
    let words = words(label);
    words.iter().any(|word| is_computed(word))
        || label.matches('|').count() > 1
        || label.contains(['‖', '√', '∑', 'Σ', 'Δ', '∫'])
        || label.starts_with(['-', '−'])
        || combines_two(label, &words)
}

/// Tells whether a word is one for what is computed, alone or grown together with one for an
/// acceleration: `ayabs`, `maxacc`.
fn is_computed(word: &str) -> bool {
    let word = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let says = |word: &str| COMPUTED.contains(&word);
    says(word)
        || LATERAL_ACCELERATION
            .iter()
            .chain(ACCELERATION.iter())
            .any(|stem| match stem.len() {
                // `amin` and `arms` are words of their own.
                1 => false,
                _ => {
                    word.strip_prefix(stem).is_some_and(says)
                        || word.strip_suffix(stem).is_some_and(says)
                }
            })
}

/// Tells whether arithmetic joins two words of one kind: `ay1-ay2`, `acc y left + acc y right`.
fn combines_two(label: &str, words: &[String]) -> bool {
    if !label.contains(['-', '−', '–', '+', '/', '*']) {
        return false;
    }
    let stems: Vec<&str> = words
        .iter()
        .map(|word| {
            let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
            // A letter alone is part of many a name: `A-pillar a y`.
            if word.len() > 1 { stem } else { "" }
        })
        .filter(|stem| {
            LATERAL_ACCELERATION.contains(stem) || ACCELERATION.contains(stem) || *stem == "y"
        })
        .collect();
    let twice = |stem: &&str| stems.iter().filter(|other| *other == stem).count() > 1;
    stems.iter().any(twice)
}
