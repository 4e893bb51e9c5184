//! Archives: .zip, .tar.gz and .tar, read within limits.
//!
//! The archive itself is held in memory; of what it holds, one file at a time, or the channel
//! files of a .tar.gz together. A file that unpacks to more than a limit, or to far more than
//! it takes in the archive, ends the reading there.

use super::names::{is_channel_file, is_test_file};
use crate::error::{Error, ErrorKind, Place};
use crate::recording::Limits;
use crate::recording::text;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Read};

/// Bytes unpacked before the ratio counts.
const RATIO_FROM: u64 = 4 << 20;

/// Bytes of a tar header, and what its parts are filled up to.
const BLOCK: u64 = 512;

/// Longest name that a tar archive states apart from a header [byte].
const LONG_NAME: u64 = 16 << 10;

/// Tells whether the head is that of a .zip, a gzip file or a .tar.
pub(super) fn is_archive(head: &[u8]) -> bool {
    is_zip(head) || is_gzip(head) || is_tar(head)
}

fn is_zip(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06")
}

fn is_gzip(head: &[u8]) -> bool {
    head.starts_with(b"\x1F\x8B")
}

fn is_tar(head: &[u8]) -> bool {
    head.get(257..262) == Some(b"ustar")
}

/// An archive.
pub(super) enum Archive {
    Zip {
        archive: Box<zip::ZipArchive<Cursor<Vec<u8>>>>,
        /// Index of each file by its name, with `/` between folder and file.
        files: BTreeMap<String, usize>,
        /// Bytes unpacked so far.
        out: u64,
    },
    /// Files of a test, unpacked; and the names of all.
    Tar {
        files: BTreeMap<String, Vec<u8>>,
        compressed: bool,
    },
    /// A gzip file that holds no tar.
    Plain,
}

impl Archive {
    pub(super) fn open(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Error> {
        if is_zip(&bytes) {
            return Self::open_zip(bytes, limits);
        }
        if is_gzip(&bytes) {
            let mut stream = Stream::new(
                flate2::read::MultiGzDecoder::new(Cursor::new(bytes)),
                limits,
            );
            return match tar(&mut stream, limits)? {
                Some(files) => Ok(Self::Tar {
                    files,
                    compressed: true,
                }),
                None => Ok(Self::Plain),
            };
        }
        let mut stream = Stream::new(Cursor::new(bytes), limits);
        Ok(Self::Tar {
            files: tar(&mut stream, limits)?.unwrap_or_default(),
            compressed: false,
        })
    }

    fn open_zip(bytes: Vec<u8>, limits: &Limits) -> Result<Self, Error> {
        // Each entry costs memory before it can be asked for, so they are counted first.
        let entries = bytes
            .windows(4)
            .filter(|four| four == b"PK\x01\x02")
            .count() as u64;
        if entries > limits.archive_entries {
            return Err(too_many_entries(entries, limits));
        }
        let repeated = repeated_name(&bytes);
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|_| {
            Error::from(ErrorKind::RefusedFormat {
                format: "a zip container (.xlsx or an archive) that does not open",
                way_out: "if it is a sheet, save the sheet as CSV; if it is a test, fetch it again",
            })
        })?;
        if archive.len() as u64 > limits.archive_entries {
            return Err(too_many_entries(archive.len() as u64, limits));
        }
        if archive.has_duplicate_names() {
            return Err(twice(repeated.as_deref().unwrap_or("a file")));
        }
        let mut files = BTreeMap::new();
        let mut first = u64::MAX;
        for index in 0..archive.len() {
            let entry = archive
                .by_index_raw(index)
                .map_err(|error| damaged(&error.to_string()))?;
            first = first.min(entry.header_start());
            // Some programs for Windows write its own mark between folder and file.
            let Ok(name) = entry.name() else { continue };
            let name = name.replace('\\', "/");
            if files.insert(name.clone(), index).is_some() {
                return Err(twice(&name));
            }
        }
        // The file begins with a file in a zip: what stands before the first one that is listed
        // is of another archive, or of one that this one has replaced.
        if archive.offset() > 0 || (first > 0 && !archive.is_empty()) {
            return Err(Error::from(ErrorKind::Malformed {
                expected: "one zip archive, from the first byte on".into(),
                found: "files before those that its list names, as where two archives stand one \
                        behind the other"
                    .into(),
                hint: "which of them hold is not known; pack the test again".into(),
            })
            .at(Place::default().byte(0)));
        }
        Ok(Self::Zip {
            archive: Box::new(archive),
            files,
            out: 0,
        })
    }

    /// Lists the files.
    pub(super) fn names(&self) -> Vec<String> {
        match self {
            Self::Zip { files, .. } => files.keys().cloned().collect(),
            Self::Tar { files, .. } => files.keys().cloned().collect(),
            Self::Plain => Vec::new(),
        }
    }

    /// Says what the archive is, if it holds no test.
    pub(super) fn refused(&self) -> Error {
        let (format, way_out) = match self {
            Self::Zip { files, .. }
                if files
                    .keys()
                    .any(|name| name == "[Content_Types].xml" || name.starts_with("xl/")) =>
            {
                ("Excel (.xlsx)", "save the sheet as CSV")
            }
            Self::Zip { .. } => (
                "a .zip that holds no ISO-MME test",
                "unpack it and name the recording, or export the channel as CSV",
            ),
            Self::Tar {
                compressed: true, ..
            } => (
                "a .tar.gz that holds no ISO-MME test",
                "unpack it and name the recording, or export the channel as CSV",
            ),
            Self::Tar { .. } => (
                "a .tar that holds no ISO-MME test",
                "unpack it and name the recording, or export the channel as CSV",
            ),
            Self::Plain => ("a gzip file", "unpack it first"),
        };
        ErrorKind::RefusedFormat { format, way_out }.into()
    }

    /// Reads up to `most` bytes of a file.
    pub(super) fn head(
        &mut self,
        name: &str,
        most: u64,
        limits: &Limits,
    ) -> Result<Vec<u8>, Error> {
        match self {
            Self::Zip {
                archive,
                files,
                out,
            } => match files.get(name) {
                Some(index) => unzip(archive, out, *index, most, limits),
                None => Ok(Vec::new()),
            },
            Self::Tar { files, .. } => {
                let bytes = files.get(name).map(Vec::as_slice).unwrap_or_default();
                let end = bytes.len().min(usize::try_from(most).unwrap_or(usize::MAX));
                Ok(bytes[..end].to_vec())
            }
            Self::Plain => Ok(Vec::new()),
        }
    }

    /// Reads a file whole.
    pub(super) fn read(
        &mut self,
        name: &str,
        limit: u64,
        limits: &Limits,
    ) -> Result<Vec<u8>, Error> {
        let bytes = self.head(name, limit.saturating_add(1), limits)?;
        if bytes.len() as u64 > limit {
            return Err(over("unpacked_bytes", limit, "more bytes in a file")
                .at(Place::default().byte(limit)));
        }
        Ok(bytes)
    }
}

fn unzip(
    archive: &mut zip::ZipArchive<Cursor<Vec<u8>>>,
    out: &mut u64,
    index: usize,
    most: u64,
    limits: &Limits,
) -> Result<Vec<u8>, Error> {
    check_packing(archive, index)?;
    let mut entry = archive
        .by_index(index)
        .map_err(|error| damaged(&error.to_string()))?;
    let packed = entry.compressed_size();
    let start = entry.data_start().unwrap_or_default();
    let mut bytes = Vec::new();
    let mut buffer = vec![0; buffer_bytes(entry.size())];
    loop {
        let left = most
            .saturating_sub(bytes.len() as u64)
            .min(buffer.len() as u64);
        if left == 0 {
            break;
        }
        let room = usize::try_from(left).unwrap_or(buffer.len());
        let count = entry
            .read(&mut buffer[..room])
            .map_err(|error| damaged(&error.to_string()).at(Place::default().byte(start)))?;
        if count == 0 {
            break;
        }
        bytes.extend_from_slice(&buffer[..count]);
        *out += count as u64;
        if *out > limits.unpacked_stream_bytes {
            return Err(over(
                "unpacked_stream_bytes",
                limits.unpacked_stream_bytes,
                "more bytes in all files",
            )
            .at(Place::default().byte(start)));
        }
        check_ratio(bytes.len() as u64, packed, limits)
            .map_err(|error| error.at(Place::default().byte(start)))?;
    }
    Ok(bytes)
}

/// Refuses by name what is packed in a way that is not read here.
fn check_packing(
    archive: &mut zip::ZipArchive<Cursor<Vec<u8>>>,
    index: usize,
) -> Result<(), Error> {
    use zip::CompressionMethod as Method;
    let way_out = "unpack it and name the folder";
    let entry = archive
        .by_index_raw(index)
        .map_err(|error| damaged(&error.to_string()))?;
    let format = match entry.compression() {
        _ if entry.encrypted() => "a .zip that is encrypted",
        Method::Stored | Method::Deflated => return Ok(()),
        Method::AES => "a .zip that is encrypted",
        Method::DEFLATE64 => "a .zip packed with deflate64",
        Method::BZIP2 => "a .zip packed with bzip2",
        Method::LZMA => "a .zip packed with lzma",
        Method::ZSTD => "a .zip packed with zstd",
        Method::XZ => "a .zip packed with xz",
        Method::PPMD => "a .zip packed with ppmd",
        _ => "a .zip packed in a way that is not read here",
    };
    Err(ErrorKind::RefusedFormat { format, way_out }.into())
}

/// Returns the bytes that are unpacked at a time, of a file that states its size.
fn buffer_bytes(stated: u64) -> usize {
    usize::try_from(stated.clamp(BLOCK, 64 << 10)).unwrap_or(64 << 10)
}

/// Refuses what unpacks to far more than it takes.
fn check_ratio(unpacked: u64, packed: u64, limits: &Limits) -> Result<(), Error> {
    if unpacked > RATIO_FROM && unpacked / limits.unpacked_ratio.max(1) > packed {
        return Err(over(
            "unpacked_ratio",
            limits.unpacked_ratio,
            &format!("{unpacked} bytes from {packed}"),
        ));
    }
    Ok(())
}

/// Returns a name that comes twice among what looks like records of a zip archive's directory.
fn repeated_name(bytes: &[u8]) -> Option<String> {
    let mut seen: BTreeSet<&[u8]> = BTreeSet::new();
    memchr::memmem::find_iter(bytes, b"PK\x01\x02").find_map(|start| {
        let length = bytes.get(start + 28..start + 30)?;
        let length = usize::from(u16::from_le_bytes([length[0], length[1]]));
        let name = bytes.get(start + 46..start + 46 + length)?;
        (!seen.insert(name)).then(|| String::from_utf8_lossy(name).into_owned())
    })
}

fn twice(name: &str) -> Error {
    ErrorKind::Malformed {
        expected: "each file once in the archive".into(),
        found: format!("{} twice", text::shown(name)),
        hint: "which of the two holds is not known; pack the test again".into(),
    }
    .into()
}

/// A stream that counts what comes out of it, and what went in if it unpacks.
struct Stream<'a, R> {
    inner: R,
    limits: &'a Limits,
    out: u64,
}

/// Where a stream stands in the bytes it was made of.
trait Position {
    fn position(&self) -> u64;
}

impl Position for Cursor<Vec<u8>> {
    fn position(&self) -> u64 {
        Self::position(self)
    }
}

impl Position for flate2::read::MultiGzDecoder<Cursor<Vec<u8>>> {
    fn position(&self) -> u64 {
        self.get_ref().position()
    }
}

impl<'a, R: Read + Position> Stream<'a, R> {
    fn new(inner: R, limits: &'a Limits) -> Self {
        Self {
            inner,
            limits,
            out: 0,
        }
    }

    /// Fills the buffer as far as the stream goes.
    fn fill(&mut self, buffer: &mut [u8]) -> Result<usize, Error> {
        let mut filled = 0;
        while filled < buffer.len() {
            let at = Place::default().byte(self.inner.position());
            let count = self
                .inner
                .read(&mut buffer[filled..])
                .map_err(|error| damaged(&error.to_string()).at(at.clone()))?;
            if count == 0 {
                break;
            }
            filled += count;
            self.out += count as u64;
            let at = Place::default().byte(self.inner.position());
            check_ratio(self.out, self.inner.position(), self.limits)
                .map_err(|error| error.at(at.clone()))?;
            if self.out > self.limits.unpacked_stream_bytes {
                return Err(over(
                    "unpacked_stream_bytes",
                    self.limits.unpacked_stream_bytes,
                    "a longer archive",
                )
                .at(at));
            }
        }
        Ok(filled)
    }

    /// Takes `size` bytes, kept or passed over, and the filling up to a whole block.
    fn take(&mut self, size: u64, keep: bool) -> Result<Vec<u8>, Error> {
        let mut kept = Vec::new();
        let mut left = size;
        let mut buffer = vec![0; buffer_bytes(size)];
        while left > 0 {
            let room = usize::try_from(left.min(buffer.len() as u64)).unwrap_or(buffer.len());
            let count = self.fill(&mut buffer[..room])?;
            if count < room {
                return Err(self.cut());
            }
            if keep {
                kept.extend_from_slice(&buffer[..count]);
            }
            left -= count as u64;
        }
        let over = size % BLOCK;
        if over > 0 {
            let room = usize::try_from(BLOCK - over).unwrap_or(0);
            if self.fill(&mut buffer[..room])? < room {
                return Err(self.cut());
            }
        }
        Ok(kept)
    }

    /// Reads the filling after the last file, so that checksums at the end are looked at.
    fn drain(&mut self) -> Result<(), Error> {
        let mut buffer = vec![0; 64 << 10];
        loop {
            let count = self.fill(&mut buffer)?;
            if buffer[..count].iter().any(|byte| *byte != 0) {
                return Err(damaged("more data after the end of the tar archive")
                    .at(Place::default().byte(self.inner.position())));
            }
            if count < buffer.len() {
                return Ok(());
            }
        }
    }

    fn cut(&self) -> Error {
        Error::from(ErrorKind::Truncated {
            expected: "the rest of the archive, up to the block of zeros that ends it".into(),
            found: "the archive's end".into(),
        })
        .at(Place::default().byte(self.inner.position()))
    }
}

/// Reads the files of a test from a tar stream; `None` if it is no tar.
fn tar<R: Read + Position>(
    stream: &mut Stream<'_, R>,
    limits: &Limits,
) -> Result<Option<BTreeMap<String, Vec<u8>>>, Error> {
    let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    let mut held = 0_u64;
    let mut entries = 0_u64;
    let mut long_name: Option<String> = None;
    let mut header = [0_u8; BLOCK as usize];
    loop {
        let count = match stream.fill(&mut header) {
            Ok(count) => count,
            // What does not even unpack a block is no tar, unless a limit was crossed.
            Err(error)
                if entries == 0 && !matches!(error.kind(), ErrorKind::LimitExceeded { .. }) =>
            {
                return Ok(None);
            }
            Err(error) => return Err(error),
        };
        if count < header.len() {
            return match (entries, count) {
                (0, _) => Ok(None),
                _ => Err(stream.cut()),
            };
        }
        if header.iter().all(|byte| *byte == 0) {
            if entries == 0 {
                return Ok(None);
            }
            stream.drain()?;
            return Ok(Some(files));
        }
        let Some(size) = octal(&header[124..136]).filter(|_| checksum_fits(&header)) else {
            if entries == 0 {
                return Ok(None);
            }
            return Err(damaged("a tar header whose checksum is wrong")
                .at(Place::default().byte(stream.inner.position())));
        };
        entries += 1;
        if entries > limits.archive_entries {
            return Err(too_many_entries(entries, limits)
                .at(Place::default().byte(stream.inner.position())));
        }
        match header[156] {
            // Names too long for a header stand in an entry of their own.
            kind @ (b'L' | b'x') if size <= LONG_NAME => {
                let bytes = stream.take(size, true)?;
                let text = String::from_utf8_lossy(&bytes).into_owned();
                if kind == b'L' {
                    long_name = Some(text.trim_end_matches('\0').to_string());
                } else if let Some(path) = pax_path(&text) {
                    long_name = Some(path);
                }
            }
            b'0' | 0 | b'7' => {
                let name = long_name.take().unwrap_or_else(|| name_of(&header));
                let name = name.trim_start_matches("./").to_string();
                let keep = is_test_file(&name) || is_channel_file(&name);
                if keep {
                    held = held.saturating_add(size);
                    check_held(held, stream, limits)?;
                }
                let bytes = stream.take(size, keep)?;
                if keep && files.insert(name.clone(), bytes).is_some() {
                    return Err(twice(&name));
                }
            }
            kind => {
                let name = long_name.clone().unwrap_or_else(|| name_of(&header));
                refuse_link(kind, &name, stream)?;
                // What a link points to may stand between a long name and its entry.
                if kind != b'K' {
                    long_name = None;
                }
                stream.take(size, false)?;
            }
        }
    }
}

/// Refuses a file of the test that is a link or another kind of entry.
fn refuse_link<R: Read + Position>(
    kind: u8,
    name: &str,
    stream: &Stream<'_, R>,
) -> Result<(), Error> {
    let is_wanted = is_test_file(name) || is_channel_file(name);
    if is_wanted && !matches!(kind, b'5' | b'g' | b'x' | b'L' | b'K') {
        return Err(Error::from(ErrorKind::Malformed {
            expected: "the files of the test themselves in the archive".into(),
            found: format!("{} as a link or another kind of entry", text::shown(name)),
            hint: "unpack the archive and name the folder, or pack it without links".into(),
        })
        .at(Place::default().byte(stream.inner.position())));
    }
    Ok(())
}

/// Refuses channel files that are larger together than allowed.
fn check_held<R: Read + Position>(
    held: u64,
    stream: &Stream<'_, R>,
    limits: &Limits,
) -> Result<(), Error> {
    if held > limits.unpacked_bytes {
        return Err(over(
            "unpacked_bytes",
            limits.unpacked_bytes,
            "more bytes in the channel files together",
        )
        .at(Place::default().byte(stream.inner.position())));
    }
    Ok(())
}

fn name_of(header: &[u8; BLOCK as usize]) -> String {
    let text = |bytes: &[u8]| {
        let end = bytes
            .iter()
            .position(|byte| *byte == 0)
            .unwrap_or(bytes.len());
        String::from_utf8_lossy(&bytes[..end]).into_owned()
    };
    let name = text(&header[..100]);
    let prefix = if &header[257..262] == b"ustar" {
        text(&header[345..500])
    } else {
        String::new()
    };
    if prefix.is_empty() {
        name
    } else {
        format!("{prefix}/{name}")
    }
}

/// Returns the path of a pax header: records `length path=value`.
fn pax_path(text: &str) -> Option<String> {
    text.lines()
        .filter_map(|line| line.split_once(' '))
        .find_map(|(_, record)| record.strip_prefix("path=").map(ToString::to_string))
}

fn octal(field: &[u8]) -> Option<u64> {
    // GNU tar marks sizes beyond 8 GiB by a set high bit; no channel file has one.
    let text = std::str::from_utf8(field).ok()?;
    let text = text.trim_matches(['\0', ' ']);
    if text.is_empty() {
        return Some(0);
    }
    u64::from_str_radix(text, 8).ok()
}

fn checksum_fits(header: &[u8; BLOCK as usize]) -> bool {
    let sum: u64 = header
        .iter()
        .enumerate()
        .map(|(index, byte)| {
            // The field of the checksum itself counts as blanks.
            if (148..156).contains(&index) {
                32
            } else {
                u64::from(*byte)
            }
        })
        .sum();
    octal(&header[148..156]) == Some(sum)
}

fn too_many_entries(found: u64, limits: &Limits) -> Error {
    over(
        "archive_entries",
        limits.archive_entries,
        &format!("{found} entries"),
    )
}

fn over(limit: &'static str, value: u64, found: &str) -> Error {
    ErrorKind::LimitExceeded {
        limit,
        value,
        found: found.into(),
    }
    .into()
}

fn damaged(reason: &str) -> Error {
    ErrorKind::Malformed {
        expected: "an archive that unpacks".into(),
        found: reason.to_string(),
        hint: "the archive is damaged; fetch it again, or unpack it and name the folder".into(),
    }
    .into()
}
