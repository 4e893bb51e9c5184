//! The share of one process: its recordings judged with every design, kept line by line.

use super::key::Key;
use super::plan::{Plan, PlannedRecording};
use super::question::Questions;
use super::run::{Clock, GateJudge};
use super::share::Share;
use super::store::{BEGUN_MAX, Store, StoredDecisions, make, name_of, put_in_place};
use crate::pipeline::{Control, Limits};
use latchgate_recording::error::{Error, ErrorKind, Place};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Settings of one share's process.
pub struct ShareTask<'a> {
    /// The share.
    pub share: Share,
    /// Folder of the store.
    pub folder: &'a Path,
    /// Limits on input.
    pub limits: &'a Limits,
    /// Time since the process began.
    pub clock: Clock<'a>,
}

/// Result of judging a share.
#[derive(Debug, Default)]
pub struct ShareOutcome {
    /// Recordings of the share.
    pub recordings: usize,
    /// Pairs that were in the store before.
    pub stored: usize,
    /// Pairs that were judged.
    pub judged: usize,
    /// Recordings of which pairs are missing, each with the reason.
    pub refused: Vec<Error>,
}

/// The mark of a share that is completely in the store: the files that hold it, and their bytes.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct ShareDone {
    pub(super) files: BTreeMap<String, u64>,
}

impl ShareDone {
    /// Reads the mark of a share; an empty one, where the share is not done. It is opened by name,
    /// since a shared file system may list a folder as it was some time ago.
    pub(super) fn read(folder: &Path, share: Share) -> Self {
        let text = fs::read(done_path(folder, share)).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }
}

/// Start of the name of a share's mark.
const DONE: &str = "done";

/// Returns the path of a share's mark.
fn done_path(folder: &Path, share: Share) -> PathBuf {
    folder.join(format!("{DONE}{}.json", share.label()))
}

/// Returns each number of shares of which a store lists a mark.
///
/// # Errors
///
/// [`ErrorKind::Io`] if the store cannot be listed.
pub(super) fn divisions(folder: &Path) -> Result<BTreeSet<u32>, Error> {
    let list = || -> io::Result<BTreeSet<u32>> {
        let mut divisions = BTreeSet::new();
        for entry in fs::read_dir(folder)? {
            let name = entry?.file_name();
            let name = name.to_string_lossy();
            let share = Share::of_file(&name).filter(|_| name.starts_with(DONE));
            divisions.extend(share.map(|share| share.of));
        }
        Ok(divisions)
    };
    list().map_err(|error| Error::io_at("list the store", folder, &error))
}

/// Judges the recordings of a share with every design; what is in the store is not judged again.
///
/// A recording that was begun twice and never ended is refused, for it may end this process, too.
/// The other recordings are judged.
///
/// # Errors
///
/// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work; what is done is kept. [`ErrorKind::Io`] if the
/// store cannot be read or written, [`ErrorKind::Malformed`] if it holds two decisions of a pair that
/// differ.
pub fn judge_share(
    plan: &Plan,
    task: &ShareTask<'_>,
    control: &Control<'_>,
) -> Result<ShareOutcome, Error> {
    make(task.folder)?;
    let numbers = 0..plan.recordings.len();
    let numbers: Vec<usize> = numbers
        .filter(|&number| task.share.holds(&plan.recordings[number].name))
        .collect();
    let questions = Questions::new(task.limits);
    let key = |number: &usize| Ok::<_, Error>(questions.key(&plan.recordings[*number]));
    let keys = control.try_map(&numbers, key)?;
    let store = Store::open(task.folder, &task.share.label())?;
    let stored = store.decisions(keys.iter().copied(), Some(task.share))?;
    let judge = ShareJudge {
        plan,
        store: &store,
        stored: &stored,
        judge: GateJudge::new(plan, task.limits, &store, task.clock),
    };
    let recordings: Vec<(usize, Key)> = numbers.into_iter().zip(keys).collect();
    plan.check_agreement(recordings.iter().copied(), &stored)?;
    let outcomes = control.try_map(&recordings, |&(number, key)| {
        // The progress shown counts recordings; that within one of them would disturb it.
        control.unmeasured(|control| judge.recording(number, key, &control.with_threads(1)))
    });
    // Before the outcomes are looked at: a stopped run, too, keeps what it judged.
    store.sync()?;
    let mut share_outcome = ShareOutcome {
        recordings: recordings.len(),
        ..ShareOutcome::default()
    };
    for outcome in outcomes? {
        share_outcome.stored += outcome.stored;
        share_outcome.judged += outcome.judged;
        share_outcome.refused.extend(outcome.refused);
    }
    if share_outcome.refused.is_empty() {
        mark_done(task, &store, stored)?;
    }
    Ok(share_outcome)
}

/// Data that the threads of a share have in common.
struct ShareJudge<'a> {
    plan: &'a Plan,
    store: &'a Store,
    stored: &'a StoredDecisions,
    judge: GateJudge<'a>,
}

impl ShareJudge<'_> {
    fn recording(
        &self,
        number: usize,
        key: Key,
        control: &Control<'_>,
    ) -> Result<ShareOutcome, Error> {
        let recording = &self.plan.recordings[number];
        let mut outcome = ShareOutcome::default();
        let rows = self.judge.stored_rows(key, self.stored);
        outcome.stored = rows.iter().flatten().count();
        if outcome.stored == rows.len() {
            return Ok(outcome);
        }
        if self.stored.is_skipped(key) {
            outcome.refused.push(never_ended(recording));
            return Ok(outcome);
        }
        // Between these two notes a crash of the process is known to be due to this recording.
        self.store.begin(key, &recording.name)?;
        let judged = self.judge.recording(number, key, self.stored, control);
        self.store.end(key)?;
        match judged {
            Ok(judged) if judged.unread.is_some() => outcome.refused.extend(judged.unread),
            Ok(judged) => outcome.judged = judged.rows.len() - judged.cached,
            Err(error) if matches!(error.kind(), ErrorKind::Malformed { .. }) => {
                outcome.refused.push(error);
            }
            Err(error) => return Err(error),
        }
        Ok(outcome)
    }
}

/// Returns the error for a recording that is skipped since it ended its process twice.
fn never_ended(recording: &PlannedRecording) -> Error {
    let expected = "a recording that does not end its process";
    let found = format!("one that was begun {BEGUN_MAX} times and never finished");
    let hint = "inspect it, or give the process more memory; the gate without shares judges it too";
    Error::malformed(expected, found, hint).at(Place::file(recording.name.clone()))
}

/// Marks the share as completely in the store, with the files that hold it.
fn mark_done(task: &ShareTask<'_>, store: &Store, stored: StoredDecisions) -> Result<(), Error> {
    let files = stored.files;
    let mut done = ShareDone { files };
    if let Some((path, length)) = store.process_file() {
        done.files.insert(name_of(&path), length);
    }
    let path = done_path(task.folder, task.share);
    serde_json::to_vec(&done)
        .map_err(Into::into)
        .and_then(|text| put_in_place(&path, &text))
        .map_err(|error| Error::io_at("write the store", &path, &error))
}
