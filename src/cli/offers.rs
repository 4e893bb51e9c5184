//! The commands to choose from where a file leaves a setting open.

use crate::pipeline::Offer;
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_report::escape;
use latchgate_report::escape::shell as quoted;
use std::path::Path;

/// Returns a line for each channel to choose: the command that takes it, its shape, and the doubt for
/// which it is not taken without a choice. `words` are those of the command line.
pub(super) fn offers(recording: &Path, offers: &[Offer], words: &[String]) -> String {
    const LISTED: usize = 24;
    let recording = recording.to_string_lossy();
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

/// Returns a line for each choice of the settings that a table without names leaves open: the full
/// command.
pub(super) fn commands(recording: &Path, error: &Error, words: &[String]) -> String {
    const LISTED: usize = 8;
    let ErrorKind::UnnamedColumns { settings, .. } = error.kind() else {
        return String::new();
    };
    let recording = recording.to_string_lossy();
    let further = further_options(words, &recording);
    let recording = quoted(&recording);
    let mut commands = vec![format!("latchgate replay {recording}")];
    for (setting, values) in settings {
        let with_setting = |command: &String| -> Vec<String> {
            let values = values.iter();
            values
                .map(|value| format!("{command} {setting} = {value}"))
                .collect()
        };
        commands = commands
            .iter()
            .flat_map(with_setting)
            .take(LISTED)
            .collect();
    }
    let line = |command: &String| {
        let command = escape::terminal(command);
        format!("  try: {command}{}\n", escape::terminal(&further))
    };
    commands.iter().map(line).collect()
}

/// Returns the options of a command line except `--channel`, each after a blank.
fn further_options(words: &[String], recording: &str) -> String {
    let mut options = String::new();
    let (mut command_seen, mut file_seen, mut is_channel) = (false, false, false);
    for word in words {
        if std::mem::take(&mut is_channel) || word.starts_with("--channel=") {
            continue;
        }
        if word == "--channel" {
            is_channel = true;
        } else if !command_seen && matches!(word.as_str(), "replay" | "inspect" | "margin") {
            command_seen = true;
        } else if !file_seen && word.as_str() == recording {
            file_seen = true;
        } else {
            options += &format!(" {}", quoted(word));
        }
    }
    options
}

/// Returns the words of this process's command line, behind the program's name.
pub(super) fn command_words() -> Vec<String> {
    let words = std::env::args_os().skip(1);
    words
        .map(|word| word.to_string_lossy().into_owned())
        .collect()
}
