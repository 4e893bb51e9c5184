//! State that all handlers share.

use crate::allowances::Allowances;
use crate::audit;
use crate::auth::{Door, SessionTimes, Visitor};
use crate::clock::now_ms;
use crate::config::Config;
use crate::pool::Crew;
use crate::problem::Problem;
use crate::store::{
    self, BlobFolder, Blobs, Ledger, Manifest, SqliteLedger, StoreError, StoredFile,
    StoredRecording,
};
use crate::supply::Supply;
use crate::traffic::Traffic;
use axum::http::StatusCode;
use latchgate::pipeline::pulse;
use std::collections::HashMap;
use std::fmt::Display;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::Semaphore;
use tokio::time::timeout;

/// Memory for the bodies of requests in progress, without uploads [bytes].
pub(crate) const BODIES_BYTES: u64 = 32 << 20;

/// Files (inodes) that uploads and jobs leave free on the disk: more than an upload or a report takes.
pub(crate) const FREE_FILES: u64 = 128;

/// Number of pages made at a time from whole reports; each may take some 40 MB.
const PAGES: usize = 1;

/// Returns the recording that a pulse is: its name and its content are its canonical word.
///
/// # Errors
///
/// A problem: the word is not a pulse, or names a file.
pub fn recording_of_pulse(word: &str) -> Result<Manifest, Problem> {
    let word = pulse::canonical(word, None).map_err(|error| Problem::of_recording(&error))?;
    let file = StoredFile {
        name: word.clone(),
        sha256: store::sha256_hex(word.as_bytes()),
        bytes: word.len() as u64,
    };
    Ok(Manifest {
        name: word,
        files: vec![file],
        card: None,
    })
}

/// State that all handlers share.
#[derive(Clone)]
pub struct App(Arc<Parts>);

/// The parts of the service.
pub struct Parts {
    /// The configuration.
    pub config: Config,
    /// Recordings, jobs, results, designs, tokens.
    pub ledger: Arc<dyn Ledger>,
    /// Bytes.
    pub blobs: Arc<dyn Blobs>,
    /// Children.
    pub crew: Crew,
    /// Tokens.
    pub door: Door,
    /// Rate limits by token.
    pub of_tokens: Allowances,
    /// Rate limits by address, of requests without a token.
    pub of_addresses: Allowances,
    /// Last trial write of the ledger, if there was one.
    pub probed: Arc<tokio::sync::Mutex<Option<Probed>>>,
    /// Counters of requests.
    pub traffic: Traffic,
    /// Bytes reserved for uploads in progress, by the name of their token.
    pub under_way: Mutex<HashMap<String, u64>>,
    /// Memory for the bodies of requests that are no uploads [bytes].
    pub bodies: Arc<Supply>,
    /// Permits to make pages from whole reports.
    pub pages: Semaphore,
    /// Lock of the removal of deleted files; a second caller waits and finds nothing left to remove.
    pub sweeping: tokio::sync::Mutex<()>,
    /// True once the service ends and takes no more work.
    pub ends: AtomicBool,
    /// Lock of the data folder; released when the process ends.
    _lock: Option<File>,
}

/// Instant and outcome of a trial write of the ledger.
pub type Probed = (Instant, Result<(), StoreError>);

/// Time for which the outcome of a trial write is reused.
const PROBED: Duration = Duration::from_secs(1);

/// Longest time of a trial write.
const WRITTEN: Duration = Duration::from_secs(5);

impl std::ops::Deref for App {
    type Target = Parts;

    fn deref(&self) -> &Parts {
        &self.0
    }
}

impl Parts {
    /// Deletes recordings; returns the number that existed.
    ///
    /// # Errors
    ///
    /// [`StoreError`]; recordings before the failing one stay deleted.
    pub fn delete(
        &self,
        recordings: &[String],
        deleted_by: &str,
        why: &str,
        from: impl Display,
    ) -> Result<u64, StoreError> {
        let mut deleted = 0;
        for id in recordings {
            if self
                .ledger
                .delete_recording(id, deleted_by, why, now_ms())?
            {
                deleted += 1;
                audit::record("recording deleted", id, deleted_by, &from);
            }
        }
        self.sweep()?;
        Ok(deleted)
    }

    /// Stores a pulse as a recording, in the share of its owner.
    ///
    /// # Errors
    ///
    /// A problem: the share is used up, or the disk refuses.
    pub fn keep_pulse(&self, pulse: &Manifest, owner: &str) -> Result<(), Problem> {
        let kept = self.ledger.bytes_of(owner)?;
        if kept.saturating_add(pulse.bytes()) > self.config.own_bytes {
            let found = format!("{kept} bytes, and a pulse to come");
            return Err(Problem::beyond_share(self.config.own_bytes, found));
        }
        let placing = self.blobs.placing();
        let _together = placing.read().unwrap_or_else(PoisonError::into_inner);
        let mut blob = self.blobs.begin()?;
        blob.write(pulse.name.as_bytes())?;
        blob.finish(&pulse.name)?;
        self.ledger.put_recording(pulse, owner, now_ms())?;
        Ok(())
    }

    /// Removes the files of deleted recordings.
    ///
    /// # Errors
    ///
    /// [`StoreError`]; what stays is removed the next time.
    pub fn sweep(&self) -> Result<(), StoreError> {
        store::sweep(&*self.ledger, &*self.blobs)
    }

    /// Finds a recording.
    ///
    /// # Errors
    ///
    /// A problem: it was deleted, there is none, or its row is damaged.
    pub fn recording(&self, id: &str) -> Result<StoredRecording, Problem> {
        if let Some(recording) = self.ledger.recording(id)? {
            return Ok(recording);
        }
        Err(match self.ledger.deletion(id)? {
            Some(deletion) => Problem::deleted(&deletion),
            None => Problem::not_found("such recording; upload it to /v1/recordings first"),
        })
    }
}

impl App {
    /// Returns the state of a service that begins.
    pub fn new(config: Config, store: Store, crew: Crew) -> Self {
        let times = SessionTimes {
            idle_ms: config.session_idle.as_millis() as i64,
            whole_ms: config.session.as_millis() as i64,
        };
        Self(Arc::new(Parts {
            config,
            ledger: store.ledger,
            blobs: store.blobs,
            crew,
            door: Door::new(times),
            of_tokens: Allowances::default(),
            of_addresses: Allowances::default(),
            probed: Arc::default(),
            traffic: Traffic::default(),
            under_way: Mutex::default(),
            bodies: Supply::new(BODIES_BYTES),
            pages: Semaphore::new(PAGES),
            sweeping: tokio::sync::Mutex::default(),
            ends: AtomicBool::new(false),
            _lock: store.lock,
        }))
    }

    /// Runs work that may wait for the disk.
    ///
    /// # Errors
    ///
    /// As `work`; a problem if it ends without saying so.
    pub async fn on_disk<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Parts) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, Problem> {
        self.apart(move |parts| Ok(work(parts)?)).await
    }

    /// Runs work that may wait for the disk or take long.
    ///
    /// # Errors
    ///
    /// As `work`; a problem if it ends without saying so.
    pub async fn apart<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Parts) -> Result<T, Problem> + Send + 'static,
    ) -> Result<T, Problem> {
        let app = self.clone();
        let done = tokio::task::spawn_blocking(move || work(&app)).await;
        match done {
            Ok(outcome) => outcome,
            Err(error) => {
                tracing::error!(%error, "work on the disk ended");
                let reason = "work on the disk ended".into();
                Err(StoreError::Broken { reason }.into())
            }
        }
    }

    /// Checks by a trial write that the ledger can be written: at most once a second, and on one thread
    /// at a time, however long a write takes.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if it cannot, or not in time.
    pub async fn probe(&self) -> Result<(), StoreError> {
        let (app, probed) = (self.clone(), Arc::clone(&self.probed));
        let probing = async move {
            let mut probed = probed.lock_owned().await;
            let probing = tokio::task::spawn_blocking(move || match &*probed {
                Some((when, outcome)) if when.elapsed() < PROBED => outcome.clone(),
                _ => {
                    let outcome = app.ledger.probe();
                    *probed = Some((Instant::now(), outcome.clone()));
                    outcome
                }
            });
            probing.await
        };
        let broken = |reason: String| Err(StoreError::Broken { reason });
        match timeout(WRITTEN, probing).await {
            Ok(Ok(outcome)) => outcome,
            Ok(Err(error)) => broken(error.to_string()),
            Err(_) => broken(format!(
                "nothing was written within {} s",
                WRITTEN.as_secs()
            )),
        }
    }

    /// Refuses more data if the disk is nearly full or the service ends.
    ///
    /// # Errors
    ///
    /// The problem that says so.
    pub fn admit_bytes(&self, bytes: u64) -> Result<(), Problem> {
        if self.ends.load(Ordering::Relaxed) {
            let text = "the service is ending; try again";
            return Err(Problem::busy(StatusCode::SERVICE_UNAVAILABLE, text, 2));
        }
        let free = self.blobs.free().map_err(Problem::from)?;
        let over = |name: &str, value: u64, found: String, way_out: &str| {
            let status = StatusCode::INSUFFICIENT_STORAGE;
            Err(Problem {
                retry_after_s: Some(5),
                ..Problem::over(status, name, value, found, way_out)
            })
        };
        let free_bytes_min = self.config.free_bytes;
        if free.bytes < free_bytes_min.saturating_add(bytes) {
            let found = format!("{} bytes free, {bytes} to come", free.bytes);
            let way_out = "free space where the data lie, or lower `free_mib` in the service's \
                           configuration; nothing that was acknowledged is lost";
            return over("free_bytes", free_bytes_min, found, way_out);
        }
        if let Some(files) = free.files.filter(|files| *files < FREE_FILES) {
            let found = format!("{files} files free (df -i)");
            let way_out = "remove files where the data lie, or take a disk with more inodes; \
                           nothing that was acknowledged is lost";
            return over("free_files", FREE_FILES, found, way_out);
        }
        Ok(())
    }

    /// Reserves the bytes of an upload in its token's share, so that several at once cannot exceed it together;
    /// `length` is the length that the request states [bytes].
    ///
    /// # Errors
    ///
    /// A problem if the ledger cannot be read.
    pub async fn reserve(&self, owner: &str, length: Option<u64>) -> Result<Reserved, Problem> {
        let (app, owner) = (self.clone(), owner.to_string());
        self.on_disk(move |parts| {
            let mut under_way = locked(&parts.under_way);
            let kept = parts.ledger.bytes_of(&owner)?;
            let reserved = under_way.entry(owner.clone()).or_default();
            let share = parts.config.own_bytes;
            let left_bytes = share.saturating_sub(kept).saturating_sub(*reserved);
            let bytes = length.unwrap_or(parts.config.upload_bytes).min(left_bytes);
            *reserved += bytes;
            drop(under_way);
            Ok(Reserved {
                app,
                owner,
                bytes,
                left_bytes,
            })
        })
        .await
    }

    /// Refuses jobs if the visitor, or all visitors together, have too many.
    ///
    /// # Errors
    ///
    /// The problem that says so.
    pub fn admit_jobs(&self, visitor: &Visitor, count: u64) -> Result<(), Problem> {
        self.admit_bytes(1 << 20)?;
        let load = self.ledger.load(&visitor.name)?;
        let jobs_max = self.config.own_queue;
        if load.owner_jobs.saturating_add(count) > jobs_max {
            let found = format!(
                "{count} more than the {} of this token that wait",
                load.owner_jobs
            );
            let status = StatusCode::TOO_MANY_REQUESTS;
            return Err(Problem::later(status, "own_queue", jobs_max, found, 5));
        }
        let queue_max = self.config.queue;
        if load.queued.saturating_add(count) > queue_max {
            let found = format!("{count} more than the {} that wait", load.queued);
            let status = StatusCode::SERVICE_UNAVAILABLE;
            return Err(Problem::later(status, "queue", queue_max, found, 5));
        }
        Ok(())
    }
}

/// Bytes reserved in a token's share while an upload is in progress.
pub struct Reserved {
    app: App,
    owner: String,
    bytes: u64,
    left_bytes: u64,
}

impl Reserved {
    /// Returns the bytes that the token may still upload.
    pub fn left_bytes(&self) -> u64 {
        self.left_bytes
    }
}

impl Drop for Reserved {
    fn drop(&mut self) {
        let mut under_way = locked(&self.app.under_way);
        if let Some(reserved) = under_way.get_mut(&self.owner) {
            *reserved -= self.bytes;
            if *reserved == 0 {
                under_way.remove(&self.owner);
            }
        }
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Name of the ledger's file in the folder of the data.
pub const LEDGER: &str = "ledger.sqlite";

/// The store of one data folder.
pub struct Store {
    /// The ledger.
    pub ledger: Arc<dyn Ledger>,
    /// The blobs.
    pub blobs: Arc<dyn Blobs>,
    /// Lock of the process that serves the folder.
    lock: Option<File>,
}

impl Store {
    /// Opens the store to serve it; one process at a time can.
    ///
    /// # Errors
    ///
    /// What is in the way, in a sentence.
    pub fn open(config: &Config) -> Result<Self, String> {
        let data = config.data.as_path();
        let shown = data.display();
        let cannot = |error: io::Error| format!("{shown}: {error}");
        own_folder(data)?;
        let lock = File::create(data.join("lock")).map_err(cannot)?;
        rustix::fs::flock(&lock, rustix::fs::FlockOperation::NonBlockingLockExclusive).map_err(
            |_| {
                format!(
                    "{shown}: another process serves this folder; end it first, or name another \
                     folder with --data"
                )
            },
        )?;
        let error_text = |error: StoreError| format!("{shown}: {error}");
        let ledger = SqliteLedger::open(&data.join(LEDGER)).map_err(error_text)?;
        let order_s = config.order_time.as_secs();
        Ok(Self {
            ledger: Arc::new(ledger.with_limits(config.child_memory_bytes, order_s)),
            blobs: Arc::new(BlobFolder::open(&data.join("blobs")).map_err(error_text)?),
            lock: Some(lock),
        })
    }

    /// Opens the store while another process may be serving it; makes it if absent.
    ///
    /// # Errors
    ///
    /// What is in the way, in a sentence.
    pub fn beside(data: &Path) -> Result<Self, String> {
        own_folder(data)?;
        Self::with(data, SqliteLedger::open)
    }

    /// Opens an existing store read-only, while another process may be serving it, also on a read-only
    /// disk.
    ///
    /// # Errors
    ///
    /// What is in the way, in a sentence.
    pub fn read_only(data: &Path) -> Result<Self, String> {
        Self::is_there(data)?;
        Self::with(data, SqliteLedger::read_only)
    }

    /// Refuses a folder that holds no data.
    ///
    /// # Errors
    ///
    /// A sentence that says so.
    pub fn is_there(data: &Path) -> Result<(), String> {
        if data.join(LEDGER).is_file() {
            return Ok(());
        }
        let shown = data.display();
        Err(format!(
            "{shown}: there are no data here; name their folder with --data"
        ))
    }

    fn with(
        data: &Path,
        open: impl FnOnce(&Path) -> Result<SqliteLedger, StoreError>,
    ) -> Result<Self, String> {
        let shown = data.display();
        let ledger = open(&data.join(LEDGER)).map_err(|error| format!("{shown}: {error}"))?;
        Ok(Self {
            ledger: Arc::new(ledger),
            blobs: Arc::new(BlobFolder::beside(&data.join("blobs"))),
            lock: None,
        })
    }
}

/// Makes a folder for data, or accepts one that is empty or holds data; only its owner can enter.
///
/// # Errors
///
/// What is in the way, in a sentence.
pub fn own_folder(data: &Path) -> Result<(), String> {
    use std::os::unix::fs::PermissionsExt;
    let shown = data.display();
    let cannot = |error: io::Error| format!("{shown}: {error}");
    fs::create_dir_all(data).map_err(cannot)?;
    // The root of a disk has the folder lost+found.
    let counts = |entry: io::Result<fs::DirEntry>| {
        entry.is_ok_and(|entry| entry.file_name() != "lost+found")
    };
    let is_empty = !fs::read_dir(data).map_err(cannot)?.any(counts);
    let is_ours = |name: &str| data.join(name).exists();
    if !is_empty && !is_ours(LEDGER) && !is_ours("lock") {
        return Err(format!(
            "{shown}: the folder holds files that are none of latchgate's; name an empty one with \
             --data"
        ));
    }
    fs::set_permissions(data, fs::Permissions::from_mode(0o700)).map_err(cannot)
}
