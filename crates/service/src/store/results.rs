//! Results as rows.

use super::sql::{confirmed, page, rows, text_of};
use super::sum::of_row;
use super::{Page, ResultFilter, ResultOrder, StoreError, StoredResult};
use rusqlite::{Connection, Row, params};

pub(super) fn result_of(row: &Row<'_>) -> Result<(i64, StoredResult), StoreError> {
    let (id, body, sum): (String, String, String) = (row.get(1)?, row.get(2)?, row.get(3)?);
    Ok((row.get(0)?, confirmed("result", &id, &body, &sum)?))
}

pub(super) fn find(
    connection: &Connection,
    report_id: &str,
) -> Result<Option<StoredResult>, StoreError> {
    let sql = "SELECT number, report_id, body, sum FROM results WHERE report_id = ?";
    let last = rows(connection, sql, [report_id], result_of)?.pop();
    Ok(last.map(|(_, result)| result))
}

pub(super) fn put(connection: &Connection, result: &StoredResult) -> Result<(), StoreError> {
    let (id, summary) = (&result.report_id, &result.summary);
    let body = text_of(result);
    let sum = of_row("result", id, &body);
    let words = [
        summary.file.as_str(),
        summary.channel.as_deref().unwrap_or(""),
        &summary.design,
        id,
    ]
    .join("\n")
    .to_lowercase();
    let values = params![
        id,
        result.recording,
        summary.verdict,
        summary.design,
        words,
        body,
        sum
    ];
    let added = connection.execute(
        "INSERT OR IGNORE INTO results (report_id, recording, verdict, design, words, body, sum)
         VALUES (?, ?, ?, ?, ?, ?, ?)",
        values,
    )?;
    if added == 1 {
        return Ok(());
    }
    let mut stored = match find(connection, id) {
        Ok(Some(stored)) => stored,
        Ok(None) => return Ok(()),
        // The stored answer cannot be read any more, and this is the same answer.
        Err(StoreError::Damaged { .. }) => {
            let sql = "UPDATE results SET body = ?, sum = ? WHERE report_id = ?";
            connection.execute(sql, params![body, sum, id])?;
            return Ok(());
        }
        Err(error) => return Err(error),
    };
    if stored.content_sha256 != result.content_sha256 {
        // The first answer was given out under this identity, so it stays.
        tracing::error!(report_id = %id, "one question has two answers");
        return Ok(());
    }
    // Files that were lost, or deleted with a recording that is uploaded again.
    if stored.is_stripped || !stored.lost.is_empty() {
        for (name, file) in &result.files {
            if stored.lost.contains(name) || !stored.files.contains_key(name) {
                stored.files.insert(name.clone(), file.clone());
            }
        }
        stored.lost.clear();
        stored.is_stripped = false;
        let body = text_of(&stored);
        let sum = of_row("result", id, &body);
        let sql = "UPDATE results SET body = ?, sum = ? WHERE report_id = ?";
        connection.execute(sql, params![body, sum, id])?;
    }
    Ok(())
}

/// Lists results.
pub(super) fn list(
    connection: &Connection,
    filter: &ResultFilter,
) -> Result<Page<StoredResult>, StoreError> {
    let (order, before, skipped) = match (filter.order, filter.after) {
        (ResultOrder::Newest, after) => ("number DESC", after.unwrap_or(i64::MAX), 0),
        (ResultOrder::Oldest, after) => ("number", i64::MAX, after.unwrap_or(0)),
        // The column `words` begins with file and channel.
        (ResultOrder::File, after) => ("words, number DESC", i64::MAX, after.unwrap_or(0)),
        (ResultOrder::Verdict, after) => ("verdict, number DESC", i64::MAX, after.unwrap_or(0)),
        (ResultOrder::Design, after) => (
            "design COLLATE NOCASE, number DESC",
            i64::MAX,
            after.unwrap_or(0),
        ),
    };
    let sql = format!(
        "SELECT number, report_id, body, sum FROM results
             WHERE number < ?1 AND (?2 IS NULL OR verdict = ?2)
               AND (?3 IS NULL OR recording = ?3) AND (?4 IS NULL OR design = ?4)
               AND (?5 IS NULL OR instr(words, ?5) > 0)
             ORDER BY {order} LIMIT ?6 OFFSET ?7"
    );
    let text = filter.text.as_ref().map(|text| text.to_lowercase());
    let parameters = params![
        before,
        filter.verdict,
        filter.recording,
        filter.design,
        text,
        filter.limit,
        skipped
    ];
    let mut results = page(connection, &sql, parameters, filter.limit, |row| {
        result_of(row).map(|(_, result)| result)
    })?;
    if filter.order != ResultOrder::Newest && results.next.is_some() {
        results.next = Some(skipped + i64::from(filter.limit));
    }
    Ok(results)
}
