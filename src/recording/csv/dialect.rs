//! Dialects: comment lines, separators and quotes of a table, found in its first rows and
//! checked on every line before the table is read.
//!
//! Every line is measured here first, because a table reader stores one number per cell: 256 MiB
//! of commas on one line would cost gigabytes there.

use crate::error::{Error, ErrorKind, Place};
use crate::recording::Limits;
use crate::recording::number;
use crate::recording::text::{self, line_at};

/// Rows from which the separator is found.
const SAMPLE_ROWS: usize = 64;

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
    /// The candidates; where two explain a table equally well, the first is meant.
    const CANDIDATES: [Self; 4] = [Self::Tab, Self::Semicolon, Self::Comma, Self::Blanks];

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

/// Bytes of a text whose lines are looked at together.
const BLOCK: usize = 4096;

/// Tells whether a line that begins with `byte` is a row without a further look.
fn begins_row(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'-' | b'.' | b'+')
}

/// Returns the bytes and the number of the whole lines that a block, from a line's start on,
/// holds; `None` if there is none, or one does not begin as a row does.
fn plain_rows(block: &[u8]) -> Option<(usize, u64)> {
    let last = memchr::memrchr(b'\n', block)?;
    let lines = &block[..last];
    // No early end, so that many bytes are compared at once.
    let others = lines
        .iter()
        .zip(&block[1..])
        .fold(!begins_row(block[0]), |found, (end, start)| {
            found | ((*end == b'\n') & !begins_row(*start))
        });
    let count = memchr::memchr_iter(b'\n', lines).count() as u64 + 1;
    (!others).then_some((last + 1, count))
}

/// What the lines of a text are.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct LineScan {
    /// The separator that a spreadsheet's `sep=;` names.
    pub(super) separator: Option<Separator>,
    /// The first line that is no row between one row, two, and three or more before it and
    /// others after it.
    breaks: [Option<u64>; 3],
    /// The first line after a row that is nothing but `##…`: a rule drawn, or the only cell of a
    /// row that a spreadsheet had no room for.
    pub(super) hashes: Option<u64>,
    /// Whether a comment follows a row.
    comments: bool,
    /// The text of comments that are words, with their lines; of very many the first.
    pub(super) words: Vec<(u64, String)>,
    /// Whether more are there.
    pub(super) more_words: bool,
    /// Bytes of those kept.
    kept: usize,
}

impl LineScan {
    /// Returns the first line that is no row between two rows of data.
    pub(super) fn break_after(&self, header_rows: usize) -> Option<u64> {
        self.breaks
            .iter()
            .skip(header_rows)
            .copied()
            .flatten()
            .next()
    }

    /// Returns the rows of so many numbers that were made comments: how many follow the header,
    /// the line of the first, and whether a row follows one of them.
    pub(super) fn rows_made_comments(
        &self,
        text: &[u8],
        separator: Separator,
        header_rows: usize,
        cells: usize,
    ) -> Option<(usize, u64, bool)> {
        if !self.comments {
            return None;
        }
        let mut found: Option<(usize, u64, bool)> = None;
        let mut rows = 0;
        for (index, line) in text.split(|byte| *byte == b'\n').enumerate() {
            if is_row(line) {
                rows += 1;
                if let Some(found) = &mut found {
                    found.2 = true;
                }
            } else if rows >= header_rows && is_row_of_numbers(line, separator, cells) {
                let (count, first, followed) = found.unwrap_or((0, index as u64 + 1, false));
                found = Some((count + 1, first, followed));
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

    /// Takes in that more rows follow a line that is none.
    fn close(&mut self, open: &mut Option<(u64, u64)>) {
        if let Some((line, rows)) = open.take() {
            let slot = usize::try_from(rows).map_or(2, |rows| rows.clamp(1, 3) - 1);
            self.breaks[slot].get_or_insert(line);
        }
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

/// Measures every line and marks what is no row: comments (`#`, `%`, `//`), empty lines and a
/// spreadsheet's `sep=;` get a `#` as their first byte. Returns what the lines are.
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] at the first line with too many bytes or separators,
/// [`ErrorKind::Malformed`] for a named separator that is not read, and for a row whose first cell
/// a spreadsheet damaged so that the row looks like a comment.
pub(super) fn scan_lines(text: &mut [u8], limits: &Limits) -> Result<LineScan, Error> {
    let mut marked = LineScan::default();
    let mut seen_row = false;
    // Rows so far, and the line that is none after them, with their number.
    let mut rows = 0_u64;
    let mut open: Option<(u64, u64)> = None;
    let mut next = 0;
    let mut index = 0_u64;
    let block = limits
        .line_bytes
        .min(limits.columns)
        .min(limits.field_bytes);
    let block = usize::try_from(block).map_or(BLOCK, |least| least.min(BLOCK));
    // Up to where lines are looked at one by one.
    let mut singly = 0;
    while next < text.len() {
        if seen_row && next >= singly {
            let end = text.len().min(next + block);
            if let Some((bytes, lines)) = plain_rows(&text[next..end]) {
                next += bytes;
                index += lines;
                rows += lines;
                marked.close(&mut open);
                continue;
            }
            singly = end;
        }
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
        // Most lines begin with a digit, a sign or a point, and are rows.
        if seen_row
            && begins_row(line[0])
            && line.len() as u64 <= limits.columns.min(limits.field_bytes)
        {
            rows += 1;
            marked.close(&mut open);
            continue;
        }
        let start = line.trim_ascii_start();
        let no_row = start.is_empty()
            || start.starts_with(b"#")
            || start.starts_with(b"%")
            || start.starts_with(b"//");
        if no_row && rows > 0 {
            open.get_or_insert((index, rows));
            marked.comments |= !start.is_empty();
        }
        match damage(start) {
            Some(Damage::Row) => {
                return Err(damaged_row(start).at(place(0).column(1)));
            }
            Some(Damage::Hashes) if rows > 0 => {
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
        rows += 1;
        marked.close(&mut open);
        check_row(line, first as u64, limits).map_err(|error| error.at(place(0)))?;
    }
    Ok(marked)
}

/// Finds the separator from the first rows: the one under which most of them have equally
/// many cells that are numbers.
pub(super) fn find_separator(text: &[u8]) -> Separator {
    let mut sample = sample(text);
    let mut best = (Separator::None, 0.0);
    for candidate in Separator::CANDIDATES {
        // The last candidate, so that the others have seen the sample as it is.
        if candidate == Separator::Blanks {
            collapse_blanks(&mut sample);
        }
        let score = score(&sample, candidate);
        if score > best.1 {
            best = (candidate, score);
        }
    }
    best.0
}

/// Returns the first rows, whole, without what stands between them.
fn sample(text: &[u8]) -> Vec<u8> {
    let mut rows = 0;
    let mut sample = Vec::new();
    for line in text.split_inclusive(|byte| *byte == b'\n') {
        if is_row(line) {
            sample.extend_from_slice(line);
            rows += 1;
            if rows == SAMPLE_ROWS || (rows >= FEW_ROWS && sample.len() > SAMPLE_BYTES) {
                break;
            }
        }
    }
    sample
}

/// Tells whether a marked line is a row.
pub(super) fn is_row(line: &[u8]) -> bool {
    !matches!(line.first(), None | Some(b'#' | b'\r' | b'\n'))
}

fn score(sample: &[u8], separator: Separator) -> f64 {
    if memchr::memchr(separator.byte(), sample).is_none() {
        // Rows of one cell explain nothing.
        return 0.0;
    }
    let mut rows: Vec<(usize, f64)> = Vec::with_capacity(SAMPLE_ROWS);
    let mut reader = reader(sample, separator, true);
    let mut record = ::csv::ByteRecord::new();
    while let Ok(true) = reader.read_byte_record(&mut record) {
        let (mut filled, mut numbers) = (0_u32, 0_u32);
        for cell in &record {
            filled += u32::from(!cell.trim_ascii().is_empty());
            numbers += u32::from(number::is_numeric(cell));
        }
        rows.push((
            record.len(),
            f64::from(numbers) / f64::from(filled).max(1.0),
        ));
    }
    // The commonest number of cells; among equally common ones, that of the last rows.
    let common = rows
        .iter()
        .map(|(cells, _)| *cells)
        .max_by_key(|cells| rows.iter().filter(|(other, _)| other == cells).count());
    match common {
        // A header counts a little, so that a file with nothing else is split as well.
        Some(common) if common >= 2 => rows
            .iter()
            .filter(|(cells, _)| *cells == common)
            .map(|(_, numbers)| 1.0 + 100.0 * numbers)
            .sum(),
        _ => 0.0,
    }
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
    use super::{Limits, scan_lines};

    /// Lines looked at together are marked as each of them is alone after a row.
    #[test]
    fn verif_blocks_of_lines_are_marked_as_single_lines_are() {
        const LINES: &[&str] = &[
            "1.5,2\n",
            "-3,4.25\n",
            "+1,.5\r\n",
            ".5,1\n",
            "# note\n",
            "\n",
            "\r\n",
            " 7,8\n",
            "  \n",
            "% note\n",
            "//\n",
        ];
        let alone = |line: &str| {
            let mut text = format!("0,0\n{line}").into_bytes();
            scan_lines(&mut text, &Limits::default()).expect("short lines");
            text.split_off(4)
        };
        let mut seed = 7_u64;
        for case in 0..400 {
            let (mut text, mut expected) = (b"0,0\n".to_vec(), b"0,0\n".to_vec());
            for _ in 0..3 * case {
                seed = seed
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                // Other lines than rows are rare, so that whole blocks are rows as well.
                let pick = usize::try_from(seed >> 40).expect("24 bits");
                let most = if pick % 64 == 0 { LINES.len() } else { 4 };
                let line = LINES[pick / 64 % most];
                text.extend_from_slice(line.as_bytes());
                expected.extend_from_slice(&alone(line));
            }
            scan_lines(&mut text, &Limits::default()).expect("short lines");
            assert!(text == expected, "case {case}");
        }
    }

    /// A line too long after many that are not is told at its own line and byte.
    #[test]
    fn verif_a_long_line_after_many_rows_is_told_at_its_place() {
        let rows = "1,2\n".repeat(5000);
        let mut text = format!("{rows}{}\n1,2\n", "3".repeat(99)).into_bytes();
        let limits = Limits {
            line_bytes: 60,
            ..Limits::default()
        };
        let error = scan_lines(&mut text, &limits).expect_err("a long line");
        let place = error.place();
        assert_eq!((place.line, place.byte), (Some(5001), Some(20_060)));
    }
}
