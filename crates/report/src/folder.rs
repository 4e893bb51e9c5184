//! A report's folder: its name, and that it holds the earlier report, the new one or none, never
//! parts of both.

use latchgate_recording::error::Error;
use serde::Deserialize;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// File name of the verdict.
pub const VERDICT_FILE: &str = "verdict.json";

/// File name of the document of a margin.
pub const MARGIN_FILE: &str = "margin.json";

/// File name of the document of a static calculation.
pub const STATIC_FILE: &str = "static.json";

/// File name of the document of latch response spectra.
pub const SPECTRUM_FILE: &str = "spectrum.json";

/// File name of the page of several verdicts.
pub const COMPARE_FILE: &str = "compare.html";

/// Title of that page.
pub(crate) const COMPARE_TITLE: &str = "Verdicts compared · latchgate";

/// Attempts to put a report in its place while other processes put theirs there.
const ATTEMPTS: u32 = 100;

/// Step that an error names where a folder cannot be made.
const MAKE: &str = "make the report folder";

/// Number of the next temporary folder of this process.
static NEXT: AtomicU32 = AtomicU32::new(0);

/// Returns the name of a report's folder, `<recording>-<design>-<id>`, of characters that any file
/// system takes.
pub fn folder_name(recording: &str, design: &str, id: &str) -> String {
    let name = if recording == "-" { "stdin" } else { recording };
    let id: String = id.chars().take(8).collect();
    // A folder's name has 255 bytes at most, and a letter up to four.
    let mut plain: String = format!("{name}-{design}")
        .chars()
        .take(50)
        .map(|c| {
            if c.is_alphanumeric() || matches!(c, '.' | '_' | '-') {
                c
            } else {
                '_'
            }
        })
        .collect();
    if !id.is_empty() {
        plain.push('-');
        plain.push_str(&id);
    }
    plain
}

/// Puts `files` into `dir`, made if absent, in place of those of the names `ours`, and returns
/// their paths. They are written into a folder beside it, which then takes its name. Where
/// `dir` holds files of other names these stay, and ours are exchanged one by one, the last of
/// `files` first away and last there.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if a folder cannot be made or a file not be written, moved or
/// removed.
pub(super) fn put(
    dir: &Path,
    ours: &[impl AsRef<str>],
    files: &[(String, Vec<u8>)],
) -> Result<Vec<PathBuf>, Error> {
    if dir.exists() && !dir.is_dir() {
        let error = io::Error::from(io::ErrorKind::NotADirectory);
        return Err(Error::io_at(MAKE, dir, &error));
    }
    if is_foreign(dir) {
        let reason =
            "it holds files that are no report; name an empty folder, or one that is not there yet";
        return Err(Error::io_at("write a report into the folder", dir, &reason));
    }
    // `.` and `..` cannot be renamed, so their files are exchanged one by one.
    let has_name = dir.file_name().is_some();
    let beside = if has_name {
        Unplaced::beside(dir)?
    } else {
        fs::create_dir_all(dir).map_err(|error| Error::io_at(MAKE, dir, &error))?;
        Unplaced::new(dir)?
    };
    for (name, content) in files {
        let path = beside.path.join(name);
        fs::write(&path, content)
            .map_err(|error| Error::io_at("write the report", &path, &error))?;
    }
    beside.settle(dir, |beside| {
        (!has_name || holds_others(dir, ours)).then(|| exchange(beside, dir, ours, files))
    })?;
    Ok(files.iter().map(|(name, _)| dir.join(name)).collect())
}

/// Beginning and end of the names of temporary folders.
const UNPLACED_NAME: (&str, &str) = (".latchgate-", ".part");

/// A temporary folder. Dropping it removes it, unless it was renamed into its place.
#[derive(Debug)]
pub struct Unplaced {
    parent: PathBuf,
    path: PathBuf,
    /// Tells other processes that it is in use, where the file system has locks.
    _lock: Lock,
}

/// A lock on a folder, which ends with its process or when it is dropped.
#[derive(Debug)]
enum Lock {
    Ours(#[allow(dead_code, reason = "it holds the lock")] File),
    /// Another process has it.
    Theirs,
    /// The file system has no locks on folders, or the folder is gone.
    None,
}

fn lock(dir: &Path) -> Lock {
    let Ok(file) = File::open(dir) else {
        return Lock::None;
    };
    match file.try_lock() {
        Ok(()) => Lock::Ours(file),
        Err(TryLockError::WouldBlock) => Lock::Theirs,
        Err(TryLockError::Error(_)) => Lock::None,
    }
}

impl Drop for Unplaced {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.path);
    }
}

impl Unplaced {
    /// Makes an empty folder beside `dir`, under a name that no other process of this machine uses.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it or the folder above cannot be made.
    pub fn beside(dir: &Path) -> Result<Self, Error> {
        let parent = dir.parent().unwrap_or(Path::new(""));
        if !parent.as_os_str().is_empty() {
            fs::create_dir_all(parent).map_err(|error| Error::io_at(MAKE, dir, &error))?;
        }
        Self::new(parent)
    }

    fn new(parent: &Path) -> Result<Self, Error> {
        loop {
            let path = Self::unused(parent);
            match fs::create_dir(&path) {
                Ok(()) => {
                    // Between the two steps another process may have taken it for one that was left.
                    match lock(&path) {
                        Lock::Theirs => continue,
                        Lock::Ours(_) if !path.is_dir() => continue,
                        lock => {
                            return Ok(Self {
                                parent: parent.to_path_buf(),
                                path,
                                _lock: lock,
                            });
                        }
                    }
                }
                // Nothing is written into what already has that name; it may be another user's link.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(Error::io_at(MAKE, &path, &error)),
            }
        }
    }

    /// Returns a path that no other process of this machine uses.
    fn unused(parent: &Path) -> PathBuf {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let (begin, end) = UNPLACED_NAME;
        parent.join(format!("{begin}{}-{number}{end}", std::process::id()))
    }

    /// Removes the temporary folders beside `dir` that processes left when they were killed, where locks tell that
    /// none uses them.
    pub fn remove_left(dir: &Path) {
        let parent = match dir.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let (begin, end) = UNPLACED_NAME;
        for entry in fs::read_dir(parent).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let is_named_so = name
                .to_str()
                .is_some_and(|name| name.starts_with(begin) && name.ends_with(end));
            // Not what a link of that name leads to.
            if !is_named_so || !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                continue;
            }
            if let Lock::Ours(_lock) = lock(&entry.path()) {
                let _ = fs::remove_dir_all(entry.path());
            }
        }
    }

    /// Returns the path of the folder until it is placed.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Renames the folder to `dir`, unless `otherwise`, called before each attempt, returns a result.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] if it cannot, and those of `otherwise`.
    pub fn settle(
        self,
        dir: &Path,
        otherwise: impl Fn(&Path) -> Option<Result<(), Error>>,
    ) -> Result<(), Error> {
        let cannot = |error: io::Error| Error::io_at("replace the earlier report", dir, &error);
        for _ in 0..ATTEMPTS {
            if let Some(done) = otherwise(&self.path) {
                return done;
            }
            let Err(error) = fs::rename(&self.path, dir) else {
                return Ok(());
            };
            if !dir.is_dir() {
                return Err(Error::io_at(MAKE, dir, &error));
            }
            let old = Self {
                parent: self.parent.clone(),
                path: Self::unused(&self.parent),
                _lock: lock(dir),
            };
            match fs::rename(dir, &old.path) {
                Ok(()) => {}
                // Another process has just moved the folder away.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => return Err(cannot(error)),
            }
            match fs::rename(&self.path, dir) {
                Ok(()) => return Ok(()),
                Err(_) if dir.is_dir() => {}
                Err(error) => {
                    let _ = fs::rename(&old.path, dir);
                    return Err(cannot(error));
                }
            }
        }
        Err(cannot(io::Error::other("others keep writing into it")))
    }
}

/// Returns true if a folder holds files, and no report among them.
fn is_foreign(dir: &Path) -> bool {
    let documents = [VERDICT_FILE, MARGIN_FILE, SPECTRUM_FILE, STATIC_FILE];
    let holds_any = fs::read_dir(dir).is_ok_and(|mut entries| entries.next().is_some());
    holds_any && !documents.iter().any(|name| is_document(dir, name)) && !is_comparison(dir)
}

/// Returns true if a file is a document of the kind that its name states, as its `schema` says. The word latchgate
/// alone proves nothing: others write about it, too.
fn is_document(dir: &Path, name: &str) -> bool {
    #[derive(Deserialize)]
    struct Head {
        schema: String,
    }
    let kind = name.trim_end_matches(".json");
    File::open(dir.join(name))
        .ok()
        .and_then(|file| serde_json::from_reader::<_, Head>(BufReader::new(file)).ok())
        .is_some_and(|head| head.schema.starts_with(&format!("latchgate.{kind}/")))
}

/// Returns true if a folder holds the page of several verdicts, which has no document beside it.
fn is_comparison(dir: &Path) -> bool {
    let mut head = Vec::new();
    let read =
        File::open(dir.join(COMPARE_FILE)).and_then(|file| file.take(4096).read_to_end(&mut head));
    let title = format!("<title>{COMPARE_TITLE}</title>");
    read.is_ok() && String::from_utf8_lossy(&head).contains(&title)
}

/// Returns true if a folder holds anything but files of the names `ours`.
fn holds_others(dir: &Path, ours: &[impl AsRef<str>]) -> bool {
    let Ok(entries) = fs::read_dir(dir) else {
        return false;
    };
    entries.flatten().any(|entry| {
        let name = entry.file_name();
        let is_ours = ours.iter().any(|our_name| name == *our_name.as_ref());
        !is_ours || entry.path().is_dir()
    })
}

/// Takes the files of the names `ours` out of `dir` and puts the new ones there.
fn exchange(
    beside: &Path,
    dir: &Path,
    ours: &[impl AsRef<str>],
    files: &[(String, Vec<u8>)],
) -> Result<(), Error> {
    let last = files.last().map(|(name, _)| name.as_str());
    let earlier = last.into_iter().chain(ours.iter().map(AsRef::as_ref));
    for name in earlier {
        let path = dir.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(Error::io_at("replace the earlier report", &path, &error));
            }
            _ => {}
        }
    }
    for (name, _) in files {
        let path = dir.join(name);
        fs::rename(beside.join(name), &path)
            .map_err(|error| Error::io_at("write the report", &path, &error))?;
    }
    Ok(())
}
