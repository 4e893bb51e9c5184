//! What decisions are kept under: the key of a recording's question, and that of a design.
//!
//! A key is worked out from the bytes as they lie there, unread: of 100 000 recordings in the time it
//! takes to read them.

use super::key::Key;
use super::plan::PlannedRecording;
use crate::pipeline::{Design, Limits, NUMBERS_REVISION};
use serde_json::json;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Bytes of a file that are read at once.
const READ_AT_ONCE: usize = 64 << 10;

/// Folders within one another that are looked into.
const DEPTH_MAX: usize = 8;

/// Works out the keys of recordings, each folder listed once.
#[derive(Debug)]
pub(super) struct Questions {
    limits: BTreeMap<String, u64>,
    folders: Mutex<BTreeMap<PathBuf, Arc<Neighbours>>>,
}

/// Files of a folder by their name in lower case.
type Neighbours = BTreeMap<String, PathBuf>;

impl Questions {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            limits: limits.changed(),
            folders: Mutex::default(),
        }
    }

    /// Returns the key of everything that an answer about the recording rests on but the design:
    /// its files, their names, the settings, and the version. A file that cannot be read is part of it
    /// as such.
    pub(super) fn key(&self, recording: &PlannedRecording) -> Key {
        let files: Vec<(String, String)> = self
            .files(&recording.path)
            .into_iter()
            .map(|(name, path)| (name, hash(&path)))
            .collect();
        let question = json!({
            "schema": "latchgate.store/1",
            "numbers_revision": NUMBERS_REVISION,
            // Another version may read what this one refuses.
            "version": env!("CARGO_PKG_VERSION"),
            "files": files,
            "request": &*recording.request,
            "limits": self.limits,
        });
        Key::of(question.to_string().as_bytes())
    }

    /// Lists what a recording may be read from: of a folder what it holds; of a file all that bear its
    /// name with another ending, such as its card, and channels in the folder of that name.
    fn files(&self, path: &Path) -> Vec<(String, PathBuf)> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let mut found = vec![(name.to_string(), path.to_path_buf())];
        let folder = path.parent().unwrap_or(Path::new(""));
        let neighbours = self.neighbours(folder);
        let stem = Path::new(&*name).file_stem().unwrap_or_default();
        let stem = format!("{}.", stem.to_string_lossy().to_lowercase());
        for start in [stem.clone(), format!("{}.", name.to_lowercase())] {
            let alike = neighbours.range(start.clone()..);
            let alike = alike.take_while(|(name, _)| name.starts_with(&start));
            found.extend(alike.map(|(name, path)| (name.clone(), path.clone())));
        }
        if path.is_dir() {
            below(path, "", DEPTH_MAX, &mut found);
        } else if let Some(channels) = neighbours.get("channel") {
            let mut all = Vec::new();
            below(channels, "channel", 1, &mut all);
            all.retain(|(name, _)| name.to_lowercase().starts_with(&format!("channel/{stem}")));
            found.extend(all);
        }
        found.sort();
        found.dedup();
        found.retain(|(_, path)| !path.is_dir());
        found
    }

    fn neighbours(&self, folder: &Path) -> Arc<Neighbours> {
        // A thread that panicked has not left half a list.
        let mut folders = self.folders.lock().unwrap_or_else(|held| held.into_inner());
        let listed = folders.entry(folder.into()).or_insert_with(|| {
            let place = if folder.as_os_str().is_empty() {
                Path::new(".")
            } else {
                folder
            };
            let entries = fs::read_dir(place).into_iter().flatten().flatten();
            let named = entries.map(|entry| {
                let name = entry.file_name();
                (name.to_string_lossy().to_lowercase(), folder.join(name))
            });
            Arc::new(named.collect())
        });
        Arc::clone(listed)
    }
}

/// Lists the files below a folder, but those of hidden folders, where stores are.
fn below(folder: &Path, prefix: &str, depth: usize, found: &mut Vec<(String, PathBuf)>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = format!("{prefix}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            if depth > 1 && !entry.file_name().to_string_lossy().starts_with('.') {
                below(&entry.path(), &name, depth - 1, found);
            }
        } else {
            found.push((name, entry.path()));
        }
    }
}

/// Returns the SHA-256 of a file, or why there is none.
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
pub(super) fn design_key(design: &Design) -> Key {
    Key::of(json!(design).to_string().as_bytes())
}

/// Writes bytes as lower-case hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
