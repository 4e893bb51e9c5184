//! What was served, counted: requests by what became of them, and how long each kind took.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Requests by what became of them, and by the time they took.
#[derive(Debug, Default)]
pub struct Traffic {
    /// Answered with what was asked for.
    pub answered: AtomicU64,
    /// Refused.
    pub refused: AtomicU64,
    /// Not answered because of a fault here.
    pub failed: AtomicU64,
    /// Under way.
    pub open: AtomicU64,
    /// Times by kind, as [`KINDS`] names them.
    times: [Times; KINDS.len()],
}

/// Kinds of requests whose times are told apart.
const KINDS: [&str; 7] = [
    "health", "upload", "question", "gate", "events", "read", "page",
];

/// Times up to which requests are counted together [s].
const STEPS: [f64; 7] = [0.005, 0.025, 0.1, 0.5, 2.5, 10.0, 60.0];

#[derive(Debug, Default)]
struct Times {
    /// Requests by [`STEPS`], those that took longer last; each is counted once.
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
    /// Notes how long a request took until its answer began.
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
