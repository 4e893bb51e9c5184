//! How much each may ask: so many requests at once, and so many a second from then on.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Names whose allowance is remembered; beyond them all others share one.
const REMEMBERED: usize = 4096;

/// How much each has asked lately.
#[derive(Debug, Default)]
pub struct Allowances(Mutex<HashMap<String, (f64, Instant)>>);

impl Allowances {
    /// Takes one request out of an allowance; else says after how many seconds to come again.
    ///
    /// # Errors
    ///
    /// The time to wait [s].
    pub fn take(&self, name: &str, per_s: u64, burst: u64) -> Result<(), u32> {
        let (per_s, burst) = (per_s as f64, burst as f64);
        let mut buckets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let since = |last: Instant| now.duration_since(last).as_secs_f64() * per_s;
        if buckets.len() >= REMEMBERED {
            // Whoever has the whole allowance again need not be remembered.
            buckets.retain(|_, (tokens, last)| *tokens + since(*last) < burst);
        }
        let is_one_too_many = buckets.len() >= REMEMBERED && !buckets.contains_key(name);
        let name = if is_one_too_many { "others" } else { name };
        let (tokens, last) = buckets.entry(name.into()).or_insert((burst, now));
        *tokens = (*tokens + since(*last)).min(burst);
        *last = now;
        if *tokens < 1.0 {
            return Err(((1.0 - *tokens) / per_s).ceil().max(1.0) as u32);
        }
        *tokens -= 1.0;
        Ok(())
    }
}
