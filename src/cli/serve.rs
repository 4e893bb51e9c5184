//! `latchgate serve`: starts the service, another program.

use super::args::ServeArguments;
use super::failure::Failure;
use latchgate_recording::error::Error;
use std::path::PathBuf;
use std::process::Command;

/// Name of the service's program.
const PROGRAM: &str = "latchgate-serve";

/// Runs the command; returns the exit code of the service.
pub(super) fn command(arguments: &ServeArguments) -> Result<u8, Failure> {
    let beside = std::env::current_exe().ok().map(|path| {
        path.with_file_name(PROGRAM)
            .with_extension(std::env::consts::EXE_EXTENSION)
    });
    let program = beside
        .filter(|path| path.is_file())
        .unwrap_or_else(|| PathBuf::from(PROGRAM));
    run(Command::new(program).args(&arguments.options)).map_err(|error| {
        Failure::Data(Error::io(
            "start the service, latchgate-serve",
            &format!("{error}; start it: cargo run --release -p latchgate-service"),
        ))
    })
}

/// Replaces this process by the service, so that signals reach it.
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
