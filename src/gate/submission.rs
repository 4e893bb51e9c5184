//! The recordings and designs of a sweep as submitted, so that every share judges exactly these.

use super::key::Key;
use super::plan::Plan;
use super::question::{Questions, design_key, hex};
use super::store::{self, DesignKey, put_in_place};
use crate::pipeline::{Control, Design, Limits, NUMBERS_REVISION};
use latchgate_recording::error::{Error, Place};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The recordings and designs of a sweep by name, with the keys of what they were.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Submission {
    /// Number of shares.
    pub shares: u32,
    numbers_revision: u32,
    version: String,
    designs: BTreeMap<String, Key>,
    recordings: BTreeMap<String, Key>,
}

impl Plan {
    /// Returns the keys of the designs, in order.
    pub(super) fn design_keys(&self) -> Vec<DesignKey> {
        let key = |design: &Design| DesignKey {
            key: design_key(design),
            threshold_rad: design.criterion.threshold_rad,
        };
        self.designs.iter().map(key).collect()
    }

    /// Returns the keys of the recordings, in order.
    ///
    /// # Errors
    ///
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work.
    pub(super) fn recording_keys(
        &self,
        limits: &Limits,
        control: &Control<'_>,
    ) -> Result<Vec<Key>, Error> {
        let questions = Questions::new(limits);
        control.try_map(&self.recordings, |recording| Ok(questions.key(recording)))
    }
}

impl Submission {
    /// Records the designs and recordings of a plan as they are now.
    ///
    /// # Errors
    ///
    /// [`Stopped`](latchgate_kernel::error::Error::Stopped) if `control` ends the work.
    pub fn of(
        plan: &Plan,
        shares: u32,
        limits: &Limits,
        control: &Control<'_>,
    ) -> Result<Self, Error> {
        let keys = plan.recording_keys(limits, control)?;
        let recordings = plan.recordings.iter().zip(keys);
        Ok(Self {
            shares,
            numbers_revision: NUMBERS_REVISION,
            version: env!("CARGO_PKG_VERSION").into(),
            designs: plan.designs.iter().map(named_design).collect(),
            recordings: recordings
                .map(|(recording, key)| (recording.name.clone(), key))
                .collect(),
        })
    }

    /// Returns an identifier: the first eight bytes of its SHA-256 in hexadecimal digits.
    pub fn id(&self) -> String {
        let text = serde_json::to_vec(self).unwrap_or_default();
        hex(&Sha256::digest(&text)[..8])
    }

    /// Returns the key of a recording as it was submitted.
    pub(super) fn recording(&self, name: &str) -> Option<Key> {
        self.recordings.get(name).copied()
    }

    /// Refuses a plan of other designs or recordings, and another version or revision of the numbers.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Malformed`] that names what differs.
    pub fn check(&self, plan: &Plan) -> Result<(), Error> {
        let hint = "submit the sweep again";
        let differs = |expected: String, found: &str| {
            Err(Error::malformed(&expected, found, hint).at(Place::file(plan.gate.clone())))
        };
        if self.numbers_revision != NUMBERS_REVISION {
            let expected = format!("numbers of revision {}", self.numbers_revision);
            return differs(expected, &format!("those of revision {NUMBERS_REVISION}"));
        }
        if self.version != env!("CARGO_PKG_VERSION") {
            let expected = format!("latchgate {}", self.version);
            return differs(expected, env!("CARGO_PKG_VERSION"));
        }
        let designs: BTreeMap<String, Key> = plan.designs.iter().map(named_design).collect();
        for name in designs.keys().chain(self.designs.keys()) {
            let difference = match (designs.get(name), self.designs.get(name)) {
                (Some(now), Some(submitted)) if now == submitted => continue,
                (Some(_), Some(_)) => "another one of that name",
                (Some(_), None) => "it was not submitted",
                (None, _) => "it is gone",
            };
            return differs(format!("design `{name}` as it was submitted"), difference);
        }
        let recordings = plan.recordings.iter();
        let names: Vec<&String> = recordings.map(|recording| &recording.name).collect();
        if let Some(new) = names
            .iter()
            .find(|name| !self.recordings.contains_key(**name))
        {
            let expected = format!("the recordings that were submitted, without `{new}`");
            return differs(expected, "it among them");
        }
        // A plan has its recordings in the order of their names.
        let gone = |name: &&String| names.binary_search(name).is_err();
        if let Some(gone) = self.recordings.keys().find(gone) {
            return differs(
                format!("the recording `{gone}` as it was submitted"),
                "none",
            );
        }
        Ok(())
    }

    /// Returns where the submission of a gate lies in a store.
    fn path(folder: &Path, gate: &str) -> PathBuf {
        folder.join(format!("{gate}.submission.json"))
    }

    /// Keeps it in the store, in place of an earlier one of the gate.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written.
    pub fn keep(&self, folder: &Path, gate: &str) -> Result<(), Error> {
        store::make(folder)?;
        let path = Self::path(folder, gate);
        serde_json::to_vec(self)
            .map_err(Into::into)
            .and_then(|text| put_in_place(&path, &text))
            .map_err(|error| Error::io_at("write the store", &path, &error))
    }

    /// Reads the last submission of a gate from a store, if there is one.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be read or is none.
    pub fn read(folder: &Path, gate: &str) -> Result<Option<Self>, Error> {
        let path = Self::path(folder, gate);
        match fs::read(&path) {
            Ok(text) => serde_json::from_slice(&text)
                .map(Some)
                .map_err(|error| Error::io_at("read the submission", &path, &error)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Error::io_at("read the submission", &path, &error)),
        }
    }

    /// Reads the submission of that [`Self::id`].
    ///
    /// # Errors
    ///
    /// As [`Self::read`]; [`latchgate_recording::error::ErrorKind::Malformed`] if it is another one, or none is there.
    pub fn read_as(folder: &Path, gate: &str, id: &str) -> Result<Self, Error> {
        match Self::read(folder, gate)? {
            Some(submission) if submission.id() == id => Ok(submission),
            later => {
                let found = later.map_or("none".into(), |later| later.id());
                let hint = "the sweep was submitted again since; let the newer tasks run";
                let error = Error::malformed(format!("the submission {id}"), &found, hint);
                Err(error.at(Place::file(Self::path(folder, gate).display().to_string())))
            }
        }
    }
}

fn named_design(design: &Design) -> (String, Key) {
    (design.name.clone(), design_key(design))
}
