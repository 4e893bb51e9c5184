//! Decisions that were made before, and those made now, kept for the next run.
//!
//! A store is a folder. Each process appends to one file of its own; nothing is rewritten, so that
//! several processes may share a store, on a network file system, too. A file is a sequence of
//! blocks. A block that does not fit its checksum is left out and told; its rows are judged again.
//!
//! In memory stands only where each row lies, so that a gate of very many pairs takes little more
//! than one of few. Rows that are not to be kept (nothing could be read, or no store is wished) are
//! put aside as blocks in memory.

use super::block::{self, BlockHead, BlockKind, BlockOf, Key};
use crate::pipeline::DecisionRow;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

/// Name of the store's folder, where nobody names another.
pub const FOLDER: &str = ".latchgate";

/// How the name of a store's file ends.
pub(super) const ENDING: &str = "rows";

/// The mark of a folder that may be deleted and made again, after the Cache Directory Tagging
/// Specification.
const CACHE_TAG: &str = "Signature: 8a477f597d28d172789f06886806bc55\n\
# Decisions of latchgate gate. This folder may be deleted; they are then made again.\n";

/// What a block of decisions holds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct BlockRows {
    /// SHA-256 of the recording, where it was read.
    pub(super) sha256: Option<String>,
    /// The channel that was judged.
    pub(super) channel: Option<String>,
    pub(super) rows: Vec<DecisionRow>,
}

impl BlockRows {
    /// Returns rows of which it is not known here what they are of.
    fn plain(rows: &[DecisionRow]) -> Self {
        Self {
            rows: rows.to_vec(),
            ..Self::default()
        }
    }
}

/// Decisions by `report_id`.
#[derive(Debug)]
pub struct Store {
    /// `None` where nothing is to be kept.
    folder: Option<PathBuf>,
    /// What the name of this process's file says beside the process.
    label: String,
    /// The first half of each `report_id` that was kept before, and where its row lies, in order.
    index: Vec<(IdKey, RowAddress)>,
    /// Damages found on opening, one sentence each.
    damages: Vec<String>,
    blocks: Mutex<Blocks>,
}

/// Where a row lies: the number of its block, and its place in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct RowAddress {
    pub(super) block: u32,
    pub(super) index: u32,
}

/// Where the blocks lie.
#[derive(Debug, Default)]
struct Blocks {
    files: Vec<PathBuf>,
    places: Vec<BlockPlace>,
    /// The file of this process, made with the first block.
    own: Option<OwnFile>,
    /// Blocks that are not kept.
    aside: Vec<u8>,
}

/// The file that this process appends to.
#[derive(Debug)]
struct OwnFile {
    file: File,
    number: u32,
    length: u64,
    /// Where the notes begin that no rows follow.
    notes_from: u64,
}

#[derive(Debug, Clone, Copy)]
struct BlockPlace {
    /// Number of the file; `None`: aside.
    file: Option<u32>,
    offset: u64,
}

impl Store {
    /// Returns a store that keeps nothing beyond the process.
    pub fn unkept() -> Self {
        Self {
            folder: None,
            label: String::new(),
            index: Vec::new(),
            damages: Vec::new(),
            blocks: Mutex::default(),
        }
    }

    /// Opens the store in a folder, which is made if absent.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if the folder cannot be made, listed or read.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        make(folder)?;
        let paths = files(folder)?;
        let mut store = Self {
            folder: Some(folder.into()),
            ..Self::unkept()
        };
        for path in paths {
            store
                .list(&path)
                .map_err(|error| Error::io_at("read the store", &path, &error))?;
        }
        // Of two rows of one question either is as good as the other.
        store.index.sort_unstable();
        store.index.dedup_by_key(|(key, _)| *key);
        Ok(store)
    }

    /// Returns a store of which nothing is read beforehand; the name of this process's file ends with
    /// `label`.
    pub(super) fn beside(folder: &Path, label: &str) -> Self {
        Self {
            folder: Some(folder.into()),
            label: label.into(),
            ..Self::unkept()
        }
    }

    /// Returns a store of blocks that are known to be there, each by the number of its file and where
    /// it begins.
    pub(super) fn of_blocks(files: Vec<PathBuf>, blocks: impl Iterator<Item = (u32, u64)>) -> Self {
        let places = blocks.map(|(file, offset)| BlockPlace {
            file: Some(file),
            offset,
        });
        Self {
            blocks: Mutex::new(Blocks {
                files,
                places: places.collect(),
                ..Blocks::default()
            }),
            ..Self::unkept()
        }
    }

    /// Returns the file of this process, once it has one, and the bytes in it.
    pub(super) fn own_file(&self) -> Option<(PathBuf, u64)> {
        let blocks = self.blocks();
        let own = blocks.own.as_ref()?;
        Some((blocks.files[own.number as usize].clone(), own.length))
    }

    /// Sees what this process appended onto the disk.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if that fails.
    pub(super) fn sync(&self) -> Result<(), Error> {
        match (&self.blocks().own, &self.folder) {
            (Some(own), Some(folder)) => own
                .file
                .sync_data()
                .map_err(|error| Error::io_at("write the store", folder, &error)),
            _ => Ok(()),
        }
    }

    /// Returns what was found damaged, one sentence each.
    pub fn damages(&self) -> &[String] {
        &self.damages
    }

    /// Returns where the row of that `report_id` lies, if it was kept before the store was opened.
    pub fn find(&self, report_id: &str) -> Option<RowAddress> {
        let key = key_of(report_id)?;
        let found = self.index.binary_search_by_key(&key, |(key, _)| *key);
        found.ok().map(|at| self.index[at].1)
    }

    /// Appends a block of rows and sees it onto the disk; returns where they lie.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written.
    pub fn put(&self, rows: &[DecisionRow]) -> Result<Vec<RowAddress>, Error> {
        if self.folder.is_none() {
            return self.put_aside(rows);
        }
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        let of = BlockOf {
            count: rows.len() as u32,
            ..BlockOf::note(BlockKind::Rows, Key::default())
        };
        let addresses = self.append(of, &BlockRows::plain(rows))?;
        self.sync()?;
        Ok(addresses)
    }

    /// Appends a block to the file of this process, which a kill of the process does not take away;
    /// returns where its rows lie.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written; what was written of it is taken
    /// back where possible.
    pub(super) fn append(
        &self,
        of: BlockOf,
        body: &impl Serialize,
    ) -> Result<Vec<RowAddress>, Error> {
        let folder = self.folder.as_deref().unwrap_or(Path::new(""));
        let unwritable = |error: io::Error| Error::io_at("write the store", folder, &error);
        let block = block::encode(of, body).map_err(unwritable)?;
        let mut blocks = self.blocks();
        if blocks.own.is_none() {
            let (file, path) = own_file(folder, &self.label).map_err(unwritable)?;
            blocks.files.push(path);
            blocks.own = Some(OwnFile {
                file,
                number: blocks.files.len() as u32 - 1,
                length: 0,
                notes_from: 0,
            });
        }
        let Some(own) = blocks.own.as_mut() else {
            return Err(unwritable(gone()));
        };
        if let Err(error) = own.file.write_all(&block) {
            // A full disk leaves half a block, and a note that something is begun which nothing ends.
            let _ = own.file.set_len(own.notes_from);
            own.length = own.notes_from;
            return Err(unwritable(error));
        }
        let place = BlockPlace {
            file: Some(own.number),
            offset: own.length,
        };
        own.length += block.len() as u64;
        if of.count > 0 {
            own.notes_from = own.length;
        }
        Ok(blocks.added(place, of.count as usize))
    }

    /// Puts rows aside that are not to be kept; returns where they lie.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if they are too many for a block.
    pub fn put_aside(&self, rows: &[DecisionRow]) -> Result<Vec<RowAddress>, Error> {
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        let of = BlockOf {
            count: rows.len() as u32,
            ..BlockOf::note(BlockKind::Rows, Key::default())
        };
        let block = block::encode(of, &BlockRows::plain(rows)).map_err(unkept)?;
        let mut blocks = self.blocks();
        let place = BlockPlace {
            file: None,
            offset: blocks.aside.len() as u64,
        };
        blocks.aside.extend(block);
        Ok(blocks.added(place, rows.len()))
    }

    /// Reads rows; each block of which several are asked in a sequence is read once for them.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if a block is no longer there, or no longer fits its
    /// checksum.
    pub fn rows(&self, addresses: &[RowAddress]) -> Result<Vec<DecisionRow>, Error> {
        let mut found = Vec::with_capacity(addresses.len());
        for of_block in addresses.chunk_by(|a, b| a.block == b.block) {
            let rows = self.block(of_block[0].block)?.rows;
            for address in of_block {
                let row = rows.get(address.index as usize).cloned();
                found.push(row.ok_or_else(|| unkept(gone()))?);
            }
        }
        Ok(found)
    }

    /// Reads the block of that number.
    ///
    /// # Errors
    ///
    /// As [`Self::rows`].
    pub(super) fn block(&self, number: u32) -> Result<BlockRows, Error> {
        let blocks = self.blocks();
        let Some(place) = blocks.places.get(number as usize).copied() else {
            return Err(unkept(gone()));
        };
        let Some(file) = place.file else {
            let mut aside = io::Cursor::new(&blocks.aside);
            return rows_at(&mut aside, place.offset).map_err(unkept);
        };
        let path = blocks.files[file as usize].clone();
        drop(blocks);
        File::open(&path)
            .and_then(|mut file| rows_at(&mut file, place.offset))
            .map_err(|error| Error::io_at("read the store again", &path, &error))
    }

    fn blocks(&self) -> MutexGuard<'_, Blocks> {
        // A thread that panicked has not left half a block: it is entered after it is written.
        self.blocks.lock().unwrap_or_else(|held| held.into_inner())
    }

    /// Enters the rows of a file.
    fn list(&mut self, path: &Path) -> io::Result<()> {
        let mut file = File::open(path)?;
        let end = file.metadata()?.len();
        let name = path
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let blocks = self
            .blocks
            .get_mut()
            .unwrap_or_else(|held| held.into_inner());
        let number = blocks.files.len() as u32;
        blocks.files.push(path.into());
        let (mut at, mut lost) = (0, None);
        while at < end {
            match whole_at(&mut file, at)? {
                Some((head, BlockRows { rows, .. })) => {
                    if let Some(start) = lost.take() {
                        self.damages.push(damage(&name, start, at));
                    }
                    let place = BlockPlace {
                        file: Some(number),
                        offset: at,
                    };
                    let addresses = blocks.added(place, rows.len());
                    let keys = rows.iter().map(|row| key_of(&row.report_id));
                    self.index
                        .extend(keys.zip(addresses).filter_map(|(key, at)| Some((key?, at))));
                    at += head.whole();
                }
                None => {
                    lost = lost.or(Some(at));
                    at = block::next_block(&mut file, at + 1)?.unwrap_or(end);
                }
            }
        }
        if let Some(start) = lost {
            self.damages.push(damage(&name, start, end));
        }
        Ok(())
    }
}

impl Blocks {
    fn added(&mut self, place: BlockPlace, rows: usize) -> Vec<RowAddress> {
        let block = self.places.len() as u32;
        self.places.push(place);
        let address = |index| RowAddress { block, index };
        (0..rows as u32).map(address).collect()
    }
}

/// Reads the rows of the block at an offset.
fn rows_at(file: &mut (impl Read + Seek), offset: u64) -> io::Result<BlockRows> {
    whole_at(file, offset)?
        .map(|(_, body)| body)
        .ok_or_else(gone)
}

/// Reads the block at an offset with its rows; one that speaks of a recording has none. `None` if
/// there is no block that fits its checksums.
fn whole_at(
    file: &mut (impl Read + Seek),
    offset: u64,
) -> io::Result<Option<(BlockHead, BlockRows)>> {
    let Some(head) = block::head_at(file, offset)? else {
        return Ok(None);
    };
    if head.of.count == 0 {
        let whole = block::is_whole(file, offset, &head)?;
        return Ok(whole.then(|| (head, BlockRows::default())));
    }
    let body: Option<BlockRows> = block::body_at(file, offset, &head)?;
    let body = body.filter(|body| body.rows.len() == head.of.count as usize);
    Ok(body.map(|body| (head, body)))
}

/// Makes the folder of a store, with its marks: for programs that keep copies, and for git.
pub(super) fn make(folder: &Path) -> Result<(), Error> {
    // What else lies in a folder that was there must not vanish from git.
    let own = !folder.exists() || folder.ends_with(FOLDER);
    fs::create_dir_all(folder).map_err(|error| Error::io_at("make the store", folder, &error))?;
    for (name, text, wanted) in [
        ("CACHEDIR.TAG", CACHE_TAG, true),
        (".gitignore", "*\n", own),
    ] {
        let mark = folder.join(name);
        if wanted && !mark.exists() {
            fs::write(&mark, text)
                .map_err(|error| Error::io_at("write the store", &mark, &error))?;
        }
    }
    Ok(())
}

/// Lists the files of a store, in the order of their names.
pub(super) fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let listed =
        fs::read_dir(folder).map_err(|error| Error::io_at("list the store", folder, &error))?;
    let mut paths = BTreeSet::new();
    for entry in listed {
        let entry = entry.map_err(|error| Error::io_at("list the store", folder, &error))?;
        let path = entry.path();
        // What else bears such a name is nobody's here, and to open a pipe takes for ever.
        if path.extension().is_some_and(|end| end == ENDING) && path.is_file() {
            paths.insert(path);
        }
    }
    Ok(paths.into_iter().collect())
}

pub(super) fn damage(file: &str, start: u64, end: u64) -> String {
    format!(
        "{file}: bytes {start} to {end} are no block that fits its checksum; what they held is \
         judged again"
    )
}

fn gone() -> io::Error {
    io::Error::other("a block that was there is gone or damaged")
}

fn unkept(error: io::Error) -> Error {
    Error::io("read a decision again", &error)
}

/// The first half of a `report_id`.
type IdKey = [u8; 16];

fn key_of(report_id: &str) -> Option<IdKey> {
    let half = u128::from_str_radix(report_id.get(..32)?, 16).ok()?;
    Some(half.to_be_bytes())
}

/// Returns the name of this machine, as names of files hold it.
pub(super) fn host() -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let letters = host.trim().chars().filter(char::is_ascii_alphanumeric);
    letters.take(40).collect()
}

/// Makes a file that no other process has.
fn own_file(folder: &Path, label: &str) -> io::Result<(File, PathBuf)> {
    let process = std::process::id();
    let host = host();
    let mut number = 0_u32;
    loop {
        let path = folder.join(format!("{host}-{process}-{number}{label}.{ENDING}"));
        match OpenOptions::new().append(true).create_new(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            other => return other.map(|file| (file, path)),
        }
    }
}
