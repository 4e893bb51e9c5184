//! Blobs as files of a folder, each named by its hash: written, synced, renamed, the folder synced.

use super::sum::{Hex, sha256_of};
use super::{Blobs, Collected, Free, StoreError, StoredFile};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::SystemTime;

/// A folder of blobs.
#[derive(Debug)]
pub struct BlobFolder {
    root: PathBuf,
    next: AtomicU64,
    /// Locked while a blob is renamed into place or removed, so that a blob that is kept again at the
    /// same time is not lost.
    moving: Arc<Mutex<()>>,
    placing: RwLock<()>,
    /// Bytes of all blobs.
    stored: Arc<AtomicI64>,
}

impl BlobFolder {
    /// Opens a folder of blobs, made if absent; unfinished blobs of an earlier process are removed, and the bytes of
    /// the others counted.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if it cannot be made or read.
    pub fn open(root: &Path) -> Result<Self, StoreError> {
        let unfinished = root.join("unfinished");
        fs::create_dir_all(&unfinished)?;
        for entry in fs::read_dir(&unfinished)? {
            fs::remove_file(entry?.path())?;
        }
        sync_folder(root)?;
        let folder = Self::beside(root);
        let mut bytes = 0;
        for place in folder.places()? {
            for entry in fs::read_dir(place)? {
                bytes += length_of(&entry?.path());
            }
        }
        folder.stored.store(bytes, Ordering::Relaxed);
        Ok(folder)
    }

    /// Lists the folders that hold blobs.
    fn places(&self) -> Result<Vec<PathBuf>, StoreError> {
        let mut places = Vec::new();
        for entry in fs::read_dir(&self.root)? {
            let place = entry?.path();
            if !place.ends_with("unfinished") && place.is_dir() {
                places.push(place);
            }
        }
        Ok(places)
    }

    /// Opens a folder of blobs to read, in which another process may work.
    pub fn beside(root: &Path) -> Self {
        Self {
            root: root.to_path_buf(),
            next: AtomicU64::new(0),
            moving: Arc::default(),
            placing: RwLock::default(),
            stored: Arc::default(),
        }
    }

    /// Returns the path of a blob.
    pub fn path(&self, sha256: &str) -> PathBuf {
        let head = sha256.get(..2).unwrap_or("xx");
        self.root.join(head).join(sha256)
    }
}

impl Blobs for BlobFolder {
    fn begin(&self) -> Result<BlobWriter, StoreError> {
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        let name = format!("{}-{number}", std::process::id());
        let path = self.root.join("unfinished").join(name);
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&path)?;
        Ok(BlobWriter {
            root: self.root.clone(),
            moving: Arc::clone(&self.moving),
            stored: Arc::clone(&self.stored),
            path,
            file: Some(file),
            hash: Sha256::new(),
            bytes: 0,
        })
    }

    fn open(&self, sha256: &str) -> Result<File, StoreError> {
        let damaged = || StoreError::Damaged {
            what: format!("blob {sha256}"),
        };
        if sha256.len() != 64 || !sha256.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return Err(damaged());
        }
        let mut file = File::open(self.path(sha256)).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => damaged(),
            _ => error.into(),
        })?;
        if sha256_of(&mut file)? != sha256 {
            return Err(damaged());
        }
        file.seek(SeekFrom::Start(0))?;
        Ok(file)
    }

    fn placing(&self) -> &RwLock<()> {
        &self.placing
    }

    fn remove(&self, sha256: &str) -> Result<(), StoreError> {
        let path = self.path(sha256);
        let _moving = locked(&self.moving);
        let bytes = length_of(&path);
        match fs::remove_file(&path) {
            Ok(()) => {
                self.stored.fetch_sub(bytes, Ordering::Relaxed);
                path.parent().map_or(Ok(()), sync_folder)
            }
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    fn stored_bytes(&self) -> u64 {
        let stored = self.stored.load(Ordering::Relaxed);
        u64::try_from(stored).unwrap_or(0)
    }

    fn free(&self) -> Result<Free, StoreError> {
        let space = rustix::fs::statvfs(&self.root).map_err(std::io::Error::from)?;
        Ok(Free {
            bytes: space.f_bavail.saturating_mul(space.f_frsize),
            files: (space.f_files > 0).then_some(space.f_favail),
        })
    }

    fn collect(
        &self,
        named: &BTreeSet<String>,
        before: SystemTime,
    ) -> Result<Collected, StoreError> {
        let mut collected = Collected::default();
        let began = SystemTime::now();
        let (before_bytes, mut found_bytes) = (self.stored.load(Ordering::Relaxed), 0);
        for folder in self.places()? {
            for entry in fs::read_dir(&folder)? {
                let entry = entry?;
                let name = entry.file_name();
                let is_named = name.to_str().is_none_or(|name| named.contains(name));
                // What came since this look began was counted as it came.
                let is_counted = |metadata: &fs::Metadata| {
                    metadata.modified().is_ok_and(|modified| modified > began)
                };
                if is_named {
                    let metadata = entry.metadata().ok();
                    let uncounted = metadata.filter(|metadata| !is_counted(metadata));
                    found_bytes += uncounted.map_or(0, |metadata| metadata.len() as i64);
                    continue;
                }
                let _moving = locked(&self.moving);
                let metadata = match entry.metadata() {
                    Ok(metadata) => metadata,
                    Err(error) if error.kind() == ErrorKind::NotFound => continue,
                    Err(error) => return Err(error.into()),
                };
                if metadata.is_file() && metadata.modified()? < before {
                    fs::remove_file(entry.path())?;
                    collected.files += 1;
                    collected.bytes += metadata.len();
                } else if !is_counted(&metadata) {
                    found_bytes += metadata.len() as i64;
                }
            }
        }
        self.stored
            .fetch_add(found_bytes - before_bytes, Ordering::Relaxed);
        Ok(collected)
    }
}

/// A blob that is being written; a drop before its end removes it.
#[derive(Debug)]
pub struct BlobWriter {
    root: PathBuf,
    moving: Arc<Mutex<()>>,
    stored: Arc<AtomicI64>,
    path: PathBuf,
    file: Option<File>,
    hash: Sha256,
    bytes: u64,
}

impl BlobWriter {
    /// Adds bytes.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if they cannot be written.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        if let Some(file) = &mut self.file {
            file.write_all(bytes)?;
        }
        self.hash.update(bytes);
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// Returns the number of bytes that were written.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Syncs the bytes to the disk and closes the file, which is not in its place yet.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if it cannot be synced.
    pub fn close(&mut self) -> Result<(), StoreError> {
        if let Some(file) = self.file.take() {
            file.sync_all()?;
        }
        Ok(())
    }

    /// Puts the blob in its place, and returns once that is on the disk.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if it cannot be synced or renamed.
    pub fn finish(mut self, name: &str) -> Result<StoredFile, StoreError> {
        self.close()?;
        let sha256 = Hex(&std::mem::take(&mut self.hash).finalize()).to_string();
        let folder = self.root.join(&sha256[..2]);
        if !folder.is_dir() {
            fs::create_dir_all(&folder)?;
            sync_folder(&self.root)?;
        }
        // A blob that exists already is replaced: it may be damaged, and these bytes are not.
        {
            let _moving = locked(&self.moving);
            // Its age decides if `collect` may remove it, so it begins now, not with the upload.
            File::open(&self.path)?.set_modified(SystemTime::now())?;
            let place = folder.join(&sha256);
            let replaced_bytes = length_of(&place);
            fs::rename(&self.path, place)?;
            let more = i64::try_from(self.bytes).unwrap_or(i64::MAX) - replaced_bytes;
            self.stored.fetch_add(more, Ordering::Relaxed);
        }
        sync_folder(&folder)?;
        Ok(StoredFile {
            name: name.into(),
            sha256,
            bytes: self.bytes,
        })
    }
}

impl Drop for BlobWriter {
    fn drop(&mut self) {
        // After `finish` the file has another name, and this does nothing.
        let _ = fs::remove_file(&self.path);
    }
}

fn locked(moving: &Mutex<()>) -> MutexGuard<'_, ()> {
    moving.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the length of a file; 0 if there is none.
fn length_of(path: &Path) -> i64 {
    let length = fs::metadata(path).map_or(0, |metadata| metadata.len());
    i64::try_from(length).unwrap_or(i64::MAX)
}

fn sync_folder(path: &Path) -> Result<(), StoreError> {
    File::open(path)?.sync_all()?;
    Ok(())
}
