//! The command line as the tests of the service compare it with what is served.

use std::process::ExitCode;

fn main() -> ExitCode {
    latchgate::cli::main()
}
