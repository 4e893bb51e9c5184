//! Decisions that were made before, and those made now, kept for the next run.
//!
//! A store is a folder. Each process appends to one file of its own; nothing is rewritten, so that
//! several processes may share a store, on a network file system, too. A file is a sequence of
//! blocks: eight letters, the length of what follows, its SHA-256, and rows as compressed JSON.
//! A block that does not fit its checksum is left out and told; its rows are judged again.

//!
//! In memory stands only where each row lies, so that a gate of very many pairs takes little more
//! than one of few. Rows that are not to be kept (nothing could be read, or no store is wished) are
//! put aside as blocks in memory.

use crate::error::{Error, ErrorKind, Place};
use crate::pipeline::Row;
use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

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

/// Bytes that are searched at once for the next block behind a damage.
const SEARCHED: usize = 64 << 10;

/// Decisions by `report_id`.
#[derive(Debug)]
pub struct Store {
    /// `None` where nothing is to be kept.
    folder: Option<PathBuf>,
    /// The first half of each `report_id` that was kept before, and where its row lies, in order.
    index: Vec<(IdKey, RowAddress)>,
    /// Damages found on opening, one sentence each.
    damages: Vec<String>,
    blocks: Mutex<Blocks>,
}

/// Where a row lies: the number of its block, and its place in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct RowAddress {
    block: u32,
    index: u32,
}

/// Where the blocks lie.
#[derive(Debug, Default)]
struct Blocks {
    files: Vec<PathBuf>,
    places: Vec<BlockPlace>,
    /// The file of this process, made with the first block: handle, number, bytes in it.
    own: Option<(File, u32, u64)>,
    /// Blocks that are not kept.
    aside: Vec<u8>,
}

#[derive(Debug, Clone, Copy)]
struct BlockPlace {
    /// Number of the file; `None`: aside.
    file: Option<u32>,
    offset: u64,
}

impl Store {
    /// Returns a store that keeps nothing beyond the process.
    #[must_use]
    pub fn unkept() -> Self {
        Self {
            folder: None,
            index: Vec::new(),
            damages: Vec::new(),
            blocks: Mutex::default(),
        }
    }

    /// Opens the store in a folder, which is made if absent.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if the folder cannot be made, listed or read.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        fs::create_dir_all(folder).map_err(|error| failed("make the store", folder, &error))?;
        let tag = folder.join("CACHEDIR.TAG");
        if !tag.exists() {
            fs::write(&tag, CACHE_TAG).map_err(|error| failed("write the store", &tag, &error))?;
        }
        let listed =
            fs::read_dir(folder).map_err(|error| failed("list the store", folder, &error))?;
        let mut paths = BTreeSet::new();
        for entry in listed {
            let entry = entry.map_err(|error| failed("list the store", folder, &error))?;
            if entry.path().extension().is_some_and(|end| end == ENDING) {
                paths.insert(entry.path());
            }
        }
        let mut store = Self {
            folder: Some(folder.into()),
            ..Self::unkept()
        };
        for path in paths {
            store
                .list(&path)
                .map_err(|error| failed("read the store", &path, &error))?;
        }
        // Of two rows of one question either is as good as the other.
        store.index.sort_unstable();
        store.index.dedup_by_key(|(key, _)| *key);
        Ok(store)
    }

    /// Returns what was found damaged, one sentence each.
    #[must_use]
    pub fn damages(&self) -> &[String] {
        &self.damages
    }

    /// Returns where the row of that `report_id` lies, if it was kept before the store was opened.
    #[must_use]
    pub fn find(&self, report_id: &str) -> Option<RowAddress> {
        let key = key_of(report_id)?;
        let found = self.index.binary_search_by_key(&key, |(key, _)| *key);
        found.ok().map(|at| self.index[at].1)
    }

    /// Appends a block of rows and sees it onto the disk; returns where they lie.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if it cannot be written.
    pub fn put(&self, rows: &[Row]) -> Result<Vec<RowAddress>, Error> {
        let Some(folder) = &self.folder else {
            return self.put_aside(rows);
        };
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        let unwritable = |error: io::Error| failed("write the store", folder, &error);
        let block = block_of(rows).map_err(unwritable)?;
        let mut blocks = self.blocks();
        let mut own = match blocks.own.take() {
            Some(own) => own,
            None => {
                let (file, path) = own_file(folder).map_err(unwritable)?;
                blocks.files.push(path);
                (file, blocks.files.len() as u32 - 1, 0)
            }
        };
        own.0
            .write_all(&block)
            .and_then(|()| own.0.sync_data())
            .map_err(unwritable)?;
        let place = BlockPlace {
            file: Some(own.1),
            offset: own.2,
        };
        own.2 += block.len() as u64;
        blocks.own = Some(own);
        Ok(blocks.added(place, rows.len()))
    }

    /// Puts rows aside that are not to be kept; returns where they lie.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if they are too many for a block.
    pub fn put_aside(&self, rows: &[Row]) -> Result<Vec<RowAddress>, Error> {
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        let block = block_of(rows).map_err(unkept)?;
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
    /// [`ErrorKind::Io`] if a block is no longer there, or no longer fits its checksum.
    pub fn rows(&self, addresses: &[RowAddress]) -> Result<Vec<Row>, Error> {
        let mut found = Vec::with_capacity(addresses.len());
        for of_block in addresses.chunk_by(|a, b| a.block == b.block) {
            let rows = self.block(of_block[0].block)?;
            for address in of_block {
                let row = rows.get(address.index as usize).cloned();
                found.push(row.ok_or_else(|| unkept(gone()))?);
            }
        }
        Ok(found)
    }

    fn block(&self, number: u32) -> Result<Vec<Row>, Error> {
        let blocks = self.blocks();
        let Some(place) = blocks.places.get(number as usize).copied() else {
            return Err(unkept(gone()));
        };
        let Some(file) = place.file else {
            let mut aside = io::Cursor::new(&blocks.aside);
            let read = block_at(&mut aside, place.offset);
            return read
                .and_then(|block| block.ok_or_else(gone))
                .map_err(unkept)
                .map(|(rows, _)| rows);
        };
        let path = blocks.files[file as usize].clone();
        drop(blocks);
        File::open(&path)
            .and_then(|mut file| block_at(&mut file, place.offset)?.ok_or_else(gone))
            .map(|(rows, _)| rows)
            .map_err(|error| failed("read the store again", &path, &error))
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
            match block_at(&mut file, at)? {
                Some((rows, length)) => {
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
                    at += length;
                }
                None => {
                    lost = lost.or(Some(at));
                    at = next_block(&mut file, at + 1)?.unwrap_or(end);
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

fn damage(file: &str, start: u64, end: u64) -> String {
    format!(
        "{file}: bytes {start} to {end} are no block that fits its checksum; what they held is \
         judged again"
    )
}

fn gone() -> io::Error {
    io::Error::other("a block that was there is gone or damaged")
}

fn unkept(error: io::Error) -> Error {
    Error::from(ErrorKind::Io {
        action: "read a decision again",
        reason: error.to_string(),
    })
}

/// The first half of a `report_id`.
type IdKey = [u8; 16];

fn key_of(report_id: &str) -> Option<IdKey> {
    let half = u128::from_str_radix(report_id.get(..32)?, 16).ok()?;
    Some(half.to_be_bytes())
}

/// Makes a file that no other process has.
fn own_file(folder: &Path) -> io::Result<(File, PathBuf)> {
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
        let path = folder.join(format!("{host}-{process}-{number}.{ENDING}"));
        match OpenOptions::new().append(true).create_new(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            other => return other.map(|file| (file, path)),
        }
    }
}

/// Returns the next place, not before `from`, at which a block could begin.
fn next_block(file: &mut File, from: u64) -> io::Result<Option<u64>> {
    let mut window = Vec::with_capacity(SEARCHED);
    let mut at = from;
    loop {
        window.clear();
        file.seek(SeekFrom::Start(at))?;
        file.take(SEARCHED as u64).read_to_end(&mut window)?;
        if let Some(found) = memchr::memmem::find(&window, MAGIC) {
            return Ok(Some(at + found as u64));
        }
        if window.len() < SEARCHED {
            return Ok(None);
        }
        // The letters may lie across the window's end.
        at += (SEARCHED + 1 - MAGIC.len()) as u64;
    }
}

fn block_of(rows: &[Row]) -> io::Result<Vec<u8>> {
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

/// Reads the block at an offset: its rows, and its length; `None` if there is none that fits its
/// checksum.
fn block_at(file: &mut (impl Read + Seek), offset: u64) -> io::Result<Option<(Vec<Row>, u64)>> {
    let mut head = Vec::with_capacity(HEAD);
    file.seek(SeekFrom::Start(offset))?;
    file.take(HEAD as u64).read_to_end(&mut head)?;
    let Some((magic, rest)) = head
        .split_at_checked(MAGIC.len())
        .filter(|_| head.len() == HEAD)
    else {
        return Ok(None);
    };
    let (length, sum) = rest.split_at(4);
    let length = u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize;
    if magic != MAGIC || length > BLOCK_MAX {
        return Ok(None);
    }
    let mut packed = Vec::new();
    file.take(length as u64).read_to_end(&mut packed)?;
    if packed.len() != length || checksum(&packed) != sum {
        return Ok(None);
    }
    let unpacked = DeflateDecoder::new(&*packed).take(ROWS_MAX);
    let rows = serde_json::from_reader(io::BufReader::new(unpacked)).ok();
    Ok(rows.map(|rows| (rows, (HEAD + length) as u64)))
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
