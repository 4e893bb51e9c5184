//! Which blobs the rows name.

use super::recordings::{self, recording_of};
use super::results::result_of;
use super::{LastRows, StoreError, StoredFile, gates};
use rusqlite::{Connection, Row};
use std::collections::BTreeSet;

/// Reads the rows that name blobs and notes which do not fit their hash, and what the others name.
pub(super) fn named(connection: &Connection) -> Result<(Vec<String>, Vec<StoredFile>), StoreError> {
    let (mut damaged, mut named) = (Vec::new(), Vec::new());
    each(connection, &mut LastRows::default(), |files| {
        named.extend(whole_or_noted(files, &mut damaged)?.unwrap_or_default());
        Ok(())
    })?;
    Ok((damaged, named))
}

/// Finds which of some files rows name that were added after others; returns the last rows, too.
/// Of a row that is damaged nothing is known: an upload or a backup alone can make it whole, and brings
/// its files.
pub(super) fn among(
    connection: &Connection,
    wanted: &BTreeSet<String>,
    after: LastRows,
) -> Result<(BTreeSet<String>, LastRows), StoreError> {
    let (mut needed, mut last, mut damaged) = (BTreeSet::new(), after, Vec::new());
    each(connection, &mut last, |files| {
        let files = whole_or_noted(files, &mut damaged)?.unwrap_or_default();
        let hashes = files.into_iter().map(|file| file.sha256);
        needed.extend(hashes.filter(|sha256| wanted.contains(sha256)));
        Ok(())
    })?;
    Ok((needed, last))
}

/// Reads the rows that name blobs and were added after others, one by one: all together they may be
/// larger than memory. Hands over the files of each, and notes the last rows.
fn each(
    connection: &Connection,
    last: &mut LastRows,
    mut read: impl FnMut(Result<Vec<StoredFile>, StoreError>) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    let of_recording = |row: &Row<'_>| {
        let manifest = recording_of(row)?.1.manifest;
        Ok(manifest.files.into_iter().chain(manifest.card).collect())
    };
    let of_result = |row: &Row<'_>| Ok(result_of(row)?.1.files.into_values().collect());
    let of_gate = |row: &Row<'_>| {
        let outcome = gates::gate_of(row)?.1.outcome;
        let files = outcome.map(|outcome| outcome.files.into_values().collect());
        Ok(files.unwrap_or_default())
    };
    let recordings = format!("SELECT {} FROM recordings", recordings::COLUMNS);
    let results = "SELECT number, report_id, body, sum FROM results";
    stream(
        connection,
        &recordings,
        &mut last.recordings,
        of_recording,
        &mut read,
    )?;
    stream(connection, results, &mut last.results, of_result, &mut read)?;
    stream(
        connection,
        gates::EVERY,
        &mut last.gates,
        of_gate,
        &mut read,
    )
}

fn stream(
    connection: &Connection,
    select: &str,
    last: &mut i64,
    files_of: impl Fn(&Row<'_>) -> Result<Vec<StoredFile>, StoreError>,
    read: &mut impl FnMut(Result<Vec<StoredFile>, StoreError>) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    let mut statement = connection.prepare_cached(&format!("{select} WHERE number > ?"))?;
    let mut rows = statement.query([*last])?;
    while let Some(row) = rows.next()? {
        *last = (*last).max(row.get(0)?);
        read(files_of(row))?;
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
