//! The store: recordings, jobs and results in SQLite, bytes in files named by their hash.
//!
//! Two traits divide the work. [`Ledger`] holds the rows of recordings, jobs, results and designs;
//! [`Blobs`] holds bytes by their SHA-256. Whatever either has acknowledged survives a crash of the
//! process and a power cut.
//!
//! - `ledger`: the ledger in SQLite, one writer that commits in groups;
//! - `jobs`: jobs with lease, attempts and fencing;
//! - `gates`: gates and their pairs;
//! - `recordings`, `results`: rows of these;
//! - `needed`: the blobs that rows name;
//! - `deletions`: deleted recordings;
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

/// The reason for which something could not be stored or read back.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The disk is full.
    #[error(
        "the disk has no bytes or no files left (df, df -i); free some where the data lie, nothing that was \
         acknowledged is lost"
    )]
    Full,
    /// A row or a file does not fit its hash.
    #[error("{what} is damaged: its hash does not fit; restore it from a backup")]
    Damaged {
        /// Name of the row or file.
        what: String,
    },
    /// Tokens were made, and none of their rows is left or fits its hash.
    #[error(
        "tokens were made and none can be read, so nobody is let in; make one with `latchgate-serve token create \
         NAME`, or restore a backup"
    )]
    TokensLost,
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

/// The files of one recording, as uploaded.
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

    /// Returns the number of its bytes.
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
    /// Its files.
    pub manifest: Manifest,
    /// Name of the visitor who uploaded it first.
    pub owner: String,
    /// Time of the first upload [ms since 1970].
    pub created_ms: i64,
    /// Time of the last upload [ms since 1970], from which its age counts.
    pub renewed_ms: i64,
    /// Its channels as the reader lists them, or the problem of reading it; `None` before it was
    /// read.
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

/// The filter of a list of recordings.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordingFilter {
    /// A part of the name, of who uploaded it, or of the identity.
    pub text: Option<String>,
    /// The order.
    pub order: RecordingOrder,
    /// `next` of the part before.
    pub after: Option<i64>,
    /// Largest number of entries.
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

/// The question of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Question {
    /// The recording's identity.
    pub recording: String,
    /// Settings of reading, conditioning and judging, all of them written out.
    pub request: Value,
    /// The lever, every number written out.
    pub design: Value,
    /// Name and version of the design, where it came from the store.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub design_name: Option<String>,
    /// True for a pair of a gate: the decision alone, without a report.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub decision_alone: bool,
}

impl Question {
    /// Returns the identity of the question: the same for everybody who asks it.
    pub fn id(&self) -> String {
        let plain = Self {
            design_name: None,
            ..self.clone()
        };
        let text = serde_json::to_string(&plain).expect("a question has text keys only");
        sha256_hex(format!("{}{text}", latchgate::pipeline::NUMBERS_REVISION).as_bytes())
    }

    /// Returns what decides most about the time of its verdict: the varied levers, and the tables of the design, each
    /// mechanism being one.
    pub fn kind(&self) -> String {
        let tables = self.design.as_object().into_iter().flatten();
        let tables = tables.filter(|(name, table)| table.is_object() && *name != "modified_from");
        let tables: Vec<&str> = tables.map(|(name, _)| name.as_str()).collect();
        format!("{} {}", self.request["members"], tables.join(" "))
    }
}

/// The state of a job.
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
    /// It has been answered with a decision alone.
    Decided {
        /// `row`, as the library writes it, with `sha256` and `channel` of the recording.
        row: Value,
    },
    /// There is no answer, for a reason that does not change.
    Refused {
        /// The reason, a problem document.
        problem: Value,
    },
}

impl JobState {
    /// True once the job has an answer or was refused.
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
    /// Hash of the question.
    pub id: String,
    /// Its question.
    pub question: Question,
    /// Its state.
    pub state: JobState,
    /// Number of the attempt, counted up whenever a child takes it.
    pub attempt: i64,
    /// Number of children that ended under it.
    pub failures: i64,
    /// Who submitted it first.
    pub owner: String,
}

/// A result that is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredResult {
    /// The report's identity.
    pub report_id: String,
    /// The recording's identity.
    pub recording: String,
    /// The row of lists: file, channel, design, verdict, peak, limit.
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
    /// True if all files but the document were deleted with its recording.
    #[serde(default)]
    pub is_stripped: bool,
    /// Files that were lost and are made again.
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
    /// Returns the distance of the peak with its error to the limit, as part of the limit.
    pub fn margin(&self) -> Option<f64> {
        let highest = self.peak_angle_rad? + self.uncertainty_rad.unwrap_or(0.0);
        Some((self.threshold_rad - highest) / self.threshold_rad)
    }

    /// Returns the name of the design, with its version where it is kept, and its changes.
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

/// The filter of a list of results; an absent field admits all.
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
    /// `next` of the part before.
    pub after: Option<i64>,
    /// Largest number of entries.
    pub limit: u32,
}

/// A gate: stored recordings and designs, each with each, and the required answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredGate {
    /// Hash of everything that determines its outcome.
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
    /// True if pairs of the baseline may be gone.
    pub allow_removed: bool,
    /// True if pairs that were not as required in the baseline and are no worse are let through.
    pub no_worse: bool,
    /// The day on which exceptions must still hold, `YYYY-MM-DD`.
    pub date: String,
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
    /// Settings of reading, conditioning and judging.
    pub request: Value,
}

/// The outcome of a gate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateOutcome {
    /// The exit code that the command line would give.
    pub exit_code: u8,
    /// Pairs that are not as required.
    pub not_as_required: u64,
    /// Its files by name: `summary.json`, `summary.csv`, `junit.xml`, `summary.md`, `index.html`.
    pub files: BTreeMap<String, StoredFile>,
    /// The problem for which there is no summary, a problem document.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<Value>,
}

/// A gate with its progress.
#[derive(Debug, Clone, PartialEq)]
pub struct GateStanding {
    /// The gate.
    pub gate: StoredGate,
    /// Pairs that are decided.
    pub decided: u64,
    /// Its outcome, once all pairs are decided.
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

/// Part of a list, without the rows that are damaged.
#[derive(Debug, Clone, PartialEq)]
pub struct Page<T> {
    /// The undamaged rows.
    pub entries: Vec<T>,
    /// Names of the damaged rows.
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
    /// Name of its holder.
    pub name: String,
    /// Label that distinguishes it from the holder's other tokens.
    pub label: String,
    /// Its scopes, with commas between.
    pub scopes: String,
    /// When it was made [ms since 1970].
    pub created_ms: i64,
    /// When it ends [ms since 1970].
    pub ends_ms: Option<i64>,
    /// When it was last used [ms since 1970].
    pub used_ms: Option<i64>,
    /// True if it was revoked.
    pub revoked: bool,
}

impl StoredToken {
    /// True if it is neither revoked nor ended.
    pub fn is_valid(&self, now_ms: i64) -> bool {
        !self.revoked && self.ends_ms.is_none_or(|end| now_ms < end)
    }

    /// Returns its name: holder and number.
    pub fn reference(&self) -> String {
        format!("{}#{}", self.name, self.number)
    }
}

/// A session of a person who signed in with a token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredSession {
    /// SHA-256 of the cookie's secret.
    pub sha256: String,
    /// Number of the token.
    pub token: i64,
    /// When it began [ms since 1970].
    pub created_ms: i64,
    /// When it was last used [ms since 1970].
    pub seen_ms: i64,
}

/// Rows of recordings, jobs, results, designs and tokens. A change returns once it is synced to the
/// disk.
#[expect(
    clippy::missing_errors_doc,
    reason = "each call says the same: StoreError, if the disk or the database refuses"
)]
pub trait Ledger: Send + Sync {
    /// Returns the name of the program that answers: its version, and the limits of its children.
    fn program(&self) -> &str;

    /// Keeps a recording; false if it was stored before. A damaged row is replaced, and a deleted
    /// recording is restored.
    fn put_recording(
        &self,
        manifest: &Manifest,
        owner: &str,
        now_ms: i64,
    ) -> Result<bool, StoreError>;
    /// Keeps the listing of a recording.
    fn put_listing(&self, id: &str, listing: &Value) -> Result<(), StoreError>;
    /// Finds a recording.
    fn recording(&self, id: &str) -> Result<Option<StoredRecording>, StoreError>;
    /// Lists recordings, without their listings.
    fn recordings(&self, filter: &RecordingFilter) -> Result<Page<ListedRecording>, StoreError>;
    /// Deletes a recording, and all files of its reports except the documents; false if there is
    /// none. [`sweep`] removes the files.
    fn delete_recording(
        &self,
        id: &str,
        deleted_by: &str,
        why: &str,
        now_ms: i64,
    ) -> Result<bool, StoreError>;
    /// Finds the deletion of a recording that was not uploaded again.
    fn deletion(&self, id: &str) -> Result<Option<Deletion>, StoreError>;
    /// Lists deletions, the newest first.
    fn deletions(&self, before: Option<i64>, limit: u32) -> Result<Page<Deletion>, StoreError>;
    /// Keeps the time of this upkeep of the store; returns that of the upkeep before.
    fn note_upkeep(&self, now_ms: i64) -> Result<Option<i64>, StoreError>;
    /// Lists the recordings that came before `before_ms`.
    fn aged_recordings(&self, before_ms: i64) -> Result<Vec<String>, StoreError>;
    /// Returns the deletions whose files must still be removed, and those files.
    fn open_deletions(&self) -> Result<(Vec<i64>, BTreeSet<String>), StoreError>;
    /// Adds files to a deletion.
    fn extend_deletion(&self, id: &str, files: &BTreeSet<String>) -> Result<(), StoreError>;
    /// Finds the files among `files` that rows after the given ones name, and the last rows.
    fn needed_of(
        &self,
        files: &BTreeSet<String>,
        after: LastRows,
    ) -> Result<(BTreeSet<String>, LastRows), StoreError>;
    /// Notes that the files of deletions were removed.
    fn close_deletions(&self, numbers: &[i64]) -> Result<(), StoreError>;
    /// Returns the bytes that an owner has uploaded.
    fn bytes_of(&self, owner: &str) -> Result<u64, StoreError>;

    /// Puts a job in the queue unless it exists; returns the job, and true if it is new.
    fn submit(&self, id: &str, question: &Question, owner: &str)
    -> Result<(Job, bool), StoreError>;
    /// Finds a job.
    fn job(&self, id: &str) -> Result<Option<Job>, StoreError>;
    /// Takes the next job that waits, until `lease_ms`.
    fn take(&self, now_ms: i64, lease_ms: i64) -> Result<Option<Job>, StoreError>;
    /// Takes the next job that is no pair of a gate, until `lease_ms`.
    fn take_question(&self, now_ms: i64, lease_ms: i64) -> Result<Option<Job>, StoreError>;
    /// Holds a job until `lease_ms`, if this attempt still has it.
    fn hold(&self, id: &str, attempt: i64, lease_ms: i64) -> Result<(), StoreError>;
    /// Ends a job with a result, if this attempt still has it.
    fn finish(&self, id: &str, attempt: i64, result: &StoredResult) -> Result<(), StoreError>;
    /// Ends a job with a decision alone, if this attempt still has it.
    fn decide(&self, id: &str, attempt: i64, row: &Value) -> Result<(), StoreError>;
    /// Ends a job without an answer, if this attempt still has it. A refusal that `lasts` stands
    /// until another program, or other limits, may answer.
    fn refuse(
        &self,
        id: &str,
        attempt: i64,
        problem: &Value,
        lasts: bool,
    ) -> Result<(), StoreError>;
    /// Puts a job back whose child ended, to be taken from `not_before_ms` on; returns the number of its failures,
    /// to which this one `counts` or not. Times are those of this process, [`crate::clock::running_ms`].
    fn give_back(
        &self,
        id: &str,
        attempt: i64,
        counts: bool,
        not_before_ms: i64,
    ) -> Result<i64, StoreError>;
    /// Puts jobs back whose lease has passed. At the start of a process this is `every` running job,
    /// and all pauses end.
    fn reclaim(&self, now_ms: i64, every: bool) -> Result<usize, StoreError>;
    /// Puts an answered job back in the queue.
    fn requeue(&self, id: &str) -> Result<(), StoreError>;
    /// Puts the job of a report back in the queue, since its file `lost` is gone. Returns the job, or
    /// the reason why none can make the file.
    fn remake(&self, report_id: &str, lost: &str) -> Result<Remake, StoreError>;
    /// Returns the place of a question that waits; `None` if it does not.
    fn place(&self, id: &str) -> Result<Option<QueuePlace>, StoreError>;
    /// Returns the numbers of jobs that wait and run, of all owners and of one.
    fn load(&self, owner: &str) -> Result<Load, StoreError>;
    /// Returns further figures of the store.
    fn census(&self) -> Result<Census, StoreError>;
    /// Writes a value that is there already, to check that the ledger can be written.
    fn probe(&self) -> Result<(), StoreError>;

    /// Finds a result.
    fn result(&self, report_id: &str) -> Result<Option<StoredResult>, StoreError>;
    /// Lists results, the newest first.
    fn results(&self, filter: &ResultFilter) -> Result<Page<StoredResult>, StoreError>;

    /// Keeps a design under a name and returns it with its version: that of the newest, if both are
    /// equal. No version number is used twice.
    fn put_design(
        &self,
        name: &str,
        design: &Value,
        owner: &str,
        now_ms: i64,
    ) -> Result<StoredDesign, StoreError>;
    /// Returns the number of an owner's designs.
    fn designs_of(&self, owner: &str) -> Result<u64, StoreError>;
    /// Deletes a version of a design; false if there is none.
    fn delete_design(&self, name: &str, version: i64) -> Result<bool, StoreError>;
    /// Finds a version of a design, the newest if none is named.
    fn design(&self, name: &str, version: Option<i64>) -> Result<Option<StoredDesign>, StoreError>;
    /// Lists versions of designs by name, the newest first, without the first `skipped` ones.
    fn designs(&self, skipped: u32, limit: u32) -> Result<Page<StoredDesign>, StoreError>;

    /// Keeps a gate and puts its pairs in the queue; of a stored gate the pairs that were refused for
    /// a reason that may pass. True if the gate is new or its outcome is open again.
    fn put_gate(
        &self,
        gate: &StoredGate,
        pairs: Vec<Question>,
        owner: &str,
    ) -> Result<bool, StoreError>;
    /// Finds a gate with its progress.
    fn gate(&self, id: &str) -> Result<Option<GateStanding>, StoreError>;
    /// Lists gates, the newest first.
    fn gates(&self, before: Option<i64>, limit: u32) -> Result<Page<GateStanding>, StoreError>;
    /// Lists the gates that have no outcome yet.
    fn open_gates(&self) -> Result<Page<GateStanding>, StoreError>;
    /// Returns the jobs of a gate's pairs, by recording and design.
    fn pairs(&self, id: &str) -> Result<Vec<Job>, StoreError>;
    /// Keeps the outcome of a gate.
    fn end_gate(&self, id: &str, outcome: &GateOutcome) -> Result<(), StoreError>;

    /// Returns a number that differs from the one before if anything was written since, by whomever.
    fn change(&self) -> Result<i64, StoreError>;
    /// Keeps a token and returns its number. Removes those whose rows do not fit their hashes.
    fn put_token(&self, token: &StoredToken) -> Result<i64, StoreError>;
    /// Revokes a token at once, with its sessions, or lets it end at `ends_ms`.
    fn end_token(&self, number: i64, ends_ms: Option<i64>) -> Result<(), StoreError>;
    /// Keeps the time of a token's last use.
    fn used_token(&self, number: i64, now_ms: i64) -> Result<(), StoreError>;
    /// Lists the tokens whose rows fit their hashes; the others grant nothing. The list is empty only if no token was
    /// ever made.
    fn tokens(&self) -> Result<Vec<StoredToken>, StoreError>;
    /// Keeps a session, or the time of its last use.
    fn put_session(&self, session: &StoredSession) -> Result<(), StoreError>;
    /// Lists the sessions whose rows fit their hashes.
    fn sessions(&self) -> Result<Vec<StoredSession>, StoreError>;
    /// Ends a session.
    fn end_session(&self, sha256: &str) -> Result<(), StoreError>;

    /// Writes the log into the file of the ledger.
    fn settle(&self) -> Result<(), StoreError>;
    /// Writes a consistent copy into a new file.
    fn copy_to(&self, path: &Path) -> Result<(), StoreError>;
    /// Reads the rows that name blobs.
    fn named_files(&self) -> Result<CheckedFiles, StoreError>;
    /// Reads every row.
    fn check(&self) -> Result<CheckedFiles, StoreError>;
}

/// Files that rows name, and the rows that are damaged.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CheckedFiles {
    /// Names of the damaged rows.
    pub damaged: Vec<String>,
    /// Files that the other rows name.
    pub files: Vec<StoredFile>,
}

/// Result of a request to make a report again.
#[derive(Debug, Clone, PartialEq)]
pub enum Remake {
    /// This job makes it.
    Waits(Job),
    /// The report was made with the numbers of this revision, and this program has others.
    OtherNumbers(u32),
    /// The recording was deleted.
    Deleted(Deletion),
    /// There is no such report, or nothing that could make it.
    Impossible,
}

/// Numbers of unfinished jobs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Load {
    /// Jobs that wait.
    pub queued: u64,
    /// Jobs that run.
    pub running: u64,
    /// Jobs of one owner that wait or run.
    pub owner_jobs: u64,
}

/// Place of a question in the queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QueuePlace {
    /// Jobs that come before it: those that run, its owner's earlier questions, and by turns those of other owners.
    pub behind: u64,
    /// Time since which it waits [ms since 1970].
    pub since_ms: i64,
}

/// Figures of the store.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Census {
    /// Time at which the oldest waiting job came [ms since 1970].
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
}

/// Age from which a blob that no row names cannot be part of a running upload.
const COLLECTED_AFTER: Duration = Duration::from_secs(86_400);

/// Removes the blobs that no row names and that are older than a day: those of a process that ended
/// between writing a blob and its row.
///
/// # Errors
///
/// [`StoreError`]; a row that is damaged may name any of them, and then none is removed.
pub fn collect(ledger: &dyn Ledger, blobs: &dyn Blobs) -> Result<Collected, StoreError> {
    let before = SystemTime::now().checked_sub(COLLECTED_AFTER);
    let before = before.unwrap_or(SystemTime::UNIX_EPOCH);
    let named = ledger.named_files()?;
    if let Some(what) = named.damaged.into_iter().next() {
        return Err(StoreError::Damaged { what });
    }
    let hashes = named.files.into_iter().map(|file| file.sha256).collect();
    blobs.collect(&hashes, before)
}

/// What is free on a disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Free {
    /// Bytes.
    pub bytes: u64,
    /// Files (inodes); `None` on a disk that does not count them.
    pub files: Option<u64>,
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

/// Removes the files of deleted recordings, except those that another row names.
///
/// # Errors
///
/// [`StoreError`]; the next sweep removes the remaining files.
pub fn sweep(ledger: &dyn Ledger, blobs: &dyn Blobs) -> Result<(), StoreError> {
    let (numbers, files) = ledger.open_deletions()?;
    if numbers.is_empty() {
        return Ok(());
    }
    // Every row is read without the lock, which takes long. Under the lock only the rows that came
    // meanwhile are read, so that no upload waits for long.
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
    /// Opens a blob after a check that its bytes have the hash.
    fn open(&self, sha256: &str) -> Result<File, StoreError>;
    /// Lock between uploads and [`sweep`]. Uploads hold it shared, from putting files in their places
    /// until the rows that name them are written; a sweep holds it exclusively.
    fn placing(&self) -> &RwLock<()>;
    /// Removes a blob, if it exists, and returns once that is on the disk.
    fn remove(&self, sha256: &str) -> Result<(), StoreError>;
    /// Returns the bytes of all blobs: those that lay there at the start, with what came and went since.
    fn stored_bytes(&self) -> u64;
    /// Returns what is free on the blobs' disk.
    fn free(&self) -> Result<Free, StoreError>;
    /// Removes the blobs whose hash is not in `named` and that were kept before a time.
    fn collect(
        &self,
        named: &BTreeSet<String>,
        before: SystemTime,
    ) -> Result<Collected, StoreError>;
}
