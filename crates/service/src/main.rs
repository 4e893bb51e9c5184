//! `latchgate-serve`: arguments in, exit code out.

use std::process::ExitCode;

fn main() -> ExitCode {
    latchgate_service::run::main()
}
