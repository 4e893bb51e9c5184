//! Which blobs the rows name.

use super::recordings::{self, recording_of};
use super::results::result_of;
use super::sql::rows;
use super::{LastRows, StoreError, StoredFile, gates};
use rusqlite::{Connection, Row};
use std::collections::BTreeSet;

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

/// Finds which of some files rows name that were added after others; returns the last rows, too.
/// Of a row that is damaged nothing is known: an upload or a backup alone can make it whole, and brings
/// its files.
pub(super) fn among(
    connection: &Connection,
    files: &BTreeSet<String>,
    after: LastRows,
) -> Result<(BTreeSet<String>, LastRows), StoreError> {
    let (mut needed, mut last) = (BTreeSet::new(), after);
    let mut add = |named: Vec<StoredFile>| {
        let named = named.into_iter().map(|file| file.sha256);
        needed.extend(named.filter(|sha256| files.contains(sha256)));
    };
    let sql = format!(
        "SELECT {} FROM recordings WHERE number > ?",
        recordings::COLUMNS
    );
    each(connection, &sql, &mut last.recordings, |row| {
        let (_, recording) = recording_of(row)?;
        add(recording.manifest.files);
        add(recording.manifest.card.into_iter().collect());
        Ok(())
    })?;
    let sql = "SELECT number, report_id, body, sum FROM results WHERE number > ?";
    each(connection, sql, &mut last.results, |row| {
        add(result_of(row)?.1.files.into_values().collect());
        Ok(())
    })?;
    let sql = format!("{} WHERE number > ?", gates::EVERY);
    each(connection, &sql, &mut last.gates, |row| {
        let outcome = gates::gate_of(row)?.1.outcome.into_iter();
        add(outcome.flat_map(|own| own.files.into_values()).collect());
        Ok(())
    })?;
    Ok((needed, last))
}

/// Reads the rows after one, one by one.
fn each(
    connection: &Connection,
    sql: &str,
    last: &mut i64,
    mut read: impl FnMut(&Row<'_>) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    let mut statement = connection.prepare_cached(sql)?;
    let mut rows = statement.query([*last])?;
    while let Some(row) = rows.next()? {
        *last = (*last).max(row.get(0)?);
        match read(row) {
            Ok(()) | Err(StoreError::Damaged { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
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
