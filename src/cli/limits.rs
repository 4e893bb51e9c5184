//! `latchgate limits`: every limit on input, with its value and how to change it.

use super::failure::Failure;
use super::options::Common;
use super::output;
use super::values::OutputFormat;
use latchgate_recording::error::ErrorKind;
use latchgate_recording::limits::Limit;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt::Write as _;

/// The document that `limits --format json` prints.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LimitList {
    /// `latchgate.limits/1`.
    pub schema: Cow<'static, str>,
    /// Every limit, in the order of their table.
    pub limits: Vec<ListedLimit>,
}

/// A limit, and the option that changes it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListedLimit {
    /// The limit.
    #[serde(flatten)]
    pub limit: Limit,
    /// The option that sets its present value.
    pub change: String,
}

/// Runs the command; returns the exit code.
pub(super) fn command(common: &Common) -> Result<u8, Failure> {
    let listing = LimitList {
        schema: "latchgate.limits/1".into(),
        limits: common
            .limits()
            .map_err(Failure::Usage)?
            .entries()
            .into_iter()
            .map(|limit| ListedLimit {
                change: format!("--limit {}={}", limit.name, limit.value),
                limit,
            })
            .collect(),
    };
    match common.format {
        OutputFormat::Json => {
            let mut text = serde_json::to_string_pretty(&listing).map_err(|error| {
                Failure::Data(
                    ErrorKind::Io {
                        action: "write the limits",
                        reason: error.to_string(),
                    }
                    .into(),
                )
            })?;
            text.push('\n');
            output::document(&text)
        }
        OutputFormat::Text => output::text(&table(&listing)),
    }
    .map_err(Failure::Data)?;
    Ok(0)
}

fn table(listing: &LimitList) -> String {
    let entries = &listing.limits;
    let widest = |width: &dyn Fn(&Limit) -> usize| {
        let widths = entries.iter().map(|entry| width(&entry.limit));
        widths.max().unwrap_or(0)
    };
    let names = widest(&|limit| limit.name.len());
    let values = widest(&|limit| limit.value.to_string().len());
    let units = widest(&|limit| limit.unit.len());
    let mut text = String::new();
    for ListedLimit { limit, .. } in entries {
        let changed = if limit.value == limit.default {
            String::new()
        } else {
            format!(" (default {})", limit.default)
        };
        let _ = writeln!(
            text,
            "{:names$}  {:>values$}  {:units$}  {}{changed}",
            limit.name, limit.value, limit.unit, limit.meaning
        );
    }
    text.push_str(
        "\nChange one with --limit KEY=VALUE, for example --limit text_bytes=512MiB. Every command \
         takes the option, more than once. Higher limits cost memory.\n",
    );
    text
}
