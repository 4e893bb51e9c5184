//! The records of an MCAP file, read with checked lengths.
//!
//! Every length in a record is compared with the bytes there before anything is taken, so
//! no field can make the reader allocate. Bytes after the known fields are ignored: later
//! versions of the format may add some.

use crate::error::{Error, ErrorKind};
use crate::recording::Limits;
use crate::recording::remarks;

/// Bytes of opcode and length before each record.
pub(super) const PREFIX_BYTES: usize = 9;

/// A cursor over the fields of one record.
#[derive(Clone)]
struct Fields<'a> {
    left: &'a [u8],
    what: &'static str,
    /// Longest text let in [byte].
    longest: u64,
}

impl<'a> Fields<'a> {
    fn new(what: &'static str, data: &'a [u8]) -> Self {
        Self {
            left: data,
            what,
            longest: u64::MAX,
        }
    }

    /// As [`Self::new`], with a limit on texts.
    fn within(what: &'static str, data: &'a [u8], limits: &Limits) -> Self {
        Self {
            longest: limits.mcap_string_bytes,
            ..Self::new(what, data)
        }
    }

    fn is_empty(&self) -> bool {
        self.left.is_empty()
    }

    fn bytes(&mut self, count: u64) -> Result<&'a [u8], Error> {
        let split = usize::try_from(count)
            .ok()
            .and_then(|count| self.left.split_at_checked(count));
        let Some((taken, left)) = split else {
            return Err(damaged(
                format!("{count} more bytes in the {} record", self.what),
                format!("{}", self.left.len()),
            ));
        };
        self.left = left;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut array = [0; N];
        array.copy_from_slice(self.bytes(N as u64)?);
        Ok(array)
    }

    fn u8(&mut self) -> Result<u8, Error> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, Error> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, Error> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Error> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Result<&'a str, Error> {
        let length = u64::from(self.u32()?);
        if length > self.longest {
            return Err(too_long(self.longest, length, self.what));
        }
        let bytes = self.bytes(length)?;
        std::str::from_utf8(bytes).map_err(|_| {
            damaged(
                format!("text in UTF-8 in the {} record", self.what),
                "other bytes",
            )
        })
    }

    /// Takes a block whose length in bytes stands before it.
    fn block(&mut self) -> Result<Self, Error> {
        let length = self.u32()?;
        let (what, longest) = (self.what, self.longest);
        self.bytes(u64::from(length)).map(|left| Self {
            left,
            what,
            longest,
        })
    }
}

/// Returns an error for a text that claims to be longer than allowed.
pub(super) fn too_long(limit: u64, found: u64, what: &str) -> Error {
    ErrorKind::LimitExceeded {
        limit: "mcap_string_bytes",
        value: limit,
        found: format!("a string of {found} bytes in a {what}, as its length field says"),
    }
    .into()
}

/// A schema: the definition of a message type.
pub(super) struct SchemaRecord<'a> {
    pub(super) id: u16,
    pub(super) name: &'a str,
    pub(super) encoding: &'a str,
    pub(super) data: &'a [u8],
}

/// Reads a schema.
pub(super) fn schema<'a>(data: &'a [u8], limits: &Limits) -> Result<SchemaRecord<'a>, Error> {
    let mut fields = Fields::within("schema", data, limits);
    Ok(SchemaRecord {
        id: fields.u16()?,
        name: fields.text()?,
        encoding: fields.text()?,
        data: fields.block()?.left,
    })
}

/// A channel: a topic with its message encoding and schema.
pub(super) struct ChannelRecord<'a> {
    pub(super) id: u16,
    pub(super) schema_id: u16,
    pub(super) topic: &'a str,
    pub(super) encoding: &'a str,
    /// What a person wrote of it.
    pub(super) comments: Vec<&'a str>,
}

/// Reads a channel.
pub(super) fn channel<'a>(data: &'a [u8], limits: &Limits) -> Result<ChannelRecord<'a>, Error> {
    let mut fields = Fields::within("channel", data, limits);
    Ok(ChannelRecord {
        id: fields.u16()?,
        schema_id: fields.u16()?,
        topic: fields.text()?,
        encoding: fields.text()?,
        comments: comments(fields.block()?)?,
    })
}

/// Reads what a person wrote in a metadata record, which is of no topic.
pub(super) fn metadata(data: &[u8]) -> Result<Vec<&str>, Error> {
    let mut fields = Fields::new("metadata", data);
    fields.text()?;
    comments(fields.block()?)
}

/// Returns the values of a map whose keys say that a person wrote them.
fn comments(mut map: Fields<'_>) -> Result<Vec<&str>, Error> {
    let mut found = Vec::new();
    while !map.is_empty() {
        let (key, value) = (map.text()?, map.text()?);
        if remarks::is_key(key) {
            found.push(value);
        }
    }
    Ok(found)
}

/// Reads a message: its channel, when it was recorded [ns], and its content.
pub(super) fn message(data: &[u8]) -> Result<(u16, u64, &[u8]), Error> {
    let mut fields = Fields::new("message", data);
    let channel_id = fields.u16()?;
    let _sequence = fields.u32()?;
    let log_time = fields.u64()?;
    let _publish_time = fields.u64()?;
    Ok((channel_id, log_time, fields.left))
}

/// A chunk: records, compressed or not.
pub(super) struct ChunkRecord<'a> {
    pub(super) uncompressed_size: u64,
    /// CRC-32 of the uncompressed records; 0 if there is none.
    pub(super) crc: u32,
    pub(super) compression: &'a str,
    pub(super) data: &'a [u8],
}

/// Reads a chunk.
pub(super) fn chunk<'a>(data: &'a [u8], limits: &Limits) -> Result<ChunkRecord<'a>, Error> {
    let mut fields = Fields::within("chunk", data, limits);
    let _times = fields.bytes(2 * 8)?;
    let (uncompressed_size, crc) = (fields.u64()?, fields.u32()?);
    let compression = fields.text()?;
    let compressed_size = fields.u64()?;
    Ok(ChunkRecord {
        uncompressed_size,
        crc,
        compression,
        data: fields.bytes(compressed_size)?,
    })
}

/// Reads statistics: how many messages the file says that it holds, and how many by channel.
pub(super) fn statistics(data: &[u8]) -> Result<(u64, Vec<(u16, u64)>), Error> {
    let mut fields = Fields::new("statistics", data);
    let messages = fields.u64()?;
    // Counts of schemas (2 bytes), channels, attachments, metadata and chunks (4 bytes each), then
    // the times of the first and the last message.
    fields.bytes(2 + 4 * 4 + 2 * 8)?;
    let mut block = fields.block()?;
    let mut by_channel = Vec::new();
    while !block.is_empty() {
        by_channel.push((block.u16()?, block.u64()?));
    }
    Ok((messages, by_channel))
}

/// Reads where the chunk starts that a chunk-index record tells of [byte].
pub(super) fn indexed_chunk_start(data: &[u8]) -> Result<u64, Error> {
    let mut fields = Fields::new("chunk index", data);
    fields.bytes(2 * 8)?;
    fields.u64()
}

/// Reads where the footer says that the summary starts [byte]; 0 if there is none.
pub(super) fn summary_start(data: &[u8]) -> Result<u64, Error> {
    Fields::new("footer", data).u64()
}

/// Takes opcode and content of the next record inside a chunk from what is left of it.
pub(super) fn next_in_chunk<'a>(left: &mut &'a [u8]) -> Result<Option<(u8, &'a [u8])>, Error> {
    if left.is_empty() {
        return Ok(None);
    }
    let mut fields = Fields::new("chunk", left);
    let (opcode, length) = (fields.u8()?, fields.u64()?);
    let data = fields.bytes(length)?;
    *left = fields.left;
    Ok(Some((opcode, data)))
}

/// Says what a damaged file should hold, and what it holds.
pub(super) fn damaged(expected: impl Into<String>, found: impl Into<String>) -> Error {
    ErrorKind::Malformed {
        expected: expected.into(),
        found: found.into(),
        hint: "the file is damaged; copy or record it again".into(),
    }
    .into()
}
