//! Units as types at every boundary; plain SI `f64` only inside hot loops.

use crate::error::{Error, ErrorKind};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Standard gravity [m/s²], exact by definition (3rd CGPM, 1901; ISO 80000-3).
///
/// Every `g` in a recording is this value, never a gram and never 9.81.
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// Time from one sample to the next [s].
///
/// Its reciprocal is a [`SampleRate`]; neither turns into the other silently.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct SampleInterval(f64);

impl SampleInterval {
    /// Wraps a finite, positive interval in seconds.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::NotPositive`] if `seconds` is zero, negative, infinite or NaN.
    pub fn from_seconds(seconds: f64) -> Result<Self, Error> {
        positive("sample interval [s]", seconds).map(Self)
    }

    /// Returns the interval [s].
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0
    }

    /// Returns the rate whose interval this is.
    #[must_use]
    pub fn rate(self) -> SampleRate {
        SampleRate(1.0 / self.0)
    }
}

/// Samples per second [Hz].
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct SampleRate(f64);

impl SampleRate {
    /// Wraps a finite, positive rate in hertz.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::NotPositive`] if `hertz` is zero, negative, infinite or NaN.
    pub fn from_hertz(hertz: f64) -> Result<Self, Error> {
        positive("sample rate [Hz]", hertz).map(Self)
    }

    /// Returns the rate [Hz].
    #[must_use]
    pub fn hertz(self) -> f64 {
        self.0
    }

    /// Returns the interval whose rate this is.
    #[must_use]
    pub fn interval(self) -> SampleInterval {
        SampleInterval(1.0 / self.0)
    }

    /// Returns the rate rounded to 1e-4 Hz, the form in which rates are compared with
    /// the demands of a filter class.
    #[must_use]
    pub fn rounded(self) -> f64 {
        (self.0 * 1e4).round() / 1e4
    }
}

/// Newton's coefficient of restitution R [-]: speed after an impact over speed before it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Restitution(f64);

impl Restitution {
    /// Wraps a ratio from 0 (no rebound) to 1 (no loss).
    ///
    /// # Errors
    ///
    /// [`ErrorKind::OutOfRange`] outside 0 ≤ R ≤ 1 or for NaN.
    pub fn from_ratio(ratio: f64) -> Result<Self, Error> {
        if (0.0..=1.0).contains(&ratio) {
            Ok(Self(ratio))
        } else {
            Err(Error::out_of_range(
                "restitution [-]",
                "0 to 1",
                format!("{ratio}"),
            ))
        }
    }

    /// Returns the ratio [-].
    #[must_use]
    pub fn ratio(self) -> f64 {
        self.0
    }
}

/// The unit in which a recording states acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AccelerationUnit {
    /// Standard gravity, 9.806 65 m/s².
    StandardGravity,
    /// Metre per second squared.
    MetrePerSecondSquared,
    /// Millimetre per second squared, 1e-3 m/s².
    MillimetrePerSecondSquared,
    /// Millimetre per millisecond squared, 1000 m/s² (finite-element codes).
    MillimetrePerMillisecondSquared,
    /// Foot per second squared, 0.3048 m/s².
    FootPerSecondSquared,
    /// A thousand times standard gravity; never a kilogram, so that it is spelt out.
    ThousandStandardGravity,
}

impl AccelerationUnit {
    /// Lists every unit with the name that options, cards and reports use.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::StandardGravity, "g"),
        (Self::MetrePerSecondSquared, "m/s2"),
        (Self::MillimetrePerSecondSquared, "mm/s2"),
        (Self::MillimetrePerMillisecondSquared, "mm/ms2"),
        (Self::FootPerSecondSquared, "ft/s2"),
        (Self::ThousandStandardGravity, "kilo-g"),
    ];

    /// Returns the name that options, cards and reports use.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(unit, _)| *unit == self)
            .map_or("", |(_, name)| name)
    }

    /// Returns the factor that turns a value in this unit into m/s².
    #[must_use]
    pub fn metres_per_second_squared(self) -> f64 {
        match self {
            Self::StandardGravity => STANDARD_GRAVITY,
            Self::MetrePerSecondSquared => 1.0,
            Self::MillimetrePerSecondSquared => 1e-3,
            Self::MillimetrePerMillisecondSquared => 1e3,
            Self::FootPerSecondSquared => 0.3048,
            Self::ThousandStandardGravity => 1e3 * STANDARD_GRAVITY,
        }
    }

    /// Reads one of the spellings found in files: `g`, `G'S`, `m/s^2`, `m/s²`, `m/(s*s)`,
    /// `m s-2`, `mm/ms^2`, `ft/s2` and their like; `None` for anything else, a product with a
    /// number or with another unit among it.
    #[must_use]
    pub fn from_spelling(text: &str) -> Option<Self> {
        let plain = plain_spelling(text);
        if matches!(plain.as_str(), "g" | "gs" | "g's" | "g'" | "gn" | "g0") {
            return Some(Self::StandardGravity);
        }
        if matches!(plain.as_str(), "kilo-g" | "kilo*g") {
            return Some(Self::ThousandStandardGravity);
        }
        let (unit, rest) = [
            (Self::MillimetrePerSecondSquared, "mm"),
            (Self::MetrePerSecondSquared, "meters"),
            (Self::MetrePerSecondSquared, "metre"),
            (Self::MetrePerSecondSquared, "m"),
            (Self::FootPerSecondSquared, "ft"),
        ]
        .into_iter()
        .find_map(|(unit, length)| Some((unit, plain.strip_prefix(length)?)))?;
        match (rest, unit) {
            (
                "/s2" | "/ss" | "/s/s" | "/(s*s)" | "/(s2)" | "s-2" | "*s-2" | "/sec2" | "/sec/sec"
                | "/(sec*sec)" | "/(sec2)",
                unit,
            ) => Some(unit),
            (
                "/ms2" | "/msms" | "/ms/ms" | "/(ms*ms)" | "/(ms2)" | "ms-2" | "*ms-2",
                Self::MillimetrePerSecondSquared,
            ) => Some(Self::MillimetrePerMillisecondSquared),
            _ => None,
        }
    }
}

/// Writes a unit in small letters without powers' carets, blanks around operators and the
/// brackets around all of it; a product gets a `*`, be it written with a dot or a blank.
fn plain_spelling(text: &str) -> String {
    let text = text.trim();
    let inner = text
        .strip_prefix('(')
        .and_then(|rest| rest.strip_suffix(')'))
        .filter(|inner| inner.find('(').unwrap_or(0) <= inner.find(')').unwrap_or(0));
    let text = inner.unwrap_or(text).trim_end_matches('.');
    let mut plain = String::with_capacity(text.len());
    let mut product = false;
    for character in text.replace("**", "^").chars() {
        let character = match character {
            '²' => '2',
            '⁻' => '-',
            '’' => '\'',
            other => other.to_ascii_lowercase(),
        };
        if character.is_whitespace() || matches!(character, '*' | '·' | '⋅' | '∙' | '.') {
            product = true;
            continue;
        }
        if character == '^' {
            continue;
        }
        // A blank beside a stroke or a bracket is no product.
        if product
            && !matches!(character, '/' | ')')
            && !plain.is_empty()
            && !plain.ends_with(['/', '('])
        {
            plain.push('*');
        }
        product = false;
        plain.push(character);
    }
    if product && text.ends_with(['*', '·', '⋅', '∙']) {
        plain.push('*');
    }
    plain
}

/// The unit in which a recording states time: a second, a day, or any number of such, as in 10 µs.
///
/// A value becomes seconds by a product and a quotient with whole numbers. A division by 1000 keeps
/// the decimal digits of a printed stamp exact where a product with 1e-3 would not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeUnit {
    /// Whole seconds in `parts` units; the two have no divisor in common.
    times: u64,
    parts: u64,
}

impl TimeUnit {
    /// Second.
    pub const SECOND: Self = Self { times: 1, parts: 1 };
    /// Millisecond.
    pub const MILLISECOND: Self = Self {
        times: 1,
        parts: 1_000,
    };
    /// Microsecond.
    pub const MICROSECOND: Self = Self {
        times: 1,
        parts: 1_000_000,
    };
    /// Nanosecond.
    pub const NANOSECOND: Self = Self {
        times: 1,
        parts: 1_000_000_000,
    };
    /// Minute.
    pub const MINUTE: Self = Self {
        times: 60,
        parts: 1,
    };
    /// Hour.
    pub const HOUR: Self = Self {
        times: 3_600,
        parts: 1,
    };
    /// Day of 24 hours, of which spreadsheets count fractions.
    pub const DAY: Self = Self {
        times: 86_400,
        parts: 1,
    };
    /// 100 ns, the tick of Windows' clocks.
    pub const WINDOWS_TICK: Self = Self {
        times: 1,
        parts: 10_000_000,
    };

    /// Lists the units that have a name, the longest first, with the names found in files; the first
    /// of them is the one that options and cards use.
    const NAMED: [(Self, &'static [&'static str]); 7] = [
        (
            Self::DAY,
            &[
                "day", "days", "d", "tag", "tage", "jour", "jours", "dia", "dias", "día", "días",
                "giorno", "giorni", "dag", "dagen",
            ],
        ),
        (
            Self::HOUR,
            &[
                "h", "hr", "hrs", "hour", "hours", "std", "stunde", "stunden", "heure", "heures",
                "hora", "horas", "ora", "ore", "uur",
            ],
        ),
        (
            Self::MINUTE,
            &[
                "min", "mins", "minute", "minutes", "minuten", "minuto", "minutos", "minuti",
                "minuut",
            ],
        ),
        (
            Self::SECOND,
            &[
                "s", "sec", "secs", "second", "seconds", "sek", "sekunde", "sekunden", "seconde",
                "secondes", "segundo", "segundos", "secondo", "secondi", "seconden",
            ],
        ),
        (
            Self::MILLISECOND,
            &[
                "ms",
                "msec",
                "msecs",
                "millis",
                "millisec",
                "millisecond",
                "milliseconds",
                "millisekunde",
                "millisekunden",
                "milliseconde",
                "millisecondes",
                "milisegundo",
                "milisegundos",
                "millisecondo",
                "millisecondi",
                "milliseconden",
            ],
        ),
        (
            Self::MICROSECOND,
            &[
                "us",
                "usec",
                "usecs",
                "µs",
                "μs",
                "µsec",
                "μsec",
                "micros",
                "microsec",
                "microsecond",
                "microseconds",
                "mikrosekunde",
                "mikrosekunden",
                "microseconde",
                "microsecondes",
                "microsegundo",
                "microsegundos",
                "microsecondo",
                "microsecondi",
            ],
        ),
        (
            Self::NANOSECOND,
            &[
                "ns",
                "nsec",
                "nsecs",
                "nanos",
                "nanosec",
                "nanosecond",
                "nanoseconds",
                "nanosekunde",
                "nanosekunden",
                "nanoseconde",
                "nanosecondes",
                "nanosegundo",
                "nanosegundos",
                "nanosecondo",
                "nanosecondi",
            ],
        ),
    ];

    /// Returns the unit of `times`/`parts` seconds; `None` beyond a picosecond and thirty years.
    fn of_ratio(times: u128, parts: u128) -> Option<Self> {
        let (mut divisor, mut rest) = (times, parts);
        while rest > 0 {
            (divisor, rest) = (rest, divisor % rest);
        }
        let unit = Self {
            times: u64::try_from(times.checked_div(divisor)?).ok()?,
            parts: u64::try_from(parts.checked_div(divisor)?).ok()?,
        };
        (1e-12..=1e9).contains(&unit.seconds()).then_some(unit)
    }

    /// Returns the length of the unit [s].
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.to_seconds(1.0)
    }

    /// Brings a value in this unit to seconds [s].
    #[must_use]
    pub fn to_seconds(self, value: f64) -> f64 {
        value * self.times as f64 / self.parts as f64
    }

    /// Reads one of the spellings found in files: `s`, `sec.`, `ms`, `µs`, `min`, `h`, `day`, and any
    /// of them behind a number, as in `10 us`, `0.1ms`, `1e-4 s`, `1/32768 s`, `100 ns ticks`.
    #[must_use]
    pub fn from_spelling(text: &str) -> Option<Self> {
        let small = text.trim().to_lowercase();
        let (number, name) = split_number(&small);
        let name = name.trim_start_matches([' ', '*', '·', '×', '_', '-']);
        let name = name.trim_end_matches(" ticks").trim_end_matches(" tick");
        let name = name.trim_end_matches('.');
        let (unit, _) = Self::NAMED
            .iter()
            .find(|(_, names)| names.contains(&name))?;
        if number.is_empty() {
            return (name.len() == small.trim_end_matches('.').len()).then_some(*unit);
        }
        let (above, below) = number.split_once('/').unwrap_or((number, "1"));
        let (above, below) = (Ratio::from_decimal(above)?, Ratio::from_decimal(below)?);
        let times = above.above.checked_mul(below.below)?;
        let parts = above.below.checked_mul(below.above)?;
        Self::of_ratio(
            times.checked_mul(u128::from(unit.times))?,
            parts.checked_mul(u128::from(unit.parts))?,
        )
    }
}

impl fmt::Display for TimeUnit {
    /// Writes the unit as options and cards take it, in one way only: `ms`, `10us`, `1/32768s`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |unit: &Self| {
            let above = u128::from(self.times) * u128::from(unit.parts);
            let below = u128::from(self.parts) * u128::from(unit.times);
            (above % below == 0).then_some(above / below)
        };
        let whole = Self::NAMED
            .iter()
            .find_map(|(unit, names)| Some((counted(unit)?, names[0])));
        match whole {
            Some((1, name)) => f.write_str(name),
            Some((count, name)) => write!(f, "{count}{name}"),
            None => write!(f, "{}/{}s", self.times, self.parts),
        }
    }
}

/// Splits a text into the number that it begins with, decimals, exponent and stroke included, and the
/// rest.
fn split_number(text: &str) -> (&str, &str) {
    let digit = |text: &str| text.starts_with(|c: char| c.is_ascii_digit());
    let mut end = 0;
    while let Some(next) = text[end..].chars().next() {
        let rest = &text[end + next.len_utf8()..];
        let exponent = next == 'e' && digit(rest.trim_start_matches(['-', '+']));
        let sign = matches!(next, '-' | '+') && text[..end].ends_with('e') && digit(rest);
        let mark = end > 0 && matches!(next, '.' | ',' | '/') && digit(rest);
        if !(next.is_ascii_digit() || mark || (end > 0 && exponent) || sign) {
            break;
        }
        end += next.len_utf8();
    }
    text.split_at(end)
}

/// A decimal number as a quotient of whole ones.
struct Ratio {
    above: u128,
    below: u128,
}

impl Ratio {
    /// Reads a number with a decimal point or comma; `None` for zero and for what is longer than a
    /// number of units is.
    fn from_decimal(text: &str) -> Option<Self> {
        let (digits, exponent) = text.split_once('e').unwrap_or((text, "0"));
        let exponent: i32 = exponent.parse().ok()?;
        let (whole, decimals) = digits.split_once(['.', ',']).unwrap_or((digits, ""));
        if whole.len() + decimals.len() > 18 || exponent.abs() > 18 {
            return None;
        }
        let above: u128 = format!("{whole}{decimals}").parse().ok()?;
        let shift = exponent - i32::try_from(decimals.len()).ok()?;
        let power = 10_u128.pow(shift.unsigned_abs());
        let (above, below) = match shift < 0 {
            true => (above, power),
            false => (above.checked_mul(power)?, 1),
        };
        (above > 0).then_some(Self { above, below })
    }
}

/// The mark between the whole part of a number and its decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DecimalMark {
    /// A point; commas may separate thousands.
    Point,
    /// A comma; points may separate thousands.
    Comma,
}

impl DecimalMark {
    /// Lists both marks.
    pub const ALL: [Self; 2] = [Self::Point, Self::Comma];

    /// Returns the mark as text.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => ".",
            Self::Comma => ",",
        }
    }
}

/// Whose clock tells the time of a message in a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageClock {
    /// The stamp in the message's own header: when it was measured.
    Header,
    /// The recorder's: when the message was logged.
    Log,
    /// The sender's: when the message was published.
    Publish,
}

impl MessageClock {
    /// Lists the clocks, the one nearest to the measurement first.
    pub const ALL: [Self; 3] = [Self::Header, Self::Log, Self::Publish];

    /// Returns the word that options, cards and documents use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Header => "header",
            Self::Log => "log",
            Self::Publish => "publish",
        }
    }
}

/// The sign of the recorded acceleration that swings the lever open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OpensWhen {
    /// A negative recorded acceleration opens; the recording enters the model as it is.
    Negative,
    /// A positive recorded acceleration opens; the recording enters with its sign changed.
    Positive,
}

impl OpensWhen {
    /// Returns the factor, +1 or −1, that turns the recorded acceleration into the model's.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Negative => 1.0,
            Self::Positive => -1.0,
        }
    }

    /// Returns the other polarity.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Negative => Self::Positive,
            Self::Positive => Self::Negative,
        }
    }

    /// Returns the word that options, cards and verdicts use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Negative => "negative",
            Self::Positive => "positive",
        }
    }
}

fn positive(what: &'static str, value: f64) -> Result<f64, Error> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(ErrorKind::NotPositive { what, found: value }.into())
    }
}

/// As [`plain`] without zeros at the end of its decimals: `6.4`, `1000`, `3.10e-7`.
#[must_use]
pub fn short(value: f64, digits: usize) -> String {
    let text = plain(value, digits);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

/// As [`plain`] with as few digits as give the value to 1e-9 of it, four at most.
#[must_use]
pub fn shortest(value: f64) -> String {
    let digits = (1..=4).find(|digits| {
        let read: f64 = plain(value, *digits).parse().unwrap_or(f64::NAN);
        (read - value).abs() <= 1e-9 * value.abs()
    });
    plain(value, digits.unwrap_or(4))
}

/// Returns `value` with `digits` significant digits in ASCII, for a terminal: `-0.46000` or
/// `3.1000e-7`; `-` if it is not finite.
#[must_use]
pub fn plain(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "-".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let digits = digits.max(1);
    let scientific = format!("{:.*e}", digits - 1, value);
    let exponent = scientific
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse::<i32>().ok())
        .unwrap_or(0);
    if (-4..7).contains(&exponent) {
        let decimals = i32::try_from(digits).unwrap_or(17) - 1 - exponent;
        format!("{:.*}", usize::try_from(decimals).unwrap_or(0), value)
    } else {
        scientific
    }
}
