//! Decisions kept for the next run, and for whoever collects them: lines of JSON.
//!
//! A store is a folder. Each process appends to one file of its own, line by line; nothing is
//! rewritten, so that several processes may share a store, on a network file system, too.
//!
//! A line is a decision, or a note:
//!
//! ```text
//! {"rec":"8f0c…","des":"52a1…","rev":16,"id":"…","is":"fail","why":"…","lim":0.1,"peak":0.31,"u":0.002,"sum":"…"}
//! {"note":"reason","why":"…","code":"…","text":"…","sum":"…"}
//! ```
//!
//! It ends with a checksum of what stands before it. A line that does not fit is nothing, wherever it
//! stands: what it held is missing, and is judged again.

use super::key::Key;
use super::share::Share;
use crate::pipeline::{Answer, DecisionRow, NUMBERS_REVISION, Reason};
use latchgate_kernel::range::Range;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

/// Name of the store's folder, where nobody names another.
pub const FOLDER: &str = ".latchgate";

/// How the name of a store's file ends.
const ENDING: &str = "jsonl";

/// The mark of a folder that may be deleted and made again, after the Cache Directory Tagging
/// Specification.
const CACHE_TAG: &str = "Signature: 8a477f597d28d172789f06886806bc55\n\
# Decisions of latchgate gate. This folder may be deleted; they are then made again.\n";

/// Longest line that is read [bytes]; a row takes 400, a reason what its text takes.
const LINE_MAX: u64 = 64 << 10;

/// Time after which what was appended is seen onto the disk.
const SYNC: Duration = Duration::from_secs(5);

/// Times that a recording is begun, and nothing follows, after which a share passes over it.
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
    /// Of which reason, as a line before says it.
    why: String,
    /// The angle that loses the door [rad].
    lim: f64,
    /// The largest angle [rad].
    #[serde(skip_serializing_if = "Option::is_none")]
    peak: Option<f64>,
    /// Its U [rad].
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
    /// What was read.
    Read { rec: Key, read: ReadFacts },
    /// A reason that rows behind it in the file speak of.
    Reason { why: String, reason: Reason },
}

/// What is known of a recording that was read.
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
    /// `None` where nothing is to be kept.
    folder: Option<PathBuf>,
    /// What the name of this process's file says beside the process.
    label: String,
    /// The file of this process, made with the first line.
    own: Mutex<Option<OwnFile>>,
}

/// The file that this process appends to.
#[derive(Debug)]
struct OwnFile {
    file: File,
    path: PathBuf,
    length: u64,
    /// Where the notes begin that no row follows.
    notes_from: u64,
    /// Reasons that stand in it.
    reasons: BTreeSet<String>,
    synced: Duration,
}

impl Store {
    /// Returns a store that keeps nothing.
    pub fn unkept() -> Self {
        Self {
            folder: None,
            label: String::new(),
            own: Mutex::default(),
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
            own: Mutex::default(),
        })
    }

    /// Reads what is known of recordings; nothing, where nothing is kept.
    ///
    /// # Errors
    ///
    /// As [`Known::read`].
    pub(super) fn known(
        &self,
        keys: impl IntoIterator<Item = Key>,
        share: Option<Share>,
    ) -> Result<Known, Error> {
        match &self.folder {
            Some(folder) => Known::read(&files(folder)?, keys, share),
            None => Ok(Known::default()),
        }
    }

    /// Returns the file of this process, once it has one, and the bytes in it.
    pub(super) fn own_file(&self) -> Option<(PathBuf, u64)> {
        let own = self.own();
        own.as_ref().map(|own| (own.path.clone(), own.length))
    }

    /// Keeps what was read of a recording.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written; what was written of it is taken
    /// back where possible.
    pub(super) fn put_read(&self, rec: Key, read: &ReadFacts) -> Result<(), Error> {
        let read = read.clone();
        self.append(&mut self.own(), &Note::Read { rec, read }, false)
    }

    /// Keeps a decision; `now` is the time since some instant.
    ///
    /// # Errors
    ///
    /// As [`Self::put_read`].
    pub(super) fn put(
        &self,
        (rec, des): (Key, Key),
        row: &DecisionRow,
        now: Duration,
    ) -> Result<(), Error> {
        let why = reason_key(&row.reason);
        let mut own = self.own();
        if !own.as_ref().is_some_and(|own| own.reasons.contains(&why)) {
            let reason = Note::Reason {
                why: why.clone(),
                reason: row.reason.clone(),
            };
            self.append(&mut own, &reason, false)?;
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
        self.append(&mut own, &line, true)?;
        let Some(own) = own.as_mut() else {
            return Ok(());
        };
        own.reasons.insert(why);
        if now.saturating_sub(own.synced) >= SYNC {
            own.synced = now;
            own.file
                .sync_data()
                .map_err(|error| unwritable(&own.path, &error))?;
        }
        Ok(())
    }

    /// Notes that a recording is begun.
    ///
    /// # Errors
    ///
    /// As [`Self::put_read`].
    pub(super) fn begin(&self, rec: Key, name: &str) -> Result<(), Error> {
        let name = name.into();
        self.append(&mut self.own(), &Note::Begun { rec, name }, false)
    }

    /// Notes that a recording is left in good order.
    ///
    /// # Errors
    ///
    /// As [`Self::put_read`].
    pub(super) fn end(&self, rec: Key) -> Result<(), Error> {
        self.append(&mut self.own(), &Note::Ended { rec }, false)
    }

    /// Sees what this process appended onto the disk.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if that fails.
    pub(super) fn sync(&self) -> Result<(), Error> {
        match self.own().as_ref() {
            Some(own) => own
                .file
                .sync_data()
                .map_err(|error| unwritable(&own.path, &error)),
            None => Ok(()),
        }
    }

    /// Appends a line, which a kill of the process does not take away.
    fn append(
        &self,
        own: &mut Option<OwnFile>,
        line: &impl Serialize,
        is_row: bool,
    ) -> Result<(), Error> {
        let Some(folder) = &self.folder else {
            return Ok(());
        };
        let text = sealed(line).map_err(|error| unwritable(folder, &error))?;
        let own = match own {
            Some(own) => own,
            None => own
                .insert(own_file(folder, &self.label).map_err(|error| unwritable(folder, &error))?),
        };
        if let Err(error) = own.file.write_all(text.as_bytes()) {
            // A full disk leaves half a line, and a note that something is begun which nothing ends.
            let _ = own.file.set_len(own.notes_from);
            own.length = own.notes_from;
            return Err(unwritable(&own.path, &error));
        }
        own.length += text.len() as u64;
        if is_row {
            own.notes_from = own.length;
        }
        Ok(())
    }

    fn own(&self) -> MutexGuard<'_, Option<OwnFile>> {
        // A thread that panicked has not left half a line: it is counted after it is written.
        self.own.lock().unwrap_or_else(|held| held.into_inner())
    }
}

/// By what the decisions of a design are found.
#[derive(Debug, Clone, Copy)]
pub(super) struct DesignKey {
    pub(super) key: Key,
    /// Its limit angle [rad]: a row of another one is none of it.
    pub(super) threshold_rad: f64,
}

/// What a store holds of some recordings.
#[derive(Debug, Default)]
pub(super) struct Known {
    recordings: BTreeMap<Key, KnownRecording>,
    /// Damages, one sentence each.
    pub(super) damages: Vec<String>,
    /// Pairs of which two decisions differ, with the file of the second.
    pub(super) contradictions: Vec<(Key, Key, String)>,
    /// The files that were read, with their bytes.
    pub(super) files: BTreeMap<String, u64>,
}

/// What a store holds of a recording.
#[derive(Debug, Default)]
struct KnownRecording {
    /// What was read; several where notes of it differ, none of which is believed.
    reads: Vec<ReadFacts>,
    /// Decisions by design, one for each `report_id`.
    rows: BTreeMap<Key, Vec<DecisionRow>>,
    /// Times that it was begun, after which nothing follows of it.
    begun: u32,
}

impl Known {
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
        let mut known = Self::default();
        let keys = keys.into_iter();
        known.recordings = keys.map(|key| (key, KnownRecording::default())).collect();
        for path in paths {
            let of = Share::of_file(&name_of(path));
            let is_other = |(own, of): (Share, Share)| own.of == of.of && own.number != of.number;
            if !share.zip(of).is_some_and(is_other) {
                known
                    .read_file(path)
                    .map_err(|error| Error::io_at("read the store", path, &error))?;
            }
        }
        Ok(known)
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
                // What stands at the end of a line that is too long is none.
                length += file.skip_until(b'\n')? as u64;
                damaged += 1;
                continue;
            }
            match Line::parse(&line) {
                Some(Line::Row(row)) => {
                    begun.remove(&row.rec);
                    self.take(*row, &reasons, &name);
                }
                Some(Line::Note(Note::Reason { why, reason })) => {
                    reasons.insert(why, reason);
                }
                Some(Line::Note(Note::Read { rec, read })) => {
                    if let Some(known) = self.recordings.get_mut(&rec)
                        && !known.reads.contains(&read)
                    {
                        known.reads.push(read);
                    }
                }
                Some(Line::Note(Note::Begun { rec, .. })) => {
                    begun.insert(rec);
                }
                Some(Line::Note(Note::Ended { rec })) => {
                    begun.remove(&rec);
                }
                None => damaged += 1,
            }
        }
        for rec in begun {
            if let Some(known) = self.recordings.get_mut(&rec) {
                known.begun += 1;
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

    fn take(&mut self, line: RowLine, reasons: &BTreeMap<String, Reason>, file: &str) {
        let known = self.recordings.get_mut(&line.rec);
        let (Some(known), Some(reason)) = (known, reasons.get(&line.why)) else {
            return;
        };
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
        let rows = known.rows.entry(line.des).or_default();
        match rows.iter().find(|other| other.report_id == row.report_id) {
            Some(other) if !agree(other, &row) => {
                let pair = (line.rec, line.des, file.into());
                self.contradictions.push(pair);
            }
            Some(_) => {}
            None => rows.push(row),
        }
    }

    /// Takes several decisions of a pair, each of something else that was read, for contradictions.
    pub(super) fn contradict_doubles(&mut self) {
        for (rec, known) in &self.recordings {
            let doubles = known.rows.iter().filter(|(_, rows)| rows.len() > 1);
            let doubles = doubles.map(|(des, _)| (*rec, *des, "the store".into()));
            self.contradictions.extend(doubles);
        }
    }

    /// Returns the decision of a pair, if there is one and no other.
    pub(super) fn row(&self, recording: Key, design: &DesignKey) -> Option<&DecisionRow> {
        // A row says nothing of what was read.
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

    /// Returns what was read of a recording, if that is beyond doubt.
    pub(super) fn facts(&self, recording: Key) -> Option<&ReadFacts> {
        match self.recordings.get(&recording)?.reads.as_slice() {
            [read] => Some(read),
            _ => None,
        }
    }

    /// Tells whether a recording was begun so often, and nothing followed, that shares pass over it.
    pub(super) fn is_left(&self, recording: Key) -> bool {
        let known = self.recordings.get(&recording);
        known.is_some_and(|known| known.begun >= BEGUN_MAX)
    }
}

/// Tells whether two decisions say the same; how a reason is worded may change with the version.
fn agree(one: &DecisionRow, other: &DecisionRow) -> bool {
    let plain = |row: &DecisionRow| {
        let mut row = row.clone();
        row.reason.text.clear();
        row
    };
    plain(one) == plain(other)
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
        let (said, rest) = text.split_at_checked(text.len().checked_sub(SUM_LEN)?)?;
        if rest != sum(said) {
            return None;
        }
        let whole = format!("{said}}}");
        if said.starts_with("{\"note\":") {
            return serde_json::from_str(&whole).ok().map(Self::Note);
        }
        serde_json::from_str(&whole).ok().map(Self::Row)
    }
}

/// Bytes that the checksum takes with its key and what ends the line.
const SUM_LEN: usize = r#","sum":""}"#.len() + 16;

/// Returns a line with its checksum.
fn sealed(line: &impl Serialize) -> io::Result<String> {
    let mut text = serde_json::to_string(line)?;
    text.pop();
    let sum = sum(&text);
    Ok(text + &sum + "\n")
}

/// Returns what ends a line that begins so: the first eight bytes of its SHA-256.
fn sum(said: &str) -> String {
    format!(",\"sum\":\"{:.16}\"}}", Key::of(said.as_bytes()))
}

/// Returns what stands for a reason in rows.
fn reason_key(reason: &Reason) -> String {
    let text = format!("{} {}", reason.code, reason.text);
    format!("{:.12}", Key::of(text.as_bytes()))
}

/// Makes the folder of a store, with its marks: for programs that keep copies, and for git.
pub(super) fn make(folder: &Path) -> Result<(), Error> {
    // What else lies in a folder that was there must not vanish from git.
    let own = !folder.exists() || folder.ends_with(FOLDER);
    fs::create_dir_all(folder).map_err(|error| Error::io_at("make the store", folder, &error))?;
    for (name, text, wanted) in [
        ("CACHEDIR.TAG", CACHE_TAG, true),
        (".gitignore", "*\n", own),
    ] {
        let mark = folder.join(name);
        if wanted && !mark.exists() {
            fs::write(&mark, text).map_err(|error| unwritable(&mark, &error))?;
        }
    }
    Ok(())
}

/// Tells whether a folder is a store by the mark that latchgate makes; other programs' caches are none.
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
        // What else bears such a name is nobody's here, and to open a pipe takes for ever.
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
    let own = files
        .iter()
        .filter(|path| Share::of_file(&name_of(path)) == Some(share));
    Ok(own
        .filter_map(|path| Some(path.metadata().ok()?.len()))
        .sum())
}

/// Writes a file beside its place and moves it there whole.
pub(super) fn put_in_place(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = path.with_extension(format!("{}.part", std::process::id()));
    let write = || {
        let mut file = File::create(&beside)?;
        file.write_all(bytes)?;
        // By the handle that wrote: Windows refuses it to one that only reads.
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
fn own_file(folder: &Path, label: &str) -> io::Result<OwnFile> {
    let process = std::process::id();
    let host = host();
    let mut number = 0_u32;
    loop {
        let path = folder.join(format!("{host}-{process}-{number}{label}.{ENDING}"));
        match OpenOptions::new().append(true).create_new(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            made => {
                return made.map(|file| OwnFile {
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
