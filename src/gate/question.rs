//! What decisions are kept under: the key of a recording's question, and that of a design.
//!
//! A key is worked out from the bytes as they lie there, unread: of 100 000 recordings in the time it
//! takes to read them. It covers whatever a reader may look at, rather too much than too little.

use super::key::Key;
use super::plan::PlannedRecording;
use super::store::is_store;
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

/// Folders within one another that are looked into, as deep as readers look.
const DEPTH_MAX: usize = 2;

/// Works out the keys of recordings, each folder listed once.
#[derive(Debug)]
pub(super) struct Questions {
    limits: BTreeMap<String, u64>,
    /// Most files of a folder that readers look at.
    entries_max: u64,
    folders: Mutex<BTreeMap<PathBuf, Arc<Neighbours>>>,
}

/// What a folder holds: names in lower case, in order, each with its path.
type Neighbours = Vec<(String, PathBuf)>;

impl Questions {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            limits: limits.changed(),
            entries_max: limits.archive_entries,
            folders: Mutex::default(),
        }
    }

    /// Returns the key of everything that an answer about the recording rests on but the design:
    /// its files, their names, the settings, and the version. A file that cannot be read is part of it
    /// as such.
    pub(super) fn key(&self, recording: &PlannedRecording) -> Key {
        let files = match recording.is_pulse() {
            true => Vec::new(),
            false => self.files(&recording.path),
        };
        let files = files.iter().map(|path| (path, told_of(path)));
        let files: Vec<(String, String)> = files
            .map(|(path, told)| (below(path, recording.path.parent()), told))
            .collect();
        let question = json!({
            "schema": "latchgate.store/1",
            "numbers_revision": NUMBERS_REVISION,
            // Another version may read what this one refuses.
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

    /// Lists what a recording may be read from: of a folder what it holds; of a file all beside it that
    /// bear its name, such as its card and its channels, also in a folder of channels.
    fn files(&self, path: &Path) -> Vec<PathBuf> {
        let mut found = vec![path.to_path_buf()];
        if path.is_dir() {
            all_in(path, DEPTH_MAX, self.entries_max, &mut found);
        } else {
            let stem = path.file_stem().unwrap_or_default();
            let stem = stem.to_string_lossy().to_lowercase();
            let folder = path.parent().unwrap_or(Path::new(""));
            let neighbours = self.neighbours(folder);
            found.extend(of_name(&neighbours, &stem));
            for channels in exactly(&neighbours, "channel") {
                found.extend(of_name(&self.neighbours(channels), &stem));
            }
        }
        found.sort();
        found.dedup();
        found
    }

    fn neighbours(&self, folder: &Path) -> Arc<Neighbours> {
        // A thread that panicked has not left half a list.
        let mut folders = self.folders.lock().unwrap_or_else(|held| held.into_inner());
        let listed = folders.entry(folder.into()).or_insert_with(|| {
            let here = folder.as_os_str().is_empty();
            let place = if here { Path::new(".") } else { folder };
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

/// Returns what bears a name: the name itself, or the name before a sign that is no letter or digit; of an EV5
/// test's curves as .tsv the number may follow at once.
fn of_name<'a>(neighbours: &'a Neighbours, stem: &'a str) -> impl Iterator<Item = PathBuf> + 'a {
    let from = neighbours.partition_point(|(name, _)| name.as_str() < stem);
    let alike = neighbours[from..].iter().map_while(move |(name, path)| {
        let rest = name.strip_prefix(stem)?;
        Some((rest, path))
    });
    let bears = |rest: &str| !rest.starts_with(char::is_alphanumeric) || rest.ends_with(".tsv");
    alike
        .filter(move |(rest, _)| bears(rest))
        .map(|(_, path)| path.clone())
}

/// Returns what has that name in lower case, of which there may be several.
fn exactly<'a>(neighbours: &'a Neighbours, name: &'a str) -> impl Iterator<Item = &'a PathBuf> {
    let alike = neighbours.iter().filter(move |(own, _)| own == name);
    alike.map(|(_, path)| path)
}

/// Lists what is in a folder, at most `most` files and folders in all; a store of decisions is passed over.
fn all_in(folder: &Path, depth: usize, most: u64, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .collect();
    entries.sort();
    for path in entries {
        if found.len() as u64 > most {
            return;
        }
        let deeper = path.is_dir() && depth > 1 && !is_store(&path);
        found.push(path.clone());
        if deeper {
            all_in(&path, depth - 1, most, found);
        }
    }
}

/// Returns a path as it is told of below a folder.
fn below(path: &Path, folder: Option<&Path>) -> String {
    let folder = folder.unwrap_or(Path::new(""));
    let path = path.strip_prefix(folder).unwrap_or(path);
    path.to_string_lossy().into_owned()
}

/// Returns the SHA-256 of a file; of anything else what it is, for a pipe may have no end.
fn told_of(path: &Path) -> String {
    match fs::metadata(path) {
        Ok(about) if about.is_file() => hash(path),
        Ok(about) if about.is_dir() => "folder".into(),
        Ok(_) => "no file".into(),
        Err(error) => format!("unread: {:?}", error.kind()),
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
