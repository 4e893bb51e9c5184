//! What a store holds of a sweep: what is done, given up and missing, and all of it as one summary.

use super::block::Key;
use super::columns::Columns;
use super::index::{KnownDesigns, PlaceOfRow, Share, StoreIndex, name_of};
use super::pairs::WHOLE_MAX;
use super::plan::Plan;
use super::rule::{Asked, HeldRecording, hold_each};
use super::run::JudgedRecording;
use super::share::ShareDone;
use super::store::{self, BlockRows, RowAddress, Store};
use super::submission::Submission;
use super::summary::GateSummary;
use crate::pipeline::{Control, Limits};
use latchgate_recording::error::{Error, Place};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most recordings that are named as missing.
const NAMED_MAX: usize = 1000;

/// What stands where of a sweep.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Standing {
    /// All pairs.
    pub pairs: usize,
    /// Pairs that were judged.
    pub done: usize,
    /// Pairs that were given up, since their recording ended its process too often.
    pub given_up: usize,
    /// Pairs that are not in the store.
    pub missing: usize,
    /// Recordings with the number of their pairs that are missing, a thousand at most.
    pub missing_of: Vec<(String, usize)>,
    /// Recordings that were given up, a thousand at most.
    pub given_up_of: Vec<String>,
    /// Numbers of the shares of which something is missing; none where it is not known how many
    /// shares there are.
    pub shares: Vec<u32>,
}

/// A sweep and the store of its shares.
#[derive(Debug)]
pub struct Collection<'a> {
    plan: &'a Plan,
    shares: Option<u32>,
    /// Files of shares that are said to be finished, with their bytes.
    finished: BTreeMap<String, u64>,
    keys: Vec<Key>,
    designs: KnownDesigns,
    index: StoreIndex,
}

impl<'a> Collection<'a> {
    /// Looks through a store for the pairs of a plan: as they were submitted, or else as they lie
    /// there now. `whole` sees to it that every block fits its checksum.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] if the plan is no longer the one that was submitted,
    /// [`latchgate_recording::error::ErrorKind::Io`] if the store cannot be read,
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped).
    pub fn of(
        plan: &'a Plan,
        folder: &'a Path,
        submission: Option<&Submission>,
        limits: &Limits,
        whole: bool,
        control: &Control<'_>,
    ) -> Result<Self, Error> {
        store::make(folder)?;
        let keys = match submission {
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
        paths.extend(named.filter(|path| finished.contains_key(&name_of(path)) && path.is_file()));
        Ok(Self {
            plan,
            shares,
            finished,
            keys,
            designs: KnownDesigns::new(plan.design_keys()),
            index: StoreIndex::open(folder, paths.into_iter().collect(), None, whole)?,
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
            .zip(&self.keys)
            .position(|(now, then)| now != then);
        if now.len() == self.keys.len() && changed.is_none() {
            return Ok(());
        }
        let name = changed.map_or("", |number| self.plan.recordings[number].name.as_str());
        let expected = "the recording as it was submitted and judged";
        let error = Error::malformed(expected, "another one", "submit the shares again");
        Err(error.at(Place::file(name)))
    }

    /// Returns what is damaged in the store, one sentence each.
    pub fn damages(&self) -> &[String] {
        &self.index.damages
    }

    /// Returns what stands where.
    pub fn standing(&mut self) -> Standing {
        let mut standing = Standing::default();
        let mut shares = std::collections::BTreeSet::new();
        for (recording, key) in self.plan.recordings.iter().zip(&self.keys) {
            let places = self.index.known(*key, &mut self.designs);
            let missing = places.iter().filter(|place| place.is_none()).count();
            let is_given_up = |place: &&PlaceOfRow| self.index.is_given_up(place.0);
            let given_up = places.iter().flatten().filter(is_given_up).count();
            standing.pairs += places.len();
            standing.missing += missing;
            standing.given_up += given_up;
            standing.done += places.len() - missing - given_up;
            if missing > 0 {
                let of = self.shares.map(|of| Share::number_of(&recording.name, of));
                shares.extend(of);
                if standing.missing_of.len() < NAMED_MAX {
                    standing.missing_of.push((recording.name.clone(), missing));
                }
            }
            if given_up > 0 && standing.given_up_of.len() < NAMED_MAX {
                standing.given_up_of.push(recording.name.clone());
            }
        }
        standing.shares = shares.into_iter().collect();
        standing
    }

    /// Returns the files of shares that are said to be finished and that are not there yet, or are
    /// too short: a shared file system may show them late.
    pub fn late(&self) -> Vec<String> {
        let names = self.index.files.iter().map(|path| name_of(path));
        let read: BTreeMap<String, u64> = names.zip(self.index.lengths.iter().copied()).collect();
        let late = self.finished.iter().filter(|(name, length)| {
            let read = read.get(*name).copied().unwrap_or(0);
            read < **length
        });
        late.map(|(name, _)| name.clone()).collect()
    }

    /// Reads every decision once, recording by recording, and holds it against what is required.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] if a pair is missing or its block damaged,
    /// [`latchgate_recording::error::ErrorKind::Io`] if a column cannot be written.
    pub fn summary(
        mut self,
        asked: Asked<'_>,
        mut columns: Option<&mut Columns>,
    ) -> Result<GateSummary, Error> {
        let plan = self.plan;
        let store = self.store();
        hold_each(plan, &store.clone(), asked, WHOLE_MAX, |number| {
            let held = self.held(number, &store)?;
            if let Some(columns) = &mut columns {
                held.rows.iter().try_for_each(|(_, row)| columns.add(row))?;
            }
            Ok(held)
        })
    }

    /// Returns where the decisions of each recording lie, in the plan's order, for [`super::hold`].
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] if a pair is missing or its block damaged.
    pub fn judged(mut self) -> Result<(Arc<Store>, Vec<JudgedRecording>), Error> {
        let store = self.store();
        let numbers = 0..self.plan.recordings.len();
        let judged = numbers.map(|number| {
            let held = self.held(number, &store)?;
            Ok(JudgedRecording {
                sha256: held.sha256,
                channel: held.channel,
                cached: held.rows.len(),
                times: Vec::new(),
                rows: held.rows.into_iter().map(|(address, _)| address).collect(),
            })
        });
        let judged = judged.collect::<Result<Vec<_>, Error>>()?;
        Ok((store, judged))
    }

    fn store(&self) -> Arc<Store> {
        let blocks = self.index.blocks.iter();
        let blocks = blocks.map(|block| (block.file, block.offset));
        Arc::new(Store::of_blocks(self.index.files.clone(), blocks))
    }

    /// Reads the decisions of a recording. A block that is damaged is as good as none: where the
    /// share was judged again since, another one holds what it held.
    fn held(&mut self, number: usize, store: &Store) -> Result<HeldRecording, Error> {
        let mut blocks = BTreeMap::new();
        let places = loop {
            let places = self.index.known(self.keys[number], &mut self.designs);
            let read = places.iter().flatten().map(|place| place.0);
            let unread = read.filter(|block| !blocks.contains_key(block)).min();
            let Some(block) = unread else {
                break places;
            };
            match store.block(block as u32) {
                Ok(body) => drop(blocks.insert(block, body)),
                Err(_) => self.index.forget(block),
            }
        };
        let mut held = HeldRecording::default();
        for place in places {
            let found = place.and_then(|(block, index)| {
                let body: &BlockRows = blocks.get(&block)?;
                let address = RowAddress {
                    block: block as u32,
                    index,
                };
                Some((body, address, body.rows.get(index as usize)?.clone()))
            });
            let Some((body, address, row)) = found else {
                let error = Error::malformed(
                    "a decision for every design",
                    "a damaged block in the store, and no other that holds what it held",
                    "let its share be judged again",
                );
                let name = self.plan.recordings[number].name.clone();
                return Err(error.at(Place::file(name)));
            };
            if held.sha256.is_none() {
                held.sha256.clone_from(&body.sha256);
                held.channel.clone_from(&body.channel);
            }
            held.rows.push((address, row));
        }
        Ok(held)
    }
}

/// Returns the folder in which an engine's own output of a store is kept.
pub fn engine_folder(store: &Path) -> PathBuf {
    store.join("engine")
}
