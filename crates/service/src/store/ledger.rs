//! The ledger in SQLite: write-ahead log, synced at every commit, one writer that commits all waiting
//! changes as one group, readers beside it.

use super::schema;
use super::sql::{confirmed, page, rows, text_of};
use super::sum::of_row;
use super::{
    Census, CheckedFiles, Deletion, GateOutcome, GateStanding, Job, LastRows, Ledger,
    ListedRecording, Load, Manifest, Page, Question, QueuePlace, RecordingFilter, Remake,
    ResultFilter, StoreError, StoredDesign, StoredGate, StoredRecording, StoredResult,
    StoredSession, StoredToken, deletions, gates, jobs, needed, recordings, results, tokens,
};
use crate::turns::Turns;
use rusqlite::{Connection, OpenFlags, OptionalExtension, Row, params};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Time after which the log is written into the ledger. Damage in the ledger costs the damaged row,
/// damage in the log costs everything after it.
const SETTLE: Duration = Duration::from_secs(2);

/// Waiting time for another process that writes.
const BUSY: Duration = Duration::from_secs(5);

/// Largest number of changes that are committed together.
const GROUP: usize = 256;

/// Reports the outcome to the caller of a change, once its group is committed or not.
type After = Box<dyn FnOnce(Result<(), StoreError>) + Send>;

/// A change that waits for the writer.
type Change = Box<dyn FnOnce(&Connection) -> After + Send>;

/// The ledger in an SQLite file.
#[derive(Debug)]
pub struct SqliteLedger {
    path: PathBuf,
    program: Arc<str>,
    readers: Mutex<Vec<Connection>>,
    /// Connection that looks for changes: SQLite counts for each connection those of all others.
    watcher: Mutex<Option<Connection>>,
    changes: SyncSender<Change>,
    turns: Arc<Mutex<Turns>>,
}

impl SqliteLedger {
    /// Opens the ledger, made if absent.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if it cannot be opened or was made by another version that cannot be read.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let writer = connect(path)?;
        writer.execute_batch("PRAGMA journal_mode = WAL; PRAGMA secure_delete = ON;")?;
        upgrade(&writer)?;
        let (changes, waiting) = sync_channel(4 * GROUP);
        std::thread::Builder::new()
            .name("ledger".into())
            .spawn(move || write_in_groups(&writer, &waiting))?;
        Ok(Self {
            path: path.to_path_buf(),
            program: jobs::PROGRAM.into(),
            readers: Mutex::new(Vec::new()),
            watcher: Mutex::default(),
            changes,
            turns: Arc::default(),
        })
    }

    /// Opens the ledger read-only, also where nothing can be written.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if it cannot be read, or was made by another version.
    pub fn read_only(path: &Path) -> Result<Self, StoreError> {
        let reader = connect_to_read(path)?;
        let version = version_of(&reader)?;
        if version != schema::VERSION {
            return Err(other_version(version));
        }
        // Without a receiver every change fails.
        let (changes, _) = sync_channel(0);
        Ok(Self {
            path: path.to_path_buf(),
            program: jobs::PROGRAM.into(),
            readers: Mutex::new(vec![reader]),
            watcher: Mutex::default(),
            changes,
            turns: Arc::default(),
        })
    }

    /// States the limits of children that answer: memory [bytes] and time [s].
    #[must_use]
    pub fn with_limits(mut self, memory_bytes: u64, order_s: u64) -> Self {
        self.program = jobs::program_of(memory_bytes, order_s).into();
        self
    }

    /// Takes the next job in one of some states.
    fn take_of(
        &self,
        states: &'static [&'static str],
        now_ms: i64,
        lease_ms: i64,
    ) -> Result<Option<Job>, StoreError> {
        // Mostly nothing waits, and a reader finds that out without the writer.
        if !self.read(|connection| jobs::any_waits(connection, states, now_ms))? {
            return Ok(None);
        }
        let turns = Arc::clone(&self.turns);
        self.write(move |connection| {
            let mut turns = turns
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            jobs::take(connection, &mut turns, states, now_ms, lease_ms)
        })
    }

    /// Sends a change to the writer, and returns once it is on the disk.
    fn write<T: Send + 'static>(
        &self,
        change: impl FnOnce(&Connection) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, StoreError> {
        let (sender, receiver) = sync_channel(1);
        let change: Change = Box::new(move |connection| {
            let outcome = in_savepoint(connection, change);
            Box::new(move |committed: Result<(), StoreError>| {
                let _ = sender.send(committed.and(outcome));
            })
        });
        let gone = || StoreError::Broken {
            reason: "nobody writes the ledger".into(),
        };
        self.changes.send(change).map_err(|_| gone())?;
        receiver.recv().map_err(|_| gone())?
    }

    fn read<T>(
        &self,
        read: impl FnOnce(&Connection) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let idle = self.idle_readers().pop();
        let connection = idle.map_or_else(|| connect(&self.path), Ok)?;
        let outcome = read(&connection);
        self.idle_readers().push(connection);
        outcome
    }

    fn idle_readers(&self) -> std::sync::MutexGuard<'_, Vec<Connection>> {
        self.readers
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

fn connect(path: &Path) -> Result<Connection, StoreError> {
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE
        | OpenFlags::SQLITE_OPEN_CREATE
        | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags)?;
    connection.busy_timeout(BUSY)?;
    connection.execute_batch("PRAGMA synchronous = FULL; PRAGMA trusted_schema = OFF;")?;
    Ok(connection)
}

/// Connects to a ledger in a folder that may be read-only.
fn connect_to_read(path: &Path) -> Result<Connection, StoreError> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let readable = |connection: &Connection| version_of(connection);
    let plain = Connection::open_with_flags(path, flags)?;
    plain.busy_timeout(BUSY)?;
    if readable(&plain).is_ok() {
        return Ok(plain);
    }
    // In a read-only folder SQLite opens a database only if it is declared immutable. It then ignores
    // the log, so there must be none.
    let log = path.with_extension("sqlite-wal");
    if log.metadata().is_ok_and(|metadata| metadata.len() > 0) {
        let reason = "a log lies beside the ledger and cannot be read here; copy the folder to \
                      where it can be written";
        return Err(StoreError::Broken {
            reason: reason.into(),
        });
    }
    let odd = |byte: &u8| !(byte.is_ascii_alphanumeric() || b"/._-".contains(byte));
    let mut address = String::from("file:");
    for byte in path.as_os_str().as_encoded_bytes() {
        if odd(byte) {
            address += &format!("%{byte:02X}");
        } else {
            address.push(char::from(*byte));
        }
    }
    address += "?immutable=1";
    let fixed = Connection::open_with_flags(address, flags | OpenFlags::SQLITE_OPEN_URI)?;
    readable(&fixed)?;
    Ok(fixed)
}

fn version_of(connection: &Connection) -> Result<i64, StoreError> {
    Ok(connection.query_row("PRAGMA user_version", [], |row| row.get(0))?)
}

fn other_version(version: i64) -> StoreError {
    let expected = schema::VERSION;
    let way_out = match version {
        2 | 3 => "start the service on them once, which makes them new",
        ..2 => "no program takes them over",
        _ => "take the program that made them, or a newer one",
    };
    StoreError::Broken {
        reason: format!(
            "the data have version {version}, this program takes {expected}; {way_out}"
        ),
    }
}

/// Makes the tables, or upgrades those of an earlier version, in one transaction.
fn upgrade(connection: &Connection) -> Result<(), StoreError> {
    let begun = connection.unchecked_transaction()?;
    let version = version_of(connection)?;
    match version {
        schema::VERSION => return Ok(()),
        0 => {}
        2 => begun.execute_batch(&[schema::FROM_2, schema::FROM_3].concat())?,
        3 => begun.execute_batch(schema::FROM_3)?,
        version => return Err(other_version(version)),
    }
    begun.execute_batch(schema::TABLES)?;
    if version != 0 {
        tokens::seal(connection)?;
    }
    begun.pragma_update(None, "user_version", schema::VERSION)?;
    Ok(begun.commit()?)
}

/// Makes one change of a group in a savepoint, so that its failure does not undo the others.
fn in_savepoint<T>(
    connection: &Connection,
    change: impl FnOnce(&Connection) -> Result<T, StoreError>,
) -> Result<T, StoreError> {
    connection.execute_batch("SAVEPOINT one")?;
    let outcome = change(connection);
    let end = if outcome.is_ok() {
        "RELEASE one"
    } else {
        "ROLLBACK TO one; RELEASE one"
    };
    connection.execute_batch(end)?;
    outcome
}

fn write_in_groups(connection: &Connection, waiting: &Receiver<Change>) {
    let (mut is_settled, mut emptied) = (true, Instant::now());
    loop {
        if !is_settled && emptied.elapsed() >= SETTLE {
            is_settled = empty_log(connection);
            emptied = Instant::now();
        }
        let first = match waiting.recv_timeout(SETTLE) {
            Ok(first) => first,
            Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => continue,
        };
        is_settled = false;
        let begun = connection.execute_batch("BEGIN IMMEDIATE");
        let mut group = vec![first(connection)];
        while group.len() < GROUP
            && let Ok(next) = waiting.try_recv()
        {
            group.push(next(connection));
        }
        let committed = begun
            .and_then(|()| connection.execute_batch("COMMIT"))
            .map_err(StoreError::from);
        if let Err(error) = &committed {
            tracing::error!(%error, changes = group.len(), "a group was not committed");
            // After a full disk the transaction may have been rolled back already.
            let _ = connection.execute_batch("ROLLBACK");
        }
        for after in group {
            after(committed.clone());
        }
    }
}

/// Writes the log into the ledger; false if readers prevent it.
fn empty_log(connection: &Connection) -> bool {
    let sql = "PRAGMA wal_checkpoint(TRUNCATE)";
    // Without waiting for readers: changes wait for this thread.
    let _ = connection.busy_timeout(Duration::ZERO);
    let is_busy = connection.query_row(sql, [], |row| row.get::<_, i64>(0));
    let _ = connection.busy_timeout(BUSY);
    matches!(is_busy, Ok(0))
}

/// Reads a design whose columns begin with `first`.
fn design_of(row: &Row<'_>, first: usize) -> Result<StoredDesign, StoreError> {
    let (name, version): (String, i64) = (row.get(first)?, row.get(first + 1)?);
    let (body, sum): (String, String) = (row.get(first + 2)?, row.get(first + 3)?);
    confirmed("design", &format!("{name}@{version}"), &body, &sum)
}

impl Ledger for SqliteLedger {
    fn program(&self) -> &str {
        &self.program
    }

    fn put_recording(
        &self,
        manifest: &Manifest,
        owner: &str,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        let (id, bytes, owner) = (manifest.id(), manifest.bytes(), owner.to_string());
        let name = manifest.name.clone();
        let body = text_of(&recordings::RecordingBody {
            manifest: manifest.clone(),
            created_ms: now_ms,
            renewed_ms: now_ms,
        });
        self.write(move |connection| {
            let sum = of_row("recording", &id, &body);
            let added = connection.execute(
                "INSERT OR IGNORE INTO recordings (id, owner, bytes, body, sum, name, created_ms)
                 VALUES (?, ?, ?, ?, ?, ?, ?)",
                params![id, owner, bytes as i64, body, sum, name, now_ms],
            )?;
            if added == 1 {
                return Ok(true);
            }
            match recordings::find(connection, &id) {
                Err(StoreError::Damaged { .. }) => {
                    connection.execute(
                        "UPDATE recordings SET body = ?, sum = ?, listing = NULL, listing_sum = NULL WHERE id = ?",
                        params![body, sum, id],
                    )?;
                    Ok(true)
                }
                Err(error) => Err(error),
                Ok(stored) => {
                    // Its age by `keep_days` counts from the last upload.
                    if let Some(stored) = stored {
                        let body = text_of(&recordings::RecordingBody {
                            manifest: stored.manifest,
                            created_ms: stored.created_ms,
                            renewed_ms: now_ms,
                        });
                        let sum = of_row("recording", &id, &body);
                        let sql = "UPDATE recordings SET body = ?, sum = ? WHERE id = ?";
                        connection.execute(sql, params![body, sum, id])?;
                    }
                    Ok(false)
                }
            }
        })
    }

    fn put_listing(&self, id: &str, listing: &Value) -> Result<(), StoreError> {
        let (id, listing) = (id.to_string(), text_of(listing));
        self.write(move |connection| {
            let sum = of_row("listing", &id, &listing);
            connection.execute(
                "UPDATE recordings SET listing = ?, listing_sum = ? WHERE id = ?",
                params![listing, sum, id],
            )?;
            Ok(())
        })
    }

    fn recording(&self, id: &str) -> Result<Option<StoredRecording>, StoreError> {
        self.read(|connection| recordings::find(connection, id))
    }

    fn recordings(&self, filter: &RecordingFilter) -> Result<Page<ListedRecording>, StoreError> {
        self.read(|connection| recordings::list(connection, filter))
    }

    fn delete_recording(
        &self,
        id: &str,
        deleted_by: &str,
        why: &str,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        let (id, deleted_by, why) = (id.to_string(), deleted_by.to_string(), why.to_string());
        self.write(move |connection| deletions::delete(connection, &id, &deleted_by, &why, now_ms))
    }

    fn deletion(&self, id: &str) -> Result<Option<Deletion>, StoreError> {
        self.read(|connection| deletions::find(connection, id))
    }

    fn deletions(&self, before: Option<i64>, limit: u32) -> Result<Page<Deletion>, StoreError> {
        self.read(|connection| deletions::list(connection, before, limit))
    }

    fn note_upkeep(&self, now_ms: i64) -> Result<Option<i64>, StoreError> {
        self.write(move |connection| {
            let before = connection
                .query_row("SELECT at_ms FROM looked", [], |row| row.get(0))
                .optional()?;
            connection.execute(
                "INSERT OR REPLACE INTO looked (number, at_ms) VALUES (1, ?)",
                [now_ms],
            )?;
            Ok(before)
        })
    }

    fn aged_recordings(&self, before_ms: i64) -> Result<Vec<String>, StoreError> {
        self.read(|connection| deletions::aged(connection, before_ms))
    }

    fn open_deletions(&self) -> Result<(Vec<i64>, BTreeSet<String>), StoreError> {
        self.read(deletions::open)
    }

    fn extend_deletion(&self, id: &str, files: &BTreeSet<String>) -> Result<(), StoreError> {
        let (id, files) = (id.to_string(), files.clone());
        self.write(move |connection| deletions::extend(connection, &id, &files))
    }

    fn needed_of(
        &self,
        files: &BTreeSet<String>,
        after: LastRows,
    ) -> Result<(BTreeSet<String>, LastRows), StoreError> {
        self.read(|connection| needed::among(connection, files, after))
    }

    fn close_deletions(&self, numbers: &[i64]) -> Result<(), StoreError> {
        let numbers = numbers.to_vec();
        self.write(move |connection| deletions::close(connection, &numbers))
    }

    fn bytes_of(&self, owner: &str) -> Result<u64, StoreError> {
        self.read(|connection| {
            let bytes: i64 = connection.query_row(
                "SELECT coalesce(sum(bytes), 0) FROM recordings WHERE owner = ?",
                [owner],
                |row| row.get(0),
            )?;
            Ok(bytes.unsigned_abs())
        })
    }

    fn submit(
        &self,
        id: &str,
        question: &Question,
        owner: &str,
    ) -> Result<(Job, bool), StoreError> {
        let (id, question, owner) = (id.to_string(), question.clone(), owner.to_string());
        let program = Arc::clone(&self.program);
        self.write(move |connection| jobs::submit(connection, &id, &question, &owner, &program))
    }

    fn job(&self, id: &str) -> Result<Option<Job>, StoreError> {
        self.read(|connection| jobs::find(connection, id))
    }

    fn take(&self, now_ms: i64, lease_ms: i64) -> Result<Option<Job>, StoreError> {
        self.take_of(jobs::WAITING, now_ms, lease_ms)
    }

    fn take_question(&self, now_ms: i64, lease_ms: i64) -> Result<Option<Job>, StoreError> {
        self.take_of(jobs::QUESTIONS, now_ms, lease_ms)
    }

    fn hold(&self, id: &str, attempt: i64, lease_ms: i64) -> Result<(), StoreError> {
        let id = id.to_string();
        self.write(move |connection| jobs::hold(connection, &id, attempt, lease_ms))
    }

    fn finish(&self, id: &str, attempt: i64, result: &StoredResult) -> Result<(), StoreError> {
        let (id, mut result) = (id.to_string(), result.clone());
        let program = Arc::clone(&self.program);
        self.write(move |connection| {
            if deletions::find(connection, &result.recording)?.is_some() {
                return Err(StoreError::Deleted);
            }
            result.asked_by = jobs::owner(connection, &id)?;
            results::put(connection, &result)?;
            let answer = Value::from(result.report_id);
            jobs::end(connection, &id, attempt, "done", &answer, &program)
        })
    }

    fn decide(&self, id: &str, attempt: i64, row: &Value) -> Result<(), StoreError> {
        let (id, row) = (id.to_string(), row.clone());
        let program = Arc::clone(&self.program);
        self.write(move |connection| jobs::end(connection, &id, attempt, "done", &row, &program))
    }

    fn refuse(
        &self,
        id: &str,
        attempt: i64,
        problem: &Value,
        lasts: bool,
    ) -> Result<(), StoreError> {
        let (id, problem) = (id.to_string(), problem.clone());
        // A refusal without a program never stands: `submit` compares the names.
        let program = if lasts {
            Arc::clone(&self.program)
        } else {
            "".into()
        };
        self.write(move |connection| {
            jobs::end(connection, &id, attempt, "refused", &problem, &program)
        })
    }

    fn give_back(
        &self,
        id: &str,
        attempt: i64,
        counts: bool,
        not_before_ms: i64,
    ) -> Result<i64, StoreError> {
        let id = id.to_string();
        self.write(move |connection| {
            jobs::give_back(connection, &id, attempt, counts, not_before_ms)
        })
    }

    fn reclaim(&self, now_ms: i64, every: bool) -> Result<usize, StoreError> {
        self.write(move |connection| jobs::reclaim(connection, now_ms, every))
    }

    fn requeue(&self, id: &str) -> Result<(), StoreError> {
        let id = id.to_string();
        self.write(move |connection| jobs::requeue(connection, &id))
    }

    fn remake(&self, report_id: &str, lost: &str) -> Result<Remake, StoreError> {
        let (report_id, lost) = (report_id.to_string(), lost.to_string());
        self.write(move |connection| remake(connection, &report_id, &lost))
    }

    fn census(&self) -> Result<Census, StoreError> {
        self.read(|connection| {
            let sum = |sql: &str| -> Result<u64, StoreError> {
                let sum: i64 = connection.query_row(sql, [], |row| row.get(0))?;
                Ok(sum.unsigned_abs())
            };
            Ok(Census {
                oldest_ms: jobs::oldest_ms(connection)?,
                recording_bytes: sum("SELECT coalesce(sum(bytes), 0) FROM recordings")?,
                open_gates: sum("SELECT count(*) FROM gates WHERE outcome IS NULL")?,
            })
        })
    }

    fn probe(&self) -> Result<(), StoreError> {
        self.write(|connection| {
            Ok(connection.pragma_update(None, "user_version", schema::VERSION)?)
        })
    }

    fn place(&self, id: &str) -> Result<Option<QueuePlace>, StoreError> {
        self.read(|connection| jobs::place(connection, id))
    }

    fn load(&self, owner: &str) -> Result<Load, StoreError> {
        self.read(|connection| jobs::load(connection, owner))
    }

    fn result(&self, report_id: &str) -> Result<Option<StoredResult>, StoreError> {
        self.read(|connection| results::find(connection, report_id))
    }

    fn results(&self, filter: &ResultFilter) -> Result<Page<StoredResult>, StoreError> {
        self.read(|connection| results::list(connection, filter))
    }

    fn put_design(
        &self,
        name: &str,
        design: &Value,
        owner: &str,
        now_ms: i64,
    ) -> Result<StoredDesign, StoreError> {
        let stored = StoredDesign {
            name: name.into(),
            version: 1,
            design: design.clone(),
            created_ms: now_ms,
            owner: owner.into(),
        };
        self.write(move |connection| put_design(connection, stored))
    }

    fn designs_of(&self, owner: &str) -> Result<u64, StoreError> {
        let sql = "SELECT count(*) FROM designs WHERE owner = ? AND NOT is_deleted";
        let count: i64 =
            self.read(|connection| Ok(connection.query_row(sql, [owner], |row| row.get(0))?))?;
        Ok(count.unsigned_abs())
    }

    fn delete_design(&self, name: &str, version: i64) -> Result<bool, StoreError> {
        let name = name.to_string();
        self.write(move |connection| {
            let sql = "UPDATE designs SET is_deleted = 1
                       WHERE name = ? AND version = ? AND NOT is_deleted";
            Ok(connection.execute(sql, params![name, version])? > 0)
        })
    }

    fn design(&self, name: &str, version: Option<i64>) -> Result<Option<StoredDesign>, StoreError> {
        self.read(|connection| {
            let mut designs = rows(
                connection,
                "SELECT name, version, body, sum FROM designs
                 WHERE name = ?1 AND (?2 IS NULL OR version = ?2) AND NOT is_deleted
                 ORDER BY version DESC LIMIT 1",
                params![name, version],
                |row| design_of(row, 0),
            )?;
            Ok(designs.pop())
        })
    }

    fn designs(&self, skipped: u32, limit: u32) -> Result<Page<StoredDesign>, StoreError> {
        self.read(|connection| {
            let mut designs = page(
                connection,
                "SELECT rowid, name, version, body, sum FROM designs WHERE NOT is_deleted
                 ORDER BY name, version DESC LIMIT ? OFFSET ?",
                params![limit, skipped],
                limit,
                |row| design_of(row, 1),
            )?;
            designs.next = designs.next.map(|_| i64::from(skipped) + i64::from(limit));
            Ok(designs)
        })
    }

    fn put_gate(
        &self,
        gate: &StoredGate,
        pairs: Vec<Question>,
        owner: &str,
    ) -> Result<bool, StoreError> {
        let (gate, owner) = (gate.clone(), owner.to_string());
        let program = Arc::clone(&self.program);
        self.write(move |connection| gates::put(connection, &gate, &pairs, &owner, &program))
    }

    fn gate(&self, id: &str) -> Result<Option<GateStanding>, StoreError> {
        self.read(|connection| gates::find(connection, id))
    }

    fn gates(&self, before: Option<i64>, limit: u32) -> Result<Page<GateStanding>, StoreError> {
        self.read(|connection| gates::list(connection, before, limit))
    }

    fn open_gates(&self) -> Result<Page<GateStanding>, StoreError> {
        self.read(gates::open)
    }

    fn pairs(&self, id: &str) -> Result<Vec<Job>, StoreError> {
        self.read(|connection| gates::pairs(connection, id))
    }

    fn end_gate(&self, id: &str, outcome: &GateOutcome) -> Result<(), StoreError> {
        let (id, outcome) = (id.to_string(), outcome.clone());
        self.write(move |connection| gates::end(connection, &id, &outcome))
    }

    fn change(&self) -> Result<i64, StoreError> {
        let mut watcher = self
            .watcher
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let connection = match &mut *watcher {
            Some(connection) => connection,
            none => none.insert(connect(&self.path)?),
        };
        let mut statement = connection.prepare_cached("PRAGMA data_version")?;
        Ok(statement.query_row([], |row| row.get(0))?)
    }

    fn put_token(&self, token: &StoredToken) -> Result<i64, StoreError> {
        let token = token.clone();
        self.write(move |connection| tokens::put(connection, &token))
    }

    fn end_token(&self, number: i64, ends_ms: Option<i64>) -> Result<(), StoreError> {
        self.write(move |connection| tokens::end(connection, number, ends_ms))
    }

    fn used_token(&self, number: i64, now_ms: i64) -> Result<(), StoreError> {
        self.write(move |connection| tokens::used(connection, number, now_ms))
    }

    fn tokens(&self) -> Result<Vec<StoredToken>, StoreError> {
        self.read(tokens::list)
    }

    fn put_session(&self, session: &StoredSession) -> Result<(), StoreError> {
        let session = session.clone();
        self.write(move |connection| tokens::put_session(connection, &session))
    }

    fn sessions(&self) -> Result<Vec<StoredSession>, StoreError> {
        self.read(tokens::sessions)
    }

    fn end_session(&self, sha256: &str) -> Result<(), StoreError> {
        let sha256 = sha256.to_string();
        self.write(move |connection| tokens::end_session(connection, &sha256))
    }

    fn settle(&self) -> Result<(), StoreError> {
        let connection = connect(&self.path)?;
        empty_log(&connection);
        Ok(())
    }

    fn copy_to(&self, path: &Path) -> Result<(), StoreError> {
        let path = path.to_str().ok_or_else(|| StoreError::Broken {
            reason: "the copy needs a path that is text (UTF-8)".into(),
        })?;
        self.read(|connection| Ok(connection.execute("VACUUM INTO ?", [path]).map(|_| ())?))
    }

    fn named_files(&self) -> Result<CheckedFiles, StoreError> {
        self.read(needed::named)
    }

    fn check(&self) -> Result<CheckedFiles, StoreError> {
        self.read(check)
    }
}

/// Reads every row; returns the damaged rows and the files that the others name.
fn check(connection: &Connection) -> Result<CheckedFiles, StoreError> {
    let mut damaged = Vec::new();
    let integrity: String = connection.query_row("PRAGMA integrity_check", [], |row| row.get(0))?;
    if integrity != "ok" {
        damaged.push(format!("the database: {integrity}"));
    }
    let named = needed::named(connection)?;
    damaged.extend(named.damaged);
    let sql = "SELECT name, version, body, sum FROM designs";
    for design in rows(connection, sql, [], |row| Ok(design_of(row, 0)))? {
        needed::value_or_damage(design, &mut damaged)?;
    }
    let sql = format!("SELECT {} FROM deletions", deletions::COLUMNS);
    for deletion in rows(connection, &sql, [], |row| Ok(deletions::body_of(row)))? {
        needed::value_or_damage(deletion, &mut damaged)?;
    }
    for job in rows(connection, jobs::EVERY, [], |row| Ok(jobs::job_of(row)))? {
        needed::value_or_damage(job, &mut damaged)?;
    }
    damaged.extend(tokens::damaged(connection)?);
    Ok(CheckedFiles {
        damaged,
        files: named.files,
    })
}

fn remake(connection: &Connection, report_id: &str, lost: &str) -> Result<Remake, StoreError> {
    let Some(mut result) = results::find(connection, report_id)? else {
        return Ok(Remake::Impossible);
    };
    if let Some(deletion) = deletions::find(connection, &result.recording)? {
        return Ok(Remake::Deleted(deletion));
    }
    let Some(job) = jobs::find(connection, &result.job)? else {
        return Ok(Remake::Impossible);
    };
    if job.question.id() != job.id {
        return Ok(Remake::OtherNumbers(result.numbers_revision));
    }
    if result.lost.insert(lost.into()) {
        let body = text_of(&result);
        let sum = of_row("result", report_id, &body);
        let sql = "UPDATE results SET body = ?, sum = ? WHERE report_id = ?";
        connection.execute(sql, params![body, sum, report_id])?;
    }
    jobs::requeue(connection, &job.id)?;
    Ok(jobs::find(connection, &job.id)?.map_or(Remake::Impossible, Remake::Waits))
}

fn put_design(
    connection: &Connection,
    mut stored: StoredDesign,
) -> Result<StoredDesign, StoreError> {
    let newest = connection
        .query_row(
            "SELECT name, version, body, sum, is_deleted FROM designs WHERE name = ?
             ORDER BY version DESC LIMIT 1",
            [&stored.name],
            |row| Ok((design_of(row, 0), row.get::<_, bool>(4)?)),
        )
        .optional()?;
    if let Some((newest, is_deleted)) = newest {
        let newest = newest?;
        if newest.design == stored.design && !is_deleted {
            return Ok(newest);
        }
        stored.version = newest.version + 1;
    }
    let body = text_of(&stored);
    let key = stored.reference();
    connection.execute(
        "INSERT INTO designs (name, version, body, sum, owner) VALUES (?, ?, ?, ?, ?)",
        params![
            stored.name,
            stored.version,
            body,
            of_row("design", &key, &body),
            stored.owner
        ],
    )?;
    Ok(stored)
}
