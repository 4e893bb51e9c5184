//! A report's folder, which holds the earlier report, the new one or none, never parts of both.

use crate::error::{Error, ErrorKind, Place};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Attempts to put a report in its place while others put theirs there.
const ATTEMPTS: u32 = 100;

/// Number of the next folder that this process writes beside another.
static NEXT: AtomicU32 = AtomicU32::new(0);

/// Puts `files` into `dir`, made if absent, in place of those of the names `ours`, and returns
/// their paths. They are written into a folder beside it, which then takes its name. Where
/// `dir` holds files of other names these stay, and ours are exchanged one by one, the last of
/// `files` first away and last there.
///
/// # Errors
///
/// [`ErrorKind::Io`] if a folder cannot be made or a file not be written, moved or removed.
pub(super) fn put(
    dir: &Path,
    ours: &[impl AsRef<str>],
    files: &[(String, Vec<u8>)],
) -> Result<Vec<PathBuf>, Error> {
    let make = |path: &Path| {
        fs::create_dir_all(path).map_err(|error| failed("make the report folder", dir, &error))
    };
    if dir.exists() && !dir.is_dir() {
        let error = io::Error::from(io::ErrorKind::NotADirectory);
        return Err(failed("make the report folder", dir, &error));
    }
    // Of `.` and `..` there is no beside.
    let parent = if dir.file_name().is_none() {
        make(dir)?;
        dir
    } else {
        dir.parent().unwrap_or(Path::new(""))
    };
    if !parent.as_os_str().is_empty() {
        make(parent)?;
    }
    let beside = Unplaced(parent.join(unique()));
    make(&beside.0)?;
    for (name, content) in files {
        let path = beside.0.join(name);
        fs::write(&path, content).map_err(|error| failed("write the report", &path, &error))?;
    }
    settle(&beside.0, dir, parent, ours, files)?;
    Ok(files.iter().map(|(name, _)| dir.join(name)).collect())
}

/// Returns a name that no other run of this machine takes.
fn unique() -> String {
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    format!(".latchgate-{}-{number}.part", std::process::id())
}

/// A folder that goes with its end, unless it has taken another's place.
struct Unplaced(PathBuf);

impl Drop for Unplaced {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Lets the folder `beside` take the place of `dir`.
fn settle(
    beside: &Path,
    dir: &Path,
    parent: &Path,
    ours: &[impl AsRef<str>],
    files: &[(String, Vec<u8>)],
) -> Result<(), Error> {
    let cannot = |error: io::Error| failed("replace the earlier report", dir, &error);
    for _ in 0..ATTEMPTS {
        if parent == dir || holds_others(dir, ours) {
            return exchange(beside, dir, ours, files);
        }
        let Err(error) = fs::rename(beside, dir) else {
            return Ok(());
        };
        if !dir.is_dir() {
            return Err(failed("make the report folder", dir, &error));
        }
        let old = Unplaced(parent.join(unique()));
        match fs::rename(dir, &old.0) {
            Ok(()) => {}
            // Another run was quicker.
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(cannot(error)),
        }
        match fs::rename(beside, dir) {
            Ok(()) => return Ok(()),
            Err(_) if dir.is_dir() => {}
            Err(error) => {
                let _ = fs::rename(&old.0, dir);
                return Err(cannot(error));
            }
        }
    }
    Err(cannot(io::Error::other("others keep writing into it")))
}

/// Tells whether a folder holds anything but files of the names `ours`.
fn holds_others(dir: &Path, ours: &[impl AsRef<str>]) -> bool {
    let Ok(entries) = fs::read_dir(dir) else {
        return false;
    };
    entries.flatten().any(|entry| {
        let name = entry.file_name();
        let known = |known: &&str| name == **known;
        ours.iter()
            .map(AsRef::as_ref)
            .find(known)
            .is_none_or(|_| entry.path().is_dir())
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
                return Err(failed("replace the earlier report", &path, &error));
            }
            _ => {}
        }
    }
    for (name, _) in files {
        let path = dir.join(name);
        fs::rename(beside.join(name), &path)
            .map_err(|error| failed("write the report", &path, &error))?;
    }
    Ok(())
}

fn failed(action: &'static str, path: &Path, error: &io::Error) -> Error {
    Error::from(ErrorKind::Io {
        action,
        reason: error.to_string(),
    })
    .at(Place::file(path.display().to_string()))
}
