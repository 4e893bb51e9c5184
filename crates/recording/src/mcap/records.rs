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
            other => other.to_string(),
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

/// Sees to it that no text of a record claims to be longer than what is left of the record: the
/// crate asks for the memory of a text before it reads it. `None` if one does.
///
/// A map ends for the crate where an entry reaches its length or goes beyond it, so it does here.
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
    let mut left = data.get(before..)?;
    for _ in 0..texts {
        take_text(&mut left)?;
    }
    let map = match is_map_next {
        true => take_length(&mut left)?,
        false => 0,
    };
    let end = left.len().saturating_sub(map);
    while left.len() > end {
        take_text(&mut left)?;
        take_text(&mut left)?;
    }
    Some(())
}

fn take_length(left: &mut &[u8]) -> Option<usize> {
    let (length, rest) = left.split_first_chunk()?;
    *left = rest;
    Some(u32::from_le_bytes(*length) as usize)
}

/// Takes a length of four bytes, and as many bytes as it says.
fn take_text(left: &mut &[u8]) -> Option<()> {
    let length = take_length(left)?;
    *left = left.get(length..)?;
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

/// Returns the values of a map whose keys say that a person wrote them.
pub(super) fn comments(map: &BTreeMap<String, String>) -> impl Iterator<Item = &str> {
    let said = map.iter().filter(|(key, _)| remarks::is_key(key));
    said.map(|(_, value)| value.as_str())
}

/// Takes opcode and content of the next record inside a chunk from what is left of it.
pub(super) fn next_in_chunk<'a>(left: &mut &'a [u8]) -> Result<Option<(u8, &'a [u8])>, Error> {
    if left.is_empty() {
        return Ok(None);
    }
    let next = left
        .split_first_chunk::<PREFIX_BYTES>()
        .and_then(|(prefix, rest)| {
            let [opcode, length @ ..] = *prefix;
            let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
            let (data, rest) = rest.split_at_checked(length)?;
            *left = rest;
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
