//! What a store holds of a gate's shares: what is done and missing, and all of it as decisions.

use super::key::Key;
use super::plan::Plan;
use super::run::JudgedRecording;
use super::share::Share;
use super::share_task::ShareDone;
use super::store::{self, DesignKey, Known};
use super::submission::Submission;
use crate::pipeline::{Control, Limits};
use latchgate_recording::error::{Error, Place};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Most recordings that are named.
const NAMED_MAX: usize = 1000;

/// What stands where of the shares of a gate.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Standing {
    /// All pairs.
    pub pairs: usize,
    /// Pairs that were judged.
    pub done: usize,
    /// Pairs that are not in the store.
    pub missing: usize,
    /// Recordings with the number of their pairs that are missing, a thousand at most.
    pub missing_of: Vec<(String, usize)>,
    /// Those of them that shares pass over, since they were begun twice and never ended; a thousand at most.
    pub never_ended: Vec<String>,
    /// Numbers of the shares of which something is missing; none where it is not known how many
    /// shares there are.
    pub shares: Vec<u32>,
}

/// A gate and the store of its shares.
#[derive(Debug)]
pub struct Collection<'a> {
    plan: &'a Plan,
    shares: Option<u32>,
    /// Files of shares that are said to be finished, with their bytes.
    finished: BTreeMap<String, u64>,
    recordings: Vec<Key>,
    designs: Vec<DesignKey>,
    known: Known,
}

impl<'a> Collection<'a> {
    /// Looks through a store for the pairs of a plan: as they were submitted, or else as they lie
    /// there now.
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
                let names = plan.recordings.iter().map(|own| &own.name);
                names
                    .filter_map(|name| submission.recording(name))
                    .collect()
            }
            None => plan.recording_keys(limits, control)?,
        };
        let shares = submission.map(|submission| submission.shares);
        let of = shares.unwrap_or(0);
        let mut finished = BTreeMap::new();
        for number in 1..=of {
            for (name, length) in ShareDone::read(folder, Share { number, of }).files {
                let known: &mut u64 = finished.entry(name).or_default();
                *known = length.max(*known);
            }
        }
        let mut paths: BTreeSet<PathBuf> = store::files(folder)?.into_iter().collect();
        // A shared file system may list a file late that it opens.
        let named = finished.keys().map(|name| folder.join(name));
        paths.extend(named.filter(|path| path.is_file()));
        let paths: Vec<PathBuf> = paths.into_iter().collect();
        let mut known = Known::read(&paths, recordings.iter().copied(), None)?;
        // Nothing is read here that would tell which of several decisions holds.
        known.contradict_doubles();
        plan.check_agreement(recordings.iter().copied().enumerate(), &known)?;
        Ok(Self {
            plan,
            shares,
            finished,
            recordings,
            designs: plan.design_keys(),
            known,
        })
    }

    /// Sees to it that the recordings are still what the collection is of.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] that names one that is not,
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped).
    pub fn check_unchanged(&self, limits: &Limits, control: &Control<'_>) -> Result<(), Error> {
        if self.shares.is_none() {
            // They were read just now.
            return Ok(());
        }
        let now = self.plan.recording_keys(limits, control)?;
        let changed = now
            .iter()
            .zip(&self.recordings)
            .position(|(now, then)| now != then);
        if now.len() == self.recordings.len() && changed.is_none() {
            return Ok(());
        }
        let name = changed.map_or("", |number| self.plan.recordings[number].name.as_str());
        let expected = "the recording as it was submitted and judged";
        let error = Error::malformed(expected, "another one", "submit the shares again");
        Err(error.at(Place::file(name)))
    }

    /// Returns what is damaged in the store, one sentence each.
    pub fn damages(&self) -> &[String] {
        &self.known.damages
    }

    /// Returns what stands where.
    pub fn standing(&self) -> Standing {
        let mut standing = Standing::default();
        let mut shares = BTreeSet::new();
        for (recording, key) in self.plan.recordings.iter().zip(&self.recordings) {
            let is_missing = |design: &&DesignKey| self.known.row(*key, design).is_none();
            let missing = self.designs.iter().filter(is_missing).count();
            standing.pairs += self.designs.len();
            standing.missing += missing;
            if missing == 0 {
                continue;
            }
            let share = self.shares.map(|of| Share::number_of(&recording.name, of));
            shares.extend(share);
            if standing.missing_of.len() < NAMED_MAX {
                standing.missing_of.push((recording.name.clone(), missing));
            }
            if self.known.is_left(*key) && standing.never_ended.len() < NAMED_MAX {
                standing.never_ended.push(recording.name.clone());
            }
        }
        standing.done = standing.pairs - standing.missing;
        standing.shares = shares.into_iter().collect();
        standing
    }

    /// Returns the files of shares that are said to be finished and that are not there yet, or are
    /// too short: a shared file system may show them late.
    pub fn late(&self) -> Vec<String> {
        let late = self.finished.iter().filter(|(name, length)| {
            let read = self.known.files.get(*name).copied().unwrap_or(0);
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
                .filter_map(|design| self.known.row(*key, design));
            let read = self.known.facts(*key).cloned().unwrap_or_default();
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
