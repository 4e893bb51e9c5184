//! What the library answers to a case, in this process: the words of a command line become the same
//! question as they do in the program.

use super::Case;
use clap::Parser as _;
use latchgate::cli::args::{Arguments, Command};
use latchgate::cli::message;
use latchgate::document::json::render;
use latchgate::pipeline::{
    self, Control, Design, Extras, Limits, Listing, Outcome, Request, pulse,
};
use std::path::Path;

/// How each case is judged; the push is a shorter record than a crash recorder takes, and where a sensor sits is
/// what most of the files do not say.
const JUDGED_WITH: [&str; 6] = [
    "--members",
    "0",
    "--accept",
    "clock,axis,noise",
    "--transfer",
    "1",
];

/// A case's command line of `replay`.
pub(super) fn replay_words<'a>(case: &'a Case, path: &'a str) -> Vec<&'a str> {
    let options = case.options.iter().map(String::as_str);
    let fixed = ["replay", path, "--no-report"];
    fixed
        .into_iter()
        .chain(JUDGED_WITH)
        .chain(options)
        .chain(["--format", "json"])
        .collect()
}

/// A case's command line of `inspect`.
pub(super) fn inspect_words<'a>(case: &'a Case, path: &'a str) -> Vec<&'a str> {
    // `--opens-when NAME`, the first two, is for those who judge.
    let options = case.options[2..].iter().map(String::as_str);
    ["inspect", path]
        .into_iter()
        .chain(options)
        .chain(["--format", "json"])
        .collect()
}

fn parsed(words: &[&str]) -> Arguments {
    Arguments::try_parse_from([&["latchgate"], words].concat())
        .unwrap_or_else(|error| panic!("{words:?}: {error}"))
}

/// Judges a case.
pub(super) fn judge(case: &Case, path: &Path) -> Outcome {
    let words = replay_words(case, path.to_str().unwrap());
    let arguments = parsed(&words);
    let Command::Replay(options) = arguments.command else {
        panic!("{words:?}: another command");
    };
    let request = options.replay.request(&arguments.common).unwrap();
    let design = Design::reference();
    request.check_design(&design).unwrap();
    pipeline::judge(
        &pulse::source_at(path).unwrap(),
        &request,
        &design,
        Extras::default(),
        &Limits::default(),
        &Control::default(),
    )
}

/// Lists what the file of a case holds.
pub(super) fn inspect(case: &Case, path: &Path) -> Result<Listing, pipeline::Error> {
    let words = inspect_words(case, path.to_str().unwrap());
    let arguments = parsed(&words);
    let Command::Inspect(options) = arguments.command else {
        panic!("{words:?}: another command");
    };
    listing(path, &options.read.request(&arguments.common).unwrap())
}

/// Lists what a file holds as a question reads it.
pub(super) fn listing(path: &Path, request: &Request) -> Result<Listing, pipeline::Error> {
    let source = pulse::source_at(path).unwrap();
    pipeline::inspect(&source, request, &Limits::default(), &Control::default())
}

/// The document as it is written.
pub(super) fn written(outcome: &Outcome) -> String {
    render(&outcome.document)
}

/// What stderr says of a case, which begins with the reason for which there is no verdict; empty where there is one.
pub(super) fn errors(case: &Case, path: &Path, outcome: &Outcome) -> String {
    let words = replay_words(case, path.to_str().unwrap());
    let words: Vec<String> = words.into_iter().map(String::from).collect();
    message(path, outcome, &words).unwrap_or_default()
}
