//! A bounded supply that owners share without fixed parts.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A bounded supply. An owner may hold at most as much as is still free: the first that takes all it can has half of
/// it, the next one half of the rest, and whoever comes after them finds some.
#[derive(Debug)]
pub struct Supply {
    total: u64,
    taken: Mutex<Taken>,
}

#[derive(Debug, Default)]
struct Taken {
    sum: u64,
    by_owner: HashMap<String, u64>,
}

impl Supply {
    /// Returns a supply of which nothing is taken.
    pub fn new(total: u64) -> Arc<Self> {
        Arc::new(Self {
            total,
            taken: Mutex::default(),
        })
    }

    /// Returns what an owner holds for one purpose, nothing yet.
    pub fn open(self: &Arc<Self>, owner: &str) -> Held {
        Held {
            supply: Arc::clone(self),
            owner: owner.into(),
            amount: 0,
        }
    }
}

/// A part of a supply, free again when it is dropped.
#[derive(Debug)]
pub struct Held {
    supply: Arc<Supply>,
    owner: String,
    amount: u64,
}

impl Held {
    /// Takes more; returns false, and takes nothing, if the owner would then hold more than is free.
    #[must_use]
    pub fn grow(&mut self, amount: u64) -> bool {
        let mut taken = locked(&self.supply.taken);
        let own = taken.by_owner.get(&self.owner).copied().unwrap_or(0) + amount;
        let sum = taken.sum + amount;
        if own.saturating_add(sum) > self.supply.total {
            return false;
        }
        taken.sum = sum;
        taken.by_owner.insert(self.owner.clone(), own);
        self.amount += amount;
        true
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        let mut taken = locked(&self.supply.taken);
        taken.sum -= self.amount;
        if let Some(own) = taken.by_owner.get_mut(&self.owner) {
            *own -= self.amount;
            if *own == 0 {
                taken.by_owner.remove(&self.owner);
            }
        }
    }
}

fn locked(taken: &Mutex<Taken>) -> MutexGuard<'_, Taken> {
    taken.lock().unwrap_or_else(PoisonError::into_inner)
}
