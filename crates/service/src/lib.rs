//! The HTTP service of latchgate: recordings in, verdicts kept, judged in jailed children.
//!
//! In reading order: `config` says how it runs, `http` answers requests, `auth` says who
//! may, `allowances` how often, `audit` tells of what they did, `app` is what they share, `store` keeps what was taken in and answered, `gate` judges
//! many of them here, `cluster_gates` on a cluster (`engine` is what was last seen there), `pool` has children
//! read and judge in a `jail`, `problem` words what went wrong, `run` are the commands.

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
pub mod cluster_gates;
pub mod config;
pub mod engine;
pub mod gate;
pub mod http;
pub mod jail;
pub mod pool;
pub mod problem;
pub mod run;
pub mod store;
pub mod traffic;
