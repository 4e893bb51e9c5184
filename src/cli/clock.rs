//! The day of a run, which no library asks for.

use latchgate_recording::calendar::day;
use std::time::{SystemTime, UNIX_EPOCH};

/// Returns the present day, UTC, `YYYY-MM-DD`.
pub fn today() -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    day(now.map_or(0, |since| since.as_secs() / 86_400) as i64)
}

/// Returns the day that a document says it was made on: the present one, or that of the variable `SOURCE_DATE_EPOCH`,
/// by which builds that must come out the same state one.
///
/// # Source
///
/// SOURCE_DATE_EPOCH specification, reproducible-builds.org.
pub fn date_of_run() -> String {
    let stated = std::env::var("SOURCE_DATE_EPOCH").ok();
    let seconds = stated.and_then(|text| text.parse::<u64>().ok());
    seconds.map_or_else(today, |seconds| day((seconds / 86_400) as i64))
}
