//! One integration-test binary; a module per subject.

#![allow(missing_docs, reason = "tests are read, not linked")]
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "tests may"
)]

mod report;
