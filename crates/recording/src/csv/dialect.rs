//! Dialects: comment lines and separators of a table. Every line is measured before the table is
//! read.

use crate::error::{Error, Place};
use crate::{Limits, number, text};

/// What separates the cells of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    Tab,
    Semicolon,
    Comma,
    /// Runs of blanks and tabs.
    Blanks,
    /// Nothing: one column.
    None,
}

impl Separator {
    /// Every separator; where two explain a table equally well, the first is meant.
    pub(super) const ALL: [Self; 5] = [
        Self::Tab,
        Self::Semicolon,
        Self::Comma,
        Self::Blanks,
        Self::None,
    ];

    /// Returns the word for it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Tab => "tab",
            Self::Semicolon => "semicolon",
            Self::Comma => "comma",
            Self::Blanks => "blanks",
            Self::None => "nothing",
        }
    }

    /// Returns the byte that the table reader splits at.
    pub(super) fn byte(self) -> u8 {
        match self {
            Self::Tab => b'\t',
            Self::Semicolon => b';',
            Self::Comma => b',',
            Self::Blanks => b' ',
            // The unit separator of ASCII, which no text table holds.
            Self::None => 0x1F,
        }
    }
}

/// Bytes of comments that are read.
pub(super) const COMMENT_BYTES: usize = 1 << 20;

/// True if a line that begins with `byte` is a row without a further look.
pub(super) fn begins_row(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'-' | b'.' | b'+')
}

/// What stands between the rows of a table.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Interruptions {
    /// The first line that is no row between two rows of data.
    pub(super) broken_at: Option<u64>,
    /// Comments that hold as many numbers as a row, and the line of the first.
    pub(super) numbers: usize,
    pub(super) numbers_at: Option<u64>,
    /// The first row that a spreadsheet made a comment.
    pub(super) damaged: Option<(u64, String)>,
}

/// What the lines of a text are.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct LineScan {
    /// True if a line is no row.
    interrupted: bool,
    /// Lines above the table that are no comments, as they stand.
    pub(super) above: Vec<(u64, String)>,
    /// Lines of numbers behind the last one of the table.
    pub(super) rows_below: usize,
    /// The text of comments that are words, with their lines; of very many the first.
    pub(super) words: Vec<(u64, String)>,
    /// True if more are there.
    pub(super) more_words: bool,
    /// Bytes of those kept.
    kept: usize,
}

impl LineScan {
    /// Finds what stands between the rows of data, which follow so many of a header.
    pub(super) fn interruptions(
        &self,
        text: &[u8],
        separator: Separator,
        header_rows: usize,
        cells: usize,
    ) -> Interruptions {
        let mut found = Interruptions::default();
        if !self.interrupted {
            return found;
        }
        let (mut rows, mut open) = (0, None);
        for (line, number) in text.split(|byte| *byte == b'\n').zip(1..) {
            if is_row(line) {
                rows += 1;
                found.broken_at = found.broken_at.or(open.take());
                continue;
            }
            if rows > header_rows {
                open.get_or_insert(number);
            }
            if rows >= header_rows
                && let Some(cell) = damaged_cell(line, separator, cells)
            {
                found.damaged.get_or_insert((number, text::shown(cell)));
            }
            if rows >= header_rows && is_row_of_numbers(line, separator, cells) {
                found.numbers += 1;
                found.numbers_at.get_or_insert(number);
            }
        }
        found
    }

    /// Keeps a line above the table.
    fn keep_above(&mut self, line: u64, text: &[u8]) {
        if self.kept + text.len() > COMMENT_BYTES {
            self.more_words = true;
            return;
        }
        self.kept += text.len() + 64;
        let text = String::from_utf8_lossy(text.trim_ascii_end()).into_owned();
        self.above.push((line, text));
    }

    /// Keeps what a comment says.
    pub(super) fn keep(&mut self, line: u64, comment: &[u8]) {
        let comment = uncommented(comment);
        if !comment
            .iter()
            .any(|byte| byte.is_ascii_alphabetic() || !byte.is_ascii())
        {
            return;
        }
        if self.kept + comment.len() > COMMENT_BYTES {
            self.more_words = true;
            return;
        }
        self.kept += comment.len() + 64;
        self.words
            .push((line, String::from_utf8_lossy(comment).into_owned()));
    }
}

/// True if a comment holds `cells` numbers and nothing else.
fn is_row_of_numbers(line: &[u8], separator: Separator, cells: usize) -> bool {
    let mut found = uncommented(line).split(|byte| *byte == separator.byte());
    found.clone().take(cells + 1).count() == cells && found.all(number::is_numeric)
}

/// Returns what a comment says, without its marks.
pub(super) fn uncommented(line: &[u8]) -> &[u8] {
    let marks = |byte: &&u8| matches!(**byte, b'#' | b'%' | b'/' | b' ' | b'\t');
    line[line.iter().take_while(marks).count()..].trim_ascii_end()
}

/// Returns the first cell of a comment that is a row: what a spreadsheet writes for a number that has
/// no room in its column (`####`) or could not be computed (`#NUM!`, `#N/A`).
fn damaged_cell(line: &[u8], separator: Separator, cells: usize) -> Option<&[u8]> {
    let all = line.trim_ascii().split(|byte| *byte == separator.byte());
    let mut all: Vec<&[u8]> = all.map(<[u8]>::trim_ascii).collect();
    while all.len() > cells && all.last().is_some_and(|cell| cell.is_empty()) {
        all.pop();
    }
    let (first, others) = all.split_first()?;
    // Other alphabets have capitals of their own: `#NÚM!`.
    let is_word = |byte: &u8| byte.is_ascii_uppercase() || !byte.is_ascii();
    let mark = |byte: &u8| is_word(byte) || b"#/0!?".contains(byte);
    let damaged = first.len() > 1 && first.starts_with(b"#") && first.iter().all(mark);
    // Behind a blank words go on in a comment, numbers in a row.
    let words = |cell: &&[u8]| !number::is_numeric(cell) && !cell.starts_with(b"#");
    let goes_on = separator == Separator::Blanks && others.iter().any(words);
    (damaged && all.len() == cells && !goes_on).then_some(*first)
}

/// True if a line is that of a spreadsheet which names the separator, `sep=;`.
fn names_separator(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    let bare = line.strip_prefix(b"\"").unwrap_or(line);
    bare.len() < 7
        && bare
            .get(..4)
            .is_some_and(|key| key.eq_ignore_ascii_case(b"sep="))
}

/// What a person says, or a look at the table has found, of the lines around the samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableBounds {
    /// Lines above the table.
    pub(super) above: u64,
    /// True if the line behind them names the columns, be it a comment or not.
    pub(super) named: bool,
    /// Last line of the table.
    pub(super) last: u64,
}

/// Takes the marks of a comment off a line.
fn uncomment(line: &mut [u8]) {
    let marks = |byte: &&mut u8| matches!(**byte, b'#' | b'%' | b'/');
    line.iter_mut()
        .take_while(marks)
        .for_each(|byte| *byte = b' ');
}

/// Measures every line and marks what is no row: comments (`#`, `%`, `//`), empty lines and a
/// spreadsheet's `sep=;` get a `#` as their first byte, and so do those that are
/// no samples by a person's word. Returns what the lines are.
pub(super) fn scan_lines(
    text: &mut [u8],
    bounds: TableBounds,
    limits: &Limits,
) -> Result<LineScan, Error> {
    let mut marked = LineScan::default();
    let mut seen_row = false;
    let mut next = 0;
    let mut index = 0_u64;
    while next < text.len() {
        let first = next;
        let rest = &mut text[first..];
        let length = memchr::memchr(b'\n', rest).map_or(rest.len(), |end| end + 1);
        let line = &mut rest[..length];
        next += length;
        index += 1;
        let place = |beyond: u64| Place::default().line(index).byte(first as u64 + beyond);
        if line.len() as u64 > limits.line_bytes {
            return Err(limits
                .over("line_bytes", "a longer line")
                .at(place(limits.line_bytes)));
        }
        let (above, below) = (index <= bounds.above, index > bounds.last);
        if bounds.named && index == bounds.above + 1 {
            uncomment(line);
        }
        // Most lines begin with a digit, a sign or a point, and are rows.
        if seen_row && !below && begins_row(line[0]) {
            continue;
        }
        let start = line.trim_ascii_start();
        let comment = [b"#".as_slice(), b"%", b"//"]
            .iter()
            .any(|mark| start.starts_with(mark));
        let no_row = start.is_empty() || above || below || comment;
        marked.interrupted |= no_row && !above && !below;
        if start.is_empty() {
            // The table reader skips a bare line end by itself, and it must stay one.
            if !matches!(line[0], b'\r' | b'\n') {
                line[0] = b'#';
            }
            continue;
        }
        if no_row {
            match (
                above && !comment,
                below && !start.iter().any(u8::is_ascii_alphabetic),
            ) {
                (true, _) => marked.keep_above(index, start),
                (_, true) => marked.rows_below += 1,
                _ => marked.keep(index, start),
            }
            line[0] = b'#';
            continue;
        }
        if !seen_row {
            seen_row = true;
            if names_separator(start) {
                line[0] = b'#';
            }
        }
    }
    Ok(marked)
}

/// True if a marked line is a row.
pub(super) fn is_row(line: &[u8]) -> bool {
    !matches!(line.first(), None | Some(b'#' | b'\r' | b'\n'))
}

/// Replaces each run of blanks and tabs by one blank and drops those at the ends of lines; in
/// place, so that no second copy of a file is held.
pub(super) fn collapse_blanks(text: &mut Vec<u8>) {
    // A carriage return stands at the end of a line.
    let blanks = text.iter_mut().filter(|byte| matches!(byte, b'\t' | b'\r'));
    blanks.for_each(|byte| *byte = b' ');
    text.dedup_by(|next, last| match (*last, *next) {
        (b' ' | b'\n', b' ') => true,
        (b' ', b'\n') => {
            *last = b'\n';
            true
        }
        _ => false,
    });
    if text.last() == Some(&b' ') {
        text.pop();
    }
    if text.first() == Some(&b' ') {
        text.remove(0);
    }
}
