//! Counters of requests: by outcome, and by kind and time.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Counters of requests by outcome, and by kind and time.
#[derive(Debug, Default)]
pub struct Traffic {
    /// Answered as requested.
    pub answered: AtomicU64,
    /// Refused.
    pub refused: AtomicU64,
    /// Failed by a fault of the service.
    pub failed: AtomicU64,
    /// In progress.
    pub open: AtomicU64,
    /// Times by kind, in the order of [`KINDS`].
    times: [Times; KINDS.len()],
}

/// Kinds of requests with separate times.
const KINDS: [&str; 7] = [
    "health", "upload", "question", "gate", "events", "read", "page",
];

/// Upper bounds of the histogram [s].
const STEPS: [f64; 7] = [0.005, 0.025, 0.1, 0.5, 2.5, 10.0, 60.0];

#[derive(Debug, Default)]
struct Times {
    /// Number of requests in each step of [`STEPS`], longer ones last.
    counts: [AtomicU64; STEPS.len() + 1],
    sum_us: AtomicU64,
}

/// Returns the kind of a route.
fn kind_of(method: &str, route: &str) -> &'static str {
    match (method, route) {
        (_, "/healthz" | "/readyz") => "health",
        ("POST", "/v1/recordings") => "upload",
        ("POST", "/v1/verdicts" | "/v1/what-if") => "question",
        ("POST", "/v1/gates") => "gate",
        (_, route) if route.ends_with("/events") => "events",
        (_, route) if route.starts_with("/v1/") => "read",
        _ => "page",
    }
}

impl Traffic {
    /// Counts a request with the time until its answer began.
    pub fn took(&self, method: &str, route: &str, time: Duration) {
        let kind = kind_of(method, route);
        let Some(index) = KINDS.iter().position(|name| *name == kind) else {
            return;
        };
        let times = &self.times[index];
        let seconds = time.as_secs_f64();
        let step = STEPS.iter().position(|seconds_max| seconds <= *seconds_max);
        times.counts[step.unwrap_or(STEPS.len())].fetch_add(1, Ordering::Relaxed);
        let us = u64::try_from(time.as_micros()).unwrap_or(u64::MAX);
        times.sum_us.fetch_add(us, Ordering::Relaxed);
    }

    /// Writes the times as a histogram of Prometheus.
    pub fn histogram(&self, name: &str) -> String {
        let mut text = String::new();
        for (kind, times) in KINDS.iter().zip(&self.times) {
            let mut count = 0;
            let steps = STEPS.iter().map(ToString::to_string);
            for (counter, seconds_max) in times.counts.iter().zip(steps.chain(["+Inf".into()])) {
                count += counter.load(Ordering::Relaxed);
                let _ = writeln!(
                    text,
                    "{name}_bucket{{kind=\"{kind}\",le=\"{seconds_max}\"}} {count}"
                );
            }
            let sum = Duration::from_micros(times.sum_us.load(Ordering::Relaxed)).as_secs_f64();
            let _ = writeln!(text, "{name}_sum{{kind=\"{kind}\"}} {sum}");
            let _ = writeln!(text, "{name}_count{{kind=\"{kind}\"}} {count}");
        }
        text
    }
}
