//! `latchgate replay`: recordings, one design, a verdict each.

use super::command_line::quoted;
use super::design::design;
use super::failure::{COULD_NOT, Failure};
use super::options::{Common, ReplayArguments, ReplayCommand};
use super::output;
use super::progress::Progress;
use super::values::OutputFormat;
use crate::error::Error;
use crate::model::Design;
use crate::pipeline::{self, Extras, Offer, Outcome};
use crate::recording::{Limits, Source};
use crate::report::{self, Document, escape, text};
use crate::request::Request;
use crate::verdict::Answer;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A recording's answer, and where its report lies.
struct ReplayedFile {
    outcome: Outcome,
    report: Option<PathBuf>,
    /// Why its report could not be written.
    unwritten: Option<Error>,
}

/// Runs the command; returns the exit code.
pub(super) fn command(own: &ReplayCommand, common: &Common) -> Result<u8, Failure> {
    // What the command line alone shows to be wrong comes before what a file says.
    let request = own.replay.request(common).map_err(Failure::Usage)?;
    let design = asked_design(&own.replay, &request, common)?;
    let first = &own.replay.read.recording;
    let recordings: Vec<&Path> = std::iter::once(first)
        .chain(&own.further)
        .map(PathBuf::as_path)
        .collect();
    let progress = Progress::new("replay");
    // A search of its own, for readers of one answer; a program asks for the margin.
    let advises = common.format == OutputFormat::Text && recordings.len() == 1;
    let mut judged = Vec::with_capacity(recordings.len());
    for (index, recording) in recordings.iter().enumerate() {
        let step = match recordings.len() {
            1 => format!("replay {}", recording.display()),
            many => format!("replay {} of {many}: {}", index + 1, recording.display()),
        };
        let started = Instant::now();
        let mut outcome = progress.watch(&step, common.thread_count(), |control| {
            let source = source(recording);
            let extras = Extras {
                filter_table: advises || !own.replay.no_report || request.members > 0,
                preload_answer: advises || !own.replay.no_report,
                evidence: !own.replay.no_report || own.series.is_some(),
            };
            pipeline::judge(
                &source,
                &request,
                &design,
                extras,
                &Limits::default(),
                control,
            )
        });
        if outcome.was_stopped() {
            return Err(Failure::Interrupted);
        }
        outcome.document.run.elapsed_s = started.elapsed().as_secs_f64();
        judged.push(kept(own, recording, recordings.len() > 1, outcome));
    }
    drop(progress);
    answer(&judged, common).map_err(Failure::Data)?;
    for (recording, judged) in recordings.iter().zip(&judged) {
        say(recording, judged);
        if let (true, Some(report)) = (own.open, &judged.report) {
            output::open(&report.join(report::REPORT_FILE));
        }
    }
    Ok(exit_code(&judged))
}

/// Returns the source: `-` is standard input, anything else a path.
fn source(recording: &Path) -> Source {
    if recording == Path::new("-") {
        Source::Stdin
    } else {
        Source::File(recording.to_path_buf())
    }
}

/// Writes the report, if there is to be one; what was not judged has none.
fn kept(own: &ReplayCommand, recording: &Path, several: bool, outcome: Outcome) -> ReplayedFile {
    let mut judged = ReplayedFile {
        outcome,
        report: None,
        unwritten: None,
    };
    if let (Some(path), Some(evidence)) = (&own.series, &judged.outcome.evidence) {
        judged.unwritten = report::series::write(path, &evidence.series).err();
    }
    let document = &judged.outcome.document;
    if own.replay.no_report || judged.outcome.refusal.is_some() {
        return judged;
    }
    let name = folder_name(
        &document.recording.file,
        &document.design.name,
        &document.report_id,
    );
    let folder = match &own.replay.out {
        Some(out) if several => out.join(name),
        Some(out) => out.clone(),
        None => Path::new("reports/out").join(name),
    };
    let evidence = judged.outcome.evidence.as_ref();
    let path = (recording != Path::new("-")).then_some(recording);
    let earlier = report::id_in(&folder);
    match report::write(&folder, document, evidence, path) {
        Ok(_) => {
            if earlier.is_some_and(|earlier| earlier != document.report_id) {
                let folder = folder.display();
                output::talk(&format!(
                    "latchgate: {folder}: an earlier report was replaced"
                ));
            }
            judged.report = Some(folder);
        }
        Err(error) => judged.unwritten = Some(error),
    }
    judged
}

/// Returns the document as it is printed: the same, whether a report was written or not. A question of
/// nominal runs alone is a program's, that wants it soon: it has no filter table.
fn printed(judged: &ReplayedFile) -> Document {
    let mut document = judged.outcome.document.clone();
    document.preload_answer = None;
    if document.request.members == 0 {
        document.filters.clear();
    }
    document
}

/// Prints the answer: one document or text, or a table of several.
fn answer(judged: &[ReplayedFile], common: &Common) -> Result<(), Error> {
    let look = output::look(common);
    match (common.format, judged) {
        (OutputFormat::Json, [one]) => output::document(&report::json::render(&printed(one))),
        (OutputFormat::Json, several) => {
            let worst = several.iter().map(|judged| judged.outcome.document.verdict);
            let worst = worst.min_by_key(|answer| text::rank(*answer));
            let documents: Vec<Value> = several
                .iter()
                .map(|judged| json!(printed(judged)))
                .collect();
            output::document(&report::json::render(&json!({
                "schema": "latchgate.verdicts/1",
                "verdict": worst.map(Answer::name),
                "verdicts": documents,
            })))
        }
        // What was not judged is told on stderr.
        (OutputFormat::Text, [one]) if one.outcome.refusal.is_some() => Ok(()),
        (OutputFormat::Text, [one]) => {
            let document = &one.outcome.document;
            output::document(&text::render(document, one.report.as_deref(), look))
        }
        (OutputFormat::Text, several) => {
            let rows: Vec<text::TableRow> = several
                .iter()
                .map(|judged| text::TableRow {
                    document: &judged.outcome.document,
                    judged: judged.outcome.refusal.is_none(),
                    report: judged.report.as_deref(),
                })
                .collect();
            output::document(&text::table(&rows, look))
        }
    }
}

/// Returns the worst exit code, in the order 4, 1, 3, 0.
fn exit_code(judged: &[ReplayedFile]) -> u8 {
    if judged.iter().any(|judged| judged.unwritten.is_some()) {
        return COULD_NOT;
    }
    let answers = judged.iter().map(|judged| judged.outcome.document.verdict);
    let worst = answers.min_by_key(|answer| text::rank(*answer));
    worst.map_or(COULD_NOT, Answer::exit_code)
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

/// Says on stderr why there is no answer, and which channels there are to choose from, or why
/// there is no report.
fn say(recording: &Path, judged: &ReplayedFile) {
    let document = &judged.outcome.document;
    if let Some(error) = &judged.outcome.refusal {
        output::talk(&format!("latchgate: {error}"));
        let lines = offers(recording, &judged.outcome.offers);
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
    if let Some(error) = &judged.unwritten {
        output::talk(&format!("latchgate: {error}"));
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

/// Returns the name of a report's folder, `<recording>-<design>-<id>`, of characters that any file
/// system takes.
pub(super) fn folder_name(recording: &str, design: &str, id: &str) -> String {
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
