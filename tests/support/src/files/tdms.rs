//! TDMS files, written segment by segment.

/// The value of a property.
#[derive(Clone, Copy)]
pub enum Said<'a> {
    Text(&'a [u8]),
    Number(f64),
    Count(u32),
    /// Seconds since 1904.
    Instant(f64),
    /// An extended number, which is not read.
    Extended,
}

/// A property: its name and its value.
pub type Property<'a> = (&'a str, Said<'a>);

pub fn text(said: &str) -> Said<'_> {
    Said::Text(said.as_bytes())
}

/// What a list says of an object's samples: type and number in a chunk, or of texts bytes as well.
#[derive(Clone, Copy)]
pub enum Raw {
    Absent,
    AsBefore,
    Numbers(u32, u64),
    Texts(u64, u64),
    /// The first number of the index, as DAQmx has it.
    Other(u32),
}

pub const I8: u32 = 1;
pub const I16: u32 = 2;
pub const F32: u32 = 9;
pub const F64: u32 = 10;
pub const INSTANT: u32 = 0x44;

/// Flags of a segment beside those for a list and samples.
pub const INTERLEAVED: u32 = 32;
pub const BIG_ENDIAN: u32 = 64;
pub const DAQMX: u32 = 128;

/// Writes numbers in one order of bytes.
#[derive(Clone, Copy)]
pub struct Bytes {
    pub big: bool,
}

pub const LITTLE: Bytes = Bytes { big: false };
pub const BIG: Bytes = Bytes { big: true };

impl Bytes {
    pub fn ordered<const N: usize>(self, mut little: [u8; N]) -> Vec<u8> {
        if self.big {
            little.reverse();
        }
        little.to_vec()
    }

    fn u32(self, number: u32) -> Vec<u8> {
        self.ordered(number.to_le_bytes())
    }

    fn text(self, text: &[u8]) -> Vec<u8> {
        let length = u32::try_from(text.len()).unwrap();
        [&self.u32(length), text].concat()
    }

    /// An instant, in seconds since 1904.
    pub fn instant(self, seconds: f64) -> Vec<u8> {
        let whole = (seconds.floor() as i128) << 64;
        let part = (seconds.fract() * 18_446_744_073_709_551_616.0) as i128;
        self.ordered((whole + part).to_le_bytes())
    }

    fn property(self, (key, said): &Property<'_>) -> Vec<u8> {
        let (kind, value) = match said {
            Said::Text(text) => (0x20, self.text(text)),
            Said::Number(number) => (F64, self.ordered(number.to_le_bytes())),
            Said::Count(number) => (7, self.u32(*number)),
            Said::Instant(seconds) => (INSTANT, self.instant(*seconds)),
            Said::Extended => (11, vec![0; 16]),
        };
        [self.text(key.as_bytes()), self.u32(kind), value].concat()
    }

    /// An object of a list.
    pub fn object(self, path: &str, raw: Raw, properties: &[Property<'_>]) -> Vec<u8> {
        let index = match raw {
            Raw::Absent => self.u32(u32::MAX),
            Raw::AsBefore => self.u32(0),
            Raw::Other(length) => self.u32(length),
            Raw::Numbers(kind, count) => {
                let head = [20, kind, 1].map(|number| self.u32(number)).concat();
                [head, self.ordered(count.to_le_bytes())].concat()
            }
            Raw::Texts(count, bytes) => {
                let head = [28, 0x20, 1].map(|number| self.u32(number)).concat();
                let numbers = [count, bytes].map(|number| self.ordered(number.to_le_bytes()));
                [head, numbers.concat()].concat()
            }
        };
        let count = u32::try_from(properties.len()).unwrap();
        let said = properties.iter().flat_map(|one| self.property(one));
        [
            self.text(path.as_bytes()),
            index,
            self.u32(count),
            said.collect(),
        ]
        .concat()
    }

    /// A segment with a list of its own, or going on with the one before; `flags` beside those that
    /// follow from that.
    pub fn segment(self, flags: u32, objects: Option<&[Vec<u8>]>, data: &[u8]) -> Vec<u8> {
        self.with_end(flags, objects, data, |end| end)
    }

    /// A segment as [`Self::segment`], with another statement of where it ends.
    pub fn with_end(
        self,
        mut flags: u32,
        objects: Option<&[Vec<u8>]>,
        data: &[u8],
        end: impl Fn(u64) -> u64,
    ) -> Vec<u8> {
        let list = objects.map_or(Vec::new(), |objects| {
            let count = u32::try_from(objects.len()).unwrap();
            [self.u32(count), objects.concat()].concat()
        });
        flags |= if objects.is_some() { 2 | 4 } else { 0 };
        flags |= if data.is_empty() { 0 } else { 8 };
        flags |= if self.big { BIG_ENDIAN } else { 0 };
        let length = list.len() as u64;
        [
            b"TDSm".to_vec(),
            flags.to_le_bytes().to_vec(),
            self.u32(4713),
            self.ordered(end(length + data.len() as u64).to_le_bytes()),
            self.ordered(length.to_le_bytes()),
            list,
            data.to_vec(),
        ]
        .concat()
    }
}
