//! The quick way through a table: rows of unquoted cells, numbers with decimal points, stamps
//! that rise. Most files are such, and large ones above all.
//!
//! Whatever is not as plain as that ends the quick way without a word; the careful reader in
//! `rows` then begins anew and says what there is to say. So both must agree wherever this
//! one answers, to the last bit.

use super::dialect::{self, Separator};
use super::layout::Layout;
use super::number::{self, Decimal, Marks, PrintedDigits};
use super::rows::{Fate, Rows};

/// Largest integer whose every smaller neighbour is a double too.
const EXACT: u64 = 1 << 53;

/// Bytes below which one thread reads all rows.
const IN_ONE: usize = 4 << 20;

/// Powers of ten that are exact as doubles.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Powers of ten up to eight digits.
const INTEGER_TENS: [u64; 9] = [
    1,
    10,
    100,
    1_000,
    10_000,
    100_000,
    1_000_000,
    10_000_000,
    100_000_000,
];

/// Reads all rows after the header, or `None` at the first that is not plain. `rows` is their
/// number, `time` the column of stamps with their number per second.
pub(super) fn read(
    text: &[u8],
    layout: &Layout,
    time: Option<(usize, f64)>,
    wanted: &[usize],
    rows: usize,
    one_thread: bool,
) -> Option<Rows> {
    let in_one = if one_thread { usize::MAX } else { IN_ONE };
    read_in(text, layout, time, wanted, rows, in_one)
}

/// As [`read`], with the bytes from which on two threads are worth it.
fn read_in(
    text: &[u8],
    layout: &Layout,
    time: Option<(usize, f64)>,
    wanted: &[usize],
    rows: usize,
    in_one: usize,
) -> Option<Rows> {
    if layout.quoted || layout.separator == Separator::Blanks {
        return None;
    }
    let (names, cells) = layout.widths();
    let separator = layout.separator.byte();
    // What a cell of each column is for: the stamp, a sample, or nothing.
    let mut uses: Vec<Use> = (0..names).map(|_| Use::Pass).collect();
    for (slot, column) in wanted.iter().enumerate() {
        match uses.get_mut(*column) {
            Some(place @ Use::Pass) => *place = Use::Sample(slot),
            _ => return None,
        }
    }
    if let Some((column, _)) = time {
        match uses.get_mut(column) {
            Some(place @ Use::Pass) => *place = Use::Stamp,
            _ => return None,
        }
    }
    let shape = Shape {
        uses,
        cells,
        separator,
        per_second: time.map_or(1.0, |(_, per_second)| per_second),
        stamped: time.is_some(),
        slots: wanted.len(),
    };
    let body = after_header(text, layout.header_rows);
    let halves = if body.len() < in_one {
        (body, &[][..])
    } else {
        // Two threads read a half each; where the first one ends changes no number.
        let middle = body.len() / 2;
        let line = memchr::memchr(b'\n', &body[middle..]).map_or(body.len(), |at| middle + at + 1);
        body.split_at(line)
    };
    let mut part = if halves.1.is_empty() {
        Part::read(halves.0, &shape, rows)?
    } else {
        let (first, second) = std::thread::scope(|scope| {
            let helper = std::thread::Builder::new()
                .name("rows".into())
                .spawn_scoped(scope, || {
                    let lines = memchr::memchr_iter(b'\n', halves.1).count() + 1;
                    Part::read(halves.1, &shape, lines)
                });
            // The whole of the table will go here, so that only the second half moves.
            let first = Part::read(halves.0, &shape, rows);
            let second = match helper {
                Ok(helper) => helper
                    .join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
                // A system that gives no thread.
                Err(_) => Part::read(halves.1, &shape, rows),
            };
            (first, second)
        });
        first?.followed_by(second?)?
    };
    // What may be thousands is for the careful reader to judge.
    if !part.stamp_marks.decimal
        && (part.stamp_marks.may_be_thousands()
            || part.marks.iter().any(|marks| marks.may_be_thousands()))
    {
        return None;
    }
    Some(Rows {
        printed_digit_s: part.digits.last_digit() / shape.per_second,
        stamps_s: std::mem::take(&mut part.stamps_s),
        values: part.values.into_iter().map(Fate::Kept).collect(),
        count: part.count,
        repeated: None,
        stamps_repeat: false,
        decimal_comma: false,
        counts: Vec::new(),
    })
}

/// Returns what follows the header.
fn after_header(mut text: &[u8], header_rows: usize) -> &[u8] {
    let mut skipped = 0;
    while skipped < header_rows && !text.is_empty() {
        skipped += usize::from(dialect::is_row(text));
        let end = memchr::memchr(b'\n', text).map_or(text.len(), |end| end + 1);
        text = &text[end..];
    }
    text
}

/// What rows look like and what is wanted of them.
struct Shape {
    /// What the cells of each column are for.
    uses: Vec<Use>,
    /// Cells of a row, empty ones at its end included.
    cells: usize,
    separator: u8,
    /// Units of the stamps per second.
    per_second: f64,
    stamped: bool,
    /// Wanted columns.
    slots: usize,
}

/// Rows that stand together, read.
struct Part {
    stamps_s: Vec<f64>,
    values: Vec<Vec<f64>>,
    digits: PrintedDigits,
    stamp_marks: Marks,
    /// Of each wanted column.
    marks: Vec<Marks>,
    count: usize,
}

impl Part {
    /// Reads whole lines after the header; `room` is made for so many rows.
    fn read(text: &[u8], shape: &Shape, room: usize) -> Option<Self> {
        let mut part = Self {
            stamps_s: Vec::with_capacity(if shape.stamped { room } else { 0 }),
            values: (0..shape.slots).map(|_| Vec::with_capacity(room)).collect(),
            digits: PrintedDigits::new(),
            stamp_marks: Marks::default(),
            marks: vec![Marks::default(); shape.slots],
            count: 0,
        };
        // A number just below any stamp.
        let mut last = f64::NEG_INFINITY;
        let mut rest = text;
        while let Some(first) = rest.first() {
            if matches!(first, b'#' | b'\r' | b'\n') {
                let end = memchr::memchr(b'\n', rest).map_or(rest.len(), |end| end + 1);
                rest = &rest[end..];
                continue;
            }
            part.count += 1;
            let mut column = 0;
            loop {
                match shape.uses.get(column) {
                    Some(Use::Stamp) => {
                        let number;
                        let cell = rest;
                        (number, rest) = self::number(rest)?;
                        let stamp = number.value / shape.per_second;
                        if stamp <= last {
                            return None;
                        }
                        last = stamp;
                        let cell = &cell[..cell.len() - rest.len()];
                        number.count_in(&mut part.digits, cell);
                        if !part.stamp_marks.decimal {
                            number.mark_in(&mut part.stamp_marks, cell);
                        }
                        part.stamps_s.push(stamp);
                    }
                    Some(Use::Sample(slot)) => {
                        let number;
                        let cell = rest;
                        (number, rest) = self::number(rest)?;
                        part.values[*slot].push(number.value);
                        let marks = &mut part.marks[*slot];
                        if !marks.decimal {
                            number.mark_in(marks, &cell[..cell.len() - rest.len()]);
                        }
                    }
                    Some(Use::Pass) => {
                        let end =
                            memchr::memchr2(shape.separator, b'\n', rest).unwrap_or(rest.len());
                        rest = &rest[end..];
                    }
                    // Cells after the last column are empty or a fault.
                    None => rest = without_blanks(rest),
                }
                column += 1;
                match rest {
                    [byte, tail @ ..] if *byte == shape.separator => rest = tail,
                    [b'\n', tail @ ..] | [b'\r', b'\n', tail @ ..] => {
                        rest = tail;
                        break;
                    }
                    [] => break,
                    _ => return None,
                }
            }
            if column != shape.cells {
                return None;
            }
        }
        Some(part)
    }

    /// Joins the rows that follow; `None` if time does not go on.
    fn followed_by(mut self, next: Self) -> Option<Self> {
        if let (Some(last), Some(first)) = (self.stamps_s.last(), next.stamps_s.first())
            && first <= last
        {
            return None;
        }
        self.stamps_s.extend_from_slice(&next.stamps_s);
        for (values, more) in self.values.iter_mut().zip(&next.values) {
            values.extend_from_slice(more);
        }
        self.digits.join(&next.digits);
        self.stamp_marks.join(next.stamp_marks);
        for (marks, more) in self.marks.iter_mut().zip(&next.marks) {
            marks.join(*more);
        }
        self.count += next.count;
        Some(self)
    }
}

/// What a column's cells are for.
#[derive(Clone, Copy)]
enum Use {
    Stamp,
    Sample(usize),
    Pass,
}

/// A number, and what it looked like.
struct Number {
    value: f64,
    /// The digits as one integer, where they are few enough to be one.
    mantissa: u64,
    /// Digits before and after the point.
    whole: usize,
    decimals: usize,
    /// Whether those digits alone tell how it was printed.
    simple: bool,
}

impl Number {
    fn count_in(&self, digits: &mut PrintedDigits, cell: &[u8]) {
        let parts = i32::try_from(self.whole)
            .ok()
            .zip(i32::try_from(self.decimals).ok());
        match parts {
            Some((whole, decimals)) if self.simple => {
                let first = match self.mantissa.checked_ilog10() {
                    // As many digits as the integer has are at the end.
                    Some(power) => whole + decimals - i32::try_from(power).unwrap_or(0),
                    None => 0,
                };
                digits.count_parts(whole, decimals, first, 0);
            }
            _ => digits.count(cell),
        }
    }

    fn mark_in(&self, marks: &mut Marks, cell: &[u8]) {
        if self.simple && self.decimals == 0 {
            // A point with nothing behind it counts as none, which only adds to the doubt.
            marks.whole = true;
        } else {
            marks.look(cell);
        }
    }
}

/// Most digits whose integer cannot have wrapped round.
const MOST_DIGITS: usize = 19;

fn without_blanks(mut rest: &[u8]) -> &[u8] {
    while let [b' ', tail @ ..] = rest {
        rest = tail;
    }
    rest
}

/// Takes the digits at the start of `rest` into `mantissa`; returns what follows them. Eight
/// bytes are looked at together, since how many of them are digits changes from number to number
/// and no processor foresees it.
#[inline]
fn take_digits<'a>(mut rest: &'a [u8], mantissa: &mut u64) -> &'a [u8] {
    while let Some((eight, _)) = rest.split_first_chunk::<8>() {
        // A digit becomes its value, any other byte more than nine.
        let bytes = u64::from_le_bytes(*eight) ^ 0x3030_3030_3030_3030;
        // The lowest mark is right; a carry can only spoil those above it.
        let others = (bytes.wrapping_add(0x7676_7676_7676_7676) | bytes) & 0x8080_8080_8080_8080;
        let count = others.trailing_zeros() / 8;
        if count == 0 {
            return rest;
        }
        // Zeros before the first digit change nothing.
        let digits = bytes << (64 - 8 * count);
        let pairs = digits.wrapping_mul(10).wrapping_add(digits >> 8) & 0x00FF_00FF_00FF_00FF;
        let fours = pairs.wrapping_mul(100).wrapping_add(pairs >> 16) & 0x0000_FFFF_0000_FFFF;
        let value = fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xFFFF_FFFF;
        let scale = INTEGER_TENS[count as usize];
        *mantissa = mantissa.wrapping_mul(scale).wrapping_add(value);
        rest = &rest[count as usize..];
        if count < 8 {
            return rest;
        }
    }
    while let [byte, tail @ ..] = rest {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        rest = tail;
    }
    rest
}

/// Reads the number that `text` begins with, blanks around it passed over; returns it with what
/// follows.
#[inline]
fn number(text: &[u8]) -> Option<(Number, &[u8])> {
    let begin = without_blanks(text);
    let (negative, start) = match begin {
        [b'-', tail @ ..] => (true, tail),
        [b'+', tail @ ..] => (false, tail),
        _ => (false, begin),
    };
    let mut mantissa = 0_u64;
    let mut rest = take_digits(start, &mut mantissa);
    let whole = start.len() - rest.len();
    let mut decimals = 0;
    if let [b'.', tail @ ..] = rest {
        rest = take_digits(tail, &mut mantissa);
        decimals = tail.len() - rest.len();
    }
    let digits = whole + decimals;
    if digits == 0 {
        return None;
    }
    let mut exponent = -i64::try_from(decimals).ok()?;
    let mut simple = digits <= MOST_DIGITS;
    if let [b'e' | b'E', tail @ ..] = rest {
        simple = false;
        let (minus, tail) = match tail {
            [b'-', tail @ ..] => (true, tail),
            [b'+', tail @ ..] => (false, tail),
            _ => (false, tail),
        };
        let mut power = 0;
        rest = take_digits(tail, &mut power);
        if !(1..=4).contains(&(tail.len() - rest.len())) {
            return None;
        }
        let power = i64::try_from(power).ok()?;
        exponent += if minus { -power } else { power };
    }
    let scale = TENS.get(usize::try_from(exponent.unsigned_abs()).ok()?);
    let value = match scale {
        Some(scale) if digits <= MOST_DIGITS && mantissa <= EXACT => {
            // Both numbers are exact, so that the one rounding of the operation is the right one.
            let mantissa = mantissa as f64;
            let size = if exponent < 0 {
                mantissa / scale
            } else {
                mantissa * scale
            };
            if negative { -size } else { size }
        }
        _ => {
            let cell = &begin[..begin.len() - rest.len()];
            number::parse(cell, &mut Decimal::PointOnly).ok()?
        }
    };
    let number = Number {
        value,
        mantissa,
        whole,
        decimals,
        simple,
    };
    Some((number, without_blanks(rest)))
}

#[cfg(test)]
mod tests {
    use super::{Fate, Layout, Rows, read_in, take_digits};
    use crate::recording::ReadOptions;
    use crate::recording::csv::dialect::Separator;

    /// A table read by one thread or by two, cut where `in_one` says.
    fn read_with(text: &str, in_one: usize) -> Option<Rows> {
        let text = text.as_bytes();
        let options = ReadOptions::default();
        let layout = Layout::find(text, Separator::Comma, false, &options, &mut Vec::new()).ok()?;
        read_in(text, &layout, Some((0, 1e3)), &[1], 99, in_one)
    }

    /// Two threads read what one reads, wherever the table is cut and whatever stands there.
    #[track_caller]
    fn check_halves(text: &str, rows: Option<usize>) {
        let all = |rows: Option<Rows>| {
            rows.map(|rows| {
                let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let Fate::Kept(values) = &rows.values[0] else {
                    panic!("a column left out");
                };
                let digit = rows.printed_digit_s.to_bits();
                (bits(&rows.stamps_s), bits(values), digit, rows.count)
            })
        };
        let one = all(read_with(text, usize::MAX));
        assert_eq!(one.as_ref().map(|one| one.3), rows);
        assert_eq!(all(read_with(text, 0)), one, "{text}");
    }

    #[test]
    fn verif_two_threads_read_what_one_reads() {
        let head = "# made\nt_ms,ay_g\n";
        let rows: Vec<String> = (0..20)
            .map(|k| format!("{}.{k:02},{}\n", k / 3, 7 * k - 60))
            .collect();
        for count in 1..20 {
            check_halves(&format!("{head}{}", rows[..count].concat()), Some(count));
            // A comment moves the cut; a table may end without a line end.
            let between = format!("{head}{}# pause\n\n{}", rows[0], rows[1..=count].concat());
            check_halves(between.trim_end(), Some(count + 1));
        }
        let mut back = rows.clone();
        for cut in 1..19 {
            back.swap(cut, cut + 1);
            check_halves(&format!("{head}{}", back.concat()), None);
            back.swap(cut, cut + 1);
            let short = format!("{head}{}3\n{}", rows[..cut].concat(), rows[cut..].concat());
            check_halves(&short, None);
        }
    }

    /// Whole numbers in one half and marks that may separate thousands in the other are told by
    /// the careful reader; stamps or samples with decimals make them decimal ones.
    #[test]
    fn verif_marks_of_both_halves_are_judged_together() {
        for cut in 1..30 {
            let table = |stamp: fn(usize) -> String, last: &str| {
                let mut text = "t_us,ay_g\n".to_string();
                for k in 0..30 {
                    let value = if k < cut { "7" } else { "6.158" };
                    text += &format!("{},{value}\n", stamp(k));
                }
                text + &format!("{},{last}\n", stamp(30))
            };
            let whole: fn(usize) -> String = |k| (100 * k).to_string();
            let tenths: fn(usize) -> String = |k| format!("{k}.5");
            check_halves(&table(whole, "6.158"), None);
            check_halves(&table(whole, "0.158"), Some(31));
            check_halves(&table(tenths, "6.158"), Some(31));
        }
    }

    /// Digits of every length, with every byte behind them, against the plain sum.
    #[test]
    fn verif_digits_are_summed_eight_at_a_time() {
        let all = "0123456789098765432101234567890987654321";
        for from in 0..20 {
            for length in 0..=18 {
                let digits = &all[from..from + length];
                for other in 0..=u8::MAX {
                    if other.is_ascii_digit() {
                        continue;
                    }
                    let mut text = digits.as_bytes().to_vec();
                    text.push(other);
                    text.extend_from_slice(b"12\xFF,8765");
                    let mut sum = 0;
                    let rest = take_digits(&text, &mut sum);
                    assert_eq!(rest.len(), text.len() - length, "{digits} {other}");
                    let expected = digits.parse::<u64>().unwrap_or(0);
                    assert_eq!(sum, expected, "{digits} {other}");
                }
            }
        }
    }
}
