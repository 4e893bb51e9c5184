//! Archives: .zip, .tar.gz and .tar, unpacked within limits.
//!
//! The files of a test, ISO-MME or NHTSA, or the parts of a workbook are kept in memory; all others
//! are skipped. An archive that unpacks to more than a limit, or to far more than its size, ends the
//! reading there.

use super::mme::names::{has_suffix, is_channel_file, is_shadow, is_test_file};
use super::source::Files;
use super::{Limits, text, workbook};
use crate::error::{Error, ErrorKind, Place};
use std::io::{self, Cursor, Read};

/// Bytes unpacked before the ratio counts: a small archive of a smooth signal may well shrink a lot.
const RATIO_FROM: u64 = 4 << 20;

/// Bytes of a tar header; parts are padded to a multiple of it.
const BLOCK: u64 = 512;

/// Longest entry of a tar archive that describes the next one [byte].
const DESCRIPTION: u64 = 16 << 10;

const UNPACK: &str = "unpack it and name the recording, or export the channel as CSV";

/// True if the head is that of a .zip, a gzip file or a .tar.
pub(super) fn is_archive(head: &[u8]) -> bool {
    is_zip(head) || is_gzip(head) || head.get(257..262) == Some(b"ustar")
}

fn is_zip(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06")
}

fn is_gzip(head: &[u8]) -> bool {
    head.starts_with(b"\x1F\x8B")
}

/// True if a file may be one of a test (header, list, channel or curve) or of a workbook.
fn is_part(name: &str) -> bool {
    let is_iso_mme = is_test_file(name) || is_channel_file(name);
    let is_nhtsa = has_suffix(name, "ev5") || has_suffix(name, "tsv");
    (is_iso_mme || is_nhtsa || workbook::is_part(name)) && !is_shadow(name)
}

/// True if a file shows that the archive is one of a test, or a workbook.
fn shows_recording(name: &str) -> bool {
    is_channel_file(name) || has_suffix(name, "ev5") || workbook::is_main_part(name)
}

/// Unpacks the files of a test, or of a workbook.
pub(super) fn unpack(name: &str, bytes: Vec<u8>, limits: &Limits) -> Result<Files, Error> {
    let mut unpacker = Unpacker::new(name, bytes.len() as u64, limits);
    let (format, way_out) = if is_zip(&bytes) {
        let office_format = unpacker.unzip(bytes)?;
        office_format.unwrap_or(("a .zip that holds no ISO-MME test and no .EV5", UNPACK))
    } else if is_gzip(&bytes) {
        match unpacker.untar(&mut flate2::read::MultiGzDecoder::new(Cursor::new(bytes)))? {
            true => ("a .tar.gz that holds no ISO-MME test and no .EV5", UNPACK),
            false => ("a gzip file", "unpack it first"),
        }
    } else {
        unpacker.untar(&mut Cursor::new(bytes))?;
        ("a .tar that holds no ISO-MME test and no .EV5", UNPACK)
    };
    if unpacker.files.keys().any(|name| shows_recording(name)) {
        return Ok(unpacker.files);
    }
    Err(ErrorKind::RefusedFormat { format, way_out }.into())
}

/// Unpacks files until a limit is reached.
struct Unpacker<'a> {
    /// Name of the archive.
    name: &'a str,
    files: Files,
    limits: &'a Limits,
    /// Bytes that may still be unpacked, and the limit that bounds them.
    bytes_left: u64,
    limit: (&'static str, u64),
    /// Bytes unpacked.
    unpacked: u64,
    /// Bytes kept in memory.
    kept: u64,
    entries: u64,
}

impl<'a> Unpacker<'a> {
    /// Prepares to unpack an archive of so many bytes.
    fn new(name: &'a str, packed: u64, limits: &'a Limits) -> Self {
        let by_ratio = packed.saturating_mul(limits.unpacked_ratio).max(RATIO_FROM);
        let stream_limit = limits.unpacked_stream_bytes;
        let (bytes_left, limit) = match by_ratio < stream_limit {
            true => (by_ratio, ("unpacked_ratio", limits.unpacked_ratio)),
            false => (stream_limit, ("unpacked_stream_bytes", stream_limit)),
        };
        Self {
            name,
            files: Files::new(),
            limits,
            bytes_left,
            limit,
            unpacked: 0,
            kept: 0,
            entries: 0,
        }
    }

    /// Counts unpacked bytes.
    fn spend(&mut self, count: u64) -> Result<(), Error> {
        self.unpacked += count;
        self.bytes_left = self.bytes_left.checked_sub(count).ok_or_else(|| {
            let place = Place::default().byte(self.unpacked);
            Error::over(self.limit.0, self.limit.1, "more bytes after unpacking").at(place)
        })?;
        Ok(())
    }

    /// Reads up to `limit` bytes.
    fn read(&mut self, from: &mut dyn Read, limit: u64) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        let room = limit.min(self.bytes_left.saturating_add(1));
        from.take(room)
            .read_to_end(&mut bytes)
            .map_err(|error| damaged(error.to_string()))?;
        self.spend(bytes.len() as u64)?;
        Ok(bytes)
    }

    /// Counts an entry.
    fn enter(&mut self) -> Result<(), Error> {
        self.entries += 1;
        if self.entries > self.limits.archive_entries {
            return Err(self.limits.over("archive_entries", "more entries"));
        }
        Ok(())
    }

    /// Keeps a file of the test, of `limit` bytes at most.
    fn keep(&mut self, name: String, from: &mut dyn Read, limit: u64) -> Result<u64, Error> {
        let total_limit = self.limits.unpacked_bytes;
        let room = total_limit.saturating_sub(self.kept).saturating_add(1);
        let place = Place::file(format!("{}: {name}", self.name));
        let read = self.read(from, limit.min(room));
        let bytes = read.map_err(|error| error.at(place.clone()))?;
        let count = bytes.len() as u64;
        self.kept += count;
        if self.kept > total_limit {
            let found = "more bytes in the files of the test together";
            let error = self.limits.over("unpacked_bytes", found);
            return Err(error.at(place.byte(self.unpacked)));
        }
        if self.files.insert(name.clone(), bytes.into()).is_some() {
            return Err(twice(&name));
        }
        Ok(count)
    }

    /// Unpacks a zip; returns name and remedy where it is a file of an office program.
    fn unzip(&mut self, bytes: Vec<u8>) -> Result<Option<(&'static str, &'static str)>, Error> {
        // The zip reader allocates memory for each entry at once, so they are counted first.
        for _ in memchr::memmem::find_iter(&bytes, b"PK\x01\x02") {
            self.enter()?;
        }
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|_| {
            Error::from(ErrorKind::RefusedFormat {
                format: "a zip container (.xlsx or an archive) that does not open",
                way_out: "if it is a sheet, save the sheet as CSV; if it is a test, fetch it again",
            })
        })?;
        if archive.has_duplicate_names() {
            return Err(twice("a file"));
        }
        let (mut first, mut office_format) = (u64::MAX, None);
        for index in 0..archive.len() {
            let entry = archive.by_index_raw(index).map_err(not_unzipped)?;
            first = first.min(entry.header_start());
            let plain = [
                zip::CompressionMethod::Stored,
                zip::CompressionMethod::Deflated,
            ];
            let packed_plainly = !entry.encrypted() && plain.contains(&entry.compression());
            // Some programs for Windows write its own mark between folder and file.
            let Ok(name) = entry.name().map(|name| name.replace('\\', "/")) else {
                continue;
            };
            drop(entry);
            office_format = office_format.max(office_file(&name));
            if !is_part(&name) {
                continue;
            }
            if !packed_plainly {
                return Err(ErrorKind::RefusedFormat {
                    format: "a .zip that is encrypted, or packed in an unknown way",
                    way_out: "unpack it and name the folder",
                }
                .into());
            }
            let mut entry = archive.by_index(index).map_err(not_unzipped)?;
            self.keep(name, &mut entry, u64::MAX)?;
        }
        // A zip begins with a file. Bytes before the first one that is listed are from another archive, or
        // from one that this one has replaced.
        if archive.offset() > 0 || (first > 0 && !archive.is_empty()) {
            return Err(Error::malformed(
                "one zip archive, from the first byte on",
                "files before those in its list, as if two archives were joined",
                "pack the test again",
            ));
        }
        Ok(office_format.map(|(_, format, way_out)| (format, way_out)))
    }

    /// Unpacks a tar stream; false if it is none.
    fn untar(&mut self, stream: &mut dyn Read) -> Result<bool, Error> {
        loop {
            let read = self.read(stream, BLOCK);
            // A stream that does not unpack a single block is no tar, unless a limit was crossed.
            let is_limit = |error: &Error| matches!(error.kind(), ErrorKind::LimitExceeded { .. });
            if self.entries == 0 && read.as_ref().is_err_and(|error| !is_limit(error)) {
                return Ok(false);
            }
            let header = read?;
            let is_end = header.iter().all(|byte| *byte == 0);
            let is_whole = header.len() as u64 == BLOCK;
            if self.entries == 0 && (is_end || !is_whole || !checksum_fits(&header)) {
                return Ok(false);
            }
            if !is_whole {
                return Err(cut());
            }
            if is_end {
                // Reading to the end lets the decompressor verify its checksums.
                while let block = self.read(stream, 1 << 16)?
                    && !block.is_empty()
                {
                    if block.iter().any(|byte| *byte != 0) {
                        return Err(damaged("more data after the end of the tar archive"));
                    }
                }
                return Ok(true);
            }
            let size = octal(&header[124..136]).filter(|_| checksum_fits(&header));
            let size = size.ok_or_else(|| damaged("a tar header whose checksum is wrong"))?;
            self.enter()?;
            self.entry(&header, size, stream)?;
        }
    }

    /// Reads or skips one entry of a tar archive.
    fn entry(&mut self, header: &[u8], size: u64, stream: &mut dyn Read) -> Result<(), Error> {
        let name = name_of(header);
        let read_bytes = match header[156] {
            b'0' | 0 | b'7' if is_part(&name) => self.keep(name, stream, size)?,
            // An entry that describes the next one, such as its time, must not rename it.
            b'x' | b'g' if size <= DESCRIPTION => {
                let bytes = self.read(stream, size)?;
                if memchr::memmem::find(&bytes, b"path=").is_some() {
                    return Err(odd_entry(&name));
                }
                bytes.len() as u64
            }
            b'0' | 0 | b'7' | b'5' => 0,
            kind if is_part(&name) || !matches!(kind, b'1'..=b'6') => {
                return Err(odd_entry(&name));
            }
            _ => 0,
        };
        let bytes_left = size.saturating_sub(read_bytes) + (BLOCK - size % BLOCK) % BLOCK;
        let room = bytes_left.min(self.bytes_left.saturating_add(1));
        let passed = io::copy(&mut stream.take(room), &mut io::sink())
            .map_err(|error| damaged(error.to_string()))?;
        self.spend(passed)?;
        if passed < bytes_left {
            Err(cut())
        } else {
            Ok(())
        }
    }
}

/// Recognises a file of an office program by a file in it: rank, name and remedy; the surest has the
/// highest rank.
fn office_file(name: &str) -> Option<(u8, &'static str, &'static str)> {
    match name {
        "xl/workbook.bin" => Some((3, "Excel, binary (.xlsb)", "save it as .xlsx")),
        "content.xml" => {
            let way_out = "save the sheet as .xlsx or CSV";
            Some((2, "OpenDocument (.ods)", way_out))
        }
        "[Content_Types].xml" => {
            let way_out = "save the table as .xlsx or CSV";
            Some((1, "a file of Office without a workbook", way_out))
        }
        _ => None,
    }
}

fn name_of(header: &[u8]) -> String {
    let text = |bytes: &[u8]| {
        let end = bytes.iter().position(|byte| *byte == 0);
        String::from_utf8_lossy(&bytes[..end.unwrap_or(bytes.len())]).into_owned()
    };
    let (name, prefix) = (text(&header[..100]), text(&header[345..500]));
    let name = match &header[257..262] {
        b"ustar" if !prefix.is_empty() => format!("{prefix}/{name}"),
        _ => name,
    };
    name.trim_start_matches("./").to_string()
}

fn octal(field: &[u8]) -> Option<u64> {
    // GNU tar marks sizes beyond 8 GiB by a set high bit; no channel file has one.
    let text = std::str::from_utf8(field).ok()?.trim_matches(['\0', ' ']);
    if text.is_empty() {
        return Some(0);
    }
    u64::from_str_radix(text, 8).ok()
}

fn checksum_fits(header: &[u8]) -> bool {
    // The field of the checksum itself counts as blanks.
    let counted = header.iter().enumerate().map(|(index, byte)| match index {
        148..156 => 32,
        _ => u64::from(*byte),
    });
    octal(&header[148..156]) == Some(counted.sum())
}

fn not_unzipped(error: zip::result::ZipError) -> Error {
    damaged(error.to_string())
}

fn odd_entry(name: &str) -> Error {
    Error::malformed(
        "the test's files in the archive, under short names",
        format!("{} as a link or another kind of entry", text::shown(name)),
        "unpack the archive and name the folder, or pack it without links",
    )
}

fn twice(name: &str) -> Error {
    Error::malformed(
        "each file once in the archive",
        format!("{} twice", text::shown(name)),
        "pack the test again with one of the two",
    )
}

fn cut() -> Error {
    Error::truncated(
        "the rest of the archive, up to the block of zeros that ends it",
        "the archive's end",
    )
}

fn damaged(reason: impl Into<String>) -> Error {
    Error::malformed(
        "an archive that unpacks",
        reason,
        "the archive is damaged; fetch it again, or unpack it and name the folder",
    )
}
