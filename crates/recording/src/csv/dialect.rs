//! Dialects: comment lines and separators of a table. Every line is measured before the table is
//! read.

use crate::error::{Error, Place};
use crate::{Limits, number, text};

/// Separator of the cells of a row.
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
    /// Every separator; where two explain a table equally well, the first is chosen.
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

/// Most bytes of comments that are kept.
pub(super) const COMMENT_BYTES: usize = 1 << 20;
/// Memory of a kept line besides its text, roughly [byte]: many short lines are bounded as well.
pub(super) const LINE_OVERHEAD: usize = 64;

/// True if a line that begins with `byte` is a row without a further look.
pub(super) fn begins_row(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'-' | b'.' | b'+')
}

/// Lines between the rows of a table that are no rows.
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

/// Result of the scan of all lines.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct LineScan {
    /// True if a line is no row.
    interrupted: bool,
    /// Lines above the table that are no comments, as they stand.
    pub(super) above: Vec<(u64, String)>,
    /// Number of lines of numbers after the last one of the table.
    pub(super) rows_below: usize,
    /// Comments with words, each with its line; of very many the first.
    pub(super) words: Vec<(u64, String)>,
    /// True if there are more.
    pub(super) more_words: bool,
    /// Bytes of those kept.
    kept: usize,
}

impl LineScan {
    /// Finds the lines between the rows of data, which follow `header_rows` rows of the header.
    pub(super) fn interruptions(
        &self,
        text: &[u8],
        separator: Separator,
        header_rows: usize,
        cells: usize,
    ) -> Interruptions {
        let mut interruptions = Interruptions::default();
        if !self.interrupted {
            return interruptions;
        }
        let (mut rows, mut open) = (0, None);
        for (line, number) in text.split(|byte| *byte == b'\n').zip(1..) {
            if is_row(line) {
                rows += 1;
                interruptions.broken_at = interruptions.broken_at.or(open.take());
                continue;
            }
            if rows > header_rows {
                open.get_or_insert(number);
            }
            if rows >= header_rows
                && let Some(cell) = damaged_cell(line, separator, cells)
            {
                // The first sign of each line that is no row was made this one.
                let cell = match cell {
                    b"#/" => b"//",
                    cell => cell,
                };
                interruptions
                    .damaged
                    .get_or_insert((number, text::shown(cell)));
            }
            if rows >= header_rows && is_row_of_numbers(line, separator, cells) {
                interruptions.numbers += 1;
                interruptions.numbers_at.get_or_insert(number);
            }
        }
        interruptions
    }

    /// Keeps a line above the table.
    fn keep_above(&mut self, line: u64, text: &[u8]) {
        if self.kept + text.len() > COMMENT_BYTES {
            self.more_words = true;
            return;
        }
        self.kept += text.len() + LINE_OVERHEAD;
        let text = String::from_utf8_lossy(text.trim_ascii_end()).into_owned();
        self.above.push((line, text));
    }

    /// Keeps the words of a comment.
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
        self.kept += comment.len() + LINE_OVERHEAD;
        self.words
            .push((line, String::from_utf8_lossy(comment).into_owned()));
    }
}

/// True if a comment holds `cells` numbers and nothing else.
fn is_row_of_numbers(line: &[u8], separator: Separator, cells: usize) -> bool {
    let mut comment_cells = uncommented(line).split(|byte| *byte == separator.byte());
    comment_cells.clone().take(cells + 1).count() == cells && comment_cells.all(number::is_numeric)
}

/// Returns the text of a comment, without its marks.
pub(super) fn uncommented(line: &[u8]) -> &[u8] {
    let marks = |byte: &&u8| matches!(**byte, b'#' | b'%' | b'/' | b' ' | b'\t');
    line[line.iter().take_while(marks).count()..].trim_ascii_end()
}

/// Returns the first cell of a comment that is a row: what a spreadsheet writes for a number too wide
/// for its column (`####`) or one that could not be computed (`#NUM!`, `#N/A`).
fn damaged_cell(line: &[u8], separator: Separator, cells: usize) -> Option<&[u8]> {
    let row_cells = line.trim_ascii().split(|byte| *byte == separator.byte());
    let mut row_cells: Vec<&[u8]> = row_cells.map(<[u8]>::trim_ascii).collect();
    while row_cells.len() > cells && row_cells.last().is_some_and(|cell| cell.is_empty()) {
        row_cells.pop();
    }
    let (first, following) = row_cells.split_first()?;
    // Other alphabets have capitals of their own: `#NÚM!`.
    let is_word = |byte: &u8| byte.is_ascii_uppercase() || !byte.is_ascii();
    let mark = |byte: &u8| is_word(byte) || b"#/0!?".contains(byte);
    let damaged = first.len() > 1 && first.starts_with(b"#") && first.iter().all(mark);
    // After a blank a comment goes on with words, a row with numbers.
    let words = |cell: &&[u8]| !number::is_numeric(cell) && !cell.starts_with(b"#");
    let goes_on = separator == Separator::Blanks && following.iter().any(words);
    (damaged && row_cells.len() == cells && !goes_on).then_some(*first)
}

/// True if a line is a spreadsheet's line that names the separator, `sep=;`.
fn names_separator(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    let bare = line.strip_prefix(b"\"").unwrap_or(line);
    bare.len() < 7
        && bare
            .get(..4)
            .is_some_and(|key| key.eq_ignore_ascii_case(b"sep="))
}

/// Lines around the samples, as a person states them or as they were found.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableBounds {
    /// Lines above the table.
    pub(super) above: u64,
    /// True if the line after them names the columns, even as a comment.
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

/// Measures every line and marks those that are no rows: comments (`#`, `%`, `//`), empty lines, a
/// spreadsheet's `sep=;` and lines outside the bounds get a `#` as their first byte.
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
        let unread = &mut text[first..];
        let length = memchr::memchr(b'\n', unread).map_or(unread.len(), |end| end + 1);
        let line = &mut unread[..length];
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
    // A carriage return is at the end of a line.
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
