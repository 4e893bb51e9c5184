//! Encodings: from a file's bytes to UTF-8 text whose lines end with a line feed.

use super::text::line_at;
use super::{Finding, Limits};
use crate::error::{Error, Place};

/// Characters of Windows-1252 from 0x80 to 0x9F. The five bytes that it leaves undefined keep
/// their Latin-1 control characters, as WHATWG's Encoding Standard has it.
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}',
    '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

/// Tells whether the head looks like text: marked UTF-16, or free of control characters
/// other than tab, line ends and form feed.
pub(super) fn looks_like_text(head: &[u8]) -> bool {
    if is_utf_16(head) {
        return true;
    }
    let body = head.strip_suffix(b"\x1a").unwrap_or(head);
    !body
        .iter()
        .any(|byte| matches!(byte, 0x00..=0x08 | 0x0E..=0x1F | 0x7F))
}

/// Decodes a file to UTF-8 with `\n` or `\r\n` at its line ends.
///
/// # Errors
///
/// [`ErrorKind::LimitExceeded`] if the decoded text, together with the file's own bytes if these
/// are UTF-16, takes more than `text_bytes`; [`ErrorKind::Malformed`] at the line where the bytes are not in the encoding that the file
/// is marked with, or hold a NUL character.
pub(super) fn decode(bytes: Vec<u8>, limits: &Limits) -> Result<(Vec<u8>, Vec<Finding>), Error> {
    let mut findings = Vec::new();
    let mut text = if is_utf_16(&bytes) {
        decode_utf_16(&bytes, limits)?
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
            "the text is not UTF-8 and was read as Windows-1252; only names and comments depend \
             on it",
        ));
        decode_windows_1252(bytes, limits)?
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

fn is_utf_16(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF")
}

fn decode_utf_16(bytes: &[u8], limits: &Limits) -> Result<Vec<u8>, Error> {
    let little = bytes[0] == 0xFF;
    let pairs = bytes[2..].chunks(2);
    let units = pairs.map(|pair| match (pair, little) {
        ([low, high], true) | ([high, low], false) => u16::from_le_bytes([*low, *high]),
        // Half of a pair of units, which is wrong alone.
        _ => 0xD800,
    });
    let length = |unit: u16| match unit {
        0..=0x7F => 1,
        0x80..=0x7FF | 0xD800..=0xDFFF => 2,
        _ => 3,
    };
    let needed: usize = units.clone().map(length).sum();
    // Both are held while one is made of the other.
    if (needed + bytes.len()) as u64 > limits.text_bytes {
        return Err(too_long(limits));
    }
    let mut text = String::with_capacity(needed);
    for character in char::decode_utf16(units) {
        let wrong = |_| wrong_encoding("UTF-16", line_at(text.as_bytes(), text.len()));
        let character = character.map_err(wrong)?;
        text.push(character);
    }
    Ok(text.into_bytes())
}

/// Widens the bytes in place, from the end, so that no second copy of the file is held.
fn decode_windows_1252(mut bytes: Vec<u8>, limits: &Limits) -> Result<Vec<u8>, Error> {
    let of = |byte: u8| match byte {
        0x80..=0x9F => WINDOWS_1252[usize::from(byte - 0x80)],
        other => char::from(other),
    };
    let old = bytes.len();
    let more: usize = bytes
        .iter()
        .filter(|byte| !byte.is_ascii())
        .map(|byte| of(*byte).len_utf8() - 1)
        .sum();
    if (old + more) as u64 > limits.text_bytes {
        return Err(too_long(limits));
    }
    bytes.reserve_exact(more);
    bytes.resize(old + more, 0);
    let mut end = bytes.len();
    for index in (0..old).rev() {
        if end == index + 1 {
            // All that is left is ASCII and stands where it belongs.
            break;
        }
        let mut buffer = [0; 4];
        let encoded = of(bytes[index]).encode_utf8(&mut buffer).as_bytes();
        end -= encoded.len();
        bytes[end..end + encoded.len()].copy_from_slice(encoded);
    }
    Ok(bytes)
}

fn too_long(limits: &Limits) -> Error {
    limits
        .over("text_bytes", "more bytes once decoded to UTF-8")
        .at(Place::default().byte(limits.text_bytes))
}

/// Turns a carriage return that stands alone, the line end of old Macintosh files, into a
/// line feed.
fn end_lines_with_line_feeds(text: &mut [u8]) {
    if memchr::memchr(b'\r', text).is_none() {
        return;
    }
    let mut from = 0;
    while let Some(found) = memchr::memchr(b'\r', &text[from..]) {
        let index = from + found;
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
