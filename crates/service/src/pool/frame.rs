//! Frames: a length of four bytes, little-endian, then so many bytes of JSON.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::{self, Read, Write};

/// Largest frame [bytes].
const FRAME_BYTES: u32 = 16 << 20;

/// Size of a piece that is copied [bytes].
const PIECE: usize = 64 << 10;

pub(super) fn write(out: &mut impl Write, words: &impl Serialize) -> io::Result<()> {
    let text = serde_json::to_vec(words)?;
    let length = u32::try_from(text.len())
        .ok()
        .filter(|length| *length <= FRAME_BYTES);
    let length = length.ok_or_else(|| io::Error::other("a frame is too long"))?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&text)
}

/// Reads a frame; `None` if the other side has closed the pipe between two frames.
pub(super) fn read<T: DeserializeOwned>(input: &mut impl Read) -> io::Result<Option<T>> {
    let mut length = [0; 4];
    match input.read_exact(&mut length) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        other => other?,
    }
    let length = u32::from_le_bytes(length);
    if length > FRAME_BYTES {
        return Err(io::Error::other("a frame is too long"));
    }
    let mut text = vec![0; length as usize];
    input.read_exact(&mut text)?;
    Ok(Some(serde_json::from_slice(&text)?))
}

/// Reads `bytes` bytes and passes them to `take` piece by piece.
pub(super) fn copy(
    input: &mut impl Read,
    bytes: u64,
    mut take: impl FnMut(&[u8]) -> io::Result<()>,
) -> io::Result<()> {
    let mut piece = vec![0; PIECE];
    let mut bytes_left = bytes;
    while bytes_left > 0 {
        let length = usize::try_from(bytes_left).map_or(PIECE, |bytes_left| bytes_left.min(PIECE));
        input.read_exact(&mut piece[..length])?;
        take(&piece[..length])?;
        bytes_left -= length as u64;
    }
    Ok(())
}
