//! Reading a recording and what was found in it.

use latchgate_recording::error::{Error, ErrorKind};
use latchgate_recording::{
    self, Channel, Finding, Limits, ReadOptions, Recording, Selection, Severity, Source,
};
use std::path::Path;

pub fn with_channel(channel: &str) -> ReadOptions {
    ReadOptions {
        channel: Some(channel.into()),
        ..ReadOptions::default()
    }
}

pub fn read_path(
    path: &Path,
    options: &ReadOptions,
    selection: Selection,
) -> Result<Recording, Error> {
    latchgate_recording::read(
        &Source::File(path.to_path_buf()),
        options,
        selection,
        &Limits::default(),
    )
}

/// Reads the one channel, with the findings of file and channel together.
#[track_caller]
pub fn one(path: &Path, options: &ReadOptions) -> (Channel, Vec<Finding>) {
    let recording = read_path(path, options, Selection::Lateral)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let [channel] = recording.channels.as_slice() else {
        panic!("{} channels", recording.channels.len());
    };
    let findings = recording.findings.iter().chain(&channel.findings);
    (channel.clone(), findings.cloned().collect())
}

/// Checks that a file is refused with an error of a kind and with words in its message.
#[track_caller]
pub fn check_refused(
    path: &Path,
    options: &ReadOptions,
    kind: fn(&ErrorKind) -> bool,
    words: &[&str],
) {
    let error = match read_path(path, options, Selection::Lateral) {
        Ok(recording) => panic!("read: {:?}", recording.channels[0].name),
        Err(error) => error,
    };
    assert!(kind(error.kind()), "{error}");
    for word in words {
        assert!(error.to_string().contains(word), "`{word}` in: {error}");
    }
}

/// Checks which findings of a severity there are.
#[track_caller]
pub fn check_codes(findings: &[Finding], severity: Severity, expected: &[&str]) {
    let mut codes: Vec<&str> = findings
        .iter()
        .filter(|finding| finding.severity == severity)
        .map(|finding| &*finding.code)
        .collect();
    codes.sort_unstable();
    assert_eq!(codes, expected, "{findings:#?}");
}

#[track_caller]
pub fn check_at(findings: &[Finding], code: &str, at_s: Option<f64>) {
    let finding = findings
        .iter()
        .find(|finding| finding.code == code)
        .unwrap_or_else(|| panic!("no finding {code}: {findings:#?}"));
    assert_eq!(finding.at_s, at_s, "{finding:?}");
}
