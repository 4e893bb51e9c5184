//! Units as types at every boundary; plain SI `f64` only inside hot loops.

use crate::error::{Error, ErrorKind};
use serde::{Deserialize, Serialize};

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

/// The unit in which a recording states time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeUnit {
    /// Second.
    Second,
    /// Millisecond.
    Millisecond,
    /// Microsecond.
    Microsecond,
    /// Nanosecond.
    Nanosecond,
}

impl TimeUnit {
    /// Lists every unit.
    pub const ALL: [Self; 4] = [
        Self::Second,
        Self::Millisecond,
        Self::Microsecond,
        Self::Nanosecond,
    ];

    /// Returns the factor by which a value in this unit is divided to give seconds.
    ///
    /// A division by 1000 keeps the decimal digits of a printed stamp exact where a
    /// product with 1e-3 would not.
    #[must_use]
    pub fn per_second(self) -> f64 {
        match self {
            Self::Second => 1.0,
            Self::Millisecond => 1e3,
            Self::Microsecond => 1e6,
            Self::Nanosecond => 1e9,
        }
    }

    /// Returns the name that options and cards use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "us",
            Self::Nanosecond => "ns",
        }
    }

    /// Reads one of the spellings found in files: `s`, `sec`, `ms`, `msec`, `us`, `µs`, `ns`.
    #[must_use]
    pub fn from_spelling(text: &str) -> Option<Self> {
        match text.trim().to_lowercase().as_str() {
            "s" | "sec" | "second" | "seconds" | "sec." => Some(Self::Second),
            "ms" | "msec" | "millisecond" | "milliseconds" => Some(Self::Millisecond),
            "us" | "usec" | "µs" | "μs" | "microsecond" | "microseconds" => {
                Some(Self::Microsecond)
            }
            "ns" | "nsec" | "nanosec" | "nanosecond" | "nanoseconds" => Some(Self::Nanosecond),
            _ => None,
        }
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
