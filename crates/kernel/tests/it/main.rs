//! Tests of the crate: a module per subject, one binary.

#![allow(missing_docs, reason = "tests are read, not linked")]
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "tests may"
)]

mod batch;
mod catch;
mod coast;
mod double_double;
mod early_end;
mod fan;
mod harmonic;
mod in_plane;
mod oracle;
mod polynomial;
mod pulses;
mod replay;
mod replay_failures;
mod replay_properties;
mod ties;
