//! The store: decisions kept for the next run and for collecting shares, as lines of JSON.
//!
//! A store is a folder. Each process appends to a file that it alone writes, line by line. Nothing is
//! rewritten, so that several processes may share a store, on a network file system, too.
//!
//! A line is a decision, or a note:
//!
//! ```text
//! {"rec":"8f0c…","des":"52a1…","rev":16,"id":"…","is":"fail","why":"…","lim":0.1,"peak":0.31,"u":0.002,"sum":"…"}
//! {"note":"reason","why":"…","code":"…","text":"…","sum":"…"}
//! {"note":"advised","id":"…","advised":{"preload":{…},"restitution":null},"sum":"…"}
//! ```
//!
//! Each line ends with a checksum of the text before it. A line with a wrong checksum is ignored,
//! wherever it is: its decision is missing, and the pair is judged again.

use super::key::Key;
use super::share::Share;
use crate::pipeline::{Answer, DecisionRow, NUMBERS_REVISION, Reason};
use latchgate_kernel::range::Range;
use latchgate_recording::error::Error;
use latchgate_verdict::margin::Advice;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

/// Default name of the store's folder.
pub const FOLDER: &str = ".latchgate";

/// Extension of a store's files.
const ENDING: &str = "jsonl";

/// The mark of a folder that may be deleted and made again, after the Cache Directory Tagging
/// Specification.
const CACHE_TAG: &str = "Signature: 8a477f597d28d172789f06886806bc55\n\
# Decisions of latchgate gate. This folder may be deleted; they are then made again.\n";

/// Longest line that is read [bytes]; a row takes 400, a reason what its text takes.
const LINE_MAX: u64 = 64 << 10;

/// Beginning of the line of a search.
const ADVISED: &[u8] = br#"{"note":"advised","#;

/// Interval after which appended lines are synced to the disk. A sync per line would cost more than
/// the decision; a power cut loses the lines since the last sync.
const SYNC: Duration = Duration::from_secs(5);

/// Number of times that a recording is begun without an end before shares skip it. Once may be a
/// process that was killed from outside; twice is likely the recording's own doing.
pub(super) const BEGUN_MAX: u32 = 2;

/// A decision as a line; keys are short, since there is one line for each pair.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RowLine {
    /// Key of the recording.
    rec: Key,
    /// Key of the design.
    des: Key,
    /// Revision of the numbers.
    rev: u32,
    /// The `report_id`.
    id: String,
    /// The answer.
    is: Answer,
    /// Key of the reason, which an earlier line of the file defines.
    why: String,
    /// The angle that loses the door [rad].
    lim: f64,
    /// The largest angle [rad].
    #[serde(skip_serializing_if = "Option::is_none")]
    peak: Option<f64>,
    /// Uncertainty U of the peak [rad].
    #[serde(skip_serializing_if = "Option::is_none")]
    u: Option<f64>,
    /// The largest angle after the judged window [rad].
    #[serde(skip_serializing_if = "Option::is_none")]
    coast: Option<f64>,
    /// Bounds of the share of levers that cross.
    #[serde(skip_serializing_if = "Option::is_none")]
    share: Option<Range>,
}

/// A line that is no decision.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "note", rename_all = "kebab-case")]
enum Note {
    /// A share begins a recording.
    Begun { rec: Key, name: String },
    /// A share leaves a recording in good order, done or not.
    Ended { rec: Key },
    /// Facts of the recording as it was read.
    Read { rec: Key, read: ReadFacts },
    /// A reason to which later rows of the file refer.
    Reason { why: String, reason: Reason },
    /// What was searched for the report of a verdict.
    Advised { id: String, advised: Box<Advised> },
}

/// What a report says beside its verdict, which takes longer to search than the verdict.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Advised {
    /// The preload from which on the recording passes.
    pub(super) preload: Option<Advice>,
    /// The restitution up to which it does.
    pub(super) restitution: Option<Advice>,
}

/// Facts of a recording that was read.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct ReadFacts {
    /// SHA-256 of the file, where it was read.
    pub(super) sha256: Option<String>,
    /// The channel that was judged.
    pub(super) channel: Option<String>,
}

/// The store as this process writes it.
#[derive(Debug)]
pub struct Store {
    /// `None` where nothing is kept.
    folder: Option<PathBuf>,
    /// End of the name of this process's file.
    label: String,
    /// The file of this process, made with the first line.
    file: Mutex<Option<ProcessFile>>,
}

/// The file that this process appends to.
#[derive(Debug)]
struct ProcessFile {
    file: File,
    path: PathBuf,
    length: u64,
    /// Offset of the notes that no row follows.
    notes_from: u64,
    /// Keys of the reasons in the file.
    reasons: BTreeSet<String>,
    synced: Duration,
}

impl Store {
    /// Returns a store that keeps nothing.
    pub fn unkept() -> Self {
        Self {
            folder: None,
            label: String::new(),
            file: Mutex::default(),
        }
    }

    /// Returns the store in a folder, which is made if absent; the name of this process's file ends
    /// with `label`.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if the folder cannot be made.
    pub fn open(folder: &Path, label: &str) -> Result<Self, Error> {
        make(folder)?;
        Ok(Self {
            folder: Some(folder.into()),
            label: label.into(),
            file: Mutex::default(),
        })
    }

    /// Reads the decisions of recordings; none, where nothing is kept.
    ///
    /// # Errors
    ///
    /// As [`StoredDecisions::read`].
    pub(super) fn decisions(
        &self,
        keys: impl IntoIterator<Item = Key>,
        share: Option<Share>,
    ) -> Result<StoredDecisions, Error> {
        match &self.folder {
            Some(folder) => StoredDecisions::read(&files(folder)?, keys, share),
            None => Ok(StoredDecisions::default()),
        }
    }

    /// Returns the file of this process, once it has one, and the bytes in it.
    pub(super) fn process_file(&self) -> Option<(PathBuf, u64)> {
        let file = self.lock_file();
        file.as_ref().map(|file| (file.path.clone(), file.length))
    }

    /// Keeps the facts of a recording that was read.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written; a part that was written is
    /// removed where possible.
    pub(super) fn put_read(&self, rec: Key, read: &ReadFacts) -> Result<(), Error> {
        let read = read.clone();
        self.append(&mut self.lock_file(), &Note::Read { rec, read }, false)
    }

    /// Keeps a decision; `now` is the time since some instant.
    ///
    /// # Errors
    ///
    /// As [`Self::put_read`].
    pub(super) fn put(
        &self,
        rec: Key,
        des: Key,
        row: &DecisionRow,
        now: Duration,
    ) -> Result<(), Error> {
        let why = reason_key(&row.reason);
        let mut file = self.lock_file();
        if !file
            .as_ref()
            .is_some_and(|file| file.reasons.contains(&why))
        {
            let reason = Note::Reason {
                why: why.clone(),
                reason: row.reason.clone(),
            };
            self.append(&mut file, &reason, false)?;
        }
        let line = RowLine {
            rec,
            des,
            rev: NUMBERS_REVISION,
            id: row.report_id.clone(),
            is: row.verdict,
            why: why.clone(),
            lim: row.threshold_rad,
            peak: row.peak_angle_rad,
            u: row.uncertainty_rad,
            coast: row.coast_peak_angle_rad,
            share: row.share,
        };
        self.append(&mut file, &line, true)?;
        let Some(file) = file.as_mut() else {
            return Ok(());
        };
        // Only now: the row makes the reason's line before it permanent (see `append`).
        file.reasons.insert(why);
        if now.saturating_sub(file.synced) >= SYNC {
            file.synced = now;
            file.file
                .sync_data()
                .map_err(|error| unwritable(&file.path, &error))?;
        }
        Ok(())
    }

    /// Keeps what was searched for a report, by `report_id`.
    ///
    /// # Errors
    ///
    /// As [`Self::put_read`].
    pub(super) fn put_advised(&self, id: &str, advised: &Advised) -> Result<(), Error> {
        let (id, advised) = (id.into(), Box::new(advised.clone()));
        self.append(&mut self.lock_file(), &Note::Advised { id, advised }, true)
    }

    /// Returns what is kept of the searches for these reports.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if a file cannot be read.
    pub(super) fn advised(&self, ids: &BTreeSet<&str>) -> Result<BTreeMap<String, Advised>, Error> {
        let mut kept = BTreeMap::new();
        let files = self.folder.as_deref().map(files).transpose()?;
        for path in files.unwrap_or_default() {
            let unread = |error: io::Error| Error::io_at("read the store", &path, &error);
            let mut file = BufReader::new(File::open(&path).map_err(unread)?);
            let mut line = Vec::new();
            loop {
                line.clear();
                // A line that is too long ends without its end, and is none.
                let read = file.by_ref().take(LINE_MAX).read_until(b'\n', &mut line);
                if read.map_err(unread)? == 0 {
                    break;
                }
                if !line.starts_with(ADVISED) {
                    continue;
                }
                if let Some(Line::Note(Note::Advised { id, advised })) = Line::parse(&line)
                    && ids.contains(&*id)
                {
                    kept.insert(id, *advised);
                }
            }
        }
        Ok(kept)
    }

    /// Notes that a recording is begun.
    ///
    /// # Errors
    ///
    /// As [`Self::put_read`].
    pub(super) fn begin(&self, rec: Key, name: &str) -> Result<(), Error> {
        let name = name.into();
        self.append(&mut self.lock_file(), &Note::Begun { rec, name }, false)
    }

    /// Notes that a recording is left in good order.
    ///
    /// # Errors
    ///
    /// As [`Self::put_read`].
    pub(super) fn end(&self, rec: Key) -> Result<(), Error> {
        self.append(&mut self.lock_file(), &Note::Ended { rec }, false)
    }

    /// Syncs the lines of this process to the disk.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if that fails.
    pub(super) fn sync(&self) -> Result<(), Error> {
        match self.lock_file().as_ref() {
            Some(file) => file
                .file
                .sync_data()
                .map_err(|error| unwritable(&file.path, &error)),
            None => Ok(()),
        }
    }

    /// Appends a line, unbuffered, so that it survives a kill of the process.
    fn append(
        &self,
        file: &mut Option<ProcessFile>,
        line: &impl Serialize,
        is_row: bool,
    ) -> Result<(), Error> {
        let Some(folder) = &self.folder else {
            return Ok(());
        };
        let text = sealed(line).map_err(|error| unwritable(folder, &error))?;
        let file = match file {
            Some(file) => file,
            None => file.insert(
                create_file(folder, &self.label).map_err(|error| unwritable(folder, &error))?,
            ),
        };
        if let Err(error) = file.file.write_all(text.as_bytes()) {
            // A full disk leaves half a line, and perhaps a note of a begin that nothing ends. Both
            // are cut off, back to the last row.
            let _ = file.file.set_len(file.notes_from);
            file.length = file.notes_from;
            return Err(unwritable(&file.path, &error));
        }
        file.length += text.len() as u64;
        if is_row {
            file.notes_from = file.length;
        }
        Ok(())
    }

    fn lock_file(&self) -> MutexGuard<'_, Option<ProcessFile>> {
        // Poisoning is harmless: a line is written by one call, and counted after it.
        self.file
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// Key by which the decisions of a design are found.
#[derive(Debug, Clone, Copy)]
pub(super) struct DesignKey {
    pub(super) key: Key,
    /// Limit angle [rad]. A row with another limit is no decision of this design.
    pub(super) threshold_rad: f64,
}

/// Decisions that a store holds of some recordings.
#[derive(Debug, Default)]
pub(super) struct StoredDecisions {
    recordings: BTreeMap<Key, StoredRecording>,
    /// Damage to the store, one sentence each.
    pub(super) damages: Vec<String>,
    /// Pairs with two decisions that differ.
    pub(super) contradictions: Vec<Contradiction>,
    /// The files that were read, with their bytes.
    pub(super) files: BTreeMap<String, u64>,
}

/// A pair with two decisions that differ.
#[derive(Debug)]
pub(super) struct Contradiction {
    pub(super) recording: Key,
    pub(super) design: Key,
    /// Name of the file with the second decision.
    pub(super) file: String,
}

/// Decisions that a store holds of a recording.
#[derive(Debug, Default)]
struct StoredRecording {
    /// Facts as read. Where several differ, none is trusted.
    reads: Vec<ReadFacts>,
    /// Decisions by design, one for each `report_id`.
    rows: BTreeMap<Key, Vec<DecisionRow>>,
    /// Number of times that it was begun and never ended.
    begun: u32,
}

impl StoredDecisions {
    /// Reads the lines of these recordings in a store's files; with a `share`, not those of other
    /// shares of as many.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if a file cannot be read.
    pub(super) fn read(
        paths: &[PathBuf],
        keys: impl IntoIterator<Item = Key>,
        share: Option<Share>,
    ) -> Result<Self, Error> {
        let mut decisions = Self::default();
        for key in keys {
            decisions.recordings.insert(key, StoredRecording::default());
        }
        for path in paths {
            // Another share of the same division holds none of these recordings. Files of another
            // division, or of no share, may hold any.
            let is_other = share
                .zip(Share::of_file(&name_of(path)))
                .is_some_and(|(share, other)| share.of == other.of && share != other);
            if !is_other {
                decisions
                    .read_file(path)
                    .map_err(|error| Error::io_at("read the store", path, &error))?;
            }
        }
        Ok(decisions)
    }

    fn read_file(&mut self, path: &Path) -> io::Result<()> {
        let name = name_of(path);
        let mut file = BufReader::new(File::open(path)?);
        let mut reasons: BTreeMap<String, Reason> = BTreeMap::new();
        let mut begun = BTreeSet::new();
        let (mut line, mut length, mut damaged) = (Vec::new(), 0, 0_usize);
        loop {
            line.clear();
            let read = file.by_ref().take(LINE_MAX).read_until(b'\n', &mut line)?;
            if read == 0 {
                break;
            }
            length += read as u64;
            if read as u64 == LINE_MAX && !line.ends_with(b"\n") {
                // The rest of a line that is too long is no line.
                length += file.skip_until(b'\n')? as u64;
                damaged += 1;
                continue;
            }
            match Line::parse(&line) {
                Some(Line::Row(row)) => {
                    begun.remove(&row.rec);
                    self.add_row(*row, &reasons, &name);
                }
                Some(Line::Note(Note::Reason { why, reason })) => {
                    reasons.insert(why, reason);
                }
                Some(Line::Note(Note::Read { rec, read })) => {
                    if let Some(recording) = self.recordings.get_mut(&rec)
                        && !recording.reads.contains(&read)
                    {
                        recording.reads.push(read);
                    }
                }
                Some(Line::Note(Note::Begun { rec, .. })) => {
                    begun.insert(rec);
                }
                Some(Line::Note(Note::Ended { rec })) => {
                    begun.remove(&rec);
                }
                // Reports ask for it by themselves.
                Some(Line::Note(Note::Advised { .. })) => {}
                None => damaged += 1,
            }
        }
        for rec in begun {
            if let Some(recording) = self.recordings.get_mut(&rec) {
                recording.begun += 1;
            }
        }
        if damaged > 0 {
            let lines = super::text::counted(damaged, "line");
            self.damages.push(format!(
                "{name}: {lines} with a wrong checksum; those pairs are judged again"
            ));
        }
        self.files.insert(name, length);
        Ok(())
    }

    fn add_row(&mut self, line: RowLine, reasons: &BTreeMap<String, Reason>, file: &str) {
        let recording = self.recordings.get_mut(&line.rec);
        let (Some(recording), Some(reason)) = (recording, reasons.get(&line.why)) else {
            return;
        };
        // Another revision may judge the same pair differently, which is no contradiction.
        if line.rev != NUMBERS_REVISION {
            return;
        }
        let row = DecisionRow {
            report_id: line.id,
            verdict: line.is,
            reason: reason.clone(),
            threshold_rad: line.lim,
            peak_angle_rad: line.peak,
            uncertainty_rad: line.u,
            coast_peak_angle_rad: line.coast,
            share: line.share,
        };
        let rows = recording.rows.entry(line.des).or_default();
        let earlier = rows
            .iter()
            .find(|earlier| earlier.report_id == row.report_id);
        match earlier {
            Some(earlier) if !agree(earlier, &row) => {
                self.contradictions.push(Contradiction {
                    recording: line.rec,
                    design: line.des,
                    file: file.into(),
                });
            }
            Some(_) => {}
            None => rows.push(row),
        }
    }

    /// Treats several decisions of a pair, each with another `report_id`, as contradictions.
    pub(super) fn contradict_doubles(&mut self) {
        for (rec, recording) in &self.recordings {
            let doubles = recording.rows.iter().filter(|(_, rows)| rows.len() > 1);
            self.contradictions
                .extend(doubles.map(|(design, _)| Contradiction {
                    recording: *rec,
                    design: *design,
                    file: "the store".into(),
                }));
        }
    }

    /// Returns the decision of a pair, if there is one and no other.
    pub(super) fn row(&self, recording: Key, design: &DesignKey) -> Option<&DecisionRow> {
        // A row does not say which content it was judged from, so the facts must be certain.
        self.facts(recording)?;
        match self
            .recordings
            .get(&recording)?
            .rows
            .get(&design.key)?
            .as_slice()
        {
            [row] if row.threshold_rad.to_bits() == design.threshold_rad.to_bits() => Some(row),
            _ => None,
        }
    }

    /// Returns the decision of a pair that has that `report_id`.
    pub(super) fn row_of(&self, recording: Key, design: Key, id: &str) -> Option<&DecisionRow> {
        let rows = self.recordings.get(&recording)?.rows.get(&design)?;
        rows.iter().find(|row| row.report_id == id)
    }

    /// Returns the facts of a recording, if all notes of it agree.
    pub(super) fn facts(&self, recording: Key) -> Option<&ReadFacts> {
        match self.recordings.get(&recording)?.reads.as_slice() {
            [read] => Some(read),
            _ => None,
        }
    }

    /// True if a recording was begun so often without an end that shares skip it.
    pub(super) fn is_skipped(&self, recording: Key) -> bool {
        let recording = self.recordings.get(&recording);
        recording.is_some_and(|recording| recording.begun >= BEGUN_MAX)
    }
}

/// True if two decisions agree. The wording of a reason may change with the version.
fn agree(earlier: &DecisionRow, later: &DecisionRow) -> bool {
    let without_words = |row: &DecisionRow| {
        let mut row = row.clone();
        row.reason.text.clear();
        row
    };
    without_words(earlier) == without_words(later)
}

/// A line as it is read.
enum Line {
    Row(Box<RowLine>),
    Note(Note),
}

impl Line {
    /// Reads a line with its end; `None` if it does not fit its checksum, or is of another version.
    fn parse(line: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(line).ok()?.strip_suffix('\n')?;
        let (body, seal) = text.split_at_checked(text.len().checked_sub(SUM_LEN)?)?;
        if seal != sum(body) {
            return None;
        }
        let json = format!("{body}}}");
        if body.starts_with("{\"note\":") {
            return serde_json::from_str(&json).ok().map(Self::Note);
        }
        serde_json::from_str(&json).ok().map(Self::Row)
    }
}

/// Bytes of the checksum with its key and the closing brace.
const SUM_LEN: usize = r#","sum":""}"#.len() + 16;

/// Returns a line with its checksum.
fn sealed(line: &impl Serialize) -> io::Result<String> {
    let mut text = serde_json::to_string(line)?;
    text.pop();
    let sum = sum(&text);
    Ok(text + &sum + "\n")
}

/// Returns the end of a line with that body: the first eight bytes of its SHA-256.
fn sum(body: &str) -> String {
    format!(",\"sum\":\"{:.16}\"}}", Key::of(body.as_bytes()))
}

/// Returns the key by which rows refer to a reason.
fn reason_key(reason: &Reason) -> String {
    let text = format!("{} {}", reason.code, reason.text);
    format!("{:.12}", Key::of(text.as_bytes()))
}

/// Makes the folder of a store, with its marks: for programs that keep copies, and for git.
pub(super) fn make(folder: &Path) -> Result<(), Error> {
    // In a folder that existed before, other files must not vanish from git.
    let ignore_all = !folder.exists() || folder.ends_with(FOLDER);
    fs::create_dir_all(folder).map_err(|error| Error::io_at("make the store", folder, &error))?;
    for (name, text, needed) in [
        ("CACHEDIR.TAG", CACHE_TAG, true),
        (".gitignore", "*\n", ignore_all),
    ] {
        let mark = folder.join(name);
        if needed && !mark.exists() {
            fs::write(&mark, text).map_err(|error| unwritable(&mark, &error))?;
        }
    }
    Ok(())
}

/// True if a folder has the mark of a store, which differs from that of other programs' caches.
pub(super) fn is_store(folder: &Path) -> bool {
    fs::read(folder.join("CACHEDIR.TAG")).is_ok_and(|tag| tag == CACHE_TAG.as_bytes())
}

/// Lists the files of a store, in the order of their names.
pub(super) fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let listed =
        fs::read_dir(folder).map_err(|error| Error::io_at("list the store", folder, &error))?;
    let mut paths = BTreeSet::new();
    for entry in listed {
        let entry = entry.map_err(|error| Error::io_at("list the store", folder, &error))?;
        let path = entry.path();
        // A pipe may bear such a name, and opening it would wait for ever.
        if path.extension().is_some_and(|end| end == ENDING) && path.is_file() {
            paths.insert(path);
        }
    }
    Ok(paths.into_iter().collect())
}

/// Returns the bytes that the files of a share hold.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if the store cannot be listed.
pub fn share_bytes(folder: &Path, share: Share) -> Result<u64, Error> {
    let files = files(folder)?;
    let of_share = files
        .iter()
        .filter(|path| Share::of_file(&name_of(path)) == Some(share));
    Ok(of_share
        .filter_map(|path| Some(path.metadata().ok()?.len()))
        .sum())
}

/// Writes a file under another name and renames it, so that no reader sees a part of it.
pub(super) fn put_in_place(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = path.with_extension(format!("{}.part", std::process::id()));
    let write = || {
        let mut file = File::create(&beside)?;
        file.write_all(bytes)?;
        // By the handle that wrote: Windows refuses to sync a handle that only reads.
        file.sync_all()?;
        fs::rename(&beside, path)
    };
    write().inspect_err(|_| drop(fs::remove_file(&beside)))
}

pub(super) fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn unwritable(path: &Path, error: &io::Error) -> Error {
    Error::io_at("write the store", path, error)
}

/// Returns the name of this machine, as names of files hold it.
fn host() -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let letters = host.trim().chars().filter(char::is_ascii_alphanumeric);
    letters.take(40).collect()
}

/// Makes a file that no other process has.
fn create_file(folder: &Path, label: &str) -> io::Result<ProcessFile> {
    let process = std::process::id();
    let host = host();
    let mut number = 0_u32;
    loop {
        let path = folder.join(format!("{host}-{process}-{number}{label}.{ENDING}"));
        match OpenOptions::new().append(true).create_new(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            made => {
                return made.map(|file| ProcessFile {
                    file,
                    path,
                    length: 0,
                    notes_from: 0,
                    reasons: BTreeSet::new(),
                    synced: Duration::ZERO,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number at its longest: sixteen digits behind the first, a sign and an exponent.
    #[test]
    fn verif_a_row_takes_400_bytes_at_most() -> Result<(), Box<dyn std::error::Error>> {
        let number = 1.2345678901234567e-10;
        let line = RowLine {
            rec: Key::of(b"recording"),
            des: Key::of(b"design"),
            rev: 999,
            id: "0".repeat(64),
            is: Answer::Undecided,
            why: "0".repeat(12),
            lim: 0.1,
            peak: Some(-number),
            u: Some(number),
            coast: Some(-number),
            share: Some(Range::new(number, number)),
        };
        let text = sealed(&line)?;
        assert!(text.len() <= 400, "{} bytes: {text}", text.len());
        assert!(
            matches!(Line::parse(text.as_bytes()), Some(Line::Row(row)) if row.peak == Some(-number))
        );
        Ok(())
    }

    /// No byte of a line can be another one, or be missing, without being seen.
    #[test]
    fn verif_a_line_that_was_changed_is_none() -> Result<(), Box<dyn std::error::Error>> {
        let rec = Key::of(b"recording");
        let line = sealed(&Note::Ended { rec })?.into_bytes();
        assert!(Line::parse(&line).is_some());
        for place in 0..line.len() {
            for bit in 0..8 {
                let mut changed = line.clone();
                changed[place] ^= 1 << bit;
                assert!(Line::parse(&changed).is_none(), "byte {place}, bit {bit}");
            }
            assert!(Line::parse(&line[..place]).is_none(), "cut at {place}");
        }
        Ok(())
    }
}
