//! The output of a replay on stdout and stderr, and its exit code.

use super::ReplayedFile;
use crate::cli::failure::COULD_NOT;
use crate::cli::offers::{commands, offers};
use crate::cli::options::Common;
use crate::cli::output;
use crate::cli::values::OutputFormat;
use crate::pipeline::Outcome;
use latchgate_document::Document;
use latchgate_document::blocks::Verdicts;
use latchgate_recording::error::Error;
use latchgate_report::text;
use latchgate_verdict::Answer;
use serde_json::json;
use std::path::Path;

/// Returns the document as it is printed: the same with a report and without. A request of nominal
/// runs alone comes from programs that need a fast answer, so it has no filter table.
fn printed(judged: &ReplayedFile) -> Document {
    let mut document = judged.outcome.document.clone();
    document.preload_answer = None;
    document.restitution_answer = None;
    if document.request.members == 0 {
        document.filters.clear();
    }
    document
}

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
        (OutputFormat::Json, [replayed]) => {
            output::document(&latchgate_document::json::render(&printed(replayed)))
        }
        (OutputFormat::Json, several) => {
            let verdicts = Verdicts {
                schema: "latchgate.verdicts/1".into(),
                verdict: worst(several),
                verdicts: several.iter().map(printed).collect(),
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

/// Prints errors to stderr: the refusal with the channels to choose from, the reason of an unusable
/// recording, and the error of writing the report.
pub(super) fn print_errors(recording: &Path, judged: &ReplayedFile) {
    let document = &judged.outcome.document;
    if let Some(error) = &judged.outcome.refusal {
        output::talk(&format!("latchgate: {error}"));
        let lines = offers(recording, &judged.outcome.offers) + &commands(recording, error);
        if !lines.is_empty() {
            output::talk(lines.trim_end());
        }
    } else if document.verdict == Answer::Unusable {
        let file = &document.recording.file;
        let reason = document.why.first();
        let reason = reason.map_or("", |reason| reason.text.as_str());
        output::talk(&format!("latchgate: {file}: unusable: {reason}"));
    }
    if let Some(error) = &judged.unwritten {
        output::talk(&format!("latchgate: {error}"));
    }
}
