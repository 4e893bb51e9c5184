//! Stamps as words: dates (`2024-05-01T10:00:00.0001`, `01.05.2024 10:00:00`, `5/1/2024 10:00:00 AM`),
//! times of day (`10:00:00.0001`), minutes and seconds (`00:00.0001`), what pandas and Python write of a
//! length of time (`-1 days +23:59:59.95`), and numbers with their unit (`0.1 ms`).
//!
//! Only differences of stamps count. So neither the zone nor the order of day and month matters while
//! the date stays the same.

use crate::number::{self, Decimal, PrintedDigits};
use crate::words::{Words, word_list};
use latchgate_kernel::units::TimeUnit;

// The head of the list explains it.
static MONTHS: Words = word_list!("month-names");

/// Nanoseconds in a second, a minute, an hour and a day.
const SECOND: i128 = 1_000_000_000;
const MINUTE: i128 = 60 * SECOND;
const HOUR: i128 = 60 * MINUTE;
const DAY: i128 = 24 * HOUR;

/// Decimals of a second that are read; no clock of a recorder is finer.
const DECIMALS: usize = 9;

/// True if a cell is a stamp as words.
pub(super) fn is_stamp(cell: &[u8]) -> bool {
    Stamp::read(cell).is_some()
}

/// True if a cell is a stamp with its date.
pub(super) fn is_dated(cell: &[u8]) -> bool {
    matches!(Stamp::read(cell), Some(Stamp::Clock { date: Some(_), .. }))
}

/// Returns the number and the unit of a cell with a number and a unit of time after it.
pub(super) fn amount(cell: &[u8]) -> Option<(&[u8], TimeUnit)> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    let number = |c: char| c.is_ascii_digit() || "+-−.,".contains(c);
    let mut end = text.find(|c: char| !number(c))?;
    // `1e-4 s`.
    if let Some(exponent) = text[end..].strip_prefix(['e', 'E']) {
        let digits = exponent.find(|c: char| !(c.is_ascii_digit() || "+-".contains(c)))?;
        end += if digits > 0 { 1 + digits } else { 0 };
    }
    let (number, unit) = text.split_at(end);
    let named = !number.is_empty() && !unit.contains(|c: char| c.is_ascii_digit());
    let unit = TimeUnit::from_spelling(unit).filter(|_| named)?;
    Some((number.as_bytes(), unit))
}

/// Returns the nanoseconds of a stamp since 1970 [ns], that of its zone taken off; `None` without a date
/// that can be read in one way only.
pub fn nanoseconds(cell: &[u8]) -> Option<i128> {
    match Stamp::read(cell)? {
        Stamp::Clock {
            date: Some(date),
            nanoseconds,
            ..
        } => Some(i128::from(date.only()?) * DAY + nanoseconds),
        _ => None,
    }
}

/// A date as days since 1970, by either order of day and month; `None` for an order that makes no date.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Date {
    day_first: Option<i64>,
    month_first: Option<i64>,
}

impl Date {
    fn certain(days: i64) -> Self {
        Self {
            day_first: Some(days),
            month_first: Some(days),
        }
    }

    /// Returns the day where both orders give the same, or only one gives any.
    fn only(self) -> Option<i64> {
        match (self.day_first, self.month_first) {
            (Some(by_day), Some(by_month)) => (by_day == by_month).then_some(by_day),
            (by_day, by_month) => by_day.or(by_month),
        }
    }

    fn in_order(self, order: DateOrder) -> Option<i64> {
        match order {
            DateOrder::DayFirst => self.day_first,
            DateOrder::MonthFirst => self.month_first,
        }
    }

    /// Reads a date without its time of day; `None` for anything else.
    fn read(text: &str) -> Option<Self> {
        let marks = |c: char| c.is_whitespace() || matches!(c, '-' | '/' | '.' | ',');
        let mut split = text.split(marks).filter(|part| !part.is_empty());
        let parts = [split.next()?, split.next()?, split.next()?];
        let [first, second, third] = parts;
        if split.next().is_some() {
            return None;
        }
        let named = |part: &&str| month_named(part).is_some();
        if text.contains(char::is_alphabetic)
            && let Some(index) = parts.iter().position(named)
        {
            let month = month_named(parts[index])?;
            let (day, year) = match index {
                0 => (second, third),
                1 if first.len() == 4 => (third, first),
                1 => (first, third),
                _ => return None,
            };
            return days_of(year, month, number_in(day)?).map(Self::certain);
        }
        let [first_number, second_number] = [number_in(first)?, number_in(second)?];
        if first.len() == 4 {
            return days_of(first, second_number, number_in(third)?).map(Self::certain);
        }
        let pointed = text.contains('.');
        if third.len() != 4 && !(third.len() == 2 && (pointed || text.contains('/'))) {
            return None;
        }
        let day_first = days_of(third, second_number, first_number);
        if pointed {
            return day_first.map(Self::certain);
        }
        let month_first = days_of(third, first_number, second_number);
        let date = Self {
            day_first,
            month_first,
        };
        (day_first.is_some() || month_first.is_some()).then_some(date)
    }
}

/// Order of day and month in dates such as `01/05/2024`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DateOrder {
    DayFirst,
    MonthFirst,
}

/// A cell of a column of stamps.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stamp<'a> {
    /// A number with its unit.
    Amount { number: &'a [u8], unit: TimeUnit },
    /// A reading of a clock.
    Clock {
        date: Option<Date>,
        /// Since midnight, or since the zero of a clock that counts days or has a sign [ns].
        nanoseconds: i128,
        /// Time after which it begins anew [ns], if it does.
        period: Option<i128>,
        /// True if it has its own zero.
        elapsed: bool,
        /// Size of its last printed digit [ns].
        digit: i128,
    },
}

impl<'a> Stamp<'a> {
    fn read(cell: &'a [u8]) -> Option<Self> {
        // Most stamps are clocks of digits, which a colon shows at once.
        let colons = memchr::memchr(b':', cell).is_some();
        if !colons && let Some((number, unit)) = amount(cell) {
            return Some(Self::Amount { number, unit });
        }
        let text = std::str::from_utf8(cell).ok()?.trim();
        let text = match text
            .bytes()
            .any(|byte| byte.is_ascii_alphabetic() || byte >= 128)
        {
            true => std::borrow::Cow::Owned(text.to_lowercase()),
            false => std::borrow::Cow::Borrowed(text),
        };
        if !text.starts_with(|c: char| c.is_alphanumeric() || "+-−".contains(c)) {
            return None;
        }
        match text.split_once("day") {
            Some((days, tail)) => Self::of_days(days, tail),
            None => Self::of_clock(&text),
        }
    }

    /// Reads `0 days 00:00:00.0001`, `-1 days +23:59:59.95` and `-1 day, 23:59:59.95`.
    fn of_days(days: &str, tail: &str) -> Option<Self> {
        let days: i64 = days.trim().parse().ok()?;
        let tail = tail.strip_prefix('s').unwrap_or(tail);
        let tail = tail.trim_start_matches([' ', ',']);
        let sign = if tail.starts_with('-') { -1 } else { 1 };
        let time = TimeOfDay::read(tail.trim_start_matches(['-', '+']))?;
        if !time.tail.is_empty() || time.fields < 3 {
            return None;
        }
        Some(Self::Clock {
            date: None,
            nanoseconds: i128::from(days) * DAY + sign * time.nanoseconds,
            period: None,
            elapsed: true,
            digit: time.digit,
        })
    }

    /// Reads a time of day, with its date or without.
    fn of_clock(text: &str) -> Option<Self> {
        let text = &*spread_basic(text);
        let hour = text[..text.find(':')?].trim_end_matches(|c: char| c.is_ascii_digit());
        let mut time = TimeOfDay::read(&text[hour.len()..])?;
        let before = hour.trim_end_matches([' ', 't', ',', ';', '_', '\u{a0}']);
        let mut after = time.tail.trim();
        for (half, names) in [(0, ["am", "a.m."]), (12, ["pm", "p.m."])] {
            let tail = names.iter().find_map(|name| after.strip_prefix(name));
            if let Some(tail) = tail {
                time.take_half_day(half)?;
                after = tail.trim_start();
            }
        }
        let signed = matches!(before, "-" | "+" | "−");
        if before.is_empty() || signed {
            let sign = if signed && before != "+" { -1 } else { 1 };
            return after.is_empty().then(|| Self::Clock {
                date: None,
                nanoseconds: sign * time.nanoseconds,
                period: time.period.filter(|_| !signed),
                elapsed: signed,
                digit: time.digit,
            });
        }
        let date = Date::read(before)?;
        let time = time.beside_date()?;
        Some(Self::Clock {
            date: Some(date),
            nanoseconds: time.nanoseconds - zone(after)?,
            period: None,
            elapsed: false,
            digit: time.digit,
        })
    }
}

/// Writes the basic form of ISO 8601, `20240501T100000.0001`, in the extended one.
fn spread_basic(text: &str) -> std::borrow::Cow<'_, str> {
    let bytes = text.as_bytes();
    let digits = |from: usize, to: usize| {
        let part = bytes.get(from..to);
        part.is_some_and(|part| part.iter().all(u8::is_ascii_digit))
    };
    if !(digits(0, 8) && bytes.get(8) == Some(&b't') && digits(9, 15)) || text.contains(':') {
        return text.into();
    }
    let part = |from: usize, to: usize| &text[from..to];
    let [year, month, day] = [part(0, 4), part(4, 6), part(6, 8)];
    let [hour, minute, second] = [part(9, 11), part(11, 13), &text[13..]];
    format!("{year}-{month}-{day} {hour}:{minute}:{second}").into()
}

/// A time of day, or minutes and seconds, as it is read from the front of a text.
struct TimeOfDay<'a> {
    nanoseconds: i128,
    /// Numbers between colons.
    fields: usize,
    period: Option<i128>,
    digit: i128,
    tail: &'a str,
}

impl<'a> TimeOfDay<'a> {
    /// Reads `10:00:00.0001`, `10:00:00:0001` and `00:00.0001`.
    fn read(text: &'a str) -> Option<Self> {
        let mut values = [0_i64; 4];
        let mut fields = 0;
        let mut unread = text;
        let mut width;
        loop {
            width = unread.bytes().take_while(u8::is_ascii_digit).count();
            let fits = fields < 4 && (1..=DECIMALS).contains(&width);
            *values.get_mut(fields)? = unread[..width].parse().ok().filter(|_| fits)?;
            unread = &unread[width..];
            fields += 1;
            let next = unread.strip_prefix(':');
            match next.filter(|next| next.starts_with(|c: char| c.is_ascii_digit())) {
                Some(next) => unread = next,
                None => break,
            }
        }
        let mut decimals = 0;
        let mut nanoseconds = 0;
        if fields == 4 {
            // Fewer digits may count frames of a video.
            (decimals, nanoseconds) = (
                width,
                of_decimals(&text[..text.len() - unread.len()], width)?,
            );
            (width >= 3).then_some(())?;
        } else if let Some(after) = unread.strip_prefix(['.', ',']) {
            decimals = after.bytes().take_while(u8::is_ascii_digit).count();
            nanoseconds = of_decimals(&after[..decimals], decimals)?;
            unread = &after[decimals..];
        }
        let [first, second, third, _] = values.map(i128::from);
        let (whole_ns, period) = match fields {
            2 => (
                first * MINUTE + second * SECOND,
                (first < 60).then_some(HOUR),
            ),
            3 | 4 => {
                let whole_ns = first * HOUR + second * MINUTE + third * SECOND;
                (whole_ns, (first < 24).then_some(DAY))
            }
            _ => return None,
        };
        let minutes_fit = values[1] < 60 && (fields == 2 || values[2] < 60);
        minutes_fit.then(|| Self {
            nanoseconds: whole_ns + nanoseconds,
            fields,
            period,
            digit: SECOND / 10_i128.pow(u32::try_from(decimals.min(DECIMALS)).unwrap_or(0)),
            tail: unread,
        })
    }

    /// Reads the hour as one of a clock of twelve, which after noon is later by `half` hours.
    fn take_half_day(&mut self, half: i128) -> Option<()> {
        (self.fields > 2 || self.digit == SECOND).then_some(())?;
        self.take_minutes();
        let hour = self.nanoseconds / HOUR;
        (1..=12).contains(&hour).then_some(())?;
        let shift = half - if hour == 12 { 12 } else { 0 };
        self.nanoseconds += shift * HOUR;
        Some(())
    }

    /// Reads two numbers as hours and minutes.
    fn take_minutes(&mut self) {
        if self.fields == 2 {
            self.nanoseconds *= 60;
            (self.digit, self.period, self.fields) = (MINUTE, Some(DAY), 3);
        }
    }

    /// Reads the time as one beside a date; `None` if no day has it.
    fn beside_date(mut self) -> Option<Self> {
        let is_split = self.fields == 2 && self.digit < SECOND;
        self.take_minutes();
        (!is_split && self.nanoseconds < DAY).then_some(self)
    }
}

/// Returns the nanoseconds of the last `count` characters of a text as decimals of a second; `None`
/// without one.
fn of_decimals(text: &str, count: usize) -> Option<i128> {
    let digits = text.get(text.len() - count..)?;
    let read = &digits[..count.min(DECIMALS)];
    let shift = u32::try_from(DECIMALS - read.len()).ok()?;
    let number: i128 = read.parse().ok()?;
    Some(number * 10_i128.pow(shift))
}

/// Returns the nanoseconds by which a zone is ahead [ns]: `z`, `utc`, `+02:00`, `-0530`, `+02` or nothing.
fn zone(text: &str) -> Option<i128> {
    if matches!(text, "" | "z" | "utc" | "gmt") {
        return Some(0);
    }
    let sign = if text.starts_with('-') { -1 } else { 1 };
    let digits = text.strip_prefix(['-', '+'])?;
    let (hours, minutes) = match digits.len() {
        2 => (digits, "0"),
        4 => digits.split_at_checked(2)?,
        5 => digits.split_once(':')?,
        _ => return None,
    };
    let (hours, minutes) = (number_in(hours)?, number_in(minutes)?);
    let fits = hours < 24 && minutes < 60;
    fits.then(|| sign * (i128::from(hours) * HOUR + i128::from(minutes) * MINUTE))
}

fn number_in(text: &str) -> Option<i64> {
    let short = (1..=4).contains(&text.len());
    let digits = text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|_| short && digits)
}

/// Returns the number of a month by its name, in the languages of the list.
fn month_named(word: &str) -> Option<i64> {
    let mut months = MONTHS.iter().filter_map(|line| line.split_once(' '));
    months.find(|(name, _)| *name == word)?.1.parse().ok()
}

/// Returns the days from 1970 to a date of the Gregorian calendar; `None` if there is none. Two digits
/// of a year are those of this century.
fn days_of(year: &str, month: i64, day: i64) -> Option<i64> {
    /// Days from 0000-03-01 to 1970-01-01.
    const TO_EPOCH: i64 = 719_468;
    let century = if year.len() == 2 { 2000 } else { 0 };
    let year = century + number_in(year)?;
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let longest = match month {
        2 => 28 + i64::from(leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return None,
    };
    (1..=longest).contains(&day).then_some(())?;
    // Counting years from March puts the leap day at the end of a year.
    let (years, months) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let before = years.div_euclid(4) - years.div_euclid(100) + years.div_euclid(400);
    Some(365 * years + before + (153 * months + 2) / 5 + day - 1 - TO_EPOCH)
}

/// Reads a column of stamps, one after the other, in whole nanoseconds, so that no digit is lost to
/// the years before them. Dates and times of day are counted from the first; what has a sign, counts
/// days or has a unit has a zero of its own.
#[derive(Default)]
pub struct StampClock {
    /// The instant that is 0 [ns].
    zero: Option<i128>,
    /// The stamp before [ns], with the periods that came before it.
    last: i128,
    /// Periods that have passed [ns].
    passed: i128,
    /// The date before, while the order of day and month is not known.
    undecided: Option<Date>,
    order: Option<DateOrder>,
    dated: Option<bool>,
    /// True if time is counted from the first stamp.
    from_first: bool,
    /// True if the order of day and month was inferred from the next date alone.
    order_assumed: bool,
    /// Smallest last digit of a clock [ns].
    digit: Option<i128>,
    /// Digits of numbers with a unit, and the longest unit among them.
    digits: PrintedDigits,
    unit: Option<TimeUnit>,
}

impl StampClock {
    /// Returns the time of the next stamp [s]; `None` for a cell that is none.
    pub fn seconds(&mut self, cell: &[u8]) -> Option<f64> {
        self.read(cell, &mut Decimal::Unknown)
    }

    /// As [`Self::seconds`], with the decimal mark of numbers beside a unit.
    pub(super) fn read(&mut self, cell: &[u8], decimal: &mut Decimal) -> Option<f64> {
        match Stamp::read(cell)? {
            Stamp::Amount { number, unit } => {
                let zero = *self.zero.get_or_insert(0);
                let value = number::parse(number, decimal).ok()?;
                self.digits.count(number);
                let longest = self.unit.unwrap_or(unit);
                let longer = unit.seconds() > longest.seconds();
                self.unit = Some(if longer { unit } else { longest });
                (zero == 0).then(|| unit.to_seconds(value))
            }
            Stamp::Clock {
                date,
                nanoseconds,
                period,
                elapsed,
                digit,
            } => {
                if *self.dated.get_or_insert(date.is_some()) != date.is_some() {
                    return None;
                }
                let day = date.map_or(Some(0), |date| self.day(date))?;
                let mut stamp = i128::from(day) * DAY + nanoseconds + self.passed;
                if let (Some(period), Some(_)) = (period, self.zero)
                    && self.last - stamp > period / 2
                {
                    self.passed += period;
                    stamp += period;
                }
                self.last = stamp;
                self.digit = Some(self.digit.map_or(digit, |least| least.min(digit)));
                self.from_first |= self.zero.is_none() && !elapsed;
                let zero = *self.zero.get_or_insert(if elapsed { 0 } else { stamp });
                Some((stamp - zero) as f64 / 1e9)
            }
        }
    }

    /// Returns the day of a date, by the order of day and month that the dates before have shown. Where
    /// it changes and both orders are possible, the day that follows sooner is meant.
    fn day(&mut self, date: Date) -> Option<i64> {
        if let Some(order) = self.order {
            return date.in_order(order);
        }
        let before = self.undecided.replace(date);
        if date.day_first == date.month_first {
            return date.day_first;
        }
        let later = |order: DateOrder| {
            let before = before.and_then(|before| before.in_order(order));
            Some(
                date.in_order(order)?
                    .abs_diff(before.or(date.in_order(order))?),
            )
        };
        let order = match (later(DateOrder::DayFirst), later(DateOrder::MonthFirst)) {
            (Some(_), None) => DateOrder::DayFirst,
            (None, Some(_)) => DateOrder::MonthFirst,
            (Some(0), Some(0)) => return date.day_first,
            (by_day, by_month) => {
                self.order_assumed = true;
                match by_day <= by_month {
                    true => DateOrder::DayFirst,
                    false => DateOrder::MonthFirst,
                }
            }
        };
        self.order = Some(order);
        // A day that was read by the other order moves to this one.
        if let (Some(zero), Some(before)) = (&mut self.zero, before) {
            let days =
                before.in_order(order)? - before.day_first.unwrap_or(before.in_order(order)?);
            *zero += i128::from(days) * DAY;
            self.last += i128::from(days) * DAY;
        }
        date.in_order(order)
    }

    /// True if time is counted from the first stamp.
    pub(super) fn counts_from_first(&self) -> bool {
        self.from_first
    }

    /// True if the first stamp is an instant of some day, not the zero of a clock.
    pub(super) fn is_absolute(&self) -> bool {
        self.from_first && (self.zero != Some(0) || self.dated == Some(true))
    }

    /// True if the order of day and month was inferred from the next date alone.
    pub(super) fn order_is_assumed(&self) -> bool {
        self.order_assumed
    }

    /// Returns the size of the last printed digit [s].
    pub(super) fn last_digit(&self) -> f64 {
        match (self.digit, self.unit) {
            (Some(digit), _) => digit as f64 / 1e9,
            (None, Some(unit)) => unit.to_seconds(self.digits.last_digit()),
            (None, None) => 0.0,
        }
    }
}
