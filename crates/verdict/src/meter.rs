//! The work of one question: how much its runs have taken, and how much the next may take.
//!
//! Work is counted in steps, not by a clock, so that what is answered does not depend on the
//! machine. Runs side by side get the same part of what is left when they begin, whatever the
//! others take meanwhile: the count is the same on any number of threads.

use latchgate_kernel::parallel::Control;
use latchgate_kernel::replay::Within;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Part of what is left that a single run may take.
const RUN_PART: u64 = 4;

/// Part of what a run of many levers may take that one of them may.
const MEMBER_PART: u64 = 16;

/// The count of one question's work.
#[derive(Debug)]
pub(crate) struct Meter {
    limit: u64,
    spent: AtomicU64,
    each: AtomicU64,
    cut: AtomicBool,
}

impl Meter {
    pub(crate) fn new(limit: u64) -> Self {
        Self {
            limit,
            spent: AtomicU64::new(0),
            each: AtomicU64::new(limit / RUN_PART),
            cut: AtomicBool::new(false),
        }
    }

    /// Gives each of so many runs side by side its part of what is left.
    pub(crate) fn share_out(&self, runs: usize) {
        let each = self.left() / (runs as u64).max(RUN_PART);
        self.each.store(each, Ordering::Relaxed);
    }

    /// Returns what each of the levers may take that advance side by side in one of the runs that
    /// were shared out to.
    pub(crate) fn within_of_members<'a>(&self, control: &'a Control<'a>) -> Within<'a> {
        Within {
            steps_max: self.each.load(Ordering::Relaxed) / MEMBER_PART,
            control,
        }
    }

    /// Returns what one of the runs that were shared out to may take.
    pub(crate) fn within<'a>(&self, control: &'a Control<'a>) -> Within<'a> {
        Within {
            steps_max: self.each.load(Ordering::Relaxed),
            control,
        }
    }

    pub(crate) fn add(&self, steps: u64) {
        self.spent.fetch_add(steps, Ordering::Relaxed);
    }

    /// Returns the steps taken so far.
    pub(crate) fn spent(&self) -> u64 {
        self.spent.load(Ordering::Relaxed)
    }

    /// Returns the steps that may still be taken.
    pub(crate) fn left(&self) -> u64 {
        self.limit.saturating_sub(self.spent())
    }

    /// Tells whether that many steps may still be taken; where they may not, something is left
    /// out.
    pub(super) fn allows(&self, steps: u64) -> bool {
        let allows = steps <= self.left();
        if !allows {
            self.cut();
        }
        allows
    }

    /// Notes that something was left out or broken off.
    pub(crate) fn cut(&self) {
        self.cut.store(true, Ordering::Relaxed);
    }

    /// Returns the limit, if something was left out or broken off for it.
    pub(crate) fn limit_reached(&self) -> Option<u64> {
        self.cut.load(Ordering::Relaxed).then_some(self.limit)
    }
}
