//! Rate limits by name: a burst of requests at once, then a number of requests per second.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Largest number of names with an allowance of their own; all others share one.
const REMEMBERED: usize = 4096;

/// Buckets of the requests left, by name.
#[derive(Debug, Default)]
pub struct Allowances(Mutex<HashMap<String, Bucket>>);

#[derive(Debug)]
struct Bucket {
    requests: f64,
    counted: Instant,
}

impl Allowances {
    /// Takes one request out of an allowance.
    ///
    /// # Errors
    ///
    /// The time after which to try again [s].
    pub fn take(&self, name: &str, per_s: u64, burst: u64) -> Result<(), u32> {
        let (per_s, burst) = (per_s as f64, burst as f64);
        let mut buckets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let refilled_to = |bucket: &Bucket| {
            let added = now.duration_since(bucket.counted).as_secs_f64() * per_s;
            bucket.requests + added
        };
        if buckets.len() >= REMEMBERED {
            // A full bucket equals a new one, so it can be dropped.
            buckets.retain(|_, bucket| refilled_to(bucket) < burst);
        }
        let is_one_too_many = buckets.len() >= REMEMBERED && !buckets.contains_key(name);
        let name = if is_one_too_many { "others" } else { name };
        let bucket = buckets.entry(name.into()).or_insert(Bucket {
            requests: burst,
            counted: now,
        });
        bucket.requests = refilled_to(bucket).min(burst);
        bucket.counted = now;
        if bucket.requests < 1.0 {
            return Err(((1.0 - bucket.requests) / per_s).ceil().max(1.0) as u32);
        }
        bucket.requests -= 1.0;
        Ok(())
    }
}
