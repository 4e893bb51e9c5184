//! Deleted recordings. The name, the person and the reason of a deletion are kept; the samples are not.

use super::recordings::{self, recording_of};
use super::results::result_of;
use super::sql::{confirmed, page, rows, text_of};
use super::sum::of_row;
use super::{Deletion, Page, StoreError, StoredRecording};
use latchgate::report::VERDICT_FILE;
use rusqlite::{Connection, OptionalExtension, Row, params};
use std::collections::BTreeSet;

pub(super) const COLUMNS: &str = "number, recording, body, sum";

/// A deletion with the hashes of the files that go with it.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct DeletionBody {
    deletion: Deletion,
    files: BTreeSet<String>,
}

pub(super) fn body_of(row: &Row<'_>) -> Result<DeletionBody, StoreError> {
    let (recording, body, sum): (String, String, String) = (row.get(1)?, row.get(2)?, row.get(3)?);
    confirmed("deletion", &recording, &body, &sum)
}

/// Deletes a recording: its row, its files, and every file of its reports except the documents.
/// Returns false if there is none. A damaged row can be deleted, too; its files are then removed with
/// those that no row names.
pub(super) fn delete(
    connection: &Connection,
    id: &str,
    deleted_by: &str,
    why: &str,
    now_ms: i64,
) -> Result<bool, StoreError> {
    let columns = connection
        .query_row(
            "SELECT name, owner, bytes, created_ms FROM recordings WHERE id = ?",
            [id],
            |row| {
                Ok(Deletion {
                    recording: id.into(),
                    name: row.get(0)?,
                    owner: row.get(1)?,
                    bytes: row.get::<_, i64>(2)?.unsigned_abs(),
                    created_ms: row.get(3)?,
                    deleted_ms: now_ms,
                    by: deleted_by.into(),
                    why: why.into(),
                })
            },
        )
        .optional()?;
    let Some(deletion) = columns else {
        return Ok(false);
    };
    let mut files = BTreeSet::new();
    match recordings::find(connection, id) {
        Ok(recording) => {
            let manifest = recording.into_iter().map(|recording| recording.manifest);
            let stored =
                manifest.flat_map(|manifest| manifest.files.into_iter().chain(manifest.card));
            files.extend(stored.map(|file| file.sha256));
        }
        Err(StoreError::Damaged { .. }) => {}
        Err(error) => return Err(error),
    }
    let sql = "SELECT number, report_id, body, sum FROM results WHERE recording = ?";
    let results = rows(connection, sql, [id], |row| {
        Ok((row.get::<_, i64>(0)?, result_of(row)))
    })?;
    for (number, result) in results {
        let Ok((_, mut result)) = result else {
            // A damaged row. Its files are removed with those that no row names.
            connection.execute("DELETE FROM results WHERE number = ?", [number])?;
            continue;
        };
        let (kept, gone) = result
            .files
            .into_iter()
            .partition(|(name, _)| name == VERDICT_FILE);
        result.files = kept;
        result.is_stripped = true;
        files.extend(gone.into_values().map(|file| file.sha256));
        let body = text_of(&result);
        connection.execute(
            "UPDATE results SET body = ?, sum = ? WHERE number = ?",
            params![body, of_row("result", &result.report_id, &body), number],
        )?;
    }
    let body = text_of(&DeletionBody { deletion, files });
    connection.execute(
        "INSERT INTO deletions (recording, body, sum) VALUES (?, ?, ?)",
        params![id, body, of_row("deletion", id, &body)],
    )?;
    connection.execute("DELETE FROM recordings WHERE id = ?", [id])?;
    // A refusal may quote samples of the recording, which must not stay.
    connection.execute(
        "DELETE FROM jobs WHERE state = 'refused' AND json_valid(body)
         AND json_extract(body, '$.recording') = ?",
        [id],
    )?;
    Ok(true)
}

/// Adds files to a deletion: those that a child made of the recording meanwhile.
pub(super) fn extend(
    connection: &Connection,
    id: &str,
    files: &BTreeSet<String>,
) -> Result<(), StoreError> {
    let sql =
        format!("SELECT {COLUMNS} FROM deletions WHERE recording = ? ORDER BY number DESC LIMIT 1");
    let deletions = rows(connection, &sql, [id], |row| {
        Ok((row.get::<_, i64>(0)?, body_of(row)?))
    })?;
    for (number, mut body) in deletions {
        body.files.extend(files.iter().cloned());
        let body = text_of(&body);
        connection.execute(
            "UPDATE deletions SET body = ?, sum = ?, is_open = 1 WHERE number = ?",
            params![body, of_row("deletion", id, &body), number],
        )?;
    }
    Ok(())
}

/// Finds the last deletion of a recording, unless it was uploaded again.
pub(super) fn find(connection: &Connection, id: &str) -> Result<Option<Deletion>, StoreError> {
    let sql = format!(
        "SELECT {COLUMNS} FROM deletions WHERE recording = ?1
         AND NOT EXISTS (SELECT 1 FROM recordings WHERE id = ?1) ORDER BY number DESC LIMIT 1"
    );
    let last = rows(connection, &sql, [id], |row| Ok(body_of(row)))?.pop();
    match last.transpose() {
        // A damaged row still shows that the recording was deleted.
        Err(StoreError::Damaged { .. }) => Ok(Some(Deletion {
            recording: id.into(),
            name: "the recording".into(),
            owner: String::new(),
            bytes: 0,
            created_ms: 0,
            deleted_ms: 0,
            by: "somebody whose name is lost".into(),
            why: "asked".into(),
        })),
        body => Ok(body?.map(|body| body.deletion)),
    }
}

/// Lists deletions, the newest first.
pub(super) fn list(
    connection: &Connection,
    before: Option<i64>,
    limit: u32,
) -> Result<Page<Deletion>, StoreError> {
    let sql =
        format!("SELECT {COLUMNS} FROM deletions WHERE number < ? ORDER BY number DESC LIMIT ?");
    let before = before.unwrap_or(i64::MAX);
    page(connection, &sql, params![before, limit], limit, |row| {
        body_of(row).map(|body| body.deletion)
    })
}

/// Lists the recordings that came before `before_ms`; damaged rows are skipped.
pub(super) fn aged(connection: &Connection, before_ms: i64) -> Result<Vec<String>, StoreError> {
    let sql = format!(
        "SELECT {} FROM recordings WHERE created_ms < ? ORDER BY number",
        recordings::COLUMNS
    );
    let recordings = rows(connection, &sql, [before_ms], |row| Ok(recording_of(row)))?;
    let recordings = recordings.into_iter().filter_map(Result::ok);
    let is_aged = |recording: &StoredRecording| recording.renewed_ms < before_ms;
    let aged = recordings.map(|(_, recording)| recording).filter(is_aged);
    Ok(aged.map(|recording| recording.id).collect())
}

/// Returns the deletions whose files must still be removed, and those files.
pub(super) fn open(connection: &Connection) -> Result<(Vec<i64>, BTreeSet<String>), StoreError> {
    let sql = format!("SELECT {COLUMNS} FROM deletions WHERE is_open");
    let deletions = rows(connection, &sql, [], |row| {
        Ok((row.get::<_, i64>(0)?, body_of(row)))
    })?;
    let (mut numbers, mut files) = (Vec::new(), BTreeSet::new());
    for (number, body) in deletions {
        numbers.push(number);
        match body {
            Ok(body) => files.extend(body.files),
            Err(StoreError::Damaged { what }) => {
                tracing::error!(%what, "its files go with those that no row names");
            }
            Err(error) => return Err(error),
        }
    }
    Ok((numbers, files))
}

/// Notes that the files of deletions were removed.
pub(super) fn close(connection: &Connection, numbers: &[i64]) -> Result<(), StoreError> {
    let mut statement =
        connection.prepare_cached("UPDATE deletions SET is_open = 0 WHERE number = ?")?;
    for number in numbers {
        statement.execute([number])?;
    }
    Ok(())
}
