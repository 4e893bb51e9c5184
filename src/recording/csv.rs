//! Text tables.

use super::{Limits, ReadOptions, ReadOutcome, Selection, source::Reader};
use crate::error::Error;

/// Tells whether the head looks like text.
#[must_use]
pub fn recognises(_head: &[u8], _file_name: &str) -> bool {
    true
}

/// Reads a text table.
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
