//! Where the bytes come from: a file or standard input, hashed while they are read.

use crate::error::{Error, ErrorKind};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Bytes of the head from which a format is recognised.
const HEAD_BYTES: u64 = 4096;

/// A place to read a recording from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// A file.
    File(PathBuf),
    /// Standard input.
    Stdin,
    /// Bytes in memory, with a name.
    Bytes {
        /// The name for messages and reports.
        name: String,
        /// The content.
        bytes: Vec<u8>,
    },
}

impl Source {
    /// Takes `-` for standard input, anything else for a path.
    #[must_use]
    pub fn from_argument(argument: &str) -> Self {
        if argument == "-" {
            Self::Stdin
        } else {
            Self::File(PathBuf::from(argument))
        }
    }

    /// Returns the file name without folders; `-` for standard input.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.file_name().map_or_else(
                || path.display().to_string(),
                |name| name.to_string_lossy().into_owned(),
            ),
            Self::Stdin => "-".into(),
            Self::Bytes { name, .. } => name.clone(),
        }
    }

    /// Returns the path, if it is a file.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Stdin | Self::Bytes { .. } => None,
        }
    }

    /// Returns a source that can be opened twice: standard input is read into memory, up to
    /// the limit of a text recording.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::LimitExceeded`] beyond the limit, [`ErrorKind::Io`] if reading fails.
    pub fn held_in_memory(self, limits: &super::Limits) -> Result<Self, Error> {
        match self {
            Self::Stdin => Ok(Self::Bytes {
                name: self.name(),
                bytes: self.open()?.read_all("text_bytes", limits.text_bytes)?,
            }),
            other => Ok(other),
        }
    }

    /// Opens the source.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if there is no such file, it is a folder, or it may not be read.
    pub fn open(&self) -> Result<Reader, Error> {
        let inner: Box<dyn Read> = match self {
            Self::File(path) => {
                let metadata =
                    std::fs::metadata(path).map_err(|error| io_error("open the file", &error))?;
                if metadata.is_dir() {
                    return Err(ErrorKind::Io {
                        action: "read the recording",
                        reason: "it is a folder; name a file in it".into(),
                    }
                    .into());
                }
                Box::new(File::open(path).map_err(|error| io_error("open the file", &error))?)
            }
            Self::Stdin => Box::new(io::stdin()),
            Self::Bytes { bytes, .. } => Box::new(io::Cursor::new(bytes.clone())),
        };
        Ok(Reader {
            inner,
            hasher: Sha256::new(),
            head: Vec::new(),
            consumed: 0,
        })
    }
}

/// A stream of a recording's bytes that hashes what passes.
pub struct Reader {
    inner: Box<dyn Read>,
    hasher: Sha256,
    head: Vec<u8>,
    consumed: usize,
}

impl std::fmt::Debug for Reader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Reader")
            .field("consumed", &self.consumed)
            .finish_non_exhaustive()
    }
}

impl Reader {
    /// Returns up to 4096 bytes from the start without consuming them.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if reading fails.
    pub fn head(&mut self) -> Result<Vec<u8>, Error> {
        if self.head.is_empty() {
            let mut head = Vec::new();
            (&mut self.inner)
                .take(HEAD_BYTES)
                .read_to_end(&mut head)
                .map_err(|error| io_error("read the file", &error))?;
            self.hasher.update(&head);
            self.head = head;
        }
        Ok(self.head.clone())
    }

    /// Reads what is left, up to `limit` bytes.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::LimitExceeded`] beyond `limit`, [`ErrorKind::Io`] if reading fails.
    pub fn read_all(&mut self, limit_name: &'static str, limit: u64) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        self.take(limit.saturating_add(1))
            .read_to_end(&mut bytes)
            .map_err(|error| io_error("read the file", &error))?;
        if bytes.len() as u64 > limit {
            return Err(ErrorKind::LimitExceeded {
                limit: limit_name,
                value: limit,
                found: "more bytes".into(),
            }
            .into());
        }
        Ok(bytes)
    }

    /// Reads to the end and returns the SHA-256 of all bytes, lower-case hexadecimal.
    ///
    /// # Errors
    ///
    /// [`ErrorKind::Io`] if reading fails.
    pub fn finish(mut self) -> Result<String, Error> {
        self.head()?;
        io::copy(&mut self, &mut io::sink()).map_err(|error| io_error("read the file", &error))?;
        Ok(hexadecimal(&self.hasher.finalize()))
    }
}

impl Read for Reader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.consumed < self.head.len() {
            let left = &self.head[self.consumed..];
            let count = left.len().min(buffer.len());
            buffer[..count].copy_from_slice(&left[..count]);
            self.consumed += count;
            return Ok(count);
        }
        let count = self.inner.read(buffer)?;
        self.hasher.update(&buffer[..count]);
        Ok(count)
    }
}

/// Returns the SHA-256 of `bytes`, lower-case hexadecimal.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn io_error(action: &'static str, error: &io::Error) -> Error {
    ErrorKind::Io {
        action,
        reason: error.to_string(),
    }
    .into()
}
