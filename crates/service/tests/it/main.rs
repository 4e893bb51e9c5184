//! The service as its users meet it: a process, asked over HTTP.
//!
//! No test may fail because the machine is busy. Where a promise is about time, a test counts work,
//! reads processor time or waits for an event; `HANG` only ends a test that would wait for ever.

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
mod turns;
