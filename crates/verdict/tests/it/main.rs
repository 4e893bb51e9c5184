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

mod between;
mod bounds;
mod conditioning;
mod conditioning_cfc;
mod conditioning_quality;
mod conditioning_resample;
mod conditioning_spectrum;
mod in_plane;
mod interpolation;
mod margin;
mod noise_spectrum;
mod processed;
mod reference;
mod response_spectrum;
mod support;
mod verdict;
mod work;
