//! The source of the bytes: a file, standard input or memory, hashed while it is read.
//!
//! A reader hashes all bytes that it hands out, those of files beside the recording included, so that the
//! hashes in a verdict are those of the very bytes that were judged. No other file of this crate opens a
//! file.

use super::Limits;
use crate::error::{Error, Place};
use latchgate_kernel::parallel::Control;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Prefix of the word of a pulse, which is name and content of a recording at once.
pub const PULSE_PREFIX: &str = "pulse:";

/// Bytes of the head from which a format is recognised.
const HEAD_BYTES: u64 = 4096;

/// A place to read a recording from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// A file or a folder.
    File(PathBuf),
    /// Standard input.
    Stdin,
    /// Bytes in memory.
    Memory(Memory),
}

/// Reads a file that is no recording, of at most the size of the named limit. Errors name the file `shown`
/// and the action, as in "read the design file".
///
/// # Errors
///
/// [`crate::error::ErrorKind::Io`] if it cannot be read, [`crate::error::ErrorKind::LimitExceeded`]
/// if it is larger.
pub fn read_within(
    path: &Path,
    shown: &str,
    action: &'static str,
    (limit, value): (&'static str, u64),
) -> Result<Vec<u8>, Error> {
    let bytes = start_of(path, value.saturating_add(1))
        .map_err(|error| Error::io(action, &error).at(Place::file(shown)))?;
    if bytes.len() as u64 > value {
        let error = Error::over(limit, value, "a larger file");
        return Err(error.at(Place::file(shown)));
    }
    Ok(bytes)
}

/// Reads up to `limit` bytes from the start of a file.
fn start_of(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A recording in memory: one file, or the files of a folder. Clones share the bytes.
#[derive(Clone, PartialEq, Eq)]
pub struct Memory {
    name: String,
    files: Arc<Files>,
    card: Option<Arc<[u8]>>,
}

/// Files by their name, with `/` between folder and file.
pub(super) type Files = BTreeMap<String, Arc<[u8]>>;

impl std::fmt::Debug for Memory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Memory")
            .field("name", &self.name)
            .field("files", &self.files.len())
            .field("card", &self.card.is_some())
            .finish()
    }
}

impl Source {
    /// Builds a source of one file in memory.
    ///
    /// # Examples
    ///
    /// ```
    /// use latchgate_recording::Source;
    ///
    /// let source = Source::bytes("crash.csv", *b"t_s,acc_y_g\n0,0\n")
    ///     .with_card(*b"opens_when = \"negative\"\n");
    /// assert_eq!(source.name(), "crash.csv");
    /// ```
    pub fn bytes(name: impl Into<String>, bytes: impl Into<Arc<[u8]>>) -> Self {
        let name = name.into();
        Self::files(name.clone(), [(name, bytes.into())])
    }

    /// Builds a source of a set of files in memory. `name` is the one to read, with the others beside it;
    /// if no file has that name, it is the name of the folder that they form. A file `name.toml` among them
    /// is the card.
    ///
    /// # Examples
    ///
    /// ```
    /// use latchgate_recording::Source;
    /// use std::sync::Arc;
    ///
    /// let parts: [(&str, Arc<[u8]>); 2] = [
    ///     ("test.mme", b"Test object 1 :car".as_slice().into()),
    ///     ("Channel/test.001", b"Channel code :11DOORLE0000ACYA".as_slice().into()),
    /// ];
    /// let package = Source::files("test", parts.map(|(name, bytes)| (name.to_string(), bytes)));
    /// assert_eq!(package.name(), "test");
    /// ```
    pub fn files(
        name: impl Into<String>,
        files: impl IntoIterator<Item = (String, Arc<[u8]>)>,
    ) -> Self {
        Self::Memory(Memory {
            name: name.into(),
            files: Arc::new(files.into_iter().collect()),
            card: None,
        })
    }

    /// Sets the card of a recording in memory, as one beside a file; a source on disk or from standard input
    /// is not changed.
    pub fn with_card(mut self, card: impl Into<Arc<[u8]>>) -> Self {
        if let Self::Memory(memory) = &mut self {
            memory.card = Some(card.into());
        }
        self
    }

    /// Returns the file name without folders; `-` for standard input.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.file_name().map_or_else(
                || path.display().to_string(),
                |name| name.to_string_lossy().into_owned(),
            ),
            Self::Stdin => "-".into(),
            Self::Memory(memory) => match memory.name.rsplit_once('/') {
                Some((_, file)) if !memory.name.starts_with(PULSE_PREFIX) => file.to_string(),
                _ => memory.name.clone(),
            },
        }
    }

    /// Returns the bytes of the card beside the recording, at most `limit` of them; `None` if there is none.
    /// Standard input has none.
    pub(super) fn read_card(&self, limit: u64) -> Result<Option<Vec<u8>>, Error> {
        let path = match self {
            Self::Stdin => return Ok(None),
            Self::Memory(memory) => {
                let length = usize::try_from(limit).unwrap_or(usize::MAX);
                let cut = |card: &Arc<[u8]>| card[..card.len().min(length)].to_vec();
                let listed = || memory.files.get(&format!("{}.toml", memory.name));
                return Ok(memory.card.as_ref().or_else(listed).map(cut));
            }
            Self::File(path) => path,
        };
        // A folder may be named with a slash at its end.
        let mut name = path.components().as_path().as_os_str().to_os_string();
        name.push(".toml");
        match start_of(Path::new(&name), limit) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) => match error.kind() {
                // A name that is too long for a file names none.
                io::ErrorKind::NotFound
                | io::ErrorKind::NotADirectory
                | io::ErrorKind::InvalidFilename => Ok(None),
                _ => Err(Error::io("read the card", &error)),
            },
        }
    }

    /// Returns the SHA-256 of a file that was refused before its end was read, if it exists and is no longer
    /// than `limit`: hashing a larger one would take too long.
    pub fn sha256_within(&self, limit: u64) -> Option<String> {
        let short = match self {
            Self::File(path) => std::fs::metadata(path)
                .is_ok_and(|metadata| metadata.is_file() && metadata.len() <= limit),
            Self::Stdin => false,
            Self::Memory(memory) => memory
                .files
                .get(&memory.name)
                .is_some_and(|bytes| bytes.len() as u64 <= limit),
        };
        short.then(|| self.open().ok()?.finish().ok()).flatten()
    }

    /// Opens the source. A folder opens as a reader without bytes of its own, whose files are
    /// reached with [`Reader::read_beside`].
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::Io`] if there is no such file, or it may not be read.
    pub fn open(&self) -> Result<Reader<'static>, Error> {
        self.open_watched(Control::default())
    }

    /// As [`Self::open`], for a reading that `control` can stop.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn open_watched<'a>(&self, control: Control<'a>) -> Result<Reader<'a>, Error> {
        let mut siblings = Siblings::files(Files::new());
        let mut is_folder = false;
        let mut size = None;
        let failed = |error: io::Error| Error::io("open the file", &error);
        let inner: Box<dyn Read> = match self {
            Self::File(path) => {
                let metadata = std::fs::metadata(path).map_err(failed)?;
                is_folder = metadata.is_dir();
                if is_folder {
                    siblings = Siblings::Folder(path.clone());
                    Box::new(io::empty())
                } else {
                    size = Some(metadata.len()).filter(|_| metadata.is_file());
                    if let Some(folder) = path.parent() {
                        siblings = Siblings::Folder(folder.to_path_buf());
                    }
                    Box::new(File::open(path).map_err(failed)?)
                }
            }
            Self::Stdin => Box::new(io::stdin()),
            Self::Memory(memory) => {
                let bytes = memory.files.get(&memory.name);
                is_folder = bytes.is_none();
                let above = memory.name.rfind('/').filter(|_| !is_folder);
                siblings = Siblings::Memory {
                    files: Arc::clone(&memory.files),
                    folder: memory.name[..above.map_or(0, |slash| slash + 1)].to_string(),
                };
                size = bytes.map(|bytes| bytes.len() as u64);
                Box::new(io::Cursor::new(bytes.cloned().unwrap_or_default()))
            }
        };
        Ok(Reader {
            inner,
            name: self.name(),
            siblings,
            is_folder,
            is_archive: false,
            size,
            parts: BTreeMap::new(),
            hasher: Sha256::new(),
            head: Vec::new(),
            consumed: 0,
            control,
        })
    }
}

/// The files that belong to a recording: those of its folder, or of the recording if it is a folder.
enum Siblings {
    /// In a folder.
    Folder(PathBuf),
    /// In memory, below a folder that is empty or ends with `/`.
    Memory { files: Arc<Files>, folder: String },
}

impl Siblings {
    fn files(files: Files) -> Self {
        Self::Memory {
            files: Arc::new(files),
            folder: String::new(),
        }
    }

    /// Lists the names of files in order, relative to the folder; if `deep`, with those in the
    /// folders one level down.
    fn list(&self, deep: bool, limits: &Limits) -> Result<Vec<String>, Error> {
        match self {
            Self::Folder(folder) => list_folder(folder, deep, limits),
            Self::Memory { files, folder } => {
                let depth = if deep { 1 } else { 0 };
                let names = files.keys().filter_map(|name| name.strip_prefix(&**folder));
                let names = names.filter(|name| name.matches('/').count() <= depth);
                let names: Vec<String> = names.map(String::from).collect();
                if names.len() as u64 > limits.archive_entries {
                    return Err(limits.over("archive_entries", MORE_FILES));
                }
                Ok(names)
            }
        }
    }

    /// Reads up to `limit` bytes of a file that is listed; `None` if there is no such file.
    fn read(&self, name: &str, limit: u64) -> Result<Option<Vec<u8>>, Error> {
        let folder = match self {
            Self::Memory { files, folder } => {
                let length = usize::try_from(limit).unwrap_or(usize::MAX);
                let bytes = files.get(&format!("{folder}{name}"));
                return Ok(bytes.map(|bytes| bytes[..bytes.len().min(length)].to_vec()));
            }
            Self::Folder(folder) => folder,
        };
        let path = folder.join(name);
        if !std::fs::metadata(&path).is_ok_and(|metadata| metadata.is_file()) {
            return Ok(None);
        }
        let bytes = start_of(&path, limit)
            .map_err(|error| Error::io("read the file", &error).at(Place::file(name)))?;
        Ok(Some(bytes))
    }
}

/// Another file that belongs to a recording and was read with it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// File name, relative to the recording's folder.
    pub file: String,
    /// SHA-256 of its bytes, lower-case hexadecimal.
    pub sha256: String,
}

/// A stream of a recording's bytes that hashes them as they pass.
pub struct Reader<'a> {
    inner: Box<dyn Read>,
    name: String,
    siblings: Siblings,
    is_folder: bool,
    is_archive: bool,
    /// Size in bytes, where it is known beforehand.
    size: Option<u64>,
    /// Hashes of the other files that were read.
    parts: BTreeMap<String, String>,
    hasher: Sha256,
    head: Vec<u8>,
    consumed: usize,
    /// The caller's wish to stop.
    control: Control<'a>,
}

impl Reader<'_> {
    /// Returns up to 4096 bytes from the start without consuming them.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::Io`] if reading fails.
    pub fn head(&mut self) -> Result<Vec<u8>, Error> {
        if self.head.is_empty() {
            let mut head = Vec::new();
            (&mut self.inner)
                .take(HEAD_BYTES)
                .read_to_end(&mut head)
                .map_err(|error| Error::io("read the file", &error))?;
            self.hasher.update(&head);
            self.head = head;
        }
        Ok(self.head.clone())
    }

    /// Reads the remaining bytes, up to `limit`.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::LimitExceeded`] at the byte beyond `limit`,
    /// [`crate::error::ErrorKind::Io`] if reading fails.
    pub fn read_all(&mut self, limit_name: &'static str, limit: u64) -> Result<Vec<u8>, Error> {
        self.read_checked(limit_name, limit, |_, _| Ok(()))
    }

    /// Reads the remaining bytes of a text within `text_bytes`, `line_bytes` and `lines`. Lines are measured as
    /// they arrive, so that one without an end is refused early.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::LimitExceeded`] at the byte where a limit is crossed,
    /// [`crate::error::ErrorKind::Io`] if reading fails.
    pub fn read_text(&mut self, limits: &Limits) -> Result<Vec<u8>, Error> {
        let head = self.head()?;
        // UTF-16 takes two bytes for a character.
        let wide = head.starts_with(b"\xFF\xFE") || head.starts_with(b"\xFE\xFF");
        let longest = limits.line_bytes.saturating_mul(if wide { 2 } else { 1 });
        let (mut line, mut start) = (1_u64, 0_u64);
        let too_long = |line: u64, byte: u64| {
            let place = Place::default().line(line).byte(byte);
            limits.over("line_bytes", "a longer line").at(place)
        };
        self.read_checked("text_bytes", limits.text_bytes, |offset, block| {
            // In a block without a line that is too long, the lines need only be counted.
            let feeds = memchr::memchr_iter(b'\n', block).count() as u64;
            if let Some(first) = memchr::memchr(b'\n', block)
                && let Some(last) = memchr::memrchr(b'\n', block)
                && offset + first as u64 - start <= longest
                && block.len() as u64 <= longest
                && line + feeds <= limits.lines
                && memchr::memchr(b'\r', block).is_none()
            {
                line += feeds;
                start = offset + last as u64 + 1;
                return Ok(());
            }
            for position in memchr::memchr2_iter(b'\n', b'\r', block) {
                let end = offset + position as u64;
                if end - start > longest {
                    return Err(too_long(line, start + longest));
                }
                start = end + 1;
                // A carriage return before a line feed counts with it, give or take one at the
                // border of two blocks.
                let pair = block[position] == b'\r' && block.get(position + 1) == Some(&b'\n');
                line += u64::from(!pair);
                if line > limits.lines.saturating_add(1) {
                    let place = Place::default().line(line).byte(end);
                    return Err(limits.over("lines", "more lines").at(place));
                }
            }
            if offset + block.len() as u64 - start > longest {
                return Err(too_long(line, start + longest));
            }
            Ok(())
        })
    }

    /// Reads the remaining bytes block by block; `check` sees each block with its offset.
    fn read_checked(
        &mut self,
        limit_name: &'static str,
        limit: u64,
        mut check: impl FnMut(u64, &[u8]) -> Result<(), Error>,
    ) -> Result<Vec<u8>, Error> {
        const BLOCK: u64 = 1 << 20;
        let crossed =
            || Error::over(limit_name, limit, "more bytes").at(Place::default().byte(limit));
        if self.size.is_some_and(|size| size > limit) {
            return Err(crossed());
        }
        let mut bytes = Vec::new();
        if let Some(size) = self.size {
            bytes.reserve_exact(usize::try_from(size).unwrap_or(0) + 1);
        }
        loop {
            let length_before = bytes.len();
            let count = self
                .by_ref()
                .take(BLOCK)
                .read_to_end(&mut bytes)
                .map_err(|error| Error::io("read the file", &error))?;
            self.control.check()?;
            if bytes.len() as u64 > limit {
                return Err(crossed());
            }
            check(length_before as u64, &bytes[length_before..])?;
            if count == 0 {
                return Ok(bytes);
            }
        }
    }

    /// Returns the recording's file name without folders.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// True if the recording is a folder.
    pub fn is_folder(&self) -> bool {
        self.is_folder
    }

    /// True if the recording is an archive that was unpacked.
    pub fn is_archive(&self) -> bool {
        self.is_archive
    }

    /// Lists, in order, the files beside the recording, or those in it if it is a folder or an
    /// archive; if `deep`, with those in the folders one level down, of an archive in all. Names are relative, with `/` between
    /// folder and file. Standard input has none.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::Io`] if a folder cannot be listed,
    /// [`crate::error::ErrorKind::LimitExceeded`] beyond `limits.archive_entries`.
    pub fn list(&self, deep: bool, limits: &Limits) -> Result<Vec<String>, Error> {
        match &self.siblings {
            Siblings::Memory { files, .. } if self.is_archive && deep => {
                Ok(files.keys().cloned().collect())
            }
            siblings => siblings.list(deep, limits),
        }
    }

    /// Reads a file that [`Self::list`] names, of at most `limits.text_bytes`, and notes it as
    /// part of the recording. `None` if there is no such file.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::LimitExceeded`] beyond the limit, [`crate::error::ErrorKind::Io`]
    /// if reading fails.
    pub fn read_beside(&mut self, name: &str, limits: &Limits) -> Result<Option<Vec<u8>>, Error> {
        let Some(bytes) = self.read_head_of(name, limits.text_bytes.saturating_add(1))? else {
            return Ok(None);
        };
        if bytes.len() as u64 > limits.text_bytes {
            let place = Place::file(name).byte(limits.text_bytes);
            return Err(limits.over("text_bytes", "more bytes").at(place));
        }
        self.parts.insert(name.to_string(), sha256(&bytes));
        Ok(Some(bytes))
    }

    /// Replaces the files beside the recording by those of the archive that the recording is; they are not
    /// separate parts of it.
    pub(super) fn set_siblings(&mut self, files: Files) {
        self.siblings = Siblings::files(files);
        self.is_archive = true;
    }

    /// Reads up to `limit` bytes from the start of a file that [`Self::list`] names, to recognise it. `None`
    /// if there is no such file.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::Io`] if reading fails.
    pub fn read_head_of(&self, name: &str, limit: u64) -> Result<Option<Vec<u8>>, Error> {
        self.siblings.read(name, limit)
    }

    /// Reads to the end and returns the hashes of all bytes that were read.
    pub(super) fn finish_hashes(mut self) -> Result<Hashes, Error> {
        let parts = std::mem::take(&mut self.parts);
        let content = (!self.is_folder).then(|| self.finish()).transpose()?;
        Ok(Hashes { content, parts })
    }

    /// Reads to the end and returns the SHA-256 of all bytes, lower-case hexadecimal.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::Io`] if reading fails.
    pub fn finish(mut self) -> Result<String, Error> {
        self.head()?;
        io::copy(&mut self, &mut io::sink()).map_err(|error| Error::io("read the file", &error))?;
        Ok(hexadecimal(&self.hasher.finalize()))
    }
}

/// Hashes of a recording and of the other files that were read with it.
pub(super) struct Hashes {
    /// Hash of the recording's bytes; `None` for a folder.
    content: Option<String>,
    parts: BTreeMap<String, String>,
}

impl Hashes {
    /// Returns the SHA-256 of the recording with those `parts`, lower-case hexadecimal, and the parts. The
    /// hash of a folder is that of a list of its files that were read: hash, two blanks, name and line feed
    /// each.
    pub(super) fn with_parts(&self, parts: &BTreeSet<String>) -> (String, Vec<Part>) {
        let part = |file: &String| {
            let (file, sha256) = (file.clone(), self.parts.get(file)?.clone());
            Some(Part { file, sha256 })
        };
        let parts: Vec<Part> = parts.iter().filter_map(part).collect();
        let listed = || {
            let line = |part: &Part| format!("{}  {}\n", part.sha256, part.file);
            sha256(parts.iter().map(line).collect::<String>().as_bytes())
        };
        (self.content.clone().unwrap_or_else(listed), parts)
    }
}

impl Read for Reader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.consumed < self.head.len() {
            let head_left = &self.head[self.consumed..];
            let count = head_left.len().min(buffer.len());
            buffer[..count].copy_from_slice(&head_left[..count]);
            self.consumed += count;
            return Ok(count);
        }
        let count = self.inner.read(buffer)?;
        if self.control.check().is_err() {
            return Err(io::Error::other("the reading was stopped"));
        }
        self.hasher.update(&buffer[..count]);
        Ok(count)
    }
}

/// Returns the SHA-256 of `bytes`, lower-case hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Text of the error where a folder crosses a limit.
const MORE_FILES: &str = "a folder of more files";

fn list_folder(folder: &Path, deep: bool, limits: &Limits) -> Result<Vec<String>, Error> {
    let is_current = folder.as_os_str().is_empty();
    let folder = if is_current { Path::new(".") } else { folder };
    let (mut names, mut entries) = (Vec::new(), 0);
    list_into(&mut names, folder, "", deep, &mut entries, limits)?;
    names.sort();
    Ok(names)
}

/// Lists the files of a folder, each after `prefix`; if `deep`, with those in its folders.
fn list_into(
    names: &mut Vec<String>,
    folder: &Path,
    prefix: &str,
    deep: bool,
    entries: &mut u64,
    limits: &Limits,
) -> Result<(), Error> {
    let failed = |error: io::Error| Error::io("list the folder", &error);
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        *entries += 1;
        if *entries > limits.archive_entries {
            return Err(limits.over("archive_entries", MORE_FILES));
        }
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            continue;
        };
        let name = format!("{prefix}{name}");
        match path.is_dir() {
            false => names.push(name),
            true if deep => {
                list_into(names, &path, &format!("{name}/"), false, entries, limits)?;
            }
            true => {}
        }
    }
    Ok(())
}

pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
