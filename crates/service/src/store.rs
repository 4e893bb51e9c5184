//! What survives: recordings, jobs and results in SQLite, bytes in files named by their hash.
//!
//! Two traits divide the work. [`Ledger`] is what is known of recordings, jobs, results and
//! designs; [`Blobs`] is bytes by their SHA-256. What either has acknowledged survives the end of
//! the process and of power.
//!
//! - `ledger`: the ledger in SQLite, one writer that commits in groups;
//! - `jobs`: jobs with lease, attempts and fencing;
//! - `gates`: gates and their pairs;
//! - `recordings`, `results`: rows of these;
//! - `needed`: which blobs the rows name;
//! - `deletions`: recordings that were deleted, and what remains of them;
//! - `tokens`: tokens and sessions;
//! - `schema`: the tables;
//! - `folder`: blobs in a folder;
//! - `sql`: rows as text, confirmed by their hash;
//! - `sum`: the hash that every row carries.

mod deletions;
mod folder;
mod gates;
mod jobs;
mod ledger;
mod needed;
mod recordings;
mod results;
mod schema;
mod sql;
mod sum;
mod tokens;

pub use folder::{BlobFolder, BlobWriter};
pub use ledger::SqliteLedger;
pub use sum::{Hex, sha256_hex, sha256_of};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::{PoisonError, RwLock};
use std::time::{Duration, SystemTime};

/// Why something could not be stored or read back.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The disk is full.
    #[error(
        "the disk is full; free space where the data lie, nothing that was acknowledged is lost"
    )]
    Full,
    /// What was read does not fit its hash.
    #[error("{what} is damaged: its hash does not fit; restore it from a backup")]
    Damaged {
        /// What was read.
        what: String,
    },
    /// Another attempt holds the job, or it has ended.
    #[error("the job is held by another attempt")]
    Fenced,
    /// The recording was deleted meanwhile.
    #[error("the recording was deleted")]
    Deleted,
    /// The database or the file system refuses.
    #[error("the store does not work: {reason}")]
    Broken {
        /// The system's reason.
        reason: String,
    },
}

impl From<rusqlite::Error> for StoreError {
    fn from(error: rusqlite::Error) -> Self {
        use rusqlite::ErrorCode;
        match error.sqlite_error_code() {
            Some(ErrorCode::DiskFull) => Self::Full,
            Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => Self::Damaged {
                what: "the database".into(),
            },
            _ => Self::Broken {
                reason: error.to_string(),
            },
        }
    }
}

impl From<io::Error> for StoreError {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::Full,
            _ => Self::Broken {
                reason: error.to_string(),
            },
        }
    }
}

/// A file of an upload.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct StoredFile {
    /// Name, with `/` between folders.
    pub name: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
    /// Number of bytes.
    pub bytes: u64,
}

/// What was uploaded as one recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name of the file to read, or of the folder that the files form.
    pub name: String,
    /// The files, in the order of their names.
    pub files: Vec<StoredFile>,
    /// The card.
    pub card: Option<StoredFile>,
}

impl Manifest {
    /// Returns the recording's identity: the same files under the same names have the same one.
    pub fn id(&self) -> String {
        let mut manifest = self.clone();
        manifest.files.sort();
        let text = serde_json::to_string(&manifest).expect("a manifest is plain text and numbers");
        sha256_hex(text.as_bytes())
    }

    /// Returns how many bytes it has.
    pub fn bytes(&self) -> u64 {
        self.files
            .iter()
            .chain(&self.card)
            .map(|file| file.bytes)
            .sum()
    }
}

/// A recording that was uploaded.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredRecording {
    /// Its identity.
    pub id: String,
    /// What was uploaded.
    pub manifest: Manifest,
    /// Who uploaded it.
    pub owner: String,
    /// When it came [ms since 1970].
    pub created_ms: i64,
    /// When its bytes came last [ms since 1970]: its age counts from then.
    pub renewed_ms: i64,
    /// What it holds as its reader lists it, or the problem that kept it from being read; `None`
    /// before it was looked at.
    pub listing: Option<Value>,
}

/// A recording in a list.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, utoipa::ToSchema)]
pub struct ListedRecording {
    /// Its identity.
    pub id: String,
    /// Name of the file, or of the folder that the files form.
    pub name: String,
    /// Bytes of all files.
    pub bytes: u64,
    /// Who uploaded it.
    pub owner: String,
    /// When it came [ms since 1970].
    pub created_ms: i64,
    /// Channels that its reader found; absent before it was looked at.
    pub channels: Option<u64>,
    /// Verdicts on it.
    pub verdicts: u64,
}

/// The order of a list of recordings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum RecordingOrder {
    /// The newest first.
    #[default]
    Newest,
    /// The oldest first.
    Oldest,
    /// By name.
    Name,
    /// The largest first.
    Size,
    /// By who uploaded it.
    Owner,
}

/// What a list of recordings asks for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordingFilter {
    /// A part of the name, of who uploaded it, or of the identity.
    pub text: Option<String>,
    /// The order.
    pub order: RecordingOrder,
    /// What the part before gave as `next`.
    pub after: Option<i64>,
    /// Entries at most.
    pub limit: u32,
}

/// What remains of a recording that was deleted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Deletion {
    /// The recording's identity.
    pub recording: String,
    /// Its name.
    pub name: String,
    /// Who had uploaded it.
    pub owner: String,
    /// Bytes of its files.
    pub bytes: u64,
    /// When it came [ms since 1970].
    pub created_ms: i64,
    /// When it was deleted [ms since 1970].
    pub deleted_ms: i64,
    /// Who deleted it.
    pub by: String,
    /// Why: `asked`, or `keep_days` where it had grown too old.
    pub why: String,
}

/// What a job asks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Question {
    /// The recording's identity.
    pub recording: String,
    /// How it is read, conditioned and judged, every setting written out.
    pub request: Value,
    /// The lever, every number written out.
    pub design: Value,
    /// Name and version of the design, where it came from the store.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub design_name: Option<String>,
    /// Whether the decision alone is wanted, without report: a pair of a gate.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub decision_alone: bool,
}

impl Question {
    /// Names the question: the same one has the same name, whoever asks.
    pub fn id(&self) -> String {
        let plain = Self {
            design_name: None,
            ..self.clone()
        };
        let text = serde_json::to_string(&plain).expect("a question has text keys only");
        sha256_hex(format!("{}{text}", latchgate::pipeline::NUMBERS_REVISION).as_bytes())
    }
}

/// How far a job is.
#[derive(Debug, Clone, PartialEq)]
pub enum JobState {
    /// It waits.
    Queued,
    /// A child works on it.
    Running,
    /// It has been answered with the report of that identity.
    Done {
        /// The report.
        report_id: String,
    },
    /// The decision that was wanted alone.
    Decided {
        /// `row`, as the library writes it, with `sha256` and `channel` of what was judged.
        row: Value,
    },
    /// There is no answer, for a reason that does not change.
    Refused {
        /// The reason, a problem document.
        problem: Value,
    },
}

impl JobState {
    /// Tells whether nothing more will come.
    pub fn has_ended(&self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }

    /// Returns the word for it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Done { .. } | Self::Decided { .. } => "done",
            Self::Refused { .. } => "refused",
        }
    }
}

/// A job as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Hash of the question, under which the job is found.
    pub id: String,
    /// What it asks.
    pub question: Question,
    /// How far it is.
    pub state: JobState,
    /// Number of the attempt, counted up whenever a child takes it.
    pub attempt: i64,
    /// How often a child ended under it.
    pub failures: i64,
}

/// A result that is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredResult {
    /// The report's identity.
    pub report_id: String,
    /// The recording's identity.
    pub recording: String,
    /// What lists show: file, channel, design, verdict, peak, limit.
    pub summary: Summary,
    /// The files of the report by name.
    pub files: BTreeMap<String, StoredFile>,
    /// When it was made [ms since 1970].
    pub created_ms: i64,
    /// SHA-256 of the document without its `run`.
    pub content_sha256: String,
    /// The job that made it.
    #[serde(default)]
    pub job: String,
    /// Revision of the numbers with which it was made.
    #[serde(default)]
    pub numbers_revision: u32,
    /// Whether all but the document went with its recording.
    #[serde(default)]
    pub is_stripped: bool,
    /// Files that were found lost, and are made again.
    #[serde(default)]
    pub lost: BTreeSet<String>,
    /// Name of the token that asked first.
    #[serde(default)]
    pub asked_by: String,
}

/// What a list shows of a verdict.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Summary {
    /// The file.
    pub file: String,
    /// The channel.
    pub channel: Option<String>,
    /// The design's name.
    pub design: String,
    /// What of the design was changed, `key=value`.
    pub modified: Vec<String>,
    /// The same in words, behind the name; of a design that is not kept, what tells it from the
    /// paper's.
    #[serde(default)]
    pub changes: String,
    /// Name and version of the design, where it came from the store.
    pub design_version: Option<String>,
    /// The verdict.
    pub verdict: String,
    /// What the lever does, or what would decide it, in a sentence.
    #[serde(default)]
    pub headline: String,
    /// The declared opening direction; `null` where none was.
    #[serde(default)]
    pub opens_when: Option<String>,
    /// The first reason.
    pub why: String,
    /// Peak angle of the nominal run [rad].
    pub peak_angle_rad: Option<f64>,
    /// Its U, numerical plus interpolation error [rad].
    #[serde(default)]
    pub uncertainty_rad: Option<f64>,
    /// The limit angle [rad].
    pub threshold_rad: f64,
    /// Members of the ensemble that were judged; 0 for the nominal run alone.
    pub members: u64,
}

impl Summary {
    /// Returns how far the peak and its error stay below the limit, as part of the limit.
    pub fn margin(&self) -> Option<f64> {
        let highest = self.peak_angle_rad? + self.uncertainty_rad.unwrap_or(0.0);
        Some((self.threshold_rad - highest) / self.threshold_rad)
    }

    /// Names the design: with its version where it is kept, and with what was changed.
    pub fn full_design(&self) -> String {
        let design = self.design_version.as_ref().unwrap_or(&self.design);
        format!("{design}{}", self.changes)
    }
}

/// The order of a list of verdicts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ResultOrder {
    /// The newest first.
    #[default]
    Newest,
    /// The oldest first.
    Oldest,
    /// By file, then by channel.
    File,
    /// By verdict.
    Verdict,
    /// By design.
    Design,
}

/// What a list of results asks for; an absent field asks nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ResultFilter {
    /// The verdict.
    pub verdict: Option<String>,
    /// The recording's identity.
    pub recording: Option<String>,
    /// The design's name.
    pub design: Option<String>,
    /// A part of the file's, channel's or design's name.
    pub text: Option<String>,
    /// The order.
    pub order: ResultOrder,
    /// What the part before gave as `next`.
    pub after: Option<i64>,
    /// Entries at most.
    pub limit: u32,
}

/// A gate: stored recordings and designs, each with each, and what is required of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredGate {
    /// Hash of all that decides its outcome.
    pub id: String,
    /// Name.
    pub name: String,
    /// The gate file.
    pub text: String,
    /// Recordings in the order of their names in the gate.
    pub recordings: Vec<GateRecording>,
    /// Designs in the order of their names, every number written out.
    pub designs: Vec<Value>,
    /// Name and version in the store of those designs that were taken from there as they are.
    pub versions: BTreeMap<String, String>,
    /// The gate that it is compared with.
    pub baseline: Option<String>,
    /// Whether pairs of the baseline may be gone.
    pub allow_removed: bool,
    /// Whether what was not as required in the baseline and is no worse is let stand.
    pub no_worse: bool,
    /// The day against which exceptions are held, `YYYY-MM-DD`.
    pub date: String,
    /// The engine that judges it, where it is not judged here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub engine: Option<String>,
    /// When it came [ms since 1970].
    pub created_ms: i64,
}

/// A recording of a gate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateRecording {
    /// Its name in the gate.
    pub name: String,
    /// The recording's identity.
    pub id: String,
    /// How it is read, conditioned and judged.
    pub request: Value,
}

/// What came of a gate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateOutcome {
    /// The exit code that the command line would give.
    pub exit_code: u8,
    /// Pairs that are not as required.
    pub not_as_required: u64,
    /// Its files by name: `summary.json`, `summary.csv`, `junit.xml`, `summary.md`, `index.html`.
    pub files: BTreeMap<String, StoredFile>,
    /// Why there is no summary: a problem document.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<Value>,
}

/// How far a gate is.
#[derive(Debug, Clone, PartialEq)]
pub struct GateStanding {
    /// The gate.
    pub gate: StoredGate,
    /// Pairs that are decided.
    pub decided: u64,
    /// What came of it, once all pairs are.
    pub outcome: Option<GateOutcome>,
}

/// A design that is kept under a name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredDesign {
    /// Name.
    pub name: String,
    /// Version, counted from 1 for each name.
    pub version: i64,
    /// The design.
    pub design: Value,
    /// When it came [ms since 1970].
    pub created_ms: i64,
    /// Who submitted it.
    #[serde(default)]
    pub owner: String,
}

impl StoredDesign {
    /// Returns name and version, as questions use them.
    pub fn reference(&self) -> String {
        format!("{}@{}", self.name, self.version)
    }

    /// Finds a design by `name@version`, or by `name` the newest.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if it cannot be read.
    pub fn find(ledger: &dyn Ledger, reference: &str) -> Result<Option<Self>, StoreError> {
        match reference.rsplit_once('@') {
            None => ledger.design(reference, None),
            Some((name, version)) => match version.parse() {
                Ok(version) => ledger.design(name, Some(version)),
                Err(_) => Ok(None),
            },
        }
    }
}

/// Part of a list. A row that is damaged costs that row alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Page<T> {
    /// What is whole.
    pub entries: Vec<T>,
    /// Names of the rows that are damaged and left out.
    pub damaged: Vec<String>,
    /// Number of the last row, where more may follow.
    pub next: Option<i64>,
}

/// A token without its secret.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredToken {
    /// Its number; 0 before it is kept.
    pub number: i64,
    /// SHA-256 of the token.
    pub sha256: String,
    /// Who holds it.
    pub name: String,
    /// What tells it from the holder's others.
    pub label: String,
    /// What it may do, words with commas between.
    pub scopes: String,
    /// When it was made [ms since 1970].
    pub created_ms: i64,
    /// When it ends [ms since 1970].
    pub ends_ms: Option<i64>,
    /// When it was last used [ms since 1970].
    pub used_ms: Option<i64>,
    /// Whether it was taken back.
    pub revoked: bool,
}

impl StoredToken {
    /// Tells whether it opens anything.
    pub fn is_valid(&self, now_ms: i64) -> bool {
        !self.revoked && self.ends_ms.is_none_or(|end| now_ms < end)
    }

    /// Names it: its holder and its number.
    pub fn reference(&self) -> String {
        format!("{}#{}", self.name, self.number)
    }
}

/// Somebody who signed in with a token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredSession {
    /// SHA-256 of what the cookie holds.
    pub sha256: String,
    /// Number of the token.
    pub token: i64,
    /// When it began [ms since 1970].
    pub created_ms: i64,
    /// When it was last used [ms since 1970].
    pub seen_ms: i64,
}

/// What is known of recordings, jobs, results, designs and tokens. Every change that returns has
/// been written through to the disk.
#[expect(
    clippy::missing_errors_doc,
    reason = "each call says the same: StoreError, if the disk or the database refuses"
)]
pub trait Ledger: Send + Sync {
    /// Names what answers: the version of the program, and what its children may take.
    fn program(&self) -> &str;

    /// Keeps a recording; false if it was known. A row that is damaged is written anew, and one that
    /// was deleted is there again.
    fn put_recording(
        &self,
        manifest: &Manifest,
        owner: &str,
        now_ms: i64,
    ) -> Result<bool, StoreError>;
    /// Notes what a recording holds.
    fn put_listing(&self, id: &str, listing: &Value) -> Result<(), StoreError>;
    /// Finds a recording.
    fn recording(&self, id: &str) -> Result<Option<StoredRecording>, StoreError>;
    /// Lists recordings, without what they hold.
    fn recordings(&self, filter: &RecordingFilter) -> Result<Page<ListedRecording>, StoreError>;
    /// Deletes a recording, and of its reports all but the documents; false if there is none. Its
    /// files go with [`sweep`].
    fn delete_recording(
        &self,
        id: &str,
        by: &str,
        why: &str,
        now_ms: i64,
    ) -> Result<bool, StoreError>;
    /// Finds what remains of a recording that was deleted and is not there again.
    fn deletion(&self, id: &str) -> Result<Option<Deletion>, StoreError>;
    /// Lists deletions, the newest first.
    fn deletions(&self, before: Option<i64>, limit: u32) -> Result<Page<Deletion>, StoreError>;
    /// Notes when the store was last looked after; returns when it was before.
    fn looked(&self, now_ms: i64) -> Result<Option<i64>, StoreError>;
    /// Lists the recordings that came before some time.
    fn aged_recordings(&self, before_ms: i64) -> Result<Vec<String>, StoreError>;
    /// Returns the deletions whose files are to be removed, and those files.
    fn open_deletions(&self) -> Result<(Vec<i64>, BTreeSet<String>), StoreError>;
    /// Has further files go with a recording that was deleted.
    fn extend_deletion(&self, id: &str, files: &BTreeSet<String>) -> Result<(), StoreError>;
    /// Finds which of some files rows name that came after others, and the last rows.
    fn needed_of(
        &self,
        files: &BTreeSet<String>,
        after: LastRows,
    ) -> Result<(BTreeSet<String>, LastRows), StoreError>;
    /// Notes that the files of deletions were removed.
    fn close_deletions(&self, numbers: &[i64]) -> Result<(), StoreError>;
    /// Returns the bytes that an owner has uploaded.
    fn bytes_of(&self, owner: &str) -> Result<u64, StoreError>;

    /// Puts a job in the queue unless it is known; returns how it stands, and whether it is new.
    fn submit(&self, id: &str, question: &Question, owner: &str)
    -> Result<(Job, bool), StoreError>;
    /// Finds a job.
    fn job(&self, id: &str) -> Result<Option<Job>, StoreError>;
    /// Takes the next job that waits, until `lease_ms`.
    fn take(&self, now_ms: i64, lease_ms: i64) -> Result<Option<Job>, StoreError>;
    /// Holds a job until `lease_ms`, if this attempt still has it.
    fn hold(&self, id: &str, attempt: i64, lease_ms: i64) -> Result<(), StoreError>;
    /// Ends a job with a result, if this attempt still has it.
    fn finish(&self, id: &str, attempt: i64, result: &StoredResult) -> Result<(), StoreError>;
    /// Ends a job of which the decision alone was wanted, if this attempt still has it.
    fn decide(&self, id: &str, attempt: i64, row: &Value) -> Result<(), StoreError>;
    /// Ends a job without an answer, if this attempt still has it. One that `lasts` is answered from
    /// the store until another program or other limits may do better.
    fn refuse(
        &self,
        id: &str,
        attempt: i64,
        problem: &Value,
        lasts: bool,
    ) -> Result<(), StoreError>;
    /// Puts a job back whose child ended, to be taken from `not_before_ms` on; returns how often that has happened
    /// to it. This and leases are times of this process, [`crate::clock::running_ms`].
    fn give_back(
        &self,
        id: &str,
        attempt: i64,
        counts: bool,
        not_before_ms: i64,
    ) -> Result<i64, StoreError>;
    /// Puts jobs back whose lease has passed; at the start of a process `every` one that runs, and then
    /// none waits.
    fn reclaim(&self, now_ms: i64, every: bool) -> Result<usize, StoreError>;
    /// Puts a job that was answered in the queue again.
    fn ask_again(&self, id: &str) -> Result<(), StoreError>;
    /// Has a report made again of which a file was lost: its job waits once more. Returns the job, or
    /// why none can do that.
    fn remake(&self, report_id: &str, lost: &str) -> Result<Remake, StoreError>;
    /// Returns how many jobs wait and run, all of them and those of one owner.
    fn load(&self, owner: &str) -> Result<Load, StoreError>;
    /// Returns what else is told of the store in figures.
    fn census(&self) -> Result<Census, StoreError>;
    /// Writes what it says already, to see whether it can be written.
    fn probe(&self) -> Result<(), StoreError>;

    /// Finds a result.
    fn result(&self, report_id: &str) -> Result<Option<StoredResult>, StoreError>;
    /// Lists results, the newest first.
    fn results(&self, filter: &ResultFilter) -> Result<Page<StoredResult>, StoreError>;

    /// Keeps a design under a name and returns its version: that of the newest, if it says the same.
    /// No version is given twice.
    fn put_design(
        &self,
        name: &str,
        design: &Value,
        owner: &str,
        now_ms: i64,
    ) -> Result<StoredDesign, StoreError>;
    /// Returns how many designs an owner has.
    fn designs_of(&self, owner: &str) -> Result<u64, StoreError>;
    /// Deletes a version of a design; false if there is none.
    fn delete_design(&self, name: &str, version: i64) -> Result<bool, StoreError>;
    /// Finds a version of a design, the newest if none is named.
    fn design(&self, name: &str, version: Option<i64>) -> Result<Option<StoredDesign>, StoreError>;
    /// Lists versions of designs by name, the newest first, without the first `skipped` ones.
    fn designs(&self, skipped: u32, limit: u32) -> Result<Page<StoredDesign>, StoreError>;

    /// Keeps a gate and puts its pairs in the queue; of one that is known those that were refused
    /// for a reason that passes. Returns whether any wait now that did not.
    fn put_gate(
        &self,
        gate: &StoredGate,
        pairs: Vec<Question>,
        owner: &str,
    ) -> Result<bool, StoreError>;
    /// Finds a gate and how far it is.
    fn gate(&self, id: &str) -> Result<Option<GateStanding>, StoreError>;
    /// Lists gates, the newest first.
    fn gates(&self, before: Option<i64>, limit: u32) -> Result<Page<GateStanding>, StoreError>;
    /// Lists the gates that have no outcome yet.
    fn open_gates(&self) -> Result<Page<GateStanding>, StoreError>;
    /// Returns the jobs of a gate's pairs, by recording and design.
    fn pairs(&self, id: &str) -> Result<Vec<Job>, StoreError>;
    /// Keeps what came of a gate.
    fn end_gate(&self, id: &str, outcome: &GateOutcome) -> Result<(), StoreError>;

    /// Keeps a token and returns its number.
    fn put_token(&self, token: &StoredToken) -> Result<i64, StoreError>;
    /// Takes a token back, at once with its sessions, or from some time on.
    fn end_token(&self, number: i64, ends_ms: Option<i64>) -> Result<(), StoreError>;
    /// Notes that a token was used.
    fn used_token(&self, number: i64, now_ms: i64) -> Result<(), StoreError>;
    /// Lists the tokens.
    fn tokens(&self) -> Result<Vec<StoredToken>, StoreError>;
    /// Keeps a session, or notes that it was used.
    fn put_session(&self, session: &StoredSession) -> Result<(), StoreError>;
    /// Lists the sessions.
    fn sessions(&self) -> Result<Vec<StoredSession>, StoreError>;
    /// Ends a session.
    fn end_session(&self, sha256: &str) -> Result<(), StoreError>;

    /// Writes what was committed into the file of the ledger itself.
    fn settle(&self) -> Result<(), StoreError>;
    /// Writes a copy that holds together into a file that does not exist.
    fn copy_to(&self, path: &Path) -> Result<(), StoreError>;
    /// Reads the rows that name blobs, and returns what is damaged and the blobs that the others name.
    fn named(&self) -> Result<(Vec<String>, Vec<StoredFile>), StoreError>;
    /// Reads every row, and returns what is damaged and the hashes of the blobs that are needed.
    fn check(&self) -> Result<(Vec<String>, Vec<StoredFile>), StoreError>;
}

/// What comes of having a report made again.
#[derive(Debug, Clone, PartialEq)]
pub enum Remake {
    /// This job makes it.
    Waits(Job),
    /// It was made with the numbers of this revision, and this program has others.
    OtherNumbers(u32),
    /// The recording was deleted.
    Deleted(Deletion),
    /// There is no such report, or nothing that could make it.
    Impossible,
}

/// How much there is to do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Load {
    /// Jobs that wait.
    pub queued: u64,
    /// Jobs that run.
    pub running: u64,
    /// Jobs of one owner that wait or run.
    pub own: u64,
}

/// What the store holds, in figures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Census {
    /// When the oldest job came that waits [ms since 1970].
    pub oldest_ms: Option<i64>,
    /// Bytes of all recordings.
    pub recording_bytes: u64,
    /// Gates that have no outcome yet.
    pub open_gates: u64,
}

/// Blobs that were removed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Collected {
    /// Number.
    pub files: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Bytes of those that stay.
    pub kept_bytes: u64,
}

/// Age from which a blob that no row names is no upload under way.
const COLLECTED_AFTER: Duration = Duration::from_secs(86_400);

/// Removes the blobs that no row names and that are older than a day: what a process left that ended
/// between a blob and its row.
///
/// # Errors
///
/// [`StoreError`]; a row that is damaged may name any of them, and then none is removed.
pub fn collect(ledger: &dyn Ledger, blobs: &dyn Blobs) -> Result<Collected, StoreError> {
    let before = SystemTime::now().checked_sub(COLLECTED_AFTER);
    let before = before.unwrap_or(SystemTime::UNIX_EPOCH);
    let (damaged, named) = ledger.named()?;
    if let Some(what) = damaged.into_iter().next() {
        return Err(StoreError::Damaged { what });
    }
    let named = named.into_iter().map(|file| file.sha256).collect();
    blobs.collect(&named, before)
}

/// Numbers of the last rows that were read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LastRows {
    /// Of recordings.
    pub recordings: i64,
    /// Of results.
    pub results: i64,
    /// Of gates.
    pub gates: i64,
}

/// Removes the files of recordings that were deleted, but for those that another row names.
///
/// # Errors
///
/// [`StoreError`]; what was not removed is removed the next time.
pub fn sweep(ledger: &dyn Ledger, blobs: &dyn Blobs) -> Result<(), StoreError> {
    let (numbers, files) = ledger.open_deletions()?;
    if numbers.is_empty() {
        return Ok(());
    }
    // Nobody waits while every row is read; then only the rows that came meanwhile are.
    let (needed, last) = ledger.needed_of(&files, LastRows::default())?;
    let _alone = blobs
        .placing()
        .write()
        .unwrap_or_else(PoisonError::into_inner);
    let (fresh, _) = ledger.needed_of(&files, last)?;
    for file in &files {
        if !needed.contains(file) && !fresh.contains(file) {
            blobs.remove(file)?;
        }
    }
    ledger.close_deletions(&numbers)
}

/// Bytes by their SHA-256.
#[expect(
    clippy::missing_errors_doc,
    reason = "each call says the same: StoreError, if the disk or the database refuses"
)]
pub trait Blobs: Send + Sync {
    /// Begins a blob of unknown hash.
    fn begin(&self) -> Result<BlobWriter, StoreError>;
    /// Opens a blob after its bytes were read and found to have the hash.
    fn open(&self, sha256: &str) -> Result<File, StoreError>;
    /// Held together by those who put files in their place until the rows that name them are written,
    /// alone by who removes files.
    fn placing(&self) -> &RwLock<()>;
    /// Removes a blob, if it is there; when this returns that is on the disk.
    fn remove(&self, sha256: &str) -> Result<(), StoreError>;
    /// Returns the bytes that are free where the blobs lie.
    fn free_bytes(&self) -> Result<u64, StoreError>;
    /// Removes the blobs whose hash is not `named` and that were kept before some time.
    fn collect(
        &self,
        named: &BTreeSet<String>,
        before: SystemTime,
    ) -> Result<Collected, StoreError>;
}
