//! Makes text from files safe to show: in markup and on a terminal.
//!
//! Channel names, file names and findings come from outside. They may hold markup, control
//! characters that steer a terminal, or characters that turn the reading direction and so
//! make a text look like another one.

use latchgate_document::json::steers;
use std::borrow::Cow;

/// Replaces a character that must not be shown.
const REPLACEMENT: char = '\u{FFFD}';

/// Returns `text` for use between tags and inside quoted attributes of HTML, SVG and XML.
///
/// The five characters of markup become entities, line ends and tabs become spaces; what XML
/// forbids and what would reorder the text becomes U+FFFD.
pub fn markup(text: &str) -> Cow<'_, str> {
    if text.chars().all(|c| !is_markup(c) && shown(c) == c) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            other => out.push(shown(other)),
        }
    }
    Cow::Owned(out)
}

/// Returns `text` for use on one line of a terminal: nothing in it can move the cursor,
/// change colours, begin a line or turn the reading direction.
pub fn terminal(text: &str) -> Cow<'_, str> {
    if text.chars().all(|c| shown(c) == c) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.chars().map(shown).collect())
}

/// Returns `text` for a cell of a table that a spreadsheet opens. What it would take for a formula gets an apostrophe
/// in front.
pub fn cell(text: &str) -> Cow<'_, str> {
    if text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']) {
        Cow::Owned(format!("'{text}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// Returns a word of a shell's command line, quoted for this system's shells where it needs it.
pub fn shell(word: &str) -> String {
    if cfg!(windows) {
        quoted_for_windows(word)
    } else {
        quoted_for_posix(word)
    }
}

fn quoted_for_posix(word: &str) -> String {
    if is_plain(word, "-_./=:,+") {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Quotes a word for both shells of Windows. The command prompt knows double quotes alone; PowerShell expands
/// variables within them, so words that it would expand are in single quotes.
fn quoted_for_windows(word: &str) -> String {
    if is_plain(word, "-_./=:+\\") {
        word.to_string()
    } else if word.contains(['"', '$', '`']) {
        format!("'{}'", word.replace('\'', "''"))
    } else {
        format!("\"{word}\"")
    }
}

fn is_plain(word: &str, marks: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || marks.contains(c);
    !word.is_empty() && word.chars().all(plain)
}

fn is_markup(c: char) -> bool {
    matches!(c, '&' | '<' | '>' | '"' | '\'')
}

fn shown(c: char) -> char {
    match c {
        '\n' | '\r' | '\t' => ' ',
        '\u{FFFE}' | '\u{FFFF}' => REPLACEMENT,
        other if steers(other) => REPLACEMENT,
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::{quoted_for_posix, quoted_for_windows};

    #[test]
    fn verif_words_reach_the_shell_of_each_system_whole() {
        for (word, posix, windows) in [
            ("a/b.csv", "a/b.csv", "a/b.csv"),
            (r"C:\a\b.csv", r"'C:\a\b.csv'", r"C:\a\b.csv"),
            ("a b", "'a b'", "\"a b\""),
            ("a&b", "'a&b'", "\"a&b\""),
            ("it's $1", r"'it'\''s $1'", "'it''s $1'"),
            ("", "''", "\"\""),
        ] {
            assert_eq!(quoted_for_posix(word), posix);
            assert_eq!(quoted_for_windows(word), windows);
        }
    }
}
