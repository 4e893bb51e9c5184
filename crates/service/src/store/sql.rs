//! Rows of the ledger: bodies as text, confirmed by their hash.

use super::sum::of_row;
use super::{Page, StoreError};
use rusqlite::{Connection, Row};
use serde::Serialize;
use serde::de::DeserializeOwned;

pub(super) fn text_of<T: Serialize>(body: &T) -> String {
    serde_json::to_string(body).expect("what is stored has text keys only")
}

/// Reads a body that its hash confirms.
pub(super) fn confirmed<T: DeserializeOwned>(
    table: &str,
    key: &str,
    body: &str,
    sum: &str,
) -> Result<T, StoreError> {
    let damaged = || StoreError::Damaged {
        what: format!("{table} {key}"),
    };
    if of_row(table, key, body) != sum {
        return Err(damaged());
    }
    serde_json::from_str(body).map_err(|_| damaged())
}

/// Collects the rows of a list of at most so many rows, `limit`, without those that are damaged, which
/// are logged. The first column is the number of the row.
pub(super) fn page<T>(
    connection: &Connection,
    sql: &str,
    params: impl rusqlite::Params,
    limit: u32,
    of: impl Fn(&Row<'_>) -> Result<T, StoreError>,
) -> Result<Page<T>, StoreError> {
    let found = rows(connection, sql, params, |row| Ok((row.get(0)?, of(row))))?;
    let is_full = found.len() as u64 >= u64::from(limit);
    let next = found.last().filter(|_| is_full).map(|(number, _)| *number);
    let (mut entries, mut damaged) = (Vec::with_capacity(found.len()), Vec::new());
    for (_, found) in found {
        match found {
            Ok(entry) => entries.push(entry),
            Err(StoreError::Damaged { what }) => {
                tracing::error!(%what, "a row is damaged and was left out of a list");
                damaged.push(what);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Page {
        entries,
        damaged,
        next,
    })
}

/// Collects the rows of a query.
pub(super) fn rows<T>(
    connection: &Connection,
    sql: &str,
    params: impl rusqlite::Params,
    of: impl Fn(&Row<'_>) -> Result<T, StoreError>,
) -> Result<Vec<T>, StoreError> {
    let mut statement = connection.prepare_cached(sql)?;
    let mut rows = statement.query(params)?;
    let mut found = Vec::new();
    while let Some(row) = rows.next()? {
        found.push(of(row)?);
    }
    Ok(found)
}
