//! Where a table begins, and what separates its cells: the longest run of rows with as many cells
//! each, numbers among them. Above it stand names, or a preamble of which a person is asked.

use super::dialect::{Separator, is_row, uncommented};
use super::stamp;
use crate::channel_name::{ChannelName, is_known_unit};
use crate::number;
use latchgate_kernel::units::DecimalMark;

/// Bytes of a text that are looked at.
pub(super) const LOOKED_AT: usize = 256 << 10;

/// Rows above the samples that may name them: names, units, descriptions.
const ABOVE: usize = 8;

/// Where a table seems to begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Begin {
    /// The line that names the columns, counted from 1, if there is one.
    pub(super) header: Option<u64>,
    /// The line of the first sample.
    pub(super) data: u64,
}

/// Rows of a text, each with its line.
type Lines<'a> = Vec<(u64, &'a [u8])>;

fn rows(text: &[u8]) -> Lines<'_> {
    text[..text.len().min(LOOKED_AT)]
        .split(|byte| *byte == b'\n')
        .zip(1..)
        .filter(|(line, _)| is_row(line))
        .map(|(line, number)| (number, line.trim_ascii_end()))
        .collect()
}

/// Finds the separator under which the longest run of rows holds most numbers; of equally good ones
/// the first. With a decimal comma a comma separates no cells, unless quotes hold the numbers
/// together.
pub(super) fn find_separator(text: &[u8], decimal: Option<DecimalMark>) -> Separator {
    let no_comma = decimal == Some(DecimalMark::Comma) && memchr::memchr(b'"', text).is_none();
    let rows = rows(text);
    match best_run(&rows, no_comma) {
        // No numbers: the header alone tells.
        (_, start) if start == rows.len() => {
            let of = |one: &Separator| rows.first().is_some_and(|row| row.1.contains(&one.byte()));
            let found = Separator::ALL.into_iter().find(of);
            found.unwrap_or(Separator::None)
        }
        (separator, _) => separator,
    }
}

/// Finds where the table begins, and the line above it that names the columns.
pub(super) fn find(text: &[u8]) -> Option<Begin> {
    let rows = rows(text);
    let (separator, start) = best_run(&rows, false);
    let (data, first) = *rows.get(start)?;
    let count = cells(first, separator).len();
    let words = |line| -> Vec<String> {
        let text = |cell: &[u8]| String::from_utf8_lossy(cell).into_owned();
        cells(line, separator).into_iter().map(text).collect()
    };
    let lines = text[..text.len().min(LOOKED_AT)].split(|byte| *byte == b'\n');
    let lines: Vec<(u64, &[u8])> = (1..data).zip(lines).collect();
    let above = lines
        .iter()
        .rev()
        .filter(|(_, line)| !line.trim_ascii().is_empty());
    // Some programs write the names as a comment.
    let fitting: Vec<(u64, bool, Vec<String>)> = above
        .take(ABOVE)
        .map(|(number, line)| (*number, is_row(line), words(uncommented(line))))
        .filter(|(_, _, cells)| cells.len() == count)
        .collect();
    let says_time = |cell: &String| says_time(cell.as_bytes());
    let names = fitting.iter().find(|one| one.2.iter().any(says_time));
    let is_time_unit = |one: &&(u64, bool, Vec<String>)| names_time_by_unit(&one.2);
    let names = names.or_else(|| fitting.first().filter(is_time_unit));
    let no_units =
        |one: &&(u64, bool, Vec<String>)| one.1 && !one.2.iter().any(|cell| is_known_unit(cell));
    let header = names.or_else(|| fitting.iter().find(no_units));
    // `0,1,2`, as some exports number the columns.
    let mut counted = cells(first, separator).into_iter().zip(0..);
    let counted = count > 1 && counted.all(|(cell, at)| cell == at.to_string().as_bytes());
    let header = header
        .map(|(number, ..)| *number)
        .or(counted.then_some(data));
    Some(Begin { header, data })
}

/// True if two rows follow one another that have as many cells each, numbers among them.
pub(super) fn has_rows(text: &[u8]) -> bool {
    let rows = rows(text);
    let (separator, start) = best_run(&rows, false);
    let width = |index: usize| Some(numbers(rows.get(index)?.1, separator)?.1);
    width(start).is_some() && width(start) == width(start + 1)
}

/// Finds the line that names the columns below a preamble, where nothing else can be meant: right above
/// the samples or their units, with a name above each cell, a word for time among them, and above it
/// nothing but rows that begin with a word.
pub(super) fn below_preamble(text: &[u8], known: Option<Separator>) -> Option<u32> {
    let rows = rows(text);
    let (separator, start) = match known {
        Some(separator) => (separator, longest_run(&rows, separator).1),
        None => best_run(&rows, false),
    };
    let (_, first) = rows.get(start)?;
    let width = cells(first, separator).len();
    let words = |index: usize| cells(rows[index].1, separator);
    let is_word =
        |cell: &[u8]| !cell.is_empty() && !number::is_numeric(cell) && !stamp::is_stamp(cell);
    let is_unit = |cell: &&[u8]| is_known_unit(&String::from_utf8_lossy(cell));
    let has_units = |index: usize| words(index).iter().any(is_unit);
    let is_full = |cells: &[&[u8]]| {
        cells.len() == width && width > 1 && cells.iter().all(|cell| is_word(cell))
    };
    let above = start.checked_sub(1)?;
    let names = match has_units(above) && !words(above).iter().any(|cell| says_time(cell)) {
        true => above.checked_sub(1)?,
        false => above,
    };
    let is_header = |cells: &[&[u8]]| is_full(cells) && cells.iter().any(|cell| says_time(cell));
    let by_unit = |cells: &[&[u8]]| {
        let texts = cells
            .iter()
            .map(|cell| String::from_utf8_lossy(cell).into_owned());
        // `x-axis,1,2` above them are the names.
        let is_number = |cell: &&[u8]| cell.iter().all(u8::is_ascii_digit);
        let numbered = above == 1 && words(0).len() == width && words(0)[1..].iter().all(is_number);
        is_full(cells) && names_time_by_unit(&texts.collect::<Vec<_>>()) && !numbered
    };
    let (names, is_header) = match is_header(&words(names)) {
        true => (names, true),
        false => (above, by_unit(&words(above))),
    };
    let first_cell = |index: usize| words(index).first().copied().unwrap_or_default();
    let is_preamble = |index: usize| is_word(first_cell(index)) || words(index) == [b""];
    let found = names > 0 && is_header && (0..names).all(is_preamble);
    found.then(|| u32::try_from(rows[names].0).ok()).flatten()
}

/// True if a cell is a name for time, with a unit or without.
fn says_time(cell: &[u8]) -> bool {
    let cell = String::from_utf8_lossy(cell);
    !is_known_unit(&cell) && ChannelName::from_header(&cell, 1).says_time()
}

/// True if names are the units alone, the first of them that of time, as oscilloscopes write them:
/// `Second,Volt`, `Second,Value`.
fn names_time_by_unit(cells: &[String]) -> bool {
    let first = cells.first().map(|cell| ChannelName::from_header(cell, 1));
    first.is_some_and(|column| column.says_time() && column.time_unit.is_some())
}

/// Splits a row, quotes taken off its cells; empty cells at its end are left out.
pub(super) fn cells(line: &[u8], separator: Separator) -> Vec<&[u8]> {
    let mark = separator.byte();
    let mut quoted = false;
    let separates = |byte: &u8| {
        quoted ^= *byte == b'"';
        let blank = separator == Separator::Blanks && *byte == b'\t';
        (*byte == mark || blank) && !quoted
    };
    let mut cells: Vec<&[u8]> = line.split(separates).map(unquoted).collect();
    if separator == Separator::Blanks {
        cells.retain(|cell| !cell.is_empty());
    }
    while cells.len() > 1 && cells.last().is_some_and(|cell| cell.is_empty()) {
        cells.pop();
    }
    cells
}

fn unquoted(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    let rest = cell.strip_prefix(b"\"");
    let inner = rest.and_then(|rest| rest.strip_suffix(b"\""));
    inner.unwrap_or(cell).trim_ascii()
}

/// Returns the separator with the best run of rows, and the index of the run's first row.
fn best_run(rows: &Lines<'_>, no_comma: bool) -> (Separator, usize) {
    let mut best = (0, Separator::None, rows.len());
    for separator in Separator::ALL {
        if no_comma && separator == Separator::Comma {
            continue;
        }
        let (score, start) = longest_run(rows, separator);
        if score > best.0 {
            best = (score, separator, start);
        }
    }
    (best.1, best.2)
}

/// Returns the sum of the shares of numbers in the rows of the longest run [1/1000], and the index
/// of its first row.
fn longest_run(rows: &Lines<'_>, separator: Separator) -> (usize, usize) {
    let mut best = (0, rows.len());
    let (mut score, mut start, mut width) = (0, 0, 0);
    for (index, (_, line)) in rows.iter().enumerate() {
        let Some((found, cells)) = numbers(line, separator) else {
            width = 0;
            continue;
        };
        if cells != width {
            (score, start, width) = (0, index, cells);
        }
        score += 1000 * found / cells;
        if score > best.0 {
            best = (score, start);
        }
    }
    best
}

/// Returns how many numbers a row holds, and how many cells; `None` without a number, or if it is not as
/// the separator has it.
fn numbers(line: &[u8], separator: Separator) -> Option<(usize, usize)> {
    let one = separator == Separator::None;
    let blank = separator == Separator::Blanks && line.contains(&b'\t');
    // Most rows hold no byte of most separators, and need not be split.
    if !(one || blank || line.contains(&separator.byte())) {
        return None;
    }
    let cells = cells(line, separator);
    if (cells.len() < 2) != one {
        return None;
    }
    let is_number = |cell: &&&[u8]| number::is_numeric(cell) || stamp::is_stamp(cell);
    let found = cells.iter().filter(is_number).count();
    (found > 0).then_some((found, cells.len()))
}
