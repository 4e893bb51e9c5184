//! The keys under which decisions are kept: of a recording with its settings, and of a design.
//!
//! A key is a hash of the raw bytes, without parsing: 100 000 recordings take the time that their
//! reading from disk takes. It covers every file that a reader may look at. A file too many costs
//! a second judgement; a file too few would return the decision of another recording.

use super::key::Key;
use super::plan::{Plan, PlannedRecording};
use super::store::{DesignKey, is_store};
use crate::pipeline::{Control, Design, Limits, NUMBERS_REVISION};
use latchgate_recording::error::Error;
use serde_json::json;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Bytes of a file that are read at once.
const READ_AT_ONCE: usize = 64 << 10;

/// Depth of folders that are listed, the same as that of readers.
const DEPTH_MAX: usize = 2;

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

/// Computes the keys of recordings. Each folder is listed once.
#[derive(Debug)]
pub(super) struct Questions {
    limits: BTreeMap<String, u64>,
    /// Largest number of files of a folder that readers look at.
    entries_max: u64,
    folders: Mutex<BTreeMap<PathBuf, Arc<Neighbours>>>,
}

/// Entries of a folder: names in lower case, in order, each with its path.
type Neighbours = Vec<(String, PathBuf)>;

impl Questions {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            limits: limits.changed(),
            entries_max: limits.archive_entries,
            folders: Mutex::default(),
        }
    }

    /// Returns the key of everything that determines an answer about the recording except the
    /// design: its files, their names, the settings, and the version. A file that cannot be read
    /// enters with its error.
    pub(super) fn key(&self, recording: &PlannedRecording) -> Key {
        let files = match recording.is_pulse() {
            true => Vec::new(),
            false => self.files(&recording.path),
        };
        let files: Vec<(String, String)> = files
            .iter()
            .map(|path| (below(path, recording.path.parent()), fingerprint(path)))
            .collect();
        let question = json!({
            "schema": "latchgate.store/1",
            "numbers_revision": NUMBERS_REVISION,
            // Another version may read a file that this one refuses.
            "version": env!("CARGO_PKG_VERSION"),
            "recording": match recording.is_pulse() {
                true => Some(recording.path.to_string_lossy()),
                false => recording.path.file_name().map(|name| name.to_string_lossy()),
            },
            "files": files,
            "request": &*recording.request,
            "limits": self.limits,
        });
        Key::of(question.to_string().as_bytes())
    }

    /// Lists the files that a reader may open: of a folder its contents; of a file all files beside
    /// it with its name, such as its card and its channels, also in a folder of channels.
    fn files(&self, path: &Path) -> Vec<PathBuf> {
        let mut files = vec![path.to_path_buf()];
        if path.is_dir() {
            list_folder(path, DEPTH_MAX, self.entries_max, &mut files);
        } else {
            let stem = path.file_stem().unwrap_or_default();
            let stem = stem.to_string_lossy().to_lowercase();
            let folder = path.parent().unwrap_or(Path::new(""));
            let neighbours = self.neighbours(folder);
            files.extend(with_stem(&neighbours, &stem));
            // ISO-MME tests keep their channels in a folder `Channel`.
            for (_, folder) in neighbours.iter().filter(|(name, _)| name == "channel") {
                files.extend(with_stem(&self.neighbours(folder), &stem));
            }
        }
        files.sort();
        files.dedup();
        files
    }

    fn neighbours(&self, folder: &Path) -> Arc<Neighbours> {
        // Poisoning is harmless: a list is inserted complete.
        let mut folders = self
            .folders
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        let listed = folders.entry(folder.into()).or_insert_with(|| {
            // The parent of a bare file name is the empty path, which cannot be listed.
            let is_empty = folder.as_os_str().is_empty();
            let place = if is_empty { Path::new(".") } else { folder };
            let entries = fs::read_dir(place).into_iter().flatten().flatten();
            let named = entries.map(|entry| {
                let name = entry.file_name();
                (name.to_string_lossy().to_lowercase(), folder.join(name))
            });
            let mut named: Neighbours = named.collect();
            named.sort();
            Arc::new(named)
        });
        Arc::clone(listed)
    }
}

/// Returns the entries of a stem: the stem alone, or before a character that is no letter or digit.
/// In the curves of an EV5 test as .tsv the number may follow the stem directly.
fn with_stem<'a>(neighbours: &'a Neighbours, stem: &'a str) -> impl Iterator<Item = PathBuf> + 'a {
    let start = neighbours.partition_point(|(name, _)| name.as_str() < stem);
    neighbours[start..]
        .iter()
        .map_while(move |(name, path)| Some((name.strip_prefix(stem)?, path)))
        .filter(|(suffix, _)| {
            !suffix.starts_with(char::is_alphanumeric) || suffix.ends_with(".tsv")
        })
        .map(|(_, path)| path.clone())
}

/// Lists the contents of a folder, about `entries_max` files and folders in all; a store in it is
/// not entered.
fn list_folder(folder: &Path, depth: usize, entries_max: u64, paths: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .collect();
    entries.sort();
    for path in entries {
        if paths.len() as u64 > entries_max {
            return;
        }
        // A store below a recording's folder grows with each decision; the key must not.
        let deeper = path.is_dir() && depth > 1 && !is_store(&path);
        paths.push(path.clone());
        if deeper {
            list_folder(&path, depth - 1, entries_max, paths);
        }
    }
}

/// Returns a path relative to a folder.
fn below(path: &Path, folder: Option<&Path>) -> String {
    let folder = folder.unwrap_or(Path::new(""));
    let path = path.strip_prefix(folder).unwrap_or(path);
    path.to_string_lossy().into_owned()
}

/// Returns the SHA-256 of a file, or the kind of anything else: a pipe may never end.
fn fingerprint(path: &Path) -> String {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => hash(path),
        Ok(metadata) if metadata.is_dir() => "folder".into(),
        Ok(_) => "no file".into(),
        Err(error) => format!("unread: {:?}", error.kind()),
    }
}

/// Returns the SHA-256 of a file, or the kind of the error.
fn hash(path: &Path) -> String {
    let hashed = || -> io::Result<String> {
        let mut file = File::open(path)?;
        let mut hash = Sha256::new();
        let mut bytes = vec![0; READ_AT_ONCE];
        loop {
            match file.read(&mut bytes)? {
                0 => break,
                read => hash.update(&bytes[..read]),
            }
        }
        Ok(hex(&hash.finalize()))
    };
    hashed().unwrap_or_else(|error| format!("unread: {:?}", error.kind()))
}

/// Returns the key of a design.
fn design_key(design: &Design) -> Key {
    Key::of(json!(design).to_string().as_bytes())
}

/// Writes bytes as lower-case hexadecimal digits.
fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
