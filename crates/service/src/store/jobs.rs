//! Jobs: taken under a lease that is held by heartbeats, at most three attempts that end their
//! child, and fenced, so that an attempt that lost its lease changes nothing.

use super::sql::{confirmed, text_of};
use super::sum::of_row;
use super::{Job, JobState, Load, Question, QueuePlace, StoreError};
use crate::clock::now_ms;
use crate::turns::Turns;
use rusqlite::{Connection, OptionalExtension, Row, params};
use serde_json::Value;
use std::collections::BTreeSet;

/// Version of this program.
pub(super) const PROGRAM: &str = env!("CARGO_PKG_VERSION");

/// Returns the name under which a refusal is kept. Another program, or children with more memory or
/// time, may answer where this one refused.
pub(super) fn program_of(memory_bytes: u64, order_s: u64) -> String {
    format!("{PROGRAM} {memory_bytes} B {order_s} s")
}

pub(super) const COLUMNS: &str =
    "id, body, sum, state, attempt, failures, answer, answer_sum, program, owner";

/// Reads every job.
pub(super) const EVERY: &str =
    "SELECT id, body, sum, state, attempt, failures, answer, answer_sum, program, owner FROM jobs";

pub(super) fn job_of(row: &Row<'_>) -> Result<Job, StoreError> {
    let (id, body, sum): (String, String, String) = (row.get(0)?, row.get(1)?, row.get(2)?);
    let question: Question = confirmed("job", &id, &body, &sum)?;
    let word: String = row.get(3)?;
    let state = match word.as_str() {
        "queued" | "later" => JobState::Queued,
        "running" => JobState::Running,
        _ => {
            let (answer, sum): (String, String) = (row.get(6)?, row.get(7)?);
            let answer: Value = confirmed(&word, &id, &answer, &sum)?;
            match answer {
                Value::String(report_id) if word == "done" => JobState::Done { report_id },
                row if word == "done" => JobState::Decided { row },
                problem => JobState::Refused { problem },
            }
        }
    };
    Ok(Job {
        id,
        question,
        state,
        attempt: row.get(4)?,
        failures: row.get(5)?,
        owner: row.get(9)?,
    })
}

pub(super) fn find(connection: &Connection, id: &str) -> Result<Option<Job>, StoreError> {
    let sql = format!("SELECT {COLUMNS} FROM jobs WHERE id = ?");
    let mut statement = connection.prepare_cached(&sql)?;
    let mut rows = statement.query([id])?;
    rows.next()?.map(job_of).transpose()
}

pub(super) fn submit(
    connection: &Connection,
    id: &str,
    question: &Question,
    owner: &str,
    program: &str,
) -> Result<(Job, bool), StoreError> {
    // A refusal by another version, or with other limits, does not stand: the job is done anew.
    connection.execute(
        "DELETE FROM jobs WHERE id = ? AND state = 'refused' AND program <> ?",
        params![id, program],
    )?;
    if let Err(StoreError::Damaged { what }) = find(connection, id) {
        // The question is given again, so the damaged row can be replaced.
        tracing::warn!(%what, "a job is damaged and is asked anew");
        connection.execute("DELETE FROM jobs WHERE id = ?", [id])?;
    }
    let body = text_of(question);
    // A person waits for a single question, so it comes before the many pairs of a gate.
    let state = if question.decision_alone {
        "later"
    } else {
        "queued"
    };
    let added = connection.execute(
        "INSERT OR IGNORE INTO jobs (id, owner, body, sum, state, lease_ms) VALUES (?, ?, ?, ?, ?, ?)",
        // While the job waits, the column of its lease holds the time at which it came or was put back.
        params![id, owner, body, of_row("job", id, &body), state, now_ms()],
    )?;
    let job = find(connection, id)?.ok_or(StoreError::Fenced)?;
    Ok((job, added == 1))
}

/// Puts an answered job back in the queue. Its answer stays in case no other comes.
pub(super) fn requeue(connection: &Connection, id: &str) -> Result<(), StoreError> {
    connection.execute(
        "UPDATE jobs SET state = 'queued', failures = 0, lease_ms = ?2 WHERE id = ?1 AND state = 'done'",
        params![id, now_ms()],
    )?;
    Ok(())
}

/// States of single questions that wait.
pub(super) const QUESTIONS: &[&str] = &["queued"];

/// States of jobs that wait, in the order in which an owner's are taken.
pub(super) const WAITING: &[&str] = &["queued", "later"];

pub(super) fn any_waits(
    connection: &Connection,
    states: &[&str],
    now_ms: i64,
) -> Result<bool, StoreError> {
    let sql = "SELECT 1 FROM jobs WHERE state = ? AND not_before_ms <= ? LIMIT 1";
    let mut statement = connection.prepare_cached(sql)?;
    for state in states {
        if statement.exists(params![state, now_ms])? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Takes the next job in one of some states: of the owner who was not served for longest, the oldest of the first
/// state. So his questions come before the pairs of his gates, and neither keeps another owner waiting.
pub(super) fn take(
    connection: &Connection,
    turns: &mut Turns,
    states: &[&str],
    now_ms: i64,
    lease_ms: i64,
) -> Result<Option<Job>, StoreError> {
    let mut jobs = Vec::new();
    for (rank, state) in states.iter().enumerate() {
        let oldest = waiting(connection, state, now_ms)?.into_iter();
        jobs.extend(oldest.map(|(owner, number)| (owner, rank, number)));
    }
    let next = jobs
        .into_iter()
        .min_by_key(|(owner, rank, number)| (turns.last(owner), *rank, *number));
    let Some((owner, _, number)) = next else {
        return Ok(None);
    };
    turns.serve(&owner);
    let sql = "UPDATE jobs SET state = 'running', attempt = attempt + 1, lease_ms = ?2
               WHERE number = ?1 RETURNING id";
    let mut statement = connection.prepare_cached(sql)?;
    let id: String = statement.query_row(params![number, lease_ms], |row| row.get(0))?;
    match find(connection, &id) {
        Err(StoreError::Damaged { what }) => {
            // A question that cannot be read cannot be answered, and must not block the queue.
            tracing::error!(%what, "a job is damaged and was set aside");
            let sql = "UPDATE jobs SET state = 'damaged' WHERE id = ?";
            connection.execute(sql, [&id])?;
            Ok(None)
        }
        found => found,
    }
}

/// Lists the owners with waiting jobs, each with its oldest one. The query goes from owner to owner in
/// the index: one owner may have a hundred thousand jobs.
fn waiting(
    connection: &Connection,
    state: &str,
    now_ms: i64,
) -> Result<Vec<(String, i64)>, StoreError> {
    let sql = "WITH RECURSIVE owners (owner) AS (
             SELECT min(owner) FROM jobs
             UNION ALL
             SELECT (SELECT min(jobs.owner) FROM jobs WHERE jobs.owner > owners.owner)
             FROM owners WHERE owner IS NOT NULL),
         oldest (owner, number) AS (
             SELECT owner, (SELECT number FROM jobs INDEXED BY jobs_by_owner
                 WHERE jobs.owner = owners.owner AND state = ?2 AND not_before_ms <= ?1 ORDER BY number LIMIT 1)
             FROM owners WHERE owner IS NOT NULL)
         SELECT owner, number FROM oldest WHERE number IS NOT NULL";
    let mut statement = connection.prepare_cached(sql)?;
    let parameters = params![now_ms, state];
    let owners = statement.query_map(parameters, |row| Ok((row.get(0)?, row.get(1)?)))?;
    Ok(owners.collect::<Result<_, _>>()?)
}

/// Refuses a change that met no row: another attempt holds the job.
fn fenced(changed: usize) -> Result<(), StoreError> {
    if changed == 1 {
        Ok(())
    } else {
        Err(StoreError::Fenced)
    }
}

pub(super) fn hold(
    connection: &Connection,
    id: &str,
    attempt: i64,
    lease_ms: i64,
) -> Result<(), StoreError> {
    fenced(connection.execute(
        "UPDATE jobs SET lease_ms = ?3 WHERE id = ?1 AND state = 'running' AND attempt = ?2",
        params![id, attempt, lease_ms],
    )?)
}

/// Ends a job in the state `done` or `refused`.
pub(super) fn end(
    connection: &Connection,
    id: &str,
    attempt: i64,
    state: &str,
    answer: &Value,
    program: &str,
) -> Result<(), StoreError> {
    if state == "refused" {
        // The job was answered before and only had to remake its report: the earlier answer stays.
        let answered = "UPDATE jobs SET state = 'done'
             WHERE id = ? AND state = 'running' AND attempt = ? AND answer LIKE '\"%'";
        if connection.execute(answered, params![id, attempt])? == 1 {
            return Ok(());
        }
    }
    let answer = text_of(answer);
    let sum = of_row(state, id, &answer);
    fenced(connection.execute(
        "UPDATE jobs SET state = ?3, answer = ?4, answer_sum = ?5, program = ?6
         WHERE id = ?1 AND state = 'running' AND attempt = ?2",
        params![id, attempt, state, answer, sum, program],
    )?)
}

pub(super) fn give_back(
    connection: &Connection,
    id: &str,
    attempt: i64,
    counts: bool,
    not_before_ms: i64,
) -> Result<i64, StoreError> {
    fenced(connection.execute(
        "UPDATE jobs SET state = 'queued', failures = failures + ?3, not_before_ms = ?4, lease_ms = ?5
         WHERE id = ?1 AND state = 'running' AND attempt = ?2",
        params![id, attempt, i64::from(counts), not_before_ms, now_ms()],
    )?)?;
    let sql = "SELECT failures FROM jobs WHERE id = ?";
    Ok(connection.query_row(sql, [id], |row| row.get(0))?)
}

pub(super) fn reclaim(
    connection: &Connection,
    running_ms: i64,
    every: bool,
) -> Result<usize, StoreError> {
    if every {
        // Pauses are times of the process that set them, and that process has ended.
        let sql = "UPDATE jobs SET not_before_ms = 0 WHERE state IN ('queued', 'later', 'running') AND not_before_ms > 0";
        connection.execute(sql, [])?;
    }
    Ok(connection.execute(
        "UPDATE jobs SET state = 'queued', lease_ms = ?3
         WHERE state = 'running' AND (?2 OR lease_ms < ?1)",
        params![running_ms, every, now_ms()],
    )?)
}

/// Returns the time at which the oldest waiting job came; of one that was put back, the time of that.
pub(super) fn oldest_ms(connection: &Connection) -> Result<Option<i64>, StoreError> {
    let sql = "SELECT lease_ms FROM jobs WHERE state = ? ORDER BY number LIMIT 1";
    let mut statement = connection.prepare_cached(sql)?;
    let mut oldest = |state: &str| statement.query_row([state], |row| row.get(0)).optional();
    let (question, pair): (Option<i64>, Option<i64>) = (oldest("queued")?, oldest("later")?);
    Ok(question.into_iter().chain(pair).min())
}

/// Returns the place of a question that waits; `None` if it does not. Of each other owner as many jobs come before it
/// as it needs turns.
pub(super) fn place(connection: &Connection, id: &str) -> Result<Option<QueuePlace>, StoreError> {
    let count = |sql: &str, parameters: &[&dyn rusqlite::ToSql]| -> Result<u64, StoreError> {
        let mut statement = connection.prepare_cached(sql)?;
        let count: i64 = statement.query_row(parameters, |row| row.get(0))?;
        Ok(count.unsigned_abs())
    };
    let sql = "SELECT number, owner, lease_ms FROM jobs WHERE id = ? AND state = 'queued'";
    let found = connection
        .query_row(sql, [id], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))
        .optional()?;
    let Some((number, owner, since_ms)): Option<(i64, String, i64)> = found else {
        return Ok(None);
    };
    let running = "SELECT count(*) FROM jobs WHERE state = 'running'";
    let earlier = "SELECT count(*) FROM jobs WHERE owner = ? AND state = 'queued' AND number < ?";
    let earlier = count(earlier, &[&owner, &number])?;
    let mut behind = count(running, &[])? + earlier;
    let mut others = BTreeSet::new();
    for state in WAITING {
        let waiting = waiting(connection, state, i64::MAX)?;
        others.extend(waiting.into_iter().map(|(other, _)| other));
    }
    others.remove(&owner);
    let turns = i64::try_from(earlier).unwrap_or(i64::MAX - 1) + 1;
    let of_other = "SELECT count(*) FROM (SELECT 1 FROM jobs WHERE owner = ? AND state IN ('queued', 'later') LIMIT ?)";
    for other in &others {
        behind += count(of_other, &[other, &turns])?;
    }
    Ok(Some(QueuePlace { behind, since_ms }))
}

/// Returns the owner who submitted a job first.
pub(super) fn owner(connection: &Connection, id: &str) -> Result<String, StoreError> {
    let owner = connection
        .query_row("SELECT owner FROM jobs WHERE id = ?", [id], |row| {
            row.get(0)
        })
        .optional()?;
    Ok(owner.unwrap_or_default())
}

pub(super) fn load(connection: &Connection, owner: &str) -> Result<Load, StoreError> {
    let count = |sql: &str, parameter: &str| -> Result<u64, StoreError> {
        let mut statement = connection.prepare_cached(sql)?;
        let count: i64 = statement.query_row([parameter], |row| row.get(0))?;
        Ok(count.unsigned_abs())
    };
    let by_state = "SELECT count(*) FROM jobs WHERE state = ?1";
    let by_owner =
        "SELECT count(*) FROM jobs WHERE owner = ?1 AND state IN ('queued', 'later', 'running')";
    Ok(Load {
        queued: count(by_state, "queued")? + count(by_state, "later")?,
        running: count(by_state, "running")?,
        owner_jobs: count(by_owner, owner)?,
    })
}
