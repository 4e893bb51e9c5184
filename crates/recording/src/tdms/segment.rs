//! The segments of a TDMS file: lead-in, the list of objects, and where their samples stand.

use super::value::{ByteOrder, DataType, Fields, Value, damaged};
use crate::Limits;
use crate::error::{Error, ErrorKind};

/// Bytes of a lead-in.
pub(super) const LEAD_IN_BYTES: usize = 28;

/// First bytes of a segment.
pub(super) const TAG: &[u8; 4] = b"TDSm";

// Flags of a lead-in.
const METADATA: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;
const KNOWN: u32 = METADATA | NEW_LIST | RAW_DATA | INTERLEAVED | BIG_ENDIAN | DAQMX;

/// How a channel is converted whose scale only npTDMS reads.
pub(super) const CONVERT: &str = "\
    convert the channel by npTDMS, which scales it: python -c \"import numpy as n; from nptdms import \
    TdmsFile as T; c = T.read('FILE.tdms')['GROUP']['CHANNEL']; n.savetxt('FILE.csv', \
    n.c_[c.time_track(), c[:]], delimiter=',', comments='', header='time_s,' + c.name + ' [' + \
    c.properties['unit_string'] + ']')\"";

/// Refuses DAQmx raw data: counts, which the driver's own scales turn into a quantity.
fn refuse_daqmx() -> Error {
    let format = "NI TDMS with DAQmx raw data (counts without a scale of TDMS)";
    ErrorKind::RefusedFormat {
        format,
        way_out: CONVERT,
    }
    .into()
}

/// Says that no segment begins where one should.
pub(super) fn untagged() -> Error {
    damaged("a segment, which begins with TDSm", "other bytes")
}

/// What a segment says before its metadata.
#[derive(Debug, Clone, Copy)]
pub(super) struct LeadIn {
    flags: u32,
    /// Bytes of the metadata.
    pub(super) metadata_bytes: u64,
    /// Bytes of the samples; `None` where the writer did not close the segment.
    pub(super) data_bytes: Option<u64>,
}

impl LeadIn {
    pub(super) fn read(bytes: [u8; LEAD_IN_BYTES]) -> Result<Self, Error> {
        if !bytes.starts_with(TAG) {
            return Err(untagged());
        }
        // The flags are little-endian, whatever they say of the rest.
        let flags = Fields::new(&bytes[4..8], ByteOrder::Little).u32("flags")?;
        if flags & !KNOWN != 0 {
            return Err(damaged("the flags of TDMS", format!("flags {flags:#x}")));
        }
        let mut fields = Fields::new(&bytes[8..], order(flags));
        let version = fields.u32("the version")?;
        if !matches!(version, 4712 | 4713) {
            let shown_version = version.to_string();
            return Err(damaged("version 4712 or 4713 of TDMS", shown_version));
        }
        let next = fields.u64("the next segment")?;
        let raw = fields.u64("the raw data")?;
        if flags & DAQMX != 0 {
            return Err(refuse_daqmx());
        }
        let data_bytes = match next {
            u64::MAX => None,
            _ => Some(next.checked_sub(raw).ok_or_else(|| {
                let claimed_end = format!("the end {next} bytes behind the lead-in");
                damaged(
                    format!("an end of the segment behind {raw} bytes"),
                    claimed_end,
                )
            })?),
        };
        let lead_in = Self {
            flags,
            metadata_bytes: raw,
            data_bytes,
        };
        if !lead_in.has(RAW_DATA) && data_bytes.is_some_and(|bytes| bytes > 0) {
            let expected = "no samples, as the flags of the segment say";
            return Err(damaged(expected, format!("{data_bytes:?} bytes")));
        }
        if !lead_in.has(METADATA) && raw > 0 {
            let expected = "no metadata, as the flags of the segment say";
            return Err(damaged(expected, format!("{raw} bytes of it")));
        }
        Ok(lead_in)
    }

    fn has(self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    pub(super) fn order(self) -> ByteOrder {
        order(self.flags)
    }

    /// Tells whether it brings a list of objects.
    pub(super) fn has_metadata(self) -> bool {
        self.has(METADATA)
    }

    /// Tells whether its list stands in place of the one before.
    pub(super) fn has_new_list(self) -> bool {
        self.has(NEW_LIST)
    }

    /// Tells whether samples may follow.
    pub(super) fn has_data(self) -> bool {
        self.has(RAW_DATA)
    }

    /// Tells whether the samples of all channels take turns.
    pub(super) fn is_interleaved(self) -> bool {
        self.has(INTERLEAVED)
    }
}

fn order(flags: u32) -> ByteOrder {
    match flags & BIG_ENDIAN {
        0 => ByteOrder::Little,
        _ => ByteOrder::Big,
    }
}

/// Where the samples of a channel stand in each chunk of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RawIndex {
    pub(super) kind: DataType,
    /// Values in a chunk.
    pub(super) count: u64,
    /// Bytes in a chunk.
    pub(super) bytes: u64,
}

/// What a segment says of the samples of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RawData {
    /// It has none here.
    Absent,
    /// As in the last segment that had some.
    AsBefore,
    As(RawIndex),
}

impl RawData {
    fn read(fields: &mut Fields<'_>) -> Result<Self, Error> {
        const WHAT: &str = "a raw data index";
        let length = match fields.u32(WHAT)? {
            u32::MAX => return Ok(Self::Absent),
            0 => return Ok(Self::AsBefore),
            0x1269 | 0x126A => return Err(refuse_daqmx()),
            length => length,
        };
        let kind = DataType::of(fields.u32(WHAT)?)?;
        let (dimensions, count) = (fields.u32(WHAT)?, fields.u64(WHAT)?);
        let bytes = match kind.bytes() {
            Some(each) => count.checked_mul(each),
            None => Some(fields.u64(WHAT)?),
        };
        let expected_length = if kind.bytes().is_some() { 20 } else { 28 };
        match bytes {
            Some(bytes) if length == expected_length && dimensions == 1 => {
                Ok(Self::As(RawIndex { kind, count, bytes }))
            }
            _ => {
                let expected =
                    format!("a raw data index of {expected_length} bytes and dimension 1");
                let stated_index =
                    format!("{length} bytes, dimension {dimensions}, {count} values");
                Err(damaged(expected, stated_index))
            }
        }
    }
}

/// Bytes of a path; messages name channels in full.
const LONGEST_PATH: usize = 2048;

/// The place of an object: the file, a group, or a channel in it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ObjectPath {
    File,
    Group(String),
    Channel(String, String),
}

impl ObjectPath {
    /// Reads `/`, `/'group'` or `/'group'/'channel'`; a quote in a name is doubled.
    fn read(text: &str) -> Result<Self, Error> {
        let part = |path: &str| -> Option<(String, usize)> {
            let path = path.strip_prefix("/'")?;
            let mut name = String::new();
            let mut letters = path.char_indices().peekable();
            while let Some((position, letter)) = letters.next() {
                if letter != '\'' {
                    name.push(letter);
                } else if letters.next_if(|(_, next)| *next == '\'').is_some() {
                    name.push('\'');
                } else {
                    return Some((name, 2 + position + 1));
                }
            }
            None
        };
        let parts = || {
            if text == "/" {
                return Some(Self::File);
            }
            let (group, end) = part(text)?;
            let channel_part = &text[end..];
            if channel_part.is_empty() {
                return Some(Self::Group(group));
            }
            let (channel, end) = part(channel_part)?;
            channel_part[end..]
                .is_empty()
                .then_some(Self::Channel(group, channel))
        };
        parts().ok_or_else(|| {
            let path = format!("`{}`", crate::text::shown(text));
            damaged("a path as /'group'/'channel'", path)
        })
    }
}

/// An object as the metadata of a segment lists it.
#[derive(Debug)]
pub(super) struct Listed {
    pub(super) path: ObjectPath,
    pub(super) raw: RawData,
    pub(super) properties: Vec<(String, Value)>,
}

/// Reads the metadata of a segment.
pub(super) fn listed(
    bytes: &[u8],
    order: ByteOrder,
    limits: &Limits,
) -> Result<Vec<Listed>, Error> {
    let mut fields = Fields::new(bytes, order);
    let count = fields.u32("the number of objects")?;
    if u64::from(count) > limits.columns {
        return Err(limits.over("columns", format!("{count} objects in a segment")));
    }
    let mut objects: Vec<Listed> = Vec::new();
    for _ in 0..count {
        let path = fields.text("the path of an object")?;
        if path.len() > LONGEST_PATH {
            let expected = format!("a path of at most {LONGEST_PATH} bytes");
            return Err(damaged(expected, format!("{} bytes", path.len())));
        }
        let path = ObjectPath::read(&path)?;
        let raw = RawData::read(&mut fields)?;
        if raw != RawData::Absent && !matches!(path, ObjectPath::Channel(..)) {
            return Err(damaged(
                "samples of channels alone",
                "some of a group or of the file",
            ));
        }
        let mut properties = Vec::new();
        for _ in 0..fields.u32("the number of properties")? {
            properties.push((fields.text("the name of a property")?, fields.value()?));
        }
        objects.push(Listed {
            path,
            raw,
            properties,
        });
    }
    // Some writers fill up to a round number of bytes.
    match fields.left().iter().any(|byte| *byte != 0) {
        true => Err(damaged(
            "the samples behind the metadata",
            "bytes that belong to neither",
        )),
        false => Ok(objects),
    }
}
