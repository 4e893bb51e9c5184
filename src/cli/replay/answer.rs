//! The output of a replay on stdout and stderr, and its exit code.

use super::ReplayedFile;
use crate::cli::failure::COULD_NOT;
use crate::cli::offers::{command_words, commands, offers};
use crate::cli::options::Common;
use crate::cli::output;
use crate::cli::values::OutputFormat;
use crate::pipeline::Outcome;
use latchgate_document::Document;
use latchgate_document::blocks::Verdicts;
use latchgate_recording::SensorPlace;
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_recording::setting::Setting;
use latchgate_report::{escape, text};
use latchgate_verdict::{Answer, TOGETHER};
use serde_json::json;
use std::path::Path;

/// Prints the part of one answer that needs no search for advice; nothing if the recording was not
/// judged.
pub(super) fn print_first(outcome: &Outcome, common: &Common) -> Result<(), Error> {
    if outcome.refusal.is_some() {
        return Ok(());
    }
    output::document(&text::answer(&outcome.document, output::look(common)))
}

/// Prints the answer: one document, the second part of one text, or a table of several.
pub(super) fn print(judged: &[ReplayedFile], common: &Common) -> Result<(), Error> {
    let look = output::look(common);
    match (common.format, judged) {
        (OutputFormat::Json, [replayed]) => output::document(&latchgate_document::json::render(
            &replayed.outcome.document,
        )),
        (OutputFormat::Json, several) => {
            let verdicts = Verdicts {
                schema: "latchgate.verdicts/1".into(),
                verdict: worst(several),
                verdicts: several
                    .iter()
                    .map(|judged| judged.outcome.document.clone())
                    .collect(),
            };
            // `json!` puts the keys in the order of their names, as in a single document.
            output::document(&latchgate_document::json::render(&json!(verdicts)))
        }
        // The refusal goes to stderr.
        (OutputFormat::Text, [replayed]) if replayed.outcome.refusal.is_some() => Ok(()),
        (OutputFormat::Text, [replayed]) => {
            let document = &replayed.outcome.document;
            let (report, pdf) = (replayed.report.as_deref(), replayed.pdf.as_deref());
            output::document(&text::afterwards(document, report, pdf, look))
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
pub(super) fn exit_code(judged: &[ReplayedFile]) -> u8 {
    if judged.iter().any(|judged| judged.unwritten.is_some()) {
        return COULD_NOT;
    }
    worst(judged).map_or(COULD_NOT, Answer::exit_code)
}

fn worst(judged: &[ReplayedFile]) -> Option<Answer> {
    let answers = judged.iter().map(|judged| judged.outcome.document.verdict);
    answers.min_by_key(|answer| text::rank(*answer))
}

/// Returns why there is no verdict, as stderr shows it: the refusal with the channels to choose from
/// or the commands to try, or the reason of an unusable recording. `None` where there is a verdict.
/// `words` are those of the command line.
pub fn message(recording: &Path, outcome: &Outcome, words: &[String]) -> Option<String> {
    let document = &outcome.document;
    let text = if let Some(error) = &outcome.refusal {
        let lines = offers(recording, &outcome.offers, words) + &commands(recording, error, words);
        let further = further_words(recording, error, document);
        format!("latchgate: {error}{further}\n{lines}")
    } else if document.verdict == Answer::Unusable {
        let file = &document.recording.file;
        let reason = document.why.first();
        let reason = reason.map_or("", |reason| reason.text.as_str());
        format!("latchgate: {file}: unusable: {reason}")
    } else {
        return None;
    };
    Some(output::with_options(text.trim_end()))
}

/// Returns the sentences that name, beside a missing unit or time, what a pass would wait for next; empty of any other
/// error, and where nothing else is missing.
fn further_words(recording: &Path, error: &Error, document: &Document) -> String {
    let is_missing = matches!(
        error.kind(),
        ErrorKind::MissingUnit | ErrorKind::MissingTime | ErrorKind::UnnamedColumns { .. }
    );
    let request = &document.request;
    let mut missing = Vec::new();
    if document.recording.opens_when.is_none() {
        missing.push(format!("{} = negative|positive|both", Setting::OpensWhen));
    }
    let place = document.recording.place;
    if request.transfer.is_none() && !place.is_some_and(SensorPlace::moves_as_latch) {
        missing.push(format!("{} = LO..HI", Setting::Transfer));
    }
    if !is_missing || missing.is_empty() {
        return String::new();
    }
    let recording = recording.to_string_lossy();
    format!(
        ". A pass may wait for more. {TOGETHER}{}. latchgate init card {} writes a card for all",
        missing.join(", "),
        escape::terminal(&escape::shell(&recording))
    )
}

/// Prints errors to stderr: why there is no verdict, and the error of writing the report.
pub(super) fn print_errors(recording: &Path, judged: &ReplayedFile) {
    if let Some(message) = message(recording, &judged.outcome, &command_words()) {
        output::talk_plainly(&message);
    }
    if let Some(error) = &judged.unwritten {
        output::talk(&format!("latchgate: {error}"));
    }
}
