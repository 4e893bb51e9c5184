//! The hash of every row, by which a damaged row is detected and not served.

use sha2::{Digest, Sha256};
use std::fmt;
use std::io::{self, Read};

/// Returns the SHA-256 of bytes, lower-case hexadecimal.
pub fn sha256_hex(bytes: &[u8]) -> String {
    Hex(&Sha256::digest(bytes)).to_string()
}

/// Returns the SHA-256 of a file or stream, lower-case hexadecimal.
///
/// # Errors
///
/// Those of reading.
pub fn sha256_of(mut from: impl Read) -> io::Result<String> {
    let mut hash = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    loop {
        match from.read(&mut piece)? {
            0 => return Ok(Hex(&hash.finalize()).to_string()),
            count => hash.update(&piece[..count]),
        }
    }
}

/// Bytes that are shown as lower-case hexadecimal.
#[derive(Debug, Clone, Copy)]
pub struct Hex<'a>(pub &'a [u8]);

impl fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Returns the hash of a row: of its key and its body, with their lengths between.
pub(super) fn of_row(table: &str, key: &str, body: &str) -> String {
    sha256_hex(format!("{table}\0{}\0{key}{body}", key.len()).as_bytes())
}
