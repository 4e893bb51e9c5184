//! `latchgate verify`: the run inside a verdict made again, and compared.

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

/// Exit code for a run that comes to something else.
const DIFFERENT: u8 = 1;

/// Bytes of a verdict that are taken in: one with two hundred impacts of four runs has less than
/// a hundredth of it.
const VERDICT_BYTES: u64 = 64 << 20;

/// Runs the command; returns the exit code.
pub(super) fn command(own: &VerifyArguments, common: &Common) -> Result<u8, Failure> {
    let in_verdict = |error: Error| Failure::Data(error.at(place(&own.verdict)));
    let bytes = read(&own.verdict).map_err(Failure::Data)?;
    let stored = Stored::from_json(&bytes).map_err(in_verdict)?;
    let mut request = stored.request().clone();
    // Limits of this command line come before those of the verdict.
    let limits = common.limits().map_err(Failure::Usage)?;
    let changed = limits.changed();
    request.limits.retain(|name, _| !changed.contains_key(name));
    let source = match (&own.recording, Path::new(stored.file())) {
        (None, word) if is_pulse(word) => source_of(word).map_err(Failure::Data)?,
        _ => Source::File(recording(own, &stored).map_err(Failure::Data)?),
    };
    let progress = Progress::new("verify");
    let verification = progress.watch("verify", common.thread_count(), |control| {
        pipeline::verify(
            &stored,
            &source,
            &request,
            own.recording.is_some(),
            Some(own.verdict.parent().unwrap_or(Path::new(""))),
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
    let most = ("verdict_bytes", VERDICT_BYTES);
    read_within(path, &path.display().to_string(), "read the verdict", most)
}

/// Returns the recording: the one that is named, else that of the verdict's name beside the
/// verdict, where the report notes that it was when it was replayed, or in the current folder. Of
/// several the one that has the verdict's bytes is taken.
fn recording(own: &VerifyArguments, stored: &Stored) -> Result<PathBuf, Error> {
    if let Some(path) = &own.recording {
        return existing(path);
    }
    let name = Path::new(stored.file()).file_name().unwrap_or_default();
    let folder = own.verdict.parent().unwrap_or(Path::new(""));
    let mut places = vec![folder.join(name)];
    places.extend(noted(folder, name));
    places.push(PathBuf::from(name));
    places.retain(|path| !name.is_empty() && path.exists());
    let same = |path: &&PathBuf| {
        let source = Source::File((*path).clone());
        source
            .sha256_within(Limits::default().text_bytes)
            .as_deref()
            == stored.sha256()
    };
    let found = match places.as_slice() {
        [_, _, ..] => places.iter().find(same).or(places.first()),
        _ => places.first(),
    };
    found.cloned().ok_or_else(|| {
        let absent = format!(
            "no file or folder {name:?} beside the verdict, where it was replayed or in the \
             current folder; state it with --recording FILE"
        );
        Error::io("find the recording", &absent).at(place(&own.verdict))
    })
}

/// Returns where the recording may lie by the note beside a report, a path from the folder where
/// it was replayed: from here, and from each folder that the report lies in. A note of another
/// name is none of this recording.
fn noted(folder: &Path, name: &std::ffi::OsStr) -> Vec<PathBuf> {
    const PATH_BYTES: u64 = 4096;
    let mut note = String::new();
    let read = std::fs::File::open(folder.join(latchgate_report::SOURCE_FILE))
        .and_then(|file| file.take(PATH_BYTES).read_to_string(&mut note));
    let path = Path::new(note.trim_end_matches('\n'));
    if read.is_err() || path.file_name() != Some(name) {
        return Vec::new();
    }
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    let above = whole.ancestors().map(|above| above.join(path));
    std::iter::once(path.to_path_buf()).chain(above).collect()
}

fn existing(path: &Path) -> Result<PathBuf, Error> {
    if path.exists() {
        return Ok(path.to_path_buf());
    }
    Err(Error::io("read the recording", &"no such file or folder").at(place(path)))
}
