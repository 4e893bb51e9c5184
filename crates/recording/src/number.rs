//! Numbers in cells: decimal point or comma, and the digits they were printed with.

use latchgate_kernel::units::DecimalMark;
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

/// Reason why a cell holds no usable number.
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

/// Longest number with a decimal comma [bytes]; 17 digits determine an `f64`.
const LONGEST: usize = 64;

/// Reads a cell, and sets the decimal mark by the first number that has one.
pub(super) fn parse(cell: &[u8], decimal: &mut Decimal) -> Result<f64, NumberFault> {
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
            let mut copy = cell.to_vec();
            copy[index] = b'.';
            plain(&copy)?
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

/// Reads a number whose decimal mark is stated, so that the other can only separate thousands.
fn stated(cell: &[u8], mark: DecimalMark) -> Result<f64, NumberFault> {
    let (mark, group_mark) = match mark {
        DecimalMark::Point => (b'.', b','),
        DecimalMark::Comma => (b',', b'.'),
    };
    let integer_part = cell.split(|byte| *byte == mark).next().unwrap_or_default();
    let mut groups = integer_part.split(|byte| *byte == group_mark);
    let whole = groups.next().unwrap_or_default();
    let first = whole.strip_prefix(b"-").or(whole.strip_prefix(b"+"));
    let first = first.unwrap_or(whole);
    let three = |group: &[u8]| group.len() == 3 && group.iter().all(u8::is_ascii_digit);
    // No group of thousands begins with zero: `0,123` is no number of thousands.
    let is_group = (1..=3).contains(&first.len()) && !first.starts_with(b"0");
    if integer_part.contains(&group_mark) && !(is_group && groups.all(three)) {
        return Err(NumberFault::OtherMark);
    }
    let digits = cell.iter().filter(|byte| **byte != group_mark);
    let point = |byte: &u8| if *byte == mark { b'.' } else { *byte };
    let digits: Vec<u8> = digits.map(point).collect();
    if cell[integer_part.len()..].contains(&group_mark) || digits.len() > LONGEST {
        return Err(NumberFault::OtherMark);
    }
    plain(&digits)
}

/// Returns a cell without the blanks around it, non-breaking ones included, and with a plain hyphen for a
/// typographic minus.
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
        Some(digits) => Cow::Owned(format!("-{digits}").into_bytes()),
        None => Cow::Borrowed(text.as_bytes()),
    }
}

fn plain(cell: &[u8]) -> Result<f64, NumberFault> {
    let text = std::str::from_utf8(cell).ok();
    match text.and_then(|text| text.parse::<f64>().ok()) {
        None => Err(NumberFault::Text),
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(NumberFault::NonFinite),
    }
}

/// True if a cell is meant as a number, even a bad one.
pub(super) fn is_numeric(cell: &[u8]) -> bool {
    // Digits and a point need no parser.
    let digits = cell.strip_prefix(b"-").unwrap_or(cell);
    let points = digits.iter().filter(|byte| **byte == b'.').count();
    let bare = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
    if digits.iter().all(bare) && points <= 1 && digits.len() > points {
        return true;
    }
    matches!(
        parse(cell, &mut Decimal::Unknown),
        Ok(_) | Err(NumberFault::NonFinite | NumberFault::OtherMark)
    )
}

/// Meaning of the marks in the numbers of a column: `6,158` is a little more than six, or six thousand,
/// and only its neighbours decide.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Marks {
    /// True if some number has a mark that separates no thousands, such as `0,5` or `12.25`.
    pub(super) decimal: bool,
    /// True if some number has a mark that may separate thousands.
    pub(super) doubtful: bool,
    /// True if some number is whole and has no mark.
    pub(super) whole: bool,
}

impl Marks {
    /// Reads a cell that [`parse`] accepted; true if its mark is the first doubtful one.
    pub(super) fn look(&mut self, cell: &[u8]) -> bool {
        if self.decimal {
            return false;
        }
        let cell = &*bare(cell);
        let digits = match cell {
            [b'-' | b'+', digits @ ..] => digits,
            _ => cell,
        };
        let Some(mark) = digits.iter().position(|byte| matches!(byte, b',' | b'.')) else {
            self.whole |= digits.iter().all(u8::is_ascii_digit);
            return false;
        };
        let (before, after) = (&digits[..mark], &digits[mark + 1..]);
        // The first group of thousands never begins with zero.
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

    /// True if the marks may separate thousands: all of them could, and there are whole numbers without a
    /// mark.
    pub(super) fn may_be_thousands(self) -> bool {
        !self.decimal && self.doubtful && self.whole
    }
}

/// Powers of ten of first digits that are distinguished.
const DECADES: Range<i32> = -24..24;

/// The digits that a column of stamps was printed with.
///
/// A fixed number of decimals is one power of ten throughout. Where a number of significant
/// digits is printed, the last one depends on the size of the number, and trailing zeros may
/// be omitted; so each decade keeps its finest digit, and the coarsest decade with enough
/// stamps to trust counts.
pub(super) struct PrintedDigits {
    decades: [(i32, u32); 48],
}

impl Default for PrintedDigits {
    fn default() -> Self {
        Self::new()
    }
}

impl PrintedDigits {
    /// Fewest stamps of a decade that is trusted.
    const ENOUGH: u32 = 10;

    pub(super) fn new() -> Self {
        Self {
            decades: [(i32::MAX, 0); 48],
        }
    }

    /// Counts the digits of a cell that [`parse`] accepted.
    pub(super) fn count(&mut self, cell: &[u8]) {
        let mut parts = cell.splitn(2, |byte| matches!(byte, b'e' | b'E'));
        let digits = parts.next().unwrap_or_default();
        let exponent = parts.next().and_then(|text| std::str::from_utf8(text).ok());
        let exponent = exponent
            .and_then(|text| text.trim().parse().ok())
            .unwrap_or(0_i32);
        let exponent = exponent.clamp(-400, 400);
        let mark = digits.iter().position(|byte| matches!(byte, b'.' | b','));
        let count = |part: &[u8]| part.iter().filter(|byte| byte.is_ascii_digit()).count() as i32;
        let integer_digits = count(&digits[..mark.unwrap_or(digits.len())]);
        // Zero does not show the digits of other numbers.
        let Some(first) = digits.iter().position(|byte| matches!(byte, b'1'..=b'9')) else {
            return;
        };
        let before = count(&digits[..first]);
        let decade = (integer_digits - before - 1 + exponent).clamp(DECADES.start, DECADES.end - 1);
        let slot = &mut self.decades[(decade - DECADES.start) as usize];
        slot.0 = slot.0.min(exponent - (count(digits) - integer_digits));
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
        let digits_of = |least_count: u32| {
            let decades = self.decades.iter();
            let trusted = decades.filter(move |(_, count)| *count >= least_count);
            trusted.map(|(digit, _)| *digit)
        };
        let digit = digits_of(Self::ENOUGH).max().or_else(|| digits_of(1).min());
        let digit = digit.and_then(|digit| format!("1e{digit}").parse().ok());
        digit.unwrap_or(0.0)
    }
}
