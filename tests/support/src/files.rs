//! Files of other programs, byte by byte.

pub(crate) mod archive;
pub mod mcap;
pub mod tdms;
pub mod workbook;
