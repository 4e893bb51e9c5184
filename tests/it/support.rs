//! What tests of several subjects share: the program and its answers, folders, data, recordings
//! and random levers.

mod archive;
mod data;
mod folder;
mod lever;
mod program;
mod random;
mod reading;
mod table;
pub(crate) mod tdms;
pub(crate) mod workbook;

pub(crate) use archive::{gzip_of, tar_of, zip_of};
pub(crate) use data::{columns, data, json, number};
pub(crate) use folder::Folder;
pub(crate) use lever::{
    options, random_design, random_signal, replay, signal, signal_from, unconditioned,
};
pub(crate) use program::{Done, fed, finish, latchgate, program, without_run};
pub(crate) use random::Random;
pub(crate) use reading::{check_at, check_codes, check_refused, one, read_path, with_channel};
pub(crate) use table::{half_sine, signal_file, table, weak};
