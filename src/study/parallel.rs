//! Work shared among threads, with a say in when to stop.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Threads, and whoever watches them.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Threads.
    pub threads: usize,
    /// Told from time to time which part is done, 0 to 1; false stops the work.
    pub proceed: &'a (dyn Fn(f64) -> bool + Sync),
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Control {{ threads: {} }}", self.threads)
    }
}

impl Control<'_> {
    /// Computes `of(0)` to `of(count − 1)` and returns the results in order, whatever the threads;
    /// `None` in place of those that were not begun when the work was stopped.
    pub fn map<T: Send>(&self, count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<Option<T>> {
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let stopped = AtomicBool::new(false);
        let take = || {
            let mut results = Vec::new();
            while !stopped.load(Ordering::Relaxed) {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= count {
                    break;
                }
                results.push((index, of(index)));
                let finished = done.fetch_add(1, Ordering::Relaxed) + 1;
                #[expect(clippy::cast_precision_loss, reason = "counts stay far below 2^53")]
                let part = finished as f64 / count as f64;
                if !(self.proceed)(part) {
                    stopped.store(true, Ordering::Relaxed);
                }
            }
            results
        };
        let threads = self.threads.clamp(1, count.max(1));
        let results = std::thread::scope(|scope| {
            let others: Vec<_> = (1..threads).map(|_| scope.spawn(take)).collect();
            let mut results = take();
            for other in others {
                match other.join() {
                    Ok(more) => results.extend(more),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
            results
        });
        let mut ordered: Vec<Option<T>> = std::iter::repeat_with(|| None).take(count).collect();
        for (index, result) in results {
            ordered[index] = Some(result);
        }
        ordered
    }
}
