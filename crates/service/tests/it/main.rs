//! The service as its users meet it: a process, asked over HTTP.
//!
//! Tests that take long are marked `ignored`; `docs/service.md` says what they found.

#![cfg(target_os = "linux")]
#![allow(clippy::disallowed_methods, reason = "tests may")]
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "tests"
)]

mod access;
mod api;
mod damage;
mod gates;
mod hostile;
mod life;
mod operation;
mod pages;
mod proxy;
mod store;
mod strangers;
mod support;
