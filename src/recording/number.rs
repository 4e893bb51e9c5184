//! Numbers in cells: decimal point or comma, and the digits they were printed with.

use crate::units::DecimalMark;
use std::borrow::Cow;
use std::ops::Range;

/// The decimal mark of a table, as far as it is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Decimal {
    /// No number had one yet.
    Unknown,
    /// A point.
    Point,
    /// A comma.
    Comma,
    /// A point; a comma inside a number could mean anything, since it separates cells.
    PointOnly,
    /// The one that a person states; the other may separate thousands.
    Stated(DecimalMark),
}

/// Why a cell holds no usable number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberFault {
    /// Nothing in it.
    Empty,
    /// No number.
    Text,
    /// A number that is infinite, too large, or none (`nan`).
    NonFinite,
    /// A number with the other decimal mark than the numbers before, or with a comma where
    /// commas separate cells.
    OtherMark,
}

/// Longest number with a decimal comma [bytes]; 17 digits carry all of an `f64`.
const LONGEST: usize = 64;

/// Reads a cell, and learns the decimal mark from the first number that has one.
pub(super) fn parse(cell: &[u8], decimal: &mut Decimal) -> Result<f64, NumberFault> {
    if let Some((value, has_point)) = exact(cell)
        && !(has_point
            && matches!(
                decimal,
                Decimal::Comma | Decimal::Stated(DecimalMark::Comma)
            ))
    {
        if has_point && *decimal == Decimal::Unknown {
            *decimal = Decimal::Point;
        }
        return Ok(value);
    }
    let cell = &*bare(cell);
    if cell.is_empty() {
        return Err(NumberFault::Empty);
    }
    if let Decimal::Stated(mark) = decimal {
        return stated(cell, *mark);
    }
    let mut comma = None;
    let mut point = false;
    for (index, byte) in cell.iter().enumerate() {
        match byte {
            b',' if comma.is_none() => comma = Some(index),
            b',' => return Err(NumberFault::Text),
            b'.' => point = true,
            _ => {}
        }
    }
    let value = match comma {
        None => plain(cell)?,
        Some(index) => {
            // "1,234.5" has a thousands separator, "1," is a cell and a half.
            let followed = cell.get(index + 1).is_some_and(u8::is_ascii_digit);
            if point || !followed || cell.len() > LONGEST {
                return Err(NumberFault::Text);
            }
            let mut buffer = [0_u8; LONGEST];
            let copy = &mut buffer[..cell.len()];
            copy.copy_from_slice(cell);
            copy[index] = b'.';
            plain(copy)?
        }
    };
    match (*decimal, comma.is_some(), point) {
        (Decimal::Unknown, true, _) => *decimal = Decimal::Comma,
        (Decimal::Unknown, _, true) => *decimal = Decimal::Point,
        (Decimal::Point | Decimal::PointOnly, true, _) | (Decimal::Comma, _, true) => {
            return Err(NumberFault::OtherMark);
        }
        _ => {}
    }
    Ok(value)
}

/// Reads a number whose decimal mark is known, so that the other can only separate thousands.
fn stated(cell: &[u8], mark: DecimalMark) -> Result<f64, NumberFault> {
    let (mark, other) = match mark {
        DecimalMark::Point => (b'.', b','),
        DecimalMark::Comma => (b',', b'.'),
    };
    let whole = cell.split(|byte| *byte == mark).next().unwrap_or_default();
    let mut groups = whole.split(|byte| *byte == other);
    let first = groups.next().unwrap_or_default();
    let first = first.strip_prefix(b"-").unwrap_or(first);
    let three = |group: &[u8]| group.len() == 3 && group.iter().all(u8::is_ascii_digit);
    if whole.contains(&other) && !((1..=3).contains(&first.len()) && groups.all(three)) {
        return Err(NumberFault::OtherMark);
    }
    let (before, after) = cell.split_at(whole.len());
    let mut plain_cell: Vec<u8> = before
        .iter()
        .copied()
        .filter(|byte| *byte != other)
        .collect();
    plain_cell.extend(
        after
            .iter()
            .map(|byte| if *byte == mark { b'.' } else { *byte }),
    );
    if after.contains(&other) || plain_cell.len() > LONGEST {
        return Err(NumberFault::OtherMark);
    }
    plain(&plain_cell)
}

/// Powers of ten that are exact as doubles.
const TENS: [f64; 16] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
];

/// Reads what most numbers of a table are: a sign, and up to 15 digits with a point among them.
/// Their digits as an integer and the power of ten are exact as doubles, so that the one rounding
/// of the division is the right one. Returns whether there is a point, too.
#[inline]
fn exact(cell: &[u8]) -> Option<(f64, bool)> {
    let (negative, digits) = match cell {
        [b'-', digits @ ..] => (true, digits),
        digits => (false, digits),
    };
    // A point is one byte more.
    if digits.len() > TENS.len() || !digits.first()?.is_ascii_digit() {
        return None;
    }
    let (mut mantissa, mut point) = (0_u64, None);
    for (index, byte) in digits.iter().enumerate() {
        match byte {
            b'0'..=b'9' => mantissa = 10 * mantissa + u64::from(byte - b'0'),
            b'.' if point.is_none() => point = Some(index),
            _ => return None,
        }
    }
    if point.is_none() && digits.len() == TENS.len() {
        // Sixteen digits may be more than a double holds.
        return None;
    }
    let decimals = point.map_or(0, |index| digits.len() - index - 1);
    let size = mantissa as f64 / TENS[decimals];
    Some((if negative { -size } else { size }, point.is_some()))
}

/// Returns a cell without the blanks around it, those that do not break a line among them, and
/// with a plain hyphen for the minus of typesetters.
fn bare(cell: &[u8]) -> Cow<'_, [u8]> {
    const BLANKS: [char; 7] = [
        '\u{a0}', '\u{2009}', '\u{200a}', '\u{200b}', '\u{202f}', '\u{2060}', '\u{feff}',
    ];
    let cell = cell.trim_ascii();
    if cell.is_ascii() {
        return Cow::Borrowed(cell);
    }
    let Ok(text) = std::str::from_utf8(cell) else {
        return Cow::Borrowed(cell);
    };
    let text = text.trim_matches(|c: char| c == ' ' || c == '\t' || BLANKS.contains(&c));
    match text.strip_prefix('\u{2212}') {
        Some(rest) => Cow::Owned(format!("-{rest}").into_bytes()),
        None => Cow::Borrowed(text.as_bytes()),
    }
}

fn plain(cell: &[u8]) -> Result<f64, NumberFault> {
    let value: f64 = std::str::from_utf8(cell)
        .ok()
        .and_then(|text| text.parse().ok())
        .ok_or(NumberFault::Text)?;
    if value.is_finite() {
        Ok(value)
    } else {
        Err(NumberFault::NonFinite)
    }
}

/// Tells whether somebody meant a number here, be it a bad one.
pub(super) fn is_numeric(cell: &[u8]) -> bool {
    matches!(
        parse(cell, &mut Decimal::Unknown),
        Ok(_) | Err(NumberFault::NonFinite | NumberFault::OtherMark)
    )
}

/// What the marks in the numbers of a column may be: `6,158` is a little more than six, or six
/// thousand, and only its neighbours tell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Marks {
    /// Whether a number was there whose mark separates no thousands, such as `0,5` or `12.25`.
    pub(super) decimal: bool,
    /// Whether one was there whose mark may separate thousands.
    pub(super) doubtful: bool,
    /// Whether one was there that is whole and has no mark.
    pub(super) whole: bool,
}

impl Marks {
    /// Takes in a cell that [`parse`] accepted; returns whether its mark is the first doubtful one.
    pub(super) fn look(&mut self, cell: &[u8]) -> bool {
        if self.decimal {
            return false;
        }
        let cell = &*bare(cell);
        let digits = match cell {
            [b'-' | b'+', rest @ ..] => rest,
            _ => cell,
        };
        let Some(mark) = digits.iter().position(|byte| matches!(byte, b',' | b'.')) else {
            self.whole |= digits.iter().all(u8::is_ascii_digit);
            return false;
        };
        let (before, after) = (&digits[..mark], &digits[mark + 1..]);
        // Nobody writes a zero before the first group of thousands.
        let thousands = (1..=3).contains(&before.len())
            && before[0] != b'0'
            && after.len() == 3
            && before.iter().chain(after).all(u8::is_ascii_digit);
        if thousands {
            let first = !self.doubtful;
            self.doubtful = true;
            return first;
        }
        self.decimal = true;
        false
    }

    /// Tells whether the marks may separate thousands: all of them could, and whole numbers
    /// without a mark stand beside them.
    pub(super) fn may_be_thousands(self) -> bool {
        !self.decimal && self.doubtful && self.whole
    }
}

/// Powers of ten of first digits that are told apart.
const DECADES: Range<i32> = -24..24;

/// The digits that a column of stamps was printed with.
///
/// A fixed number of decimals is one power of ten throughout. Where a number of significant
/// digits is printed, the last one depends on the size of the number, and trailing zeros may
/// be left out; so each decade keeps its finest digit, and the coarsest decade that holds
/// enough stamps to trust counts.
pub(super) struct PrintedDigits {
    decades: [(i32, u32); 48],
}

impl PrintedDigits {
    /// Stamps below which a decade is not trusted.
    const ENOUGH: u32 = 10;

    pub(super) fn new() -> Self {
        Self {
            decades: [(i32::MAX, 0); 48],
        }
    }

    /// Takes in a cell that [`parse`] accepted.
    pub(super) fn count(&mut self, cell: &[u8]) {
        let mut decimals = 0;
        let mut whole_digits = 0;
        let mut seen_mark = false;
        let mut first = None;
        let mut exponent = 0_i32;
        for (index, byte) in cell.iter().enumerate() {
            match byte {
                b'0'..=b'9' => {
                    if seen_mark {
                        decimals += 1;
                    } else {
                        whole_digits += 1;
                    }
                    if first.is_none() && *byte != b'0' {
                        first = Some(whole_digits + decimals);
                    }
                }
                b'.' | b',' => seen_mark = true,
                b'e' | b'E' => {
                    exponent = std::str::from_utf8(&cell[index + 1..])
                        .ok()
                        .and_then(|text| text.trim().parse().ok())
                        .unwrap_or(0)
                        .clamp(-400, 400);
                    break;
                }
                _ => {}
            }
        }
        self.count_parts(whole_digits, decimals, first.unwrap_or(0), exponent);
    }

    /// Takes in a number of so many digits before and after the mark; `first` is the first of
    /// them that is no zero, counted from 1, and 0 if there is none.
    pub(super) fn count_parts(
        &mut self,
        whole_digits: i32,
        decimals: i32,
        first: i32,
        exponent: i32,
    ) {
        // Zero says nothing about the digits of other numbers.
        if first == 0 {
            return;
        }
        let decade = (whole_digits - first + exponent).clamp(DECADES.start, DECADES.end - 1);
        let slot = &mut self.decades[(decade - DECADES.start) as usize];
        slot.0 = slot.0.min(exponent - decimals);
        slot.1 = slot.1.saturating_add(1);
    }

    /// Returns the size of the last digit of a cell that [`parse`] accepted; 0 for zero.
    pub(super) fn of_cell(cell: &[u8]) -> f64 {
        let mut digits = Self::new();
        digits.count(cell);
        digits.last_digit()
    }

    /// Returns the size of the last printed digit, in the column's unit; 0 if unknown.
    pub(super) fn last_digit(&self) -> f64 {
        let trusted = self
            .decades
            .iter()
            .filter(|(_, count)| *count >= Self::ENOUGH)
            .map(|(digit, _)| *digit)
            .max();
        let seen = self
            .decades
            .iter()
            .filter(|(_, count)| *count > 0)
            .map(|(digit, _)| *digit)
            .min();
        trusted
            .or(seen)
            .and_then(|digit| format!("1e{digit}").parse().ok())
            .unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{Decimal, Marks, exact, parse};

    /// Numbers of every length and with the point at every place, against the standard library.
    #[test]
    fn verif_short_numbers_are_read_to_the_last_bit() {
        let digits = "9007199254740993001234567890";
        for from in 0..12 {
            for length in 1..=17 {
                for point in 0..=length {
                    let (whole, rest) = digits[from..from + length].split_at(point);
                    for text in [format!("{whole}.{rest}"), format!("-{whole}.{rest}")] {
                        let expected: f64 = text.parse().expect("a number");
                        let found = parse(text.as_bytes(), &mut Decimal::Unknown);
                        assert_eq!(found.map(f64::to_bits), Ok(expected.to_bits()), "{text}");
                    }
                    let text = format!("{whole}{rest}");
                    let expected: f64 = text.parse().expect("a number");
                    if let Some((value, point)) = exact(text.as_bytes()) {
                        assert_eq!(
                            (value.to_bits(), point),
                            (expected.to_bits(), false),
                            "{text}"
                        );
                    }
                }
            }
        }
        for text in [
            "",
            "-",
            ".5",
            "+1",
            "1e3",
            "1,5",
            "1.2.3",
            " 1",
            "9007199254740993",
        ] {
            assert!(exact(text.as_bytes()).is_none(), "{text}");
        }
        // A comma of the rows before is held against a point.
        assert!(parse(b"1.5", &mut Decimal::Comma).is_err());
    }

    #[track_caller]
    fn check(cells: &[&str], decimal: bool, may_be_thousands: bool) {
        let mut marks = Marks::default();
        for cell in cells {
            marks.look(cell.as_bytes());
        }
        assert_eq!(marks.decimal, decimal, "{cells:?}");
        assert_eq!(marks.may_be_thousands(), may_be_thousands, "{cells:?}");
    }

    #[test]
    fn verif_marks_that_may_separate_thousands_are_told_from_decimal_ones() {
        check(&["-1", "2", "6,158", "12,322"], false, true);
        check(&["-1", " -6.158 "], false, true);
        check(&["+588,273", "0"], false, true);
        // Three decimals throughout, and nothing beside them.
        check(&["6.158", "12.322"], false, false);
        check(&["1", "2"], false, false);
        for proof in [
            "0,158", "-0.158", ".158", "1234.158", "6.1580", "6,1", "6.158e0", "6.",
        ] {
            check(&["1", "6.158", proof], true, false);
            check(&[proof, "1", "6.158"], true, false);
        }
    }
}
