//! The records of an MCAP file, read by the `mcap` crate with checked lengths.

use crate::error::Error;
use crate::{Limits, remarks};
use ::mcap::McapError;
use ::mcap::records::{Record, op};
use std::collections::BTreeMap;

/// Bytes of opcode and length before each record.
pub(super) const PREFIX_BYTES: usize = 9;

/// Reads the fields of a record.
pub(super) fn parse(opcode: u8, data: &[u8]) -> Result<Record<'_>, Error> {
    let parsed = match texts_fit(opcode, data) {
        Some(()) => ::mcap::parse_record(opcode, data).map_err(|error| match &error {
            McapError::Parse(error) => error.root_cause().to_string(),
            error => error.to_string(),
        }),
        None => Err("one that ends within a text, as the text's length field says".into()),
    };
    parsed.map_err(|found| {
        let what = match opcode {
            op::FOOTER => "footer",
            op::SCHEMA => "schema",
            op::CHANNEL => "channel",
            op::MESSAGE => "message",
            op::CHUNK => "chunk",
            op::CHUNK_INDEX => "chunk index",
            op::STATISTICS => "statistics",
            _ => "metadata",
        };
        damaged(format!("a whole {what} record"), found)
    })
}

/// Checks that no text of a record claims to be longer than the bytes that are left of the record;
/// `None` if one does. The crate allocates the memory of a text before it reads it.
///
/// The crate ends a map where an entry reaches its length or goes beyond it, so this does too.
fn texts_fit(opcode: u8, data: &[u8]) -> Option<()> {
    // Bytes before the texts, the texts, and whether a map of texts follows.
    let (before, texts, is_map_next) = match opcode {
        op::SCHEMA => (2, 2, false),
        op::CHANNEL => (4, 2, true),
        op::CHUNK => (28, 1, false),
        op::CHUNK_INDEX => {
            let offsets = take_length(&mut data.get(32..)?)?.div_ceil(10);
            (
                offsets.saturating_mul(10).saturating_add(32 + 4 + 8),
                1,
                false,
            )
        }
        op::METADATA => (0, 1, true),
        _ => return Some(()),
    };
    let mut bytes_left = data.get(before..)?;
    for _ in 0..texts {
        take_text(&mut bytes_left)?;
    }
    let map = match is_map_next {
        true => take_length(&mut bytes_left)?,
        false => 0,
    };
    let end = bytes_left.len().saturating_sub(map);
    while bytes_left.len() > end {
        take_text(&mut bytes_left)?;
        take_text(&mut bytes_left)?;
    }
    Some(())
}

fn take_length(bytes_left: &mut &[u8]) -> Option<usize> {
    let (length, tail) = bytes_left.split_first_chunk()?;
    *bytes_left = tail;
    Some(u32::from_le_bytes(*length) as usize)
}

/// Takes a length of four bytes, and as many bytes as it says.
fn take_text(bytes_left: &mut &[u8]) -> Option<()> {
    let length = take_length(bytes_left)?;
    *bytes_left = bytes_left.get(length..)?;
    Some(())
}

/// Refuses texts that are longer than allowed.
pub(super) fn check_texts(texts: &[&str], what: &str, limits: &Limits) -> Result<(), Error> {
    let long = |text: &&&str| text.len() as u64 > limits.mcap_string_bytes;
    match texts.iter().find(long) {
        Some(text) => Err(too_long(limits.mcap_string_bytes, text.len() as u64, what)),
        None => Ok(()),
    }
}

/// Returns an error for a text that claims to be longer than allowed.
pub(super) fn too_long(limit: u64, found: u64, what: &str) -> Error {
    let found = format!("a string of {found} bytes in a {what}, as its length field says");
    Error::over("mcap_string_bytes", limit, found)
}

/// Returns the values of a map whose keys say that they are comments.
pub(super) fn comments(map: &BTreeMap<String, String>) -> impl Iterator<Item = &str> {
    let entries = map.iter().filter(|(key, _)| remarks::is_key(key));
    entries.map(|(_, value)| value.as_str())
}

/// Takes opcode and content of the next record inside a chunk from what is left of it.
pub(super) fn next_in_chunk<'a>(
    records_left: &mut &'a [u8],
) -> Result<Option<(u8, &'a [u8])>, Error> {
    if records_left.is_empty() {
        return Ok(None);
    }
    let next = records_left
        .split_first_chunk::<PREFIX_BYTES>()
        .and_then(|(prefix, content)| {
            let [opcode, length @ ..] = *prefix;
            let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
            let (data, tail) = content.split_at_checked(length)?;
            *records_left = tail;
            Some((opcode, data))
        });
    let missing = || damaged("more bytes in the chunk record", "its end in a record");
    next.map(Some).ok_or_else(missing)
}

/// Says what a damaged file should hold, and what it holds.
pub(super) fn damaged(expected: impl Into<String>, found: impl Into<String>) -> Error {
    let hint = "the file is damaged; copy or record it again";
    Error::malformed(expected, found, hint)
}
