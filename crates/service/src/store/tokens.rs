//! Tokens and sessions by their hashes.

use super::sql::rows;
use super::{StoreError, StoredSession, StoredToken};
use rusqlite::{Connection, params};

/// Largest number of sessions of one token; beyond it the one that was unused for longest ends.
const SESSIONS: i64 = 20;

pub(super) fn put(connection: &Connection, token: &StoredToken) -> Result<i64, StoreError> {
    connection.execute(
        "INSERT INTO tokens (sha256, name, label, scopes, created_ms, ends_ms) VALUES (?, ?, ?, ?, ?, ?)",
        params![
            token.sha256,
            token.name,
            token.label,
            token.scopes,
            token.created_ms,
            token.ends_ms
        ],
    )?;
    Ok(connection.last_insert_rowid())
}

pub(super) fn list(connection: &Connection) -> Result<Vec<StoredToken>, StoreError> {
    rows(
        connection,
        "SELECT number, sha256, name, label, scopes, created_ms, ends_ms, used_ms, revoked
         FROM tokens ORDER BY name, number",
        [],
        |row| {
            Ok(StoredToken {
                number: row.get(0)?,
                sha256: row.get(1)?,
                name: row.get(2)?,
                label: row.get(3)?,
                scopes: row.get(4)?,
                created_ms: row.get(5)?,
                ends_ms: row.get(6)?,
                used_ms: row.get(7)?,
                revoked: row.get(8)?,
            })
        },
    )
}

/// Revokes a token at once, with its sessions, or lets it end at `ends_ms`.
pub(super) fn end(
    connection: &Connection,
    number: i64,
    ends_ms: Option<i64>,
) -> Result<(), StoreError> {
    match ends_ms {
        Some(ends_ms) => connection.execute(
            "UPDATE tokens SET ends_ms = min(coalesce(ends_ms, ?2), ?2) WHERE number = ?1",
            params![number, ends_ms],
        )?,
        None => {
            connection.execute("DELETE FROM sessions WHERE token = ?", [number])?;
            connection.execute("UPDATE tokens SET revoked = 1 WHERE number = ?", [number])?
        }
    };
    Ok(())
}

pub(super) fn used(connection: &Connection, number: i64, now_ms: i64) -> Result<(), StoreError> {
    connection.execute(
        "UPDATE tokens SET used_ms = ?2 WHERE number = ?1",
        params![number, now_ms],
    )?;
    Ok(())
}

pub(super) fn put_session(
    connection: &Connection,
    session: &StoredSession,
) -> Result<(), StoreError> {
    connection.execute(
        "INSERT INTO sessions (sha256, token, created_ms, seen_ms) VALUES (?1, ?2, ?3, ?4)
         ON CONFLICT (sha256) DO UPDATE SET seen_ms = ?4",
        params![
            session.sha256,
            session.token,
            session.created_ms,
            session.seen_ms
        ],
    )?;
    connection.execute(
        "DELETE FROM sessions WHERE token = ?1 AND sha256 NOT IN (
             SELECT sha256 FROM sessions WHERE token = ?1 ORDER BY seen_ms DESC LIMIT ?2)",
        params![session.token, SESSIONS],
    )?;
    Ok(())
}

pub(super) fn sessions(connection: &Connection) -> Result<Vec<StoredSession>, StoreError> {
    rows(
        connection,
        "SELECT sha256, token, created_ms, seen_ms FROM sessions",
        [],
        |row| {
            Ok(StoredSession {
                sha256: row.get(0)?,
                token: row.get(1)?,
                created_ms: row.get(2)?,
                seen_ms: row.get(3)?,
            })
        },
    )
}

pub(super) fn end_session(connection: &Connection, sha256: &str) -> Result<(), StoreError> {
    connection.execute("DELETE FROM sessions WHERE sha256 = ?", [sha256])?;
    Ok(())
}
