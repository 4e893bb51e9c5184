//! The HTTP service of latchgate: recordings in, verdicts kept, judged in jailed children.
//!
//! In reading order: `config` is the configuration, `http` answers requests, `auth` authorises them,
//! `allowances` limits their rate, `supply` shares what is scarce, `turns` says whose turn it is, `audit` logs what people did, `app` is the shared state, `store` keeps recordings
//! and answers, `gate` judges gates, `pool`
//! has children read and judge in a `jail`, `problem` is the form of errors, `run` holds the commands.

#![cfg(target_os = "linux")]
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "a service has clock and environment; no answer depends on the order of its tables"
)]
#![expect(
    clippy::result_large_err,
    reason = "a problem is made once for a request that is refused, and sent"
)]

pub mod allowances;
pub mod app;
pub mod audit;
pub mod auth;
pub mod clock;
pub mod config;
pub mod gate;
pub mod http;
pub mod jail;
pub mod pool;
pub mod problem;
pub mod run;
pub mod store;
pub mod supply;
pub mod traffic;
pub mod turns;
