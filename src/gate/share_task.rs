//! The share of one process: its recordings judged with every design, kept line by line.

use super::key::Key;
use super::plan::{Plan, PlannedRecording};
use super::question::Questions;
use super::run::{Clock, Judging, changed};
use super::share::Share;
use super::store::{BEGUN_MAX, Known, Store, make, name_of, put_in_place};
use super::submission::Submission;
use crate::pipeline::{Control, DecisionRow, Design, Limits, Prepared};
use latchgate_recording::error::{Error, ErrorKind, Place};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What a share is judged with.
pub struct ShareTask<'a> {
    /// Which one.
    pub share: Share,
    /// Folder of the store.
    pub folder: &'a Path,
    /// Limits on input.
    pub limits: &'a Limits,
    /// What the recordings and designs were when the gate was submitted, if it was.
    pub submission: Option<&'a Submission>,
    /// Time since the process began.
    pub clock: Clock<'a>,
}

/// What became of a share.
#[derive(Debug, Default)]
pub struct ShareOutcome {
    /// Recordings of the share.
    pub recordings: usize,
    /// Pairs that were in the store before.
    pub known: usize,
    /// Pairs that were judged.
    pub judged: usize,
    /// Recordings of which pairs are missing, each with the reason.
    pub refused: Vec<Error>,
}

/// What a share says once it is wholly in the store: the files that hold it, and their bytes.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct ShareDone {
    pub(super) files: BTreeMap<String, u64>,
}

impl ShareDone {
    /// Reads what a share said; nothing, where it said nothing yet. By name, since a list of names
    /// may be old.
    pub(super) fn read(folder: &Path, share: Share) -> Self {
        let text = fs::read(done_path(folder, share)).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }
}

/// Returns where that is said.
fn done_path(folder: &Path, share: Share) -> PathBuf {
    folder.join(format!("done{}.json", share.label()))
}

/// Judges the recordings of a share with every design; what is in the store is not judged again.
///
/// A recording that is not the one that was submitted is refused, and so is one that was begun
/// twice and never ended, for it may end this process, too; the others go on.
///
/// # Errors
///
/// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work; what is done is kept. [`ErrorKind::Io`] if the
/// store cannot be read or written, [`ErrorKind::Malformed`] if the designs are not those that were
/// submitted.
pub fn judge_share(
    plan: &Plan,
    task: &ShareTask<'_>,
    control: &Control<'_>,
) -> Result<ShareOutcome, Error> {
    make(task.folder)?;
    if let Some(submission) = task.submission {
        submission.check(plan)?;
    }
    let numbers = 0..plan.recordings.len();
    let own: Vec<usize> = numbers
        .filter(|&number| task.share.holds(&plan.recordings[number].name))
        .collect();
    let questions = Questions::new(task.limits);
    let key = |number: &usize| Ok::<_, Error>(questions.key(&plan.recordings[*number]));
    let keys = control.try_map(&own, key)?;
    let store = Store::open(task.folder, &task.share.label())?;
    let known = store.known(keys.iter().copied(), Some(task.share))?;
    let sharing = Sharing {
        plan,
        task,
        store: &store,
        known: &known,
        judging: Judging::new(plan, task.limits, &store, task.clock),
    };
    let recordings: Vec<(usize, Key)> = own.into_iter().zip(keys).collect();
    plan.check_agreement(recordings.iter().copied(), &known)?;
    let outcomes = control.try_map(&recordings, |&(number, key)| {
        // How far one recording is says nothing of the whole.
        control.unmeasured(|control| sharing.recording(number, key, &control.with_threads(1)))
    });
    store.sync()?;
    let mut whole = ShareOutcome {
        recordings: recordings.len(),
        ..ShareOutcome::default()
    };
    for outcome in outcomes? {
        whole.known += outcome.known;
        whole.judged += outcome.judged;
        whole.refused.extend(outcome.refused);
    }
    if whole.refused.is_empty() {
        say_done(task, &store, known)?;
    }
    Ok(whole)
}

/// What the threads of a share have in common.
struct Sharing<'a> {
    plan: &'a Plan,
    task: &'a ShareTask<'a>,
    store: &'a Store,
    known: &'a Known,
    judging: Judging<'a>,
}

impl Sharing<'_> {
    fn recording(
        &self,
        number: usize,
        key: Key,
        control: &Control<'_>,
    ) -> Result<ShareOutcome, Error> {
        let recording = &self.plan.recordings[number];
        let mut outcome = ShareOutcome::default();
        let submission = self.task.submission;
        let submitted = submission.and_then(|own| own.recording(&recording.name));
        if submitted.is_some_and(|submitted| submitted != key) {
            outcome
                .refused
                .push(changed(recording, "since it was submitted"));
            return Ok(outcome);
        }
        let rows = self.judging.known_rows(key, self.known);
        outcome.known = rows.iter().flatten().count();
        if outcome.known == rows.len() {
            return Ok(outcome);
        }
        if self.known.is_left(key) {
            outcome.refused.push(left(recording));
            return Ok(outcome);
        }
        self.store.begin(key, &recording.name)?;
        let judged = self.judging.recording(number, key, self.known, control);
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

/// Says why a recording is not judged.
fn left(recording: &PlannedRecording) -> Error {
    let expected = "a recording that does not end its process";
    let found = format!("one that was begun {BEGUN_MAX} times and never finished");
    let hint = "inspect it, or give the process more memory; the gate without shares judges it too";
    Error::malformed(expected, found, hint).at(Place::file(recording.name.clone()))
}

/// Says that the share is wholly in the store, and in which files.
fn say_done(task: &ShareTask<'_>, store: &Store, known: Known) -> Result<(), Error> {
    let mut done = ShareDone { files: known.files };
    if let Some((path, length)) = store.own_file() {
        done.files.insert(name_of(&path), length);
    }
    let path = done_path(task.folder, task.share);
    serde_json::to_vec(&done)
        .map_err(Into::into)
        .and_then(|text| put_in_place(&path, &text))
        .map_err(|error| Error::io_at("write the store", &path, &error))
}

/// Judges one pair and keeps nothing, to see what it takes.
///
/// # Errors
///
/// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work.
pub fn judge_pair(
    recording: &PlannedRecording,
    design: &Design,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<DecisionRow, Error> {
    let source = recording.source();
    match Prepared::open(&source, &recording.request, limits, control) {
        Ok(prepared) => prepared.row(design, control),
        Err(refused) if refused.error.is_stopped() => Err(refused.error),
        Err(refused) => Ok(refused.row(design)),
    }
}
