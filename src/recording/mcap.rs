//! MCAP logs.

use super::{Limits, ReadOptions, ReadOutcome, Selection, source::Reader};
use crate::error::Error;

/// Tells whether the head carries MCAP's magic bytes.
#[must_use]
pub fn recognises(head: &[u8], _file_name: &str) -> bool {
    head.starts_with(b"\x89MCAP0\r\n")
}

/// Reads an MCAP log.
///
/// # Errors
///
/// Any kind of the reader.
pub fn read(
    _source: &mut Reader,
    _options: &ReadOptions,
    _selection: Selection,
    _limits: &Limits,
) -> Result<ReadOutcome, Error> {
    Ok(ReadOutcome::default())
}
