//! What a store holds of shares, from the heads of its blocks.

use super::block::{self, BlockHead, BlockKind, Key, key_of_bytes};
use super::question::{hex, key_of_hex};
use super::store::damage;
use latchgate_recording::error::Error;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Ends of its process after which a recording is given up.
pub(super) const ENDS_MAX: usize = 3;

/// One of several equal parts of a gate: recordings by the hash of their name, so that they stay
/// where they are when others join.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// Its number, from 1.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Share {
    /// Reads `I/N`.
    ///
    /// # Errors
    ///
    /// What was expected, if the text is no share.
    pub fn parse(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            Some(Self {
                number: number.trim().parse().ok()?,
                of: of.trim().parse().ok()?,
            })
        });
        numbers
            .filter(|share| (1..=share.of).contains(&share.number))
            .ok_or_else(|| "expected I/N, from 1/N to N/N, for example 3/100".into())
    }

    /// Tells whether a recording of that name is of the share.
    pub fn holds(&self, recording: &str) -> bool {
        Self::number_of(recording, self.of) == self.number
    }

    /// Returns the number of the share that holds a recording.
    pub fn number_of(recording: &str, of: u32) -> u32 {
        let hash = u128::from_be_bytes(key_of_bytes(recording.as_bytes()));
        (hash % u128::from(of.max(1))) as u32 + 1
    }

    /// Returns what the names of its files hold.
    pub(super) fn label(&self) -> String {
        format!("-share-{}-of-{}", self.number, self.of)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// How a recording ended its process.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct EndNote {
    /// Name of the file of that process.
    pub(super) file: String,
    /// How, in words.
    pub(super) how: String,
}

/// A block of decisions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PlacedBlock {
    recording: Key,
    /// Decisions come before those that are none.
    kind: BlockKind,
    pub(super) file: u32,
    pub(super) offset: u64,
    first: u32,
    count: u32,
    designs: Key,
}

/// Where the decision of a pair lies: the block's number, and its place in it.
pub(super) type PlaceOfRow = (usize, u32);

/// What a store holds of shares.
#[derive(Debug, Default)]
pub(super) struct StoreIndex {
    folder: PathBuf,
    pub(super) files: Vec<PathBuf>,
    /// Bytes of each that were read.
    pub(super) lengths: Vec<u64>,
    /// In order of their recordings.
    pub(super) blocks: Vec<PlacedBlock>,
    /// How often, and how, each recording ended its process.
    ends: BTreeMap<Key, Vec<String>>,
    /// Damages, one sentence each.
    pub(super) damages: Vec<String>,
}

/// A recording that a process began and did not leave.
struct Unfinished {
    file: String,
    recording: Key,
    /// Nothing follows in the file.
    is_last: bool,
}

impl StoreIndex {
    /// Reads the heads of the blocks in a store's files; with a `share`, not those of other shares of
    /// as many. `whole` reads the bodies as well, to see that they fit their checksums.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if the store cannot be read.
    pub(super) fn open(
        folder: &Path,
        paths: Vec<PathBuf>,
        share: Option<Share>,
        whole: bool,
    ) -> Result<Self, Error> {
        let mut index = Self {
            folder: folder.into(),
            ..Self::default()
        };
        let mut unfinished = Vec::new();
        let mut explained = BTreeSet::new();
        for path in paths {
            let name = name_of(&path);
            let label = share_of(&name);
            if let (Some(own), Some(other)) = (share, label)
                && own.of == other.of
                && own != other
            {
                continue;
            }
            let left = index
                .read(&path, whole, &mut explained)
                .map_err(|error| Error::io_at("read the store", &path, &error))?;
            // Of this share no other process is at work: the engine promises it.
            if share.is_some() && label == share {
                unfinished.extend(left);
            }
        }
        // A process that was ended together with whoever watched it left no word. It counts where
        // it had made no decision since the recording was begun, not where it was just at work.
        for left in unfinished {
            if left.is_last && !explained.contains(&left.file) {
                let ends = index.ends.entry(left.recording).or_default();
                ends.push("ended without a word".into());
            }
        }
        index.blocks.sort_unstable();
        Ok(index)
    }

    /// Reads a file; returns what its process began and did not leave.
    fn read(
        &mut self,
        path: &Path,
        whole: bool,
        explained: &mut BTreeSet<String>,
    ) -> io::Result<Vec<Unfinished>> {
        let mut file = File::open(path)?;
        let (end, name) = (file.metadata()?.len(), name_of(path));
        let number = self.files.len() as u32;
        self.files.push(path.into());
        self.lengths.push(end);
        let mut open = BTreeSet::new();
        let mut last = None;
        let (mut at, mut lost) = (0, None);
        while at < end {
            let head = block::head_at(&mut file, at)?.filter(|head| at + head.whole() <= end);
            let fits = match &head {
                Some(head) if whole => block::is_whole(&mut file, at, head)?,
                other => other.is_some(),
            };
            let Some(head) = head.filter(|_| fits) else {
                lost = lost.or(Some(at));
                at = block::next_block(&mut file, at + 1)?.unwrap_or(end);
                continue;
            };
            if let Some(start) = lost.take() {
                self.damages.push(damage(&name, start, at));
            }
            let of = head.of;
            last = Some((of.kind, of.recording));
            match of.kind {
                BlockKind::Rows | BlockKind::GivenUp => {
                    self.blocks.push(PlacedBlock {
                        recording: of.recording,
                        kind: of.kind,
                        file: number,
                        offset: at,
                        first: of.first,
                        count: of.count,
                        designs: of.designs,
                    });
                }
                BlockKind::Begun => {
                    open.insert(of.recording);
                }
                BlockKind::Left => {
                    open.remove(&of.recording);
                }
                BlockKind::Ended => self.take_end(&mut file, at, &head, explained)?,
            }
            at += head.whole();
        }
        if let Some(start) = lost {
            self.damages.push(damage(&name, start, end));
        }
        let left = open.into_iter().map(|recording| Unfinished {
            file: name.clone(),
            recording,
            is_last: last == Some((BlockKind::Begun, recording)),
        });
        Ok(left.collect())
    }

    fn take_end(
        &mut self,
        file: &mut File,
        at: u64,
        head: &BlockHead,
        explained: &mut BTreeSet<String>,
    ) -> io::Result<()> {
        if let Some(note) = block::body_at::<EndNote>(file, at, head)? {
            self.ends
                .entry(head.of.recording)
                .or_default()
                .push(note.how);
            explained.insert(note.file);
        }
        Ok(())
    }

    /// Returns how a recording ended its processes, if it did so too often.
    pub(super) fn given_up(&self, recording: Key) -> Option<&str> {
        let ends = self.ends.get(&recording)?;
        ends.last()
            .filter(|_| ends.len() >= ENDS_MAX)
            .map(String::as_str)
    }

    /// Returns the recordings that a process began and neither left nor finished.
    pub(super) fn begun_by(path: &Path) -> Result<Vec<Key>, Error> {
        let mut alone = Self::default();
        let left = alone
            .read(path, false, &mut BTreeSet::new())
            .map_err(|error| Error::io_at("read the store", path, &error))?;
        Ok(left.into_iter().map(|left| left.recording).collect())
    }

    /// Returns the block of that number as it was placed.
    fn blocks_of(&self, recording: Key) -> std::ops::Range<usize> {
        let from = self
            .blocks
            .partition_point(|block| block.recording < recording);
        let to = self
            .blocks
            .partition_point(|block| block.recording <= recording);
        from..to
    }

    /// Returns where the decision of each design lies, by its place in `designs`; `None` where there
    /// is none. Of several either is as good as the other, and a decision better than none.
    pub(super) fn known(
        &self,
        recording: Key,
        designs: &mut KnownDesigns,
    ) -> Vec<Option<PlaceOfRow>> {
        let mut found = vec![None; designs.keys.len()];
        for number in self.blocks_of(recording) {
            let block = &self.blocks[number];
            let places = designs.places(&self.folder, block.designs);
            for row in 0..block.count {
                let place = places.get((block.first + row) as usize).copied().flatten();
                if let Some(slot) = place.and_then(|place| found.get_mut(place as usize)) {
                    slot.get_or_insert((number, row));
                }
            }
        }
        found
    }

    /// Takes a block for one that holds nothing.
    pub(super) fn forget(&mut self, block: usize) {
        self.blocks[block].count = 0;
    }

    /// Tells whether a block holds decisions that are none.
    pub(super) fn is_given_up(&self, block: usize) -> bool {
        self.blocks[block].kind == BlockKind::GivenUp
    }
}

/// The designs of a plan, and where those of other lists stand among them.
#[derive(Debug, Clone)]
pub(super) struct KnownDesigns {
    pub(super) keys: Vec<Key>,
    /// The key of the list.
    pub(super) list: Key,
    others: BTreeMap<Key, Vec<Option<u32>>>,
}

impl KnownDesigns {
    pub(super) fn new(keys: Vec<Key>) -> Self {
        Self {
            list: key_of_bytes(keys.as_flattened()),
            keys,
            others: BTreeMap::new(),
        }
    }

    /// Keeps the list, under its key, for whoever reads the store with another one.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot be written.
    pub(super) fn keep(&self, folder: &Path) -> Result<(), Error> {
        let path = list_path(folder, self.list);
        let lines: Vec<String> = self.keys.iter().map(|key| hex(key)).collect();
        let text = lines.join("\n").into_bytes();
        if fs::read(&path).is_ok_and(|kept| kept == text) {
            return Ok(());
        }
        put_in_place(&path, &text).map_err(|error| Error::io_at("write the store", &path, &error))
    }

    /// Returns where the designs of a list stand here; none of them, where the list is not there.
    fn places(&mut self, folder: &Path, list: Key) -> &[Option<u32>] {
        let own = &self.keys;
        let is_own = list == self.list;
        self.others.entry(list).or_insert_with(|| {
            let all = 0..own.len() as u32;
            if is_own {
                return all.map(Some).collect();
            }
            let text = fs::read_to_string(list_path(folder, list)).unwrap_or_default();
            let keys: Vec<Key> = text.lines().filter_map(key_of_hex).collect();
            if key_of_bytes(keys.as_flattened()) != list {
                return Vec::new();
            }
            let here: BTreeMap<Key, u32> = own.iter().copied().zip(all).collect();
            keys.iter().map(|key| here.get(key).copied()).collect()
        })
    }
}

fn list_path(folder: &Path, list: Key) -> PathBuf {
    folder.join(format!("{}.designs", hex(&list)))
}

/// Writes a file beside its place and moves it there whole.
pub(super) fn put_in_place(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = path.with_extension(format!("{}.part", std::process::id()));
    fs::write(&beside, bytes)
        .and_then(|()| File::open(&beside)?.sync_all())
        .and_then(|()| fs::rename(&beside, path))
        .inspect_err(|_| drop(fs::remove_file(&beside)))
}

pub(super) fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Returns the share that a file's name tells of.
fn share_of(name: &str) -> Option<Share> {
    let (_, rest) = name.split_once("-share-")?;
    let (number, rest) = rest.split_once("-of-")?;
    let of = rest.split(|c: char| !c.is_ascii_digit()).next()?;
    Share::parse(&format!("{number}/{of}")).ok()
}
