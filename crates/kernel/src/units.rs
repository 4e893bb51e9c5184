//! Units as types at every boundary; plain SI `f64` only inside hot loops.

use crate::error::Error;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
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
    /// [`Error::NotPositive`] if `seconds` is zero, negative, infinite or NaN.
    pub fn from_seconds(seconds: f64) -> Result<Self, Error> {
        positive("sample interval [s]", seconds).map(Self)
    }

    /// Returns the interval [s].
    pub fn seconds(self) -> f64 {
        self.0
    }

    /// Returns the rate whose interval this is.
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
    /// [`Error::NotPositive`] if `hertz` is zero, negative, infinite or NaN.
    pub fn from_hertz(hertz: f64) -> Result<Self, Error> {
        positive("sample rate [Hz]", hertz).map(Self)
    }

    /// Returns the rate [Hz].
    pub fn hertz(self) -> f64 {
        self.0
    }

    /// Returns the interval whose rate this is.
    pub fn interval(self) -> SampleInterval {
        SampleInterval(1.0 / self.0)
    }

    /// Returns the rate rounded to 1e-4 Hz, the form in which rates are compared with
    /// the demands of a filter class.
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
    /// [`Error::OutOfRange`] outside 0 ≤ R ≤ 1 or for NaN.
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
    /// Inch per second squared, 0.0254 m/s².
    InchPerSecondSquared,
    /// Centimetre per second squared, 0.01 m/s²; as Gal the unit of geophysicists.
    CentimetrePerSecondSquared,
    /// A thousandth of standard gravity; `mg` is a milligram as well.
    MilliStandardGravity,
    /// A thousand times standard gravity; never a kilogram, so that it is spelt out.
    ThousandStandardGravity,
}

impl Serialize for AccelerationUnit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for AccelerationUnit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let unit = Self::ALL.into_iter().find(|(_, known)| *known == name);
        let unknown = || D::Error::custom(format!("unknown unit `{name}`"));
        unit.map(|(unit, _)| unit).ok_or_else(unknown)
    }
}

impl AccelerationUnit {
    /// Lists every unit with the name that options, cards and reports use.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::StandardGravity, "g"),
        (Self::MilliStandardGravity, "mg"),
        (Self::MetrePerSecondSquared, "m/s2"),
        (Self::CentimetrePerSecondSquared, "cm/s2"),
        (Self::MillimetrePerSecondSquared, "mm/s2"),
        (Self::MillimetrePerMillisecondSquared, "mm/ms2"),
        (Self::FootPerSecondSquared, "ft/s2"),
        (Self::InchPerSecondSquared, "in/s2"),
        (Self::ThousandStandardGravity, "kilo-g"),
    ];

    /// Returns the name that options, cards and reports use.
    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(unit, _)| *unit == self)
            .map_or("", |(_, name)| name)
    }

    /// Returns the factor that turns a value in this unit into m/s².
    pub fn metres_per_second_squared(self) -> f64 {
        match self {
            Self::StandardGravity => STANDARD_GRAVITY,
            Self::MetrePerSecondSquared => 1.0,
            Self::MillimetrePerSecondSquared => 1e-3,
            Self::MillimetrePerMillisecondSquared => 1e3,
            Self::FootPerSecondSquared => 0.3048,
            Self::InchPerSecondSquared => 0.0254,
            Self::CentimetrePerSecondSquared => 1e-2,
            Self::MilliStandardGravity => 1e-3 * STANDARD_GRAVITY,
            Self::ThousandStandardGravity => 1e3 * STANDARD_GRAVITY,
        }
    }

    /// Reads one of the spellings found in files: `g`, `G'S`, `milli-g`, `m/s^2`, `m/s²`,
    /// `m/(s*s)`, `m s-2`, `mm/ms^2`, `ft/s2`, `Gal` and their like; `None` for anything else, a
    /// product with a number or with another unit among it.
    pub fn from_spelling(text: &str) -> Option<Self> {
        let plain = plain_spelling(text);
        match plain.as_str() {
            "g" | "gs" | "g's" | "g'" | "gn" | "g0" => return Some(Self::StandardGravity),
            "kilo-g" | "kilo*g" => return Some(Self::ThousandStandardGravity),
            // A megagram, or nobody knows what.
            "mg" if text.contains("Mg") => return None,
            "mg" | "mgs" | "mg's" | "mgn" | "mg0" | "millig" | "milli-g" | "milli*g"
            | "milligs" | "milli-gs" | "milli*gs" | "milli-g's" | "milli*g's" => {
                return Some(Self::MilliStandardGravity);
            }
            "gal" | "gals" => return Some(Self::CentimetrePerSecondSquared),
            _ => {}
        }
        let (unit, rest) = [
            (Self::MillimetrePerSecondSquared, "mm"),
            (Self::CentimetrePerSecondSquared, "cm"),
            (Self::MetrePerSecondSquared, "meters"),
            (Self::MetrePerSecondSquared, "metre"),
            (Self::MetrePerSecondSquared, "m"),
            (Self::FootPerSecondSquared, "ft"),
            (Self::FootPerSecondSquared, "feet"),
            (Self::InchPerSecondSquared, "inches"),
            (Self::InchPerSecondSquared, "inch"),
            (Self::InchPerSecondSquared, "in"),
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

    /// Tells whether a spelling is that of another quantity's unit as well: `mg` of a mass, `gal` of
    /// a volume.
    pub fn is_ambiguous(text: &str) -> bool {
        matches!(plain_spelling(text).as_str(), "mg" | "mgs" | "gal" | "gals")
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

/// What a number of another quantity means as an acceleration: `20 g/V`, or the other way round
/// `10 mV/g`, as data sheets of sensors have it.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorSensitivity {
    number: f64,
    unit: AccelerationUnit,
    /// The other quantity's unit, as it is written.
    quantity: String,
    /// Whether the number counts the other quantity for one of `unit`.
    inverse: bool,
}

impl SensorSensitivity {
    /// Reads NUMBER UNIT/UNIT, one of the units being one of acceleration and the other none.
    ///
    /// # Errors
    ///
    /// Says what was expected.
    ///
    /// # Examples
    ///
    /// ```
    /// # use latchgate_kernel::units::SensorSensitivity;
    /// let scope = SensorSensitivity::from_text("20 g/V").unwrap();
    /// assert_eq!(scope.scale_of("mV"), Some(0.02));
    /// let sheet = SensorSensitivity::from_text("10 mV/g").unwrap();
    /// assert_eq!(sheet.scale_of("Volt"), Some(100.0));
    /// assert_eq!(sheet.scale_of("counts"), None);
    /// assert!(SensorSensitivity::from_text("20").is_err());
    /// ```
    pub fn from_text(text: &str) -> Result<Self, String> {
        let expected = || {
            "expected NUMBER UNIT/UNIT with one unit of acceleration, for example 20 g/V or 10 mV/g"
                .to_string()
        };
        let text = text.trim();
        // The longest number: in `1e-3 g/V` the `e` is its own.
        let ends = text.char_indices().map(|(end, _)| end).rev();
        let (number, ratio) = ends
            .filter_map(|end| Some((text[..end].trim().parse::<f64>().ok()?, text[end..].trim())))
            .next()
            .ok_or_else(expected)?;
        if ratio.starts_with(',') {
            return Err("expected a decimal point in the number, as in 0.05 V/g".into());
        }
        if !(number.is_finite() && number > 0.0) {
            return Err("must be positive; which sign opens is stated by itself".into());
        }
        let parts = || {
            let strokes = ratio.match_indices('/');
            strokes.map(|(at, _)| (ratio[..at].trim(), ratio[at + 1..].trim()))
        };
        let other_quantity = |text: &str| {
            (!text.is_empty() && AccelerationUnit::from_spelling(text).is_none())
                .then(|| text.to_string())
        };
        let direct = parts().find_map(|(unit, quantity)| {
            Some((
                AccelerationUnit::from_spelling(unit)?,
                other_quantity(quantity)?,
            ))
        });
        let inverse = || {
            parts().find_map(|(quantity, unit)| {
                Some((
                    AccelerationUnit::from_spelling(unit)?,
                    other_quantity(quantity)?,
                ))
            })
        };
        let is_inverse = direct.is_none();
        let (unit, quantity) = direct.or_else(inverse).ok_or_else(expected)?;
        Ok(Self {
            number,
            unit,
            quantity,
            inverse: is_inverse,
        })
    }

    /// Returns the unit of the accelerations that it gives.
    pub fn unit(&self) -> AccelerationUnit {
        self.unit
    }

    /// Returns the unit of the other quantity, as it was written.
    pub fn quantity(&self) -> &str {
        &self.quantity
    }

    /// Returns the acceleration in [`Self::unit`] that one of the other quantity is.
    pub fn scale(&self) -> f64 {
        match self.inverse {
            true => 1.0 / self.number,
            false => self.number,
        }
    }

    /// As [`Self::scale`] for a quantity in the unit `text`; `None` if it is another one.
    pub fn scale_of(&self, text: &str) -> Option<f64> {
        let (counted, stated) = (OtherUnit::read(&self.quantity), OtherUnit::read(text));
        let exponent = (counted.name == stated.name).then(|| stated.exponent - counted.exponent)?;
        // A quotient keeps decimals that a product with 1e-3 does not.
        let power = |exponent: i32| format!("1e{}", exponent.max(0)).parse::<f64>().ok();
        let (up, down) = (power(exponent)?, power(-exponent)?);
        Some(match self.inverse {
            true => up / (self.number * down),
            false => self.number * up / down,
        })
    }
}

impl std::fmt::Display for SensorSensitivity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (number, unit, quantity) = (self.number, self.unit.name(), &self.quantity);
        match self.inverse {
            true => write!(f, "{number} {quantity}/{unit}"),
            false => write!(f, "{number} {unit}/{quantity}"),
        }
    }
}

/// A unit of another quantity than acceleration, as far as two of them are compared.
#[derive(Debug, PartialEq)]
struct OtherUnit {
    name: String,
    /// Power of ten of the unit.
    exponent: i32,
}

impl OtherUnit {
    /// Reads a unit. Volts, coulombs and their parts are known, counts under their names; anything else is
    /// compared as it is written, brackets, blanks and case aside.
    fn read(text: &str) -> Self {
        let bare: String = text
            .trim_matches(|c: char| "()[]{}<>".contains(c))
            .chars()
            .filter(|c| !c.is_whitespace())
            .collect();
        let parts = [
            ("m", -3),
            ("\u{b5}", -6),
            ("\u{3bc}", -6),
            ("u", -6),
            ("n", -9),
            ("p", -12),
        ];
        let symbol = |symbol: &str| {
            let prefix = bare.strip_suffix(symbol)?;
            let part = parts.iter().find(|(part, _)| *part == prefix);
            part.map(|(_, exponent)| *exponent)
                .or(prefix.is_empty().then_some(0))
        };
        let symbols = ["V", "C"].into_iter();
        if let Some((name, exponent)) = symbols.filter_map(|one| Some((one, symbol(one)?))).next() {
            let name = name.to_string();
            return Self { name, exponent };
        }
        let small = bare.to_lowercase();
        let (name, exponent) = match small.as_str() {
            "volt" | "volts" => ("V", 0),
            "mvolt" | "mvolts" | "millivolt" | "millivolts" => ("V", -3),
            "coulomb" | "coulombs" => ("C", 0),
            "cnt" | "cnts" | "count" | "counts" => ("count", 0),
            "lsb" | "lsbs" => ("lsb", 0),
            "digit" | "digits" => ("digit", 0),
            other => (other, 0),
        };
        let name = name.to_string();
        Self { name, exponent }
    }
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

    /// Names that people are shown, the usual ones first.
    pub const NAMES: [&str; 7] = ["s", "ms", "us", "ns", "min", "h", "day"];

    /// Returns the unit of `times`/`parts` seconds; `None` beyond a picosecond and thirty years.
    fn of_ratio(times: u128, parts: u128) -> Option<Self> {
        let (mut divisor, mut remainder) = (times, parts);
        while remainder > 0 {
            (divisor, remainder) = (remainder, divisor % remainder);
        }
        let unit = Self {
            times: u64::try_from(times.checked_div(divisor)?).ok()?,
            parts: u64::try_from(parts.checked_div(divisor)?).ok()?,
        };
        (1e-12..=1e9).contains(&unit.seconds()).then_some(unit)
    }

    /// Returns the length of the unit [s].
    pub fn seconds(self) -> f64 {
        self.to_seconds(1.0)
    }

    /// Brings a value in this unit to seconds [s].
    pub fn to_seconds(self, value: f64) -> f64 {
        value * self.times as f64 / self.parts as f64
    }

    /// Reads one of the spellings found in files: `s`, `sec.`, `ms`, `µs`, `min`, `h`, `day`, and any
    /// of them behind a number, as in `10 us`, `0.1ms`, `1e-4 s`, `1/32768 s`, `100 ns ticks`.
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
        let multiple = Self::NAMED
            .iter()
            .find_map(|(unit, names)| Some((counted(unit)?, names[0])));
        match multiple {
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
        let following = &text[end + next.len_utf8()..];
        let exponent = next == 'e' && digit(following.trim_start_matches(['-', '+']));
        let sign = matches!(next, '-' | '+') && text[..end].ends_with('e') && digit(following);
        let mark = end > 0 && matches!(next, '.' | ',' | '/') && digit(following);
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
    pub fn sign(self) -> f64 {
        match self {
            Self::Negative => 1.0,
            Self::Positive => -1.0,
        }
    }

    /// Returns the other polarity.
    pub fn reversed(self) -> Self {
        match self {
            Self::Negative => Self::Positive,
            Self::Positive => Self::Negative,
        }
    }

    /// Returns the word that options, cards and verdicts use.
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
        Err(Error::NotPositive { what, found: value })
    }
}

/// As [`plain`] without zeros at the end of its decimals: `6.4`, `1000`, `3.10e-7`.
pub fn short(value: f64, digits: usize) -> String {
    let text = plain(value, digits);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

/// As [`plain`] with as few digits as give the value to 1e-9 of it, four at most.
pub fn shortest(value: f64) -> String {
    let digits = (1..=4).find(|digits| {
        let read: f64 = plain(value, *digits).parse().unwrap_or(f64::NAN);
        (read - value).abs() <= 1e-9 * value.abs()
    });
    plain(value, digits.unwrap_or(4))
}

/// Returns `value` with `digits` significant digits in ASCII, for a terminal: `-0.46000` or
/// `3.1000e-7`; `-` if it is not finite.
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
