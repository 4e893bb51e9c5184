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

/// Collects at most `limit` rows of a list. Damaged rows are left out and logged. The first column must
/// be the number of the row.
pub(super) fn page<T>(
    connection: &Connection,
    sql: &str,
    params: impl rusqlite::Params,
    limit: u32,
    read: impl Fn(&Row<'_>) -> Result<T, StoreError>,
) -> Result<Page<T>, StoreError> {
    let numbered = rows(connection, sql, params, |row| Ok((row.get(0)?, read(row))))?;
    let is_full = numbered.len() as u64 >= u64::from(limit);
    let last = numbered.last().filter(|_| is_full);
    let next = last.map(|(number, _)| *number);
    let (mut entries, mut damaged) = (Vec::with_capacity(numbered.len()), Vec::new());
    for (_, entry) in numbered {
        match entry {
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
    read: impl Fn(&Row<'_>) -> Result<T, StoreError>,
) -> Result<Vec<T>, StoreError> {
    let mut statement = connection.prepare_cached(sql)?;
    let mut rows = statement.query(params)?;
    let mut values = Vec::new();
    while let Some(row) = rows.next()? {
        values.push(read(row)?);
    }
    Ok(values)
}
