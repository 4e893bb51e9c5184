//! Rows of the ledger: bodies as text, confirmed by their hash.

use super::StoreError;
use super::sum::of_row;
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
