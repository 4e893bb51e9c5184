//! Recordings as rows.

use super::sql::{confirmed, page, rows};
use super::{
    ListedRecording, Manifest, Page, RecordingFilter, RecordingOrder, StoreError, StoredRecording,
};
use rusqlite::{Connection, Row, params};

/// The part of a recording that does not change.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct RecordingBody {
    pub(super) manifest: Manifest,
    pub(super) created_ms: i64,
    #[serde(default)]
    pub(super) renewed_ms: i64,
}

/// The part of a body that a list needs: an upload may have hundreds of files.
#[derive(serde::Deserialize)]
struct ListedBody {
    manifest: ListedManifest,
    created_ms: i64,
}

#[derive(serde::Deserialize)]
struct ListedManifest {
    name: String,
    files: Vec<ListedFile>,
    card: Option<ListedFile>,
}

#[derive(serde::Deserialize)]
struct ListedFile {
    bytes: u64,
}

pub(super) const COLUMNS: &str = "number, id, body, sum, listing, listing_sum, owner";

pub(super) fn recording_of(row: &Row<'_>) -> Result<(i64, StoredRecording), StoreError> {
    let (id, body, sum): (String, String, String) = (row.get(1)?, row.get(2)?, row.get(3)?);
    let body: RecordingBody = confirmed("recording", &id, &body, &sum)?;
    let listing: Option<String> = row.get(4)?;
    let listing = match listing {
        None => None,
        Some(listing) => {
            let sum: String = row.get(5)?;
            Some(confirmed("listing", &id, &listing, &sum)?)
        }
    };
    let recording = StoredRecording {
        id,
        manifest: body.manifest,
        owner: row.get(6)?,
        created_ms: body.created_ms,
        renewed_ms: body.renewed_ms.max(body.created_ms),
        listing,
    };
    Ok((row.get(0)?, recording))
}

pub(super) fn find(
    connection: &Connection,
    id: &str,
) -> Result<Option<StoredRecording>, StoreError> {
    let sql = format!("SELECT {COLUMNS} FROM recordings WHERE id = ?");
    let last = rows(connection, &sql, [id], recording_of)?.pop();
    Ok(last.map(|(_, recording)| recording))
}

/// Lists recordings, without their listings.
pub(super) fn list(
    connection: &Connection,
    filter: &RecordingFilter,
) -> Result<Page<ListedRecording>, StoreError> {
    let (order, before, skipped) = match (filter.order, filter.after) {
        (RecordingOrder::Newest, after) => ("number DESC", after.unwrap_or(i64::MAX), 0),
        (RecordingOrder::Oldest, after) => ("number", i64::MAX, after.unwrap_or(0)),
        (RecordingOrder::Name, after) => {
            ("name COLLATE NOCASE, number", i64::MAX, after.unwrap_or(0))
        }
        (RecordingOrder::Size, after) => ("bytes DESC, number", i64::MAX, after.unwrap_or(0)),
        (RecordingOrder::Owner, after) => (
            "owner COLLATE NOCASE, number DESC",
            i64::MAX,
            after.unwrap_or(0),
        ),
    };
    let sql = format!(
            "SELECT number, id, body, sum, NULL, NULL, owner,
                 CASE WHEN json_valid(listing) THEN json_array_length(listing, '$.channels') END,
                 (SELECT count(*) FROM results WHERE results.recording = recordings.id)
             FROM recordings
             WHERE number < ?1 AND (?2 IS NULL OR instr(lower(name || char(10) || owner || char(10) || id), ?2) > 0)
             ORDER BY {order} LIMIT ?3 OFFSET ?4"
        );
    let text = filter.text.as_ref().map(|text| text.to_ascii_lowercase());
    let parameters = params![before, text, filter.limit, skipped];
    let mut recordings = page(connection, &sql, parameters, filter.limit, |row| {
        let channels: Option<i64> = row.get(7)?;
        let (id, body, sum): (String, String, String) = (row.get(1)?, row.get(2)?, row.get(3)?);
        let body: ListedBody = confirmed("recording", &id, &body, &sum)?;
        let files = body.manifest.files.iter().chain(&body.manifest.card);
        Ok(ListedRecording {
            id,
            bytes: files.map(|file| file.bytes).sum(),
            name: body.manifest.name,
            owner: row.get(6)?,
            created_ms: body.created_ms,
            channels: channels.map(i64::unsigned_abs),
            verdicts: row.get::<_, i64>(8)?.unsigned_abs(),
        })
    })?;
    if filter.order != RecordingOrder::Newest && recordings.next.is_some() {
        recordings.next = Some(skipped + i64::from(filter.limit));
    }
    Ok(recordings)
}
