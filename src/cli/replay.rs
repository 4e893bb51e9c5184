//! `latchgate replay`: one recording, one design, one verdict.

use super::command_line::quoted;
use super::design::design;
use super::failure::Failure;
use super::options::{Common, ReplayArguments};
use super::output;
use super::progress::Progress;
use super::values::OutputFormat;
use crate::error::{Error, ErrorKind};
use crate::model::Design;
use crate::pipeline::{self, Extras, Offer, Outcome};
use crate::recording::Limits;
use crate::report::{self, escape};
use crate::request::Request;
use crate::verdict::Answer;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Runs the command; returns the exit code.
pub(super) fn command(own: &ReplayArguments, common: &Common) -> Result<u8, Failure> {
    let started = Instant::now();
    // What the command line alone shows to be wrong comes before what a file says.
    let request = own.request(common).map_err(Failure::Usage)?;
    let design = asked_design(own, &request, common)?;
    let source = own.read.source();
    let extras = Extras {
        // The nominal run alone, for a program that reads one number, is not to wait for more.
        filter_table: own.members > 0 || !own.no_report,
        preload_answer: !own.no_report,
        evidence: !own.no_report,
    };
    let progress = Progress::new("replay");
    let mut outcome = progress.watch("replay", common.thread_count(), |control| {
        let limits = Limits::default();
        pipeline::judge(&source, &request, &design, extras, &limits, control)
    });
    drop(progress);
    if outcome.was_stopped() {
        return Err(Failure::Interrupted);
    }
    outcome.document.run.elapsed_s = started.elapsed().as_secs_f64();
    let folder = report_folder(own, &outcome);
    if let Some(folder) = &folder {
        report::write(folder, &outcome.document, outcome.evidence.as_ref())
            .map_err(Failure::Data)?;
    }
    match common.format {
        OutputFormat::Json => output::document(&report::json::render(&outcome.document)),
        OutputFormat::Text => {
            output::text(&report::text::render(&outcome.document, folder.as_deref()))
        }
    }
    .map_err(Failure::Data)?;
    say_why_unusable(own, &outcome);
    Ok(outcome.document.verdict.exit_code())
}

/// Returns the design that the options ask for, checked together with the question.
pub(super) fn asked_design(
    own: &ReplayArguments,
    request: &Request,
    common: &Common,
) -> Result<Design, Failure> {
    request.check().map_err(Failure::Usage)?;
    let limits = common.limits().map_err(Failure::Usage)?;
    let design = design(own.design.as_deref(), &own.set, &limits)?;
    request.check_design(&design).map_err(match own.design {
        None => Failure::Usage,
        // Here it takes the file to see that value and tolerance do not go together.
        Some(_) => Failure::Data,
    })?;
    Ok(design)
}

/// Returns where the report goes; `None` if there shall be none, or if there is nothing to say.
fn report_folder(own: &ReplayArguments, outcome: &Outcome) -> Option<PathBuf> {
    if own.no_report {
        return None;
    }
    let document = &outcome.document;
    let folder = own
        .out
        .clone()
        .unwrap_or_else(|| default_folder(&document.recording.file, &document.design.name));
    // A name that no file bears makes no folder; but an older report, perhaps a pass, must not
    // outlive a run that found its recording gone.
    let nothing_there = |error: &Error| matches!(error.kind(), ErrorKind::Io { .. });
    let absent = outcome.refusal.as_ref().is_some_and(nothing_there) && !folder.exists();
    (!absent).then_some(folder)
}

/// Says on stderr why there is no answer, and which channels there are to choose from.
fn say_why_unusable(own: &ReplayArguments, outcome: &Outcome) {
    let document = &outcome.document;
    if let Some(error) = &outcome.refusal {
        output::talk(&format!("latchgate: {error}"));
        let lines = offers(&own.read.recording, &outcome.offers);
        if !lines.is_empty() {
            output::talk(lines.trim_end());
        }
    } else if document.verdict == Answer::Unusable {
        let reason = document
            .why
            .first()
            .map_or("", |reason| reason.text.as_str());
        let file = &document.recording.file;
        output::talk(&format!("latchgate: {file}: unusable: {reason}"));
    }
}

/// Returns a line for each channel to choose: the command that takes it, its shape, and what
/// keeps it from being taken unasked.
pub(super) fn offers(recording: &Path, offers: &[Offer]) -> String {
    const LISTED: usize = 24;
    let recording = recording.to_string_lossy();
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| word.to_string_lossy().into_owned());
    let further = further_options(words, &recording);
    let mut lines: String = offers
        .iter()
        .take(LISTED)
        .map(|offer| {
            let doubt = offer.doubt.as_ref();
            let doubt = doubt.map_or(String::new(), |doubt| format!("  ({doubt})"));
            format!(
                "  choose: latchgate replay {} --channel {}{}  {}{}\n",
                escape::terminal(&quoted(&recording)),
                escape::terminal(&quoted(&offer.channel)),
                escape::terminal(&further),
                offer.spark,
                escape::terminal(&doubt),
            )
        })
        .collect();
    if offers.len() > LISTED {
        lines += &format!("  … {} more\n", offers.len() - LISTED);
    }
    lines
}

/// Returns the options of a command line, each after a blank, but the one that names a channel.
fn further_options(words: impl Iterator<Item = String>, recording: &str) -> String {
    let mut rest = String::new();
    let (mut command, mut file, mut value) = (false, false, false);
    for word in words {
        if std::mem::take(&mut value) || word.starts_with("--channel=") {
            continue;
        }
        if word == "--channel" {
            value = true;
        } else if !command && matches!(word.as_str(), "replay" | "inspect" | "margin") {
            command = true;
        } else if !file && word == recording {
            file = true;
        } else {
            rest += &format!(" {}", quoted(&word));
        }
    }
    rest
}

/// `reports/out/<recording>-<design>`, of characters that any file system takes.
pub(super) fn default_folder(recording: &str, design: &str) -> PathBuf {
    let name = if recording == "-" { "stdin" } else { recording };
    // A folder's name has 255 bytes at most, and a letter up to four.
    let plain: String = format!("{name}-{design}")
        .chars()
        .take(60)
        .map(|c| {
            if c.is_alphanumeric() || matches!(c, '.' | '_' | '-') {
                c
            } else {
                '_'
            }
        })
        .collect();
    Path::new("reports/out").join(plain)
}
