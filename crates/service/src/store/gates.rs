//! Gates and their pairs. Each pair is a job, which gates with the same pair share.

use super::sql::{confirmed, page, rows, text_of};
use super::sum::of_row;
use super::{GateOutcome, GateStanding, Job, Page, Question, StoreError, StoredGate, jobs};
use rusqlite::{Connection, Row, params};

/// Reads every gate.
pub(super) const EVERY: &str = "SELECT number, id, body, sum, outcome, outcome_sum, 0 FROM gates";

/// The columns of a gate, with the number of its pairs that are decided.
const STANDING: &str = "SELECT number, id, body, sum, outcome, outcome_sum,
     CASE WHEN outcome IS NOT NULL THEN 0 ELSE
         (SELECT count(*) FROM pairs JOIN jobs ON jobs.id = pairs.job WHERE pairs.gate = gates.id
          AND jobs.state NOT IN ('queued', 'later', 'running')) END FROM gates";

pub(super) fn gate_of(row: &Row<'_>) -> Result<(i64, GateStanding), StoreError> {
    let (id, body, sum): (String, String, String) = (row.get(1)?, row.get(2)?, row.get(3)?);
    let gate: StoredGate = confirmed("gate", &id, &body, &sum)?;
    let outcome: Option<String> = row.get(4)?;
    let outcome: Option<GateOutcome> = match outcome {
        None => None,
        Some(outcome) => {
            let sum: String = row.get(5)?;
            Some(confirmed("outcome", &id, &outcome, &sum)?)
        }
    };
    let decided: i64 = row.get(6)?;
    let decided = match outcome {
        Some(_) => (gate.recordings.len() * gate.designs.len()) as u64,
        None => decided.unsigned_abs(),
    };
    let standing = GateStanding {
        gate,
        decided,
        outcome,
    };
    Ok((row.get(0)?, standing))
}

pub(super) fn put(
    connection: &Connection,
    gate: &StoredGate,
    pairs: &[Question],
    owner: &str,
    program: &str,
) -> Result<bool, StoreError> {
    let body = text_of(gate);
    let added = connection.execute(
        "INSERT OR IGNORE INTO gates (id, name, body, sum) VALUES (?, ?, ?, ?)",
        params![gate.id, gate.name, body, of_row("gate", &gate.id, &body)],
    )?;
    if added == 0 {
        return reopen(connection, gate, pairs, owner, program);
    }
    let mut statement =
        connection.prepare_cached("INSERT INTO pairs (gate, number, job) VALUES (?, ?, ?)")?;
    for (number, question) in (0_i64..).zip(pairs) {
        let job = question.id();
        jobs::submit(connection, &job, question, owner, program)?;
        statement.execute(params![gate.id, number, job])?;
    }
    Ok(true)
}

/// Puts pairs of a stored gate back in the queue that were refused for a reason that may pass. The
/// outcome is then open again, and so is one without a summary. True if it is.
fn reopen(
    connection: &Connection,
    gate: &StoredGate,
    pairs: &[Question],
    owner: &str,
    program: &str,
) -> Result<bool, StoreError> {
    let before: i64 = connection.query_row(WAITING, [&gate.id], |row| row.get(0))?;
    for question in pairs {
        jobs::submit(connection, &question.id(), question, owner, program)?;
    }
    let after: i64 = connection.query_row(WAITING, [&gate.id], |row| row.get(0))?;
    let outcome = find(connection, &gate.id)?.and_then(|standing| standing.outcome);
    let failed = outcome.is_some_and(|outcome| outcome.problem.is_some());
    if after > before || failed {
        let sql = "UPDATE gates SET outcome = NULL, outcome_sum = NULL WHERE id = ?";
        connection.execute(sql, [&gate.id])?;
    }
    Ok(after > before || failed)
}

/// Counts the pairs of a gate that wait.
const WAITING: &str = "SELECT count(*) FROM pairs JOIN jobs ON jobs.id = pairs.job
     WHERE gate = ? AND state IN ('queued', 'later', 'running')";

pub(super) fn find(connection: &Connection, id: &str) -> Result<Option<GateStanding>, StoreError> {
    let sql = format!("{STANDING} WHERE id = ?");
    let last = rows(connection, &sql, [id], gate_of)?.pop();
    Ok(last.map(|(_, standing)| standing))
}

pub(super) fn list(
    connection: &Connection,
    before: Option<i64>,
    limit: u32,
) -> Result<Page<GateStanding>, StoreError> {
    let sql = format!("{STANDING} WHERE number < ? ORDER BY number DESC LIMIT ?");
    let before = before.unwrap_or(i64::MAX);
    page(connection, &sql, params![before, limit], limit, |row| {
        gate_of(row).map(|(_, standing)| standing)
    })
}

pub(super) fn open(connection: &Connection) -> Result<Page<GateStanding>, StoreError> {
    let sql = format!("{STANDING} WHERE outcome IS NULL ORDER BY number");
    page(connection, &sql, [], u32::MAX, |row| {
        gate_of(row).map(|(_, standing)| standing)
    })
}

pub(super) fn pairs(connection: &Connection, id: &str) -> Result<Vec<Job>, StoreError> {
    let columns = jobs::COLUMNS.replace("id, body", "jobs.id, body");
    let sql = format!(
        "SELECT {columns} FROM pairs JOIN jobs ON jobs.id = pairs.job WHERE gate = ? ORDER BY pairs.number"
    );
    rows(connection, &sql, [id], jobs::job_of)
}

pub(super) fn end(
    connection: &Connection,
    id: &str,
    outcome: &GateOutcome,
) -> Result<(), StoreError> {
    let text = text_of(outcome);
    let sum = of_row("outcome", id, &text);
    // An outcome may have been read by a client, so it stays until the gate is submitted again.
    connection.execute(
        "UPDATE gates SET outcome = ?, outcome_sum = ? WHERE id = ? AND outcome IS NULL",
        params![text, sum, id],
    )?;
    Ok(())
}
