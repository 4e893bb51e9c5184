//! Numbers, texts and instants as TDMS stores them, in either byte order.

use crate::calendar::civil;
use crate::error::Error;
use encoding_rs::WINDOWS_1252;

/// Says what a damaged file should hold, and what it holds.
pub(super) fn damaged(expected: impl Into<String>, found: impl Into<String>) -> Error {
    let hint = "the file is damaged or not written as TDMS; copy or export it again";
    Error::malformed(expected, found, hint)
}

/// Order of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    /// Returns the bytes of a number, the least first.
    fn little<const N: usize>(self, mut bytes: [u8; N]) -> [u8; N] {
        if self == Self::Big {
            bytes.reverse();
        }
        bytes
    }
}

/// Type of a value or of the samples of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DataType {
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    F32,
    F64,
    Text,
    Bool,
    Timestamp,
    /// Pairs of numbers, of so many bytes.
    Complex(u64),
}

impl DataType {
    /// Reads the number of a type.
    pub(super) fn of(code: u32) -> Result<Self, Error> {
        Ok(match code {
            1 => Self::I8,
            2 => Self::I16,
            3 => Self::I32,
            4 => Self::I64,
            5 => Self::U8,
            6 => Self::U16,
            7 => Self::U32,
            8 => Self::U64,
            // The same numbers; the unit stands in the property `unit_string`.
            9 | 0x19 => Self::F32,
            10 | 0x1A => Self::F64,
            0x20 => Self::Text,
            0x21 => Self::Bool,
            0x44 => Self::Timestamp,
            0x08_000C => Self::Complex(8),
            0x10_000D => Self::Complex(16),
            11 | 0x1B => {
                return Err(Error::malformed(
                    "numbers of 8 to 64 bits",
                    "extended floating point",
                    "save the channels as double precision",
                ));
            }
            other => {
                let unknown_type = format!("a type {other:#x}");
                return Err(damaged("a type of data that TDMS has", unknown_type));
            }
        })
    }

    /// Returns the bytes of one value; `None` for text, whose values differ.
    pub(super) fn bytes(self) -> Option<u64> {
        Some(match self {
            Self::I8 | Self::U8 | Self::Bool => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
            Self::Timestamp => 16,
            Self::Complex(bytes) => bytes,
            Self::Text => return None,
        })
    }

    /// Tells whether values are whole numbers, as counts of a converter are.
    pub(super) fn is_whole(self) -> bool {
        !matches!(
            self,
            Self::F32 | Self::F64 | Self::Timestamp | Self::Text | Self::Complex(_)
        )
    }

    /// Tells whether values can be samples.
    pub(super) fn is_number(self) -> bool {
        self.is_whole() || matches!(self, Self::F32 | Self::F64)
    }

    /// Reads a number from as many bytes as the type has; `None` if it is none.
    pub(super) fn number(self, bytes: &[u8], order: ByteOrder) -> Option<f64> {
        macro_rules! read {
            ($type:ty) => {
                <$type>::from_le_bytes(order.little(bytes.try_into().ok()?))
            };
        }
        Some(match self {
            Self::I8 => f64::from(read!(i8)),
            Self::I16 => f64::from(read!(i16)),
            Self::I32 => f64::from(read!(i32)),
            Self::I64 => read!(i64) as f64,
            Self::U8 | Self::Bool => f64::from(read!(u8)),
            Self::U16 => f64::from(read!(u16)),
            Self::U32 => f64::from(read!(u32)),
            Self::U64 => read!(u64) as f64,
            Self::F32 => f64::from(read!(f32)),
            Self::F64 => read!(f64),
            Self::Text | Self::Timestamp | Self::Complex(_) => return None,
        })
    }
}

/// An instant: whole seconds since the start of 1904 in UTC, and 2⁻⁶⁴ seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Instant {
    seconds: i64,
    fraction: u64,
}

impl Instant {
    /// Reads one from its 16 bytes.
    pub(super) fn read(bytes: &[u8], order: ByteOrder) -> Option<Self> {
        // The seconds are the upper half, so that both are one number of 128 bits.
        let number = u128::from_le_bytes(order.little(bytes.try_into().ok()?));
        Some(Self {
            seconds: (number >> 64) as i64,
            fraction: number as u64,
        })
    }

    /// Returns the time since `first` [s].
    pub(super) fn since(self, first: Self) -> f64 {
        let seconds = i128::from(self.seconds) - i128::from(first.seconds);
        let part = i128::from(self.fraction) - i128::from(first.fraction);
        const UNITS: f64 = 18_446_744_073_709_551_616.0;
        seconds as f64 + part as f64 / UNITS
    }

    /// Returns the day and the time of day in UTC, to the second; `None` of no year with four digits.
    fn date(self) -> Option<String> {
        const DAY_S: i64 = 86_400;
        /// Days from the first of 1904, from which TDMS counts, to that of 1970.
        const TO_1970: i64 = 24_107;
        let (year, month, day) = civil(self.seconds.div_euclid(DAY_S) - TO_1970);
        let clock = self.seconds.rem_euclid(DAY_S);
        let (hour, minute, second) = (clock / 3600, clock / 60 % 60, clock % 60);
        (1000..10_000)
            .contains(&year)
            .then(|| format!("{year}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z"))
    }
}

/// The value of a property.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// A number, and its type.
    Number(f64, DataType),
    Text(String),
    Instant(Instant),
    /// One that nothing here rests on.
    Other,
}

impl Value {
    /// Returns it as text; empty where it says nothing.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Number(number, _) => number.to_string(),
            Self::Text(text) => text.trim().to_string(),
            Self::Instant(instant) => instant.date().unwrap_or_default(),
            Self::Other => String::new(),
        }
    }

    /// Returns the number that it is, or that stands in its text.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number, _) => Some(*number),
            Self::Text(text) => crate::text::header_number(text.trim()),
            Self::Instant(_) | Self::Other => None,
        }
    }
}

/// Decodes text: UTF-8, or Windows-1252, as older programs write.
pub(super) fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_string(),
        Err(_) => WINDOWS_1252
            .decode_without_bom_handling(bytes)
            .0
            .into_owned(),
    }
}

/// What is left of a block of metadata.
pub(super) struct Fields<'a> {
    left: &'a [u8],
    order: ByteOrder,
}

impl<'a> Fields<'a> {
    pub(super) fn new(bytes: &'a [u8], order: ByteOrder) -> Self {
        Self { left: bytes, order }
    }

    /// Returns what is left.
    pub(super) fn left(&self) -> &'a [u8] {
        self.left
    }

    fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8], Error> {
        let parts = self.left.split_at_checked(count);
        let (bytes, remaining) = parts.ok_or_else(|| {
            let claimed = format!("{count} bytes claimed, {} left", self.left.len());
            damaged(format!("{what} within the metadata"), claimed)
        })?;
        self.left = remaining;
        Ok(bytes)
    }

    /// Takes a whole number of 32 bits.
    pub(super) fn u32(&mut self, what: &str) -> Result<u32, Error> {
        let bytes = self.take(4, what)?.try_into().unwrap_or_default();
        Ok(u32::from_le_bytes(self.order.little(bytes)))
    }

    /// Takes a whole number of 64 bits.
    pub(super) fn u64(&mut self, what: &str) -> Result<u64, Error> {
        let bytes = self.take(8, what)?.try_into().unwrap_or_default();
        Ok(u64::from_le_bytes(self.order.little(bytes)))
    }

    /// Takes a text behind its length.
    pub(super) fn text(&mut self, what: &str) -> Result<String, Error> {
        let length = self.u32(what)? as usize;
        Ok(decoded(self.take(length, what)?))
    }

    /// Takes a value behind its type.
    pub(super) fn value(&mut self) -> Result<Value, Error> {
        const WHAT: &str = "a property";
        let code = self.u32(WHAT)?;
        let kind = match code {
            // Extended numbers in properties have 16 bytes, and nothing rests on them.
            11 | 0x1B => DataType::Complex(16),
            _ => DataType::of(code)?,
        };
        let Some(count) = kind.bytes() else {
            return Ok(Value::Text(self.text(WHAT)?));
        };
        let bytes = self.take(count as usize, WHAT)?;
        let value = match kind {
            DataType::Timestamp => Instant::read(bytes, self.order).map(Value::Instant),
            _ => {
                let number = kind.number(bytes, self.order);
                number.map(|number| Value::Number(number, kind))
            }
        };
        Ok(value.unwrap_or(Value::Other))
    }
}
