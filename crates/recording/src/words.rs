//! Lists of words that readers know, each in its own file in `words/`, where words are added without a
//! change of the program.

use std::sync::LazyLock;

/// A list of words or phrases, read at its first use.
pub(super) type Words = LazyLock<Vec<&'static str>>;

/// Builds a list from the file of that name in `words/`.
macro_rules! word_list {
    ($name:literal) => {
        std::sync::LazyLock::new(|| $crate::words::list(word_list!(@text $name)))
    };
    (@text $name:literal) => {
        include_str!(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/src/words/",
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
