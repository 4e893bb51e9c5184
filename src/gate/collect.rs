//! The shares of a gate as a store holds them: what is done, what is missing, and the decisions.

use super::key::Key;
use super::plan::Plan;
use super::run::JudgedRecording;
use super::share::Share;
use super::share_task::{self, ShareDone};
use super::store::{self, DesignKey, StoredDecisions};
use crate::pipeline::{Control, Limits};
use latchgate_recording::error::{Error, Place};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Largest number of recordings named in a status: a list to read, not the store's contents.
const NAMED_MAX: usize = 1000;

/// Progress of the shares of a gate.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct SweepStatus {
    /// All pairs.
    pub pairs: usize,
    /// Pairs that were judged.
    pub done: usize,
    /// Pairs that are not in the store.
    pub missing: usize,
    /// Recordings with the number of their pairs that are missing, a thousand at most.
    pub missing_of: Vec<(String, usize)>,
    /// Missing recordings that shares skip, since they were begun twice and never ended; a thousand
    /// at most.
    pub never_ended: Vec<String>,
}

/// A gate and the store of its shares.
#[derive(Debug)]
pub struct Collection<'a> {
    plan: &'a Plan,
    /// Files of shares that are marked as done, with their bytes.
    finished: BTreeMap<String, u64>,
    recordings: Vec<Key>,
    designs: Vec<DesignKey>,
    stored: StoredDecisions,
}

impl<'a> Collection<'a> {
    /// Collects the pairs of a plan from a store. The keys of recordings and designs are taken here,
    /// so a decision of another content, design, setting or version is not found: its pair is missing.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] if two decisions of a pair differ,
    /// [`latchgate_recording::error::ErrorKind::Io`] if the store cannot be read,
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped).
    pub fn of(
        plan: &'a Plan,
        folder: &Path,
        limits: &Limits,
        control: &Control<'_>,
    ) -> Result<Self, Error> {
        if !folder.is_dir() {
            let error = Error::malformed(
                "the folder of a store",
                "none",
                "state the store of the shares",
            );
            return Err(error.at(Place::path(folder)));
        }
        let recordings = plan.recording_keys(limits, control)?;
        let finished = finished_files(plan, folder)?;
        let mut paths: BTreeSet<PathBuf> = store::files(folder)?.into_iter().collect();
        // A shared file system may open a file that it does not list yet.
        let named = finished.keys().map(|name| folder.join(name));
        paths.extend(named.filter(|path| path.is_file()));
        let paths: Vec<PathBuf> = paths.into_iter().collect();
        let mut stored = StoredDecisions::read(&paths, recordings.iter().copied(), None)?;
        // No recording is read here, so nothing says which of several decisions is that of its
        // present content.
        stored.contradict_doubles();
        plan.check_agreement(recordings.iter().copied().enumerate(), &stored)?;
        Ok(Self {
            plan,
            finished,
            recordings,
            designs: plan.design_keys(),
            stored,
        })
    }

    /// Returns the damage to the store, one sentence each.
    pub fn damages(&self) -> &[String] {
        &self.stored.damages
    }

    /// Returns what is done and what is missing.
    pub fn status(&self) -> SweepStatus {
        let mut status = SweepStatus::default();
        for (recording, key) in self.plan.recordings.iter().zip(&self.recordings) {
            let is_missing = |design: &&DesignKey| self.stored.row(*key, design).is_none();
            let missing = self.designs.iter().filter(is_missing).count();
            status.pairs += self.designs.len();
            status.missing += missing;
            if missing == 0 {
                continue;
            }
            if status.missing_of.len() < NAMED_MAX {
                status.missing_of.push((recording.name.clone(), missing));
            }
            if self.stored.is_skipped(*key) && status.never_ended.len() < NAMED_MAX {
                status.never_ended.push(recording.name.clone());
            }
        }
        status.done = status.pairs - status.missing;
        status
    }

    /// Returns the files of finished shares that are absent or too short: a shared file system may
    /// show them late.
    pub fn late(&self) -> Vec<String> {
        let late = self.finished.iter().filter(|(name, length)| {
            let read = self.stored.files.get(*name).copied().unwrap_or(0);
            read < **length
        });
        late.map(|(name, _)| name.clone()).collect()
    }

    /// Returns the decisions of each recording, in the plan's order, for [`super::summarise`].
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] if a pair is missing.
    pub fn judged(&self) -> Result<Vec<JudgedRecording>, Error> {
        let recordings = self.plan.recordings.iter().zip(&self.recordings);
        let judged = recordings.map(|(recording, key)| {
            let rows = self
                .designs
                .iter()
                .filter_map(|design| self.stored.row(*key, design));
            let read = self.stored.facts(*key).cloned().unwrap_or_default();
            let judged = JudgedRecording {
                sha256: read.sha256,
                channel: read.channel,
                rows: rows.cloned().collect(),
                ..JudgedRecording::default()
            };
            if judged.rows.len() == self.designs.len() {
                return Ok(judged);
            }
            let (expected, hint) = ("a decision for every design", "judge its share");
            let error = Error::malformed(expected, "some missing in the store", hint);
            Err(error.at(Place::file(recording.name.clone())))
        });
        judged.collect()
    }
}

/// Returns the files of shares that are marked as done, with their bytes. A mark that is listed tells
/// the number of shares; the others are opened by name, since a shared file system may list a folder
/// as it was some time ago.
fn finished_files(plan: &Plan, folder: &Path) -> Result<BTreeMap<String, u64>, Error> {
    let mut finished: BTreeMap<String, u64> = BTreeMap::new();
    for of in share_task::divisions(folder)? {
        let names = plan.recordings.iter().map(|recording| &recording.name);
        let numbers: BTreeSet<u32> = names.map(|name| Share::number_of(name, of)).collect();
        for number in numbers {
            for (name, length) in ShareDone::read(folder, Share { number, of }).files {
                let longest = finished.entry(name).or_default();
                *longest = length.max(*longest);
            }
        }
    }
    Ok(finished)
}
