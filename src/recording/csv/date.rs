//! Stamps that are dates: `2024-05-01T10:00:00.0001`, as ISO 8601 writes them, with a `T` or a
//! blank between date and time, and with a zone or without.

use toml::value::{Datetime, Offset};

/// Nanoseconds in a second.
const NANO: i64 = 1_000_000_000;

/// Days from 0000-03-01 to 1970-01-01, which only shifts what is subtracted again.
const TO_EPOCH: i64 = 719_468;

/// Tells whether a cell is such a stamp.
pub(super) fn is_date(cell: &[u8]) -> bool {
    parse(cell).is_some()
}

/// Returns the nanoseconds of a stamp since 1970 [ns], that of its zone taken off.
#[must_use]
pub fn nanoseconds(cell: &[u8]) -> Option<i128> {
    parse(cell).map(|(stamp, _)| stamp)
}

/// Counts time from the first stamp, in whole nanoseconds, so that no digit is lost to the
/// years before it.
#[derive(Debug, Default)]
pub struct DateClock {
    first: Option<i128>,
    decimals: usize,
}

impl DateClock {
    /// Returns the time since the first stamp [s]; `None` for what is no date.
    pub fn seconds(&mut self, cell: &[u8]) -> Option<f64> {
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

/// Bytes of a stamp up to its whole seconds.
const WHOLE: usize = 19;

/// Returns the nanoseconds of a stamp since 1970, that of its zone taken off, and the number of
/// its decimals.
fn parse(cell: &[u8]) -> Option<(i128, usize)> {
    // TOML's dates have a point, and minutes in the zone.
    let text = std::str::from_utf8(cell.trim_ascii()).ok()?;
    let long = text.is_ascii() && text.len() >= WHOLE;
    let mut text = long.then(|| text.replace(',', "."))?;
    let rest = text.get(WHOLE..)?;
    let decimals = rest.bytes().skip(1).take_while(u8::is_ascii_digit).count();
    if let Some(zone) = rest.find(['+', '-']).map(|zone| zone + WHOLE) {
        match text.len() - zone {
            3 => text.push_str(":00"),
            5 => text.insert(zone + 3, ':'),
            _ => {}
        }
    }
    let stamp: Datetime = text.parse().ok()?;
    let (date, time) = (stamp.date?, stamp.time?);
    // Finer than a nanosecond is no clock of a recorder.
    let second = time.second.filter(|second| *second < 60 && decimals <= 9)?;
    let zone = match stamp.offset {
        Some(Offset::Custom { minutes }) => i64::from(minutes),
        _ => 0,
    };
    let (year, month, day) = (
        i64::from(date.year),
        i64::from(date.month),
        i64::from(date.day),
    );
    // Years begin in March, so that the day added in leap years is the last.
    let (years, months) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let before = years.div_euclid(4) - years.div_euclid(100) + years.div_euclid(400);
    let days = 365 * years + before + (153 * months + 2) / 5 + day - 1 - TO_EPOCH;
    let minutes = (days * 24 + i64::from(time.hour)) * 60 + i64::from(time.minute) - zone;
    let seconds = i128::from(minutes * 60 + i64::from(second));
    let nanoseconds = i128::from(time.nanosecond.unwrap_or(0));
    Some((seconds * i128::from(NANO) + nanoseconds, decimals))
}
