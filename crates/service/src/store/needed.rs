//! Which blobs the rows name.

use super::recordings::{self, recording_of};
use super::results::result_of;
use super::sql::rows;
use super::{StoreError, StoredFile, gates};
use rusqlite::Connection;

/// Reads the rows that name blobs and notes which do not fit their hash, and what the others name.
pub(super) fn named(connection: &Connection) -> Result<(Vec<String>, Vec<StoredFile>), StoreError> {
    let (mut damaged, mut named) = (Vec::new(), Vec::new());
    let sql = format!("SELECT {} FROM recordings", recordings::COLUMNS);
    for found in rows(connection, &sql, [], |row| Ok(recording_of(row)))? {
        if let Some((_, recording)) = whole_or_noted(found, &mut damaged)? {
            named.extend(recording.manifest.files);
            named.extend(recording.manifest.card);
        }
    }
    let sql = "SELECT number, report_id, body, sum FROM results";
    for found in rows(connection, sql, [], |row| Ok(result_of(row)))? {
        if let Some((_, result)) = whole_or_noted(found, &mut damaged)? {
            named.extend(result.files.into_values());
        }
    }
    for found in rows(connection, gates::EVERY, [], |row| Ok(gates::gate_of(row)))? {
        if let Some((_, gate)) = whole_or_noted(found, &mut damaged)? {
            let outcome = gate.outcome.into_iter();
            named.extend(outcome.flat_map(|outcome| outcome.files.into_values()));
        }
    }
    Ok((damaged, named))
}

/// Returns what was read, or notes what is damaged.
pub(super) fn whole_or_noted<T>(
    found: Result<T, StoreError>,
    damaged: &mut Vec<String>,
) -> Result<Option<T>, StoreError> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(StoreError::Damaged { what }) => {
            damaged.push(what);
            Ok(None)
        }
        Err(error) => Err(error),
    }
}
