//! `latchgate serve`: the service, a program of its own, started from here.

use super::args::ServeArguments;
use super::failure::Failure;
use latchgate_recording::error::Error;
use std::path::PathBuf;
use std::process::Command;

/// Name of the service's program.
const PROGRAM: &str = "latchgate-serve";

/// Runs the command; returns the exit code of the service.
pub(super) fn command(own: &ServeArguments) -> Result<u8, Failure> {
    let beside = std::env::current_exe().ok();
    let beside = beside.map(|path| path.with_file_name(PROGRAM).with_extension(extension()));
    let program = beside
        .filter(|path| path.is_file())
        .unwrap_or_else(|| PathBuf::from(PROGRAM));
    let error = run(Command::new(program).args(&own.options));
    match error {
        Ok(code) => Ok(code),
        Err(error) => Err(Failure::Data(Error::io(
            "start the service, latchgate-serve",
            &format!("{error}; start it: cargo run --release -p latchgate-service"),
        ))),
    }
}

fn extension() -> &'static str {
    std::env::consts::EXE_EXTENSION
}

/// Lets the service take this process's place, so that signals reach it.
#[cfg(unix)]
fn run(command: &mut Command) -> std::io::Result<u8> {
    use std::os::unix::process::CommandExt;
    Err(command.exec())
}

/// Waits for the service.
#[cfg(not(unix))]
fn run(command: &mut Command) -> std::io::Result<u8> {
    let code = command.status()?.code();
    Ok(code.and_then(|code| u8::try_from(code).ok()).unwrap_or(4))
}
