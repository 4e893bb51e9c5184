//! Encodings: from a file's bytes to UTF-8 text whose lines end with a line feed.

use super::text::line_at;
use super::{Finding, Limits};
use crate::error::{Error, Place};
use encoding_rs::{DecoderResult, Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// True if the head looks like text: marked UTF-16, or free of control characters
/// other than tab, line ends and form feed.
pub(super) fn looks_like_text(head: &[u8]) -> bool {
    if is_utf_16(head) {
        return true;
    }
    let body = head.strip_suffix(b"\x1a").unwrap_or(head);
    let is_control = |byte: &u8| matches!(byte, 0x00..=0x08 | 0x0E..=0x1F | 0x7F);
    !body.iter().any(is_control)
}

/// Returns the start of a file as text, by its byte order mark, else as UTF-8.
pub(super) fn head_of(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    encoding_rs::UTF_8.decode(bytes).0
}

/// Decodes a file to UTF-8 with `\n` or `\r\n` at its line ends.
pub(super) fn decode(bytes: Vec<u8>, limits: &Limits) -> Result<(Vec<u8>, Vec<Finding>), Error> {
    let mut findings = Vec::new();
    let mut text = if is_utf_16(&bytes) {
        let little = bytes[0] == 0xFF;
        let encoding = if little { UTF_16LE } else { UTF_16BE };
        decoded(&bytes, encoding, 2, limits)?
    } else if bytes.starts_with(b"\xEF\xBB\xBF") {
        let mut body = bytes;
        body.drain(..3);
        if let Err(error) = std::str::from_utf8(&body) {
            return Err(wrong_encoding("UTF-8", line_at(&body, error.valid_up_to())));
        }
        body
    } else if std::str::from_utf8(&bytes).is_ok() {
        bytes
    } else {
        findings.push(Finding::info(
            "encoding-assumed",
            "the text is not UTF-8. It was read as Windows-1252. Only names and comments depend on \
             that",
        ));
        decoded(&bytes, WINDOWS_1252, 0, limits)?
    };
    // Text files of DOS may end with Ctrl-Z.
    if text.last() == Some(&0x1A) {
        text.pop();
    }
    if let Some(position) = memchr::memchr(0, &text) {
        return Err(Error::malformed(
            "text",
            "a NUL character",
            "the file is binary, damaged, or UTF-16 without its mark; export it as UTF-8",
        )
        .at(Place::default().line(line_at(&text, position))));
    }
    end_lines_with_line_feeds(&mut text);
    Ok((text, findings))
}

/// Decodes a text and refuses one with a line that is too long.
pub(super) fn text_of(bytes: Vec<u8>, limits: &Limits) -> Result<(String, Vec<Finding>), Error> {
    let (bytes, findings) = decode(bytes, limits)?;
    let mut start = 0_u64;
    for (index, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        if line.len() as u64 > limits.line_bytes {
            let place = Place::default().line(index as u64 + 1);
            let place = place.byte(start + limits.line_bytes);
            return Err(limits.over("line_bytes", "a longer line").at(place));
        }
        start += line.len() as u64 + 1;
    }
    let text = String::from_utf8(bytes);
    let lossy =
        |error: std::string::FromUtf8Error| String::from_utf8_lossy(error.as_bytes()).into();
    Ok((text.unwrap_or_else(lossy), findings))
}

fn is_utf_16(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF")
}

/// Decodes the text after a byte order mark of `mark` bytes. The result and the bytes are both in memory
/// until it is complete, so that the limit counts both.
fn decoded(
    bytes: &[u8],
    encoding: &'static Encoding,
    mark: usize,
    limits: &Limits,
) -> Result<Vec<u8>, Error> {
    let room = limits.text_bytes.saturating_sub(bytes.len() as u64);
    let room = usize::try_from(room).unwrap_or(usize::MAX);
    let mut decoder = encoding.new_decoder_without_bom_handling();
    let longest = decoder.max_utf8_buffer_length_without_replacement(bytes.len());
    let mut text = vec![0; longest.map_or(room, |longest| longest.min(room))];
    let (result, _, written) =
        decoder.decode_to_utf8_without_replacement(&bytes[mark..], &mut text, true);
    text.truncate(written);
    match result {
        DecoderResult::InputEmpty => Ok(text),
        DecoderResult::OutputFull => {
            let error = limits.over("text_bytes", "more bytes once decoded to UTF-8");
            Err(error.at(Place::default().byte(limits.text_bytes)))
        }
        DecoderResult::Malformed(..) => Err(wrong_encoding("UTF-16", line_at(&text, written))),
    }
}

/// Turns a lone carriage return, the line end of old Macintosh files, into a line feed.
fn end_lines_with_line_feeds(text: &mut [u8]) {
    if memchr::memchr(b'\r', text).is_none() {
        return;
    }
    let mut from = 0;
    while let Some(offset) = memchr::memchr(b'\r', &text[from..]) {
        let index = from + offset;
        if text.get(index + 1) != Some(&b'\n') {
            text[index] = b'\n';
        }
        from = index + 1;
    }
}

fn wrong_encoding(name: &str, line: u64) -> Error {
    Error::malformed(
        format!("{name}, as the file is marked"),
        "other bytes",
        "the file is damaged or cut; export it again",
    )
    .at(Place::default().line(line))
}
