//! The only place that prints.

use super::options::Common;
use super::values::ColorArgument;
use latchgate_recording::error::{Error, Place};
use latchgate_recording::setting::Setting;
use latchgate_report::escape;
use latchgate_report::terminal::{Look, PIPED};
use latchgate_verdict::TOGETHER;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest number of columns: longer lines are hard to read.
const WIDEST: usize = 120;

/// True if stdout was closed when the process began.
static STDOUT_IS_CLOSED: AtomicBool = AtomicBool::new(false);

/// Notes if stdout is closed. It must run before `main`: there the standard library has already
/// opened a closed stdout to `/dev/null`, and an answer would vanish without an error.
pub extern "C" fn look_at_stdout() {
    let is_open = Path::new("/proc/self/fd/1").symlink_metadata().is_ok();
    // Without /proc this cannot be known, and stdout counts as open.
    let has_proc = Path::new("/proc/self/fd").is_dir();
    STDOUT_IS_CLOSED.store(has_proc && !is_open, Ordering::Relaxed);
}

/// Writes the settings of a message as options: ``the setting `filter` = none`` becomes
/// `--filter none`.
pub(super) fn with_options(text: &str) -> String {
    with_options_but(text, &[])
}

/// As [`with_options`], except for the settings of these keys: in a gate they are keys of its file.
pub(super) fn with_options_but(text: &str, keys: &[&str]) -> String {
    let mut text = text.to_string();
    // Most texts name no setting, and an answer may be long.
    if text.contains("the setting `") {
        let options = Setting::ALL.iter();
        for setting in options.filter(|setting| !keys.contains(&setting.key())) {
            let named = setting.to_string();
            let option = match setting {
                // The option takes one remark, the setting a list.
                Setting::AcceptedRemarks => "--accept-remark".into(),
                _ => format!("--{}", setting.key().replace('_', "-")),
            };
            text = text
                .replace(&format!("{named} = "), &format!("{option} "))
                .replace(&named, &option);
        }
    }
    // Options that answer one question together are one command line.
    if let Some((before, line)) = text.split_once(TOGETHER) {
        let (line, after) = line.split_once(". ").unwrap_or((line, ""));
        let line = line.replace(", --", " --");
        let stop = if after.is_empty() { "" } else { ". " };
        text = format!("{before}{TOGETHER}{line}{stop}{after}");
    }
    text
}

/// Returns the layout of an answer for the stdout of this process.
pub(super) fn look(common: &Common) -> Look {
    let terminal = io::stdout().is_terminal();
    let width =
        terminal_size::terminal_size_of(io::stdout()).map(|(width, _)| usize::from(width.0));
    let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let dumb = std::env::var_os("TERM").is_some_and(|name| name == "dumb");
    Look {
        width: Some(
            width
                .filter(|_| terminal)
                .map_or(PIPED, |width| width.min(WIDEST)),
        ),
        colour: match common.color {
            ColorArgument::Always => true,
            ColorArgument::Never => false,
            ColorArgument::Auto => terminal && !no_color && !dumb,
        },
        links: terminal && !dumb,
        detail: common.verbose > 0,
        worded: with_options,
    }
}

/// Opens a file with the desktop's program for it.
pub(super) fn open(path: &Path) {
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let begun = Command::new(opener)
        .arg(path)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    if let Err(error) = begun {
        talk(&format!(
            "latchgate: {}: cannot be opened with {opener}: {error}",
            path.display()
        ));
    }
}

/// Writes an answer for people to stdout, with settings as options.
///
/// # Errors
///
/// As [`document`].
pub(super) fn text(text: &str) -> Result<(), Error> {
    document(&with_options(text))
}

/// Writes a document to stdout as it is. A closed pipe is no error: `| head` reads what it needs.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if the data could not be written for another reason, for example
/// a full disk: the exit code must not state an answer that was lost.
pub(super) fn document(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    let open = if STDOUT_IS_CLOSED.load(Ordering::Relaxed) {
        Err(io::Error::other("stdout is closed"))
    } else {
        Ok(())
    };
    let written = open.and_then(|()| out.write_all(text.as_bytes()));
    match written.and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::io("write the answer", &error).at(Place::file("stdout")))
        }
        _ => Ok(()),
    }
}

/// Writes a message to stderr, with settings as options.
pub(super) fn talk(text: &str) {
    talk_plainly(&with_options(text));
}

/// Writes a message to stderr, with settings as they are. It may hold names and cells of files, so
/// control characters are escaped.
pub(super) fn talk_plainly(text: &str) {
    let mut err = io::stderr().lock();
    for line in text.split('\n') {
        let _ = writeln!(err, "{}", escape::terminal(line));
    }
}

#[cfg(test)]
mod tests {
    use super::with_options;

    #[test]
    fn verif_settings_become_options_and_sentences_keep_their_full_stops() {
        for (text, expected) in [
            (
                "by a replay with the setting `set`.",
                "by a replay with --set.",
            ),
            (
                "state the setting `time_unit` = s|ms|us|ns.",
                "state --time-unit s|ms|us|ns.",
            ),
            (
                "state the setting `unit`, or the setting `rate_hz`.",
                "state --unit, or --rate-hz.",
            ),
            ("no setting at all.", "no setting at all."),
        ] {
            assert_eq!(with_options(text), expected);
        }
    }
}
