//! Tracing output: stderr, as text or JSON lines, off by default.

use super::options::Common;
use super::values::LogFormat;
use latchgate_recording::error::Error;
use std::io::IsTerminal;
use tracing::level_filters::LevelFilter;

/// Starts tracing by `-v` and `--log`.
///
/// # Errors
///
/// [`latchgate_recording::error::ErrorKind::Io`] if tracing was started before in this process.
pub(super) fn start(common: &Common) -> Result<(), Error> {
    let log_level = common.log.map_or(LevelFilter::OFF, |log| log.level);
    let level = match common.verbose {
        0 => log_level,
        1 => log_level.max(LevelFilter::INFO),
        2 => log_level.max(LevelFilter::DEBUG),
        _ => LevelFilter::TRACE,
    };
    if level == LevelFilter::OFF {
        return Ok(());
    }
    let colour = std::io::stderr().is_terminal()
        && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let builder = tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(colour);
    let started = match common.log.map(|log| log.format) {
        Some(LogFormat::Json) => builder.json().flatten_event(true).try_init(),
        Some(LogFormat::Text) | None => builder.try_init(),
    };
    started.map_err(|error| Error::io("start tracing", &error))
}
