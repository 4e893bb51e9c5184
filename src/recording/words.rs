//! Lists of words that readers know, each in a file of its own in `words/`, where words are added
//! without a look at the program.

use std::sync::LazyLock;

/// A list of words or phrases, read at its first use.
pub(super) type Words = LazyLock<Vec<&'static str>>;

/// Successions of words, each one of several.
pub(super) type Phrases = LazyLock<Vec<Vec<Vec<&'static str>>>>;

/// Takes a list from the file of that name in `words/`.
macro_rules! word_list {
    ($name:literal) => {
        std::sync::LazyLock::new(|| $crate::recording::words::list(word_list!(@text $name)))
    };
    (@text $name:literal) => {
        include_str!(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/src/recording/words/",
            $name,
            ".txt"
        ))
    };
}
pub(super) use word_list;

/// Returns the lines of a list that are no comments.
pub(super) fn list(text: &'static str) -> Vec<&'static str> {
    text.lines()
        .filter(|line| !line.starts_with('#') && !line.is_empty())
        .collect()
}

/// Reads phrases: places of words with blanks between them, at each place words with `/` between
/// them, or in angle brackets the name of a list that `lists` has.
pub(super) fn phrases(text: &'static str, lists: &[(&str, &Words)]) -> Vec<Vec<Vec<&'static str>>> {
    let place = |place: &'static str| {
        let named = lists.iter().find(|(name, _)| place == format!("<{name}>"));
        match named {
            Some((_, words)) => words.to_vec(),
            None => place.split('/').collect(),
        }
    };
    let phrase = |line: &'static str| line.split(' ').map(place).collect();
    list(text).into_iter().map(phrase).collect()
}
