//! The shares of a gate as a store holds them: what is done, what is missing, and the decisions.

use super::key::Key;
use super::plan::Plan;
use super::run::JudgedRecording;
use super::share::Share;
use super::share_task::ShareDone;
use super::store::{self, DesignKey, StoredDecisions};
use super::submission::Submission;
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
    /// Numbers of the shares of which something is missing; empty where the number of shares is not
    /// known.
    pub shares: Vec<u32>,
}

/// A gate and the store of its shares.
#[derive(Debug)]
pub struct Collection<'a> {
    plan: &'a Plan,
    shares: Option<u32>,
    /// Files of shares that are marked as done, with their bytes.
    finished: BTreeMap<String, u64>,
    recordings: Vec<Key>,
    designs: Vec<DesignKey>,
    stored: StoredDecisions,
}

impl<'a> Collection<'a> {
    /// Collects the pairs of a plan from a store: of recordings as they were submitted, or else as
    /// they are now.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] if the plan is no longer the one that was submitted, or two
    /// decisions of a pair differ, [`latchgate_recording::error::ErrorKind::Io`] if the store cannot be read,
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped).
    pub fn of(
        plan: &'a Plan,
        folder: &'a Path,
        submission: Option<&Submission>,
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
        let recordings = match submission {
            Some(submission) => {
                submission.check(plan)?;
                let names = plan.recordings.iter().map(|recording| &recording.name);
                names
                    .filter_map(|name| submission.recording(name))
                    .collect()
            }
            None => plan.recording_keys(limits, control)?,
        };
        let shares = submission.map(|submission| submission.shares);
        let mut finished: BTreeMap<String, u64> = BTreeMap::new();
        let count = shares.unwrap_or(0);
        for number in 1..=count {
            let share = Share { number, of: count };
            for (name, length) in ShareDone::read(folder, share).files {
                let longest = finished.entry(name).or_default();
                *longest = length.max(*longest);
            }
        }
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
            shares,
            finished,
            recordings,
            designs: plan.design_keys(),
            stored,
        })
    }

    /// Checks that the recordings are still those of the collection.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] that names one that is not,
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped).
    pub fn check_unchanged(&self, limits: &Limits, control: &Control<'_>) -> Result<(), Error> {
        if self.shares.is_none() {
            // Without a submission their keys were taken just now.
            return Ok(());
        }
        let now = self.plan.recording_keys(limits, control)?;
        let changed = now
            .iter()
            .zip(&self.recordings)
            .position(|(now, submitted)| now != submitted);
        if now.len() == self.recordings.len() && changed.is_none() {
            return Ok(());
        }
        let name = changed.map_or("", |number| self.plan.recordings[number].name.as_str());
        let expected = "the recording as it was submitted and judged";
        let error = Error::malformed(expected, "another one", "submit the shares again");
        Err(error.at(Place::file(name)))
    }

    /// Returns the damage to the store, one sentence each.
    pub fn damages(&self) -> &[String] {
        &self.stored.damages
    }

    /// Returns what is done and what is missing.
    pub fn status(&self) -> SweepStatus {
        let mut status = SweepStatus::default();
        let mut shares = BTreeSet::new();
        for (recording, key) in self.plan.recordings.iter().zip(&self.recordings) {
            let is_missing = |design: &&DesignKey| self.stored.row(*key, design).is_none();
            let missing = self.designs.iter().filter(is_missing).count();
            status.pairs += self.designs.len();
            status.missing += missing;
            if missing == 0 {
                continue;
            }
            let share = self.shares.map(|of| Share::number_of(&recording.name, of));
            shares.extend(share);
            if status.missing_of.len() < NAMED_MAX {
                status.missing_of.push((recording.name.clone(), missing));
            }
            if self.stored.is_skipped(*key) && status.never_ended.len() < NAMED_MAX {
                status.never_ended.push(recording.name.clone());
            }
        }
        status.done = status.pairs - status.missing;
        status.shares = shares.into_iter().collect();
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

    /// Returns the decisions of each recording, in the plan's order, for [`super::hold`].
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

/// Returns the folder in which an engine's own output of a store is kept.
pub fn engine_folder(store: &Path) -> PathBuf {
    store.join("engine")
}
