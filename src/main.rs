//! The thin binary: arguments in, exit code out.

use std::process::ExitCode;

/// Has stdout looked at before the standard library opens a closed one to nowhere: an answer that
/// nobody can get must not end with the exit code of one.
#[cfg(target_os = "linux")]
#[expect(
    unsafe_code,
    reason = "nothing else runs before the standard library's own start"
)]
#[used]
#[unsafe(link_section = ".init_array")]
static LOOK: extern "C" fn() = latchgate::cli::look_at_stdout;

fn main() -> ExitCode {
    latchgate::cli::main()
}
