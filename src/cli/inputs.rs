//! Protects the files that a command reads from what it writes.

use super::options::ReplayArguments;
use latchgate_recording::error::{Error, Place};
use std::fs;
use std::path::{Path, PathBuf};

/// Files that a command reads.
pub(super) struct Inputs(Vec<PathBuf>);

impl Inputs {
    /// Returns the recordings, their cards and the design file of a command line.
    pub(super) fn of(arguments: &ReplayArguments, further: &[PathBuf]) -> Self {
        let recordings = std::iter::once(&arguments.read.recording).chain(further);
        let designs: Vec<PathBuf> = arguments.design.iter().cloned().collect();
        Self::of_files(recordings.map(PathBuf::as_path), &designs)
    }

    /// Returns recordings, their cards and design files.
    pub(super) fn of_files<'a>(
        recordings: impl Iterator<Item = &'a Path>,
        designs: &[PathBuf],
    ) -> Self {
        let mut files: Vec<PathBuf> = designs.to_vec();
        for recording in recordings {
            let mut card = recording.to_path_buf().into_os_string();
            card.push(".toml");
            files.push(recording.to_path_buf());
            files.push(card.into());
        }
        Self(files)
    }

    /// Refuses a folder for reports that holds one of the files.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] that names the file.
    pub(super) fn check_report_folder(&self, folder: &Path) -> Result<(), Error> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let paths = entries.map(|entry| entry.path());
        match paths.into_iter().find(|path| self.contain(path)) {
            Some(path) => Err(overwritten(&path, "report")),
            None => Ok(()),
        }
    }

    /// Refuses a file for the series that is one of the files, or holds anything but an earlier series.
    ///
    /// # Errors
    ///
    /// [`latchgate_recording::error::ErrorKind::Io`] that names the file.
    pub(super) fn check_series_file(&self, series: &Path) -> Result<(), Error> {
        if self.contain(series) {
            return Err(overwritten(series, "series"));
        }
        // A pipe or a device such as /dev/stdout may be written; so may an empty file.
        let has_content =
            fs::metadata(series).is_ok_and(|metadata| metadata.is_file() && metadata.len() > 0);
        if has_content && !latchgate_report::series::is_one(series) {
            let reason = "the file is there and is no series; name one that is not there yet";
            return Err(Error::io("write the series", &reason).at(Place::path(series)));
        }
        Ok(())
    }

    fn contain(&self, path: &Path) -> bool {
        let mut inputs = self.0.iter();
        inputs.any(|input| same_file::is_same_file(input, path).unwrap_or(false))
    }
}

fn overwritten(path: &Path, what: &str) -> Error {
    let reason =
        format!("the {what} would take the place of a file that is read; name another place");
    Error::io("write beside what is read", &reason).at(Place::path(path))
}
