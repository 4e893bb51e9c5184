//! A block of a store's file: what it is of, how long it is, checksums of both, and its body.
//!
//! The head alone tells which pairs a block holds, so that whoever wants to know what is there
//! reads past the rows.

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::io::{self, Read, Seek, SeekFrom, Write as _};

/// What a block begins with.
const MAGIC: &[u8; 8] = b"latchro2";

/// Bytes before a block's body: letters, kind, two keys, first and count, length, the body's
/// SHA-256, the head's own checksum.
const HEAD: usize = 8 + 1 + 16 + 16 + 4 + 4 + 4 + 32 + 4;

/// Longest body that is taken for one [bytes].
const BODY_MAX: usize = 64 << 20;

/// Most bytes that a body may unfold to.
const UNFOLDED_MAX: u64 = 512 << 20;

/// Bytes that are searched at once for the next block behind a damage.
const SEARCHED: usize = 64 << 10;

/// The first half of a hash.
pub(super) type Key = [u8; 16];

/// Returns the first half of the SHA-256 of bytes.
pub(super) fn key_of_bytes(bytes: &[u8]) -> Key {
    let mut key = Key::default();
    key.copy_from_slice(&Sha256::digest(bytes)[..16]);
    key
}

/// What a block says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum BlockKind {
    /// Decisions.
    Rows,
    /// Decisions that are none: the recording ended its process too often.
    GivenUp,
    /// A recording is begun.
    Begun,
    /// A recording is left in good order, done or not; or how its process was ended is noted elsewhere.
    Left,
    /// A recording ended its process.
    Ended,
}

/// What a block is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BlockOf {
    pub(super) kind: BlockKind,
    /// Key of the recording's question; zeros where none is known.
    pub(super) recording: Key,
    /// Key of the list of designs.
    pub(super) designs: Key,
    /// Place in that list of the first row's design; those of the others follow.
    pub(super) first: u32,
    /// How many rows there are.
    pub(super) count: u32,
}

impl BlockOf {
    /// Returns the head of a block that speaks of a recording, not of pairs.
    pub(super) fn note(kind: BlockKind, recording: Key) -> Self {
        Self {
            kind,
            recording,
            designs: Key::default(),
            first: 0,
            count: 0,
        }
    }
}

/// A head as it was read.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockHead {
    pub(super) of: BlockOf,
    length: u32,
    sum: [u8; 32],
}

impl BlockHead {
    /// Returns the bytes of the whole block.
    pub(super) fn whole(&self) -> u64 {
        HEAD as u64 + u64::from(self.length)
    }
}

/// Returns a block's bytes.
pub(super) fn encode(of: BlockOf, body: &impl Serialize) -> io::Result<Vec<u8>> {
    let mut packed = DeflateEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(&serde_json::to_vec(body)?)?;
    let packed = packed.finish()?;
    let length = u32::try_from(packed.len())
        .ok()
        .filter(|length| *length as usize <= BODY_MAX)
        .ok_or_else(|| io::Error::other("a block is too long"))?;
    let mut block = Vec::with_capacity(HEAD + packed.len());
    block.extend(MAGIC);
    block.push(of.kind as u8);
    block.extend(of.recording);
    block.extend(of.designs);
    block.extend(of.first.to_le_bytes());
    block.extend(of.count.to_le_bytes());
    block.extend(length.to_le_bytes());
    block.extend(checksum(&packed));
    block.extend(crc32fast::hash(&block).to_le_bytes());
    block.extend(packed);
    Ok(block)
}

/// Reads the head at an offset; `None` if there is none that fits its checksum.
pub(super) fn head_at(file: &mut (impl Read + Seek), offset: u64) -> io::Result<Option<BlockHead>> {
    let mut head = Vec::with_capacity(HEAD);
    file.seek(SeekFrom::Start(offset))?;
    file.take(HEAD as u64).read_to_end(&mut head)?;
    Ok(head_of(&head))
}

fn head_of(bytes: &[u8]) -> Option<BlockHead> {
    let (head, sum) = bytes.split_last_chunk::<4>()?;
    let fits = bytes.len() == HEAD && crc32fast::hash(head) == u32::from_le_bytes(*sum);
    let (magic, rest) = head.split_first_chunk::<8>()?;
    let (kind, rest) = rest.split_first()?;
    let (recording, rest) = rest.split_first_chunk::<16>()?;
    let (designs, rest) = rest.split_first_chunk::<16>()?;
    let (first, rest) = rest.split_first_chunk::<4>()?;
    let (count, rest) = rest.split_first_chunk::<4>()?;
    let (length, rest) = rest.split_first_chunk::<4>()?;
    let (sum, _) = rest.split_first_chunk::<32>()?;
    use BlockKind::{Begun, Ended, GivenUp, Left, Rows};
    let kinds = [Rows, GivenUp, Begun, Left, Ended];
    let kind = kinds.into_iter().find(|known| *known as u8 == *kind)?;
    let length = u32::from_le_bytes(*length);
    (fits && magic == MAGIC && length as usize <= BODY_MAX).then_some(BlockHead {
        of: BlockOf {
            kind,
            recording: *recording,
            designs: *designs,
            first: u32::from_le_bytes(*first),
            count: u32::from_le_bytes(*count),
        },
        length,
        sum: *sum,
    })
}

/// Tells whether the body behind a head fits its checksum.
pub(super) fn is_whole(
    file: &mut (impl Read + Seek),
    offset: u64,
    head: &BlockHead,
) -> io::Result<bool> {
    Ok(packed_at(file, offset, head)?.is_some())
}

/// Reads the body behind a head; `None` if it does not fit its checksum.
pub(super) fn body_at<T: DeserializeOwned>(
    file: &mut (impl Read + Seek),
    offset: u64,
    head: &BlockHead,
) -> io::Result<Option<T>> {
    let Some(packed) = packed_at(file, offset, head)? else {
        return Ok(None);
    };
    // Text as a whole is parsed several times as fast as a stream.
    let mut text = Vec::new();
    let unpacked = DeflateDecoder::new(&*packed)
        .take(UNFOLDED_MAX)
        .read_to_end(&mut text);
    Ok(unpacked
        .ok()
        .and_then(|_| serde_json::from_slice(&text).ok()))
}

fn packed_at(
    file: &mut (impl Read + Seek),
    offset: u64,
    head: &BlockHead,
) -> io::Result<Option<Vec<u8>>> {
    let mut packed = Vec::new();
    file.seek(SeekFrom::Start(offset + HEAD as u64))?;
    file.take(u64::from(head.length)).read_to_end(&mut packed)?;
    let fits = packed.len() == head.length as usize && checksum(&packed) == head.sum;
    Ok(fits.then_some(packed))
}

/// Returns the next place, not before `from`, at which a block could begin.
pub(super) fn next_block(file: &mut (impl Read + Seek), from: u64) -> io::Result<Option<u64>> {
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

fn checksum(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}
