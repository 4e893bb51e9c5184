//! What the tests of several crates share: outside truths, folders that vanish, random numbers and
//! levers, tables.

#![allow(missing_docs, reason = "what tests share is read where it is used")]
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::missing_panics_doc,
    clippy::missing_errors_doc,
    clippy::should_implement_trait,
    clippy::new_without_default,
    clippy::must_use_candidate,
    reason = "a test ends where its support does"
)]

mod data;
#[cfg(feature = "files")]
mod files;
mod folder;
mod lever;
mod random;
#[cfg(feature = "reading")]
mod reading;
mod table;

pub use data::{columns, data, json, number, root};
#[cfg(feature = "files")]
pub use files::archive::{gzip_of, tar_of, zip_of};
#[cfg(feature = "files")]
pub use files::{mcap, tdms, workbook};
pub use folder::Folder;
pub use lever::{options, random_design, random_signal, replay, signal, signal_from};
pub use random::Random;
#[cfg(feature = "reading")]
pub use reading::{check_at, check_codes, check_refused, one, read_path, with_channel};
pub use table::{half_sine, signal_file, table, weak};
