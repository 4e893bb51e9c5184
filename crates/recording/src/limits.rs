//! Limits on input: what a reader refuses to take in, so that memory stays bounded.
//!
//! One table lists them with unit and meaning, which `latchgate limits` prints. An assignment `KEY=VALUE`
//! changes an entry.

use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A limit with its present value.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limit {
    /// Name, as messages and assignments use it.
    pub name: Cow<'static, str>,
    /// Its value.
    pub value: u64,
    /// The value unless changed.
    pub default: u64,
    /// Unit of the value, for example `bytes`.
    pub unit: Cow<'static, str>,
    /// Meaning of the limit.
    pub meaning: Cow<'static, str>,
}

macro_rules! limits {
    ($($name:ident = $value:expr, $unit:literal, $meaning:literal;)*) => {
        /// Limits on input; crossing one is an error that names it.
        #[derive(Debug, Clone, PartialEq, Eq)]
        pub struct Limits {
            $(#[doc = $meaning] pub $name: u64,)*
        }

        impl Default for Limits {
            fn default() -> Self {
                Self { $($name: $value,)* }
            }
        }

        impl Limits {
            /// Names of all limits, in the order of the table.
            pub const NAMES: &[&str] = &[$(stringify!($name)),*];

            /// Returns every limit with its value.
            pub fn entries(&self) -> Vec<Limit> {
                vec![$(Limit {
                    name: stringify!($name).into(),
                    value: self.$name,
                    default: $value,
                    unit: $unit.into(),
                    meaning: $meaning.into(),
                }),*]
            }

            /// Returns the limits that differ from their defaults, by name.
            pub fn changed(&self) -> BTreeMap<String, u64> {
                self.entries()
                    .into_iter()
                    .filter(|limit| limit.value != limit.default)
                    .map(|limit| (limit.name.to_string(), limit.value))
                    .collect()
            }

            /// Returns the error of the crossed limit of that name.
            pub(super) fn over(&self, limit: &'static str, found: impl Into<String>) -> Error {
                let value = match limit {
                    $(stringify!($name) => self.$name,)*
                    _ => 0,
                };
                Error::over(limit, value, found)
            }

            fn slot(&mut self, name: &str) -> Option<&mut u64> {
                match name {
                    $(stringify!($name) => Some(&mut self.$name),)*
                    _ => None,
                }
            }
        }
    };
}

limits! {
    text_bytes = 192 << 20, "bytes", "Bytes of a text recording in memory, plus its decoded text \
                                      unless UTF-8; of a sheet as text and of a part of a workbook; of standard input that is read twice.";
    line_bytes = 1 << 20, "bytes", "Bytes of one line of text.";
    lines = 8_200_000, "lines", "Lines of a text recording, headers and comments included; rows of a sheet.";
    samples = 8_000_000, "samples", "Samples kept per channel.";
    columns = 4096, "columns", "Columns of a table: channels of a text file; channels and groups of a TDMS file.";
    table_cells = 48_000_000, "cells", "Cells of a table kept as numbers when every channel is read.";
    settings_bytes = 1 << 20, "bytes", "Bytes of a card, design or gate file.";
    archive_bytes = 64 << 20, "bytes", "Bytes of an archive (.zip, .tar.gz, .tar) or a workbook in memory.";
    archive_entries = 20_000, "entries", "Entries of an archive, files of a folder, or channels of a test header.";
    unpacked_bytes = 192 << 20, "bytes", "Bytes of all files of a test in an archive, or of the parts of a workbook, after \
                                          decompression.";
    unpacked_stream_bytes = 1 << 30, "bytes", "Bytes of an archive's stream after decompression, \
                                               skipped ones included.";
    unpacked_ratio = 200, "bytes per byte", "Ratio of bytes after decompression to bytes before it, past the first 4 MiB.";
    header_bytes = 64 << 10, "bytes", "Bytes of the header of an ISO-MME channel file.";
    headers_bytes = 8 << 20, "bytes", "Bytes of all headers of an ISO-MME test, plus 64 a line; of \
                                       its test header; of its list of channels; of the metadata and of the properties \
                                       of a TDMS file.";
    test_samples = 16_000_000, "samples", "Samples kept of all channels of an ISO-MME test or a TDMS file when every channel is read.";
    mcap_record_bytes = 64 << 20, "bytes", "Bytes of one MCAP record, a chunk included; of all schemas together.";
    mcap_chunk_bytes = 64 << 20, "bytes", "Bytes of one MCAP chunk after decompression.";
    mcap_string_bytes = 16 << 20, "bytes", "Bytes of one string in an MCAP record or message.";
    mcap_fields = 1 << 20, "fields", "Fields of all message types of an MCAP file, nested ones \
                                      included.";
    mcap_channels = 4096, "topics", "Topics of an MCAP file.";
    work = 100_000_000, "steps", "Steps of all runs of one question; four levers side by side \
                                  count as one.";
}

impl Limits {
    /// Changes the limit that `KEY=VALUE` names. The value is a positive whole number; one of
    /// bytes may end in `KiB`, `MiB` or `GiB`.
    ///
    /// # Errors
    ///
    /// [`crate::error::ErrorKind::UnknownName`] for a key that is no limit,
    /// [`OutOfRange`](latchgate_kernel::error::Error::OutOfRange) for a value that is no positive whole number below
    /// 2⁶³.
    pub fn set(&mut self, assignment: &str) -> Result<(), Error> {
        let (name, text) = assignment.split_once('=').unwrap_or((assignment, ""));
        let (name, text) = (name.trim(), text.trim());
        let Some(slot) = self.slot(name) else {
            return Err(Error::unknown("limit", name, Self::NAMES));
        };
        *slot = value(name, text).ok_or_else(|| {
            let bytes = match name.ends_with("_bytes") {
                true => "; KiB, MiB and GiB may follow it",
                false => "",
            };
            Error::out_of_range(
                format!("the limit {name}"),
                format!("a whole number from 1 on, as in {name}=1000000{bytes}"),
                format!("`{text}`"),
            )
        })?;
        Ok(())
    }
}

fn value(name: &str, text: &str) -> Option<u64> {
    let (digits, shift) = [("KiB", 10), ("MiB", 20), ("GiB", 30)]
        .into_iter()
        .filter(|_| name.ends_with("_bytes"))
        .find_map(|(suffix, shift)| Some((text.strip_suffix(suffix)?.trim_end(), shift)))
        .unwrap_or((text, 0));
    if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let value = digits.parse::<u64>().ok()?.checked_mul(1 << shift)?;
    (1..1 << 63).contains(&value).then_some(value)
}
