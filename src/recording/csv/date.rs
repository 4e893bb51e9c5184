//! Stamps that are dates: `2024-05-01T10:00:00.0001`, as ISO 8601 writes them, with a `T` or a
//! blank between date and time, and with a zone or without.

/// Nanoseconds in a second.
const NANO: i64 = 1_000_000_000;

/// Days from 0000-03-01 to 1970-01-01, which only shifts what is subtracted again.
const TO_EPOCH: i64 = 719_468;

/// Tells whether a cell is such a stamp.
pub(super) fn is_date(cell: &[u8]) -> bool {
    parse(cell).is_some()
}

/// Counts time from the first stamp, in whole nanoseconds, so that no digit is lost to the
/// years before it.
#[derive(Debug, Default)]
pub(super) struct DateClock {
    first: Option<i128>,
    decimals: usize,
}

impl DateClock {
    /// Returns the seconds since the first stamp; `None` for what is no date.
    pub(super) fn seconds(&mut self, cell: &[u8]) -> Option<f64> {
        let (stamp, decimals) = parse(cell)?;
        self.decimals = self.decimals.max(decimals);
        let since = stamp - *self.first.get_or_insert(stamp);
        let nanoseconds = since as f64;
        Some(nanoseconds / 1e9)
    }

    /// Returns the size of the last printed digit [s].
    pub(super) fn last_digit(&self) -> f64 {
        format!("1e-{}", self.decimals).parse().unwrap_or(0.0)
    }
}

/// Returns the nanoseconds of a stamp since 1970, that of its zone taken off, and the number of
/// its decimals.
fn parse(cell: &[u8]) -> Option<(i128, usize)> {
    let cell = cell.trim_ascii();
    let (date, rest) = cell.split_at_checked(10)?;
    let [year, month, day] = fields(date, b'-', [4, 2, 2])?;
    let time = rest.strip_prefix(b"T").or(rest.strip_prefix(b" "))?;
    let (clock, rest) = time.split_at_checked(8)?;
    let [hour, minute, second] = fields(clock, b':', [2, 2, 2])?;
    let valid = (1..=12).contains(&month)
        && (1..=days_in(year, month)).contains(&day)
        && hour < 24
        && minute < 60
        && second < 60;
    if !valid {
        return None;
    }
    let (fraction, zone) = match rest.strip_prefix(b".").or(rest.strip_prefix(b",")) {
        Some(rest) => {
            let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
            rest.split_at(digits)
        }
        None => (&rest[..0], rest),
    };
    // Finer than a nanosecond is no clock of a recorder.
    if fraction.len() > 9 || (fraction.is_empty() && rest.len() > zone.len()) {
        return None;
    }
    let mut part = number(fraction).unwrap_or(0);
    for _ in fraction.len()..9 {
        part *= 10;
    }
    // Years begin in March, so that the day added in leap years is the last.
    let (years, months) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let before = years.div_euclid(4) - years.div_euclid(100) + years.div_euclid(400);
    let days = 365 * years + before + (153 * months + 2) / 5 + day - 1 - TO_EPOCH;
    let seconds = ((days * 24 + hour) * 60 + minute) * 60 + second - zone_seconds(zone)?;
    Some((
        i128::from(seconds) * i128::from(NANO) + i128::from(part),
        fraction.len(),
    ))
}

/// Returns how far a zone lies before Greenwich [s]: `Z`, `+01:00`, `-0530`, `+01`, or nothing.
fn zone_seconds(zone: &[u8]) -> Option<i64> {
    let (sign, rest) = match zone.split_first() {
        None | Some((b'Z', [])) => return Some(0),
        Some((b'+', rest)) => (1, rest),
        Some((b'-', rest)) => (-1, rest),
        _ => return None,
    };
    let (hours, minutes) = rest.split_at_checked(2)?;
    let minutes = match minutes.strip_prefix(b":").unwrap_or(minutes) {
        [] if minutes.is_empty() => 0,
        two if two.len() == 2 => number(two)?,
        _ => return None,
    };
    let hours = number(hours)?;
    (hours < 24 && minutes < 60).then_some(sign * 60 * (60 * hours + minutes))
}

/// Splits at a mark into fields of so many digits each.
fn fields(text: &[u8], mark: u8, digits: [usize; 3]) -> Option<[i64; 3]> {
    let mut found = [0; 3];
    let mut parts = text.split(|byte| *byte == mark);
    for (value, length) in found.iter_mut().zip(digits) {
        *value = number(parts.next().filter(|part| part.len() == length)?)?;
    }
    parts.next().is_none().then_some(found)
}

/// Reads up to nine digits.
fn number(digits: &[u8]) -> Option<i64> {
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(
        digits
            .iter()
            .fold(0, |sum, digit| 10 * sum + i64::from(digit - b'0')),
    )
}

fn days_in(year: i64, month: i64) -> i64 {
    match month {
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

#[cfg(test)]
mod tests {
    use super::{DateClock, NANO, is_date, parse};

    #[track_caller]
    fn check(text: &str, seconds: i64, nanoseconds: i64) {
        let expected = i128::from(seconds) * i128::from(NANO) + i128::from(nanoseconds);
        assert_eq!(
            parse(text.as_bytes()).map(|(stamp, _)| stamp),
            Some(expected),
            "{text}"
        );
    }

    /// Seconds since 1970 as `date -u -d TEXT +%s` gives them.
    #[test]
    fn val_dates() {
        check("1970-01-01T00:00:00", 0, 0);
        check("2024-05-01T10:00:00.0001", 1_714_557_600, 100_000);
        check("2024-05-01 10:00:00,5Z", 1_714_557_600, 500_000_000);
        check("2024-05-01T10:00:00+02:00", 1_714_550_400, 0);
        check(
            "2024-05-01T10:00:00.123456789-0530",
            1_714_577_400,
            123_456_789,
        );
        check("2000-02-29T23:59:59", 951_868_799, 0);
        check("1969-12-31T23:59:59.999999999", -1, 999_999_999);
        for text in [
            "2023-02-29T00:00:00",
            "2024-13-01T00:00:00",
            "2024-05-01",
            "2024-05-01T24:00:00",
            "2024-05-01T10:00",
            "2024-05-01T10:00:00.",
            "2024-05-01T10:00:00 CET",
            "2024-05-01T10:00:00+1",
            "2024-05-01T10:00:00+01:",
            "24-05-01T10:00:00",
            "2024/05/01T10:00:00",
            "0.5",
            "",
        ] {
            assert!(!is_date(text.as_bytes()), "{text}");
        }
        let mut clock = DateClock::default();
        assert_eq!(clock.seconds(b"2024-12-31T23:59:59.9999"), Some(0.0));
        assert_eq!(clock.seconds(b"2025-01-01T00:00:00.0001"), Some(0.0002));
    }
}
