//! The quick way through a table: rows of unquoted cells, numbers with decimal points, stamps
//! that rise. Most files are such, and large ones above all.
//!
//! Whatever is not as plain as that ends the quick way without a word; the careful reader in
//! `rows` then begins anew and says what there is to say. So both must agree wherever this
//! one answers, to the last bit.

use super::dialect::{self, Separator};
use super::layout::Layout;
use super::number::{self, Decimal, PrintedDigits};
use super::rows::{Fate, Rows};

/// Largest integer whose every smaller neighbour is a double too.
const EXACT: u64 = 1 << 53;

/// Powers of ten that are exact as doubles.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Reads all rows after the header, or `None` at the first that is not plain. `rows` is their
/// number, `time` the column of stamps with their number per second.
pub(super) fn read(
    text: &[u8],
    layout: &Layout,
    time: Option<(usize, f64)>,
    wanted: &[usize],
    rows: usize,
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
    let per_second = time.map_or(1.0, |(_, per_second)| per_second);
    let mut stamps_s: Vec<f64> = Vec::with_capacity(if time.is_some() { rows } else { 0 });
    let mut values: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(rows)).collect();
    let mut digits = PrintedDigits::new();
    let mut count = 0_usize;
    let mut skipped = 0;
    let mut next = 0;
    while let Some(rest) = text.get(next..).filter(|rest| !rest.is_empty()) {
        let length = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        next += length + 1;
        let line = &rest[..length];
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if !dialect::is_row(line) {
            continue;
        }
        if skipped < layout.header_rows {
            skipped += 1;
            continue;
        }
        count += 1;
        let mut at = 0;
        let mut column = 0;
        loop {
            match uses.get(column) {
                Some(Use::Stamp) => {
                    let number = number(line, at)?;
                    let stamp = number.value / per_second;
                    if stamps_s.last().is_some_and(|last| stamp <= *last) {
                        return None;
                    }
                    number.count_in(&mut digits, &line[at..number.end]);
                    stamps_s.push(stamp);
                    at = number.end;
                }
                Some(Use::Sample(slot)) => {
                    let number = number(line, at)?;
                    values[*slot].push(number.value);
                    at = number.end;
                }
                Some(Use::Pass) => {
                    at += memchr::memchr(separator, &line[at..]).unwrap_or(line.len() - at)
                }
                None => {
                    // Cells after the last column are empty or a fault.
                    at += line[at..].iter().take_while(|byte| **byte == b' ').count();
                }
            }
            column += 1;
            match line.get(at) {
                Some(byte) if *byte == separator => at += 1,
                Some(_) => return None,
                None => break,
            }
        }
        if column != cells {
            return None;
        }
    }
    Some(Rows {
        printed_digit_s: digits.last_digit() / per_second,
        stamps_s,
        values: values.into_iter().map(Fate::Kept).collect(),
        count,
        repeated: None,
        decimal_comma: false,
    })
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
    /// Index after its last byte, blanks behind it included.
    end: usize,
    /// Digits before and after the point.
    whole: i32,
    decimals: i32,
    /// Which digit is the first that is no zero, counted from 1; 0 if there is none.
    first: i32,
    /// Whether digits alone tell how it was printed.
    simple: bool,
}

impl Number {
    fn count_in(&self, digits: &mut PrintedDigits, cell: &[u8]) {
        if self.simple {
            digits.count_parts(self.whole, self.decimals, self.first, 0);
        } else {
            digits.count(cell);
        }
    }
}

/// Reads the number that begins at `start`, blanks around it passed over.
fn number(line: &[u8], start: usize) -> Option<Number> {
    let mut at = start;
    while let Some(b' ') = line.get(at) {
        at += 1;
    }
    let begin = at;
    let negative = match line.get(at) {
        Some(b'-') => {
            at += 1;
            true
        }
        Some(b'+') => {
            at += 1;
            false
        }
        _ => false,
    };
    let mut mantissa = 0_u64;
    let (mut whole, mut decimals, mut first) = (0_i32, 0_i32, 0_i32);
    let from = at;
    while let Some(digit) = line
        .get(at)
        .map(|byte| byte.wrapping_sub(b'0'))
        .filter(|digit| *digit < 10)
    {
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
        if first == 0 && digit != 0 {
            first = i32::try_from(at - from).ok()?;
        }
    }
    whole += i32::try_from(at - from).ok()?;
    if line.get(at) == Some(&b'.') {
        at += 1;
        let from = at;
        while let Some(digit) = line
            .get(at)
            .map(|byte| byte.wrapping_sub(b'0'))
            .filter(|digit| *digit < 10)
        {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            at += 1;
            if first == 0 && digit != 0 {
                first = whole + i32::try_from(at - from).ok()?;
            }
        }
        decimals = i32::try_from(at - from).ok()?;
    }
    if whole + decimals == 0 {
        return None;
    }
    let mut simple = true;
    let mut exponent = -decimals;
    if let Some(b'e' | b'E') = line.get(at) {
        simple = false;
        at += 1;
        let minus = match line.get(at) {
            Some(b'-') => {
                at += 1;
                true
            }
            Some(b'+') => {
                at += 1;
                false
            }
            _ => false,
        };
        let from = at;
        let mut power = 0_i32;
        while let Some(digit) = line
            .get(at)
            .map(|byte| byte.wrapping_sub(b'0'))
            .filter(|digit| *digit < 10)
        {
            power = power * 10 + i32::from(digit);
            at += 1;
            if at - from > 4 {
                return None;
            }
        }
        if at == from {
            return None;
        }
        exponent += if minus { -power } else { power };
    }
    // Up to nineteen digits the sum above cannot have wrapped round.
    let digits = whole + decimals;
    let scale = TENS.get(usize::try_from(exponent.unsigned_abs()).ok()?);
    let value = match scale {
        Some(scale) if digits <= 19 && mantissa <= EXACT => {
            // Both numbers are exact, so that the one rounding of the operation is the right one.
            #[expect(clippy::cast_precision_loss, reason = "at most 2^53")]
            let mantissa = mantissa as f64;
            let size = if exponent < 0 {
                mantissa / scale
            } else {
                mantissa * scale
            };
            if negative { -size } else { size }
        }
        _ => number::parse(&line[begin..at], &mut Decimal::PointOnly).ok()?,
    };
    while let Some(b' ') = line.get(at) {
        at += 1;
    }
    Some(Number {
        value,
        end: at,
        whole,
        decimals,
        first,
        simple,
    })
}
