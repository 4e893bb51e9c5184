//! The begin of a table, and the separator of its cells: the longest run of rows with as many cells
//! each, numbers among them. Above it are names, or a preamble that a person has to explain.

use super::dialect::{Separator, is_row, uncommented};
use super::stamp;
use crate::channel_name::{ChannelName, is_known_unit};
use crate::number;
use latchgate_kernel::units::DecimalMark;

/// Bytes at the start of a text by which the table is found.
pub(super) const LOOKED_AT: usize = 256 << 10;

/// Rows above the samples that may name them: names, units, descriptions.
const ABOVE: usize = 8;

/// The lines where a table seems to begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Begin {
    /// The line that names the columns, counted from 1, if there is one.
    pub(super) header: Option<u64>,
    /// The line of the first sample.
    pub(super) data: u64,
}

/// A line above the samples with as many cells as they have.
struct HeadLine {
    /// Its number in the file, counted from 1.
    number: u64,
    is_comment: bool,
    cells: Vec<String>,
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
/// the first. With a decimal comma a comma separates no cells, unless quotes enclose the numbers.
pub(super) fn find_separator(text: &[u8], decimal: Option<DecimalMark>) -> Separator {
    let no_comma = decimal == Some(DecimalMark::Comma) && memchr::memchr(b'"', text).is_none();
    let rows = rows(text);
    match best_run(&rows, no_comma) {
        // Without numbers the first row decides.
        (_, start) if start == rows.len() => {
            let first = rows.first().map_or(&[][..], |row| row.1);
            let mut separators = Separator::ALL.into_iter();
            let separator = separators.find(|separator| first.contains(&separator.byte()));
            separator.unwrap_or(Separator::None)
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
    let fitting: Vec<HeadLine> = above
        .take(ABOVE)
        .map(|(number, line)| HeadLine {
            number: *number,
            is_comment: !is_row(line),
            cells: words(uncommented(line)),
        })
        .filter(|line| line.cells.len() == count)
        .collect();
    let says_time = |cell: &String| says_time(cell.as_bytes());
    let names = fitting
        .iter()
        .find(|line| line.cells.iter().any(says_time))
        .or_else(|| {
            let nearest = fitting.first();
            nearest.filter(|line| names_time_by_unit(&line.cells))
        });
    // A comment without a word for time is no line of names.
    let header = names.or_else(|| {
        let has_unit = |line: &HeadLine| line.cells.iter().any(|cell| is_known_unit(cell));
        fitting
            .iter()
            .find(|line| !line.is_comment && !has_unit(line))
    });
    // `0,1,2`, as some exports number the columns.
    let mut counted = cells(first, separator).into_iter().zip(0..);
    let counted = count > 1 && counted.all(|(cell, index)| cell == index.to_string().as_bytes());
    let header = header.map(|line| line.number).or(counted.then_some(data));
    Some(Begin { header, data })
}

/// True if two rows follow one another that have as many cells each, numbers among them.
pub(super) fn has_rows(text: &[u8]) -> bool {
    let rows = rows(text);
    let (separator, start) = best_run(&rows, false);
    let width = |index: usize| Some(count_cells(rows.get(index)?.1, separator)?.cells);
    width(start).is_some() && width(start) == width(start + 1)
}

/// Finds the line that names the columns below a preamble, where no other can be meant: right above
/// the samples or their units, with a name above each cell, a word for time among them, and above it
/// only rows that begin with a word.
pub(super) fn below_preamble(text: &[u8], known_separator: Option<Separator>) -> Option<u32> {
    let rows = rows(text);
    let (separator, start) = match known_separator {
        Some(separator) => (separator, longest_run(&rows, separator).start),
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
    let is_clear = names > 0 && is_header && (0..names).all(is_preamble);
    is_clear
        .then(|| u32::try_from(rows[names].0).ok())
        .flatten()
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
    let opened = cell.strip_prefix(b"\"");
    let inner = opened.and_then(|opened| opened.strip_suffix(b"\""));
    inner.unwrap_or(cell).trim_ascii()
}

/// Returns the separator with the best run of rows, and the index of the run's first row.
fn best_run(rows: &Lines<'_>, no_comma: bool) -> (Separator, usize) {
    let mut best = Run {
        score: 0,
        start: rows.len(),
    };
    let mut best_separator = Separator::None;
    for separator in Separator::ALL {
        if no_comma && separator == Separator::Comma {
            continue;
        }
        let run = longest_run(rows, separator);
        if run.score > best.score {
            (best, best_separator) = (run, separator);
        }
    }
    (best_separator, best.start)
}

/// A run of rows with as many cells each.
struct Run {
    /// Sum of the shares of numbers in its rows [1/1000].
    score: usize,
    /// Index of its first row; the number of rows if there is no run.
    start: usize,
}

/// Returns the longest run of rows with as many cells each.
fn longest_run(rows: &Lines<'_>, separator: Separator) -> Run {
    let mut best = Run {
        score: 0,
        start: rows.len(),
    };
    let (mut score, mut start, mut width) = (0, 0, 0);
    for (index, (_, line)) in rows.iter().enumerate() {
        let Some(row) = count_cells(line, separator) else {
            width = 0;
            continue;
        };
        if row.cells != width {
            (score, start, width) = (0, index, row.cells);
        }
        score += 1000 * row.numbers / row.cells;
        if score > best.score {
            best = Run { score, start };
        }
    }
    best
}

/// Counts of a row.
struct CellCounts {
    numbers: usize,
    cells: usize,
}

/// Counts the numbers and the cells of a row; `None` without a number, or if the row does not fit
/// the separator.
fn count_cells(line: &[u8], separator: Separator) -> Option<CellCounts> {
    let is_one_column = separator == Separator::None;
    let blank = separator == Separator::Blanks && line.contains(&b'\t');
    // Most rows hold no byte of most separators, and need not be split.
    if !(is_one_column || blank || line.contains(&separator.byte())) {
        return None;
    }
    let cells = cells(line, separator);
    if (cells.len() < 2) != is_one_column {
        return None;
    }
    let is_number = |cell: &&&[u8]| number::is_numeric(cell) || stamp::is_stamp(cell);
    let numbers = cells.iter().filter(is_number).count();
    (numbers > 0).then_some(CellCounts {
        numbers,
        cells: cells.len(),
    })
}
