//! Numbers for people: significant digits, true minus signs, powers of ten.
//!
//! All digits stand in `verdict.json`; what is rounded here is rounded once, from the value
//! itself.

pub use latchgate_kernel::units::plain;

/// The minus sign, U+2212.
const MINUS: char = '\u{2212}';

/// Stands where there is no number.
pub const ABSENT: &str = "\u{2013}";

/// Returns `value` with `digits` significant digits, for example `1.0636`, `−0.46000` or
/// `3.1000 × 10⁻⁷`; an en dash if it is not finite.
pub fn significant(value: f64, digits: usize) -> String {
    typeset(&plain(value, digits))
}

/// As [`significant`] without zeros at the end of its decimals: `6.4`, `2083.3`, `1000`.
pub fn trimmed(value: f64, digits: usize) -> String {
    let ascii = plain(value, digits);
    let (mantissa, exponent) = match ascii.split_once('e') {
        Some((mantissa, exponent)) => (mantissa, format!("e{exponent}")),
        None => (&*ascii, String::new()),
    };
    let mantissa = if mantissa.contains('.') {
        mantissa.trim_end_matches('0').trim_end_matches('.')
    } else {
        mantissa
    };
    typeset(&format!("{mantissa}{exponent}"))
}

/// Returns `value` with all its digits and no more, for example `0.1` or `8.888 × 10⁻⁴`; an en
/// dash if it is not finite.
pub fn exact(value: f64) -> String {
    if !value.is_finite() {
        return ABSENT.into();
    }
    let magnitude = value.abs();
    if magnitude == 0.0 {
        return "0".into();
    }
    if (1e-3..1e6).contains(&magnitude) {
        typeset(&format!("{value}"))
    } else {
        typeset(&format!("{value:e}"))
    }
}

/// Returns a count with its thousands set apart by narrow no-break spaces.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut out = String::with_capacity(digits.len() + digits.len());
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push('\u{202F}');
        }
        out.push(digit);
    }
    out
}

/// Returns an instant or duration given in seconds as milliseconds with `digits` significant
/// digits, without the unit.
pub fn milliseconds(seconds: f64, digits: usize) -> String {
    significant(seconds * 1e3, digits)
}

/// Turns `-1.5e-7` into `−1.5 × 10⁻⁷`.
fn typeset(ascii: &str) -> String {
    if ascii == "-" {
        return ABSENT.into();
    }
    let (mantissa, exponent) = match ascii.split_once('e') {
        Some((mantissa, exponent)) => (mantissa, Some(exponent)),
        None => (ascii, None),
    };
    let mut out: String = mantissa
        .chars()
        .map(|c| if c == '-' { MINUS } else { c })
        .collect();
    if let Some(exponent) = exponent {
        out.push_str("\u{00A0}×\u{00A0}10");
        out.extend(exponent.chars().map(superscript));
    }
    out
}

/// Returns the superscript form of a digit or minus sign.
pub fn superscript(c: char) -> char {
    match c {
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        '-' => '⁻',
        other => other,
    }
}
