//! The clock of the wall.

use std::time::{SystemTime, UNIX_EPOCH};

/// Returns the time since 1970 [ms].
pub fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| {
        i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
    })
}
