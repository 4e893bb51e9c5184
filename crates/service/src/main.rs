//! `latchgate-serve`: arguments in, exit code out.

use std::process::ExitCode;

#[cfg(target_os = "linux")]
fn main() -> ExitCode {
    latchgate_service::run::main()
}

/// The jail for hostile recordings (Landlock, seccomp) exists on Linux alone.
#[cfg(not(target_os = "linux"))]
#[expect(clippy::print_stderr, reason = "all that the program says here")]
fn main() -> ExitCode {
    eprintln!(
        "latchgate-serve: the service runs on Linux alone, found {}; \
         `latchgate` itself works here, and a browser here reaches a service on Linux",
        std::env::consts::OS
    );
    ExitCode::from(4)
}
