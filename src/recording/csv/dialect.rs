//! Dialects: comment lines, separators and quotes of a table, found in its first rows and
//! checked on every line before the table is read.
//!
//! Every line is measured here first, because a table reader stores one number per cell: 256 MiB
//! of commas on one line would cost gigabytes there.

use crate::error::{Error, ErrorKind, Place};
use crate::recording::Limits;
use crate::recording::number;
use crate::recording::text::{self, line_at};

/// Rows and bytes from which on fewer rows do: rows may be long.
pub(super) const FEW_ROWS: usize = 8;
pub(super) const SAMPLE_BYTES: usize = 4 << 20;

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
const COMMENT_BYTES: usize = 1 << 20;

/// Tells whether a line that begins with `byte` is a row without a further look.
fn begins_row(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'-' | b'.' | b'+')
}

/// What stands between the rows of a table.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Interruptions {
    /// The first line that is no row between two rows of data.
    pub(super) broken_at: Option<u64>,
    /// Comments that hold as many numbers as a row, the line of the first, and whether a row
    /// follows one.
    pub(super) numbers: usize,
    pub(super) numbers_at: Option<u64>,
    pub(super) numbers_inside: bool,
}

/// What the lines of a text are.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct LineScan {
    /// The separator that a spreadsheet's `sep=;` names.
    pub(super) separator: Option<Separator>,
    /// The first line after a row that is nothing but `##…`: a rule drawn, or the only cell of a
    /// row that a spreadsheet had no room for.
    pub(super) hashes: Option<u64>,
    /// Whether a line that is no row follows a row.
    interrupted: bool,
    /// The text of comments that are words, with their lines; of very many the first.
    pub(super) words: Vec<(u64, String)>,
    /// Whether more are there.
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
                found.numbers_inside |= found.numbers_at.is_some();
                continue;
            }
            if rows > header_rows {
                open.get_or_insert(number);
            }
            if rows >= header_rows && is_row_of_numbers(line, separator, cells) {
                found.numbers += 1;
                found.numbers_at.get_or_insert(number);
            }
        }
        found
    }

    /// Keeps what a comment says.
    fn keep(&mut self, line: u64, comment: &[u8]) {
        let marks = |byte: &u8| matches!(byte, b'#' | b'%' | b'/' | b' ' | b'\t');
        let skipped = comment.iter().take_while(|byte| marks(byte)).count();
        let comment = comment[skipped..].trim_ascii_end();
        if !comment.iter().any(u8::is_ascii_alphabetic) {
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

/// Reads a spreadsheet's line that names the separator, `sep=;`; `None` for any other line.
fn named_separator(line: &[u8]) -> Option<Result<Separator, ErrorKind>> {
    let bare = line
        .strip_prefix(b"\"")
        .and_then(|rest| rest.strip_suffix(b"\""))
        .unwrap_or(line);
    let (key, value) = bare.split_at_checked(4)?;
    if !key.eq_ignore_ascii_case(b"sep=") || value.len() > 1 {
        return None;
    }
    Some(match value {
        b";" => Ok(Separator::Semicolon),
        b"," => Ok(Separator::Comma),
        b"" | b"\t" => Ok(Separator::Tab),
        b" " => Ok(Separator::Blanks),
        other => Err(ErrorKind::Malformed {
            expected: "a comma, a semicolon, a tab or blanks between cells".into(),
            found: format!("`{}` by the line sep=", String::from_utf8_lossy(other)),
            hint: "export with one of them".into(),
        }),
    })
}

/// Tells whether a comment holds `cells` numbers and nothing else.
fn is_row_of_numbers(line: &[u8], separator: Separator, cells: usize) -> bool {
    let marks = line
        .iter()
        .take_while(|byte| matches!(byte, b'#' | b'%' | b'/' | b' ' | b'\t'))
        .count();
    let body = line[marks..].trim_ascii_end();
    let mut found = 0;
    for cell in body.split(|byte| *byte == separator.byte()) {
        found += 1;
        if found > cells || !number::is_numeric(cell) {
            return false;
        }
    }
    found == cells
}

/// What a line that begins as a comment does is to a spreadsheet.
enum Damage {
    /// A row whose first cell was damaged.
    Row,
    /// Nothing but `##…`.
    Hashes,
}

/// Tells whether a line's first cell is what a spreadsheet writes for a number that has no room
/// in its column (`####`) or could not be computed (`#NUM!`, `#N/A`), and not a comment's start.
fn damage(start: &[u8]) -> Option<Damage> {
    let line = start.trim_ascii_end();
    let end = |cells: &[u8]| {
        cells
            .iter()
            .position(|byte| matches!(byte, b',' | b';' | b'\t' | b' '))
            .unwrap_or(cells.len())
    };
    let (cell, rest) = line.split_at(end(line));
    let hashes = is_overflow(cell);
    if !hashes && !is_error_value(cell) {
        return None;
    }
    let bare = rest.trim_ascii_start();
    if bare.is_empty() {
        return Some(if hashes { Damage::Hashes } else { Damage::Row });
    }
    // Behind a blank words go on, but no numbers.
    let row = matches!(rest[0], b',' | b';' | b'\t')
        || matches!(bare[0], b',' | b';' | b'\t')
        || bare
            .split(|byte| matches!(byte, b' ' | b'\t'))
            .filter(|cell| !cell.is_empty())
            .all(|cell| number::is_numeric(cell) || is_overflow(cell) || is_error_value(cell));
    row.then_some(Damage::Row)
}

fn is_overflow(cell: &[u8]) -> bool {
    cell.len() > 1 && cell.iter().all(|byte| *byte == b'#')
}

/// Tells whether a cell is a spreadsheet's error, in whichever language: `#DIV/0!`, `#WERT!`.
fn is_error_value(cell: &[u8]) -> bool {
    let Some(word) = cell.strip_prefix(b"#") else {
        return false;
    };
    let upper = |byte: &u8| !byte.is_ascii_lowercase() && !byte.is_ascii_whitespace();
    match word {
        [name @ .., b'!' | b'?'] => {
            name.first().is_some_and(u8::is_ascii_uppercase)
                && name.iter().all(|byte| upper(byte) && *byte != b'#')
        }
        _ => matches!(word, b"N/A" | b"NA" | b"NV" | b"N/D" | b"N/B"),
    }
}

/// Refuses a row that would be passed over as a comment for what stands in its first cell.
pub(super) fn damaged_row(line: &[u8]) -> Error {
    ErrorKind::Malformed {
        expected: "a number in the first cell, or a comment".into(),
        found: format!(
            "`{}`, as spreadsheets write for a number that does not fit into its column or could not be computed",
            super::cell::shown(line)
        ),
        hint: "widen the column or mend the cell there, and export again; the sample of this row would be missing".into(),
    }
    .into()
}

/// Refuses a row, which begins at byte `first`, with a cell that is too long or too many cells by
/// any separator.
fn check_row(line: &[u8], first: u64, limits: &Limits) -> Result<(), Error> {
    let separates = |byte| matches!(byte, b',' | b';' | b'\t' | b' ');
    text::check_fields(line, first, separates, limits)?;
    if line.len() as u64 > limits.columns {
        for separator in [b',', b';', b'\t'] {
            check_columns(line, separator, limits)?;
        }
    }
    Ok(())
}

/// Returns the separator that a spreadsheet's first line names, if it is such a line. A tab may be
/// named as it stands, so that only line ends are cut off at first.
fn separator_line(line: &[u8]) -> Option<Result<Separator, ErrorKind>> {
    let end = line
        .iter()
        .rposition(|byte| !matches!(byte, b'\r' | b'\n'))
        .map_or(0, |last| last + 1);
    named_separator(&line[..end]).or_else(|| named_separator(line.trim_ascii_end()))
}

/// What a person says of the lines above the samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Above {
    /// Lines that are passed over.
    pub(super) lines: u64,
    /// Whether the line behind them names the columns, be it a comment or not.
    pub(super) named: bool,
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
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] at the first line with too many bytes or separators,
/// [`ErrorKind::Malformed`] for a named separator that is not read, and for a row whose first cell
/// a spreadsheet damaged so that the row looks like a comment.
pub(super) fn scan_lines(
    text: &mut [u8],
    above: Above,
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
            return Err(
                over("line_bytes", limits.line_bytes, "a longer line").at(place(limits.line_bytes))
            );
        }
        let skipped = index <= above.lines;
        if above.named && index == above.lines + 1 {
            uncomment(line);
        }
        // Most lines begin with a digit, a sign or a point, and are rows.
        if seen_row
            && begins_row(line[0])
            && line.len() as u64 <= limits.columns.min(limits.field_bytes)
        {
            continue;
        }
        let start = line.trim_ascii_start();
        let no_row = start.is_empty()
            || skipped
            || start.starts_with(b"#")
            || start.starts_with(b"%")
            || start.starts_with(b"//");
        marked.interrupted |= no_row && seen_row;
        if skipped && marked.separator.is_none() {
            marked.separator = separator_line(start).and_then(Result::ok);
        }
        match damage(start).filter(|_| !skipped) {
            Some(Damage::Row) => {
                return Err(damaged_row(start).at(place(0).column(1)));
            }
            Some(Damage::Hashes) if seen_row => {
                marked.hashes.get_or_insert(index);
            }
            _ => {}
        }
        if start.is_empty() {
            // The table reader skips a bare line end by itself, and it must stay one.
            if !matches!(line[0], b'\r' | b'\n') {
                line[0] = b'#';
            }
            continue;
        }
        if no_row {
            marked.keep(index, start);
            line[0] = b'#';
            continue;
        }
        if !seen_row {
            seen_row = true;
            if let Some(separator) = separator_line(start) {
                marked.separator = Some(separator.map_err(|kind| Error::from(kind).at(place(0)))?);
                line[0] = b'#';
                continue;
            }
        }
        check_row(line, first as u64, limits).map_err(|error| error.at(place(0)))?;
    }
    Ok(marked)
}

/// Tells whether a marked line is a row.
pub(super) fn is_row(line: &[u8]) -> bool {
    !matches!(line.first(), None | Some(b'#' | b'\r' | b'\n'))
}

/// Replaces each run of blanks and tabs by one blank and drops those at the ends of lines; in
/// place, so that no second copy of a file is held.
pub(super) fn collapse_blanks(text: &mut Vec<u8>) {
    let (mut read, mut written) = (0, 0);
    while read < text.len() {
        let next = memchr::memchr(b'\n', &text[read..]).map_or(text.len(), |end| read + end + 1);
        let ended = text[next - 1] == b'\n';
        let mut started = false;
        let mut pending = false;
        // What trimming the line would drop at its end is written only once more follows.
        let last = text[read..next]
            .iter()
            .rposition(|byte| !byte.is_ascii_whitespace())
            .map_or(read, |at| read + at + 1);
        for index in read..last {
            let byte = text[index];
            if !started && byte.is_ascii_whitespace() {
                continue;
            }
            started = true;
            if matches!(byte, b' ' | b'\t') {
                pending = true;
                continue;
            }
            if pending {
                text[written] = b' ';
                written += 1;
                pending = false;
            }
            text[written] = byte;
            written += 1;
        }
        if ended {
            text[written] = b'\n';
            written += 1;
        }
        read = next;
    }
    text.truncate(written);
}

/// Checks what only the chosen separator tells: the columns of each line, and that no quoted
/// cell runs over a line's end.
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] or [`ErrorKind::Malformed`] at the first bad line.
pub(super) fn check_lines(
    text: &[u8],
    separator: Separator,
    quoted: bool,
    limits: &Limits,
) -> Result<(), Error> {
    if !quoted && separator != Separator::Blanks {
        return Ok(());
    }
    for (index, line) in text.split(|byte| *byte == b'\n').enumerate() {
        if !is_row(line) {
            continue;
        }
        let place = || Place::default().line(index as u64 + 1);
        if line.len() as u64 > limits.columns {
            check_columns(line, separator.byte(), limits).map_err(|error| error.at(place()))?;
        }
        if quoted && ends_inside_quotes(line, separator.byte()) {
            return Err(Error::from(ErrorKind::Malformed {
                expected: "a quoted cell to end on its line".into(),
                found: "no closing quote".into(),
                hint: "add the quote, or remove the line break in the cell".into(),
            })
            .at(place()));
        }
    }
    Ok(())
}

/// Follows the quoting rule of the table reader: a quote opens at the start of a cell only,
/// and two quotes inside stand for one.
fn ends_inside_quotes(line: &[u8], separator: u8) -> bool {
    let mut at_start = true;
    let mut inside = false;
    for byte in line {
        if inside {
            // A doubled quote closes and at once opens again.
            if *byte == b'"' {
                inside = false;
                at_start = true;
            }
        } else if *byte == b'"' && at_start {
            inside = true;
        } else {
            at_start = *byte == separator;
        }
    }
    inside
}

fn check_columns(line: &[u8], separator: u8, limits: &Limits) -> Result<(), Error> {
    let cells = 1 + memchr::memchr_iter(separator, line).count() as u64;
    if cells > limits.columns {
        return Err(over(
            "columns",
            limits.columns,
            &format!("{cells} cells on a line"),
        ));
    }
    Ok(())
}

fn over(limit: &'static str, value: u64, found: &str) -> Error {
    ErrorKind::LimitExceeded {
        limit,
        value,
        found: found.into(),
    }
    .into()
}

/// Opens a table reader on marked text.
pub(super) fn reader(text: &[u8], separator: Separator, quoted: bool) -> ::csv::Reader<&[u8]> {
    ::csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(separator.byte())
        .comment(Some(b'#'))
        .quoting(quoted)
        .buffer_capacity(text.len().clamp(1 << 10, 1 << 16))
        .from_reader(text)
}

/// Returns the line on which the record stands that the table reader began at `byte`; it may
/// have begun with comments and empty lines.
pub(super) fn line_of_record(text: &[u8], byte: u64) -> u64 {
    let start = usize::try_from(byte).unwrap_or(usize::MAX).min(text.len());
    let before = text[start..]
        .split_inclusive(|byte| *byte == b'\n')
        .take_while(|line| !is_row(line))
        .count();
    line_at(text, start) + before as u64
}

#[cfg(test)]
mod tests {
    use super::{Above, Limits, scan_lines};

    /// A line too long after many that are not is told at its own line and byte.
    #[test]
    fn verif_a_long_line_after_many_rows_is_told_at_its_place() {
        let rows = "1,2\n".repeat(5000);
        let mut text = format!("{rows}{}\n1,2\n", "3".repeat(99)).into_bytes();
        let limits = Limits {
            line_bytes: 60,
            ..Limits::default()
        };
        let error = scan_lines(&mut text, Above::default(), &limits).expect_err("a long line");
        let place = error.place();
        assert_eq!((place.line, place.byte), (Some(5001), Some(20_060)));
    }
}
