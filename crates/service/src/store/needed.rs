//! The blobs that rows name.

use super::recordings::{self, recording_of};
use super::results::result_of;
use super::{CheckedFiles, LastRows, StoreError, StoredFile, gates};
use rusqlite::{Connection, Row};
use std::collections::BTreeSet;

/// Reads the rows that name blobs; returns the damaged rows and the files that the others name.
pub(super) fn named(connection: &Connection) -> Result<CheckedFiles, StoreError> {
    let mut checked = CheckedFiles::default();
    each(connection, &mut LastRows::default(), |files| {
        let files = value_or_damage(files, &mut checked.damaged)?;
        checked.files.extend(files.unwrap_or_default());
        Ok(())
    })?;
    Ok(checked)
}

/// Finds the files among `candidates` that rows after the given ones name; returns the last rows, too.
/// The files of a damaged row are not known. Only an upload or a backup can repair it, and brings its
/// files again.
pub(super) fn among(
    connection: &Connection,
    candidates: &BTreeSet<String>,
    after: LastRows,
) -> Result<(BTreeSet<String>, LastRows), StoreError> {
    let (mut needed, mut last, mut damaged) = (BTreeSet::new(), after, Vec::new());
    each(connection, &mut last, |files| {
        let files = value_or_damage(files, &mut damaged)?.unwrap_or_default();
        let hashes = files.into_iter().map(|file| file.sha256);
        needed.extend(hashes.filter(|sha256| candidates.contains(sha256)));
        Ok(())
    })?;
    Ok((needed, last))
}

/// Reads the rows that name blobs and come after `last`, one by one: all of them may be larger than
/// memory. Calls `read` with the files of each, and moves `last` on.
fn each(
    connection: &Connection,
    last: &mut LastRows,
    mut read: impl FnMut(Result<Vec<StoredFile>, StoreError>) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    let recording_files = |row: &Row<'_>| {
        let manifest = recording_of(row)?.1.manifest;
        Ok(manifest.files.into_iter().chain(manifest.card).collect())
    };
    let result_files = |row: &Row<'_>| Ok(result_of(row)?.1.files.into_values().collect());
    let gate_files = |row: &Row<'_>| {
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
        recording_files,
        &mut read,
    )?;
    stream(
        connection,
        results,
        &mut last.results,
        result_files,
        &mut read,
    )?;
    stream(
        connection,
        gates::EVERY,
        &mut last.gates,
        gate_files,
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

/// Returns the value of a row, or adds the row to those that are damaged.
pub(super) fn value_or_damage<T>(
    row: Result<T, StoreError>,
    damaged: &mut Vec<String>,
) -> Result<Option<T>, StoreError> {
    match row {
        Ok(value) => Ok(Some(value)),
        Err(StoreError::Damaged { what }) => {
            damaged.push(what);
            Ok(None)
        }
        Err(error) => Err(error),
    }
}
