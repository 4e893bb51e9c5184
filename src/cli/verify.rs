//! `latchgate verify`: repeats the run of a verdict and compares.

use super::failure::Failure;
use super::options::{Common, VerifyArguments, is_pulse, source_of};
use super::output;
use super::progress::Progress;
use super::values::OutputFormat;
use crate::pipeline::{self, Difference, Stored, Verification};
use latchgate_recording::error::{Error, Place};
use latchgate_recording::{Limits, Source, read_within};
use latchgate_report::escape;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Exit code for a run with another result.
const DIFFERENT: u8 = 1;

/// Largest verdict that is read [bytes]: a hundred times one with two hundred impacts of four runs.
const VERDICT_BYTES: u64 = 64 << 20;

/// Runs the command; returns the exit code.
pub(super) fn command(arguments: &VerifyArguments, common: &Common) -> Result<u8, Failure> {
    let in_verdict = |error: Error| Failure::Data(error.at(place(&arguments.verdict)));
    let bytes = read(&arguments.verdict).map_err(Failure::Data)?;
    let stored = Stored::from_json(&bytes).map_err(in_verdict)?;
    let mut request = stored.request().clone();
    // Limits of this command line come before those of the verdict.
    let limits = common.limits().map_err(Failure::Usage)?;
    let changed = limits.changed();
    request.limits.retain(|name, _| !changed.contains_key(name));
    let source = match (&arguments.recording, Path::new(stored.file())) {
        (None, word) if is_pulse(word) => source_of(word).map_err(Failure::Data)?,
        _ => Source::File(recording(arguments, &stored).map_err(Failure::Data)?),
    };
    let progress = Progress::new("verify");
    let verification = progress.watch("verify", common.thread_count(), |control| {
        pipeline::verify(
            &stored,
            &source,
            &request,
            arguments.recording.is_some(),
            Some(arguments.verdict.parent().unwrap_or(Path::new(""))),
            &limits,
            control,
        )
    });
    drop(progress);
    let verification = verification.map_err(Failure::of_data)?;
    match common.format {
        OutputFormat::Json => output::document(&latchgate_document::json::render(&verification)),
        OutputFormat::Text => output::text(&text(&verification)),
    }
    .map_err(Failure::Data)?;
    Ok(if verification.same { 0 } else { DIFFERENT })
}

fn text(verification: &Verification) -> String {
    let mut out = String::from(if verification.same {
        "SAME\n"
    } else {
        "DIFFERENT\n"
    });
    let mut line = |name: &str, text: &str| {
        out.push_str(&format!("  {name:<15} {}\n", escape::terminal(text)));
    };
    line("recording", &verification.recording.file);
    for (name, both) in [
        ("verdict", &verification.verdict),
        ("version", &verification.version),
    ] {
        let stored = both.stored.as_deref().unwrap_or("none");
        let now = both.now.as_deref().unwrap_or("none");
        if stored == now {
            line(name, stored);
        } else {
            line(name, &format!("{stored} in the verdict, {now} now"));
        }
    }
    match &verification.first_difference {
        None => line(
            "compared",
            "every key but version and time taken, every number to its last digit",
        ),
        Some(Difference { text, .. }) => {
            line("first", text);
            line(
                "differences",
                &format!("{} values in all", verification.differences),
            );
        }
    }
    let report = &verification.report;
    for (name, files) in [
        ("report, same", &report.same),
        ("different", &report.different),
        ("not compared", &report.not_compared),
        ("missing", &report.missing),
    ] {
        if !files.is_empty() {
            line(name, &files.join(", "));
        }
    }
    out
}

pub(super) fn place(path: &Path) -> Place {
    Place::file(path.display().to_string())
}

/// Reads a verdict, within bounds.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, Error> {
    let limit = ("verdict_bytes", VERDICT_BYTES);
    read_within(path, &path.display().to_string(), "read the verdict", limit)
}

/// Returns the recording: the one that is named, or a file of the recording's name beside the
/// verdict, at the path that the report notes, or in the current folder. Of several files the one
/// with the hash of the verdict is used.
fn recording(arguments: &VerifyArguments, stored: &Stored) -> Result<PathBuf, Error> {
    if let Some(path) = &arguments.recording {
        return existing(path);
    }
    let name = Path::new(stored.file()).file_name().unwrap_or_default();
    let folder = arguments.verdict.parent().unwrap_or(Path::new(""));
    let mut places = vec![folder.join(name)];
    places.extend(noted_places(folder, name));
    places.push(PathBuf::from(name));
    places.retain(|path| !name.is_empty() && path.exists());
    let same = |path: &&PathBuf| {
        let source = Source::File((*path).clone());
        source
            .sha256_within(Limits::default().text_bytes)
            .as_deref()
            == stored.sha256()
    };
    let recording = match places.as_slice() {
        // Hashing reads the whole file, so a single one is not hashed for the choice.
        [_, _, ..] => places.iter().find(same).or(places.first()),
        _ => places.first(),
    };
    recording.cloned().ok_or_else(|| {
        let absent = format!(
            "no file or folder {name:?} beside the verdict, where it was replayed or in the \
             current folder; state it with --recording FILE"
        );
        Error::io("find the recording", &absent).at(place(&arguments.verdict))
    })
}

/// Returns the places of the recording by the note beside a report, a path relative to the folder of
/// the replay: from the current folder, and from each folder above the report. A note with another
/// name belongs to another recording.
fn noted_places(folder: &Path, name: &std::ffi::OsStr) -> Vec<PathBuf> {
    const PATH_BYTES: u64 = 4096;
    let mut note = String::new();
    let read = std::fs::File::open(folder.join(latchgate_report::SOURCE_FILE))
        .and_then(|file| file.take(PATH_BYTES).read_to_string(&mut note));
    let path = Path::new(note.trim_end_matches('\n'));
    if read.is_err() || path.file_name() != Some(name) {
        return Vec::new();
    }
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    let above = absolute.ancestors().map(|folder| folder.join(path));
    std::iter::once(path.to_path_buf()).chain(above).collect()
}

fn existing(path: &Path) -> Result<PathBuf, Error> {
    if path.exists() {
        return Ok(path.to_path_buf());
    }
    Err(Error::io("read the recording", &"no such file or folder").at(place(path)))
}
