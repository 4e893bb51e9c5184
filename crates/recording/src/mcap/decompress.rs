//! Chunks: decompression within limits, checked against the chunk's own size and checksum.

use super::records::damaged;
use crate::Limits;
use crate::error::Error;
use ::mcap::records::ChunkHeader;
use std::borrow::Cow;
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Window that a zstd frame may always ask for [byte]: what the highest ordinary level of the
/// reference encoder uses. The decoder holds back up to a window of what it has produced.
const ZSTD_WINDOW_BYTES: u64 = 8 << 20;

/// Returns the records inside a chunk.
pub(super) fn records<'a>(
    chunk: &ChunkHeader,
    data: &'a [u8],
    limits: &Limits,
) -> Result<Cow<'a, [u8]>, Error> {
    let size = chunk.uncompressed_size;
    if size > limits.mcap_chunk_bytes {
        return Err(limits.over("mcap_chunk_bytes", format!("a chunk of {size} bytes")));
    }
    let records = match chunk.compression.as_str() {
        "" => Cow::Borrowed(data),
        "zstd" => Cow::Owned(guarded("zstd", || zstd(data, size, limits))?),
        "lz4" => Cow::Owned(guarded("lz4", || lz4(data, size))?),
        method => {
            return Err(Error::malformed(
                "a chunk compressed with zstd or lz4, or not at all",
                format!("compression `{method}`"),
                "rewrite the file with `mcap compress`",
            ));
        }
    };
    let unpacked_bytes = records.len() as u64;
    let expected = format!("{size} bytes in the chunk, as its header says");
    if unpacked_bytes > size {
        return Err(damaged(expected, "more"));
    }
    if unpacked_bytes < size {
        return Err(Error::truncated(expected, unpacked_bytes.to_string()));
    }
    if chunk.uncompressed_crc != 0 {
        let crc = crc32fast::hash(&records);
        if crc != chunk.uncompressed_crc {
            return Err(damaged(
                format!("checksum {:08x} of the chunk", chunk.uncompressed_crc),
                format!("{crc:08x}"),
            ));
        }
    }
    Ok(records)
}

/// Runs a decompressor so that a panic inside it, on damaged data, ends in an error.
fn guarded(
    name: &'static str,
    run: impl FnOnce() -> Result<Vec<u8>, String>,
) -> Result<Vec<u8>, Error> {
    let reason = match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(bytes)) => return Ok(bytes),
        Ok(Err(reason)) => reason,
        Err(_) => "the decompressor gave up".into(),
    };
    Err(damaged(
        format!("a chunk compressed with {name}"),
        format!("data that do not decompress ({reason})"),
    ))
}

/// Unpacks frame by frame up to one byte beyond `size`; `frame` reads one from the front of its
/// first argument. Some writers leave bytes behind the last frame, so these are not looked at.
fn frames(
    mut data_left: &[u8],
    size: u64,
    mut frame: impl FnMut(&mut &[u8], u64, &mut Vec<u8>) -> Result<(), String>,
) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    while !data_left.is_empty() && (bytes.len() as u64) < size {
        let room = size + 1 - bytes.len() as u64;
        frame(&mut data_left, room, &mut bytes)?;
    }
    Ok(bytes)
}

fn zstd(data: &[u8], size: u64, limits: &Limits) -> Result<Vec<u8>, String> {
    let window = limits.mcap_chunk_bytes.max(ZSTD_WINDOW_BYTES);
    frames(data, size, |data_left, room, bytes| {
        let decoder =
            ruzstd::decoding::StreamingDecoder::new_with_max_window_size(&mut *data_left, window);
        let mut decoder = decoder.map_err(|error| error.to_string())?;
        let read = (&mut decoder).take(room).read_to_end(bytes);
        read.map_err(|error| error.to_string())?;
        let frame = decoder.into_frame_decoder();
        let stated_checksum = frame.get_checksum_from_data();
        let is_whole = frame.is_finished() && frame.can_collect() == 0;
        if is_whole
            && stated_checksum.is_some()
            && stated_checksum != frame.get_calculated_checksum()
        {
            return Err("the checksum of the frame is wrong".into());
        }
        Ok(())
    })
}

fn lz4(data: &[u8], size: u64) -> Result<Vec<u8>, String> {
    frames(data, size, |data_left, room, bytes| {
        let decoder = lz4_flex::frame::FrameDecoder::new(&mut *data_left);
        let read = decoder.take(room).read_to_end(bytes);
        read.map(|_| ()).map_err(|error| error.to_string())
    })
}
