//! Decisions that were made before, and those made now, kept for the next run.
//!
//! A store is a folder. Each process appends to one file of its own; nothing is rewritten, so that
//! several processes may share a store, on a network file system, too. A file is a sequence of
//! blocks: eight letters, the length of what follows, its SHA-256, and rows as compressed JSON.
//! A block that does not fit its checksum is left out and told; its rows are judged again.

use crate::error::{Error, ErrorKind, Place};
use crate::pipeline::Row;
use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// What a block begins with.
const MAGIC: &[u8; 8] = b"latchrow";

/// Bytes before a block's rows: letters, length, checksum.
const HEAD: usize = 8 + 4 + 32;

/// Longest block that is taken for one [bytes].
const BLOCK_MAX: usize = 64 << 20;

/// Most bytes of rows that a block may unfold to.
const ROWS_MAX: u64 = 512 << 20;

/// How the name of a store's file ends.
const ENDING: &str = "rows";

/// The mark of a folder that may be deleted and made again, after the Cache Directory Tagging
/// Specification.
const CACHE_TAG: &str = "Signature: 8a477f597d28d172789f06886806bc55\n\
# Decisions of latchgate gate. This folder may be deleted; they are then made again.\n";

/// Decisions by `report_id`.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    known: BTreeMap<String, Row>,
    /// Damages found on opening, one sentence each.
    damages: Vec<String>,
    /// The file of this process, made with the first block.
    file: Mutex<Option<File>>,
}

impl Store {
    /// Opens the store in a folder, which is made if absent, and reads the rows of which `wanted`
    /// approves.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if the folder cannot be made, listed or read.
    pub fn open(folder: &Path, wanted: impl Fn(&Row) -> bool) -> Result<Self, Error> {
        fs::create_dir_all(folder).map_err(|error| failed("make the store", folder, &error))?;
        let tag = folder.join("CACHEDIR.TAG");
        if !tag.exists() {
            fs::write(&tag, CACHE_TAG).map_err(|error| failed("write the store", &tag, &error))?;
        }
        let mut store = Self {
            folder: folder.into(),
            known: BTreeMap::new(),
            damages: Vec::new(),
            file: Mutex::new(None),
        };
        let listed =
            fs::read_dir(folder).map_err(|error| failed("list the store", folder, &error))?;
        let mut paths = BTreeSet::new();
        for entry in listed {
            let entry = entry.map_err(|error| failed("list the store", folder, &error))?;
            if entry.path().extension().is_some_and(|end| end == ENDING) {
                paths.insert(entry.path());
            }
        }
        for path in paths {
            store.read(&path, &wanted)?;
        }
        Ok(store)
    }

    /// Returns what was found damaged, one sentence each.
    #[must_use]
    pub fn damages(&self) -> &[String] {
        &self.damages
    }

    /// Returns the row of that `report_id`, if it was made before the store was opened.
    #[must_use]
    pub fn get(&self, report_id: &str) -> Option<&Row> {
        self.known.get(report_id)
    }

    /// Appends a block of rows and sees it onto the disk.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if it cannot be written.
    pub fn put(&self, rows: &[&Row]) -> Result<(), Error> {
        if rows.is_empty() {
            return Ok(());
        }
        let unwritable = |error: io::Error| failed("write the store", &self.folder, &error);
        let block = block_of(rows).map_err(unwritable)?;
        // A thread that panicked has not left half a block: it is written at once.
        let mut file = self.file.lock().unwrap_or_else(|held| held.into_inner());
        let own = match file.take() {
            Some(own) => own,
            None => self.own_file().map_err(unwritable)?,
        };
        let own = file.insert(own);
        own.write_all(&block)
            .and_then(|()| own.sync_data())
            .map_err(unwritable)
    }

    /// Makes a file that no other process has.
    fn own_file(&self) -> io::Result<File> {
        let process = std::process::id();
        let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        let host: String = host
            .trim()
            .chars()
            .filter(char::is_ascii_alphanumeric)
            .take(40)
            .collect();
        let mut number = 0_u32;
        loop {
            let path = self
                .folder
                .join(format!("{host}-{process}-{number}.{ENDING}"));
            match OpenOptions::new().append(true).create_new(true).open(path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
                other => return other,
            }
        }
    }

    fn read(&mut self, path: &Path, wanted: &impl Fn(&Row) -> bool) -> Result<(), Error> {
        let bytes = fs::read(path).map_err(|error| failed("read the store", path, &error))?;
        let file = path
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let (mut at, mut lost) = (0, None);
        while at < bytes.len() {
            match block_at(&bytes[at..]) {
                Some((rows, length)) => {
                    self.told(&file, lost.take(), at);
                    for row in rows {
                        if wanted(&row) {
                            self.known.insert(row.report_id.clone(), row);
                        }
                    }
                    at += length;
                }
                None => {
                    lost = lost.or(Some(at));
                    at += 1 + next_block(&bytes[at + 1..]);
                }
            }
        }
        self.told(&file, lost, bytes.len());
        Ok(())
    }

    fn told(&mut self, file: &str, lost: Option<usize>, end: usize) {
        if let Some(start) = lost {
            self.damages.push(format!(
                "{file}: bytes {start} to {end} are no block that fits its checksum; what they held \
                 is judged again"
            ));
        }
    }
}

/// Returns how far it is to the next place at which a block could begin.
fn next_block(bytes: &[u8]) -> usize {
    memchr::memmem::find(bytes, MAGIC).unwrap_or(bytes.len())
}

fn block_of(rows: &[&Row]) -> io::Result<Vec<u8>> {
    let mut packed = DeflateEncoder::new(Vec::new(), Compression::fast());
    serde_json::to_writer(&mut packed, rows)?;
    let packed = packed.finish()?;
    let length = u32::try_from(packed.len())
        .ok()
        .filter(|length| *length as usize <= BLOCK_MAX)
        .ok_or_else(|| io::Error::other("a block is too long"))?;
    let mut block = Vec::with_capacity(HEAD + packed.len());
    block.extend(MAGIC);
    block.extend(length.to_le_bytes());
    block.extend(checksum(&packed));
    block.extend(packed);
    Ok(block)
}

/// Reads the block at the beginning of `bytes`: its rows, and its length.
fn block_at(bytes: &[u8]) -> Option<(Vec<Row>, usize)> {
    let head = bytes.get(..HEAD)?;
    let (magic, rest) = head.split_at(MAGIC.len());
    let (length, sum) = rest.split_at(4);
    let length = u32::from_le_bytes(length.try_into().ok()?) as usize;
    let packed = bytes.get(HEAD..HEAD.checked_add(length)?)?;
    if magic != MAGIC || length > BLOCK_MAX || checksum(packed) != sum {
        return None;
    }
    let unpacked = DeflateDecoder::new(packed).take(ROWS_MAX);
    let rows = serde_json::from_reader(io::BufReader::new(unpacked)).ok()?;
    Some((rows, HEAD + length))
}

fn checksum(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}

fn failed(action: &'static str, path: &Path, error: &io::Error) -> Error {
    Error::from(ErrorKind::Io {
        action,
        reason: error.to_string(),
    })
    .at(Place::file(path.display().to_string()))
}
