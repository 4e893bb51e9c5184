//! What a person may mean where the file does not say it: for each choice the command that takes it.

use crate::pipeline::Offer;
use latchgate_recording::error::{Error, ErrorKind};
use latchgate_report::escape;
use latchgate_report::escape::shell as quoted;
use std::path::Path;

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

/// Returns a line for each way of stating what a table without names does not say: the whole command.
pub(super) fn commands(recording: &Path, error: &Error) -> String {
    const LISTED: usize = 8;
    let ErrorKind::UnnamedColumns { settings, .. } = error.kind() else {
        return String::new();
    };
    let recording = recording.to_string_lossy();
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| word.to_string_lossy().into_owned());
    let further = further_options(words, &recording);
    let recording = quoted(&recording);
    let mut commands = vec![format!("latchgate replay {recording}")];
    for (setting, values) in settings {
        let stated = |command: &String| -> Vec<String> {
            let one = |value: &String| format!("{command} {setting} = {value}");
            values.iter().map(one).collect()
        };
        commands = commands.iter().flat_map(stated).take(LISTED).collect();
    }
    let line = |command: &String| {
        let command = escape::terminal(command);
        format!("  try: {command}{}\n", escape::terminal(&further))
    };
    commands.iter().map(line).collect()
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
