//! The share of one process: its recordings judged with every design, kept block by block.
//!
//! The desk of one process holds its store, its clock and the block that is not yet written;
//! judging, writing and giving up share it, and so stand together.

use super::block::{self, BlockKind, BlockOf, Key};
use super::index::{ENDS_MAX, EndNote, KnownDesigns, Share, StoreIndex, name_of, put_in_place};
use super::plan::{Plan, PlannedRecording};
use super::question::Questions;
use super::store::{self, BlockRows, Store};
use super::submission::Submission;
use crate::pipeline::{Answer, Control, DecisionRow, Design, Limits, Prepared, Reason, Source};
use latchgate_kernel::error::Error as KernelError;
use latchgate_recording::error::{Error, ErrorKind, Place};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Longest work that a block holds [s]: what a kill costs at most.
const BLOCK_S: f64 = 30.0;

/// Longest work that a block holds, as part of what its process has done: what kills cost of the
/// whole, however often they come.
const BLOCK_PART: f64 = 0.02;

/// Most rows of a block.
const BLOCK_ROWS: usize = 4096;

/// Time after which what was appended is seen onto the disk [s].
const SYNC_S: f64 = 5.0;

/// What a share is judged with.
pub struct ShareTask<'a> {
    /// Which one.
    pub share: Share,
    /// Folder of the store.
    pub folder: &'a Path,
    /// Limits on input.
    pub limits: &'a Limits,
    /// What the recordings and designs were when the sweep was submitted, if it was.
    pub submission: Option<&'a Submission>,
    /// Time since the process began [s].
    pub clock: &'a (dyn Fn() -> f64 + Sync),
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
    /// Pairs given up, in this run or before.
    pub given_up: usize,
    /// Recordings that were not judged, each with the reason.
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
/// A recording that is not the one that was submitted is refused, the others go on.
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
    store::make(task.folder)?;
    if let Some(submission) = task.submission {
        submission.check(plan)?;
    }
    let index = StoreIndex::open(
        task.folder,
        store::files(task.folder)?,
        Some(task.share),
        true,
    )?;
    let designs = KnownDesigns::new(plan.design_keys());
    designs.keep(task.folder)?;
    let label = task.share.label();
    let desk = ShareDesk {
        plan,
        task,
        questions: Questions::new(task.limits),
        store: Store::beside(task.folder, &label),
        given_up: Store::beside(task.folder, &format!("{label}-ended")),
        designs,
        index,
        synced_s: Mutex::new(0.0),
    };
    let own = plan.recordings.iter();
    let own: Vec<&PlannedRecording> = own.filter(|own| task.share.holds(&own.name)).collect();
    let outcomes = control.try_map(&own, |recording| {
        // How far one recording is says nothing of the whole.
        control.unmeasured(|control| desk.recording(recording, &control.with_threads(1)))
    });
    desk.store.sync()?;
    desk.given_up.sync()?;
    let mut whole = ShareOutcome {
        recordings: own.len(),
        ..ShareOutcome::default()
    };
    for outcome in outcomes? {
        whole.known += outcome.known;
        whole.judged += outcome.judged;
        whole.given_up += outcome.given_up;
        whole.refused.extend(outcome.refused);
    }
    if whole.refused.is_empty() {
        desk.say_done()?;
    }
    Ok(whole)
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
    let source = Source::File(recording.path.clone());
    match Prepared::open(&source, &recording.request, limits, control) {
        Ok(prepared) => prepared.row(design, control),
        Err(refused) if refused.error.is_stopped() => Err(refused.error),
        Err(refused) => Ok(refused.row(design)),
    }
}

/// What the threads of a share have in common.
struct ShareDesk<'a> {
    plan: &'a Plan,
    task: &'a ShareTask<'a>,
    questions: Questions,
    store: Store,
    /// What stands there can be deleted, so that it is tried again.
    given_up: Store,
    designs: KnownDesigns,
    index: StoreIndex,
    /// When what was appended was last seen onto the disk.
    synced_s: Mutex<f64>,
}

impl ShareDesk<'_> {
    fn recording(
        &self,
        recording: &PlannedRecording,
        control: &Control<'_>,
    ) -> Result<ShareOutcome, Error> {
        let mut outcome = ShareOutcome::default();
        let key = self.questions.key(recording);
        let submitted = self
            .task
            .submission
            .and_then(|own| own.recording(&recording.name));
        if submitted.is_some_and(|submitted| submitted != key) {
            outcome
                .refused
                .push(changed(recording, "since it was submitted"));
            return Ok(outcome);
        }
        let places = self.index.known(key, &mut self.designs.clone());
        let given_up =
            |place: &&Option<_>| place.is_some_and(|(block, _)| self.index.is_given_up(block));
        outcome.given_up = places.iter().filter(given_up).count();
        outcome.known = places.iter().flatten().count();
        if outcome.known == places.len() {
            return Ok(outcome);
        }
        let unknown = (0..places.len()).filter(|&place| places[place].is_none());
        if let Some(how) = self.index.given_up(key) {
            let unknown: Vec<usize> = unknown.collect();
            self.give_up(key, &unknown, how)?;
            outcome.given_up += unknown.len();
            return Ok(outcome);
        }
        let note = |kind| self.store.append(BlockOf::note(kind, key), &());
        note(BlockKind::Begun)?;
        let judged = self.judged(recording, key, unknown, control);
        note(BlockKind::Left)?;
        match judged {
            Ok(judged) => outcome.judged = judged,
            Err(error) if matches!(error.kind(), ErrorKind::Malformed { .. }) => {
                outcome.refused.push(error);
            }
            Err(error) => return Err(error),
        }
        Ok(outcome)
    }

    /// Judges a recording with the designs at those places; returns how many they were.
    fn judged(
        &self,
        recording: &PlannedRecording,
        key: Key,
        places: impl Iterator<Item = usize>,
        control: &Control<'_>,
    ) -> Result<usize, Error> {
        let source = Source::File(recording.path.clone());
        let prepared = Prepared::open(&source, &recording.request, self.task.limits, control);
        // Between the two keys it was read.
        if self.questions.key(recording) != key {
            return Err(changed(recording, "while it was read"));
        }
        let read = match &prepared {
            Ok(prepared) => prepared.recording(),
            Err(refused) if refused.error.is_stopped() => {
                return Err(KernelError::Stopped.into());
            }
            Err(refused) => refused.recording(),
        };
        let mut block = PendingBlock {
            first: 0,
            began_s: (self.task.clock)(),
            body: BlockRows {
                sha256: read.sha256.clone(),
                channel: read.channel.clone(),
                rows: Vec::new(),
            },
        };
        let mut judged = 0;
        let mut ending = Ok(());
        for place in places {
            let design = &self.plan.designs[place];
            let row = match &prepared {
                Ok(prepared) => prepared.row(design, control),
                Err(refused) => Ok(refused.row(design)),
            };
            tracing::debug!(recording = %recording.name, design = %design.name, "judged");
            match row {
                Ok(row) => self.take(&mut block, key, place, row)?,
                Err(error) => {
                    ending = Err(error);
                    break;
                }
            }
            judged += 1;
        }
        // What is done is kept, also where the rest is stopped.
        self.flush(&mut block, key)?;
        ending.map(|()| judged)
    }

    /// Adds a row to the block, which is kept once it holds enough work.
    fn take(
        &self,
        block: &mut PendingBlock,
        key: Key,
        place: usize,
        row: DecisionRow,
    ) -> Result<(), Error> {
        if place != block.first + block.body.rows.len() {
            self.flush(block, key)?;
            block.first = place;
        }
        block.body.rows.push(row);
        let now = (self.task.clock)();
        let long = now - block.began_s >= BLOCK_S.min(BLOCK_PART * now);
        if long || block.body.rows.len() >= BLOCK_ROWS {
            self.flush(block, key)?;
        }
        Ok(())
    }

    fn flush(&self, block: &mut PendingBlock, key: Key) -> Result<(), Error> {
        let rows = block.body.rows.len();
        if rows > 0 {
            let of = self.block_of(BlockKind::Rows, key, block.first, rows);
            self.store.append(of, &block.body)?;
            block.first += rows;
            block.body.rows.clear();
        }
        block.began_s = (self.task.clock)();
        let mut synced_s = self
            .synced_s
            .lock()
            .unwrap_or_else(|held| held.into_inner());
        if block.began_s - *synced_s >= SYNC_S {
            self.store.sync()?;
            *synced_s = block.began_s;
        }
        Ok(())
    }

    fn block_of(&self, kind: BlockKind, recording: Key, first: usize, count: usize) -> BlockOf {
        BlockOf {
            designs: self.designs.list,
            first: first as u32,
            count: count as u32,
            ..BlockOf::note(kind, recording)
        }
    }

    /// Keeps that pairs are given up.
    fn give_up(&self, key: Key, places: &[usize], how: &str) -> Result<(), Error> {
        for run in places.chunk_by(|a, b| a + 1 == *b) {
            for some in run.chunks(BLOCK_ROWS) {
                let rows = some
                    .iter()
                    .map(|&place| row_given_up(&self.plan.designs[place], how));
                let body = BlockRows {
                    rows: rows.collect(),
                    ..BlockRows::default()
                };
                let of = self.block_of(BlockKind::GivenUp, key, some[0], some.len());
                self.given_up.append(of, &body)?;
            }
        }
        Ok(())
    }

    /// Says that the share is wholly in the store, and in which files.
    fn say_done(&self) -> Result<(), Error> {
        let mut done = ShareDone::default();
        let before = self.index.files.iter().zip(&self.index.lengths);
        let before = before.map(|(path, length)| (path.clone(), *length));
        let own = [self.store.own_file(), self.given_up.own_file()];
        for (path, length) in before.chain(own.into_iter().flatten()) {
            done.files.insert(name_of(&path), length);
        }
        let path = done_path(self.task.folder, self.task.share);
        serde_json::to_vec(&done)
            .map_err(Into::into)
            .and_then(|text| put_in_place(&path, &text))
            .map_err(|error| Error::io_at("write the store", &path, &error))
    }
}

/// Rows that are not yet kept.
struct PendingBlock {
    /// Place of the first row's design.
    first: usize,
    /// When its work began.
    began_s: f64,
    body: BlockRows,
}

fn row_given_up(design: &Design, how: &str) -> DecisionRow {
    DecisionRow {
        // No question is answered.
        report_id: String::new(),
        verdict: Answer::Unusable,
        reason: Reason {
            code: "ended-its-process".into(),
            text: format!(
                "judging it ended its process {ENDS_MAX} times, the last time by {how}; look for what \
                 is odd in the recording, or give the process more memory"
            ),
        },
        threshold_rad: design.criterion.threshold_rad,
        peak_angle_rad: None,
        uncertainty_rad: None,
        coast_peak_angle_rad: None,
        share: None,
    }
}

fn changed(recording: &PlannedRecording, when: &str) -> Error {
    let found = format!("another one, or another card: its hash changed {when}");
    Error::malformed("the recording as it was", &found, "submit the sweep again")
        .at(Place::file(recording.name.clone()))
}

/// Notes in the store that a process of the share ended so, with whatever it had begun; returns
/// whether it had begun anything.
///
/// # Errors
///
/// [`ErrorKind::Io`] if the store cannot be read or written.
pub fn note_end(folder: &Path, share: Share, process: u32, how: &str) -> Result<bool, Error> {
    let before = format!("{}-{process}-", store::host());
    let behind = format!("{}.{}", share.label(), store::ENDING);
    // Of several processes of one number the last; clocks may have been set meanwhile.
    let number = |path: &PathBuf| -> Option<u32> {
        let name = name_of(path);
        let number = name.strip_prefix(&before)?.strip_suffix(&behind)?;
        number.parse().ok()
    };
    let files = store::files(folder)?;
    let last = files.iter().filter_map(|path| Some((number(path)?, path)));
    let Some((_, path)) = last.max() else {
        return Ok(false);
    };
    let begun = StoreIndex::begun_by(path)?;
    let notes = Store::beside(folder, &format!("{}-ended", share.label()));
    for recording in &begun {
        let note = EndNote {
            file: name_of(path),
            how: how.into(),
        };
        notes.append(BlockOf::note(BlockKind::Ended, *recording), &note)?;
    }
    notes.sync()?;
    // Its file then speaks of no end of its own: without the notes the recordings are tried again. As
    // long as the notes are there it changes nothing, and a full disk may refuse it.
    if let Ok(mut file) = OpenOptions::new().append(true).open(path) {
        for recording in &begun {
            let left = block::encode(BlockOf::note(BlockKind::Left, *recording), &());
            let _ = left.and_then(|left| file.write_all(&left));
        }
    }
    Ok(!begun.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two processes of one number the later one is meant, whatever the clocks say.
    #[test]
    fn verif_an_end_is_noted_of_the_last_process_of_its_number()
    -> Result<(), Box<dyn std::error::Error>> {
        let name = format!("latchgate-ends-{}", std::process::id());
        let target = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/tmp");
        let folder = target.join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder)?;
        let share = Share { number: 1, of: 2 };
        let begin = |recording: Key| {
            let store = Store::beside(&folder, &share.label());
            let note = BlockOf::note(BlockKind::Begun, recording);
            store.append(note, &())?;
            Ok::<_, Error>(store.own_file())
        };
        let (first, second) = ([1; 16], [2; 16]);
        let earlier = begin(first)?;
        // A clock that was set back meanwhile.
        let (earlier, _) = earlier.ok_or("no file")?;
        let earlier = fs::File::options().append(true).open(earlier)?;
        let hour = core::time::Duration::from_secs(3600);
        earlier.set_modified(earlier.metadata()?.modified()? + hour)?;
        for _ in 0..ENDS_MAX {
            begin(second)?;
            assert!(note_end(&folder, share, std::process::id(), "a test")?);
        }
        let files = store::files(&folder)?;
        let index = StoreIndex::open(&folder, files, Some(share), false)?;
        assert_eq!(index.given_up(second), Some("a test"));
        assert_eq!(index.given_up(first), None);
        // Without the notes it is tried again.
        let is_note = |path: &Path| name_of(path).contains("-ended");
        for note in store::files(&folder)?.iter().filter(|path| is_note(path)) {
            fs::remove_file(note)?;
        }
        let index = StoreIndex::open(&folder, store::files(&folder)?, Some(share), false)?;
        assert_eq!(index.given_up(second), None);
        Ok(fs::remove_dir_all(&folder)?)
    }
}
