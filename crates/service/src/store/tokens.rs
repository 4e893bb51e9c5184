//! Tokens and sessions by their hashes. A row that does not fit its sum grants nothing.

use super::sql::{page, rows, text_of};
use super::sum::of_row;
use super::{Page, StoreError, StoredSession, StoredToken};
use rusqlite::{Connection, Row, params};

/// Largest number of sessions of one token; beyond it the one that was unused for longest ends.
const SESSIONS: i64 = 20;

/// Reads every token.
const EVERY_TOKEN: &str =
    "SELECT number, sha256, name, label, scopes, created_ms, ends_ms, used_ms, revoked, sum
     FROM tokens ORDER BY name, number";

/// Reads every session, its number in the table first.
const EVERY_SESSION: &str = "SELECT rowid, sha256, token, created_ms, seen_ms, sum FROM sessions";

/// Returns the sum of a token's row. The time of its last use is left out: nothing depends on it.
fn token_sum(token: &StoredToken) -> String {
    let StoredToken {
        number,
        sha256,
        name,
        label,
        scopes,
        created_ms,
        ends_ms,
        used_ms: _,
        revoked,
    } = token;
    let body = (sha256, name, label, scopes, created_ms, ends_ms, revoked);
    of_row("token", &number.to_string(), &text_of(&body))
}

fn session_sum(session: &StoredSession) -> String {
    let body = (session.token, session.created_ms, session.seen_ms);
    of_row("session", &session.sha256, &text_of(&body))
}

/// Reads a token and its sum, which may not fit.
fn unchecked_token(row: &Row<'_>) -> rusqlite::Result<(StoredToken, String)> {
    let token = StoredToken {
        number: row.get(0)?,
        sha256: row.get(1)?,
        name: row.get(2)?,
        label: row.get(3)?,
        scopes: row.get(4)?,
        created_ms: row.get(5)?,
        ends_ms: row.get(6)?,
        used_ms: row.get(7)?,
        revoked: row.get(8)?,
    };
    Ok((token, row.get(9)?))
}

fn token_of(row: &Row<'_>) -> Result<StoredToken, StoreError> {
    let number: i64 = row.get(0)?;
    match unchecked_token(row) {
        Ok((token, sum)) if token_sum(&token) == sum => Ok(token),
        // A column of another type is damage as well.
        _ => Err(StoreError::Damaged {
            what: format!("token #{number}"),
        }),
    }
}

fn session_of(row: &Row<'_>) -> Result<StoredSession, StoreError> {
    let read = || -> rusqlite::Result<(StoredSession, String)> {
        let session = StoredSession {
            sha256: row.get(1)?,
            token: row.get(2)?,
            created_ms: row.get(3)?,
            seen_ms: row.get(4)?,
        };
        Ok((session, row.get(5)?))
    };
    let number: i64 = row.get(0)?;
    match read() {
        Ok((session, sum)) if session_sum(&session) == sum => Ok(session),
        _ => Err(StoreError::Damaged {
            what: format!("session {number}"),
        }),
    }
}

/// Gives every token its sum, after tables of a version without sums were taken over.
pub(super) fn seal(connection: &Connection) -> Result<(), StoreError> {
    let tokens = rows(connection, EVERY_TOKEN, [], |row| {
        Ok(unchecked_token(row)?.0)
    })?;
    tokens
        .iter()
        .try_for_each(|token| set_sum(connection, token))
}

fn set_sum(connection: &Connection, token: &StoredToken) -> Result<(), StoreError> {
    let sql = "UPDATE tokens SET sum = ? WHERE number = ?";
    connection.execute(sql, params![token_sum(token), token.number])?;
    Ok(())
}

/// Keeps a token. Rows that do not fit their sums go: they can be used no more.
pub(super) fn put(connection: &Connection, token: &StoredToken) -> Result<i64, StoreError> {
    remove_damaged(connection, "tokens", EVERY_TOKEN, token_of)?;
    connection.execute(
        "INSERT INTO tokens (sha256, name, label, scopes, created_ms, ends_ms, sum) VALUES (?, ?, ?, ?, ?, ?, '')",
        params![
            token.sha256,
            token.name,
            token.label,
            token.scopes,
            token.created_ms,
            token.ends_ms
        ],
    )?;
    let token = StoredToken {
        number: connection.last_insert_rowid(),
        ..token.clone()
    };
    set_sum(connection, &token)?;
    Ok(token.number)
}

/// Removes the rows of a table that do not fit their sums. `sql` reads all, the number of the row first.
fn remove_damaged<T>(
    connection: &Connection,
    table: &str,
    sql: &str,
    read: impl Fn(&Row<'_>) -> Result<T, StoreError>,
) -> Result<(), StoreError> {
    let numbered = rows(connection, sql, [], |row| {
        Ok((row.get(0)?, read(row).is_err()))
    })?;
    for (number, is_damaged) in numbered {
        let number: i64 = number;
        if is_damaged {
            connection.execute(&format!("DELETE FROM {table} WHERE rowid = ?"), [number])?;
        }
    }
    Ok(())
}

/// Lists the tokens whose rows fit; empty only if no token was ever made.
pub(super) fn list(connection: &Connection) -> Result<Vec<StoredToken>, StoreError> {
    let Page {
        entries, damaged, ..
    } = page(connection, EVERY_TOKEN, [], u32::MAX, token_of)?;
    if entries.is_empty() && (!damaged.is_empty() || were_made(connection)?) {
        return Err(StoreError::TokensLost);
    }
    Ok(entries)
}

/// Returns true if a token was ever made: SQLite counts the rows that a table with AUTOINCREMENT has had, and no row
/// of tokens is removed but for damage.
fn were_made(connection: &Connection) -> Result<bool, StoreError> {
    let sql = "SELECT count(*) FROM sqlite_sequence WHERE name = 'tokens' AND seq <> 0";
    Ok(connection.query_row(sql, [], |row| row.get::<_, i64>(0))? > 0)
}

/// Names what is damaged of tokens and sessions.
pub(super) fn damaged(connection: &Connection) -> Result<Vec<String>, StoreError> {
    let mut damaged = page(connection, EVERY_TOKEN, [], u32::MAX, token_of)?.damaged;
    damaged.extend(page(connection, EVERY_SESSION, [], u32::MAX, session_of)?.damaged);
    if list(connection) == Err(StoreError::TokensLost) {
        damaged.push("the tokens: some were made, and none can be read".into());
    }
    Ok(damaged)
}

/// Revokes a token at once, with its sessions, or lets it end at `ends_ms`.
pub(super) fn end(
    connection: &Connection,
    number: i64,
    ends_ms: Option<i64>,
) -> Result<(), StoreError> {
    let mut tokens = list(connection)?;
    tokens.retain(|token| token.number == number);
    // A change that finds no row must not look as if it had been made.
    let mut token = tokens.pop().ok_or_else(|| StoreError::Damaged {
        what: format!("token #{number}"),
    })?;
    match ends_ms {
        Some(ends_ms) => {
            token.ends_ms = Some(token.ends_ms.map_or(ends_ms, |end| end.min(ends_ms)))
        }
        None => {
            connection.execute("DELETE FROM sessions WHERE token = ?", [number])?;
            token.revoked = true;
        }
    }
    connection.execute(
        "UPDATE tokens SET ends_ms = ?, revoked = ? WHERE number = ?",
        params![token.ends_ms, token.revoked, number],
    )?;
    set_sum(connection, &token)
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
    remove_damaged(connection, "sessions", EVERY_SESSION, session_of)?;
    connection.execute(
        "INSERT OR REPLACE INTO sessions (sha256, token, created_ms, seen_ms, sum) VALUES (?, ?, ?, ?, ?)",
        params![
            session.sha256,
            session.token,
            session.created_ms,
            session.seen_ms,
            session_sum(session)
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
    Ok(page(connection, EVERY_SESSION, [], u32::MAX, session_of)?.entries)
}

pub(super) fn end_session(connection: &Connection, sha256: &str) -> Result<(), StoreError> {
    // Without the index: a damaged one would hide the row, and the session would go on.
    connection.execute(
        "DELETE FROM sessions NOT INDEXED WHERE sha256 = ?",
        [sha256],
    )?;
    Ok(())
}
