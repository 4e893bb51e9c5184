//! Work shared among threads in a fixed order, with a say in when to stop.

use crate::error::Error;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// How a piece of work is carried out: on how many threads, watched by whom. No result depends
/// on it, but for the one of work that was stopped.
///
/// # Examples
///
/// ```
/// use latchgate_kernel::parallel::Control;
///
/// // Stops once half of the work is done.
/// let control = Control {
///     threads: 1,
///     proceed: &|part| part.is_none_or(|part| part < 0.5),
/// };
/// let squares = control.map(4, |n| n * n);
/// assert_eq!(squares, [Some(0), Some(1), None, None]);
/// ```
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Threads, at least one.
    pub threads: usize,
    /// Told from time to time which part is done, 0 to 1, or `None` where that is not known;
    /// false stops the work.
    pub proceed: &'a (dyn Fn(Option<f64>) -> bool + Sync),
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Control {{ threads: {} }}", self.threads)
    }
}

impl Default for Control<'_> {
    fn default() -> Self {
        Self::unwatched(1)
    }
}

impl Control<'_> {
    /// Returns a control that nobody watches and nothing stops.
    pub const fn unwatched(threads: usize) -> Self {
        Self {
            threads,
            proceed: &|_| true,
        }
    }

    /// Asks whether to go on, where it is not known how far the work is.
    ///
    /// # Errors
    ///
    /// [`Error::Stopped`] if it shall stop.
    pub fn check(&self) -> Result<(), Error> {
        if (self.proceed)(None) {
            Ok(())
        } else {
            Err(Error::Stopped)
        }
    }

    /// Returns the same control with another number of threads.
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Does a part of a larger work, from `from` to `to` of it, 0 to 1.
    pub fn during<T>(&self, from: f64, to: f64, work: impl FnOnce(&Control<'_>) -> T) -> T {
        work(&Control {
            threads: self.threads,
            proceed: &|part| (self.proceed)(part.map(|part| from + part * (to - from))),
        })
    }

    /// Does a part of a larger work whose own parts say nothing of the whole.
    pub fn unmeasured<T>(&self, work: impl FnOnce(&Control<'_>) -> T) -> T {
        work(&Control {
            threads: self.threads,
            proceed: &|_| (self.proceed)(None),
        })
    }

    /// Computes `of(0)` to `of(count − 1)` and returns the results in order, whatever the threads;
    /// `None` in place of those that were not begun when the work was stopped.
    pub fn map<T: Send>(&self, count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<Option<T>> {
        let ordered: Mutex<Vec<Option<T>>> =
            Mutex::new(std::iter::repeat_with(|| None).take(count).collect());
        self.each(count, &|index| {
            let result = of(index);
            ordered.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(result);
        });
        ordered.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `work` with 0 to `count` − 1, but for what is not begun when it is stopped. Behind a pointer, as in
    /// [`on_threads`], so that threads are compiled once for all there is to do on them.
    fn each(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let stopped = AtomicBool::new(false);
        on_threads(self.threads.clamp(1, count.max(1)), &|| {
            while !stopped.load(Ordering::Relaxed) {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= count {
                    break;
                }
                work(index);
                let finished = done.fetch_add(1, Ordering::Relaxed) + 1;
                let part = finished as f64 / count as f64;
                if !(self.proceed)(Some(part)) {
                    stopped.store(true, Ordering::Relaxed);
                }
            }
        });
    }

    /// Computes `of` each item and returns the results in the items' order, whatever the threads.
    ///
    /// # Errors
    ///
    /// [`Error::Stopped`] if the work was stopped before the last item was begun; else the
    /// first error of `of`, in the items' order.
    pub fn try_map<T: Sync, R: Send, E: From<Error> + Send>(
        &self,
        items: &[T],
        of: impl Fn(&T) -> Result<R, E> + Sync,
    ) -> Result<Vec<R>, E> {
        self.map(items.len(), |index| of(&items[index]))
            .into_iter()
            .map(|result| result.unwrap_or_else(|| Err(Error::Stopped.into())))
            .collect()
    }
}

/// Calls `work` on each of `threads` threads, the calling one among them.
pub fn on_threads(threads: usize, work: &(dyn Fn() + Sync)) {
    if threads <= 1 {
        return work();
    }
    std::thread::scope(|scope| {
        let further: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        work();
        for thread in further {
            if let Err(panic) = thread.join() {
                std::panic::resume_unwind(panic);
            }
        }
    });
}
